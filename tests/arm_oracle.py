"""Arms with the hand in its place, slowly and obviously: angles drawn within the stops at random, and
brought to the target by Gauss-Newton steps of least change. What the search of clear arms must not
miss."""

from __future__ import annotations

import numpy as np

import workbench as wb
from workbench.posture.reaching.heeding import as_posed
from workbench.posture.reaching.reach_solver import joint_rotations, tips_of

STEPS = 12
AT = 2e-4
"""[m] A hand that is so near is there."""


def arm_postures(body, poses, arm, target, count, rng):
    """Poses (P,) of one person, of `count` that are drawn, whose hand is at a target [m] with the arm
    within its stops."""
    task, start = as_posed(body, poses.rows(np.zeros(count, dtype=np.int64)), arm)
    limits = body.stops.limits[list(task.joints)]
    turns = np.isin(task.joints, arm.free)[:, None] & (limits.sum(axis=2) > 1e-6)
    low, high = -limits[..., 1], limits[..., 0]
    angles = np.where(turns, rng.uniform(size=start.shape) * (high - low) + low, start)
    columns = np.argwhere(turns)
    for _ in range(STEPS):
        tip = tips_of(task, angles)[:, :3]
        slope = np.zeros((count, 3, len(columns)))
        for c, (joint, axis) in enumerate(columns):
            other = angles.copy()
            other[:, joint, axis] += 1e-5
            slope[:, :, c] = (tips_of(task, other)[:, :3] - tip) / 1e-5
        square = slope @ slope.transpose(0, 2, 1) + 1e-5 * np.eye(3)
        step = np.linalg.solve(square, (target - tip)[..., None])
        change = (slope.transpose(0, 2, 1) @ step)[..., 0]
        angles[:, columns[:, 0], columns[:, 1]] += np.clip(change, -0.4, 0.4)
        angles = np.where(turns, np.clip(angles, low, high), angles)
    there = np.linalg.norm(target - tips_of(task, angles)[:, :3], axis=1) < AT
    rotations = joint_rotations(task, angles)[there]
    world = np.repeat(poses.world_from_reference, len(rotations), axis=0)
    every = wb.Poses(rotations, poses.reference, world)
    margin = wb.stops(body, every).margin[:, list(arm.free)].min(axis=1)
    return every.rows(np.flatnonzero(margin >= -1e-3))
