"""The marks that a user may ask for by name, of whatever pose is shown."""

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
from workbench.draw.scene_builder import Source
from workbench.errors import UsageError, one_of
from workbench.model.poses import Placed, Poses
from workbench.model.posture_study import Person
from workbench.posture.stops import stops

__all__ = ["MARKS", "marks_for_scene", "with_marks"]

MARKS = ("axes", "clearances", "contacts", "controls", "segments", "stops")


def with_marks(source: Source, kinds: tuple[str, ...]) -> Source:
    """The source with marks of these kinds (see MARKS) for its first pose. UsageError for an
    unknown kind."""
    for kind in kinds:
        if kind not in MARKS:
            raise UsageError(f"no marks {kind!r}; {one_of(kind, MARKS)}")
    scene = replace(source.scene, marks=_with_kinds(source, source.scene, kinds))
    return replace(source, scene=scene, kinds=kinds, fixed=source.scene.marks)


def marks_for_scene(source: Source, scene: Scene) -> tuple[Mark, ...]:
    """The marks of a scene of a source's poses, those of the source's kinds for the poses that the
    scene shows."""
    if not source.kinds:
        return scene.marks
    return _with_kinds(source, replace(scene, marks=source.fixed), source.kinds)


def _with_kinds(source: Source, scene: Scene, kinds: tuple[str, ...]) -> tuple[Mark, ...]:
    found = scene.marks
    for kind in kinds:
        found += _marks(source, scene, kind)
    return found


def _marks(source: Source, scene: Scene, kind: str) -> tuple[Mark, ...]:
    found = tuple[Mark, ...]()
    if kind == "axes":
        low, high = scene.bounds
        return axes_marks((0.0, 0.0, 0.0), length=float(np.max(high - low)) / 5.0)
    if kind == "controls":
        return control_marks(scene.environment) if scene.environment is not None else ()
    for shown, person in zip(scene.bodies, source.persons, strict=True):
        placed = _alone(shown)
        if kind == "segments":
            found += segment_marks(placed)
        elif kind == "stops":
            found += stop_marks(placed, stops(person.body, _pose(person, shown.pose)).margin)
        elif scene.environment is not None and kind == "contacts":
            found += contact_marks(contacts(placed, scene.environment))
        elif scene.environment is not None:
            found += clearance_marks(placed, nearest(placed, scene.environment))
    return found


def _alone(shown: SceneBody) -> Placed:
    """The pose that is shown, by itself."""
    placed = shown.placed
    at = range(len(shown.placed))[shown.pose]
    return Placed(
        placed.body,
        placed.world_from_segment[at : at + 1],
        placed.centres[at : at + 1],
        placed.window,
    )


def _pose(person: Person, pose: int) -> Poses:
    poses = person.poses
    at = range(len(person.poses))[pose]
    return Poses(
        poses.rotations[at : at + 1], poses.reference, poses.world_from_reference[at : at + 1]
    )
