"""Rules of sight against numbers of their tables, worked vectors, and slow other ways to them.

Vectors are of a fact sheet on sight (sections ac25_773, a_pillar, mirror_plane, mirror_convex,
character_height_mm, ocular_height_r46_proposal, seatback, tractor_masking), in mm and degrees.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ROOT
from workbench import InputError, eyellipse
from workbench.cli import main
from workbench.files.study.rules import load_rule_set
from workbench.model.rule_set import REMEMBERED
from workbench.sight.eyes import given_eyes
from workbench.sight.rules.eye_points import (
    car_eye_points,
    eyellipse_centroid,
    ocular_points,
    seat_back_shift,
)
from workbench.sight.rules.pillar import pillar_angle
from workbench.sight.rules.reading import character_height, reading

R125 = load_rule_set("sight_un_r125")
R46 = load_rule_set("sight_un_r46")
NUREG = load_rule_set("sight_nureg_0700")
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


@settings(max_examples=30)
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


def test_a_value_of_another_shape_is_refused_by_its_name(tmp_path):
    text = (ROOT / "studies" / "rules" / "sight_un_r125.yaml").read_text()
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace("p_to_e: {value: 104", "p_to_e: {value: [104, 65]"))
    with pytest.raises(InputError, match=r"rule set .*: p_to_e: expected an array of shape \(\)"):
        pillar_angle(post((0.6, 0.42), 0.05), PLAN, load_rule_set(path), side="left")
    path.write_text(
        text.replace(
            "v1: {value: [68, -5, 665], unit: mm, axes: rearward right up",
            "v1: {value: 5, unit: mm",
        )
    )
    with pytest.raises(InputError, match=r": v1: expected an array of shape \(3,\), got \(\)"):
        car_eye_points(ZERO, STRAIGHT, load_rule_set(path))
    path.write_text(text.replace("5, 6, 7, 8,", "5, 6, 7,"))
    with pytest.raises(InputError, match=r"seat_back_shift: expected an array of shape \(35, 3\)"):
        car_eye_points(ZERO, STRAIGHT, load_rule_set(path))


def test_every_rule_set_of_sight_loads_and_checks(capsys):
    found = sorted((ROOT / "studies" / "rules").glob("sight_*.yaml"))
    assert len(found) >= 2
    for path in found:
        assert main(["check", str(path)]) == 0
        rules = load_rule_set(path.stem)
        assert rules.name == path.stem
        assert rules.status(*rules.values)


def post(centre, radius, *, lean=(0.0, 0.0), sides=720):
    """Triangles (T, 3, 3) [m] of a round post from z 0 to 1.2 m whose level cuts are circles; its
    axis moves by `lean` a metre of height. centre (2,): at z 0.6 m."""
    angle = np.arange(sides) * 2 * np.pi / sides
    ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) + centre
    low = np.column_stack([ring - 0.6 * np.array(lean), np.zeros(sides)])
    high = np.column_stack([ring + 0.6 * np.array(lean), np.full(sides, 1.2)])
    low_next, high_next = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
    one = np.stack([low, low_next, high_next], axis=1)
    return np.concatenate([one, np.stack([low, high_next, high], axis=1)])


PLAN = car_eye_points(ZERO, STRAIGHT, R125)


@pytest.mark.parametrize(
    ("radius", "angle", "turn", "outer_eye", "inner_eye"),
    [
        (40.0, 1.320, 32.780, (30.46, 100.81), (65.66, 46.16)),
        (50.0, 3.082, 33.544, (29.38, 101.68), (65.30, 47.50)),
        (60.0, 4.847, 34.308, (28.29, 102.53), (64.92, 48.84)),
        (32.5, 0.0, 32.208, (31.27, 100.15), (65.91, 45.16)),
    ],
)
def test_pillar_angle_of_upright_round_posts(radius, angle, turn, outer_eye, inner_eye):
    found = pillar_angle(post((0.6, 0.42), 1e-3 * radius), PLAN, R125, side="left")
    assert np.degrees(found.angle) == pytest.approx(angle, abs=5e-4)
    assert np.degrees(found.turn) == pytest.approx(turn, abs=5e-4)
    assert 1e3 * found.eyes[:, :2] == pytest.approx(np.array([outer_eye, inner_eye]), abs=5e-3)
    assert np.linalg.norm(found.eyes - PLAN["p1"], axis=1) == pytest.approx(0.104)
    assert "p_to_e, e_apart" in found.status and REMEMBERED in found.status


@settings(max_examples=30)
@given(st.floats(0.3, 1.5), st.floats(0.1, 0.9), st.floats(0.004, 0.0325))
def test_an_upright_round_post_no_wider_than_the_eyes_are_apart_hides_nothing(x, y, radius):
    found = pillar_angle(post((x, y), radius, sides=48), PLAN, R125, side="left")
    assert found.angle == pytest.approx(0.0, abs=1e-6)


@settings(max_examples=30)
@given(st.floats(0.3, 1.2), st.floats(0.1, 0.9), st.floats(-0.7, 0.0), st.floats(0.03, 0.09))
def test_the_passengers_side_and_a_driver_on_the_right_are_mirrored(x, y, lean, radius):
    corners = post((x, y), radius, lean=(lean, 0.2 * lean), sides=48)
    mirrored = corners * [1, -1, 1]
    other = car_eye_points(ZERO, STRAIGHT, R125, driver="right")
    for side, across in (("left", "right"), ("right", "left")):
        there = corners if side == "left" else mirrored
        one = pillar_angle(there, PLAN, R125, side=side)
        two = pillar_angle(there * [1, -1, 1], other, R125, side=across)
        assert two.angle == pytest.approx(one.angle, abs=1e-12)
        assert two.turn == pytest.approx(-one.turn)
        assert two.eyes == pytest.approx(one.eyes * [1, -1, 1])


def searched_pillar_angle(circles, pivot):
    """The angle [rad] by turning eyes step by step, the edges sampled. circles: centre (2,) and
    radius of S1 and S2, of a pillar on the left."""
    angle = np.linspace(0, 2 * np.pi, 20_001)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    s1, s2 = (np.array(centre) + radius * ring for centre, radius in circles)

    def edge(points, eye, turn, pick):
        way = points - eye
        return pick((np.arctan2(way[:, 1], way[:, 0]) - turn + np.pi) % (2 * np.pi)) - np.pi

    def eye(turn, aside):
        ahead = np.sqrt(0.104**2 - 0.0325**2)
        direction = np.array([np.cos(turn), np.sin(turn)])
        return pivot[:2] + ahead * direction + aside * np.array([-direction[1], direction[0]])

    low, high = 0.0, np.pi / 2
    for _ in range(50):
        turn = (low + high) / 2
        beyond = edge(s2, eye(turn, 0.0325), turn, np.max) > 0
        low, high = (turn, high) if beyond else (low, turn)
    return max(0.0, -edge(s1, eye(turn, -0.0325), turn, np.min))


@pytest.mark.parametrize("lean", [(0.0, 0.0), (-1.2, -0.3), (-0.6, 0.1), (0.3, 0.0)])
@pytest.mark.parametrize("radius", [0.035, 0.06])
def test_a_leaning_pillar_is_cut_twice_as_a_search_over_turns_finds(lean, radius):
    corners = post((0.75, 0.55), radius, lean=lean)
    circles = []
    for rise in np.radians([2.0, -5.0]):
        x = 0.75
        for _ in range(200):  # the foremost point of the plane's cut is the front of a level circle
            z = PLAN["pm"][2] + np.tan(rise) * (x - PLAN["pm"][0])
            centre = np.array([0.75, 0.55]) + (z - 0.6) * np.array(lean)
            x = centre[0] + radius
        circles.append((centre, radius))
    found = pillar_angle(corners, PLAN, R125, side="left")
    assert found.angle == pytest.approx(searched_pillar_angle(circles, PLAN["p1"]), abs=1e-5)
    for cut, alone in zip(circles, (found.of_upper, found.of_lower), strict=True):
        assert alone == pytest.approx(searched_pillar_angle([cut, cut], PLAN["p1"]), abs=1e-5)
    if lean[0] < -1 and radius > 0.05:
        one_cut = searched_pillar_angle([circles[1], circles[1]], PLAN["p1"])
        assert abs(np.degrees(found.angle - one_cut)) > 1.0  # S1 and S2 differ by so much


def test_both_pillars_in_one_part_with_what_is_behind_give_the_angle_of_the_side():
    left = post((0.6, 0.42), 0.05)
    behind = post((-0.6, 0.6), 0.08)
    all_of_it = np.concatenate([left, left * [1, -1, 1], behind])
    alone = pillar_angle(left, PLAN, R125, side="left")
    assert pillar_angle(all_of_it, PLAN, R125, side="left").angle == alone.angle


def test_a_pillar_that_the_planes_do_not_meet_or_at_the_eyes_is_refused():
    corners = post((0.6, 0.42), 0.05)
    with pytest.raises(InputError, match="2 degrees up, meets nothing of the pillar"):
        pillar_angle(corners, PLAN, R125, side="right")
    with pytest.raises(InputError, match="5 degrees down, meets nothing"):
        pillar_angle(corners + np.array([0, 0, 0.62]), PLAN, R125, side="left")
    with pytest.raises(InputError, match="mm from the P point; farther than"):
        pillar_angle(post((0.0, 0.03), 0.04), PLAN, R125, side="left")


@pytest.mark.parametrize(
    ("minutes", "distance", "height"),
    [
        (10, 500, 1.454),
        (10, 711, 2.068),
        (10, 1000, 2.909),
        (16, 500, 2.327),
        (16, 711, 3.309),
        (16, 1000, 4.654),
        (20, 500, 2.909),
        (20, 711, 4.136),
        (20, 1000, 5.818),
        (22, 500, 3.200),
        (22, 711, 4.550),
        (22, 1000, 6.400),
        (24, 500, 3.491),
        (24, 711, 4.964),
        (24, 1000, 6.981),
    ],
)
def test_character_heights_at_a_distance(minutes, distance, height):
    found = character_height(np.radians(minutes / 60), 1e-3 * distance)
    assert 1e3 * found == pytest.approx(height, abs=5.1e-4)


def test_an_instrument_straight_ahead_is_read_by_hand():
    """5 mm at 0.8 m are 21.5 minutes of arc; a face tilted by 30 degrees leaves cos 30 of them."""
    eyes = given_eyes(ZERO)
    tilted = (-np.cos(np.radians(30)), 0.0, np.sin(np.radians(30)))
    found = reading(eyes, (0.8, 0, 0), tilted, 0.005, NUREG)
    assert found.distance == pytest.approx([0.8])
    minutes = 60 * np.degrees(found.character)
    assert minutes == pytest.approx([0.005 / 0.8 * 60 * 180 / np.pi * np.cos(np.radians(30))])
    assert np.degrees(found.face_angle) == pytest.approx([60])
    assert [found.azimuth[0], found.elevation[0]] == pytest.approx([0, 0])
    assert 60 * np.degrees(NUREG["character_preferred"]) == pytest.approx([20, 22])
    assert np.degrees(NUREG["elevation"]) == pytest.approx([-40, 20])
    assert np.degrees(NUREG.number("face_angle")) == pytest.approx(45)


def test_off_axis_angles_are_left_and_up_of_the_head_and_behind_a_face_nothing_is_read():
    eyes = given_eyes([[0, 0, 0], [0, 0, 1]], ahead=(0, 1, 0))
    found = reading(eyes, (-0.5, 0.5, 0), (1, -1, 0), 0.004, NUREG)
    assert np.degrees(found.azimuth) == pytest.approx([45, 45])
    assert np.degrees(found.elevation) == pytest.approx([0, -np.degrees(np.arctan(np.sqrt(2)))])
    away = reading(eyes, (-0.5, 0.5, 0), (-1, 1, 0), 0.004, NUREG)
    assert away.character == pytest.approx([0, 0])
    assert np.all(away.face_angle < 0)


@settings(max_examples=30)
@given(st.floats(0.3, 1.2), st.floats(-0.8, 0.8), st.floats(-0.6, 0.4), st.floats(-1, 1))
def test_a_mirrored_instrument_is_read_alike_on_the_other_side(x, y, z, turned):
    eyes = given_eyes(ZERO)
    face = np.array([-1.0, turned, 0.3])
    one = reading(eyes, (x, y, z), face, 0.004, NUREG)
    two = reading(eyes, (x, -y, z), face * [1, -1, 1], 0.004, NUREG)
    assert two.azimuth == pytest.approx(-one.azimuth)
    for name in ("distance", "character", "face_angle", "elevation"):
        assert getattr(two, name) == pytest.approx(getattr(one, name))


@pytest.mark.parametrize(
    ("at", "face", "characters", "told"),
    [
        ((0.7, 0, 0), (-1, 0, 0), 0.0, "height of characters above 0 m, got 0"),
        ((0.7, 0, 0), (0, 0, 0), 0.004, "the instrument has no face"),
    ],
)
def test_an_instrument_that_nobody_can_read_is_refused(at, face, characters, told):
    with pytest.raises(InputError, match=told):
        reading(given_eyes(ZERO), at, face, characters, NUREG)


def rule_rows(rules):
    """The rows of a rule set in the table of the docs."""
    return [f"| `{name}` | {value.words} |" for name, value in rules.values.items()]


def test_the_docs_tell_of_every_value_how_sure_it_is():
    for docs, kind in (("sight-rules", "sight"), ("strain", "strain")):
        page = (ROOT / "docs" / f"{docs}.md").read_text()
        for path in (ROOT / "studies" / "rules").glob(f"{kind}_*.yaml"):
            rules = load_rule_set(path.stem)
            assert rules.credit in page
            for row in rule_rows(rules):
                assert row in page


def test_a_rule_set_says_how_many_of_its_values_are_from_memory_or_which_where_they_are_few():
    told = load_rule_set("sight_un_r125").all_told
    assert re.search(r"; \d+ of its \d+ values are from memory, not checked", told)
    few = load_rule_set("sight_nureg_0700").all_told
    end = "; the line of sight below straight ahead (0 degrees): from memory, not checked against the "
    assert few.endswith(f"{end}rule's text")


def test_values_of_sight_that_are_not_sure_are_told_in_words_with_their_figures_and_units():
    told = load_rule_set("sight_un_r125").told("p1", "v1", "p_to_e", "s2_fall")
    asked = "the point P1 (35, -20, 627 mm rearward right up), the distance from P to the eyes (104 mm), "
    assert f"; {asked}the fall to the lower cut S2 (5 degrees): from memory, " in told
    for path in (ROOT / "studies" / "rules").glob("sight_*.yaml"):
        rules = load_rule_set(path.stem)
        for name, value in rules.values.items():
            if value.status != "seen" or value.doubt:
                assert not value.called.startswith(name.replace("_", " ")), name
                assert "_" not in rules.told(name)
