"""Reach: the most comfortable posture within the stops, the miss where there is none, obstacles."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from tests.conftest import box_part, environment_of
from workbench import limb, stops
from workbench.model.joint_angles import angles_of, compose
from workbench.posture.reaching.limbs import Limb

PLANAR = """
body: planar
length: mm
segments:
  BASE: {name: base, number: 1, mass: 1, directions: {front: +x, left: +y, top: +z}, spheres: [[0, 0, 0, 10]]}
  UPPER: {name: upper, number: 2, mass: 1, directions: {front: +x, left: +y, top: +z}, spheres: [[0, 0, 0, 10]]}
  LOWER: {name: lower, number: 3, mass: 1, directions: {front: +x, left: +y, top: +z}, spheres: [[0, 0, 0, 10]]}
joints:
  A:
    name: first
    number: 1
    between: [BASE, UPPER]
    at: {BASE: [0, 0, 0], UPPER: [0, 0, 0]}
    stop: hinge
    play: 0
    swing:
      - {motion: [flexion, extension], axis: -y, limits: [170, 170]}
      - {motion: [abduction, adduction], axis: -x, limits: [0, 0]}
    twist: {motion: [medial_rotation, lateral_rotation], axis: +z, limits: [0, 0]}
  B:
    name: second
    number: 2
    between: [UPPER, LOWER]
    at: {UPPER: [0, 0, -300], LOWER: [0, 0, 0]}
    stop: hinge
    play: 0
    swing:
      - {motion: [flexion, extension], axis: -y, limits: [140, 0]}
      - {motion: [abduction, adduction], axis: -x, limits: [0, 0]}
    twist: {motion: [medial_rotation, lateral_rotation], axis: +z, limits: [0, 0]}
"""
UPPER = 0.3
LOWER = 0.25
BENT = np.radians(140.0)
FARTHEST = UPPER + LOWER
NEAREST = np.sqrt(UPPER**2 + LOWER**2 + 2 * UPPER * LOWER * np.cos(BENT))


@pytest.fixture(scope="module")
def planar(tmp_path_factory):
    """Two links of 300 and 250 mm in the xz plane; the second bends by 0 to 140 degrees."""
    path = tmp_path_factory.mktemp("reach") / "planar.yaml"
    path.write_text(PLANAR)
    return wb.load_body(path)


@pytest.fixture(scope="module")
def two_links(planar):
    solid = np.ones(len(planar.sphere_names), dtype=bool)
    return Limb(
        "arm", 0, 2, (0, 1), np.array([0, 0, -LOWER]), np.array([0, 0, -1.0]), (1, 2), solid
    )


def at_rest(body, reference="LT"):
    return wb.pose(body, {}, reference=reference)


def legal(body, arm, count, seed):
    """Random legal postures of a limb's free joints, drawn until they are."""
    rng = np.random.default_rng(seed)
    found = []
    while sum(map(len, found)) < count:
        angles = np.zeros((2000, len(body.joints), 3))
        low = -body.stops.limits[list(arm.free), :, 1]
        high = body.stops.limits[list(arm.free), :, 0]
        angles[:, list(arm.free)] = rng.uniform(low, high, (2000, len(arm.free), 3))
        poses = wb.Poses(
            compose(body, angles), arm.base, np.broadcast_to(np.eye(3, 4), (2000, 3, 4))
        )
        ok = np.all(stops(body, poses).margin[:, list(arm.free)] >= 0, axis=1)
        found.append(poses.rotations[ok])
    rotations = np.concatenate(found)[:count]
    return wb.Poses(rotations, arm.base, np.broadcast_to(np.eye(3, 4), (count, 3, 4)))


def tip_of(body, poses, arm):
    world = wb.place(body, poses).world_from_segment[:, arm.end]
    return np.einsum("pij,j->pi", world[..., :3], arm.tip[0]) + world[..., 3]


def test_two_straight_links_reach_their_sum(planar, two_links):
    targets = np.array([[r, 0, 0] for r in (FARTHEST - 1e-6, FARTHEST + 0.01, FARTHEST + 0.3)])
    found = wb.reach(planar, wb.pose(planar, {}), targets, limb=two_links)
    assert list(found.reached[0]) == [True, False, False]
    assert found.miss[0, 1:] == pytest.approx([0.01, 0.3], abs=1e-6)


def test_the_second_links_stop_gives_the_least_radius(planar, two_links):
    turn = np.radians(np.arange(-60, 61, 30))
    way = np.stack([np.cos(turn), 0 * turn, np.sin(turn)], axis=1)
    found = wb.reach(planar, wb.pose(planar, {}), way * (NEAREST + 1e-6), limb=two_links)
    assert found.reached.all()
    found = wb.reach(planar, wb.pose(planar, {}), way * (NEAREST - 0.02), limb=two_links)
    assert found.miss[0] == pytest.approx(np.full(5, 0.02), abs=1e-6)
    assert {found.limit(0, row) for row in range(5)} == {"second (flexion)"}


def test_a_target_out_of_the_plane_is_missed_by_its_distance_from_the_plane(planar, two_links):
    found = wb.reach(planar, wb.pose(planar, {}), [0.4, 0.07, 0.1], limb=two_links)
    assert found.miss[0, 0] == pytest.approx(0.07, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "zone"),
    [("right hand", 1), ("left hand", 2), ("right hand", 3), ("left foot", 1), ("right foot", 1)],
)
def test_what_a_legal_posture_touches_is_reached_within_the_stops(bubbleman, name, zone):
    arm = limb(bubbleman, name, zone=zone)
    poses = legal(bubbleman, arm, 150, seed=zone)
    found = wb.reach(
        bubbleman,
        at_rest(bubbleman, bubbleman.segments[arm.base]),
        tip_of(bubbleman, poses, arm),
        limb=arm,
    )
    base = found.poses.world_from_reference
    assert np.ptp(base, axis=0).max() == 0
    assert found.reached.all()
    assert np.degrees(stops(bubbleman, found.poses).margin[:, list(arm.free)].min()) > -0.1


def test_the_answer_is_where_forward_kinematics_puts_it(bubbleman):
    arm = limb(bubbleman, "right hand", grip="pinch", zone=3)
    target = np.array([[0.45, -0.2, 0.3], [0.3, 0.1, 0.5]])
    found = wb.reach(bubbleman, at_rest(bubbleman), target, limb=arm)
    assert found.reached.all()
    np.testing.assert_allclose(tip_of(bubbleman, found.poses, arm), target, atol=1e-4)


def test_only_free_joints_move(bubbleman):
    arm = limb(bubbleman, "left hand", zone=2)
    poses = wb.pose(
        bubbleman,
        {"W": {"flexion": 10}, "LK": {"flexion": 40}, "LH": {"flexion": 60}},
        reference="LT",
    )
    found = wb.reach(bubbleman, poses, [0.3, 0.3, 0.4], limb=arm)
    others = [j for j in range(len(bubbleman.joints)) if j not in arm.free]
    np.testing.assert_allclose(
        found.poses.rotations[:, others], poses.rotations[:, others], atol=1e-15
    )


MIRROR = np.array([1.0, -1.0, 1.0])


@given(st.tuples(st.floats(-0.1, 0.6), st.floats(-0.6, 0.2), st.floats(-0.2, 0.7)))
def test_the_mirrored_hand_reaches_the_mirrored_target_alike(bubbleman, target):
    right = wb.reach(bubbleman, at_rest(bubbleman), target, limb=_hand(bubbleman, "right hand"))
    left = wb.reach(
        bubbleman, at_rest(bubbleman), MIRROR * target, limb=_hand(bubbleman, "left hand")
    )
    assert left.miss[0, 0] == pytest.approx(right.miss[0, 0], abs=2e-4)
    ease = right.discomfort[0, 0]
    if right.reached[0, 0] and left.discomfort[0, 0] == pytest.approx(ease, abs=1e-3):
        elbow = [
            angles_of(bubbleman, r.poses)[0, bubbleman.joint(j), 0]
            for r, j in ((left, "LE"), (right, "RE"))
        ]
        assert elbow[0] == pytest.approx(elbow[1], abs=0.02)


_HANDS = {}


def _hand(body, name):
    return _HANDS.setdefault(name, limb(body, name, zone=2))


def test_a_longer_arm_never_reaches_less(bubbleman):
    arm = limb(bubbleman, "right hand")
    longer = Limb(
        arm.name,
        arm.base,
        arm.end,
        arm.free,
        arm.tip * [1, 1, 1.3],
        arm.pointing,
        arm.moving,
        arm.solid,
    )
    rng = np.random.default_rng(5)
    way = rng.normal(size=(60, 3)) * [1, 1, 0.6]
    targets = np.array([0.1, -0.2, 0.35]) + 0.85 * way / np.linalg.norm(way, axis=1)[:, None]
    short, long = (
        wb.reach(bubbleman, at_rest(bubbleman), targets, limb=chosen) for chosen in (arm, longer)
    )
    out = short.joint < 0  # those that only length limits
    assert np.all(long.miss[out & ~short.reached] <= short.miss[out & ~short.reached] + 1e-6)
    assert np.any(long.miss < short.miss - 0.02)


def _nearest_sampled(body, arm, poses, target):
    """The nearest that sampling gets: the best legal posture, then many small changes of it, ever
    smaller."""
    rng = np.random.default_rng(8)
    best = None
    angles = angles_of(body, poses)
    for turn in range(14):
        trial = wb.Poses(
            compose(body, angles), arm.base, np.broadcast_to(np.eye(3, 4), (len(angles), 3, 4))
        )
        gap = np.linalg.norm(tip_of(body, trial, arm) - target, axis=1)
        gap[stops(body, trial).margin[:, list(arm.free)].min(axis=1) < 0] = np.inf
        best = angles[np.argmin(gap)]
        change = np.zeros((400, len(body.joints), 3))
        change[:, list(arm.free)] = rng.normal(scale=0.3 * 0.7**turn, size=(400, len(arm.free), 3))
        change[:, [j for j in arm.free if body.stops.kind[j] == 2], 1:] = 0
        change[0] = 0
        angles = best + change
    return gap.min()


MISSED = np.array([[0.9, -0.4, 0.1], [0.2, 0.9, 0.0], [0.1, -0.3, 1.2], [0.0, 0.3, -0.7]])


@pytest.mark.parametrize("targets", [MISSED[:1], pytest.param(MISSED, marks=pytest.mark.nightly)])
def test_a_miss_is_the_least_that_dense_sampling_finds(bubbleman, targets):
    arm = limb(bubbleman, "right hand")
    poses = legal(bubbleman, arm, 2500, seed=3)
    found = wb.reach(bubbleman, wb.pose(bubbleman, {}, reference="UT"), targets, limb=arm)
    least = np.array([_nearest_sampled(bubbleman, arm, poses, target) for target in targets])
    assert np.all(found.miss[0] <= least + 1e-4)
    assert found.miss[0] == pytest.approx(least, abs=0.012)


def test_what_is_behind_the_back_is_reached_by_an_arm_that_swings_the_other_way(bubbleman):
    """From where the arm swings at first it ends 91 and 58 mm short, against the stops."""
    arm = limb(bubbleman, "right hand")
    targets = [[-0.5, -0.4, 0.3], [-0.5, -0.2, 0.4]]
    found = wb.reach(bubbleman, at_rest(bubbleman, "UT"), targets, limb=arm)
    assert found.reached.all()
    np.testing.assert_allclose(tip_of(bubbleman, found.poses, arm), targets, atol=1e-4)
    assert np.degrees(stops(bubbleman, found.poses).margin[:, list(arm.free)].min()) > -0.1


def test_a_batch_is_its_rows_and_the_same_each_time(bubbleman):
    arm = limb(bubbleman, "left foot", grip="heel")
    targets = np.array([[0.5, 0.1, -0.5], [0.7, 0.2, -0.3], [0.2, 0.1, -0.9], [2.0, 0.0, 0.0]])
    batch = wb.reach(bubbleman, at_rest(bubbleman), targets, limb=arm)
    again = wb.reach(bubbleman, at_rest(bubbleman), targets, limb=arm)
    np.testing.assert_array_equal(batch.poses.rotations, again.poses.rotations)
    for row, target in enumerate(targets):
        one = wb.reach(bubbleman, at_rest(bubbleman), target, limb=arm)
        np.testing.assert_array_equal(one.poses.rotations[0], batch.poses.rotations[row])


def test_a_limb_arrives_in_the_direction_asked_for(bubbleman):
    arm = limb(bubbleman, "right hand", zone=2)
    found = wb.reach(bubbleman, at_rest(bubbleman), [0.4, -0.2, 0.3], limb=arm, direction=[1, 0, 0])
    world = wb.place(bubbleman, found.poses).world_from_segment[0, arm.end]
    assert found.reached.all()
    np.testing.assert_allclose(world[:, :3] @ arm.pointing[0], [1, 0, 0], atol=1e-3)


def test_the_hand_goes_around_a_board_and_what_is_behind_a_wall_is_told(bubbleman):
    arm = limb(bubbleman, "right hand")
    target = [0.55, -0.3, 0.25]
    board = environment_of(box_part("board", [0.30, -0.7, 0.16], [0.34, -0.1, 0.2]))
    free = wb.reach(bubbleman, at_rest(bubbleman), target, limb=arm)
    around = wb.reach(bubbleman, at_rest(bubbleman), target, limb=arm, environment=board)
    assert free.reached.all() and around.reached.all() and not around.overlap.any()
    assert not len(_entered(bubbleman, around, arm, board))
    wall = environment_of(box_part("wall", [0.3, -2, -2], [0.35, 2, 2]))
    behind = wb.reach(bubbleman, at_rest(bubbleman), target, limb=arm, environment=wall)
    assert not behind.reached.any() and behind.limit(0, 0) == "wall" and behind.miss[0, 0] > 0.1
    assert not len(_entered(bubbleman, behind, arm, wall))


def _entered(body, found, arm, environment):
    met = wb.contacts(wb.place(body, found.poses), environment)
    return met.rows(arm.solid[0, met.sphere] & (met.excess > 0))


def test_unknown_limbs_grips_and_zones_are_told_with_the_valid_ones(bubbleman, one_arm):
    for arguments, words in (
        ({"name": "third hand"}, "left hand"),
        ({"name": "left hand", "grip": "ball"}, "push"),
        ({"name": "left foot", "grip": "push"}, "ball"),
        ({"name": "left hand", "zone": 4}, "1, 2 or 3"),
    ):
        with pytest.raises(wb.InputError, match=words):
            limb(bubbleman, **arguments)
    with pytest.raises(wb.InputError, match="LHN"):
        limb(one_arm, "left hand")


def test_targets_that_are_no_points_are_refused(bubbleman):
    arm = limb(bubbleman, "left hand")
    with pytest.raises(wb.UsageError, match="targets: expected finite numbers, got nan"):
        wb.reach(bubbleman, at_rest(bubbleman), [np.nan, 0, 0], limb=arm)
    with pytest.raises(wb.UsageError, match=r"targets: expected shape \(T, 3\) or \(2, T, 3\)"):
        two = wb.join_poses([at_rest(bubbleman)] * 2)
        wb.reach(bubbleman, two, np.zeros((3, 1, 3)), limb=arm)
