"""Reaches that were found, looked at again once their people are elsewhere.

A reach is what its posture shows. So who reached a target, and finds a posture that reaches it next
to the one before, reaches it still: no other posture is searched for. Who finds none there may reach
it in another one, which `reach` decides.

How far each sphere of the limb was from all parts goes along with its reach. Most of them move less
than that, and are not looked at.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.body.forward import segment_frames
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.poses import Poses
from workbench.posture.kernels.clear_reach import KEPT, Looked, Outcome, new_desk, still_reaches
from workbench.posture.kernels.limb_contacts import GROUPS
from workbench.posture.reaching.heeding import in_own_body
from workbench.posture.reaching.history import known_of
from workbench.posture.reaching.limbs import Limb
from workbench.posture.reaching.linkage import joints_between
from workbench.posture.reaching.obstacles import ObstacleScene, obstacles_of
from workbench.posture.reaching.packing import packed_limbs
from workbench.posture.reaching.reach_solver import goals_of, limb_task, rows_of
from workbench.threads import run_in_threads

__all__ = ["KeptReaches", "no_reaches", "still_reached"]

PIECE = 64
"""Rows that a thread takes at a time."""


@dataclass(eq=False)
class KeptReaches:
    """Reaches of B people with T targets, filled in place as they are looked at.

    Parameters
    ----------
    angles
        (B, T, K, 3) [rad] of the chain of the limb.
    reached
        (B, T) whether each target was reached.
    looked
        What was looked at about them, B T rows.
    environment
        The obstacles that it was looked at in; None before the first time.
    """

    angles: Floats
    reached: Bools
    looked: Looked
    environment: Environment | None = None

    def put(self, people: Ints, targets: Ints, angles: Floats) -> None:
        """Keep reaches of other postures (P, K, 3) [rad], of a person (P,) and a target (P,) each."""
        self.angles[people, targets] = angles
        self.reached[people, targets] = True
        self.looked.gap[people * self.reached.shape[1] + targets] = -1.0


def no_reaches(body: Body, limb: Limb, shape: tuple[int, int]) -> KeptReaches:
    """Nothing that is reached yet, of so many people, rows of a body, and targets."""
    rows = shape[0] * shape[1]
    spheres = packed_limbs(body, limb).centre.shape[2]
    joints = len(joints_between(body, limb.base, limb.end))
    looked = Looked(np.zeros((rows, GROUPS, spheres, 3)), np.full((rows, GROUPS, spheres), -1.0))
    return KeptReaches(np.zeros((*shape, joints, 3)), np.zeros(shape, dtype=np.bool_), looked)


def still_reached(
    body: Body,
    poses: Poses,
    targets: Floats,
    *,
    limb: Limb,
    kept: KeptReaches,
    environment: Environment,
    moving_parts: tuple[str, ...],
    displacement: Floats,
) -> Bools:
    """Look which targets people who reached them reach still, next to the posture before.

    Parameters
    ----------
    body, poses
        B poses of the rows of a body, one of each.
    targets
        (B, T, 3) [m] of each person, in the world.
    limb
        The limb, of this body.
    kept
        What was reached; it is made to be what is reached now.
    environment, moving_parts, displacement
        As of `reach`.

    Returns
    -------
    (B, T) array
        False too where nothing was reached before.
    """
    count = targets.shape[1]
    world = segment_frames(body, poses, limb.base)
    task = limb_task(
        body,
        limb,
        np.repeat(np.arange(len(body)), count),
        held=np.repeat(poses.rotations, count, axis=0),
        base=np.repeat(world, count, axis=0),
        goal=goals_of(targets.reshape(-1, 3)),
    )
    if kept.environment is not environment:
        kept.looked.gap[:] = -1.0
        kept.environment = environment
    moving = np.isin(environment.parts, list(moving_parts)).astype(np.int64)
    room = obstacles_of(body, environment, moving, displacement)
    rows = len(task)
    out = Outcome(
        kept.angles.reshape(rows, *kept.angles.shape[2:]),
        np.zeros((rows, 8)),
        np.zeros(rows),
        np.full(rows, -1),
        np.where(kept.reached.ravel(), 0, KEPT),
        *known_of(task),
    )
    limbs = packed_limbs(body, limb)

    def work(begin: int, end: int) -> None:
        problem = *task.own, task.base, task.goal
        desk = new_desk(task.link, limbs, task.held.shape[1], 1)
        still_reaches(
            task.link, limbs, task.who, task.held, problem, room, kept.looked, out, begin, end, desk
        )

    run_in_threads(work, rows, PIECE)
    got = np.flatnonzero(out.doubt != KEPT)
    if "hand" in limb.name:
        around = ObstacleScene(environment, moving, displacement)
        got = got[in_own_body(rows_of(task, got), out.angles[got], around) <= 0]
    kept.reached[:] = np.isin(np.arange(rows), got).reshape(kept.reached.shape)
    return kept.reached.copy()
