"""Fill bands of rows of the faces of a cube about an eye, and add up what is in them.

A band is small enough to stay in the cache of a processor between the passes over it. Depths are
1 / t [1/m], t being the distance along the middle of the face: linear across the picture of a plane.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit
from workbench.model.arrays import Bools, Floats, Ints
from workbench.sight.kernels.rasterization import Fragments, fill_triangles
from workbench.sight.kernels.sphere_rays import RUN_LENGTH, Lens, surface_depths

__all__ = ["FaceShapes", "Items", "Pixels", "Sums", "add_bands", "fill_bands"]


Items = NDArray[np.int32]


class FaceShapes(NamedTuple):
    """What is before one face of n x n pixels.

    opaque (K, 3, 3), opaque_item (K,): columns and rows [pixels] and depths of the corners of
    triangles, and their items; clear (C, 3, 3), clear_item (C,): the same of see-through ones. balls
    (S, 4): spheres in view coordinates, see `Lens`, the eye being 1 m from their origin; order: those
    that may be seen, the nearest last; ball_item (S,).
    """

    opaque: Floats
    opaque_item: Ints
    clear: Floats
    clear_item: Ints
    balls: Floats
    order: Ints
    ball_item: Ints


class Scratch(NamedTuple):
    """Pictures of a band that are overwritten: depths (H, n), and bounds of runs of pixels."""

    depth: Floats
    clear_depth: Floats
    bound: Floats
    cut: Bools


@njit(cache=True)
def fill_band(shapes: FaceShapes, first: int, scratch: Scratch, item: Items, glass: Items) -> None:
    """Fill a band of a face.

    Parameters
    ----------
    shapes
        What is before the face.
    first
        Its row that is the first of the band.
    scratch
        Overwritten.
    item, glass
        (H, n) filled with the opaque item in each pixel, and the see-through one before it; -1 for
        none. A glass of no rows is left out.
    """
    height, n = item.shape
    depth = scratch.depth[:height]
    bound = scratch.bound[:height]
    item[:] = -1
    depth[:] = 0.0
    half = n / 2.0
    if len(shapes.order):
        depth[:] = -math.inf
        bound[:] = -math.inf
        lens = Lens(shapes.balls, half, 1.0, half, half - first, 1.0, 1.0)
        surface_depths(shapes.balls, shapes.order, lens, depth, item, bound)
        for row in range(height):
            for column in range(n):
                depth[row, column] = 1.0 / (1.0 - depth[row, column])
                if item[row, column] >= 0:
                    item[row, column] = shapes.ball_item[item[row, column]]
    out = Fragments(depth, item, scratch.cut, first)
    fill_triangles(shapes.opaque, shapes.opaque_item, 0.0, math.inf, out)
    glass[:] = -1
    if len(glass) and len(shapes.clear):
        before = scratch.clear_depth[:height]
        before[:] = depth
        through = Fragments(before, glass, scratch.cut, first)
        fill_triangles(shapes.clear, shapes.clear_item, 0.0, math.inf, through)


@njit(cache=True, nogil=True)
def fill_bands(
    shapes: FaceShapes, begin: int, end: int, height: int, item: Items, glass: Items
) -> None:
    """Fill the rows from `begin` to `end` of a face of n x n pixels, (end - begin, n) items and
    see-through items, band by band; these may be of no rows, if nobody asks for them.

    height: rows of a band.
    """
    n = item.shape[1]
    scratch = _scratch(height, n)
    for first in range(begin, end, height):
        rows = slice(first - begin, min(first + height, end) - begin)
        fill_band(shapes, first, scratch, item[rows], glass[rows])


@njit(cache=True)
def _scratch(height: int, n: int) -> Scratch:
    """Pictures that are overwritten."""
    return Scratch(
        np.empty((height, n)),
        np.empty((height, n)),
        np.empty((height, (n + RUN_LENGTH - 1) // RUN_LENGTH)),
        np.empty((0, 0), dtype=np.bool_),
    )


class Sums(NamedTuple):
    """What is added up; of N + 2 items the first is none, the last stands for what does not count.

    opaque, clear (N + 2, 3) [sr]: by the first opaque and see-through item: left eye, right eye, both
    the same. free (2,) [sr]: where one eye at least meets nothing opaque, and where both do. border
    (N + 2,) [sr]: pixels on both sides of borders between opaque items, of both eyes.
    """

    opaque: Floats
    clear: Floats
    free: Floats
    border: Floats


class Pixels(NamedTuple):
    """The n x n pixels of a face.

    weight (n, n) [sr]; before (n, n + 1): sums of the weights of a row to the left of each pixel;
    inside (n, n): those that count, (0, 0) where all do.
    """

    weight: Floats
    before: Floats
    inside: Bools


_Rows = tuple[Items, Items, Items, Items]
"""A row of pictures: opaque items of the left and the right eye, see-through ones of both."""


@njit(cache=True, nogil=True)
def add_bands(
    left: FaceShapes,
    right: FaceShapes,
    begin: int,
    end: int,
    height: int,
    pixels: Pixels,
    sums: Sums,
) -> None:
    """Add up what two eyes see in the rows from `begin` to `end` of a face, band by band.

    Parameters
    ----------
    left, right
        What is before the eyes.
    begin, end, height
        As for `fill_bands`.
    pixels
        Of the face.
    sums
        Added to.
    """
    n = len(pixels.weight)
    scratch = _scratch(height + 1, n)
    pictures = np.empty((4 * (height + 1), n), dtype=np.int32)
    changes = np.zeros(n + n % 2, dtype=np.int32)
    for begun in range(begin, end, height):
        last = min(begun + height, end)
        first = max(begun - 1, 0)  # the row above shows the borders between bands
        rows = last - first
        fill_band(left, first, scratch, pictures[:rows], pictures[2 * rows : 3 * rows])
        fill_band(right, first, scratch, pictures[rows : 2 * rows], pictures[3 * rows : 4 * rows])
        if len(pixels.inside):
            _leave_out(pictures[: 4 * rows], pixels.inside[first:last], len(sums.border) - 2)
        for row in range(begun, last):
            line = row - first
            here = (
                pictures[line],
                pictures[rows + line],
                pictures[2 * rows + line],
                pictures[3 * rows + line],
            )
            line = max(line - 1, 0)
            above = pictures[line], pictures[rows + line]
            _changes(here, above, changes)
            _add_row(here, above, row, changes, pixels, sums)


@njit(cache=True)
def _leave_out(pictures: Items, inside: Bools, outside: int) -> None:
    """Write `outside` into the pixels of four pictures, below each other, that do not count."""
    for line in range(len(pictures)):
        picture = pictures[line]
        counts = inside[line % len(inside)]
        for column in range(len(picture)):
            picture[column] = picture[column] if counts[column] else outside


@njit(cache=True)
def _changes(here: _Rows, above: tuple[Items, Items], changes: Items) -> None:
    """Write 0 for pixels of a row of four pictures that show the same as the pixel to the left,
    and in the first two as the pixel above. Bits alone: eight pixels at once."""
    one, two, three, four = here
    one_above, two_above = above
    for column in range(len(one)):
        changes[column] = (one[column] ^ one_above[column]) | (two[column] ^ two_above[column])
    later = changes[1:]
    for column in range(len(one) - 1):
        later[column] |= (
            (one[column] ^ one[column + 1])
            | (two[column] ^ two[column + 1])
            | (three[column] ^ three[column + 1])
            | (four[column] ^ four[column + 1])
        )


@njit(cache=True)
def _add_row(
    here: _Rows,
    above: tuple[Items, Items],
    row: int,
    changes: Ints,
    pixels: Pixels,
    sums: Sums,
) -> None:
    """Add a row run by run; changes: of `_changes`, looked at in pairs."""
    pairs = changes.view(np.int64)
    begin = 0
    for pair in range(len(pairs)):
        if pairs[pair] == 0:
            continue
        for column in range(2 * pair, min(2 * pair + 2, len(here[0]))):
            before = max(column - 1, 0)
            if (
                here[0][column] != here[0][before]
                or here[1][column] != here[1][before]
                or here[2][column] != here[2][before]
                or here[3][column] != here[3][before]
            ):
                _add_run(here, row, begin, column, pixels, sums)
                begin = column
            weight = pixels.weight[row, column]
            for eye in range(2):
                item = here[eye][column]
                _add_border(item, above[eye][column], weight, sums.border)
                _add_border(item, here[eye][before], weight, sums.border)
    _add_run(here, row, begin, len(here[0]), pixels, sums)


@njit(cache=True)
def _add_border(item: int, other: int, weight: float, border: Floats) -> None:
    """Add a pixel between two items to both."""
    if item != other:
        border[item + 1] += weight
        border[other + 1] += weight


@njit(cache=True)
def _add_run(here: _Rows, row: int, begin: int, end: int, pixels: Pixels, sums: Sums) -> None:
    """Add pixels of a row that show the same in each of four pictures."""
    total = pixels.before[row, end] - pixels.before[row, begin]
    left = here[0][begin] + 1
    right = here[1][begin] + 1
    left_clear = here[2][begin] + 1
    right_clear = here[3][begin] + 1
    sums.opaque[left, 0] += total
    sums.opaque[right, 1] += total
    sums.clear[left_clear, 0] += total
    sums.clear[right_clear, 1] += total
    sums.opaque[left, 2] += total if left == right else 0.0
    sums.clear[left_clear, 2] += total if left_clear == right_clear else 0.0
    sums.free[0] += total if left == 0 or right == 0 else 0.0
    sums.free[1] += total if left == 0 and right == 0 else 0.0
