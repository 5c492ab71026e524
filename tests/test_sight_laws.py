"""Laws of sight that hold wherever eyes and boxes are."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.conftest import box_part, environment_of
from workbench.sight.eyes import TURNS, Eyes, gaze, given_eyes
from workbench.sight.kernels.sphere_rays import Lens, sphere_box
from workbench.sight.obscuration import (
    SEEN_BY,
    lines_of_sight,
    obscuration,
    seen_shares,
    target_of_disc,
)
from workbench.sight.panorama import panorama, pixel_weights
from workbench.sight.regions import WHOLE, cone, outline
from workbench.sight.scenery import enclosing_items, scenery_of

STEP = math.radians(2.0)
SEEDS = st.integers(0, 2**32 - 1)


def boxes(random, count=4):
    """Boxes around a place that is free, one of them see-through."""
    middle = random.uniform(-1, 1, (count, 3))
    middle *= (0.6 + random.uniform(0, 1, (count, 1))) / np.linalg.norm(middle, axis=1)[:, None]
    half = random.uniform(0.02, 0.25, (count, 3))
    parts = [box_part(f"box {k}", middle[k] - half[k], middle[k] + half[k]) for k in range(count)]
    made = environment_of(*parts)
    return replace(made, see_through=np.arange(count) == count - 1)


def seen_from(environment, eyes, **options):
    """What is hidden from eyes that are inside nothing."""
    scenery = scenery_of(environment)
    pair = np.concatenate([eyes.left, eyes.right])
    assume(np.all(enclosing_items(scenery, pair) < 0))
    return obscuration(scenery, eyes, step=STEP, **options)


@given(SEEDS)
def test_all_items_and_what_is_free_fill_the_whole_sphere_and_two_eyes_see_more_than_one(seed):
    found = seen_from(boxes(np.random.default_rng(seed)), given_eyes((0, 0, 0)))
    for eye, hidden in enumerate((found.left, found.right)):
        assert hidden.sum() + found.free[eye] == pytest.approx(4 * math.pi, abs=1e-9)
        assert np.all(found.either >= hidden - 1e-12) and np.all(hidden >= found.both - 1e-12)
        assert found.free[2] >= found.free[eye] - 1e-12 >= found.free[3] - 2e-12


@given(SEEDS)
def test_a_region_holds_its_solid_angle_and_no_more_than_all_directions(seed):
    random = np.random.default_rng(seed)
    environment = boxes(random)
    whole = seen_from(environment, given_eyes((0, 0, 0)))
    corners = np.array([(-0.5, -0.4), (0.9, -0.3), (0.7, 0.5), (-0.2, 0.6)])
    for region in (cone("cone", random.normal(size=3), 0.8), outline("outline", corners)):
        part = seen_from(environment, given_eyes((0, 0, 0)), within=region)
        held = part.left.sum() + part.free[0]
        assert abs(held - region.solid_angle) <= part.error.sum() + part.free_error
        assert np.all(part.left <= whole.left + 1e-12)
    assert seen_from(environment, given_eyes((0, 0, 0)), within=WHOLE).left == pytest.approx(
        whole.left
    )


def mirrored(environment):
    """An environment with left and right exchanged."""
    flip = np.array([1.0, -1.0, 1.0])
    parts = [
        box_part(name, *np.sort((environment.part(name).vertices * flip), axis=0)[[0, -1]])
        for name in environment.parts
    ]
    return replace(environment_of(*parts), see_through=environment.see_through)


@given(SEEDS)
def test_a_mirrored_scene_gives_mirrored_numbers(seed):
    environment = boxes(np.random.default_rng(seed))
    found = seen_from(environment, given_eyes((0, 0.1, 0)))
    other = seen_from(mirrored(environment), given_eyes((0, -0.1, 0)))
    tolerance = found.error + 1e-9
    assert np.all(np.abs(found.left - other.right) <= tolerance)
    assert np.all(np.abs(found.both - other.both) <= tolerance)


@given(SEEDS, st.floats(-3.1, 3.1))
def test_a_scene_that_is_moved_and_turned_with_the_eyes_gives_the_same_within_the_error(seed, turn):
    environment = boxes(np.random.default_rng(seed))
    eyes = given_eyes((0, 0, 0))
    matrix = np.array(
        [
            (math.cos(turn), -math.sin(turn), 0),
            (math.sin(turn), math.cos(turn), 0),
            (0, 0, 1),
        ]
    )
    scenery = scenery_of(environment)
    assume(np.all(enclosing_items(scenery, np.concatenate([eyes.left, eyes.right])) < 0))
    move = np.array([3.0, -2.0, 1.0])
    turned = replace(
        scenery, triangles=scenery.triangles @ matrix.T + move, item_ball=np.zeros((0, 4))
    )
    moved = Eyes(
        *(point @ matrix.T + move for point in (eyes.left, eyes.right)), eyes.axes, eyes.pivot
    )
    one, other = (
        obscuration(scenery, eyes, step=STEP),
        obscuration(turned, moved, step=STEP),
    )
    assert np.all(np.abs(one.left - other.left) <= one.error + other.error)
    assert np.all(np.abs(one.free - other.free) <= one.free_error + other.free_error)


@given(SEEDS)
def test_the_stated_error_holds_against_finer_steps_and_shrinks_with_them(seed):
    scenery = scenery_of(boxes(np.random.default_rng(seed)))
    eyes = given_eyes((0, 0, 0))
    assume(np.all(enclosing_items(scenery, np.concatenate([eyes.left, eyes.right])) < 0))
    coarse, fine = (obscuration(scenery, eyes, step=step) for step in (2 * STEP, STEP / 4))
    for one, other in ((coarse.left, fine.left), (coarse.right, fine.right)):
        assert np.all(np.abs(one - other) <= coarse.error + fine.error)
    assert fine.error.sum() <= 0.2 * coarse.error.sum()


@given(SEEDS)
def test_an_eye_that_goes_along_its_line_of_sight_sees_the_same_until_it_passes_the_blocker(seed):
    random = np.random.default_rng(seed)
    scenery = scenery_of(boxes(random))
    eye, point = np.zeros(3), random.normal(size=3) * 2
    assume(enclosing_items(scenery, eye[None])[0] < 0)
    first = lines_of_sight(scenery, eye[None], point[None, None])[0, 0]
    shares = np.linspace(0.0, 0.999, 40)
    path = eye + shares[:, None] * (point - eye)
    along = lines_of_sight(scenery, path, np.broadcast_to(point, (40, 1, 3)))[:, 0]
    if first < 0:
        assert np.all(along < 0)
    else:
        passed = np.flatnonzero(along != first)
        assert along[0] == first and np.all(along[: passed[0] if len(passed) else 40] == first)


@given(SEEDS, st.floats(0.05, 0.5))
def test_a_nearer_eye_sees_a_part_larger(seed, nearer):
    random = np.random.default_rng(seed)
    centre = random.uniform(1.0, 2.0)
    room = environment_of(box_part("box", (centre, -0.2, -0.2), (centre + 0.1, 0.2, 0.2)))
    far, near = (
        obscuration(scenery_of(room), given_eyes((x, 0, 0)), step=STEP / 2) for x in (0, nearer)
    )
    assert near.left[0] + near.error[0] > far.left[0] - far.error[0]


@given(SEEDS)
def test_shares_of_two_eyes_hold_those_of_one(seed):
    random = np.random.default_rng(seed)
    scenery = scenery_of(boxes(random))
    eyes = given_eyes(random.uniform(-0.2, 0.2, (3, 3)))
    away = random.normal(size=3) * 2
    targets = [
        target_of_disc("disc", away, 0.4, normal=-away),
        target_of_disc("flat", away, 0.2),
    ]
    left, right, either, both = np.moveaxis(seen_shares(scenery, eyes, targets).share, -1, 0)
    assert np.all(either >= np.maximum(left, right)) and np.all(both <= np.minimum(left, right))
    assert np.all((both >= 0) & (either <= 1 + 1e-12))
    assert either + both == pytest.approx(left + right)
    for by, share in zip(SEEN_BY, (left, right, either, both), strict=True):
        seen = seen_shares(scenery, eyes, targets, by=by)
        assert np.all(seen.blocked <= 1 - share + 1e-12)  # nothing hides more than is not seen
        assert np.all((seen.blocked > 0) == (share < 1 - 1e-12))


@settings(max_examples=5)
@given(st.integers(1, 60))
def test_the_pixels_of_six_faces_are_all_directions(n):
    weight, before = pixel_weights(n)
    assert 6 * weight.sum() == pytest.approx(4 * math.pi)
    assert before[:, -1] == pytest.approx(weight.sum(axis=1))


@given(SEEDS)
def test_a_panorama_looks_alike_in_whatever_axes_its_faces_stand(seed):
    random = np.random.default_rng(seed)
    scenery = scenery_of(boxes(random))
    assume(enclosing_items(scenery, np.zeros((1, 3)))[0] < 0)
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    axes *= np.sign(np.linalg.det(axes))
    ways = random.normal(size=(500, 3))
    one, other = (panorama(scenery, (0, 0, 0), step=STEP, axes=frame) for frame in (None, axes))
    assert np.mean(one.look(ways) != other.look(ways)) < 0.05


@given(SEEDS)
def test_eyes_turn_beyond_what_is_easy_only_where_the_head_is_at_its_limit(seed):
    random = np.random.default_rng(seed)
    ways = random.normal(size=(40, 3))
    ways = ways[ways[:, 0] > 0.0] / np.linalg.norm(ways[ways[:, 0] > 0.0], axis=1)[:, None]
    eyes = given_eyes(np.zeros_like(ways))
    found = gaze(eyes, ways * random.uniform(0.3, 3.0, (len(ways), 1)))
    low = np.array([-TURNS.head_side, -TURNS.head_down])
    high = np.array([TURNS.head_side, TURNS.head_up])
    moves = (found.head_turn > low + 1e-6) & (found.head_turn < high - 1e-6)
    assert np.all((np.abs(found.eye_turn) <= TURNS.easy + 1e-4) | ~moves)
    turned = np.abs(found.head_turn) > 1e-6
    at_ease = np.abs(np.abs(found.eye_turn) - TURNS.easy) < 1e-4
    assert np.all(at_ease | ~(moves & turned))


@given(SEEDS, st.floats(0.0, 0.5))
def test_a_gaze_in_a_mirrored_and_turned_world_is_mirrored_and_turned(seed, trunk):
    random = np.random.default_rng(seed)
    goals = random.normal(size=(20, 3)) * [2, 2, 0.5] + [0.5, 0, 0]
    turn = random.uniform(-3, 3)
    c, s = np.cos(turn), np.sin(turn)
    about = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])  # of rows
    mirror = np.diag([1.0, -1.0, 1.0])
    here = given_eyes(np.zeros_like(goals))
    one = gaze(here, goals, trunk=trunk)
    other = gaze(
        given_eyes(np.zeros_like(goals), ahead=(c, s, 0.0)), goals @ mirror @ about, trunk=trunk
    )
    assert other.eyes.left == pytest.approx(one.eyes.right @ mirror @ about, abs=1e-6)
    assert other.trunk_turn == pytest.approx(-one.trunk_turn, abs=1e-6)
    assert other.lack == pytest.approx(one.lack, abs=1e-6)
    within = one.within & (one.trunk_turn == 0.0)  # who needs no trunk looks as if none were there
    plain = gaze(here, goals)
    assert plain.eyes.left[within] == pytest.approx(one.eyes.left[within], abs=1e-6)


def test_what_is_straight_overhead_is_looked_up_to_without_a_turn_to_the_side():
    found = gaze(given_eyes((0, 0, 0)), (0.05, 0.0, 1.0))
    assert found.head_turn[0] == pytest.approx((0.0, TURNS.head_up))
    assert found.eye_turn[0, 0] == 0.0 and found.within[0]


FACE = 24
"""Pixels along the edge of a face of a quarter turn, seen from the origin."""
LENS = Lens(np.zeros((0, 3)), FACE / 2, 1.0, FACE / 2, FACE / 2, 1.0, 1.0)


def box_on_face(x, y, along, radius):
    """The pixels of a face that are asked whether they show a sphere."""
    return sphere_box(np.array([[x, y, 1.0 - along, radius]]), 0, LENS, FACE, FACE)


@given(st.tuples(*[st.floats(-2, 2)] * 3), st.floats(0.05, 1.5))
def test_the_box_of_a_sphere_about_an_eye_holds_every_pixel_that_shows_it(centre, radius):
    x, y, along = centre
    assume(np.linalg.norm(centre) > 1.001 * radius)
    box = box_on_face(x, y, along, radius)
    at = (np.arange(FACE) + 0.5) / (FACE / 2) - 1.0
    right, down = np.meshgrid(at, at)
    ways = np.stack([right, -down, np.ones_like(right)], axis=-1)
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    before = ways @ np.array(centre)
    shows = (before > 0) & (np.sum(np.square(centre)) - before**2 <= radius**2)
    rows, columns = np.nonzero(shows)
    assert np.all((rows >= box.top) & (rows < box.bottom))
    assert np.all((columns >= box.left) & (columns < box.right))


def test_a_sphere_beside_or_behind_an_eye_is_looked_for_where_it_can_be_alone():
    # 2 m to the right and 1 m in radius: from 90 - 30 degrees on, beyond a face that ends at 45
    beside = box_on_face(2.0, 0.0, 0.0, 1.0)
    assert beside.left == beside.right == FACE
    # from 63.43 - 32.45 degrees on, tan 30.98 = 0.600: column 12 + 7.2, less one for rounding
    assert box_on_face(1.0, 0.0, 0.5, 0.6).left == 18
    for across in (-2.0, 0.5, 2.0):
        behind = box_on_face(across, 0.0, -1.5, 1.0)
        assert behind.left == behind.right
