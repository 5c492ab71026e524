"""A result is drawn as it was computed: its postures stand in result.json, wherever its study is."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

import workbench as wb
from tests.accommodations import smaller_study
from tests.conftest import ROOT
from workbench.cli import main
from workbench.report.folder import write_report

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


@pytest.fixture(scope="module")
def crowd(tmp_path_factory):
    """A population's study, what a run finds of it, and the folder with its result."""
    folder = tmp_path_factory.mktemp("crowd")
    study = smaller_study("car_driver", folder, people=8)
    result = wb.run(wb.load_study(study))
    write_report(result, folder / "out")
    return result.population, folder / "out"


def test_the_people_shown_of_a_population_are_drawn_as_they_were_found(crowd):
    """Before, a result of a population held nobody's posture, and could not be drawn."""
    found, folder = crowd
    assert found.shown
    labels = [
        row["person"]
        for row in json.loads((folder / "result.json").read_text())["population"]["hardest"]
    ]
    for number, shown in enumerate(found.shown):
        scene = wb.scene_of(str(folder), case=labels[number])
        assert len(scene.bodies) == 1
        drawn = scene.bodies[0].placed
        np.testing.assert_allclose(drawn.body.radius, shown.placed.body.radius, atol=1e-9)
        np.testing.assert_allclose(drawn.centres, shown.placed.centres, atol=2e-6)
        np.testing.assert_allclose(
            scene.environment.vertices, shown.environment.vertices, atol=2e-6
        )


def test_the_people_shown_hold_their_postures_in_tables(crowd):
    found, folder = crowd
    hard = json.loads((folder / "result.json").read_text())["population"]["hardest"]
    with (folder / "placements.csv").open() as file:
        placements = list(csv.DictReader(file))
    assert [row["person"] for row in placements] == [row["person"] for row in hard]
    for row, one in zip(placements, hard, strict=True):
        assert [float(row[f"{k}_mm"]) for k in "xyz"] == one["posture"]["position_mm"]
        at = 1000 * found.seat[one["row"]]
        seat = [float(row["seat_forward_mm"]), float(row["seat_up_mm"])]
        assert seat == pytest.approx(at, abs=1e-3)
    with (folder / "postures.csv").open() as file:
        angles = list(csv.DictReader(file))
    assert {row["person"] for row in angles} == {row["person"] for row in hard}


def test_everybody_of_a_population_is_drawn_and_those_who_are_held_as_they_are(
    crowd,
):
    """Found again are all those of whom the result holds no posture: here everybody."""
    found, folder = crowd
    rows = json.loads((folder / "result.json").read_text())
    labels = rows["population"]["people"]["label"]
    for hard in rows["population"]["hardest"]:
        hard["posture"] = None
    file = folder.parent / "bare.json"
    file.write_text(json.dumps(rows))
    for shown in found.shown:
        if shown.requirement == np.nanargmin(found.margin[shown.row]):
            scene = wb.scene_of(str(file), case=labels[shown.row])
            drawn = scene.bodies[0].placed
            np.testing.assert_allclose(drawn.centres, shown.placed.centres, atol=1e-5)
            np.testing.assert_allclose(scene.environment.vertices, shown.environment.vertices, atol=2e-6)  # fmt: skip
    held = {shown.row for shown in found.shown}
    other = next(row for row in range(len(labels)) if row not in held)
    scene = wb.scene_of(str(folder), case=labels[other])
    assert len(scene.bodies) == 1 and f"person {labels[other]}" in scene.title


def test_a_person_whom_nobody_knows_is_refused_with_those_there_are(crowd):
    _, folder = crowd
    with pytest.raises(wb.InputError, match=r"has no person 'nobody'; valid: \S+, "):
        wb.scene_of(str(folder), case="nobody")
