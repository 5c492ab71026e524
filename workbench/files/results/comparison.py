"""The published shape of comparison.json: two designs, the same people."""

from __future__ import annotations

from workbench.files.results.postures import Row

__all__ = ["MARK", "ChangedPersonRow", "ComparisonFile", "PairRow"]

MARK = "comparison.json"


class PairRow(Row):
    """Two shares of the same people, 0 to 1: of a group that meets everything, or of all who meet
    one requirement.

    gained and lost are people; difference is after - before with its interval (Newcombe 1998,
    method 10); chance is the two-sided probability of so uneven a count if nothing had changed
    (McNemar's exact test).
    """

    name: str
    people: int
    before: float
    after: float
    gained: int
    lost: int
    difference: float
    low: float
    high: float
    chance: float


class ChangedPersonRow(Row):
    """Somebody who fits only in one of the designs: what decides it there and here, in mm, and in
    words."""

    person: str
    row: int
    change: str
    sentence: str


class ComparisonFile(Row):
    """comparison.json. changes: what differs between the two designs, in words."""

    format: str = "bubbleman-workbench comparison 1"
    headline: str
    before: str
    after: str
    before_title: str
    after_title: str
    people: int
    confidence: float
    groups: list[PairRow]
    requirements: list[PairRow]
    changes: list[str] = []
    only_before: list[str]
    only_after: list[str]
    changed: list[ChangedPersonRow]
    provenance: dict[str, dict[str, str]]
