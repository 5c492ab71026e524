"""What people see of things and what hides it, and whether they can read an instrument, in a cockpit
of boxes with lines that can be drawn by hand."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import workbench as wb
from tests.toy_cockpit import STUDY, write_toy
from workbench import load_study
from workbench.model.units import UNITS
from workbench.report.population.sentences import person_sentence
from workbench.report.sentences import finding_words
from workbench.sight.eyes import eyes_of, gaze

HEAD = STUDY.split("criteria:")[0] + "criteria:\n"
ONE = HEAD.replace(", population: {people: PEOPLE, seed: 3}", "")
EDGE = np.array([1.52, 0.9])
"""[m] x and z of the panel's rear upper edge."""
HELD = """
study: held
length: mm
environment: trainer
people: {pilot: {body: adult_male, detail: coarse, seat: left}}
cases: [{name: flying, people: {pilot: {predicted: {hands: {right: throttle}, eyes: left_design_eye}}}}]
criteria:
  - {name: heading, check: sees, instruments: [heading_indicator], at_least: 99}
  - {name: throttle, check: sees, parts: [throttle_lever], at_least: 50}
"""
SIDES = {1: "left", -1: "right"}
DIAL = "instruments:\n  dial: {part: panel, characters: 5}\n  blank: {part: roof}\n"


def written(folder, *criteria, points="", head=ONE, people=6):
    """A study in the toy cockpit, with more points and two instruments."""
    text = head + "".join(f"  - {{{one}}}\n" for one in criteria)
    path = write_toy(folder, study=text, people=people)
    room = folder / "environments/toy/environment.yaml"
    eye = "  eye: [100, 0, 1050]"
    room.write_text(room.read_text().replace(eye, f"{eye}\n{points}") + DIAL)
    return path


def found(folder, *criteria, points="", head=ONE):
    """The verdicts of one person, and the eyes."""
    result = wb.run(load_study(written(folder, *criteria, points=points, head=head)))
    (person,) = result.postures[0].people
    placed = wb.place(person.body, person.poses.rows(np.arange(1)))
    asked = [
        verdict for verdict in result.postures[0].verdicts if verdict.criterion.check != "seated"
    ]
    return asked, eyes_of(placed)


@pytest.fixture(scope="module")
def height(tmp_path_factory):
    """[m] The height over which a point 3 m ahead is seen over the panel, by eyes that are turned to
    it, and under which it is not."""
    _, eyes = found(tmp_path_factory.mktemp("eyes"), "name: a, check: over_nose, down: 1")
    height = 0.7
    for _ in range(6):
        x, _, z = gaze(eyes, [3.0, 0.0, height]).eyes.middle[0].tolist()
        height = z + (3.0 - x) / (EDGE[0] - x) * (EDGE[1] - z)
    return height


@pytest.mark.parametrize(("above", "share"), [(0.005, 1.0), (-0.005, 0.0)])
def test_a_point_over_the_line_of_sight_is_seen_and_one_under_it_is_not(
    tmp_path, height, above, share
):
    point = f"  far: [3000, 0, {1000 * (height + above):.3f}]"
    criterion = "name: a, check: sees, points: [far], at_least: 100"
    ((verdict,), _) = found(tmp_path, criterion, points=point)
    assert verdict.worst.value == share and verdict.passed == (share == 1.0)
    words = finding_words("sees", verdict.worst)
    hidden = "far is 0.0 % visible, 100.0 points less than the 100 % asked for; panel hides 100 %"
    assert words == ("far is 100.0 % visible, the 100 % asked for" if share else hidden)


def test_of_a_disc_across_the_line_half_is_seen(tmp_path, height):
    point = f"  far: [3000, 0, {1000 * height:.3f}]"
    criterion = "name: a, check: sees, points: [far], size: 300, at_least: 40"
    ((verdict,), _) = found(tmp_path, criterion, points=point)
    assert verdict.worst.value == pytest.approx(0.5, abs=0.1) and verdict.passed


def test_characters_must_not_be_larger_than_the_rule_set_s_largest(tmp_path):
    path = written(tmp_path, "name: a, check: reads, instruments: [dial], rules: sight_nureg_0700")
    room = tmp_path / "environments/toy/environment.yaml"
    room.write_text(room.read_text().replace("characters: 5", "characters: 35"))
    verdict = wb.run(load_study(path)).postures[0].verdicts[-1]
    assert verdict.worst.target == "largest size of its characters" and not verdict.passed
    assert math.degrees(-60 * verdict.worst.limit) == pytest.approx(45)
    assert "arc minutes (45.0 arc minutes allowed)" in finding_words("reads", verdict.worst)


@pytest.mark.parametrize(("trunk", "share"), [("", 0.0), (", trunk: 20", 1.0)])
def test_the_trunk_turns_to_what_head_and_eyes_do_not_get_to(tmp_path, trunk, share):
    """Straight to the side of the eyes and 15 degrees behind them: 105, of which head and eyes turn 95."""
    criterion = f"name: a, check: sees, points: [aft], at_least: 1{trunk}"
    point = "  aft: [-25780, -100000, 1100]"
    ((verdict,), _) = found(tmp_path, criterion, points=point)
    assert verdict.worst.value == share


@pytest.mark.parametrize(("trunk", "what"), [("", "head"), (", trunk: 20", "trunk, head")])
def test_what_is_beyond_the_turn_is_told_with_the_trunk_where_it_turns(tmp_path, trunk, what):
    criterion = f"name: a, check: sees, points: [aft], at_least: 1{trunk}"
    ((verdict,), _) = found(tmp_path, criterion, points="  aft: [-3000, 0, 1100]")
    words = finding_words("sees", verdict.worst)
    assert words.endswith(f"; it is beyond the turn of {what} and eyes")


@pytest.mark.parametrize("up", [0.0, 20.0])
def test_a_helmet_turns_with_the_head_to_what_is_looked_at(tmp_path, up):
    """60 degrees to the side the head turns by 45: a helmet that stayed would be before the eyes. It
    hides what somebody sits so that its shell comes between, and nothing else."""
    way = np.array([math.cos(1.05), math.sin(1.05), math.tan(math.radians(up))])
    x, y, z = (1000 * (np.array([0.1, 0.0, 1.05]) + 30.0 * way)).tolist()
    criterion = "name: a, check: sees, points: [aside], at_least: 1"
    worn = ONE.replace("body: adult_male", "body: adult_male, clothes: [helmet]")
    ((verdict,), _) = found(tmp_path, criterion, points=f"  aside: [{x}, {y}, {z}]", head=worn)
    assert verdict.worst.value == 1.0, verdict.worst.target


def test_the_own_hand_hides_the_knob_that_it_holds(tmp_path):
    path = tmp_path / "held.yaml"
    path.write_text(HELD)
    heading, verdict = wb.run(load_study(path)).postures[0].verdicts[-2:]
    assert heading.worst.value == 1.0  # its pointer, which is the same part, is no news
    assert verdict.worst.value < 0.8 and verdict.worst.target.startswith("own right hand hides")


def test_characters_are_seen_at_their_height_across_the_line_over_its_length(tmp_path):
    read = "name: a, check: reads, instruments: [dial], rules: sight_nureg_0700"
    ((verdict,), eyes) = found(tmp_path, read)
    way = np.array([1.5, 0.0, 0.75]) - eyes.middle[0]
    distance = float(np.linalg.norm(way))
    wanted = 0.005 / distance * way[0] / distance
    assert verdict.worst.unit == "arcmin" and not verdict.passed
    assert verdict.worst.value == pytest.approx(wanted, rel=1e-3)
    assert verdict.worst.limit == pytest.approx(math.radians(16 / 60))
    assert finding_words("reads", verdict.worst).startswith(
        f"the characters of dial are seen at {60 * math.degrees(wanted):.1f} arc minutes, "
    )


def test_each_limit_of_reading_can_be_the_one_that_fails(tmp_path):
    """From the point straight over the dial its face is met at a few degrees only."""
    least = "name: a, check: reads, instruments: [dial], rules: sight_nureg_0700, at_least: 2"
    ((easy,), _) = found(tmp_path, least)
    assert easy.passed
    seen = f"{least}, visible: 100, eyes: both"
    ((whole,), _) = found(tmp_path, seen)
    assert whole.passed


def test_of_a_population_each_thing_is_a_requirement_of_its_own(tmp_path, height):
    points = (
        f"  high: [3000, 0, {1000 * height + 300:.1f}]\n  low: [3000, 0, {1000 * height - 300:.1f}]"
    )
    path = written(
        tmp_path,
        "name: points, check: sees, points: [high, low], at_least: 100",
        "name: dials, check: reads, instruments: [dial], rules: sight_nureg_0700",
        points=points,
        head=HEAD,
    )
    result = wb.run(load_study(path)).population
    assert [one.name for one in result.requirements] == ["see high", "see low", "read dial"]
    assert (
        result.single[:2].tolist() == [1.0, 0.0] and result.requirements[0].unit.column == "percent"
    )
    said = person_sentence(result, 0)
    assert "low is 0 % visible to" in said and ", 100 % asked: panel hides most" in said


def test_where_everybody_meets_everything_the_page_shows_who_comes_nearest_to_missing_it(
    tmp_path, height
):
    """Who comes nearest to missing anything is shown alone; of each criterion of sight the one is shown with the least margin,
    which is the margin of what is measured in its own unit."""
    path = written(
        tmp_path,
        "name: far, check: sees, points: [high, higher], at_least: 50",
        "name: dials, check: reads, instruments: [dial], rules: sight_nureg_0700, at_least: 2",
        "name: nose, check: over_nose, down: 1",
        "name: clear, check: outline, rules: sight_ac_25_773_1, side: left, at_least: 5",
        points=f"  high: [3000, 0, {1000 * height + 300:.1f}]\n  higher: [3000, 0, 3000]",
        head=HEAD,
    )
    result = wb.run(load_study(path))
    people = result.population
    assert people.served.all()
    (shown,) = people.shown
    assert people.margin[shown.row, shown.requirement] == np.nanmin(people.margin)
    of = [people.requirements[one.requirement].criterion for one in people.beheld]
    assert of == ["far", "dials", "nose", "clear"]
    for one, name in zip(people.beheld, of, strict=True):
        least = np.nanmin(people.margin[:, one.requirement])
        assert people.margin[one.row, one.requirement] == least
        unit = "share" if name == "dials" else one.finding.unit
        share = abs(one.finding.limit) if name == "dials" else 1.0
        spare = UNITS[unit].counts * one.finding.margin / share
        assert spare == pytest.approx(least, abs=1e-9), name
    wb.write_report(result, tmp_path / "out")
    text = (tmp_path / "out/report.html").read_text()
    assert text.count(", nearest to missing it: a ") == 4 + 2  # of pictures also their words
    assert f"({people.people.called(people.beheld[2].row)}), " in text


def on_side(folder, side):
    """What people see from a seat 280 mm to one side of a cockpit, past a panel: a disc farther out, by
    the outer eye; and how they read a dial on the centre line. side: 1 to the left, -1 to the right."""
    path = written(
        folder,
        f"name: disc, check: sees, points: [out], size: 300, at_least: 50, eyes: {SIDES[side]}",
        "name: dials, check: reads, instruments: [dial], rules: sight_nureg_0700",
        points="  out: [3000, 640, 700]",
        head=HEAD,
    )
    room = folder / "environments/toy/environment.yaml"
    text = re.sub(
        r"\[([-\d.]+), ([-\d.]+), ([-\d.]+)\]",
        lambda m: f"[{m[1]}, {side * (float(m[2]) + 280)}, {m[3]}]",
        room.read_text(),
    )
    room.write_text(text)
    mesh = room.with_name("toy.obj")
    text = re.sub(
        r"v (\S+) (\S+)", lambda m: f"v {m[1]} {side * (float(m[2]) + 280)}", mesh.read_text()
    )
    mesh.write_text(
        re.sub(r"f (\d+) (\d+) (\d+)", r"f \3 \2 \1" if side < 0 else r"f \1 \2 \3", text)
    )
    return wb.run(load_study(path)).population


def test_people_in_the_right_seat_see_as_those_in_the_left_of_a_mirrored_cockpit(tmp_path):
    """To the one of 25 samples of the disc that the edge of the panel may just pass."""
    left, right = (on_side(tmp_path / SIDES[side], side).margin for side in (1, -1))
    assert left[:, 1] == pytest.approx(right[:, 1], abs=1e-9) and np.ptp(left[:, 0]) > 0
    assert left[:, 0] == pytest.approx(right[:, 0], abs=0.1 / 25 + 1e-4)


def test_what_is_lacking_of_reading_is_told_in_the_unit_of_what_limits_it(tmp_path):
    path = written(
        tmp_path,
        "name: dials, check: reads, instruments: [dial], rules: sight_nureg_0700",
        head=HEAD,
    )
    result = wb.run(load_study(path))
    people = result.population
    row = int(people.margin[:, 0].argmin())
    short = 16 * -people.margin[row, 0] / 0.1
    assert (
        f"“read dial” is missed by {short:.1f} arc minutes (16.0 asked): the size of its char"
        in (person_sentence(people, row))
    )
    told = " ".join(result.warnings)
    assert (
        "nobody meets 'read dial': it is missed by at least " in told
        and "arc minutes (16.0 asked)" in told
    )
    assert (
        "criterion 'dials' is judged by NUREG-0700" in told
        and "straight ahead (0 degrees): from memory" in told
    )


@pytest.fixture(scope="module")
def low(tmp_path_factory, height):
    """Six people who are to see a point that the panel's rear upper edge hides from most."""
    path = written(
        tmp_path_factory.mktemp("low"),
        "name: points, check: sees, points: [low], at_least: 100",
        points=f"  low: [3000, 0, {1000 * height - 60:.1f}]",
        head=HEAD,
    )
    return wb.run(load_study(path)).population


def test_the_part_that_hides_is_proposed_to_go_as_far_as_lets_people_see(low, height):
    """The line from the eyes, turned to the point, passes the panel's edge so much lower."""
    needed = []
    for row in np.flatnonzero(low.margin[:, 0] < 0).tolist():
        shown = next(one for one in low.shown if one.row == row) if row in low.hardest else None
        if shown is not None:
            looks = gaze(eyes_of(shown.placed), [3.0, 0.0, height - 0.06])
            eye = looks.eyes.middle[0]
            share = (EDGE[0] - eye[0]) / (3.0 - eye[0])
            needed.append(EDGE[1] - (eye[2] + share * (height - 0.06 - eye[2])))
    gain = next(one for one in low.gains if one.words.endswith("mm down"))
    assert gain.words.startswith("moving panel ") and gain.requirement == "see low"
    assert gain.before < gain.joint_after == 1.0 and len(needed) == sum(low.margin[:, 0] < 0)
    assert max(needed) <= gain.move < max(needed) + 0.011


def test_a_change_of_the_panel_lets_people_see_what_it_hid(tmp_path, height):
    points = f"  low: [3000, 0, {1000 * height - 60:.1f}]"
    path = written(
        tmp_path,
        "name: points, check: sees, points: [low], at_least: 100",
        points=points,
        head=HEAD,
    )
    path.write_text(
        path.read_text() + "changes:\n  - {name: lower panel, parts: [panel], move: [0, 0, -90]}\n"
    )
    (gain,) = wb.run(load_study(path)).population.gains
    assert gain.requirement == "see low" and gain.before < 0.5 and gain.after == 1.0


SEES = "name: a, check: sees, at_least: 90"
READS = "name: a, check: reads, rules: sight_nureg_0700"


@pytest.mark.parametrize(
    ("criterion", "said"),
    [
        (SEES, "exactly one of parts, controls, instruments, points, got none"),
        (f"{SEES}, parts: [pan], points: [eye]", "got parts and points"),
        (f"{SEES}, parts: [nose]", "nothing is called 'nose'"),
        (f"{SEES}, points: [moon]", "nothing is called 'moon'"),
        (f"{SEES}, parts: [pan], size: 5", "'size' is the diameter of what is at 'points'"),
        (f"{SEES}, parts: [pan], eyes: third", "eyes"),
        ("name: a, check: sees, parts: [pan], at_least: 101", "0 to 100 percent"),
        ("name: a, check: sees, parts: [pan]", "check: sees needs 'at_least'"),
        ("name: a, check: reads, instruments: [dial]", "check: reads needs 'rules'"),
        (f"{READS}, instruments: [blank]", "'blank' of environment toy has no height of its char"),
        (f"{READS}, instruments: [altimeter]", "nothing is called 'altimeter'"),
        ("name: a, check: reads, instruments: [dial], rules: fmvss_208", "has no 'values'"),
    ],
)
def test_wrong_keys_are_told(tmp_path, criterion, said):
    with pytest.raises(wb.InputError, match=said):
        load_study(written(tmp_path, criterion))
