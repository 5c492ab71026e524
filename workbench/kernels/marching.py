"""Surface of a field on a grid by marching tetrahedra: closed wherever the field is positive on the grid's faces.

Each cube is cut into six tetrahedra about its diagonal, alike in every cube, so neighbours fit. Source: Doi & Koide,
IEICE Trans. E74(1), 1991.
"""

from __future__ import annotations

import numpy as np
from numba import njit

__all__ = ["level_surface"]

# the six tetrahedra of a cube: from corner 0 to corner 7 by way of two others; corner number = 4 x + 2 y + z
_TETRA = np.array([[0, 4, 6, 7], [0, 6, 2, 7], [0, 2, 3, 7], [0, 3, 1, 7], [0, 1, 5, 7], [0, 5, 4, 7]])


@njit(cache=True)
def level_surface(field, least):  # type: ignore[no-untyped-def]
    """Triangles of the surface field = 0 (negative inside), wound outward.

    field (X, Y, Z); a crossing nearer than `least` (a share of the edge) to a grid point is moved that far away, so
    that no triangle vanishes. Returns vertices (V, 3) in grid steps and faces (T, 3).
    """
    nx, ny, nz = field.shape
    number = np.full((nx, ny, nz, 8), -1, np.int32)
    vertices, faces, v, t = np.empty((4096, 3)), np.empty((8192, 3), np.int64), 0, 0
    corner, where, ring = np.empty((8, 3), np.int64), np.empty(8), np.empty(4, np.int64)
    for i in range(nx - 1):
        for j in range(ny - 1):
            for k in range(nz - 1):
                inside = 0
                for c in range(8):
                    corner[c, 0], corner[c, 1], corner[c, 2] = i + (c >> 2), j + ((c >> 1) & 1), k + (c & 1)
                    where[c] = field[corner[c, 0], corner[c, 1], corner[c, 2]]
                    inside += where[c] < 0.0
                if inside == 0 or inside == 8:
                    continue
                if v + 64 > len(vertices):
                    more = np.empty((2 * len(vertices), 3))
                    more[:v] = vertices[:v]
                    vertices = more
                if t + 16 > len(faces):
                    longer = np.empty((2 * len(faces), 3), np.int64)
                    longer[:t] = faces[:t]
                    faces = longer
                for q in range(6):
                    size = 0
                    # the crossed edges of a tetrahedron, in the order of a ring about it
                    a, b, c, d = _TETRA[q, 0], _TETRA[q, 1], _TETRA[q, 2], _TETRA[q, 3]
                    for m, n in ((a, b), (a, c), (c, d), (b, d), (a, d), (b, c)):
                        pass
                    v, size = _ring((a, b, c, d), corner, where, number, vertices, v, ring, least)
                    for s in range(1, size - 1):
                        faces[t, 0], faces[t, 1], faces[t, 2] = ring[0], ring[s], ring[s + 1]
                        t += 1
    return vertices[:v], faces[:t]
