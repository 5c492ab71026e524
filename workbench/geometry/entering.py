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

import numpy as np
from numpy.typing import ArrayLike

from workbench.geometry.box_pairs import box_pairs
from workbench.geometry.nearest import build_solid, mesh_distance
from workbench.geometry.polygon import point_winding
from workbench.model.arrays import Floats, Ints, xyz
from workbench.model.environment import Environment, Seat
from workbench.model.posing import attitude_matrix

__all__ = ["TOLERANCE", "Entered", "entered", "travel_ways"]

TOLERANCE = 5e-3
"""[m] Parts of real meshes overlap by so much more without meaning it: seams, foam, sheets."""
_FOLLOWED = 0.15
"""[m] Ways are followed by multiples of this, so that one is followed once for all lengths."""
_SPACING = 0.01
"""[m] between the points along edges."""
_MOST = 20_000
"""Points of a mesh that are followed at most: of more every so manieth."""
_TELLING = 200
"""Points that tell on which side of the other mesh a mesh is, and how deep in it."""
_BESIDE = 0.1
"""[m] What is nearer to where parts overlap already is beside that place."""
_TOUCHES = 1e-3
"""[m] Surfaces that are nearer touch."""


@dataclass(frozen=True)
class Entered:
    """A moved part that enters another one: by how much [m], and whether they touch before."""

    part: str
    other: str
    depth: float
    touched: bool


@dataclass(frozen=True, eq=False)
class _Way:
    """N points that go through triangles of a mesh, after `height` (N,) [m], with `slope` (N,) =
    |n . d|, and beside which both overlap by `known` (N,) [m] before."""

    height: Floats
    slope: Floats
    known: Floats

    def deepest(self, length: float) -> tuple[float, bool]:
        """How deep [m] a point enters after a way [m], 0 where none does, and whether the meshes touch
        there before."""
        depth = (length - self.height) * self.slope
        depth[depth <= self.known + TOLERANCE] = 0.0
        at = int(np.argmax(depth))
        return float(depth[at]), bool(self.height[at] < _TOUCHES)


def entered(
    environment: Environment,
    parts: Sequence[str],
    by: ArrayLike,
    *,
    start: ArrayLike = (0.0, 0.0, 0.0),
    others: Sequence[str] | None = None,
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
        ways = _ways_of(environment, part, among, (xyz(np.array(start)), unit), most)
        for other, way in ways:
            depth, touched = way.deepest(length)
            if depth > (best.depth if best else 0.0):
                best = Entered(part, other, depth, touched)
    return best


Range = tuple[float, float]


def travel_ways(
    seat: Seat, known: Sequence[Range], travel: Sequence[Range], *, middles: bool = False
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
    told: set[tuple[float, ...]] = set()
    for place in product(*map(sorted, stops)):
        start = np.clip(place, *np.transpose(known))
        corner = np.array([start[0], place[1]])
        for begin, end in ((start, corner), (corner, np.array(place))):
            way = (*begin, *end)
            if (begin != end).any() and way not in told:
                told.add(way)
                yield begin @ axes, (end - begin) @ axes


@lru_cache(maxsize=256)
def _ways_of(
    environment: Environment,
    part: str,
    among: tuple[str, ...],
    line: tuple[tuple[float, float, float], tuple[float, float, float]],
    most: float,
) -> list[tuple[str, _Way]]:
    """By the name of each part that may be entered the points that are followed, from where a part is
    displaced to along a unit vector, up to a way [m]."""
    row = environment.part_index(part)
    start, direction = (np.array(vector) for vector in line)
    moved = environment.triangle_corners(row) + start
    ends = np.concatenate([moved.reshape(-1, 3), moved.reshape(-1, 3) + most * direction])
    low, high = ends.min(axis=0), ends.max(axis=0)
    found = []
    lows, highs = _part_boxes(environment)
    meets = (lows <= high).all(axis=1) & (highs >= low).all(axis=1)
    for other in among:
        k = environment.part_index(other)
        if environment.hidden[k] or environment.hidden[row] or not meets[k]:
            continue
        still = environment.triangle_corners(k)
        near = still[((still.max(axis=1) >= low) & (still.min(axis=1) <= high)).all(axis=1)]
        if len(near):
            found += [(other, way) for way in _followed(moved, near, direction, (still, most))]
            found += [(other, way) for way in _followed(near, moved, -direction, (moved, most))]
    return found


@lru_cache(maxsize=4)
def _part_boxes(environment: Environment) -> tuple[Floats, Floats]:
    """(K, 3) the least and the greatest corners [m] of all parts."""
    corners = [environment.triangle_corners(k) for k in range(len(environment.parts))]
    lows = [one.min(axis=(0, 1), initial=np.inf) for one in corners]
    return np.array(lows), np.array([one.max(axis=(0, 1), initial=-np.inf) for one in corners])


def _followed(
    own: Floats, mesh: Floats, along: Floats, whole: tuple[Floats, float]
) -> Iterator[_Way]:
    """The points of triangles (T, 3, 3) [m] that enter triangles of a mesh (M, 3, 3) along a unit
    vector.

    whole: all triangles of the other mesh, and how far [m] the way is.
    """
    every = _edge_points(own)
    height, met = _first_met(every, mesh, along)
    ahead = np.flatnonzero(height < whole[1])
    height = _met_aside(every[ahead], (mesh, along), np.full(len(ahead), TOLERANCE), height[ahead])
    enters = height < whole[1]
    if not enters.any():
        return
    within = ((every >= mesh.min(axis=(0, 1))) & (every <= mesh.max(axis=(0, 1)))).all(axis=1)
    near = _thinned(every[within], _TELLING)
    outer = np.median(_windings(_thinned(every, _TELLING), whole[0]))
    inner = near[np.abs(_windings(near, whole[0]) - outer) >= 0.5]
    points = every[ahead][enters]
    height = height[enters]
    beside = np.linalg.norm((points + height[:, None] * along)[:, None] - inner, axis=2) < _BESIDE
    known = np.max(np.where(beside, _distance(inner, whole[0]), 0.0), axis=1, initial=0.0)
    height = _met_aside(points, (mesh, along), known + TOLERANCE, height)
    new = np.abs(_windings(points - _TOUCHES * along, whole[0]) - outer) < 0.5
    new &= height < whole[1]
    if new.any():
        slope = np.abs(_normals(mesh[met[ahead][enters][new]]) @ along)
        yield _Way(height[new], slope, known[new])


def _met_aside(points: Floats, line: tuple[Floats, Floats], by: Floats, height: Floats) -> Floats:
    """(N,) [m] how far ahead points meet triangles (T, 3, 3) along a unit vector both where they are, at
    `height` (N,) [m], and moved aside by so much (N,) [m] in any of four ways."""
    mesh, along = line
    for aside in np.concatenate([_across(along), -_across(along)]):
        height = np.maximum(height, _first_met(points + by[:, None] * aside, mesh, along)[0])
    return height


def _thinned(points: Floats, most: int) -> Floats:
    """Every so manieth of some points (N, 3), so that they are no more than so many."""
    return points[:: max(1, -(-len(points) // most))]


def _windings(points: Floats, triangles: Floats) -> Floats:
    """(N,) the winding numbers of triangles (T, 3, 3) about points."""
    count = len(triangles)
    return np.array([point_winding(x, y, z, triangles, 0, count) for x, y, z in points.tolist()])


def _edge_points(triangles: Floats) -> Floats:
    """(N, 3) [m] points along the edges of triangles (T, 3, 3)."""
    start = triangles.reshape(-1, 3)
    side = np.roll(triangles, -1, axis=1).reshape(-1, 3) - start
    count = np.maximum(np.ceil(np.linalg.norm(side, axis=1) / _SPACING), 1).astype(np.int64)
    edge = np.repeat(np.arange(len(start)), count)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    points = start[edge] + (step / count[edge])[:, None] * side[edge]
    return _thinned(points, _MOST)


def _normals(triangles: Floats) -> Floats:
    """(T, 3) unit normals, 0 of what has no area."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-30)[:, None])


def _first_met(points: Floats, triangles: Floats, along: Floats) -> tuple[Floats, Ints]:
    """How far ahead (N,) [m] along a unit vector points first meet triangles, infinite where they meet
    none, and which (N,); triangles that are seen edge-on are met by none."""
    if not len(points):
        return np.zeros(0), np.zeros(0, dtype=np.int64)
    across = _across(along)
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
    height = np.full(len(points), np.inf)
    met = np.zeros(len(points), dtype=np.int64)
    height[i[last]] = ahead[last]
    met[i[last]] = j[last]
    return height, met


def _across(along: Floats) -> Floats:
    """(2, 3) two unit vectors at right angles to one and to each other."""
    return np.asarray(np.linalg.svd(along[None])[2][1:])


def _distance(points: Floats, triangles: Floats) -> Floats:
    """(N,) [m] how far points are from the nearest place of triangles (T, 3, 3)."""
    found = np.empty(len(points)), np.empty(len(points), dtype=np.int64), np.empty((len(points), 3))
    faces = np.arange(3 * len(triangles)).reshape(-1, 3)
    mesh = build_solid(triangles.reshape(-1, 3), faces)
    mesh_distance(np.ascontiguousarray(points), mesh, *found)
    return np.abs(found[0])
