"""Batch loops of forward kinematics: the chain of transforms, and the spheres in the world."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.kernels.rotation import product, quaternion_matrix, rotate_about, twist_angle

__all__ = ["Chain", "Skin", "chain_transforms", "place_spheres"]


class Chain(NamedTuple):
    """The tree walked from the reference segment: step m reaches segment `to` from `came` over `joint`.

    `upward` is 1 where the step goes from a distal segment to the proximal one. at_came, at_to: the joint's
    coordinates in both frames. The reference itself is not a step.
    """

    to: NDArray[np.int64]
    came: NDArray[np.int64]
    joint: NDArray[np.int64]
    upward: NDArray[np.int64]
    at_came: NDArray[np.float64]
    at_to: NDArray[np.float64]


class Skin(NamedTuple):
    """The spheres of a body and how they share the twist of a joint; `shown` (N,) is 1 in the window.

    blend_joint (S,): -1 where rigid; blend_share (S,), blend_point (S, 3): the joint in the frame of the sphere's own
    segment; distal (S,): 1 where that segment is the joint's distal one; twist_shared (J,): 1 where the proximal one
    shares the twist.
    """

    centre: NDArray[np.float64]
    start: NDArray[np.int64]
    twist_joint: NDArray[np.int64]
    joint_axis: NDArray[np.float64]
    twist_point: NDArray[np.float64]
    twist_axis: NDArray[np.float64]
    twist_share: NDArray[np.float64]
    shown: NDArray[np.int64]
    blend_joint: NDArray[np.int64]
    blend_share: NDArray[np.float64]
    blend_point: NDArray[np.float64]
    distal: NDArray[np.int64]
    twist_shared: NDArray[np.int64]


@njit(cache=True)
def chain_transforms(rotations, chain, first, world):  # type: ignore[no-untyped-def]
    """Fill world (P, N, 3, 4) for the steps `first` onward; what earlier steps reached must be filled already."""
    for p in range(world.shape[0]):
        for m in range(first, chain.to.shape[0]):
            to, came, j = chain.to[m], chain.came[m], chain.joint[m]
            q = rotations[p, j]
            r = quaternion_matrix(q[0], q[1], q[2], q[3])
            for i in range(3):
                u, v, w = world[p, came, i, 0], world[p, came, i, 1], world[p, came, i, 2]
                if chain.upward[m]:
                    a = u * r[0] + v * r[1] + w * r[2]
                    b = u * r[3] + v * r[4] + w * r[5]
                    c = u * r[6] + v * r[7] + w * r[8]
                else:
                    a = u * r[0] + v * r[3] + w * r[6]
                    b = u * r[1] + v * r[4] + w * r[7]
                    c = u * r[2] + v * r[5] + w * r[8]
                joint = u * chain.at_came[m, 0] + v * chain.at_came[m, 1] + w * chain.at_came[m, 2]
                back = a * chain.at_to[m, 0] + b * chain.at_to[m, 1] + c * chain.at_to[m, 2]
                world[p, to, i, 0], world[p, to, i, 1], world[p, to, i, 2] = a, b, c
                world[p, to, i, 3] = world[p, came, i, 3] + joint - back


@njit(cache=True, inline="always")
def _across(q, axis, shared, distal):  # type: ignore[no-untyped-def]
    """The rotation that carries a point of one segment of a joint along with the other segment, in the frame of the
    first: Q, or for the distal one its inverse; without the twist T where the proximal segment shares it.

    Q = S T: of the swing alone S for the proximal segment, and T' S' T for the distal one, which has the twist.
    """
    r = quaternion_matrix(q[0], q[1], q[2], q[3])
    if shared == 0:
        return r if distal == 0 else (r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8])
    along = q[1] * axis[0] + q[2] * axis[1] + q[3] * axis[2]
    w, x, y, z = q[0], along * axis[0], along * axis[1], along * axis[2]
    if w * w + along * along < 1e-24:  # half a turn of swing: no twist can be told from it
        w = 1.0
    t = quaternion_matrix(w, x, y, z)
    s = product(r, (t[0], t[3], t[6], t[1], t[4], t[7], t[2], t[5], t[8]))
    if distal == 0:
        return s
    back = product((s[0], s[3], s[6], s[1], s[4], s[7], s[2], s[5], s[8]), t)
    return product((t[0], t[3], t[6], t[1], t[4], t[7], t[2], t[5], t[8]), back)


@njit(cache=True)
def place_spheres(rotations, world, skin, centres):  # type: ignore[no-untyped-def]
    """Fill centres (P, S, 3) for the shown segments: local centres, twisted by their share and blended, into the
    world."""
    for p in range(world.shape[0]):
        for n in range(world.shape[1]):
            if skin.shown[n] == 0:
                continue
            angle, last = 0.0, -1
            m = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
            j = skin.twist_joint[n]
            line, point = skin.twist_axis[n], skin.twist_point[n]
            if j >= 0:
                q, axis = rotations[p, j], skin.joint_axis[j]
                angle = twist_angle(q[0], q[1], q[2], q[3], axis[0], axis[1], axis[2])
                if axis[0] * line[0] + axis[1] * line[1] + axis[2] * line[2] < 0.0:
                    angle = -angle
            for s in range(skin.start[n], skin.start[n + 1]):
                x, y, z = skin.centre[s, 0], skin.centre[s, 1], skin.centre[s, 2]
                share = skin.twist_share[s]
                if share > 0.0 and angle != 0.0:
                    x, y, z = rotate_about(
                        x - point[0], y - point[1], z - point[2], line[0], line[1], line[2], share * angle
                    )
                    x, y, z = x + point[0], y + point[1], z + point[2]
                b = skin.blend_joint[s]
                if b >= 0 and skin.blend_share[s] > 0.0:
                    if b != last:
                        m = _across(rotations[p, b], skin.joint_axis[b], skin.twist_shared[b], skin.distal[s])
                        last = b
                    u, v, w = x - skin.blend_point[s, 0], y - skin.blend_point[s, 1], z - skin.blend_point[s, 2]
                    x += skin.blend_share[s] * (m[0] * u + m[1] * v + m[2] * w - u)
                    y += skin.blend_share[s] * (m[3] * u + m[4] * v + m[5] * w - v)
                    z += skin.blend_share[s] * (m[6] * u + m[7] * v + m[8] * w - w)
                for i in range(3):
                    t = world[p, n, i]
                    centres[p, s, i] = t[0] * x + t[1] * y + t[2] * z + t[3]
