"""Eyes, regions of directions, solid angles in closed form, and what stands before an eye."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.conftest import REFERENCE, box_part, environment_of
from workbench.body.wear import wear
from workbench.errors import InputError, UsageError
from workbench.files.body.encumbrances import load_encumbrance
from workbench.sight.eyes import PIVOT_BEHIND, TURNS, eyes_of, gaze, given_eyes
from workbench.sight.obscuration import (
    TURNED_AWAY,
    Target,
    lines_of_sight,
    obscuration,
    seen_shares,
    target_of_disc,
    target_of_part,
    target_of_point,
)
from workbench.sight.panorama import look_out, lookout, panorama
from workbench.sight.rays import first_hits
from workbench.sight.regions import (
    WHOLE,
    cone,
    direction_of,
    outline,
    solid_angle_of_triangles,
)
from workbench.sight.scenery import scenery_of

DEGREE = math.pi / 180.0
LEFT_SEAT = np.radians(
    [
        (20, 0), (20, -10), (10, -17), (-30, -17), (-70, -27), (-95, -27),
        (-120, -15), (-120, 15), (-80, 35), (-40, 35), (20, 15),
    ]
)  # fmt: skip
"""The outline of AC 25.773-1 for the left seat: azimuth positive to the right, elevation."""


def test_a_window_of_a_metre_by_half_at_700_mm_fills_0_787_steradians():
    corners = np.array([(0.7, y, z) for y in (-0.5, 0.5) for z in (-0.25, 0.25)])
    faces = corners[[(0, 2, 3), (0, 3, 1)]]
    angle = abs(solid_angle_of_triangles(faces, (0, 0, 0)).sum())
    a, b = 0.5 / 0.7, 0.25 / 0.7
    exact = 4 * math.asin(a * b / math.sqrt((1 + a * a) * (1 + b * b)))
    assert angle == pytest.approx(exact, abs=1e-12)
    assert angle == pytest.approx(0.78703, abs=5e-6)


def test_a_sphere_of_60_mm_at_600_mm_is_a_cone_of_0_031495_steradians():
    assert math.degrees(math.asin(0.1)) == pytest.approx(5.7392, abs=5e-5)
    half = cone("sphere", (1, 0, 0), math.asin(0.1))
    assert half.solid_angle == pytest.approx(0.031495, abs=5e-7)


@pytest.mark.parametrize(("width", "end"), [(0.050, 2.600), (0.064, 39.000), (0.065, 1e4)])
def test_a_post_narrower_than_the_eyes_are_apart_hides_up_to_some_distance_only(width, end):
    """Past its edges the lines from both eyes, 65 mm apart, meet at d 65 / (65 - width)."""
    post = scenery_of(room(("post", (0.6, -width / 2, -1), (0.6001, width / 2, 1))))
    points = [target_of_point("far", (share * end, 0, 0)) for share in (0.99, 1.01)]
    found = seen_shares(post, given_eyes((0, 0, 0)), points).share[0, :, 2]
    assert found.tolist() == [0.0, float(width < 0.065)]


def test_the_outline_of_a_transport_cockpit_has_1_9945_steradians_and_its_corners():
    right_positive = np.diag([1.0, -1.0])
    region = outline("outline", LEFT_SEAT @ right_positive)
    assert region.solid_angle == pytest.approx(1.9945, abs=5e-5)
    inside = np.radians([(0, -16.9), (-60, -24), (-100, 20)]) @ right_positive
    outside = np.radians([(0, -17.1), (15, -14), (-120, 16), (21, 0)]) @ right_positive
    assert region.contains(direction_of(*inside.T)).all()
    assert not region.contains(direction_of(*outside.T)).any()


def test_an_outline_may_pass_straight_behind():
    region = outline("behind", np.radians([(150, -10), (210, -10), (210, 10), (150, 10)]))
    behind = direction_of(np.radians([180, -179, -151, 151, 149, -149, 0]), 0.0)
    assert region.contains(behind).tolist() == [True, True, True, True, False, False, False]
    assert region.solid_angle == pytest.approx(math.pi / 3 * 2 * math.sin(math.radians(10)))


def test_the_reference_vectors_are_those_of_these_tests():
    if not REFERENCE.exists():
        pytest.skip("no tables to compare with")
    vectors = json.loads((REFERENCE / "test_vectors2.json").read_text())
    assert vectors["solid_angle"]["rect_1000x500_at_700"] == 0.78703
    assert vectors["solid_angle"]["sphere_r60_at_600"] == 0.031495
    assert (
        vectors["ac25_773"]["left_seat_polygon_az_el_deg"] == np.degrees(LEFT_SEAT).round().tolist()
    )


CAP = """
encumbrance: cap
description: a cap with a brim above the left eye and the right, and lenses in which they are
source: made up
length: mm
layers:
  - {segments: [H], thickness: 30, shift: [60, 0, 70], subparts: [left eye, right eye]}
  - {segments: [H], thickness: 10, shift: [5, 0, 0], subparts: [left eye, right eye]}
"""


def upright(body, *, at=(0.0, 0.0, 0.0)):
    """A body in its zero pose, so far from where it stands."""
    rotations = np.zeros((1, len(body.joints), 4))
    rotations[:, :, 0] = 1.0
    world = np.concatenate([np.eye(3), np.reshape(at, (3, 1))], axis=1)[None]
    return wb.place(body, wb.Poses(rotations, 0, world))


def room(*parts, solid="auto"):
    """An environment of boxes: (name, low corner, high corner) [m]."""
    return environment_of(*[box_part(*part) for part in parts], solid=solid)


def test_eyes_of_a_body_are_the_fronts_of_its_eye_spheres(bubbleman):
    placed = upright(bubbleman)
    eyes = eyes_of(placed)
    left = bubbleman.sphere_names.index("left eye")
    assert eyes.left[0] - placed.centres[0, left] == pytest.approx((0.013, 0, 0))
    assert np.linalg.norm(eyes.left - eyes.right) == pytest.approx(0.064)
    assert eyes.left[0, 1] > eyes.right[0, 1]
    assert eyes.pivot[0, 2] < eyes.middle[0, 2] and eyes.pivot[0, 0] < eyes.middle[0, 0]


def test_given_eyes_stand_104_mm_from_their_pivot():
    eyes = given_eyes((0, 0, 1), ahead=(0, 1, 0))
    assert np.linalg.norm(eyes.left - eyes.pivot) == pytest.approx(0.104)
    assert eyes.pivot[0] == pytest.approx((0, -PIVOT_BEHIND, 1))
    assert eyes.right[0] == pytest.approx((0.0325, 0, 1))


LEVEL = replace(TURNS, line_down=0.0, eye_centre=0.0)
"""Limits with a normal line of sight that is level, as the directions of these tests are, and eyes that
turn about their pupils."""


@pytest.mark.parametrize(
    ("azimuth", "eye", "head"), [(10, 10, 0), (-40, -15, -25), (75, 15, 60), (90, 30, 60)]
)
def test_eyes_turn_first_then_the_head_then_the_eyes_to_their_limit(azimuth, eye, head):
    found = gaze(given_eyes((0, 0, 0)), 1e6 * direction_of(azimuth * DEGREE, 0.0), LEVEL)
    assert found.within[0]
    assert np.degrees(found.head_turn[0]) == pytest.approx((head, 0), abs=1e-4)
    assert np.degrees(found.eye_turn[0]) == pytest.approx((eye, 0), abs=1e-4)


def test_a_near_target_is_looked_at_from_where_the_turned_head_has_the_eyes():
    found = gaze(given_eyes((0, 0, 0)), (0.3, 0.4, 0.0), LEVEL)
    way = np.array([0.3, 0.4, 0.0]) - found.eyes.middle[0]
    forward = found.eyes.axes[0] @ way / np.linalg.norm(way)
    assert math.atan2(forward[1], forward[0]) == pytest.approx(15 * DEGREE, abs=1e-6)
    assert np.linalg.norm(found.eyes.middle - found.eyes.pivot) == pytest.approx(PIVOT_BEHIND)


def test_a_target_behind_is_out_of_limits_by_the_angle_that_the_eyes_lack():
    found = gaze(given_eyes((0, 0, 0)), 1e6 * direction_of(120 * DEGREE, 0.0), LEVEL)
    assert not found.within[0]
    assert np.degrees(found.lack[0]) == pytest.approx(120 - 60 - 35, abs=1e-4)
    assert TURNS.status


def test_what_is_exactly_behind_is_beyond_the_limits():
    found = gaze(given_eyes((0, 0, 0)), (-1e6, 0.0, 0.0), LEVEL)
    assert np.degrees(found.lack[0]) == pytest.approx(180 - 60 - 35, abs=1e-3)


@pytest.mark.parametrize(("azimuth", "trunk", "eye"), [(70, 0, 10), (90, 15, 15), (130, 30, 40)])
def test_the_trunk_turns_after_the_head_where_asked_and_the_eyes_go_on(azimuth, trunk, eye):
    goal = 1e6 * direction_of(azimuth * DEGREE, 0.0)
    found = gaze(given_eyes((0, 0, 0)), goal, LEVEL, trunk=30 * DEGREE)
    head = min(azimuth - 15, 60)
    assert np.degrees(found.head_turn[0, 0]) == pytest.approx(head, abs=1e-4)
    assert np.degrees(found.trunk_turn[0]) == pytest.approx(trunk, abs=1e-4)
    assert np.degrees(found.eye_turn[0, 0]) == pytest.approx(azimuth - head - trunk, abs=1e-4)
    assert found.within[0] == (eye <= 35)


def test_pupils_move_round_the_centres_of_the_eyes():
    """An eye turned by 15 degrees about a point 13 mm behind its pupil: 13 sin 15 = 3.36 mm aside."""
    limits = replace(TURNS, line_down=0.0, head_side=0.0)
    found = gaze(given_eyes((0, 0, 0)), 1e6 * direction_of(15 * DEGREE, 0.0), limits)
    wanted = 0.013 * np.array([math.cos(15 * DEGREE) - 1, math.sin(15 * DEGREE), 0.0])
    assert found.eyes.middle[0] == pytest.approx(wanted, abs=1e-8)


def test_a_box_hides_its_solid_angle_and_the_rest_is_free():
    scenery = scenery_of(room(("box", (1, -0.5, -0.5), (2, 0.5, 0.5))))
    found = obscuration(scenery, given_eyes((0, 0, 0), spacing=0.0), step=0.5 * DEGREE)
    exact = 4 * math.asin(0.25 / 1.25)
    assert found.left[0] == pytest.approx(exact, abs=found.error[0])
    assert found.left[0] == found.right[0] == found.either[0] == found.both[0]
    assert found.left.sum() + found.free[0] == pytest.approx(4 * math.pi)
    assert found.error[0] < 0.05 * exact


def test_what_is_hidden_neither_hides_nor_is_seen_and_glass_is_looked_through():
    cab = room(("glass", (1, -0.5, -0.5), (1.1, 0.5, 0.5)), ("wall", (2, -1, -1), (2.1, 1, 1)))
    glass = replace(cab, see_through=np.array([True, False]))
    found = panorama(scenery_of(glass), (0, 0, 0), step=2 * DEGREE)
    assert found.names[found.look((1, 0, 0))] == "wall"
    assert found.names[found.look_through((1, 0, 0))] == "glass"
    assert found.look_through((-1, 0, 0)) == -1
    none = panorama(scenery_of(replace(cab, hidden=np.array([True, True]))), (0, 0, 0), step=0.1)
    assert (none.item == -1).all() and (none.glass == -1).all()
    behind = replace(cab, see_through=np.array([False, True]))
    assert panorama(scenery_of(behind), (0, 0, 0), step=0.1).look_through((1, 0, 0)) == -1


def test_some_directions_show_what_they_do_in_a_panorama():
    cab = room(
        ("glass", (1, -0.5, -0.5), (1.1, 0.5, 0.5)),
        ("wall", (2, -1, -1), (2.1, 1, 1)),
        ("floor", (-1, -3, -1.3), (3, 3, -1.2)),
    )
    scenery = scenery_of(replace(cab, see_through=np.array([True, False, False])))
    ways = np.random.default_rng(1).normal(size=(40, 50, 3))
    ways[0] = (1.0, 0.1, 0.05)
    whole = panorama(scenery, (0, 0, 0), step=2 * DEGREE)
    item, glass = look_out(scenery, (0, 0, 0), lookout(ways, 2 * DEGREE), through=True)
    assert np.array_equal(item, whole.look(ways)) and len(np.unique(item)) == 3
    assert np.array_equal(glass, whole.look_through(ways)) and (glass == 0).any()
    few = lookout(ways[0], 2 * DEGREE)
    assert np.array_equal(look_out(scenery, (0, 0, 0), few)[0], item[0])


def test_lines_of_sight_name_the_first_thing_in_the_way():
    scenery = scenery_of(
        room(("near", (1, -0.5, -0.5), (1.1, 0.5, 0.5)), ("far", (2, -2, -2), (2.1, 2, 2)))
    )
    points = np.array([[(3, 0, 0), (0.9, 0, 0), (3, 1.8, 0), (3, 4, 0), (-1, 0, 0)]], dtype=float)
    found = lines_of_sight(scenery, [(0, 0, 0)], points)
    assert [scenery.names[k] if k >= 0 else "" for k in found[0]] == ["near", "", "far", "", ""]


def test_a_post_hides_half_a_disc_from_one_eye_and_the_other_half_from_the_other():
    scenery = scenery_of(room(("post", (0.59, -0.01, -1), (0.6, 0.01, 1))))
    disc = target_of_disc("lamp", (3, 0, 0), 0.1, normal=(-1, 0, 0))
    seen = seen_shares(scenery, given_eyes((0, 0, 0)), [disc, target_of_point("eye", (1, 0, 0))])
    left, right, either, both = seen.share[0, 0]
    assert left == right == either == both == 1.0  # past the post on both sides
    near = target_of_disc("label", (0.62, 0, 0), 0.015, normal=(-1, 0, 0))
    away = target_of_disc("back", (0.5, 0, 0), 0.1, normal=(1, 0, 0))
    seen = seen_shares(scenery, given_eyes((0, 0, 0)), [near, away])
    assert seen.share[0, 0].tolist() == [0, 0, 0, 0]
    assert seen.blocker[0].tolist() == ["post", TURNED_AWAY]


def test_people_together_see_what_each_sees_alone_beside_what_goes_along_with_the_seat():
    cab = room(("post", (0.59, -0.01, -1), (0.6, 0.01, 1)), ("seat", (-0.3, -0.3, -1), (0, 0.3, 0)))
    shift = np.array([(0.0, 0.0, 0.0), (0.0, 0.05, 0.0), (0.0, 0.0, 0.6)])
    eyes = given_eyes([(0.1, 0, 0.1), (0.2, 0.02, 0.1), (-0.1, 0, 0.2)])
    disc = target_of_disc("lamp", (1.5, 0, 0), 0.2, normal=(-1, 0, 0))
    moving = ("post", "seat")
    every = seen_shares(scenery_of(cab, moving=moving, displacement=shift), eyes, [disc])
    for row in range(3):
        own = scenery_of(cab, moving=moving, displacement=shift[[row]])
        alone = seen_shares(own, eyes.rows(slice(row, row + 1)), [disc])
        assert np.array_equal(alone.share[0], every.share[row])
        assert alone.blocker[0].tolist() == every.blocker[row].tolist()
        assert alone.inside[0] == every.inside[row]
    assert every.inside.tolist() == [-1, -1, 1]  # the seat has risen about the eyes of the third
    assert len(np.unique(every.share[:, 0], axis=0)) == 3


def test_an_eye_inside_a_part_is_reported_by_its_name():
    scenery = scenery_of(room(("seat", (-1, -1, -1), (1, 1, 1))))
    with pytest.raises(InputError, match=r"the eye at \(0, 32, 0\) mm is inside 'seat'"):
        obscuration(scenery, given_eyes((0, 0, 0)), step=0.1)


def test_a_body_without_eyes_is_told_what_to_name(one_arm):
    with pytest.raises(InputError, match="'left eye' and 'right eye'"):
        eyes_of(upright(one_arm))


def test_the_own_head_never_hides_and_own_hands_do(bubbleman):
    placed = upright(bubbleman)
    scenery = scenery_of(None, placed)
    eyes = eyes_of(placed)
    down = lines_of_sight(
        scenery,
        eyes.left,
        eyes.left[:, None]
        + [
            [[0.2, 0, -1.7]],
        ],
    )
    assert scenery.names[down[0, 0]].startswith("own ")
    used = {scenery.names[k] for k in scenery.sphere_item}
    assert "own head" not in used and any("hand" in name for name in used)
    assert WHOLE.solid_angle == pytest.approx(4 * math.pi)
    assert len(target_of_part(room(("box", (1, 0, 0), (2, 1, 1))), "box").points) == 25


def test_a_brim_hides_and_worn_spheres_that_an_eye_is_in_do_not(tmp_path, bubbleman):
    file = tmp_path / "cap.yaml"
    file.write_text(CAP, encoding="utf-8")
    placed = upright(wear(bubbleman, [load_encumbrance(file)]))
    scenery, eyes = scenery_of(None, placed), eyes_of(placed)
    cap = scenery.names.index("own cap")
    inside = np.linalg.norm(scenery.centre[0] - eyes.left[0], axis=1) < 0.03
    assert np.isnan(scenery.radius[0, inside & (scenery.sphere_item == cap)]).all()
    above = obscuration(scenery, eyes, within=cone("above", (1, 0, 1), 0.3), step=DEGREE)
    assert above.both[cap] > 0.5 * above.region.solid_angle
    ahead = obscuration(scenery, eyes, within=cone("ahead", (1, 0, 0), 0.3), step=DEGREE)
    assert ahead.both[cap] == 0.0


def test_parts_that_go_along_with_a_seat_hide_where_each_person_has_them():
    cab = room(
        ("panel", (1, -0.5, -0.5), (1.1, 0.5, 0.5)), ("lamp", (2, -0.1, -0.1), (2.1, 0.1, 0.1))
    )
    away = np.array([(0, 0, 0), (0, 0, 0.6)], dtype=float)
    scenery = scenery_of(cab, moving=("panel",), displacement=away)
    eyes = given_eyes(np.zeros((2, 3)))
    lamp = target_of_part(cab, "lamp", facing=(-1, 0, 0))
    seen = seen_shares(scenery, eyes, [lamp, target_of_part(cab, "panel", facing=(-1, 0, 0))])
    assert seen.share[:, 0, 2].tolist() == [0.0, 1.0]
    assert seen.share[:, 1, 2].tolist() == [1.0, 1.0]
    assert [obscuration(scenery, eyes, row=row, step=DEGREE).both[1] > 0 for row in (0, 1)] == [
        False,
        True,
    ]


def test_an_eye_of_one_of_many_in_the_others_hand_is_told_and_sees_nothing(bubbleman):
    eyes = given_eyes([(0, 0, 1), (0, 0, 3)])
    lower = upright(bubbleman, at=np.array([0, 0, 1]) - eyes_of(upright(bubbleman)).pivot[0])
    scenery = scenery_of(None, None, {"pilot": lower})
    seen = seen_shares(scenery, eyes, [target_of_point("lamp", (5, 0, 3))])
    assert scenery.names[seen.inside[0]].startswith("pilot's ") and seen.inside[1] == -1
    assert seen.share[:, 0, 2].tolist() == [0.0, 1.0]
    assert seen.blocker[0, 0] == scenery.names[seen.inside[0]]


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        (lambda: given_eyes((0, 0, np.nan)), "finite points"),
        (lambda: given_eyes((0, 0, 0), ahead=(0, 0, 1)), "not upright"),
        (lambda: given_eyes((0, 0, 0), spacing=-1), "spacing of 0 m or more"),
        (lambda: gaze(given_eyes((0, 0, 0)), (0, 0, 0)), "away from the eyes"),
        (lambda: panorama(scenery_of(None), (0, 0, 0), step=0.0), "0.02 to 45 degrees, got 0"),
        (lambda: panorama(scenery_of(None), (np.nan, 0, 0)), "not finite"),
        (lambda: outline("line", [(0, 0), (1, 1)]), "3 corners or more"),
        (lambda: outline("high", [(0, 0), (1, 1), (0, 2)]), "elevations of -90 to 90"),
        (lambda: cone("none", (1, 0, 0), 0.0), "half angle above 0"),
        (lambda: target_of_part(room(("box", (1, 0, 0), (2, 1, 1))), "bix"), "did you mean 'box'"),
        (lambda: Target("none", np.zeros((0, 3))), "one at least"),
    ],
)
def test_what_cannot_be_looked_at_is_told(asked, message):
    with pytest.raises(InputError, match=message):
        asked()


def test_eyes_that_are_not_placed_or_of_other_rows_are_refused_not_said_to_see():
    scenery = scenery_of(room(("box", (1, 0, 0), (2, 1, 1))), displacement=np.zeros((3, 3)))
    lamp = [target_of_point("lamp", (5, 0, 0))]
    with pytest.raises(UsageError, match="eyes: expected 3, a row of the scenery each, got 4"):
        seen_shares(scenery, given_eyes(np.zeros((4, 3))), lamp)
    with pytest.raises(InputError, match="outside the logical window"):
        lines_of_sight(scenery, np.full((3, 3), np.nan), np.ones((3, 1, 3)))
    with pytest.raises(UsageError, match="one at least, got none"):
        seen_shares(scenery, given_eyes(np.zeros((3, 3))), [])
    with pytest.raises(UsageError, match="a row of 0 to 2, got 3"):
        obscuration(scenery, given_eyes(np.zeros((4, 3))), row=3)


def test_rays_name_the_first_of_the_parts_that_count_and_how_far_it_is(box_cab):
    origins = np.zeros((3, 3))
    ways = np.array([(0, 0, -1), (1, 0, 0), (0, 0, 1)], dtype=float)
    found = first_hits(box_cab, origins, ways, length=1.0, among=np.ones(3, dtype=np.bool_))
    assert found.distance == pytest.approx([0.8, 0.4, np.inf])
    assert [box_cab.parts[k] for k in found.parts] == ["floor", "wall"]
    short = first_hits(box_cab, origins, ways, length=0.7, among=np.array([True, False, True]))
    assert not np.isfinite(short.distance).any() and short.parts == []
