"""Labanotation, a first step: movements of parts of the body by direction, level and time, and what
the names mean.

Eight horizontal directions and `place`, each high, middle or low: the 27 direction signs of Laban
(A. Hutchinson, Labanotation, 1954). Middle is level, high is half way to straight up, low half way
to straight down; `place high` is straight up and `place low` straight down. `place middle` is no
direction but a place: a limb drawn in to its joint, or a support that stays where it is. Directions
are those of the body's own cross of axes: of the lower torso for legs, trunk and support, of the
upper torso for arms and head.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats

__all__ = [
    "DIRECTIONS",
    "LEVELS",
    "PARTS",
    "SUBPARTS",
    "Movement",
    "Score",
    "Sign",
    "nearest_sign",
    "sign_vector",
    "sign_words",
]

DIRECTIONS: dict[str, tuple[int, int]] = {
    "place": (0, 0),
    "forward": (1, 0),
    "left forward": (1, 1),
    "left": (0, 1),
    "left back": (-1, 1),
    "back": (-1, 0),
    "right back": (-1, -1),
    "right": (0, -1),
    "right forward": (1, -1),
}
"""Name to x (forward) and y (left)."""
LEVELS: dict[str, int] = {"high": 1, "middle": 0, "low": -1}
_LIMBS = {"arm": ("upper arm", "lower arm", "hand"), "leg": ("upper leg", "lower leg")}
SUBPARTS: dict[str, tuple[str, ...]] = {
    f"{side} {limb}": tuple(f"{side} {part}" for part in parts)
    for limb, parts in _LIMBS.items()
    for side in ("left", "right")
}
"""A whole limb to the parts that it takes along."""
PARTS: tuple[str, ...] = (
    "support",
    "trunk",
    "head",
    *(part for whole, parts in SUBPARTS.items() for part in (whole, *parts)),
)


@dataclass(frozen=True)
class Sign:
    """A direction sign: one of DIRECTIONS and one of LEVELS."""

    direction: str
    level: str

    def __str__(self) -> str:
        return f"{self.direction} {self.level}"


@dataclass(frozen=True)
class Movement:
    """A part of the body that moves to a sign, or holds (None), from a beat on for some beats; the
    first beat is 1.

    line: where it stands in its file, 0 where it stands in none.
    """

    part: str
    sign: Sign | None
    begin: float
    beats: float
    line: int = 0


@dataclass(frozen=True)
class Score:
    """Movements in the order of time. tempo [beats a minute]; step [m]: how far a support goes;
    file: its name."""

    movements: tuple[Movement, ...]
    tempo: float
    step: float = 0.5
    title: str = ""
    file: str = "score"


_SIGNS = tuple(Sign(d, h) for h in LEVELS for d in DIRECTIONS if (d, h) != ("place", "middle"))


def sign_vector(sign: Sign) -> Floats:
    """(3,) unit vector of a sign, x forward, y left, z up; zero for `place middle`."""
    flat = np.array(DIRECTIONS[sign.direction], dtype=np.float64)
    rise = float(LEVELS[sign.level])
    flat = flat / max(float(np.linalg.norm(flat)), 1.0)
    vector = np.array([*flat, rise])
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1.0))


def nearest_sign(vector: Floats) -> Sign:
    """The sign whose direction is nearest to a vector (3,) other than zero, of any length; never
    `place middle`."""
    along = np.array([sign_vector(sign) for sign in _SIGNS]) @ vector
    return _SIGNS[int(np.argmax(np.round(along / np.linalg.norm(vector), 12)))]


def sign_words(sign: Sign) -> str:
    """ "forward and up", "to the left and back", "down": a sign in words."""
    x, y = DIRECTIONS[sign.direction]
    ways = [
        ("forward", "", "back")[1 - x],
        ("to the left", "", "to the right")[1 - y],
        ("up", "", "down")[1 - LEVELS[sign.level]],
    ]
    said = [way for way in ways if way]
    return ", ".join(said[:-1]) + (" and " if said[:-1] else "") + said[-1] if said else "in"
