"""Coplanar triangles become polygons again: what is merged, what is kept apart, and what stays the
same."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from workbench.files.meshes.parts import triangulate, weld
from workbench.files.meshes.polygons import (
    PLANE_TOLERANCE,
    Polygons,
    degenerate_faces,
    enclosing_circles,
    merge_coplanar,
)


def plate(ring, faces):
    return merge_coplanar(np.array([[x, y, 0.0] for x, y in ring]), np.array(faces))


def area_of(vertices, merged: Polygons, polygon: int) -> float:
    """By Green's theorem over the outline: holes, wound the other way, count negative."""
    a, b = vertices[merged.edges[merged.edge_start[polygon] : merged.edge_start[polygon + 1]].T]
    return float(np.cross(a, b).sum(axis=0) @ merged.normal[polygon]) / 2


def grid(n, height=None):
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    z = np.zeros_like(x) if height is None else height(x, y)
    index = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a = index[:-1, :-1].ravel()
    b = index[:-1, 1:].ravel()
    c = index[1:, 1:].ravel()
    d = index[1:, :-1].ravel()
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()]), np.vstack(
        [np.c_[a, b, c], np.c_[a, c, d]]
    )


def test_a_box_of_12_triangles_is_6_rectangles():
    box = trimesh.creation.box(extents=(2, 4, 6))
    merged = merge_coplanar(np.array(box.vertices), np.array(box.faces))
    assert len(merged.normal) == 6
    assert np.all(np.diff(merged.edge_start) == 4)
    assert sorted(merged.offset) == pytest.approx([1, 1, 2, 2, 3, 3])


def test_the_circle_of_a_rectangle_reaches_its_corners():
    merged = plate([(0, 0), (4, 0), (4, 3), (0, 3)], [[0, 1, 2], [0, 2, 3]])
    assert merged.circle_centre[0] == pytest.approx([2, 1.5, 0])
    assert merged.circle_radius[0] == pytest.approx(2.5)


def test_an_l_shape_is_one_concave_polygon_of_6_edges():
    ring = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    merged = plate(ring, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
    assert len(merged.normal) == 1 and len(merged.edges) == 6
    assert area_of(np.array([[x, y, 0.0] for x, y in ring]), merged, 0) == pytest.approx(3)


def test_a_plate_with_a_hole_has_an_outer_loop_and_a_loop_wound_the_other_way():
    corners = [(0, 0), (3, 0), (3, 3), (0, 3), (1, 1), (2, 1), (2, 2), (1, 2)]
    ring = [[k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4] for k in range(4)]
    vertices = np.array([[x, y, 0.0] for x, y in corners])
    merged = merge_coplanar(vertices, triangulate(vertices, np.array(ring).ravel(), np.full(4, 4)))
    assert len(merged.normal) == 1
    assert {tuple(edge) for edge in merged.edges.tolist()} == {
        (0, 1), (1, 2), (2, 3), (3, 0), (5, 4), (6, 5), (7, 6), (4, 7)
    }  # fmt: skip
    assert area_of(vertices, merged, 0) == pytest.approx(8)


def test_neighbours_wound_oppositely_stay_apart():
    assert len(plate([(0, 0), (1, 0), (1, 1), (0, 1)], [[0, 1, 2], [0, 3, 2]]).normal) == 2


def test_nothing_merges_across_an_edge_of_three_faces():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1.0]])
    assert len(merge_coplanar(vertices, np.array([[0, 1, 2], [0, 2, 3], [0, 2, 4]])).normal) == 3


def test_a_face_without_area_becomes_a_polygon_of_three_edges_through_its_line():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [3.0, 0, 0]])
    merged = merge_coplanar(vertices, np.array([[0, 1, 2], [1, 1, 1]]))
    assert np.diff(merged.edge_start).tolist() == [3, 3]
    assert abs(merged.normal[0] @ [1, 0, 0]) < 1e-15
    assert np.linalg.norm(merged.normal, axis=1) == pytest.approx([1, 1])
    assert merged.circle_radius.tolist() == pytest.approx([1.5, 0])


def test_a_fold_of_less_than_the_tolerance_is_one_polygon_and_a_larger_one_is_not():
    for lift, polygons in ((0.5 * PLANE_TOLERANCE, 1), (5 * PLANE_TOLERANCE, 2)):
        vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, lift]])
        assert len(merge_coplanar(vertices, np.array([[0, 1, 2], [0, 2, 3]])).normal) == polygons


def test_a_gently_bent_sheet_is_cut_so_that_no_corner_leaves_its_plane():
    vertices, faces = grid(40, lambda x, y: 1e-4 * x * x)
    merged = merge_coplanar(vertices, faces)
    normal = np.repeat(merged.normal, np.diff(merged.triangle_start), axis=0)
    offset = np.repeat(merged.offset, np.diff(merged.triangle_start))
    heights = np.einsum("nkc,nc->nk", vertices[merged.triangles], normal) - offset[:, None]
    assert 1 < len(merged.normal) < 100
    assert np.abs(heights).max() <= PLANE_TOLERANCE * (1 + 1e-6)


def test_a_grain_smaller_than_the_tolerance_keeps_its_outline():
    grain = trimesh.creation.icosphere(subdivisions=1, radius=4e-7)
    merged = merge_coplanar(np.array(grain.vertices), np.array(grain.faces))
    assert np.all(np.diff(merged.edge_start) >= 3)


def test_every_triangle_is_in_exactly_one_polygon_with_its_winding():
    box = trimesh.creation.annulus(0.5, 1, 0.2)
    merged = merge_coplanar(np.array(box.vertices), np.array(box.faces))
    assert sorted(map(tuple, merged.triangles.tolist())) == sorted(map(tuple, box.faces.tolist()))
    assert len(merged.normal) == 2 + 2 * 32


@given(st.integers(0, 2**32 - 1))
def test_area_is_kept_whatever_the_mesh(seed):
    random = np.random.default_rng(seed)
    vertices, faces = grid(6, lambda x, y: np.round(2 * random.random(x.shape)) * 0.1)
    faces = faces[random.random(len(faces)) < 0.9]
    merged = merge_coplanar(vertices, faces)
    corner = vertices[merged.triangles]
    areas = (
        np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
        / 2
    )
    wanted = np.add.reduceat(areas, merged.triangle_start[:-1])
    assert [area_of(vertices, merged, k) for k in range(len(merged.normal))] == pytest.approx(
        wanted, abs=1e-9
    )


@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=3, max_size=12))
def test_the_circle_is_the_smallest_that_encloses(points):
    ring = np.array([[x, y, 0.0] for x, y in points])
    edges = np.column_stack([np.arange(len(ring)), np.roll(np.arange(len(ring)), -1)])
    centre, radius = enclosing_circles(
        ring, edges, np.array([0, len(ring)]), np.array([[0, 0, 1.0]])
    )
    assert np.linalg.norm(ring - centre[0], axis=1).max() <= radius[0] * (1 + 1e-12)
    assert radius[0] == pytest.approx(smallest_radius(ring), abs=1e-9)


def distance_to_polygon(vertices, merged: Polygons, polygon: int, point) -> float:
    """To the plane where the foot is inside by the even-odd rule, else to the nearest edge: slow
    and obvious."""
    normal = merged.normal[polygon]
    height = point @ normal - merged.offset[polygon]
    axis = int(np.abs(normal).argmax())
    a, b = vertices[merged.edges[merged.edge_start[polygon] : merged.edge_start[polygon + 1]].T]
    (p, q), foot = (
        (np.delete(side, axis, axis=1) for side in (a, b)),
        np.delete(point - height * normal, axis),
    )
    crosses = (p[:, 1] > foot[1]) != (q[:, 1] > foot[1])
    rise = np.where(crosses, q[:, 1] - p[:, 1], 1)
    if np.sum(crosses & (p[:, 0] + (foot[1] - p[:, 1]) * (q - p)[:, 0] / rise > foot[0])) % 2:
        return abs(height)
    along = np.clip(((point - a) * (b - a)).sum(axis=1) / ((b - a) ** 2).sum(axis=1), 0, 1)
    return float(np.linalg.norm(point - a - along[:, None] * (b - a), axis=1).min())


@given(st.integers(0, 2**32 - 1))
def test_merging_leaves_every_distance_as_it_was(seed):
    random = np.random.default_rng(seed)
    vertices, faces = grid(4, lambda x, y: np.where(x > 0.4, 0.3, 0.0))
    faces = faces[random.random(len(faces)) < 0.8]
    merged = merge_coplanar(vertices, faces)
    point = random.uniform(-0.5, 1.5, 3)
    nearest = trimesh.triangles.closest_point(vertices[faces], np.tile(point, (len(faces), 1)))
    wanted = np.linalg.norm(nearest - point, axis=1).min()
    found = min(distance_to_polygon(vertices, merged, k, point) for k in range(len(merged.normal)))
    assert len(merged.normal) < len(faces) and found == pytest.approx(wanted, abs=1e-9)


def smallest_radius(points):
    """Every circle on two or three of the points, and the smallest that holds all: slow and
    obvious."""
    best = np.inf if len(np.unique(points, axis=0)) > 1 else 0.0
    for a in points:
        for b in points:
            for c in points:
                u = b[:2] - a[:2]
                v = c[:2] - a[:2]
                twice = 2 * (u[0] * v[1] - u[1] * v[0])
                middle = (
                    (a + b)[:2] / 2
                    if twice == 0
                    else a[:2]
                    + np.array([v[1] * (u @ u) - u[1] * (v @ v), u[0] * (v @ v) - v[0] * (u @ u)])
                    / twice
                )
                reach = np.linalg.norm(points[:, :2] - middle, axis=1).max()
                if reach <= np.linalg.norm(a[:2] - middle) * (1 + 1e-9):
                    best = min(best, reach)
    return best


def test_a_circle_about_many_points_on_a_circle_is_found():
    angle = np.linspace(0, 2 * np.pi, 5000, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(5000)])
    edges = np.column_stack([np.arange(5000), np.roll(np.arange(5000), -1)])
    _, radius = enclosing_circles(ring, edges, np.array([0, 5000]), np.array([[0, 0, 1.0]]))
    assert radius[0] == pytest.approx(1, abs=1e-9)


def test_a_concave_face_is_cut_inside_its_outline():
    ring = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [2, 1, 0], [0, 4, 0.0]])
    corner = ring[triangulate(ring, np.arange(5), np.array([5]))]
    areas = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2] / 2
    assert len(areas) == 3 and np.all(areas > 0) and areas.sum() == pytest.approx(10)


def test_a_concave_quadrilateral_is_cut_along_the_diagonal_that_does_not_fold():
    ring = np.array([[0, 0, 0], [2, 1, 0], [0, 2, 0], [1, 1, 0.0]])
    corner = ring[triangulate(ring, np.arange(4), np.array([4]))]
    areas = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2] / 2
    assert areas == pytest.approx([0.5, 0.5])


def test_only_exactly_equal_positions_are_welded():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, 0, 0], [1, 0, 0], [1e-12, 1, 0]])
    places, faces = weld(vertices, np.array([[0, 1, 2], [3, 5, 4]]))
    assert len(places) == 4 and faces.tolist() == [[0, 1, 2], [0, 3, 1]]


def test_a_triangle_lower_than_a_nanometre_is_degenerate():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-10, 0], [0.5, 1e-8, 0]])
    assert degenerate_faces(vertices, np.array([[0, 1, 2], [0, 1, 3]])).tolist() == [True, False]


def test_an_empty_mesh_has_no_polygons():
    assert len(merge_coplanar(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)).normal) == 0
