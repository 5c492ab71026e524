"""How far parts of an environment may go along a straight way until they enter others.

Two meshes meet first where an edge or a corner of one meets the other, so points along the edges of
both are followed along the way, those of what stands still the other way round. Where the way of a
point goes through a triangle with unit normal n after a height h, it is after a way t

    (t - h) |n . d|

behind the triangle's plane, d being the direction. It has entered where this is more than
`TOLERANCE`, and where it would have met the mesh too if it were so far aside: what grazes a floor or
the side of a bolster has not.

Only what is entered more than before the way begins counts: where meshes overlap already, what goes
no deeper beside that place is nothing new. A point is in the other mesh already, and
leaves it, where the mesh winds about it otherwise than about most points of its own mesh. Winding numbers tell the sides of open sheets too (Jacobson, Kavan & Sorkine-Hornung,
ACM Trans. Graph. 32(4), 2013).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from workbench.geometry.box_pairs import box_pairs
from workbench.geometry.nearest import build_solid, mesh_distance
from workbench.geometry.polygon import winding_number
from workbench.geometry.surfaces import come_near
from workbench.model.arrays import Floats, Ints, xyz
from workbench.model.environment import Environment, Seat
from workbench.model.joint_angles import attitude_matrix

T = TypeVar("T", Floats, Ints)
__all__ = ["TOLERANCE", "Entered", "entered", "travel_ways"]

TOLERANCE = 5e-3
"""[m] Parts of real meshes overlap by so much more without meaning it: seams, foam, sheets."""
_FOLLOWED = 0.15
"""[m] Ways are followed by multiples of this, so that one is followed once for all lengths."""
_SPACING = 0.01
_BESIDE = 0.1
_TOUCHES = 1e-3
"""[m] How far points are apart along edges; what is beside a place; what touches."""
_MOST = 20_000
_TELLING = 200
_WORK = 20_000_000
"""Points of a mesh that are followed at most, of more every so manieth; that tell on which side of the
other mesh it is, and how deep in that; and of these times the triangles that they are held against."""


@dataclass(frozen=True)
class Entered:
    """A moved part that enters another one: by how much [m], and whether they touch before."""

    part: str
    other: str
    depth: float
    touched: bool


@dataclass(frozen=True, eq=False)
class _Way:
    """N points that enter `other`, each after `height` (N,) [m] through a triangle with `slope` (N,) =
    |n . d|, where both overlap by `known` (N,) [m] before."""

    other: str
    height: Floats
    slope: Floats
    known: Floats


def entered(
    environment: Environment,
    parts: Sequence[str],
    by: ArrayLike,
    *,
    start: ArrayLike = (0.0, 0.0, 0.0),
    others: Sequence[str] | None = None,
    way_counts: bool = True,
) -> Entered | None:
    """Find which of some parts enters another one deepest, by more than it does before.

    Parameters
    ----------
    environment
        With everything at rest. What is hidden is not there.
    parts
        What is moved, together.
    by
        (3,) [m] the straight way that they are moved.
    start
        (3,) [m] how far from rest they are before.
    others
        What they may enter, which stands still: all other parts if None.
    way_counts
        Whether what is gone all through counts: to a seat on its way, not to what is fixed elsewhere.

    Returns
    -------
    Entered or None
        None where nothing is entered by more than `TOLERANCE`, and where the way is 0.
    """
    length = float(np.linalg.norm(np.asarray(by)))
    if length == 0.0:
        return None
    unit = xyz(np.round(np.array(by) / length, 12))
    most = _FOLLOWED * float(np.ceil(length / _FOLLOWED - 1e-9))
    among = tuple(environment.parts if others is None else others)
    among = tuple(name for name in among if name not in parts)
    best: Entered | None = None
    for part in parts:
        for way in _ways_of(environment, part, among, (xyz(np.array(start)), unit), most):
            depth = (length - way.height) * way.slope
            depth[depth <= way.known + TOLERANCE] = 0.0
            at = int(np.argmax(depth))
            deeper = depth[at] > (best.depth if best else 0.0)
            if deeper and (way_counts or _stays_in(environment, (part, way.other), start, by)):
                touched = way.height[at] < _TOUCHES or way.known[at] > 0.0
                best = Entered(part, way.other, float(depth[at]), bool(touched))
    return best


def travel_ways(
    seat: Seat,
    known: Sequence[tuple[float, float]],
    travel: Sequence[tuple[float, float]],
    *,
    middles: bool = False,
) -> Iterator[tuple[Floats, Floats]]:
    """Return the straight ways of a seat out of one range of places to the corners of another one: up
    or down first, then forward or back.

    Parameters
    ----------
    seat
        That is moved.
    known, travel
        The ranges, forward and up [m]: the least and the greatest.
    middles
        Also to where it is at rest in one of the two, or nearest to that.

    Returns
    -------
    Iterator[tuple[Floats, Floats]]
        From where off its place at rest (3,) [m] each way begins, and how far it goes (3,) [m].
    """
    axes = np.array([attitude_matrix(yaw=seat.yaw)[:, 0], (0.0, 0.0, 1.0)])
    stops = [
        {low, high} | ({min(max(0.0, low), high)} if middles else set()) for low, high in travel
    ]
    for place in product(*map(sorted, stops)):
        start = np.clip(place, *np.transpose(known))
        corner = np.array([start[0], place[1]])
        for begin, end in ((start, corner), (corner, np.array(place))):
            if (begin != end).any():
                yield begin @ axes, (end - begin) @ axes


@lru_cache(maxsize=256)
def _ways_of(
    environment: Environment,
    part: str,
    among: tuple[str, ...],
    line: tuple[tuple[float, float, float], tuple[float, float, float]],
    most: float,
) -> list[_Way]:
    """What enters which parts, from where a part is displaced to along a unit vector, up to a way [m]."""
    row = environment.part_index(part)
    direction = np.array(line[1])
    moved = environment.triangle_corners(row) + np.array(line[0])
    ends = np.concatenate([moved, moved + most * direction])
    lows, highs = _part_boxes(environment)
    meets = (lows <= ends.max(axis=(0, 1))) & (highs >= ends.min(axis=(0, 1)))
    shown = meets.all(axis=1) & ~environment.hidden & (not environment.hidden[row])
    found: list[_Way] = []
    for other in among:
        if shown[environment.part_index(other)]:
            still = environment.triangle_corners(environment.part_index(other))
            found += _followed(other, (moved, still), direction, most)
            found += _followed(other, (still, moved), -direction, most)
    return found


@lru_cache(maxsize=4)
def _part_boxes(environment: Environment) -> Floats:
    """(2, K, 3) the least and the greatest corners [m] of all parts."""
    corners = [environment.triangle_corners(k) for k in range(len(environment.parts))]
    lows = [one.min(axis=(0, 1), initial=np.inf) for one in corners]
    return np.array([lows, [one.max(axis=(0, 1), initial=-np.inf) for one in corners]])


def _followed(
    other: str, meshes: tuple[Floats, Floats], along: Floats, most: float
) -> Iterator[_Way]:
    """The points of triangles (T, 3, 3) [m] that enter a mesh (M, 3, 3) along a unit vector, up to a
    way [m]."""
    own, mesh = meshes
    swept = np.concatenate([mesh, mesh - most * along])
    near = (own.max(axis=1) >= swept.min(axis=(0, 1))) & (own.min(axis=1) <= swept.max(axis=(0, 1)))
    enough = max(8, _WORK // len(mesh))
    points = _edge_points(own[near.all(axis=1)])
    if not len(points):
        return
    reach = np.concatenate([points, points + most * along])
    ends = reach.min(axis=0) - TOLERANCE, reach.max(axis=0) + TOLERANCE
    ahead = mesh[((mesh.max(axis=1) >= ends[0]) & (mesh.min(axis=1) <= ends[1])).all(axis=1)]
    within = ((points >= mesh.min(axis=(0, 1))) & (points <= mesh.max(axis=(0, 1)))).all(axis=1)
    within = _thinned(points[within], min(_TELLING, enough))
    telling = _thinned(points, min(_TELLING, enough))
    height, slope = _first_met(points, ahead, along)
    for aside in _aside(along):
        points, height, slope = points[height < most], height[height < most], slope[height < most]
        height = np.maximum(height, _first_met(points + TOLERANCE * aside, ahead, along)[0])
    some = _thinned(np.flatnonzero(height < most), enough)
    points, height, slope = points[some], height[some], slope[some]
    if not len(points):
        return
    outer = np.median(_windings(telling, mesh))
    inner = within[np.abs(_windings(within, mesh) - outer) >= 0.5]
    beside = np.linalg.norm((points + height[:, None] * along)[:, None] - inner, axis=2) < _BESIDE
    known = np.max(np.where(beside, _distance(inner, mesh), 0.0), axis=1, initial=0.0)
    for aside in _aside(along):
        far = points + (known + TOLERANCE)[:, None] * aside
        height = np.maximum(height, _first_met(far, mesh, along)[0])
    new = np.abs(_windings(points - _TOUCHES * along, mesh) - outer) < 0.5
    new &= height < most
    if new.any():
        yield _Way(other, height[new], slope[new], known[new])


def _stays_in(
    environment: Environment, parts: tuple[str, str], start: ArrayLike, by: ArrayLike
) -> bool:
    """Whether a part crosses the surface of another one at the end of a way, or its middle is on another
    side of it than before, and no farther out."""
    own, other = (environment.triangle_corners(environment.part_index(name)) for name in parts)
    own = own + np.asarray(start)
    middle = own.mean(axis=(0, 1))
    before, after = _windings(np.array([middle, middle + np.asarray(by)]), other)
    crossed = abs(after - before) >= 0.5 and abs(after) > abs(before) - 0.25
    return bool(crossed) or come_near(own + np.asarray(by), other, 0.0)


def _thinned(rows: T, most: int) -> T:
    """Every so manieth of some rows, so that they are no more than so many."""
    return rows[:: max(1, -(-len(rows) // most))]


def _windings(points: Floats, triangles: Floats) -> Floats:
    """(N,) the winding numbers of triangles (T, 3, 3) about points."""
    count = len(triangles)
    return np.array([winding_number(x, y, z, triangles, 0, count) for x, y, z in points.tolist()])


def _edge_points(triangles: Floats) -> Floats:
    """(N, 3) [m] points along the edges of triangles (T, 3, 3)."""
    triangles = _thinned(triangles, _MOST)
    start = triangles.reshape(-1, 3)
    side = np.roll(triangles, -1, axis=1).reshape(-1, 3) - start
    count = np.maximum(np.ceil(np.linalg.norm(side, axis=1) / _SPACING), 1).astype(np.int64)
    edge = np.repeat(np.arange(len(start)), count)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    points = start[edge] + (step / count[edge])[:, None] * side[edge]
    return _thinned(points, _MOST)


def _first_met(points: Floats, triangles: Floats, along: Floats) -> Floats:
    """(2, N) how far ahead [m] along a unit vector points first meet triangles, infinite where they meet
    none, and |n . d| of these; triangles that are seen edge-on are met by none."""
    found = np.full((2, len(points)), np.inf)
    if not len(points):
        return found
    across = _aside(along)[:2]
    flat = points @ across.T
    corner = triangles @ across.T
    boxes = np.concatenate([corner.min(axis=1), corner.max(axis=1)], axis=1)
    i, j = box_pairs(np.concatenate([flat, flat], axis=1), boxes)
    # barycentric coordinates by the areas of the triangles of a point and each side
    side = np.roll(corner, -1, axis=1) - corner
    to = flat[i, None] - corner[j]
    part = side[j, :, 0] * to[..., 1] - side[j, :, 1] * to[..., 0]
    area = part.sum(axis=1)
    flat_on = np.abs(area) > 1e-9 * np.abs(side).sum(axis=(1, 2))[j] ** 2
    share = np.roll(part / np.where(flat_on, area, 1.0)[:, None], -1, axis=1)
    ahead = np.einsum("kc,kc->k", share, triangles[j] @ along) - points[i] @ along
    meets = np.flatnonzero(flat_on & (share > -1e-9).all(axis=1) & (ahead > -_TOUCHES))
    last = meets[np.argsort(-ahead[meets], kind="stable")]  # the nearest is written last
    size = np.linalg.norm(np.cross(*np.moveaxis(np.diff(triangles[j[last]], axis=1), 1, 0)), axis=1)
    found[:, i[last]] = ahead[last], np.abs(area[last]) / size
    return found


def _aside(along: Floats) -> Floats:
    """(4, 3) unit vectors at right angles to one: two at right angles, and their opposites."""
    across = np.linalg.svd(along[None])[2][1:]
    return np.concatenate([across, -across])


def _distance(points: Floats, triangles: Floats) -> Floats:
    """(N,) [m] how far points are from the nearest place of triangles (T, 3, 3)."""
    found = np.empty(len(points)), np.empty(len(points), dtype=np.int64), np.empty((len(points), 3))
    faces = np.arange(3 * len(triangles)).reshape(-1, 3)
    mesh = build_solid(triangles.reshape(-1, 3), faces)
    mesh_distance(np.ascontiguousarray(points), mesh, *found)
    return np.abs(found[0])
