"""Cells of a grid that the surface of a solid may run through: elsewhere a whole cell is inside or
outside."""

from __future__ import annotations

import numpy as np

from workbench.compiled import inner, njit
from workbench.geometry.polygon import RECORD

__all__ = ["mark_solids"]

HAIR = 1e-3
"""Widening of what is marked as a part of a cell's edge, more than any rounding of a point's
cell."""
ROUNDING = 1e-6
"""And as a part of the whole grid: cells are also found in single precision."""


@inner
def _mark(cells, field, g, low, high):  # type: ignore[no-untyped-def]
    """Set the cells (nx, ny, nz) of grid g that a box low..high (3,) meets."""
    nx, ny, nz = cells.shape
    per = field.grid[g, 4]
    spare = HAIR + ROUNDING * max(nx, ny, nz) + field.grid[g, 6] * per
    a = (
        (low[0] - field.grid[g, 0]) * per,
        (low[1] - field.grid[g, 1]) * per,
        (low[2] - field.grid[g, 2]) * per,
    )
    b = (
        (high[0] - field.grid[g, 0]) * per,
        (high[1] - field.grid[g, 1]) * per,
        (high[2] - field.grid[g, 2]) * per,
    )
    for i in range(max(int(np.floor(a[0] - spare)), 0), min(int(np.floor(b[0] + spare)) + 1, nx)):
        for j in range(
            max(int(np.floor(a[1] - spare)), 0), min(int(np.floor(b[1] + spare)) + 1, ny)
        ):
            for k in range(
                max(int(np.floor(a[2] - spare)), 0), min(int(np.floor(b[2] + spare)) + 1, nz)
            ):
                cells[i, j, k] = True


@njit(cache=True, nogil=True)
def mark_solids(cells, field, shells, g):  # type: ignore[no-untyped-def]
    """Set those of the cells (nx, ny, nz) of grid g, that of group g itself, that a polygon of a
    solid of the group may run through; all within the box of a solid that is not closed, since a
    winding number changes anywhere."""
    low = np.empty(3)
    high = np.empty(3)
    for s in range(field.solid_start[g], field.solid_start[g + 1]):
        if shells.closed[field.solid_part[s]] == 0:
            _mark(cells, field, g, field.solid_span[s, :3], field.solid_span[s, 3:])
            continue
        for rank in range(field.solid_rank[s, 0], field.solid_rank[s, 1]):
            low[:] = np.inf
            high[:] = -np.inf
            for e in range(field.begin[rank] + RECORD, field.begin[rank + 1], 6):
                for axis in range(3):
                    low[axis] = min(low[axis], field.record[e + axis])
                    high[axis] = max(high[axis], field.record[e + axis])
            _mark(cells, field, g, low, high)
