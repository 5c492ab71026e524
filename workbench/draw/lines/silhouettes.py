"""Cut the rims of spheres into visible arcs, exactly: one interval of angle for every pair.

Parallel view. The rim of sphere i is a circle at the constant depth z_i. With z = z_i - step,
sphere j hides a point of the rim where the point's distance from j's centre in the picture is below
rho, with rho^2 = r_j^2 - max(z - z_j, 0)^2.

Perspective. The eye is at the origin, d is the distance of a centre, and t = sqrt(d^2 - r^2) is the
length of the tangent. Rim i is the circle t_i u of the unit vectors u at the angle asin(r_i / d_i)
from its axis. With t = t_i + step, sphere j hides the point in direction u where

    u . c_j > t_j                      if t >= t_j,
    u . c_j > (t^2 + t_j^2) / (2 t)    otherwise.

Either condition is linear in the cosine of the angle from the direction of j, so the hidden part is
one interval. The same formula without depth (r_j, or t_j) gives the interval over j's disk. What no
interval covers is visible; what of it lies over no disk of the same body is against the background.

`step` is 0, or for spheres of segments that are joined the least step of depth that is drawn. The
creases between them are shallower and vanish, and a limb fades into the body at its joint. Angles
run from +x to +y. Of two rims that coincide, that of the nearer sphere is drawn, or the first.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.geometry.box_pairs import box_pairs
from workbench.model.arrays import Bools, Floats, Ints

__all__ = [
    "Rims",
    "UncoveredIntervals",
    "ball_extent",
    "gaps_along",
    "gaps_round",
    "parallel_rims",
    "perspective_rims",
    "silhouette_arcs",
]

_COINCIDENCE = 1e-7
"""Distance [unit of x, y], and a hundredth of it [rad], below which two rims are one."""
_TINY = 1e-300
"""Divisor below which a quotient is not taken."""
_ALL_ROUND = math.pi + 0.1
"""Half an interval [rad] that surely covers the turn."""
_OPEN = -1
"""In place of a sphere: no other arc goes on at this end."""
_BATCH_SIZE = 20_000_000
"""Pairs of rims that are sought at a time, at most."""


class Rims(NamedTuple):
    """The rims of S spheres, of N segments, as they are cut."""

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
    box = np.column_stack([*ball_extent(x, along, radius), *ball_extent(y, along, radius)])[
        :, [0, 2, 1, 3]
    ]
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


def ball_extent(across: Floats, along: Floats, radius: Floats) -> tuple[Floats, Floats]:
    """Return the least and greatest across / along of spheres; infinite beside the eye."""
    ahead = along > radius
    square = np.where(ahead, along * along - radius * radius, 1.0)
    root = radius * np.sqrt(np.maximum(across * across + along * along - radius * radius, 0.0))
    low = (across * along - root) / square
    high = (across * along + root) / square
    return np.where(ahead, low, -np.inf), np.where(ahead, high, np.inf)


# ----------------------------------------------------------------------------------- pairs


class _Pairs(NamedTuple):
    """How spheres j cover rims i, (K,) each. A cosine of 1 or more means nothing, of -1 or less
    all."""

    angle: Floats
    """Direction [rad] of j from i."""
    hidden: Floats
    """Cosine of half the angle of what j hides."""
    over: Floats
    """Cosine of half the angle of what lies over the disk of j."""
    coincides: Bools
    """Whether the two rims are one."""


def _pair_cosines(i: Ints, j: Ints, rims: Rims) -> _Pairs:
    """Compute how spheres j (K,) cover rims i (K,)."""
    offset = np.where(rims.joined[rims.segment[i], rims.segment[j]], rims.step[i], 0.0)
    if rims.is_perspective:
        # A point of rim i at the angle a from the direction of j has
        # u . c_j = cosine (axis . c_j) + sine |across . c_j| cos(a).
        column = rims.balls.T
        centre = [axis[j] for axis in column[:3]]
        along, dx, dy = (
            sum(axis[i] * part for axis, part in zip(column[k : k + 3], centre, strict=True))
            for k in (6, 9, 12)
        )
        sine = column[3] / column[4]
        across = np.hypot(dx, dy)
        other = column[5][j]
        reach = column[5][i] + offset
        over = other - (column[5] / column[4])[i] * along
        below = np.where(reach < other, (reach - other) ** 2 / (2.0 * reach), 0.0)
        side = sine[i] * across
        apart = 100.0 * (across / column[4][j] + np.abs(sine[i] - sine[j]))
    else:
        # A point of rim i at the angle a from the direction of j has the squared distance
        # D^2 + r_i^2 - 2 D r_i cos(a) from j's centre in the picture.
        dx, dy, depth = (axis[j] - axis[i] for axis in rims.balls.T[:3])
        radius = rims.balls[:, 3][i]
        other = rims.balls[:, 3][j]
        distance = np.hypot(dx, dy)
        over = dx * dx + dy * dy + radius * radius - other * other
        below = np.maximum(-depth - offset, 0.0) ** 2
        side = 2.0 * distance * radius
        apart = distance + np.abs(radius - other)
    return _Pairs(
        np.arctan2(dy, dx), _divided(over + below, side), _divided(over, side), apart < _COINCIDENCE
    )


def _divided(level: Floats, side: Floats) -> Floats:
    """Divide to cosines; in the same direction it is all or nothing."""
    far = side >= _TINY
    return np.where(far, level / np.where(far, side, 1.0), np.where(level >= 0.0, 2.0, -2.0))


# ------------------------------------------------------------------------------------ arcs


class _Covers(NamedTuple):
    """Intervals of angle on rims, (K,) each."""

    rim: Ints
    start: Floats
    end: Floats
    """[rad]."""
    sphere: Ints
    """The sphere of the same body whose rim goes on where this one is cut; `_OPEN` for none."""
    hides: Bools
    """Whether the rim is hidden, or only before its own body."""


def silhouette_arcs(rims: Rims) -> tuple[Floats, Ints]:
    """Find the visible arcs of rims.

    Parameters
    ----------
    rims
        As of `parallel_rims` or `perspective_rims`.

    Returns
    -------
    tuple[Floats, Ints]
        Angles (A, 2) [rad] from and to, the second larger, and keys (A, 4):

        0. the sphere;
        1. the sphere of the same body whose arc leads into this one at its start, -1 for none, the
           own number for a circle that closes;
        2. the sphere whose arc goes on at its end, in the same way;
        3. 1 where nothing of its own body lies behind (against the background), else 0.

        In the order of the spheres, and of angles from -pi on.
    """
    count = len(rims.near)
    size = max(_BATCH_SIZE // max(count, 1), 1)
    angles = [np.empty((0, 2))]
    keys = [np.empty((0, 4), dtype=np.int64)]
    drawn = np.arange(count + 1)
    drawn[count] = _OPEN
    for first in range(0, count, size):
        angle, key = _batch_arcs(rims, np.arange(first, min(first + size, count)), drawn)
        angles.append(angle)
        keys.append(key)
    key = np.concatenate(keys)
    key[:, 1:3] = drawn[key[:, 1:3]]  # of two rims that coincide an arc leads to the drawn one
    return np.concatenate(angles), key


def _batch_arcs(rims: Rims, batch: Ints, drawn: Ints) -> tuple[Floats, Ints]:
    """Cut the rims `batch` (M,) and fill `drawn` (S,): the one that is drawn of all that coincide
    with each."""
    row, j = box_pairs(rims.box[batch], rims.box)
    i = batch[row]
    i, j = i[i != j], j[i != j]
    pairs = _pair_cosines(i, j, rims)
    near = rims.near
    before = pairs.coincides & ((near[j] > near[i]) | ((near[j] == near[i]) & (j < i)))
    is_gone = np.zeros(len(near), dtype=np.bool_)
    is_gone[i[before | (~pairs.coincides & (pairs.hidden <= -1.0))]] = True
    twin = np.flatnonzero(before & (rims.body[i] == rims.body[j]))
    twin = twin[np.lexsort((-j[twin], near[j[twin]], i[twin]))]  # the nearest, or first, comes last
    last = np.flatnonzero(np.diff(i[twin], append=-1))
    drawn[i[twin[last]]] = j[twin[last]]
    kept = ~pairs.coincides & (pairs.over < 1.0) & ~is_gone[i]
    covers = _pair_covers(rims, i[kept], j[kept], _Pairs._make(part[kept] for part in pairs))
    outer = gaps_round(covers.rim, covers.start, covers.end, math.tau)
    # what is hidden or against the background leaves what is seen before the own body
    hides = covers.hides
    rest = _Covers(
        np.concatenate([covers.rim[hides], outer.item]),
        np.concatenate([covers.start[hides], outer.low]),
        np.concatenate([covers.end[hides], outer.high]),
        np.concatenate([covers.sphere[hides], np.full(len(outer.item), _OPEN)]),
        np.ones(np.count_nonzero(hides) + len(outer.item), dtype=np.bool_),
    )
    inner = gaps_round(rest.rim, rest.start, rest.end, math.tau)
    uncut = batch[~is_gone[batch]]
    alone = np.setdiff1d(uncut, covers.rim)
    before_body = np.setdiff1d(np.setdiff1d(uncut, alone), rest.rim)
    whole = np.concatenate([alone, before_body])
    rim = np.concatenate([outer.item, inner.item, whole])
    start = np.concatenate([outer.low, inner.low, np.zeros(len(whole))])
    end = np.concatenate([outer.high, inner.high, np.full(len(whole), math.tau)])
    lead = np.concatenate([covers.sphere[outer.before], rest.sphere[inner.before], whole])
    follow = np.concatenate([covers.sphere[outer.after], rest.sphere[inner.after], whole])
    is_outer = np.zeros(len(rim), dtype=np.int64)
    is_outer[: len(outer.item)] = 1
    is_outer[len(rim) - len(whole) : len(rim) - len(before_body)] = 1
    first = start - math.tau * np.floor(start / math.tau + 0.5)
    order = np.lexsort((first, rim))
    angle = np.column_stack([first, first + (end - start)])
    return angle[order], np.column_stack([rim, lead, follow, is_outer])[order]


def _pair_covers(rims: Rims, i: Ints, j: Ints, pairs: _Pairs) -> _Covers:
    """Return the intervals that spheres j (K,) cover on rims i (K,).

    What lies over the disk of a sphere of another body is against the background.
    """
    same_body = rims.body[i] == rims.body[j]
    is_whole = pairs.hidden == pairs.over  # then the rim ends on that of j, which may go on
    hides = pairs.hidden < 1.0
    only_over = same_body & ~is_whole
    hidden_half = np.arccos(np.clip(pairs.hidden, -1.0, 1.0))
    over_half = np.where(pairs.over > -1.0, np.arccos(np.clip(pairs.over, -1.0, 1.0)), _ALL_ROUND)
    half = np.concatenate([hidden_half[hides], over_half[only_over]])
    angle = np.concatenate([pairs.angle[hides], pairs.angle[only_over]])
    ahead = np.where(same_body & is_whole, j, _OPEN)
    return _Covers(
        np.concatenate([i[hides], i[only_over]]),
        angle - half,
        angle + half,
        np.concatenate([ahead[hides], j[only_over]]),
        np.repeat([True, False], [np.count_nonzero(hides), np.count_nonzero(only_over)]),
    )


_LEAST_ROUND = 1e-12
"""[rad] A gap of a rim no wider than this is rounding."""
_LEAST_ALONG = 1e-9
"""[rad] or share of a line: the same of a line, whose ends lie hundreds of pixels off."""


class UncoveredIntervals(NamedTuple):
    """What no interval covers, in the order of the items and along each."""

    item: Ints
    """(G,)."""
    low: Floats
    """(G,) where a gap begins, and (G,) where it ends."""
    high: Floats
    before: Ints
    """(G,) the interval that ends where a gap begins, and (G,) the one that begins at its end."""
    after: Ints


def gaps_round(item: Ints, start: Floats, end: Floats, turn: float) -> UncoveredIntervals:
    """Find what intervals leave of closed rims, as far as those have any interval.

    Parameters
    ----------
    item, start, end
        (K,) the rim, the beginning and the end of each interval; none is longer than two turns.
    turn
        Length of a rim.

    Returns
    -------
    Gaps
        Their beginnings are within a turn of the rim's first interval.
    """
    low = start % turn
    return _gaps(item, low, low + (end - start), turn, _LEAST_ROUND)


def gaps_along(item: Ints, start: Floats, end: Floats, length: Floats) -> UncoveredIntervals:
    """Find what intervals leave of lines, from 0 to their lengths.

    Parameters
    ----------
    item, start, end
        (K,) the line, the beginning and the end of each interval.
    length
        (M,) of all lines.

    Returns
    -------
    Gaps
        `before` is -1 where a gap begins at 0; `after` is K or more where it ends with the line.
    """
    lines = np.arange(len(length))
    return _gaps(
        np.concatenate([item, lines]),
        np.concatenate([start, length]),
        np.concatenate([end, length]),
        None,
        _LEAST_ALONG,
    )


def _gaps(
    item: Ints, start: Floats, end: Floats, turn: float | None, least: float
) -> UncoveredIntervals:
    """Find the gaps before intervals: on a line (`turn` is None) from 0 on, on a rim from the end
    of the interval that reaches farthest into the next turn."""
    if not len(item):
        return UncoveredIntervals(item, start, end, item, item)
    order = np.lexsort((start, item))
    farness = np.lexsort((end, item))
    rank = np.empty(len(item), dtype=np.int64)
    rank[farness] = np.arange(len(item))
    sorted_item = item[order]
    # of the intervals of its item up to each, the one that reaches farthest
    farthest = farness[np.maximum.accumulate(rank[order])]
    is_first = np.diff(sorted_item, prepend=-1) > 0
    before = np.concatenate([[-1], farthest[:-1]])
    reach = np.where(is_first, -np.inf, end[before])
    if turn is None:
        floor = np.zeros(len(item))
        floor_of = np.full(len(item), -1)
    else:
        blocks = np.flatnonzero(is_first)
        count = np.diff(blocks, append=len(item))
        floor_of = np.repeat(farthest[blocks + count - 1], count)
        floor = end[floor_of] - turn
    before = np.where(reach >= floor, before, floor_of)
    reach = np.maximum(reach, floor)
    high = start[order]
    gap = np.flatnonzero(high > reach + least)
    return UncoveredIntervals(sorted_item[gap], reach[gap], high[gap], before[gap], order[gap])
