"""What every mesh reader hands over: named parts in the file's own numbers, and what the file says
about itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["RawMesh", "RawPart", "triangulate", "weld"]


@dataclass(frozen=True, eq=False)
class RawPart:
    """A named part: vertices (V, 3), triangles (T, 3)."""

    name: str
    vertices: Floats
    faces: Ints


@dataclass(frozen=True, eq=False)
class RawMesh:
    """A mesh file as read. metres: what one file unit is in metres, None where the file does not
    say; up: the axis the file or its format says is up, forward: the same for forward, None where
    neither does; notes: sentences about what the file holds besides surfaces."""

    file: str
    format: str
    parts: tuple[RawPart, ...]
    metres: float | None = None
    up: str | None = None
    notes: tuple[str, ...] = ()
    forward: str | None = None


def weld(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Vertices of exactly equal position become one, unused ones go; faces keep their order and
    count.

    No tolerance: what lies a hair apart stays apart, and shows as open edges.
    """
    points = vertices[faces.ravel()] + 0.0  # -0.0 and 0.0 are one place
    mixed = np.zeros(len(points), dtype=np.uint64)
    for column, factor in zip(
        points.T, (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9), strict=True
    ):
        mixed = (mixed ^ column.copy().view(np.uint64)) * np.uint64(factor)
        mixed ^= mixed >> np.uint64(29)
    first, inverse = np.unique(mixed, return_index=True, return_inverse=True)[1:]
    if not np.array_equal(
        points[first[inverse]], points
    ):  # two places with one hash: sort the rows themselves
        first, inverse = np.unique(points, axis=0, return_index=True, return_inverse=True)[1:]
    order = np.argsort(first)
    rank = np.empty(len(first), dtype=np.int64)
    rank[order] = np.arange(len(first))
    return points[first[order]], rank[inverse.ravel()].reshape(-1, 3)


def triangulate(vertices: Floats, corners: Ints, counts: Ints) -> Ints:
    """Triangles (T, 3) of faces with any number of corners; `corners` holds the faces one after the
    other.

    A quadrilateral is cut along the diagonal that does not fold it; larger faces so that concave
    ones come out right.
    """
    start = np.cumsum(counts) - counts
    three = start[counts == 3][:, None] + np.arange(3)
    quads = corners[start[counts == 4][:, None] + np.arange(4)]
    cut = np.where(_folds(vertices, quads)[:, None], np.roll(quads, -1, axis=1), quads)
    pieces = [corners[three], cut[:, [0, 1, 2]], cut[:, [0, 2, 3]]]
    origin = [np.flatnonzero(counts == 3), np.flatnonzero(counts == 4), np.flatnonzero(counts == 4)]
    for face in np.flatnonzero(counts > 4):
        ring = corners[start[face] : start[face] + counts[face]]
        pieces.append(_clipped(vertices[ring], ring))
        origin.append(np.full(len(pieces[-1]), face))
    order = np.argsort(np.concatenate(origin), kind="stable")
    faces: Ints = np.concatenate(pieces)[order]
    return faces


def _folds(vertices: Floats, quads: Ints) -> Bools:
    """(n,) whether cutting from corner 0 to corner 2 makes two triangles that face opposite
    ways."""
    a, b, c, d = (vertices[quads[:, k]] for k in range(4))
    folds: Bools = (np.cross(b - a, c - a) * np.cross(c - a, d - a)).sum(axis=1) < 0
    return folds


def _clipped(points: Floats, ring: Ints) -> Ints:
    """Triangles (n - 2, 3) of one polygon (n corners), laid into the coordinate plane that it faces
    most.

    By manifold3d: exact for any polygon that does not cross itself, concave ones and those with
    holes that a double edge joins to the outline; one that crosses itself still gives n - 2
    triangles with its own edges.
    """
    if not np.isfinite(points).all():  # refused later, with the name of its part
        return np.column_stack([np.full(len(ring) - 2, ring[0]), ring[1:-1], ring[2:]])
    from manifold3d import triangulate

    around = points - points[0]
    normal = np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)
    axis = int(np.abs(normal).argmax())
    flat = np.delete(around, axis, axis=1) * (1 if (normal[axis] > 0) == (axis != 1) else -1, 1)
    clipped: Ints = ring[np.asarray(triangulate([flat]), dtype=np.int64).reshape(-1, 3)]
    return clipped
