"""Bad studies, postures and environments: every fault with its line, its key, what was given, what
would be right."""

from __future__ import annotations

import json

import pytest

import workbench as wb
from tests.conftest import ONE_ARM, ROOT
from tests.one_arm_cab import (
    ENVIRONMENT,
    POSTURES,
    STUDY,
    changed,
    line_with,
    lines_of,
    mutants,
    write_cab,
)
from workbench import InputError
from workbench.cli import main
from workbench.files.kinds import check_file, kind_of


def problems(folder, **files):
    path = write_cab(folder, **files)
    with pytest.raises(InputError) as caught:
        wb.load_study(path)
    return caught.value.problems


def check(folder, kind, text, words):
    """Exactly one fault, in this file, on the first line that was changed, with these words in
    it."""
    good, name = {"study": (STUDY, "cab_study"), "postures": (POSTURES, "arms")}[kind]
    pairs = zip(good.splitlines(), text.splitlines(), strict=False)
    line = next(n for n, (one, other) in enumerate(pairs, start=1) if one != other)
    found = problems(folder, **{kind: text})
    assert lines_of(found) == [line], found
    assert f"/{name}.yaml:" in found[0]
    assert words in found[0], found


def test_the_unchanged_study_loads(tmp_path):
    study = wb.load_study(write_cab(tmp_path))
    assert [role.name for role in study.roles] == ["anna", "bert"]
    assert study.criteria[1].parts == ("wall",)
    assert study.criteria[0].parts == ("floor", "wall", "seat", "rest")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "environment: cab",
            "environment: cabb",
            "environment: no environments entry named 'cabb'; did you mean 'cab'? valid",
        ),
        (
            "environment: cab",
            "environment: ../none.yaml",
            "environment: ../none.yaml: no such file (looked from ",
        ),
        (
            "bert: {body: one_arm",
            "bert: {body: one_leg",
            "people.bert.body: no bodies entry named 'one_leg'; valid: ",
        ),
        (
            "bert: {body: one_arm",
            "bert: {body: " + "x" * 300,
            "people.bert.body: no bodies entry named 'xxx",
        ),
        (
            "seat: stool",
            "seat: stul",
            "people.anna.seat: environment cab has no seat 'stul'; did you mean 'stool'? valid: ",
        ),
        (
            "forward: 10",
            "forward: 51",
            "position.forward: beyond the travel of seat stool, -50 to 50 mm (got 51 mm)",
        ),
        (
            "up: 0}",
            "up: -1 in}",
            "position.up: beyond the travel of seat stool, -20 to 20 mm (got -25.4 mm)",
        ),
        (
            "seat: stool, position: {forward: 10, up: 0}",
            "position: {forward: 1}",
            "'position' is that of a seat: give 'seat' too",
        ),
        (
            "seat: stool, position: {forward: 10, up: 0}",
            "detail: null",
            "people.anna: 'seat', 'at' or 'stand' must say where the role is",
        ),
        (
            "seat: stool",
            "seat: stool, stand: {on: [0, 0, 0]}",
            "'seat' and 'stand' exclude each other: give one of 'seat', 'at' and 'stand'",
        ),
        (
            "at: {segment: BASE",
            "position: {up: 1}, at: {segment: BASE",
            "'position' is that of a seat: give 'seat' too",
        ),
        (
            "at: {segment: BASE",
            "at: {segment: BSAE",
            "at.segment: unknown segment 'BSAE'; did you mean 'BASE'? valid: BASE,",
        ),
        (
            "position: [0, 600, 900]",
            "position: [0, 600]",
            "at.position: value 3 of the list is missing (got [0, 600])",
        ),
        (
            "position: [0, 600, 900]",
            "position: [0, .nan, 0]",
            "at.position[1]: input should be a finite number (got nan)",
        ),
        (
            "position: [0, 600, 900]",
            "position: [0, 6 feet, 0]",
            "units: mm, cm, m, in, ft (got '6 feet')",
        ),
        (
            "attitude: {yaw: 90}",
            "attitude: {yaw: 9000}",
            "attitude.yaw: input should be less than or equal to 720",
        ),
        (
            "attitude: {yaw: 90}",
            "attitude: {jaw: 90}",
            "attitude.jaw: unknown key 'jaw'; did you mean 'yaw'? valid: pitch",
        ),
        (
            "bert: {posture: bent}",
            "bert: {posture: band}",
            "cases[1].people.bert.posture: no posture 'band'; valid: hanging, bent",
        ),
        (
            "SHOULDER: {flexion: 80}",
            "SHOLDER: {flexion: 80}",
            "angles.SHOLDER: body one_arm has no joint 'SHOLDER'; did you",
        ),
        (
            "SHOULDER: {flexion: 80}",
            "SHOULDER WRST: {flexion: 80}",
            "has no joint 'WRST'; did you mean 'WRIST'",
        ),
        (
            "SHOULDER: {flexion: 80}",
            "'': {flexion: 80}",
            "angles.'': no joint is named here; valid: SHOULDER",
        ),
        (
            "SHOULDER: {flexion: 80}",
            "SHOULDER: {flexon: 80}",
            "joint SHOULDER: no motion 'flexon'; did you mean 'flexion'",
        ),
        (
            "SHOULDER: {flexion: 80}",
            "SHOULDER: {flexion: 800}",
            "flexion: input should be less than or equal to 720",
        ),
        ("SHOULDER: {flexion: 80}", "SHOULDER: {flexion: .inf}", "finite number (got inf)"),
        (
            "SHOULDER: {flexion: 80}",
            "SHOULDER: 80",
            "angles.SHOULDER: a mapping of keys is needed (got 80)",
        ),
        ("name: forward", "name: down", "cases[1].name: two cases are named 'down'"),
        (
            "name: joints",
            "name: nobody is in himself",
            "criteria[4].name: two criteria are named 'nobody is in himself'",
        ),
        (
            "people: [anna]",
            "people: [ana]",
            "criteria[1].people[0]: nothing is called 'ana'; did you mean 'anna'? valid: ",
        ),
        (
            "segments: [HAND]",
            "segments: [HND]",
            "criteria[1].segments[0]: nothing is called 'HND'; did you mean 'HAND'",
        ),
        (
            "segments: [HAND]",
            "segments: [lower arm]",
            "nothing is called 'lower arm'; did you mean 'LOWER'?",
        ),
        (
            "segments: [HAND]",
            "segments: []",
            "criteria[1].segments: at least 1 are needed (got [])",
        ),
        (
            "segments: [HAND]",
            "segments: HAND",
            "criteria[1].segments: a list is needed (got 'HAND')",
        ),
        (
            '["w*"]',
            '["x*"]',
            "criteria[1].parts[0]: nothing is called 'x*'; valid: floor, wall, seat, rest",
        ),
        (
            '["w*"]',
            "[secret]",
            "criteria[1].parts[0]: part 'secret' is hidden, so it is not checked; ",
        ),
        (", at_least: 100", "", "criteria[1]: check: clearance needs 'at_least'"),
        (
            "at_least: 100",
            "down: 5, at_least: 9",
            "criteria[1]: 'down' does not belong to check: clearance, whose keys are at_least, ",
        ),
        (
            "check: self_contact",
            "check: self_contact, at_least: 3",
            "'at_least' does not belong to check: self_contact, whose keys are segments",
        ),
        (
            "check: self_contact",
            "check: self_contact, parts: [wall]",
            "'parts' does not belong to check: self_contact",
        ),
        (
            "check: stops, at_least: 0",
            "check: stops, at_least: 3 mm",
            "criteria[4].at_least: a number of degrees is needed (got '3 mm')",
        ),
        (
            "check: stops",
            "check: stop",
            "criteria[4].check: input should be 'contact', 'clearance', 'self_con",
        ),
        (
            "length: mm",
            "kind: reach\nlength: mm",
            "kind: a study has no kind now. `kind: accommodation` becomes `people` with a `population`",
        ),
        ("study: cab_study", "study: ../up", "study: string should match pattern"),
        (
            "length: mm",
            "length: yards",
            "length: the unit of length is needed (got 'yards'), one of mm, cm, m, in, ft",
        ),
        (
            "title: One",
            "titel: One",
            "titel: unknown key 'titel'; did you mean 'title'? valid: cases, changes, compare, ",
        ),
    ],
)
def test_one_fault_of_a_study_is_one_line(tmp_path, old, new, words):
    check(tmp_path, "study", changed(STUDY, old, new), words)


def test_two_people_cannot_sit_in_one_seat(tmp_path):
    text = changed(
        STUDY, "at: {segment: BASE, position: [0, 600, 900], attitude: {yaw: 90}}", "seat: stool"
    )
    check(
        tmp_path,
        "study",
        text,
        "people.bert.seat: 'anna' sits in 'stool' already; for people who take a seat one at a time ",
    )


def test_everybody_takes_part_in_every_case(tmp_path):
    text = changed(STUDY, "      bert: {posture: bent}\n", "      brt: {posture: bent}\n")
    found = problems(tmp_path, study=text)
    assert lines_of(found) == [line_with(text, "name: forward") + 1, line_with(text, "brt:")]
    assert (
        "cases[1].people: the action of 'bert' is missing; every role acts in every case"
        in found[0]
    )
    assert "nobody is called 'brt'; did you mean 'bert'? valid: anna, bert" in found[1]


def test_one_person_alone_has_nobody_to_keep_away_from(tmp_path):
    text = "\n".join(line for line in STUDY.splitlines() if "bert:" not in line)
    found = problems(tmp_path, study=text)
    assert lines_of(found) == [line_with(text, "between_people")]
    assert "between_people needs two roles or more" in found[0]


def test_all_faults_of_a_study_come_at_once_even_where_its_environment_and_a_body_are_unknown(
    tmp_path,
):
    text = STUDY
    parts = [
        "environment: cub",
        "bert: {body: one_leg",
        "{posture: bant",
        "people: [ana]",
        "name: down #",
    ]
    for old, new in zip(
        [
            "environment: cab",
            "bert: {body: one_arm",
            "{posture: bent, an",
            "people: [anna]",
            "name: forward",
        ],
        [*parts[:2], "{posture: bant, an", *parts[3:]],
        strict=True,
    ):
        text = changed(text, old, new)
    found = problems(tmp_path, study=text)
    assert sorted(lines_of(found)) == sorted(line_with(text, part) for part in parts)


def test_faults_of_the_files_a_study_names_come_with_those_of_the_study(tmp_path):
    found = problems(
        tmp_path,
        study=changed(STUDY, "people: [anna]", "people: [ana]"),
        body=changed(ONE_ARM, "mass: 2", "mass: two"),
        environment=changed(ENVIRONMENT, "part: seat", "part: set"),
    )
    assert len(lines_of(found)) == len(set(found)) == 3
    assert [
        name in line
        for name, line in zip(["environment.yaml", "one_arm", "cab_study"], found, strict=True)
    ] == [True] * 3


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "reference: BASE",
            "reference: BSE",
            "reference: body one_arm has no segment 'BSE'; did you mean 'BASE'? valid: ",
        ),
        (
            "reference: BASE",
            "refrence: BASE\nreference: BASE",
            "refrence: unknown key 'refrence'; did you mean 'reference'",
        ),
        (
            "ELBOW: {",
            "ELBO: {",
            "postures.bent.angles.ELBO: body one_arm has no joint 'ELBO'; did you mean 'ELBOW'",
        ),
        (
            "{flexion: 90}",
            "{flexin: 90}",
            "angles.ELBOW.flexin: joint ELBOW: no motion 'flexin'; did you mean 'flexion'",
        ),
        (
            "{flexion: 90}",
            "{flexion: right}",
            "angles.ELBOW.flexion: a number is needed (got 'right')",
        ),
        (
            "{flexion: 90}",
            "{flexion: -721}",
            "input should be greater than or equal to -720 (got -721)",
        ),
        (
            "    angles:",
            "    rotations: {WRST: [1, 0, 0, 0]}\n    angles:",
            "rotations.WRST: body one_arm has no joint 'WRST'",
        ),
        (
            "    angles:",
            "    rotations: {WRIST: [1, 0, 0]}\n    angles:",
            "rotations.WRIST: value 4 of the list is missing",
        ),
        (
            "    angles:",
            "    rotations: {WRIST: [0, 0, 0, 0]}\n    angles:",
            "whose length is not zero (got [0.0, 0.0, 0.0",
        ),
        (
            "    angles:",
            "    attitude: {pitch: up}\n    angles:",
            "bent.attitude.pitch: a number is needed (got 'up')",
        ),
        (
            "    angles:",
            "    angels: {}\n    angles:",
            "bent.angels: unknown key 'angels'; did you mean 'angles'? valid: angles",
        ),
        (
            "hanging: {description: the arm straight down}",
            "hanging: 5",
            "hanging: a mapping of keys is needed (got 5)",
        ),
    ],
)
def test_one_fault_of_a_posture_file_is_one_line(tmp_path, old, new, words):
    check(tmp_path, "postures", changed(POSTURES, old, new), words)


def test_two_postures_cannot_have_one_name(tmp_path):
    found = problems(tmp_path, postures=changed(POSTURES, "hanging:", "bent:"))
    assert lines_of(found) == [4]
    assert "key 'bent' stands twice in one mapping" in found[0]


def test_a_missing_posture_file_is_a_fault_of_the_body_that_names_it(tmp_path):
    path = write_cab(tmp_path)
    (tmp_path / "bodies/arms.yaml").unlink()
    with pytest.raises(InputError) as caught:
        check_file(tmp_path / "bodies/one_arm.yaml")
    assert lines_of(caught.value.problems) == [4]
    with pytest.raises(
        InputError, match=r"one_arm.yaml:4:1: postures: no such file 'arms.yaml' in "
    ):
        wb.load_study(path)


def test_a_body_without_postures_cannot_be_in_a_study(tmp_path):
    path = write_cab(tmp_path)
    (tmp_path / "bodies/one_arm.yaml").write_text(ONE_ARM)
    with pytest.raises(InputError) as caught:
        wb.load_study(path)
    assert len(lines_of(caught.value.problems)) == 2
    assert "people.anna.body: body 'one_arm' names no postures file" in caught.value.problems[0]


@pytest.mark.parametrize(
    ("kind", "data"),
    [
        ("studies/cab_study.yaml", b""),
        ("bodies/arms.yaml", b"\xff\xfe\x00"),
        ("environments/cab/environment.yaml", b"a: [1"),
        ("bodies/one_arm.yaml", b"[]"),
    ],
)
def test_a_file_that_is_none_is_told_with_its_name(tmp_path, kind, data):
    path = write_cab(tmp_path)
    (tmp_path / kind).write_bytes(data)
    with pytest.raises(InputError) as caught:
        wb.load_study(path)
    assert lines_of(caught.value.problems)
    assert all(
        line.startswith(str(tmp_path / "studies/.." / kind)) or kind in line
        for line in caught.value.problems
    )


def test_a_misspelt_first_key_does_not_make_a_study_an_environment(tmp_path):
    path = write_cab(tmp_path, study=changed(STUDY, "study: cab_study", "studdy: cab_study"))
    assert kind_of(path) == "study"
    with pytest.raises(InputError, match="unknown key 'studdy'; did you mean 'study'"):
        check_file(path)


def test_a_yaml_file_of_no_known_kind_is_told_the_kinds(tmp_path):
    (tmp_path / "x.yaml").write_text("a: 1\n")
    with pytest.raises(InputError, match=r"one of the keys study, body, .*, simulation must say"):
        check_file(tmp_path / "x.yaml")


def test_angles_beyond_the_stops_warn_and_still_run(tmp_path, capsys):
    path = write_cab(
        tmp_path, study=changed(STUDY, "SHOULDER: {flexion: 80}", "ELBOW: {flexion: 150}")
    )
    assert main(["run", str(path), "--out", str(tmp_path / "out"), "--json"]) == 1
    told = capsys.readouterr()
    result = json.loads(told.out)
    pieces, bent = result["warnings"]
    assert pieces.startswith("anna, bert: the body is in ")
    assert bent == "anna, forward: elbow is 8.0 degrees past its stop in flexion"
    assert told.err == f"warning: {pieces}\nwarning: {bent}\n"
    margin = {
        (row["case"], row["joint"]): row["margin_deg"]
        for row in result["postures"][0]["people"][0]["stops"]
    }
    assert margin[("forward", "ELBOW")] == pytest.approx(-8.0, abs=1e-6)


def test_angles_of_a_case_replace_those_of_the_posture_axis_by_axis(tmp_path):
    text = changed(STUDY, "SHOULDER: {flexion: 80}", "ELBOW: {extension: -30, medial_rotation: 10}")
    study = wb.load_study(write_cab(tmp_path, study=text))
    bent = wb.pose(study.roles[0].body, {"ELBOW": {"flexion": 30, "medial_rotation": 10}})
    assert study.cases[1].actions[0].poses.rotations[0] == pytest.approx(bent.rotations[0])


def test_sixty_mutants_of_studies_postures_and_environments_load_or_are_bad_input(tmp_path):
    files = {
        "studies/cab_study": STUDY,
        "bodies/arms": POSTURES,
        "environments/cab/environment": ENVIRONMENT,
    }
    bad = 0
    for name, text in files.items():
        path = write_cab(tmp_path)
        for data in mutants(text, 20, seed=2):
            (tmp_path / f"{name}.yaml").write_bytes(data)
            try:
                wb.load_study(path)
            except InputError as error:
                bad += 1
                lines_of(error.problems)
    assert bad > 20


def test_mutants_of_the_shipped_study_are_checked_within_its_catalogue(tmp_path):
    text = (ROOT / "studies/trainer_clearance.yaml").read_text()
    path = tmp_path / "study.yaml"
    for data in mutants(changed(text, "environment: trainer", "environment: nowhere"), 10, seed=3):
        path.write_bytes(data)
        with pytest.raises(InputError) as caught:
            wb.load_study(path)
        lines_of(caught.value.problems)
