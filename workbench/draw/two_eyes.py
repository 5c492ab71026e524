"""Superimpose what two eyes see, and show what is hidden to both."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from PIL import Image

from workbench.draw.camera import Camera
from workbench.draw.marks.pictures import paint_mark_shapes, paint_mark_texts
from workbench.draw.scene import PAPER, Scene
from workbench.draw.visibility import render_buffers
from workbench.model.arrays import Bools

__all__ = ["both_eyes"]

_PALE = 0.6
"""Share of paper in what only one eye sees something of."""
_HATCH = 0.78
"""Share of the colour that is left in a line of the hatch."""
_HATCHES = 90
"""Number of lines of the hatch across a picture."""
_KEY_WIDTH = 400
"""Least width [pixels] of a picture with a legend."""
_KEY = (
    ("hatched: hidden to both eyes", "grey"),
    ("pale: hidden to one eye", "grey"),
)


def both_eyes(
    scene: Scene, camera: Camera, paint: Callable[[Scene, Camera], Image.Image]
) -> Image.Image:
    """Superimpose the pictures of two eyes that look into one distance.

    Where they look far, what hides it from both is hatched, and pale where one eye sees past it.

    Parameters
    ----------
    scene
        What is seen.
    camera
        Midway between the eyes, with `aside` and `focus`.
    paint
        Draws the picture of one eye.
    """
    # f [pixels] the distance of the picture: a point straight ahead in distance d is f a / d aside
    pixels = camera.scale * camera.distance
    apart = float(np.linalg.norm(camera.aside))
    shift = round(pixels * apart / camera.focus)
    wide = replace(camera, width=camera.width + 2 * shift, aside=(0.0, 0.0, 0.0))
    bare = replace(scene, marks=())
    images = []
    hidden = []
    for sign, first in ((1.0, 2 * shift), (-1.0, 0)):
        eye = replace(wide, centre=wide.centre + sign * np.array(camera.aside))
        kept = slice(first, first + camera.width)
        images.append(np.asarray(paint(bare, eye).convert("RGB"), dtype=np.float64)[:, kept])
        hidden.append(_hidden(bare, eye)[:, kept])
    mixed = (images[0] + images[1]) / 2.0
    far = not math.isfinite(camera.focus)
    if far:
        one = hidden[0] ^ hidden[1]
        mixed[one] += _PALE * (np.array(PAPER) - mixed[one])
        row, column = np.indices(one.shape)
        step = max(4, camera.width // _HATCHES)
        mixed[hidden[0] & hidden[1] & ((row + column) % step == 0)] *= _HATCH
    image = Image.fromarray(np.round(mixed).astype(np.uint8))
    key = _KEY if far and camera.width >= _KEY_WIDTH else ()
    paint_mark_shapes(image, scene, camera, 1)
    paint_mark_texts(image, replace(scene, key=key), camera)
    return image


def _hidden(scene: Scene, camera: Camera) -> Bools:
    """(height, width) whether something opaque is seen."""
    buffers = render_buffers(scene, camera, spheres="exact")
    return np.asarray((buffers.triangle >= 0) | (buffers.sphere >= 0))
