"""A serial chain of joints: where its links are, and how its tip moves with each free angle.

The angles of a joint are the two components of its swing vector and its twist: rotation =
exp(swing) exp(twist). The rate of turn that a swing component causes is the left Jacobian of the
exponential map times its axis (Chirikjian 2011, Stochastic Models, Information Theory, and Lie
Groups 2, section 10.3).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import inlined, njit

__all__ = ["Linkage", "State", "move", "new_state"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Linkage(NamedTuple):
    """K joints from link 0 (held) to link K (with the tip), of B bodies that differ in lengths
    only; n of the 3 K angles are free.

    at_parent, at_child (B, K, 3): each joint in both links' frames; tip, pointing (B, 3): the point
    that reaches and the direction it reaches in, in link K. axes (K, 3, 3): swing 1, swing 2,
    twist; rows (R, 3): its stops, joint, axis and side (see kernels.limbs.limits); limits (K, 3, 2)
    [rad]; coupled (K, 3, 2): the row of coupling (M, 6) that a limit follows, or -1: driver joint
    and axis, two driver angles, two limits; free_joint, free_axis (n,); free_of (K, 3): which free
    angle, or -1; mode (n,) [rad] and weight (n,) [1/rad2]: comfort is the weighted square of the
    distance to the mode. sides (V, 5, 3): the spherical polygon that holds limb (3,) in the frame
    of link polygon_link, side by side: first corner, inward normal, normals of its two ends, normal
    of the plane through first corner and centre.
    """

    at_parent: Floats
    at_child: Floats
    axes: Floats
    rows: Ints
    limits: Floats
    coupling: Floats
    coupled: Ints
    free_joint: Ints
    free_axis: Ints
    free_of: Ints
    mode: Floats
    weight: Floats
    sides: Floats
    limb: Floats
    polygon_link: int
    tip: Floats
    pointing: Floats


class State(NamedTuple):
    """Where a chain is: angles (K, 3); world (K + 1, 3, 4); spin (n, 3): rate of turn for each free
    angle; slope (n, 6): rate of the tip and of its direction; at (6,): tip and direction; pivot (K,
    3): the joints; bend (K, 3, 3): how a joint's rates of turn change with its swing, the first's
    with the first angle, with the second, and the second's with the second; room (R,),
    slope_of_room (R, n), label (R, 3): the stops (joint, axis, side) and planes; held (R, 7): of a
    plane its point, normal and link, of a polygon the limb's direction and the way in, of a cone
    its curvature (3); used (1,): how many rows there are."""

    angles: Floats
    world: Floats
    spin: Floats
    slope: Floats
    at: Floats
    pivot: Floats
    bend: Floats
    room: Floats
    slope_of_room: Floats
    label: Ints
    held: Floats
    used: Ints


# Nothing below allocates, so it is compiled without the run time that counts references, and
# inlined into the batch loop by force: a call would copy the descriptions of all these arrays, 1 kB
# and more, onto the stack.


@njit(cache=True)
def new_state(joints, free, rows):  # type: ignore[no-untyped-def]
    """An empty state."""
    return State(
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
def _sines(angle):  # type: ignore[no-untyped-def]
    """sin(a)/a, (1 - cos a)/a2 and (a - sin a)/a3, also near zero."""
    if angle < 1e-4:
        square = angle * angle
        return 1.0 - square / 6.0, 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    sine = math.sin(angle)
    cosine = math.cos(angle)
    return sine / angle, (1.0 - cosine) / (angle * angle), (angle - sine) / (angle * angle * angle)


@inlined
def _times(m, r):  # type: ignore[no-untyped-def]
    """Product of two matrices given row by row as tuples."""
    return (
        m[0] * r[0] + m[1] * r[3] + m[2] * r[6],
        m[0] * r[1] + m[1] * r[4] + m[2] * r[7],
        m[0] * r[2] + m[1] * r[5] + m[2] * r[8],
        m[3] * r[0] + m[4] * r[3] + m[5] * r[6],
        m[3] * r[1] + m[4] * r[4] + m[5] * r[7],
        m[3] * r[2] + m[4] * r[5] + m[5] * r[8],
        m[6] * r[0] + m[7] * r[3] + m[8] * r[6],
        m[6] * r[1] + m[7] * r[4] + m[8] * r[7],
        m[6] * r[2] + m[7] * r[5] + m[8] * r[8],
    )


@inlined
def _turn(x, y, z, a, b):  # type: ignore[no-untyped-def]
    """Matrix of the rotation vector (x, y, z), a and b being the first two sines of its length:
    Rodrigues' formula."""
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
def _joint(link, b, k, state):  # type: ignore[no-untyped-def]
    """World of link k + 1 and the rates of turn of joint k's free angles, from the world of link k;
    of body b."""
    t0 = state.angles[k, 0]
    t1 = state.angles[k, 1]
    t2 = state.angles[k, 2]
    axes = link.axes
    w = state.world
    world = state.world
    spin = state.spin
    s = (
        t0 * axes[k, 0, 0] + t1 * axes[k, 1, 0],
        t0 * axes[k, 0, 1] + t1 * axes[k, 1, 1],
        t0 * axes[k, 0, 2] + t1 * axes[k, 1, 2],
    )
    size = math.sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2])
    above = (
        w[k, 0, 0],
        w[k, 0, 1],
        w[k, 0, 2],
        w[k, 1, 0],
        w[k, 1, 1],
        w[k, 1, 2],
        w[k, 2, 0],
        w[k, 2, 1],
        w[k, 2, 2],
    )
    first, second, third = _sines(size)
    swung = _times(above, _turn(s[0], s[1], s[2], first, second)) if size > 0.0 else above
    below = swung
    if t2 != 0.0:
        a, c, _ = _sines(abs(t2))
        below = _times(
            swung, _turn(t2 * axes[k, 2, 0], t2 * axes[k, 2, 1], t2 * axes[k, 2, 2], a, c)
        )
    p0 = link.at_parent[b, k, 0]
    p1 = link.at_parent[b, k, 1]
    p2 = link.at_parent[b, k, 2]
    q0 = link.at_child[b, k, 0]
    q1 = link.at_child[b, k, 1]
    q2 = link.at_child[b, k, 2]
    for i in range(3):
        m = 3 * i
        world[k + 1, i, 0] = below[m]
        world[k + 1, i, 1] = below[m + 1]
        world[k + 1, i, 2] = below[m + 2]
        at = above[m] * p0 + above[m + 1] * p1 + above[m + 2] * p2
        state.pivot[k, i] = w[k, i, 3] + at
        world[k + 1, i, 3] = w[k, i, 3] + at - below[m] * q0 - below[m + 1] * q1 - below[m + 2] * q2
    for axis in range(3):
        d = link.free_of[k, axis]
        if d < 0:
            continue
        x = axes[k, axis, 0]
        y = axes[k, axis, 1]
        z = axes[k, axis, 2]
        frame = swung
        if axis < 2:
            frame = above
            u = (s[1] * z - s[2] * y, s[2] * x - s[0] * z, s[0] * y - s[1] * x)
            t = (s[1] * u[2] - s[2] * u[1], s[2] * u[0] - s[0] * u[2], s[0] * u[1] - s[1] * u[0])
            x = x + second * u[0] + third * t[0]
            y = y + second * u[1] + third * t[1]
            z = z + second * u[2] + third * t[2]
        for i in range(3):
            spin[d, i] = frame[3 * i] * x + frame[3 * i + 1] * y + frame[3 * i + 2] * z
    if link.free_of[k, 0] >= 0 and link.free_of[k, 1] >= 0:
        _bends(axes, state.bend, k, s, size, above)


@inlined
def _cross(a, b):  # type: ignore[no-untyped-def]
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def _bends(axes, bend, k, s, size, above):  # type: ignore[no-untyped-def]
    """Fill bend[k]: the left Jacobian times an axis, a + b s x a + c s x (s x a), differentiated by
    the components of the swing vector s (3,)."""
    _, b, c = _sines(size)
    square = size * size
    b_slope = -1.0 / 12.0
    c_slope = -1.0 / 60.0
    if size > 1e-2:
        b_slope = (math.sin(size) / size - 2.0 * b) / square
        c_slope = (b - 3.0 * c) / square
    for m in range(3):
        i = m // 2
        j = (m + 1) // 2  # the rate of the first is differentiated by the second
        a = (axes[k, i, 0], axes[k, i, 1], axes[k, i, 2])
        o = (axes[k, j, 0], axes[k, j, 1], axes[k, j, 2])
        u = _cross(s, a)
        q = _cross(o, a)
        t = _cross(s, u)
        v = _cross(o, u)
        w = _cross(s, q)
        part = s[0] * o[0] + s[1] * o[1] + s[2] * o[2]
        p = b_slope * part
        r = c_slope * part
        x = p * u[0] + b * q[0] + r * t[0] + c * (v[0] + w[0])
        y = p * u[1] + b * q[1] + r * t[1] + c * (v[1] + w[1])
        z = p * u[2] + b * q[2] + r * t[2] + c * (v[2] + w[2])
        for n in range(3):
            bend[k, m, n] = above[3 * n] * x + above[3 * n + 1] * y + above[3 * n + 2] * z


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def move(link, b, base, p, state):  # type: ignore[no-untyped-def]
    """Fill world, spin, slope and `at` of a state from its angles, of body b; base[p] (3, 4) is the
    world of link 0."""
    world = state.world
    at = state.at
    slope = state.slope
    spin = state.spin
    joints = link.axes.shape[0]
    for i in range(3):
        for m in range(4):
            world[0, i, m] = base[p, i, m]
    for k in range(joints):
        _joint(link, b, k, state)
    for i in range(3):
        at[i] = world[joints, i, 3]
        at[3 + i] = 0.0
        for m in range(3):
            at[i] += world[joints, i, m] * link.tip[b, m]
            at[3 + i] += world[joints, i, m] * link.pointing[b, m]
    for d in range(link.free_joint.shape[0]):
        k = link.free_joint[d]
        w0 = spin[d, 0]
        w1 = spin[d, 1]
        w2 = spin[d, 2]
        r0 = at[0] - state.pivot[k, 0]
        r1 = at[1] - state.pivot[k, 1]
        r2 = at[2] - state.pivot[k, 2]
        slope[d, 0] = w1 * r2 - w2 * r1
        slope[d, 1] = w2 * r0 - w0 * r2
        slope[d, 2] = w0 * r1 - w1 * r0
        slope[d, 3] = w1 * at[5] - w2 * at[4]
        slope[d, 4] = w2 * at[3] - w0 * at[5]
        slope[d, 5] = w0 * at[4] - w1 * at[3]
