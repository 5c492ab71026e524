"""Contour lines of values known at scattered points of a plane: spread over a grid, then marching
squares.

Marching squares as in Maple, Geometric design and space planning using the marching squares and
marching cube algorithms, GMAG 2003; a saddle is joined through its middle where the mean of its
four corners is inside. The spreading is the weighted mean of Nadaraya (1964) and Watson (1964) with
a normal kernel.
"""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats, Ints

__all__ = ["level_loops", "spacing", "spread"]

# corners of a cell run a (row, column), b (row, column + 1), c (row + 1, column + 1), d (row + 1,
# column); its sides ab, bc, cd, da are 0 to 3. By the corners inside (a 1, b 2, c 4, d 8): from the
# side where a walk round the cell goes out to the side where it comes in.
_CASES: dict[int, tuple[tuple[int, int], ...]] = {
    1: ((0, 3),), 2: ((1, 0),), 3: ((1, 3),), 4: ((2, 1),), 6: ((2, 0),), 7: ((2, 3),), 8: ((3, 2),), 9: ((0, 2),),
    11: ((1, 2),), 12: ((3, 1),), 13: ((0, 1),), 14: ((3, 0),),
}  # fmt: skip
_JOINED: dict[int, tuple[tuple[int, int], ...]] = {5: ((0, 1), (2, 3)), 10: ((3, 0), (1, 2))}
_APART: dict[int, tuple[tuple[int, int], ...]] = {5: ((0, 3), (2, 1)), 10: ((1, 0), (3, 2))}
_CHUNK = 2_000_000  # distances held at once


def spread(points: Floats, values: Floats, places: Floats, *, width: float) -> Floats:
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


def spacing(points: Floats) -> float:
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
    """Closed loops (K, 2) of row, column around where a field (R, C) is at least `level`.

    Between grid points it is linear along the sides of cells. What reaches the border is closed
    half a cell beyond it.
    """
    rim = np.full((field.shape[0] + 2, field.shape[1] + 2), -np.inf)
    rim[1:-1, 1:-1] = field
    following = _segments(rim, level)
    loops = []
    while following:
        start = next(iter(following))
        sides = [start]
        while (side := following.pop(sides[-1])) != start:
            sides.append(side)
        loops.append(_crossings(rim, level, np.array(sides)) - 1.0)
    return loops


def _segments(field: Floats, level: float) -> dict[int, int]:
    """Each line through a cell, from the number of one side to that of another: along row r from
    column c (2 (r C + c)) or along column c from row r (the same + 1)."""
    columns = field.shape[1]
    inside = field >= level
    code = inside[:-1, :-1] + 2 * inside[:-1, 1:] + 4 * inside[1:, 1:] + 8 * inside[1:, :-1]
    following: dict[int, int] = {}
    for row, column in np.argwhere((code > 0) & (code < 15)).tolist():
        case = int(code[row, column])
        if case in _JOINED:
            middle = float(field[row : row + 2, column : column + 2].mean())
            lines = _JOINED[case] if middle >= level else _APART[case]
        else:
            lines = _CASES[case]
        here = row * columns + column
        sides = (2 * here, 2 * (here + 1) + 1, 2 * (here + columns), 2 * here + 1)
        for out, back in lines:
            following[sides[out]] = sides[back]
    return following


def _crossings(field: Floats, level: float, sides: Ints) -> Floats:
    """(K, 2) row, column where the level crosses sides (K,); the middle of those that lead to the
    rim."""
    columns = field.shape[1]
    row, column = np.divmod(sides // 2, columns)
    upright = sides % 2
    one = field[row, column]
    two = field[row + upright, column + 1 - upright]
    known = np.isfinite(one) & np.isfinite(two)
    with np.errstate(invalid="ignore"):
        share = np.where(known, (level - one) / np.where(known, two - one, 1.0), 0.5)
    return np.stack([row + share * upright, column + share * (1 - upright)], axis=1)
