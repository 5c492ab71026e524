"""Cameras: one noun for parallel and perspective views; what is behind the eye or cut away is never
drawn."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.test_draw import BOX, boxes, crowd, eye_of, front, painted_slowly, spheres_body
from workbench import UsageError, scene_of
from workbench.draw.camera import (
    VIEWS,
    fit_to_spheres,
    look_at,
    metric_depth,
    orbit,
    project,
    projective_depth,
    standard_view,
)
from workbench.draw.disks import disks
from workbench.draw.eye_view import eye_point, eye_view
from workbench.draw.lines.arcs import arc_lengths, outline_arcs
from workbench.draw.lines.circles import circles
from workbench.draw.lines.edges import drawn_edges
from workbench.draw.lines.outline import outline
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.section_planes import cut_away
from workbench.draw.views import fitted_view
from workbench.draw.visibility import projected_disks, render_buffers
from workbench.geometry.clipping import clip_segments, clip_triangles, plane_intersections

RIGHT_ANGLE = math.pi / 2  # of view: a picture is as high as twice the distance
UP = np.array([0.0, 0.0, 1.0])


def test_a_point_half_as_far_is_drawn_twice_as_far_from_the_middle() -> None:
    camera = look_at((4, 0, 0), (0, 0, 0), field=RIGHT_ANGLE, width=100, height=100)
    near, far = project(camera, [[2, 1, 1], [0, 1, 1]])
    assert near == pytest.approx([75, 25, 2])
    assert far == pytest.approx([62.5, 37.5, 0])


def test_the_eye_is_where_it_was_put() -> None:
    assert eye_of(look_at((4, 1, 2), (0, 0, 0))) == pytest.approx([4, 1, 2])


def test_a_parallel_view_is_the_limit_of_perspective() -> None:
    points = np.random.default_rng(1).uniform(-1, 1, (50, 3))
    near = front(640)
    far = standard_view("front", BOX, width=640, height=640, field=1e-7, margin=0.0)
    assert math.isinf(near.distance) and far.distance > 1e6
    assert project(replace(far, scale=near.scale), points) == pytest.approx(
        project(near, points), abs=1e-3
    )
    scene = Scene((crowd(),))
    wide = replace(near, distance=1e12)
    assert np.array_equal(render_buffers(scene, wide).sphere, render_buffers(scene, near).sphere)
    arcs = outline_arcs(scene, near)
    like = outline_arcs(scene, replace(near, distance=1e5))
    assert np.bincount(like.sphere, arc_lengths(like), 60) == pytest.approx(
        np.bincount(arcs.sphere, arc_lengths(arcs), 60), abs=0.5
    )
    assert np.sum(arc_lengths(like)) == pytest.approx(np.sum(arc_lengths(arcs)), rel=1e-4)


@pytest.mark.parametrize("field", [0.0, 0.3, 1.2])
@pytest.mark.parametrize("view", VIEWS)
def test_a_fitted_view_holds_every_sphere_and_touches_the_margin(view: str, field: float) -> None:
    shown = crowd(3, 30)
    camera = fitted_view(
        Scene((shown,)), standard_view(view, BOX, width=300, height=200, field=field), margin=0.1
    )
    surface = np.random.default_rng(2).normal(size=(4000, 1, 3))
    points = (
        shown.placed.centres[0]
        + surface
        / np.linalg.norm(surface, axis=-1, keepdims=True)
        * shown.placed.body.radius[0, :, None]
    )
    pixels = project(camera, points)[..., :2].reshape(-1, 2) / (300, 200)
    room = np.min([pixels.min(axis=0), 1.0 - pixels.max(axis=0)])
    assert 0.1 - 1e-9 <= room < 0.102  # the samples come near the very edge


def test_projective_depth_is_linear_along_a_line_and_turns_back_into_metres() -> None:
    camera = look_at((4, 0, 0), (0, 0, 0), field=1.0)
    ends = np.array([[2.0, -1.0, 0.3], [-5.0, 1.0, 0.5]])
    points = project(camera, ends[0] + np.linspace(0, 1, 9)[:, None] * (ends[1] - ends[0]))
    share = (points[:, 0] - points[0, 0]) / (points[-1, 0] - points[0, 0])
    depth = projective_depth(camera, points[:, 2])
    assert depth == pytest.approx(depth[0] + share * (depth[-1] - depth[0]))
    assert metric_depth(camera, depth) == pytest.approx(points[:, 2])
    assert metric_depth(camera, np.array([-np.inf])) == -np.inf


def test_a_whole_turn_gives_the_first_picture_byte_for_byte() -> None:
    scene = Scene((crowd(),), boxes([[-1, -1, -1], [1, 1, -0.9]]))
    camera = front(48)
    first = disks(scene, camera).tobytes()
    assert disks(scene, orbit(camera, math.tau)).tobytes() == first
    bare = replace(
        scene, environment=None
    )  # the box has corners on the borders of pixels, where rounding shows
    first = disks(bare, camera).tobytes()
    for _ in range(8):
        camera = orbit(camera, math.tau / 8)
    assert disks(bare, camera).tobytes() == first


def test_a_quarter_turn_to_the_left_shows_the_left_side() -> None:
    camera = orbit(front(), math.pi / 2)
    assert np.allclose([camera.toward, camera.up], [[0, 1, 0], UP])


def test_a_sphere_that_holds_the_eye_is_not_drawn() -> None:
    scene = Scene((spheres_body([[2.0, 0, 0], [-3, 0, 0]], [0.5, 0.4]),))
    camera = look_at((2.1, 0.1, 0), (0, 0, 0), width=40, height=40)
    assert set(np.unique(render_buffers(scene, camera).sphere)) == {-1, 1}


def test_the_near_plane_shows_the_face_it_cuts() -> None:
    ball = Scene((spheres_body([0, 0, 0], 0.5),))
    whole = replace(front(200), cut=0.3)  # the front is gone, the widest circle is not
    layers = render_buffers(ball, whole)
    assert projected_disks(ball, whole).disk[0, 2] == pytest.approx(50)
    assert layers.body_depth.max() == 0.3 and np.sum(layers.body_depth == 0.3) == pytest.approx(
        np.pi * 40**2, rel=0.01
    )
    behind = projected_disks(
        ball, replace(whole, cut=-0.3)
    )  # only a cap is left, as wide as the cut: 3-4-5
    assert behind.disk[0, 2] == pytest.approx(40) and behind.front[0] == -0.3
    assert not len(projected_disks(ball, replace(whole, cut=-0.5)).order)


@given(st.integers(0, 2**32 - 1))
def test_disks_in_perspective_equal_a_plain_painter(seed: int) -> None:
    random = np.random.default_rng(seed)
    scene = Scene((crowd(seed % 7, 40),))
    eye = random.normal(size=3)
    camera = look_at(
        eye * random.uniform(0.2, 4.0),
        (0, 0, 0),
        width=41,
        height=29,
        cut=random.choice([np.inf, 0.2]),
    )
    drawn = projected_disks(scene, camera)
    slow = painted_slowly(scene, camera)
    assert np.array_equal(render_buffers(scene, camera).sphere, slow)
    assert not np.isin(slow, np.setdiff1d(np.arange(40), drawn.order)).any()


def test_polygons_behind_the_eye_are_not_drawn_and_those_it_stands_in_are_cut() -> None:
    room = boxes([[-3, -2, -1], [3, 2, 1]])  # the eye is inside it
    camera = look_at((1, 0, 0), (-1, 0, 0), field=RIGHT_ANGLE, width=64, height=48)
    layers = render_buffers(Scene((), room), camera)
    assert np.all(layers.triangle >= 0) and np.isfinite(layers.depth).all()
    assert layers.depth[24, 32] == pytest.approx(-2.0, abs=1e-3)  # the far wall
    floor = layers.depth[44, 32]
    assert 1.0 / (2.0 - floor) == pytest.approx(20.5 / 24, abs=1e-3)  # one metre below the eye
    for display in (outline, circles):
        assert "nan" not in display(Scene((), room), camera)
    assert np.asarray(disks(Scene((crowd(),), room), camera)).shape == (48, 64, 3)


def test_the_eye_of_a_body_looks_ahead_and_sees_its_hands_not_its_nose() -> None:
    scene = scene_of("trainer_clearance")
    camera = eye_view(scene.bodies[0], width=64, height=64)
    point, axes = eye_point(scene.bodies[0])
    assert eye_of(camera) == pytest.approx(point) and -camera.toward @ axes[0] > 0.98
    layers = render_buffers(scene, camera)
    body = scene.bodies[0].placed.body
    segment = np.array(body.segments)[body.sphere_segment]
    assert (
        "H"
        not in segment[
            np.unique(layers.sphere[(layers.sphere >= 0) & (layers.sphere < len(segment))])
        ]
    )
    assert np.any(layers.triangle >= 0)


def test_a_body_without_eyes_says_so() -> None:
    with pytest.raises(UsageError, match="no sphere is named an eye"):
        eye_view(SceneBody(crowd().placed))


@given(st.integers(0, 2**32 - 1))
def test_clipped_triangles_keep_their_area_on_both_sides(seed: int) -> None:
    random = np.random.default_rng(seed)
    corners = random.normal(size=(20, 3, 3))
    normal = random.normal(size=3)
    below, of = clip_triangles(corners, normal, 0.2)
    above, also = clip_triangles(corners, -normal, -0.2)
    pieces = np.bincount(of, _areas(below), 20) + np.bincount(also, _areas(above), 20)
    assert pieces == pytest.approx(_areas(corners)) and np.all(below @ normal <= 0.2 + 1e-9)
    lines, crossed = plane_intersections(corners, normal, 0.2)
    assert np.allclose(lines @ normal, 0.2) and set(crossed) == set(of) & set(also)


def _areas(corners: np.ndarray) -> np.ndarray:
    return (
        np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        / 2.0
    )


def test_a_segment_through_the_plane_ends_on_it() -> None:
    ends = np.array(
        [[[0, 0, -1.0], [0, 0, 3.0]], [[0, 0, 1.0], [0, 0, 2.0]], [[1, 0, -2.0], [1, 0, -1.0]]]
    )
    pieces, of = clip_segments(ends, UP, 0.0)
    assert of.tolist() == [0, 2] and pieces[0].tolist() == [[0, 0, -1], [0, 0, 0]]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: look_at((1, 0, 0), (1, 0, 0)), "two finite points"),
        (lambda: look_at((1, 0, np.nan), (1, 0, 0)), "two finite points"),
        (lambda: look_at((1, 0, 0), (0, 0, 0), field=4.0), "177 degrees"),
        (lambda: look_at((1, 0, 0), (0, 0, 0), width=0), "at least 1 x 1"),
        (lambda: replace(front(), distance=-1.0), "must be positive"),
        (lambda: fit_to_spheres(front(), np.empty((0, 3)), np.empty(0)), "finite spheres"),
        (lambda: fitted_view(Scene(), front()), "nothing to show"),
    ],
)
def test_what_is_no_camera_is_refused_in_words(wrong: object, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        wrong()  # type: ignore[operator]


def test_a_shell_cut_in_half_is_open_and_a_solid_closed_by_its_cut_face() -> None:
    box = boxes([[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]])
    shell = replace(box, solid=np.zeros(1, dtype=np.bool_))
    half = cut_away(box, (0, 0, 0), (2, 0, 0))
    area = _areas(half.vertices[half.triangles])
    assert area.sum() == pytest.approx(1.0 + 4 * 0.5 + 1.0)
    half = cut_away(shell, (0, 0, 0), (2, 0, 0))
    area = _areas(half.vertices[half.triangles])
    assert area.sum() == pytest.approx(1.0 + 4 * 0.5) and half.bounds[:, 0] == pytest.approx(
        [-0.5, 0.0]
    )
    whole, opened = (render_buffers(Scene((), shown), front()).depth for shown in (box, half))
    assert whole[32, 32] == pytest.approx(0.5, abs=1e-3) and opened[32, 32] == pytest.approx(
        -0.5, abs=1e-3
    )
    edges, _ = drawn_edges(half, front(), np.inf)
    rim = edges[np.all(np.abs(edges[:, :, 2]) < 1e-9, axis=1)]
    assert np.linalg.norm(rim[:, 1, :2] - rim[:, 0, :2], axis=1).sum() == pytest.approx(4 * 32.0)
    for display in (outline, circles):
        assert "nan" not in display(Scene((crowd(),), half), front())


@pytest.mark.parametrize(
    ("point", "normal", "message"),
    [
        ((0, 0, 0), (0, 0, 0), "a point and a direction"),
        ((0, np.nan, 0), (1, 0, 0), "a point and a direction"),
        ((-9, 0, 0), (1, 0, 0), "nothing of boxes is left"),
    ],
)
def test_a_plane_that_is_none_or_leaves_nothing_is_refused(
    point: tuple[float, ...], normal: tuple[float, ...], message: str
) -> None:
    with pytest.raises(UsageError, match=message):
        cut_away(boxes([[-1, -1, -1], [1, 1, 1]]), point, normal)
