"""The one study format: faults all at once, patterns, and criteria of every kind of case."""

from __future__ import annotations

import json

import numpy as np
import pytest
import yaml

import workbench as wb
from tests.conftest import tracked
from tests.one_arm_cab import STUDY, changed, lines_of, write_cab
from tests.test_crash import drop  # noqa: F401
from tests.toy_cockpit import STUDY as TOY
from tests.toy_cockpit import write_toy
from workbench.cli import main
from workbench.files.kinds import check_file, kind_of
from workbench.files.names import matches, matching

SHIPPED = tracked("studies/*.yaml")


def faults(folder, text):
    path = write_cab(folder, study=text)
    with pytest.raises(wb.InputError) as caught:
        wb.load_study(path)
    return caught.value.problems


@pytest.mark.parametrize("kind", ["clearance", "reach", "accommodation", "crash", "1", "null"])
def test_an_old_file_gets_its_one_line_and_no_other(tmp_path, kind):
    text = changed(STUDY, "length: mm", f"kind: {kind}\nlength: inches")
    text = changed(text, "environment: cab", "environment: nowhere")
    (line,) = faults(tmp_path, text)
    assert lines_of((line,)) == [3]
    assert "kind: a study has no kind now" in line and "docs/studies.md shows all" in line


def test_an_old_crash_file_is_a_study_and_no_simulation(tmp_path):
    path = tmp_path / "old.yaml"
    path.write_text(
        "study: old\nkind: crash\nlength: mm\nenvironment: trainer\nbody: bubbleman\n"
        "motion: {file: x.csv}\npulse: {shape: half_sine, peak: 1, duration: 9}\nbelts: []\n"
        "anchors: {}\nairbags: []\ntitle: x\ndescription: y\ncriteria: []\n"
    )
    assert kind_of(path) == "study"
    with pytest.raises(wb.InputError, match="a study has no kind now"):
        check_file(path)


def test_faults_of_form_and_of_names_come_together_in_the_order_of_the_lines(tmp_path):
    text = STUDY
    for old, new in (
        ("title: One", "titel: One"),
        ("seat: stool, position: {forward: 10", "seat: stul, position: {forward: ten"),
        ("bert: {posture: bent}", "bert: {posture: band}"),
        ("check: self_contact}", "check: self_contact, parts: [wall]}"),
        ("people: [anna]", "people: [ana], at_lest: 5"),
        ("check: stops, at_least: 0}", "check: stop}"),
    ):
        text = changed(text, old, new)
    found = faults(tmp_path, text)
    said = "\n".join(found)
    for words in (
        "titel: unknown key 'titel'",
        "people.anna.seat: environment cab has no seat 'stul'",
        "people.anna.position.forward: a length such as '450 mm'",
        "cases[1].people.bert.posture: no posture 'band'",
        "criteria[1].people[0]: nothing is called 'ana'",
        "criteria[1].at_lest: unknown key 'at_lest'; did you mean 'at_least'?",
        "criteria[2]: 'parts' does not belong to check: self_contact",
        "criteria[4].check: input should be 'contact'",
    ):
        assert words in said, words
    assert len(found) == 8
    assert lines_of(found) == sorted(lines_of(found))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("people: [anna]", "people: []", "criteria[1].people: at least 1 are needed (got [])"),
        ("people: [anna]", "people: [3]", "criteria[1].people[0]: a text is needed (got 3)"),
        ("people: [anna]", "cases: [up]", "criteria[1].cases[0]: nothing is called 'up'"),
        ("segments: [HAND]", "segments: ['']", "criteria[1].segments[0]: string should have at"),
        ("segments: [HAND]", "segments: ['*X']", "nothing is called '*X'; valid: BASE"),
        ("at_least: 100", "at_least: '100'", "criteria[1].at_least: a length such as '450 mm'"),
        ("at_least: 100", "at_least: .nan", "criteria[1].at_least: input should be a finite"),
        ("at_least: 100", "at_least: true", "a number or a length such as '450 mm' is needed"),
        ("at_least: 100", "at_least: 100 m m", "a length such as '450 mm' or '17.7 in'"),
        ("at_least: 100", "at_least: 9e9", "farther than 10000 m: a wrong unit?"),
        ("stops, at_least: 0", "stops, at_least: 181", "-180 to 180 degrees are possible"),
        ("stops, at_least: 0", "stops, at_least: .inf", "-180 to 180 degrees are possible"),
        (
            "stops, at_least: 0",
            "view_over, parts: [wall]",
            "criteria[4]: check: view_over needs 'down'",
        ),
        (
            "stops, at_least: 0",
            "preferred_seat",
            "check: preferred_seat fits no case: it is asked of a predicted posture",
        ),
        (
            "stops, at_least: 0",
            "pedals, people: [anna]",
            "criteria[4].people[0]: check: pedals fits no case of 'anna'",
        ),
        ("stops, at_least: 0", "injury, rules: fmvss_208", "injury fits no case: it is asked of"),
        ("stops, at_least: 0", "share, at_least: 50", "a share is of a population; give a role"),
        (
            "check: self_contact",
            "check: contact, at_most: -1",
            "'at_most' of check: contact is 0 or more",
        ),
        ("bert: {posture: bent}", "bert: {}", "exactly one of posture, predicted, driver, motion"),
        ("bert: {posture: bent}", "bert: bent", "people.bert: a mapping of keys is needed"),
        (
            "bert: {posture: bent}",
            "bert: {predicted: {like: bent}}",
            "bert.predicted: only the posture of somebody in a seat, or who stands, is predicted",
        ),
        ("position: {forward: 10, up: 0}", "position: free", "hands and feet would not follow"),
        ("position: {forward: 10, up: 0}", "position: loose", "input should be 'free' or 'refer"),
        ("position: {forward: 10, up: 0}", "position: 10", "a mapping of keys is needed (got 10)"),
        ("position: {forward: 10, up: 0}", "position: {tilt: 3}", "seat 'stool' cannot be tilted"),
        ("cases:\n", "cases: []\nx:\n", "cases: at least 1 are needed (got [])"),
        ("criteria:\n", "compare: [down, forward]\ncriteria:\n", "case 'down' is no motion"),
        ("criteria:\n", "compare: [down]\ncriteria:\n", "compare: at least 2 are needed"),
        ("criteria:\n", "compare: [down, up]\ncriteria:\n", "compare[1]: no case is called 'up'"),
        (
            "criteria:\n",
            "contact_forces: [{parts: [wall], stiffness: 3}]\ncriteria:\n",
            "'contact_forces' are of motions",
        ),
        ("criteria:\n", "shares: {confidence: 90}\ncriteria:\n", "'shares' are of a population"),
        (
            "criteria:\n",
            "reach_envelopes: [{people: bert}]\ncriteria:\n",
            "'bert' neither sits nor stands, so nothing says which way is ahead",
        ),
        (
            "criteria:\n",
            "reach_maps: [{people: anna, part: wall}]\ncriteria:\n",
            "a reach map is of a population; ask for 'reach_envelopes' of one person",
        ),
        (
            "cases:\n",
            "postures: {up: {like: bnt}}\ncases:\n",
            "postures.up.like: body one_arm has no posture 'bnt'; did you mean 'bent'?",
        ),
        (
            "cases:\n",
            "postures: {bent: {like: hanging}}\ncases:\n",
            "postures.bent: body one_arm has a posture 'bent' of its own",
        ),
        (
            "cases:\n",
            "postures: {up: {like: bent, angles: {ELBO: {flexion: 3}}}}\ncases:\n",
            "postures.up.angles.ELBO: body one_arm has no joint 'ELBO'",
        ),
    ],
)
def test_what_a_study_cannot_mean_is_told_with_what_would_be_right(tmp_path, old, new, words):
    found = faults(tmp_path, changed(STUDY, old, new))
    assert any(words in line for line in found), found
    assert lines_of(found)


def test_a_pattern_has_two_signs_and_all_else_means_itself():
    assert matches("*_stick", "left_stick") and not matches("*_stick", "left_stick_boot")
    assert matches("?LL/knee cap", "RLL/knee cap") and not matches("?LL", "LL")
    assert matches("pane[1]", "pane[1]") and not matches("pane[1]", "pane1")
    assert matches("a.b", "a.b") and not matches("a.b", "aXb")
    assert matching(["c", "a*"], ["ab", "b", "c"]) == ("ab", "c")
    assert matching(None, ["b", "a"]) == ("b", "a")


def test_a_posture_of_the_study_is_the_same_as_its_angles_written_out(tmp_path):
    own = changed(
        STUDY,
        "cases:\n",
        "postures: {up: {like: bent, angles: {SHOULDER: {flexion: 80}}}}\ncases:\n",
    )
    own = changed(own, "{posture: bent, angles: {SHOULDER: {flexion: 80}}}", "{posture: up}")
    both = (
        wb.load_study(write_cab(tmp_path / name, study=text))
        for name, text in (("a", STUDY), ("b", own))
    )
    one, two = (study.cases[1].actions[0].poses.rotations for study in both)
    assert np.array_equal(one, two)


@pytest.mark.parametrize("path", SHIPPED[-2:], ids=lambda path: path.stem)
def test_a_shipped_study_that_loses_any_key_is_checked_with_positions(path, tmp_path):
    """Each key of the file left out: it loads, or each fault has its place."""
    value = yaml.safe_load(path.read_text())
    for key in value:
        less = {k: v for k, v in value.items() if k != key}
        copy = tmp_path / "less.yaml"
        copy.write_text(yaml.safe_dump(less, sort_keys=False))
        try:
            wb.load_study(copy)
        except wb.InputError as error:
            assert lines_of(error.problems)


def asked(result):
    """The verdicts by criterion: passed, value and limit of the worst."""
    return {
        v.criterion.name: (v.passed, v.worst.value if v.worst else None) for v in result.verdicts
    }


def test_a_criterion_is_asked_of_the_cases_it_names(tmp_path):
    text = changed(STUDY, "at_least: 100", "at_least: 100, cases: [down]")
    both = wb.run(wb.load_study(write_cab(tmp_path / "a")))
    one = wb.run(wb.load_study(write_cab(tmp_path / "b", study=text)))
    wall = next(v for v in one.verdicts if v.criterion.name == "room for the hand")
    every = next(v for v in both.verdicts if v.criterion.name == "room for the hand")
    assert (wall.worst.case, every.worst.case) == ("down", "forward")
    assert wall.worst.value > every.worst.value


def test_depth_that_a_criterion_allows_is_no_contact(tmp_path):
    near = changed(STUDY, "[0, 600, 900]", "[620, 600, 0]")
    depth = -asked(wb.run(wb.load_study(write_cab(tmp_path / "a", study=near))))[
        "nobody is in the cab"
    ][1]
    assert depth > 0
    for extra, passed in ((-0.5, False), (0.5, True)):
        text = changed(near, "check: contact", f"check: contact, at_most: {1000 * depth + extra}")
        result = asked(wb.run(wb.load_study(write_cab(tmp_path / str(passed), study=text))))
        assert result["nobody is in the cab"][0] is passed


TRAINER = """study: one_sits
length: mm
environment: trainer
people:
  pilot: {body: bubbleman, seat: left}
cases:
  - name: flying
    people:
      pilot: {predicted: {eyes: left_design_eye, heels: left_heel,
        feet: {left: left_seat_left_pedal, right: left_seat_right_pedal}}}
criteria:
  - {name: pedals, check: pedals}
  - {name: seat, check: preferred_seat}
  - {name: eyes, check: eye_height, below: 25, above: 40}
  - {name: nose, check: view_over, parts: [coaming, forward_deck], down: 10}
  - {name: knees, check: clearance, subparts: ["?LL/knee cap"], parts: [instrument_panel], at_least: 25}
  - {name: shins, check: clearance, segments: [LLL, RLL], parts: [instrument_panel], at_least: 25}
  - {name: forward, check: excursion, segments: [H], direction: [1, 0, 0], origin: [0, 280, 280], at_most: 900}
  - {name: right hand, check: reach, controls: [throttle], hand: right}
  - {name: left hand, check: reach, controls: [throttle], hand: left}
"""


@pytest.fixture(scope="module")
def sitter(tmp_path_factory):
    path = tmp_path_factory.mktemp("one") / "study.yaml"
    path.write_text(TRAINER)
    return wb.run(wb.load_study(path))


@pytest.mark.parametrize(
    ("action", "said"),
    [
        ("predicted: {", "no control is stated for the left hand and the right hand, so both arms"),
        ("predicted: {hands: {left: left_stick}, ", "stated for the right hand, so that arm stays"),
        ("predicted: {hands: {left: left_stick, right: throttle}, ", ""),
        ("predicted: {like: hands_in_lap, ", ""),
    ],
)
def test_arms_that_nothing_is_asked_of_are_told_of(tmp_path, action, said):
    path = tmp_path / "study.yaml"
    text = TRAINER.replace("bubbleman", "adult_male").replace("predicted: {", action)
    path.write_text(text)
    told = [words for words in wb.load_study(path).warnings if "whatever is in the way" in words]
    assert len(told) == bool(said)
    assert all(
        words.startswith("pilot, flying: ")
        and said in words
        and words.endswith("'like: hands_in_lap' lays them in the lap")
        for words in told
    )


def test_view_seat_and_pedals_are_asked_of_one_person(sitter):
    found = asked(sitter)
    assert found["pedals"][0] and found["seat"][0] and found["eyes"][0]
    person = sitter.postures[0].people[0]
    travel = sitter.postures[0].environment.seat("left").travel_forward
    # the left hand does not reach the throttle from the most comfortable position
    assert any("the most comfortable position" in line for line in sitter.warnings)
    assert found["seat"][1] >= 0 and travel[0] <= person.forward <= travel[1]
    eye = [k for k, n in enumerate(person.body.sphere_names) if n in ("left eye", "right eye")]
    rise = (
        sitter.postures[0].people[0].placed.centres[0, eye, 2].mean()
        - sitter.postures[0].environment.points["left_design_eye"][2]
    )
    assert found["eyes"][1] == pytest.approx(min(rise + 0.025, 0.04 - rise), abs=1e-12)


def test_a_subpart_is_part_of_its_segment(sitter):
    found = asked(sitter)
    assert found["knees"][1] >= found["shins"][1] - 1e-12
    assert found["knees"][1] < 1.0


def test_an_excursion_of_a_posture_is_that_of_its_farthest_sphere(sitter):
    placed = sitter.postures[0].people[0].placed
    head = placed.body.spheres(placed.body.segment("H"))
    ahead = (placed.centres[0, head, 0] + placed.body.radius[0, head]).max()
    assert asked(sitter)["forward"][1] == pytest.approx(-ahead, abs=1e-12)


def test_the_hand_that_is_asked_for_is_the_one_that_reaches(sitter):
    limbs = {
        (row.hand, row.limb) for row in sitter.postures[0].reaches if row.control == "throttle"
    }
    assert limbs == {("right", "right hand"), ("left", "left hand")}
    found = asked(sitter)
    assert found["right hand"][0] or found["right hand"][1] >= found["left hand"][1]


def test_a_share_that_is_too_small_fails_and_one_that_is_not_passes(tmp_path, capsys):
    text = TOY + "  - {name: all fit, check: share, at_least: 100}\n"
    text += "  - {name: some see, check: share, at_least: 1, of: [view]}\n"
    path = write_toy(tmp_path, knob=850, people=6, study=text)
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().out
    assert "FAILED  all fit: " in said and "passed  some see: " in said
    rows = json.loads((tmp_path / "out" / "result.json").read_text())
    assert [(v["name"], v["passed"]) for v in rows["verdicts"]] == [
        ("all fit", False),
        ("some see", True),
    ]
    assert "all fit" in (tmp_path / "out" / "report.html").read_text()


def test_a_population_of_one_in_a_given_posture_does_not_move_its_seat(tmp_path):
    text = TOY.replace("predicted: {like: driving, eyes: eye}", "posture: driving")
    text = "\n".join(line for line in text.splitlines() if "eye_height" not in line)
    text += "\n  - {name: himself, check: self_contact}\n"
    text += "  - {name: elbows, check: stops, segments: [LLA, RLA]}\n"
    text += "  - {name: joints, check: stops}\n"
    text += "  - {name: deep, check: contact, segments: [H], parts: [roof], at_most: 5}\n"
    result = wb.run(wb.load_study(write_toy(tmp_path, people=1, study=text)))
    found = result.population
    margin = dict(zip((r.name for r in found.requirements), found.margin[0], strict=True))
    assert len(found.people) == 1 and found.seat.tolist() == [[0.0, 0.0]]
    assert margin["elbows"] >= margin["joints"]
    assert margin["deep"] == pytest.approx(margin["head room"] + 0.150 + 0.005, abs=1e-9)
    assert np.isfinite(margin["himself"])


def test_a_motion_is_asked_for_clearance_self_contact_and_room_to_its_stops(drop):  # noqa: F811
    text = drop.read_text()
    more = (
        "  - {name: feet, check: clearance, segments: [LF, RF], at_least: 0}\n"
        "  - {name: head, check: clearance, segments: [H], at_least: 1000}\n"
        "  - {name: himself, check: self_contact}\n"
        "  - {name: inside, check: stops, at_least: 1}\n"
        "  - {name: elbows, check: stops, segments: [LLA], at_least: -5}\n"
    )
    drop.write_text(text + more)
    found = {v.criterion.name: v for v in wb.run(wb.load_study(drop)).verdicts}
    feet = found["feet"].worst
    assert feet.value == pytest.approx(-0.040, abs=1e-5) and not found["feet"].passed
    assert feet.time == pytest.approx(0.07)
    assert found["head"].passed and found["head"].worst.value > 1
    assert found["himself"].passed and found["elbows"].passed
    margins = wb.stops(wb.load_body("bubbleman"), wb.pose(wb.load_body("bubbleman"), {}))
    assert found["inside"].worst.value == pytest.approx(margins.margin.min(), abs=1e-8)


def test_two_motions_are_both_judged_without_a_comparison(drop, tmp_path, capsys):  # noqa: F811
    moved = "{motion: {file: drop.csv, move: [0, 0, 100]}}"
    text = drop.read_text().replace(
        "signals:", f"  - {{name: higher, people: {{occupant: {moved}}}}}\nsignals:"
    )
    text = text.replace("at_most: 10}", "at_most: 10, cases: [higher]}")
    drop.write_text(text)
    result = wb.run(wb.load_study(drop))
    assert result.agreements == ()
    assert [(v.motion, v.criterion.name) for v in result.verdicts] == [
        ("the fall", "head stays low"),
        ("the fall", "stops"),
        ("higher", "nothing is hit"),
        ("higher", "head stays low"),
        ("higher", "stops"),
    ]
    assert [len(motion.verdicts) for motion in result.motions] == [2, 3]
    assert main(["run", str(drop), "--out", str(tmp_path / "out")]) == 0
    drop.write_text(text.replace("cases: [higher]", "cases: [the fall]"))
    assert main(["run", str(drop), "--out", str(tmp_path / "out")]) == 1
    drop.write_text(text.replace("at_most: 2500", "at_most: 2000"))
    assert main(["run", str(drop), "--out", str(tmp_path / "out")]) == 1  # of the second motion
    capsys.readouterr()
