"""Putting a picture together from its layers, pixel by pixel. Pictures are (height, width, 3) of 0
to 255."""

from __future__ import annotations

import math

from workbench.compiled import njit
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["blend_overlays", "compose_solids", "darken_rims"]


@njit(cache=True)
def compose_solids(
    wall: Floats,
    body: Ints,
    layers: tuple[Ints, Floats, Bools, Ints, Floats],
    fade: Floats,
    veil: float,
    picture: Floats,
) -> None:
    """Walls, paler the farther they are, and bodies over them, behind a veil of what stands in
    front.

    wall (T + 2, 3): colour of each triangle, then that of cut faces, then paper. layers: triangle,
    depth, section, sphere, body_depth, each (height, width), -1 or -inf for nothing. fade (3,): the
    depth [m] from which walls fade, over how much they do, and the share of paper that is never
    exceeded. body (height, width, 3): read where a sphere is. veil: opacity of what is in front of
    a body.
    """
    triangle, depth, section, sphere, body_depth = layers
    height, width = triangle.shape
    paper = len(wall) - 1
    cut = len(wall) - 2
    for row in range(height):
        for column in range(width):
            number = triangle[row, column]
            here = sphere[row, column] >= 0
            front = veil if here and depth[row, column] > body_depth[row, column] else 0.0
            share = 0.0
            source = paper
            if section[row, column]:
                source = cut
            elif number >= 0:
                source = number
                share = min(max((fade[0] - depth[row, column]) / fade[1], 0.0), 1.0) * fade[2]
            for k in range(3):
                value = wall[source, k] + (wall[paper, k] - wall[source, k]) * share
                if here:
                    value = value * front + body[row, column, k] * (1.0 - front)
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
    """Glass where it is the foremost thing, then lines in ink, into `out` (height, width, 3) of
    whole numbers.

    tinted (height, width): -1 without glass; lines (height, width): opacity of ink, 0 to 255. inks
    (2, 4): colour and opacity of glass, colour of lines.
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
def darken_rims(body: Floats, depth: Floats, width: int, jump: float, share: float) -> None:
    """Multiply `body` (height, width, 3) by `share` within `width` pixels of a place that lies
    `jump` [m] farther.

    That is a silhouette, or a limb before the trunk. depth (height, width): of bodies, -inf where
    there are none.
    """
    height, across = depth.shape
    for row in range(height):
        for column in range(across):
            least = depth[row, column] - jump
            if least == -math.inf:
                continue
            rim = False
            for step in range(1, width + 1):
                rim = rim or (column >= step and depth[row, column - step] < least)
                rim = rim or (column + step < across and depth[row, column + step] < least)
                rim = rim or (row >= step and depth[row - step, column] < least)
                rim = rim or (row + step < height and depth[row + step, column] < least)
            if rim:
                for k in range(3):
                    body[row, column, k] *= share
