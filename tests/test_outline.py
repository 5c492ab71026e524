"""The line drawing: exactly what shows is drawn, creases are not, and lines hang together."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from tests.test_draw import BOX, SVG, boxes, crowd, front, numbered, spheres_body
from workbench import UsageError, scene_of
from workbench.draw.camera import VIEWS, standard_view
from workbench.draw.lines.arcs import outline_arcs
from workbench.draw.lines.outline import arc_chains, ends_met, outline
from workbench.draw.lines.silhouettes import parallel_rims, silhouette_arcs
from workbench.draw.scene import Mark, Scene
from workbench.draw.views import four_views
from workbench.geometry.box_pairs import box_pairs
from workbench.model.arrays import Bools, Floats, Ints


def arcs_of(
    balls: ArrayLike,
    *,
    segment: tuple[int, ...] = (),
    body: tuple[int, ...] = (),
    step: float = 0.0,
) -> tuple[Floats, Ints]:
    """Arcs of balls x, y, depth, radius; every segment is joined to the next one."""
    given_balls = np.array(balls, dtype=float).reshape(-1, 4)
    count = len(given_balls)
    number = np.array(segment or (0,) * count)
    joined = np.abs(np.subtract.outer(np.arange(9), np.arange(9))) <= 1
    rims = parallel_rims(
        given_balls, number, np.array(body or (0,) * count), joined, np.full(count, float(step))
    )
    return silhouette_arcs(rims)


def drawn_length(balls: ArrayLike, arcs: Floats, keys: Ints, sphere: int) -> float:
    """Length of all arcs of one rim."""
    return float(
        np.diff(arcs[keys[:, 0] == sphere]).sum() * np.asarray(balls, dtype=float)[sphere][3]
    )


def covered(arcs: Floats, keys: Ints, sphere: Ints, angle: Floats) -> Bools:
    """Rim points that an arc of their sphere holds."""
    turned = (angle[:, None] - arcs[None, :, 0]) % math.tau
    return np.any((turned <= arcs[:, 1] - arcs[:, 0]) & (sphere[:, None] == keys[:, 0]), axis=1)


def seen_slowly(balls: Floats, sphere: Ints, angle: Floats) -> tuple[Bools, Floats]:
    """Rim points that no sphere's surface is in front of, and by how much [units] each is hidden or
    clear."""
    x = balls[sphere, 0] + balls[sphere, 3] * np.cos(angle)
    y = balls[sphere, 1] + balls[sphere, 3] * np.sin(angle)
    half = balls[:, 3] ** 2 - (x[:, None] - balls[:, 0]) ** 2 - (y[:, None] - balls[:, 1]) ** 2
    half[np.arange(len(sphere)), sphere] = -1.0
    with np.errstate(invalid="ignore"):
        above = np.where(
            half > 0.0, balls[:, 2] + np.sqrt(half) - balls[sphere, 2][:, None], -np.inf
        ).max(axis=1)
    return above <= 0.0, np.minimum(np.abs(above), np.abs(half).min(axis=1))


def test_two_overlapping_spheres_give_two_arcs_that_meet_where_the_circles_cross() -> None:
    arcs, keys = arcs_of([[-3, 0, 0, 5], [3, 0, 0, 5]])
    ends = np.array([[-3], [3]])[..., None] * [1, 0] + 5 * np.stack(
        [np.cos(arcs), np.sin(arcs)], axis=-1
    )
    assert keys.tolist() == [[0, 1, 1, 1], [1, 0, 0, 1]]
    assert ends == pytest.approx(np.array([[[0, 4], [0, -4]], [[0, -4], [0, 4]]]), abs=1e-12)


def test_a_nearer_sphere_is_drawn_whole_and_cuts_the_farther_one_at_its_own_rim() -> None:
    balls = [[-3, 0, 9, 5], [3, 0, 0, 5]]
    arcs, keys = arcs_of(balls)
    assert drawn_length(balls, arcs, keys, 0) == pytest.approx(10 * math.pi)
    assert drawn_length(balls, arcs, keys, 1) == pytest.approx(10 * (math.pi - math.acos(0.6)))


def test_a_sphere_that_another_hides_gives_nothing() -> None:
    _, keys = arcs_of([[0, 0, 0, 1], [0.5, 0, 8, 2], [0, 0, 0, 1]])
    assert keys[:, 0].tolist() == [1]


def test_of_two_equal_circles_the_nearer_or_the_first_is_drawn() -> None:
    assert arcs_of([[0, 0, 0, 1], [0, 0, 5, 1]])[1][:, 0].tolist() == [1]
    assert arcs_of([[0, 0, 0, 1], [0, 0, 0, 1], [1e-12, 0, 0, 1]])[1][:, 0].tolist() == [0]


def test_the_arcs_of_a_single_sphere_are_its_circumference() -> None:
    arcs = outline_arcs(Scene((spheres_body([0, 0, 0], 0.5),)), front(64))
    assert np.sum(np.diff(arcs.angle)[:, 0] * arcs.disk[:, 2]) == pytest.approx(math.tau * 16.0)


@given(st.integers(0, 2**32 - 1), st.integers(1, 25))
def test_what_is_drawn_is_what_is_in_front_and_nothing_else(seed: int, count: int) -> None:
    random = np.random.default_rng(seed)
    balls = np.column_stack([random.uniform(-3, 3, (count, 3)), random.uniform(0.1, 2.5, count)])
    sphere = random.integers(0, count, 2000)
    angle = random.uniform(0.0, math.tau, 2000)
    seen, margin = seen_slowly(balls, sphere, angle)
    clear = margin > 1e-7
    assert np.array_equal(covered(*arcs_of(balls), sphere, angle)[clear], seen[clear])


@given(st.integers(0, 2**32 - 1), st.integers(1, 25))
def test_outer_arcs_are_those_outside_all_disks(seed: int, count: int) -> None:
    random = np.random.default_rng(seed)
    balls = np.column_stack([random.uniform(-3, 3, (count, 3)), random.uniform(0.1, 2.5, count)])
    sphere = random.integers(0, count, 2000)
    angle = random.uniform(0.0, math.tau, 2000)
    seen, margin = seen_slowly(balls * [1, 1, 0, 1], sphere, angle)
    arcs, keys = arcs_of(balls)
    outer = keys[:, 3] == 1
    clear = margin > 1e-7
    assert np.array_equal(covered(arcs[outer], keys[outer], sphere, angle)[clear], seen[clear])


@pytest.mark.parametrize("view", VIEWS)
def test_the_arcs_of_a_scene_lie_on_the_frontmost_surface(view: str) -> None:
    scene = Scene((crowd(), crowd(3, 20)))
    camera = standard_view(view, BOX, width=80, height=80)
    arcs = outline_arcs(scene, camera, step=0.0, share=0.0)
    spheres = scene.spheres
    angle = arcs.angle.mean(axis=1)[:, None]
    rim = np.cos(angle) * camera.right - np.sin(angle) * camera.up
    points = spheres.centre[arcs.sphere] + spheres.radius[arcs.sphere, None] * rim
    along = (spheres.centre - points[:, None]) @ camera.toward
    off = np.sum((spheres.centre - points[:, None]) ** 2, axis=2) - along**2
    half = np.where(np.arange(len(off.T)) == arcs.sphere[:, None], -1.0, spheres.radius**2 - off)
    assert np.all((half <= 0) | (along + np.sqrt(np.maximum(half, 0)) <= 1e-9))


@pytest.mark.parametrize("segment", [(0, 0), (0, 1)])
def test_a_crease_below_the_step_vanishes_in_a_segment_and_across_a_joint(
    segment: tuple[int, int],
) -> None:
    balls = [[-30, 0, 10, 50], [30, 0, 0, 50]]
    _, keys = arcs_of(balls, segment=segment, step=13)
    assert keys.tolist() == arcs_of([[-30, 0, 0, 50], [30, 0, 0, 50]])[1].tolist()


def test_a_limb_that_stands_out_by_more_keeps_its_whole_outline() -> None:
    balls = [[-30, 0, 70, 50], [30, 0, 0, 50]]
    assert drawn_length(balls, *arcs_of(balls, segment=(0, 1), step=13), 0) == pytest.approx(
        100 * math.pi
    )


@pytest.mark.parametrize(("segment", "body"), [((0, 2), (0, 0)), ((0, 3), (0, 1))])
def test_the_step_does_not_hold_towards_other_limbs_and_other_bodies(
    segment: tuple[int, int], body: tuple[int, int]
) -> None:
    balls = [[-30, 0, 40, 50], [30, 0, 0, 50]]  # hidden within 30 = sqrt(50^2 - 40^2)
    assert drawn_length(
        balls, *arcs_of(balls, segment=segment, body=body, step=13), 0
    ) == pytest.approx(100 * math.pi - 100 * math.acos((60**2 + 50**2 - 30**2) / (2 * 60 * 50)))


def test_an_arm_before_the_chest_fades_into_its_shoulder() -> None:
    chest = [0, 0, 0, 100]
    shoulder = [70, 0, 65, 40]
    arm = [30, 0, 110, 30]
    balls = [chest, shoulder, arm]
    arcs, keys = arcs_of(balls, segment=(0, 1, 2), step=13)
    assert drawn_length(balls, arcs, keys, 0) > 500  # chest
    open_rim = math.acos(
        (40**2 + 30**2 - (40**2 - 32**2)) / (2 * 40 * 30)
    )  # the shoulder is 110 - 13 - 65 = 32 behind
    assert drawn_length(balls, arcs, keys, 2) == pytest.approx(60 * (math.pi - open_rim))


def test_arcs_chain_into_one_closed_path_round_a_row_of_spheres() -> None:
    row = spheres_body([[0, y, 0] for y in (-0.6, -0.3, 0, 0.3, 0.6)], [0.2] * 5)
    path = bodies(outline(Scene((row,)), front(640)))
    assert [item.get("class") for item in path] == ["outer"]
    assert (path[0].get("d") or "").count("M") == (path[0].get("d") or "").count("Z") == 1


def bodies(svg: str) -> list[ElementTree.Element]:
    """The paths of the bodies."""
    group = next(item for item in ElementTree.fromstring(svg) if item.get("class") == "bodies")
    return list(group)


def test_every_point_of_the_path_is_on_a_sphere_of_the_arc_s_radius() -> None:
    scene = Scene((crowd(5, 30),))
    flat = np.array([[32 + 32 * c[1], 32 - 32 * c[2]] for c in scene.spheres.centre]) * 10
    text = "".join(item.get("d") or "" for item in bodies(outline(scene, front(640))))
    for radius, x, y in re.findall(r"A(\S+) \S+ 0 0 1 (\S+) ([-\d.]+)", text):
        like = np.abs(scene.spheres.radius * 320 - float(radius)) <= 0.051
        assert (
            np.min(
                np.abs(
                    np.hypot(*(flat[like] - [float(x), float(y)]).T)
                    - scene.spheres.radius[like] * 320
                )
            )
            < 0.35
        )


def test_each_of_very_many_pairs_of_spheres_has_the_arcs_of_a_pair_alone() -> None:
    pair = np.array([[-3.0, 0, 0, 5], [3, 0, 0, 5]])
    count = 2400  # 4,800 spheres: more than are sought at a time
    row = 16.0 * np.arange(count)
    balls = np.tile(pair, (count, 1)) + np.repeat(row, 2)[:, None] * [1, 0, 0, 0]
    arcs, keys = arcs_of(balls)
    alone, alone_keys = arcs_of(pair)
    first = 2 * np.repeat(np.arange(count), 2)[:, None]
    assert np.array_equal(keys, np.tile(alone_keys, (count, 1)) + first * [1, 1, 1, 0])
    assert arcs == pytest.approx(np.tile(alone, (count, 1)), abs=1e-9)


def test_boxes_that_meet_or_touch_are_found_once() -> None:
    one = np.array([[0, 0, 2, 2], [-np.inf, 1, np.inf, 1], [5, 5, 5, 5]])
    other = np.array([[2, 2, 3, 3], [-4, 0.5, -3, 1.5], [4, 4, 6, 6], [0, 3, 2, 4]])
    assert sorted(zip(*map(np.ndarray.tolist, box_pairs(one, other)), strict=True)) == [
        (0, 0),
        (1, 1),
        (2, 2),
    ]


@given(st.integers(0, 2**32 - 1), st.integers(0, 12), st.integers(0, 12))
def test_pairs_of_boxes_are_those_of_a_plain_comparison(seed: int, m: int, n: int) -> None:
    random = np.random.default_rng(seed)
    low = random.integers(0, 9, (m + n, 2))
    boxes = np.column_stack([low, low + random.integers(0, 4, (m + n, 2))]).astype(float)
    one = boxes[:m, None]
    other = boxes[m:]
    meets = np.all((one[..., :2] <= other[:, 2:]) & (other[:, :2] <= one[..., 2:]), axis=-1)
    i, j = box_pairs(boxes[:m], other)
    order = np.lexsort((j, i))
    assert np.array_equal(np.column_stack([i, j])[order], np.argwhere(meets))


def test_a_small_sphere_far_away_is_drawn_and_a_speck_on_a_body_is_not() -> None:
    lone = [0, 0.9, 0.9]
    speck = [0.57, 0, 0]
    path = bodies(
        outline(Scene((spheres_body([[0, 0, 0], lone, speck], [0.5, 0.01, 0.01]),)), front(200))
    )
    assert [item.get("class") for item in path] == ["outer"]
    assert (path[0].get("d") or "").count("M") == 2


def test_what_is_behind_a_polygon_is_drawn_as_a_pale_line() -> None:
    body = spheres_body([[0, 0, 0], [0.9, 0.8, 0.8]], [0.5, 0.1])
    wall = boxes([[0.6, -1, -1], [0.62, 1, 0]])
    scene = Scene((body,), wall)
    length = {item.get("class"): ys(item) for item in bodies(outline(scene, front(200)))}
    assert set(length) == {"veiled", "outer"}
    assert length["veiled"].min() >= 98.0 and length["outer"].max() <= 102.0


def ys(item: ElementTree.Element) -> Floats:
    """The y of every point of a path."""
    return np.array(
        [float(y) for y in re.findall(r"(?:M|0 0 1 )\S+ ([-\d.]+)", item.get("d") or "")]
    )


def test_a_see_through_or_hidden_part_hides_no_line() -> None:
    body = spheres_body([[0, 0, 0], [0.9, 0.8, 0.8]], [0.5, 0.1])
    bare = [item.get("d") for item in bodies(outline(Scene((body,)), front(200)))]
    for kind in ({"hidden": True}, {"see_through": True}):
        wall = boxes([[0.6, -1, -1], [0.62, 1, 0]], **kind)  # type: ignore[arg-type]
        assert [item.get("d") for item in bodies(outline(Scene((body,), wall), front(200)))] == bare


def test_the_same_scene_gives_the_same_bytes_and_names_are_text() -> None:
    scene = Scene(
        (crowd(),),
        boxes([[-1, -1, -1], [1, 1, -0.8]]),
        (*numbered([[0, 0, 0]]), Mark((0, 0, 0), "<b>&")),
    )
    text = outline(replace(scene, title="<script>", description='"&<'), front(200))
    assert text == outline(replace(scene, title="<script>", description='"&<'), front(200))
    root = ElementTree.fromstring(text)
    assert root.findtext(SVG + "title") == "<script>" and root.findtext(SVG + "desc") == '"&<'
    assert "<b>&" in [item.text for item in root.iter(SVG + "text")]


@pytest.mark.parametrize(
    "scene", [Scene(), Scene((), boxes([[-1, -1, -1], [1, 1, 1]])), Scene((crowd(),))]
)
def test_an_empty_page_a_bare_room_and_a_view_that_misses_are_pictures(scene: Scene) -> None:
    away = standard_view("front", BOX + 50.0, width=40, height=40)
    for camera in (front(), away):
        assert ElementTree.fromstring(outline(scene, camera)).get("viewBox")


def test_a_standing_body_is_one_outer_line_and_few_bytes() -> None:
    scene = scene_of("bubbleman")
    text = outline(scene, dict(four_views(scene, width=800, height=800))["front"])
    outer = next(item.get("d") or "" for item in bodies(text) if item.get("class") == "outer")
    assert len(text) < 30_000
    assert outer.count("M") == outer.count("Z") == 1 and outer.count("A") > 200


def test_chains_are_followed_from_their_beginnings_and_rings_closed() -> None:
    order, start = arc_chains(np.array([2, 0, -1, 4, 3]))
    assert order.tolist() == [1, 0, 2, 3, 4]
    assert start.tolist() == [0, 3]


def test_an_end_meets_another_chain_s_arc_only_along_its_angle() -> None:
    points = np.array([[5.0, 0.0], [-5.0, 0.0], [5.4, 0.0], [5.6, 0.0]])
    disk = np.array([[0.0, 0.0, 5.0, 1.0, 0.0]])
    met = ends_met(
        points,
        np.zeros(4, dtype=np.int64),
        disk,
        np.array([[-1.0, 1.0]]),
        np.array([1]),
        np.array([True, False]),
        0.5,
    )
    assert met[:, 0].tolist() == [True, False, True, False] and not met[:, 1].any()


def test_more_spheres_than_anyone_can_draw_as_lines_are_refused():
    body = crowd()
    many = Scene(tuple(body for _ in range(50_001 // len(body.placed.body.sphere_names) + 1)))
    with pytest.raises(
        UsageError, match=r"outline: .* spheres; 50000 at most, or draw them as disks"
    ):
        outline(many, front())
