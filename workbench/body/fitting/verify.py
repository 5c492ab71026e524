"""Prove that a union of spheres keeps its tolerances everywhere, and find where it does not.

The surface is proved triangle by triangle: the field of one sphere is convex, so its greatest value
on a triangle is at a corner. The exposed surface of the spheres is proved patch by patch: the depth
under the surface changes by no more than the distance moved. What is not proved is cut into
quarters, down to 2 % of the tolerance.
"""

from __future__ import annotations

import numpy as np

from workbench.body.fitting.polish import union_field
from workbench.body.kernels.balls import widest_gap
from workbench.body.kernels.hollows import deep_patches
from workbench.body.kernels.spacing import thin_points
from workbench.body.surface import Surface
from workbench.geometry.nearest import morton_order
from workbench.model.arrays import Floats

__all__ = ["bare_places", "deepest_hollow", "gap_bound", "hollow_places", "split_triangles"]

_RESERVE = 0.02
"""Share of the tolerance in reserve: what is proved to within this share holds in full."""
_GOLDEN = 0.5 * (1 + np.sqrt(5))


def bare_places(corners: Floats, centre: Floats, radius: Floats, inward: float) -> Floats:
    """Return points (k, 3) of triangles (T, 3, 3) that are not proved to lie within `inward` [m] of the
    union of spheres (m, 3), (m,) [m].
    """
    points = np.empty((len(corners), 3))
    gaps = np.empty((len(corners), 2))
    widest_gap(corners, centre, radius, (1 - _RESERVE) * inward, _RESERVE * inward, points, gaps)
    # rounding of the last digits is not a fault
    bad = points[gaps[:, 1] > inward * (1 + 1e-9)]
    return bad[thin_points(bad, 0.5 * inward)] if len(bad) else bad


def hollow_places(surface: Surface, centre: Floats, radius: Floats, inward: float) -> Floats:
    """Return points (k, 3) of the exposed spheres that are not proved to lie at most `inward` [m] under
    the surface.
    """
    places = _deep(surface, (centre, radius), inward, _RESERVE * inward, most=64)[0]
    return places[thin_points(places, 0.5 * inward)] if len(places) else places


def deepest_hollow(surface: Surface, centre: Floats, radius: Floats, floor: float) -> float:
    """Return a proved upper bound [m], to 2 %, of how deep the union's surface lies under the surface.

    The bound is at least `floor`, and at least 1/500 of the root of the area (0.6 mm of a hand, 2.7 mm
    of a body): a finer proof needs too many patches.
    """
    bound = max(floor, 0.002 * np.sqrt(surface.area))
    for _ in range(60):
        _, upper = _deep(surface, (centre, radius), bound, _RESERVE * bound, most=64)
        if upper <= bound * (1 + 1e-9):
            return float(bound)
        bound = max(1.01 * bound, upper)
    return float(np.inf)


def gap_bound(corners: Floats, centre: Floats, radius: Floats) -> float:
    """Return a proved upper bound [m], to 2 %, of how far triangles (T, 3, 3) lie outside the union."""
    if not len(corners) or not len(radius):
        return float("inf") if len(corners) else 0.0
    middle = corners.mean(axis=1)
    floor = max(float(union_field(middle[morton_order(middle)], centre, radius)[0].max()), 1e-5)
    points = np.empty((len(corners), 3))
    gaps = np.empty((len(corners), 2))
    for _ in range(2):
        widest_gap(corners, centre, radius, floor, _RESERVE * floor, points, gaps)
        floor = max(floor, float(gaps[:, 0].max()))
    return float(max(0.0, gaps[:, 1].max()))


def split_triangles(corners: Floats, longest: float) -> Floats:
    """Return triangles (T, 3, 3) halved across their longest side until none is longer than `longest` [m]."""
    done = []
    while len(corners):
        side = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        large = side.max(axis=1) > longest
        done.append(corners[~large])
        turn = (side[large].argmax(axis=1)[:, None] + np.arange(3)) % 3
        a, b, c = np.moveaxis(np.take_along_axis(corners[large], turn[:, :, None], axis=1), 1, 0)
        middle = 0.5 * (a + b)
        halves = [np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)]
        corners = np.stack(halves, axis=1).reshape(-1, 3, 3)
    return np.concatenate(done)


def _deep(
    surface: Surface, spheres: tuple[Floats, Floats], inward: float, fine: float, *, most: int
) -> tuple[Floats, float]:
    """Places (k, 3) on the exposed spheres not proved at most `inward` deep, `most` a sphere, and the deepest [m]."""
    points = np.empty((most * len(spheres[1]), 3))
    depth = np.empty(most * len(spheres[1]))
    found = deep_patches(*spheres, _icosahedron(), surface.solid, inward, fine, most, points, depth)
    return points[:found], float(depth[:found].max(initial=inward))


def _icosahedron() -> Floats:
    """(20, 3, 3) corners of the faces, unit vectors."""
    points = [(0.0, a, b * _GOLDEN) for a in (-1, 1) for b in (-1, 1)]
    ring = np.array([np.roll(p, k) for k in range(3) for p in points]) / np.sqrt(1 + _GOLDEN**2)
    near = ring @ ring.T > 0.4
    triples = [(i, j, k) for i in range(12) for j in range(i) for k in range(j)]
    faces: Floats = ring[
        np.array([(i, j, k) for i, j, k in triples if near[i, j] and near[j, k] and near[i, k]])
    ]
    return faces
