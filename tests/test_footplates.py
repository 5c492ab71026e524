"""Footplates and levers on a seat: to who sits there it is all one where the seat is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import workbench as wb

COUNTER = Path(__file__).parents[1] / "environments" / "counter"
STUDY = """
study: chair
length: mm
environment: chair
people: {guest: {body: adult_male, detail: coarse, seat: wheelchair, position: {forward: FORWARD}}}
cases:
  - name: rolling
    people:
      guest: {predicted: {hands: {right: stick}, feet: {left: left_footplate, right: right_footplate}}}
criteria:
  - {name: feet, check: pedals}
  - {name: stick, check: reach, controls: [stick, left_footplate, right_footplate]}
"""


def rolled_studies(folder, study):
    """Two studies of a wheelchair with a stick on its armrest, 120 mm back and 20 mm back."""
    place = folder / "environments" / "chair"
    place.mkdir(parents=True)
    for file in ("counter.obj", "environment.yaml"):
        text = (COUNTER / file).read_text()
        text = text.replace("environment: counter", "environment: chair")
        stick = "  stick: {at: [250, -260, 720], grip: grasp, zone: 1, part: right_armrest}\n"
        (place / file).write_text(text.replace("controls:\n", f"controls:\n{stick}"))
    (folder / "studies").mkdir()
    for forward in ("-120", "-20"):
        path = folder / "studies" / f"at{forward}.yaml"
        path.write_text(study.replace("FORWARD", forward))
        yield path


@pytest.fixture(scope="module")
def rolled(tmp_path_factory):
    """The same man in both."""
    studies = rolled_studies(tmp_path_factory.mktemp("chair"), STUDY)
    return [wb.run(wb.load_study(path)) for path in studies]


def test_the_force_on_a_stick_of_the_chair_is_the_same_wherever_the_chair_stands(tmp_path):
    force = "  - {name: push, check: force, controls: [stick], direction: [1, 0, 0], at_least: 60, capable: 75}\n"
    people = "population: {people: 4, seed: 2}, "
    study = STUDY.replace("seat: wheelchair", people + "seat: wheelchair")
    found = [
        wb.run(wb.load_study(path)).population.margin[:, 0]
        for path in rolled_studies(tmp_path, study.split("criteria:")[0] + "criteria:\n" + force)
    ]
    assert np.ptp(found[0]) > 0.0 and found[0].max() > -0.06  # somebody pushes
    np.testing.assert_allclose(found[1], found[0], atol=5e-4)  # half a newton


def test_who_rolls_reaches_what_is_on_the_chair_alike_and_no_pedal_is_too_near(rolled):
    one, other = (result.postures[0] for result in rolled)
    assert [verdict.passed for verdict in one.verdicts] == [True, True]
    for mine, yours in zip(one.reaches, other.reaches, strict=True):
        assert (mine.control, mine.reached) == (yours.control, yours.reached)
        if mine.spare is not None:
            assert mine.spare == pytest.approx(yours.spare, abs=2e-3)
    np.testing.assert_allclose(
        one.people[0].poses.rotations, other.people[0].poses.rotations, atol=1e-4
    )
    assert not [words for words in (*one.warnings, *other.warnings) if "pedal" in words]
    at = {control.name: control.at for control in other.environment.controls}
    rest = {control.name: control.at for control in one.environment.controls}
    assert np.subtract(at["stick"], rest["stick"]) == pytest.approx([0.1, 0.0, 0.0])
