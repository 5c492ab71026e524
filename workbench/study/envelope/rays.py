"""Rays along which reach is found: a grid about one point, as Kennedy's device had it, and levels
about an upright axis.

Kennedy (1978, AMRL-TR-77-50) measured along rods 15 degrees apart that pointed at the seat
reference point, and measured the reach in level and upright sections.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import UsageError
from workbench.model.arrays import Floats, Ints

__all__ = ["Rays", "check_step", "level_rays", "point_rays", "ray_grid", "solid_angles"]


@dataclass(frozen=True, eq=False)
class Rays:
    """R rays: where they begin (R, 3) [m], unit directions (R, 3), whose they are (R,): a number of
    a body; beside (R, N): the rays next to each, -1 where there are fewer than N."""

    origin: Floats
    direction: Floats
    who: Ints
    beside: Ints

    def __len__(self) -> int:
        return len(self.who)

    def at(self, radius: Floats) -> Floats:
        """(R, 3) [m] the points at these radii (R,)."""
        points: Floats = self.origin + radius[:, None] * self.direction
        return points

    def rows(self, rows: Ints) -> Rays:
        """Some of the rays; those beside keep the numbers they had."""
        return Rays(self.origin[rows], self.direction[rows], self.who[rows], self.beside[rows])


def point_rays(origins: Floats, direction: Floats, triangles: Ints) -> Rays:
    """The rays (B D,) of B people about their origins (B, 3) [m] along the directions (D, 3) of a
    grid of triangles (T, 3), person by person."""
    people = len(origins)
    rays = len(direction)
    who = np.repeat(np.arange(people), rays)
    beside = np.tile(_beside(rays, triangles), (people, 1))
    beside = np.where(beside >= 0, beside + who[:, None] * rays, -1)
    return Rays(np.repeat(origins, rays, axis=0), np.tile(direction, (people, 1)), who, beside)


def _beside(rays: int, triangles: Ints) -> Ints:
    """(D, N) the rays that share an edge of a triangle with each, the first 8 of them, -1 where
    there are fewer."""
    pairs = np.unique(
        np.concatenate([triangles[:, list(pair)] for pair in ((0, 1), (1, 2), (2, 0))]), axis=0
    )
    beside = np.full((rays, 8), -1)
    count = np.zeros(rays, np.int64)
    for one, other in pairs:
        if count[one] < 8:
            beside[one, count[one]] = other
            count[one] += 1
    return beside


def level_rays(origin: Floats, heights: Floats, step: int) -> Rays:
    """Level rays every `step` degrees of azimuth about the upright axis through an origin (3,) [m],
    at each of the heights (H,) [m] above it, height by height."""
    azimuth = np.radians(np.arange(0, 360, step))
    direction = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(len(azimuth))], axis=1)
    start = origin + np.repeat(heights, len(azimuth))[:, None] * np.array([0.0, 0.0, 1.0])
    place = np.arange(len(heights) * len(azimuth)).reshape(len(heights), len(azimuth))
    down = np.full_like(place, -1)
    up = np.full_like(place, -1)
    down[1:] = place[:-1]
    up[:-1] = place[1:]
    beside = np.stack(
        [np.roll(place, 1, axis=1), np.roll(place, -1, axis=1), down, up], axis=-1
    ).reshape(-1, 4)
    return Rays(
        start, np.tile(direction, (len(heights), 1)), np.zeros(len(start), dtype=np.int64), beside
    )


def check_step(step: int) -> None:
    """UsageError for a step of a grid of rays [deg] that does not go into a right angle."""
    if step < 1 or 90 % step:
        steps = ", ".join(str(whole) for whole in range(1, 91) if 90 % whole == 0)
        raise UsageError(f"step: expected one of {steps} degrees, got {step}")


def ray_grid(step: int) -> tuple[Floats, Ints]:
    """Unit rays (D, 3) every `step` degrees of azimuth and elevation, level by level from below,
    then the lowest and the highest; and the triangles (T, 3) between them, counter-clockwise seen
    from outside."""
    azimuth = np.radians(np.arange(0, 360, step))
    levels = np.radians(np.arange(-90 + step, 90, step))
    a, e = (grid.ravel() for grid in np.meshgrid(azimuth, levels))
    direction = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=1)
    count = len(azimuth)
    rows = len(levels)
    here = np.arange(count)
    after = (here + 1) % count
    triangles = []
    for level in range(rows - 1):
        low = level * count
        high = (level + 1) * count
        triangles += [np.stack([low + here, low + after, high + after], axis=1)]
        triangles += [np.stack([low + here, high + after, high + here], axis=1)]
    bottom = np.full(count, rows * count)
    top = np.full(count, rows * count + 1)
    triangles += [np.stack([bottom, after, here], axis=1)]
    triangles += [np.stack([top, (rows - 1) * count + here, (rows - 1) * count + after], axis=1)]
    return np.concatenate([direction, [[0, 0, -1.0], [0, 0, 1.0]]]), np.concatenate(triangles)


def solid_angles(direction: Floats, step: float) -> Floats:
    """(D,) [sr] of the cells of a grid of rays, `step` [rad] wide about each; together 4 pi."""
    elevation = np.arcsin(np.clip(direction[:, 2], -1.0, 1.0))
    low = np.maximum(elevation - step / 2, -np.pi / 2)
    high = np.minimum(elevation + step / 2, np.pi / 2)
    width = np.where(np.abs(direction[:, 2]) > 1.0 - 1e-12, 2 * np.pi, step)
    cells: Floats = width * (np.sin(high) - np.sin(low))
    return cells
