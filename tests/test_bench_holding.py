"""The bench says what a change has taken from people: limbs off their controls, thighs in seats."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import ROOT
from workbench.files.study.saving import read_text
from workbench.model.surroundings import Move
from workbench.posture.reaching.limbs import FEET, HANDS, limb
from workbench.study.bench.answers import answer, near_pairs
from workbench.study.bench.edits import seated, shifted
from workbench.study.bench.edits_people import SizeWanted, sized
from workbench.study.bench.edits_postures import predicted, suggested
from workbench.study.bench.holding import limbs_off, troubles
from workbench.study.bench.placing import placed_environment, placed_people
from workbench.study.bench.saving import save

LIMBS = (*HANDS, *FEET)
CONTROLS = {
    "left hand": "left_stick",
    "right hand": "throttle",
    "left foot": "left_seat_left_pedal",
    "right foot": "left_seat_right_pedal",
}
"""What the pilot of the study holds."""


@pytest.fixture(scope="module")
def small_woman(trainer):
    """The pilot is a woman of 1550 mm, in the same posture and seat position."""
    edit = sized(trainer, trainer.start, "pilot", SizeWanted("female", {"stature": 1.55}))
    return placed_people(trainer, edit.arrangement)


def distances(opened, there):
    """[m] of each limb of the pilot to its control, by its grip."""
    person = there.people[0]
    controls = {one.name: one for one in placed_environment(opened, there).controls}
    found = {}
    for name, control in CONTROLS.items():
        grip = "ball" if name in FEET else controls[control].grip
        one = limb(person.body, name, grip=grip)
        world = person.placed.world_from_segment[0, one.end]
        tip = world[:, :3] @ one.tip[0] + world[:, 3]
        found[name] = float(np.linalg.norm(tip - controls[control].at))
    return found


def test_of_a_smaller_person_each_limb_that_left_its_control_is_said_in_mm(trainer, small_woman):
    far = distances(trainer, small_woman)
    found = troubles(trainer, answer(small_woman), 0)
    assert found.offer == "predict" and len(found.words) == 1
    for name, control in CONTROLS.items():
        assert f"{name} {1e3 * far[name]:.0f} mm from {control.replace('_', ' ')}" in found.words[0]
    assert far["left foot"] > 0.08


def test_as_opened_and_with_nothing_held_nothing_is_said(trainer, placement):
    found = answer(placement)
    assert [troubles(trainer, found, row).words for row in (0, 1)] == [(), ()]


@settings(max_examples=10)
@given(
    forward=st.floats(-0.09, 0.09),
    pedal=st.tuples(*[st.floats(-0.06, 0.06)] * 3),
)
def test_a_limb_is_off_where_it_is_20_mm_farther_than_before(trainer, placement, forward, pedal):
    before = distances(trainer, placement)
    state = seated(trainer, trainer.start, "pilot", forward, 0.0).arrangement
    state = shifted(trainer, state, Move((), ("left_seat_left_pedal",), pedal)).arrangement
    there = placed_people(trainer, state)
    far = distances(trainer, there)
    found = {one.limb: one.distance for one in limbs_off(trainer, there, 0, LIMBS)}
    assert found == {name: far[name] for name in far if far[name] > before[name] + 0.02}


def test_a_prediction_says_how_deep_the_thighs_are_and_the_seat_may_go_along(trainer, small_woman):
    wanted = suggested(trainer, small_woman, 0, LIMBS)
    assert wanted.controls == CONTROLS  # also what the hands and feet have left
    held = predicted(trainer, small_woman, "pilot", wanted).arrangement
    found = answer(placed_people(trainer, held))
    said = troubles(trainer, found, 0)
    deep = re.search(r"thighs press (\d+) mm deep into the front of left seat pan", str(said.words))
    least = min(pair.distance for pair in near_pairs(found) if pair.target == "left_seat_pan")
    assert int(deep[1]) == pytest.approx(-1e3 * least, abs=1.0) and said.offer == "free"
    edit = predicted(trainer, small_woman, "pilot", replace(wanted, free=True))
    assert edit.words == (
        "pilot: the posture of 3 cases is predicted; joints that were turned beside the posture's "
        "own are given up in looking left"
    )
    assert edit.arrangement.people[0].free
    feet = {limb: name for limb, name in CONTROLS.items() if "foot" in limb}
    idle = predicted(trainer, small_woman, "pilot", replace(wanted, controls=feet)).words
    assert "the left hand and the right hand hold no control and stay as in posture driving" in idle


def test_a_seat_without_travel_is_not_offered_to_go_along(trainer, small_woman):
    wanted = suggested(trainer, small_woman, 0, LIMBS)
    held = predicted(trainer, small_woman, "pilot", wanted).arrangement
    found = answer(placed_people(trainer, held))
    still = {"travel_forward": (0.0, 0.0), "travel_up": (0.0, 0.0)}
    environment = trainer.study.environment
    seats = tuple(replace(seat, **still) for seat in environment.seats)
    study = replace(trainer.study, environment=replace(environment, seats=seats))
    said = troubles(replace(trainer, study=study), found, 0)
    assert said.words and said.offer == ""


def test_all_cases_are_predicted_each_from_what_it_holds_and_saved(trainer, placement, tmp_path):
    wanted = replace(suggested(trainer, placement, 0, LIMBS), like="driving", everywhere=True)
    after = predicted(trainer, placement, "pilot", wanted).arrangement
    actions = after.people[0].actions
    assert [one.like for one in actions] == ["driving", "flying", "flying"]
    assert all(dict(one.aims.controls) == CONTROLS for one in actions)
    assert not after.people[0].free
    path = tmp_path / "trainer.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    save(trainer, read_text(path), after)
    assert [case.actions[0].like for case in wb.load_study(path).postures] == [
        "driving",
        "flying",
        "flying",
    ]
