"""Legs of a driver: soles from floor to pedal, and the hip position that suits thigh, knee and
ankle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.driving import Package
from workbench.model.posing import motion_of
from workbench.posture.kernels.linkage import Linkage
from workbench.posture.reaching.comfort import comfort_modes
from workbench.posture.reaching.limbs import Limb, limb
from workbench.posture.reaching.packing import packed_links
from workbench.posture.seating.leg_triangle import leg_triangle
from workbench.posture.seating.posture import pointed_foot

__all__ = [
    "Sole",
    "accelerator_foot",
    "ankles_wanted",
    "hips_from_pedal",
    "pitches_at",
    "sole_at",
    "soles_on",
]

ALIKE = 1e-3
"""Distances [m] of two feet from the accelerator that differ by less are alike."""

NEAREST_HIP = 0.15
FARTHEST_HIP = 1.3
"""How far aft of the ball of the foot [m] hips are searched."""
OUT_OF_REACH = 1e3
"""Cost [1/m] of an ankle that the leg does not reach. It outweighs every angle."""
THIGH = 6
KNEE = 7
"""Indices of thigh and knee among the angles of a driving posture."""
ANKLE_SPREAD = np.radians(10.0)
"""Standard deviation of drivers' ankles [rad]. The ranges that were observed, taken from the 5th to
the 95th percentile, give 8.5 degrees (Wolf 2022, 85 to 113), 10 (Porter & Gyi 1998, 80 to 113) and
12.8 (Park 2000, 82 to 124)."""
WIDER = np.sqrt(1.5)
"""How much farther from their means thigh and knee are expected than they were drawn. Published is
the scatter of angles that people show. Three angles that are drawn independently do not go
together, as a leg has two freedoms: where the hips are, and the pitch of the foot. Least squares
leave of three units of variance two."""
FLATTER = np.radians(20.0)
"""How much flatter [rad] than its pedal a sole may lie, at most: its heel is then farther aft."""
SLIDE = 0.05
"""How far [m] the ball of the foot may be farther down its pedal for that, at most."""
COARSE = (60, 7)
"""Hip positions and pitches of the first grid on which the least cost is looked for."""
FINER = 7
HALVINGS = 14
"""Points along each axis of the grids that follow about the best point, each with half the spacing,
and how many there are: hips are found to 2e-6 m."""


@dataclass(frozen=True, eq=False)
class Sole:
    """Soles of B drivers' feet, from the floor to their pedal."""

    start: Floats
    """(3,) [m] where the plane of the pedal rises from the floor."""
    slope: float
    """[rad] of the plane above the horizontal: the steepest that a sole lies."""
    flattest: Floats
    """(B,) [rad] the least pitch of the soles."""
    round: Floats
    """(B,) [m] radius of the round of the heel."""
    under: Floats
    """(B,) [m] how thick the sole of the shoe is under the foot's own."""
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
    """Place the sole of a foot between the floor and the plane from the heel point to the pedal.

    For the foot that is not on the accelerator the plane starts beside the heel point. The round of
    the heel rests on the floor, and the ball touches the plane. A sole lies in the plane, then its
    heel is in the corner of floor and plane, or flatter: see `FLATTER` and `SLIDE`. The sole of a
    shoe lies under the foot's own.

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
    """
    chain = pointed_foot(body, foot)
    link = packed_links(body, chain)
    heel = limb(body, foot, grip="heel")
    ball = link.tip
    back = heel.tip
    start = np.array([package.heel[0], at[1], package.heel[2]])
    rise = np.array(at) - start
    slope = float(np.arctan2(rise[2], rise[0]))
    spheres = body.spheres(heel.end)
    row = int(spheres.start) + body.sphere_names[spheres].index("heel")
    lowest = (body.centre[:, spheres, 2] - body.radius[:, spheres]).min(axis=1)
    under = np.maximum(np.minimum(ball[:, 2], back[:, 2]) - lowest, 0.0)
    sole = Sole(
        start=start,
        slope=slope,
        flattest=np.full(len(body), slope),
        round=body.radius[:, row],
        under=under,
        limb=chain,
        link=link,
        sole=ball - back,
    )
    return replace(sole, flattest=_flattest(sole))


def _flattest(sole: Sole) -> Floats:
    """(B,) [rad] the least pitch of the soles: `FLATTER` than the plane, the floor at the flattest,
    with the balls no more than `SLIDE` farther down it."""
    least = min(sole.slope, max(sole.slope - FLATTER, 0.0))
    pitches = np.linspace(sole.slope, least, 31)[None] * np.ones((len(sole.round), 1))
    x, z = _balls(sole, pitches)
    down = np.hypot(x - x[:, :1], z - z[:, :1])
    allowed = (down <= SLIDE).sum(axis=1) - 1
    found: Floats = pitches[np.arange(len(pitches)), allowed]
    return found


def _balls(sole: Sole, pitch: Floats) -> tuple[Floats, Floats]:
    """(B, ...) x and z [m] of the balls of feet whose soles have a pitch (B, ...) [rad].

    The middle of the heel's round stands at the height r + u over the floor, r its radius, u the
    thickness of the shoe's sole. From there the ball lies r below, square to the sole of length L,
    and L along it: z = r + u - r cos(p) + L sin(p). Of a sole in the plane, of slope s, it lies
    (r + u) tan(s / 2) + L up the plane and u off it. Of a flatter one it lies lower, as far off.
    """
    shape = (-1, *(1,) * (pitch.ndim - 1))
    r = sole.round.reshape(shape)
    u = sole.under.reshape(shape)
    length = np.linalg.norm(sole.sole, axis=1).reshape(shape)
    s = sole.slope
    lower = r * (np.cos(s) - np.cos(pitch)) + length * (np.sin(pitch) - np.sin(s))
    up = (r + u) * np.tan(0.5 * s) + length
    z = up * np.sin(s) + u * np.cos(s) + lower
    x = up * np.cos(s) - u * np.sin(s) + lower / max(np.tan(s), 1e-9)  # lower is 0 on a level plane
    return sole.start[0] + x, sole.start[2] + z


def sole_at(sole: Sole, pitch: Floats) -> tuple[Floats, Floats]:
    """Balls of the feet (B, 3) [m] and unit directions (B, 3) from heel to ball of soles of a pitch
    (B,) [rad]."""
    x, z = _balls(sole, pitch)
    at = np.stack([x, np.full(len(x), sole.start[1]), z], axis=1)
    along = np.stack([np.cos(pitch), np.zeros(len(x)), np.sin(pitch)], axis=1)
    return np.ascontiguousarray(at), along


def ankles_wanted(body: Body, foot: str, seed: int | None, numbers: Sequence[int]) -> Floats:
    """Return the plantarflexion (B,) [rad] that drivers want of an ankle.

    Parameters
    ----------
    seed
        The angles are drawn about the mode of comfort, by the numbers (B,) of the drivers; the mode
        if None.
    """
    joint = limb(body, foot, grip="ball").free[-1]
    axis, sign = motion_of(body, joint, "plantarflexion")
    mode, _ = comfort_modes(body, joint)
    wanted = np.full(len(body), sign * mode[axis])
    if seed is None:
        return wanted
    wanted += ANKLE_SPREAD * np.array([_residual(seed, number) for number in numbers])
    return wanted


@lru_cache(maxsize=1 << 14)
def _residual(seed: int, number: int) -> float:
    """An ankle's residual in units of its scatter: of a stream beside that of the other angles, which
    stay as they are."""
    source = np.random.SeedSequence(seed, spawn_key=(number, 1))
    return float(np.random.Generator(np.random.PCG64(source)).standard_normal())


def hips_from_pedal(
    pedal: Sole, height: Floats, angles: tuple[Floats, Floats, Floats], ankles: Floats
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

    Returns
    -------
    Floats
        (B,) x [m] of the hips.
    """
    mean, drawn, spread = (some[:, [THIGH, KNEE]] for some in angles)
    expected = mean + WIDER * (drawn - mean)
    steepest = np.full(len(height), pedal.slope)
    x, _ = _balls(pedal, steepest)
    legs = _Legs(pedal, height, expected, spread, ankles)
    ends = np.stack([x - FARTHEST_HIP, x - NEAREST_HIP], axis=1)
    pitches = np.stack([pedal.flattest, steepest], axis=1)
    return _least(legs, ends, pitches)[0]


def pitches_at(sole: Sole, hips: Floats, ankles: Floats) -> Floats:
    """Find the pitch (B,) [rad] at which ankles come nearest to what is wanted (B,) [rad], with the
    hips (B, 3) [m] where they are."""
    nothing = np.zeros((len(hips), 2))
    legs = _Legs(sole, hips[:, 2], nothing, np.full_like(nothing, np.inf), ankles)
    ends = np.repeat(hips[:, :1], 2, axis=1)
    pitches = np.stack([sole.flattest, np.full(len(hips), sole.slope)], axis=1)
    return _least(legs, ends, pitches)[1]


@dataclass(frozen=True, eq=False)
class _Legs:
    """Legs of B drivers in upright planes: soles, heights (B,) [m] of hips, the angles (B, 2) [rad]
    of thigh and knee that are expected with their scatter, and of ankles (B,) [rad]."""

    sole: Sole
    height: Floats
    mean: Floats
    spread: Floats
    ankle: Floats

    def cost(self, hips: Floats, pitch: Floats) -> Floats:
        """(B, ...) squares of the residuals in units of their scatter, the hips at x (B, ...) [m],
        soles of a pitch (B, ...) [rad]."""
        link = self.sole.link
        shape = (-1, *(1,) * (hips.ndim - 1))
        thigh = np.linalg.norm(link.at_child[:, 0] - link.at_parent[:, 1], axis=1).reshape(shape)
        shank = np.linalg.norm(link.at_child[:, 1] - link.at_parent[:, 2], axis=1).reshape(shape)
        turn = pitch - self.sole.own_pitch.reshape(shape)
        x, z = self._ankles(pitch, turn)
        rise = z - self.height.reshape(shape)
        leg = leg_triangle(thigh, shank, np.hypot(x - hips, rise))
        lifted = np.arctan2(rise, x - hips) + leg.hip
        plantarflexion = lifted + leg.knee - 0.5 * np.pi - turn
        found: Floats = OUT_OF_REACH * np.abs(leg.lack)
        found += ((plantarflexion - self.ankle.reshape(shape)) / ANKLE_SPREAD) ** 2
        for k, angle in enumerate((lifted, leg.knee)):
            off = angle - self.mean[:, k].reshape(shape)
            found += (off / self.spread[:, k].reshape(shape)) ** 2
        return found

    def _ankles(self, pitch: Floats, turn: Floats) -> tuple[Floats, Floats]:
        """(B, ...) x and z [m] of the ankles of feet that are turned up by so much [rad]."""
        link = self.sole.link
        own = link.at_child[:, 2] - link.tip  # from the ball to the ankle, in the foot's frame
        forth = own[:, 0].reshape(-1, *(1,) * (pitch.ndim - 1))
        above = own[:, 2].reshape(forth.shape)
        x, z = _balls(self.sole, pitch)
        c = np.cos(turn)
        s = np.sin(turn)
        return x + c * forth - s * above, z + s * forth + c * above


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
