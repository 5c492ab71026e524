"""Measure volumes of a closed mesh, of a union of balls, and of their intersection, by lines.

The lines are parallel to z, through the middles of the squares of a grid. The lengths inside are
exact along each line; only the spacing of the lines is an approximation.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit

__all__ = ["shared_volume"]

_OFFSET = 0.381966
"""Cells of the grid before the shapes. It is no simple fraction, so that lines rarely meet
edges."""


class _Lines(NamedTuple):
    """A grid of lines parallel to z; line i rows + j is at low + (i, j) pitch."""

    x: float
    """Position of the first line [m]."""
    y: float
    columns: int
    rows: int
    pitch: float
    """[m] between lines."""


def shared_volume(
    corners: NDArray[np.float64],
    centre: NDArray[np.float64],
    radius: NDArray[np.float64],
    pitch: float,
) -> tuple[float, float, float]:
    """Measure the volumes of a mesh, of a union of balls, and of their intersection.

    Parameters
    ----------
    corners
        (T, 3, 3) triangles of a closed mesh, wound outward [m].
    centre, radius
        (m, 3) and (m,) the balls [m].
    pitch
        Distance [m] between lines.

    Returns
    -------
    tuple[float, float, float]
        [m^3].
    """
    lines = _lines_around(corners, centre, radius, pitch)
    # first count what each line meets, then fill lists of that size
    nothing = np.empty((0, 2))
    count = np.zeros((2, lines.columns * lines.rows), dtype=np.int64)
    _cross_triangles(corners, lines, False, count[0], nothing)
    _cross_balls(centre, radius, lines, False, count[1], nothing)
    start = np.zeros((2, count.shape[1] + 1), dtype=np.int64)
    start[:, 1:] = np.cumsum(count, axis=1)
    crossings = np.empty((int(start[0, -1]), 2))
    spans = np.empty((int(start[1, -1]), 2))
    next_free = start[:, :-1].copy()
    _cross_triangles(corners, lines, True, next_free[0], crossings)
    _cross_balls(centre, radius, lines, True, next_free[1], spans)
    mesh, union, both = _lengths(start, crossings, spans)
    area = pitch * pitch
    return mesh * area, union * area, both * area


def _lines_around(
    corners: NDArray[np.float64],
    centre: NDArray[np.float64],
    radius: NDArray[np.float64],
    pitch: float,
) -> _Lines:
    """Return lines around a mesh and balls, as of `shared_volume`."""
    balls_low = (centre - radius[:, None]).min(axis=0)
    balls_high = (centre + radius[:, None]).max(axis=0)
    low = np.minimum(corners.min(axis=(0, 1)), balls_low)[:2] - pitch * _OFFSET
    high = np.maximum(corners.max(axis=(0, 1)), balls_high)[:2]
    size = np.ceil((high - low) / pitch).astype(np.int64) + 1
    return _Lines(float(low[0]), float(low[1]), int(size[0]), int(size[1]), pitch)


@njit(cache=True)
def _first_line(low: float, origin: float, pitch: float) -> int:
    """Return the first column or row of lines that is not below `low`."""
    return max(0, math.ceil((low - origin) / pitch))


@njit(cache=True)
def _last_line(high: float, origin: float, pitch: float, count: int) -> int:
    """Return the last of `count` columns or rows of lines that is not above `high`."""
    return min(count - 1, math.floor((high - origin) / pitch))


@njit(cache=True)
def _doubled_area(c):  # type: ignore[no-untyped-def]
    """Return twice the area of a triangle (3, 3) seen along z, positive if it faces up."""
    ux = c[1, 0] - c[0, 0]
    uy = c[1, 1] - c[0, 1]
    vx = c[2, 0] - c[0, 0]
    vy = c[2, 1] - c[0, 1]
    return ux * vy - uy * vx


@njit(cache=True)
def _barycentric(c, x, y, area):  # type: ignore[no-untyped-def]
    """Return the weights of corners 1 and 2 of a triangle at (x, y), by Cramer's rule."""
    px = x - c[0, 0]
    py = y - c[0, 1]
    a = (px * (c[2, 1] - c[0, 1]) - py * (c[2, 0] - c[0, 0])) / area
    b = ((c[1, 0] - c[0, 0]) * py - (c[1, 1] - c[0, 1]) * px) / area
    return a, b


@njit(cache=True)
def _cross_triangles(corners, lines, fill, next_free, crossings):  # type: ignore[no-untyped-def]
    """Find where the lines cross triangles.

    Parameters
    ----------
    corners, lines
        (T, 3, 3) and the lines.
    fill
        Whether `crossings` is filled; else they are counted.
    next_free
        (L,) the next free row of each line, counted up.
    crossings
        (K, 2) height [m], and 1 where the line enters the solid, -1 where it leaves it.
    """
    for t in range(len(corners)):
        c = corners[t]
        area = _doubled_area(c)
        if area == 0.0:
            continue
        first = _first_line(c[:, 0].min(), lines.x, lines.pitch)
        last = _last_line(c[:, 0].max(), lines.x, lines.pitch, lines.columns)
        bottom = _first_line(c[:, 1].min(), lines.y, lines.pitch)
        top = _last_line(c[:, 1].max(), lines.y, lines.pitch, lines.rows)
        for i in range(first, last + 1):
            x = lines.x + i * lines.pitch
            for j in range(bottom, top + 1):
                a, b = _barycentric(c, x, lines.y + j * lines.pitch, area)
                if a < 0.0 or b < 0.0 or a + b > 1.0:
                    continue
                line = i * lines.rows + j
                if fill:
                    height = c[0, 2] + a * (c[1, 2] - c[0, 2]) + b * (c[2, 2] - c[0, 2])
                    crossings[next_free[line], 0] = height
                    crossings[next_free[line], 1] = -1.0 if area > 0.0 else 1.0
                next_free[line] += 1


@njit(cache=True)
def _cross_balls(centre, radius, lines, fill, next_free, spans):  # type: ignore[no-untyped-def]
    """Find where the lines run inside balls: spans (K, 2) from and to [m].

    Other arguments as for `_cross_triangles`.
    """
    for s in range(len(radius)):
        first = _first_line(centre[s, 0] - radius[s], lines.x, lines.pitch)
        last = _last_line(centre[s, 0] + radius[s], lines.x, lines.pitch, lines.columns)
        for i in range(first, last + 1):
            dx = lines.x + i * lines.pitch - centre[s, 0]
            for j in range(lines.rows):
                dy = lines.y + j * lines.pitch - centre[s, 1]
                square = radius[s] * radius[s] - dx * dx - dy * dy
                if square <= 0.0:
                    continue
                line = i * lines.rows + j
                if fill:
                    half = math.sqrt(square)
                    spans[next_free[line], 0] = centre[s, 2] - half
                    spans[next_free[line], 1] = centre[s, 2] + half
                next_free[line] += 1


@njit(cache=True)
def _events_of(crossings, spans, height, winding, depth):  # type: ignore[no-untyped-def]
    """Fill in what happens along a line.

    height: where; winding and depth: by how much the number of times that the line is in the mesh,
    and the number of balls that it is in, change there.
    """
    count = 0
    for k in range(len(crossings)):
        height[count] = crossings[k, 0]
        winding[count] = crossings[k, 1]
        depth[count] = 0.0
        count += 1
    for k in range(len(spans)):
        for end in range(2):
            height[count] = spans[k, end]
            winding[count] = 0.0
            depth[count] = 1.0 - 2.0 * end
            count += 1


@njit(cache=True)
def _lengths(start, crossings, spans):  # type: ignore[no-untyped-def]
    """Sum the lengths [m] of all lines inside the mesh, inside the union, and inside both.

    start (2, L + 1): where the crossings and the spans of each line start.
    """
    mesh = 0.0
    union = 0.0
    both = 0.0
    for line in range(start.shape[1] - 1):
        crossed = crossings[start[0, line] : start[0, line + 1]]
        inside = spans[start[1, line] : start[1, line + 1]]
        count = len(crossed) + 2 * len(inside)
        if count == 0:
            continue
        height = np.empty(count)
        winding = np.empty(count)
        depth = np.empty(count)
        _events_of(crossed, inside, height, winding, depth)
        in_mesh = 0.0
        in_balls = 0.0
        before = 0.0
        for e in np.argsort(height, kind="mergesort"):
            length = height[e] - before
            if in_mesh > 0.5:
                mesh += length
            if in_balls > 0.5:
                union += length
                if in_mesh > 0.5:
                    both += length
            before = height[e]
            in_mesh += winding[e]
            in_balls += depth[e]
    return mesh, union, both
