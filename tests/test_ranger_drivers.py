"""Drawn people drive the utility vehicle: its bench stands too high for a car driver's posture, so
theirs is predicted; where they sit they reach its wheel and pedals."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import workbench as wb
from tests.conftest import SHARED, needs_real_input
from workbench import load_study

MESH = SHARED / "environments" / "polaris_ranger_ev" / "polaris.dae"
DATA = Path(__file__).parent / "data"
pytestmark = needs_real_input(MESH)
STUDY = """
study: ranger_drivers
length: mm
environment: ranger/environment.yaml
people:
  driver:
    body: adult_male
    detail: coarse
    seat: left
    population: {source: ansur2, people: 4, seed: 3}
cases:
  - name: driving
    people:
      driver: {predicted: {feet: {right: gas_pedal}, heels: floor}}
criteria:
  - {name: the right foot on the gas, check: pedals}
  - {name: pedals, check: reach, controls: [gas_pedal, brake_pedal]}
  - {name: wheel, check: reach, controls: [steering_wheel]}
changes:
  - {name: the gas pedal 20 mm aft, control: gas_pedal, move: [-20, 0, 0]}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The vehicle beside a study, with a point on its floor and one where its bench has hips."""
    folder = tmp_path_factory.mktemp("ranger_drivers")
    (folder / "ranger").mkdir()
    shutil.copyfile(MESH, folder / "ranger" / MESH.name)
    text = (DATA / "ranger_environment.yaml").read_text(encoding="utf-8")
    text = text.replace("points:\n", "points:\n  floor: [480, 137, 393]\n  hips: [-80, 300, 945]\n")
    (folder / "ranger" / "environment.yaml").write_text(text, encoding="utf-8")
    return folder


def test_its_bench_is_too_high_for_a_car_drivers_posture_and_that_is_said(folder):
    (folder / "car.yaml").write_text(
        STUDY.replace("predicted: {", "driver: {wheel: wheel_centre, h_point: hips, seed: 1, ")
    )
    with pytest.raises(wb.InputError, match=r"100 to 500 mm above the heel \(H30\), got 552 mm"):
        wb.run(load_study(folder / "car.yaml"))


@pytest.mark.nightly
def test_drawn_people_reach_its_wheel_and_pedals_from_the_bench(folder):
    """The wheel by everybody; the pedals by most: bench, floor and dash are one part, and who sits
    with a thigh in the bench's front edge (at best by 19 mm, with the heel lifted by 25 mm) is kept."""
    (folder / "study.yaml").write_text(STUDY)
    result = wb.run(load_study(folder / "study.yaml")).population
    share = dict(zip((r.name for r in result.requirements), result.single.tolist(), strict=True))
    assert share["reach steering_wheel"] == 1
    assert min(share.values()) >= 0.75
    assert all("Ranger" in reason.text for reason in result.reasons), result.reasons
