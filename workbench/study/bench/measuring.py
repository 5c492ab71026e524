"""The distance between two named things of a placement: segments, parts and controls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.contact.clearance_pairs import bodies_displaced
from workbench.contact.collide import body_clearance, clearance_of_rows, self_clearance
from workbench.errors import InputError, one_of
from workbench.geometry.nearest import build_solid, mesh_distance
from workbench.geometry.surfaces import surface_gap
from workbench.model.arrays import Floats
from workbench.model.contacts import Clearance
from workbench.study.bench.criteria import segment_of
from workbench.study.bench.placing import PlacedPerson, Placement, placed_environment
from workbench.study.bench.state import OpenStudy

__all__ = ["Measured", "Thing", "measured"]


@dataclass(frozen=True)
class Thing:
    """Something that has a name: a part, a control, or a segment of a person by name or mnemonic;
    what it is not is ""."""

    part: str = ""
    control: str = ""
    person: str = ""
    segment: str = ""


@dataclass(frozen=True, eq=False)
class Measured:
    """The nearest points (3,) [m] of two things, and their signed distance [m]: negative where they
    overlap."""

    start: Floats
    end: Floats
    distance: float


@dataclass(frozen=True, eq=False)
class _Segment:
    """A segment of somebody who is placed, by their indices."""

    person: PlacedPerson
    row: int
    segment: int


def measured(opened: OpenStudy, placement: Placement, one: Thing, other: Thing) -> Measured:
    """Measure between two things where a placement has them.

    A control is a point. Of a segment and a part, or two segments, the points are those of the
    nearest spheres. Two parts are measured between their surfaces: 0 where these cross.

    Raises
    ------
    InputError
        If either is not there or has no surface, or two segments are next to each other.
    """
    if one == other:
        raise InputError("two different things are needed to measure between them")
    if other.segment and not one.segment:
        back = measured(opened, placement, other, one)
        return Measured(back.end, back.start, back.distance)
    if one.segment:
        return _from_segment(opened, placement, _segment(placement, one), other)
    if one.part and other.part:
        gap = surface_gap(_surface(placement, one.part), _surface(placement, other.part))
        return Measured(gap.start, gap.end, gap.distance)
    if one.part:
        back = _from_point(opened, placement, _control(opened, placement, other), one)
        return Measured(back.end, back.start, back.distance)
    return _from_point(opened, placement, _control(opened, placement, one), other)


def _segment(placement: Placement, thing: Thing) -> _Segment:
    if not placement.people:
        raise InputError("people who move are measured by two points in the picture")
    row = placement.arrangement.row(thing.person)
    person = placement.people[row]
    return _Segment(person, row, segment_of(person.body, thing.segment))


def _control(opened: OpenStudy, placement: Placement, thing: Thing) -> Floats:
    """(3,) [m] where a control is."""
    controls = placed_environment(opened, placement).controls
    found = next((one for one in controls if one.name == thing.control), None)
    if found is None:
        names = [one.name for one in controls]
        raise InputError(f"no control {thing.control!r}; {one_of(thing.control, names)}")
    return np.array(found.at)


def _from_segment(opened: OpenStudy, placement: Placement, own: _Segment, other: Thing) -> Measured:
    """Between a segment and something else."""
    placed = own.person.placed
    if other.segment:
        return _between_segments(own, _segment(placement, other))
    if other.control:
        point = _control(opened, placement, other)
        body = placed.body
        spheres = slice(int(body.start[own.segment]), int(body.start[own.segment + 1]))
        far = np.linalg.norm(placed.centres[0, spheres] - point, axis=1) - body.radius[0, spheres]
        nearest = int(body.start[own.segment]) + int(far.argmin())
        return _toward(own, nearest, point, float(far.min()))
    environment = placement.parts.environment
    part = environment.part_index(other.part)
    shift = placement.parts.by_part[part]
    rows = np.array([[0, own.segment, part]])
    distance, sphere, _, point = clearance_of_rows(
        bodies_displaced(placed, -shift), environment, rows
    )
    if sphere[0] < 0:
        raise InputError(f"{other.part} has no surface to measure to")
    return _toward(own, int(sphere[0]), point[0] + shift, float(distance[0]))


def _between_segments(own: _Segment, other: _Segment) -> Measured:
    """Between two segments of one body or of two."""
    if own.row != other.row:
        found = body_clearance(own.person.placed, other.person.placed)
        return _of_pair(own, found, (0, own.segment, other.segment))
    first, second = sorted((own.segment, other.segment))
    found = self_clearance(own.person.placed)
    back = _of_pair(_Segment(own.person, own.row, first), found, (0, first, second))
    return back if first == own.segment else Measured(back.end, back.start, back.distance)


def _of_pair(own: _Segment, found: Clearance, where: tuple[int, int, int]) -> Measured:
    distance = float(found.distance[where])
    if not np.isfinite(distance):
        names = [own.person.body.segment_names[k] for k in where[1:]]
        raise InputError(f"{names[0]} and {names[1]} are next to each other on the body")
    return _toward(own, int(found.sphere[where]), found.point[where], distance)


def _toward(own: _Segment, sphere: int, point: Floats, distance: float) -> Measured:
    """From the side of a sphere to a point that is so far from its surface; from the point itself
    where it is inside."""
    centre = own.person.placed.centres[0, sphere]
    way = point - centre
    far = float(np.linalg.norm(way))
    start = centre + way / far * own.person.body.radius[0, sphere] if far > 1e-9 else point
    return Measured(start, point, distance)


def _from_point(opened: OpenStudy, placement: Placement, point: Floats, other: Thing) -> Measured:
    """Between a control and a control or a part."""
    if other.control:
        end = _control(opened, placement, other)
        return Measured(point, end, float(np.linalg.norm(end - point)))
    corners = _surface(placement, other.part).reshape(-1, 3)
    solid = build_solid(corners, np.arange(len(corners)).reshape(-1, 3))
    distance = np.empty(1)
    face = np.empty(1, dtype=np.int64)
    foot = np.empty((1, 3))
    mesh_distance(point[None], solid, distance, face, foot)
    return Measured(point, foot[0], float(np.linalg.norm(foot[0] - point)))


def _surface(placement: Placement, name: str) -> Floats:
    """(T, 3, 3) [m] the corners of the triangles of a part where a placement has it."""
    environment = placement.parts.environment
    part = environment.part_index(name)
    corners = environment.triangle_corners(part).reshape(-1, 3, 3)
    if not len(corners):
        raise InputError(f"{name} has no surface to measure to")
    return corners + placement.parts.by_part[part]
