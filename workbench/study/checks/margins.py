"""Margins: what each of many people has to spare in each requirement, or lacks; and bounds of the
margins that the people truly have.

The margins are those of the spheres. A body states its fit error, segment by segment: how far its
true surface may lie outside the spheres, and how far inside. So the true margin lies between two
bounds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workbench.model.accommodation import Requirement
from workbench.model.arrays import Floats, Ints
from workbench.model.criterion import NO_REASON, Criterion
from workbench.model.environment import Control

__all__ = ["Asked", "Bounds", "Margins", "no_bounds", "no_margins"]


@dataclass(frozen=True)
class Asked:
    """A requirement of the people in one case of their workplace.

    Parameters
    ----------
    requirement, criterion
        What is asked, and the criterion of the study that asks it.
    control
        Of a reach.
    case
        The index of the case.
    for_certain
        Whether its margin is the lower bound of the true one.
    """

    requirement: Requirement
    criterion: Criterion
    control: Control | None = None
    case: int = 0
    for_certain: bool = False


@dataclass(frozen=True, eq=False)
class Margins:
    """What B people have to spare in R requirements.

    Parameters
    ----------
    margin
        (B, R) [m], or what counts as so much beside lengths (see model.units); negative where the requirement is not met by so much, NaN where it does not
        apply.
    words
        (B, R) what limits, "" where the requirement is met.
    toward
        (B, R, 3) the unit vector along which moving the control or part lets the margin grow as
        much, NaN where there is none.
    """

    margin: Floats
    words: NDArray[np.object_]
    toward: Floats

    def put(self, people: Ints, columns: Ints, other: Margins) -> None:
        """Take the margins of some people in some requirements from elsewhere."""
        where = np.ix_(people, columns)
        self.margin[where] = other.margin
        self.words[where] = other.words
        self.toward[where] = other.toward


@dataclass(frozen=True, eq=False)
class Bounds:
    """Between which margins the true ones of B people in R requirements lie.

    Parameters
    ----------
    low, high
        (B, R) [m]: with the true surface as far outside the spheres as it may be, and as far
        inside. NaN where the requirement does not apply or the fit error is not known.
    """

    low: Floats
    high: Floats

    def put(self, people: Ints, columns: Ints, other: Bounds) -> None:
        """Take the bounds of some people in some requirements from elsewhere."""
        where = np.ix_(people, columns)
        self.low[where] = other.low
        self.high[where] = other.high


def no_bounds(people: int, asked: Sequence[Asked]) -> Bounds:
    """Bounds of which nothing is known yet."""
    shape = (people, len(asked))
    return Bounds(np.full(shape, np.nan), np.full(shape, np.nan))


def no_margins(people: int, asked: Sequence[Asked]) -> Margins:
    """Margins that nothing is known of yet."""
    shape = (people, len(asked))
    words = np.full(shape, NO_REASON, dtype=object)
    return Margins(np.full(shape, np.nan), words, np.full((*shape, 3), np.nan))
