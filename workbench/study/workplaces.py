"""The workplaces of a study, and the people who take them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.body.people.sampling import draw_people
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.model.population import Population, sex_index
from workbench.model.study import (
    Case,
    GivenPosture,
    PeopleDrawn,
    PredictedPosture,
    Role,
    Study,
)
from workbench.model.workplace import Beside, WorkCase, Workplace
from workbench.study.persons import role_body
from workbench.study.situation import Occupants

__all__ = ["drawn_number", "occupant", "population_of", "workplace_of"]


def workplace_of(
    study: Study, row: int, environment: Environment, beside: Sequence[Beside] = ()
) -> Workplace:
    """The workplace of a role of a study.

    Parameters
    ----------
    row
        The index of the role.
    environment
        The surroundings, with the seats of others where these have put them.
    beside
        Others who are there too.
    """
    role = study.roles[row]
    if role.seat is not None and not role.free:
        held = environment.seat(role.seat).held(role.forward, role.up)
        environment = environment.with_seat(held)
    return Workplace(
        role=role.name,
        environment=environment,
        cases=tuple(_work_case(case, row) for case in study.postures),
        criteria=tuple(_criteria(study, role, bool(beside))),
        seat=role.seat,
        stand=role.stand,
        beside=tuple(beside),
        adjusts=role.adjusts,
    )


def _work_case(case: Case, row: int) -> WorkCase:
    """What a role does in a case that is a posture."""
    action = case.actions[row]
    if isinstance(action, GivenPosture):
        return WorkCase(case.name, action.name, action.poses, hands=action.hands)
    assert isinstance(action, PredictedPosture)
    return WorkCase(case.name, action.like, action.poses, action.aims)


def _criteria(study: Study, role: Role, company: bool) -> list[Criterion]:
    """What is asked of a role in postures; between people where there is company."""
    names = [case.name for case in study.postures]
    return [
        criterion
        for criterion in study.criteria
        if role.name in criterion.people
        and criterion.check not in ("share", "injury")
        and (company or criterion.check != "between_people")
        and any(criterion.asks(name) for name in names)
    ]


def drawn_number(roles: Sequence[Role], role: Role) -> int:
    """The number by which the driving posture of a role is drawn: its place among the names of all
    roles, whatever their order in the file."""
    return sorted(one.name for one in roles).index(role.name)


def occupant(role: Role, number: int) -> tuple[Occupants, list[str]]:
    """The one person who takes a role, and what is improbable about the size.

    Parameters
    ----------
    number
        By which a driver's posture is drawn, see `drawn_number`.
    """
    body, notes = role_body(role)
    size = role.size
    given = dict(size.measures) if size is not None else {}
    one = Population(
        names=tuple(given),
        sex=np.array([sex_index(size.sex) if size is not None else 0]),
        weight=np.ones(1),
        measures=np.array([list(given.values())]),
        source=role.name,
        labels=(role.name,),
    )
    return Occupants(body, one, np.zeros(1, dtype=np.int64), number), list(notes)


def population_of(role: Role) -> Population:
    """The people who take a role, drawn where they are to be drawn."""
    people = role.population
    if isinstance(people, PeopleDrawn):
        return draw_people(
            people.model,
            people.people,
            seed=people.seed,
            men=1.0 - people.women,
            synthetic=people.synthetic,
        )
    assert people is not None
    return people
