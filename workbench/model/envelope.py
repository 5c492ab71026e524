"""Envelope: how far a limb reaches about a point, direction by direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints, frozen

__all__ = ["Envelope"]


@dataclass(frozen=True, eq=False, repr=False)
class Envelope:
    """The reach of one limb of one person about an origin (3,) [m], the seat reference point.

    direction (D, 3): unit rays, a grid of azimuth and elevation with the two poles last; outer, inner (D,) [m]: the
    farthest and the nearest reached point along each ray (where none is, the point that comes nearest: both the same);
    any_reached (D,): whether there is one. step: the grid's angle [rad]. vertices (2 D, 3) [m] and triangles (T, 3):
    outer and inner boundary as one closed surface; volume [m3]. lost [m3]: the part of it that obstacles take,
    blocked (D,): the share of each ray between its ends that is lost; zero where obstacles are not heeded.
    """

    person: str
    limb: str
    zone: int
    origin: Floats
    step: float
    direction: Floats
    outer: Floats
    inner: Floats
    any_reached: Bools
    triangles: Ints
    volume: float
    obstacles: bool
    lost: float
    blocked: Floats

    def __repr__(self) -> str:
        return f"Envelope({self.person}, {self.limb}, zone {self.zone}: {1000 * self.volume:.0f} litres)"

    def __post_init__(self) -> None:
        rays = len(self.direction)
        object.__setattr__(self, "origin", frozen(self.origin, np.float64, (3,), "envelope.origin"))
        object.__setattr__(self, "direction", frozen(self.direction, np.float64, (rays, 3), "envelope.direction"))
        for name in ("outer", "inner", "blocked"):
            object.__setattr__(self, name, frozen(getattr(self, name), np.float64, (rays,), f"envelope.{name}"))
        object.__setattr__(self, "any_reached", frozen(self.any_reached, np.bool_, (rays,), "envelope.any_reached"))
        object.__setattr__(self, "triangles", frozen(self.triangles, np.int64, (None, 3), "envelope.triangles"))

    @property
    def vertices(self) -> Floats:
        """(2 D, 3) [m] the outer points, then the inner points."""
        ends = np.concatenate([self.outer, self.inner])[:, None]
        points: Floats = self.origin + np.concatenate([self.direction, self.direction]) * ends
        return points
