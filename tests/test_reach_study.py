"""Reach studies: seats, feet and hands that find their places; what controls are reached;
envelopes."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ROOT
from tests.made_studies import found_of, made_study
from tests.seat_oracle import eye_points
from workbench import limb, load_study, scale
from workbench.draw.scene_builder import build_source
from workbench.model.criterion import Criterion
from workbench.model.reach import DOUBTS
from workbench.report.postures.envelopes import litres_taken
from workbench.report.postures.rows import doubt_sentence
from workbench.study.people import present_people
from workbench.study.situation import position_of
from workbench.study.warnings import controls_inside_solids

STUDY = """
study: two_sitters
length: mm
environment: trainer
people:
  pilot: {body: bubbleman, seat: left}
cases:
  - name: flying
    people:
      pilot:
        predicted:
          hands: {left: left_stick, right: throttle}
          feet: {left: left_seat_left_pedal, right: left_seat_right_pedal}
          eyes: left_design_eye
          heels: left_heel
criteria:
  - {name: flying controls, check: reach, controls: [left_stick, throttle, grab_handle], zone: 1}
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    def write(text):
        path = tmp_path_factory.mktemp("study") / "study.yaml"
        path.write_text(text)
        return path

    return write


@pytest.fixture(scope="module")
def flying(written):
    """The median man in the left seat, predicted: his study, person, environment and placed
    body."""
    there = present_people(load_study(written(STUDY)))
    situation = there.situations[0][0]
    return (
        situation,
        (*there.words, *(one.sentence for one in there.short)),
        there.environment,
        situation.placed,
    )


def tip(placed, name, grip):
    arm = limb(placed.body, name, grip=grip)
    world = placed.world_from_segment[0, arm.end]
    return world[:, :3] @ arm.tip[0] + world[:, 3]


def test_hands_and_feet_are_on_their_controls_without_an_angle_given(flying):
    _, _, environment, placed = flying
    at = {control.name: control.at for control in environment.controls}
    for name, grip, control in (
        ("left hand", "grasp", "left_stick"),
        ("right hand", "grasp", "throttle"),
        ("left foot", "ball", "left_seat_left_pedal"),
        ("right foot", "ball", "left_seat_right_pedal"),
    ):
        assert np.linalg.norm(tip(placed, name, grip) - at[control]) < 2e-3, name


def test_the_seat_stays_within_its_travel_and_what_it_cannot_give_is_told(flying):
    situation, told, environment, placed = flying
    ((forward, up),) = position_of(situation)
    seat = environment.seat("left")
    assert seat.travel_forward[0] <= forward <= seat.travel_forward[1]
    assert seat.travel_up[0] <= up <= seat.travel_up[1]
    off = eye_points(placed)[0, 2] - environment.points["left_design_eye"][2]
    assert abs(off) < 2e-3 or any("eyes" in line for line in told)


def test_the_predicted_posture_is_within_the_stops(flying):
    situation, _, _, placed = flying
    poses = wb.Poses(situation.poses.rotations, 1, placed.world_from_segment[:, 1])
    assert np.degrees(wb.stops(placed.body, poses).margin.min()) > -0.1


@pytest.fixture(scope="module")
def ran(written):
    """The file of the study, and its result."""
    path = written(STUDY)
    return path, wb.run(load_study(path))


def test_a_run_says_who_reaches_what_in_words(ran, tmp_path):
    from workbench.report.folder import write_report

    _, result = ran
    rows = write_report(result, tmp_path / "out")
    reached = {(r.control, r.zone): r.reached for r in result.postures[0].reaches}
    assert reached["left_stick", 1] and reached["throttle", 1] and not reached["grab_handle", 1]
    sentence = next(
        r.sentence for r in rows.postures[0].reaches if r.control == "grab_handle" and r.zone == 1
    )
    assert re.fullmatch(
        r"pilot, zone 1: the right hand stays \d+\.\d mm short of grab_handle, limited by .+\.",
        sentence,
    )
    assert not rows.passed and "<h2>Reach</h2>" in (tmp_path / "out" / "report.html").read_text()
    assert (tmp_path / "out" / "reaches.csv").read_text().count("\n") == 1 + 3 * 3


@pytest.mark.parametrize(
    "hands, asked",
    [("left: throttle", "left hand"), ("right: throttle", "right hand"), ("", "right")],
)
def test_the_limb_that_a_case_puts_on_a_control_is_asked_for_it(written, hands, asked):
    held = "hands: {left: left_stick, right: throttle}"
    assert STUDY.count(held) == 1
    text = STUDY.replace(held, f"hands: {{{hands}}}").replace("left_stick, throttle, grab", "grab")
    text = text.replace("[grab_handle], zone: 1", "[throttle, left_seat_left_pedal]")
    text = text.replace(
        "left: left_seat_left_pedal, right: left", "right: left_seat_left_pedal, left: left"
    )
    result = wb.run(load_study(written(text)))
    limbs = {row.control: row.limb for row in result.postures[0].reaches}
    assert limbs["throttle"].startswith(asked)
    assert limbs["left_seat_left_pedal"] == "right foot"


def test_what_is_to_spare_is_how_much_farther_from_the_shoulder_the_hand_gets(ran, flying):
    situation, environment = flying[0], flying[2]
    poses, placed = situation.taken.poses, flying[3]
    body = placed.body
    spares = {r.control: r for r in ran[1].postures[0].reaches if r.spare is not None}
    assert set(spares) == {"left_stick", "throttle"}
    for row in spares.values():
        assert 0 < row.spare <= 0.2
        arm = limb(body, row.limb, grip="grasp", zone=row.zone)
        upper = body.joint("RS" if row.limb == "right hand" else "LS")
        world = placed.world_from_segment[0, upper + 1]
        shoulder = world[:, :3] @ body.joint_in_child[0, upper] + world[:, 3]
        at = np.array(one(environment, row.control).at)
        way = (at - shoulder) / np.linalg.norm(at - shoulder)
        beyond = np.array([at + (row.spare + more) * way for more in (-0.002, 0.004)])
        nearer, farther = wb.reach(body, poses, beyond, limb=arm).reached[0].tolist()
        assert nearer and not (farther and row.spare < 0.2)
    assert min(row.spare for row in spares.values()) < 0.2


def test_a_picture_shows_the_posture_of_the_run_to_the_last_bit(ran):
    path, result = ran
    measured = result.postures[0]
    drawn = build_source(str(path)).scene
    assert len(drawn.bodies) == len(measured.people) == 1
    for shown, person in zip(drawn.bodies, measured.people, strict=True):
        np.testing.assert_array_equal(shown.placed.centres, person.placed.centres)
        np.testing.assert_array_equal(
            shown.placed.world_from_segment, person.placed.world_from_segment
        )
    np.testing.assert_array_equal(drawn.environment.vertices, measured.environment.vertices)


def test_what_is_reached_in_a_zone_is_reached_in_the_next(bubbleman):
    """The belly of somebody so near to the stick is in the way of zone 3 alone, which moves the
    trunk."""
    trainer = wb.load_environment("trainer")
    body = scale(bubbleman, {"stature": 1.731})
    legs = {
        "LH": {"flexion": 80},
        "RH": {"flexion": 80},
        "LK": {"flexion": 70},
        "RK": {"flexion": 70},
    }
    pose = wb.pose(body, legs, reference="LT", position=(0.219, 0.28, 0.407))
    asked = Criterion("throttle", "reach", ("pilot",), (), (), 0.0, controls=("throttle",))
    rows = found_of(made_study(trainer, {"pilot": ({"body": body}, pose)}, [asked])).reaches
    alone = wb.reach(
        body,
        pose,
        one(trainer, "throttle").at,
        environment=trainer,
        limb=limb(body, "right hand", grip="grasp", zone=3),
    )
    assert alone.reached[0, 0]
    assert [row.zone for row in rows] == [1, 2, 3] and all(row.reached for row in rows)


def one(environment, name):
    return next(control for control in environment.controls if control.name == name)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("left: left_stick", "left: stick", "no control 'stick'"),
        ("left: left_stick", "left: left_seat_left_pedal", "is for feet"),
        ("left: left_seat_left_pedal", "left: throttle", "is for hands"),
        ("eyes: left_design_eye", "eyes: left_eye", "no point 'left_eye'"),
        (
            "predicted:",
            "posture: driving\n        predicted:",
            "'posture' and 'predicted' are given",
        ),
        (
            "seat: left}",
            "stand: {on: [0, 0, 0]}}",
            "of somebody who stands the hands are predicted",
        ),
        (
            "controls: [left_stick, throttle, grab_handle]",
            "controls: [sticks]",
            "nothing is called 'sticks'",
        ),
        ("zone: 1}", "zone: 4}", "less than or equal to 3"),
        ("check: reach, controls", "check: stops, controls", "does not belong to check: stops"),
    ],
)
def test_what_a_reach_study_cannot_mean_is_told_with_its_place(written, old, new, words):
    assert old in STUDY
    with pytest.raises(wb.InputError, match=re.escape(words)) as caught:
        load_study(written(STUDY.replace(old, new, 1)))
    assert re.search(r"study\.yaml:\d+:\d+", str(caught.value))


def test_a_control_inside_a_solid_is_told():
    trainer = wb.load_environment("trainer")
    assert controls_inside_solids(trainer) == []
    inside = replace(trainer.controls[0], at=(0.0, 0.28, 0.25), part="")
    told = controls_inside_solids(replace(trainer, controls=(inside,)))
    assert len(told) == 1 and "left_seat_back" in told[0]


def test_the_trainer_is_flown_by_a_small_woman_and_a_large_man():
    study = load_study(ROOT / "studies" / "trainer_reach.yaml")
    assert [role.name for role in study.roles] == ["small woman", "large man"]
    assert all(role.free for role in study.roles) and len(study.reach_envelopes) == 2


@pytest.mark.parametrize(
    ("ends", "sentence"),
    [
        ([0, 0], ""),
        (
            [0, 1, 1, 2],
            "In 3 of 4 reaches an obstacle was in the way at first: 2 were solved by a small change of "
            "posture, 1 was solved by another posture.",
        ),
        (
            [0, 3],
            "In 1 of 2 reaches an obstacle was in the way at first: for 1 no clear posture was found, "
            "which does not prove that none exists.",
        ),
        (
            [0, 4],
            "In 1 of 2 reaches an obstacle was in the way at first: for 1 none exists, because the "
            "control is too deep inside a part.",
        ),
    ],
)
def test_the_page_says_how_doubts_ended(ends, sentence):
    assert doubt_sentence([DOUBTS[end] for end in ends]) == sentence


def test_the_litres_that_parts_take_of_an_envelope_add_up():
    lost = dict(zip("abcdef", [0.0476, 0.0116, 0.0096, 0.0055, 0.0046, 0.0021], strict=True))
    named, others, by_others = litres_taken({**lost, "": 0.0001})
    assert [litres for _, litres in named] == [48, 12, 10, 5, 4]  # 81 in all, not 82
    assert (others, by_others) == (2, 2)
