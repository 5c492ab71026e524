"""Feet that are through the floor, above it or over none are told in millimetres, with what would
mend it."""

from __future__ import annotations

import json
import math

import pytest

import workbench as wb
from tests.made_seat import corners, obj_text
from workbench.cli import main
from workbench.files.environment_schema import EnvironmentFile
from workbench.files.schema import validate
from workbench.files.yaml_text import parse_yaml
from workbench.geometry.ground import ground_of
from workbench.study.describe.people import seated_person, seated_words
from workbench.study.feet_on_floor import feet_on_floor

CAB = """environment: cab
length: m
meshes: [{{file: cab.obj, length: m, up: z, forward: x}}]
seats:
  left:
    srp: [0, 0, 0.45]
    back_angle: 10
    cushion_angle: 5
    cushion: {{part: pan, segments: [LT, LUL, RUL], depth: 0.02}}
    back: {{part: back, segments: [LT, CT, UT], depth: 0.02}}
parts:
  pan: {{allow: [{{segments: [LT, LUL, RUL], depth: 0.2}}]}}
controls: {controls}
"""
STUDY = """study: sit
length: mm
environment: ./environment.yaml
people: {driver: {body: adult_male, seat: left}}
cases: [{name: at rest, people: {driver: {posture: hands_in_lap}}}]
criteria: [{name: clear, check: contact}]
"""


def cab(folder, floor, *, controls="{}", more=None):
    """A cab whose floor is at a height [m], None for none, and more parts; its environment and its
    file."""
    parts = {
        "pan": corners((-0.1, -0.25, 0.3), (0.4, 0.25, 0.43)),
        "back": corners((-0.4, -0.25, 0.43), (-0.15, 0.25, 1.0)),
    }
    if floor is not None:
        parts["floor"] = corners((-1.0, -1.0, floor - 0.1), (2.0, 1.0, floor))
    (folder / "cab.obj").write_text(obj_text(parts | (more or {})))
    text = CAB.format(controls=controls)
    (folder / "environment.yaml").write_text(text)
    file = validate(parse_yaml(text, "environment.yaml"), EnvironmentFile)
    return wb.load_environment(folder), file


@pytest.fixture(scope="module")
def sole(tmp_path_factory):
    """The height [m] of the soles of who sits in the cab."""
    _, file = cab(tmp_path_factory.mktemp("cab"), 0.0)
    placed = seated_person(file, "left")
    body = placed.body
    feet = [body.spheres(body.segment(foot)) for foot in ("LF", "RF")]
    return min(float((placed.centres[0, own, 2] - body.radius[0, own]).min()) for own in feet)


def told(folder, floor, **more):
    environment, file = cab(folder, floor, **more)
    return seated_words(file, "left", ground_of(environment))


def words(folder, floor, **more):
    return [*told(folder, floor, **more).doubts]


def test_feet_on_the_floor_are_nothing_to_say(tmp_path, sole):
    assert words(tmp_path, sole + 0.001) == []


def test_feet_under_the_floor_are_told_with_the_seat_that_is_high_enough(tmp_path, sole):
    (said,) = words(tmp_path, sole + 0.1)
    needed = 1e3 * (0.45 - sole)
    assert said.startswith(
        f"left: adult male, hands in the lap: the feet are 100 mm under 'floor': with these knees "
        f"the seat reference point must be {needed:.0f} mm above it, and it is {needed - 100:.0f} "
        f"mm. A seat 100 mm higher would mend it, or feet "
    )
    assert said.endswith("no control is for feet: are pedals missing?")


@pytest.mark.parametrize(
    ("at", "notes"),
    [((0.8, 0.1), 1), ((0.8, -0.4), 1), ((0.2, 0.1), 0), ((0.8, 0.5), 0), ((-0.8, 0.1), 0)],
)
def test_feet_under_the_floor_are_a_doubt_unless_pedals_are_farther_ahead(
    tmp_path, sole, at, notes
):
    """Feet at rest are 0.5 m ahead; 0.5 m aside is another seat's pedal."""
    pedal = f"{{brake: {{at: [{at[0]}, {at[1]}, 0.2], grip: foot, zone: 1}}}}"
    found = told(tmp_path, sole + 0.1, controls=pedal)
    assert (len(found.doubts), len(found.notes)) == (1 - notes, notes)
    if notes:
        assert found.notes[0].endswith(
            "at rest the feet would be 100 mm under 'floor'; brake is farther ahead, and a study puts "
            "the feet there"
        )


def test_feet_that_hang_and_feet_over_nothing_are_told(tmp_path, sole):
    (said,) = words(tmp_path, sole - 0.15)
    assert "the feet hang 150 mm above 'floor'" in said and "150 mm lower, or a footrest" in said
    assert words(tmp_path, None) == [
        "left: adult male, hands in the lap: there is no floor under the feet: is it left out or "
        "hidden, or is the seat in another place?"
    ]


def test_the_lower_leg_reaches_the_floor_farther_ahead_by_pythagoras(tmp_path, sole):
    environment, file = cab(tmp_path, sole + 0.1)
    placed = seated_person(file, "left")
    feet = feet_on_floor(placed, 0, environment.seat("left"), ground_of(environment))
    legs = [placed.body.spheres(placed.body.segment(leg)) for leg in ("LLL", "RLL")]
    knee = max(float(placed.centres[0, leg, 2].max()) for leg in legs)
    leg = knee - sole
    assert feet.above == pytest.approx(-0.1, abs=2e-3)
    assert feet.ahead == pytest.approx(math.sqrt(leg**2 - (leg - 0.1) ** 2), rel=0.03)


def test_a_run_says_that_feet_are_through_the_floor(tmp_path, sole, capsys):
    cab(tmp_path, sole + 0.1)
    mesh = tmp_path / "cab.obj"
    mesh.write_text(mesh.read_text() + mesh.read_text().splitlines()[-1] + "\n")  # a face twice
    assert any("duplicate face" in line for line in wb.load_environment(tmp_path).warnings)
    (tmp_path / "sit.yaml").write_text(STUDY)
    main(["run", str(tmp_path / "sit.yaml"), "--out", str(tmp_path / "out"), "--json"])
    told = json.loads(capsys.readouterr().out)["warnings"]
    (said,) = [line for line in told if "under 'floor'" in line]
    assert not [line for line in told if "duplicate face" in line]  # no figure depends on it
    assert said.startswith("driver, at rest: the feet are 1") and "mm higher would mend it" in said


@pytest.mark.parametrize(("rear", "under"), [(0.64, False), (0.2, True)])
def test_a_shelf_over_the_feet_is_no_floor_and_one_that_shins_go_through_is(
    tmp_path, sole, rear, under
):
    """Shins are 0.6 m ahead of the seat reference point at most there, toes 0.8 m."""
    shelf = corners((rear, -0.5, sole + 0.18), (1.0, 0.5, sole + 0.2))
    told = words(tmp_path, sole, more={"shelf": shelf})
    assert bool(told) == under, told
    assert not told or "the feet are 200 mm under 'shelf'" in told[0]


def test_a_seat_that_is_not_where_its_cushion_is_comes_first_and_its_feet_are_not_explained(
    tmp_path, capsys
):
    cab(tmp_path, 0.0)
    file = tmp_path / "environment.yaml"
    file.write_text(file.read_text().replace("srp: [0, 0, 0.45]", "srp: [-0.2, 0, 0.1]"))
    (tmp_path / "sit.yaml").write_text(STUDY)
    main(["run", str(tmp_path / "sit.yaml"), "--out", str(tmp_path / "out"), "--json"])
    rows = json.loads(capsys.readouterr().out)
    lost = "eat 'left': its reference point is 324 mm below its cushion 'pan' and 107 mm behind"
    assert rows["warnings"][0].startswith(f"s{lost}")
    assert "; at (-150, 0, 430) mm it would be" in rows["warnings"][0]  # the edge of pan and back
    assert not [one for one in rows["warnings"] if "the feet" in one or "check the seat" in one]
    said = rows["headline"]
    assert said.startswith(f"S{lost}") and "Mend this first" in said
    assert "tightest gap" not in said


@pytest.mark.parametrize(
    "asked, told",
    [
        ("segments: [LUL, LLL], parts: [pan, floor]", True),
        ("segments: [LLL], parts: [pan]", False),
        ("segments: [LUL], parts: [floor]", False),
        ("subparts: [LLL/knee cap], parts: [pan]", False),
    ],
)
def test_room_for_thighs_to_what_they_lie_on_is_told_to_say_nothing_of_knees(tmp_path, asked, told):
    cab(tmp_path, 0.0)
    rule = f"{{name: knee room, check: clearance, {asked}, at_least: 30}}"
    text = STUDY.replace("{name: clear, check: contact}", rule)
    (tmp_path / "sit.yaml").write_text(text)
    said = [line for line in wb.load_study(tmp_path / "sit.yaml").warnings if "thighs" in line]
    assert bool(said) == told
    assert not told or "lie over 'pan', so that 30 mm from it say nothing" in said[0]
