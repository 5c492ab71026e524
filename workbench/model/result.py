"""Result: verdicts, tables and provenance of a study; data first, pictures and words are views of
it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.model.arrays import Floats
from workbench.model.contacts import Clearance, Contacts
from workbench.model.criterion import Criterion
from workbench.model.envelope import Envelope
from workbench.model.environment import Environment
from workbench.model.poses import Placed
from workbench.model.posture_study import PostureStudy

__all__ = ["ControlReach", "Finding", "PersonResult", "Result", "Verdict"]


@dataclass(frozen=True)
class Finding:
    """One measured value of a criterion.

    case: index; person, other_person: names ("" where there is none); subject, target: both sides
    in words; value: [m] or [rad], to be compared with `limit`; point [m] in the world, None where
    there is none. surface_known_to [m]: how far the true surface may lie outside the spheres where
    the value is within its limit, inside them where it is beyond; of two bodies both together; NaN
    where not known.
    """

    case: int
    person: str
    other_person: str
    subject: str
    target: str
    value: float
    limit: float
    point: tuple[float, float, float] | None = None
    surface_known_to: float = math.nan

    @property
    def doubt(self) -> float:
        """How far the body's surface, where it truly is, may lie beyond the limit [m]; negative
        where it cannot, NaN where it is not known."""
        return self.surface_known_to - abs(self.value - self.limit)


@dataclass(frozen=True)
class ControlReach:
    """How one person reaches one control in one harness zone, by the hand (or foot) that does it
    best.

    miss [m]: how far the grip stays from it, overlap [m]: how far obstacles are still entered
    there; limit: what limits it, in words; discomfort as in `Reach`. case: index of the case whose
    posture it begins from; hand: the one that was asked for, "" for either.
    """

    person: str
    control: str
    zone: int
    own_zone: int
    limb: str
    reached: bool
    miss: float
    overlap: float
    limit: str
    discomfort: float
    case: int = 0
    hand: str = ""


@dataclass(frozen=True)
class Verdict:
    """How one criterion came out: `worst` is the finding nearest to failing (None where nothing
    could be measured), `breaches` are all that fail, worst first. doubtful: a finding by which the
    verdict could turn, the body's surface not being known any better; None where nothing is in
    doubt."""

    criterion: Criterion
    passed: bool
    worst: Finding | None
    breaches: tuple[Finding, ...]
    doubtful: Finding | None = None


@dataclass(frozen=True, eq=False)
class PersonResult:
    """What was found for one person, over all P cases.

    margin (P, J) [rad]: joint-stop margins, infinite where free; margin_motion (P, J): the motion
    nearest its stop.
    """

    name: str
    placed: Placed
    contacts: Contacts
    self_contacts: Contacts
    clearance: Clearance
    margin: Floats
    margin_motion: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, eq=False)
class Result:
    """The result of a study.

    environment: as it was checked, seats adjusted. between: contacts of each pair of people, by
    their names. provenance: the input files' hashes and the versions of what computed. reaches: how
    people reach controls, of a reach study; envelopes: how far they reach all around.
    """

    study: PostureStudy
    environment: Environment
    verdicts: tuple[Verdict, ...]
    people: tuple[PersonResult, ...]
    between: Mapping[tuple[str, str], Contacts]
    provenance: Mapping[str, Mapping[str, str]]
    warnings: tuple[str, ...]
    reaches: tuple[ControlReach, ...] = ()
    envelopes: tuple[Envelope, ...] = ()

    @property
    def passed(self) -> bool:
        """True where every criterion holds."""
        return all(verdict.passed for verdict in self.verdicts)
