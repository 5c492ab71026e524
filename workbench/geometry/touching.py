"""Whether two meshes come near one another: the exact distance of triangles, through a tree.

Two triangles are nearest to one another along two edges, or at a corner over the other's face, or
an edge goes through the other's face (Ericson, Real-Time Collision Detection, 2005, 5.1.9, 5.1.10
and 5.2.10).
"""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import batch_loop, inlined, inner
from workbench.geometry.tree import DEPTH, split_tree
from workbench.model.arrays import Floats

__all__ = ["come_near"]

_ALONG = 1e-12
"""Of edges whose squared sine is below this, an end is nearest to the other: they are parallel."""


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
    groups = np.array([0, len(other)], dtype=np.int64)
    boxes = np.concatenate([other.min(axis=1), other.max(axis=1)], axis=1)
    box, link, item, _ = split_tree(boxes, groups)
    found = np.zeros(1, dtype=np.bool_)
    stack = np.empty(DEPTH, dtype=np.int64)
    one = np.ascontiguousarray(one)
    _search(one, other[item], box, link, within, stack, found)
    return bool(found[0])


def _beside(triangles: Floats, other: Floats, within: float) -> Floats:
    """The triangles whose boxes are as near as that to the box of the others."""
    if not (len(triangles) and len(other)):
        return triangles[:0]
    corners = other.reshape(-1, 3)
    low = corners.min(axis=0) - within
    high = corners.max(axis=0) + within
    near = (triangles.max(axis=1) >= low) & (triangles.min(axis=1) <= high)
    found: Floats = triangles[near.all(axis=1)]
    return found


@inlined
def _dot(u, v):  # type: ignore[no-untyped-def]
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@inlined
def _less(u, v):  # type: ignore[no-untyped-def]
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


@inlined
def _cross(u, v):  # type: ignore[no-untyped-def]
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


@inlined
def _corner(c, k):  # type: ignore[no-untyped-def]
    return c[k, 0], c[k, 1], c[k, 2]


@inner
def _edge_gap(p, q, r, s):  # type: ignore[no-untyped-def]
    """Squared distance [m2] of the edges p-q and r-s (Ericson 5.1.9)."""
    d = _less(q, p)
    e = _less(s, r)
    w = _less(p, r)
    a = _dot(d, d)
    b = _dot(e, e)
    f = _dot(e, w)
    c = _dot(d, w)
    along = _dot(d, e)
    flat = a * b - along * along
    t = 0.0
    if a > 0.0 and flat > _ALONG * a * b:
        t = min(max((along * f - c * b) / flat, 0.0), 1.0)
    u = (along * t + f) / b if b > 0.0 else 0.0
    if u < 0.0 or u > 1.0 or flat <= _ALONG * a * b:
        u = min(max(u, 0.0), 1.0)
        t = min(max((along * u - c) / a, 0.0), 1.0) if a > 0.0 else 0.0
    x = w[0] + t * d[0] - u * e[0]
    y = w[1] + t * d[1] - u * e[1]
    z = w[2] + t * d[2] - u * e[2]
    return x * x + y * y + z * z


@inner
def _over(p, c, n):  # type: ignore[no-untyped-def]
    """Whether a point is over the inside of a triangle c (3, 3) with normal n of any length."""
    for k in range(3):
        a = _corner(c, k)
        side = _less(_corner(c, (k + 1) % 3), a)
        if _dot(n, _cross(side, _less(p, a))) < 0.0:
            return False
    return True


@inner
def _faces_near(one, other, within):  # type: ignore[no-untyped-def]
    """Whether a corner of a triangle is that near over the face of another, or an edge goes
    through it."""
    a = _corner(other, 0)
    n = _cross(_less(_corner(other, 1), a), _less(_corner(other, 2), a))
    size = math.sqrt(_dot(n, n))
    if size == 0.0:
        return False
    for k in range(3):
        p = _corner(one, k)
        q = _corner(one, (k + 1) % 3)
        h = _dot(n, _less(p, a)) / size
        g = _dot(n, _less(q, a)) / size
        if abs(h) <= within and _over(p, other, n):
            return True
        if h * g < 0.0:
            t = h / (h - g)
            x = p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2])
            if _over(x, other, n):
                return True
    return False


@inner
def _triangles_near(one, other, within):  # type: ignore[no-untyped-def]
    """Whether two triangles (3, 3) are as near as that."""
    for k in range(3):
        for m in range(3):
            gap = _edge_gap(
                _corner(one, k),
                _corner(one, (k + 1) % 3),
                _corner(other, m),
                _corner(other, (m + 1) % 3),
            )
            if gap <= within * within:
                return True
    return _faces_near(one, other, within) or _faces_near(other, one, within)


@batch_loop
def _search(one, other, box, link, within, stack, found):  # type: ignore[no-untyped-def]
    """Set found (1,) where a triangle of one (T, 3, 3) is near one of other (T, 3, 3), which stand
    in the leaves of a tree. stack (DEPTH,): working space."""
    for t in range(len(one)):
        stack[0] = 0
        size = 1
        while size > 0:
            size -= 1
            m = stack[size]
            apart = False
            for i in range(3):
                least = min(one[t, 0, i], one[t, 1, i], one[t, 2, i])
                most = max(one[t, 0, i], one[t, 1, i], one[t, 2, i])
                apart |= least > box[m, i + 3] + within or most < box[m, i] - within
            if apart:
                continue
            if link[m, 0] >= 0:
                stack[size] = link[m, 0]
                stack[size + 1] = link[m, 0] + 1
                size += 2
                continue
            for s in range(link[m, 1], link[m, 2]):
                if _triangles_near(one[t], other[s], within):
                    found[0] = True
                    return
