"""Parts and controls that a study has elsewhere than their environment: `moved`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from workbench.errors import InputError
from workbench.model.surroundings import Move, displaced, move_parts, parts_along
from workbench.report.sentences import moved_line

TEXT = (ROOT / "studies" / "trainer_clearance.yaml").read_text()
LINE = "environment: trainer\n"


def study_with(tmp_path, rows):
    path = tmp_path / "moved.yaml"
    assert LINE in TEXT
    path.write_text(TEXT.replace(LINE, f"{LINE}moved:\n{rows}"))
    return path


def control(environment, name):
    return np.array(next(one.at for one in environment.controls if one.name == name))


def test_a_part_goes_with_its_control_and_a_control_alone(tmp_path):
    rows = (
        "  - {parts: [throttle_lever], by: [15, 0, 2 cm]}\n"
        "  - {controls: [flaps], alone: true, by: [0, 5, 0]}\n"
    )
    plain = wb.load_study("trainer_clearance").environment
    study = wb.load_study(study_with(tmp_path, rows))
    environment = study.environment
    expected = move_parts(plain, ["throttle_lever"], [0.015, 0.0, 0.02])
    assert np.array_equal(environment.vertices, expected.vertices)
    assert np.array_equal(environment.offset, expected.offset)
    assert control(environment, "throttle") - control(plain, "throttle") == pytest.approx(
        [0.015, 0.0, 0.02]
    )
    assert control(environment, "flaps") - control(plain, "flaps") == pytest.approx([0, 0.005, 0])
    same = [c.name for c, d in zip(environment.controls, plain.controls, strict=True) if c == d]
    assert len(same) == len(plain.controls) - 2
    assert [move.by for move in study.moved] == [(0.015, 0.0, 0.02), (0.0, 0.005, 0.0)]


@pytest.mark.parametrize(
    ("row", "parts", "controls"),
    [
        ("control: flaps", ("flap_lever",), ()),
        ("controls: [flap*]", ("flap_lever",), ()),
        ("control: flaps, alone: true", (), ("flaps",)),
        ("control: flaps, parts: [compass]", ("compass", "flap_lever"), ()),
        ("controls: [flaps, mixture]", ("flap_lever", "mixture_lever"), ()),
    ],
)
def test_controls_take_a_part_along_that_no_other_control_is_on(tmp_path, row, parts, controls):
    study = wb.load_study(study_with(tmp_path, f"  - {{{row}, by: [0, 5, 0]}}\n"))
    (move,) = study.moved
    assert (set(move.parts), move.controls) == (set(parts), controls)
    plain = wb.load_study("trainer_clearance").environment
    shift = control(study.environment, "flaps") - control(plain, "flaps")
    assert shift == pytest.approx([0, 0.005, 0])


def test_a_part_goes_along_where_all_controls_on_it_do():
    environment = wb.load_study("trainer_clearance").environment
    first, second = environment.controls[:2]
    both = (first, replace(second, part=first.part))
    environment = replace(environment, controls=both)
    assert parts_along(environment, [first.name]) == ()
    assert parts_along(environment, [first.name, second.name]) == (first.part,)


def test_the_report_says_what_is_moved():
    moves = [
        Move(("throttle_lever", "mixture_lever"), (), (0.015, 0.0, -0.02)),
        Move((), ("flaps",), (0.0, 0.0051, 0.0)),
    ]
    assert moved_line(moves) == [
        "moved: throttle_lever, mixture_lever by 15 mm forward and 20 mm down; control flaps by 5.1 mm "
        "left"
    ]
    assert moved_line([]) == []


def test_what_is_moved_there_and_back_is_where_it_was():
    environment = wb.load_study("trainer_clearance").environment
    there = (Move(("flap_lever",), (), (0.03, -0.01, 0.02)), Move((), ("flaps",), (0.0, 0.0, 0.01)))
    away = displaced(environment, there)
    assert displaced(away, there, there) is away
    back = displaced(away, (), there)
    assert np.abs(back.vertices - environment.vertices).max() < 1e-15
    assert control(back, "flaps") == pytest.approx(control(environment, "flaps"), abs=1e-15)


def test_an_adjustment_goes_with_its_parts():
    environment = wb.load_study("car_driver").environment
    names = environment.adjustment("wheel_telescope").parts
    by = (0.02, 0.0, 0.01)
    found = displaced(environment, (Move(tuple(names), (), by),))
    assert np.array(found.points["wheel_centre"]) - environment.points["wheel_centre"] == (
        pytest.approx(by)
    )
    tilt = environment.adjustment("wheel_tilt")
    assert found.adjustment("wheel_tilt") == tilt  # its column stays
    column = displaced(environment, (Move(tilt.parts, (), by),)).adjustment("wheel_tilt")
    assert np.array(column.pivot) - tilt.pivot == pytest.approx(by)


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("{parts: [throtle_lever], by: [1, 0, 0]}", "has no part 'throtle_lever'; did you mean"),
        ("{controls: [flap], by: [1, 0, 0]}", "has no control 'flap'; did you mean 'flaps'"),
        ("{controls: [flaps], by: [.inf, 0, 0]}", "by"),
        ("{controls: [flaps], by: [.nan, 0, 0]}", "by"),
        ("{controls: [flaps], by: [1, 0]}", "by"),
        ("{controls: [flaps], by: [1 km, 0, 0]}", "by"),
        ("{controls: [flaps]}", "by"),
        ("{by: [1, 0, 0]}", "'control', 'controls' or 'parts' says what is moved"),
        ("{parts: [compass], alone: true, by: [1, 0, 0]}", "'alone' says that controls leave"),
        ("{control: flap*, by: [1, 0, 0]}", "has no control 'flap*'; did you mean 'flaps'"),
        ("{controls: [knob*], by: [1, 0, 0]}", "has no control 'knob*'; valid: "),
        ("{parts: [door*], by: [1, 0, 0]}", "has no part 'door*'; "),
        (
            "{controls: [flaps], by: [1, 0, 0]}\n  - {control: flaps, alone: true, by: [1, 0, 0]}",
            "control 'flaps' is moved by entry 1 already; move it once",
        ),
        (
            "{parts: [flap*], by: [1, 0, 0]}\n  - {control: flaps, by: [1, 0, 0]}",
            "part 'flap_lever' is moved by entry 1 already, and goes along with flaps here",
        ),
        ("{parts: [left_seat_pan], by: [1, 0, 0]}", "goes with seat 'left'"),
        (
            "{parts: [compass], by: [1, 0, 0]}\n  - {parts: [comp*], by: [0, 1, 0]}",
            "part 'compass' is moved by entry 1 already",
        ),
        ("{parts: [], by: [1, 0, 0]}", "parts"),
    ],
)
def test_a_move_that_is_wrong_is_reported_with_its_line(tmp_path, row, words):
    path = study_with(tmp_path, f"  - {row}\n")
    line = path.read_text().split("\n").index("moved:") + 2
    with pytest.raises(InputError) as found:
        wb.load_study(path)
    (problem,) = found.value.problems
    assert words in problem and (f":{line}:" in problem or f":{line + 1}:" in problem)


def test_a_simulated_motion_has_the_environment_of_its_simulation(tmp_path):
    text = (ROOT / "studies" / "trainer_crash.yaml").read_text()
    recorded = "{motion: {file: motions/trainer_lap.csv, restraints: trainer_lap}}"
    text = text.replace(recorded, "{simulated: {start: flying, simulation: trainer_lap}}")
    path = tmp_path / "crash.yaml"
    path.write_text(text.replace(LINE, f"{LINE}moved: [{{parts: [compass], by: [1, 0, 0]}}]\n"))
    with pytest.raises(InputError, match="takes place in the environment of its simulation"):
        wb.load_study(path)
