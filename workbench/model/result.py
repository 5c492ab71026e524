"""The result of a study: verdicts, what was found of people, motions and populations, provenance.

It is data only; pictures, tables and words are made from it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError, one_of
from workbench.model.accommodation import (
    DesignChange,
    GroupShare,
    ReachMap,
    Requirement,
    certainly_met,
    met_of,
    possibly_met,
)
from workbench.model.arguments import above, checked, short_repr
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.contacts import Clearance, Contacts, Episodes
from workbench.model.criterion import Criterion, Finding, Reason
from workbench.model.envelope import Envelope
from workbench.model.environment import Adjustment, Environment
from workbench.model.motion_case import (
    Agreement,
    ContactEvent,
    Excursion,
    ForceCurve,
    MotionCase,
    Signal,
    StopBreach,
)
from workbench.model.population import Population
from workbench.model.poses import Placed, Poses
from workbench.model.study import Role, Study
from workbench.model.workplace import Workplace

__all__ = [
    "ChangedPerson",
    "ControlReach",
    "Finding",
    "GripFinding",
    "Illustration",
    "MotionFound",
    "PeopleOverlap",
    "PersonFound",
    "PopulationFound",
    "PosturesFound",
    "Result",
    "Shortfall",
    "TriedChange",
    "Verdict",
]


@dataclass(frozen=True, eq=False)
class Illustration:
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
    before: Illustration
    after: Illustration

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

    gain: DesignChange
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
    refused
        In words the changes that would gain and are not proposed, since they put a part into another
        one.
    ends
        Of the area to step in, by what an end is called: (P,) who is left out, stands at it and would
        miss less beyond it.
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
    shown: tuple[Illustration, ...] = ()
    beheld: tuple[Illustration, ...] = ()
    overlaps: tuple[PeopleOverlap, ...] = ()
    grips: tuple[GripFinding, ...] = ()
    refused: tuple[str, ...] = ()
    ends: Mapping[str, Bools] = field(default_factory=dict)
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
    def gains(self) -> tuple[DesignChange, ...]:
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


@dataclass(frozen=True)
class ControlReach:
    """How one person reaches one control in one harness zone, by the hand (or foot) that does it
    best.

    miss [m]: how far the grip stays from it, overlap [m]: how far obstacles are still entered
    there; limit: what limits it; spare [m]: how much farther out from the shoulder or hip
    the limb would get, 0.2 at most and obstacles aside, None where it is missed or no criterion asks
    for it in this zone; discomfort as in `Reach`. doubt: one of DOUBTS, how a doubt ended that
    obstacles raised. case: the name of the case whose posture it begins from; hand: the one that was
    asked for, "" for either.
    """

    person: str
    control: str
    zone: int
    own_zone: int
    limb: str
    reached: bool
    miss: float
    overlap: float
    limit: Reason
    spare: float | None
    discomfort: float
    doubt: str
    case: str = ""
    hand: str = ""


@dataclass(frozen=True)
class Shortfall:
    """One aim of a posture that is missed: what a case asks of eyes, seat, hands and feet.

    Parameters
    ----------
    person, case
        The names of the role and of the case.
    what
        What misses it: "eyes too low", "eyes too high", "seat", "thighs", or the limb, as "left foot".
    words, why
        What is missed, and what limits it, "" where that is not known.
    size
        [m] by how much.
    """

    person: str
    case: str
    what: str
    words: str
    why: str
    size: float

    @property
    def sentence(self) -> str:
        """ "pilot, flying: the eyes stay 56 mm below left_design_eye: the seat is as high as it
        goes"."""
        why = f": {self.why}" if self.why else ""
        return f"{self.person}, {self.case}: {self.words}{why}"


@dataclass(frozen=True, repr=False)
class Verdict:
    """How one criterion came out.

    Parameters
    ----------
    worst
        The finding nearest to failing, None where nothing could be measured.
    breaches
        All findings that fail, worst first.
    doubtful
        A finding by which the verdict could turn because the body's surface is not known any
        better; None where nothing is in doubt.
    motion
        The motion that it is about, by its case, "" where it is about all its cases.
    row
        The size of the person who takes a role that several sizes take one at a time, else "".
    share
        Of a population: the share of people, with its interval.
    words
        Why there is no finding, "" where the report has its own words.
    """

    criterion: Criterion
    passed: bool
    worst: Finding | None
    breaches: tuple[Finding, ...] = ()
    doubtful: Finding | None = None
    motion: str = ""
    row: str = ""
    share: GroupShare | None = None
    words: str = ""

    def __repr__(self) -> str:
        row = f", {self.row or self.motion}" if self.row or self.motion else ""
        margin = f", margin {self.worst.margin:.4g} {self.worst.unit}" if self.worst else ""
        verdict = "passed" if self.passed else "FAILED"
        return f"Verdict({self.criterion.name}{row}: {verdict}{margin})"


@dataclass(frozen=True, eq=False)
class PersonFound:
    """What was found of one person in P cases.

    Parameters
    ----------
    role
        Who it is.
    poses
        (P,) as checked, in the world.
    placed
        (P,) the body at its size, dressed, in the world.
    postures
        (P,) the name of each posture, "predicted" or "driver".
    forward, up
        [m] the position of the seat.
    margin, margin_motion
        (P, J) [rad] joint-stop margins, infinite where free; and the motion nearest its stop.
    """

    role: Role
    poses: Poses
    placed: Placed
    postures: tuple[str, ...]
    forward: float
    up: float
    contacts: Contacts
    self_contacts: Contacts
    clearance: Clearance
    margin: Floats
    margin_motion: tuple[tuple[str, ...], ...]

    __repr__ = short_repr

    @property
    def name(self) -> str:
        """The name of the role."""
        return self.role.name

    @property
    def body(self) -> Body:
        """The body at its size, dressed."""
        return self.placed.body


@dataclass(frozen=True, eq=False, repr=False)
class PosturesFound:
    """What was found of people in postures.

    Parameters
    ----------
    study
        The study, with one size of each role.
    cases
        The names of the cases that are postures.
    environment
        As it was checked, with the seats where the people have put them.
    between
        Contacts of each pair of people, by their names.
    short
        What the postures miss of what the cases ask of them, among the warnings too.
    reaches, envelopes
        How people reach controls, and how far all around.
    row
        The size of the person who takes a role that several sizes take one at a time, else "".
    """

    study: Study
    cases: tuple[str, ...]
    environment: Environment
    verdicts: tuple[Verdict, ...]
    people: tuple[PersonFound, ...]
    between: Mapping[tuple[str, str], Contacts]
    warnings: tuple[str, ...]
    short: tuple[Shortfall, ...] = ()
    reaches: tuple[ControlReach, ...] = ()
    envelopes: tuple[Envelope, ...] = ()
    row: str = ""

    def __repr__(self) -> str:
        held = sum(verdict.passed for verdict in self.verdicts)
        asked = f"{held} of {len(self.verdicts)} criteria hold"
        return f"PosturesFound({self.who} in {', '.join(self.cases)}: {asked})"

    @property
    def passed(self) -> bool:
        """True where every criterion holds."""
        return all(verdict.passed for verdict in self.verdicts)

    @property
    def who(self) -> str:
        """The names of the people in words: "pilot", "pilot and guest", "pilot, guest and child"."""
        *before, last = (person.name for person in self.people)
        return f"{', '.join(before)} and {last}" if before else last


@dataclass(frozen=True, eq=False)
class MotionFound:
    """What was found of the motion of one person in one case.

    Parameters
    ----------
    clearance
        (P, N) [m] of each segment from everything it may not touch, at each frame.
    excursions
        The farthest that is got, by the name of the criterion that asks for it.
    forces
        Of the pairs that have a law and touch, and the tensions of belts.
    """

    study: MotionCase
    episodes: Episodes
    meetings: tuple[ContactEvent, ...]
    breaches: tuple[StopBreach, ...]
    signals: tuple[Signal, ...]
    clearance: Floats
    excursions: Mapping[str, Excursion]
    verdicts: tuple[Verdict, ...]
    warnings: tuple[str, ...]
    forces: tuple[ForceCurve, ...] = ()

    __repr__ = short_repr

    @property
    def passed(self) -> bool:
        """True where every criterion holds."""
        return all(verdict.passed for verdict in self.verdicts)


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """The result of a study.

    Parameters
    ----------
    verdicts
        Of all criteria that pass or fail, those of a motion motion by motion.
    provenance
        Hashes of the input files and versions of what computed.
    postures, motions, population
        What was found of people in postures (for each of several sizes), of each motion, of a
        population: what the study has.
    agreements
        How near the second of two motions that are compared is to the first.
    """

    study: Study
    verdicts: tuple[Verdict, ...]
    warnings: tuple[str, ...]
    provenance: Mapping[str, Mapping[str, str]]
    postures: tuple[PosturesFound, ...] = ()
    motions: tuple[MotionFound, ...] = ()
    agreements: tuple[Agreement, ...] = ()
    population: PopulationFound | None = None

    def __repr__(self) -> str:
        held = sum(verdict.passed for verdict in self.verdicts)
        words = [f"{held} of {len(self.verdicts)} criteria hold"] if self.verdicts else []
        if self.population is not None:
            served = self.population.served
            words.append(f"{int(served.sum())} of {len(served)} people fit")
        return f"Result({self.study.name}: {', '.join(words) or 'nothing is asked'})"

    def _repr_html_(self) -> str:
        return above("report.notebook", "result_html")(self)

    @checked
    def verdict(self, criterion: str) -> Verdict:
        """The verdict of a criterion by its name; the worst where sizes or motions have one each.

        Raises
        ------
        InputError
            If no criterion with a verdict is called so.
        """
        names = list(dict.fromkeys(verdict.criterion.name for verdict in self.verdicts))
        if criterion not in names:
            what = f"no verdict is about {criterion!r}; {one_of(criterion, names)}"
            raise InputError(f"result of {self.study.name}: {what}")
        found = (verdict for verdict in self.verdicts if verdict.criterion.name == criterion)
        return min(found, key=lambda one: (one.passed, one.worst.margin if one.worst else math.inf))

    def tables(self) -> dict[str, dict[str, NDArray[np.generic]]]:
        """Return the tables that a result folder has as CSV, as arrays by column.

        Returns
        -------
        dict
            By the name of a table ("verdicts", "breaches"; of postures "contacts", "clearance",
            "stops", "postures", "placements", "reaches"; of motions "contacts", "figures",
            "signals"; of a population "people", "requirements", "shares", "gains"; what the result
            has), by the name of a column an array with a value a row: numbers with NaN where there
            is none, truth values, or texts. Lengths are in millimetres, as the names say.
        """
        tables: dict[str, dict[str, NDArray[np.generic]]]
        tables = above("report.result_rows", "result_columns")(self)
        return tables

    @checked
    def to_dataframe(self, table: str = "") -> Any:
        """Return one of the tables as a pandas.DataFrame.

        Parameters
        ----------
        table
            Its name, see `tables`. If "": "people" of a population (everybody with the margin of
            each requirement), else "verdicts".

        Raises
        ------
        MissingPartError
            If pandas is not installed.
        UsageError
            If the result has no such table.
        """
        return above("report.result_rows", "result_frame")(self, table)

    @property
    def passed(self) -> bool:
        """True where every criterion holds."""
        return all(verdict.passed for verdict in self.verdicts)
