"""Reach envelopes: closed forms, laws, sampled postures that must lie within, obstacles, ease,
people."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import box_part, environment_of
from tests.rows import changed
from tests.test_reach import LOWER, NEAREST, PLANAR, UPPER, legal, tip_of
from workbench import limb, load_body
from workbench.posture.reaching.limbs import Limb
from workbench.study.envelope.asking import (
    asked,
    drawn,
    level_rays,
    point_rays,
    ray_grid,
    solid_angles,
)
from workbench.study.envelope.ends import ray_ends

HAND = {"name": "right hand", "grip": "grasp"}


@pytest.fixture(scope="module")
def sitting(bubbleman):
    """The median man sitting, and a point at his hips."""
    flexed = {
        "LH": {"flexion": 90},
        "RH": {"flexion": 90},
        "LK": {"flexion": 90},
        "RK": {"flexion": 90},
    }
    return wb.pose(bubbleman, flexed, reference="LT"), np.array([-0.1, 0.0, -0.1])


@pytest.fixture(scope="module")
def free(bubbleman, sitting):
    poses, origin = sitting
    return wb.reach_envelope(bubbleman, poses, origin, levels=False, **HAND)


@pytest.fixture(scope="module")
def walled(bubbleman, sitting):
    """The same before a wall 350 mm ahead of the origin, and a post beyond reach."""
    poses, origin = sitting
    cab = environment_of(
        box_part("wall", [0.25, -1.5, -1.0], [0.30, 1.5, 1.5]),
        box_part("post", [-0.1, -2.6, -1.0], [0.1, -2.5, 1.5]),
    )
    return wb.reach_envelope(bubbleman, poses, origin, environment=cab, levels=False, **HAND), cab


def planar_ends(body, first, second, rays=None):
    """The ends of rays about the first joint of two links of these lengths, the second of which
    bends 0 to 140 degrees."""
    arm = replace_lengths(body, first)
    chain = Limb(
        "arm",
        0,
        2,
        (0, 1),
        np.array([0, 0, -second]),
        np.array([0, 0, -1.0]),
        (1, 2),
        np.ones(3, dtype=bool),
    )
    task = asked(arm, wb.pose(arm, {}), chain)
    if rays is None:
        rays = point_rays(np.zeros((1, 3)), *ray_grid(15))
    return rays, ray_ends(task, rays, drawn(task, 512))


def replace_lengths(body, first):
    at = body.joint_in_parent[0].copy()
    at[1] = [0, 0, -first]
    return changed(body, joint_in_parent=at)


@pytest.fixture(scope="module")
def planar(tmp_path_factory):
    path = tmp_path_factory.mktemp("envelope") / "planar.yaml"
    path.write_text(PLANAR)
    return load_body(path)


def test_two_links_in_a_plane_reach_from_the_bent_to_the_straight_arm_and_nowhere_else(planar):
    rays, ends = planar_ends(planar, UPPER, LOWER)
    inside = np.abs(rays.direction[:, 1]) < 1e-9
    assert np.array_equal(ends.reached, inside) and inside.sum() == 24
    # straight up is 10 degrees past the first link's stop: the second must bend to get there
    ten = np.radians(10)
    bent = UPPER * np.cos(ten) + np.sqrt(LOWER**2 - (UPPER * np.sin(ten)) ** 2)
    assert ends.outer[inside] == pytest.approx([*np.full(23, UPPER + LOWER), bent], abs=5e-4)
    # the bent arm points 56 degrees off the first link; the ray 120 degrees back is 64 from its
    # stop, and gets 50
    fifty = np.radians(50)
    stopped = UPPER * np.cos(fifty) + np.sqrt(LOWER**2 - (UPPER * np.sin(fifty)) ** 2)
    back = np.argmax(
        rays.direction[inside] @ [-np.sin(np.radians(120)), 0, -np.cos(np.radians(120))]
    )
    least = np.where(np.arange(24) == back, stopped, NEAREST)
    assert ends.inner[inside] == pytest.approx(least, abs=1e-3)


@given(st.floats(0.1, 0.4), st.floats(0.1, 0.4), st.floats(0.0, 0.2), st.floats(-2.9, 2.9))
@settings(max_examples=25)
def test_a_longer_arm_never_reaches_less(planar, first, second, more, angle):
    direction = np.array([[np.cos(angle), 0.0, np.sin(angle)]])
    ray = point_rays(np.zeros((1, 3)), direction, np.zeros((0, 3), dtype=np.int64))
    short, long = (
        planar_ends(planar, first, length, ray)[1].outer[0] for length in (second, second + more)
    )
    assert long >= short - 5e-4
    if abs(angle - np.pi / 2) > np.radians(10):  # else the first link's stops are in the way
        assert short == pytest.approx(first + second, abs=5e-4)


def test_all_lengths_twice_as_long_reach_twice_as_far(planar):
    inside = np.arange(0, 266)[np.abs(ray_grid(15)[0][:, 1]) < 1e-9]
    one, two = (planar_ends(planar, s * UPPER, s * LOWER)[1] for s in (1, 2))
    assert two.outer[inside] == pytest.approx(2 * one.outer[inside], abs=1e-3)
    assert two.inner[inside] == pytest.approx(2 * one.inner[inside], abs=1e-3)


def scaled_body(body, s):
    """A body with all lengths times s."""
    return changed(
        body,
        joint_in_parent=s * body.joint_in_parent[0],
        joint_in_child=s * body.joint_in_child[0],
        centre=s * body.centre[0],
        radius=s * body.radius[0],
        twist_point=s * body.twist_point[0],
    )


def test_a_body_scaled_by_s_has_an_envelope_scaled_by_s(bubbleman, sitting, free):
    poses, origin = sitting
    large = wb.reach_envelope(
        scaled_body(bubbleman, 1.1), poses, 1.1 * origin, levels=False, **HAND
    )
    assert large.volume == pytest.approx(1.1**3 * free.volume, rel=0.01)
    off = np.abs(large.about.outer - 1.1 * free.about.outer)
    assert np.mean(off < 2e-3) > 0.95


def test_the_mirrored_hand_has_the_mirrored_envelope(bubbleman, sitting, free):
    poses, origin = sitting
    left = wb.reach_envelope(bubbleman, poses, origin, name="left hand", grip="grasp", levels=False)
    assert left.volume == pytest.approx(free.volume, rel=0.01)
    partner = np.argmax(left.about.direction @ (free.about.direction * [1, -1, 1]).T, axis=0)
    off = np.abs(left.about.outer[partner] - free.about.outer)
    assert np.mean(off < 2e-3) > 0.95


def beyond(found, outer, tips, degrees):
    """How far (M,) [m] tips within a narrow cone about a ray are beyond its outer end and twice
    what that gains toward the rays beside within the cone's angle; of those that are in one."""
    about = found.about
    off = tips - about.origin[0]
    far = np.linalg.norm(off, axis=1)
    share = (off / far[:, None]) @ about.direction.T
    ray = share.argmax(axis=1)
    near = share.max(axis=1) > np.cos(np.radians(degrees))
    beside = point_rays(found.origin[None], about.direction, found.triangles).beside
    most = np.where(beside >= 0, outer[beside], 0.0).max(axis=1)
    slack = 2 * np.maximum(most - outer, 0.0) * degrees / np.degrees(found.step)
    return (far - outer[ray] - slack[ray])[near]


def sampled_check(bubbleman, found, sitting, count, cab=None):
    arm = limb(bubbleman, **HAND)
    poses = legal(bubbleman, arm, count, seed=3)
    base = wb.place(bubbleman, sitting[0]).world_from_segment[0, arm.base]
    poses = wb.Poses(poses.rotations, arm.base, np.broadcast_to(base, (count, 3, 4)))
    if cab is not None:
        clear = reach_side_clear(bubbleman, poses, arm, cab)
        poses = wb.Poses(poses.rotations[clear], arm.base, poses.world_from_reference[clear])
    outer = np.where(found.about.clear, found.about.clear_outer, 0.0)
    return beyond(found, outer, tip_of(bubbleman, poses, arm), 1.0)


def reach_side_clear(body, poses, arm, cab):
    """Whether the spheres of an arm (those of a reaching hand's fingers aside) touch a cab."""
    placed = wb.place(body, poses)
    clear = np.ones(len(poses), dtype=bool)
    for part in cab.parts:
        k = cab.parts.index(part)
        corners = cab.vertices[
            cab.edges[cab.edge_start[cab.part_start[k]] : cab.edge_start[cab.part_start[k + 1]]]
        ]
        low = corners.reshape(-1, 3).min(axis=0)
        high = corners.reshape(-1, 3).max(axis=0)
        centres = placed.centres[:, arm.solid[0]]
        gap = np.linalg.norm(np.maximum(np.maximum(low - centres, centres - high), 0.0), axis=2)
        clear &= np.all(gap > body.radius[0, arm.solid[0]], axis=1)
    return clear


def test_no_sampled_posture_goes_beyond_the_envelope(bubbleman, free, sitting):
    past = sampled_check(bubbleman, free, sitting, 3000)
    assert len(past) > 30 and past.max() < 0.01


def test_no_clear_sampled_posture_goes_beyond_the_envelope_with_obstacles(
    bubbleman, walled, sitting
):
    found, cab = walled
    past = sampled_check(bubbleman, found, sitting, 3000, cab)
    assert len(past) > 20 and past.max() < 0.01


@pytest.mark.nightly
def test_none_of_many_postures_goes_beyond_the_envelopes(bubbleman, free, walled, sitting):
    for found, cab in ((free, None), walled):
        past = sampled_check(bubbleman, found, sitting, 30_000, cab)
        assert len(past) > 200 and past.max() < 0.015 and np.mean(past > 5e-3) < 1e-3


def test_the_ends_of_the_rays_are_reached(bubbleman, free, sitting):
    poses, origin = sitting
    about = free.about
    ends = origin + about.outer[about.reached, None] * about.direction[about.reached]
    found = wb.reach(bubbleman, poses, ends, limb=limb(bubbleman, **HAND), restarts=40)
    assert np.mean(found.miss < 1e-3) > 0.97


def test_a_wall_takes_what_lies_beyond_it_and_leaves_what_does_not(walled, free, sitting):
    found, _ = walled
    assert list(found.lost_to) == ["wall"] and 0.05 < found.lost / found.volume < 0.9
    np.testing.assert_allclose(found.about.outer, free.about.outer, atol=1e-12)
    x = found.about.direction[:, 0]
    tips = sitting[1][0] + found.about.clear_outer * x
    assert np.all(tips[found.about.clear] < 0.252)
    back = found.about.reached & (x < -0.3)
    assert np.mean(found.about.clear_outer[back] > found.about.outer[back] - 1e-3) > 0.8


def test_ease_is_nested_and_lies_within_the_envelope(free):
    easy, moderate = (np.where(np.isfinite(outer), outer, 0.0) for outer in free.about.easy_outer)
    assert np.all(easy <= moderate + 1e-9) and np.all(moderate <= free.about.outer + 1e-9)
    assert 0.02 < np.mean(easy**3) / np.mean(free.about.outer**3) < 0.6


def test_the_discomfort_where_ease_ends_is_that_of_its_grade(bubbleman, sitting, free):
    from workbench.study.envelope.envelope import MOST_DISCOMFORT

    poses, origin = sitting
    for outer, most in zip(free.about.easy_outer, MOST_DISCOMFORT, strict=True):
        rows = np.flatnonzero(np.isfinite(outer) & (outer < free.about.outer - 0.06))[::5]
        at = origin + outer[rows, None] * free.about.direction[rows]
        found = wb.reach(bubbleman, poses, at, limb=limb(bubbleman, **HAND))
        assert np.median(np.abs(found.discomfort - most)) < 0.1 * most


def test_the_surface_is_closed_and_holds_the_volume(free, walled):
    import manifold3d

    for envelope, clear in ((free, False), (walled[0], False)):
        points, faces = envelope.surface(clear=clear)
        edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        forward, backward = (
            np.unique(e, axis=0, return_counts=True) for e in (edges, edges[:, ::-1])
        )
        assert np.array_equal(forward[0], backward[0]) and np.array_equal(forward[1], backward[1])
        solid = manifold3d.Manifold(
            manifold3d.Mesh(points.astype(np.float32), faces.astype(np.uint32))
        )
        assert solid.status() == manifold3d.Error.NoError
        assert solid.volume() == pytest.approx(envelope.volume, rel=0.1)


@pytest.mark.nightly
def test_the_volume_of_the_coarse_grid_is_that_of_a_fine_one(bubbleman, sitting, free):
    poses, origin = sitting
    fine = wb.reach_envelope(bubbleman, poses, origin, step=5, levels=False, **HAND)
    assert free.volume == pytest.approx(fine.volume, rel=0.02)


def test_the_grid_of_rays_is_a_closed_surface_that_faces_out():
    direction, triangles = ray_grid(15)
    assert len(direction) == 24 * 11 + 2
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(edges, axis=0)) == len(edges)
    assert {tuple(e) for e in edges} == {tuple(e[::-1]) for e in edges}
    a, b, c = (direction[triangles[:, k]] for k in range(3))
    volume = np.sum(np.cross(a, b) * c) / 6
    assert volume == pytest.approx(4 / 3 * np.pi, rel=0.03) and np.all(
        np.sum(np.cross(a, b) * c, axis=1) > 0
    )
    assert solid_angles(direction, np.radians(15)).sum() == pytest.approx(4 * np.pi)


def test_rays_know_those_beside_them():
    rays = level_rays(np.zeros(3), np.array([0.0, 0.15]), 15)
    assert sorted(rays.beside[0].tolist()) == [-1, 1, 23, 24] and np.all(
        rays.origin[24:, 2] == 0.15
    )
    pole = point_rays(np.zeros((2, 3)), *ray_grid(15)).beside[264]
    assert set(pole[pole >= 0]) <= set(range(24)) and (pole >= 0).sum() == 8


def test_level_sections_agree_with_the_rays_about_the_point(bubbleman, sitting):
    poses, origin = sitting
    found = wb.reach_envelope(bubbleman, poses, origin, step=30, **HAND)
    level = np.flatnonzero(np.abs(found.about.direction[:, 2]) < 1e-9)
    zero = int(np.flatnonzero(np.abs(found.heights) < 1e-9)[0]) * 12 + np.arange(12)
    np.testing.assert_allclose(
        found.levels.direction[zero], found.about.direction[level], atol=1e-12
    )
    assert np.median(np.abs(found.levels.outer[zero] - found.about.outer[level])) < 1e-3
    assert found.heights[1] - found.heights[0] == pytest.approx(0.15)


def test_the_percentile_of_people_is_that_of_their_radii(bubbleman, sitting):
    poses, origin = sitting
    bodies = wb.stack_bodies([scaled_body(bubbleman, s) for s in (0.9, 1.0, 1.1)])
    three = wb.join_poses([poses] * 3)
    low, middle = (
        wb.people_envelope(bodies, three, origin, percentile=p, step=30, **HAND) for p in (5, 50)
    )
    one = wb.reach_envelope(bodies[0], poses, origin, step=30, levels=False, **HAND)
    both = low.about.reached & one.about.reached
    assert np.mean(np.abs(low.about.outer - one.about.outer)[both] < 5e-3) > 0.8
    assert np.all(low.about.outer[both] <= middle.about.outer[both] + 1e-9) and low.people == 3
    with pytest.raises(wb.UsageError, match="0 to 50, got 95"):
        wb.people_envelope(bodies, three, origin, percentile=95, **HAND)


FITTED = [
    ("bubbleman", "male", 0.811),
    ("bubbleman", "female", 0.742),
    ("adult_male", "male", 0.811),
    ("adult_female", "female", 0.742),
]


@pytest.mark.parametrize(("name", "sex", "given"), FITTED)
def test_a_body_fitted_to_a_thumb_tip_reach_reaches_that_far_from_the_wall_and_little_farther(
    name, sex, given
):
    person = wb.person_body(
        wb.load_body(name),
        wb.load_population_model("ansur2"),
        sex=sex,
        measures={"thumb_tip_reach": given},
    )
    body = person.body
    arm = limb(person.body, "right hand", grip="pinch")
    placed = wb.place(body, wb.pose(body, {"RS": {"flexion": 90}}, reference="UT"))
    torso = np.isin(body.sphere_segment, [body.segment(code) for code in ("LT", "CT", "UT")])
    wall = (placed.centres[0, :, 0] - body.radius[0])[torso].min()
    world = placed.world_from_segment[0, arm.end]
    tip = world[:, :3] @ arm.tip[0] + world[:, 3]
    assert tip[0] - wall == pytest.approx(given, abs=1e-3)
    ahead = np.array([[wall + given + more, tip[1], tip[2]] for more in (0.0, 0.2)])
    found = wb.reach(body, wb.pose(body, {}, reference="UT"), ahead, limb=arm)
    assert found.reached[0, 0] and 0.0 < found.tip[0, 1, 0] - wall - given < 0.025
