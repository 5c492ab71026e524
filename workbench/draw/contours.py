"""Contour lines of values known at scattered points of a plane: spread over a grid, then traced.

The spreading is the weighted mean of Nadaraya (1964) and Watson (1964) with a normal kernel;
contourpy traces the lines.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from contourpy import FillType, contour_generator

from workbench.model.arrays import Floats

__all__ = ["kernel_regression", "level_loops", "median_spacing"]

_CHUNK = 2_000_000  # distances held at once


def kernel_regression(points: Floats, values: Floats, places: Floats, *, width: float) -> Floats:
    """Values (Q,) at places (Q, 2) from those (M,) known at points (M, 2): means weighted by
    exp(-d^2 / 2 width^2).

    Far from all points it is the value of the nearest. One point or more is needed; all lengths in
    one unit.
    """
    out = np.empty(len(places))
    step = max(1, _CHUNK // len(points))
    for begin in range(0, len(places), step):
        apart = places[begin : begin + step, None] - points[None]
        far = (apart**2).sum(axis=2) / (2 * width**2)
        weight = np.exp(far.min(axis=1, keepdims=True) - far)
        out[begin : begin + step] = (weight @ values) / weight.sum(axis=1)
    return out


def median_spacing(points: Floats) -> float:
    """The median distance from a point to its nearest neighbour; points (M, 2), two or more."""
    nearest = np.empty(len(points))
    step = max(1, _CHUNK // len(points))
    for begin in range(0, len(points), step):
        rows = np.arange(begin, min(begin + step, len(points)))
        far = ((points[rows, None] - points[None]) ** 2).sum(axis=2)
        far[np.arange(len(rows)), rows] = np.inf
        nearest[rows] = far.min(axis=1)
    return float(np.sqrt(np.median(nearest)))


def level_loops(field: Floats, level: float) -> list[Floats]:
    """Trace the closed loops around where a field is at least `level`.

    Between grid points the field is linear along the sides of cells. A loop that reaches the border
    is closed half a cell beyond it.

    Parameters
    ----------
    field
        (R, C) values at the grid's points.

    Returns
    -------
    list[Floats]
        Loops (K, 2) of row and column, the first point not repeated.
    """
    rows, columns = field.shape
    # the border's values go on for half a cell
    generator = contour_generator(
        x=np.concatenate([[-0.5], np.arange(columns), [columns - 0.5]]),
        y=np.concatenate([[-0.5], np.arange(rows), [rows - 0.5]]),
        z=np.pad(field, 1, mode="edge"),
        fill_type=FillType.OuterOffset,
    )
    outlines, offsets = generator.filled(level, np.inf)  # type: ignore[misc]  # of OuterOffset
    loops = []
    for points, ends in zip(outlines, offsets, strict=True):
        loops += [points[low : high - 1, ::-1] for low, high in pairwise(ends.tolist())]
    return loops
