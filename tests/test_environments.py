"""Environments: from a folder with environment.yaml and meshes, or from a bare mesh; their rules
and their faults."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

import workbench as wb
from tests.conftest import SHARED, real_input
from workbench import InputError, UsageError, environment_from_mesh, load_environment
from workbench.cli import main
from workbench.files.environments import environment_files
from workbench.files.mesh_report import inspect_environment, inspect_mesh
from workbench.files.meshes.mesh_validation import validate_part
from workbench.files.meshes.parts import RawPart
from workbench.model.surroundings import move_parts

CAB = """environment: box_cab
length: mm
meshes:
  - {file: cab.obj, length: m, up: z, forward: x}
"""
SEATS = """seats:
  left:
    srp: [0, 0, 450]
    back_angle: 13
    cushion_angle: 6
    cushion: {part: pan, segments: [LT, LUL], depth: 20}
    back: {part: pan, segments: all, depth: 15}
    travel: {forward: [-70, 70], up: [-25, "2 in"]}
    moves: ["p*"]
"""


def solid(size=(1.0, 1.0, 1.0), at=(0.0, 0.0, 0.0)):
    mesh = trimesh.creation.box(extents=size)
    mesh.apply_translation(at)
    return mesh


def part(mesh, name="box"):
    return RawPart(name, np.array(mesh.vertices), np.array(mesh.faces))


def obj(**meshes) -> str:
    """An OBJ file with one object for each mesh."""
    lines = []
    count = 1
    for name, mesh in meshes.items():
        lines += [f"o {name}", *("v {:.9g} {:.9g} {:.9g}".format(*v) for v in mesh.vertices)]
        lines += ["f {} {} {}".format(*(f + count)) for f in mesh.faces]
        count += len(mesh.vertices)
    return "\n".join(lines) + "\n"


def cab(folder: Path, text: str = "", *, head: str = CAB) -> Path:
    """A cab 2 m long: floor and pan, and an open sheet."""
    sheet = solid((0.5, 0.5, 0.5), (0, 0, 2))
    sheet.update_faces(sheet.face_normals[:, 0] < 0.5)
    (folder / "cab.obj").write_text(
        obj(floor=solid((2, 1, 0.1)), pan=solid((0.5, 0.5, 0.1), (0, 0, 0.4)), sheet=sheet)
    )
    (folder / "environment.yaml").write_text(head + text)
    return folder


def faults(folder: Path, text: str = "", *, head: str = CAB) -> tuple[str, ...]:
    with pytest.raises(InputError) as caught:
        load_environment(cab(folder, text, head=head))
    assert all("environment.yaml:" in line for line in caught.value.problems)
    return caught.value.problems


def real(name: str) -> Path:
    return real_input(SHARED / "environments" / name)


def corners(environment, name):
    polygons = environment.polygons(environment.part_index(name))
    first, last = environment.triangle_start[[polygons.start, polygons.stop]]
    return environment.vertices[environment.triangles[first:last].ravel()]


def test_a_folder_and_its_yaml_file_are_the_same_environment(tmp_path):
    one = load_environment(cab(tmp_path))
    other = load_environment(tmp_path / "environment.yaml")
    assert one.parts == other.parts == ("floor", "pan", "sheet")
    assert one.part_start.tolist() == [0, 6, 12, 17]
    assert one.solid.tolist() == [True, True, False]
    assert one.bounds.tolist() == [[-1, -0.5, -0.05], [1, 0.5, 2.25]]


def test_an_environment_is_made_of_its_yaml_file_and_its_meshes(tmp_path):
    assert [path.name for path in environment_files(cab(tmp_path))] == [
        "environment.yaml",
        "cab.obj",
    ]


def test_what_is_open_is_told_with_its_edges(tmp_path):
    assert load_environment(cab(tmp_path)).warnings == (
        "part sheet: 4 open edges: a surface, not a solid; what lies wholly inside is not noticed, "
        "and a depth is a lower bound",
    )


def test_rules_are_by_name_before_pattern(tmp_path):
    text = 'parts:\n  pan: {solid: false}\n  "*": {see_through: true, allow: [{segments: all, depth: 45}]}\n'
    environment = load_environment(cab(tmp_path, text))
    assert environment.see_through.tolist() == [True, False, True]
    assert environment.solid.tolist() == [True, False, False]
    assert [(a.part, a.segments, a.depth) for a in environment.allowances] == [
        (0, ("all",), 0.045),
        (2, ("all",), 0.045),
    ]


def test_a_seat_is_in_metres_and_radians_and_its_patterns_are_names(tmp_path):
    seat = load_environment(cab(tmp_path, SEATS)).seat("left")
    assert seat.srp == pytest.approx((0, 0, 0.45)) and seat.back_angle == pytest.approx(
        np.radians(13)
    )
    assert seat.travel_up == pytest.approx((-0.025, 0.0508)) and seat.moves == ("pan",)
    assert seat.back.segments == ("all",) and seat.cushion.depth == pytest.approx(0.02)


def allowed(environment) -> list[tuple[str, tuple[str, ...], float]]:
    return [(environment.parts[a.part], a.segments, a.depth) for a in environment.allowances]


def test_a_grip_enters_the_part_of_its_control_by_what_it_does(tmp_path):
    text = (
        "controls:\n"
        "  lever: {at: [0, 0, 450], grip: grasp, zone: 1, part: pan}\n"
        "  pedal: {at: [0, 0, 450], grip: foot, zone: 1, part: pan}\n"
        "  button: {at: [0, 0, 2250], grip: push, zone: 1, part: sheet}\n"
        "  free: {at: [0, 0, 450], grip: grasp, zone: 1}\n"
    )
    assert allowed(load_environment(cab(tmp_path, text))) == [
        ("pan", ("LHN", "RHN"), 0.03),
        ("pan", ("LF", "RF"), 0.025),
        ("sheet", ("LHN", "RHN"), 0.015),
    ]


def test_a_rule_for_hands_takes_the_place_of_what_a_grip_does(tmp_path):
    text = (
        "parts: {pan: {allow: [{segments: [RHN], depth: 5}]}}\n"
        "controls:\n"
        "  lever: {at: [0, 0, 450], grip: grasp, zone: 1, part: pan}\n"
        "  pedal: {at: [0, 0, 450], grip: foot, zone: 1, part: pan}\n"
    )
    assert allowed(load_environment(cab(tmp_path, text))) == [
        ("pan", ("RHN",), 0.005),
        ("pan", ("LF", "RF"), 0.025),
    ]


def test_a_hand_may_not_enter_a_panel_that_a_control_is_on(tmp_path):
    text = "controls:\n  lever: {at: [0, 0, 50], grip: grasp, zone: 1, part: floor}\n"
    assert allowed(load_environment(cab(tmp_path, text))) == []


def test_points_and_controls_are_there(tmp_path):
    text = "points: {eye: [0, 0, 1200]}\ncontrols:\n  lever: {at: [300, 0, 700], grip: grasp, zone: 2, part: pan}\n"
    environment = load_environment(cab(tmp_path, text))
    assert environment.points == {"eye": pytest.approx((0, 0, 1.2))}
    assert (
        environment.controls[0].grip,
        environment.controls[0].zone,
        environment.controls[0].part,
    ) == (
        "grasp",
        2,
        "pan",
    )


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("parts: {pann: {hidden: true}}\n", 5, "did you mean 'pan'?"),
        ('parts: {"left_*": {hidden: true}}\n', 5, "no part 'left_"),
        ("parts: {pan: {hiden: true}}\n", 5, "did you mean 'hidden'?"),
        ("parts:\n  pan: {allow: [{segments: all, depth: -3}]}\n", 6, "depth"),
        ("parts:\n  sheet: {solid: true}\n", 6, "4 of its edges are open"),
        (SEATS.replace("[p*]", "[x*]").replace('["p*"]', '["x*"]'), 13, "no part 'x*'"),
        (
            SEATS.replace("part: pan, segments: all", "part: pen, segments: all"),
            11,
            "did you mean 'pan'?",
        ),
        (SEATS.replace("[-70, 70]", "[70, -70]"), 12, "least"),
        (SEATS.replace("back_angle: 13", "back_angle: 130"), 8, "back_angle"),
        ("controls: {k: {at: [0, 0, 0], grip: bite, zone: 2}}\n", 5, "grip"),
        ("controls: {k: {at: [0, 0, 0], grip: push, zone: 4}}\n", 5, "zone"),
        ("controls: {k: {at: [0, 0, 0], grip: push, zone: 1, part: lid}}\n", 5, "no part 'lid'"),
        ("points: {eye: [0, .nan, 0]}\n", 5, "eye"),
    ],
)
def test_a_wrong_value_is_named_with_its_line(tmp_path, text, line, words):
    (problem,) = faults(tmp_path, text)
    assert f"environment.yaml:{line}:" in problem and words in problem


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        ("file: gone.obj, length: m, up: z, forward: x", "no such file"),
        ("file: ../cab.obj, length: m, up: z, forward: x", "in the folder"),
        ("file: cab.obj, up: z, forward: x", "does not say its unit"),
        (
            "file: cab.obj, length: mm, up: z, forward: x",
            "0.0023 m in mm, 0.023 m in cm, 2.3 m in m",
        ),
        ("file: cab.obj, length: km, up: z, forward: x", "units: mm, cm, m, in, ft"),
        ("file: cab.obj, length: m, up: z, forward: -z", "right angles"),
        ("file: cab.obj, length: m, up: up, forward: x", "up"),
        ("file: cab.obj, length: m, forward: x", "the file does not say its axis up: state it"),
    ],
)
def test_a_wrong_mesh_is_named_with_its_line(tmp_path, mesh, words):
    (problem,) = faults(tmp_path, head=f"environment: cab\nlength: mm\nmeshes:\n  - {{{mesh}}}\n")
    assert "environment.yaml:4:" in problem and words in problem


def test_a_part_in_two_meshes_is_refused(tmp_path):
    two = CAB + "  - {file: cab.obj, length: m, up: z, forward: x, move: [3000, 0, 0]}\n"
    assert [problem.split("'")[1] for problem in faults(tmp_path, head=two)] == [
        "floor",
        "pan",
        "sheet",
    ]


def test_all_faults_of_a_file_come_at_once(tmp_path):
    assert len(faults(tmp_path, SEATS.replace("pan", "pen") + "parts: {lid: {}}\n")) == 3


def test_a_mesh_is_turned_after_its_axes_and_then_moved(tmp_path):
    (tmp_path / "cab.obj").write_text(obj(rod=solid((2, 0.2, 0.4))))
    mesh = "{file: cab.obj, length: m, up: y, forward: x, turn: {yaw: 90}, move: [0, 0, 5000]}"
    (tmp_path / "environment.yaml").write_text(f"environment: rod\nlength: mm\nmeshes: [{mesh}]\n")
    environment = load_environment(tmp_path)
    assert np.diff(environment.bounds, axis=0)[0] == pytest.approx([0.4, 2, 0.2])
    assert environment.bounds.mean(axis=0) == pytest.approx([0, 0, 5])


def test_a_small_mesh_is_fine_beside_a_large_one(tmp_path):
    (tmp_path / "knob.obj").write_text(obj(knob=solid((0.02, 0.02, 0.02))))
    two = CAB + "  - {file: knob.obj, length: m, up: z, forward: x}\n"
    assert load_environment(cab(tmp_path, head=two)).parts[-1] == "knob"
    with pytest.raises(InputError, match=r"0\.02 m large"):
        environment_from_mesh(tmp_path / "knob.obj", length="m", up="z", forward="x")


def test_an_odd_scale_is_stated_as_the_length_of_one_unit(tmp_path):
    (tmp_path / "a.obj").write_text(obj(a=solid((10, 10, 10))))
    environment = environment_from_mesh(tmp_path / "a.obj", length="150 mm", up="z", forward="x")
    assert np.diff(environment.bounds, axis=0)[0] == pytest.approx([1.5, 1.5, 1.5])


def test_gltf_says_its_unit_and_both_axes_and_needs_none_stated(tmp_path):
    """A box 1.5 (x) by 0.9 (y, up) by 0.6 (z, forward) of the file."""
    (tmp_path / "a.glb").write_bytes(
        trimesh.Scene([solid((1.5, 0.9, 0.6))]).export(file_type="glb")
    )
    (tmp_path / "environment.yaml").write_text(
        "environment: a\nlength: mm\nmeshes:\n  - file: a.glb\n"
    )
    bounds = load_environment(tmp_path / "environment.yaml").bounds
    assert np.diff(bounds, axis=0)[0] == pytest.approx([0.6, 1.5, 0.9])


def test_a_scene_of_trimesh_is_an_environment_with_a_part_for_each_geometry():
    """A block of 1 m, and a mirrored copy of it 2 m to the right, whose faces must still look
    outward."""
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box((1000, 1000, 1000)), geom_name="block")
    mirrored = np.diag([1.0, -1.0, 1.0, 1.0])
    mirrored[1, 3] = -2000.0
    scene.add_geometry(
        trimesh.creation.box((1000, 1000, 1000)), geom_name="seat", transform=mirrored
    )
    environment = wb.environment_from_mesh(scene, length="mm", up="z", forward="x")
    assert environment.parts == ("block", "seat")
    assert environment.solid.all()
    assert environment.bounds.tolist() == [[-0.5, -2.5, -0.5], [0.5, 0.5, 0.5]]
    assert not any("inside out" in warning for warning in environment.warnings)


def test_a_mesh_of_trimesh_needs_a_unit_and_a_surface():
    with pytest.raises(wb.InputError, match="does not say its unit"):
        wb.environment_from_mesh(trimesh.creation.box((1, 1, 1)), up="z", forward="x")
    with pytest.raises(wb.InputError, match="holds no surface"):
        wb.environment_from_mesh(trimesh.Scene(), length="m", up="z", forward="x")
    with pytest.raises(
        wb.UsageError, match=r"expected a path, a trimesh.Scene or a trimesh.Trimesh, got list"
    ):
        wb.environment_from_mesh([1, 2], length="m", up="z", forward="x")


def test_a_stated_unit_overrides_what_the_file_tells(tmp_path):
    (tmp_path / "a.glb").write_bytes(trimesh.Scene([solid((150, 90, 90))]).export(file_type="glb"))
    with pytest.raises(InputError, match=r"1\.5 m in cm"):
        environment_from_mesh(tmp_path / "a.glb", up="y", forward="x")
    assert environment_from_mesh(
        tmp_path / "a.glb", length="cm", up="y", forward="x"
    ).bounds.max() == pytest.approx(0.75)


def test_polygons_keep_their_invariants(tmp_path):
    environment = load_environment(cab(tmp_path))
    polygon = np.repeat(np.arange(len(environment.normal)), np.diff(environment.edge_start))
    points = environment.vertices[environment.edges[:, 0]]
    assert np.linalg.norm(environment.normal, axis=1) == pytest.approx(np.ones(17))
    assert np.einsum("ij,ij->i", points, environment.normal[polygon]) == pytest.approx(
        environment.offset[polygon]
    )
    away = np.linalg.norm(points - environment.circle_centre[polygon], axis=1)
    assert np.all(away <= environment.circle_radius[polygon] * (1 + 1e-12))


def test_a_solid_inside_out_is_turned_and_told():
    inverted = solid()
    inverted.invert()
    turned, found = validate_part(part(inverted))
    assert found.closed and found.turned == 1
    assert trimesh.Trimesh(turned.vertices, turned.faces).volume == pytest.approx(1)
    assert found.sentences() == ["1 closed shell inside out: turned for the inside/outside test"]


def test_a_cavity_is_not_a_solid_inside_out():
    hollow = trimesh.util.concatenate(
        solid((3, 3, 3)), trimesh.Trimesh(solid().vertices, solid().faces[:, ::-1])
    )
    kept, found = validate_part(part(hollow))
    assert found.closed and found.turned == 0
    assert trimesh.Trimesh(kept.vertices, kept.faces).volume == pytest.approx(26)


def test_copies_of_faces_are_left_out_and_told_and_the_box_stays_closed():
    box = solid()
    twice, found = validate_part(
        RawPart("box", np.array(box.vertices), np.vstack([box.faces, box.faces[:3, ::-1]]))
    )
    assert (found.faces, found.duplicate, found.closed, len(twice.faces)) == (15, 3, True, 12)


def test_faults_are_counted():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0], [2, 0, 0.0]])
    faces = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 5]])
    found = validate_part(RawPart("fan", vertices, faces))[1]
    assert (found.degenerate, found.crowded_edges, found.open_edges, found.closed) == (
        1,
        1,
        8,
        False,
    )


def test_moved_parts_take_their_planes_and_circles_along(tmp_path):
    before = load_environment(cab(tmp_path))
    after = move_parts(before, ["pan"], [0.1, 0, 0.2])
    assert corners(after, "pan") == pytest.approx(corners(before, "pan") + np.array([0.1, 0, 0.2]))
    assert corners(after, "floor").tolist() == corners(before, "floor").tolist()
    polygon = np.repeat(np.arange(17), np.diff(after.edge_start))
    points = after.vertices[after.edges[:, 0]]
    assert np.einsum("ij,ij->i", points, after.normal[polygon]) == pytest.approx(
        after.offset[polygon]
    )
    assert (after.circle_centre - before.circle_centre)[6:12] == pytest.approx(
        np.tile([0.1, 0, 0.2], (6, 1))
    )


def test_moving_an_unknown_part_or_by_nonsense_is_refused(tmp_path):
    environment = load_environment(cab(tmp_path))
    with pytest.raises(InputError, match="did you mean 'pan'"):
        move_parts(environment, ["pann"], [0, 0, 1])
    with pytest.raises(UsageError, match="three finite numbers"):
        move_parts(environment, ["pan"], [0, float("nan"), 1])


def test_inspecting_a_mesh_without_a_unit_shows_it_in_each(tmp_path):
    (tmp_path / "a.obj").write_text(obj(a=solid((200, 100, 50))))
    found = inspect_mesh(tmp_path / "a.obj", up="z", forward="y")
    assert found.metres_told is None and found.metres == 0.01
    assert found.size == pytest.approx((1, 2, 0.5))
    assert found.assumed == ("unit cm (not sure): by its size, 2 m long; it would be 5.08 m in in",)
    assert (
        found.largest_if["cm"] == pytest.approx(2)
        and found.problem is not None
        and "2 m in cm" in found.problem
    )
    known = inspect_mesh(tmp_path / "a.obj", length="cm")
    assert (
        known.problem is None
        and known.parts[0].size == pytest.approx((2, 1, 0.5))
        and known.parts[0].polygons == 6
    )


def test_inspecting_an_environment_counts_its_parts(tmp_path):
    found = inspect_environment(cab(tmp_path))
    assert [(p.name, p.faces, p.polygons, p.open_edges) for p in found.parts] == [
        ("floor", 12, 6, 0),
        ("pan", 12, 6, 0),
        ("sheet", 10, 5, 4),
    ]


def test_inspecting_an_environment_tells_seats_controls_and_points_with_their_parts(capsys):
    assert main(["inspect", "trainer"]) == 0
    said = capsys.readouterr().out
    assert "seat 'left' at (0, 280, 280) mm: 0 mm from 'left_seat_pan'" in said
    assert "control 'flaps' at (213, 22, 366) mm: 0 mm from 'flap_lever'" in said
    assert "point 'left_heel' at (786, 280, 0) mm: 0 mm from 'floor', the nearest part" in said


def test_the_ranger_comes_out_in_metres_where_its_simulation_model_has_it():
    """model.sdf turns the mesh by -90 degrees about z: y of the file is forward. Seat, roll cage
    and wheels of that model, in metres, are where the mesh has them."""
    environment = environment_from_mesh(real("polaris_ranger_ev/polaris.dae"), up="z", forward="y")
    assert np.diff(environment.bounds, axis=0)[0] == pytest.approx([2.730, 1.492, 1.950], abs=2e-3)
    wheel = corners(environment, "Steering_Wheel")
    assert wheel.mean(axis=0) == pytest.approx([0.36, 0.30, 1.30], abs=0.03)
    ranger = corners(environment, "Ranger")
    seat = ranger[
        (np.abs(ranger[:, 0] + 0.1) < 0.3)
        & (np.abs(ranger[:, 1]) < 0.61)
        & (np.abs(ranger[:, 2] - 0.75) < 0.2)
    ]
    assert len(seat) > 50 and 0.80 < seat[:, 2].max() < 0.95
    assert corners(environment, "Front_Wheel_Left").mean(axis=0) == pytest.approx(
        [0.98, 0.61, 0.34], abs=0.02
    )


def test_the_prius_is_a_car_only_in_centimetres():
    path = real("prius_cardemo/hybrid_body.obj")
    environment = environment_from_mesh(path, length="cm", up="z", forward="-y")
    assert np.diff(environment.bounds, axis=0)[0] == pytest.approx([4.618, 2.012, 1.386], abs=1e-3)
    for wrong in ("m", "ft"):
        with pytest.raises(InputError, match=r"4\.62 m in cm"):
            environment_from_mesh(path, length=wrong, up="z", forward="-y")


def test_the_wheelchair_needs_the_scale_of_its_robot_description():
    name = "assistive_gym/wheelchair__wheelchair_permobil_reduced_compressed"
    chair = environment_from_mesh(real(f"{name}.obj"), length="150 mm", up="y", forward="-z")
    assert np.diff(chair.bounds, axis=0)[0] == pytest.approx([0.946, 0.782, 1.237], abs=1e-3)
    pieces = environment_from_mesh(real(f"{name}_vhacd.obj"), length="150 mm", up="y", forward="-z")
    assert len(pieces.parts) == 44 and pieces.solid.all() and not chair.solid.any()


def test_the_console_and_the_space_station_load_with_their_faults_told():
    console = environment_from_mesh(real("gazebo_control_console/console.dae"), up="z", forward="y")
    assert (
        len(console.parts) == 41
        and console.quality[0].duplicate == 0
        and console.quality[0].degenerate == 5
    )
    station = environment_from_mesh(
        real("iss_astrobee/astrobee_iss/meshes/jpm.dae"), up="z", forward="x"
    )
    assert station.quality[0].degenerate == 74 and any(
        "sets of lines" in said for said in station.warnings
    )


def test_a_box_with_bad_normals_is_a_solid_all_the_same():
    path = real_input(SHARED / "nasty" / "assimp" / "BoxBadNormals.glb")
    environment = environment_from_mesh(path, up="y", forward="z")
    assert (
        environment.solid.tolist() == [True]
        and len(environment.normal) == 6
        and environment.warnings == ()
    )
