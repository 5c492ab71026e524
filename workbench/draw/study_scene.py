"""Build the scene that shows a study: people in postures, or in motion."""

from __future__ import annotations

import numpy as np

from workbench.body.forward import place
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.source import PEOPLE_COLOURS, Source, chosen_cases, people_source, split_names
from workbench.model.person import Person
from workbench.model.study import Study
from workbench.study.motion_cases import motion_cases
from workbench.study.people import poses_of, present_people

__all__ = ["study_source"]


def study_source(study: Study, case: str | None = None) -> Source:
    """Build what is to be drawn of a study's cases, as a run evaluates them. See `build_source`.

    Of several sizes the first is drawn; of postures and motions the postures, unless a motion is
    named.
    """
    _, single = study.by_size()[0]
    motions = {each.name for each in study.motions}
    named = case is not None and bool(motions & set(split_names(case)))
    if named or not study.postures:
        return _motion_source(single, case)
    return _posture_source(single, case)


def _posture_source(study: Study, case: str | None) -> Source:
    """Build cases of a study of people in postures: the first, or those that are named."""
    there = present_people(study)
    known = tuple(each.name for each in study.postures)
    chosen = chosen_cases(study.name, known, case)
    if case is None:
        chosen = chosen[:1]
    rows = np.array([known.index(name) for name in chosen])
    persons = tuple(
        Person(role.name, mine[0].body, poses_of(mine).rows(rows))
        for role, mine in zip(there.roles, there.situations, strict=True)
    )
    return people_source(study.title, there.environment, persons, chosen)


def _motion_source(study: Study, case: str | None) -> Source:
    """Build a motion in its environment, over the other motions of the cases."""
    chosen = chosen_cases(study.name, tuple(each.name for each in study.motions), case)
    motions = [motion for motion in motion_cases(study) if motion.case in chosen]
    first = motions[0]
    people = [first.person, *(motion.name for motion in motions[1:])]
    persons = tuple(
        Person(name, motion.body, motion.motion)
        for name, motion in zip(people, motions, strict=True)
    )
    coloured = [
        (motion, PEOPLE_COLOURS[row % len(PEOPLE_COLOURS)]) for row, motion in enumerate(motions)
    ]
    bodies = tuple(
        SceneBody(place(motion.body, motion.motion.rows(slice(1))), 0, colour)
        for motion, colour in coloured
    )
    key = tuple((motion.name, colour) for motion, colour in coloured)
    scene = Scene(
        bodies[:1],
        first.cabin,
        title=study.title,
        ghosts=bodies[1:],
        key=key if len(motions) > 1 else (),
    )
    return Source(scene, (), (first.person,), persons[:1], True, under=persons[1:])
