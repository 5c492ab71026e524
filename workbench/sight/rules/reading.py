"""Whether an instrument can be read: how large its characters are seen, how obliquely, and how far
off the line of sight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.rule_set import RuleSet
from workbench.sight.eyes import Eyes
from workbench.sight.regions import azimuth_elevation

__all__ = ["Reading", "character_height", "reading"]


@dataclass(frozen=True, eq=False)
class Reading:
    """How B people see an instrument; (B,) each.

    distance [m] from the middle of the eyes. character [rad]: of what is written, by the least of
    its sizes across the line of sight. face_angle [rad] between line of sight and face, negative
    from behind it. azimuth (left) and elevation (up) [rad] off the line of sight of the head as it
    is held.
    """

    distance: Floats
    character: Floats
    face_angle: Floats
    azimuth: Floats
    elevation: Floats


def character_height(angle: ArrayLike, distance: ArrayLike) -> Floats:
    """Height [m] of characters that are to be seen at an angle [rad] from a distance [m].

    NUREG-0700: h = 6.283 D MA / 21600 for MA minutes of arc, which is D times the angle.
    """
    return np.asarray(angle, dtype=np.float64) * np.asarray(distance, dtype=np.float64)


def reading(
    eyes: Eyes, at: ArrayLike, face: ArrayLike, characters: float, rules: RuleSet
) -> Reading:
    """See an instrument with the eyes of B people.

    Parameters
    ----------
    at, face
        (3,) [m] the middle of its face, and the direction out of the face toward who reads it.
    characters
        Height [m] of its characters. Seen from the side one size of theirs shrinks by the cosine of
        the angle between the line of sight and the normal of the face.

    Raises
    ------
    InputError
        If the characters have no height, or the face no direction.
    """
    normal = np.asarray(face, dtype=np.float64)
    length = float(np.linalg.norm(normal))
    if not characters > 0.0:
        raise InputError(f"reading: expected a height of characters above 0 m, got {characters:g}")
    if not length > 0.0:
        raise InputError("reading: the instrument has no face; state the direction out of its face")
    way = np.asarray(at, dtype=np.float64) - eyes.middle
    distance = np.linalg.norm(way, axis=1)
    slant = -(way @ normal) / (length * distance)
    down = rules.number("line_down")
    line = np.stack([eyes.line(down=down), eyes.axes[:, 1], eyes.line(down=down - np.pi / 2)], 1)
    off = azimuth_elevation(np.einsum("bki,bi->bk", line, way))
    return Reading(
        distance=distance,
        character=character_height(1.0, characters / distance) * np.maximum(slant, 0.0),
        face_angle=np.arcsin(np.clip(slant, -1.0, 1.0)),
        azimuth=off[:, 0],
        elevation=off[:, 1],
    )
