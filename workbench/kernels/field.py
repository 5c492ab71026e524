"""Distances to groups of parts on grids of nodes: rigorous lower bounds, near polygons, and the exact search.

For any closed set d(x)^2 - |x|^2 is the least of the linear functions |p|^2 - 2 x.p, so it is concave: in a cell of
edge h the trilinear mix of the nodes' d^2 less h^2 sum t (1 - t) is never more than d(x)^2. Outside the grid, whose
box holds the whole group, d(x)^2 is at least the squared distance to the box plus d^2 at the nearest point of the box.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.kernels.inside import inside_part
from workbench.kernels.polygon import point_polygon
from workbench.kernels.tree import box_gap

__all__ = ["Field", "fill_rows", "inside_group", "near_polygon", "nearest_in", "reaches", "square_bound"]


class Field(NamedTuple):
    """G groups of parts, each with a tree over its polygons and a grid of nodes around them.

    Tree node m spans low[m]..high[m] (M, 3), with child, first, last, item, root (G,; -1 where empty) as in Faces. The
    grid of group g has shape[g] nodes of edge cell[g] from origin[g], and its node (i, j, k) is
    start[g] + (i ny + j) nz + k of: square, d^2 to the group rounded down, negative inside a solid; near, the nearest
    polygon. slack (G,) [m2] covers the rounding of coordinates. solid_part[solid_start[g]:solid_start[g + 1]] are
    the solid parts of group g.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    child: NDArray[np.int64]
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    item: NDArray[np.int64]
    root: NDArray[np.int64]
    origin: NDArray[np.float64]
    cell: NDArray[np.float64]
    shape: NDArray[np.int64]
    start: NDArray[np.int64]
    slack: NDArray[np.float64]
    square: NDArray[np.float32]
    near: NDArray[np.int32]
    solid_start: NDArray[np.int64]
    solid_part: NDArray[np.int64]


@njit(cache=True)
def square_bound(x, y, z, field, g):  # type: ignore[no-untyped-def]
    """A lower bound of the squared distance of a point to a group, and True where it surely is outside all solids."""
    h = field.cell[g]
    u, v, w = (x - field.origin[g, 0]) / h, (y - field.origin[g, 1]) / h, (z - field.origin[g, 2]) / h
    nx, ny, nz = field.shape[g, 0], field.shape[g, 1], field.shape[g, 2]
    a, b, c = min(max(u, 0.0), nx - 1.0), min(max(v, 0.0), ny - 1.0), min(max(w, 0.0), nz - 1.0)
    i, j, k = min(int(a), nx - 2), min(int(b), ny - 2), min(int(c), nz - 2)
    r, s, t = a - i, b - j, c - k
    at = field.start[g] + (i * ny + j) * nz + k
    q = field.square
    y0, y1 = at + nz, at + ny * nz
    y2 = y1 + nz
    e00 = abs(q[at]) + t * (abs(q[at + 1]) - abs(q[at]))
    e01 = abs(q[y0]) + t * (abs(q[y0 + 1]) - abs(q[y0]))
    e10 = abs(q[y1]) + t * (abs(q[y1 + 1]) - abs(q[y1]))
    e11 = abs(q[y2]) + t * (abs(q[y2 + 1]) - abs(q[y2]))
    e0, e1 = e00 + s * (e01 - e00), e10 + s * (e11 - e10)
    low = e0 + r * (e1 - e0) - h * h * (r * (1.0 - r) + s * (1.0 - s) + t * (1.0 - t))
    out = h * h * ((u - a) ** 2 + (v - b) ** 2 + (w - c) ** 2)
    low = (out + max(low, 0.0)) * (1.0 - 1e-9) - field.slack[g]
    if out > 0.0 or field.solid_start[g] == field.solid_start[g + 1]:
        return max(low, 0.0), True
    node = q[at + (ny * nz if r > 0.5 else 0) + (nz if s > 0.5 else 0) + (1 if t > 0.5 else 0)]
    r, s, t = min(r, 1.0 - r), min(s, 1.0 - s), min(t, 1.0 - t)
    return max(low, 0.0), node * (1.0 - 1e-9) - field.slack[g] > h * h * (r * r + s * s + t * t)


@njit(cache=True)
def near_polygon(x, y, z, field, g):  # type: ignore[no-untyped-def]
    """The polygon of a group that is nearest to the grid's node at a point."""
    h = field.cell[g]
    nx, ny, nz = field.shape[g, 0], field.shape[g, 1], field.shape[g, 2]
    i = int(min(max((x - field.origin[g, 0]) / h, 0.0), nx - 1.0) + 0.5)
    j = int(min(max((y - field.origin[g, 1]) / h, 0.0), ny - 1.0) + 0.5)
    k = int(min(max((z - field.origin[g, 2]) / h, 0.0), nz - 1.0) + 0.5)
    return field.near[field.start[g] + (i * ny + j) * nz + k]


@njit(cache=True)
def nearest_in(x, y, z, faces, field, g, hint, limit, stack, gaps):  # type: ignore[no-untyped-def]
    """Nearest polygon of a group: squared distance and polygon, -1 where none is within sqrt(limit); hint first (-1:
    none). Equal distances go to the lower polygon, so the answer depends neither on the tree nor on the hint."""
    best, found = limit, -1
    if hint >= 0:
        gap, _, _, _ = point_polygon(x, y, z, faces, hint, best)
        if gap <= best:
            best, found = gap, hint
    m = field.root[g]
    stack[0], gaps[0], size = m, box_gap(x, y, z, field.low[m], field.high[m]), 1
    while size > 0:
        size -= 1
        if gaps[size] > best:
            continue
        m = stack[size]
        near = field.child[m]
        if near < 0:
            for s in range(field.first[m], field.last[m]):
                f = field.item[s]
                if f == hint:
                    continue
                gap, _, _, _ = point_polygon(x, y, z, faces, f, best)
                if gap < best or (gap == best and (found < 0 or f < found)):
                    best, found = gap, f
            continue
        far = near + 1
        a = box_gap(x, y, z, field.low[near], field.high[near])
        b = box_gap(x, y, z, field.low[far], field.high[far])
        if b < a:
            near, far, a, b = far, near, b, a
        if b <= best:
            stack[size], gaps[size] = far, b
            size += 1
        if a <= best:
            stack[size], gaps[size] = near, a
            size += 1
    return best, found


@njit(cache=True)
def reaches(x, y, z, faces, field, g, limit, stack):  # type: ignore[no-untyped-def]
    """True where a polygon of a group is nearer to a point than sqrt(limit)."""
    gap, _, _, _ = point_polygon(x, y, z, faces, near_polygon(x, y, z, field, g), limit)
    if gap < limit:
        return True
    stack[0], size = field.root[g], 1
    while size > 0:
        size -= 1
        m = stack[size]
        if box_gap(x, y, z, field.low[m], field.high[m]) >= limit:
            continue
        if field.child[m] >= 0:
            stack[size], stack[size + 1] = field.child[m], field.child[m] + 1
            size += 2
            continue
        for s in range(field.first[m], field.last[m]):
            gap, _, _, _ = point_polygon(x, y, z, faces, field.item[s], limit)
            if gap < limit:
                return True
    return False


@njit(cache=True)
def inside_group(x, y, z, faces, shells, field, g):  # type: ignore[no-untyped-def]
    """True where a point lies inside a solid of a group."""
    for s in range(field.solid_start[g], field.solid_start[g + 1]):
        if inside_part(x, y, z, faces, shells, field.solid_part[s]):
            return True
    return False


@njit(cache=True, nogil=True)
def fill_rows(faces, shells, field, g, begin, end):  # type: ignore[no-untyped-def]
    """Fill the rows begin..end of the grid of group g; a row is a line of nodes along z. Rows may fill at once."""
    ny, nz, h = field.shape[g, 1], field.shape[g, 2], field.cell[g]
    stack, gaps = np.empty(64, np.int64), np.empty(64)
    solids = field.solid_start[g + 1] > field.solid_start[g]
    for row in range(begin, end):
        x, y = field.origin[g, 0] + (row // ny) * h, field.origin[g, 1] + (row % ny) * h
        hint, sunk, free = -1, False, -1.0
        for k in range(nz):
            z = field.origin[g, 2] + k * h
            square, hint = nearest_in(x, y, z, faces, field, g, hint, np.inf, stack, gaps)
            # where no surface can lie between two nodes they are on the same side
            if solids and free <= h * (1.0 + 1e-6):
                sunk = inside_group(x, y, z, faces, shells, field, g)
            free = math.sqrt(square)
            low = np.float32(square * (1.0 - 2e-7))
            field.square[field.start[g] + row * nz + k] = -low if sunk else low
            field.near[field.start[g] + row * nz + k] = hint
