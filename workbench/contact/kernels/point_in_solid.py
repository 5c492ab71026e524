"""Inside or outside of a solid: signed crossings along a ray, the winding number only where a
crossing is in doubt.

In a closed surface every crossing changes the winding number by one, so the crossings from a point
to the outside add up to it exactly, also where the surface crosses itself. Every sign is taken with
its error bound; a ray that comes too near to an edge, a needle or the point's own plane is given up
for another, and after four the solid angles of all triangles are summed, which also serves surfaces
that are not closed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.geometry.polygon import winding_number
from workbench.geometry.vectors import cross, dot

__all__ = ["SolidMeshes", "crossings_between", "inside_part", "is_closed", "odd_shares"]

DOUBT = 1 << 40
"""Stands for a crossing whose sign is not sure: more than all triangles together."""
ROUNDING = 1e-14
"""Error of a product of three coordinates, as a part of the product of their sizes."""


class SolidMeshes(NamedTuple):
    """triangle_start (F + 1,): the triangles of each polygon in Faces.corners; closed (K,): 1 where
    every edge of a part is run along as often one way as the other, so that its winding number is
    whole."""

    triangle_start: NDArray[np.int64]
    closed: NDArray[np.int64]


def is_closed(triangles: NDArray[np.int64]) -> bool:
    """True where every edge of the triangles (T, 3) is run along as often one way as the other."""
    tail = triangles.ravel()
    head = np.roll(triangles, -1, axis=1).ravel()
    key = np.minimum(tail, head) * (int(triangles.max(initial=0)) + 1) + np.maximum(tail, head)
    edge = np.unique(key, return_inverse=True)[1].reshape(-1)
    return not np.any(np.bincount(edge, np.sign(head - tail)))


@inlined
def _size(a):  # type: ignore[no-untyped-def]
    """Sum of the magnitudes of a vector's components, which its rounding is a part of."""
    return abs(a[0]) + abs(a[1]) + abs(a[2])


@inlined
def _corner(corners, t, k, x, y, z):  # type: ignore[no-untyped-def]
    """Corner k of triangle t, seen from a point."""
    return corners[t, k, 0] - x, corners[t, k, 1] - y, corners[t, k, 2] - z


@inner
def _crossing(corners, t, x, y, z, ray):  # type: ignore[no-untyped-def]
    """Sign with which a ray from a point crosses triangle t, 0 where it surely does not, else DOUBT.

    With the corners a, b, c seen from the point, the ray d passes all three edges on one side where
    d.(a x b), d.(b x c) and d.(c x a) have one sign. It runs toward the triangle where that is the
    sign of the volume c.(a x b).
    """
    a = _corner(corners, t, 0, x, y, z)
    b = _corner(corners, t, 1, x, y, z)
    c = _corner(corners, t, 2, x, y, z)
    normal = cross(a, b)
    u = dot(ray, normal)
    v = dot(ray, cross(b, c))
    w = dot(ray, cross(c, a))
    p = _size(a)
    q = _size(b)
    r = _size(c)
    d = ROUNDING * _size(ray)
    above = (u > d * p * q) + (v > d * q * r) + (w > d * r * p)
    below = (u < -d * p * q) + (v < -d * q * r) + (w < -d * r * p)
    if above > 0 and below > 0:
        return 0
    volume = dot(c, normal)
    doubt = abs(volume) <= ROUNDING * p * q * r
    if above == 3 and not doubt:
        return 1 if volume > 0.0 else 0
    if below == 3 and not doubt:
        return -1 if volume < 0.0 else 0
    return DOUBT


@inlined
def _slab(low, high, place, step):  # type: ignore[no-untyped-def]
    """Where on a line, place + t step, it is between two planes: the lower t and the greater."""
    s = (low - place) / step
    t = (high - place) / step
    return min(s, t), max(s, t)


@inner
def _meets(low, high, m, wide, x, y, z, ray):  # type: ignore[no-untyped-def]
    """True where a ray may meet box m widened by `wide`; no component of its direction is zero."""
    a, b = _slab(low[m, 0] - wide, high[m, 0] + wide, x, ray[0])
    c, d = _slab(low[m, 1] - wide, high[m, 1] + wide, y, ray[1])
    e, f = _slab(low[m, 2] - wide, high[m, 2] + wide, z, ray[2])
    near = max(max(max(0.0, a), c), e)
    far = min(min(b, d), f)
    return near <= far


@inner
def _crossings(x, y, z, ray, faces, shells, root, wide, stack):  # type: ignore[no-untyped-def]
    """Signed crossings of a ray with the polygons under a tree node, DOUBT where any is in
    doubt."""
    stack[0] = root
    size = 1
    total = 0
    while size > 0:
        size -= 1
        m = stack[size]
        if not _meets(faces.low, faces.high, m, wide, x, y, z, ray):
            continue
        if faces.child[m] >= 0:
            stack[size] = faces.child[m]
            stack[size + 1] = faces.child[m] + 1
            size += 2
            continue
        for s in range(faces.first[m], faces.last[m]):
            f = faces.item[s]
            for t in range(shells.triangle_start[f], shells.triangle_start[f + 1]):
                sign = _crossing(faces.corners, t, x, y, z, ray)
                if sign == DOUBT:
                    return DOUBT
                total += sign
    return total


@inlined
def _way_out(up, down, least, lean, step, turn):  # type: ignore[no-untyped-def]
    """One component of the ray that is tried in a turn: the shortest way out of the box, leaning a
    little, so that it runs along no edge by design."""
    straight = (1.0 if up == least else 0.0) - (1.0 if down == least else 0.0)
    return straight + lean + step * turn


@inner
def inside_part(x, y, z, faces, shells, part, stack):  # type: ignore[no-untyped-def]
    """True where a point lies inside a solid part: its winding number, to the nearest whole, is not
    zero.

    stack (64,) is working space.
    """
    m = faces.root[part]
    if faces.solid[part] == 0 or m < 0:
        return False
    # the ways out of the part's box, up and down each axis [m]
    u0 = faces.high[m, 0] - x
    u1 = faces.high[m, 1] - y
    u2 = faces.high[m, 2] - z
    v0 = x - faces.low[m, 0]
    v1 = y - faces.low[m, 1]
    v2 = z - faces.low[m, 2]
    least = min(min(min(u0, u1), u2), min(min(v0, v1), v2))
    if least < 0.0:
        return False
    if shells.closed[part] == 1:
        far = max(max(abs(x) + u0 + v0, abs(y) + u1 + v1), abs(z) + u2 + v2)
        for turn in range(4):
            ray = (
                _way_out(u0, v0, least, 0.0371, -0.0613, turn),
                _way_out(u1, v1, least, 0.0213, 0.0457, turn),
                _way_out(u2, v2, least, -0.0291, 0.0333, turn),
            )
            total = _crossings(x, y, z, ray, faces, shells, m, 1e-12 * far, stack)
            if total != DOUBT:
                return total != 0
    first = faces.corner_start[part]
    return abs(winding_number(x, y, z, faces.corners, first, faces.corner_start[part + 1])) > 0.5


@inner
def odd_shares(points, directions, faces, shells, part, stack, share):  # type: ignore[no-untyped-def]
    """Share of the lines of sight from each point that cross a part an odd number of times.

    points (Q, 3) [m]; directions (D, 3) without a component of zero; stack (64,) is working space;
    share (Q,) is filled, with 0 for a point all of whose lines are in doubt. The sum of signed
    crossings is odd where their number is, so that the winding of the part does not matter.
    """
    m = faces.root[part]
    for q in range(len(points)):
        x = points[q, 0]
        y = points[q, 1]
        z = points[q, 2]
        sure = 0
        odd = 0
        if m >= 0:
            far = max(abs(x), abs(y), abs(z))
            for k in range(3):
                far = max(far, abs(faces.low[m, k]), abs(faces.high[m, k]))
            for d in range(len(directions)):
                ray = directions[d, 0], directions[d, 1], directions[d, 2]
                total = _crossings(x, y, z, ray, faces, shells, m, 4e-12 * far, stack)
                if total != DOUBT:
                    sure += 1
                    odd += total & 1
        share[q] = odd / max(sure, 1)


@batch_loop
def crossings_between(start, end, ray, wide, faces, shells, part, stack, count):  # type: ignore[no-untyped-def]
    """Signed crossings (Q,) of a part by the straight lines from points (Q, 3) to others [m].

    They are those of a ray from the start less those of the same ray from the end; 0 where any of
    them is in doubt. ray (Q, 3): from start to end, no component zero; wide [m]: the rounding of
    coordinates; stack (64,) is working space; count is filled.
    """
    m = faces.root[part]
    for q in range(len(start)):
        way = ray[q, 0], ray[q, 1], ray[q, 2]
        a = _crossings(start[q, 0], start[q, 1], start[q, 2], way, faces, shells, m, wide, stack)
        b = _crossings(end[q, 0], end[q, 1], end[q, 2], way, faces, shells, m, wide, stack)
        count[q] = 0 if a == DOUBT or b == DOUBT else a - b
