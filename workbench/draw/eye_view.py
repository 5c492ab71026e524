"""Place a camera between the eyes of a body."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from workbench.draw.camera import Camera, look_at
from workbench.draw.scene import SceneBody
from workbench.errors import UsageError
from workbench.model.arrays import Floats
from workbench.model.poses import Placed

__all__ = ["FIELD", "Sight", "eye_point", "eye_view", "sight"]

USUAL_DOWN = math.radians(10.0)
"""How far [rad] a usual line of sight is below straight ahead of the head."""
FIELD = math.radians(75.0)
"""Angle of view [rad] from bottom to top."""

_NEAR_PLANE = 0.08
"""Distance [m] before the eyes where drawing begins. Brows, nose and cheeks would hide the rest."""


@dataclass(frozen=True, eq=False)
class Sight:
    """From where P poses of a body look, and how.

    Parameters
    ----------
    point
        (P, 3) [m] between the fronts of the eyes.
    axes
        (P, 3, 3) of the head: forward, left, up as rows.
    head
        The index of the segment that has the eyes.
    """

    point: Floats
    axes: Floats
    head: int

    def line(self, *, down: float = USUAL_DOWN, left: float = 0.0) -> Floats:
        """(P, 3) the directions of the line of sight, so far [rad] from straight ahead of the
        head."""
        forward, leftward, up = (self.axes[:, k] for k in range(3))
        level = math.cos(left) * forward + math.sin(left) * leftward
        return np.asarray(math.cos(down) * level - math.sin(down) * up)


def sight(placed: Placed) -> Sight | None:
    """Find the eyes of a body: the spheres whose name ends with "eye"; None where it has none."""
    body = placed.body
    eyes = [k for k, name in enumerate(body.sphere_names) if name.endswith("eye")]
    if not eyes:
        return None
    head = int(body.sphere_segment[eyes[0]])
    axes = placed.world_from_segment[:, head, :, :3].transpose(0, 2, 1)
    radius = body.radius[placed.person][:, eyes].mean(axis=1)
    point = placed.centres[:, eyes].mean(axis=1) + radius[:, None] * axes[:, 0]
    return Sight(point, axes, head)


def eye_point(shown: SceneBody) -> tuple[Floats, Floats]:
    """Find the eyes of a body as `sight` does.

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
    body = shown.placed.body
    found = sight(shown.placed)
    if found is None:
        raise UsageError(
            f"body {body.name}: no sphere is named an eye; give a camera by eye and target"
        )
    point = found.point[shown.pose]
    if not np.all(np.isfinite(point)):
        raise UsageError(
            f"body {body.name}: its eyes are outside the logical window, so it has no view"
        )
    return point, found.axes[shown.pose]


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
    point, axes = eye_point(shown)
    way = Sight(point[None], axes[None], 0).line(down=down, left=left)[0]
    near_plane = 1.0 - _NEAR_PLANE  # as a depth; the target is 1 m away
    camera = look_at(
        point, point + way, up=axes[2], field=field, width=width, height=height, cut=near_plane
    )
    return replace(camera, name="eye")
