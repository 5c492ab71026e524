"""Edits of limbs: a hand or foot goes to a target, or takes hold of a control."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from workbench.errors import InputError, one_of
from workbench.model.criterion import short_words
from workbench.model.environment import Control
from workbench.model.reach import Reach
from workbench.model.study import GivenPosture, PredictedPosture
from workbench.posture.reaching.limbs import FEET, HANDS, limb
from workbench.posture.reaching.reach import reach
from workbench.study.bench.edits import FARTHEST, Edit
from workbench.study.bench.edits_joints import as_given, let_go, poses_in, with_angles
from workbench.study.bench.placing import Placement, placed_environment
from workbench.study.bench.state import (
    Arrangement,
    OpenStudy,
    given_angles,
)

__all__ = ["LimbTarget", "reached"]


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
