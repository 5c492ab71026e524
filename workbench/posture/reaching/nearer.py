"""Misses by obstacles, asked again before they are told.

A search from one start may stay far off a target that is reached, or nearly: the clear postures about
a target lie in pockets, and one start ends in one of them. So a miss that is to be told is asked
again from many starts (kernels.clear_reach), and then at targets near by. For a posture found for
any of them is a witness for all: if it misses a target t' by m(t'), it misses t by m at most with

    m(t) <= m(t') + |t - t'|.

The targets near by lie along the axes of the segment that the limb hangs on, to both sides. So a
question that is turned or mirrored has the same ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.posture.kernels.clear_reach import BURIED, KEPT, NEARER, NEXT_TO, OTHER_WAY, PRECISE
from workbench.posture.kernels.inverse_kinematics import NEARLY
from workbench.posture.reaching.obstacles import ObstacleScene, avoid_obstacles
from workbench.posture.reaching.reach_solver import (
    LimbTask,
    ReachSolution,
    reaches,
    rows_of,
    tips_of,
)

__all__ = ["asked_again", "missed_by_obstacles", "targets_aside"]

ASIDE = (1e-3, 5e-3, 20e-3)
"""Distances [m] of the targets near by."""
ROUNDS = 3
"""How often the targets near by are asked at most, each time from a better posture."""
WORTH = 10e-3
"""A posture of a target near by is taken further where it misses by so much more [m] at most."""
FARTHEST = 1.0
"""[m] Nothing farther from a target counts as a posture near it."""


def missed_by_obstacles(found: ReachSolution, doubt: Ints) -> Ints:
    """The rows that miss their targets by obstacles."""
    blamed = (doubt >= KEPT) | (found.part >= 0) | (found.overlap > 0)
    return np.flatnonzero(~reaches(found) & blamed)


@dataclass(frozen=True, eq=False)
class _Misses:
    """P misses that are asked again, and the best that is known of each; filled in place."""

    task: LimbTask
    room: ObstacleScene
    least: Floats
    """(P,) [m] no posture comes nearer."""
    angles: Floats
    """(P, K, 3) [rad] of the best posture."""
    miss: Floats
    """(P,) [m] of that posture; `FARTHEST` where the best posture enters something."""
    part: Ints
    """(P,) what is in its way."""
    numbers: Floats
    """(P, 8) of a row that is reached."""
    reached: Ints
    """(P,) 1 where a row is reached."""

    @property
    def left(self) -> Ints:
        """The rows that may still come nearer."""
        return np.flatnonzero((self.reached == 0) & (self.miss - self.least > PRECISE))

    def ask(self, rows: Ints, angles: Floats, how: int) -> None:
        """Ask rows (Q,) for something nearer, each from a posture (Q, K, 3); any row may come
        several times. What is better is taken."""
        if not len(rows):
            return
        out, doubt = _nearer(
            rows_of(self.task, rows), angles, self.least[rows], self.miss[rows], how, self.room
        )
        got = doubt == OTHER_WAY
        miss = np.where(got, 0.0, np.where(out.overlap > 0, np.inf, out.numbers[:, 0]))
        order = np.lexsort((np.arange(len(rows)), miss, rows))
        first = order[np.r_[True, rows[order][1:] != rows[order][:-1]]]
        for q in first[miss[first] < self.miss[rows[first]]].tolist():
            row = rows[q]
            if self.reached[row]:
                continue
            self.angles[row] = out.angles[q]
            self.numbers[row] = out.numbers[q]
            self.miss[row] = miss[q]
            self.part[row] = out.part[q]
            self.reached[row] = got[q]


def asked_again(
    task: LimbTask,
    free: ReachSolution,
    found: ReachSolution,
    doubt: Ints,
    room: ObstacleScene,
    *,
    starts: Floats | None,
    thorough: bool,
) -> tuple[ReachSolution, Ints]:
    """Ask reaches that miss their targets by obstacles again.

    Parameters
    ----------
    task
        P reaches.
    free
        What they come to without obstacles.
    found, doubt
        What they have come to beside them, and what became of each (P,).
    room
        The obstacles.
    starts
        (P, K, 3) [rad] other postures to start from; none if None.
    thorough
        Whether they are asked from many other starts too, and at targets near by.

    Returns
    -------
    found, doubt
        The same with nearer postures where there are some.
    """
    rows = missed_by_obstacles(found, doubt)
    if not len(rows) or (starts is None and not thorough):
        return found, doubt
    some = rows_of(task, rows)
    entered = found.overlap[rows] > 0
    misses = _Misses(
        some,
        room,
        _least(free.numbers[rows, 0], doubt[rows]),
        np.array(found.angles[rows]),
        np.where(entered, FARTHEST, found.numbers[rows, 0]),
        found.part[rows].copy(),
        np.array(found.numbers[rows]),
        np.zeros(len(rows), np.int64),
    )
    before = misses.miss.copy()
    if starts is not None:
        misses.ask(misses.left, starts[rows][misses.left], NEXT_TO)
    if thorough:
        misses.ask(misses.left, free.angles[rows][misses.left], NEXT_TO)
        misses.ask(misses.left, misses.angles[misses.left], NEARER)
        _ask_near_by(misses)
    return _put(found, doubt, rows, misses, misses.miss < before, free)


def _least(free: Floats, doubt: Ints) -> Floats:
    """(P,) [m] how near postures come at most: what is missed by little without obstacles may be
    reached, what is buried may not."""
    least = np.where(free <= NEARLY, 0.0, free)
    return np.where(doubt == BURIED, np.maximum(least, PRECISE), least)


def _ask_near_by(misses: _Misses) -> None:
    """Ask at targets near by from the best postures, and the rows again from what is found there;
    again where that was better."""
    rows = misses.left
    for _ in range(ROUNDS):
        if not len(rows):
            return
        before = misses.miss[rows].copy()
        aside = targets_aside(misses.task.base[rows])
        whose = np.repeat(rows, aside.shape[1])
        away = aside.reshape(-1, 3)
        far = np.linalg.norm(away, axis=1)
        known = misses.angles[whose]
        task = rows_of(misses.task, whose)
        goal = task.goal.copy()
        goal[:, :3] += away
        near = replace(task, goal=goal)
        beat = np.minimum(_off(near, known), misses.miss[whose] + far)
        least = np.maximum(misses.least[whose] - far, 0.0)
        out, doubt = _nearer(near, known, least, beat, NEXT_TO, misses.room)
        good = (doubt == OTHER_WAY) | (out.overlap <= 0)
        good &= _off(task, out.angles) < misses.miss[whose] + WORTH
        misses.ask(whose[good], out.angles[good], NEXT_TO)
        better = misses.miss[rows] < before - PRECISE
        rows = np.intersect1d(rows[better], misses.left)


def targets_aside(base: Floats) -> Floats:
    """(P, N, 3) [m] how far aside the targets near by are, along the axes (P, 3, 4) of segments."""
    axes = base[:, :, :3].transpose(0, 2, 1)
    ways = np.concatenate([axes, -axes], axis=1)
    return np.concatenate([far * ways for far in ASIDE], axis=1)


def _off(task: LimbTask, angles: Floats) -> Floats:
    """(P,) [m] how far the tips are from their targets at angles (P, K, 3)."""
    off: Floats = np.linalg.norm(tips_of(task, angles)[:, :3] - task.goal[:, :3], axis=1)
    return off


def _nearer(
    task: LimbTask, angles: Floats, least: Floats, beat: Floats, how: int, room: ObstacleScene
) -> tuple[ReachSolution, Ints]:
    """Postures nearer to their targets than `beat` (P,) [m], from postures (P, K, 3)."""
    count = len(task)
    numbers = np.zeros((count, 8))
    numbers[:, 0] = least
    numbers[:, 1] = beat
    start = ReachSolution(
        angles, numbers, np.zeros((count, 0)), np.zeros(count), np.full(count, -1)
    )
    return avoid_obstacles(task, start, room, effort=how)


def _put(
    found: ReachSolution,
    doubt: Ints,
    rows: Ints,
    misses: _Misses,
    better: Bools,
    free: ReachSolution,
) -> tuple[ReachSolution, Ints]:
    """Found with the rows that are better."""
    angles = found.angles.copy()
    numbers = found.numbers.copy()
    held = found.held.copy()
    overlap = found.overlap.copy()
    part = found.part.copy()
    doubt = doubt.copy()
    at = rows[better]
    angles[at] = misses.angles[better]
    numbers[at, 0] = misses.miss[better]
    got = misses.reached[better] == 1
    numbers[at[got]] = misses.numbers[better][got]
    held[at[got]] = 0.0
    overlap[at] = 0.0
    by_length = ~got & (free.numbers[at, 0] > NEARLY)
    by_length &= misses.miss[better] <= misses.least[better] + PRECISE
    blamed = np.where(misses.part[better] >= 0, misses.part[better], part[at])
    part[at] = np.where(got | by_length, -1, blamed)
    doubt[at[got]] = OTHER_WAY
    return ReachSolution(angles, numbers, held, overlap, part), doubt
