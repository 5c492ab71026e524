"""The zones that are hidden to two eyes: their colours, and the legend with their sizes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.draw.chart import FINER, Words
from workbench.draw.scene import PAPER, Colour
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.units import plain

__all__ = ["CLEAR", "OWN", "Items", "LegendBox", "Zones", "add_legend", "spread", "zones"]

CLEAR: Colour = (228, 240, 248)
"""What is seen through a window."""
_COLOURS: tuple[Colour, ...] = (
    (213, 94, 0),
    (0, 114, 178),
    (230, 159, 0),
    (0, 158, 115),
    (204, 121, 167),
    (86, 180, 233),
    (240, 228, 66),
    (136, 34, 85),
    (153, 153, 51),
    (51, 34, 136),
)
"""Colours that people of any colour vision tell apart: Okabe & Ito 2008, Color universal design, and
three of the scheme "muted" of Tol 2021, Colour schemes."""
OWN = "own body"
"""The zone of the body whose eyes they are."""
_OWN: Colour = (122, 92, 72)
_OTHERS: Colour = (150, 150, 150)
_EDGE = 20.0
"""How much more what is hidden to one eye only counts, for who gets a colour: it lies along the
borders of what is free, and tells what stands before the view."""
_PALE = 0.62
"""Share of paper in the colour of what is hidden to one eye only."""
_COLUMN = 29.0
"""Width of a column of the legend, as a multiple of the size of its letters."""
_ENDS = (20.5, 24.0, 28.0)
"""Where the figures of a column end, likewise."""
_LINE = 1.5
"""Height of a line, likewise."""
_LETTERS = 27
"""Longest name in a legend."""
_BORDER = 0.55
"""Share of the colour that is left along a border between zones."""


Items = NDArray[np.int32]


class _Row(NamedTuple):
    """A zone in the legend, and how much it hides to both eyes and to one only."""

    name: str
    colour: Colour
    both: float
    one: float


@dataclass(frozen=True, eq=False)
class Zones:
    """Whose zone is drawn in which colour.

    Parameters
    ----------
    rows
        R lines of the legend.
    row
        (N,) the line of each item.
    clear
        How much both eyes see.
    """

    rows: tuple[_Row, ...]
    row: Ints
    clear: float

    @property
    def total(self) -> float:
        """All that is shown: hidden to both eyes, to one only, and seen by both."""
        return self.clear + sum(zone.both + zone.one for zone in self.rows)

    def paint(self, left: Items, right: Items, through: Items) -> NDArray[np.uint8]:
        """Colours (H, W, 3) of what hides each pixel.

        Parameters
        ----------
        left, right
            (H, W) the item that hides it to either eye, -1 for none.
        through
            (H, W) the see-through item that is looked through, -1 for none.
        """
        colour = np.array([*(zone.colour for zone in self.rows), CLEAR, PAPER], dtype=np.float64)
        free = np.where(through >= 0, len(self.rows), len(self.rows) + 1)
        item = np.where(left >= 0, left, right)
        row = np.where(item >= 0, np.append(self.row, 0)[item], free)
        both = (left >= 0) & (right >= 0)
        pale = (item >= 0) & ~both
        image = colour[row]
        image[pale] += _PALE * (np.array(PAPER) - image[pale])
        kind = 2 * row + pale
        border = np.zeros_like(pale)
        border[:, 1:] |= kind[:, 1:] != kind[:, :-1]
        border[1:] |= kind[1:] != kind[:-1]
        image[border] *= _BORDER
        return np.round(image).astype(np.uint8)


def zones(items: Sequence[str], both: Floats, one: Floats, clear: float) -> Zones:
    """Give each zone a colour: those that bound the free view most and hide most one of their own,
    the own body its own, all others grey.

    Parameters
    ----------
    items
        (N,) the zone that each item belongs to, by name.
    both, one
        (N,) how much each item hides to both eyes, and to one only.
    clear
        How much both eyes see.
    """
    names, index = np.unique(np.array(items, dtype=object), return_inverse=True)
    sums = [np.bincount(index, size, len(names)) for size in (both, one)]
    colours = iter(_COLOURS)
    rows = []
    for k in np.argsort(-(sums[0] + _EDGE * sums[1]), kind="stable").tolist():
        hides = sums[0][k] + sums[1][k] > 0.0
        colour = _OWN if names[k] == OWN else next(colours, _OTHERS) if hides else _OTHERS
        rows.append((colour == _OTHERS, -float(sums[0][k] + sums[1][k]), k, colour))
    rows.sort()
    row = np.argsort([k for _, _, k, _ in rows])
    listed = [
        _Row(plain(names[k]), colour, float(sums[0][k]), float(sums[1][k]))
        for _, _, k, colour in rows
    ]
    return Zones(tuple(listed), row[index], clear)


def spread(items: Items, inside: Bools) -> Items:
    """An image of items (K,) at its pixels (H, W) that are inside a map, -1 outside."""
    image = np.full(inside.shape, -1, dtype=np.int32)
    image[inside] = items
    return image


class LegendBox(NamedTuple):
    """Where a legend stands [pixels], and the size of its letters."""

    left: float
    top: float
    right: float
    bottom: float
    size: float

    @property
    def columns(self) -> int:
        """How many columns have room."""
        return max(1, int((self.right - self.left) / (_COLUMN * self.size)))

    @property
    def lines(self) -> int:
        """How many lines have room below the heads."""
        return max(1, int((self.bottom - self.top) / (_LINE * self.size)) - 1)


def add_legend(
    colours: NDArray[np.uint8], found: Zones, box: LegendBox, *, unit: str, places: int
) -> list[Words]:
    """Paint the patches of a legend into a chart's colours, and return its words.

    As many zones have a line as there is room for; the last line has all others together.

    Parameters
    ----------
    colours
        (FINER height, FINER width, 3), filled in place.
    found
        The zones.
    box
        Where the legend stands.
    unit, places
        Of the sizes, and how many decimal places they are written with.
    """
    size = box.size
    columns, lines = box.columns, box.lines
    hidden = [(zone.both, zone.one) for zone in found.rows]
    both, one = np.sum(hidden, axis=0).tolist() if hidden else (0.0, 0.0)
    totals = [
        _Row("hidden", PAPER, both, one),
        _Row("seen by both eyes", CLEAR, found.clear, math.nan),
        _Row("in all", PAPER, found.total, math.nan),
    ]
    hiding = [zone for zone in found.rows if zone.both + zone.one > 0.0]
    entries = _first(hiding, columns * lines - len(totals)) + totals
    width = (box.right - box.left) / columns
    words = []
    for column in range(min(columns, -(-len(entries) // lines))):
        left = box.left + column * width
        ends = [left + size * place for place in _ENDS]
        y = box.top + 0.7 * size
        heads = (f"both eyes [{unit}]", "%", "one eye")
        words += [
            Words((x, y), text, 0.85 * size, "end") for x, text in zip(ends, heads, strict=True)
        ]
        for name, colour, both, one in entries[column * lines : (column + 1) * lines]:
            y += _LINE * size
            _patch(colours, (left, y - 0.5 * size), size, colour)
            texts = (f"{both:.{places}f}", f"{100 * both / found.total:.1f}", f"{one:.{places}f}")
            words.append(
                Words(
                    (left + 2.3 * size, y),
                    name if len(name) <= _LETTERS else name[: _LETTERS - 1] + "...",
                    size,
                )
            )
            words += [
                Words((x, y), text, size, "end")
                for x, text in zip(ends, texts, strict=True)
                if text != "nan"
            ]
    return words


def _first(rows: Sequence[_Row], count: int) -> list[_Row]:
    """The first rows, the last of them all others together."""
    if len(rows) <= max(count, 1):
        return list(rows)
    kept = max(count - 1, 0)
    rest = rows[kept:]
    others = _Row(
        f"{len(rest)} others", _OTHERS, sum(z.both for z in rest), sum(z.one for z in rest)
    )
    return [*rows[:kept], others]


def _patch(
    colours: NDArray[np.uint8], corner: tuple[float, float], size: float, colour: Colour
) -> None:
    """Paint a patch, its right part as pale as what is hidden to one eye only."""
    x, y = (round(FINER * value) for value in corner)
    width, height = round(FINER * 1.9 * size), round(FINER * size)
    pale = np.array(colour) + _PALE * (np.array(PAPER) - np.array(colour))
    colours[y : y + height, x : x + width] = colour
    colours[y : y + height, x + 2 * width // 3 : x + width] = np.round(pale)
