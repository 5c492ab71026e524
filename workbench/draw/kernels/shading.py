"""Paint and light the surfaces of spheres, pixel by pixel; see `sight.kernels.sphere_rays`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.compiled import njit
from workbench.model.arrays import Floats, Ints
from workbench.sight.kernels.sphere_rays import Lens, cast, row_of, sphere_box

__all__ = ["Light", "light_surfaces", "paint_rays"]

_AMBIENT = 0.42
"""Share of the light on a surface that faces away from it."""
_DIFFUSE = 0.58
"""What is added to this on a surface that faces the light."""
_TAP_WEIGHT = 0.11
"""Share of the ambient light that one of 8 places around a pixel takes at most."""
_MAX_DARK = 0.75
"""Share of the ambient light that all of them take at most."""
_MIN_FACING = 0.05
"""Least part of a normal toward the viewer, for pixels at a rim."""
_MAX_TAP = 1e6
"""[pixels] to where ambient light is sought at most, so that it fits an integer."""
_H = math.sqrt(0.5)
_TAPS = (
    (1.0, 0.0),
    (0.0, 1.0),
    (-1.0, 0.0),
    (0.0, -1.0),
    (_H, _H),
    (-_H, _H),
    (-_H, -_H),
    (_H, -_H),
)
"""Directions right and up in which ambient light is sought."""


class Light(NamedTuple):
    """Direction to the light in view coordinates, a unit vector."""

    x: float
    y: float
    z: float
    crease_radius: float
    """Distance [m] within which surfaces darken creases."""


@njit(cache=True)
def paint_rays(balls: Floats, order: Ints, lens: Lens, value: Ints, picture: Ints) -> None:
    """Paint spheres by their exact outlines: later ones cover earlier ones where a ray meets them.

    Parameters
    ----------
    balls, order, lens
        As for `surface_depths`.
    value
        (S,) what is written for each sphere.
    picture
        (height, width) filled in place.
    """
    height, width = picture.shape
    pixel = 1.0 / lens.scale
    for sphere in order:
        box = sphere_box(balls, sphere, lens, width, height)
        for row in range(box.top, box.bottom):
            rays = row_of(balls, sphere, row, lens)
            for column in range(box.left, box.right):
                ray = cast((column + 0.5 - lens.x) * pixel, rays)
                if ray.rest < 0.0:
                    continue
                if rays.z + (ray.middle - math.sqrt(ray.rest)) / ray.whole < lens.nearest:
                    picture[row, column] = value[sphere]


# ----------------------------------------------------------------------------------- light


@njit(cache=True, error_model="numpy", forceinline=True)
def _normal(
    row: int, column: int, depth: float, pixel: float, sphere: int, balls: Floats, lens: Lens
) -> tuple[float, float, float]:
    """Return the unit normal of a sphere at a pixel of that depth, as far as the viewer sees it.

    It points straight at the viewer on a cut face. pixel: its width [m] at that depth.
    """
    if depth >= lens.nearest:
        return 0.0, 0.0, 1.0
    inverse = 1.0 / balls[sphere, 3]
    x = ((column + 0.5 - lens.x) * pixel - balls[sphere, 0]) * inverse
    y = ((lens.y - row - 0.5) * pixel - balls[sphere, 1]) * inverse
    return x, y, max((depth - balls[sphere, 2]) * inverse, _MIN_FACING)


@njit(cache=True)
def _tap_offsets(balls: Floats, lens: Lens, radius: float) -> tuple[Ints, Floats]:
    """Find where ambient light is sought around a pixel of each sphere.

    Four places lie `radius` [m] away and four half as far, at least 2 pixels and 1. Returns (S, 8,
    2) pixels right and down, and (S, 8) 1 / their distance [1/m].
    """
    offset = np.empty((len(balls), 8, 2), np.int64)
    inverse = np.empty((len(balls), 8))
    for sphere in range(len(balls)):
        pixel = (1.0 - lens.bend * balls[sphere, 2]) / lens.scale  # [m]
        farthest = min(max(radius / pixel, 2.0), _MAX_TAP)
        for k in range(8):
            step = farthest if k < 4 else 0.5 * farthest
            offset[sphere, k, 0] = math.floor(_TAPS[k][0] * step + 0.5)
            offset[sphere, k, 1] = -math.floor(_TAPS[k][1] * step + 0.5)
            inverse[sphere, k] = 1.0 / (step * pixel)
    return offset, inverse


@njit(cache=True, error_model="numpy", forceinline=True)
def _ambient_share(
    row: int,
    column: int,
    sphere: int,
    normal: tuple[float, float, float],
    pixel: float,
    depth: Floats,
    offset: Ints,
    inverse: Floats,
) -> float:
    """Return the share of ambient light at a pixel.

    What stands above the tangent plane of the pixel at 8 places around takes some of the light,
    most where it rises as much as it is away. Steps of twice that and more are other limbs and take
    nothing. pixel: its width [m]; offset, inverse: of `_tap_offsets`.
    """
    height, width = depth.shape
    nx, ny, nz = normal
    here = depth[row, column]
    # [m], times nz: by how much the tangent plane falls per pixel to the right, and up
    slope_x = nx * pixel
    slope_y = ny * pixel
    dark = 0.0
    far = offset[sphere, 0, 0]
    inside = column >= far and row >= far and column + far < width and row + far < height
    for k in range(8):
        du = offset[sphere, k, 0]
        dv = offset[sphere, k, 1]
        u = column + du
        v = row + dv
        if not inside and (u < 0 or v < 0 or u >= width or v >= height):
            continue
        rise = ((depth[v, u] - here) * nz + slope_x * du - slope_y * dv) * inverse[sphere, k]
        taken = rise if rise < 1.0 else 2.0 - rise
        dark += taken if taken > 0.0 else 0.0
    return 1.0 - min(_TAP_WEIGHT * dark, _MAX_DARK)


@njit(cache=True, error_model="numpy")
def light_surfaces(
    balls: Floats,
    colour: Floats,
    light: Light,
    lens: Lens,
    depth: Floats,
    ids: Ints,
    picture: Ints,
) -> None:
    """Light surfaces softly, with ambient occlusion in creases.

    Parameters
    ----------
    balls, lens
        As for `surface_depths`.
    colour
        (S, 3) colour of each sphere in full light, 0 to 255.
    light
        The light.
    depth, ids
        (height, width) as `surface_depths` fills them.
    picture
        (height, width, 3) written where `ids` is not -1.
    """
    height, width = ids.shape
    offset, inverse = _tap_offsets(balls, lens, light.crease_radius)
    for row in range(height):
        for column in range(width):
            sphere = ids[row, column]
            if sphere < 0:
                continue
            here = depth[row, column]
            pixel = (1.0 - lens.bend * here) / lens.scale
            normal = _normal(row, column, here, pixel, sphere, balls, lens)
            soft = 0.5 + 0.5 * (normal[0] * light.x + normal[1] * light.y + normal[2] * light.z)
            lit = _AMBIENT + _DIFFUSE * soft * soft
            lit *= _ambient_share(row, column, sphere, normal, pixel, depth, offset, inverse)
            for k in range(3):
                picture[row, column, k] = int(colour[sphere, k] * lit + 0.5)
