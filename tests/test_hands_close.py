"""Hands that close: worked vectors of a finger, mirror law, ranges, bars that are too thick, and an oracle.

The oracle turns joints by small steps with matrices, and knows neither speeds nor the planes of fingers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from workbench.body.hands import (
    DIGITS,
    TOUCH,
    Hand,
    close_hand,
    close_on_cylinder,
    grasp,
    grasps,
    thickest_cylinder,
)
from workbench.errors import InputError

MAN = Hand(0.1941, 0.0904)
WOMAN = Hand(0.1807, 0.0795)
CLOSING = ["power", "hook", "wheel_rim", "tip_pinch", "three_finger", "lateral_pinch", "flat_press"]


def ball(middle, radius):
    """Distances to a ball."""

    def gap(points):
        return np.linalg.norm(points - middle, axis=1) - radius

    return gap


def nothing(points):
    return np.full(len(points), np.inf)


@pytest.mark.parametrize(
    ("bent", "tip"),
    [
        ((0, 0, 0), (182.45, 0.0)),
        ((40, 60, 40), (96.25, -70.77)),
        ((90, 100, 67), (55.91, -17.33)),
    ],
)
def test_the_index_finger_of_the_survey_has_its_tip_where_the_worked_vectors_have_it(bent, tip):
    angles = np.zeros((5, 5))
    angles[1, :3] = np.radians(bent)
    assert 1000 * MAN.joints(angles)[1, 3, [0, 2]] == pytest.approx(tip, abs=0.006)


def test_the_links_of_a_middle_finger_add_up_to_its_tip_as_it_was_measured_apart():
    tip = WOMAN.joints(np.zeros((5, 5)))[2, 3]
    assert 1000 * tip[0] == pytest.approx(178.4, abs=0.06)  # 78.1 + 49.7 + 25.1 + 25.5 mm


def test_length_and_breadth_of_a_hand_scale_apart_and_a_glove_adds_to_radii_alone():
    broad = Hand(0.1941, 0.0994, glove=0.003)
    flat = np.zeros((5, 5))
    assert np.array_equal(broad.joints(flat)[1:, :, 0], MAN.joints(flat)[1:, :, 0])
    assert broad.joints(flat)[1:, 0, 1] == pytest.approx(1.0995575 * MAN.joints(flat)[1:, 0, 1])
    assert broad.radius - 0.003 == pytest.approx(1.0995575 * MAN.radius)


def test_the_last_sphere_of_each_digit_ends_at_its_tip():
    angles = grasp("tip_pinch").begin
    joints = MAN.joints(angles)
    last = MAN.centres(angles)[:40].reshape(5, 8, 3)[:, 7]
    radius = MAN.radius[:40].reshape(5, 8)[:, 7]
    assert np.linalg.norm(joints[:, 3] - last, axis=1) == pytest.approx(radius)


@pytest.mark.parametrize("name", CLOSING)
def test_a_left_hand_is_the_mirror_image_of_a_right_one(name):
    middle = np.array([0.10, 0.02, -0.05])
    right = close_hand(MAN, grasp(name), ball(middle, 0.02))
    left = close_hand(
        Hand(0.1941, 0.0904, side="left"), grasp(name), ball(middle * (1, -1, 1), 0.02)
    )
    assert np.abs(right.centres * (1, -1, 1) - left.centres).max() < 1e-12
    assert np.abs(right.gap - left.gap).max() < 1e-12


def limits(found):
    """How much [rad] angles of fingers are within their ranges and what ties them to each other."""
    deg = np.radians(1.0)
    knuckle, middle, last = found.angles[1:, 0], found.angles[1:, 1], found.angles[1:, 2]
    room = [knuckle + 30 * deg, 90 * deg - knuckle, middle + 5 * deg, 110 * deg - middle]
    room += [last + 10 * deg, 80 * deg - last]
    room += [15 * deg - np.abs(last - 0.67 * middle)]
    room += [np.radians([30, 25, 30]) - np.abs(np.diff(knuckle))]
    room += [np.radians([45, 35, 45]) - np.abs(np.diff(middle))]
    return np.concatenate(room)


@settings(max_examples=25, deadline=None)
@given(
    name=st.sampled_from(CLOSING),
    at=st.tuples(st.floats(0.05, 0.16), st.floats(-0.06, 0.08), st.floats(-0.1, 0.0)),
    size=st.floats(0.004, 0.05),
    share=st.floats(0.5, 1.1),
)
def test_fingers_stay_in_their_ranges_and_go_no_deeper_into_anything(name, at, size, share):
    hand = Hand(0.1941 * share, 0.0904 * share)
    gap = ball(np.array(at) * share, size)
    found = close_hand(hand, grasp(name), gap)
    assert limits(found).min() > -1e-9
    closed = (gap(found.centres) - hand.radius)[:40].reshape(5, 8).min(axis=1)
    open_ = (gap(hand.centres(grasp(name).begin)) - hand.radius)[:40].reshape(5, 8).min(axis=1)
    for digits in (slice(0, 1), slice(1, 5)):
        assert closed[digits].min() >= min(open_[digits].min(), 0.0) - 2e-4
    assert np.array_equal(found.touching, closed <= 2 * TOUCH)


@pytest.mark.parametrize("hand", [MAN, WOMAN, Hand(0.1941, 0.0904, 0.003, "left")])
@pytest.mark.parametrize("diameter", [0.02, 0.035, 0.05, 0.07])
def test_four_fingers_touch_a_bar_within_a_fifth_of_a_millimetre_and_none_enters_it(hand, diameter):
    found = close_on_cylinder(hand, diameter)
    assert found.touching[1:].all() and found.gap[1:].max() < 2e-4
    assert found.depth < 2e-4 and found.gap.min() > -2e-4


def test_the_thumb_closes_around_a_thick_bar_and_lies_on_the_fingers_around_a_thin_one():
    assert close_on_cylinder(MAN, 0.05).touching[0]
    thin = close_on_cylinder(MAN, 0.02)
    own = thin.centres[:40].reshape(5, 8, 3)
    size = MAN.radius[:40].reshape(5, 8)
    apart = np.linalg.norm(own[0, :, None, None] - own[1:], axis=-1) - size[1:]
    assert not thin.touching[0]
    assert 0.0 <= (apart.min(axis=(1, 2)) - size[0])[4:].min() < 2e-4


@pytest.mark.parametrize("hand", [MAN, WOMAN])
def test_a_bar_that_is_too_thick_is_refused_with_the_diameter_that_would_do(hand):
    most = 1000 * thickest_cylinder(hand)
    with pytest.raises(InputError, match=rf"150 mm is too thick .*; {int(most)} mm at most"):
        close_on_cylinder(hand, 0.150)
    assert close_on_cylinder(hand, int(most) / 1000).depth < 2e-4


def test_a_longer_hand_reaches_around_a_thicker_bar():
    assert thickest_cylinder(MAN) > thickest_cylinder(WOMAN) > 0.05


def test_all_grasps_are_within_the_ranges_and_close_on_nothing_to_their_ends():
    assert set(grasps()) >= {*CLOSING, "fingertip_push", "thumb_push"}
    for name in grasps():
        found = close_hand(MAN, grasp(name), nothing)
        assert limits(replace(found, angles=grasp(name).begin)).min() > -1e-9
        assert limits(found).min() > -1e-9
        assert not found.touching.any() and np.isinf(found.gap).all() and found.depth == 0.0
        still = np.all(grasp(name).begin == grasp(name).end, axis=1)
        assert np.array_equal(found.angles[still], grasp(name).begin[still])
        assert np.linalg.norm(grasp(name).way) == pytest.approx(1.0)
        assert grasp(name).meets.sum() == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ((1.9, 0.09), r"hand_length 1900 mm is not a person's \(65 to 330 mm is\)"),
        ((0.19, 0.5), "hand_breadth 500 mm is not a person's"),
        ((0.19, 0.09, -0.001), "hand.glove: expected 0 to 20 mm, got -1 mm"),
        ((float("nan"), 0.09), "hand_length nan mm is not a person's"),
        ((0.19, 0.09, 0.0, "up"), "hand.side: expected 'left' or 'right', got 'up'"),
    ],
)
def test_a_hand_that_nobody_has_is_refused(size, words):
    with pytest.raises(InputError, match=words):
        Hand(*size)


def test_an_unknown_grasp_and_a_bar_of_no_thickness_are_refused():
    with pytest.raises(InputError, match=r"no grasp 'fist'; .*power"):
        grasp("fist")
    with pytest.raises(InputError, match="diameter: expected 0 to 1 m, got 0"):
        close_on_cylinder(MAN, 0.0)


def test_a_grasp_beyond_the_ranges_is_refused():
    begin = np.array(grasp("power").begin)
    begin[2, 0] = np.radians(-40)
    with pytest.raises(InputError, match="middle, angle 1: expected -30 to 90 degrees, got -40"):
        close_hand(MAN, replace(grasp("power"), begin=begin), nothing)


def slow_points(hand, digit, bent, sideways):
    """(8, 3) [m] the spheres of a finger, by rotations one after the other."""
    side = {"index": 1, "middle": 1, "ring": -1, "little": -1}[DIGITS[digit]]
    less = max(0.0, 1.0 - bent[0] / (np.pi / 2))
    turn = Rotation.from_euler("z", side * sideways * less)
    joints = [hand.joints(np.zeros((5, 5)))[digit, 0]]
    flat = hand.joints(np.zeros((5, 5)))[digit]
    for link, angle in enumerate(bent):
        turn = turn * Rotation.from_euler("y", angle)
        joints.append(joints[-1] + turn.apply([np.linalg.norm(flat[link + 1] - flat[link]), 0, 0]))
    straight = hand.centres(np.zeros((5, 5)))[:40].reshape(5, 8, 3)[digit]
    at = np.array([0, 0, 0, 1, 1, 2, 2, 2])
    share = [
        (s - flat[k])[0] / (flat[k + 1] - flat[k])[0] for s, k in zip(straight, at, strict=True)
    ]
    return np.array(
        [joints[k] + t * (joints[k + 1] - joints[k]) for k, t in zip(at, share, strict=True)]
    )


@pytest.mark.nightly
@pytest.mark.parametrize("digit", [1, 2, 3, 4])
@pytest.mark.parametrize("size", [0.012, 0.02])
def test_a_finger_closes_to_where_small_steps_bring_it(digit, size):
    hand, chosen = MAN, grasp("hook")
    middle = hand.joints(chosen.begin)[digit, 1] - (0.0, 0.0, size + 0.013)
    gap = ball(middle, size)
    bent, sideways = np.array(chosen.begin[digit, :3]), chosen.begin[digit, 3]
    radius = hand.radius[:40].reshape(5, 8)[digit]
    step = np.radians(0.01)
    for joint, rate, end in ((1, [0, 1, 0.67], 110), (2, [0, 0, 1], None)):
        most = np.radians(end) if end else min(np.radians(80), 0.67 * bent[1] + np.radians(15))
        while bent[joint] + step <= most:
            there = bent + step * np.array(rate)
            own = slow_points(hand, digit, there, sideways)
            if (gap(own) - radius)[3 if joint == 1 else 5 :].min() < 0.5 * TOUCH:
                break
            bent = there
    found = close_hand(hand, chosen, gap).angles[digit, :3]
    assert np.degrees(found) == pytest.approx(np.degrees(bent), abs=0.2)
