"""The colours of all displays."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats

__all__ = [
    "FAMILIES",
    "GLASS",
    "INK",
    "INKS",
    "MARKS",
    "PAPER",
    "SECTION",
    "Colour",
    "hexadecimal",
    "ramp",
]

Colour = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""

PAPER: Colour = (255, 255, 255)
INK: Colour = (52, 60, 72)
GLASS: Colour = (150, 190, 205)
SECTION: Colour = (176, 184, 194)

FAMILIES: dict[str, tuple[Colour, Colour]] = {
    "warm": ((140, 118, 103), (252, 238, 220)),
    "blue": ((98, 122, 158), (214, 231, 248)),
    "green": ((98, 130, 110), (216, 240, 218)),
    "rose": ((150, 104, 118), (250, 222, 228)),
    "grey": ((116, 116, 116), (238, 238, 238)),
}
"""Colour families: a ramp of one hue from far to near. Near is light: on a white page the dark
outline holds the form together, and what is far recedes."""

INKS: dict[str, Colour] = {
    "warm": (66, 48, 36),
    "blue": (20, 58, 122),
    "green": (24, 86, 50),
    "rose": (130, 34, 66),
    "grey": (40, 40, 40),
}
"""The same hues for thin lines."""

MARKS: dict[str, Colour] = {
    "contact": (212, 32, 38),
    "allowed": (206, 128, 0),
    "clearance": (20, 96, 190),
    "point": (30, 130, 70),
    "reach": (0, 122, 128),
    "missed": (176, 24, 92),
    "stop": (122, 44, 168),
    "segment": (70, 78, 90),
    "axis_x": (200, 40, 40),
    "axis_y": (30, 130, 50),
    "axis_z": (30, 80, 200),
}
"""Colour of each kind of mark; `marks.layout` describes their shapes."""


def ramp(family: str, share: Floats) -> Floats:
    """Interpolate a colour family at shares (...,), 0 far to 1 near; colours (..., 3) of 0 to 255."""
    far, near = (np.array(colour, dtype=np.float64) for colour in FAMILIES[family])
    return far + (near - far) * np.asarray(share)[..., None]


def hexadecimal(colour: Floats | Colour) -> str:
    """Write a colour of 0 to 255 as '#rrggbb'."""
    red, green, blue = (round(float(value)) for value in colour)
    return f"#{red:02x}{green:02x}{blue:02x}"
