"""Clearances that an accommodation study asks for: which spheres of which parts, and who comes too near in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.kernels.polygon import point_polygon
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.study import Criterion
from workbench.solve.fields import packed_faces
from workbench.solve.people_gaps import Gap, PeopleGaps
from workbench.solve.people_placed import PeoplePlaced

__all__ = ["foot_on", "gap_of", "gap_toward", "gap_words"]


def gap_of(body: Body, environment: Environment, criterion: Criterion) -> Gap:
    """The spheres and parts that a clearance or contact criterion is about."""
    segment = body.sphere_segment
    if criterion.subparts:
        labels = [f"{body.segments[n]}/{name}" for n, name in zip(segment, body.sphere_names, strict=True)]
        spheres = np.isin(labels, criterion.subparts)
    else:
        spheres = np.isin(segment, [n for n, name in enumerate(body.segments) if name in criterion.segments])
    return Gap(spheres, np.isin(environment.parts, criterion.parts), criterion.check == "contact")


def gap_words(body: Body, environment: Environment, pair: tuple[int, int]) -> str:
    """ "right lower leg, instrument_panel": what comes too near to what, from a sphere and a polygon."""
    sphere, polygon = pair
    segment = body.segment_names[int(body.sphere_segment[sphere])]
    name = body.sphere_names[sphere]
    part = environment.parts[int(environment.polygon_part[polygon])]
    return f"{segment} ({name}) at {part}" if name else f"{segment} at {part}"


def foot_on(environment: Environment, polygon: int, centre: Floats, seat: tuple[Sequence[str], Floats]) -> Floats:
    """(3,) [m] the point of a polygon nearest to a centre (3,), where the seat has taken it: the parts that go along
    and by how much (3,)."""
    moves, shift = seat
    by = shift if environment.parts[int(environment.polygon_part[polygon])] in moves else np.zeros(3)
    x, y, z = centre - by
    _, px, py, pz = point_polygon(x, y, z, packed_faces(environment), polygon, np.inf)
    point: Floats = np.array([px, py, pz]) + by
    return point


def gap_toward(
    found: tuple[PeoplePlaced, PeopleGaps, int], environment: Environment, seat: tuple[Sequence[str], Floats]
) -> Floats:
    """(B, 3) the unit vector from the nearest sphere to the nearest part of gap q: where the part would have to go; NaN
    where nothing is there, or a centre is inside."""
    (placed, gaps, q), (moves, shift) = found, seat
    away = np.full((len(placed.centres), 3), np.nan)
    for b in np.flatnonzero(gaps.sphere[:, q] >= 0):
        centre = placed.centres[b, gaps.sphere[b, q]]
        way = foot_on(environment, int(gaps.polygon[b, q]), centre, (moves, shift[b])) - centre
        far = float(np.linalg.norm(way))
        if far > 1e-9 and gaps.room[b, q] > -placed.radius[b, gaps.sphere[b, q]]:
            away[b] = way / far
    return away
