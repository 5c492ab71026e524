"""Frame standard views on the bodies and some of their surroundings, all at one scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.draw.camera import Camera, fit_to_spheres, project, standard_view
from workbench.draw.scene import Scene, shown_corners
from workbench.model.arrays import Floats

__all__ = ["FOUR", "fitted_view", "four_views", "framed_views"]

FOUR: tuple[str, ...] = ("front", "left", "top", "corner")
"""The views of a report."""


def four_views(scene: Scene, *, width: int = 640, height: int = 640) -> list[tuple[str, Camera]]:
    """Return front, left, top and corner cameras, see `framed_views`."""
    return framed_views(scene, FOUR, width=width, height=height)


def framed_views(
    scene: Scene,
    names: Sequence[str],
    *,
    width: int = 640,
    height: int = 640,
    around: float | None = None,
) -> list[tuple[str, Camera]]:
    """Return cameras of standard views, each of which holds all bodies.

    All have one scale, so that sizes can be compared from picture to picture. Free room is given to
    the environment.

    Parameters
    ----------
    scene
        What is seen.
    names
        Names of standard views, see `camera.VIEWS`.
    width, height
        Size of each picture [pixels].
    around
        Least width [m] of the surroundings on each side of the bodies; if None 0.12 with an
        environment and 0.06 without.
    """
    if around is None:
        around = 0.06 if scene.environment is None else 0.12
    cameras = [standard_view(name, scene.bounds, width=width, height=height) for name in names]
    if not len(scene.spheres.radius):
        scale = min(camera.scale for camera in cameras)
        return [(camera.name, replace(camera, scale=scale)) for camera in cameras]
    frames = [_body_frame(scene, camera, around) for camera in cameras]
    scale = min(float(np.min([width, height] / (frame[1] - frame[0]))) for frame in frames)
    return [
        (camera.name, _centre_on(scene, replace(camera, scale=scale), frame))
        for camera, frame in zip(cameras, frames, strict=True)
    ]


def fitted_view(scene: Scene, camera: Camera, *, margin: float = 0.06) -> Camera:
    """Move a camera, without turning it, so that all bodies fill its picture.

    Without bodies it is fitted to the shown environment. See `camera.fit_to_spheres`.

    Raises
    ------
    UsageError
        If there is nothing to show.
    """
    spheres = scene.spheres
    if len(spheres.radius):
        return fit_to_spheres(camera, spheres.centre, spheres.radius, margin=margin)
    corners = shown_corners(scene.environment)
    points = corners if len(corners) else scene.bounds
    return fit_to_spheres(camera, points, np.zeros(len(points)), margin=margin)


def _body_frame(scene: Scene, camera: Camera, around: float) -> Floats:
    """Return the extent (2, 2) [m] of all spheres to the right and up, grown by `around`."""
    spheres = scene.spheres
    seen = _in_picture_plane(camera, spheres.centre)
    reach = spheres.radius[:, None] + around
    return np.array([(seen - reach).min(axis=0), (seen + reach).max(axis=0)])


def _in_picture_plane(camera: Camera, points: Floats) -> Floats:
    """Return points (M, 3) [m] as (M, 2) [m] to the right and up from the camera's centre."""
    x, y, _ = project(camera, points).T
    return np.column_stack([x - camera.width / 2.0, camera.height / 2.0 - y]) / camera.scale


def _centre_on(scene: Scene, camera: Camera, frame: Floats) -> Camera:
    """Move a camera across the view: `frame` (2, 2) stays in the picture, and as much of the
    environment as possible."""
    middle = frame.mean(axis=0)
    corners = shown_corners(scene.environment)
    if len(corners):
        seen = _in_picture_plane(camera, corners)
        low = np.minimum(seen.min(axis=0), frame[0])
        high = np.maximum(seen.max(axis=0), frame[1])
        middle = _picture_middle(camera, frame, low, high)
    return replace(camera, centre=camera.centre + middle[0] * camera.right + middle[1] * camera.up)


def _picture_middle(camera: Camera, frame: Floats, low: Floats, high: Floats) -> Floats:
    """Choose the middle (2,) [m] of a picture of everything from `low` to `high` (2,).

    Along an axis where everything fits, it is centred. Where it does not, the picture is moved as
    little as possible from the middle of the frame so that it ends at the environment's border.
    """
    half = np.array([camera.width, camera.height]) / (2.0 * camera.scale)
    inside = np.clip(frame.mean(axis=0), low + half, np.maximum(high - half, low + half))
    clamped = np.clip(inside, frame[1] - half, frame[0] + half)
    return np.where(high - low <= 2.0 * half, (low + high) / 2.0, clamped)
