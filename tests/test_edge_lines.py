"""Edges in raster pictures: pieces and pixels against plain loops, and numbers to be done by
hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.test_draw import boxes, front
from workbench.draw.camera import look_at, to_view, view_to_pixels
from workbench.draw.lines.edges import SurfaceLayers, drawn_edges, edge_pieces, paint_lines


def painted(ends, width=1.0, size=(8, 12)):
    mask = np.zeros(size, dtype=np.uint8)
    rows = np.array(ends, dtype=np.float64).reshape(-1, 4)
    paint_lines(rows, np.arange(1, len(rows) + 1, dtype=np.uint8), width, mask)
    return mask


def test_a_level_line_takes_one_pixel_in_every_column_and_later_lines_lie_over():
    mask = painted([[2.2, 3.5, 9.7, 3.5], [5.5, 0.5, 5.5, 7.5]])
    assert np.flatnonzero(mask[3]).tolist() == list(range(2, 10)) and mask[3, 5] == 2
    assert (
        np.flatnonzero(mask[:, 5]).tolist() == list(range(8))
        and mask.astype(bool).sum() == 8 + 8 - 1
    )


@given(st.lists(st.floats(-30, 30), min_size=4, max_size=4), st.floats(1.5, 5))
def test_a_wide_line_is_the_pixels_less_than_half_its_width_off(ends, width):
    x0, y0, x1, y1 = ends
    length = math.hypot(x1 - x0, y1 - y0)
    mask = painted(ends, width, (16, 16)) > 0
    middle = np.stack(np.meshgrid(np.arange(16) + 0.5, np.arange(16) + 0.5), axis=-1) - [x0, y0]
    if length < 2 * width:
        return
    along = (middle @ [x1 - x0, y1 - y0]) / length
    off = np.abs(middle @ [-(y1 - y0), x1 - x0]) / length
    inside = (along > width) & (
        along < length - width
    )  # away from the ends, which are cut across the axes
    assert np.array_equal(
        mask[inside & (np.abs(off - width / 2) > 1e-6)],
        (off < width / 2)[inside & (np.abs(off - width / 2) > 1e-6)],
    )
    assert not mask[(off > width / 2 + 1.0) | (along < -width) | (along > length + width)].any()


def slow_pieces(edge, clear, layers, limits, bend):
    """The pieces of one edge by plain Python."""
    surface, sphere, body = layers
    height, width = surface.shape
    count = math.ceil(math.dist(edge[0, :2], edge[1, :2]) / 2.0) + 2
    states = []
    points = []
    for k in range(count):
        x, y, z = edge[0] + (edge[1] - edge[0]) * (k / (count - 1))
        z = z / (1 + z * bend)
        state = 0
        row = math.floor(y)
        column = math.floor(x)
        if 0 <= column < width and 0 <= row < height and z <= limits[1] + limits[0]:
            around = surface[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
            behind = sphere[row, column] >= 0 and z < body[row, column]
            if z >= around.min() - limits[0] and not behind:
                state = 1 if sphere[row, column] >= 0 or clear else 2
        states.append(state)
        points.append((x, y, z))
    found = []
    first = 0
    for k in range(1, count + 1):
        if k == count or states[k] != states[first]:
            if states[first] and k - 1 > first:
                a = points[first]
                b = points[k - 1]
                found.append([*a[:2], *b[:2], (a[2] + b[2]) / 2, float(states[first] == 1)])
            first = k
    return found


@pytest.mark.parametrize("bend", [0.0, 0.3])
@given(seed=st.integers(0, 2**32 - 1))
def test_pieces_of_edges_are_those_of_a_plain_loop(bend, seed):
    random = np.random.default_rng(seed)
    edges = random.uniform([-4, -4, -1], [24, 20, 1], (9, 2, 3))
    surface = np.where(
        random.uniform(size=(16, 20)) < 0.4,
        -np.inf,
        np.repeat(random.uniform(-1, 1, (16, 4)), 5, axis=1),
    )
    sphere = np.where(random.uniform(size=(16, 20)) < 0.3, 4, -1).astype(np.int32)
    layers = (surface, sphere, random.uniform(-1, 1, (16, 20)))
    limits = np.array([1e-3, 0.7])
    clear = random.uniform(size=9) < 0.5
    want = [
        row
        for edge, glass in zip(edges, clear, strict=True)
        for row in slow_pieces(edge, glass, layers, limits, bend)
    ]
    kernel_layers = SurfaceLayers(*layers, *limits.tolist())
    assert edge_pieces(edges, clear, kernel_layers, 2.0, bend) == pytest.approx(
        np.array(want).reshape(-1, 6), abs=1e-9
    )


def test_a_face_cut_into_triangles_has_the_edges_of_the_whole_face():
    box = boxes([[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]])
    edges, _ = drawn_edges(box, front(), np.inf)
    corners = box.vertices[box.triangles]
    face = np.repeat(np.arange(6), 2)
    cut = replace(
        box,
        vertices=corners.reshape(-1, 3),
        triangles=np.arange(36).reshape(-1, 3),
        triangle_start=np.arange(13),
        edges=np.stack([np.arange(36), np.arange(36).reshape(-1, 3)[:, [1, 2, 0]].ravel()], axis=1),
        edge_start=3 * np.arange(13),
        normal=box.normal[face],
        offset=box.offset[face],
        circle_centre=box.circle_centre[face],
        circle_radius=box.circle_radius[face],
        part_start=np.array([0, 12]),
    )
    again, _ = drawn_edges(cut, front(), np.inf)
    assert len(edges) == len(again) == 12


@given(st.integers(0, 2**32 - 1))
def test_view_coordinates_are_products_with_the_camera_s_axes(seed):
    random = np.random.default_rng(seed)
    points = random.uniform(-1, 1, (2, 5, 3))
    camera = look_at([3, 2, 1], random.uniform(-0.2, 0.2, 3), width=200, height=100, field=0.8)
    seen = to_view(camera, points)
    assert seen == pytest.approx(
        (points - camera.centre) @ np.array([camera.right, camera.up, camera.toward]).T
    )
    shown = view_to_pixels(camera, seen)
    size = camera.scale / (1 - seen[..., 2] / camera.distance)
    assert shown[..., 0] == pytest.approx(100 + size * seen[..., 0]) and np.array_equal(
        shown[..., 2], seen[..., 2]
    )
    assert np.isnan(view_to_pixels(camera, np.array([0.1, 0.2, camera.distance]))[:2]).all()
