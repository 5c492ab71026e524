"""A body into a seat: translated until it rests on cushion and back with the stated depth, on the
seat's centre line.

The pelvis leans with the seat back; the translation solves three plane equations at once: the
lowest sphere toward the cushion plane, the rearmost toward the back plane, the reference segment on
the centre line.
"""

from __future__ import annotations

import numpy as np

from workbench.body.forward import place
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.environment import Rest, Seat
from workbench.model.poses import Placed, Poses
from workbench.model.posing import attitude_matrix

__all__ = ["seat_attitude", "seat_body", "seat_planes"]


def seat_planes(seat: Seat) -> tuple[Floats, Floats, Floats]:
    """Unit normals (3,) of cushion (up), back (forward) and centre plane (left) of a seat, all
    through its SRP."""
    heading = attitude_matrix(yaw=seat.yaw)
    cushion = np.array([-np.sin(seat.cushion_angle), 0.0, np.cos(seat.cushion_angle)])
    back = np.array([np.cos(seat.back_angle), 0.0, np.sin(seat.back_angle)])
    return heading @ cushion, heading @ back, heading @ np.array([0.0, 1.0, 0.0])


def seat_attitude(seat: Seat) -> Floats:
    """(3, 3) attitude of the reference segment of a sitter: the seat's heading, leaning with the
    seat back."""
    return attitude_matrix(yaw=seat.yaw, pitch=-seat.back_angle)


def seat_body(body: Body, poses: Poses, seat: Seat, *, srp: Floats | None = None) -> Poses:
    """The same poses, moved into the seat (their attitude stays).

    srp (3,) [m]: the adjusted seat reference point, the seat's own where None. InputError where the
    seat's cushion or back names no segment with spheres of this body.
    """
    placed = place(body, poses)
    point = np.array(seat.srp) if srp is None else srp
    cushion, back, centre = seat_planes(seat)
    low = _support(placed, cushion, seat.cushion) - cushion @ point
    rear = _support(placed, back, seat.back) - back @ point
    aside = poses.world_from_reference[:, :, 3] @ centre - centre @ point
    wanted = np.stack([-seat.cushion.depth - low, -seat.back.depth - rear, -aside], axis=1)
    shift = np.linalg.solve(np.stack([cushion, back, centre]), wanted.T).T
    world = poses.world_from_reference.copy()
    world[:, :, 3] += shift
    return Poses(poses.rotations, poses.reference, world, poses.time)


def _support(placed: Placed, normal: Floats, rest: Rest) -> Floats:
    """(P,) least height along a normal of the spheres of the segments that rest there."""
    body = placed.body
    names = body.segments if "all" in rest.segments else rest.segments
    wanted = np.flatnonzero(
        np.isin(body.sphere_segment, [body.segments.index(n) for n in names if n in body.segments])
    )
    if not len(wanted):
        raise InputError(
            f"body {body.name} has no spheres in {list(rest.segments)}, which rest on {rest.part!r}"
        )
    heights: Floats = (
        placed.centres[:, wanted] @ normal - body.radius[placed.person[:, None], wanted]
    )
    lowest: Floats = heights.min(axis=1)
    return lowest
