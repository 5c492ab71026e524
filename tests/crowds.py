"""Populations of studies, for tests that look at their rows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench import load_study
from workbench.body.scaling.scale import morph_to
from workbench.model.study import Study
from workbench.study.accommodation.accommodation import population_question
from workbench.study.accommodation.population_bodies import PopulationBodies, fit_population
from workbench.study.positions import comfortable_situations, in_positions
from workbench.study.situation import Occupants

__all__ = ["Crowd", "crowd_of"]


@dataclass(frozen=True, eq=False)
class Crowd:
    """A study of a population, and what is asked of its people."""

    study: Study

    @cached_property
    def question(self):
        return population_question(self.study)

    @property
    def people(self):
        return self.question.people

    @property
    def environment(self):
        return self.question.place.environment

    @property
    def seat(self):
        return self.question.place.own_seat

    @property
    def clothes(self):
        return self.study.crowd.clothes

    @cached_property
    def body(self):
        """The body that everybody is made from."""
        return morph_to(self.study.crowd.body, self.study.crowd.detail)

    @cached_property
    def bodies(self) -> PopulationBodies:
        sits = self.study.crowd.seat is not None
        return fit_population(self.body, self.people, self.clothes, sits=sits)

    def with_people(self, people, **changes):
        """The same study with these people, and other fields changed."""
        (role,) = self.study.roles
        roles = (replace(role, population=people),)
        return Crowd(replace(self.study, roles=roles, **changes))

    def occupants(self, body, rows):
        """Some people, rows of the population, with these bodies."""
        return Occupants(body, self.people, rows)

    def situations(self, body, rows, position=None):
        """Some people in each case, in their comfortable positions or all in one."""
        who = self.occupants(body, np.asarray(rows))
        place = self.question.place
        comfortable = comfortable_situations(place, who)
        if position is None:
            return comfortable
        at = np.tile(np.asarray(position, dtype=float), (len(who), 1))
        return in_positions(place, who, at, comfortable)

    def seated(self, body, rows):
        """Some people as they sit in the first case."""
        return self.situations(body, rows)[0].seated


def crowd_of(path) -> Crowd:
    """The population of a study's file."""
    return Crowd(load_study(path))
