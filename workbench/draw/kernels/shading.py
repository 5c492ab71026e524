"""Compute the surfaces of spheres pixel by pixel, as a ray caster would, and light them.

Spheres are in view coordinates, see `disk_painter.Lens`; the last is the depth. The ray through a
pixel passes q (1 - bend z) at depth z, where q is the pixel's position at depth 0. With e the
distance of the ray from a sphere's centre at the centre's depth and s = -bend q its slope, it meets
the surface z' in front of the centre where

    (1 + s^2) z' = -s . e + sqrt(r^2 (1 + s^2) - e^2 - (e x s)^2).

A parallel view has s = 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.compiled import njit
from workbench.draw.kernels.disk_painter import Lens
from workbench.model.arrays import Floats, Ints

__all__ = ["RUN_LENGTH", "Light", "light_surfaces", "paint_rays", "surface_depths"]

RUN_LENGTH = 16
"""Pixels of a row that share one bound of depth."""
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


class _Box(NamedTuple):
    """First column and row of a block of pixels, and one past the last."""

    left: int
    top: int
    right: int
    bottom: int


class _Row(NamedTuple):
    """What a row of pixels and a sphere have in common, for rays in perspective."""

    x: float
    """View coordinates of the centre [m]."""
    z: float
    square: float
    """r^2 [m^2]."""
    bend: float
    shrink: float
    """1 - bend z."""
    slope: float
    """s and e of the row, upward."""
    offset: float


class _Ray(NamedTuple):
    """How a ray meets a sphere: z' = z + (middle +- sqrt(rest)) / whole; rest < 0: not at all."""

    rest: float
    middle: float
    whole: float
    """1 + s^2."""


@njit(cache=True)
def _extent(across: float, along: float, radius: float) -> tuple[float, float]:
    """Return the least and greatest across / along of a sphere seen from the origin.

    They are infinite where it reaches beside the eye.
    """
    if along <= radius:
        return -math.inf, math.inf
    square = along * along - radius * radius
    root = radius * math.sqrt(max(across * across + square, 0.0))
    return (across * along - root) / square, (across * along + root) / square


@njit(cache=True)
def _sphere_box(balls: Floats, sphere: int, lens: Lens, width: int, height: int) -> _Box:
    """Return the pixels of a picture that may show a sphere of balls (S, 4)."""
    x = balls[sphere, 0]
    y = balls[sphere, 1]
    along = lens.distance - balls[sphere, 2]
    radius = balls[sphere, 3]
    left = x - radius
    right = x + radius
    low = y - radius
    high = y + radius
    if lens.bend != 0.0:
        left, right = _extent(x, along, radius)
        low, high = _extent(y, along, radius)
        left = left * lens.distance
        right = right * lens.distance
        low = low * lens.distance
        high = high * lens.distance
    return _Box(
        math.floor(_clamp(lens.x + lens.scale * left - 1.0, width)),
        math.floor(_clamp(lens.y - lens.scale * high - 1.0, height)),
        math.ceil(_clamp(lens.x + lens.scale * right + 1.0, width)),
        math.ceil(_clamp(lens.y - lens.scale * low + 1.0, height)),
    )


@njit(cache=True)
def _clamp(value: float, largest: int) -> float:
    return min(max(value, 0.0), largest)


@njit(cache=True, error_model="numpy", forceinline=True)
def _row_of(balls: Floats, sphere: int, row: int, lens: Lens) -> _Row:
    """Prepare the rays of a row for a sphere of balls (S, 4)."""
    z = balls[sphere, 2]
    radius = balls[sphere, 3]
    qy = (lens.y - row - 0.5) * (1.0 / lens.scale)
    shrink = 1.0 - lens.bend * z
    slope = -lens.bend * qy
    offset = qy * shrink - balls[sphere, 1]
    return _Row(balls[sphere, 0], z, radius * radius, lens.bend, shrink, slope, offset)


@njit(cache=True, error_model="numpy", forceinline=True)
def _cast(qx: float, row: _Row) -> _Ray:
    """Cast the ray at the horizontal position qx [m]; the formula of this module."""
    sx = -row.bend * qx
    ex = qx * row.shrink - row.x
    whole = 1.0 + sx * sx + row.slope * row.slope
    cross = ex * row.slope - row.offset * sx
    rest = row.square * whole - ex * ex - row.offset * row.offset - cross * cross
    return _Ray(rest, -(sx * ex + row.slope * row.offset), whole)


@njit(cache=True, error_model="numpy")
def _parallel_run(
    number: int,
    row: int,
    first: int,
    end: int,
    left: float,
    pixel: float,
    limit: float,
    z: float,
    depth: Floats,
    ids: Ints,
) -> None:
    """Deepen the columns from `first` to `end` of a row by a sphere in a parallel view.

    Parameters
    ----------
    number, z
        The sphere, and its depth [m].
    left, pixel
        [m] from its centre to column 0, and between pixels.
    limit
        Square of the half width [m^2] that the sphere has in this row.
    depth, ids
        (height, width) depth and sphere of the pixels, filled in place.
    """
    line = depth[row, first:end]
    names = ids[row, first:end]
    start = left + pixel * first
    for k in range(len(line)):  # a slice from 0, without branches: eight pixels at once
        across = start + pixel * k
        rest = limit - across * across
        front = z + math.sqrt(rest if rest > 0.0 else 0.0)
        better = (rest >= 0.0) & (front > line[k])
        line[k] = front if better else line[k]
        names[k] = number if better else names[k]


@njit(cache=True, error_model="numpy")
def _perspective_run(
    number: int, row: int, first: int, end: int, rays: _Row, lens: Lens, depth: Floats, ids: Ints
) -> None:
    """Deepen the columns from `first` to `end` of a row by a sphere in perspective.

    What is nearer than the nearest plane of the lens is cut, and the cut face shows.
    """
    line = depth[row, first:end]
    names = ids[row, first:end]
    nearest = lens.nearest
    pixel = 1.0 / lens.scale
    left = (first + 0.5 - lens.x) * pixel
    for k in range(len(line)):
        ray = _cast(left + pixel * k, rays)
        root = math.sqrt(ray.rest if ray.rest > 0.0 else 0.0)
        front = rays.z + (ray.middle + root) / ray.whole
        back = rays.z + (ray.middle - root) / ray.whole
        front = front if front < nearest else nearest
        better = (ray.rest >= 0.0) & (front > line[k]) & (back < nearest)
        line[k] = front if better else line[k]
        names[k] = number if better else names[k]


@njit(cache=True, error_model="numpy")
def surface_depths(
    balls: Floats, order: Ints, lens: Lens, depth: Floats, ids: Ints, bound: Floats
) -> None:
    """Find the foremost sphere surface in every pixel. Beyond the nearest plane the cut face shows.

    The nearest spheres are drawn first. Where all pixels of a run are nearer than the foremost
    point of a sphere in their row, the sphere is passed over.

    Parameters
    ----------
    balls
        (S, 4) view coordinates and radius [m] of whole spheres.
    order
        (K,) the spheres that are drawn, back to front.
    lens
        The camera.
    depth, ids
        (height, width) depth [m] and sphere. They come with the background, and are filled.
    bound
        (height, columns / RUN_LENGTH rounded up) least depth of each run of pixels. It comes filled
        with -inf.
    """
    height, width = depth.shape
    for n in range(len(order) - 1, -1, -1):
        sphere = order[n]
        box = _sphere_box(balls, sphere, lens, width, height)
        for row in range(box.top, box.bottom):
            if lens.bend == 0.0:
                _deepen_parallel(balls, sphere, row, box, lens, depth, ids, bound)
            else:
                front = balls[sphere, 2] + balls[sphere, 3]
                _deepen_runs(
                    balls, sphere, row, box.left, box.right, front, lens, depth, ids, bound
                )


@njit(cache=True, error_model="numpy", forceinline=True)
def _deepen_parallel(
    balls: Floats,
    sphere: int,
    row: int,
    box: _Box,
    lens: Lens,
    depth: Floats,
    ids: Ints,
    bound: Floats,
) -> None:
    """Deepen a row by a sphere of a parallel view, where it is as narrow as in this row."""
    off = (lens.y - row - 0.5) * (1.0 / lens.scale) - balls[sphere, 1]
    limit = balls[sphere, 3] * balls[sphere, 3] - off * off
    if limit < 0.0:
        return
    half = math.sqrt(limit)
    x = balls[sphere, 0]
    low = max(box.left, math.floor(lens.x + lens.scale * (x - half) - 1.0))
    high = min(box.right, math.ceil(lens.x + lens.scale * (x + half) + 1.0))
    front = balls[sphere, 2] + half
    _deepen_runs(balls, sphere, row, low, high, front, lens, depth, ids, bound)


@njit(cache=True, error_model="numpy", forceinline=True)
def _deepen_runs(
    balls: Floats,
    sphere: int,
    row: int,
    low: int,
    high: int,
    front: float,
    lens: Lens,
    depth: Floats,
    ids: Ints,
    bound: Floats,
) -> None:
    """Deepen the columns from `low` to `high` of a row by a sphere, run by run.

    front: depth [m] of the sphere's foremost point in the row, or a larger one.
    """
    width = depth.shape[1]
    pixel = 1.0 / lens.scale
    z = balls[sphere, 2]
    radius = balls[sphere, 3]
    is_general = lens.bend != 0.0 or z + radius > lens.nearest
    rays = _row_of(balls, sphere, row, lens)
    left = (0.5 - lens.x) * pixel - rays.x
    limit = rays.square - rays.offset * rays.offset
    for run in range(low // RUN_LENGTH, (high + RUN_LENGTH - 1) // RUN_LENGTH):
        if bound[row, run] >= front:
            continue
        first = max(low, run * RUN_LENGTH)
        last = min(high, (run + 1) * RUN_LENGTH)
        if is_general:
            _perspective_run(sphere, row, first, last, rays, lens, depth, ids)
        else:
            _parallel_run(sphere, row, first, last, left, pixel, limit, z, depth, ids)
        end = min((run + 1) * RUN_LENGTH, width)
        bound[row, run] = _least(depth, row, run * RUN_LENGTH, end)


@njit(cache=True, error_model="numpy", forceinline=True)
def _least(values: Floats, row: int, first: int, end: int) -> float:
    """Return the least value of a row from column `first` to `end`."""
    least = math.inf
    for column in range(first, end):
        least = values[row, column] if values[row, column] < least else least
    return least


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
        box = _sphere_box(balls, sphere, lens, width, height)
        for row in range(box.top, box.bottom):
            rays = _row_of(balls, sphere, row, lens)
            for column in range(box.left, box.right):
                ray = _cast((column + 0.5 - lens.x) * pixel, rays)
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
