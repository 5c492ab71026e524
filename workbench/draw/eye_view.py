"""Place a camera between the eyes of a body."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from workbench.draw.camera import Camera, look_at
from workbench.draw.scene import SceneBody
from workbench.errors import UsageError
from workbench.model.arrays import Floats
from workbench.sight.eyes import USUAL_DOWN, Eyes, eyes_of, has_eyes

__all__ = ["FIELD", "eye_point", "eye_view"]

FIELD = math.radians(75.0)
"""Angle of view [rad] from bottom to top."""

_NEAR_PLANE = 0.08
"""Distance [m] before the eyes where drawing begins. Brows, nose and cheeks would hide the rest."""


def eye_point(shown: SceneBody) -> tuple[Floats, Floats]:
    """Find the eyes of a body.

    Returns
    -------
    tuple[Floats, Floats]
        The midpoint (3,) [m] between the pupils, and the axes (3, 3) of the head: forward, left, up
        as rows.

    Raises
    ------
    UsageError
        If the body has no eyes, or they are not placed.
    """
    eyes = _eyes(shown)
    return eyes.middle[shown.pose], eyes.axes[shown.pose]


def _eyes(shown: SceneBody) -> Eyes:
    """The eyes of all poses of a body; UsageError as `eye_point`."""
    body = shown.placed.body
    if not has_eyes(body):
        raise UsageError(
            f"body {body.name}: no sphere is named an eye; give a camera by eye and target"
        )
    eyes = eyes_of(shown.placed)
    if not np.all(np.isfinite(eyes.middle[shown.pose])):
        raise UsageError(
            f"body {body.name}: its eyes are outside the logical window, so it has no view"
        )
    return eyes


def eye_view(
    shown: SceneBody,
    *,
    down: float = USUAL_DOWN,
    left: float = 0.0,
    field: float = FIELD,
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
    eyes = _eyes(shown)
    point = eyes.middle[shown.pose]
    way = eyes.line(down=down, left=left)[shown.pose]
    near_plane = 1.0 - _NEAR_PLANE  # as a depth; the target is 1 m away
    camera = look_at(
        point,
        point + way,
        up=eyes.axes[shown.pose, 2],
        field=field,
        width=width,
        height=height,
        cut=near_plane,
    )
    return replace(camera, name="eye")
