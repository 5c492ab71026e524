"""Which spheres hide which part of another sphere's rim: one interval of angle for every pair, in
closed form.

Parallel view: the rim of sphere i is a circle at the constant depth z_i. With z = z_i - step,
sphere j hides a rim point exactly where its distance from j's centre in the picture is below rho,
rho^2 = r_j^2 - max(z - z_j, 0)^2. Perspective: with the eye at the origin, d the distance of a
centre and t = sqrt(d^2 - r^2) the length of the tangent, rim i is the circle t_i u of unit vectors
u at the angle asin(r_i / d_i) round its axis. Sphere j hides what lies t = t_i + step along u
exactly where u . c_j > t_j if t >= t_j, and where u . c_j > (t^2 + t_j^2) / (2 t) if not. Either is
linear in the cosine of the angle from the direction of j, so the hidden part is one interval. With
the same formula and no regard to depth, r_j or t_j gives the interval that lies over j's disk.

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
    "COINCIDE",
    "Rims",
    "candidates",
    "cells_of",
    "covered_by_few",
    "diamond_angle",
    "diamond_span",
    "grid_of",
    "keep_uncovered",
    "pair_cosines",
    "parallel_rims",
    "perspective_rims",
    "wrapped",
]

COINCIDE = 1e-7  # [unit of x, y], and a hundredth of it [rad]: rims nearer than this are one
_FEW = 6


class Rims(NamedTuple):
    """What the kernels know of S rims.

    balls: in a parallel view (S, 4) x, y, depth (larger is nearer), radius; in perspective (S, 15)
    x, y, distance along the view, radius, d, t, then three unit vectors: the axis, and two across
    it from which the angle is measured. near (S,): larger is nearer. box (S, 4): least and greatest
    x, y of a rim, in any unit. segment, body (S,); joined (N, N); step (S,): towards spheres of
    segments that are joined to its own, in the unit of depth. lens: 1 perspective.
    """

    balls: Floats
    near: Floats
    box: Floats
    segment: Ints
    body: Ints
    joined: Bools
    step: Floats
    lens: int


def parallel_rims(balls: Floats, segment: Ints, body: Ints, joined: Bools, step: Floats) -> Rims:
    """Rims of spheres `balls` (S, 4): x, y, depth, radius in one unit."""
    packed = np.ascontiguousarray(balls)
    box = np.column_stack([balls[:, :2] - balls[:, 3:], balls[:, :2] + balls[:, 3:]])
    return Rims(packed, np.ascontiguousarray(balls[:, 2]), box, segment, body, joined, step, 0)


def perspective_rims(balls: Floats, segment: Ints, body: Ints, joined: Bools, step: Floats) -> Rims:
    """Rims of spheres `balls` (S, 4): x, y, distance along the view from the eye, radius in one
    unit.

    The angle of a rim is 0 at its outermost point from the middle of the picture and grows from +x
    to +y. None holds the eye.
    """
    x, y, along, radius = balls.T
    off = np.hypot(x, y)
    far = np.sqrt(np.sum(balls[:, :3] ** 2, axis=1))
    tangent = np.sqrt(np.maximum(far * far - radius * radius, 0.0))
    turned = off > 1e-12 * far
    safe = np.where(turned, off, 1.0)
    hx = np.where(turned, x / safe, 1.0)
    hy = np.where(turned, y / safe, 0.0)
    sine = off / far
    cosine = along / far
    axes = [
        hx * sine,
        hy * sine,
        cosine,
        hx * cosine,
        hy * cosine,
        -sine,
        -hy,
        hx,
        np.zeros(len(balls)),
    ]
    packed = np.column_stack([balls, far, tangent, *axes])
    box = np.column_stack([*_ends(x, along, radius), *_ends(y, along, radius)])[:, [0, 2, 1, 3]]
    return Rims(np.ascontiguousarray(packed), -tangent, box, segment, body, joined, step, 1)


def _ends(across: Floats, along: Floats, radius: Floats) -> tuple[Floats, Floats]:
    """Least and greatest across / along of spheres; infinite for those that reach beside the
    eye."""
    ahead = along > radius
    square = np.where(ahead, along * along - radius * radius, 1.0)
    root = radius * np.sqrt(np.maximum(across * across + along * along - radius * radius, 0.0))
    low = (across * along - root) / square
    high = (across * along + root) / square
    return np.where(ahead, low, -np.inf), np.where(ahead, high, np.inf)


@njit(cache=True)
def pair_cosines(
    i: int, j: int, balls: Floats, lens: int, offset: float
) -> tuple[float, float, float, float, float]:
    """How sphere j covers rim i: direction x, y; cosine of half the hidden angle, of half that over
    j's disk; apart.

    A cosine of 1 or more: nothing; of -1 or less: all. apart: 0 where the two rims are one.
    """
    if lens == 0:
        dx = balls[j, 0] - balls[i, 0]
        dy = balls[j, 1] - balls[i, 1]
        radius = balls[i, 3]
        other = balls[j, 3]
        square = dx * dx + dy * dy
        apart = math.sqrt(square)
        below = max(balls[i, 2] - offset - balls[j, 2], 0.0)
        over = square + radius * radius - other * other
        side = 2.0 * apart * radius
        hidden = over + below * below
        unlike = apart + abs(radius - other)
    else:
        dot = 0.0
        dx = 0.0
        dy = 0.0
        for k in range(3):
            dot += balls[j, k] * balls[i, 6 + k]
            dx += balls[j, k] * balls[i, 9 + k]
            dy += balls[j, k] * balls[i, 12 + k]
        reach = balls[i, 5] + offset
        other = balls[j, 5]
        sine = balls[i, 3] / balls[i, 4]
        cosine = balls[i, 5] / balls[i, 4]
        apart = math.sqrt(dx * dx + dy * dy)
        over = other - cosine * dot
        side = sine * apart
        hidden = (
            over if reach >= other else over + (reach - other) * (reach - other) / (2.0 * reach)
        )
        unlike = 100.0 * (apart / balls[j, 4] + abs(sine - balls[j, 3] / balls[j, 4]))
    if unlike < COINCIDE:
        return dx, dy, 2.0, 2.0, 0.0
    if side < 1e-300:
        return 1.0, 0.0, 2.0 if hidden >= 0.0 else -2.0, 2.0 if over >= 0.0 else -2.0, unlike
    return dx, dy, hidden / side, over / side, unlike


@njit(cache=True)
def grid_of(box: Floats, near: Floats) -> tuple[Ints, Ints, Ints, Floats]:
    """Rims sorted into cells about as wide as a usual rim: start (C + 1,) of each cell, rims, cells
    each way, frame.

    box (S, 4); nearest rims come first in each cell. frame: least x, y and cells a unit; infinite
    ends lie outside.
    """
    low = np.empty(2)
    high = np.empty(2)
    wide = 0.0
    found = 0
    low[0] = np.inf
    low[1] = np.inf
    high[0] = -np.inf
    high[1] = -np.inf
    for n in range(len(box)):
        if math.isfinite(box[n, 0] + box[n, 1] + box[n, 2] + box[n, 3]):
            for k in range(2):
                low[k], high[k] = min(low[k], box[n, k]), max(high[k], box[n, 2 + k])
            wide = wide + box[n, 2] - box[n, 0]
            found = found + 1
    cells = np.ones(2, np.int64)
    frame = np.zeros(4)
    if found and wide > 0.0:
        for k in range(2):
            cells[k] = min(max(int((high[k] - low[k]) * found / wide), 1), 2048)
            frame[k], frame[2 + k] = low[k], cells[k] / max(high[k] - low[k], 1e-300)
    order = np.empty(len(near), np.int64)
    farness = np.empty(len(near))
    for n in range(len(near)):
        farness[n] = -near[n]
    stable_order(farness, len(near), order, np.empty(len(near), np.int64))
    start = np.zeros(cells[0] * cells[1] + 1, np.int64)
    for i in order:
        a, b, c, d = cells_of(box[i], cells, frame)
        for row in range(b, d):
            for column in range(a, c):
                start[row * cells[0] + column + 1] += 1
    at = np.empty(len(start) - 1, np.int64)
    for cell in range(len(at)):
        at[cell] = start[cell]
        start[cell + 1] += start[cell]
    rims = np.empty(start[-1], np.int64)
    for i in order:
        a, b, c, d = cells_of(box[i], cells, frame)
        for row in range(b, d):
            for column in range(a, c):
                cell = row * cells[0] + column
                rims[at[cell]] = i
                at[cell] += 1
    return start, rims, cells, frame


@njit(cache=True)
def cells_of(box: Floats, cells: Ints, frame: Floats) -> tuple[int, int, int, int]:
    """First column and row, and one past the last, of the cells that a box meets."""
    ends = np.empty(4, np.int64)
    for k in range(4):
        place = (box[k] - frame[k % 2]) * frame[2 + k % 2]
        ends[k] = int(min(max(place, 0.0), cells[k % 2] - 1.0)) if place == place else 0
    return ends[0], ends[1], ends[2] + 1, ends[3] + 1


@njit(cache=True)
def candidates(
    i: int,
    box: Floats,
    start: Ints,
    rims: Ints,
    cells: Ints,
    frame: Floats,
    stamp: Ints,
    found: Ints,
) -> int:
    """Rims j != i whose boxes meet that of i, into `found`; how many. stamp (S,) holds no i before
    the call."""
    count = 0
    a, b, c, d = cells_of(box[i], cells, frame)
    stamp[i] = i
    for row in range(b, d):
        for column in range(a, c):
            cell = row * cells[0] + column
            for k in range(start[cell], start[cell + 1]):
                j = rims[k]
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


@njit(cache=True)
def diamond(x: float, y: float) -> float:
    """Which way a vector points, from 0 along +x to below 4: it grows with its angle and takes no
    arc tangent."""
    if y >= 0.0:
        return y / (x + y) if x > 0.0 else (1.0 - x / (y - x) if y > 0.0 or x < 0.0 else 0.0)
    return 2.0 - y / (-x - y) if x < 0.0 else 3.0 + x / (x - y)


@njit(cache=True)
def wrapped(way: float) -> float:
    """A way of `diamond` within the turn from 0 to 4; several times as fast as a remainder."""
    return way - 4.0 * math.floor(0.25 * way)


@njit(cache=True)
def diamond_angle(way: float) -> float:
    """The angle [rad], from -pi to pi, of a `diamond` way, which may be some turns of 4 off."""
    way = wrapped(way)
    if way < 2.0:
        return math.atan2(way if way < 1.0 else 2.0 - way, 1.0 - way)
    return math.atan2(2.0 - way if way < 3.0 else way - 4.0, way - 3.0)


@njit(cache=True)
def diamond_span(x: float, y: float, cosine: float) -> tuple[float, float]:
    """From and to, in ways of `diamond`, of what lies within the angle with this cosine round (x,
    y)."""
    sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
    first = diamond(x * cosine + y * sine, y * cosine - x * sine)
    width = diamond(x * cosine - y * sine, y * cosine + x * sine) - first
    return first, first + (width if width >= 0.0 else width + 4.0)


@njit(cache=True)
def covered_by_few(pairs: Floats, count: int) -> tuple[float, float]:
    """From and to, in ways of `diamond`, what the few widest hidden intervals of a rim cover in one
    run.

    pairs (K, 4): x, y and cosines. A whole turn of 4 or more: all. Most hidden rims are so by
    three others.
    """
    widest = np.empty(_FEW, np.int64)
    most = 0
    for k in range(count):
        if pairs[k, 2] >= 0.9 or (most == _FEW and pairs[k, 2] >= pairs[widest[most - 1], 2]):
            continue
        place = min(most, _FEW - 1)
        most = min(most + 1, _FEW)
        while place > 0 and pairs[widest[place - 1], 2] > pairs[k, 2]:
            widest[place] = widest[place - 1]
            place -= 1
        widest[place] = k
    low = high = 0.0
    used = np.zeros(_FEW, np.bool_)
    grown = most > 0
    while grown and high - low < 4.0:
        grown = False
        for n in range(most):
            if used[n]:
                continue
            k = widest[n]
            first, end = diamond_span(pairs[k, 0], pairs[k, 1], pairs[k, 2])
            if n == 0:
                low = first
                high = end
                used[0] = True
                grown = True
                continue
            width = end - first
            first = low + wrapped(first - low)
            if first - 4.0 + width >= low:  # it comes round to the beginning
                first -= 4.0
            if first <= high:
                low = min(low, first)
                high = max(high, first + width)
                used[n] = True
                grown = True
    return low, high


@njit(cache=True)
def keep_uncovered(low: float, high: float, found: Ints, pairs: Floats, count: int) -> int:
    """Of the pairs (K, 4) only those that reach out of the hidden part from low to high (ways of
    `diamond`).

    An interval of half width h round v is inside one of half width H round m where the angle
    between them is at most H - h. Those that lie inside over their whole disk go; of the others
    nothing is changed. Returns how many are kept.
    """
    if high <= low:
        return count
    begin = diamond_angle(low)
    kept = 0
    half = 0.5 * ((diamond_angle(high) - begin) % math.tau)
    mx = math.cos(begin + half)
    my = math.sin(begin + half)
    least = math.cos(half)
    for k in range(count):
        cosine = pairs[k, 3]
        if cosine > -1.0 and cosine >= least:
            along = (mx * pairs[k, 0] + my * pairs[k, 1]) / math.sqrt(
                pairs[k, 0] ** 2 + pairs[k, 1] ** 2
            )
            sine = math.sqrt(max((1.0 - along * along) * (1.0 - cosine * cosine), 0.0))
            if along > -cosine and along * cosine - sine >= least:
                continue
        found[kept] = found[k]
        for part in range(4):
            pairs[kept, part] = pairs[k, part]
        kept += 1
    return kept
