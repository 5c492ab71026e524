"""Chains of bodies asked to reach for points of rays: the tasks of the solver, posed and
retargeted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.body.forward import segment_frames
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.model.posing import angles_of
from workbench.posture.reaching.chains import (
    Found,
    Task,
    cold,
    goals_of,
    legal,
    limb_task,
    rows_of,
    tips_of,
)
from workbench.posture.reaching.limbs import Limb

__all__ = [
    "Drawn",
    "anchors",
    "asked",
    "comfort_start",
    "drawn",
    "held_at",
    "merged",
    "rows_toward",
]

AT_ONCE = 16
"""Points whose distances to all tips are held at once, as many as a cache holds."""
LEGAL = 5e-4
"""Breach [rad, m] below which a posture is within the stops."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """M legal postures: angles (M, K, 3), and where they bring the tips (B, M, 3) [m] of B
    bodies."""

    angles: Floats
    tips: Floats

    def nearest(self, who: Ints, points: Floats) -> tuple[Ints, Floats]:
        """For points (P, 3) of bodies who (P,): the posture (P,) that brings the tip nearest, and
        how near (P,) [m]."""
        best = np.zeros(len(points), np.int64)
        gap = np.zeros(len(points))
        for person in np.unique(who):
            rows = np.flatnonzero(who == person)
            tips = self.tips[person]
            # the square of the distance less that of the point: |t|^2 - 2 t . p, one product each
            square = np.vstack([-2.0 * tips.T, np.einsum("mi,mi->m", tips, tips)])
            raised = np.column_stack([points[rows], np.ones(len(rows))])
            for first in range(0, len(rows), AT_ONCE):
                some = slice(first, first + AT_ONCE)
                best[rows[some]] = (raised[some] @ square).argmin(axis=1)
            gap[rows] = np.linalg.norm(points[rows] - tips[best[rows]], axis=1)
        return best, gap


def asked(body: Body, poses: Poses, chain: Limb) -> Task:
    """One row for each of the B rows of a body in its own pose (B rows of poses), as yet without a
    goal."""
    return limb_task(
        body,
        chain,
        np.arange(len(body)),
        held=poses.rotations,
        base=segment_frames(body, poses, chain.base),
        goal=goals_of(np.zeros((len(body), 3))),
    )


def rows_toward(task: Task, who: Ints, points: Floats) -> Task:
    """The bodies who (P,) of a task of one row a body, reaching for points (P, 3) [m]."""
    return replace(rows_of(task, who), goal=goals_of(points))


def comfort_start(task: Task) -> Floats:
    """(P, K, 3) the chains' angles as the poses have them, the free ones at their comfort modes."""
    given = Poses(task.held, 0, np.repeat(np.eye(3, 4)[None], len(task), axis=0))
    return cold(task, angles_of(task.body, given)[:, task.joints])


def anchors(task: Task) -> tuple[Floats, Floats]:
    """Of a task of one row a body: the points (B, 3) [m] that the first free joint turns about, and
    how far (B,) [m] the tip can be from there at most, all links beyond in one line."""
    link = task.link
    first = int(task.link.free_joint.min())
    held = np.zeros((len(task), 6))
    base = task.base
    if first > 0:
        # what lies before the first free joint is held: its link is where forward kinematics puts
        # it
        poses = Poses(task.held, task.limb.base, task.base)
        base = segment_frames(task.body, poses, task.joints[first - 1] + 1)
    held = np.einsum("bij,bj->bi", base[:, :, :3], link.at_parent[:, first]) + base[:, :, 3]
    steps = link.at_parent[:, first + 1 :] - link.at_child[:, first:-1]
    length = np.linalg.norm(steps, axis=2).sum(axis=1) + np.linalg.norm(
        link.tip - link.at_child[:, -1], axis=1
    )
    return held, length


def drawn(task: Task, count: int) -> Drawn:
    """Legal postures spread evenly over the joints' ranges out of `count` tries, of a task of one
    row a body: the same ones each time, and for all."""
    link = task.link
    people = len(task)
    limits = task.body.stops.limits[task.joints]
    share = np.random.default_rng(7).uniform(size=(count, len(task.joints), 3))
    angles = np.repeat(comfort_start(rows_of(task, np.arange(1))), count, axis=0)
    free: Bools = link.free_of >= 0
    angles[:, free] = (-limits[..., 1] + share * limits.sum(axis=-1))[:, free]
    good = np.linalg.norm(angles[..., :2], axis=-1).max(axis=1) < 3.0
    good &= legal(rows_of(task, np.zeros(count, np.int64)), angles)
    angles = angles[good]
    every = rows_of(task, np.repeat(np.arange(people), len(angles)))
    tips = tips_of(every, np.tile(angles, (people, 1, 1)))[:, :3]
    return Drawn(angles, tips.reshape(people, len(angles), 3))


def merged(found: Found, other: Found, rows: Ints) -> Found:
    """Found with the rows (Q,) taken from another (Q) where that came nearer within the stops."""
    less = (other.numbers[:, 0] < found.numbers[rows, 0]) & (other.numbers[:, 1] < LEGAL)
    take = rows[less]
    angles = found.angles.copy()
    numbers = found.numbers.copy()
    held = found.held.copy()
    overlap = found.overlap.copy()
    part = found.part.copy()
    angles[take] = other.angles[less]
    numbers[take] = other.numbers[less]
    held[take] = other.held[less]
    overlap[take] = other.overlap[less]
    part[take] = other.part[less]
    return Found(angles, numbers, held, overlap, part)


def held_at(task: Task, angles: Floats) -> Found:
    """Postures (P, K, 3) as they are, with how far they miss the goals of a task."""
    gap = np.linalg.norm(tips_of(task, angles)[:, :3] - task.goal[:, :3], axis=1)
    numbers = np.zeros((len(task), 8))
    numbers[:, 0] = gap
    held = np.zeros((len(task), 6 + len(task.link.rows)))
    return Found(angles, numbers, held, np.zeros(len(task)), np.full(len(task), -1))
