"""The turnable picture of a motion: the body in frames that can be scrubbed, its belts, contacts
while they last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.body.forward import place
from workbench.draw.web.views import WebBody, WebGaps, WebMark, WebView, body_view
from workbench.model.arrays import Floats, pieces
from workbench.model.joint_angles import poses_at
from workbench.model.motion_case import MotionCase
from workbench.model.poses import Placed
from workbench.model.result import MotionFound
from workbench.model.units import plain
from workbench.study.crash.belts import belt_line
from workbench.study.crash.frames import BLOCK
from workbench.study.motions import (
    AskedGap,
    asked_gaps,
    distance_criteria,
    nearest_criterion,
)

__all__ = ["cord_counts", "motion_bodies", "motion_view"]

_MOST_PLACES = 42_000
"""Spheres times frames of a motion on a page: 43 frames of 980 spheres are about 100 kB."""
_FRAMES = (2, 61)
"""Least and most frames."""
_MOST_GAPS = 400
"""Times at which gaps are shown."""
_MOST_MARKS = 12
_CORD = 0.009
"""Radius [m] of the cord as which a belt is shown."""
_BELT_COLOUR = (70, 84, 104)


def motion_view(
    motion: MotionFound,
    colour: str,
    *,
    times: Floats | None = None,
    moments: Sequence[float] = (),
) -> WebView:
    """Return the turnable picture of a motion.

    Parameters
    ----------
    motion
        The motion and its contacts. Those deeper than allowed are marked, and their spheres are
        red, while they last.
    colour
        Colour family of the body.
    times
        (F,) [s] at which it is shown; evenly spaced over the motion where None.
    moments
        [s] shown besides the evenly spaced ones, as far as they lie within the motion.
    """
    study = motion.study
    clock = study.motion.clock
    if len(clock) < 2:
        times = clock
        placed = place(study.body, study.motion)
    else:
        times = _times(study, moments) if times is None else times
        placed = place(study.body, poses_at(study.motion, times))
    counts = cord_counts(study, placed)
    bodies = motion_bodies(study, placed, colour, counts, touching=_touching(motion))
    title = f"{study.person}, {study.name}" if study.name else study.person
    marks = _marks(motion)
    return WebView(title, bodies, study.cabin, marks, tuple(times.tolist()), gaps=_gaps(motion))


def _times(study: MotionCase, moments: Sequence[float]) -> Floats:
    """(F,) [s] evenly over a motion, as many as a page can hold, and the moments within it."""
    clock = study.motion.clock
    count = int(np.clip(_MOST_PLACES // max(len(study.body.sphere_names), 1), *_FRAMES))
    even = np.linspace(clock[0], clock[-1], min(count, max(len(clock), 2)))
    return np.union1d(even, [time for time in moments if clock[0] < time < clock[-1]])


def _gaps(motion: MotionFound) -> WebGaps | None:
    """How near the motion comes at its frames, and the criterion about distances that is nearest to
    failing, thinned so that no least gap is lost."""
    study = motion.study
    least = np.nan_to_num(motion.clearance, nan=np.inf).min(axis=1, initial=np.inf)
    if len(least) < 2 or not np.isfinite(least).any():
        return None
    segment = study.body.segment_names[
        int(np.nan_to_num(motion.clearance, nan=np.inf).min(axis=0).argmin())
    ]
    near = nearest_criterion(_asked(study))
    groups = np.array_split(np.arange(len(least)), min(len(least), _MOST_GAPS))
    rows = [int(group[np.argmin(least[group])]) for group in groups]
    found = WebGaps(study.motion.clock[rows], least[rows], segment)
    if near is None:
        return found
    asked = np.array([near.distance[group].min() for group in groups])
    return replace(found, name=near.criterion.name, limit=near.limit, asked=asked)


def _asked(study: MotionCase) -> list[AskedGap]:
    """What the criteria about distances find at all frames, some of them placed at a time."""
    criteria = distance_criteria(study)
    found = [
        asked_gaps(study, place(study.body, study.motion.rows(rows)), criteria)
        for rows in pieces(len(study.motion), size=BLOCK)
    ]
    return [
        AskedGap(one[0].criterion, np.concatenate([gap.distance for gap in one]), one[0].limit)
        for one in zip(*found, strict=True)
    ]


def motion_bodies(
    motion: MotionCase,
    placed: Placed,
    colour: str,
    counts: Sequence[int],
    *,
    touching: Sequence[tuple[int, float, float]] = (),
) -> tuple[WebBody, ...]:
    """Return somebody who moves with the belts that are worn, in some frames.

    Parameters
    ----------
    placed
        The body in the frames.
    colour
        Colour family of the body.
    counts
        The spheres of each belt's cord.
    touching
        As of `body_view`.
    """
    body = body_view(placed, motion.person, colour, frames=slice(0, len(placed)), touching=touching)
    cords = (_cord(motion, placed, k, count) for k, count in enumerate(counts))
    return (body, *cords)


def cord_counts(motion: MotionCase, placed: Placed) -> tuple[int, ...]:
    """Return how many spheres show each belt as a cord, without gaps in any of the frames."""
    counts = []
    for belt in motion.belts:
        lines = [belt_line(belt, placed, pose) for pose in range(len(placed))]
        longest = max(float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) for line in lines)
        counts.append(max(2, int(np.ceil(1.5 * longest / _CORD))))
    return tuple(counts)


def _touching(motion: MotionFound) -> tuple[tuple[int, float, float], ...]:
    """The spheres that are deeper in something than is allowed, and from when to when [s]."""
    found = motion.episodes
    rows = np.flatnonzero((-found.distance > found.allowed) & (found.sphere >= 0))
    return tuple(
        (int(found.sphere[row]), float(found.enter[row]), float(found.leave[row])) for row in rows
    )


def _marks(motion: MotionFound) -> tuple[WebMark, ...]:
    """Where and while the deepest contacts last, with their depth beyond what is allowed."""
    deep = sorted(
        (meeting for meeting in motion.meetings if meeting.depth > meeting.allowed),
        key=lambda meeting: meeting.allowed - meeting.depth,
    )
    return tuple(
        WebMark(
            meeting.point,
            f"{1000 * (meeting.depth - meeting.allowed):.0f} mm",
            failing=True,
            span=(meeting.enter, meeting.leave),
        )
        for meeting in deep[:_MOST_MARKS]
    )


def _cord(study: MotionCase, placed: Placed, k: int, count: int) -> WebBody:
    """A belt as a cord of spheres along its middle line, evenly spaced in every frame."""
    belt = study.belts[k]
    lines = [belt_line(belt, placed, pose) for pose in range(len(placed))]
    centres = np.array([_evenly(line, count) for line in lines])
    return WebBody(
        plain(belt.name),
        _BELT_COLOUR,
        np.full(count, _CORD),
        centres,
        np.zeros(count, dtype=np.int64),
        ("belt",),
        ("",) * count,
    )


def _evenly(line: Floats, count: int) -> Floats:
    """(count, 3) [m] evenly spaced points along a line (M, 3)."""
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    at = np.linspace(0.0, way[-1], count)
    return np.column_stack([np.interp(at, way, column) for column in line.T])
