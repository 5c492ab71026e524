"""Rows of a body: many people of one topology, each the same as alone."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

import workbench as wb
from workbench.contact.collide import nearest, self_clearance
from workbench.model.body import ROW_FIELDS
from workbench.posture.reaching.limbs import limb
from workbench.posture.reaching.packing import packed_limbs, packed_links


@pytest.fixture(scope="module")
def three(one_arm):
    """One arm in three sizes."""
    sizes = np.array([0.9, 1.0, 1.2])
    lengths = ("joint_in_parent", "joint_in_child", "centre", "radius", "twist_point")
    return wb.stack_bodies(
        [replace(one_arm, **{name: s * getattr(one_arm, name) for name in lengths}) for s in sizes]
    )


@pytest.fixture
def mixed(random_arm):
    """Eight poses of the three, in no order."""
    return replace(random_arm(8, 3), person=np.array([2, 0, 0, 1, 2, 2, 1, 0]))


def test_rows_are_taken_by_number_slice_and_numbers_and_share_the_topology(three):
    assert [len(three), len(three[0]), len(three[1:]), len(three[[2, 0]])] == [3, 1, 2, 2]
    assert all(
        one.topology is three.topology for one in (three[1], three[:2], three[[0, 2]], *three)
    )
    assert all(
        np.array_equal(three[[2, 0]].radius[k], three[n].radius[0]) for k, n in enumerate((2, 0))
    )
    assert three[-1].radius[0, 0] == three.radius[2, 0] and three[0][0] is not three
    assert three[:] is three
    with pytest.raises(IndexError, match="no row 3; it has 3"):
        three[3]


def test_a_stack_has_the_rows_of_its_bodies(three, one_arm):
    again = wb.stack_bodies([three[:1], three[1:]])
    for name in ROW_FIELDS:
        assert np.array_equal(getattr(again, name), getattr(three, name), equal_nan=True)
    assert wb.stack_bodies([one_arm]) is one_arm


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"sphere_names": ("",) * 10}, "spheres"),
        ({"segments": ("A", "B", "C", "D")}, "segments or joints"),
        ({"twist_joint": np.full(4, -1)}, "twist_joint"),
    ],
)
def test_bodies_of_other_topologies_cannot_be_stacked(one_arm, change, words):
    other = replace(one_arm, name="other", topology=replace(one_arm.topology, **change))
    with pytest.raises(wb.UsageError, match=f"'one_arm' and 'other' .* differ in {words}"):
        wb.stack_bodies([one_arm, other])


def test_poses_of_many_people_are_placed_as_each_alone_to_the_last_bit(three, mixed):
    placed = wb.place(three, mixed)
    assert placed.person.tolist() == mixed.person.tolist()
    for p, b in enumerate(mixed.person):
        alone = wb.place(three[int(b)], replace(mixed.rows(slice(p, p + 1)), person=None))
        assert np.array_equal(placed.centres[p], alone.centres[0])
        assert np.array_equal(placed.world_from_segment[p], alone.world_from_segment[0])


def test_a_pose_for_each_row_needs_no_person_and_other_numbers_do(three, random_arm):
    assert wb.place(three, random_arm(3, 1)).person.tolist() == [0, 1, 2]
    with pytest.raises(wb.UsageError, match="expected 3 rows for 3 bodies, or `person`"):
        wb.place(three, random_arm(2, 1))
    with pytest.raises(wb.InputError, match="has 3 rows, counted from 0, got 3"):
        wb.place(three, replace(random_arm(2, 1), person=np.array([0, 3])))


@pytest.mark.parametrize(
    "ask",
    [
        wb.contacts,
        nearest,
        wb.clearance,
        wb.collides,
        lambda placed, room: self_clearance(placed),
        lambda placed, room: wb.self_contacts(placed, margin=0.2),
        lambda placed, room: wb.body_clearance(placed, placed),
    ],
)
def test_contacts_of_many_people_are_those_of_each_alone(three, mixed, box_cab, ask):
    placed = wb.place(three, mixed)
    whole = _arrays(ask(placed, box_cab))
    for b, body in enumerate(three):
        rows = np.flatnonzero(mixed.person == b)
        alone = _arrays(ask(wb.place(body, replace(mixed.rows(rows), person=None)), box_cab))
        pose = whole.get("pose")
        some = rows if pose is None else np.flatnonzero(np.isin(pose, rows))
        if pose is not None:
            alone["pose"] = rows[alone["pose"]]
        assert all(np.array_equal(whole[name][some], alone[name], equal_nan=True) for name in alone)


def _arrays(answer):
    """The arrays of an answer by name."""
    if isinstance(answer, np.ndarray):
        return {"": answer}
    named = {field.name: getattr(answer, field.name) for field in fields(answer)}
    return {name: value for name, value in named.items() if isinstance(value, np.ndarray)}


@pytest.mark.parametrize("rows", [[1], [2, 0], [0, 2, 2, 1, 0]])
@pytest.mark.parametrize("name", ["left hand", "right foot"])
def test_what_is_packed_of_some_rows_is_the_same_whether_or_not_they_were_taken_from_a_body(
    bubbleman, rows, name
):
    whole = wb.stack_bodies(
        [replace(bubbleman, radius=s * bubbleman.radius) for s in (0.9, 1.0, 1.1)]
    )
    some = whole[[2, 1, 0]][rows]
    alone = replace(some)
    assert some.source is not None and alone.source is None
    zone = 3 if name == "left hand" else 1
    own, other = (limb(body, name, zone=zone) for body in (some, alone))
    assert np.array_equal(own.tip, other.tip) and np.array_equal(own.solid, other.solid)
    for pack in (packed_links, packed_limbs):
        for one, same in zip(pack(some, own), pack(alone, other), strict=True):
            if isinstance(one, np.ndarray):
                assert (
                    np.array_equal(one, same) and one.flags.c_contiguous == same.flags.c_contiguous
                )
    with_other_tip = replace(own, tip=own.tip + 0.01)
    assert np.array_equal(packed_links(some, with_other_tip).tip, with_other_tip.tip)
