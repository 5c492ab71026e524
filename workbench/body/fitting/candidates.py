"""Candidate spheres: large ones inside the surface, each with its exact clearance, so that
protrusion is bounded.

A sphere of radius r = d(c) + outward, d(c) the exact distance of its centre to the surface, never
leaves the surface by more than `outward`: by construction, not by measurement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.body.fitting.regions import Regions
from workbench.body.fitting.sampling import Samples
from workbench.body.surface import Surface
from workbench.errors import UsageError
from workbench.geometry.nearest import morton_order, shrink_balls
from workbench.model.arrays import Bools, Floats, Ints

__all__ = [
    "LONGEST",
    "SHORTEST",
    "Candidates",
    "Limits",
    "bounded_radius",
    "inner_balls",
    "joined_candidates",
]


_RETREATS = 8


SHORTEST = 1e-5
LONGEST = 10.0
"""Radii and tolerances [m] that may be asked for."""


@dataclass(frozen=True)
class Limits:
    """What a sphere may be [m]: radius least to greatest, out of the surface by outward; inward:
    what may stay bare."""

    least: float
    greatest: float
    outward: float
    inward: float

    @classmethod
    def checked(
        cls, *, least_radius: float, greatest_radius: float, outward: float, inward: float
    ) -> Limits:
        """The limits as somebody gives them [m]; UsageError for lengths beyond SHORTEST to LONGEST,
        and for a least radius that is greater than the greatest."""
        given = {
            "least_radius": least_radius,
            "greatest_radius": greatest_radius,
            "outward": outward,
            "inward": inward,
        }
        for name, value in given.items():
            if not SHORTEST <= value <= LONGEST:
                raise UsageError(
                    f"{name}: expected a length of {SHORTEST:g} to {LONGEST:g} m, got {value:g}"
                )
        if least_radius > greatest_radius:
            raise UsageError(
                f"least_radius ({least_radius:g} m) is greater than greatest_radius ({greatest_radius:g} m)"
            )
        return cls(least_radius, greatest_radius, outward, inward)

    def scaled(self, factor: float) -> Limits:
        """The same with both tolerances times `factor`."""
        return Limits(self.least, self.greatest, self.outward * factor, self.inward * factor)


@dataclass(frozen=True, eq=False)
class Candidates:
    """Centres (m, 3), their depth (m,) [m] under the surface, and the bits (m,) of the segments
    they belong to."""

    centre: Floats
    depth: Floats
    bits: Ints

    def __len__(self) -> int:
        return len(self.depth)

    def at(self, index: Ints | Bools) -> Candidates:
        """Some of them."""
        return Candidates(self.centre[index], self.depth[index], self.bits[index])


def bounded_radius(depth: Floats, limits: Limits) -> Floats:
    """Radii (m,) that use the outward tolerance up; 0 where the least radius would protrude more
    than that."""
    radius = np.minimum(depth + limits.outward, limits.greatest)
    return np.where(radius >= limits.least, radius, 0.0)


def inner_balls(
    surface: Surface,
    samples: Samples,
    limits: Limits,
    *,
    slack: Floats,
    bits: Ints,
    regions: Regions,
) -> Candidates:
    """A candidate under each sample (n): shrunk from the greatest radius until the surface is at
    most `slack` (n,) [m] deep in it.

    bits (n,): the segment each is for. Its centre lies no deeper than about the bones of that
    segment, and not far inside another's part: a sphere that did would leave its place when the
    joint turns.
    """
    order = morton_order(samples.point)
    point = samples.point[order]
    normal = samples.normal[order]
    bits = bits[order]
    slack = slack[order]
    centre = np.empty((len(order), 3))
    start = np.full(len(order), max(limits.greatest - limits.outward, limits.least))
    start = np.minimum(start, np.maximum(regions.reach(point, bits), limits.least))
    shrink_balls(point, normal, start, slack, surface.solid, centre)
    for _ in range(_RETREATS):
        away = regions.foreign(centre, bits)
        if not away.any():
            break
        centre[away] = point[away] + 0.7 * (centre[away] - point[away])
    return Candidates(centre, -surface.distance(centre), bits)


def joined_candidates(parts: list[Candidates]) -> Candidates:
    """All of several lists, one after the other."""
    return Candidates(
        np.concatenate([p.centre for p in parts]),
        np.concatenate([p.depth for p in parts]),
        np.concatenate([p.bits for p in parts]),
    )
