"""The surfaces of spheres pixel by pixel: a depth buffer that equals a ray caster, and light on
what it shows.

View coordinates are metres to the right, up and toward the viewer from the camera's centre; the
last is the depth. The ray through a pixel passes q (1 - bend z) at depth z, where q is the pixel's
place at depth 0. With e the ray's distance from a sphere's centre at the centre's depth and s =
-bend q its slope, it meets the surface z' in front of the centre, (1 + s^2) z' = -s . e + sqrt(r^2
(1 + s^2) - e^2 - (e x s)^2). A parallel view has s = 0. lens: see `disk_painter`.
"""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit
from workbench.model.arrays import Floats, Ints

__all__ = ["BLOCK", "light_surfaces", "paint_rays", "surface_depths"]

BLOCK = 16  # pixels of a row that share one bound of depth


@njit(cache=True)
def _ends(across: float, along: float, radius: float) -> tuple[float, float]:
    """Least and greatest across / along of a sphere as seen from the origin; infinite where it
    reaches beside it."""
    if along <= radius:
        return -math.inf, math.inf
    square = along * along - radius * radius
    root = radius * math.sqrt(max(across * across + square, 0.0))
    return (across * along - root) / square, (across * along + root) / square


@njit(cache=True)
def _box(
    x: float, y: float, z: float, radius: float, lens: Floats, width: int, height: int
) -> tuple[int, int, int, int]:
    """First column and row, and one past the last, of the pixels that may show a sphere."""
    if lens[13] == 0.0:
        left = x - radius
        right = x + radius
        low = y - radius
        high = y + radius
    else:
        left, right = _ends(x, lens[17] - z, radius)
        low, high = _ends(y, lens[17] - z, radius)
        left = left * lens[17]
        right = right * lens[17]
        low = low * lens[17]
        high = high * lens[17]
    first = math.floor(min(max(lens[14] + lens[12] * left - 1.0, 0.0), width))
    end = math.ceil(min(max(lens[14] + lens[12] * right + 1.0, 0.0), width))
    top = math.floor(min(max(lens[15] - lens[12] * high - 1.0, 0.0), height))
    bottom = math.ceil(min(max(lens[15] - lens[12] * low + 1.0, 0.0), height))
    return first, top, end, bottom


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
    """Deepen a run of pixels by a sphere: `left` [m] from its centre to column 0, limit r^2 less
    the row's."""
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
    number: int,
    row: int,
    first: int,
    end: int,
    balls: Floats,
    lens: Floats,
    depth: Floats,
    ids: Ints,
) -> None:
    """Deepen a run of pixels by sphere `number`; what is nearer than the nearest plane is cut."""
    x = balls[number, 0]
    y = balls[number, 1]
    z = balls[number, 2]
    radius = balls[number, 3]
    pixel = 1.0 / lens[12]
    bend = lens[13]
    nearest = lens[16]
    line = depth[row, first:end]
    names = ids[row, first:end]
    left = (first + 0.5 - lens[14]) * pixel
    qy = (lens[15] - row - 0.5) * pixel
    shrink = 1.0 - bend * z
    sy = -bend * qy
    ey = qy * shrink - y
    for k in range(len(line)):
        qx = left + pixel * k
        sx = -bend * qx
        ex = qx * shrink - x
        whole = 1.0 + sx * sx + sy * sy
        cross = ex * sy - ey * sx
        rest = radius * radius * whole - ex * ex - ey * ey - cross * cross
        root = math.sqrt(rest if rest > 0.0 else 0.0)
        middle = -(sx * ex + sy * ey)
        front = z + (middle + root) / whole
        back = z + (middle - root) / whole
        front = front if front < nearest else nearest
        better = (rest >= 0.0) & (front > line[k]) & (back < nearest)
        line[k] = front if better else line[k]
        names[k] = number if better else names[k]


@njit(cache=True)
def surface_depths(
    balls: Floats, order: Ints, lens: Floats, depth: Floats, ids: Ints, bound: Floats
) -> None:
    """Depth [m] of the foremost sphere surface in every pixel, and the sphere's number, into
    `depth` and `ids`.

    balls (S, 4): view coordinates and radius [m] of whole spheres; drawn are those of `order` (K,),
    back to front. Beyond the nearest plane the cut face shows. depth, ids (height, width) hold the
    background; bound (height, columns / BLOCK rounded up) -inf. Nearest spheres are drawn first;
    where all pixels of a block are nearer than a sphere's foremost point in their row, it is passed
    over.
    """
    height, width = depth.shape
    nearest = lens[16]
    bend = lens[13]
    pixel = 1.0 / lens[12]
    for n in range(len(order) - 1, -1, -1):
        sphere = order[n]
        x = balls[sphere, 0]
        y = balls[sphere, 1]
        z = balls[sphere, 2]
        radius = balls[sphere, 3]
        first, top, end, bottom = _box(x, y, z, radius, lens, width, height)
        general = bend != 0.0 or z + radius > nearest
        left = (0.5 - lens[14]) * pixel - x
        for row in range(top, bottom):
            off = (lens[15] - row - 0.5) * pixel - y
            limit = radius * radius - off * off
            front = z + radius
            low = first
            high = end
            if bend == 0.0:
                if limit < 0.0:
                    continue
                half = math.sqrt(limit)
                front = z + half
                low = max(first, math.floor(lens[14] + lens[12] * (x - half) - 1.0))
                high = min(end, math.ceil(lens[14] + lens[12] * (x + half) + 1.0))
            for block in range(low // BLOCK, (high + BLOCK - 1) // BLOCK):
                if bound[row, block] >= front:
                    continue
                a = max(low, block * BLOCK)
                b = min(high, (block + 1) * BLOCK)
                if general:
                    _perspective_run(sphere, row, a, b, balls, lens, depth, ids)
                else:
                    _parallel_run(sphere, row, a, b, left, pixel, limit, z, depth, ids)
                bound[row, block] = _least(
                    row, block * BLOCK, min((block + 1) * BLOCK, width), depth
                )


@njit(cache=True)
def _least(row: int, first: int, end: int, depth: Floats) -> float:
    least = math.inf
    for column in range(first, end):
        least = depth[row, column] if depth[row, column] < least else least
    return least


@njit(cache=True)
def paint_rays(balls: Floats, order: Ints, lens: Floats, value: Ints, picture: Ints) -> None:
    """A painter's disks by their exact outlines: later spheres of `order` cover earlier ones
    wherever a ray meets them.

    balls, order, lens as for `surface_depths`; value (S,) goes into picture (height, width).
    """
    height, width = picture.shape
    nearest = lens[16]
    bend = lens[13]
    pixel = 1.0 / lens[12]
    for sphere in order:
        x = balls[sphere, 0]
        y = balls[sphere, 1]
        z = balls[sphere, 2]
        radius = balls[sphere, 3]
        first, top, end, bottom = _box(x, y, z, radius, lens, width, height)
        shrink = 1.0 - bend * z
        for row in range(top, bottom):
            qy = (lens[15] - row - 0.5) * pixel
            sy = -bend * qy
            ey = qy * shrink - y
            for column in range(first, end):
                qx = (column + 0.5 - lens[14]) * pixel
                sx = -bend * qx
                ex = qx * shrink - x
                whole = 1.0 + sx * sx + sy * sy
                cross = ex * sy - ey * sx
                rest = radius * radius * whole - ex * ex - ey * ey - cross * cross
                if rest >= 0.0 and z - (sx * ex + sy * ey + math.sqrt(rest)) / whole < nearest:
                    picture[row, column] = value[sphere]


@njit(cache=True)
def _normal(
    row: int, column: int, depth: float, grow: float, sphere: int, balls: Floats, lens: Floats
) -> tuple[float, float, float]:
    """Unit normal of a sphere at a pixel of that depth; straight at the viewer on a face that is
    cut."""
    if depth >= lens[16]:
        return 0.0, 0.0, 1.0
    inverse = 1.0 / balls[sphere, 3]
    x = ((column + 0.5 - lens[14]) * grow - balls[sphere, 0]) * inverse
    y = ((lens[15] - row - 0.5) * grow - balls[sphere, 1]) * inverse
    return x, y, max((depth - balls[sphere, 2]) * inverse, 0.05)


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


@njit(cache=True)
def _taps(balls: Floats, lens: Floats, reach: float) -> tuple[Ints, Floats]:
    """Where ambient light is asked for round a pixel of each sphere: (S, 8, 2) pixels right and
    down; (S, 8) 1 / [m].

    Four places lie `reach` [m] away and four half as far, at least 2 pixels and 1.
    """
    offset = np.empty((len(balls), 8, 2), np.int64)
    inverse = np.empty((len(balls), 8))
    for sphere in range(len(balls)):
        grow = (1.0 - lens[13] * balls[sphere, 2]) / lens[12]  # [m] a pixel
        far = min(max(reach / grow, 2.0), 1e6)
        for k in range(8):
            step = far if k < 4 else 0.5 * far
            offset[sphere, k, 0] = math.floor(_TAPS[k][0] * step + 0.5)
            offset[sphere, k, 1] = -math.floor(_TAPS[k][1] * step + 0.5)
            inverse[sphere, k] = 1.0 / (step * grow)
    return offset, inverse


@njit(cache=True)
def _shade(
    row: int,
    column: int,
    sphere: int,
    normal: tuple[float, float, float],
    grow: float,
    depth: Floats,
    offset: Ints,
    inverse: Floats,
) -> float:
    """Share of ambient light at a pixel: what stands above its tangent plane at 8 places around
    takes some of it.

    Most where it rises as much as it is away; steps of twice that and more are other limbs and take
    nothing.
    """
    height, width = depth.shape
    (nx, ny, nz), here, dark = normal, depth[row, column], 0.0
    slope_x = nx * grow
    slope_y = ny * grow  # [m], times nz: the tangent plane falls a pixel to the right, and up
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
    return 1.0 - min(0.11 * dark, 0.75)


@njit(cache=True)
def light_surfaces(
    balls: Floats,
    colour: Floats,
    light: Floats,
    lens: Floats,
    reach: float,
    depth: Floats,
    ids: Ints,
    picture: Ints,
) -> None:
    """Soft light from `light` (3,), a unit vector in view coordinates, and ambient shade in
    creases.

    colour (S, 3): 0 to 255, of each sphere in full light; picture (height, width, 3) is written
    where ids are not -1.
    """
    height, width = ids.shape
    offset, inverse = _taps(balls, lens, reach)
    for row in range(height):
        for column in range(width):
            sphere = ids[row, column]
            if sphere < 0:
                continue
            here = depth[row, column]
            grow = (1.0 - lens[13] * here) / lens[12]
            nx, ny, nz = _normal(row, column, here, grow, sphere, balls, lens)
            soft = 0.5 + 0.5 * (nx * light[0] + ny * light[1] + nz * light[2])
            lit = 0.42 + 0.58 * soft * soft
            lit *= _shade(row, column, sphere, (nx, ny, nz), grow, depth, offset, inverse)
            for k in range(3):
                picture[row, column, k] = int(colour[sphere, k] * lit + 0.5)
