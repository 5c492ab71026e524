"""One study with several sizes, with postures and motions, with several people who move."""

from __future__ import annotations

import json

import numpy as np
import pytest

import workbench as wb
from tests.test_crash import BODY, PLATE, standing
from workbench import InputError
from workbench.cli import main
from workbench.files.motions.tables import angle_table_text

SIZES = """study: sizes
length: mm
environment: pit
people:
  visitor:
    body: bubbleman
    stand: {on: [0, 0, 0]}
    sizes:
      small woman: {sex: female, measures: {stature: 1525}}
      large man: {sex: male, measures: {stature: 1870}}
cases:
  - {name: standing, people: {visitor: {posture: standing}}}
criteria:
  - {name: headroom, check: clearance, segments: [H], parts: [ceiling], at_least: 200}
"""
MIXED = """study: mixed
length: mm
environment: pit
people: {occupant: {body: bubbleman, stand: {on: [0, 0, 50]}}}
cases:
  - {name: before, people: {occupant: {posture: standing}}}
  - {name: the fall, people: {occupant: {motion: {file: drop.csv}}}}
criteria:
  - {name: clear of the plate, check: clearance, parts: [plate], at_least: 20}
  - {name: joints, check: stops}
"""
TWO = """study: two
length: mm
environment: pit
people: {one: {body: bubbleman}, other: {body: bubbleman}}
cases:
  - name: both fall
    people: {one: {motion: {file: drop.csv}}, other: {motion: {file: drop.csv, move: [0, 800, 0]}}}
criteria:
  - {name: apart, check: between_people, at_least: 100}
  - {name: one stays high, check: excursion, people: [one], segments: [H], at_most: 3000,
     direction: [0, 0, 1], origin: [0, 0, 0]}
"""
CEILING = "o ceiling\nv -2 -2 2\nv 2 -2 2\nv 2 2 2\nv -2 2 2\nf -4 -3 -2 -1\n"


@pytest.fixture
def pit(tmp_path):
    """A plate to fall on, 2 m below a ceiling, and a man who falls 100 mm."""
    (tmp_path / "environments/pit").mkdir(parents=True)
    (tmp_path / "environments/pit/pit.obj").write_text(PLATE + CEILING)
    (tmp_path / "environments/pit/environment.yaml").write_text(
        "environment: pit\nlength: mm\nmeshes: [{file: pit.obj, length: m, up: z, forward: x}]\n"
    )
    (tmp_path / "studies").mkdir()
    time = np.array([0, 0.05, 0.07, 0.09, 0.2])
    fall = standing(np.array([0.1, 0.0, -0.04, 0.0, 0.2]), time)
    (tmp_path / "studies/drop.csv").write_text("".join(angle_table_text(BODY, fall)))

    def write(text):
        path = tmp_path / "studies/study.yaml"
        path.write_text(text)
        return path

    return write


def test_several_sizes_take_their_place_one_at_a_time_and_each_is_judged(pit, tmp_path, capsys):
    path = pit(SIZES)
    result = wb.run(wb.load_study(path))
    gaps = {verdict.row: verdict.worst.value for verdict in result.verdicts}
    assert gaps == {
        "small woman": pytest.approx(2.0 - 1.525, abs=2e-3),
        "large man": pytest.approx(2.0 - 1.870, abs=2e-3),
    }
    assert [verdict.passed for verdict in result.verdicts] == [True, False]
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().out
    assert "passed  headroom, small woman:" in said and "FAILED  headroom, large man:" in said
    rows = json.loads((tmp_path / "out/result.json").read_text())
    assert [section["row"] for section in rows["postures"]] == ["small woman", "large man"]
    assert (tmp_path / "out/contacts.csv").read_text().startswith("size,case,person,")


def test_each_of_several_sizes_is_answered_as_alone(pit):
    both = wb.run(wb.load_study(pit(SIZES)))
    text = SIZES.replace("sizes:\n      small woman: ", "size: ").replace(
        "      large man: {sex: male, measures: {stature: 1870}}\n", ""
    )
    alone = wb.run(wb.load_study(pit(text)))
    assert both.verdicts[0].worst.value == alone.verdicts[0].worst.value
    distances = both.postures[0].people[0].clearance.distance
    assert np.array_equal(distances, alone.postures[0].people[0].clearance.distance)


def test_postures_and_motions_of_one_study_are_judged_side_by_side(pit, tmp_path, capsys):
    path = pit(MIXED)
    found = wb.run(wb.load_study(path))
    told = {(v.criterion.name, v.motion): v.worst.value for v in found.verdicts}
    assert told["clear of the plate", ""] == pytest.approx(0.05, abs=1e-6)
    assert told["clear of the plate", "the fall"] == pytest.approx(-0.04, abs=1e-3)
    assert ("joints", "") in told and ("joints", "the fall") in told
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 1
    page = (tmp_path / "out/report.html").read_text()
    assert "<h2>Cases</h2>" in page and "<h2>What happens</h2>" in page
    capsys.readouterr()


def test_two_people_who_move_are_as_far_apart_as_they_were_put(pit):
    found = wb.run(wb.load_study(pit(TWO)))
    assert [motion.study.name for motion in found.motions] == ["both fall, one", "both fall, other"]
    apart = next(v for v in found.verdicts if v.criterion.check == "between_people")
    body = wb.load_body("bubbleman")
    placed = wb.place(body, found.motions[0].study.motion.rows(slice(0, 1)))
    centres = placed.centres[0]
    gaps = np.linalg.norm(centres[:, None] - (centres + np.array((0, 0.8, 0)))[None], axis=2)
    gaps -= body.radius[0][:, None] + body.radius[0][None]
    assert apart.worst.value == pytest.approx(gaps.min(), abs=1e-9)
    assert apart.motion == "both fall" and apart.passed == (gaps.min() >= 0.1)
    assert [v.motion for v in found.verdicts if v.criterion.check == "excursion"] == [
        "both fall, one"
    ]


def test_more_than_two_motions_are_found_each_by_itself(pit):
    case = "  - {{name: {0}, people: {{occupant: {{motion: {{file: drop.csv, move: [0, 0, {1}]}}}}}}}}\n"
    cases = "".join(case.format(name, by) for name, by in (("a", 0), ("b", 30), ("c", 60)))
    text = MIXED.replace(", stand: {on: [0, 0, 50]}", "")
    head, tail = text.split("cases:\n")
    text = f"{head}cases:\n{cases}criteria:\n{tail.split('criteria:')[1].lstrip(chr(10))}"
    found = wb.run(wb.load_study(pit(text)))
    nearest = {v.motion: v.worst.value for v in found.verdicts if v.criterion.check == "clearance"}
    assert nearest == {
        name: pytest.approx(by, abs=1e-3)
        for name, by in zip("abc", (-0.04, -0.01, 0.02), strict=False)
    }


def test_a_role_that_stands_still_while_another_moves_is_refused(pit):
    still = "{posture: standing}"
    text = TWO.replace("{motion: {file: drop.csv, move: [0, 800, 0]}}", still)
    text = text.replace(
        "other: {body: bubbleman}", "other: {body: bubbleman, stand: {on: [0, 800, 0]}}"
    )
    with pytest.raises(
        InputError, match="'one' moves in this case, so this role needs a motion too"
    ):
        wb.load_study(pit(text))


def test_only_the_role_with_several_sizes_moves_once_for_each_of_them(pit):
    sizes = "sizes: {a: {sex: male, measures: {stature: 1700}}, b: {sex: male, measures: {stature: 1800}}}"
    text = TWO.replace("one: {body: bubbleman}", f"one: {{body: bubbleman, {sizes}}}")
    found = wb.run(wb.load_study(pit(text)))
    assert [motion.study.name for motion in found.motions] == [
        "both fall, one, a",
        "both fall, one, b",
        "both fall, other",
    ]
