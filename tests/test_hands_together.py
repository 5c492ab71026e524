"""Hands of people who are there together: on their controls, clear of one another, wherever a slow
sampler finds a way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.reach_judge import Judge, Surroundings
from tests.test_hands_held import seated  # noqa: F401 (a fixture)
from workbench import Bystander
from workbench.study.bench.placing import placed_people
from workbench.study.bench.state import open_study
from workbench.study.hands import hands_together
from workbench.study.people import present_people
from workbench.study.situation import solid_to_others, with_hands

PAIR = """
study: pair
length: mm
environment: trainer
people:
  a: {{body: bubbleman, size: {{sex: male, measures: {{stature: {a.stature}}}}}, seat: left,
    position: {{forward: {a.forward}, up: {a.up}}}}}
  b: {{body: bubbleman, size: {{sex: male, measures: {{stature: {b.stature}}}}}, seat: right,
    position: {{forward: {b.forward}, up: {b.up}}}}}
cases:
  - name: flying
    people:
      a: {{predicted: {{hands: {{right: {a.control}}}, heels: left_heel,
        feet: {{left: left_seat_left_pedal, right: left_seat_right_pedal}}}}}}
      b: {{predicted: {{hands: {{left: {b.control}}}, heels: right_heel,
        feet: {{left: right_seat_left_pedal, right: right_seat_right_pedal}}}}}}
criteria:
  - {{name: stops, check: stops}}
"""
MIDDLE = ("throttle", "mixture", "propeller", "carb_heat", "fuel_selector", "elevator_trim")
"""Controls in the middle, that both reach."""


class Sitter:
    """How tall somebody is, where the seat stands [mm], and what the inner hand holds."""

    def __init__(self, stature, forward, up, control):
        self.stature = stature
        self.forward = forward
        self.up = up
        self.control = control


def drawn(rng):
    """Two sitters."""
    names = rng.choice(MIDDLE, 2, replace=False)
    return [
        Sitter(
            int(rng.integers(1700, 1930)), int(rng.integers(-80, 80)), int(rng.integers(0, 40)), c
        )
        for c in names
    ]


@pytest.fixture
def study_of(tmp_path):
    def study(a, b):
        path = tmp_path / "study.yaml"
        path.write_text(PAIR.format(a=a, b=b))
        return wb.load_study(path)

    return study


def depth(one, other):
    """[m] How deep two people are in each other, fingers on controls aside; 0 where they are not."""
    met = wb.body_contacts(one.placed, other.placed)
    counts = solid_to_others(one, hands_on=True)[met.sphere]
    counts &= solid_to_others(other, hands_on=True)[met.other_sphere]
    return float(-met.distance[counts].min()) if counts.any() else 0.0


def alone(situation):
    """Somebody's hands where they would be without others."""
    return with_hands(situation.at_rest)


def misses(situation):
    return sum(float(miss[0]) for miss in situation.hand_miss.values())


@pytest.fixture
def met(study_of):
    """Two people who would touch each other if each were alone: as they rest."""
    there = present_people(
        study_of(Sitter(1850, 40, 20, "throttle"), Sitter(1850, 40, 20, "mixture"))
    )
    return [mine[0].at_rest for mine in there.situations]


@pytest.mark.parametrize("seed", range(4))
def test_hands_are_on_their_controls_and_clear_of_others(study_of, seed):
    there = present_people(study_of(*drawn(np.random.default_rng(seed))))
    one, other = (mine[0] for mine in there.situations)
    assert depth(alone(one), alone(other)) > 0.01
    assert depth(one, other) == 0.0
    assert misses(one) <= misses(alone(one)) and misses(other) <= misses(alone(other))


def test_the_first_keeps_to_comfort_and_the_same_bytes_come_twice(met):
    one, other = hands_together(met)
    np.testing.assert_array_equal(one.poses.rotations, alone(met[0]).poses.rotations)
    for now, again in zip((one, other), hands_together(met), strict=True):
        np.testing.assert_array_equal(now.poses.rotations, again.poses.rotations)


def test_in_either_order_everybody_has_the_same_posture_and_nobody_is_in_the_other(met):
    one, other = hands_together(met)
    for now, again in zip((other, one), hands_together(met[::-1]), strict=True):
        np.testing.assert_array_equal(now.poses.rotations, again.poses.rotations)
    assert depth(one, other) == 0.0 and misses(one) == misses(other) == 0.0


def test_who_is_in_nobodys_way_is_as_alone(study_of):
    apart = study_of(Sitter(1600, 0, 0, "left_stick"), Sitter(1600, 0, 0, "right_air_vent"))
    one, other = (mine[0] for mine in present_people(apart).situations)
    assert depth(alone(one), alone(other)) == 0.0
    for situation in (one, other):
        np.testing.assert_array_equal(situation.poses.rotations, alone(situation).poses.rotations)


def test_of_two_hands_that_do_not_both_hold_one_holds_and_the_other_is_told(study_of):
    both = Sitter(1900, 40, 20, "parking_brake")
    there = present_people(study_of(both, both))
    people = [mine[0] for mine in there.situations]
    assert depth(*people) == 0.0
    assert [misses(alone(one)) for one in people] == [0.0, 0.0]
    kept, holder = sorted(people, key=misses, reverse=True)
    assert misses(holder) == 0.0 and 5e-3 < misses(kept) < 20e-3
    (told,) = [one.sentence for one in there.short if "hand stays" in one.words]
    hand, other = {"a": ("right", "b"), "b": ("left", "a")}[kept.place.role]
    assert told == (
        f"{kept.place.role}, flying: the {hand} hand stays {1e3 * misses(kept):.1f} mm short of "
        f"parking_brake: kept off by {other}: no posture was found in which all hands are on their controls "
        "and nobody touches another"
    )


def test_two_hands_make_room_on_one_lever(study_of):
    there = present_people(
        study_of(Sitter(1800, 40, 20, "throttle"), Sitter(1800, 40, 20, "throttle"))
    )
    one, other = (mine[0] for mine in there.situations)
    assert depth(one, other) == 0.0 and misses(one) == misses(other) == 0.0


def test_people_of_a_population_keep_clear_each_by_itself(seated):  # noqa: F811 (a fixture)
    _, (situation,) = seated
    whose = with_hands(situation)
    arm = whose.placed.of_person(0, np.array([0]))
    beside = arm.centres + np.array([0.03, -0.09, 0.03])
    solid = np.isin(arm.body.sphere_segment, [arm.body.segment(n) for n in ("RLA", "RHN")])
    other = Bystander("other", replace(arm, centres=beside), solid)
    heeding = replace(situation, bystanders=(other,))
    everybody = with_hands(heeding)
    some = np.array([5, 2])
    lone = with_hands(heeding.rows(some))
    np.testing.assert_array_equal(everybody.poses.rotations[some], lone.poses.rotations)
    assert not np.array_equal(everybody.poses.rotations, whose.poses.rotations)


def test_the_bench_has_them_where_a_run_has_them(study_of):
    study = study_of(Sitter(1850, 40, 20, "throttle"), Sitter(1850, 40, 20, "mixture"))
    opened = open_study(study)
    placement = placed_people(opened, opened.start)
    for person, (situation,) in zip(
        placement.people, present_people(study).situations, strict=True
    ):
        np.testing.assert_array_equal(person.poses.rotations, situation.poses.rotations)
    again = placed_people(opened, opened.start, before=placement)
    assert all(now is then for now, then in zip(again.people, placement.people, strict=True))


def test_bystanders_without_an_environment_are_refused(one_arm, bubbleman):
    placed = wb.place(one_arm, wb.pose(one_arm, {}))
    other = Bystander("other", placed, np.ones(len(one_arm.sphere_names), bool))
    pose = wb.pose(bubbleman, {})
    arm = wb.limb(bubbleman, "right hand")
    with pytest.raises(wb.UsageError, match="bystanders"):
        wb.reach(bubbleman, pose, [[0.4, -0.2, 0.8]], limb=arm, bystanders=[other])
    two = wb.place(one_arm, wb.join_poses([wb.pose(one_arm, {})] * 2))
    with pytest.raises(wb.UsageError, match="one pose"):
        Bystander("other", two, other.solid)


def ways(situation, hand, draws):
    """Postures [(S, 3) centres] that bring a hand to its control, by random restarts of a search
    with kinematics of its own, nobody else being there."""
    name = situation.work.aims.controls[hand]
    control = next(one for one in situation.environment.controls if one.name == name)
    body = situation.body
    rest = situation.taken.poses
    pose = wb.Poses(rest.rotations, rest.reference, rest.world_from_reference)
    base = wb.place(body, pose).world_from_segment[
        0, [body.segment("UT"), body.segment("LT")], :, 3
    ]
    around = Surroundings(
        situation.environment,
        situation.place.moving_parts,
        base,
        float(body.radius.max()) + 2e-3,
    )
    found = []
    for zone in range(1, control.zone + 1):
        arm = wb.limb(body, hand, grip=control.grip, zone=zone)
        judge = Judge(body, arm, pose, around, situation.displacement[0])
        for seed in range(draws):
            verdict = judge.judge(control.at, restarts=12, seed=1 + 1_000_003 * seed)
            if verdict.attempt >= 0:
                found.append(wb.place(body, judge.posed(verdict.angles)).centres[0])
    return found


def sampled_apart(one, other, draws):
    """Whether two of the postures sampled of two people do not touch."""
    counts = [solid_to_others(person, hands_on=True) for person in (one, other)]
    radii = [person.body.radius[0, some] for person, some in zip((one, other), counts, strict=True)]
    room = radii[0][:, None] + radii[1][None]
    theirs = [centres[counts[1]] for centres in ways(other, "left hand", draws)]
    for centres in ways(one, "right hand", draws):
        for beside in theirs:
            square = np.sum((centres[counts[0]][:, None] - beside[None]) ** 2, axis=2)
            if np.all(square >= room**2):
                return True
    return False


@pytest.mark.nightly
def test_who_is_said_to_be_kept_off_by_others_is_so_for_a_slow_sampler(study_of):
    """Somebody holds the parking brake, low between the seats, and the other's control is moved so
    near to it that there is often no room for two hands; at most other controls they make room."""
    wrong = judged = 0
    for seed in range(48):
        rng = np.random.default_rng(100 + seed)
        pair = drawn(rng)
        pair[0].control = "parking_brake"
        study = study_of(*pair)
        way = rng.normal(size=3) * (0.3, 1.0, 1.0)
        controls = {one.name: one for one in study.environment.controls}
        near = controls[pair[0].control].at + rng.uniform(0.0, 0.04) * way / np.linalg.norm(way)
        moved = replace(controls[pair[1].control], at=tuple(near.tolist()), part="")
        every = tuple({**controls, moved.name: moved}.values())
        environment = replace(study.environment, controls=every)
        there = present_people(replace(study, environment=environment))
        one, other = (mine[0] for mine in there.situations)
        assert depth(one, other) == 0.0
        reached = misses(alone(one)) == misses(alone(other)) == 0.0
        if reached and misses(one) + misses(other) > 0.0:
            judged += 1
            wrong += sampled_apart(one, other, draws=8)
    assert judged >= 10 and wrong <= 0.1 * judged
