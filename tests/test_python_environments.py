"""Environments in Python: parts with their meshes, things elsewhere, meshes of trimesh."""

from __future__ import annotations

import copy
import pickle
import re

import numpy as np
import pytest

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
        (3, "displacements: expected a mapping of names to displacements [m], got 3"),
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
    assert back.parts == toy.parts and back.warnings == ()
    for name in toy.parts:
        one, two = back.part(name), toy.part(name)
        np.testing.assert_array_equal(one.vertices[one.faces], two.vertices[two.faces])
    assert toy.part("panel").to_trimesh().is_watertight
