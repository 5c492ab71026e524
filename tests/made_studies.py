"""Studies of people in given postures, made without files."""

from __future__ import annotations

from workbench.model.result import PosturesFound
from workbench.model.study import Case, GivenPosture, Role, Study
from workbench.study.people import people_found, present_people

__all__ = ["found_of", "made_study"]


def made_study(environment, people, criteria, *, case="hanging") -> Study:
    """A study with one case; people: name -> (fields of the role, pose)."""
    roles = tuple(Role(name, **fields) for name, (fields, _) in people.items())
    actions = tuple(GivenPosture(case, pose) for _, pose in people.values())
    return Study(
        name="test",
        title="test",
        description="",
        environment=environment,
        roles=roles,
        cases=(Case(case, actions),),
        criteria=tuple(criteria),
        inputs={},
    )


def found_of(study: Study) -> PosturesFound:
    """What is found of the people of a study."""
    return people_found(study, present_people(study))
