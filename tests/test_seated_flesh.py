"""Hips and thighs spread on a seat: by the body's own factors, once, and only there."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.rows import changed
from workbench import measure, stack_bodies

SPREAD = ("LT", "LUL", "RUL")
TRAINER = """study: sits
length: mm
environment: trainer
people:
  pilot: {{body: {body}, seat: left}}
cases:
  - name: flying
    people:
      pilot: {{predicted: {{hands: {{left: left_stick, right: throttle}}, eyes: left_design_eye,
        heels: left_heel, feet: {{left: left_seat_left_pedal, right: left_seat_right_pedal}}}}}}
criteria:
  - {{name: thighs, check: contact, segments: [LUL, RUL], parts: [left_seat_pan]}}
"""
CAR = """study: sits
length: mm
environment: compact_car
people:
  driver: {{body: {body}, seat: driver}}
cases:
  - name: driving
    people:
      driver: {{driver: {{sex: {sex}, wheel: wheel_centre, h_point: driver_h_point, seed: 11,
        eyes: low_eye, heels: accelerator_heel, hands: {{left: wheel_ten, right: wheel_two}},
        feet: {{left: foot_rest, right: accelerator}}}}}}
criteria:
  - {{name: thighs, check: contact, segments: [LUL, RUL], parts: [driver_seat_pan]}}
"""
TYPICAL = [("adult_male", "male"), ("adult_female", "female")]


@pytest.fixture(scope="module", params=["adult_male", "adult_female", "bubbleman"])
def body(request):
    return wb.load_body(request.param)


def test_hips_are_broader_by_the_stated_factor(body):
    found = measure(body, ["hip_breadth", "hip_breadth_sitting"])
    share = found["hip_breadth_sitting"] / found["hip_breadth"]
    assert share == pytest.approx(body.seated_factors[0, 0], abs=0.01)


def test_only_hips_and_thighs_change_and_only_once(body):
    sitter = wb.seated(body)
    moved = np.linalg.norm(sitter.centre - body.centre, axis=2)[0] > 1e-12
    there = np.isin(np.array(body.segments)[body.sphere_segment], SPREAD)
    assert moved.any()
    assert not np.any(moved & ~there)
    assert np.all(sitter.radius[0, ~there] == body.radius[0, ~there])
    assert wb.seated(sitter) is sitter


def test_its_spheres_stay_inside_their_enclosing_spheres(body):
    sitter = wb.seated(body)
    middle = sitter.enclosing_centre[0, sitter.sphere_segment]
    far = np.linalg.norm(sitter.centre[0] - middle, axis=1) + sitter.radius[0]
    assert np.all(far <= sitter.enclosing_radius[0, sitter.sphere_segment] + 1e-9)


def test_measures_are_the_same_before_and_after_on_a_seat(body):
    names = ["sitting_height", "thigh_clearance", "hip_breadth_sitting", "buttock_knee_length"]
    before = measure(body, names)
    after = measure(wb.seated(body), names)
    assert after == pytest.approx(before, abs=1e-9)


def test_rows_spread_as_each_by_itself(body):
    stout = changed(body, radius=1.05 * body.radius[0])
    both = wb.seated(stack_bodies([body, stout]))
    for row, one in enumerate((body, stout)):
        alone = wb.seated(one)
        assert np.array_equal(both.centre[row], alone.centre[0])
        assert np.array_equal(both.radius[row], alone.radius[0])


def test_a_body_without_factors_stays_as_it_is(one_arm):
    child = wb.load_body("child_6")
    assert wb.seated(child) is child
    assert wb.seated(one_arm) is one_arm


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_factor_that_nobody_has_is_refused_with_its_place(tmp_path, factor):
    from tests.conftest import ROOT

    text = (ROOT / "bodies" / "bubbleman.yaml").read_text(encoding="utf-8")
    path = tmp_path / "broad.yaml"
    path.write_text(text.replace("breadth: 1.09", f"breadth: {factor}"), encoding="utf-8")
    with pytest.raises(wb.InputError, match=r"broad\.yaml:\d+:\d+: seated\.breadth"):
        wb.load_body(str(path))


@pytest.mark.parametrize("name", [name for name, _ in TYPICAL])
def test_undersides_of_thighs_are_level_with_the_buttocks(name):
    sitter = wb.seated(wb.load_body(name))
    posture = {joint: {"flexion": 90.0} for joint in ("LH", "RH", "LK", "RK")}
    centres = wb.place(sitter, wb.pose(sitter, posture)).centres[0]
    under = centres[:, 2] - sitter.radius[0]
    lowest = {segment: under[sitter.spheres(sitter.segment(segment))].min() for segment in SPREAD}
    assert lowest["LUL"] == pytest.approx(lowest["LT"], abs=0.012)


@pytest.mark.parametrize(("study", "most"), [(TRAINER, 0.045), (CAR, 0.038)])
@pytest.mark.parametrize(("name", "sex"), TYPICAL)
def test_thighs_lie_on_the_cushion_not_deep_in_it(tmp_path, study, most, name, sex):
    path = tmp_path / "sits.yaml"
    path.write_text(study.format(body=name, sex=sex), encoding="utf-8")
    (verdict,) = wb.run(wb.load_study(path)).verdicts
    assert verdict.worst is not None
    assert -most <= verdict.worst.value < 0.02
