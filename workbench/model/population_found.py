"""What was found of a population."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from workbench.model.accommodation import (
    Gain,
    GroupShare,
    ReachMap,
    Requirement,
    certainly_met,
    met_of,
    possibly_met,
)
from workbench.model.arguments import short_repr
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.criterion import Finding
from workbench.model.environment import Adjustment, Environment
from workbench.model.population import Population
from workbench.model.poses import Placed, Poses
from workbench.model.reason import Reason
from workbench.model.study import Study
from workbench.model.workplace import Workplace

__all__ = [
    "ChangedPerson",
    "GripFinding",
    "PeopleOverlap",
    "PopulationFound",
    "Shown",
    "TriedChange",
]


@dataclass(frozen=True, eq=False)
class Shown:
    """One of the hardest people as found at the worst requirement, to be drawn.

    row: of the person; requirement: index of the worst; case: the name of the case; body, poses:
    the person in one pose, in the attempt where it is a reach; placed: the same; environment: with the seat where this person sits. limb: "right
    hand" of a reach, else what comes too near ("right shin"), "" where nothing is to be named.
    target, tip (3,) [m] in the world: where the limb was to go and where it got, or the two nearest
    points of a clearance; None where there is nothing to point at. finding: of a criterion of sight
    what is measured, None of others.
    """

    row: int
    requirement: int
    case: str
    poses: Poses
    placed: Placed
    environment: Environment
    limb: str = ""
    target: tuple[float, float, float] | None = None
    tip: tuple[float, float, float] | None = None
    finding: Finding | None = None

    __repr__ = short_repr


@dataclass(frozen=True)
class PeopleOverlap:
    """Two things that overlap in some people more than is allowed, about which no criterion asks.

    Parameters
    ----------
    segment
        Of the body, in words.
    part, other_segment
        The part that it is in, else the other segment of the same body; "" for the other one.
    people, share
        How many people, and their weighted share.
    deepest, person
        [m] beyond what is allowed, of the person (row) of whom it is the most.
    """

    segment: str
    part: str
    other_segment: str
    people: int
    share: float
    deepest: float
    person: int


@dataclass(frozen=True)
class GripFinding:
    """A grip with which nobody, or almost nobody, uses a control, since it is flat.

    Parameters
    ----------
    requirement
        The name of the reach that is asked for.
    control, grip
        The control, and how it is gripped.
    thickness
        [m] of the part that it is on.
    some
        Whether a few do.
    other, share, people
        Another grip, the share of so many people, 0 to 1, that reach it so.
    """

    requirement: str
    control: str
    grip: str
    thickness: float
    some: bool
    other: str
    share: float
    people: int


@dataclass(frozen=True, eq=False)
class ChangedPerson:
    """Somebody who gains or loses by a change of the design, as found in both designs at the
    requirement that decides it.

    Parameters
    ----------
    row
        Of the person.
    before, after
        The person in either design.
    """

    row: int
    before: Shown
    after: Shown

    __repr__ = short_repr


@dataclass(frozen=True, eq=False)
class TriedChange:
    """A change of the design as it was tried.

    Parameters
    ----------
    gain
        What it gains.
    person
        Who lacked most of its requirement and meets it by the change, with everything else as far as
        anybody does; None where nobody meets it.
    margins
        [m] What that person has to spare at the requirement in either design, negative what is
        lacking.
    """

    gain: Gain
    person: ChangedPerson | None = None
    margins: tuple[float, float] = (0.0, 0.0)

    __repr__ = short_repr


@dataclass(frozen=True, eq=False, repr=False)
class PopulationFound:
    """What was found of a population: P people, R requirements.

    A person fits who meets all requirements in some position of the seat, and some setting of what
    may be adjusted.

    Parameters
    ----------
    place
        The workplace that they take.
    people
        The P people, drawn where they are to be drawn.
    body
        The body that everybody is made from, at the level of detail that is checked.
    margin
        (P, R) [m] to spare in the fitting position nearest to the comfortable one; where none fits,
        in that of the least shortfall. Negative where the requirement is not met by so much, NaN
        where it does not apply.
    low, high
        (P, R) [m] between which that margin truly lies, by how far the surface of the body may lie
        outside and inside its spheres; the margin itself where it does not depend on the surface,
        NaN where the fit error of the body is not known.
    reason, reasons
        (P, R) index into `reasons`, what limits; -1 where nothing does.
    seat, comfortable
        (P, 2) [m] that position and the comfortable one, forward and up.
    window
        (P, 4) [m] the least and greatest forward, least and greatest up of the positions tried that
        fit. NaN where the comfortable one fits (then no other is tried) and where none does.
    sets
        (P, K) whether some position meets all requirements without one (the first R), without
        those of a criterion (the next C), or those of a share that is asked for.
    setting
        (P, A) [m or rad] the setting of the adjustments of the workplace that the margins are of.
    limiting
        (P,) the measure that is oddest of the person and bears on the worst requirement, "" for
        whom all is met.
    shares
        Who fits, by group.
    single, only, without
        (R,) the share that meets a requirement in the position of the margins; that misses it there
        and nothing else; that would fit, in whatever position, if it were dropped.
    spread
        (R, 5) [m] margins at 1, 5, 50, 95 and 99 % of the (weighted) people.
    tried
        The changes that were tried.
    grips
        Controls that nobody uses with the grip that is asked for, since they are flat.
    hardest, shown
        Rows of the people farthest from being served, at most five, first who misses most of what
        most people miss, then worst first; whoever comes nearest to missing anything where nobody
        does; and the same people to be drawn.
    beheld
        For each criterion of sight whoever comes nearest to missing it, met or not, with what is
        measured.
    overlaps, overlapping
        What overlaps by more than is allowed though no criterion asks about it; and (P,) of whom
        that is so.
    elsewhere
        (P,) who meets everything for certain in another position than that of the margins.
    """

    study: Study
    place: Workplace
    people: Population
    body: Body
    requirements: tuple[Requirement, ...]
    margin: Floats
    low: Floats
    high: Floats
    reason: Ints
    reasons: tuple[Reason, ...]
    seat: Floats
    comfortable: Floats
    window: Floats
    sets: Bools
    setting: Floats
    limiting: tuple[str, ...]
    shares: tuple[GroupShare, ...]
    single: Floats
    without: Floats
    only: Floats
    spread: Floats
    hardest: tuple[int, ...]
    tried: tuple[TriedChange, ...]
    maps: tuple[ReachMap, ...]
    warnings: tuple[str, ...]
    shown: tuple[Shown, ...] = ()
    beheld: tuple[Shown, ...] = ()
    overlaps: tuple[PeopleOverlap, ...] = ()
    grips: tuple[GripFinding, ...] = ()
    overlapping: Bools = field(kw_only=True)
    elsewhere: Bools = field(kw_only=True)

    def looked_at(self, row: int) -> int:
        """The requirement that one of the people is looked at for: where drawn, else the one that
        is missed by most."""
        drawn = (one.requirement for one in self.shown if one.row == row)
        return next(drawn, int(np.nanargmin(self.margin[row])))

    def __repr__(self) -> str:
        served = f"{int(self.served.sum())} of {len(self.served)} people fit"
        return (
            f"PopulationFound({self.study.name}: {served}, {len(self.requirements)} requirements)"
        )

    @property
    def gains(self) -> tuple[Gain, ...]:
        """What the changes that were tried gain."""
        return tuple(change.gain for change in self.tried)

    @property
    def moved(self) -> Bools:
        """(P,) who fits with all at its nominal setting, but not in the comfortable position."""
        elsewhere = np.isfinite(self.window[:, 0]) & self.served & ~self.adjusted
        return np.asarray(elsewhere, dtype=np.bool_)

    @property
    def adjustments(self) -> tuple[Adjustment, ...]:
        """The A adjustments that the people may make."""
        return tuple(self.place.environment.adjustment(name) for name in self.place.adjusts)

    @property
    def adjusted(self) -> Bools:
        """(P,) who fits, but only with something set otherwise than nominally."""
        nominal = np.array([one.at for one in self.adjustments])
        away = (self.setting != nominal).any(axis=1)
        return np.asarray(away & self.served, dtype=np.bool_)

    @property
    def met(self) -> Bools:
        """(P, R) whether each person meets each requirement; what does not apply is met."""
        return met_of(self.margin)

    @property
    def served(self) -> Bools:
        """(P,) whether a person meets all requirements."""
        return np.asarray(np.all(self.met, axis=1), dtype=np.bool_)

    @property
    def clear(self) -> Bools:
        """(P,) whether a person meets all requirements and overlaps nothing by more than is
        allowed."""
        return self.served & ~self.overlapping

    @property
    def certain(self) -> Bools:
        """(P, R) whether a requirement is met wherever the true surface lies, in the position of the
        margins or another one in which all are."""
        return certainly_met(self.margin, self.low) | self.elsewhere[:, None]

    @property
    def possible(self) -> Bools:
        """(P, R) whether a requirement is met if the true surface lies where it suits."""
        return possibly_met(self.margin, self.high)

    @property
    def undecided(self) -> Bools:
        """(P,) whether a person fits or not by where the true surface lies; also where it is not
        known how far from the spheres that may be."""
        return np.asarray(~self.certain.all(axis=1) & self.possible.all(axis=1), dtype=np.bool_)

    @property
    def known(self) -> Bools:
        """(P, R) whether it is known between which bounds a margin truly lies."""
        bounded = ~np.isnan(self.low) & ~np.isnan(self.high)
        return np.asarray(np.isnan(self.margin) | bounded, dtype=np.bool_)

    @property
    def of_surface(self) -> Bools:
        """(R,) whether a margin depends on where the surface of the body truly lies."""
        return np.array([one.of_surface for one in self.requirements], dtype=np.bool_)
