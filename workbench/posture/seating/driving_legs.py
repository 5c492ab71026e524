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
from workbench.model.posing import motion_of
from workbench.posture.kernels.linkage import Linkage
from workbench.posture.reaching.comfort import comfort_modes
from workbench.posture.reaching.limbs import Limb, limb
from workbench.posture.reaching.packing import packed_links
from workbench.posture.seating.driving_angles import residuals
from workbench.posture.seating.leg_triangle import leg_triangle
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
OUT_OF_REACH = 1e6
"""Cost [1/m] of an ankle that the leg does not reach. It outweighs every angle."""
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
COARSE = (60, 7)
"""Hip positions and pitches of the first grid on which the least cost is looked for."""
FINER = 7
HALVINGS = 14
"""Points along each axis of the grids that follow about the best point, each with half the spacing,
and how many there are: hips are found to 2e-6 m."""


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
        found: Floats = np.arctan2(self.sole[:, 2], self.sole[:, 0])
        return found


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
    legs = _Legs(pedal, height, expected, spread, ankles, others)
    ends = np.stack([x - FARTHEST_HIP, x - NEAREST_HIP], axis=1)
    pitches = np.stack([pedal.flattest, pedal.steepest], axis=1)
    return _least(legs, ends, pitches)[0]


def pitches_at(sole: Sole, hips: Floats, ankles: Floats) -> Floats:
    """Find the pitch (B,) [rad] at which ankles come nearest to what is wanted (B,) [rad], with the
    hips (B, 3) [m] where they are."""
    nothing = np.zeros((len(hips), 2))
    legs = _Legs(sole, hips[:, 2], nothing, np.full_like(nothing, np.inf), ankles)
    ends = np.repeat(hips[:, :1], 2, axis=1)
    pitches = np.stack([sole.flattest, sole.steepest], axis=1)
    return _least(legs, ends, pitches)[1]


@dataclass(frozen=True, eq=False)
class _Legs:
    """Legs of B drivers in upright planes: soles, heights (B,) [m] of hips, the angles (B, 2) [rad]
    of thigh and knee that are expected with their scatter, and of ankles (B,) [rad]; and the soles
    of other feet, whose legs must be long enough."""

    sole: Sole
    height: Floats
    mean: Floats
    spread: Floats
    ankle: Floats
    others: Sequence[Sole] = ()

    def cost(self, hips: Floats, pitch: Floats) -> Floats:
        """(B, ...) squares of the residuals in units of their scatter, the hips at x (B, ...) [m],
        soles of a pitch (B, ...) [rad]."""
        shape = (-1, *(1,) * (hips.ndim - 1))
        thigh, shank = (length.reshape(shape) for length in _lengths(self.sole))
        turn = pitch - self.sole.own_pitch.reshape(shape)
        x, z = _ankles(self.sole, turn)
        rise = z - self.height.reshape(shape)
        leg = leg_triangle(thigh, shank, np.hypot(x - hips, rise))
        lifted = np.arctan2(rise, x - hips) + leg.hip
        plantarflexion = lifted + leg.knee - 0.5 * np.pi - turn
        found: Floats = OUT_OF_REACH * np.abs(leg.lack)
        found += ((plantarflexion - self.ankle.reshape(shape)) / ANKLE_SPREAD) ** 2
        for other in self.others:
            found += OUT_OF_REACH * np.maximum(_lack(other, hips, self.height), 0.0)
        for k, angle in enumerate((lifted, leg.knee)):
            off = angle - self.mean[:, k].reshape(shape)
            found += (off / self.spread[:, k].reshape(shape)) ** 2
        return found


def _lengths(sole: Sole) -> tuple[Floats, Floats]:
    """(B,) [m] lengths of thighs and shanks."""
    link = sole.link
    thigh = np.linalg.norm(link.at_child[:, 0] - link.at_parent[:, 1], axis=1)
    shank = np.linalg.norm(link.at_child[:, 1] - link.at_parent[:, 2], axis=1)
    return thigh, shank


def _ankles(sole: Sole, turn: Floats) -> tuple[Floats, Floats]:
    """(B, ...) x and z [m] of the ankles of feet that are turned up by so much [rad]."""
    own = (
        sole.link.at_child[:, 2] - sole.link.tip
    )  # from the ball to the ankle, in the foot's frame
    shape = (-1, *(1,) * (turn.ndim - 1))
    forth, above = (own[:, k].reshape(shape) for k in (0, 2))
    x, z = (sole.at[:, k].reshape(shape) for k in (0, 2))
    c = np.cos(turn)
    s = np.sin(turn)
    return x + c * forth - s * above, z + s * forth + c * above


def _lack(sole: Sole, hips: Floats, height: Floats) -> Floats:
    """(B, ...) [m] by how much legs are too short for soles in the plane of their pedal."""
    shape = (-1, *(1,) * (hips.ndim - 1))
    x, z = _ankles(sole, sole.steepest - sole.own_pitch)
    thigh, shank = _lengths(sole)
    distance = np.hypot(x.reshape(shape) - hips, (z - height).reshape(shape))
    found: Floats = distance - STRETCHED * (thigh + shank).reshape(shape)
    return found


def _least(legs: _Legs, hips: Floats, pitches: Floats) -> tuple[Floats, Floats]:
    """Where the cost is least: x (B,) [m] of the hips and pitch (B,) [rad], each between two ends
    (B, 2). A grid over all, then finer and finer ones about the best point."""
    everybody = np.arange(len(hips))
    middle = [ends.mean(axis=1) for ends in (hips, pitches)]
    half = [0.5 * (ends[:, 1] - ends[:, 0]) for ends in (hips, pitches)]
    for round_ in range(1 + HALVINGS):
        counts = COARSE if round_ == 0 else (FINER, FINER)
        counts = (1 if not half[0].any() else counts[0], counts[1])
        grid = [
            np.clip(
                at[:, None] + size[:, None] * np.linspace(-1.0, 1.0, count), *ends.T[:, :, None]
            )
            for at, size, count, ends in zip(middle, half, counts, (hips, pitches), strict=True)
        ]
        cost = legs.cost(grid[0][:, :, None], grid[1][:, None])
        best = cost.reshape(len(cost), -1).argmin(axis=1)
        rows, columns = np.divmod(best, counts[1])
        middle = [grid[0][everybody, rows], grid[1][everybody, columns]]
        # the next grid reaches one and a half spacings to either side, so it has half the spacing
        half = [3.0 * size / max(count - 1, 1) for size, count in zip(half, counts, strict=True)]
    return middle[0], middle[1]
