"""Ways of directions and angles from rest to rest."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats

__all__ = ["Path", "Ways", "smooth"]

_OPPOSITE = np.cos(np.radians(170.0))


def smooth(share: Floats) -> Floats:
    """Share of the way after a share of the time, from rest to rest with the least jerk (Flash &
    Hogan 1985); 0 before and 1 after."""
    u = np.clip(share, 0.0, 1.0)
    return np.asarray(u**3 * (10.0 - 15.0 * u + 6.0 * u**2))


class Path:
    """Numbers (k,) that move from rest to rest: where they are at any time."""

    def __init__(self, start: Floats) -> None:
        self._start = np.array(start, dtype=np.float64)
        self._moves: list[tuple[float, float, Floats, Floats]] = []

    @property
    def last(self) -> Floats:
        """Where they end up."""
        return self._moves[-1][3] if self._moves else self._start

    def move(self, begin: float, span: float, target: Floats) -> None:
        """Move to a target from `begin` [s] on for `span` [s], from wherever all moves so far have
        come to by then."""
        start = self.at(np.array([begin]))[0]
        self._moves.append((begin, span, start, np.array(target, dtype=np.float64)))

    def at(self, time: Floats) -> Floats:
        """(P, k) where they are at times (P,) [s]."""
        found = np.repeat(self._start[None], len(time), axis=0)
        latest = np.searchsorted([move[0] for move in self._moves], time) - 1
        for k in np.unique(latest[latest >= 0]).tolist():
            begin, span, start, target = self._moves[k]
            rows = latest == k
            found[rows] = self._between(start, target, smooth((time[rows] - begin) / span))
        return found

    def _between(self, start: Floats, target: Floats, share: Floats) -> Floats:
        return np.asarray(start + share[:, None] * (target - start))


class Ways(Path):
    """A direction that moves along great circles; a turn to the opposite one goes by the first of
    `by` (n, 3) that is far from both."""

    def __init__(self, start: Floats, by: Floats) -> None:
        super().__init__(start)
        self._by = by

    def _between(self, start: Floats, target: Floats, share: Floats) -> Floats:
        if start @ target < _OPPOSITE:
            middle = next(way for way in self._by if abs(way @ start) < 0.9)
            first = _arc(start, middle, 2.0 * share)
            second = _arc(middle, target, 2.0 * share - 1.0)
            return np.where(share[:, None] < 0.5, first, second)
        return _arc(start, target, share)


def _arc(start: Floats, target: Floats, share: Floats) -> Floats:
    """(P, 3) points on the shorter great circle between two unit vectors."""
    across = target - start * (start @ target)
    sine = float(np.linalg.norm(across))
    if sine < 1e-12:
        return np.repeat(target[None], len(share), axis=0)
    turn = np.arctan2(sine, float(start @ target)) * share[:, None]
    return np.asarray(np.cos(turn) * start + np.sin(turn) * across / sine)
