"""Where the roles of a study set the adjustments of its environment, and which they may set."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from workbench.errors import one_of
from workbench.files.study.schema import PositionFile, RoleFile
from workbench.files.study.work import Key, Work
from workbench.model.environment import Adjustment, Environment

__all__ = ["SeatedRole", "adjusts_of", "setting_faults", "stated_settings"]


@dataclass(frozen=True)
class _Stated:
    """A setting that a role states: of which adjustment, where [m or rad; NaN where it is no angle],
    and the key at which it stands."""

    name: str
    value: float
    key: Key


def _stated(name: str, file: RoleFile, room: Environment) -> Iterator[_Stated]:
    """The settings that a role states of adjustments that are there."""
    known = {one.name: one for one in room.adjustments}
    for adjustment, given in file.adjust.items():
        if adjustment in known:
            value = given[0] if known[adjustment].turns else given[1]
            yield _Stated(adjustment, value, ("people", name, "adjust", adjustment))
    if isinstance(file.position, PositionFile) and file.position.tilt:
        for one in room.adjustments:
            if one.tilts and one.tilts == file.seat:
                key = ("people", name, "position", "tilt")
                yield _Stated(one.name, math.radians(file.position.tilt), key)


def stated_settings(files: Mapping[str, RoleFile], room: Environment) -> dict[str, float]:
    """Where the roles of a study set adjustments [m or rad], by their names."""
    return {
        one.name: one.value for name, file in files.items() for one in _stated(name, file, room)
    }


def setting_faults(work: Work, files: Mapping[str, RoleFile], room: Environment) -> None:
    """Report settings of adjustments that are not there, belong to another seat, lie beyond their
    travel, or are stated twice."""
    taken: dict[str, str] = {}
    known = {one.name: one for one in room.adjustments}
    for name, file in files.items():
        for adjustment in file.adjust:
            if adjustment not in known:
                what = f"environment {room.name} has no adjustment {adjustment!r}"
                key = ("people", name, "adjust", adjustment)
                work.fault(key, f"{what}; {one_of(adjustment, known)}")
        _tilt_fault(work, name, file, room)
        for stated in _stated(name, file, room):
            before = taken.setdefault(stated.name, name)
            twice = before != name or (stated.key[2] == "position" and stated.name in file.adjust)
            if twice:
                work.fault(stated.key, f"{before!r} sets {stated.name!r} already; state it once")
            elif what := _wrong(known[stated.name], stated.value, file.seat):
                work.fault(stated.key, what)


def _tilt_fault(work: Work, name: str, file: RoleFile, room: Environment) -> None:
    """Report the tilt of a seat that cannot be tilted."""
    if not isinstance(file.position, PositionFile) or not file.position.tilt:
        return
    seats = {seat.name for seat in room.seats}
    if file.seat in seats and file.seat not in {one.tilts for one in room.adjustments}:
        what = (
            f"seat {file.seat!r} cannot be tilted; its environment says how far it can be by "
            "'travel: {tilt: [-5, 5]}'"
        )
        work.fault(("people", name, "position", "tilt"), what)


def _wrong(one: Adjustment, value: float, seat: str | None) -> str:
    """What is wrong with the setting of an adjustment from a seat, "" where nothing is."""
    if one.seat and one.seat != seat:
        return f"{one.name!r} is set from seat {one.seat!r}"
    if math.isnan(value):
        return f"{one.name!r} turns: a number of degrees is needed"
    scale, unit = (math.degrees(1), "degrees") if one.turns else (1000.0, "mm")
    low, high = one.travel
    if low - 1e-9 <= value <= high + 1e-9:
        return ""
    travel = f"{scale * low:g} to {scale * high:g} {unit}"
    return f"beyond the travel of {one.name}, {travel} (got {scale * value:g} {unit})"


@dataclass(frozen=True)
class SeatedRole:
    """A role that acts on controls from a seat. free: whether its seat is; driver: whether a case
    predicts a driver's posture, which no tilt of the seat changes."""

    role: str
    seat: str
    free: bool
    driver: bool


def adjusts_of(
    sitters: Sequence[SeatedRole], room: Environment, stated: Mapping[str, float]
) -> dict[str, tuple[str, ...]]:
    """The adjustments that each role may set, by the name of the role.

    What a study states stays so. An adjustment without a seat is set by the first who acts on
    controls.

    Parameters
    ----------
    sitters
        In the order in which they take their seats.
    stated
        The settings that the study states.
    """
    found = {}
    taken = set(stated)
    for sitter in sitters:
        own = [
            one
            for one in room.adjustments
            if one.seat in ("", sitter.seat) and one.name not in taken
        ]
        taken |= {one.name for one in own}
        found[sitter.role] = tuple(
            one.name for one in own if sitter.free and not (one.tilts and sitter.driver)
        )
    return found
