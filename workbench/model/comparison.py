"""Comparison: the same people in two designs, who gained, who lost, and by how much."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from workbench.errors import InputError
from workbench.model.accommodation import met_of
from workbench.model.arrays import Bools, Floats, Ints, read_only
from workbench.model.units import Unit

__all__ = ["Comparison", "Judged", "PairedShare"]


@dataclass(frozen=True, eq=False, repr=False)
class Judged:
    """People judged in one design: P people, R requirements, as a comparison needs them.

    labels (P): what each is called; sex (P,): index into SEXES; weight (P,); stature (P,) [m], NaN
    where not known; margin (P, R) [m]: NaN where a requirement does not apply; units (R): in which
    margins are read. who: a hash of the
    people and their measures. design: what they were judged in, in words by name; empty where it is
    not known.
    """

    name: str
    title: str
    requirements: tuple[str, ...]
    labels: tuple[str, ...]
    sex: Ints
    weight: Floats
    stature: Floats
    margin: Floats
    units: tuple[Unit, ...]
    who: str
    confidence: float = 0.95
    design: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        return (
            f"Judged({self.name}: {len(self.labels)} people, {len(self.requirements)} requirements)"
        )

    def __post_init__(self) -> None:
        people = len(self.labels)
        count = len(self.requirements)
        object.__setattr__(self, "sex", read_only(self.sex, np.int64, (people,), "judged.sex"))
        for name in ("weight", "stature"):
            object.__setattr__(
                self, name, read_only(getattr(self, name), np.float64, (people,), f"judged.{name}")
            )
        object.__setattr__(
            self, "margin", read_only(self.margin, np.float64, (people, count), "judged.margin")
        )
        if len(set(self.requirements)) < count:
            raise InputError(f"{self.name}: a requirement stands twice")

    def unit(self, name: str) -> Unit:
        """The unit in which the margins of a requirement are read, by its name."""
        return self.units[self.requirements.index(name)]

    @property
    def met(self) -> Bools:
        """(P, R) whether each person meets each requirement; what does not apply is met."""
        return met_of(self.margin)

    @property
    def served(self) -> Bools:
        """(P,) whether a person meets all requirements."""
        return np.asarray(np.all(self.met, axis=1), dtype=np.bool_)


@dataclass(frozen=True)
class PairedShare:
    """The shares, 0 to 1, of the same people served before and after a change.

    both, gained, lost, neither: the shares served in both, only after, only before, in none;
    gainers, losers: how many people those are. difference: after - before, low to high its interval
    at this confidence. chance: the two-sided probability of so uneven a count of gainers and losers
    if the change made no difference (McNemar's exact test).
    """

    name: str
    before: float
    after: float
    both: float
    gained: float
    lost: float
    neither: float
    gainers: int
    losers: int
    count: int
    difference: float
    low: float
    high: float
    chance: float
    confidence: float


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Two designs and the same people in both.

    groups: all requirements together, of everybody and of each sex; pairs: each requirement that
    both have, in the order of the first; changes: what differs between the designs, in words;
    gained, lost: rows of the people who fit only after, only
    before; only_before, only_after: the requirements that but one of them has.
    """

    before: Judged
    after: Judged
    groups: tuple[PairedShare, ...]
    pairs: tuple[PairedShare, ...]
    gained: tuple[int, ...]
    lost: tuple[int, ...]
    only_before: tuple[str, ...]
    only_after: tuple[str, ...]
    changes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"Comparison({self.before!r}, {self.after!r}: {len(self.gained)} gained, {len(self.lost)} lost)"
