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
from workbench.contact.kernels.pairs import facing_side
from workbench.contact.kernels.search import foot, polygon_number, record_gap, signed_distance

__all__ = ["ClearanceTask", "Leads", "min_clearances", "near_sides"]


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
    """(Q, 3) row of the task, sphere and rank of the polygon, -1 where there is none."""
    bound: NDArray[np.float64]
    """(Q,) how near these come in this pose [m]."""


@inlined
def _bounds(b, centres, radius, shift, task, trees, leads):  # type: ignore[no-untyped-def]
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
            square = record_gap(x, y, z, trees, f, np.inf)
            leads.bound[q] = math.sqrt(square) - radius[b, s] + task.allowed[m] + 1e-9


@inlined
def _write_least(b, q, m, centres, shift, task, trees, out, leads):  # type: ignore[no-untyped-def]
    """Write which sphere and polygon are nearest, and the point; they are of row m of the task."""
    s = leads.row[q, 1]
    moves = task.row[m, 3]
    x = centres[b, s, 0] - moves * shift[b, 0]
    y = centres[b, s, 1] - moves * shift[b, 1]
    z = centres[b, s, 2] - moves * shift[b, 2]
    x, y, z = foot(x, y, z, trees, leads.row[q, 2])
    out.sphere[b, q] = s
    out.polygon[b, q] = polygon_number(trees, leads.row[q, 2])
    out.point[b, q, 0] = x + moves * shift[b, 0]
    out.point[b, q, 1] = y + moves * shift[b, 1]
    out.point[b, q, 2] = z + moves * shift[b, 2]


@inlined
def _measure_group(b, m, centres, radius, shift, task, parts, out, leads, space):  # type: ignore[no-untyped-def]
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
    better = False
    for i in range(task.first[g], task.first[g + 1]):
        s = task.sphere[i]
        x = centres[b, s, 0] - moves * shift[b, 0]
        y = centres[b, s, 1] - moves * shift[b, 1]
        z = centres[b, s, 2] - moves * shift[b, 2]
        away = math.sqrt((x - hx) ** 2 + (y - hy) ** 2 + (z - hz) ** 2)
        free = max(0.0, clear - away - 1e-9)
        most = min(out.distance[b, q], leads.bound[q]) - allowed
        signed, f, about = signed_distance(
            x, y, z, most + radius[b, s], free, parts, k, space.stack, space.gaps
        )
        signed -= radius[b, s]
        if about > free:
            hx = x
            hy = y
            hz = z
            clear = about
        if f >= 0 and signed + allowed < out.distance[b, q]:
            out.distance[b, q] = signed + allowed
            leads.row[q, 0] = m
            leads.row[q, 1] = s
            leads.row[q, 2] = f
            better = True
    if better:
        _write_least(b, q, m, centres, shift, task, parts.trees, out, leads)


@batch_loop
def min_clearances(  # type: ignore[no-untyped-def]
    centres, radius, shift, task, parts, out, leads, space, begin, end
):
    """Fill the least signed distance plus the allowed overlap, for poses begin..end.

    centres (P, S, 3), radius (P, S) [m]: the spheres of each pose; shift (P, 3) [m]: displacement
    of the parts that move. task: ClearanceTask; parts: Parts; out: Nearest, infinite before; leads:
    Leads; space: SearchSpace.
    """
    for q in range(len(leads.row)):
        leads.row[q, 0] = -1
    for b in range(begin, end):
        _bounds(b, centres, radius, shift, task, parts.trees, leads)
        for m in range(len(task.row)):
            if parts.trees.root[task.row[m, 2]] >= 0:
                _measure_group(b, m, centres, radius, shift, task, parts, out, leads, space)


@batch_loop
def near_sides(centres, world, radius, directions, distance, sphere, point, side):  # type: ignore[no-untyped-def]
    """Fill side (P, N, K) with the direction (N, 6, 3) of its segment that faces the point
    (P, N, K, 3) of each nearest sphere (P, N, K); inside a solid, that which faces away from it."""
    for p in range(sphere.shape[0]):
        for n in range(sphere.shape[1]):
            for k in range(sphere.shape[2]):
                s = sphere[p, n, k]
                if s < 0:
                    continue
                way = -1.0 if distance[p, n, k] < -radius[s] else 1.0
                u = way * (point[p, n, k, 0] - centres[p, s, 0])
                v = way * (point[p, n, k, 1] - centres[p, s, 1])
                w = way * (point[p, n, k, 2] - centres[p, s, 2])
                side[p, n, k] = facing_side(world, p, n, u, v, w, directions)
