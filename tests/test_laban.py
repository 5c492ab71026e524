"""Labanotation: scores are written, performed and read back; directions beyond the stops are reported."""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from workbench import InputError, Poses, UsageError, load_body, place, stops
from workbench.cli import main
from workbench.files.motions.laban import read_score, score_text
from workbench.model.laban import (
    DIRECTIONS,
    LEVELS,
    SUBPARTS,
    Movement,
    Score,
    Sign,
    nearest_sign,
    sign_vector,
    sign_words,
)
from workbench.motion.laban.laban import score_poses
from workbench.motion.laban.limbs import DirectionPath, minimum_jerk
from workbench.motion.laban.reading import read_motion_score, strokes

BODY = load_body("bubbleman")
SIGNS = [Sign(d, h) for h in LEVELS for d in DIRECTIONS]
SCORE = """# remark
title: Reaching
tempo: 60
step: 60 cm
1    2    right arm        forward high
3    1/2  Left lower arm   forward left low   # diagonals in either order
3    1    trunk            hold
4.5  1    support          left middle
"""
BEFORE = {
    "upper arm": ("lower arm", Sign("forward", "middle")),
    "upper leg": ("lower leg", Sign("back", "middle")),
}
"""What must be bent first, for the part to be told apart from the whole limb."""
ALLOWED = {
    "trunk": 3,
    "head": 8,
    "arm": 16,
    "upper arm": 15,
    "lower arm": 9,
    "hand": 5,
    "leg": 5,
    "upper leg": 4,
    "lower leg": 3,
}
"""How many of the 26 or 27 signs other than the zero pose's the stops of bubbleman allow."""


def score(*rows, tempo=60.0):
    return Score(
        tuple(Movement(part, sign, begin, beats) for part, sign, begin, beats in rows), tempo
    )


def told(found):
    return [(m.part, str(m.sign), m.begin, m.beats) for m in found.movements]


def again(given_score):
    poses, notes = score_poses(BODY, given_score)
    return told(read_motion_score(BODY, poses, tempo=given_score.tempo)), notes


def written(tmp_path, text):
    path = tmp_path / "a.laban"
    path.write_text(text)
    return path


def test_a_score_is_read_line_by_line(tmp_path):
    found = read_score(written(tmp_path, SCORE))
    rows = [("right arm", "forward high", 1, 2), ("trunk", "None", 3, 1)]
    rows += [("left lower arm", "left forward low", 3, 0.5), ("support", "left middle", 4.5, 1)]
    assert told(found) == rows
    assert (found.title, found.tempo, found.step) == ("Reaching", 60, 0.6)
    assert [m.line for m in found.movements] == [5, 7, 6, 8]


def test_a_score_that_is_written_is_read_back(tmp_path):
    found = read_score(written(tmp_path, SCORE))
    (tmp_path / "b.laban").write_text("".join(score_text(found)))
    assert told(read_score(tmp_path / "b.laban")) == told(found)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("tempo: 60\n", "", "the tempo is not stated"),
        ("tempo: 60", "tempo: fast", "line 3: tempo 'fast' is no number"),
        ("tempo: 60", "tempo: 5000", "line 3: tempo 5000: 1 to 1000 beats a minute"),
        ("tempo: 60", "temp: 60", "line 3: no key 'temp'; did you mean 'tempo'"),
        ("tempo: 60", "tempo: 60\ntempo: 61", "line 4: tempo stands twice"),
        ("step: 60 cm", "step: 60", "line 4: step '60' needs a number and a unit"),
        ("right arm ", "right harm ", "line 5: no part 'right harm'; did you mean 'right arm'"),
        (
            "forward high",
            "upward high",
            "line 5: right arm: 'upward high' is no direction and level",
        ),
        ("forward high", "forward", "line 5: right arm: 'forward' is no direction and level"),
        (
            "trunk            hold",
            "trunk place middle",
            "line 7: trunk: place middle is no direction",
        ),
        ("4.5  1    support", "0  1    support", "line 8: beat 0 for 1 beats: beats count from 1"),
        ("4.5  1    support", "4.5  0    support", "line 8: beat 4.5 for 0 beats"),
        ("4.5  1    support", "4.5  1/0    support", "line 8: beats '1/0' is no number"),
        ("4.5  1    support", "1e9999999  1    support", "line 8: beat '1e9999999' is no number"),
        (
            "4.5  1    support          left middle",
            "2 1 right hand hold",
            "line 8: right hand at beat 2: the right arm of line 5 moves or holds until beat 3",
        ),
        (
            "4.5  1    support          left middle",
            "2 1 trunk",
            "line 8: '2 1 trunk': beat, beats, part, direction",
        ),
    ],
)
def test_what_is_wrong_in_a_score_is_told_with_its_line(tmp_path, old, new, said):
    with pytest.raises(InputError) as caught:
        read_score(written(tmp_path, SCORE.replace(old, new)))
    assert said in str(caught.value)


def test_a_sign_is_45_degrees_from_its_neighbours():
    assert sign_vector(Sign("forward", "high")) == pytest.approx(np.array([1, 0, 1]) / np.sqrt(2))
    assert sign_vector(Sign("left forward", "middle")) == pytest.approx(
        np.array([1, 1, 0]) / np.sqrt(2)
    )
    assert sign_vector(Sign("place", "low")).tolist() == [0, 0, -1]
    assert all(nearest_sign(3 * sign_vector(s)) == s for s in SIGNS if str(s) != "place middle")
    assert len(SIGNS) == 27 and len({sign_words(s) for s in SIGNS}) == 27
    assert sign_words(Sign("right back", "low")) == "back, to the right and down"


def test_least_jerk_goes_from_rest_to_rest():
    assert minimum_jerk(np.array([-1, 0, 0.5, 1, 2])).tolist() == [0, 0, 0.5, 1, 1]
    assert minimum_jerk(np.array([0.246636]))[0] == pytest.approx(0.1, abs=1e-5)


def test_an_arm_goes_from_low_to_high_by_the_front():
    way = DirectionPath(np.array([0.0, 0, -1]), np.eye(3))
    way.move(0, 1, np.array([0.0, 0, 1]))
    assert way.at(np.array([0.0, 0.5, 1.0])) == pytest.approx(
        np.array([[0, 0, -1], [1, 0, 0], [0, 0, 1]]), abs=1e-9
    )


def test_strokes_lie_between_rests_and_dips():
    time = np.linspace(0, 6, 301)
    path = (
        90
        * (minimum_jerk(time) - minimum_jerk((time - 1) / 2) + minimum_jerk((time - 4) / 2))[
            :, None
        ]
    )
    found = strokes(path, time, least=20)
    assert [t for s in found for t in s[:2]] == pytest.approx([0, 1, 1, 3, 4, 6], abs=0.05)
    assert strokes(path, time, least=100) == []


@pytest.mark.parametrize(
    "part", ["trunk", "head", *SUBPARTS, *SUBPARTS["right arm"], *SUBPARTS["left leg"][:2]]
)
def test_every_direction_that_the_stops_allow_comes_back(part):
    """Of the 27 signs, one after another, from the zero pose: those the stops keep off are told
    instead."""
    limb = part.split(" ", 1)[-1]
    first = (
        [(f"{part.split()[0]} {BEFORE[limb][0]}", BEFORE[limb][1], 1, 1)] if limb in BEFORE else []
    )
    signs = [s for s in SIGNS if str(s) != "place middle"] + [Sign("place", "middle")] * (
        part in SUBPARTS
    )
    signs = [
        s for s in signs if str(s) != ("place high" if part in ("trunk", "head") else "place low")
    ]
    _, notes = score_poses(
        BODY, score(*first, *((part, s, 2 + 2 * k, 2) for k, s in enumerate(signs)), tempo=120)
    )
    kept = [
        s
        for s in signs
        if not any(f"{part} {s} is beyond the joint stops" in note for note in notes)
    ]
    rows = [(part, s, 2 + 2 * k, 2) for k, s in enumerate(kept)]
    found, notes = again(score(*first, *rows, tempo=120))
    assert not notes
    assert [row for row in found if row[2] >= 2] == [(part, str(s), b, n) for _, s, b, n in rows]
    assert len(kept) == ALLOWED[limb]


def test_every_support_comes_back():
    rows = [
        ("support", s, 1 + 2 * k, 2)
        for k, s in enumerate(s for s in SIGNS if str(s) != "place middle")
    ]
    found, notes = again(score(*rows, tempo=120))
    assert found == [(part, str(s), b, n) for part, s, b, n in rows]
    assert not notes


def test_what_is_reached_is_within_the_stops_and_on_the_ground():
    given_score = score(
        ("left arm", Sign("right back", "high"), 1, 1),
        ("trunk", Sign("back", "low"), 1, 2),
        ("support", Sign("left", "low"), 2, 2),
        ("right leg", Sign("left", "high"), 3, 1),
    )
    poses, notes = score_poses(BODY, given_score)
    assert len(notes) == 3 and "left arm right back high is beyond the joint stops" in notes[1]
    assert stops(BODY, poses).margin.min() > -1e-6
    low = (place(BODY, poses).centres[..., 2] - BODY.radius[0]).min(axis=1)
    assert np.abs(low).max() < 1e-12


ARM = ["forward middle", "forward high", "forward low", "place low", "place high"]
CHOICES = {
    "left arm": ARM,
    "right arm": ARM,
    "trunk": ["forward high", "place high"],
    "head": ["forward high", "place high", "back high"],
    "left leg": ["left low", "forward middle", "place low"],
    "support": ["forward middle", "left low", "back high"],
}


@st.composite
def scores(draw):
    """Short scores in which every movement goes somewhere new."""
    rows = []
    for part, choices in CHOICES.items():
        now = Sign("place", "high" if part in ("trunk", "head") else "low")
        beat = 1.0
        for _ in range(draw(st.integers(0, 2))):
            sign = Sign(*draw(st.sampled_from(choices)).rsplit(" ", 1))
            beat += draw(st.sampled_from([0, 0.5, 1]))
            beats = draw(st.sampled_from([0.5, 1, 1.5, 2]))
            if sign != now or part == "support":
                rows.append((part, sign, beat, beats))
            beat = beat + beats
            now = sign
    return rows


@settings(max_examples=25)
@given(scores(), st.sampled_from([40.0, 60.0, 120.0]))
def test_short_scores_come_back(rows, tempo):
    carried = [(beat, beat + beats) for part, _, beat, beats in rows if part == "support"]
    legs = [(beat, beat + beats) for part, _, beat, beats in rows if part == "left leg"]
    assume(
        not any(a < d and c < b for a, b in carried for c, d in legs)
    )  # a leg that both carries and gestures
    if rows:
        found, notes = again(score(*rows, tempo=tempo))
        assert not notes
        assert sorted(found) == sorted(
            (part, str(sign), begin, beats) for part, sign, begin, beats in rows
        )


def test_a_body_that_stands_still_has_no_score():
    poses, _ = score_poses(BODY, score(("head", Sign("place", "high"), 1, 1)))
    with pytest.raises(InputError, match="nothing moves far enough"):
        read_motion_score(BODY, poses, tempo=60)
    with pytest.raises(UsageError, match="tempo 0"):
        read_motion_score(
            BODY, Poses(poses.rotations, poses.reference, poses.world_from_reference), tempo=0
        )


def test_a_body_with_other_joints_is_refused(one_arm):
    with pytest.raises(InputError, match="a score needs the paper's joints; W, SP"):
        score_poses(one_arm, score(("head", Sign("place", "high"), 1, 1)))


def test_the_command_line_moves_a_score_and_writes_one(tmp_path, capsys):
    source = written(tmp_path, SCORE.replace("forward high", "left back high"))
    assert main(["motion", "convert", str(source), "-o", str(tmp_path / "m.csv")]) == 0
    assert (
        "a.laban: line 5: right arm left back high is beyond the joint stops"
        in capsys.readouterr().err
    )
    assert (
        main(
            [
                "motion",
                "convert",
                str(tmp_path / "m.csv"),
                "-o",
                str(tmp_path / "b.laban"),
                "--tempo",
                "60",
            ]
        )
        == 0
    )
    assert told(read_score(tmp_path / "b.laban"))[0][0] == "right arm"
    assert (
        main(["motion", "convert", str(tmp_path / "m.csv"), "-o", str(tmp_path / "c.laban")]) == 2
    )
    assert "needs its --tempo" in capsys.readouterr().err
    assert not (tmp_path / "c.laban").exists()


def test_a_score_whose_lines_all_overlap_is_refused_at_once(tmp_path):
    rows = "".join("1 90000 left hand forward high\n" for _ in range(5000))
    (tmp_path / "a.laban").write_text(f"tempo: 60\n{rows}")
    start = process_time()
    with pytest.raises(InputError, match="moves or holds until"):
        read_score(tmp_path / "a.laban")
    assert process_time() - start < 5
