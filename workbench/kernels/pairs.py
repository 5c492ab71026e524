"""Batch loops of spheres against spheres: the paper's three steps, and the least distance of segment pairs."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from workbench.kernels.groups import carried, cluster_hub

__all__ = ["pair_clearance", "pair_witness", "sphere_contacts"]


@njit(cache=True, inline="always")
def _apart(a, b):  # type: ignore[no-untyped-def]
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@njit(cache=True)
def sphere_contacts(one, other, pairs, margin):  # type: ignore[no-untyped-def]
    """All sphere pairs of the segment pairs (M, 2) nearer than margin [m].

    one, other: (centres (P, S, 3), radius, start, around (P, N, 3), around_radius). I = |ci - cj| - (ri + rj). Three
    steps: enclosing spheres; each sphere of the smaller set against the other's enclosing sphere; pairs. Returns rows
    (C, 3): pose, sphere of one, sphere of other; I (C,).
    """
    c1, r1, start1, around1, big1 = one
    c2, r2, start2, around2, big2 = other
    rows, numbers, used = np.empty((256, 3), np.int64), np.empty(256), 0
    for p in range(c1.shape[0]):
        for m in range(pairs.shape[0]):
            a, b = pairs[m, 0], pairs[m, 1]
            if not _apart(around1[p, a], around2[p, b]) - big1[a] - big2[b] < margin:
                continue
            small = start1[a + 1] - start1[a] <= start2[b + 1] - start2[b]
            outer = (start1[a], start1[a + 1]) if small else (start2[b], start2[b + 1])
            inner = (start2[b], start2[b + 1]) if small else (start1[a], start1[a + 1])
            for u in range(outer[0], outer[1]):
                cu, ru = (c1[p, u], r1[u]) if small else (c2[p, u], r2[u])
                far, big = (around2[p, b], big2[b]) if small else (around1[p, a], big1[a])
                if not _apart(cu, far) - ru - big < margin:
                    continue
                for v in range(inner[0], inner[1]):
                    cv, rv = (c2[p, v], r2[v]) if small else (c1[p, v], r1[v])
                    gap = _apart(cu, cv) - (ru + rv)
                    if not gap < margin:
                        continue
                    if used == len(rows):
                        rows = np.concatenate((rows, np.empty_like(rows)))
                        numbers = np.concatenate((numbers, np.empty_like(numbers)))
                    rows[used, 0] = p
                    rows[used, 1], rows[used, 2] = (u, v) if small else (v, u)
                    numbers[used] = gap
                    used += 1
    return rows[:used], numbers[:used]


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _nearer(c1, c2, p, crowd1, crowd2, c, hubs, d, best, u, v):  # type: ignore[no-untyped-def]
    """Improve the least I and its spheres (u, v) by those of cluster c of one and d of the other; ties to the first."""
    for i in range(crowd1.first[c], crowd1.first[c + 1]):
        s = crowd1.member[i]
        x, y, z, r = c1[p, s, 0], c1[p, s, 1], c1[p, s, 2], crowd1.radius[s]
        a, b, e, most = x - hubs[d, 0], y - hubs[d, 1], z - hubs[d, 2], best + r + crowd2.reach[d]
        if most < 0.0 or a * a + b * b + e * e > most * most:
            continue
        for j in range(crowd2.first[d], crowd2.first[d + 1]):
            t = crowd2.member[j]
            a, b, e = x - c2[p, t, 0], y - c2[p, t, 1], z - c2[p, t, 2]
            square, both = a * a + b * b + e * e, r + crowd2.radius[t]
            # the root is taken only where it may count
            if best + both < 0.0 or square > (best + both) * (best + both) * (1.0 + 1e-12) + 1e-30:
                continue
            gap = math.sqrt(square) - both
            if gap < best or (gap == best and (s < u or (s == u and t < v))):
                best, u, v = gap, s, t
    return best, u, v


@njit(cache=True, error_model="numpy", _nrt=False)
def _fill_hubs(centres, world, p, crowd, hubs, around):  # type: ignore[no-untyped-def]
    """Fill hubs (C, 3) and around (N, 3) with the middles of the clusters and of the segments in the world, pose p."""
    for n in range(len(crowd.start) - 1):
        x, y, z = carried(world, p, n, crowd.around[n, 0], crowd.around[n, 1], crowd.around[n, 2])
        around[n, 0], around[n, 1], around[n, 2] = x, y, z
        for c in range(crowd.start[n], crowd.start[n + 1]):
            hubs[c, 0], hubs[c, 1], hubs[c, 2] = cluster_hub(centres, world, p, crowd, n, c)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _beyond(a, i, b, j, most):  # type: ignore[no-untyped-def]
    """True where the points a[i] and b[j] are farther apart than `most`."""
    x, y, z = a[i, 0] - b[j, 0], a[i, 1] - b[j, 1], a[i, 2] - b[j, 2]
    return most < 0.0 or x * x + y * y + z * z > most * most


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _pair(c1, c2, p, crowd1, crowd2, a, b, u, v, space):  # type: ignore[no-untyped-def]
    """Least I of segments a and b with its spheres; (u, v) is any pair of theirs, the more promising the better."""
    hubs1, hubs2, around1, around2, near1, near2 = space
    x, y, z = c1[p, u, 0] - c2[p, v, 0], c1[p, u, 1] - c2[p, v, 1], c1[p, u, 2] - c2[p, v, 2]
    best, first, second = math.sqrt(x * x + y * y + z * z) - (crowd1.radius[u] + crowd2.radius[v]), 0, 0
    for d in range(crowd2.start[b], crowd2.start[b + 1]):
        if not _beyond(around1, a, hubs2, d, best + crowd1.big[a] + crowd2.reach[d]):
            near2[second] = d
            second += 1
    lead, follow, promise = -1, -1, np.inf
    for c in range(crowd1.start[a], crowd1.start[a + 1]):
        if _beyond(hubs1, c, around2, b, best + crowd1.reach[c] + crowd2.big[b]):
            continue
        near1[first] = c
        first += 1
        for k in range(second):
            d = near2[k]
            x, y, z = hubs1[c, 0] - hubs2[d, 0], hubs1[c, 1] - hubs2[d, 1], hubs1[c, 2] - hubs2[d, 2]
            square = x * x + y * y + z * z - (crowd1.reach[c] + crowd2.reach[d]) ** 2
            if square < promise:
                lead, follow, promise = c, d, square
    if lead >= 0:
        best, u, v = _nearer(c1, c2, p, crowd1, crowd2, lead, hubs2, follow, best, u, v)
    for i in range(first):
        c = near1[i]
        if _beyond(hubs1, c, around2, b, best + crowd1.reach[c] + crowd2.big[b]):
            continue
        for k in range(second):
            d = near2[k]
            if c == lead and d == follow:
                continue
            if not _beyond(hubs1, c, hubs2, d, best + crowd1.reach[c] + crowd2.reach[d]):
                best, u, v = _nearer(c1, c2, p, crowd1, crowd2, c, hubs2, d, best, u, v)
    return best, u, v


@njit(cache=True, error_model="numpy", _nrt=False, nogil=True)
def pair_clearance(one, other, pairs, distance, sphere, space, begin, end):  # type: ignore[no-untyped-def]
    """Fill distance (P, M) with the least I of each segment pair and sphere (P, M, 2) with the pair that has it.

    one, other: (centres (P, S, 3), world (P, N, 3, 4), Crowd); poses begin..end. What was nearest in the pose before
    comes first; then those clusters whose balls are nearer than the least so far to the other segment's ball, and to
    each other, the nearest two of them first. space: hubs (C, 3) of both, around (N, 3) of both, near (C,) of both,
    working space.
    """
    c1, world1, crowd1 = one
    c2, world2, crowd2 = other
    for p in range(begin, end):
        _fill_hubs(c1, world1, p, crowd1, space[0], space[2])
        _fill_hubs(c2, world2, p, crowd2, space[1], space[3])
        for m in range(pairs.shape[0]):
            a, b = pairs[m, 0], pairs[m, 1]
            if crowd1.start[a] == crowd1.start[a + 1] or crowd2.start[b] == crowd2.start[b + 1]:
                continue
            u, v = crowd1.member[crowd1.first[crowd1.start[a]]], crowd2.member[crowd2.first[crowd2.start[b]]]
            if p > begin:
                u, v = sphere[p - 1, m, 0], sphere[p - 1, m, 1]
            best, u, v = _pair(c1, c2, p, crowd1, crowd2, a, b, u, v, space)
            distance[p, m] = best
            sphere[p, m, 0] = u
            sphere[p, m, 1] = v


@njit(cache=True, error_model="numpy", _nrt=False, nogil=True)
def pair_witness(one, other, pairs, sphere, found, begin, end):  # type: ignore[no-untyped-def]
    """Where each pair of spheres (P, M, 2) is nearest: point (P, M, 3) on the other's sphere, facing (P, M).

    one: (centres, world, directions (N, 6, 3)), facing is the direction of its segment's table nearest to the way to
    the other centre; other: (centres, radius). found: point and facing to fill, for the poses begin..end.
    """
    c1, world, directions = one
    c2, radius = other
    point, facing = found
    for p in range(begin, end):
        for m in range(pairs.shape[0]):
            n, u, v = pairs[m, 0], sphere[p, m, 0], sphere[p, m, 1]
            if u < 0:
                continue
            x, y, z = c2[p, v, 0] - c1[p, u, 0], c2[p, v, 1] - c1[p, u, 1], c2[p, v, 2] - c1[p, u, 2]
            far = math.sqrt(x * x + y * y + z * z)
            part = radius[v] / far if far > 1e-12 else 0.0
            point[p, m, 0], point[p, m, 1] = c2[p, v, 0] - part * x, c2[p, v, 1] - part * y
            point[p, m, 2] = c2[p, v, 2] - part * z if far > 1e-12 else c2[p, v, 2] + radius[v]
            r, s = world[p, n, 0, 0] * x + world[p, n, 1, 0] * y + world[p, n, 2, 0] * z, 0
            t = world[p, n, 0, 1] * x + world[p, n, 1, 1] * y + world[p, n, 2, 1] * z
            w, most = world[p, n, 0, 2] * x + world[p, n, 1, 2] * y + world[p, n, 2, 2] * z, -np.inf
            for d in range(directions.shape[1]):
                along = directions[n, d, 0] * r + directions[n, d, 1] * t + directions[n, d, 2] * w
                if along > most:
                    s, most = d, along
            facing[p, m] = s
