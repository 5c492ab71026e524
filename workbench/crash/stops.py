"""Joint stops as moments: soft, stiffer the farther, and giving back little of what they take."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.stops import StopKind
from workbench.posture.kernels.past_stops import StopPack, past_stops

__all__ = ["STOP_SOFTNESS", "packed_stops", "stop_moments"]

STOP_SOFTNESS = 0.1
"""[rad] How far past its stop a joint goes under the moment stated for it."""
_STEEPEST = 5.0
_RATE = 15.0
"""[rad/s] A stop pushes back twice as hard where the joint runs out at this rate, and not at all
where it comes back at it (Hunt & Crossley 1975)."""


def stop_moments(pack: StopPack, rotations: Floats, rates: Floats, moment: Floats) -> Floats:
    """(J, 3) [Nm] on the distal segments, in their frames, of rotations (J, 4) and rates (J, 3)
    [rad/s] in the same frames. A joint x past its stop is pushed back by moment (u + u^3) / 2 with
    u = x / STOP_SOFTNESS, moment (J,) [Nm] being that at u = 1."""
    joints = len(rotations)
    past = np.empty((joints, 3))
    past_stops(rotations, pack, np.empty((joints, 3)), np.empty((joints, 3, 2)), past)
    angle = np.linalg.norm(past, axis=1)
    outward = np.sum(past * rates, axis=1) / np.maximum(angle, 1e-12)
    stiffness = (
        moment * (1.0 + np.minimum(angle / STOP_SOFTNESS, _STEEPEST) ** 2) / (2.0 * STOP_SOFTNESS)
    )
    held: Floats = -(stiffness * np.clip(1.0 + outward / _RATE, 0.0, 2.0))[:, None] * past
    return held


def packed_stops(body: Body) -> StopPack:
    """The stops of a body for the kernel."""
    stops = body.stops
    joints = len(body.joints)
    rows = [
        [c.joint, c.axis, c.side, c.driver_joint, c.driver_axis, *c.driver_angle, *c.limit]
        for c in stops.couplings
    ]
    shaped = np.flatnonzero(stops.kind == StopKind.POLYGON)
    most = max((len(stops.polygon[j]) for j in shaped), default=1)
    sides = np.zeros((joints, most, 5, 3))
    count = np.zeros(joints, dtype=np.int64)
    for j in shaped:
        count[j] = len(stops.polygon[j])
        sides[j, : count[j]] = _sides(stops.polygon[j], stops.polygon_centre[j])
    before = [_before(body, int(j)) if j in shaped else [] for j in range(joints)]
    deep = max((len(row) for row in before), default=0)
    chain: Ints = np.array(
        [row + [-1] * (deep - len(row)) for row in before], dtype=np.int64
    ).reshape(joints, deep)
    return StopPack(
        stops.kind,
        stops.axes,
        stops.limits,
        stops.play,
        np.array(rows, dtype=np.float64).reshape(-1, 9),
        sides,
        count,
        stops.limb,
        chain,
    )


def _before(body: Body, joint: int) -> list[int]:
    """The joints from the frame of a joint's polygon to the joint, without itself."""
    at = int(body.parent[joint + 1])
    found = list[int]()
    while at != body.stops.polygon_frame[joint]:
        found.insert(0, at - 1)
        at = int(body.parent[at])
    return found


def _sides(corner: Floats, centre: Floats) -> Floats:
    following = np.roll(corner, -1, axis=0)
    inward = np.cross(corner, following)
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    spoke = np.cross(centre, corner)
    return np.stack(
        [corner, inward, np.cross(inward, corner), np.cross(following, inward), spoke], axis=1
    )
