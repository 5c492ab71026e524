"""The criterion of forces: what a hand or foot exerts on its control, of one person and of many."""

from __future__ import annotations

import json

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from tests.toy_cockpit import STUDY, write_toy
from workbench.errors import InputError
from workbench.report.folder import write_report

HEAD = STUDY.split("criteria:")[0].replace(
    "predicted: {like: driving, eyes: eye}", "predicted: {like: driving, eyes: eye, hands: {HANDS}}"
)
ONE = HEAD.replace("population: {people: PEOPLE, seed: 3}", "size: SIZE")
WOMAN = "{sex: female, measures: {stature: 1650}}"
PUSH = "check: force, controls: [near], direction: [1, 0, 0], at_least: 80, capable: 75"
CRITERIA = f"criteria:\n  - {{name: push, {PUSH}}}\n"


def study_of(folder, text=ONE + CRITERIA, *, hands="right: near", size=WOMAN):
    text = text.replace("HANDS", hands).replace("SIZE", size)
    return wb.load_study(write_toy(folder, study=text, people=8))


def strength(result, share=0.75, *, male, hand="right"):
    person = result.postures[0].people[0]
    at = next(c.at for c in result.study.environment.controls if c.name == "near")
    arms = wb.arms_of(wb.place(person.body, person.poses), hand, hand=at)
    return wb.hand_strength(arms, (1, 0, 0), male=male).strength(share)[0]


def test_a_hand_exerts_what_the_stated_share_of_such_people_does_in_the_posture_found(tmp_path):
    result = wb.run(study_of(tmp_path))
    worst = result.verdicts[0].worst
    assert worst.value == pytest.approx(strength(result, male=False), abs=1e-9)
    assert worst.unit == "N" and worst.limit == 80.0
    write_report(result, tmp_path / "out")
    rows = json.loads((tmp_path / "out" / "result.json").read_text())["verdicts"]
    sentence = rows[0]["sentence"]
    assert "right hand on near: " in sentence and "N (80 needed) by 75 % of such women" in sentence
    page = (tmp_path / "out" / "report.html").read_text()
    assert "La Delfa and J. Potvin 2025, CC BY 4.0" in page
    assert "No fatigue is computed" in page and "No forces" not in page


def test_a_man_of_the_same_size_is_stronger_and_a_mirrored_hand_as_strong(tmp_path):
    size = WOMAN.replace("female", "male")
    man = wb.run(study_of(tmp_path / "man", size=size))
    assert man.verdicts[0].worst.value == pytest.approx(strength(man, male=True), abs=1e-9)


def test_who_does_not_get_to_the_control_exerts_nothing(tmp_path):
    text = (ONE + CRITERIA).replace("[near]", "[knob]")
    path = write_toy(
        tmp_path, knob=1400, study=text.replace("HANDS", "right: knob").replace("SIZE", WOMAN)
    )
    worst = wb.run(wb.load_study(path)).verdicts[0].worst
    assert worst.value == 0.0 and "the reach gives way first" in worst.target


def test_strength_moves_nobodys_seat_and_each_of_a_population_has_newtons_to_spare(tmp_path):
    text = HEAD + CRITERIA
    asked = wb.run(study_of(tmp_path / "a", text)).population
    weak = wb.run(
        study_of(tmp_path / "b", text.replace("at_least: 80", "at_least: 900"))
    ).population
    np.testing.assert_array_equal(asked.seat, weak.seat)
    row = asked.requirements[0]
    assert (row.check, row.target, row.unit.column) == ("force", "near", "N")
    np.testing.assert_allclose(asked.margin - weak.margin, 0.82, atol=1e-9)  # 820 N
    men = asked.people.sex == 0
    assert asked.margin[men].min() > asked.margin[~men].max()
    assert not weak.served.any()


def test_a_foot_pushes_along_the_leg_where_its_push_may_lean_from_the_way_of_the_pedal(tmp_path):
    study = (ROOT / "studies" / "trainer_forces.yaml").read_text()
    study = study.replace(
        "population: {source: ansur2, people: 200, seed: 1}",
        "size: {sex: male, measures: {stature: 1750}}",
    )
    found = {}
    for lean in (0, 30):
        path = tmp_path / f"lean_{lean}.yaml"
        path.write_text(study.replace("lean: 30", f"lean: {lean}"))
        verdicts = {v.criterion.name: v for v in wb.run(wb.load_study(path)).verdicts}
        found[lean] = verdicts["rudder"].worst
    assert found[30].value > 1.3 * found[0].value
    assert "hip flexion" in found[0].target and "foot on left seat" in found[0].subject


@pytest.mark.parametrize(
    ("keys", "hands", "size", "message"),
    [
        (PUSH, "left: knob", WOMAN, "no hand or foot of 'pilot' in case 'sitting' is on 'near'"),
        (PUSH, "left: near, right: near", WOMAN, "are both on 'near'"),
        (PUSH.replace("[near]", "[neer]"), "right: near", WOMAN, "neer"),
        (PUSH.replace("[1, 0, 0]", "[0, 0, 0]"), "right: near", WOMAN, "must not be zero"),
        (PUSH.replace(", direction: [1, 0, 0]", ""), "right: near", WOMAN, "needs 'direction'"),
        (PUSH.replace("80", "0"), "right: near", WOMAN, "1 to 10000 newtons are possible"),
        (PUSH.replace("75", "100"), "right: near", WOMAN, "less than 100"),
        (PUSH + ", ages: 65+", "right: near", WOMAN, "'ages' is of feet"),
        (PUSH + ", lean: 10", "right: near", WOMAN, "'lean' is of feet"),
        (PUSH, "right: near", "", "strength goes by sex"),
        (PUSH, "right: near", "{sex: female, age: 6}", "strength is known of adults"),
    ],
)
def test_wrong_keys_of_a_force_are_refused_where_they_stand(tmp_path, keys, hands, size, message):
    text = ONE.replace(", size: SIZE", "") if not size else ONE
    with pytest.raises(InputError, match=message) as caught:
        study_of(tmp_path, f"{text}criteria:\n  - {{name: bad, {keys}}}\n", hands=hands, size=size)
    assert "toy_crew.yaml:" in str(caught.value)


def test_a_foot_without_ages_is_refused(tmp_path):
    study = (ROOT / "studies" / "trainer_forces.yaml").read_text().replace("ages: 55-65, ", "")
    (tmp_path / "no_ages.yaml").write_text(study)
    with pytest.raises(InputError, match="a foot's strength needs 'ages'"):
        wb.load_study(tmp_path / "no_ages.yaml")
