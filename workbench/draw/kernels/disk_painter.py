"""Paint spheres as disks, as in the paper, at the speed of a film: project, sort, paint."""

from __future__ import annotations

import math
from typing import NamedTuple

from workbench.compiled import njit
from workbench.model.arrays import Floats, Ints
from workbench.sight.kernels.sphere_rays import Lens

__all__ = [
    "Projection",
    "disk_span",
    "paint_disks",
    "project_spheres",
    "sphere_depths",
    "update_depth_order",
]


class Projection(NamedTuple):
    """Disks of S spheres."""

    balls: Floats
    """(S, 4) [m] view coordinates of the centre, and the radius."""
    shown: Floats
    """(S, 2) [m] depth and radius of what the disk shows: the centre's, or those of the face where
    the nearest plane cuts the sphere."""
    disk: Floats
    """(S, 3) x, y, radius [pixels]; 0 for a sphere that is not drawn."""
    front: Floats
    """(S,) depth [m] of the frontmost point; -inf for a sphere that is not drawn."""


@njit(cache=True)
def project_spheres(centre: Floats, radius: Floats, lens: Lens, out: Projection) -> int:
    """Project spheres to disks.

    The disk is the paper's circle about the image of the centre. Its radius is in inverse
    proportion to the distance of the centre along the view. Where the nearest plane takes the
    centre, the disk is that of the cut face. Spheres that hold the eye, or that are all cut away,
    are not drawn.

    Parameters
    ----------
    centre, radius
        (S, 3) and (S,) [m].
    lens
        The camera.
    out
        Filled in place.

    Returns
    -------
    int
        How many spheres are drawn.
    """
    drawn = 0
    for s in range(len(radius)):
        _to_view(centre, radius, s, lens.axes, out.balls)
        drawn += _project_sphere(s, lens, out)
    return drawn


@njit(cache=True)
def _to_view(centre: Floats, radius: Floats, s: int, axes: Floats, balls: Floats) -> None:
    """Write the view coordinates and the radius of sphere s; axes: as of `Lens`."""
    x = 0.0
    y = 0.0
    z = 0.0
    for k in range(3):
        offset = centre[s, k] - axes[3, k]
        x = x + axes[0, k] * offset
        y = y + axes[1, k] * offset
        z = z + axes[2, k] * offset
    balls[s, 0] = x
    balls[s, 1] = y
    balls[s, 2] = z
    balls[s, 3] = radius[s]


@njit(cache=True)
def _project_sphere(s: int, lens: Lens, out: Projection) -> int:
    """Project sphere s from its view coordinates; returns 1, or 0 where it is not drawn."""
    x = out.balls[s, 0]
    y = out.balls[s, 1]
    z = out.balls[s, 2]
    size = out.balls[s, 3]
    behind_eye = lens.distance - z
    holds_eye = lens.bend > 0.0 and x * x + y * y + behind_eye * behind_eye <= size * size
    beyond = max(z - lens.nearest, 0.0)  # how far the centre is cut away
    if holds_eye or not beyond < size:
        out.disk[s, 0] = 0.0
        out.disk[s, 1] = 0.0
        out.disk[s, 2] = 0.0
        out.shown[s, 0] = min(z, lens.nearest)
        out.shown[s, 1] = 0.0
        out.front[s] = -math.inf
        return 0
    out.front[s] = min(z + size, lens.nearest)
    if beyond > 0.0:
        size = math.sqrt(size * size - beyond * beyond)
        z = lens.nearest
    scale = lens.scale / (1.0 - z * lens.bend)
    out.shown[s, 0] = z
    out.shown[s, 1] = size
    out.disk[s, 0] = lens.x + scale * x
    out.disk[s, 1] = lens.y - scale * y
    out.disk[s, 2] = scale * size
    return 1


@njit(cache=True)
def update_depth_order(order: Ints, front: Floats) -> int:
    """Sort spheres back to front by insertion, which is fast from the order of the frame before.

    Parameters
    ----------
    order
        (S,) sorted in place. Of equal fronts the lower number comes first.
    front
        (S,) depths of the frontmost points.

    Returns
    -------
    int
        How many times one sphere was moved by one place.
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
    """Return the first column of a disk in a row, and one past the last.

    The first is not below the second where there is none.

    Parameters
    ----------
    row, x, y, radius
        The row, and the disk [pixels].
    width
        Of the picture.
    """
    # The square root gives the ends to within rounding. The last steps use the predicate that
    # defines the disk, so that spans and a test of each pixel agree on every pixel.
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


@njit(cache=True, error_model="numpy", forceinline=True)
def _fill(line: Ints, first: int, end: int, value: int, blank: int) -> None:
    """Write `value` into the pixels of a row that are still `blank`."""
    for column in range(first, end):
        if line[column] == blank:
            line[column] = value


@njit(cache=True, error_model="numpy", forceinline=True)
def _paint_span(line: Ints, runs: Ints, first: int, end: int, value: int, blank: int) -> None:
    """Paint the columns from `first` to `end` of a row where nothing was painted.

    runs: (4,) from and to of two runs of columns that are known to be painted. One that the span
    meets is extended; otherwise the span replaces the shorter run, if that is shorter still.
    """
    a = runs[0]
    b = runs[1]
    c = runs[2]
    d = runs[3]
    if end >= a and first <= b:
        _fill(line, first, a, value, blank)
        _fill(line, b, end, value, blank)
        runs[0] = min(first, a)
        runs[1] = max(end, b)
    elif end >= c and first <= d:
        _fill(line, first, c, value, blank)
        _fill(line, d, end, value, blank)
        runs[2] = min(first, c)
        runs[3] = max(end, d)
    else:
        _fill(line, first, end, value, blank)
        slot = 0 if b - a < d - c else 2
        if end - first > runs[slot + 1] - runs[slot]:
            runs[slot] = first
            runs[slot + 1] = end


@njit(cache=True, error_model="numpy", forceinline=True)
def _is_painted(covered: Ints, row: int, first: int, end: int) -> bool:
    """Whether a run of columns lies in one of those that are known to be painted."""
    return (covered[row, 0] <= first and covered[row, 1] >= end) or (
        covered[row, 2] <= first and covered[row, 3] >= end
    )


@njit(cache=True)
def paint_disks(
    disk: Floats, order: Ints, value: Ints, blank: int, picture: Ints, covered: Ints
) -> None:
    """Paint disks over one another: each pixel gets the value of the last disk that holds it.

    Disks are painted from the last to the first, and each pixel once.

    Parameters
    ----------
    disk
        (S, 3) x, y, radius [pixels].
    order
        (K,) the disks in painter's order.
    value, blank
        (S,) what is written for each disk, and what the picture comes filled with. No value may
        equal `blank`.
    picture
        (height, width) filled in place.
    covered
        (height, 4) working space: two runs of columns of each row, from and to, that are known to
        be painted. Most disks fall inside them.
    """
    height, width = picture.shape
    covered[:] = 0
    for n in range(len(order) - 1, -1, -1):
        sphere = order[n]
        x = disk[sphere, 0]
        y = disk[sphere, 1]
        radius = disk[sphere, 2]
        left = max(math.floor(x - radius), 0)
        right = min(math.ceil(x + radius), width)
        if left >= right:
            continue
        for row in range(max(0, math.floor(y - radius)), min(height, math.ceil(y + radius))):
            if _is_painted(covered, row, left, right):
                continue
            first, end = disk_span(row, x, y, radius, width)
            if first < end and not _is_painted(covered, row, first, end):
                _paint_span(picture[row], covered[row], first, end, value[sphere], blank)


@njit(cache=True)
def sphere_depths(disks: Floats, centre: Floats, radius: Floats, depth: Floats) -> None:
    """Rasterize spheres that are seen as disks.

    Parameters
    ----------
    disks
        (S, 3) x, y, radius [pixels].
    centre, radius
        (S,) depth of the centre and radius [m].
    depth
        (height, width) depth [m] of the foremost surface, filled in place.
    """
    height, width = depth.shape
    for sphere in range(len(disks)):
        x = disks[sphere, 0]
        y = disks[sphere, 1]
        size = disks[sphere, 2]
        metre = radius[sphere] / size
        for row in range(
            max(0, math.floor(y - size - 0.5)), min(height, math.ceil(y + size + 0.5))
        ):
            first, end = disk_span(row, x, y, size, width)
            dy = row + 0.5 - y
            for column in range(first, end):
                dx = column + 0.5 - x
                front = centre[sphere] + metre * math.sqrt(
                    max(0.0, size * size - dx * dx - dy * dy)
                )
                if front > depth[row, column]:
                    depth[row, column] = front
