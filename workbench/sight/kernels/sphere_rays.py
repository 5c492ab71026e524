"""Find the foremost sphere surface in every pixel, as a ray caster would.

Spheres are in view coordinates, see `Lens`; the last is the depth. The ray through a
pixel passes q (1 - bend z) at depth z, where q is the pixel's position at depth 0. With e the
distance of the ray from a sphere's centre at the centre's depth and s = -bend q its slope, it meets
the surface z' in front of the centre where

    (1 + s^2) z' = -s . e + sqrt(r^2 (1 + s^2) - e^2 - (e x s)^2).

A parallel view has s = 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from workbench.compiled import njit
from workbench.model.arrays import Floats, Ints

__all__ = ["RUN_LENGTH", "Lens", "Ray", "Row", "cast", "row_of", "sphere_box", "surface_depths"]

RUN_LENGTH = 16
"""Pixels of a row that share one bound of depth."""


class Lens(NamedTuple):
    """A camera as the kernels take it.

    View coordinates are metres to the right, up and toward the viewer from the camera's centre.
    """

    axes: Floats
    """(4, 3) unit vectors right, up and toward the viewer, and the centre [m]."""
    scale: float
    """Pixels per metre at depth 0."""
    bend: float
    """1 / distance of the eye [1/m], 0 in a parallel view."""
    x: float
    """Middle of the picture [pixels]."""
    y: float
    nearest: float
    """Largest depth [m] that is drawn."""
    distance: float
    """Depth of the eye [m], infinite in a parallel view."""


class Box(NamedTuple):
    """First column and row of a block of pixels, and one past the last."""

    left: int
    top: int
    right: int
    bottom: int


class Row(NamedTuple):
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


class Ray(NamedTuple):
    """How a ray meets a sphere: z' = z + (middle +- sqrt(rest)) / whole; rest < 0: not at all."""

    rest: float
    middle: float
    whole: float
    """1 + s^2."""


@njit(cache=True)
def _tangent(angle: float) -> float:
    """Return the tangent of an angle [rad] from straight ahead, infinite from the side on."""
    if abs(angle) < math.pi / 2.0:
        return math.tan(angle)
    return math.inf if angle > 0.0 else -math.inf


@njit(cache=True)
def _extent(across: float, along: float, radius: float) -> tuple[float, float]:
    """Return the least and greatest across / along, before the eye, of a sphere seen from the origin.

    One is infinite where the sphere reaches beside the eye on that side; both where the eye is
    inside in this plane. Where the sphere is behind the eye both are the same infinity.
    """
    if along <= radius:
        distance = math.hypot(across, along)
        if distance <= radius:
            return -math.inf, math.inf
        # tangents at atan2(across, along) -+ asin(radius / distance) from straight ahead
        middle = math.atan2(across, along)
        half = math.asin(radius / distance)
        return _tangent(middle - half), _tangent(middle + half)
    square = along * along - radius * radius
    root = radius * math.sqrt(max(across * across + square, 0.0))
    return (across * along - root) / square, (across * along + root) / square


@njit(cache=True)
def sphere_box(balls: Floats, sphere: int, lens: Lens, width: int, height: int) -> Box:
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
    return Box(
        math.floor(_clamp(lens.x + lens.scale * left - 1.0, width)),
        math.floor(_clamp(lens.y - lens.scale * high - 1.0, height)),
        math.ceil(_clamp(lens.x + lens.scale * right + 1.0, width)),
        math.ceil(_clamp(lens.y - lens.scale * low + 1.0, height)),
    )


@njit(cache=True)
def _clamp(value: float, largest: int) -> float:
    return min(max(value, 0.0), largest)


@njit(cache=True, error_model="numpy", forceinline=True)
def row_of(balls: Floats, sphere: int, row: int, lens: Lens) -> Row:
    """Prepare the rays of a row for a sphere of balls (S, 4)."""
    z = balls[sphere, 2]
    radius = balls[sphere, 3]
    qy = (lens.y - row - 0.5) * (1.0 / lens.scale)
    shrink = 1.0 - lens.bend * z
    slope = -lens.bend * qy
    offset = qy * shrink - balls[sphere, 1]
    return Row(balls[sphere, 0], z, radius * radius, lens.bend, shrink, slope, offset)


@njit(cache=True, error_model="numpy", forceinline=True)
def cast(qx: float, row: Row) -> Ray:
    """Cast the ray at the horizontal position qx [m]; the formula of this module."""
    sx = -row.bend * qx
    ex = qx * row.shrink - row.x
    whole = 1.0 + sx * sx + row.slope * row.slope
    cross = ex * row.slope - row.offset * sx
    rest = row.square * whole - ex * ex - row.offset * row.offset - cross * cross
    return Ray(rest, -(sx * ex + row.slope * row.offset), whole)


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
    number: int, row: int, first: int, end: int, rays: Row, lens: Lens, depth: Floats, ids: Ints
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
        ray = cast(left + pixel * k, rays)
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
        box = sphere_box(balls, sphere, lens, width, height)
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
    box: Box,
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
    rays = row_of(balls, sphere, row, lens)
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
