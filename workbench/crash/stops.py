"""Compute the moments of joint stops in a dynamic simulation.

A stop is a soft, progressive spring with dissipation. Its moment grows with the angle beyond the
stop, and it returns little of the energy that it takes.
"""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.stops import StopKind, Stops
from workbench.posture.kernels.past_stops import StopPack, past_stops

__all__ = ["STOP_SOFTNESS", "packed_stops", "stop_moments"]

STOP_SOFTNESS = 0.1
"""Angle [rad] beyond its stop at which a joint meets its reference moment."""
_MAX_STEEPENING = 5.0
"""Angle beyond the stop, in units of STOP_SOFTNESS, from which on the stiffness grows no more."""
_DAMPING_RATE = 15.0
"""Rate [rad/s] at which dissipation doubles an outgoing joint's moment and cancels a returning
joint's one."""


def stop_moments(pack: StopPack, rotations: Floats, rates: Floats, moment: Floats) -> Floats:
    """Compute the moments that push joints back from beyond their stops.

    Parameters
    ----------
    pack
        Joint stops of the body, see `packed_stops`.
    rotations
        (J, 4) joint rotations, unit quaternions.
    rates
        (J, 3) angular velocities [rad/s] of the distal segments, in their frames.
    moment
        (J,) reference moments [Nm], at an angle of STOP_SOFTNESS beyond the stop.

    Returns
    -------
    Floats
        (J, 3) [Nm] on the distal segments, in their frames.

    References
    ----------
    Hunt, K. H. & Crossley, F. R. E. (1975), Coefficient of restitution interpreted as damping in
    vibroimpact, Journal of Applied Mechanics 42, 440-445: damping in proportion to the elastic
    force.
    """
    joints = len(rotations)
    past = np.empty((joints, 3))  # rotation vector from the stop to the joint, zero within it
    past_stops(rotations, pack, np.empty((joints, 3)), np.empty((joints, 3, 2)), past)
    angle = np.linalg.norm(past, axis=1)
    outward_rate = np.sum(past * rates, axis=1) / np.maximum(angle, 1e-12)
    # elastic moment M(u) = M0 (u + u^3) / 2 with u = angle / STOP_SOFTNESS, here as stiffness M / angle
    u = np.minimum(angle / STOP_SOFTNESS, _MAX_STEEPENING)
    stiffness = moment * (1.0 + u**2) / (2.0 * STOP_SOFTNESS)
    # Hunt and Crossley: M (1 + rate / rate0), which neither pulls nor more than doubles
    dissipation = np.clip(1.0 + outward_rate / _DAMPING_RATE, 0.0, 2.0)
    return np.asarray(-(stiffness * dissipation)[:, None] * past)


def packed_stops(body: Body) -> StopPack:
    """Pack the joint stops of a body as the arrays that the kernel `past_stops` reads."""
    stops = body.stops
    couplings = [
        [c.joint, c.axis, c.side, c.driver_joint, c.driver_axis, *c.driver_angle, *c.limit]
        for c in stops.couplings
    ]
    sides, corners = _polygons(stops)
    return StopPack(
        kind=stops.kind,
        axes=stops.axes,
        limits=stops.limits,
        play=stops.play,
        coupling=np.array(couplings, dtype=np.float64).reshape(-1, 9),
        sides=sides,
        corners=corners,
        limb=stops.limb,
        before=_joints_before(body),
    )


def _polygons(stops: Stops) -> tuple[Floats, Ints]:
    """Sides (J, V, 5, 3) and numbers of corners (J,) of the spherical polygons; 0 for others."""
    joints = len(stops.kind)
    polygonal = np.flatnonzero(stops.kind == StopKind.POLYGON)
    most = max((len(stops.polygon[j]) for j in polygonal), default=1)
    sides = np.zeros((joints, most, 5, 3))
    corners = np.zeros(joints, dtype=np.int64)
    for j in polygonal:
        corners[j] = len(stops.polygon[j])
        sides[j, : corners[j]] = _sides(stops.polygon[j], stops.polygon_centre[j])
    return sides, corners


def _joints_before(body: Body) -> Ints:
    """(J, B) joints from a polygon's frame to its joint, padded with -1; none for other kinds."""
    chains = [
        _chain_before(body, j) if body.stops.kind[j] == StopKind.POLYGON else []
        for j in range(len(body.joints))
    ]
    longest = max((len(chain) for chain in chains), default=0)
    padded = [chain + [-1] * (longest - len(chain)) for chain in chains]
    return np.array(padded, dtype=np.int64).reshape(len(chains), longest)


def _chain_before(body: Body, joint: int) -> list[int]:
    """The joints from the frame of a joint's polygon to the joint, without itself."""
    segment = int(body.parent[joint + 1])
    chain = list[int]()
    while segment != body.stops.polygon_frame[joint]:
        chain.insert(0, segment - 1)
        segment = int(body.parent[segment])
    return chain


def _sides(corner: Floats, centre: Floats) -> Floats:
    """(V, 5, 3) sides of a spherical polygon with corners (V, 3) about a centre (3,).

    A side has its first corner, its inward normal, the normals of its two ends, and the normal of
    the plane through centre and corner.
    """
    following = np.roll(corner, -1, axis=0)
    inward = np.cross(corner, following)
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    spoke = np.cross(centre, corner)
    return np.stack(
        [corner, inward, np.cross(inward, corner), np.cross(following, inward), spoke], axis=1
    )
