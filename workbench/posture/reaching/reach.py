"""Reach: the most comfortable posture that brings a hand or foot to a target, within the joint
stops and clear of obstacles; or how far it is missed and what limits it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.forward import segment_frames
from workbench.errors import UsageError
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body, check_one
from workbench.model.environment import Environment
from workbench.model.poses import Poses, check_joints
from workbench.model.posing import angles_of
from workbench.model.reach import Reach
from workbench.posture.reaching.chains import AGAIN, Found, Task, cold, posed, solved, tips_of
from workbench.posture.reaching.limbs import Limb
from workbench.posture.reaching.linkage import joints_between
from workbench.posture.reaching.obstacles import Room, cleared
from workbench.posture.reaching.packing import packed_links

__all__ = ["REACHED", "TURN_LEVER", "goals_of", "reach", "stopped_by"]

REACHED = 1e-4
"""A target is reached where the tip is this near to it [m]."""
TURN_LEVER = 0.2
"""What a radian between wanted and actual direction counts [m]."""
SLACK = 0.03
"""A stop that gives less than this [m/rad] is not what limits a reach."""


def reach(
    body: Body,
    poses: Poses,
    targets: ArrayLike,
    *,
    limb: Limb,
    direction: ArrayLike | None = None,
    environment: Environment | None = None,
    start: Poses | None = None,
    tries: int = AGAIN,
) -> Reach:
    """Reach for targets (P, 3) [m] from poses of the same number, or from one pose for all.

    What the limb does not move stays as the poses have it. direction (3,) or (P, 3): the way the
    limb is to point on arrival, any where None. environment: obstacles, with their allowances.
    start: postures near to the solutions, which then is quicker; from the comfort modes where None.
    tries: from how many other postures to begin again where a target is missed. UsageError where
    the numbers of rows do not fit.
    """
    task = _task(body, poses, np.atleast_2d(np.asarray(targets, dtype=np.float64)), limb, direction)
    given = Poses(task.held, poses.reference, np.repeat(np.eye(3, 4)[None], len(task), axis=0))
    angles = cold(task, angles_of(body, given)[:, task.joints])
    if start is not None:
        if len(start) not in (1, len(task)):
            raise UsageError(
                f"start: expected 1 or {len(task)} rows for {len(task)} targets, got {len(start)}"
            )
        free = (slice(None), task.link.free_joint, task.link.free_axis)
        angles[free] = angles_of(body, start)[:, task.joints][free]
    found = solved(task, angles, tries)
    if environment is not None:
        still = np.zeros(len(environment.parts), dtype=np.int64)
        found = cleared(task, found, Room(environment, still, np.zeros((1, 3))))
    return _answer(task, found, environment)


def _task(
    body: Body, poses: Poses, targets: Floats, limb: Limb, direction: ArrayLike | None
) -> Task:
    if targets.ndim != 2 or targets.shape[1] != 3 or not np.all(np.isfinite(targets)):
        raise UsageError(f"targets: expected finite points (P, 3), got an array {targets.shape}")
    if len(poses) not in (1, len(targets)):
        raise UsageError(
            f"poses: expected 1 or {len(targets)} rows for {len(targets)} targets, got {len(poses)}"
        )
    check_one(body)
    check_joints(body, poses)
    base = segment_frames(body, poses, limb.base)
    rotations = poses.rotations
    if len(poses) != len(targets):
        base, rotations = (np.repeat(array, len(targets), axis=0) for array in (base, rotations))
    goal = goals_of(targets)
    if direction is not None:
        given = np.asarray(direction, dtype=np.float64)
        if given.shape not in ((3,), targets.shape):
            raise UsageError(
                f"direction: expected a vector (3,) or {targets.shape}, got an array {given.shape}"
            )
        way = np.broadcast_to(given, targets.shape)
        size = np.linalg.norm(way, axis=1, keepdims=True)
        if not np.all(size > 1e-9):
            raise UsageError("direction: expected vectors that have a length, got one of length 0")
        goal[:, 3:6] = way / size
        goal[:, 9:] = TURN_LEVER
    joints = joints_between(body, limb.base, limb.end)
    # arrays of one kind only: each new kind would have the kernels compiled again
    who = np.zeros(len(targets), dtype=np.int64)
    return Task(body, limb, packed_links(body, limb), joints, who, np.array(rotations), base, goal)


def goals_of(targets: Floats) -> Floats:
    """(P, 12) goals of the kernels for targets (P, 3), from any direction."""
    goal = np.zeros((len(targets), 12))
    goal[:, :3] = targets
    goal[:, 6:9] = 1.0
    return goal


def stopped_by(task: Task, found: Found, reached: Bools) -> tuple[Floats, Floats, Floats]:
    """Joint, axis and side (P,) of the stop that limits each reach, -1 where none does."""
    numbers = found.numbers
    stopped = (
        ~reached
        & (found.part < 0)
        & (numbers[:, 7] > 0)
        & (numbers[:, 3] >= 0)
        & (numbers[:, 6] > SLACK)
    )
    joint = np.array(task.joints)[numbers[:, 3].astype(np.int64)]
    values = joint, numbers[:, 4], numbers[:, 5]
    first, second, third = (np.where(stopped, value, -1) for value in values)
    return first, second, third


def _answer(task: Task, found: Found, environment: Environment | None) -> Reach:
    link = task.link
    at = tips_of(task, found.angles)
    off = found.angles[:, link.free_joint, link.free_axis] - link.mode
    reached = (found.numbers[:, 0] <= REACHED) & (found.overlap <= 0)
    joint, axis, side = stopped_by(task, found, reached)
    return Reach(
        body=task.body,
        limb=task.limb.name,
        poses=Poses(posed(task, found.angles), task.limb.base, task.base),
        target=task.goal[:, :3],
        tip=at[:, :3],
        reached=reached,
        miss=np.linalg.norm(at[:, :3] - task.goal[:, :3], axis=1),
        overlap=found.overlap,
        discomfort=np.sum(link.weight * off * off, axis=1),
        joint=joint.astype(np.int64),
        axis=axis.astype(np.int64),
        side=side.astype(np.int64),
        part=np.where(reached, -1, found.part),
        parts=environment.parts if environment is not None else (),
    )
