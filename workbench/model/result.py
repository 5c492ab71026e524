"""The result of a study: verdicts, what was found of people, motions and populations, provenance.

It is data only; pictures, tables and words are made from it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.errors import InputError, one_of
from workbench.model.accommodation import GroupShare
from workbench.model.arguments import above, checked, short_repr
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.contacts import Clearance, Contacts, Episodes
from workbench.model.criterion import Criterion, Finding
from workbench.model.envelope import Envelope
from workbench.model.environment import Environment
from workbench.model.motion_case import (
    Agreement,
    Excursion,
    ForceCurve,
    Meeting,
    MotionCase,
    Signal,
    StopBreach,
)
from workbench.model.population_found import PopulationFound
from workbench.model.poses import Placed, Poses
from workbench.model.reason import Reason
from workbench.model.study import Role, Study

__all__ = [
    "ControlReach",
    "Finding",
    "MotionFound",
    "PersonFound",
    "PosturesFound",
    "Result",
    "Shortfall",
    "Verdict",
]


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
        What misses it: "eyes", "seat", "thighs", or the limb, as "left foot".
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
    meetings: tuple[Meeting, ...]
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
        html: str = above("report.notebook", "result_html")(self)
        return html

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
