"""Patches of a union's exposed spheres that lie deep under a closed mesh: proved patch by patch,
cut where unproved."""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit
from workbench.geometry.nearest import nearest_triangle

__all__ = ["deep_patches"]


@njit(cache=True)
def _overlapping(a, centre, radius, near):  # type: ignore[no-untyped-def]
    """Write the balls that overlap ball a into near, largest overlap first; returns how many."""
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
    """Write the middle of a spherical triangle (3, 3: unit vectors) of a ball; returns how far its
    corners are."""
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
    """How p lies to the other balls: 2 where one of them holds all within reach of p, 1 where one
    holds p, 0 else."""
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
    """Replace the top patch of the stack by its four quarters; returns the new size."""
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
def deep_patches(centre, radius, first, solid, inward, fine, most, points, depth):  # type: ignore[no-untyped-def]
    """Places on the union of balls (m, 3), (m,) not proved to be at most `inward` [m] under the
    mesh.

    first (20, 3, 3): unit patches of a sphere. A patch is let go where another ball holds it, or
    where the mesh is near enough to its middle; it is reported where its middle is exposed and
    deeper, or where it is no larger than `fine` [m]. At most `most` places a ball; fills points (k,
    3) and depth (k,), a bound for what was looked at; returns how many.
    """
    near = np.empty(len(radius), np.int64)
    stack = np.empty((96, 3, 3))
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
            room = inward - reach
            if room > 0.0:
                _, hit, _, _, _, _ = nearest_triangle(
                    p[0], p[1], p[2], solid, hint, room * room, True
                )
                if hit >= 0:
                    hint = hit
                    size -= 1
                    continue
            if reach <= fine or (held == 0 and room > 0.0):
                square, hint, feature, x, y, z = nearest_triangle(
                    p[0], p[1], p[2], solid, hint, np.inf, False
                )
                n = solid.normal[hint, feature]
                outside = (p[0] - x) * n[0] + (p[1] - y) * n[1] + (p[2] - z) * n[2] >= 0.0
                deep = -math.sqrt(square) if outside else math.sqrt(square)
                sure = held == 0 and deep > inward
                if sure or (reach <= fine and deep + reach > inward):
                    points[used] = p
                    depth[used] = deep if sure else deep + reach
                    used += 1
                    found += 1
                    size -= 1
                    continue
                if deep + reach <= inward:
                    size -= 1
                    continue
            size = _quarter(stack, size)
    return used
