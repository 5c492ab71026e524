"""Batch loops of bodies against groups of parts: does anything collide, and the least clearance of each segment.

Segments first, then clusters of spheres, spheres, polygons: the next only where the last cannot decide. A signed
distance changes by no more than the way moved, so what holds at the middle of a cluster bounds all its spheres.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.kernels.field import inside_group, near_polygon, nearest_in, reaches, square_bound
from workbench.kernels.inside import inside_part
from workbench.kernels.polygon import point_polygon
from workbench.kernels.tree import nearest_polygon

__all__ = ["Crowd", "group_clearance", "group_collides"]


class Crowd(NamedTuple):
    """The spheres of a body in clusters: those of segment n are start[n]:start[n + 1].

    radius (S,); cluster c has a middle sphere middle[c], reach[c] [m] from its centre to beyond every sphere of the
    cluster at every twist, and the spheres member[first[c]:first[c + 1]]. around (N, 3), big (N,): enclosing spheres
    in the segments' frames; shown (N,).
    """

    radius: NDArray[np.float64]
    start: NDArray[np.int64]
    middle: NDArray[np.int64]
    reach: NDArray[np.float64]
    first: NDArray[np.int64]
    member: NDArray[np.int64]
    around: NDArray[np.float64]
    big: NDArray[np.float64]
    shown: NDArray[np.int64]


@njit(cache=True)
def _deepest(x, y, z, faces, shells, field, g):  # type: ignore[no-untyped-def]
    """Depth of a point in the solids of a group and the nearest polygon of the one it is deepest in; -1 outside."""
    depth, polygon = -1.0, -1
    for s in range(field.solid_start[g], field.solid_start[g + 1]):
        k = field.solid_part[s]
        if inside_part(x, y, z, faces, shells, k):
            square, f, _, _, _ = nearest_polygon(x, y, z, faces, k, np.inf)
            if math.sqrt(square) > depth:
                depth, polygon = math.sqrt(square), f
    return depth, polygon


@njit(cache=True)
def _cluster(centres, crowd, c, where, best, scratch):  # type: ignore[no-untyped-def]
    """Improve best = (signed distance, sphere, polygon) of a segment to a group by the spheres of cluster c."""
    faces, shells, field, g = where
    low, stack, gaps = scratch
    a, b = crowd.first[c], crowd.first[c + 1]
    signed, sphere, polygon = best
    lead, promise = a, np.inf
    for i in range(a, b):
        s = crowd.member[i]
        x, y, z, r = centres[s, 0], centres[s, 1], centres[s, 2], crowd.radius[s]
        square, sure = square_bound(x, y, z, field, g)
        low[i] = math.sqrt(square) - r
        if not sure:
            depth, f = _deepest(x, y, z, faces, shells, field, g)
            if f >= 0:
                low[i] = np.inf
                if -depth - r < signed or (-depth - r == signed and s < sphere):
                    signed, sphere, polygon = -depth - r, s, f
        if low[i] < promise:
            lead, promise = i, low[i]
    for turn in range(a - 1, b):
        i = lead if turn < a else turn
        if turn == lead or low[i] > signed or low[i] == np.inf:
            continue
        s = crowd.member[i]
        x, y, z, r = centres[s, 0], centres[s, 1], centres[s, 2], crowd.radius[s]
        limit = (signed + r) ** 2 * (1.0 + 1e-12)
        hint = near_polygon(x, y, z, field, g)
        square, f = nearest_in(x, y, z, faces, field, g, hint, limit, stack, gaps)
        if f >= 0:
            gap = math.sqrt(square) - r
            if gap < signed or (gap == signed and s < sphere):
                signed, sphere, polygon = gap, s, f
    return signed, sphere, polygon


@njit(cache=True)
def _segment(centres, crowd, n, where, scratch, low):  # type: ignore[no-untyped-def]
    """Least signed distance of segment n to a group, with the sphere and the polygon."""
    field, g = where[2], where[3]
    a, b = crowd.start[n], crowd.start[n + 1]
    lead, promise = a, np.inf
    for c in range(a, b):
        m = crowd.middle[c]
        square, sure = square_bound(centres[m, 0], centres[m, 1], centres[m, 2], field, g)
        low[c] = math.sqrt(square) - crowd.reach[c] if sure else -np.inf
        if low[c] < promise:
            lead, promise = c, low[c]
    best = (np.inf, -1, -1)
    for turn in range(a - 1, b):
        c = lead if turn < a else turn
        if turn != lead and low[c] <= best[0]:
            best = _cluster(centres, crowd, c, where, best, scratch)
    return best


@njit(cache=True, nogil=True)
def group_clearance(centres, crowd, faces, shells, field, out):  # type: ignore[no-untyped-def]
    """Signed clearance of every segment to every group, for every pose.

    centres (P, S, 3); out: distance (P, N, G), sphere, polygon (P, N, G), point (P, N, G, 3), filled where shown.
    """
    distance, sphere, polygon, point = out
    low, scratch = np.empty(len(crowd.middle)), (np.empty(len(crowd.member)), np.empty(64, np.int64), np.empty(64))
    for p in range(centres.shape[0]):
        for n in range(len(crowd.shown)):
            if crowd.shown[n] == 0 or crowd.start[n] == crowd.start[n + 1]:
                continue
            for g in range(len(field.root)):
                if field.root[g] < 0:
                    continue
                d, s, f = _segment(centres[p], crowd, n, (faces, shells, field, g), scratch, low)
                distance[p, n, g], sphere[p, n, g], polygon[p, n, g] = d, s, f
                x, y, z = centres[p, s, 0], centres[p, s, 1], centres[p, s, 2]
                _, u, v, w = point_polygon(x, y, z, faces, f, np.inf)
                point[p, n, g, 0], point[p, n, g, 1], point[p, n, g, 2] = u, v, w


@njit(cache=True)
def _sphere_hits(x, y, z, r, where, allowed, stack):  # type: ignore[no-untyped-def]
    """True where a sphere is deeper in a group than allowed."""
    faces, shells, field, g = where
    square, sure = square_bound(x, y, z, field, g)
    if not sure and inside_group(x, y, z, faces, shells, field, g):
        return r > allowed or _deepest(x, y, z, faces, shells, field, g)[0] + r > allowed
    limit = r - allowed
    if limit <= 0.0 or square >= limit * limit:
        return False
    return reaches(x, y, z, faces, field, g, limit * limit, stack)


@njit(cache=True)
def _segment_hits(centres, crowd, n, where, allowed, stack):  # type: ignore[no-untyped-def]
    """True where a sphere of segment n is deeper in a group than allowed."""
    for c in range(crowd.start[n], crowd.start[n + 1]):
        m = crowd.middle[c]
        square, sure = square_bound(centres[m, 0], centres[m, 1], centres[m, 2], where[2], where[3])
        limit = max(crowd.reach[c] - allowed, 0.0)
        if sure and square >= limit * limit:
            continue
        for i in range(crowd.first[c], crowd.first[c + 1]):
            s = crowd.member[i]
            if _sphere_hits(centres[s, 0], centres[s, 1], centres[s, 2], crowd.radius[s], where, allowed, stack):
                return True
    return False


@njit(cache=True, nogil=True)
def group_collides(centres, world, crowd, faces, shells, field, allowed, hit):  # type: ignore[no-untyped-def]
    """Fill hit (P,): is any sphere deeper in a group than allowed (N, G) [m], tolerance included, for its segment?

    centres (P, S, 3), world (P, N, 3, 4). Segments that may collide are tried from the most promising on.
    """
    groups = len(field.root)
    key, pair, stack = np.empty(len(crowd.shown) * groups), np.empty(len(crowd.shown) * groups, np.int64), np.empty(64, np.int64)
    for p in range(centres.shape[0]):
        used = 0
        for n in range(len(crowd.shown)):
            if crowd.shown[n] == 0 or crowd.start[n] == crowd.start[n + 1]:
                continue
            t, c = world[p, n], crowd.around[n]
            x = t[0, 0] * c[0] + t[0, 1] * c[1] + t[0, 2] * c[2] + t[0, 3]
            y = t[1, 0] * c[0] + t[1, 1] * c[1] + t[1, 2] * c[2] + t[1, 3]
            z = t[2, 0] * c[0] + t[2, 1] * c[1] + t[2, 2] * c[2] + t[2, 3]
            for g in range(groups):
                if field.root[g] < 0:
                    continue
                square, sure = square_bound(x, y, z, field, g)
                limit = max(crowd.big[n] - allowed[n, g], 0.0)
                if sure and square >= limit * limit:
                    continue
                rank = math.sqrt(square) - limit
                at = used
                while at > 0 and key[at - 1] > rank:
                    key[at], pair[at] = key[at - 1], pair[at - 1]
                    at -= 1
                key[at], pair[at] = rank, n * groups + g
                used += 1
        hit[p] = False
        for i in range(used):
            n, g = pair[i] // groups, pair[i] % groups
            if _segment_hits(centres[p], crowd, n, (faces, shells, field, g), allowed[n, g], stack):
                hit[p] = True
                break
