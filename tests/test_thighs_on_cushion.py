"""Thighs lie on the front of a cushion: what it is made of, and that seating keeps them out of it."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.accommodations import smaller_study
from tests.crowds import crowd_of
from tests.test_seat_people import EYE, TRAINER, poses_of
from tests.test_seated_flesh import TRAINER as STUDY
from tests.toy_cockpit import write_toy
from workbench.posture.seating.posture import positions

GIVEN = 0.045
"""[m] How deep the trainer's cushions let thighs in."""
SHORT = "{sex: female, measures: {stature: 1525, sitting_height: 803}, mass_kg: 52}"


@pytest.fixture(scope="module")
def crowd(tmp_path_factory):
    path = smaller_study("trainer_accommodation", tmp_path_factory.mktemp("thighs"), people=48)
    return crowd_of(path)


@pytest.fixture(scope="module")
def sitters(crowd):
    return crowd.seated(crowd.bodies[:], range(len(crowd.people)))


def max_miss(seated):
    return np.max(list(seated.miss.values()), axis=0)


def test_the_front_of_a_box_is_its_upper_side_and_its_edge(tmp_path):
    write_toy(tmp_path)
    front = wb.load_environment(tmp_path / "environments/toy").seat("pilot").front
    assert front.gives == pytest.approx(0.2)
    np.testing.assert_allclose(np.unique(front.faces, axis=0), [[0, 1, 0], [1, 0, 0.45]], atol=1e-9)


def test_the_front_is_told_in_the_frame_of_its_cushion(tmp_path):
    write_toy(tmp_path)
    room = tmp_path / "environments/toy/environment.yaml"
    room.write_text(room.read_text().replace("cushion_angle: 0", "cushion_angle: 30"))
    faces = wb.load_environment(room.parent).seat("pilot").front.faces
    # the level top of the box falls away from a cushion plane that rises by 30 degrees
    np.testing.assert_allclose(faces[0], [0.5, np.sqrt(0.75), 0.0], atol=1e-9)


def test_nobody_in_the_trainer_has_thighs_deeper_in_the_cushion_than_it_gives(crowd, sitters):
    """By the mesh itself: before, 38 of 100 were deeper, by 50 mm at worst."""
    body = crowd.bodies[:]
    world = sitters.poses.world_from_reference.copy()
    world[:, :, 3] -= sitters.shift  # the seat is where its mesh stands
    back = wb.Poses(sitters.poses.rotations, sitters.poses.reference, world)
    pan = crowd.environment.part_index(crowd.seat.cushion.part)
    thighs = [body.segment(name) for name in ("LUL", "RUL")]
    gaps = wb.clearance(wb.place(body, back), crowd.environment)
    deepest = -gaps[:, thighs, pan].min(axis=1)
    assert np.all(deepest <= GIVEN + 1e-3)
    assert np.all(sitters.pressed <= 1e-3)
    assert max_miss(sitters).max() < 1e-3


def test_no_place_of_the_seat_presses_thighs_less_and_is_easier(crowd):
    body = crowd.bodies[:]
    poses = poses_of(body)
    best = wb.seat(body, poses, crowd.seat, eye=EYE, pedals=TRAINER)
    for forward in positions(crowd.seat.travel_forward)[::3].tolist():
        held = replace(crowd.seat, travel_forward=(forward, forward))
        there = wb.seat(body, poses, held, eye=EYE, pedals=TRAINER)
        good = (there.pressed < 5e-4) & (max_miss(there) < 1e-3)
        assert np.all(there.discomfort[good] >= best.discomfort[good] - 2e-3)


def test_thighs_that_no_place_rests_are_reported(tmp_path):
    path = tmp_path / "sits.yaml"
    text = STUDY.format(body=f"adult_female, size: {SHORT}", sex="female")
    path.write_text(text.replace("seat: left}", "seat: left, position: {forward: -20, up: 45}}"))
    warnings = [w for w in wb.run(wb.load_study(path)).warnings if "thighs" in w]
    assert len(warnings) == 1
    assert "left_seat_pan, which gives 45 mm" in warnings[0]


def test_a_leg_without_a_pedal_hangs_as_its_posture_has_it(bubbleman):
    seat = wb.load_environment("trainer").seat("left")
    poses = wb.pose(bubbleman, {}, reference="LT")
    assert wb.seat(bubbleman, poses, seat, eye=EYE).pressed[0] == 0.0


def test_heels_come_off_the_floor_where_thighs_press_too_deep_with_them_down(crowd):
    """The knees rise with the heels: seats held where thighs pressed by up to 120 mm."""
    body = crowd.bodies[:]
    held = np.tile([0.09, 0.0333], (len(body), 1))
    floored = replace(TRAINER, floor=None)
    found = wb.seat(body, poses_of(body), crowd.seat, pedals=TRAINER, held=held)
    free = wb.seat(body, poses_of(body), crowd.seat, pedals=floored, held=held)
    assert np.all(found.pressed <= free.pressed + 1e-3)
    assert np.all(max_miss(found) <= max_miss(free) + 2e-4)


def test_feet_that_reach_their_pedals_only_through_the_cushion_do_not_meet_pedals(tmp_path):
    path = tmp_path / "sits.yaml"
    text = STUDY.format(body=f"adult_female, size: {SHORT}", sex="female")
    text = text.replace("seat: left}", "seat: left, position: {forward: -20, up: 45}}")
    head, _, _ = text.partition("criteria:")
    path.write_text(head + "criteria:\n  - {name: pedals, check: pedals, at_most: 60}\n")
    result = wb.run(wb.load_study(path))
    said = " ".join(result.warnings)
    deeper = float(re.search(r"thighs press (\d+) mm", said)[1]) - 1000 * GIVEN
    missed = max(float(mm) for mm in re.findall(r"foot stays ([\d.]+) mm short", said))
    worst = result.verdicts[0].worst
    assert deeper > 10 and not result.verdicts[0].passed
    assert 1000 * worst.value == pytest.approx(-(missed + deeper), abs=1.5)
