"""Least distance of segment pairs by their fronts: the spheres that stand foremost toward each
other.

For a unit direction n and spheres s of one set and t of the other |cs - ct| - rs - rt is no less
than n.(ct - cs) - rs - rt = (n.ct - rt) - (n.cs + rs). So where n points from one to the other of a
pair that is nearly the nearest, few spheres of either set are far enough forward to be of a pair
that is nearer still: they are found with one product a sphere, where pairs would take one for each
two. The pair to begin with is found by going from a sphere to the nearest of the other set and
back.

All this goes by eight lanes in single precision, with coordinates from a sphere nearby and a margin
for rounding (SPARE). What of the two fronts is the nearest then, and whatever is as near within the
margin, is worked out in double precision and decides: one pair, mostly. No loop here ends before
its last turn, so that the processor seldom foresees a branch wrongly, and the time goes into
arithmetic.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import inlined, inner
from workbench.geometry.lanes import (
    eight,
    equal,
    first_bit,
    greatest,
    larger,
    least,
    load,
    not_above,
    pack,
    root,
    smaller,
    store,
    where_below,
)
from workbench.geometry.quads import four, greatest_of, load_triples, lower, store_single, upper

__all__ = [
    "FAR",
    "NODE",
    "Blocks",
    "Room",
    "first_pairs",
    "foremost_pair",
    "near_place",
    "place_blocks",
]

FAR = np.float32(1e15)
"""Where lanes without a sphere stand [m]; their radius is its square, negative."""
NODE = np.uint64(32)
"""Numbers of eight balls: x of all, y, z, radii."""
SPARE = 2e-5
"""Margin as a part of the greatest coordinate and radius together: two heights are off by less than
100 roundings of 6e-8, the distance of two balls by less than 35: for two of these a quarter of it
is enough."""
_L = np.uint64(8)
_H = np.uint64(4)
_ONE = np.uint64(1)
_NOBODY = np.float32(-1e30)
_EXACT = np.uint64(1 << 24)  # whole numbers below are exact in single precision


class Blocks(NamedTuple):
    """A body's spheres in blocks of eight: those of segment n stand in order in the blocks
    first[n]:first[n + 1], and sphere s of segment n at the place 8 first[n] + s - start[n].

    ball (32 B,): blocks of NODE numbers, so far with radii alone; what no sphere has is FAR away.
    """

    start: NDArray[np.int64]
    first: NDArray[np.int64]
    ball: NDArray[np.float32]


class Room(NamedTuple):
    """Working space for one body: ball as in `Blocks`, in the world; high (8 B,): how far spheres
    reach; front (8 B + 8,): places picked out; near (32 B + 32,): the blocks of what was picked
    out."""

    ball: NDArray[np.float32]
    high: NDArray[np.float32]
    front: NDArray[np.float32]
    near: NDArray[np.float32]


@inner
def place_blocks(centres, p, shown, blocks, ball, o0, o1, o2):  # type: ignore[no-untyped-def]
    """Fill ball with what stands where in pose p, seen from a point; returns the greatest
    coordinate [m]."""
    low = four(0.0)
    high = four(0.0)
    base = np.uint64(3 * p * centres.shape[1])
    x4 = four(o0)
    y4 = four(o1)
    z4 = four(o2)
    for n in range(len(shown)):
        if shown[n] == 0:
            continue
        start = np.uint64(blocks.start[n])
        end = np.uint64(blocks.start[n + 1])
        e = np.uint64(blocks.first[n]) * NODE
        whole = start + (end - start) // _H * _H
        for s in range(start, whole, _H):
            x, y, z = load_triples(centres, base + np.uint64(3) * s)
            x = x - x4
            y = y - y4
            z = z - z4
            at = e + (s - start) // _L * NODE + (s - start) % _L
            store_single(ball, at, x)
            store_single(ball, at + _L, y)
            store_single(ball, at + _L + _L, z)
            low = lower(lower(x, y), lower(z, low))
            high = upper(upper(x, y), upper(z, high))
        for s in range(whole, end):
            x = centres[p, s, 0] - o0
            y = centres[p, s, 1] - o1
            z = centres[p, s, 2] - o2
            at = e + (s - start) // _L * NODE + (s - start) % _L
            ball[at] = x
            ball[at + _L] = y
            ball[at + _L + _L] = z
            low = lower(low, four(min(min(x, y), z)))
            high = upper(high, four(max(max(x, y), z)))
    return greatest_of(upper(high, four(0.0) - low))


@inlined
def _ball(array, place):  # type: ignore[no-untyped-def]
    """Centre and radius of the ball at a place of blocks of NODE numbers."""
    e = (place // _L) * NODE + place % _L
    return array[e], array[e + _L], array[e + _L + _L], array[e + _L + _L + _L]


@inlined
def _gaps(x, y, z, array, block):  # type: ignore[no-untyped-def]
    """Distances of a point, each coordinate eight times, from the surfaces of eight balls."""
    e = block * NODE
    u = load(array, e) - x
    v = load(array, e + _L) - y
    w = load(array, e + _L + _L) - z
    return root(u * u + v * v + w * w) - load(array, e + _L + _L + _L)


@inlined
def _heights(x, y, z, array, a, b, high):  # type: ignore[no-untyped-def]
    """How far the balls in the blocks a..b reach along a direction, each component eight times,
    into high; the greatest."""
    top = eight(-FAR)
    for g in range(np.uint64(a), np.uint64(b)):
        e = g * NODE
        reach = x * load(array, e) + y * load(array, e + _L) + z * load(array, e + _L + _L)
        reach = reach + load(array, e + _L + _L + _L)
        store(high, (g - np.uint64(a)) * _L, reach)
        top = larger(top, reach)
    return greatest(top)


@inlined
def near_place(x, y, z, array, a, b, spare):  # type: ignore[no-untyped-def]
    """The place of a sphere about as near to a point as any in the blocks a..b."""
    x8 = eight(x)
    y8 = eight(y)
    z8 = eight(z)
    low = eight(FAR)
    at = eight(np.float32(a))
    for g in range(a, b):
        gap = _gaps(x8, y8, z8, array, np.uint64(g))
        at = where_below(gap, low, eight(np.float32(g)), at)
        low = smaller(gap, low)
    k = first_bit(equal(low, eight(least(low)))) % _L
    store(spare, np.uint64(0), at)
    return np.uint64(np.int64(spare[k])) * _L + k


@inner
def first_pairs(pairs, first1, first2, ball1, ball2, spare, place1, place2):  # type: ignore[no-untyped-def]
    """For each segment pair (M, 2) the places (M,) of two spheres that are nearly the nearest: from
    what stands in place1 to the nearest of the other segment, and back.

    One loop for the ways there and one for those back, so that the processor has several under way
    at once.
    """
    for m in range(len(pairs)):
        b = pairs[m, 1]
        x, y, z, _ = _ball(ball1, place1[m])
        place2[m] = near_place(x, y, z, ball2, first2[b], first2[b + 1], spare)
    for m in range(len(pairs)):
        a = pairs[m, 0]
        x, y, z, _ = _ball(ball2, place2[m])
        place1[m] = near_place(x, y, z, ball1, first1[a], first1[a + 1], spare)


@inlined
def _picked(limit, high, a, b, front):  # type: ignore[no-untyped-def]
    """The places of what reaches to a height in the blocks a..b, into front; how many."""
    used = np.uint64(0)
    lowest = eight(limit)
    for g in range(np.uint64(a), np.uint64(b)):
        bits = not_above(lowest, load(high, (g - np.uint64(a)) * _L))
        used = pack(front, used, bits, np.float32(np.int64(g * _L)))
    return used


@inlined
def _gathered(ball, front, used, near):  # type: ignore[no-untyped-def]
    """Bring the balls at the places in front together into blocks of near; how many blocks."""
    blocks = max((used + _L - _ONE) // _L, _ONE)
    last = blocks * NODE - NODE
    for k in range(np.uint64(4)):
        store(near, last + k * _L, eight(FAR if k < 3 else _NOBODY))
    for q in range(used):
        x, y, z, r = _ball(ball, np.uint64(np.int64(front[q])))
        e = (q // _L) * NODE + q % _L
        near[e] = x
        near[e + _L] = y
        near[e + _L + _L] = z
        near[e + _L + _L + _L] = r
    return blocks


@inlined
def _direction(ball1, ball2, begun):  # type: ignore[no-untyped-def]
    """About the unit vector from the one to the other of two balls, and their distance less the
    radii."""
    (x, y, z, r), (u, v, w, t) = _ball(ball1, begun[0]), _ball(ball2, begun[1])
    x = u - x
    y = v - y
    z = w - z
    far = math.sqrt(x * x + y * y + z * z)
    per = np.float32(1.0) / np.float32(
        max(far, 1e-12)
    )  # shorter than a unit where the centres are one: all the safer
    return x * per, y * per, z * per, far - (r + t)


@inlined
def _fronts(ball1, ball2, room1, room2, ends, begun, spare):  # type: ignore[no-untyped-def]
    """Fill front of both with the places that may be of a pair nearer than that begun with; how
    many of each."""
    a, b, c, d = ends
    x, y, z, gap = _direction(ball1, ball2, begun)
    x8 = eight(x)
    y8 = eight(y)
    z8 = eight(z)
    none = eight(np.float32(0.0))
    top1 = _heights(x8, y8, z8, ball1, a, b, room1.high)
    top2 = _heights(none - x8, none - y8, none - z8, ball2, c, d, room2.high)
    used1 = _picked(-(gap + spare) - top2, room1.high, a, b, room1.front)
    used2 = _picked(-(gap + spare) - top1, room2.high, c, d, room2.front)
    return used1, used2


@inlined
def _nearest(ball1, front, used, near, blocks, spare, room):  # type: ignore[no-untyped-def]
    """The nearest of two fronts in single precision: the least distance and a quarter of `spare`,
    which of the one front and which of `near` it is between, and 1 where no others are as near
    within that. used: of the one front.
    """
    low = eight(FAR)
    next_low = eight(FAR)
    at = eight(np.float32(0.0))
    for q in range(used):
        x, y, z, r = _ball(ball1, np.uint64(np.int64(front[q])))
        x8 = eight(x)
        y8 = eight(y)
        z8 = eight(z)
        r8 = eight(r)
        for j in range(blocks):
            gap = _gaps(x8, y8, z8, near, j) - r8
            at = where_below(gap, low, eight(np.float32(np.int64(q * blocks + j))), at)
            next_low = smaller(next_low, larger(low, gap))
            low = smaller(low, gap)
    within = least(low) + np.float32(0.25) * spare
    bits = not_above(low, eight(within))
    alone = np.uint64(bits & (bits - _ONE) == 0) & np.uint64(
        not_above(next_low, eight(within)) == 0
    )
    store(room, np.uint64(0), at)
    alone &= np.uint64(used * blocks < _EXACT)
    turn = min(np.uint64(np.int64(room[first_bit(bits) % _L])), used * blocks - _ONE)
    k = first_bit(bits) % _L
    return within, turn // blocks, (turn % blocks) * _L + k, alone


@inlined
def _better(c1, c2, p, radius1, radius2, s, t, best):  # type: ignore[no-untyped-def]
    """The nearer of the pair (s, t) and the best so far (I, sphere, sphere): equal ones by the
    lowest spheres."""
    least_so_far, u, v = best
    x = c1[p, s, 0] - c2[p, t, 0]
    y = c1[p, s, 1] - c2[p, t, 1]
    z = c1[p, s, 2] - c2[p, t, 2]
    gap = math.sqrt(x * x + y * y + z * z) - (radius1[s] + radius2[t])
    if gap < least_so_far or (gap == least_so_far and (s < u or (s == u and t < v))):
        return gap, s, t
    return best


@inner
def _several(one, other, p, counts, begins, within, fronts, balls, best):  # type: ignore[no-untyped-def]
    """The best of all pairs of the fronts within a distance, in double precision."""
    (c1, radius1), (c2, radius2), (front1, front2), (ball1, near) = one, other, fronts, balls
    for q in range(counts[0]):
        f = np.int64(front1[q])
        x, y, z, r = _ball(ball1, np.uint64(f))
        x8 = eight(x)
        y8 = eight(y)
        z8 = eight(z)
        most = eight(within + r)
        for j in range(counts[1]):
            bits = not_above(_gaps(x8, y8, z8, near, j), most)
            while bits != 0:
                t = np.int64(front2[j * _L + first_bit(bits)])
                bits &= bits - _ONE
                spheres = np.uint64(f + begins[0]), np.uint64(t + begins[1])
                best = _better(c1, c2, p, radius1, radius2, spheres[0], spheres[1], best)
    return best


@inlined
def foremost_pair(one, other, p, pair, rooms, begun, spare):  # type: ignore[no-untyped-def]
    """Least I of two segments with its spheres, of equal ones the lowest: (I, sphere, sphere).

    one, other: (centres (P, S, 3), radius (S,), Blocks); rooms of both; begun: places of two
    spheres nearly nearest; spare [m]: margin for rounding.
    """
    (c1, radius1, blocks1), (c2, radius2, blocks2), (room1, room2), (a, b) = one, other, rooms, pair
    ends = blocks1.first[a], blocks1.first[a + 1], blocks2.first[b], blocks2.first[b + 1]
    used1, used2 = _fronts(room1.ball, room2.ball, room1, room2, ends, begun, spare)
    blocks = _gathered(room2.ball, room2.front, used2, room2.near)
    within, q, k, alone = _nearest(
        room1.ball, room1.front, used1, room2.near, blocks, spare, room1.high
    )
    s0 = blocks1.start[a] - 8 * ends[0]
    t0 = blocks2.start[b] - 8 * ends[2]
    s = np.uint64(np.int64(room1.front[q]) + s0)
    t = np.uint64(np.int64(room2.front[k]) + t0)
    best = _better(c1, c2, p, radius1, radius2, s, t, (np.inf, s, t))
    if alone == 0:
        counts = (used1, blocks)
        fronts = (room1.front, room2.front)
        balls = (room1.ball, room2.near)
        best = _several(
            (c1, radius1), (c2, radius2), p, counts, (s0, t0), within, fronts, balls, best
        )
    return best
