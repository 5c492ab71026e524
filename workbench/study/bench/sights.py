"""What the people of a state see from where they are: while something is dragged, nobody takes
another place for it.

The verdicts are those of a run where everybody stays: the same functions find and judge them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.model.accommodation import OF_RULES, OF_SIGHT
from workbench.model.arrays import Floats
from workbench.model.poses import Placed, Poses
from workbench.model.quaternions import exponential, from_matrices, matrices
from workbench.model.result import Verdict
from workbench.model.surroundings import moved_along
from workbench.sight.eyes import TURNS, Gaze, eyes_of, gaze, head_of
from workbench.sight.obscuration import Obscuration, obscuration
from workbench.sight.regions import Region
from workbench.sight.scenery import Scenery
from workbench.study.bench.placing import Placement
from workbench.study.bench.state import Arrangement, OpenStudy, arranged_study
from workbench.study.people import Present, among_others, verdicts_of
from workbench.study.situation import Situation, situated
from workbench.study.workplaces import workplace_of

__all__ = ["Field", "field_of", "people_here", "sight_verdicts"]

_TRUNK = "UT"
"""The segment that turns with the trunk, and bears arms and head."""
_HEAD_TURNED = replace(TURNS, head_side=0.0, head_up=0.0, head_down=0.0)
"""How far eyes turn whose head has turned already."""
_FAR = 1000.0
"""Distance [m] of what somebody looks at who looks in a direction."""


def people_here(opened: OpenStudy, placement: Placement) -> Present:
    """The people of a placement in the case that is looked at, as a run has them who sit so."""
    arrangement = replace(placement.arrangement, settings=placement.settings)
    study = arranged_study(opened, arrangement)
    environment = study.environment
    found = []
    for row, person in enumerate(placement.people):
        one = person.held
        if one is None:
            place = workplace_of(study, row, study.environment)
            one = situated(place, person.case, person.state.figure.who)
        found.append(one)
        if person.shift.any():
            parts = [environment.parts[k] for k in opened.movers[row]]
            environment = moved_along(environment, parts, person.shift)
    mine = tuple((one.seat_moved(environment),) for one in found)
    return Present(environment, study.roles, mine, ())


def sight_verdicts(opened: OpenStudy, arrangement: Arrangement, here: Present) -> Iterator[Verdict]:
    """Judge the criteria of sight in the case that is looked at, those of a rule last: these cost
    the most.

    Parameters
    ----------
    here
        Of `people_here`.
    """
    criteria = [one for one in opened.study.criteria if one.check in OF_SIGHT]
    criteria.sort(key=lambda one: one.check in OF_RULES)
    yield from verdicts_of(criteria, here, (), (opened.cases[arrangement.case],))


@dataclass(frozen=True, eq=False)
class Field:
    """What stands before the eyes of somebody who looks in a direction.

    Parameters
    ----------
    placed
        The person with trunk and head turned.
    scenery
        What may hide something.
    gaze
        The eyes where they are, one row, and by how much they and the head have turned.
    hidden
        What each item hides within an angle of the direction.
    """

    placed: Placed
    scenery: Scenery
    gaze: Gaze
    hidden: Obscuration


def field_of(
    opened: OpenStudy,
    placement: Placement,
    row: int,
    toward: ArrayLike,
    *,
    within: float,
    step: float,
) -> Field:
    """Turn the eyes and the head of somebody, and measure what hides the field.

    The eyes turn first, then the head with what is worn on it, then the trunk with all that it bears,
    as far as a criterion of the person lets it, as `gaze` has it.

    Parameters
    ----------
    row
        Of the person in the placement.
    toward
        (3,) the direction in which the person looks.
    within
        [rad] from it the field goes.
    step
        As of `obscuration`.

    Raises
    ------
    InputError
        If the person has no eyes, or an eye is inside something, or the direction is none.
    """
    way = np.asarray(toward, dtype=np.float64)
    length = float(np.linalg.norm(way))
    if not math.isfinite(length) or length == 0.0:
        raise InputError("a direction to look in is three numbers that are not all 0")
    situation = _seeing(opened, placement)[row]
    asked = [one.trunk for one in opened.study.criteria if situation.place.role in one.people]
    target = eyes_of(situation.placed).middle + _FAR / length * way
    turned, looks = _turned_to(situation, target, max(asked, default=0.0))
    ahead = way / length
    left = looks.eyes.axes[0, 1]
    if abs(left @ ahead) > 0.9:  # far beyond the turn of the head
        left = np.cross(looks.eyes.axes[0, 2], ahead)
    left = left - (left @ ahead) * ahead
    left /= np.linalg.norm(left)
    region = Region("field", np.stack([ahead, left, np.cross(ahead, left)]), within)
    hidden = obscuration(turned.scenery, looks.eyes, within=region, step=step)
    return Field(turned.placed, turned.scenery, looks, hidden)


def _turned_to(situation: Situation, target: Floats, trunk: float) -> tuple[Situation, Gaze]:
    """Turn a person to a target (1, 3) [m]: the posture with trunk and head turned, and how the eyes
    look from there; trunk: how far [rad] it may turn."""
    body = situation.body
    head = head_of(body)
    looks = gaze(eyes_of(situation.placed), target, trunk=trunk)
    if not head:
        return situation, looks  # nothing bears the head
    aside = looks.trunk_turn
    if aside.any() and _TRUNK in body.segments:
        up = eyes_of(situation.placed).axes[0, 2]
        situation = _with_turn(situation, body.segment(_TRUNK), aside[0] * up)
        looks = gaze(eyes_of(situation.placed), target)
    _, left, up = eyes_of(situation.placed).axes[0]
    to_left, upward = looks.head_turn[0].tolist()
    situation = _with_turn(situation, head, to_left * up - upward * left)
    rest = gaze(eyes_of(situation.placed), target, _HEAD_TURNED)
    return situation, replace(rest, head_turn=looks.head_turn, trunk_turn=aside)


def _with_turn(situation: Situation, segment: int, turn: Floats) -> Situation:
    """A person with a segment, and all that it bears, turned about its joint by a rotation vector (3,)
    [rad] in the world."""
    world = situation.placed.world_from_segment[:, :, :, :3]
    parent = world[0, situation.body.parent[segment]]
    rotations = situation.poses.rotations.copy()
    turned = parent.T @ matrices(exponential(turn)) @ world[0, segment]
    rotations[0, segment - 1] = from_matrices(turned)
    poses = Poses(rotations, 0, situation.placed.world_from_segment[:, 0])
    return replace(situation, poses=poses)


@lru_cache(maxsize=2)
def _seeing(opened: OpenStudy, placement: Placement) -> list[Situation]:
    """The people of a placement with the others before them: what stands there is collected once for
    all directions."""
    return among_others(people_here(opened, placement))
