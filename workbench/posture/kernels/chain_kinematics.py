"""Forward kinematics of a serial chain of joints: poses of its links, and Jacobians of its tip.

The angles of a joint are the two components of its swing vector and its twist: rotation =
exp(swing) exp(twist). The angular velocity that a swing component causes is the left Jacobian of
the exponential map times its axis [1]_.

References
----------
.. [1] G. S. Chirikjian (2011), Stochastic Models, Information Theory, and Lie Groups, volume 2,
   section 10.3, Birkhäuser.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.rotation import product
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
    vector,
)

__all__ = ["ChainState", "Linkage", "forward_kinematics", "new_state", "rotation_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SMALL_ANGLE = 1e-4
"""Angle [rad] below which the coefficients of Rodrigues' formula are taken from their series."""
SMALL_SWING = 1e-2
"""Swing [rad] below which the derivatives of these coefficients are taken as at zero."""


class Linkage(NamedTuple):
    """Chain of K joints, for B bodies that differ in lengths only. Link 0 is the base.

    n of the 3 K angles are free. Joint k stands between the links k and k + 1.
    """

    at_parent: Floats
    """(B, K, 3) [m] centre of each joint in the frame of the link before it."""
    at_child: Floats
    """(B, K, 3) [m] the same point in the frame of the link after it."""
    axes: Floats
    """(K, 3, 3) unit axes of each joint: first swing, second swing, twist."""
    rows: Ints
    """(R, 3) stops: joint, axis and side (see `posture.kernels.limits`)."""
    limits: Floats
    """(K, 3, 2) [rad] how far each angle goes up and down."""
    coupling: Floats
    """(M, 6) limits that follow an angle: driving joint and axis, two of its angles [rad], and the
    limit [rad] at each."""
    coupled: Ints
    """(K, 3, 2) the row of coupling that a limit follows, -1 for a constant limit."""
    free_joint: Ints
    """(n,) joint of each free angle."""
    free_axis: Ints
    """(n,) axis of each free angle."""
    free_of: Ints
    """(K, 3) number of each angle among the free ones (its Jacobian column), -1 if it is fixed."""
    mode: Floats
    """(n,) [rad] the most comfortable value of each free angle."""
    weight: Floats
    """(n,) [1/rad2] discomfort is the sum of weight (angle - mode)^2."""
    sides: Floats
    """(V, 5, 3) sides of the spherical polygon that holds the limb: first corner, inward normal,
    the normals of its two ends, and the normal of the plane through first corner and centre."""
    limb: Floats
    """(3,) direction of the limb that the polygon holds."""
    polygon_link: int
    """Link in whose frame the polygon stands, -1 without a polygon."""
    tip: Floats
    """(B, 3) [m] the point that reaches, in link K."""
    pointing: Floats
    """(B, 3) unit direction that it points in, in link K."""


class ChainState(NamedTuple):
    """Working arrays of one chain, filled in place: the solver's loop allocates nothing."""

    angles: Floats
    """(K, 3) [rad] joint angles."""
    world: Floats
    """(K + 1, 3, 4) world-from-link transforms."""
    spin: Floats
    """(n, 3) angular Jacobian: angular velocity beyond the joint per unit rate of a free angle."""
    slope: Floats
    """(n, 6) Jacobian of the tip [m/rad] and of its direction [1/rad]."""
    at: Floats
    """(6,) tip [m] and its direction."""
    pivot: Floats
    """(K, 3) [m] centres of the joints."""
    bend: Floats
    """(K, 3, 3) derivatives of a joint's angular velocities by its swing: of the first by the first
    angle, of the first by the second, of the second by the second."""
    room: Floats
    """(R,) distance from each stop [rad] and plane [m], positive inside."""
    slope_of_room: Floats
    """(R, n) its derivatives by the free angles."""
    label: Ints
    """(R, 3) joint, axis and side of each stop; -1, number and 0 of a plane."""
    held: Floats
    """(R, 7) what the curvature of a row needs. A plane: point, normal and link. A polygon:
    direction of the limb and direction inward. A cone: its three second derivatives."""
    used: Ints
    """(1,) number of rows in use."""


# Nothing below allocates, so it is compiled without the run time that counts references. It is
# inlined into the batch loop: a call would copy the descriptions of all these arrays, 1 kB and
# more, onto the stack.


def new_state(joints: int, free: int, rows: int) -> ChainState:
    """Make an empty state for so many joints, free angles, and rows of room."""
    return ChainState(
        np.zeros((joints, 3)),
        np.zeros((joints + 1, 3, 4)),
        np.zeros((free, 3)),
        np.zeros((free, 6)),
        np.zeros(6),
        np.zeros((joints, 3)),
        np.zeros((joints, 3, 3)),
        np.zeros(rows),
        np.zeros((rows, free)),
        np.zeros((rows, 3), np.int64),
        np.zeros((rows, 7)),
        np.zeros(1, np.int64),
    )


@inlined
def _rodrigues_coefficients(angle):  # type: ignore[no-untyped-def]
    """Coefficients sin(a)/a, (1 - cos a)/a2 and (a - sin a)/a3, by their series near zero."""
    if angle < SMALL_ANGLE:
        square = angle * angle
        return 1.0 - square / 6.0, 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    sine = math.sin(angle)
    cosine = math.cos(angle)
    return sine / angle, (1.0 - cosine) / (angle * angle), (angle - sine) / (angle * angle * angle)


@inlined
def _exp_so3(w, coefficients):  # type: ignore[no-untyped-def]
    """Matrix of a rotation vector w by Rodrigues' formula: I + a [w] + b [w]^2."""
    x, y, z = w
    a, b, _ = coefficients
    return (
        1.0 - b * (y * y + z * z),
        b * x * y - a * z,
        b * x * z + a * y,
        b * x * y + a * z,
        1.0 - b * (x * x + z * z),
        b * y * z - a * x,
        b * x * z - a * y,
        b * y * z + a * x,
        1.0 - b * (x * x + y * y),
    )


@inlined
def _left_jacobian_times(w, coefficients, v):  # type: ignore[no-untyped-def]
    """Left Jacobian of SO(3) at w, applied to v: v + b w x v + c w x (w x v)."""
    once = cross(w, v)
    twice = cross(w, once)
    return add(add(v, scale(coefficients[1], once)), scale(coefficients[2], twice))


@inlined
def _coefficient_slopes(size, coefficients):  # type: ignore[no-untyped-def]
    """Derivatives of the coefficients b and c by the angle, divided by the angle."""
    _, b, c = coefficients
    if size > SMALL_SWING:
        square = size * size
        return (math.sin(size) / size - 2.0 * b) / square, (b - 3.0 * c) / square
    return -1.0 / 12.0, -1.0 / 60.0


@inlined
def _left_jacobian_slope(w, coefficients, slopes, v, o):  # type: ignore[no-untyped-def]
    """Differentiate the left Jacobian at w, applied to v, as w moves along o."""
    # J(w) v = v + b w x v + c w x (w x v), and the angle |w| grows by w . o / |w|, so
    #     b'/|w| (w . o) w x v + b o x v
    #     + c'/|w| (w . o) w x (w x v) + c (o x (w x v) + w x (o x v)).
    _, b, c = coefficients
    along = dot(w, o)
    once = cross(w, v)
    turned = cross(o, v)
    first = add(scale(slopes[0] * along, once), scale(b, turned))
    second = add(first, scale(slopes[1] * along, cross(w, once)))
    return add(second, scale(c, add(cross(o, once), cross(w, turned))))


@inlined
def _place_link(link, body, k, parent, child, state):  # type: ignore[no-untyped-def]
    """Write the pose of link k + 1, p' = p + R u - R' v, and the centre of joint k, p + R u.

    R (parent) and R' (child) are the links' rotations, u and v the centre of the joint in each.
    """
    world = state.world
    u = matvec(parent, vector(link.at_parent[body, k]))
    v = vector(link.at_child[body, k])
    for i in range(3):
        state.pivot[k, i] = world[k, i, 3] + u[i]
        for m in range(3):
            world[k + 1, i, m] = child[3 * i + m]
        world[k + 1, i, 3] = (
            state.pivot[k, i]
            - child[3 * i] * v[0]
            - child[3 * i + 1] * v[1]
            - child[3 * i + 2] * v[2]
        )


@inlined
def _fill_angular_jacobian(link, k, swing, coefficients, parent, swung, state):  # type: ignore[no-untyped-def]
    """Fill the angular velocities that the free angles of joint k cause."""
    # J being the left Jacobian of SO(3), s the swing vector and R the rotation of the parent:
    #     ω1 = R J(s) a1,    ω2 = R J(s) a2,    ω3 = R exp(s) a3.
    for axis in range(3):
        column = link.free_of[k, axis]
        if column < 0:
            continue
        direction = vector(link.axes[k, axis])
        frame = swung  # the twist comes after the swing, so its axis has swung
        if axis < 2:
            frame = parent
            direction = _left_jacobian_times(swing, coefficients, direction)
        store(matvec(frame, direction), state.spin[column])


@inlined
def _fill_axis_derivatives(link, k, swing, size, coefficients, parent, state):  # type: ignore[no-untyped-def]
    """Fill the derivatives of joint k's angular velocities by its swing angles."""
    first = vector(link.axes[k, 0])
    second = vector(link.axes[k, 1])
    slopes = _coefficient_slopes(size, coefficients)
    bend = state.bend[k]
    store(matvec(parent, _left_jacobian_slope(swing, coefficients, slopes, first, first)), bend[0])
    store(matvec(parent, _left_jacobian_slope(swing, coefficients, slopes, first, second)), bend[1])
    store(
        matvec(parent, _left_jacobian_slope(swing, coefficients, slopes, second, second)), bend[2]
    )


@inlined
def rotation_of(vector):  # type: ignore[no-untyped-def]
    """Matrix of a rotation vector [rad], as nine numbers."""
    return _exp_so3(vector, _rodrigues_coefficients(norm(vector)))


@inlined
def _update_joint(link, body, k, state):  # type: ignore[no-untyped-def]
    """Place link k + 1 and fill the angular Jacobian of joint k. Link k must be placed already."""
    # Forward kinematics, with s = θ1 a1 + θ2 a2 the swing vector and θ3 a3 the twist vector:
    #     R' = R exp(s) exp(θ3 a3).
    parent = rotation_part(state.world[k])
    swing = add(
        scale(state.angles[k, 0], vector(link.axes[k, 0])),
        scale(state.angles[k, 1], vector(link.axes[k, 1])),
    )
    size = norm(swing)
    coefficients = _rodrigues_coefficients(size)
    swung = parent
    if size > 0.0:  # a joint that only twists needs no product
        swung = product(parent, _exp_so3(swing, coefficients))
    child = swung
    twist = state.angles[k, 2]
    if twist != 0.0:
        twist_vector = scale(twist, vector(link.axes[k, 2]))
        child = product(swung, _exp_so3(twist_vector, _rodrigues_coefficients(abs(twist))))
    _place_link(link, body, k, parent, child, state)
    _fill_angular_jacobian(link, k, swing, coefficients, parent, swung, state)
    if link.free_of[k, 0] >= 0 and link.free_of[k, 1] >= 0:
        _fill_axis_derivatives(link, k, swing, size, coefficients, parent, state)


@inlined
def _place_tip(link, body, state):  # type: ignore[no-untyped-def]
    """Fill the tip, p + R t, and its direction, R d, from the pose of the last link."""
    last = state.world[link.axes.shape[0]]
    for i in range(3):
        state.at[i] = last[i, 3]
        state.at[3 + i] = 0.0
        for m in range(3):
            state.at[i] += last[i, m] * link.tip[body, m]
            state.at[3 + i] += last[i, m] * link.pointing[body, m]


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def forward_kinematics(link, b, base, p, state):  # type: ignore[no-untyped-def]
    """Place the chain of body b at the angles of a state, and fill its Jacobians.

    Parameters
    ----------
    link : Linkage
        The chain of B bodies.
    b : int
        Row of the body.
    base : (P, 3, 4)
        World-from-base transforms [m].
    p : int
        Row of base.
    state : State
        Angles in; world, spin, slope, at, pivot and bend out.
    """
    for i in range(3):
        for m in range(4):
            state.world[0, i, m] = base[p, i, m]
    for k in range(link.axes.shape[0]):
        _update_joint(link, b, k, state)
    _place_tip(link, b, state)
    # Geometric Jacobian of a point x and a direction d that turn with ω about a joint at c:
    #     dx/dθ = ω x (x - c),    dd/dθ = ω x d.
    tip = vector(state.at)
    direction = vector(state.at[3:])
    for column in range(link.free_joint.shape[0]):
        omega = vector(state.spin[column])
        arm = subtract(tip, vector(state.pivot[link.free_joint[column]]))
        store(cross(omega, arm), state.slope[column])
        store(cross(omega, direction), state.slope[column, 3:])
