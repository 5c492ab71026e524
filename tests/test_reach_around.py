"""People led around obstacles: whoever is said to be kept from a target is, whoever else is asked."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.reach_oracle import clear_ways
from workbench.shape.parts import moved
from workbench.shape.scaling.scale import scale
from workbench.solve.reaching.limbs import limb
from workbench.solve.reaching.reach_people import reach_people

MEASURES = ({"stature": 1.56}, {"stature": 1.66}, {"stature": 1.75}, {"stature": 1.86})
HOW = {"name": "left hand", "grip": "grasp", "zone": 2}
CONTROLS = ("left_canopy_latch", "throttle", "parking_brake", "alternate_air")


@pytest.fixture(scope="module")
def people(bubbleman):
    return [scale(bubbleman, measures) for measures in MEASURES]


@pytest.fixture(scope="module")
def seated(people):
    legs = {"LH": {"flexion": 80}, "RH": {"flexion": 80}, "LK": {"flexion": 70}, "RK": {"flexion": 70}}
    return wb.join_poses([wb.pose(body, legs, reference="LT", position=(0.17, 0.28, 0.38)) for body in people])


@pytest.fixture(scope="module")
def trainer():
    return wb.load_environment("trainer")


@pytest.fixture(scope="module")
def controls(trainer):
    return np.array([control.at for name in CONTROLS for control in trainer.controls if control.name == name])


def row(poses, b):
    return wb.Poses(poses.rotations[b : b + 1], poses.reference, poses.world_from_reference[b : b + 1])


def _false_misses(people, seated, trainer, controls, how, *, draws, keep):
    """(person, target) said to be kept from a target by more than 5 mm by obstacles alone, that a drawn posture
    reaches; and how many were looked at."""
    seat = trainer.seat("left")
    shift = np.zeros((len(people), 3))
    free = reach_people(people, seated, controls, **how)
    found = reach_people(people, seated, controls, environment=trainer, moves=seat.moves, shift=shift, **how)
    kept = np.argwhere(free.reached & ~found.reached & (found.miss + found.overlap > 5e-3))
    wrong = []
    for b, t in kept:
        arm = limb(people[b], how["name"], grip=how["grip"], zone=how["zone"])
        room = moved(trainer, seat.moves, shift[b])
        ways = clear_ways(people[b], arm, row(seated, b), controls[t], room, draws=draws, keep=keep, seed=1)
        wrong += [(int(b), CONTROLS[t])] * bool(len(ways))
    return wrong, len(kept)


def test_whoever_is_kept_from_a_control_has_no_clear_way_among_many_drawn(people, seated, trainer, controls):
    wrong, _ = _false_misses(people[1::2], seated_of(seated, [1, 3]), trainer, controls, HOW, draws=20000, keep=300)
    assert not wrong


@pytest.mark.nightly
@pytest.mark.parametrize("zone", [1, 2, 3])
@pytest.mark.parametrize(("name", "grip"), [("left hand", "grasp"), ("right hand", "grasp"), ("left hand", "push")])
def test_nobody_kept_from_a_control_has_a_clear_way_among_thousands_drawn(
    people, seated, trainer, controls, name, grip, zone
):
    how = {"name": name, "grip": grip, "zone": zone}
    wrong, asked = _false_misses(people, seated, trainer, controls, how, draws=100_000, keep=3000)
    assert len(wrong) <= 0.02 * asked


def seated_of(poses, rows):
    return wb.Poses(poses.rotations[rows], poses.reference, poses.world_from_reference[rows])


def test_who_reaches_does_not_depend_on_who_else_is_asked(people, seated, trainer, controls):
    seat = trainer.seat("left")
    where = {"environment": trainer, "moves": seat.moves}
    together = reach_people(people, seated, controls, shift=np.zeros((4, 3)), **where, **HOW)
    for b, body in enumerate(people):
        alone = reach_people([body], row(seated, b), controls, shift=np.zeros((1, 3)), **where, **HOW)
        assert list(alone.reached[0]) == list(together.reached[b])
        np.testing.assert_allclose(alone.miss[0][alone.reached[0]], together.miss[b][together.reached[b]], atol=1e-4)


def test_a_hand_that_is_led_around_enters_nothing_and_keeps_its_stops(people, seated, trainer, controls):
    seat, shift = trainer.seat("left"), np.zeros((4, 3))
    found = reach_people(people, seated, controls, environment=trainer, moves=seat.moves, shift=shift, rotations=True,
                         **HOW)  # fmt: skip
    for b, body in enumerate(people):
        arm = limb(body, "left hand", grip="grasp", zone=2)
        world = np.repeat(seated.world_from_reference[b : b + 1], len(controls), axis=0)
        poses = wb.Poses(found.rotations[b], seated.reference, world)
        met = wb.contacts(wb.place(body, poses), moved(trainer, seat.moves, shift[b]))
        met = met.rows(arm.solid[met.sphere] & (met.excess > 0))
        assert not set(met.pose) & set(np.flatnonzero(found.reached[b]))
        assert np.degrees(wb.stops(body, poses).margin[:, list(arm.free)].min()) > -0.1
    assert found.reached.any()
