"""Find the seat of a cushion and a back that are given as parts.

Rays take the place of clicks. From above they meet the cushion over its whole box; from over the
cushion, each way in turn, they meet the back. Of the surfaces that grow from what they meet the one
that most rays meet is the cushion, and the back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError
from workbench.files.meshes.parts import weld
from workbench.files.seat_figures import SeatFigures, seat_figures
from workbench.files.surface_planes import Surface
from workbench.geometry.ground import Ground
from workbench.model.arrays import Floats, Ints
from workbench.model.joint_angles import attitude_matrix

__all__ = ["SITTER", "FoundSeat", "Met", "PartFaces", "found_seat"]

SITTER = 0.4
"""Width [m] of who sits: hips and chest of most people, without arms (ANSUR II, hip breadth sitting
of men, 95th percentile 0.41 m)."""
RAYS = 9
"""Rays across a cushion or a back, and as many along it."""
WAYS = 8
"""Level directions in which a back is looked for from its cushion."""
OVER = 0.05
"""Rays to a back begin so far [m] above the middle of the cushion."""
SQUARE = math.cos(math.radians(60.0))
"""Cosine of the angle between a ray and the normal of what it meets, at least: cushions slope and
backs lean, and a back may face between two of the directions."""


class PartFaces(NamedTuple):
    """A part: its name and the corners (T, 3, 3) [m] of its faces in the world, z up."""

    name: str
    corners: Floats


@dataclass(frozen=True, eq=False)
class Met:
    """What a ray meets: the row of the face, the point (3,) [m], and the way (3,) of the ray."""

    face: int
    point: Floats
    way: Floats


@dataclass(frozen=True, eq=False)
class FoundSeat:
    """A seat: where its cushion and its back are met, and the figures of the planes there."""

    cushion: Met
    back: Met
    figures: SeatFigures


def found_seat(cushion: PartFaces, back: PartFaces) -> FoundSeat:
    """Find cushion and back on their parts, and where their planes meet.

    Parameters
    ----------
    cushion, back
        The parts; of one name where they are one part.

    Raises
    ------
    InputError
        If nobody can sit on the one or lean against the other, or their planes are no seat's.
    """
    seat = _surface(cushion.corners)
    lap = _on_cushion(seat, cushion.name)
    region = seat.region(lap.face)
    one_part = cushion.name == back.name
    rest = seat if one_part else _surface(back.corners)
    own = np.setdiff1d(np.arange(len(rest.faces)), region if one_part else [])
    lean = _on_back(rest, own, seat.corners[region], back.name)
    figures = seat_figures(
        seat.corners[region],
        rest.corners[rest.region(lean.face)],
        lap.point[None],
        cushion_part=seat.corners,
        back_part=rest.corners,
    )
    return FoundSeat(lap, lean, figures)


def _surface(corners: Floats) -> Surface:
    """Faces (T, 3, 3) that hang together where they have corners in common."""
    return Surface(*weld(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)))


def _on_cushion(seat: Surface, part: str) -> Met:
    """Where a cushion is met from above."""
    (left, aft, _), (right, front, _) = _box(seat.corners)
    window = ((left, right), (aft, front))
    found = _most_met(seat, np.arange(len(seat.faces)), np.eye(3), window, math.inf)
    if found is None:
        raise InputError(f"nobody can sit on {part!r}: no face of it is level enough")
    return found[2]


def _on_back(rest: Surface, own: Ints, cushion: Floats, part: str) -> Met:
    """Where the back of a seat is met, whose cushion is known: straight behind its middle, or, where
    more of the part is met there, behind the middle of the part."""
    middle = _box(cushion).mean(axis=0)
    box = _box(rest.corners)
    tall = (float(middle[2]) + OVER, float(box[1, 2]))
    if not len(own) or tall[0] >= tall[1]:
        raise InputError(f"{part!r} does not rise above the cushion: is it the back of this seat?")
    found: list[tuple[int, int, float, Met]] = []
    for k in range(WAYS):
        ahead, left, above = attitude_matrix(yaw=2.0 * math.pi * k / WAYS).T
        axes = np.array([left, above, -ahead])  # rays go ahead, down the third axis
        start = float(axes[2] @ middle)
        for elsewhere, across in enumerate((middle, box.mean(axis=0))):
            side = float(left @ across)
            wide = (side - 0.5 * SITTER, side + 0.5 * SITTER)
            met = _most_met(rest, own, axes, (wide, tall), start)
            if met is not None:
                count, height, place = met
                found.append((count, -elsewhere, height - start, place))
    if found:
        return max(found, key=lambda row: row[:3])[3]
    raise InputError(f"nobody can lean against {part!r}: no face of it is steep enough")


def _box(corners: Floats) -> Floats:
    """(2, 3) [m] the least and the greatest corner of faces."""
    points = corners.reshape(-1, 3)
    return np.array([points.min(axis=0), points.max(axis=0)])


def _most_met(
    surface: Surface, own: Ints, axes: Floats, window: Sequence[tuple[float, float]], top: float
) -> tuple[int, float, Met] | None:
    """Find the surface of faces that most rays meet first: how many, how high [m] along the axis that
    they go down, and where one meets it next to the middle of all; None where they meet nothing
    that is square enough to them.

    axes: (3, 3) rows; rays go down the third one from the height `top` [m], over a window [m] of the
    two others.
    """
    met = _met_first(surface, own, axes, window, top)
    best: list[tuple[int, Floats]] = []
    while len(met) > len(best):
        region = surface.region(met[0][0])
        best = max(best, [one for one in met if one[0] in region], key=len)
        met = [one for one in met if one[0] not in region]
    if not best:
        return None
    points = np.array([point for _, point in best])
    rows = np.array([row for row, _ in best])
    nearest = np.argsort(np.linalg.norm(points - points.mean(axis=0), axis=1), kind="stable")
    # where a surface bends, what grows from one face of it may be a smaller one
    k = next(
        k for k in nearest if 2 * np.isin(rows, surface.region(int(rows[k]))).sum() > len(rows)
    )
    return len(best), float(points[k, 2]), Met(int(rows[k]), points[k] @ axes, -axes[2])


def _met_first(
    surface: Surface, own: Ints, axes: Floats, window: Sequence[tuple[float, float]], top: float
) -> list[tuple[int, Floats]]:
    """The face that each ray meets first, and where (3,) [m] by the axes; without those that are not
    square enough to their ray. Arguments as of `_most_met`."""
    corners = surface.corners[own] @ axes.T
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    square = np.abs(crosses[:, 2]) >= SQUARE * np.linalg.norm(crosses, axis=1)
    faces = Ground(corners, np.arange(len(own)), (), np.zeros(len(own), dtype=np.bool_))
    share = (np.arange(RAYS) + 0.5) / RAYS
    across, along = (low + share * (high - low) for low, high in window)
    met: list[tuple[int, Floats]] = []
    for place in np.stack(np.meshgrid(across, along), axis=-1).reshape(-1, 2):
        heights, rows = faces.levels(place)
        k = int((heights < top).sum()) - 1
        if k >= 0 and square[rows[k]]:
            met.append((int(own[rows[k]]), np.array([*place, heights[k]])))
    return met
