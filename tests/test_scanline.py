"""Scan lines: another way to the same pictures, which shares nothing with the painter and the depth
buffer."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.test_draw import BOX, crowd, front
from tests.test_frames import cameras, swarm
from workbench import UsageError, scene_of
from workbench.draw.camera import standard_view
from workbench.draw.scanline import scan_numbers, scan_pieces, scanline
from workbench.draw.scene import Scene, Spheres
from workbench.draw.sphere_raster import (
    cast_rays,
    exact_item_buffer,
    painter_item_buffer,
    project_disks,
)


@given(st.integers(0, 2**32 - 1))
def test_scan_lines_equal_disks(seed: int) -> None:
    spheres, (camera, *_) = swarm(seed), cameras(seed)
    assert np.array_equal(
        scan_numbers(spheres, camera), painter_item_buffer(project_disks(spheres, camera), camera)
    )


@given(st.integers(0, 2**32 - 1))
def test_scan_lines_equal_exact_disks_in_perspective(seed: int) -> None:
    spheres = swarm(seed)
    for camera in (cameras(seed)[2], cameras(seed)[4]):
        drawn = exact_item_buffer(project_disks(spheres, camera), camera)
        assert np.mean(scan_numbers(spheres, camera) != drawn) < 1e-3


@given(st.integers(0, 2**32 - 1))
def test_scan_lines_by_the_surface_equal_the_depth_buffer(seed: int) -> None:
    spheres = swarm(seed)
    for camera in cameras(seed)[::2]:
        buffer = cast_rays(project_disks(spheres, camera), camera).sphere
        assert np.mean(scan_numbers(spheres, camera, rule="surface") != buffer) < 1e-3


def test_a_body_by_scan_lines_is_the_body_by_disks() -> None:
    scene = scene_of("bubbleman", posture="seated")
    camera = standard_view("corner", scene.bounds, width=120, height=160)
    drawn = painter_item_buffer(project_disks(scene.spheres, camera), camera)
    assert np.array_equal(scan_numbers(scene.spheres, camera), drawn)


def test_two_circles_divide_a_line_where_they_cross() -> None:
    two = Spheres(
        np.array([[0.0, -0.3, 0], [0.0, 0.3, 0]]), np.array([0.5, 0.5]), np.zeros(2, dtype=np.int64)
    )
    camera = front(65)  # the middle line goes through both centres
    pieces = scan_pieces(two, camera, rule="surface", rows=np.array([32]))
    assert pieces.sphere.tolist() == [0, 1]
    assert pieces.ends / 65 == pytest.approx(np.array([[0.1, 0.5], [0.5, 0.9]]))
    nearer = two._replace(centre=np.array([[0.0, -0.3, 0], [0.01, 0.3, 0]]))
    by_front = scan_pieces(nearer, camera, rows=np.array([32]))
    assert by_front.ends / 65 == pytest.approx(np.array([[0.1, 0.4], [0.4, 0.9]]))


def test_the_picture_may_leave_lines_out() -> None:
    picture = np.asarray(scanline(Scene((crowd(),)), front(60), spacing=3))
    assert (
        np.all(picture[1::3] == 255) and np.all(picture[2::3] == 255) and picture[::3].min() < 200
    )
    assert np.all(np.asarray(scanline(Scene(), front(9))) == 255)


def test_the_nearer_a_sphere_is_the_lighter_it_is_drawn() -> None:
    scene = scene_of("bubbleman", posture="seated")
    camera = standard_view("corner", scene.bounds, width=120, height=160)
    grey = np.asarray(scanline(scene, camera).convert("L"), dtype=np.float64)
    shown = scan_numbers(scene.spheres, camera, rule="surface")
    front = project_disks(scene.spheres, camera).front
    assert np.corrcoef(front[shown[shown >= 0]], grey[shown >= 0])[0, 1] > 0.99
    assert grey[shown >= 0].max() < grey[shown < 0].min()  # the nearest are told from the paper


def test_what_it_cannot_do_is_said() -> None:
    with pytest.raises(UsageError, match="cannot cut"):
        scan_pieces(swarm(1), replace(front(), cut=0.1))
    with pytest.raises(UsageError, match="did you mean 'front'"):
        scan_pieces(swarm(1), front(), rule="fronts")
    with pytest.raises(UsageError, match="1 pixel apart"):
        scanline(Scene((crowd(),)), front(), spacing=0)
    away = standard_view("front", BOX + 50.0, width=9, height=7, field=math.radians(40))
    assert np.all(scan_numbers(swarm(1), away) == -1)
