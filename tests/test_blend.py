"""Blended spheres: smooth across a joint, exact where they can be checked by hand, inside their
enclosing spheres."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import ONE_ARM
from tests.rows import changed
from workbench.files.body.writer import body_text
from workbench.model.quaternions import rotate
from workbench.model.skinning import enclosing_spheres

BLENDED = ONE_ARM.replace(
    "    spheres: [[0, 0, 100, 30], [20, 0, 0, 30], [20, 0, -100, 30]]",
    "    blend: {ELBOW: {1: 0.5}, WRIST: {2: 0.4}}\n    spheres: [[0, 0, 100, 30], [20, 0, 0, 30], [20, 0, -100, 30]]",
)


@pytest.fixture(scope="module")
def blended(tmp_path_factory):
    """The one arm; the middle sphere of its forearm half blended across the elbow, the last one
    across the wrist."""
    path = tmp_path_factory.mktemp("zoo") / "one_arm.yaml"
    path.write_text(BLENDED)
    return wb.load_body(path)


def random_blend(body, seed):
    """The body with every sphere blended across a random joint of its segment by a random share."""
    rng = np.random.default_rng(seed)
    segment = body.sphere_segment
    near = [
        [j for j in range(len(body.joints)) if n in (j + 1, body.parent[j + 1])]
        for n in range(len(body.segments))
    ]
    joint = np.array([rng.choice(near[n]) if near[n] else -1 for n in segment])
    made = changed(body, blend_joint=joint, blend_share=rng.uniform(0, 1, len(segment)))
    (centre,), (radius,) = enclosing_spheres(made)
    return changed(made, enclosing_centre=centre, enclosing_radius=radius)


def test_the_file_says_what_is_blended_across_which_joint(blended):
    assert blended.blend_joint.tolist() == [-1, -1, -1, -1, -1, 1, 2, -1, -1, -1]
    assert blended.blend_share[0, 5:7].tolist() == [0.5, 0.4]


def test_in_the_zero_pose_nothing_moves_at_all(one_arm, blended):
    pose = wb.pose(one_arm, {})
    assert np.array_equal(wb.place(blended, pose).centres, wb.place(one_arm, pose).centres)


def test_half_of_an_elbow_at_90_degrees_is_midway_between_both_segments(blended):
    # elbow at -300; the sphere hangs 100 below and 20 ahead of it; bent forward it stands at (100,
    # 0, -280)
    placed = wb.place(blended, wb.pose(blended, {"ELBOW": {"flexion": 90}}))
    bent = np.array([0.1, 0, -0.28])
    hanging = np.array([0.02, 0, -0.4])
    assert placed.centres[0, 5] == pytest.approx((bent + hanging) / 2, abs=1e-12)


def test_the_wrists_twist_is_shared_and_not_blended_once_more(one_arm, blended):
    pose = wb.pose(one_arm, {"WRIST": {"pronation": 90}})
    assert np.allclose(
        wb.place(blended, pose).centres[0, 6], wb.place(one_arm, pose).centres[0, 6], atol=1e-12
    )


def test_the_wrists_swing_is_blended_after_the_twist(blended):
    placed = wb.place(blended, wb.pose(blended, {"WRIST": {"flexion": 90}}))
    # the sphere is 20 ahead of the wrist; flexion turns about +x, which leaves it there
    assert placed.centres[0, 6] == pytest.approx([0.02, 0, -0.5], abs=1e-12)
    placed = wb.place(blended, wb.pose(blended, {"WRIST": {"radial_deviation": 90}}))
    # about -y: from 20 ahead of the wrist to 20 below or above it; 0.4 of the way
    assert abs(placed.centres[0, 6] - [0.012, 0, -0.5]) == pytest.approx([0, 0, 0.008], abs=1e-12)


def test_a_share_of_none_is_rigid_and_of_all_moves_with_the_other_segment(one_arm, random_arm):
    poses = random_arm(5)
    rigid = wb.place(one_arm, poses)
    joint = np.array([-1, 0, 1, 1, 1, -1, -1, 2, 2, 2])
    none = changed(one_arm, blend_joint=joint, blend_share=np.zeros(10))
    assert np.array_equal(wb.place(none, poses).centres, rigid.centres)
    # the upper arm's last sphere, carried along by the forearm: the elbow is its own middle, so 150
    # below it
    share = np.array([0, 0, 1.0, 0, 0, 0, 0, 0, 0, 0])
    moved = wb.place(changed(one_arm, blend_joint=joint, blend_share=share), poses)
    lower = rigid.world_from_segment[:, 2]
    at = np.array([0, 0, 0.1]) + one_arm.centre[0, 2] - one_arm.joint_in_parent[0, 1]
    assert np.allclose(moved.centres[:, 2], lower[:, :, :3] @ at + lower[:, :, 3], atol=1e-12)


@given(st.integers(0, 10**6))
def test_the_formula_of_two_frames_is_what_the_kernel_does(one_arm, random_arm, seed):
    body = random_blend(changed(one_arm, twist_joint=np.full(4, -1)), seed)
    poses = random_arm(3, seed)
    body = changed(body, twist_share=np.zeros(10))
    placed = wb.place(body, poses)
    world = placed.world_from_segment
    segment = body.sphere_segment
    for s in np.flatnonzero(body.blend_joint >= 0):
        n = int(segment[s])
        j = int(body.blend_joint[s])
        other = int(body.parent[n]) if j == n - 1 else j + 1
        point = body.joint_in_child[0, j] if j == n - 1 else body.joint_in_parent[0, j]
        w = body.blend_share[0, s]
        turn = (1 - w) * world[:, n, :, :3] + w * world[:, other, :, :3]
        at = world[:, n, :, :3] @ point + world[:, n, :, 3] + turn @ (body.centre[0, s] - point)
        assert np.allclose(placed.centres[:, s], at, atol=1e-12)


@given(st.integers(0, 10**6))
def test_both_sides_of_a_joint_that_shares_its_twist_stay_together(one_arm, seed):
    """Two spheres at the same place near the wrist, one of the forearm and one of the hand, both
    halfway blended."""
    rng = np.random.default_rng(seed)
    spot = np.array([0.02, 0.01, 0.0])
    centre = one_arm.centre[0].copy()
    centre[6] = one_arm.joint_in_parent[0, 2] + spot
    centre[7] = one_arm.joint_in_child[0, 2] + spot
    share = one_arm.twist_share[0].copy()
    share[6] = 1.0
    joint = np.full(10, -1)
    joint[6:8] = 2
    body = changed(
        one_arm, centre=centre, twist_share=share, blend_joint=joint, blend_share=np.full(10, 0.5)
    )
    q = rng.normal(size=(1, 3, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    placed = wb.place(body, wb.Poses(q, 0, np.eye(3, 4)[None]))
    assert np.allclose(placed.centres[0, 6], placed.centres[0, 7], atol=1e-9)


@given(st.integers(0, 10**6), st.integers(0, 3))
def test_a_batch_of_blended_bodies_equals_its_rows_to_the_last_bit(
    one_arm, random_arm, seed, reference
):
    body = random_blend(one_arm, seed)
    poses = random_arm(4, seed)
    poses = wb.Poses(poses.rotations, reference, poses.world_from_reference)
    whole = wb.place(body, poses)
    for p in range(4):
        row = wb.Poses(poses.rotations[p : p + 1], reference, poses.world_from_reference[p : p + 1])
        assert np.array_equal(wb.place(body, row).centres[0], whole.centres[p])


@given(st.integers(0, 10**6), st.sampled_from(["SHOULDER", "ELBOW", "WRIST"]), st.integers(0, 3))
def test_incremental_update_of_blended_spheres_equals_the_full_chain(
    one_arm, random_arm, seed, joint, reference
):
    body = random_blend(one_arm, seed)
    poses = random_arm(3, seed)
    poses = wb.Poses(poses.rotations, reference, poses.world_from_reference)
    rotations = poses.rotations.copy()
    rotations[:, body.joint(joint)] = random_arm(3, seed + 1).rotations[:, 0]
    changed = wb.Poses(rotations, reference, poses.world_from_reference)
    updated = wb.update(wb.place(body, poses), changed, first_changed=joint)
    assert np.array_equal(updated.centres, wb.place(body, changed).centres)


@given(st.integers(0, 10**6))
def test_a_window_gives_blended_spheres_the_same_numbers(one_arm, random_arm, seed):
    body = random_blend(one_arm, seed)
    poses = random_arm(3, seed)
    whole = wb.place(body, poses)
    part = wb.place(body, poses, window=["LOWER"])
    assert np.array_equal(whole.centres[:, :7], part.centres[:, :7])
    assert np.isnan(part.centres[:, 7:]).all()


@given(st.integers(0, 10**6))
def test_rereferencing_carries_blended_spheres_along(one_arm, random_arm, seed):
    body = random_blend(one_arm, seed)
    poses = random_arm(2, seed)
    placed = wb.place(body, poses)
    again = wb.place(body, wb.Poses(poses.rotations, 2, placed.world_from_segment[:, 2]))
    assert np.allclose(again.centres, placed.centres, rtol=0, atol=1e-12)


@given(st.integers(0, 10**6))
def test_enclosing_spheres_hold_blended_spheres_in_any_pose(bubbleman, seed):
    body = random_blend(bubbleman, seed)
    q = np.random.default_rng(seed).normal(size=(8, len(body.joints), 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    placed = wb.place(body, wb.Poses(q, 0, np.broadcast_to(np.eye(3, 4), (8, 3, 4))))
    world = placed.world_from_segment
    segment = body.sphere_segment
    around = np.einsum("pnij,nj->pni", world[..., :3], body.enclosing_centre[0]) + world[..., 3]
    reach = np.linalg.norm(placed.centres - around[:, segment], axis=-1) + body.radius[0]
    assert (reach - body.enclosing_radius[0, segment]).max() <= 1e-9


def test_the_sphere_at_a_joint_stays_at_the_joint_however_it_is_blended(bubbleman):
    body = random_blend(bubbleman, 3)
    q = np.random.default_rng(3).normal(size=(5, len(body.joints), 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    for s in np.flatnonzero(
        np.linalg.norm(body.centre[0] - body.joint_in_parent[0, body.blend_joint], axis=1) < 1e-9
    ):
        j = int(body.blend_joint[s])
        if body.parent[j + 1] != body.sphere_segment[s]:
            continue
        placed = wb.place(body, wb.Poses(q, 0, np.broadcast_to(np.eye(3, 4), (5, 3, 4))))
        world = placed.world_from_segment[:, j + 1]
        joint = rotate_all(world, body.joint_in_child[0, j])
        assert np.allclose(placed.centres[:, s], joint, atol=1e-9)


def rotate_all(world, point):
    return world[:, :, :3] @ point + world[:, :, 3]


def test_a_blended_body_is_written_and_read_again_as_it_was(blended, tmp_path):
    path = tmp_path / "again.yaml"
    origin = tmp_path / "one_arm.yaml"
    origin.write_text(BLENDED)
    path.write_text(body_text(blended, origin, name="again", description=""))
    again = wb.load_body(path)
    assert again.blend_joint.tolist() == blended.blend_joint.tolist()
    assert again.blend_share[0].tolist() == blended.blend_share[0].tolist()
    assert again.sphere_names == blended.sphere_names


def test_a_body_file_in_metres_is_written_as_finely_as_one_in_millimetres(tmp_path):
    ball = "name: ball, number: 1, mass: 1, directions: {front: +x, left: +y, top: +z}"
    origin = tmp_path / "ball.yaml"
    origin.write_text(
        f"body: ball\nlength: m\nsegments: {{B: {{{ball}, spheres: [[0, 0, 0.0123456, 0.1002]]}}}}\n"
    )
    path = tmp_path / "again.yaml"
    path.write_text(body_text(wb.load_body(origin), origin, name="again", description="in metres"))
    again = wb.load_body(path)
    assert again.centre[0, 0].tolist() == [0, 0, 0.012346] and again.radius[0, 0] == 0.1002


@pytest.mark.parametrize(
    ("blend", "words"),
    [
        (
            "{SHOULDER: {1: 0.5}}",
            "blend.SHOULDER: not a joint of LOWER (got 'SHOULDER'); valid: ELBOW, WRIST",
        ),
        ("{ELBOW: {3: 0.5}}", "LOWER has the spheres 0 to 2 (got 3)"),
        ("{ELBOW: {1: 0.5}, WRIST: {1: 0.5}}", "sphere 1 is blended across ELBOW already"),
        ("{ELBOW: {1: 1.5}}", "blend.ELBOW.1: input should be less than or equal to 1"),
        ("{ELBOW: {first: 0.5}}", "blend.ELBOW"),
    ],
)
def test_a_wrong_blend_is_told_where_it_stands(tmp_path, blend, words):
    path = tmp_path / "wrong.yaml"
    path.write_text(BLENDED.replace("{ELBOW: {1: 0.5}, WRIST: {2: 0.4}}", blend))
    with pytest.raises(wb.InputError) as caught:
        wb.load_body(path)
    assert words in str(caught.value)
    assert ":18:" in str(caught.value)


def test_a_body_cannot_be_blended_across_a_joint_of_another_segment(one_arm):
    with pytest.raises(wb.InputError, match="a joint of its own segment"):
        changed(one_arm, blend_joint=np.full(10, 2), blend_share=np.full(10, 0.1))
    with pytest.raises(wb.InputError, match="between 0 and 1"):
        changed(one_arm, blend_joint=np.full(10, -1), blend_share=np.full(10, 1.1))


def test_quaternions_and_their_matrices_agree_about_what_is_carried(blended):
    placed = wb.place(blended, wb.pose(blended, {"ELBOW": {"flexion": 45}}))
    q = wb.pose(blended, {"ELBOW": {"flexion": 45}}).rotations[0, 1]
    lever = np.array([0.02, 0, -0.1])
    wanted = np.array([0, 0, -0.3]) + 0.5 * (rotate(q[None], lever[None])[0] + lever)
    assert placed.centres[0, 5] == pytest.approx(wanted, abs=1e-12)
