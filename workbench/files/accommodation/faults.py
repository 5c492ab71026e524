"""What is wrong with an accommodation study beyond its form: names of nothing, contradictions,
seats that do not move.

Faults are told with the line they stand in, all of them at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase

from workbench.errors import one_of
from workbench.files.accommodation.schema import AccommodationFile, DemandFile
from workbench.files.postures import PosturesFile
from workbench.files.schema import fail
from workbench.files.yaml_text import Document
from workbench.model.body import Body, segment_words
from workbench.model.environment import Environment

__all__ = ["plan_faults", "subparts_of"]

Loaded = tuple[Environment | None, Body | None, PosturesFile | None]
Key = tuple[str | int, ...]


def plan_faults(document: Document, file: AccommodationFile, loaded: Loaded) -> list[str]:
    """A line for every fault; what could not be loaded is not asked about."""
    environment, body, postures = loaded
    faults = [fail(document, key, what) for key, what in _criteria(file, loaded)]
    if body is not None and postures is not None:
        faults += [fail(document, key, what) for key, what in _body_faults(file, body, postures)]
    if environment is not None:
        for key, what in (
            *_seat(file, environment),
            *_aims(file, environment),
            *_changes(file, environment),
        ):
            faults.append(fail(document, key, what))
    return faults


def subparts_of(body: Body) -> list[str]:
    """The named spheres of a body, as "RLL/knee cap"."""
    pairs = zip(body.sphere_segment, body.sphere_names, strict=True)
    return [f"{body.segments[segment]}/{name}" for segment, name in pairs if name]


def _body_faults(
    file: AccommodationFile, body: Body, postures: PosturesFile
) -> Iterator[tuple[Key, str]]:
    if file.posture.like not in postures.postures:
        yield (
            ("posture", "like"),
            f"no posture {file.posture.like!r}; {one_of(file.posture.like, postures.postures)}",
        )
    if file.detail is not None and (body.basis is None or file.detail not in body.basis.details):
        levels = ", ".join(body.basis.details) if body.basis else "none"
        yield (
            ("detail",),
            f"body {body.name} has no level of detail {file.detail!r}; valid: {levels}",
        )


def _seat(file: AccommodationFile, environment: Environment) -> Iterator[tuple[Key, str]]:
    seats = {seat.name: seat for seat in environment.seats}
    if file.seat not in seats:
        yield (
            ("seat",),
            f"environment {environment.name} has no seat {file.seat!r}; {one_of(file.seat, seats)}",
        )


def _aims(file: AccommodationFile, environment: Environment) -> Iterator[tuple[Key, str]]:
    controls = {control.name: control for control in environment.controls}
    for field, kind in (("hands", "hand"), ("feet", "foot")):
        for side in ("left", "right"):
            name = getattr(getattr(file.posture, field), side)
            key = ("posture", field, side)
            if name is not None and name not in controls:
                yield (
                    key,
                    f"environment {environment.name} has no control {name!r}; {one_of(name, controls)}",
                )
            elif name is not None and (controls[name].grip == "foot") != (kind == "foot"):
                yield key, f"{name} is for {'feet' if controls[name].grip == 'foot' else 'hands'}"
    for field in ("eyes", "heels"):
        point = getattr(file.posture, field)
        if point is not None and point not in environment.points:
            known = one_of(point, environment.points)
            yield (
                ("posture", field),
                f"environment {environment.name} has no point {point!r}; {known}",
            )
    for field in ("wheel", "h_point") if file.posture.driver is not None else ():
        point = getattr(file.posture.driver, field)
        if point not in environment.points:
            known = one_of(point, environment.points)
            yield (
                ("posture", "driver", field),
                f"environment {environment.name} has no point {point!r}; {known}",
            )


def _criteria(file: AccommodationFile, loaded: Loaded) -> Iterator[tuple[Key, str]]:
    environment, body, _ = loaded
    seen: set[str] = set()
    asked: dict[tuple[str, str | None, int], str] = {}
    for row, demand in enumerate(file.criteria):
        if demand.name in seen:
            yield ("criteria", row, "name"), f"two criteria are named {demand.name!r}"
        seen.add(demand.name)
        if environment is not None:
            yield from _named(
                ("criteria", row, "controls"),
                demand.controls,
                [c.name for c in environment.controls],
            )
            shown = [
                p
                for p, hidden in zip(environment.parts, environment.hidden, strict=True)
                if not hidden
            ]
            yield from _named(("criteria", row, "parts"), demand.parts, shown)
            yield from _twice((row, demand), environment, asked)
        if body is not None:
            words = segment_words(body)
            yield from _named(("criteria", row, "segments"), demand.segments, body.segments, words)
            yield from _named(("criteria", row, "subparts"), demand.subparts, subparts_of(body))
        yield from _contradictions(file, (row, demand))


def _named(
    key: Key, patterns: list[str] | None, known: Iterable[str], words: dict[str, str] | None = None
) -> Iterator[tuple[Key, str]]:
    names = list(known)
    for place, name in enumerate(patterns or ()):
        if not any(fnmatchcase(each, name) for each in names):
            yield (
                (*key, place),
                f"nothing is called {name!r}; {one_of(name, names, words=words or {})}",
            )


def _twice(
    entry: tuple[int, DemandFile],
    environment: Environment,
    asked: dict[tuple[str, str | None, int], str],
) -> Iterator[tuple[Key, str]]:
    """A control that two criteria ask for by the same hand in the same zone would be counted
    twice."""
    row, demand = entry
    if demand.check != "reach":
        return
    for control in environment.controls:
        wanted = demand.controls is None or any(
            fnmatchcase(control.name, name) for name in demand.controls
        )
        zone = demand.zone or control.zone
        before = (
            asked.setdefault((control.name, demand.hand, zone), demand.name)
            if wanted
            else demand.name
        )
        if before != demand.name:
            key: Key = ("criteria", row, "controls") if demand.controls else ("criteria", row)
            yield key, f"{control.name} in zone {zone} is asked for by {before!r} already"


def _contradictions(
    file: AccommodationFile, entry: tuple[int, DemandFile]
) -> Iterator[tuple[Key, str]]:
    row, demand = entry
    heights = demand.at_most_below is not None or demand.at_most_above is not None
    if demand.check == "vision" and heights and file.posture.eyes is None:
        yield (
            ("criteria", row),
            "a vision is about the point that 'eyes' of the posture names, and it names none",
        )
    if (
        demand.check == "seat"
        and file.posture.feet.left is None
        and file.posture.feet.right is None
    ):
        yield (
            ("criteria", row),
            "a seat is about the pedals that 'feet' of the posture names, and it names none",
        )


def _changes(file: AccommodationFile, environment: Environment) -> Iterator[tuple[Key, str]]:
    for row, change in enumerate(file.changes):
        controls = [control.name for control in environment.controls]
        if change.control is not None and change.control not in controls:
            what = f"environment {environment.name} has no control {change.control!r}; "
            yield ("changes", row, "control"), what + one_of(change.control, controls)
        yield from _named(("changes", row, "parts"), change.parts, environment.parts)
    for row, task in enumerate(file.maps):
        if task.part not in environment.parts:
            what = f"environment {environment.name} has no part {task.part!r}; {one_of(task.part, environment.parts)}"
            yield ("maps", row, "part"), what
