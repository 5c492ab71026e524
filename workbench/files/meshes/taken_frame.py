"""The unit and the axes with which a mesh is taken: as stated, as its file says, else guessed with the
reason in words.

Describing, inspecting and drawing a bare mesh take the same.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.environment_schema import unit_metres
from workbench.files.meshes.parts import RawMesh, RawPart
from workbench.files.meshes.reading import axes_rotation, implausible, outsized, to_world
from workbench.files.meshes.sizes import NamedFits, named_fits
from workbench.files.schema import metres_in
from workbench.geometry.sampling import even_places
from workbench.model.arrays import Bools, Floats

__all__ = [
    "GuessedAxes",
    "Taken",
    "TakenFrame",
    "guessed_axes",
    "named_way",
    "surface_points",
    "symmetries",
    "taken_frame",
]

_LIKELY = 1.0
"""A mesh that is smaller [m] is no likely cockpit."""
_LONG = 15.0
"""A mesh that is larger [m] is a less likely one."""
_NAMES = 2.0
_FEW = 2.0
"""What odd names weigh at most, and how many names weigh half of that."""
_NO_COCKPIT = 1.0
_HALL = 0.5
"""What it weighs that a mesh is smaller or larger than likely."""
_PLAIN = 0.75
"""A unit against which not so much more speaks than against another one is possible too."""


@dataclass(frozen=True)
class Taken:
    """A unit or an axis.

    Parameters
    ----------
    value
        As in the file of an environment.
    why
        How it was guessed, in words; "" where it was stated, or the mesh file says it.
    sure
        Whether that tells plainly.
    """

    value: str
    why: str = ""
    sure: bool = True


@dataclass(frozen=True)
class TakenFrame:
    """How a mesh is taken: its unit, the axis that is up and the one that is forward."""

    length: Taken
    up: Taken
    forward: Taken

    @property
    def metres(self) -> float:
        """One unit of the file [m]."""
        return unit_metres(self.length.value)

    @property
    def rotation(self) -> Floats:
        """(3, 3) from the axes of the file to x forward, y left, z up."""
        return axes_rotation(self.up.value, self.forward.value)

    def assumed(self) -> Iterator[str]:
        """Sentences about what was guessed."""
        for what, one in (("unit", self.length), ("up", self.up), ("forward", self.forward)):
            if one.why:
                doubt = "" if one.sure else " (not sure)"
                yield f"{what} {one.value}{doubt}: {one.why}"


def taken_frame(
    raw: RawMesh, *, length: str | None = None, up: str | None = None, forward: str | None = None
) -> TakenFrame:
    """Find the unit and the axes of a mesh.

    Parameters
    ----------
    raw
        As in its file.
    length, up, forward
        As stated; None for what the file says, or a guess.

    Raises
    ------
    InputError
        If the unit is none. UsageError if the axes are none, or not at right angles.
    """
    aside = outsized(raw.parts)
    telling = tuple(part for part in raw.parts if part not in aside)
    said = replace(raw, parts=telling, up=up or raw.up, forward=forward or raw.forward)
    if forward is None and said.up and said.forward and said.up[-1] == said.forward[-1]:
        said = replace(said, forward=None)
    if said.up and said.forward:
        axes_rotation(said.up, said.forward)
    elif said.up or said.forward:
        given = str(said.up or said.forward)
        axes_rotation(given, "x" if given[-1:] != "x" else "y")
    found = guessed_axes(said)
    turned = replace(said, parts=to_world(said, axes_rotation(found.up, found.forward), metres=1.0))
    unit = _unit(said, turned) if length is None else Taken(_checked(raw.file, length))
    ahead = Taken(found.forward, found.why_forward, found.sure_forward)
    if said.forward == found.forward:
        ahead = Taken(found.forward, *(_doubt(said) if forward is None else ()))
    return TakenFrame(
        unit,
        Taken(found.up) if said.up else Taken(found.up, found.why_up, found.sure_up),
        ahead,
    )


def _doubt(said: RawMesh) -> tuple[str, bool] | tuple[()]:
    """Why the forward axis that a mesh's format states may be wrong: its left and right are alike along
    that axis, or names of parts say another one."""
    shape = guessed_axes(replace(said, forward=None))
    named = shape.sure_forward and shape.why_forward.startswith("by the names")
    along = shape.why_forward.startswith("left and right are alike")
    level = str(said.forward)[-1] != shape.forward[-1]
    if (named and shape.forward != said.forward) or (along and level):
        why = shape.why_forward.partition(";")[0]
        return f"its format says so, but {why}: forward may be {shape.forward}", False
    return ()


def _checked(file: str, length: str) -> str:
    try:
        unit_metres(length)
    except ValueError as error:
        raise InputError(f"{file}: length {length!r}: {error}") from None
    return length


def _unit(raw: RawMesh, turned: RawMesh) -> Taken:
    """The unit of a mesh: as the file says, else the one that least speaks against.

    The size of the whole is weighed against those of parts that are named after things: n of N that
    are odd weigh 2 n / (N + 2), so that one name alone decides nothing, unless most of the mesh is
    that thing.
    """
    if raw.metres is not None:
        named = [unit for unit, metres in metres_in.items() if math.isclose(metres, raw.metres)]
        return Taken(named[0] if named else f"{1e3 * raw.metres:.9g} mm")
    corners = np.concatenate([part.vertices[part.faces.ravel()] for part in raw.parts])
    largest = float(np.ptp(corners, axis=0).max())
    against: dict[str, float] = {}
    fitting: dict[str, NamedFits] = {}
    for unit in ("m", "mm", "cm", "in", "ft"):
        metres = metres_in[unit]
        if implausible(largest, metres):
            continue
        parts = to_world(turned, np.eye(3), metres=metres)
        found = named_fits(parts, metres, file=Path(raw.file).stem)
        fitting[unit] = found
        against[unit] = _NAMES * (found.of - found.fits) / (found.of + _FEW)
        if found.whole:  # a wheel alone is no cockpit, and as large as wheels are
            continue
        against[unit] += _NO_COCKPIT * (largest * metres < _LIKELY)
        against[unit] += _HALL * (largest * metres > _LONG)
    if not against:
        return Taken("m", "no unit makes it as large as a cockpit or a vehicle", False)
    best = min(against, key=lambda unit: against[unit])
    near = [unit for unit in against if against[unit] < against[best] + _PLAIN and unit != best]
    others = [f"{largest * metres_in[unit]:.3g} m in {unit}" for unit in near]
    also = f"; it would be {' or '.join(others)}" if others else ""
    usual = best in ("m", "mm") or fitting[best].fits > 0
    sure = not others and usual and against[best] == 0.0
    thing = f", as of {fitting[best].whole!r}" if fitting[best].whole else ""
    return Taken(best, f"by its size, {largest * metres_in[best]:.3g} m long{thing}{also}", sure)


# Guess the axes of a mesh whose file does not say them, with the reason in words.
#
# A guess follows from the first of these that tells:
#
# 1. Names of parts. What is named roof or headrest stands above what is named floor, pedal or tyre;
#    what is named front, bonnet or windscreen stands before what is named rear or tail; left and right
#    give the third axis, and with it the front.
# 2. Symmetry. People and what is built for them are alike on the left and on the right, so the axis
#    across is the one along which the mesh is its own mirror image best.
# 3. Size. Of the two other axes the one that most area faces for its length is up: floors, pans and
#    roofs are larger than fronts, and what is built for people is lower than it is long. Where both
#    horizontal axes are symmetric the longer one is forward. A round shape, as of a person, shows no
#    such faces, and whether it stands or lies no shape tells: it is taken to stand, and unsure.
# 4. Lean. Windscreens and seat backs lean aft: their area, as far as it slopes, faces forward and up.
#
# What the last three find is a likely answer and no more. Where the lean is small, or the symmetry of
# two axes is the same, the answer is called unsure, so that it is asked about.

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
_AXIS_NAMES = ("x", "y", "z")


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
        return ("-" if self.way[axis] < 0.0 else "") + _AXIS_NAMES[axis]


def guessed_axes(raw: RawMesh) -> GuessedAxes:
    """Guess the axes that a mesh's file does not say; those that it says stay.

    Parameters
    ----------
    raw
        As in its file.
    """
    points = surface_points(raw.parts)
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
    way[_AXIS_NAMES.index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    return _Direction(way, "", True)


def _guessed_up(parts: Sequence[RawPart], points: Floats, size: Floats) -> _Direction:
    found = named_way(parts, size, ABOVE, BELOW, np.ones(3, dtype=bool))
    if found is not None:
        return found
    mirror = symmetries(points)
    across = int(mirror.argmax())
    rest = [axis for axis in range(3) if axis != across]
    area = _facing_area(parts)
    faces = area / np.where(size > 0.0, size, np.inf)
    way = np.zeros(3)
    if faces[rest].max() <= 0.0 or mirror[across] < ALIKE:
        way[2] = 1.0
        return _Direction(way, "z, as in most files", False)
    if area.sum() < ROUND * sum(
        float(np.linalg.norm(_crosses(part), axis=1).sum()) for part in parts
    ):
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
    found = named_way(parts, size, AHEAD, BEHIND, level)
    if found is not None:
        return found
    left = named_way(parts, size, LEFT, RIGHT, level)
    if left is not None:
        # x forward, y left, z up: forward is left x up
        return _Direction(np.cross(left.way, up.way), left.why, True)
    mirror = symmetries(points)
    first, second = np.flatnonzero(level).tolist()
    along = first if size[first] >= size[second] else second
    why = "the longer of two axes"
    sure = bool(size[along] > LONGER * size[first + second - along])
    sides = mirror[[first, second]]
    if np.ptp(sides) > SYMMETRIC and sides.max() >= ALIKE:
        along = first if mirror[first] < mirror[second] else second
        why = f"left and right are alike along {_AXIS_NAMES[first + second - along]}"
        sure = True
    sure = sure and up.sure  # what is ahead of somebody who lies is up
    lean = _lean(parts, up.way, along)
    way = np.zeros(3)
    way[along] = -1.0 if lean < 0.0 else 1.0
    if abs(lean) < LEANING:
        return _Direction(way, f"{why}; which end is the front is not known", False)
    return _Direction(way, f"{why}, and slopes lean away from it", sure)


def named_way(
    parts: Sequence[RawPart],
    size: Floats,
    ahead: frozenset[str],
    behind: frozenset[str],
    allowed: Bools,
) -> _Direction | None:
    """Find the axis along which parts of some names stand apart from parts of others; None where they
    do not."""
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


def surface_points(parts: Sequence[RawPart]) -> Floats:
    """Return (N, 3) points spread evenly over the surface: of each face as many as its share of the area,
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
    return a[face] + u[:, None] * (b - a)[face] + v[:, None] * (c - a)[face]


def symmetries(points: Floats) -> Floats:
    """Return (3,) how far the surface is its mirror image along each axis: the share of its area that cells
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
