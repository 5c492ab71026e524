"""Episodes of contact as meetings: who meets what, where, how fast and how deep."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from workbench.body.forward import place
from workbench.contact.collide import nearest, self_clearance
from workbench.model.arrays import Floats, Ints
from workbench.model.contacts import Clearance
from workbench.model.episodes import Episodes
from workbench.model.motion_case import Meeting, MotionCase
from workbench.model.moving import poses_at
from workbench.model.poses import Placed, Poses

__all__ = ["environment_meetings", "own_meetings"]

_BLOCK = 64
_STEP = 1e-4
"""Speeds are differences over this share of the time between two frames."""


def environment_meetings(study: MotionCase, found: Episodes) -> Iterator[Meeting]:
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


def own_meetings(study: MotionCase, found: Episodes) -> Iterator[Meeting]:
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
) -> Meeting:
    """The meeting k of some episodes: as it begins and at its deepest, at (pose, segment, other)."""
    began, lasts = some.cut_short
    at = deep if deep.sphere[where] >= 0 else begun
    x, y, z = (float(v) for v in at.point[where])
    polygon, other_sphere = at.met(where)
    return Meeting(
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
