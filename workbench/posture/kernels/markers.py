"""Joint angles from markers: weighted least squares on the whole chain, frame after frame (Lu &
O'Connor 1999)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.rotation import quaternion_matrix
from workbench.compiled import njit

__all__ = ["MarkerChain", "solve_markers"]

_STEPS = 12
_MOST_TURN = 0.6
_CLOSE = 1e-5


class MarkerChain(NamedTuple):
    """A body as a chain below its placed segment, and markers on it.

    segment k hangs on segment parent[k] (0: the placed one) by joint k - 1; at_parent, at_child:
    the joint in both frames; axes (K, 3, 3): two swing axes and the twist axis of each joint; half
    (K, 3): the angle [rad] that costs as much as a marker one unit off; marker_segment (M,), local
    (M, 3) [m], weight (M,) [1/m].
    """

    parent: NDArray[np.int64]
    at_parent: NDArray[np.float64]
    at_child: NDArray[np.float64]
    axes: NDArray[np.float64]
    half: NDArray[np.float64]
    marker_segment: NDArray[np.int64]
    local: NDArray[np.float64]
    weight: NDArray[np.float64]


@njit(cache=True, inline="always")
def _product(a, b, out):  # type: ignore[no-untyped-def]
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]


@njit(cache=True)
def _turned(q, x, y, z):  # type: ignore[no-untyped-def]
    """q turned further by a rotation vector in the outer frame, of unit length."""
    angle = np.sqrt(x * x + y * y + z * z)
    s = 0.5 - angle * angle / 48.0 if angle < 1e-4 else np.sin(0.5 * angle) / angle
    step = np.empty(4)
    out = np.empty(4)
    step[0] = np.cos(0.5 * angle)
    step[1] = s * x
    step[2] = s * y
    step[3] = s * z
    _product(step, q, out)
    return out / np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2 + out[3] ** 2)


@njit(cache=True)
def _angles(q, axes, out):  # type: ignore[no-untyped-def]
    """The two components of the swing vector and the twist of a joint."""
    along = q[1] * axes[2, 0] + q[2] * axes[2, 1] + q[3] * axes[2, 2]
    twist = 2.0 * np.arctan2(along, q[0])
    if twist > np.pi:
        twist -= 2.0 * np.pi
    elif twist < -np.pi:
        twist += 2.0 * np.pi
    back = np.empty(4)
    swing = np.empty(4)
    c = np.cos(0.5 * twist)
    s = -np.sin(0.5 * twist)
    back[0] = c
    back[1] = s * axes[2, 0]
    back[2] = s * axes[2, 1]
    back[3] = s * axes[2, 2]
    _product(q, back, swing)
    if swing[0] < 0.0:
        swing *= -1.0
    sine = np.sqrt(swing[1] ** 2 + swing[2] ** 2 + swing[3] ** 2)
    scale = 2.0 if sine < 1e-12 else 2.0 * np.arctan2(sine, swing[0]) / sine
    for k in range(2):
        out[k] = scale * (swing[1] * axes[k, 0] + swing[2] * axes[k, 1] + swing[3] * axes[k, 2])
    out[2] = twist


@njit(cache=True)
def _chain(rotations, place, chain, world, joint):  # type: ignore[no-untyped-def]
    world[0] = place
    for k in range(1, chain.parent.shape[0]):
        p = chain.parent[k]
        q = rotations[k]
        r = quaternion_matrix(q[0], q[1], q[2], q[3])
        for i in range(3):
            u = world[p, i, 0]
            v = world[p, i, 1]
            w = world[p, i, 2]
            a = u * r[0] + v * r[3] + w * r[6]
            b = u * r[1] + v * r[4] + w * r[7]
            c = u * r[2] + v * r[5] + w * r[8]
            at = chain.at_parent[k]
            joint[k, i] = world[p, i, 3] + u * at[0] + v * at[1] + w * at[2]
            back = chain.at_child[k]
            world[k, i, 0] = a
            world[k, i, 1] = b
            world[k, i, 2] = c
            world[k, i, 3] = joint[k, i] - (a * back[0] + b * back[1] + c * back[2])


@njit(cache=True)
def _add(matrix, right, at, other, blocks):  # type: ignore[no-untyped-def]
    """Add one block pair's product to the normal matrix; where both are the same, the right side
    too."""
    one, two, gap = blocks
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += one[k, i] * two[k, j]
            matrix[3 * at + i, 3 * other + j] += total
        if at == other:
            for k in range(3):
                right[3 * at + i] += one[k, i] * gap[k]


@njit(cache=True)
def _marker_rows(seen, chain, state, system):  # type: ignore[no-untyped-def]
    """Normal equations of the markers seen; block 0 turns the placed segment, K moves it, k turns
    joint k."""
    world, joint = state
    matrix, right = system
    count = chain.parent.shape[0]
    path = np.empty(16, np.int64)
    blocks = np.empty((16, 3, 3))
    gap = np.empty(3)
    p = np.empty(3)
    for m in range(seen.shape[0]):
        if not np.isfinite(seen[m, 0]):
            continue
        n = chain.marker_segment[m]
        w = chain.weight[m]
        for i in range(3):
            p[i] = world[n, i, 3]
            for j in range(3):
                p[i] += world[n, i, j] * chain.local[m, j]
            gap[i] = w * (seen[m, i] - p[i])
        length = 0
        k = n
        while True:
            about = world[0, :, 3] if k == 0 else joint[k]
            x = w * (p[0] - about[0])
            y = w * (p[1] - about[1])
            z = w * (p[2] - about[2])
            path[length] = k
            block = blocks[length]
            block[0, 0] = block[1, 1] = block[2, 2] = 0.0
            block[0, 1] = z
            block[0, 2] = -y
            block[1, 0] = -z
            block[1, 2] = x
            block[2, 0] = y
            block[2, 1] = -x
            length += 1
            if k == 0:
                break
            k = chain.parent[k]
        path[length] = count
        blocks[length] = 0.0
        for i in range(3):
            blocks[length, i, i] = w
        for a in range(length + 1):
            for b in range(length + 1):
                _add(matrix, right, path[a], path[b], (blocks[a], blocks[b], gap))


@njit(cache=True)
def _joint_rows(rotations, chain, state, system):  # type: ignore[no-untyped-def]
    """Normal equations of the pull of each joint toward its neutral angles, by differences."""
    world, _ = state
    matrix, right = system
    now = np.empty(3)
    near = np.empty(3)
    block = np.empty((3, 3))
    gap = np.empty(3)
    for k in range(1, chain.parent.shape[0]):
        _angles(rotations[k], chain.axes[k], now)
        p = chain.parent[k]
        for j in range(3):
            turned = _turned(
                rotations[k], 1e-6 * world[p, j, 0], 1e-6 * world[p, j, 1], 1e-6 * world[p, j, 2]
            )
            _angles(turned, chain.axes[k], near)
            for i in range(3):
                block[i, j] = 1e6 * (near[i] - now[i]) / chain.half[k, i]
        for i in range(3):
            gap[i] = -now[i] / chain.half[k, i]
        _add(matrix, right, k, k, (block, block, gap))


@njit(cache=True)
def _solved(matrix, right):  # type: ignore[no-untyped-def]
    """Solve a positive definite system in place by Cholesky's method."""
    n = right.shape[0]
    for j in range(n):
        for k in range(j):
            matrix[j, j] -= matrix[j, k] ** 2
        matrix[j, j] = np.sqrt(max(matrix[j, j], 1e-12))
        for i in range(j + 1, n):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = total / matrix[j, j]
    for i in range(n):
        for k in range(i):
            right[i] -= matrix[i, k] * right[k]
        right[i] /= matrix[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            right[i] -= matrix[k, i] * right[k]
        right[i] /= matrix[i, i]


@njit(cache=True)
def _advance(rotations, turn, place, chain, step, world):  # type: ignore[no-untyped-def]
    """Turn and move everything by a step; returns the largest turn [rad] or move [m]."""
    count = chain.parent.shape[0]
    most = 0.0
    for k in range(count + 1):
        x = step[3 * k]
        y = step[3 * k + 1]
        z = step[3 * k + 2]
        size = np.sqrt(x * x + y * y + z * z)
        most = max(most, size)
        if k == count:
            place[0, 3] += x
            place[1, 3] += y
            place[2, 3] += z
            break
        if size > _MOST_TURN:
            x = x * _MOST_TURN / size
            y = y * _MOST_TURN / size
            z = z * _MOST_TURN / size
        if k == 0:
            turn[:] = _turned(turn, x, y, z)
            continue
        f = world[chain.parent[k]]
        rotations[k] = _turned(
            rotations[k],
            f[0, 0] * x + f[1, 0] * y + f[2, 0] * z,
            f[0, 1] * x + f[1, 1] * y + f[2, 1] * z,
            f[0, 2] * x + f[1, 2] * y + f[2, 2] * z,
        )
    r = quaternion_matrix(turn[0], turn[1], turn[2], turn[3])
    for i in range(3):
        for j in range(3):
            place[i, j] = r[3 * i + j]
    return most


@njit(cache=True, nogil=True)
def solve_markers(seen, chain, rotations, turns, places, modelled):  # type: ignore[no-untyped-def]
    """Fill rotations (P, K, 4), turns (P, 4) and places (P, 3, 4) of the placed segment, and
    modelled (P, M, 3).

    seen (P, M, 3): NaN where a marker was not seen. The first frame starts from what the arrays
    hold, every other from the one before it.
    """
    count = chain.parent.shape[0]
    world = np.empty((count, 3, 4))
    joint = np.zeros((count, 3))
    size = 3 * (count + 1)
    for p in range(seen.shape[0]):
        if p:
            rotations[p] = rotations[p - 1]
            turns[p] = turns[p - 1]
            places[p] = places[p - 1]
        for _ in range(_STEPS if p else 5 * _STEPS):
            _chain(rotations[p], places[p], chain, world, joint)
            matrix = np.zeros((size, size))
            right = np.zeros(size)
            for i in range(size):
                matrix[i, i] = 1e-6
            _marker_rows(seen[p], chain, (world, joint), (matrix, right))
            _joint_rows(rotations[p], chain, (world, joint), (matrix, right))
            _solved(matrix, right)
            if _advance(rotations[p], turns[p], places[p], chain, right, world) < _CLOSE:
                break
        _chain(rotations[p], places[p], chain, world, joint)
        for m in range(seen.shape[1]):
            n = chain.marker_segment[m]
            for i in range(3):
                modelled[p, m, i] = world[n, i, 3]
                for j in range(3):
                    modelled[p, m, i] += world[n, i, j] * chain.local[m, j]
