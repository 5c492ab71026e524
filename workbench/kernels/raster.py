"""Filling spheres and triangles into depth buffers. Pixel centres lie at half-integers; rows run down.

Depth is in metres and larger is nearer. Every loop writes into arrays that the caller has filled with the
background, visits rows top to bottom and pixels left to right, and is deterministic to the bit.
"""

from __future__ import annotations

import math

from numba import njit

from workbench.kernels.frames import disk_span
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["fill_triangles", "sphere_depths"]


@njit(cache=True)
def sphere_depths(disks: Floats, centre: Floats, radius: Floats, depth: Floats) -> None:
    """Depth [m] of the foremost sphere surface in every pixel; `depth` (height, width) starts at the background.

    disks (S, 3): x, y, radius [pixels]; centre (S,), radius (S,): depth of the centre and true radius [m].
    """
    height, width = depth.shape
    for sphere in range(len(disks)):
        x, y, size = disks[sphere, 0], disks[sphere, 1], disks[sphere, 2]
        metre = radius[sphere] / size
        for row in range(max(0, math.floor(y - size - 0.5)), min(height, math.ceil(y + size + 0.5))):
            first, end = disk_span(row, x, y, size, width)
            dy = row + 0.5 - y
            for column in range(first, end):
                dx = column + 0.5 - x
                front = centre[sphere] + metre * math.sqrt(max(0.0, size * size - dx * dx - dy * dy))
                if front > depth[row, column]:
                    depth[row, column] = front


@njit(cache=True)
def _triangle_span(row: int, corner: Floats, turn: float, width: int) -> tuple[int, int]:
    """First and one past the last column whose centre is in the triangle; its edges belong to it."""
    low, high = 0.5, width - 0.5
    y = row + 0.5
    for k in range(3):
        ax, ay = corner[k, 0], corner[k, 1]
        dx, dy = corner[(k + 1) % 3, 0] - ax, corner[(k + 1) % 3, 1] - ay
        # inside: turn * (dx * (y - ay) - dy * (x - ax)) >= 0
        level = dx * (y - ay) * turn
        slope = dy * turn
        if slope == 0.0:
            if level < 0.0:
                return 0, 0
        elif slope > 0.0:
            high = min(high, ax + level / slope)
        else:
            low = max(low, ax + level / slope)
    first, end = math.ceil(low - 0.5), math.floor(high - 0.5) + 1
    return first, max(end, first)


@njit(cache=True)
def fill_triangles(
    corners: Floats, number: Ints, bend: float, cut: float, depth: Floats, ids: Ints, was_cut: Bools
) -> None:
    """Depth buffer of triangles `corners` (T, 3, 3): x, y [pixels], projective depth Z; on a tie the first one stays.

    Z changes linearly across the picture; the depth [m] is Z / (1 + bend Z), with bend 0 in a parallel view.

    ids receives the foremost triangle's `number` (T,). Fragments nearer than `cut` [m] are left out and noted in
    `was_cut`. depth, ids, was_cut: (height, width).
    """
    height, width = depth.shape
    for triangle in range(len(corners)):
        corner = corners[triangle]
        ux, uy, uz = corner[1, 0] - corner[0, 0], corner[1, 1] - corner[0, 1], corner[1, 2] - corner[0, 2]
        vx, vy, vz = corner[2, 0] - corner[0, 0], corner[2, 1] - corner[0, 1], corner[2, 2] - corner[0, 2]
        area = ux * vy - uy * vx
        if abs(area) < 1e-12:  # seen edge-on: it covers nothing
            continue
        slope_x, slope_y = (uz * vy - vz * uy) / area, (vz * ux - uz * vx) / area
        nearest = max(corner[0, 2], corner[1, 2], corner[2, 2])
        farthest = min(corner[0, 2], corner[1, 2], corner[2, 2])
        top = min(corner[0, 1], corner[1, 1], corner[2, 1])
        bottom = max(corner[0, 1], corner[1, 1], corner[2, 1])
        turn = 1.0 if area > 0.0 else -1.0
        for row in range(max(0, math.floor(top)), min(height, math.ceil(bottom))):
            first, end = _triangle_span(row, corner, turn, width)
            base = corner[0, 2] + slope_y * (row + 0.5 - corner[0, 1])
            for column in range(first, end):
                front = base + slope_x * (column + 0.5 - corner[0, 0])
                front = min(max(front, farthest), nearest)  # slivers: never beyond the corners
                front /= 1.0 + bend * front
                if front > cut:
                    was_cut[row, column] = True
                elif front > depth[row, column]:
                    depth[row, column] = front
                    ids[row, column] = number[triangle]
