"""Mesh files: what is read, and what is refused in one clear line."""

from __future__ import annotations

import base64
import io
import json
import os
import random
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.conftest import SHARED, real_input
from tests.step_files import step_assembly
from workbench import InputError, MissingPartError, UsageError
from workbench.files.meshes import parts as mesh_parts
from workbench.files.meshes import reading
from workbench.files.meshes import threemf as threemf_module
from workbench.files.meshes.mesh_validation import validate_part
from workbench.files.meshes.parts import triangulate
from workbench.files.meshes.reading import axes_rotation, extent, read_mesh
from workbench.files.names import unique_names
from workbench.files.yaml_text import read_yaml

ENVIRONMENTS = SHARED / "environments"
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def box(size=(2.0, 4.0, 6.0)):
    return trimesh.creation.box(extents=size)


def written(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def refused(path: Path, *words: str) -> str:
    with pytest.raises(InputError) as caught:
        read_mesh(path)
    message = str(caught.value)
    assert "\n" not in message and str(path.parent) in message
    assert all(word in message for word in words), message
    return message


def real(name: str) -> Path:
    return real_input(SHARED / name)


def dae(body: str, *, head: str = "", unit: str = '<unit meter="0.0254"/>') -> str:
    """A COLLADA file with one triangle, geometry #tri, and the given visual scene."""
    return f"""<?xml version="1.0"?>{head}<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
    <asset>{unit}</asset><library_geometries><geometry id="tri"><mesh>
    <source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
    <accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
    <param name="Z" type="float"/></accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
    </mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s">{body}</visual_scene>
    </library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


@pytest.mark.parametrize("form", ["stl", "stl_ascii", "ply", "off", "obj", "glb", "3mf"])
def test_a_box_is_a_closed_box_in_every_format(tmp_path, form):
    content = (
        trimesh.Scene({"seat": box()}).export(file_type=form)
        if form in ("glb", "3mf")
        else box().export(file_type=form)
    )
    raw = read_mesh(written(tmp_path, f"seat.{form[:3]}", content))
    assert [part.name for part in raw.parts] in (["seat"], ["geometry"], ["world"])
    assert extent(raw.parts) == pytest.approx([2, 4, 6])
    assert len(raw.parts[0].vertices) == 8 and validate_part(raw.parts[0])[1].closed


@pytest.mark.parametrize(
    ("form", "metres"), [("stl", None), ("ply", None), ("off", None), ("obj", None), ("glb", 1.0)]
)
def test_only_some_formats_tell_their_unit(tmp_path, form, metres):
    content = (
        trimesh.Scene([box()]).export(file_type="glb")
        if form == "glb"
        else box().export(file_type=form)
    )
    assert read_mesh(written(tmp_path, f"a.{form}", content)).metres == metres


def test_objects_and_groups_of_an_obj_keep_their_names(tmp_path):
    text = (
        TRIANGLE
        + "o left seat\nf 1 2 3\no desk\ng desk_top\nf 1 2 3\ng leg\nf 3 2 1\ng desk_top\nf 2 3 1\n"
    )
    raw = read_mesh(written(tmp_path, "a.obj", text))
    assert [(part.name, len(part.faces)) for part in raw.parts] == [
        ("left seat", 1),
        ("desk_top", 2),
        ("desk_leg", 1),
    ]


def test_negative_indices_of_an_obj_count_from_where_they_stand(tmp_path):
    text = f"o a\n{TRIANGLE}f -3 -2 -1\no b\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf -3 -2 -1\n"
    raw = read_mesh(written(tmp_path, "a.obj", text))
    assert [float(part.vertices[0, 2]) for part in raw.parts] == [0, 5]


def test_a_missing_material_file_does_not_matter(tmp_path):
    text = f"mtllib gone.mtl\nusemtl wood\n{TRIANGLE}f 1/1/1 2/2/2 3/3/3\n"
    assert len(read_mesh(written(tmp_path, "a.obj", text)).parts[0].faces) == 1


@pytest.mark.parametrize(
    "where", ["../a.mtl", "/etc/passwd", "http://a/b.mtl", "C:\\a.mtl", "sub/../../a.mtl"]
)
def test_materials_of_an_obj_may_lie_anywhere_since_they_are_never_opened(tmp_path, where):
    raw = read_mesh(written(tmp_path, "a.obj", f"mtllib {where}\n{TRIANGLE}f 1 2 3\n"))
    assert len(raw.parts[0].faces) == 1


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("f 1 2 9", "vertex 9"),
        ("f 1 2", "three vertices"),
        ("f 0 1 2", "three vertices"),
        ("f a b c", "whole numbers"),
        ("v 1 2", "three numbers"),
        ("v 1 2 x", "three numbers"),
        ("hello", "not a line of an OBJ"),
        ("call b.obj", "another"),
        ("f -9 1 2", "three vertices"),
        ("v nan 0 0\nf 1 2 4", "not finite"),
        ("v 1e999 0 0\nf 1 2 4", "not finite"),
    ],
)
def test_a_broken_line_of_an_obj_is_named(tmp_path, line, word):
    refused(written(tmp_path, "a.obj", f"{TRIANGLE}f 1 2 3\n{line}\n"), word)


def test_curves_of_an_obj_are_told_to_be_left_out(tmp_path):
    raw = read_mesh(written(tmp_path, "a.obj", f"{TRIANGLE}f 1 2 3\nl 1 2\n"))
    assert raw.notes == ("1 lines of curves or points are not surfaces and are left out",)


def test_a_text_stl_with_two_solids_has_two_parts():
    raw = read_mesh(real("nasty/assimp/triangle_with_two_solids.stl"))
    assert [part.name for part in raw.parts] == ["testTriangle_1", "testTriangle_2"]


def test_a_text_stl_whose_second_solid_has_no_end_is_refused(tmp_path):
    text = box().export(file_type="stl_ascii")
    refused(written(tmp_path, "a.stl", text + text.rpartition("endsolid")[0]), "cut short")


def test_a_warning_of_the_collada_library_does_not_make_a_file_broken(tmp_path, monkeypatch):
    import collada

    read = collada.Collada

    def warning(*arguments, **options):
        warnings.warn(
            "setting the shape on an array has been deprecated", DeprecationWarning, stacklevel=1
        )
        return read(*arguments, **options)

    monkeypatch.setattr(collada, "Collada", warning)
    node = '<node name="desk"><instance_geometry url="#tri"/></node>'
    assert [part.name for part in read_mesh(written(tmp_path, "a.dae", dae(node))).parts] == [
        "desk"
    ]


def test_a_node_of_a_dae_gives_its_name_and_transforms_and_the_file_its_unit(tmp_path):
    node = '<node name="desk"><translate>0 0 7</translate><instance_geometry url="#tri"/></node>'
    raw = read_mesh(written(tmp_path, "a.dae", dae(node + node)))
    assert raw.metres == 0.0254 and [part.name for part in raw.parts] == ["desk", "desk_2"]
    assert raw.parts[0].vertices[:, 2].tolist() == [7, 7, 7]


def test_a_node_of_a_dae_that_looks_at_a_point_stands_at_the_eye_and_turns_its_minus_z_there(
    tmp_path,
):
    """From 7 along x toward the origin: the node's z is along x, its y up, its x along -z."""
    node = '<node><lookat>7 0 0  0 0 0  0 1 0</lookat><instance_geometry url="#tri"/></node>'
    plain = '<node><instance_geometry url="#tri"/></node>'
    found, own = (
        read_mesh(written(tmp_path, name, dae(text))).parts[0].vertices
        for name, text in (("a.dae", node), ("b.dae", plain))
    )
    assert found == pytest.approx(own @ np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]]) + [7, 0, 0])
    for wrong in ("1 2 3", "0 1 0  0 0 0  0 1 0"):
        refused(
            written(tmp_path, "c.dae", dae(node.replace("7 0 0  0 0 0  0 1 0", wrong))), "lookat"
        )


def test_a_mirrored_instance_keeps_its_outside_outside(tmp_path):
    node = '<node name="a"><scale>1 1 -1</scale><instance_geometry url="#tri"/></node>'
    part = read_mesh(written(tmp_path, "a.dae", dae(node))).parts[0]
    a, b, c = part.vertices[part.faces[0]]
    assert np.cross(b - a, c - a)[2] == -1


@pytest.mark.parametrize(
    ("body", "word"),
    [
        ('<node><instance_controller url="#skin"/></node>', "skinned"),
        ('<node><instance_geometry url="../b.dae#tri"/></node>', "another file"),
        ('<node><instance_geometry url="#gone"/></node>', "not found"),
        ("", "no surface"),
    ],
)
def test_a_dae_that_would_come_out_empty_or_in_part_is_refused(tmp_path, body, word):
    refused(written(tmp_path, "a.dae", dae(body)), word)


def test_a_dae_that_grows_without_bound_is_refused_at_once(tmp_path):
    bomb = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10 if k else "lol"}">' for k in range(12))
    text = dae("<node>&l11;</node>", head=f"<!DOCTYPE COLLADA [{bomb}]>")
    refused(written(tmp_path, "a.dae", text), "DOCTYPE")
    refused(
        written(
            tmp_path, "b.dae", text.replace('"1.0"', '"1.0" encoding="UTF-16"').encode("utf-16")
        ),
        "DOCTYPE",
    )


def test_the_upward_axis_of_a_dae_is_read_in_any_case_and_an_unknown_one_is_refused(tmp_path):
    node = '<node><instance_geometry url="#tri"/></node>'
    text = dae(node, unit="<up_axis>z_up</up_axis>")
    assert read_mesh(written(tmp_path, "a.dae", text)).up == "z"
    refused(written(tmp_path, "b.dae", text.replace("z_up", "W_UP")), "up_axis")


@pytest.mark.parametrize("meter", ["x", "0", "-1", "nan", "1e9"])
def test_a_dae_with_a_senseless_unit_is_refused(tmp_path, meter):
    node = '<node><instance_geometry url="#tri"/></node>'
    refused(written(tmp_path, "a.dae", dae(node, unit=f'<unit meter="{meter}"/>')), "unit")


def gltf(**change) -> str:
    """A glTF file with one box, its buffer inside."""
    files = trimesh.Scene({"box": box()}).export(file_type="gltf")
    tree = json.loads(files["model.gltf"])
    for buffer in tree["buffers"]:
        buffer["uri"] = (
            "data:application/octet-stream;base64,"
            + base64.b64encode(files[buffer["uri"]]).decode()
        )
    return json.dumps(tree | change)


@pytest.mark.parametrize(
    "uri", ["../b.bin", "%2e%2e/b.bin", "/b.bin", "https://a/b.bin", "file:///b.bin"]
)
def test_a_gltf_that_refers_outside_its_folder_is_refused(tmp_path, uri):
    text = gltf(buffers=[{"uri": uri, "byteLength": 840}])
    refused(written(tmp_path, "a.gltf", text), "outside its own folder")


def test_a_gltf_that_cannot_be_read_whole_is_refused(tmp_path):
    assert len(read_mesh(written(tmp_path, "a.gltf", gltf())).parts) == 1
    refused(
        written(tmp_path, "b.gltf", gltf(extensionsUsed=["KHR_draco_mesh_compression"])),
        "compressed",
    )
    refused(
        written(tmp_path, "c.gltf", gltf(buffers=[{"uri": "gone.bin", "byteLength": 840}])),
        "gone.bin",
    )
    refused(
        written(
            tmp_path,
            "d.gltf",
            gltf(accessors=[{"count": 10**12, "componentType": 5126, "type": "VEC3"}]),
        ),
        "does not hold",
    )


def test_both_instances_of_a_gltf_mesh_are_there():
    raw = read_mesh(real("environments/trimesh/CesiumMilkTruck.glb"))
    assert [part.name for part in raw.parts] == ["Cesium_Milk_Truck", "Wheels", "Wheels_2"]
    assert extent(raw.parts) == pytest.approx([4.869, 2.583, 2.792], abs=1e-3)


def test_a_3mf_is_in_its_own_unit_and_must_not_unpack_without_bound(tmp_path, monkeypatch):
    raw = read_mesh(
        written(tmp_path, "a.3mf", trimesh.Scene({"box": box()}).export(file_type="3mf"))
    )
    assert raw.metres == 0.001
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", b"\0" * 2**24)
    monkeypatch.setattr(threemf_module, "_MAX_UNPACKED", 2**23)
    refused(written(tmp_path, "b.3mf", packed.getvalue()), "unpacks to")


@pytest.mark.parametrize("form", ["ascii 1.0", "binary_little_endian 1.0", "binary_big_endian 1.0"])
def test_a_ply_may_mix_triangles_and_quadrilaterals(tmp_path, form):
    head = f"ply\nformat {form}\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0)]
    faces = [(1, 4, 2), (0, 1, 2, 3)]
    order = ">" if "big" in form else "<"
    body = b"".join(np.array(p, order + "f4").tobytes() for p in points)
    body += b"".join(bytes([len(f)]) + np.array(f, order + "i4").tobytes() for f in faces)
    text = "".join(
        " ".join(map(str, row)) + "\n" for row in [*points, *[(len(f), *f) for f in faces]]
    ).encode()
    raw = read_mesh(
        written(tmp_path, "a.ply", head.encode() + (text if form.startswith("a") else body))
    )
    assert len(raw.parts[0].faces) == 3 and extent(raw.parts) == pytest.approx([2, 1, 0])


def test_the_step_part_is_five_inches_long():
    pytest.importorskip("cascadio")
    raw = read_mesh(real("environments/trimesh/featuretype.STEP"))
    assert raw.metres == 1 and extent(raw.parts) == pytest.approx(
        [0.127, 0.0635, 0.034925], abs=1e-5
    )


def test_step_without_cascadio_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setattr("workbench.files.meshes.step.find_spec", lambda name: None)
    with pytest.raises(MissingPartError, match="pip install cascadio"):
        read_mesh(written(tmp_path, "a.step", "ISO-10303-21;\nEND-ISO-10303-21;\n"))


def test_a_broken_step_file_cannot_end_the_workbench(tmp_path):
    pytest.importorskip("cascadio")
    text = real("environments/trimesh/featuretype.STEP").read_bytes()
    refused(written(tmp_path, "a.step", text[: len(text) // 2]), "cut short")
    refused(written(tmp_path, "b.step", text[:20000] + text[60000:70000] + text[-30:]), "STEP")


def test_what_is_not_there_or_not_a_mesh_is_one_line(tmp_path):
    refused(tmp_path / "gone.stl", "no such file")
    refused(written(tmp_path, "a.stl", b""), "is empty")
    refused(written(tmp_path, "a.xyz", b"0 0 0"), ".xyz", ".obj")
    (tmp_path / "folder.obj").mkdir()
    refused(tmp_path / "folder.obj", "folder")


@pytest.mark.parametrize("ending", sorted(reading.FORMATS))
def test_binary_garbage_and_text_are_refused_in_every_format(tmp_path, ending):
    garbage = random.Random(7).randbytes(5000)
    for name, content in (
        ("a", garbage),
        ("b", b"hello, this is text\n" * 20),
        ("c", box().export(file_type="glb")[:-9]),
    ):
        refused(written(tmp_path, name + ending, content))


@pytest.mark.parametrize(
    "form", ["stl", "stl_ascii", "ply", "off", "obj", "glb", "3mf", "dae", "gltf"]
)
def test_damaged_files_are_read_or_refused_and_never_end_in_a_traceback(tmp_path, form):
    chance = random.Random(form)
    whole = {"dae": lambda: dae('<node><instance_geometry url="#tri"/></node>'), "gltf": gltf}.get(
        form,
        lambda: (
            trimesh.Scene([box()]).export(file_type=form)
            if form in ("glb", "3mf")
            else box().export(file_type=form)
        ),
    )()
    data = whole.encode() if isinstance(whole, str) else whole
    for _ in range(60):
        broken = bytearray(
            data[: chance.randrange(1, len(data) + 1)] if chance.random() < 0.3 else data
        )
        for _ in range(chance.choice([0, 1, 8])):
            broken[chance.randrange(len(broken))] = chance.randrange(256)
        try:
            assert read_mesh(
                written(
                    tmp_path, f"a.{form[:4]}" if form == "gltf" else f"a.{form[:3]}", bytes(broken)
                )
            ).parts
        except InputError as error:
            assert "\n" not in str(error)


def test_a_mesh_too_large_for_the_memory_says_what_it_needs(tmp_path, monkeypatch):
    monkeypatch.setattr(reading, "free_memory", lambda: 100_000)
    refused(written(tmp_path, "a.stl", b"\0" * 2**20), "1 MiB", "of memory")


def test_axes_put_right_are_never_mirrored():
    names = ["x", "y", "z", "-x", "-y", "-z"]
    for up in names:
        for forward in (name for name in names if name[-1] != up[-1]):
            assert np.linalg.det(axes_rotation(up, forward)) == pytest.approx(1)
    assert (axes_rotation("y", "-z") @ [0, 1, 0]).tolist() == [0, 0, 1]
    assert (axes_rotation("y", "-z") @ [0, 0, -1]).tolist() == [1, 0, 0]


@pytest.mark.parametrize(("up", "forward"), [("y", "y"), ("y", "-y"), ("w", "x"), ("z", "+x")])
def test_axes_that_span_no_frame_are_refused(up, forward):
    with pytest.raises(UsageError):
        axes_rotation(up, forward)


def test_names_become_unique_in_order():
    assert unique_names(["seat", "seat", "", "seat_2", "seat"], "mesh") == [
        "seat",
        "seat_3",
        "mesh",
        "seat_2",
        "seat_4",
    ]


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("polaris_ranger_ev/polaris.dae", 107.467),
        ("prius_cardemo/hybrid_body.obj", 461.829),
        ("gazebo_control_console/console.dae", 2625.193),
        ("iss_astrobee/astrobee_iss/meshes/jpm.dae", 10.175),
        ("assistive_gym/wheelchair__wheelchair_permobil_reduced_compressed.obj", 8.25),
        ("gazebo_suv/suv.obj", 83.669),
        ("iss_astrobee/astrobee_handrail_30/meshes/handrail_30.dae", 0.783),
        ("gazebo_bus_stop/bench.dae", 1.6),
    ],
)
def test_real_files_have_the_size_they_should_in_their_own_units(name, size):
    assert extent(read_mesh(real(f"environments/{name}")).parts).max() == pytest.approx(
        size, abs=1e-3
    )


@pytest.mark.parametrize("uri", ["../a.png", "/a.png", "https://a/b.png", "file:///b.png"])
def test_images_of_a_gltf_may_lie_anywhere_since_they_are_never_opened(tmp_path, uri):
    assert read_mesh(written(tmp_path, "a.gltf", gltf(images=[{"uri": uri}]))).parts


def points_gltf(
    values: np.ndarray, kind: int, *, nodes=({"mesh": 0},), accessor=None, views=(), **change
) -> str:
    """A glTF file of one triangle, its corners as given numbers; further buffer views are bytes
    after the corners."""
    blobs = [values.tobytes(), *views]
    starts = np.cumsum([0, *(len(blob) for blob in blobs)])
    body = base64.b64encode(b"".join(blobs)).decode()
    tree = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": list(nodes),
        "meshes": [{"name": "tri", "primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": kind, "count": 3, "type": "VEC3"} | (accessor or {})
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": int(a), "byteLength": len(b)}
            for a, b in zip(starts, blobs, strict=False)
        ],
        "buffers": [{"uri": f"data:;base64,{body}", "byteLength": int(starts[-1])}],
    }
    return json.dumps(tree | change)


CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype="<f4")


@pytest.mark.parametrize(
    ("dtype", "kind"), [("<u2", 5123), ("<i2", 5122), ("u1", 5121), ("i1", 5120)]
)
def test_quantised_positions_have_their_true_size(tmp_path, dtype, kind):
    rows = np.zeros((3, 4), dtype=dtype)  # a row is filled up to four numbers
    rows[:, :3] = CORNERS * np.iinfo(dtype).max
    text = points_gltf(
        rows, kind, accessor={"normalized": True}, extensionsRequired=["KHR_mesh_quantization"]
    )
    tree = json.loads(text)
    tree["bufferViews"][0]["byteStride"] = rows.itemsize * 4
    raw = read_mesh(written(tmp_path, "a.gltf", json.dumps(tree)))
    assert extent(raw.parts).tolist() == [1, 1, 0]


def test_sparse_accessors_move_the_corners_that_they_name(tmp_path):
    sparse = {
        "count": 1,
        "indices": {"bufferView": 1, "componentType": 5123},
        "values": {"bufferView": 2},
    }
    views = (np.array([1], dtype="<u2").tobytes(), np.array([7, 0, 0], dtype="<f4").tobytes())
    raw = read_mesh(
        written(
            tmp_path, "a.gltf", points_gltf(CORNERS, 5126, accessor={"sparse": sparse}, views=views)
        )
    )
    assert sorted(raw.parts[0].vertices[:, 0].tolist()) == [0, 0, 7]


def test_all_copies_of_an_instanced_mesh_are_there(tmp_path):
    copies = np.array([[0, 0, 0], [5, 0, 0], [9, 0, 0]], dtype="<f4")
    text = points_gltf(
        CORNERS,
        5126,
        views=(copies.tobytes(),),
        nodes=[
            {
                "name": "seat",
                "mesh": 0,
                "scale": [2, 2, 2],
                "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}},
            }
        ],
        extensionsRequired=["EXT_mesh_gpu_instancing"],
        accessors=[
            {"bufferView": k, "componentType": 5126, "count": 3, "type": "VEC3"} for k in (0, 1)
        ],
    )
    raw = read_mesh(written(tmp_path, "a.gltf", text))
    assert [part.name for part in raw.parts] == ["seat", "seat_2", "seat_3"]
    assert [part.vertices[:, 0].min() for part in raw.parts] == [0, 10, 18]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"extensionsRequired": ["VENDOR_new_shape"]}, ("requires VENDOR_new_shape", "not read")),
        (
            {"extensionsRequired": ["EXT_meshopt_compression"]},
            ("EXT_meshopt_compression", "compressed"),
        ),
        ({"asset": {"version": "1.0"}}, ("glTF 1.0", "only 2.0")),
        (
            {"buffers": [{"uri": "body.bin", "byteLength": 36}]},
            ("'body.bin' is missing", "belongs beside it"),
        ),
        (
            {"buffers": [{"uri": "data:;base64,AAAA", "byteLength": 36}]},
            ("buffer 0", "cut short", "3 bytes"),
        ),
        ({"nodes": [{"children": [0]}]}, ("node 0 stands in two places",)),
    ],
)
def test_a_gltf_that_would_be_read_wrongly_is_refused_by_name(tmp_path, change, words):
    refused(written(tmp_path, "a.gltf", points_gltf(CORNERS, 5126, **change)), *words)


def test_a_gltf_may_require_what_changes_no_surface(tmp_path):
    text = points_gltf(
        CORNERS, 5126, extensionsRequired=["KHR_materials_unlit", "KHR_texture_transform"]
    )
    assert read_mesh(written(tmp_path, "a.gltf", text)).parts


def test_a_binary_gltf_of_version_1_is_refused(tmp_path):
    data = bytearray(trimesh.Scene([box()]).export(file_type="glb"))
    data[4] = 1
    refused(written(tmp_path, "a.glb", bytes(data)), "glTF 1.0")


@pytest.mark.parametrize(
    ("mode", "faces"), [(5, [[0, 1, 2], [2, 1, 3]]), (6, [[0, 1, 2], [0, 2, 3]])]
)
def test_strips_and_fans_of_a_gltf_are_triangles(tmp_path, mode, faces):
    square = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], dtype="<f4")
    mesh = {"primitives": [{"attributes": {"POSITION": 0}, "mode": mode}]}
    part = read_mesh(
        written(tmp_path, "a.gltf", points_gltf(square, 5126, accessor={"count": 4}, meshes=[mesh]))
    ).parts[0]
    assert np.array_equal(part.vertices[part.faces], square[np.array(faces)])


def test_names_of_nodes_that_are_numbers_are_kept(tmp_path):
    nodes = [{"name": "12", "mesh": 0}, {"name": "7", "mesh": 0}, {"mesh": 0}]
    raw = read_mesh(written(tmp_path, "a.gltf", points_gltf(CORNERS, 5126, nodes=nodes)))
    assert [part.name for part in raw.parts] == ["12", "7", "tri"]


def test_3000_nested_nodes_of_a_gltf_are_read(tmp_path):
    nodes = [{"children": [k + 1], "translation": [0, 0, 1]} for k in range(3000)] + [{"mesh": 0}]
    raw = read_mesh(
        written(
            tmp_path, "a.gltf", points_gltf(CORNERS, 5126, nodes=nodes, scenes=[{"nodes": [0]}])
        )
    )
    assert raw.parts[0].vertices[0, 2] == 3000


def test_names_of_an_obj_keep_what_follows_a_number_sign(tmp_path):
    text = f"{TRIANGLE}o seat #1\nf 1 2 3  # a face\no seat #2\nf 3 2 1\n"
    raw = read_mesh(written(tmp_path, "a.obj", text))
    assert [part.name for part in raw.parts] == ["seat #1", "seat #2"]


@pytest.mark.parametrize("index", [10**17, 10**19, 10**40, -(10**40)])
def test_a_huge_index_in_a_face_of_an_obj_is_one_line(tmp_path, index):
    refused(written(tmp_path, "a.obj", f"{TRIANGLE}f 1 2 {index}\n"), "a.obj:4")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.obj", f"o a\n{TRIANGLE}f 1 2 3\n"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        ),
        (
            "a.stl",
            "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
            "endsolid a\n",
        ),
        ("a.dae", dae('<node><instance_geometry url="#tri"/></node>')),
        ("a.gltf", points_gltf(CORNERS, 5126)),
    ],
)
def test_a_byte_order_mark_before_the_text_makes_no_difference(tmp_path, name, text):
    raw = read_mesh(written(tmp_path, name, b"\xef\xbb\xbf" + text.encode()))
    assert [len(part.faces) for part in raw.parts] == [1]


def test_control_characters_in_names_become_text(tmp_path):
    raw = read_mesh(
        written(tmp_path, "a.obj", f"{TRIANGLE}o seat\x1b[2J\x9b\nf 1 2 3\no \u202eback\nf 1 2 3\n")
    )
    assert [part.name for part in raw.parts] == ["seat\\u001b[2J\\u009b", "\\u202eback"]


DOOR = """<library_nodes><node id="door" name="door"><instance_geometry url="#tri"/>
    <node name="handle"><instance_geometry url="#tri"/></node></node></library_nodes>"""


def test_nodes_placed_twice_in_a_dae_are_named_as_where_they_are_placed(tmp_path):
    body = "".join(
        f'<node name="{side}"><instance_node url="#door"/></node>' for side in ("left", "right")
    )
    text = dae(body).replace("<library_visual_scenes>", DOOR + "<library_visual_scenes>")
    raw = read_mesh(written(tmp_path, "a.dae", text))
    assert [part.name for part in raw.parts] == ["left", "left_handle", "right", "right_handle"]


def test_a_node_placed_by_one_without_a_name_keeps_its_own(tmp_path):
    body = '<node><instance_node url="#door"/></node>'
    text = dae(body).replace("<library_visual_scenes>", DOOR + "<library_visual_scenes>")
    assert [part.name for part in read_mesh(written(tmp_path, "a.dae", text)).parts] == [
        "door",
        "handle",
    ]


@pytest.mark.parametrize(
    ("body", "word"),
    [
        ("<node>" * 3000 + "</node>" * 3000, "deeper than 200 levels"),
        ('<node><skew>45 0 1 0 1 0 0</skew><instance_geometry url="#tri"/></node>', "<skew>"),
    ],
)
def test_a_dae_that_ended_in_a_traceback_is_one_line(tmp_path, body, word):
    refused(written(tmp_path, "a.dae", dae(body)), word)


def doubling_dae(levels: int) -> str:
    nodes = "".join(
        f'<node id="n{k}">{f"<instance_node url={chr(34)}#n{k - 1}{chr(34)}/>" * 2}</node>'
        for k in range(1, levels)
    )
    library = f'<library_nodes><node id="n0"><instance_geometry url="#tri"/></node>{nodes}</library_nodes>'
    body = f'<node><instance_node url="#n{levels - 1}"/></node>'
    return dae(body).replace("<library_visual_scenes>", library + "<library_visual_scenes>")


def threemf(model: str) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", f'<model unit="meter" xmlns="m">{model}</model>')
    return packed.getvalue()


TRIANGLE_3MF = """<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/>
    </vertices><triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>"""


def doubling_threemf(levels: int) -> bytes:
    objects = "".join(
        f'<object id="{k}"><components>{f"<component objectid={chr(34)}{k - 1}{chr(34)}/>" * 2}'
        "</components></object>"
        for k in range(1, levels)
    )
    return threemf(
        f'<object id="0">{TRIANGLE_3MF}</object>{objects}<build><item objectid="{levels - 1}"/></build>'
    )


def test_copies_of_copies_are_counted_before_they_are_made(tmp_path):
    assert len(read_mesh(written(tmp_path, "a.dae", doubling_dae(4))).parts) == 8
    assert len(read_mesh(written(tmp_path, "a.3mf", doubling_threemf(4))).parts) == 8
    refused(written(tmp_path, "b.dae", doubling_dae(40)), "more than")
    refused(written(tmp_path, "b.3mf", doubling_threemf(40)), "more than")


def test_copies_that_do_not_fit_into_the_memory_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh_parts, "free_memory", lambda: 5000)
    nodes = [{"mesh": 0}] * 5
    refused(
        written(tmp_path, "a.gltf", points_gltf(CORNERS, 5126, nodes=nodes)),
        "places 5 triangles",
        "of memory",
    )
    refused(written(tmp_path, "a.dae", doubling_dae(5)), "places 16 triangles")
    refused(written(tmp_path, "a.3mf", doubling_threemf(5)), "places 16 triangles")


def test_objects_of_a_3mf_are_placed_named_and_none_is_lost_without_a_word(tmp_path):
    objects = f'<object id="1" name="seat">{TRIANGLE_3MF}</object><object id="2" name="cut">{TRIANGLE_3MF}</object>'
    objects += '<object id="3" name="row"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 5"/>'
    build = '</components></object><build><item objectid="3"/><item objectid="1"/></build>'
    raw = read_mesh(written(tmp_path, "a.3mf", threemf(objects + build)))
    assert [(part.name, part.vertices[0, 2]) for part in raw.parts] == [("seat", 5), ("seat_2", 0)]
    assert raw.metres == 1 and raw.notes == (
        "1 objects are not part of the build and are left out",
    )


@pytest.mark.parametrize(
    ("model", "word"),
    [
        ('<build><item objectid="9"/></build>', "'9' is named and not there"),
        (
            f'<object id="1">{TRIANGLE_3MF.replace("v3=" + chr(34) + "2", "v3=" + chr(34) + "3")}</object>'
            '<build><item objectid="1"/></build>',
            "vertex 3",
        ),
        (
            '<object id="1"><components><component objectid="1"/></components></object><build><item objectid="1"/></build>',
            "within themselves",
        ),
    ],
)
def test_a_3mf_that_names_what_is_not_there_is_refused(tmp_path, model, word):
    refused(written(tmp_path, "a.3mf", threemf(model)), word)


def test_a_3mf_that_unpacks_to_far_more_than_meshes_do_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(threemf_module, "_RATIO_FREE_SIZE", 2**16)
    refused(written(tmp_path, "a.3mf", threemf(" " * 2**20)), "made to fill the memory")


def star(corners: int) -> np.ndarray:
    """(n, 2) corners of a star, every second one near its middle."""
    angle = np.linspace(0, 2 * np.pi, corners, endpoint=False)
    return (
        np.column_stack([np.cos(angle), np.sin(angle)])
        * np.where(np.arange(corners) % 2, 0.3, 1.0)[:, None]
    )


def signed_areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a = points[faces[:, 0]]
    b = points[faces[:, 1]]
    c = points[faces[:, 2]]
    return ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2


SQUARE_HOLE = np.array(
    [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)], dtype=float
)


@pytest.mark.parametrize(
    "outline", [star(8), star(2000), star(9)[::-1], SQUARE_HOLE], ids=["8", "2000", "cw", "hole"]
)
def test_a_face_of_many_corners_is_covered_once_and_nothing_else_is(outline):
    flat = np.column_stack([outline, np.full(len(outline), 3.0)])
    faces = triangulate(flat, np.arange(len(flat)), np.array([len(flat)]))
    areas = signed_areas(outline, faces)
    x, y = outline.T
    area = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
    assert len(faces) == len(outline) - 2
    assert areas.sum() == pytest.approx(area) and (areas * np.sign(area) > -1e-12).all()


def test_a_face_of_more_corners_than_can_be_cut_in_time_is_refused(tmp_path):
    ring = " ".join(str(k + 1) for k in range(10_001))
    text = "".join(f"v {x} {y} 0\n" for x, y in star(10_001))
    refused(written(tmp_path, "a.obj", f"{text}f {ring}\n"), "a.obj:10002", "10001 corners")


def test_pipes_and_devices_are_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "a.obj")
    refused(tmp_path / "a.obj", "a pipe, a device or a socket")
    (tmp_path / "b.obj").symlink_to("/dev/zero")
    refused(tmp_path / "b.obj", "a pipe, a device or a socket")


def test_an_stl_file_shorter_than_its_head_is_refused(tmp_path):
    refused(written(tmp_path, "a.stl", b"x" * 34), "not an STL file")


STRIPS = """ply
format ascii 1.0
element vertex 6
property float x
property float y
property float z
element tristrips 1
property list int int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
1 1 0
0 2 0
1 2 0
10 0 1 2 3 -1 2 3 4 5 5
"""


def test_strips_of_triangles_in_a_ply_are_read_with_one_winding(tmp_path):
    """Two triangles of each strip; the last one of the second has two corners only."""
    part = read_mesh(written(tmp_path, "a.ply", STRIPS)).parts[0]
    a, b, c = (part.vertices[part.faces[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)[:, 2] / 2
    assert area.tolist() == [0.5, 0.5, 0.5, 0.5]


@pytest.mark.parametrize("more", [b"\0", b"COLOR=\xff\xff", b"\n" * 300])
def test_bytes_behind_a_binary_stl_are_left_out_and_told(tmp_path, more):
    data = box().export(file_type="stl")
    for head in (data[:80], b"solid exported by X".ljust(80)):
        raw = read_mesh(written(tmp_path, "a.stl", head + data[80:] + more))
        assert len(raw.parts[0].faces) == 12
        assert raw.notes == (f"{len(more)} bytes behind its 12 triangles are left out",)
    refused(written(tmp_path, "b.stl", b"solid".ljust(80) + data[80:-1]), "cut short")


def test_names_of_parts_are_the_same_in_every_unicode_form(tmp_path):
    """e with an accent is one character or two; a file's and a study's may differ."""
    assert unique_names(["sie\u0300ge", "si\u00e8ge"], "x") == ["si\u00e8ge", "si\u00e8ge_2"]
    (tmp_path / "u\u0308.yaml").write_text("a: 1")
    text = "part: 'sie\u0300ge'\nsie\u0300ge: 1\nfile: u\u0308.yaml\n"
    document = read_yaml(written(tmp_path, "a.yaml", text))
    assert document.value == {"part": "si\u00e8ge", "si\u00e8ge": 1, "file": "u\u0308.yaml"}


@pytest.mark.parametrize(
    ("form", "far", "told"), [("stl", 1e6, "0.062 apart, 1/96"), ("obj", 1e6, "10 apart")]
)
def test_a_mesh_too_far_from_the_origin_for_its_numbers_is_remarked_on(tmp_path, form, far, told):
    """Single precision at 1,000,000 counts in sixteenths; a text of six digits in tens."""
    mesh = box()
    assert not read_mesh(written(tmp_path, f"a.{form}", mesh.export(file_type=form))).notes
    points = mesh.vertices * (1 if form == "stl" else 10) + [far, 0, 0]
    data = trimesh.Trimesh(points, mesh.faces, process=False).export(file_type=form)
    if form == "obj":
        vertices = "\n".join(f"v {x:g} {y:g} {z:g}" for x, y, z in points)
        data = vertices + "\nf 1 2 3\nf 4 5 6\n"
    (note,) = read_mesh(written(tmp_path, f"b.{form}", data)).notes
    assert told in note and "move it to the origin" in note


def test_parts_of_a_step_file_have_the_names_of_products_where_occurrences_have_none(tmp_path):
    pytest.importorskip("cascadio")
    parts = {"seat": ("=>[0:1:1:2]", ""), "desk": ("NAUO1",), "lamp": ("left lamp",)}
    raw = read_mesh(written(tmp_path, "a.step", step_assembly(parts)))
    assert [part.name for part in raw.parts] == ["seat", "seat_2", "desk", "left lamp"]
    assert [part.vertices[:, 0].min() for part in raw.parts] == pytest.approx([0, 1, 2, 3])
