"""Make the marks that a user asks for by name, for the pose that is shown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.contact.collide import contacts, nearest
from workbench.draw.marks.annotations import (
    axes_marks,
    clearance_marks,
    contact_marks,
    control_marks,
    segment_marks,
    stop_marks,
)
from workbench.draw.scene import Mark, Scene, SceneBody
from workbench.draw.source import Source
from workbench.errors import UsageError, one_of
from workbench.model.person import Person
from workbench.model.poses import Placed
from workbench.posture.stops import stops

__all__ = ["MARKS", "marks_for_scene", "with_marks"]

MARKS = ("axes", "clearances", "contacts", "controls", "segments", "stops")
"""Kinds of marks."""


def with_marks(source: Source, kinds: tuple[str, ...]) -> Source:
    """Add marks of some kinds to a source.

    Parameters
    ----------
    source
        What is drawn.
    kinds
        Names of `MARKS`.

    Raises
    ------
    UsageError
        If there is no such kind.
    """
    for kind in kinds:
        if kind not in MARKS:
            raise UsageError(f"no marks {kind!r}; {one_of(kind, MARKS)}")
    marked = replace(source, kinds=kinds, fixed=source.scene.marks)
    scene = replace(source.scene, marks=marks_for_scene(marked, source.scene))
    return replace(marked, scene=scene)


def marks_for_scene(source: Source, scene: Scene) -> tuple[Mark, ...]:
    """Return the marks of a scene that shows some poses of a source.

    Marks of the kinds that were asked for follow the poses; the others stay.
    """
    if not source.kinds:
        return scene.marks
    marks = source.fixed
    for kind in source.kinds:
        marks += _marks_of_kind(source, scene, kind)
    return marks


def _marks_of_kind(source: Source, scene: Scene, kind: str) -> tuple[Mark, ...]:
    if kind == "axes":
        low, high = scene.bounds
        return axes_marks((0.0, 0.0, 0.0), length=float(np.max(high - low)) / 5.0)
    if kind == "controls":
        return control_marks(scene.environment) if scene.environment is not None else ()
    marks: tuple[Mark, ...] = ()
    for shown, person in zip(scene.bodies, source.persons, strict=True):
        marks += _body_marks(scene, shown, person, kind)
    return marks


def _body_marks(scene: Scene, shown: SceneBody, person: Person, kind: str) -> tuple[Mark, ...]:
    """Return the marks of one body in the pose that is shown."""
    placed = _shown_pose(shown)
    if kind == "segments":
        return segment_marks(placed)
    if kind == "stops":
        pose = range(len(person.poses))[shown.pose]
        return stop_marks(
            placed, stops(person.body, person.poses.rows(slice(pose, pose + 1))).margin
        )
    if scene.environment is None:
        return ()
    if kind == "contacts":
        return contact_marks(contacts(placed, scene.environment))
    return clearance_marks(placed, nearest(placed, scene.environment))


def _shown_pose(shown: SceneBody) -> Placed:
    """Return the placed body in the shown pose only."""
    placed = shown.placed
    pose = range(len(placed))[shown.pose]  # a pose may be counted from the end
    rows = slice(pose, pose + 1)
    return Placed(placed.body, placed.world_from_segment[rows], placed.centres[rows], placed.window)
