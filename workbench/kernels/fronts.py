"""Least distance of segment pairs by their fronts: the spheres that stand foremost toward each other.

For a unit direction n and spheres s of one set and t of the other |cs - ct| - rs - rt is no less than
n.(ct - cs) - rs - rt = (n.ct - rt) - (n.cs + rs). So where n points from one to the other of a pair that is nearly the
nearest, few spheres of either set are far enough forward to be of a pair that is nearer still: they are found with one
product a sphere, where pairs would take one for each two. The pair to begin with is found by going from a sphere to
the nearest of the other set and back.

All this goes by eight lanes in single precision, with coordinates from a sphere nearby and a margin for rounding
(SPARE); what is left is worked out in double precision and decides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.kernels.groups import cluster_hub
from workbench.kernels.lanes import (
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

__all__ = ["FAR", "NODE", "Blocks", "Room", "first_pairs", "foremost_pair", "place_blocks"]

FAR = np.float32(1e15)
"""Where lanes without a sphere stand [m]; their radius is its square, negative."""
NODE = np.uint64(32)
"""Numbers of eight balls: x of all, y, z, radii."""
SPARE = 2e-5
"""Margin as a part of the greatest coordinate: a height takes six roundings of 6e-8, a gap eight, n is off by one."""
HEAVY = np.uint64(8)
"""Blocks against blocks from which on their own balls are compared before the spheres in them."""
_L, _ONE = np.uint64(8), np.uint64(1)


class Blocks(NamedTuple):
    """A body's spheres in blocks of eight, one for each cluster, and the balls of these in blocks of eight again.

    Blocks group[n]:group[n + 1] of balls are those of segment n; cluster (8 G,): whose ball each lane holds, -1 where
    none. Place 8 c + k is lane k of the block of ball c; member (64 G,): the sphere there; spot (S,): where in `ball`
    the x of a sphere stands. hub (32 G,), ball (256 G,): blocks of NODE numbers, so far with radii alone.
    """

    group: NDArray[np.int64]
    cluster: NDArray[np.int64]
    member: NDArray[np.int64]
    spot: NDArray[np.int64]
    hub: NDArray[np.float32]
    ball: NDArray[np.float32]


class Room(NamedTuple):
    """Working space for one body: hub, ball as in `Blocks`, in the world; up (8 G,), high (64 G,): heights of balls
    and of spheres; some, near: blocks and places picked out; kept: bits of balls."""

    hub: NDArray[np.float32]
    ball: NDArray[np.float32]
    up: NDArray[np.float32]
    high: NDArray[np.float32]
    some: NDArray[np.float32]
    near: NDArray[np.float32]
    kept: NDArray[np.uint64]


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def place_blocks(centres, world, p, crowd, blocks, hub, ball, o0, o1, o2):  # type: ignore[no-untyped-def]
    """Fill hub and ball with what stands where in pose p, seen from a point; returns the greatest coordinate [m]."""
    most = 0.0
    for n in range(len(crowd.start) - 1):
        if crowd.shown[n] == 0:
            continue
        for i in range(blocks.group[n] * 8, blocks.group[n + 1] * 8):
            c = blocks.cluster[i]
            if c < 0:
                continue
            x, y, z = cluster_hub(centres, world, p, crowd, n, c)
            x, y, z = x - o0, y - o1, z - o2
            e = (np.uint64(i) // _L) * NODE + np.uint64(i) % _L
            hub[e], hub[e + _L], hub[e + _L + _L] = x, y, z
            most = max(most, max(max(abs(x), abs(y)), abs(z)) + crowd.reach[c])
        first, last = crowd.first[crowd.start[n]], crowd.first[crowd.start[n + 1]]
        for s in range(np.uint64(first), np.uint64(last)):
            e = np.uint64(blocks.spot[s])
            ball[e], ball[e + _L], ball[e + _L + _L] = (
                centres[p, s, 0] - o0,
                centres[p, s, 1] - o1,
                centres[p, s, 2] - o2,
            )
    return most


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _ball(array, place):  # type: ignore[no-untyped-def]
    """Centre and radius of the ball at a place of blocks of NODE numbers."""
    e = (place // _L) * NODE + place % _L
    return array[e], array[e + _L], array[e + _L + _L], array[e + _L + _L + _L]


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _gaps(x, y, z, array, block):  # type: ignore[no-untyped-def]
    """Distances of a point, each coordinate eight times, from the surfaces of eight balls."""
    e = block * NODE
    u, v, w = load(array, e) - x, load(array, e + _L) - y, load(array, e + _L + _L) - z
    return root(u * u + v * v + w * w) - load(array, e + _L + _L + _L)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _heights(x, y, z, array, block):  # type: ignore[no-untyped-def]
    """How far eight balls reach along a direction, each component eight times."""
    e = block * NODE
    return x * load(array, e) + y * load(array, e + _L) + z * load(array, e + _L + _L) + load(array, e + _L + _L + _L)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _meet(x, y, z, reach, array, block):  # type: ignore[no-untyped-def]
    """Bits of those of eight balls that come within `reach`, if that is not negative, of a point; all eight times."""
    e = block * NODE
    u, v, w = load(array, e) - x, load(array, e + _L) - y, load(array, e + _L + _L) - z
    r = larger(load(array, e + _L + _L + _L) + reach, eight(np.float32(0.0)))
    return not_above(u * u + v * v + w * w, r * r)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _near_place(x, y, z, room, a, b):  # type: ignore[no-untyped-def]
    """The place of a sphere about as near to a point as any in the blocks a..b of balls."""
    x8, y8, z8 = eight(x), eight(y), eight(z)
    low, at = eight(FAR), eight(np.float32(a))
    for g in range(a, b):
        gap = _gaps(x8, y8, z8, room.hub, np.uint64(g))
        at = where_below(gap, low, eight(np.float32(g)), at)
        low = smaller(gap, low)
    k = first_bit(equal(low, eight(least(low)))) % _L
    store(room.high, np.uint64(0), at)
    block = np.uint64(np.int64(room.high[k])) * _L + k
    gap = _gaps(x8, y8, z8, room.ball, block)
    return block * _L + first_bit(equal(gap, eight(least(gap)))) % _L


@njit(cache=True, error_model="numpy", _nrt=False)
def first_pairs(pairs, blocks1, blocks2, room1, room2, place1, place2):  # type: ignore[no-untyped-def]
    """For each segment pair (M, 2) the places (M,) of two spheres that are nearly the nearest: from what stands in
    place1 to the nearest of the other segment, and back.

    One loop for the ways there and one for those back, so that the processor has several under way at once.
    """
    for m in range(len(pairs)):
        b = pairs[m, 1]
        x, y, z, _ = _ball(room1.ball, place1[m])
        place2[m] = _near_place(x, y, z, room2, blocks2.group[b], blocks2.group[b + 1])
    for m in range(len(pairs)):
        a = pairs[m, 0]
        x, y, z, _ = _ball(room2.ball, place2[m])
        place1[m] = _near_place(x, y, z, room1, blocks1.group[a], blocks1.group[a + 1])


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _reach_of_balls(x, y, z, room, a, b):  # type: ignore[no-untyped-def]
    """Heights of the balls in the blocks a..b, into room.up; the greatest."""
    top = eight(-FAR)
    for g in range(a, b):
        high = _heights(x, y, z, room.hub, np.uint64(g))
        store(room.up, np.uint64(g - a) * _L, high)
        top = larger(top, high)
    return greatest(top)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _front(x, y, z, limit, room, a, b):  # type: ignore[no-untyped-def]
    """Blocks of spheres whose balls reach to a height, into room.some, and the heights of their spheres, into
    room.high; the greatest of these and how many blocks."""
    top, used, lowest = eight(-FAR), np.uint64(0), eight(limit)
    for g in range(a, b):
        used = pack(room.some, used, not_above(lowest, load(room.up, np.uint64(g - a) * _L)), np.float32(g * 8))
    for q in range(used):
        high = _heights(x, y, z, room.ball, np.uint64(np.int64(room.some[q])))
        store(room.high, q * _L, high)
        top = larger(top, high)
    return greatest(top), used


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _fronts(way, within, groups, room1, room2):  # type: ignore[no-untyped-def]
    """How far the spheres of both that may be of a pair within a distance reach toward each other, and in how many
    blocks they stand; fills some and high of both. groups: first and last block of balls of both."""
    a, b, c, d = groups
    x, y, z = eight(way[0]), eight(way[1]), eight(way[2])
    none = eight(np.float32(0.0))
    u, v, w = none - x, none - y, none - z
    top1 = _reach_of_balls(x, y, z, room1, a, b)
    _reach_of_balls(u, v, w, room2, c, d)
    top2, used2 = _front(u, v, w, -within - top1, room2, c, d)
    top1, used1 = _front(x, y, z, -within - top2, room1, a, b)
    return top1, used1, top2, used2


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _better(c1, c2, p, radius1, radius2, s, t, best):  # type: ignore[no-untyped-def]
    """The nearer of the pair (s, t) and the best so far (I, sphere, sphere): equal ones by the lowest spheres."""
    least_so_far, u, v = best
    x, y, z = c1[p, s, 0] - c2[p, t, 0], c1[p, s, 1] - c2[p, t, 1], c1[p, s, 2] - c2[p, t, 2]
    gap = math.sqrt(x * x + y * y + z * z) - (radius1[s] + radius2[t])
    if gap < least_so_far or (gap == least_so_far and (s < u or (s == u and t < v))):
        return gap, s, t
    return best


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _scan(one, other, p, f, few, begun, spare, rooms, best):  # type: ignore[no-untyped-def]
    """Improve best (I, sphere, sphere) by the sphere at place f with those in the first `few` blocks of room2.near.

    begun: the places of the pair to begin with, which need not be looked at again.
    """
    (c1, radius1, blocks1), (c2, radius2, blocks2), (room1, room2) = one, other, rooms
    x, y, z, r = _ball(room1.ball, f)
    x8, y8, z8, reach = eight(x), eight(y), eight(z), eight(r + np.float32(best[0] + spare))
    own = np.uint64(f == begun[0]) << (begun[1] % _L)
    s = np.uint64(blocks1.member[f])
    for j in range(few):
        block = np.uint64(np.int64(room2.near[j]))
        bits = _meet(x8, y8, z8, reach, room2.ball, block) & ~(own * np.uint64(block == begun[1] // _L))
        while bits != 0:
            t = np.uint64(blocks2.member[block * _L + first_bit(bits)])
            bits &= bits - _ONE
            best = _better(c1, c2, p, radius1, radius2, s, t, best)
            reach = eight(r + np.float32(best[0] + spare))
    return best


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _search_few(one, other, p, counts, heights, begun, spare, rooms, best):  # type: ignore[no-untyped-def]
    """Every sphere of the one's front against all blocks of the other's."""
    room1 = rooms[0]
    count, lowest = np.uint64(0), eight(heights[0])
    for q in range(counts[0]):
        bits = not_above(lowest, load(room1.high, q * _L))
        count = pack(room1.near, count, bits, room1.some[q] * np.float32(8.0))
    for q in range(count):
        f = np.uint64(np.int64(room1.near[q]))
        best = _scan(one, other, p, f, counts[1], begun, spare, rooms, best)
    return best


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _search_many(one, other, p, counts, heights, begun, spare, rooms, best):  # type: ignore[no-untyped-def]
    """As `_search_few`, the balls of the blocks compared first."""
    room1, room2 = rooms
    first, last = heights[1], heights[2]
    for g in range(first, last):
        room2.kept[g - first] = np.uint64(0)
    for q in range(counts[1]):
        block = np.uint64(np.int64(room2.near[q]))
        room2.kept[block // _L - np.uint64(first)] |= _ONE << (block % _L)
    for q in range(counts[0]):
        block = np.uint64(np.int64(room1.some[q]))
        bits = not_above(eight(heights[0]), load(room1.high, q * _L))
        count = pack(room1.near, np.uint64(0), bits, np.float32(block * _L))
        x, y, z, r = _ball(room1.hub, block)
        x8, y8, z8, reach = eight(x), eight(y), eight(z), eight(r + np.float32(best[0] + spare))
        few = np.uint64(0)
        for g in range(first, last):
            bits = _meet(x8, y8, z8, reach, room2.hub, np.uint64(g)) & room2.kept[g - first]
            few = pack(room2.near, few, bits, np.float32(g * 8))
        for o in range(count):
            f = np.uint64(np.int64(room1.near[o]))
            best = _scan(one, other, p, f, few, begun, spare, rooms, best)
    return best


@njit(cache=True, error_model="numpy", _nrt=False)
def foremost_pair(one, other, p, groups, way, begun, spare, rooms, best):  # type: ignore[no-untyped-def]
    """Least I of two segments with its spheres, of equal ones the lowest; best (I, sphere, sphere): to begin with.

    one, other: (centres (P, S, 3), radius (S,), Blocks); groups: first and last block of balls of both; way (3,): unit
    vector, about from the one's sphere of best to the other's; begun: their places; spare [m]: margin for rounding.
    """
    room1, room2 = rooms
    within = np.float32(best[0] + spare)
    top1, used1, top2, used2 = _fronts(way, within, groups, room1, room2)
    count, lowest = np.uint64(0), eight(-within - top1)
    for q in range(used2):
        room2.near[count] = room2.some[q]
        count += np.uint64(not_above(lowest, load(room2.high, q * _L)) != 0)
    counts, heights = (used1, count), (-within - top2, groups[2], groups[3])
    if used1 * count > HEAVY:
        return _search_many(one, other, p, counts, heights, begun, spare, rooms, best)
    return _search_few(one, other, p, counts, heights, begun, spare, rooms, best)
