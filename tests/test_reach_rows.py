"""Reaches of many people at once: the same answers, to the last bit, as of each alone."""

from __future__ import annotations

import numpy as np
import pytest

import workbench as wb
from tests.conftest import box_part, environment_of
from workbench import scale
from workbench.files.postures import load_postures, posture_path, posture_pose
from workbench.model.surroundings import move_parts

MEASURES = (
    {"stature": 1.60, "thumb_tip_reach": 0.70},
    {"stature": 1.75},
    {"stature": 1.88, "thumb_tip_reach": 0.86},
)
TARGETS = np.array(
    [[0.45, -0.2, 0.3], [0.3, 0.1, 0.5], [0.75, -0.3, 0.35], [0.1, -0.6, 0.2], [1.3, 0.2, 0.1]]
)
LIMBS = (("left hand", "grasp", 2), ("right hand", "push", 3), ("left foot", "ball", 1))
FIELDS = (
    *("target", "tip", "angles", "reached", "miss", "overlap", "discomfort", "extension"),
    *("joint", "axis", "side", "part"),
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


@pytest.fixture(scope="module", params=[8, pytest.param(64, marks=pytest.mark.nightly)])
def crowd(request):
    """Women and men of many sizes, in turns, as rows of one body."""
    templates = [wb.load_body(name) for name in ("adult_female", "adult_male")]
    spread = np.random.default_rng(4)
    return wb.stack_bodies(
        [
            scale(templates[k % 2], {"stature": float(spread.uniform(1.5, 1.9))})
            for k in range(request.param)
        ]
    )


def driving(body, environment, seat):
    """The rows of a body, each in the driving posture of its file, in a seat."""
    file, _ = load_postures(posture_path("adult_male"), body[0])
    own = []
    for one in body:
        poses = posture_pose(one, file, "driving")
        own.append(wb.seat(one, poses, environment.seat(seat).held(0.0, 0.0)).poses)
    return wb.join_poses(own)


@pytest.mark.parametrize(("environment", "seat"), [("trainer", "left"), ("compact_car", "driver")])
def test_a_person_gets_the_same_answer_alone_in_any_order_and_in_any_crowd(
    crowd, environment, seat
):
    room = wb.load_environment(environment)
    poses = driving(crowd, room, seat)
    count = len(crowd)
    shift = np.zeros((count, 3))
    shift[:, 0] = np.linspace(-0.05, 0.05, count)
    for name, grip, zone in LIMBS:
        kind = "foot" if grip == "ball" else grip
        at = [control.at for control in room.controls if control.grip == kind][
            : 2 if count == 8 else 4
        ]
        if not at:
            continue

        def asked(rows, at=at, name=name, grip=grip, zone=zone):
            body = crowd[rows]
            return wb.reach(
                body,
                wb.Poses(poses.rotations[rows], poses.reference, poses.world_from_reference[rows]),
                at,
                limb=wb.limb(body, name, grip=grip, zone=zone),
                environment=room,
                moving_parts=room.seat(seat).moves,
                displacement=shift[rows],
                max_extension=0.2,
            )

        together = asked(np.arange(count))
        assert together.reached.any()
        for rows in ([5], [count - 4], list(range(count - 1, -1, -4)), [count // 2, 2, count - 3]):
            some = asked(np.array(rows))
            for field in FIELDS:
                np.testing.assert_array_equal(
                    getattr(some, field), getattr(together, field)[rows], err_msg=field
                )


def test_rows_named_by_the_poses_are_the_rows_themselves(people, seated):
    rows = np.array([2, 0, 2])
    own = wb.Poses(
        seated.rotations[rows], seated.reference, seated.world_from_reference[rows], person=rows
    )
    arm = wb.limb(people, "right hand", zone=2)
    all_of_them = wb.reach(people, seated, TARGETS, limb=arm)
    found = wb.reach(people, own, TARGETS, limb=arm)
    room = environment_of(box_part("board", [0.30, -0.7, 0.16], [0.34, -0.1, 0.2]))
    aside = np.array([[0.0, 0, 0], [0, 0, 0.1], [0.2, 0, 0]])
    kept = wb.reach(
        people,
        own,
        TARGETS,
        limb=arm,
        environment=room,
        moving_parts=["board"],
        displacement=aside,
    )
    for field in FIELDS:
        np.testing.assert_array_equal(getattr(found, field), getattr(all_of_them, field)[rows])
    assert len(kept.poses) == 15 and np.all(kept.poses.person == np.repeat(rows, 5))
    for b, person in enumerate(rows):
        one = wb.reach(
            people[person],
            row(seated, person),
            TARGETS,
            limb=wb.limb(people[person], "right hand", zone=2),
            environment=move_parts(room, ["board"], aside[b]),
        )
        np.testing.assert_array_equal(kept.reached[b], one.reached[0])


def test_each_person_may_have_targets_of_their_own(people, seated):
    arm = wb.limb(people, "left hand")
    own = TARGETS[None] + np.arange(3)[:, None, None] * [0.0, 0.03, 0.0]
    found = wb.reach(people, seated, own, limb=arm)
    for b, body in enumerate(people):
        one = wb.reach(body, row(seated, b), own[b], limb=wb.limb(body, "left hand"))
        np.testing.assert_array_equal(found.angles[b], one.angles[0])


@pytest.mark.parametrize(
    ("name", "grip", "zone"), [("right hand", "pinch", 1), ("left hand", "grasp", 3)]
)
def test_a_search_from_a_guide_finds_what_one_from_comfort_finds(people, seated, name, grip, zone):
    arm = wb.limb(people, name, grip=grip, zone=zone)
    found = wb.reach(people, seated, TARGETS, limb=arm)
    cold = wb.reach(people, seated, TARGETS, limb=arm, restarts=12)
    np.testing.assert_array_equal(found.reached, cold.reached)
    np.testing.assert_allclose(found.miss, cold.miss, atol=1e-4)
    limits = [[reach.limit(b, t) for b in range(3) for t in range(5)] for reach in (found, cold)]
    assert limits[0] == limits[1]
    # another local least may be found, for better or worse; most are the same
    ease, plain = found.discomfort[found.reached], cold.discomfort[found.reached]
    assert np.median(np.abs(ease - plain)) < 1e-2
    assert ease.sum() < 1.02 * plain.sum()
    assert found.poses.rotations.shape == (15, 19, 4)
    assert 0 < found.reached.sum() < found.reached.size


def test_the_extension_ends_where_the_next_millimetres_are_missed(people, seated):
    arm = wb.limb(people, "right hand", zone=2)
    found = wb.reach(people, seated, TARGETS, limb=arm, max_extension=0.2)
    j = people.joint("RS")
    shoulder = wb.place(people, seated).world_from_segment[:, j + 1]
    origin = np.einsum("bij,bj->bi", shoulder[:, :, :3], people.joint_in_child[:, j])
    way = TARGETS - (origin + shoulder[:, :, 3])[:, None]
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    inner = found.reached & (found.extension > 0.003) & (found.extension < 0.2 - 1e-6)
    for beyond, expected in ((-2e-3, True), (2e-3, False)):
        targets = TARGETS + (found.extension[..., None] + beyond) * way
        tried = wb.reach(people, seated, targets, limb=arm, restarts=12)
        assert np.all(tried.reached[inner] == expected)
    assert np.all(found.extension[~found.reached] == 0)
    assert np.all((found.extension >= 0) & (found.extension <= 0.2))
    assert np.any((found.extension > 0) & (found.extension < 0.199))


def test_people_keep_off_obstacles_that_move_with_their_seats(people, seated):
    room = environment_of(
        box_part("board", [0.30, -0.7, 0.16], [0.34, -0.1, 0.2]),
        box_part("wing", [0.2, -0.8, 0.0], [0.25, -0.45, 0.3]),
    )
    shift = np.array([[0.0, 0, 0], [0.05, 0, 0.02], [-0.05, 0, 0.04]])
    found = wb.reach(
        people,
        seated,
        TARGETS[:3],
        limb=wb.limb(people, "right hand"),
        environment=room,
        moving_parts=["wing"],
        displacement=shift,
    )
    for b, body in enumerate(people):
        own = move_parts(room, ["wing"], shift[b])
        arm = wb.limb(body, "right hand")
        one = wb.reach(body, row(seated, b), TARGETS[:3], limb=arm, environment=own)
        assert list(found.reached[b]) == list(one.reached[0])
        easy = one.reached[0]
        np.testing.assert_allclose(found.miss[b, easy], one.miss[0, easy], atol=1e-4)
        met = wb.contacts(wb.place(body, row_poses(found, b)), own)
        met = met.rows(arm.solid[0, met.sphere] & (met.excess > 0))
        assert set(met.pose) <= set(np.flatnonzero(found.overlap[b] > 0))


def row_poses(found, b):
    """The postures found for one person, as of a body of one row."""
    count = found.reached.shape[1]
    poses = found.poses.rows(slice(b * count, (b + 1) * count))
    return wb.Poses(poses.rotations, poses.reference, poses.world_from_reference)


def test_bodies_of_other_families_and_wrong_numbers_of_rows_are_refused(people, seated, one_arm):
    arm = wb.limb(people, "right hand")
    with pytest.raises(wb.UsageError, match="poses: expected 2 rows for 2 bodies"):
        wb.reach(people[:2], seated, TARGETS, limb=wb.limb(people[:2], "right hand"))
    with pytest.raises(wb.UsageError, match="limb: expected one of a body of 1 row"):
        wb.reach(people[0], row(seated, 0), TARGETS, limb=arm)
    with pytest.raises(wb.UsageError, match="displacement: expected shape"):
        wb.reach(people, seated, TARGETS, limb=arm, displacement=np.zeros((2, 3)))
    with pytest.raises(wb.UsageError, match="finite points"):
        wb.reach(people, seated, TARGETS[:, :2], limb=arm)
    with pytest.raises(wb.UsageError, match="rows of one body, they differ in segments or joints"):
        wb.stack_bodies([people, one_arm])
