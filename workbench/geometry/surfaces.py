"""Exact distance between two triangle meshes with the points that are nearest, through a tree.

Two triangles are nearest to one another along two edges, or at a corner over the other's face, or
an edge goes through the other's face (Ericson, Real-Time Collision Detection, 2005, 5.1.9, 5.1.10
and 5.2.10).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from workbench.compiled import batch_loop, inlined, inner
from workbench.geometry.bvh import DEPTH, build_sah_bvh
from workbench.geometry.vectors import cross, dot, subtract
from workbench.model.arrays import Floats

__all__ = ["SurfaceGap", "come_near", "surface_gap"]

_ALONG = 1e-12
"""Of edges whose squared sine is below this, an end is nearest to the other: they are parallel."""


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
        (T, 3, 3) and (U, 3, 3) [m] the corners of their triangles, one of each at least; triangles
        without area count as lines or points.
    """
    found = _least_gap(one, other, np.inf, 0.0)
    return SurfaceGap(found[1:4], found[4:7], float(found[0]))


def come_near(one: Floats, other: Floats, within: float) -> bool:
    """Tell whether two surfaces cross, or come as near as a distance.

    Parameters
    ----------
    one, other
        (T, 3, 3) [m] corners of their triangles; triangles without area count as lines or points.
    within
        [m].

    Returns
    -------
    bool
        False where one of them has no triangle.
    """
    for _ in range(2):  # each to the box of the other, and that to what is left of the first
        one = _beside(one, other, within)
        other = _beside(other, one, within)
    if not (len(one) and len(other)):
        return False
    most = within * (1.0 + 1e-12) + 1e-150
    return bool(_least_gap(one, other, most, within)[0] <= within)


def _beside(triangles: Floats, other: Floats, within: float) -> Floats:
    """The triangles whose boxes are as near as that to the box of the others."""
    if not (len(triangles) and len(other)):
        return triangles[:0]
    corners = other.reshape(-1, 3)
    low = corners.min(axis=0) - within
    high = corners.max(axis=0) + within
    near = (triangles.max(axis=1) >= low) & (triangles.min(axis=1) <= high)
    return triangles[near.all(axis=1)]


def _least_gap(one: Floats, other: Floats, most: float, enough: float) -> Floats:
    """(7,) [m] the distance of two meshes and the nearest points, `most` and NaN where it is not
    less; the first that is no more than `enough`, where there is one."""
    groups = np.array([0, len(other)], dtype=np.int64)
    boxes = np.concatenate([other.min(axis=1), other.max(axis=1)], axis=1)
    box, link, item, _ = build_sah_bvh(boxes, groups)
    found = np.full(7, np.nan)
    found[0] = most
    stack = np.empty(DEPTH, dtype=np.int64)
    _search(np.ascontiguousarray(one), other[item], box, link, enough, stack, found)
    return found


@inlined
def _along(p, way, t):  # type: ignore[no-untyped-def]
    """p + t way."""
    return p[0] + t * way[0], p[1] + t * way[1], p[2] + t * way[2]


@inlined
def _corner(c, k):  # type: ignore[no-untyped-def]
    return c[k, 0], c[k, 1], c[k, 2]


@inner
def _edge_points(p, q, r, s):  # type: ignore[no-untyped-def]
    """The nearest points of the edges p-q and r-s (Ericson 5.1.9)."""
    d = subtract(q, p)
    e = subtract(s, r)
    w = subtract(p, r)
    a = dot(d, d)
    b = dot(e, e)
    f = dot(e, w)
    c = dot(d, w)
    along = dot(d, e)
    flat = a * b - along * along
    t = 0.0
    if a > 0.0 and flat > _ALONG * a * b:
        t = min(max((along * f - c * b) / flat, 0.0), 1.0)
    u = (along * t + f) / b if b > 0.0 else 0.0
    if u < 0.0 or u > 1.0 or flat <= _ALONG * a * b:
        u = min(max(u, 0.0), 1.0)
        t = min(max((along * u - c) / a, 0.0), 1.0) if a > 0.0 else 0.0
    return _along(p, d, t), _along(r, e, u)


@inner
def _over(p, c, n):  # type: ignore[no-untyped-def]
    """Whether a point is over the inside of a triangle c (3, 3) with normal n of any length."""
    for k in range(3):
        a = _corner(c, k)
        side = subtract(_corner(c, (k + 1) % 3), a)
        if dot(n, cross(side, subtract(p, a))) < 0.0:
            return False
    return True


@inlined
def _nearer(best, start, end, turned):  # type: ignore[no-untyped-def]
    """The nearer of `best` (squared distance, start, end) and two points; turned: these stand the
    other way round."""
    away = subtract(end, start)
    square = dot(away, away)
    if not square < best[0]:
        return best
    return (square, end, start) if turned else (square, start, end)


@inner
def _face_points(one, other, best, turned):  # type: ignore[no-untyped-def]
    """Improve `best` by the corners of a triangle over the face of another, and by where its edges
    go through that; turned: what is `one` here has the ends."""
    a = _corner(other, 0)
    n = cross(subtract(_corner(other, 1), a), subtract(_corner(other, 2), a))
    square = dot(n, n)
    if square == 0.0:
        return best
    for k in range(3):
        p = _corner(one, k)
        q = _corner(one, (k + 1) % 3)
        h = dot(n, subtract(p, a))
        g = dot(n, subtract(q, a))
        if _over(p, other, n):
            best = _nearer(best, p, _along(p, n, -h / square), turned)
        if h * g < 0.0:
            x = _along(p, subtract(q, p), h / (h - g))
            if _over(x, other, n):
                best = _nearer(best, x, x, turned)
    return best


@inner
def _triangle_points(one, other, best):  # type: ignore[no-untyped-def]
    """Improve `best` by two triangles (3, 3)."""
    for k in range(3):
        for m in range(3):
            start, end = _edge_points(
                _corner(one, k),
                _corner(one, (k + 1) % 3),
                _corner(other, m),
                _corner(other, (m + 1) % 3),
            )
            best = _nearer(best, start, end, False)
    best = _face_points(one, other, best, False)
    return _face_points(other, one, best, True)


@inner
def _box_gap(one, box, m):  # type: ignore[no-untyped-def]
    """Squared distance [m2] of the box of a triangle (3, 3) to box m (low, high)."""
    square = 0.0
    for i in range(3):
        low = min(one[0, i], one[1, i], one[2, i])
        high = max(one[0, i], one[1, i], one[2, i])
        out = max(low - box[m, i + 3], 0.0, box[m, i] - high)
        square += out * out
    return square


@batch_loop
def _search(one, other, box, link, enough, stack, found):  # type: ignore[no-untyped-def]
    """Improve found (7,): the least distance [m] of a triangle of one (T, 3, 3) and one of other
    (T, 3, 3), which stand in the leaves of a tree, and the nearest points. Stops where it is no
    more than `enough` [m]. stack (DEPTH,): working space."""
    none = 0.0, 0.0, 0.0
    for t in range(len(one)):
        stack[0] = 0
        size = 1
        while size > 0:
            size -= 1
            m = stack[size]
            best = (found[0] * found[0], none, none)
            if _box_gap(one[t], box, m) >= best[0]:
                continue
            c = link[m, 0]
            if c >= 0:  # the nearer child on top
                near = 1 if _box_gap(one[t], box, c) > _box_gap(one[t], box, c + 1) else 0
                stack[size] = c + 1 - near
                stack[size + 1] = c + near
                size += 2
                continue
            before = best[0]
            for s in range(link[m, 1], link[m, 2]):
                best = _triangle_points(one[t], other[s], best)
            if best[0] < before:
                found[0] = math.sqrt(best[0])
                for i in range(3):
                    found[1 + i] = best[1][i]
                    found[4 + i] = best[2][i]
                if found[0] <= enough:
                    return
