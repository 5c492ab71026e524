"""The population reach map: points spread over a part, shares of people, settled points as if asked
about."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.conftest import box_part, environment_of
from workbench import limb, reach, reach_map, scale
from workbench.study.reach_map import farthest_point_order, part_points, who_reaches


@pytest.fixture(scope="module")
def board():
    """A board of 0.8 x 0.8 m, 0.6 m ahead of the hips."""
    return environment_of(box_part("board", [0.6, -0.4, 0.0], [0.602, 0.4, 0.8]))


@pytest.fixture(scope="module")
def people(bubbleman):
    bodies = [scale(bubbleman, {"stature": stature}) for stature in (1.55, 1.72, 1.88)]
    poses = wb.join_poses([wb.pose(body, {}, reference="LT") for body in bodies])
    return wb.stack_bodies(bodies), poses


def test_points_lie_on_the_part_and_are_spread_by_area(board):
    point, normal = part_points(board, "board", 400)
    assert point.shape == normal.shape == (400, 3)
    low, high = board.bounds
    assert np.all(point >= low - 1e-9) and np.all(point <= high + 1e-9)
    assert (
        np.abs(np.min(np.abs(np.concatenate([point - low, point - high], axis=1)), axis=1)).max()
        < 1e-9
    )
    face = point[np.abs(normal[:, 0]) > 0.5]
    quarters = [np.sum((face[:, 1] > 0) == left) for left in (True, False)]
    assert quarters[0] == pytest.approx(quarters[1], rel=0.15)


def test_the_map_is_what_each_reaches_point_by_point(board, people):
    bodies, poses = people
    found = reach_map(bodies, poses, board, "board", points=60, zone=1, weights=[1, 2, 1])
    oracle = np.zeros((3, 60), dtype=bool)
    for b, body in enumerate(bodies):
        own = wb.Poses(
            poses.rotations[b : b + 1], poses.reference, poses.world_from_reference[b : b + 1]
        )
        for name in ("left hand", "right hand"):
            oracle[b] |= wb.reach(body, own, found.points, limb=limb(body, name, zone=1)).reached[0]
    np.testing.assert_allclose(found.share, np.array([0.25, 0.5, 0.25]) @ oracle, atol=1e-12)
    assert 0 < found.share.mean() < 1


def test_a_mirrored_hand_has_the_mirrored_map(board, people):
    bodies, poses = people
    left, right = (
        reach_map(bodies, poses, board, "board", points=40, zone=1, hand=h)
        for h in ("left", "right")
    )
    mirrored = (
        np.linalg.norm(left.points[:, None] * [1, -1, 1] - right.points[None], axis=2).min(axis=1)
        < 0.04
    )
    assert mirrored.any()
    assert left.share[left.points[:, 1] > 0.1].mean() > right.share[right.points[:, 1] > 0.1].mean()


def test_what_a_map_cannot_mean_is_refused(board, people):
    bodies, poses = people
    with pytest.raises(wb.InputError, match="board"):
        reach_map(bodies, poses, board, "bord")
    with pytest.raises(wb.UsageError, match="left or right"):
        reach_map(bodies, poses, board, "board", hand="third")
    with pytest.raises(wb.UsageError, match="weights"):
        reach_map(bodies, poses, board, "board", points=5, weights=[1, 1])
    with pytest.raises(wb.UsageError, match="points: expected 3 to 20000, got 0"):
        reach_map(bodies, poses, board, "board", points=0)


def test_points_come_from_coarse_to_fine_and_it_is_known_how_coarse():
    points = np.stack([np.linspace(0.0, 1.0, 9), np.zeros(9), np.zeros(9)], axis=1)
    order, far = farthest_point_order(points)
    assert order[:3].tolist() == [0, 8, 4]  # one end, the other, the middle
    assert far[:3] == pytest.approx([1.0, 0.5, 0.25]) and far[-1] == 0.0
    assert sorted(order.tolist()) == list(range(9))


@pytest.mark.parametrize("count", [400, pytest.param(2000, marks=pytest.mark.nightly)])
def test_points_that_are_not_asked_about_are_as_if_they_had_been(board, people, count):
    bodies, poses = people
    points = part_points(board, "board", count)[0]
    asked = []

    def counted(*given, **options):
        asked.append(len(given[1]))
        return reach(*given, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("workbench.study.reach_map.reach", counted)
        found = who_reaches(bodies, poses, points, "right hand", grip="push", zone=1)
    arm = limb(bodies, "right hand", grip="push", zone=1)
    every = reach(bodies, poses, points, limb=arm).reached
    assert np.mean(found != every) <= 0.002
    assert sum(asked) < 0.6 * every.size and 0.1 < every.mean() < 0.9
