"""Excess of every joint of one pose past its stops, as a rotation to be taken back.

It is fast enough for each step of a simulation. `posture.stops` gives exact margins of whole
batches: here the excess of a cone is measured along the ray from zero, not to the nearest point.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.rotation import swing_twist_angles, twist_quaternion
from workbench.compiled import inlined, inner, njit
from workbench.geometry.vectors import (
    add,
    conjugate,
    cross,
    dot,
    norm,
    quaternion,
    quaternion_product,
    rotate,
    scale,
    store,
    vector,
)
from workbench.model.stops import StopKind
from workbench.posture.kernels.stop_law import (
    SMALLEST_LIMIT,
    cone_share,
    followed_limit,
    nearest_side,
)

__all__ = ["StopPack", "past_stops"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FREE = int(StopKind.FREE)
CONE = int(StopKind.CONE)
HINGE = int(StopKind.HINGE)
POLYGON = int(StopKind.POLYGON)


class StopPack(NamedTuple):
    """The stops of J joints, packed for the kernel."""

    kind: Ints
    """(J,) a `StopKind`."""
    axes: Floats
    """(J, 3, 3) unit axes: first swing, second swing, twist."""
    limits: Floats
    """(J, 3, 2) [rad] how far each angle goes up and down."""
    play: Floats
    """(J,) [rad] play of a hinge beyond the limits of its other two angles."""
    coupling: Floats
    """(M, 9) limits that follow an angle: joint, axis, side, driving joint and axis, two of its
    angles [rad], and the limit [rad] at each."""
    sides: Floats
    """(J, V, 5, 3) sides of the spherical polygons, as `Linkage.sides`."""
    corners: Ints
    """(J,) number of sides of each polygon."""
    limb: Floats
    """(J, 3) direction of the limb that a polygon holds."""
    before: Ints
    """(J, B) joints from the polygon's frame to this one, -1 where there are none."""


@inlined
def _excess(value, up, down):  # type: ignore[no-untyped-def]
    """How far a value lies beyond the limits -down..up, with its sign."""
    if value > up:
        return value - up
    return value + down if value < -down else 0.0


@inlined
def _cone_excess(first, second, limits):  # type: ignore[no-untyped-def]
    """Excess of a swing past its cone (s1 / L1)^2 + (s2 / L2)^2 = 1, along the ray from zero."""
    l0 = max(limits[0, 0 if first >= 0 else 1], SMALLEST_LIMIT)
    l1 = max(limits[1, 0 if second >= 0 else 1], SMALLEST_LIMIT)
    q = cone_share(first, second, l0, l1)
    if q > 1.0:
        return first - first / q, second - second / q
    return 0.0, 0.0


@inner
def _polygon_excess(j, pack, rotations):  # type: ignore[no-untyped-def]
    """Rotation vector [rad], in the distal frame of joint j, by which its limb is past its polygon.

    The limb's direction d goes back to the nearest point p along the great circle: about p x d.
    """
    whole = (1.0, 0.0, 0.0, 0.0)
    for b in range(pack.before.shape[1]):
        if pack.before[j, b] >= 0:
            whole = quaternion_product(whole, quaternion(rotations[pack.before[j, b]]))
    whole = quaternion_product(whole, quaternion(rotations[j]))
    d = rotate(whole, vector(pack.limb[j]))
    p, _, inside = nearest_side(pack.sides[j, : pack.corners[j]], d)
    axis = cross(p, d)
    sine = norm(axis)
    if inside or sine < 1e-12:
        return 0.0, 0.0, 0.0
    angle = math.atan2(sine, dot(p, d))
    return rotate(conjugate(whole), scale(angle / sine, axis))


@inlined
def _angle_excess(kind, angles, limits, play, axes):  # type: ignore[no-untyped-def]
    """Rotation vector [rad], in the distal frame, by which the angles of a joint exceed its limits.

    The excess of the swing is turned into that frame, which lies beyond the twist.
    """
    slack = play if kind == HINGE else 0.0
    first = 0.0
    second = 0.0
    if kind == CONE:
        first, second = _cone_excess(angles[0], angles[1], limits)
    elif kind == HINGE:
        first = _excess(angles[0], limits[0, 0], limits[0, 1])
        second = _excess(angles[1], limits[1, 0] + slack, limits[1, 1] + slack)
    twist = _excess(angles[2], limits[2, 0] + slack, limits[2, 1] + slack)
    swing = add(scale(first, vector(axes[0])), scale(second, vector(axes[1])))
    back = conjugate(twist_quaternion(vector(axes[2]), angles[2]))
    return add(rotate(back, swing), scale(twist, vector(axes[2])))


@inlined
def _apply_couplings(pack, angles, limits):  # type: ignore[no-untyped-def]
    """Set the limits that follow an angle."""
    for m in range(pack.coupling.shape[0]):
        c = pack.coupling[m]
        driver = angles[int(c[3]), int(c[4])]
        limit, _ = followed_limit(driver, c[5], c[6], c[7], c[8])
        limits[int(c[0]), int(c[1]), int(c[2])] = limit


@njit(cache=True)
def past_stops(rotations, pack, angles, limits, past):  # type: ignore[no-untyped-def]
    """Measure how far every joint is past its stops.

    Parameters
    ----------
    rotations : (J, 4)
        Joint rotations.
    pack : StopPack
        The stops.
    angles : (J, 3)
        Filled with the joint angles [rad].
    limits : (J, 3, 2)
        Filled with the limits [rad], couplings applied.
    past : (J, 3)
        Filled with the rotation vector [rad], in the frame of the distal segment, from a legal
        rotation to this one: the nearest one, but for a cone the one on the ray from zero.
    """
    for j in range(pack.kind.shape[0]):
        for i in range(3):
            limits[j, i, 0] = pack.limits[j, i, 0]
            limits[j, i, 1] = pack.limits[j, i, 1]
        store(swing_twist_angles(quaternion(rotations[j]), pack.axes[j]), angles[j])
    _apply_couplings(pack, angles, limits)
    for j in range(pack.kind.shape[0]):
        kind = pack.kind[j]
        past[j] = 0.0
        if kind == FREE:
            continue
        excess = _angle_excess(kind, angles[j], limits[j], pack.play[j], pack.axes[j])
        if kind == POLYGON:
            excess = add(excess, _polygon_excess(j, pack, rotations))
        store(excess, past[j])
