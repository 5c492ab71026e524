"""The crash study: a motion against an environment, in continuous time: what meets what, when, how
fast, how deep."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from workbench.body.forward import place
from workbench.body.pieces import piece_warnings
from workbench.contact.collide import nearest, self_clearance
from workbench.contact.episodes import episodes, self_episodes
from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints, pieces
from workbench.model.body import Body
from workbench.model.contacts import Clearance, Episodes
from workbench.model.joint_angles import poses_at
from workbench.model.motion_case import Agreement, ContactEvent, MotionCase
from workbench.model.poses import Placed, Poses
from workbench.model.result import MotionFound
from workbench.study.checks.table import motion_verdict
from workbench.study.crash.belts import belt_tensions
from workbench.study.crash.frames import (
    BLOCK,
    force_curves,
    frames_of,
    ruled_pairs,
    signal_of,
    stop_breaches,
    with_forces,
)
from workbench.study.unasked import meeting_warnings, unasked_meetings
from workbench.study.warnings import enclosure_warnings

__all__ = ["environment_meetings", "motion_found", "motions_agree", "own_meetings"]

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


_BLOCK = 64
_STEP = 1e-4
"""Speeds are differences over this share of the time between two frames."""


def environment_meetings(study: MotionCase, found: Episodes) -> Iterator[ContactEvent]:
    """A meeting for each episode with the environment."""
    for rows in _blocks(len(found)):
        some = found.rows(rows)
        at = _Moments(study, some)
        pairs = np.column_stack([np.arange(len(some)), some.segment, some.part])
        begun, deep = (
            nearest(when, study.environment, rows=pairs) for when in (at.enter, at.deepest)
        )
        for k in range(len(some)):
            where = (k, int(some.segment[k]), int(some.part[k]))
            yield _meeting(study, some, k, begun, deep, where, at.speed(begun, where, other=None))


def own_meetings(study: MotionCase, found: Episodes) -> Iterator[ContactEvent]:
    """A meeting for each episode of two segments of the body."""
    for rows in _blocks(len(found)):
        some = found.rows(rows)
        at = _Moments(study, some)
        begun = self_clearance(at.enter)
        deep = self_clearance(at.deepest)
        for k in range(len(some)):
            one, two = sorted((int(some.segment[k]), int(some.other_segment[k])))
            where = (k, one, two)
            yield _meeting(
                study, some, k, begun, deep, where, at.speed(begun, where, other=begun.target)
            )


def _blocks(count: int) -> Iterator[Ints]:
    for first in range(0, count, _BLOCK):
        yield np.arange(first, min(first + _BLOCK, count))


class _Moments:
    """The body at the beginning and at the deepest moment of each episode, and just before and
    after the beginning."""

    def __init__(self, study: MotionCase, some: Episodes) -> None:
        self.study = study
        motion = study.motion
        time = motion.clock
        step = _STEP * float(np.min(np.diff(time)))
        self.before = np.maximum(some.enter - step, time[0])
        self.after = np.minimum(self.before + 2 * step, time[-1])
        self.enter, self.deepest = (
            self._placed(motion, some.enter),
            self._placed(motion, some.deepest),
        )
        self.pair = self._placed(motion, self.before), self._placed(motion, self.after)

    def _placed(self, motion: Poses, times: Floats) -> Placed:
        return place(self.study.body, poses_at(motion, times))

    def speed(self, begun: Clearance, where: tuple[int, int, int], *, other: Ints | None) -> Floats:
        """(3,) speed, its part toward the other, its part along it [m/s] of the sphere that meets
        first."""
        k = where[0]
        sphere = int(begun.sphere[where])
        if sphere < 0:
            return np.zeros(3)
        moved = self._moved(k, sphere)
        if other is not None and other[where] >= 0:
            moved = moved - self._moved(k, int(other[where]))
        toward = begun.point[where] - self.enter.centres[k, sphere]
        inside = begun.distance[where] < -self.study.body.radius[0, sphere]
        length = float(np.linalg.norm(toward))
        normal = (
            float(moved @ toward) / length * (-1.0 if inside else 1.0) if length > 1e-12 else 0.0
        )
        speed = float(np.linalg.norm(moved))
        return np.array([speed, normal, np.sqrt(max(speed**2 - normal**2, 0.0))])

    def _moved(self, k: int, sphere: int) -> Floats:
        gap = self.pair[1].centres[k, sphere] - self.pair[0].centres[k, sphere]
        return np.asarray(gap / (self.after[k] - self.before[k]))


def _meeting(
    study: MotionCase,
    some: Episodes,
    k: int,
    begun: Clearance,
    deep: Clearance,
    where: tuple[int, int, int],
    speeds: Floats,
) -> ContactEvent:
    """The meeting k of some episodes: as it begins and at its deepest, at (pose, segment, other)."""
    began, lasts = some.cut_short
    at = deep if deep.sphere[where] >= 0 else begun
    x, y, z = (float(v) for v in at.point[where])
    polygon, other_sphere = at.met(where)
    return ContactEvent(
        segment=study.body.segments[where[1]],
        who=at.name(where) if began[k] or begun.sphere[where] < 0 else begun.name(where),
        other=study.environment.parts[where[2]] if some.part[k] >= 0 else at.other_name(where),
        enter=float(some.enter[k]),
        deepest=float(some.deepest[k]),
        leave=float(some.leave[k]),
        began=bool(began[k]),
        lasts=bool(lasts[k]),
        depth=float(-some.distance[k]),
        allowed=float(some.allowed[k]),
        speed=float(speeds[0]),
        normal=float(speeds[1]),
        tangential=float(speeds[2]),
        point=(x, y, z),
        own=some.part[k] < 0,
        deep=at.name(where),
        sphere=int(at.sphere[where]),
        polygon=polygon,
        other_sphere=other_sphere,
    )
