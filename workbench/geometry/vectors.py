"""Vectors, 3 x 3 matrices and quaternions as tuples, which compiled loops keep in registers.

A matrix is nine numbers, row by row; a quaternion is w, x, y, z. Each sum is taken from left to right, so that a formula gives
the same bits wherever it is written.
"""

from __future__ import annotations

import math

from workbench.compiled import inlined

__all__ = [
    "add",
    "conjugate",
    "cross",
    "dot",
    "matvec",
    "norm",
    "quaternion",
    "quaternion_product",
    "rotate",
    "rotation_part",
    "scale",
    "store",
    "subtract",
    "transpose_matvec",
    "vector",
]


@inlined
def vector(values):  # type: ignore[no-untyped-def]
    """Read the first three numbers of an array (3,) as a tuple."""
    return values[0], values[1], values[2]


@inlined
def store(a, out):  # type: ignore[no-untyped-def]
    """Write a vector into the first three numbers of an array."""
    out[0] = a[0]
    out[1] = a[1]
    out[2] = a[2]


@inlined
def add(a, b):  # type: ignore[no-untyped-def]
    """Sum a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def subtract(a, b):  # type: ignore[no-untyped-def]
    """Difference a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def scale(factor, a):  # type: ignore[no-untyped-def]
    """Product of a number and a vector."""
    return factor * a[0], factor * a[1], factor * a[2]


@inlined
def dot(a, b):  # type: ignore[no-untyped-def]
    """Scalar product a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a, b):  # type: ignore[no-untyped-def]
    """Vector product a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def norm(a):  # type: ignore[no-untyped-def]
    """Length of a vector."""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@inlined
def rotation_part(transform):  # type: ignore[no-untyped-def]
    """Read the rotation of a transform (3, 4) as nine numbers."""
    return (
        transform[0, 0],
        transform[0, 1],
        transform[0, 2],
        transform[1, 0],
        transform[1, 1],
        transform[1, 2],
        transform[2, 0],
        transform[2, 1],
        transform[2, 2],
    )


@inlined
def matvec(m, a):  # type: ignore[no-untyped-def]
    """Product of a matrix and a vector."""
    return (
        m[0] * a[0] + m[1] * a[1] + m[2] * a[2],
        m[3] * a[0] + m[4] * a[1] + m[5] * a[2],
        m[6] * a[0] + m[7] * a[1] + m[8] * a[2],
    )


@inlined
def transpose_matvec(m, a):  # type: ignore[no-untyped-def]
    """Product of a transposed matrix and a vector: the inverse rotation."""
    return (
        m[0] * a[0] + m[3] * a[1] + m[6] * a[2],
        m[1] * a[0] + m[4] * a[1] + m[7] * a[2],
        m[2] * a[0] + m[5] * a[1] + m[8] * a[2],
    )


@inlined
def quaternion(values):  # type: ignore[no-untyped-def]
    """Read the first four numbers of an array (4,) as a tuple."""
    return values[0], values[1], values[2], values[3]


@inlined
def conjugate(q):  # type: ignore[no-untyped-def]
    """Conjugate of a quaternion: the inverse rotation of a unit one."""
    return q[0], -q[1], -q[2], -q[3]


@inlined
def quaternion_product(a, b):  # type: ignore[no-untyped-def]
    """Product of two quaternions: first b, then a."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@inlined
def rotate(q, v):  # type: ignore[no-untyped-def]
    """Rotate a vector by a unit quaternion: v + w t + u x t with t = 2 u x v, u its last three."""
    x, y, z = v
    tx = 2 * (q[2] * z - q[3] * y)
    ty = 2 * (q[3] * x - q[1] * z)
    tz = 2 * (q[1] * y - q[2] * x)
    return (
        x + q[0] * tx + q[2] * tz - q[3] * ty,
        y + q[0] * ty + q[3] * tx - q[1] * tz,
        z + q[0] * tz + q[1] * ty - q[2] * tx,
    )
