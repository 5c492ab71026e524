"""Accommodation: everybody of a population in one workplace, what is asked of each, and who is left
out by what."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.encumbrance import Encumbrance
from workbench.model.environment import Environment
from workbench.model.population import Population
from workbench.model.poses import Placed, Poses
from workbench.model.posture_study import Aims

__all__ = [
    "MAP_POINTS",
    "MET",
    "AccommodationStudy",
    "Change",
    "Gain",
    "GroupShare",
    "IntervalRule",
    "MapTask",
    "PopulationFound",
    "ReachMap",
    "Requirement",
    "Shown",
]

MAP_POINTS = 3, 20_000
"""The fewest and the most points that a population reach map may have."""
MET = 1e-6
"""A margin [m] down to which a requirement counts as met: below what any length here is known
to."""


@dataclass(frozen=True)
class MapTask:
    """A population reach map that a study asks for: a part's surface with so many points on it, by
    which hands, grip and zone; hands: left, right or either."""

    part: str
    grip: str
    zone: int
    hand: str
    points: int


@dataclass(frozen=True)
class Change:
    """A change of the design: a control (with the part it is on) or parts moved by `move` (3,) [m];
    or the ends of the seat's travel moved: lower and upper end of it, forward and up [m]."""

    words: str
    control: str = ""
    parts: tuple[str, ...] = ()
    move: tuple[float, float, float] = (0.0, 0.0, 0.0)
    travel_forward: tuple[float, float] = (0.0, 0.0)
    travel_up: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class IntervalRule:
    """How a share's interval is found: method "wilson" or "bootstrap", with its seed and number of
    draws."""

    method: str = "wilson"
    seed: int = 0
    draws: int = 10_000


@dataclass(frozen=True, eq=False)
class AccommodationStudy:
    """An accommodation study ready to run: one seat, one population, many criteria.

    body: the family's body that every person is made from, at the level of detail that is checked;
    people: one row a person; aims: what a sitter's posture is predicted from; like: the named
    posture of trunk and head; mixes: by name, the share of women that the people are weighted to;
    confidence (0 to 1) and interval: of the shares; changes: those whose gain is asked for, looked
    for by the study itself where there are none; pose (P = 1): the posture `like` of the body, None
    where the study is not to be run.
    """

    name: str
    title: str
    description: str
    environment: Environment
    body: Body
    wears: tuple[Encumbrance, ...]
    people: Population
    seat: str
    aims: Aims
    like: str
    criteria: tuple[Criterion, ...]
    mixes: Mapping[str, float]
    confidence: float
    maps: tuple[MapTask, ...]
    inputs: Mapping[str, Path]
    seed: int | None = None
    warnings: tuple[str, ...] = ()
    changes: tuple[Change, ...] = ()
    pose: Poses | None = None
    interval: IntervalRule = IntervalRule()
    share_criteria: tuple[Criterion, ...] = ()
    role: str = ""


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


@dataclass(frozen=True)
class GroupShare:
    """The share, 0 to 1, of a group ("everybody", "women", "75 % men") that is served, with its
    interval."""

    group: str
    share: float
    low: float
    high: float
    count: int


@dataclass(frozen=True)
class Gain:
    """What a change of the design would gain, found from the margins and confirmed by a run with
    the change made.

    words: "moving flaps 32 mm aft"; requirement: the one it is for; move [m]; rate: share gained by
    a metre, and margin_rate: metres by which the margin grows with a metre, mean of those who do
    not meet the requirement, both at the design as it is; before, after: the share that meets the
    requirement without and with the change (run again); joint_before, joint_after: the share that
    meets all.
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


@dataclass(frozen=True, eq=False)
class ReachMap:
    """The share of people who reach each point of a part: points and normals (M, 3) [m], share (M,)
    0 to 1; flat (M, 2) [m]: the points in the part's main plane, first to the sitter's right, then
    up."""

    task: MapTask
    points: Floats
    normals: Floats
    flat: Floats
    share: Floats


@dataclass(frozen=True, eq=False)
class Shown:
    """One of the hardest people as found at the worst requirement, to be drawn.

    row: of the person; requirement: index of the worst; placed: the body in one pose, in the
    attempt where it is a reach; environment: with the seat where this person sits. limb: "right
    hand" of a reach, else what comes too near ("right shin"), "" where nothing is to be named.
    target, tip (3,) [m] in the world: where the limb was to go and where it got, or the two nearest
    points of a clearance; None where there is nothing to point at.
    """

    row: int
    requirement: int
    placed: Placed
    environment: Environment
    limb: str = ""
    target: tuple[float, float, float] | None = None
    tip: tuple[float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class PopulationFound:
    """What was found of a population: P people, R requirements.

    A person fits who meets all requirements in some position of the seat.

    Parameters
    ----------
    margin
        (P, R) [m] to spare in the fitting position nearest to the comfortable one; where none fits,
        in that of the least shortfall. Negative where the requirement is not met by so much, NaN
        where it does not apply.
    reason, reasons
        (P, R) index into `reasons`, what limits in words; -1 where nothing does.
    seat, comfortable
        (P, 2) [m] that position and the comfortable one, forward and up.
    window
        (P, 4) [m] the least and greatest forward, least and greatest up of the positions tried that
        fit. NaN where the comfortable one fits (then no other is tried) and where none does.
    sets
        (P, K) whether some position meets all requirements without one (the first R), without
        those of a criterion (the next C), or those of a share that is asked for.
    limiting
        (P,) the measure that is oddest of the person and bears on the worst requirement, "" for
        whom all is met.
    shares
        Who fits, by group.
    single, without, alone
        (R,) the share that meets a requirement in the position of the margins; that would fit if it
        were dropped; that is left out by nothing but it.
    spread
        (R, 5) [m] margins at 1, 5, 50, 95 and 99 % of the (weighted) people.
    hardest, shown
        Rows of the people farthest from being served, worst first, at most five; and the same
        people to be drawn.
    """

    study: AccommodationStudy
    requirements: tuple[Requirement, ...]
    margin: Floats
    reason: Ints
    reasons: tuple[str, ...]
    seat: Floats
    comfortable: Floats
    window: Floats
    sets: Bools
    limiting: tuple[str, ...]
    shares: tuple[GroupShare, ...]
    single: Floats
    without: Floats
    alone: Floats
    spread: Floats
    hardest: tuple[int, ...]
    gains: tuple[Gain, ...]
    maps: tuple[ReachMap, ...]
    warnings: tuple[str, ...]
    shown: tuple[Shown, ...] = ()

    @property
    def moved(self) -> Bools:
        """(P,) who fits, but not in the comfortable position."""
        return np.asarray(np.isfinite(self.window[:, 0]) & self.served, dtype=np.bool_)

    @property
    def met(self) -> Bools:
        """(P, R) whether each person meets each requirement; what does not apply is met."""
        return np.asarray(np.isnan(self.margin) | (self.margin >= -MET), dtype=np.bool_)

    @property
    def served(self) -> Bools:
        """(P,) whether a person meets all requirements."""
        return np.asarray(np.all(self.met, axis=1), dtype=np.bool_)
