"""`workbench body fit`: a mesh or outlines in, a body file out that loads, poses and runs."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh

import workbench as wb
from tests.conftest import ONE_ARM
from tests.one_arm_cab import POSTURES
from workbench import InputError, UsageError
from workbench.body.fitting.candidates import FitBounds, random_samples
from workbench.body.fitting.polish import union_field
from workbench.cli import main
from workbench.study.fit_body import bound_of, fit_body, placed_skeleton, read_surface

COARSE = ["--outward", "10 mm", "--inward", "10 mm", "--least-radius", "4 mm"]
FOREARM = """
outlines: forearm
length: mm
axis: z
stations:
  - {at: 0, points: [[30, 0], [20, 22], [0, 30], [-20, 22], [-30, 0], [-20, -22], [0, -30], [20, -22]]}
  - {at: 200, points: [[22, 0], [16, 16], [0, 22], [-16, 16], [-22, 0], [-16, -16], [0, -22], [16, -16]]}
"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    """A mesh [mm] of the zoo's arm: one limb 80 mm thick from 60 mm above the shoulder to below the
    hand, standing as the skeleton stands with its base at (0, 0, 1 m); the skeleton; its
    postures."""
    folder = tmp_path_factory.mktemp("arm")
    mesh = trimesh.creation.capsule(620, 40, count=(24, 24))
    middle = mesh.bounds.mean(axis=0)
    mesh.apply_translation([0, 0, 1000 - 290] - middle)
    mesh.export(folder / "arm.obj")
    skeleton = ONE_ARM.replace("body: one_arm\n", "body: one_arm\npostures: arm_postures.yaml\n")
    (folder / "one_arm.yaml").write_text(skeleton)
    (folder / "arm_postures.yaml").write_text(POSTURES)
    return folder


@pytest.fixture(scope="module")
def fitted(arm):
    code = main(
        [
            "body",
            "fit",
            str(arm / "arm.obj"),
            "--length",
            "mm",
            "--skeleton",
            str(arm / "one_arm.yaml"),
            "--at",
            "0 mm, 0 mm, 1 m",
            "-o",
            str(arm / "made.yaml"),
            *COARSE,
        ]
    )
    assert code == 0
    return wb.load_body(arm / "made.yaml")


def test_the_body_has_the_skeletons_segments_joints_and_stops(fitted, arm):
    skeleton = wb.load_body(arm / "one_arm.yaml")
    assert (fitted.segments, fitted.joints) == (skeleton.segments, skeleton.joints)
    assert np.allclose(fitted.joint_in_parent[0], skeleton.joint_in_parent[0]) and len(
        fitted.sphere_names
    ) > len(skeleton.sphere_names)
    assert np.allclose(fitted.stops.limits, skeleton.stops.limits)


def test_a_sphere_is_exactly_at_every_joint_in_both_segments(fitted):
    for j in range(len(fitted.joints)):
        for segment, joint in (
            (fitted.parent[j + 1], fitted.joint_in_parent[0, j]),
            (j + 1, fitted.joint_in_child[0, j]),
        ):
            assert np.abs(fitted.centre[0, fitted.spheres(segment)] - joint).sum(axis=1).min() == 0


def test_the_surface_stays_within_the_stated_fit_error(fitted, arm):
    surface = read_surface(arm / "arm.obj", length="mm")
    assert (fitted.fit_error[0, :, 0] <= 10.3e-3).all() and (
        fitted.fit_error[0, :, 1] <= 10.1e-3
    ).all()
    places = random_samples(surface, 30_000, seed=9).point - [0, 0, 1]
    centres = wb.place(fitted, wb.pose(fitted, {})).centres[0]
    assert (
        union_field(places, centres, fitted.radius[0])[0].max() <= fitted.fit_error[0, :, 0].max()
    )
    out = surface.distance(centres + np.array([0, 0, 1])) + fitted.radius[0]
    assert (out <= fitted.fit_error[0, fitted.sphere_segment, 1] + 2e-6).all()


def test_named_subparts_are_there_and_masses_are_volumes(fitted, arm):
    assert {"fingertip", "thumb tip", "ball"} & set(fitted.sphere_names) == {
        "fingertip",
        "thumb tip",
    }
    volume = read_surface(arm / "arm.obj", length="mm").volume
    assert fitted.mass[0].sum() == pytest.approx(1010 * volume, rel=1e-3)


def test_the_body_runs_in_a_study(fitted, arm):
    (arm / "study.yaml").write_text("""study: fitted
title: A fitted arm
length: mm
environment: trainer
people: {anna: {body: ./made.yaml, at: {segment: BASE, position: [0, 0, 3000]}}}
cases: [{name: bent, people: {anna: {posture: bent}}}]
criteria: [{name: free, check: contact}]
""")
    result = wb.run(wb.load_study(str(arm / "study.yaml")))
    assert [v.passed for v in result.verdicts] == [True]


def test_a_mesh_in_a_posture_gives_the_same_segments(arm):
    body = wb.load_body(arm / "one_arm.yaml")
    straight = placed_skeleton(arm / "one_arm.yaml", at=[0, 0, 1.0])
    bent = placed_skeleton(arm / "one_arm.yaml", posture="bent", at=[0, 0, 1.0])
    assert np.allclose(straight.world[:2], bent.world[:2]) and not np.allclose(
        straight.world[2], bent.world[2]
    )
    assert np.allclose(bent.world[2, :, :3] @ bent.world[2, :, :3].T, np.eye(3)) and len(
        bent.world
    ) == len(body.segments)


def test_a_posture_that_twists_a_shared_joint_is_refused(arm):
    twisted = POSTURES + "  turned: {angles: {WRIST: {pronation: 40}}}\n"
    (arm / "arm_postures.yaml").write_text(twisted)
    with pytest.raises(UsageError, match="WRIST"):
        placed_skeleton(arm / "one_arm.yaml", posture="turned")


def test_outlines_give_a_body_of_one_segment(tmp_path, capsys):
    (tmp_path / "forearm.yaml").write_text(FOREARM)
    out = tmp_path / "made.yaml"
    assert (
        main(
            [
                "body",
                "fit",
                str(tmp_path / "forearm.yaml"),
                "-o",
                str(out),
                "--count",
                "12",
                "--json",
            ]
        )
        == 0
    )
    told = json.loads(capsys.readouterr().out)
    body = wb.load_body(out)
    assert body.segments == ("BODY",) and len(body.sphere_names) == told["whole"]["spheres"] == 12
    assert told["whole"]["mean_mm"] < 2 and told["whole"]["volume_l"] == pytest.approx(
        0.387, rel=0.02
    )
    # the origin is the centre of gravity
    assert np.abs(np.average(body.centre[0], axis=0, weights=body.radius[0] ** 3)).max() < 0.02


def test_the_bound_is_at_most_what_was_found():
    surface = read_of(trimesh.creation.capsule(0.3, 0.05, count=(24, 24)))
    limits = FitBounds(0.002, 0.2, 0.004, 0.004)
    fit = fit_body(surface, None, limits)
    fewest = bound_of(surface, None, limits)
    assert 0.7 * len(fit.fit.radius) <= fewest <= len(fit.fit.radius)


def read_of(mesh):
    from workbench import sealed

    return sealed(mesh.vertices, mesh.faces)


@pytest.mark.parametrize(
    "options, said",
    [
        (["--length", "m"], r"is 700 m large, .* a wrong unit of length"),
        ([], "does not say its unit of length"),
        (["--length", "mm", "--at", "0 mm, 0 mm, 3 m"], "outside the surface.*place or pose"),
        (["--length", "mm", "--at", "0 mm"], "three lengths"),
        (
            ["--length", "mm", "--at", "0 mm, 0 mm, 1 m", "--posture", "flying"],
            "no posture 'flying'",
        ),
        (
            ["--length", "mm", "--at", "0 mm, 0 mm, 1 m", "--least-radius", "300 mm"],
            "greater than --greatest-radius",
        ),
        (
            ["--length", "mm", "--at", "0 mm, 0 mm, 1 m", "--least-radius", "60 mm"],
            "it can be with a least radius of",
        ),
        (["--length", "mm", "--outward", "4 apples"], "a length such as"),
        (["--length", "mm", "--count", "20", "--bound"], "leave --count out"),
    ],
)
def test_a_bad_call_is_told_and_writes_nothing(arm, capsys, options, said):
    import re

    out = arm / "none.yaml"
    code = main(
        [
            "body",
            "fit",
            str(arm / "arm.obj"),
            "--skeleton",
            str(arm / "one_arm.yaml"),
            "-o",
            str(out),
            *options,
        ]
    )
    told = capsys.readouterr().err
    assert code in (2, 3) and re.search(said, told) and not out.exists() and "Traceback" not in told


def test_errors_are_the_workbenchs_own(arm):
    with pytest.raises(UsageError, match="does not say its unit"):
        read_surface(arm / "arm.obj")
    with pytest.raises(InputError, match="no such file"):
        read_surface(arm / "nothing.obj", length="mm")
