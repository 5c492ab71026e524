"""Accommodation: what a study asks of a population beside its criteria, and what it says of
shares and changes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from workbench.model.arguments import short_repr
from workbench.model.arrays import Bools, Floats
from workbench.model.surroundings import Move
from workbench.model.units import Unit, unit_of

__all__ = [
    "MAP_POINTS",
    "MET",
    "OF_RULES",
    "OF_SIGHT",
    "OF_SURFACE",
    "SHARE_TOLERANCE",
    "Certainty",
    "Change",
    "DesignChange",
    "GroupShare",
    "IntervalRule",
    "MapTask",
    "ReachMap",
    "Requirement",
    "certainly_met",
    "certainty_of",
    "met_of",
    "possibly_met",
]

MAP_POINTS = 3, 20_000
"""The fewest and the most points that a population reach map may have."""
MET = 1e-6
"""A margin [m], see model.units, down to which a requirement counts as met: below what any length here is known
to."""


OF_SURFACE = ("clearance", "contact", "self_contact", "between_people", "excursion")
"""Checks whose margin is a distance of the body's surface, so that it is known no better than
that."""


OF_RULES = ("outline", "pillar", "forward_field", "mirror", "reflection")
"""Checks of rules of sight."""


OF_SIGHT = ("over_nose", "sees", "reads", *OF_RULES)
"""Checks of what is seen: any part may stand before it, and anybody who is there."""


SHARE_TOLERANCE = 1e-9
"""A share this much below the one asked for counts as it: less than one person in any sample."""


def met_of(margin: Floats) -> Bools:
    """Whether margins [m] are met; what does not apply (NaN) is."""
    return np.asarray(np.isnan(margin) | (margin >= -MET), dtype=np.bool_)


def most_missed(margin: Floats, weight: Floats) -> int:
    """Return the requirement, of margins (P, R) [m], that most people, by weight (P,), miss; of several
    the one of which most is missing in the median."""
    missed = ~met_of(margin)
    lacking = np.median(np.where(missed, -margin, 0.0), axis=0)
    return int(np.lexsort((-lacking, -np.round(weight @ missed, 12)))[0])


def certainly_met(margin: Floats, low: Floats) -> Bools:
    """Whether margins [m] are met even where the true ones are as low as they may be; not where
    it is not known how low (NaN)."""
    return np.asarray(np.isnan(margin) | (low >= -MET), dtype=np.bool_)


def possibly_met(margin: Floats, high: Floats) -> Bools:
    """Whether margins [m] are met where the true ones are as high as they may be; so they may be
    where it is not known how high (NaN)."""
    return np.asarray(np.isnan(margin) | ~(high < -MET), dtype=np.bool_)


@dataclass(frozen=True, eq=False)
class Certainty:
    """Who of P people meets everything wherever the true surface of the body lies within its fit
    error, and who does if it lies where it suits."""

    certain: Bools
    possible: Bools


def certainty_of(margin: Floats, low: Floats, high: Floats, elsewhere: Bools) -> Certainty | None:
    """Tell who meets all requirements for certain, and who possibly.

    Parameters
    ----------
    margin, low, high
        (P, R) [m] the margins of the spheres, and between which the true ones lie; NaN where a
        requirement does not apply.
    elsewhere
        (P,) who meets everything for certain in another position than that of the margins.

    Returns
    -------
    Certainty or None
        None where it is not known of a margin between which bounds it truly lies.
    """
    if (~np.isnan(margin) & (np.isnan(low) | np.isnan(high))).any():
        return None
    return Certainty(
        np.asarray(certainly_met(margin, low).all(axis=1) | elsewhere, dtype=np.bool_),
        np.asarray(possibly_met(margin, high).all(axis=1), dtype=np.bool_),
    )


@dataclass(frozen=True)
class MapTask:
    """A population map that a study asks for: a part's surface with so many points on it, from the
    posture of which case. It tells who reaches them, by which hands (left, right or either), grip
    and zone; or who sees them, with either eye."""

    part: str
    grip: str
    zone: int
    hand: str
    points: int
    case: int = 0
    sees: bool = False


@dataclass(frozen=True)
class Change:
    """A change of the design: controls and parts moved, and the ends of the seat's travel moved:
    lower and upper end of it, forward and up [m]; of the area in which people step, forward and, as
    `travel_up`, to the left."""

    words: str
    moves: tuple[Move, ...] = ()
    travel_forward: tuple[float, float] = (0.0, 0.0)
    travel_up: tuple[float, float] = (0.0, 0.0)

    @property
    def of_travel(self) -> bool:
        """Whether an end of the seat's travel, or of the area to step in, is moved."""
        return any((*self.travel_forward, *self.travel_up))

    @property
    def size(self) -> float:
        """The longest way [m] that anything is moved, 0 of what turns."""
        ends = (*self.travel_forward, *self.travel_up)
        return max(*(math.hypot(*move.by) for move in self.moves), *map(abs, ends))


@dataclass(frozen=True)
class IntervalRule:
    """How a share's interval is found: method "wilson" or "bootstrap", with its seed and number of
    draws."""

    method: str = "wilson"
    seed: int = 0
    draws: int = 10_000


@dataclass(frozen=True)
class Requirement:
    """The smallest thing that is asked of a person: one control, one clearance, the view, the pedals.

    name: "reach throttle", "right knee clear of the panel": unique in a result; criterion: the
    criterion of the study that it belongs to; check: as of the criterion; target: the control or part; zone: of a reach, 0 of others.
    """

    name: str
    criterion: str
    check: str
    target: str
    zone: int = 0

    @property
    def of_surface(self) -> bool:
        """Whether its margin is a distance of the body's surface."""
        return self.check in OF_SURFACE

    @property
    def of_sight(self) -> bool:
        """Whether any part that is moved may change its margin, since it may stand before the eyes."""
        return self.check in OF_SIGHT

    @property
    def unit(self) -> Unit:
        """The unit in which its margin is read."""
        return unit_of(self.check)


@dataclass(frozen=True)
class GroupShare:
    """The share, 0 to 1, of a group ("everybody", "women", "75 % men") that is served, with its
    interval.

    certain, possible: the share that is served wherever the true surface of the body lies within
    its fit error, and the share that is served if it lies where it suits; NaN where not known.
    clear: the share that is served and overlaps nothing by more than is allowed, whether a
    criterion asks about it or not; NaN where not known.
    """

    group: str
    share: float
    low: float
    high: float
    count: int
    certain: float = math.nan
    possible: float = math.nan
    clear: float = math.nan

    @property
    def undecided(self) -> float:
        """The share that is served or not by where the true surface lies."""
        return self.possible - self.certain

    def leaves_open(self, wanted: float) -> bool:
        """Whether it depends on where the true surface lies if so large a share is served."""
        least = wanted - SHARE_TOLERANCE
        return self.certain < least <= self.possible


@dataclass(frozen=True)
class DesignChange:
    """What a change of the design would gain, found from the margins and confirmed by a run with
    the change made.

    words: "moving flaps 32 mm aft"; requirement: the one it is for; move [m], 0 of what turns; rate: share gained by
    a metre, and margin_rate: metres by which the margin grows with a metre, mean of those who do
    not meet the requirement, both at the design as it is; before, after: the share that meets the
    requirement without and with the change (run again); joint_before, joint_after: the share that
    meets all; limit: that it, or where it was cut down a longer move, would put a part into another one, "" where none is.
    """

    words: str
    requirement: str
    move: float
    rate: float
    before: float
    after: float
    joint_before: float
    joint_after: float
    margin_rate: float = math.nan
    limit: str = ""


@dataclass(frozen=True, eq=False)
class ReachMap:
    """The share of people who reach or see each point of a part: points and normals (M, 3) [m], share (M,)
    0 to 1; flat (M, 2) [m]: the points in the part's main plane, first to the sitter's right, then
    up."""

    task: MapTask
    points: Floats
    normals: Floats
    flat: Floats
    share: Floats

    __repr__ = short_repr
