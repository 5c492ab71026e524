"""The line drawing in perspective: rims are ellipses, what is drawn is what the eye sees, near
spheres are cut."""

from __future__ import annotations

import math
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.test_draw import BOX, boxes, crowd, eye_of, front, spheres_body
from tests.test_outline import bodies, covered
from workbench import scene_of
from workbench.draw.camera import Camera, look_at, project, standard_view, to_view
from workbench.draw.eye_view import eye_view
from workbench.draw.lines.arcs import arc_points, outline_arcs
from workbench.draw.lines.outline import outline
from workbench.draw.lines.silhouettes import perspective_rims, silhouette_arcs
from workbench.draw.scene import Scene
from workbench.model.arrays import Bools, Floats, Ints


def swarm(seed: int, count: int) -> Floats:
    """Spheres x, y, along, radius round an eye at the origin, none of which holds it; some are
    behind it."""
    random = np.random.default_rng(seed)
    balls = np.column_stack(
        [
            random.uniform(-3, 3, (count, 2)),
            random.uniform(-1, 6, count),
            random.uniform(0.1, 2.0, count),
        ]
    )
    far = np.linalg.norm(balls[:, :3], axis=1)
    balls[:, 3] = np.minimum(balls[:, 3], 0.9 * far)
    return balls


def seen_slowly(balls: Floats, sphere: Ints, ray: Floats, reach: Floats) -> tuple[Bools, Floats]:
    """Points reach x ray (M, 3), tangent to their sphere, with no sphere between them and the eye;
    and by how much."""
    along = ray @ balls[:, :3].T
    off = np.sum(balls[:, :3] ** 2, axis=1) - along**2
    half = balls[:, 3] ** 2 - off
    half[np.arange(len(sphere)), sphere] = -1.0
    enters = along - np.sqrt(np.maximum(half, 0.0))
    before = np.where((half > 0.0) & (along > 0.0), reach[:, None] - enters, -np.inf).max(axis=1)
    return before <= 0.0, np.minimum(np.abs(before), np.abs(half).min(axis=1))


def rays_of(rims: Floats, sphere: Ints, angle: Floats) -> Floats:
    """Unit vectors (M, 3) to points of rims."""
    ball = rims[sphere]
    across = np.cos(angle)[:, None] * ball[:, 9:12] + np.sin(angle)[:, None] * ball[:, 12:]
    rays: Floats = (ball[:, 5:6] * ball[:, 6:9] + ball[:, 3:4] * across) / ball[:, 4:5]
    return rays


@given(st.integers(0, 2**32 - 1), st.integers(1, 25))
def test_what_is_drawn_is_what_the_eye_sees_and_nothing_else(seed: int, count: int) -> None:
    balls = swarm(seed, count)
    none = np.zeros(count, dtype=np.int64)
    rims = perspective_rims(balls, none, none, np.ones((1, 1), dtype=np.bool_), np.zeros(count))
    random = np.random.default_rng(seed + 1)
    sphere = random.integers(0, count, 2000)
    angle = random.uniform(0.0, math.tau, 2000)
    ray = rays_of(rims.balls, sphere, angle)
    seen, margin = seen_slowly(balls, sphere, ray, rims.balls[sphere, 5])
    clear = margin > 1e-7
    assert np.array_equal(covered(*silhouette_arcs(rims), sphere, angle)[clear], seen[clear])


def rays_through(camera: Camera, points: Floats) -> Floats:
    """(M, 3) directions from the eye through pixels (M, 2), one metre along the view."""
    focal = camera.scale * camera.distance
    x, y = ((points - [camera.width / 2, camera.height / 2]) / focal).T
    rays: Floats = x[:, None] * camera.right - y[:, None] * camera.up - camera.toward
    return rays


@given(st.integers(0, 2**32 - 1))
def test_every_arc_is_where_rays_graze_its_sphere_and_nothing_is_before_it(seed: int) -> None:
    scene = Scene((crowd(seed % 11, 30), crowd(seed % 13 + 20, 10)))
    eye = np.random.default_rng(seed).normal(size=3)
    camera = look_at(eye * 2.5 / np.linalg.norm(eye), (0.1, 0, 0), field=0.9, width=400, height=300)
    arcs = outline_arcs(scene, camera, step=0.0, share=0.0)
    spheres = scene.spheres
    which = np.repeat(np.arange(len(arcs.sphere)), 5)
    share = np.tile([0.01, 0.3, 0.5, 0.7, 0.99], len(arcs.sphere))
    points = arc_points(arcs, which, arcs.angle[which, 0] + share * np.diff(arcs.angle)[which, 0])
    rays = rays_through(camera, points)
    sphere = arcs.sphere[which]
    centre = spheres.centre - eye_of(camera)
    near = np.sum(rays * centre[sphere], axis=1) / np.sum(rays**2, axis=1)
    touching = near[:, None] * rays
    assert np.linalg.norm(touching - centre[sphere], axis=1) == pytest.approx(
        spheres.radius[sphere], rel=1e-7
    )
    length = np.linalg.norm(touching, axis=1)
    seen, margin = seen_slowly(
        np.column_stack([centre, spheres.radius]),
        sphere,
        rays / np.linalg.norm(rays, axis=1)[:, None],
        length,
    )
    assert np.all(seen | (margin < 1e-6))


def test_a_sphere_ahead_is_a_circle_a_little_larger_than_the_paper_s() -> None:
    camera = look_at((5, 0, 0), (0, 0, 0), field=math.pi / 2, width=100, height=100)
    arcs = outline_arcs(Scene((spheres_body([0, 0, 0], 3.0),)), camera)
    assert arcs.disk[0] == pytest.approx(
        [50, 50, 50 * 3 / 4]
    )  # the tangent: 3-4-5; the paper's circle has 50 x 3 / 5
    assert arcs.squeeze[0, 0] == pytest.approx(1.0) and np.ptp(arcs.angle[0]) == pytest.approx(
        math.tau
    )


def test_a_sphere_aside_is_an_ellipse_drawn_outward() -> None:
    camera = look_at((5, 0, 0), (0, 0, 0), field=math.pi / 2, width=100, height=100)
    arcs = outline_arcs(Scene((spheres_body([0, 5.0, 0], 1.0),)), camera)
    low = math.tan(math.pi / 4 - math.asin(1 / math.sqrt(50)))
    high = math.tan(math.pi / 4 + math.asin(1 / math.sqrt(50)))
    assert arcs.disk[0] == pytest.approx([50 + 25 * (low + high), 50, 25 * (high - low)])
    assert arcs.squeeze[0] == pytest.approx([math.sqrt(24 / 49), 0.0])


def test_the_svg_draws_ellipses_and_is_well_formed() -> None:
    camera = standard_view("corner", BOX, width=300, height=300, field=1.0)
    scene = Scene((crowd(5, 30),), boxes([[-1, -1, -1], [1, 1, -0.9]]))
    text = outline(scene, camera)
    path = "".join(item.get("d") or "" for item in bodies(text))
    assert (
        path.count("A") > 20 and "nan" not in text and ElementTree.fromstring(text).get("viewBox")
    )


def test_a_limb_fades_into_its_neighbour_in_perspective_too() -> None:
    two = [[0, -0.03, 0.01], [0, 0.03, 0.0]]
    scene = Scene((spheres_body(two, [0.05, 0.05]),))
    camera = look_at((2, 0, 0), (0, 0, 0), field=0.2)
    assert len(outline_arcs(scene, camera).sphere) == 2  # one closed line of two arcs
    closer = Scene((spheres_body([[0.07, -0.03, 0.01], [0, 0.03, 0.0]], [0.05, 0.05]),))
    nearer = outline_arcs(closer, camera)
    whole = np.diff(nearer.angle[nearer.sphere == 0])
    assert whole.sum() == pytest.approx(math.tau)  # 70 mm in front: drawn all round


def test_rims_end_at_the_near_plane_and_nothing_behind_the_eye_is_drawn() -> None:
    balls = spheres_body([[0.0, 0.4, 0], [3.0, 0, 0], [1.0, 0.02, 0]], [0.3, 0.5, 0.2])
    camera = look_at((1.05, 0, 0), (0, 0, 0), field=2.0, width=200, height=200)
    assert set(outline_arcs(Scene((balls,)), camera).sphere) == {
        0
    }  # one is behind, one holds the eye
    cut = replace(camera, cut=0.1)
    arcs = outline_arcs(Scene((balls,)), cut)
    assert arcs.lead.tolist() == [[-1, -1]]


def test_the_eye_of_a_body_draws_its_hands() -> None:
    scene = scene_of("trainer_clearance")
    camera = eye_view(scene.bodies[0], width=300, height=300)
    arcs = outline_arcs(scene, camera)
    assert np.isfinite(arc_points(arcs, np.arange(len(arcs.sphere)), arcs.angle[:, 0])).all()
    assert "nan" not in outline(scene, camera)


def test_projected_centres_lie_inside_their_ellipses() -> None:
    scene = Scene((crowd(3),))
    camera = look_at((2.5, 1, 1), (0, 0, 0), field=1.0)
    arcs = outline_arcs(scene, camera)
    middle = project(camera, scene.spheres.centre[arcs.sphere])[:, :2]
    assert np.all(np.linalg.norm(middle - arcs.disk[:, :2], axis=1) < arcs.disk[:, 2])
    assert (
        np.all(to_view(camera, scene.spheres.centre)[:, 2] < camera.distance)
        and front().inverse_distance == 0.0
    )
