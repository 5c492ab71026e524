"""Find what flat triangles and balls hide of arcs and of straight lines, in closed form.

Triangles, arcs and lines are in picture space: x right, y down [pixels] and projective depth w,
larger nearer. Planes are planes and straight lines are straight there, in a parallel view and in
perspective. A triangle hides a point p that lies inside its three sides and behind its plane: where
four functions

    f(p) = a x + b y + c w + d

are all at least 0. Along an ellipse m + cos(t) u + sin(t) v each of them is

    f(t) = h0 + hc cos(t) + hs sin(t),

which is at least 0 on one interval of angles. Along a line f is linear, and at least 0 on one
interval of shares of its length. What no triangle hides is visible; there is no depth buffer.

Triangles are found by a grid of square cells: all that meet a cell that the line meets, or that
the bounding box of the ellipse meets.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.compiled import njit
from workbench.geometry.order import stable_order
from workbench.model.arrays import Floats, Ints
from workbench.sight.kernels.rasterization import MIN_AREA

__all__ = [
    "Occluders",
    "hidden_arcs",
    "hidden_lines",
    "lines_among_balls",
    "occluder_planes",
    "with_room",
]

_TURN = 2.0 * math.pi
_MAX_SPANS = 24
"""Bound on the intervals of one triangle on one arc. Four cuts of a turn, and the turns before and
after it, give fewer."""
_MIN_GAP = 1e-9
"""[rad] or share of a line: a gap between two intervals no wider than this is rounding."""
_HAIR = 1e-6
"""Widening [pixels] of what is sought in the grid, more than any rounding of a point's cell."""
_EMPTY = (0.0, -1.0)
"""An interval that holds nothing: its end lies before its start."""

Triple = tuple[float, float, float]


class Occluders(NamedTuple):
    """T triangles that hide, and a grid of square cells to find them in."""

    planes: Floats
    """(T, 4, 4) coefficients a, b, c, d of the three sides and of the plane."""
    cell_size: float
    """Width of a cell [pixels]."""
    columns: int
    rows: int
    start: Ints
    """(columns rows + 1,) where the list of each cell starts in `members`, row by row."""
    members: Ints
    """(K,) the triangles that meet each cell."""


class _Search(NamedTuple):
    """Working arrays of a search in the grid, for T triangles."""

    last_query: Ints
    """(T,) number of the last query that found each triangle; -1 for none."""
    found: Ints
    """(T,) the triangles that the query found come first."""


class _Ellipse(NamedTuple):
    """The curve middle + cos(t) u + sin(t) v in picture space."""

    middle: Triple
    u: Triple
    v: Triple


class _Overlap(NamedTuple):
    """Where on a line, as shares of its length, it crosses the outline of a ball.

    An end before its start means nowhere.
    """

    low: float
    """From where it is over the outline, and to where."""
    high: float
    behind_low: float
    """From where it is also behind the rim, and to where."""
    behind_high: float


class _Query(NamedTuple):
    """Box [pixels] in which triangles are sought, or the line across it."""

    left: float
    top: float
    right: float
    bottom: float
    top_x: float
    """x of a line at the top of the box, and at its bottom."""
    bottom_x: float
    is_line: bool


# ------------------------------------------------------------------------------- triangles


@njit(cache=True)
def occluder_planes(corners: Floats, bias: float) -> Floats:
    """Compute the four functions that are at least 0 where a triangle hides a point.

    Parameters
    ----------
    corners
        (T, 3, 3) corners in picture space.
    bias
        Projective depth by which a point must lie behind the plane to be hidden.

    Returns
    -------
    Floats
        (T, 4, 4) coefficients a, b, c, d of the three sides and of the plane. A triangle seen
        edge-on hides nothing: its last function is -1 everywhere.
    """
    planes = np.zeros((len(corners), 4, 4))
    for t in range(len(corners)):
        a = corners[t, 0]
        b = corners[t, 1]
        c = corners[t, 2]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        if abs(area) < MIN_AREA:
            planes[t, 3, 3] = -1.0
            continue
        sense = 1.0 if area > 0.0 else -1.0
        for side in range(3):
            _put_side(planes[t, side], corners[t, side], corners[t, (side + 1) % 3], sense)
        _put_plane(planes[t, 3], corners[t], area, bias)
    return planes


@njit(cache=True)
def _put_side(plane: Floats, p: Floats, q: Floats, sense: float) -> None:
    """Fill plane (4,) with a function that is positive on the inner side of the edge p q.

    sense: 1 or -1, the sign of the triangle's area.
    """
    dx = q[0] - p[0]
    dy = q[1] - p[1]
    plane[0] = -sense * dy
    plane[1] = sense * dx
    plane[3] = sense * (dy * p[0] - dx * p[1])


@njit(cache=True)
def _put_plane(plane: Floats, corners: Floats, area: float, bias: float) -> None:
    """Fill plane (4,) with the depth of a triangle (3, 3) above a point, less `bias`.

    area: twice the signed area of the triangle in the picture.
    """
    a = corners[0]
    b = corners[1]
    c = corners[2]
    # change of depth per pixel to the right and down, by Cramer's rule
    right = ((b[2] - a[2]) * (c[1] - a[1]) - (c[2] - a[2]) * (b[1] - a[1])) / area
    down = ((c[2] - a[2]) * (b[0] - a[0]) - (b[2] - a[2]) * (c[0] - a[0])) / area
    plane[0] = right
    plane[1] = down
    plane[2] = -1.0
    plane[3] = a[2] - right * a[0] - down * a[1] - bias


@njit(cache=True)
def _triple(points: Floats, i: int, k: int) -> Triple:
    """Return points[i, k] of an array (M, K, 3)."""
    return points[i, k, 0], points[i, k, 1], points[i, k, 2]


@njit(cache=True)
def _slope_along(planes: Floats, t: int, side: int, v: Triple) -> float:
    """Return a x + b y + c w of function `side` of triangle t, for a vector v."""
    return planes[t, side, 0] * v[0] + planes[t, side, 1] * v[1] + planes[t, side, 2] * v[2]


@njit(cache=True)
def _row_extent(query: _Query, low: float, high: float) -> tuple[float, float]:
    """Return the least and greatest x of a query between the heights `low` and `high`."""
    if not query.is_line or query.bottom <= query.top:
        return query.left, query.right
    height = query.bottom - query.top
    first = (min(max(low, query.top), query.bottom) - query.top) / height
    last = (min(max(high, query.top), query.bottom) - query.top) / height
    one = query.top_x + first * (query.bottom_x - query.top_x)
    two = query.top_x + last * (query.bottom_x - query.top_x)
    return min(one, two), max(one, two)


@njit(cache=True)
def _find_triangles(query: _Query, number: int, occluders: Occluders, search: _Search) -> int:
    """Put each triangle of the cells that a query meets into `search.found` once.

    number: another one for each query. Returns how many triangles were found.
    """
    size = occluders.cell_size
    start = occluders.start
    members = occluders.members
    last_query = search.last_query
    triangles = search.found
    found = 0
    top = max(int((query.top - _HAIR) // size), 0)
    bottom = min(int((query.bottom + _HAIR) // size), occluders.rows - 1)
    for row in range(top, bottom + 1):
        left, right = _row_extent(query, row * size - _HAIR, (row + 1) * size + _HAIR)
        first = row * occluders.columns + max(int((left - _HAIR) // size), 0)
        last = row * occluders.columns + min(int((right + _HAIR) // size), occluders.columns - 1)
        for cell in range(first, last + 1):
            for k in range(start[cell], start[cell + 1]):
                triangle = members[k]
                if last_query[triangle] != number:
                    last_query[triangle] = number
                    triangles[found] = triangle
                    found += 1
    return found


# ------------------------------------------------------------------------------- intervals


@njit(cache=True)
def with_room(values: Floats, count: int) -> Floats:
    """Return an array of at least `count` rows that begins with all rows of `values`."""
    if count <= len(values):
        return values
    larger = np.empty((max(2 * len(values), count), values.shape[1]))
    for row in range(len(values)):
        for column in range(values.shape[1]):
            larger[row, column] = values[row, column]
    return larger


@njit(cache=True)
def _put_span(spans: Floats, count: int, first: float, last: float) -> int:
    """Append an interval to spans (R, 2) unless it is empty; returns the new count."""
    if last <= first:
        return count
    spans[count, 0] = first
    spans[count, 1] = last
    return count + 1


@njit(cache=True)
def _put_piece(
    pieces: Floats, count: int, item: int, first: float, last: float, hidden: float
) -> int:
    """Append a row item, from, to, hidden to pieces (R, 4); returns the new count."""
    pieces[count, 0] = item
    pieces[count, 1] = first
    pieces[count, 2] = last
    pieces[count, 3] = hidden
    return count + 1


@njit(cache=True)
def _put_pieces(
    item: int, spans: Floats, count: int, low: float, high: float, pieces: Floats, found: int
) -> int:
    """Merge hidden intervals and append the pieces into which they cut the range low to high.

    Parameters
    ----------
    item
        Number of the arc or line.
    spans, count
        (R, 2) intervals in any order; the first `count` of them hold.
    low, high
        The range that is cut. All intervals lie in it.
    pieces, found
        (R, 4) rows item, from, to, 1 for hidden or 0, and how many there are. There must be room
        for 2 count + 1 more.

    Returns
    -------
    int
        The new number of pieces.
    """
    keys = np.empty(count)
    order = np.empty(count, np.int64)
    spare = np.empty(count, np.int64)
    for row in range(count):
        keys[row] = spans[row, 0]
    stable_order(keys, count, order, spare)
    here = low
    k = 0
    while k < count:
        first = spans[order[k], 0]
        last = spans[order[k], 1]
        while k + 1 < count and spans[order[k + 1], 0] <= last + _MIN_GAP:
            k += 1
            last = max(last, spans[order[k], 1])
        k += 1
        if first > here + _MIN_GAP:
            found = _put_piece(pieces, found, item, here, first, 0.0)
        else:
            first = here
        if high - last <= _MIN_GAP:
            last = high
        found = _put_piece(pieces, found, item, first, last, 1.0)
        here = last
    if here < high:
        found = _put_piece(pieces, found, item, here, high, 0.0)
    return found


@njit(cache=True)
def _intersect_spans(spans: Floats, count: int, low: float, high: float, spare: Floats) -> int:
    """Intersect intervals of angle with low to high, and with the same a turn before and after.

    spans, spare (R, 2); returns the new count.
    """
    found = 0
    for k in range(count):
        for turn in range(-1, 2):
            first = max(spans[k, 0], low + turn * _TURN)
            last = min(spans[k, 1], high + turn * _TURN)
            if found < len(spare):
                found = _put_span(spare, found, first, last)
    for k in range(found):
        spans[k, 0] = spare[k, 0]
        spans[k, 1] = spare[k, 1]
    return found


# ------------------------------------------------------------------- arcs behind triangles


@njit(cache=True)
def _hidden_spans(
    ellipse: _Ellipse,
    start: float,
    width: float,
    planes: Floats,
    t: int,
    spans: Floats,
    spare: Floats,
) -> int:
    """Find where triangle t hides an arc of an ellipse.

    Parameters
    ----------
    ellipse, start, width
        The ellipse, the first angle of the arc [rad] and its extent.
    planes, t
        (T, 4, 4) as of `occluder_planes`, and the triangle.
    spans, spare
        (R, 2) filled with angles from `start`, 0 to `width`.

    Returns
    -------
    int
        Number of intervals.
    """
    spans[0, 0] = 0.0
    spans[0, 1] = width
    count = 1
    for side in range(4):
        level = _slope_along(planes, t, side, ellipse.middle) + planes[t, side, 3]
        cosine = _slope_along(planes, t, side, ellipse.u)
        sine = _slope_along(planes, t, side, ellipse.v)
        # level + cosine cos(t) + sine sin(t) = level + swing cos(t - peak)
        swing = math.hypot(cosine, sine)
        if level >= swing:
            continue
        if level <= -swing:
            return 0
        half = math.acos(-level / swing)
        peak = math.atan2(sine, cosine)
        low = (peak - half - start) % _TURN
        count = _intersect_spans(spans, count, low, low + 2.0 * half, spare)
        if count == 0:
            return 0
    return count


@njit(cache=True)
def _arc_query(ellipse: _Ellipse) -> _Query:
    """Return the bounding box of an ellipse."""
    x, y, _ = ellipse.middle
    wide = math.hypot(ellipse.u[0], ellipse.v[0])
    high = math.hypot(ellipse.u[1], ellipse.v[1])
    return _Query(x - wide, y - high, x + wide, y + high, 0.0, 0.0, False)


@njit(cache=True)
def _arc_pieces(rims: Floats, angle: Floats, occluders: Occluders) -> Floats:
    """Return rows (K, 4) arc, angles from and to, hidden; arguments as for `hidden_arcs`."""
    planes = occluders.planes
    triangles = np.empty(len(planes), np.int64)
    search = _Search(np.full(len(planes), -1), triangles)
    spans = np.empty((_MAX_SPANS, 2))
    spare = np.empty((_MAX_SPANS, 2))
    hidden = np.empty((64, 2))
    pieces = np.empty((4 * len(rims) + 64, 4))
    found = 0
    for i in range(len(rims)):
        start = angle[i, 0]
        width = angle[i, 1] - start
        count = 0
        ellipse = _Ellipse(_triple(rims, i, 0), _triple(rims, i, 1), _triple(rims, i, 2))
        for k in range(_find_triangles(_arc_query(ellipse), i, occluders, search)):
            cuts = _hidden_spans(ellipse, start, width, planes, triangles[k], spans, spare)
            hidden = with_room(hidden, count + cuts)
            whole = cuts == 1 and spans[0, 0] <= 0.0 and spans[0, 1] >= width
            if whole:  # no other triangle can add to it
                hidden[0, 0] = start
                hidden[0, 1] = start + width
                count = 1
                break
            for s in range(cuts):
                hidden[count, 0] = start + spans[s, 0]
                hidden[count, 1] = start + spans[s, 1]
                count += 1
        pieces = with_room(pieces, found + 2 * count + 2)
        found = _put_pieces(i, hidden, count, start, angle[i, 1], pieces, found)
    return pieces[:found]


def hidden_arcs(rims: Floats, angle: Floats, occluders: Occluders) -> tuple[Ints, Floats, Ints]:
    """Cut arcs of ellipses where triangles start or end to hide them.

    Parameters
    ----------
    rims
        (A, 3, 3) middle m and half axes u, v of ellipses m + cos(t) u + sin(t) v in picture space.
    angle
        (A, 2) angles t [rad] from and to, at most a turn apart.
    occluders
        The triangles that hide.

    Returns
    -------
    tuple[Ints, Floats, Ints]
        The arc (K,) of each piece, in turn; its angles (K, 2); and 1 where it is hidden, else 0.
    """
    rows = _arc_pieces(rims, angle, occluders)
    return rows[:, 0].astype(np.int64), rows[:, 1:3], rows[:, 3].astype(np.int64)


# ------------------------------------------------------------------ lines behind triangles


@njit(cache=True)
def _line_query(p: Triple, q: Triple) -> _Query:
    """Return the bounding box of the line from p to q, and how the line crosses it."""
    if p[1] > q[1]:
        return _Query(min(p[0], q[0]), q[1], max(p[0], q[0]), p[1], q[0], p[0], True)
    return _Query(min(p[0], q[0]), p[1], max(p[0], q[0]), q[1], p[0], q[0], True)


@njit(cache=True, error_model="numpy")
def _hidden_share(p: Triple, q: Triple, planes: Floats, t: int) -> tuple[float, float]:
    """Return the shares of the line from p to q between which triangle t hides it."""
    first = 0.0
    last = 1.0
    for side in range(4):
        low = _slope_along(planes, t, side, p) + planes[t, side, 3]
        high = _slope_along(planes, t, side, q) + planes[t, side, 3]
        if low < 0.0 and high < 0.0:
            return _EMPTY
        if low < 0.0:
            first = max(first, low / (low - high))
        elif high < 0.0:
            last = min(last, low / (low - high))
    return first, last


@njit(cache=True)
def _line_pieces(ends: Floats, occluders: Occluders) -> Floats:
    """Return rows (K, 4) line, shares from and to, hidden; arguments as for `hidden_lines`."""
    planes = occluders.planes
    triangles = np.empty(len(planes), np.int64)
    search = _Search(np.full(len(planes), -1), triangles)
    hidden = np.empty((64, 2))
    pieces = np.empty((4 * len(ends) + 64, 4))
    found = 0
    for i in range(len(ends)):
        count = 0
        p = _triple(ends, i, 0)
        q = _triple(ends, i, 1)
        for k in range(_find_triangles(_line_query(p, q), i, occluders, search)):
            first, last = _hidden_share(p, q, planes, triangles[k])
            hidden = with_room(hidden, count + 1)
            if first <= 0.0 and last >= 1.0:  # wholly: no other triangle can add to it
                count = _put_span(hidden, 0, first, last)
                break
            count = _put_span(hidden, count, first, last)
        pieces = with_room(pieces, found + 2 * count + 2)
        found = _put_pieces(i, hidden, count, 0.0, 1.0, pieces, found)
    return pieces[:found]


def hidden_lines(ends: Floats, occluders: Occluders) -> tuple[Ints, Floats, Ints]:
    """Cut straight lines where triangles start or end to hide them.

    Parameters
    ----------
    ends
        (M, 2, 3) ends of the lines in picture space.
    occluders
        The triangles that hide.

    Returns
    -------
    tuple[Ints, Floats, Ints]
        The line (K,) of each piece, in turn; shares (K, 2) of its length, from and to; and 1 where
        it is hidden, else 0.
    """
    rows = _line_pieces(ends, occluders)
    return rows[:, 0].astype(np.int64), rows[:, 1:3], rows[:, 3].astype(np.int64)


# -------------------------------------------------------------------------- lines and balls


@njit(cache=True)
def _dot(a: Triple, b: Triple) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _negative_interval(
    a: float, b: float, c: float, first: float, last: float
) -> tuple[float, float]:
    """Return where a t^2 + 2 b t + c < 0 within first to last, for a >= 0."""
    if a <= 0.0:
        return (first, last) if c < 0.0 else _EMPTY
    discriminant = b * b - a * c
    if discriminant <= 0.0:
        return _EMPTY
    root = math.sqrt(discriminant)
    return max(first, (-b - root) / a), min(last, (-b + root) / a)


@njit(cache=True)
def _positive_interval(
    level: float, slope: float, first: float, last: float
) -> tuple[float, float]:
    """Return where level + slope t > 0 within first to last."""
    if slope == 0.0:
        return (first, last) if level > 0.0 else _EMPTY
    return (max(first, -level / slope), last) if slope > 0.0 else (first, min(last, -level / slope))


@njit(cache=True)
def _parallel_overlap(p: Triple, d: Triple, centre: Triple, radius: float) -> _Overlap:
    """Intersect the line p + t d, t from 0 to 1, with the outline of a ball in a parallel view."""
    x = p[0] - centre[0]
    y = p[1] - centre[1]
    z = p[2] - centre[2]
    low, high = _negative_interval(
        d[0] * d[0] + d[1] * d[1],
        x * d[0] + y * d[1],
        x * x + y * y - radius * radius,
        0.0,
        1.0,
    )
    first, last = _positive_interval(-z, -d[2], low, high)
    return _Overlap(low, high, first, last)


@njit(cache=True)
def _perspective_overlap(p: Triple, d: Triple, u: Triple, radius: float) -> _Overlap:
    """Intersect the line p + t d, t from 0 to 1, with the outline of a ball seen from the origin.

    u: the centre of the ball. Nothing is found for a ball that holds the eye: it is not drawn.
    """
    # The outline is the cone (u . X)^2 = (u . u - r^2) X . X around the axis u, and the rim lies in
    # the plane u . X = u . u - r^2. On the line the first is a quadratic a t^2 + 2 b t + c = 0, and
    # the second is linear in t.
    square = _dot(u, u) - radius * radius
    if square <= 0.0:
        return _Overlap(0.0, -1.0, 0.0, -1.0)
    level = _dot(u, p)
    slope = _dot(u, d)
    a = square * _dot(d, d) - slope * slope
    b = square * _dot(p, d) - level * slope
    c = square * _dot(p, p) - level * level
    low, high = _positive_interval(level, slope, 0.0, 1.0)
    if a >= 0.0:
        low, high = _negative_interval(a, b, c, low, high)
    else:  # the line also crosses the mirrored cone behind the eye: one of the outer parts is ahead
        root = math.sqrt(max(b * b - a * c, 0.0))
        one = (-b + root) / a
        two = (-b - root) / a
        if slope > 0.0:
            low = max(low, max(one, two))
        else:
            high = min(high, min(one, two))
    first, last = _positive_interval(level - square, slope, low, high)
    return _Overlap(low, high, first, last)


@njit(cache=True)
def _is_beside(p: Triple, d: Triple, centre: Triple, radius: float) -> bool:
    """Whether a line and a ball are apart in the picture of a parallel view, by their boxes."""
    return (
        centre[0] + radius < min(p[0], p[0] + d[0])
        or centre[0] - radius > max(p[0], p[0] + d[0])
        or centre[1] + radius < min(p[1], p[1] + d[1])
        or centre[1] - radius > max(p[1], p[1] + d[1])
    )


@njit(cache=True)
def _ball_spans(
    p: Triple, d: Triple, balls: Floats, distance: float, over: Floats, behind: Floats
) -> tuple[int, int]:
    """Find where the line p + t d is over the outlines of balls, and where behind or inside them.

    Parameters
    ----------
    p, d
        Start of the line and its extent, view coordinates [m].
    balls
        (S, 4) view coordinates of the centres, and radii [m].
    distance
        Depth [m] of the eye; infinite in a parallel view.
    over, behind
        (S + 1, 2) and (2 S + 1, 2) filled with shares of the length of the line.

    Returns
    -------
    tuple[int, int]
        Number of intervals in `over` and in `behind`.
    """
    is_parallel = math.isinf(distance)
    overs = 0
    hidden = 0
    for j in range(len(balls)):
        centre = (balls[j, 0], balls[j, 1], balls[j, 2])
        radius = balls[j, 3]
        if is_parallel:
            if _is_beside(p, d, centre, radius):
                continue
            overlap = _parallel_overlap(p, d, centre, radius)
        else:
            overlap = _perspective_overlap(
                (p[0], p[1], p[2] - distance),
                d,
                (centre[0], centre[1], centre[2] - distance),
                radius,
            )
        if overlap.high <= overlap.low:
            continue
        overs = _put_span(over, overs, overlap.low, overlap.high)
        hidden = _put_span(behind, hidden, overlap.behind_low, overlap.behind_high)
        # inside the ball: |p + t d - centre|^2 < r^2
        off = (p[0] - centre[0], p[1] - centre[1], p[2] - centre[2])
        first, last = _negative_interval(
            _dot(d, d), _dot(off, d), _dot(off, off) - radius * radius, 0.0, 1.0
        )
        hidden = _put_span(behind, hidden, first, last)
    return overs, hidden


@njit(cache=True)
def _clip_spans(spans: Floats, count: int, low: float, high: float, out: Floats) -> int:
    """Put what of intervals (R, 2) lies within low to high into `out` (R, 2); returns how many."""
    found = 0
    for k in range(count):
        found = _put_span(out, found, max(spans[k, 0], low), min(spans[k, 1], high))
    return found


@njit(cache=True)
def lines_among_balls(ends: Floats, balls: Floats, distance: float) -> Floats:
    """Find the pieces of straight lines that no ball hides.

    Parameters
    ----------
    ends
        (M, 2, 3) ends of the lines, view coordinates [m].
    balls
        (S, 4) view coordinates of the centres, and radii [m].
    distance
        Depth [m] of the eye; infinite in a parallel view.

    Returns
    -------
    Floats
        (K, 4) line, share of its length from and to, and 1 where a ball is behind the piece, else
        0.
    """
    room = 2 * len(balls) + 1
    over = np.empty((room, 2))
    behind = np.empty((room, 2))
    spans = np.empty((room, 2))
    visible = np.empty((2 * room + 2, 4))
    pieces = np.empty((4 * len(ends) + 64, 4))
    found = 0
    for i in range(len(ends)):
        p = _triple(ends, i, 0)
        q = _triple(ends, i, 1)
        d = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
        overs, hidden = _ball_spans(p, d, balls, distance, over, behind)
        for k in range(_put_pieces(i, behind, hidden, 0.0, 1.0, visible, 0)):
            if visible[k, 3] == 1.0:
                continue
            low = visible[k, 1]
            high = visible[k, 2]
            count = _clip_spans(over, overs, low, high, spans)
            pieces = with_room(pieces, found + 2 * count + 2)
            found = _put_pieces(i, spans, count, low, high, pieces, found)
    return pieces[:found]
