"""Names for the pieces of a part that has been split, by where they are and what shape they have.

A name says the side (left, right), the end (front, rear), the height (upper, lower) and the shape:
`left_front_lower_disc`, `rear_upper_bar`. What reaches across the middle of the whole has no side. The
shape is that of the box, and of the outline where that is round. It is what can be told without
knowing what the thing is; a door is a `left_side_plate`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.files.names import unique_names
from workbench.model.arrays import Floats
from workbench.study.describe.meshes import PlacedMeshes

__all__ = ["named_pieces", "piece_names"]

ENDS = (("rear", "front"), ("right", "left"), ("lower", "upper"))
"""Words for the low and the high end along x, y and z."""
ORDER = (1, 0, 2)
"""The axes in the order in which a name has them."""
FAR = 1.0 / 6.0
"""A piece whose middle is farther from the middle of the whole than this share of its extent is at
an end."""
THIN = 0.25
"""A plate's least extent, as a share of the middle one, at most; a bar's middle one of the largest."""
ROUND = 1.1
"""An outline whose points are at most so many times as far from its middle as its sides is round; a
square's corners are 1.41 times as far."""
EVEN = 1.15
"""Extents of something round differ by less than this factor."""
SMALL = 0.04
"""A piece smaller [m] than this is a small one, whatever its shape."""
MAIN = 0.6
"""A piece of this share of the whole along every axis is its body."""
LARGE = 0.5
"""A level plate of this share of the whole's length and width is a floor or a roof."""


def named_pieces(
    stands: PlacedMeshes, pieces: Sequence[str], *, lead: str = ""
) -> dict[str, list[str]]:
    """Return what joins pieces under names that say where they are: by each new name the piece.

    Parameters
    ----------
    stands
        The meshes in the world.
    pieces
        Names of parts that are pieces; no other part's name is given to one.
    lead
        What each name begins with.
    """
    kept = [name for name in stands.names if name not in pieces]
    points = [stands.points(stands.names.index(name)) for name in pieces]
    called = [lead + name for name in piece_names(points, stands.bounds)]
    names = unique_names([*kept, *called], "piece")[len(kept) :]
    return {new: [old] for new, old in zip(names, pieces, strict=True)}


def piece_names(pieces: Sequence[Floats], whole: Floats) -> list[str]:
    """Return a name for each piece; equal ones are numbered.

    Parameters
    ----------
    pieces
        (V, 3) [m] the vertices of each piece: x forward, y left, z up.
    whole
        (2, 3) [m] the box that says where the middle and the ends are.
    """
    return unique_names((_name(points, whole) for points in pieces), "piece")


def _name(points: Floats, whole: Floats) -> str:
    """The name of one piece, without a number."""
    box = np.array([points.min(axis=0), points.max(axis=0)])
    words = [word for axis in ORDER if (word := _end(box, whole, axis))]
    shape = _shape(points, box, whole)
    if shape in ("floor", "roof"):
        words = [word for word in words if word not in ENDS[2]]
    return "_".join([*words, shape])


def _end(box: Floats, whole: Floats, axis: int) -> str:
    """At which end along an axis a piece is; "" where it is in the middle, or reaches across it."""
    size = float(whole[1, axis] - whole[0, axis])
    middle = float(whole[:, axis].mean())
    away = float(box[:, axis].mean()) - middle
    across = box[0, axis] < middle - FAR * size and box[1, axis] > middle + FAR * size
    if across or abs(away) <= FAR * size:
        return ""
    return ENDS[axis][int(away > 0.0)]


def _shape(points: Floats, box: Floats, whole: Floats) -> str:
    size = box[1] - box[0]
    if (size >= MAIN * (whole[1] - whole[0])).all():
        return "body"
    least, middle, most = np.sort(size)
    if most < SMALL:
        return "small_piece"
    thin = int(size.argmin())
    long = int(size.argmax())
    if middle <= THIN * most:
        return ("lengthwise_bar", "crossbar", "post")[long]
    if least <= middle / EVEN and most <= EVEN * middle and _is_round(points, box, thin):
        return "disc"
    if least <= THIN * middle:
        if thin == 2:
            return _level(size, box, whole)
        return ("cross_plate", "side_plate")[thin]
    return "block"


def _is_round(points: Floats, box: Floats, axis: int) -> bool:
    """Whether the outline of a piece, seen along an axis, is a circle."""
    others = [k for k in range(3) if k != axis]
    away = np.linalg.norm((points - box.mean(axis=0))[:, others], axis=1)
    return bool(away.max() <= ROUND * 0.5 * (box[1] - box[0])[others].max())


def _level(size: Floats, box: Floats, whole: Floats) -> str:
    """What a level plate is called: floor and roof where it is large."""
    height = _end(box, whole, 2)
    if height and (size[:2] >= LARGE * (whole[1] - whole[0])[:2]).all():
        return "floor" if height == "lower" else "roof"
    return "level_plate"
