"""Triangles with their planes, and which of them have none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["Faced", "degenerate_faces", "faced"]

_FLAT = 1e-9
"""A face lower than this above its longest edge [m] has no area: its normal is rounding noise."""


@dataclass(frozen=True)
class Faced:
    """Triangles with their planes: area vectors (T, 3), unit normals (T, 3), areas (T,), who is
    degenerate (T,)."""

    vertices: Floats
    faces: Ints
    vector: Floats
    normal: Floats
    area: Floats
    flat: Bools

    def only(self, kept: Bools) -> Faced:
        """The same mesh with fewer faces."""
        return Faced(
            self.vertices,
            self.faces[kept],
            self.vector[kept],
            self.normal[kept],
            self.area[kept],
            self.flat[kept],
        )

    def heights(self, faces: Ints, normal: Floats) -> Floats:
        """(n, 3) signed heights of the corners of `faces` along one normal for each [m]."""
        heights: Floats = np.einsum("nkc,nc->nk", self.vertices[self.faces[faces]], normal)
        return heights


def degenerate_faces(vertices: Floats, faces: Ints) -> Bools:
    """(T,) whether a triangle has no area: two corners in one place, or all three on one line."""
    return faced(vertices, faces).flat


def faced(vertices: Floats, faces: Ints) -> Faced:
    """The planes of triangles `faces` (T, 3) over `vertices` (V, 3) [m]."""
    corner = vertices[faces]
    side = np.roll(corner, -1, axis=1) - corner
    vector = np.cross(side[:, 0], side[:, 1]) / 2
    length = np.sqrt(np.einsum("nkc,nkc->nk", side, side))
    area = np.sqrt(np.einsum("nc,nc->n", vector, vector))
    flat = 2 * area <= _FLAT * length.max(axis=1, initial=0)
    normal = vector / np.where(flat, 1, area)[:, None]
    longest = side[np.arange(len(faces)), length.argmax(axis=1)] if len(faces) else np.zeros((0, 3))
    normal[flat] = _across(longest[flat])
    return Faced(vertices, faces, vector, normal, area, flat)


def _across(direction: Floats) -> Floats:
    """(n, 3) some unit vector at right angles to each direction; z where the direction is
    nothing."""
    smallest = np.eye(3)[np.abs(direction).argmin(axis=1)]
    normal = np.cross(direction, smallest)
    length = np.linalg.norm(normal, axis=1)
    normal[length == 0] = (0, 0, 1)
    unit: Floats = normal / np.where(length == 0, 1, length)[:, None]
    return unit
