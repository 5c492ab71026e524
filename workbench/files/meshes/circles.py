"""Minimum enclosing circles of many polygons at once.

The smallest circle about a set of points is held by two or three of them. Starting from two far
points, the farthest point outside joins the holders and the smallest circle of those (at most four)
is found by trying every pair and triple; the radius grows with each step, so it ends at the exact
circle (an LP-type problem: Matousek, Sharir, Welzl, 1996). All polygons step together, and those
that are done drop out.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["enclosing_circles"]

_CLOSE = 1e-12
_STEPS = 200


def enclosing_circles(
    vertices: Floats, loops: tuple[Ints, Ints], normal: Floats
) -> tuple[Floats, Floats]:
    """Centres (F, 3) and radii (F,) [m] of the smallest circles about the polygons (edges (E, 2),
    start (F + 1,)).

    Centres lie at the mean height of the polygon's corners along `normal` (F, 3); a radius reaches
    the farthest corner in space, so that nothing of the polygon is outside the sphere of the same
    centre and radius.
    """
    edges, start = loops
    polygons = len(normal)
    if not polygons:
        return np.zeros((0, 3)), np.zeros(0)
    owner = np.repeat(np.arange(polygons), np.diff(start))
    points = vertices[edges[:, 0]]
    origin = points[start[:-1]]
    first, second = _axes(normal)
    local = points - origin[owner]
    flat = np.column_stack([np.einsum("nc,nc->n", local, axis[owner]) for axis in (first, second)])
    centre2 = _circles(flat, owner, start)
    centre: Floats = origin + centre2[:, :1] * first + centre2[:, 1:] * second
    reach = np.linalg.norm(points - centre[owner], axis=1)
    return centre, np.maximum.reduceat(reach, start[:-1])


def _axes(normal: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors (F, 3) that span the plane across each normal."""
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin(axis=1)])
    first /= np.linalg.norm(first, axis=1)[:, None]
    return first, np.cross(normal, first)


def _circles(points: Floats, owner: Ints, start: Ints) -> Floats:
    """(F, 2) centres; points (E, 2) stand polygon by polygon."""
    polygons = len(start) - 1
    a = _farthest(points, points[start[:-1]][owner], start)
    b = _farthest(points, points[a][owner], start)
    holders = np.column_stack([a, b, b, b])
    centre = (points[a] + points[b]) / 2
    radius = np.linalg.norm(points[a] - points[b], axis=1) / 2
    active = np.arange(polygons)
    points_of = points
    owner_of = owner
    start_of = start
    index = np.arange(len(points))
    for _ in range(_STEPS):
        far = _farthest(points_of, centre[owner_of], start_of)
        outside = (
            np.linalg.norm(points_of[far] - centre[active], axis=1)
            > radius[active] * (1 + _CLOSE) + 1e-15
        )
        if not outside.any():
            break
        holders[active[outside], 3] = index[far[outside]]
        active = active[outside]
        held, centre[active], grown = _smallest(points, holders[active])
        holders[active, :3] = held
        stuck = grown <= radius[active] * (1 + 1e-15)
        radius[active] = np.maximum(grown, radius[active])
        active = active[~stuck]
        if not len(active):
            break
        points_of, owner_of, start_of, index = _narrow(points, start, active)
    return centre


def _narrow(points: Floats, start: Ints, active: Ints) -> tuple[Floats, Ints, Ints, Ints]:
    """The points of the active polygons only: their places, owners, starts, and their indices in
    `points`."""
    count = np.diff(start)[active]
    begin = np.concatenate([[0], np.cumsum(count)])
    index = np.arange(begin[-1]) + np.repeat(start[active] - begin[:-1], count)
    return points[index], np.repeat(active, count), begin, index


def _farthest(points: Floats, origin: Floats, start: Ints) -> Ints:
    """(F,) index of the point farthest from its origin (E, 2), in each run of points."""
    away = ((points - origin) ** 2).sum(axis=1)
    most = np.maximum.reduceat(away, start[:-1])
    hit = np.flatnonzero(away == np.repeat(most, np.diff(start)))
    which = np.searchsorted(hit, start[:-1])
    return hit[which]


def _smallest(points: Floats, holders: Ints) -> tuple[Ints, Floats, Floats]:
    """Of four points (n, 4) each: which three hold the smallest circle, its centre (n, 2) and
    radius (n,)."""
    best_centre = np.zeros((len(holders), 2))
    best_radius = np.full(len(holders), np.inf)
    best = holders[:, :3].copy()
    corner = points[holders]
    for chosen in [(i, j, j) for i, j in combinations(range(4), 2)] + list(
        combinations(range(4), 3)
    ):
        pick = corner[:, chosen]
        centre = (pick[:, 0] + pick[:, 1]) / 2 if chosen[1] == chosen[2] else _circumcentres(pick)
        away = np.linalg.norm(corner - centre[:, None], axis=2)
        radius = away[:, chosen].max(axis=1)
        better: Bools = (away.max(axis=1) <= radius * (1 + _CLOSE)) & (radius < best_radius)
        best_centre[better] = centre[better]
        best_radius[better] = radius[better]
        best[better] = holders[better][:, chosen]
    return best, best_centre, best_radius


def _circumcentres(corner: Floats) -> Floats:
    """(n, 2) centres of the circles through three points (n, 3, 2); NaN where they stand in one
    line."""
    u = corner[:, 1] - corner[:, 0]
    v = corner[:, 2] - corner[:, 0]
    twice = 2 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    uu = (u**2).sum(axis=1)
    vv = (v**2).sum(axis=1)
    twice = np.where(twice == 0, np.nan, twice)
    x = (v[:, 1] * uu - u[:, 1] * vv) / twice
    y = (u[:, 0] * vv - v[:, 0] * uu) / twice
    centre: Floats = corner[:, 0] + np.column_stack([x, y])
    return centre
