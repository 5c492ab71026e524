"""Ways of looking of the live bench: motions, distances, reach envelopes, criteria of a pair."""

from __future__ import annotations

import json
import shutil
import zlib

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from tests.test_bench import verdict_words
from workbench.contact.collide import clearance
from workbench.draw.eye_view import eye_point
from workbench.draw.scene import SceneBody
from workbench.errors import InputError
from workbench.files.study.saving import read_text
from workbench.live.desk import Desk, Judgement, SupersededError
from workbench.live.playing import WINDOW, Frames, Gaps, Near
from workbench.live.protocol import parsed, unpacked
from workbench.model.surroundings import Move
from workbench.study.bench.answers import judged
from workbench.study.bench.criteria import PairLimit, asked_for
from workbench.study.bench.edits import shifted
from workbench.study.bench.measuring import Thing, measured
from workbench.study.bench.motions import motions_judged, near_in_frame, playing
from workbench.study.bench.saving import said, save
from workbench.study.bench.state import open_study
from workbench.study.crash.frames import frames_of

LAP = "the lap belt alone"


@pytest.fixture(scope="module")
def crash():
    return open_study(wb.load_study("trainer_crash"))


@pytest.fixture(scope="module")
def desks():
    return {name: Desk(name) for name in ("trainer_clearance", "trainer_crash")}


def replied(desk, **given):
    return desk.do(parsed(json.dumps({"n": 3, **given})))


def headed(frames):
    return [unpacked(frame)[0] for frame in frames]


# --- motions -------------------------------------------------------------------------------------


def test_the_least_gap_of_every_frame_is_the_clearance_of_the_report(crash):
    motion = playing(crash, crash.start, LAP).motions[0]
    (frame,) = Gaps(crash, crash.start, 1, LAP).made().frames
    head, arrays = unpacked(frame)
    least = frames_of(motion).clearance.min(axis=1)
    assert arrays["least"] == pytest.approx(least, abs=1e-6)
    names = [row["name"] for row in head["rows"]]
    assert names == [
        "head free of the cockpit",
        "chest free of stick and panel",
        "knees free of the panel",
    ]
    assert arrays["asked1"].min() == pytest.approx(least.min(), abs=1e-6)
    assert " – left stick" in head["worst"]["words"]


def test_frames_come_in_windows_with_what_touches_in_red(crash):
    found = playing(crash, crash.start, LAP)
    (frame,) = Frames(crash, crash.start, 1, LAP, 100, 120).made().frames
    head, arrays = unpacked(frame)
    block = zlib.decompress(arrays["block"].tobytes(), -15)
    length = int.from_bytes(block[:4], "little")
    (view,) = json.loads(block[4 : 4 + length])["views"]
    assert (head["from"], head["count"], len(arrays["eyes0"])) == (100, 20, 9 * 20)
    assert [body["name"] for body in view["bodies"]] == ["pilot", "lap belt"]
    motion = found.motions[0]
    body = motion.body
    chest = {s for s, name in enumerate(body.sphere_segment) if body.segments[name] == "UT"}
    now = 1e3 * found.clock[112]
    red = {s for s, begin, end in view["bodies"][0]["touching"] if begin <= now <= end}
    assert red & chest
    with pytest.raises(InputError, match="has frames 0 to 200, got 500 on"):
        Frames(crash, crash.start, 1, LAP, 500, 501).made()


def test_gaps_follow_a_part_that_is_moved(crash):
    far = shifted(crash, crash.start, Move(("left_stick",), (), (0.6, 0.0, 0.0))).arrangement
    _, arrays = unpacked(Gaps(crash, far, 2, LAP).made().frames[0])
    assert arrays["asked1"].min() > -0.1019  # the chest no longer meets the stick


def test_verdicts_of_motions_are_those_of_a_run(crash):
    first, last = motions_judged(crash, crash.start)
    assert (first.done, last.done, last.of) == (1, 2, 2)
    run = wb.run(wb.load_study("trainer_crash"))
    assert verdict_words(last.verdicts) == verdict_words(run.verdicts)
    assert first.verdicts == last.verdicts[: len(first.verdicts)]
    found = run.motions[0].warnings[0]
    assert last.warnings[0] == f"{LAP}: {found}"


def test_motions_are_not_judged_on_once_the_state_is_another(crash):
    calls = []

    def go_on():
        calls.append(None)
        if len(calls) == 2:
            raise SupersededError

    desk = Desk("trainer_crash")
    asked = Judgement(crash, crash.start, desk.generation, desk.following)
    assert list(asked.motions(go_on)) == [] and len(calls) == 2


def test_what_is_nearest_in_a_frame_is_what_the_gaps_say(crash):
    found = playing(crash, crash.start, LAP)
    _, arrays = unpacked(Gaps(crash, crash.start, 1, LAP).made().frames[0])
    deepest = int(arrays["least"].argmin())
    rows = near_in_frame(found, deepest)
    worst = next(row for row in rows if row.target == "left_stick")
    assert worst.distance == pytest.approx(float(arrays["least"][deepest]), abs=1e-6)
    foot = next(row for row in near_in_frame(found, 0) if row.subject.startswith("left foot"))
    assert foot.allowed == pytest.approx(0.02) and foot.target == "floor"
    assert foot.room == pytest.approx(foot.distance + 0.02) and -0.005 < foot.room < 0.0
    near = Near(crash, crash.start, 1, LAP, deepest).made().frames[0]
    assert unpacked(near)[0]["rows"][0]["mm"] == 1e3 * rows[0].distance
    with pytest.raises(InputError, match="has frames 0 to 200, got 500"):
        Near(crash, crash.start, 1, LAP, 500).made()


def test_a_study_of_motions_alone_is_opened_and_judged(desks):
    desk = desks["trainer_crash"]
    (hello, _), (answer,) = headed(desk.greeting()), headed(desk.state())
    assert hello["cases"] == [] and hello["motions"] == [LAP, "lap and shoulder belts"]
    assert answer["people"] == [] and answer["near"] == []
    asked = desk.judgement()
    assert asked.made() is None and desk.take(asked, None) == []
    *_, judged_last = asked.motions(lambda: None)
    (frame,) = desk.take_motions(asked, judged_last)
    head, _ = unpacked(frame)
    assert [*desk.judgement().motions(lambda: None)] == [judged_last]  # it is known now
    assert not head["passed"] and not head["waits"] and len(head["rows"]) == 14
    chest = next(row for row in head["rows"] if row["name"].startswith("chest"))
    worst = next(v.worst for v in judged_last.verdicts if v.criterion.name == chest["name"])
    assert (chest["case"], chest["time"]) == (LAP, worst.time)
    assert chest["margin"] == pytest.approx(1000 * worst.margin) and -120 < chest["margin"] < -80


# --- what is refused, in a sentence -------------------------------------------------------------


@pytest.mark.parametrize(
    ("study", "given", "words"),
    [
        ("trainer_crash", {"do": "motion", "case": "x"}, "no motion 'x'; valid: the lap belt"),
        ("trainer_clearance", {"do": "gaps", "case": "flying"}, "no motion 'flying'"),
        ("trainer_crash", {"do": "frames", "case": LAP, "from": 9, "to": 9}, f"1 to {WINDOW} of them"),
        ("trainer_crash", {"do": "frames", "case": LAP, "from": 0, "to": 9999}, f"1 to {WINDOW} of"),
        ("trainer_crash", {"do": "envelope", "person": "pilot", "limb": "left hand"}, "nobody is"),
        ("trainer_clearance", {"do": "envelope", "person": "x", "limb": "left hand"}, "nobody is"),
        ("trainer_clearance", {"do": "measure", "of": {"part": "x"}, "to": {"control": "flaps"}}, "no part 'x'"),
        (
            "trainer_crash",
            {"do": "measure", "of": {"person": "pilot", "segment": "H"}, "to": {"part": "canopy"}},
            "measured by two points",
        ),
        (
            "trainer_clearance",
            {"do": "criterion", "person": "pilot", "segment": "tail", "part": "canopy", "at_least": 0},
            "no segment 'tail'",
        ),
        (
            "trainer_clearance",
            {"do": "criterion", "person": "pilot", "segment": "H", "part": "canopy", "at_least": 1e9},
            "a limit of 0 to 10000 mm",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_looked_at_is_refused_in_a_sentence(desks, study, given, words):
    (fault,) = headed(replied(desks[study], **given).asker)
    assert fault["kind"] == "fault" and words in fault["words"]
    assert "internal" not in fault["words"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"do": "frames", "case": "a", "from": NaN, "to": 3}', "NaN is no number"),
        ('{"do": "frames", "case": "a", "from": -1, "to": 3}', "the number of a frame"),
        ('{"do": "frames", "case": "a", "from": 1.5, "to": 3}', "the number of a frame"),
        ('{"do": "motion"}', "'case' is missing"),
        ('{"do": "envelope", "person": "a", "limb": "left foot"}', "a hand"),
        ('{"do": "measure", "of": {"part": "a"}, "to": {"part": 3}}', "a part, a control, or"),
        ('{"do": "measure", "of": "a", "to": {"part": "b"}}', "a part, a control, or"),
        ('{"do": "criterion", "person": "a", "segment": "H", "at_least": NaN}', "NaN is no number"),
    ],
)
def test_questions_about_looks_are_checked(text, words):
    with pytest.raises(InputError, match=words):
        parsed(text)


# --- distances and eyes --------------------------------------------------------------------------


def test_a_measured_distance_is_the_clearance_between_its_points(trainer, placement):
    head = Thing(person="pilot", segment="head")
    found = measured(trainer, placement, head, Thing(part="canopy"))
    person = placement.people[0]
    environment = trainer.study.environment
    plain = clearance(person.placed, environment)
    where = 0, person.body.segment("H"), environment.part_index("canopy")
    assert found.distance == pytest.approx(float(plain[where]), abs=1e-9)
    assert np.linalg.norm(found.end - found.start) == pytest.approx(found.distance, abs=1e-9)
    back = measured(trainer, placement, Thing(part="canopy"), head)
    assert back.start == pytest.approx(found.end) and back.distance == found.distance


def test_what_is_measured_between_controls_and_hands_can_be_checked_by_hand(trainer, placement):
    controls = {one.name: np.array(one.at) for one in trainer.study.environment.controls}
    one = measured(trainer, placement, Thing(control="throttle"), Thing(control="flaps"))
    expected = np.linalg.norm(controls["throttle"] - controls["flaps"])
    assert one.distance == pytest.approx(float(expected))
    lever = measured(trainer, placement, Thing(part="throttle_lever"), Thing(control="throttle"))
    assert 0.0 <= lever.distance < 0.03 and lever.end == pytest.approx(controls["throttle"])
    gap = measured(trainer, placement, Thing(part="left_stick"), Thing(part="right_stick"))
    assert np.linalg.norm(gap.end - gap.start) == pytest.approx(gap.distance)
    assert gap.distance == pytest.approx(2 * gap.start[1], abs=1e-6)  # the sticks mirror each other
    same = measured(trainer, placement, Thing(part="canopy"), Thing(part="canopy_frame"))
    assert 0.0 <= same.distance < 0.003


def test_answers_say_where_people_look_from(desks):
    desk = desks["trainer_clearance"]
    (answer,) = (head for head in headed(desk.state()) if head["kind"] == "answer")
    person = desk.shown.people[0].person
    point, axes = eye_point(SceneBody(person.placed, 0))
    eyes = answer["people"][0]["eyes"]
    assert eyes["at"] == pytest.approx(point, abs=1e-5)
    assert np.dot(eyes["sight"], axes[0]) == pytest.approx(np.cos(np.radians(10.0)), abs=1e-4)
    assert person.body.segments[eyes["head"]] == "H"


# --- criteria of a pair --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "wanted",
    [
        PairLimit("pilot", "right lower leg", part="instrument_panel", at_least=0.0301),
        PairLimit("pilot", "LLA", other="instructor", other_segment="RLA", at_least=0.02),
    ],
)
def test_a_criterion_of_a_pair_is_saved_and_run_as_it_was_shown(trainer, tmp_path, wanted):
    edit = asked_for(trainer, trainer.start, wanted)
    path = tmp_path / "study.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    before = path.read_text()
    save(trainer, read_text(path), edit.arrangement)
    lines = path.read_text().splitlines()
    assert [line for line in lines if line not in before.splitlines()] == [lines[-1]]
    assert "\n".join(lines[:-1]) + "\n" == before
    shown = judged(trainer, edit.arrangement).found.verdicts
    assert verdict_words(shown) == verdict_words(wb.run(wb.load_study(path)).verdicts)
    assert edit.words == f"asked for: {shown[-1].criterion.name}"


def test_a_pair_that_is_asked_for_again_gets_the_new_limit(trainer):
    first = asked_for(trainer, trainer.start, PairLimit("pilot", "H", part="canopy", at_least=0.03))
    again = asked_for(
        trainer, first.arrangement, PairLimit("pilot", "H", part="canopy", at_least=0.04)
    )
    (one,) = again.arrangement.added
    assert one.name == "pilot's head to canopy, at least 40 mm" and one.at_least == 0.04
    says = trainer.study.statement.value
    assert said(trainer, trainer.start, says) == says
    with pytest.raises(InputError, match="may touch left_seat_pan"):
        asked_for(trainer, trainer.start, PairLimit("pilot", "LT", part="left_seat_pan"))


def test_a_criterion_is_undone(desks):
    desk = desks["trainer_clearance"]
    desk.open()
    given = {"person": "pilot", "segment": "H", "part": "canopy", "at_least": 0.2}
    (answer,) = headed(replied(desk, do="criterion", **given).everybody)
    assert answer["undo"] and answer["unsaved"]
    asked = desk.judgement()
    assert not judged(desk.opened, asked.arrangement).found.verdicts[-1].passed
    (answer,) = headed(replied(desk, do="undo").everybody)
    assert not answer["unsaved"] and desk.live.added == ()
