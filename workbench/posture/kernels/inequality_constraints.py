"""Room of a chain to its stops and to planes, and the gradient of that room.

A row of room is positive inside. It is in radians for a stop and in metres for a plane. The stops are
those of `stop_law`.

References
----------
.. [1] G. Taubin (1991), Estimation of planar curves, surfaces, and nonplanar space curves, IEEE
   Transactions on Pattern Analysis and Machine Intelligence 13, 1115-1138.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import inlined, njit
from workbench.geometry.vectors import (
    add,
    cross,
    dot,
    matvec,
    norm,
    rotation_part,
    scale,
    store,
    subtract,
    transpose_matvec,
    vector,
)
from workbench.posture.kernels.stop_law import (
    SMALLEST_LIMIT,
    cone_share,
    followed_limit,
    nearest_side,
)

__all__ = [
    "SIDE_ROWS",
    "WHOLE_CONE",
    "WHOLE_POLYGON",
    "WHOLE_TURN",
    "ContactPlanes",
    "clamp_angles",
    "constraint_slacks",
]

SIDE_ROWS = 3
"""Number of axes: a row with a smaller number in the place of its axis is about one angle."""
WHOLE_CONE = 3
WHOLE_POLYGON = 4
WHOLE_TURN = 5
"""What stands in the place of an axis in a row that is about more than one angle."""
MIDDLE_OF_CONE = 0.05
"""Share of its half-angles within which a swing is far from its cone: the gradient is poor there."""
MOST_SWING = 3.12
"""Largest swing [rad] of the joint of a polygon."""
SLOPE_OF_HALF_TURN = 1.0
"""Swing [rad] from which its distance to a half turn has a gradient; a swing of 0 has none."""
UNLIMITED = 1e3
"""Room [rad] where nothing limits."""
ON_BOUNDARY = 1e-5
"""Distance [rad] from the boundary of a polygon within which its side gives the way inward."""


class ContactPlanes(NamedTuple):
    """Q planes that points of a chain must stay above: normal . x >= offset."""

    link: NDArray[np.int64]
    """(Q,) the link that carries the point."""
    point: NDArray[np.float64]
    """(Q, 3) [m] the point, in the link's frame."""
    normal: NDArray[np.float64]
    """(Q, 3) unit normals, in the world."""
    offset: NDArray[np.float64]
    """(Q,) [m]."""


# As in `posture.kernels.linkage`, all is inlined and compiled without counting references.


@inlined
def _limit(link, angles, k, axis, side):  # type: ignore[no-untyped-def]
    """Limit [rad] of an angle: its value, the row of coupling that it follows here (or -1), its rate."""
    c = link.coupled[k, axis, side]
    if c < 0:
        return link.limits[k, axis, side], -1, 0.0
    coupling = link.coupling[c]
    driver = angles[int(coupling[0]), int(coupling[1])]
    limit, rate = followed_limit(driver, coupling[2], coupling[3], coupling[4], coupling[5])
    return limit, c if rate != 0.0 else -1, rate


@inlined
def _half_angle(link, angles, k, axis):  # type: ignore[no-untyped-def]
    """Half-angle of a cone on the side of a swing angle: side, half-angle, coupling and rate."""
    side = 0 if angles[k, axis] >= 0 else 1
    limit, c, rate = _limit(link, angles, k, axis, side)
    return side, max(limit, SMALLEST_LIMIT), c, rate


@inlined
def _add_slope(link, slope, k, axis, rate):  # type: ignore[no-untyped-def]
    """Add the rate of a row by an angle, where that angle is free."""
    column = link.free_of[k, axis]
    if column >= 0:
        slope[column] += rate


@inlined
def _add_coupled_slope(link, slope, c, rate):  # type: ignore[no-untyped-def]
    """Add the rate of a row by the angle that drives coupling c (-1 for none)."""
    if c >= 0:
        _add_slope(link, slope, int(link.coupling[c, 0]), int(link.coupling[c, 1]), rate)


@inlined
def _angle_row(link, state, k, axis, side, r):  # type: ignore[no-untyped-def]
    """Fill a row for the limit of one angle: room = limit -+ angle."""
    limit, c, rate = _limit(link, state.angles, k, axis, side)
    sign = 1.0 - 2.0 * side
    state.room[r] = limit - sign * state.angles[k, axis]
    state.slope_of_room[r, link.free_of[k, axis]] = -sign
    _add_coupled_slope(link, state.slope_of_room[r], c, rate)


@inlined
def _cone_row(link, state, k, r):  # type: ignore[no-untyped-def]
    """Fill a row for the swing cone of joint k, with its second derivatives."""
    # With the half-angles L of the quadrant and q = sqrt((s1 / L1)^2 + (s2 / L2)^2), the room is
    # the first-order distance to the ellipse q = 1 [1]_, an angle:
    #     room = (1 - q) / |∇q|,    ∇q = (s1 / (L1^2 q), s2 / (L2^2 q)).
    s0 = state.angles[k, 0]
    s1 = state.angles[k, 1]
    first = _half_angle(link, state.angles, k, 0)
    second = _half_angle(link, state.angles, k, 1)
    l0 = first[1]
    l1 = second[1]
    q = cone_share(s0, s1, l0, l1)
    state.room[r] = UNLIMITED
    state.label[r, 1] = 0
    state.label[r, 2] = first[0]
    store((0.0, 0.0, 0.0), state.held[r])
    if q < MIDDLE_OF_CONE:
        return
    g0 = s0 / (l0 * l0 * q)
    g1 = s1 / (l1 * l1 * q)
    size = math.sqrt(g0 * g0 + g1 * g1)
    if abs(g1) > abs(g0):
        state.label[r, 1] = 1
        state.label[r, 2] = second[0]
    state.room[r] = (1.0 - q) / size
    store(_cone_curvature(l0, l1, g0, g1, q, size), state.held[r])
    _add_cone_slope(link, state, k, 0, g0, size, first, r)
    _add_cone_slope(link, state, k, 1, g1, size, second, r)


@inlined
def _add_cone_slope(link, state, k, axis, g, size, half_angle, r):  # type: ignore[no-untyped-def]
    """Add what one swing angle does to the room of a cone, and the angle its half-angle follows."""
    # |∇q| counts as constant in the derivatives of the room: ∇room = -∇q / |∇q|. A half-angle that
    # grows moves the ellipse outward: dq/dL = -s^2 / (L^3 q) = -∇q s / L.
    _, limit, c, rate = half_angle
    slope = state.slope_of_room[r]
    _add_slope(link, slope, k, axis, -(g / size))
    _add_coupled_slope(link, slope, c, g * state.angles[k, axis] / limit * rate / size)


@inlined
def _cone_curvature(l0, l1, g0, g1, q, size):  # type: ignore[no-untyped-def]
    """Second derivatives of minus the room: (diag(1 / L^2) - ∇q ∇q') / (q |∇q|), as xx, xy, yy."""
    bend = 1.0 / (q * size)
    return bend * (1.0 / (l0 * l0) - g0 * g0), -bend * g0 * g1, bend * (1.0 / (l1 * l1) - g1 * g1)


@inlined
def _polygon_row(link, state, k, r):  # type: ignore[no-untyped-def]
    """Fill a row for the limb of joint k in its spherical polygon: room is the angle to it."""
    # With the limb's direction d, its nearest boundary point q, and the unit direction u inward:
    #     room = +-2 asin(|d - q| / 2),    d room / dθ = u . (ω x d) = ω . (d x u).
    frame = link.polygon_link
    from_polygon = rotation_part(state.world[frame])
    limb = matvec(rotation_part(state.world[k + 1]), vector(link.limb))
    d = transpose_matvec(from_polygon, limb)
    q, side, inside = nearest_side(link.sides, d)
    gap = norm(subtract(d, q))
    sign = -1.0 if inside else 1.0
    state.room[r] = -sign * (2.0 * math.asin(min(1.0, 0.5 * gap)))
    u = scale(sign / max(gap, 1e-300), subtract(q, d))
    if gap < ON_BOUNDARY:
        u = vector(link.sides[side, 1])
    store(matvec(from_polygon, d), state.held[r])
    store(matvec(from_polygon, u), state.held[r, 3:])
    turn = matvec(from_polygon, cross(d, u))
    _label_turn(link, state, k, turn, r)
    for i in range(link.free_joint.shape[0]):
        if frame <= link.free_joint[i] <= k:
            state.slope_of_room[r, i] = dot(vector(state.spin[i]), turn)


@inlined
def _label_turn(link, state, k, turn, r):  # type: ignore[no-untyped-def]
    """Label a row with the swing axis of joint k, and its side, that leads out most directly.

    turn is the axis of the rotation that leads inward, in the world.
    """
    own = transpose_matvec(rotation_part(state.world[k]), turn)
    first = dot(own, vector(link.axes[k, 0]))
    second = dot(own, vector(link.axes[k, 1]))
    axis = 0 if abs(first) >= abs(second) else 1
    inward = first if axis == 0 else second
    state.label[r, 1] = axis
    state.label[r, 2] = 0 if inward < 0.0 else 1


@inlined
def _half_turn_row(link, state, k, r):  # type: ignore[no-untyped-def]
    """Fill a row that keeps the swing of joint k below a half turn, where its angles would jump."""
    s0 = state.angles[k, 0]
    s1 = state.angles[k, 1]
    size = math.sqrt(s0 * s0 + s1 * s1)
    axis = 0 if abs(s0) >= abs(s1) else 1
    state.label[r, 1] = axis
    state.label[r, 2] = 0 if state.angles[k, axis] >= 0.0 else 1
    state.room[r] = MOST_SWING - size
    if size > SLOPE_OF_HALF_TURN:
        for i in range(2):
            if link.free_of[k, i] >= 0:
                state.slope_of_room[r, link.free_of[k, i]] = -state.angles[k, i] / size


@inlined
def _plane_row(link, planes, m, state, r):  # type: ignore[no-untyped-def]
    """Fill a row for plane m: room = n . x - offset, d room / dθ = n . (ω x arm) = ω . (arm x n)."""
    k = planes.link[m]
    normal = vector(planes.normal[m])
    pose = state.world[k]
    turned = matvec(rotation_part(pose), vector(planes.point[m]))
    x = add(turned, (pose[0, 3], pose[1, 3], pose[2, 3]))
    state.room[r] = dot(normal, x) - planes.offset[m]
    store(x, state.held[r])
    store(normal, state.held[r, 3:])
    state.held[r, 6] = k
    for i in range(link.free_joint.shape[0]):
        j = link.free_joint[i]
        if j < k:
            arm = subtract(x, vector(state.pivot[j]))
            state.slope_of_room[r, i] = dot(vector(state.spin[i]), cross(arm, normal))


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def constraint_slacks(link, planes, span, state):  # type: ignore[no-untyped-def]
    """Fill the rows of room of a state: the stops in the order of link.rows, then planes.

    Parameters
    ----------
    link : Linkage
        The chain.
    planes : Planes
        Planes of all chains.
    span : tuple of two
        First plane that counts, and the one after the last.
    state : State
        A state that `move` has filled; room, slope_of_room, label, held and used out.
    """
    stops = link.rows.shape[0]
    count = span[1] - span[0]
    state.used[0] = stops + count
    for r in range(stops + count):
        for i in range(state.slope_of_room.shape[1]):
            state.slope_of_room[r, i] = 0.0
    for r in range(stops):
        k = link.rows[r, 0]
        axis = link.rows[r, 1]
        side = link.rows[r, 2]
        store((k, axis, side), state.label[r])
        if axis < SIDE_ROWS:
            _angle_row(link, state, k, axis, side, r)
        elif axis == WHOLE_CONE:
            _cone_row(link, state, k, r)
        elif axis == WHOLE_POLYGON:
            _polygon_row(link, state, k, r)
        else:
            _half_turn_row(link, state, k, r)
    for m in range(count):
        store((-1, m, 0), state.label[stops + m])
        _plane_row(link, planes, span[0] + m, state, stops + m)


@inlined
def _clamp_swing(link, angles, k):  # type: ignore[no-untyped-def]
    """Bring a swing into its cone along the ray from zero."""
    _, l0, _, _ = _half_angle(link, angles, k, 0)
    _, l1, _, _ = _half_angle(link, angles, k, 1)
    q = cone_share(angles[k, 0], angles[k, 1], l0, l1)
    if q > 1.0:
        angles[k, 0] = angles[k, 0] / q
        angles[k, 1] = angles[k, 1] / q


@inlined
def clamp_angles(link, angles):  # type: ignore[no-untyped-def]
    """Bring free angles (K, 3) [rad] inside their cones, hinges and twist limits, in place."""
    for twist in range(2):  # a limit of a twist may follow a swing, so twists come second
        for r in range(link.rows.shape[0]):
            k = link.rows[r, 0]
            axis = link.rows[r, 1]
            side = link.rows[r, 2]
            if axis == WHOLE_CONE and twist == 0:
                _clamp_swing(link, angles, k)
            elif axis < SIDE_ROWS and (axis == 2) == (twist == 1):
                limit, _, _ = _limit(link, angles, k, axis, side)
                if side == 0:
                    angles[k, axis] = min(angles[k, axis], limit)
                else:
                    angles[k, axis] = max(angles[k, axis], -limit)
