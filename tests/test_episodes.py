"""Episodes of contact in motions: hand-checkable spells, dense sampling as the oracle, and laws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests import oracles
from tests.conftest import box_part, environment_of
from workbench.model.environment import Allowance

EXACT = 2e-6


def motion_of(body, positions, *, time=None, angles=None):
    """A motion through positions (F, 3) of the reference segment."""
    poses = wb.join_poses([wb.pose(body, angles or {}, position=at) for at in positions])
    return replace(poses, time=None if time is None else np.array(time, dtype=float))


def keys(found):
    return list(zip(found.segment.tolist(), found.part.tolist(), strict=True))


@pytest.fixture(scope="module")
def slab():
    """200 mm thick, 10 m wide, its top at 0."""
    return environment_of(box_part("slab", [-5, -5, -0.2], [5, 5, 0]))


def test_a_ball_through_a_slab_enters_is_deepest_and_leaves_by_hand(two_spheres, slab):
    # the first ball, 10 mm, falls 1 m a second from 0.5 m: enters at 0.49 s, deepest in the middle,
    # leaves at 0.71 s
    way = motion_of(two_spheres, [[0, 0, 0.5], [0, 0, -1.5]], time=[10, 12])
    found = wb.episodes(two_spheres, way, slab)
    first = found.rows(found.segment == 0)
    assert first.enter == pytest.approx([10.49], abs=EXACT)
    assert first.leave == pytest.approx([10.71], abs=EXACT)
    assert first.distance == pytest.approx([-0.11], abs=1e-5)
    assert first.deepest == pytest.approx([10.6], abs=1e-5)
    assert first.cut_short[0].tolist() == [False]


def test_a_contact_over_many_frames_is_one_episode(two_spheres, slab):
    height = np.concatenate([np.linspace(0.1, -0.05, 40), np.linspace(-0.05, 0.1, 40)])
    way = motion_of(
        two_spheres,
        np.stack([np.zeros(80), np.zeros(80), height], axis=1),
        time=np.arange(80) / 100,
    )
    found = wb.episodes(two_spheres, way, slab)
    first = found.rows(found.segment == 0)
    step = 0.15 / 39
    assert len(first) == 1
    assert first.enter == pytest.approx([0.09 / step / 100], abs=1e-7)
    assert first.leave == pytest.approx([0.79 - 0.09 / step / 100], abs=1e-7)
    assert first.distance == pytest.approx([-0.06], abs=1e-5)
    assert first.deepest == pytest.approx([0.395], abs=0.006)


def test_two_visits_are_two_episodes_in_order(two_spheres, slab):
    way = motion_of(two_spheres, [[0, 0, z] for z in (0.1, -0.02, 0.1, -0.03, 0.1)])
    found = wb.episodes(two_spheres, way, slab)
    first = found.rows(found.segment == 0)
    assert first.enter == pytest.approx([0.75, 2 + 0.09 / 0.13], abs=EXACT)
    assert first.distance == pytest.approx([-0.03, -0.04], abs=1e-5)
    assert first.deepest == pytest.approx([1, 3], abs=1e-4)
    assert first.frame.tolist() == [1, 3]


def test_contact_at_both_ends_of_a_motion_is_cut_short(two_spheres, slab):
    way = motion_of(two_spheres, [[0, 0, 0], [0.5, 0, 0]], time=[3, 4])
    found = wb.episodes(two_spheres, way, slab, by="sphere")
    assert [mask.all() for mask in found.cut_short] == [True, True]
    assert found.enter.tolist() == [3, 3, 3, 3]
    assert found.leave.tolist() == [4, 4, 4, 4]


def test_allowed_depth_begins_the_episode_and_is_carried(two_spheres, slab):
    soft = replace(slab, allowances=(Allowance(0, ("all",), 0.005),))
    way = motion_of(two_spheres, [[0, 0, 0.1], [0, 0, -0.1]])
    found = wb.episodes(two_spheres, way, soft).rows(np.array([0]))
    assert found.enter == pytest.approx([(0.1 - 0.005) / 0.2], abs=EXACT)
    assert found.allowed == pytest.approx(0.005)


def test_sheets_passed_within_one_frame_are_as_many_episodes(two_spheres):
    sheets = environment_of(
        *[box_part(f"sheet{i}", [0.1 * i, -1, -1], [0.1 * i + 0.001, 1, 1]) for i in range(20)]
    )
    way = motion_of(two_spheres, [[-50, 0, 0], [50, 0, 0]])
    found = wb.episodes(two_spheres, way, sheets)
    assert len(found) == 4 * 20  # the rod has a sphere at each end
    ball = found.rows(found.segment == 0)
    assert ball.part.tolist() == list(range(20))
    assert ball.enter == pytest.approx((50 + 0.1 * np.arange(20) - 0.01) / 100, abs=EXACT)


def test_bodies_that_pass_each_other_touch_for_the_hand_reckoned_time(two_spheres):
    still = motion_of(two_spheres, [[0, 0, 0], [0, 0, 0]], time=[0, 2])
    way = motion_of(two_spheres, [[-1, 0.012, 0], [1, 0.012, 0]], time=[0, 2])
    found = wb.body_episodes((two_spheres, way), (two_spheres, still))
    pair = found.rows((found.segment == 0) & (found.other_segment == 0))
    assert [*pair.enter, *pair.leave] == pytest.approx([1 - 0.016, 1 + 0.016], abs=2 * EXACT)
    assert pair.distance == pytest.approx([-0.008], abs=1e-5)
    assert pair.deepest == pytest.approx([1.0], abs=1e-3)


def test_an_arm_that_folds_touches_itself_beyond_its_allowance(one_arm):
    folded = wb.join_poses([wb.pose(one_arm, {"ELBOW": {"flexion": a}}) for a in (0, 170, 0)])
    found = wb.self_episodes(one_arm, folded, by="sphere")
    assert len(found)
    assert np.all(found.enter < 1) and np.all(found.leave > 1)
    assert found.enter == pytest.approx(2 - found.leave, abs=EXACT)
    assert np.all(-found.distance - found.allowed > 0)
    assert found.deepest == pytest.approx(1, abs=1e-2)


def test_nothing_in_the_way_is_no_episode(two_spheres, slab):
    found = wb.episodes(two_spheres, motion_of(two_spheres, [[0, 0, 1], [0, 0, 2]]), slab)
    assert len(found) == 0
    assert len(wb.self_episodes(two_spheres, motion_of(two_spheres, [[0, 0, 1], [0, 0, 2]]))) == 0


def test_motions_that_cannot_be_are_told(two_spheres, slab):
    with pytest.raises(wb.InputError, match="at least two frames, got 1"):
        wb.episodes(two_spheres, motion_of(two_spheres, [[0, 0, 0]]), slab)
    with pytest.raises(wb.InputError, match="finite and rise"):
        wb.episodes(two_spheres, motion_of(two_spheres, np.zeros((2, 3)), time=[1, 1]), slab)
    with pytest.raises(wb.UsageError, match="by='part'"):
        wb.episodes(two_spheres, motion_of(two_spheres, np.zeros((2, 3))), slab, by="part")


@given(st.integers(0, 10**6))
def test_a_motion_backwards_has_the_same_episodes_backwards(one_arm, random_arm, box_cab, seed):
    motion = random_arm(3, seed, 0.3)
    back = wb.Poses(motion.rotations[::-1], 0, motion.world_from_reference[::-1])
    one = wb.episodes(one_arm, motion, box_cab)
    two = wb.episodes(one_arm, back, box_cab)
    assert keys(one) == keys(two)
    order = np.lexsort((2 - two.leave, two.part, two.segment))
    assert np.allclose(one.enter, (2 - two.leave)[order], rtol=0, atol=2 * EXACT)
    assert np.allclose(one.leave, (2 - two.enter)[order], rtol=0, atol=2 * EXACT)
    assert np.allclose(one.distance, two.distance[order], rtol=0, atol=2.1e-5)


@settings(max_examples=20)
@given(st.integers(0, 10**6))
def test_episodes_equal_dense_sampling(one_arm, random_arm, box_cab, seed):
    motion = random_arm(3, seed, 0.3)
    found = wb.episodes(one_arm, motion, box_cab)
    oracles.check_episodes(one_arm, motion, box_cab, found, steps=400)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(50))
def test_episodes_equal_dense_sampling_at_ten_thousand_steps(one_arm, random_arm, box_cab, seed):
    motion = random_arm(3, seed, 1.0)
    found = wb.episodes(one_arm, motion, box_cab)
    oracles.check_episodes(one_arm, motion, box_cab, found, steps=10_000)


def test_the_first_episode_begins_at_the_first_contact(one_arm, random_arm, box_cab):
    motion = random_arm(2, 11, 0.3)
    start, end = (
        wb.Poses(motion.rotations[[i]], 0, motion.world_from_reference[[i]]) for i in (0, 1)
    )
    first = wb.sweep(one_arm, (start, end), box_cab, by="part")[0]
    found = wb.episodes(one_arm, motion, box_cab)
    wanted = np.full(first.shape, np.nan)
    for row in reversed(range(len(found))):
        wanted[found.segment[row], found.part[row]] = found.enter[row]
    assert np.allclose(first, wanted, rtol=0, atol=EXACT, equal_nan=True)
    assert np.isfinite(first).any()


def test_no_episode_depends_on_the_number_of_threads(one_arm, random_arm, box_cab):
    motion = random_arm(200, 5, 0.1)
    one, two = (wb.episodes(one_arm, motion, box_cab, threads=n) for n in (1, 3))
    assert len(one) > 20
    for name in ("enter", "deepest", "leave", "distance", "segment", "sphere", "part", "frame"):
        assert np.array_equal(getattr(one, name), getattr(two, name))
