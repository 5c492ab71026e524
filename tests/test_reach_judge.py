"""The judge of reaches is right itself: its kinematics, stops and distances are those of the
package, and it finds a way to where a way is known to lead."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.conftest import box_part, environment_of
from tests.judge_limb import breaches, move, sphere_centre, sphere_slope, tip, tip_slope
from tests.judge_search import OFF, evaluate
from tests.reach_judge import Judge, Surroundings
from tests.reach_truth import planted, seats_of, study_of

pytestmark = pytest.mark.nightly
STEP = 1e-6
PLANTED = 0.99
"""Share of the targets of known ways that the judge finds a way to."""
LIMBS = (
    ("left hand", "push", 1),
    ("right hand", "pinch", 2),
    ("left hand", "grasp", 3),
    ("right foot", "ball", 1),
)


@pytest.fixture(scope="module")
def seats(tmp_path_factory):
    """Two people in the trainer, with all spheres, some of them blended."""
    return seats_of("trainer", study_of("trainer", tmp_path_factory.mktemp("places")), "fine", 2)


@pytest.fixture(scope="module", params=LIMBS)
def judge(request, seats):
    name, grip, zone = request.param
    return seats.judge(1, name, grip, zone)


def drawn(judge, count=12):
    """(count, D) turns drawn evenly from the joints' ranges."""
    scene = judge.scene
    return np.random.default_rng(5).uniform(scene.low, scene.high, (count, len(scene.low)))


def centres_of(judge, turns):
    """(S, 3) where the judge has the limb's spheres."""
    state = judge.desk.state
    move(judge.scene.chain, turns, state)
    centres = np.zeros((len(judge.scene.skin.radius), 3))
    for s in range(len(centres)):
        sphere_centre(judge.scene.skin, state, s, centres[s])
    return centres


def test_its_spheres_stand_where_the_package_places_them(judge):
    sphere = np.flatnonzero(judge.arm.solid[0])
    for turns in drawn(judge):
        placed = wb.place(judge.body, judge.posed(judge.angles_at(turns)))
        np.testing.assert_allclose(centres_of(judge, turns), placed.centres[0, sphere], atol=1e-12)


def test_its_slopes_are_those_of_differences(judge):
    chain, state = judge.scene.chain, judge.desk.state
    at = np.zeros(3)
    slope = np.zeros((len(chain.owner), 3))
    for turns in drawn(judge, 4):
        first = centres_of(judge, turns)
        nudged = [centres_of(judge, turns + STEP * e) for e in np.eye(len(turns))]
        move(chain, turns, state)
        for s in range(0, len(first), 5):
            sphere_slope(chain, judge.scene.skin, state, s, first[s], slope)
            differences = np.array([(other[s] - first[s]) / STEP for other in nudged])
            np.testing.assert_allclose(slope, differences, atol=1e-5)
        tip(chain, state, at)
        tip_slope(chain, state, at, slope)
        moved = np.zeros(3)
        for d, e in enumerate(np.eye(len(turns))):
            move(chain, turns + STEP * e, state)
            tip(chain, state, moved)
            np.testing.assert_allclose(slope[d], (moved - at) / STEP, atol=1e-5)


def test_it_calls_legal_what_the_stops_of_the_package_do(judge):
    free = list(judge.arm.free)
    for turns in drawn(judge, 40):
        margin = wb.stops(judge.body, judge.posed(judge.angles_at(turns))).margin[0, free].min()
        move(judge.scene.chain, turns, judge.desk.state)
        desk = judge.desk
        count = breaches(judge.scene.chain, desk.state, 0.0, desk.breach, desk.slopes)
        assert (count > 0) == (margin < 0) or abs(margin) < 1e-6
        if count:
            # of a cone it has the distance to first order
            assert desk.breach[:count].max() == pytest.approx(-margin, rel=0.4, abs=1e-3)


def test_its_deepest_contact_is_that_of_the_package(judge):
    gap = np.zeros(3)
    for turns in drawn(judge, 40):
        placed = wb.place(judge.body, judge.posed(judge.angles_at(turns)))
        met = wb.contacts(placed, judge.room)
        excess = met.excess[judge.arm.solid[0, met.sphere]].max(initial=0.0)
        evaluate(judge.scene, turns, np.zeros(3), 0.0, judge.desk, gap)
        deepest = judge.desk.depth[: judge.desk.count[0]].max(initial=0.0) - OFF
        assert max(deepest, 0.0) == pytest.approx(max(excess, 0.0), abs=2e-6)


@pytest.mark.parametrize("place", ["trainer", "compact_car"])
def test_it_finds_a_way_to_the_tips_of_clear_postures_beside_obstacles(place, tmp_path):
    seats = seats_of(place, study_of(place, tmp_path), "medium", 4)
    found = [
        judge.judge(target).attempt >= 0
        for judge, targets in planted(seats, each=4, seed=2)
        for target in targets
    ]
    assert len(found) > 50
    assert np.mean(found) >= PLANTED


def test_it_finds_no_way_into_a_closed_box(seats):
    target = np.array([0.55, 0.1, 0.75])
    box = environment_of(box_part("box", target - 0.15, target + 0.15))
    base = wb.place(seats.body, seats.poses).world_from_segment[:, seats.body.segment("UT"), :, 3]
    body = seats.body[np.array([0])]
    arm = wb.limb(body, "right hand", grip="grasp", zone=2)
    alone = Judge(body, arm, seats.pose(0), Surroundings(box, (), base, 0.2), np.zeros(3))
    assert alone.judge(target, restarts=40).attempt < 0
