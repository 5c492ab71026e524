"""Contacts and clearance: hand-checkable cases, the slow oracles, and laws."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import workbench as wb
from tests import oracles
from tests.conftest import box_part, environment_of
from workbench import body_clearance
from workbench.contact.collide import _faces, nearest, self_clearance
from workbench.files.meshes.parts import RawPart
from workbench.geometry.polygon import point_polygon, winding_number


def at(body, *position, angles=None):
    return wb.place(body, wb.pose(body, angles or {}, position=position))


def test_two_spheres_of_10_mm_at_100_mm_are_80_mm_apart(two_spheres):
    found = self_clearance(at(two_spheres, 0, 0, 0))
    assert found.distance[0, 0, 2] == pytest.approx(0.08, abs=1e-15)


def test_self_contact_of_two_spheres_is_named_on_both_sides(two_spheres):
    # the rod bent back on itself by 180 degrees brings nothing nearer: turn the end joint instead
    placed = at(two_spheres, 0, 0, 0)
    assert len(wb.self_contacts(placed)) == 0
    assert len(wb.self_contacts(placed, margin=0.0801)) == 1
    row = wb.self_contacts(placed, margin=0.0801)
    assert (row.name(0), row.other_name(0)) == ("first, ball (front)", "second (back)")
    assert row.point[0] == pytest.approx([0.09, 0, 0])


def test_a_sphere_over_the_box_has_its_gap_as_clearance(one_arm, unit_box):
    placed = at(one_arm, 0.5, 0.5, 1.75)
    distance = wb.clearance(placed, unit_box)[0, :, 0]
    assert distance[one_arm.segment("BASE")] == pytest.approx(0.7)
    assert distance[one_arm.segment("HAND")] == pytest.approx(0.75 - 0.6 - 0.02)


def test_inside_a_solid_the_distance_stays_negative_all_the_way_in(one_arm, unit_box):
    depth = [
        wb.clearance(at(one_arm, 0.5, 0.5, z), unit_box)[0, 0, 0]
        for z in (1.05, 1.0, 0.9, 0.7, 0.5)
    ]
    assert depth == pytest.approx([0.0, -0.05, -0.15, -0.35, -0.55])


def test_a_surface_has_no_inside(one_arm):
    box = environment_of(box_part("box", [0, 0, 0], [1, 1, 1]), solid=False)
    assert wb.clearance(at(one_arm, 0.5, 0.5, 0.7), box)[0, 0, 0] == pytest.approx(0.25)


def test_a_contact_is_named_with_part_polygon_point_normal_and_depth(one_arm, box_cab):
    placed = at(one_arm, 0, 0, -0.195)
    row = wb.contacts(placed, box_cab).deepest()
    assert len(row) == 1
    assert row.name(0) == "hand, fingertip (top)"
    assert row.other_name(0).startswith("floor, polygon ")
    assert row.distance[0] == pytest.approx(-0.015)
    assert row.point[0] == pytest.approx([0, 0, -0.8])
    assert row.normal[0] == pytest.approx([0, 0, 1])


def test_a_sphere_wholly_inside_a_solid_is_a_contact_of_its_nearest_polygon(one_arm, unit_box):
    rows = wb.contacts(at(one_arm, 0.5, 0.5, 0.8), unit_box)
    base = rows.rows(rows.sphere == 0)
    assert len(base) == 1
    assert base.distance[0] == pytest.approx(-0.25)
    assert base.normal[0] == pytest.approx([0, 0, 1])


def test_tangent_is_not_a_contact(one_arm, unit_box):
    assert len(wb.contacts(at(one_arm, 0.5, 0.5, 1.62), unit_box)) == 0
    assert len(wb.contacts(at(one_arm, 0.5, 0.5, 1.62 - 1e-6), unit_box)) == 1


@settings(max_examples=12)
@given(st.integers(0, 10**6))
def test_clearance_equals_the_triangle_oracle(one_arm, random_arm, box_cab, seed):
    placed = wb.place(one_arm, random_arm(2, seed))
    assert np.allclose(
        wb.clearance(placed, box_cab), oracles.clearance(placed, box_cab), rtol=0, atol=1e-9
    )


@given(st.integers(0, 10**6))
def test_clearance_equals_the_oracle_among_random_triangles(one_arm, random_arm, seed):
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(6, 3, 3)) * 0.4
    corners[0] = corners[0, 0]  # a point
    corners[1, 2] = 0.5 * (corners[1, 0] + corners[1, 1])  # a needle without area
    soup = environment_of(RawPart("soup", corners.reshape(-1, 3), np.arange(18).reshape(-1, 3)))
    placed = wb.place(one_arm, random_arm(2, seed))
    assert np.allclose(
        wb.clearance(placed, soup), oracles.clearance(placed, soup), rtol=0, atol=1e-9
    )


@settings(max_examples=12)
@given(st.integers(0, 10**6), st.floats(0, 0.1))
def test_contacts_are_all_pairs_the_oracle_finds(one_arm, random_arm, box_cab, seed, margin):
    placed = wb.place(one_arm, random_arm(1, seed))
    rows = wb.contacts(placed, box_cab, margin=margin)
    corners = box_cab.vertices[box_cab.triangles]
    wanted = {}
    for s, f in np.ndindex(len(one_arm.sphere_names), len(box_cab.normal)):
        part = corners[box_cab.triangle_start[f] : box_cab.triangle_start[f + 1]]
        gap = (
            min(oracles.point_triangle(placed.centres[0, s], t) for t in part)
            - one_arm.radius[0, s]
        )
        if gap < margin - 1e-9:
            wanted[s, f] = gap
    outside = rows.rows(rows.distance >= -one_arm.radius[0, rows.sphere])
    found = dict(
        zip(
            zip(outside.sphere.tolist(), outside.polygon.tolist(), strict=True),
            outside.distance,
            strict=True,
        )
    )
    inside = {
        (s, f) for s, f in zip(rows.sphere.tolist(), rows.polygon.tolist(), strict=True)
    } - set(found)
    assert set(found) | inside >= set(wanted)
    assert all(found[key] == pytest.approx(wanted[key], abs=1e-9) for key in found)


@given(st.integers(0, 10**6))
def test_the_deepest_contact_is_the_clearance(one_arm, random_arm, box_cab, seed):
    placed = wb.place(one_arm, random_arm(3, seed))
    distance = wb.clearance(placed, box_cab)
    rows = wb.contacts(placed, box_cab)
    deep = rows.deepest()
    for row in range(len(deep)):
        assert deep.distance[row] == pytest.approx(
            distance[deep.pose[row], deep.segment[row], deep.part[row]], abs=1e-12
        )
    touched = {(p, s, k) for p, s, k in zip(rows.pose, rows.segment, rows.part, strict=True)}
    assert touched == {tuple(key) for key in np.argwhere(distance < -1e-9)}


@given(st.integers(0, 10**6))
def test_self_contacts_equal_all_pairs(one_arm, random_arm, seed):
    placed = wb.place(one_arm, random_arm(3, seed, spread=5))
    rows = wb.self_contacts(placed)
    found = {
        (p, i, j): d
        for p, i, j, d in zip(rows.pose, rows.sphere, rows.other_sphere, rows.distance, strict=True)
    }
    wanted = oracles.sphere_pairs(placed)
    assert set(found) == set(wanted)
    assert all(found[key] == pytest.approx(wanted[key], abs=1e-12) for key in found)


@given(st.integers(0, 10**6))
def test_contact_of_two_bodies_is_symmetric(one_arm, two_spheres, random_arm, seed):
    one = wb.place(one_arm, random_arm(2, seed))
    other = wb.place(two_spheres, wb.join_poses([wb.pose(two_spheres, {})] * 2))
    rows = wb.body_contacts(one, other, margin=0.2)
    mirrored = wb.body_contacts(other, one, margin=0.2)
    pairs = {
        (p, i, j): d
        for p, i, j, d in zip(rows.pose, rows.sphere, rows.other_sphere, rows.distance, strict=True)
    }
    back = {
        (p, j, i): d
        for p, i, j, d in zip(
            mirrored.pose, mirrored.sphere, mirrored.other_sphere, mirrored.distance, strict=True
        )
    }
    assert pairs == back
    near = body_clearance(one, other).distance
    far = body_clearance(other, one).distance
    assert np.array_equal(near, far.transpose(0, 2, 1))


def test_scaling_everything_scales_every_distance(one_arm, random_arm):
    cab = environment_of(box_part("box", [0.1, -0.5, -0.5], [0.3, 0.5, 0.1]))
    placed = wb.place(one_arm, random_arm(5, 3))
    far = environment_of(box_part("box", [1e4 + 0.1, -0.5, -0.5], [1e4 + 0.3, 0.5, 0.1]))
    poses = random_arm(5, 3)
    world = poses.world_from_reference.copy()
    world[:, 0, 3] += 1e4
    moved = wb.place(one_arm, wb.Poses(poses.rotations, 0, world))
    assert np.allclose(wb.clearance(placed, cab), wb.clearance(moved, far), rtol=0, atol=1e-8)


def test_the_flesh_allowance_is_carried_and_taken_off(one_arm):
    folded = at(one_arm, 0, 0, 0, angles={"ELBOW": {"flexion": 165}})
    rows = wb.self_contacts(folded)
    assert len(rows)
    assert rows.excess == pytest.approx(-rows.distance - rows.allowed)


def test_hidden_parts_are_left_out(one_arm, box_cab):
    from dataclasses import replace

    hidden = replace(box_cab, hidden=np.array([True, False, False]))
    placed = at(one_arm, 0, 0, -0.25)
    assert np.isinf(wb.clearance(placed, hidden)[..., 0]).all()
    assert "floor" not in {hidden.parts[k] for k in wb.contacts(placed, hidden).part}


@given(
    st.tuples(st.floats(-2, 2), st.floats(-2, 2)),
    st.floats(0.01, 1.5),
    st.floats(-0.5, 0.5),
    st.sampled_from(["convex", "concave", "holed"]),
)
def test_the_papers_circle_polygon_test_equals_the_distance(foot, radius, height, shape):
    loops = SHAPES[shape]
    faces = _faces(environment_of(plate(loops)))
    square, *_ = point_polygon(*foot, height, faces, 0, np.inf)
    cut = np.sqrt(max(radius**2 - height**2, 0.0))
    touches = abs(height) < radius and oracles.circle_touches_polygon(np.array(foot), cut, loops)
    if abs(np.sqrt(square) - radius) > 1e-9:
        assert touches == (np.sqrt(square) < radius)


SQUARE = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
SHAPES = {
    "convex": [SQUARE],
    "concave": [np.array([[-1.0, -1], [1, -1], [1, 1], [0, 1], [0, 0], [-1, 0]])],
    "holed": [SQUARE, 0.5 * SQUARE[::-1]],
}


def plate(loops):
    """A flat part in the plane z = 0, triangulated on a half-metre grid inside the loops."""
    corners = []
    faces = []
    for x, y in np.ndindex(4, 4):
        low = np.array([-1 + 0.5 * x, -1 + 0.5 * y])
        if oracles.circle_touches_polygon(low + 0.25, 0.0, loops):
            first = len(corners)
            corners += [[*(low + step), 0.0] for step in ([0, 0], [0.5, 0], [0.5, 0.5], [0, 0.5])]
            faces += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    points, back = np.unique(np.array(corners), axis=0, return_inverse=True)
    return RawPart("plate", points, back.reshape(-1)[np.array(faces)])


def test_a_plate_is_one_polygon_again():
    for shape, edges in (("convex", 16), ("holed", 16 + 8)):
        made = environment_of(plate(SHAPES[shape]))
        assert len(made.normal) == 1
        assert len(made.edges) in (edges, edges // 2, {"convex": 4, "holed": 8}[shape])


def test_a_point_in_the_hole_is_as_far_as_its_rim():
    faces = _faces(environment_of(plate(SHAPES["holed"])))
    square, *point = point_polygon(0.1, 0.0, 0.0, faces, 0, np.inf)
    assert np.sqrt(square) == pytest.approx(0.4)
    assert point == pytest.approx([0.5, 0, 0])


@given(st.tuples(*[st.floats(-0.5, 1.5)] * 3))
def test_winding_number_is_one_inside_the_box_and_zero_outside(point):
    corners = environment_of(box_part("box", [0, 0, 0], [1, 1, 1]))
    triangles = corners.vertices[corners.triangles]
    from_faces = min(abs(c) for c in point) > 1e-6 and min(abs(1 - c) for c in point) > 1e-6
    if from_faces:
        inside = all(0 < c < 1 for c in point)
        assert winding_number(*point, triangles, 0, len(triangles)) == pytest.approx(
            float(inside), abs=1e-9
        )


def test_the_window_takes_part_in_contacts_alone(bubbleman):
    poses = wb.pose(bubbleman, {})
    floor = environment_of(box_part("floor", [-1, -1, -0.1], [1, 1, 0.05]))
    placed = wb.place(bubbleman, poses, window=["LF"])
    rows = wb.contacts(placed, floor)
    assert {bubbleman.segments[n] for n in rows.segment} == {
        "LF",
        "LLL",
    }  # the path to the stage comes along
    distance = wb.clearance(placed, floor)
    assert np.isnan(distance[0, bubbleman.segment("RF")]).all()


def test_standing_and_seated_bodies_do_not_touch_themselves(library):
    placed, names = library
    rows = wb.self_contacts(placed)
    faults = rows.rows(rows.excess > 1e-9).deepest()
    told = [
        f"{names[faults.pose[i]]}: {faults.name(i)} {faults.other_name(i)} {faults.excess[i]}"
        for i in range(len(faults))
    ]
    assert told == []


def test_a_joint_sphere_stays_at_its_joint_in_every_posture(bubbleman, library):
    placed, _ = library
    for j in range(len(bubbleman.joints)):
        frame = placed.world_from_segment[:, j + 1]
        joint = frame[:, :, :3] @ bubbleman.joint_in_child[0, j] + frame[:, :, 3]
        gaps = []
        for n in (j + 1, int(bubbleman.parent[j + 1])):
            gaps.append(
                np.linalg.norm(placed.centres[:, bubbleman.spheres(n)] - joint[:, None], axis=-1)
            )
        assert np.all(np.concatenate(gaps, axis=1).min(axis=1) < 2e-6), bubbleman.joints[j]


def test_nearest_witnesses_lie_where_they_say(one_arm, random_arm, box_cab):
    placed = wb.place(one_arm, random_arm(10, 5))
    found = nearest(placed, box_cab)
    for where in np.argwhere(np.isfinite(found.distance)):
        p, n, k = (int(i) for i in where)
        centre = placed.centres[p, found.sphere[p, n, k]]
        gap = np.linalg.norm(found.point[p, n, k] - centre)
        assert abs(found.distance[p, n, k]) == pytest.approx(
            abs(gap - one_arm.radius[0][found.sphere[p, n, k]]), abs=1e-9
        ) or found.distance[p, n, k] == pytest.approx(
            -gap - one_arm.radius[0][found.sphere[p, n, k]], abs=1e-9
        )


@given(
    st.lists(st.floats(-3, 3), min_size=3, max_size=3),
    st.lists(st.floats(-10, 10), min_size=3, max_size=3),
    st.floats(1e-4, 1.0),
)
def test_of_two_polygons_as_near_the_first_is_named_wherever_the_box_stands(
    two_spheres, turn, where, away
):
    # over the middle of each edge a centre is as near to both faces that meet there
    box = box_part("box", [0, 0, 0], [1, 1, 1])
    corners = np.asarray(box.vertices) - 0.5
    middles = np.array([[a, b, 0] for a in (0.5, -0.5) for b in (0.5, -0.5)])
    edges = np.concatenate([np.roll(middles, k, axis=1) for k in range(3)])
    turned = Rotation.from_rotvec(turn).as_matrix()
    named = []
    for rotation, shift in ((np.eye(3), np.zeros(3)), (turned, np.array(where))):
        there = environment_of(RawPart("box", corners @ rotation.T + shift, box.faces))
        centres = (edges * (1 + away)) @ rotation.T + shift
        found = [nearest(at(two_spheres, *centre), there) for centre in centres]
        named.append([int(one.target[0, 0, 0]) for one in found])
    assert named[0] == named[1]
    assert len(set(named[0])) > 2
