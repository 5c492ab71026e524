"""Postures of limbs kept clear of obstacles: what they enter, and a target tried from a posture
that is clear.

What is near a clear posture becomes planes that its spheres must stay behind at once, so that on
the way to a target near by the limb slides along obstacles instead of passing into them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.posture.kernels.inequality_constraints import ContactPlanes
from workbench.posture.kernels.limb_contacts import DEEPEST, limb_contacts, new_space
from workbench.posture.reaching.obstacles import ObstacleScene, obstacles_of
from workbench.posture.reaching.packing import packed_limbs
from workbench.posture.reaching.reach_solver import (
    PIECE,
    LimbTask,
    ReachSolution,
    Walls,
    rows_of,
    solve_reaches,
)
from workbench.threads import run_in_threads

__all__ = ["CLEAR", "REACHED", "Touched", "cleared_from", "touched"]

MOST_PLANES = 40
CLEAR = 2e-4
"""How far [m] beyond what is allowed a posture is kept off obstacles, so that rounding does not
touch them."""
AROUND = 0.03
"""How near [m] an obstacle is minded at once."""
REACHED = 1e-3
"""How near [m] a point is to be reached."""
TURNS = 3


@dataclass(frozen=True, eq=False)
class Touched:
    """Of P postures: overlap (P,) [m] beyond what is allowed; the many (P,) deepest contacts as
    planes (P, Q, 8) with their parts (P, Q), -1 where there are fewer."""

    overlap: Floats
    planes: Floats
    part: Ints
    many: Ints


def touched(task: LimbTask, angles: Floats, room: ObstacleScene, near: float) -> Touched:
    """What limbs at angles (P, K, 3) enter, or come nearer to than `near` [m], beyond what is
    allowed."""
    count = len(angles)
    limbs = packed_limbs(task.body, task.limb)
    obstacles = obstacles_of(task.body, room.environment, room.moving, room.shift)
    planes = ContactPlanes(
        np.zeros(count * DEEPEST, np.int64),
        np.zeros((count * DEEPEST, 3)),
        np.zeros((count * DEEPEST, 3)),
        np.zeros(count * DEEPEST),
    )
    out = (
        planes,
        np.zeros(count, np.int64),
        np.full((count, DEEPEST), -1),
        np.zeros(count),
    )

    def work(begin: int, end: int) -> None:
        space = new_space(limbs, task.held.shape[1])
        limb_contacts(
            limbs,
            task.who,
            task.held,
            task.base,
            angles,
            obstacles,
            (near, CLEAR),
            out,
            begin,
            end,
            space,
        )

    run_in_threads(work, count, PIECE)
    columns = np.column_stack([planes.link, planes.point, planes.normal, planes.offset])
    return Touched(out[3], columns.reshape(count, DEEPEST, 8), out[2], out[1])


def cleared_from(task: LimbTask, start: Floats, room: ObstacleScene) -> tuple[ReachSolution, Bools]:
    """The targets of a task tried from postures (P, K, 3) that touch nothing, minding what is near
    to them, and again with what is then touched: what was found, and whether (P,) it arrives and is
    clear."""
    near = touched(task, start, room, AROUND)
    found = solve_reaches(task, start, 0, walls=_walls([near], np.arange(len(task))))
    good = np.zeros(len(task), np.bool_)
    rows = np.arange(len(task))
    history = [near]
    current = found
    for turn in range(TURNS):
        hit = touched(rows_of(task, rows), current.angles, room, CLEAR)
        arrived = current.numbers[:, 0] < REACHED
        fine = arrived & (hit.overlap <= 0)
        found = _put(found, current, rows, fine)
        good[rows[fine]] = True
        on = np.flatnonzero(arrived & (hit.overlap > 0))
        if not len(on) or turn == TURNS - 1:
            break
        history = [_some(touches, on) for touches in (*history, hit)]
        rows = rows[on]
        before = current.rows(on)
        current = solve_reaches(
            rows_of(task, rows), before.angles, 0, walls=_walls(history[::-1], rows), near=before
        )
    return found, good


def _some(touches: Touched, rows: Ints) -> Touched:
    return Touched(
        touches.overlap[rows], touches.planes[rows], touches.part[rows], touches.many[rows]
    )


def _put(found: ReachSolution, other: ReachSolution, rows: Ints, fine: Bools) -> ReachSolution:
    """Found with the rows that are fine taken from another."""
    angles = found.angles.copy()
    numbers = found.numbers.copy()
    held = found.held.copy()
    at = rows[fine]
    angles[at] = other.angles[fine]
    numbers[at] = other.numbers[fine]
    held[at] = other.held[fine]
    return replace(found, angles=angles, numbers=numbers, held=held)


def _walls(history: list[Touched], rows: Ints) -> Walls:
    """The planes of touches of the same rows, the first list first, MOST_PLANES a row at most."""
    count = len(rows)
    many = np.stack([touches.many for touches in history], axis=1)
    some = np.arange(DEEPEST) < many[:, :, None]
    planes = np.stack([touches.planes for touches in history], axis=1)
    parts = np.stack([touches.part for touches in history], axis=1)
    flat = some.reshape(count, -1)
    flat &= np.cumsum(flat, axis=1) <= MOST_PLANES
    start = np.concatenate([[0], np.cumsum(flat.sum(axis=1))]).astype(np.int64)
    return Walls(planes.reshape(count, -1, 8)[flat], parts.reshape(count, -1)[flat], start)
