"""Least distances of segment pairs against all pairs of spheres; eight lanes compiled and not."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.rows import changed
from tests.test_blend import random_blend
from workbench.contact.collide import self_clearance
from workbench.geometry import simd8
from workbench.model.skinning import enclosing_spheres


def crowded(body, seed, *, most=200, grid=0.0):
    """The body with up to so many spheres a segment, at random places; on a grid [m] many distances
    are equal."""
    rng = np.random.default_rng(seed)
    counts = rng.integers(0, most, len(body.segments))
    counts[rng.integers(len(counts))] = 0
    owner = np.repeat(np.arange(len(counts)), counts)
    centre = rng.normal(size=(len(owner), 3)) * 0.1
    centre = np.round(centre / grid) * grid if grid else centre
    radius = rng.choice([0.01, 0.02], len(owner)) if grid else rng.uniform(0.001, 0.06, len(owner))
    start = np.concatenate([[0], np.cumsum(counts)])
    made = changed(
        body, **(spheres(len(owner)) | {"centre": centre, "radius": radius, "start": start})
    )
    (middle,), (reach,) = enclosing_spheres(made)
    return changed(made, enclosing_centre=middle, enclosing_radius=reach)


def spheres(count):
    """What so many spheres need beside their start: all alike, still and without names."""
    return {
        "centre": np.zeros((count, 3)),
        "radius": np.ones(count),
        "sphere_names": ("",) * count,
        "sphere_direction": np.full(count, -1),
        "twist_share": np.zeros(count),
        "blend_joint": np.full(count, -1),
        "blend_share": np.zeros(count),
    }


def all_pairs(one, other, p, a, b):
    """Least I of segments a and b in pose p and its spheres, by every pair; of equal ones the
    first."""
    s = one.body.spheres(a)
    t = other.body.spheres(b)
    away = one.centres[p, s][:, None] - other.centres[p, t][None]
    gap = np.sqrt(away[..., 0] ** 2 + away[..., 1] ** 2 + away[..., 2] ** 2)
    gap = gap - (one.body.radius[0, s][:, None] + other.body.radius[0, t][None])
    if not gap.size:
        return np.inf, -1, -1
    u, v = np.unravel_index(np.argmin(gap), gap.shape)
    return gap[u, v], one.body.start[a] + u, other.body.start[b] + v


def check_pairs(one, other, found, pairs):
    for p in range(len(one)):
        for a, b in pairs:
            told = found.distance[p, a, b], found.sphere[p, a, b], found.target[p, a, b]
            assert told == all_pairs(one, other, p, a, b)


def own_pairs(body):
    return np.argwhere(np.triu(~body.adjacent)).tolist()


@given(st.integers(0, 10**6), st.sampled_from([0.0, 0.02]), st.sampled_from([0.0, 1e4]))
def test_the_least_of_each_segment_pair_is_that_of_all_sphere_pairs(
    one_arm, random_arm, seed, grid, far
):
    body = crowded(one_arm, seed, most=120, grid=grid)
    poses = random_arm(3, seed)
    world = poses.world_from_reference.copy()
    still = np.broadcast_to([1.0, 0.0, 0.0, 0.0], poses.rotations.shape)
    world[:, :, 3] += far
    if grid:  # nothing turned: many pairs are equally near
        world[:, :, :3] = np.eye(3)
    placed = wb.place(body, wb.Poses(still if grid else poses.rotations, 0, world))
    check_pairs(placed, placed, self_clearance(placed), own_pairs(body))


@given(st.integers(0, 10**6), st.sampled_from([0.0, 0.3, 1e3, 1e6]))
def test_two_bodies_far_apart_or_one_in_the_other_have_the_least_of_all_pairs(
    one_arm, random_arm, seed, far
):
    poses = random_arm(2, seed)
    world = poses.world_from_reference.copy()
    world[:, 0, 3] += far
    one = wb.place(crowded(one_arm, seed, most=40), poses)
    other = wb.place(
        crowded(one_arm, seed + 1, most=90), wb.Poses(random_arm(2, seed + 1).rotations, 0, world)
    )
    pairs = np.argwhere(np.ones((len(one.window), len(other.window)), dtype=bool)).tolist()
    check_pairs(one, other, wb.body_clearance(one, other), pairs)


@given(st.integers(0, 10**6))
def test_blended_and_twisted_spheres_have_the_least_of_all_pairs(one_arm, random_arm, seed):
    body = random_blend(crowded(one_arm, seed, most=60), seed)
    placed = wb.place(body, random_arm(3, seed, spread=3.0))
    check_pairs(placed, placed, self_clearance(placed), own_pairs(body))


def test_spheres_at_one_place_are_as_far_apart_as_their_radii_say(one_arm):
    # one hundred spheres at the middle of each segment, unturned: nothing is nearer than anything
    # else
    body = crowded(one_arm, 1, grid=10.0)
    poses = wb.pose(one_arm, {})
    one = wb.place(body, poses)
    other = wb.place(body, poses)
    found = wb.body_clearance(one, other)
    check_pairs(one, other, found, [(a, a) for a in range(len(body.segments))])
    assert np.nanmin(found.distance) == -0.04


def test_the_one_answers_what_the_other_does_in_batches_of_any_size(one_arm, random_arm):
    body = crowded(one_arm, 5)
    poses = random_arm(300, 5)
    whole = self_clearance(wb.place(body, poses))
    for p in (0, 127, 128, 299):
        alone = wb.Poses(poses.rotations[p : p + 1], 0, poses.world_from_reference[p : p + 1])
        mine = self_clearance(wb.place(body, alone))
        for name in ("distance", "sphere", "target", "point", "facing"):
            assert np.array_equal(getattr(mine, name)[0], getattr(whole, name)[p], equal_nan=True)


numbers = st.lists(st.floats(-1e6, 1e6, width=32), min_size=8, max_size=8)


@given(numbers, numbers)
def test_the_lanes_do_compiled_what_their_definitions_say(a, b):
    from tests.lanes_compiled import every_lane_function

    a = np.array(a, dtype=np.float32)
    b = np.array(b, dtype=np.float32)
    out = np.zeros(8 * 16, dtype=np.float32)
    bits = every_lane_function(a, b, out)
    wanted = [
        a + b,
        a - b,
        a * b,
        simd8.larger(a, b),
        simd8.root(np.abs(a)),
        simd8.splat8(a[3]),
        simd8.splat8(simd8.greatest(b)),
    ]
    for row, values in enumerate(wanted):
        assert np.array_equal(out[8 * row : 8 * row + 8], values)
    below = simd8.not_above(a, b)
    assert bits == (below, simd8.lowest_set_bit(below), simd8.how_many(below))
