"""Refine spheres by least squares against surface samples, and take them back into the bounds.

Gauss-Newton steps minimize the squared field |p - c| - r of the nearest sphere over the samples,
four unknowns for each sphere by itself. Measured on whole bodies and parts: 10 to 30 % less mean
error in four steps, and 1 % more in eight. Higher powers of the error, or moving spheres elsewhere,
gain less than 3 %.
"""

from __future__ import annotations

import numpy as np

from workbench.body.fitting.candidates import FitBounds
from workbench.body.kernels.sphere_union import BLOCK, block_bounds, nearest_ball
from workbench.body.surface import Surface
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["polished_parts", "refine_spheres", "union_field", "within_bounds"]

_DAMPING = 0.02
"""Levenberg's damping, as a share of the number of samples that a sphere holds."""
_MAX_STEP = 0.3
"""Greatest step of a centre, as a share of the radius."""


def union_field(points: Floats, centre: Floats, radius: Floats) -> tuple[Floats, Ints]:
    """Compute the field of a union of spheres, the least |p - c| - r over the spheres.

    Parameters
    ----------
    points
        (n, 3) [m], near ones together.
    centre, radius
        (m, 3) and (m,) [m].

    Returns
    -------
    tuple of Floats and Ints
        Field (n,) [m], negative inside, and the sphere (n,) that gives it.
    """
    field = np.empty(len(points))
    ball = np.empty(len(points), dtype=np.int64)
    nearest_ball(points, block_bounds(points, BLOCK), centre, radius, field, ball)
    return field, ball


def refine_spheres(
    points: Floats,
    centre: Floats,
    radius: Floats,
    *,
    free: Bools,
    limits: FitBounds,
    steps: int = 8,
) -> tuple[Floats, Floats]:
    """Move and resize spheres so that points lie on their union in the least-squares sense.

    Parameters
    ----------
    points
        (n, 3) [m].
    centre, radius
        (m, 3) and (m,) [m].
    free
        (m,) which spheres may change.
    limits
        Range of the radii. The tolerances are not considered, see `within_bounds`.
    steps
        Gauss-Newton steps.

    Returns
    -------
    tuple of Floats
        Centres (m, 3) and radii (m,) [m].
    """
    for _ in range(steps):
        step = _gauss_newton_step(points, centre, radius)
        length = np.maximum(np.linalg.norm(step[:, :3], axis=1), 1e-12)
        step *= np.minimum(1.0, _MAX_STEP * radius / length)[:, None]
        step[~free] = 0.0
        centre = centre + step[:, :3]
        radius = np.where(free, np.clip(radius + step[:, 3], limits.least, limits.greatest), radius)
    return centre, radius


def _gauss_newton_step(points: Floats, centre: Floats, radius: Floats) -> Floats:
    """(m, 4) steps of centre and radius of each sphere.

    A point p on the sphere (c, r) has the residual f = |p - c| - r and the row -(u, 1) of the
    Jacobian, with u = (p - c) / |p - c|. The normal equations are 4 by 4 for each sphere.
    """
    spheres = len(radius)
    field, ball = union_field(points, centre, radius)
    outward = points - centre[ball]
    outward /= np.maximum(np.linalg.norm(outward, axis=1), 1e-12)[:, None]
    row = np.column_stack([outward, np.ones(len(points))])
    held = np.bincount(ball, minlength=spheres).astype(np.float64)
    normal = np.empty((spheres, 4, 4))
    right = np.empty((spheres, 4))
    for a in range(4):
        right[:, a] = np.bincount(ball, row[:, a] * field, minlength=spheres)
        for b in range(4):
            normal[:, a, b] = np.bincount(ball, row[:, a] * row[:, b], minlength=spheres)
    normal += (_DAMPING * held + 1e-9)[:, None, None] * np.eye(4)
    return np.asarray(np.linalg.solve(normal, right[:, :, None])[:, :, 0])


def polished_parts(
    points: Floats,
    spheres: tuple[Floats, Floats],
    *,
    free: Bools,
    limits: FitBounds,
    parts: list[tuple[Bools, Bools]],
) -> tuple[Floats, Floats]:
    """Refine spheres part by part, see `refine_spheres`.

    Parameters
    ----------
    points
        (n, 3) [m].
    spheres
        Centres (m, 3) and radii (m,) [m].
    free
        (m,) which spheres may change.
    limits
        Range of the radii.
    parts
        For each part: the points (n,) that it must hold, and the spheres (m,) that it has.
    """
    centre = spheres[0].copy()
    radius = spheres[1].copy()
    for holds, mine in parts:
        if holds.any() and (mine & free).any():
            centre[mine], radius[mine] = refine_spheres(
                points[holds], centre[mine], radius[mine], free=free[mine], limits=limits
            )
    return centre, radius


def within_bounds(
    surface: Surface, moved: tuple[Floats, Floats], safe: tuple[Floats, Floats], limits: FitBounds
) -> tuple[Floats, Floats]:
    """Take moved spheres back into the outward tolerance: smaller if that is enough, else as they were.

    moved and safe are centres (m, 3) and radii (m,) [m] of the spheres after and before.
    """
    depth = -surface.distance(moved[0])
    radius = np.minimum(moved[1], depth + limits.outward)
    back = radius < limits.least
    return np.where(back[:, None], safe[0], moved[0]), np.where(back, safe[1], radius)
