"""The solid union of a placed body's spheres as one closed surface of triangles."""

from __future__ import annotations

import math

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.model.arrays import Floats, Ints
from workbench.model.poses import Placed

__all__ = ["FLATTEST", "body_solid", "sphere_segments"]

# of a sphere of radius 1 made of n segments a face lies at most FLATTEST / n^2 below the surface
FLATTEST = 13.5
_LEAST = 8
_MOST = 512  # segments round a sphere
_GRID = 1e-3  # [mm] a 32-bit coordinate of 2 m is true to 1.2e-4 mm
_STEPS = (2e-3, 3e-3, 5e-3, 7e-3, 11e-3, 13e-3)  # [mm]


def body_solid(placed: Placed, pose: int = 0, *, tolerance: float = 5e-4) -> tuple[Floats, Ints]:
    """Corners (V, 3) [m] and triangles (T, 3), outward, of the union of all spheres of one pose.

    Closed and without self-intersection. Every face lies inside the spheres, by at most `tolerance`
    [m] (but for a few micrometres where folds touch). Spheres outside the logical window are left
    out. InputError where no sphere is placed.
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
    """Corners [mm] on a grid of micrometres, no two at one place: those that share theirs move
    toward their neighbours.

    Where two folds of the surface touch, the union has two corners at one place. A program that
    reads STL knows corners by their coordinates only: as one they would make an edge of four
    triangles, and the surface would read as broken.
    """
    points = np.round(points / _GRID) * _GRID
    for step in _STEPS:
        order = np.lexsort(points.T)
        same = order[1:][
            np.all(np.abs(points[order[1:]] - points[order[:-1]]) < 0.5 * _GRID, axis=1)
        ]
        if not len(same):
            break
        for corner in same.tolist():
            ring = (
                points[triangles[np.any(triangles == corner, axis=1)].reshape(-1)].mean(axis=0)
                - points[corner]
            )
            away = float(np.linalg.norm(ring))
            toward = ring / away if away > _GRID else np.array([0.0, 0.0, -1.0])
            points[corner] = np.round((points[corner] + step * toward) / _GRID) * _GRID
    return points


def sphere_segments(radius: float, tolerance: float) -> int:
    """Segments, a multiple of four, round a sphere so that no face is deeper than `tolerance` (same
    unit) inside."""
    wanted = 4 * math.ceil(math.sqrt(FLATTEST * radius / tolerance) / 4.0)
    return min(max(wanted, _LEAST), _MOST)
