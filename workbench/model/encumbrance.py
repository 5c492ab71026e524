"""Encumbrance: what somebody wears, as spheres laid over those of the body, or what is missing."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Encumbrance", "Layer"]


@dataclass(frozen=True)
class Layer:
    """Copies of some spheres of a body, grown and shifted.

    segments: mnemonics; subparts: only spheres of these names, all where empty; beyond: only
    spheres whose middles lie at least so far [m] along a direction of the segment from a landmark
    (direction, subpart, distance), all that hold; thickness [m]: added to the radii; shift (3,)
    [m]: in the segment's frame (x front, y left, z top).
    """

    segments: tuple[str, ...]
    subparts: tuple[str, ...]
    beyond: tuple[tuple[str, str, float], ...]
    thickness: float
    shift: tuple[float, float, float]


@dataclass(frozen=True)
class Encumbrance:
    """Something worn: its layers, and what it weighs [kg] on each segment.

    without: segments whose own spheres and mass are gone: a limb that is missing, or in whose place
    the layers are (a prosthesis).
    """

    name: str
    description: str
    source: str
    layers: tuple[Layer, ...]
    mass: tuple[tuple[str, float], ...]
    without: tuple[str, ...] = ()
