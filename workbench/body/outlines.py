"""Compute a closed surface through outlines.

1. The field of a slice is the distance to its curves, negative inside.
2. Between slices, each point of the plane follows a monotone cubic through its distances [1]_, so
   that nothing overshoots. The first and last slice close the part flat.
3. The surface is where the field is zero, see `level_surface`.

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

from workbench.body.surface import Surface, sealed
from workbench.errors import InputError
from workbench.geometry.polygon import inside_loops
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.outlines import Outlines

__all__ = ["level_surface", "outline_surface"]

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
    return np.maximum(field, beyond[:, None, None])


def _slice_field(points: Floats, curves: list[Floats]) -> Floats:
    """Return the signed distance (n,) [m] of points (n, 2) to closed curves (K, 2).

    It is negative inside an odd number of them.
    """
    square = np.full(len(points), np.inf)
    for curve in curves:
        for a, b in zip(curve, np.roll(curve, -1, axis=0), strict=True):
            square = np.minimum(square, _segment_distance_squared(points, a, b))
    return np.where(inside_loops(points, curves), -1.0, 1.0) * np.sqrt(square)


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
    return np.einsum("nc,nc->n", gap, gap)


# Compute the surface where a field on a grid is zero, by marching tetrahedra [1]_.
#
# Each cube is cut into six tetrahedra about one diagonal, alike in every cube, so that neighbours
# fit. The surface is closed where the field is positive all around.
#
# The level set of manifold3d calls a Python function for every point. On a field of 262,144 points it
# takes 6.6 s, against 0.34 s here, and its vertices are as near to the true surface.
#
# References
# ----------
# .. [1] A. Doi, A. Koide (1991), An efficient method of triangulating equi-valued surfaces by using
#    tetrahedral cells, IEICE Transactions E74(1), 214-224.

# from corner 0 to corner 7 of a cube by way of two others; corner number = 4 x + 2 y + z
_TETRAHEDRA = np.array(
    [[0, 4, 6, 7], [0, 6, 2, 7], [0, 2, 3, 7], [0, 3, 1, 7], [0, 1, 5, 7], [0, 5, 4, 7]]
)
_MIN_SHARE = 0.02
"""Share of an edge that a crossing keeps from its ends, so that no triangle vanishes."""


def level_surface(field: Floats, origin: Floats, pitch: Floats) -> tuple[Floats, Ints]:
    """Compute the surface where a field is zero, by marching tetrahedra.

    Parameters
    ----------
    field
        (X, Y, Z) values on a grid, negative inside. They must be positive on its outer faces.
    origin, pitch
        (3,) position of the first point, and spacing [m].

    Returns
    -------
    tuple[Floats, Ints]
        Vertices (V, 3) [m] and outward faces (T, 3).
    """
    flat = field.ravel()
    corner = _crossed_tetrahedra(field)
    inside = flat[corner] < 0
    triangles = np.concatenate([_cut(corner, inside, n) for n in (1, 2, 3)])
    # each edge of the grid that is crossed holds one vertex
    ends = np.sort(triangles, axis=2).reshape(-1, 2)
    edge, face = np.unique(ends[:, 0] * flat.size + ends[:, 1], return_inverse=True)
    ends = np.stack([edge // flat.size, edge % flat.size], axis=1)
    position = origin + pitch * np.stack(np.unravel_index(ends, field.shape), axis=-1)
    vertices, inner = _crossings(position, flat[ends])
    return vertices, _outward(vertices, face.reshape(-1, 3), inner)


def _crossings(position: Floats, value: Floats) -> tuple[Floats, Floats]:
    """Return where (V, 3) edges are zero, linearly between their ends, and their ends inside.

    position (V, 2, 3) and value (V, 2): of both ends.
    """
    share = np.clip(value[:, 0] / (value[:, 0] - value[:, 1]), _MIN_SHARE, 1 - _MIN_SHARE)
    zero = position[:, 0] + share[:, None] * (position[:, 1] - position[:, 0])
    inner = np.where((value[:, 0] < 0)[:, None], position[:, 0], position[:, 1])
    return zero, inner


def _crossed_tetrahedra(field: Floats) -> Ints:
    """Return the corners (n, 4), flat indices, of all tetrahedra of cubes that the surface crosses."""
    shape = np.array(field.shape)
    stride = np.array([shape[1] * shape[2], shape[2], 1])
    # flat index of the first corner of each cube, and from there to its eight corners
    axes = np.meshgrid(*[np.arange(n - 1) for n in shape], indexing="ij")
    cube = np.stack(axes, axis=-1).reshape(-1, 3) @ stride
    corner = np.array([[c >> 2, (c >> 1) & 1, c & 1] for c in range(8)]) @ stride
    flat = field.ravel()
    count = sum((flat[cube + step] < 0).astype(np.int8) for step in corner)
    crossed = cube[(count > 0) & (count < 8)]
    return (crossed[:, None] + corner)[:, _TETRAHEDRA].reshape(-1, 4)


def _cut(corner: Ints, inside: Bools, count: int) -> Ints:
    """Return the edges (n, 3, 2) on which the corners of each triangle lie.

    Of the tetrahedra `corner` (m, 4) those with `count` corners inside are cut: into a triangle, or
    into two for two corners.
    """
    chosen = inside.sum(axis=1) == count
    order = np.argsort(~inside[chosen], axis=1, kind="stable")
    a, b, c, d = np.take_along_axis(corner[chosen], order, axis=1).T
    if count == 1:
        rings = [((a, b), (a, c), (a, d))]
    elif count == 3:
        rings = [((a, d), (b, d), (c, d))]
    else:
        rings = [((a, c), (a, d), (b, d)), ((a, c), (b, d), (b, c))]
    return np.concatenate(
        [np.stack([np.stack(edge, axis=1) for edge in ring], axis=1) for ring in rings]
    )


def _outward(vertices: Floats, faces: Ints, inner: Floats) -> Ints:
    """Return faces turned so that their normals point away from the grid points inside.

    inner: (V, 3) the end inside of the edge that holds each vertex.
    """
    corner = vertices[faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    away = (corner - inner[faces]).sum(axis=1)
    return np.where((np.einsum("tc,tc->t", normal, away) < 0)[:, None], faces[:, ::-1], faces)
