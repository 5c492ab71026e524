"""How far every joint of one pose is past its stop, as a turn to be taken back: fast enough for
each step of a simulation, where solve.stops gives exact margins of whole batches."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit
from workbench.posture.kernels.limits import nearest_side

__all__ = ["StopPack", "past_stops"]

_CONE = 1
_HINGE = 2
_POLYGON = 3
_LEAST = 1e-9


class StopPack(NamedTuple):
    """The stops of J joints: kind (J,), axes (J, 3, 3), limits (J, 3, 2), play (J,) as model.stops
    has them.

    coupling (M, 9): joint, axis, side, driver joint and axis, two driver angles, two limits. sides
    (J, V, 5, 3), corners (J,): the spherical polygons side by side (first corner, inward normal,
    normals of its ends, normal of the plane through centre and corner); limb (J, 3); before (J, B):
    joints from the polygon's frame to this one, -1 where there are none.
    """

    kind: NDArray[np.int64]
    axes: NDArray[np.float64]
    limits: NDArray[np.float64]
    play: NDArray[np.float64]
    coupling: NDArray[np.float64]
    sides: NDArray[np.float64]
    corners: NDArray[np.int64]
    limb: NDArray[np.float64]
    before: NDArray[np.int64]


@njit(cache=True)
def _turned(q, x, y, z):  # type: ignore[no-untyped-def]
    """A vector turned by a quaternion."""
    tx = 2 * (q[2] * z - q[3] * y)
    ty = 2 * (q[3] * x - q[1] * z)
    tz = 2 * (q[1] * y - q[2] * x)
    return (
        x + q[0] * tx + q[2] * tz - q[3] * ty,
        y + q[0] * ty + q[3] * tx - q[1] * tz,
        z + q[0] * tz + q[1] * ty - q[2] * tx,
    )


@njit(cache=True)
def _product(a, b):  # type: ignore[no-untyped-def]
    """The product of two quaternions: first b, then a."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@njit(cache=True)
def _angles(q, axes, out):  # type: ignore[no-untyped-def]
    """The two swing components and the twist of a rotation; returns the twist as a quaternion."""
    u = axes[2]
    along = q[1] * u[0] + q[2] * u[1] + q[3] * u[2]
    twist = 2.0 * math.atan2(along, q[0])
    twist -= 2 * math.pi * round(twist / (2 * math.pi))
    c = math.cos(0.5 * twist)
    s = math.sin(0.5 * twist)
    turn = (c, s * u[0], s * u[1], s * u[2])
    swing = _product(q, (c, -turn[1], -turn[2], -turn[3]))
    sign = -1.0 if swing[0] < 0 else 1.0
    sine = math.sqrt(swing[1] ** 2 + swing[2] ** 2 + swing[3] ** 2)
    scale = sign * (2.0 * math.atan2(sine, sign * swing[0]) / sine if sine > 1e-12 else 2.0)
    for k in range(2):
        out[k] = scale * (swing[1] * axes[k, 0] + swing[2] * axes[k, 1] + swing[3] * axes[k, 2])
    out[2] = twist
    return turn


@njit(cache=True)
def _beyond(value, first, second):  # type: ignore[no-untyped-def]
    """How far a value lies beyond first upward or second downward, with its sign."""
    return value - first if value > first else value + second if value < -second else 0.0


@njit(cache=True)
def _polygon(q, j, pack, rotations, out):  # type: ignore[no-untyped-def]
    """Add the turn, in the joint's distal frame, by which the limb is outside its spherical
    polygon."""
    before = (1.0, 0.0, 0.0, 0.0)
    for b in range(pack.before.shape[1]):
        if pack.before[j, b] >= 0:
            before = _product(before, rotations[pack.before[j, b]])
    whole = _product(before, q)
    d = _turned(whole, pack.limb[j, 0], pack.limb[j, 1], pack.limb[j, 2])
    p, _, inside = nearest_side(pack.sides[j, : pack.corners[j]], d)
    if inside:
        return
    cross = (p[1] * d[2] - p[2] * d[1], p[2] * d[0] - p[0] * d[2], p[0] * d[1] - p[1] * d[0])
    sine = math.sqrt(cross[0] ** 2 + cross[1] ** 2 + cross[2] ** 2)
    if sine < 1e-12:
        return
    scale = math.atan2(sine, p[0] * d[0] + p[1] * d[1] + p[2] * d[2]) / sine
    back = (whole[0], -whole[1], -whole[2], -whole[3])
    e = _turned(back, scale * cross[0], scale * cross[1], scale * cross[2])
    out[0] += e[0]
    out[1] += e[1]
    out[2] += e[2]


@njit(cache=True)
def past_stops(rotations, pack, angles, limits, past):  # type: ignore[no-untyped-def]
    """Fill angles (J, 3), limits (J, 3, 2) with couplings applied, and past (J, 3): the rotation
    vector [rad], in the distal segment's frame, from the nearest legal rotation (cones: along the
    ray from zero) to this one."""
    joints = pack.kind.shape[0]
    limits[:] = pack.limits
    for j in range(joints):
        _angles(rotations[j], pack.axes[j], angles[j])
    for m in range(pack.coupling.shape[0]):
        c = pack.coupling[m]
        driver = angles[int(c[3]), int(c[4])]
        share = min(max((driver - c[5]) / (c[6] - c[5]), 0.0), 1.0)
        limits[int(c[0]), int(c[1]), int(c[2])] = c[7] + share * (c[8] - c[7])
    for j in range(joints):
        past[j] = 0.0
        kind = pack.kind[j]
        if kind == 0:
            continue
        turn = _angles(rotations[j], pack.axes[j], angles[j])
        a, b, t = angles[j]
        slack = pack.play[j] if kind == _HINGE else 0.0
        da = 0.0
        db = 0.0
        if kind == _CONE:
            first = max(limits[j, 0, 0 if a >= 0 else 1], _LEAST)
            second = max(limits[j, 1, 0 if b >= 0 else 1], _LEAST)
            root = math.sqrt((a / first) ** 2 + (b / second) ** 2)
            if root > 1.0:
                da = a - a / root
                db = b - b / root
        elif kind == _HINGE:
            da = _beyond(a, limits[j, 0, 0], limits[j, 0, 1])
            db = _beyond(b, limits[j, 1, 0] + slack, limits[j, 1, 1] + slack)
        dt = _beyond(t, limits[j, 2, 0] + slack, limits[j, 2, 1] + slack)
        axes = pack.axes[j]
        back = (turn[0], -turn[1], -turn[2], -turn[3])
        e = _turned(
            back,
            da * axes[0, 0] + db * axes[1, 0],
            da * axes[0, 1] + db * axes[1, 1],
            da * axes[0, 2] + db * axes[1, 2],
        )
        for k in range(3):
            past[j, k] = e[k] + dt * axes[2, k]
        if kind == _POLYGON:
            _polygon(rotations[j], j, pack, rotations, past[j])
