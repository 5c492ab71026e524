"""Segment a motion into strokes: movements from rest to rest."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from workbench.model.arrays import Floats

__all__ = ["Stroke", "strokes"]

_REST_SHARE = 0.002
"""Share of the greatest speed up to which something rests."""
_REST_SPEED = 1e-3
"""Speed up to which something rests in any case, in units of the path per second."""
_DIP_SHARE = 0.1
"""A speed below this share of the peaks before and after it separates two strokes."""
_TENTH = 0.246636
"""Share u of its time after which a minimum-jerk movement has done a tenth of its way, the root of
10 u^3 - 15 u^4 + 6 u^5 = 0.1."""


class Stroke(NamedTuple):
    """A movement from rest to rest."""

    begin: float
    """Time [s] at which it begins; it may lie between frames."""
    end: float
    """Time [s] at which it ends."""
    first: int
    """Frame at rest before it."""
    last: int
    """Frame at rest after it."""


def strokes(path: Floats, time: Floats, *, least: float) -> list[Stroke]:
    """Find the strokes of a path.

    A stroke lies between rests or dips of the speed. Its beginning and end are those of the
    minimum-jerk movement that does a tenth and nine tenths of the way at the same times. They never
    lie outside the rests.

    Parameters
    ----------
    path
        (P, k) positions, in any unit.
    time
        (P,) times [s], increasing.
    least
        Least distance between the ends of a stroke, in the unit of the path.

    Returns
    -------
    list of Stroke
        In the order of time.
    """
    if len(path) < 2:
        return []
    length = np.linalg.norm(np.diff(path, axis=0), axis=1)
    speed = length / np.diff(time)
    travelled = np.concatenate([[0.0], np.cumsum(length)])
    found = []
    for first, last in _moving_intervals(speed):
        cuts = [first, *(first + k for k in _dips(speed[first:last])), last]
        for a, b in pairwise(cuts):
            if np.linalg.norm(path[b] - path[a]) >= least:
                begin, end = _minimum_jerk_ends(travelled[a : b + 1], time[a : b + 1])
                found.append(Stroke(begin, end, a, b))
    return found


def _moving_intervals(speed: Floats) -> list[tuple[int, int]]:
    """First and last frames of the intervals without rest; speed (P - 1,) is that after a frame."""
    moving = speed > max(_REST_SHARE * float(speed.max()), _REST_SPEED)
    change = np.diff(np.concatenate([[False], moving, [False]]).astype(np.int64))
    edges = np.flatnonzero(change).tolist()
    return list(zip(edges[0::2], edges[1::2], strict=True))


def _dips(speed: Floats) -> list[int]:
    """The steps at which a speed (n,) dips below a tenth of the peaks before and after."""
    dips = []
    peak = 0.0
    low = np.inf
    low_step = 0
    for step, value in enumerate(speed.tolist()):
        if value < low:
            low = value
            low_step = step
        if low < _DIP_SHARE * peak and value > low / _DIP_SHARE and value > _DIP_SHARE * peak:
            dips.append(low_step)
            peak = value
            low = np.inf
        elif value > peak:
            peak = value
            low = np.inf
    return dips


def _minimum_jerk_ends(travelled: Floats, time: Floats) -> tuple[float, float]:
    """Beginning and end [s] of the minimum-jerk movement with the same tenth and nine tenths.

    travelled (n,) is the length of the path up to each of the times (n,) [s]. With tenths at t1 and
    t9 the movement takes (t9 - t1) / (1 - 2 u), u being the share of time of the first tenth.
    """
    share = (travelled - travelled[0]) / (travelled[-1] - travelled[0])
    early = float(np.interp(0.1, share, time))
    late = float(np.interp(0.9, share, time))
    lead = _TENTH * (late - early) / (1.0 - 2.0 * _TENTH)
    return max(early - lead, float(time[0])), min(late + lead, float(time[-1]))
