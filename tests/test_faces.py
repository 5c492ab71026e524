"""Instruments and mirrors of an environment: which face they have, that it goes along with its part,
and what is said where it cannot be told."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ROOT
from tests.same_study import Same, write_same
from tests.test_environments import SEATS, obj, solid
from workbench import InputError, load_environment, load_study
from workbench.model.surroundings import adjusted

HEAD = """environment: cab
length: {unit}
meshes:
  - {{file: cab.obj, length: m, up: z, forward: x}}
"""
SEAT = SEATS.replace("moves: ", "moves: [] # ")
"""Eyes at (47, 0, 1229) mm by the seat's reference point (0, 0, 450) and its back of 13 degrees."""
THINGS = """instruments:
  clock: {part: dial, characters: "4.5 mm", lit: true}
mirrors:
  rear_view: {part: glass, radius: "1260 mm", class: I, aims: ["-20 m", "0 m", "0 m"]}
  plain: {part: pane, radius: flat}
"""
COLUMN = """adjustments:
  tilt: {about: {point: [1000, 0, 500], axis: [0, 2, 1]}, travel: [-30, 30], parts: [dial, glass]}
"""
NO_DOUBT = "accepted: ['*']\n"
CAP = 1.26
MIDDLE = np.array([0.6, 0.2, 1.4])
LOOKS = np.array([-0.8, -0.6, 0.0])


def cap(radius=CAP, *, half=0.1, outward=LOOKS, at=MIDDLE):
    """A convex glass, 10 mm thick, whose surface of a radius has `at` in its middle."""
    y, z = np.meshgrid(np.linspace(-half, half, 13), np.linspace(-half, half, 13), indexing="ij")
    front = np.stack([np.sqrt(radius**2 - y**2 - z**2) - radius, y, z], axis=-1).reshape(-1, 3)
    edge = np.array([[-0.03, s * half, t * half] for s in (-1, 1) for t in (-1, 1)])
    mesh = trimesh.Trimesh(np.concatenate([front, edge])).convex_hull
    up = np.array([0.0, 0.0, 1.0])
    turn = np.column_stack([outward, np.cross(up, outward), up])
    return trimesh.Trimesh(mesh.vertices @ turn.T + at, mesh.faces)


def sheet(*, flip):
    """A square of 200 mm at x = 800 mm, wound either way."""
    corners = [(0.8, s, 1.0 + t) for s in (-0.1, 0.1) for t in (-0.1, 0.1)]
    faces = np.array([[0, 1, 3], [0, 3, 2]])
    return trimesh.Trimesh(corners, faces[:, ::-1] if flip else faces, process=False)


def reflected(mesh):
    """A mesh on the other side of the plane y = 0."""
    return trimesh.Trimesh(mesh.vertices * [1, -1, 1], mesh.faces[:, ::-1], process=False)


def made(folder, things=THINGS, *, seat=SEAT, unit="mm", image=False, put_away=NO_DOUBT, **more):
    """The environment of a folder: a dial, a glass, a pane, and other parts; or its mirror image."""
    parts = {
        "pan": solid((0.5, 0.5, 0.1), (0, 0, 0.4)),
        "dial": solid((0.02, 0.1, 0.08), (0.7, 0.1, 1.1)),
        "cube": solid((0.2, 0.2, 0.2), (0.7, 0.0, 0.6)),
        "glass": cap(),
        "pane": sheet(flip=False),
    } | more
    if image:
        parts = {name: reflected(mesh) for name, mesh in parts.items()}
    (folder / "cab.obj").write_text(obj(**parts))
    (folder / "environment.yaml").write_text(HEAD.format(unit=unit) + seat + things + put_away)
    return load_environment(folder)


def test_an_instrument_has_the_face_of_its_part_that_shows_most_to_the_eyes(tmp_path):
    clock = made(tmp_path).instrument("clock")
    assert clock.at == pytest.approx((0.69, 0.1, 1.1)) and clock.face == pytest.approx((-1, 0, 0))
    assert (clock.part, clock.characters, clock.lit) == ("dial", pytest.approx(0.0045), True)


def test_a_convex_mirror_has_its_middle_on_its_surface(tmp_path):
    glass = made(tmp_path).mirror("rear_view")
    np.testing.assert_allclose(glass.normal, LOOKS, atol=1e-3)
    np.testing.assert_allclose(glass.at, MIDDLE, atol=3e-4)
    assert (glass.radius, glass.field) == (pytest.approx(1.26), "I")
    assert glass.aims == (-20.0, 0.0, 0.0)


@pytest.mark.parametrize("flip", [False, True])
def test_a_sheet_looks_toward_the_eyes_however_it_is_wound(tmp_path, flip):
    pane = made(tmp_path, pane=sheet(flip=flip)).mirror("plain")
    assert pane.at == pytest.approx((0.8, 0, 1)) and pane.normal == pytest.approx((-1, 0, 0))
    assert pane.radius == math.inf and pane.field == "" and pane.aims is None


@pytest.mark.parametrize(("stated", "x"), [("[-3, 0.5, 0]", 0.6), ("[2, 0, 0]", 0.8)])
def test_a_stated_direction_chooses_the_face(tmp_path, stated, x):
    things = f"instruments: {{clock: {{part: cube, face: {stated}}}}}\n"
    clock = made(tmp_path, things).instrument("clock")
    assert clock.at == pytest.approx((x, 0, 0.6)) and clock.characters == 0.0
    assert clock.face == pytest.approx((math.copysign(1, x - 0.7), 0, 0))


def test_without_a_seat_a_stated_direction_is_enough(tmp_path):
    things = "instruments: {clock: {part: dial, face: [-1, 0, 0]}}\n"
    assert made(tmp_path, things, seat="").instrument("clock").at == pytest.approx((0.69, 0.1, 1.1))


def test_the_unit_of_the_file_makes_no_difference(tmp_path):
    seat = SEAT.replace("450", '"450 mm"').replace("20}", '"20 mm"}').replace("15}", '"15 mm"}')
    seat = seat.replace("[-70, 70]", "[0, 0]").replace("[-25,", "[0,")
    one = made(tmp_path, seat=seat, unit="in")
    other = made(tmp_path)
    assert one.instruments == other.instruments and one.mirrors == other.mirrors


@settings(max_examples=10)
@given(st.floats(-30, 30), st.tuples(*[st.floats(-1, 1)] * 3))
def test_instruments_and_mirrors_go_along_with_their_parts(tmp_path_factory, degrees, by):
    room = made(tmp_path_factory.mktemp("cab"), THINGS + COLUMN)
    out = adjusted(room, {"tilt": math.radians(degrees)}).moved({"dial": by})
    dial = out.polygons(out.part_index("dial"))
    face = dial.start + int(np.argmax(room.normal[dial] @ [-1, 0, 0]))
    np.testing.assert_allclose(out.instrument("clock").at, out.circle_centre[face], atol=1e-12)
    np.testing.assert_allclose(out.instrument("clock").face, out.normal[face], atol=1e-12)
    start, end = room.mirror("rear_view"), out.mirror("rear_view")
    glass = out.part_index("glass")
    one, other = (np.array(e.triangle_corners(glass)).reshape(-1, 3) for e in (room, out))
    np.testing.assert_allclose(
        np.linalg.norm(other - end.at, axis=1), np.linalg.norm(one - start.at, axis=1), atol=1e-9
    )
    np.testing.assert_allclose(
        (other - end.at) @ end.normal, (one - start.at) @ start.normal, atol=1e-9
    )
    assert end.aims == start.aims and out.mirror("plain") == room.mirror("plain")


def test_the_mirror_image_of_a_cab_has_mirrored_instruments(tmp_path):
    flip = np.array([1.0, -1.0, 1.0])
    one = made(tmp_path)
    other = made(tmp_path, image=True)
    np.testing.assert_allclose(other.instrument("clock").at, one.instrument("clock").at * flip)
    for name in ("rear_view", "plain"):
        here, there = one.mirror(name), other.mirror(name)
        np.testing.assert_allclose(there.at, here.at * flip, atol=1e-9)
        np.testing.assert_allclose(there.normal, here.normal * flip, atol=1e-9)


TWO_FACES = "two faces of part 'cube' show about as much to the eyes"


@pytest.mark.parametrize(
    ("things", "place", "words"),
    [
        ("instruments: {clock: {part: dal}}", "14:23", "did you mean 'dial'?"),
        ("instruments: {clock: {part: 'd*', face: [-1, 0, 0], chars: 3}}", "14:53", "'characters'"),
        ("instruments: {clock: {part: '*a*', face: [-1, 0, 0]}}", "14:23", "means 4 parts: pan, dial"),
        ("instruments: {clock: {part: cube}}", "14:15", TWO_FACES),
        ("instruments: {clock: {part: pan, face: [0, 0, 0]}}", "14:34", "a direction needs a length"),
        ("instruments: {clock: {part: pane, face: [0, 0, 1]}}", "14:35", "no face of part 'pane' looks within 45 degrees of [0, 0, 1]; its largest look along [-1, 0, 0]"),
        ("instruments: {clock: {part: dial, characters: 0}}", "14:35", "0.5 to 200 mm"),
        ("instruments: {clock: {part: dial, characters: 4500}}", "14:35", "0.5 to 200 mm high are possible"),
        ("mirrors: {m: {part: pane}}", "14:11", "key 'radius' is missing"),
        ("mirrors: {m: {part: pane, radius: round}}", "14:27", "'flat', or the radius of a convex surface: a length such as '450 mm'"),
        ("mirrors: {m: {part: pane, radius: 0}}", "14:27", "'flat', or the radius of a convex surface"),
        ("mirrors: {m: {part: pane, radius: -1200}}", "14:27", "'flat', or the radius"),
        ("mirrors: {m: {part: pane, radius: flat, klass: I}}", "14:41", "did you mean 'class'?"),
        ("mirrors: {m: {part: pane, radius: flat, face: [1, 0, 0]}}", "14:41", "it faces away from the eyes in every seat ('left'): its surface looks along [1, 0, 0]"),
        ("mirrors: {m: {part: cube, radius: flat}}", "14:11", TWO_FACES),
        ("mirrors: {m: {part: fin, radius: flat}}", "14:11", "has no face that looks toward the eyes in a seat"),
    ],
)  # fmt: skip
def test_what_cannot_be_told_is_named_with_its_place(tmp_path, things, place, words):
    # a sheet that holds the eyes in its plane
    fin = trimesh.Trimesh([(0.8, 0, 0), (0.9, 0, 0), (0.8, 0, 0.1)], [[0, 1, 2]])
    with pytest.raises(InputError) as caught:
        made(tmp_path, things + "\n", fin=fin)
    (problem,) = caught.value.problems
    assert f"environment.yaml:{place}:" in problem and words in problem


def test_where_a_seat_is_doubted_that_is_told_and_not_which_face_is_meant(tmp_path):
    things = "instruments: {clock: {part: cube}}\n"
    room = made(tmp_path, things, put_away="")
    assert room.warnings and room.instrument("clock").face == pytest.approx((-1, 0, 0))


def test_without_a_seat_a_face_has_to_be_stated(tmp_path):
    with pytest.raises(InputError, match=r"environment.yaml:6:3: .*state 'face'"):
        made(tmp_path, "instruments:\n  clock: {part: dial}\n", seat="")


@pytest.mark.parametrize(
    ("name", "how"),
    [
        ("trainer_reach", Same(mirrored=True, unit="in", y_up=True)),
        ("car_driver", Same(turned=37.0, moved=(3.0, -2.0, 0.5), order=5)),
    ],
)
def test_faces_of_an_environment_written_otherwise_are_the_same(tmp_path, name, how):
    path = ROOT / "studies" / f"{name}.yaml"
    one = load_study(path).environment
    other = load_study(write_same(path, tmp_path, how)).environment
    assert one.instruments
    for kind, normal in (("instrument", "face"), ("mirror", "normal")):
        for here in getattr(one, f"{kind}s"):
            there = getattr(other, kind)(here.name)
            np.testing.assert_allclose(there.at, how.place(here.at, 1.0), atol=1e-6)
            face = how.way(getattr(here, normal))
            np.testing.assert_allclose(getattr(there, normal), face, atol=1e-6)
    for here in one.mirrors:
        there = other.mirror(here.name)
        np.testing.assert_allclose(there.aims, how.place(here.aims, 1.0), atol=1e-9)
        assert there.radius == pytest.approx(here.radius) and there.field == here.field
    heights = {here.name: here.characters for here in one.instruments}
    assert {there.name: there.characters for there in other.instruments} == pytest.approx(heights)
