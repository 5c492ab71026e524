"""First contact between poses: hand-checkable motions, dense sampling as the oracle, and laws."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests import oracles
from tests.conftest import ROOT, box_part, environment_of
from tests.rows import changed
from workbench.contact.continuous_contact import (
    centres_at,
    frames_of,
    joint_discontinuities,
    pack_motion,
    ways,
)
from workbench.files.meshes.parts import RawPart
from workbench.model.environment import Allowance
from workbench.model.quaternions import from_matrices, matrices
from workbench.model.skinning import enclosing_spheres

EXACT = 2e-6


def at(body, *position, angles=None, turn=None):
    """One pose; turn: a quaternion of the reference segment."""
    attitude = None if turn is None else matrices(np.array(turn, dtype=float))
    return wb.pose(body, angles or {}, position=position, attitude=attitude)


def sheet(low, high, *, axis=2):
    """A rectangle without thickness across an axis."""
    low = np.array(low, dtype=float)
    high = np.array(high, dtype=float)
    u, v = (i for i in range(3) if i != axis)
    corners = np.array([low, low, high, high])
    corners[1, u] = high[u]
    corners[3, u] = low[u]
    corners[:, v] = [low[v], low[v], high[v], high[v]]
    return environment_of(RawPart("sheet", corners, np.array([[0, 1, 2], [0, 2, 3]])), solid=False)


def base_only(one_arm, start, end, environment):
    """First contact of the one arm's base, one sphere of 50 mm."""
    return wb.sweep(one_arm, (start, end), environment, by="sphere")[0, 0]


@pytest.fixture(scope="module")
def plate():
    return environment_of(box_part("plate", [-1, -1, -0.001], [1, 1, 0]))


def test_a_dropped_sphere_meets_the_plate_when_its_height_is_its_radius(one_arm, plate):
    found = wb.sweep(one_arm, (at(one_arm, 0, 0, 1), at(one_arm, 0, 0, -1)), plate, by="sphere")[0]
    heights = wb.place(one_arm, at(one_arm, 0, 0, 1)).centres[0, :, 2]
    assert found == pytest.approx((heights - one_arm.radius[0]) / 2, abs=1e-9)


@pytest.mark.parametrize("speed", [1.0, 100.0, 1e4, 1e6])
@pytest.mark.parametrize("solid", [True, False])
def test_nothing_tunnels_through_a_sheet_of_a_millimetre_at_any_speed(one_arm, speed, solid):
    wall = environment_of(box_part("wall", [0, -1, -1], [0.001, 1, 1]), solid=solid)
    found = base_only(
        one_arm, at(one_arm, -speed / 3, 0, 0), at(one_arm, 2 * speed / 3, 0, 0), wall
    )
    assert found == pytest.approx(1 / 3 - 0.05 / speed, abs=EXACT)


def test_nothing_tunnels_through_a_sheet_without_thickness(one_arm):
    wall = sheet([0, -0.01, -0.01], [0, 0.01, 0.01], axis=0)
    found = base_only(one_arm, at(one_arm, -700, 0, 0), at(one_arm, 300, 0, 0), wall)
    assert found == pytest.approx(0.7 - 0.05 / 1000, abs=EXACT)


def test_a_pendulum_arm_meets_a_wall_at_the_angle_of_the_arcsine(one_arm):
    # the fingertip, 20 mm, hangs 650 mm below the shoulder and swings up by 90 degrees
    turned = at(one_arm, 0, 0, 0, angles={"SHOULDER": {"flexion": 90}})
    way = np.sign(wb.place(one_arm, turned).centres[0, 8, 0])
    low, high = sorted([way * 0.5, way * 0.6])
    wall = environment_of(box_part("wall", [low, -1, -2], [high, 1, 1]))
    found = wb.sweep(one_arm, (at(one_arm, 0, 0, 0), turned), wall, by="sphere")[0, 8]
    lever = -wb.place(one_arm, at(one_arm, 0, 0, 0)).centres[0, 8, 2]
    assert found == pytest.approx(np.arcsin((0.5 - 0.02) / lever) / (np.pi / 2), abs=EXACT)


def test_a_spinning_body_meets_a_thin_sheet_beside_its_way(two_spheres):
    # the far ball, 10 mm at 100 mm, turns half round: first contact with the half plane x = 0, y >
    # 0 at the angle where its centre is 10 mm before the plane
    half = sheet([0, 0.05, -1], [0, 1, 1], axis=0)
    found = wb.sweep(
        two_spheres, (at(two_spheres, 0, 0, 0), at(two_spheres, 0, 0, 0, turn=[0, 0, 0, 1])), half
    )
    assert found[0, 2] == pytest.approx((np.pi / 2 - np.arcsin(0.1)) / np.pi, abs=EXACT)


def test_what_touches_already_touches_at_time_zero(one_arm, plate):
    assert base_only(one_arm, at(one_arm, 0, 0, 0.04), at(one_arm, 0, 0, 1), plate) == 0.0


def test_what_starts_wholly_inside_a_solid_touches_at_time_zero(one_arm, unit_box):
    assert (
        base_only(one_arm, at(one_arm, 0.5, 0.5, 0.5), at(one_arm, 0.5, 0.5, 0.6), unit_box) == 0.0
    )


def test_a_body_at_rest_touches_at_once_or_never(one_arm, plate):
    assert base_only(one_arm, at(one_arm, 0, 0, 0.04), at(one_arm, 0, 0, 0.04), plate) == 0.0
    assert np.isnan(base_only(one_arm, at(one_arm, 0, 0, 0.06), at(one_arm, 0, 0, 0.06), plate))


def test_what_slides_along_a_plate_without_touching_is_free(one_arm, plate):
    for height in (0.05, 0.05 + 1e-9, 0.05 + 1e-6):
        assert np.isnan(
            base_only(one_arm, at(one_arm, -0.2, 0, height), at(one_arm, 0.2, 0, height), plate)
        )
    assert (
        base_only(one_arm, at(one_arm, -0.2, 0, 0.05 - 1e-6), at(one_arm, 0.2, 0, 0.05), plate)
        == 0.0
    )


@pytest.mark.parametrize("miss", [1e-6, 1e-8, 0.0, -1e-6, -1e-4])
def test_balls_that_graze_touch_only_where_they_overlap(two_spheres, miss):
    # two first balls of 10 mm pass each other with their centres 20 mm + miss apart at the middle
    # of the way
    still = at(two_spheres, 0, 0, 0)
    way = (at(two_spheres, -1, 0.02 + miss, 0), at(two_spheres, 1, 0.02 + miss, 0))
    found = wb.body_sweep((two_spheres, *way), (two_spheres, still, still))[0, 0, 0]
    if miss >= 0:
        assert np.isnan(found)
    else:
        assert found == pytest.approx(0.5 - np.sqrt(0.02**2 - (0.02 + miss) ** 2) / 2, abs=EXACT)


def test_a_half_turn_goes_the_way_of_the_end_quaternions_sign(two_spheres):
    start = at(two_spheres, 0, 0, 0)
    ends = [wb.pose(two_spheres, {}, rotations={"J": [0, 0, 0, sign]}) for sign in (1, -1)]
    side = [wb.place(two_spheres, wb.between(start, end, 0.5)).centres[0, 2, 1] for end in ends]
    assert side == pytest.approx([0.1, -0.1])
    wall = sheet([-1, 0.09, -1], [1, 0.09, 1], axis=1)
    times = [wb.sweep(two_spheres, (start, end), wall)[0, 2] for end in ends]
    assert times[0] == pytest.approx(np.arcsin(0.8) / np.pi, abs=EXACT)
    assert np.isnan(times[1])


def test_allowed_depth_is_no_contact_and_hidden_parts_take_no_part(one_arm, plate):
    way = (at(one_arm, 0, 0, 1), at(one_arm, 0, 0, 0))
    soft = replace(plate, allowances=(Allowance(0, ("all",), 0.01),))
    assert base_only(one_arm, *way, soft) == pytest.approx(0.96, abs=EXACT)
    hidden = replace(plate, hidden=np.array([True]))
    assert np.isnan(wb.sweep(one_arm, way, hidden)).all()


def test_allowance_beyond_the_radius_counts_the_depth_of_the_centre(one_arm, unit_box):
    deep = replace(unit_box, allowances=(Allowance(0, ("all",), 0.2),))
    way = (at(one_arm, 0.5, 0.5, 2), at(one_arm, 0.5, 0.5, 0))
    assert base_only(one_arm, *way, deep) == pytest.approx((2 - 0.85) / 2, abs=EXACT)
    shallow = (at(one_arm, -1, 0.5, 0.851), at(one_arm, 2, 0.5, 0.851))
    assert np.isnan(base_only(one_arm, *shallow, deep))


def test_answers_come_by_segment_part_and_sphere(one_arm, box_cab, random_arm):
    way = (random_arm(6, 1), random_arm(6, 2))
    full = wb.sweep(one_arm, way, box_cab, by="sphere and part")
    assert full.shape == (6, 10, 3)
    least = np.where(np.isnan(full), np.inf, full)
    owner = one_arm.sphere_segment
    parts = np.stack([least[:, owner == n].min(axis=1) for n in range(4)], axis=1)
    for by, wanted in (
        ("sphere", least.min(axis=2)),
        ("part", parts),
        ("segment", parts.min(axis=2)),
    ):
        found = wb.sweep(one_arm, way, box_cab, by=by)
        assert np.allclose(np.where(np.isnan(found), np.inf, found), wanted, rtol=0, atol=EXACT)


def test_what_lies_outside_the_window_has_no_time(bubbleman, plate):
    way = (at(bubbleman, 0, 0, 2), at(bubbleman, 0, 0, -1))
    found = wb.sweep(bubbleman, way, plate, window=["LF"])[0]
    assert np.isnan(found[bubbleman.segment("RF")])
    assert (
        found[bubbleman.segment("LF")]
        == wb.sweep(bubbleman, way, plate)[0, bubbleman.segment("LF")]
    )


def test_no_answer_depends_on_the_number_of_threads(one_arm, box_cab, random_arm):
    way = (random_arm(150, 3), random_arm(150, 4))
    one, two = (wb.sweep(one_arm, way, box_cab, by="part", threads=n) for n in (1, 3))
    assert np.array_equal(one, two, equal_nan=True)


def test_poses_that_do_not_belong_together_are_told(one_arm, two_spheres, plate):
    start = at(one_arm, 0, 0, 1)
    with pytest.raises(wb.InputError, match="same number of poses, got 1 and 2"):
        wb.sweep(one_arm, (start, wb.join_poses([start, start])), plate)
    with pytest.raises(wb.InputError, match="different reference segments"):
        wb.sweep(one_arm, (start, wb.pose(one_arm, {}, reference="HAND")), plate)
    with pytest.raises(wb.InputError, match="different bodies: 3 and 2 joints"):
        wb.sweep(one_arm, (start, at(two_spheres, 0, 0, 0)), plate)
    with pytest.raises(wb.UsageError, match=r"by='limb'.*valid: segment, part"):
        wb.sweep(one_arm, (start, start), plate, by="limb")
    with pytest.raises(wb.InputError, match="at: expected fractions from 0 to 1"):
        wb.between(start, start, 1.5)


@given(st.integers(0, 10**6))
def test_between_turns_at_a_constant_rate(random_arm, seed):
    start = random_arm(1, seed)
    end = random_arm(1, seed + 1)
    path = [wb.between(start, end, t).rotations[0] for t in np.linspace(0, 1, 6)]
    turned = [np.abs(np.sum(a * b, axis=-1)) for a, b in pairwise(path)]
    assert np.allclose(turned, turned[0], rtol=0, atol=1e-9)
    assert np.abs(np.sum(path[-1] * end.rotations[0], axis=-1)) == pytest.approx(1)
    assert wb.between(start, end, 1.0).world_from_reference == pytest.approx(
        end.world_from_reference, abs=1e-9
    )


@given(st.integers(0, 10**6))
def test_quaternions_of_matrices_are_those_they_came_from(seed):
    q = np.random.default_rng(seed).normal(size=(5, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    q[0] = [[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [1, 0, 0, 0]][seed % 4]
    back = from_matrices(matrices(q))
    assert np.allclose(np.abs(np.sum(back * q, axis=-1)), 1)
    assert np.all(back[..., 0] >= 0)


@given(st.integers(0, 10**6), st.floats(0, 1))
def test_a_sphere_on_the_way_is_where_the_pose_between_has_it(one_arm, random_arm, seed, time):
    start = random_arm(3, seed)
    end = random_arm(3, seed + 1)
    mover = pack_motion(one_arm, *frames_of(start, end))
    pair = np.repeat(np.arange(3), 10)
    sphere = np.tile(np.arange(10), 3)
    found = centres_at(mover, pair, sphere, np.full(30, time))
    wanted = wb.place(one_arm, wb.between(start, end, time)).centres
    # where a twist is about to jump, rounding decides the side
    safe = np.abs(joint_discontinuities(mover, pair, sphere) - time) > 1e-9
    assert np.allclose(found[safe], wanted.reshape(-1, 3)[safe], rtol=0, atol=1e-9)


def strays_beyond(body, way, seed):
    """By how much spheres leave the bound about their chord, on random intervals of random motions;
    <= 0 is right."""
    rng = np.random.default_rng(seed)
    mover = pack_motion(body, *frames_of(*way))
    count = 200
    pair = rng.integers(0, len(way[0]), count)
    sphere = rng.integers(0, len(body.sphere_names), count)
    ends = np.sort(rng.uniform(size=(2, count)), axis=0)
    ends[1] = ends[0] + (ends[1] - ends[0]) * 10.0 ** -rng.integers(0, 4, count)
    fraction = rng.uniform(size=count)
    jump = joint_discontinuities(mover, pair, sphere)
    keep = (jump < ends[0]) | (jump > ends[1])
    pair = pair[keep]
    sphere = sphere[keep]
    ends = ends[:, keep]
    fraction = fraction[keep]
    one, two = (centres_at(mover, pair, sphere, end) for end in ends)
    found = centres_at(mover, pair, sphere, ends[0] + fraction * (ends[1] - ends[0]))
    off = np.linalg.norm(found - (one + fraction[:, None] * (two - one)), axis=1)
    return off - ways(mover, pair, sphere, *ends)


@given(st.integers(0, 10**6), st.sampled_from([1.0, 0.3, 5.0]))
def test_no_sphere_strays_farther_from_its_chord_than_the_bound(one_arm, random_arm, seed, spread):
    way = (random_arm(20, seed, spread), random_arm(20, seed + 1, spread))
    assert np.max(strays_beyond(one_arm, way, seed)) < 1e-12


@given(st.integers(0, 10**6))
def test_the_bound_holds_from_any_reference_segment(one_arm, random_arm, seed):
    reference = seed % 4
    way = [
        wb.Poses(p.rotations, reference, p.world_from_reference)
        for p in (random_arm(9, seed), random_arm(9, seed + 1))
    ]
    assert np.max(strays_beyond(one_arm, way, seed)) < 1e-12


@pytest.fixture(scope="module")
def blended_arm(one_arm):
    """The one arm with every sphere but the base's blended across a joint, the lower arm's twist
    shared as well."""
    joint = np.array([-1, 0, 1, 1, 1, 2, 2, 2, 2, 2])
    share = np.array([0, 0.5, 0.2, 0.5, 0.7, 0.3, 0.5, 1.0, 0.4, 0.1])
    body = changed(one_arm, blend_joint=joint, blend_share=share)
    (centre,), (radius,) = enclosing_spheres(body)
    return changed(body, enclosing_centre=centre, enclosing_radius=radius)


@given(st.integers(0, 10**6), st.sampled_from([1.0, 5.0]))
def test_the_bound_holds_for_blended_spheres(blended_arm, random_arm, seed, spread):
    way = (random_arm(20, seed, spread), random_arm(20, seed + 1, spread))
    assert np.max(strays_beyond(blended_arm, way, seed)) < 1e-12


@given(st.integers(0, 10**6))
def test_first_contact_of_blended_spheres_equals_dense_sampling(
    blended_arm, random_arm, box_cab, seed
):
    way = (random_arm(1, seed), random_arm(1, seed + 1))
    oracles.check_sweep(
        blended_arm, way, box_cab, wb.sweep(blended_arm, way, box_cab, by="part")[0], steps=300
    )


@given(st.integers(0, 10**6))
def test_first_contact_equals_dense_sampling(one_arm, random_arm, box_cab, seed):
    way = (random_arm(1, seed), random_arm(1, seed + 1))
    oracles.check_sweep(
        one_arm, way, box_cab, wb.sweep(one_arm, way, box_cab, by="part")[0], steps=500
    )


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(200))
def test_first_contact_equals_dense_sampling_at_ten_thousand_steps(
    one_arm, random_arm, box_cab, seed
):
    way = (random_arm(1, seed, 2.0), random_arm(1, seed + 1000, 2.0))
    oracles.check_sweep(
        one_arm, way, box_cab, wb.sweep(one_arm, way, box_cab, by="part")[0], steps=10_000
    )


@given(st.integers(0, 10**6), st.floats(0.05, 0.95))
def test_a_way_in_two_pieces_gives_the_same_first_contact(one_arm, random_arm, box_cab, seed, cut):
    start = random_arm(4, seed, 0.2)
    end = random_arm(4, seed + 1, 0.2)
    middle = wb.between(start, end, cut)
    whole = wb.sweep(one_arm, (start, end), box_cab, by="part")
    first = wb.sweep(one_arm, (start, middle), box_cab, by="part") * cut
    second = cut + wb.sweep(one_arm, (middle, end), box_cab, by="part") * (1 - cut)
    joined = np.where(np.isnan(first), second, first)
    same = np.isclose(whole, joined, rtol=0, atol=1e-5) | (np.isnan(whole) & np.isnan(joined))
    # the wrist may pass half a turn of twist just where the way is cut
    assert same.mean() > 0.95


@given(st.integers(0, 10**6))
def test_first_contact_with_itself_and_another_equals_dense_sampling(one_arm, random_arm, seed):
    way = (random_arm(1, seed, 5.0), random_arm(1, seed + 1, 5.0))
    still = random_arm(1, seed + 2)
    other = wb.body_sweep((one_arm, *way), (one_arm, still, still), by="sphere")[0]
    own = wb.self_sweep(one_arm, way, by="sphere")[0]
    oracles.check_pair_sweep(one_arm, way, (other, still), own, steps=400)


def test_two_bodies_meet_at_the_same_time_whichever_comes_first(one_arm, two_spheres, random_arm):
    way = (random_arm(20, 1), random_arm(20, 2))
    ball = wb.join_poses(
        [at(two_spheres, *where) for where in wb.place(one_arm, way[1]).centres[:, 4]]
    )
    one = wb.body_sweep((one_arm, *way), (two_spheres, ball, ball))
    other = wb.body_sweep((two_spheres, ball, ball), (one_arm, *way))
    assert np.allclose(one, other.transpose(0, 2, 1), rtol=0, atol=EXACT, equal_nan=True)
    assert np.isfinite(one).any()


@pytest.mark.nightly
def test_the_kernels_of_continuous_contact_pass_with_the_compiler_off():
    chosen = (
        "dropped or pendulum or spinning or tunnels or graze or allowance or by_hand or half_turn"
    )
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-p",
        "no:cacheprovider",
        "-k",
        f"({chosen}) and not compiler",
        "tests/test_sweep.py",
        "tests/test_episodes.py",
    ]
    env = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:]
