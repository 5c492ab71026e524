"""Compose a picture from its layers, pixel by pixel.

Pictures are (height, width, 3) of 0 to 255.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["SolidLayers", "blend_overlays", "compose_solids", "darken_rims"]


class SolidLayers(NamedTuple):
    """What is foremost in each pixel, (height, width) each."""

    triangle: NDArray[np.int32]
    """Index of the opaque triangle, -1 for none."""
    depth: Floats
    """Its depth [m], -inf for none."""
    section: Bools
    """Whether it is a cut face."""
    sphere: NDArray[np.int32]
    """Index of the sphere, -1 for none."""
    body_depth: Floats
    """Depth [m] of the spheres, -inf for none."""


@njit(cache=True)
def compose_solids(
    wall: Floats,
    body: Ints,
    layers: SolidLayers,
    fade: Floats,
    veil: float,
    picture: Floats,
) -> None:
    """Compose walls, paler the farther they are, and bodies behind a veil of what is before them.

    Parameters
    ----------
    wall
        (T + 2, 3) colour of each triangle, of cut faces and of paper.
    body
        (height, width, 3) colour of bodies, read where a sphere is.
    layers
        What is foremost.
    fade
        (3,) depth [m] from which walls fade, length [m] over which they do, and the largest share
        of paper.
    veil
        Opacity of what is in front of a body.
    picture
        (height, width, 3) filled in place.
    """
    height, width = layers.triangle.shape
    paper = len(wall) - 1
    cut_face = len(wall) - 2
    for row in range(height):
        for column in range(width):
            depth = layers.depth[row, column]
            is_body = layers.sphere[row, column] >= 0
            wall_share = 0.0  # of the wall, over a body
            if is_body and depth > layers.body_depth[row, column]:
                wall_share = veil
            paper_share = 0.0
            source = paper
            if layers.section[row, column]:
                source = cut_face
            elif layers.triangle[row, column] >= 0:
                source = layers.triangle[row, column]
                paper_share = min(max((fade[0] - depth) / fade[1], 0.0), 1.0) * fade[2]
            for k in range(3):
                value = wall[source, k] + (wall[paper, k] - wall[source, k]) * paper_share
                if is_body:
                    value = value * wall_share + body[row, column, k] * (1.0 - wall_share)
                picture[row, column, k] = value


@njit(cache=True)
def blend_overlays(
    picture: Floats,
    tinted: Ints,
    tint_depth: Floats,
    depth: Floats,
    body_depth: Floats,
    lines: Ints,
    inks: Floats,
    out: Ints,
) -> None:
    """Blend glass over a picture where it is foremost, then lines, and round to integers.

    Parameters
    ----------
    picture
        (height, width, 3).
    tinted, tint_depth
        (height, width) triangle of glass, -1 for none, and its depth [m].
    depth, body_depth
        (height, width) depth [m] of walls and of bodies.
    lines
        (height, width) opacity of ink, 0 to 255.
    inks
        (2, 4) colour and opacity of glass, and colour of lines.
    out
        (height, width, 3) filled in place.
    """
    height, width = lines.shape
    for row in range(height):
        for column in range(width):
            glass = 0.0
            if tinted[row, column] >= 0:
                foremost = max(depth[row, column], body_depth[row, column])
                glass = inks[0, 3] if tint_depth[row, column] > foremost else 0.0
            ink = lines[row, column] / 255.0
            for k in range(3):
                value = picture[row, column, k]
                value += (inks[0, k] - value) * glass
                value += (inks[1, k] - value) * ink
                out[row, column, k] = math.floor(value + 0.5)


@njit(cache=True)
def darken_rims(body: Floats, depth: Floats, width: int, step: float, share: float) -> None:
    """Darken bodies along their silhouettes, and along a limb before the trunk.

    Parameters
    ----------
    body
        (height, width, 3) colours, multiplied in place.
    depth
        (height, width) depth [m] of bodies, -inf for none.
    width
        Distance [pixels], along rows and columns, of a rim from what lies behind it.
    step
        Least step of depth [m].
    share
        Factor of the colours.
    """
    height, across = depth.shape
    for row in range(height):
        for column in range(across):
            behind = depth[row, column] - step
            if behind == -math.inf:
                continue
            rim = False
            for k in range(1, width + 1):
                rim = rim or (column >= k and depth[row, column - k] < behind)
                rim = rim or (column + k < across and depth[row, column + k] < behind)
                rim = rim or (row >= k and depth[row - k, column] < behind)
                rim = rim or (row + k < height and depth[row + k, column] < behind)
            if rim:
                for k in range(3):
                    body[row, column, k] *= share
