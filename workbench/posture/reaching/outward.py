"""How much farther out on a ray limbs of people still reach, obstacles aside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.posture.kernels.maximum_reach import (
    Extents,
    GuideRows,
    new_ray_workspace,
    reach_outward,
)
from workbench.posture.reaching.reach_solver import PIECE, LimbTask, ReachSolution
from workbench.posture.reaching.seeds import NO_PLANES
from workbench.threads import run_in_threads

__all__ = ["Lead", "no_lead", "outward"]

ATTEMPT_STEPS = 60
"""Steps of an attempt at most."""


@dataclass(frozen=True, eq=False)
class Lead:
    """How far P limbs have come outward."""

    angles: Floats
    """(P, K, 3) [rad] their postures."""
    held: Floats
    """(P, 6 + R) multipliers of the ray, in the axes of the held segments, and of the stops."""
    ways: Floats
    """(P,) [m] how far beyond the target, minus infinity where nothing on the ray was reached."""

    def rows(self, rows: Ints) -> Lead:
        """Some of the rows."""
        return Lead(self.angles[rows], self.held[rows], self.ways[rows])

    def joined(self, other: Lead) -> Lead:
        """The rows of both."""
        return Lead(
            np.concatenate([self.angles, other.angles]),
            np.concatenate([self.held, other.held]),
            np.concatenate([self.ways, other.ways]),
        )


def no_lead(task: LimbTask) -> Lead:
    """Nothing known for the rows of a task."""
    count = len(task)
    return Lead(
        np.zeros((count, len(task.joints), 3)),
        np.zeros((count, 6 + len(task.link.rows))),
        np.full(count, -np.inf),
    )


def outward(
    task: LimbTask,
    found: ReachSolution,
    ways: Floats,
    lead: Lead,
    *,
    most: float,
    threads: int | None = None,
) -> Lead:
    """Lead limbs outward from targets that they reach, each by itself.

    Parameters
    ----------
    found
        The solutions of the task.
    ways
        (P, 3) the directions of the rays in the axes of the held segments, of any length.
    lead
        How far a guide of each row came.
    most
        How far to go [m].
    """
    count = len(task)
    size = np.sqrt(ways[:, :1] ** 2 + ways[:, 1:2] ** 2 + ways[:, 2:] ** 2)
    rays = np.concatenate([task.own.goal[:, :3], ways / np.maximum(size, 1e-9)], axis=1)
    known = GuideRows(lead.angles, lead.held, lead.ways)
    held = np.zeros((count, 6 + len(task.link.rows)))
    out = Extents(np.array(found.angles), held, np.zeros(count), np.zeros(count, dtype=np.int64))

    def work(begin: int, end: int) -> None:
        reach_outward(
            task.link,
            task.who,
            task.own.base,
            rays,
            NO_PLANES,
            most,
            ATTEMPT_STEPS,
            known,
            out,
            begin,
            end,
            new_ray_workspace(task.link),
        )

    run_in_threads(work, count, PIECE, threads=threads)
    return Lead(out.angles, out.held, out.ways)
