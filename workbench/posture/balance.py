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
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.poses import Placed

__all__ = ["Balance", "balance", "centre_of_mass", "edges_of", "sole_points", "support_polygon"]

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
    support = tuple(support_polygon(sole_points(placed, row)) for row in range(len(placed)))
    margin = np.array(
        [_margin(corners, at) for corners, at in zip(support, centre[:, :2], strict=True)]
    )
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
    centre: Floats = moment / total[:, None]
    return centre


def sole_points(placed: Placed, row: int) -> Floats:
    """(C, 2) [m] the points of one pose's soles that bear, seen from above; InputError for a body
    without feet."""
    body = placed.body
    rows = foot_spheres(body)
    low = placed.centres[row, rows, 2] - body.radius[placed.person[row], rows]
    points: Floats = placed.centres[row, rows, :2][low < low.min() + SOLE]
    return points


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


def _margin(corners: Floats, point: Floats) -> float:
    """How far [m] a point (2,) is inside a convex polygon (V, 2), negative outside."""
    if len(corners) > 2:
        inward, offset = edges_of(corners)
        inside = float((inward @ point - offset).min())
        if inside >= 0.0:
            return inside
    ends = np.roll(corners, -1, axis=0) - corners
    arm = point - corners
    length = np.maximum(np.sum(ends * ends, axis=1), 1e-18)
    share = np.clip(np.sum(arm * ends, axis=1) / length, 0.0, 1.0)
    return -float(np.linalg.norm(arm - share[:, None] * ends, axis=1).min())
