"""What the people of a state see from where they are: while something is dragged, nobody takes
another place for it.

The verdicts are those of a run where everybody stays: the same functions find and judge them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from workbench.body.parts import moved
from workbench.model.accommodation import OF_RULES, OF_SIGHT
from workbench.model.result import Verdict
from workbench.study.bench.placing import Placement
from workbench.study.bench.state import Arrangement, OpenStudy, arranged_study
from workbench.study.people import Present, verdicts_of
from workbench.study.situation import situated
from workbench.study.workplaces import workplace_of

__all__ = ["people_here", "sight_verdicts"]


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
            environment = moved(environment, parts, person.shift)
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
