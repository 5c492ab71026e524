"""The adjustments of `environment.yaml`: what is wrong with them, and the nouns made from them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from workbench.errors import one_of
from workbench.files.environment_parts import matching_parts
from workbench.files.environment_schema import AdjustmentFile, EnvironmentFile
from workbench.files.schema import fail
from workbench.files.yaml_text import Document
from workbench.model.adjusting import seat_tilt
from workbench.model.environment import Adjustment, Seat

__all__ = ["MOST_ADJUSTMENTS", "adjustment_faults", "adjustments_of"]

MOST_ADJUSTMENTS = 4
"""Adjustments that the occupant of one seat may make, its tilt with them: settings are tried in
combination, and four have 81 with three settings each."""
Key = tuple[str | int, ...]


def adjustment_faults(document: Document, file: EnvironmentFile, names: Sequence[str]) -> list[str]:
    """A line for each thing that is wrong with the adjustments of a file.

    names: the parts of the meshes.
    """
    every = (
        *_unknown(file, names),
        *_mounted_on_themselves(file),
        *_without_parts(file),
        *_moved_twice(file, names),
        *_tilts_named(file),
        *_too_many(file),
    )
    return [fail(document, key, what) for key, what in every]


def _unknown(file: EnvironmentFile, names: Sequence[str]) -> Iterator[tuple[Key, str]]:
    """Parts, points, seats and adjustments that are named and not there."""
    for name, one in file.adjustments.items():
        for k, part in enumerate(one.parts):
            if not matching_parts(part, names):
                key: Key = ("adjustments", name, "parts", k)
                yield key, f"no part {part!r}; {one_of(part, names)}"
        for k, point in enumerate(one.points):
            if point not in file.points:
                key = ("adjustments", name, "points", k)
                yield key, f"no point {point!r}; {one_of(point, file.points)}"
        for what, given, valid in (
            ("adjustment", one.mounted_on, file.adjustments),
            ("seat", one.seat, file.seats),
        ):
            if given is not None and given not in valid:
                key = ("adjustments", name, "seat" if what == "seat" else "mounted_on")
                yield key, f"no {what} {given!r}; {one_of(given, valid)}"


def _mounted_on_themselves(file: EnvironmentFile) -> Iterator[tuple[Key, str]]:
    """Adjustments that carry themselves."""
    for name, one in file.adjustments.items():
        seen = {name}
        carrier = one.mounted_on
        while carrier is not None and carrier in file.adjustments and carrier not in seen:
            seen.add(carrier)
            carrier = file.adjustments[carrier].mounted_on
        if carrier == name:
            what = "it is mounted on itself; name the adjustment that carries it, or leave it out"
            yield ("adjustments", name, "mounted_on"), what


def _without_parts(file: EnvironmentFile) -> Iterator[tuple[Key, str]]:
    """Adjustments that move nothing."""
    carriers = {one.mounted_on for one in file.adjustments.values()}
    for name, one in file.adjustments.items():
        if not (one.parts or one.points or name in carriers):
            yield ("adjustments", name), "it moves nothing: name the 'parts' that it moves"


def _moved_twice(file: EnvironmentFile, names: Sequence[str]) -> Iterator[tuple[Key, str]]:
    """Parts and points that something else moves already."""
    movers: dict[str, str] = {}
    for seat, stated in file.seats.items():
        for key in (stated.cushion.part, stated.back.part, *stated.moves):
            movers |= dict.fromkeys(matching_parts(key, names), f"seat {seat!r}")
    placers: dict[str, str] = {}
    for name, one in file.adjustments.items():
        advice = "; list it once, and say 'mounted_on' where one adjustment carries another"
        for k, key in enumerate(one.parts):
            for part in matching_parts(key, names):
                other = movers.setdefault(part, f"adjustment {name!r}")
                if other != f"adjustment {name!r}":
                    what = f"part {part!r} is moved by {other} already{advice}"
                    yield ("adjustments", name, "parts", k), what
        for k, point in enumerate(one.points):
            other = placers.setdefault(point, f"adjustment {name!r}")
            if other != f"adjustment {name!r}":
                what = f"point {point!r} is moved by {other} already{advice}"
                yield ("adjustments", name, "points", k), what


def _tilts_named(file: EnvironmentFile) -> Iterator[tuple[Key, str]]:
    """Adjustments with the name that the tilt of a seat has."""
    tilts = {f"{seat}_tilt": seat for seat, stated in file.seats.items() if any(stated.travel.tilt)}
    for name in file.adjustments:
        if name in tilts:
            what = f"the tilt of seat {tilts[name]!r} has this name; take another"
            yield ("adjustments", name), what


def _too_many(file: EnvironmentFile) -> Iterator[tuple[Key, str]]:
    """More adjustments than are tried in combination."""
    for seat, stated in file.seats.items():
        own = [name for name, one in file.adjustments.items() if one.seat in (None, seat)]
        count = len(own) + any(stated.travel.tilt)
        if count > MOST_ADJUSTMENTS:
            what = (
                f"the occupant of seat {seat!r} has {count} adjustments, and their settings are "
                f"tried in combination; {MOST_ADJUSTMENTS} are possible, the seat's tilt with them "
                f"('seat' says whose an adjustment is)"
            )
            yield ("adjustments",), what
            return


def adjustments_of(
    file: EnvironmentFile, seats: Sequence[Seat], names: Sequence[str]
) -> tuple[Adjustment, ...]:
    """The adjustments of a file without faults, then the tilts of its seats.

    names: the parts of the meshes.
    """
    stated = [_adjustment(name, one, names) for name, one in file.adjustments.items()]
    tilts = [
        seat_tilt(seat, file.seats[seat.name].travel.tilt)
        for seat in seats
        if any(file.seats[seat.name].travel.tilt)
    ]
    return (*stated, *tilts)


def _adjustment(name: str, file: AdjustmentFile, names: Sequence[str]) -> Adjustment:
    axis = file.along if file.about is None else file.about.axis
    assert axis is not None
    return Adjustment(
        name=name,
        axis=axis,
        pivot=None if file.about is None else file.about.point,
        travel=file.travel,
        parts=tuple(dict.fromkeys(p for key in file.parts for p in matching_parts(key, names))),
        points=tuple(dict.fromkeys(file.points)),
        mounted_on=file.mounted_on or "",
        seat=file.seat or "",
    )
