"""Find which part of a sphere's rim another sphere hides: one interval of angle for every pair.

Parallel view. The rim of sphere i is a circle at the constant depth z_i. With z = z_i - step,
sphere j hides a point of the rim where the point's distance from j's centre in the picture is below
rho, with rho^2 = r_j^2 - max(z - z_j, 0)^2.

Perspective. The eye is at the origin, d is the distance of a centre, and t = sqrt(d^2 - r^2) is the
length of the tangent. Rim i is the circle t_i u of the unit vectors u at the angle asin(r_i / d_i)
from its axis. With t = t_i + step, sphere j hides the point in direction u where

    u . c_j > t_j                      if t >= t_j,
    u . c_j > (t^2 + t_j^2) / (2 t)    otherwise.

Either condition is linear in the cosine of the angle from the direction of j, so the hidden part is
one interval. The same formula without depth (r_j, or t_j) gives the interval over j's disk.

`step` is 0, or for spheres of segments that are joined the least step of depth that is drawn.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.compiled import njit
from workbench.geometry.order import stable_order
from workbench.model.arrays import Bools, Floats, Ints

__all__ = [
    "COINCIDENCE",
    "TURN",
    "Grid",
    "Rims",
    "build_grid",
    "candidates",
    "cell_of",
    "covered_by_few",
    "keep_uncovered",
    "pair_cosines",
    "parallel_rims",
    "perspective_rims",
    "pseudo_angle_interval",
    "pseudo_angle_to_radians",
    "wrap_turn",
]

TURN = 4.0
"""A whole turn in pseudo-angles."""
COINCIDENCE = 1e-7
"""Distance [unit of x, y], and a hundredth of it [rad], below which two rims are one."""
_FEW = 6
"""Number of intervals with which `covered_by_few` tries to cover a rim."""
_MAX_COSINE = 0.9
"""Cosine of half the angle of an interval that is too narrow for `covered_by_few`."""
_MAX_CELLS = 2048
"""Columns or rows of a grid at most."""
_TINY = 1e-300
"""Divisor below which a quotient is not taken."""


class Rims(NamedTuple):
    """The rims of S spheres, of N segments, as the kernels take them."""

    balls: Floats
    """In a parallel view (S, 4): x, y, depth (larger is nearer), radius. In perspective (S, 15): x,
    y, distance along the view, radius, d, t, then three unit vectors: the axis, and two across it
    from which the angle is measured."""
    near: Floats
    """(S,) larger is nearer."""
    box: Floats
    """(S, 4) least x, y and greatest x, y of each rim, in any unit."""
    segment: Ints
    """(S,)."""
    body: Ints
    """(S,)."""
    joined: Bools
    """(N, N) whether two segments are joined."""
    step: Floats
    """(S,) least step of depth towards spheres of joined segments, in the unit of depth."""
    is_perspective: bool


class Grid(NamedTuple):
    """Boxes in a grid of cells about as wide as a usual box."""

    start: Ints
    """(columns rows + 1,) where the list of each cell starts in `members`, row by row."""
    members: Ints
    """(K,) the boxes that meet each cell, in the order that `build_grid` was given."""
    columns: int
    rows: int
    left: float
    """Least x and y of the grid, and its cells per unit."""
    top: float
    columns_per_unit: float
    rows_per_unit: float


class _Cells(NamedTuple):
    """First column and row of a range of cells, and one past the last."""

    left: int
    top: int
    right: int
    bottom: int


class _Pair(NamedTuple):
    """How sphere j covers rim i. A cosine of 1 or more means nothing, of -1 or less all."""

    x: float
    """Direction of j from i, of any length."""
    y: float
    hidden: float
    """Cosine of half the angle of what j hides."""
    over: float
    """Cosine of half the angle of what lies over the disk of j."""
    apart: float
    """How much the two rims differ; 0 where they are one."""


def parallel_rims(balls: Floats, segment: Ints, body: Ints, joined: Bools, step: Floats) -> Rims:
    """Prepare the rims of spheres in a parallel view.

    Parameters
    ----------
    balls
        (S, 4) x, y, depth, radius in one unit.
    segment, body, joined, step
        See `Rims`.
    """
    packed = np.ascontiguousarray(balls)
    box = np.column_stack([balls[:, :2] - balls[:, 3:], balls[:, :2] + balls[:, 3:]])
    depth = np.ascontiguousarray(balls[:, 2])
    return Rims(packed, depth, box, segment, body, joined, step, False)


def perspective_rims(balls: Floats, segment: Ints, body: Ints, joined: Bools, step: Floats) -> Rims:
    """Prepare the rims of spheres in perspective.

    The angle of a rim is 0 at its outermost point from the middle of the picture, and grows from +x
    to +y.

    Parameters
    ----------
    balls
        (S, 4) x, y, distance along the view from the eye, radius in one unit. None holds the eye.
    segment, body, joined, step
        See `Rims`.
    """
    x, y, along, radius = balls.T
    distance = np.sqrt(np.sum(balls[:, :3] ** 2, axis=1))
    tangent = np.sqrt(np.maximum(distance * distance - radius * radius, 0.0))
    packed = np.column_stack([balls, distance, tangent, *_rim_axes(x, y, along, distance)])
    box = np.column_stack([*_extent(x, along, radius), *_extent(y, along, radius)])[:, [0, 2, 1, 3]]
    return Rims(np.ascontiguousarray(packed), -tangent, box, segment, body, joined, step, True)


def _rim_axes(x: Floats, y: Floats, along: Floats, distance: Floats) -> list[Floats]:
    """Return 9 columns (S,): the axis of each rim, and two unit vectors across it."""
    off = np.hypot(x, y)
    is_off = off > 1e-12 * distance
    divisor = np.where(is_off, off, 1.0)
    # (hx, hy): direction of the sphere from the middle of the picture
    hx = np.where(is_off, x / divisor, 1.0)
    hy = np.where(is_off, y / divisor, 0.0)
    sine = off / distance
    cosine = along / distance
    axis = [hx * sine, hy * sine, cosine]
    outward = [hx * cosine, hy * cosine, -sine]
    return [*axis, *outward, -hy, hx, np.zeros(len(x))]


def _extent(across: Floats, along: Floats, radius: Floats) -> tuple[Floats, Floats]:
    """Return the least and greatest across / along of spheres; infinite beside the eye."""
    ahead = along > radius
    square = np.where(ahead, along * along - radius * radius, 1.0)
    root = radius * np.sqrt(np.maximum(across * across + along * along - radius * radius, 0.0))
    low = (across * along - root) / square
    high = (across * along + root) / square
    return np.where(ahead, low, -np.inf), np.where(ahead, high, np.inf)


# ----------------------------------------------------------------------------------- pairs


@njit(cache=True)
def pair_cosines(i: int, j: int, balls: Floats, is_perspective: bool, offset: float) -> _Pair:
    """Compute how sphere j covers rim i.

    Parameters
    ----------
    i, j
        The rim and the sphere.
    balls, is_perspective
        See `Rims`.
    offset
        Step of depth by which j must be nearer to hide.
    """
    if is_perspective:
        return _perspective_pair(i, j, balls, offset)
    return _parallel_pair(i, j, balls, offset)


@njit(cache=True)
def _parallel_pair(i: int, j: int, balls: Floats, offset: float) -> _Pair:
    # A point of rim i at the angle a from the direction of j has the squared distance
    # D^2 + r_i^2 - 2 D r_i cos(a) from j's centre in the picture.
    dx = balls[j, 0] - balls[i, 0]
    dy = balls[j, 1] - balls[i, 1]
    radius = balls[i, 3]
    other = balls[j, 3]
    square = dx * dx + dy * dy
    distance = math.sqrt(square)
    below = max(balls[i, 2] - offset - balls[j, 2], 0.0)
    over = square + radius * radius - other * other
    hidden = over + below * below
    return _divided(dx, dy, hidden, over, 2.0 * distance * radius, distance + abs(radius - other))


@njit(cache=True)
def _perspective_pair(i: int, j: int, balls: Floats, offset: float) -> _Pair:
    # A point of rim i at the angle a from the direction of j has
    # u . c_j = cosine (axis . c_j) + sine |across . c_j| cos(a).
    along = 0.0
    dx = 0.0
    dy = 0.0
    for k in range(3):
        along += balls[j, k] * balls[i, 6 + k]
        dx += balls[j, k] * balls[i, 9 + k]
        dy += balls[j, k] * balls[i, 12 + k]
    reach = balls[i, 5] + offset
    other = balls[j, 5]
    sine = balls[i, 3] / balls[i, 4]
    cosine = balls[i, 5] / balls[i, 4]
    across = math.sqrt(dx * dx + dy * dy)
    over = other - cosine * along
    hidden = over if reach >= other else over + (reach - other) * (reach - other) / (2.0 * reach)
    apart = 100.0 * (across / balls[j, 4] + abs(sine - balls[j, 3] / balls[j, 4]))
    return _divided(dx, dy, hidden, over, sine * across, apart)


@njit(cache=True)
def _divided(dx: float, dy: float, hidden: float, over: float, side: float, apart: float) -> _Pair:
    """Divide both numerators by `side` to cosines; rims that coincide hide nothing here."""
    if apart < COINCIDENCE:
        return _Pair(dx, dy, 2.0, 2.0, 0.0)
    if side < _TINY:  # the same direction: all or nothing
        return _Pair(1.0, 0.0, 2.0 if hidden >= 0.0 else -2.0, 2.0 if over >= 0.0 else -2.0, apart)
    return _Pair(dx, dy, hidden / side, over / side, apart)


# ------------------------------------------------------------------------------------ grid


@njit(cache=True)
def build_grid(box: Floats, near: Floats) -> Grid:
    """Sort boxes into cells.

    Parameters
    ----------
    box
        (S, 4) least x, y and greatest x, y. Infinite ones meet the cells at the margin.
    near
        (S,) the nearest (largest) come first in each cell.
    """
    order = np.empty(len(near), np.int64)
    farness = np.empty(len(near))
    for n in range(len(near)):
        farness[n] = -near[n]
    stable_order(farness, len(near), order, np.empty(len(near), np.int64))
    grid = _empty_grid(box)
    # counting sort: the sizes of the lists, their starts, then the lists
    start = grid.start
    for i in order:
        cells = _cells_of_box(box, i, grid)
        for row in range(cells.top, cells.bottom):
            for column in range(cells.left, cells.right):
                start[row * grid.columns + column + 1] += 1
    next_free = np.empty(len(start) - 1, np.int64)
    for cell in range(len(next_free)):
        next_free[cell] = start[cell]
        start[cell + 1] += start[cell]
    members = np.empty(start[-1], np.int64)
    for i in order:
        cells = _cells_of_box(box, i, grid)
        for row in range(cells.top, cells.bottom):
            for column in range(cells.left, cells.right):
                cell = row * grid.columns + column
                members[next_free[cell]] = i
                next_free[cell] += 1
    return _with_members(grid, members)


@njit(cache=True)
def _empty_grid(box: Floats) -> Grid:
    """Return a grid around the finite boxes (S, 4), about as many cells as boxes each way."""
    left = np.inf
    top = np.inf
    right = -np.inf
    bottom = -np.inf
    width = 0.0
    count = 0
    for n in range(len(box)):
        if math.isfinite(box[n, 0] + box[n, 1] + box[n, 2] + box[n, 3]):
            left = min(left, box[n, 0])
            top = min(top, box[n, 1])
            right = max(right, box[n, 2])
            bottom = max(bottom, box[n, 3])
            width = width + box[n, 2] - box[n, 0]
            count = count + 1
    nothing = np.empty(0, np.int64)
    if count == 0 or width <= 0.0:
        return Grid(np.zeros(2, np.int64), nothing, 1, 1, 0.0, 0.0, 0.0, 0.0)
    columns = min(max(int((right - left) * count / width), 1), _MAX_CELLS)
    rows = min(max(int((bottom - top) * count / width), 1), _MAX_CELLS)
    start = np.zeros(columns * rows + 1, np.int64)
    across = columns / max(right - left, _TINY)
    down = rows / max(bottom - top, _TINY)
    return Grid(start, nothing, columns, rows, left, top, across, down)


@njit(cache=True)
def _with_members(grid: Grid, members: Ints) -> Grid:
    return Grid(
        grid.start,
        members,
        grid.columns,
        grid.rows,
        grid.left,
        grid.top,
        grid.columns_per_unit,
        grid.rows_per_unit,
    )


@njit(cache=True)
def _clamped(position: float, count: int) -> int:
    """Return the cell that holds a position [cells], the first or last one beyond the grid."""
    if math.isnan(position):  # an infinite box over a grid without extent
        return 0
    return int(min(max(position, 0.0), count - 1.0))


@njit(cache=True)
def cell_of(x: float, y: float, grid: Grid) -> int:
    """Return the cell that holds a point, or the one nearest to it."""
    column = _clamped((x - grid.left) * grid.columns_per_unit, grid.columns)
    row = _clamped((y - grid.top) * grid.rows_per_unit, grid.rows)
    return row * grid.columns + column


@njit(cache=True)
def _cells_of_box(box: Floats, i: int, grid: Grid) -> _Cells:
    """Return the cells that box i (S, 4) meets."""
    return _Cells(
        _clamped((box[i, 0] - grid.left) * grid.columns_per_unit, grid.columns),
        _clamped((box[i, 1] - grid.top) * grid.rows_per_unit, grid.rows),
        _clamped((box[i, 2] - grid.left) * grid.columns_per_unit, grid.columns) + 1,
        _clamped((box[i, 3] - grid.top) * grid.rows_per_unit, grid.rows) + 1,
    )


@njit(cache=True)
def candidates(i: int, box: Floats, grid: Grid, stamp: Ints, found: Ints) -> int:
    """Find the rims other than i whose boxes meet that of rim i.

    Parameters
    ----------
    i, box, grid
        The rim, the boxes (S, 4) of all rims, and their grid.
    stamp
        (S,) the last rim that met each one; no element may be i before the call.
    found
        (S,) filled with the rims.

    Returns
    -------
    int
        How many were found.
    """
    start = grid.start
    members = grid.members
    count = 0
    cells = _cells_of_box(box, i, grid)
    stamp[i] = i
    for row in range(cells.top, cells.bottom):
        for column in range(cells.left, cells.right):
            cell = row * grid.columns + column
            for k in range(start[cell], start[cell + 1]):
                j = members[k]
                if stamp[j] == i:
                    continue
                stamp[j] = i
                if (
                    box[j, 0] < box[i, 2]
                    and box[i, 0] < box[j, 2]
                    and box[j, 1] < box[i, 3]
                    and box[i, 1] < box[j, 3]
                ):
                    found[count] = j
                    count += 1
    return count


# --------------------------------------------------------------------------- pseudo-angles


@njit(cache=True)
def _pseudo_angle(x: float, y: float) -> float:
    """Return the diamond angle of a vector: from 0 along +x to below 4, monotonic in its angle.

    It is the distance round the diamond |x| + |y| = 1, and takes no arc tangent.
    """
    if y >= 0.0:
        if x > 0.0:
            return y / (x + y)
        return 1.0 - x / (y - x) if y > 0.0 or x < 0.0 else 0.0
    return 2.0 - y / (-x - y) if x < 0.0 else 3.0 + x / (x - y)


@njit(cache=True)
def wrap_turn(angle: float) -> float:
    """Return a pseudo-angle within 0 to `TURN`; several times as fast as a remainder."""
    return angle - 4.0 * math.floor(0.25 * angle)


@njit(cache=True)
def pseudo_angle_to_radians(angle: float) -> float:
    """Return the angle [rad], from -pi to pi, of a pseudo-angle in any turn."""
    angle = wrap_turn(angle)
    if angle < 2.0:
        return math.atan2(angle if angle < 1.0 else 2.0 - angle, 1.0 - angle)
    return math.atan2(2.0 - angle if angle < 3.0 else angle - 4.0, angle - 3.0)


@njit(cache=True)
def pseudo_angle_interval(x: float, y: float, cosine: float) -> tuple[float, float]:
    """Return the pseudo-angles from and to of what lies within an angle from the vector (x, y).

    cosine: of that angle.
    """
    sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
    first = _pseudo_angle(x * cosine + y * sine, y * cosine - x * sine)
    width = _pseudo_angle(x * cosine - y * sine, y * cosine + x * sine) - first
    return first, first + (width if width >= 0.0 else width + 4.0)


# -------------------------------------------------------------------------- covered at once


@njit(cache=True)
def _widest_intervals(pairs: Floats, count: int, widest: Ints) -> int:
    """Fill `widest` with the pairs that hide most, the widest first; returns how many."""
    most = 0
    for k in range(count):
        if pairs[k, 2] >= _MAX_COSINE:
            continue
        if most == _FEW and pairs[k, 2] >= pairs[widest[most - 1], 2]:
            continue
        place = min(most, _FEW - 1)
        most = min(most + 1, _FEW)
        while place > 0 and pairs[widest[place - 1], 2] > pairs[k, 2]:
            widest[place] = widest[place - 1]
            place -= 1
        widest[place] = k
    return most


@njit(cache=True)
def covered_by_few(pairs: Floats, count: int) -> tuple[float, float]:
    """Find what the few widest hidden intervals of a rim cover in one run.

    Most rims that are hidden at all are hidden by three others.

    Parameters
    ----------
    pairs, count
        (K, 4) x, y and the two cosines of `pair_cosines`; the first `count` hold.

    Returns
    -------
    tuple[float, float]
        Pseudo-angles from and to; a whole turn or more: all.
    """
    widest = np.empty(_FEW, np.int64)
    most = _widest_intervals(pairs, count, widest)
    if most == 0:
        return 0.0, 0.0
    low, high = _pair_interval(pairs, widest[0])
    used = np.zeros(_FEW, np.bool_)
    used[0] = True
    has_grown = True
    while has_grown and high - low < TURN:
        has_grown = False
        for n in range(1, most):
            if used[n]:
                continue
            first, end = _pair_interval(pairs, widest[n])
            width = end - first
            first = low + wrap_turn(first - low)
            if first - TURN + width >= low:  # it comes round to the beginning
                first -= TURN
            if first <= high:
                low = min(low, first)
                high = max(high, first + width)
                used[n] = True
                has_grown = True
    return low, high


@njit(cache=True)
def _pair_interval(pairs: Floats, k: int) -> tuple[float, float]:
    """Return the pseudo-angles of what pair k (K, 4) hides."""
    return pseudo_angle_interval(pairs[k, 0], pairs[k, 1], pairs[k, 2])


@njit(cache=True)
def keep_uncovered(low: float, high: float, found: Ints, pairs: Floats, count: int) -> int:
    """Drop the pairs whose interval over the disk lies within a hidden part of the rim.

    Parameters
    ----------
    low, high
        Pseudo-angles of the hidden part.
    found, pairs, count
        (K,) spheres and (K, 4) what `pair_cosines` gave; the first `count` hold. Filled in place.

    Returns
    -------
    int
        How many are kept.
    """
    if high <= low:
        return count
    begin = pseudo_angle_to_radians(low)
    half = 0.5 * ((pseudo_angle_to_radians(high) - begin) % math.tau)
    mx = math.cos(begin + half)
    my = math.sin(begin + half)
    least = math.cos(half)
    kept = 0
    for k in range(count):
        if _is_within(pairs, k, mx, my, least):
            continue
        found[kept] = found[k]
        for part in range(4):
            pairs[kept, part] = pairs[k, part]
        kept += 1
    return kept


@njit(cache=True)
def _is_within(pairs: Floats, k: int, mx: float, my: float, least: float) -> bool:
    """Whether the interval of pair k over its disk lies within an arc.

    mx, my: unit vector of the middle of the arc; least: cosine of half its angle.
    """
    # An interval of half width h lies within one of half width H where the angle g between their
    # middles is at most H - h, that is where cos(g + h) >= cos(H).
    cosine = pairs[k, 3]
    if cosine <= -1.0 or cosine < least:
        return False
    length = math.sqrt(pairs[k, 0] ** 2 + pairs[k, 1] ** 2)
    along = (mx * pairs[k, 0] + my * pairs[k, 1]) / length
    sine = math.sqrt(max((1.0 - along * along) * (1.0 - cosine * cosine), 0.0))
    return along > -cosine and along * cosine - sine >= least
