"""Edits of what a person does in a case: a posture by its name, or one that is predicted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats
from workbench.model.study import Action, GivenPosture, PredictedPosture, Role
from workbench.model.units import plain
from workbench.model.workplace import PostureGoals
from workbench.posture.reaching.limbs import FEET, HANDS
from workbench.study.bench.edits import Edit, held_seat
from workbench.study.bench.holding import HELD_WITHIN, limbs_off, nearest_control, nearest_name
from workbench.study.bench.placing import (
    PlacedPerson,
    Placement,
    controls_there,
    placed_environment,
    placed_people,
)
from workbench.study.bench.state import Arrangement, OpenStudy

__all__ = ["Prediction", "freed", "posed", "predicted", "suggested"]

POINT_WITHIN = 0.25
"""[m] A point that is nearer to eyes or heels is taken to be meant for them, and a pedal for a foot."""

_TRUNK = ("W", "SP", "NP", "HP")
"""The joints of trunk and head, whose angles a prediction takes from a posture by its name."""


@dataclass(frozen=True)
class Prediction:
    """What a posture is to be predicted from.

    Parameters
    ----------
    like
        The posture of trunk and head, by its name.
    controls
        By limb ("left hand", ...) the control that it holds.
    eyes, heels
        Names of points of the environment, "" where any will do.
    everywhere
        Whether the given postures of the other cases are predicted too, each from what hands and
        feet hold in it.
    free
        Whether the seat goes along within its travel: then every case is predicted.
    """

    like: str
    controls: Mapping[str, str] = field(default_factory=dict)
    eyes: str = ""
    heels: str = ""
    everywhere: bool = False
    free: bool = False


def posed(opened: OpenStudy, placement: Placement, person: str, name: str) -> Edit:
    """Give a person a posture of the body or the study, by its name.

    Raises
    ------
    InputError
        If the person or the posture is not there.
    """
    arrangement = placement.arrangement
    row = arrangement.row(person)
    library = opened.study.roles[row].library
    if name not in library:
        raise InputError(f"no posture {name!r}; {one_of(name, library)}")
    state = held_seat(placement, row)
    after = state.doing(arrangement.case, GivenPosture(name, library[name]))
    return Edit(arrangement.with_person(row, after), f"{person}: {name}")


def predicted(opened: OpenStudy, placement: Placement, person: str, wanted: Prediction) -> Edit:
    """Predict the posture of a person instead of giving it, in the seat where it stands unless it is
    to go along.

    Returns
    -------
    Edit
        The words name the cases in which joints were turned beside the posture that is named: a
        prediction takes trunk and head of that posture, and no other angles.

    Raises
    ------
    InputError
        If the person is in no seat, or a posture, control or point is not there or not for this
        limb.
    """
    arrangement = placement.arrangement
    row = arrangement.row(person)
    role = opened.study.roles[row]
    if role.seat is None:
        raise InputError(f"{person}: only the posture of somebody in a seat is predicted")
    if wanted.like not in role.library:
        raise InputError(f"no posture {wanted.like!r}; {one_of(wanted.like, role.library)}")
    if missing := sorted({"LT", "UT", "LHN", "RHN", "LF", "RF"} - set(role.body.segments)):
        raise InputError(
            f"the posture of body {role.body.name} cannot be predicted: "
            f"it has no segment {missing[0]}"
        )
    _check_held(opened, wanted)
    state = arrangement.people[row]
    predictions = {arrangement.case: wanted}
    for case, one in enumerate(state.actions):
        if (wanted.everywhere or wanted.free) and isinstance(one, GivenPosture):
            predictions.setdefault(case, _in_case(opened, placement, row, case))
    after = state
    for case, what in predictions.items():
        if _is_so(state.actions[case], what):
            continue
        aims = PostureGoals(dict(what.controls), what.eyes or None, what.heels or None)
        after = after.doing(case, PredictedPosture(what.like, role.library[what.like], aims))
    if wanted.free:
        after = replace(after, free=True, forward=0.0, up=0.0)
    words = [f"{person}: the posture is predicted"]
    if len(predictions) > 1:
        words = [f"{person}: the posture of {len(predictions)} cases is predicted"]
    if idle := [limb for limb in HANDS if limb not in dict(wanted.controls)]:
        words.append(
            f"the {' and the '.join(idle)} hold no control and stay as in posture {plain(wanted.like)}"
        )
    if turned := [case for case in predictions if _turned(state.actions[case], role)]:
        named = ", ".join(opened.cases[case] for case in turned)
        words.append(f"joints that were turned beside the posture's own are given up in {named}")
    return Edit(arrangement.with_person(row, after), "; ".join(words))


def _is_so(action: Action, wanted: Prediction) -> bool:
    """Whether a posture is predicted from this already, perhaps as a driver's."""
    if not isinstance(action, PredictedPosture):
        return False
    aims = action.aims
    now = Prediction(action.like, dict(aims.controls), aims.eyes or "", aims.heels or "")
    return now == replace(wanted, controls=dict(wanted.controls), everywhere=False, free=False)


def _in_case(opened: OpenStudy, placement: Placement, row: int, case: int) -> Prediction:
    """What the given posture of another case is predicted from: trunk and head as in itself."""
    there = replace(placement.arrangement, case=case)
    placed = placed_people(opened, there, before=placement)
    action = there.people[row].actions[case]
    assert isinstance(action, GivenPosture)
    return replace(_around(opened, placed, row, (*HANDS, *FEET)), like=action.name)


def _turned(action: Action, role: Role) -> bool:
    """Whether a given posture turns joints of trunk and head otherwise than the posture of its name
    does: those of arms and legs are predicted."""
    if not isinstance(action, GivenPosture):
        return False
    body = role.body
    trunk = [body.joint(name) for name in _TRUNK if name in body.joints]
    other = action.poses.rotations[0] != role.library[action.name].rotations[0]
    return bool(other[trunk].any())


def _check_held(opened: OpenStudy, wanted: Prediction) -> None:
    """InputError for controls and points that are not there, hands on pedals and feet on knobs."""
    environment = opened.study.environment
    controls = {control.name: control for control in environment.controls}
    for name, control in wanted.controls.items():
        if name not in (*HANDS, *FEET):
            raise InputError(f"no limb {name!r}; {one_of(name, (*HANDS, *FEET))}")
        if control not in controls:
            raise InputError(f"no control {control!r}; {one_of(control, controls)}")
        if not controls[control].is_for(name):
            meant = controls[control].limbs
            raise InputError(f"{control} is for {meant}, not for the {name}")
    for name in (wanted.eyes, wanted.heels):
        if name and name not in environment.points:
            raise InputError(f"no point {name!r}; {one_of(name, environment.points)}")


def suggested(
    opened: OpenStudy, placement: Placement, row: int, limbs: Iterable[str]
) -> Prediction:
    """What a person's posture might be predicted from: what it is in another case, else what hands,
    feet, eyes and heels are near to.

    Parameters
    ----------
    limbs
        The names of those that the body has.
    """
    person = placement.arrangement.people[row]
    every = (person.actions[placement.arrangement.case], *person.actions)
    known = next((one for one in every if isinstance(one, PredictedPosture)), None)
    if known is not None:
        aims = known.aims
        return Prediction(known.like, aims.controls, aims.eyes or "", aims.heels or "")
    return _around(opened, placement, row, limbs)


def _around(opened: OpenStudy, placement: Placement, row: int, limbs: Iterable[str]) -> Prediction:
    """What hands, feet, eyes and heels of a given posture are near to; of hands and feet that have
    left their controls, these."""
    environment = placed_environment(opened, placement)
    left = {one.limb: one.control for one in limbs_off(opened, placement, row, limbs)}
    controls: dict[str, str] = {}
    there = placement.people[row]
    around = controls_there(opened, environment, row, there.shift)
    for name in limbs:
        control, distance = nearest_control(there, name, around)
        if name in left or distance <= (POINT_WITHIN if name in FEET else HELD_WITHIN):
            controls[name] = left.get(name, control)
    library = opened.study.roles[row].library
    person = placement.arrangement.people[row]
    action = person.actions[placement.arrangement.case]
    assert isinstance(action, GivenPosture)
    like = "driving" if "driving" in library else action.name
    body = there.body
    heads = [
        row for row, segment in enumerate(body.sphere_segment) if body.segments[segment] == "H"
    ]
    heels = [row for row, name in enumerate(body.subparts) if name in ("LF/heel", "RF/heel")]
    points = environment.points
    return Prediction(
        like,
        controls,
        nearest_name(points, _middle(there, heads), POINT_WITHIN),
        nearest_name(points, _middle(there, heels), POINT_WITHIN),
    )


def _middle(there: PlacedPerson, spheres: list[int]) -> Floats:
    """(3,) [m] the middle of the centres of spheres; NaN where there are none."""
    if not spheres:
        return np.full(3, np.nan)
    return there.placed.centres[0, spheres].mean(axis=0)


def freed(opened: OpenStudy, arrangement: Arrangement, person: str) -> Edit:
    """Let a person's seat go where the person wants it.

    Raises
    ------
    InputError
        If the person is in no seat, or a posture of the person is given.
    """
    row = arrangement.row(person)
    if opened.seat(row) is None:
        raise InputError(f"{person} is in no seat")
    state = arrangement.people[row]
    given = [
        opened.cases[k] for k, one in enumerate(state.actions) if isinstance(one, GivenPosture)
    ]
    if given:
        raise InputError(
            f"{person}: the posture is given in case {given[0]!r}, so hands and feet would not "
            "follow a free seat; predict the posture of every case first"
        )
    if state.free:
        return Edit(arrangement)
    after = replace(state, free=True, forward=0.0, up=0.0)
    return Edit(arrangement.with_person(row, after), f"{person}: the seat is free")
