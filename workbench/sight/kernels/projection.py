"""Project triangles on a face of a cube about an eye: what is behind the eye is cut off.

A point (x, y, z) in the view of a face, z being ahead, is at x / z to the right and y / z up on the
plane 1 m ahead. The face goes from -1 to 1 both ways, n pixels wide; rows run down. Of a triangle
that crosses the plane a little before the eye the part ahead of that stays: one triangle or two.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.compiled import inlined, njit
from workbench.geometry.vectors import add, cross, dot, scale, store, vector
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["Triangles", "project_triangles"]

_NEAREST = 1e-6
"""Distance [m] before the eye, along the middle of a face, from which on triangles are seen."""
_ROOT = math.sqrt(2.0)


class Triangles(NamedTuple):
    """Triangles of N items, seen from an eye.

    corners (T, 3, 3) [m]; item (T,); ball (T, 4) [m]: a sphere about each. away (N, 3) [m]: from the
    eye, what is added to points of each item. closed (N,): items of which only the outside is seen.
    """

    corners: Floats
    item: Ints
    ball: Floats
    away: Floats
    closed: Bools


@inlined
def _is_before(ball, away, view):  # type: ignore[no-untyped-def]
    """Whether a sphere is within the four planes through the eye and the sides of a face.

    Their normals, ahead plus or minus right or above, are sqrt(2) long.
    """
    middle = add(vector(ball), away)
    ahead = dot(vector(view[2]), middle)
    aside = abs(dot(vector(view[0]), middle))
    above = abs(dot(vector(view[1]), middle))
    return ahead - max(aside, above) >= -_ROOT * ball[3] * (1.0 + 1e-12)


@inlined
def _between(one, other, height, low):  # type: ignore[no-untyped-def]
    """Where the side from one corner to another, at heights of other signs, crosses the plane."""
    share = height / (height - low)
    return add(scale(1.0 - share, one), scale(share, other))


@inlined
def _write(point, half, out):  # type: ignore[no-untyped-def]
    """Write column, row [pixels] and 1 / z of a point; half: of the pixels of an edge."""
    near = 1.0 / point[2]
    store(((point[0] * near + 1.0) * half, (1.0 - point[1] * near) * half, near), out)


@njit(cache=True, nogil=True)
def project_triangles(triangles: Triangles, view: Floats, n: int) -> tuple[Floats, Ints]:
    """Project triangles on a face.

    Parameters
    ----------
    triangles
        Seen from the eye.
    view
        (3, 3) right, up and ahead of the face as rows.
    n
        Pixels along an edge.

    Returns
    -------
    tuple[Floats, Ints]
        Columns, rows [pixels] and depths 1 / z [1/m] of the corners (K, 3, 3) of what is before the
        face, in the order of the triangles, and the item (K,) of each.
    """
    before = np.empty(len(triangles.item), dtype=np.int64)
    count = 0
    for t in range(len(triangles.item)):
        item = triangles.item[t]
        away = vector(triangles.away[item])
        if not _is_before(triangles.ball[t], away, view):
            continue
        if triangles.closed[item]:
            a = add(vector(triangles.corners[t, 0]), away)
            b = add(vector(triangles.corners[t, 1]), away)
            c = add(vector(triangles.corners[t, 2]), away)
            if dot(a, cross(b, c)) > 0.0:
                continue
        before[count] = t
        count += 1
    scratch = np.empty((3, 4))
    pixels = np.empty((2 * count, 3, 3))
    items = np.empty(2 * count, dtype=np.int64)
    pieces = 0
    for t in before[:count]:
        added = _project(triangles, t, view, 0.5 * n, scratch, pixels[pieces : pieces + 2])
        items[pieces : pieces + added] = triangles.item[t]
        pieces += added
    return pixels[:pieces], items[:pieces]


@njit(cache=True)
def _project(
    triangles: Triangles, t: int, view: Floats, half: float, scratch: Floats, out: Floats
) -> int:
    """Write the pieces of triangle t, up to 2 of (2, 3, 3), and return how many there are.

    scratch (3, 4): overwritten with the corners in the view, and how far they are behind the plane.
    """
    turned = scratch[:, :3]
    height = scratch[:, 3]
    behind = 0
    for k in range(3):
        point = add(vector(triangles.corners[t, k]), vector(triangles.away[triangles.item[t]]))
        for axis in range(3):
            turned[k, axis] = dot(vector(view[axis]), point)
        height[k] = _NEAREST - turned[k, 2]
        behind += 1 if height[k] > 0.0 else 0
    if behind == 0:
        for k in range(3):
            _write(vector(turned[k]), half, out[0, k])
        return 1
    if behind == 3:
        return 0
    alone = 0  # the corner that is on its side of the plane by itself
    for k in range(3):
        if (height[k] > 0.0) == (behind == 1):
            alone = k
    left = (alone + 1) % 3
    right = (alone + 2) % 3
    apex = vector(turned[alone])
    left_cut = _between(apex, vector(turned[left]), height[alone], height[left])
    right_cut = _between(apex, vector(turned[right]), height[alone], height[right])
    if behind == 2:
        _write(apex, half, out[0, 0])
        _write(left_cut, half, out[0, 1])
        _write(right_cut, half, out[0, 2])
        return 1
    _write(left_cut, half, out[0, 0])
    _write(vector(turned[left]), half, out[0, 1])
    _write(vector(turned[right]), half, out[0, 2])
    _write(left_cut, half, out[1, 0])
    _write(vector(turned[right]), half, out[1, 1])
    _write(right_cut, half, out[1, 2])
    return 2
