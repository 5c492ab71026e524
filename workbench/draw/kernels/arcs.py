"""The visible rims of spheres as arcs: exact, by one hidden interval of angle for a pair (see
kernels.silhouettes).

What no interval covers is visible. Where a step of depth is given, the creases between spheres of
joined segments are shallower and vanish, and a limb fades into the body at its joint. Angles run
from +x to +y. Two rims that coincide are one: that of the nearer sphere, or the first.
"""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit
from workbench.draw.kernels.silhouettes import (
    COINCIDE,
    Rims,
    candidates,
    cells_of,
    covered_by_few,
    diamond_angle,
    diamond_span,
    grid_of,
    keep_uncovered,
    pair_cosines,
    wrapped,
)
from workbench.geometry.order import NONE, ONE
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["arc_chains", "ends_met", "silhouette_arcs"]

_TURN = 4.0  # intervals are in ways of rims.diamond; only what is drawn is turned into angles
_NOTHING = 1e-12  # a gap no wider than rounding
_INSIDE = 1e-9
# of an interval: it hides the rim; it ends where the rim of the same body's other sphere goes on
_HIDES = ONE
_NEXT = ONE + ONE
_OPEN = NONE - ONE  # of an arc's end: no other arc goes on there


@njit(cache=True)
def _add(
    count: int,
    first: float,
    end: float,
    other: int,
    kind: int,
    spans: Floats,
    others: Ints,
    kinds: Ints,
) -> int:
    spans[count, 0] = first
    spans[count, 1] = end
    others[count] = other
    kinds[count] = kind
    return count + 1


@njit(cache=True)
def _overlaps(i: int, rims: Rims, found: Ints, count: int, pairs: Floats) -> int:
    """Keep of the rims `found` those that reach over rim i, with their cosines in `pairs`; -1: one
    hides it all."""
    kept = 0
    for k in range(count):
        j = found[k]
        offset = rims.step[i] if rims.joined[rims.segment[i], rims.segment[j]] else 0.0
        dx, dy, hidden, over, apart = pair_cosines(i, j, rims.balls, rims.lens, offset)
        if apart == 0.0:
            if rims.near[j] > rims.near[i] or (rims.near[j] == rims.near[i] and j < i):
                return -1
            continue
        if hidden <= -1.0:
            return -1
        if over < 1.0:
            found[kept] = j
            pairs[kept, 0] = dx
            pairs[kept, 1] = dy
            pairs[kept, 2] = hidden
            pairs[kept, 3] = over
            kept += 1
    return kept


@njit(cache=True)
def _pair_spans(
    j: int, count: int, one: bool, pair: Floats, spans: Floats, others: Ints, kinds: Ints
) -> int:
    """Append the intervals of sphere j with its direction and cosines `pair` (4,) on a rim; the new
    count.

    `one`: both are of one body; then the part of the rim over j's disk is not against the
    background.
    """
    if pair[2] >= 1.0 and not one:
        return count
    whole = pair[2] == pair[3]  # then the rim ends on j's, which may go on
    if pair[2] < 1.0:
        first, end = diamond_span(pair[0], pair[1], pair[2])
        count = _add(
            count, first, end, j, _HIDES | (_NEXT if one and whole else NONE), spans, others, kinds
        )
    if one and not whole:
        first, end = (
            diamond_span(pair[0], pair[1], pair[3]) if pair[3] > -1.0 else (0.0, 4.1)
        )  # surely all round
        count = _add(count, first, end, j, _NEXT, spans, others, kinds)
    return count


@njit(cache=True)
def _gaps(order: Ints, kinds: Ints, kind: int, spans: Floats, gaps: Floats, edge: Ints) -> int:
    """What no interval of this kind covers on the turn 0 to 4; `order` sorts by start; one starts
    at 0.

    gaps (K, 2): from and to; edge (K, 2): the interval that ends at the one and that which starts
    at the other.
    """
    found = 0
    reach = 0.0
    last = -1
    first = -1
    for k in order:
        if kinds[k] & kind and (
            first < 0 or spans[k, 1] - _TURN > reach
        ):  # from the turn before into this one
            reach = max(reach, spans[k, 1] - _TURN)
            last = k
            first = k if first < 0 else first
    for k in order:
        if not kinds[k] & kind:
            continue
        if spans[k, 0] > reach + _NOTHING:
            gaps[found, 0] = reach
            gaps[found, 1] = spans[k, 0]
            edge[found, 0] = last
            edge[found, 1] = k
            found += 1
        if spans[k, 1] > reach:
            reach = spans[k, 1]
            last = k
    if reach < _TURN - _NOTHING:
        gaps[found, 0] = reach
        gaps[found, 1] = _TURN
        edge[found, 0] = last
        edge[found, 1] = first
        found += 1
    return found


@njit(cache=True)
def _sorted(count: int, spans: Floats) -> Ints:
    """Order of the first intervals by start, stable: by insertion, for some 20 twice as fast as
    np.argsort."""
    order = np.arange(count)
    for k in range(1, count):
        place = k
        while place > 0 and spans[order[place - 1], 0] > spans[k, 0]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = k
    return order


@njit(cache=True)
def _cut_rim(
    i: int,
    count: int,
    spans: Floats,
    others: Ints,
    kinds: Ints,
    gaps: Floats,
    edges: Ints,
    arcs: Floats,
    keys: Ints,
) -> int:
    """The arcs of rim i that its intervals leave, in order round it; their number. See `silhouette_arcs`
    for the columns.

    gaps, edges (2 n, 2): room for what n - 1 intervals leave, twice.
    """
    origin = spans[0, 0]
    free = True
    for k in range(count - 1, -1, -1):
        if kinds[k] & _HIDES:
            origin = spans[k, 0]
            free = False
    for k in range(count):
        width = spans[k, 1] - spans[k, 0]
        spans[k, 0] = wrapped(spans[k, 0] - origin)
        spans[k, 1] = spans[k, 0] + width
    order = _sorted(count, spans)
    half = len(gaps) // 2
    seen = gaps[:half]
    seen_edge = edges[:half]
    outer = gaps[half:]
    outer_edge = edges[half:]
    outers = _gaps(order, kinds, _HIDES | _NEXT, spans, outer, outer_edge)
    seens = _gaps(order, kinds, _HIDES, spans, seen, seen_edge) if not free else 1
    found = NONE
    o = 0
    for v in range(seens):
        here = 0.0
        stop = _TURN
        start_key = i
        end_key = i
        if not free:
            here = seen[v, 0]
            stop = seen[v, 1]
            start_key = _key(seen_edge[v, 0], others, kinds)
            end_key = _key(seen_edge[v, 1], others, kinds)
        while o < outers and outer[o, 1] <= stop + _NOTHING:
            if outer[o, 0] > here + _NOTHING:
                found = _put(
                    found,
                    i,
                    here + origin,
                    outer[o, 0] + origin,
                    start_key,
                    _OPEN,
                    NONE,
                    arcs,
                    keys,
                )
            first = _key(outer_edge[o, 0], others, kinds)
            last = _key(outer_edge[o, 1], others, kinds)
            found = _put(
                found, i, outer[o, 0] + origin, outer[o, 1] + origin, first, last, ONE, arcs, keys
            )
            here = outer[o, 1]
            start_key = _OPEN
            o += 1
        if stop > here + _NOTHING:
            found = _put(
                found, i, here + origin, stop + origin, start_key, end_key, NONE, arcs, keys
            )
    return found


@njit(cache=True)
def _key(k: int, others: Ints, kinds: Ints) -> int:
    return others[k] if kinds[k] & _NEXT else _OPEN


@njit(cache=True)
def _put(
    at: int,
    i: int,
    start: float,
    end: float,
    before: int,
    after: int,
    outer: int,
    arcs: Floats,
    keys: Ints,
) -> int:
    first = diamond_angle(start)
    width = (diamond_angle(end) - first) % math.tau
    if end - start > _TURN - _NOTHING:
        width = math.tau
    elif end - start < 1.0 and width > math.pi:  # rounded to less than nothing
        width = 0.0
    arcs[at, 0] = first
    arcs[at, 1] = first + width
    keys[at, 0] = i
    keys[at, 1] = before
    keys[at, 2] = after
    keys[at, 3] = outer
    return at + 1


@njit(cache=True)
def _drawn_twin(i: int, rims: Rims, found: Ints, count: int) -> int:
    """Of the spheres of its body whose rims coincide with that of i, the one that is drawn."""
    twin = i
    for k in range(count):
        j = found[k]
        if rims.body[i] != rims.body[j] or abs(rims.box[j, 0] - rims.box[i, 0]) > COINCIDE:
            continue
        nearer = rims.near[j] > rims.near[twin] or (rims.near[j] == rims.near[twin] and j < twin)
        if nearer and pair_cosines(i, j, rims.balls, rims.lens, 0.0)[4] == 0.0:
            twin = j
    return twin


@njit(cache=True)
def _all_arcs(rims: Rims, arcs: Floats, keys: Ints, twins: Ints) -> int:
    """Fill arcs (R, 2) and keys (R, 4) as `silhouette_arcs` returns them; the number found, which may be
    more than R."""
    count = len(rims.near)
    total = 0
    start, listed, cells, frame = grid_of(rims.box, rims.near)
    stamp = np.full(count, -1)
    found = np.empty(count, np.int64)
    pairs = np.empty((count, 4))
    room = 2 * count + 1
    spans = np.empty((room, 2))
    others = np.empty(room, np.int64)
    kinds = np.empty(room, np.int64)
    gaps = np.empty((2 * room + 2, 2))
    edges = np.empty((2 * room + 2, 2), np.int64)
    some_arcs = np.empty((2 * count + 2, 2))
    some_keys = np.empty((2 * count + 2, 4), np.int64)
    for i in range(count):
        number = candidates(i, rims.box, start, listed, cells, frame, stamp, found)
        twins[i] = _drawn_twin(i, rims, found, number)
        number = _overlaps(i, rims, found, number, pairs)
        spanned = NONE
        if number < 0:
            continue
        low, high = covered_by_few(pairs, number)
        if high - low >= _TURN:
            continue
        low = low + _INSIDE
        high = high - _INSIDE  # the pairs at both ends stay, and give their names to the arcs
        number = keep_uncovered(low, high, found, pairs, number)
        for k in range(number):
            one = rims.body[i] == rims.body[found[k]]
            spanned = _pair_spans(found[k], spanned, one, pairs[k], spans, others, kinds)
        if high > low:
            spanned = _add(spanned, low, high, i, _HIDES, spans, others, kinds)
        if spanned:
            number = _cut_rim(i, spanned, spans, others, kinds, gaps, edges, some_arcs, some_keys)
        else:
            number = _put(NONE, i, 0.0, _TURN, i, i, ONE, some_arcs, some_keys)
        for arc in range(min(number, len(arcs) - total)):
            for end in range(2):
                arcs[total + arc, end] = some_arcs[arc, end]
            for part in range(4):
                keys[total + arc, part] = some_keys[arc, part]
        total += number
    return total


def silhouette_arcs(rims: Rims) -> tuple[Floats, Ints]:
    """The visible arcs of rims, made by `parallel_rims` or `perspective_rims`.

    Returns angles (A, 2) from and to, the second larger, and keys (A, 4): sphere; the sphere of the
    same body whose arc leads into this one at its start, and the one whose arc goes on at its end,
    -1 for none, its own number for a circle that closes; 1 where nothing of its own body lies
    behind (against the background), 0 where something does.
    """
    twins = np.full(len(rims.near) + 1, -1)
    found = 4 * len(rims.near)
    room = -1
    while found > room:
        room = found
        arcs = np.empty((room, 2))
        keys = np.empty((room, 4), np.int64)
        found = _all_arcs(rims, arcs, keys, twins)
    arcs = arcs[:found]
    keys = keys[:found]
    keys[:, 1:3] = twins[keys[:, 1:3]]  # an arc leads to that of two coinciding rims which is drawn
    return arcs, keys


@njit(cache=True)
def arc_chains(following: Ints) -> tuple[Ints, Ints]:
    """Arcs in the order in which a pen draws them, and where each chain starts in it.

    following (A,): the arc that goes on where one ends, -1 for none; no two have the same. Chains
    with a beginning come first, closed ones after them, each by the number of its first arc.
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
    points: Floats, own: Ints, disk: Floats, angle: Floats, chain: Ints, long: Bools, room: float
) -> Bools:
    """Whether points (M, 2), ends of chains `own` (M,), lie within `room` of an arc of another
    chain: (M, 2) any, long.

    The arcs are of ellipses: disk (A, 5) x, y, longer half axis, the shorter as a share of it,
    direction of the longer; angle (A, 2) from and to, chain (A,); long (C,): of all chains. Of an
    ellipse distances are measured as if it were stretched to a circle.
    """
    met = np.zeros((len(points), 2), dtype=np.bool_)
    box = np.empty((len(chain), 4))
    for arc in range(len(chain)):
        for k in range(2):
            box[arc, k] = disk[arc, k] - disk[arc, 2] - room
            box[arc, 2 + k] = disk[arc, k] + disk[arc, 2] + room
    start, listed, cells, frame = grid_of(box, np.zeros(len(chain)))
    place = np.empty(4)
    for end in range(len(points)):
        for k in range(2):
            place[k] = place[2 + k] = points[end, k]
        column, row, _, _ = cells_of(place, cells, frame)
        cell = row * cells[0] + column
        for n in range(start[cell], start[cell + 1]):
            arc = listed[n]
            if chain[arc] != own[end] and _on_arc(
                points[end, 0], points[end, 1], disk[arc], angle[arc], room
            ):
                met[end, 0] = True
                if long[chain[arc]]:
                    met[end, 1] = True
                    break
    return met


@njit(cache=True)
def _on_arc(x: float, y: float, disk: Floats, angle: Floats, room: float) -> bool:
    """Whether a point lies within `room` of an arc, of disk (5,), angle (2,) as in `ends_met`."""
    dx = x - disk[0]
    dy = y - disk[1]
    radius = disk[2]
    if dx * dx + dy * dy > (radius + room) ** 2:
        return False
    if disk[3] != 1.0:
        cosine = math.cos(disk[4])
        sine = math.sin(disk[4])
        dx, dy = dx * cosine + dy * sine, (dy * cosine - dx * sine) / disk[3]
    square = dx * dx + dy * dy
    slack = room / radius
    if square > (radius + room) ** 2 or square < max(radius - room, 0.0) ** 2:
        return False
    turn = (math.atan2(dy, dx) - angle[0] + slack) % math.tau
    return turn <= angle[1] - angle[0] + 2.0 * slack
