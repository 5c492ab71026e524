"""Forward kinematics: hand-checkable places, the slow oracle, and its laws."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests import oracles


def test_the_hanging_arm_has_its_hand_450_mm_below_the_shoulder(one_arm):
    placed = wb.place(one_arm, wb.pose(one_arm, {}))
    tip = placed.centres[0, one_arm.sphere_names.index("fingertip")]
    assert tip == pytest.approx([0, 0, -0.3 - 0.2 - 0.1], abs=1e-15)


def test_elbow_flexion_of_90_degrees_brings_the_hand_forward(one_arm):
    placed = wb.place(one_arm, wb.pose(one_arm, {"ELBOW": {"flexion": 90}}))
    tip = placed.centres[0, one_arm.sphere_names.index("fingertip")]
    assert tip == pytest.approx([0.3, 0, -0.3], abs=1e-12)


def test_abduction_of_the_right_sense_goes_to_the_right(one_arm):
    placed = wb.place(one_arm, wb.pose(one_arm, {"SHOULDER": {"abduction": 90}}))
    tip = placed.centres[0, one_arm.sphere_names.index("fingertip")]
    assert tip == pytest.approx([0, -0.6, 0], abs=1e-12)


def test_forward_equals_the_matrix_oracle(one_arm, random_arm):
    poses = random_arm(20)
    for reference in range(4):
        again = wb.Poses(poses.rotations, reference, poses.world_from_reference)
        placed = wb.place(one_arm, again)
        assert np.allclose(
            placed.world_from_segment, oracles.forward(one_arm, again), rtol=0, atol=1e-12
        )


def test_a_batch_equals_its_rows_to_the_last_bit(one_arm, random_arm):
    poses = random_arm(7)
    whole = wb.place(one_arm, poses)
    for p in range(7):
        row = wb.Poses(poses.rotations[p : p + 1], 0, poses.world_from_reference[p : p + 1])
        assert np.array_equal(wb.place(one_arm, row).centres[0], whole.centres[p])


@given(st.integers(0, 10**6), st.sampled_from(["BASE", "UPPER", "LOWER", "HAND"]))
def test_re_rooting_at_any_segment_leaves_all_distances(one_arm, random_arm, seed, segment):
    poses = random_arm(2, seed)
    placed = wb.place(one_arm, poses)
    n = one_arm.segment(segment)
    again = wb.place(one_arm, wb.Poses(poses.rotations, n, placed.world_from_segment[:, n]))
    assert np.allclose(again.centres, placed.centres, rtol=0, atol=1e-12)
    seen = wb.rereference(placed, segment)
    gaps = [
        np.linalg.norm(c[:, :, None] - c[:, None], axis=-1) for c in (placed.centres, seen.centres)
    ]
    assert np.allclose(gaps[0], gaps[1], rtol=0, atol=1e-12)
    assert np.allclose(seen.world_from_segment[:, n], np.eye(3, 4), atol=1e-12)


@given(st.integers(0, 10**6), st.sampled_from(["SHOULDER", "ELBOW", "WRIST"]), st.integers(0, 3))
def test_incremental_update_equals_the_full_chain_to_the_last_bit(
    one_arm, random_arm, seed, joint, reference
):
    poses = random_arm(3, seed)
    poses = wb.Poses(poses.rotations, reference, poses.world_from_reference)
    placed = wb.place(one_arm, poses)
    rotations = poses.rotations.copy()
    rotations[:, one_arm.joint(joint)] = random_arm(3, seed + 1).rotations[:, 0]
    changed = wb.Poses(rotations, reference, poses.world_from_reference)
    updated = wb.update(placed, changed, first_changed=joint)
    full = wb.place(one_arm, changed)
    assert np.array_equal(updated.world_from_segment, full.world_from_segment)
    assert np.array_equal(updated.centres, full.centres)


def test_the_window_of_figure_5_keeps_two_segments_and_their_paths_to_the_stage(bubbleman):
    placed = wb.place(bubbleman, wb.pose(bubbleman, {}), window=["LLA", "LF"], reference="STG")
    kept = {name for name, shown in zip(bubbleman.segments, placed.window, strict=True) if shown}
    assert kept == {"STG", "LT", "CT", "UT", "LSM", "LUA", "LLA", "LUL", "LLL", "LF"}
    assert np.isnan(placed.centres[0, bubbleman.spheres(bubbleman.segment("H"))]).all()


def test_a_window_gives_the_same_numbers_as_the_whole_body(one_arm, random_arm):
    poses = random_arm(4)
    whole = wb.place(one_arm, poses)
    part = wb.place(one_arm, poses, window=["LOWER"])
    assert np.array_equal(whole.centres[:, :7], part.centres[:, :7])
    assert list(part.window) == [True, True, True, False]


def test_twist_of_the_wrist_grows_linearly_along_the_lower_arm(one_arm):
    placed = wb.place(one_arm, wb.pose(one_arm, {"WRIST": {"pronation": 90}}))
    lower = placed.centres[0, one_arm.spheres(one_arm.segment("LOWER"))]
    assert lower[0] == pytest.approx([0, 0, -0.3])
    half = 0.02 * np.sqrt(0.5)
    assert lower[1] == pytest.approx([half, half, -0.4])
    assert lower[2] == pytest.approx([0, 0.02, -0.5])


def test_the_joints_angle_sets_the_twist_and_swing_does_not(one_arm):
    placed = wb.place(one_arm, wb.pose(one_arm, {"WRIST": {"flexion": 60}}))
    still = wb.place(one_arm, wb.pose(one_arm, {}))
    lower = one_arm.spheres(one_arm.segment("LOWER"))
    assert np.allclose(placed.centres[0, lower], still.centres[0, lower])


def test_joint_coordinates_meet_in_every_pose(bubbleman, library):
    placed, _ = library
    for j in range(len(bubbleman.joints)):
        parent = placed.world_from_segment[:, bubbleman.parent[j + 1]]
        child = placed.world_from_segment[:, j + 1]
        one = parent[:, :, :3] @ bubbleman.joint_in_parent[0, j] + parent[:, :, 3]
        other = child[:, :, :3] @ bubbleman.joint_in_child[0, j] + child[:, :, 3]
        assert np.allclose(one, other, rtol=0, atol=1e-12)


def test_enclosing_spheres_hold_all_spheres_at_every_twist(bubbleman, library):
    placed, _ = library
    world = placed.world_from_segment
    around = (
        np.einsum("pnij,nj->pni", world[..., :3], bubbleman.enclosing_centre[0]) + world[..., 3]
    )
    segment = bubbleman.sphere_segment
    reach = np.linalg.norm(placed.centres - around[:, segment], axis=-1) + bubbleman.radius[0]
    assert np.all(reach <= bubbleman.enclosing_radius[0, segment] + 1e-9)


def test_poses_of_another_body_are_refused(one_arm, bubbleman):
    with pytest.raises(
        wb.InputError, match="poses: expected 19 joints, those of body bubbleman, got 3"
    ):
        wb.place(bubbleman, wb.pose(one_arm, {}))


def test_an_unknown_motion_is_answered_with_the_valid_ones(one_arm):
    with pytest.raises(wb.InputError, match="did you mean 'flexion'"):
        wb.pose(one_arm, {"ELBOW": {"flexon": 3}})
