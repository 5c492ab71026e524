"""Edits of what a person does in a case: a posture by its name, or one that is predicted."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats
from workbench.model.environment import Control
from workbench.model.study import GivenPosture, PredictedPosture
from workbench.model.workplace import Aims
from workbench.posture.reaching.limbs import FEET, HANDS, limb
from workbench.study.bench.edits import Edit, held_seat
from workbench.study.bench.placing import PlacedPerson, Placement, placed_environment
from workbench.study.bench.state import Arrangement, OpenStudy

__all__ = ["Prediction", "freed", "posed", "predicted", "suggested"]

HELD_WITHIN = 0.06
"""[m] A control that is nearer to a hand or foot is taken to be held by it."""
POINT_WITHIN = 0.25
"""[m] A point that is nearer to eyes or heels is taken to be meant for them."""


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
    """

    like: str
    controls: Mapping[str, str] = field(default_factory=dict)
    eyes: str = ""
    heels: str = ""


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
    """Predict the posture of a person in the seat where it stands, instead of giving it.

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
    aims = Aims(dict(wanted.controls), wanted.eyes or None, wanted.heels or None)
    action = PredictedPosture(wanted.like, role.library[wanted.like], aims)
    after = arrangement.people[row].doing(arrangement.case, action)
    return Edit(arrangement.with_person(row, after), f"{person}: the posture is predicted")


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
    environment = placed_environment(opened, placement)
    controls: dict[str, str] = {}
    there = placement.people[row]
    for name in limbs:
        if held := _held(there, name, environment.controls):
            controls[name] = held
    library = opened.study.roles[row].library
    action = every[0]
    assert isinstance(action, GivenPosture)
    like = "driving" if "driving" in library else action.name
    eyes = _nearest(environment.points, _middle(there, "H"), POINT_WITHIN)
    feet = _middle(there, "LF", "RF")
    heels = _nearest(environment.points, feet, POINT_WITHIN)
    return Prediction(like, controls, eyes, heels)


def _held(there: PlacedPerson, name: str, controls: Iterable[Control]) -> str:
    """The control that a hand or foot is nearest to by the point that would hold it; "" where it is
    too far."""
    world = there.placed.world_from_segment[0]
    offset: dict[str, tuple[float, float, float]] = {}
    tips: dict[str, Floats] = {}
    for control in controls:
        if not control.is_for(name):
            continue
        grip = "ball" if name in FEET else control.grip
        if grip not in tips:
            one = limb(there.body, name, grip=grip)
            tips[grip] = world[one.end, :, :3] @ one.tip[0] + world[one.end, :, 3]
        x, y, z = (np.array(control.at) - tips[grip]).tolist()
        offset[control.name] = (x, y, z)
    return _nearest(offset, np.zeros(3), POINT_WITHIN if name in FEET else HELD_WITHIN)


def _middle(there: PlacedPerson, *segments: str) -> Floats:
    """(3,) [m] the middle between the centres of gravity of segments; NaN where one is missing."""
    body = there.body
    if not set(segments) <= set(body.segments):
        return np.full(3, np.nan)
    rows = [body.segment(name) for name in segments]
    middle: Floats = there.placed.world_from_segment[0, rows, :, 3].mean(axis=0)
    return middle


def _nearest(points: Mapping[str, tuple[float, float, float]], to: Floats, within: float) -> str:
    """The name of the point that is nearest to another one, "" where none is within a distance."""
    if not points or np.isnan(to).any():
        return ""
    distance = np.linalg.norm(np.array(list(points.values())) - to, axis=1)
    nearest = int(distance.argmin())
    return list(points)[nearest] if distance[nearest] <= within else ""


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
