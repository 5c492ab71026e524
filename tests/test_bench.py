"""The bench: states, edits and answers of an open study, and what is saved of them."""

from __future__ import annotations

import errno
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import ROOT
from workbench.contact.clearance_pairs import room_of_segments, rooms_by_mover
from workbench.contact.collide import allowed_depth, nearest
from workbench.errors import InputError
from workbench.files.study.saving import read_text
from workbench.files.yaml_text import read_yaml
from workbench.model.environment import Control
from workbench.model.surroundings import Move, Surroundings, move_parts
from workbench.posture.reaching.limbs import limb
from workbench.study.bench.answers import answer, judged, near_pairs
from workbench.study.bench.edits import adjusted_to, looking_at, seated, shifted
from workbench.study.bench.edits_joints import LimbTarget, mirrored, reached, turned
from workbench.study.bench.edits_people import SizeWanted, dressed, sized
from workbench.study.bench.edits_postures import freed, posed, predicted, suggested
from workbench.study.bench.history import TOGETHER, Entry, History
from workbench.study.bench.placing import controls_there, placed_people
from workbench.study.bench.saving import said, save
from workbench.study.bench.state import (
    Arrangement,
    arranged_study,
    given_angles,
    open_study,
)


def verdict_words(verdicts):
    """What a reader sees of verdicts: to 0.01 mm or degrees."""
    rows = []
    for one in verdicts:
        worst = one.worst
        said = worst and (worst.case, worst.person, worst.other_person, worst.subject, worst.target)
        value = worst and round(float(worst.value), 5)
        rows.append((one.criterion.name, one.passed, len(one.breaches), said, value))
    return rows


@pytest.mark.parametrize("seed", range(4))
def test_parts_displaced_are_the_parts_moved(trainer, placement, seed):
    shifts = np.random.default_rng(seed).uniform(-0.1, 0.1, (2, 3))
    arranged = Surroundings(trainer.study.environment, trainer.movers, shifts)
    environment = arranged.moved()
    person = placement.people[0]
    rest = rooms_by_mover(person.placed, placement.parts)
    found = room_of_segments(rooms_by_mover(person.placed, arranged, rest))
    plain = nearest(person.placed, environment)
    room = (plain.distance + allowed_depth(person.body, environment))[0].min(axis=1)
    near = np.isfinite(room)
    assert np.array_equal(np.isfinite(found.distance[0]), near) and near.sum() > 10
    assert np.abs(found.distance[0, near] - room[near]).max() < 1e-12
    person_of = person.placed.body
    sphere, point = found.sphere[0, near], found.point[0, near]
    away = np.linalg.norm(point - person.placed.centres[0, sphere], axis=1)
    outside, inside = (
        found.distance[0, near] + person_of.radius[0, sphere] - s * away for s in (1, -1)
    )
    # the point is in the world; the centre of a sphere may be inside of a solid
    assert np.maximum(outside, inside).min() > -1e-9


def test_verdicts_at_opening_are_those_of_a_run(trainer):
    run = wb.run(wb.load_study("trainer_clearance"))
    found = judged(trainer, trainer.start).found.verdicts
    assert verdict_words(found) == verdict_words(run.verdicts)


def test_the_worst_pair_at_hand_is_that_of_the_clearances(trainer, placement):
    near = near_pairs(answer(placement))
    assert [pair.room for pair in near] == sorted(pair.room for pair in near)
    environment = trainer.study.environment
    person = placement.people[0]
    plain = nearest(person.placed, environment).distance + allowed_depth(person.body, environment)
    least = min(pair.room for pair in near if pair.person == "pilot" and not pair.other_person)
    assert least == pytest.approx(float(np.nanmin(plain)), abs=1e-12)


def test_an_answer_that_builds_on_another_is_the_same(trainer, placement):
    first = answer(placement)
    after = turned(placement, "pilot", "RE", 0, 60.0).arrangement
    there = placed_people(trainer, after, before=placement)
    assert there.people[1] is placement.people[1]
    anew = answer(placed_people(trainer, after))
    again = answer(there, first)
    assert again.people[1].own is first.people[1].own
    assert near_pairs(again, 60) == near_pairs(anew, 60)
    seat = seated(trainer, after, "instructor", 0.02, 0.0).arrangement
    anew = answer(placed_people(trainer, seat))
    moved_seat = answer(placed_people(trainer, seat, before=there), again)
    assert near_pairs(moved_seat, 60) == near_pairs(anew, 60)


def test_a_joint_turns_to_a_tenth_of_a_degree_and_says_when_its_stop_is_passed(trainer, placement):
    body = trainer.start.body(0)
    edit = turned(placement, "pilot", "RE", 0, 61.2345)
    found = answer(placed_people(trainer, edit.arrangement)).people[0]
    assert np.degrees(found.angles[body.joint("RE"), 0]) == pytest.approx(61.2, abs=1e-9)
    assert edit.words == ""
    far = turned(placement, "pilot", "RE", 0, 170.0)
    assert "beyond the stop of flexion" in far.words
    same = turned(placement, "pilot", "RE", 0, 68.04)
    assert same.arrangement.people[0] is trainer.start.people[0]


@pytest.mark.parametrize("joint", ["LS", "RW", "NP", "LH", "RK", "W", "LA"])
def test_who_is_placed_from_another_state_sits_as_anew(trainer, placement, joint):
    body = trainer.start.body(0)
    after = turned(placement, "pilot", joint, 0, 30.0).arrangement
    anew = placed_people(trainer, after).people[0]
    again = placed_people(trainer, after, before=placement).people[0]
    assert np.array_equal(again.placed.centres, anew.placed.centres)
    assert np.any(again.poses.rotations[0, body.joint(joint)] != 0.0)
    assert np.array_equal(again.shift, anew.shift)


@pytest.mark.parametrize(
    ("person", "joint", "axis", "degrees", "words"),
    [
        ("nobody", "RE", 0, 10.0, "nobody is called 'nobody'"),
        ("pilot", "XX", 0, 10.0, "no joint 'XX'"),
        ("pilot", "RE", 3, 10.0, "axes 0, 1 and 2"),
        ("pilot", "RE", 0, 1e9, "-180 to 180 degrees"),
        ("pilot", "RE", 0, float("nan"), "-180 to 180 degrees"),
    ],
)
def test_a_joint_that_cannot_be_turned_says_why(
    trainer, placement, person, joint, axis, degrees, words
):
    with pytest.raises(InputError, match=words):
        turned(placement, person, joint, axis, degrees)


def test_a_hand_goes_to_a_target_and_says_how_far_it_misses(trainer, placement):
    tip = answer(placement).people[0].tips["right hand"]
    goal = tuple((tip + np.array([0.0, 0.05, 0.02])).tolist())
    edit = reached(trainer, placement, "pilot", LimbTarget("right hand", goal))
    assert edit.words == ""
    got = answer(placed_people(trainer, edit.arrangement)).people[0].tips["right hand"]
    assert np.linalg.norm(got - goal) < 3e-3  # angles stand in tenths of a degree
    far = reached(trainer, placement, "pilot", LimbTarget("right hand", (3.0, 0.0, 1.0)))
    assert "mm short of the target, limited by" in far.words


def test_spheres_that_are_in_somebody_else_are_known(trainer, placement):
    assert answer(placement).overlaps == (frozenset(), frozenset())
    other = placement.people[1].placed
    goal = other.centres[
        0, trainer.start.body(1).sphere_segment == trainer.start.body(1).segment("UT")
    ].mean(0)
    edit = reached(trainer, placement, "pilot", LimbTarget("right hand", tuple(goal.tolist())))
    there = placed_people(trainer, edit.arrangement)
    found = answer(there)
    one, two = (person.placed for person in there.people)
    gap = np.linalg.norm(one.centres[0][:, None] - two.centres[0][None], axis=2)
    gap -= one.body.radius[0][:, None] + two.body.radius[0][None]
    deep = gap < -1e-6
    mine, yours = found.overlaps
    assert mine and yours
    assert mine <= set(np.flatnonzero(deep.any(axis=1)))
    assert yours <= set(np.flatnonzero(deep.any(axis=0)))
    least = np.unravel_index(gap.argmin(), gap.shape)
    assert least[0] in mine and least[1] in yours
    pair = next(pair for pair in near_pairs(found, 60) if pair.other_person == "instructor")
    assert pair.room == pytest.approx(gap.min(), abs=1e-12)


def test_a_hand_takes_hold_of_a_control(trainer, placement):
    edit = reached(trainer, placement, "pilot", LimbTarget("right hand", control="throttle"))
    assert edit.words == "right hand on throttle"
    with pytest.raises(InputError, match="no control 'thrott'; did you mean 'throttle'"):
        reached(trainer, placement, "pilot", LimbTarget("right hand", control="thrott"))


def test_a_control_on_the_own_seat_is_where_that_stands(trainer):
    environment = trainer.study.environment
    knob = Control("knob", (0.2, 0.3, 0.5), "push", 1, environment.parts[trainer.movers[0][0]])
    there = replace(environment, controls=(*environment.controls, knob))
    *others, moved = controls_there(trainer, there, 0, np.array([0.05, 0.0, -0.02]))
    assert moved.at == pytest.approx((0.25, 0.3, 0.48))
    assert tuple(others) == environment.controls


def test_a_hand_on_a_control_stays_there_until_its_arm_is_turned(trainer, placement):
    hold = LimbTarget("right hand", control="throttle")
    held = reached(trainer, placement, "pilot", hold).arrangement
    action = held.people[0].actions[0]
    assert action.hands == {"right hand": "throttle"}
    there = placed_people(trainer, held, before=placement)
    assert reached(trainer, there, "pilot", hold).arrangement.content == held.content
    lever = Move(("throttle_lever",), (), (0.03, 0.0, 0.0))
    moved_lever = shifted(trainer, held, lever).arrangement
    after = placed_people(trainer, moved_lever, before=there)
    way = tip_on(trainer, after, "throttle") - tip_on(trainer, there, "throttle")
    assert way == pytest.approx([0.03, 0.0, 0.0], abs=1e-4)  # it goes along with the lever
    head = turned(after, "pilot", "HP", 0, 5.0).arrangement
    assert head.people[0].actions[0].hands == action.hands
    free = turned(after, "pilot", "RE", 0, 60.0).arrangement
    assert free.people[0].actions[0].hands == {}
    shoulder = trainer.start.body(0).joint("RS")
    shown = given_angles(after.people[0].body, after.people[0].poses)[shoulder]
    kept = given_angles(after.people[0].body, free.people[0].actions[0].poses)[shoulder]
    assert kept == pytest.approx(shown, abs=np.radians(0.051))


def test_a_hand_that_is_held_is_saved_and_run_as_it_is_shown(trainer, placement, tmp_path):
    path = tmp_path / "held.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    opened = open_study(wb.load_study(str(path)))
    first = placed_people(opened, opened.start)
    hold = LimbTarget("left hand", control="mixture")
    held = reached(opened, first, "instructor", hold).arrangement
    text = read_text(path)
    saved = save(opened, text, held)
    line = next(row for row in saved.text.splitlines() if "cruise" in row)
    assert line.endswith("instructor: {posture: riding, hands: {left: mixture}}}}")
    run = wb.run(wb.load_study(str(path)))
    shown = placed_people(opened, held).people[1].placed
    assert np.array_equal(run.postures[0].people[1].placed.centres[0], shown.centres[0])
    again = open_study(wb.load_study(str(path)))
    free = turned(placed_people(again, again.start), "instructor", "LE", 0, 60.0).arrangement
    assert "hands: {" not in save(again, read_text(path), free).text


def tip_on(opened, placement, name):
    """Where the right hand of the first person is by the grip of a control."""
    grip = next(one.grip for one in opened.study.environment.controls if one.name == name)
    there = placement.people[0]
    one = limb(there.body, "right hand", grip=grip)
    world = there.placed.world_from_segment[0, one.end]
    return world[:, :3] @ one.tip[0] + world[:, 3]


def test_a_seat_stays_within_its_travel(trainer):
    edit = seated(trainer, trainer.start, "pilot", 0.01004, 0.0)
    assert edit.arrangement.people[0].forward == pytest.approx(0.01, abs=1e-12)
    there = placed_people(trainer, edit.arrangement)
    environment = there.parts.moved()
    seat = trainer.seat(0)
    shift = there.people[0].shift
    expected = move_parts(trainer.study.environment, seat.moves, shift)
    assert np.array_equal(environment.vertices, expected.vertices)
    with pytest.raises(InputError, match="the travel of seat left is"):
        seated(trainer, trainer.start, "pilot", 5.0, 0.0)


@pytest.mark.parametrize("seed", range(3))
def test_a_part_that_is_moved_is_asked_where_it_stands(trainer, placement, seed):
    by = np.random.default_rng(seed).uniform(-0.1, 0.1, 3).round(4)
    first = shifted(trainer, trainer.start, Move(("left_stick", "compass"), (), tuple(by)))
    assert first.words == "left_stick goes along"
    second = seated(trainer, first.arrangement, "pilot", 0.02, 0.01).arrangement
    there = placed_people(trainer, second, before=placement)
    found = answer(there, answer(placement))
    environment = there.parts.moved()
    shift = there.people[0].shift
    expected = move_parts(
        move_parts(trainer.study.environment, ["left_stick", "compass"], by),
        trainer.seat(0).moves,
        shift,
    )
    assert np.abs(environment.vertices - expected.vertices).max() < 1e-12
    person = there.people[0]
    plain = nearest(person.placed, expected)
    room = (plain.distance + allowed_depth(person.body, expected))[0].min(axis=1)
    near = np.isfinite(room)
    assert np.abs(found.people[0].near.distance[0, near] - room[near]).max() < 1e-12


def test_a_move_takes_the_place_of_what_was_said_of_the_same_parts(trainer):
    def moves(arrangement, parts, by, controls=()):
        return shifted(trainer, arrangement, Move(parts, controls, by)).arrangement

    both = moves(trainer.start, ("compass", "flap_lever"), (0.1, 0.0, 0.0))
    one = moves(both, ("compass",), (0.0, 0.02, 0.0))
    rows = [(move.parts, move.by) for move in one.moves]
    assert rows == [(("flap_lever",), (0.1, 0.0, 0.0)), (("compass",), (0.0, 0.02, 0.0))]
    assert moves(one, ("flap_lever",), (0.0, 0.0, 0.0)).moves == one.moves[1:]
    assert moves(both, ("compass", "flap_lever"), (0.1, 0.00004, 0.0)) is both
    alone = moves(one, (), (0.0, 0.0, 0.03), controls=("flaps",))
    study = arranged_study(trainer, alone)
    at = {control.name: np.array(control.at) for control in study.environment.controls}
    start = {control.name: control.at for control in trainer.study.environment.controls}
    assert at["flaps"] - start["flaps"] == pytest.approx([0.1, 0.0, 0.03])


@pytest.fixture(scope="module")
def car(tmp_path_factory):
    """One driver of the car in a seat that is held, in a file of its own."""
    text = (ROOT / "studies" / "car_driver.yaml").read_text()
    who = "size: {sex: male, measures: {stature: 1800}}, position: {forward: 0, up: 0}}"
    text = re.sub(r"population: .*?\}\}", who, text, count=1)
    path = tmp_path_factory.mktemp("car") / "car.yaml"
    path.write_text(
        "".join(row for row in text.splitlines(True) if row[:6] not in ("shares", "change"))
    )
    return path


def test_an_adjustment_is_set_and_saved_where_it_belongs(car):
    opened = open_study(wb.load_study(str(car)))
    edit = adjusted_to(opened, opened.start, "wheel_telescope", 0.02004)
    assert edit.words == "wheel telescope at 20 mm"
    tilted = adjusted_to(opened, edit.arrangement, "wheel_tilt", np.radians(-2)).arrangement
    saved = save(opened, read_text(car), tilted)
    assert "adjust: {wheel_telescope: 20, wheel_tilt: -2}}" in saved.text
    study = wb.load_study(str(car))
    there = placed_people(opened, tilted).parts.environment
    assert np.array_equal(there.vertices, study.environment.vertices)
    with pytest.raises(InputError, match="its travel is -25 to 25 mm, got 30 mm"):
        adjusted_to(opened, opened.start, "wheel_telescope", 0.03)
    again = open_study(study)
    back = adjusted_to(again, again.start, "wheel_tilt", 0.0).arrangement
    assert "adjust: {wheel_telescope: 20, wheel_tilt: 0}}" in save(again, read_text(car), back).text


def test_who_frees_a_seat_finds_the_adjustments_that_nobody_states(car):
    opened = open_study(wb.load_study(str(car)))
    stated = dict(opened.start.settings)
    free = freed(opened, opened.start, "driver").arrangement
    role = arranged_study(opened, free).roles[0]
    assert role.free and not set(role.adjusts) & set(stated)
    assert set(role.adjusts) | set(stated) == {"wheel_tilt", "wheel_telescope"}


def test_another_case_is_looked_at(trainer):
    edit = looking_at(trainer, trainer.start, "looking left")
    assert edit.arrangement.case == 1 and edit.arrangement.people == trainer.start.people
    with pytest.raises(InputError, match="no case 'looking'"):
        looking_at(trainer, trainer.start, "looking")


def test_history_undoes_and_redoes_and_joins_one_drag():
    states = [Arrangement((), case) for case in range(5)]
    history = History.of(states[0])
    history = history.added(Entry(states[1], "RE", 10.0))
    history = history.added(Entry(states[2], "RE", 10.0 + TOGETHER / 2))
    history = history.added(Entry(states[3], "RE", 12.0 + TOGETHER))
    assert [one.arrangement for one in history.entries] == [states[0], states[2], states[3]]
    back = history.undone()
    assert back.shown.arrangement is states[2] and back.redone().shown is history.shown
    assert back.undone().undone().shown.arrangement is states[0]
    other = back.added(Entry(states[4], "seat", 20.0))
    assert not other.can_redo and other.shown.arrangement is states[4]


def test_history_forgets_the_oldest_states():
    history = History.of(Arrangement(()))
    for number in range(600):
        history = history.added(Entry(Arrangement((), number)))
    assert len(history.entries) == 500 and history.shown.arrangement.case == 599


EDITS = st.one_of(
    st.tuples(
        st.just("turn"),
        st.sampled_from(["pilot", "instructor"]),
        st.sampled_from(["LS", "RE", "NP", "LH", "RK", "RW"]),
        st.integers(0, 2),
        st.floats(-40, 90),
    ),
    st.tuples(
        st.just("seat"),
        st.sampled_from(["pilot", "instructor"]),
        st.floats(-0.05, 0.05),
        st.just(0.0),
        st.none(),
    ),
    st.tuples(
        st.just("hand"), st.just("pilot"), st.just("throttle"), st.just("right hand"), st.none()
    ),
    st.tuples(
        st.just("move"),
        st.sampled_from(["throttle_lever", "compass", "instrument_panel", "left_stick"]),
        *[st.floats(-0.2, 0.2)] * 3,
    ),
    st.tuples(
        st.just("move control"),
        st.sampled_from(["throttle", "flaps"]),
        *[st.floats(-0.2, 0.2)] * 3,
    ),
    st.tuples(
        st.just("size"),
        st.sampled_from(["pilot", "instructor"]),
        st.sampled_from(["female", "male"]),
        st.floats(1.5, 1.9),
        st.sampled_from([None, 5.0, 50.0, 95.0]),
    ),
    st.tuples(
        st.just("clothes"),
        st.sampled_from(["pilot", "instructor"]),
        st.lists(st.sampled_from(["helmet", "boots", "vest"]), unique=True, max_size=2),
        *[st.none()] * 2,
    ),
    st.tuples(st.just("mirror"), st.sampled_from(["pilot", "instructor"]), *[st.none()] * 3),
    st.tuples(
        st.just("posture"),
        st.sampled_from(["pilot", "instructor"]),
        st.sampled_from(["riding", "flying", "hands_in_lap"]),
        *[st.none()] * 2,
    ),
    st.tuples(st.just("predict"), st.just("pilot"), *[st.none()] * 3),
    st.tuples(st.just("case"), st.sampled_from(["cruise", "looking left"]), *[st.none()] * 3),
)


def edited(opened, arrangement, edit):
    """A state after an edit; the same where the edit is refused."""
    verb, who, *more = edit
    try:
        if verb == "case":
            return looking_at(opened, arrangement, who).arrangement
        if verb == "seat":
            return seated(opened, arrangement, who, *more[:2]).arrangement
        if verb.startswith("move"):
            parts, controls = ((), (who,)) if verb == "move control" else ((who,), ())
            return shifted(opened, arrangement, Move(parts, controls, tuple(more))).arrangement
        if verb == "size":
            percentiles = {} if more[2] is None else {"sitting_height": more[2]}
            wanted = SizeWanted(more[0], {"stature": more[1]}, percentiles)
            return sized(opened, arrangement, who, wanted).arrangement
        if verb == "clothes":
            return dressed(opened, arrangement, who, more[0]).arrangement
        there = placed_people(opened, arrangement)
        if verb == "mirror":
            return mirrored(there, who).arrangement
        if verb == "posture":
            return posed(opened, there, who, more[0]).arrangement
        if verb == "predict":
            tips = answer(there).people[0].tips
            return predicted(opened, there, who, suggested(opened, there, 0, tips)).arrangement
        if verb == "turn":
            return turned(there, who, *more).arrangement
        return reached(opened, there, who, LimbTarget(more[1], control=more[0])).arrangement
    except InputError:
        return arrangement


@settings(max_examples=5)
@given(st.lists(EDITS, min_size=1, max_size=5))
def test_random_edits_saved_are_what_a_run_then_finds(trainer, tmp_path_factory, edits):
    folder = tmp_path_factory.mktemp("saved")
    path = folder / "trainer_clearance.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    text = read_text(path)
    arrangement = trainer.start
    for edit in edits:
        arrangement = edited(trainer, arrangement, edit)
    after = save(trainer, text, arrangement)
    assert after.data == path.read_bytes()
    run = wb.run(wb.load_study(path))
    assert verdict_words(judged(trainer, arrangement).found.verdicts) == verdict_words(run.verdicts)
    assert list(folder.iterdir()) == [path]
    again = save(trainer, text, trainer.start, disk=after)
    assert again.data == text.data == path.read_bytes()


def test_a_file_that_changed_meanwhile_is_not_written_over(trainer, placement, tmp_path):
    path = tmp_path / "a.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    text = read_text(path)
    path.write_text(path.read_text() + "# by an editor\n")
    state = turned(placement, "pilot", "RE", 0, 60.0).arrangement
    with pytest.raises(InputError, match="has changed on the disk"):
        save(trainer, text, state)
    assert path.read_text().endswith("# by an editor\n")
    saved = save(trainer, text, state, over=True)
    assert b"by an editor" not in saved.data and saved.data == path.read_bytes()
    with pytest.raises(InputError, match="is there already"):
        save(trainer, text, state, to=path)


KILLED = """
import sys
from dataclasses import replace
from pathlib import Path
import workbench as wb
from tests.killed import killed_before
from workbench.files.study.saving import read_text
from workbench.study.bench.edits import seated
from workbench.study.bench.saving import save
from workbench.study.bench.state import open_study
path = Path(sys.argv[1])
text = read_text(path)
opened = open_study(wb.load_study(path))
state = seated(opened, opened.start, "pilot", 0.02, 0.0).arrangement
new = save(opened, text, state, to=path.with_name("b.yaml")).data
seen = set()
for number in range(1, 30):
    path.write_bytes(text.data)
    killed = killed_before(number, path.parent, lambda: save(opened, text, state))
    seen.add(path.read_bytes() == new)
    assert path.read_bytes() in (text.data, new)
    if not killed:
        break
assert not killed and seen == {False, True}, (number, seen)
path.write_bytes(text.data)
save(opened, text, state)
assert sorted(one.name for one in path.parent.iterdir()) == ["a.yaml", "b.yaml"]
"""
"""A process of its own, which forks before it has threads: what is killed leaves no part of a file."""


def test_killed_at_any_step_of_saving_the_old_study_is_whole_or_the_new_one(tmp_path):
    path = tmp_path / "a.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    done = subprocess.run(
        [sys.executable, "-c", KILLED, str(path)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_a_full_disk_leaves_the_study_and_the_state_as_they_were(
    trainer, placement, tmp_path, monkeypatch
):
    path = tmp_path / "a.yaml"
    shutil.copy(ROOT / "studies" / "trainer_clearance.yaml", path)
    text = read_text(path)

    def full(file):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    state = turned(placement, "pilot", "RE", 0, 60.0).arrangement
    with pytest.raises(InputError, match=r"a\.yaml: cannot be written \(No space left on device\)"):
        save(trainer, text, state)
    assert [one.name for one in tmp_path.iterdir()] == ["a.yaml"]
    assert path.read_bytes() == text.data


def test_a_predicted_posture_becomes_a_given_one_in_its_seat(tmp_path):
    opened = open_study(wb.load_study("trainer_reach"))
    there = placed_people(opened, opened.start)
    edit = turned(there, "small woman", "RE", 0, 50.0)
    person = edit.arrangement.people[0]
    assert not person.free and person.forward == pytest.approx(there.people[0].forward, abs=6e-5)
    path = tmp_path / "reach.yaml"
    shutil.copy(ROOT / "studies" / "trainer_reach.yaml", path)
    save(opened, read_text(path), edit.arrangement)
    study = wb.load_study(path)
    assert not study.roles[0].free and study.roles[1].free
    says = read_yaml(path).value
    assert said(open_study(study), open_study(study).start, says) == says
    text = path.read_text()
    assert "small woman: {posture: driving, angles: {" in text and "large man: {predicted:" in text


def test_a_study_of_motions_alone_has_nobody_in_a_posture():
    opened = open_study(wb.load_study("trainer_crash"))
    assert opened.cases == () and opened.start.people == ()
    assert answer(placed_people(opened, opened.start)).people == ()


def test_the_study_of_the_opened_state_is_the_study_itself(trainer):
    assert arranged_study(trainer, trainer.start) is trainer.study
