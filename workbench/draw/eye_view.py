"""What a body sees: a camera between its eyes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from workbench.draw.camera import Camera, look_at
from workbench.draw.scene import SceneBody
from workbench.errors import UsageError
from workbench.model.arrays import Floats

__all__ = ["eye_point", "eye_view"]

_CLEAR = 0.08  # [m] nothing nearer is drawn: brows, nose and cheeks would hide the rest


def eye_point(shown: SceneBody) -> tuple[Floats, Floats]:
    """The middle (3,) [m] between the fronts of a body's eyes, and its head's axes (3, 3): forward,
    left, up as rows.

    The eyes are the spheres whose name ends with "eye". UsageError where the body has none or they
    are not placed.
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
    point = (
        placed.centres[shown.pose][eyes].mean(axis=0)
        + body.radius[placed.person[shown.pose], eyes].mean() * axes[0]
    )
    if not np.all(np.isfinite(point)):
        raise UsageError(
            f"body {body.name}: its eyes are outside the logical window, nothing can be seen from them"
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
    """A perspective camera where the body's eyes are, upright with its head, without what is within
    80 mm.

    down, left [rad]: of the line of sight from straight ahead of the head; the default is a usual
    line of sight. field [rad]: from the bottom of the picture to its top.
    """
    point, (forward, leftward, up) = eye_point(shown)
    level = math.cos(left) * forward + math.sin(left) * leftward
    ahead = math.cos(down) * level - math.sin(down) * up
    camera = look_at(
        point, point + ahead, up=up, field=field, width=width, height=height, cut=1.0 - _CLEAR
    )
    return replace(camera, name="eye")
