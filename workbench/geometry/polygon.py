"""Sphere against planar polygon, the paper's way: plane, then circle against enclosing circle, then
edges and inside.

Carried out on the distance, the three steps give the exact distance of a point to a polygon
(convex, concave, with holes), and stop as soon as it is known to exceed what is asked for.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit

__all__ = ["Faces", "point_polygon", "point_winding"]


class Faces(NamedTuple):
    """The polygons of an environment in flat arrays, and a tree of boxes over the polygons of each
    part.

    Edge e runs from head[e] to tail[e] (E, 3); drop[f] is the largest component of the normal: the
    coordinate left out when inside or outside is decided. off[f] [m] is how far the corners lie off
    the polygon's plane, and circle_radius[f] how far from the circle's centre in it, both widened
    by rounding. Node m of the trees spans low[m]..high[m]; inner nodes have children child[m] and
    child[m] + 1, leaves have child -1 and the polygons listed in item[first[m]:last[m]]; root[k] is
    part k's. corners (T, 3, 3) are the triangles of the solids, corner_start (K + 1,) by part.
    """

    head: NDArray[np.float64]
    tail: NDArray[np.float64]
    edge_start: NDArray[np.int64]
    normal: NDArray[np.float64]
    drop: NDArray[np.int64]
    off: NDArray[np.float64]
    circle_centre: NDArray[np.float64]
    circle_radius: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    child: NDArray[np.int64]
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    item: NDArray[np.int64]
    root: NDArray[np.int64]
    solid: NDArray[np.int64]
    corners: NDArray[np.float64]
    corner_start: NDArray[np.int64]


@njit(cache=True)
def point_polygon(x, y, z, faces, f, limit):  # type: ignore[no-untyped-def]
    """Squared distance of a point to polygon f and the nearest point; infinite where the square
    exceeds `limit`.

    What is given up early is beyond the limit also as it would have been computed: the answer does
    not depend on it.
    """
    n = faces.normal[f]
    o = faces.circle_centre[f]
    u = x - o[0]
    v = y - o[1]
    w = z - o[2]
    h = n[0] * u + n[1] * v + n[2] * w
    over = max(abs(h) - faces.off[f], 0.0)
    if over * over > limit:
        return np.inf, x, y, z
    u = u - h * n[0]
    v = v - h * n[1]
    w = w - h * n[2]
    out = max(math.sqrt(u * u + v * v + w * w) - faces.circle_radius[f], 0.0)
    if over * over + out * out > limit:
        return np.inf, x, y, z
    drop = faces.drop[f]
    i = (drop + 1) % 3
    k = (drop + 2) % 3
    p = (x - h * n[0], y - h * n[1], z - h * n[2])
    inside = False
    best = np.inf
    bx = x
    by = y
    bz = z
    for e in range(faces.edge_start[f], faces.edge_start[f + 1]):
        a = faces.head[e]
        b = faces.tail[e]
        if (a[k] > p[k]) != (b[k] > p[k]) and p[i] < (b[i] - a[i]) * (p[k] - a[k]) / (
            b[k] - a[k]
        ) + a[i]:
            inside = not inside
        d0 = b[0] - a[0]
        d1 = b[1] - a[1]
        d2 = b[2] - a[2]
        square = d0 * d0 + d1 * d1 + d2 * d2
        t = 0.0
        if square > 0.0:
            t = ((x - a[0]) * d0 + (y - a[1]) * d1 + (z - a[2]) * d2) / square
            t = min(1.0, max(0.0, t))
        qx = a[0] + t * d0
        qy = a[1] + t * d1
        qz = a[2] + t * d2
        gap = (x - qx) ** 2 + (y - qy) ** 2 + (z - qz) ** 2
        if gap < best:
            best = gap
            bx = qx
            by = qy
            bz = qz
    if inside and h * h < best:
        best = h * h
        bx = p[0]
        by = p[1]
        bz = p[2]
    if best > limit:
        return np.inf, x, y, z
    return best, bx, by, bz


@njit(cache=True)
def point_winding(x, y, z, corners, first, last):  # type: ignore[no-untyped-def]
    """Winding number of triangles about a point: +-1 inside a closed surface, 0 outside.

    Source: van Oosterom & Strackee, IEEE Trans. Biomed. Eng. 30(2), 1983: the solid angle of a
    plane triangle.
    """
    total = 0.0
    for t in range(first, last):
        c = corners[t]
        a0 = c[0, 0] - x
        a1 = c[0, 1] - y
        a2 = c[0, 2] - z
        b0 = c[1, 0] - x
        b1 = c[1, 1] - y
        b2 = c[1, 2] - z
        c0 = c[2, 0] - x
        c1 = c[2, 1] - y
        c2 = c[2, 2] - z
        a = math.sqrt(a0 * a0 + a1 * a1 + a2 * a2)
        b = math.sqrt(b0 * b0 + b1 * b1 + b2 * b2)
        d = math.sqrt(c0 * c0 + c1 * c1 + c2 * c2)
        volume = a0 * (b1 * c2 - b2 * c1) + a1 * (b2 * c0 - b0 * c2) + a2 * (b0 * c1 - b1 * c0)
        ab = a0 * b0 + a1 * b1 + a2 * b2
        bc = b0 * c0 + b1 * c1 + b2 * c2
        ca = c0 * a0 + c1 * a1 + c2 * a2
        total += math.atan2(volume, a * b * d + ab * d + bc * a + ca * b)
    return total / (2.0 * math.pi)
