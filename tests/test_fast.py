"""The fast paths against the slow oracles: grids, clusters, rays through solids, threads."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests import oracles
from tests.conftest import BOX, BOX_FACES, box_part, environment_of
from tests.test_blend import random_blend
from workbench import collides
from workbench.contact import collide
from workbench.contact.batches import build_clusters, clearance_by_part, grouped_clearance
from workbench.contact.collide import _plain, allowed_depth, clearance_of_groups, nearest
from workbench.contact.distance_fields import build_distance_field, packed_faces, packed_shells
from workbench.contact.kernels.clearance_groups import cluster_hub
from workbench.contact.kernels.distance_field import square_bound
from workbench.contact.kernels.point_in_solid import inside_part
from workbench.contact.kernels.search import nearest_in, record_gap, tied
from workbench.contact.kernels.wide_bvh import DEEP, EIGHT
from workbench.files.meshes.parts import RawPart
from workbench.geometry.polygon import point_polygon, winding_number
from workbench.model.environment import Allowance
from workbench.threads import run_in_threads


def soup(seed, count=12):
    """Random triangles, among them a point, a needle without area and a sliver."""
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(count, 3, 3)) * 0.4
    corners[0] = corners[0, 0]
    corners[1, 2] = 0.5 * (corners[1, 0] + corners[1, 1])
    corners[2, 2] = 0.5 * (corners[2, 0] + corners[2, 1]) + [1e-9, 0, 0]
    return RawPart("soup", corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def spindle(rings=24, length=0.6, radius=0.15):
    """A closed double cone of needles, 4 to a millimetre at its tips."""
    turn = np.linspace(0, 2 * np.pi, rings, endpoint=False)
    belt = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros(rings)], axis=1)
    points = np.concatenate([belt, [[0, 0, length], [0, 0, -length]]])
    here = np.arange(rings)
    then = (np.arange(rings) + 1) % rings
    faces = [
        np.stack([here, then, np.full(rings, rings)], 1),
        np.stack([then, here, np.full(rings, rings + 1)], 1),
    ]
    return RawPart(
        "spindle",
        points @ np.linalg.qr(np.arange(9).reshape(3, 3) + np.eye(3))[0],
        np.concatenate(faces),
    )


def pierced():
    """One closed part of two boxes that run through each other: winding number 2 where they
    overlap."""
    points = np.concatenate(
        [BOX * [0.6, 0.2, 0.2] - [0.3, 0.1, 0.1], BOX * [0.2, 0.2, 0.7] - [0.1, 0.11, 0.3]]
    )
    return RawPart("pierced", points, np.concatenate([BOX_FACES, BOX_FACES + 8]))


def moved(environment, by):
    """The environment somewhere else."""
    shift = np.array(by)
    return replace(
        environment,
        vertices=environment.vertices + shift,
        circle_centre=environment.circle_centre + shift,
        offset=environment.offset + environment.normal @ shift,
    )


ZOO = {
    "boxes": lambda seed: environment_of(
        box_part("floor", [-1, -1, -0.9], [1, 1, -0.8]),
        box_part("post", [-0.2, 0.15, -0.8], [-0.1, 0.25, 0.5]),
    ),
    "soup": lambda seed: environment_of(soup(seed), soup(seed + 1)),
    "needles": lambda seed: environment_of(spindle()),
    "pierced": lambda seed: environment_of(pierced(), spindle(7), solid=True),
    "flat": lambda seed: environment_of(
        box_part("sheet", [-1, -1, 0.1], [1, 1, 0.1 + 1e-9]), soup(seed)
    ),
}


def least_of_all(placed, environment):
    """(P, N) clearance of each segment to the nearest of all shown parts, through their grid."""
    shown = tuple(np.flatnonzero(~environment.hidden).tolist())
    return clearance_of_groups(placed, environment, (shown,), grid=True)[:, :, 0]


def compared(body, poses, environment):
    """Fast and oracle's clearance of the same poses; a pose more than the fast path needs."""
    placed = wb.place(body, poses)
    return placed, wb.clearance(placed, environment), oracles.clearance(placed, environment)


def with_rules(environment):
    """The environment with overlap allowed in its first part, more for one segment."""
    rules = (Allowance(0, ("LOWER", "UPPER"), 0.05), Allowance(0, ("all",), 0.01))
    return replace(environment, allowances=rules)


@pytest.mark.parametrize("kind", ZOO)
def test_room_is_the_least_clearance_with_what_is_allowed_added(one_arm, random_arm, kind):
    soft = with_rules(ZOO[kind](5))
    placed = wb.place(one_arm, random_arm(200, 8))
    wanted = (_plain(placed, soft)[0] + allowed_depth(one_arm, soft)).min(axis=2)
    assert np.array_equal(wb.room(placed, soft, grid=True), wanted, equal_nan=True)
    assert np.array_equal(wb.room(placed, soft, grid=False), wanted, equal_nan=True)


def test_room_of_many_poses_is_that_of_each(one_arm, random_arm, monkeypatch):
    soft = with_rules(ZOO["pierced"](5))
    poses = random_arm(300, 9)
    wanted = wb.room(wb.place(one_arm, poses), soft)
    monkeypatch.setattr(collide, "BLOCK", 70)
    assert np.array_equal(wb.room_of_poses(one_arm, poses, soft), wanted, equal_nan=True)


def test_room_of_many_poses_holds_one_block_of_them(one_arm, random_arm):
    poses = random_arm(20_000, 9)
    environment = ZOO["boxes"](5)
    wb.room_of_poses(one_arm, poses.rows(slice(100)), environment)
    tracemalloc.start()
    found = wb.room_of_poses(one_arm, poses, environment)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    whole = 20_000 * 8 * (3 * len(one_arm.sphere_names) + 12 * len(one_arm.segments))
    assert most - found.nbytes < 0.5 * whole


def check_against_oracle(body, poses, environment):
    placed, found, wanted = compared(body, poses, environment)
    assert np.allclose(found, wanted, rtol=0, atol=1e-9)
    least = least_of_all(placed, environment)
    assert np.allclose(least, wanted.min(axis=2), rtol=0, atol=1e-9)
    excess = (-wanted - allowed_depth(body, environment)).max(axis=(1, 2))
    clear = np.abs(excess - 1e-9) > 1e-9  # a tangent within rounding may go either way
    assert np.array_equal(collides(placed, environment)[clear], (excess > 1e-9)[clear])


@pytest.mark.parametrize("kind", ZOO)
def test_fast_answers_equal_the_oracle(one_arm, random_arm, kind):
    check_against_oracle(one_arm, random_arm(16, 3), ZOO[kind](3))


@pytest.mark.parametrize("kind", ZOO)
def test_fast_answers_equal_the_plain_ones_to_the_last_bit(one_arm, random_arm, kind):
    placed = wb.place(one_arm, random_arm(500, 11))
    environment = ZOO[kind](11)
    distance, sphere, polygon, point = _plain(placed, environment)
    found = nearest(placed, environment)
    assert np.array_equal(found.distance, distance)
    assert np.array_equal(found.sphere, sphere)
    assert np.array_equal(found.target, polygon)
    assert np.array_equal(found.point, point, equal_nan=True)


@pytest.mark.parametrize("kind", ZOO)
def test_one_pose_has_the_answers_of_a_batch(one_arm, random_arm, kind):
    soft = with_rules(ZOO[kind](4))
    poses = random_arm(70, 6)
    placed = wb.place(one_arm, poses)
    batch = nearest(placed, soft)
    hits = collides(placed, soft)
    for p in range(0, 70, 7):
        alone = wb.place(one_arm, poses.rows(slice(p, p + 1)))
        assert collides(alone, soft)[0] == hits[p]
        for name in ("distance", "sphere", "target", "point", "facing"):
            one, other = (getattr(found, name) for found in (nearest(alone, soft), batch))
            assert np.array_equal(one[0], other[p], equal_nan=True)


@pytest.mark.parametrize("kind", ZOO)
def test_below_a_limit_the_clearances_are_those_without_and_above_it_there_are_none(
    one_arm, random_arm, kind
):
    placed = wb.place(one_arm, random_arm(100, 12))
    environment = ZOO[kind](12)
    every = clearance_by_part(placed, environment)
    most = np.full(every.distance.shape[1:], 0.1)
    some = clearance_by_part(placed, environment, most=most)
    near = every.distance < 0.1
    assert 0 < near.sum() < near.size
    assert np.array_equal(some.distance, np.where(near, every.distance, np.inf))
    assert np.array_equal(some.sphere, np.where(near, every.sphere, -1))
    assert np.array_equal(some.polygon, np.where(near, every.polygon, -1))


@pytest.mark.nightly
@pytest.mark.parametrize("kind", ZOO)
@pytest.mark.parametrize("seed", range(32))
def test_fast_answers_equal_the_oracle_in_a_hundred_thousand_cases(one_arm, random_arm, kind, seed):
    # 64 poses of 10 spheres: 640 spheres against each of 1 or 2 parts, 160 times
    check_against_oracle(one_arm, random_arm(64, 100 + seed), ZOO[kind](seed))


def test_ten_kilometres_away_the_answers_are_those_at_home(one_arm, random_arm):
    poses = random_arm(64, 5)
    home = ZOO["pierced"](0)
    world = poses.world_from_reference.copy()
    world[:, :, 3] += [1e4, -1e4, 1e4]
    far = wb.place(one_arm, wb.Poses(poses.rotations, 0, world))
    away = moved(home, [1e4, -1e4, 1e4])
    assert np.allclose(
        wb.clearance(far, away), wb.clearance(wb.place(one_arm, poses), home), rtol=0, atol=1e-8
    )
    assert np.array_equal(wb.clearance(far, away), _plain(far, away)[0])
    assert np.array_equal(least_of_all(far, away), wb.clearance(far, away).min(axis=2))


def test_a_sphere_that_just_touches_does_not_collide_and_one_a_hair_deeper_does(one_arm, unit_box):
    height = 1.62 + np.repeat([0.0, 1e-12, -1e-12, -1e-8, 1e-8], 20)
    base = wb.pose(one_arm, {})
    world = np.repeat(base.world_from_reference, 100, axis=0)
    world[:, :, 3] = np.stack([np.full(100, 0.5), np.full(100, 0.5), height], axis=1)
    placed = wb.place(one_arm, wb.Poses(np.repeat(base.rotations, 100, axis=0), 0, world))
    assert np.array_equal(collides(placed, unit_box), height < 1.62 - 1e-9)


def test_allowances_are_respected(one_arm, random_arm):
    cab = environment_of(
        box_part("seat", [-0.3, -0.3, -0.5], [0.3, 0.3, -0.2]),
        box_part("bar", [0.3, -1, 0], [0.4, 1, 0.1]),
    )
    rules = (
        Allowance(0, ("LOWER", "UPPER"), 0.05),
        Allowance(0, ("HAND",), 0.01),
        Allowance(1, ("all",), 0.02),
    )
    placed = wb.place(one_arm, random_arm(300, 2))
    soft = replace(cab, allowances=rules)
    wanted = (-_plain(placed, soft)[0] - allowed_depth(one_arm, soft)).max(axis=(1, 2)) > 1e-9
    assert 0.05 < wanted.mean() < 0.95
    assert np.array_equal(collides(placed, soft), wanted)
    assert np.array_equal(
        np.concatenate([collides(wb.place(one_arm, random_arm(20, 2)), soft)]),
        collides(wb.place(one_arm, random_arm(20, 2)), soft),
    )
    assert collides(placed, cab).sum() > wanted.sum()


def test_hidden_parts_and_segments_outside_the_window_take_no_part(one_arm, random_arm, box_cab):
    hidden = replace(box_cab, hidden=np.array([True, False, False]))
    placed = wb.place(one_arm, random_arm(80, 4), window=["UPPER"])
    assert np.isnan(least_of_all(placed, hidden)[:, one_arm.segment("HAND")]).all()
    assert np.isinf(wb.clearance(placed, hidden)[:, 0, 0]).all()
    plain = _plain(placed, hidden)[0]
    assert np.array_equal(collides(placed, hidden), (plain < -1e-9).any(axis=(1, 2)))


def test_an_empty_environment_hits_nothing(one_arm, random_arm, box_cab):
    placed = wb.place(one_arm, random_arm(70, 4))
    nothing = replace(box_cab, hidden=np.ones(3, dtype=bool))
    assert not collides(placed, nothing).any()
    assert np.isinf(least_of_all(placed, nothing)).all()


def test_no_answer_depends_on_the_number_of_threads(one_arm, random_arm, box_cab):
    placed = wb.place(one_arm, random_arm(700, 9))
    groups = ((0, 2), (1,))
    alone = grouped_clearance(placed, box_cab, groups, threads=1)
    shared = grouped_clearance(placed, box_cab, groups, threads=4)
    for one, four in zip(alone, shared, strict=True):
        assert np.array_equal(one, four)
    assert np.array_equal(
        collides(placed, box_cab, threads=1), collides(placed, box_cab, threads=3)
    )


def test_pieces_are_each_done_once_and_a_failure_is_told():
    done = np.zeros(100, dtype=int)

    def work(begin, end):
        done[begin:end] += 1

    run_in_threads(work, 100, 7, threads=3)
    assert (done == 1).all()
    with pytest.raises(ZeroDivisionError):
        run_in_threads(lambda begin, end: 1 // 0, 10, 2, threads=2)


@pytest.mark.parametrize("kind", ZOO)
def test_the_grid_bound_is_never_more_than_the_distance(kind):
    environment = ZOO[kind](8)
    field = build_distance_field(environment, (tuple(range(len(environment.parts))),))
    faces = packed_faces(environment)
    for x in np.random.default_rng(1).uniform(-1.5, 1.5, (200, 3)):
        low, _ = square_bound(*x, field, 0)
        exact = min(point_polygon(*x, faces, f, np.inf)[0] for f in range(len(environment.normal)))
        assert low <= exact


@pytest.mark.parametrize("kind", ZOO)
def test_records_hold_the_same_polygons(kind):
    environment = ZOO[kind](6)
    field = build_distance_field(environment, (tuple(range(len(environment.parts))),))
    faces = packed_faces(environment)
    for x in np.random.default_rng(2).uniform(-1, 1, (50, 3)):
        for f in range(len(environment.normal)):
            assert (
                record_gap(*x, field.trees, faces.rank[f], np.inf)
                == point_polygon(*x, faces, f, np.inf)[0]
            )


@pytest.mark.parametrize("kind", ["boxes", "needles", "pierced"])
def test_rays_tell_inside_as_the_winding_number_does(kind):
    environment = ZOO[kind](0)
    faces = packed_faces(environment)
    shells = packed_shells(environment)
    stack = np.empty(64, dtype=np.int64)
    assert shells.closed.all()
    rng = np.random.default_rng(4)
    corners = environment.vertices[environment.triangles]
    mix = rng.dirichlet([1, 1, 1], 200)
    near = np.einsum("nk,nkc->nc", mix, corners[rng.integers(0, len(corners), 200)])
    points = np.concatenate(
        [
            rng.uniform(-0.7, 0.7, (500, 3)),
            near + rng.normal(size=(200, 3)) * 1e-5,
            environment.vertices,
        ]
    )
    for k in range(len(environment.parts)):
        span = (faces.corner_start[k], faces.corner_start[k + 1])
        for x in points:
            assert inside_part(*x, faces, shells, k, stack) == (
                abs(winding_number(*x, faces.corners, *span)) > 0.5
            )


@pytest.mark.parametrize("kind", ZOO)
def test_the_nearest_polygon_is_the_first_of_those_as_near_wherever_the_search_begins(kind):
    environment = ZOO[kind](5)
    environment = moved(environment, [1e4, 0, -1e4]) if kind == "needles" else environment
    field = build_distance_field(environment, (tuple(range(len(environment.parts))),))
    faces = packed_faces(environment)
    stack = np.empty(DEEP, dtype=np.int64)
    gaps = np.empty(DEEP + EIGHT, dtype=np.float32)
    middle = environment.bounds.mean(axis=0)
    for x in np.random.default_rng(3).uniform(-1, 1, (60, 3)) + middle:
        every = [point_polygon(*x, faces, f, np.inf)[0] for f in range(len(environment.normal))]
        first = np.argmax(np.array(every) <= tied(min(every)))
        for hint in (-1, 0, len(every) - 1):
            square, rank = nearest_in(
                *x, field.trees, field.trees.root[0], hint, np.inf, stack, gaps
            )
            number = field.trees.record[field.trees.begin[rank] + 8]
            assert (square, number) == (min(every), first)


@given(st.integers(0, 10**6))
def test_clusters_hold_their_spheres_however_the_joints_turn(one_arm, random_arm, seed):
    body = random_blend(one_arm, seed)
    placed = wb.place(body, random_arm(20, seed, spread=3.0))
    crowd = build_clusters(placed)
    assert sorted(crowd.member.tolist()) == list(range(len(body.sphere_names)))
    for n in range(len(body.segments)):
        for c in range(crowd.start[n], crowd.start[n + 1]):
            some = crowd.member[crowd.first[c] : crowd.first[c + 1]]
            hub = np.array(
                [
                    cluster_hub(placed.centres, placed.world_from_segment, p, crowd, n, c)
                    for p in range(20)
                ]
            )
            far = (
                np.linalg.norm(placed.centres[:, some] - hub[:, None], axis=-1)
                + body.radius[0, some]
            )
            assert np.all(far <= crowd.reach[c])


def test_blended_bodies_have_the_same_answers_fast_and_plain(one_arm, random_arm, box_cab):
    placed = wb.place(random_blend(one_arm, 4), random_arm(300, 8))
    distance, sphere, *_ = _plain(placed, box_cab)
    assert np.array_equal(wb.clearance(placed, box_cab), distance)
    assert np.array_equal(nearest(placed, box_cab).sphere, sphere)


@pytest.mark.parametrize("kind", ZOO)
def test_contacts_of_a_batch_are_those_of_its_poses_one_at_a_time(one_arm, random_arm, kind):
    poses = random_arm(100, 6)
    environment = ZOO[kind](6)
    whole = wb.contacts(wb.place(one_arm, poses), environment, margin=0.03)
    assert len(whole)
    for p in range(0, 100, 7):
        row = wb.place(
            one_arm, wb.Poses(poses.rotations[p : p + 1], 0, poses.world_from_reference[p : p + 1])
        )
        alone = wb.contacts(row, environment, margin=0.03)
        mine = whole.rows(whole.pose == p)
        for name in ("sphere", "part", "polygon", "distance", "point", "normal"):
            assert np.array_equal(getattr(mine, name), getattr(alone, name))


@pytest.mark.nightly
@pytest.mark.parametrize("kind", ZOO)
@pytest.mark.parametrize("far", [0.0, 1e4])
@pytest.mark.parametrize("seed", range(13))
def test_fast_answers_equal_the_plain_ones_in_half_a_million_cases(
    one_arm, random_arm, kind, far, seed
):
    # 400 poses of 10 spheres, 130 times; every other time unturned, every third on a grid of
    # decimetres: many ties
    environment = moved(ZOO[kind](seed), [far, -far, far])
    poses = random_arm(400, 1000 + seed)
    shift = [far, -far, far]
    world = poses.world_from_reference.copy()
    world[:, :, 3] = (
        np.round(world[:, :, 3] + shift, 1) if seed % 3 == 0 else world[:, :, 3] + shift
    )
    still = np.broadcast_to([1.0, 0.0, 0.0, 0.0], poses.rotations.shape)
    placed = wb.place(one_arm, wb.Poses(still if seed % 2 == 0 else poses.rotations, 0, world))
    plain = _plain(placed, environment)
    found = nearest(placed, environment)
    for one, other in zip(
        plain, (found.distance, found.sphere, found.target, found.point), strict=True
    ):
        assert np.array_equal(one, other, equal_nan=True)
    assert np.array_equal(least_of_all(placed, environment), plain[0].min(axis=2))
    deep = -plain[0] > allowed_depth(one_arm, environment) + 1e-9
    assert np.array_equal(collides(placed, environment), deep.any(axis=(1, 2)))
