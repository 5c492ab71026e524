"""Sight at the bench: what people see while something is dragged, and where they look."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import workbench as wb
from tests.conftest import ROOT
from workbench.live.protocol import parsed, unpacked
from workbench.model.surroundings import displaced
from workbench.model.units import UNITS
from workbench.sight.eyes import TURNS, eyes_of, gaze
from workbench.sight.obscuration import obscuration
from workbench.sight.regions import cone
from workbench.sight.scenery import scenery_of

pytest.importorskip("starlette", reason="the extra `live` is not installed")
pytest.importorskip("uvicorn", reason="the extra `live` is not installed")

from workbench.live.desk import Desk

SIGHT = """
  - {name: over the nose, check: over_nose, down: 14}
  - {name: panel seen, check: sees, instruments: [tachometer, altimeter], at_least: 80}
  - {name: throttle seen, check: sees, controls: [throttle], at_least: 50}
  - {name: outline, check: outline, rules: sight_ac_25_773_1, side: left, people: [pilot], at_least: 80}
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("sight") / "two_see.yaml"
    path.write_text((ROOT / "tests" / "data" / "two_men.yaml").read_text().rstrip() + SIGHT)
    return path


@pytest.fixture
def desk(study):
    found = Desk(str(study))
    found.state()
    return found


def asked(desk, text):
    """The replies of a desk to a question."""
    return desk.do(parsed(text))


def sights(desk):
    """The rows of what is seen now, by the names of their criteria."""
    heads = [unpacked(frame)[0] for frame in desk.judgement().sights()]
    assert all(head["generation"] == desk.generation for head in heads)
    return {head["row"]["name"]: head["row"] for head in heads}


RAISED = '{"do": "move", "parts": ["coaming"], "by": [0, 0, 0.08], "done": %s}'


def test_what_is_seen_while_the_coaming_is_dragged_is_what_a_run_of_the_saved_study_finds(
    desk, study
):
    before = study.read_text()
    seen = sights(desk)
    assert seen["over the nose"]["passed"]
    assert not any(row["words"].endswith((" ", "–")) for row in seen.values())
    asked(desk, RAISED % "false")
    rows = []
    for case in desk.opened.cases:
        asked(desk, json.dumps({"do": "case", "name": case}))
        rows.append(sights(desk))
    asked(desk, RAISED % "true")
    asked(desk, '{"do": "save"}')
    run = wb.run(wb.load_study(study))
    study.write_text(before)
    found = {one.criterion.name: one for one in run.verdicts if one.criterion.name in rows[0]}
    assert len(found) == 4 and found["over the nose"].worst.target == "coaming"
    for name, verdict in found.items():
        worst = min((row[name] for row in rows), key=lambda row: row["margin"])
        unit = UNITS[verdict.worst.unit]
        assert worst["now"] and worst["passed"] == verdict.passed
        assert worst["margin"] == pytest.approx(unit.scale * verdict.worst.margin, abs=1e-9)
    assert "coaming" in rows[0]["over the nose"]["words"] + rows[1]["over the nose"]["words"]


def shown(desk):
    """Where the people are."""
    desk.state()
    return desk.shown.placement


def field(desk, toward, **more):
    """What hides the pilot's field, and the arrays of its pictures."""
    work = asked(
        desk, json.dumps({"do": "field", "person": "pilot", "toward": toward, **more})
    ).work
    (frame,) = work.made().frames
    head, arrays = unpacked(frame)
    return head, arrays


def head_turn(eyes, looks):
    """The turn of the head in the world, as a rotation vector [rad]."""
    (left, up) = looks.head_turn[0]
    return left * eyes.axes[0, 2] - up * eyes.axes[0, 1]


def posed_anew(placed, poses, name, turn):
    """Poses with a segment turned about its joint by a rotation vector in the world, the pelvis still."""
    body, world = placed.body, placed.world_from_segment[0]
    segment = body.segments.index(name)
    seen = Rotation.from_matrix(world[body.parent[segment], :, :3]).inv()
    joint = seen * Rotation.from_rotvec(turn) * Rotation.from_matrix(world[segment, :, :3])
    given = dict(zip(body.joints, poses.rotations[0], strict=True))
    given[body.joints[segment - 1]] = np.roll(joint.as_quat(), 1)
    return wb.pose(body, {}, rotations=given, position=world[0, :, 3], attitude=world[0, :, :3])


TOWARD = (math.cos(0.6), math.sin(0.6), -0.1)


def test_the_field_is_what_the_turned_eyes_meet_in_the_place_as_it_is_dragged(desk):
    asked(desk, RAISED % "false")
    head, arrays = field(desk, TOWARD)
    pilot, instructor = (one.placed for one in shown(desk).people)
    environment = displaced(desk.opened.study.environment, desk.live.moves)
    eyes = eyes_of(pilot)
    target = eyes.middle + 1000.0 * np.array(TOWARD)
    looks = gaze(eyes, target)
    poses = posed_anew(pilot, shown(desk).people[0].poses, "H", head_turn(eyes, looks))
    turned = wb.place(pilot.body, poses)
    scenery = scenery_of(environment, turned, {"instructor": instructor})
    region = cone("field", TOWARD, math.radians(60))
    found = obscuration(
        scenery, gaze(eyes_of(turned), target).eyes, within=region, step=math.radians(0.5)
    )
    share = 100 / region.solid_angle
    assert head["free"] == pytest.approx(share * found.free, abs=0.006)
    for row in head["rows"]:
        k = found.names.index(
            row["name"].replace(" ", "_") if "own" not in row["name"] else row["name"]
        )
        hides = [found.left[k], found.right[k], found.either[k], found.both[k]]
        assert row["shares"] == pytest.approx(share * np.array(hides), abs=0.006)
    assert head["at"] == pytest.approx(looks.eyes.middle[0], abs=1e-5)
    picture = arrays["picture"]
    assert picture.shape == (3 * head["size"] ** 2,) and len(np.unique(picture)) > 10


def test_eyes_turn_first_then_the_head_and_what_is_beyond_both_is_told(desk):
    eyes = eyes_of(shown(desk).people[0].placed)
    ahead, left = eyes.axes[0, 0], eyes.axes[0, 1]
    level = math.cos(TURNS.line_down) * ahead - math.sin(TURNS.line_down) * eyes.axes[0, 2]
    near, _ = field(desk, (math.cos(0.2) * level + math.sin(0.2) * left).tolist())
    assert near["head"] == [0, 0] and near["eyes"] == pytest.approx([math.degrees(0.2), 0], abs=0.1)
    far, _ = field(desk, (math.cos(0.7) * level + math.sin(0.7) * left).tolist())
    assert math.hypot(*far["head"]) > 20 and far["eyes"][0] == pytest.approx(15, abs=0.1)
    behind, _ = field(desk, (0.1 * left - level).tolist())
    assert behind["lack"] > 30 and near["lack"] == far["lack"] == 0


def test_a_helmet_turns_with_the_head_and_the_arms_with_the_trunk_as_in_a_study_that_sits_so(study):
    text = study.read_text().replace("pilot: {body", "pilot: {clothes: [helmet], body", 1)
    wide = study.with_name("wide.yaml")
    wide.write_text(text.replace("controls: [throttle],", "controls: [throttle], trunk: 30,"))
    desk = Desk(str(wide))
    pilot = shown(desk).people[0]
    body, eyes = pilot.body, eyes_of(pilot.placed)
    toward = np.array([math.cos(2.2), math.sin(2.2), -0.1])
    head, arrays = field(desk, toward.tolist(), within=90)
    target = eyes.middle + 1000.0 * toward / np.linalg.norm(toward)
    trunk = gaze(eyes, target, trunk=math.radians(30)).trunk_turn[0]
    assert trunk == pytest.approx(math.radians(30)) and head["trunk"] == 30
    half = posed_anew(pilot.placed, pilot.poses, "UT", trunk * eyes.axes[0, 2])
    between = wb.place(body, half)
    looks = gaze(eyes_of(between), target)
    whole = posed_anew(between, half, "H", head_turn(eyes_of(between), looks))
    turned = wb.place(body, whole)
    assert head["head"] == pytest.approx(np.degrees(looks.head_turn[0]), abs=0.06)
    # the picture shows the body so: arms and helmet stand elsewhere than at rest
    assert arrays["centres"] == pytest.approx(turned.centres[0].ravel(), abs=1e-5)
    assert np.abs(turned.centres - pilot.placed.centres).max() > 0.3
    other = shown(desk).people[1].placed
    scenery = scenery_of(desk.opened.study.environment, turned, {"instructor": other})
    at = np.array(head["at"])
    assert at == pytest.approx(eyes_of(turned).middle[0], abs=1e-5)
    hidden = obscuration(
        scenery,
        eyes_of(turned),
        within=cone("field", toward, math.radians(90)),
        step=math.radians(0.5),
    )
    share = 100 / hidden.region.solid_angle
    own = [row for row in head["rows"] if row["name"].startswith("own ")]
    assert "own helmet" in [row["name"] for row in own]
    for row in own:
        k = hidden.names.index(row["name"])
        assert row["shares"][2] == pytest.approx(share * hidden.either[k], abs=0.006)


def test_the_field_is_refused_in_words_where_an_eye_is_inside_a_part_or_nobody_is_there(desk):
    eye = eyes_of(shown(desk).people[0].placed).left[0]
    environment = desk.opened.study.environment
    middle = environment.triangle_corners(environment.part_index("centre_console")).mean(
        axis=(0, 1)
    )
    by = (eye - middle).tolist()
    asked(desk, json.dumps({"do": "move", "parts": ["coaming"], "by": [0, 0, 0.01]}))
    head, arrays = field(desk, TOWARD)
    assert not head["words"] and arrays
    asked(desk, json.dumps({"do": "move", "parts": ["centre_console"], "by": by}))
    head, arrays = field(desk, TOWARD)
    assert "is inside 'centre_console', so it sees nothing" in head["words"] and not arrays
    head, _ = field(desk, [0, 0, 0])
    assert head["words"].startswith("a direction to look in")
    replies = desk.do(parsed('{"do": "field", "person": "nobody", "toward": [1, 0, 0]}'))
    assert "nobody is called 'nobody'" in unpacked(replies.asker[0])[0]["words"]
