"""The visible rims of spheres in a parallel view, as circular arcs: exact, by one hidden interval for a pair.

x, y and depth share one unit; larger depth is nearer the viewer. The rim of sphere i is a circle at the constant depth
z_i. With z = z_i - step, sphere j hides a rim point exactly where its distance from j's centre in the picture is below
rho = r_j if z_j >= z, else sqrt(r_j^2 - (z - z_j)^2): one interval of angle for every pair, and what no interval covers
is visible. `step` is 0, or for spheres of segments that are joined the least step of depth that is drawn: the creases
between such spheres are shallower and vanish, and a limb fades into the body at its joint.

Angles run from +x to +y. Two rims that coincide within COINCIDE are one: that of the nearer sphere, or the first.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["COINCIDE", "arc_chains", "ends_met", "rim_arcs"]

COINCIDE = 1e-7  # [unit of x, y]
_TURN = 2.0 * math.pi
_NOTHING = 1e-12  # [rad] a gap no wider than rounding
_HIDES, _NEXT = 1, 2  # of an interval: it hides the rim; it ends where the rim of the same body's other sphere goes on


@njit(cache=True)
def _half_angle(apart: float, radius: float, other: float) -> float:
    """Half the angle of the circle `radius` that lies inside a circle `other`, centres `apart`; pi whole, -1 none."""
    if other >= apart + radius:
        return math.pi
    if other <= 0.0 or other <= abs(apart - radius):
        return -1.0
    cosine = (apart * apart + radius * radius - other * other) / (2.0 * apart * radius)
    return math.acos(min(max(cosine, -1.0), 1.0))


@njit(cache=True)
def _reach(below: float, radius: float) -> float:
    """rho: how far round a centre `below` a rim its sphere hides it."""
    if below <= 0.0:
        return radius
    return math.sqrt(max(radius * radius - below * below, 0.0))


@njit(cache=True)
def _add(
    count: int, middle: float, half: float, other: int, kind: int, spans: Floats, others: Ints, kinds: Ints
) -> int:
    spans[count, 0], spans[count, 1] = middle - half, middle + half
    others[count], kinds[count] = other, kind
    return count + 1


@njit(cache=True)
def _neighbours(
    i: int,
    balls: Floats,
    order: Ints,
    line: Floats,
    widest: float,
    step: float,
    segment: Ints,
    joined: Bools,
    near: Ints,
    reach: Floats,
) -> int:
    """Spheres whose disks cross rim i or hold it, into `near`; how far they hide, into `reach`; -1: one hides it all.

    order (S,): spheres by x, line (S,): their x; segment, joined: see `rim_arcs`.
    """
    x, y, z, radius = balls[i, 0], balls[i, 1], balls[i, 2], balls[i, 3]
    room, count = radius + widest, 0
    for place in range(np.searchsorted(line, x - room), len(order)):
        if line[place] > x + room:
            break
        j = order[place]
        dx, dy, other = balls[j, 0] - x, balls[j, 1] - y, balls[j, 3]
        square = dx * dx + dy * dy
        if j == i or square >= (radius + other) * (radius + other):
            continue
        apart = math.sqrt(square)
        if apart + abs(radius - other) < COINCIDE:
            if balls[j, 2] > z or (balls[j, 2] == z and j < i):
                return -1
            continue
        offset = step if joined[segment[i], segment[j]] else 0.0
        rho = _reach(z - offset - balls[j, 2], other)
        if rho >= radius + apart:
            return -1
        if apart + other > radius:
            near[count], reach[count] = j, rho
            count += 1
    return count


@njit(cache=True)
def _pair_spans(
    i: int, j: int, count: int, rho: float, one: bool, balls: Floats, spans: Floats, others: Ints, kinds: Ints
) -> int:
    """Append the intervals of sphere j, which hides as far as rho, on the rim of i; the new count.

    `one`: both are of one body; then the part of the rim over j's disk is not against the background.
    """
    dx, dy = balls[j, 0] - balls[i, 0], balls[j, 1] - balls[i, 1]
    apart, radius, other = math.sqrt(dx * dx + dy * dy), balls[i, 3], balls[j, 3]
    whole = rho == other  # then i's rim ends on j's, whose arc may go on
    hidden = _half_angle(apart, radius, rho)
    if hidden <= 0.0 and not one:
        return count
    middle = math.atan2(dy, dx)
    if hidden > 0.0:
        count = _add(count, middle, hidden, j, _HIDES | (_NEXT if one and whole else 0), spans, others, kinds)
    if one and not whole:
        inside = _half_angle(apart, radius, other)
        inside = 3.2 if inside == math.pi else inside  # surely all round
        if inside > 0.0:
            count = _add(count, middle, inside, j, _NEXT, spans, others, kinds)
    return count


@njit(cache=True)
def _gaps(order: Ints, kinds: Ints, kind: int, spans: Floats, gaps: Floats, edge: Ints) -> int:
    """What no interval of this kind covers on the turn 0 to 2 pi; `order` sorts by start; one starts at 0.

    gaps (K, 2): from and to; edge (K, 2): the interval that ends at the one and that which starts at the other.
    """
    found, reach, last, first = 0, 0.0, -1, -1
    for k in order:
        if kinds[k] & kind and (first < 0 or spans[k, 1] - _TURN > reach):  # from the turn before into this one
            reach, last = max(reach, spans[k, 1] - _TURN), k
            first = k if first < 0 else first
    for k in order:
        if not kinds[k] & kind:
            continue
        if spans[k, 0] > reach + _NOTHING:
            gaps[found, 0], gaps[found, 1], edge[found, 0], edge[found, 1] = reach, spans[k, 0], last, k
            found += 1
        if spans[k, 1] > reach:
            reach, last = spans[k, 1], k
    if reach < _TURN - _NOTHING:
        gaps[found, 0], gaps[found, 1], edge[found, 0], edge[found, 1] = reach, _TURN, last, first
        found += 1
    return found


@njit(cache=True)
def _sorted(count: int, spans: Floats) -> Ints:
    """Order of the first intervals by start, stable: by insertion, for some 20 twice as fast as np.argsort."""
    order = np.arange(count)
    for k in range(1, count):
        place = k
        while place > 0 and spans[order[place - 1], 0] > spans[k, 0]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = k
    return order


@njit(cache=True)
def _cut_rim(i: int, count: int, spans: Floats, others: Ints, kinds: Ints, arcs: Floats, keys: Ints) -> int:
    """The arcs of rim i that its intervals leave, in order round it; their number. See `rim_arcs` for the columns."""
    origin, free = spans[0, 0], True
    for k in range(count - 1, -1, -1):
        if kinds[k] & _HIDES:
            origin, free = spans[k, 0], False
    for k in range(count):
        width = spans[k, 1] - spans[k, 0]
        spans[k, 0] = (spans[k, 0] - origin) % _TURN
        spans[k, 1] = spans[k, 0] + width
    order = _sorted(count, spans)
    seen, seen_edge = np.empty((count + 1, 2)), np.empty((count + 1, 2), dtype=np.int64)
    outer, outer_edge = np.empty((count + 1, 2)), np.empty((count + 1, 2), dtype=np.int64)
    outers = _gaps(order, kinds, _HIDES | _NEXT, spans, outer, outer_edge)
    seens = _gaps(order, kinds, _HIDES, spans, seen, seen_edge) if not free else 1
    found, o = 0, 0
    for v in range(seens):
        here, stop, start_key, end_key = 0.0, _TURN, i, i
        if not free:
            here, stop = seen[v, 0], seen[v, 1]
            start_key, end_key = _key(seen_edge[v, 0], others, kinds), _key(seen_edge[v, 1], others, kinds)
        while o < outers and outer[o, 1] <= stop + _NOTHING:
            if outer[o, 0] > here + _NOTHING:
                found = _put(found, i, here + origin, outer[o, 0] + origin, start_key, -1, 0, arcs, keys)
            first, last = _key(outer_edge[o, 0], others, kinds), _key(outer_edge[o, 1], others, kinds)
            found = _put(found, i, outer[o, 0] + origin, outer[o, 1] + origin, first, last, 1, arcs, keys)
            here, start_key = outer[o, 1], -1
            o += 1
        if stop > here + _NOTHING:
            found = _put(found, i, here + origin, stop + origin, start_key, end_key, 0, arcs, keys)
    return found


@njit(cache=True)
def _key(k: int, others: Ints, kinds: Ints) -> int:
    return others[k] if kinds[k] & _NEXT else -1


@njit(cache=True)
def _put(
    at: int, i: int, start: float, end: float, before: int, after: int, outer: int, arcs: Floats, keys: Ints
) -> int:
    arcs[at, 0], arcs[at, 1] = start, end
    keys[at, 0], keys[at, 1], keys[at, 2], keys[at, 3] = i, before, after, outer
    return at + 1


@njit(cache=True)
def _drawn_twins(balls: Floats, body: Ints, order: Ints, line: Floats) -> Ints:
    """(S,) of the spheres of its body whose rims coincide with a sphere's, the one that is drawn."""
    twins = np.arange(len(balls))
    for i in range(len(balls)):
        for place in range(np.searchsorted(line, balls[i, 0] - COINCIDE), len(order)):
            j, now = order[place], twins[i]
            if line[place] > balls[i, 0] + COINCIDE:
                break
            nearer = balls[j, 2] > balls[now, 2] or (balls[j, 2] == balls[now, 2] and j < now)
            apart = math.hypot(balls[i, 0] - balls[j, 0], balls[i, 1] - balls[j, 1])
            if nearer and body[i] == body[j] and apart + abs(balls[i, 3] - balls[j, 3]) < COINCIDE:
                twins[i] = j
    return twins


@njit(cache=True)
def _all_arcs(
    balls: Floats,
    segment: Ints,
    body: Ints,
    joined: Bools,
    step: Floats,
    order: Ints,
    line: Floats,
    widest: float,
    spans: Floats,
    others: Ints,
    kinds: Ints,
    arcs: Floats,
    keys: Ints,
) -> int:
    """Fill arcs (R, 2) and keys (R, 4) as `rim_arcs` returns them; the number found, which may be more than R."""
    count, total = len(balls), 0
    near, reach = np.empty(count, np.int64), np.empty(count)
    some_arcs, some_keys = np.empty((2 * count + 2, 2)), np.empty((2 * count + 2, 4), np.int64)
    for i in range(count):
        found, spanned = _neighbours(i, balls, order, line, widest, step[i], segment, joined, near, reach), 0
        if found < 0:
            continue
        for k in range(found):
            spanned = _pair_spans(i, near[k], spanned, reach[k], body[i] == body[near[k]], balls, spans, others, kinds)
        if spanned:
            found = _cut_rim(i, spanned, spans, others, kinds, some_arcs, some_keys)
        else:
            found = _put(0, i, 0.0, _TURN, i, i, 1, some_arcs, some_keys)
        for arc in range(min(found, len(arcs) - total)):
            for end in range(2):
                arcs[total + arc, end] = some_arcs[arc, end]
            for part in range(4):
                keys[total + arc, part] = some_keys[arc, part]
        total += found
    return total


def rim_arcs(balls: Floats, segment: Ints, body: Ints, joined: Bools, step: Floats) -> tuple[Floats, Ints]:
    """The visible arcs of spheres `balls` (S, 4): x, y, depth, radius; segment (S,), body (S,); joined (N, N).

    step (S,): of each rim, towards spheres of segments that are `joined` to its own. Returns angles (A, 2) from and
    to, the second larger, and keys (A, 4): sphere; the sphere of the same body whose arc leads into this one at its
    start, and the one whose arc goes on at its end, -1 for none, its own number for a circle that closes; 1 where
    nothing of its own body lies behind (against the background), 0 where something does.
    """
    order = np.argsort(balls[:, 0], kind="stable")
    line, widest, count = balls[order, 0], float(balls[:, 3].max(initial=0.0)), len(balls)
    spans, others, kinds = np.empty((2 * count, 2)), np.empty(2 * count, np.int64), np.empty(2 * count, np.int64)
    found, room = 4 * count, -1
    while found > room:
        room = found
        arcs, keys = np.empty((room, 2)), np.empty((room, 4), np.int64)
        found = _all_arcs(balls, segment, body, joined, step, order, line, widest, spans, others, kinds, arcs, keys)
    arcs, keys = arcs[:found], keys[:found]
    twins = np.append(_drawn_twins(balls, body, order, line), -1)
    keys[:, 1:3] = twins[keys[:, 1:3]]  # an arc leads to that of two coinciding rims which is drawn
    return arcs, keys


@njit(cache=True)
def arc_chains(following: Ints) -> tuple[Ints, Ints]:
    """Arcs in the order in which a pen draws them, and where each chain starts in it.

    following (A,): the arc that goes on where one ends, -1 for none; no two have the same. Chains with a beginning
    come first, closed ones after them, each by the number of its first arc.
    """
    count = len(following)
    begins, done = np.ones(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_)
    for arc in range(count):
        if following[arc] >= 0:
            begins[following[arc]] = False
    order, start = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    drawn, chains = 0, 0
    for closed in range(2):
        for arc in range(count):
            if done[arc] or (closed == 0 and not begins[arc]):
                continue
            start[chains], chains = drawn, chains + 1
            while arc >= 0 and not done[arc]:
                order[drawn], done[arc], drawn = arc, True, drawn + 1
                arc = following[arc]
    return order, start[:chains]


@njit(cache=True)
def ends_met(points: Floats, own: Ints, disk: Floats, angle: Floats, chain: Ints, room: float) -> Bools:
    """Points (M, 2), ends of chains `own` (M,), that lie within `room` of an arc of another chain.

    The arcs: disk (A, 3) x, y, radius, angle (A, 2) from and to, chain (A,).
    """
    met = np.zeros(len(points), dtype=np.bool_)
    for end in range(len(points)):
        for arc in range(len(chain)):
            dx, dy, radius = points[end, 0] - disk[arc, 0], points[end, 1] - disk[arc, 1], disk[arc, 2]
            square = dx * dx + dy * dy
            if chain[arc] == own[end] or square > (radius + room) ** 2 or square < max(radius - room, 0.0) ** 2:
                continue
            slack = room / radius
            if (math.atan2(dy, dx) - angle[arc, 0] + slack) % _TURN <= angle[arc, 1] - angle[arc, 0] + 2.0 * slack:
                met[end] = True
                break
    return met
