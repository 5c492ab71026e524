"""Exact distance between two triangle meshes, with the points that are nearest.

Pairs of triangles are taken in the order of the gaps between their boxes until no other pair can be
nearer. Two triangles are nearest at a corner of one and the other's face, at two edges, or where an
edge of one pierces the other (Ericson, Real-Time Collision Detection, 2005, 5.1.5, 5.1.9, 5.3.6).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats

__all__ = ["MOST_PAIRS", "SurfaceGap", "surface_gap"]

MOST_PAIRS = 200_000_000
"""Pairs of triangles whose boxes are compared at most: some seconds."""
_BLOCK = 2_000_000
"""Pairs whose boxes are compared at a time: 50 MB."""
_CHUNK = 512
"""Pairs whose triangles are measured at a time."""
_TINY = 1e-30
"""[m²] Squares below are those of edges without length."""


@dataclass(frozen=True, eq=False)
class SurfaceGap:
    """The nearest points (3,) [m] of two meshes and their distance [m], 0 where they touch or
    cross."""

    start: Floats
    end: Floats
    distance: float


def surface_gap(one: Floats, other: Floats) -> SurfaceGap:
    """Find the nearest points of two meshes.

    Parameters
    ----------
    one, other
        (T, 3, 3) and (U, 3, 3) [m] the corners of their triangles, one of each at least.

    Raises
    ------
    InputError
        If there are more than MOST_PAIRS pairs of triangles.
    """
    if len(one) * len(other) > MOST_PAIRS:
        raise InputError(
            f"meshes of {len(one)} and {len(other)} triangles are too fine for this: "
            "measure between two points"
        )
    best = SurfaceGap(one[0, 0], other[0, 0], float(np.linalg.norm(one[0, 0] - other[0, 0])))
    rows = max(1, _BLOCK // len(other))
    low, high = other.min(axis=1), other.max(axis=1)
    for first in range(0, len(one), rows):
        some = one[first : first + rows]
        apart = np.maximum(low[None] - some.max(axis=1)[:, None], some.min(axis=1)[:, None] - high)
        bound = np.sqrt((np.maximum(apart, 0.0) ** 2).sum(axis=2))
        best = _nearer(some, other, bound, best)
    return best


def _nearer(one: Floats, other: Floats, bound: Floats, best: SurfaceGap) -> SurfaceGap:
    """What is nearer than `best` among triangles whose boxes are `bound` (T, U) [m] apart."""
    where = np.flatnonzero(bound.ravel() < best.distance)
    where = where[np.argsort(bound.ravel()[where], kind="stable")]
    for first in range(0, len(where), _CHUNK):
        pairs = where[first : first + _CHUNK]
        if bound.ravel()[pairs[0]] >= best.distance:
            break
        t, u = np.divmod(pairs, len(other))
        start, end = _nearest_points(one[t], other[u])
        distance = np.linalg.norm(end - start, axis=1)
        k = int(distance.argmin())
        if distance[k] < best.distance:
            best = SurfaceGap(start[k], end[k], float(distance[k]))
    return best


def _nearest_points(one: Floats, other: Floats) -> tuple[Floats, Floats]:
    """(P, 3) the nearest points of P pairs of triangles (P, 3, 3)."""
    starts = []
    ends = []
    for k in range(3):
        starts.append(one[:, k])
        ends.append(_on_triangle(one[:, k], other))
        starts.append(_on_triangle(other[:, k], one))
        ends.append(other[:, k])
        for m in range(3):
            mine, yours = _on_edges(
                one[:, k], one[:, (k + 1) % 3], other[:, m], other[:, (m + 1) % 3]
            )
            starts.append(mine)
            ends.append(yours)
        for edges, faces in ((one, other), (other, one)):
            point, pierced = _piercing(edges[:, k], edges[:, (k + 1) % 3], faces)
            starts.append(np.where(pierced[:, None], point, one[:, k]))
            ends.append(np.where(pierced[:, None], point, other[:, k]))
    start, end = np.stack(starts), np.stack(ends)
    nearest = np.linalg.norm(end - start, axis=2).argmin(axis=0)
    each = np.arange(len(one))
    return start[nearest, each], end[nearest, each]


def _dot(a: Floats, b: Floats) -> Floats:
    found: Floats = np.einsum("pc,pc->p", a, b)
    return found


def _on_triangle(point: Floats, corner: Floats) -> Floats:
    """(P, 3) the point of each triangle that is nearest to a point (P, 3): in the face where its
    foot lies inside, else on one of the edges."""
    a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
    normal = np.cross(b - a, c - a)
    square = np.maximum(_dot(normal, normal), _TINY)
    away = point - a
    # barycentric coordinates of the foot of the perpendicular
    v = _dot(np.cross(away, c - a), normal) / square
    w = _dot(np.cross(b - a, away), normal) / square
    inside = (v >= 0) & (w >= 0) & (v + w <= 1) & (_dot(normal, normal) > _TINY)
    best = np.where(inside[:, None], a + v[:, None] * (b - a) + w[:, None] * (c - a), np.inf)
    for begin, end in ((a, b), (b, c), (c, a)):
        along = end - begin
        share = np.clip(_dot(point - begin, along) / np.maximum(_dot(along, along), _TINY), 0, 1)
        foot = begin + share[:, None] * along
        nearer = np.linalg.norm(foot - point, axis=1) < np.linalg.norm(best - point, axis=1)
        best = np.where((nearer & ~inside)[:, None], foot, best)
    return best


def _on_edges(a: Floats, b: Floats, c: Floats, d: Floats) -> tuple[Floats, Floats]:
    """(P, 3) the nearest points of the edges a to b and c to d."""
    first, second = b - a, d - c
    away = a - c
    aa = np.maximum(_dot(first, first), _TINY)
    bb = np.maximum(_dot(second, second), _TINY)
    ab, a0, b0 = _dot(first, second), _dot(first, away), _dot(second, away)
    # the lines' nearest points, then each held on its edge; of parallel edges any will do
    slope = aa * bb - ab * ab
    s = np.where(slope > _TINY, np.clip((ab * b0 - a0 * bb) / np.maximum(slope, _TINY), 0, 1), 0.0)
    t = np.clip((ab * s + b0) / bb, 0, 1)
    s = np.clip((ab * t - a0) / aa, 0, 1)
    return a + s[:, None] * first, c + t[:, None] * second


def _piercing(a: Floats, b: Floats, corner: Floats) -> tuple[Floats, Bools]:
    """(P, 3) where the edges a to b pass through triangles, and (P,) whether they do."""
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    way = b - a
    cross = np.cross(way, second)
    turn = _dot(first, cross)
    sound = np.abs(turn) > _TINY
    scale = np.where(sound, turn, 1.0)
    away = a - corner[:, 0]
    u = _dot(away, cross) / scale
    over = np.cross(away, first)
    v = _dot(way, over) / scale
    t = _dot(second, over) / scale
    hit = sound & (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= 1)
    return a + t[:, None] * way, hit
