"""Outlines: closed plane curves at stations along an axis, from which a part of a body is made."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats, read_only

__all__ = ["Outlines", "crossing"]


@dataclass(frozen=True, eq=False)
class Outlines:
    """K closed curves: curve k lies across the axis at station[k] [m] and runs through points[k]
    (n, 2) [m].

    axis: 0, 1, 2 for x, y, z; the two coordinates of a point are the next two axes in turn (axis z:
    x and y; axis x: y and z; axis y: z and x). Several curves may lie at one station: side by side,
    or one in another as its hole.
    """

    name: str
    axis: int
    station: Floats
    points: tuple[Floats, ...]

    def __post_init__(self) -> None:
        count = len(self.points)
        station = read_only(self.station, np.float64, (count,), f"{self.name}: station")
        loops = tuple(
            read_only(p, np.float64, (None, 2), f"{self.name}: points") for p in self.points
        )
        object.__setattr__(self, "station", station)
        object.__setattr__(self, "points", loops)
        if self.axis not in (0, 1, 2):
            raise InputError(f"{self.name}: the axis is 0, 1 or 2 (x, y, z), got {self.axis!r}")
        if len(np.unique(station)) < 2:
            raise InputError(f"{self.name}: outlines at two stations or more are needed")
        for k, loop in enumerate(loops):
            if len(loop) < 3 or not np.all(np.isfinite(loop)):
                raise InputError(
                    f"{self.name}: outline {k + 1}: three finite points or more are needed"
                )
            self._check_crossings(k)

    def _check_crossings(self, k: int) -> None:
        """Raise where an outline crosses itself, or one before it at the same station."""
        for j in range(k + 1):
            if self.station[j] != self.station[k]:
                continue
            if (found := crossing(self.points[j], self.points[k])) is not None:
                other = "itself" if j == k else f"outline {j + 1}"
                at = f"{self.station[k] * 1e3:g} mm"
                raise InputError(
                    f"{self.name}: outline {k + 1} at {at} crosses {other} near point {found[1] + 1}"
                )


def crossing(first: Floats, second: Floats) -> tuple[int, int] | None:
    """The first two sides, of each closed curve one, that cross; None where none do. The same curve
    twice: itself.

    Sides run from each point (n, 2) to the next, the last one back to the first.
    """
    a = first
    b = np.roll(first, -1, axis=0)
    c = second
    d = np.roll(second, -1, axis=0)
    one = _turn(a, b, c) * _turn(a, b, d) < 0
    two = (_turn(c, d, a) * _turn(c, d, b) < 0).T
    hits = np.argwhere(one & two)
    return (int(hits[0, 0]), int(hits[0, 1])) if len(hits) else None


def _turn(a: Floats, b: Floats, p: Floats) -> Floats:
    """(n, m) twice the area of the triangles of sides a-b (n, 2) and points p (m, 2)."""
    side = (b - a)[:, None]
    way = p[None] - a[:, None]
    return side[..., 0] * way[..., 1] - side[..., 1] * way[..., 0]
