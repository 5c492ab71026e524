"""Points into view coordinates and into pixels: the arithmetic of draw.camera in one pass each, to
the same bits."""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit
from workbench.model.arrays import Floats

__all__ = ["pixel_points", "view_points"]


@njit(cache=True)
def view_points(points: Floats, axes: Floats, centre: Floats) -> Floats:
    """View coordinates (M, 3) of points (M, 3): along the three axes (3, 3), its rows, from the
    centre (3,)."""
    seen = np.empty((len(points), 3))
    for k in range(len(points)):
        x = points[k, 0] - centre[0]
        y = points[k, 1] - centre[1]
        z = points[k, 2] - centre[2]
        for way in range(3):
            seen[k, way] = x * axes[way, 0] + y * axes[way, 1] + z * axes[way, 2]
    return seen


@njit(cache=True)
def pixel_points(seen: Floats, scale: float, bend: float, nearest: float, middle: Floats) -> Floats:
    """Pixels x, y and depth (M, 3) of view coordinates (M, 3); x and y NaN where the depth is above
    `nearest`.

    scale [pixels/m] at depth 0, bend [1/m], middle (2,) of the picture [pixels].
    """
    shown = np.empty((len(seen), 3))
    for k in range(len(seen)):
        depth = seen[k, 2]
        inside = depth if depth <= nearest else math.nan
        size = scale / (1.0 - inside * bend)
        shown[k, 0] = middle[0] + size * seen[k, 0]
        shown[k, 1] = middle[1] - size * seen[k, 1]
        shown[k, 2] = depth
    return shown
