"""The surfaces that an upright line meets: floors under feet, and what lies over them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = ["Ground", "ground_of"]

_NO_AREA = 1e-12
"""Twice the area [m2] of a triangle, as seen from above, that stands upright."""


@dataclass(frozen=True, eq=False)
class Ground:
    """Triangles that may be stood on.

    Parameters
    ----------
    corners
        (T, 3, 3) [m], z up.
    part
        (T,) index into `names`.
    names
        The parts.
    one_sided
        (T,) whether only the side that faces up can be stood on: of a solid.
    """

    corners: Floats
    part: Ints
    names: tuple[str, ...]
    one_sided: Bools

    @cached_property
    def _box(self) -> tuple[Floats, Floats]:
        """(T, 2) [m] each: the triangles as seen from above, least and greatest."""
        return self.corners[:, :, :2].min(axis=1), self.corners[:, :, :2].max(axis=1)

    def breadth(self, part: int) -> float:
        """The smaller extent [m] of a part, by its number, as seen from above; 0 of one without
        triangles."""
        corners = self.corners[self.part == part].reshape(-1, 3)[:, :2]
        return float(np.ptp(corners, axis=0).min()) if len(corners) else 0.0

    def levels(self, at: Floats) -> tuple[Floats, Ints]:
        """Return the heights (N,) [m] at which the upright line through a point (2,) meets
        triangles, ascending, and the part (N,) of each."""
        low, high = self._box
        near = np.flatnonzero(((low <= at) & (at <= high)).all(axis=1))
        corners = self.corners[near]
        a, b, c = (corners[:, k, :2] - at for k in range(3))
        # barycentric coordinates of the point in the triangles as seen from above
        u = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
        v = c[:, 0] * a[:, 1] - c[:, 1] * a[:, 0]
        w = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        area = u + v + w
        side = np.sign(area)
        inside = np.min([u * side, v * side, w * side], axis=0) >= 0
        kept = inside & (np.abs(area) > _NO_AREA) & ((area > 0) | ~self.one_sided[near])
        rows = np.flatnonzero(kept)
        weight = np.stack([u, v, w], axis=1)[rows] / area[rows, None]
        height = np.sum(weight * corners[rows, :, 2], axis=1)
        order = np.argsort(height, kind="stable")
        return height[order], self.part[near[rows]][order]


def ground_of(environment: Environment) -> Ground:
    """Return all triangles of an environment's parts that are not hidden. Of a solid, what one
    stands on is the side that faces up."""
    part = np.repeat(environment.polygon_part, np.diff(environment.triangle_start))
    shown = ~environment.hidden[part]
    corners = environment.vertices[environment.triangles[shown]]
    part = part[shown]
    return Ground(corners, part, environment.parts, environment.solid[part])
