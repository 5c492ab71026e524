"""The bound of a reach: whatever a limb reaches is within its balls, and what is far is not."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from workbench.model.joint_angles import compose
from workbench.posture.reach_bound import reach_bound

COUNT = 400


def _at_random(body, arm, seed):
    """(P,) poses with the limb's joints anywhere in the boxes of their limits; the first ones at
    the corners."""
    rng = np.random.default_rng(seed)
    angles = np.zeros((COUNT, len(body.joints), 3))
    for joint in arm.free:
        first, second = body.stops.limits[joint].T
        share = rng.uniform(size=(COUNT, 3))
        share[:50] = share[:50].round()
        angles[:, joint] = -second + share * (first + second)
    straight = slice(COUNT // 2, None)
    angles[straight, arm.free[-1]] = 0.0
    angles[straight, arm.free[-2], 0] = 0.0
    pose = wb.pose(body, {}, reference="LT")
    return wb.Poses(
        compose(body, angles),
        pose.reference,
        np.repeat(pose.world_from_reference, COUNT, axis=0),
        person=np.zeros(COUNT, dtype=np.int64),
    )


@pytest.mark.parametrize(
    ("name", "zone"),
    [("left hand", 1), ("left hand", 2), ("right hand", 2), ("right hand", 3), ("left foot", 1)],
)
def test_whatever_a_limb_reaches_is_within_its_bound(bubbleman, name, zone):
    arm = wb.limb(bubbleman, name, zone=zone)
    poses = _at_random(bubbleman, arm, seed=zone)
    frame = wb.place(bubbleman, poses).world_from_segment[:, arm.end]
    tip = np.einsum("bij,j->bi", frame[:, :, :3], arm.tip[0]) + frame[:, :, 3]
    bound = reach_bound(bubbleman, wb.pose(bubbleman, {}, reference="LT"), arm)
    assert not bound.excludes(np.zeros(COUNT, dtype=np.int64), tip).any()
    away = tip - bound.centre[0].mean(axis=0)
    far = bound.centre[0].mean(axis=0) + 3.0 * away / np.linalg.norm(away, axis=1)[:, None]
    assert bound.excludes(np.zeros(COUNT, dtype=np.int64), far).all()


def test_most_of_what_is_missed_for_want_of_length_is_out_of_bounds(bubbleman):
    pose = wb.pose(bubbleman, {}, reference="LT")
    arm = wb.limb(bubbleman, "left hand", zone=2)
    points = np.random.default_rng(3).uniform([0.2, -0.2, 0.0], [1.1, 0.8, 0.9], size=(400, 3))
    found = wb.reach(bubbleman, pose, points, limb=arm)
    missed = ~found.reached[0]
    least = reach_bound(bubbleman, pose, arm).misses(np.zeros(400, dtype=np.int64), points)
    assert (least <= found.miss[0]).all()
    out = least > 0.0
    assert out.sum() > 0.6 * missed.sum() > 100
