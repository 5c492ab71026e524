"""What flat triangles hide of arcs and of straight lines, in closed form: exact, no depth buffer.

Everything is in picture space: x right, y down [pixels] and projective depth w, larger nearer, in
which planes are planes and straight lines straight, in a parallel view and in perspective. A
triangle hides a point p where p lies inside its three sides and behind its plane: where four
functions a x + b y + c w + d are all at least 0. Along an ellipse m + cos(t) u + sin(t) v each of
them is h0 + hc cos t + hs sin t and holds on one interval of angle; along a line it is linear and
holds on one interval of the share. What no triangle hides is visible.

Triangles are looked up in a grid of square cells; every cell that a line or an ellipse's box meets
is asked.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.compiled import njit
from workbench.geometry.order import NONE, ONE, stable_order
from workbench.model.arrays import Floats, Ints

__all__ = ["Occluders", "hidden_arcs", "hidden_lines", "lines_among_balls", "occluder_planes"]

_TURN = 2.0 * math.pi
# intervals of one triangle on one arc: four cuts of a turn and its two neighbours give fewer
_MOST = 24
_NOTHING = 1e-9  # [rad] or share: a gap between neighbours' shares of a line no wider than rounding


class Occluders(NamedTuple):
    """Triangles in a grid. plane (T, 4, 4): a, b, c, d of three sides and the plane itself. cell
    [pixels]; columns, rows: of the grid; start (columns rows + 1,), inside: the triangles that meet
    each cell, row by row."""

    plane: Floats
    cell: float
    columns: int
    rows: int
    start: Ints
    inside: Ints


@njit(cache=True)
def occluder_planes(corners: Floats, bias: float) -> Floats:
    """(T, 4, 4) of triangles (T, 3, 3) in picture space; a point less than `bias` behind the plane
    is not hidden.

    A triangle seen edge-on hides nothing: its last function is -1 everywhere.
    """
    planes = np.zeros((len(corners), 4, 4))
    for t in range(len(corners)):
        a = corners[t, 0]
        b = corners[t, 1]
        c = corners[t, 2]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        if abs(area) < 1e-12:
            planes[t, 3, 3] = -1.0
            continue
        sense = 1.0 if area > 0.0 else -1.0
        for side in range(3):
            p = corners[t, side]
            q = corners[t, (side + 1) % 3]
            dx = q[0] - p[0]
            dy = q[1] - p[1]
            planes[t, side, 0] = -sense * dy
            planes[t, side, 1] = sense * dx
            planes[t, side, 3] = sense * (dy * p[0] - dx * p[1])
        right = ((b[2] - a[2]) * (c[1] - a[1]) - (c[2] - a[2]) * (b[1] - a[1])) / area
        down = ((c[2] - a[2]) * (b[0] - a[0]) - (b[2] - a[2]) * (c[0] - a[0])) / area
        planes[t, 3, 0] = right
        planes[t, 3, 1] = down
        planes[t, 3, 2] = -1.0
        planes[t, 3, 3] = a[2] - right * a[0] - down * a[1] - bias
    return planes


@njit(cache=True)
def _clip_spans(spans: Floats, count: int, low: float, high: float, room: Floats) -> int:
    """Intersect spans with the interval low to high and with itself a turn before and after; the
    new count."""
    found = 0
    for k in range(count):
        for turn in range(-1, 2):
            first = max(spans[k, 0], low + turn * _TURN)
            last = min(spans[k, 1], high + turn * _TURN)
            if last > first and found < len(room):
                room[found, 0] = first
                room[found, 1] = last
                found += 1
    for k in range(found):
        spans[k, 0] = room[k, 0]
        spans[k, 1] = room[k, 1]
    return found


@njit(cache=True)
def _arc_spans(
    rim: Floats, planes: Floats, origin: float, width: float, spans: Floats, room: Floats
) -> int:
    """Where one triangle hides an ellipse, as angles from `origin` to at most `width`; their
    number."""
    count = ONE
    spans[0, 0] = 0.0
    spans[0, 1] = width
    for k in range(4):
        a = planes[k, 0]
        b = planes[k, 1]
        c = planes[k, 2]
        d = planes[k, 3]
        level = a * rim[0, 0] + b * rim[0, 1] + c * rim[0, 2] + d
        cosine = a * rim[1, 0] + b * rim[1, 1] + c * rim[1, 2]
        sine = a * rim[2, 0] + b * rim[2, 1] + c * rim[2, 2]
        swing = math.hypot(cosine, sine)
        if level >= swing:
            continue
        if level <= -swing:
            return 0
        half = math.acos(-level / swing)
        middle = math.atan2(sine, cosine)
        low = (middle - half - origin) % _TURN
        count = _clip_spans(spans, count, low, low + 2.0 * half, room)
        if count == 0:
            return 0
    return count


@njit(cache=True)
def _grown(values: Floats, count: int) -> Floats:
    """Room for twice as many rows, where all are taken."""
    if count < len(values):
        return values
    larger = np.empty((2 * len(values), values.shape[1]))
    for row in range(len(values)):
        for column in range(values.shape[1]):
            larger[row, column] = values[row, column]
    return larger


@njit(cache=True)
def _put_pieces(
    which: int, spans: Floats, count: int, low: float, high: float, pieces: Floats, found: int
) -> int:
    """Merge `count` hidden spans and append the pieces of low to high: which, from, to, 1 hidden or
    0. No growth."""
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
        while k + 1 < count and spans[order[k + 1], 0] <= last + _NOTHING:
            k += 1
            last = max(last, spans[order[k], 1])
        k += 1
        if first > here + _NOTHING:
            pieces[found, 0] = which
            pieces[found, 1] = here
            pieces[found, 2] = first
            pieces[found, 3] = 0.0
            found += 1
        else:
            first = here
        if high - last <= _NOTHING:
            last = high
        pieces[found, 0] = which
        pieces[found, 1] = first
        pieces[found, 2] = last
        pieces[found, 3] = 1.0
        found = found + 1
        here = last
    if here < high:
        pieces[found, 0] = which
        pieces[found, 1] = here
        pieces[found, 2] = high
        pieces[found, 3] = 0.0
        found += 1
    return found


@njit(cache=True)
def _near(
    box: Floats,
    slope: Floats,
    cell: float,
    columns: int,
    rows: int,
    start: Ints,
    inside: Ints,
    seen: Ints,
    mark: int,
    out: Ints,
) -> int:
    """Triangles, each once, of the cells that a box meets: left, top, right, bottom; their number
    in `out`.

    slope: x at the box's top and bottom of a line that goes across it, or its left and right sides
    for a full box.
    """
    found = 0
    top = max(int(box[1] // cell), 0)
    bottom = min(int(box[3] // cell), rows - 1)
    for row in range(top, bottom + 1):
        left = box[0]
        right = box[2]
        if slope[2] > 0.0 and box[3] > box[1]:
            first = (min(max(row * cell, box[1]), box[3]) - box[1]) / (box[3] - box[1])
            last = (min(max((row + 1) * cell, box[1]), box[3]) - box[1]) / (box[3] - box[1])
            one = slope[0] + first * (slope[1] - slope[0])
            two = slope[0] + last * (slope[1] - slope[0])
            left = min(one, two)
            right = max(one, two)
        for column in range(max(int(left // cell), 0), min(int(right // cell), columns - 1) + 1):
            at = row * columns + column
            for k in range(start[at], start[at + 1]):
                triangle = inside[k]
                if seen[triangle] != mark:
                    seen[triangle] = mark
                    out[found] = triangle
                    found += 1
    return found


@njit(cache=True)
def _arc_pieces(
    rims: Floats,
    angle: Floats,
    planes: Floats,
    cell: float,
    columns: int,
    rows: int,
    start: Ints,
    inside: Ints,
) -> Floats:
    total = len(planes)
    seen = np.full(total, -1)
    near = np.empty(total, np.int64)
    spans = np.empty((_MOST, 2))
    room = np.empty((_MOST, 2))
    hidden = np.empty((64, 2))
    pieces = np.empty((4 * len(rims) + 64, 4))
    found = NONE
    box = np.empty(4)
    slope = np.zeros(3)
    for i in range(len(rims)):
        wide = math.hypot(rims[i, 1, 0], rims[i, 2, 0])
        high = math.hypot(rims[i, 1, 1], rims[i, 2, 1])
        box[0] = rims[i, 0, 0] - wide
        box[1] = rims[i, 0, 1] - high
        box[2] = rims[i, 0, 0] + wide
        box[3] = rims[i, 0, 1] + high
        count = NONE
        width = angle[i, 1] - angle[i, 0]
        for k in range(_near(box, slope, cell, columns, rows, start, inside, seen, i, near)):
            for s in range(_arc_spans(rims[i], planes[near[k]], angle[i, 0], width, spans, room)):
                hidden = _grown(hidden, count)
                hidden[count, 0] = angle[i, 0] + spans[s, 0]
                hidden[count, 1] = angle[i, 0] + spans[s, 1]
                count += 1
        while found + 2 * count + 2 > len(pieces):
            pieces = _grown(pieces, len(pieces))
        found = _put_pieces(i, hidden, count, angle[i, 0], angle[i, 1], pieces, found)
    return pieces[:found]


@njit(cache=True)
def _line_pieces(
    ends: Floats, planes: Floats, cell: float, columns: int, rows: int, start: Ints, inside: Ints
) -> Floats:
    total = len(planes)
    seen = np.full(total, -1)
    near = np.empty(total, np.int64)
    hidden = np.empty((64, 2))
    pieces = np.empty((4 * len(ends) + 64, 4))
    found = NONE
    box = np.empty(4)
    slope = np.ones(3)
    for i in range(len(ends)):
        p = ends[i, 0]
        q = ends[i, 1]
        if p[1] > q[1]:
            p = ends[i, 1]
            q = ends[i, 0]
        box[0], box[1], box[2], box[3] = min(p[0], q[0]), p[1], max(p[0], q[0]), q[1]
        slope[0] = p[0]
        slope[1] = q[0]
        count = NONE
        for k in range(_near(box, slope, cell, columns, rows, start, inside, seen, i, near)):
            first = 0.0
            last = 1.0
            for side in range(4):
                plane = planes[near[k], side]
                low = (
                    plane[0] * ends[i, 0, 0]
                    + plane[1] * ends[i, 0, 1]
                    + plane[2] * ends[i, 0, 2]
                    + plane[3]
                )
                high = (
                    plane[0] * ends[i, 1, 0]
                    + plane[1] * ends[i, 1, 1]
                    + plane[2] * ends[i, 1, 2]
                    + plane[3]
                )
                if low < 0.0 and high < 0.0:
                    last = -1.0
                elif low < 0.0:
                    first = max(first, low / (low - high))
                elif high < 0.0:
                    last = min(last, low / (low - high))
            if last > first:
                hidden = _grown(hidden, count)
                hidden[count, 0] = first
                hidden[count, 1] = last
                count += 1
        while found + 2 * count + 2 > len(pieces):
            pieces = _grown(pieces, len(pieces))
        found = _put_pieces(i, hidden, count, 0.0, 1.0, pieces, found)
    return pieces[:found]


@njit(cache=True)
def _between(a: float, b: float, c: float, first: float, last: float) -> tuple[float, float]:
    """Where a t^2 + 2 b t + c < 0, a not negative, within first to last; empty where the second is
    not larger."""
    if a <= 0.0:
        return (first, last) if c < 0.0 else (0.0, -1.0)
    rest = b * b - a * c
    if rest <= 0.0:
        return 0.0, -1.0
    root = math.sqrt(rest)
    return max(first, (-b - root) / a), min(last, (-b + root) / a)


@njit(cache=True)
def _positive_interval(
    level: float, slope: float, first: float, last: float
) -> tuple[float, float]:
    """Return where level + slope t > 0 for t from first to last; an end before the start is none."""
    if slope == 0.0:
        return (first, last) if level > 0.0 else (0.0, -1.0)
    return (max(first, -level / slope), last) if slope > 0.0 else (first, min(last, -level / slope))


@njit(cache=True)
def _occlusion_interval(
    p: Floats, d: Floats, ball: Floats, distance: float
) -> tuple[float, float, float, float]:
    """Find where the line p + t d, t from 0 to 1, crosses the outline of a ball.

    Coordinates are view coordinates, with the eye at depth `distance`, infinite in a parallel view.

    Returns
    -------
    tuple[float, float, float, float]
        From and to where the line is over the outline, and from and to where it is also behind the
        rim. An end before the start is none.
    """
    # In perspective, with u the centre and X a point as seen from the eye, the outline is the cone
    #     (u . X)^2 = (u . u - r^2) X . X,
    # and the rim lies in the plane u . X = u . u - r^2. On the line, the first is a quadratic
    # a t^2 + 2 b t + c = 0 and the second is linear in t.
    x = p[0] - ball[0]
    y = p[1] - ball[1]
    z = p[2] - ball[2]
    radius = ball[3]
    if math.isinf(distance):
        low, high = _between(
            d[0] * d[0] + d[1] * d[1],
            x * d[0] + y * d[1],
            x * x + y * y - radius * radius,
            0.0,
            1.0,
        )
        behind = _positive_interval(-z, -d[2], low, high)
        return low, high, behind[0], behind[1]
    ux = ball[0]
    uy = ball[1]
    uz = ball[2] - distance
    square = ux * ux + uy * uy + uz * uz - radius * radius
    px = p[0]
    py = p[1]
    pz = p[2] - distance
    level = ux * px + uy * py + uz * pz
    slope = ux * d[0] + uy * d[1] + uz * d[2]
    if square <= 0.0:  # the eye is in the ball, which is not drawn
        return 0.0, -1.0, 0.0, -1.0
    a = square * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - slope * slope
    b = square * (px * d[0] + py * d[1] + pz * d[2]) - level * slope
    c = square * (px * px + py * py + pz * pz) - level * level
    low, high = _positive_interval(level, slope, 0.0, 1.0)
    if a >= 0.0:
        low, high = _between(a, b, c, low, high)
    else:  # the line also crosses the mirrored cone behind the eye: one of the outer parts is ahead
        rest = math.sqrt(max(b * b - a * c, 0.0))
        one = (-b + rest) / a
        two = (-b - rest) / a
        if slope > 0.0:
            low = max(low, max(one, two))
        else:
            high = min(high, min(one, two))
    behind = _positive_interval(level - square, slope, low, high)
    return low, high, behind[0], behind[1]


@njit(cache=True)
def _ball_spans(
    p: Floats, d: Floats, balls: Floats, distance: float, over: Floats, behind: Floats
) -> tuple[int, int]:
    """Fill where a line is over the outlines of balls, and where it is behind or inside them; their
    numbers."""
    overs = NONE
    hidden = NONE
    a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    flat = math.isinf(distance)
    left = min(p[0], p[0] + d[0])
    right = max(p[0], p[0] + d[0])
    bottom = min(p[1], p[1] + d[1])
    top = max(p[1], p[1] + d[1])
    for j in range(len(balls)):
        x = balls[j, 0]
        y = balls[j, 1]
        radius = balls[j, 3]
        if flat and (
            x + radius < left or x - radius > right or y + radius < bottom or y - radius > top
        ):
            continue
        low, high, first, last = _occlusion_interval(p, d, balls[j], distance)
        if high <= low:
            continue
        over[overs, 0] = low
        over[overs, 1] = high
        overs += 1
        if last > first:
            behind[hidden, 0] = first
            behind[hidden, 1] = last
            hidden += 1
        x = p[0] - x
        y = p[1] - y
        z = p[2] - balls[j, 2]
        away = x * x + y * y + z * z - radius * radius
        first, last = _between(a, x * d[0] + y * d[1] + z * d[2], away, 0.0, 1.0)
        if last > first:
            behind[hidden, 0] = first
            behind[hidden, 1] = last
            hidden += 1
    return overs, hidden


@njit(cache=True)
def lines_among_balls(ends: Floats, balls: Floats, distance: float) -> Floats:
    """Pieces (K, 4) of lines `ends` (M, 2, 3) that no ball (S, 4) x, y, z, radius hides: line,
    share from and to, 1 where a ball is behind. View coordinates; see _occlusion_interval."""
    over = np.empty((len(balls) + 1, 2))
    behind = np.empty((2 * len(balls) + 1, 2))
    spans = np.empty((len(balls) + 1, 2))
    parts = np.empty((4 * len(balls) + 4, 4))
    small = np.empty((4 * len(balls) + 4, 4))
    pieces = np.empty((4 * len(ends) + 64, 4))
    found = NONE
    for i in range(len(ends)):
        p = ends[i, 0]
        d = ends[i, 1] - ends[i, 0]
        overs, hidden = _ball_spans(p, d, balls, distance, over, behind)
        for k in range(_put_pieces(i, behind, hidden, 0.0, 1.0, parts, NONE)):
            if parts[k, 3] == 1.0:
                continue
            count = NONE
            for s in range(overs):
                low = max(over[s, 0], parts[k, 1])
                high = min(over[s, 1], parts[k, 2])
                if high > low:
                    spans[count, 0] = low
                    spans[count, 1] = high
                    count += 1
            made = _put_pieces(i, spans, count, parts[k, 1], parts[k, 2], small, NONE)
            while found + made > len(pieces):
                pieces = _grown(pieces, len(pieces))
            for s in range(made):
                for part in range(4):
                    pieces[found, part] = small[s, part]
                found += 1
    return pieces[:found]


def hidden_arcs(rims: Floats, angle: Floats, hiders: Occluders) -> tuple[Ints, Floats, Ints]:
    """Pieces of arcs of ellipses `rims` (A, 3, 3): middle, u and v; angle (A, 2) from and to, at
    most a turn apart.

    Returns the arc (K,) of each piece, in turn, its angles (K, 2) and 1 where it is hidden (K,).
    """
    rows = _arc_pieces(
        rims,
        angle,
        hiders.plane,
        hiders.cell,
        hiders.columns,
        hiders.rows,
        hiders.start,
        hiders.inside,
    )
    return rows[:, 0].astype(np.int64), rows[:, 1:3], rows[:, 3].astype(np.int64)


def hidden_lines(ends: Floats, hiders: Occluders) -> tuple[Ints, Floats, Ints]:
    """Pieces of lines `ends` (M, 2, 3): the line (K,), shares of its length (K, 2) from and to, 1
    where hidden (K,)."""
    rows = _line_pieces(
        ends, hiders.plane, hiders.cell, hiders.columns, hiders.rows, hiders.start, hiders.inside
    )
    return rows[:, 0].astype(np.int64), rows[:, 1:3], rows[:, 3].astype(np.int64)
