"""Studies: seats, standing places, adjustments, and each criterion at its limit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.conftest import ONE_ARM, box_part, environment_of
from tests.made_studies import found_of, made_study
from workbench.model.criterion import Criterion
from workbench.model.environment import Allowance, Rest, Seat
from workbench.model.workplace import Stand
from workbench.posture.seating.seating import seat_planes
from workbench.study.people import present_people


def seat(**changes):
    base = Seat(
        name="left",
        srp=(1.0, 0.5, 0.4),
        back_angle=np.radians(15),
        cushion_angle=np.radians(7),
        yaw=0.0,
        cushion=Rest("pan", ("LT", "LUL", "RUL"), 0.02),
        back=Rest("back", ("LT", "CT", "UT"), 0.015),
        travel_forward=(-0.1, 0.1),
        travel_up=(-0.05, 0.05),
        moves=("pan",),
    )
    return replace(base, **changes)


@pytest.mark.parametrize("yaw", [0.0, 90.0, 180.0, -35.0])
def test_a_sitter_sinks_into_cushion_and_back_by_exactly_the_stated_depth(bubbleman, yaw):
    place = seat(yaw=np.radians(yaw))
    legs = {"LH": {"flexion": 90}, "RH": {"flexion": 90}}
    poses = wb.pose(bubbleman, legs, reference="LT")
    placed = wb.place(bubbleman, wb.seat(bubbleman, poses, place).poses)
    cushion, back, centre = seat_planes(place)
    for normal, rest in ((cushion, place.cushion), (back, place.back)):
        rows = np.isin(bubbleman.sphere_segment, [bubbleman.segment(s) for s in rest.segments])
        low = (
            placed.centres[0, rows] @ normal - bubbleman.radius[0, rows]
        ).min() - normal @ np.array(place.srp)
        assert low == pytest.approx(-rest.depth, abs=1e-12)
    origin = placed.world_from_segment[0, bubbleman.segment("LT"), :, 3]
    assert centre @ (origin - np.array(place.srp)) == pytest.approx(0, abs=1e-12)


def study(one_arm, *criteria, environment=None, stand=(0.0, 0.0, 0.0), other=None, angles=None):
    """One arm (and perhaps another) in a box cab, one case."""
    cab = environment or environment_of(
        box_part("floor", [-1, -1, -0.1], [1, 1, 0]), box_part("wall", [0.5, -1, 0], [0.6, 1, 1])
    )
    people = {"arm": ({"body": one_arm, "stand": Stand(stand)}, wb.pose(one_arm, angles or {}))}
    if other is not None:
        people["twin"] = ({"body": one_arm, "stand": Stand(other)}, wb.pose(one_arm, {}))
    return made_study(cab, people, criteria)


def criterion(
    check, *, at_least=0.0, segments=None, parts=("floor", "wall"), people=("arm", "twin")
):
    return Criterion(
        check, check, people, segments or ("BASE", "UPPER", "LOWER", "HAND"), parts, at_least
    )


def only(result):
    return result.verdicts[0]


def test_standing_puts_the_lowest_sphere_on_the_point(one_arm):
    room = environment_of(box_part("b", [0, 0, 0], [1, 1, 1]))
    there = present_people(study(one_arm, environment=room, stand=(0.1, 0.2, 0.3)))
    placed = there.situations[0][0].placed
    assert (placed.centres[0, :, 2] - one_arm.radius[0]).min() == pytest.approx(0.3)
    assert placed.world_from_segment[0, 0, :2, 3] == pytest.approx([0.1, 0.2])


def test_touching_the_floor_is_no_fault_and_one_micrometre_into_it_is(one_arm):
    assert found_of(study(one_arm, criterion("contact"))).passed
    assert not found_of(study(one_arm, criterion("contact"), stand=(0, 0, -1e-6))).passed


def test_allowed_contact_passes_down_to_its_depth(one_arm):
    cab = environment_of(box_part("floor", [-1, -1, -0.1], [1, 1, 0]))
    cab = replace(cab, allowances=(Allowance(0, ("HAND",), 0.01),))
    made = [
        study(one_arm, criterion("contact", parts=("floor",)), environment=cab, stand=(0, 0, -d))
        for d in (0.009, 0.011)
    ]
    assert [found_of(s).passed for s in made] == [True, False]


def test_clearance_is_judged_against_its_limit(one_arm):
    # the base of 50 mm at x = 0 and the wall at 500 mm
    assert found_of(study(one_arm, criterion("clearance", at_least=0.449, parts=("wall",)))).passed
    failed = only(found_of(study(one_arm, criterion("clearance", at_least=0.451, parts=("wall",)))))
    assert not failed.passed
    assert failed.worst.value == pytest.approx(0.45)
    assert failed.worst.subject in {"base (front)", "lower arm (front)"}


def test_clearance_of_segments_looks_at_those_alone(one_arm):
    found = only(
        found_of(
            study(
                one_arm, criterion("clearance", segments=("HAND",), at_least=0.1, parts=("wall",))
            )
        )
    )
    assert found.worst.value == pytest.approx(0.5 - 0.03 - 0.015)


def test_self_contact_counts_from_the_allowance(one_arm):
    folded = study(one_arm, criterion("self_contact"), angles={"ELBOW": {"flexion": 178}})
    found = only(found_of(folded))
    assert not found.passed
    assert {f.target.split(",")[0].split(" (")[0] for f in found.breaches} <= {"lower arm", "hand"}


def test_two_people_are_kept_apart(one_arm):
    near = only(
        found_of(study(one_arm, criterion("between_people", at_least=0.05), other=(0, 0.14, 0)))
    )
    far = only(
        found_of(study(one_arm, criterion("between_people", at_least=0.05), other=(0, 0.16, 0)))
    )
    assert (near.passed, far.passed) == (False, True)
    assert near.worst.value == pytest.approx(0.04)
    assert near.worst.other_person == "twin"


def test_stops_are_judged_in_radians_and_warned_about(one_arm):
    result = found_of(study(one_arm, criterion("stops"), angles={"SHOULDER": {"extension": 25}}))
    assert not result.passed
    assert only(result).worst.value == pytest.approx(np.radians(-5), abs=1e-9)
    assert any("5.0 degrees past its stop in extension" in w for w in result.warnings)


def test_a_seat_adjusted_moves_its_sitter_and_its_parts(bubbleman):
    cab = environment_of(
        box_part("pan", [0.9, 0.2, 0.2], [1.5, 0.8, 0.3]),
        box_part("wall", [2.5, 0, 0], [2.6, 1, 1]),
    )
    cab = replace(cab, seats=(seat(),))
    pose = wb.pose(bubbleman, {}, reference="LT")
    role = {"body": bubbleman, "seat": "left"}
    still, ahead = (
        present_people(made_study(cab, {"p": (fields, pose)}, []))
        for fields in (role, {**role, "forward": 0.05, "up": 0.02})
    )
    before, after = (there.situations[0][0].placed.centres for there in (still, ahead))
    assert after - before == pytest.approx(np.broadcast_to([0.05, 0, 0.02], before.shape))
    moved = ahead.environment
    assert moved.vertices[:8] - cab.vertices[:8] == pytest.approx(
        np.broadcast_to([0.05, 0, 0.02], (8, 3))
    )
    assert np.array_equal(moved.vertices[8:], cab.vertices[8:])


def test_a_body_swallowed_by_a_solid_is_warned_about(one_arm):
    cabin = environment_of(box_part("cabin", [-2, -2, -2], [2, 2, 2]))
    result = found_of(study(one_arm, criterion("contact", parts=("cabin",)), environment=cabin))
    assert any("whole body is inside the solid part 'cabin'" in w for w in result.warnings)


def test_the_body_of_a_study_need_not_have_20_segments(tmp_path):
    tail = ONE_ARM.replace(
        "allowances:",
        """  TIP:
    name: tip
    number: 4
    between: [HAND, TAIL]
    at: {HAND: [0, 0, -50], TAIL: [0, 0, 0]}
    stop: free
    swing:
      - {motion: [up, down], axis: +y, limits: [90, 90]}
      - {motion: [left, right], axis: -x, limits: [90, 90]}
    twist: {motion: [in, out], axis: +z, limits: [10, 10]}
allowances:""",
    )
    tool = (
        "  TAIL: {name: tool, number: 5, mass: 0.1, directions: {front: +x, left: +y, top: +z},"
        " spheres: [[0, 0, -200, 5, tool tip, bottom]]}\n"
    )
    tail = tail.replace("joints:", tool + "joints:", 1)
    path = tmp_path / "tail.yaml"
    path.write_text(tail)
    body = wb.load_body(path)
    assert body.segments == ("BASE", "UPPER", "LOWER", "HAND", "TAIL")
    assert wb.place(body, wb.pose(body, {})).centres[0, -1] == pytest.approx([0, 0, -0.8])
