"""Joint stops: the numbers of the sources, margins against a dense oracle, nearest legal
rotations."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import REFERENCE, real_input
from workbench.model.joint_angles import angles_of, compose
from workbench.model.reach import stop_reason
from workbench.posture.stops import nearest_legal, nearest_on_cone, nearest_on_polygon


def margin(body, joint, **angles):
    found = wb.stops(body, wb.pose(body, {joint: angles}))
    return np.degrees(found.margin)[0, body.joint(joint)]


def test_hip_flexion_80_with_abduction_40_is_illegal_and_with_30_legal(one_arm):
    # (80/113)^2 + (40/53)^2 = 1.0708, (80/113)^2 + (30/53)^2 = 0.8216
    assert margin(one_arm, "SHOULDER", flexion=80, abduction=40) < 0
    assert margin(one_arm, "SHOULDER", flexion=80, abduction=30) > 0


@pytest.mark.parametrize(
    ("motion", "limit"),
    [
        ("flexion", 113),
        ("extension", 20),
        ("abduction", 53),
        ("adduction", 31),
        ("medial_rotation", 39),
    ],
)
def test_margin_along_an_axis_is_limit_minus_angle(one_arm, motion, limit):
    assert margin(one_arm, "SHOULDER", **{motion: limit - 3}) == pytest.approx(3, abs=0.2)
    assert margin(one_arm, "SHOULDER", **{motion: limit}) == pytest.approx(0, abs=1e-9)
    assert margin(one_arm, "SHOULDER", **{motion: limit + 5}) == pytest.approx(-5, abs=1e-9)


def test_neutral_joint_margin_is_the_nearest_stop(one_arm):
    found = wb.stops(one_arm, wb.pose(one_arm, {}))
    assert np.degrees(found.margin)[0, 0] == pytest.approx(20)
    assert found.motion(0, 0) == "extension"


def test_free_joints_have_no_margin(one_arm):
    assert margin(one_arm, "WRIST", flexion=170) == np.inf


def test_a_hinge_has_play_beside_its_axis(one_arm):
    assert margin(one_arm, "ELBOW", flexion=60, abduction=1.5) == pytest.approx(60)
    assert margin(one_arm, "ELBOW", flexion=60, abduction=3) == pytest.approx(-1)
    assert margin(one_arm, "ELBOW", flexion=150) == pytest.approx(-8)


def test_a_coupled_limit_grows_with_its_driver(one_arm):
    # medial rotation: 0 at 0 degrees of flexion, 35 at 90, and 2 of play
    assert margin(one_arm, "ELBOW", flexion=45, medial_rotation=17.5) == pytest.approx(2)
    assert margin(one_arm, "ELBOW", flexion=90, medial_rotation=40) == pytest.approx(-3)


@given(
    st.tuples(st.floats(-3, 3), st.floats(-3, 3)),
    st.lists(st.floats(0.1, 2.5), min_size=4, max_size=4),
)
def test_cone_distance_equals_a_dense_search(swing, limits):
    swing = np.array([swing])
    limits = np.array(limits).reshape(1, 2, 2)
    _, distance, _ = nearest_on_cone(swing, limits)
    t = np.linspace(0, 2 * np.pi, 40001)
    unit = np.stack([np.cos(t), np.sin(t)], axis=1)
    curve = unit * np.where(unit >= 0, limits[0, :, 0], limits[0, :, 1])
    assert abs(distance[0]) == pytest.approx(
        np.linalg.norm(curve - swing[0], axis=1).min(), abs=2e-4
    )


@given(st.integers(0, 10**6))
def test_nearest_legal_rotations_are_legal_and_legal_ones_stay(bubbleman, seed):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(4, len(bubbleman.joints), 4)) * [0.4, 1, 1, 1]
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    poses = wb.Poses(q, 0, np.broadcast_to(np.eye(3, 4), (4, 3, 4)))
    first = wb.stops(bubbleman, poses)
    single = [
        j
        for j in range(len(bubbleman.joints))
        if not any(c.driver_joint == j or c.joint == j for c in bubbleman.stops.couplings)
    ]
    legalised = q.copy()
    legalised[:, single] = first.nearest[:, single]
    again = wb.stops(bubbleman, wb.Poses(legalised, 0, poses.world_from_reference))
    assert np.all(np.degrees(again.margin)[:, single] > -0.01)
    legal = first.margin >= 0
    assert (first.nearest[legal] == poses.rotations[legal]).all()


def arm_margin(body, direction):
    """Polygon margin with the right arm's long axis along a direction in the upper torso's
    frame."""
    from workbench.model.quaternions import shortest

    q = np.tile([1.0, 0, 0, 0], (1, len(body.joints), 1))
    toward = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    q[0, body.joint("RS")] = shortest(np.array([0, 0, -1.0]), toward)
    return np.degrees(
        wb.stops(body, wb.Poses(q, 0, np.eye(3, 4)[None])).margin[0, body.joint("RS")]
    )


def sagittal(a):
    return [np.sin(np.radians(a)), 0, -np.cos(np.radians(a))]


def frontal(a):
    return [0, -np.sin(np.radians(a)), -np.cos(np.radians(a))]


def limb_is_legal(body, direction):
    j = body.joint("RS")
    toward = np.asarray(direction, dtype=float)[None] / np.linalg.norm(direction)
    return (
        nearest_on_polygon(toward, body.stops.polygon[j], body.stops.polygon_centre[j])[1][0]
        >= -5e-4
    )


def test_the_shoulder_reaches_what_the_swept_check_of_its_polygon_says(bubbleman):
    assert all(limb_is_legal(bubbleman, sagittal(a)) for a in range(-60, 181, 5))
    assert all(limb_is_legal(bubbleman, frontal(a)) for a in range(-25, 181, 5))
    assert not limb_is_legal(bubbleman, frontal(-50))
    # the written summary says -45; the polygon's own vertices give 85 degrees at clock 270, which
    # is -38
    level = [[np.cos(np.radians(a)), -np.sin(np.radians(a)), 0] for a in range(-35, 126, 5)]
    assert all(limb_is_legal(bubbleman, d) for d in level)


def test_the_legal_share_of_the_shoulder_sphere_is_58_percent(bubbleman):
    height = (np.arange(2000) + 0.5) / 1000 - 1  # a spiral with equal areas between its points
    turn = np.pi * (1 + np.sqrt(5)) * np.arange(2000)
    ring = np.sqrt(1 - height**2)
    unit = np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])
    j = bubbleman.joint("RS")
    _, angle = nearest_on_polygon(
        unit, bubbleman.stops.polygon[j], bubbleman.stops.polygon_centre[j]
    )
    assert np.mean(angle >= 0) == pytest.approx(0.58, abs=0.015)


def test_left_and_right_stops_are_mirror_images(bubbleman):
    for side, other in (("L", "R"), ("R", "L")):
        angles = {
            f"{side}S": {"flexion": 50, "abduction": 30},
            f"{side}H": {"flexion": 60, "abduction": 20},
            f"{side}W": {"flexion": 20, "pronation": 30},
        }
        mirrored = {other + name[1:]: value for name, value in angles.items()}
        one, two = (
            np.degrees(wb.stops(bubbleman, wb.pose(bubbleman, a)).margin[0])
            for a in (angles, mirrored)
        )
        for name in angles:
            assert one[bubbleman.joint(name)] == pytest.approx(
                two[bubbleman.joint(other + name[1:])], abs=1e-6
            )


def test_angles_come_back_from_rotations(bubbleman):
    pose = wb.pose(bubbleman, {"LH": {"flexion": 70, "abduction": 20, "medial_rotation": 15}})
    back = np.degrees(angles_of(bubbleman, pose))[0, bubbleman.joint("LH")]
    assert back == pytest.approx([70, 20, 15], abs=1e-9)


def test_bubblemans_limits_are_those_of_the_reference_table(bubbleman):
    path = real_input(REFERENCE / "joint_stops.csv")
    columns = [
        "flex",
        "extend",
        "abduct_or_radial",
        "adduct_or_ulnar",
        "twist_medial_or_pronate",
        "twist_lateral_or_supinate",
    ]
    for row in csv.DictReader(path.read_text().splitlines()):
        for name in row["joint"].split("/") if row["kind"] != "free" else []:
            limits = np.degrees(bubbleman.stops.limits[bubbleman.joint(name)]).ravel()
            table = [float(row[c]) for c in columns]
            if name in ("LC", "RC"):  # the axial turn is named the other way round
                table[4:] = table[:3:-1]
            if name in ("LH", "RH"):  # coupled: 113 with the knee straight, 127 bent
                assert (limits[0], table[0]) == pytest.approx((127, 113))
                table[0] = 127.0
            assert limits == pytest.approx(table, abs=1e-9), name


def test_nearest_legal_rotations_alone_are_those_told_with_the_margins(bubbleman):
    rng = np.random.default_rng(5)
    rotations = compose(bubbleman, rng.uniform(-1.5, 1.5, (60, len(bubbleman.joints), 3)))
    poses = wb.Poses(rotations, 0, np.tile(np.eye(3, 4), (60, 1, 1)))
    assert np.array_equal(nearest_legal(bubbleman, poses), wb.stops(bubbleman, poses).nearest)


def test_a_shoulder_at_its_stop_is_told_in_words_that_need_no_anatomy():
    body = wb.load_body("adult_male")
    joint = body.joint("RC")
    pairs = body.stops.motions[joint]
    axis = next(k for k, pair in enumerate(pairs) if "protraction" in pair)
    found = stop_reason(body, (joint, axis, pairs[axis].index("protraction")))
    assert found.text == (
        "right clavicular joint (protraction: the shoulder is as far forward as it goes)"
    )
    elbow = body.joint("RE")
    assert stop_reason(body, (elbow, 0, 0)).text.startswith("right elbow (")
    assert ":" not in stop_reason(body, (elbow, 0, 0)).text
