"""The colours of all displays. A colour family is a ramp of one hue from far to near."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats

__all__ = ["FAMILIES", "GLASS", "INK", "MARKS", "PAPER", "SECTION", "Colour", "hexadecimal", "ramp"]

Colour = tuple[int, int, int]

PAPER: Colour = (255, 255, 255)
INK: Colour = (52, 60, 72)
GLASS: Colour = (150, 190, 205)
SECTION: Colour = (176, 184, 194)

# far, near. Near is light: on a white page the dark outline holds the form together, and what is far sinks back.
FAMILIES: dict[str, tuple[Colour, Colour]] = {
    "warm": ((122, 104, 92), (250, 236, 218)),
    "blue": ((82, 104, 138), (214, 231, 248)),
    "green": ((86, 118, 98), (216, 240, 218)),
    "rose": ((138, 92, 106), (250, 222, 228)),
    "grey": ((104, 104, 104), (238, 238, 238)),
}

MARKS: dict[str, Colour] = {
    "contact": (212, 32, 38),
    "allowed": (206, 128, 0),
    "clearance": (20, 96, 190),
    "point": (30, 130, 70),
}


def ramp(family: str, share: Floats) -> Floats:
    """Colours (..., 3) of 0 to 255 at `share` (...,): 0 far to 1 near."""
    far, near = (np.array(colour, dtype=np.float64) for colour in FAMILIES[family])
    return far + (near - far) * np.asarray(share)[..., None]


def hexadecimal(colour: Floats | Colour) -> str:
    """'#rrggbb' of a colour of 0 to 255."""
    red, green, blue = (int(round(float(value))) for value in colour)
    return f"#{red:02x}{green:02x}{blue:02x}"
