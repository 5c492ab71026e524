"""Distances to groups of parts: rigorous lower bounds and near polygons from a grid of nodes, and
exact depths where these leave it open (by `search`).

For any closed set d(x)^2 - |x|^2 is the least of the linear functions |p|^2 - 2 x.p, so it is
concave: in a cell of edge h the trilinear mix of the nodes' d^2 less h^2 sum t (1 - t) is never
more than d(x)^2. Outside the grid, whose box holds the whole group, d(x)^2 is at least the squared
distance to the box plus d^2 at the nearest point of the box.

The loops index flat arrays with scalars and allocate nothing, so they are compiled without the run
time that counts references (`_nrt=False`): counting took two thirds of the time. They are inlined
into the batch loops by force, since a call would copy all these arrays' descriptions, 1 kB and
more, onto the stack: that took two thirds of the rest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.contact.kernels.point_in_solid import inside_part
from workbench.contact.kernels.search import Trees, nearest_in
from workbench.geometry.bvh import wider
from workbench.geometry.simd8 import LANES, codes, corners, horizontal_sum, splat8

__all__ = [
    "DistanceField",
    "depth_in",
    "fill_rows",
    "near_polygon",
    "penetration_bound",
    "penetration_depth",
    "solids_at",
    "span_bound",
    "square_bound",
    "within_distance",
]


class DistanceField(NamedTuple):
    """G groups of parts, each with a tree over its polygons and a grid of nodes around them.

    Grid g is that of group g around its own box; wide[g] is a second, coarse one around the
    environment, asked from outside that box. Node (i, j, k) of grid g is number
    shape[g, 3] + (i ny + j) nz + k. The solid parts of group g are those from solid_start[g] to
    solid_start[g + 1], each with a tree of its own.
    """

    trees: Trees
    """Of the groups, and of each solid part alone."""
    wide: NDArray[np.int64]
    """(G,) the coarse grid of each group, -1 for none."""
    grid: NDArray[np.float64]
    """(G + W, 7) origin [m], edge of a cell [m], one over it, slack [m2] for the rounding of
    coordinates, how far polygons leave their planes [m]: without that a distance is one to a set
    for sure."""
    shape: NDArray[np.int64]
    """(G + W, 4) nodes along x, y, z and the first node."""
    scale: NDArray[np.float32]
    """(G + W,) what codes are to be multiplied by [m2]."""
    cell: NDArray[np.uint16]
    """(., 8) squared distances to the group at the corners of the cell that begins at each node, as
    `codes` of 16 bits, rounded down. The lowest bit of the first is set where a solid may be in the
    cell. A cell is a quarter of a line of the cache."""
    near: NDArray[np.int32]
    """(.,) rank of the polygon nearest to each node."""
    solid_start: NDArray[np.int64]
    """(G + 1,)."""
    solid_part: NDArray[np.int64]
    """(.,) the part."""
    solid_root: NDArray[np.int64]
    """(.,) the tree of its polygons alone."""
    solid_span: NDArray[np.float64]
    """(., 6) its low and high [m]."""
    solid_rank: NDArray[np.int64]
    """(., 2) first and last of its ranks."""
    held: NDArray[np.int32]
    """(.,) number of the set of solids that may hold points of the cell that begins at each node, 0
    for none."""
    set_start: NDArray[np.int64]
    """(H + 1,) where each set begins."""
    set_solid: NDArray[np.int64]
    """(.,) the solids of each set, by their places in the arrays above."""
    set_sure: NDArray[np.int64]
    """(.,) 1 where all of the cell lies inside the solid."""


@inlined
def _beyond(x, y, z, span, m):  # type: ignore[no-untyped-def]
    """True where a point lies outside the box span[m] (low, high)."""
    return (
        min(x - span[m, 0], y - span[m, 1], z - span[m, 2]) < 0.0
        or min(span[m, 3] - x, span[m, 4] - y, span[m, 5] - z) < 0.0
    )


@inlined
def span_bound(x, y, z, field, g):  # type: ignore[no-untyped-def]
    """A lower bound of the squared distance of a point to a group by its box alone, 0 in it; only
    for one of several groups, otherwise always 0. Where it is more the point is outside all
    solids."""
    if field.wide[g] < 0:
        return 0.0
    s = field.trees.span
    u = max(max(s[g, 0] - x, x - s[g, 3]), 0.0)
    v = max(max(s[g, 1] - y, y - s[g, 4]), 0.0)
    w = max(max(s[g, 2] - z, z - s[g, 5]), 0.0)
    return (u * u + v * v + w * w) * (1.0 - 1e-9)


@inlined
def _clamped(u, nodes):  # type: ignore[no-untyped-def]
    """A coordinate in cells brought into the grid, and the cell that holds it."""
    a = min(max(u, 0.0), nodes - 1.0)
    return a, min(int(a), nodes - 2)


@inlined
def _grid_bound(x, y, z, field, g):  # type: ignore[no-untyped-def]
    """Lower bound [m2] of the squared distance by one grid, and how surely the point is outside all
    solids: 2 outside the grid, 1 outside as all of its cell is, 0 perhaps not.

    With the point at (r, s, t) of a cell of edge h the bound is the mix of the corners' squares
    less h^2 (r (1 - r) + s (1 - s) + t (1 - t)), and outside the grid the squared distance to it
    more. The mix in single precision is off by less than 1e-6 of the greatest corner: so much of a
    cell's own size stands in the slack.
    """
    h = field.grid[g, 3]
    per = field.grid[g, 4]
    u = (x - field.grid[g, 0]) * per
    v = (y - field.grid[g, 1]) * per
    w = (z - field.grid[g, 2]) * per
    ny = field.shape[g, 1]
    nz = field.shape[g, 2]
    a, i = _clamped(u, field.shape[g, 0])
    b, j = _clamped(v, ny)
    c, k = _clamped(w, nz)
    r = a - i
    s = b - j
    t = c - k
    at = np.uint64(LANES) * np.uint64(field.shape[g, 3] + (i * ny + j) * nz + k)
    weights = corners(np.float32(r), np.float32(s), np.float32(t))
    mix = horizontal_sum(weights * codes(field.cell, at) * splat8(field.scale[g]))
    low = mix * (1.0 - 4e-6) - h * h * (r * (1.0 - r) + s * (1.0 - s) + t * (1.0 - t))
    du = u - a
    dv = v - b
    dw = w - c
    out = h * h * (du * du + dv * dv + dw * dw)
    low = max((out + max(low, 0.0)) * (1.0 - 1e-9) - field.grid[g, 5], 0.0)
    return low, 2 if out > 0.0 else 1 - (field.cell[at] & 1)


@inlined
def solids_at(x, y, z, field, g):  # type: ignore[no-untyped-def]
    """The set of solids that may hold a point: where it begins and ends."""
    per = field.grid[g, 4]
    ny = field.shape[g, 1]
    nz = field.shape[g, 2]
    i = _clamped((x - field.grid[g, 0]) * per, field.shape[g, 0])[1]
    j = _clamped((y - field.grid[g, 1]) * per, ny)[1]
    k = _clamped((z - field.grid[g, 2]) * per, nz)[1]
    n = field.held[field.shape[g, 3] + (i * ny + j) * nz + k]
    return field.set_start[n], field.set_start[n + 1]


@inlined
def square_bound(x, y, z, field, g):  # type: ignore[no-untyped-def]
    """A lower bound of the squared distance of a point to a group, and True where it surely is
    outside all solids."""
    low, sure = _grid_bound(x, y, z, field, g)
    if sure == 2 and field.wide[g] >= 0:
        low = max(low, _grid_bound(x, y, z, field, field.wide[g])[0])
    if sure == 0:
        sure = 1
        first, last = solids_at(x, y, z, field, g)
        for m in range(first, last):
            if field.set_sure[m] or not _beyond(x, y, z, field.solid_span, field.set_solid[m]):
                sure = 0
    return low, sure > 0


@inlined
def near_polygon(x, y, z, field, g):  # type: ignore[no-untyped-def]
    """The rank of the polygon of a group that is nearest to the grid's node at a point."""
    per = field.grid[g, 4]
    if field.wide[g] >= 0:
        u = x - field.grid[g, 0]
        v = y - field.grid[g, 1]
        w = z - field.grid[g, 2]
        h = field.grid[g, 3]
        if (
            min(u, v, w) < 0.0
            or u > field.shape[g, 0] * h
            or v > field.shape[g, 1] * h
            or w > field.shape[g, 2] * h
        ):
            g = field.wide[g]
            per = field.grid[g, 4]
    nx = field.shape[g, 0]
    ny = field.shape[g, 1]
    nz = field.shape[g, 2]
    i = int(min(max((x - field.grid[g, 0]) * per, 0.0), nx - 1.0) + 0.5)
    j = int(min(max((y - field.grid[g, 1]) * per, 0.0), ny - 1.0) + 0.5)
    k = int(min(max((z - field.grid[g, 2]) * per, 0.0), nz - 1.0) + 0.5)
    return np.int64(field.near[field.shape[g, 3] + (i * ny + j) * nz + k])


@inlined
def within_distance(x, y, z, r, field, g, allowed, stack, gaps):  # type: ignore[no-untyped-def]
    """True where a sphere of radius r overlaps a polygon of a group by more than allowed, which is
    less than r."""
    limit = wider((r - allowed) * (r - allowed))
    hint = near_polygon(x, y, z, field, g)
    square, f = nearest_in(x, y, z, field.trees, field.trees.root[g], hint, limit, stack, gaps)
    return f >= 0 and r - math.sqrt(square) > allowed


@inlined
def depth_in(x, y, z, faces, shells, field, m, near, stack, gaps):  # type: ignore[no-untyped-def]
    """Depth of a point of the grid in solid m of the sets, and its polygon (rank) that is nearest; -1
    twice where the point is outside. near: as of `near_polygon`."""
    s = field.set_solid[m]
    if _beyond(x, y, z, field.solid_span, s):
        return -1.0, -1
    if not field.set_sure[m] and not inside_part(
        x, y, z, faces, shells, field.solid_part[s], stack
    ):
        return -1.0, -1
    hint = near if field.solid_rank[s, 0] <= near < field.solid_rank[s, 1] else -1
    square, f = nearest_in(x, y, z, field.trees, field.solid_root[s], hint, np.inf, stack, gaps)
    return math.sqrt(square), f


@inner
def penetration_depth(x, y, z, faces, shells, field, g, stack, gaps):  # type: ignore[no-untyped-def]
    """Depth of a point of the grid in the solids of a group and the nearest polygon (rank) of the
    one it is deepest in, or -1."""
    depth = -1.0
    rank = -1
    near = near_polygon(x, y, z, field, g)
    first, last = solids_at(x, y, z, field, g)
    for m in range(first, last):
        own, f = depth_in(x, y, z, faces, shells, field, m, near, stack, gaps)
        if own > depth:
            depth = own
            rank = f
    return depth, rank


@inlined
def penetration_bound(x, y, z, field, g, rank, way):  # type: ignore[no-untyped-def]
    """No less than the depth of a point in the solids of a group, `way` being the distance to the
    polygon of a rank."""
    first, last = solids_at(x, y, z, field, g)
    for m in range(first, last):
        s = field.set_solid[m]
        mine = field.solid_rank[s, 0] <= rank < field.solid_rank[s, 1]
        if not mine and (field.set_sure[m] or not _beyond(x, y, z, field.solid_span, s)):
            return np.inf
    return way * (1.0 + 1e-12)


@batch_loop
def fill_rows(field, square, g, group, stack, gaps, begin, end):  # type: ignore[no-untyped-def]
    """Fill the rows begin..end of grid g, of a group; a row is a line of nodes along z. Rows may
    fill at once.

    square: d^2 of each node, rounded down and less by how far polygons leave their planes. stack
    (DEEP,), gaps (DEEP + EIGHT,): working space.
    """
    ny = field.shape[g, 1]
    nz = field.shape[g, 2]
    h = field.grid[g, 3]
    for row in range(begin, end):
        x = field.grid[g, 0] + (row // ny) * h
        y = field.grid[g, 1] + (row % ny) * h
        hint = -1
        for k in range(nz):
            z = field.grid[g, 2] + k * h
            gap, hint = nearest_in(
                x, y, z, field.trees, field.trees.root[group], hint, np.inf, stack, gaps
            )
            free = math.sqrt(gap)
            low = np.float32(max(free - field.grid[g, 6], 0.0) ** 2 * (1.0 - 2e-7))
            at = field.shape[g, 3] + row * nz + k
            square[at] = low
            field.near[at] = hint
