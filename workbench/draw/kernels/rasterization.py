"""Filling spheres and triangles into depth buffers. Pixel centres lie at half-integers; rows run
down.

Depth is in metres and larger is nearer. Every loop writes into arrays that the caller has filled
with the background, visits rows top to bottom and pixels left to right, and is deterministic to the
bit.
"""

from __future__ import annotations

import math

from workbench.compiled import njit
from workbench.draw.kernels.disk_painter import disk_span
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["fill_triangles", "sphere_depths"]


@njit(cache=True)
def sphere_depths(disks: Floats, centre: Floats, radius: Floats, depth: Floats) -> None:
    """Depth [m] of the foremost sphere surface in every pixel; `depth` (height, width) starts at
    the background.

    disks (S, 3): x, y, radius [pixels]; centre (S,), radius (S,): depth of the centre and true
    radius [m].
    """
    height, width = depth.shape
    for sphere in range(len(disks)):
        x = disks[sphere, 0]
        y = disks[sphere, 1]
        size = disks[sphere, 2]
        metre = radius[sphere] / size
        for row in range(
            max(0, math.floor(y - size - 0.5)), min(height, math.ceil(y + size + 0.5))
        ):
            first, end = disk_span(row, x, y, size, width)
            dy = row + 0.5 - y
            for column in range(first, end):
                dx = column + 0.5 - x
                front = centre[sphere] + metre * math.sqrt(
                    max(0.0, size * size - dx * dx - dy * dy)
                )
                if front > depth[row, column]:
                    depth[row, column] = front


@njit(cache=True)
def _edge(
    ax: float, ay: float, bx: float, by: float, turn: float
) -> tuple[float, float, float, float]:
    """An edge as a bound on a row's pixels: x = first + steep y; which bound (1 right, -1 left, 0
    level); and level."""
    dx = bx - ax
    dy = by - ay
    if dy == 0.0:
        return ax, 0.0, 0.0, dx * turn  # inside: level (y - ay) >= 0
    return ax - dx / dy * ay, dx / dy, 1.0 if dy * turn > 0.0 else -1.0, 0.0


@njit(cache=True)
def _bounded(
    edge: tuple[float, float, float, float], y: float, ay: float, low: float, high: float
) -> tuple[float, float]:
    """The run from low to high in the row at y cut by an edge whose first corner is at ay; low >
    high where none."""
    if edge[2] == 0.0:
        return (low, high) if edge[3] * (y - ay) >= 0.0 else (1.0, 0.0)
    place = edge[0] + edge[1] * y
    return (low, min(high, place)) if edge[2] > 0.0 else (max(low, place), high)


@njit(cache=True)
def fill_triangles(
    corners: Floats, number: Ints, bend: float, cut: float, depth: Floats, ids: Ints, was_cut: Bools
) -> None:
    """Depth buffer of triangles `corners` (T, 3, 3): x, y [pixels], projective depth Z; on a tie
    the first one stays.

    Z changes linearly across the picture; the depth [m] is Z / (1 + bend Z), with bend 0 in a
    parallel view. Pixels belong to a triangle where their middle is inside it or on its edge.

    ids receives the foremost triangle's `number` (T,). Fragments nearer than `cut` [m] are left out
    and noted in `was_cut`. depth, ids, was_cut: (height, width).
    """
    height, width = depth.shape
    for t in range(len(corners)):
        ax = corners[t, 0, 0]
        ay = corners[t, 0, 1]
        az = corners[t, 0, 2]
        bx = corners[t, 1, 0]
        by = corners[t, 1, 1]
        bz = corners[t, 1, 2]
        cx = corners[t, 2, 0]
        cy = corners[t, 2, 1]
        cz = corners[t, 2, 2]
        top = max(math.ceil(min(ay, by, cy) - 0.5), 0)
        bottom = min(math.floor(max(ay, by, cy) - 0.5), height - 1)
        if top > bottom or max(ax, bx, cx) < 0.5 or min(ax, bx, cx) > width - 0.5:
            continue
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if abs(area) < 1e-12:  # seen edge-on: it covers nothing
            continue
        slope_x = ((bz - az) * (cy - ay) - (cz - az) * (by - ay)) / area
        slope_y = ((cz - az) * (bx - ax) - (bz - az) * (cx - ax)) / area
        nearest = max(az, bz, cz)
        farthest = min(az, bz, cz)
        turn = 1.0 if area > 0.0 else -1.0
        first = _edge(ax, ay, bx, by, turn)
        second = _edge(bx, by, cx, cy, turn)
        third = _edge(cx, cy, ax, ay, turn)
        for row in range(top, bottom + 1):
            y = row + 0.5
            low, high = _bounded(first, y, ay, 0.5, width - 0.5)
            low, high = _bounded(second, y, by, low, high)
            low, high = _bounded(third, y, cy, low, high)
            base = az + slope_y * (y - ay)
            for column in range(math.ceil(low - 0.5), math.floor(high - 0.5) + 1):
                front = base + slope_x * (column + 0.5 - ax)
                front = min(max(front, farthest), nearest)  # slivers: never beyond the corners
                if bend != 0.0:
                    front /= 1.0 + bend * front
                if front > cut:
                    was_cut[row, column] = True
                elif front > depth[row, column]:
                    depth[row, column] = front
                    ids[row, column] = number[t]
