"""Spheres fitted to closed surfaces: known answers, proved tolerances, bad input."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from tests.conftest import SHARED, needs_real_input
from workbench import Bones, InputError, UsageError, decompose, fit_segments, sealed
from workbench.body.fitting.candidates import FitBounds, even_samples, inner_balls, random_samples
from workbench.body.fitting.fit_quality import exposed_points, fit_quality
from workbench.body.fitting.polish import union_field
from workbench.body.fitting.regions import Regions
from workbench.body.kernels.setcover import greedy_cover, prune_cover
from workbench.body.kernels.volume_integration import shared_volume
from workbench.files.meshes.reading import read_mesh

ADULT = SHARED / "bodies" / "makehuman_derived" / "adult_male.obj"
needs_adult = needs_real_input(ADULT)
RADII = {"least_radius": 0.002, "greatest_radius": 0.2}


def surface_of(mesh):
    return sealed(mesh.vertices, mesh.faces)


def union_of(balls):
    """The surface of a union of balls, rows x, y, z, r [m]."""
    parts = [trimesh.creation.icosphere(3, r).apply_translation(c) for *c, r in balls]
    return sealed(
        np.concatenate([p.vertices for p in parts]),
        np.concatenate([p.faces + k * len(parts[0].vertices) for k, p in enumerate(parts)]),
    )


@pytest.fixture(scope="module")
def ball():
    return surface_of(trimesh.creation.icosphere(4, 0.1))


@pytest.fixture(scope="module")
def capsule():
    return surface_of(trimesh.creation.capsule(0.3, 0.05, count=(48, 48)))


@pytest.fixture(scope="module")
def torus():
    return surface_of(trimesh.creation.torus(0.1, 0.03, 64, 32))


@pytest.fixture(scope="module")
def adult():
    part = read_mesh(ADULT).parts[0]
    upright = part.vertices[:, [2, 0, 1]] * (1.756 / np.ptp(part.vertices[:, 1]))
    return sealed(upright, part.faces)


def kept(fit, surface, samples=30_000):
    """Whether dense samples of both surfaces keep to the tolerances of a fit."""
    there = random_samples(surface, samples, seed=99).point
    bare = union_field(there, fit.centre, fit.radius)[0].max()
    signed = surface.distance(exposed_points(fit.centre, fit.radius, samples))
    return (
        bare <= fit.inward + 1e-9
        and signed.min() >= -fit.inward - 1e-9
        and signed.max() <= fit.outward + 1e-9
    )


def test_distance_to_a_sphere_mesh_is_that_of_the_sphere(ball):
    points = np.random.default_rng(0).normal(size=(2000, 3)) * 0.1
    assert np.abs(ball.distance(points) - (np.linalg.norm(points, axis=1) - 0.1)).max() < 4e-4


def test_distance_agrees_with_looking_at_every_triangle(torus):
    points = np.random.default_rng(1).normal(size=(40, 3)) * 0.08
    corner = torus.vertices[torus.faces]
    slow = [
        np.linalg.norm(
            trimesh.triangles.closest_point(corner, np.tile(p, (len(corner), 1))) - p, axis=1
        ).min()
        for p in points
    ]
    inside = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 0.1, points[:, 2]) < 0.03
    assert np.allclose(np.abs(torus.distance(points)), slow, atol=1e-12)
    clear = np.abs(slow) > 1e-3
    assert ((torus.distance(points) < 0) == inside)[clear].all()


def test_even_samples_keep_their_spacing_and_leave_no_large_hole(ball):
    samples = even_samples(ball, 0.01)
    gap = np.linalg.norm(samples.point[:, None] - samples.point[None], axis=2) + np.eye(
        len(samples)
    )
    far = np.linalg.norm(
        random_samples(ball, 3000).point[:, None] - samples.point[None], axis=2
    ).min(axis=1)
    assert gap.min() >= 0.01 and far.max() < 0.016


def test_volumes_of_two_balls_that_overlap_are_known():
    solid = trimesh.creation.icosphere(5, 0.1)
    mesh, union, both = shared_volume(
        solid.vertices[solid.faces], np.array([[0.1, 0, 0]]), np.array([0.1]), 0.0005
    )
    lens = np.pi * (4 * 0.1 + 0.1) * (2 * 0.1 - 0.1) ** 2 / 12
    assert np.allclose([mesh, union, both], [4e-3 * np.pi / 3, 4e-3 * np.pi / 3, lens], rtol=2e-3)


def test_a_cover_takes_the_rows_that_are_needed_and_drops_the_others():
    rows = [[0, 1, 2], [3, 4, 5], [0, 3], [1, 4], [2, 5]]
    start = np.cumsum([0] + [len(r) for r in rows])
    item = np.concatenate(rows).astype(np.int32)
    times = np.zeros(6, np.int64)
    chosen = np.array([0, 0, 1, 0, 0])
    times[[0, 3]] = 1
    greedy_cover(start, item, times, chosen)
    prune_cover(start, item, times, chosen, np.zeros(5, np.int64))
    assert chosen.tolist() == [1, 1, 0, 0, 0]


def test_a_sphere_is_one_sphere(ball):
    fit = decompose(ball, outward=0.002, inward=0.002, **RADII)
    assert (
        len(fit.radius) == 1
        and np.linalg.norm(fit.centre) < 1e-3
        and abs(fit.radius[0] - 0.1) < 1e-3
    )


def test_a_capsule_wants_about_as_many_spheres_as_arithmetic_says(capsule):
    fit = decompose(capsule, outward=0.003, inward=0.003, **RADII)
    # spheres of r + t whose seams fall to r - t: steps of 2 sqrt((r + t)^2 - (r - t)^2), and the
    # ends
    step = 2 * np.sqrt(0.053**2 - 0.047**2)
    assert kept(fit, capsule) and 0.3 / step - 1 <= len(fit.radius) <= 1.3 * (0.3 / step + 2)
    assert np.hypot(fit.centre[:, 0], fit.centre[:, 1]).max() < 0.004


def test_a_torus_is_a_ring_of_spheres(torus):
    fit = decompose(torus, outward=0.004, inward=0.004, **RADII)
    off = np.hypot(np.hypot(fit.centre[:, 0], fit.centre[:, 1]) - 0.1, fit.centre[:, 2])
    assert kept(fit, torus) and off.max() < 0.008 and 14 <= len(fit.radius) <= 26


def test_a_known_union_is_recovered():
    rng = np.random.default_rng(3)
    truth = np.column_stack(
        [np.arange(6) * 0.06, rng.normal(size=(6, 2)) * 0.02, rng.uniform(0.035, 0.06, 6)]
    )
    fit = decompose(union_of(truth), count=6, **RADII)
    gap = np.linalg.norm(fit.centre[:, None] - truth[:, :3], axis=2)
    nearest = gap.argmin(axis=1)
    assert sorted(nearest) == list(range(6)) and gap.min(axis=1).max() < 0.002
    assert np.abs(fit.radius - truth[nearest, 3]).max() < 0.002


@pytest.mark.parametrize("outward, inward", [(0.003, 0.006), (0.006, 0.004)])
def test_the_tolerance_holds_both_ways(torus, outward, inward):
    fit = decompose(torus, outward=outward, inward=inward, **RADII)
    assert (
        kept(fit, torus)
        and fit.quality.inside <= outward + 1e-12
        and fit.quality.outside <= inward + 1e-12
    )


def test_a_box_with_edges_keeps_the_tolerance():
    box = surface_of(trimesh.creation.box((0.1, 0.08, 0.06)))
    fit = decompose(box, outward=0.003, inward=0.003, **RADII)
    assert kept(fit, box)


def test_the_same_seed_gives_the_same_spheres_and_another_others(torus):
    one, same, other = (
        decompose(torus, outward=0.006, inward=0.006, seed=s, **RADII) for s in (1, 1, 2)
    )
    assert np.array_equal(one.centre, same.centre) and np.array_equal(one.radius, same.radius)
    assert one.centre.shape != other.centre.shape or not np.allclose(one.centre, other.centre)


def test_the_last_digits_of_a_surface_move_no_centre_that_spheres_are_chosen_from(torus):
    noise = 1e-16 * np.random.default_rng(3).standard_normal(torus.vertices.shape)
    limits = FitBounds(0.003, 0.1, 0.004, 0.004)
    one, other = (
        inner_balls(
            surface,
            random_samples(surface, 500, seed=1),
            limits,
            slack=np.zeros(500),
            bits=np.ones(500, dtype=np.int64),
            regions=Regions(),
        )
        for surface in (torus, sealed(torus.vertices + noise, torus.faces))
    )
    # but for a few at the border of two whole nanometres
    assert np.mean(one.centre == other.centre) > 0.99
    assert np.mean(one.depth == other.depth) > 0.99


def test_a_joint_sphere_stands_exactly_where_asked(capsule):
    fit = decompose(
        capsule, outward=0.004, inward=0.004, joints=[[0, 0, 0.1], [0.01, 0, -0.12]], **RADII
    )
    assert np.array_equal(fit.centre[:2], [[0, 0, 0.1], [0.01, 0, -0.12]]) and fit.joints == 2
    assert np.allclose(fit.radius[:2], [0.05, 0.04], atol=2e-4) and kept(fit, capsule)
    given = decompose(capsule, count=8, joints=[[0, 0, 0.1, 0.03]], **RADII)
    assert given.radius[0] == 0.03


def test_a_count_gives_exactly_that_many_and_says_what_holds(torus):
    fit = decompose(torus, count=16, **RADII)
    assert len(fit.radius) == fit.quality.spheres == 16 and kept(fit, torus)


def test_quality_of_a_slightly_large_sphere_is_known(ball):
    found = fit_quality(ball, np.zeros((1, 3)), np.array([0.103]))
    assert found.mean == pytest.approx(0.003, rel=0.05) and found.inside == pytest.approx(
        0.003, rel=0.1
    )
    assert found.volume_ratio == pytest.approx(1.03**3, rel=0.01) and found.iou == pytest.approx(
        1.03**-3, rel=0.01
    )
    assert found.outside < 1e-3 and found.largest == pytest.approx(0.003, rel=0.15)


def test_an_enclosed_cavity_is_filled_and_shells_are_joined():
    outer = trimesh.creation.icosphere(3, 0.1)
    inner = trimesh.creation.icosphere(3, 0.03)
    inner.invert()
    both = trimesh.util.concatenate(
        [outer, inner, trimesh.creation.icosphere(3, 0.05).apply_translation([0.1, 0, 0])]
    )
    found = surface_of(both)
    assert (
        "2 shells are joined to 1" in found.notes and "1 enclosed cavity is filled" in found.notes
    )
    assert found.distance([[0, 0, 0]])[0] == pytest.approx(-0.1, rel=0.02)


def broken(kind):
    mesh = trimesh.creation.icosphere(2, 0.1)
    if kind == "open":
        mesh.faces = mesh.faces[:-1]
    if kind == "inside out":
        mesh.invert()
    if kind == "m large":
        mesh.apply_scale(1000)
    if kind == "crosses itself":
        mesh.vertices[mesh.vertices[:, 2] > 0.08, 2] -= 0.3
    if kind == "not finite":
        mesh.vertices[0, 0] = np.nan
    return mesh.vertices, mesh.faces


@pytest.mark.parametrize("kind", ["open", "inside out", "m large", "crosses itself"])
def test_a_bad_mesh_is_refused_in_words(kind):
    with pytest.raises(InputError, match=kind):
        sealed(*broken(kind), what="scan.obj")


def test_a_mesh_with_numbers_that_are_not_finite_is_refused_by_the_argument():
    with pytest.raises(UsageError, match="vertices: expected finite numbers, got nan"):
        sealed(*broken("not finite"), what="scan.obj")


def test_a_tolerance_the_radii_forbid_is_refused_with_what_is_reachable():
    thin = surface_of(trimesh.creation.capsule(0.2, 0.006, count=(24, 24)))
    with pytest.raises(
        InputError, match=r"too thin for spheres of 20 mm .* it can be with a least radius of"
    ) as said:
        decompose(thin, outward=0.002, inward=0.002, least_radius=0.02, greatest_radius=0.1)
    least = float(str(said.value).split("least radius of ")[1].split()[0]) / 1e3
    assert kept(
        decompose(
            thin, outward=0.002, inward=0.002, least_radius=least * 0.99, greatest_radius=0.1
        ),
        thin,
    )


@pytest.mark.parametrize(
    "options, said",
    [
        ({}, "outward and inward are needed"),
        ({"outward": 0.001}, "are needed"),
        ({"outward": -1, "inward": 1}, "outward: expected a length of"),
        ({"outward": 0.01, "inward": 0.01, "least_radius": 0.3}, "greater than greatest_radius"),
        ({"count": 0}, "count: "),
        ({"outward": 0.001, "inward": 0.001, "joints": [[1, 2]]}, "three or four"),
        ({"outward": 0.001, "inward": 0.001, "joints": [[1, 0, 0]]}, "outside the surface"),
        ({"outward": 0.001, "inward": 0.001, "joints": [[0, 0, 0, 0.2]]}, "is not possible"),
        ({"outward": 1e-6, "inward": 1e-6}, "outward: expected a length of 1e-05 to 10 m"),
    ],
)
def test_contradictions_are_refused(ball, options, said):
    with pytest.raises((InputError, UsageError), match=said):
        decompose(ball, **(RADII | options))


def test_a_tolerance_that_a_surface_is_too_large_for_is_refused():
    large = surface_of(trimesh.creation.icosphere(subdivisions=3, radius=4.0))
    with pytest.raises(InputError, match="mm can be reached on a surface of this size"):
        decompose(large, outward=1e-5, inward=1e-5, **RADII)


@pytest.mark.nightly
@needs_adult
def test_a_whole_adult_of_400_spheres_is_near(adult):
    fit = decompose(adult, count=400, **RADII)
    assert (
        fit.quality.mean < 1.7e-3
        and fit.quality.p95 < 4.5e-3
        and fit.quality.iou > 0.955
        and kept(fit, adult, samples=100_000)
    )


@pytest.mark.nightly
@needs_adult
def test_a_body_is_cut_into_segments_that_share_their_joint_spheres(adult):
    bones = adult_bones()
    fit = fit_segments(adult, bones, outward=0.014, inward=0.014, **RADII)
    place, served = bones.joints()
    assert kept(fit.fit, adult, samples=100_000) and np.array_equal(
        fit.fit.centre[: len(place)], place
    )
    assert (
        np.array_equal(fit.member[: len(place)], served)
        and (fit.member[len(place) :].sum(axis=1) == 1).all()
    )
    assert all(row.spheres > 3 and row.mean < 0.007 for row in fit.parts)


def adult_bones():
    """A few bones of the adult in its own pose, x forward, y left, z up [m]."""
    rows = {"trunk": ([0, 0, -0.05], [0, 0, 0.45]), "head": ([0, 0, 0.55], [0.03, 0, 0.8])}
    return Bones(
        tuple(rows),
        np.array([r[0] for r in rows.values()]),
        np.array([r[1] for r in rows.values()]),
    )
