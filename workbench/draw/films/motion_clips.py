"""Build sources that move as a motion file says, and overlay one source on another."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.body.forward import place
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.scene_builder import build_source, source_kind
from workbench.draw.source import PEOPLE_COLOURS, Source
from workbench.errors import InputError, UsageError, one_of
from workbench.files.body.bodies import load_body
from workbench.files.motions.reading import MOTIONS
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.person import Person
from workbench.model.poses import Poses
from workbench.study.motions import MotionOptions, load_motion

__all__ = [
    "DEFAULT_POSITIONS",
    "at_times",
    "clocks",
    "common_time_span",
    "evenly_spaced_times",
    "is_motion",
    "overlay",
    "parse_times",
    "with_motion",
]

DEFAULT_POSITIONS = 4
"""Number of poses of a motion in a picture, as in the paper's Figure 7."""
_COLOUR, _GHOST_COLOUR = PEOPLE_COLOURS[:2]
_MILLISECOND_SPAN = 2.0
"""Motions shorter than this [s] have times in milliseconds."""


def with_motion(
    source: str, motion: str, *, clip: MotionOptions | None = None, case: str | None = None
) -> Source:
    """Build a body, or a study with one person, that moves as a motion file says.

    Parameters
    ----------
    source
        A body or a study.
    motion
        The motion file. In a study the first person moves, or the named one: "pilot=drive.csv".
    clip
        The part of the file that is wanted.
    case
        The case in which the other people of a study sit; the first if None.

    Raises
    ------
    InputError
        If a file cannot be read, or holds a single frame.
    UsageError
        If source and options do not go together.
    """
    kind = source_kind(source)
    if kind == "body":
        if case is not None:
            raise UsageError(f"{source} is a body: --case is for studies")
        body = load_body(source)
        poses, notes = _read_motion(body, Path(motion), clip)
        person = Person(body.name, body, poses)
        scene = Scene((_first_frame(person, _COLOUR),), None, (), body.name, Path(motion).name)
        return Source(scene, (), (body.name,), (person,), True, notes)
    if kind != "study":
        article = "an" if kind[0] == "e" else "a"
        raise UsageError(f"{source} is {article} {kind}: --motion is for bodies and studies")
    return _study_with_motion(build_source(source, case=case), motion, clip)


def _study_with_motion(source: Source, motion: str, clip: MotionOptions | None) -> Source:
    if source.moving:
        raise UsageError(f"{source.scene.title} brings its own motion: leave out --motion")
    if len(source.names) > 1:
        raise UsageError(f"--motion: the others sit as in one case; got {', '.join(source.names)}")
    index, file = _moving_person(source, motion)
    poses, notes = _read_motion(source.persons[index].body, file, clip)
    persons = list(source.persons)
    bodies = list(source.scene.bodies)
    persons[index] = replace(persons[index], poses=poses)
    bodies[index] = _first_frame(persons[index], bodies[index].colour)
    return replace(
        source,
        scene=replace(source.scene, bodies=tuple(bodies)),
        names=(),
        persons=tuple(persons),
        moving=True,
        notes=source.notes + notes,
    )


def _moving_person(source: Source, motion: str) -> tuple[int, Path]:
    """Return the index of the person that "FILE" or "NAME=FILE" moves, and the file."""
    name, equals, file = motion.partition("=")
    if not equals or Path(motion).exists():
        return 0, Path(motion)
    if name not in source.people:
        raise UsageError(
            f"--motion {motion}: nobody is called {name!r}; {one_of(name, source.people)}"
        )
    return source.people.index(name), Path(file)


def _read_motion(
    body: Body, file: Path, clip: MotionOptions | None
) -> tuple[Poses, tuple[str, ...]]:
    """Read a motion as poses of a body with times, and notes on what was assumed."""
    if not file.is_file():
        raise InputError(f"{file}: no such motion file")
    poses, notes = load_motion(body, file, options=clip)
    if len(poses) < 2:
        raise InputError(f"{file}: one frame is a posture; a motion needs two or more")
    return replace(poses, time=poses.clock), notes


def _first_frame(person: Person, colour: str) -> SceneBody:
    return SceneBody(place(person.body, replace(person.poses.rows(slice(1)), time=None)), 0, colour)


def overlay(source: Source, under: Source, names: tuple[str, str]) -> Source:
    """Show the bodies of another source as ghosts behind a source, such as predicted over actual.

    Both may move, each with its own clock. The time span that they share is shown, see
    `common_time_span`.

    Parameters
    ----------
    source, under
        What is shown in front and behind.
    names
        Names of both for the legend of the picture.

    Raises
    ------
    InputError
        If they share no time.
    UsageError
        If one has no body, or they differ in the number of cases.
    """
    _check_overlay(source, under, names)
    behind = [
        (replace(shown, colour=_GHOST_COLOUR), person)
        for shown, person in zip(under.scene.bodies, under.persons, strict=True)
        if not under.moving or person.poses.time is not None
    ]
    scene = replace(
        source.scene,
        bodies=tuple(replace(shown, colour=_COLOUR) for shown in source.scene.bodies),
        ghosts=tuple(shown for shown, _ in behind),
        key=((names[0], _COLOUR), (names[1], _GHOST_COLOUR)),
    )
    overlaid = replace(
        source,
        scene=scene,
        under=tuple(person for _, person in behind),
        moving=source.moving or under.moving,
        names=() if under.moving else source.names,
        notes=source.notes + under.notes,
    )
    if overlaid.moving:
        common_time_span(overlaid)
    return overlaid


def _check_overlay(source: Source, under: Source, names: tuple[str, str]) -> None:
    """Raise `UsageError` if one source has no body, or the numbers of cases do not match."""
    for each, name in zip((source, under), names, strict=True):
        if not each.scene.bodies:
            raise UsageError(f"--over: there is no body in {name}")
    counts = [1 if each.moving else max(len(each.names), 1) for each in (source, under)]
    if counts[1] not in (1, counts[0]):
        raise UsageError(
            f"--over: {names[1]} has {counts[1]} cases and {names[0]} {counts[0]}; as many, or one"
        )


def clocks(source: Source) -> list[Floats]:
    """Return the times (F,) [s] of each person and ghost whose poses have times."""
    people = (*source.persons, *source.under)
    return [person.poses.time for person in people if person.poses.time is not None]


def common_time_span(source: Source) -> tuple[float, float]:
    """Return the first and last time [s] that all moving people of a source have in common.

    Raises
    ------
    InputError
        If there is none.
    """
    times = clocks(source)
    start = max(float(time[0]) for time in times)
    end = min(float(time[-1]) for time in times)
    if end < start:
        spans = " and ".join(f"{time[0]:g} to {time[-1]:g} s" for time in times)
        raise InputError(f"the motions have no time in common: {spans}")
    return start, end


def parse_times(text: str) -> tuple[float, ...]:
    """Read times such as "0,0.05,90ms" in seconds.

    Raises
    ------
    UsageError
        If the text is anything else.
    """
    times = []
    for part in text.split(","):
        match = re.fullmatch(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(s|ms|)", part.strip())
        if match is None:
            raise UsageError(
                f"--at: times with commas between are needed, such as 0,0.05,90ms; got {text!r}"
            )
        times.append(float(match[1]) * (1e-3 if match[2] == "ms" else 1.0))
    return tuple(times)


def evenly_spaced_times(source: Source, count: int = DEFAULT_POSITIONS) -> tuple[float, ...]:
    """Return `count` times [s] of a motion, from its first to its last."""
    return tuple(np.linspace(*common_time_span(source), count).tolist())


def at_times(source: Source, times: Sequence[float]) -> Source:
    """Show a moving source at some times [s], as poses that carry their times as names.

    Raises
    ------
    UsageError
        If it does not move, or not at these times.
    """
    if not source.moving:
        raise UsageError(f"--at: nothing moves in {source.scene.title}; give a motion")
    start, end = common_time_span(source)
    outside = [time for time in times if not start - 1e-9 <= time <= end + 1e-9]
    if outside:
        given = ", ".join(f"{time:g}" for time in outside)
        raise UsageError(f"--at: the motion goes from {start:g} to {end:g} s, got {given}")
    short = end - start < _MILLISECOND_SPAN
    names = tuple(f"{1000.0 * time:.0f} ms" if short else f"{time:.2f} s" for time in times)
    return replace(source.at(np.array(times)), names=names, moving=False)


def is_motion(text: str) -> bool:
    """Return whether a word names a motion file, by its ending."""
    return Path(text).suffix.lower() in MOTIONS
