"""Find where the surface of a union of balls lies deep under a closed mesh.

The exposed surface is proved patch by patch: a patch that cannot be decided is cut into four.
"""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit
from workbench.geometry.nearest import nearest_triangle

__all__ = ["uncovered_patches"]

_MAX_STACK = 96
"""Patches that wait: 20, and three more for each of at most 25 cuts."""
_UNDECIDED = 0
"""What becomes of a patch: it is cut, dropped or reported."""
_DONE = 1
_REPORTED = 2


@njit(cache=True)
def _overlapping(a, centre, radius, near):  # type: ignore[no-untyped-def]
    """Fill `near` with the balls that overlap ball a, the largest overlap first; returns how many."""
    count = 0
    deep = np.empty(len(radius))
    for b in range(len(radius)):
        u = centre[b, 0] - centre[a, 0]
        v = centre[b, 1] - centre[a, 1]
        w = centre[b, 2] - centre[a, 2]
        gap = math.sqrt(u * u + v * v + w * w) - radius[b]
        if b != a and gap < radius[a]:
            near[count] = b
            deep[count] = gap
            count += 1
    near[:count] = near[:count][np.argsort(deep[:count], kind="mergesort")]
    return count


@njit(cache=True)
def _patch(corner, c, r, middle):  # type: ignore[no-untyped-def]
    """Compute the middle of a spherical triangle of a ball.

    Parameters
    ----------
    corner
        (3, 3) unit vectors.
    c, r
        Centre (3,) and radius of the ball [m].
    middle
        (3,) filled in place [m].

    Returns
    -------
    float
        Distance [m] of the farthest corner from the middle.
    """
    x = corner[0, 0] + corner[1, 0] + corner[2, 0]
    y = corner[0, 1] + corner[1, 1] + corner[2, 1]
    z = corner[0, 2] + corner[1, 2] + corner[2, 2]
    long = math.sqrt(x * x + y * y + z * z)
    x = x / long
    y = y / long
    z = z / long
    far = 0.0
    for k in range(3):
        far = max(far, (corner[k, 0] - x) ** 2 + (corner[k, 1] - y) ** 2 + (corner[k, 2] - z) ** 2)
    middle[0] = c[0] + r * x
    middle[1] = c[1] + r * y
    middle[2] = c[2] + r * z
    return r * math.sqrt(far)


@njit(cache=True)
def _buried(p, reach, near, count, centre, radius):  # type: ignore[no-untyped-def]
    """Return 2 where one of the other balls holds all within `reach` of p, 1 where one holds p.

    Else 0. near, count: the other balls (m,), and how many they are.
    """
    held = 0
    for k in range(count):
        b = near[k]
        u = p[0] - centre[b, 0]
        v = p[1] - centre[b, 1]
        w = p[2] - centre[b, 2]
        square = u * u + v * v + w * w
        inner = radius[b] - reach
        if inner > 0.0 and square <= inner * inner:
            return 2
        if square < radius[b] * radius[b]:
            held = 1
    return held


@njit(cache=True)
def _quarter(stack, size):  # type: ignore[no-untyped-def]
    """Replace the top patch of a stack (K, 3, 3) by its four quarters; returns the new size."""
    a = stack[size - 1].copy()
    m = np.empty((3, 3))
    for k in range(3):
        long = 0.0
        for x in range(3):
            m[k, x] = a[k, x] + a[(k + 1) % 3, x]
            long += m[k, x] * m[k, x]
        m[k] /= math.sqrt(long)
    for k in range(3):
        stack[size - 1 + k, 0] = a[k]
        stack[size - 1 + k, 1] = m[k]
        stack[size - 1 + k, 2] = m[(k + 2) % 3]
    stack[size + 2] = m
    return size + 3


@njit(cache=True)
def _signed_depth(p, solid, hint):  # type: ignore[no-untyped-def]
    """Return how deep [m] point p lies under the mesh, and the nearest triangle.

    hint: a triangle that may be near, -1 for none.
    """
    square, nearest, feature, x, y, z = nearest_triangle(
        p[0], p[1], p[2], solid, hint, np.inf, False
    )
    n = solid.normal[nearest, feature]
    outside = (p[0] - x) * n[0] + (p[1] - y) * n[1] + (p[2] - z) * n[2] >= 0.0
    return -math.sqrt(square) if outside else math.sqrt(square), nearest


@njit(cache=True)
def _examine(p, reach, held, solid, inward, fine, hint):  # type: ignore[no-untyped-def]
    """Decide about a patch: its middle p, how far it reaches from there, and `held` of `_buried`.

    Returns `_DONE`, `_REPORTED` or `_UNDECIDED`; a bound for its depth [m]; and a triangle near it.
    """
    # no point of the patch is deeper than its middle by more than `reach`
    room = inward - reach
    if room > 0.0:
        _, hit, _, _, _, _ = nearest_triangle(p[0], p[1], p[2], solid, hint, room * room, True)
        if hit >= 0:
            return _DONE, 0.0, hit
    is_exposed = held == 0
    if reach > fine and not (is_exposed and room > 0.0):
        return _UNDECIDED, 0.0, hint
    depth, hint = _signed_depth(p, solid, hint)
    if is_exposed and depth > inward:
        return _REPORTED, depth, hint
    if depth + reach <= inward:
        return _DONE, 0.0, hint
    if reach <= fine:
        return _REPORTED, depth + reach, hint
    return _UNDECIDED, 0.0, hint


@njit(cache=True)
def uncovered_patches(centre, radius, first, solid, inward, fine, most, points, depth):  # type: ignore[no-untyped-def]
    """Find places on a union of balls that are not proved to lie at most `inward` under a mesh.

    A patch of a ball is dropped where another ball holds it, or where the mesh is near enough to
    its middle. It is reported where its middle is exposed and deeper, or where it is no larger than
    `fine`. Any other patch is cut into four.

    Parameters
    ----------
    centre, radius
        (m, 3) and (m,) the balls [m].
    first
        (20, 3, 3) unit patches of a sphere.
    solid
        The mesh.
    inward, fine
        [m].
    most
        Places for each ball at most.
    points, depth
        (k, 3) and (k,) [m] filled with the places, and with bounds for how deep they are.

    Returns
    -------
    int
        Number of places.
    """
    near = np.empty(len(radius), np.int64)
    stack = np.empty((_MAX_STACK, 3, 3))
    p = np.empty(3)
    used = 0
    hint = -1
    for a in range(len(radius)):
        count = _overlapping(a, centre, radius, near)
        found = 0
        size = len(first)
        stack[:size] = first
        while size > 0 and found < most and used < len(depth):
            reach = _patch(stack[size - 1], centre[a], radius[a], p)
            held = _buried(p, reach, near, count, centre, radius)
            if held == 2:
                size -= 1
                continue
            verdict, deep, hint = _examine(p, reach, held, solid, inward, fine, hint)
            if verdict == _UNDECIDED:
                size = _quarter(stack, size)
                continue
            size -= 1
            if verdict == _REPORTED:
                points[used] = p
                depth[used] = deep
                used += 1
                found += 1
    return used
