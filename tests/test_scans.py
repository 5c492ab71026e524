"""A scan of a standing adult becomes a body: `workbench body fit SCAN --skeleton adult_male`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

import workbench as wb
from tests.conftest import SHARED
from tests.made_studies import found_of
from tests.mirror_images import asymmetry
from tests.toy_cockpit import write_toy
from workbench import InputError
from workbench.body.surface import body_solid
from workbench.cli import main
from workbench.study.fit_body import read_surface, skeleton_of

WIDE = ["--outward", "12 mm", "--inward", "14 mm", "--least-radius", "4 mm"]
NARROW = ["--outward", "8 mm", "--inward", "10 mm"]
STUDY = """
study: scanned
length: mm
environment: toy
people:
  pilot: {body: BODY, seat: pilot}
cases:
  - {name: sitting, people: {pilot: {posture: seated}}}
criteria:
  - {name: head room, check: clearance, segments: [H], parts: [roof], at_least: 150}
"""
APART = {
    "LS": {"abduction": 14},
    "RS": {"abduction": 12},
    "LE": {"flexion": 10},
    "RE": {"flexion": 15},
    "LH": {"abduction": 5},
    "RH": {"abduction": 6},
}
BONES = (("LH", "LK"), ("LK", "LA"), ("LS", "LE"), ("LE", "LW"), ("RH", "RK"), ("RS", "RE"))


def scan_of(body, path, *, turned=0.0):
    """The skin of a body with arms and legs apart, standing 0.4 m off the origin, as a mesh [m]."""
    turn = np.array(
        [[np.cos(turned), -np.sin(turned), 0], [np.sin(turned), np.cos(turned), 0], [0, 0, 1]]
    )
    poses = wb.pose(body, APART, position=(0.4, -0.1, 0.3), attitude=turn)
    mesh = trimesh.Trimesh(*body_solid(wb.place(body, poses), tolerance=0.003), process=False)
    mesh.export(path)
    return joints_of(body, wb.place(body, poses).world_from_segment[0])


def joints_of(body, world):
    """(J, 3) [m] the joints in the world, from frames (N, 3, 4)."""
    return np.einsum("nij,nj->ni", world[1:, :, :3], body.joint_in_child[0]) + world[1:, :, 3]


def length(body, bone):
    """[m] from the proximal to the distal joint of a segment."""
    near, far = (body.joint(name) for name in bone)
    return float(np.linalg.norm(body.joint_in_parent[0, far] - body.joint_in_child[0, near]))


@pytest.fixture(scope="module")
def woman():
    return wb.load_body("adult_female")


@pytest.fixture(scope="module")
def fitted(tmp_path_factory, woman):
    """The median woman's scan with a man's skeleton."""
    folder = tmp_path_factory.mktemp("scan")
    scan_of(woman, folder / "scan.obj")
    call = ["body", "fit", str(folder / "scan.obj"), "--length", "m", "--skeleton", "adult_male"]
    code = main([*call, "-o", str(folder / "scanned.yaml"), *WIDE])
    assert code == 0
    return folder / "scanned.yaml"


def test_the_limbs_of_a_scanned_woman_are_as_long_as_hers_with_a_mans_skeleton(fitted, woman):
    made = wb.load_body(fitted)
    off = [length(made, bone) - length(woman, bone) for bone in BONES]
    assert np.abs(off).max() < 0.020
    high, eyes = (wb.measure(woman, [name])[name] for name in ("stature", "eye_height_sitting"))
    assert wb.measure(made)["stature"] == pytest.approx(high, abs=0.025)
    assert wb.measure(made)["eye_height_sitting"] == pytest.approx(eyes, abs=0.025)
    assert float(made.mass.sum()) == pytest.approx(float(woman.mass.sum()), rel=0.1)


def test_a_scanned_person_sits_in_a_study(fitted, tmp_path):
    study = write_toy(tmp_path, study=STUDY.replace("BODY", str(fitted)))
    found = found_of(wb.load_study(study))
    head = found.verdicts[0].worst
    assert 0.3 < head.value < 0.9  # the roof is 1.3 m above the seat


@pytest.mark.parametrize(("turned", "said"), [(np.pi, "backward"), (np.pi / 2, "to the left")])
def test_a_scan_that_faces_elsewhere_is_refused_with_the_way_on(woman, tmp_path, turned, said):
    scan_of(woman, tmp_path / "scan.obj", turned=turned)
    surface = read_surface(tmp_path / "scan.obj", length="m")
    with pytest.raises(InputError, match=f"feet in the surface point {said}.*--forward"):
        skeleton_of("adult_male", surface)


@pytest.mark.nightly
@pytest.mark.parametrize("size", [{"stature": 1.88}, {"stature": 1.65, "sitting_height": 0.86}])
def test_the_joints_of_a_scanned_man_of_any_size_are_found(tmp_path, size):
    """Within 20 mm; the elbows, whose place along a nearly straight arm shows little, within 30."""
    man = wb.scale(wb.load_body("adult_male"), size)
    known = scan_of(man, tmp_path / "scan.obj")
    skeleton = skeleton_of("adult_male", read_surface(tmp_path / "scan.obj", length="m"))
    off = np.linalg.norm(joints_of(skeleton.body, skeleton.world) - known, axis=1)
    elbow = np.isin(man.joints, ["LE", "RE"])
    assert off[elbow].max() < 0.030 and off[~elbow].max() < 0.020


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["adult_male", "adult_female"])
def test_a_mesh_of_a_person_that_is_not_of_this_project_becomes_a_body_that_sits(tmp_path, name):
    source = Path(SHARED) / "bodies" / "makehuman_derived" / f"{name}.obj"
    if not source.exists():
        pytest.skip(f"no {source.name} of other people's bodies here")
    surface = read_surface(source, length="m", up="y", forward="z")
    skeleton = skeleton_of(name, surface)
    tall = float(np.ptp(surface.vertices[:, 2]))
    assert wb.measure(skeleton.body)["stature"] == pytest.approx(tall, abs=0.015)
    at = joints_of(skeleton.body, skeleton.world)
    assert surface.distance(at).max() < -0.005
    body = skeleton.body
    for left, right in (("LK", "RK"), ("LE", "RE"), ("LH", "RH"), ("LS", "RS")):
        other = at[body.joint(right)] * [1, -1, 1]
        assert np.abs(at[body.joint(left)] - other).max() < 0.015
    out = tmp_path / "scanned.yaml"
    call = ["body", "fit", str(source), "--length", "m", "--up", "y", "--forward", "z"]
    assert main([*call, "--skeleton", name, "-o", str(out), *NARROW]) == 0
    study = write_toy(tmp_path, study=STUDY.replace("BODY", str(out)))
    assert 0.3 < found_of(wb.load_study(study)).verdicts[0].worst.value < 0.9


def symmetric_scan(source, path, seed):
    """The left half of a closed mesh, and its mirror image on the right, in an order of their own."""
    cut = trimesh.intersections.slice_faces_plane(
        source.vertices, source.faces, np.array([0.0, 1.0, 0.0]), np.zeros(3)
    )
    half, faces = np.array(cut[0]), np.array(cut[1])
    half[np.abs(half[:, 1]) < 1e-7, 1] = 0.0
    faces = faces[(half[faces][:, :, 1] > 0).any(axis=1)]
    both = np.concatenate([half, half * [1, -1, 1]])
    mesh = trimesh.Trimesh(both, np.concatenate([faces, faces[:, ::-1] + len(half)]))
    mesh.merge_vertices(digits_vertex=9)
    random = np.random.default_rng(seed)
    order = random.permutation(len(mesh.vertices))
    faces = random.permutation(np.argsort(order)[mesh.faces])
    trimesh.Trimesh(mesh.vertices[order], faces, process=False).export(path, digits=12)


@pytest.mark.nightly
def test_a_symmetric_scan_gives_a_symmetric_body_whatever_the_order_in_its_file(woman, tmp_path):
    pose = wb.pose(woman, {f"{side}S": {"abduction": 30} for side in "LR"})
    solid = trimesh.Trimesh(*body_solid(wb.place(woman, pose), tolerance=0.003), process=False)
    texts = []
    for seed in (1, 2):
        scan, made = tmp_path / "scan.obj", tmp_path / "made.yaml"
        symmetric_scan(solid, scan, seed)
        call = ["body", "fit", str(scan), "--length", "m", "--skeleton", "adult_male"]
        assert main([*call, "-o", str(made), *WIDE]) == 0
        assert asymmetry(wb.load_body(made)) < 1e-9
        texts.append(made.read_text())
    assert texts[0] == texts[1]
