"""Motions to be drawn: a body, or somebody in a study, moves as a file says; one source is laid
over another."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.body.forward import place
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.scene_builder import PEOPLE_COLOURS, Source, build_source, source_kind
from workbench.errors import InputError, UsageError, one_of
from workbench.files.body.bodies import load_body
from workbench.files.motions.lines import Pick
from workbench.files.motions.reading import MOTIONS
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.model.posture_study import Person
from workbench.study.motions import MotionOptions, load_motion

__all__ = [
    "POSITIONS",
    "MotionClip",
    "at_times",
    "common_time_span",
    "evenly_spaced_times",
    "is_motion",
    "overlay",
    "parse_times",
    "with_motion",
]

POSITIONS = 4  # of a motion in a picture where nothing else is asked for: the paper's Figure 7
_OVER, _UNDER = PEOPLE_COLOURS[:2]
_SHORT = 2.0  # [s] motions that are shorter are told in milliseconds


@dataclass(frozen=True)
class MotionClip:
    """What of a motion file is wanted: frames from start to end [s]; up: its upward axis where it
    is not told right."""

    start: float | None = None
    end: float | None = None
    up: str | None = None


def with_motion(
    source: str, motion: str, *, take: MotionClip = MotionClip(), case: str | None = None
) -> Source:
    """A body that makes the movement of a motion file, or a person of a study in its environment
    who does.

    motion: the file; of a study's people the first makes it, or whoever stands before it:
    "pilot=drive.csv". The others sit as in `case`, the study's first where none is given.
    InputError and UsageError for what cannot be read or moved.
    """
    kind = source_kind(source)
    if kind == "body":
        if case is not None:
            raise UsageError(f"{source} is a body: --case is for studies")
        body = load_body(source)
        poses, notes = _read(body, Path(motion), take)
        person = Person(body.name, body, poses, ())
        scene = Scene((_first(person, _OVER),), None, (), body.name, Path(motion).name)
        return Source(scene, (), (body.name,), (person,), True, notes)
    if kind != "study":
        raise UsageError(
            f"{source} is {'an' if kind[0] == 'e' else 'a'} {kind}: --motion is for bodies and studies"
        )
    return _study_in_motion(build_source(source, case=case), motion, take)


def _study_in_motion(found: Source, motion: str, take: MotionClip) -> Source:
    if found.moving:
        raise UsageError(f"{found.scene.title} brings its own motion: leave out --motion")
    if len(found.names) > 1:
        raise UsageError(f"--motion: the others sit as in one case; got {', '.join(found.names)}")
    who, file = _who_moves(found, motion)
    poses, notes = _read(found.persons[who].body, file, take)
    moving = replace(found.persons[who], poses=poses, seat=None, stand=None)
    persons = list(found.persons)
    bodies = list(found.scene.bodies)
    persons[who], bodies[who] = moving, _first(moving, bodies[who].colour)
    scene = replace(found.scene, bodies=tuple(bodies))
    return replace(
        found, scene=scene, names=(), persons=tuple(persons), moving=True, notes=found.notes + notes
    )


def _who_moves(found: Source, motion: str) -> tuple[int, Path]:
    name, equals, file = motion.partition("=")
    if not equals or Path(motion).exists():
        return 0, Path(motion)
    if name not in found.people:
        raise UsageError(
            f"--motion {motion}: nobody is called {name!r}; {one_of(name, found.people)}"
        )
    return found.people.index(name), Path(file)


def _read(body: Body, file: Path, take: MotionClip) -> tuple[Poses, tuple[str, ...]]:
    if not file.is_file():
        raise InputError(f"{file}: no such motion file")
    keep = Pick(
        -math.inf if take.start is None else take.start, math.inf if take.end is None else take.end
    )
    poses, notes = load_motion(body, file, options=MotionOptions(up=take.up, keep=keep))
    if len(poses) < 2:
        raise InputError(f"{file}: one frame is a posture; a motion needs two or more")
    return replace(poses, time=poses.clock), notes


def _first(person: Person, colour: str) -> SceneBody:
    poses = person.poses
    return SceneBody(
        place(
            person.body, Poses(poses.rotations[:1], poses.reference, poses.world_from_reference[:1])
        ),
        0,
        colour,
    )


def overlay(source: Source, under: Source, names: tuple[str, str]) -> Source:
    """A source over the bodies of another one, which show pale behind its own in a second colour:
    predicted, actual.

    names: of both, for the picture's key. Both may move, each on its own clock; the time they share
    is shown (see shown_span). InputError where they share none; UsageError where one has no body,
    or they have different numbers of cases.
    """
    for found, name in zip((source, under), names, strict=True):
        if not found.scene.bodies:
            raise UsageError(f"--over: there is no body in {name}")
    counts = [1 if found.moving else max(len(found.names), 1) for found in (source, under)]
    if counts[1] not in (1, counts[0]):
        raise UsageError(
            f"--over: {names[1]} has {counts[1]} cases and {names[0]} {counts[0]}; as many, or one"
        )
    bodies = tuple(replace(shown, colour=_OVER) for shown in source.scene.bodies)
    shown_under = [
        k
        for k, person in enumerate(under.persons)
        if not under.moving or person.poses.time is not None
    ]
    ghosts = tuple(replace(under.scene.bodies[k], colour=_UNDER) for k in shown_under)
    scene = replace(
        source.scene, bodies=bodies, ghosts=ghosts, key=((names[0], _OVER), (names[1], _UNDER))
    )
    persons = tuple(under.persons[k] for k in shown_under)
    over = replace(
        source,
        scene=scene,
        under=persons,
        moving=source.moving or under.moving,
        names=() if under.moving else source.names,
        notes=source.notes + under.notes,
    )
    if over.moving:
        common_time_span(over)
    return over


def common_time_span(source: Source) -> tuple[float, float]:
    """First and last time [s] that everybody who moves in a source has in common. InputError where
    there is none."""
    clocks = [p.poses.time for p in (*source.persons, *source.under) if p.poses.time is not None]
    start = max(float(clock[0]) for clock in clocks)
    end = min(float(clock[-1]) for clock in clocks)
    if end < start:
        told = " and ".join(f"{clock[0]:g} to {clock[-1]:g} s" for clock in clocks)
        raise InputError(f"the motions have no time in common: {told}")
    return start, end


def parse_times(text: str) -> tuple[float, ...]:
    """Times [s] from "0,0.05,90ms"; UsageError for anything else."""
    found = []
    for part in text.split(","):
        match = re.fullmatch(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(s|ms|)", part.strip())
        if match is None:
            raise UsageError(
                f"--at: times with commas between are needed, such as 0,0.05,90ms; got {text!r}"
            )
        found.append(float(match[1]) * (1e-3 if match[2] == "ms" else 1.0))
    return tuple(found)


def evenly_spaced_times(source: Source, count: int = POSITIONS) -> tuple[float, ...]:
    """`count` times [s] of a motion, from its first to its last."""
    return tuple(np.linspace(*common_time_span(source), count).tolist())


def at_times(source: Source, times: Sequence[float]) -> Source:
    """A moving source at some moments [s], each named by its time. UsageError where it does not
    move, or not then."""
    if not source.moving:
        raise UsageError(f"--at: nothing moves in {source.scene.title}; give a motion")
    start, end = common_time_span(source)
    late = [time for time in times if not start - 1e-9 <= time <= end + 1e-9]
    if late:
        raise UsageError(
            f"--at: the motion goes from {start:g} to {end:g} s, got {', '.join(f'{t:g}' for t in late)}"
        )
    short = end - start < _SHORT
    names = tuple(f"{1000.0 * time:.0f} ms" if short else f"{time:.2f} s" for time in times)
    return replace(source.at(np.array(times)), names=names, moving=False)


def is_motion(text: str) -> bool:
    """Whether a word names a motion file, by its ending."""
    return Path(text).suffix.lower() in MOTIONS
