"""Result: verdicts, tables and provenance of a study; data first, pictures and words are views of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.model.contacts import Clearance, Contacts
from workbench.model.poses import Placed
from workbench.model.study import Criterion, Study

__all__ = ["PersonResult", "Result", "Verdict"]


@dataclass(frozen=True)
class Verdict:
    """How one criterion came out: `worst` is the value nearest to failing ([m] or [rad]; None where nothing was to be
    measured), in words `finding`; `rows` in words each breach, worst first."""

    criterion: Criterion
    passed: bool
    worst: float | None
    finding: str
    rows: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class PersonResult:
    """What was found for one person, over all cases. `margin_limit` (P, J): the motion nearest to its stop."""

    name: str
    placed: Placed
    contacts: Contacts
    self_contacts: Contacts
    clearance: Clearance
    margin: tuple[tuple[float, ...], ...]
    margin_limit: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, eq=False)
class Result:
    """The result of a study. between: contacts of each pair of people, by both names; provenance: input hashes and
    versions."""

    study: Study
    verdicts: tuple[Verdict, ...]
    people: tuple[PersonResult, ...]
    between: Mapping[tuple[str, str], Clearance]
    between_contacts: Mapping[tuple[str, str], Contacts]
    provenance: Mapping[str, Mapping[str, str]]
    warnings: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """True where every criterion holds."""
        return all(verdict.passed for verdict in self.verdicts)
