"""Slow oracles of reaches among obstacles: postures drawn from all over the joints' ranges, brought
to the target, and there kept off what they enter. They use the package's contacts, stops and
forward kinematics, and none of its solver.
"""

from __future__ import annotations

import numpy as np

import workbench as wb
from workbench import stops
from workbench.model.joint_angles import angles_of, compose

STEP = 1e-6
ROUNDS = 12
MOST_TURN = 0.3
PAST = np.radians(0.1)


def clear_ways(body, arm, pose, target, environment, *, draws, keep, seed, gap=1e-3):
    """Postures (n, J, 4) of `keep` drawn ones, the nearest of `draws`, that reach a target to
    within gap [m] and enter nothing: random legal angles, then damped least squares on the tip by
    differences, no comfort, no planes."""
    rng = np.random.default_rng(seed)
    free = list(arm.free)
    start = angles_of(body, pose)[0]
    low = -body.stops.limits[free, :, 1]
    high = body.stops.limits[free, :, 0]
    near = []
    gaps = []
    for _ in range(max(draws // 20000, 1)):
        angles = np.repeat(start[None], min(draws, 20000), axis=0)
        angles[:, free] = rng.uniform(low, high, (len(angles), len(free), 3))
        off = np.linalg.norm(_tips(body, arm, pose, angles) - target, axis=1)
        best = _nearest_legal(body, arm, pose, angles, off, keep)
        near.append(angles[best])
        gaps.append(off[best])
    angles = np.concatenate(near)[np.argsort(np.concatenate(gaps))[:keep]]
    angles = _brought(body, arm, pose, angles, target)
    good = np.linalg.norm(_tips(body, arm, pose, angles) - target, axis=1) < gap
    good &= _margin(body, arm, pose, angles) > -PAST
    poses = _poses(body, pose, angles[good])
    met = wb.contacts(wb.place(body, poses), environment)
    met = met.rows(arm.solid[0, met.sphere] & (met.excess > 0))
    clear = np.setdiff1d(np.arange(len(poses)), met.pose)
    return poses.rotations[clear]


def _nearest_legal(body, arm, pose, angles, off, keep):
    """Rows (keep,) of the legal postures that are nearest by off (n,), nearest first: the stops of
    the others are not asked for."""
    order = np.argsort(off)
    found = np.zeros(0, dtype=np.int64)
    while len(found) < keep and len(order):
        some = order[: 2 * keep]
        order = order[2 * keep :]
        found = np.concatenate([found, some[_margin(body, arm, pose, angles[some]) >= 0]])
    return found[:keep]


def _poses(body, pose, angles):
    world = np.repeat(pose.world_from_reference[:1], len(angles), axis=0)
    return wb.Poses(compose(body, angles), pose.reference, world)


def _tips(body, arm, pose, angles):
    placed = wb.place(body, _poses(body, pose, angles), window=[body.segments[arm.end]])
    world = placed.world_from_segment[:, arm.end]
    return np.einsum("pij,j->pi", world[..., :3], arm.tip[0]) + world[..., 3]


def _margin(body, arm, pose, angles):
    return stops(body, _poses(body, pose, angles)).margin[:, list(arm.free)].min(axis=1)


def _brought(body, arm, pose, angles, target):
    """Angles after a few damped least-squares steps toward the target, kept within their own
    ranges."""
    free = [
        (j, axis) for j in arm.free for axis in range(3) if body.stops.limits[j, axis].sum() > 0
    ]
    rows, columns = map(list, zip(*free, strict=True))
    low = -body.stops.limits[rows, columns, 1]
    high = body.stops.limits[rows, columns, 0]
    for _ in range(ROUNDS):
        at = _tips(body, arm, pose, angles)
        slope = np.empty((len(angles), 3, len(free)))
        for i, (j, axis) in enumerate(free):
            other = angles.copy()
            other[:, j, axis] += STEP
            slope[:, :, i] = (_tips(body, arm, pose, other) - at) / STEP
        square = slope @ slope.transpose(0, 2, 1) + 1e-6 * np.eye(3)
        step = np.einsum(
            "pci,pc->pi", slope, np.linalg.solve(square, (target - at)[..., None])[..., 0]
        )
        step *= np.minimum(
            1.0, MOST_TURN / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-12)
        )
        angles[:, rows, columns] = np.clip(angles[:, rows, columns] + step, low, high)
    return angles
