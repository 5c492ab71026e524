"""Accommodation studies that cannot be: each is told in one line, where it stands, with what would
be right."""

from __future__ import annotations

import csv

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT, SHARED, needs_real_input
from tests.crowds import crowd_of
from tests.toy_cockpit import ENVIRONMENT, STUDY, write_toy
from workbench import MissingPartError, load_study
from workbench.cli import main
from workbench.model.accommodation import Requirement
from workbench.model.criterion import Criterion
from workbench.study.accommodation.accommodation import _unmet_requirements
from workbench.study.accommodation.limiting_dimensions import odd_people
from workbench.study.checks.margins import Asked
from workbench.study.executors import dask_executor
from workbench.study.warnings import controls_inside_solids

CRITERIA = STUDY[STUDY.index("criteria:") :]
MORE = "criteria:"
CASES = [
    ("eye_height, below: 60, above: 60", "eye_height", "eye_height needs 'below' or 'above'"),
    (
        "controls: [knob, near]",
        "controls: [knobb]",
        "nothing is called 'knobb'; did you mean 'knob'?",
    ),
    ("segments: [H]", "segments: [HEAD]", "nothing is called 'HEAD'"),
    ("segments: [H]", "subparts: [H/ear]", "criteria[2].subparts[0]: nothing is called 'H/ear'"),
    ("segments: [H]", "segments: [H], subparts: [H/nose]", "'segments' and 'subparts' exclude"),
    ("parts: [roof]", "parts: [roofs]", "did you mean 'roof'?"),
    ("name: view,", "name: knobs,", "two criteria are named 'knobs'"),
    (", at_least: 150", "", "check: clearance needs 'at_least'"),
    (
        "seat: pilot",
        "seat: copilot",
        "environment toy has no seat 'copilot'; did you mean 'pilot'?",
    ),
    ("like: driving", "like: flying", "predicted.like: no posture 'flying'"),
    ("detail: coarse", "clothes: [hat]", "no bodies/encumbrance entry named 'hat'"),
    ("detail: coarse", "detail: tiny", "input should be 'coarse', 'medium' or 'fine'"),
    ("eyes: eye", "eyes: nose", "has no point 'nose'"),
    (
        "{like: driving, eyes: eye}",
        "{like: driving}",
        "check: eye_height fits no case: it needs 'eyes' in the action",
    ),
    (
        "check: clearance, segments: [H], parts: [roof], at_least: 150",
        "check: pedals",
        "check: pedals fits no case: it needs 'feet' in the action",
    ),
    (
        "people: PEOPLE, seed: 3",
        "people: 10",
        "people that are drawn need 'people', how many, and a 'seed'",
    ),
    (
        "people: PEOPLE, seed: 3",
        "people: all, seed: 3",
        "'people: all' are the measured people as they are: 'seed', 'women' and 'synthetic' belong",
    ),
    (
        "people: PEOPLE, seed: 3",
        "people: 10, seed: 3, source: nasa",
        "no bodies/populations entry named 'nasa'",
    ),
    (
        "people: PEOPLE, seed: 3",
        "people: 10, seed: 3, weights: w",
        "'unit' and 'weights' belong to 'files'",
    ),
    ("people: PEOPLE, seed: 3", "people: 0, seed: 3", "greater than or equal to 1 (got 0)"),
    ("people: PEOPLE, seed: 3", "people: '10', seed: 3", "a whole number is needed (got '10')"),
    ("people: PEOPLE, seed: 3", "files: [none.csv]", "no such file"),
    (
        "people: PEOPLE, seed: 3",
        "files: [none.csv, none.csv]",
        "population.files[1]: 'none.csv' is named already",
    ),
    (
        "people: PEOPLE, seed: 3",
        "people: 10, seed: 3, sexes: [female], women: 50",
        "a share of both sexes",
    ),
    (
        "people: PEOPLE, seed: 3",
        "people: 10, seed: 3, women: 101",
        "less than or equal to 100 (got 101)",
    ),
    (
        "population: {people: PEOPLE, seed: 3}",
        "population: {people: 9, seed: 3}, size: {sex: male, measures: {stature: 1800}}",
        "'size' and 'population' exclude each other",
    ),
    (CRITERIA, "criteria: []\n", "at least 1"),
    (MORE, "shares: {mixes: {all: 150}}\ncriteria:", "less than or equal to 100"),
    (MORE, "shares: {confidence: 100}\ncriteria:", "shares.confidence: input should be less"),
    (MORE, "shares: {interval: {method: bootstrap}}\ncriteria:", "a bootstrap needs a 'seed'"),
    (MORE, "changes: [{name: x, control: knob}]\ncriteria:", "'move' says by how much"),
    (MORE, "changes: [{name: x, higher: 9}]\ncriteria:", "a change is of 'control'"),
    (
        MORE,
        "changes: [{name: x, seat: pilots, higher: 9}]\ncriteria:",
        "changes[0].seat: environment toy has no seat 'pilots'; did you mean 'pilot'?",
    ),
    (
        MORE,
        "changes: [{name: x, control: handle, move: [1, 0, 0]}]\ncriteria:",
        "has no control 'handle'",
    ),
    (
        MORE,
        "changes: [{name: x, controls: [kn, 'z*'], move: [1, 0, 0]}]\ncriteria:",
        "changes[0].controls[1]: environment toy has no control 'z*'",
    ),
    (
        MORE,
        "changes: [{name: x, control: knob, move: [1, 0, 0], "
        "moved: [{controls: [kno*], by: [1, 0, 0]}]}]\ncriteria:",
        "changes[0].moved[0].controls[0]: control 'knob' is moved by 'move' already; move it once",
    ),
    (
        MORE,
        "changes: [{name: x, moved: [{by: [1, 0, 0]}]}]\ncriteria:",
        "'control', 'controls' or 'parts' says what is moved",
    ),
    (
        MORE,
        "changes: [{name: x, seat: pilot, lower: 1}, {name: x, seat: pilot, higher: 1}]\ncriteria:",
        "two of changes are named 'x'",
    ),
    (MORE, "reach_maps: [{people: pilot, part: wall}]\ncriteria:", "has no part 'wall'"),
    (
        MORE,
        "reach_maps: [{people: pilott, part: panel}]\ncriteria:",
        "nobody is called 'pilott'; did you mean 'pilot'?",
    ),
    (
        MORE,
        "reach_envelopes: [{people: pilot}]\ncriteria:",
        "an envelope is of one person; ask for 'reach_maps' of a population",
    ),
    (
        MORE,
        "compare: [sitting, sitting]\ncriteria:",
        "compare[1]: 'sitting' is named twice; two different cases are compared",
    ),
    (MORE, "signals: {filter_class: 60}\ncriteria:", "'signals' are of motions"),
    (
        "check: clearance",
        "check: clearance, controls: [knob]",
        "'controls' does not belong to check: clearance",
    ),
    (
        "  - {name: view,",
        "  - {name: again, check: reach, controls: [near], hand: right}\n  - {name: view,",
        "near in zone 1 is asked for by 'knobs' already",
    ),
    (
        "  - {name: view,",
        "  - {name: most, check: share, at_least: 95, of: [knob]}\n  - {name: view,",
        "criteria[1].of[0]: nothing is called 'knob'; did you mean 'knobs'?",
    ),
    (
        "  - {name: view,",
        "  - {name: most, check: share, at_least: 195}\n  - {name: view,",
        "criteria[1].at_least: 0 to 100 percent are possible (got 195)",
    ),
    (
        CRITERIA,
        "criteria: [{name: most, check: share, at_least: 95}]\n",
        "nothing is left to ask: a share is of those who meet other criteria",
    ),
    (
        "predicted: {like: driving, eyes: eye}",
        "posture: driving",
        "check: eye_height fits no case: it is asked of a predicted posture",
    ),
    (
        "seat: pilot, population",
        "seat: pilot, position: {tilt: 5}, population",
        "position.tilt: seat 'pilot' cannot be tilted",
    ),
]


@pytest.mark.parametrize(("old", "new", "said"), CASES, ids=[case[2][:40] for case in CASES])
def test_what_is_wrong_is_told_with_its_line(tmp_path, capsys, old, new, said):
    assert old in STUDY
    path = write_toy(tmp_path, study=STUDY.replace(old, new, 1))
    assert main(["check", str(path)]) == 3
    told = capsys.readouterr().err
    assert said in told and "Traceback" not in told
    assert "toy_crew.yaml:" in told or "none.csv" in told


def test_two_controls_of_one_name_are_refused_with_their_line(tmp_path):
    path = write_toy(tmp_path)
    place = tmp_path / "environments" / "toy" / "environment.yaml"
    place.write_text(
        ENVIRONMENT.replace("KNOB", "700")
        + "  knob: {at: [1, 2, 3], grip: push, zone: 1, part: panel}\n"
    )
    with pytest.raises(wb.InputError, match=r"environment.yaml:\d+"):
        load_study(path)


def test_a_control_inside_a_solid_is_told(tmp_path):
    path = write_toy(tmp_path)
    place = tmp_path / "environments" / "toy" / "environment.yaml"
    place.write_text(ENVIRONMENT.replace("[KNOB, -180, 850]", "[200, 0, 250]"))
    assert (
        "control 'knob' is inside the solid part 'pan'"
        in controls_inside_solids(load_study(path).environment)[0]
    )


def rows_file(folder, change=lambda table: None):
    """A CSV of three people of the public rows' layout, made from the model's medians."""
    model = wb.load_population_model("ansur2")
    names = [name for name in model.names if name not in ("mass", "interpupillary_breadth")]
    middle = model.quantiles[:, :, len(model.levels) // 2]
    table = [["SubjectId", "Gender", *(name.replace("_", "") for name in names)]]
    for n in range(3):
        row = middle[n % 2, [model.names.index(name) for name in names]]
        table.append(
            [f"p{n}", ("Male", "Female")[n % 2], *(f"{1000 * value:.0f}" for value in row)]
        )
    change(table)
    with (folder / "rows.csv").open("w", newline="") as file:
        csv.writer(file).writerows(table)
    return write_toy(folder, swap={"people: 10, seed: 3": "files: [../rows.csv]"})


def test_a_man_of_17_metres_is_named_by_row_and_column(tmp_path):
    def tall(table):
        table[2][table[0].index("stature")] = "17550"

    with pytest.raises(
        wb.InputError, match=r"rows.csv:3: stature: 17550 mm is absurd for a person; 630 to 2800 mm"
    ):
        load_study(rows_file(tmp_path, tall))


def test_check_tells_of_the_same_odd_people_as_a_run(tmp_path, capsys):
    def high_knee(table):
        table[2][table[0].index("kneeheightsitting")] = "700"

    path = rows_file(tmp_path, high_knee)
    assert main(["check", str(path)]) == 0
    told = capsys.readouterr().err
    (said,) = odd_people(load_study(path).crowd.population)
    assert "p1 (knee_height_sitting 700 mm)" in said
    assert f"{path}: warning: {said}" in told


def test_check_tells_of_an_improbable_size_as_a_run_does(tmp_path, capsys):
    sized = "size: {sex: male, measures: {stature: 1900, sitting_height: 800}}"
    study = STUDY[: STUDY.index("criteria:")] + "criteria:\n  - {name: stops, check: stops}\n"
    swap = {"population: {people: 10, seed: 3}": sized}
    path = write_toy(tmp_path, study=study, swap=swap)
    assert main(["check", str(path)]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "sitting height 800 mm is" in told and "there may be no such person" in told


def test_measures_that_only_some_files_have_are_told(tmp_path):
    path = rows_file(tmp_path, lambda table: None)
    with (tmp_path / "rows.csv").open(newline="") as file:
        table = list(csv.reader(file))
    out = table[0].index("chestbreadth")
    with (tmp_path / "few.csv").open("w", newline="") as file:
        csv.writer(file).writerows([row[:out] + row[out + 1 :] for row in table])
    both = "files: [../rows.csv, ../few.csv]"
    path.write_text(path.read_text().replace("files: [../rows.csv]", both))
    (said,) = [words for words in load_study(path).warnings if "not read" in words]
    assert said.endswith(
        "rows.csv: chest breadth: not read, as not every file of these people has it"
    )


def test_a_missing_measure_is_named_by_row_and_column(tmp_path):
    def empty(table):
        table[1][table[0].index("thumbtipreach")] = ""

    with pytest.raises(
        wb.InputError, match=r"rows.csv:2: thumbtipreach: a number is needed \(got ''\)"
    ):
        load_study(rows_file(tmp_path, empty))


def test_a_missing_column_that_a_workplace_needs_is_named(tmp_path):
    def without(table):
        column = table[0].index("buttockkneelength")
        for row in table:
            del row[column]

    with pytest.raises(wb.InputError, match=r"missing: buttock_knee_length"):
        load_study(rows_file(tmp_path, without))


def test_whole_rows_are_read(tmp_path):
    people = crowd_of(rows_file(tmp_path)).people
    assert len(people) == 3 and people.labels == ("p0", "p1", "p2")


def asked(*names):
    return tuple(
        Asked(Requirement(n, n, "eye_height", ""), Criterion(n, "eye_height", (), (), (), 0.0))
        for n in names
    )


def test_what_nobody_meets_and_what_contradicts_is_told():
    met = np.zeros((40, 3), dtype=bool)
    met[:20, 0] = True
    met[20:, 1] = True
    margin = np.where(met, 0.0, -0.04)
    told = _unmet_requirements(asked("low", "high", "never"), margin)
    assert told[0].startswith("nobody meets 'never': it is missed by at least 40 mm: check")
    assert told[1] == (
        "nobody meets both 'low' and 'high' in the position of the seat found for them: the two may "
        "contradict each other"
    )
    assert (
        _unmet_requirements(asked("low", "high"), margin[:, :2][::2][:4]) != told
    )  # a few people contradict nothing


def test_a_seat_that_does_not_move_is_a_seat(tmp_path):
    assert load_study(write_toy(tmp_path)).environment.seat("pilot").travel_forward == (
        0.0,
        0.0,
    )


def test_a_cluster_without_dask_says_what_to_install(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with (
        pytest.raises(MissingPartError, match=r"pip install 'bubbleman-workbench\[cluster\]'"),
        dask_executor("local"),
    ):
        pass


def test_a_cluster_is_for_many_people(capsys):
    study = str(ROOT / "studies" / "trainer_clearance.yaml")
    assert main(["run", study, "--out", "never", "--cluster", "local"]) == 2
    assert "--cluster is for studies of a population" in capsys.readouterr().err


@needs_real_input(SHARED)
def test_the_public_files_are_a_population(tmp_path):
    paths = sorted((SHARED / "anthropometry" / "ansur2").glob("*.csv"))
    names = ", ".join(str(path) for path in paths)
    path = write_toy(tmp_path, swap={"people: 10, seed: 3": f"files: [{names}], people: 100"})
    people = crowd_of(path).people
    assert len(people) == 100 and 0.2 < np.mean(people.sex == 1) < 0.5
