"""Laws of placed bodies and of the distances between their segments: motion, mirrors, threads,
empty batches."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests.rows import changed, rows_of
from tests.test_blend import random_blend
from tests.test_segment_pairs import crowded
from workbench.body import forward
from workbench.contact.batches import paired_clearance
from workbench.contact.collide import self_clearance

MIRROR = np.diag([1.0, -1.0, 1.0])


def moved(poses, seed):
    """The poses after one rigid motion of the world, and that motion: turn (3, 3), shift (3,)."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn[0] *= np.sign(np.linalg.det(turn))
    shift = rng.normal(size=3)
    world = turn @ poses.world_from_reference
    world[:, :, 3] += shift
    return wb.Poses(poses.rotations, poses.reference, world), turn, shift


@given(st.integers(0, 10**6))
def test_a_rigid_motion_of_the_reference_segment_carries_every_sphere_along(
    one_arm, random_arm, seed
):
    body = random_blend(crowded(one_arm, seed, most=9), seed)
    poses = random_arm(3, seed)
    again, turn, shift = moved(poses, seed)
    before = wb.place(body, poses)
    after = wb.place(body, again)
    assert np.allclose(after.centres, before.centres @ turn.T + shift, rtol=0, atol=1e-12)


@given(st.integers(0, 10**6))
def test_a_rigid_motion_changes_no_distance_between_segments(one_arm, random_arm, seed):
    body = random_blend(crowded(one_arm, seed, most=30), seed)
    poses = random_arm(3, seed)
    before, after = (
        self_clearance(wb.place(body, some)).distance for some in (poses, moved(poses, seed)[0])
    )
    finite = np.isfinite(before)
    assert np.array_equal(finite, np.isfinite(after))
    assert np.allclose(before[finite], after[finite], rtol=0, atol=1e-12)


def other_side(names):
    """For each name the place of its twin: R... for L..., or itself."""
    twins = [("R" if n[0] == "L" else "L") + n[1:] if n[0] in "LR" else n for n in names]
    return [names.index(twin) if twin in names else k for k, twin in enumerate(twins)]


@settings(max_examples=10)
@given(st.integers(0, 10**6))
def test_the_mirrored_pose_has_the_mirrored_distances(bubbleman, seed):
    rng = np.random.default_rng(seed)
    turned = np.concatenate([np.ones((2, 19, 1)), 0.3 * rng.normal(size=(2, 19, 3))], axis=-1)
    turned /= np.linalg.norm(turned, axis=-1, keepdims=True)
    poses = wb.Poses(turned, 1, np.repeat(np.eye(3, 4)[None], 2, axis=0))
    joints = other_side(bubbleman.joints)
    segments = other_side(bubbleman.segments)
    mirrored = wb.Poses(turned[:, joints] * [1.0, -1.0, 1.0, -1.0], 1, poses.world_from_reference)
    one, two = (self_clearance(wb.place(bubbleman, some)).distance for some in (poses, mirrored))
    one, two = (np.minimum(d, d.transpose(0, 2, 1)) for d in (one, two))
    two = two[:, segments][:, :, segments]
    finite = np.isfinite(one)
    assert finite.any() and np.allclose(one[finite], two[finite], rtol=0, atol=1e-9)


@pytest.mark.parametrize("size", [1, 7, 256])
def test_neither_threads_nor_pieces_show_in_placed_bodies(one_arm, random_arm, monkeypatch, size):
    body = random_blend(crowded(one_arm, 3), 3)
    poses = random_arm(300, 3)
    whole = wb.place(body, poses)
    monkeypatch.setattr(forward, "_BATCH", size)
    again = wb.place(body, poses)
    assert np.array_equal(again.centres, whole.centres)
    assert np.array_equal(again.world_from_segment, whole.world_from_segment)


def test_the_number_of_threads_does_not_show_in_distances_between_segments(one_arm, random_arm):
    placed = wb.place(crowded(one_arm, 4, most=60), random_arm(700, 4))
    pairs = np.argwhere(np.triu(~placed.body.adjacent))
    alone, together = (
        paired_clearance(placed, placed, pairs, threads=threads) for threads in (1, 3)
    )
    assert all(
        np.array_equal(one, other, equal_nan=True)
        for one, other in zip(alone, together, strict=True)
    )


def test_no_poses_have_no_distances(one_arm, random_arm):
    found = self_clearance(wb.place(one_arm, random_arm(0)))
    assert found.distance.shape == (0, 4, 4) and found.point.shape == (0, 4, 4, 3)


def test_answers_are_nobody_elses_to_change(one_arm, random_arm):
    found = self_clearance(wb.place(one_arm, random_arm(2)))
    for values in (found.distance, found.sphere, found.target, found.point, found.facing):
        assert not values.flags.writeable


@pytest.mark.parametrize("spheres", [3, 4, 5, 8, 11])
def test_a_sphere_stands_where_it_does_whoever_stands_beside_it(one_arm, random_arm, spheres):
    # of segments with fewer than four spheres each goes alone, of others four at a time
    rng = np.random.default_rng(spheres)
    poses = random_arm(5, 1)
    body = random_blend(crowded(one_arm, spheres, most=200), spheres)
    placed = wb.place(body, poses)
    for n in range(len(body.segments)):
        own = np.arange(body.start[n], body.start[n + 1])
        if len(own) < spheres:
            continue
        kept = np.sort(rng.choice(own, spheres, replace=False))
        assert np.array_equal(wb.place(only(body, kept, n), poses).centres, placed.centres[:, kept])


def only(body, kept, n):
    """The body with these spheres alone, all of segment n."""
    start = np.where(np.arange(len(body.segments) + 1) > n, len(kept), 0)
    fields = ("centre", "radius", "sphere_direction", "twist_share", "blend_joint", "blend_share")
    some = {name: rows_of(body, name)[kept] for name in fields}
    return changed(body, start=start, sphere_names=("",) * len(kept), **some)
