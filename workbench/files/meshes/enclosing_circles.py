"""Compute the minimum enclosing circles of many polygons at once.

Two or three points determine the smallest circle about a set of points. The method solves this as
an LP-type problem [1]_:

1. Start with the circle about two far points.
2. Add the farthest point outside to the determining points.
3. Find the smallest circle of these, at most four, by trying every pair and triple.
4. Repeat. The radius grows with each step, so the method ends at the exact circle.

All polygons step together, and those that are done drop out.

References
----------
.. [1] J. Matousek, M. Sharir, E. Welzl (1996), A subexponential bound for linear programming,
   Algorithmica 16, 498-516.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from workbench.files.meshes.planes import perpendicular
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["enclosing_circles"]

_TOLERANCE = 1e-12
"""Share of its radius by which a point may lie outside a circle."""
_MAX_STEPS = 200
_SUBSETS = [(i, j, j) for i, j in combinations(range(4), 2)] + list(combinations(range(4), 3))
"""Pairs, with the second one repeated, and triples of four points."""


def enclosing_circles(
    vertices: Floats, edges: Ints, start: Ints, normal: Floats
) -> tuple[Floats, Floats]:
    """Compute the smallest circles about planar polygons.

    Parameters
    ----------
    vertices
        (V, 3) [m].
    edges, start
        (E, 2) directed edges, and where (F + 1,) those of each polygon start.
    normal
        (F, 3) unit normals.

    Returns
    -------
    tuple[Floats, Floats]
        Centres (F, 3) [m] and radii (F,) [m]. A radius reaches the farthest corner in space, so
        nothing of the polygon is outside the sphere of the same centre and radius.
    """
    if not len(normal):
        return np.zeros((0, 3)), np.zeros(0)
    owner = np.repeat(np.arange(len(normal)), np.diff(start))
    points = vertices[edges[:, 0]]
    origin = points[start[:-1]]
    first = perpendicular(normal)
    second = np.cross(normal, first)
    local = points - origin[owner]
    flat = np.column_stack([np.einsum("nc,nc->n", local, axis[owner]) for axis in (first, second)])
    flat_centre = _circle_centres(_PointSets(flat, owner, start))
    centre: Floats = origin + flat_centre[:, :1] * first + flat_centre[:, 1:] * second
    distance = np.linalg.norm(points - centre[owner], axis=1)
    return centre, np.maximum.reduceat(distance, start[:-1])


@dataclass(frozen=True, eq=False)
class _PointSets:
    """F sets of points in a plane, one after the other."""

    points: Floats
    """(E, 2)."""
    owner: Ints
    """(E,) the set of each point."""
    start: Ints
    """(F + 1,) where each set starts."""

    def farthest(self, origin: Floats) -> Ints:
        """Return the index (F,) of the point of each set that is farthest from its origin (E, 2)."""
        squared = ((self.points - origin) ** 2).sum(axis=1)
        most = np.maximum.reduceat(squared, self.start[:-1])
        hit = np.flatnonzero(squared == np.repeat(most, np.diff(self.start)))
        return hit[np.searchsorted(hit, self.start[:-1])]

    def only(self, sets: Ints) -> tuple[_PointSets, Ints]:
        """Return some sets, with their own numbers as owners, and the indices of their points."""
        count = np.diff(self.start)[sets]
        begin = np.concatenate([[0], np.cumsum(count)])
        index = np.arange(begin[-1]) + np.repeat(self.start[sets] - begin[:-1], count)
        return _PointSets(self.points[index], np.repeat(sets, count), begin), index


def _circle_centres(sets: _PointSets) -> Floats:
    """Return the centre (F, 2) of the smallest circle about each set."""
    points = sets.points
    a = sets.farthest(points[sets.start[:-1]][sets.owner])
    b = sets.farthest(points[a][sets.owner])
    determining = np.column_stack([a, b, b, b])
    centre = (points[a] + points[b]) / 2
    radius = np.linalg.norm(points[a] - points[b], axis=1) / 2
    active = np.arange(len(radius))
    remaining = sets
    index = np.arange(len(points))
    for _ in range(_MAX_STEPS):
        far = remaining.farthest(centre[remaining.owner])
        distance = np.linalg.norm(remaining.points[far] - centre[active], axis=1)
        outside = distance > radius[active] * (1 + _TOLERANCE) + 1e-15
        active = active[outside]
        determining[active, 3] = index[far[outside]]
        determining[active, :3], centre[active], grown = _smallest_circle(
            points, determining[active]
        )
        stuck = grown <= radius[active] * (1 + 1e-15)  # by rounding
        radius[active] = np.maximum(grown, radius[active])
        active = active[~stuck]
        if not len(active):
            break
        remaining, index = sets.only(active)
    return centre


def _smallest_circle(points: Floats, indices: Ints) -> tuple[Ints, Floats, Floats]:
    """Find the smallest circle about each of N times four points.

    Parameters
    ----------
    points
        (E, 2).
    indices
        (N, 4) points.

    Returns
    -------
    tuple[Ints, Floats, Floats]
        The points (N, 3) that determine the circle, its centre (N, 2) and its radius (N,).
    """
    best = indices[:, :3].copy()
    best_centre = np.zeros((len(indices), 2))
    best_radius = np.full(len(indices), np.inf)
    corner = points[indices]
    for subset in _SUBSETS:
        chosen = corner[:, subset]
        is_pair = subset[1] == subset[2]
        centre = (chosen[:, 0] + chosen[:, 1]) / 2 if is_pair else _circumcentres(chosen)
        distance = np.linalg.norm(corner - centre[:, None], axis=2)
        radius = distance[:, subset].max(axis=1)
        holds_all = distance.max(axis=1) <= radius * (1 + _TOLERANCE)
        better: Bools = holds_all & (radius < best_radius)
        best_centre[better] = centre[better]
        best_radius[better] = radius[better]
        best[better] = indices[better][:, subset]
    return best, best_centre, best_radius


def _circumcentres(corner: Floats) -> Floats:
    """Return the centre (N, 2) of the circle through three points (N, 3, 2); NaN if they are
    collinear."""
    # With u, v the sides from the first corner: c = (|u|^2 v - |v|^2 u) turned by 90 degrees / 2 u x v
    u = corner[:, 1] - corner[:, 0]
    v = corner[:, 2] - corner[:, 0]
    twice = 2 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    twice = np.where(twice == 0, np.nan, twice)
    uu = (u**2).sum(axis=1)
    vv = (v**2).sum(axis=1)
    x = (v[:, 1] * uu - u[:, 1] * vv) / twice
    y = (u[:, 0] * vv - v[:, 0] * uu) / twice
    centre: Floats = corner[:, 0] + np.column_stack([x, y])
    return centre
