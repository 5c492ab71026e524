"""Views by rules: the cockpit's outline and the forward field, against hand-made scenes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.conftest import environment_of
from workbench import InputError
from workbench.files.meshes.parts import RawPart
from workbench.files.study.rules import load_rule_set
from workbench.sight.eyes import given_eyes
from workbench.sight.obscuration import obscuration
from workbench.sight.regions import WHOLE, solid_angle_of_triangles
from workbench.sight.rules.cockpit_view import cockpit_outline, cockpit_view
from workbench.sight.rules.eye_points import car_eye_points
from workbench.sight.rules.forward_field import (
    datum_points,
    forward_field,
    masked_length,
    wheel_fall,
)
from workbench.sight.scenery import Scenery

R125 = load_rule_set("sight_un_r125")
AC25 = load_rule_set("sight_ac_25_773_1")
LEFT = cockpit_outline(AC25, seat="left")
RIGHT = cockpit_outline(AC25, seat="right")
ZERO = np.zeros(3)


def way(degrees_right, degrees_up):
    """The direction (3,) at angles to the right and up."""
    azimuth, elevation = np.radians([-degrees_right, degrees_up])
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])


def sheet(corner, one, two):
    """Two triangles (2, 3, 3) of a parallelogram."""
    a, u, v = (np.array(values, dtype=float) for values in (corner, one, two))
    return np.array([[a, a + u, a + u + v], [a, a + u + v, a + v]])


def scenery(parts=None, balls=(), *, glass=()):
    """Scenery of named triangles (T, 3, 3) and of spheres (name, centre, radius)."""
    parts = parts or {}
    names = (*parts, *(name for name, _, _ in balls))
    count = len(names)
    return Scenery(
        names=names,
        triangles=np.concatenate([np.zeros((0, 3, 3)), *parts.values()]),
        item=np.repeat(np.arange(len(parts)), [len(t) for t in parts.values()]),
        see_through=np.array([name in glass for name in names], dtype=bool),
        solid=np.zeros(count, dtype=bool),
        centre=np.array([centre for _, centre, _ in balls], dtype=float).reshape(1, -1, 3),
        radius=np.array([radius for _, _, radius in balls], dtype=float).reshape(1, -1),
        sphere_item=np.arange(len(parts), count),
        moving=np.zeros(count, dtype=bool),
        displacement=np.zeros((1, 3)),
    )


def view(scene, region=LEFT, eyes=None, step=0.5):
    return cockpit_view(
        scene, given_eyes(ZERO) if eyes is None else eyes, region, step=np.radians(step)
    )


def test_outline_has_its_solid_angle_and_corners():
    for region in (LEFT, RIGHT):
        assert region.solid_angle == pytest.approx(1.9945, abs=5e-5)
        assert region.solid_angle / (4 * np.pi) == pytest.approx(0.1587, abs=5e-5)
    for right, up in [(0, -16.9), (-60, -24), (-100, 20)]:
        assert LEFT.contains(way(right, up)) and RIGHT.contains(way(-right, up))
    for right, up in [(0, -17.1), (15, -14), (-120, 16), (21, 0)]:
        assert not LEFT.contains(way(right, up)) and not RIGHT.contains(way(-right, up))
    assert "seen in the source text of OpenVSP" in AC25.status("outline_left_seat")


@pytest.mark.parametrize(
    ("right", "low"),
    [(20, -10), (15, -13.5), (0, -17), (-30, -17), (-50, -22), (-95, -27), (-110, -19.8)],
)
def test_lower_limits_of_the_outline(right, low):
    for region, sign in ((LEFT, 1), (RIGHT, -1)):
        inside, outside = (way(sign * (right - 1e-4), low + by) for by in (1e-3, -1e-3))
        assert region.contains(inside) and not region.contains(outside)


@pytest.mark.parametrize(
    ("right", "high"), [(20, 15), (0, 21.667), (-20, 28.333), (-40, 35), (-80, 35), (-100, 25)]
)
def test_upper_limits_of_the_outline(right, high):
    inside, outside = (way(right - 1e-4, high + by) for by in (-2e-3, 2e-3))
    assert LEFT.contains(inside) and not LEFT.contains(outside)


def test_a_cone_is_no_outline():
    with pytest.raises(InputError, match="all directions: an outline of azimuths"):
        view(scenery(), WHOLE)


def test_an_empty_sky_is_clear():
    found = view(scenery())
    assert (found.clear, found.hidden, found.hole, found.posts) == (1.0, {}, None, ())
    assert np.degrees(found.over_nose) == pytest.approx(90)


def test_a_coaming_and_a_post_by_hand():
    """A coaming whose edge is 200 mm under the eyes, 1 m ahead: atan 0.2 down. A post of 100 mm,
    1 m ahead, is hidden to both eyes over 2 atan((50 - 32.5) / 1000)."""
    coaming = sheet((1, -3, -0.2), (0, 6, 0), (0, 0, -2))
    post = sheet((1, -0.05, -0.1), (0, 0.1, 0), (0, 0, 3))
    found = view(scenery({"coaming": coaming, "post": post + np.array([0, 0.4, 0])}))
    assert np.degrees(found.over_nose) == pytest.approx(np.degrees(np.arctan(0.2)), abs=1e-3)
    (strip,) = found.posts
    edges = np.degrees(np.arctan([0.4 - 0.0175, 0.4 + 0.0175]))
    assert np.degrees(strip.size) == pytest.approx(edges[1] - edges[0], abs=1e-3)
    assert np.degrees(strip.azimuth) == pytest.approx(edges.mean(), abs=1e-3)
    assert strip.name == "post"
    assert set(found.hidden) == {"coaming", "post"}
    alone = view(scenery({"post": post[:, :, [0, 1, 2]] * [1, 0.6, 1]}))  # 60 mm: under 65
    assert (alone.clear, alone.posts) == (1.0, ())


def test_a_nose_over_the_horizon_is_a_negative_angle_and_a_wall_is_none():
    high = sheet((1, -3, 0.1), (0, 6, 0), (0, 0, -2))
    assert np.degrees(view(scenery({"nose": high})).over_nose) == pytest.approx(
        -np.degrees(np.arctan(0.1)), abs=1e-3
    )
    wall = sheet((0.3, -9, -9), (0, 18, 0), (0, 0, 18))
    over = sheet((-9, -9, 8.9), (18, 0, 0), (0, 18, 0))
    assert view(scenery({"wall": wall, "roof": over})).over_nose is None


def test_the_widest_hole_of_a_ball_is_its_cone():
    ball = scenery(balls=[("ball", tuple(way(-60, 5)), 0.1)])
    found = view(ball, eyes=given_eyes(ZERO, spacing=0.0), step=0.25)
    assert np.degrees(found.hole.size) == pytest.approx(2 * np.degrees(np.arcsin(0.1)), abs=0.5)
    assert np.degrees([found.hole.azimuth, found.hole.elevation]) == pytest.approx([60, 5], abs=0.5)
    assert found.hole.name == "ball"
    cone = 2 * np.pi * (1 - np.sqrt(1 - 0.01))
    assert found.hidden["ball"] == pytest.approx(cone, rel=0.02)


CLUTTER = {
    "coaming": sheet((0.8, -1, -0.15), (0, 2, 0), (0.1, 0, -0.6)),
    "left post": sheet((0.6, 0.35, -0.3), (0.03, 0.09, 0), (-0.2, 0.05, 0.9)),
    "mast": sheet((0.9, 0.1, -0.3), (0, 0.09, 0), (0, 0, 0.8)),
    "door": sheet((0.3, 0.6, -0.9), (-0.9, 0.1, 0), (0, 0, 0.8)),
    "window": sheet((0.3, 0.5, -0.9), (-0.9, 0.1, 0), (0, 0, 1.8)),
}
BALLS = [("own knee", (0.5, 0.1, -0.25), 0.08), ("co-pilot", (0.1, -0.6, 0.0), 0.12)]


def test_clear_and_hidden_add_up_and_agree_with_the_obscuration_of_the_region():
    scene = scenery(CLUTTER, BALLS, glass=("window",))
    found = view(scene, step=0.25)
    total = sum(found.hidden.values()) / LEFT.solid_angle
    assert found.clear + total == pytest.approx(1.0, abs=1e-9)
    assert "window" not in found.hidden
    other = obscuration(scene, given_eyes(ZERO), within=LEFT, step=np.radians(0.2))
    assert found.clear * LEFT.solid_angle == pytest.approx(other.free[2], abs=0.01)


def test_rays_at_random_find_the_same_clear_share():
    """Directions drawn evenly over the sphere, each cast at the triangles and balls one by one."""
    rng = np.random.default_rng(5)
    ways = rng.standard_normal((60_000, 3))
    ways = ways[LEFT.contains(ways)]
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    hidden = np.ones(len(ways), dtype=bool)
    for eye in ([0, 0.0325, 0], [0, -0.0325, 0]):
        met = np.zeros(len(ways), dtype=bool)
        for name, corners in CLUTTER.items():
            for a, b, c in corners - eye if name != "window" else ():
                share = np.linalg.solve(np.stack([a, b, c], axis=1), ways.T)
                met |= np.all(share >= 0, axis=0)
        for _, centre, radius in BALLS:
            along = ways @ (np.array(centre) - eye)
            away = np.linalg.norm(np.array(centre) - eye - along[:, None] * ways, axis=1)
            met |= (along > 0) & (away < radius)
        hidden &= met
    found = view(scenery(CLUTTER, BALLS, glass=("window",)), step=0.25)
    assert found.clear == pytest.approx(1 - hidden.mean(), abs=0.015)


def test_a_mirrored_cockpit_gives_the_right_seat_the_same_numbers():
    mirror = np.array([1, -1, 1])
    parts = {name: corners * mirror for name, corners in CLUTTER.items()}
    balls = [(name, tuple(centre * mirror), radius) for name, centre, radius in BALLS]
    one = view(scenery(CLUTTER, BALLS))
    two = view(scenery(parts, balls), RIGHT)
    assert two.clear == pytest.approx(one.clear, abs=2e-3)
    assert [post.name for post in two.posts] == [post.name for post in one.posts[::-1]]
    assert two.over_nose == pytest.approx(one.over_nose, abs=1e-5)
    assert [post.size for post in two.posts] == pytest.approx(
        [post.size for post in one.posts[::-1]], abs=1e-5
    )
    assert two.hole.size == pytest.approx(one.hole.size, abs=np.radians(0.8))


@settings(max_examples=15)
@given(st.floats(-1.2, 1.2), st.floats(0.07, 0.4), st.floats(0.4, 1.5))
def test_a_second_eye_never_hides_more(y, width, distance):
    post = sheet((distance, y, -1), (0, width, 0), (0, 0, 2))
    scene = scenery({"post": post})
    both = view(scene, step=2.0)
    one = view(scene, eyes=given_eyes((0, 0.0325, 0), spacing=0.0), step=2.0)
    assert both.clear >= one.clear - 1e-9


V = car_eye_points((0.068, -0.005, -0.589), np.radians(25), R125)
"""V2 is the origin here, V1 is 76 mm above it."""


def cab(**parts):
    """An environment of named triangles (T, 3, 3) [m]."""
    raw = [
        RawPart(name, corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
        for name, corners in parts.items()
    ]
    return environment_of(*raw, solid=False)


def test_v2_is_the_origin():
    assert V["v2"] == pytest.approx(ZERO, abs=1e-12)
    assert V["v1"] == pytest.approx([0, 0, 0.076])


def test_a_post_in_the_forward_field_covers_its_angle_and_an_exempt_one_nothing():
    post = sheet((1, -0.2, -1), (0, 0.1, 0), (0, 0, 3))
    found = forward_field(cab(post=post, bar=post + np.array([0, 0.5, 0])), V, R125, exempt=["bar"])
    assert list(found.blocked) == ["post"]
    one = found.blocked["post"]
    edges = np.arctan([-0.1, -0.2])
    assert [one.left, one.right] == pytest.approx(edges)
    assert one.width == found.width == pytest.approx(edges[0] - edges[1])
    assert one.top == pytest.approx(np.arctan(0.076 / np.hypot(1, 0.1)))
    assert "field_fall: from memory" in found.status


@pytest.mark.parametrize(
    ("ahead", "aside", "fall", "stands"),
    [
        (2.0, 0.0, 3.9, True),
        (2.0, 0.0, 4.1, False),
        (0.01, 2.0, 3.9, True),
        (0.01, -2.0, 3.9, True),
        (0.01, 2.0, 4.1, False),
        (1.5, 1.5, 3.9, True),  # from the corner the planes fall 4 degrees along x and along y
        (1.5, -1.5, 4.1, False),
    ],
)
def test_planes_fall_4_degrees_ahead_and_to_both_sides(ahead, aside, fall, stands):
    top = -np.tan(np.radians(fall)) * max(ahead, abs(aside))
    tip = sheet((ahead, aside - 1e-3, top), (0, 2e-3, 0), (0, 0, -0.2))
    found = forward_field(cab(tip=tip + np.array([0, 0, 1e-4])), V, R125)
    assert ("tip" in found.blocked) == stands


def test_what_is_above_v1_behind_v2_or_seen_through_does_not_count():
    high = sheet((1, -1, 0.0761), (0, 2, 0), (0, 0, 1))
    behind = sheet((-0.01, -1, -1), (0, 2, 0), (0, 0, 3))
    assert forward_field(cab(roof=high, rest=behind), V, R125).blocked == {}
    both = sheet((-1, 0.5, -1), (2, 0, 0), (0, 0, 3))
    width = forward_field(cab(door=both), V, R125).blocked["door"].width
    assert width == pytest.approx(np.pi / 2 - np.arctan(0.5))


@settings(max_examples=25)
@given(st.lists(st.floats(-1, 1), min_size=9, max_size=9))
def test_points_of_a_triangle_tried_one_by_one_find_it_in_the_field_too(numbers):
    corners = np.array(numbers).reshape(1, 3, 3) * [1, 2, 0.3] + [1.2, 0, -0.05]
    assume(abs(solid_angle_of_triangles(corners, V["v2"])[0]) > 1e-3)
    u = np.linspace(0, 1, 201)
    one, two = (axis.ravel() for axis in np.meshgrid(u, u))
    inside = one + two <= 1
    a, b, c = corners[0]
    x, y, z = (a + one[inside, None] * (b - a) + two[inside, None] * (c - a)).T
    lower = -np.tan(np.radians(4)) * np.maximum(x, np.abs(y))
    within = (x > 0) & (z < 0.076) & (z > lower)
    found = forward_field(cab(part=corners), V, R125).blocked.get("part")
    if found is None:
        assert within.mean() < 1e-3
    elif within.mean() > 1e-2:
        azimuth = np.arctan2(y, x)[within]
        assert [found.left, found.right] == pytest.approx([azimuth.max(), azimuth.min()], abs=0.2)
        assert found.left >= azimuth.max() - 1e-9 and found.right <= azimuth.min() + 1e-9


def test_two_parts_behind_one_another_cover_their_azimuths_once():
    near = sheet((1, 0.0, -1), (0, 0.3, 0), (0, 0, 3))
    far = sheet((2, 0.2, -1), (0, 0.8, 0), (0, 0, 3))
    found = forward_field(cab(near=near, far=far), V, R125)
    assert found.width == pytest.approx(np.arctan(0.5))  # 0 to 0.3, and 0.1 to 0.5
    total = sum(one.width for one in found.blocked.values())
    assert total == pytest.approx(np.arctan(0.3) + np.arctan(0.5) - np.arctan(0.1))


@pytest.mark.parametrize(("drop", "allowed"), [(0.011, True), (0.007, False)])
def test_wheel_and_panel_inside_it_are_exempt_where_the_plane_over_it_falls_a_degree(drop, allowed):
    wheel = sheet((0.5, -0.2, -drop), (0, 0.4, 0), (0, 0, -0.3))
    panel = sheet((0.8, -0.1, -0.03), (0, 0.2, 0), (0, 0, -0.3))
    room = cab(wheel=wheel, panel=panel)
    found = forward_field(room, V, R125, wheel=["wheel"], inside_wheel=["panel"])
    assert found.wheel_fall == pytest.approx(np.arctan(drop / 0.5))
    assert found.wheel_allowed is allowed
    assert set(found.blocked) == (set() if allowed else {"wheel", "panel"})
    assert found.wheel_fall == wheel_fall(room, V, ["wheel"])


@settings(max_examples=15)
@given(st.floats(0.2, 2), st.floats(-1.5, 1.5), st.floats(-0.1, 0.05), st.floats(0.02, 0.4))
def test_the_forward_field_of_a_mirrored_car_is_mirrored(x, y, z, width):
    part = sheet((x, y, z), (0.1, width, 0.02), (0, 0.1, -0.3))
    other = car_eye_points((0.068, 0.005, -0.589), np.radians(25), R125, driver="right")
    one = forward_field(cab(part=part), V, R125).blocked.get("part")
    two = forward_field(cab(part=part * [1, -1, 1]), other, R125).blocked.get("part")
    assert (one is None) == (two is None)
    if one is not None:
        assert [two.width, -two.right, -two.left, two.top] == pytest.approx(
            [one.width, one.left, one.right, one.top]
        )


def test_datum_points_are_on_the_windscreen_or_none():
    screen = sheet((1, -1, -0.5), (0, 2, 0), (0, 0, 0.65))
    found = datum_points(cab(screen=screen), V, R125, ["screen"])
    assert found["from V1, left"] == pytest.approx([1, np.tan(np.radians(17)), 0.076])
    assert found["from V1, up"] is None  # 76 mm + 123 mm is over the edge at 150 mm
    assert found["from V2, down"] == pytest.approx([1, 0, -np.tan(np.radians(5))])


def test_names_that_are_no_part_and_a_wheel_behind_are_refused():
    room = cab(wheel=sheet((-0.5, 0, 0), (0, 0.1, 0), (0, 0, 0.1)))
    with pytest.raises(InputError, match="no part 'pillars'"):
        forward_field(room, V, R125, exempt=["pillars"])
    with pytest.raises(InputError, match="nothing of wheel is ahead of V2"):
        forward_field(room, V, R125, wheel=["wheel"])


def test_a_part_of_a_tractor_hides_its_length_on_the_half_circle():
    tractor = load_rule_set("sight_tractor")
    assert 1e3 * masked_length(0.100, 0.700, tractor) == pytest.approx(665.0)
    assert 1e3 * masked_length(0.065, 0.700, tractor) == pytest.approx(65.0)
    assert tractor.number("combined_most") == pytest.approx(0.7)
    assert "masked_length: from memory" in tractor.status("masked_length")
