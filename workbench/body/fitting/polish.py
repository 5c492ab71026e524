"""Least-squares polish of spheres against surface samples, and the step back into the bounds.

Gauss-Newton on the field of the union, |p - c| - r of the nearest sphere: four unknowns a sphere,
solved sphere by sphere. Measured on whole bodies and parts: 10 to 30 % less mean error in four
steps, 1 % more in eight; higher powers of the error, or moving spheres elsewhere, gain less than 3
%.
"""

from __future__ import annotations

import numpy as np

from workbench.body.fitting.candidates import Limits
from workbench.body.kernels.balls import BLOCK, block_bounds, nearest_ball
from workbench.body.surface import Surface
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["polished", "polished_parts", "union_field", "within_bounds"]


def union_field(points: Floats, centre: Floats, radius: Floats) -> tuple[Floats, Ints]:
    """Field of the union (n,) [m], negative inside, and the sphere it comes from (n,); points (n,
    3), near ones together."""
    field = np.empty(len(points))
    ball = np.empty(len(points), dtype=np.int64)
    nearest_ball(points, block_bounds(points, BLOCK), centre, radius, field, ball)
    return field, ball


def polished(
    points: Floats, centre: Floats, radius: Floats, *, free: Bools, limits: Limits, steps: int = 8
) -> tuple[Floats, Floats]:
    """Spheres (m, 3), (m,) moved and resized so that the points (n, 3) lie on their union in least
    squares.

    Only the spheres `free` (m,) change; radii stay between the limits, the bounds on the surface
    are not looked at.
    """
    for _ in range(steps):
        field, ball = union_field(points, centre, radius)
        away = points - centre[ball]
        away /= np.maximum(np.linalg.norm(away, axis=1), 1e-12)[:, None]
        row = np.column_stack([away, np.ones(len(points))])
        held = np.bincount(ball, minlength=len(radius)).astype(np.float64)
        normal = np.empty((len(radius), 4, 4))
        right = np.empty((len(radius), 4))
        for a in range(4):
            right[:, a] = np.bincount(ball, row[:, a] * field, minlength=len(radius))
            for b in range(4):
                normal[:, a, b] = np.bincount(ball, row[:, a] * row[:, b], minlength=len(radius))
        normal += (0.02 * held + 1e-9)[:, None, None] * np.eye(4)
        step = np.linalg.solve(normal, right[:, :, None])[:, :, 0]
        length = np.maximum(np.linalg.norm(step[:, :3], axis=1), 1e-12)
        step *= np.minimum(1.0, 0.3 * radius / length)[:, None]
        step[~free] = 0.0
        centre = centre + step[:, :3]
        radius = np.where(free, np.clip(radius + step[:, 3], limits.least, limits.greatest), radius)
    return centre, radius


def polished_parts(
    points: Floats,
    spheres: tuple[Floats, Floats],
    *,
    free: Bools,
    limits: Limits,
    parts: list[tuple[Bools, Bools]],
) -> tuple[Floats, Floats]:
    """`polished`, part by part: which points (n,) each part must hold, and which spheres (m,) it
    holds them with."""
    centre = spheres[0].copy()
    radius = spheres[1].copy()
    for holds, mine in parts:
        if holds.any() and (mine & free).any():
            centre[mine], radius[mine] = polished(
                points[holds], centre[mine], radius[mine], free=free[mine], limits=limits
            )
    return centre, radius


def within_bounds(
    surface: Surface, moved: tuple[Floats, Floats], safe: tuple[Floats, Floats], limits: Limits
) -> tuple[Floats, Floats]:
    """The moved spheres, none out of the surface by more than limits.outward: smaller where that
    helps, else the safe ones."""
    depth = -surface.distance(moved[0])
    radius = np.minimum(moved[1], depth + limits.outward)
    back = radius < limits.least
    return np.where(back[:, None], safe[0], moved[0]), np.where(back, safe[1], radius)
