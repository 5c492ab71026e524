"""Posture scores: bands of angles, and the score that a table gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.criterion import Work
from workbench.model.rule_set import RuleSet
from workbench.strain.working_angles import WorkingAngles

__all__ = [
    "ASKED_BY",
    "EDGE",
    "Part",
    "PostureScore",
    "banded",
    "flagged",
    "posture_score",
    "tabled",
    "upper_arm",
]

_OF_BOTH = ("load", "shock", "repeated", "static")
ASKED_BY = {
    "rula": (*_OF_BOTH, "arms_supported", "trunk_supported", "legs_balanced"),
    "reba": (*_OF_BOTH, "rapid", "coupling", "arms_supported", "legs_balanced", "stance"),
    "owas": ("load", "stance"),
}
"""What each method asks of `Work`."""
EDGE = 1e-8
"""[rad] An angle that is beyond an edge by less is on it: a posture that was stated as 20 degrees."""


@dataclass(frozen=True, eq=False)
class Part:
    """The score of a part of the body, (P,) or (P, 2) for its sides, and how far [rad] its angles are
    from the nearest edge of a band."""

    score: Ints
    distance: Floats

    def __add__(self, other: Part) -> Part:
        """The scores summed; the nearer edge counts."""
        return Part(self.score + other.score, np.minimum(self.distance, other.distance))


@dataclass(frozen=True, eq=False)
class PostureScore:
    """The score of P postures by one method.

    Parameters
    ----------
    method
        "RULA", "REBA" or "OWAS".
    score, level
        (P,) the score of the worse side, and its action level.
    by_side
        (P, 2) the scores of the left and the right side.
    parts
        (P, 2) the scores of parts and of intermediate tables, by name.
    to_next_band
        (P,) [rad] how far the nearest angle of the worse side is from another band of its part.
    next_part
        The part that this is, of each posture.
    version
        The table that was used.
    status
        Where its numbers are from, and how sure each is.
    assumed
        What was not stated, in words.
    """

    method: str
    score: Ints
    level: Ints
    by_side: Ints
    parts: dict[str, Ints]
    to_next_band: Floats
    next_part: tuple[str, ...]
    version: str
    status: str
    assumed: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.score)


def banded(angle: Floats, rules: RuleSet, name: str) -> Part:
    """The score of the band that each angle [rad] is in.

    The bands are between `NAME_edges`, their scores `NAME_scores`. An edge belongs to the band that
    is nearer to zero: 20 degrees to 0-20, -20 to -20-0. An edge of 0 belongs to the band above it.
    """
    edges = rules.shaped(f"{name}_edges", None)
    scores = rules.shaped(f"{name}_scores", len(edges) + 1)
    if np.any(np.diff(edges) <= 0.0):
        raise InputError(f"rule set {rules.name}: {name}_edges: expected angles that rise")
    inner = edges + np.where(edges > 0.0, EDGE, -EDGE)
    band = np.searchsorted(inner, angle, side="left")
    distance = np.min([np.abs(angle - edge) for edge in edges], axis=0)
    return Part(scores.astype(np.int64)[band], distance)


def flagged(angle: Floats, rules: RuleSet, name: str) -> Part:
    """1 where an angle [rad] is beyond the threshold of a name, to that side."""
    limit = rules.number(name)
    return Part((angle > limit + EDGE).astype(np.int64), np.abs(angle - limit))


def upper_arm(angles: WorkingAngles, work: Work, rules: RuleSet) -> Part:
    """The band that an upper arm is raised to, 1 more with the shoulder up and 1 if abducted, 1 less
    where it rests on something; no less than 1."""
    raised = banded(angles.arm_raise, rules, "upper_arm")
    raised += flagged(angles.shoulder_raise, rules, "raised")
    raised += flagged(angles.arm_out, rules, "abducted")
    return replace(raised, score=np.maximum(raised.score - int(bool(work.arms_supported)), 1))


def tabled(rules: RuleSet, name: str, row: Ints, column: Ints) -> Ints:
    """The cells of a table, its rows and columns counted from 0; beyond its ends its last ones."""
    table = rules.shaped(name, None, None)
    rows, columns = table.shape
    cells: Floats = table[np.minimum(row, rows - 1), np.minimum(column, columns - 1)]
    return cells.astype(np.int64)


def _cell_sums(rules: RuleSet, names: tuple[str, ...]) -> str:
    """Name the tables of a rule set by the sums of their cells, which tell versions apart."""
    sums = "/".join(f"{rules[name].sum():g}" for name in names)
    return f"{rules.description}; cell sums {sums}"


def posture_score(
    method: str,
    rules: RuleSet,
    by_side: Ints,
    *,
    parts: Mapping[str, Part | Ints],
    lowest: int,
    tables: tuple[str, ...],
    work: Work,
) -> PostureScore:
    """Compose a score of P postures from those of both sides (P, 2) and of the parts.

    Of equal sides the one that is nearer to another band counts. lowest: the number of the lowest
    action level. tables: those of the rule set that tell its version. work: as it was stated.
    """
    worse = by_side.max(axis=1)
    levels = rules.shaped("action_levels", None)
    counted = by_side == worse[:, None]
    named = {name: part for name, part in parts.items() if isinstance(part, Part)}
    nearest = np.stack([_nearest(part, counted) for part in named.values()])
    first = nearest.argmin(axis=0)
    names = np.array(list(named))
    return PostureScore(
        method=method,
        score=worse,
        level=lowest + np.searchsorted(levels, worse, side="left"),
        by_side=by_side,
        parts={name: _both(part, len(worse)) for name, part in parts.items()},
        to_next_band=nearest.min(axis=0),
        next_part=tuple(names[first].tolist()),
        version=_cell_sums(rules, tables),
        status=rules.status(*rules.values),
        assumed=work.assumed(ASKED_BY[method.lower()]),
    )


def _nearest(part: Part, counted: Bools) -> Floats:
    """(P,) [rad] the least distance over the sides that count (P, 2)."""
    distance = part.distance if part.distance.ndim == 2 else part.distance[:, None]
    return np.where(counted, distance, np.inf).min(axis=1)


def _both(part: Part | Ints, count: int) -> Ints:
    """(P, 2) scores of both sides."""
    score = part.score if isinstance(part, Part) else part
    return np.broadcast_to(score if score.ndim == 2 else score[:, None], (count, 2))
