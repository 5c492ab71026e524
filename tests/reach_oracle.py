"""Slow oracles of reaches among obstacles: postures drawn from all over the joints' ranges, brought
to the target, and there kept off what they enter. They use the package's contacts, stops and
forward kinematics, and none of its solver.
"""

from __future__ import annotations

import numpy as np

import workbench as wb
from workbench import stops
from workbench.model.posing import angles_of, compose

STEP = 1e-6
ROUNDS = 12
MOST_TURN = 0.3
OFF = 5e-4
TIP = 1e-4
DAMPING = 1e-4
MOST = 16
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
        legal = _margin(body, arm, pose, angles) >= 0
        best = np.flatnonzero(legal)[np.argsort(off[legal])[:keep]]
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


def slow_ways(body, arm, pose, target, environment, *, starts=24, draws=6000, rounds=30, seed=1):
    """Postures (n, J, 4) that bring the tip to a target within 0.1 mm, keep the stops and enter
    nothing, none where none is found: from the nearest of drawn postures, damped least squares on
    the distance, the breach of the stops and the overlaps at once. Slopes are differences; a
    contact is pushed out along its normal."""
    rng = np.random.default_rng(seed)
    free = list(arm.free)
    angles = np.repeat(angles_of(body, pose)[:1], draws, axis=0)
    low = -body.stops.limits[free, :, 1]
    high = body.stops.limits[free, :, 0]
    angles[:, free] = rng.uniform(low, high, (draws, len(free), 3))
    off = np.linalg.norm(_tips(body, arm, pose, angles) - target, axis=1)
    legal = np.flatnonzero(_margin(body, arm, pose, angles) >= 0)
    angles = angles[legal[np.argsort(off[legal])[:starts]]]
    turns = [(j, axis) for j in free for axis in range(3) if body.stops.limits[j, axis].sum() > 0]
    rows, columns = map(list, zip(*turns, strict=True))
    for _ in range(rounds):
        met = _met(body, arm, pose, angles, environment)
        tip, breach, centres = _state(body, arm, pose, angles)
        good = (np.linalg.norm(tip - target, axis=1) < TIP) & (breach < PAST)
        good[met.pose[met.excess > 0]] = False
        if good.any():
            return _poses(body, pose, angles[good]).rotations
        others = np.repeat(angles[None], len(turns), axis=0)
        others[np.arange(len(turns)), :, rows, columns] += STEP
        moved = _state(body, arm, pose, others.reshape(-1, *angles.shape[1:]))
        slopes = [
            (b.reshape(len(turns), *a.shape) - a) / STEP
            for a, b in zip((tip, breach, centres), moved, strict=True)
        ]
        left, slope = _equations((tip - target, breach), slopes, met)
        square = slope.transpose(0, 2, 1) @ slope + DAMPING * np.eye(len(turns))
        step = -np.linalg.solve(square, np.einsum("pri,pr->pi", slope, left)[..., None])[..., 0]
        step *= np.minimum(
            1.0, MOST_TURN / np.maximum(np.abs(step).max(axis=1, keepdims=True), 1e-12)
        )
        angles[:, rows, columns] += step
    return np.zeros((0, len(body.joints), 4))


def _equations(state, slopes, met):
    """What is left (P, 4 + MOST) of tip, stops and deepest contacts, and how it changes with each
    turn (P, 4 + MOST, n)."""
    tip, breach = state
    tips, breaches, centres = slopes
    left = np.zeros((len(tip), 4 + MOST))
    slope = np.zeros((len(tip), 4 + MOST, len(tips)))
    left[:, :3] = tip
    left[:, 3] = breach
    slope[:, :3] = tips.transpose(1, 2, 0)
    slope[:, 3] = breaches.T
    used = np.full(len(tip), 4)
    deep = _is_inside(met)
    inside = set(zip(met.pose[deep], met.sphere[deep], met.part[deep], strict=True))
    for c in np.argsort(-met.excess):
        p = met.pose[c]
        s = met.sphere[c]
        part = met.part[c]
        contrary = (p, s, part) in inside and not deep[c]
        if used[p] < 4 + MOST and not contrary:
            left[p, used[p]] = met.excess[c] + OFF
            slope[p, used[p]] = -centres[:, p, s] @ met.normal[c]
            used[p] += 1
    return left, slope


def _is_inside(met):
    """(C,) whether the sphere's centre is inside the part."""
    return -met.distance > met.body.radius[0, met.sphere]


def _state(body, arm, pose, angles):
    """Tips (P, 3), breaches of the stops (P,) [rad] and centres of all spheres (P, S, 3)."""
    placed = wb.place(
        body, _poses(body, pose, angles), window=[body.segments[segment] for segment in arm.moving]
    )
    world = placed.world_from_segment[:, arm.end]
    tip = np.einsum("pij,j->pi", world[..., :3], arm.tip[0]) + world[..., 3]
    return tip, np.maximum(0.0, -_margin(body, arm, pose, angles)), placed.centres


def _met(body, arm, pose, angles, environment):
    """Contacts of the limb's solid spheres, and what is nearly one."""
    window = [body.segments[segment] for segment in arm.moving]
    met = wb.contacts(
        wb.place(body, _poses(body, pose, angles), window=window), environment, margin=OFF
    )
    return met.rows(arm.solid[0, met.sphere] & (met.excess > -OFF))
