"""Limbs of the rows of a body that reach for targets, a row a reach: tasks, their solution free of
obstacles, seeds."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.kept import kept_with_body
from workbench.model.posing import compose
from workbench.posture.kernels.inverse import breaches, solve_chains, tips
from workbench.posture.kernels.limits import Planes
from workbench.posture.kernels.linkage import Linkage
from workbench.posture.reaching.limbs import Limb
from workbench.posture.reaching.linkage import joints_between
from workbench.posture.reaching.packing import packed_links
from workbench.threads import in_pieces

__all__ = [
    "AGAIN",
    "NO_PLANES",
    "PIECE",
    "Found",
    "Task",
    "Walls",
    "cold",
    "legal",
    "posed",
    "rows_of",
    "seeds_of",
    "solved",
    "tips_of",
]

STEPS = 90
AGAIN = 12
SEEDS = 128
PIECE = 128
"""Rows that a thread takes at a time; within them a row may follow the one before."""
NO_PLANES = Planes(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


@dataclass(frozen=True, eq=False)
class Task:
    """One limb of the rows of a body reaching for P targets: row p is that of row who[p] (P,), whose
    joints stand at held (P, J, 4) and whose held segment at base (P, 3, 4); goal (P, 12):
    target, direction, weights of each."""

    body: Body
    limb: Limb
    link: Linkage
    joints: list[int]
    who: Ints
    held: Floats
    base: Floats
    goal: Floats

    def __len__(self) -> int:
        return len(self.who)


@dataclass(frozen=True, eq=False)
class Found:
    """Angles (P, K, 3), numbers (P, 8) and multipliers held (P, 6 + R) as the kernel gives them,
    overlap (P,) [m], part (P,) that is entered deepest or holds the limb, -1 where none."""

    angles: Floats
    numbers: Floats
    held: Floats
    overlap: Floats
    part: Ints

    def rows(self, rows: Ints | Bools) -> Found:
        """Some of the rows."""
        return Found(
            self.angles[rows],
            self.numbers[rows],
            self.held[rows],
            self.overlap[rows],
            self.part[rows],
        )

    def changed(self, rows: Ints, other: Found) -> Found:
        """The same with these rows (Q,) as in another, which has Q of them."""
        angles = self.angles.copy()
        numbers = self.numbers.copy()
        held = self.held.copy()
        overlap = self.overlap.copy()
        part = self.part.copy()
        angles[rows] = other.angles
        numbers[rows] = other.numbers
        held[rows] = other.held
        overlap[rows] = other.overlap
        part[rows] = other.part
        return Found(angles, numbers, held, overlap, part)


@dataclass(frozen=True, eq=False)
class Walls:
    """Planes (Q, 8) (link, point, normal, offset) with their parts (Q,); those of row p are
    start[p]:start[p + 1]."""

    planes: Floats
    part: Ints
    start: Ints


def rows_of(task: Task, rows: Ints | Bools) -> Task:
    """Some rows of a task."""
    return replace(
        task, who=task.who[rows], held=task.held[rows], base=task.base[rows], goal=task.goal[rows]
    )


def cold(task: Task, angles: Floats) -> Floats:
    """The angles (P, K, 3), the free ones at their comfort modes."""
    start = np.array(angles)
    start[:, task.link.free_joint, task.link.free_axis] = task.link.mode
    return start


def solved(
    task: Task,
    start: Floats,
    again: int,
    *,
    walls: Walls | None = None,
    follow: Ints | None = None,
    before: Found | None = None,
    threads: int | None = None,
) -> Found:
    """Solve all rows from their start angles (P, K, 3), again from `again` other postures where a
    row fails; or from the row of the same piece that they follow; or from what was found before for
    another target or other walls."""
    count = len(task)
    link = task.link
    # in one order always: for each other one the kernels would be compiled again
    out = np.array(start, order="C"), np.zeros((count, 8)), np.zeros((count, 6 + len(link.rows)))
    planes = NO_PLANES
    first = np.zeros(count + 1, dtype=np.int64)
    if walls is not None:
        at, normal, offset = (
            np.ascontiguousarray(walls.planes[:, c]) for c in (slice(1, 4), slice(4, 7), 7)
        )
        planes = Planes(walls.planes[:, 0].astype(np.int64), at, normal, offset)
        first = walls.start
    settings = (STEPS, *seeds_of(task.body, task.limb), again)
    problem = (task.base, task.goal)
    if before is not None:
        out = np.array(before.angles), np.array(before.numbers), np.array(before.held)
        follow = np.arange(count)
    lead = np.full(count, -1) if follow is None else follow

    def work(begin: int, end: int) -> None:
        solve_chains(link, task.who, problem, (planes, first), settings, out, lead, begin, end)

    in_pieces(work, count, PIECE, threads=threads)
    return Found(*out, np.zeros(count), np.full(count, -1))


@kept_with_body
def seeds_of(body: Body, limb: Limb) -> tuple[Floats, Floats]:
    """Legal angles (M, K, 3) spread over the chain's range, and where they bring tip and direction
    (M, 6) in the frame of the held segment; the same ones each time."""
    link = packed_links(body[0], limb)
    joints = joints_between(body, limb.base, limb.end)
    limits = body.stops.limits[joints]
    share = np.random.default_rng(1).uniform(size=(4 * SEEDS, len(joints), 3))
    angles = np.where(link.free_of >= 0, -limits[..., 1] + share * limits.sum(axis=-1), 0.0)
    swing = np.linalg.norm(angles[..., :2], axis=-1, keepdims=True)
    angles[..., :2] *= np.minimum(1.0, 3.0 / np.maximum(swing, 1e-9))
    breach = np.zeros(len(angles))
    breaches(link, NO_PLANES, angles, breach)
    # the legal ones first, then the least wrong: a start need not be legal
    order = np.argsort(breach, kind="stable")[:SEEDS]
    angles = np.ascontiguousarray(angles[order])
    at = np.zeros((SEEDS, 6))
    base = np.ascontiguousarray(np.broadcast_to(np.eye(3, 4), (SEEDS, 3, 4)))
    tips(link, np.zeros(SEEDS, np.int64), base, angles, at)
    return angles, at


def legal(task: Task, angles: Floats) -> Bools:
    """(P,) whether angles (P, K, 3) are within the stops, but for rounding."""
    breach = np.zeros(len(angles))
    breaches(task.link, NO_PLANES, np.array(angles), breach)
    return breach < 1e-3


def tips_of(task: Task, angles: Floats) -> Floats:
    """(P, 6) where angles (P, K, 3) bring tip and direction."""
    at = np.zeros((len(angles), 6))
    tips(task.link, task.who, task.base, angles, at)
    return at


def posed(task: Task, angles: Floats) -> Floats:
    """Rotations (P, J, 4) with the chain's free joints at these angles (P, K, 3)."""
    every = np.zeros((len(angles), len(task.body.joints), 3))
    every[:, task.joints] = angles
    rotations = np.array(task.held)
    free = [j for j in task.joints if j in task.limb.free]
    rotations[:, free] = compose(task.body, every)[:, free]
    return rotations
