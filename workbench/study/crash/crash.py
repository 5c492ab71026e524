"""The crash study: a motion against an environment, in continuous time: what meets what, when, how
fast, how deep."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from workbench.body.forward import place
from workbench.body.pieces import piece_warnings
from workbench.contact.episodes import episodes, self_episodes
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.motion_case import Agreement, MotionCase
from workbench.model.moving import poses_at
from workbench.model.poses import Poses
from workbench.model.result import MotionFound
from workbench.model.spool import pieces
from workbench.study.checks.table import motion_verdict
from workbench.study.crash.belts import belt_tensions
from workbench.study.crash.forces import force_curves, ruled_pairs, with_forces
from workbench.study.crash.frames import BLOCK, frames_of, stop_breaches
from workbench.study.crash.meetings import environment_meetings, own_meetings
from workbench.study.crash.signals import signal_of
from workbench.study.unasked import meeting_warnings, unasked_meetings
from workbench.study.warnings import enclosure_warnings

__all__ = ["motion_found", "motions_agree"]

_LOOKS = 16
"""Frames in which the surroundings are searched for open parts that enclose the person."""


def motion_found(study: MotionCase, *, go_on: Callable[[], None] | None = None) -> MotionFound:
    """Find what meets what in a motion, when, how fast and how deep, and judge its criteria.

    Parameters
    ----------
    go_on
        Is called between the steps, and may raise what ends them.
    """
    check = go_on or _nothing
    body = study.body
    motion = study.motion
    environment = study.environment
    found = episodes(body, motion, environment)
    check()
    own = self_episodes(body, motion)
    check()
    frames = frames_of(study)
    check()
    breaches = stop_breaches(body, motion)
    check()
    pairs = ruled_pairs(study)
    signals = tuple(
        signal_of(motion.clock, path, point, study)
        for path, point in zip(frames.paths, study.points, strict=True)
    )
    meetings = (*with_forces(study, environment_meetings(study, found)), *own_meetings(study, own))
    check()
    unasked = unasked_meetings(study.criteria, meetings)
    result = MotionFound(
        study=study,
        episodes=found,
        meetings=tuple(sorted(meetings, key=lambda m: m.enter)),
        breaches=breaches,
        signals=signals,
        clearance=frames.clearance,
        excursions=frames.excursions,
        verdicts=(),
        warnings=(
            *frames.coarse,
            *piece_warnings([(study.person, body)]),
            *_enclosed(study),
            *meeting_warnings(unasked),
            *study.warnings,
        ),
        forces=(*belt_tensions(study), *force_curves(study, pairs, frames.gaps)),
    )
    return replace(
        result, verdicts=tuple(motion_verdict(criterion, result) for criterion in study.criteria)
    )


def _nothing() -> None:
    """Every step is taken."""


def _enclosed(study: MotionCase) -> tuple[str, ...]:
    """Open parts that enclose the person in any of a few frames, spread over the motion."""
    if not study.environment.undecided:
        return ()
    times = study.motion.clock[:: max(len(study.motion) // _LOOKS, 1)]
    placed = place(study.body, poses_at(study.motion, times))
    return tuple(enclosure_warnings(study.person, placed, study.environment))


def motions_agree(one: MotionCase, two: MotionCase) -> tuple[Agreement, ...]:
    """Compare each joint and segment of a motion with the other's, at the motion's frames within
    the time of both. InputError for motions that have no time in common."""
    time = one.motion.clock
    other = two.motion.clock
    both = (time >= other[0]) & (time <= other[-1])
    if not both.any():
        raise InputError(
            f"the motions have no time in common: {time[0]:g} to {time[-1]:g} s and {other[0]:g} to "
            f"{other[-1]:g} s"
        )
    body = one.body
    shared = time[both]
    names = (*body.segment_names, *_joint_words(body))
    squares = np.zeros(len(names))
    peak = np.full(len(names), -1.0)
    at = np.zeros(len(names))
    for rows in pieces(len(shared), size=BLOCK):
        here, there = (
            _points(body, poses_at(poses, shared[rows])) for poses in (one.motion, two.motion)
        )
        apart = np.linalg.norm(here - there, axis=2)
        squares += (apart**2).sum(axis=0)
        worst = np.argmax(apart, axis=0)
        most = np.take_along_axis(apart, worst[None], axis=0)[0]
        more = most > peak
        peak[more] = most[more]
        at[more] = shared[rows][worst[more]]
    rms = np.sqrt(squares / len(shared))
    return tuple(
        Agreement(names[k], float(rms[k]), float(peak[k]), float(at[k])) for k in _of_the_body(body)
    )


def _joint_words(body: Body) -> Iterator[str]:
    """The joints by their names: "left clavicular joint", "waist joint"."""
    return (name if name.endswith("joint") else f"{name} joint" for name in body.joint_names)


def _of_the_body(body: Body) -> list[int]:
    """Which of the segments and joints belong to the person: not the stage, the ground of the
    paper, and not the joint that hangs the person on it."""
    segments = len(body.segments)
    first = 0 if body.start[1] > 0 else 1  # a root that has spheres is a part of the body
    joints = np.flatnonzero(body.parent[1:] >= first)
    return [*range(first, segments), *(segments + joints).tolist()]


def _points(body: Body, poses: Poses) -> Floats:
    """(P, N + J, 3) [m] centres of gravity of the segments, then the joints."""
    world = place(body, poses).world_from_segment
    joints = (
        np.einsum("pjik,jk->pji", world[:, 1:, :, :3], body.joint_in_child[0]) + world[:, 1:, :, 3]
    )
    return np.concatenate([world[..., 3], joints], axis=1)
