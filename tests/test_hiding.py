"""Polygons hide arcs and lines exactly: every sample agrees with a ray against every triangle and
sphere."""

from __future__ import annotations

import math
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.test_draw import BOX, SVG, boxes, crowd, front, spheres_body
from workbench import Placed, UsageError
from workbench.draw.camera import look_at, projective_depth, standard_view, to_view, view_to_pixels
from workbench.draw.disks import disks
from workbench.draw.films.film import every_pose
from workbench.draw.lines.arcs import arc_points, outline_arcs
from workbench.draw.lines.circles import circles, max_outline_difference
from workbench.draw.lines.edges import drawn_edges
from workbench.draw.lines.hidden_lines import (
    build_occluders,
    sections,
    split_hidden_arcs,
    surroundings,
    visible_edge_lines,
)
from workbench.draw.lines.occlusion import (
    Occluders,
    hidden_arcs,
    hidden_lines,
    occluder_planes,
)
from workbench.draw.lines.outline import outline
from workbench.draw.scene import Scene
from workbench.draw.sphere_raster import project_disks


def eye_rays(camera, points):
    """Unit directions (M, 3) from view coordinates to the eye, and the distances; a parallel view
    looks along z."""
    if math.isinf(camera.distance):
        return np.tile([0.0, 0.0, 1.0], (len(points), 1)), np.full(len(points), np.inf)
    away = np.array([0.0, 0.0, camera.distance]) - points
    length = np.linalg.norm(away, axis=1)
    return away / length[:, None], length


def blocked(camera, points, corners):
    """(M,) triangles between points and the eye (Moeller and Trumbore), and how far each is from
    being judged so."""
    ray, reach = eye_rays(camera, points)
    hit = np.zeros(len(points), bool)
    margin = np.full(len(points), np.inf)
    for a, b, c in corners:
        one = b - a
        two = c - a
        cross = np.cross(ray, two)
        area = cross @ one
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.sum((points - a) * cross, axis=1) / area
            other = np.cross(points - a, one)
            v = np.sum(ray * other, axis=1) / area
            far = (other @ two) / area
        inside = np.minimum.reduce([u, v, 1.0 - u - v])
        ahead = np.minimum(far, reach - far)
        least = np.where(np.isfinite(far), np.minimum(inside, ahead), -np.inf)
        hit |= least > 0.0
        margin = np.minimum(margin, np.abs(least))
    return hit, margin


def behind_balls(camera, points, spheres):
    """(M,) a sphere is between points and the eye or holds them, and how clearly."""
    ray, reach = eye_rays(camera, points)
    centre = to_view(camera, spheres.centre)
    hit = np.zeros(len(points), bool)
    margin = np.full(len(points), np.inf)
    for c, r in zip(centre, spheres.radius, strict=True):
        along = np.sum((c - points) * ray, axis=1)
        off = np.linalg.norm(c - points, axis=1)
        side = np.sqrt(np.maximum(off**2 - along**2, 0.0))
        hit |= (off < r) | ((side < r) & (along > 0.0) & (along < reach))
        margin = np.minimum(
            margin, np.minimum(np.abs(off - r), np.where(off < r, np.inf, np.abs(side - r)))
        )
    return hit, margin


def random_scene(seed, count=6):
    random = np.random.default_rng(seed)
    low = random.uniform(-1, 0.8, (count, 3))
    box = boxes(*np.stack([low, low + random.uniform(0.02, 0.9, (count, 3))], axis=1))
    body = spheres_body(random.uniform(-0.9, 0.9, (12, 3)), random.uniform(0.05, 0.4, 12))
    return Scene((body,), box)


CAMERAS = {
    "parallel": standard_view("corner", BOX, width=300, height=260),
    "perspective": look_at([2.6, 1.9, 1.4], [0, 0, 0], width=300, height=260, field=0.9),
}


def triangles(scene, camera):
    return to_view(camera, scene.environment.vertices)[scene.environment.triangles]


@pytest.mark.parametrize("view", CAMERAS)
@given(seed=st.integers(0, 2**32 - 1))
def test_an_arc_is_veiled_exactly_where_a_ray_to_the_eye_meets_a_polygon(view, seed):
    scene = random_scene(seed)
    camera = CAMERAS[view]
    arcs = split_hidden_arcs(
        outline_arcs(scene, camera), build_occluders(scene.environment, camera, np.inf)
    )
    random = np.random.default_rng(seed)
    which = random.integers(0, len(arcs.sphere), 400)
    angle = arcs.angle[which, 0] + random.uniform(0, 1, 400) * np.diff(arcs.angle)[which, 0]
    pixels = arc_points(arcs, which, angle)
    inside = np.all((pixels > 0) & (pixels < (camera.width, camera.height)), axis=1)
    which = which[inside]
    pixels = pixels[inside]
    depth = arcs.depth[which] + np.sum(arcs.tilt[which] * (pixels - arcs.disk[which, :2]), axis=1)
    depth = depth / (1.0 + depth * camera.inverse_distance)
    size = camera.scale / (1.0 - depth * camera.inverse_distance)
    points = np.column_stack([(pixels[:, 0] - 150) / size, (130 - pixels[:, 1]) / size, depth])
    hit, margin = blocked(camera, points, triangles(scene, camera))
    clear = margin > 5e-3
    assert np.array_equal(arcs.veiled[which][clear], hit[clear])


@pytest.mark.parametrize("view", CAMERAS)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_line_is_drawn_exactly_where_no_polygon_and_no_sphere_hides_it(view, seed):
    scene = random_scene(seed, 3)
    camera = CAMERAS[view]
    edges, clear = drawn_edges(scene.environment, camera, np.inf)
    drawn = visible_edge_lines(
        edges, clear, scene, camera, build_occluders(scene.environment, camera, np.inf), np.inf
    )
    random = np.random.default_rng(seed)
    which = random.integers(0, len(edges), 150)
    ends = np.concatenate(
        [edges[which, :, :2], projective_depth(camera, edges[which, :, 2:])], axis=2
    )
    share = random.uniform(0.02, 0.98, (150, 1))
    at = ends[:, 0] * (1 - share) + ends[:, 1] * share
    inside = np.all((at[:, :2] > 0) & (at[:, :2] < (camera.width, camera.height)), axis=1)
    at = at[inside]
    depth = at[:, 2] / (1.0 + at[:, 2] * camera.inverse_distance)
    size = camera.scale / (1.0 - depth * camera.inverse_distance)
    points = np.column_stack([(at[:, 0] - 150) / size, (130 - at[:, 1]) / size, depth])
    ray, _ = eye_rays(camera, points)
    lifted = points + 2e-3 * ray  # off its own faces, as the allowance of the display has it
    hit, margin = blocked(camera, lifted, triangles(scene, camera))
    ball, gap = behind_balls(camera, points, scene.spheres)
    sure = (margin > 1.6e-3) & (gap > 1e-3)
    assert sure.sum() > 20
    ends = drawn.ends
    along = ends[:, 1] - ends[:, 0]
    length = np.maximum(np.linalg.norm(along, axis=1), 1e-12)
    away = at[:, None, :2] - ends[None, :, 0]
    t = np.clip(np.sum(away * along, axis=2) / length**2, 0, 1)
    near = np.linalg.norm(away - t[:, :, None] * along, axis=2).min(axis=1)
    seen = ~(hit | ball)
    assert np.all(near[sure & seen] < 1e-6)
    assert np.sum(near[sure & ~seen] < 1e-6) <= 2  # another line may lie over it in the picture


def test_a_square_before_a_circle_hides_the_arc_inside_it_and_nothing_else():
    corners = np.array([[[0, -9, 1.0], [9, -9, 1], [9, 9, 1]], [[0, -9, 1], [9, 9, 1], [0, 9, 1]]])
    rim = np.array(
        [[[0.0, 0, 0], [4, 0, 0], [0, 4, 0]]]
    )  # radius 4: the right half lies behind the square
    hiders = hiders_by_hand(corners)
    of, angle, hidden = hidden_arcs(rim, np.array([[-math.pi, math.pi]]), hiders)
    assert of.tolist() == [0, 0, 0] and hidden.tolist() == [0, 1, 0]
    assert angle[1] == pytest.approx([-math.pi / 2, math.pi / 2])
    of, share, hidden = hidden_lines(
        np.array([[[-5.0, 0, 0], [5, 0, 0]], [[-5, 0, 2], [5, 0, 2]]]), hiders
    )
    assert (of.tolist(), hidden.tolist()) == ([0, 0, 1], [0, 1, 0]) and share[1].tolist() == [
        0.5,
        1.0,
    ]


def hiders_by_hand(corners):
    inside = np.arange(len(corners))
    return Occluders(occluder_planes(corners, 0.0), 1e3, 1, 1, np.array([0, len(corners)]), inside)


def test_a_slanting_plane_hides_what_is_behind_it_and_not_what_is_before_it():
    plane = np.array([[[-20.0, -20, -20], [20, -20, 20], [0, 40, 0]]])  # depth = x
    _, angle, hidden = hidden_arcs(
        np.array([[[0.0, 0, 0], [4, 0, 0], [0, 4, 0]]]),
        np.array([[-math.pi, math.pi]]),
        hiders_by_hand(plane),
    )
    assert angle[hidden == 1].tolist() == [pytest.approx([-math.pi / 2, math.pi / 2])]


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.0])
def test_a_line_along_the_side_of_a_nearer_triangle_is_hidden_however_it_is_rounded(turn):
    turned = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    corners = np.array([[[0.0, 0, 1], [300, 0, 1], [0, 300, 1]]])
    corners[..., :2] = corners[..., :2] @ turned.T + 100.0
    hiders = hiders_by_hand(corners)
    side = np.array([[[30.0, 0], [270, 0]], [[0, 300], [300, 0]], [[0, -150], [0, 450]]])
    lines = np.concatenate([side @ turned.T + 100.0, np.zeros((3, 2, 1))], axis=2)
    of, share, hidden = hidden_lines(lines, hiders)
    assert of.tolist() == [0, 1, 2, 2, 2] and hidden.tolist() == [True, True, False, True, False]
    assert share[3] == pytest.approx([0.25, 0.75], abs=1e-9)


def test_lines_far_beside_the_picture_and_very_long_ones_are_cut_at_the_same_places():
    hiders = hiders_by_hand(np.array([[[0.0, -9, 1], [9, 0, 1], [0, 9, 1]]]))
    ends = np.array([[-1.0, 0, 0], [1.0, 0, 0]])
    lines = np.array([ends * [size, 1, 1] for size in (20.0, 1e4, 1e7)])
    of, share, hidden = hidden_lines(lines, hiders)
    assert of.tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2]
    cuts = (share[hidden] - 0.5) * 2.0 * np.array([[20.0], [1e4], [1e7]])
    assert cuts == pytest.approx(np.tile([0.0, 9.0], (3, 1)), abs=1e-6)


def drawn(svg, name):
    """The elements of a group of a drawing."""
    return list(
        next((item for item in ElementTree.fromstring(svg) if item.get("class") == name), [])
    )


@pytest.mark.parametrize("display", [outline, circles])
def test_the_hidden_line_style_leaves_out_what_is_behind_a_wall(display):
    body = spheres_body([[0, 0, 0.5], [0.9, 0.9, 0.9]], [0.3, 0.05])
    wall = boxes([[0.5, -1, 0], [0.6, 1, 1]])
    scene = Scene((body,), wall)
    texts = {
        hidden: ElementTree.tostring(
            ElementTree.fromstring(display(scene, front(200), hidden=hidden))
        ).decode()
        for hidden in ("veiled", "hidden_line")
    }
    assert len(texts["hidden_line"]) < len(texts["veiled"])
    kinds = {
        item.get("class")
        for item in drawn(display(scene, front(200), hidden="hidden_line"), "bodies")
    }
    assert "veiled" not in kinds
    with pytest.raises(UsageError, match="no style 'solid'; valid: veiled, hidden_line"):
        display(scene, front(200), hidden="solid")


def test_a_circle_half_behind_a_wall_is_half_a_circle():
    body = spheres_body(
        [[0, 0, 0], [0.9, 0.9, 0.9]], [0.5, 0.05]
    )  # the second keeps the wall from being cut away
    scene = Scene((body,), boxes([[0.6, -1, 0], [0.7, 1, 1]]))
    rim = [
        item
        for item in drawn(circles(scene, front(200), hidden="hidden_line"), "bodies")
        if item.get("d")
    ]
    assert (
        len(rim) == 1
        and rim[0].get("d") == "M150.0 100.0A50.0 50.0 0 0 1 100.0 150.0A50.0 50.0 0 0 1 50.0 100.0"
    )


def drawn_points(rim):
    """Pixels (M, 2) inside the arcs or on the ellipse of an element, from its own attributes
    alone."""
    turn = np.linspace(0.05, math.tau - 0.05, 24)
    if rim.get("d") is None:
        x, y, a, b = (float(rim.get(key)) for key in ("cx", "cy", "rx", "ry"))
        lean = math.radians(float(rim.get("transform").removeprefix("rotate(").split()[0]))
        flat = np.column_stack([a * np.cos(turn), b * np.sin(turn)])
        return flat @ [[math.cos(lean), math.sin(lean)], [-math.sin(lean), math.cos(lean)]] + [x, y]
    middles = [part.split("A")[1].split()[-2:] for part in rim.get("d").split("M")[1:]]
    return np.array(middles, dtype=np.float64)


@given(seed=st.integers(0, 2**32 - 1))
def test_what_is_left_of_ellipses_behind_walls_touches_its_sphere_and_is_seen(seed):
    scene = random_scene(seed)
    camera = CAMERAS["perspective"]
    spheres = scene.spheres
    corners = triangles(scene, camera)
    balls = to_view(camera, spheres.centre) - [0.0, 0.0, camera.distance]
    cut = (
        np.max(balls[:, 2] + spheres.radius) + camera.distance
    )  # what is nearer than every body is cut away
    kept = corners[corners[:, :, 2].max(axis=1) <= cut]
    for rim in drawn(circles(scene, camera, exact=True, hidden="hidden_line"), "bodies"):
        if rim.tag == SVG + "desc":
            continue
        pixels = drawn_points(rim)
        ray = np.column_stack(
            [
                pixels[:, 0] - 150,
                130 - pixels[:, 1],
                np.full(len(pixels), -camera.scale * camera.distance),
            ]
        )
        ray /= np.linalg.norm(ray, axis=1)[:, None]
        along = ray @ balls.T
        miss = (
            np.abs(np.sqrt(np.sum(balls**2, axis=1) - along**2) - spheres.radius) / spheres.radius
        )
        nearest = np.argmin(miss.max(axis=0))  # one sphere's tangent cone holds all of them
        assert miss[:, nearest].max() * spheres.radius[nearest] < 4e-3  # 0.1 pixel is 1 mm
        points = ray * along[:, [nearest]] + [0.0, 0.0, camera.distance]
        hit, margin = blocked(camera, points, kept)
        assert not hit[margin > 0.05].any()


def test_the_largest_difference_of_circle_and_ellipse_is_that_of_its_formula():
    far = 3.0
    camera = look_at([far, 0, 0], [0, 0, 0], width=400, height=400, field=1.0)
    for t, k in (
        (0.0, 0.2),
        (0.3, 0.1),
    ):  # radius and way off the line of sight as shares of the depth
        scene = Scene((spheres_body([0.0, far * t, 0.0], far * k),))
        flat = project_disks(scene.spheres, camera)
        share = (math.sqrt(1 + t * t - k * k) + t * k) / (1 - k * k) - 1
        assert max_outline_difference(flat, camera) == pytest.approx(
            share * flat.disk[0, 2], rel=1e-9
        )
        told = drawn(circles(scene, camera), "bodies")[0]
        assert (
            told.tag == SVG + "desc"
            and f"at most {share * flat.disk[0, 2]:.1f} pixels" in told.text
        )
    assert max_outline_difference(flat, front(100)) == 0.0


def test_the_cut_face_of_a_solid_is_drawn_with_its_own_area():
    scene = Scene((spheres_body([0, 0, 0], 0.25),), boxes([[-1, 0.5, -1], [1, 1, 1]]))
    walls = surroundings(scene, front(100), "veiled")
    (loops,) = walls.sections
    x, y = loops[0].T
    area = 0.5 * abs(np.sum(x * np.roll(y, 1) - y * np.roll(x, 1)))
    assert len(loops) == 1 and area == pytest.approx(
        25.0 * 100.0
    )  # 0.5 m by 2 m, 50 pixels a metre
    assert len(drawn(outline(scene, front(100)), "section")) == 1


def test_a_camera_s_cut_takes_away_what_is_nearer_in_vector_too():
    room = boxes([[0.2, -0.5, -0.5], [0.9, 0.5, 0.5]])
    body = spheres_body([0.95, 0, 0], 0.04)
    scene = Scene((body,), room)
    camera = replace(front(200), cut=0.5)
    (loops,) = sections(room, camera, 0.5)
    assert sorted(np.ptp(loops[0], axis=0).tolist()) == pytest.approx([100.0, 100.0])
    lines = surroundings(scene, camera, "veiled").lines
    assert lines.depth.max() <= 0.5 + 2e-3
    assert not sections(room, camera, np.inf)


def test_a_hidden_or_see_through_part_hides_nothing_and_a_camera_inside_a_room_sees_its_walls():
    for kind in ({"hidden": True}, {"see_through": True}):
        assert not len(
            build_occluders(boxes([[0, 0, 0], [1, 1, 1]], **kind), front(), np.inf).planes
        )
    camera = look_at([0, 0, 0], [1, 0, 0], width=100, height=80, field=2.2)
    scene = Scene((), boxes([[-1, -1, -1], [1, 1, 1]]))
    lines = surroundings(scene, camera, "hidden_line").lines
    assert len(lines.ends) and np.all(np.isfinite(lines.ends))


def test_ghosts_are_pale_outlines_under_the_bodies():
    scene = Scene((crowd(),), ghosts=(crowd(2, 5), crowd(3, 5)))
    for display in (outline, circles):
        root = ElementTree.fromstring(display(scene, front(200)))
        names = [item.get("class") for item in root if item.tag == SVG + "g"]
        assert (
            names.index("ghost") < names.index("cover") < names.index("bodies")
            and names.count("ghost") == 2
        )
    assert np.any(
        np.asarray(disks(scene, front(200)))
        != np.asarray(disks(replace(scene, ghosts=()), front(200)))
    )
    assert len(every_pose(scene).bodies) == 3


def test_a_placed_body_outside_the_window_hides_nothing():
    lump = crowd().placed
    unplaced = Placed(lump.body, lump.world_from_segment, lump.centres * np.nan, np.array([False]))
    scene = Scene(
        (replace(crowd(), placed=unplaced),), boxes([[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]])
    )
    assert not surroundings(scene, front(100), "veiled").lines.faint.any()
    assert view_to_pixels(front(100), np.zeros((1, 3)))[0, :2].tolist() == [50.0, 50.0]
