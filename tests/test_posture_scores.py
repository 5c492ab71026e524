"""RULA, REBA and OWAS: worked vectors, edges of bands, a mirrored person, and what is assumed.

Vectors are of a fact sheet on strain (sections rula and reba): scores of parts and what they give.
"""

from __future__ import annotations

import time
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from workbench.errors import InputError
from workbench.files.study.rules import load_rule_set
from workbench.strain.owas import owas_table
from workbench.strain.reba import reba_tables
from workbench.strain.rula import rula_tables

METHODS = (wb.rula, wb.reba, wb.owas)
RULA_PARTS = ("upper_arm", "lower_arm", "wrist", "twist", "neck", "trunk", "legs")
REBA_PARTS = ("trunk", "neck", "legs", "upper_arm", "lower_arm", "wrist")
MIRRORED = {"bend_left": "bend_right", "turn_left": "turn_right"}
MIRRORED |= {other: one for one, other in MIRRORED.items()}


@pytest.fixture(scope="module")
def man():
    return wb.load_body("bubbleman")


def posed(body, angles, **place):
    return wb.place(body, wb.pose(body, angles, **place))


def parts_of(names, scores):
    return {name: np.array([score]) for name, score in zip(names, scores, strict=True)}


@pytest.mark.parametrize(
    ("parts", "muscle", "force", "answer"),
    [
        ((1, 1, 1, 1, 1, 1, 1), (0, 0), (0, 0), (1, 1, 1, 1, 1)),
        ((2, 1, 2, 1, 2, 1, 1), (1, 1), (0, 0), (3, 2, 4, 3, 3)),
        ((3, 2, 3, 2, 3, 2, 1), (1, 1), (1, 0), (4, 3, 6, 4, 6)),
        ((5, 3, 4, 2, 6, 6, 2), (1, 1), (3, 3), (8, 9, 12, 13, 7)),
    ],
)
def test_rula_gives_the_grand_scores_of_worked_vectors(parts, muscle, force, answer):
    rules = load_rule_set("strain_rula")
    tables = [
        rula_tables(parts_of(RULA_PARTS, parts), muscle=m, force=f, rules=rules)
        for m, f in zip(muscle, force, strict=True)
    ]
    found = (tables[0]["A"], tables[1]["B"], tables[0]["C"], tables[1]["D"])
    assert [int(value.item()) for value in found] == list(answer[:4])
    grand = rules["table_c"][min(answer[2], 8) - 1, min(answer[3], 7) - 1]
    assert grand == answer[4]
    if force[0] == force[1]:
        assert tables[0]["grand"].item() == answer[4]


@pytest.mark.parametrize(
    ("parts", "load", "coupling", "activity", "answer"),
    [
        ((1, 1, 1, 1, 1, 1), 0, 0, 0, (1, 1, 1, 1)),
        ((2, 1, 1, 2, 1, 1), 0, 0, 1, (2, 1, 1, 2)),
        ((3, 2, 2, 3, 2, 2), 1, 1, 1, (6, 6, 8, 9)),
        ((5, 3, 4, 6, 2, 3), 3, 3, 3, (12, 12, 12, 15)),
    ],
)
def test_reba_gives_the_scores_of_worked_vectors(parts, load, coupling, activity, answer):
    found = reba_tables(
        parts_of(REBA_PARTS, parts),
        load=load,
        coupling=coupling,
        activity=activity,
        rules=load_rule_set("strain_reba"),
    )
    assert [int(value.item()) for value in found.values()] == list(answer)


def test_every_code_of_owas_has_a_category_and_the_cells_add_up_by_category():
    codes = np.array(np.meshgrid(*(np.arange(1, n + 1) for n in (4, 3, 7, 3)))).reshape(4, -1)
    names = ("back", "arms", "legs", "load")
    code = dict(zip(names, codes, strict=True))
    found = owas_table(code, rules=load_rule_set("strain_owas"))
    assert len(found) == 252 and np.bincount(found).tolist() == [0, 72, 53, 55, 72]


def test_each_score_prints_the_table_that_it_is_from_and_how_sure_its_numbers_are(man):
    sums = ("705/438/269", "321/177/1192", "631")
    for method, cells in zip(METHODS, sums, strict=True):
        found = method(posed(man, {}))
        assert found.version.endswith(f"cell sums {cells}")
        assert "chosen here, the rule gives no number" in found.status
        assert "not compared with the print" in found.status


def test_the_table_of_an_early_worksheet_is_recognised(man):
    rules = load_rule_set("strain_rula")
    other = rules.values | {"table_a": rules.values["table_a_worksheet"]}
    found = wb.rula(posed(man, {}), rules=replace(rules, values=other))
    assert "673/438/269; table A of an early worksheet" in found.version


@pytest.mark.parametrize(
    ("part", "angles", "score"),
    [
        ("upper_arm", {"RS": {"flexion": 20}}, 1),
        ("upper_arm", {"RS": {"flexion": 20.1}}, 2),
        ("upper_arm", {"RS": {"flexion": 45}}, 2),
        ("upper_arm", {"RS": {"flexion": 45.1}}, 3),
        ("upper_arm", {"RS": {"flexion": 90}}, 3),
        ("upper_arm", {"RS": {"flexion": 90.1}}, 4),
        ("upper_arm", {"RS": {"flexion": 170}}, 4),
        ("upper_arm", {"RS": {"extension": 20}}, 1),
        ("upper_arm", {"RS": {"extension": 60}}, 2),
        ("upper_arm", {"RS": {"abduction": 19.9}}, 1),
        ("upper_arm", {"RS": {"abduction": 80}}, 4),  # raised by 80, and out to the side
        ("upper_arm", {"RC": {"elevation": 11}}, 2),
        ("lower_arm", {"RE": {"flexion": 59.9}}, 2),
        ("lower_arm", {"RE": {"flexion": 60.1}}, 1),
        ("lower_arm", {"RE": {"flexion": 100.1}}, 2),
        ("lower_arm", {"RE": {"flexion": 80}, "RS": {"medial_rotation": 60}}, 2),  # across
        ("lower_arm", {"RE": {"flexion": 80}, "RS": {"lateral_rotation": 30}}, 2),  # out
        ("wrist", {"RW": {"flexion": 4.9}}, 1),
        ("wrist", {"RW": {"extension": 15}}, 2),
        ("wrist", {"RW": {"flexion": 15.1}}, 3),
        ("wrist", {"RW": {"ulnar_deviation": 11}}, 2),
        ("twist", {"RW": {"pronation": 59}}, 1),
        ("twist", {"RW": {"supination": 61}}, 2),
        ("neck", {}, 1),
        ("neck", {"NP": {"flexion": 5}, "HP": {"flexion": 5}}, 1),
        ("neck", {"NP": {"flexion": 20}}, 2),
        ("neck", {"NP": {"flexion": 20.1}}, 3),
        ("neck", {"NP": {"extension": 1}}, 4),
        ("neck", {"NP": {"turn_left": 21, "bend_right": 11}}, 3),
        ("trunk", {"LH": {"flexion": 20}, "RH": {"flexion": 20}}, 2),
        ("trunk", {"LH": {"flexion": 60.1}, "RH": {"flexion": 60.1}}, 4),
        ("trunk", {"W": {"turn_right": 21}}, 3),
        ("legs", {}, 1),
    ],
)
def test_parts_of_rula_are_scored_by_bands_whose_edges_belong_to_the_side_of_zero(
    man, part, angles, score
):
    found = wb.rula(posed(man, angles, reference="RF"))
    assert found.parts[part][0, 1] == score


def test_a_trunk_that_a_seat_back_carries_scores_one_while_the_hips_are_open(man):
    sits = {"LH": {"flexion": 80}, "RH": {"flexion": 80}}
    carried = wb.Work(trunk_supported=True)
    back = np.array([[0.94, 0, -0.342], [0, 1, 0], [0.342, 0, 0.94]])
    back /= np.linalg.norm(back, axis=0)
    sitting = posed(man, sits, reference="LT", attitude=back)
    assert wb.rula(sitting, carried).parts["trunk"].tolist() == [[1, 1]]
    assert wb.rula(sitting).parts["trunk"].tolist() == [[2, 2]]
    closed = posed(man, {joint: {"flexion": 100} for joint in sits}, reference="LT", attitude=back)
    assert wb.rula(closed, carried).parts["trunk"].tolist() == [[2, 2]]


@pytest.mark.parametrize(
    ("work", "force"),
    [
        ({"load": 1.9}, 0),
        ({"load": 2}, 1),
        ({"load": 10}, 1),
        ({"load": 10.1}, 2),
        ({"load": 5, "static": True}, 2),
        ({"load": 11, "repeated": True}, 3),
        ({"load": 1, "shock": True}, 3),
    ],
)
def test_rula_adds_for_the_load_and_for_static_or_repeated_work(man, work, force):
    found = wb.rula(posed(man, {}), wb.Work(**work))
    muscle = int("static" in work or "repeated" in work)
    assert (found.parts["C"] - found.parts["A"]).tolist() == [[force + muscle] * 2]


def test_what_is_not_stated_is_assumed_and_told(man):
    stood = posed(man, {})
    told = wb.reba(stood, wb.Work(load=0, static=False)).assumed
    assert "coupling: good (assumed)" in told and "stance: standing (assumed)" in told
    assert not any(line.startswith(("load", "static")) for line in told)
    assert wb.owas(stood, wb.Work(load=0, stance="standing")).assumed == ()


@pytest.mark.parametrize(
    ("angles", "stance", "code"),
    [
        ({}, "standing", [1, 1, 2, 1]),
        ({}, "sitting", [1, 1, 1, 1]),
        ({"RK": {"flexion": 31}}, "standing", [1, 1, 3, 1]),
        ({"RK": {"flexion": 31}, "LK": {"flexion": 31}}, "standing", [1, 1, 4, 1]),
        ({"RK": {"flexion": 31}, "LK": {"flexion": 31}}, "one_leg", [1, 1, 5, 1]),
        ({}, "kneeling", [1, 1, 6, 1]),
        ({"RS": {"flexion": 91}}, "walking", [1, 2, 7, 1]),
        ({"RS": {"flexion": 90}, "LS": {"abduction": 95}}, "standing", [1, 3, 2, 1]),
        ({"W": {"turn_left": 21}}, "standing", [3, 1, 2, 1]),
    ],
)
def test_the_code_of_owas_is_read_from_the_posture_and_the_stance(man, angles, stance, code):
    found = wb.owas(posed(man, angles), wb.Work(stance=stance))
    assert [int(part[0, 0]) for part in found.parts.values()] == code


def test_the_distance_to_the_next_band_is_of_the_nearest_angle_of_the_worse_side(man):
    # the right arm, 2 degrees short of 90, is the worse side; the left wrist is 1 degree from an edge
    bent = {"LE": {"flexion": 80}, "RE": {"flexion": 80}, "NP": {"flexion": 5}}
    found = wb.rula(posed(man, bent | {"RS": {"flexion": 88}, "LW": {"flexion": 4}}))
    assert found.by_side[0, 1] > found.by_side[0, 0] and found.next_part == ("upper_arm",)
    assert np.degrees(found.to_next_band) == pytest.approx([2])
    beyond = wb.rula(posed(man, bent | {"RS": {"flexion": 90.5}}))
    assert beyond.parts["upper_arm"][0, 1] == found.parts["upper_arm"][0, 1] + 1


def mirrored(angles):
    """The angles of a mirrored person."""
    swapped = {"L": "R", "R": "L"}
    return {
        (swapped[joint[0]] + joint[1:] if joint[0] in "LR" else joint): {
            MIRRORED.get(motion, motion): angle for motion, angle in motions.items()
        }
        for joint, motions in angles.items()
    }


TURNS = st.fixed_dictionaries(
    {
        joint: st.fixed_dictionaries({motion: st.floats(-50, 50) for motion in motions})
        for joint, motions in {
            "W": ("flexion", "bend_left", "turn_left"),
            "NP": ("flexion", "bend_left", "turn_left"),
            **{f"{side}S": ("flexion", "abduction", "medial_rotation") for side in "LR"},
            **{f"{side}E": ("flexion",) for side in "LR"},
            **{f"{side}W": ("flexion", "radial_deviation", "pronation") for side in "LR"},
            **{f"{side}H": ("flexion",) for side in "LR"},
            **{f"{side}K": ("flexion",) for side in "LR"},
        }.items()
    }
)


@settings(max_examples=12, deadline=None)
@given(angles=TURNS)
def test_a_mirrored_person_has_the_same_scores_on_the_other_side(man, angles):
    one, other = posed(man, angles), posed(man, mirrored(angles))
    for method in METHODS:
        found, seen = method(one), method(other)
        assert found.by_side[:, ::-1].tolist() == seen.by_side.tolist()
        assert found.score.tolist() == seen.score.tolist()
        np.testing.assert_allclose(found.to_next_band, seen.to_next_band, atol=1e-9)


def test_turning_the_whole_person_about_the_plumb_line_changes_no_angle(man):
    angles = {"LH": {"flexion": 30}, "W": {"bend_left": 10, "turn_right": 5}, "RS": {"flexion": 40}}
    turned = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
    one = wb.working_angles(posed(man, angles))
    other = wb.working_angles(posed(man, angles, position=(3, 4, 5), attitude=turned))
    for field in fields(one):
        np.testing.assert_allclose(getattr(one, field.name), getattr(other, field.name), atol=1e-9)


def test_a_batch_has_the_scores_of_its_rows(man):
    rows = [{"RS": {"flexion": 3.0 * n}, "W": {"flexion": 2.0 * n}} for n in range(0, 30, 4)]
    together = wb.join_poses([wb.pose(man, angles) for angles in rows])
    for method in METHODS:
        found = method(wb.place(man, together))
        alone = [method(posed(man, angles)).score[0] for angles in rows]
        assert found.score.tolist() == alone


def test_bodies_without_the_limbs_and_rules_of_other_shapes_are_refused(man):
    dog = wb.load_body("dog")
    with pytest.raises(InputError, match="posture scores need the segments LT, UT, H"):
        wb.rula(posed(dog, {}))
    rules = load_rule_set("strain_rula")
    short = rules.values | {"neck_scores": rules.values["load_edges"]}
    with pytest.raises(InputError, match="strain_rula: neck_scores: expected an array of shape"):
        wb.rula(posed(man, {}), rules=replace(rules, values=short))
    with pytest.raises(InputError, match="load: expected 0 kg or more, got -1"):
        wb.Work(load=-1)


@pytest.mark.nightly
def test_a_hundred_thousand_postures_are_scored_in_a_second_of_one_core(man):
    one = posed(man, {"RS": {"flexion": 60}, "W": {"turn_left": 25}})
    count = 20_000
    world = np.repeat(one.world_from_segment, count, axis=0)
    many = wb.Placed(man, world, np.zeros((count, len(man.sphere_names), 3)), one.window)
    started = time.process_time()
    angles = wb.working_angles(many)
    for method in METHODS:
        method(angles)
    assert 5 * (time.process_time() - started) < 1.0
