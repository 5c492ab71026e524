"""Batch loops of bodies against groups of parts: does anything collide, and the least clearance of
each segment.

Segments first, then clusters of spheres, spheres, polygons: the next only where the last cannot
decide. A signed distance changes by no more than the way moved, so what holds at the middle of a
cluster bounds all its spheres.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.contact.kernels.distance_field import (
    near_polygon,
    penetration_bound,
    penetration_depth,
    span_bound,
    square_bound,
    within_distance,
)
from workbench.contact.kernels.search import foot, nearest_in, polygon_number, record_gap
from workbench.geometry.bvh import wider

__all__ = [
    "GroupSpace",
    "SphereClusters",
    "carried",
    "cluster_hub",
    "group_clearance",
    "group_collides",
    "group_room",
]


HAIR = 1e-12
"""More [m] than the rounding of a room less what is allowed."""


SHIFT = 1e-9
"""More [m] than the rounding of a distance between two points of the body."""


class SphereClusters(NamedTuple):
    """The spheres of a body in clusters: those of segment n are start[n]:start[n + 1].

    radius (S,); cluster c holds the spheres member[first[c]:first[c + 1]], all of them within
    reach[c] [m] of its hub at every twist: the point hub[c] of the segment's frame, or where
    spheres twist the centre of sphere middle[c] (-1: the hub, which spares fetching the centres of
    1,000 poses from memory). around (N, 3), big (N,): enclosing spheres in the segments' frames;
    shown (N,).
    """

    radius: NDArray[np.float64]
    start: NDArray[np.int64]
    middle: NDArray[np.int64]
    hub: NDArray[np.float64]
    reach: NDArray[np.float64]
    first: NDArray[np.int64]
    member: NDArray[np.int64]
    around: NDArray[np.float64]
    big: NDArray[np.float64]
    shown: NDArray[np.int64]


class GroupSpace(NamedTuple):
    """Working space of a thread."""

    stack: NDArray[np.int64]
    """(DEEP,) tree nodes to visit."""
    gaps: NDArray[np.float32]
    """(DEEP + EIGHT,) their squared distances [m2], and those of one node's children."""
    lows: NDArray[np.float64]
    """Lower bound [m] of each cluster, or of each segment and group that may collide."""
    low: NDArray[np.float64]
    """(S,) lower bound [m] of each sphere."""
    pair: NDArray[np.int64]
    """(N G,) segments and groups that may collide, as n G + g."""
    free: NDArray[np.float64]
    """(B, 4) balls without surface: centre and radius [m]."""
    key: NDArray[np.float64]
    """(G,) lower bound [m] of the room that a segment has from each group."""


@inlined
def carried(world, p, n, a, b, c):  # type: ignore[no-untyped-def]
    """A point of the frame of segment n in the world."""
    x = world[p, n, 0, 0] * a + world[p, n, 0, 1] * b + world[p, n, 0, 2] * c + world[p, n, 0, 3]
    y = world[p, n, 1, 0] * a + world[p, n, 1, 1] * b + world[p, n, 1, 2] * c + world[p, n, 1, 3]
    z = world[p, n, 2, 0] * a + world[p, n, 2, 1] * b + world[p, n, 2, 2] * c + world[p, n, 2, 3]
    return x, y, z


@inlined
def cluster_hub(centres, world, p, crowd, n, c):  # type: ignore[no-untyped-def]
    """The hub of cluster c of segment n in the world, in pose p."""
    m = crowd.middle[c]
    if m >= 0:
        return centres[p, m, 0], centres[p, m, 1], centres[p, m, 2]
    return carried(world, p, n, crowd.hub[c, 0], crowd.hub[c, 1], crowd.hub[c, 2])


@inlined
def _least(low, a, b):  # type: ignore[no-untyped-def]
    """Where the least of low[a:b] stands."""
    lead = a
    for i in range(a + 1, b):
        if low[i] < low[lead]:
            lead = i
    return lead


@inlined
def _free(x, y, z, free):  # type: ignore[no-untyped-def]
    """How far a point surely is from all surfaces of a group by the balls free (B, 4) that hold
    none: centres and radii [m]; no more than 0 where they do not say."""
    clear = 0.0
    for j in range(len(free)):
        u = x - free[j, 0]
        v = y - free[j, 1]
        w = z - free[j, 2]
        clear = max(clear, free[j, 3] - math.sqrt(u * u + v * v + w * w) - SHIFT)
    return clear


@inner
def _sphere(x, y, z, r, s, faces, shells, field, g, best, most, turn, space):  # type: ignore[no-untyped-def]
    """Improve best = (signed distance, sphere, polygon) by sphere s, of radius r, which stands at
    (x, y, z).

    most: the least distance is no more than this. Where the centre is outside of all solids, the
    ball around it without surface is put down in space.free, in a place by the number `turn`.
    """
    signed, sphere, polygon = best
    # the sum's rounding counts where a centre lies on a surface
    reach = most + r + 1e-15 * (abs(most) + r)
    clear = _free(x, y, z, space.free)
    if clear > max(reach, 0.0):
        return best
    if clear == 0.0 and not square_bound(x, y, z, field, g)[1]:
        depth, f = penetration_depth(x, y, z, faces, shells, field, g, space.stack, space.gaps)
        if f >= 0:
            better = -depth - r < signed or (-depth - r == signed and s < sphere)
            return (-depth - r, s, f) if better else best
    if reach < 0.0:
        return best
    limit = reach * reach * (1.0 + 1e-12)
    hint = near_polygon(x, y, z, field, g)
    square, f = nearest_in(
        x, y, z, field.trees, field.trees.root[g], hint, limit, space.stack, space.gaps
    )
    away = math.sqrt(square)
    j = turn % len(space.free)
    space.free[j, 0] = x
    space.free[j, 1] = y
    space.free[j, 2] = z
    space.free[j, 3] = away
    if f >= 0:
        gap = away - r
        if gap < signed or (gap == signed and s < sphere):
            signed = gap
            sphere = s
            polygon = f
    return signed, sphere, polygon


@inlined
def _cluster(centres, p, crowd, c, field, g, most, low):  # type: ignore[no-untyped-def]
    """Bound the signed distances of the spheres of cluster c from below, into low; `most` lowered
    by those from above.

    What is above `most` is left infinite. A sphere that may be inside a solid is no deeper than the
    way to any polygon of that solid.
    """
    for i in range(crowd.first[c], crowd.first[c + 1]):
        s = crowd.member[i]
        x = centres[p, s, 0]
        y = centres[p, s, 1]
        z = centres[p, s, 2]
        r = crowd.radius[s]
        if most < np.inf and span_bound(x, y, z, field, g) > max(most + r, 0.0) ** 2:
            continue
        square, sure = square_bound(x, y, z, field, g)
        least = math.sqrt(square) - r
        if sure and least > most:
            continue
        rank = near_polygon(x, y, z, field, g)
        way = math.sqrt(record_gap(x, y, z, field.trees, rank, np.inf))
        low[i] = least if sure else -penetration_bound(x, y, z, field, g, rank, way) - r
        most = min(most, way - r)
    return most


@inlined
def _cluster_bound(x, y, z, reach, field, g):  # type: ignore[no-untyped-def]
    """Lower bound of the signed distances of all spheres within reach of a hub; none where it may
    be inside a solid."""
    square, sure = square_bound(x, y, z, field, g)
    return math.sqrt(square) - reach if sure else -np.inf


@inlined
def _bound_clusters(centres, world, p, crowd, n, field, g, lows):  # type: ignore[no-untyped-def]
    """Write lower bounds [m] of the distances of segment n's clusters to a group into lows: by the
    group's box, or by its grid where that says nothing."""
    for c in range(crowd.start[n], crowd.start[n + 1]):
        x, y, z = cluster_hub(centres, world, p, crowd, n, c)
        square = span_bound(x, y, z, field, g)
        lows[c] = math.sqrt(square) - crowd.reach[c]
        if square == 0.0:
            lows[c] = _cluster_bound(x, y, z, crowd.reach[c], field, g)


@inlined
def _bound_spheres(centres, world, p, crowd, n, field, g, most, space):  # type: ignore[no-untyped-def]
    """Write lower bounds [m] of the distances of those spheres that may be the nearest, and no
    farther than `most`, into space.low, infinite for the others; returns an upper bound of the
    least.

    Clusters are opened from the nearest on, until the next is farther than that.
    """
    a = crowd.start[n]
    b = crowd.start[n + 1]
    for i in range(crowd.first[a], crowd.first[b]):
        space.low[i] = np.inf
    for _ in range(a, b):
        c = _least(space.lows, a, b)
        if space.lows[c] > most:
            break
        space.lows[c] = np.inf
        x, y, z = cluster_hub(centres, world, p, crowd, n, c)
        if (
            span_bound(x, y, z, field, g) > 0.0
            and _cluster_bound(x, y, z, crowd.reach[c], field, g) > most
        ):
            continue
        most = _cluster(centres, p, crowd, c, field, g, most, space.low)
    return most


@inlined
def _segment(centres, world, p, crowd, n, faces, shells, field, g, most, space):  # type: ignore[no-untyped-def]
    """Least signed distance [m] of segment n to a group, with the sphere and the polygon; infinite,
    -1 and -1 where it is more than `most`.

    Spheres are measured from the one with the least bound on, until the next bound is more than the
    least distance.
    """
    _bound_clusters(centres, world, p, crowd, n, field, g, space.lows)
    most = _bound_spheres(centres, world, p, crowd, n, field, g, most, space)
    begin = crowd.first[crowd.start[n]]
    end = crowd.first[crowd.start[n + 1]]
    low = space.low
    best = (np.inf, -1, -1)
    for j in range(len(space.free)):
        space.free[j, 3] = 0.0
    turn = 0
    while True:
        i = _least(low, begin, end)
        if low[i] > most or low[i] == np.inf:
            break
        low[i] = np.inf
        s = crowd.member[i]
        x = centres[p, s, 0]
        y = centres[p, s, 1]
        z = centres[p, s, 2]
        r = crowd.radius[s]
        best = _sphere(x, y, z, r, s, faces, shells, field, g, best, most, turn, space)
        turn += 1
        most = min(most, best[0])
    return best


@inlined
def _write(centres, trees, p, n, g, distance, s, rank, out):  # type: ignore[no-untyped-def]
    """Write what is nearest to segment n in pose p into column g of out."""
    x, y, z = foot(centres[p, s, 0], centres[p, s, 1], centres[p, s, 2], trees, rank)
    out.distance[p, n, g] = distance
    out.sphere[p, n, g] = s
    out.polygon[p, n, g] = polygon_number(trees, rank)
    out.point[p, n, g, 0] = x
    out.point[p, n, g, 1] = y
    out.point[p, n, g, 2] = z


@batch_loop
def group_clearance(centres, world, crowd, faces, shells, field, out, space, begin, end):  # type: ignore[no-untyped-def]
    """Signed clearance of every segment to every group, for the poses begin..end.

    centres (P, S, 3), world (P, N, 3, 4) [m]; out: Nearest, filled where shown; space: GroupSpace.
    """
    for p in range(begin, end):
        for n in range(len(crowd.shown)):
            if crowd.shown[n] == 0 or crowd.start[n] == crowd.start[n + 1]:
                continue
            for g in range(len(field.trees.root)):
                if field.trees.root[g] < 0:
                    continue
                d, s, f = _segment(
                    centres, world, p, crowd, n, faces, shells, field, g, np.inf, space
                )
                _write(centres, field.trees, p, n, g, d, s, f, out)


@inlined
def _bound_groups(world, p, crowd, n, field, allowed, key):  # type: ignore[no-untyped-def]
    """Write lower bounds [m] of the room of segment n from each group into key, infinite for empty
    ones: by the sphere around the segment."""
    x, y, z = carried(world, p, n, crowd.around[n, 0], crowd.around[n, 1], crowd.around[n, 2])
    for g in range(len(key)):
        key[g] = np.inf
        if field.trees.root[g] >= 0:
            key[g] = _cluster_bound(x, y, z, crowd.big[n], field, g) + allowed[n, g]


@batch_loop
def group_room(centres, world, crowd, faces, shells, field, allowed, out, space, begin, end):  # type: ignore[no-untyped-def]
    """Least signed clearance of every segment, the overlap that is allowed added, over all groups,
    for the poses begin..end.

    centres (P, S, 3), world (P, N, 3, 4), allowed (N, G) [m]; out: Nearest of one group,
    filled where shown; space: GroupSpace. Groups are asked from the least bound on, each for what
    is nearer than the nearest so far.
    """
    for p in range(begin, end):
        for n in range(len(crowd.shown)):
            if crowd.shown[n] == 0 or crowd.start[n] == crowd.start[n + 1]:
                continue
            _bound_groups(world, p, crowd, n, field, allowed, space.key)
            best = np.inf
            for _ in range(len(field.trees.root)):
                g = _least(space.key, 0, len(field.trees.root))
                if space.key[g] > best or space.key[g] == np.inf:
                    break
                space.key[g] = np.inf
                most = best - allowed[n, g] + HAIR
                d, s, f = _segment(
                    centres, world, p, crowd, n, faces, shells, field, g, most, space
                )
                if s >= 0 and d + allowed[n, g] < best:
                    best = d + allowed[n, g]
                    _write(centres, field.trees, p, n, 0, best, s, f, out)


@inlined
def _sphere_hits(x, y, z, r, faces, shells, field, g, allowed, space):  # type: ignore[no-untyped-def]
    """True where a sphere is deeper in a group than allowed."""
    square, sure = square_bound(x, y, z, field, g)
    if not sure:
        depth, f = penetration_depth(x, y, z, faces, shells, field, g, space.stack, space.gaps)
        if f >= 0:
            return depth + r > allowed
    if r <= allowed or square > wider((r - allowed) * (r - allowed)):
        return False
    return within_distance(x, y, z, r, field, g, allowed, space.stack, space.gaps)


@inlined
def _segment_hits(centres, world, p, crowd, n, faces, shells, field, g, allowed, space):  # type: ignore[no-untyped-def]
    """True where a sphere of segment n is deeper in a group than allowed."""
    for c in range(crowd.start[n], crowd.start[n + 1]):
        x, y, z = cluster_hub(centres, world, p, crowd, n, c)
        square, sure = square_bound(x, y, z, field, g)
        limit = max(crowd.reach[c] - allowed, 0.0)
        if sure and square >= limit * limit:
            continue
        for i in range(crowd.first[c], crowd.first[c + 1]):
            s = crowd.member[i]
            x = centres[p, s, 0]
            y = centres[p, s, 1]
            z = centres[p, s, 2]
            if _sphere_hits(x, y, z, crowd.radius[s], faces, shells, field, g, allowed, space):
                return True
    return False


@inlined
def _candidates(world, p, crowd, field, allowed, key, pair):  # type: ignore[no-untyped-def]
    """Segments and groups that may collide in pose p, the most promising first; how many."""
    used = 0
    groups = len(field.trees.root)
    for n in range(len(crowd.shown)):
        if crowd.shown[n] == 0 or crowd.start[n] == crowd.start[n + 1]:
            continue
        x, y, z = carried(world, p, n, crowd.around[n, 0], crowd.around[n, 1], crowd.around[n, 2])
        for g in range(groups):
            if field.trees.root[g] < 0:
                continue
            square, sure = square_bound(x, y, z, field, g)
            limit = max(crowd.big[n] - allowed[n, g], 0.0)
            if sure and square >= limit * limit:
                continue
            rank = math.sqrt(square) - limit
            at = used
            while at > 0 and key[at - 1] > rank:
                key[at] = key[at - 1]
                pair[at] = pair[at - 1]
                at -= 1
            key[at] = rank
            pair[at] = n * groups + g
            used += 1
    return used


@batch_loop
def group_collides(centres, world, crowd, faces, shells, field, allowed, hit, space, begin, end):  # type: ignore[no-untyped-def]
    """Fill hit (P,) for the poses begin..end: is any sphere deeper in a group than allowed (N, G)
    [m], tolerance included, for its segment? centres (P, S, 3), world (P, N, 3, 4) [m]; space:
    GroupSpace."""
    groups = len(field.trees.root)
    for p in range(begin, end):
        used = _candidates(world, p, crowd, field, allowed, space.lows, space.pair)
        found = False
        for i in range(used):
            n = space.pair[i] // groups
            g = space.pair[i] % groups
            if _segment_hits(
                centres, world, p, crowd, n, faces, shells, field, g, allowed[n, g], space
            ):
                found = True
                break
        hit[p] = found
