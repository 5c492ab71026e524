"""Legs of a driver: soles on the pedal plane, and the hip position that suits thigh and knee."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.driving import Package
from workbench.posture.kernels.linkage import Linkage
from workbench.posture.reaching.limbs import Limb, limb
from workbench.posture.reaching.packing import packed_links
from workbench.posture.seating.leg_triangle import leg_triangle
from workbench.posture.seating.posture import pointed_foot

__all__ = ["Sole", "accelerator_foot", "hips_from_pedal", "soles_on"]

ALIKE = 1e-3
"""Distances [m] of two feet from the accelerator that differ by less are alike."""

GRID_SPACING = 0.001
"""Spacing [m] of the hip positions that are tried."""
NEAREST_HIP = 0.15
FARTHEST_HIP = 1.3
"""How far aft of the ankle [m] hips are searched."""
OUT_OF_REACH = 1e3
"""Cost [1/m] of an ankle that the leg does not reach. It outweighs every angle."""
THIGH = 6
KNEE = 7
"""Indices of thigh and knee among the angles of a driving posture."""


@dataclass(frozen=True, eq=False)
class Sole:
    """Soles of B drivers' feet on the pedal plane."""

    at: Floats
    """(B, 3) [m] where the balls of the feet go."""
    along: Floats
    """(3,) unit direction from heel to ball, up the plane."""
    limb: Limb
    """The leg, which points from heel to ball."""
    link: Linkage
    """Its chain."""
    sole: Floats
    """(B, 3) [m] from heel to ball, in the foot's frame."""


def accelerator_foot(
    feet: Mapping[str, tuple[float, float, float]], at: tuple[float, float, float]
) -> str:
    """Return the foot that is on the accelerator: the nearer one, right where both are as near.

    Parameters
    ----------
    feet
        By "left foot" and "right foot", one at least, where it is [m].
    at
        The ball of foot reference point, or the heel point [m].
    """
    away = {foot: float(np.linalg.norm(np.subtract(point, at))) for foot, point in feet.items()}
    right = away.get("right foot", math.inf)
    return "left foot" if away.get("left foot", math.inf) < right - ALIKE else "right foot"


def soles_on(body: Body, foot: str, at: tuple[float, float, float], package: Package) -> Sole:
    """Place the sole of a foot in the plane that rises from the heel point to the pedal.

    For the foot that is not on the accelerator the plane starts beside the heel point. The round of
    the heel rests in the corner of floor and plane, and the ball lies as far up as the foot is long.
    The sole of a shoe lies under the foot's own.

    Parameters
    ----------
    body
        B drivers.
    foot
        "left foot" or "right foot".
    at
        Centre of the pedal [m].
    package
        The vehicle package, with its heel point.

    Returns
    -------
    Sole
        Where the balls of the feet go, and the leg.
    """
    chain = pointed_foot(body, foot)
    link = packed_links(body, chain)
    heel = limb(body, foot, grip="heel")
    ball = link.tip
    back = heel.tip
    sole = ball - back
    length = np.linalg.norm(sole, axis=1)
    start = np.array([package.heel[0], at[1], package.heel[2]])
    plane = (np.array(at) - start) / np.linalg.norm(np.array(at) - start)
    slope = float(np.arctan2(plane[2], plane[0]))
    spheres = body.spheres(heel.end)
    row = int(spheres.start) + body.sphere_names[spheres].index("heel")
    lowest = (body.centre[:, spheres, 2] - body.radius[:, spheres]).min(axis=1)
    under = np.maximum(np.minimum(ball[:, 2], back[:, 2]) - lowest, 0.0)
    up_plane = (body.radius[:, row] + under) * np.tan(0.5 * slope) + length
    lift = np.array([-plane[2], 0.0, plane[0]])
    where = start + up_plane[:, None] * plane + under[:, None] * lift
    return Sole(np.ascontiguousarray(where), plane, chain, link, sole)


def hips_from_pedal(pedal: Sole, height: Floats, mean: Floats, spread: Floats) -> Floats:
    """Find how far forward the hips are if thigh and knee come nearest to their expected angles.

    Parameters
    ----------
    pedal
        The soles of the feet on the accelerator.
    height
        (B,) heights of the hips [m].
    mean, spread
        (B, 8) [rad] the expected angles of each driver, and their scatter.

    Returns
    -------
    Floats
        (B,) x [m] of the hips.
    """
    link = pedal.link
    thigh = np.linalg.norm(link.at_child[:, 0] - link.at_parent[:, 1], axis=1)
    shank = np.linalg.norm(link.at_child[:, 1] - link.at_parent[:, 2], axis=1)
    ankle_x, ankle_z = _ankles(pedal)
    aft = np.arange(NEAREST_HIP, FARTHEST_HIP, GRID_SPACING)
    found = np.zeros(len(height))
    for b in range(len(height)):
        rise = ankle_z[b] - height[b]
        leg = leg_triangle(thigh[b], shank[b], np.hypot(aft, rise))
        lifted = np.arctan2(rise, aft) + leg.hip
        # least squares in units of the scatter
        lift = (lifted - mean[b, THIGH]) / spread[b, THIGH]
        bend = (leg.knee - mean[b, KNEE]) / spread[b, KNEE]
        cost = lift * lift + bend * bend + OUT_OF_REACH * np.abs(leg.lack)
        found[b] = ankle_x[b] - _least(aft, cost)
    return found


def _ankles(sole: Sole) -> tuple[Floats, Floats]:
    """(B,) x and z [m] of the ankles of feet whose soles lie in the plane."""
    turn = np.arctan2(sole.along[2], sole.along[0]) - np.arctan2(sole.sole[:, 2], sole.sole[:, 0])
    own = (
        sole.link.at_child[:, 2] - sole.link.tip
    )  # from the ball to the ankle, in the foot's frame
    c = np.cos(turn)
    s = np.sin(turn)
    x: Floats = sole.at[:, 0] + c * own[:, 0] - s * own[:, 2]
    z: Floats = sole.at[:, 2] + s * own[:, 0] + c * own[:, 2]
    return x, z


def _least(grid: Floats, cost: Floats) -> float:
    """Where a cost on an even grid is least: the vertex of the parabola through its least three."""
    best = int(np.clip(np.argmin(cost), 1, len(grid) - 2))
    before, at, after = cost[best - 1 : best + 2]
    shift = 0.5 * (before - after) / max(before - 2 * at + after, 1e-12)
    return float(grid[best] + GRID_SPACING * shift)
