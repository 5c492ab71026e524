"""Compare a union of balls with many points: the nearest ball, coverage, and the largest gap to a mesh.

The field of one ball is f(p) = |p - c| - r, and that of the union is the least of them. Points are
in blocks of 32 that are near each other (`nearest.morton_order`). A ball that cannot touch a block
is not compared with its points.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit

__all__ = ["BLOCK", "block_bounds", "covered_by", "max_distance_bound", "nearest_ball"]

BLOCK = 32
"""Points in a block."""


def block_bounds(
    points: NDArray[np.float64], size: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the centre (B, 3) and radius (B,) [m] of a sphere around each run of `size` points (n, 3)."""
    start = np.arange(0, len(points), size)
    low = np.minimum.reduceat(points, start)
    high = np.maximum.reduceat(points, start)
    centre = 0.5 * (low + high)
    reach = np.linalg.norm(points - np.repeat(centre, size, axis=0)[: len(points)], axis=1)
    return centre, np.maximum.reduceat(reach, start) * (1.0 + 1e-12) + 1e-15


@njit(cache=True)
def _apart(a, b):  # type: ignore[no-untyped-def]
    """Distance of two points."""
    u = a[0] - b[0]
    v = a[1] - b[1]
    w = a[2] - b[2]
    return math.sqrt(u * u + v * v + w * w)


@njit(cache=True)
def _local(middle, reach, centre, radius, low, near):  # type: ignore[no-untyped-def]
    """Write the balls that may be the nearest anywhere within `reach` of a point into `near`.

    Fields change by no more than the distance moved, so these are the balls within 2 reach of the least
    field at the point. Returns their number.
    """
    best = np.inf
    for j in range(len(radius)):
        low[j] = _apart(middle, centre[j]) - radius[j]
        best = min(best, low[j])
    size = 0
    for j in range(len(radius)):
        if low[j] <= best + 2.0 * reach:
            near[size] = j
            size += 1
    return size


@njit(cache=True)
def nearest_ball(points, bounds, centre, radius, field, ball):  # type: ignore[no-untyped-def]
    """Compute the field of the union, and the ball that gives it.

    Parameters
    ----------
    points, bounds
        (n, 3) [m], and `block_bounds` of runs of BLOCK.
    centre, radius
        (m, 3) and (m,) [m].
    field, ball
        (n,) [m] and (n,), filled in place.
    """
    low = np.empty(len(radius))
    near = np.empty(len(radius), np.int64)
    for b in range(len(bounds[1])):
        size = _local(bounds[0][b], bounds[1][b], centre, radius, low, near)
        for i in range(b * BLOCK, min((b + 1) * BLOCK, len(points))):
            field[i] = np.inf
            for k in range(size):
                f = _apart(points[i], centre[near[k]]) - radius[near[k]]
                if f < field[i]:
                    field[i] = f
                    ball[i] = near[k]


@njit(cache=True)
def covered_by(points, margin, may, bounds, wide, centre, radius, bits):  # type: ignore[no-untyped-def]
    """Find the points that each ball covers: |p - c| <= r + margin(p), and may(p) & bits(ball) is not 0.

    Parameters
    ----------
    points, margin, may
        (n, 3) [m], (n,) [m] and (n,).
    bounds, wide
        `block_bounds` of runs of BLOCK and of BLOCK^2.
    centre, radius, bits
        (m, 3) [m], (m,) [m] and (m,).

    Returns
    -------
    tuple
        start (m + 1,) and item: ball j covers item[start[j]:start[j + 1]].
    """
    start = np.zeros(len(radius) + 1, np.int64)
    used = 0
    item = np.empty(max(1024, 64 * len(radius)), np.int32)
    most = margin.max() if len(margin) else 0.0
    for j in range(len(radius)):
        c = centre[j]
        reach = radius[j] + most
        for a in range(len(wide[1])):
            if _apart(wide[0][a], c) > reach + wide[1][a]:
                continue
            for b in range(a * BLOCK, min((a + 1) * BLOCK, len(bounds[1]))):
                if _apart(bounds[0][b], c) > reach + bounds[1][b]:
                    continue
                if used + BLOCK > len(item):
                    more = np.empty(2 * len(item), np.int32)
                    more[:used] = item[:used]
                    item = more
                for i in range(b * BLOCK, min((b + 1) * BLOCK, len(points))):
                    if _apart(points[i], c) <= radius[j] + margin[i] and may[i] & bits[j] != 0:
                        item[used] = i
                        used += 1
        start[j + 1] = used
    return start, item[:used]


@njit(cache=True)
def _over(corner, centre, radius, near, size):  # type: ignore[no-untyped-def]
    """Bound the largest gap on a triangle from above and below, and return where the lower bound is.

    The field of one ball is convex, so its greatest value on a triangle is at a corner: the least of
    these over the balls is an upper bound. The field of the union at the middle is a lower bound.
    """
    upper = np.inf
    lower = np.inf
    mx = (corner[0, 0] + corner[1, 0] + corner[2, 0]) / 3.0
    my = (corner[0, 1] + corner[1, 1] + corner[2, 1]) / 3.0
    mz = (corner[0, 2] + corner[1, 2] + corner[2, 2]) / 3.0
    for k in range(size):
        c = centre[near[k]]
        r = radius[near[k]]
        worst = max(_apart(corner[0], c), _apart(corner[1], c), _apart(corner[2], c)) - r
        upper = min(upper, worst)
        lower = min(lower, math.sqrt((mx - c[0]) ** 2 + (my - c[1]) ** 2 + (mz - c[2]) ** 2) - r)
    return upper, lower, mx, my, mz


@njit(cache=True)
def _split(stack, size):  # type: ignore[no-untyped-def]
    """Replace the top triangle of the stack by its four quarters, and return the new size."""
    a = stack[size - 1].copy()
    for k in range(3):
        for x in range(3):
            stack[size + 2, k, x] = 0.5 * (a[k, x] + a[(k + 1) % 3, x])
    middle = stack[size + 2].copy()
    for k in range(3):
        stack[size - 1 + k, 0] = a[k]
        stack[size - 1 + k, 1] = middle[k]
        stack[size - 1 + k, 2] = middle[(k + 2) % 3]
    return size + 3


@njit(cache=True)
def max_distance_bound(corners, centre, radius, floor, fine, points, gaps):  # type: ignore[no-untyped-def]
    """Bound how far triangles lie outside the union, by branch and bound.

    A triangle is done once its gap is proved to be at most `floor`, or its bounds are within `fine` of
    each other. Otherwise it is cut into quarters.

    Parameters
    ----------
    corners
        (T, 3, 3) [m].
    centre, radius
        (m, 3) and (m,) [m].
    floor, fine
        [m].
    points, gaps
        (T, 3) the worst point found on each triangle, and (T, 2) its gap and the proved bound [m],
        filled in place.
    """
    low = np.empty(len(radius))
    near = np.empty(len(radius), np.int64)
    stack = np.empty((128, 3, 3))
    for t in range(len(corners)):
        middle = (corners[t, 0] + corners[t, 1] + corners[t, 2]) / 3.0
        reach = max(
            _apart(corners[t, 0], middle),
            _apart(corners[t, 1], middle),
            _apart(corners[t, 2], middle),
        )
        held = _local(middle, reach, centre, radius, low, near)
        gaps[t, 0] = gaps[t, 1] = -np.inf
        stack[0] = corners[t]
        size = 1
        while size > 0:
            upper, lower, x, y, z = _over(stack[size - 1], centre, radius, near, held)
            if lower > gaps[t, 0]:
                gaps[t, 0] = lower
                points[t, 0] = x
                points[t, 1] = y
                points[t, 2] = z
            if upper <= max(floor, gaps[t, 0]) + fine or size > 120:
                gaps[t, 1] = max(gaps[t, 1], upper)
                size -= 1
            else:
                size = _split(stack, size)
