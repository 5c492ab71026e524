"""Compute the union of a placed body's spheres as one closed surface of triangles."""

from __future__ import annotations

import math

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.model.arrays import Floats, Ints
from workbench.model.poses import Placed

__all__ = ["FLATTEST", "body_solid", "sphere_segments"]

FLATTEST = 13.5
"""Depth of a face below the surface of a unit sphere of n segments, at most, times n^2."""
_MIN_SEGMENTS = 8
_MAX_SEGMENTS = 512
"""Range of segments around a sphere."""
_GRID = 1e-3
"""Spacing [mm] of coordinates. A 32-bit coordinate of 2 m is exact to 1.2e-4 mm."""
_SHIFTS = (2e-3, 3e-3, 5e-3, 7e-3, 11e-3, 13e-3)
"""Shifts [mm] by which coincident corners are separated, one after the other."""


def body_solid(placed: Placed, pose: int = 0, *, tolerance: float = 5e-4) -> tuple[Floats, Ints]:
    """Compute the union of all spheres of one pose.

    The surface is closed and does not cross itself. Every face lies inside the spheres, by at most the
    tolerance, except for a few micrometres where folds touch. Spheres outside the logical window are
    left out.

    Parameters
    ----------
    placed, pose
        The placed body, and the number of the pose.
    tolerance
        [m], from 1e-6 to 0.1.

    Returns
    -------
    tuple of Floats and Ints
        Corners (V, 3) [m], and outward triangles (T, 3).

    Raises
    ------
    UsageError
        If the tolerance is out of its range.
    InputError
        If no sphere is placed.
    """
    import manifold3d

    if not (math.isfinite(tolerance) and 1e-6 <= tolerance <= 0.1):
        raise UsageError(
            f"solid: a tolerance of 0.001 to 100 mm is needed, got {1000 * tolerance:g} mm"
        )
    body = placed.body
    shown = placed.window[body.sphere_segment]
    centres = 1000.0 * placed.centres[pose][shown]
    radii = 1000.0 * body.radius[placed.person[pose], shown]
    if not len(radii) or not np.all(np.isfinite(centres)):
        raise InputError(
            f"body {body.name}, pose {pose}: no spheres are placed, or not at finite places"
        )
    balls = [
        manifold3d.Manifold.sphere(radius, sphere_segments(radius, 1000.0 * tolerance)).translate(
            centre
        )
        for centre, radius in zip(centres.tolist(), radii.tolist(), strict=True)
    ]
    mesh = manifold3d.Manifold.batch_boolean(balls, manifold3d.OpType.Add).to_mesh()
    points = np.array(mesh.vert_properties[:, :3], np.float64)
    triangles = np.asarray(mesh.tri_verts, np.int64)
    return _apart(points, triangles) / 1000.0, triangles


def _apart(points: Floats, triangles: Ints) -> Floats:
    """Round corners (V, 3) [mm] to a grid of micrometres, and separate those that coincide.

    The union has two corners at one place where two folds of the surface touch. A program that
    reads STL identifies corners by their coordinates. Merged, they would make an edge of four
    triangles, and the surface would not be closed. So one of them moves toward its neighbours.
    """
    points = np.round(points / _GRID) * _GRID
    for shift in _SHIFTS:
        coincident = _coincident(points)
        if not len(coincident):
            break
        for corner in coincident.tolist():
            around = triangles[np.any(triangles == corner, axis=1)].reshape(-1)
            offset = points[around].mean(axis=0) - points[corner]
            length = float(np.linalg.norm(offset))
            direction = offset / length if length > _GRID else np.array([0.0, 0.0, -1.0])
            points[corner] = np.round((points[corner] + shift * direction) / _GRID) * _GRID
    return points


def _coincident(points: Floats) -> Ints:
    """Indices of points (V, 3) that equal an earlier one in sorted order."""
    order = np.lexsort(points.T)
    gap = np.abs(points[order[1:]] - points[order[:-1]])
    return np.asarray(order[1:][np.all(gap < 0.5 * _GRID, axis=1)])


def sphere_segments(radius: float, tolerance: float) -> int:
    """Return the number of segments around a sphere, a multiple of four.

    It is enough for faces at most `tolerance` below the surface, in the unit of the radius.
    """
    wanted = 4 * math.ceil(math.sqrt(FLATTEST * radius / tolerance) / 4.0)
    return min(max(wanted, _MIN_SEGMENTS), _MAX_SEGMENTS)
