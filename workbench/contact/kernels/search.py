"""The index of an environment and the search that everything asks: the nearest polygon to a point.

The index is a tree of boxes over the polygons of each part, or of each group of parts. A search goes
down it depth first, the nearest child first. A branch is cut where its box or its cylinder is farther
than the nearest polygon so far, or than what is asked for.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import inlined, inner
from workbench.contact.kernels.bounding_cylinders import cylinders_within
from workbench.contact.kernels.point_in_solid import SolidMeshes, inside_part
from workbench.contact.kernels.wide_bvh import DEEP, boxes_within, point_lanes, widest
from workbench.geometry.polygon import Faces, nearest_of_record
from workbench.geometry.simd8 import lowest_set_bit

__all__ = [
    "Nearest",
    "Parts",
    "Trees",
    "foot",
    "nearest_in",
    "polygon_number",
    "record_gap",
    "signed_distance",
    "span_gap",
]


class Trees(NamedTuple):
    """The polygons of all parts, and a tree of boxes over those of each of G groups of parts."""

    record: NDArray[np.float64]
    """The polygons of all parts, as `geometry.polygon.Faces` has them."""
    begin: NDArray[np.int64]
    """(F + 1,) where the record of each rank begins."""
    box: NDArray[np.float32]
    """(M, 6, 8) low and high coordinates [m] of the boxes of each tree node's children."""
    child: NDArray[np.int32]
    """(M, 8) those children: a node, or -1 less the rank of a polygon."""
    many: NDArray[np.int64]
    """(M,) how many children a node has."""
    head: NDArray[np.float32]
    """(M, 8, 8) a cylinder around each child, for `cylinders_within`."""
    root: NDArray[np.int64]
    """(G,) the tree of each group, -1 where it is empty or hidden."""
    span: NDArray[np.float64]
    """(G, 6) low and high of each group [m]."""


class Parts(NamedTuple):
    """The K parts of an environment, each a group by itself."""

    faces: Faces
    shells: SolidMeshes
    trees: Trees
    corner: NDArray[np.float32]
    """(24 B,) vertices in blocks of eight, seen from the middle of their part's box [m]."""
    first: NDArray[np.int64]
    """(K + 1,) where the blocks of each part begin."""


class Nearest(NamedTuple):
    """What is nearest, of P poses: in each of Q pairs, or to each of N segments of each of K parts or
    groups of parts. Infinite, -1, -1 and NaN where there is nothing."""

    distance: NDArray[np.float64]
    """(P, Q) or (P, N, K) least signed distance [m]."""
    sphere: NDArray[np.int64]
    """The sphere that has it."""
    polygon: NDArray[np.int64]
    """The polygon nearest to that."""
    point: NDArray[np.float64]
    """(..., 3) the point of the polygon that is nearest [m]."""


@inlined
def record_gap(x, y, z, trees, rank, limit):  # type: ignore[no-untyped-def]
    """Squared distance [m2] of a point to the polygon of a rank, infinite beyond `limit`."""
    at = trees.begin[rank]
    return nearest_of_record(x, y, z, trees.record, at, trees.begin[rank + 1], limit)[0]


@inlined
def tied(square):  # type: ignore[no-untyped-def]
    """The greatest squared distance [m2] that counts as near as another.

    A centre nearest to an edge is as near to both of its polygons, and rounding alone would tell
    them apart. Here d counts as near as e where d^2 <= e^2 (1 + 1e-9) + 1e-16 m2: at least 3e-13 m,
    a hundred times what rounding does to places within 10 m, and at most 1e-8 m.
    """
    return square * (1.0 + 1e-9) + 1e-16


@inlined
def _before(trees, f, g):  # type: ignore[no-untyped-def]
    """True where the polygon of rank f has a lower number than that of rank g."""
    return trees.record[trees.begin[f] + 8] < trees.record[trees.begin[g] + 8]


@inlined
def nearest_in(x, y, z, trees, root, hint, limit, stack, gaps):  # type: ignore[no-untyped-def]
    """Nearest polygon under a tree node: squared distance and rank, -1 where none is within
    sqrt(limit).

    hint: a rank to try first, or -1. The distance is the least of all. Of polygons as near as that,
    by `tied`, the one with the lowest number is named: neither the tree nor the hint shows, nor how
    the environment stands.
    """
    best = limit
    found = np.int64(-1)
    if hint >= 0:
        gap = record_gap(x, y, z, trees, hint, tied(best))
        if gap <= best:
            best = gap
            found = hint
    stack[0] = root
    gaps[0] = 0.0
    size = 1
    point = point_lanes(x, y, z)
    most = widest(tied(best))
    while size > 0:
        size -= 1
        if gaps[size] > most:
            continue
        m = stack[size]
        low = size
        bits = boxes_within(point, trees.box, m, trees.many[m], tied(best), gaps)
        if bits != 0:
            bits &= cylinders_within(x, y, z, trees.head, m, tied(best), gaps)
        while bits != 0:
            k = lowest_set_bit(bits)
            bits &= bits - np.uint64(1)
            near = gaps[DEEP + k]
            if near > most:
                continue
            c = np.int64(trees.child[m, k])
            if c >= 0:
                at = size
                while at > low and gaps[at - 1] < near:  # the nearest child on top
                    stack[at] = stack[at - 1]
                    gaps[at] = gaps[at - 1]
                    at -= 1
                stack[at] = c
                gaps[at] = near
                size += 1
                continue
            f = -1 - c
            if f == hint:
                continue
            gap = record_gap(x, y, z, trees, f, tied(best))
            if gap > tied(best) or (found < 0 and gap > best):
                continue
            if found < 0 or tied(gap) < best or _before(trees, f, found):
                found = f
            if gap < best:
                best = gap
                most = widest(tied(best))
    return best, found


@inlined
def foot(x, y, z, trees, rank):  # type: ignore[no-untyped-def]
    """The point of the polygon of a rank that is nearest to a point."""
    at = trees.begin[rank]
    end = trees.begin[rank + 1]
    _, u, v, w = nearest_of_record(x, y, z, trees.record, at, end, np.inf)
    return u, v, w


@inlined
def polygon_number(trees, rank):  # type: ignore[no-untyped-def]
    """The number of the polygon of a rank."""
    return int(trees.record[trees.begin[rank] + 8])


@inlined
def span_gap(x, y, z, span, g):  # type: ignore[no-untyped-def]
    """Squared distance [m2] of a point to the box of group g, 0 inside."""
    u = max(span[g, 0] - x, 0.0, x - span[g, 3])
    v = max(span[g, 1] - y, 0.0, y - span[g, 4])
    w = max(span[g, 2] - z, 0.0, z - span[g, 5])
    return u * u + v * v + w * w


@inner
def signed_distance(x, y, z, most, free, parts, k, stack, gaps):  # type: ignore[no-untyped-def]
    """Signed distance [m] of a point to part k, negative inside a solid, and the rank of the nearest
    polygon: infinite and -1 where it is not less than `most` [m]. Then how far about the point there
    surely is no surface [m], 0 inside a solid.

    free: what is known of that before, 0 where nothing is. stack (DEEP,), gaps (DEEP + EIGHT,):
    working space.
    """
    free = max(free, math.sqrt(span_gap(x, y, z, parts.trees.span, k)))
    if free > 0.0 and free >= most:
        return np.inf, np.int64(-1), free
    inside = free == 0.0 and inside_part(x, y, z, parts.faces, parts.shells, k, stack)
    if not inside and most <= 0.0:
        return np.inf, np.int64(-1), free
    limit = np.inf if inside else most * most * (1.0 + 1e-12)
    root = parts.trees.root[k]
    square, rank = nearest_in(x, y, z, parts.trees, root, np.int64(-1), limit, stack, gaps)
    away = math.sqrt(square)
    if rank < 0:
        return np.inf, rank, away
    return (-away, rank, 0.0) if inside else (away, rank, away)
