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
from workbench.model.result import Verdict
from workbench.model.surroundings import move_parts
from workbench.sight.eyes import Gaze, eyes_of, gaze
from workbench.sight.obscuration import Obscuration, obscuration
from workbench.sight.regions import Region
from workbench.sight.scenery import Scenery
from workbench.study.bench.placing import Placement
from workbench.study.bench.state import Arrangement, OpenStudy, arranged_study
from workbench.study.people import Present, among_others, verdicts_of
from workbench.study.situation import Situation, situated
from workbench.study.workplaces import workplace_of

__all__ = ["Field", "field_of", "people_here", "sight_verdicts"]

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
            environment = move_parts(environment, parts, person.shift)
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
    scenery
        What may hide something.
    gaze
        The eyes where they are, one row, and by how much they and the head have turned.
    hidden
        What each item hides within an angle of the direction.
    """

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

    The eyes turn first, as `gaze` has it. What is worn on the head stays as the posture has it.

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
    eyes = eyes_of(situation.placed)
    looks = gaze(eyes, eyes.middle + _FAR / length * way)
    ahead = way / length
    left = looks.eyes.axes[0, 1]
    if abs(left @ ahead) > 0.9:  # far beyond the turn of the head
        left = np.cross(looks.eyes.axes[0, 2], ahead)
    left = left - (left @ ahead) * ahead
    left /= np.linalg.norm(left)
    region = Region("field", np.stack([ahead, left, np.cross(ahead, left)]), within)
    hidden = obscuration(situation.scenery, looks.eyes, within=region, step=step)
    return Field(situation.scenery, looks, hidden)


@lru_cache(maxsize=2)
def _seeing(opened: OpenStudy, placement: Placement) -> list[Situation]:
    """The people of a placement with the others before them: what stands there is collected once for
    all directions."""
    return among_others(people_here(opened, placement))
