"""Environments in Python: parts with their meshes, things elsewhere, meshes of trimesh."""

from __future__ import annotations

import copy
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

import workbench as wb
from tests.toy_cockpit import write_toy


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    folder = tmp_path_factory.mktemp("toy")
    write_toy(folder)
    return wb.load_environment(folder / "environments" / "toy")


def test_a_part_has_its_mesh_its_size_and_its_controls(toy):
    panel = toy.part("panel")
    assert panel.faces.shape == (12, 3) and panel.vertices.shape == (8, 3)
    np.testing.assert_allclose(panel.bounds, [[1.5, -0.3, 0.6], [1.52, 0.3, 0.9]])
    assert panel.area == pytest.approx(2 * (0.02 * 0.6 + 0.02 * 0.3 + 0.6 * 0.3))
    assert panel.solid and not panel.hidden and panel.controls == ("knob", "near")
    assert repr(panel) == "Part(panel: solid of 12 triangles, 20 x 600 x 300 mm)"
    assert toy.part("roof").controls == ()


def test_the_names_of_parts_are_a_tuple_that_gives_parts_by_name(toy):
    assert toy.parts == ("pan", "back", "panel", "roof") and toy.parts[1:3] == ("back", "panel")
    for other in (toy, pickle.loads(pickle.dumps(toy)), copy.deepcopy(toy)):
        assert repr(other.parts["panel"]) == repr(toy.part("panel"))
    assert len(pickle.dumps(toy.parts)) < 500
    for ask in (toy.part, toy.parts.__getitem__):
        with pytest.raises(wb.InputError, match=r"no part 'pannel'; did you mean 'panel'\?"):
            ask("pannel")


def test_what_is_moved_stands_elsewhere_and_the_rest_stays(toy):
    by = np.array([0.02, -0.01, 0.0])
    moved = toy.moved({"pan*l": by})
    np.testing.assert_allclose(moved.part("panel").vertices, toy.part("panel").vertices + by)
    np.testing.assert_array_equal(moved.part("roof").vertices, toy.part("roof").vertices)
    for before, after in zip(toy.controls, moved.controls, strict=True):
        np.testing.assert_allclose(after.at, before.at + by)
    alone = toy.moved({"knob": ("20 mm", 0, "1 cm")})
    assert alone.controls[0].at == pytest.approx((0.72, -0.18, 0.86))
    assert alone.controls[1] == toy.controls[1]
    np.testing.assert_array_equal(alone.vertices, toy.vertices)


@pytest.mark.parametrize(
    ("moved", "message"),
    [
        ({"knbo": (0, 0, 0)}, "environment toy has no part and no control 'knbo'; did you mean"),
        ({"knob": (0, 0)}, "displacements['knob']: expected three lengths x, y, z"),
        ({"knob": ("a", 0, 0)}, "displacements['knob']: expected three lengths x, y, z"),
        ({"knob": (np.nan, 0, 0)}, "displacements['knob']: expected three lengths x, y, z"),
        ({"knob": (20_000, 0, 0)}, "displacements['knob']: expected three lengths x, y, z"),
        ({"pan": (0, 0, 1)}, "part 'pan' goes with seat 'pilot': give a role in it a 'position'"),
        ({"panel": (0, 0, 1), "panel*": (0, 0, 1)}, "'panel' is moved by 'panel' and by 'panel*'"),
        (3, "displacements: expected a mapping of a text to anything, got 3"),
    ],
)
def test_a_move_that_is_none_says_what_is_wrong(toy, moved, message):
    with pytest.raises(wb.WorkbenchError, match=re.escape(message)):
        toy.moved(moved)


def test_meshes_of_trimesh_go_out_and_come_back_as_they_were(toy):
    scene = toy.to_trimesh()
    assert scene.units == "m" and list(scene.geometry) == list(toy.parts)
    assert scene.geometry["panel"].volume == pytest.approx(0.02 * 0.6 * 0.3)
    back = wb.environment_from_mesh(scene, up="z", forward="x")
    assert back.parts == toy.parts
    for name in toy.parts:
        one, two = back.part(name), toy.part(name)
        np.testing.assert_array_equal(one.vertices[one.faces], two.vertices[two.faces])
    assert toy.part("panel").to_trimesh().is_watertight


CABIN = {
    "floor": ((2.4, 1.4, 0.1), (0, 0, 0)),
    "roof": ((1.2, 1.4, 0.1), (-0.4, 0, 1.4)),
    "front_panel": ((0.1, 1.4, 0.5), (1.1, 0, 0.6)),
    "rear_wall": ((0.1, 1.4, 1.4), (-1.2, 0, 0.7)),
}
"""Boxes by name: size and centre [m]."""


def cabin(*, turned=None, scale=1.0):
    """A cabin whose names say where up and forward are."""
    scene = trimesh.Scene()
    for name, (size, centre) in CABIN.items():
        box = trimesh.creation.box(size, trimesh.transformations.translation_matrix(centre))
        box.apply_transform(np.eye(4) if turned is None else turned)
        box.apply_scale(scale)
        scene.add_geometry(box, geom_name=name)
    return scene


Y_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""x stays, y becomes up."""


def test_a_mesh_file_is_an_environment_and_what_was_guessed_is_told(tmp_path):
    cabin(turned=Y_UP, scale=1000.0).export(tmp_path / "cabin.obj")
    with pytest.warns(
        UserWarning, match=r"cabin\.obj: assumed, as nothing says it: unit mm \(not sure\): "
    ):
        found = wb.load_environment(tmp_path / "cabin.obj")
    np.testing.assert_allclose(found.bounds, [[-1.25, -0.7, -0.05], [1.2, 0.7, 1.45]], atol=1e-6)
    told = [line for line in found.warnings if "cabin.obj: assumed: " in line]
    assert [line.split("assumed: ")[1].split(":")[0] for line in told] == [
        "unit mm (not sure)",
        "up y",
        "forward x",
    ]
    assert repr(found).startswith("Environment(cabin: ") and "warnings)" in repr(found)


def test_a_folder_beside_the_program_is_found_by_its_bare_name(tmp_path, monkeypatch):
    write_toy(tmp_path)
    monkeypatch.chdir(tmp_path / "environments")
    assert wb.load_environment("toy").control("knob").part == "panel"
    with pytest.raises(wb.InputError, match="no control 'knbo'; did you mean 'knob'"):
        wb.load_environment(Path("toy")).control("knbo")


def test_what_is_stated_is_not_guessed(tmp_path):
    path = tmp_path / "cabin.obj"
    cabin(scale=1000.0).export(path)
    found = wb.load_environment(str(path), length="mm", up="z", forward="-x")
    assert not any("assumed" in line for line in found.warnings)
    np.testing.assert_allclose(found.bounds, [[-1.2, -0.7, -0.05], [1.25, 0.7, 1.45]], atol=1e-6)
    with pytest.raises(wb.UsageError, match="up: 'w' is not an axis"):
        wb.load_environment(path, length="mm", up="w", forward="x")
    with pytest.raises(wb.UsageError, match="up: belongs to a mesh file"):
        wb.load_environment("trainer", up="z")
    with pytest.raises(wb.InputError, match="no such file"):
        wb.load_environment(tmp_path / "nowhere.obj")


def test_a_mesh_of_trimesh_stands_where_an_environment_is_asked_for(one_arm):
    placed = wb.place(one_arm, wb.pose(one_arm, {}, position=(0, 0, 0.8)))
    stated = wb.environment_from_mesh(cabin(), length="m", up="z", forward="x")
    with pytest.warns(UserWarning, match=r"assumed, .*unit m: .*up z: .*forward x: ") as told:
        found = wb.clearance(placed, cabin())
    assert told[0].filename == __file__
    np.testing.assert_allclose(found, wb.clearance(placed, stated), atol=1e-9)
    with pytest.warns(UserWarning, match="assumed"):
        assert wb.scene_of(cabin()).environment.parts == stated.parts


def test_what_goes_out_to_trimesh_says_its_axes(toy, one_arm):
    placed = wb.place(one_arm, wb.pose(one_arm, {}))
    direct = wb.clearance(placed, toy)
    np.testing.assert_array_equal(wb.clearance(placed, toy.to_trimesh()), direct)
    panel = wb.clearance(placed, toy.part("roof").to_trimesh())
    np.testing.assert_allclose(panel[:, :, 0], direct[:, :, 3], atol=1e-12)


def test_a_study_of_a_mesh_repeats_what_was_assumed():
    with pytest.warns(UserWarning, match="assumed"):
        study = wb.study(
            cabin(),
            people={"guest": {"body": "bubbleman", "stand": {"on": (0, 0, 0.05)}}},
            cases=[{"name": "upright", "people": {"guest": {"posture": "standing"}}}],
            criteria=[{"name": "room", "check": "clearance", "parts": ["roof"], "at_least": 0.0}],
        )
    assert [line for line in study.warnings if "assumed: unit m" in line]
    assert study.environment.parts == tuple(CABIN)


def test_a_study_file_that_names_a_mesh_is_told_what_to_do(tmp_path):
    path = write_toy(tmp_path)
    path.write_text(path.read_text().replace("environment: toy", "environment: ../toy.obj"))
    with pytest.raises(wb.InputError, match=r"is a bare mesh; `workbench live \.\./toy\.obj`"):
        wb.load_study(path)
