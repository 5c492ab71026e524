"""Find what flat triangles hide of curves, in closed form.

Triangles and curves are in picture space: x right, y down [pixels] and projective depth w, larger
nearer. Planes are planes and straight lines are straight there, in a parallel view and in
perspective. A triangle hides a point p that lies inside its three sides and behind its plane: where
four functions

    f(p) = a x + b y + c w + d

are all at least 0. Along a rational Bezier curve of the second order (a straight line, or an arc of
an ellipse of less than half a turn) each of them has the sign of

    f(s) = f0 (1 - s)^2 + 2 f1 s (1 - s) + f2 s^2,    s from 0 to 1,

with f0, f1, f2 the function at the control points in homogeneous coordinates. It changes its sign
twice at most, and not at all where the three have one sign. What no triangle hides is visible;
there is no depth buffer.

Triangles are found by a grid of square cells: all that meet a cell that the box of a curve meets.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.compiled import njit
from workbench.model.arrays import Floats, Ints

__all__ = ["Occluders", "hidden_spans"]

_HAIR = 1e-6
"""Widening [pixels] of what is sought in the grid, more than any rounding of a point's cell."""
_ROUNDING = 1e-8
"""[pixels, m] What is no farther from a side is on it, and hidden: lines that coincide in the
picture are drawn once."""


class Occluders(NamedTuple):
    """T triangles that hide, and a grid of square cells to find them in."""

    planes: Floats
    """(T, 4, 4) coefficients a, b, c, d of the plane and of the three sides."""
    cell_size: float
    """Width of a cell [pixels]."""
    columns: int
    rows: int
    start: Ints
    """(columns rows + 1,) where the list of each cell starts in `members`, row by row."""
    members: Ints
    """(K,) the triangles that meet each cell."""


@njit(cache=True)
def _cell(position: float, size: float, count: int) -> int:
    """Return the row or column that holds a position, the first or last one beside the picture."""
    return int(min(max(position / size, 0.0), count - 1.0))


@njit(cache=True)
def _put_cut(root: float, cuts: Floats, count: int) -> int:
    """Sort a number between 0 and 1 into the first `count` of `cuts`; returns the new count."""
    if not 0.0 < root < 1.0:
        return count
    place = count
    while cuts[place - 1] > root:
        cuts[place] = cuts[place - 1]
        place -= 1
    cuts[place] = root
    return count + 1


@njit(cache=True)
def _put_roots(f0: float, f1: float, f2: float, cuts: Floats, count: int) -> int:
    """Sort the roots of a function between 0 and 1 into the first `count` of `cuts`; returns the
    new count."""
    # curvature s^2 + 2 slope s + f0 = 0, by the formula in which nothing cancels
    curvature = f0 - 2.0 * f1 + f2
    slope = f1 - f0
    square = slope * slope - curvature * f0
    if square < 0.0:
        return count
    far = -slope - math.copysign(math.sqrt(square), slope)
    count = _put_cut(far / curvature, cuts, count)
    return _put_cut(f0 / far, cuts, count)


@njit(cache=True)
def _hidden_parts(values: Floats, cuts: Floats, spans: Floats, row: int) -> int:
    """Find where all four functions are at least 0.

    Parameters
    ----------
    values
        (4, 3) f0, f1, f2 of each.
    cuts
        (10,) working space.
    spans, row
        (R, 3); from row `row` on the columns 1 and 2 are filled with s from and to.

    Returns
    -------
    int
        Number of the spans, 5 at most.
    """
    cuts[0] = 0.0
    count = 1
    for side in range(4):
        if min(values[side, 0], values[side, 1], values[side, 2]) < 0.0:
            count = _put_roots(values[side, 0], values[side, 1], values[side, 2], cuts, count)
    cuts[count] = 1.0
    found = 0
    for k in range(count):
        s = 0.5 * (cuts[k] + cuts[k + 1])
        least = math.inf
        for side in range(4):
            one = values[side, 0] * (1.0 - s) + values[side, 1] * s
            other = values[side, 1] * (1.0 - s) + values[side, 2] * s
            least = min(least, one * (1.0 - s) + other * s)
        if least >= 0.0 and cuts[k + 1] > cuts[k]:
            spans[row + found, 1] = cuts[k]
            spans[row + found, 2] = cuts[k + 1]
            found += 1
    return found


@njit(cache=True)
def _may_hide(planes: Floats, t: int, curves: Floats, i: int, values: Floats) -> bool:
    """Fill values (4, 3) with the functions of triangle t at the control points of curve i; False
    as soon as one is below 0 at all of them, since the curve lies within their hull."""
    for side in range(4):
        greatest = -math.inf
        for k in range(3):
            value = 0.0
            for axis in range(4):
                value += planes[t, side, axis] * curves[i, k, axis]
            value = 0.0 if abs(value) < _ROUNDING else value
            values[side, k] = value
            greatest = max(greatest, value)
        if greatest < 0.0:
            return False
    return True


@njit(cache=True)
def hidden_spans(curves: Floats, boxes: Floats, occluders: Occluders) -> Floats:
    """Find what triangles hide of curves.

    Parameters
    ----------
    curves
        (K, 3, 4) control points in homogeneous coordinates: x, y, w and 1, times a weight.
    boxes
        (K, 4) least x, y and greatest x, y [pixels] of each curve.
    occluders
        The triangles that hide.

    Returns
    -------
    Floats
        (R, 3) the curve, and s from and to, in any order and with overlaps.
    """
    size = occluders.cell_size
    planes = occluders.planes
    start = occluders.start
    members = occluders.members
    last_query = np.full(len(planes), -1)
    values = np.empty((4, 3))
    cuts = np.empty(10)
    spans = np.empty((4 * len(curves) + 64, 3))
    found = 0
    for i in range(len(curves)):
        is_open = True
        first = found
        left = _cell(boxes[i, 0] - _HAIR, size, occluders.columns)
        right = _cell(boxes[i, 2] + _HAIR, size, occluders.columns)
        top = _cell(boxes[i, 1] - _HAIR, size, occluders.rows)
        bottom = _cell(boxes[i, 3] + _HAIR, size, occluders.rows)
        for row in range(top, bottom + 1):
            begin = start[row * occluders.columns + left]
            end = start[row * occluders.columns + right + 1]
            for n in range(begin, end):
                t = members[n]
                if last_query[t] == i:
                    continue
                last_query[t] = i
                if not _may_hide(planes, t, curves, i, values):
                    continue
                if found + 5 > len(spans):
                    larger = np.empty((2 * len(spans), 3))
                    for k in range(found):
                        for column in range(3):
                            larger[k, column] = spans[k, column]
                    spans = larger
                count = _hidden_parts(values, cuts, spans, found)
                for k in range(found, found + count):
                    spans[k, 0] = i
                    is_open &= spans[k, 2] - spans[k, 1] < 1.0
                found += count
                if not is_open:  # wholly hidden: no other can add to it
                    break
            if not is_open:
                break
        if not is_open:
            found = first + 1
            spans[first, 0] = i
            spans[first, 1] = 0.0
            spans[first, 2] = 1.0
    return spans[:found]
