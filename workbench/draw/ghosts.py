"""Bodies that are shown pale behind the others: earlier frames of a motion, or what was measured
behind what was predicted. They hide nothing and every body hides them; the later in the list, the
stronger."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from workbench.draw.camera import Camera
from workbench.draw.colours import INKS, ramp
from workbench.draw.scene import Scene
from workbench.draw.visibility import DepthBuffers, depth_share, projected_disks, render_buffers
from workbench.model.arrays import Bools, Floats

__all__ = ["ghost_strengths", "paint_overlays"]

_WEAKEST = 0.25
_STRONGEST = 0.55
_BEHIND = 0.4  # of its strength a ghost keeps behind a wall


def ghost_strengths(scene: Scene) -> Floats:
    """Opacity of each ghost of a scene, 0 to 1: ghosts of one pose number are alike, later ones
    stronger."""
    poses = [shown.pose for shown in scene.ghosts]
    steps = sorted(set(poses))
    if len(steps) < 2:
        return np.full(len(poses), _STRONGEST)
    scale = np.linspace(_WEAKEST, _STRONGEST, len(steps))
    return np.array([scale[steps.index(pose)] for pose in poses])


def paint_overlays(
    picture: NDArray[np.float32], scene: Scene, camera: Camera, layers: DepthBuffers, line: int
) -> None:
    """Blend the scene's ghosts into a picture (height, width, 3) of 0 to 255 that holds its
    environment and bodies.

    layers: of the scene; line: width of an outline [pixels].
    """
    free = layers.sphere < 0
    for shown, strength in zip(scene.ghosts, ghost_strengths(scene).tolist(), strict=True):
        alone = Scene((shown,))
        seen = render_buffers(alone, camera)
        here = (seen.sphere >= 0) & free
        colour = ramp(shown.colour, depth_share(projected_disks(alone, camera).front))[
            seen.sphere[here]
        ]
        colour[_rim(seen.sphere >= 0, line)[here]] = INKS[shown.colour]
        share = np.where(layers.depth[here] > seen.body_depth[here], _BEHIND * strength, strength)[
            :, None
        ]
        picture[here] = picture[here] * (1.0 - share) + colour * share


def _rim(mask: Bools, width: int) -> Bools:
    """Pixels of a mask within `width` pixels of its border."""
    inner = mask.copy()
    for step in range(1, width + 1):
        inner[step:] &= mask[:-step]
        inner[:-step] &= mask[step:]
        inner[:, step:] &= mask[:, :-step]
        inner[:, :-step] &= mask[:, step:]
    return mask & ~inner
