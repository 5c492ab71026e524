"""Cut the rims of spheres into visible arcs, exactly: see `kernels.silhouettes` for the intervals.

What no interval of another sphere covers is visible. Where a step of depth is given, the creases
between spheres of joined segments are shallower and vanish, and a limb fades into the body at its
joint. Angles run from +x to +y. Of two rims that coincide, that of the nearer sphere is drawn, or
the first.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.compiled import njit
from workbench.draw.kernels.silhouettes import (
    COINCIDENCE,
    TURN,
    Rims,
    build_grid,
    candidates,
    cell_of,
    covered_by_few,
    keep_uncovered,
    pair_cosines,
    pseudo_angle_interval,
    pseudo_angle_to_radians,
    wrap_turn,
)
from workbench.geometry.order import stable_order
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["arc_chains", "ends_met", "silhouette_arcs"]

_MIN_GAP = 1e-12
"""Pseudo-angle: a gap no wider than this is rounding."""
_INSET = 1e-9
"""Pseudo-angle by which a run of hidden intervals is narrowed at both ends. The intervals at its
ends then stay, and name the arcs that go on there."""
_ALL_ROUND = 4.1
"""End of an interval that surely covers the turn from 0."""
# kinds of an interval, which can be both
_HIDES = 1
"""The rim is hidden."""
_CONTINUES = 1 + 1
"""The rim ends where that of another sphere of the same body goes on."""
_OPEN = 0 - 1
"""In place of a sphere: no other arc goes on at this end."""


class _Intervals(NamedTuple):
    """Intervals of pseudo-angle on one rim, working arrays of R rows."""

    span: Floats
    """(R, 2) from and to."""
    sphere: Ints
    """(R,) the sphere that makes each."""
    kind: Ints
    """(R,) `_HIDES`, `_CONTINUES` or both."""
    order: Ints
    """(R,) rows by their starts."""
    keys: Floats
    """(R,) and (R,): spare arrays of the sort."""
    spare: Ints


class _Gaps(NamedTuple):
    """What intervals leave of a rim, working arrays of R rows."""

    span: Floats
    """(R, 2) pseudo-angles from and to."""
    edge: Ints
    """(R, 2) rows of the intervals that end and start there."""


class _ArcRows(NamedTuple):
    """Arcs as `silhouette_arcs` returns them: angles (R, 2) and keys (R, 4)."""

    angle: Floats
    key: Ints


@njit(cache=True)
def _put_interval(
    intervals: _Intervals, count: int, first: float, end: float, sphere: int, kind: int
) -> int:
    """Append an interval; returns the new count."""
    intervals.span[count, 0] = first
    intervals.span[count, 1] = end
    intervals.sphere[count] = sphere
    intervals.kind[count] = kind
    return count + 1


@njit(cache=True)
def _find_overlaps(i: int, rims: Rims, found: Ints, count: int, pairs: Floats) -> int:
    """Keep of the first `count` rims `found` those that reach over rim i.

    pairs (S, 4) is filled with directions and cosines, see `pair_cosines`. Returns how many are
    kept, -1 where one hides all of rim i.
    """
    near = rims.near
    segment = rims.segment
    kept = 0
    for k in range(count):
        j = found[k]
        offset = rims.step[i] if rims.joined[segment[i], segment[j]] else 0.0
        pair = pair_cosines(i, j, rims.balls, rims.is_perspective, offset)
        if pair.apart == 0.0:
            if near[j] > near[i] or (near[j] == near[i] and j < i):
                return -1
            continue
        if pair.hidden <= -1.0:
            return -1
        if pair.over < 1.0:
            found[kept] = j
            pairs[kept, 0] = pair.x
            pairs[kept, 1] = pair.y
            pairs[kept, 2] = pair.hidden
            pairs[kept, 3] = pair.over
            kept += 1
    return kept


@njit(cache=True)
def _put_pair(
    intervals: _Intervals, count: int, sphere: int, same_body: bool, pairs: Floats, k: int
) -> int:
    """Append the intervals of pair k (S, 4) on a rim; returns the new count.

    same_body: both spheres are of one body. Then what lies over the disk of the other one is not
    against the background.
    """
    x = pairs[k, 0]
    y = pairs[k, 1]
    hidden = pairs[k, 2]
    over = pairs[k, 3]
    if hidden >= 1.0 and not same_body:
        return count
    is_whole = hidden == over  # then the rim ends on that of the other sphere, which may go on
    if hidden < 1.0:
        first, end = pseudo_angle_interval(x, y, hidden)
        kind = _HIDES | (_CONTINUES if same_body and is_whole else 0)
        count = _put_interval(intervals, count, first, end, sphere, kind)
    if same_body and not is_whole:
        first = 0.0
        end = _ALL_ROUND
        if over > -1.0:
            first, end = pseudo_angle_interval(x, y, over)
        count = _put_interval(intervals, count, first, end, sphere, _CONTINUES)
    return count


@njit(cache=True)
def _find_gaps(intervals: _Intervals, count: int, kind: int, gaps: _Gaps) -> int:
    """Find what no interval of a kind covers on the turn 0 to `TURN`; returns the number of gaps.

    The first `count` intervals are in `order`, and one of the kind starts at 0.
    """
    span = intervals.span
    kinds = intervals.kind
    order = intervals.order
    reach = 0.0
    last = -1
    first = -1
    for n in range(count):  # what reaches from the turn before into this one
        k = order[n]
        if kinds[k] & kind and (first < 0 or span[k, 1] - TURN > reach):
            reach = max(reach, span[k, 1] - TURN)
            last = k
            first = k if first < 0 else first
    found = 0
    for n in range(count):
        k = order[n]
        if not kinds[k] & kind:
            continue
        if span[k, 0] > reach + _MIN_GAP:
            found = _put_gap(gaps, found, reach, span[k, 0], last, k)
        if span[k, 1] > reach:
            reach = span[k, 1]
            last = k
    if reach < TURN - _MIN_GAP:
        found = _put_gap(gaps, found, reach, TURN, last, first)
    return found


@njit(cache=True)
def _put_gap(gaps: _Gaps, count: int, low: float, high: float, before: int, after: int) -> int:
    """Append a gap between the intervals `before` and `after`; returns the new count."""
    gaps.span[count, 0] = low
    gaps.span[count, 1] = high
    gaps.edge[count, 0] = before
    gaps.edge[count, 1] = after
    return count + 1


@njit(cache=True)
def _start_at_interval(intervals: _Intervals, count: int) -> tuple[float, bool]:
    """Turn the first `count` intervals so that one starts at 0, and sort them.

    Returns the pseudo-angle from which they count now, that of the first interval that hides, and
    whether there is such an interval.
    """
    span = intervals.span
    origin = span[0, 0]
    is_hidden = False
    for k in range(count - 1, -1, -1):
        if intervals.kind[k] & _HIDES:
            origin = span[k, 0]
            is_hidden = True
    for k in range(count):
        width = span[k, 1] - span[k, 0]
        span[k, 0] = wrap_turn(span[k, 0] - origin)
        span[k, 1] = span[k, 0] + width
        intervals.keys[k] = span[k, 0]
    stable_order(intervals.keys, count, intervals.order, intervals.spare)
    return origin, is_hidden


@njit(cache=True)
def _cut_rim(
    i: int, intervals: _Intervals, count: int, seen: _Gaps, outer: _Gaps, arcs: _ArcRows
) -> int:
    """Put the arcs of rim i that its first `count` intervals leave into `arcs`, in order round it.

    seen, outer: filled with what is visible, and with what of it is against the background. Returns
    the number of arcs.
    """
    origin, is_hidden = _start_at_interval(intervals, count)
    outers = _find_gaps(intervals, count, _HIDES | _CONTINUES, outer)
    seens = 1
    if is_hidden:
        seens = _find_gaps(intervals, count, _HIDES, seen)
    found = 0
    o = 0
    for v in range(seens):
        here = 0.0
        stop = TURN
        start_sphere = i
        end_sphere = i
        if is_hidden:
            here = seen.span[v, 0]
            stop = seen.span[v, 1]
            start_sphere = _sphere_ahead(intervals, seen.edge[v, 0])
            end_sphere = _sphere_ahead(intervals, seen.edge[v, 1])
        # every gap of `outer` lies in one of `seen`: between them the own body is behind
        while o < outers and outer.span[o, 1] <= stop + _MIN_GAP:
            low = outer.span[o, 0]
            high = outer.span[o, 1]
            if low > here + _MIN_GAP:
                _put_arc(arcs, found, here + origin, low + origin)
                found = _put_key(arcs, found, i, start_sphere, _OPEN, 0)
            first = _sphere_ahead(intervals, outer.edge[o, 0])
            last = _sphere_ahead(intervals, outer.edge[o, 1])
            _put_arc(arcs, found, low + origin, high + origin)
            found = _put_key(arcs, found, i, first, last, 1)
            here = high
            start_sphere = _OPEN
            o += 1
        if stop > here + _MIN_GAP:
            _put_arc(arcs, found, here + origin, stop + origin)
            found = _put_key(arcs, found, i, start_sphere, end_sphere, 0)
    return found


@njit(cache=True)
def _sphere_ahead(intervals: _Intervals, k: int) -> int:
    """Return the sphere whose rim goes on where interval k begins or ends, or `_OPEN`."""
    return intervals.sphere[k] if intervals.kind[k] & _CONTINUES else _OPEN


@njit(cache=True)
def _put_arc(arcs: _ArcRows, row: int, start: float, end: float) -> None:
    """Write the angles [rad] of an arc between two pseudo-angles."""
    first = pseudo_angle_to_radians(start)
    width = (pseudo_angle_to_radians(end) - first) % math.tau
    if end - start > TURN - _MIN_GAP:
        width = math.tau
    elif end - start < 1.0 and width > math.pi:  # rounded to less than nothing
        width = 0.0
    arcs.angle[row, 0] = first
    arcs.angle[row, 1] = first + width


@njit(cache=True)
def _put_key(arcs: _ArcRows, row: int, sphere: int, before: int, after: int, is_outer: int) -> int:
    """Write the key of an arc; returns the number of arcs."""
    arcs.key[row, 0] = sphere
    arcs.key[row, 1] = before
    arcs.key[row, 2] = after
    arcs.key[row, 3] = is_outer
    return row + 1


@njit(cache=True)
def _drawn_twin(i: int, rims: Rims, found: Ints, count: int) -> int:
    """Return which of the rims of one body that coincide with rim i is drawn."""
    near = rims.near
    twin = i
    for k in range(count):
        j = found[k]
        if rims.body[i] != rims.body[j] or abs(rims.box[j, 0] - rims.box[i, 0]) > COINCIDENCE:
            continue
        is_nearer = near[j] > near[twin] or (near[j] == near[twin] and j < twin)
        if is_nearer:
            pair = pair_cosines(i, j, rims.balls, rims.is_perspective, 0.0)
            twin = j if pair.apart == 0.0 else twin
    return twin


@njit(cache=True)
def _rim_intervals(
    i: int, rims: Rims, found: Ints, pairs: Floats, number: int, intervals: _Intervals
) -> int:
    """Collect the intervals of rim i from the spheres that may reach over it.

    found, pairs, number: the candidates (S,), working space (S, 4), and how many candidates there
    are. Returns how many intervals there are, -1 where the rim is hidden.
    """
    number = _find_overlaps(i, rims, found, number, pairs)
    if number < 0:
        return -1
    low, high = covered_by_few(pairs, number)
    if high - low >= TURN:
        return -1
    low = low + _INSET
    high = high - _INSET
    number = keep_uncovered(low, high, found, pairs, number)
    count = 0
    for k in range(number):
        same_body = rims.body[i] == rims.body[found[k]]
        count = _put_pair(intervals, count, found[k], same_body, pairs, k)
    if high > low:
        count = _put_interval(intervals, count, low, high, i, _HIDES)
    return count


@njit(cache=True)
def _all_arcs(rims: Rims, arcs: _ArcRows, twins: Ints) -> int:
    """Fill arcs (R rows) and twins (S + 1,): the drawn one of the rims that coincide with each.

    Returns the number of arcs, which may be more than R: then there are too few rows.
    """
    count = len(rims.near)
    grid = build_grid(rims.box, rims.near)
    stamp = np.full(count, -1)
    found = np.empty(count, np.int64)
    pairs = np.empty((count, 4))
    room = 2 * count + 2
    intervals = _Intervals(
        np.empty((room, 2)),
        np.empty(room, np.int64),
        np.empty(room, np.int64),
        np.empty(room, np.int64),
        np.empty(room),
        np.empty(room, np.int64),
    )
    seen = _Gaps(np.empty((room, 2)), np.empty((room, 2), np.int64))
    outer = _Gaps(np.empty((room, 2)), np.empty((room, 2), np.int64))
    own = _ArcRows(np.empty((room, 2)), np.empty((room, 4), np.int64))
    total = 0
    for i in range(count):
        number = candidates(i, rims.box, grid, stamp, found)
        twins[i] = _drawn_twin(i, rims, found, number)
        cuts = _rim_intervals(i, rims, found, pairs, number, intervals)
        if cuts < 0:
            continue
        if cuts:
            number = _cut_rim(i, intervals, cuts, seen, outer, own)
        else:
            _put_arc(own, 0, 0.0, TURN)
            number = _put_key(own, 0, i, i, i, 1)
        _copy_rows(own, min(number, len(arcs.key) - total), arcs, total)
        total += number
    return total


@njit(cache=True)
def _copy_rows(source: _ArcRows, count: int, arcs: _ArcRows, first: int) -> None:
    """Copy the first `count` rows into `arcs` from row `first` on."""
    for row in range(count):
        for end in range(2):
            arcs.angle[first + row, end] = source.angle[row, end]
        for part in range(4):
            arcs.key[first + row, part] = source.key[row, part]


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
    """
    twins = np.full(len(rims.near) + 1, -1)
    found = 4 * len(rims.near)
    room = -1
    while found > room:
        room = found
        arcs = _ArcRows(np.empty((room, 2)), np.empty((room, 4), np.int64))
        found = _all_arcs(rims, arcs, twins)
    angle = arcs.angle[:found]
    key = arcs.key[:found]
    key[:, 1:3] = twins[key[:, 1:3]]  # of two rims that coincide an arc leads to the drawn one
    return angle, key


@njit(cache=True)
def arc_chains(following: Ints) -> tuple[Ints, Ints]:
    """Chain arcs in the order in which a pen draws them.

    Parameters
    ----------
    following
        (A,) the arc that goes on where one ends, -1 for none. No two have the same.

    Returns
    -------
    tuple[Ints, Ints]
        The arcs (A,) in order, and where (C,) each chain starts in it. Chains with a beginning come
        first, closed ones after them, each by the number of its first arc.
    """
    count = len(following)
    begins = np.ones(count, dtype=np.bool_)
    done = np.zeros(count, dtype=np.bool_)
    for arc in range(count):
        if following[arc] >= 0:
            begins[following[arc]] = False
    order = np.empty(count, dtype=np.int64)
    start = np.empty(count, dtype=np.int64)
    drawn = 0
    chains = 0
    for closed in range(2):
        for arc in range(count):
            if done[arc] or (closed == 0 and not begins[arc]):
                continue
            start[chains] = drawn
            chains = chains + 1
            while arc >= 0 and not done[arc]:
                order[drawn] = arc
                done[arc] = True
                drawn = drawn + 1
                arc = following[arc]
    return order, start[:chains]


@njit(cache=True)
def ends_met(
    points: Floats,
    own: Ints,
    disk: Floats,
    angle: Floats,
    chain: Ints,
    is_long: Bools,
    distance: float,
) -> Bools:
    """Test whether ends of chains lie close to an arc of another chain.

    Parameters
    ----------
    points, own
        (M, 2) ends [pixels], and (M,) the chain of each.
    disk, angle, chain
        The arcs of ellipses. (A, 5) x, y, longer half axis, the shorter as a share of it, and the
        direction of the longer [rad]; (A, 2) angles from and to; (A,) the chain of each.
    is_long
        (C,) whether a chain is long.
    distance
        [pixels]. Distances from an ellipse are measured as if it were stretched to a circle.

    Returns
    -------
    Bools
        (M, 2) whether an end meets any other chain, and whether it meets a long one.
    """
    met = np.zeros((len(points), 2), dtype=np.bool_)
    grid = build_grid(_arc_boxes(disk, distance), np.zeros(len(chain)))
    start = grid.start
    members = grid.members
    for end in range(len(points)):
        cell = cell_of(points[end, 0], points[end, 1], grid)
        for n in range(start[cell], start[cell + 1]):
            arc = members[n]
            if chain[arc] == own[end]:
                continue
            if _is_on_arc(points[end, 0], points[end, 1], disk[arc], angle[arc], distance):
                met[end, 0] = True
                if is_long[chain[arc]]:
                    met[end, 1] = True
                    break
    return met


@njit(cache=True)
def _arc_boxes(disk: Floats, margin: float) -> Floats:
    """Return boxes (A, 4) around ellipses (A, 5), with a margin [pixels]."""
    box = np.empty((len(disk), 4))
    for arc in range(len(disk)):
        for k in range(2):
            box[arc, k] = disk[arc, k] - disk[arc, 2] - margin
            box[arc, 2 + k] = disk[arc, k] + disk[arc, 2] + margin
    return box


@njit(cache=True)
def _is_on_arc(x: float, y: float, disk: Floats, angle: Floats, distance: float) -> bool:
    """Whether a point lies within `distance` of an arc, of disk (5,), angle (2,)."""
    dx = x - disk[0]
    dy = y - disk[1]
    radius = disk[2]
    if dx * dx + dy * dy > (radius + distance) ** 2:
        return False
    if disk[3] != 1.0:  # turn the longer axis to x, and stretch the shorter one
        cosine = math.cos(disk[4])
        sine = math.sin(disk[4])
        dx, dy = dx * cosine + dy * sine, (dy * cosine - dx * sine) / disk[3]
    square = dx * dx + dy * dy
    if square > (radius + distance) ** 2 or square < max(radius - distance, 0.0) ** 2:
        return False
    slack = distance / radius
    turn = (math.atan2(dy, dx) - angle[0] + slack) % math.tau
    return turn <= angle[1] - angle[0] + 2.0 * slack
