"""Feet on pedals, for the kernel that seats people: legs, goals, comfort, and a first guess at the
seat's place."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.model.posing import motion_of
from workbench.model.quaternions import exponential, multiply, swing_twist
from workbench.model.reach import limit_words
from workbench.posture.kernels.sitting import Legs
from workbench.posture.reaching.chains import (
    AGAIN,
    REACHED,
    TURN_LEVER,
    Found,
    Task,
    cold,
    goals_of,
    limb_task,
    stopped_by,
)
from workbench.posture.reaching.comfort import comfort_modes
from workbench.posture.reaching.limbs import limb
from workbench.posture.seating.posture import Pedals, pointed_foot

__all__ = ["comfortable", "first_places", "foot_tasks", "legs_of", "limits_of"]

HEEL_AGAIN = 0
"""From how many other postures a foot is tried again with its heel on the floor; in the air it is
`AGAIN`."""
FREE_FOOT = 10.0
"""Discomfort of a heel in the air: it is put up with where the pedal cannot be had otherwise."""


def foot_tasks(body: Body, poses: Poses, pedals: Pedals, ahead: Floats) -> list[Task]:
    """For each foot its leg with the ball to go to the pedal, the sole as it is with the heel on
    the floor: pointing in the heading `ahead` (3,), rising as far as the ball is above the heel."""
    count = len(body)
    tasks = []
    for name, at in pedals.at.items():
        ball = pointed_foot(body, name)
        sole = ball.tip - limb(body, name, grip="heel").tip
        goal = goals_of(np.repeat(np.array(at, dtype=np.float64)[None], count, axis=0))
        if pedals.floor is not None:
            size = np.linalg.norm(sole, axis=1)
            rise = np.clip((at[2] - pedals.floor) / size, -0.95, 0.95)
            goal[:, 3:6] = np.sqrt(1.0 - rise * rise)[:, None] * ahead + rise[:, None] * np.array(
                [0.0, 0.0, 1.0]
            )
            goal[:, 9:] = TURN_LEVER
        base = np.zeros((count, 3, 4))
        who = np.arange(count)
        tasks.append(limb_task(body, ball, who, held=poses.rotations, base=base, goal=goal))
    return tasks


def legs_of(tasks: list[Task], pedals: Pedals) -> Legs:
    """The legs packed for the kernel. It takes two; of one there is a copy, which is not looked
    at."""
    two = (tasks * 2)[:2]
    goal = np.stack(
        [np.stack([task.goal, goals_of(task.goal[:, :3])], axis=1) for task in two], axis=1
    )
    return Legs(
        links=(two[0].link, two[1].link),
        goal=goal,
        start=np.stack([cold(task, _angles(task)) for task in two], axis=1),
        seeds=(two[0].seeds, two[1].seeds),
        again=np.array([HEEL_AGAIN, AGAIN, 0]),
        joints=np.array([task.joints for task in two]),
        axes=np.ascontiguousarray(tasks[0].body.stops.axes),
        feet=len(tasks),
        floor=int(pedals.floor is not None),
        in_air=FREE_FOOT,
    )


def comfortable(tasks: list[Task], rotations: Floats) -> Floats:
    """Rotations (B, J, 4) with the legs in comfort."""
    turned = np.array(rotations)
    for task in tasks:
        angles = cold(task, _angles(task))
        axes = task.body.stops.axes[task.joints]
        swing = angles[..., 0, None] * axes[:, 0] + angles[..., 1, None] * axes[:, 1]
        turned[:, task.joints] = multiply(
            exponential(swing), exponential(angles[..., 2, None] * axes[:, 2])
        )
    return turned


def _angles(task: Task) -> Floats:
    """(B, K, 3) [rad] the angles of the leg's joints in the poses."""
    axes = task.body.stops.axes[task.joints]
    swing, twist = swing_twist(task.held[:, task.joints], axes[None, :, 2])
    first, second = (np.sum(swing * axes[None, :, k], axis=-1) for k in (0, 1))
    return np.stack([first, second, twist], axis=-1)


def first_places(tasks: list[Task], lap: Floats, grid: Floats, ahead: Floats) -> Ints:
    """(B,) the place on the seat's travel (G,) from which the legs are likely to be most
    comfortable, from hip, knee and ankle in the plane of each leg; lap (B, 3, 4): the lower torso
    with the seat not moved."""
    total = np.zeros((len(lap), len(grid)))
    for task in tasks:
        total += _planar(task, lap, grid, ahead)
    found: Ints = total.argmin(axis=1)
    return found


def _planar(task: Task, lap: Floats, grid: Floats, ahead: Floats) -> Floats:
    """(B, G) the discomfort of a leg that stands in an upright plane, its sole as the goal has
    it."""
    link = task.link
    body = task.body
    along = task.goal[:, 3:6] if task.goal[0, 9] > 0 else np.broadcast_to(ahead, (len(lap), 3))
    side = np.cross([0.0, 0.0, 1.0], ahead)
    own = link.tip - link.at_child[:, 2]  # from the ankle to the ball, in the foot's frame
    turn = np.arctan2(along[:, 2], along @ ahead) - np.arctan2(
        link.pointing[:, 2], link.pointing[:, 0]
    )
    c = np.cos(turn)
    s = np.sin(turn)
    forth = c * own[:, 0] - s * own[:, 2]
    rise = s * own[:, 0] + c * own[:, 2]
    ankle = task.goal[:, :3] - forth[:, None] * ahead - rise[:, None] * np.array([0.0, 0.0, 1.0])
    hip = np.einsum("bij,bj->bi", lap[:, :, :3], link.at_parent[:, 0]) + lap[:, :, 3]
    thigh = np.linalg.norm(link.at_parent[:, 1] - link.at_child[:, 0], axis=1)[:, None]
    shank = np.linalg.norm(link.at_parent[:, 2] - link.at_child[:, 1], axis=1)[:, None]
    way = (ankle - hip)[:, None] - grid[None, :, None] * ahead
    across = way @ side
    level = np.sqrt((way @ ahead) ** 2 + across**2)
    span = np.clip(np.hypot(level, way[..., 2]), np.abs(thigh - shank) + 1e-6, thigh + shank - 1e-6)
    lack = np.maximum(np.hypot(level, way[..., 2]) - span, 0.0)
    lifted = np.arctan2(way[..., 2], level) + np.arccos(
        (thigh**2 + span**2 - shank**2) / (2 * thigh * span)
    )
    knee = np.pi - np.arccos((thigh**2 + shank**2 - span**2) / (2 * thigh * shank))
    lean = np.arctan2(lap[:, :, 2] @ ahead, lap[:, 2, 2])[
        :, None
    ]  # how far the trunk leans forward
    foot = lifted - knee + 0.5 * np.pi  # the way a neutral foot points, above the horizontal
    angles = {
        "flexion": lifted + 0.5 * np.pi + lean,
        "knee": knee,
        "plantarflexion": foot - turn[:, None],
    }
    cost: Floats = 1e6 * lack
    for joint, (motion, angle) in zip(task.joints, angles.items(), strict=True):
        mode, half = _comfort(body, joint, "flexion" if motion == "knee" else motion)
        cost += ((angle - mode) / half) ** 2
    return cost


def _comfort(body: Body, joint: int, motion: str) -> tuple[float, float]:
    """Mode and half range [rad] of a motion."""
    axis, sign = motion_of(body, joint, motion)
    mode, half = comfort_modes(body, joint)
    return sign * float(mode[axis]), float(half[axis])


def limits_of(task: Task, numbers: Floats) -> tuple[str, ...]:
    """For each person what limits a foot that misses its pedal, "" where it does not; numbers (B,
    8) as of chains."""
    reached = numbers[:, 0] <= REACHED
    count = len(numbers)
    found = Found(
        np.zeros((count, 0, 3)), numbers, np.zeros((count, 0)), np.zeros(count), np.full(count, -1)
    )
    stop = np.stack(stopped_by(task, found, reached))
    return tuple("" if reached[b] else limit_words(task.body, stop[:, b]) for b in range(count))
