"""Interpolate angles and directions from rest to rest."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats

__all__ = ["DirectionPath", "Path", "minimum_jerk"]

_OPPOSITE = np.cos(np.radians(170.0))
"""Cosine of the angle from which on two directions count as opposite."""
_NEARLY_PARALLEL = 0.9
"""Cosine of the angle to the start from which on a direction cannot be turned through."""


def minimum_jerk(share: Floats) -> Floats:
    """Compute the share of the way that a minimum-jerk movement has done.

    s(u) = 10 u^3 - 15 u^4 + 6 u^5 moves from rest to rest with the least integral of the squared
    jerk, as people move from point to point.

    Parameters
    ----------
    share
        (P,) shares u of the time; the way is 0 before 0 and 1 after 1.

    Returns
    -------
    Floats
        (P,) shares of the way.

    References
    ----------
    Flash, T. & Hogan, N. (1985), The coordination of arm movements: an experimentally confirmed
    mathematical model, Journal of Neuroscience 5, 1688-1703.
    """
    u = np.clip(share, 0.0, 1.0)
    return np.asarray(u**3 * (10.0 - 15.0 * u + 6.0 * u**2))


class Path:
    """Numbers (k,) that move from rest to rest, target after target.

    A movement begins where the one before has come to by then, even if that one is not at its end.
    """

    def __init__(self, start: Floats) -> None:
        self._start = np.array(start, dtype=np.float64)
        self._moves: list[tuple[float, float, Floats, Floats]] = []
        """Begin [s], span [s], start (k,) and target (k,) of each movement."""

    @property
    def last(self) -> Floats:
        """The last target (k,), or the start before any movement."""
        return self._moves[-1][3] if self._moves else self._start

    def move(self, begin: float, span: float, target: Floats) -> None:
        """Append a movement to a target (k,) that begins at `begin` [s] and takes `span` [s]."""
        start = self.at(np.array([begin]))[0]
        self._moves.append((begin, span, start, np.array(target, dtype=np.float64)))

    def at(self, time: Floats) -> Floats:
        """Return the values (P, k) at times (P,) [s]."""
        values = np.repeat(self._start[None], len(time), axis=0)
        latest = np.searchsorted([move[0] for move in self._moves], time) - 1
        for k in np.unique(latest[latest >= 0]).tolist():
            begin, span, start, target = self._moves[k]
            rows = latest == k
            share = minimum_jerk((time[rows] - begin) / span)
            values[rows] = self._interpolate(start, target, share)
        return values

    def _interpolate(self, start: Floats, target: Floats, share: Floats) -> Floats:
        """(P, k) values after shares (P,) of the way."""
        return np.asarray(start + share[:, None] * (target - start))


class DirectionPath(Path):
    """A unit vector (3,) that moves along great circles.

    A turn to the opposite direction has no unique great circle. It passes through the first of the
    directions `via` (n, 3) that is not nearly parallel to the start.
    """

    def __init__(self, start: Floats, via: Floats) -> None:
        super().__init__(start)
        self._via = via

    def _interpolate(self, start: Floats, target: Floats, share: Floats) -> Floats:
        if start @ target >= _OPPOSITE:
            return _great_circle(start, target, share)
        middle = next(way for way in self._via if abs(way @ start) < _NEARLY_PARALLEL)
        first = _great_circle(start, middle, 2.0 * share)
        second = _great_circle(middle, target, 2.0 * share - 1.0)
        return np.where(share[:, None] < 0.5, first, second)


def _great_circle(start: Floats, target: Floats, share: Floats) -> Floats:
    """(P, 3) points on the shorter great circle between two unit vectors (slerp)."""
    across = target - start * (start @ target)
    sine = float(np.linalg.norm(across))
    if sine < 1e-12:
        return np.repeat(target[None], len(share), axis=0)
    angle = np.arctan2(sine, float(start @ target)) * share[:, None]
    return np.asarray(np.cos(angle) * start + np.sin(angle) * across / sine)
