"""A sitter's posture: the seat where it gives the view and the pedals, feet on pedals with the heels on the floor.

The order is that of cockpit assessments (Zehner & Kennedy's): the lowest seat that still brings the eyes to the
height asked for, then fore and aft where both feet reach their pedals most comfortably. What the seat cannot give is
told, not hidden: eyes stay below, feet stop short.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.environment import Seat
from workbench.model.poses import Placed, Poses
from workbench.solve.forward import place
from workbench.solve.limbs import Limb, limb
from workbench.solve.reach import reach
from workbench.solve.seating import seat_attitude, seat_body, seat_planes

__all__ = ["Pedals", "SeatedPosture", "eye_points", "feet_on", "pointed_foot", "positions", "seat_posture"]

STEP = 0.01
"""Spacing [m] of the seat positions that are tried."""
SETTLING = 3
"""Rounds of seating and reaching: the thighs that the pedals lift change how the sitter rests on the cushion."""
SHORT = 1e-3


@dataclass(frozen=True)
class Pedals:
    """Where the balls of the feet go [m], by "left foot" and "right foot", and the height [m] of the floor that the
    heels stand on, None where they stand on nothing."""

    at: Mapping[str, tuple[float, float, float]]
    floor: float | None = None


@dataclass(frozen=True, eq=False)
class SeatedPosture:
    """P seated postures: poses in the world, the seat's `forward` and `up` (P,) [m], eye (P, 3) [m], and for each foot
    by how much it misses its pedal (P,) [m] and what limits it."""

    poses: Poses
    forward: Floats
    up: Floats
    eye: Floats
    miss: Mapping[str, Floats]
    limit: Mapping[str, tuple[str, ...]]
    discomfort: Floats


def eye_points(placed: Placed) -> Floats:
    """(P, 3) [m] the point midway between the two eyes. InputError where the body has no spheres of that name."""
    names = placed.body.sphere_names
    if "left eye" not in names or "right eye" not in names:
        raise InputError(f"body {placed.body.name} has no spheres 'left eye' and 'right eye'")
    middle: Floats = 0.5 * (placed.centres[:, names.index("left eye")] + placed.centres[:, names.index("right eye")])
    return middle


def seat_posture(body: Body, poses: Poses, seat: Seat, *, eye: float | None, pedals: Pedals) -> SeatedPosture:
    """The seat position and posture (P = 1) of a sitter whose trunk, head and arms are as in `poses` (P = 1).

    eye: the height [m] that the eyes are to reach, any where None. The seat stays within its travel.
    """
    forward = positions(seat.travel_forward)
    up = np.full(len(forward), min(max(0.0, seat.travel_up[0]), seat.travel_up[1]))
    every = Poses(np.repeat(poses.rotations, len(forward), axis=0), poses.reference,
                  np.repeat(poses.world_from_reference, len(forward), axis=0))  # fmt: skip
    found = feet_on(body, every, seat, (forward, up), pedals)
    for _ in range(4 if eye is not None else 0):
        up = np.clip(up + eye - found.eye[:, 2], *seat.travel_up)
        found = feet_on(body, found.poses, seat, (forward, up), pedals)
    missed = np.sum([np.where(m > SHORT, m, 0.0) for m in found.miss.values()], axis=0) * np.ones(len(forward))
    # whoever misses by the same amount everywhere sits nearest to where the seat stands
    order = np.lexsort((np.abs(forward), found.discomfort.round(3), missed.round(4)))
    return _row(found, int(order[0]))


def feet_on(body: Body, poses: Poses, seat: Seat, travel: tuple[Floats, Floats], pedals: Pedals) -> SeatedPosture:
    """Sitters (P) with the seat at these positions (forward (P,), up (P,)) [m], feet on the pedals."""
    centre = seat_planes(seat)[2]
    ahead = np.array([centre[1], -centre[0], 0.0])
    shift = travel[0][:, None] * ahead + travel[1][:, None] * np.array([0.0, 0.0, 1.0])
    miss: dict[str, Floats] = {}
    limit: dict[str, tuple[str, ...]] = {}
    seated, total = _seated(body, poses, seat, shift), np.zeros(len(poses))
    for _ in range(SETTLING):
        total = np.zeros(len(poses))
        for foot, at in pedals.at.items():
            seated, miss[foot], limit[foot], ease = _foot(body, seated, (foot, at, ahead), pedals.floor)
            total = total + ease
        seated = _seated(body, seated, seat, shift)
    eye = eye_points(place(body, seated, window=["H"])) if "H" in body.segments else np.full((len(poses), 3), np.nan)
    return SeatedPosture(seated, travel[0], travel[1], eye, miss, limit, total)


def positions(travel: tuple[float, float]) -> Floats:
    """Positions from the rear to the front of a travel, its ends and zero among them."""
    low, high = travel
    grid = np.arange(np.ceil(low / STEP), np.floor(high / STEP) + 1) * STEP
    positions: Floats = np.unique(np.round(np.concatenate([[low, 0.0, high], grid]), 9))
    return positions


def _seated(body: Body, poses: Poses, seat: Seat, shift: Floats) -> Poses:
    """The poses in the seat; a seat that has gone along its travel takes the sitter with it."""
    world = poses.world_from_reference.copy()
    world[:, :, :3] = seat_attitude(seat)
    seated = seat_body(body, Poses(poses.rotations, poses.reference, world), seat)
    world = seated.world_from_reference.copy()
    world[:, :, 3] += shift
    return Poses(poses.rotations, poses.reference, world)


def _foot(
    body: Body, poses: Poses, pedal: tuple[str, tuple[float, float, float], Floats], floor: float | None
) -> tuple[Poses, Floats, tuple[str, ...], Floats]:
    """Put one foot on its pedal, the heel on the floor where that can be; poses, misses, limits, discomfort."""
    name, at, ahead = pedal
    ball, heel = limb(body, name, grip="ball"), limb(body, name, grip="heel")
    sole = ball.tip - heel.tip
    targets = np.broadcast_to(np.array(at), (len(poses), 3))
    free = reach(body, poses, targets, limb=ball)
    if floor is None:
        return _kept(poses, free.poses), free.miss, tuple(free.limit(p) for p in range(len(poses))), free.discomfort
    rise = float(np.clip((at[2] - floor) / np.linalg.norm(sole), -0.95, 0.95))
    along = np.sqrt(1.0 - rise * rise) * ahead + rise * np.array([0.0, 0.0, 1.0])
    pointed = pointed_foot(body, name)
    heeled = reach(body, poses, targets, limb=pointed, direction=along)
    both = heeled.reached
    merged = np.where(both[:, None, None], heeled.poses.rotations, free.poses.rotations)
    chosen = Poses(merged, free.poses.reference, free.poses.world_from_reference)
    words = tuple("" if both[p] else free.limit(p) for p in range(len(poses)))
    # a heel in the air is put up with where the pedal cannot be had otherwise
    ease = np.where(both, heeled.discomfort, free.discomfort + 10.0)
    return _kept(poses, chosen), np.where(both, heeled.miss, free.miss), words, ease


@lru_cache(maxsize=64)
def pointed_foot(body: Body, name: str) -> Limb:
    """The foot that arrives by its ball, pointing from the heel to the ball."""
    ball, heel = limb(body, name, grip="ball"), limb(body, name, grip="heel")
    sole = ball.tip - heel.tip
    return replace(ball, pointing=sole / np.linalg.norm(sole))


def _kept(poses: Poses, found: Poses) -> Poses:
    """The found rotations, placed by the segment that the poses are placed by."""
    return Poses(found.rotations, poses.reference, poses.world_from_reference)


def _row(found: SeatedPosture, row: int) -> SeatedPosture:
    one = slice(row, row + 1)
    poses = Poses(found.poses.rotations[one], found.poses.reference, found.poses.world_from_reference[one])
    miss = {foot: value[one] for foot, value in found.miss.items()}
    limit = {foot: value[one] for foot, value in found.limit.items()}
    return SeatedPosture(poses, found.forward[one], found.up[one], found.eye[one], miss, limit, found.discomfort[one])
