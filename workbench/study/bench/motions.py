"""The motions of an open study in a state: where their people are at each frame, and the verdicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from workbench.body.forward import place
from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats
from workbench.model.criterion import Criterion
from workbench.model.motion_case import MotionCase
from workbench.model.moves import Move
from workbench.model.moving import poses_at
from workbench.model.poses import Placed
from workbench.model.result import Verdict
from workbench.study.bench.state import Arrangement, OpenStudy, arranged_environment
from workbench.study.crash.crash import motion_found
from workbench.study.motion_cases import motion_cases, moved_case
from workbench.study.run import between_motions

__all__ = ["Playing", "motion_names", "motion_verdicts", "playing"]


@dataclass(frozen=True, eq=False)
class Playing:
    """A case that is a motion, in a state: what each role does in it, at the frames of all."""

    motions: tuple[MotionCase, ...]

    @cached_property
    def clock(self) -> Floats:
        """(P,) [s] every time at which one of the motions has a frame."""
        every: Floats = np.unique(np.concatenate([one.motion.clock for one in self.motions]))
        return every

    def placed(self, times: Floats) -> tuple[Placed, ...]:
        """Each role at times (F,) [s]; who has no frame there is on the way between two."""
        return tuple(place(one.body, poses_at(one.motion, times)) for one in self.motions)


def motion_names(opened: OpenStudy) -> tuple[str, ...]:
    """The names of the cases that are motions."""
    return () if opened.moving is None else tuple(case.name for case in opened.moving.cases)


def playing(opened: OpenStudy, arrangement: Arrangement, case: str) -> Playing:
    """Put a motion of a study into a state of it. It is read once, which may take seconds.

    Raises
    ------
    InputError
        If no case that is a motion is called so, or the motion cannot be read.
    """
    names = motion_names(opened)
    if case not in names:
        raise InputError(f"no motion {case!r}; {one_of(case, names)}")
    every = _in_state(opened, arrangement.moves, arrangement.added)
    return Playing(tuple(one for one in every if one.case == case))


def motion_verdicts(opened: OpenStudy, arrangement: Arrangement) -> tuple[Verdict, ...]:
    """Judge the motions of a state as a run of its study does; () where there are none."""
    if opened.moving is None:
        return ()
    return _verdicts(opened, arrangement.moves, arrangement.added)


@lru_cache(maxsize=2)
def _as_opened(opened: OpenStudy) -> tuple[MotionCase, ...]:
    """The motions as the study's file has them."""
    assert opened.moving is not None
    return motion_cases(opened.moving)


@lru_cache(maxsize=4)
def _in_state(
    opened: OpenStudy, moves: tuple[Move, ...], added: Sequence[Criterion]
) -> tuple[MotionCase, ...]:
    """The same objects for the same state, so that what is indexed for them serves again."""
    start = opened.start
    first = _as_opened(opened)
    if (moves, added) == (start.moves, start.added):
        return first
    assert opened.moving is not None
    study = replace(
        opened.moving,
        criteria=(*opened.moving.criteria, *added),
        environment=arranged_environment(opened, moves),
        moved=moves,
    )
    return tuple(moved_case(study, one) for one in first)


@lru_cache(maxsize=4)
def _verdicts(
    opened: OpenStudy, moves: tuple[Move, ...], added: Sequence[Criterion]
) -> tuple[Verdict, ...]:
    motions = _in_state(opened, moves, added)
    found = [verdict for one in motions for verdict in motion_found(one).verdicts]
    assert opened.moving is not None
    study = replace(opened.moving, criteria=(*opened.moving.criteria, *added))
    return (*found, *between_motions(study, motions))
