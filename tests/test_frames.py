"""The fast raster display: equal to a plain painter and to a ray caster, and sorted from the frame
before."""

from __future__ import annotations

import math
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.test_draw import BOX, SVG, boxes, crowd, eye_of, front, spheres_body, veiled
from workbench import InputError, UsageError, scene_of
from workbench.draw.camera import Camera, look_at, orbit, standard_view
from workbench.draw.disks import MODES, POLYGONS, disks
from workbench.draw.kernels.disk_painter import update_depth_order
from workbench.draw.lines.circles import circles
from workbench.draw.scene import Scene, Spheres
from workbench.draw.sphere_raster import (
    cast_rays,
    exact_item_buffer,
    painter_item_buffer,
    project_disks,
    shade_surfaces,
)
from workbench.draw.visibility import render_buffers
from workbench.model.arrays import Bools, Floats, Ints


def swarm(seed: int, count: int = 40) -> Spheres:
    random = np.random.default_rng(seed)
    centre = random.uniform(-0.9, 0.9, (count, 3))
    return Spheres(centre, random.uniform(0.02, 0.4, count), np.zeros(count, dtype=np.int64))


def cameras(seed: int, width: int = 53, height: int = 37) -> list[Camera]:
    """A parallel view, one in perspective from outside, one from within the swarm, and cut ones."""
    eye = np.random.default_rng(seed).normal(size=3)
    eye /= np.linalg.norm(eye)
    flat = look_at(2.0 * eye, (0, 0, 0), field=0.0, width=width, height=height)
    far = look_at(3.0 * eye, (0, 0, 0), field=0.8, width=width, height=height)
    inside = look_at(0.5 * eye, (0, 0, 0), field=1.6, width=width, height=height)
    return [
        flat,
        replace(flat, cut=0.2),
        far,
        replace(far, cut=0.1),
        inside,
        replace(inside, cut=0.3),
    ]


def lit(spheres, camera, colour, *, last=None):
    """A shaded picture of spheres that are all of one colour, and the order for the next frame."""
    found = project_disks(spheres, camera, last=last)
    full = np.tile(np.array(colour, dtype=float), (len(found.front), 1))
    return shade_surfaces(found, cast_rays(found, camera), camera, full), found.all


def cast(spheres: Spheres, camera: Camera) -> tuple[Floats, Ints, Bools]:
    """Depth and sphere that a ray through each pixel meets first behind the nearest plane; and
    where that is clear.

    Worked out in world coordinates; not clear are pixels within rounding of an outline or of where
    two spheres meet.
    """
    rows, columns = np.mgrid[: camera.height, : camera.width] + 0.5
    across = (columns - camera.width / 2.0) / camera.scale
    high = (camera.height / 2.0 - rows) / camera.scale
    start = camera.centre + across[..., None] * camera.right + high[..., None] * camera.up
    ray = camera.toward + camera.inverse_distance * (camera.centre - start)  # one metre of depth
    square = np.sum(ray * ray, axis=-1)[..., None]
    off = start[..., None, :] - spheres.centre
    half = -np.sum(off * ray[..., None, :], axis=-1)
    rest = half * half - square * (np.sum(off * off, axis=-1) - spheres.radius**2)
    root = np.sqrt(np.maximum(rest, 0.0))
    near = (half + root) / square
    far = (half - root) / square
    there = (rest > 0.0) & (far < camera.nearest)
    if math.isfinite(camera.distance):
        there &= np.linalg.norm(spheres.centre - eye_of(camera), axis=1) > spheres.radius
    depth = np.where(there, np.minimum(near, camera.nearest), -np.inf)
    doubtful = (np.abs(rest) < 1e-9).any(axis=-1) | (np.abs(far - camera.nearest) < 1e-9).any(
        axis=-1
    )
    return depth.max(axis=-1), np.where(there.any(axis=-1), depth.argmax(axis=-1), -1), ~doubtful


@given(st.integers(0, 2**32 - 1))
def test_surfaces_are_those_a_ray_caster_finds(seed: int) -> None:
    spheres = swarm(seed)
    for camera in cameras(seed):
        found = cast_rays(project_disks(spheres, camera), camera)
        depth, sphere, clear = cast(spheres, camera)
        assert np.array_equal(found.sphere >= 0, sphere >= 0) or np.array_equal(
            (found.sphere >= 0)[clear], (sphere >= 0)[clear]
        )
        here = clear & (sphere >= 0)
        assert np.allclose(found.depth[here], depth[here], rtol=0, atol=1e-6)
        unique = here & (depth < camera.nearest)
        assert np.mean(found.sphere[unique] == sphere[unique]) > 0.999 or unique.sum() < 100


def painted_plainly(disk: Floats, order: Ints, camera: Camera) -> Ints:
    rows, columns = np.mgrid[: camera.height, : camera.width] + 0.5
    picture = np.full((camera.height, camera.width), -1)
    for sphere in order:
        x, y, radius = disk[sphere]
        picture[(columns - x) ** 2 + (rows - y) ** 2 <= radius * radius] = sphere
    return picture


@given(st.integers(0, 2**32 - 1), st.integers(1, 80))
def test_flat_disks_equal_a_plain_painter_pixel_for_pixel(seed: int, count: int) -> None:
    spheres = swarm(seed, count)
    for camera in cameras(seed)[:4]:
        found = project_disks(spheres, camera)
        assert np.array_equal(
            painter_item_buffer(found, camera), painted_plainly(found.disk, found.order, camera)
        )


def test_exact_disks_in_perspective_are_those_that_rays_meet() -> None:
    one = Spheres(np.array([[0.0, 1.2, 0.4]]), np.array([0.5]), np.zeros(1, dtype=np.int64))
    camera = look_at((2.5, 0, 0), (0, 0, 0), field=1.2, width=90, height=70)
    drawn = exact_item_buffer(project_disks(one, camera), camera) >= 0
    _, sphere, _ = cast(one, camera)
    assert np.array_equal(drawn, sphere >= 0)
    paper = painter_item_buffer(project_disks(one, camera), camera) >= 0
    assert np.sum(paper != drawn) > 0 and np.sum(paper & ~drawn) < 0.05 * np.sum(paper)


@pytest.mark.parametrize("along", [0.02, 0.1, 0.3])
@pytest.mark.parametrize("aside", [0.0, 0.3, 0.7])
def test_the_paper_s_circle_differs_from_the_ellipse_by_as_much_as_is_said(
    along: float, aside: float
) -> None:
    """A radius of `along` and a way off the line of sight of `aside`, as shares of the distance
    along the view."""
    outer = (math.sqrt(1 + aside**2 - along**2) + aside * along) / (
        1 - along**2
    ) - 1.0  # docs/displays.md
    turn = math.atan(aside)
    half = math.asin(along / math.hypot(1, aside))
    ellipse = math.tan(turn + half)
    circle = aside + along
    assert (ellipse - circle) / along == pytest.approx(outer)
    camera = look_at((1.0, 0, 0), (0, 0, 0), field=2.5, width=4000, height=4000)
    one = project_disks(
        Spheres(np.array([[0.0, aside, 0.0]]), np.array([along]), np.zeros(1, dtype=np.int64)),
        camera,
    )
    right = (one.disk[0, 0] + one.disk[0, 2] - 2000.0) / camera.scale
    assert right == pytest.approx(circle)


def test_a_frame_is_sorted_from_the_one_before_with_few_moves() -> None:
    spheres = swarm(3, 200)
    camera = front(64)
    first = project_disks(spheres, camera)
    assert first.moves == 0 and project_disks(spheres, camera, last=first.all).moves == 0
    stepped = spheres._replace(
        centre=spheres.centre + np.random.default_rng(0).normal(0, 0.002, (200, 3))
    )
    second = project_disks(stepped, camera, last=first.all)
    anew = project_disks(stepped, camera)
    assert 0 < second.moves < 600
    assert np.array_equal(second.order, anew.order)
    assert np.array_equal(painter_item_buffer(second, camera), painter_item_buffer(anew, camera))


@given(st.lists(st.integers(0, 9), max_size=40))
def test_insertion_sorts_stably_and_counts_its_moves(depths: list[int]) -> None:
    values = np.array(depths, dtype=float)
    order = np.arange(len(depths))[::-1].copy()
    backward = values[::-1]
    moves = update_depth_order(order, values)
    assert order.tolist() == np.argsort(values, kind="stable").tolist()
    assert moves == sum(
        backward[i] > backward[j] or backward[i] == backward[j]
        for i in range(len(depths))
        for j in range(i + 1, len(depths))
    )


def test_a_camera_carried_all_the_way_round_returns_to_the_first_frame() -> None:
    spheres = swarm(5)
    camera = front(90)
    first = frame = project_disks(spheres, camera)
    picture, order = lit(spheres, camera, (250, 240, 230))
    for step in range(1, 37):
        now = orbit(camera, math.radians(10 * step))
        frame = project_disks(spheres, now, last=frame.all)
        _, order = lit(spheres, now, (250, 240, 230), last=order)
    assert (
        np.array_equal(painter_item_buffer(frame, camera), painter_item_buffer(first, camera))
        and frame.moves > 0
    )
    assert np.array_equal(lit(spheres, camera, (250, 240, 230), last=order)[0], picture)


def test_light_falls_from_the_left_and_creases_are_darker() -> None:
    ball = Spheres(np.array([[0.0, 0, 0]]), np.array([0.8]), np.zeros(1, dtype=np.int64))
    one = lit(ball, front(100), (200, 200, 200))[0][..., 0].astype(int)
    assert one[30, 30] > one[70, 70] and one[0, 0] == 255 and one.min() > 60
    two = Spheres(
        np.array([[0.0, 0.25, 0], [0.0, -0.25, 0]]),
        np.array([0.4, 0.4]),
        np.zeros(2, dtype=np.int64),
    )
    alone = two._replace(centre=two.centre * [1, 1, 1] + [[0, 0, 0], [0, -9, 0]])
    pair, single = (lit(row, front(400), (200, 200, 200))[0][200, 203, 0] for row in (two, alone))
    assert int(pair) < int(single) - 5


def test_every_mode_and_style_draws_the_scene() -> None:
    scene = Scene((crowd(),), boxes([[-1, -1, -1], [1, 1, -0.9]]))
    for camera in (front(64), standard_view("corner", BOX, width=64, height=48, field=1.0)):
        pictures = [np.asarray(disks(scene, camera, mode=mode)) for mode in MODES]
        pictures += [
            np.asarray(disks(scene, camera, polygons=style, exact=True)) for style in POLYGONS
        ]
        assert all(
            p.shape[:2] == (camera.height, camera.width) and np.ptp(p) > 50 for p in pictures
        )


def test_the_depth_picture_is_light_where_near_and_black_where_nothing_is() -> None:
    scene = Scene((spheres_body([[0.4, 0.5, 0], [-0.4, -0.5, 0]], [0.2, 0.2]),))
    grey = np.asarray(disks(scene, front(64), mode="depth"))
    assert grey[32, 48] > 250 and 1 <= grey[32, 16] < 120 and grey[0, 0] == 0


def test_the_id_picture_names_the_sphere_at_a_pixel() -> None:
    scene = scene_of("bubbleman")
    camera = standard_view("front", scene.bounds, width=300, height=300)
    red, green, blue = (int(v) for v in np.asarray(disks(scene, camera, mode="id"))[28, 150])
    body = scene.bodies[0].placed.body
    assert body.segment_names[body.sphere_segment[(red << 16 | green << 8 | blue) - 1]] == "head"


def test_with_an_opaque_veil_walls_and_bodies_share_one_depth_buffer() -> None:
    wall = boxes([[0.2, -1, -1], [0.25, 1, 1]])
    body = spheres_body([[0, 0, 0], [0.9, 0.9, 0.9]], [0.5, 0.05])
    scene = Scene((body,), wall)
    camera = front(128)
    covered = np.asarray(disks(scene, camera, mode="shaded", veil=1.0)).astype(int)
    open_ = np.asarray(disks(scene, camera, mode="shaded", veil=0.0)).astype(int)
    assert np.abs(covered - open_)[64, 64].max() == 0  # in front of the wall
    assert veiled(render_buffers(scene, camera, spheres="surfaces"))[64, 64 - 31]
    assert np.abs(covered - open_)[64, 64 - 31].max() > 10  # the ball's edge is behind it


def test_hidden_line_style_leaves_faces_white() -> None:
    scene = Scene((), boxes([[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]]))
    picture = np.asarray(disks(scene, front(64), polygons="hidden_line"))
    assert np.all(picture[32, 32] == 255) and picture[20:44, 15:18].min() < 200


@pytest.mark.parametrize(
    ("wrong", "error", "message"),
    [
        (
            lambda: project_disks(swarm(1)._replace(radius=np.full(40, np.nan)), front()),
            InputError,
            "finite",
        ),
        (
            lambda: project_disks(
                swarm(1, 3), front(), last=project_disks(swarm(1, 4), front()).all
            ),
            UsageError,
            "4 spheres, this frame has 3",
        ),
        (
            lambda: disks(Scene((crowd(),)), front(), mode="flatt"),
            UsageError,
            "did you mean 'flat'",
        ),
        (lambda: disks(Scene((crowd(),)), front(), polygons="lines"), UsageError, "hidden_line"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_words(
    wrong: object, error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        wrong()  # type: ignore[operator]


def test_an_empty_scene_and_a_view_that_misses_are_white() -> None:
    nothing = Spheres(np.empty((0, 3)), np.empty(0), np.empty(0, dtype=np.int64))
    away = standard_view("front", BOX + 50.0, width=9, height=7)
    for spheres, camera in ((nothing, front(8)), (swarm(1), away)):
        assert np.all(painter_item_buffer(project_disks(spheres, camera), camera) == -1)
        assert np.all(lit(spheres, camera, (9, 9, 9))[0] == 255)


def test_a_hundred_thousand_spheres_and_one_pixel_are_pictures() -> None:
    random = np.random.default_rng(0)
    many = Spheres(
        random.uniform(-1, 1, (100_000, 3)),
        random.uniform(0.001, 0.02, 100_000),
        np.zeros(100_000, dtype=np.int64),
    )
    assert np.mean(painter_item_buffer(project_disks(many, front(200)), front(200)) >= 0) > 0.1
    assert painter_item_buffer(project_disks(many, front(1)), front(1)).shape == (1, 1)


def test_circles_in_perspective_are_the_paper_s_and_ellipses_where_asked_for() -> None:
    scene = Scene((crowd(2, 9),))
    camera = look_at((3, 0.4, 0.2), (0, 0, 0), field=0.9)
    root = ElementTree.fromstring(circles(scene, camera))
    disk = project_disks(scene.spheres, camera)
    found = [
        [float(item.get(key) or 0) for key in ("cx", "cy", "r")]
        for item in root.iter(SVG + "circle")
    ]
    assert np.array(found) == pytest.approx(disk.disk[disk.order], abs=0.051)
    exact = list(ElementTree.fromstring(circles(scene, camera, exact=True)).iter(SVG + "ellipse"))
    assert len(exact) == 9 and all(
        float(item.get("rx") or 0) >= float(item.get("ry") or 0) for item in exact
    )
    radius = np.sort([float(item.get("ry") or 0) for item in exact])
    assert np.all(radius > np.sort(disk.disk[:, 2]) - 0.1)


def test_a_pose_that_is_not_finite_is_refused_by_name() -> None:
    body = crowd()
    lost = replace(body.placed, centres=np.full_like(body.placed.centres, np.nan))
    with pytest.raises(InputError, match="body lump, pose 0: sphere centres must be finite"):
        disks(Scene((replace(body, placed=lost),)), front())


@pytest.mark.nightly
def test_a_million_spheres_are_a_picture() -> None:
    random = np.random.default_rng(0)
    place = random.uniform(-1, 1, (1_000_000, 3))
    none = np.zeros(1_000_000, dtype=np.int64)
    many = Spheres(place, random.uniform(0.0005, 0.005, 1_000_000), none)
    assert (
        np.mean(painter_item_buffer(project_disks(many, front(300)), front(300)) < 0) < 0.01
    )  # each pixel lies under some ten of them
    assert np.mean(cast_rays(project_disks(many, front(300)), front(300)).sphere < 0) < 0.01
