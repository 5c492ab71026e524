"""What people hold and sit on, and what of it a change has taken from them: hands and feet of given
postures that have left their controls, aims that a prediction misses, seats that a body sinks into."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.environment import Control
from workbench.model.study import GivenPosture
from workbench.model.units import plain
from workbench.posture.reaching.limbs import FEET, limb
from workbench.study.bench.answers import TOUCHES, Answer, PersonAnswer
from workbench.study.bench.near import Someone, part_pairs
from workbench.study.bench.placing import (
    PlacedPerson,
    Placement,
    controls_there,
    placed_environment,
    placed_person,
)
from workbench.study.bench.state import OpenStudy, PersonState

__all__ = [
    "HELD_WITHIN",
    "LimbOff",
    "Trouble",
    "limbs_off",
    "nearest_control",
    "nearest_name",
    "troubles",
]

HELD_WITHIN = 0.06
"""[m] A control that is nearer to a hand or foot is taken to be held by it."""
OFF = 0.02
"""[m] A limb that is farther from its control than before by more has left it: half the width of a
knob or of a pedal's pad, 40 mm."""


@dataclass(frozen=True)
class LimbOff:
    """A hand or foot that is no longer at what the same posture holds in the study as opened.

    Parameters
    ----------
    limb, control
        By name.
    distance, before
        [m] between the two, now and as opened.
    """

    limb: str
    control: str
    distance: float
    before: float


@dataclass(frozen=True)
class Trouble:
    """What is wrong with how a person holds and sits.

    Parameters
    ----------
    words
        Sentences, none where nothing is.
    offer
        What may mend it: "predict" the posture, "free" the seat; "" where neither would.
    """

    words: tuple[str, ...]
    offer: str


def nearest_control(
    there: PlacedPerson, name: str, controls: Iterable[Control]
) -> tuple[str, float]:
    """Find the control that a hand or foot is nearest to by the point that would hold it.

    Returns
    -------
    tuple of str and float
        Its name and its distance [m]; "" and infinity where no control is for this limb.
    """
    world = there.placed.world_from_segment[0]
    distance: dict[str, float] = {}
    tips: dict[str, Floats] = {}
    for control in controls:
        if not control.is_for(name):
            continue
        grip = "ball" if name in FEET else control.grip
        if grip not in tips:
            one = limb(there.body, name, grip=grip)
            tips[grip] = world[one.end, :, :3] @ one.tip[0] + world[one.end, :, 3]
        distance[control.name] = float(np.linalg.norm(np.array(control.at) - tips[grip]))
    nearest = min(distance, key=lambda one: distance[one], default="")
    return nearest, distance.get(nearest, np.inf)


def nearest_name(
    points: Mapping[str, tuple[float, float, float]], to: Floats, within: float
) -> str:
    """Name the point that is nearest to another one; "" where none is within a distance [m]."""
    if not points or np.isnan(to).any():
        return ""
    distance = np.linalg.norm(np.array(list(points.values())) - to, axis=1)
    nearest = int(distance.argmin())
    return list(points)[nearest] if distance[nearest] <= within else ""


def limbs_off(
    opened: OpenStudy, placement: Placement, row: int, limbs: Iterable[str]
) -> tuple[LimbOff, ...]:
    """Find the hands and feet of a given posture that have left their controls.

    A given posture holds what it holds by its angles alone: with another body, seat or place of the
    controls the same angles end elsewhere. What it holds is what the same angles hold for the
    person, the seat and the controls of the study as opened.

    Parameters
    ----------
    limbs
        The names of those that the body has.
    """
    arrangement = placement.arrangement
    person = arrangement.people[row]
    action = person.actions[arrangement.case]
    if not isinstance(action, GivenPosture) or _as_opened(opened, placement, row):
        return ()
    before = _with_this_posture(opened, row, action)
    there = placement.people[row]
    was = controls_there(opened, opened.study.environment, row, before.shift)
    are = controls_there(opened, placed_environment(opened, placement), row, there.shift)
    found = []
    for name in limbs:
        control, held = nearest_control(before, name, was)
        if held > HELD_WITHIN or name in action.hands:
            continue
        now = [one for one in are if one.name == control]
        distance = nearest_control(there, name, now)[1]
        if distance > held + OFF:
            found.append(LimbOff(name, control, distance, held))
    return tuple(found)


def _as_opened(opened: OpenStudy, placement: Placement, row: int) -> bool:
    """Whether a person, the seat and all controls are as in the study as opened."""
    start = opened.start
    same = _body_and_seat(placement.arrangement.people[row]) == _body_and_seat(start.people[row])
    now = placement.arrangement.moves, placement.settings
    return same and now == (start.moves, start.settings)


def _body_and_seat(person: PersonState) -> tuple[object, ...]:
    return person.figure, person.free, person.forward, person.up


@lru_cache(maxsize=64)
def _with_this_posture(opened: OpenStudy, row: int, action: GivenPosture) -> PlacedPerson:
    """A person of the study as opened in a given posture, its hands where its angles have them."""
    bare = GivenPosture(action.name, action.poses)
    person = replace(opened.start.people[row], actions=(bare,))
    return placed_person(opened, replace(opened.start.with_person(row, person), case=0), row)


def troubles(opened: OpenStudy, found: Answer, row: int) -> Trouble:
    """Say what is wrong with how a person holds and sits, and what may mend it.

    Parameters
    ----------
    found
        The answer to a state.
    row
        The index of the person.
    """
    one = found.people[row]
    person = one.person
    role = person.state.role
    off = limbs_off(opened, found.placement, row, one.tips)
    missed = person.shortfalls
    words = [*_off_words(role, off), *(one.sentence for one in missed)]
    if not any(one.what == "thighs" for one in missed):
        words += _sunk(opened, found, row, one)
    given = isinstance(person.state.actions[person.case], GivenPosture)
    seat = opened.seat(row)
    offer = ""
    if words and seat is not None:
        goes = max(np.ptp(seat.travel_forward), np.ptp(seat.travel_up)) > 0.0
        offer = "predict" if given else "free" if goes and not person.state.free else ""
    return Trouble(tuple(plain(line) for line in words), offer)


def _off_words(role: str, off: tuple[LimbOff, ...]) -> list[str]:
    """One sentence about the limbs that have left their controls."""
    if not off:
        return []
    named = [
        f"{one.limb} {1e3 * one.distance:.0f} mm from {one.control} "
        f"({1e3 * one.before:.0f} mm as opened)"
        for one in off
    ]
    return [f"{role}: the given posture no longer holds its controls: {', '.join(named)}"]


def _sunk(opened: OpenStudy, found: Answer, row: int, one: PersonAnswer) -> list[str]:
    """That a person is deeper in a part of the own seat than it allows, where deepest."""
    environment = found.placement.parts.environment
    own = {environment.parts[part] for part in opened.movers[row]}
    someone = Someone(one.person.state.role, one.person.body)
    most = len(one.person.body.segments)
    pairs = part_pairs(someone, environment, one.near, tolerances=found.tolerances, most=most)
    for pair in pairs:
        if pair.room < -TOUCHES and pair.target in own:
            return [
                f"{pair.person}: {pair.subject} is {-1e3 * pair.distance:.0f} mm in {pair.target}, "
                f"where {1e3 * pair.allowed:.0f} mm is allowed"
            ]
    return []
