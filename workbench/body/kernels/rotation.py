"""Compute with rotations in scalars. Quaternions are w, x, y, z; matrices are nine entries, row by row."""

from __future__ import annotations

import math

from workbench.compiled import inlined
from workbench.geometry.vectors import conjugate, dot, norm, quaternion_product, vector

__all__ = [
    "product",
    "quaternion_matrix",
    "swing_twist_angles",
    "swing_twist_quaternion",
    "twist_angle",
    "twist_quaternion",
]


@inlined
def quaternion_matrix(w, x, y, z):  # type: ignore[no-untyped-def]
    """Return the rotation matrix of a quaternion, which is normalized first."""
    n = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    w = w * n
    x = x * n
    y = y * n
    z = z * n
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )


@inlined
def product(a, b):  # type: ignore[no-untyped-def]
    """Return the product of two 3 x 3 matrices."""
    return (
        a[0] * b[0] + a[1] * b[3] + a[2] * b[6],
        a[0] * b[1] + a[1] * b[4] + a[2] * b[7],
        a[0] * b[2] + a[1] * b[5] + a[2] * b[8],
        a[3] * b[0] + a[4] * b[3] + a[5] * b[6],
        a[3] * b[1] + a[4] * b[4] + a[5] * b[7],
        a[3] * b[2] + a[4] * b[5] + a[5] * b[8],
        a[6] * b[0] + a[7] * b[3] + a[8] * b[6],
        a[6] * b[1] + a[7] * b[4] + a[8] * b[7],
        a[6] * b[2] + a[7] * b[5] + a[8] * b[8],
    )


@inlined
def twist_angle(w, x, y, z, a, b, c):  # type: ignore[no-untyped-def]
    """Return the angle [rad] in (-pi, pi] of the twist of a quaternion about the unit axis (a, b, c).

    With q = swing twist, the twist is (w, (v . axis) axis), normalized: angle = 2 atan2(v . axis, w).
    """
    angle = 2.0 * math.atan2(x * a + y * b + z * c, w)
    if angle > math.pi:
        angle -= 2.0 * math.pi
    elif angle <= -math.pi:
        angle += 2.0 * math.pi
    return angle


@inlined
def swing_twist_quaternion(axes, j, first, second, twist):  # type: ignore[no-untyped-def]
    """Return the quaternion exp(swing) exp(twist) of joint j.

    The swing vector is first a1 + second a2, the twist vector twist a3, with angles [rad] and the
    joint's axes (J, 3, 3).
    """
    x = first * axes[j, 0, 0] + second * axes[j, 1, 0]
    y = first * axes[j, 0, 1] + second * axes[j, 1, 1]
    z = first * axes[j, 0, 2] + second * axes[j, 1, 2]
    size = math.sqrt(x * x + y * y + z * z)
    scale = math.sin(0.5 * size) / size if size > 1e-9 else 0.5
    w = math.cos(0.5 * size)
    x = x * scale
    y = y * scale
    z = z * scale
    a = math.cos(0.5 * twist)
    b = math.sin(0.5 * twist)
    u = b * axes[j, 2, 0]
    v = b * axes[j, 2, 1]
    r = b * axes[j, 2, 2]
    return (
        w * a - x * u - y * v - z * r,
        w * u + x * a + y * r - z * v,
        w * v + y * a + z * u - x * r,
        w * r + z * a + x * v - y * u,
    )


@inlined
def twist_quaternion(axis, twist):  # type: ignore[no-untyped-def]
    """Quaternion of a turn by an angle [rad] about a unit axis."""
    s = math.sin(0.5 * twist)
    return math.cos(0.5 * twist), s * axis[0], s * axis[1], s * axis[2]


@inlined
def swing_twist_angles(q, axes):  # type: ignore[no-untyped-def]
    """Decompose a quaternion into exp(swing) exp(twist).

    Returns the components [rad] of the swing vector along the first two axes (3, 3), and the twist
    [rad] about the third, from -pi to pi.
    """
    axis = vector(axes[2])
    twist = 2.0 * math.atan2(dot((q[1], q[2], q[3]), axis), q[0])
    if twist > math.pi:
        twist -= 2.0 * math.pi
    elif twist < -math.pi:
        twist += 2.0 * math.pi
    swing = quaternion_product(q, conjugate(twist_quaternion(axis, twist)))
    turn = (swing[1], swing[2], swing[3])
    sine = norm(turn)
    # q and -q are one rotation: the one with a positive scalar part turns by less than pi
    sign = -1.0 if swing[0] < 0.0 else 1.0
    factor = 2.0
    if sine > 1e-12:
        factor = 2.0 * math.atan2(sine, sign * swing[0]) / sine
    factor *= sign
    return factor * dot(turn, vector(axes[0])), factor * dot(turn, vector(axes[1])), twist
