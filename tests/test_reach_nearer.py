"""What a limb misses by an obstacle is told as near as is found: no miss contradicts that of a
target near by, nor what an independent search finds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import box_part, environment_of, real_input
from tests.reach_law import (
    GRIPS,
    GROB,
    asked,
    broken_law,
    controls_of,
    longer_than_searched,
    missed_by_obstacle,
    searcher,
    seats_in,
    short,
    targets_near_parts,
)
from tests.reach_truth import MESHES

LEGS = {"LH": {"flexion": 80}, "RH": {"flexion": 80}, "LK": {"flexion": 70}, "RK": {"flexion": 70}}
MIDDLE = np.array([0.45, -0.15, 0.75])
"""[m] In front of the right shoulder of a seated man."""
PRECISE = 1e-3
"""[m] How precise misses are said to be."""
ROUGH = 0.1
"""Most of the misses of targets all about parts that may contradict a target near by."""
LOCAL = 5e-3
"""[m] By how much an independent search may come nearer: measured, once 3.1 mm in 19."""
PEOPLE = {"trainer": 6, "compact_car": 6, "console": 20, "ranger": 4, "hybrid": 4, "grob": 3}


@pytest.fixture(scope="module")
def seated(bubbleman):
    return wb.pose(bubbleman, LEGS, reference="LT", position=(0.1, 0.0, 0.4))


@pytest.fixture(scope="module")
def shelf():
    """A box of 300 mm that is open to nobody, below a shelf."""
    return environment_of(
        box_part("box", MIDDLE - [0.1, 0.15, 0.15], MIDDLE - [-0.2, -0.15, -0.15]),
        box_part("shelf", MIDDLE - [0.15, 0.4, -0.25], MIDDLE - [-0.3, -0.4, -0.27]),
    )


def right_hand(body, poses, targets, environment, **options):
    arm = wb.limb(body, "right hand", grip="push", zone=1)
    return wb.reach(body, poses, targets, limb=arm, environment=environment, **options)


@settings(max_examples=6)
@given(
    inside=st.tuples(*[st.floats(-0.08, 0.08)] * 3),
    aside=st.tuples(*[st.floats(-0.03, 0.03)] * 3),
)
def test_no_miss_exceeds_that_of_a_target_near_by_by_more_than_their_distance(
    bubbleman, seated, shelf, inside, aside
):
    target = MIDDLE - [-0.05, 0.0, 0.0] + np.array(inside)
    both = np.array([target, target + aside])
    miss = short(right_hand(bubbleman, seated, both, shelf))[0]
    assert abs(miss[0] - miss[1]) <= np.linalg.norm(aside) + PRECISE


def test_a_hand_that_misses_a_target_in_a_box_is_told_to_be_at_its_nearest_face(
    bubbleman, seated, shelf
):
    found = right_hand(bubbleman, seated, [MIDDLE - [0.03, 0.0, 0.0]], shelf)
    # 70 mm behind the face toward him; the finger that pushes is no obstacle, the hand behind it is
    assert not found.reached[0, 0]
    assert found.limit(0, 0) == "box"
    assert found.miss[0, 0] <= 0.07 + PRECISE
    assert found.overlap[0, 0] == 0


def test_a_search_that_begins_at_a_reach_finds_it_beside_obstacles_too(bubbleman, seated):
    environment = wb.load_environment("trainer")
    targets = np.array([c.at for c in environment.controls if c.grip == "push"])
    targets[:, 0] += 0.1  # deep in the panel: no way is found from the postures without it
    body = bubbleman
    pose = wb.pose(body, LEGS, reference="LT", position=(0.216, 0.28, 0.377))
    whole = right_hand(body, pose, targets, environment)
    led = np.flatnonzero(whole.reached[0] & (whole.doubt[0] == 2))
    assert len(led)
    for target in led.tolist():
        own = whole.poses.rows(slice(target, target + 1))
        for initial, reached in ((None, False), (own, True)):
            found = right_hand(
                body, pose, targets[[target]], environment, initial=initial, brief=True
            )
            assert found.reached[0, 0] == reached


def test_a_miss_is_told_as_the_posture_shows_it(bubbleman, seated, shelf):
    found = right_hand(bubbleman, seated, [MIDDLE, MIDDLE - [-0.1, -0.05, 0.0]], shelf)
    arm = wb.limb(bubbleman, "right hand", grip="push", zone=1)
    placed = wb.place(bubbleman, found.poses)
    frame = placed.world_from_segment[:, arm.end]
    tips = frame[:, :, :3] @ arm.tip[0] + frame[:, :, 3]
    np.testing.assert_allclose(
        np.linalg.norm(tips - found.target[0], axis=1), found.miss[0], atol=1e-9
    )
    met = wb.contacts(placed, shelf)
    assert not np.any(arm.solid[0, met.sphere] & (met.excess > 0))
    assert np.degrees(wb.stops(bubbleman, found.poses).margin[:, list(arm.free)].min()) > -0.1


@pytest.fixture(scope="module")
def places(tmp_path_factory):
    """People seated in a place, once."""
    folder = tmp_path_factory.mktemp("places")
    made = {}

    def of(place):
        if place == "grob":
            real_input(GROB)
        if place in MESHES:
            real_input(MESHES[place])
        if place not in made:
            made[place] = seats_in(place, folder, PEOPLE[place])
        return made[place]

    return of


@pytest.mark.nightly
@pytest.mark.parametrize("place", PEOPLE)
def test_no_miss_of_a_control_contradicts_a_target_near_by(places, place):
    seats = places(place)
    count = broken_law(seats, controls_of(seats))
    assert count.missed
    assert count.beyond(PRECISE) == 0, str(count)


@pytest.mark.nightly
@pytest.mark.parametrize("place", ["trainer", "console", "grob"])
def test_few_misses_all_about_parts_contradict_a_target_near_by(places, place):
    seats = places(place)
    count = broken_law(
        seats, [(grip, zone, targets_near_parts(seats, 10, 1)) for grip, zone in GRIPS]
    )
    assert count.beyond(10 * PRECISE) <= ROUGH * count.missed, str(count)


@pytest.mark.nightly
def test_who_stands_at_a_console_reaches_the_wall_at_the_feet_and_all_about_it(places):
    """Before, people were said to be kept 33 to 560 mm off, here or a millimetre aside."""
    seats = places("console")
    wall = next(control for control in seats.environment.controls if control.name == "foot_wall")
    aside = np.concatenate([np.zeros((1, 3)), 1e-3 * np.eye(3), -1e-3 * np.eye(3)])
    found = asked(seats, "left hand", wall.grip, wall.zone, np.array(wall.at) + aside)
    some = found.reached.any(axis=1)
    assert some.sum() > 10
    assert np.all(found.reached[some])


@pytest.mark.nightly
@pytest.mark.parametrize("place", ["trainer", "console", "grob"])
def test_an_independent_search_comes_no_nearer_to_targets_that_are_missed_but_by_millimetres(
    places, place
):
    seats = places(place)
    judged = 0
    nearer = [-np.inf]
    for grip, zone, targets in controls_of(seats):
        found = asked(seats, "left hand", grip, zone, targets)
        for person, target in np.argwhere(missed_by_obstacle(found))[:4].tolist():
            judged += 1
            search = searcher(seats, person, "left hand", grip, zone)
            miss, _ = search.nearest(targets[target], starts=12, seed=judged)
            nearer.append(short(found)[person, target] - miss)
    assert judged
    assert max(nearer) < LOCAL, nearer


@pytest.mark.nightly
@pytest.mark.parametrize("place", ["trainer", "console"])
def test_an_independent_search_comes_no_nearer_to_targets_out_of_reach(places, place):
    """But for one in 18: of 71 here 2 are told 3 mm too far; before, 8 were 2 to 7 mm."""
    longer = longer_than_searched(places(place), people=3, each=2, starts=5)
    assert len(longer) >= 30
    assert sum(one > 2 * PRECISE for one in longer) <= len(longer) / 18, longer
