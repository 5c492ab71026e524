"""What rays meet first in an environment: what is above a head, before knees, under feet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = ["Hits", "first_hits", "upright_fan"]

EDGE_ON = 1e-12
"""Twice the area [m2] of a triangle seen along the ray, at which it is seen from its edge."""
START = 1e-6
"""[m] from its origin on a ray meets things."""


@dataclass(frozen=True, eq=False)
class Hits:
    """What R rays meet first: (R,) the distance [m], infinite where nothing is met, and the part,
    -1 there."""

    distance: Floats
    part: Ints

    @property
    def parts(self) -> list[int]:
        """The parts that are met, in their order."""
        return [int(part) for part in np.unique(self.part[self.part >= 0])]


def first_hits(
    environment: Environment, origins: Floats, ways: Floats, *, length: float, among: Bools
) -> Hits:
    """Find what rays meet first, by the intersection of Moeller and Trumbore.

    Parameters
    ----------
    origins, ways
        (R, 3) [m] where the rays begin, and their unit directions.
    length
        How far [m] they go.
    among
        (K,) the parts that count.

    References
    ----------
    .. [1] T. Moeller and B. Trumbore (1997), Fast, minimum storage ray-triangle intersection,
       Journal of Graphics Tools 2(1), 21-28.
    """
    count = len(origins)
    found = Hits(np.full(count, np.inf), np.full(count, -1))
    if not count:
        return found
    low = np.minimum(origins, origins + length * ways).min(axis=0)
    high = np.maximum(origins, origins + length * ways).max(axis=0)
    for part in np.flatnonzero(among).tolist():
        corners = environment.triangle_corners(part)
        near = (corners.min(axis=1) <= high).all(axis=1) & (corners.max(axis=1) >= low).all(axis=1)
        corners = corners[near]
        if not len(corners):
            continue
        for ray in range(count):
            distance = _nearest(corners, origins[ray], ways[ray])
            if distance < min(found.distance[ray], length):
                found.distance[ray] = distance
                found.part[ray] = part
    return found


def _nearest(corners: Floats, origin: Floats, way: Floats) -> float:
    """How far [m] from its origin a ray meets the first of triangles (T, 3, 3); infinite if none."""
    one = corners[:, 1] - corners[:, 0]
    two = corners[:, 2] - corners[:, 0]
    across = np.cross(way, two)
    size = np.einsum("ti,ti->t", one, across)
    seen = np.abs(size) > EDGE_ON
    scale = 1.0 / np.where(seen, size, 1.0)
    start = origin - corners[:, 0]
    u = scale * np.einsum("ti,ti->t", start, across)
    turned = np.cross(start, one)
    v = scale * (turned @ way)
    distance = scale * np.einsum("ti,ti->t", two, turned)
    meets = seen & (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > START)
    return float(np.min(distance[meets], initial=np.inf))


def upright_fan(ahead: Floats, rises: Floats, turns: Floats) -> Floats:
    """(R, 3) unit directions at angles of elevation, each at all angles [rad] about the vertical
    from straight `ahead` (3,)."""
    aside = np.array([-ahead[1], ahead[0], 0.0])
    rise, turn = (axis.ravel() for axis in np.meshgrid(rises, turns, indexing="ij"))
    level = np.cos(turn)[:, None] * ahead + np.sin(turn)[:, None] * aside
    found: Floats = np.cos(rise)[:, None] * level
    found[:, 2] = np.sin(rise)
    return found
