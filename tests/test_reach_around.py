"""People led around obstacles: whoever is said to be kept from a target is, whoever else is
asked."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from time import process_time

import numpy as np
import pytest

import workbench as wb
from tests.conftest import box_part, environment_of
from tests.reach_judge import Judge, Surroundings
from tests.reach_oracle import clear_ways
from workbench import limb, reach, scale
from workbench.files.meshes.parts import RawPart
from workbench.model.environment import Allowance
from workbench.model.joint_angles import attitude_matrix
from workbench.model.reach import DOUBTS

MEASURES = ({"stature": 1.56}, {"stature": 1.66}, {"stature": 1.75}, {"stature": 1.86})
HOW = {"name": "left hand", "grip": "grasp", "zone": 2}
CONTROLS = ("left_canopy_latch", "throttle", "parking_brake", "alternate_air")
LEGS = {"LH": {"flexion": 80}, "RH": {"flexion": 80}, "LK": {"flexion": 70}, "RK": {"flexion": 70}}
HARD = ((1.781, 0.216, 0.377), (1.682, 0.199, 0.353), (1.595, 0.208, 0.369), (1.679, 0.138, 0.356))
"""People for whom single controls are hard to get at: stature, and where the pelvis is along the
seat and up [m]."""
LATCH = "left_canopy_latch"
FORMER = (
    (0, "left hand", 2, LATCH),
    (1, "left hand", 2, LATCH),
    (2, "left hand", 2, LATCH),
    (3, "left hand", 2, LATCH),
    (0, "left hand", 2, "audio_panel"),
    (0, "left hand", 3, "nav_com_radio"),
    (2, "left hand", 2, "left_air_vent"),
)
"""Person of HARD, hand, zone and control that the search of before said to be kept by an
obstacle."""
THROUGH_ONESELF = (
    (3, "left hand", 1, LATCH),
    (1, "left hand", 1, "fuel_selector"),
    (2, "left hand", 1, "fuel_selector"),
    (0, "right hand", 1, "ignition"),
)
"""The same where every way that is clear of the cockpit leads through the own body: of 600,000 drawn
postures the least deep has the upper arm 4.8 mm deeper in the own upper torso than it gives, for
the ignition, and 88 mm in the central torso for the fuel selector."""
DEEP_REACHED = 35
"""Of 44 targets 100 mm deep in the panel those that are reached."""


@pytest.fixture(scope="module")
def people(bubbleman):
    return wb.stack_bodies([scale(bubbleman, measures) for measures in MEASURES])


@pytest.fixture(scope="module")
def seated(people):
    return wb.join_poses(
        [wb.pose(body, LEGS, reference="LT", position=(0.17, 0.28, 0.38)) for body in people]
    )


@pytest.fixture(scope="module")
def hard(bubbleman):
    """The people of HARD and how they sit."""
    bodies = [scale(bubbleman, {"stature": stature}) for stature, _, _ in HARD]
    poses = [
        wb.pose(body, LEGS, reference="LT", position=(x, 0.28, z))
        for body, (_, x, z) in zip(bodies, HARD, strict=True)
    ]
    return wb.stack_bodies(bodies), wb.join_poses(poses)


@pytest.fixture(scope="module")
def trainer():
    return wb.load_environment("trainer")


@pytest.fixture(scope="module")
def controls(trainer):
    return np.array(
        [control.at for name in CONTROLS for control in trainer.controls if control.name == name]
    )


@pytest.fixture(scope="module")
def around_people(hard, trainer):
    """The trainer's parts near the people of HARD, for the judge."""
    bodies, poses = hard
    base = wb.place(bodies, poses).world_from_segment[:, bodies.segment("UT"), :, 3]
    return Surroundings(trainer, (), base, float(bodies.radius.max()) + 2e-3)


def row(poses, b):
    return wb.Poses(
        poses.rotations[b : b + 1], poses.reference, poses.world_from_reference[b : b + 1]
    )


def _false_misses(people, seated, trainer, controls, how, *, draws, keep):
    """(person, target) said to be kept from a target by more than 5 mm by obstacles alone, that a
    drawn posture reaches; and how many were looked at."""
    free = ask(people, seated, None, controls, how)
    found = ask(people, seated, trainer, controls, how)
    kept = np.argwhere(free.reached & ~found.reached & (found.miss + found.overlap > 5e-3))
    wrong = []
    for b, t in kept:
        arm = limb(people[b], how["name"], grip=how["grip"], zone=how["zone"])
        ways = clear_ways(
            people[b], arm, row(seated, b), controls[t], trainer, draws=draws, keep=keep, seed=1
        )
        wrong += [(int(b), CONTROLS[t])] * bool(len(ways))
    return wrong, len(kept)


def test_whoever_is_kept_from_a_control_has_no_clear_way_among_many_drawn(
    people, seated, trainer, controls
):
    wrong, _ = _false_misses(
        people[1::2], seated_of(seated, [1, 3]), trainer, controls, HOW, draws=20000, keep=300
    )
    assert not wrong


@pytest.mark.nightly
@pytest.mark.parametrize("zone", [1, 2, 3])
@pytest.mark.parametrize(
    ("name", "grip"), [("left hand", "grasp"), ("right hand", "grasp"), ("left hand", "push")]
)
def test_nobody_kept_from_a_control_has_a_clear_way_among_thousands_drawn(
    people, seated, trainer, controls, name, grip, zone
):
    how = {"name": name, "grip": grip, "zone": zone}
    # a way that fills 3e-5 of the ranges of the angles is drawn with 95 % (1 - exp(-3))
    wrong, _ = _false_misses(people, seated, trainer, controls, how, draws=100_000, keep=1000)
    assert not wrong


def seated_of(poses, rows):
    return wb.Poses(poses.rotations[rows], poses.reference, poses.world_from_reference[rows])


def test_a_hand_that_is_led_around_enters_nothing_and_keeps_its_stops(
    people, seated, trainer, controls
):
    found = ask(people, seated, trainer, controls, HOW)
    count = len(controls)
    for b, body in enumerate(people):
        arm = limb(body, "left hand", grip="grasp", zone=2)
        own = found.poses.rows(slice(b * count, (b + 1) * count))
        poses = wb.Poses(own.rotations, own.reference, own.world_from_reference)
        met = wb.contacts(wb.place(body, poses), trainer)
        met = met.rows(arm.solid[0, met.sphere] & (met.excess > 0))
        assert not set(met.pose) & set(np.flatnonzero(found.reached[b]))
        assert np.degrees(wb.stops(body, poses).margin[:, list(arm.free)].min()) > -0.1
    assert found.reached.any()


def witnessed(body, arm, found, target, environment):
    """Whether the posture found for one target brings the tip there within the stops and clear."""
    poses = found.poses
    placed = wb.place(body, poses)
    world = placed.world_from_segment[0, arm.end]
    met = wb.contacts(placed, environment)
    return (
        np.linalg.norm(world[:, :3] @ arm.tip[0] + world[:, 3] - target) < 1.1e-4
        and np.degrees(wb.stops(body, poses).margin[:, list(arm.free)].min()) > -0.1
        and not np.any(arm.solid[0, met.sphere] & (met.excess > 0))
    )


@pytest.mark.parametrize(("who", "hand", "zone", "name"), FORMER)
def test_who_was_falsely_said_to_be_kept_reaches_within_the_stops_and_clear(
    hard, trainer, who, hand, zone, name
):
    bodies, poses = hard
    body = bodies[who]
    pose = row(poses, who)
    control = one(trainer, name)
    arm = limb(body, hand, grip=control.grip, zone=zone)
    found = reach(body, pose, [control.at], limb=arm, environment=trainer)
    assert found.reached[0, 0]
    assert witnessed(body, arm, found, control.at, trainer)


def one(environment, name):
    return next(control for control in environment.controls if control.name == name)


@pytest.mark.parametrize(("who", "hand", "zone", "name"), THROUGH_ONESELF)
def test_who_would_have_to_reach_through_himself_does_not_reach(
    hard, trainer, who, hand, zone, name
):
    bodies, poses = hard
    control = one(trainer, name)
    arm = limb(bodies[who], hand, grip=control.grip, zone=zone)
    found = reach(bodies[who], row(poses, who), [control.at], limb=arm, environment=trainer)
    assert not found.reached[0, 0] and found.miss[0, 0] > 1e-3


@pytest.mark.nightly
@pytest.mark.parametrize(("who", "hand", "zone", "name"), FORMER)
def test_random_restarts_with_kinematics_of_their_own_find_their_way_too(
    hard, trainer, around_people, who, hand, zone, name
):
    bodies, poses = hard
    control = one(trainer, name)
    arm = limb(bodies[who], hand, grip=control.grip, zone=zone)
    judge = Judge(bodies[who], arm, row(poses, who), around_people, np.zeros(3))
    assert judge.judge(control.at).attempt >= 0


def ask(body, poses, environment, targets, how):
    """Reaches of everybody with one limb, `how` being its name, grip and zone."""
    return reach(body, poses, targets, limb=limb(body, **how), environment=environment)


def test_a_freer_arm_reaches_what_a_tighter_one_does(hard, trainer, controls):
    one_two = [
        ask(*hard, trainer, controls, {"name": "left hand", "grip": "grasp", "zone": zone})
        for zone in (1, 2)
    ]
    assert np.all(one_two[1].reached[one_two[0].reached])


def test_a_target_in_a_closed_box_stays_missed_with_the_hand_at_the_box(hard):
    bodies, poses = hard
    target = np.array([0.55, 0.1, 0.75])
    half = 0.15
    box = environment_of(box_part("box", target - half, target + half))
    how = {"name": "right hand", "grip": "grasp", "zone": 2}
    free = ask(bodies, poses, None, [target], how)
    found = ask(bodies, poses, box, [target], how)
    assert free.reached.all() and not found.reached.any()
    assert {found.limit(b, 0) for b in range(len(bodies))} == {"box"}
    assert np.all(found.doubt == DOUBTS.index("kept for certain")) and np.all(free.doubt == 0)
    assert np.all(found.overlap == 0)
    assert np.all(np.abs(found.miss - half) < 0.05)


def test_how_doubts_end_is_reported(hard, trainer, controls):
    how = {"name": "left hand", "grip": "grasp", "zone": 2}
    free = ask(*hard, None, controls, how)
    found = ask(*hard, trainer, controls, how)
    kept = found.doubt == DOUBTS.index("kept")
    led = (found.doubt > 0) & ~kept
    assert np.any(led) and np.all(found.reached[led]) and not np.any(found.reached[kept])
    certain = found.doubt == 0
    np.testing.assert_array_equal(found.reached[certain], free.reached[certain])
    np.testing.assert_array_equal(
        found.angles[certain & free.reached], free.angles[certain & free.reached]
    )


@pytest.mark.parametrize("eased", ["hidden", "allowed"])
def test_a_part_that_is_taken_away_or_allows_more_keeps_nobody(hard, trainer, controls, eased):
    how = {"name": "left hand", "grip": "grasp", "zone": 2}
    found = ask(*hard, trainer, controls, how)
    number = trainer.part_index("instrument_panel")
    if eased == "hidden":
        easier = replace(trainer, hidden=trainer.hidden | (np.arange(len(trainer.parts)) == number))
    else:
        rule = Allowance(number, ("all",), 0.02)
        easier = replace(trainer, allowances=(*trainer.allowances, rule))
    assert np.all(ask(*hard, easier, controls, how).reached[found.reached])


def test_a_fine_sheet_that_hands_may_enter_changes_no_reach_and_costs_little(hard):
    target = np.array([0.55, 0.1, 0.75])
    above = target + np.array([[-0.06, -0.3, 0.03], [0.2, 0.3, 0.3]])
    below = target + np.array([[-0.06, -0.3, -0.3], [0.2, 0.3, -0.03]])
    slot = box_part("above", *above), box_part("below", *below)
    both = environment_of(*slot, fine_sheet("sheet", target - [0.05, 0.0, 0.0]))
    both = replace(both, allowances=(Allowance(both.part_index("sheet"), ("all",), 1.0),))
    one, alone = timed(hard, environment_of(*slot), target)
    two, beside = timed(hard, both, target)
    assert not one.reached.any()
    np.testing.assert_array_equal(two.angles, one.angles)
    np.testing.assert_array_equal(two.miss, one.miss)
    assert beside < 3 * alone  # 12 times where each face of the sheet is looked at


def fine_sheet(name, middle):
    """An upright wavy sheet of 0.24 m, of 12,800 triangles."""
    along, up = np.meshgrid(np.linspace(-0.12, 0.12, 81), np.linspace(-0.12, 0.12, 81))
    wave = 5e-3 * np.sin(90.0 * along) * np.cos(120.0 * up)
    points = np.stack([wave, along, up], axis=-1).reshape(-1, 3)
    corner = (81 * np.arange(80)[:, None] + np.arange(80)).reshape(-1, 1, 1)
    faces = corner + np.array([[0, 1, 82], [0, 82, 81]])
    return RawPart(name, middle + points, faces.reshape(-1, 3))


def timed(people, around, target):
    """Reaches for a target, and the CPU time [s] that they take once all is compiled and indexed."""
    how = {"name": "right hand", "grip": "grasp", "zone": 2}
    ask(*people, around, [target], how)
    begun = process_time()
    found = ask(*people, around, [target], how)
    return found, process_time() - begun


def deeper(environment, grip):
    """Controls of a grip 100 mm deeper in the panel than they are."""
    targets = np.array([control.at for control in environment.controls if control.grip == grip])
    targets[:, 0] += 0.1
    return targets


def test_many_targets_deep_in_the_panel_are_reached(hard, trainer):
    found = ask(
        *hard, trainer, deeper(trainer, "push"), {"name": "right hand", "grip": "push", "zone": 2}
    )
    assert found.reached.sum() >= DEEP_REACHED


@pytest.fixture(scope="module")
def belted():
    """A table's edge inside the trunk of who sits at it: a trunk that moves never gets out of it."""
    return environment_of(box_part("edge", [0.14, 0.2, 0.40], [0.20, 0.36, 0.9]))


@pytest.mark.parametrize(
    ("around", "grip", "count"),
    [
        *(("nothing", grip, 12) for grip in ("push", "pinch", "grasp")),
        ("belted", "push", 3),
        pytest.param("trainer", "grasp", 12, marks=pytest.mark.nightly),
        pytest.param("trainer", "push", 12, marks=pytest.mark.nightly),
        pytest.param("trainer", "pinch", 12, marks=pytest.mark.nightly),
        pytest.param("belted", "pinch", 12, marks=pytest.mark.nightly),
        pytest.param("belted", "grasp", 12, marks=pytest.mark.nightly),
        pytest.param("belted", "push", 12, marks=pytest.mark.nightly),
    ],
)
def test_a_freer_zone_reaches_whatever_a_tighter_one_does(
    people, seated, trainer, belted, grip, around, count
):
    environment = {"nothing": None, "trainer": trainer, "belted": belted}[around]
    targets = np.random.default_rng(8).uniform([0.1, -0.1, 0.3], [0.7, 0.7, 1.2], (12, 3))[:count]
    found = [
        reach(
            people,
            seated,
            targets,
            limb=limb(people, "left hand", grip=grip, zone=zone),
            environment=environment,
        )
        for zone in (1, 2, 3)
    ]
    for held, free in pairwise(found):
        assert np.all(free.reached[held.reached])
        tip = free.tip[free.reached]
        np.testing.assert_allclose(tip, free.target[free.reached], atol=1e-4)


def test_what_a_tighter_zone_reaches_is_shown_in_its_posture(people, seated, belted):
    """Before, a trunk that touches something reached nothing in zone 3."""
    target = np.array([[0.4, 0.5, 0.7]])
    tight, free = (
        reach(
            people,
            seated,
            target,
            limb=limb(people, "left hand", zone=zone),
            environment=belted,
        )
        for zone in (1, 3)
    )
    assert np.all(tight.reached)
    assert np.all(free.reached)
    arm = limb(people, "left hand", zone=3)
    for b, body in enumerate(people):
        own = wb.place(body, replace(free.poses, person=None).rows(slice(b, b + 1)))
        frame = own.world_from_segment[0, arm.end]
        tip = frame[:, :3] @ arm.tip[b] + frame[:, 3]
        np.testing.assert_allclose(tip, target[0], atol=1e-4)


def rack(turn, offset):
    """Pigeonholes in front of somebody who sits, turned (3, 3) and moved (3,) [m]: boards that meet
    and cross, so that two of them are as near, or as deep, along all edges."""
    boards = [box_part("back", (0.88, -0.4, 0.3), (0.9, 0.9, 1.2))]
    for k, z in enumerate(np.linspace(0.3, 1.2, 6)):
        boards.append(box_part(f"shelf {k}", (0.68, -0.4, z), (0.88, 0.9, z + 0.02)))
    for k, y in enumerate(np.linspace(-0.4, 0.9, 8)):
        boards.append(box_part(f"upright {k}", (0.68, y, 0.32), (0.88, y + 0.02, 1.2)))
    return environment_of(
        *(replace(board, vertices=board.vertices @ turn.T + offset) for board in boards)
    )


def reaches_into(body, poses, turn, offset):
    """What people reach in the pigeonholes, all of it turned and moved."""
    targets = np.array([(0.8, y, z) for y in (-0.2, 0.06, 0.32, 0.58) for z in (0.42, 0.8)])
    world = turn @ poses.world_from_reference
    world[:, :, 3] += offset
    return reach(
        body,
        wb.Poses(poses.rotations, poses.reference, world),
        targets @ turn.T + offset,
        limb=limb(body, **HOW),
        environment=rack(turn, offset),
        thorough=False,
    )


def test_people_reach_alike_wherever_their_surroundings_stand(hard):
    bodies, poses = hard
    one = reaches_into(bodies, poses, np.eye(3), np.zeros(3))
    assert 0.1 < one.reached.mean() < 0.9
    for degrees, offset in ((23.0, (0.7, -1.3, 0.2)), (141.0, (-20.0, 3.0, 0.0))):
        turn = attitude_matrix(yaw=np.radians(degrees))
        other = reaches_into(bodies, poses, turn, np.array(offset))
        assert np.array_equal(one.part, other.part)
        assert np.array_equal(one.angles, other.angles)
        assert np.abs(one.miss - other.miss).max() < 1e-9


def test_a_limb_reaches_and_misses_alike_to_the_bit_wherever_people_are(hard):
    bodies, poses = hard
    targets = np.array([(x, y, 0.7) for x in np.arange(0.3, 1.3, 0.1) for y in (-0.3, 0.1, 0.5)])
    how = limb(bodies, **HOW)
    turn, offset = attitude_matrix(yaw=0.6458), np.array([10.0, -10.0, 0.0])
    frames = turn @ poses.world_from_reference
    frames[:, :, 3] += offset
    there = replace(poses, world_from_reference=frames)
    one = reach(bodies, poses, targets, limb=how, max_extension=0.2)
    two = reach(bodies, there, targets @ turn.T + offset, limb=how, max_extension=0.2)
    assert 0.2 < one.reached.mean() < 0.8
    assert np.array_equal(one.angles, two.angles)
    assert np.array_equal(one.extension, two.extension)
