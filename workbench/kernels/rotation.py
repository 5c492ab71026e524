"""Scalar rotation functions: quaternions are w, x, y, z."""

from __future__ import annotations

import math

from numba import njit

__all__ = ["product", "quaternion_matrix", "rotate_about", "twist_angle"]


@njit(cache=True, inline="always")
def quaternion_matrix(w, x, y, z):  # type: ignore[no-untyped-def]
    """The nine entries, row by row, of the rotation matrix of a quaternion, which is normalised first."""
    n = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w * n, x * n, y * n, z * n
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


@njit(cache=True, inline="always")
def product(a, b):  # type: ignore[no-untyped-def]
    """The nine entries of the product of two 3 x 3 matrices given row by row."""
    return (
        a[0] * b[0] + a[1] * b[3] + a[2] * b[6], a[0] * b[1] + a[1] * b[4] + a[2] * b[7],
        a[0] * b[2] + a[1] * b[5] + a[2] * b[8], a[3] * b[0] + a[4] * b[3] + a[5] * b[6],
        a[3] * b[1] + a[4] * b[4] + a[5] * b[7], a[3] * b[2] + a[4] * b[5] + a[5] * b[8],
        a[6] * b[0] + a[7] * b[3] + a[8] * b[6], a[6] * b[1] + a[7] * b[4] + a[8] * b[7],
        a[6] * b[2] + a[7] * b[5] + a[8] * b[8],
    )  # fmt: skip


@njit(cache=True, inline="always")
def twist_angle(w, x, y, z, a, b, c):  # type: ignore[no-untyped-def]
    """Angle [rad] in (-pi, pi] of the twist of a quaternion about the unit axis (a, b, c): facts of swing and twist."""
    angle = 2.0 * math.atan2(x * a + y * b + z * c, w)
    if angle > math.pi:
        angle -= 2.0 * math.pi
    elif angle <= -math.pi:
        angle += 2.0 * math.pi
    return angle


@njit(cache=True, inline="always")
def rotate_about(x, y, z, a, b, c, angle):  # type: ignore[no-untyped-def]
    """A vector turned by `angle` [rad] about the unit axis (a, b, c): Rodrigues' formula."""
    co, si = math.cos(angle), math.sin(angle)
    k = (a * x + b * y + c * z) * (1.0 - co)
    return (
        x * co + (b * z - c * y) * si + a * k,
        y * co + (c * x - a * z) * si + b * k,
        z * co + (a * y - b * x) * si + c * k,
    )
