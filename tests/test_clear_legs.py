"""Legs of sitters heed what stands around: one that is in a part takes a clear posture if it has one."""

from __future__ import annotations

import re
import sys

import numpy as np
import pytest

import workbench as wb
from tests.conftest import BOX, BOX_FACES, box_part, environment_of
from tests.leg_oracle import SPARE, leg_overlap, legs_of_grid
from workbench.posture.seating.clear_legs import clear_legs
from workbench.report.sentences import finding_sentence

ENVIRONMENT = """
environment: knees
length: mm
accepted: ["floor of seat *"]
meshes: [{file: knees.obj, length: mm, up: z, forward: x}]
parts:
  pan: {allow: [{segments: [all], depth: 200}]}
  back: {allow: [{segments: [all], depth: 200}]}
seats:
  pilot:
    srp: [0, 0, 300]
    back_angle: 12
    cushion_angle: 6
    yaw: 0
    cushion: {part: pan, segments: [LT], depth: 20}
    back: {part: back, segments: [LT, UT], depth: 20}
    travel: {forward: [0, 0], up: [0, 0]}
    moves: [pan, back]
points:
  heel: [900, 0, 0]
controls:
  left_pedal: {at: [970, 150, 120], grip: foot, zone: 1, part: far}
  right_pedal: {at: [970, -150, 120], grip: foot, zone: 1, part: far}
"""
STUDY = """
study: knees
length: mm
environment: knees
people: {pilot: {body: adult_male, detail: coarse, seat: pilot}}
cases:
  - name: sitting
    people:
      pilot: {predicted: {heels: heel, feet: {left: left_pedal, right: right_pedal}}}
criteria:
  - {name: pedals, check: pedals}
  - {name: reach, check: reach, controls: [left_pedal, right_pedal]}
"""
BOXES = {
    "pan": ([-50, -250, 200], [300, 250, 300]),
    "back": ([-100, -250, 300], [-50, 250, 900]),
    "far": ([1500, -300, 600], [1520, 300, 900]),
}
FEET = ("left foot", "right foot")
ASIDE = np.array([1.0, -1.0, 1.0])


def sat(folder, post=None, *, environment=None, study=STUDY, more=None):
    """A run in which a man sits with his feet on pedals, a box [mm] named post in his way or none, and
    more boxes by their names."""
    place = folder / "environments" / "knees"
    place.mkdir(parents=True, exist_ok=True)
    boxes = BOXES | ({} if post is None else {"post": post}) | (more or {})
    lines = []
    for k, (name, (low, high)) in enumerate(boxes.items()):
        corners = np.asarray(low) + BOX * (np.asarray(high) - low)
        lines += [f"o {name}", *(f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in corners.tolist())]
        lines += [f"f {a} {b} {c}" for a, b, c in (BOX_FACES + 8 * k + 1).tolist()]
    (place / "knees.obj").write_text("\n".join(lines) + "\n")
    (place / "environment.yaml").write_text(ENVIRONMENT if environment is None else environment)
    (folder / "studies").mkdir(exist_ok=True)
    file = folder / "studies" / "knees.yaml"
    file.write_text(study)
    result = wb.run(wb.load_study(file))
    return result.postures[0], result.postures[0].people[0]


def at(person, name):
    """Centre [m] and radius of a named sphere."""
    placed = person.placed
    sphere = list(placed.body.subparts).index(name)
    return placed.centres[0, sphere], float(placed.body.radius[0, sphere])


def one_answer(result):
    """[m] How far the worse foot stays short of its pedal, which pedals and reach tell alike."""
    pedals, reach = (verdict.worst for verdict in result.verdicts)
    assert [verdict.passed for verdict in result.verdicts] == [pedals.value >= -1e-3] * 2
    assert min(pedals.value, 0.0) == pytest.approx(min(reach.value, 0.0), abs=1e-3)
    return -pedals.value


def deepest_in_post(result, person):
    room = wb.clearance(person.placed, result.environment)[0]
    return -room[:, result.environment.part_index("post")].min()


def post_beside(knee, beside):
    """A post [mm] whose face is so far [m] to the left of the middle of a knee cap, to the right where
    negative."""
    face = knee[1] + beside
    y = sorted([face, face + np.copysign(0.06, beside)])
    low = [knee[0] + 0.02, y[0], knee[2] - 0.2]
    high = [knee[0] + 0.1, y[1], knee[2] + 0.05]
    return (1e3 * np.array(low)).tolist(), (1e3 * np.array(high)).tolist()


def ball_of(person, foot):
    """The point [m] of a foot that is on its pedal."""
    placed = person.placed
    tip = wb.limb(placed.body, foot, grip="ball").tip[0]
    world = placed.world_from_segment[0, placed.body.segment(foot[0].upper() + "F")]
    return world[:, :3] @ tip + world[:, 3]


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    return sat(tmp_path_factory.mktemp("alone"))


@pytest.fixture(scope="module")
def narrow(tmp_path_factory):
    """The same with the pedals 150 mm from one another."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            sys.modules[__name__], "ENVIRONMENT", ENVIRONMENT.replace("150, 120", "75, 120")
        )
        return sat(tmp_path_factory.mktemp("narrow"))


def in_other(poses, body):
    """(P,) [m] How deep the legs are in one another, beyond what is allowed; 0 where they are not."""
    found = wb.self_contacts(wb.place(body, poses))
    legs = [body.segment(side + name) for side in "LR" for name in ("UL", "LL", "F")]
    both = np.isin(found.segment, legs) & np.isin(found.other_segment, legs)
    deepest = np.zeros(len(poses))
    np.maximum.at(deepest, found.pose[both], found.excess[both])
    return deepest


def test_a_leg_leaves_a_box_for_no_place_in_the_other_leg(narrow):
    body, poses = narrow[1].placed.body, narrow[1].poses
    for low, high, clear in (
        ((0.553, 0.103, 0.304), (0.599, 0.215, 0.324), True),
        ((0.588, 0.085, 0.128), (0.670, 0.159, 0.246), False),
        ((0.240, 0.151, 0.382), (0.360, 0.196, 0.412), False),
    ):
        room = environment_of(box_part("box", low, high))
        before = leg_overlap(body, poses, "left foot", room)[0]
        found = clear_legs(body, poses, room, {"left foot": None})
        assert before > 0.0 and in_other(found.poses, body) == 0.0
        assert (found.overlap["left foot"][0] == 0.0) == clear
        if not clear:
            assert found.overlap["left foot"][0] == pytest.approx(before, abs=1e-6)
            np.testing.assert_array_equal(found.poses.rotations, poses.rotations)


@pytest.mark.parametrize("beside", [0.002, -0.06])
def test_a_leg_leaves_a_post_beside_its_knee_and_stays_on_its_pedal(tmp_path, alone, beside):
    knee, _ = at(alone[1], "RLL/knee cap")
    result, person = sat(tmp_path, post_beside(knee, beside))
    assert deepest_in_post(result, person) <= 0.0
    aside = at(person, "RLL/knee cap")[0][1] - knee[1]
    assert -np.sign(beside) * aside > 0.02
    stays = ball_of(alone[1], "right foot")
    np.testing.assert_allclose(ball_of(person, "right foot"), stays, atol=2e-4)
    heel, before = (at(one, "RF/heel")[0] for one in (person, alone[1]))
    assert -0.005 < heel[2] - before[2] < 0.026
    assert person.margin[0].min() >= -1e-3
    assert not any("leg is" in line for line in result.warnings)
    assert one_answer(result) == pytest.approx(0.0, abs=1e-3)
    np.testing.assert_array_equal(at(person, "LLL/knee cap")[0], at(alone[1], "LLL/knee cap")[0])


def test_a_mirrored_post_is_left_by_the_mirrored_leg(tmp_path, alone):
    knee, _ = at(alone[1], "RLL/knee cap")
    one = sat(tmp_path / "right", post_beside(knee, 0.002))[1]
    other = sat(tmp_path / "left", post_beside(knee * ASIDE, -0.002))[1]
    for name in ("knee cap", "calf"):
        moved = at(one, f"RLL/{name}")[0]
        assert np.linalg.norm(moved - at(alone[1], f"RLL/{name}")[0]) > 0.01
        np.testing.assert_allclose(at(other, f"LLL/{name}")[0] * ASIDE, moved, atol=1e-3)


def test_two_legs_between_boxes_are_not_brought_into_one_another_whichever_is_first(narrow):
    body, poses = narrow[1].placed.body, narrow[1].poses
    low, high = np.array([0.489, 0.116, 0.328]), np.array([0.516, 0.186, 0.401])
    left = box_part("left", low, high)
    right = box_part("right", (low[0], -high[1], low[2]), (high[0], -low[1], high[2]))
    room = environment_of(left, right)
    for foot in FEET:
        assert clear_legs(body, poses, room, {foot: None}).overlap[foot][0] == 0.0
    for feet in (FEET, FEET[::-1]):
        found = clear_legs(body, poses, room, dict.fromkeys(feet))
        assert in_other(found.poses, body)[0] == 0.0
        assert min(found.overlap[foot][0] for foot in FEET) > 0.04


def test_what_no_posture_of_the_legs_avoids_is_said(tmp_path, alone):
    shin = at(alone[1], "RLL/calf")[0]
    wall = [1e3 * shin[0] - 20.0, -400.0, 20.0], [1e3 * shin[0] + 20.0, 400.0, 1e3 * shin[2] + 60.0]
    result, person = sat(tmp_path, wall)
    assert deepest_in_post(result, person) > 0.02
    for side in ("left", "right"):
        words = rf"the {side} leg is \d+ mm deeper in post than is allowed"
        assert any(re.search(words, line) for line in result.warnings)
    assert one_answer(result) > 0.02
    for verdict in result.verdicts:
        words = finding_sentence(verdict.criterion.check, verdict.worst)
        assert re.search(
            r"the \w+ foot stays [\d.]+ mm short of .*; on it the leg is that much too deep in post",
            words,
        )
    np.testing.assert_array_equal(person.poses.rotations, alone[1].poses.rotations)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["alone", "narrow"])
def test_no_posture_of_a_grid_is_clear_where_the_search_found_none(request, name):
    """Boxes of all sizes at random places of the legs: of 200 legs in one, at most 2 are left in it
    although a posture of the grid is clear of it and of the other leg."""
    sitter = request.getfixturevalue(name)[1]
    body, poses, placed = sitter.placed.body, sitter.poses, sitter.placed
    rng = np.random.default_rng(4)
    pitches = np.radians([0.0, -3.0, -6.0])
    grids = {foot: legs_of_grid(body, poses, foot, pitches) for foot in FEET}
    asked = missed = clear = 0
    while asked < 200:
        foot = FEET[int(rng.integers(2))]
        of = [body.segment(foot[0].upper() + name) for name in ("UL", "LL", "LL", "LL")]
        sphere = rng.choice(np.flatnonzero(body.sphere_segment == rng.choice(of)))
        way = rng.normal(size=3) * [1.0, 1.5, 0.7]
        way /= np.linalg.norm(way)
        size = rng.uniform(0.02, 0.15, 3)
        middle = placed.centres[0, sphere] + way * (body.radius[0, sphere] - rng.uniform(0.0, 0.05))
        middle += 0.5 * size * way / np.abs(way).max()
        room = environment_of(box_part("box", middle - 0.5 * size, middle + 0.5 * size))
        if leg_overlap(body, poses, foot, room)[0] <= 0.0:
            continue
        asked += 1
        found = clear_legs(body, poses, room, {foot: None})
        deep = leg_overlap(body, found.poses, foot, room)[0]
        assert (deep <= 0.0) == (found.overlap[foot][0] == 0.0)
        assert in_other(found.poses, body)[0] == 0.0
        clear += deep <= 0.0
        if deep > 0.0:
            free = np.flatnonzero(leg_overlap(body, grids[foot], foot, room) < -SPARE)
            missed += len(free) > 0 and in_other(grids[foot].rows(free), body).min() == 0.0
    assert missed <= 2 and clear > 80
