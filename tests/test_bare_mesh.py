"""Bare meshes are looked at as they are: one or several, with what was assumed of them."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh
from PIL import Image

from tests.made_seat import corners, obj_text
from tests.one_arm_cab import write_cab
from workbench import load_environment
from workbench.cli import main
from workbench.draw.display_options import parse_display_options
from workbench.errors import InputError
from workbench.files.bare_mesh import read_bare
from workbench.files.meshes.reading import read_mesh

CAR = {
    "floor": corners((0, -0.6, 0.0), (2, 0.6, 0.1)),
    "roof": corners((0.2, -0.6, 1.2), (1.6, 0.6, 1.3)),
    "front_light": corners((1.9, -0.6, 0.4), (2.0, 0.6, 0.5)),
    "rear_light": corners((0.0, -0.6, 0.4), (0.1, 0.6, 0.5)),
}


def written(folder, name, parts):
    path = folder / name
    path.write_text(obj_text(parts))
    return path


def told(capsys, *arguments):
    """(exit code, stdout, stderr) of a command line."""
    capsys.readouterr()
    code = main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return code, out, err


def box(bare, part):
    corners = bare.environment.triangle_corners(bare.environment.part_index(part)).reshape(-1, 3)
    return corners.min(axis=0), corners.max(axis=0)


def test_a_bare_mesh_is_drawn_and_what_was_assumed_is_said(tmp_path, capsys):
    mesh = written(tmp_path, "car.obj", CAR)
    code, out, err = told(capsys, "render", mesh, "-o", tmp_path / "car.png", "--size", 100)
    assert code == 0 and out.strip().endswith("car.png")
    assert "assumed: unit m: by its size, 2 m long" in err
    assert "assumed: up z: by the names roof and floor" in err
    assert "assumed: forward x: by the names front_light and rear_light" in err
    assert np.ptp(np.asarray(Image.open(tmp_path / "car.png").convert("L"))) > 50


def test_what_is_stated_is_not_assumed(tmp_path, capsys):
    mesh = written(tmp_path, "car.obj", CAR)
    given = ("--units", "ft", "--up", "y", "--forward", "-z")
    code, out, _ = told(capsys, "inspect", mesh, *given, "--json")
    found = json.loads(out)
    assert code == 0 and found["assumed"] == []
    assert (found["metres"], found["up"], found["forward"]) == (0.3048, "y", "-z")
    _, _, err = told(capsys, "render", mesh, *given, "-o", tmp_path / "car.png", "--size", 50)
    assert err == ""


def test_inspecting_and_describing_take_a_mesh_alike(tmp_path):
    from workbench.study.describe.state import open_place

    mesh = written(tmp_path, "car.obj", CAR)
    (frame,) = read_bare([mesh]).frames
    (described,) = open_place(mesh).start.says["meshes"]
    assert (frame.length.value, frame.up.value, frame.forward.value) == tuple(
        described[key] for key in ("length", "up", "forward")
    )


def test_several_files_stand_in_one_frame_and_those_that_are_moved_beside_it(tmp_path, capsys):
    car = written(tmp_path, "car.obj", CAR)
    wheel = written(tmp_path, "wheel.obj", {"rim": corners((1, 0, 0), (1.3, 0.1, 0.3))})
    both = read_bare([car, wheel])
    assert both.environment.parts == (*CAR, "rim")
    np.testing.assert_allclose(box(both, "rim")[0], (1, 0, 0))
    moved = read_bare([car, f"{wheel}@-400mm,0,0.25"])
    np.testing.assert_allclose(box(moved, "rim"), ((0.6, 0, 0.25), (0.9, 0.1, 0.55)))
    code, out, _ = told(capsys, "inspect", car, f"{wheel}@-400mm,0,0.25")
    assert code == 0 and "5 parts" in out
    shown = tmp_path / "both.png"
    assert told(capsys, "render", car, wheel, "-o", shown, "--size", 50)[0] == 0


def test_parts_of_one_name_in_two_files_are_told_apart(tmp_path):
    one = written(tmp_path, "cab.obj", CAR)
    two = written(tmp_path, "pod.obj", {"floor": corners((3, 0, 0), (4, 1, 0.1))})
    assert read_bare([one, two]).environment.parts == (*CAR, "pod_floor")
    (tmp_path / "environment.yaml").write_text(
        "environment: both\nlength: m\nmeshes:\n"
        "  - {file: cab.obj, length: m, up: z, forward: x}\n"
        "  - {file: pod.obj, length: m, up: z, forward: x}\n"
    )
    with pytest.raises(InputError, match=r"another name, join: \{pod_floor: \[floor\]\}"):
        load_environment(tmp_path)


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("400,0,250", "400 is farther than 60 m: is a unit missing, 400mm?"),
        ("0.4,0", "three lengths are needed"),
        ("left,0,0", "a length such as '450 mm'"),
    ],
)
def test_a_place_that_is_none_is_refused_with_what_is_right(tmp_path, place, words):
    mesh = written(tmp_path, "car.obj", CAR)
    with pytest.raises(InputError, match=r"written FILE@X,Y,Z") as caught:
        read_bare([f"{mesh}@{place}"])
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("name", "way"), [("cab.ac", "Blender"), ("cab.CATPart", ".step"), ("cab.zip", "unpack")]
)
def test_a_mesh_of_another_kind_is_refused_with_the_way_on(tmp_path, name, way):
    (tmp_path / name).write_text("AC3Db")
    with pytest.raises(InputError, match=f"is not a mesh format; .*{way}.*valid: .obj"):
        read_mesh(tmp_path / name)


def test_running_a_mesh_or_an_environment_says_what_comes_before(tmp_path, capsys):
    mesh = written(tmp_path, "car.obj", CAR)
    code, _, err = told(capsys, "run", mesh)
    assert code == 3 and f"'workbench live {mesh}'" in err
    (tmp_path / "environment.yaml").write_text(
        "environment: car\nlength: m\nmeshes: [{file: car.obj, length: m, up: z, forward: x}]\n"
    )
    for source in (tmp_path, tmp_path / "environment.yaml"):
        code, _, err = told(capsys, "run", source)
        assert code == 3 and f"'workbench new {source}'" in err


def test_a_result_is_inspected_with_the_lines_of_its_run(tmp_path, capsys):
    folder = tmp_path / "out"
    study = write_cab(tmp_path)
    _, ran, _ = told(capsys, "run", study, "--out", folder)
    code, out, _ = told(capsys, "inspect", folder)
    assert code == 0 and out.splitlines()[0].startswith(f"{folder}: result of study ")
    assert ran.splitlines()[:-1] == out.splitlines()[-len(ran.splitlines()) + 1 :]
    assert f"its page: {folder / 'report.html'}" in out
    _, as_json, _ = told(capsys, "inspect", folder / "result.json", "--json")
    assert json.loads(as_json) == json.loads((folder / "result.json").read_text())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["render", "trainer", "car.obj", "-o", "a.png"], "only where all are mesh files"),
        (["render", "car.obj", "-o", "a.png", "--case", "x"], "is a mesh: leave out --case"),
        (["render", "trainer", "-o", "a.png", "--units", "mm"], "--units and --forward are for"),
        (["inspect", "trainer", "car.obj"], "only where all are mesh files"),
        (["inspect"], "name a mesh, an environment or a result"),
    ],
)
def test_sources_and_options_that_do_not_go_together_are_refused(capsys, arguments, words):
    code, _, err = told(capsys, *arguments)
    assert code == 2 and words in err


def test_a_soup_of_loose_triangles_is_called_one(tmp_path):
    away = np.random.default_rng(0).uniform(0.0, 2.0, (120, 3))
    rows = [f"v {x:.4f} {y:.4f} {z:.4f}" for a in away for x, y, z in a + 0.1 * np.eye(3)]
    faces = [f"f {k} {k + 1} {k + 2}" for k in range(1, 361, 3)]
    (tmp_path / "cab.obj").write_text("\n".join(["o cab", *rows, *faces, ""]))
    said = read_bare([tmp_path / "cab.obj"]).environment.warnings
    assert said[0].startswith("part cab is a soup of loose triangles: distances hold")
    whole = written(tmp_path, "car.obj", CAR)
    assert not any("soup" in line for line in read_bare([whole]).environment.warnings)


def test_the_corner_view_has_one_name_and_its_old_one_is_taken(tmp_path):
    out = tmp_path / "a.png"
    views = [
        parse_display_options(out, view=name).view for name in (None, "corner", "three_quarter")
    ]
    assert views == ["corner"] * 3


def test_a_stated_forward_axis_along_which_left_and_right_are_alike_is_doubted(tmp_path):
    """A wedge that rises along x; glTF says z is forward. Turned by 90 degrees about y it is right."""
    wedge = trimesh.Trimesh(
        [[0, 0, 0], [4, 0, 0], [4, 1, 0], [0, 0, 2], [4, 0, 2], [4, 1, 2]],
        [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [0, 3, 5], [0, 5, 2]],
    )
    file = tmp_path / "a.glb"
    file.write_bytes(wedge.export(file_type="glb"))
    (said,) = read_bare([str(file)]).assumed
    assert said.startswith(
        "forward z (not sure): its format says so, but left and right are alike along z"
    )
    assert read_bare([str(file)], forward="x").assumed == ()
    wedge.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
    file.write_bytes(wedge.export(file_type="glb"))
    assert read_bare([str(file)]).assumed == ()


def person():
    """A round shape 1.7 m long, as a person is: alike left and right (x), its nose to the front (y)."""
    trunk = trimesh.creation.icosphere(4)
    trunk.apply_scale([0.25, 0.15, 0.85])
    nose = trimesh.creation.icosphere(3, 0.05).apply_translation([0, 0.13, 0.7])
    return trimesh.util.concatenate([trunk, nose])


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("turns", range(4))
def test_whether_a_person_stands_or_lies_no_shape_tells_and_it_is_said(tmp_path, axis, turns):
    mesh = person()
    way = np.eye(3)[axis]
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.5 * np.pi * turns, way))
    mesh.export(tmp_path / "person.stl")
    _, up, forward = read_bare([str(tmp_path / "person.stl")]).assumed
    long = "xyz"[int(np.argmax(mesh.extents))]
    assert up.startswith(f"up {long} (not sure): a round shape, as of a person, is taken to stand")
    assert forward.startswith("forward ") and "(not sure)" in forward


def test_a_few_parts_that_dwarf_all_others_say_nothing_of_unit_and_axes(tmp_path):
    """A cone of light of 200 m on a cab of 2 m: with it a unit of 10 mm would be likely."""
    cab = {
        f"box_{k}": corners((0.2 * k, -0.6, 0.0), (0.2 * k + 0.1, 0.6, 0.9)) for k in range(1, 10)
    }
    cab |= {name: corners((0, -0.7, 0), (0.1, 0.7, 1.2)) for name in "abcdefghij"}
    cab |= {
        "floor": corners((0, -0.7, -0.05), (2, 0.7, 0)),
        "roof": corners((0, -0.7, 1.2), (2, 0.7, 1.25)),
    }
    cone = {"LightCone": corners((2, -100, -100), (202, 100, 100))}
    frames = []
    for name, parts in (("cab.obj", cab), ("lit.obj", cab | cone)):
        (tmp_path / name).write_text(obj_text(parts, up="y", forward="-x"))
        frames.append(read_bare([tmp_path / name]))
    one, lit = (bare.frames[0] for bare in frames)
    assert (one.length.value, one.up.value) == ("m", "y")
    assert (lit.length, lit.up, lit.forward) == (one.length, one.up, one.forward)
    words = "'LightCone': 100 times as large as all other parts together"
    assert any(words in line for line in frames[1].environment.warnings)
    says = (
        "environment: cab\nlength: mm\nmeshes: [{file: lit.obj, length: m, up: y, forward: -x}]\n"
    )
    (tmp_path / "environment.yaml").write_text(says)
    with pytest.raises(InputError, match=r"is 202 m large.*drop: \[LightCone\]"):
        load_environment(tmp_path)
    (tmp_path / "environment.yaml").write_text(says.replace("}", ", drop: [LightCone]}"))
    assert len(load_environment(tmp_path).parts) == len(cab)


def test_several_files_are_said_to_be_taken_in_one_frame_with_their_places(tmp_path):
    one = written(tmp_path, "cabin.obj", CAR)
    two = written(tmp_path, "panel.obj", {"dial": corners((-0.4, -0.1, 0.5), (-0.3, 0.1, 0.7))})
    (said,) = [words for words in read_bare([one, two]).assumed if "frame" in words]
    assert said.startswith(
        "all files in one frame: cabin.obj x 0 to 2000, y -600 to 600, z 0 to 1300 mm; "
        "panel.obj x -400 to -300, y -100 to 100, z 500 to 700 mm; "
    )
    assert not [w for w in read_bare([one, f"{two}@1,0,0"]).assumed if "frame" in w]
