"""Batch loops of spheres against spheres: the paper's three steps, and the least distance of segment pairs."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from workbench.kernels.groups import cluster_hub

__all__ = ["pair_clearance", "sphere_contacts"]


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
def _nearer(c1, c2, p, crowd1, crowd2, c, d, best, u, v):  # type: ignore[no-untyped-def]
    """Improve the least I and its spheres (u, v) by those of cluster c of one and d of the other; ties to the first."""
    for i in range(crowd1.first[c], crowd1.first[c + 1]):
        s = crowd1.member[i]
        x, y, z, r = c1[p, s, 0], c1[p, s, 1], c1[p, s, 2], crowd1.radius[s]
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
def _fill_hubs(centres, world, p, crowd, hubs):  # type: ignore[no-untyped-def]
    """Fill hubs (C, 3) with the clusters' hubs in the world, in pose p."""
    for n in range(len(crowd.start) - 1):
        for c in range(crowd.start[n], crowd.start[n + 1]):
            hubs[c, 0], hubs[c, 1], hubs[c, 2] = cluster_hub(centres, world, p, crowd, n, c)


@njit(cache=True, error_model="numpy", _nrt=False, nogil=True)
def pair_clearance(one, other, pairs, distance, sphere, space, begin, end):  # type: ignore[no-untyped-def]
    """Fill distance (P, M) with the least I of each segment pair and sphere (P, M, 2) with the pair that has it.

    one, other: (centres (P, S, 3), world (P, N, 3, 4), Crowd); poses begin..end. The nearest two clusters first, then
    those whose balls are nearer than the least so far. space: hubs (C, 3) of both and gaps (C, C), working space.
    """
    c1, world1, crowd1 = one
    c2, world2, crowd2 = other
    hubs1, hubs2, gaps = space
    for p in range(begin, end):
        _fill_hubs(c1, world1, p, crowd1, hubs1)
        _fill_hubs(c2, world2, p, crowd2, hubs2)
        for m in range(pairs.shape[0]):
            a, b = pairs[m, 0], pairs[m, 1]
            lead, follow, promise = -1, -1, np.inf
            for c in range(crowd1.start[a], crowd1.start[a + 1]):
                for d in range(crowd2.start[b], crowd2.start[b + 1]):
                    x, y, z = hubs1[c, 0] - hubs2[d, 0], hubs1[c, 1] - hubs2[d, 1], hubs1[c, 2] - hubs2[d, 2]
                    gap = math.sqrt(x * x + y * y + z * z) - crowd1.reach[c] - crowd2.reach[d]
                    gaps[c, d] = gap
                    if gap < promise:
                        lead, follow, promise = c, d, gap
            if lead < 0:
                continue
            best, u, v = _nearer(c1, c2, p, crowd1, crowd2, lead, follow, np.inf, -1, -1)
            for c in range(crowd1.start[a], crowd1.start[a + 1]):
                for d in range(crowd2.start[b], crowd2.start[b + 1]):
                    if gaps[c, d] <= best and (c != lead or d != follow):
                        best, u, v = _nearer(c1, c2, p, crowd1, crowd2, c, d, best, u, v)
            distance[p, m] = best
            sphere[p, m, 0] = u
            sphere[p, m, 1] = v
