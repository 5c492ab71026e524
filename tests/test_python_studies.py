"""Studies made and changed in Python: the same study as a file's, the same checks, nothing in silence."""

from __future__ import annotations

import inspect
import pickle
import re
from dataclasses import fields, replace

import numpy as np
import pytest

import workbench as wb
from tests.one_arm_cab import write_cab
from tests.test_arguments import ODD
from tests.toy_cockpit import write_toy

PEOPLE = {
    "anna": {"body": "one_arm", "seat": "stool", "position": {"forward": 0.01, "up": 0}},
    "bert": {
        "body": "one_arm",
        "at": {"segment": "BASE", "position": (0, 0.6, "900 mm"), "attitude": {"yaw": 90}},
    },
}
CASES = [
    {"name": "down", "people": {"anna": {"posture": "hanging"}, "bert": {"posture": "hanging"}}},
    {
        "name": "forward",
        "people": {
            "anna": {"posture": "bent", "angles": {"SHOULDER": {"flexion": 80}}},
            "bert": {"posture": "bent"},
        },
    },
]
CRITERIA = [
    {"name": "room", "check": "clearance", "at_least": 0.05},
    {"name": "apart", "check": "between_people", "at_least": "20 mm"},
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("python")


@pytest.fixture(scope="module")
def path(folder):
    return write_cab(folder)


@pytest.fixture(scope="module")
def loaded(path):
    return wb.load_study(path)


@pytest.fixture
def stated(loaded, folder, monkeypatch):
    """The study of the cab with other criteria, without its file."""
    monkeypatch.chdir(folder)
    return wb.study(loaded.environment, people=PEOPLE, cases=CASES, criteria=CRITERIA)


def worst(study):
    return [verdict.worst.value for verdict in wb.run(study).verdicts]


def test_a_study_of_a_call_answers_as_that_of_a_file(path, loaded, stated):
    text = path.read_text()
    head = text[: text.index("criteria:")]
    other = path.with_name("other.yaml")
    other.write_text(
        head + "criteria:\n"
        "  - {name: room, check: clearance, at_least: 50}\n"
        "  - {name: apart, check: between_people, at_least: 20}\n"
    )
    assert worst(stated) == worst(wb.load_study(other))
    assert [one.at_least for one in stated.criteria] == [0.05, 0.02]
    assert worst(pickle.loads(pickle.dumps(stated))) == worst(stated)


def test_what_a_call_says_is_in_the_provenance(stated, loaded):
    call = wb.run(stated).provenance["call"]
    assert call == wb.run(pickle.loads(pickle.dumps(stated))).provenance["call"]
    other = stated.with_(criteria={"room": {"at_least": 0.06}})
    assert wb.run(other).provenance["call"] != call
    assert "call" not in wb.run(loaded).provenance
    changed = wb.run(loaded.with_(title="other")).provenance
    assert "study" not in changed["inputs"] and len(changed["call"]["study"]) == 64


def test_a_field_changed_by_hand_is_refused_whichever_it_is(loaded):
    for name in [field.name for field in fields(loaded) if field.name != "name"]:
        changed = None if name == "statement" else object()
        other = replace(loaded, **{name: changed})
        with pytest.raises(wb.InputError, match=r"by hand"):
            wb.run(other)
        with pytest.raises(wb.InputError, match=r"by hand"):
            other.with_(title="other")


def test_moves_are_derived_anew(path, loaded):
    part = "wall"
    moved = loaded.with_(moved={part: (-0.3, 0, 0)})
    other = path.with_name("moved.yaml")
    other.write_text(path.read_text() + f"moved: [{{parts: [{part}], by: [-300, 0, 0]}}]\n")
    assert worst(moved) == worst(wb.load_study(other)) != worst(loaded)
    again = moved.with_(moved=[{"parts": [part], "by": ["-300 mm", 0, 0]}])
    assert worst(again) == worst(moved)
    assert worst(moved.with_(moved=[])) == worst(loaded)


def test_numbers_are_metres_also_where_the_file_counts_millimetres(loaded):
    """The file says forward: 10 (mm); its neighbour `up` stays in the unit of the file."""
    other = loaded.with_(people={"anna": {"position": {"forward": np.float32(0.03125)}}})
    assert other.roles[0].forward == 0.03125
    assert loaded.with_(title="other").roles[0].forward == 0.01
    with pytest.raises(wb.InputError, match=re.escape("-50 to 50 mm (got 20000 mm)")):
        loaded.with_(people={"anna": {"position": {"forward": 20}}})


def test_a_mapping_changes_what_it_names_and_none_takes_away(stated):
    fewer = stated.with_(
        people={"bert": None},
        cases={"forward": None, "down": {"people": {"bert": None}}},
        criteria={"apart": None, "room": {"at_least": 0.01}},
    )
    assert [role.name for role in fewer.roles] == ["anna"]
    assert [case.name for case in fewer.cases] == ["down"]
    assert [(one.name, one.at_least) for one in fewer.criteria] == [("room", 0.01)]
    assert len(stated.roles) == len(stated.cases) == len(stated.criteria) == 2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"criteria": {"rom": {"at_least": 0}}},
            "study.with_(...): criteria: nothing is called 'rom'; did you mean 'room'?",
        ),
        (
            {"criteria": {"room": {"at_leest": 0}}},
            "study.with_(...): criteria[0].at_leest: unknown key 'at_leest'; did you mean 'at_least'?",
        ),
        (
            {"people": {"anna": {"seat": "stol"}}},
            "study.with_(...): people.anna.seat: environment cab has no seat 'stol'; did you mean",
        ),
        ({"name": "a b"}, "study.with_(...): name: "),
        (
            {"moved": {"wal": (0, 0, 0)}},
            "study.with_(...): moved: environment cab has no part and no control 'wal'",
        ),
        (
            {"moved": [{"parts": ["seat"], "by": (0.1, 0)}]},
            "study.with_(...): moved[0].by: value 3 of the list is missing",
        ),
        ({"criteria": []}, "study.with_(...): key 'criteria' is missing"),
        ({"title": "\x1b[2J"}, "study.with_(...): title: a text with control characters"),
    ],
)
def test_faults_name_the_argument(stated, change, message):
    with pytest.raises(wb.InputError, match=re.escape(message)):
        stated.with_(**change)


def test_the_call_and_the_change_take_the_same_arguments(stated):
    call = inspect.signature(wb.study).parameters
    change = inspect.signature(stated.with_).parameters
    assert set(call) == set(change)


def test_anything_else_is_refused_in_our_own_words(stated, loaded):
    right = {"people": PEOPLE, "cases": CASES, "criteria": CRITERIA}
    loop: list = []
    loop.append(loop)
    found = []
    for name in inspect.signature(stated.with_).parameters:
        for bad in [*ODD, loop, {"anna": loop}, [{"name": object()}]]:
            for call in (
                lambda given: wb.study(**{"environment": loaded.environment, **right, **given}),
                lambda given: stated.with_(**given),
            ):
                try:
                    call({name: bad})
                except wb.WorkbenchError:
                    continue
                except Exception as error:  # noqa: BLE001
                    found.append(f"{name}={str(bad)[:50]}: {error!r}"[:300])
    assert found == []


def test_people_drawn_in_python_take_a_role(tmp_path, monkeypatch):
    study = wb.load_study(write_toy(tmp_path, people=4))
    monkeypatch.chdir(tmp_path)
    model = wb.load_population_model("ansur2")
    people = wb.draw_people(model, 3, seed=1)
    other = study.with_(people={"pilot": {"population": people}})
    assert wb.run(other).population.people is people
    few = people.of(["stature"])
    with pytest.raises(wb.InputError, match=r"people\.pilot\.population: .*lacks the measures"):
        study.with_(people={"pilot": {"population": few}})


def test_millimetres_where_metres_count_are_doubted(stated):
    words = "30 m is farther than environment cab is large (2 m): is a unit missing, as in '20 mm'?"
    other = stated.with_(criteria={"room": {"at_least": 30}}, moved={"wall": (30, 0, 0)})
    assert {f"criterion 'room': {words}", f"moved[0]: {words}"} <= set(other.warnings)
    assert not any("is a unit missing" in line for line in stated.warnings)
    with pytest.warns(UserWarning, match=re.escape(f"displacements: {words}")) as told:
        stated.environment.moved({"wall": (30, 0, 0)})
    assert told[0].filename == __file__


def test_methods_refuse_arguments_that_they_do_not_take(stated):
    with pytest.raises(
        wb.UsageError, match=r"with_\(...\): got an unexpected .*'moves'; did you mean"
    ):
        stated.with_(moves=[])


def test_a_result_is_written_as_a_folder(stated, tmp_path):
    wb.write_report(wb.run(stated), str(tmp_path / "out"))
    assert {"report.html", "result.json", "verdicts.csv"} <= {
        path.name for path in (tmp_path / "out").iterdir()
    }
    for result, folder in ((stated, tmp_path / "b"), (wb.run(stated), 3)):
        with pytest.raises(wb.UsageError, match="expected a"):
            wb.write_report(result, folder)


def test_a_body_made_in_python_takes_a_role_with_the_postures_of_its_name(stated, folder):
    arm = wb.load_body(folder / "bodies" / "one_arm.yaml")
    other = stated.with_(people={"anna": {"body": arm}, "bert": {"body": arm}})
    assert other.roles[0].body is arm
    assert worst(other) == worst(stated)
    assert "call" in wb.run(other).provenance
    both = wb.stack_bodies([arm, arm])
    with pytest.raises(wb.InputError, match=r"people\.anna\.body: one body is needed, got 2 rows"):
        stated.with_(people={"anna": {"body": both}})


def test_named_things_may_be_a_mapping_of_their_names(stated):
    named = [
        {one["name"]: {key: one[key] for key in one if key != "name"} for one in rows}
        for rows in (CASES, CRITERIA)
    ]
    cases, criteria = named
    other = wb.study(stated.environment, people=PEOPLE, cases=cases, criteria=criteria)
    assert worst(other) == worst(stated)
