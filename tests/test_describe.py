"""An environment described by pointing: planes and figures of seats, parts, and what is saved."""

from __future__ import annotations

import math
import shutil
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import ROOT
from tests.made_seat import METRES, SRP, corners, obj_text, seat_parts
from workbench.cli import main
from workbench.draw.web.place_mesh import sharp_edges, thinned
from workbench.errors import InputError
from workbench.files.environments import load_environment
from workbench.files.meshes.parts import RawMesh, RawPart
from workbench.files.meshes.reading import axes_rotation
from workbench.files.seat_figures import seat_figures
from workbench.files.surface_planes import Surface, fitted_plane, grown_faces
from workbench.files.yaml_changes import changed_text, yaml_text
from workbench.files.yaml_text import parse_yaml
from workbench.study.describe.edits_files import agreed, floored, framed, scaled
from workbench.study.describe.edits_parts import dropped, joined, put_back, ruled, split_part
from workbench.study.describe.edits_seats import carried, faced
from workbench.study.describe.edits_things import placed_point, pointed, removed, renamed, typed
from workbench.study.describe.meshes import Meshes, Ray
from workbench.study.describe.people import seated_eye, seated_words
from workbench.study.describe.piece_names import piece_names
from workbench.study.describe.saving import (
    ForeignFileError,
    SavedPlace,
    save_description,
    save_first_study,
    unfinished,
)
from workbench.study.describe.state import open_place, open_sizes, standing_of

DOWN = (0.0, 0.0, -1.0)


def placed(folder, text, name="cab.obj"):
    path = folder / name
    path.write_text(text)
    return open_place(path)


def ray(part, start, way):
    return Ray(part, start, way, 0.0)


def on_cushion(seat=SRP, ahead=0.2):
    return ray("pan", (seat[0] + ahead, seat[1] + 0.1, 3.0), DOWN)


def on_back():
    return ray("rest", (3.0, SRP[1] - 0.1, SRP[2] + 0.3), (-1.0, 0.0, 0.0))


def seated(opened, description=None, cushion=None, back=None):
    """The description with a seat, from a click on its cushion and one on its back."""
    first = faced(opened, description or opened.start, "driver", "cushion", cushion or on_cushion())
    return faced(opened, first.description, "driver", "back", back or on_back()).description


# --- planes and figures ---------------------------------------------------------------------------


def grid(height, x, y):
    """Triangles of a surface over a grid."""
    xs, ys = np.meshgrid(x, y, indexing="ij")
    points = np.stack([xs, ys, height(xs, ys)], axis=-1).reshape(-1, 3)
    n = len(y)
    first = (np.arange(len(x) - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([np.stack([first, first + n, first + n + 1], 1), np.stack([first, first + n + 1, first + 1], 1)])  # fmt: skip
    return Surface(points, faces)


def test_the_plane_of_a_triangle_is_its_own():
    plane = fitted_plane(np.array([[[0, 0, 2], [1, 0, 2], [0, 1, 2]]], dtype=float))
    assert np.allclose(np.abs(plane.normal), [0, 0, 1])
    assert np.allclose(plane.centre, [1 / 3, 1 / 3, 2])
    assert plane.off == pytest.approx(0.0, abs=1e-12)


def test_a_step_of_ten_is_off_its_plane_by_the_mean_of_its_squares():
    square = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]])
    two = np.concatenate([square, square + np.array([0, 0, 0.01])])
    assert fitted_plane(two).off == pytest.approx(0.005)


@pytest.mark.parametrize(("cushion", "back", "yaw"), [(10, 20, 0), (0, 0, 90), (14, 24, 180), (-3, 12, -37)])  # fmt: skip
def test_a_seat_of_boxes_gives_the_figures_it_was_made_to(cushion, back, yaw):
    parts = seat_parts(cushion, back, yaw)
    top = parts["pan"][[1, 3, 5, 7]][[[0, 1, 2], [1, 3, 2]]]
    front = parts["rest"][[4, 5, 6, 7]][[[0, 1, 2], [1, 3, 2]]]
    found = seat_figures(top, front, top.mean(axis=1))
    assert np.allclose(found.srp, SRP, atol=1e-9)
    angles = np.degrees([found.cushion_angle, found.back_angle, found.yaw])
    assert np.allclose(angles, [cushion, back, yaw], atol=1e-6)
    assert found.doubts == ()


def test_a_cushion_of_slats_above_and_below_their_plane_has_its_middle_between_them():
    """Two slats of 100 mm are 40 mm above their plane, the one of 200 mm between is as far below."""
    square = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]])
    rows = ((0.1, 0.1, 0.04), (0.2, 0.2, -0.04), (0.4, 0.1, 0.04))
    slats = [square * [0.4, wide, 0] + [0, y, z] for y, wide, z in rows]
    back = square[..., [2, 1, 0]] * [0, 0.4, 0.5] + [0, 0.1, 0]
    found = seat_figures(np.concatenate(slats), back, np.zeros((1, 3)))
    assert np.allclose(found.srp, [0.0, 0.3, 0.0], atol=1e-9)


def test_on_a_bench_the_seat_is_where_it_was_clicked():
    bench = np.array(
        [[[0, -1, 0], [0.5, -1, 0], [0.5, 1, 0]], [[0, -1, 0], [0.5, 1, 0], [0, 1, 0]]]
    )
    back = bench[..., [2, 1, 0]]
    found = seat_figures(bench, back, np.array([[0.2, 0.4, 0.0], [0.3, 0.5, 0.0]]))
    assert np.allclose(found.srp, [0, 0.45, 0])
    assert "a bench of 2000 mm: the seat is where it was clicked" in found.doubts[0]


@pytest.mark.parametrize("picked", [0, 150, 299, 410, 690])
def test_a_curved_cushion_gives_one_plane_whatever_face_is_picked(picked):
    # dished across by 30 mm, sloping 8 degrees, with a front lip that falls off from x = 0.4 on
    def height(x, y):
        lip = np.maximum(x - 0.4, 0.0)
        return 0.3 + math.tan(math.radians(8)) * x + 0.5 * y * y - 8.0 * lip**2

    surface = grid(height, np.linspace(0, 0.5, 21), np.linspace(-0.25, 0.25, 21))
    plane = fitted_plane(surface.corners[grown_faces(surface, [picked])])
    normal = plane.normal * np.sign(plane.normal[2])
    assert math.degrees(math.atan2(-normal[0], normal[2])) == pytest.approx(8.0, abs=1.2)
    assert abs(normal[1]) < 0.01 and plane.off < 0.012


@settings(max_examples=12)
@given(st.integers(0, 10**6), st.integers(5, 9), st.floats(0.006, 0.016), st.floats(-3, 12))
def test_of_a_cushion_in_ribs_every_rib_gives_the_plane_of_all(picked, ribs, deep, slope):
    # seams across, `deep` below the ribs' crowns; beside it a bolster and before it a front that fall
    def height(x, y):
        rib = deep * np.abs(np.sin(np.pi * ribs * x / 0.42))
        lip = 4.0 * np.maximum(x - 0.42, 0.0)
        return 0.3 + math.tan(math.radians(slope)) * x + rib - lip

    x = np.append(np.linspace(0, 0.42, 12 * ribs + 1), 0.45)
    surface = grid(height, x, np.linspace(-0.2, 0.2, 11))
    faces = np.flatnonzero(surface.corners[..., 0].max(axis=1) < 0.42)
    plane = fitted_plane(surface.corners[grown_faces(surface, [int(faces[picked % len(faces)])])])
    normal = plane.normal * np.sign(plane.normal[2])
    assert math.degrees(math.atan2(-normal[0], normal[2])) == pytest.approx(slope, abs=2.0)
    assert plane.off < deep


def test_a_surface_ends_at_an_edge_and_a_face_without_area_is_none():
    parts = seat_parts()
    faces = np.array([(1, 5, 7), (1, 7, 3), (0, 4, 5), (0, 5, 1), (1, 1, 5)])
    surface = Surface(parts["pan"], faces)
    assert grown_faces(surface, [0]).tolist() == [0, 1]
    with pytest.raises(InputError, match="no face with an area was picked"):
        grown_faces(surface, [4])


def test_a_seat_that_is_turned_by_little_is_straight_and_that_is_said():
    parts = seat_parts(yaw=1.2)
    top = parts["pan"][[1, 3, 5, 7]][[[0, 1, 2], [1, 3, 2]]]
    front = parts["rest"][[4, 5, 6, 7]][[[0, 1, 2], [1, 3, 2]]]
    found = seat_figures(top, front, top.mean(axis=1))
    assert found.yaw == 0.0
    assert found.doubts == ()  # nothing has to be mended
    assert found.notes == ("by its planes the seat is turned 1.2 degrees; it is taken as straight",)


@pytest.mark.parametrize(
    ("cushion", "back", "words"),
    [
        ((0, 0, 1), (0, 0, 1), "cushion and back are parallel, 0 degrees apart"),
        ((1, 0, 0.1), (0.1, 0, 1), "were they exchanged"),
        ((0, 1, 1), (1, 1, 0), "slopes 35 degrees across the seat"),
    ],
)
def test_planes_of_no_seat_are_refused(cushion, back, words):
    def square(normal):
        a = np.cross(normal, [0.3, 1.0, 0.2])
        b = np.cross(normal, a)
        return np.array([[[0, 0, 0], a, b]], dtype=float)

    with pytest.raises(InputError, match=words):
        seat_figures(square(cushion) + np.array([0.2, 0, 0]), square(back), np.zeros((1, 3)))


# --- a mesh in any unit and axes --------------------------------------------------------------------

AXES = [(a, b) for a in ("x", "y", "z", "-x", "-y", "-z") for b in ("x", "y", "z", "-x", "-y", "-z") if a[-1] != b[-1]]  # fmt: skip


@settings(max_examples=15, deadline=None)
@given(
    axes=st.sampled_from(AXES),
    unit=st.sampled_from(sorted(METRES)),
    ahead=st.floats(0.03, 0.4),
)
def test_unit_axes_and_the_face_that_is_picked_make_no_difference(tmp_path_factory, axes, unit, ahead):  # fmt: skip
    text = obj_text(seat_parts(10, 20), unit, *axes)
    opened = placed(tmp_path_factory.mktemp("law"), text)
    given = {"length": unit, "up": axes[0], "forward": axes[1]}
    framed_ = framed(opened, opened.start, 0, {**given, "up": given["up"]}).description
    framed_ = replace(framed_, says={**framed_.says, "meshes": [{"file": "cab.obj", **given}]})
    seat = seated(opened, framed_, on_cushion(ahead=ahead)).says["seats"]["driver"]
    assert seat["srp"] == [100, 200, 300]
    assert (seat["cushion_angle"], seat["back_angle"], seat["yaw"]) == (10, 20, 0)


def test_what_was_pointed_at_goes_along_and_what_was_typed_stays(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts(), "mm", "y", "z"))
    start = framed(opened, opened.start, 0, {"length": "mm", "up": "y", "forward": None})
    start = framed(opened, start.description, 0, {"length": None, "up": None, "forward": "z"})
    seat = seated(opened, start.description)
    spot = placed_point(opened, seat, "control", "", {"grip": "grasp", "zone": 2}, ray("lever", (0.62, 0.02, 2), DOWN)).description  # fmt: skip
    assert spot.says["controls"]["lever"]["at"] == [620, 20, 600]
    over = typed(opened, spot, "seat", "driver", "back_angle", 25.0).description
    larger = framed(opened, over, 0, {"length": "cm", "up": None, "forward": None}).description
    found = larger.says["seats"]["driver"]
    assert found["srp"][::2] == [1000, 3000] and found["back_angle"] == 25
    assert larger.says["controls"]["lever"]["at"] == [6200, 200, 6000]
    assert larger.why[("seats", "driver", "back_angle")] == "typed"


def test_the_floor_takes_everything_along(tmp_path):
    parts = {name: points + np.array([0, 0, 0.5]) for name, points in seat_parts().items()}
    opened = placed(tmp_path, obj_text(parts))
    seat = seated(opened, cushion=on_cushion((0.1, 0.2, 0.8)), back=ray("rest", (3, 0.1, 1.1), (-1, 0, 0)))  # fmt: skip
    seat = typed(opened, seat, "seat", "driver", "srp", [0.1, 0.2, 0.9]).description
    found = floored(opened, seat, ray("floor", (0.9, -0.4, 2.0), DOWN))
    assert found.words == "the floor is at height 0: everything goes 500 mm down"
    assert found.description.says["seats"]["driver"]["srp"] == [100, 200, 400]
    assert standing_of(opened, found.description).bounds[0, 2] == pytest.approx(-0.05)
    with pytest.raises(InputError, match="slopes 90 degrees: a floor is level"):
        floored(opened, seat, ray("floor", (3.0, 0.0, 0.47), (-1, 0, 0)))


def test_a_floor_stays_a_floor_when_the_unit_is_put_right_after_it(tmp_path):
    parts = {name: points + np.array([0, 0, 0.5]) for name, points in seat_parts().items()}
    opened = placed(tmp_path, obj_text(parts))
    on_floor = floored(opened, opened.start, ray("floor", (0.9, -0.4, 2.0), DOWN)).description
    feet = framed(opened, on_floor, 0, {"length": "ft", "up": None, "forward": None}).description
    assert feet.says["meshes"][0]["move"] == [0, 0, -152.4]
    assert standing_of(opened, feet).bounds[0, 2] == pytest.approx(-0.05 * 0.3048)


def test_a_mesh_is_as_long_as_is_typed_and_its_unit_follows(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    edit = scaled(opened, opened.start, 0, 3.6)
    assert edit.description.says["meshes"][0]["length"] == "2000 mm"
    assert edit.words == "one unit of the file is 2000 mm"
    assert float(np.ptp(standing_of(opened, edit.description).bounds[:, 0])) == pytest.approx(3.6)
    with pytest.raises(InputError, match=r"a length from 0\.01 to 1000 m is needed, got 0 m"):
        scaled(opened, opened.start, 0, 0.0)


def test_a_guess_that_is_right_is_no_guess_any_more(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    assert opened.start.why[("meshes", 0, "up")].startswith("guessed")
    found = agreed(opened.start).description
    assert set(found.why.values()) == {"chosen"} and found.content != opened.start.content


def test_sizes_that_no_vehicle_has_are_said_as_the_reader_does(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    wrong = framed(opened, opened.start, 0, {"length": "mm", "up": None, "forward": None})
    (doubt,) = open_sizes(opened, wrong.description)
    assert "0.0018 m large, and 0.3 to 60 m is plausible" in doubt.words
    turned = framed(opened, opened.start, 0, {"length": None, "up": "x", "forward": None})
    assert turned.words == "up and forward are at right angles: forward is y"


@pytest.mark.parametrize(
    ("moved", "words"),
    [("2 m", ()), ("30 m", ("it is 30 m high: are the unit and the axes right?",))],
)
def test_a_mesh_of_thirty_metres_is_doubted(tmp_path, moved, words):
    high = 2.0 if moved == "2 m" else 30.0
    opened = placed(tmp_path, obj_text({"box": corners((0, 0, 0), (3, 2, high))}))
    given = {"length": "m", "up": "z", "forward": "x"}
    found = framed(opened, opened.start, 0, given).description
    assert tuple(doubt.words for doubt in open_sizes(opened, found)) == words
    accepted = replace(found, says={**found.says, "accepted": ["height"]})
    assert open_sizes(opened, accepted) == []


# --- axes that are guessed --------------------------------------------------------------------------


class Guess(NamedTuple):
    """What is guessed of a mesh: its axes, and the comments about them."""

    up: str
    forward: str
    why_up: str
    why_forward: str


def guess(folder, text):
    opened = placed(folder, text)
    mesh = opened.start.says["meshes"][0]
    why = [opened.start.why.get(("meshes", 0, key), "") for key in ("up", "forward")]
    return Guess(mesh["up"], mesh["forward"], *why)


FRAMES = [("z", "x"), ("z", "-y"), ("y", "z"), ("y", "-x"), ("x", "y")]


@pytest.mark.parametrize(("up", "forward"), FRAMES)
def test_front_and_rear_and_roof_and_floor_tell_the_axes(tmp_path, up, forward):
    parts = {
        "wheel_front": corners((1, 0, 0), (1.5, 1, 0.5)),
        "WheelRear": corners((-1.5, 0, 0), (-1, 1, 0.5)),
        "roof": corners((-1, 0, 1.5), (1, 1, 1.6)),
        "floor": corners((-1, 0, 0.4), (1, 1, 0.5)),
    }
    found = guess(tmp_path, obj_text(parts, "m", up, forward))
    assert (found.up, found.forward) == (up, forward)
    assert found.why_forward == "guessed: by the names wheel_front and WheelRear"
    assert found.why_up == "guessed: by the names roof and floor"


@pytest.mark.parametrize(("up", "forward"), FRAMES)
def test_left_and_right_tell_the_front(tmp_path, up, forward):
    parts = {
        "left_door": corners((0, 0.8, 0.2), (1, 0.9, 1)),
        "right_door": corners((0, -0.9, 0.2), (1, -0.8, 1)),
        "roof": corners((-1, -0.9, 1.5), (1, 0.9, 1.6)),
        "floor": corners((-1, -0.9, 0.0), (1, 0.9, 0.1)),
    }
    assert guess(tmp_path, obj_text(parts, "m", up, forward)).forward == forward


@pytest.mark.parametrize(
    ("name", "up", "forward"), [("trainer", "y", "z"), ("compact_car", "z", "-y")]
)
def test_shape_alone_tells_the_axes_of_the_catalogue(tmp_path, name, up, forward):
    environment = load_environment(name)
    triangles = environment.vertices[environment.triangles]
    points = triangles.reshape(-1, 3) @ axes_rotation(up, forward)
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in points]
    lines += [f"f {k} {k + 1} {k + 2}" for k in range(1, len(points), 3)]
    found = guess(tmp_path, "\n".join(lines))
    assert (found.up, found.forward) == (up, forward)
    assert "not sure" not in found.why_forward


def test_which_end_of_a_box_is_the_front_is_asked(tmp_path):
    found = guess(tmp_path, obj_text({"box": corners((0, -0.5, 0), (3, 0.5, 1.0))}))
    assert found.forward == "x"
    assert found.why_forward.startswith("guessed, not sure: ")
    assert "which end is the front is not known" in found.why_forward


# --- parts ------------------------------------------------------------------------------------------


def test_pieces_are_called_by_where_they_are_and_what_shape_they_have():
    whole = corners((0, -1, 0), (4, 1, 2))
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    rim = np.stack([0.3 * np.cos(turn), np.zeros(24), 0.3 * np.sin(turn)], axis=1)
    wheel = np.concatenate([rim + np.array([3.5, y, 0.3]) for y in (0.8, 1.0)])
    pieces = [
        whole,
        corners((1.5, 0.95, 0.4), (2.5, 1.0, 1.4)),
        corners((1.5, -1.0, 0.4), (2.5, -0.95, 1.4)),
        corners((0, -1, 0), (4, 1, 0.05)),
        corners((1, -0.7, 1.9), (1.05, 0.7, 1.95)),
        corners((3.9, 0.5, 1.0), (3.92, 0.52, 1.02)),
        wheel,
        wheel,
    ]
    assert piece_names(pieces, np.array([whole.min(axis=0), whole.max(axis=0)])) == [
        "body",
        "left_side_plate",
        "right_side_plate",
        "floor",
        "rear_upper_crossbar",
        "left_front_small_piece",
        "left_front_lower_disc",
        "left_front_lower_disc_2",
    ]


def test_a_part_that_is_split_keeps_its_name_before_those_of_its_pieces(tmp_path):
    parts = seat_parts()
    lines = obj_text(parts).replace("o rest\n", "").replace("o pan\n", "o chair\n")
    opened = placed(tmp_path, lines)
    found = split_part(opened, opened.start, "chair")
    assert found.words == "chair is 2 parts, called by where they are"
    names = standing_of(opened, found.description).names
    assert names == ("chair_block", "chair_rear_upper_block", "floor", "lever")
    assert found.description.says["meshes"][0]["join"]["chair_block"] == ["chair_1"]


def test_a_mesh_without_names_is_split_into_its_pieces(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts(), names=False))
    names = ("block", "rear_upper_block", "floor", "front_post")
    assert standing_of(opened, opened.start).names == names
    assert opened.start.says["meshes"][0]["split"] == ["cab"]


def test_parts_are_renamed_joined_left_out_and_put_back(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    seat = seated(opened)
    one = joined(opened, seat, ["pan"], "seat pan").description
    assert one.says["seats"]["driver"]["cushion"]["part"] == "seat pan"
    assert one.says["seats"]["driver"]["moves"] == ["seat pan", "rest"]
    both = joined(opened, one, ["floor", "lever"], "cabin").description
    assert both.says["meshes"][0]["join"] == {"seat pan": ["pan"], "cabin": ["floor", "lever"]}
    gone = dropped(opened, both, ["cabin"]).description
    assert standing_of(opened, gone).names == ("seat pan", "rest")
    back = put_back(opened, gone, 0, "lever").description
    assert standing_of(opened, back).names == ("seat pan", "rest", "lever")
    again = joined(opened, back, ["seat pan"], "pan").description
    assert "join" not in again.says["meshes"][0]


def test_instruments_and_mirrors_follow_the_names_of_parts_and_hold_them(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    seen = {"instruments": {"clock": {"part": "lever", "face": [-1, 0, 0]}}}
    seen["mirrors"] = {"rear": {"part": "rest", "radius": "flat", "aims": [-20, 0, 0.5]}}
    start = replace(opened.start, says={**opened.start.says, **seen})
    one = joined(opened, start, ["lever"], "dial").description
    assert one.says["instruments"]["clock"] == {"part": "dial", "face": [-1, 0, 0]}
    with pytest.raises(InputError, match="instrument 'clock' is 'dial'"):
        dropped(opened, one, ["dial"])
    with pytest.raises(InputError, match="mirror 'rear' is 'rest'"):
        dropped(opened, one, ["rest"])


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda o, d: joined(o, d, ["pan"], "floor"), "there is a part 'floor' already"),
        (lambda o, d: joined(o, d, [], "x"), "no part is chosen"),
        (lambda o, d: joined(o, d, ["pan"], " "), "a part needs a name"),
        (lambda o, d: joined(o, d, ["pam"], "x"), "did you mean 'pan'"),
        (lambda o, d: dropped(o, d, ["pan"]), "'pan' is the cushion of seat 'driver'"),
        (lambda o, d: dropped(o, removed(d, "seat", "driver").description, ["pan", "rest", "floor", "lever"]), "nothing is left"),
        (lambda o, d: split_part(o, d, "floor"), "it is one piece"),
        (lambda o, d: put_back(o, d, 0, "floor"), "no part 'floor' was left out"),
        (lambda o, d: ruled(o, d, "pam", "hidden", True), "there is no part 'pam'"),
        (lambda o, d: renamed(d, "seat", "driver", ""), "a seat needs a name"),
        (lambda o, d: renamed(seated_again(o, d), "seat", "driver", "other"), "there is a seat 'other' already"),
        (lambda o, d: removed(d, "control", "horn"), "there is no control 'horn'"),
        (lambda o, d: typed(o, d, "seat", "driver", "back_angle", 120.0), "seats.driver.back_angle"),
        (lambda o, d: typed(o, d, "seat", "driver", "srp", 3.0), "3 lengths are needed"),
        (lambda o, d: typed(o, d, "seat", "driver", "colour", 3.0), "a seat has no 'colour'"),
        (lambda o, d: faced(o, d, "driver", "cushion", ray("pan", (9, 9, 9), DOWN)), "nothing was picked"),
        (lambda o, d: faced(o, d, "x", "back", ray("pam", (9, 9, 9), DOWN)), "no part 'pam' any more"),
        (lambda o, d: faced(o, faced(o, d, "x", "cushion", on_cushion()).description, "x", "back", ray("floor", (0.9, -0.4, 2.0), DOWN)), "are parallel"),
        (lambda o, d: framed(o, d, 0, {"length": "yd", "up": None, "forward": None}), "a length such as"),
        (lambda o, d: framed(o, d, 3, {}), "there are 1 meshes"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_said_in_one_sentence(tmp_path, act, words):
    opened = placed(tmp_path, obj_text(seat_parts()))
    with pytest.raises(InputError, match=words) as found:
        act(opened, seated(opened)).description.file  # noqa: B018 (some faults show only then)
    assert "\n" not in str(found.value)


def seated_again(opened, description):
    first = faced(opened, description, "other", "cushion", on_cushion())
    return faced(opened, first.description, "other", "back", on_back()).description


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("cab.txt", "hello", "is not a mesh format"),
        ("cab.obj", "", "is empty"),
        ("cab.obj", "v 0 0 0\n", "holds no surface"),
        ("cab.stl", "no mesh at all", "cab.stl"),
    ],
)
def test_a_file_that_is_no_mesh_is_refused(tmp_path, name, text, words, capsys):
    (tmp_path / name).write_text(text)
    assert main(["live", str(tmp_path / name), "--no-browser"]) == 3
    assert words in capsys.readouterr().err


def test_a_mesh_of_one_face_opens_and_gives_no_seat(tmp_path):
    opened = placed(tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    click = ray("cab", (0.2, 0.2, 1.0), DOWN)
    with pytest.raises(InputError, match="cushion and back are parallel"):
        seated(opened, cushion=click, back=click)


def test_too_many_triangles_are_refused_with_the_limit(monkeypatch, tmp_path):
    monkeypatch.setattr("workbench.study.describe.meshes.MOST_FACES", 10)
    with pytest.raises(InputError, match="has 48 triangles, and 10 are possible here"):
        placed(tmp_path, obj_text(seat_parts()))


# --- what is saved --------------------------------------------------------------------------------


def test_a_new_file_says_how_each_figure_was_got_and_opens_again_as_it_was(tmp_path, capsys):
    opened = placed(tmp_path, obj_text(seat_parts()))
    seat = seated(opened)
    seat = placed_point(opened, seat, "point", "heel", {}, ray("floor", (0.9, 0.4, 2), DOWN)).description  # fmt: skip
    seat = ruled(opened, joined(opened, seat, ["lever"], "gear lever").description, "floor", "solid", False).description  # fmt: skip
    saved = save_description(opened, seat, None)
    text = (tmp_path / "environment.yaml").read_text()
    assert "srp: [100, 200, 300]  # fitted: where the planes of cushion and back meet" in text
    assert "back_angle: 20  # fitted: plane of 2 faces, 0.0 mm off in the mean" in text
    assert "heel: [900, 400, 0]  # picked: on floor" in text
    assert main(["check", str(tmp_path / "environment.yaml")]) == 0
    again = open_place(tmp_path / "environment.yaml")
    assert again.start.says == seat.says == saved.says
    environment = load_environment(tmp_path / "environment.yaml")
    assert environment.parts == ("pan", "rest", "floor", "gear lever")
    assert not environment.solid[2] and environment.solid[3]
    assert math.degrees(environment.seat("driver").back_angle) == pytest.approx(20.0)
    more = typed(opened, seat, "seat", "driver", "back_angle", 21.0).description
    save_description(opened, more, saved)
    changed = (tmp_path / "environment.yaml").read_text()
    assert changed == text.replace(
        "back_angle: 20  # fitted: plane of 2 faces, 0.0 mm off in the mean",
        "back_angle: 21  # typed",
    )


def test_picked_faces_are_in_the_file_and_a_seat_goes_on_from_there(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    seat = typed(opened, seated(opened), "seat", "driver", "back_angle", 25.0).description
    save_description(opened, seat, None)
    text = (tmp_path / "environment.yaml").read_text()
    assert "picked: [[300, 300, 335.3]]" in text
    again = open_place(tmp_path / "environment.yaml")
    assert again.start.picks["driver"].faces("cushion") == seat.picks["driver"].faces("cushion")
    assert again.start.why[("seats", "driver", "back_angle")] == "typed"
    assert again.start.why[("seats", "driver", "cushion_angle")].startswith("fitted: plane of 2")
    larger = framed(again, again.start, 0, {"length": "cm", "up": None, "forward": None})
    found = larger.description.says["seats"]["driver"]
    assert found["srp"] == [1, 2, 3] and found["back_angle"] == 25
    assert found["cushion"]["picked"] == [[3, 3, 3.4]]


def test_picks_that_are_off_the_mesh_are_said_and_the_seat_stays(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    save_description(opened, seated(opened), None)
    path = tmp_path / "environment.yaml"
    path.write_text(path.read_text().replace("335.3", "395.3"))
    again = open_place(path)
    assert again.notes == (
        "driver: what was picked of the cushion is not on the mesh any more: pick it again",
    )
    assert again.start.picks["driver"].lacks == ("cushion",)
    assert again.start.says["seats"]["driver"]["cushion_angle"] == 10


def test_which_parts_go_along_with_a_seat_is_chosen(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    found = carried(opened, seated(opened), "driver", ["pan", "rest", "lever"]).description
    assert found.says["seats"]["driver"]["moves"] == ["pan", "rest", "lever"]
    tilted = typed(opened, found, "seat", "driver", "tilt", [-3.0, 6.0]).description
    assert tilted.says["seats"]["driver"]["travel"] == {"tilt": [-3, 6]}
    with pytest.raises(InputError, match="there is no part 'pam'; did you mean 'pan'"):
        carried(opened, found, "driver", ["pam"])


def test_a_mesh_that_has_changed_on_the_disk_is_asked_about(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    (tmp_path / "cab.obj").write_text(obj_text(seat_parts(cushion=5)) + "# new\n")
    with pytest.raises(
        ForeignFileError, match=r"cab\.obj has changed on the disk since it was opened"
    ):
        save_description(opened, opened.start, None)
    (tmp_path / "cab.obj").unlink()
    with pytest.raises(ForeignFileError, match=r"cab\.obj has changed"):
        save_description(opened, opened.start, None)


def test_what_is_unfinished_is_said(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    (tmp_path / "box").mkdir()
    box = placed(tmp_path / "box", obj_text({"box": corners((0, -0.5, 0), (3, 0.5, 1))}))
    assert unfinished(box, box.start) == ["cab.obj: up and forward: a guess that nobody confirmed"]
    sure = agreed(opened.start).description
    half = faced(opened, sure, "driver", "cushion", on_cushion()).description
    assert unfinished(opened, half) == ["seat driver is not in the file: its back was not picked"]
    again = faced(opened, seated(opened, sure), "driver", "back", None).description
    assert unfinished(opened, again) == [
        "seat driver has the figures of before: its back is not picked again yet"
    ]
    assert unfinished(opened, seated(opened, sure)) == []


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("environment.yaml", "environment: x\nlength: mm\nmeshes: [{file: gone.obj}]\n", "meshes: "),
        ("environment.yaml", "environment: x\nlength: [mm\n", "not YAML"),
        ("environment.yaml", "environment: x\ncolour: red\nlength: mm\n", "unknown key 'colour'"),
    ],
)  # fmt: skip
def test_an_environment_with_mistakes_is_refused_with_their_places(tmp_path, name, text, words, capsys):  # fmt: skip
    (tmp_path / name).write_text(text)
    assert main(["live", str(tmp_path / name), "--no-browser"]) == 3
    said = capsys.readouterr().err
    assert words in said and "environment.yaml" in said


def test_a_folder_without_an_environment_is_refused(tmp_path, capsys):
    assert main(["live", str(tmp_path), "--no-browser"]) == 3
    assert "holds no environment.yaml: name the mesh in it" in capsys.readouterr().err


def test_names_of_no_part_are_said_at_opening(tmp_path):
    (tmp_path / "cab.obj").write_text(obj_text(seat_parts()))
    text = "environment: x\nlength: mm\nmeshes: [{file: cab.obj, up: z, forward: x}]\ncontrols: {a: {at: [0, 0, 0], grip: push, zone: 1, part: pam}}\n"  # fmt: skip
    (tmp_path / "environment.yaml").write_text(text)
    first, second = open_place(tmp_path).notes
    assert "controls.a.part: no part 'pam'; did you mean 'pan'" in first
    assert second == "cab.obj: the file does not say its unit: choose it"


# --- a first study ----------------------------------------------------------------------------------


def test_a_first_study_is_checked_and_leads_on(tmp_path, capsys):
    opened = placed(tmp_path, obj_text(seat_parts()))
    sure = framed(opened, opened.start, 0, {"length": "m", "up": "z", "forward": "x"}).description
    place = placed_point(opened, seated(opened, sure), "control", "gear lever", {"grip": "grasp", "zone": 1}, ray("lever", (0.62, 0.02, 2), DOWN)).description  # fmt: skip
    save_description(opened, place, None)
    assert main(["new", str(tmp_path)]) == 0
    assert main(["check", str(tmp_path / "study.yaml")]) == 0
    text = (tmp_path / "study.yaml").read_text()
    assert 'hands: {right: "gear lever"}' in text
    assert "next: workbench run" in capsys.readouterr().err
    assert main(["new", str(tmp_path)]) == 3
    assert "is there already" in capsys.readouterr().err


def test_a_mesh_has_no_first_study(tmp_path):
    (tmp_path / "cab.obj").write_text(obj_text({"desk": corners((0, -1, 0), (1, 1, 1))}))
    assert main(["new", str(tmp_path / "cab.obj")]) == 2


def test_a_file_that_was_not_made_here_is_asked_about(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    (tmp_path / "environment.yaml").write_text("mine\n")
    with pytest.raises(ForeignFileError, match="is there already, and was not made here"):
        save_description(opened, opened.start, None)
    assert (tmp_path / "environment.yaml").read_text() == "mine\n"
    saved = save_description(opened, opened.start, None, over=True)
    (tmp_path / "environment.yaml").write_text("mine again\n")
    with pytest.raises(ForeignFileError, match="has changed on the disk"):
        save_description(opened, seated(opened), saved)


def test_elsewhere_the_mesh_goes_along_and_no_folder_is_a_sentence(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    to = tmp_path / "environments" / "cab" / "environment.yaml"
    save_description(opened, seated(opened), None, to=to)
    assert load_environment(to).seat("driver").yaw == 0.0
    with pytest.raises(InputError, match="cannot be written") as found:
        save_description(opened, opened.start, None, to=tmp_path / "cab.obj" / "environment.yaml")
    assert "\n" not in str(found.value)


def test_a_mesh_outside_of_its_folder_is_not_opened(tmp_path):
    (tmp_path / "inner").mkdir()
    text = "environment: cab\nlength: mm\nmeshes: [{file: ../cab.obj, length: m, up: z, forward: x}]\n"  # fmt: skip
    (tmp_path / "inner" / "environment.yaml").write_text(text)
    (tmp_path / "cab.obj").write_text(obj_text(seat_parts()))
    with pytest.raises(InputError, match="a mesh lies in the folder of its environment file"):
        open_place(tmp_path / "inner")


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("drop: [nose]", "environment.yaml:3:11: meshes[0].file: cab.obj: drop: no part of the name 'nose'"),
        ("join: {pan: [rest]}", "join: there is a part 'pan' already"),
        ("join: {a: [pan], b: [p*]}", "join: part 'pan' is in 'a' and in 'b'"),
        ("drop: ['*']", "drop: nothing is left of the mesh"),
    ],
)  # fmt: skip
def test_parts_that_cannot_be_made_are_refused_with_their_place(tmp_path, more, words):
    text = f"environment: cab\nlength: mm\nmeshes: [{{file: cab.obj, length: m, up: z, forward: x, {more}}}]\n"  # fmt: skip
    (tmp_path / "environment.yaml").write_text(text)
    (tmp_path / "cab.obj").write_text(obj_text(seat_parts()))
    with pytest.raises(InputError) as found:
        load_environment(tmp_path / "environment.yaml")
    assert words in str(found.value)


@pytest.mark.parametrize("name", ["trainer", "compact_car"])
def test_an_environment_of_the_catalogue_is_corrected_with_its_comments(tmp_path, name):
    shutil.copytree(ROOT / "environments" / name, tmp_path / name)
    opened = open_place(tmp_path / name)
    control = next(iter(opened.start.says["controls"]))
    seat = next(iter(opened.start.says["seats"]))
    one = typed(opened, opened.start, "seat", seat, "back_angle", 17.5).description
    one = renamed(one, "control", control, "first").description
    one = typed(opened, one, "control", "first", "zone", 3).description
    one = joined(opened, one, ["floor"], "cabin floor").description
    text = opened.text.text
    save_description(opened, one, SavedPlace(opened.text, opened.start.says))
    after = (tmp_path / name / "environment.yaml").read_text()
    assert after.count("#") == text.count("#") + 1  # that the angle was typed
    before = set(text.splitlines())
    changed = [line for line in after.splitlines() if line not in before]
    assert len(changed) == 4
    assert open_place(tmp_path / name).start.says == one.says


def plain_value(rng, deep):
    """A random value as a YAML file may hold it."""
    kind = rng.integers(0, 5 if deep else 2)
    if kind == 0:
        return int(rng.integers(-9, 9))
    if kind == 1:
        return ["a", "true", "1", "b c", "-x", "ü: #", True, False][rng.integers(8)]
    if kind == 2:
        return [plain_value(rng, deep - 1) for _ in range(rng.integers(0, 3))]
    names = rng.permutation(["p", "q", "r", "s"])[: rng.integers(0, 4)]
    return {str(name): plain_value(rng, deep - 1) for name in names}


@pytest.mark.parametrize("seed", range(40))
def test_a_changed_text_says_what_it_is_to_say(seed):
    rng = np.random.default_rng(seed)

    def file():
        return {key: plain_value(rng, 3) for key in ("one", "two", "three")[: rng.integers(1, 4)]}

    before, after, deep = file(), file(), seed % 4
    text = yaml_text(before, {}, lambda key: len(key) <= deep)
    assert parse_yaml(text, "x").value == before
    changed = changed_text(text, after, block=lambda key: len(key) <= deep)
    assert parse_yaml(changed, "x").value == after


def test_comments_of_the_program_are_exchanged_and_others_stay():
    text = "a: 1  # picked: on floor\nb: 2  # mine\nc: {d: 3}\n# end\n"
    after = {"a": 5, "b": 6, "c": {"d": 4}}
    changed = changed_text(text, after, notes={("a",): "typed", ("b",): "typed"})
    assert changed == "a: 5  # typed\nb: 6  # mine\nc: {d: 4}\n# end\n"


# --- large meshes -----------------------------------------------------------------------------------


def test_only_the_picture_of_a_large_mesh_is_thinned():
    surface = grid(lambda x, y: 0.02 * np.sin(9 * x) + 0 * y, np.linspace(0, 1, 101), np.linspace(0, 1, 101))  # fmt: skip
    thin = thinned(surface.vertices, surface.faces, np.zeros(len(surface.vertices), dtype=np.int64), most=2000)  # fmt: skip
    assert 500 < len(thin.faces) <= 2000 and len(surface.faces) == 20_000
    assert np.ptp(thin.vertices, axis=0) == pytest.approx([1, 1, 0.04], abs=0.03)
    middle = surface.corners[thin.source].mean(axis=1)
    assert np.linalg.norm(middle - thin.vertices[thin.faces].mean(axis=1), axis=1).max() < 0.06
    same = thinned(surface.vertices, surface.faces, np.zeros(len(surface.vertices), dtype=np.int64), most=2000)  # fmt: skip
    assert np.array_equal(thin.faces, same.faces)


def test_the_edges_of_a_box_are_drawn_and_its_diagonals_are_not():
    from tests.made_seat import BOX

    edges = sharp_edges(corners((0, 0, 0), (1, 2, 3)), np.array(BOX))
    assert len(edges) == 12


def test_a_click_meets_the_face_that_is_nearest_to_where_the_picture_was_met():
    part = RawPart("box", corners((0, 0, 0), (1, 1, 1)), np.array([(1, 5, 7), (1, 7, 3), (0, 6, 4), (0, 2, 6)]))  # fmt: skip
    raw = RawMesh("box.obj", "obj", (part,), 1.0, "z", (), "x")
    meshes = Meshes([raw])
    opened = open_box(meshes)
    for far, height in ((1.0, 1.0), (1.9, 0.0)):  # seen from 2 m above
        hit = opened.hit(Ray("box", (0.3, 0.6, 2.0), DOWN, far))
        assert hit.point == pytest.approx([0.3, 0.6, height])


def open_box(meshes):
    from workbench.files.environment_schema import MeshFile

    return meshes.standing([MeshFile(file="box.obj")])


def pedal_on_the_floor(opened):
    """A seat, and a pedal that was clicked on the floor before it."""
    under = ray("floor", (SRP[0] + 0.7, SRP[1], 1.0), DOWN)
    given = {"grip": "foot", "zone": 1}
    return placed_point(opened, seated(opened), "control", "pedal", given, under).description


@pytest.mark.parametrize(
    ("at", "part", "words"),
    [
        ((0.8, 0.2, 0.005), "floor", ""),
        ((0.8, 0.2, 0.15), None, "nothing is within 10 mm of there, so it is on no part"),
        ((0.8, 0.2, 0.05), None, "nothing is within 10 mm of there, so it is on no part"),
        ((0.62, 0.02, 0.603), "lever", "pedal is on lever"),
    ],
)
def test_a_control_whose_place_is_typed_is_on_what_is_there(tmp_path, at, part, words):
    opened = placed(tmp_path, obj_text(seat_parts()))
    before = pedal_on_the_floor(opened)
    assert before.says["controls"]["pedal"]["part"] == "floor"
    edit = typed(opened, before, "control", "pedal", "at", list(at))
    assert edit.description.says["controls"]["pedal"].get("part") == part
    assert words in edit.words and bool(words) == bool(edit.words)
    on_lever = typed(opened, edit.description, "control", "pedal", "part", "lever").description
    beside = typed(opened, on_lever, "control", "pedal", "at", [0.68, 0.02, 0.5])  # 40 mm beside
    assert beside.description.says["controls"]["pedal"]["part"] == "lever" and not beside.words


def test_a_floor_with_a_pedal_clicked_on_it_is_still_the_floor_under_the_feet(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    bare = seated(opened)
    ground = standing_of(opened, bare).ground
    said = seated_words(bare.file, "driver", ground)
    assert "the feet hang 61 mm above 'floor'" in said.doubts[0]
    assert seated_words(pedal_on_the_floor(opened).file, "driver", ground) == said


def test_the_eye_point_of_a_seat_is_where_its_man_has_his_eyes_in_a_first_study(tmp_path):
    opened = placed(tmp_path, obj_text(seat_parts()))
    before = pedal_on_the_floor(opened)
    eyes = seated_eye(before.file, "driver")
    eye = pointed(before, "driver_design_eye", eyes, "assumed: of the man").description
    save_description(opened, eye, None)
    save_first_study(tmp_path / "environment.yaml", tmp_path / "study.yaml")
    result = wb.run(wb.load_study(tmp_path / "study.yaml"))
    (height,) = [one.worst for one in result.verdicts if one.criterion.check == "eye_height"]
    assert height.margin == pytest.approx(0.025, abs=2e-4)  # so much below would still do
