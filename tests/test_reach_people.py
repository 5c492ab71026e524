"""Reaches and seats of many people at once: the same answers as one by one."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.conftest import box_part, environment_of
from workbench.body.parts import moved
from workbench.body.scaling.scale import scale
from workbench.posture.reaching.limbs import limb
from workbench.posture.reaching.reach_people import reach_people

MEASURES = (
    {"stature": 1.60, "thumb_tip_reach": 0.70},
    {"stature": 1.75},
    {"stature": 1.88, "thumb_tip_reach": 0.86},
)
TARGETS = np.array(
    [[0.45, -0.2, 0.3], [0.3, 0.1, 0.5], [0.75, -0.3, 0.35], [0.1, -0.6, 0.2], [1.3, 0.2, 0.1]]
)


@pytest.fixture(scope="module")
def people(bubbleman):
    return wb.stack_bodies([scale(bubbleman, measures) for measures in MEASURES])


@pytest.fixture(scope="module")
def seated(people):
    return wb.join_poses(
        [
            wb.pose(body, {"LH": {"flexion": 80}, "RH": {"flexion": 80}}, reference="LT")
            for body in people
        ]
    )


def row(poses, b):
    return wb.Poses(
        poses.rotations[b : b + 1], poses.reference, poses.world_from_reference[b : b + 1]
    )


@pytest.mark.parametrize(
    ("name", "grip", "zone"), [("right hand", "pinch", 1), ("left hand", "grasp", 3)]
)
def test_people_reach_what_each_reaches_alone(people, seated, name, grip, zone):
    found = reach_people(people, seated, TARGETS, name=name, grip=grip, zone=zone, rotations=True)
    for b, body in enumerate(people):
        one = wb.reach(body, row(seated, b), TARGETS, limb=limb(body, name, grip=grip, zone=zone))
        assert list(found.reached[b]) == list(one.reached)
        np.testing.assert_allclose(found.miss[b], one.miss, atol=1e-4)
        assert [found.limit(b, t) for t in range(len(TARGETS))] == [
            one.limit(t) for t in range(len(TARGETS))
        ]
        easy = found.reached[b]
        np.testing.assert_allclose(
            found.discomfort[b, easy], one.discomfort[easy], rtol=1e-3, atol=1e-3
        )
    assert found.rotations.shape == (3, 5, 19, 4)
    assert 0 < found.reached.sum() < found.reached.size


def test_the_spare_ends_where_the_next_millimetres_are_missed(people, seated):
    found = reach_people(people, seated, TARGETS, name="right hand", zone=2, spare=0.2)
    shoulder = [
        wb.place(body, row(seated, b)).world_from_segment[0, body.joint("RS") + 1]
        for b, body in enumerate(people)
    ]
    for b, body in enumerate(people):
        j = body.joint("RS")
        origin = shoulder[b][:, :3] @ body.joint_in_child[0, j] + shoulder[b][:, 3]
        way = (TARGETS - origin) / np.linalg.norm(TARGETS - origin, axis=1)[:, None]
        arm = limb(body, "right hand", zone=2)
        for beyond, expected in ((-2e-3, True), (2e-3, False)):
            tried = wb.reach(
                body, row(seated, b), TARGETS + (found.spare[b, :, None] + beyond) * way, limb=arm
            )
            inner = found.reached[b] & (found.spare[b] > 0.003) & (found.spare[b] < 0.2 - 1e-6)
            assert np.all(tried.reached[inner] == expected)
    assert np.all(found.spare[~found.reached] == 0)
    assert np.all((found.spare >= 0) & (found.spare <= 0.2))
    assert np.any((found.spare > 0) & (found.spare < 0.199))


def test_people_keep_off_obstacles_that_move_with_their_seats(people, seated):
    room = environment_of(
        box_part("board", [0.30, -0.7, 0.16], [0.34, -0.1, 0.2]),
        box_part("wing", [0.2, -0.8, 0.0], [0.25, -0.45, 0.3]),
    )
    shift = np.array([[0.0, 0, 0], [0.05, 0, 0.02], [-0.05, 0, 0.04]])
    found = reach_people(
        people,
        seated,
        TARGETS[:3],
        name="right hand",
        environment=room,
        moves=["wing"],
        shift=shift,
        rotations=True,
    )
    for b, body in enumerate(people):
        own = moved(room, ["wing"], shift[b])
        arm = limb(body, "right hand")
        one = wb.reach(body, row(seated, b), TARGETS[:3], limb=arm, environment=own)
        assert list(found.reached[b]) == list(one.reached)
        np.testing.assert_allclose(found.miss[b][one.reached], one.miss[one.reached], atol=1e-4)
        poses = wb.Poses(
            found.rotations[b],
            seated.reference,
            np.repeat(row(seated, b).world_from_reference, 3, axis=0),
        )
        met = wb.contacts(wb.place(body, poses), own)
        met = met.rows(arm.solid[met.sphere] & (met.excess > 0))
        assert set(met.pose) <= set(np.flatnonzero(found.overlap[b] > 0))


def test_bodies_of_other_families_and_wrong_numbers_of_rows_are_refused(people, seated, one_arm):
    with pytest.raises(wb.UsageError, match="poses: expected 2 rows for 2 bodies"):
        reach_people(people[:2], seated, TARGETS, name="right hand")
    with pytest.raises(wb.UsageError, match="finite points"):
        reach_people(people, seated, TARGETS[:, :2], name="right hand")
    with pytest.raises(wb.UsageError, match="rows of one body, they differ in segments or joints"):
        wb.stack_bodies([people, one_arm])
