"""Place a camera between the eyes of a body."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from workbench.draw.camera import Camera, look_at
from workbench.draw.scene import SceneBody
from workbench.errors import UsageError
from workbench.model.arrays import Floats

__all__ = ["eye_point", "eye_view"]

_NEAR_PLANE = 0.08
"""Distance [m] before the eyes where drawing begins. Brows, nose and cheeks would hide the rest."""


def eye_point(shown: SceneBody) -> tuple[Floats, Floats]:
    """Find the eyes of a body: the spheres whose name ends with "eye".

    Returns
    -------
    tuple[Floats, Floats]
        The midpoint (3,) [m] between the fronts of the eyes, and the axes (3, 3) of the head:
        forward, left, up as rows.

    Raises
    ------
    UsageError
        If the body has no eyes, or they are not placed.
    """
    placed = shown.placed
    body = placed.body
    eyes = [k for k, name in enumerate(body.sphere_names) if name.endswith("eye")]
    if not eyes:
        raise UsageError(
            f"body {body.name}: no sphere is named an eye; give a camera by eye and target"
        )
    head = int(body.sphere_segment[eyes[0]])
    axes = placed.world_from_segment[shown.pose, head, :, :3].T
    radius = body.radius[placed.person[shown.pose], eyes].mean()
    point = placed.centres[shown.pose][eyes].mean(axis=0) + radius * axes[0]
    if not np.all(np.isfinite(point)):
        raise UsageError(
            f"body {body.name}: its eyes are outside the logical window, so it has no view"
        )
    return point, axes


def eye_view(
    shown: SceneBody,
    *,
    down: float = math.radians(10.0),
    left: float = 0.0,
    field: float = math.radians(75.0),
    width: int = 640,
    height: int = 640,
) -> Camera:
    """Return a perspective camera at the eyes of a body, upright with its head.

    What is within 80 mm of the eyes is not drawn.

    Parameters
    ----------
    shown
        The body and its pose.
    down, left
        Angles [rad] of the line of sight from straight ahead of the head. The default is a usual
        line of sight.
    field
        Angle of view [rad] from bottom to top.
    width, height
        Size of the picture [pixels].
    """
    point, (forward, leftward, up) = eye_point(shown)
    level = math.cos(left) * forward + math.sin(left) * leftward
    sight = math.cos(down) * level - math.sin(down) * up
    near_plane = 1.0 - _NEAR_PLANE  # as a depth; the target is 1 m away
    camera = look_at(
        point, point + sight, up=up, field=field, width=width, height=height, cut=near_plane
    )
    return replace(camera, name="eye")
