"""A driver's legs: soles on the pedal plane, and how far aft of the pedal thigh and knee have the
angles expected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.driving import DrivingAngles, Package
from workbench.posture.kernels.linkage import Linkage
from workbench.posture.reaching.limbs import Limb, limb
from workbench.posture.reaching.packing import packed_links
from workbench.posture.seating.posture import pointed_foot

__all__ = ["Sole", "hips_from_pedal", "soles_on"]

GRID = 0.001
"""Spacing [m] of the hip places that are tried."""
NEAR = 0.15
FAR = 1.3
"""How far aft of the ankle [m] hips are looked for."""


@dataclass(frozen=True, eq=False)
class Sole:
    """The soles of B drivers' feet: at (B, 3) [m] where the balls go, along (3,) the way from heel
    to ball; the leg as a limb, its chain packed, pointing from heel to ball; sole (B, 3) [m] from
    heel to ball in the foot's frame."""

    at: Floats
    along: Floats
    limb: Limb
    link: Linkage
    sole: Floats


def soles_on(body: Body, foot: str, at: tuple[float, float, float], package: Package) -> Sole:
    """Soles in the plane that rises from the heel point (for the other foot: from beside it) to the
    pedal.

    Soles of shoes lie under the foot's own. The round of the heel rests in the corner of floor and
    plane, and the ball lies as far up as the foot is long.
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


def hips_from_pedal(right: Sole, height: Floats, angles: Sequence[DrivingAngles]) -> Floats:
    """(B,) x [m] of the hips at heights (B,) [m] from which thigh and knee come nearest to their
    angles, in units of their scatter, the right foot being on the accelerator."""
    link = right.link
    thigh = np.linalg.norm(link.at_child[:, 0] - link.at_parent[:, 1], axis=1)
    shank = np.linalg.norm(link.at_child[:, 1] - link.at_parent[:, 2], axis=1)
    turn = np.arctan2(right.along[2], right.along[0]) - np.arctan2(
        right.sole[:, 2], right.sole[:, 0]
    )
    own = link.at_child[:, 2] - link.tip  # from the ball to the ankle, in the foot's frame
    end = right.at[:, 0] + np.cos(turn) * own[:, 0] - np.sin(turn) * own[:, 2]
    rise = right.at[:, 2] + np.sin(turn) * own[:, 0] + np.cos(turn) * own[:, 2] - height
    aft = np.arange(NEAR, FAR, GRID)
    found = np.zeros(len(height))
    for b, one in enumerate(angles):
        a = float(thigh[b])
        s = float(shank[b])
        gap = np.hypot(aft, rise[b])
        span = np.clip(gap, abs(a - s) + 1e-6, a + s - 1e-6)
        bent = np.arccos((a**2 + s**2 - span**2) / (2 * a * s))
        lifted = np.arctan2(rise[b], aft) + np.arccos((a**2 + span**2 - s**2) / (2 * a * span))
        lift = (lifted - one.mean[6]) / one.spread[6]
        bend = (bent - one.mean[7]) / one.spread[7]
        cost = lift * lift + bend * bend + 1e3 * np.abs(gap - span)
        best = int(np.clip(np.argmin(cost), 1, len(aft) - 2))
        p, q, r = cost[best - 1 : best + 2]
        found[b] = end[b] - aft[best] + GRID * -0.5 * (p - r) / max(p - 2 * q + r, 1e-12)
    return found
