"""The criterion of posture scores: of one person, of a population, and what is wrong in its keys."""

from __future__ import annotations

import json

import numpy as np
import pytest

import workbench as wb
from tests.test_crash import BODY, PLATE, standing
from tests.test_crash import STUDY as STUDY_OF_FALL
from tests.toy_cockpit import STUDY, write_toy
from workbench.errors import InputError
from workbench.files.motions.tables import angle_table_text
from workbench.report.folder import write_report

HEAD = STUDY.split("criteria:")[0]
ONE = HEAD.replace("population: {people: PEOPLE, seed: 3}", "position: reference").replace(
    "predicted: {like: driving, eyes: eye}", "posture: driving, angles: {RS: {flexion: 70}}"
)
CRITERIA = """
criteria:
  - {name: upper limbs, check: score, method: rula, at_most: 3, work: {load: 0.5, static: true}}
  - {name: whole body, check: score, method: reba, at_most: 9}
  - {name: code, check: score, method: owas, at_most: 4}
"""


def study_of(folder, text, **changes):
    return wb.load_study(write_toy(folder, study=text, people=6, **changes))


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scores")
    return wb.run(study_of(folder, ONE + CRITERIA)), folder


def test_a_person_who_scores_more_than_allowed_fails_by_whole_points_and_is_told_why(one):
    result, _ = one
    upper, whole, code = result.verdicts
    placed = wb.place(result.postures[0].people[0].body, result.postures[0].people[0].poses)
    score = wb.rula(placed, wb.Work(load=0.5, static=True, stance="sitting"))
    assert upper.worst.value == -score.score[0] and not upper.passed
    assert upper.worst.margin == 3 - score.score[0] and upper.worst.unit == "points"
    assert whole.passed and code.passed


def test_the_page_says_points_the_table_and_what_was_assumed(one):
    result, folder = one
    write_report(result, folder / "out")
    assert "cell sums 705/438/269" in (folder / "out" / "report.html").read_text()
    rows = json.loads((folder / "out" / "result.json").read_text())["verdicts"]
    sentence = rows[0]["sentence"]
    assert "points (3 allowed)" in sentence and "cell sums 705/438/269" in sentence
    assert "assumed: shock: no shock, repeated" in sentence and "chosen here" in sentence
    assert "static: held" not in sentence and "stance" not in sentence  # both are known
    assert "static: held for at most 1 minute, rapid" in rows[1]["sentence"]


def test_a_population_has_a_share_of_people_who_score_no_more(tmp_path):
    text = HEAD + CRITERIA + "  - {name: most, check: share, of: [upper limbs], at_least: 50}\n"
    result = wb.run(study_of(tmp_path, text))
    found = result.population
    assert [row.check for row in found.requirements] == ["score"] * 3
    points = found.margin / 0.01
    np.testing.assert_allclose(points, np.rint(points), atol=1e-9)
    assert found.requirements[0].unit.column == "points"
    write_report(result, tmp_path / "out")
    told = next(line for line in result.warnings if "upper limbs" in line)
    assert "of its 24 values are chosen here" in told and "assumed: shock: no shock" in told
    assert "upper limbs [points]" in (tmp_path / "out" / "people.csv").read_text()


def test_of_a_motion_the_highest_score_counts_with_its_moment(tmp_path):
    time = np.array([0.0, 0.1, 0.2, 0.3])
    turns = np.zeros((4, len(BODY.joints), 3))
    turns[:, BODY.joint("RS"), 0] = np.radians([0, 15, 100, 0])
    text = STUDY_OF_FALL.split("criteria:")[0] + (
        "criteria:\n  - {name: arm, check: score, method: rula, at_most: 2,"
        " work: {load: 0, shock: false, stance: standing}}\n"
    )
    (tmp_path / "environments/pit").mkdir(parents=True)
    (tmp_path / "environments/pit/pit.obj").write_text(PLATE)
    (tmp_path / "environments/pit/environment.yaml").write_text(
        "environment: pit\nlength: mm\nmeshes: [{file: pit.obj, length: m, up: z, forward: x}]\n"
    )
    (tmp_path / "studies").mkdir()
    motion = standing(np.full(4, 1.0), time, angles=turns)
    (tmp_path / "studies/drop.csv").write_text("".join(angle_table_text(BODY, motion)))
    (tmp_path / "studies/drop.yaml").write_text(text)
    verdict = wb.run(wb.load_study(tmp_path / "studies/drop.yaml")).verdicts[0]
    scores = wb.rula(wb.place(BODY, motion), wb.Work(load=0, stance="standing")).score
    assert scores.argmax() == 2 and not verdict.passed
    assert verdict.worst.value == -scores[2]
    assert verdict.worst.time == pytest.approx(0.2, abs=0.01)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("method: rula", "check: score needs 'at_most'"),
        ("at_most: 3", "check: score needs 'method'"),
        ("method: rulla, at_most: 3", "method"),
        ("method: rula, at_most: 0", "1 to 15 points are possible"),
        ("method: rula, at_most: 3, work: {load: -1}", "greater than or equal to 0"),
        ("method: rula, at_most: 3, work: {lode: 1}", "lode"),
        ("method: rula, at_most: 3, rules: strain_owas", "strain_owas lacks values of strain_rula"),
        ("method: rula, at_most: 3, rules: none_such", "none_such"),
    ],
)
def test_wrong_keys_of_a_score_are_refused_where_they_stand(tmp_path, keys, message):
    text = f"{HEAD}criteria:\n  - {{name: bad, check: score, {keys}}}\n"
    with pytest.raises(InputError, match=message) as caught:
        study_of(tmp_path, text)
    assert "toy_crew.yaml:" in str(caught.value)
