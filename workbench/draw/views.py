"""The four views of a report, framed on the bodies with some of their surroundings, all at one scale."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.draw.camera import Camera, project, standard_view
from workbench.draw.scene import Scene

__all__ = ["FOUR", "four_views"]

FOUR: tuple[str, ...] = ("front", "left", "top", "three_quarter")


def four_views(
    scene: Scene, *, width: int = 640, height: int = 640, around: float | None = None
) -> list[tuple[str, Camera]]:
    """Front, left, top and three-quarter cameras, each fitted to the bodies as seen from there.

    around [m]: how much of the surroundings shows on every side; 0.18 where there are any, else 0.06. One scale for
    all four: sizes may be compared from picture to picture.
    """
    if around is None:
        around = 0.06 if scene.environment is None else 0.18
    cameras = [_framed(scene, standard_view(name, scene.bounds, width=width, height=height), around) for name in FOUR]
    scale = min(camera.scale for camera in cameras)
    return [(camera.name, replace(camera, scale=scale)) for camera in cameras]


def _framed(scene: Scene, camera: Camera, around: float) -> Camera:
    """Move the camera across the view, and scale, so that all spheres and `around` [m] beyond them are in."""
    spheres = scene.spheres
    if not len(spheres.radius):
        return camera
    seen = project(camera, spheres.centre)[:, :2] / camera.scale  # [m], y down
    reach = spheres.radius[:, None] + around
    low, high = (seen - reach).min(axis=0), (seen + reach).max(axis=0)
    middle = (low + high) / 2.0 - np.array([camera.width, camera.height]) / (2.0 * camera.scale)
    scale = float(np.min(np.array([camera.width, camera.height]) / (high - low)))
    return replace(camera, centre=camera.centre + middle[0] * camera.right - middle[1] * camera.up, scale=scale)
