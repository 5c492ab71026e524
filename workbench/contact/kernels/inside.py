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

from workbench.compiled import inner
from workbench.geometry.polygon import point_winding

__all__ = ["Shells", "inside_part", "is_closed", "odd_shares"]

DOUBT = 1 << 40
ROUNDING = 1e-14


class Shells(NamedTuple):
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


@inner
def _crossing(corners, t, x, y, z, d0, d1, d2):  # type: ignore[no-untyped-def]
    """+-1 where a ray from a point along d crosses triangle t, 0 where it surely does not, else
    DOUBT."""
    a0 = corners[t, 0, 0] - x
    a1 = corners[t, 0, 1] - y
    a2 = corners[t, 0, 2] - z
    b0 = corners[t, 1, 0] - x
    b1 = corners[t, 1, 1] - y
    b2 = corners[t, 1, 2] - z
    c0 = corners[t, 2, 0] - x
    c1 = corners[t, 2, 1] - y
    c2 = corners[t, 2, 2] - z
    m0 = a1 * b2 - a2 * b1
    m1 = a2 * b0 - a0 * b2
    m2 = a0 * b1 - a1 * b0
    u = d0 * m0 + d1 * m1 + d2 * m2
    v = d0 * (b1 * c2 - b2 * c1) + d1 * (b2 * c0 - b0 * c2) + d2 * (b0 * c1 - b1 * c0)
    w = d0 * (c1 * a2 - c2 * a1) + d1 * (c2 * a0 - c0 * a2) + d2 * (c0 * a1 - c1 * a0)
    p = abs(a0) + abs(a1) + abs(a2)
    q = abs(b0) + abs(b1) + abs(b2)
    r = abs(c0) + abs(c1) + abs(c2)
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


@inner
def _meets(low, high, m, wide, x, y, z, d0, d1, d2):  # type: ignore[no-untyped-def]
    """True where a ray may meet box m widened by `wide`; no component of its direction is zero."""
    s = (low[m, 0] - wide - x) / d0
    t = (high[m, 0] + wide - x) / d0
    near = max(0.0, min(s, t))
    far = max(s, t)
    s = (low[m, 1] - wide - y) / d1
    t = (high[m, 1] + wide - y) / d1
    near = max(near, min(s, t))
    far = min(far, max(s, t))
    s = (low[m, 2] - wide - z) / d2
    t = (high[m, 2] + wide - z) / d2
    return max(near, min(s, t)) <= min(far, max(s, t))


@inner
def _crossings(x, y, z, d0, d1, d2, faces, shells, root, wide, stack):  # type: ignore[no-untyped-def]
    """Signed crossings of a ray with the polygons under a tree node, DOUBT where any is in
    doubt."""
    stack[0] = root
    size = 1
    total = 0
    while size > 0:
        size -= 1
        m = stack[size]
        if not _meets(faces.low, faces.high, m, wide, x, y, z, d0, d1, d2):
            continue
        if faces.child[m] >= 0:
            stack[size] = faces.child[m]
            stack[size + 1] = faces.child[m] + 1
            size += 2
            continue
        for s in range(faces.first[m], faces.last[m]):
            f = faces.item[s]
            for t in range(shells.triangle_start[f], shells.triangle_start[f + 1]):
                sign = _crossing(faces.corners, t, x, y, z, d0, d1, d2)
                if sign == DOUBT:
                    return DOUBT
                total += sign
    return total


@inner
def inside_part(x, y, z, faces, shells, part, stack):  # type: ignore[no-untyped-def]
    """True where a point lies inside a solid part: its winding number, to the nearest whole, is not
    zero.

    stack (64,) is working space.
    """
    m = faces.root[part]
    if faces.solid[part] == 0 or m < 0:
        return False
    up = (faces.high[m, 0] - x, faces.high[m, 1] - y, faces.high[m, 2] - z)
    down = (x - faces.low[m, 0], y - faces.low[m, 1], z - faces.low[m, 2])
    least = min(min(up), min(down))
    if least < 0.0:
        return False
    if shells.closed[part] == 1:
        far = max(abs(x) + up[0] + down[0], abs(y) + up[1] + down[1], abs(z) + up[2] + down[2])
        for turn in range(4):
            # the shortest way out, leaning a little, so that it runs along no edge by design
            d0 = (
                (1.0 if up[0] == least else 0.0)
                - (1.0 if down[0] == least else 0.0)
                + 0.0371
                - 0.0613 * turn
            )
            d1 = (
                (1.0 if up[1] == least else 0.0)
                - (1.0 if down[1] == least else 0.0)
                + 0.0213
                + 0.0457 * turn
            )
            d2 = (
                (1.0 if up[2] == least else 0.0)
                - (1.0 if down[2] == least else 0.0)
                - 0.0291
                + 0.0333 * turn
            )
            total = _crossings(x, y, z, d0, d1, d2, faces, shells, m, 1e-12 * far, stack)
            if total != DOUBT:
                return total != 0
    return (
        abs(
            point_winding(
                x, y, z, faces.corners, faces.corner_start[part], faces.corner_start[part + 1]
            )
        )
        > 0.5
    )


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
                d0 = directions[d, 0]
                d1 = directions[d, 1]
                d2 = directions[d, 2]
                total = _crossings(x, y, z, d0, d1, d2, faces, shells, m, 4e-12 * far, stack)
                if total != DOUBT:
                    sure += 1
                    odd += total & 1
        share[q] = odd / max(sure, 1)
