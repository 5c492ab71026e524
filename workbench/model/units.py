"""Units of what a check measures: how an amount of each is written, and what it counts beside lengths.

The margins of a population are compared with each other: the search for the position of a seat takes
the place of the greatest least margin. So all of them are lengths, and an angle or a share counts as
a length by a stated factor. People read them in the unit of their check: a tenth of a millimetre or
a degree, and finer where a tenth hides a difference.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats

__all__ = [
    "UNITS",
    "Unit",
    "limit_unit_of",
    "plain",
    "tenths",
    "unit_in",
    "unit_of",
]


@dataclass(frozen=True)
class Unit:
    """A unit in which figures are read.

    Parameters
    ----------
    column
        In tables and files: "mm".
    words, sign
        After a number in a sentence, and beside one in a table, each with its space.
    scale
        How many of it are one SI unit.
    counts
        What one SI unit counts beside lengths [m].
    places
        Decimals of an amount that is not small.
    one
        After the number 1 in a sentence, where that is another word.
    """

    column: str
    words: str
    sign: str
    scale: float = 1.0
    counts: float = 1.0
    places: int = 0
    one: str = ""

    def shown(self, margin: float) -> float:
        """The number of this unit in a margin [m] that counts beside lengths."""
        return margin * self.scale / self.counts

    def counted(self, amount: Floats) -> Floats:
        """What amounts in SI units count beside lengths [m]."""
        return np.asarray(self.counts * amount, dtype=np.float64)

    def short(self, margin: float) -> str:
        """Write what a margin [m] comes to in this unit: "41 mm", "3.2 degrees"; "0.3 mm" of what
        rounds to nothing."""
        amount = self.shown(margin)
        least = 10.0**-self.places
        if amount >= 0.95 * least:
            number = f"{amount:,.{self.places}f}"
            return f"{number}{self.one if self.one and number == '1' else self.words}"
        if amount >= 0.05 * least:
            return f"{amount:.{self.places + 1}f}{self.words}"
        return f"{amount:.1g}{self.words}"


UNITS = {
    "m": Unit("mm", " mm", "\u00a0mm", 1000.0),
    "rad": Unit("deg", " degrees", "°", math.degrees(1.0), 0.2, 1),
    "arcmin": Unit("arcmin", " arc minutes", "′", 60 * math.degrees(1.0), 3.6, 1),
    "share": Unit("percent", " %", "\u00a0%", 100.0, 0.1),
    "N": Unit("N", " N", "\u00a0N", 1.0, 0.001),
    "points": Unit("points", " points", " points", 1.0, 0.01, one=" point"),
    "g": Unit("g", " g", "\u00a0g"),
    "": Unit("", "", ""),
}
"""By the unit of a finding, which is SI but for g: an angle is in radians whether degrees or arc
minutes are read. A radian counts as an arc at about a hand's length, 200 mm; a percent, an arc
minute and a newton as about a millimetre, a point of a score as a centimetre."""
_CHECKS = {
    "stops": "rad",
    "share": "share",
    "over_nose": "rad",
    "sees": "share",
    "reads": "share",
    "outline": "share",
    "pillar": "rad",
    "forward_field": "rad",
    "mirror": "share",
    "reflection": "share",
    "score": "points",
    "force": "N",
}
"""The units of checks whose margin is no length."""
_LIMITS = {"reads": "arcmin"}
"""The units of limits of checks whose margin has another."""


def unit_of(check: str) -> Unit:
    """The unit in which the margin of a check is read."""
    return UNITS[_CHECKS.get(check, "m")]


def limit_unit_of(check: str) -> Unit:
    """The unit in which the limit of a check is stated."""
    return UNITS[_LIMITS[check]] if check in _LIMITS else unit_of(check)


def unit_in(column: str) -> Unit:
    """The unit that tables and files call so."""
    return next(one for one in UNITS.values() if one.column == column)


FINEST = 6
"""Decimals at most: a nanometre in millimetres, below which nothing counts as a breach."""


def tenths(value: float, limit: float = 0.0) -> str:
    """Write a number with one decimal, or with as many as tell it from its limit.

    "12.4"; "30.04" beside a limit of 30, "65.84" beside one of 65.86; "0.0001" beside a limit of 0 of
    0.00006; "0.0" of what is no farther than 1e-6 from it; never "-0.0".
    """
    for places in range(1, FINEST + 1):
        text = f"{value:.{places}f}"
        if float(text) != round(limit, places) and round(abs(value - limit), places) > 0:
            return text
    text = f"{value:.1f}"
    return text[1:] if text == "-0.0" else text


def plain(name: str) -> str:
    """A name from a file, or a sentence with such names, as words: nothing else writes names for reading."""
    return name.replace("_", " ")
