"""Transform points into view coordinates and into pixels, in one pass each."""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit
from workbench.model.arrays import Floats

__all__ = ["pixel_points", "view_points"]


@njit(cache=True)
def view_points(points: Floats, axes: Floats, centre: Floats) -> Floats:
    """Return the view coordinates (M, 3) of points (M, 3).

    axes (3, 3): unit vectors right, up, toward as rows; centre (3,): the camera's centre.
    """
    seen = np.empty((len(points), 3))
    for k in range(len(points)):
        x = points[k, 0] - centre[0]
        y = points[k, 1] - centre[1]
        z = points[k, 2] - centre[2]
        for i in range(3):
            seen[k, i] = x * axes[i, 0] + y * axes[i, 1] + z * axes[i, 2]
    return seen


@njit(cache=True)
def pixel_points(
    seen: Floats, scale: float, inverse_distance: float, nearest: float, middle: Floats
) -> Floats:
    """Project view coordinates to pixels.

    Parameters
    ----------
    seen
        (M, 3) view coordinates [m].
    scale
        Pixels per metre at depth 0.
    inverse_distance
        Of the camera [1/m].
    nearest
        Largest depth [m] that has pixels; nearer points get NaN.
    middle
        (2,) middle of the picture [pixels].

    Returns
    -------
    Floats
        (M, 3) x, y [pixels] and depth [m].
    """
    shown = np.empty((len(seen), 3))
    for k in range(len(seen)):
        depth = seen[k, 2]
        inside = depth if depth <= nearest else math.nan
        size = scale / (1.0 - inside * inverse_distance)
        shown[k, 0] = middle[0] + size * seen[k, 0]
        shown[k, 1] = middle[1] - size * seen[k, 1]
        shown[k, 2] = depth
    return shown
