"""A vehicle the workbench was not made for: two men on the bench of a utility vehicle whose mesh is
one big part.

The mesh is in inches with its nose along y; the simulator's model file beside it says in metres
where things are.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import workbench as wb
from tests.conftest import SHARED, needs_real_input
from workbench import contacts
from workbench.cli import main
from workbench.files.mesh_report import inspect_environment

MESH = SHARED / "environments" / "polaris_ranger_ev" / "polaris.dae"
DATA = Path(__file__).parent / "data"
pytestmark = needs_real_input(MESH)


@pytest.fixture(scope="module")
def study_file(tmp_path_factory):
    """The study beside a folder with its environment and the mesh."""
    folder = tmp_path_factory.mktemp("vehicle")
    (folder / "ranger").mkdir()
    shutil.copyfile(MESH, folder / "ranger" / MESH.name)
    shutil.copyfile(DATA / "ranger_environment.yaml", folder / "ranger" / "environment.yaml")
    shutil.copyfile(DATA / "ranger_fit.yaml", folder / "ranger_fit.yaml")
    return folder / "ranger_fit.yaml"


@pytest.fixture(scope="module")
def ranger(study_file):
    return wb.load_environment(study_file.parent / "ranger")


@pytest.fixture(scope="module")
def result(study_file):
    return wb.run(wb.load_study(study_file))


@pytest.fixture(scope="module")
def person(result):
    """A person's result by name."""
    return {person.name: person for person in result.postures[0].people}.__getitem__


@pytest.fixture(scope="module")
def boxes(study_file):
    """Least and greatest corner of each part [m]."""
    parts = inspect_environment(study_file.parent / "ranger").parts
    return {part.name: np.array([part.low, part.high]) for part in parts}


def corners(environment, part):
    """(T, 3, 3) the triangles of a part."""
    polygons = environment.polygons(environment.part_index(part))
    first, last = environment.triangle_start[[polygons.start, polygons.stop]]
    return environment.vertices[environment.triangles[first:last]]


def hits(triangles, axis, at):
    """Where a line along `axis` through `at`, two coordinates, meets triangles: the third
    coordinate, rising."""
    flat = np.delete(triangles, axis, axis=2) - at
    area = [np.linalg.det(np.roll(flat, -k, axis=1)[:, 1:]) for k in range(3)]
    weights = np.stack(area, axis=1)
    total = weights.sum(axis=1)
    met = (np.abs(total) > 1e-12) & (np.all(weights >= 0, axis=1) | np.all(weights <= 0, axis=1))
    return np.sort(np.sum(weights[met] / total[met, None] * triangles[met][:, :, axis], axis=1))


def deepest(person, segment, part):
    """Signed distance [mm] of a segment and a part."""
    near = person.clearance
    return 1e3 * near.distance[0, near.body.segment(segment), near.other.part_index(part)]


def test_the_vehicle_is_as_large_as_the_real_one(ranger):
    length, width, height = ranger.bounds[1] - ranger.bounds[0]
    assert 2.7 < length < 2.9
    assert 1.4 < width < 1.5
    assert 1.8 < height < 1.96


@pytest.mark.parametrize(
    ("part", "place", "tolerance"),
    [
        ("Steering_Wheel", (0.34, 0.30, 1.29), 0.03),
        ("Pedal_brake", (0.64, 0.27, 0.58), 0.03),
        ("Pedal_Gas", (0.63, 0.10, 0.58), 0.04),
        # the simulator shifts these parts from where the mesh has them
        ("Front_Wheel_Left", (1.03, 0.60, 0.32), 0.045),
        ("Front_Wheel_Right", (1.03, -0.60, 0.32), 0.045),
        ("Rear_Wheel_Left", (-0.85, 0.60, 0.32), 0.03),
        ("Rear_Wheel_Right", (-0.85, -0.60, 0.32), 0.03),
        ("E-Brake", (0.53, 0.07, 1.10), 0.06),
    ],
)
def test_parts_lie_where_the_simulator_has_them(boxes, part, place, tolerance):
    np.testing.assert_allclose(boxes[part].mean(axis=0), place, atol=tolerance)


def test_left_and_right_are_not_mirrored(boxes):
    assert boxes["Steering_Wheel"][0, 1] > 0.1
    assert boxes["Front_Wheel_Left"][0, 1] > 0.4
    assert boxes["Front_Wheel_Left"][0, 0] > boxes["Rear_Wheel_Left"][1, 0]


@pytest.mark.parametrize("seat", ["left", "right"])
def test_the_seat_planes_lie_on_the_mesh(ranger, seat):
    chair = ranger.seat(seat)
    triangles = corners(ranger, "Ranger")
    x, y, z = chair.srp
    for ahead in (0.1, 0.2, 0.3):
        top = max(hits(triangles, 2, (x + ahead, y + 1e-4)))
        assert top == pytest.approx(z + ahead * np.tan(chair.cushion_angle), abs=0.004)
    for up in (0.15, 0.25, 0.35, 0.45):
        behind = hits(triangles, 0, (y + 1e-4, z + up))
        front = max(behind[behind < 0])
        assert front == pytest.approx(x - up * np.tan(chair.back_angle), abs=0.004)


def test_the_seat_reference_point_is_that_of_the_simulators_boxes(ranger):
    """The top of the cushion's box at 0.86 m, and there the front of a back 60 mm thick that leans
    0.2 rad aft."""
    ahead = -0.3 + 0.03 / np.cos(0.2) + (1.125 - 0.86) * np.tan(0.2)
    assert ranger.seat("left").srp == pytest.approx((ahead, 0.30, 0.86), abs=0.012)


@pytest.mark.parametrize("name", ["driver", "passenger"])
def test_a_sitter_sinks_into_the_cushion_as_far_as_the_seat_says(person, name):
    assert deepest(person(name), "LT", "Ranger") == pytest.approx(-20, abs=2)


@pytest.mark.parametrize("name", ["driver", "passenger"])
def test_a_sitter_leans_on_the_back_with_the_shoulder_blades(person, name):
    """Below the pad the back is open, so the pelvis, which stops at the plane, touches nothing
    there."""
    found = contacts(person(name).placed, person(name).clearance.other)
    blades = found.rows((found.segment == found.body.segment("UT")) & (found.normal[:, 0] > 0.95))
    assert -1e3 * blades.distance.min() == pytest.approx(15, abs=3)


def test_both_hands_hold_the_rim(person):
    for hand in ("LHN", "RHN"):
        assert -15 < deepest(person("driver"), hand, "Steering_Wheel") < 0


def test_the_feet_stand_on_gas_pedal_and_floor(person):
    driver = person("driver")
    assert -20 < deepest(driver, "RF", "Pedal_Gas") < 0
    assert -15 < deepest(driver, "LF", "Ranger") < 0
    assert all(-15 < deepest(person("passenger"), foot, "Ranger") < 0 for foot in ("LF", "RF"))


def test_the_report_names_the_vehicles_parts_and_everything_fits(study_file, capsys):
    assert main(["run", str(study_file), "--out", str(study_file.parent / "out")]) == 0
    said = capsys.readouterr().out
    page = (study_file.parent / "out" / "report.html").read_text(encoding="utf-8")
    for words in ("mm into Ranger", "mm from Steering Wheel", "head (back) is"):
        assert words in said and words in page
    data = json.loads((study_file.parent / "out" / "result.json").read_text(encoding="utf-8"))
    assert data["passed"] is True


def test_a_roll_cage_that_is_too_low_fails_and_says_by_how_much(study_file, capsys):
    strict = study_file.with_name("strict.yaml")
    text = study_file.read_text(encoding="utf-8")
    strict.write_text(
        text.replace("[Ranger], at_least: 50", "[Ranger], at_least: 250"), encoding="utf-8"
    )
    assert main(["run", str(strict), "--out", str(study_file.parent / "strict")]) == 1
    said = capsys.readouterr().out
    assert "FAILED  head to roll cage: driving, " in said
    assert "mm from Ranger" in said
    assert "less than the 250.0 mm asked for" in said


def test_a_joint_past_its_stop_is_warned_of_before_the_open_edges_of_the_mesh(study_file):
    bent = study_file.with_name("bent.yaml")
    text = study_file.read_text(encoding="utf-8").replace(
        "LE RE: {flexion: 41}", "LE RE: {flexion: 150}"
    )
    bent.write_text(text, encoding="utf-8")
    said = wb.run(wb.load_study(bent)).warnings
    assert "driver, driving: left elbow is 8.0 degrees past its stop in flexion" in said[:2]
    assert any("open edges" in line for line in said[2:])


def test_a_mesh_outside_its_folder_is_refused(study_file):
    away = study_file.parent / "away.yaml"
    text = (DATA / "ranger_environment.yaml").read_text(encoding="utf-8")
    away.write_text(text.replace("file: polaris.dae", f"file: {MESH}"), encoding="utf-8")
    with pytest.raises(wb.InputError, match="lies in the folder of its environment file"):
        wb.load_environment(away)
