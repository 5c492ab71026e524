"""Balance: the centre of mass of a body over the ground that its feet stand on.

A body that stands still is in balance while the plumb line of its centre of mass meets the ground
within the support polygon, the convex hull of what touches the ground [1]_. Here the soles are
points: the centres of the spheres of both feet that come within 10 mm of the lowest one, seen from
above. So the polygon ends some 20 to 40 mm inside the outline of the feet. People use about this
much of it: 60 % of the length of their feet when they lean as far as they can [2]_.

References
----------
.. [1] D. A. Winter (1995), Human balance and posture control during standing and walking,
   Gait and Posture 3, 193-214.
.. [2] M. B. King, J. O. Judge and L. Wolfson (1994), Functional base of support decreases with age,
   Journal of Gerontology 49, M258-M263.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.poses import Placed

__all__ = [
    "Balance",
    "balance",
    "bearing",
    "centre_of_mass",
    "edges_of",
    "foot_spheres",
    "hull_margins",
    "sole_points",
    "support_polygon",
]

SOLE = 0.01
"""Height [m] over the lowest sphere of the feet up to which a sphere bears."""


@dataclass(frozen=True, eq=False)
class Balance:
    """The balance of P poses."""

    centre: Floats
    """(P, 3) [m] the centre of mass in the world."""
    support: tuple[Floats, ...]
    """Of each pose the corners (V, 2) [m] of the support polygon, against the clock from above."""
    margin: Floats
    """(P,) [m] how far the centre of mass is inside the support polygon, seen from above; negative
    outside."""


def balance(placed: Placed) -> Balance:
    """Compute the centre of mass, the support polygon of the feet, and how far the one is within
    the other.

    Parameters
    ----------
    placed
        P bodies in the world, z upward. What they hold or lean on does not count.

    Raises
    ------
    InputError
        If the body has no mass, or no feet.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> standing = wb.place(body, wb.pose(body, {}))
    >>> float(wb.balance(standing).margin[0].round(3))  # [m] inside the soles
    0.029
    """
    centre = centre_of_mass(placed)
    support = tuple(support_polygon(points) for points in sole_points(placed))
    spheres = foot_spheres(placed.body)
    bears = bearing(placed, spheres, np.array([0.0, 0.0, -1.0]))
    margin = hull_margins(placed.centres[:, spheres, :2], bears, centre[:, :2])
    return Balance(centre, support, margin)


def centre_of_mass(placed: Placed) -> Floats:
    """(P, 3) [m] the centres of mass of placed bodies: of each segment the origin of its frame,
    weighted by its mass; InputError for a body without mass."""
    body = placed.body
    mass = body.mass[placed.person]
    total = mass.sum(axis=1)
    if not np.all(total > 0.0):
        raise InputError(f"body {body.name} has no mass, so it has no balance")
    moment = np.einsum("pn,pni->pi", mass, placed.world_from_segment[..., 3])
    return moment / total[:, None]


def sole_points(placed: Placed) -> list[Floats]:
    """Of each pose the points (C, 2) [m] of the soles that bear, seen from above; InputError for a
    body without feet."""
    spheres = foot_spheres(placed.body)
    bears = bearing(placed, spheres, np.array([0.0, 0.0, -1.0]))
    return [placed.centres[row, spheres[some], :2] for row, some in enumerate(bears)]


def bearing(placed: Placed, spheres: Ints, toward: Floats) -> Bools:
    """(P, F) which of some spheres (F,) bear: True for those that come within `SOLE` of the farthest
    one in a direction (3,) of the world."""
    height = placed.centres[:, spheres] @ toward + placed.body.radius[placed.person][:, spheres]
    return height > height.max(axis=1, keepdims=True) - SOLE


def foot_spheres(body: Body) -> Ints:
    """(F,) the spheres of both feet, by number; InputError for a body without feet."""
    feet = [body.segment(name) for name in ("LF", "RF") if name in body.segments]
    rows = np.flatnonzero(np.isin(body.sphere_segment, feet))
    if not len(rows):
        raise InputError(f"body {body.name} has no feet (segments LF, RF), so it has no balance")
    return rows


def support_polygon(points: Floats) -> Floats:
    """(V, 2) the corners of the convex hull of points (C, 2), against the clock, by Andrew's
    monotone chain (1979); fewer than three where the points lie in a line."""
    order = np.lexsort((points[:, 1], points[:, 0]))
    sorted_points = points[order].tolist()
    halves = []
    for way in (sorted_points, sorted_points[::-1]):
        chain: list[list[float]] = []
        for point in way:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], point) <= 0.0:
                chain.pop()
            chain.append(point)
        halves.append(chain[:-1])
    return np.array(halves[0] + halves[1] or sorted_points[:1])


def _turn(a: list[float], b: list[float], c: list[float]) -> float:
    """Twice the area of a triangle, positive against the clock."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def edges_of(corners: Floats) -> tuple[Floats, Floats]:
    """The inward normals (V, 2) of the edges of a polygon and their offsets (V,) [m]: a point p is
    inside by normal . p - offset."""
    along = np.roll(corners, -1, axis=0) - corners
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)
    inward = inward / np.linalg.norm(along, axis=1, keepdims=True)
    return inward, np.sum(inward * corners, axis=1)


def hull_margins(points: Floats, bears: Bools, at: Floats) -> Floats:
    """How far points are inside the convex hulls of others, for P of both.

    The hull is walked from corner to corner, for all P at once, by Jarvis's march (1973).

    Parameters
    ----------
    points
        (P, K, 2) [m] the points of each hull.
    bears
        (P, K) which of them count; one at least of each.
    at
        (P, 2) [m] the points that are asked for.

    Returns
    -------
    Floats
        (P,) [m] the distance from the edge, negative outside. Of a hull without area all is outside.
    """
    some = bears.any(axis=0)
    points, bears = points[:, some], bears[:, some]
    lowest = np.where(bears, points[..., 0], np.inf).min(axis=1, keepdims=True)
    first = np.where(bears & (points[..., 0] == lowest), points[..., 1], np.inf).argmin(axis=1)
    start = points[np.arange(len(points)), first]
    corner = start
    nearest = np.full(len(points), np.inf)
    area = np.zeros(len(points))
    inside = np.ones(len(points), dtype=np.bool_)
    for _ in range(points.shape[1]):
        following = corner
        for k in range(points.shape[1]):
            way, other = following - corner, points[:, k] - corner
            turn = _cross(way, other)
            farther = (turn == 0.0) & (np.sum(other**2, axis=1) > np.sum(way**2, axis=1))
            better = bears[:, k] & ((turn < 0.0) | farther)
            following = np.where(better[:, None], points[:, k], following)
        edge, arm = following - corner, at - corner
        length = np.maximum(np.sum(edge**2, axis=1), 1e-18)
        share = np.clip(np.sum(arm * edge, axis=1) / length, 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(arm - share[:, None] * edge, axis=1))
        inside &= _cross(edge, arm) >= 0.0
        area += _cross(corner - start, edge)
        corner = following
        if np.array_equal(corner, start):
            break
    return np.where(inside & (area > 1e-12), nearest, -nearest)


def _cross(a: Floats, b: Floats) -> Floats:
    """(P,) twice the areas of the triangles of vectors (P, 2), positive against the clock."""
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
