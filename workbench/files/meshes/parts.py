"""Meshes as read from a file: named parts in the file's own units, and what the file states."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats, Ints

__all__ = [
    "MAX_CORNERS",
    "MAX_INSTANCES",
    "RawMesh",
    "RawPart",
    "check_corners",
    "check_faces",
    "free_memory",
    "placed_part",
    "triangulate",
    "weld",
]


MAX_CORNERS = 10_000
"""Largest number of corners of a face. The time to triangulate one grows with their square: 2 s for
a self-crossing one of this size."""
MAX_INSTANCES = 100_000
"""Largest number of nodes or components placed: nested ones can repeat one any number of times."""
_FACE_BYTES = 1100
"""Bytes that a triangle takes until it is part of an environment (measured on meshes of a million
triangles)."""
_CORNER_BYTES = 96
"""Bytes that an unused corner takes: its coordinates, a few times over."""


def free_memory() -> int | None:
    """Return the available memory [bytes], with what caches would release; None if unknown."""
    try:
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, AttributeError):
        return None


def check_faces(path: Path, faces: int, corners: int) -> None:
    """Refuse a file that places more triangles and corners than there is memory for.

    Copies add almost nothing to the size of a file, so this is checked before they are made.
    """
    need = faces * _FACE_BYTES + corners * _CORNER_BYTES
    have = free_memory()
    if have is not None and need > have:
        raise InputError(
            f"{path}: places {faces} triangles with {corners} corners, which need up to {need / 2**30:.1f} GiB of "
            f"memory, {have / 2**30:.1f} GiB are free: simplify the mesh or split it"
        )


def check_corners(path: Path, counts: Ints) -> None:
    """Refuse faces with more corners than `MAX_CORNERS`; counts: the corners of each face."""
    most = int(counts.max(initial=0))
    if most > MAX_CORNERS:
        raise InputError(
            f"{path}: a face has {most} corners, at most {MAX_CORNERS} are read: export it as triangles"
        )


@dataclass(frozen=True, eq=False)
class RawPart:
    """A named part."""

    name: str
    vertices: Floats
    """(V, 3)."""
    faces: Ints
    """(T, 3) triangles."""


@dataclass(frozen=True, eq=False)
class RawMesh:
    """A mesh file as read."""

    file: str
    format: str
    parts: tuple[RawPart, ...]
    metres: float | None = None
    """Unit of the file [m], None if it states none."""
    up: str | None = None
    """Upward axis that the file or its format states, None if neither does."""
    notes: tuple[str, ...] = ()
    """Sentences about what the file holds besides surfaces."""
    forward: str | None = None
    """Forward axis, as `up`."""


def placed_part(name: str, vertices: Floats, faces: Ints, transform: Floats) -> RawPart:
    """Transform a part; a mirroring transform reverses the winding of its faces.

    Parameters
    ----------
    name, vertices, faces
        The part in its own frame.
    transform
        (4, 4) homogeneous transform.
    """
    linear = transform[:3, :3]
    mirrored = np.linalg.det(linear) < 0
    world = vertices @ linear.T + transform[:3, 3]
    return RawPart(name, world, faces[:, ::-1] if mirrored else faces)


_HASH_FACTORS = (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)
"""Odd 64-bit constants, one for each coordinate."""


def weld(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Merge vertices of exactly equal position, and drop unused ones.

    There is no tolerance: nearly equal positions stay apart, and show as open edges.

    Parameters
    ----------
    vertices, faces
        (V, 3) and (T, 3).

    Returns
    -------
    tuple[Floats, Ints]
        Vertices in the order of their first use, and the faces in their order.
    """
    points = vertices[faces.ravel()] + 0.0  # -0.0 and 0.0 are equal
    first, inverse = np.unique(_position_hashes(points), return_index=True, return_inverse=True)[1:]
    if not np.array_equal(points[first[inverse]], points):  # a collision: sort the rows themselves
        first, inverse = np.unique(points, axis=0, return_index=True, return_inverse=True)[1:]
    order = np.argsort(first)
    rank = np.empty(len(first), dtype=np.int64)
    rank[order] = np.arange(len(first))
    return points[first[order]], rank[inverse.ravel()].reshape(-1, 3)


def _position_hashes(points: Floats) -> NDArray[np.uint64]:
    """Return a hash (N,) of each position (N, 3); sorting these is several times as fast as sorting
    rows."""
    mixed = np.zeros(len(points), dtype=np.uint64)
    for column, factor in zip(points.T, _HASH_FACTORS, strict=True):
        mixed = (mixed ^ column.copy().view(np.uint64)) * np.uint64(factor)
        mixed ^= mixed >> np.uint64(29)
    return mixed


def triangulate(vertices: Floats, corners: Ints, counts: Ints) -> Ints:
    """Divide faces with any number of corners into triangles, in the order of the faces.

    A quadrilateral is cut along the diagonal that does not fold it. Larger faces may be concave.

    Parameters
    ----------
    vertices
        (V, 3).
    corners, counts
        Vertices of the faces one after the other, and the number of corners of each face.

    Returns
    -------
    Ints
        (T, 3).
    """
    start = np.cumsum(counts) - counts
    three = np.flatnonzero(counts == 3)
    four = np.flatnonzero(counts == 4)
    quads = corners[start[four][:, None] + np.arange(4)]
    cut = np.where(_folds(vertices, quads)[:, None], np.roll(quads, -1, axis=1), quads)
    pieces = [corners[start[three][:, None] + np.arange(3)], cut[:, [0, 1, 2]], cut[:, [0, 2, 3]]]
    owner = [three, four, four]
    for face in np.flatnonzero(counts > 4):
        ring = corners[start[face] : start[face] + counts[face]]
        pieces.append(_triangulate_polygon(vertices[ring], ring))
        owner.append(np.full(len(pieces[-1]), face))
    order = np.argsort(np.concatenate(owner), kind="stable")
    return np.concatenate(pieces)[order]


def _folds(vertices: Floats, quads: Ints) -> Bools:
    """Return which quadrilaterals (N, 4), cut from corner 0 to corner 2, would become two triangles
    that face opposite ways."""
    a, b, c, d = (vertices[quads[:, k]] for k in range(4))
    return (np.cross(b - a, c - a) * np.cross(c - a, d - a)).sum(axis=1) < 0


def _triangulate_polygon(points: Floats, ring: Ints) -> Ints:
    """Divide one polygon of n corners into n - 2 triangles, projected along its main axis.

    manifold3d is exact for any polygon that does not cross itself: concave ones, and those with
    holes that a double edge joins to the outline. One that crosses itself still gives n - 2
    triangles with its own edges.

    Parameters
    ----------
    points, ring
        (n, 3) corners, and the vertex (n,) of each.
    """
    if not np.isfinite(points).all():  # refused later, with the name of its part
        return np.column_stack([np.full(len(ring) - 2, ring[0]), ring[1:-1], ring[2:]])
    from manifold3d import triangulate

    relative = points - points[0]
    normal = np.cross(relative, np.roll(relative, -1, axis=0)).sum(axis=0)
    axis = int(np.abs(normal).argmax())
    flip = 1 if (normal[axis] > 0) == (axis != 1) else -1  # so that it runs anticlockwise
    flat = np.delete(relative, axis, axis=1) * (flip, 1)
    return ring[np.asarray(triangulate([flat]), dtype=np.int64).reshape(-1, 3)]
