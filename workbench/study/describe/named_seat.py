"""The figures of a seat whose cushion and back are named: found as if both had been clicked on.

Rays take the place of clicks. From above they meet the cushion over its whole box; from over the
cushion, each way in turn, they meet the back. Of the surfaces that grow from what they meet the one
that most rays meet is the cushion, and the back. All else is as after clicks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.bare_mesh import placed_file
from workbench.files.catalogue import find
from workbench.files.names import unique_names
from workbench.files.seat_doubts import SITTER, rest_lines
from workbench.geometry.ground import Ground
from workbench.model.arrays import Floats, Ints, xyz
from workbench.model.posing import attitude_matrix
from workbench.study.describe.edits_files import added_file, framed, moved_file
from workbench.study.describe.edits_seats import faced
from workbench.study.describe.meshes import Ray, Standing
from workbench.study.describe.saving import description_text
from workbench.study.describe.state import (
    INNER,
    SURFACES,
    Description,
    OpenPlace,
    figures_of,
    fitted_seat,
    open_place,
    standing_of,
)

__all__ = ["NamedSeat", "named_seat"]

RAYS = 9
"""Rays across a cushion or a back, and as many along it."""
WAYS = 8
"""Level directions in which a back is looked for from its cushion."""
OVER = 0.05
"""Rays to a back begin so far [m] above the middle of the cushion."""
SQUARE = math.cos(math.radians(60.0))
"""Cosine of the angle between a ray and the normal of what it meets, at least: cushions slope and
backs lean, and a back may face between two of the directions."""


@dataclass(frozen=True)
class NamedSeat:
    """A seat as its cushion and back give it.

    Parameters
    ----------
    lines
        What an environment's file says of it, in YAML: for a bare mesh the whole file, for an
        environment the seat and its parts.
    checks
        What was measured of it, in sentences.
    doubts
        What is odd about it.
    """

    lines: str
    checks: tuple[str, ...]
    doubts: tuple[str, ...]


def named_seat(
    sources: Sequence[str | Path],
    cushion: str,
    back: str,
    *,
    length: str | None = None,
    up: str | None = None,
    forward: str | None = None,
) -> NamedSeat:
    """Compute the figures of a seat of an environment or of bare meshes.

    Parameters
    ----------
    sources
        The file or folder of an environment or its name in the catalogue, or mesh files as of `read_bare`.
    cushion, back
        Names of parts, as describing by pointing has them; one name for both where they are one part.
    length, up, forward
        Of bare meshes, as of `read_bare`.

    Raises
    ------
    InputError
        If something cannot be read, a part is not there, or the two are no seat's.
    """
    files = [placed_file(source) for source in sources]
    first = files[0][0]
    opened = open_place(first if first.exists() else find("environments", str(first), INNER))
    description = opened.start
    for row, (path, move) in enumerate(files):
        if row:
            added = added_file(opened, description, path)
            opened = added.opened
            description = added.edit.description
        if any(move) or (row and any(files[0][1])):
            description = moved_file(opened, description, row, move).description
        if (length, up, forward) != (None, None, None):
            frame = {"length": length, "up": up, "forward": forward}
            description = framed(opened, description, row, frame).description
    names = standing_of(opened, description).names
    for part in (cushion, back):
        if part not in names:
            raise InputError(f"there is no part {part!r}; {one_of(part, names)}")
    seats = list(description.says.get("seats") or {})
    name = unique_names([*seats, "seat"], "seat")[-1]
    lap = _on_cushion(opened, description, cushion)
    description = faced(opened, description, name, "cushion", lap).description
    rest = _on_back(opened, description, name, back)
    description = faced(opened, description, name, "back", rest).description
    return _told(opened, description, name)


def _told(opened: OpenPlace, description: Description, name: str) -> NamedSeat:
    """What there is to say about a seat that is in a description."""
    figures = figures_of(opened, description, name)
    stands = standing_of(opened, description)
    seat = description.says["seats"][name]
    parts = {seat[surface]["part"] for surface in SURFACES}
    cushion, back = (
        stands.corners(opened.meshes.grown(description.picks[name].faces(surface)))
        for surface in SURFACES
    )
    checks = rest_lines(fitted_seat(name, figures), cushion, back, stands.ground)
    if opened.text is not None:
        rules = {key: rule for key, rule in description.says["parts"].items() if key in parts}
        description = replace(description, says={"parts": rules, "seats": {name: seat}})
    lines = description_text(description, None)
    return NamedSeat(lines, tuple(checks), figures.doubts)


def _on_cushion(opened: OpenPlace, description: Description, part: str) -> Ray:
    """Where a cushion is clicked on, from above."""
    stands = standing_of(opened, description)
    (left, aft, _), (right, front, _) = stands.boxes[stands.names.index(part)]
    own = np.flatnonzero(stands.part == stands.names.index(part))
    found = _most_met(opened, stands, own, np.eye(3), ((left, right), (aft, front)), math.inf)
    if found is None:
        raise InputError(f"nobody can sit on {part!r}: no face of it is level enough")
    return found[2]


def _on_back(opened: OpenPlace, description: Description, name: str, part: str) -> Ray:
    """Where the back of a seat is clicked on, whose cushion is known: straight behind its middle,
    or, where more of the part is met there, behind the middle of the part."""
    stands = standing_of(opened, description)
    lap = opened.meshes.grown(description.picks[name].faces("cushion"))
    cushion = stands.corners(lap).reshape(-1, 3)
    middle: Floats = 0.5 * (cushion.min(axis=0) + cushion.max(axis=0))
    box = stands.boxes[stands.names.index(part)]
    own = np.setdiff1d(np.flatnonzero(stands.part == stands.names.index(part)), lap)
    tall = (float(middle[2]) + OVER, float(box[1, 2]))
    if not len(own) or tall[0] >= tall[1]:
        raise InputError(f"{part!r} does not rise above the cushion: is it the back of this seat?")
    found: list[tuple[int, int, float, Ray]] = []
    for k in range(WAYS):
        ahead, left, above = attitude_matrix(yaw=2.0 * math.pi * k / WAYS).T
        axes = np.array([left, above, -ahead])  # rays go ahead, down the third axis
        start = float(axes[2] @ middle)
        for elsewhere, across in enumerate((middle, box.mean(axis=0))):
            side = float(left @ across)
            wide = (side - 0.5 * SITTER, side + 0.5 * SITTER)
            met = _most_met(opened, stands, own, axes, (wide, tall), start)
            if met is not None:
                count, height, ray = met
                found.append((count, -elsewhere, height - start, ray))
    if found:
        return max(found, key=lambda row: row[:3])[3]
    raise InputError(f"nobody can lean against {part!r}: no face of it is steep enough")


def _most_met(
    opened: OpenPlace,
    stands: Standing,
    own: Ints,
    axes: Floats,
    window: Sequence[tuple[float, float]],
    top: float,
) -> tuple[int, float, Ray] | None:
    """Find the surface of faces that most rays meet first: how many, how high [m] along the axis that
    they go down, and the ray that meets it next to the middle of all; None where they meet nothing
    that is square enough to them.

    axes: (3, 3) rows; rays go down the third one from the height `top` [m], over a window [m] of the
    two others.
    """
    corners = stands.corners(own) @ axes.T
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
    best: list[tuple[int, Floats]] = []
    left = met
    while len(left) > len(best):
        surface = opened.meshes.grown([left[0][0]])
        same = [one for one in left if one[0] in surface]
        left = [one for one in left if one[0] not in surface]
        best = max(best, same, key=len)
    if not best:
        return None
    points = np.array([point for _, point in best])
    point = points[np.linalg.norm(points - points.mean(axis=0), axis=1).argmin()]
    start = np.array([point[0], point[1], point[2] + 1.0]) @ axes
    part = stands.names[int(stands.part[best[0][0]])]
    return len(best), float(point[2]), Ray(part, xyz(start), xyz(-axes[2]), 1.0)
