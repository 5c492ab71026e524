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


@pytest.fixture(scope="module")
def rolled(tmp_path_factory):
    """The same man in a wheelchair with a stick on its armrest, 120 mm back and 100 mm ahead."""
    folder = tmp_path_factory.mktemp("chair")
    place = folder / "environments" / "chair"
    place.mkdir(parents=True)
    for file in ("counter.obj", "environment.yaml"):
        text = (COUNTER / file).read_text()
        text = text.replace("environment: counter", "environment: chair")
        stick = "  stick: {at: [250, -260, 720], grip: grasp, zone: 1, part: right_armrest}\n"
        (place / file).write_text(text.replace("controls:\n", f"controls:\n{stick}"))
    (folder / "studies").mkdir()
    found = []
    for forward in ("-120", "-20"):
        path = folder / "studies" / f"at{forward}.yaml"
        path.write_text(STUDY.replace("FORWARD", forward))
        found.append(wb.run(wb.load_study(path)))
    return found


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
