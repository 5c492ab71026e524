"""Legs of a driver: soles from floor to pedal, and the hip position that suits thigh, knee and
ankle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.driving import Package
from workbench.model.joint_angles import motion_of
from workbench.posture.kernels.chain_kinematics import Linkage
from workbench.posture.kernels.driving_legs import DrivingLegs, least_costs
from workbench.posture.reaching.comfort import comfort_modes
from workbench.posture.reaching.limbs import Limb, limb
from workbench.posture.reaching.packing import packed_links
from workbench.posture.seating.driving_angles import residuals
from workbench.posture.seating.posture import pointed_foot

__all__ = [
    "HEEL_LIFT",
    "Sole",
    "accelerator_foot",
    "ankles_wanted",
    "directions_of",
    "hips_from_pedal",
    "pitches_at",
    "soles_on",
]

ALIKE = 1e-3
"""Distances [m] of two feet from the accelerator that differ by less are alike."""

NEAREST_HIP = 0.15
FARTHEST_HIP = 1.3
"""How far aft of the ball of the foot [m] hips are searched."""
STRETCHED = 0.97
"""Of its whole length the leg of the other foot is at most so long: the knee is bent by 28 degrees,
the least that was observed of drivers (Park 2000: included angles up to 152 degrees). Straighter
legs would press their thighs into the cushion."""
THIGH = 6
KNEE = 7
"""Indices of thigh and knee among the angles of a driving posture."""
ANKLE_SPREAD = np.radians(10.0)
"""Standard deviation of drivers' ankles [rad]. The ranges that were observed, taken from the 5th to
the 95th percentile, give 8.5 degrees (Wolf 2022, 85 to 113), 10 (Porter & Gyi 1998, 80 to 113) and
12.8 (Park 2000, 82 to 124)."""
WIDER = np.sqrt(2.0)
"""How much farther from their means thigh and knee are expected than they were drawn. Published is
the scatter of angles that people show. Two angles that are drawn independently do not go together,
as the foot gives only so far and leaves one freedom: where the hips are. Least squares leave of two
units of variance one."""
HEEL_LIFT = 0.025
"""How far [m] a heel may be lifted so that the sole is flatter than its pedal, at most: about 12
degrees on an accelerator."""


@dataclass(frozen=True, eq=False)
class Sole:
    """Soles of B drivers' feet with the balls on their pedal."""

    at: Floats
    """(B, 3) [m] where the balls of the feet go."""
    steepest: Floats
    """(B,) [rad] pitch of the soles above the horizontal in the plane of the pedal, the heels on the
    floor."""
    flattest: Floats
    """(B,) [rad] pitch with the heels lifted by `HEEL_LIFT`."""
    limb: Limb
    """The leg, which points from heel to ball."""
    link: Linkage
    """Its chain."""
    sole: Floats
    """(B, 3) [m] from heel to ball, in the foot's frame."""

    @property
    def own_pitch(self) -> Floats:
        """(B,) [rad] of the sole in the foot's frame."""
        return np.arctan2(self.sole[:, 2], self.sole[:, 0])


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
    """Place the sole of a foot in the plane that rises from the heel point to the pedal, or flatter.

    For the foot that is not on the accelerator the plane starts beside the heel point. In the plane
    the round of the heel rests in the corner of floor and plane, and the ball lies as far up as the
    foot is long. There it stays when the heel is lifted. The sole of a shoe lies under the foot's
    own.

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
        Where the balls of the feet go, how steep their soles may be, and the leg.
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
    # no flatter than the floor
    rise = np.maximum(np.sin(slope) - HEEL_LIFT / length, min(np.sin(slope), 0.0))
    return Sole(
        at=np.ascontiguousarray(where),
        steepest=np.full(len(body), slope),
        flattest=np.arcsin(rise),
        limb=chain,
        link=link,
        sole=sole,
    )


def directions_of(pitch: Floats) -> Floats:
    """Return unit directions (B, 3) from heel to ball of soles of a pitch (B,) [rad]."""
    return np.stack([np.cos(pitch), np.zeros(len(pitch)), np.sin(pitch)], axis=1)


def ankles_wanted(body: Body, foot: str, seed: int | None, numbers: Sequence[int]) -> Floats:
    """Return the plantarflexion (B,) [rad] that drivers want of an ankle.

    Parameters
    ----------
    seed
        The ankles on the accelerator are drawn about the mode of comfort, by the numbers (B,) of the
        drivers; others, and all if None, have the mode.
    """
    joint = limb(body, foot, grip="ball").free[-1]
    axis, sign = motion_of(body, joint, "plantarflexion")
    mode, _ = comfort_modes(body, joint)
    wanted = np.full(len(body), sign * mode[axis])
    if seed is None:
        return wanted
    # a stream beside that of the other angles: these stay as they are
    drawn = np.array([residuals(seed, (number, 1), 1) for number in numbers])
    wanted += ANKLE_SPREAD * drawn[:, 0]
    return wanted


def hips_from_pedal(
    pedal: Sole,
    height: Floats,
    angles: tuple[Floats, Floats, Floats],
    ankles: Floats,
    others: Sequence[Sole] = (),
) -> Floats:
    """Find how far forward the hips are if thigh, knee and ankle come nearest to what is expected.

    Parameters
    ----------
    pedal
        The soles of the feet on the accelerator.
    height
        (B,) heights of the hips [m].
    angles
        (B, 8) [rad] the mean angles of such drivers, the angles of each, and the scatter.
    ankles
        (B,) [rad] as of `ankles_wanted`.
    others
        The soles of other feet: hips are where their legs are long enough, too.

    Returns
    -------
    Floats
        (B,) x [m] of the hips.
    """
    mean, drawn, spread = (some[:, [THIGH, KNEE]] for some in angles)
    expected = mean + WIDER * (drawn - mean)
    x = pedal.at[:, 0]
    legs = _legs(pedal, height, ankles, expected, spread, others)
    ends = np.stack([x - FARTHEST_HIP, x - NEAREST_HIP], axis=1)
    return _least(legs, pedal, ends)[:, 0]


def pitches_at(sole: Sole, hips: Floats, ankles: Floats) -> Floats:
    """Find the pitch (B,) [rad] at which ankles come nearest to what is wanted (B,) [rad], with the
    hips (B, 3) [m] where they are."""
    nothing = np.zeros((len(hips), 2))
    height = np.ascontiguousarray(hips[:, 2])
    legs = _legs(sole, height, ankles, nothing, np.full_like(nothing, np.inf))
    return _least(legs, sole, np.repeat(hips[:, :1], 2, axis=1))[:, 1]


def _legs(
    sole: Sole,
    height: Floats,
    ankles: Floats,
    expected: Floats,
    spread: Floats,
    others: Sequence[Sole] = (),
) -> DrivingLegs:
    """Legs with their hips at heights (B,) [m], as of `DrivingLegs`: thigh and knee (B, 2) [rad] are
    expected, and ankles (B,) [rad] are wanted."""
    own = sole.link.at_child[:, 2] - sole.link.tip
    scatter = np.full((len(height), 1), ANKLE_SPREAD)
    bounds = np.empty((len(others), len(height), 3))
    for bound, other in zip(bounds, others, strict=True):
        bound[:, :2] = _ankles(other)
        bound[:, 2] = STRETCHED * _lengths(other).sum(axis=1)
    return DrivingLegs(
        _lengths(sole),
        np.ascontiguousarray(sole.at[:, ::2]),
        np.ascontiguousarray(own[:, ::2]),
        sole.own_pitch,
        height,
        np.hstack([expected, ankles[:, None]]),
        np.hstack([spread, scatter]),
        bounds,
    )


def _lengths(sole: Sole) -> Floats:
    """(B, 2) [m] lengths of thighs and shanks."""
    link = sole.link
    bones = link.at_child[:, :2] - link.at_parent[:, 1:3]
    return np.linalg.norm(bones, axis=2)


def _ankles(sole: Sole) -> Floats:
    """(B, 2) x and z [m] of the ankles of soles in the plane of their pedal."""
    own = sole.link.at_child[:, 2] - sole.link.tip
    turn = sole.steepest - sole.own_pitch
    c = np.cos(turn)
    s = np.sin(turn)
    along = np.stack([c * own[:, 0] - s * own[:, 2], s * own[:, 0] + c * own[:, 2]], axis=1)
    return sole.at[:, ::2] + along


def _least(legs: DrivingLegs, sole: Sole, hips: Floats) -> Floats:
    """(B, 2) x [m] of the hips, between two ends (B, 2), and pitch [rad] at the least cost."""
    pitches = np.stack([sole.flattest, sole.steepest], axis=1)
    found = np.empty((len(hips), 2))
    least_costs(legs, hips, pitches, found)
    return found
