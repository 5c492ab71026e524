"""What reaches came to that are asked for over and over, from one position of the seat after the
other.

A reach that obstacles keep from its target is searched for whole once: from hundreds of starts, in
some 9,000 steps. In another position the posture that came nearest is a good start, and so is one
that reached. These and a few others find nearly all that the whole search finds, in some 200 steps.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.posture.kernels.clear_reach import (
    BURIED,
    CERTAIN,
    FEW_STARTS,
    KEPT,
    KNOWN_POSTURES,
    NO_ROOM,
    SKIPPED,
    WHOLE,
    Outcome,
)
from workbench.posture.reaching.limbs import Limb
from workbench.posture.reaching.reach_solver import LimbTask

__all__ = ["ReachHistory", "Recall", "known_of"]

REACHED_AT, NEAREST_AT = range(KNOWN_POSTURES)


@dataclass(frozen=True, eq=False)
class _Known:
    """What N reaches of one limb in one harness zone came to.

    Parameters
    ----------
    angles
        (N, KNOWN_POSTURES, K, 3) [rad] the last posture that reached the target, and the last that
        came nearest to it.
    held
        (N, KNOWN_POSTURES) whether there is such a posture.
    searched
        (N,) whether a whole search has found no reach once.
    """

    angles: Floats
    held: Bools
    searched: Bools


@dataclass(frozen=True, eq=False)
class ReachHistory:
    """What N reaches came to, each of a person for a target, by limb and harness zone."""

    count: int
    known: dict[tuple[str, int], _Known] = field(default_factory=dict)
    proofs: dict[str, Bools] = field(default_factory=dict)
    """By limb whether it is proved that the hand has no room at the target (N,)."""

    def no_room(self, limb: Limb) -> Bools:
        """(N,) of what it is proved that the hand has no room at the target; filled in place."""
        return self.proofs.setdefault(limb.name, np.zeros(self.count, dtype=np.bool_))

    def elsewhere(self) -> ReachHistory:
        """The same, where parts stand elsewhere: nothing is proved there yet."""
        return ReachHistory(self.count, self.known)

    def of(self, limb: Limb, joints: int) -> _Known:
        """What is known of a limb with so many joints."""
        key = limb.name, limb.zone
        if key not in self.known:
            shape = self.count, KNOWN_POSTURES
            self.known[key] = _Known(
                np.zeros((*shape, joints, 3)),
                np.zeros(shape, dtype=np.bool_),
                np.zeros(self.count, dtype=np.bool_),
            )
        return self.known[key]


@dataclass(frozen=True, eq=False)
class Recall:
    """The history of B people with T targets, as a reach uses it.

    Parameters
    ----------
    history
        It is made to hold what becomes of them.
    row
        (B, T) the row of each in the history.
    once
        Whether few starts are tried for what was searched for whole once.
    few_starts
        Whether few starts are tried for everything.
    skips_proved
        Whether what is proved to be kept is not brought near to its target.
    """

    history: ReachHistory
    row: Ints
    once: bool
    few_starts: bool = False
    skips_proved: bool = False

    def rows(self, keep: slice | Ints) -> Recall:
        """That of some of the people."""
        return replace(self, row=self.row[keep])

    def each(self) -> Recall:
        """That of a person for each reach, with one target."""
        return replace(self, row=self.row.reshape(-1, 1))

    def searched(self, limb: Limb) -> Bools:
        """(B, T) what was searched for whole once, with a limb in its own zone."""
        known = self.history.known.get((limb.name, limb.zone))
        return (
            np.zeros(self.row.shape, dtype=np.bool_) if known is None else known.searched[self.row]
        )

    def kept(self, limb: Limb) -> Bools:
        """(B, T) what obstacles have kept a limb from, in any zone."""
        found = np.zeros(self.row.shape, dtype=np.bool_)
        for (name, _), known in self.history.known.items():
            if name == limb.name:
                found |= known.held[self.row, NEAREST_AT]
        return found

    def prove(self, limb: Limb, people: Ints, target: int) -> None:
        """Hold that it is proved of some people that the hand has no room at a target."""
        self.history.no_room(limb)[self.row[people, target]] = True

    def keep(self, limb: Limb, out: Outcome) -> None:
        """Hold what became of the reaches (B T,) of a limb that obstacles put in doubt."""
        known = self.history.of(limb, out.angles.shape[1])
        row = self.row.ravel()
        kept = ((out.doubt == KEPT) | (out.doubt == BURIED)) & (out.effort != SKIPPED)
        for at, some in (
            (REACHED_AT, (out.doubt != CERTAIN) & (out.doubt < KEPT)),
            (NEAREST_AT, kept),
        ):
            known.angles[row[some], at] = out.angles[some]
            known.held[row[some], at] = True
        known.searched[row[kept & (out.effort != FEW_STARTS)]] = True
        self.history.no_room(limb)[row[out.effort == NO_ROOM]] = True


def known_of(
    task: LimbTask, *, effort: int = WHOLE, recall: Recall | None = None
) -> tuple[Ints, Floats, Bools]:
    """The effort, the known postures, and which of these there are, of the rows of a task, as
    `Outcome` has them."""
    count = len(task)
    joints = len(task.joints)
    if recall is None or effort != WHOLE:
        none = np.zeros((count, KNOWN_POSTURES), dtype=np.bool_)
        return np.full(count, effort), np.zeros((count, KNOWN_POSTURES, joints, 3)), none
    known = recall.history.of(task.limb, joints)
    row = recall.row.ravel()
    few = (known.searched[row] & recall.once) | recall.few_starts
    each = np.where(few, FEW_STARTS, WHOLE)
    proved = recall.history.no_room(task.limb)[row]
    each[proved] = SKIPPED if recall.skips_proved else NO_ROOM
    return each, known.angles[row], known.held[row]
