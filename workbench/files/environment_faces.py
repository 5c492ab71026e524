"""The instruments and mirrors of `environment.yaml`: the face of its part that each of them has.

A face is a group of triangles of a part whose normals differ by SPREAD at most from the one that
shows most. How much a triangle shows is the solid angle that it has from the eyes, about
A max(0, n . e) / d^2 for one of area A whose centre is d away from an eye along the unit vector e;
where a direction is stated, it is A n . e along that direction. Both sides of a part that is no
solid are looked at, since the winding of a sheet tells nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.errors import InputError
from workbench.files.environment_parts import matching_parts
from workbench.files.environment_schema import (
    EnvironmentFile,
    InstrumentFile,
    MirrorFile,
)
from workbench.files.schema import error_at
from workbench.files.yaml_text import Document
from workbench.model.arrays import Floats, xyz
from workbench.model.environment import Environment, Instrument, Mirror

__all__ = ["with_faces"]

Point = tuple[float, float, float]

SPREAD = math.cos(math.radians(20.0))
"""Cosine of the angle between normals of one face at most: a wide-angle mirror of 300 mm radius and
200 mm width turns by 19 degrees from its middle to its edge."""
STATED_WITHIN = math.cos(math.radians(45.0))
"""Cosine of the angle between a face and the direction that is stated for it, at least."""
CLEARLY = 0.6
"""The largest face is not clearly the one that is meant where another shows more than this share of
what it shows."""


class _FaceError(ValueError):
    """A face that cannot be told: the key that it is about, "" for the whole entry, and words."""

    def __init__(self, words: str, key: str = "") -> None:
        super().__init__(words)
        self.key = key


@dataclass(frozen=True, eq=False)
class _Triangles:
    """Triangles of a part: centres (T, 3) [m], unit normals (T, 3), areas (T,) [m2]."""

    centre: Floats
    normal: Floats
    area: Floats


@dataclass(frozen=True, eq=False)
class _Face:
    """A face of a part: the middle `at` (3,) [m] of its surface, its mean unit normal (3,), how much
    it shows."""

    at: Floats
    normal: Floats
    shows: float


def with_faces(
    environment: Environment, file: EnvironmentFile, document: Document, *, doubted: bool
) -> Environment:
    """Return an environment, complete but for its instruments and mirrors, with those of its file.

    Parameters
    ----------
    environment
        With its parts and seats.
    file, document
        All parts that it names are there.
    doubted
        Whether something is probably wrong with sizes or seats, which is told: then the eyes may be
        elsewhere, and which of two faces is meant is not asked about.

    Raises
    ------
    InputError
        With a line for each instrument or mirror whose face cannot be told, or faces away.
    """
    faults: list[str] = []
    found: dict[tuple[str, str], tuple[str, Point, Point]] = {}
    for section, things in (("instruments", file.instruments), ("mirrors", file.mirrors)):
        for name, one in things.items():
            try:
                part = _part(environment, one.part)
                face = _face(environment, part, one, doubted=doubted)
            except _FaceError as error:
                key = (section, name, error.key) if error.key else (section, name)
                faults.append(error_at(document, key, str(error)))
            else:
                found[section, name] = (part, xyz(face.at), xyz(face.normal))
    if faults:
        raise InputError(faults)
    instruments = [
        Instrument(name, *found["instruments", name], one.characters or 0.0, one.lit)
        for name, one in file.instruments.items()
    ]
    mirrors = [
        Mirror(name, *found["mirrors", name], one.radius or math.inf, one.field, one.aims)
        for name, one in file.mirrors.items()
    ]
    return replace(environment, instruments=tuple(instruments), mirrors=tuple(mirrors))


def _part(environment: Environment, key: str) -> str:
    """The one part that a name or a pattern means."""
    parts = matching_parts(key, environment.parts)
    if len(parts) > 1:
        raise _FaceError(f"{key!r} means {len(parts)} parts: {', '.join(parts)}; name one", "part")
    return parts[0]


def _face(
    environment: Environment, part: str, given: InstrumentFile | MirrorFile, *, doubted: bool
) -> _Face:
    """The face of a part that is meant; _FaceError where none or several could be, or a mirror faces
    away."""
    every = _triangles(environment, part)
    eyes = np.array([seat.nominal_eye for seat in environment.seats]).reshape(-1, 3)
    if given.face is None:
        return _shown_face(part, every, eyes, clearly=1.0 if doubted else CLEARLY)
    along = np.array(given.face)
    cosine = every.normal @ along
    shows = np.where(cosine >= STATED_WITHIN, every.area * cosine, 0.0)
    face = next(_groups(every, shows), None)
    if face is None:
        raise _FaceError(
            f"no face of part {part!r} looks within 45 degrees of {_words(along)}; its largest "
            f"look along {_largest(every)}",
            "face",
        )
    if isinstance(given, MirrorFile) and len(eyes) and max((eyes - face.at) @ face.normal) <= 0.0:
        seats = ", ".join(repr(seat.name) for seat in environment.seats)
        raise _FaceError(
            f"it faces away from the eyes in every seat ({seats}): its surface looks along "
            f"{_words(face.normal)}; state the direction in which the mirror looks",
            "face",
        )
    return face


def _shown_face(part: str, every: _Triangles, eyes: Floats, *, clearly: float) -> _Face:
    """The face that shows most to the eyes (E, 3) of the seats."""
    if not len(eyes):
        raise _FaceError(
            "no seat says where the eyes are that it looks toward: state 'face', the direction in "
            "which its face looks, such as face: [-1, 0, 0]"
        )
    to_eye = eyes - every.centre[:, None]
    distance = np.linalg.norm(to_eye, axis=-1)
    cosine = np.einsum("tec,tc->te", to_eye, every.normal) / distance
    shows = (every.area[:, None] * cosine.clip(0.0) / distance**2).mean(axis=1)
    faces = list(_groups(every, shows))
    if not faces:
        raise _FaceError(
            f"part {part!r} has no face that looks toward the eyes in a seat; its largest look "
            f"along {_largest(every)}: state 'face', the direction of the one that is meant"
        )
    if len(faces) > 1 and faces[1].shows > clearly * faces[0].shows:
        one, other = (_words(face.normal) for face in faces[:2])
        raise _FaceError(
            f"two faces of part {part!r} show about as much to the eyes, one looks along {one}, "
            f"one along {other}: state 'face', the direction of the one that is meant"
        )
    return faces[0]


def _triangles(environment: Environment, part: str) -> _Triangles:
    """The triangles of a part, those of a sheet from both sides."""
    k = environment.part_index(part)
    corner = environment.triangle_corners(k)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    length = np.linalg.norm(normal, axis=1)
    seen = length > 0.0
    found = _Triangles(
        corner[seen].mean(axis=1), normal[seen] / length[seen, None], 0.5 * length[seen]
    )
    if environment.solid[k]:
        return found
    return _Triangles(
        np.concatenate([found.centre, found.centre]),
        np.concatenate([found.normal, -found.normal]),
        np.concatenate([found.area, found.area]),
    )


def _groups(every: _Triangles, shows: Floats) -> Iterator[_Face]:
    """The faces of a part, the one that shows most first."""
    left = shows > 0.0
    found = []
    while left.any():
        seed = every.normal[int(np.where(left, shows, 0.0).argmax())]
        rows = left & (every.normal @ seed >= SPREAD)
        mine = _Triangles(every.centre[rows], every.normal[rows], every.area[rows])
        found.append(_Face(*_middle(mine), float(shows[rows].sum())))
        left &= ~rows
    yield from sorted(found, key=lambda face: -face.shows)


def _middle(mine: _Triangles) -> tuple[Floats, Floats]:
    """The middle (3,) [m] of a face, on its surface, and its mean unit normal (3,).

    The mean of a curved surface is beside it: it is moved along the normal to the plane of the
    triangle that is nearest.
    """
    mean = mine.area @ mine.centre / mine.area.sum()
    normal = mine.area @ mine.normal
    normal = normal / np.linalg.norm(normal)
    nearest = int(np.linalg.norm(mine.centre - mean, axis=1).argmin())
    plane = mine.normal[nearest]
    way = (mine.centre[nearest] - mean) @ plane / (normal @ plane)
    return mean + way * normal, normal


def _largest(every: _Triangles) -> str:
    """The directions of the largest faces of a part, in words."""
    faces = list(_groups(every, every.area))
    return " and ".join(_words(face.normal) for face in faces[:2])


def _words(direction: Floats | Sequence[float]) -> str:
    """A direction as a file states it."""
    return "[" + ", ".join(f"{round(float(c), 2) + 0.0:g}" for c in direction) + "]"
