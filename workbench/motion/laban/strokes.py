"""Strokes of a motion: the spells in which something moves from rest to rest."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from workbench.model.arrays import Floats

__all__ = ["Stroke", "strokes"]

_STILL_SHARE = 0.002
_STILL = 1e-3
_DIP = 0.1
"""A speed below this share of the peaks on both sides parts two strokes."""
_TENTH = 0.246636
"""Share of its time after which a movement of least jerk has done a tenth of its way."""


class Stroke(NamedTuple):
    """A movement from `begin` to `end` [s], between the frames `first` and `last`."""

    begin: float
    end: float
    first: int
    last: int


def strokes(path: Floats, time: Floats, *, least: float) -> list[Stroke]:
    """The strokes of a path (P, k) at times (P,) [s] whose ends are at least so far apart, in units
    of the path.

    A stroke lies between rests or dips of the speed. Its beginning and end are those of the
    movement of least jerk that does the tenth and the nine tenths of the way when it does, or the
    rests where they lie nearer together.
    """
    if len(path) < 2:
        return []
    way = np.linalg.norm(np.diff(path, axis=0), axis=1)
    speed = way / np.diff(time)
    done = np.concatenate([[0.0], np.cumsum(way)])
    moving = speed > max(_STILL_SHARE * float(speed.max()), _STILL)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], moving, [False]]).astype(np.int64)))
    found = []
    for first, last in zip(edges[0::2].tolist(), edges[1::2].tolist(), strict=True):
        cuts = [first, *(first + k for k in _dips(speed[first:last])), last]
        for a, b in pairwise(cuts):
            if np.linalg.norm(path[b] - path[a]) >= least:
                found.append(Stroke(*_ends(done[a : b + 1], time[a : b + 1]), a, b))
    return found


def _dips(speed: Floats) -> list[int]:
    """Where a speed dips below a tenth of the peaks before and after."""
    cuts = []
    peak = 0.0
    low = np.inf
    at = 0
    for k, value in enumerate(speed.tolist()):
        if value < low:
            low = value
            at = k
        if low < _DIP * peak and value > low / _DIP and value > _DIP * peak:
            cuts.append(at)
            peak = value
            low = np.inf
        elif value > peak:
            peak = value
            low = np.inf
    return cuts


def _ends(done: Floats, time: Floats) -> tuple[float, float]:
    share = (done - done[0]) / (done[-1] - done[0])
    early, late = (float(np.interp(s, share, time)) for s in (0.1, 0.9))
    lead = _TENTH * (late - early) / (1.0 - 2.0 * _TENTH)
    return max(early - lead, float(time[0])), min(late + lead, float(time[-1]))
