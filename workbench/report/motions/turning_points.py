"""Turning points of tracks that are seen a piece at a time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from workbench.model.arrays import Floats

__all__ = ["Turning"]

Point = tuple[int, float]
"""Where on a track, and its value there."""


class Turning:
    """The turning points of a track, where it turns back by `least` or more."""

    def __init__(self, least: float) -> None:
        self._least = least
        self._points: list[Point] = []
        self._high: Point = (0, -np.inf)
        self._low: Point = (0, np.inf)
        self._rising: bool | None = None
        self._seen = 0

    def take(self, track: Floats) -> None:
        """Take up the next values (P,)."""
        if not len(track):
            return
        if not self._points:
            start = (0, float(track[0]))
            self._points = [start]
            self._high = start
            self._low = start
        if not self._turns(track):
            self._widen(track)
        else:
            for k, value in enumerate(track.tolist(), start=self._seen):
                self._step(k, value)
        self._seen += len(track)

    def spells(self) -> list[tuple[Point, Point]]:
        """The stretches between turning points in which it rose or fell by `least` or more."""
        if not self._points:
            return []
        ends = {True: self._high, False: self._low, None: self._points[-1]}
        last = ends[self._rising]
        points = self._points + ([last] if last[0] != self._points[-1][0] else [])
        return [(a, b) for a, b in pairwise(points) if abs(b[1] - a[1]) >= self._least]

    def _turns(self, track: Floats) -> bool:
        """True where the track may turn in this piece: most pieces of most joints do not."""
        above = np.maximum(np.maximum.accumulate(track), self._high[1]) - track
        below = track - np.minimum(np.minimum.accumulate(track), self._low[1])
        return bool(
            (self._rising is not False and above.max() >= self._least)
            or (self._rising is not True and below.max() >= self._least)
        )

    def _widen(self, track: Floats) -> None:
        top = int(np.argmax(track))
        bottom = int(np.argmin(track))
        if track[top] > self._high[1]:
            self._high = self._seen + top, float(track[top])
        if track[bottom] < self._low[1]:
            self._low = self._seen + bottom, float(track[bottom])

    def _step(self, k: int, value: float) -> None:
        here = k, value
        self._high = here if value > self._high[1] else self._high
        self._low = here if value < self._low[1] else self._low
        if self._rising is not False and self._high[1] - value >= self._least:
            self._turn(self._high, here, rising=False)
        elif self._rising is not True and value - self._low[1] >= self._least:
            self._turn(self._low, here, rising=True)

    def _turn(self, at: Point, here: Point, *, rising: bool) -> None:
        if at[0] != self._points[-1][0]:
            self._points.append(at)
        self._rising = rising
        self._high = here
        self._low = here
