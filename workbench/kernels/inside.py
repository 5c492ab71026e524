"""Inside or outside of a solid: signed crossings along a ray, the winding number only where a crossing is in doubt.

In a closed surface every crossing changes the winding number by one, so the crossings from a point to the outside add
up to it exactly, also where the surface crosses itself. Every sign is taken with its error bound; a ray that comes
too near to an edge, a needle or the point's own plane is given up for another, and after four the solid angles of all
triangles are summed, which also serves surfaces that are not closed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.kernels.polygon import point_winding
from workbench.kernels.tree import box_gap

__all__ = ["Shells", "inside_part", "is_closed"]

DOUBT = 1 << 40
ROUNDING = 1e-14


class Shells(NamedTuple):
    """triangle_start (F + 1,): the triangles of each polygon in Faces.corners; closed (K,): 1 where every edge of a
    part is run along as often one way as the other, so that its winding number is whole."""

    triangle_start: NDArray[np.int64]
    closed: NDArray[np.int64]


def is_closed(triangles: NDArray[np.int64]) -> bool:
    """True where every edge of the triangles (T, 3) is run along as often one way as the other."""
    tail, head = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    key = np.minimum(tail, head) * (int(triangles.max(initial=0)) + 1) + np.maximum(tail, head)
    edge = np.unique(key, return_inverse=True)[1].reshape(-1)
    return not np.any(np.bincount(edge, np.sign(head - tail)))


@njit(cache=True)
def _crossing(a, b, c, ray):  # type: ignore[no-untyped-def]
    """+-1 where a ray from ray[0:3] along ray[3:6] crosses a triangle, 0 where it surely does not, else DOUBT."""
    x, y, z, d0, d1, d2 = ray
    a0, a1, a2, b0, b1, b2 = a[0] - x, a[1] - y, a[2] - z, b[0] - x, b[1] - y, b[2] - z
    c0, c1, c2 = c[0] - x, c[1] - y, c[2] - z
    m0, m1, m2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
    u = d0 * m0 + d1 * m1 + d2 * m2
    v = d0 * (b1 * c2 - b2 * c1) + d1 * (b2 * c0 - b0 * c2) + d2 * (b0 * c1 - b1 * c0)
    w = d0 * (c1 * a2 - c2 * a1) + d1 * (c2 * a0 - c0 * a2) + d2 * (c0 * a1 - c1 * a0)
    p, q, r = abs(a0) + abs(a1) + abs(a2), abs(b0) + abs(b1) + abs(b2), abs(c0) + abs(c1) + abs(c2)
    d = ROUNDING * (abs(d0) + abs(d1) + abs(d2))
    above = (u > d * p * q) + (v > d * q * r) + (w > d * r * p)
    below = (u < -d * p * q) + (v < -d * q * r) + (w < -d * r * p)
    if above > 0 and below > 0:
        return 0
    volume = c0 * m0 + c1 * m1 + c2 * m2
    doubt = abs(volume) <= ROUNDING * p * q * r
    if above == 3 and not doubt:
        return 1 if volume > 0.0 else 0
    if below == 3 and not doubt:
        return -1 if volume < 0.0 else 0
    return DOUBT


@njit(cache=True, inline="always")
def _slab(low, high, at, along, near, far):  # type: ignore[no-untyped-def]
    """The part of near..far in which a ray's coordinate lies in low..high."""
    s, t = (low - at) / along, (high - at) / along
    return max(near, min(s, t)), min(far, max(s, t))


@njit(cache=True)
def _crossings(faces, shells, part, ray):  # type: ignore[no-untyped-def]
    """Signed crossings of a ray with a part, DOUBT where any is in doubt."""
    stack = np.empty(64, np.int64)
    stack[0], size, total = faces.root[part], 1, 0
    wide = 1e-9 * np.max(faces.high[stack[0]] - faces.low[stack[0]])
    wide += 1e-15 * max(np.max(np.abs(faces.high[stack[0]])), np.max(np.abs(faces.low[stack[0]])))
    while size > 0:
        size -= 1
        m = stack[size]
        near, far = 0.0, np.inf
        for i in range(3):
            near, far = _slab(faces.low[m, i] - wide, faces.high[m, i] + wide, ray[i], ray[i + 3], near, far)
        if near > far:
            continue
        if faces.child[m] >= 0:
            stack[size], stack[size + 1] = faces.child[m], faces.child[m] + 1
            size += 2
            continue
        for s in range(faces.first[m], faces.last[m]):
            f = faces.item[s]
            for t in range(shells.triangle_start[f], shells.triangle_start[f + 1]):
                corner = faces.corners[t]
                sign = _crossing(corner[0], corner[1], corner[2], ray)
                if sign == DOUBT:
                    return DOUBT
                total += sign
    return total


@njit(cache=True)
def inside_part(x, y, z, faces, shells, part):  # type: ignore[no-untyped-def]
    """True where a point lies inside a solid part: its winding number, to the nearest whole, is not zero."""
    root = faces.root[part]
    if faces.solid[part] == 0 or box_gap(x, y, z, faces.low[root], faces.high[root]) > 0.0:
        return False
    if shells.closed[part] == 1:
        low, high = faces.low[root], faces.high[root]
        gaps = np.array([high[0] - x, high[1] - y, high[2] - z, x - low[0], y - low[1], z - low[2]])
        way = np.argmin(gaps)
        for turn in range(4):
            lean = np.array([0.0371 - 0.0613 * turn, 0.0213 + 0.0457 * turn, -0.0291 + 0.0333 * turn])
            lean[way % 3] = 1.0 if way < 3 else -1.0
            total = _crossings(faces, shells, part, (x, y, z, lean[0], lean[1], lean[2]))
            if total != DOUBT:
                return total != 0
    return abs(point_winding(x, y, z, faces.corners, faces.corner_start[part], faces.corner_start[part + 1])) > 0.5
