"""Files for other programs: closed solids of the right size, glTF scenes with the body's tree and
its motion."""

from __future__ import annotations

import io
import json
import math
import zipfile

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.test_draw import boxes, spheres_body
from workbench import InputError, UsageError
from workbench.body.surface import body_solid
from workbench.files.exports.gltf import Figure, glb_bytes
from workbench.files.exports.solids import stl_bytes, threemf_bytes
from workbench.model.quaternions import exponential, from_matrices, multiply, rotate, slerp

WARM = (0.8, 0.6, 0.4)


def loaded(data, kind):
    return trimesh.load(io.BytesIO(data), file_type=kind)


def document(glb):
    assert glb[:4] == b"glTF" and int.from_bytes(glb[8:12], "little") == len(glb)
    size = int.from_bytes(glb[12:16], "little")
    return json.loads(glb[20 : 20 + size])


def named(glb, name):
    return next(node for node in document(glb)["nodes"] if node["name"] == name)


def test_the_solid_of_one_sphere_has_its_volume_and_lies_inside_it_by_no_more_than_the_tolerance():
    points, faces = body_solid(spheres_body([0.3, 0, 0], 0.1).placed, tolerance=5e-4)
    mesh = trimesh.Trimesh(points, faces)
    assert mesh.is_watertight and mesh.volume == pytest.approx(4 / 3 * math.pi * 1e-3, rel=0.015)
    depth = 0.1 - np.linalg.norm(mesh.triangles_center - [0.3, 0, 0], axis=1)
    assert depth.min() >= -1e-7 and depth.max() <= 5e-4 + 1e-7


def test_two_overlapping_spheres_are_one_solid_of_the_union_s_volume():
    points, faces = body_solid(
        spheres_body([[0, 0, 0], [0.1, 0, 0]], [0.1, 0.1]).placed, tolerance=1e-4
    )
    lens = math.pi * (4 * 0.1 + 0.1) * (2 * 0.1 - 0.1) ** 2 / 12  # of two spheres r = 0.1, d = 0.1
    mesh = trimesh.Trimesh(points, faces)
    assert mesh.body_count == 1 and mesh.is_watertight
    assert mesh.volume == pytest.approx(2 * 4 / 3 * math.pi * 1e-3 - lens, rel=0.005)


def test_the_whole_body_is_a_closed_solid_as_stl_and_3mf(bubbleman, library):
    placed, names = library
    surface = body_solid(placed, names.index("seated"), tolerance=2e-3)
    stl = loaded(stl_bytes({"man": surface}), "stl")
    threemf = threemf_bytes({"man": surface})
    stl.merge_vertices()
    assert stl.is_watertight and stl.is_winding_consistent and stl.volume > 0
    assert 0.06e9 < stl.volume < 0.08e9  # cubic millimetres: some 70 litres
    scene = loaded(threemf, "3mf")
    whole = trimesh.util.concatenate(list(scene.geometry.values()))
    assert whole.is_watertight and whole.volume == pytest.approx(stl.volume, rel=1e-5)


def test_a_solid_stays_within_the_logical_window_and_refuses_what_it_cannot_do(one_arm):
    placed = wb.place(one_arm, wb.pose(one_arm, {}), window=["UPPER"])
    points, _ = body_solid(placed)
    assert points[:, 2].min() == pytest.approx(
        -0.34, abs=5e-4
    )  # lowest sphere of the upper arm, not of the hand
    with pytest.raises(UsageError, match=r"0\.001 to 100 mm is needed"):
        body_solid(placed, tolerance=0.0)
    far = wb.place(one_arm, wb.pose(one_arm, {}))
    with pytest.raises(InputError, match="no spheres"):
        body_solid(wb.Placed(one_arm, far.world_from_segment, far.centres * np.nan, far.window))


def test_solids_are_the_same_bytes_twice_and_names_are_text():
    surface = body_solid(spheres_body([0, 0, 0], 0.1).placed)
    names = {'<a "b">\x07&': surface, "other": surface}
    assert threemf_bytes(names) == threemf_bytes(names) and stl_bytes(names) == stl_bytes(names)
    model = zipfile.ZipFile(io.BytesIO(threemf_bytes(names))).read("3D/3dmodel.model").decode()
    assert "&lt;a" in model and model.count("<object") == 2 and "\x07" not in model
    assert len(loaded(stl_bytes(names), "stl").faces) == 2 * len(surface[1])


def test_a_posed_body_is_a_tree_of_named_segments_with_one_mesh_for_all_spheres(one_arm):
    glb = glb_bytes(
        [Figure("arm", wb.place(one_arm, wb.pose(one_arm, {"ELBOW": {"flexion": 90}})), WARM)]
    )
    tree = document(glb)
    upper = named(glb, "upper arm")
    lower = named(glb, "lower arm")
    assert tree["nodes"].index(lower) in upper["children"]
    assert named(glb, "fingertip")["scale"] == [0.02] * 3
    assert len(tree["meshes"]) == 1 and sum("mesh" in node for node in tree["nodes"]) == 10
    assert "animations" not in tree


def test_every_sphere_of_the_file_is_where_the_body_has_it(bubbleman, library):
    placed, names = library
    pose = names.index("seated")
    scene = loaded(glb_bytes([Figure("man", placed, WARM)], pose=pose), "glb")
    at = sorted(
        tuple(np.round(scene.graph[node][0][:3, 3], 5)) for node in scene.graph.nodes_geometry
    )
    want = sorted(tuple(np.round(c[[1, 2, 0]], 5)) for c in placed.centres[pose])  # y up, z forward
    assert np.allclose(at, want, atol=2e-5)


def test_a_motion_is_an_animation_of_what_moves_and_only_that(one_arm):
    placed = wb.place(
        one_arm, wb.join_poses([wb.pose(one_arm, {"ELBOW": {"flexion": a}}) for a in (0, 45, 90)])
    )
    glb = glb_bytes([Figure("arm", placed, WARM)], times=np.array([1.0, 1.5, 2.0]))
    tree = document(glb)
    moved = {
        (tree["nodes"][c["target"]["node"]]["name"], c["target"]["path"])
        for c in tree["animations"][0]["channels"]
    }
    assert moved == {
        ("lower arm", "rotation"),
        ("lower arm", "translation"),
    }  # about the elbow, not its own middle
    clock = tree["accessors"][tree["animations"][0]["samplers"][0]["input"]]
    assert (clock["min"], clock["max"], clock["count"]) == ([0.0], [1.0], 3)


def test_spheres_that_share_a_twist_move_in_their_segment(bubbleman):
    poses = wb.join_poses([wb.pose(bubbleman, {"RW": {"pronation": a}}) for a in (0, 40)])
    tree = document(
        glb_bytes([Figure("man", wb.place(bubbleman, poses), WARM)], times=np.array([0.0, 1.0]))
    )
    moved = [tree["nodes"][c["target"]["node"]]["name"] for c in tree["animations"][0]["channels"]]
    assert any(name.startswith("RLA ") for name in moved)


def test_a_still_motion_has_no_animation_and_an_environment_has_its_parts(one_arm, unit_box):
    placed = wb.place(one_arm, wb.join_poses([wb.pose(one_arm, {})] * 2))
    glb = glb_bytes([Figure("arm", placed, WARM)], unit_box, times=np.array([0.0, 1.0]))
    assert "animations" not in document(glb)
    box = loaded(glb, "glb").geometry["box"]
    assert box.volume == pytest.approx(1.0) and named(glb, "box")
    glass = document(glb_bytes([], boxes([[0, 0, 0], [1, 1, 1]], see_through=True)))
    assert [m.get("alphaMode") for m in glass["materials"]] == [None, "BLEND"]


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ([0.0, 0.0], "must be finite and rise"),
        ([0.0], "2 poses, the motion 1"),
        ([0.0, np.nan], "finite"),
    ],
)
def test_times_that_cannot_be_are_refused(one_arm, times, message):
    placed = wb.place(one_arm, wb.join_poses([wb.pose(one_arm, {})] * 2))
    with pytest.raises(InputError, match=message):
        glb_bytes([Figure("arm", placed, WARM)], times=np.array(times))


def test_glb_is_the_same_bytes_twice_and_aligned(one_arm):
    figure = Figure("<arm>", wb.place(one_arm, wb.pose(one_arm, {})), WARM)
    first = glb_bytes([figure])
    assert first == glb_bytes([figure]) and len(first) % 4 == 0
    tree = document(first)
    assert all(view["byteOffset"] % 4 == 0 for view in tree["bufferViews"])
    assert all(node.get("children") != [] for node in tree["nodes"])


vectors = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)


@given(vectors, vectors)
def test_matrices_and_quaternions_turn_alike(turn, vector):
    q = exponential(turn)
    matrix = np.stack([rotate(q, axis) for axis in np.eye(3)], axis=-1)
    assert rotate(from_matrices(matrix), vector) == pytest.approx(matrix @ vector, abs=1e-9)


@given(vectors, vectors, st.floats(0, 1))
def test_slerp_goes_from_one_to_the_other_at_a_constant_rate(turn, step, share):
    a = exponential(turn)
    b = multiply(exponential(turn), exponential(step))
    at = slerp(a, b, np.array(share))
    apart = [2 * math.acos(min(abs(float(p @ q)), 1.0)) for p, q in ((a, at), (a, b))]
    assert apart[0] == pytest.approx(share * apart[1], abs=1e-6)
    assert abs(float(slerp(a, b, np.array(1.0)) @ b)) == pytest.approx(1.0)
