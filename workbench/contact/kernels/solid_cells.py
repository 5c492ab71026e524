"""Cells of a grid and a solid: those that its surface may run through, and those that lie inside
as a whole."""

from __future__ import annotations

import numpy as np

from workbench.compiled import inner, njit
from workbench.contact.kernels.point_in_solid import inside_part
from workbench.geometry.polygon import EDGES, RECORD
from workbench.geometry.simd4 import FOUR

__all__ = ["mark_solid"]

HAIR = 1e-3
"""Widening of what is marked as a part of a cell's edge, more than any rounding of a point's
cell."""
ROUNDING = 1e-6
"""And as a part of the whole grid: cells are also found in single precision."""


@inner
def _mark(cells, first, field, g, low, high, plane):  # type: ignore[no-untyped-def]
    """Set those of the cells (nx, ny, nz) of grid g, from cell first (3,) on, that a box low..high
    (3,) and a plane meet.

    plane: unit normal, a point of it, and half its thickness [m]; a normal of zero for none. A cell
    with its middle at x and of half an edge e meets it where |n.(x - c)| is no more than e (|n0| +
    |n1| + |n2|) and that half.
    """
    nx, ny, nz = cells.shape
    per = field.grid[g, 4]
    most = max(field.shape[g, 0], field.shape[g, 1], field.shape[g, 2])
    spare = HAIR + ROUNDING * most + field.grid[g, 6] * per
    h = field.grid[g, 3]
    reach = (0.5 + spare) * h * (abs(plane[0]) + abs(plane[1]) + abs(plane[2])) + plane[6]
    a = (
        (low[0] - field.grid[g, 0]) * per - first[0],
        (low[1] - field.grid[g, 1]) * per - first[1],
        (low[2] - field.grid[g, 2]) * per - first[2],
    )
    b = (
        (high[0] - field.grid[g, 0]) * per - first[0],
        (high[1] - field.grid[g, 1]) * per - first[1],
        (high[2] - field.grid[g, 2]) * per - first[2],
    )
    for i in range(max(int(np.floor(a[0] - spare)), 0), min(int(np.floor(b[0] + spare)) + 1, nx)):
        u = field.grid[g, 0] + (first[0] + i + 0.5) * h - plane[3]
        for j in range(
            max(int(np.floor(a[1] - spare)), 0), min(int(np.floor(b[1] + spare)) + 1, ny)
        ):
            v = field.grid[g, 1] + (first[1] + j + 0.5) * h - plane[4]
            for k in range(
                max(int(np.floor(a[2] - spare)), 0), min(int(np.floor(b[2] + spare)) + 1, nz)
            ):
                w = field.grid[g, 2] + (first[2] + k + 0.5) * h - plane[5]
                if abs(plane[0] * u + plane[1] * v + plane[2] * w) <= reach:
                    cells[i, j, k] = True


@njit(cache=True, nogil=True)
def _mark_surface(touched, first, field, g, s):  # type: ignore[no-untyped-def]
    """Set the cells that a polygon of solid s may run through."""
    low = np.empty(3)
    high = np.empty(3)
    for rank in range(field.solid_rank[s, 0], field.solid_rank[s, 1]):
        low[:] = np.inf
        high[:] = -np.inf
        for e in range(field.trees.begin[rank] + RECORD, field.trees.begin[rank + 1], EDGES):
            for axis in range(3):
                for tail in range(e + FOUR * axis, e + FOUR * (axis + 1)):
                    low[axis] = min(low[axis], field.trees.record[tail])
                    high[axis] = max(high[axis], field.trees.record[tail])
        at = field.trees.begin[rank]
        r = field.trees.record
        plane = r[at], r[at + 1], r[at + 2], r[at + 3], r[at + 4], r[at + 5], r[at + 9]
        _mark(touched, first, field, g, low, high, plane)


@njit(cache=True, nogil=True)
def mark_solid(touched, inside, first, faces, shells, field, g, s, stack):  # type: ignore[no-untyped-def]
    """Tell the cells of a block of grid g, that of group g itself, apart by solid s.

    Parameters
    ----------
    touched, inside : (nx, ny, nz)
        Set where the surface of the solid may run through a cell, and where a cell lies inside it
        as a whole. All cells are touched where the solid is not closed, since a winding number
        changes anywhere then.
    first : (3,)
        The first cell of the block.
    faces, shells, field : Faces, Shells, Field
        The environment.
    stack : (64,)
        Working space.
    """
    if shells.closed[field.solid_part[s]] == 0:
        none = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        _mark(touched, first, field, g, field.solid_span[s, :3], field.solid_span[s, 3:], none)
        return
    _mark_surface(touched, first, field, g, s)
    h = field.grid[g, 3]
    nx, ny, nz = touched.shape
    for i in range(nx):
        x = field.grid[g, 0] + (first[0] + i + 0.5) * h
        for j in range(ny):
            y = field.grid[g, 1] + (first[1] + j + 0.5) * h
            known = False
            sunk = False
            for k in range(nz):
                if touched[i, j, k]:
                    known = False
                    continue
                if not known:  # as the cell before, where no surface lies between them
                    z = field.grid[g, 2] + (first[2] + k + 0.5) * h
                    sunk = inside_part(x, y, z, faces, shells, field.solid_part[s], stack)
                    known = True
                inside[i, j, k] = sunk
