"""Strength of hands, feet and grips: worked vectors, mirror laws and what is out of the tables.

Vectors are of a fact sheet on strain: of the Arm Force Field's net, its full example (mass 73.5 kg,
points left, up, forward), isometric moments of legs (g = 9.81 m/s2) and grip norms in kgf.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

import workbench as wb
from workbench.errors import InputError
from workbench.files.study.rules import load_rule_set
from workbench.strain.arm_strength import arm_net
from workbench.strain.leg_strength import AGES, joint_moments, largest_push

FIELD = load_rule_set("strain_arm_force_field")
LEGS = load_rule_set("strain_leg_strength")
GRIP = load_rule_set("strain_grip")


@pytest.fixture(scope="module")
def man():
    return wb.load_body("bubbleman")


@pytest.mark.parametrize(
    ("hand", "forces"),
    [  # up, down, push, pull, outward, inward
        ((-0.2, 0.4, 0.0), (118.5241, 96.6384, 161.7962, 180.5123, 58.4880, 93.1682)),
        ((0.0, 0.45, 0.0), (79.4010, 84.4895, 135.6876, 155.6286, 53.1, 77.0543)),
        ((0.2, 0.3, 0.2), (97.4544, 110.2365, 75.9204, 94.3853, 67.8098, 82.5453)),
        ((-0.3, 0.3, 0.3), (96.0495, 79.3645, 69.7951, 100.3374, 62.4268, 93.1872)),
    ],
)
def test_the_net_gives_the_strength_of_worked_vectors(hand, forces):
    ways = np.array([sign * axis for axis in np.eye(3) for sign in (1, -1)])
    found = arm_net(np.tile(hand, (6, 1)), ways, FIELD)
    np.testing.assert_allclose(found, forces, atol=5.1e-5)


def example(side):
    """An arm of the authors' example, with the axes turned to forward, left, up."""
    points = {
        "left": [(0.09191, 1.30461, -0.06136), (0.191, 1.11068, 0.09171),
                 (0.2617, 0.96619, 0.23538), (0.29034, 0.91934, 0.29134)],
        "right": [(-0.21538, 1.32291, -0.06481), (-0.42676, 1.28636, 0.0928),
                  (-0.36905, 1.20173, 0.2826), (-0.37368, 1.20097, 0.360862)],
        "spine": [(-0.06385, 1.35457, -0.06182), (-0.063, 0.95253, -0.07984)],
    }  # fmt: skip
    other = "right" if side == "left" else "left"
    rows = [*points[side], points[other][0], *points["spine"]]
    turned = [np.array([(forward, left, up)]) for left, up, forward in rows]
    return wb.Arms(side, *turned, mass=np.array([73.5]))


@pytest.mark.parametrize(
    ("side", "strong", "share"),
    [("right", 61.83646134080713, 86.8986571708246), ("left", 78.5881047818177, 94.96051991382123)],
)
def test_the_authors_example_has_their_strength_and_a_left_arm_with_mirrored_gravity(
    side, strong, share
):
    found = wb.hand_strength(example(side), (0, 0, 1), male=False)
    assert found.strength(0.75) == pytest.approx([strong], abs=1e-9)
    assert 100 * found.capable(50.0) == pytest.approx([share], abs=1e-9)
    assert found.capable(found.strength(0.75)) == pytest.approx([0.75])


def test_men_are_stronger_by_the_stated_multiple_and_every_figure_carries_the_credit():
    women, men = (
        wb.hand_strength(example("right"), (1, 0, 0), male=male) for male in (False, True)
    )
    np.testing.assert_allclose(men.mean, 1.66 * women.mean)
    assert np.array_equal(men.gravity, women.gravity)
    assert "copyright N. La Delfa and J. Potvin 2025, CC BY 4.0" in women.status
    assert "men: seen in a comment in another public program" in women.status


@settings(max_examples=15, deadline=None)
@given(
    way=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda way: np.linalg.norm(way) > 0.1),
    angles=st.tuples(*[st.floats(-60, 90)] * 3),
)
def test_a_mirrored_person_has_the_same_strength_in_the_mirrored_direction(man, way, angles):
    flexion, abduction, elbow = angles
    strengths = []
    for side, sign in (("right", 1), ("left", -1)):
        joint = side[0].upper()
        turned = {f"{joint}S": {"flexion": flexion, "abduction": abduction}}
        turned |= {f"{joint}E": {"flexion": abs(elbow)}}
        arm = wb.arms_of(wb.place(man, wb.pose(man, turned)), side)
        direction = np.array(way) * [1, sign, 1]
        strengths.append(wb.hand_strength(arm, direction, male=False))
    one, other = strengths
    np.testing.assert_allclose(one.mean, other.mean, rtol=1e-6)
    np.testing.assert_allclose(one.gravity, other.gravity, atol=1e-6)
    assert one.extrapolated.tolist() == other.extrapolated.tolist()


def test_turning_the_whole_person_about_the_plumb_line_changes_no_strength(man):
    angles = {"RS": {"flexion": 50}, "RE": {"flexion": 60}, "LH": {"flexion": 80}}
    turn = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
    here = wb.place(man, wb.pose(man, angles))
    there = wb.place(man, wb.pose(man, angles, position=(3, 4, 5), attitude=turn))
    way = np.array([0.5, 0.3, -0.4])
    hands = [
        wb.hand_strength(wb.arms_of(placed, "right"), direction, male=True).strength(0.95)
        for placed, direction in ((here, way), (there, turn @ way))
    ]
    feet = [
        wb.foot_strength(placed, "left", direction, male=True, stature=1.75, ages="55-65").mean
        for placed, direction in ((here, way), (there, turn @ way))
    ]
    assert hands[0] == pytest.approx(hands[1]) and feet[0] == pytest.approx(feet[1])


def test_a_hand_outside_the_places_of_the_measured_people_is_marked(man):
    arms = wb.arms_of(wb.place(man, wb.pose(man, {})), "right")
    near = arms.shoulder + np.array([0.3, -0.1, 0.0])
    overhead = arms.shoulder + np.array([0.2, 0.0, 0.6])
    found = [
        wb.hand_strength(replace(arms, hand=at), (1, 0, 0), male=True) for at in (near, overhead)
    ]
    assert [one.extrapolated.tolist() for one in found] == [[False], [True]]


def test_the_weight_of_a_level_arm_helps_down_as_much_as_it_hinders_up(man):
    level = wb.arms_of(wb.place(man, wb.pose(man, {"RS": {"flexion": 90}})), "right")
    up, down = (wb.hand_strength(level, (0, 0, way), male=True).gravity for way in (1, -1))
    assert down > 0.0 and down == pytest.approx(-up)
    # shares of the body's mass at shares of the links, over the whole reach
    shoulder, elbow, wrist, hand = (
        getattr(level, name)[0, 0] for name in ("shoulder", "elbow", "wrist", "hand")
    )
    centres = (0.436 * (elbow - shoulder), elbow - shoulder + 0.43 * (wrist - elbow))
    centres += (wrist - shoulder + 0.74 * (hand - wrist),)
    moment = 9.81 * level.mass[0] * np.dot((0.028, 0.017, 0.006), centres)
    reach = np.linalg.norm(level.hand - level.shoulder)
    assert down == pytest.approx(moment / reach, rel=0.05)


@pytest.mark.parametrize(
    ("joint", "sense", "male", "ages", "degrees", "mass", "stature", "moment"),
    [
        ("knee", "extension", True, "18-25", 65, 75, 1.75, 209.9),
        ("knee", "extension", True, "18-25", 90, 75, 1.75, 178.8),
        ("knee", "extension", True, "18-25", 20, 75, 1.75, 115.8),
        ("knee", "extension", False, "18-25", 65, 62, 1.63, 155.5),
        ("knee", "extension", False, "65+", 65, 62, 1.63, 122.9),
        ("hip", "extension", True, "18-25", 90, 75, 1.75, 169.7),
        ("hip", "flexion", True, "18-25", 90, 75, 1.75, 36.5),
        ("hip", "flexion", True, "18-25", 115, 75, 1.75, 0.0),  # past 110 the curve is below zero
        ("ankle", "extension", True, "18-25", 0, 75, 1.75, 103.1),
        ("ankle", "flexion", True, "18-25", 0, 75, 1.75, 40.8),
        ("knee", "flexion", True, "18-25", 90, 75, 1.75, 68.6),
    ],
)
def test_joints_of_legs_have_the_moments_of_worked_vectors(
    joint, sense, male, ages, degrees, mass, stature, moment
):
    angles = np.full((1, 3), np.radians(degrees))
    row = np.array([3 * int(male) + AGES.index(ages)])
    found, share = joint_moments(angles, row, np.array([mass * stature]), rules=LEGS)
    at = ("hip", "knee", "ankle").index(joint), ("flexion", "extension").index(sense)
    assert found[0, at[0], at[1]] == pytest.approx(moment, abs=0.051)
    if (joint, sense, male, ages) == ("hip", "extension", True, "18-25"):
        assert share[0, 0, 1] == pytest.approx(0.30, abs=0.005)


def test_the_force_on_a_pedal_is_the_least_that_a_joint_bears_at_its_lever(man):
    sits = wb.place(man, wb.pose(man, {"RH": {"flexion": 90}, "RK": {"flexion": 90}}))
    hip, knee, ankle = (
        sits.world_from_segment[0, s, :, :3] @ man.joint_in_child[0, s - 1]
        + sits.world_from_segment[0, s, :, 3]
        for s in (man.segment(name) for name in ("RUL", "RLL", "RF"))
    )
    foot = ankle + np.array([0.10, 0.0, -0.05])
    found = wb.foot_strength(
        sits, "right", (1, 0, 0), male=True, stature=1.75, ages="18-25", foot=foot
    )
    # pushed level forward each joint has the height of the joint over the foot as its lever
    size = np.array([man.mass[0].sum() * 1.75])
    bent = np.radians([[90.0, 90.0, 0.0]])
    moment, _ = joint_moments(bent, np.array([3]), size, rules=LEGS)
    levers = np.array([hip[2], knee[2], ankle[2]]) - foot[2]
    # over it: the knee extends, hip and ankle flex against the reaction
    needed = moment[0, [0, 1, 2], [0, 1, 0]] / levers
    np.testing.assert_allclose(-found.levers[0, 1, 0], levers[1], rtol=1e-6)
    assert found.mean == pytest.approx([needed.min()], rel=1e-6)
    assert found.limits == ("hip flexion",) and found.capable(found.mean) == pytest.approx([0.5])
    toward = foot - hip
    pressed = wb.foot_strength(
        sits, "right", toward, male=True, stature=1.75, ages="18-25", foot=foot
    )
    assert abs(pressed.levers[0, 0, 0]) < 1e-9 and pressed.limits == ("knee extension",)
    # a pedal that bears what presses across its way is pushed along the leg, with the same moments
    leaning = wb.foot_strength(
        sits, "right", (1, 0, 0), male=True, stature=1.75, ages="18-25", foot=foot, lean=1.3
    )
    assert leaning.mean[0] > 1.5 * found.mean[0]
    assert leaning.capable(leaning.strength(0.9)) == pytest.approx([0.9])
    assert "its weight neither helps nor hinders (assumed)" in found.assumed[0]


@settings(max_examples=40, deadline=None)
@given(
    levers=st.lists(st.floats(-0.5, 0.5), min_size=6, max_size=6),
    moments=st.lists(st.floats(5.0, 300.0), min_size=6, max_size=6),
    lean=st.floats(0.0, 1.2),
)
def test_the_largest_push_that_may_lean_is_that_of_a_linear_programme(levers, moments, lean):
    way, across = np.reshape(levers, (3, 2)).T
    flexion, extension = np.reshape(moments, (3, 2)).T
    loads = np.column_stack([way, across])
    rows = np.vstack([loads, -loads, [[-np.tan(lean), 1.0], [-np.tan(lean), -1.0]]])
    limits = np.concatenate([flexion, extension, [0.0, 0.0]])
    best = linprog([-1.0, 0.0], rows, limits, bounds=[(0.0, 1e7), (None, None)])
    found, _ = largest_push(
        np.reshape(levers, (1, 3, 2)), np.stack([flexion, extension], axis=1)[None], lean
    )
    assert min(found[0], 1e7) == pytest.approx(-best.fun, rel=1e-6)


def test_hips_that_are_bent_too_far_for_the_curve_are_marked(man):
    bent = wb.place(man, wb.pose(man, {"RH": {"flexion": 112}, "RK": {"flexion": 90}}))
    lifting = wb.foot_strength(bent, "right", (0, 0, 1), male=True, stature=1.75, ages="18-25")
    assert lifting.limits == ("hip flexion",) and lifting.beyond.tolist() == [True]
    assert lifting.mean == pytest.approx([0.0]) and lifting.capable(10.0) == pytest.approx([0.0])


def test_grip_norms_have_their_checksum_and_percentiles():
    newton = 9.80665
    middle = GRIP["female"][:, 5].sum() + GRIP["male"][:, 5].sum()
    assert middle / newton == pytest.approx(809.7)
    men, women = (wb.grip_strength([32, 32], male=male) for male in (True, False))
    for found, kgf in ((men, (35.0, 49.7, 64.9)), (women, (19.6, 29.7, 40.4))):
        for share, value in zip((0.95, 0.5, 0.05), kgf, strict=True):
            assert found.strength(share) / newton == pytest.approx([value, value])
            assert found.capable(newton * value) == pytest.approx([share, share])
    assert women.strength(0.95) == pytest.approx([192, 192], abs=0.5)


@given(age=st.integers(20, 74), male=st.booleans(), force=st.floats(10, 900))
def test_the_share_that_grips_is_the_inverse_of_the_force_of_that_share(age, male, force):
    found = wb.grip_strength(age, male=male, rules=GRIP)
    share = found.capable(force).item()
    if 1e-6 < share < 1 - 1e-6:
        assert found.strength(share) == pytest.approx([force], rel=1e-6)
    assert found.capable(force + 1.0).item() <= share


@pytest.mark.parametrize("age", [19.9, 75, -1])
def test_an_age_out_of_the_table_is_refused(age):
    with pytest.raises(InputError, match="the table has 20 to 74 years of age"):
        wb.grip_strength([30, age], male=True)


def test_forces_without_direction_and_people_of_no_height_are_refused(man):
    placed = wb.place(man, wb.pose(man, {}))
    legs = {"male": True, "ages": "18-25"}
    with pytest.raises(InputError, match="a force needs a direction"):
        wb.hand_strength(wb.arms_of(placed, "left"), (0, 0, 0), male=True)
    with pytest.raises(InputError, match="a force needs a direction"):
        wb.foot_strength(placed, "left", (0, 0, 0), stature=1.7, **legs)
    with pytest.raises(InputError, match="stature: expected more than 0 m"):
        wb.foot_strength(placed, "left", (1, 0, 0), stature=0.0, **legs)
    with pytest.raises(wb.UsageError, match="ages: expected"):
        wb.foot_strength(placed, "left", (1, 0, 0), stature=1.7, male=True, ages="30-40")


@pytest.mark.nightly
def test_twenty_five_controls_of_six_thousand_people_take_less_than_five_seconds():
    arms = example("right")
    fields = ("shoulder", "elbow", "wrist", "hand", "other_shoulder", "neck", "low_back")
    many = {name: np.repeat(getattr(arms, name), 6068, axis=0) for name in fields}
    crowd = wb.Arms("right", **many, mass=np.full(6068, 73.5))
    started = time.process_time()
    for control in range(25):
        found = wb.hand_strength(crowd, (1.0, 0.1 * control, 0.0), male=np.arange(6068) % 2 == 0)
        assert 0.0 < found.capable(100.0).mean() < 1.0
    assert time.process_time() - started < 5.0
