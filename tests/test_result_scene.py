"""A result is drawn as it was computed: its postures stand in result.json, wherever its study is."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from workbench.cli import main

STUDY = f"""study: elsewhere
length: mm
environment: {ROOT / "environments" / "trainer"}
people:
  pilot: {{body: adult_female, seat: left, size: {{sex: female, measures: {{stature: 1600}}}}}}
cases:
  - name: flying
    people:
      pilot: {{predicted: {{hands: {{left: left_stick, right: throttle}}, eyes: left_design_eye, heels: left_heel,
        feet: {{left: left_seat_left_pedal, right: left_seat_right_pedal}}}}}}
  - {{name: resting, people: {{pilot: {{predicted: {{like: hands_in_lap, eyes: left_design_eye, heels: left_heel}}}}}}}}
criteria:
  - {{name: pedals, check: pedals, cases: [flying]}}
  - {{name: head to canopy, check: clearance, segments: [H], parts: [canopy], at_least: 40}}
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a study that is in no catalogue, and its result."""
    folder = tmp_path_factory.mktemp("project")
    (folder / "elsewhere.yaml").write_text(STUDY)
    code = main(["run", str(folder / "elsewhere.yaml"), "--out", str(folder / "out")])
    assert code in (0, 1)
    return folder


@pytest.fixture(scope="module")
def checked(made):
    """What a run finds of the pilot."""
    return wb.run(wb.load_study(made / "elsewhere.yaml")).postures[0]


@pytest.mark.parametrize("source", ["out", "elsewhere.yaml"])
def test_a_predicted_posture_is_drawn_as_it_was_checked(made, checked, source):
    scene = wb.scene_of(str(made / source), case="flying,resting")
    shown = scene.bodies[0].placed
    assert np.abs(shown.centres - checked.people[0].placed.centres).max() < 1e-6
    assert np.array_equal(shown.body.radius, checked.people[0].body.radius)
    assert np.abs(scene.environment.vertices - checked.environment.vertices).max() < 1e-6


def test_the_study_of_a_result_is_found_by_its_content_or_named(made, tmp_path, capsys):
    picture = tmp_path / "x.png"
    command = ["render", str(made / "out"), "-o", str(picture), "--size", "64x64"]
    assert main(command) == 0
    moved = tmp_path / "away"
    (made / "out").rename(moved)
    try:
        command[1] = str(moved)
        assert main(command) == 3
        assert "name its file by --study" in capsys.readouterr().err
        assert main([*command, "--study", str(made / "elsewhere.yaml")]) == 0
    finally:
        moved.rename(made / "out")
    assert main(["render", "bubbleman", "-o", str(picture), "--study", "trainer_clearance"]) == 2
    assert "bubbleman is no result" in capsys.readouterr().err


def test_tables_hold_the_postures_and_the_placements(made):
    rows = json.loads((made / "out" / "result.json").read_text())["postures"][0]["people"][0]
    posture = rows["postures"][0]
    assert posture["case"] == "flying" and posture["name"] == "predicted"
    assert rows["seat_mm"][1] > 0  # a small pilot raises the seat for the view
    with (made / "out" / "postures.csv").open(newline="") as file:
        angles = [row for row in csv.DictReader(file) if row["case"] == "flying"]
    stated = {(row["joint"], row["motion"]): float(row["angle_deg"]) for row in angles}
    assert stated == {
        (joint, motion): degrees
        for joint, motions in posture["angles_deg"].items()
        for motion, degrees in motions.items()
    }
    with (made / "out" / "placements.csv").open(newline="") as file:
        placed = list(csv.DictReader(file))
    assert [row["case"] for row in placed] == ["flying", "resting"]
    assert [float(placed[0][key]) for key in ("seat_forward_mm", "seat_up_mm")] == rows["seat_mm"]
    assert float(placed[0]["x_mm"]) == posture["position_mm"][0]


def test_a_posture_of_a_result_can_be_taken_on(made, checked):
    """The angles of a result are those of a posture file: the same angles give the same rotations."""
    found = checked.people[0]
    posture = json.loads((made / "out" / "result.json").read_text())["postures"][0]
    held = posture["people"][0]["postures"][0]
    again = wb.pose(found.body, held["angles_deg"], reference=held["reference"])
    same = np.abs(np.sum(again.rotations[0] * found.poses.rotations[0], axis=1))
    assert np.abs(same - 1).max() < 1e-12
