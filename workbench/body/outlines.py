"""Compute a closed surface through outlines.

1. The field of a slice is the distance to its curves, negative inside.
2. Between slices, each point of the plane follows a monotone cubic through its distances [1]_, so
   that nothing overshoots. The first and last slice close the part flat.
3. The surface is where the field is zero, see `marching`.

Measured on a body: slices every 20 mm give back the surface to 0.8 mm in the mean. Toes, chin and
fingers need closer ones.

References
----------
.. [1] F. N. Fritsch, J. Butland (1984), A method for constructing local monotone piecewise cubic
   interpolants, SIAM Journal on Scientific and Statistical Computing 5, 300-304.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

from workbench.body.marching import level_surface
from workbench.body.surface import Surface, sealed
from workbench.errors import InputError
from workbench.geometry.polygon import inside_loops
from workbench.model.arrays import Floats
from workbench.model.outlines import Outlines

__all__ = ["outline_surface"]

_MAX_POINTS = 20_000_000
"""Points of the grid at most."""
_DEFAULT_POINTS = 200_000
"""Points of the grid, about, where no pitch is given."""
_DEFAULT_CELLS = 64
"""Cells across the part at most, where no pitch is given."""
_MARGIN = 2.37
"""Cells of the grid before the part. It is no whole number, so that flat ends do not fall on
points."""


class _Grid(NamedTuple):
    """A grid of points over the planes (u, v) of outlines and along their axis (s), in metres."""

    u: Floats
    v: Floats
    s: Floats
    step: float

    @property
    def size(self) -> int:
        """Number of points."""
        return len(self.u) * len(self.v) * len(self.s)


def outline_surface(outlines: Outlines, *, pitch: float | None = None) -> Surface:
    """Compute the closed surface through outlines.

    Parameters
    ----------
    outlines
        Closed curves in parallel planes.
    pitch
        Spacing of the grid [m]. If None, 1/64 of the size across, or what makes a grid of some
        200,000 points.

    Raises
    ------
    InputError
        If the outlines enclose nothing or the grid would be too large.
    """
    grid = _grid(outlines, pitch)
    field = _distance_field(outlines, grid)
    if not (field < 0).any():
        raise InputError(
            f"{outlines.name}: the outlines enclose nothing at a pitch of {grid.step * 1e3:.3g} mm"
        )
    origin = np.array([grid.s[0], grid.u[0], grid.v[0]])
    vertices, faces = level_surface(field, origin, np.full(3, grid.step))
    return sealed(np.roll(vertices, outlines.axis, axis=1), faces, what=outlines.name)


def _grid(outlines: Outlines, pitch: float | None) -> _Grid:
    """Lay a grid around outlines; refuse one that is too large."""
    points = np.concatenate(outlines.points)
    low = np.append(points.min(axis=0), outlines.station.min())
    high = np.append(points.max(axis=0), outlines.station.max())
    step = _default_pitch(high - low) if pitch is None else float(pitch)
    if not (np.isfinite(step) and step > 0):
        raise InputError(f"{outlines.name}: the outlines have no extent")
    u, v, s = (
        np.arange(a - _MARGIN * step, b + 3 * step, step) for a, b in zip(low, high, strict=True)
    )
    grid = _Grid(u, v, s, step)
    if grid.size > _MAX_POINTS:
        possible = step * (grid.size / _MAX_POINTS) ** (1 / 3)
        raise InputError(
            f"{outlines.name}: a grid of {len(u)} x {len(v)} x {len(s)} points is too large; "
            f"a pitch of {possible * 1e3:.3g} mm or more is possible"
        )
    return grid


def _default_pitch(extent: Floats) -> float:
    """Return the spacing [m] of a grid over extents (3,) [m]: across, across, and along the axis."""
    volume = float(np.prod(extent[:2])) * float(extent[2])
    coarsest = float(extent[:2].max()) / _DEFAULT_CELLS
    return max(coarsest, float(np.cbrt(volume / _DEFAULT_POINTS)))


def _distance_field(outlines: Outlines, grid: _Grid) -> Floats:
    """Return the field (s, u, v) [m] of outlines on a grid, negative inside."""
    plane = np.stack(np.meshgrid(grid.u, grid.v, indexing="ij"), axis=-1).reshape(-1, 2)
    stations = np.unique(outlines.station)
    slices = []
    for station in stations:
        curves = [
            curve
            for curve, at in zip(outlines.points, outlines.station, strict=True)
            if at == station
        ]
        slices.append(_slice_field(plane, curves).reshape(len(grid.u), len(grid.v)))
    within = np.clip(grid.s, stations[0], stations[-1])
    field = PchipInterpolator(stations, np.stack(slices), axis=0)(within)
    # beyond the first and the last slice the distance to their planes closes the part flat
    beyond = np.maximum(stations[0] - grid.s, grid.s - stations[-1])
    closed: Floats = np.maximum(field, beyond[:, None, None])
    return closed


def _slice_field(points: Floats, curves: list[Floats]) -> Floats:
    """Return the signed distance (n,) [m] of points (n, 2) to closed curves (K, 2).

    It is negative inside an odd number of them.
    """
    square = np.full(len(points), np.inf)
    for curve in curves:
        for a, b in zip(curve, np.roll(curve, -1, axis=0), strict=True):
            square = np.minimum(square, _segment_distance_squared(points, a, b))
    field: Floats = np.where(inside_loops(points, curves), -1.0, 1.0) * np.sqrt(square)
    return field


def _segment_distance_squared(points: Floats, a: Floats, b: Floats) -> Floats:
    """Return the squared distance (n,) of points (n, 2) to the segment from a to b."""
    side = b - a
    offset = points - a
    length_squared = float(side @ side)
    if length_squared > 0:
        share = np.clip(offset @ side / length_squared, 0.0, 1.0)
    else:
        share = np.zeros(len(points))
    gap = offset - share[:, None] * side
    square: Floats = np.einsum("nc,nc->n", gap, gap)
    return square
