"""Feet on pedals, for the kernel that seats people: legs, goals, comfort, a guess at the seat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.criterion import NO_REASON, Reason
from workbench.model.joint_angles import motion_of
from workbench.model.poses import Poses
from workbench.model.quaternions import cross, exponential, multiply, swing_twist
from workbench.model.reach import stop_reason
from workbench.posture.kernels.driving_legs import FLAT
from workbench.posture.kernels.seated_posture import Legs
from workbench.posture.reaching.comfort import comfort_modes
from workbench.posture.reaching.limbs import limb
from workbench.posture.reaching.reach_solver import (
    AGAIN,
    REACHED,
    TURN_LEVER,
    LimbTask,
    ReachSolution,
    cold,
    goals_of,
    limb_task,
    stopped_by,
)
from workbench.posture.seating.posture import Pedals, pointed_foot

__all__ = [
    "LegTriangle",
    "comfortable",
    "first_places",
    "foot_tasks",
    "leg_triangle",
    "legs_of",
    "limits_of",
]

HEEL_AGAIN = 0
"""From how many other postures a foot is tried again with its heel on the floor; in the air it is
`AGAIN`."""
FREE_FOOT = 10.0
"""Discomfort of a heel in the air: it is accepted where the pedal cannot be reached otherwise."""
OUT_OF_REACH = 1e6
"""Discomfort [1/m] of an ankle that a leg does not reach. It outweighs every angle."""
UP = np.array([0.0, 0.0, 1.0])


def foot_tasks(body: Body, poses: Poses, pedals: Pedals, ahead: Floats) -> list[LimbTask]:
    """Make a task for each foot: its ball goes to the pedal, its sole lies as with the heel down.

    Parameters
    ----------
    body, poses
        B people, and a pose of each.
    pedals
        The pedals, and the floor.
    ahead
        (3,) unit heading of the person. A sole points that way and rises as far as the pedal is
        above the floor.

    Returns
    -------
    list
        A task for each foot, with B rows.
    """
    count = len(body)
    tasks = []
    for name, at in pedals.at.items():
        ball = pointed_foot(body, name)
        sole = ball.tip - limb(body, name, grip="heel").tip
        goal = goals_of(np.repeat(np.array(at, dtype=np.float64)[None], count, axis=0))
        if pedals.floor is not None:
            size = np.linalg.norm(sole, axis=1)
            rise = np.clip((at[2] - pedals.floor) / size, -0.95, 0.95)
            goal[:, 3:6] = np.sqrt(1.0 - rise * rise)[:, None] * ahead + rise[:, None] * UP
            goal[:, 9:] = TURN_LEVER
        base = np.zeros((count, 3, 4))
        who = np.arange(count)
        tasks.append(limb_task(body, ball, who, held=poses.rotations, base=base, goal=goal))
    return tasks


def legs_of(tasks: list[LimbTask], pedals: Pedals) -> Legs:
    """Pack the legs for the kernel, which takes two: a single one is doubled, and counts once."""
    two = (tasks * 2)[:2]
    goal = np.stack(
        [np.stack([task.goal, goals_of(task.goal[:, :3])], axis=1) for task in two], axis=1
    )
    return Legs(
        links=(two[0].link, two[1].link),
        goal=goal,
        start=np.ascontiguousarray(np.stack([cold(task, _angles(task)) for task in two], axis=1)),
        seeds=(two[0].seeds, two[1].seeds),
        again=np.array([HEEL_AGAIN, AGAIN, 0]),
        joints=np.array([task.joints for task in two]),
        axes=np.ascontiguousarray(tasks[0].body.stops.axes),
        feet=len(tasks),
        along=np.array([foot in pedals.along for foot in (list(pedals.at) * 2)[:2]], np.float64),
        floor=int(pedals.floor is not None),
        in_air=FREE_FOOT,
    )


def comfortable(tasks: list[LimbTask], rotations: Floats) -> Floats:
    """Put the legs at their comfort modes.

    Parameters
    ----------
    tasks
        A task for each leg.
    rotations
        (B, J, 4) joint rotations.

    Returns
    -------
    Floats
        (B, J, 4) the same with the legs in comfort.
    """
    turned = np.array(rotations)
    for task in tasks:
        angles = cold(task, _angles(task))
        axes = task.body.stops.axes[task.joints]
        swing = angles[..., 0, None] * axes[:, 0] + angles[..., 1, None] * axes[:, 1]
        turned[:, task.joints] = multiply(
            exponential(swing), exponential(angles[..., 2, None] * axes[:, 2])
        )
    return turned


def _angles(task: LimbTask) -> Floats:
    """(B, K, 3) [rad] the angles of the leg's joints in the poses."""
    axes = task.body.stops.axes[task.joints]
    swing, twist = swing_twist(task.held[:, task.joints], axes[None, :, 2])
    first, second = (np.sum(swing * axes[None, :, k], axis=-1) for k in (0, 1))
    return np.stack([first, second, twist], axis=-1)


def first_places(
    tasks: list[LimbTask], lap: Floats, grid: Floats, ahead: Floats, along: Floats
) -> Ints:
    """Guess where on the seat's travel the legs are most comfortable, from triangles in a plane.

    Parameters
    ----------
    tasks
        A task for each foot, with B rows.
    lap
        (B, 3, 4) the lower torso with the seat not moved [m].
    grid
        (B, G) positions of each seat, forward [m].
    ahead
        (3,) unit direction in which the seat travels.
    along
        (F,) 1 for a foot whose pedal moves with the seat, else 0: where the seat stands is all the
        same to it.

    Returns
    -------
    Ints
        (B,) indices of positions.
    """
    total = np.zeros(grid.shape)
    for task, moves in zip(tasks, along, strict=False):
        total += _planar_discomfort(task, lap, grid * (1.0 - moves), ahead)
    return total.argmin(axis=1)


def _planar_discomfort(task: LimbTask, lap: Floats, grid: Floats, ahead: Floats) -> Floats:
    """(B, G) discomfort of a leg that stands in an upright plane, its sole as the goal has it."""
    link = task.link
    ankle, turn = _ankle_of_goal(task, ahead)
    hip = np.einsum("bij,bj->bi", lap[:, :, :3], link.at_parent[:, 0]) + lap[:, :, 3]
    way = (ankle - hip)[:, None] - grid[:, :, None] * ahead
    level = np.sqrt((way @ ahead) ** 2 + (way @ cross(UP, ahead)) ** 2)
    thigh = np.linalg.norm(link.at_parent[:, 1] - link.at_child[:, 0], axis=1)[:, None]
    shank = np.linalg.norm(link.at_parent[:, 2] - link.at_child[:, 1], axis=1)[:, None]
    leg = leg_triangle(thigh, shank, np.hypot(level, way[..., 2]))
    lifted = np.arctan2(way[..., 2], level) + leg.hip
    bent = np.pi - leg.knee
    lean = np.arctan2(lap[:, :, 2] @ ahead, lap[:, 2, 2])[:, None]  # of the trunk, forward
    foot = lifted - bent + 0.5 * np.pi  # the way a neutral foot points, above the horizontal
    angles = {
        "flexion": lifted + 0.5 * np.pi + lean,
        "knee": bent,
        "plantarflexion": foot - turn[:, None],
    }
    cost: Floats = OUT_OF_REACH * np.maximum(leg.lack, 0.0)
    for joint, (motion, angle) in zip(task.joints, angles.items(), strict=True):
        mode, half = _comfort(task.body, joint, "flexion" if motion == "knee" else motion)
        cost += ((angle - mode) / half) ** 2
    return cost


def _ankle_of_goal(task: LimbTask, ahead: Floats) -> tuple[Floats, Floats]:
    """Ankles (B, 3) [m] of feet on their pedals, and by how much the feet are tipped up (B,) [rad].

    A goal without a direction leaves the foot level.
    """
    link = task.link
    along = task.goal[:, 3:6]
    if not task.goal[0, 9] > 0:
        along = np.broadcast_to(ahead, along.shape)
    own = link.tip - link.at_child[:, 2]  # from the ankle to the ball, in the foot's frame
    neutral = np.arctan2(link.pointing[:, 2], link.pointing[:, 0])
    turn: Floats = np.arctan2(along[:, 2], along @ ahead) - neutral
    c = np.cos(turn)
    s = np.sin(turn)
    forth = c * own[:, 0] - s * own[:, 2]
    rise = s * own[:, 0] + c * own[:, 2]
    ankle: Floats = task.goal[:, :3] - forth[:, None] * ahead - rise[:, None] * UP
    return ankle, turn


def _comfort(body: Body, joint: int, motion: str) -> tuple[float, float]:
    """Mode and half range [rad] of a motion."""
    axis, sign = motion_of(body, joint, motion)
    mode, half = comfort_modes(body, joint)
    return sign * float(mode[axis]), float(half[axis])


def limits_of(task: LimbTask, numbers: Floats) -> tuple[Reason, ...]:
    """Tell what limits a foot that misses its pedal, for each person; `NO_REASON` where it does not.

    Parameters
    ----------
    task
        The task of the foot, with B rows.
    numbers
        (B, 8) as of `posture.kernels.inverse.Solutions`.

    Returns
    -------
    tuple
        B reasons.
    """
    reached = numbers[:, 0] <= REACHED
    count = len(numbers)
    found = ReachSolution(
        np.zeros((count, 0, 3)), numbers, np.zeros((count, 0)), np.zeros(count), np.full(count, -1)
    )
    stop = np.stack(stopped_by(task, found, reached))
    return tuple(
        NO_REASON if reached[b] else stop_reason(task.body, stop[:, b]) for b in range(count)
    )


@dataclass(frozen=True, eq=False)
class LegTriangle:
    """Legs whose hip and ankle are given. The arrays have the shape of their distances."""

    hip: Floats
    """[rad] between the thigh and the line from hip to ankle."""
    knee: Floats
    """[rad] between thigh and shank: pi for a straight leg."""
    lack: Floats
    """[m] by how much the ankle is out of reach: negative if it is too near."""


def leg_triangle(thigh: Floats, shank: Floats, distance: Floats) -> LegTriangle:
    """Solve the triangle of a leg by the law of cosines.

    Parameters
    ----------
    thigh, shank
        Lengths [m], which broadcast with the distances.
    distance
        From hip to ankle [m]. A leg that cannot span it is stretched, or folded.

    Returns
    -------
    LegTriangle
        Angles at hip and knee, and what the leg lacks.
    """
    span = np.clip(distance, np.abs(thigh - shank) + FLAT, thigh + shank - FLAT)
    hip = np.arccos((thigh**2 + span**2 - shank**2) / (2 * thigh * span))
    knee = np.arccos((thigh**2 + shank**2 - span**2) / (2 * thigh * shank))
    return LegTriangle(hip, knee, distance - span)
