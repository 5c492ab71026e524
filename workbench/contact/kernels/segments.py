"""Batch loops of bodies against one group of parts, or several without asking which: eight balls at
a time.

The answers are those of `groups`, to the last bit; which balls are looked at, and in which order,
does not show.
"""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit
from workbench.contact.kernels.bounds import (
    FAR,
    bound_lanes,
    carry,
    frame_of,
    gathered,
    in_solid_box,
)
from workbench.contact.kernels.field import (
    deepest,
    deepest_may_be,
    list_of,
    list_ways,
    near_polygon,
    nearest_of,
    reaches,
    record_gap,
    record_point,
)
from workbench.contact.kernels.groups import carried, cluster_hub
from workbench.geometry.lanes import (
    LANES,
    eight,
    equal,
    first_bit,
    least,
    load,
    not_above,
    smaller,
    store,
)

__all__ = ["ROOM", "segment_collides", "segment_least"]

ROOM = 5 * LANES
"""Numbers of single precision that bounds are worked out in."""


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _hub_bounds(centres, world, p, n, frame, index, g, lows, room):  # type: ignore[no-untyped-def]
    """Lower bounds of the signed distances of the clusters of segment n to group g, block after
    block, into lows."""
    crowd, lanes, field = index
    step = np.uint64(LANES)
    for b in range(lanes.group[n], lanes.group[n + 1]):
        at = np.uint64(4 * LANES) * np.uint64(b)
        spot = carry(frame, lanes.hub, at)
        if lanes.block_moves[b] != 0:
            store(room, np.uint64(0), spot[0])
            store(room, step, spot[1])
            store(room, step + step, spot[2])
            for lane in range(LANES):
                c = lanes.cluster[LANES * b + lane]
                if c >= 0 and crowd.middle[c] >= 0:
                    for axis in range(3):
                        room[lane + axis * LANES] = (
                            centres[p, crowd.middle[c], axis] - field.grid[g, axis]
                        )
            spot = load(room, np.uint64(0)), load(room, step), load(room, step + step)
        way, unsure = bound_lanes(spot, lanes.extent[0], field, g, room)
        base = LANES * (b - lanes.group[n])
        store(lows, np.uint64(base), way - load(lanes.hub, at + step + step + step))
        while unsure != np.uint64(0):
            k = np.int64(first_bit(unsure))
            unsure &= unsure - np.uint64(1)
            c = lanes.cluster[LANES * b + k]
            if c >= 0:
                x, y, z = cluster_hub(centres, world, p, crowd, n, c)
                if in_solid_box(x, y, z, field, g):
                    lows[base + k] = -np.inf


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _sphere_bounds(centres, p, c, frame, index, g, room):  # type: ignore[no-untyped-def]
    """Lower bounds of the signed distances of the spheres of cluster c to group g, and which may be
    in solids."""
    _, lanes, field = index
    at = np.uint64(4 * LANES) * np.uint64(c)
    spot = carry(frame, lanes.ball, at)
    if lanes.moves[c] != 0:
        spot = gathered(centres, p, lanes.member, LANES * c, field, g, room)
    way, unsure = bound_lanes(spot, lanes.extent[0], field, g, room)
    return way - load(lanes.ball, at + np.uint64(3 * LANES)), unsure


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _above(most):  # type: ignore[no-untyped-def]
    """A number of single precision that is more than one of double."""
    return np.float32(most + 1e-6 * abs(most) + 1e-9)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _improved(centres, p, s, sure, index, solids, best, most, space):  # type: ignore[no-untyped-def]
    """Improve best = (signed distance, sphere, polygon) to group 0 by sphere s; most: the least is
    no more than this.

    sure: the sphere's centre is outside all solids.
    """
    crowd, _, field = index
    signed, sphere, polygon = best
    x = centres[p, s, 0]
    y = centres[p, s, 1]
    z = centres[p, s, 2]
    r = crowd.radius[s]
    if not sure:
        depth, f = deepest(x, y, z, solids[0], solids[1], field, 0, space[0], space[1])
        if f >= 0:
            better = -depth - r < signed or (-depth - r == signed and s < sphere)
            return (-depth - r, s, f) if better else best
    reach = (
        most + r + 1e-15 * (abs(most) + r)
    )  # the sum's rounding counts where a centre lies on a surface
    if reach < 0.0:
        return best
    square, f = nearest_of(x, y, z, field, 0, reach * reach * (1.0 + 1e-12), space[0], space[1])
    if f >= 0:
        gap = math.sqrt(square) - r
        if gap < signed or (gap == signed and s < sphere):
            signed = gap
            sphere = s
            polygon = f
    return signed, sphere, polygon


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _next_block(lows, blocks):  # type: ignore[no-untyped-def]
    """The least of the first LANES * blocks of lows, and where it stands."""
    lead = load(lows, np.uint64(0))
    for b in range(1, blocks):
        lead = smaller(lead, load(lows, np.uint64(LANES * b)))
    value = least(lead)
    for b in range(blocks):
        bits = equal(load(lows, np.uint64(LANES * b)), eight(value))
        if bits != np.uint64(0):
            return value, LANES * b + np.int64(first_bit(bits))
    return value, -1


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _open(centres, p, c, frame, index, most, room, low, some, used):  # type: ignore[no-untyped-def]
    """Append the spheres of cluster c that may be as near as `most` to low, some; `most` and how
    many there are then.

    some: their numbers, or -1 less that where they may be inside a solid: such a sphere is no
    deeper than the way to any polygon of that solid.
    """
    crowd, lanes, field = index
    bound, unsure = _sphere_bounds(centres, p, c, frame, index, 0, room)
    store(room, np.uint64(0), bound)
    bits = not_above(bound, eight(_above(most))) | unsure
    while bits != np.uint64(0):
        k = np.int64(first_bit(bits))
        bits &= bits - np.uint64(1)
        s = lanes.member[LANES * c + k]
        if s < 0:
            continue
        low[used] = room[k]
        some[used] = s
        if unsure >> np.uint64(k) & np.uint64(1) != np.uint64(0):
            x = centres[p, s, 0]
            y = centres[p, s, 1]
            z = centres[p, s, 2]
            r = crowd.radius[s]
            if in_solid_box(x, y, z, field, 0):
                rank = near_polygon(x, y, z, field, 0)
                way = math.sqrt(record_gap(x, y, z, field, rank, np.inf))
                deep = -deepest_may_be(x, y, z, field, 0, rank, way) - r
                low[used] = -_above(-deep)
                some[used] = -1 - s
                most = min(most, way - r)
        if low[used] <= _above(most):
            used += 1
    return most, used


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _lead(low, some, used, kept):  # type: ignore[no-untyped-def]
    """Which of the candidates of `kept` on has the least bound; -1 where there is none."""
    lead = -1
    for i in range(kept, used):
        if lead < 0 or low[i] < low[lead]:
            lead = i
    return lead


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _swapped(low, some, i, k):  # type: ignore[no-untyped-def]
    """Swap two candidates."""
    low[i], low[k] = low[k], low[i]
    some[i], some[k] = some[k], some[i]


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _refined(centres, p, s, radius, field, bound, most, gaps):  # type: ignore[no-untyped-def]
    """A closer lower bound of the signed distance of sphere s, and `most` lowered by one from
    above."""
    x = centres[p, s, 0]
    y = centres[p, s, 1]
    z = centres[p, s, 2]
    at = list_of(x, y, z, field, 0)
    if at < 0:
        return bound, most
    below, above, spare = list_ways(x, y, z, field, 0, at, gaps)
    if above > below + np.float32(3.0) * spare:  # a polygon of many corners: its own distance
        for i in range(LANES * np.int64(field.listed[at])):
            if gaps[i] <= below + spare:
                rank = field.patch[LANES * np.int64(field.listed[at + 1 + i // LANES]) + i % LANES]
                most = min(most, math.sqrt(record_gap(x, y, z, field, rank, np.inf)) - radius[s])
                break
    return -_above(radius[s] - np.float64(below)), min(most, np.float64(above) - radius[s])


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _segment(centres, world, p, n, index, solids, space):  # type: ignore[no-untyped-def]
    """Least signed distance of segment n to the only group, with the sphere and the polygon."""
    crowd, lanes, field = index
    gaps = space[1]
    room = space[2]
    lows = space[3]
    low = space[4]
    some = space[5]
    frame = frame_of(world, p, n, field, 0)
    _hub_bounds(centres, world, p, n, frame, index, 0, lows, room)
    first = lanes.group[n]
    blocks = lanes.group[n + 1] - lanes.group[n]
    # candidates: those before `kept` have their closer bound, or have to be worked out anyway
    best = (np.inf, -1, -1)
    most = np.inf
    seen = np.inf
    used = 0
    kept = 0
    while True:
        bound, lane = _next_block(lows, blocks)
        if bound > _above(most) or bound > 0.5 * FAR:
            break
        lows[lane] = np.inf
        old = used
        most, used = _open(
            centres,
            p,
            lanes.cluster[LANES * first + lane],
            frame,
            index,
            most,
            room,
            low,
            some,
            used,
        )
        lead = _lead(low, some, used, old)
        # one that promises more than all before is looked at at once: what follows is measured by
        # it
        if lead >= 0 and low[lead] < seen:
            seen = low[lead]
            if some[lead] >= 0:
                low[lead], most = _refined(
                    centres, p, some[lead], crowd.radius, field, low[lead], most, gaps
                )
            _swapped(low, some, lead, kept)
            kept += 1
    while kept < used:
        lead = _lead(low, some, used, kept)
        if low[lead] > _above(most):
            break
        if some[lead] >= 0:
            low[lead], most = _refined(
                centres, p, some[lead], crowd.radius, field, low[lead], most, gaps
            )
        _swapped(low, some, lead, kept)
        kept += 1
    for i in range(kept):
        if low[i] <= _above(most):
            s = max(some[i], -1 - some[i])
            best = _improved(centres, p, s, some[i] >= 0, index, solids, best, most, space)
            most = min(most, best[0])
    return best


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)
def segment_least(centres, world, index, solids, out, space, begin, end):  # type: ignore[no-untyped-def]
    """Signed clearance of every segment to the only group of a field, for the poses begin..end.

    centres (P, S, 3), world (P, N, 3, 4); index: Crowd, Lanes, Field; solids: Faces, Shells; out:
    distance, sphere, polygon (P, N, 1), nearest point (P, N, 1, 3), filled where shown. space:
    stack, gaps as searches want them, and in single precision room (ROOM,), lows (lanes of
    clusters,), low (S,), then the numbers of as many spheres: working space.
    """
    crowd, _, field = index
    distance, sphere, polygon, point = out
    if field.root[0] < 0:
        return
    for p in range(begin, end):
        for n in range(len(crowd.shown)):
            if crowd.shown[n] == 0 or crowd.start[n] == crowd.start[n + 1]:
                continue
            d, s, f = _segment(centres, world, p, n, index, solids, space)
            distance[p, n, 0] = d
            sphere[p, n, 0] = s
            polygon[p, n, 0] = int(field.record[field.begin[f] + 8])
            x = centres[p, s, 0]
            y = centres[p, s, 1]
            z = centres[p, s, 2]
            point[p, n, 0, 0], point[p, n, 0, 1], point[p, n, 0, 2] = record_point(
                x, y, z, field, f
            )


@njit(cache=True, error_model="numpy", _nrt=False)
def _sphere_hits(centres, p, s, unsure, index, solids, g, allowed, space):  # type: ignore[no-untyped-def]
    """True where sphere s is deeper in a group than allowed."""
    crowd, _, field = index
    x = centres[p, s, 0]
    y = centres[p, s, 1]
    z = centres[p, s, 2]
    r = crowd.radius[s]
    if unsure:
        depth, f = deepest(x, y, z, solids[0], solids[1], field, g, space[0], space[1])
        if f >= 0:
            return depth + r > allowed
    return r > allowed and reaches(x, y, z, r, field, g, allowed, space[0], space[1])


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _segment_hits(centres, world, p, n, g, index, solids, allowed, space):  # type: ignore[no-untyped-def]
    """True where a sphere of segment n is deeper in a group than allowed."""
    _, lanes, field = index
    room = space[2]
    lows = space[3]
    frame = frame_of(world, p, n, field, g)
    _hub_bounds(centres, world, p, n, frame, index, g, lows, room)
    free = np.float32(-allowed * (1.0 - 1e-6))
    for b in range(lanes.group[n], lanes.group[n + 1]):
        bits = not_above(load(lows, np.uint64(LANES * (b - lanes.group[n]))), eight(free))
        while bits != np.uint64(0):
            c = lanes.cluster[LANES * b + np.int64(first_bit(bits))]
            bits &= bits - np.uint64(1)
            bound, unsure = _sphere_bounds(centres, p, c, frame, index, g, room)
            near = not_above(bound, eight(free)) | unsure
            while near != np.uint64(0):
                k = first_bit(near)
                near &= near - np.uint64(1)
                s = lanes.member[LANES * c + np.int64(k)]
                doubt = unsure >> k & np.uint64(1) != np.uint64(0)
                if s >= 0 and _sphere_hits(centres, p, s, doubt, index, solids, g, allowed, space):
                    return True
    return False


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _candidates(world, p, index, g, allowed, room, key, pair):  # type: ignore[no-untyped-def]
    """Segments that may collide with group g in pose p, the most promising first; how many."""
    crowd, lanes, field = index
    used = 0
    step = np.uint64(LANES)
    for b in range(0, len(lanes.who), LANES):
        for k in range(LANES):
            n = lanes.who[min(b + k, len(lanes.who) - 1)]
            x, y, z = carried(
                world, p, n, crowd.around[n, 0], crowd.around[n, 1], crowd.around[n, 2]
            )
            room[k] = x - field.grid[g, 0]
            room[k + LANES] = y - field.grid[g, 1]
            room[k + 2 * LANES] = z - field.grid[g, 2]
        spot = load(room, np.uint64(0)), load(room, step), load(room, step + step)
        way, unsure = bound_lanes(spot, lanes.extent[0], field, g, room)
        store(room, np.uint64(0), way)
        for k in range(min(LANES, len(lanes.who) - b)):
            n = lanes.who[b + k]
            rank = room[k] - max(crowd.big[n] - allowed[n, g], 0.0)
            if crowd.shown[n] == 0 or (
                rank > 0.0 and unsure >> np.uint64(k) & np.uint64(1) == np.uint64(0)
            ):
                continue
            at = used
            while at > 0 and key[at - 1] > rank:
                key[at] = key[at - 1]
                pair[at] = pair[at - 1]
                at -= 1
            key[at] = rank
            pair[at] = n
            used += 1
    return used


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)
def segment_collides(centres, world, index, solids, allowed, hit, space, begin, end):  # type: ignore[no-untyped-def]
    """Fill hit (P,) for the poses begin..end: is any sphere deeper in a group than allowed (N, G)
    [m], tolerance included, for its segment? As in `segment_least`; space: stack, gaps, room, lows
    as there, key (N,), pair (N,)."""
    field = index[2]
    for p in range(begin, end):
        found = False
        for g in range(len(field.root)):
            if found or field.root[g] < 0:
                continue
            used = _candidates(world, p, index, g, allowed, space[2], space[4], space[5])
            for i in range(used):
                n = space[5][i]
                if _segment_hits(centres, world, p, n, g, index, solids, allowed[n, g], space):
                    found = True
                    break
        hit[p] = found
