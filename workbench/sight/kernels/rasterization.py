"""Rasterize triangles into depth buffers.

Pixel centres lie at half-integers; rows run down. Depth is in metres and larger is nearer. Every
loop writes into arrays that the caller has filled with the background, visits rows top to bottom
and pixels left to right, and is deterministic to the bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["MIN_AREA", "Fragments", "fill_triangles"]

MIN_AREA = 1e-12
"""Twice the area [pixels^2] of a triangle in the picture below which it is seen edge-on."""


class _EdgeBound(NamedTuple):
    """An edge of a triangle as a bound on the pixels of a row: x = offset + slope y."""

    offset: float
    slope: float
    side: float
    """1 for a bound on the right, -1 on the left, 0 for a level edge."""
    y: float
    """For a level edge: its height, and the inside is where level (row - y) >= 0."""
    level: float


class _Triangle(NamedTuple):
    """A triangle to be filled: its edges and its depth, Z = depth + slope_x x + slope_y y."""

    first: _EdgeBound
    second: _EdgeBound
    third: _EdgeBound
    x: float
    """x, y [pixels] and Z of the corner from which Z is measured."""
    y: float
    depth: float
    slope_x: float
    """Change of Z per pixel right and down."""
    slope_y: float
    nearest: float
    """Largest and smallest Z of the corners."""
    farthest: float


class Fragments(NamedTuple):
    """Images (height, width) that triangles are written into."""

    depth: Floats
    """Depth [m] of the foremost triangle."""
    number: NDArray[np.int32]
    """Its number."""
    was_cut: Bools
    """Whether anything was dropped there by the near plane."""
    first: int = 0
    """The row of the whole picture that is their first one."""


@njit(cache=True)
def _edge_bound(ax: float, ay: float, bx: float, by: float, turn: float) -> _EdgeBound:
    """Return the bound of the edge from a to b; turn: 1 or -1, the sign of the triangle's area."""
    dx = bx - ax
    dy = by - ay
    if dy == 0.0:
        return _EdgeBound(ax, 0.0, 0.0, ay, dx * turn)
    return _EdgeBound(ax - dx / dy * ay, dx / dy, 1.0 if dy * turn > 0.0 else -1.0, ay, 0.0)


@njit(cache=True, error_model="numpy", forceinline=True)
def _clip_row(edge: _EdgeBound, y: float, low: float, high: float) -> tuple[float, float]:
    """Clip the run from low to high in the row at y by an edge; low > high for nothing."""
    if edge.side == 0.0:
        return (low, high) if edge.level * (y - edge.y) >= 0.0 else (1.0, 0.0)
    x = edge.offset + edge.slope * y
    return (low, min(high, x)) if edge.side > 0.0 else (max(low, x), high)


@njit(cache=True)
def _prepare(corners: Floats, t: int, area: float) -> _Triangle:
    """Prepare triangle t of corners (T, 3, 3); area: twice its signed area [pixels^2]."""
    ax = corners[t, 0, 0]
    ay = corners[t, 0, 1]
    az = corners[t, 0, 2]
    bx = corners[t, 1, 0]
    by = corners[t, 1, 1]
    bz = corners[t, 1, 2]
    cx = corners[t, 2, 0]
    cy = corners[t, 2, 1]
    cz = corners[t, 2, 2]
    turn = 1.0 if area > 0.0 else -1.0
    return _Triangle(
        _edge_bound(ax, ay, bx, by, turn),
        _edge_bound(bx, by, cx, cy, turn),
        _edge_bound(cx, cy, ax, ay, turn),
        ax,
        ay,
        az,
        ((bz - az) * (cy - ay) - (cz - az) * (by - ay)) / area,
        ((cz - az) * (bx - ax) - (bz - az) * (cx - ax)) / area,
        max(az, bz, cz),
        min(az, bz, cz),
    )


@njit(cache=True)
def _twice_area(corners: Floats, t: int) -> float:
    """Return twice the signed area [pixels^2] of triangle t of corners (T, 3, 3)."""
    x = corners[t, 0, 0]
    y = corners[t, 0, 1]
    return (corners[t, 1, 0] - x) * (corners[t, 2, 1] - y) - (corners[t, 1, 1] - y) * (
        corners[t, 2, 0] - x
    )


@njit(cache=True, error_model="numpy", forceinline=True)
def _fill_row(
    triangle: _Triangle, number: int, row: int, bend: float, cut: float, out: Fragments
) -> None:
    """Fill the pixels of a row with a triangle; arguments as for `fill_triangles`."""
    depth = out.depth
    numbers = out.number
    was_cut = out.was_cut
    y = out.first + row + 0.5
    low, high = _clip_row(triangle.first, y, 0.5, depth.shape[1] - 0.5)
    low, high = _clip_row(triangle.second, y, low, high)
    low, high = _clip_row(triangle.third, y, low, high)
    base = triangle.depth + triangle.slope_y * (y - triangle.y)
    first = math.ceil(low - 0.5)
    end = max(math.floor(high - 0.5) + 1, first)
    if bend == 0.0 and cut == math.inf:
        line = depth[row, first:end]
        names = numbers[row, first:end]
        for k in range(len(line)):  # a slice from 0, without branches: four pixels at once
            front = base + triangle.slope_x * (first + k + 0.5 - triangle.x)
            front = min(max(front, triangle.farthest), triangle.nearest)
            better = front > line[k]
            line[k] = front if better else line[k]
            names[k] = number if better else names[k]
        return
    for column in range(first, end):
        front = base + triangle.slope_x * (column + 0.5 - triangle.x)
        # slivers: never beyond the corners
        front = min(max(front, triangle.farthest), triangle.nearest)
        if bend != 0.0:
            front /= 1.0 + bend * front
        if front > cut:
            was_cut[row, column] = True
        elif front > depth[row, column]:
            depth[row, column] = front
            numbers[row, column] = number


@njit(cache=True)
def fill_triangles(corners: Floats, number: Ints, bend: float, cut: float, out: Fragments) -> None:
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
        Depth [m] of the near plane; nearer fragments are dropped and noted in `out.was_cut`.
    out
        Filled in place.
    """
    height, width = out.depth.shape
    for t in range(len(corners)):
        ax = corners[t, 0, 0]
        bx = corners[t, 1, 0]
        cx = corners[t, 2, 0]
        ay = corners[t, 0, 1]
        by = corners[t, 1, 1]
        cy = corners[t, 2, 1]
        top = max(math.ceil(min(ay, by, cy) - 0.5) - out.first, 0)
        bottom = min(math.floor(max(ay, by, cy) - 0.5) - out.first, height - 1)
        if top > bottom or max(ax, bx, cx) < 0.5 or min(ax, bx, cx) > width - 0.5:
            continue
        area = _twice_area(corners, t)
        if abs(area) < MIN_AREA:  # seen edge-on: it covers nothing
            continue
        triangle = _prepare(corners, t, area)
        for row in range(top, bottom + 1):
            _fill_row(triangle, number[t], row, bend, cut, out)
