"""Edits of joints and limbs: a joint is turned, all are mirrored, a hand or foot goes to a target or
takes hold of a control."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.criterion import short_words
from workbench.model.environment import Control
from workbench.model.joint_angles import compose
from workbench.model.poses import Poses
from workbench.model.reach import Reach
from workbench.model.study import GivenPosture, PredictedPosture
from workbench.model.units import plain
from workbench.posture.reaching.limbs import FEET, HANDS, limb
from workbench.posture.reaching.reach import reach
from workbench.posture.stops import nearest_legal, stop_limits
from workbench.study.bench.edits import FARTHEST, Edit, held_seat
from workbench.study.bench.placing import Placement, controls_there, placed_environment
from workbench.study.bench.state import (
    Arrangement,
    OpenStudy,
    PersonState,
    given_angles,
)

__all__ = [
    "LimbTarget",
    "as_given",
    "given_since",
    "let_go",
    "mirrored",
    "poses_in",
    "reached",
    "turned",
    "with_angles",
]

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


@dataclass(frozen=True)
class LimbTarget:
    """Where a hand or foot is to go.

    Parameters
    ----------
    limb
        "left hand", "right hand", "left foot" or "right foot".
    at
        (3,) [m] in the world; None where `control` says it.
    control
        The name of a control that is taken hold of, with its own grip and up to its own zone.
    grip
        As of `limb`, for a target; the first of the limb if None.
    zone
        Harness zone 1, 2 or 3, for a target.
    obstacles
        Whether parts and other people are kept clear of.
    """

    limb: str
    at: tuple[float, float, float] | None = None
    control: str = ""
    grip: str | None = None
    zone: int = 1
    obstacles: bool = False


def reached(opened: OpenStudy, placement: Placement, person: str, wanted: LimbTarget) -> Edit:
    """Bring a hand or foot to a target or a control, as near as the joint stops allow.

    A hand that takes hold of a control holds it from then on: the arm is solved anew whenever
    anything else is another. So does a foot of a posture that is predicted. A posture that is
    predicted becomes a given one where a limb goes to any other target.

    Returns
    -------
    Edit
        The words say by how much the target is missed and what limits the limb, where it is.

    Raises
    ------
    InputError
        If the person, limb, control, grip or zone is not there, or the target is too far off.
    """
    arrangement = placement.arrangement
    row = arrangement.row(person)
    body = arrangement.body(row)
    found = _solved(opened, placement, row, wanted)
    action = arrangement.people[row].actions[arrangement.case]
    if isinstance(action, PredictedPosture) and _may_hold(opened, wanted):
        return Edit(_holding(arrangement, row, action, wanted), _reach_words(found, wanted))
    if isinstance(action, GivenPosture) and wanted.limb in HANDS and wanted.control:
        after = arrangement.people[row]
        if action.hands.get(wanted.limb) != wanted.control:
            held = replace(action, hands={**action.hands, wanted.limb: wanted.control})
            after = after.doing(arrangement.case, held)
        return Edit(arrangement.with_person(row, after), _reach_words(found, wanted))
    free = list(found.free)
    before = let_go(placement, row, as_given(placement, row), free)
    angles = given_angles(body, poses_in(before, arrangement.case))
    goal = angles.copy()
    solution = given_angles(body, found.poses)
    goal[free] = solution[free]
    after = with_angles(before, arrangement.case, angles, goal)
    return Edit(arrangement.with_person(row, after), _reach_words(found, wanted))


def _may_hold(opened: OpenStudy, wanted: LimbTarget) -> bool:
    """Whether a prediction can hold the control: with a foot a pedal, with a hand anything else."""
    controls = {one.name: one for one in opened.study.environment.controls}
    return bool(wanted.control) and controls[wanted.control].is_for(wanted.limb)


def _holding(
    arrangement: Arrangement, row: int, action: PredictedPosture, wanted: LimbTarget
) -> Arrangement:
    """A state in which the prediction of a person holds a control with a limb."""
    if action.aims.controls.get(wanted.limb) == wanted.control:
        return arrangement
    aims = replace(action.aims, controls={**action.aims.controls, wanted.limb: wanted.control})
    person = arrangement.people[row].doing(arrangement.case, replace(action, aims=aims))
    return arrangement.with_person(row, person)


def _solved(opened: OpenStudy, placement: Placement, row: int, wanted: LimbTarget) -> Reach:
    """The reach to a target; to a control in the tightest harness zone that will do."""
    body = placement.people[row].body
    poses = placement.people[row].poses
    environment = placed_environment(opened, placement)
    others = [one.bystander for k, one in enumerate(placement.people) if k != row]
    controls = controls_there(opened, environment, row, placement.people[row].shift)
    target, grip, zones = _aimed(controls, wanted)
    for zone in zones:
        found = reach(
            body,
            poses,
            [target],
            limb=limb(body, wanted.limb, grip=grip, zone=zone),
            environment=environment if wanted.obstacles else None,
            moving_parts=[environment.parts[k] for k in opened.movers[row]],
            displacement=placement.people[row].shift[None],
            bystanders=others if wanted.obstacles else (),
            initial=poses,
            restarts=0,
            tighter_zones=len(zones) == 1,  # the zones before have missed it
            thorough=bool(wanted.control),  # a hand that is dragged is asked again at once
        )
        if found.reached[0, 0]:
            break
    return found


def _aimed(
    controls: Sequence[Control], wanted: LimbTarget
) -> tuple[tuple[float, float, float], str | None, Sequence[int]]:
    """The target of a limb, its grip, and the harness zones that are tried in turn."""
    if wanted.control:
        control = next((one for one in controls if one.name == wanted.control), None)
        if control is None:
            valid = one_of(wanted.control, [one.name for one in controls])
            raise InputError(f"no control {wanted.control!r}; {valid}")
        foot = wanted.limb in FEET
        if control.limbs == "feet" and not foot:
            raise InputError(f"{control.name} is for feet, not for the {wanted.limb}")
        grip = "ball" if foot else control.grip
        return control.at, grip, (1,) if foot else range(1, control.zone + 1)
    if wanted.at is None:
        raise InputError(f"{wanted.limb}: a target or a control is needed")
    if not max(map(abs, wanted.at)) <= FARTHEST:
        raise InputError(f"{wanted.limb}: a target within {FARTHEST:g} m of the origin is needed")
    return wanted.at, wanted.grip, (wanted.zone,)


def _reach_words(found: Reach, wanted: LimbTarget) -> str:
    """By how much a limb misses its target and why, or what it holds."""
    if found.reached[0, 0]:
        return f"{wanted.limb} on {wanted.control}" if wanted.control else ""
    miss, overlap = float(found.miss[0, 0]), float(found.overlap[0, 0])
    goal = wanted.control or "the target"
    return short_words(wanted.limb, goal, miss, overlap, found.reason(0, 0))
