"""Where markers sit on the skin of a sphere body."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.motion.recorded.marker_names import Site

__all__ = ["marker_places"]

_MARKER_RADIUS = 0.007
"""[m]"""


def marker_places(body: Body, sites: Mapping[str, Site]) -> tuple[Floats, Floats]:
    """Where each marker should sit in its segment's frame (M, 3) [m], and how far it may be from
    there (M,) [m]."""
    size = _stature(body) / 1.75
    local = [_place(body, site, size) for site in sites.values()]
    return np.array(local), np.array([site.spread for site in sites.values()])


def _stature(body: Body) -> float:
    """Rough height [m] of a body in the zero pose, from the ankles to the top of the head."""
    z = body.zero_origins[0, body.sphere_segment, 2] + body.centre[0, :, 2]
    return float((z + body.radius[0]).max() - (z - body.radius[0]).min())


def _place(body: Body, site: Site, size: float) -> Floats:
    n = body.segment(site.segment)
    points = [
        body.joint_in_child[0, j] if n == j + 1 else body.joint_in_parent[0, j]
        for j in map(body.joint, site.joints)
    ]
    base = (
        np.zeros(3)
        if not points
        else points[0]
        if len(points) == 1
        else points[0] + site.along * (points[1] - points[0])
    )
    out = 1.0 if site.side == "L" else -1.0
    mirror = np.array([1.0, out, 1.0])
    base = base + np.array(site.shift) * mirror * size
    ways = {
        "front": (1, 0, 0),
        "back": (-1, 0, 0),
        "top": (0, 0, 1),
        "out": (0, out, 0),
        "in": (0, -out, 0),
    }
    way: Floats = np.sum([ways[word] for word in site.toward.split()], axis=0, dtype=np.float64)
    way /= np.linalg.norm(way)
    return np.asarray(base + way * (_skin(body, n, (base, way)) + _MARKER_RADIUS))


def _skin(body: Body, segment: int, ray: tuple[Floats, Floats]) -> float:
    """How far [m] the last sphere of a segment reaches along a ray from a point."""
    base, way = ray
    spheres = body.spheres(segment)
    gap = body.centre[0, spheres] - base
    along = gap @ way
    under = body.radius[0, spheres] ** 2 - (np.sum(gap**2, axis=1) - along**2)
    met = under > 0
    return float(np.max(along[met] + np.sqrt(under[met]), initial=0.0))
