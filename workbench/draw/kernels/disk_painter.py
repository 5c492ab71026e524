"""The paper's raster display at the speed of a film: projection, order, painting. One picture,
three loops.

A lens (18,) packs a camera: right, up, toward and centre, three numbers each; then scale [pixels /
m], bend [1/m], the picture's middle x and y [pixels], the nearest depth that is drawn and the eye's
distance [m].
"""

from __future__ import annotations

import math

from workbench.compiled import njit
from workbench.model.arrays import Floats, Ints

__all__ = ["disk_span", "paint_disks", "project_spheres", "update_depth_order"]


@njit(cache=True)
def project_spheres(
    centre: Floats,
    radius: Floats,
    lens: Floats,
    view: Floats,
    shown: Floats,
    disk: Floats,
    front: Floats,
) -> int:
    """Spheres centre (S, 3), radius (S,) [m] to their disks; how many are drawn.

    view (S, 4) [m]: to the right, up and toward the viewer; and the radius. disk (S, 3): x, y,
    radius [pixels]: the paper's circle, in inverse proportion to the distance of the centre along
    the view. front (S,) [m]: the depth of the frontmost point. What the nearest plane cuts ends
    there: the disk of a sphere that loses its centre is that of the cut face. shown (S, 2) [m]:
    depth and radius of what the disk shows, the centre's or the face's. Spheres that hold the eye,
    or are all cut away, have disk 0 and front -inf.
    """
    nearest = lens[16]
    distance = lens[17]
    drawn = 0
    for s in range(len(radius)):
        x = 0.0
        y = 0.0
        z = 0.0
        size = radius[s]
        holds = False
        for k in range(3):
            away = centre[s, k] - lens[9 + k]
            x = x + lens[k] * away
            y = y + lens[3 + k] * away
            z = z + lens[6 + k] * away
        view[s, 0] = x
        view[s, 1] = y
        view[s, 2] = z
        view[s, 3] = size
        if lens[13] > 0.0:
            holds = x * x + y * y + (distance - z) * (distance - z) <= size * size
        beyond = max(z - nearest, 0.0)
        if holds or not beyond < size:
            disk[s, 0] = disk[s, 1] = disk[s, 2] = shown[s, 1] = 0.0
            front[s], shown[s, 0] = -math.inf, min(z, nearest)
            continue
        front[s] = min(z + size, nearest)
        if beyond > 0.0:
            size = math.sqrt(size * size - beyond * beyond)
            z = nearest
        scale = lens[12] / (1.0 - z * lens[13])
        shown[s, 0] = z
        shown[s, 1] = size
        disk[s, 0] = lens[14] + scale * x
        disk[s, 1] = lens[15] - scale * y
        disk[s, 2] = scale * size
        drawn += 1
    return drawn


@njit(cache=True)
def update_depth_order(order: Ints, front: Floats) -> int:
    """Sort `order` (S,) in place back to front, by insertion; how many times one sphere was moved
    by one place.

    Of equal fronts (S,) the lower number comes first. From the order of a frame before, n spheres
    take a few n moves.
    """
    moves = 0
    for k in range(1, len(order)):
        moved = order[k]
        place = k
        depth = front[moved]
        while place > 0:
            before = order[place - 1]
            if front[before] < depth or (front[before] == depth and before < moved):
                break
            order[place] = before
            place -= 1
        order[place] = moved
        moves += k - place
    return moves


@njit(cache=True)
def disk_span(row: int, x: float, y: float, radius: float, width: int) -> tuple[int, int]:
    """First and one past the last column of a disk in a row; the first is not below the second
    where there is none.

    The square root gives the ends to within rounding; the last steps use the very predicate that
    defines the disk, so that spans and a pixel-by-pixel test agree on every pixel.
    """
    dy = row + 0.5 - y
    square = dy * dy
    limit = radius * radius
    if square > limit:
        return 0, 0
    half = math.sqrt(limit - square)
    first = math.ceil(x - half - 0.5)
    last = math.floor(x + half - 0.5)
    if (first - 0.5 - x) * (first - 0.5 - x) + square <= limit:
        first -= 1
    elif (first + 0.5 - x) * (first + 0.5 - x) + square > limit:
        first += 1
    if (last + 1.5 - x) * (last + 1.5 - x) + square <= limit:
        last += 1
    elif (last + 0.5 - x) * (last + 0.5 - x) + square > limit:
        last -= 1
    return max(first, 0), min(last + 1, width)


@njit(cache=True)
def _fill(line: Ints, first: int, end: int, value: int, blank: int) -> None:
    for column in range(first, end):
        if line[column] == blank:
            line[column] = value


@njit(cache=True)
def paint_disks(
    disk: Floats, order: Ints, value: Ints, blank: int, picture: Ints, covered: Ints
) -> None:
    """What a painter sees who lays disks (S, 3) x, y, radius [pixels] over one another in `order`
    (K,).

    Each pixel gets the `value` (S,) of the last disk that holds its centre; picture (height, width)
    comes filled with `blank`, which no value may equal. Painted from the last disk to the first,
    each pixel once: covered (height, 4) holds two runs of columns of each row, from and to, that
    are known to be painted, and most disks fall inside.
    """
    height, width = picture.shape
    covered[:] = 0
    for n in range(len(order) - 1, -1, -1):
        sphere = order[n]
        x = disk[sphere, 0]
        y = disk[sphere, 1]
        radius = disk[sphere, 2]
        colour = value[sphere]
        left = max(math.floor(x - radius), 0)
        right = min(math.ceil(x + radius), width)
        if left >= right:
            continue
        for row in range(max(0, math.floor(y - radius)), min(height, math.ceil(y + radius))):
            a = covered[row, 0]
            b = covered[row, 1]
            c = covered[row, 2]
            d = covered[row, 3]
            if (a <= left and b >= right) or (c <= left and d >= right):
                continue
            first, end = disk_span(row, x, y, radius, width)
            if first >= end or (a <= first and b >= end) or (c <= first and d >= end):
                continue
            line = picture[row]
            if end >= a and first <= b:
                _fill(line, first, a, colour, blank)
                _fill(line, b, end, colour, blank)
                covered[row, 0], covered[row, 1] = min(first, a), max(end, b)
            elif end >= c and first <= d:
                _fill(line, first, c, colour, blank)
                _fill(line, d, end, colour, blank)
                covered[row, 2], covered[row, 3] = min(first, c), max(end, d)
            else:
                _fill(line, first, end, colour, blank)
                slot = 0 if b - a < d - c else 2
                if end - first > covered[row, slot + 1] - covered[row, slot]:
                    covered[row, slot] = first
                    covered[row, slot + 1] = end
