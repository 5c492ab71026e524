"""Edits of an open study: each takes a state and returns another one, and says in words what it did.

Angles are set to 0.1 degrees and lengths to 0.1 mm, so that a state is exactly what its file says
once it is saved. An edit within this of what stands changes nothing. Here are seats, parts and
cases; `edits_joints`, `edits_people` and `edits_postures` have the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.environment import Adjustment
from workbench.model.surroundings import Move
from workbench.model.units import plain
from workbench.study.bench.placing import Placement
from workbench.study.bench.state import Arrangement, OpenStudy, PersonState

__all__ = [
    "FARTHEST",
    "LENGTH_STEP",
    "Edit",
    "adjusted_to",
    "adjuster_of",
    "held_seat",
    "looking_at",
    "rounded",
    "seated",
    "shifted",
]

LENGTH_STEP = 1e-4
"""[m]"""
FARTHEST = 10.0
"""[m] Targets are no farther than this from the world's origin."""


@dataclass(frozen=True, eq=False)
class Edit:
    """What an edit came to: the state, and in words what it did, "" where that is plain to see."""

    arrangement: Arrangement
    words: str = ""


def held_seat(placement: Placement, row: int) -> PersonState:
    """A person whose seat is held where it stands; as before without a seat."""
    person = placement.arrangement.people[row]
    there = placement.people[row]
    sits = there.resting is None or there.resting.place.seat is not None
    if not person.free or not sits:
        return person
    forward = rounded(there.forward, LENGTH_STEP)
    up = rounded(there.up, LENGTH_STEP)
    return replace(person, free=False, forward=forward, up=up)


def seated(
    opened: OpenStudy, arrangement: Arrangement, person: str, forward: float, up: float
) -> Edit:
    """Put a person's seat into a position within its travel.

    Parameters
    ----------
    forward, up
        [m] from where the seat stands at rest.

    Raises
    ------
    InputError
        If the person is not there or has no seat, or the position is beyond its travel.
    """
    row = arrangement.row(person)
    seat = opened.seat(row)
    if seat is None:
        raise InputError(f"{person} is in no seat")
    state = arrangement.people[row]
    values = []
    for way, given, (low, high) in (
        ("forward", forward, seat.travel_forward),
        ("up", up, seat.travel_up),
    ):
        if not low - 1e-9 <= given <= high + 1e-9:
            travel = f"{1000 * low:g} to {1000 * high:g} mm"
            raise InputError(
                f"{way}: the travel of seat {seat.name} is {travel}, got {1000 * given:g} mm"
            )
        values.append(min(max(rounded(given, LENGTH_STEP), low), high))
    same = np.abs(np.array(values) - (state.forward, state.up)).max() < LENGTH_STEP / 2
    if same and not state.free:
        return Edit(arrangement)
    after = replace(state, free=False, forward=values[0], up=values[1])
    return Edit(arrangement.with_person(row, after))


def shifted(opened: OpenStudy, arrangement: Arrangement, wanted: Move) -> Edit:
    """Put parts, with the controls on them, or controls alone, elsewhere.

    Parameters
    ----------
    wanted
        By how much from where the environment's file has them, in all: what else was said of them
        is forgotten.

    Returns
    -------
    Edit
        The words name the controls that go along.

    Raises
    ------
    InputError
        If nothing is named, a part or control is not there or goes with a seat, or the move is too
        far.
    """
    environment = opened.study.environment
    if bool(wanted.parts) == bool(wanted.controls):
        raise InputError("parts or controls must be named, one of the two")
    controls = [control.name for control in environment.controls]
    for name in wanted.controls:
        if name not in controls:
            raise InputError(f"no control {name!r}; {one_of(name, controls)}")
    riding = {name: seat.name for seat in environment.seats for name in seat.moves}
    for name in wanted.parts:
        environment.part_index(name)
        if name in riding:
            raise InputError(f"{name} goes with seat {riding[name]}: move the seat instead")
    if not max(map(abs, wanted.by)) <= FARTHEST:
        raise InputError(f"a move of up to {FARTHEST:g} m is possible")
    x, y, z = (rounded(value, LENGTH_STEP) for value in wanted.by)
    moves = _with_move(arrangement.moves, replace(wanted, by=(x, y, z)))
    along = [control.name for control in environment.controls if control.part in wanted.parts]
    words = f"{', '.join(along)} goes along" if len(along) == 1 else f"{', '.join(along)} go along"
    if not along or not any(wanted.by):
        words = ""
    if moves == arrangement.moves:
        return Edit(arrangement, words)
    return Edit(replace(arrangement, moves=moves), words)


def _with_move(moves: Sequence[Move], wanted: Move) -> tuple[Move, ...]:
    """The moves of a state with one in the place of what it said of the same parts or controls."""
    found = []
    told = not any(wanted.by)
    for move in moves:
        if (move.parts, move.controls) == (wanted.parts, wanted.controls):
            if not told:
                found.append(wanted)
                told = True
            continue
        left = replace(
            move,
            parts=tuple(name for name in move.parts if name not in wanted.parts),
            controls=tuple(name for name in move.controls if name not in wanted.controls),
        )
        if left.parts or left.controls:
            found.append(left)
    return tuple(found) if told else (*found, wanted)


def adjusted_to(opened: OpenStudy, arrangement: Arrangement, name: str, value: float) -> Edit:
    """Set an adjustment of the environment, to 0.1 mm or 0.1 degrees.

    Parameters
    ----------
    value
        [m] of a slide, [rad] of a turn, from its nominal setting.

    Raises
    ------
    InputError
        If there is no such adjustment, nobody sits where it is set from, or the value is beyond its
        travel.
    """
    one = opened.study.environment.adjustment(name)
    if not adjuster_of(opened, one):
        where = f"seat {one.seat}" if one.seat else "a seat"
        raise InputError(f"{name} is set by who is in {where}: nobody is")
    scale, unit = (float(np.degrees(1.0)), "degrees") if one.turns else (1e3, "mm")
    low, high = one.travel
    if not low - 1e-9 <= value <= high + 1e-9:
        travel = f"{scale * low:g} to {scale * high:g} {unit}"
        raise InputError(f"{name}: its travel is {travel}, got {scale * value:g} {unit}")
    tenths = min(max(rounded(scale * value, 0.1), scale * low), scale * high)
    settings = dict(arrangement.settings)
    if name in settings and abs(scale * settings[name] - tenths) < 0.05:
        return Edit(arrangement)
    settings[name] = tenths / scale
    after = replace(arrangement, settings=tuple(sorted(settings.items())))
    return Edit(after, f"{plain(name)} at {tenths:g} {unit}".replace("-", "−"))


def adjuster_of(opened: OpenStudy, one: Adjustment) -> str:
    """The role in whose entry of the file an adjustment is set: the first in its seat, or in any
    where it has none; "" where nobody is."""
    found = [role.name for role in opened.study.roles if role.seat and one.seat in ("", role.seat)]
    return found[0] if found else ""


def looking_at(opened: OpenStudy, arrangement: Arrangement, case: str) -> Edit:
    """Look at another case. InputError where it is not there."""
    if case not in opened.cases:
        raise InputError(f"no case {case!r}; {one_of(case, opened.cases)}")
    return Edit(replace(arrangement, case=opened.cases.index(case)))


def rounded(value: float, step: float) -> float:
    """The multiple of a step that is nearest to a value."""
    return round(value / step) * step
