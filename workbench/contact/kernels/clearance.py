"""Batch loops of bodies against polygons: signed clearance of segments to parts, and lists of
contacts."""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit
from workbench.contact.kernels.inside import inside_part
from workbench.geometry.polygon import point_polygon
from workbench.geometry.tree import box_gap, nearest_polygon

__all__ = ["environment_contacts", "row_clearance"]


@njit(cache=True)
def _segment_part(centres, radius, first, last, faces, shells, part, witness, stack):  # type: ignore[no-untyped-def]
    """Least signed distance of spheres first..last to a part; writes the nearest point into witness
    (3,)."""
    root = faces.root[part]
    best = np.inf
    sphere = -1
    polygon = -1
    start = first
    promise = np.inf
    for s in range(first, last):
        gap = math.sqrt(
            box_gap(centres[s, 0], centres[s, 1], centres[s, 2], faces.low[root], faces.high[root])
        )
        if gap - radius[s] < promise:
            start = s
            promise = gap - radius[s]
    for turn in range(first - 1, last):
        s = start if turn < first else turn
        if turn == start:
            continue
        x = centres[s, 0]
        y = centres[s, 1]
        z = centres[s, 2]
        gap = math.sqrt(box_gap(x, y, z, faces.low[root], faces.high[root]))
        # a centre inside the box of a solid may be deeper than any outside
        if gap - radius[s] > best and (gap > 0.0 or faces.solid[part] == 0):
            continue
        sign = -1.0 if inside_part(x, y, z, faces, shells, part, stack) else 1.0
        reach = best + radius[s] + (1e-15 * (abs(best) + radius[s]) if best < np.inf else 0.0)
        if sign > 0.0 and reach < 0.0:
            continue
        limit = np.inf if sign < 0.0 or reach == np.inf else reach * reach * (1.0 + 1e-12)
        square, f, qx, qy, qz = nearest_polygon(x, y, z, faces, part, limit)
        if f < 0:
            continue
        signed = sign * math.sqrt(square) - radius[s]
        if signed < best or (signed == best and s < sphere):
            best = signed
            sphere = s
            polygon = f
            witness[0] = qx
            witness[1] = qy
            witness[2] = qz
    return best, sphere, polygon


@njit(cache=True)
def row_clearance(centres, radius, start, rows, faces, shells, out):  # type: ignore[no-untyped-def]
    """Signed clearance [m] of one segment to one part in one pose, for each row.

    centres (P, S, 3) [m]; rows (R, 3): pose, segment, part. out: distance (R,), sphere, polygon
    (R,), point (R, 3). A row is left as it is where the segment has no sphere or the part no
    polygon.
    """
    distance, sphere, polygon, point = out
    stack = np.empty(64, np.int64)
    for r in range(rows.shape[0]):
        p = rows[r, 0]
        n = rows[r, 1]
        k = rows[r, 2]
        if start[n] == start[n + 1] or faces.root[k] < 0:
            continue
        d, s, f = _segment_part(
            centres[p], radius, start[n], start[n + 1], faces, shells, k, point[r], stack
        )
        distance[r] = d
        sphere[r] = s
        polygon[r] = f


@njit(cache=True)
def _grow(rows, numbers):  # type: ignore[no-untyped-def]
    wide = np.empty((2 * rows.shape[0], rows.shape[1]), np.int64)
    long = np.empty((2 * len(numbers), numbers.shape[1]))
    for n in range(len(rows)):
        for i in range(rows.shape[1]):
            wide[n, i] = rows[n, i]
        for i in range(numbers.shape[1]):
            long[n, i] = numbers[n, i]
    return wide, long


@njit(cache=True, nogil=True)
def environment_contacts(centres, radius, near, faces, shells, checked, margin, begin, end):  # type: ignore[no-untyped-def]
    """All (sphere, polygon) pairs nearer than margin [m], and for a centre inside a solid its
    nearest polygon.

    Of the spheres with near (P, S) 1, in the poses begin..end.

    Returns rows (C, 4): pose, sphere, part, polygon; numbers (C, 5): signed distance, point, 1
    where inside.
    """
    rows = np.empty((256, 4), np.int64)
    numbers = np.empty((256, 5))
    used = 0
    stack = np.empty(64, np.int64)
    for p in range(begin, end):
        for s in range(centres.shape[1]):
            if near[p, s]:
                x = centres[p, s, 0]
                y = centres[p, s, 1]
                z = centres[p, s, 2]
                reach = max(radius[s] + margin, 0.0)
                for k in range(faces.root.shape[0]):
                    if checked[k] == 0 or faces.root[k] < 0:
                        continue
                    deep = -1
                    if inside_part(x, y, z, faces, shells, k, stack):
                        square, deep, qx, qy, qz = nearest_polygon(x, y, z, faces, k, np.inf)
                        if used == len(rows):
                            rows, numbers = _grow(rows, numbers)
                        rows[used, 0] = p
                        rows[used, 1] = s
                        rows[used, 2] = k
                        rows[used, 3] = deep
                        numbers[used, 0] = -math.sqrt(square) - radius[s]
                        numbers[used, 1] = qx
                        numbers[used, 2] = qy
                        numbers[used, 3] = qz
                        numbers[used, 4] = 1.0
                        used += 1
                    stack[0] = faces.root[k]
                    size = 1
                    while size > 0:
                        size -= 1
                        m = stack[size]
                        if box_gap(x, y, z, faces.low[m], faces.high[m]) > reach * reach:
                            continue
                        if faces.child[m] >= 0:
                            stack[size] = faces.child[m]
                            stack[size + 1] = faces.child[m] + 1
                            size += 2
                            continue
                        for i in range(faces.first[m], faces.last[m]):
                            f = faces.item[i]
                            square, qx, qy, qz = point_polygon(x, y, z, faces, f, reach * reach)
                            signed = math.sqrt(square) - radius[s]
                            if f == deep or not signed < margin:
                                continue
                            if used == len(rows):
                                rows, numbers = _grow(rows, numbers)
                            rows[used, 0] = p
                            rows[used, 1] = s
                            rows[used, 2] = k
                            rows[used, 3] = f
                            numbers[used, 0] = signed
                            numbers[used, 1] = qx
                            numbers[used, 2] = qy
                            numbers[used, 3] = qz
                            numbers[used, 4] = 0.0
                            used += 1
    return rows[:used], numbers[:used]
