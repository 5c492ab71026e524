"""Where a map stands in a picture: a title above it, a legend below."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workbench.draw.chart import FINER, Stroke, Words
from workbench.draw.scene import INK, PAPER, Colour
from workbench.draw.zones import LegendBox, Zones, add_legend
from workbench.model.arrays import Bools, Floats

__all__ = ["GRID", "LETTER", "Sheet"]

GRID: Colour = (96, 104, 116)
"""Colour of the lines of a grid."""
_WIDTH = 62.0
"""Width of a picture as a multiple of the size of its letters, which are 8 to 14 pixels high."""
LETTER = 0.55
"""Mean width of letters as a multiple of their height."""
_LEGEND = 20.0
"""Lines of a legend that room is kept for."""


@dataclass(frozen=True)
class Sheet:
    """A picture of width x height pixels with a map in it.

    Parameters
    ----------
    width, height
        [pixels].
    half
        How far the map goes to the right and up, in its own unit.
    """

    width: int
    height: int
    half: tuple[float, float]

    @property
    def letters(self) -> float:
        """Height of letters [pixels]."""
        return float(np.clip(self.width / _WIDTH, 8.0, 14.0))

    @property
    def _top(self) -> float:
        return 4.8 * self.letters

    @property
    def scale(self) -> float:
        """Pixels for one unit of the map."""
        columns = self._legend(0.0).columns
        legend = min(_LEGEND * 1.5 * self.letters / columns, 0.45 * self.height)
        across = (self.width - 2.0 * self.letters) / (2.0 * self.half[0])
        return min(across, (self.height - self._top - legend) / (2.0 * self.half[1]))

    def pixels(self, points: Floats) -> Floats:
        """Points (..., 2) of the map, to the right and up, in pixels to the right and down."""
        middle = [self.width / 2.0, self._top + self.half[1] * self.scale]
        return np.asarray(middle + points * [self.scale, -self.scale])

    def places(self) -> Floats:
        """(FINER height, FINER width, 2) the point of the map in the middle of each pixel."""
        column = (np.arange(FINER * self.width) + 0.5) / FINER - self.width / 2.0
        row = self._top + self.half[1] * self.scale - (np.arange(FINER * self.height) + 0.5) / FINER
        return np.stack(np.meshgrid(column, row), axis=-1) / self.scale

    def words(self, *lines: str) -> list[Words]:
        """The title, and in smaller letters what else there is to say; letters that all have room."""
        words = []
        for k, text in enumerate(lines):
            room = (self.width - 2.0 * self.letters) / (LETTER * max(len(text), 1))
            size = min((0.9 if k else 1.2) * self.letters, room)
            words.append(Words((self.letters, (1.0 + 1.3 * k) * self.letters), text, size))
        return words

    def label(self, point: Floats, text: str) -> Words:
        """A label of the grid at a point (2,) of the map."""
        x, y = self.pixels(point).tolist()
        return Words((x, y), text, 0.85 * self.letters, "middle", GRID, halo=True)

    def line(self, points: Floats, colour: Colour = GRID, width: float = 0.6) -> Stroke:
        """A line through points (K, 2) of the map."""
        return Stroke(self.pixels(points), colour, width)

    def emphasised(self, points: Floats) -> list[Stroke]:
        """A line through points (K, 2) of the map that is seen on every colour."""
        return [self.line(points, PAPER, 4.0), self.line(points, INK, 1.8)]

    def coloured(
        self, found: Zones, inside: Bools, painted: NDArray[np.uint8], *, unit: str, places: int
    ) -> tuple[NDArray[np.uint8], list[Words]]:
        """The colours of a whole picture and the words of its legend.

        Parameters
        ----------
        found
            The zones of the legend.
        inside, painted
            (FINER height, FINER width) where the map is, and (..., 3) its colours.
        unit, places
            As of `add_legend`.
        """
        colours = np.where(inside[..., None], painted, np.uint8(PAPER[0]))
        top = self._top + 2.0 * self.half[1] * self.scale + 0.6 * self.letters
        words = add_legend(colours, found, self._legend(top), unit=unit, places=places)
        return colours, words

    def _legend(self, top: float) -> LegendBox:
        size = self.letters
        return LegendBox(size, top, self.width - size, self.height - 0.5 * size, size)
