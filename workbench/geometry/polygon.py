"""Sphere against planar polygon, the paper's way: plane, then circle against enclosing circle, then
edges and inside.

Carried out on the distance, the three steps give the exact distance of a point to a polygon
(convex, concave, with holes), and stop as soon as it is known to exceed what is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import inlined, inner
from workbench.geometry.simd4 import (
    below,
    divided,
    least_of,
    load_four,
    lower,
    splat4,
    upper,
    where_positive,
)
from workbench.geometry.simd8 import how_many, lowest_set_bit

__all__ = [
    "EDGES",
    "RECORD",
    "Faces",
    "inside_loops",
    "nearest_of_record",
    "point_polygon",
    "winding_number",
]

RECORD = 10
"""Numbers before the edges of a polygon's record: unit normal (3), centre of the enclosing circle
(3) and its radius [m], the coordinate left out, the polygon's number, how far it leaves its plane
[m]."""
EDGES = 24
"""Numbers of four edges: x of their tails, y, z, and x, y, z of their heads."""
_STEP = np.uint64(EDGES)
_FOUR = np.uint64(4)
_HEADS = np.uint64(12)


class Faces(NamedTuple):
    """The polygons of an environment as records, and a tree of boxes over those of each part.

    Both the radius of a polygon's circle and how far its corners lie off its plane are widened by
    rounding. Inner nodes of the trees have the children child[m] and child[m] + 1. A leaf has child
    -1 and the polygons of the ranks first[m]:last[m].
    """

    record: NDArray[np.float64]
    """Record q at begin[q]:begin[q + 1]: RECORD numbers, then tails and heads of its edges [m] by
    fours, EDGES numbers each; the last four are filled up with the first edge's tail as edges
    without length. The coordinate left out is that of the normal's largest component."""
    begin: NDArray[np.int64]
    """(F + 1,) where each record begins."""
    rank: NDArray[np.int64]
    """(F,) the record of each polygon: they stand in the order of the trees' leaves."""
    low: NDArray[np.float64]
    """(M, 3) least coordinates of each node's box [m]."""
    high: NDArray[np.float64]
    """(M, 3) greatest coordinates of each node's box [m]."""
    child: NDArray[np.int64]
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    item: NDArray[np.int64]
    """(F,) the polygon of each rank."""
    root: NDArray[np.int64]
    """(K,) the node of each part, -1 for one without polygons."""
    solid: NDArray[np.int64]
    """(K,) 1 for a solid part."""
    corners: NDArray[np.float64]
    """(T, 3, 3) triangles of all parts [m]."""
    corner_start: NDArray[np.int64]
    """(K + 1,) where the triangles of each part begin."""


@inlined
def _coordinate(axis, x, y, z):  # type: ignore[no-untyped-def]
    """Coordinate number 0, 1 or 2 of a point."""
    if axis == 1:
        return y
    return z if axis == 2 else x


@inlined
def _crossed(record, e, i, k, u, v):  # type: ignore[no-untyped-def]
    """Bits of those of four edges that a ray from (u, v) along the coordinate i crosses, seen in i
    and k."""
    ai = load_four(record, e + _FOUR * i)
    ak = load_four(record, e + _FOUR * k)
    bi = load_four(record, e + _FOUR * i + _HEADS)
    bk = load_four(record, e + _FOUR * k + _HEADS)
    # the edge from a to b passes the height v at i = a_i + (b_i - a_i) (v - a_k) / (b_k - a_k)
    parted = below(v, ak) ^ below(v, bk)
    return parted & below(u, divided((bi - ai) * (v - ak), bk - ak) + ai)


@inlined
def _gaps_of_edges(x, y, z, record, e):  # type: ignore[no-untyped-def]
    """Squared distances [m2] of a point, each coordinate four times, to four edges."""
    a0 = load_four(record, e)
    a1 = load_four(record, e + _FOUR)
    a2 = load_four(record, e + _FOUR + _FOUR)
    head = e + _HEADS
    d0 = load_four(record, head) - a0
    d1 = load_four(record, head + _FOUR) - a1
    d2 = load_four(record, head + _FOUR + _FOUR) - a2
    # foot on the edge a + t d: t = (x - a) . d / |d|^2, kept from 0 to 1; 0 where d has no length
    square = d0 * d0 + d1 * d1 + d2 * d2
    t = divided((x - a0) * d0 + (y - a1) * d1 + (z - a2) * d2, square)
    t = where_positive(square, lower(splat4(1.0), upper(splat4(0.0), t)))
    u = x - (a0 + t * d0)
    v = y - (a1 + t * d1)
    w = z - (a2 + t * d2)
    return u * u + v * v + w * w


@inlined
def _nearest_of_edge(x, y, z, record, e):  # type: ignore[no-untyped-def]
    """The point of an edge, whose tail begins at e, that is nearest to a point."""
    head = e + _HEADS
    a0 = record[e]
    a1 = record[e + _FOUR]
    a2 = record[e + _FOUR + _FOUR]
    d0 = record[head] - a0
    d1 = record[head + _FOUR] - a1
    d2 = record[head + _FOUR + _FOUR] - a2
    square = d0 * d0 + d1 * d1 + d2 * d2
    t = 0.0
    if square > 0.0:
        t = min(1.0, max(0.0, ((x - a0) * d0 + (y - a1) * d1 + (z - a2) * d2) / square))
    return a0 + t * d0, a1 + t * d1, a2 + t * d2


@inlined
def _nearest_of_edges(x, y, z, h, record, at, end):  # type: ignore[no-untyped-def]
    """Squared distance [m2] of a point, h above the plane of record[at:end], to that polygon, and
    the nearest point: the foot of the height where that is inside, else a point of an edge.

    Inside is the parity of crossings in the plane without the left-out coordinate.
    """
    px = x - h * record[at]
    py = y - h * record[at + 1]
    pz = z - h * record[at + 2]
    drop = np.uint64(record[at + 7])
    i = (drop + np.uint64(1)) % np.uint64(3)
    k = (drop + np.uint64(2)) % np.uint64(3)
    pi = splat4(_coordinate(i, px, py, pz))
    pk = splat4(_coordinate(k, px, py, pz))
    x4 = splat4(x)
    y4 = splat4(y)
    z4 = splat4(z)
    crossed = np.uint64(0)
    best = np.inf
    edge = np.uint64(0)
    for e in range(np.uint64(at + RECORD), np.uint64(end), _STEP):
        crossed ^= _crossed(record, e, i, k, pi, pk)
        gaps = _gaps_of_edges(x4, y4, z4, record, e)
        gap = least_of(gaps)
        if gap < best:
            best = gap
            edge = e + lowest_set_bit(~below(splat4(gap), gaps))
    if how_many(crossed) & np.uint64(1) and h * h < best:
        return h * h, px, py, pz
    bx, by, bz = _nearest_of_edge(x, y, z, record, edge)
    return best, bx, by, bz


@inlined
def nearest_of_record(x, y, z, record, at, end, limit):  # type: ignore[no-untyped-def]
    """Squared distance [m2] of a point to the polygon record[at:end], and the nearest point.

    The paper's steps: the height h above the plane, less what the corners lie off it; the distance
    from the enclosing circle; the edges. Infinite where the square exceeds `limit`: what is given
    up early is beyond it also as it would have been computed, so the answer does not depend on it.
    """
    n0 = record[at]
    n1 = record[at + 1]
    n2 = record[at + 2]
    u = x - record[at + 3]
    v = y - record[at + 4]
    w = z - record[at + 5]
    # 1. height above the plane: h = n . (x - c)
    h = n0 * u + n1 * v + n2 * w
    over = max(abs(h) - record[at + 9], 0.0)
    if over * over > limit:
        return np.inf, x, y, z
    # 2. in the plane, as far out of the enclosing circle: |x - c - h n| - r
    u = u - h * n0
    v = v - h * n1
    w = w - h * n2
    out = max(math.sqrt(u * u + v * v + w * w) - record[at + 6], 0.0)
    if over * over + out * out > limit:
        return np.inf, x, y, z
    # 3. edges and inside
    best, bx, by, bz = _nearest_of_edges(x, y, z, h, record, at, end)
    if best > limit:
        return np.inf, x, y, z
    return best, bx, by, bz


@inner
def point_polygon(x, y, z, faces, f, limit):  # type: ignore[no-untyped-def]
    """Squared distance [m2] of a point to polygon f and the nearest point, as `nearest_of_record`."""
    q = faces.rank[f]
    return nearest_of_record(x, y, z, faces.record, faces.begin[q], faces.begin[q + 1], limit)


@inner
def winding_number(x, y, z, corners, first, last):  # type: ignore[no-untyped-def]
    """Winding number of triangles about a point: +-1 inside a closed surface, 0 outside.

    Source: van Oosterom & Strackee, IEEE Trans. Biomed. Eng. 30(2), 1983: the solid angle of a
    plane triangle.
    """
    # solid angle of a triangle: tan(O / 2) = a . (b x c) / (|a||b||c| + a.b |c| + b.c |a| + c.a |b|)
    total = 0.0
    for t in range(first, last):
        a0 = corners[t, 0, 0] - x
        a1 = corners[t, 0, 1] - y
        a2 = corners[t, 0, 2] - z
        b0 = corners[t, 1, 0] - x
        b1 = corners[t, 1, 1] - y
        b2 = corners[t, 1, 2] - z
        c0 = corners[t, 2, 0] - x
        c1 = corners[t, 2, 1] - y
        c2 = corners[t, 2, 2] - z
        a = math.sqrt(a0 * a0 + a1 * a1 + a2 * a2)
        b = math.sqrt(b0 * b0 + b1 * b1 + b2 * b2)
        d = math.sqrt(c0 * c0 + c1 * c1 + c2 * c2)
        volume = a0 * (b1 * c2 - b2 * c1) + a1 * (b2 * c0 - b0 * c2) + a2 * (b0 * c1 - b1 * c0)
        ab = a0 * b0 + a1 * b1 + a2 * b2
        bc = b0 * c0 + b1 * c1 + b2 * c2
        ca = c0 * a0 + c1 * a1 + c2 * a2
        total += math.atan2(volume, a * b * d + ab * d + bc * a + ca * b)
    return total / (2.0 * math.pi)


def inside_loops(
    points: NDArray[np.float64], loops: Iterable[NDArray[np.float64]]
) -> NDArray[np.bool_]:
    """Return which of points (..., 2) are inside an odd number of closed loops (K, 2): a ray in +x
    crosses an odd number of their edges."""
    x, y = points[..., 0], points[..., 1]
    inside = np.zeros(points.shape[:-1], dtype=np.bool_)
    for loop in loops:
        for a, b in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            if a[1] != b[1]:
                spans = (a[1] > y) != (b[1] > y)
                inside ^= spans & (x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1]))
    return inside
