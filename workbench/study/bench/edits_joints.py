"""Edits of joints: one is turned, or all are mirrored."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.model.posing import compose
from workbench.model.study import GivenPosture, PredictedPosture
from workbench.model.units import plain
from workbench.posture.reaching.limbs import limb
from workbench.posture.stops import nearest_legal, stop_limits
from workbench.study.bench.edits import Edit, held_seat
from workbench.study.bench.placing import Placement
from workbench.study.bench.state import Arrangement, PersonState, given_angles

__all__ = ["as_given", "given_since", "let_go", "mirrored", "poses_in", "turned", "with_angles"]

ANGLE_STEP = 0.1
"""[degrees]"""
MOST_DEGREES = 180.0
"""A joint turned farther would stand as if it were turned the other way."""


def turned(placement: Placement, person: str, joint: str, axis: int, degrees: float) -> Edit:
    """Turn a joint about one of its axes.

    Parameters
    ----------
    placement
        The state, and where its people are.
    axis
        0 and 1 swing, 2 twist.
    degrees
        In the first sense of the axis.

    Returns
    -------
    Edit
        The words say how far the angle is beyond its stop, where it is.

    Raises
    ------
    InputError
        If the person, the joint or the axis is not there or locked, or the angle beyond half a turn.
    """
    arrangement = placement.arrangement
    row = arrangement.row(person)
    body = arrangement.body(row)
    j = _joint(body, joint)
    if axis not in (0, 1, 2):
        raise InputError(f"a joint has axes 0, 1 and 2, got {axis!r}")
    if body.stops.locked[j, axis]:
        raise InputError(f"{body.joint_names[j]} does not turn about this axis")
    if not abs(degrees) <= MOST_DEGREES:
        raise InputError(f"{joint}: an angle of -180 to 180 degrees is possible, got {degrees:g}")
    before = let_go(placement, row, as_given(placement, row), [j])
    angles = given_angles(body, poses_in(before, arrangement.case))
    wanted = angles.copy()
    wanted[j, axis] = np.radians(degrees)
    after = with_angles(before, arrangement.case, angles, wanted)
    shown = given_angles(body, poses_in(after, arrangement.case))
    return Edit(arrangement.with_person(row, after), _stop_words(body, shown, j, axis))


def _joint(body: Body, name: str) -> int:
    if name not in body.joints:
        raise InputError(f"body {body.name} has no joint {name!r}; {one_of(name, body.joints)}")
    return body.joint(name)


def _stop_words(body: Body, angles: Floats, joint: int, axis: int) -> str:
    """How far an angle is beyond its stop, in words; "" within."""
    up, down = stop_limits(body, angles[None])[0, joint, axis]
    angle = float(angles[joint, axis])
    beyond = max(angle - up, -angle - down)
    if not body.stops.kind[joint] or beyond < np.radians(ANGLE_STEP / 2):
        return ""
    motion = plain(body.stops.motions[joint][axis][int(angle < 0)])
    return (
        f"{body.joint_names[joint]}: {np.degrees(beyond):.1f} degrees beyond the stop of {motion}"
    )


def mirrored(placement: Placement, person: str) -> Edit:
    """Exchange left and right in the angles of a person, each within its stops.

    Returns
    -------
    Edit
        The words name the joints that stay at a stop.

    Raises
    ------
    InputError
        If the person is not there, or a joint of the body has no counterpart.
    """
    arrangement = placement.arrangement
    row = arrangement.row(person)
    body = arrangement.body(row)
    before = let_go(placement, row, as_given(placement, row), range(len(body.joints)))
    angles = given_angles(body, poses_in(before, arrangement.case))
    goal = _mirrored_angles(body, angles)
    poses = poses_in(before, arrangement.case)
    turns = Poses(compose(body, goal)[None], poses.reference, poses.world_from_reference)
    legal = given_angles(body, replace(turns, rotations=nearest_legal(body, turns)))
    stopped = np.abs(legal - goal).max(axis=1) > np.radians(ANGLE_STEP / 2)
    # toward zero, so that a stop is not passed by what is rounded
    steps = np.trunc(np.degrees(legal) / ANGLE_STEP + 1e-6 * np.sign(legal)) * ANGLE_STEP
    goal[stopped] = np.radians(steps)[stopped]
    after = with_angles(before, arrangement.case, angles, goal)
    names = [body.joint_names[j] for j in np.flatnonzero(stopped)]
    words = f"mirrored; at the stop: {', '.join(names)}" if names else "mirrored"
    return Edit(arrangement.with_person(row, after), words)


def _mirrored_angles(body: Body, angles: Floats) -> Floats:
    """(J, 3) [rad] the angles with left and right exchanged."""
    found = np.empty_like(angles)
    for j, name in enumerate(body.joints):
        other = _counterpart(body, name)
        mirror = [tuple(map(_other_side, pair)) for pair in body.stops.motions[other]]
        for axis, pair in enumerate(body.stops.motions[j]):
            if tuple(pair) in mirror:
                found[j, axis] = angles[other, mirror.index(tuple(pair))]
            elif tuple(pair[::-1]) in mirror:
                found[j, axis] = -angles[other, mirror.index(tuple(pair[::-1]))]
            else:
                raise InputError(f"{body.joint_names[j]} of body {body.name} cannot be mirrored")
    return found


def _counterpart(body: Body, name: str) -> int:
    """The joint of the other side, the same one in the middle of the body."""
    swapped = {"L": "R", "R": "L"}.get(name[0], name[0]) + name[1:]
    words = _other_side(body.joint_names[body.joint(name)].replace(" ", "_"))
    paired = swapped in body.joints
    if paired and body.joint_names[body.joint(swapped)].replace(" ", "_") == words:
        return body.joint(swapped)
    return body.joint(name)


def _other_side(words: str) -> str:
    """Words that are joined by underscores, with left and right exchanged."""
    swap = {"left": "right", "right": "left"}
    return "_".join(swap.get(word, word) for word in words.split("_"))


def poses_in(person: PersonState, case: int) -> Poses:
    """The pose of a person whose posture in a case is given."""
    action = person.actions[case]
    assert isinstance(action, GivenPosture)
    return action.poses


def as_given(placement: Placement, row: int) -> PersonState:
    """A person whose posture in the case is given: of a predicted one as it came out, with the seat
    held where it stands."""
    arrangement = placement.arrangement
    person = arrangement.people[row]
    action = person.actions[arrangement.case]
    if isinstance(action, GivenPosture):
        return person
    assert isinstance(action, PredictedPosture)
    there = placement.people[row]
    base = given_angles(there.body, action.poses)
    held = held_seat(placement, row)
    person = held.doing(arrangement.case, GivenPosture(action.like, action.poses))
    goal = given_angles(there.body, there.poses)
    return with_angles(person, arrangement.case, base, goal)


def given_since(before: Arrangement, after: Arrangement) -> str:
    """Say whose posture was predicted before and is given after, "" where nobody's is.

    Both states have the same people and cases. It is the case of the state after that counts.
    """
    case = after.case
    changed = [
        (was, now)
        for was, now in zip(before.people, after.people, strict=True)
        if was.actions  # none where all cases are motions
        and isinstance(was.actions[case], PredictedPosture)
        and isinstance(now.actions[case], GivenPosture)
    ]
    if not changed:
        return ""
    names = " and ".join(now.role for _, now in changed)
    held = ", the seat held" if any(was.free and not now.free for was, now in changed) else ""
    return f"{names}: no longer predicted; the posture is given{held}"


def let_go(
    placement: Placement, row: int, person: PersonState, joints: Iterable[int]
) -> PersonState:
    """A person whose hands let go of the controls for which any of some joints is solved; the
    joints stay where they are shown.

    Parameters
    ----------
    person
        The person of a row with a given posture in the case.
    """
    case = placement.arrangement.case
    action = person.actions[case]
    assert isinstance(action, GivenPosture)
    wanted = set(joints)
    there = placement.people[row]
    controls = {one.name: one for one in placement.parts.environment.controls}
    for hand, name in action.hands.items():
        control = controls[name]
        free = list(limb(there.body, hand, grip=control.grip, zone=control.zone).free)
        if not wanted.intersection(free):
            continue
        before = given_angles(there.body, poses_in(person, case))
        goal = before.copy()
        goal[free] = given_angles(there.body, there.poses)[free]
        person = with_angles(person, case, before, goal)
        held = person.actions[case]
        assert isinstance(held, GivenPosture)
        kept = {key: value for key, value in held.hands.items() if key != hand}
        person = person.doing(case, replace(held, hands=kept))
    return person


def with_angles(person: PersonState, case: int, before: Floats, goal: Floats) -> PersonState:
    """A person with other angles (J, 3) [rad] in a case, in steps of ANGLE_STEP; joints that are
    nearer to where they were than half a step stay."""
    degrees = np.round(np.degrees(goal) / ANGLE_STEP) * ANGLE_STEP
    changed = np.abs(degrees - np.degrees(before)) > ANGLE_STEP / 2
    if not changed.any():
        return person
    angles = np.where(changed, np.radians(np.round(degrees, 1)), before)
    poses = poses_in(person, case)
    rotations = poses.rotations.copy()
    joints = changed.any(axis=1)
    rotations[0, joints] = compose(person.figure.body, angles)[joints]
    action = person.actions[case]
    assert isinstance(action, GivenPosture)
    turned_poses = Poses(rotations, poses.reference, poses.world_from_reference)
    return person.doing(case, replace(action, poses=turned_poses))
