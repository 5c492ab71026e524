"""Batch loops of spheres against spheres: the paper's three steps, and the least distance of segment pairs."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

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


@njit(cache=True)
def pair_clearance(one, other, pairs, distance, sphere):  # type: ignore[no-untyped-def]
    """Fill distance (P, M) with the least I of each segment pair and sphere (P, M, 2) with the pair that has it."""
    c1, r1, start1 = one[:3]
    c2, r2, start2, around2, big2 = other
    for p in range(c1.shape[0]):
        for m in range(pairs.shape[0]):
            a, b = pairs[m, 0], pairs[m, 1]
            best = np.inf
            for u in range(start1[a], start1[a + 1]):
                if not _apart(c1[p, u], around2[p, b]) - r1[u] - big2[b] < best:
                    continue
                for v in range(start2[b], start2[b + 1]):
                    gap = _apart(c1[p, u], c2[p, v]) - (r1[u] + r2[v])
                    if gap < best:
                        best = gap
                        sphere[p, m, 0], sphere[p, m, 1] = u, v
            distance[p, m] = best
