"""Least clearance of chosen spheres and parts, for many placed people.

Each sphere is measured by the nearest polygon of a part. Three bounds leave most of them out: the
distance from the part's box, the ball about the sphere before that holds no surface, and the
distance of the pair that was nearest of the person before (which bounds, but is never the answer,
so that no answer depends on other people).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined
from workbench.contact.kernels.inside import inside_part
from workbench.geometry.polygon import point_polygon
from workbench.geometry.tree import box_gap, nearest_polygon

__all__ = ["ClearanceTask", "Leads", "min_clearances"]


class ClearanceTask(NamedTuple):
    """What is measured: groups of spheres against single parts."""

    sphere: NDArray[np.int64]
    """Spheres, group by group."""
    first: NDArray[np.int64]
    """(G + 1,) where each group begins."""
    row: NDArray[np.int64]
    """(M, 4) pair, group, part, 1 where the part is displaced."""
    allowed: NDArray[np.float64]
    """(M,) overlap [m] that is added to the distance."""


class Leads(NamedTuple):
    """What was nearest of the pose before, for each of the Q pairs: working space."""

    row: NDArray[np.int64]
    """(Q, 3) row of the task, sphere and polygon, -1 where there is none."""
    bound: NDArray[np.float64]
    """(Q,) how near these come in this pose [m]."""


@inlined
def _nearest(x, y, z, r, most, faces, shells, k, free, space):  # type: ignore[no-untyped-def]
    """Signed distance of a sphere to part k, the polygon and its point, -1 where not below `most`;
    and how far about the centre there is surely no surface. free: what is known of that before, 0
    where nothing is."""
    root = faces.root[k]
    gap = math.sqrt(box_gap(x, y, z, faces.low, faces.high, root))
    if max(gap, free) > 0.0 and max(gap, free) - r >= most:
        return np.inf, -1, x, y, z, max(gap, free)
    inside = free <= 0.0 and inside_part(x, y, z, faces, shells, k, space.stack)
    if not inside and most + r <= 0.0:
        return np.inf, -1, x, y, z, max(gap, free)
    limit = np.inf if inside or most == np.inf else (most + r) * (most + r) * (1.0 + 1e-12)
    square, f, px, py, pz = nearest_polygon(x, y, z, faces, k, limit, space)
    if f < 0:
        return np.inf, -1, x, y, z, math.sqrt(limit)
    away = math.sqrt(square)
    return (-away if inside else away) - r, f, px, py, pz, 0.0 if inside else away


@inlined
def _bounds(b, centres, radius, shift, task, faces, lead, bound):  # type: ignore[no-untyped-def]
    """How near body b comes at least, by the sphere and polygon that were nearest of the one
    before: bound (Q,), a hair more, so that it cuts off nothing that counts."""
    for q in range(len(bound)):
        m = lead[q, 0]
        s = lead[q, 1]
        f = lead[q, 2]
        bound[q] = np.inf
        if m >= 0:
            moves = task.row[m, 3]
            x = centres[b, s, 0]
            y = centres[b, s, 1]
            z = centres[b, s, 2]
            x = x - moves * shift[b, 0]
            y = y - moves * shift[b, 1]
            z = z - moves * shift[b, 2]
            square = point_polygon(x, y, z, faces, f, np.inf)[0]
            bound[q] = math.sqrt(square) - radius[b, s] + task.allowed[m] + 1e-9


@batch_loop
def min_clearances(  # type: ignore[no-untyped-def]
    centres, radius, shift, task, faces, shells, out, leads, space, begin, end
):
    """Fill the least signed distance plus the allowed overlap, for poses begin..end.

    centres (P, S, 3), radius (P, S): the spheres of each pose; shift (P, 3): displacement of the
    parts that move. task: ClearanceTask; faces, shells: the environment. out: distance (P, Q),
    infinite before; sphere, polygon (P, Q); point (P, Q, 3): of that polygon, displaced. leads:
    Leads; space: SearchSpace.
    """
    room, sphere, polygon, point = out
    bound = leads.bound
    lead = leads.row
    for q in range(len(lead)):
        lead[q, 0] = -1
    for b in range(begin, end):
        _bounds(b, centres, radius, shift, task, faces, lead, bound)
        for m in range(len(task.row)):
            q = task.row[m, 0]
            g = task.row[m, 1]
            k = task.row[m, 2]
            moves = task.row[m, 3]
            if faces.root[k] < 0:
                continue
            hx = 0.0
            hy = 0.0
            hz = 0.0
            clear = 0.0
            for i in range(task.first[g], task.first[g + 1]):
                s = task.sphere[i]
                x = centres[b, s, 0] - moves * shift[b, 0]
                y = centres[b, s, 1] - moves * shift[b, 1]
                z = centres[b, s, 2] - moves * shift[b, 2]
                away = math.sqrt((x - hx) ** 2 + (y - hy) ** 2 + (z - hz) ** 2)
                free = max(0.0, clear - away - 1e-9)
                most = min(room[b, q], bound[q]) - task.allowed[m]
                signed, f, px, py, pz, about = _nearest(
                    x, y, z, radius[b, s], most, faces, shells, k, free, space
                )
                if about > free:
                    hx = x
                    hy = y
                    hz = z
                    clear = about
                if f >= 0 and signed + task.allowed[m] < room[b, q]:
                    room[b, q] = signed + task.allowed[m]
                    sphere[b, q] = s
                    polygon[b, q] = f
                    lead[q, 0] = m
                    lead[q, 1] = s
                    lead[q, 2] = f
                    point[b, q, 0] = px + moves * shift[b, 0]
                    point[b, q, 1] = py + moves * shift[b, 1]
                    point[b, q, 2] = pz + moves * shift[b, 2]
