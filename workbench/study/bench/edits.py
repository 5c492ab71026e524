"""Edits of an open study: each takes a state and returns another one, and says in words what it did.

Angles are set to 0.1 degrees and seats to 0.1 mm, so that a state is exactly what its file says
once it is saved. An edit within this of what stands changes nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.environment import Control
from workbench.model.moves import Move
from workbench.model.poses import Poses
from workbench.model.posing import compose
from workbench.model.reach import Reach
from workbench.model.study import GivenPosture, PredictedPosture
from workbench.posture.reaching.limbs import FEET, limb
from workbench.posture.reaching.reach import reach
from workbench.posture.stops import stop_limits
from workbench.study.bench.placing import Placement
from workbench.study.bench.state import (
    Arrangement,
    OpenStudy,
    PersonState,
    arranged_environment,
    given_angles,
)

__all__ = ["Edit", "LimbTarget", "looking_at", "reached", "seated", "shifted", "turnable", "turned"]

ANGLE_STEP = 0.1
"""[degrees]"""
LENGTH_STEP = 1e-4
"""[m]"""
MOST_DEGREES = 180.0
"""A joint turned farther would stand as if it were turned the other way."""
FARTHEST = 10.0
"""[m] Targets are no farther than this from the world's origin."""


@dataclass(frozen=True, eq=False)
class Edit:
    """What an edit came to: the state, and in words what it did, "" where that is plain to see."""

    arrangement: Arrangement
    words: str = ""


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
        Whether parts are kept clear of.
    """

    limb: str
    at: tuple[float, float, float] | None = None
    control: str = ""
    grip: str | None = None
    zone: int = 1
    obstacles: bool = False


def turnable(body: Body, angles: Floats) -> Floats:
    """(J, 3, 2) [rad] how far each angle may go up and down; (0, 0) of axes that are locked.

    Parameters
    ----------
    angles
        (J, 3) [rad], on which coupled stops depend.
    """
    limits: Floats = stop_limits(body, angles[None])[0]
    return limits


def turned(
    opened: OpenStudy, placement: Placement, person: str, joint: str, axis: int, degrees: float
) -> Edit:
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
    body = opened.body(row)
    j = _joint(body, joint)
    if axis not in (0, 1, 2):
        raise InputError(f"a joint has axes 0, 1 and 2, got {axis!r}")
    if body.stops.kind[j] and body.stops.limits[j, axis].max() < 1e-6:
        raise InputError(f"{body.joint_names[j]} does not turn about this axis")
    if not abs(degrees) <= MOST_DEGREES:
        raise InputError(f"{joint}: an angle of -180 to 180 degrees is possible, got {degrees:g}")
    before = _as_given(opened, placement, row)
    angles = given_angles(body, _poses(before, arrangement.case))
    wanted = angles.copy()
    wanted[j, axis] = np.radians(degrees)
    after = _with_angles(opened, before, row, arrangement.case, angles, wanted)
    shown = given_angles(body, _poses(after, arrangement.case))
    return Edit(arrangement.with_person(row, after), _stop_words(body, shown, j, axis))


def _joint(body: Body, name: str) -> int:
    if name not in body.joints:
        raise InputError(f"body {body.name} has no joint {name!r}; {one_of(name, body.joints)}")
    return body.joint(name)


def _stop_words(body: Body, angles: Floats, joint: int, axis: int) -> str:
    """How far an angle is beyond its stop, in words; "" within."""
    up, down = turnable(body, angles)[joint, axis]
    angle = float(angles[joint, axis])
    beyond = max(angle - up, -angle - down)
    if not body.stops.kind[joint] or beyond < np.radians(ANGLE_STEP / 2):
        return ""
    motion = body.stops.motions[joint][axis][int(angle < 0)].replace("_", " ")
    return (
        f"{body.joint_names[joint]}: {np.degrees(beyond):.1f} degrees beyond the stop of {motion}"
    )


def reached(opened: OpenStudy, placement: Placement, person: str, wanted: LimbTarget) -> Edit:
    """Bring a hand or foot to a target or a control, as near as the joint stops allow.

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
    body = opened.body(row)
    found = _solved(opened, placement, row, wanted)
    before = _as_given(opened, placement, row)
    angles = given_angles(body, _poses(before, arrangement.case))
    goal = angles.copy()
    solution = given_angles(body, found.poses)
    free = list(found.free)
    goal[free] = solution[free]
    after = _with_angles(opened, before, row, arrangement.case, angles, goal)
    return Edit(arrangement.with_person(row, after), _reach_words(found, wanted))


def _solved(opened: OpenStudy, placement: Placement, row: int, wanted: LimbTarget) -> Reach:
    """The reach to a target; to a control in the tightest harness zone that will do."""
    body = opened.body(row)
    poses = placement.people[row].poses
    environment = arranged_environment(opened, placement.arrangement.moves)
    target, grip, zones = _aimed(environment.controls, wanted)
    for zone in zones:
        found = reach(
            body,
            poses,
            [target],
            limb=limb(body, wanted.limb, grip=grip, zone=zone),
            environment=environment if wanted.obstacles else None,
            moving_parts=[environment.parts[k] for k in opened.movers[row]],
            displacement=placement.people[row].shift[None],
            initial=poses,
            restarts=0,
            tighter_zones=len(zones) == 1,  # the zones before have missed it
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
    limit = found.limit(0, 0)
    why = f", limited by {limit}" if limit else ""
    overlap = float(found.overlap[0, 0])
    depth = f", {1e3 * overlap:.0f} mm in an obstacle" if overlap > 0 else ""
    goal = wanted.control or "the target"
    return f"the {wanted.limb} stays {1e3 * float(found.miss[0, 0]):.0f} mm from {goal}{depth}{why}"


def seated(
    opened: OpenStudy, arrangement: Arrangement, person: str, forward: float, up: float
) -> Edit:
    """Put a person's seat into a position within its travel.

    Parameters
    ----------
    forward, up
        [m] from where the seat stands at rest.

    Raises
    ------
    InputError
        If the person is not there or has no seat, or the position is beyond its travel.
    """
    row = arrangement.row(person)
    seat = opened.seat(row)
    if seat is None:
        raise InputError(f"{person} is in no seat")
    state = arrangement.people[row]
    values = []
    for way, given, (low, high) in (
        ("forward", forward, seat.travel_forward),
        ("up", up, seat.travel_up),
    ):
        if not low - 1e-9 <= given <= high + 1e-9:
            travel = f"{1000 * low:g} to {1000 * high:g} mm"
            raise InputError(
                f"{way}: the travel of seat {seat.name} is {travel}, got {1000 * given:g} mm"
            )
        values.append(min(max(rounded(given, LENGTH_STEP), low), high))
    same = np.abs(np.array(values) - (state.forward, state.up)).max() < LENGTH_STEP / 2
    if same and not state.free:
        return Edit(arrangement)
    after = replace(state, free=False, forward=values[0], up=values[1])
    return Edit(arrangement.with_person(row, after))


def shifted(opened: OpenStudy, arrangement: Arrangement, wanted: Move) -> Edit:
    """Put parts, with the controls on them, or controls alone, elsewhere.

    Parameters
    ----------
    wanted
        By how much from where the environment's file has them, in all: what else was said of them
        is forgotten.

    Returns
    -------
    Edit
        The words name the controls that go along.

    Raises
    ------
    InputError
        If nothing is named, a part or control is not there or goes with a seat, or the move is too
        far.
    """
    environment = opened.study.environment
    if bool(wanted.parts) == bool(wanted.controls):
        raise InputError("parts or controls must be named, one of the two")
    controls = [control.name for control in environment.controls]
    for name in wanted.controls:
        if name not in controls:
            raise InputError(f"no control {name!r}; {one_of(name, controls)}")
    riding = {name: seat.name for seat in environment.seats for name in seat.moves}
    for name in wanted.parts:
        environment.part(name)
        if name in riding:
            raise InputError(f"{name} goes with seat {riding[name]}: move the seat instead")
    if not max(map(abs, wanted.by)) <= FARTHEST:
        raise InputError(f"a move of up to {FARTHEST:g} m is possible")
    x, y, z = (rounded(value, LENGTH_STEP) for value in wanted.by)
    moves = _with_move(arrangement.moves, replace(wanted, by=(x, y, z)))
    along = [control.name for control in environment.controls if control.part in wanted.parts]
    words = f"{', '.join(along)} goes along" if len(along) == 1 else f"{', '.join(along)} go along"
    if not along or not any(wanted.by):
        words = ""
    if moves == arrangement.moves:
        return Edit(arrangement, words)
    return Edit(replace(arrangement, moves=moves), words)


def _with_move(moves: Sequence[Move], wanted: Move) -> tuple[Move, ...]:
    """The moves of a state with one in the place of what it said of the same parts or controls."""
    found = []
    told = not any(wanted.by)
    for move in moves:
        if (move.parts, move.controls) == (wanted.parts, wanted.controls):
            if not told:
                found.append(wanted)
                told = True
            continue
        left = replace(
            move,
            parts=tuple(name for name in move.parts if name not in wanted.parts),
            controls=tuple(name for name in move.controls if name not in wanted.controls),
        )
        if left.parts or left.controls:
            found.append(left)
    return tuple(found) if told else (*found, wanted)


def looking_at(opened: OpenStudy, arrangement: Arrangement, case: str) -> Edit:
    """Look at another case. InputError where it is not there."""
    if case not in opened.cases:
        raise InputError(f"no case {case!r}; {one_of(case, opened.cases)}")
    return Edit(replace(arrangement, case=opened.cases.index(case)))


def rounded(value: float, step: float) -> float:
    """The multiple of a step that is nearest to a value."""
    return round(value / step) * step


def _poses(person: PersonState, case: int) -> Poses:
    action = person.actions[case]
    assert isinstance(action, GivenPosture)
    return action.poses


def _as_given(opened: OpenStudy, placement: Placement, row: int) -> PersonState:
    """A person whose posture in the case is given: of a predicted one as it came out, with the seat
    held where it stands."""
    arrangement = placement.arrangement
    person = arrangement.people[row]
    action = person.actions[arrangement.case]
    if isinstance(action, GivenPosture):
        return person
    assert isinstance(action, PredictedPosture)
    there = placement.people[row]
    if person.free:
        forward = rounded(there.forward, LENGTH_STEP)
        up = rounded(there.up, LENGTH_STEP)
        person = replace(person, free=False, forward=forward, up=up)
    body = opened.body(row)
    base = given_angles(body, action.poses)
    posture = GivenPosture(action.like, action.poses)
    actions = list(person.actions)
    actions[arrangement.case] = posture
    person = replace(person, actions=tuple(actions))
    goal = given_angles(body, there.poses)
    return _with_angles(opened, person, row, arrangement.case, base, goal)


def _with_angles(
    opened: OpenStudy, person: PersonState, row: int, case: int, before: Floats, goal: Floats
) -> PersonState:
    """A person with other angles (J, 3) [rad] in a case, in steps of ANGLE_STEP; joints that are
    nearer to where they were than half a step stay."""
    degrees = np.round(np.degrees(goal) / ANGLE_STEP) * ANGLE_STEP
    changed = np.abs(degrees - np.degrees(before)) > ANGLE_STEP / 2
    if not changed.any():
        return person
    angles = np.where(changed, np.radians(np.round(degrees, 1)), before)
    poses = _poses(person, case)
    rotations = poses.rotations.copy()
    joints = changed.any(axis=1)
    rotations[0, joints] = compose(opened.body(row), angles)[joints]
    action = person.actions[case]
    assert isinstance(action, GivenPosture)
    actions = list(person.actions)
    actions[case] = GivenPosture(
        action.name, Poses(rotations, poses.reference, poses.world_from_reference)
    )
    return replace(person, actions=tuple(actions))
