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

__all__ = ["ClearanceTask", "Leads", "LeastClearances", "min_clearances"]


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
def _bounds(b, centres, radius, shift, task, faces, leads):  # type: ignore[no-untyped-def]
    """How near body b comes at least, by the sphere and polygon that were nearest of the one
    before: leads.bound, a hair more, so that it cuts off nothing that counts."""
    for q in range(len(leads.bound)):
        m = leads.row[q, 0]
        s = leads.row[q, 1]
        f = leads.row[q, 2]
        leads.bound[q] = np.inf
        if m >= 0:
            moves = task.row[m, 3]
            x = centres[b, s, 0]
            y = centres[b, s, 1]
            z = centres[b, s, 2]
            x = x - moves * shift[b, 0]
            y = y - moves * shift[b, 1]
            z = z - moves * shift[b, 2]
            square = point_polygon(x, y, z, faces, f, np.inf)[0]
            leads.bound[q] = math.sqrt(square) - radius[b, s] + task.allowed[m] + 1e-9


class LeastClearances(NamedTuple):
    """What is filled for each pose and pair."""

    distance: NDArray[np.float64]
    """(P, Q) least signed distance plus the allowed overlap [m], infinite before."""
    sphere: NDArray[np.int64]
    """(P, Q) the nearest sphere."""
    polygon: NDArray[np.int64]
    """(P, Q) the nearest polygon."""
    point: NDArray[np.float64]
    """(P, Q, 3) the nearest point of that polygon, displaced [m]."""


@inlined
def _write_least(b, q, s, f, point, moves, shift, out):  # type: ignore[no-untyped-def]
    """Write which sphere and polygon are nearest; point: in the frame of the part."""
    out.sphere[b, q] = s
    out.polygon[b, q] = f
    for i in range(3):
        out.point[b, q, i] = point[i] + moves * shift[b, i]


@inlined
def _measure_group(b, m, centres, radius, shift, task, faces, shells, out, leads, space):  # type: ignore[no-untyped-def]
    """Measure the spheres of row m's group by its part for pose b, where they may be nearest.

    (hx, hy, hz) is the centre of the ball of radius `clear` that holds no surface, from a sphere
    before.
    """
    q = task.row[m, 0]
    g = task.row[m, 1]
    k = task.row[m, 2]
    moves = task.row[m, 3]
    allowed = task.allowed[m]
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
        most = min(out.distance[b, q], leads.bound[q]) - allowed
        signed, f, px, py, pz, about = _nearest(
            x, y, z, radius[b, s], most, faces, shells, k, free, space
        )
        if about > free:
            hx = x
            hy = y
            hz = z
            clear = about
        if f >= 0 and signed + allowed < out.distance[b, q]:
            out.distance[b, q] = signed + allowed
            _write_least(b, q, s, f, (px, py, pz), moves, shift, out)
            leads.row[q, 0] = m
            leads.row[q, 1] = s
            leads.row[q, 2] = f


@batch_loop
def min_clearances(  # type: ignore[no-untyped-def]
    centres, radius, shift, task, faces, shells, out, leads, space, begin, end
):
    """Fill the least signed distance plus the allowed overlap, for poses begin..end.

    centres (P, S, 3), radius (P, S) [m]: the spheres of each pose; shift (P, 3) [m]: displacement
    of the parts that move. task: ClearanceTask; faces, shells: the environment. out:
    LeastClearances; leads: Leads; space: SearchSpace.
    """
    for q in range(len(leads.row)):
        leads.row[q, 0] = -1
    for b in range(begin, end):
        _bounds(b, centres, radius, shift, task, faces, leads)
        for m in range(len(task.row)):
            if faces.root[task.row[m, 2]] >= 0:
                _measure_group(b, m, centres, radius, shift, task, faces, shells, out, leads, space)
