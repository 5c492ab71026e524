"""Compute the planes of triangles, and find those that have none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["FacePlanes", "degenerate_faces", "face_planes", "perpendicular"]

_MIN_HEIGHT = 1e-9
"""Height [m] of a face above its longest edge below which it is degenerate: its normal is rounding
noise."""


@dataclass(frozen=True)
class FacePlanes:
    """Triangles with their planes."""

    vertices: Floats
    """(V, 3) [m]."""
    faces: Ints
    """(T, 3)."""
    vector: Floats
    """(T, 3) area vectors."""
    normal: Floats
    """(T, 3) unit normals; across the longest edge for degenerate faces."""
    area: Floats
    """(T,) [m^2]."""
    flat: Bools
    """(T,) whether a face is degenerate."""

    def only(self, kept: Bools) -> FacePlanes:
        """Return the same mesh with the faces (T,) that are kept."""
        return FacePlanes(
            self.vertices,
            self.faces[kept],
            self.vector[kept],
            self.normal[kept],
            self.area[kept],
            self.flat[kept],
        )

    def heights(self, faces: Ints, normal: Floats) -> Floats:
        """Return the heights (N, 3) [m] of the corners of faces (N,) along normals (N, 3)."""
        heights: Floats = np.einsum("nkc,nc->nk", self.vertices[self.faces[faces]], normal)
        return heights


def degenerate_faces(vertices: Floats, faces: Ints) -> Bools:
    """Return which triangles (T,) have no area: two corners coincide, or all lie on one line."""
    return face_planes(vertices, faces).flat


def face_planes(vertices: Floats, faces: Ints) -> FacePlanes:
    """Compute the planes of triangles (T, 3) over vertices (V, 3) [m]."""
    corner = vertices[faces]
    side = np.roll(corner, -1, axis=1) - corner
    vector = np.cross(side[:, 0], side[:, 1]) / 2
    length = np.sqrt(np.einsum("nkc,nkc->nk", side, side))
    area = np.sqrt(np.einsum("nc,nc->n", vector, vector))
    flat = 2 * area <= _MIN_HEIGHT * length.max(axis=1, initial=0)
    normal = vector / np.where(flat, 1, area)[:, None]
    degenerate = np.flatnonzero(flat)
    if len(degenerate):
        longest = side[degenerate, length[degenerate].argmax(axis=1)]
        normal[degenerate] = perpendicular(longest)
    return FacePlanes(vertices, faces, vector, normal, area, flat)


def perpendicular(direction: Floats) -> Floats:
    """Return some unit vector (N, 3) at right angles to each direction; z for a zero vector."""
    smallest = np.eye(3)[np.abs(direction).argmin(axis=1)]
    normal = np.cross(direction, smallest)
    length = np.linalg.norm(normal, axis=1)
    normal[length == 0] = (0, 0, 1)
    unit: Floats = normal / np.where(length == 0, 1, length)[:, None]
    return unit
