"""Limbs that are where they belong, brought clear of what was not looked at when they came there: legs
of what stands around, the fingers of hands that hold a control of everything but this. No posture
of a leg that enters the own body deeper than the one before, and than the body allows, counts as clear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from workbench.body.forward import place, segment_frames
from workbench.contact.collide import self_contacts
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.joint_angles import angles_of
from workbench.model.poses import Poses, people_of
from workbench.posture.kernels.clear_reach import BRIEF, FEW_STARTS, KEPT, SKIPPED
from workbench.posture.reaching.limbs import Limb, arm_alone, shoulder_held, with_fingers
from workbench.posture.reaching.obstacles import ObstacleScene, avoid_obstacles
from workbench.posture.reaching.oneself import ARM, own_body
from workbench.posture.reaching.reach_solver import (
    LimbTask,
    ReachSolution,
    goals_of,
    joint_rotations,
    limb_task,
    rows_of,
)

__all__ = [
    "as_posed",
    "clear_fingers",
    "deep_in",
    "heeding",
    "in_oneself",
    "in_own_body",
    "swung_clear",
]


def as_posed(body: Body, poses: Poses, limb: Limb) -> tuple[LimbTask, Floats]:
    """The task of a limb in B poses that asks for nothing yet, and its angles (B, K, 3) [rad]."""
    task = limb_task(
        body,
        limb,
        people_of(body, poses),
        held=poses.rotations,
        base=segment_frames(body, poses, limb.base),
        goal=np.zeros((len(poses), 12)),
    )
    return task, np.ascontiguousarray(angles_of(body, poses)[:, task.joints])


def deep_in(task: LimbTask, angles: Floats, room: ObstacleScene) -> ReachSolution:
    """How deep limbs at angles (P, K, 3) are in obstacles, and in what; nothing is searched for."""
    return avoid_obstacles(task, _known(task, angles), room, effort=SKIPPED)[0]


def swung_clear(task: LimbTask, angles: Floats, room: ObstacleScene) -> tuple[ReachSolution, Ints]:
    """Limbs at angles (P, K, 3) brought clear from where they are, and what became of each, as of
    `avoid_obstacles`."""
    return avoid_obstacles(task, _known(task, angles), room, effort=BRIEF)


def _known(task: LimbTask, angles: Floats) -> ReachSolution:
    """What a search begins from that knows of angles alone."""
    count = len(task)
    return ReachSolution(
        np.array(angles, order="C"),
        np.zeros((count, 8)),
        np.zeros((count, 6 + len(task.link.rows))),
        np.zeros(count),
        np.full(count, -1),
    )


def in_oneself(task: LimbTask, angles: Floats) -> Floats:
    """How much deeper (P,) [m] legs at angles (P, K, 3) are in other segments of the own body than it
    allows, below 0 where they are not. The arms do not count: they are still to go elsewhere, or asked
    apart as `own_arms`."""
    body = task.body
    poses = Poses(joint_rotations(task, angles), task.limb.base, task.base, person=task.who)
    found = self_contacts(place(body, poses))
    one, other = found.segment, found.other_segment
    moving = np.isin(one, task.limb.moving) | np.isin(other, task.limb.moving)
    arms = np.array([name[1:] in ARM for name in body.segments])
    moving &= ~(arms[one] | arms[other])
    deepest: Floats = np.full(len(task), -np.inf)
    np.maximum.at(deepest, found.pose[moving], found.excess[moving])
    return deepest


def in_own_body(
    task: LimbTask, angles: Floats, room: ObstacleScene, *, other_arm: bool = False
) -> Floats:
    """How much deeper (P,) [m] arms at angles (P, K, 3) are in the own body than it allows, 0 where they are
    not: in that of the room if there is one, else as it has come to lie, the own shoulder included.
    other_arm: as of `own_body`.
    """
    if not len(task):
        return np.zeros(0)
    room = replace(room, people=(), bodies_only=True)
    if room.own is None:
        body = task.body
        poses = Poses(joint_rotations(task, angles), task.limb.base, task.base, person=task.who)
        arm = shoulder_held(body, task.limb)
        room = replace(room, own=own_body(body, poses, arm, other_arm=other_arm))
        task, angles = as_posed(body, poses, arm)
    return deep_in(task, angles, room).overlap


def heeding(
    task: LimbTask, angles: Floats, clear: Bools, before: Callable[[Ints], Floats]
) -> Bools:
    """(P,) which of the clear legs at angles (P, K, 3) enter the own body no deeper than it allows, or
    than before: that says how deep [m] some of them (N,) were."""
    rows = np.flatnonzero(clear)
    kept = np.zeros(len(clear), dtype=np.bool_)
    if len(rows):
        now = in_oneself(rows_of(task, rows), angles[rows])
        kept[rows] = now <= np.maximum(before(rows), 0.0)
    return kept


def clear_fingers(
    body: Body,
    poses: Poses,
    hand: Limb,
    at: Floats,
    room: ObstacleScene,
    *,
    other_arm: bool = False,
) -> Poses:
    """Bring the fingers of hands that have reached a control clear of obstacles and of the own body.

    A reach does not count fingers, which bend out of the way: where the body's straight ones are in
    something, and another posture of the hand keeps them out, that one is taken. Nor does it count
    by how much the true surfaces may be inside the spheres: a posture in which the spheres too are no
    deeper in the own body than flesh gives, elbow out or up, goes before one in which they are.

    Parameters
    ----------
    poses
        Of rows of the body.
    at
        (P, 3) where the hand of each is [m].
    room
        The obstacles; in those that are `held` the hand may be.
    other_arm
        As of `own_body`.
    """
    arm = arm_alone(body, hand)
    task, angles = as_posed(body, poses, with_fingers(body, arm))
    task = replace(task, goal=goals_of(at))
    rotations = np.array(poses.rotations)
    left = np.arange(len(task))
    for flesh_alone in (True, False):
        own = own_body(body, poses, arm, other_arm=other_arm, flesh_alone=flesh_alone)
        around = replace(room, own=own)
        deep = deep_in(rows_of(task, left), angles[left], around).overlap > 0.0
        left = left[deep]
        some = rows_of(task, left)
        found, doubt = avoid_obstacles(some, _known(some, angles[left]), around, effort=FEW_STARTS)
        clear = doubt < KEPT
        if flesh_alone and len(left):  # for no place deeper in what the hand holds
            parts = replace(room, held=())
            was, now = (deep_in(some, at, parts).overlap for at in (angles[left], found.angles))
            clear &= now <= np.maximum(was, 0.0)
        rotations[left[clear]] = joint_rotations(some, found.angles)[clear]
        left = left[~clear]
    return replace(poses, rotations=rotations)
