"""What is probably a mistake is said before anything runs: places and lengths that do not fit."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.conftest import ROOT
from tests.made_seat import corners, obj_text
from workbench.files.environments import load_environment
from workbench.files.kinds import check_file
from workbench.files.seat_doubts import heel_doubts
from workbench.geometry.ground import ground_of

EYE = "left_design_eye: [20, 280, 1053]"
HEEL = "left_heel: [786, 280, 0]"
FLAPS = "flaps: {at: [213, 22, 366], grip: grasp, zone: 2, part: flap_lever}"
TRAVEL = "travel: {forward: [-90, 90], up: [-20, 60]}"
PAN = "left_seat_pan: {allow: [{segments: [LT, LUL, RUL], depth: 45}]}"


def trainer(folder: Path, old: str, new: str) -> Path:
    """A copy of the trainer in which one place of the file is another; its study."""
    copy = folder / "environments" / "trainer"
    shutil.copytree(ROOT / "environments" / "trainer", copy)
    text = (copy / "environment.yaml").read_text()
    assert old in text
    (copy / "environment.yaml").write_text(text.replace(old, new, 1))
    (folder / "studies").mkdir()
    study = folder / "studies" / "study.yaml"
    source = (ROOT / "studies" / "trainer_accommodation.yaml").read_text()
    study.write_text(source.replace("environment: trainer", f"environment: {copy}"))
    return study


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            FLAPS,
            FLAPS.replace("213", "533"),
            "control 'flaps' is 262 mm away from its part 'flap_lever'",
        ),
        (
            FLAPS,
            FLAPS.replace("[213, 22, 366]", "[0.213, 0.022, 0.366]"),
            "control 'flaps' is 263 mm away from its part 'flap_lever': it would be there if its "
            "numbers were 1000 times as large",
        ),
        (
            EYE,
            "left_design_eye: [740, 280, 1053]",
            "point 'left_design_eye' is 344 mm ahead of where the eyes of anybody in seat 'left' "
            "can be",
        ),
        (
            EYE,
            "left_design_eye: [20, 280, 1650]",
            "point 'left_design_eye' is 310 mm above where the eyes of anybody in seat 'left' "
            "can be",
        ),
        (
            EYE,
            "left_design_eye: [20, -280, 1053]",
            "point 'left_design_eye' is 310 mm to the right of where the eyes of anybody in seat "
            "'left' can be",
        ),
        (
            HEEL,
            "left_heel: [786, 280, -52]",
            "point 'left_heel', where the heels stand, is 52 mm under the surface there, 'floor'",
        ),
        (
            HEEL,
            "left_heel: [786, 280, 350]",
            "point 'left_heel', where the heels stand, is 350 mm above the surface there, 'floor'",
        ),
        (
            HEEL,
            "left_heel: [9000, 280, 0]",
            "point 'left_heel': there is no floor under or over it for the heels",
        ),
        (
            TRAVEL,
            "travel: {forward: [-0.09, 0.09], up: [-20, 60]}",
            "seat 'left': its travel forward is 0.18 mm long: a wrong unit of length?",
        ),
        (
            PAN,
            PAN.replace("45", "0.045"),
            "part 'left_seat_pan': contact is allowed down to 0.045 mm: a wrong unit of length?",
        ),
        (
            PAN,
            PAN.replace("LUL", "LTH"),
            "part 'left_seat_pan': contact is allowed to 'LTH', which is no segment of a body",
        ),
        (
            "cushion: {part: left_seat_pan, segments: [LT]",
            "cushion: {part: left_seat_pan, segments: [LTO]",
            "seat 'left': 'LTO' rests on its cushion, which is no segment of a body",
        ),
    ],
)
def test_a_place_that_nobody_means_is_said_with_its_distance(tmp_path, old, new, words):
    study = trainer(tmp_path, old, new)
    assert [line for line in check_file(study).warnings if line.startswith(words)], check_file(
        study
    )


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (EYE, "left_design_eye: [20, 280, 90]", "520 mm below where the eyes of anybody in seat"),
        (EYE, "left_design_eye: [0.02, 0.28, 1.053]", "609 mm below where the eyes of anybody in"),
        (HEEL, "left_heel: [786, 280, 300]", "300 mm above the surface there, 'floor'"),
        (HEEL, "left_heel: [786, 280, -400]", "400 mm under the floor before seat 'left', 'floor'"),
    ],
)
def test_a_point_by_its_name_is_where_a_sitter_has_it_or_said_once(tmp_path, old, new, words):
    study = trainer(tmp_path, old, new)
    environment = tmp_path / "environments" / "trainer" / "environment.yaml"
    for file in (environment, study):
        said = [line for line in check_file(file).warnings if words in line]
        assert len(said) == 1, check_file(file)
    assert "eye" not in new or "mm is usual" in said[0]


def test_heels_stand_on_no_stick(tmp_path):
    """A stick of 20 mm that ends 60 mm over the floor under the heels is none, nor is its breadth a
    foot's; an eye point across a counter is nobody's who sits."""
    environment = load_environment(ROOT / "environments" / "trainer" / "environment.yaml")
    seat = environment.seat("left")
    lever = np.array([[0.0, 0.0, 0.06], [0.02, 0.0, 0.06], [0.0, 0.02, 0.06]])
    heel = np.array(environment.points["left_heel"])
    for broad, said in ((0.02, 0), (0.5, 1)):
        corners_there = heel + (lever - [0.005, 0.005, 0.0]) * [broad / 0.02, broad / 0.02, 1.0]
        ground = ground_of(environment)
        more = replace(
            ground,
            corners=np.concatenate([ground.corners, corners_there[None]]),
            part=np.append(ground.part, len(ground.names)),
            names=(*ground.names, "lever"),
            one_sided=np.append(ground.one_sided, False),
        )
        assert len(list(heel_doubts(seat, more, "heel", tuple(heel.tolist())))) == said


def test_a_mesh_in_feet_that_is_read_as_metres_has_seats_for_giants(tmp_path):
    study = trainer(tmp_path, "{file: trainer.obj, length: m,", "{file: trainer.obj, length: ft,")
    lines = check_file(study).warnings
    assert any("'left_seat_pan' is 0.14" in line for line in lines), lines


def test_the_environments_and_studies_of_the_catalogue_have_no_doubts():
    for path in sorted((ROOT / "studies").glob("*.yaml")):
        assert check_file(path).warnings == (), path
    for path in sorted((ROOT / "environments").glob("*/environment.yaml")):
        assert check_file(path).warnings == (), path


CAB = """environment: cab
length: mm
meshes: [{file: cab.obj, length: m, up: z, forward: x}]
controls: {knob: {at: AT, part: lever, grip: push, zone: 1}}
"""


@settings(max_examples=30)
@given(
    low=st.tuples(*[st.floats(-1.5, 1.5)] * 3),
    at=st.tuples(*[st.floats(-3000.0, 3000.0)] * 3),
)
@example(low=(-0.03, -0.03, -0.03), at=(900.0, 0.0, 0.0))
def test_a_wrong_unit_is_suspected_only_where_the_number_in_it_leads_to_the_part(
    tmp_path_factory, low, at
):
    """A part at the origin explains nothing: whatever is made small enough is there."""
    home = tmp_path_factory.mktemp("cab")
    box = corners(low, np.add(low, 0.06))
    (home / "cab.obj").write_text(
        obj_text({"lever": box, "floor": corners((-2, -2, -2), (2, 2, -1.9))})
    )
    (home / "environment.yaml").write_text(CAB.replace("AT", str(list(map(float, at)))))
    said = [line for line in load_environment(home).warnings if "times as large" in line]
    origin = float(np.linalg.norm(np.clip(0.0, box.min(axis=0), box.max(axis=0))))
    assert not said or origin > 0.1
    for line in said:
        factor = float(line.partition("numbers were ")[2].split()[0])
        there = factor * np.array(at) / 1000.0
        away = np.clip(there, box.min(axis=0), box.max(axis=0)) - there
        assert np.linalg.norm(away) < 0.11
