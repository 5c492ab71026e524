"""Standard views framed on the bodies with some of their surroundings, all at one scale; a report
shows four."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.draw.camera import Camera, fit_to_spheres, project, standard_view
from workbench.draw.scene import Scene, shown_corners
from workbench.model.arrays import Floats

__all__ = ["FOUR", "fitted_view", "four_views", "framed_views"]

FOUR: tuple[str, ...] = ("front", "left", "top", "three_quarter")


def four_views(scene: Scene, *, width: int = 640, height: int = 640) -> list[tuple[str, Camera]]:
    """Front, left, top and three-quarter cameras, as `framed_views` makes them."""
    return framed_views(scene, FOUR, width=width, height=height)


def framed_views(
    scene: Scene,
    names: Sequence[str],
    *,
    width: int = 640,
    height: int = 640,
    around: float | None = None,
) -> list[tuple[str, Camera]]:
    """Cameras of standard views by name, each of which holds all bodies as seen from there.

    around [m]: how much of the surroundings shows at least on every side; 0.12 where there are any,
    else 0.06. One scale for all: sizes may be compared from picture to picture. Room that is left
    is given to the environment.
    """
    if around is None:
        around = 0.06 if scene.environment is None else 0.12
    cameras = [standard_view(name, scene.bounds, width=width, height=height) for name in names]
    if not len(scene.spheres.radius):
        least = min(camera.scale for camera in cameras)
        return [(camera.name, replace(camera, scale=least)) for camera in cameras]
    frames = [_extent(scene, camera, around) for camera in cameras]
    scale = min(float(np.min([width, height] / (frame[1] - frame[0]))) for frame in frames)
    return [
        (camera.name, _centred(scene, replace(camera, scale=scale), frame))
        for camera, frame in zip(cameras, frames, strict=True)
    ]


def fitted_view(scene: Scene, camera: Camera, *, margin: float = 0.06) -> Camera:
    """The camera moved so that all bodies, or what is shown of the environment where there are
    none, fill its picture.

    UsageError where there is nothing to show. See `camera.fitted`; the view is not turned.
    """
    spheres = scene.spheres
    if len(spheres.radius):
        return fit_to_spheres(camera, spheres.centre, spheres.radius, margin=margin)
    corners = shown_corners(scene.environment)
    return fit_to_spheres(
        camera,
        corners if len(corners) else scene.bounds,
        np.zeros(max(len(corners), 2)),
        margin=margin,
    )


def _extent(scene: Scene, camera: Camera, around: float) -> Floats:
    """(2, 2) least and greatest [m] to the right and up, from the camera's centre: all spheres and
    `around` beyond."""
    spheres = scene.spheres
    seen = _flat(camera, spheres.centre)
    reach = spheres.radius[:, None] + around
    return np.array([(seen - reach).min(axis=0), (seen + reach).max(axis=0)])


def _flat(camera: Camera, points: Floats) -> Floats:
    """Points (M, 3) [m] as (M, 2) [m] to the right and up from the camera's centre."""
    x, y, _ = project(camera, points).T
    return np.column_stack([x - camera.width / 2.0, camera.height / 2.0 - y]) / camera.scale


def _centred(scene: Scene, camera: Camera, frame: Floats) -> Camera:
    """Move the camera across the view: `frame` (2, 2) stays in the picture, and the environment as
    far as it can."""
    half = np.array([camera.width, camera.height]) / (2.0 * camera.scale)
    middle = frame.mean(axis=0)
    corners = shown_corners(scene.environment)
    if len(corners):
        seen = _flat(camera, corners)
        low = np.minimum(seen.min(axis=0), frame[0])
        high = np.maximum(seen.max(axis=0), frame[1])
        fits = high - low <= 2.0 * half
        inside = np.clip(middle, low + half, np.maximum(high - half, low + half))
        middle = np.where(
            fits, (low + high) / 2.0, np.clip(inside, frame[1] - half, frame[0] + half)
        )
    return replace(camera, centre=camera.centre + middle[0] * camera.right + middle[1] * camera.up)
