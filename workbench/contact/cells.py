"""The nodes of grids packed by cell: the eight corners of each side by side, 16 bits a corner."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from workbench.contact.kernels.cells import mark_solids
from workbench.contact.kernels.field import Field
from workbench.contact.kernels.inside import Shells
from workbench.geometry.lanes import LANES

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
        nodes = square[first : first + nx * ny * nz].reshape(nx, ny, nz)
        scale = scale_of(nodes)
        code = (np.abs(nodes) * np.float32(1.0 / scale)).view(np.uint32) >> np.uint32(12)
        code[code < 1 << MANTISSA] = 0  # too small for the exponent
        field.scale[g] = scale
        # a corner's lowest bit may stand for 2^-137 where it should be nothing
        field.grid[g, 5] += 1e-6 * field.grid[g, 3] ** 2 + np.ldexp(scale, -137)
        cell = field.cell[LANES * first : LANES * (first + nx * ny * nz)].reshape(nx, ny, nz, LANES)
        for k in range(LANES):
            i = k >> 2
            j = k >> 1 & 1
            m = k & 1
            cell[: nx - 1, : ny - 1, : nz - 1, k] = code[
                i : nx - 1 + i, j : ny - 1 + j, m : nz - 1 + m
            ]
        unsure = np.zeros((nx, ny, nz), dtype=np.bool_)
        if g < len(field.root):
            mark_solids(unsure, field, shells, g)
            inside = nodes < 0
            for k in range(LANES):
                i = k >> 2
                j = k >> 1 & 1
                m = k & 1
                unsure[: nx - 1, : ny - 1, : nz - 1] |= inside[
                    i : nx - 1 + i, j : ny - 1 + j, m : nz - 1 + m
                ]
        corner = cell[..., 0]
        # the greatest odd number that is no more than the code says "perhaps", the greatest even
        # one "no"
        np.copyto(
            corner,
            np.where(unsure, np.maximum(corner, 1) - 1 | 1, corner & 0xFFFE),
            casting="unsafe",
        )
