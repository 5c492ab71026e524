"""Batch loop of bodies against polygons: lists of contacts."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.contact.kernels.bounding_cylinders import cylinders_within
from workbench.contact.kernels.clearance_groups import carried, cluster_hub
from workbench.contact.kernels.search import foot, polygon_number, signed_distance, span_gap
from workbench.contact.kernels.wide_bvh import boxes_within, point_lanes
from workbench.geometry.bvh import wider
from workbench.geometry.polygon import nearest_of_record
from workbench.geometry.simd8 import lowest_set_bit

__all__ = ["ContactRows", "environment_contacts"]

HAIR = 1e-9
"""More [m] than the rounding of a distance between two points of the body."""


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
def _near_polygons(x, y, z, r, margin, trees, where, deep, found, used, space):  # type: ignore[no-untyped-def]
    """Put down the polygons of a part nearer than margin [m] to a sphere, but for polygon `deep`.

    where: pose, sphere, part. Returns how many contacts there are then.
    """
    p, s, k = where
    reach = max(r + margin, 0.0)
    limit = reach * reach
    space.stack[0] = trees.root[k]
    size = 1
    point = point_lanes(x, y, z)
    while size > 0:
        size -= 1
        m = space.stack[size]
        bits = boxes_within(point, trees.box, m, trees.many[m], limit, space.gaps)
        if bits != 0:
            bits &= cylinders_within(x, y, z, trees.head, m, limit, space.gaps)
        while bits != 0:
            c = np.int64(trees.child[m, lowest_set_bit(bits)])
            bits &= bits - np.uint64(1)
            if c >= 0:
                space.stack[size] = c
                size += 1
                continue
            begin = trees.begin[-1 - c]
            square, qx, qy, qz = nearest_of_record(
                x, y, z, trees.record, begin, trees.begin[-c], limit
            )
            signed = math.sqrt(square) - r
            f = polygon_number(trees, -1 - c)
            if f != deep and signed < margin:
                used = _put(found, used, (p, s, k, f), (signed, qx, qy, qz, 0.0))
    return used


@inlined
def _known(x, y, z, free):  # type: ignore[no-untyped-def]
    """How far [m] a point surely is from any surface by a ball (centre, radius) that holds none; no
    more than 0 where that does not say."""
    u = x - free[0]
    v = y - free[1]
    w = z - free[2]
    return max(free[3] - math.sqrt(u * u + v * v + w * w) - HAIR, 0.0)


@inner
def _segment_polygons(centres, world, p, n, crowd, k, parts, margin, found, used, space):  # type: ignore[no-untyped-def]
    """Put down the polygons of part k nearer than margin [m] to the spheres of segment n in pose p;
    returns how many contacts there are then.

    A cluster is left out where nothing comes near enough to its hub. Around a hub or a centre outside
    of a solid the ball is known that holds no surface: other centres in it are outside too.
    """
    free = 0.0, 0.0, 0.0, 0.0
    for c in range(crowd.start[n], crowd.start[n + 1]):
        x, y, z = cluster_hub(centres, world, p, crowd, n, c)
        limit = max(crowd.reach[c] + margin, 0.0) + HAIR
        known = _known(x, y, z, free)
        _, rank, about = signed_distance(x, y, z, limit, known, parts, k, space.stack, space.gaps)
        if rank < 0:
            continue
        if about > 0.0:
            free = x, y, z, about
        for i in range(crowd.first[c], crowd.first[c + 1]):
            s = crowd.member[i]
            x = centres[p, s, 0]
            y = centres[p, s, 1]
            z = centres[p, s, 2]
            r = crowd.radius[s]
            reach = max(r + margin, 0.0)
            known = max(_known(x, y, z, free), math.sqrt(span_gap(x, y, z, parts.trees.span, k)))
            if known > reach + HAIR:
                continue
            deep = -1
            if parts.faces.solid[k] == 1 and known == 0.0:
                signed, rank, about = signed_distance(
                    x, y, z, np.inf, 0.0, parts, k, space.stack, space.gaps
                )
                if math.copysign(1.0, signed) < 0.0:
                    deep = polygon_number(parts.trees, rank)
                    qx, qy, qz = foot(x, y, z, parts.trees, rank)
                    used = _put(found, used, (p, s, k, deep), (signed - r, qx, qy, qz, 1.0))
                else:
                    free = x, y, z, about
            used = _near_polygons(
                x, y, z, r, margin, parts.trees, (p, s, k), deep, found, used, space
            )
    return used


@batch_loop
def environment_contacts(  # type: ignore[no-untyped-def]
    centres, world, crowd, parts, checked, margin, found, space, begin, end
):
    """Fill found with all (sphere, polygon) pairs nearer than margin [m]; returns how many.

    Of the spheres of segments that are shown, in the poses begin..end, and the parts with checked
    (K,) 1, segment by segment and part by part. A centre inside a solid has a row with its nearest
    polygon. centres (P, S, 3), world (P, N, 3, 4) [m]; found: ContactRows; where there are more than
    it holds, the others are counted only. space: SearchSpace.
    """
    used = 0
    for p in range(begin, end):
        for n in range(len(crowd.shown)):
            if crowd.shown[n] == 0 or crowd.start[n] == crowd.start[n + 1]:
                continue
            x, y, z = carried(
                world, p, n, crowd.around[n, 0], crowd.around[n, 1], crowd.around[n, 2]
            )
            reach = crowd.big[n] + max(margin, 0.0)
            for k in range(len(parts.trees.root)):
                if checked[k] == 0 or parts.trees.root[k] < 0:
                    continue
                if span_gap(x, y, z, parts.trees.span, k) > wider(reach * reach):
                    continue
                used = _segment_polygons(
                    centres, world, p, n, crowd, k, parts, margin, found, used, space
                )
    return used
