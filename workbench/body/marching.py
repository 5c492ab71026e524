"""The surface where a field on a grid is zero, by marching tetrahedra: closed wherever the field is
positive all round.

Each cube is cut into six tetrahedra about one diagonal, alike in every cube, so that neighbours
fit. Source: Doi & Koide, IEICE Trans. E74(1), 1991.
"""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["level_surface"]

# from corner 0 to corner 7 of a cube by way of two others; corner number = 4 x + 2 y + z
_TETRAHEDRA = np.array(
    [[0, 4, 6, 7], [0, 6, 2, 7], [0, 2, 3, 7], [0, 3, 1, 7], [0, 1, 5, 7], [0, 5, 4, 7]]
)
_LEAST = 0.02
"""Share of an edge that a crossing keeps from its ends, so that no triangle vanishes."""


def level_surface(field: Floats, origin: Floats, pitch: Floats) -> tuple[Floats, Ints]:
    """Vertices (V, 3) [m] and outward faces (T, 3) of the surface field = 0 (negative inside).

    field (X, Y, Z) at origin (3,) + index * pitch (3,) [m]; it must be positive on the outer faces
    of the grid.
    """
    shape = np.array(field.shape)
    cube = np.stack(
        np.meshgrid(*[np.arange(n - 1) for n in shape], indexing="ij"), axis=-1
    ).reshape(-1, 3)
    offset = np.array([[c >> 2, (c >> 1) & 1, c & 1] for c in range(8)])
    stride = np.array([shape[1] * shape[2], shape[2], 1])
    low = cube @ stride
    flat = field.ravel()
    count = sum((flat[low + step] < 0).astype(np.int8) for step in offset @ stride)
    low = low[(count > 0) & (count < 8)]
    corner = (low[:, None] + offset @ stride)[:, _TETRAHEDRA].reshape(-1, 4)
    inside = flat[corner] < 0
    triangles = np.concatenate([_cut(corner, inside, n) for n in (1, 2, 3)])
    ends = np.sort(triangles, axis=2).reshape(-1, 2)
    edge, face = np.unique(ends[:, 0] * flat.size + ends[:, 1], return_inverse=True)
    ends = np.stack([edge // flat.size, edge % flat.size], axis=1)
    value = flat[ends]
    share = np.clip(value[:, 0] / (value[:, 0] - value[:, 1]), _LEAST, 1 - _LEAST)
    place = origin + pitch * np.stack(np.unravel_index(ends, field.shape), axis=-1)
    vertices = place[:, 0] + share[:, None] * (place[:, 1] - place[:, 0])
    faces = face.reshape(-1, 3)
    inner = np.where((value[:, 0] < 0)[:, None], place[:, 0], place[:, 1])
    return vertices, _outward(vertices, faces, inner)


def _cut(corner: Ints, inside: Bools, count: int) -> Ints:
    """(n, 3, 2) the crossed edges, three to a triangle, of the tetrahedra with `count` corners
    inside."""
    chosen = inside.sum(axis=1) == count
    order = np.argsort(~inside[chosen], axis=1, kind="stable")
    a, b, c, d = np.take_along_axis(corner[chosen], order, axis=1).T
    if count == 1:
        rings = [((a, b), (a, c), (a, d))]
    elif count == 3:
        rings = [((a, d), (b, d), (c, d))]
    else:
        rings = [((a, c), (a, d), (b, d)), ((a, c), (b, d), (b, c))]
    return np.concatenate(
        [np.stack([np.stack(edge, axis=1) for edge in ring], axis=1) for ring in rings]
    )


def _outward(vertices: Floats, faces: Ints, inner: Floats) -> Ints:
    """Faces turned so that their normals point away from the grid points inside, inner (V, 3)."""
    corner = vertices[faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    away = (corner - inner[faces]).sum(axis=1)
    turned: Ints = np.where(
        (np.einsum("tc,tc->t", normal, away) < 0)[:, None], faces[:, ::-1], faces
    )
    return turned
