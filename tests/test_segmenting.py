"""Bodies cut into segments: who holds what, joint spheres, and no notch where a joint bends."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from workbench import Bones, InputError, UsageError, fit_segments, sealed
from workbench.body.fitting.candidates import random_samples
from workbench.body.fitting.polish import union_field
from workbench.body.fitting.segmenting import regions_of, symmetric_fit

RADII = {"least_radius": 0.002, "greatest_radius": 0.2}
TOLERANCE = 0.004
ARM = Bones(
    ("upper", "lower"),
    np.array([[0, 0, 0.16], [0, 0, 0.0]]),
    np.array([[0, 0, 0.0], [0, 0, -0.16]]),
)


def limb(wide=1.0):
    """A straight limb along z, 80 mm thick, `wide` times as wide (y)."""
    mesh = trimesh.creation.capsule(0.4, 0.04, count=(32, 32))
    mesh.apply_translation([0, 0, -0.2])
    if not np.allclose(mesh.bounds.mean(axis=0), 0, atol=1e-6):
        mesh.apply_translation(-mesh.bounds.mean(axis=0))
    return sealed(mesh.vertices * [1, wide, 1], mesh.faces)


@pytest.fixture(scope="module", params=[1.0, 1.4], ids=["round", "wide"])
def arm(request):
    surface = limb(request.param)
    return surface, fit_segments(surface, ARM, outward=TOLERANCE, inward=TOLERANCE, **RADII)


def turn(angle):
    """Flexion about y, which takes -z forward (rotation matrix)."""
    c = np.cos(angle)
    s = np.sin(angle)
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def test_the_sphere_at_the_joint_is_exact_and_in_both_segments(arm):
    fit = arm[1]
    assert np.array_equal(fit.fit.centre[0], [0, 0, 0]) and fit.member[0].tolist() == [True, True]
    assert (fit.member[1:].sum(axis=1) == 1).all()


def test_each_segment_holds_its_own_part_by_itself(arm):
    surface, fit = arm
    places = random_samples(surface, 20_000, seed=3).point
    number = regions_of(surface, ARM).number(places)
    assert (
        np.array_equal(number, (places[:, 2] < 0).astype(int))
        or np.mean(number == (places[:, 2] < 0)) > 0.99
    )
    for k, name in enumerate(fit.segments):
        centre, radius = fit.spheres(name)
        assert union_field(places[number == k], centre, radius)[0].max() <= TOLERANCE + 1e-9
        assert fit.parts[k].outside <= 1.02 * TOLERANCE and fit.parts[k].inside <= TOLERANCE + 1e-12


def test_the_spheres_of_a_symmetric_surface_are_each_others_images_and_hold_as_before(arm):
    surface, fit = arm
    regions = regions_of(surface, ARM)
    made = symmetric_fit(surface, regions, fit, np.arange(2), 0.0)
    balls = np.column_stack([made.fit.centre, made.fit.radius, made.member])
    image = balls * [1, -1, 1, 1, 1, 1]
    assert np.array_equal(np.unique(balls, axis=0), np.unique(image + 0.0, axis=0))
    assert len(np.unique(balls, axis=0)) == len(balls) and balls[0, :3].tolist() == [0, 0, 0]
    for before, part in zip(fit.parts, made.parts, strict=True):
        assert part.outside <= 1.02 * max(TOLERANCE, before.outside)
        assert part.inside <= TOLERANCE + 1e-9


@pytest.mark.parametrize("degrees", [0, 45, 90])
def test_no_notch_opens_and_nothing_stands_out_where_the_joint_bends(arm, degrees):
    surface, fit = arm
    bend = turn(np.radians(degrees))
    (upper, lower), (r_upper, r_lower) = zip(
        *(fit.spheres(name) for name in fit.segments), strict=True
    )
    centre = np.concatenate([upper, lower @ bend.T])
    radius = np.concatenate([r_upper, r_lower])
    places = random_samples(surface, 20_000, seed=3).point
    # the bent limb: both straight parts, and the ring at the joint swept from one to the other
    ring = places[np.abs(places[:, 2]) < 0.002] * [1, 1, 0]
    swept = [ring @ turn(angle).T for angle in np.radians(np.linspace(0, degrees, 19))]
    bent = np.concatenate([places[places[:, 2] > 0], places[places[:, 2] < 0] @ bend.T, *swept])
    assert union_field(bent, centre, radius)[0].max() <= TOLERANCE + 2e-4


def test_volumes_of_the_parts_are_those_of_the_whole(arm):
    surface, fit = arm
    assert sum(p.volume for p in fit.parts) == pytest.approx(surface.volume, rel=1e-9)
    assert all(
        0.95 < p.volume_ratio < 1.15 and p.iou > 0.85 and p.mean < TOLERANCE for p in fit.parts
    )
    assert fit.parts[0].volume == pytest.approx(fit.parts[1].volume, rel=0.1)


def test_a_thick_trunk_keeps_its_side_from_a_thin_arm_that_hangs_beside_it():
    trunk = trimesh.creation.capsule(0.3, 0.15, count=(32, 32))
    arm = trimesh.creation.capsule(0.3, 0.03, count=(24, 24)).apply_translation([0, 0.22, 0])
    both = trimesh.util.concatenate([trunk, arm])
    surface = sealed(both.vertices, both.faces)
    middle = trunk.bounds.mean(axis=0)[2]
    line = np.array([[0, 0, middle - 0.15], [0, 0.22, middle - 0.15]])
    regions = regions_of(surface, Bones(("trunk", "arm"), line, line + np.array([0, 0, 0.3])))
    side = np.array([[0, 0.145, middle], [0, 0.2, middle]])
    assert regions.number(side).tolist() == [0, 1]


def test_a_count_is_shared_out_among_segments():
    fit = fit_segments(limb(), ARM, count=20, **RADII)
    assert (
        len(fit.fit.radius) == 20 and fit.member.any(axis=0).all() and fit.fit.quality.mean < 0.002
    )


@pytest.mark.parametrize(
    "bones, options, said",
    [
        (
            Bones(("a",), np.array([[1.0, 0, 0]]), np.array([[1.1, 0, 0]])),
            {},
            "middle of a lies outside the surface",
        ),
        (
            Bones(
                ("a", "b"),
                np.array([[0, 0, 0.1], [0.05, 0, 0]]),
                np.array([[0.05, 0, 0], [-0.04, 0, 0]]),
            ),
            {},
            r"the joint at \(0.050, 0.000, 0.000\) m lies .* mm outside",
        ),
        (ARM, {"count": 2}, "1 joints and 2 segments need 3 spheres"),
    ],
)
def test_a_skeleton_that_does_not_fit_is_refused_in_words(bones, options, said):
    with pytest.raises((InputError, UsageError), match=said):
        fit_segments(limb(), bones, **RADII, **options)
