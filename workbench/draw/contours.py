"""Trace contour lines of values that are known at scattered points of a plane.

The values are spread over a grid by Nadaraya-Watson kernel regression [1]_ [2]_; contourpy traces
the lines.

References
----------
.. [1] E. A. Nadaraya (1964), On estimating regression, Theory of Probability and Its Applications
   9, 141-142.
.. [2] G. S. Watson (1964), Smooth regression analysis, Sankhya A 26, 359-372.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from contourpy import FillType, contour_generator

from workbench.model.arrays import Floats

__all__ = ["kernel_regression", "level_loops", "median_spacing"]

_BATCH_SIZE = 2_000_000
"""Distances computed at once, which bounds the memory."""


def _squared_distances(points: Floats, others: Floats) -> Iterator[tuple[int, Floats]]:
    """Yield, batch by batch, the first row and (N, M) squared distances of points to others."""
    step = max(1, _BATCH_SIZE // len(others))
    for begin in range(0, len(points), step):
        difference = points[begin : begin + step, None] - others[None]
        yield begin, (difference**2).sum(axis=2)


def kernel_regression(points: Floats, values: Floats, places: Floats, *, width: float) -> Floats:
    """Interpolate scattered values by a mean with weights exp(-d^2 / 2 width^2).

    Far from all points the result is the value of the nearest one.

    Parameters
    ----------
    points, values
        (M, 2) and (M,), M at least 1.
    places
        (Q, 2) where values are wanted.
    width
        Standard deviation of the kernel, in the unit of the points.

    Returns
    -------
    Floats
        (Q,) values.
    """
    result = np.empty(len(places))
    for begin, squared in _squared_distances(places, points):
        exponent = squared / (2 * width**2)
        weight = np.exp(exponent.min(axis=1, keepdims=True) - exponent)
        result[begin : begin + len(weight)] = (weight @ values) / weight.sum(axis=1)
    return result


def median_spacing(points: Floats) -> float:
    """Return the median distance from a point (M, 2) to its nearest neighbour; M at least 2."""
    nearest = np.empty(len(points))
    for begin, squared in _squared_distances(points, points):
        rows = np.arange(len(squared))
        squared[rows, begin + rows] = np.inf
        nearest[begin + rows] = squared.min(axis=1)
    return float(np.sqrt(np.median(nearest)))


def level_loops(field: Floats, level: float) -> list[Floats]:
    """Trace the closed loops around where a field is at least `level`.

    Between grid points the field is linear along the sides of cells. A loop that reaches the border
    is closed half a cell beyond it.

    Parameters
    ----------
    field
        (R, C) values at the grid's points.
    level
        The value to trace.

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
