"""Arms and hands heed the own body: what is told to be reached enters trunk, head and legs no deeper than
they allow, and what is told to be kept by them has no clear posture of the arm."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.conftest import box_part, environment_of
from tests.reach_judge import Judge, Surroundings, entered
from workbench.posture.reaching.again import no_reaches, still_reached

SIT = {joint: {"flexion": 85} for joint in ("LH", "RH")} | {
    joint: {"flexion": 80} for joint in ("LK", "RK")
}
FAR = environment_of(box_part("far", [3, 3, 3], [3.1, 3.1, 3.1]))
"""Nothing stands around, so only the own body is in the way."""
LAP = np.array([[0.088, 0.169, 0.084], [0.062, -0.137, 0.12], [0.135, 0.219, 0.198]])
"""[m] from the pelvis: points that an arm comes to through the trunk in comfort, and round it too."""
ASIDE = np.array([1.0, -1.0, 1.0])


@pytest.fixture(scope="module")
def man():
    return wb.load_body("adult_male")


@pytest.fixture(scope="module")
def sits(man):
    return wb.pose(man, SIT, reference="LT")


@pytest.mark.parametrize("zone", [1, 2, 3])
def test_an_arm_goes_round_the_own_trunk_and_thighs(man, sits, zone):
    arm = wb.limb(man, "right hand", grip="grasp", zone=zone)
    heedless = wb.reach(man, sits, LAP, limb=arm)
    found = wb.reach(man, sits, LAP, limb=arm, environment=FAR)
    assert heedless.reached.all() and entered(man, heedless.poses, "right hand").max() > 0.02
    assert found.reached.all() and entered(man, found.poses, "right hand").max() == 0.0
    np.testing.assert_allclose(found.tip, found.target, atol=2e-4)


def test_who_is_out_of_the_own_body_stays_as_it_is_to_the_bit(man, sits):
    arm = wb.limb(man, "right hand", grip="grasp", zone=2)
    ahead = [[0.55, -0.2, 0.3], [0.4, -0.4, 0.2]]
    heedless = wb.reach(man, sits, ahead, limb=arm)
    assert entered(man, heedless.poses, "right hand").max() == 0.0
    found = wb.reach(man, sits, ahead, limb=arm, environment=FAR)
    np.testing.assert_array_equal(found.angles, heedless.angles)


@pytest.mark.parametrize("hand", ["left hand", "right hand"])
def test_a_target_within_the_own_thigh_is_kept_by_it(man, sits, hand):
    side = hand[0].upper()
    thigh = wb.place(man, sits).world_from_segment[0, man.segment(side + "UL"), :, 3]
    arm = wb.limb(man, hand, grip="grasp", zone=1)
    found = wb.reach(man, sits, [thigh], limb=arm, environment=FAR)
    assert not found.reached[0, 0]
    assert found.reason(0, 0).kind == "own"
    assert found.limit(0, 0) == f"own {hand.split()[0]} upper leg"
    assert 0.02 < found.miss[0, 0] < 0.12
    assert entered(man, found.poses, hand)[0] == 0.0


def test_mirrored_targets_have_mirrored_answers(man, sits):
    targets = np.concatenate([LAP, [[0.2, -0.1, 0.02], [0.25, 0.1, -0.08]]])
    right, left = (
        wb.reach(man, sits, where, limb=wb.limb(man, hand, grip="grasp", zone=2), environment=FAR)
        for hand, where in (("right hand", targets), ("left hand", targets * ASIDE))
    )
    np.testing.assert_array_equal(left.reached, right.reached)
    np.testing.assert_allclose(left.miss, right.miss, atol=2e-3)
    assert right.reached.any() and not right.reached.all()


def test_an_arm_that_the_chest_keeps_off_reaches_from_a_trunk_that_leans(man, sits):
    """Targets close before the chest and the belly: upright, the upper arm or the hand is in the trunk."""
    close = np.array([[0.04, -0.13, 0.27], [0.08, -0.08, 0.22], [0.06, -0.11, 0.27]])
    leaning = []
    for hand, targets in (("right hand", close), ("left hand", close * ASIDE)):
        held, freed = (wb.limb(man, hand, grip="grasp", zone=zone) for zone in (2, 3))
        assert not wb.reach(man, sits, targets, limb=held, environment=FAR).reached.any()
        found = wb.reach(man, sits, targets, limb=freed, environment=FAR)
        assert found.reached.all() and entered(man, found.poses, hand).max() == 0.0
        assert wb.stops(man, found.poses).margin.min() > -1e-3
        leaning.append(found.angles[0, :, 0])
    np.testing.assert_allclose(leaning[1], leaning[0] * (1, -1, -1), atol=1e-9)


def test_people_of_a_crowd_have_their_own_bodies(man):
    bodies = wb.stack_bodies([wb.scale(man, {"stature": s}) for s in (1.62, 1.75, 1.9)])
    poses = wb.join_poses([wb.pose(body, SIT, reference="LT") for body in bodies])
    both = wb.limb(bodies, "left hand", grip="grasp", zone=3)
    crowd = wb.reach(bodies, poses, LAP * ASIDE, limb=both, environment=FAR)
    for k, body in enumerate(bodies):
        arm = wb.limb(body, "left hand", grip="grasp", zone=3)
        pose = wb.pose(body, SIT, reference="LT")
        alone = wb.reach(body, pose, LAP * ASIDE, limb=arm, environment=FAR)
        np.testing.assert_array_equal(alone.angles[0], crowd.angles[k])
        assert entered(body, alone.poses, "left hand")[alone.reached[0]].max() == 0.0


def test_the_other_arm_gives_way_unless_it_holds_something(man, sits):
    arm = wb.limb(man, "left hand", grip="grasp", zone=1)
    held = wb.reach(man, sits, [[0.3, 0.05, 0.25]], limb=arm, environment=FAR).poses
    placed = wb.place(man, held)
    forearm = placed.world_from_segment[0, man.segment("LLA"), :, 3]
    beside = [forearm + np.array([0.02, -0.03, 0.02])]
    arm = wb.limb(man, "right hand", grip="grasp", zone=1)
    gives = wb.reach(man, held, beside, limb=arm, environment=FAR)
    stays = wb.reach(man, held, beside, limb=arm, environment=FAR, other_arm=True)
    assert gives.reached[0, 0] and entered(man, gives.poses, "right hand", other_arm=True)[0] > 0.0
    assert entered(man, stays.poses, "right hand", other_arm=True)[0] == 0.0


def test_a_reach_kept_from_elsewhere_is_none_where_it_enters_the_own_body(man, sits):
    arm = wb.limb(man, "right hand", grip="grasp", zone=2)
    heedless = wb.reach(man, sits, LAP, limb=arm)
    clear = wb.reach(man, sits, LAP, limb=arm, environment=FAR)
    for found, expected in ((heedless, False), (clear, True)):
        kept = no_reaches(man, arm, (1, len(LAP)))
        kept.put(np.zeros(len(LAP), int), np.arange(len(LAP)), found.angles[0])
        still = still_reached(
            man,
            sits,
            LAP[None],
            limb=arm,
            kept=kept,
            environment=FAR,
            moving_parts=(),
            displacement=np.zeros((1, 3)),
        )
        assert (still == expected).all()


def ways(body, poses, arm, target, draws):
    """Postures that bring a hand to a target whatever they enter, by random restarts of a search with
    kinematics of its own."""
    base = poses.world_from_reference[:, :, 3]
    around = Surroundings(FAR, (), base, float(body.radius.max()) + 2e-3)
    judge = Judge(body, arm, poses, around, np.zeros(3))
    verdicts = [judge.judge(target, restarts=12, seed=1 + 1_000_003 * k) for k in range(draws)]
    return [judge.posed(one.angles) for one in verdicts if one.attempt >= 0]


@pytest.mark.nightly
@pytest.mark.parametrize("zone", [1, 2, 3])
def test_what_is_kept_by_the_own_body_is_so_for_a_slow_sampler(man, sits, zone):
    """Targets all about the lap, which often lie within the body: what is reached enters nothing, and of
    what is not, the sampler finds a clear posture for one in twenty at most."""
    rng = np.random.default_rng(zone)
    count = 360
    low, high = (0.0, -0.25, -0.05), (0.5, 0.25, 0.35)
    targets = rng.uniform(low, high, (count, 3))
    hand = ("left hand", "right hand")[zone % 2]
    arm = wb.limb(man, hand, grip="grasp", zone=zone)
    free = wb.reach(man, sits, targets, limb=arm).reached[0]
    found = wb.reach(man, sits, targets, limb=arm, environment=FAR)
    reached = found.reached[0]
    assert entered(man, found.poses, hand)[reached].max() == 0.0
    kept = np.flatnonzero(free & ~reached)
    assert all(found.reason(0, k).kind == "own" for k in kept)
    wrong = sum(
        min(entered(man, way, hand)[0] for way in some) == 0.0
        for k in kept
        if (some := ways(man, sits, arm, targets[k], draws=20))
    )
    assert len(kept) >= 20 and wrong <= 0.05 * len(kept)
