"""The nodes of grids packed by cell: the eight corners of each side by side, 16 bits a corner; and
the solids that may hold points of each cell."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.contact.kernels.cells import mark_solid
from workbench.contact.kernels.field import Field
from workbench.contact.kernels.inside import Shells
from workbench.geometry.lanes import LANES
from workbench.geometry.polygon import Faces
from workbench.model.arrays import Bools, Ints

__all__ = ["pack_cells", "scale_of", "with_solids"]

Single = NDArray[np.float32]
MANTISSA = 11
"""Bits of a code's mantissa: what it stands for is less than it should be by a 2,048th at most, and
d by half that."""

BESIDE = 2
"""Cells beside the box of a solid that are looked at too: more than its surface is widened by."""


def scale_of(square: Single) -> float:
    """The power of two that codes are to be multiplied by so that the greatest of squares (.,) has
    one."""
    return float(np.ldexp(1.0, int(np.frexp(square.max(initial=0.0))[1]) + 95))


def with_solids(field: Field, faces: Faces, shells: Shells) -> Field:
    """A field with the sets of solids that may hold points of its cells."""
    held = np.zeros(len(field.near), dtype=np.int32)
    sets: dict[tuple[tuple[int, int], ...], int] = {(): 0}
    found: list[tuple[tuple[int, int], ...]] = [()]
    for g in range(len(field.trees.root)):
        nx, ny, nz, first = field.shape[g].tolist()
        cells = held[first : first + nx * ny * nz].reshape(nx, ny, nz)
        for s in range(field.solid_start[g], field.solid_start[g + 1]):
            for sure, at in enumerate(_marked(field, faces, shells, g, s)):
                before, which = np.unique(cells[at], return_inverse=True)
                after = []
                for number in before.tolist():
                    one = (*found[number], (s, sure))
                    if one not in sets:
                        sets[one] = len(found)
                        found.append(one)
                    after.append(sets[one])
                cells[at] = np.array(after, dtype=np.int32)[which.reshape(-1)]
    members = np.array([pair for one in found for pair in one], dtype=np.int64).reshape(-1, 2)
    return field._replace(
        held=held,
        set_start=np.cumsum([0, *map(len, found)]),
        set_solid=np.ascontiguousarray(members[:, 0]),
        set_sure=np.ascontiguousarray(members[:, 1]),
    )


def _marked(
    field: Field, faces: Faces, shells: Shells, g: int, s: int
) -> Iterator[tuple[Ints, ...]]:
    """The cells of a group that the surface of a solid may run through, then those inside it: their
    indices along x, y, z."""
    per = field.grid[g, 4]
    whole = field.shape[g, :3] - 1
    span = (field.solid_span[s].reshape(2, 3) - field.grid[g, :3]) * per
    low = np.clip(np.floor(span[0]).astype(np.int64) - BESIDE, 0, whole)
    high = np.clip(np.ceil(span[1]).astype(np.int64) + BESIDE, 0, whole)
    touched, inside = (np.zeros(tuple(np.maximum(high - low, 0)), dtype=np.bool_) for _ in range(2))
    stack = np.empty(64, dtype=np.int64)
    mark_solid(touched, inside, low, faces, shells, field, g, s, stack)
    for marked in (touched, inside):
        yield tuple(at + start for at, start in zip(np.nonzero(marked), low, strict=True))


def pack_cells(field: Field, square: Single) -> None:
    """Fill field.scale and field.cell by the squares of the nodes, and have the slack hold
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
        _mark_unsure(cells[..., 0], field.held[some].reshape(nx, ny, nz) > 0)


def _codes(nodes: Single, scale: float) -> NDArray[np.uint32]:
    """Squares of distances as codes of 16 bits: five of exponent, MANTISSA below."""
    code = (nodes * np.float32(1.0 / scale)).view(np.uint32) >> np.uint32(12)
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
