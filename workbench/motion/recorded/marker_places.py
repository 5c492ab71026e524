"""Compute where markers sit on the skin of a sphere body."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.motion.recorded.marker_names import Site

__all__ = ["marker_places"]

_MARKER_RADIUS = 0.007
"""Radius [m] of a marker, whose centre is recorded."""
_SITE_STATURE = 1.75
"""Stature [m] of the body in which the shifts of sites are given."""


def marker_places(body: Body, sites: Mapping[str, Site]) -> tuple[Floats, Floats]:
    """Compute the places of M markers on a body.

    Returns
    -------
    tuple of Floats
        Centres (M, 3) [m] in the segments' frames, and the spread (M,) [m] of real markers.
    """
    scale = _height(body) / _SITE_STATURE
    places = [_place(body, site, scale) for site in sites.values()]
    return np.array(places), np.array([site.spread for site in sites.values()])


def _height(body: Body) -> float:
    """Height [m] of a body in the zero pose, from the lowest to the highest sphere."""
    z = body.zero_origins[0, body.sphere_segment, 2] + body.centre[0, :, 2]
    return float((z + body.radius[0]).max() - (z - body.radius[0]).min())


def _place(body: Body, site: Site, scale: float) -> Floats:
    """(3,) [m] centre of a marker in its segment's frame; scale: of the site's shift."""
    segment = body.segment(site.segment)
    outward = 1.0 if site.side == "L" else -1.0
    shift = np.array(site.shift) * np.array([1.0, outward, 1.0]) * scale
    base = _base(body, segment, site) + shift
    direction = _direction(site.toward, outward)
    return np.asarray(base + direction * (_skin(body, segment, base, direction) + _MARKER_RADIUS))


def _base(body: Body, segment: int, site: Site) -> Floats:
    """(3,) [m] the origin, one joint, or a point between two joints, in the segment's frame."""
    points = [
        body.joint_in_child[0, j] if segment == j + 1 else body.joint_in_parent[0, j]
        for j in map(body.joint, site.joints)
    ]
    if not points:
        return np.zeros(3)
    if len(points) == 1:
        return np.asarray(points[0])
    return np.asarray(points[0] + site.along * (points[1] - points[0]))


def _direction(words: str, outward: float) -> Floats:
    """(3,) unit vector of the sum of directions by name; outward: the sign of y on this side."""
    vectors = {
        "front": (1, 0, 0),
        "back": (-1, 0, 0),
        "top": (0, 0, 1),
        "out": (0, outward, 0),
        "in": (0, -outward, 0),
    }
    total: Floats = np.sum([vectors[word] for word in words.split()], axis=0, dtype=np.float64)
    return total / np.linalg.norm(total)


def _skin(body: Body, segment: int, origin: Floats, direction: Floats) -> float:
    """Distance [m] at which a ray leaves the last sphere of a segment, 0 if it meets none."""
    spheres = body.spheres(segment)
    # a sphere at gap g with g.d = s is left at s + sqrt(r^2 - (g.g - s^2))
    gap = body.centre[0, spheres] - origin
    along = gap @ direction
    half_chord_squared = body.radius[0, spheres] ** 2 - (np.sum(gap**2, axis=1) - along**2)
    met = half_chord_squared > 0
    return float(np.max(along[met] + np.sqrt(half_chord_squared[met]), initial=0.0))
