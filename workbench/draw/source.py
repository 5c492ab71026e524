"""What is to be drawn: a scene, and what is needed to show it at other times."""

from __future__ import annotations

from dataclasses import dataclass, replace

from workbench.body.forward import place
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.joint_angles import poses_at
from workbench.model.person import Person

__all__ = ["PEOPLE_COLOURS", "Source", "chosen_cases", "people_source", "split_names"]

PEOPLE_COLOURS = ("warm", "blue", "green", "rose", "grey")
"""Colour families of the people of a study, in turn."""


@dataclass(frozen=True, eq=False)
class Source:
    """What is to be drawn: a scene, and what is needed to show it at other times."""

    scene: Scene
    """Its bodies hold P poses each and show the first. Of a recorded motion it holds the first
    frame only."""
    names: tuple[str, ...] = ()
    """Names of the P poses or cases; empty for a recorded motion."""
    people: tuple[str, ...] = ()
    """Names of the bodies."""
    persons: tuple[Person, ...] = ()
    """Body and poses of each person."""
    moving: bool = False
    """Whether `at` can give the poses at any time."""
    notes: tuple[str, ...] = ()
    """What the numbers of marks mean, and what was assumed."""
    under: tuple[Person, ...] = ()
    """The persons of the scene's ghosts."""
    kinds: tuple[str, ...] = ()
    """Kinds of marks that follow the poses, see `requested_marks.with_marks`."""
    fixed: tuple[Mark, ...] = ()
    """Marks that do not."""

    def at(self, times: Floats) -> Source:
        """Return the source with everybody who moves in F poses, at times (F,) [s]."""
        persons = tuple(_at_times(person, times) for person in self.persons)
        under = tuple(_at_times(person, times) for person in self.under)
        bodies = self._placed(self.scene.bodies, self.persons, persons)
        ghosts = self._placed(self.scene.ghosts, self.under, under)
        scene = replace(self.scene, bodies=bodies, ghosts=ghosts)
        return replace(self, scene=scene, persons=persons, under=under)

    def _placed(
        self, shown: tuple[SceneBody, ...], before: tuple[Person, ...], after: tuple[Person, ...]
    ) -> tuple[SceneBody, ...]:
        """Place the persons whose poses have changed."""
        return tuple(
            body if new is old else replace(body, placed=place(new.body, new.poses), pose=0)
            for body, old, new in zip(shown, before, after, strict=True)
        )


def _at_times(person: Person, times: Floats) -> Person:
    """Return a person in poses at times (F,) [s]; the same person if the poses have no times."""
    if person.poses.time is None:
        return person
    return replace(person, poses=poses_at(person.poses, times))


def people_source(
    title: str, environment: Environment, persons: tuple[Person, ...], cases: tuple[str, ...]
) -> Source:
    """Return what is to be drawn of people who are in postures, a pose a case."""
    bodies = tuple(
        SceneBody(
            place(person.body, person.poses),
            0,
            PEOPLE_COLOURS[i % len(PEOPLE_COLOURS)],
            environment,
        )
        for i, person in enumerate(persons)
    )
    description = ", ".join(cases) if len(cases) < 9 else ""
    scene = Scene(bodies, environment, (), title, description)
    return Source(scene, cases, tuple(person.name for person in persons), persons)


def chosen_cases(study: str, known: tuple[str, ...], case: str | None) -> tuple[str, ...]:
    """Return the named cases, all if None."""
    chosen = split_names(case) if case is not None else known
    for name in chosen:
        if name not in known:
            raise UsageError(f"study {study} has no case {name!r}; {one_of(name, known)}")
    return chosen


def split_names(text: str) -> tuple[str, ...]:
    """Return the names of a list with commas between."""
    listed = tuple(name.strip() for name in text.split(","))
    if not all(listed):
        raise UsageError(f"names with commas between are needed, got {text!r}")
    return listed
