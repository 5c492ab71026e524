"""The nodes of grids packed by cell: the eight corners of each side by side, 16 bits a corner."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.contact.kernels.cells import mark_solids
from workbench.contact.kernels.field import Field
from workbench.contact.kernels.inside import Shells
from workbench.geometry.lanes import LANES
from workbench.model.arrays import Bools

__all__ = ["pack_cells", "scale_of"]

Single = NDArray[np.float32]
MANTISSA = 11
"""Bits of a code's mantissa: what it stands for is less than it should be by a 2,048th at most, and
d by half that."""


def scale_of(square: Single) -> float:
    """The power of two that codes are to be multiplied by so that the greatest of squares (., in
    size) has one."""
    return float(np.ldexp(1.0, int(np.frexp(np.abs(square).max(initial=0.0))[1]) + 95))


def pack_cells(field: Field, square: Single, shells: Shells) -> None:
    """Fill field.scale and field.cell by the signed squares of the nodes, and have the slack hold
    what that adds."""
    for g, (nx, ny, nz, first) in enumerate(field.shape.tolist()):
        some = slice(first, first + nx * ny * nz)
        nodes = square[some].reshape(nx, ny, nz)
        cells = field.cell.reshape(-1, LANES)[some].reshape(nx, ny, nz, LANES)
        scale = scale_of(nodes)
        field.scale[g] = scale
        # a corner's lowest bit may stand for 2^-137 where it should be nothing
        field.grid[g, 5] += 1e-6 * field.grid[g, 3] ** 2 + np.ldexp(scale, -137)
        code = _codes(nodes, scale)
        for k, corner in enumerate(_corners(code)):
            cells[:-1, :-1, :-1, k] = corner
        unsure = np.zeros((nx, ny, nz), dtype=np.bool_)
        if g < len(field.root):
            mark_solids(unsure, field, shells, g)
            for inside in _corners(nodes < 0):
                unsure[:-1, :-1, :-1] |= inside
        _mark_unsure(cells[..., 0], unsure)


def _codes(nodes: Single, scale: float) -> NDArray[np.uint32]:
    """Squares of distances, in size, as codes of 16 bits: five of exponent, MANTISSA below."""
    code = (np.abs(nodes) * np.float32(1.0 / scale)).view(np.uint32) >> np.uint32(12)
    code[code < 1 << MANTISSA] = 0  # too small for the exponent
    return code


def _corners(nodes: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Of each cell between nodes (nx, ny, nz) the values at its eight corners, corner by corner, z
    changing first."""
    nx, ny, nz = nodes.shape
    for k in range(LANES):
        i = k >> 2
        j = k >> 1 & 1
        m = k & 1
        yield nodes[i : nx - 1 + i, j : ny - 1 + j, m : nz - 1 + m]


def _mark_unsure(corner: NDArray[np.uint16], unsure: Bools) -> None:
    """Set the lowest bit of a corner's codes where a solid may be in the cell, rounding down: the
    greatest odd number that is no more than the code, else the greatest even one."""
    odd = np.maximum(corner, 1) - 1 | 1
    np.copyto(corner, np.where(unsure, odd, corner & 0xFFFE), casting="unsafe")
