"""Guess the axes of a mesh whose file does not say them, with the reason in words.

A guess follows from the first of these that tells:

1. Names of parts. What is named roof or headrest stands above what is named floor, pedal or tyre;
   what is named front, bonnet or windscreen stands before what is named rear or tail; left and right
   give the third axis, and with it the front.
2. Symmetry. People and what is built for them are alike on the left and on the right, so the axis
   across is the one along which the mesh is its own mirror image best.
3. Size. Of the two other axes the one that most area faces for its length is up: floors, pans and
   roofs are larger than fronts, and what is built for people is lower than it is long. Where both
   horizontal axes are symmetric the longer one is forward. A round shape, as of a person, shows no
   such faces, and whether it stands or lies no shape tells: it is taken to stand, and unsure.
4. Lean. Windscreens and seat backs lean aft: their area, as far as it slopes, faces forward and up.

What the last three find is a likely answer and no more. Where the lean is small, or the symmetry of
two axes is the same, the answer is called unsure, so that it is asked about.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.files.meshes.parts import RawMesh, RawPart
from workbench.geometry.sampling import even_places
from workbench.model.arrays import Bools, Floats

__all__ = ["GuessedAxes", "guessed_axes"]

ABOVE = frozenset(
    [
        "roof",
        "ceiling",
        "headliner",
        "canopy",
        "headrest",
        "windscreen",
        "windshield",
        "steering",
        "visor",
        "mirror",
    ]
)
BELOW = frozenset(
    [
        "floor",
        "pedal",
        "pedals",
        "tyre",
        "tyres",
        "tire",
        "tires",
        "heel",
        "chassis",
        "underbody",
        "carpet",
    ]
)
AHEAD = frozenset(
    [
        "front",
        "fore",
        "nose",
        "bonnet",
        "hood",
        "windscreen",
        "windshield",
        "dashboard",
        "headlight",
        "headlights",
        "headlamp",
        "headlamps",
        "grille",
        "pedal",
        "pedals",
        "radiator",
    ]
)
BEHIND = frozenset(
    [
        "rear",
        "aft",
        "tail",
        "taillight",
        "taillights",
        "tailgate",
        "trunk",
        "boot",
        "exhaust",
        "spoiler",
        "backrest",
    ]
)
LEFT = frozenset(["left", "lh", "port"])
RIGHT = frozenset(["right", "rh", "starboard"])
"""Words of names that say where a part is."""
APART = 0.1
"""Named parts whose centres differ by less than this share of the mesh's size tell nothing."""
BINS = 24
"""Cells along each axis in which the surface is compared with its mirror image."""
SAMPLES = 20_000
"""Points of the surface that are compared, about."""
SYMMETRIC = 0.1
"""The mirror image of an axis is better than another one's by this share, or they are alike."""
ALIKE = 0.5
"""A mesh that has less in common with any of its mirror images has no sides that are alike."""
LONGER = 1.15
"""A side that is so many times as long as the other is the longer one."""
PLAIN = 1.5
"""An axis that so many times as much area faces, for its length, as another is plainly up."""
ROUND = 0.3
"""A mesh of whose area less faces along the three axes is round: people 0.09 to 0.20, a steering
wheel 0.11; cars, cockpits, furniture and wheelchairs 0.41 to 1.0."""
SLOPES = (0.3, 0.95)
"""Upward parts of unit normals between which a face slopes: 18 to 72 degrees from the level."""
LEANING = 0.2
"""Sloping area that faces one way rather than the other, as a share of all of it, that tells."""
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_NAMES = ("x", "y", "z")


@dataclass(frozen=True)
class GuessedAxes:
    """The axes of a mesh.

    Parameters
    ----------
    up, forward
        As in the file of an environment.
    why_up, why_forward
        How they were got, in words.
    sure_up, sure_forward
        Whether names of parts say it, or shape does plainly.
    """

    up: str
    forward: str
    why_up: str
    why_forward: str
    sure_up: bool
    sure_forward: bool


@dataclass(frozen=True)
class _Direction:
    """An axis (3,) of the file with its sign, why, and whether that tells plainly."""

    way: Floats
    why: str
    sure: bool

    @property
    def name(self) -> str:
        """As in the file of an environment."""
        axis = int(np.abs(self.way).argmax())
        return ("-" if self.way[axis] < 0.0 else "") + _NAMES[axis]


def guessed_axes(raw: RawMesh) -> GuessedAxes:
    """Guess the axes that a mesh's file does not say; those that it says stay.

    Parameters
    ----------
    raw
        As in its file.
    """
    points = _surface_points(raw.parts)
    size = np.ptp(points, axis=0)
    up = _stated(raw.up) or _guessed_up(raw.parts, points, size)
    forward = _stated(raw.forward)
    if forward is None or abs(float(forward.way @ up.way)) > 0.5:
        forward = _guessed_forward(raw.parts, points, size, up)
    return GuessedAxes(up.name, forward.name, up.why, forward.why, up.sure, forward.sure)


def _stated(axis: str | None) -> _Direction | None:
    if axis is None:
        return None
    way = np.zeros(3)
    way[_NAMES.index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    return _Direction(way, "", True)


def _guessed_up(parts: Sequence[RawPart], points: Floats, size: Floats) -> _Direction:
    found = _by_names(parts, size, ABOVE, BELOW, np.ones(3, dtype=bool))
    if found is not None:
        return found
    mirror = _symmetries(points)
    across = int(mirror.argmax())
    rest = [axis for axis in range(3) if axis != across]
    area = _facing_area(parts)
    faces = area / np.where(size > 0.0, size, np.inf)
    way = np.zeros(3)
    if faces[rest].max() <= 0.0 or mirror[across] < ALIKE:
        way[2] = 1.0
        return _Direction(way, "z, as in most files", False)
    if area.sum() < ROUND * _whole_area(parts):
        way[max(rest, key=lambda axis: (size[axis], axis))] = 1.0
        why = "a round shape, as of a person, is taken to stand on end; one who lies looks the same"
        return _Direction(way, why, False)
    # z where it is as good as the other one: most files have it so
    best = max(rest, key=lambda axis: (round(float(faces[axis] / faces[rest].max()), 1), axis))
    way[best] = 1.0
    others = [axis for axis in rest if axis != best]
    plain = faces[best] > PLAIN * faces[others].max()
    return _Direction(
        way, "most area faces this way for its length, as of floors and roofs", bool(plain)
    )


def _guessed_forward(
    parts: Sequence[RawPart], points: Floats, size: Floats, up: _Direction
) -> _Direction:
    level = np.abs(up.way) < 0.5
    found = _by_names(parts, size, AHEAD, BEHIND, level)
    if found is not None:
        return found
    left = _by_names(parts, size, LEFT, RIGHT, level)
    if left is not None:
        # x forward, y left, z up: forward is left x up
        return _Direction(np.cross(left.way, up.way), left.why, True)
    mirror = _symmetries(points)
    first, second = np.flatnonzero(level).tolist()
    along = first if size[first] >= size[second] else second
    why = "the longer of two axes"
    sure = bool(size[along] > LONGER * size[first + second - along])
    sides = mirror[[first, second]]
    if np.ptp(sides) > SYMMETRIC and sides.max() >= ALIKE:
        along = first if mirror[first] < mirror[second] else second
        why = f"left and right are alike along {_NAMES[first + second - along]}"
        sure = True
    sure = sure and up.sure  # what is ahead of somebody who lies is up
    lean = _lean(parts, up.way, along)
    way = np.zeros(3)
    way[along] = -1.0 if lean < 0.0 else 1.0
    if abs(lean) < LEANING:
        return _Direction(way, f"{why}; which end is the front is not known", False)
    return _Direction(way, f"{why}, and slopes lean away from it", sure)


def _by_names(
    parts: Sequence[RawPart],
    size: Floats,
    ahead: frozenset[str],
    behind: frozenset[str],
    allowed: Bools,
) -> _Direction | None:
    """The axis along which parts of some names stand apart from parts of others."""
    groups: list[list[tuple[str, Floats]]] = [[], []]
    for part in parts:
        words = {word.lower() for word in _WORD.findall(part.name)}
        kinds = [bool(words & ahead), bool(words & behind)]
        if kinds[0] != kinds[1]:
            centre = 0.5 * (part.vertices.min(axis=0) + part.vertices.max(axis=0))
            groups[0 if kinds[0] else 1].append((part.name, centre))
    if not groups[0] or not groups[1]:
        return None
    means = [np.mean([centre for _, centre in group], axis=0) for group in groups]
    apart = np.where(allowed, (means[0] - means[1]) / np.where(size > 0.0, size, 1.0), 0.0)
    axis = int(np.abs(apart).argmax())
    if abs(apart[axis]) < APART:
        return None
    way = np.zeros(3)
    way[axis] = np.sign(apart[axis])
    return _Direction(way, f"by the names {groups[0][0][0]} and {groups[1][0][0]}", True)


def _surface_points(parts: Sequence[RawPart]) -> Floats:
    """(N, 3) points spread evenly over the surface: of each face as many as its share of the area,
    at fixed places, so that the same mesh gives the same points."""
    corners = np.concatenate([part.vertices[part.faces] for part in parts])
    a, b, c = np.moveaxis(corners, 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    total = float(area.sum())
    if not total > 0.0:
        return corners.reshape(-1, 3)
    ends = np.floor(np.cumsum(area) / total * SAMPLES).astype(np.int64)
    count = np.diff(ends, prepend=0)
    face = np.repeat(np.arange(len(corners)), count)
    u, v = even_places(len(face))
    found: Floats = a[face] + u[:, None] * (b - a)[face] + v[:, None] * (c - a)[face]
    return found


def _symmetries(points: Floats) -> Floats:
    """(3,) how far the surface is its mirror image along each axis: the share of its area that cells
    and their mirror images have in common."""
    low = points.min(axis=0)
    size = np.ptp(points, axis=0)
    cell = np.minimum((points - low) / np.where(size > 0.0, size, 1.0) * BINS, BINS - 1)
    counts = np.zeros((BINS, BINS, BINS))
    np.add.at(counts, tuple(cell.astype(np.int64).T), 1.0)
    return np.array(
        [np.minimum(counts, np.flip(counts, axis)).sum() / counts.sum() for axis in range(3)]
    )


def _facing_area(parts: Sequence[RawPart]) -> Floats:
    """(3,) area of the faces within 10 degrees of facing along each axis."""
    crosses = np.concatenate([_crosses(part) for part in parts])
    area = np.linalg.norm(crosses, axis=1)
    along = np.abs(crosses) >= np.cos(np.radians(10.0)) * area[:, None]
    return np.array([area[along[:, axis] & (area > 0.0)].sum() for axis in range(3)])


def _whole_area(parts: Sequence[RawPart]) -> float:
    """The area of all faces, twice, as `_facing_area` has it."""
    return sum(float(np.linalg.norm(_crosses(part), axis=1).sum()) for part in parts)


def _crosses(part: RawPart) -> Floats:
    a, b, c = np.moveaxis(part.vertices[part.faces], 1, 0)
    return np.cross(b - a, c - a)


def _lean(parts: Sequence[RawPart], up: Floats, along: int) -> float:
    """How much more of the sloping area faces ahead and up than back and up, -1 to 1, whichever
    way faces are wound."""
    crosses = np.concatenate([_crosses(part) for part in parts])
    area = np.linalg.norm(crosses, axis=1)
    normal = crosses / np.where(area > 0.0, area, 1.0)[:, None]
    height = normal @ up
    ahead = np.where(height < 0.0, -normal[:, along], normal[:, along])
    across = np.sqrt(np.maximum(1.0 - height**2 - ahead**2, 0.0))
    slopes = (np.abs(height) > SLOPES[0]) & (np.abs(height) < SLOPES[1]) & (across < np.abs(ahead))
    weight = np.where(slopes, area, 0.0)
    total = float(weight.sum())
    return float((weight * np.sign(ahead)).sum()) / total if total > 0.0 else 0.0
