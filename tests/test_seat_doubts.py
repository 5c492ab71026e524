"""What is odd about a seat is said in millimetres: cushion and back of two seats, no floor, two in
one place."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.made_seat import BOX, SRP, corners, obj_text, seat_parts
from workbench import load_environment
from workbench.cli import main
from workbench.errors import InputError
from workbench.files.seat_doubts import floor_before, rest_doubts
from workbench.geometry.ground import ground_of
from workbench.model.environment import Rest, Seat
from workbench.study.describe.edits_seats import faced
from workbench.study.describe.meshes import Ray
from workbench.study.describe.state import open_place

PARTS = {
    "left_pan": corners((0.0, 0.1, 0.3), (0.5, 0.6, 0.4)),
    "left_back": corners((-0.1, 0.1, 0.4), (0.0, 0.6, 1.0)),
    "right_pan": corners((0.0, -0.6, 0.3), (0.5, -0.1, 0.4)),
    "right_back": corners((-0.1, -0.6, 0.4), (0.0, -0.1, 1.0)),
    "floor": corners((-1.0, -1.0, -0.1), (2.0, 1.0, 0.0)),
    "wall": corners((1.9, -1.0, 0.0), (2.0, 1.0, 1.5)),
}
SEAT = """  {name}:
    srp: [0, {y}, {z}]
    back_angle: {back_angle}
    cushion_angle: 0
    cushion: {{part: {cushion}, segments: [LT], depth: 0.02}}
    back: {{part: {back}, segments: [LT], depth: 0.02}}
"""
LEFT = {
    "name": "left",
    "y": 0.35,
    "z": 0.4,
    "back_angle": 0,
    "cushion": "left_pan",
    "back": "left_back",
}


def cab(folder, *seats, without=(), more=""):
    """The warnings of a cab with some seats, and its folder."""
    parts = {name: points for name, points in PARTS.items() if name not in without}
    (folder / "cab.obj").write_text(obj_text(parts))
    head = "environment: cab\nlength: m\nmeshes: [{file: cab.obj, length: m, up: z, forward: x}]\n"
    rows = "".join(SEAT.format(**{**LEFT, **seat}) for seat in seats)
    (folder / "environment.yaml").write_text(f"{head}{more}seats:\n{rows}")
    return load_environment(folder).warnings


def test_a_seat_whose_cushion_back_and_floor_go_together_is_not_doubted(tmp_path):
    right = {"name": "right", "y": -0.35, "cushion": "right_pan", "back": "right_back"}
    assert cab(tmp_path, {}, right) == ()


def test_a_cushion_and_the_back_of_the_next_seat_are_told_with_how_far_it_is_aside(tmp_path):
    (said,) = cab(tmp_path, {"back": "right_back"})
    assert said == (
        "seat 'left': its back 'right_back' lies 700 mm to the right of its middle, and nothing is "
        "behind the sitter: is it that of another seat? [back of seat left]"
    )
    assert cab(tmp_path, {"back": "right_back"}, more='accepted: ["back of seat *"]\n') == ()


def test_cushion_and_back_that_hold_less_than_half_of_a_sitter_are_told_with_the_width(tmp_path):
    said = cab(tmp_path, {"y": 0.05})
    words = "lies 300 mm to the left of its middle, and 150 of the 400 mm of a sitter have it"
    assert [f"{words} under" in said[0], f"{words} behind" in said[1]] == [True, True]


def test_a_seat_away_from_the_planes_of_its_parts_and_one_that_opens_too_far_are_told(tmp_path):
    said = cab(tmp_path, {"z": 0.55, "back_angle": 80})
    assert any(
        "its reference point is 150 mm above its cushion 'left_pan'" in line for line in said
    )
    assert any("cushion and back open by 170 degrees" in line for line in said)


def test_a_seat_without_a_floor_and_one_too_high_over_it_are_told(tmp_path, monkeypatch):
    (said,) = cab(tmp_path, {}, without=("floor",))
    assert "there is no floor before it, 600 to 900 mm ahead" in said
    monkeypatch.setitem(PARTS, "floor", corners((-1.0, -1.0, -0.7), (2.0, 1.0, -0.6)))
    (said,) = cab(tmp_path, {})
    assert "1000 mm above 'floor', the floor before it" in said


def test_two_seats_in_one_place_are_told(tmp_path):
    (said,) = cab(tmp_path, {}, {"name": "left_too", "y": 0.45})
    assert said.startswith("seats 'left' and 'left_too' are 100 mm apart: people in both are in")


def test_the_floor_before_a_seat_is_the_highest_surface_below_it(tmp_path):
    cab(tmp_path, {})
    environment = load_environment(tmp_path)
    floor = floor_before(environment.seat("left"), ground_of(environment))
    assert (floor.height, floor.part) == (0.0, "floor")


def test_check_and_inspect_tell_the_doubts_about_seats(tmp_path, capsys):
    cab(tmp_path, {"back": "right_back"})
    for command in ("check", "inspect"):
        assert main([command, str(tmp_path)]) == 0
        told = capsys.readouterr()
        assert "700 mm to the right of its middle" in told.out + told.err


def test_pointing_at_the_back_of_another_seat_is_refused_and_at_its_own_taken(tmp_path):
    (tmp_path / "cab.obj").write_text(obj_text(PARTS))
    opened = open_place(tmp_path / "cab.obj")
    down, aft = (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0)
    start = opened.start
    (mesh,) = start.says["meshes"]
    assert (mesh["length"], mesh["up"], mesh["forward"]) == ("m", "z", "x")
    one = faced(opened, start, "left", "cushion", Ray("left_pan", (0.2, 0.35, 3.0), down, 0.0))
    with pytest.raises(InputError, match="700 mm to the right of its middle"):
        faced(opened, one.description, "left", "back", Ray("right_back", (3, -0.35, 0.8), aft, 0))
    both = faced(opened, one.description, "left", "back", Ray("left_back", (3, 0.35, 0.8), aft, 0))
    assert both.description.says["seats"]["left"]["srp"] == [0, 350, 400]
    assert np.allclose(both.description.file.seats["left"].back_angle, 0.0)


@settings(max_examples=30)
@given(dx=st.floats(-0.12, 0.12), dz=st.floats(-0.12, 0.12), one_part=st.booleans())
def test_a_seat_is_doubted_where_its_planes_are_60_mm_off_its_faces(dx, dz, one_part):
    pan, rest = (seat_parts(10.0, 20.0)[name][np.array(BOX)] for name in ("pan", "rest"))
    faces = (np.concatenate([pan, rest]),) * 2 if one_part else (pan, rest)
    names = ("seat", "seat") if one_part else ("pan", "rest")
    surfaces = (Rest(name, (), 0.0) for name in names)
    srp = (SRP[0] + dx, SRP[1], SRP[2] + dz)
    angles = (np.radians(20.0), np.radians(10.0), 0.0)
    seat = Seat("driver", srp, *angles, *surfaces, (0.0, 0.0), (0.0, 0.0), ())
    c, s = np.cos(np.radians([10.0, 20.0])), np.sin(np.radians([10.0, 20.0]))
    off = np.abs([-s[0] * dx + c[0] * dz, c[1] * dx + s[1] * dz])
    assume(abs(off.max() - 0.06) > 1e-6)
    said = [doubt.words for doubt in rest_doubts(seat, *faces)]
    assert bool(said) == bool(off.max() > 0.06)
    if said:
        assert "at (100, 200, 300) mm it would be where the planes of both meet" in said[0]


def test_how_far_a_cushion_is_from_the_plane_of_its_seat_is_said(tmp_path):
    (said,) = cab(tmp_path, {"z": 0.33})
    assert "its reference point is 70 mm below its cushion 'left_pan', so that a sitter" in said


@pytest.mark.parametrize(
    "at, said",
    [
        (
            (0.0, 0.74),
            "340 mm above its cushion 'left_pan', so that a sitter floats above the cushion",
        ),
        (
            (0.0, 0.06),
            "340 mm below its cushion 'left_pan', so that a sitter sinks through the cush",
        ),
        ((0.3, 0.4), "300 mm ahead of its back 'left_back', so that a sitter has no back behind"),
        (
            (-0.2, 0.4),
            "200 mm behind its back 'left_back', so that a sitter leans through the back",
        ),
    ],
)
def test_a_seat_reference_point_off_its_cushion_or_back_is_told_with_where_it_would_be_right(
    at, said
):
    seat = Seat(
        *("left", (at[0], 0.35, at[1]), 0.0, 0.0, 0.0),
        *(Rest("left_pan", ("LT",), 0.02), Rest("left_back", ("LT",), 0.02)),
        *((0.0, 0.0), (0.0, 0.0), ()),
    )
    faces = [PARTS[name][np.array(BOX)] for name in ("left_pan", "left_back")]
    (doubt,) = rest_doubts(seat, *faces)
    assert doubt.words.startswith(f"seat 'left': its reference point is {said}")
    assert "at (0, 350, 400) mm it would be where the planes of both meet" in doubt.words
