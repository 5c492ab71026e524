"""Batch loops of bodies against polygons: signed clearance of segments to parts, and lists of
contacts."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.contact.kernels.groups import carried
from workbench.contact.kernels.inside import inside_part
from workbench.contact.kernels.pairs import facing_side
from workbench.geometry.polygon import nearest_of_record
from workbench.geometry.tree import box_gap, nearest_polygon, wider

__all__ = ["ContactRows", "environment_contacts", "near_sides", "row_clearance"]


HAIR = 1e-9
"""More [m] than the rounding of a distance between two points of the body."""


@inlined
def _least_promise(centres, radius, p, first, last, faces, root):  # type: ignore[no-untyped-def]
    """Which of the spheres first..last of pose p is nearest to the box of a part."""
    start = first
    least = np.inf
    for s in range(first, last):
        square = box_gap(
            centres[p, s, 0], centres[p, s, 1], centres[p, s, 2], faces.low, faces.high, root
        )
        gap = math.sqrt(square)
        if gap - radius[s] < least:
            start = s
            least = gap - radius[s]
    return start


@inner
def _segment_part(centres, radius, p, first, last, faces, shells, part, space):  # type: ignore[no-untyped-def]
    """Least signed distance [m] of the spheres first..last of pose p to a part, its sphere, polygon
    and point.

    The sphere nearest to the part's box is measured first: the bound that it gives leaves most of
    the others out.
    """
    root = faces.root[part]
    best = np.inf
    sphere = -1
    polygon = -1
    bx = np.nan
    by = np.nan
    bz = np.nan
    start = _least_promise(centres, radius, p, first, last, faces, root)
    for turn in range(first - 1, last):
        s = start if turn < first else turn
        if turn == start:
            continue
        x = centres[p, s, 0]
        y = centres[p, s, 1]
        z = centres[p, s, 2]
        gap = math.sqrt(box_gap(x, y, z, faces.low, faces.high, root))
        # a centre inside the box of a solid may be deeper than any outside
        if gap - radius[s] > best and (gap > 0.0 or faces.solid[part] == 0):
            continue
        sign = -1.0 if inside_part(x, y, z, faces, shells, part, space.stack) else 1.0
        reach = best + radius[s] + (1e-15 * (abs(best) + radius[s]) if best < np.inf else 0.0)
        if sign > 0.0 and reach < 0.0:
            continue
        limit = np.inf if sign < 0.0 or reach == np.inf else reach * reach * (1.0 + 1e-12)
        square, f, qx, qy, qz = nearest_polygon(x, y, z, faces, part, limit, space)
        if f < 0:
            continue
        signed = sign * math.sqrt(square) - radius[s]
        if signed < best or (signed == best and s < sphere):
            best = signed
            sphere = s
            polygon = f
            bx = qx
            by = qy
            bz = qz
    return best, sphere, polygon, bx, by, bz


@batch_loop
def row_clearance(centres, radius, start, rows, faces, shells, out, space):  # type: ignore[no-untyped-def]
    """Signed clearance [m] of one segment to one part in one pose, for each row.

    centres (P, S, 3) [m]; rows (R, 3): pose, segment, part. out: distance (R,), sphere, polygon
    (R,), point (R, 3). A row is left as it is where the segment has no sphere or the part no
    polygon. space: SearchSpace.
    """
    distance, sphere, polygon, point = out
    for r in range(len(rows)):
        n = rows[r, 1]
        k = rows[r, 2]
        if start[n] == start[n + 1] or faces.root[k] < 0:
            continue
        distance[r], sphere[r], polygon[r], point[r, 0], point[r, 1], point[r, 2] = _segment_part(
            centres, radius, rows[r, 0], start[n], start[n + 1], faces, shells, k, space
        )


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


class ContactRows(NamedTuple):
    """Room for C contacts."""

    row: NDArray[np.int64]
    """(C, 4) pose, sphere, part, polygon."""
    number: NDArray[np.float64]
    """(C, 5) signed distance [m], the polygon's nearest point [m], 1 where the centre is inside."""


@inlined
def _put(found, used, row, number):  # type: ignore[no-untyped-def]
    """Write a contact where there is room; returns how many there are then."""
    if used < len(found.row):
        for i in range(4):
            found.row[used, i] = row[i]
        for i in range(5):
            found.number[used, i] = number[i]
    return used + 1


@inner
def _near_polygons(x, y, z, r, margin, faces, where, deep, found, used, stack):  # type: ignore[no-untyped-def]
    """Put down the polygons of a part nearer than margin [m] to a sphere, but for polygon `deep`.

    where: pose, sphere, part. Returns how many contacts there are then.
    """
    p, s, k = where
    reach = max(r + margin, 0.0)
    limit = reach * reach
    stack[0] = faces.root[k]
    size = 1
    while size > 0:
        size -= 1
        m = stack[size]
        if box_gap(x, y, z, faces.low, faces.high, m) > limit:
            continue
        if faces.child[m] >= 0:
            stack[size] = faces.child[m]
            stack[size + 1] = faces.child[m] + 1
            size += 2
            continue
        for q in range(faces.first[m], faces.last[m]):
            square, qx, qy, qz = nearest_of_record(
                x, y, z, faces.record, faces.begin[q], faces.begin[q + 1], limit
            )
            signed = math.sqrt(square) - r
            f = faces.item[q]
            if f != deep and signed < margin:
                used = _put(found, used, (p, s, k, f), (signed, qx, qy, qz, 0.0))
    return used


@inner
def _segment_polygons(  # type: ignore[no-untyped-def]
    centres, radius, p, first, last, near, k, faces, shells, margin, found, used, space
):
    """Put down the polygons of part k nearer than margin [m] to the spheres first..last of pose p;
    returns how many contacts there are then.

    Around a centre outside of a solid, and in its box, the ball that holds no surface is found:
    other centres in that ball are outside too.
    """
    hub = first
    clear = -1.0
    for s in range(first, last):
        if not near[p, s]:
            continue
        x = centres[p, s, 0]
        y = centres[p, s, 1]
        z = centres[p, s, 2]
        r = radius[s]
        deep = -1
        boxed = box_gap(x, y, z, faces.low, faces.high, faces.root[k]) == 0.0
        if boxed and faces.solid[k] == 1:
            u = x - centres[p, hub, 0]
            v = y - centres[p, hub, 1]
            w = z - centres[p, hub, 2]
            if math.sqrt(u * u + v * v + w * w) >= clear:
                square, f, qx, qy, qz = nearest_polygon(x, y, z, faces, k, np.inf, space)
                if inside_part(x, y, z, faces, shells, k, space.stack):
                    deep = f
                    number = (-math.sqrt(square) - r, qx, qy, qz, 1.0)
                    used = _put(found, used, (p, s, k, f), number)
                else:
                    hub = s
                    clear = math.sqrt(square) - HAIR
        used = _near_polygons(x, y, z, r, margin, faces, (p, s, k), deep, found, used, space.stack)
    return used


@batch_loop
def environment_contacts(  # type: ignore[no-untyped-def]
    centres, world, crowd, near, faces, shells, checked, margin, found, space, begin, end
):
    """Fill found with all (sphere, polygon) pairs nearer than margin [m]; returns how many.

    Of the spheres with near (P, S) 1, in the poses begin..end, and the parts with checked (K,) 1,
    segment by segment and part by part. A centre inside a solid has a row with its nearest polygon.
    centres (P, S, 3), world (P, N, 3, 4) [m]; found: ContactRows; where there are more than it
    holds, the others are counted only. space: SearchSpace.
    """
    used = 0
    for p in range(begin, end):
        for n in range(len(crowd.shown)):
            first = crowd.first[crowd.start[n]]
            last = crowd.first[crowd.start[n + 1]]
            if crowd.shown[n] == 0 or first == last:
                continue
            x, y, z = carried(
                world, p, n, crowd.around[n, 0], crowd.around[n, 1], crowd.around[n, 2]
            )
            reach = crowd.big[n] + max(margin, 0.0)
            for k in range(len(faces.root)):
                if checked[k] == 0 or faces.root[k] < 0:
                    continue
                if box_gap(x, y, z, faces.low, faces.high, faces.root[k]) > wider(reach * reach):
                    continue
                used = _segment_polygons(
                    centres,
                    crowd.radius,
                    p,
                    first,
                    last,
                    near,
                    k,
                    faces,
                    shells,
                    margin,
                    found,
                    used,
                    space,
                )
    return used
