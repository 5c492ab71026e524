"""Pulses, belts, airbags and force laws of a file as nouns: units to SI, names to indices, faults
with their lines."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.crash.simulation_schema import (
    AirbagFile,
    BeltFile,
    BeltPointFile,
    ContactFile,
    LawFile,
    PulseFile,
)
from workbench.files.meshes.parts import RawPart
from workbench.files.motions.number_rows import Clock, number_rows, numbered_lines
from workbench.files.names import matches
from workbench.files.schema import error_at
from workbench.files.yaml_text import Document
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.joint_angles import attitude_matrix
from workbench.model.simulation import (
    STANDARD_GRAVITY,
    Airbag,
    Belt,
    BeltPoint,
    ContactRule,
    ForceLaw,
    Pulse,
    half_sine,
    table_pulse,
    trapezoid,
)

__all__ = [
    "airbag_faults",
    "airbag_part",
    "airbags_of",
    "belt_faults",
    "belts_of",
    "contact_faults",
    "law_in_si",
    "pulse_of",
    "read_pulse",
    "rules_of",
    "surface_point",
]

_MM = 1000.0
_RINGS = 9
_SLICES = 16
_LASTS = (0.001, 10.0)
"""Least and greatest duration [s] of a pulse."""


def law_in_si(law: LawFile) -> ForceLaw:
    """A law of N and mm in N and m."""
    return ForceLaw(law.stiffness * _MM**law.exponent, law.exponent, law.returned, law.friction)


def pulse_of(file: PulseFile, folder: Path) -> Pulse:
    """The pulse of a file; InputError for a table that cannot be read, or does not begin and end at
    0, and for times that are in another unit: no crash of a vehicle lasts less than 1 ms or more than
    10 s."""
    made = _shape(file, folder)
    shortest, longest = _LASTS
    if not shortest <= made.duration <= longest:
        header = "; a table says its unit in its header, time [ms] or [s]" if file.file else ""
        raise InputError(
            f"the pulse lasts {1000 * made.duration:g} ms, {1000 * shortest:g} to {1000 * longest:g} ms is a "
            f"crash: its times are in milliseconds (0.1 s is 100){header}"
        )
    x, y, z = (v / math.hypot(*file.toward) for v in file.toward)
    return replace(made, toward=(x, y, z))


def _shape(file: PulseFile, folder: Path) -> Pulse:
    """The pulse of a file, its times in seconds, whatever way it acts."""
    start = file.start / _MM
    peak = (file.peak or 0.0) * STANDARD_GRAVITY
    if file.shape == "table":
        return read_pulse(folder / (file.file or ""), start=start)
    if file.shape == "half_sine":
        return half_sine(peak, (file.duration or 0.0) / _MM, start=start)
    rise, hold, fall = ((v or 0.0) / _MM for v in (file.rise, file.hold, file.fall))
    return trapezoid(peak, (rise, hold, fall), start=start)


def belt_faults(
    document: Document,
    belts: Sequence[BeltFile],
    body: Body,
    *,
    anchors: Iterable[str],
    taken: Iterable[str],
    key: tuple[str | int, ...] = ("belts",),
) -> list[str]:
    """Faults of belts: names that are taken, and points that nothing holds.

    Parameters
    ----------
    document, belts
        The file, and the belts in it.
    body
        The occupant, to whose segments points of the routes belong.
    anchors
        The names of the points that a route may go through.
    taken
        The names of parts, which no belt may have.
    key
        Where the belts stand in the file.
    """
    faults = []
    names = list(anchors)
    seen = set(taken)
    for row, belt in enumerate(belts):
        if belt.name in seen:
            what = f"something is named {belt.name!r} already"
            faults.append(error_at(document, (*key, row, "name"), what))
        seen.add(belt.name)
        for place, point in enumerate(belt.route):
            where = (*key, row, "route", place)
            if isinstance(point, BeltPointFile):
                faults += _belt_point_faults(document, where, point, body)
            elif isinstance(point, str) and point not in names:
                faults.append(
                    error_at(document, where, f"no anchor {point!r}; {one_of(point, names)}")
                )
    return faults


def _belt_point_faults(
    document: Document, key: tuple[str | int, ...], point: BeltPointFile, body: Body
) -> list[str]:
    """Report a point on no segment of the body, or without a way from the segment's origin."""
    if point.segment not in body.segments:
        hint = one_of(point.segment, body.segments)
        what = f"body {body.name} has no segment {point.segment!r}; {hint}"
        return [error_at(document, (*key, "segment"), what)]
    if not any(point.at):
        return [error_at(document, (*key, "at"), "the segment's origin is on no surface")]
    return []


def belts_of(
    belts: Sequence[BeltFile], body: Body, anchors: Mapping[str, Sequence[float]]
) -> tuple[Belt, ...]:
    """Belts without faults; points of segments go onto the surface of their spheres."""
    return tuple(
        Belt(
            b.name,
            tuple(_belt_point(body, anchors, p) for p in b.route),
            ForceLaw(b.stiffness * _MM, 1.0, b.returned),
            b.slack,
            b.width,
            b.allow,
        )
        for b in belts
    )


def _belt_point(body: Body, anchors: Mapping[str, Sequence[float]], point: object) -> BeltPoint:
    if isinstance(point, BeltPointFile):
        n = body.segment(point.segment)
        x, y, z = (float(v) for v in surface_point(body, n, np.array(point.at)))
        return BeltPoint(n, (x, y, z), body.segment_names[n])
    given = anchors[point] if isinstance(point, str) else point
    x, y, z = (float(v) for v in given)  # type: ignore[attr-defined]
    return BeltPoint(-1, (x, y, z), point if isinstance(point, str) else "")


def surface_point(body: Body, segment: int, toward: Floats) -> Floats:
    """(3,) [m] where the ray from a segment's origin toward a point leaves its spheres, in the
    segment's frame; the point itself where the ray meets none."""
    way = toward / np.linalg.norm(toward)
    some = body.spheres(segment)
    centre = body.centre[0, some]
    radius = body.radius[0, some]
    along = centre @ way
    square = radius**2 - (np.sum(centre**2, axis=1) - along**2)
    out = along + np.sqrt(np.maximum(square, 0.0))
    hit = (square > 0) & (out > 0)
    return way * float(out[hit].max()) if hit.any() else toward


def contact_faults(
    document: Document,
    rows: Iterable[tuple[tuple[str | int, ...], ContactFile]],
    body: Body,
    parts: Sequence[str],
) -> list[str]:
    """Names of segments and parts in force laws, given with their keys, that nothing is called."""
    return [
        error_at(
            document, (*key, field, place), f"nothing is called {name!r}; {one_of(name, valid)}"
        )
        for key, rule in rows
        for field, names, valid in (
            ("parts", rule.parts, parts),
            ("segments", rule.segments or [], body.segments),
        )
        for place, name in enumerate(names)
        if not any(matches(name, each) for each in valid)
    ]


def rules_of(
    rows: Sequence[ContactFile], body: Body, environment: Environment
) -> tuple[ContactRule, ...]:
    """Force laws with the segments and parts they are about as masks."""
    return tuple(
        ContactRule(
            _mask(rule.segments, body.segments),
            _mask(rule.parts, environment.parts),
            law_in_si(rule),
        )
        for rule in rows
    )


def _mask(patterns: Sequence[str] | None, names: Iterable[str]) -> Bools:
    return np.array(
        [patterns is None or any(matches(p, n) for p in patterns) for n in names],
        dtype=np.bool_,
    )


def airbags_of(bags: Sequence[AirbagFile]) -> tuple[Airbag, ...]:
    """Airbags without faults."""
    return tuple(
        Airbag(bag.name, bag.centre, bag.half_axes, math.radians(bag.pitch), bag.allow)
        for bag in bags
    )


def airbag_faults(
    document: Document,
    bags: Sequence[AirbagFile],
    taken: Iterable[str],
    key: tuple[str | int, ...] = ("airbags",),
) -> list[str]:
    """Airbags that are called like a part that is there already."""
    faults = []
    seen = set(taken)
    for row, bag in enumerate(bags):
        if bag.name in seen:
            what = f"a part is named {bag.name!r} already; give it another name"
            faults.append(error_at(document, (*key, row, "name"), what))
        seen.add(bag.name)
    return faults


def airbag_part(bag: Airbag) -> RawPart:
    """An airbag as a closed part of flat triangles on its ellipsoid."""
    turn = np.linspace(0, 2 * np.pi, _SLICES, endpoint=False)
    rise = np.linspace(0, np.pi, _RINGS + 1)[1:-1]
    ring = [[(np.sin(a) * np.cos(t), np.sin(a) * np.sin(t), np.cos(a)) for t in turn] for a in rise]
    unit = np.concatenate([[(0.0, 0.0, 1.0)], np.array(ring).reshape(-1, 3), [(0.0, 0.0, -1.0)]])
    scaled = unit * np.array(bag.half_axes)
    placed = scaled @ attitude_matrix(pitch=bag.pitch).T + np.array(bag.centre)
    if not np.isfinite(placed).all():
        raise InputError(f"airbag {bag.name}: its size must be finite")
    return RawPart(bag.name, placed, np.array(_globe_faces(len(rise)), dtype=np.int64))


def _globe_faces(rings: int) -> list[tuple[int, int, int]]:
    """Triangles of a globe: vertex 0 is its top, then `rings` rings of slices follow, its bottom is
    the last."""
    last = rings * _SLICES + 1
    faces = []
    for s in range(_SLICES):
        t = (s + 1) % _SLICES
        faces += [(0, 1 + s, 1 + t), (last, last - _SLICES + t, last - _SLICES + s)]
        for r in range(rings - 1):
            a = 1 + r * _SLICES
            b = a + _SLICES
            faces += [(a + s, b + s, b + t), (a + s, b + t, a + t)]
    return faces


_TIME = {"ms": 1e-3, "s": 1.0}
_LEVEL = {"g": STANDARD_GRAVITY, "m/s2": 1.0}
_UNITS = {"time": _TIME, "acceleration": _LEVEL}
_SMALL = 0.01


def read_pulse(path: Path, *, start: float = 0.0) -> Pulse:
    """Read a table `time [ms], acceleration [g]` (or [s], [m/s2]) as a pulse.

    Lines with # are left out.

    Raises
    ------
    InputError
        With the line where a value is no finite number or time goes back, and where the pulse does
        not begin and end at 0 (within 1 % of its peak).
    """
    lines = _data_lines(path)
    number, head = next(lines, (1, ""))
    words = [word.strip() for word in [*head.split(","), "", ""][:2]]
    seconds, metres = (
        _unit(path, number, word, name) for word, name in zip(words, _UNITS, strict=True)
    )
    rows = ((n, [word.strip() for word in line.split(",")]) for n, line in lines)
    table = number_rows(path, rows, 2, rows=list(_UNITS), clock=Clock(None, 1.0))
    values = table.values
    numbers = table.lines
    if len(values) < 3:
        raise InputError(f"{path}: a pulse needs 3 samples or more, got {len(values)}")
    _check_time(path, values[:, 0], numbers)
    time = values[:, 0] * seconds
    level = values[:, 1] * metres
    for which, k in (("begin", 0), ("end", -1)):
        if abs(level[k]) > _SMALL * np.abs(level).max():
            unit = re.sub(r".*\[|\].*", "", words[1])
            raise InputError(
                f"{path}, line {numbers[k]}: the pulse does not {which} at 0: {values[k, 1]:g} {unit} at "
                f"{1000 * time[k]:g} ms; give it whole"
            )
    return table_pulse(time, level, start=start)


def _data_lines(path: Path) -> Iterator[tuple[int, str]]:
    """The lines of a file with their numbers, but for empty ones and those with #."""
    for number, line in numbered_lines(path):
        if line.strip() and not line.lstrip().startswith("#"):
            yield number, line


def _check_time(path: Path, time: Floats, numbers: Ints) -> None:
    """Raise where the time (T,) of a table does not rise. numbers: the line of each sample."""
    back = np.flatnonzero(np.diff(time) <= 0)
    if len(back):
        k = int(back[0])
        raise InputError(
            f"{path}, line {numbers[k + 1]}: time goes back or stands still, from "
            f"{time[k]:g} to {time[k + 1]:g}"
        )


def _unit(path: Path, number: int, word: str, name: str) -> float:
    found = re.fullmatch(rf"{name}\s*\[\s*(\S+)\s*\]", word)
    units = _UNITS[name]
    if not found or found[1] not in units:
        valid = " or ".join(f"'{name} [{unit}]'" for unit in units)
        raise InputError(f"{path}, line {number}: the header needs a column {valid}, got {word!r}")
    return units[found[1]]
