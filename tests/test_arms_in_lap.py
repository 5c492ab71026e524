"""An arm whose hand holds something between the thighs keeps clear of them, or the knees part."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.arm_oracle import arm_postures
from tests.leg_oracle import SPARE, leg_overlap, legs_of_grid
from tests.test_clear_legs import ENVIRONMENT, STUDY, at, ball_of, sat
from workbench.study.situation import without_parts

NARROW = ENVIRONMENT.replace("150, 120", "75, 120")
FEET = ("left foot", "right foot")
LIMBS = "[LLA, RLA, LHN, RHN, LLL, RLL, LF, RF]"
LIMB = (("UA", "LA", "HN"), ("UL", "LL", "F"))
KNEES = ("LLL/knee cap", "RLL/knee cap")
FLESH = 1e-3
"""[m] What a search leaves."""


def holding(folder, stick, *, hand="left", more=None, at_most=0.0, asked=True, environment=NARROW):
    """A man with narrow pedals who holds a stick [mm] with one hand, asked not to overlap himself."""
    control = f"  stick: {{at: {list(stick)}, grip: grasp, zone: 1}}\n"
    study = STUDY.replace("heels: heel", f"hands: {{{hand}: stick}}, heels: heel")
    own = f"  - {{name: own, check: self_contact, segments: {LIMBS}, at_most: {at_most}}}\n"
    return sat(folder, environment=environment + control, study=study + own * asked, more=more)


def in_legs(body, poses):
    """(P,) [m] how deep arms are in legs of the same body, 0 where they are not."""
    found = wb.self_contacts(wb.place(body, poses))
    of_arm, of_leg = (np.isin([name[1:] for name in body.segments], limb) for limb in LIMB)
    pairs = [(found.segment, found.other_segment), (found.other_segment, found.segment)]
    meets = np.any([of_arm[one] & of_leg[other] for one, other in pairs], axis=0)
    deepest = np.zeros(len(poses))
    np.maximum.at(deepest, found.pose[meets], found.excess[meets])
    return deepest


def knees_of(person):
    return np.array([at(person, name)[0] for name in KNEES])


def posts(knees, room):
    """Boxes [mm] beside the knees (2, 3) [m], so far [m] beyond them."""
    x, z = 1e3 * knees[0, 0], 1e3 * knees[0, 2]
    y = 1e3 * (abs(knees[0, 1]) + room)
    low, high = [x - 400.0, y, z - 300.0], [x + 200.0, y + 50.0, z + 200.0]
    mirror = ([low[0], -high[1], low[2]], [high[0], -low[1], high[2]])
    return {"one": (low, high), "other": mirror}


@pytest.fixture(scope="module")
def parted(tmp_path_factory):
    return holding(tmp_path_factory.mktemp("parted"), (480, 0, 400))


@pytest.fixture(scope="module")
def closed(tmp_path_factory):
    """The same man where nobody asks whether he overlaps himself."""
    return holding(tmp_path_factory.mktemp("closed"), (480, 0, 400), asked=False)[1]


def test_knees_part_for_a_hand_between_them_and_the_feet_stay_on_their_pedals(parted, closed):
    result, person = parted
    body = person.placed.body
    assert in_legs(body, closed.poses)[0] > 0.015
    assert in_legs(body, person.poses)[0] == 0.0
    assert [verdict.passed for verdict in result.verdicts] == [True] * 3
    apart, before = (np.ptp(knees_of(one)[:, 1]) for one in (person, closed))
    assert apart > before + 0.03
    for foot in FEET:
        np.testing.assert_allclose(ball_of(person, foot), ball_of(closed, foot), atol=2e-4)
    assert person.margin[0].min() >= -FLESH


def test_the_other_hand_parts_the_mirrored_knees(tmp_path, parted):
    person = holding(tmp_path, (480, 0, 400), hand="right")[1]
    mirrored = knees_of(parted[1])[::-1] * [1.0, -1.0, 1.0]
    np.testing.assert_allclose(knees_of(person), mirrored, atol=FLESH)


def test_an_arm_that_is_clear_of_the_thighs_leaves_the_knees_where_they_are(tmp_path, closed):
    person = holding(tmp_path, (420, 0, 480))[1]
    np.testing.assert_array_equal(knees_of(person), knees_of(closed))


def test_knees_that_cannot_part_are_told_as_an_overlap_up_to_what_is_allowed(tmp_path, closed):
    held = posts(knees_of(closed), 0.067)
    result, person = holding(tmp_path / "held", (480, 0, 400), more=held)
    own = next(one for one in result.verdicts if one.criterion.name == "own")
    deep = -own.worst.value
    assert deep == pytest.approx(in_legs(person.placed.body, person.poses)[0]) and deep > 2e-3
    for room, passes in ((1.0, True), (-1.0, False)):
        most = 1e3 * deep + room
        result, _ = holding(tmp_path / str(passes), (480, 0, 400), more=held, at_most=most)
        own = next(one for one in result.verdicts if one.criterion.name == "own")
        assert own.passed == passes


DRAWN = 4000
"""Arms that are drawn for each man, and how many of them, the least deep in the legs, are put beside
every posture of these."""
TRIED = 60


def clear_in_a_sample(person, around, stick, rng):
    """Whether an arm that is drawn, with a posture of each leg out of a grid, is clear of the legs and of
    what else an arm heeds, and the legs of one another."""
    body, poses = person.placed.body, person.poses
    arm = wb.limb(body, "left hand", grip="grasp")
    arms = arm_postures(body, poses, arm, np.array(stick) / 1e3, DRAWN, rng)
    arms = arms.rows(np.argsort(in_legs(body, arms), kind="stable")[:TRIED])
    clear = np.ones(len(arms), dtype=np.bool_)
    for foot in FEET:
        grid = legs_of_grid(body, poses, foot, np.radians([0.0, -4.0]))
        grid = grid.rows(np.flatnonzero(leg_overlap(body, grid, foot, around) < -SPARE))
        joints = [body.joint(foot[0].upper() + letter) for letter in "HKA"]
        deep = np.full((len(grid) + 1, len(arms)), np.inf)
        for k, leg in enumerate(grid.rotations):
            rotations = arms.rotations.copy()
            rotations[:, joints] = leg[joints]
            both = wb.Poses(rotations, arms.reference, arms.world_from_reference)
            deep[k] = deepest_of(body, both, foot[0].upper())
        clear &= deep.min(axis=0) <= 0.0
    return bool(clear.any())


def deepest_of(body, poses, side):
    """(P,) [m] how deep the left arm is in a leg, and in trunk and head beyond what it heeds, less what
    a posture of the grid must have to spare."""
    found = wb.self_contacts(wb.place(body, poses))
    error = np.nan_to_num(body.fit_error[0, :, 1])
    names = np.array(body.segments)
    deepest = np.zeros(len(poses))
    for one, other in ((found.segment, found.other_segment), (found.other_segment, found.segment)):
        arm = np.isin(names[one], ["LUA", "LLA", "LHN"])
        leg = np.isin(names[other], [side + name for name in LIMB[1]])
        trunk = np.isin(names[other], ["LT", "CT", "UT", "H"])
        beyond = found.excess - trunk * (error[one] + error[other])
        meets = arm & (leg | trunk)
        np.maximum.at(deepest, found.pose[meets], np.maximum(beyond[meets], 0.0))
    return deepest


@pytest.mark.nightly
def test_no_posture_of_a_sample_is_clear_where_arms_are_told_to_be_in_the_legs(tmp_path, closed):
    """Sticks at random places of the lap, between walls at random places beside the knees: of those who
    are told to overlap themselves at most one in ten could have been clear by a sample of arms and legs."""
    rng = np.random.default_rng(7)
    told = missed = 0
    for number in range(60):
        stick = rng.uniform([420.0, -60.0, 370.0], [470.0, 60.0, 410.0]).round(1).tolist()
        held = posts(knees_of(closed), rng.uniform(0.06, 0.08))
        result, person = holding(tmp_path / str(number), stick, more=held)
        body = person.placed.body
        tip = wb.limb(body, "left hand", grip="grasp").tip[0]
        hand = person.placed.world_from_segment[0, body.segment("LHN")]
        there = np.linalg.norm(hand[:, :3] @ tip + hand[:, 3] - np.array(stick) / 1e3) < FLESH
        if there and in_legs(body, person.poses)[0] > FLESH:
            told += 1
            around = without_parts(result.environment, ("pan", "back"))
            missed += clear_in_a_sample(person, around, stick, rng)
    assert told > 4 and missed <= told / 10
