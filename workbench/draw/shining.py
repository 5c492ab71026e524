"""Draw a part shining through the bodies that hide it, as in close-ups of deep contacts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PIL import Image

from workbench.draw.camera import Camera
from workbench.draw.disks import disks
from workbench.draw.marks.pictures import paint_mark_shapes, paint_mark_texts
from workbench.draw.scene import Scene
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Floats
from workbench.model.environment import Environment

__all__ = ["shining_part"]

_OPACITY = 0.5
"""Opacity of the part over what hides it."""
_COLOUR = np.array([240.0, 120.0, 90.0])


def shining_part(scene: Scene, camera: Camera, part: str) -> Image.Image:
    """Draw a scene in light and shade, with one part shining through all that is before it.

    Raises
    ------
    UsageError
        If the scene has no such part.
    """
    environment = scene.environment
    names = () if environment is None else environment.parts
    if environment is None or part not in names:
        raise UsageError(f"no part {part!r} in the scene; {one_of(part, names)}")
    whole = disks(replace(scene, marks=()), camera, mode="shaded")
    others = np.array([name != part for name in names])
    lit = _drawn(replace(environment, hidden=others), camera)
    bare = _drawn(replace(environment, hidden=np.ones_like(others)), camera)
    here = np.abs(lit - bare).max(axis=2) > 0.0
    shade = 0.4 + 0.6 * lit[here].mean(axis=1, keepdims=True) / 255.0
    picture = np.asarray(whole, dtype=np.float64).copy()
    picture[here] += _OPACITY * (shade * _COLOUR - picture[here])
    image = Image.fromarray(np.round(picture).astype(np.uint8))
    paint_mark_shapes(image, scene, camera, 1)
    paint_mark_texts(image, scene, camera)
    return image


def _drawn(environment: Environment, camera: Camera) -> Floats:
    """(height, width, 3) of the environment alone."""
    return np.asarray(disks(Scene((), environment), camera, mode="shaded"), dtype=np.float64)
