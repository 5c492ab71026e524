"""A mesh for a picture: fewer triangles where there are many, and the edges that are drawn.

Vertices that lie in one cell of a grid become one, their mean, and triangles that are collapsed by
that go (Rossignac and Borrel 1993, Multi-resolution 3D approximations for rendering complex
scenes). The same mesh gives the same picture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats, Ints

__all__ = ["MOST_DRAWN", "ThinMesh", "sharp_edges", "thinned"]

MOST_DRAWN = 150_000
"""Triangles of a picture that a computer without a graphics card still turns."""
SHARP = np.radians(30.0)
"""Angle [rad] between faces from which their edge is drawn."""
_FINER = 0.8
_TRIES = 40


@dataclass(frozen=True, eq=False)
class ThinMesh:
    """A mesh as it is drawn.

    Parameters
    ----------
    vertices
        (V, 3).
    faces
        (T, 3).
    source
        (T,) a face of the whole mesh that each stands for.
    edges
        (E, 2) edges that are drawn.
    """

    vertices: Floats
    faces: Ints
    source: Ints
    edges: Ints


def thinned(vertices: Floats, faces: Ints, group: Ints, *, most: int = MOST_DRAWN) -> ThinMesh:
    """Thin a mesh to a number of triangles.

    Parameters
    ----------
    vertices, faces
        (V, 3) and (T, 3).
    group
        (V,) vertices of different groups stay apart.
    most
        Triangles there are at most; a mesh with fewer stays as it is.
    """
    if len(faces) <= most:
        return ThinMesh(vertices, faces, np.arange(len(faces)), sharp_edges(vertices, faces))
    size = float(np.ptp(vertices, axis=0).max()) or 1.0
    cells = 4.0 * np.sqrt(most)
    found = _clustered(vertices, faces, group, size / cells)
    for _ in range(_TRIES):
        if len(found[1]) <= most:
            break
        cells *= _FINER
        found = _clustered(vertices, faces, group, size / cells)
    points, kept, source = found
    if len(kept) > most:  # groups that are too small to become fewer: some are not drawn
        step = np.linspace(0, len(kept) - 1, most).astype(np.int64)
        kept = kept[step]
        source = source[step]
    return ThinMesh(points, kept, source, sharp_edges(points, kept))


def _clustered(
    vertices: Floats, faces: Ints, group: Ints, cell: float
) -> tuple[Floats, Ints, Ints]:
    """Vertices and faces with one vertex a cell and group, and the face that each stands for."""
    grid = np.floor((vertices - vertices.min(axis=0)) / cell).astype(np.int64)
    wide = grid.max(axis=0) + 1
    key = ((group * wide[0] + grid[:, 0]) * wide[1] + grid[:, 1]) * wide[2] + grid[:, 2]
    _, index, count = np.unique(key, return_inverse=True, return_counts=True)
    points = np.stack(
        [np.bincount(index, vertices[:, k], len(count)) / count for k in range(3)], axis=1
    )
    own = index[faces]
    open_ = (own[:, 0] != own[:, 1]) & (own[:, 1] != own[:, 2]) & (own[:, 2] != own[:, 0])
    source = np.flatnonzero(open_)
    own = own[source]
    corners = np.sort(own, axis=1)
    order = np.lexsort((source, corners[:, 2], corners[:, 1], corners[:, 0]))
    first = np.ones(len(order), dtype=np.bool_)
    first[1:] = (corners[order][1:] != corners[order][:-1]).any(axis=1)
    keep = np.sort(order[first])
    return points, own[keep], source[keep]


def sharp_edges(vertices: Floats, faces: Ints) -> Ints:
    """Find the edges at which faces end, or meet at an angle.

    Returns
    -------
    Ints
        (E, 2) vertices.
    """
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal / np.where(length > 0.0, length, 1.0)
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    face = np.tile(np.arange(len(faces)), 3)
    ends = np.sort(ends, axis=1)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    ends = ends[order]
    face = face[order]
    edge = np.ones(len(ends), dtype=np.bool_)
    edge[1:] = (ends[1:] != ends[:-1]).any(axis=1)
    first = np.flatnonzero(edge)
    count = np.diff([*first, len(ends)])
    second = np.minimum(first + 1, len(ends) - 1)
    along = np.abs(np.einsum("ij,ij->i", normal[face[first]], normal[face[second]]))
    drawn = (count != 2) | (along < np.cos(SHARP))
    found: Ints = ends[first[drawn]]
    return found
