"""Least clearances of many placed bodies of one topology, of each pair that is asked for."""

from __future__ import annotations

import math

import numpy as np

from workbench.kernels.compiled import njit
from workbench.kernels.contact.inside import inside_part
from workbench.kernels.contact.polygon import point_polygon
from workbench.kernels.contact.tree import box_gap, nearest_polygon

__all__ = ["least_gaps"]


@njit(cache=True, nogil=True, forceinline=True)
def _nearest(x, y, z, r, most, faces, shells, k, free, stack):  # type: ignore[no-untyped-def]
    """Signed distance of a sphere to part k, the polygon and its point, -1 where not below `most`;
    and how far about the centre there is surely no surface. free: what is known of that before, 0
    where nothing is."""
    root = faces.root[k]
    gap = math.sqrt(box_gap(x, y, z, faces.low[root], faces.high[root]))
    if max(gap, free) > 0.0 and max(gap, free) - r >= most:
        return np.inf, -1, x, y, z, max(gap, free)
    inside = free <= 0.0 and inside_part(x, y, z, faces, shells, k, stack)
    if not inside and most + r <= 0.0:
        return np.inf, -1, x, y, z, max(gap, free)
    limit = np.inf if inside or most == np.inf else (most + r) * (most + r) * (1.0 + 1e-12)
    square, f, px, py, pz = nearest_polygon(x, y, z, faces, k, limit)
    if f < 0:
        return np.inf, -1, x, y, z, math.sqrt(limit)
    away = math.sqrt(square)
    return (-away if inside else away) - r, f, px, py, pz, 0.0 if inside else away


@njit(cache=True, nogil=True, forceinline=True)
def _bounds(b, centres, radius, shift, asked, faces, lead, bound):  # type: ignore[no-untyped-def]
    """How near body b comes at least, by the sphere and polygon that were nearest of the one
    before: bound (Q,), a hair more, so that it cuts off nothing that counts."""
    for q in range(len(bound)):
        m = lead[q, 0]
        s = lead[q, 1]
        f = lead[q, 2]
        bound[q] = np.inf
        if m >= 0:
            moves = asked[2][m, 3]
            x = centres[b, s, 0]
            y = centres[b, s, 1]
            z = centres[b, s, 2]
            x = x - moves * shift[b, 0]
            y = y - moves * shift[b, 1]
            z = z - moves * shift[b, 2]
            square = point_polygon(x, y, z, faces, f, np.inf)[0]
            bound[q] = math.sqrt(square) - radius[b, s] + asked[3][m] + 1e-9


@njit(cache=True, nogil=True)
def least_gaps(centres, radius, shift, asked, faces, shells, out, begin, end):  # type: ignore[no-untyped-def]
    """Least signed distance plus allowance, for bodies begin..end.

    centres (B, S, 3), radius (B, S); shift (B, 3): how far the parts that go along have gone.
    asked: rows: spheres, group by group; first (G + 1,): where each group begins; pairs (M, 4):
    question, group, part, 1 where the part goes along; allowed (M,): added to the pair's distance.
    out: room (B, Q), infinite before; sphere, polygon (B, Q); point (B, Q, 3): of that polygon,
    where it has gone.

    Spheres are measured only where they may be nearest: not where the one before, with no surface
    about it for so far, or the sphere that was nearest of the body before says that they are not.
    """
    rows, first, pairs, allowed = asked
    room, sphere, polygon, point = out
    stack = np.empty(64, np.int64)
    bound = np.empty(room.shape[1])
    lead = np.full((room.shape[1], 3), -1)
    for b in range(begin, end):
        _bounds(b, centres, radius, shift, asked, faces, lead, bound)
        for m in range(len(pairs)):
            q = pairs[m, 0]
            g = pairs[m, 1]
            k = pairs[m, 2]
            moves = pairs[m, 3]
            if faces.root[k] < 0:
                continue
            hx = 0.0
            hy = 0.0
            hz = 0.0
            clear = 0.0
            for i in range(first[g], first[g + 1]):
                s = rows[i]
                x = centres[b, s, 0] - moves * shift[b, 0]
                y = centres[b, s, 1] - moves * shift[b, 1]
                z = centres[b, s, 2] - moves * shift[b, 2]
                away = math.sqrt((x - hx) ** 2 + (y - hy) ** 2 + (z - hz) ** 2)
                free = max(0.0, clear - away - 1e-9)
                most = min(room[b, q], bound[q]) - allowed[m]
                signed, f, px, py, pz, about = _nearest(
                    x, y, z, radius[b, s], most, faces, shells, k, free, stack
                )
                if about > free:
                    hx = x
                    hy = y
                    hz = z
                    clear = about
                if f >= 0 and signed + allowed[m] < room[b, q]:
                    room[b, q] = signed + allowed[m]
                    sphere[b, q] = s
                    polygon[b, q] = f
                    lead[q, 0] = m
                    lead[q, 1] = s
                    lead[q, 2] = f
                    point[b, q, 0] = px + moves * shift[b, 0]
                    point[b, q, 1] = py + moves * shift[b, 1]
                    point[b, q, 2] = pz + moves * shift[b, 2]
