"""Sample points evenly over a surface (blue noise), with normals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.body.kernels.spacing import thin_points
from workbench.body.surface import Surface
from workbench.geometry.nearest import morton_order
from workbench.model.arrays import Floats, Ints

__all__ = ["Samples", "even_samples", "random_samples"]

_DARTS = 4.0
"""Random points for each one that is kept; 4 leave no hole wider than about 1.3 spacings (measured)."""


@dataclass(frozen=True, eq=False)
class Samples:
    """n points on a surface."""

    point: Floats
    """(n, 3) [m]."""
    normal: Floats
    """(n, 3) outward unit normals, smoothed over the faces."""
    face: Ints
    """(n,) number of the face."""

    def __len__(self) -> int:
        return len(self.face)

    def at(self, index: Ints) -> Samples:
        """Return some of the samples."""
        return Samples(self.point[index], self.normal[index], self.face[index])


def random_samples(surface: Surface, count: int, *, seed: int = 0) -> Samples:
    """Return points that are uniform over the area: one at random in each of `count` equal shares of it."""
    rng = np.random.default_rng(seed)
    corner = surface.vertices[surface.faces]
    cross = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = np.linalg.norm(cross, axis=1)
    edge = np.cumsum(area)
    at = (np.arange(count) + rng.random(count)) / count * edge[-1]
    face = np.minimum(np.searchsorted(edge, at), len(area) - 1)
    return _on_faces(surface, face, rng.random((2, count)))


def even_samples(surface: Surface, spacing: float, *, seed: int = 0) -> Samples:
    """Return points no two of which are nearer than `spacing` [m], with no room for many more.

    This is dart throwing (Poisson-disk sampling). Near points are together.
    """
    count = max(64, int(_DARTS * 0.7 * surface.area / spacing**2))
    darts = random_samples(surface, count, seed=seed)
    shuffled = darts.at(np.random.default_rng(seed + 1).permutation(count))
    kept = shuffled.at(thin_points(shuffled.point, spacing))
    return kept.at(morton_order(kept.point))


def _on_faces(surface: Surface, face: Ints, uniform: Floats) -> Samples:
    """Points at random places (2, n) of faces (n,).

    Weights (1 - sqrt u, sqrt u (1 - v), v sqrt u) are uniform over a triangle.
    """
    root = np.sqrt(uniform[0])
    weight = np.stack([1 - root, root * (1 - uniform[1]), root * uniform[1]], axis=1)
    point = np.einsum("nk,nkc->nc", weight, surface.vertices[surface.faces[face]])
    normal = np.einsum("nk,nkc->nc", weight, corner_normals(surface)[surface.faces[face]])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
    return Samples(point, normal, face)


def corner_normals(surface: Surface) -> Floats:
    """Return unit normals (V, 3) at the vertices: means over the faces, weighted by their angles there."""
    solid = surface.solid
    normal = np.zeros_like(surface.vertices)
    for k in range(3):
        normal[surface.faces[solid.face, k]] = solid.normal[:, 1 + k]
    unit: Floats = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
    return unit
