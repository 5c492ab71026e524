"""Paint ghosts: bodies shown pale behind all others.

Ghosts are earlier frames of a motion, or a measurement behind a prediction. They hide nothing, and
every body hides them. Later ghosts are stronger.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from workbench.draw.camera import Camera
from workbench.draw.colours import INKS, ramp
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.visibility import (
    DepthBuffers,
    depth_share,
    projected_disks,
    render_buffers,
)
from workbench.model.arrays import Bools, Floats

__all__ = ["ghost_strengths", "paint_overlays"]

_MIN_STRENGTH = 0.25
_MAX_STRENGTH = 0.55
_STRENGTH_BEHIND_WALL = 0.4
"""Share of its strength that a ghost keeps behind a wall."""


def ghost_strengths(scene: Scene) -> Floats:
    """Return the opacity (G,) of each ghost, 0 to 1.

    Ghosts with the same pose number are alike. Later poses are stronger.
    """
    poses, step = np.unique([shown.pose for shown in scene.ghosts], return_inverse=True)
    if len(poses) < 2:
        return np.full(len(scene.ghosts), _MAX_STRENGTH)
    return np.linspace(_MIN_STRENGTH, _MAX_STRENGTH, len(poses))[step]


def paint_overlays(
    picture: NDArray[np.float32], scene: Scene, camera: Camera, buffers: DepthBuffers, line: int
) -> None:
    """Blend the ghosts of a scene into its picture.

    Parameters
    ----------
    picture
        (height, width, 3) of 0 to 255, with environment and bodies; changed in place.
    scene, camera, buffers
        The scene, its camera, and its depth buffers.
    line
        Width of an outline [pixels].
    """
    free = buffers.sphere < 0
    for shown, strength in zip(scene.ghosts, ghost_strengths(scene).tolist(), strict=True):
        alone = Scene((shown,))
        own = render_buffers(alone, camera)
        here = (own.sphere >= 0) & free
        colour = _ghost_colours(shown, alone, camera)[own.sphere[here]]
        colour[_border(own.sphere >= 0, line)[here]] = INKS[shown.colour]
        behind_wall = buffers.depth[here] > own.body_depth[here]
        opacity = np.where(behind_wall, _STRENGTH_BEHIND_WALL * strength, strength)[:, None]
        picture[here] = picture[here] * (1.0 - opacity) + colour * opacity


def _ghost_colours(shown: SceneBody, alone: Scene, camera: Camera) -> Floats:
    """Return the colour (S, 3) of each sphere, by its depth."""
    return ramp(shown.colour, depth_share(projected_disks(alone, camera).front))


def _border(mask: Bools, width: int) -> Bools:
    """Return the pixels of a mask within `width` pixels of its border, along rows and columns."""
    inner = mask.copy()
    for step in range(1, width + 1):
        inner[step:] &= mask[:-step]
        inner[:-step] &= mask[step:]
        inner[:, step:] &= mask[:, :-step]
        inner[:, :-step] &= mask[:, step:]
    return mask & ~inner
