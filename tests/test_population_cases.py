"""A population in several cases, beside other people, and without a seat."""

from __future__ import annotations

import csv

import numpy as np
import pytest

import workbench as wb
from tests.crowds import crowd_of
from tests.toy_cockpit import write_toy
from workbench.cli import main

HEAD = """
study: toy_crew
length: mm
environment: toy
"""
SEATED = "{body: adult_male, detail: coarse, seat: pilot, population: {people: 4, seed: 3}}"
CRITERIA = """
criteria:
  - {name: knobs, check: reach, controls: [knob], hand: right}
  - {name: head room, check: clearance, segments: [H], parts: [roof], at_least: 150}
"""
LOOKING = "{name: looking, people: {pilot: {predicted: {like: driving, eyes: eye}}}}"
LEANING = "{name: relaxed, people: {pilot: {predicted: {like: relaxed, eyes: eye}}}}"


def written(folder, people, cases, criteria=CRITERIA):
    """The path of a study in the toy cockpit."""
    rows = "\n".join(f"  - {case}" for case in cases)
    roles = "\n".join(f"  {name}: {role}" for name, role in people.items())
    text = f"{HEAD}people:\n{roles}\npostures:\n  relaxed: {{like: driving, angles: {{RE: {{flexion: 10}}}}}}\n"
    return write_toy(folder, study=f"{text}cases:\n{rows}\n{criteria}")


def names(found):
    return [requirement.name for requirement in found.requirements]


def test_a_population_meets_the_criteria_of_all_cases_together(tmp_path):
    both = written(tmp_path / "both", {"pilot": SEATED}, [LOOKING, LEANING])
    found = wb.run(wb.load_study(both)).population
    assert names(found) == [
        "reach knob by the right hand, looking",
        "reach knob by the right hand, relaxed",
        "head room, looking",
        "head room, relaxed",
    ]
    for number, case in enumerate((LOOKING, LEANING)):
        alone = written(tmp_path / str(number), {"pilot": SEATED}, [case])
        own = wb.run(wb.load_study(alone)).population
        np.testing.assert_array_equal(found.margin[:, number::2], own.margin)


def test_a_criterion_of_one_case_is_asked_of_that_case_alone(tmp_path):
    criteria = CRITERIA.replace("at_least: 150", "at_least: 150, cases: [relaxed]")
    path = written(tmp_path, {"pilot": SEATED}, [LOOKING, LEANING], criteria)
    assert names(wb.run(wb.load_study(path)).population)[2:] == ["head room"]


BESIDE = "{body: adult_male, detail: coarse, stand: {on: [-700, 60, 0]}}"
TOGETHER = (
    "{name: together, people: {pilot: {predicted: {like: driving, eyes: eye}}, "
    "other: {posture: standing}}}"
)
APART = CRITERIA + "  - {name: apart, check: between_people, at_least: 200}\n"


@pytest.fixture(scope="module")
def company(tmp_path_factory):
    """The path of a study of four people beside somebody who stands behind the seat."""
    folder = tmp_path_factory.mktemp("company")
    people = {"other": BESIDE, "pilot": SEATED}
    return written(folder, people, [TOGETHER], APART)


def test_each_of_a_population_keeps_the_distance_to_those_beside(company):
    result = wb.run(wb.load_study(company))
    found = result.population
    margin = found.margin[:, names(found).index("apart")]
    assert [person.name for person in result.postures[0].people] == ["other"]
    other = result.postures[0].people[0].placed
    crowd = crowd_of(company)
    for row in range(4):
        there = crowd.situations(crowd.bodies[row], [row])[0]
        near = wb.body_clearance(there.placed, other).distance
        assert margin[row] == pytest.approx(near[np.isfinite(near)].min() - 0.2, abs=1e-9)
    assert margin.min() < margin.max()


def test_those_beside_a_population_are_judged_by_themselves(company, tmp_path):
    result = wb.run(wb.load_study(company))
    (verdict,) = [v for v in result.verdicts if v.criterion.name == "head room"]
    assert verdict.passed == (result.postures[0].people[0].placed.centres[..., 2].max() < 1.2)
    assert "apart" not in [v.criterion.name for v in result.verdicts]
    out = tmp_path / "out"
    main(["run", str(company), "--out", str(out)])
    page = (out / "report.html").read_text()
    assert "other: adult male" in page and "4 people" in page


STANDING = (
    "{body: adult_male, detail: coarse, stand: {on: [600, 0, 0]}, population: {people: 3, seed: 3}}"
)
UP = "{name: up, people: {pilot: {posture: standing}}}"
TALL = """
criteria:
  - name: under the roof
    check: excursion
    segments: [H]
    direction: [0, 0, 1]
    origin: [0, 0, 0]
    at_most: 1600
  - {name: free of the panel, check: clearance, parts: [panel], at_least: 0}
"""


def test_a_population_stands_with_its_feet_on_the_floor_and_is_measured_there(tmp_path):
    path = written(tmp_path, {"pilot": STANDING}, [UP], TALL)
    found = wb.run(wb.load_study(path)).population
    crowd = crowd_of(path)
    (there,) = crowd.situations(crowd.bodies[:], range(3))
    body = there.body
    low = (there.placed.centres[:, :, 2] - body.radius).min(axis=1)
    np.testing.assert_allclose(low, 0.0, atol=1e-12)
    head = body.spheres(body.segment("H"))
    top = (there.placed.centres[:, head, 2] + body.radius[:, head]).max(axis=1)
    np.testing.assert_allclose(found.margin[:, 0], 1.6 - top, atol=1e-12)
    assert np.isfinite(found.margin[:, 1]).all() and not found.moved.any()


def test_the_report_of_people_who_stand_names_no_seat(tmp_path):
    path = written(tmp_path, {"pilot": STANDING}, [UP], TALL)
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 0
    page = (tmp_path / "out" / "report.html").read_text()
    assert "in the seat" not in page
    with (tmp_path / "out" / "people.csv").open() as lines:
        assert len(list(csv.DictReader(lines))) == 3


def test_an_overlap_with_somebody_beside_is_a_shortfall_with_words(tmp_path):
    near = BESIDE.replace("-700, 60", "-230, 60")
    people = {"other": near, "pilot": SEATED}
    found = wb.run(wb.load_study(written(tmp_path, people, [TOGETHER], APART))).population
    column = names(found).index("apart")
    worst = int(np.argmin(found.margin[:, column]))
    assert found.margin[worst, column] < 0
    assert "other's" in found.reasons[int(found.reason[worst, column])].at
