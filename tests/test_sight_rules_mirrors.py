"""Mirrors and reflections: worked vectors (mirror_plane, mirror_convex of a fact sheet on sight), laws
of reflection, and rays traced outward from the eye."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.conftest import box_part, environment_of
from tests.test_sight_rules_view import scenery, sheet
from workbench import InputError
from workbench.files.meshes.parts import RawPart
from workbench.files.study.rules import load_rule_set
from workbench.model.environment import Mirror
from workbench.model.rule_set import RuleSet, RuleValue
from workbench.sight.eyes import given_eyes
from workbench.sight.obscuration import Target
from workbench.sight.regions import WHOLE, cone
from workbench.sight.rules.cockpit_view import cockpit_outline
from workbench.sight.rules.mirrors import (
    AWAY,
    OUTSIDE,
    Glass,
    aimed_normal,
    glass_of,
    ground_points,
    mirror_field,
    reflected,
    reflections,
    required_ground,
    windscreen_reflection,
)
from workbench.sight.scenery import scenery_of

AC25 = load_rule_set("sight_ac_25_773_1")
R46 = load_rule_set("sight_un_r46")
F111 = load_rule_set("sight_fmvss_111")
ZERO = np.zeros(3)
AT = np.array([0.45, 0.75, -0.10])
REAR = np.array([-1.0, 0.0, 0.0])


def test_flat_mirror_that_shows_straight_behind_by_hand():
    normal = aimed_normal(ZERO, AT, REAR)
    assert normal == pytest.approx([-0.869243, -0.490049, 0.065340], abs=5e-7)
    assert reflected(ZERO, AT, normal) == pytest.approx([1.330341, 0.75, -0.10], abs=5e-7)


def square(at, normal, half, radius=np.inf):
    """A square glass, turned somehow about its normal."""
    side = np.cross([0.1, 0.2, 1.0], normal)
    side /= np.linalg.norm(side)
    up = np.cross(normal, side)
    corner = at - half * side - half * up
    return Glass("mirror", at, normal, radius, sheet(corner, 2 * half * side, 2 * half * up))


def test_convex_mirror_near_its_axis_by_hand():
    """1 / image = 1 / 20 + 2 / 1.2: 582.52 mm behind the glass; against a flat mirror things look
    0.58252 / 20 x 20.7 / (0.7 + 0.58252) = 0.4701 as large."""
    eye, points = np.array([0, 0, 0.7]), np.array([[1e-3, 0, 20.0]])
    flat, bent = (
        reflections(square(ZERO, np.array([0, 0, 1.0]), 5.0, radius), eye, points)[0, 0]
        for radius in (np.inf, 1.2)
    )
    assert bent / flat == pytest.approx(0.4701, abs=5e-5)


CAR = np.array([[-2.5, -0.9, -1.1], [1.5, 0.62, 0.3]])
"""The bounds of a car whose driver is near its left side."""


def ground_of(name, *, rules=R46, side="left", mirror=1):
    bounds = CAR if mirror == 1 else np.sort(CAR * [1, -1, 1], axis=0)
    return required_ground(rules, name, eye=ZERO, bounds=bounds, ground=-1.1, side=side)


VECTORS = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array)


@given(VECTORS, VECTORS, st.floats(0.3, 3.0))
def test_a_place_of_reflection_has_equal_angles_and_one_plane(eye, point, radius):
    glass = square(ZERO, np.array([0, 0, 1.0]), 10.0, radius)
    eye = eye * [1, 1, 0] + [0, 0, 0.5 + abs(eye[2])]
    point = 5 * point * [1, 1, 0] + [0, 0, 0.5 + 5 * abs(point[2])]
    (place,) = reflections(glass, eye, point[None])
    out = place - [0, 0, -radius]
    assert np.linalg.norm(out) == pytest.approx(radius)
    way, back = (v - place for v in (eye, point))
    way, back, out = (v / np.linalg.norm(v) for v in (way, back, out))
    assert way @ out == pytest.approx(back @ out, abs=1e-9)
    assert np.cross(way, back) @ out == pytest.approx(0.0, abs=1e-9)


@given(VECTORS, VECTORS)
def test_a_convex_mirror_of_a_huge_radius_is_flat(eye, point):
    eye = eye * [1, 1, 0] + [0, 0, 0.5]
    point = point * [1, 1, 0] + [0, 0, 2.0]
    normal = np.array([0, 0, 1.0])
    flat, bent = (
        reflections(square(ZERO, normal, 5.0, radius), eye, point[None])[0]
        for radius in (np.inf, 1e7)
    )
    assert bent == pytest.approx(flat, abs=1e-5)


def test_a_convex_mirror_near_its_axis_shows_things_as_large_as_the_lens_formula_says():
    glass = square(ZERO, np.array([1.0, 0, 0]), 0.1, 1.2)
    (place,) = reflections(glass, np.array([0.7, 0, 0]), np.array([[20.0, 0.01, 0]]))
    flat = 0.01 / 20.7
    assert np.arctan(place[1] / 0.7) / flat == pytest.approx(0.4701, abs=1e-4)


def test_what_is_behind_a_mirror_or_reflected_beside_it_is_not_shown():
    for radius in (np.inf, 1.2):
        glass = square(ZERO, np.array([1.0, 0, 0]), 0.1, radius)
        eye = np.array([1.0, 0.0, 0.0])
        shown = np.array([[2.0, 0.1, 0], [-1.0, 0, 0], [1.0, 5.0, 0]])
        assert np.isfinite(reflections(glass, eye, shown)[:, 0]).tolist() == [True, False, False]
        with pytest.raises(InputError, match="mirror faces away from the eyes"):
            reflections(glass, -eye, shown)


def traced(glass, eye, height, obstacles, count=80):
    """Rays from an eye by way of a square glass, and of what is around it, to level ground: where
    they come down (M, 3) [m], whether by the glass, and which obstacle (T, 3, 3) each meets, -1."""
    a, b, d = glass.corners[0, 0], glass.corners[0, 1], glass.corners[1, 2]
    u = 2 * (np.arange(count) + 0.5) / count - 0.5  # half of them miss the glass on each side
    v, w = (axis.ravel() for axis in np.meshgrid(u, u))
    spots = a + v[:, None] * (b - a) + w[:, None] * (d - a)
    inside = (v > 0) & (v < 1) & (w > 0) & (w < 1)
    normal = np.broadcast_to(glass.normal, spots.shape)
    if np.isfinite(glass.radius):  # onto the sphere along the mirror's normal
        centre = glass.at - glass.radius * glass.normal
        flat = spots - centre - ((spots - centre) @ glass.normal)[:, None] * glass.normal
        depth = np.sqrt(glass.radius**2 - np.sum(flat**2, axis=1))
        spots = centre + flat + depth[:, None] * glass.normal
        normal = (spots - centre) / glass.radius
    way = spots - eye
    on = way - 2 * np.sum(way * normal, axis=1)[:, None] * normal
    falls = on[:, 2] < 0
    spots, on, inside = spots[falls], on[falls], inside[falls]
    ground = spots + on * ((height - spots[:, 2]) / on[:, 2])[:, None]
    met = np.full(len(spots), -1)
    for start, end in ((spots, ground), (np.broadcast_to(eye, spots.shape), spots)):
        for k, (p, q, r) in enumerate(obstacles):
            across = np.cross(q - p, r - p)
            share = (p - start) @ across / np.sum((end - start) * across, axis=1)
            hit = start + share[:, None] * (end - start)
            sides = [np.cross(n - m, hit - m) @ across for m, n in ((p, q), (q, r), (r, p))]
            met[(share > 0) & (share < 1) & np.all(np.array(sides) >= 0, axis=0)] = k
    return ground, inside, met


@pytest.mark.parametrize("radius", [np.inf, 1.4])
@pytest.mark.parametrize("spot", [(0.0, 0.0325, 0.0), (-0.05, -0.1, 0.06)])
def test_the_ground_seen_in_a_mirror_is_what_rays_outward_from_the_eye_meet(radius, spot):
    glass = square(AT, aimed_normal(ZERO, AT, np.array([-1.0, 0.02, -0.12])), 0.09, radius)
    body = sheet((-2.0, 0.8, -1.1), (0, 0.5, 0), (0, 0, 0.6))
    post = sheet((0.3, 0.47, -0.5), (0.02, 0.03, 0), (0, 0, 0.8))
    ground, inside, met = traced(glass, np.array(spot), -1.1, np.concatenate([body, post]))
    kinds = np.where(inside, np.where(met < 0, "seen", np.where(met < 2, "body", "post")), OUTSIDE)
    assert set(kinds) == {"seen", "body", "post", OUTSIDE}
    scene = scenery({"body": body, "post": post})
    eyes = given_eyes(spot, spacing=0.0)
    for kind in sorted(set(kinds)):
        found = mirror_field(scene, eyes, glass, ground[kinds == kind])
        told = {"seen": found.share, **found.hidden}
        assert told[kind] == pytest.approx(1.0, abs=1e-9)


def test_two_eyes_see_the_union_and_every_lost_point_has_its_reason():
    glass = square(AT, aimed_normal(ZERO, AT, np.array([-1.0, 0.02, -0.12])), 0.09, 1.4)
    post = sheet((0.3, 0.47, -0.5), (0.02, 0.03, 0), (0, 0, 0.8))
    ground = ground_points(ground_of("field_IV"))
    found = mirror_field(scenery({"post": post}), given_eyes(ZERO), glass, ground)
    for eye, seen in zip(((0, 0.0325, 0), (0, -0.0325, 0)), found.seen, strict=True):
        one = mirror_field(scenery({"post": post}), given_eyes(eye, spacing=0.0), glass, ground)
        assert one.seen.tolist() == [seen.tolist()] * 2
    assert found.share == found.seen.any(axis=0).mean() > found.seen.mean(axis=1).max()
    assert found.share + sum(found.hidden.values()) == pytest.approx(1.0)


def test_a_blocked_mirror_names_what_hides_and_its_own_part_hides_nothing():
    glass = square(AT, aimed_normal(ZERO, AT, REAR), 0.1)
    back = glass.corners + 1e-3 * glass.normal  # a cover of the mirror's own part
    screen = sheet((0.3, 0.3, -0.5), (0, 0.6, 0), (0, 0, 0.8))
    ground = np.array([[-20.0, 0.8, -1.1]])
    scene = scenery({"housing": back})
    assert mirror_field(scene, given_eyes(ZERO), glass, ground).hidden == {"housing": 1.0}
    assert mirror_field(scene, given_eyes(ZERO), glass, ground, item=0).share == 1.0
    hidden = mirror_field(scenery({"screen": screen}), given_eyes(ZERO), glass, ground)
    assert (hidden.share, hidden.hidden) == (0.0, {"screen": 1.0})
    aside = mirror_field(scenery(), given_eyes(ZERO), glass, ground + np.array([0, 30.0, 0]))
    assert aside.hidden == {OUTSIDE: 1.0}


def test_an_eye_behind_a_mirror_is_told_that_it_faces_away():
    glass = square(AT, aimed_normal(ZERO, AT, REAR), 0.1)
    turned = Glass("mirror", AT, -glass.normal, np.inf, glass.corners)
    ground = np.array([[-20.0, 0.8, -1.1]])
    found = mirror_field(scenery(), given_eyes(ZERO), turned, ground)
    assert (found.share, found.hidden) == (0.0, {AWAY: 1.0})
    edge = Glass("mirror", ZERO, np.array([0, 1.0, 0]), np.inf, glass.corners)
    assert mirror_field(scenery(), given_eyes(ZERO), edge, ground).hidden == {
        AWAY: 0.5,
        OUTSIDE: 0.5,
    }


@settings(max_examples=15)
@given(st.floats(0.2, 0.8), st.floats(0.4, 1.0), st.floats(-0.3, 0.1), st.floats(0.8, 2.0))
def test_a_mirrored_mirror_shows_the_mirrored_ground(x, y, z, radius):
    turn = np.array([1, -1, 1])
    at = np.array([x, y, z])
    glass = square(at, aimed_normal(ZERO, at, np.array([-1, 0.1, -0.1])), 0.08, radius)
    other = Glass("mirror", at * turn, glass.normal * turn, radius, glass.corners * turn)
    ground = ground_points(ground_of("field_IV"), count=200)
    across = ground_points(ground_of("field_IV", side="right", mirror=-1), count=200)
    one = mirror_field(scenery(), given_eyes(ZERO), glass, ground)
    two = mirror_field(scenery(), given_eyes(ZERO), other, ground * turn)
    assert two.share == one.share
    assert two.seen[::-1].tolist() == one.seen.tolist()
    order = np.lexsort(np.round(across, 9).T), np.lexsort(np.round(ground * turn, 9).T)
    assert across[order[0]] == pytest.approx((ground * turn)[order[1]])


def area_of(polygon):
    x, y = polygon[:, 0], polygon[:, 1]
    return 0.5 * abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


@pytest.mark.parametrize(("name", "area"), [("IV", 307.875), ("V", 5.5)])
def test_fields_have_their_areas_and_points_share_them(name, area):
    polygon = ground_of(f"field_{name}", side="right")
    assert area_of(polygon) == pytest.approx(area)
    points = ground_points(polygon, count=4000)
    assert len(points) == pytest.approx(4000, rel=0.02)
    assert np.all(points[:, 2] == -1.1)
    assert points[:, 1].max() < -0.9  # out to the right is less y
    assert "area" in R46.status(f"field_{name}")


@pytest.mark.parametrize(
    ("rules", "name", "side", "x", "y"),
    [
        (R46, "I", "left", (-120, -60), (-0.14 - 10, -0.14 + 10)),  # about the car's middle
        (R46, "II", "left", (-120, -4), (0.62, 5.62)),
        (R46, "III", "right", (-120, -4), (-4.9, -0.9)),
        (R46, "V", "right", (-1.75, 1), (-2.9, -0.9)),
        (R46, "VI", "right", (1.5, 3.5), (-2.9, 1.1)),  # ahead of the front
        (F111, "inside", "left", (-120, -61), (-21.159, 21.159)),  # about the eyes
        (F111, "driver_outside", "left", (-120, -10.7), (0.62, 3.02)),
    ],
)
def test_fields_count_from_eyes_front_side_or_middle(rules, name, side, x, y):
    polygon = ground_of(f"field_{name}", rules=rules, side=side)
    assert (polygon[:, 0].min(), polygon[:, 0].max()) == pytest.approx(x)
    assert (polygon[:, 1].min(), polygon[:, 1].max()) == pytest.approx(y)


def test_a_field_without_an_origin_is_refused():
    with pytest.raises(InputError, match="field 'passenger_field' needs 'origin', as"):
        mine = RuleSet(
            "mine", "", {"passenger_field": RuleValue(np.zeros((3, 2)), "", status="remembered")}
        )
        ground_of("passenger_field", rules=mine)
    with pytest.raises(InputError, match="no value 'field_VII'; did you mean 'field_VI'"):
        ground_of("field_VII")


def test_field_of_the_inside_mirror_is_20_degrees_wide():
    for behind, out in F111["field_inside"]:
        assert abs(np.degrees(np.arctan(out / behind))) == pytest.approx(10, abs=1e-3)


def mirror_room(turn=(0.0, 0.0, 0.0)):
    glass = square(AT, aimed_normal(ZERO, AT, REAR), 0.1)
    corners = glass.corners + np.array(turn)
    part = RawPart("glass", corners.reshape(-1, 3), np.arange(6).reshape(-1, 3))
    mirror = Mirror("left", "glass", tuple(AT), tuple(glass.normal))
    return environment_of(part, solid=False), mirror, glass


def test_the_surface_of_a_part_is_taken_and_aimed():
    room, mirror, glass = mirror_room()
    drawn = glass_of(room, mirror)
    assert np.sort(drawn.corners.reshape(-1, 3), axis=0) == pytest.approx(
        np.sort(glass.corners.reshape(-1, 3), axis=0)
    )
    eye = np.array([-0.1, 0.05, 0.1])
    aims = np.array([-30.0, 2.0, -1.0])
    aimed = glass_of(
        room, Mirror("left", "glass", mirror.at, mirror.normal, aims=tuple(aims)), eye=eye
    )
    assert reflections(aimed, eye, aims[None])[0] == pytest.approx(AT)
    assert (aimed.corners - AT) @ aimed.normal == pytest.approx(np.zeros((2, 3)), abs=1e-12)
    assert glass_of(room, mirror, eye=eye).normal == pytest.approx(mirror.normal)


def test_of_a_housing_only_the_side_counts_that_faces_who_looks_in():
    """A solid wedge: its glass, turned to -x, is 0.2 m wide and its back 0.6 m."""
    box = box_part("housing", (0, -0.3, -0.1), (0.3, 0.3, 0.1))
    box.vertices[box.vertices[:, 0] == 0, 1] *= 1 / 3
    found = glass_of(environment_of(box), Mirror("left", "housing", (0, 0, 0), (-1.0, 0, 0)))
    assert found.corners.min(axis=(0, 1)) == pytest.approx([0, -0.1, -0.1])
    assert found.corners.max(axis=(0, 1)) == pytest.approx([0, 0.1, 0.1])


def test_a_mirror_whose_part_has_no_surface_that_way_is_refused():
    room, _, _ = mirror_room()
    with pytest.raises(InputError, match="mirror left: part 'glass' has no surface that faces"):
        glass_of(room, Mirror("left", "glass", tuple(AT), (0.0, 0.0, 1.0)))
    with pytest.raises(InputError, match="no part 'chrome'"):
        glass_of(room, Mirror("left", "chrome", tuple(AT), (0.0, 0.0, 1.0)))
    with pytest.raises(InputError, match="expected a polygon with an area"):
        ground_points(np.zeros((3, 3)))


PANE = sheet((0.9, -0.4, -0.1), (0, 0.8, 0), (-0.4, 0, 0.4))
"""A windscreen in the plane x + z = 0.8 m."""
LIT = np.array([0.55, 0.0, -0.25])
"""A lit instrument 0.5 m / sqrt(2) before it: its image is at (1.05, 0, 0.25)."""


def cockpit(**parts):
    """An environment of a windscreen and what else there is, of triangles (T, 3, 3) [m]."""
    raw = [
        RawPart(name, corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
        for name, corners in ({"windscreen": PANE} | parts).items()
    ]
    return environment_of(*raw, solid=False)


def image(room, *, region=WHOLE, target=None, eye=ZERO, spacing=0.0):
    lit = Target("lit", LIT[None], np.array([[0, 0, 1.0]])) if target is None else target
    return windscreen_reflection(
        scenery_of(room),
        given_eyes(eye, spacing=spacing),
        lit,
        environment=room,
        windscreen=["windscreen"],
        region=region,
    )


def test_the_image_of_an_instrument_in_the_windscreen_by_hand():
    found = image(cockpit())
    assert (found.share, found.parts) == (1.0, ("windscreen",))
    assert found.middle == pytest.approx([0, np.arctan(0.25 / 1.05)])  # 13.4 degrees up
    assert image(cockpit(), region=cockpit_outline(AC25, seat="left")).share == 1.0
    below = cone("low", (1, 0, 0), np.radians(13.0))
    nothing = image(cockpit(), region=below)
    assert (nothing.share, nothing.parts) == (0.0, ())
    assert np.isnan(nothing.middle).all()


def test_what_shines_away_is_shaded_or_meets_no_glass_is_not_mirrored():
    down = Target("lit", LIT[None], np.array([[0, 0, -1.0]]))
    assert image(cockpit(), target=down).share == 0.0
    hood = sheet((0.4, -0.3, -0.2), (0.3, 0, 0), (0, 0.6, 0))
    assert image(cockpit(hood=hood)).share == 0.0
    post = sheet((0.3, -0.1, -0.1), (0, 0.2, 0), (0, 0, 0.5))
    assert image(cockpit(post=post)).share == 0.0
    aside = Target("lit", LIT[None] + np.array([0, 0.9, 0]))
    assert image(cockpit(), target=aside).share == 0.0


def test_each_eye_sees_its_own_image_and_the_share_is_of_either():
    edge = 0.4 / 0.615385 + 0.01  # the glass ends here for what the eye in the middle sees
    target = Target("lit", LIT[None] + np.array([0, edge, 0]))
    both = image(cockpit(), target=target, spacing=0.2)
    alone = image(cockpit(), target=target)
    assert alone.share == 0.0
    assert (both.seen[:, 0].tolist(), both.share) == ([False, True], 1.0)


@settings(max_examples=20)
@given(st.floats(0.3, 0.7), st.floats(-0.4, 0.4), st.floats(-0.4, -0.1), st.floats(-0.2, 0.2))
def test_an_image_is_where_a_ray_by_way_of_the_pane_ends(x, y, z, aside):
    """The ray from the eye toward the image, turned back at the pane, meets the instrument."""
    eye = np.array([0.0, aside, 0.05])
    target = Target("lit", np.array([[x, y, z]]))
    found = image(cockpit(), target=target, eye=eye)
    normal = np.array([1, 0, 1]) / np.sqrt(2)
    virtual = target.points[0] + 2 * (0.8 / np.sqrt(2) - target.points[0] @ normal) * normal
    way = virtual - eye
    meets = eye + way * (0.8 - eye[0] - eye[2]) / (way[0] + way[2])
    inside = min(0.4 - abs(meets[1]), meets[0] - 0.5, 0.9 - meets[0])
    assume(abs(inside) > 1e-6)
    on_pane = inside > 0
    assert found.share == float(on_pane)
    if on_pane:
        assert found.middle[0] == pytest.approx(np.arctan2(way[1], way[0]))
        back = way - 2 * (way @ normal) * normal
        left = np.linalg.norm(virtual - meets)
        assert meets + back / np.linalg.norm(back) * left == pytest.approx(target.points[0])


def test_an_eye_in_the_plane_of_a_pane_sees_nothing_in_it():
    flat = cockpit(roof=sheet((-0.5, -0.5, 0.0), (0.2, 0, 0), (0, 1, 0)))
    found = windscreen_reflection(
        scenery_of(flat),
        given_eyes(ZERO),
        Target("lit", LIT[None]),
        environment=flat,
        windscreen=["roof", "windscreen"],
        region=WHOLE,
    )
    assert found.parts == ("windscreen",)
    with pytest.raises(InputError, match="no part 'screen'"):
        windscreen_reflection(
            scenery_of(flat),
            given_eyes(ZERO),
            Target("lit", LIT[None]),
            environment=flat,
            windscreen=["screen"],
            region=WHOLE,
        )
