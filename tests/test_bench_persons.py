"""The bench and the person who is looked at: size, clothes, harness, postures, mirror, holds."""

from __future__ import annotations

import shutil
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import ROOT
from tests.test_bench import verdict_words
from workbench.errors import InputError
from workbench.files.study.saving import read_text
from workbench.study.bench.answers import answer, judged
from workbench.study.bench.edits import seated
from workbench.study.bench.edits_joints import LimbTarget, given_since, mirrored, reached, turned
from workbench.study.bench.edits_people import (
    SizeWanted,
    dressed,
    harnessed,
    percentile_of,
    sized,
    wearable,
)
from workbench.study.bench.edits_postures import (
    Prediction,
    freed,
    posed,
    predicted,
    suggested,
)
from workbench.study.bench.placing import placed_people
from workbench.study.bench.saving import save
from workbench.study.bench.state import open_study

SMALL = """study: small
length: in      # every length
environment: trainer
people:
  pilot:
    body: bubbleman
    size: &short {sex: female, measures: {stature: 60, sitting_height: 31.5}}   # a small woman
    clothes: [boots]   # of leather
    seat: left
cases:
  - name: flying
    people:
      pilot: {predicted: {hands: {left: left_stick, right: throttle}, eyes: left_design_eye,   # far
        feet: {left: left_seat_left_pedal, right: left_seat_right_pedal}, heels: left_heel}}
criteria:
  - {name: levers, check: reach, controls: [throttle, mixture]}   # zones of their own
  - {name: joints, check: stops}
"""
HOLDS = {"left hand": "left_stick", "right foot": "left_seat_right_pedal"}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("persons") / "small.yaml"
    path.write_text(SMALL)
    return path


@pytest.fixture(scope="module")
def small(path):
    return open_study(wb.load_study(path))


@pytest.fixture(scope="module")
def there(small):
    return placed_people(small, small.start)


def saved(opened, arrangement, path):
    """The text of a study with a state saved in it; the file is as before."""
    before = path.read_bytes()
    try:
        save(opened, read_text(path), arrangement, sharing="all")
        return path.read_text()
    finally:
        path.write_bytes(before)


def test_a_size_is_had_and_saved_beside_its_comments(small, path):
    wanted = SizeWanted("female", {"stature": 1.6}, {"sitting_height": 50.0}, mass=60.04)
    edit = sized(small, small.start, "pilot", wanted)
    assert edit.words == "pilot: a woman, 1600 mm tall, with boots"
    figure = edit.arrangement.people[0].figure
    assert figure.size.measures == pytest.approx(
        {"stature": 1.6, "sitting_height": 0.857, "mass": 60.0}, abs=1e-9
    )
    assert percentile_of(figure.size, "sitting_height") == pytest.approx(50.0, abs=0.5)
    bare = dressed(small, edit.arrangement, "pilot", []).arrangement.body(0)
    standing = sized(small, edit.arrangement, "pilot", wanted)
    assert standing.arrangement is edit.arrangement  # nothing is made anew
    assert wb.measure(bare)["stature"] == pytest.approx(1.6, abs=2e-4)
    text = saved(small, edit.arrangement, path)
    assert (
        "    size: &short {sex: female, measures: {stature: 62.992126, sitting_height: 33.7401575}, "
        "mass_kg: 60}   # a small woman\n"
    ) in text
    back = sized(
        small,
        edit.arrangement,
        "pilot",
        SizeWanted("female", small.start.people[0].figure.size.measures),
    )
    assert back.arrangement.people[0].figure is small.figures[0]
    assert saved(small, back.arrangement, path) == SMALL


def test_a_body_as_its_file_has_it_has_no_size_in_the_text(small, path):
    plain = sized(small, small.start, "pilot", SizeWanted("")).arrangement
    text = saved(small, plain, path)
    assert "size" not in text.replace("sizes", "") or "size: &short null" in text
    assert plain.people[0].figure.size is None


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        (SizeWanted("female", {"stature": 9.6}), "stature: 9600 mm is not a person's"),
        (SizeWanted("female", {"stature": float("nan")}), "stature: nan mm is not a person's"),
        (SizeWanted("female", {"statur": 1.6}), "no measure 'statur'; did you mean 'stature'"),
        (SizeWanted("female", {"mass": 60.0}), "a mass is no length"),
        (
            SizeWanted("female", {"stature": 1.7, "sitting_height": 0.55}),
            "no such person: the ",
        ),
        (SizeWanted("female", {"stature": 1.7}, mass=-1.0), "mass -1 kg is not a person's"),
        (SizeWanted("female", {"stature": 1.7}, mass=float("nan")), "mass nan kg"),
        (SizeWanted("female", {}, {"stature": 100.0}), "between 0 and 100, got 100"),
        (SizeWanted("female", {}, {"stature": float("nan")}), "between 0 and 100, got nan"),
        (SizeWanted("female", {}, {"span_of_wings": 5.0}), "no percentiles of 'span_of_wings'"),
        (SizeWanted("female"), "one measure or more, or the age of a child"),
        (SizeWanted("nobody", {"stature": 1.7}), "no sex 'nobody'"),
        (SizeWanted("male", {"stature": 1.1}, age=500.0), "an age of up to 120 years"),
        (SizeWanted("male", {"stature": 1.1}, age=50.0), "ages from 2 to 20 years are known"),
    ],
)
def test_a_size_that_nobody_has_says_so_in_one_sentence(trainer, wanted, words):
    with pytest.raises(InputError, match=words) as fault:
        sized(trainer, trainer.start, "pilot", wanted)
    assert "\n" not in str(fault.value)


def test_a_child_takes_its_stature_from_the_growth_charts(trainer, tmp_path):
    girl = sized(trainer, trainer.start, "pilot", SizeWanted("female", age=6.0))
    assert girl.words == "pilot: a girl of 6 years"
    stature = wb.measure(girl.arrangement.body(0))["stature"]
    assert 1.08 < stature < 1.22
    path = tmp_path / "trainer.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    assert "position: reference, size: {sex: female, age: 6}}" in saved(
        trainer, girl.arrangement, path
    )


def test_a_dog_has_no_size_and_wears_nothing(trainer):
    dog = wb.load_body("dog")
    role = replace(trainer.study.roles[0], body=dog)
    opened = replace(trainer, study=replace(trainer.study, roles=(role, trainer.study.roles[1])))
    with pytest.raises(InputError, match="body dog cannot be measured as a person"):
        sized(opened, opened.start, "pilot", SizeWanted("female", {"stature": 1.6}))
    with pytest.raises(InputError, match="which body dog does not have"):
        dressed(opened, opened.start, "pilot", ["helmet"])
    assert wearable(dog, opened.folder) == [] and "helmet" in wearable(
        wb.load_body("child_6"), opened.folder
    )


def test_the_size_of_a_population_is_changed_in_its_file(small):
    opened = replace(small, crowd=0)
    for edit in (
        lambda: sized(opened, opened.start, "pilot", SizeWanted("male", {"stature": 1.8})),
        lambda: dressed(opened, opened.start, "pilot", []),
    ):
        with pytest.raises(InputError, match="a population takes this role"):
            edit()


def test_one_of_several_sizes_is_saved_where_it_stands(tmp_path):
    path = tmp_path / "sizes.yaml"
    sizes = "    sizes:\n      short: {sex: female, measures: {stature: 60}}   # she\n      tall: {sex: male, measures: {stature: 74}}\n"
    line = next(line for line in SMALL.split("\n") if "size:" in line)
    path.write_text(SMALL.replace(line + "\n", sizes))
    opened = open_study(wb.load_study(path), "tall")
    state = sized(
        opened, opened.start, "pilot", SizeWanted("male", {"stature": 1.8542})
    ).arrangement
    assert sizes.replace("74", "73") in saved(opened, state, path)


def test_clothes_are_put_on_taken_off_and_saved(small, path):
    body = small.start.body(0)
    more = dressed(small, small.start, "pilot", ["boots", "helmet"])
    assert len(more.arrangement.body(0).sphere_names) > len(body.sphere_names)
    assert "clothes: [boots, helmet]   # of leather" in saved(small, more.arrangement, path)
    none = dressed(small, more.arrangement, "pilot", [])
    assert len(none.arrangement.body(0).sphere_names) < len(body.sphere_names)
    text = saved(small, none.arrangement, path)
    assert "clothes: null   # of leather" in text or "clothes" not in text
    with pytest.raises(InputError, match="no bodies/encumbrance entry named 'hat'"):
        dressed(small, small.start, "pilot", ["hat"])
    with pytest.raises(InputError, match="cannot be worn twice"):
        dressed(small, small.start, "pilot", ["boots", "boots"])


def test_the_harness_zone_of_reaches_is_switched_and_saved(small, trainer, path):
    edit = harnessed(small, small.start, "pilot", 1)
    assert edit.arrangement.zones == (1, None)
    text = saved(small, edit.arrangement, path)
    assert "controls: [throttle, mixture], zone: 1}   # zones of their own" in text
    assert harnessed(small, edit.arrangement, "pilot", None).arrangement.zones == (None, None)
    with pytest.raises(InputError, match="no zone 4"):
        harnessed(small, small.start, "pilot", 4)
    with pytest.raises(InputError, match="no criterion asks what pilot reaches"):
        harnessed(trainer, trainer.start, "pilot", 1)


def test_a_mirrored_person_is_the_mirror_image(trainer, placement):
    edit = mirrored(placement, "pilot")
    assert edit.words == "mirrored"
    body = trainer.start.body(0)

    def tips(arrangement):
        poses = arrangement.people[0].actions[0].poses
        level = wb.Poses(poses.rotations, body.segment("LT"), np.eye(3, 4)[None])
        placed = wb.place(body, level)
        return {
            name: placed.world_from_segment[0, body.segment(name), :, 3] for name in body.segments
        }

    before, after = tips(trainer.start), tips(edit.arrangement)
    for one, other in (("LHN", "RHN"), ("RF", "LF"), ("H", "H"), ("LUA", "RUA")):
        assert after[one] == pytest.approx(before[other] * (1, -1, 1), abs=3e-3)
    assert np.abs(before["LHN"] - before["RHN"] * (1, -1, 1)).max() > 0.1
    there = placed_people(trainer, edit.arrangement)
    again = mirrored(there, "pilot").arrangement.people[0].actions[0]
    first = trainer.start.people[0].actions[0]
    assert np.abs(again.poses.rotations - first.poses.rotations).max() < 1e-6


def test_a_mirrored_pose_stays_within_the_stops(trainer, placement):
    far = turned(placement, "pilot", "RE", 0, 175.0)
    assert "beyond the stop" in far.words
    edit = mirrored(placed_people(trainer, far.arrangement), "pilot")
    assert edit.words == "mirrored; at the stop: left elbow"
    body = trainer.start.body(0)
    margins = wb.stops(body, edit.arrangement.people[0].actions[0].poses).margin
    assert margins[0, body.joint("LE")] >= 0


def test_a_posture_of_the_body_or_the_study_is_taken_by_its_name(trainer, placement, tmp_path):
    edit = posed(trainer, placement, "pilot", "riding")
    action = edit.arrangement.people[0].actions[0]
    known = trainer.start.people[1].actions[0]
    assert np.array_equal(action.poses.rotations, known.poses.rotations)
    path = tmp_path / "trainer.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    bent = turned(placed_people(trainer, edit.arrangement), "pilot", "RE", 0, 33.0).arrangement
    text = saved(trainer, bent, path)
    assert "{pilot: {posture: riding, angles: {RE: {flexion: 33}}}, instructor" in text
    with pytest.raises(InputError, match="no posture 'ridin'; did you mean 'riding'"):
        posed(trainer, placement, "pilot", "ridin")


def test_a_given_posture_is_predicted_from_what_it_is_near_to(trainer, placement, tmp_path):
    tips = answer(placement).people[0].tips
    wanted = suggested(trainer, placement, 0, tips)
    assert wanted.controls == {
        "left hand": "left_stick",
        "right hand": "throttle",
        "left foot": "left_seat_left_pedal",
        "right foot": "left_seat_right_pedal",
    }
    assert (wanted.eyes, wanted.heels) == ("left_design_eye", "left_heel")
    edit = predicted(trainer, placement, "pilot", replace(wanted, controls=HOLDS))
    path = tmp_path / "trainer.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    text = saved(trainer, edit.arrangement, path)
    assert (
        "{pilot: {predicted: {like: driving, hands: {left: left_stick}, feet: {right: "
        "left_seat_right_pedal}, eyes: left_design_eye, heels: left_heel}}, instructor"
    ) in text
    assert "pilot: {body: adult_male, seat: left, position: reference}" in text


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        (Prediction("sleeping"), "no posture 'sleeping'"),
        (Prediction("driving", {"tail": "throttle"}), "no limb 'tail'"),
        (Prediction("driving", {"left hand": "throtle"}), "no control 'throtle'"),
        (
            Prediction("driving", {"left hand": "left_seat_left_pedal"}),
            "left_seat_left_pedal is for feet, not for the left hand",
        ),
        (Prediction("driving", eyes="moon"), "no point 'moon'"),
    ],
)
def test_a_prediction_from_nothing_that_is_there_says_so(trainer, placement, wanted, words):
    with pytest.raises(InputError, match=words):
        predicted(trainer, placement, "pilot", wanted)


def test_what_is_no_longer_predicted_is_told(small, there):
    start = small.start
    after = turned(there, "pilot", "RE", 0, 50.0).arrangement
    words = "pilot: no longer predicted; the posture is given, the seat held"
    assert given_since(start, after) == words
    assert given_since(after, after) == given_since(after, start) == ""


def test_a_seat_is_freed_once_every_posture_is_predicted(small, there, trainer, path):
    held = seated(small, small.start, "pilot", 0.0254, 0.0).arrangement
    free = freed(small, held, "pilot").arrangement
    assert free.people[0].free
    assert saved(small, free, path) == SMALL
    assert "position: {forward: 1, up: 0}" in saved(small, held, path)
    with pytest.raises(InputError, match="given in case 'cruise'"):
        freed(trainer, trainer.start, "pilot")


def test_a_hand_that_takes_hold_in_a_prediction_stays_there(small, there, path):
    edit = reached(small, there, "pilot", LimbTarget("right hand", control="mixture"))
    assert "right hand" in edit.words
    person = edit.arrangement.people[0]
    assert person.free and person.actions[0].aims.controls["right hand"] == "mixture"
    text = saved(small, edit.arrangement, path)
    assert text == SMALL.replace("right: throttle", "right: mixture")
    to_pedal = LimbTarget("right hand", control="left_seat_left_pedal")
    with pytest.raises(InputError, match="left_seat_left_pedal is for feet"):
        reached(small, there, "pilot", to_pedal)


def held(opened, state, control):
    target = LimbTarget("right hand", control=control)
    return reached(opened, placed_people(opened, state), "pilot", target)


TALL = SizeWanted("male", {"stature": 1.7}, {"sitting_height": 30})
CHANGES = {
    "taller": lambda opened, state: sized(opened, state, "pilot", TALL),
    "vest": lambda opened, state: dressed(opened, state, "pilot", ["boots", "vest"]),
    "barefoot": lambda opened, state: dressed(opened, state, "pilot", []),
    "zone 1": lambda opened, state: harnessed(opened, state, "pilot", 1),
    "zone 3": lambda opened, state: harnessed(opened, state, "pilot", 3),
    "flaps": lambda opened, state: held(opened, state, "flaps"),
    "seat": lambda opened, state: seated(opened, state, "pilot", 0.01, 0.0),
    "predicted": lambda opened, state: predicted(
        opened, placed_people(opened, state), "pilot", Prediction("seated", HOLDS)
    ),
}


@settings(max_examples=2)
@given(st.lists(st.sampled_from(sorted(CHANGES)), min_size=1, max_size=4))
def test_persons_saved_are_those_that_a_run_then_finds(small, path, edits):
    state = small.start
    for edit in edits:
        state = CHANGES[edit](small, state).arrangement
    found = verdict_words(judged(small, state).found.verdicts)
    text = saved(small, state, path)
    try:
        path.write_text(text)
        run = wb.run(wb.load_study(path))
    finally:
        path.write_text(SMALL)
    assert found == verdict_words(run.verdicts)
    assert text.count("#") == SMALL.count("#")


FOUR = """study: four
length: mm
environment: trainer
people:
  pilot: {body: adult_male, detail: coarse, seat: left}
  guest: {body: adult_female, detail: coarse, seat: right}
  one: {body: adult_male, detail: coarse, stand: {on: [400, 900, 0], yaw: -90}}
  two: {body: adult_female, detail: coarse, stand: {on: [400, 1400, 0], yaw: -90}}
cases:
  - name: around
    people:
      pilot: {posture: driving}
      guest: {posture: hands_in_lap, hands: {right: right_stick}}
      one: {posture: standing}
      two: {posture: standing}
criteria:
  - {name: room, check: between_people, at_least: 30}
"""


def test_four_people_heed_each_other_and_are_saved_as_a_run_finds_them(tmp_path):
    path = tmp_path / "four.yaml"
    path.write_text(FOUR)
    opened = open_study(wb.load_study(path))
    there = placed_people(opened, opened.start)
    back = (0.4, 0.92, 1.25)  # inside of the one in front
    assert reached(opened, there, "two", LimbTarget("right hand", back)).words == ""
    edit = reached(opened, there, "two", LimbTarget("right hand", back, obstacles=True))
    assert edit.words.endswith("; one's central torso is in the way")
    (room,) = judged(opened, edit.arrangement).found.verdicts
    assert {room.worst.person, room.worst.other_person} == {"one", "two"}
    save(opened, read_text(path), edit.arrangement)
    run = wb.run(wb.load_study(path))
    assert verdict_words(run.verdicts) == verdict_words([room])
    assert run.postures[0].who == "pilot, guest, one and two"
