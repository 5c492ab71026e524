"""Measuring and scaling: the virtual anthropometer, bodies to measures, sized people in studies."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import REFERENCE, ROOT, real_input
from workbench import load_population_model, measure, person_body, scale
from workbench.body.scaling.manikin import Manikin
from workbench.body.scaling.measure import MEASURES, lengths
from workbench.cli import main
from workbench.files.populations import load_growth
from workbench.files.postures import posture_pose

SIX = (
    "stature",
    "sitting_height",
    "eye_height_sitting",
    "acromial_height_sitting",
    "buttock_knee_length",
    "knee_height_sitting",
)


@pytest.fixture(scope="module")
def model():
    return load_population_model("ansur2")


def percentile(column, names):
    path = real_input(REFERENCE / "ansur2_percentiles.csv")
    rows = {
        row["dim"].removesuffix("_d"): row for row in csv.DictReader(path.read_text().splitlines())
    }
    return {
        n: float(rows[n.replace("_", "")][column]) / 1000
        for n in names
        if n.replace("_", "") in rows
    }


def test_there_are_35_measures_or_more_and_each_says_what_it_measures():
    assert len(MEASURES) >= 35
    assert all(len(one.definition) > 20 for one in MEASURES.values())


def test_the_measures_a_study_may_give_are_those_of_the_anthropometer():
    from workbench.model.population import ON_THE_BODY

    assert list(MEASURES) == list(ON_THE_BODY)


@pytest.mark.parametrize(
    ("measures", "words"),
    [
        ("{stature: 60}", "60 mm is not a person's (630 to 2800 mm is): a wrong unit?"),
        ("{mass: 60}", "mass_kg: 60"),
        ("{span: 1500}", "no measure 'span'"),
    ],
)
def test_a_size_that_cannot_be_is_told_where_it_stands(tmp_path, measures, words):
    text = (ROOT / "studies" / "trainer_clearance.yaml").read_text()
    path = tmp_path / "wrong.yaml"
    path.write_text(
        text.replace("seat: left,", f"seat: left, size: {{sex: male, measures: {measures}}},")
    )
    with pytest.raises(wb.InputError) as caught:
        wb.load_study(path)
    assert words in str(caught.value)


@pytest.mark.parametrize(("sex", "stature"), [("female", 1525), ("female", 1626), ("male", 1870)])
def test_bubbleman_of_a_stature_is_drawn_near_to_such_people(bubbleman, sex, stature):
    """Its hip joints are at the trochanterion, its knees elsewhere: drawn near to both it would lose
    its trunk."""
    people = wb.load_population_model("ansur2")
    made = wb.person_body(bubbleman, people, sex=sex, measures={"stature": stature / 1000})
    assert made.warnings == ()
    found = wb.measure(made.body, ["buttock_knee_length", "knee_height_sitting"])
    for name, value in found.items():
        assert value == pytest.approx(made.measures[name], abs=0.015)


def test_bubbleman_measures_as_a_median_man(bubbleman):
    # what a rigid body cannot show, or what its definition is known to miss, has more room
    room = {
        "radiale_stylion_length": 13,
        "forearm_forearm_breadth": 37,
        "overhead_fingertip_reach_sitting": 25,
        "cervicale_height": 21,
        "cervicale_height_sitting": 20,
        "biacromial_breadth": 16,
        "forearm_hand_length": 13,
        "forearm_center_of_grip_length": 12,
        "elbow_rest_height": 11,
        "interpupillary_breadth": 600,
        "trochanterion_height": 14,  # its hip joints are at the trochanterion
    }
    found = measure(bubbleman)
    straight = [name for name in MEASURES if "circumference" not in name]
    for name, wanted in percentile("M50", straight).items():
        assert 1000 * abs(found[name] - wanted) <= room.get(name, 8.5), (name, found[name], wanted)


def test_a_length_is_linear_in_the_body_while_its_extreme_spheres_stay(bubbleman):
    from workbench.body.scaling.manikin import Shape

    base = Manikin(bubbleman)
    twice = base.changed(
        Shape(*(2 * getattr(base.shape, f) for f in ("centre", "radius", "in_parent", "in_child")))
    )
    for name, length in lengths(base).items():
        assert twice.value(length) == pytest.approx(2 * base.value(length)), name


def test_measured_on_the_posed_body_stature_is_its_height(bubbleman):
    placed = wb.place(bubbleman, wb.pose(bubbleman, {}))
    top = (placed.centres[0, :, 2] + bubbleman.radius[0]).max()
    low = (placed.centres[0, :, 2] - bubbleman.radius[0]).min()
    assert measure(bubbleman, ["stature"])["stature"] == pytest.approx(top - low)


SAID = (
    ("height", "stature"),
    ("shoulder_width", "bideltoid_breadth"),
    ("knee height", "knee_height_sitting"),
)


def test_what_people_say_for_a_measure_is_answered_with_its_name(bubbleman):
    for said, name in SAID:
        with pytest.raises(wb.InputError, match=f"did you mean .{name}."):
            measure(bubbleman, [said])


@pytest.mark.parametrize(
    "column", ["M1", "M5", "M50", "M95", "M99", "F1", "F5", "F50", "F95", "F99"]
)
def test_six_measures_come_out_within_a_hundredth_of_a_millimetre(bubbleman, column):
    wanted = percentile(column, SIX)
    found = measure(scale(bubbleman, wanted), SIX)
    assert max(abs(found[name] - wanted[name]) for name in wanted) < 1e-5


def test_scaling_to_its_own_measures_changes_nothing(bubbleman):
    same = scale(bubbleman, measure(bubbleman, SIX))
    assert np.allclose(same.centre[0], bubbleman.centre[0], atol=1e-9)
    assert np.allclose(same.radius[0], bubbleman.radius[0], atol=1e-9)
    assert np.allclose(same.allowance[0], bubbleman.allowance[0], atol=1e-9)


def test_a_scaled_body_stands_on_the_floor_with_spheres_at_its_joints(bubbleman, postures):
    small = scale(bubbleman, {"stature": 1.5, "sitting_height": 0.8})
    placed = wb.place(
        small,
        wb.join_poses(
            [posture_pose(small, postures, n) for n in ("standing", "seated", "driving")]
        ),
    )
    standing = wb.place(small, wb.pose(small, {}))
    assert (standing.centres[0, :, 2] - small.radius[0]).min() == pytest.approx(0, abs=1e-9)
    for j in range(len(small.joints)):
        at = (
            placed.world_from_segment[:, j + 1, :, :3] @ small.joint_in_child[0, j]
            + placed.world_from_segment[:, j + 1, :, 3]
        )
        near = np.linalg.norm(placed.centres - at[:, None], axis=-1).min(axis=1)
        assert near.max() < 3e-6, small.joints[j]


@pytest.mark.parametrize("column", ["M1", "M99", "F1", "F99"])
def test_extreme_bodies_are_not_in_contact_with_themselves_standing_or_seated(
    bubbleman, postures, column
):
    body = scale(bubbleman, percentile(column, SIX))
    poses = wb.join_poses(
        [wb.pose(body, {}, reference="LT"), posture_pose(body, postures, "seated")]
    )
    rows = wb.self_contacts(wb.place(body, poses))
    assert rows.excess.max(initial=-1) < 1e-3


@given(st.floats(1.45, 2.0), st.floats(0.49, 0.56))
def test_any_likely_stature_and_sitting_height_can_be_had(bubbleman, stature, share):
    found = measure(
        scale(bubbleman, {"stature": stature, "sitting_height": stature * share}), SIX[:2]
    )
    assert found["stature"] == pytest.approx(stature, abs=1e-5)
    assert found["sitting_height"] == pytest.approx(stature * share, abs=1e-5)


def test_contradicting_measures_are_named(bubbleman):
    with pytest.raises(
        wb.InputError,
        match="buttock_knee_length 480 mm is shorter than buttock_popliteal_length 502 mm",
    ):
        scale(bubbleman, {"buttock_knee_length": 0.48, "buttock_popliteal_length": 0.502})


def test_a_body_beyond_any_person_is_refused(bubbleman):
    with pytest.raises(wb.InputError, match="would have to change by a factor"):
        scale(bubbleman, {"hand_length": 0.07})


def test_a_body_without_a_persons_joints_cannot_be_measured(one_arm):
    with pytest.raises(wb.InputError, match="cannot be measured as a person"):
        measure(one_arm)


def test_what_is_not_given_follows_the_population(bubbleman, model):
    made = person_body(bubbleman, model, sex="female", measures={"stature": 1.626})
    found = measure(made.body)
    wanted = percentile("F50", ["knee_height_sitting", "buttock_knee_length", "foot_length"])
    assert all(abs(found[name] - wanted[name]) < 0.012 for name in wanted)
    assert made.body.mass[0].sum() == pytest.approx(66.8, abs=3)
    assert made.warnings == ()


def test_an_improbable_mix_is_told_with_the_measure_that_causes_it(bubbleman, model):
    made = person_body(
        bubbleman, model, sex="male", measures={"stature": 1.755, "sitting_height": 0.80}
    )
    assert "sitting height 800 mm is 5" in made.warnings[0]


@pytest.mark.parametrize(
    ("stature", "where"), [(0.80, "below the 0.1th"), (1.20, "above the 99.9th")]
)
def test_a_child_beyond_the_charts_is_told_by_the_end_that_it_is_beyond(stature, where):
    child = wb.load_body("child_3")
    made = person_body(child, load_growth(), sex="female", measures={"stature": stature}, age=3)
    said = f"stature {1000 * stature:.0f} mm is {where} percentile at 3 years"
    assert made.warnings[0].startswith(said)


def test_body_scale_writes_a_body_that_loads_and_measures_right(tmp_path, capsys):
    out = tmp_path / "small.yaml"
    assert (
        main(
            ["body", "scale", "bubbleman", "--stature", "60 in", "--sex", "female", "-o", str(out)]
        )
        == 0
    )
    assert measure(wb.load_body(out), ["stature"])["stature"] == pytest.approx(1.524, abs=1e-5)
    assert capsys.readouterr().out == f"{out}\n"


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (["--statur", "1 m"], "did you mean 'stature'"),
        (["--stature", "1 furlong"], "a length such as"),
        (["--mass", "heavy"], "a mass such as"),
        ([], "give one measure or more"),
    ],
)
def test_body_scale_refuses_what_it_does_not_understand(tmp_path, capsys, flags, words):
    assert main(["body", "scale", "bubbleman", "-o", str(tmp_path / "x.yaml"), *flags]) == 2
    assert words in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_body_measure_prints_all_measures(capsys):
    assert main(["body", "measure", "bubbleman"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == len(MEASURES)


def test_a_tall_pilot_in_a_study_is_out_of_head_room_and_told_by_how_much(tmp_path):
    text = (ROOT / "studies" / "trainer_clearance.yaml").read_text()
    size = "size: {sex: male, measures: {stature: 1960}}"
    tall = text.replace(
        "pilot: {body: adult_male, seat: left", f"pilot: {{body: adult_male, seat: left, {size}"
    )
    path = tmp_path / "tall.yaml"
    path.write_text(tall)
    result = wb.run(wb.load_study(path))
    head = next(v for v in result.verdicts if v.criterion.name == "head to canopy")
    assert not head.passed
    assert 0 < head.worst.value < 0.05
    assert measure(result.postures[0].people[0].placed.body, ["stature"])[
        "stature"
    ] == pytest.approx(1.96, abs=1e-3)


def test_an_unknown_measure_in_a_study_is_told_with_its_line(tmp_path):
    text = (ROOT / "studies" / "trainer_clearance.yaml").read_text()
    path = tmp_path / "wrong.yaml"
    path.write_text(
        text.replace("seat: left,", "seat: left, size: {sex: male, measures: {statur: 1900}},")
    )
    with pytest.raises(
        wb.InputError, match=r"wrong.yaml:\d+:\d+: .*no measure 'statur'; did you mean 'stature'"
    ):
        wb.load_study(path)
