"""Displays: what covers what, what is never drawn, and that the same scene gives the same bytes."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import ArrayLike

from workbench import Body, Environment, InputError, Placed, Topology, UsageError
from workbench.draw.camera import VIEWS, Camera, project, standard_view
from workbench.draw.disks import disks
from workbench.draw.hidden import shining_part
from workbench.draw.lines.circles import circles
from workbench.draw.lines.edges import drawn_edges, visible_lines
from workbench.draw.marks.layout import layout_marks
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.draw.views import four_views
from workbench.draw.visibility import projected_disks, render_buffers
from workbench.model.arrays import Ints
from workbench.model.stops import Stops

BOX = np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
SVG = "{http://www.w3.org/2000/svg}"
QUADS = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def numbered(points):
    """Marks of contacts with the labels 1, 2, 3, ... at points (M, 3) [m]."""
    return tuple(
        Mark(tuple(map(float, point)), str(number), "contact")
        for number, point in enumerate(points, start=1)
    )


def eye_of(camera):
    """(3,) [m] where the viewer's eye of a view in perspective is."""
    return camera.centre + camera.distance * camera.toward


def veiled(layers):
    """(height, width) a body is here and an opaque triangle stands in front of it."""
    return (layers.sphere >= 0) & (layers.depth > layers.body_depth)


def spheres_body(centre: ArrayLike, radius: ArrayLike) -> SceneBody:
    """A body of one segment made of these spheres, one pose."""
    points = np.array(centre, dtype=float).reshape(-1, 3)
    radii = np.array(radius, dtype=float).reshape(-1)
    none = np.empty(0)
    count = len(radii)
    stops = Stops(
        none,
        np.empty((0, 3, 3)),
        np.empty((0, 3, 2)),
        none,
        (),
        (),
        (),
        np.empty((0, 3)),
        none,
        np.empty((0, 3)),
    )
    topology = Topology(
        segments=("A",),
        segment_names=("a",),
        segment_numbers=(1,),
        joints=(),
        joint_names=(),
        joint_numbers=(),
        parent=np.array([-1]),
        stops=stops,
        start=np.array([0, count]),
        sphere_names=("",) * count,
        sphere_direction=np.full(count, -1),
        directions=np.zeros((1, 6, 3)),
        twist_joint=np.array([-1]),
    )
    body = Body(
        name="lump",
        description="",
        topology=topology,
        joint_in_parent=np.empty((1, 0, 3)),
        joint_in_child=np.empty((1, 0, 3)),
        mass=np.ones((1, 1)),
        centre=points[None],
        radius=radii[None],
        enclosing_centre=np.zeros((1, 1, 3)),
        enclosing_radius=np.array([[9.0]]),
        twist_point=np.zeros((1, 1, 3)),
        twist_axis=np.zeros((1, 1, 3)),
        twist_share=np.zeros((1, count)),
        allowance=np.zeros((1, 1, 1)),
        fit_error=np.zeros((1, 1, 2)),
    )
    return SceneBody(Placed(body, np.eye(4)[None, None, :3], points[None], np.array([True])))


def boxes(
    *corners: ArrayLike, hidden: bool = False, see_through: bool = False, solid: bool = True
) -> Environment:
    """An environment of boxes given by their least and greatest corners (2, 3), all of one kind."""
    count = len(corners)
    faces = 6 * len(corners)
    unit = np.array([[(i >> k) & 1 for k in range(3)] for i in range(8)])
    vertices = np.concatenate(
        [np.where(unit, np.array(box)[1], np.array(box)[0]) for box in corners]
    ).astype(float)
    quads = np.concatenate([np.array(QUADS) + 8 * k for k in range(count)])
    first, second, third, _ = vertices[quads].transpose(1, 0, 2)
    normal = np.cross(second - first, third - first)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    centre = vertices[quads].mean(axis=1)
    return Environment(
        "boxes",
        "",
        tuple(f"box {k}" for k in range(count)),
        np.arange(count + 1) * 6,
        vertices,
        np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2),
        np.arange(faces + 1) * 4,
        normal,
        np.sum(normal * centre, axis=1),
        centre,
        np.linalg.norm(first - centre, axis=1),
        quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3),
        np.arange(faces + 1) * 2,
        np.full(count, solid),
        np.full(count, hidden),
        np.full(count, see_through),
    )


def front(size: int = 64) -> Camera:
    """Two metres square about the origin."""
    return standard_view("front", BOX, width=size, height=size, margin=0.0)


def crowd(seed: int = 1, count: int = 60) -> SceneBody:
    random = np.random.default_rng(seed)
    return spheres_body(random.uniform(-0.9, 0.9, (count, 3)), random.uniform(0.02, 0.4, count))


def painted_slowly(scene: Scene, camera: Camera) -> Ints:
    """In every pixel the last sphere of the painter's order whose disk holds the pixel's centre."""
    flat = projected_disks(scene, camera)
    rows, columns = np.mgrid[: camera.height, : camera.width] + 0.5
    ids = np.full((camera.height, camera.width), -1)
    for sphere in sorted(range(len(flat.front)), key=lambda k: (flat.front[k], k)):
        x, y, radius = flat.disk[sphere]
        ids[(columns - x) ** 2 + (rows - y) ** 2 <= radius * radius] = sphere
    return ids


@pytest.mark.parametrize("view", VIEWS)
def test_disks_equal_a_plain_painter_pixel_for_pixel(view: str) -> None:
    scene = Scene((crowd(),))
    camera = standard_view(view, BOX, width=61, height=47)
    assert np.array_equal(render_buffers(scene, camera).sphere, painted_slowly(scene, camera))


def test_the_depth_of_a_body_is_that_of_a_ray_through_each_pixel() -> None:
    scene = Scene((crowd(2),))
    camera = front(32)
    depth = render_buffers(scene, camera).body_depth
    spheres = scene.spheres
    rays = (np.mgrid[:32, :32] + 0.5 - 16.0) / 16.0
    off = (rays[1][..., None] - spheres.centre[:, 1]) ** 2 + (
        -rays[0][..., None] - spheres.centre[:, 2]
    ) ** 2
    half = np.sqrt(np.maximum(spheres.radius**2 - off, 0.0))
    slow = np.where(off <= spheres.radius**2, spheres.centre[:, 0] + half, -np.inf).max(axis=-1)
    assert np.allclose(depth, slow, rtol=0, atol=1e-6)


def test_a_nearer_disk_hides_a_farther_one() -> None:
    scene = Scene((spheres_body([[0.5, 0, 0], [0.0, 0, 0]], [0.2, 0.5]),))
    layers = render_buffers(scene, front())
    assert layers.sphere[32, 32] == 0
    assert (
        layers.sphere[32, 32 + 12] == 1
    )  # 12 px = 0.375 m to the left of the middle: only the large one
    assert layers.sphere[0, 0] == -1


def test_a_sphere_behind_a_polygon_is_hidden_by_it_where_the_veil_is_opaque() -> None:
    wall = boxes([[0.0, -1, 0.0], [0.05, 1, 1]])  # the upper half of the picture
    body = spheres_body(
        [[-0.5, 0, 0], [0.9, 0.8, -0.8]], [0.5, 0.1]
    )  # the second one keeps the wall from being cut
    camera = front(256)
    alone = np.asarray(disks(Scene((), wall), camera))
    picture = np.asarray(disks(Scene((body,), wall), camera, veil=1.0))
    assert (
        np.ptp(picture[96, 128].astype(int) - alone[96, 128]) <= 2
    )  # the wall's own hue, a little less faded
    assert picture[96, 128].min() > 180 > picture[160, 128].min()
    assert veiled(render_buffers(Scene((body,), wall), camera))[96, 128]


def test_a_part_inside_a_body_shines_through_it_and_nothing_else_does() -> None:
    inside = boxes([[-0.2, -0.2, 0.0], [0.2, 0.2, 0.3]])
    scene = Scene((spheres_body([0, 0, 0], 0.9),), inside)
    camera = front(256)
    picture = np.asarray(shining_part(scene, camera, inside.parts[0])).astype(int)
    plain = np.asarray(disks(scene, camera, mode="shaded")).astype(int)
    rows, columns = np.nonzero((picture != plain).any(axis=2)[:200])  # above the scale bar
    assert abs(rows.min() - 89) <= 1 and abs(rows.max() - 128) <= 1  # z from 0 to 0.3 of two metres
    assert abs(columns.min() - 102) <= 1 and abs(columns.max() - 154) <= 1
    red, green, blue = picture[108, 128] - plain[108, 128]
    assert red > green + 20 > blue
    with pytest.raises(UsageError, match="no part 'wing' in the scene"):
        shining_part(scene, camera, "wing")


def test_what_is_nearer_than_every_body_is_cut_away() -> None:
    body = spheres_body([0, 0, 0], 0.5)
    wall = boxes([[0.6, -1, -1], [0.7, 1, 1]])
    layers = render_buffers(Scene((body,), wall), front())
    assert layers.cut == pytest.approx(0.5, abs=2e-3)
    assert np.all(layers.triangle == -1)


def test_a_solid_that_the_cut_goes_through_shows_its_section() -> None:
    body = spheres_body([0, 0, 0], 0.25)
    block = boxes([[-1, 0.5, -1], [1, 1, 1]])
    layers = render_buffers(Scene((body,), block), front())
    assert np.all(layers.section[:, 49:63]) and not np.any(layers.section[:, :48])
    assert np.allclose(layers.depth[:, 49:63], layers.cut)


@pytest.mark.parametrize("display", ["disks", "circles"])
def test_a_hidden_part_is_not_drawn(display: str) -> None:
    body = spheres_body([0, 0, 0], 0.5)
    box = boxes([[-1, -1, -1], [0.2, 1, 1]], hidden=True)
    draw = {
        "disks": lambda scene: disks(scene, front()).tobytes(),
        "circles": lambda scene: drawing(scene),
    }[display]
    assert draw(Scene((body,), box)) == draw(Scene((body,), None))


def drawing(scene: Scene) -> list[str]:
    """All paths and circles of the circle picture."""
    root = ElementTree.fromstring(circles(scene, front()))
    return [
        ElementTree.tostring(item).decode()
        for kind in ("path", "circle")
        for item in root.iter(SVG + kind)
    ]


def test_a_see_through_part_tints_and_does_not_hide() -> None:
    body = spheres_body([[0, 0, 0], [0.9, 0.8, -0.8]], [0.5, 0.1])
    pane = boxes([[0.6, -1, -1], [0.62, 1, 1]], see_through=True)
    bare, seen = (
        np.asarray(disks(Scene((body,), e), front())).astype(int)[32, 32] for e in (None, pane)
    )
    assert 0 < np.abs(bare - seen).max() < 30


def test_a_box_seen_from_the_front_is_drawn_with_the_four_edges_of_its_face() -> None:
    scene = Scene((), boxes([[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]]))
    camera = front()
    edges, clear = drawn_edges(boxes([[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]]), camera, np.inf)
    lines = visible_lines(edges, clear, render_buffers(scene, camera))
    near = lines.ends[lines.depth > 0.49]
    assert len(edges) == 12 and not lines.faint.any()
    assert np.linalg.norm(near[:, 1] - near[:, 0], axis=1) == pytest.approx([32.0] * 4)


def test_the_svg_parses_and_has_one_circle_for_every_sphere() -> None:
    scene = Scene(
        (crowd(), crowd(3, 7)),
        boxes([[-1, -1, -1], [1, 1, -0.9]]),
        numbered([[0, 0, 0], [0.1, 0, 0]]),
    )
    root = ElementTree.fromstring(circles(scene, front(640)))
    assert root.get("viewBox") == "0 0 640 640"
    assert len(list(root.iter(SVG + "circle"))) == 67
    assert root.find(SVG + "title") is not None and root.find(SVG + "desc") is not None


def test_names_and_labels_are_text_whatever_they_hold() -> None:
    scene = Scene((crowd(),), None, (Mark((0, 0, 0), "<script>&"),), title="<b>", description='"&<')
    root = ElementTree.fromstring(circles(scene, front()))
    assert next(item.text for item in root.iter(SVG + "text")) == "<script>&"
    assert not list(root.iter(SVG + "script"))


def test_the_same_scene_gives_the_same_bytes() -> None:
    scene = Scene((crowd(),), boxes([[-1, -1, -1], [1, 1, -0.8]]), numbered([[0, 0, 0]]))
    assert disks(scene, front()).tobytes() == disks(scene, front()).tobytes()
    assert circles(scene, front()) == circles(scene, front())


@pytest.mark.parametrize("view", VIEWS)
def test_a_standard_view_holds_its_box_and_touches_the_margin(view: str) -> None:
    bounds = np.array([[0.0, -0.3, 0.1], [1.2, 0.3, 2.0]])
    camera = standard_view(view, bounds, width=300, height=200, margin=0.1)
    corners = np.array(
        [[bounds[i, 0], bounds[j, 1], bounds[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    )
    pixels = project(camera, corners)[:, :2] / (300, 200)
    assert pixels.min() >= 0.1 - 1e-9 and pixels.max() <= 0.9 + 1e-9
    assert np.min(np.concatenate([pixels.min(axis=0), 1.0 - pixels.max(axis=0)])) == pytest.approx(
        0.1
    )


@pytest.mark.parametrize(
    ("view", "forward", "left", "up"),
    [
        ("front", "near", "right", "up"),
        ("back", "far", "left", "up"),
        ("left", "left", "near", "up"),
        ("right", "right", "far", "up"),
        ("top", "up", "left", "near"),
        ("bottom", "up", "right", "far"),
    ],
)
def test_the_axes_of_the_body_point_where_the_view_says(
    view: str, forward: str, left: str, up: str
) -> None:
    camera = standard_view(view, BOX)
    names = ["right", "up", "near", "left", "down", "far"]
    for axis, said in zip(np.eye(3), (forward, left, up), strict=True):
        along = project(camera, axis) - project(camera, np.zeros(3))
        picture = np.array([along[0] / camera.scale, -along[1] / camera.scale, along[2]])
        assert names[int(np.argmax([*picture, *-picture]))] == said


def test_four_views_hold_every_sphere_at_one_scale() -> None:
    scene = Scene((crowd(),), boxes([[-1, -1, -1], [5, 1, -0.9]]))
    for _, camera in (views := four_views(scene, width=200, height=200)):
        flat = projected_disks(scene, camera).disk
        assert np.all(flat[:, :2] - flat[:, 2:] >= 0) and np.all(flat[:, :2] + flat[:, 2:] <= 200)
    assert len({camera.scale for _, camera in views}) == 1


def test_labels_of_crowded_marks_do_not_overlap() -> None:
    points = np.random.default_rng(4).normal(0.0, 0.05, (30, 3))
    placed = layout_marks(Scene((), None, numbered(points)), front(640))
    for a, b in combinations(placed, 2):
        apart = np.abs(np.subtract(a.label, b.label)) - np.add(a.half, b.half)
        assert apart.max() >= 0.0


def test_spheres_outside_the_logical_window_are_not_drawn() -> None:
    body = crowd()
    unplaced = replace(
        body.placed, centres=np.full_like(body.placed.centres, np.nan), window=np.array([False])
    )
    assert not len(Scene((SceneBody(unplaced),)).spheres.radius)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: standard_view("above", BOX), "no view 'above'.*valid"),
        (lambda: standard_view("front", BOX, width=0), "at least 1 x 1"),
        (lambda: standard_view("front", BOX * np.nan), "finite"),
        (lambda: SceneBody(crowd().placed, 5), "pose 5 of 1"),
        (lambda: SceneBody(crowd().placed, 0, "mauve"), "no colour family"),
        (lambda: Mark((0.0, np.nan, 0.0)), "finite point"),
        (lambda: Scene().bounds, "nothing to show"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_words(wrong: object, message: str) -> None:
    with pytest.raises((InputError, UsageError), match=message):
        wrong()  # type: ignore[operator]


def test_a_view_that_misses_the_scene_is_an_empty_page() -> None:
    camera = standard_view("front", BOX + 50.0, width=40, height=40)
    layers = render_buffers(Scene((crowd(),), boxes([[-1, -1, -1], [1, 1, -0.8]])), camera)
    assert np.all(layers.sphere == -1) and np.all(layers.triangle == -1)
