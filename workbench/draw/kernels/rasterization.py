"""Rasterize spheres and triangles into depth buffers.

Pixel centres lie at half-integers; rows run down. Depth is in metres and larger is nearer. Every
loop writes into arrays that the caller has filled with the background, visits rows top to bottom
and pixels left to right, and is deterministic to the bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from workbench.compiled import njit
from workbench.draw.kernels.disk_painter import disk_span
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["fill_triangles", "sphere_depths"]


@njit(cache=True)
def sphere_depths(disks: Floats, centre: Floats, radius: Floats, depth: Floats) -> None:
    """Rasterize spheres that are seen as disks.

    Parameters
    ----------
    disks
        (S, 3) x, y, radius [pixels].
    centre, radius
        (S,) depth of the centre and radius [m].
    depth
        (height, width) depth [m] of the foremost surface, filled in place.
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


class _EdgeBound(NamedTuple):
    """An edge of a triangle as a bound on the pixels of a row: x = offset + slope y."""

    offset: float
    slope: float
    side: float
    """1 for a bound on the right, -1 on the left, 0 for a level edge."""
    level: float
    """For a level edge: the inside is where level (y - y of the edge) >= 0."""


@njit(cache=True)
def _edge_bound(ax: float, ay: float, bx: float, by: float, turn: float) -> _EdgeBound:
    """Return the bound of the edge from a to b; turn: 1 or -1, the sign of the triangle's area."""
    dx = bx - ax
    dy = by - ay
    if dy == 0.0:
        return _EdgeBound(ax, 0.0, 0.0, dx * turn)
    return _EdgeBound(ax - dx / dy * ay, dx / dy, 1.0 if dy * turn > 0.0 else -1.0, 0.0)


@njit(cache=True)
def _clip_row(
    edge: _EdgeBound, y: float, ay: float, low: float, high: float
) -> tuple[float, float]:
    """Clip the run from low to high in the row at y by an edge from ay; low > high for nothing."""
    if edge.side == 0.0:
        return (low, high) if edge.level * (y - ay) >= 0.0 else (1.0, 0.0)
    x = edge.offset + edge.slope * y
    return (low, min(high, x)) if edge.side > 0.0 else (max(low, x), high)


@njit(cache=True)
def fill_triangles(
    corners: Floats, number: Ints, bend: float, cut: float, depth: Floats, ids: Ints, was_cut: Bools
) -> None:
    """Rasterize triangles with a depth test; of equal depths the first one stays.

    A pixel belongs to a triangle if its middle is inside it or on its edge. Projective depth Z is
    linear across the picture; the depth is Z / (1 + Z / D), D being the camera's distance.

    Parameters
    ----------
    corners
        (T, 3, 3) x, y [pixels] and projective depth Z.
    number
        (T,) the index that is written for each triangle.
    bend
        1 / D [1/m], 0 in a parallel view.
    cut
        Depth [m] of the near plane; nearer fragments are dropped and noted in `was_cut`.
    depth, ids, was_cut
        (height, width) filled in place.
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
        first = _edge_bound(ax, ay, bx, by, turn)
        second = _edge_bound(bx, by, cx, cy, turn)
        third = _edge_bound(cx, cy, ax, ay, turn)
        for row in range(top, bottom + 1):
            y = row + 0.5
            low, high = _clip_row(first, y, ay, 0.5, width - 0.5)
            low, high = _clip_row(second, y, by, low, high)
            low, high = _clip_row(third, y, cy, low, high)
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
