"""The motions of an open study in a state: where their people are at each frame, and the verdicts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import combinations
from threading import Lock

import numpy as np

from workbench.body.forward import place
from workbench.contact.collide import body_clearance, self_clearance
from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats
from workbench.model.criterion import Criterion
from workbench.model.joint_angles import poses_at
from workbench.model.motion_case import MotionCase
from workbench.model.poses import Placed
from workbench.model.result import Verdict
from workbench.model.surroundings import Move
from workbench.study.bench.near import (
    MOST_NEAR,
    NearPair,
    Someone,
    Tolerances,
    own_pair,
    part_pairs,
    people_pair,
)
from workbench.study.bench.state import Arrangement, OpenStudy, Settings, arranged_environment
from workbench.study.crash.crash import motion_found
from workbench.study.motion_cases import motion_cases, moved_case
from workbench.study.motions import frame_rooms
from workbench.study.run import between_motions

__all__ = [
    "MotionsJudged",
    "Playing",
    "check_motion",
    "motion_names",
    "motion_state",
    "motions_judged",
    "near_in_frame",
    "playing",
]

_READING = Lock()
"""Held while motions are read: two threads that want the same ones read them once."""


@dataclass(frozen=True, eq=False)
class Playing:
    """A case that is a motion, in a state: what each role does in it, at the frames of all.

    between: the criteria that are asked between people.
    """

    motions: tuple[MotionCase, ...]
    between: tuple[Criterion, ...] = ()

    @cached_property
    def clock(self) -> Floats:
        """(P,) [s] every time at which one of the motions has a frame."""
        return np.unique(np.concatenate([one.motion.clock for one in self.motions]))

    def placed(self, times: Floats) -> tuple[Placed, ...]:
        """Each role at times (F,) [s]; who has no frame there is on the way between two."""
        return tuple(place(one.body, poses_at(one.motion, times)) for one in self.motions)


def motion_names(opened: OpenStudy) -> tuple[str, ...]:
    """The names of the cases that are motions."""
    return () if opened.moving is None else tuple(case.name for case in opened.moving.cases)


def check_motion(opened: OpenStudy, case: str) -> None:
    """Raise InputError if no case that is a motion is called so."""
    names = motion_names(opened)
    if case not in names:
        raise InputError(f"no motion {case!r}; {one_of(case, names)}")


def playing(opened: OpenStudy, arrangement: Arrangement, case: str) -> Playing:
    """Put a motion of a study into a state of it. It is read once, which may take seconds.

    Raises
    ------
    InputError
        If no case that is a motion is called so, or the motion cannot be read.
    """
    check_motion(opened, case)
    assert opened.moving is not None
    every = _read(opened, arrangement)
    criteria = (*opened.moving.criteria, *arrangement.added)
    between = tuple(one for one in criteria if one.check == "between_people")
    return Playing(tuple(one for one in every if one.case == case), between)


@dataclass(frozen=True, eq=False)
class MotionsJudged:
    """What is found of the motions of a state, one after the other.

    Parameters
    ----------
    state
        What of the state they depend on.
    verdicts, warnings
        Of the motions that were judged.
    done, of
        How many these are, and how many there are.
    """

    state: tuple[object, ...]
    verdicts: tuple[Verdict, ...]
    warnings: tuple[str, ...]
    done: int
    of: int


def motion_state(arrangement: Arrangement) -> tuple[object, ...]:
    """What of a state its motions and their verdicts depend on."""
    return arrangement.moves, arrangement.settings, arrangement.added


def motions_judged(
    opened: OpenStudy, arrangement: Arrangement, *, go_on: Callable[[], None] | None = None
) -> Iterator[MotionsJudged]:
    """Judge the motions of a state as a run of its study does, one after the other.

    Parameters
    ----------
    go_on
        Is called on the way, some seconds apart, and may raise what ends it.
    """
    if opened.moving is None:
        return
    motions = _read(opened, arrangement)
    verdicts: list[Verdict] = []
    warnings: list[str] = []
    state = motion_state(arrangement)
    for number, one in enumerate(motions, start=1):
        found = motion_found(one, go_on=go_on)
        verdicts += found.verdicts
        warnings += [f"{one.name}: {line}" for line in found.warnings]
        if number == len(motions):
            study = replace(opened.moving, criteria=(*opened.moving.criteria, *arrangement.added))
            verdicts += between_motions(study, motions)
        yield MotionsJudged(state, tuple(verdicts), tuple(warnings), number, len(motions))


def _read(opened: OpenStudy, arrangement: Arrangement) -> tuple[MotionCase, ...]:
    """The motions of a state, read by one thread while others wait."""
    with _READING:
        return _in_state(opened, arrangement.moves, arrangement.settings, arrangement.added)


def near_in_frame(found: Playing, frame: int) -> list[NearPair]:
    """The nearest pairs at a frame of a motion, the worst first, as of a posture."""
    times = found.clock[frame : frame + 1]
    placed = found.placed(times)
    rows: list[NearPair] = []
    people = []
    for motion, one in zip(found.motions, placed, strict=True):
        someone = Someone(motion.person, motion.body)
        tolerances = Tolerances(motion.criteria, motion.case)
        rows += part_pairs(
            someone, motion.environment, frame_rooms(motion, one), tolerances=tolerances
        )
        rows += own_pair(someone, self_clearance(one))
        people.append((someone, one))
    for (mine, here), (yours, there) in combinations(people, 2):
        tolerances = Tolerances(found.between, found.motions[0].case)
        near = body_clearance(here, there)
        rows.append(people_pair(mine, yours, near, tolerances=tolerances))
    return sorted(rows, key=lambda pair: pair.room)[:MOST_NEAR]


@lru_cache(maxsize=2)
def _as_opened(opened: OpenStudy) -> tuple[MotionCase, ...]:
    """The motions as the study's file has them."""
    assert opened.moving is not None
    return motion_cases(opened.moving)


@lru_cache(maxsize=4)
def _in_state(
    opened: OpenStudy,
    moves: tuple[Move, ...],
    settings: Settings,
    added: tuple[Criterion, ...],
) -> tuple[MotionCase, ...]:
    """The same objects for the same state, so that what is indexed for them serves again."""
    start = opened.start
    first = _as_opened(opened)
    if (moves, settings, added) == (start.moves, start.settings, start.added):
        return first
    assert opened.moving is not None
    study = replace(
        opened.moving,
        criteria=(*opened.moving.criteria, *added),
        environment=arranged_environment(opened, replace(start, moves=moves, settings=settings)),
        settings=dict(settings),
        moved=moves,
    )
    return tuple(moved_case(study, one) for one in first)
