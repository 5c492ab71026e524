"""Where a control may be so that a share of a population reaches it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.accommodation import SHARE_TOLERANCE
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Control, Environment
from workbench.model.poses import Placed

__all__ = ["ControlRegion"]


@dataclass(frozen=True, eq=False)
class ControlRegion:
    """Places of a control on a lattice about the one that it has, and the share of a population
    that reaches it there.

    Parameters
    ----------
    control
        The control where the study has it.
    hand, zone
        "left", "right" or "either", and the harness zone, as the study asks for it.
    people
        How many there are.
    wanted
        The share, 0 to 1, that is to reach it.
    spacing, within
        [m] between the places of the lattice, and how far they are from today's at most.
    axes
        (3, 3) unit vectors forward, to the left and up, as the people face.
    offset
        (M, 3) [m] from today's place along the axes: of the lattice, and of more places where enough
        of its are nearest.
    free, share
        (M,) the share that reaches it without obstacles, where that is less than is wanted perhaps
        less; and clear of them, where it is less than is wanted perhaps less, NaN where the former
        is too small already. Both are exact of today's place, and of all where no place will do.
    inside
        (M,) the index in `solids` of the part that the place is inside of, -1 of none.
    behind
        (M,) whether it is behind everybody's backrest.
    solids
        The names of solid parts.
    placed, environment
        Somebody of middle stature where that person sits (P = 1), and the surroundings with the
        seat there.
    standing, steps
        Whether they stand, and may step in an area.
    together
        The share, 0 to 1, that reaches it where it is, each from the one place from which everything
        that the study asks is done; NaN where nothing asks for it. Of people who may step the other
        shares are those of who steps for this control alone.
    """

    control: Control
    hand: str
    zone: int
    people: int
    wanted: float
    spacing: float
    within: float
    axes: Floats
    offset: Floats
    free: Floats
    share: Floats
    inside: Ints
    behind: Bools
    solids: tuple[str, ...]
    placed: Placed
    environment: Environment
    standing: bool
    steps: bool
    together: float

    @property
    def points(self) -> Floats:
        """(M, 3) [m] the places in the world."""
        return np.array(self.control.at) + self.offset @ self.axes

    @property
    def known(self) -> Floats:
        """(M,) the share that reaches it as far as it was asked: clear of obstacles, or without
        them where that is too few already."""
        return np.where(np.isnan(self.share), self.free, self.share)

    @property
    def enough(self) -> Bools:
        """(M,) where as many reach it as is wanted."""
        return np.asarray(np.nan_to_num(self.share, nan=-1.0) >= self.wanted - SHARE_TOLERANCE)

    @property
    def on_lattice(self) -> Bools:
        """(M,) which places are those of the lattice."""
        steps = self.offset / self.spacing
        return np.asarray((np.abs(steps - np.round(steps)) < 1e-6).all(axis=1))

    @property
    def today(self) -> int:
        """The row of the place that it has."""
        return int(np.argmin(np.linalg.norm(self.offset, axis=1)))

    @property
    def nearest(self) -> int | None:
        """The row of the place nearest to today's where enough reach it, None where there is none;
        of several that are as near, where most do."""
        rows = np.flatnonzero(self.enough)
        if not len(rows):
            return None
        far = np.round(np.linalg.norm(self.offset[rows], axis=1), 6)
        return int(rows[np.lexsort((-self.share[rows], far))[0]])

    @property
    def best(self) -> int | None:
        """The row of the place that most people reach, the nearest of several; None where nobody
        reaches any."""
        known = np.round(np.where(self.inside >= 0, 0.0, self.known), 9)
        if not known.any():
            return None
        far = np.round(np.linalg.norm(self.offset, axis=1), 6)
        return int(np.lexsort((far, -known))[0])
