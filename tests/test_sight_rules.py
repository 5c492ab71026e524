"""Rules of sight against numbers of their tables, worked vectors, and slow other ways to them.

Vectors are of a fact sheet on sight (sections ac25_773, a_pillar, mirror_plane, mirror_convex,
character_height_mm, ocular_height_r46_proposal, seatback, tractor_masking), in mm and degrees.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import ROOT
from workbench import InputError, eyellipse
from workbench.cli import main
from workbench.files.study.rules import load_rule_set
from workbench.model.rule_set import REMEMBERED
from workbench.sight.rules.eye_points import (
    car_eye_points,
    eyellipse_centroid,
    ocular_points,
    seat_back_shift,
)

R125 = load_rule_set("sight_un_r125")
R46 = load_rule_set("sight_un_r46")
ZERO = np.zeros(3)
STRAIGHT = np.radians(25.0)


def test_seat_back_table_has_its_rows_and_sums():
    shift = 1e3 * R125["seat_back_shift"]
    assert np.degrees(R125["seat_back"]) == pytest.approx(np.arange(5, 41))
    assert shift.sum(axis=0) == pytest.approx([911, 0, -13])  # forward: the rule's -911 rearward


@pytest.mark.parametrize(
    ("degrees", "name", "rearward_right_up"),
    [
        (25, "v1", (68, -5, 665)),
        (25, "v2", (68, -5, 589)),
        (15, "v1", (-22, -5, 685)),
        (33, "v2", (135, -5, 565)),
        (25, "p1", (35, -20, 627)),
        (25, "p2", (63, 47, 627)),
        (22.5, "v1", (68 - 22, -5, 665 + 6)),  # half-way between 22 and 23 degrees
    ],
)
def test_eye_points_of_car_drivers(degrees, name, rearward_right_up):
    point = car_eye_points(ZERO, np.radians(degrees), R125)[name]
    assert 1e3 * point * [-1, -1, 1] == pytest.approx(rearward_right_up)


def test_pm_is_where_the_line_of_p1_and_p2_meets_the_plane_of_r():
    points = car_eye_points(ZERO, STRAIGHT, R125)
    share = points["p1"][1] / (points["p1"][1] - points["p2"][1])
    between = points["p1"] + share * (points["p2"] - points["p1"])
    assert 1e3 * points["pm"] == pytest.approx(1e3 * between, abs=0.005)


@pytest.mark.parametrize(
    ("travel", "forward"),
    [(108, 0), (109, 13), (120, 13), (121, 22), (140, 32), (158, 42), (159, 48), (300, 48)],
)
def test_seat_travel_moves_the_p_points_by_bands_and_not_the_v_points(travel, forward):
    moved = car_eye_points(ZERO, STRAIGHT, R125, seat_travel=1e-3 * travel)
    still = car_eye_points(ZERO, STRAIGHT, R125)
    for name, far in (("p1", forward), ("p2", forward), ("pm", forward), ("v1", 0), ("v2", 0)):
        assert 1e3 * (moved[name] - still[name]) == pytest.approx([far, 0, 0])
    assert "seat_travel_shift: from memory" in moved.status
    assert "seat_travel" not in still.status


@given(st.floats(5, 40), st.tuples(*[st.floats(-3, 3)] * 3))
def test_a_driver_on_the_right_has_the_mirrored_points(degrees, r_point):
    left = car_eye_points(r_point, np.radians(degrees), R125)
    mirrored = np.array(r_point) * [1, -1, 1]
    right = car_eye_points(mirrored, np.radians(degrees), R125, driver="right")
    for name, point in left.points.items():
        assert right[name] == pytest.approx(point * [1, -1, 1])


@pytest.mark.parametrize("degrees", [4.9, 40.1, -25])
def test_a_seat_back_beyond_the_table_is_refused(degrees):
    told = f"seat back {degrees:g} degrees .* holds for 5 to 40 degrees"
    with pytest.raises(InputError, match=told):
        seat_back_shift(np.radians(degrees), R125)
    with pytest.raises(InputError, match="working paper's heights hold for 5 to 40 degrees"):
        ocular_points(ZERO, R46, working_paper=np.radians(degrees))


@pytest.mark.parametrize(
    ("degrees", "height"),
    [(5, 675.6), (10, 670.5), (15, 662.0), (20, 650.1), (25, 635.0), (30, 616.8), (40, 571.6)],
)
def test_working_paper_gives_the_heights_of_ocular_points(degrees, height):
    points = ocular_points(ZERO, R46, working_paper=np.radians(degrees))
    assert 1e3 * points["middle"] == pytest.approx([0, 0, height], abs=0.05)
    assert "working paper of 2008 (not adopted everywhere)" in points.status


def test_ocular_points_are_65_mm_apart_and_635_mm_above_r():
    points = ocular_points((1, 2, 3), R46)
    assert points["left"] == pytest.approx([1, 2.0325, 3.635])
    assert points["right"] == pytest.approx([1, 1.9675, 3.635])
    assert REMEMBERED not in points.status


def test_eyellipse_centroid_says_that_it_is_remembered():
    ball = (0.96, 0.2, 0.18)
    ellipse = eyellipse(ball, heel=0.0, side=0.35, wheel=0.56, height=0.25, clutch=True)
    points = eyellipse_centroid(ellipse)
    assert points["middle"] == pytest.approx(ellipse.centroid)
    assert REMEMBERED in points.status


def test_status_names_what_was_seen_and_what_is_remembered():
    status = car_eye_points(ZERO, STRAIGHT, R125).status
    assert "v1, v2, seat_back_shift: seen in 78/318/EEC annex IV" in status
    assert f"p1, p2: {REMEMBERED} (UN R125 5.3)" in status


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("values: {a: {value: [[1, 2], [3]], unit: m, status: seen, source: b}}", "same length"),
        ("values: {a: {value: [], unit: m, status: seen, source: b}}", "same length"),
        ("values: {a: {value: 1, unit: feet, status: seen, source: b}}", "values.a.unit"),
        ("values: {a: {value: 1, unit: m, status: sure, source: b}}", "values.a.status"),
        ("values: {a: {value: 1, unit: m, status: seen}}", "key 'source' is missing"),
        (
            "values: {a: {value: [1, 2], unit: m, axes: rearward right up, status: seen, source: b}}",
            "have three numbers each",
        ),
        ("limits: []", "'limits' or 'values' are needed"),
    ],
)
def test_a_rule_set_with_a_fault_is_refused(tmp_path, text, told):
    path = tmp_path / "mine.yaml"
    path.write_text(f"rules: mine\n{text}\n")
    with pytest.raises(InputError, match=told):
        load_rule_set(path)


def test_a_set_of_injury_limits_is_no_set_of_sight_and_an_unknown_value_lists_the_valid():
    with pytest.raises(InputError, match="fmvss_208 has no 'values'"):
        load_rule_set("fmvss_208")
    with pytest.raises(InputError, match="no value 'v3'; valid: v1, v2"):
        R125["v3"]


def test_every_rule_set_of_sight_loads_and_checks(capsys):
    found = sorted((ROOT / "studies" / "rules").glob("sight_*.yaml"))
    assert len(found) >= 2
    for path in found:
        assert main(["check", str(path)]) == 0
        rules = load_rule_set(path.stem)
        assert rules.name == path.stem
        assert rules.status(*rules.values)
