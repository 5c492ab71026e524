"""A study has the same answers mirrored, turned, moved, in other units and in another order."""

from __future__ import annotations

import re

import pytest

from tests.conftest import ROOT
from tests.same_study import Same, answers, differences, write_plain, write_same

AIRCRAFT = ROOT.parent / "shared" / "cases" / "grob"

TOLERANCE = 1e-5
"""What two runs may differ by [m, rad or mm]: kernels work in single precision far from the origin."""
KEPT_OFF = 2e-3
"""What is told of how far a hand stays off what it does not reach may differ by so much [m]."""
OTHERWISE = Same(
    mirrored=True, turned=90.0, moved=(10.0, -10.0, 0.0), unit="in", order=3, y_up=True
)
EACH = {
    "mirrored": Same(mirrored=True),
    "turned by a right angle": Same(turned=90.0),
    "turned": Same(turned=37.0),
    "moved": Same(moved=(10.0, -10.0, 0.0)),
    "in inches": Same(unit="in"),
    "in another order": Same(order=3),
    "y up": Same(y_up=True),
}
REACH = """study: two_reach
length: mm
environment: trainer
people:
  small woman:
    body: bubbleman
    size: {sex: female, measures: {stature: 1525, sitting_height: 803, buttock_knee_length: 541}}
    seat: left
  large man: {body: bubbleman, size: {sex: male, measures: {stature: 1870, sitting_height: 977}}, seat: right}
cases:
  - name: flying
    people:
      small woman: {predicted: {hands: {left: left_stick, right: throttle}, eyes: left_design_eye,
        heels: left_heel, feet: {left: left_seat_left_pedal, right: left_seat_right_pedal}}}
      large man: {predicted: {hands: {left: mixture, right: right_stick}, eyes: right_design_eye,
        heels: right_heel, feet: {left: right_seat_left_pedal, right: right_seat_right_pedal}}}
criteria:
  - {name: flying controls, check: reach, people: [small woman], controls: [left_stick, throttle]}
  - {name: engine, check: reach, controls: [propeller, canopy_handle]}
  - {name: joints, check: stops}
  - {name: view, check: view_over, parts: [coaming, forward_deck], down: 10}
  - {name: apart, check: between_people, at_least: 0}
"""
PEOPLE = """study: few_people
length: mm
environment: trainer
people:
  pilot: {body: bubbleman, seat: left, population: {source: ansur2, people: 3, seed: 1}}
cases:
  - name: flying
    people:
      pilot: {predicted: {hands: {left: left_stick, right: throttle}, eyes: left_design_eye,
        heels: left_heel, feet: {left: left_seat_left_pedal, right: left_seat_right_pedal}}}
criteria:
  - {name: controls, check: reach, controls: [left_stick, throttle, left_canopy_latch]}
  - {name: eyes, check: eye_height, below: 25, above: 40}
  - {name: pedals, check: pedals}
  - {name: shoulder, check: clearance, segments: [LSM], parts: [canopy, left_sill], at_least: 15}
  - {name: knees, check: clearance, segments: [RUL, RLL], parts: [instrument_panel], at_least: 25}
"""
DRIVER = """study: driver
length: mm
environment: compact_car
people:
  driver: {body: bubbleman, seat: driver}
cases:
  - name: driving
    people:
      driver: {driver: {sex: male, wheel: wheel_centre, h_point: driver_h_point, seed: 11, eyes: low_eye,
        heels: accelerator_heel, hands: {left: wheel_ten, right: wheel_two},
        feet: {left: foot_rest, right: accelerator}}}
criteria:
  - {name: seat, check: preferred_seat}
  - {name: pedals, check: pedals}
  - {name: rim, check: reach, controls: [wheel_ten, turn_signal]}
  - {name: knees, check: clearance, segments: [RUL, RLL], parts: [column_shroud], at_least: 50}
"""
MOTION = """study: motion
length: mm
environment: trainer
people:
  pilot: {body: bubbleman}
cases:
  - {name: crash, people: {pilot: {motion: {file: motions/trainer_lap.csv, every: 20}}}}
signals: {points: [{name: head, segment: H}, {name: hand, segment: LHN, at: [10, 20, 30]}]}
contact_forces:
  - {parts: ["*"], segments: [H, N, UT, CT], stiffness: 150, returned: 0.2}
criteria:
  - {name: head free of the cockpit, check: contact, segments: [H, N]}
  - {name: left arm, check: clearance, segments: [LUA, LLA], parts: [left_stick], at_least: 10}
  - {name: head excursion, check: excursion, segments: [H], at_most: 550, direction: [1, 0, 0], origin: [0, 280, 280]}
  - {name: joints, check: stops, at_least: -20}
"""


STANDING = """study: standing
length: mm
environment: trainer
people:
  worker:
    body: bubbleman
    stand: {on: [-200, 1050, 0], yaw: -90, area: {forward: [-100, 200], left: [-150, 100]}}
cases:
  - {name: works, people: {worker: {predicted: {hands: {right: left_canopy_latch}}}}}
criteria:
  - {name: latch, check: reach, people: [worker], controls: [left_canopy_latch]}
  - {name: clear, check: clearance, segments: [RHN, RLA], parts: ["*"], at_least: 5}
  - {name: stops, check: stops}
"""


RUN: dict[str, object] = {}
"""The answers of studies as they are, by their texts: one run for all other ways to write them."""


def as_it_is(study, folder):
    text = study.read_text()
    if text not in RUN:
        RUN[text] = answers(write_same(study, folder / "as_it_is", Same()), Same())
    return RUN[text]


def unlike(study, folder, how, tolerance=TOLERANCE):
    """The largest differences that another way of writing a study makes to its answers."""
    found = answers(write_same(study, folder / "otherwise", how), how)
    return differences(as_it_is(study, folder), found, tolerance)[:5]


@pytest.mark.parametrize(
    "text", [REACH, PEOPLE, DRIVER, MOTION], ids=["reach", "people", "driver", "motion"]
)
def test_a_study_written_otherwise_has_the_same_answers(tmp_path, text):
    study = tmp_path / "study.yaml"
    study.write_text(text)
    (tmp_path / "motions").symlink_to(ROOT / "studies" / "motions")
    assert unlike(study, tmp_path, OTHERWISE) == []


def test_a_study_of_postures_written_otherwise_has_the_same_answers(tmp_path):
    study = ROOT / "studies" / "trainer_clearance.yaml"
    assert unlike(study, tmp_path, OTHERWISE) == []


@pytest.mark.nightly
@pytest.mark.parametrize("how", EACH.values(), ids=EACH)
@pytest.mark.parametrize("name", ["trainer_clearance", "trainer_reach"])
def test_a_shipped_study_has_the_same_answers(tmp_path, name, how):
    assert unlike(ROOT / "studies" / f"{name}.yaml", tmp_path, how) == []


@pytest.mark.nightly
@pytest.mark.parametrize("how", EACH.values(), ids=EACH)
def test_a_hand_that_obstacles_keep_off_stays_as_far_off(tmp_path, how):
    study = tmp_path / "study.yaml"
    study.write_text(STANDING)
    if not how.mirrored:
        assert unlike(study, tmp_path, how) == []
        return
    # who bends with left and right exchanged stands 0.3 um aside; of the ways in which the hand may
    # hang there as near, one or another is found
    found, mirrored = (
        {key: far for key, far in of.items() if key[-1] == "miss" or key[-1] == "passed"}
        for of in (
            as_it_is(study, tmp_path),
            answers(write_same(study, tmp_path / "otherwise", how), how),
        )
    )
    assert len(found) == 6 and differences(found, mirrored, KEPT_OFF) == []


@pytest.mark.nightly
@pytest.mark.parametrize("how", EACH.values(), ids=EACH)
def test_people_in_a_real_light_aircraft_have_the_same_answers(tmp_path, how):
    if not AIRCRAFT.exists():
        pytest.skip("the light aircraft of ../shared is not here")
    study = tmp_path / "fit.yaml"
    text = re.sub("people: 60", "people: 6", (AIRCRAFT / "fit.yaml").read_text())
    study.write_text("".join(line for line in text.splitlines(True) if "nine in ten" not in line))
    write_plain(AIRCRAFT / "environment.yaml", tmp_path)
    assert unlike(study, tmp_path, how) == []


@pytest.mark.nightly
@pytest.mark.parametrize(
    "how", [Same(turned=37.0), EACH["moved"], Same(unit="cm", order=5)], ids=repr
)
@pytest.mark.parametrize("name", ["trainer_accommodation", "car_driver"])
def test_people_who_are_asked_whether_they_fit_have_the_same_answers(tmp_path, name, how):
    study = tmp_path / "study.yaml"
    text = (ROOT / "studies" / f"{name}.yaml").read_text()
    study.write_text(re.sub(r"people: \d+", "people: 40", text))
    assert unlike(study, tmp_path, how) == []
