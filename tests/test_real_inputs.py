"""Real files of other people: their sizes, what is said about them, and clearance against what
trimesh reads."""

from __future__ import annotations

import importlib.util
import logging
import shutil
import warnings
from dataclasses import dataclass

import numpy as np
import pytest
import trimesh

import workbench as wb
from tests.conftest import SHARED, needs_real_input
from tests.oracles import winding
from workbench import InputError, environment_from_mesh
from workbench.files.mesh_report import inspect_mesh
from workbench.files.postures import posture_pose

ENVIRONMENTS = SHARED / "environments"
NASTY = SHARED / "nasty" / "assimp"
pytestmark = needs_real_input(ENVIRONMENTS)
BALL = """
body: ball
length: mm
segments:
  B: {name: ball, number: 1, mass: 1, directions: {front: +x, left: +y, top: +z}, spheres: [[0, 0, 0, 50]]}
joints: {}
"""


@dataclass(frozen=True)
class File:
    """A mesh: its unit (None: the file says it), its axes, metres a unit, size [m] along x, y, z
    and parts."""

    path: str
    length: str | None
    up: str
    forward: str
    metres: float
    size: tuple[float, float, float]
    parts: int


FILES = {
    "car": File("prius_cardemo/hybrid_body.obj", "cm", "z", "-y", 0.01, (4.618, 2.012, 1.386), 3),
    "steering_wheel": File(
        "prius_cardemo/steering_wheel.obj", "cm", "z", "-y", 0.01, (0.126, 0.362, 0.349), 1
    ),
    "console": File(
        "gazebo_control_console/console.dae", None, "z", "y", 0.001, (1.000, 1.842, 2.625), 41
    ),
    "space_module": File(
        "iss_astrobee/astrobee_iss/meshes/jpm.dae", None, "z", "x", 1, (10.175, 2.861, 3.078), 1
    ),
    "handrail": File(
        "iss_astrobee/astrobee_handrail_30/meshes/handrail_30.dae",
        None,
        "z",
        "x",
        1,
        (0.078, 0.033, 0.783),
        2,
    ),
    "wheelchair": File(
        "assistive_gym/wheelchair__wheelchair_permobil_reduced_compressed.obj",
        "150 mm",
        "y",
        "-z",
        0.15,
        (0.946, 0.782, 1.237),
        1,
    ),
    "wheelchair_hulls": File(
        "assistive_gym/wheelchair__wheelchair_permobil_reduced_compressed_vhacd.obj",
        "150 mm",
        "y",
        "-z",
        0.15,
        (0.948, 0.785, 1.237),
        44,
    ),
    "truck": File("trimesh/CesiumMilkTruck.glb", None, "y", "x", 1, (4.869, 2.792, 2.583), 3),
    "suv": File("gazebo_suv/suv.obj", "60 mm", "z", "-y", 0.06, (5.020, 2.604, 2.157), 4),
    "bench": File("gazebo_bus_stop/bench.dae", None, "y", "z", 1, (0.300, 1.600, 0.040), 1),
    "utility_vehicle": File(
        "polaris_ranger_ev/polaris.dae", None, "z", "y", 0.0254, (2.730, 1.492, 1.951), 9
    ),
}


@pytest.fixture(scope="module", params=FILES)
def pair(request):
    """What the table says of a file, and the file as an environment."""
    file = FILES[request.param]
    return file, environment_from_mesh(
        ENVIRONMENTS / file.path, up=file.up, forward=file.forward, length=file.length
    )


@pytest.fixture(scope="module")
def balls(tmp_path_factory):
    """Place balls of 50 mm at points (P, 3) [m], one a pose."""
    path = tmp_path_factory.mktemp("ball") / "ball.yaml"
    path.write_text(BALL)
    body = wb.load_body(path)

    def put(points):
        world = np.concatenate(
            [np.broadcast_to(np.eye(3), (len(points), 3, 3)), points[:, :, None]], axis=2
        )
        return wb.place(body, wb.Poses(np.zeros((len(points), 0, 4)), 0, world))

    return put


def trimesh_corners(file):
    """(T, 3, 3) the triangles that trimesh reads, in the world's axes [m]."""
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mesh = trimesh.load(
            ENVIRONMENTS / file.path, force="mesh", process=False, skip_materials=True
        )
    unit = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}
    up, ahead = (
        np.array(unit[way[-1]]) * (-1 if way[0] == "-" else 1) for way in (file.up, file.forward)
    )
    return (
        np.stack([mesh.triangles @ way for way in (ahead, np.cross(up, ahead), up)], axis=-1)
        * file.metres
    )


def surface_distance(points, corners):
    """(P,) distance of points to the nearest of all triangles."""
    return np.array(
        [
            np.linalg.norm(
                trimesh.triangles.closest_point(corners, np.tile(p, (len(corners), 1))) - p, axis=1
            ).min()
            for p in points
        ]
    )


def test_a_file_has_the_size_it_has_in_the_world(pair):
    file, environment = pair
    np.testing.assert_allclose(
        environment.bounds[1] - environment.bounds[0], file.size, atol=0.0006
    )
    assert len(environment.parts) == len(set(environment.parts)) == file.parts


def test_clearance_of_twenty_balls_is_the_distance_to_the_nearest_triangle(pair, balls):
    file, environment = pair
    low, high = environment.bounds + np.array([[-0.3], [0.3]])
    points = np.random.default_rng(7).uniform(low, high, (20, 3))
    found = wb.clearance(balls(points), environment)[:, 0]
    expected = surface_distance(points, trimesh_corners(file))
    np.testing.assert_allclose(np.abs(found + 0.05).min(axis=1), expected, atol=1e-5)


def test_a_ball_is_inside_the_solid_parts_that_wind_around_it(pair, balls):
    _, environment = pair
    solids = np.flatnonzero(environment.solid)[:3]
    for part in solids:
        polygons = environment.polygons(part)
        first, last = environment.triangle_start[[polygons.start, polygons.stop]]
        corners = environment.vertices[environment.triangles[first:last]]
        points = np.random.default_rng(part).uniform(
            corners.min(axis=(0, 1)), corners.max(axis=(0, 1)), (10, 3)
        )
        found = wb.clearance(balls(points), environment)[:, 0, part] + 0.05
        np.testing.assert_array_equal(found < 0, [abs(winding(p, corners)) > 0.5 for p in points])


@pytest.mark.parametrize("name", [name for name, file in FILES.items() if file.length])
def test_a_file_that_does_not_say_its_unit_is_refused_with_its_size_in_each(name):
    file = FILES[name]
    with pytest.raises(
        InputError, match=r"does not say its unit of length; .* m in mm, .* m in cm, .* m in ft"
    ):
        environment_from_mesh(ENVIRONMENTS / file.path, up=file.up, forward=file.forward)


def test_a_wheelchair_in_metres_would_be_told_to_be_eight_metres_large():
    found = inspect_mesh(ENVIRONMENTS / FILES["wheelchair"].path, length="m", up="y", forward="-z")
    assert max(found.size) == pytest.approx(8.25, abs=0.01)


def test_lines_in_a_mesh_are_left_out_and_told():
    found = inspect_mesh(ENVIRONMENTS / FILES["space_module"].path)
    assert any("lines" in said and "left out" in said for said in found.warnings)
    assert any("degenerate" in said for said in found.warnings)
    assert any("open edges: a surface, not a solid" in said for said in found.warnings)


def test_a_floating_body_is_as_far_from_the_walls_as_trimesh_says(bubbleman, postures):
    file = FILES["space_module"]
    module = environment_from_mesh(ENVIRONMENTS / file.path, up=file.up, forward=file.forward)
    pose = posture_pose(bubbleman, postures, "t_pose")
    world = pose.world_from_reference.copy()
    world[:, :, 3] = 5.0, 0.0, 0.2
    placed = wb.place(bubbleman, wb.Poses(pose.rotations, pose.reference, world))
    hand = bubbleman.spheres(bubbleman.segment("LHN"))
    apart = (
        surface_distance(placed.centres[0, hand], trimesh_corners(file)) - bubbleman.radius[0, hand]
    )
    assert wb.clearance(placed, module)[0, bubbleman.segment("LHN"), 0] == pytest.approx(
        apart.min(), abs=1e-5
    )


@pytest.mark.skipif(importlib.util.find_spec("cascadio") is None, reason="STEP needs cascadio")
def test_a_machined_part_of_five_inches_is_one_closed_solid_and_too_small_for_a_vehicle():
    found = inspect_mesh(ENVIRONMENTS / "trimesh" / "featuretype.STEP")
    np.testing.assert_allclose(found.size, np.array([5, 2.5, 1.375]) * 0.0254, atol=1e-5)
    assert [part.solid for part in found.parts] == [True]
    assert found.problem is not None
    assert found.problem.startswith("is 0.127 m large, and 0.3 to 60 m is plausible")


def test_a_box_with_bad_normals_is_a_solid_all_the_same(balls):
    box = environment_from_mesh(NASTY / "BoxBadNormals.glb", up="y", forward="z")
    assert box.solid.tolist() == [True]
    centre = box.bounds.mean(axis=0)
    assert wb.clearance(balls(centre[None]), box).item() == pytest.approx(-0.55)


def test_two_solids_of_one_triangle_in_an_stl_are_two_open_parts():
    found = inspect_mesh(NASTY / "triangle_with_two_solids.stl", length="m")
    assert [(part.faces, part.open_edges, part.solid) for part in found.parts] == [
        (1, 3, False),
        (1, 3, False),
    ]


@pytest.mark.parametrize("name", ["car", "space_module", "truck", "suv"])
def test_a_file_cut_in_half_is_one_line_of_error_or_a_warning(tmp_path, name):
    file = FILES[name]
    whole = ENVIRONMENTS / file.path
    cut = tmp_path / whole.name
    shutil.copyfile(whole, cut)
    with cut.open("r+b") as stream:
        stream.truncate(whole.stat().st_size // 2)
    try:
        found = inspect_mesh(cut, length=file.length)
    except InputError as error:
        assert len(error.problems) == 1
        assert "\n" not in str(error)
        assert str(cut) in str(error)
    else:
        assert any("may be cut short" in said for said in found.warnings)
