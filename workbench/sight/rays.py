"""What rays meet first in an environment: what is above a head, before knees, under feet."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment
from workbench.sight.obscuration import block_lines
from workbench.sight.scenery import scenery_of

__all__ = ["Hits", "first_hits"]

_START = 1e-6
"""[m] from its origin on a ray meets things."""


@dataclass(frozen=True, eq=False)
class Hits:
    """What R rays meet first: (R,) the distance [m], infinite where nothing is met, and the part,
    -1 there."""

    distance: Floats
    part: Ints

    @property
    def parts(self) -> list[int]:
        """The parts that are met, in their order."""
        return [int(part) for part in np.unique(self.part[self.part >= 0])]


def first_hits(
    environment: Environment, origins: Floats, ways: Floats, *, length: float, among: Bools
) -> Hits:
    """Find what rays meet first.

    Parameters
    ----------
    origins, ways
        (R, 3) [m] where the rays begin, and their unit directions.
    length
        How far [m] they go.
    among
        (K,) the parts that count, see-through and hidden ones too.
    """
    clear = np.zeros_like(among)
    scenery = scenery_of(replace(environment, hidden=~among, see_through=clear))
    begin = origins + _START * ways
    ends = (origins + length * ways)[:, None]
    met = block_lines(scenery, begin, ends, np.full(1, -1), np.array([0, 1]))
    part = met.item[:, 0]
    distance = _START + met.share[:, 0] * (length - _START)
    return Hits(np.where(part >= 0, distance, np.inf), part)
