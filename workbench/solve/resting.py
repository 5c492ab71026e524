"""What rests on a seat, of many bodies at once: heights that do not change with the legs, packed for the kernel."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from workbench.errors import InputError
from workbench.kernels.limb_contacts import least_heights
from workbench.kernels.sitting import Sitting
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.environment import Rest, Seat
from workbench.model.poses import Poses
from workbench.solve.family import Family, frames, packed_limbs
from workbench.solve.limbs import Limb
from workbench.solve.seating import seat_attitude, seat_planes

__all__ = ["at_rest", "eyes_over", "lap_frames", "sitting_of"]


def lap_frames(family: Family, poses: Poses, seat: Seat, lap: int) -> Floats:
    """(B, 3, 4) where the segment `lap` stands when the segment that the poses are placed by stands at the origin,
    leaning with the seat's back."""
    world = np.zeros((len(poses), 3, 4))
    world[:, :, :3] = seat_attitude(seat)
    return frames(family, Poses(poses.rotations, poses.reference, world), lap)


def sitting_of(family: Family, poses: Poses, seat: Seat, eye: float | None, lap: tuple[int, Floats]) -> Sitting:
    """How bodies sit on a seat; lap: the segment that the legs hang on, and its frames as of `lap_frames`.

    InputError where no segment with spheres rests there, and where eyes are asked for that a body does not have.
    """
    body, (segment, lean) = family.bodies[0], lap
    cushion, back, centre = seat_planes(seat)
    ways, counts = np.stack([cushion, back]), np.stack([_resting(body, rest) for rest in (seat.cushion, seat.back)])
    moving = counts.any(axis=0) & _by_legs(body, segment)
    still = counts.any(axis=0) & ~moving
    at_origin = lean.copy()
    at_origin[:, :, 3] = 0.0
    fixed = np.full((len(family), 2), np.inf)
    if still.any():
        limbs = packed_limbs(family, _rests(body, segment, tuple(np.flatnonzero(still).tolist())))
        who, turns = np.arange(len(family)), np.array(poses.rotations)
        least_heights(limbs, who, turns, at_origin, (ways, counts), fixed, 0, len(family))
    point, depth = np.array(seat.srp), np.array([seat.cushion.depth, seat.back.depth])
    level = np.concatenate([np.repeat((ways @ point - depth)[None], len(family), axis=0),
                            (centre @ point + lean[:, :, 3] @ centre)[:, None]], axis=1)  # fmt: skip
    wanted = np.full(len(family), np.nan)
    if eye is not None:
        wanted = eye - eyes_over(family, poses, (segment, at_origin))[:, 2]
    segments = tuple(np.flatnonzero(moving).tolist()) or (segment,)
    return Sitting(
        limbs=packed_limbs(family, _rests(body, segment, segments)), counts=counts, ways=ways, fixed=fixed,
        lap=at_origin, level=level, solve=np.linalg.inv(np.stack([cushion, back, centre])),
        ahead=np.array([centre[1], -centre[0], 0.0]), rise=np.array(seat.travel_up, dtype=np.float64), eye=wanted,
    )  # fmt: skip


def at_rest(sitting: Sitting, rotations: Floats) -> tuple[Floats, Floats]:
    """Where the lap (B, 3) [m] comes to rest with the legs as they are, the seat not moved forward, and the seat's
    travel up (B,) [m] that brings the eyes to their height."""
    heights = np.zeros((len(rotations), 2))
    who = np.arange(len(rotations))
    least_heights(sitting.limbs, who, np.array(rotations), sitting.lap, (sitting.ways, sitting.counts), heights, 0, len(who))
    off = sitting.level.copy()
    off[:, :2] -= np.minimum(heights, sitting.fixed)
    at: Floats = off @ sitting.solve.T
    low, high = sitting.rise
    up = np.where(np.isnan(sitting.eye), min(max(0.0, low), high), np.clip(sitting.eye - at[:, 2], low, high))
    at[:, 2] += up
    return at, up


def eyes_over(family: Family, poses: Poses, lap: tuple[int, Floats], *, needed: bool = True) -> Floats:
    """(B, 3) [m] midway between the eyes, with the segment lap[0] in frames lap[1] (B, 3, 4); of bodies without eyes an
    InputError where they are needed, else NaN."""
    body = family.bodies[0]
    names = ("left eye", "right eye")
    if not all(name in body.sphere_names for name in names):
        if not needed:
            return np.full((len(family), 3), np.nan)
        raise InputError(f"body {body.name} has no spheres 'left eye' and 'right eye'")
    sphere = [body.sphere_names.index(name) for name in names]
    head = frames(family, Poses(poses.rotations, *lap), int(body.sphere_segment[sphere[0]]))
    found: Floats = np.einsum("bij,bj->bi", head[:, :, :3], family.centre[:, sphere].mean(axis=1)) + head[:, :, 3]
    return found


def _resting(body: Body, rest: Rest) -> Bools:
    """(N,) the segments that rest there. InputError where none of them has spheres."""
    names = body.segments if "all" in rest.segments else rest.segments
    found: Bools = np.isin(body.segments, names) & (np.diff(body.start) > 0)
    if not found.any():
        raise InputError(f"body {body.name} has no spheres in {list(rest.segments)}, which rest on {rest.part!r}")
    return found


def _by_legs(body: Body, lap: int) -> Bools:
    """(N,) the segments whose spheres move with the joints of the legs: legs, and what is blended with them."""
    legs = np.zeros(len(body.segments), dtype=np.bool_)
    for name in ("LUL", "RUL"):
        if name in body.segments:
            legs[body.segment(name)] = True
    for n in range(1, len(body.segments)):
        legs[n] |= legs[body.parent[n]]
    joint = legs[1:]  # a joint is that of the segment beyond it
    found = legs.copy()
    blended = (body.blend_joint >= 0) & joint[np.maximum(body.blend_joint, 0)]
    found[body.sphere_segment[blended]] = True
    return found


@lru_cache(maxsize=16)
def _rests(body: Body, base: int, segments: tuple[int, ...]) -> Limb:
    """Some segments that rest on a seat, as a limb without joints."""
    none = np.zeros(len(body.sphere_names), dtype=np.bool_)
    return Limb("what rests", base, base, (), np.zeros(3), np.zeros(3), segments, none)
