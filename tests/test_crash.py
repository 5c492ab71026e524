"""Crash studies: times, speeds and depths by hand; words, files and faults."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import tracked
from workbench import InputError, Poses, load_body, place
from workbench.cli import main
from workbench.draw.web.motion_view import motion_view
from workbench.files.motions.tables import angle_table_text
from workbench.model.joint_angles import compose, motion_of
from workbench.model.motion import SegmentTrack
from workbench.motion.recorded.retarget import poses_from_track
from workbench.report.motions.movement_summary import movement_sentences
from workbench.report.motions.turning_points import Turning
from workbench.report.page import page as report_page
from workbench.report.result_rows import result_file

BODY = load_body("bubbleman")
PLATE = (
    "o plate\nv -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\nv -2 -2 -1\nv 2 -2 -1\nv 2 2 -1\nv -2 2 -1\n"
    "f 1 2 3 4\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n"
)
STUDY = """study: drop
length: mm
environment: pit
people: {occupant: {body: bubbleman}}
cases:
  - {name: the fall, people: {occupant: {motion: {file: drop.csv}}}}
signals: {points: [{name: head, segment: H}]}
criteria:
  - {name: nothing is hit, check: contact, at_most: 10}
  - {name: head stays low, check: excursion, segments: [H], at_most: 2500, direction: [0, 0, 1], origin: [0, 0, 0]}
  - {name: stops, check: stops}
"""


def spells(track, least):
    """First and last index of each stretch in which a track rises or falls by `least` or more."""
    turning = Turning(least)
    turning.take(track)
    return [(first[0], last[0]) for first, last in turning.spells()]


def standing(height, time, *, angles=None):
    """The zero pose with its soles at heights [m] over time [s]."""
    frames = len(time)
    turns = np.zeros((frames, len(BODY.joints), 3)) if angles is None else angles
    still = Poses(compose(BODY, turns), 0, np.tile(np.eye(3, 4), (frames, 1, 1)), time)
    world = np.array(still.world_from_reference)
    sole = (place(BODY, still).centres[0, :, 2] - BODY.radius[0]).min()
    world[:, 2, 3] = height - sole
    return Poses(still.rotations, 0, world, time)


@pytest.fixture
def drop(tmp_path):
    """A man falls 100 mm at 2 m/s onto a plate, sinks 40 mm in, and comes out again."""
    time = np.array([0, 0.05, 0.07, 0.09, 0.2])
    height = np.array([0.1, 0.0, -0.04, 0.0, 0.2])
    (tmp_path / "environments/pit").mkdir(parents=True)
    (tmp_path / "environments/pit/pit.obj").write_text(PLATE)
    (tmp_path / "environments/pit/environment.yaml").write_text(
        "environment: pit\nlength: mm\nmeshes: [{file: pit.obj, length: m, up: z, forward: x}]\n"
    )
    (tmp_path / "studies").mkdir()
    (tmp_path / "studies/drop.csv").write_text(
        "".join(angle_table_text(BODY, standing(height, time)))
    )
    path = tmp_path / "studies/drop.yaml"
    path.write_text(STUDY)
    return path


def test_a_man_who_falls_on_a_plate_meets_it_when_and_as_fast_and_deep_as_by_hand(drop):
    result = wb.run(wb.load_study(drop)).motions[0]
    feet = [m for m in result.meetings if m.segment in ("LF", "RF")]
    first = min(feet, key=lambda m: m.enter)
    assert first.enter == pytest.approx(0.05, abs=1e-5)
    assert first.leave == pytest.approx(0.09, abs=1e-5)
    assert first.deepest == pytest.approx(0.07, abs=1e-4)
    assert first.depth == pytest.approx(0.04, abs=1e-5)
    assert first.normal == pytest.approx(2.0, rel=1e-3)
    assert first.tangential == pytest.approx(0.0, abs=1e-3)
    assert first.other == "plate"


def test_criteria_of_a_crash_are_judged_with_their_worst_moment(drop):
    result = wb.run(wb.load_study(drop))
    verdicts = {v.criterion.name: v for v in result.verdicts}
    assert result.verdicts == result.motions[0].verdicts
    hit = verdicts["nothing is hit"]
    assert not hit.passed and hit.worst == hit.breaches[0]
    assert hit.worst.value == pytest.approx(-0.040, abs=2e-5)
    assert (hit.worst.limit, hit.worst.unit, hit.motion) == (-0.010, "m", "the fall")
    assert hit.worst.time == pytest.approx(0.07, abs=1e-4)
    head = verdicts["head stays low"]
    assert head.passed and not head.breaches
    assert head.worst.value == pytest.approx(-(1.755 + 0.200), abs=1e-3)
    assert head.worst.time == 0.2
    assert head.worst.point[2] == pytest.approx(-head.worst.value)
    assert head.worst.target == "above the point x 0, y 0, z 0 mm"
    assert verdicts["stops"].passed
    near = verdicts["stops"].worst
    assert (near.subject, near.value, near.unit) == ("left elbow", 0.0, "rad")  # it is straight


def test_a_crash_study_leaves_its_whole_report_and_says_what_happened(drop, capsys, tmp_path):
    assert main(["run", str(drop), "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().out
    assert "FAILED  nothing is hit: Left foot" in said
    assert (
        "1 of 3 criteria fails, “nothing is hit”: left foot (bottom) is 40.0 mm into plate" in said
    )
    rows = json.loads((tmp_path / "out/result.json").read_text())
    sentence = next(c["sentence"] for c in rows["motions"][0]["contacts"] if c["segment"] == "LF")
    assert (
        "meets the plate at 2.0 m/s (2.0 m/s toward it) and is 40.0 mm deep at 70.0 ms; they part at 90.0 ms."
        in sentence
    )
    tables = {
        f"{name}.csv"
        for name in ("verdicts", "breaches", "contacts", "stops", "figures", "clearance", "signals")
    }
    assert {p.name for p in (tmp_path / "out").iterdir()} == {
        "manifest.json",
        "result.json",
        "report.html",
        *tables,
    }
    again = crash_bytes(drop, tmp_path / "again")
    assert again == {p.name: p.read_bytes() for p in (tmp_path / "out").iterdir()}


def crash_bytes(study, folder):
    main(["run", str(study), "--out", str(folder)])
    return {p.name: p.read_bytes() for p in folder.iterdir()}


def test_the_picture_of_a_motion_has_the_moments_that_are_asked_for(drop):
    found = wb.run(wb.load_study(drop)).motions[0]
    view = motion_view(found, "blue", moments=[0.0713, 9.0])
    even = motion_view(found, "blue").times
    assert view.times == tuple(sorted((*even, 0.0713)))


def test_a_motion_compared_with_itself_moved_is_as_far_as_it_was_moved(drop):
    moved = "{motion: {file: drop.csv, move: [30, 0, 40]}}"
    actual = f"  - {{name: actual, people: {{occupant: {moved}}}}}\n"
    text = STUDY.replace("signals:", actual + "signals:") + "compare: [the fall, actual]\n"
    drop.write_text(text)
    result = wb.run(wb.load_study(drop))
    person = len(BODY.segments) - 1 + len(BODY.joints) - 1  # without the stage and its joint
    assert [round(1000 * a.rms, 3) for a in result.agreements] == [50.0] * person
    assert "stage" not in [a.name for a in result.agreements]
    page = report_page(result, result_file(result))
    start = page.index('<div class="still pair">')
    both = page[start : page.index('class="said"', start)]
    assert "the fall: occupant at 70.0 ms" in both and "actual: occupant at 70.0 ms" in both
    assert both.count('src="data:image/png') == 2


def test_channels_are_filtered_as_j211_has_them_as_far_as_their_samples_carry_it(drop):
    """The head at CFC 1000 needs 5,000 samples a second, the chest at CFC 180 needs 900."""
    time = np.arange(0, 0.05, 0.001)
    (drop.parent / "drop.csv").write_text(
        "".join(angle_table_text(BODY, standing(0.1 - 2 * time, time)))
    )
    points = "{name: head, segment: H}, {name: chest, segment: UT}"
    low = "{name: low, segment: H, filter_class: 60}"
    signals = f"signals: {{filter_class: j211, points: [{points}, {low}]}}\n"
    drop.write_text(STUDY.replace("signals: {points: [{name: head, segment: H}]}\n", signals))
    head, chest, sixty = wb.run(wb.load_study(drop)).motions[0].signals
    assert (head.cfc, chest.cfc, sixty.cfc) == (None, 180, 60)
    assert head.note == "CFC 1000 of SAE J211-1 needs 5,000 samples a second or more"
    assert chest.note == "" and sixty.note.startswith("SAE J211-1 has CFC 1000 for it")
    assert "HIC" in head.figures and "HIC" not in chest.figures


def test_a_motion_with_a_wrong_number_of_frames_is_read_where_the_study_says_as_read(drop):
    frames = "0 2.0 30\n0.1 2.1 40\n0.2 2.2 50\n"
    (drop.parent / "drop.mot").write_text(
        f"m\ndatacolumns 3\ndatarows 4\nendheader\ntime pelvis_ty hip_flexion_r\n{frames}"
    )
    drop.write_text(STUDY.replace("file: drop.csv", "file: drop.mot"))
    with pytest.raises(InputError, match=r"says 4 frames, 3 are there; state frames: as_read"):
        wb.run(wb.load_study(drop))
    drop.write_text(STUDY.replace("file: drop.csv", "file: drop.mot, frames: as_read"))
    motion = wb.run(wb.load_study(drop)).motions[0]
    assert "drop.mot: its header says 4 frames, 3 are there and are read" in motion.warnings
    drop.write_text(STUDY.replace("file: drop.csv", "file: drop.mot, frames: all"))
    with pytest.raises(InputError, match=r"frames"):
        wb.load_study(drop)


def test_a_coarse_motion_is_told(drop):
    assert "the motion is coarse" in wb.run(wb.load_study(drop)).motions[0].warnings[0]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("{file: drop.csv}", "{file: fall.csv}", "no such file 'fall.csv'"),
        (
            "{file: drop.csv}",
            "{file: drop.csv, start: 1, end: 0.5}",
            "end 0.5 s must be after start 1 s",
        ),
        ("{file: drop.csv}", "{file: drop.csv, start: 5}", "no frame between 5 and inf s"),
        ("{file: drop.csv}", "{file: drop.csv, end: 0.01}", "one frame is a posture"),
        ("{file: drop.csv}", "{file: drop.yaml}", "is no motion format"),
        ("segment: H}", "segment: HEAD}", "no segment 'HEAD'"),
        ("segments: [H]", "segments: [HH]", "nothing is called 'HH'; did you mean 'H'"),
        ("check: stops", "check: injury", "check: injury needs 'rules'"),
        ("check: stops", "check: stops, at_most: 3", "'at_most' does not belong to check: stops"),
        (
            "occupant: {motion: {file: drop.csv}}",
            "occupant: {motion: {file: drop.csv}, posture: standing}",
            "exactly one of posture, predicted, driver, motion, simulated is needed",
        ),
        (
            "{body: bubbleman}",
            "{body: bubbleman, stand: {on: [0, 0, 0]}}",
            "a motion says itself where the role is: leave 'stand' out",
        ),
        (
            "check: stops",
            "check: reach",
            "check: reach fits no case: it cannot be asked of a motion",
        ),
        (
            "check: stops",
            "check: eye_height, below: 3, cases: [the fall]",
            "does not fit case 'the fall': it cannot be asked of a motion",
        ),
        ("direction: [0, 0, 1]", "direction: [0, 0, 0]", "'direction' must not be zero"),
        (", origin: [0, 0, 0]", "", "check: excursion needs 'origin'"),
        (
            "check: stops",
            "check: injury, rules: fmvss_2",
            "no studies/rules entry named 'fmvss_2'",
        ),
        (
            "check: stops",
            "check: injury, rules: sight_un_r125",
            "rule set sight_un_r125 has no 'limits' of signals",
        ),
    ],
)
def test_what_is_wrong_in_a_crash_study_is_told(drop, old, new, told, capsys):
    drop.write_text(STUDY.replace(old, new))
    assert main(["run", str(drop), "--out", str(drop.parent / "out")]) == 3
    assert told in capsys.readouterr().err
    assert not (drop.parent / "out").exists()


def test_a_direction_of_any_length_is_the_same_direction(drop):
    for length in ("1.0e-300", "1.0e+300"):
        drop.write_text(STUDY.replace("direction: [0, 0, 1]", f"direction: [0, 0, {length}]"))
        (criterion,) = [c for c in wb.load_study(drop).criteria if c.check == "excursion"]
        assert criterion.direction == (0.0, 0.0, 1.0)


def test_rule_sets_that_come_along_are_read_and_a_limit_that_cannot_be_told_fails(drop):
    for path in tracked("studies/rules/*.yaml"):
        assert main(["check", str(path)]) == 0
    drop.write_text(STUDY.replace("check: stops", "check: injury, rules: fmvss_208"))
    verdict = wb.run(wb.load_study(drop)).verdicts[2]
    assert not verdict.passed and verdict.worst is None
    assert verdict.words == (
        "samples of head are 110 ms apart; a figure over 15 ms needs denser ones"
    )


def test_segments_told_one_by_one_give_the_pose_back():
    rng = np.random.default_rng(3)
    angles = rng.uniform(-0.4, 0.4, (4, len(BODY.joints), 3))
    poses = standing(np.zeros(4), np.arange(4) * 0.1, angles=angles)
    world = place(BODY, poses).world_from_segment
    track = SegmentTrack(BODY.segments, world, poses.time, "made")
    again, apart = poses_from_track(BODY, track)
    assert apart.max() < 1e-9
    assert np.abs(place(BODY, again).world_from_segment - world).max() < 1e-9
    moved = SegmentTrack(("LT", "H"), world[:, [1, BODY.segments.index("H")]], poses.time, "made")
    assert poses_from_track(BODY, moved)[1][:, 0].max() < 1e-12
    with pytest.raises(InputError, match="no segment 'head'"):
        poses_from_track(BODY, SegmentTrack(("head",), world[:, :1], poses.time, "made"))


def test_movement_is_told_in_the_words_of_the_limbs():
    time = np.linspace(0, 0.4, 41)
    angles = np.zeros((41, len(BODY.joints), 3))
    for joint, first, last in (("RE", 95, 20), ("RS", 0, 100), ("NP", 0, 30)):
        axis, sign = motion_of(BODY, BODY.joint(joint), "flexion")
        angles[:, BODY.joint(joint), axis] = sign * np.radians(np.linspace(first, last, 41))
    told = movement_sentences(BODY, standing(np.zeros(41), time, angles=angles))
    assert told[0] == "The neck pivot flexes from 0 to 30 degrees between 0 and 400 ms."
    assert told[1] == (
        "The right arm reaches forward and up; the elbow extends from 95 to 20 degrees in 400 ms, "
        "the shoulder flexes from 0 to 100 degrees in 400 ms."
    )
    assert told[2].startswith("After 400 ms the right hand is away from where it was: ")
    assert told[-1].startswith("Directions of arms are relative to the upper torso")


def test_a_limb_that_comes_nearer_to_its_joint_is_drawn_in_and_later_turns_say_when():
    time = np.linspace(0, 1.0, 101)
    angles = np.zeros((101, len(BODY.joints), 3))
    for joint in ("LH", "LK"):
        axis, sign = motion_of(BODY, BODY.joint(joint), "flexion")
        angles[:, BODY.joint(joint), axis] = sign * np.radians(60 * np.clip(2 * time - 1, 0, 1))
    told = movement_sentences(BODY, standing(np.zeros(101), time, angles=angles))
    assert told[0] == (
        "From 500 ms on the left leg is drawn in, forward and up; the hip flexes from 0 to 60 degrees "
        "in 500 ms, the knee flexes from 0 to 60 degrees in 500 ms."
    )


@given(st.lists(st.floats(-60, 60), min_size=1, max_size=60), st.integers(1, 59))
def test_turning_points_are_the_same_piece_by_piece(values, cut):
    track = np.array(values)
    halves = Turning(15.0)
    halves.take(track[:cut])
    halves.take(track[cut:])
    assert [(a[0], b[0]) for a, b in halves.spells()] == spells(track, 15.0)


def test_spells_are_the_turns_between_turning_points_without_small_waves():
    track = np.array([0, 10, 20, 18, 30, 40, 20, 5, 7, 0], dtype=float)
    assert spells(track, 15) == [(0, 5), (5, 9)]
    assert spells(np.zeros(5), 15) == []
