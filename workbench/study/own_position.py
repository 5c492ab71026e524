"""Find the seat position of one person in which what the study asks of this person is met."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.model.accommodation import MET, AccommodationStudy
from workbench.model.environment import Environment
from workbench.model.population import Population
from workbench.model.poses import Poses
from workbench.model.posture_study import Person, PostureStudy
from workbench.study.accommodation.positions import Fitted, fitted_positions
from workbench.study.accommodation.requirements import asked_of
from workbench.study.accommodation.sitters import seated

__all__ = ["own_position"]

_ASKED = (
    "clearance",
    "contact",
    "eye_height",
    "pedals",
    "preferred_seat",
    "reach",
    "self_contact",
    "stops",
    "view_over",
)
"""Checks that a position is looked for: all that are about one person by himself."""


def own_position(
    study: PostureStudy, person: Person, case: int, environment: Environment
) -> tuple[Person, str]:
    """Move the free seat of a person to where all criteria about this person are met.

    The person counts as a population of one. The criteria are those of one case; what is asked
    between people is left to the run.

    Parameters
    ----------
    person
        Somebody whose seat stands in the comfortable position.
    case
        The index of a case whose posture is predicted.
    environment
        The surroundings, with the seats of others where these have put them.

    Returns
    -------
    Person and str
        With the seat in the fitting position nearest to the comfortable one, or that of the least
        shortfall; and in words that it has left the comfortable one, "" where it has not.
    """
    alone = _as_population(study, person, case, environment)
    asked = asked_of(alone)
    if not asked:
        return person, ""
    sitters = seated(alone, person.body, [0])
    no_sets = np.zeros((len(asked), 0), dtype=np.bool_)
    found = fitted_positions(alone, asked, no_sets, sitters, [0])
    forward, up = found.tried.seat[0].tolist()
    return _moved(person, found, forward, up)


def _moved(person: Person, found: Fitted, forward: float, up: float) -> tuple[Person, str]:
    ahead, above = (found.tried.seat[0] - found.comfortable[0]).tolist()
    if not (ahead or above):
        return person, ""
    way = [
        f"{1000 * abs(size):.0f} mm {words[0] if size > 0 else words[1]}"
        for size, words in ((ahead, ("forward", "back")), (above, ("up", "down")))
        if abs(size) >= 5e-4
    ]
    least = float(np.nanmin(found.tried.margin[0]))
    why = "everything asked of the person is met" if least >= -MET else "least is missing"
    words = f"the seat is {' and '.join(way)} of the most comfortable position: there {why}"
    return replace(person, forward=forward, up=up), words


def _as_population(
    study: PostureStudy, person: Person, case: int, environment: Environment
) -> AccommodationStudy:
    """A study of a population that is this one person."""
    aims = person.aims[case]
    assert aims is not None and person.seat is not None
    name = study.cases[case]
    pose = Poses(
        person.poses.rotations[case : case + 1],
        person.poses.reference,
        person.poses.world_from_reference[case : case + 1],
    )
    nobody = Population(
        names=(),
        sex=np.zeros(1, dtype=np.int64),
        weight=np.ones(1),
        measures=np.zeros((1, 0)),
        source=person.name,
    )
    return AccommodationStudy(
        name=study.name,
        title="",
        description="",
        environment=environment,
        body=person.body,
        wears=(),
        people=nobody,
        seat=person.seat,
        aims=aims,
        like=person.postures[case],
        criteria=tuple(
            criterion
            for criterion in study.criteria
            if criterion.check in _ASKED
            and person.name in criterion.people
            and criterion.asks(name)
        ),
        mixes={},
        confidence=0.95,
        maps=(),
        inputs={},
        pose=pose,
    )
