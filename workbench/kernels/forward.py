"""Batch loops of forward kinematics: the chain of transforms, and the spheres in the world."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.kernels.rotation import product, quaternion_matrix, twist_angle

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

    centre (3, S): one coordinate after the other, so that the loops run on several spheres at once. out, across
    (3, S): each centre's arm from the line that its segment twists about, and that arm a quarter turn on. blend_joint
    (S,): -1 where rigid; blend_share (S,), blend_point (S, 3): the joint in the frame of the sphere's own segment;
    blended: the spheres that are, those of segment n being blended[blend_start[n]:blend_start[n + 1]]; distal (S,): 1
    where that segment is the joint's distal one; twist_shared (J,): 1 where the proximal one shares the twist.
    """

    centre: NDArray[np.float64]
    out: NDArray[np.float64]
    across: NDArray[np.float64]
    start: NDArray[np.int64]
    twist_joint: NDArray[np.int64]
    joint_axis: NDArray[np.float64]
    twist_axis: NDArray[np.float64]
    twist_share: NDArray[np.float64]
    shown: NDArray[np.int64]
    blend_joint: NDArray[np.int64]
    blend_share: NDArray[np.float64]
    blend_point: NDArray[np.float64]
    blended: NDArray[np.int64]
    blend_start: NDArray[np.int64]
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


@njit(cache=True, error_model="numpy", _nrt=False)
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


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _sine_cosine(x):  # type: ignore[no-untyped-def]
    """Sine and cosine for |x| <= pi / 2 by Taylor's series, below 2e-16 in error: nothing but products and sums, so
    that four spheres go at once."""
    y = x * x
    sine = 1.0 - y * (1 / 420) * (1.0 - y * (1 / 506))
    sine = 1.0 - y * (1 / 210) * (1.0 - y * (1 / 272) * (1.0 - y * (1 / 342) * sine))
    sine = 1.0 - y * (1 / 72) * (1.0 - y * (1 / 110) * (1.0 - y * (1 / 156) * sine))
    sine = x * (1.0 - y * (1 / 6) * (1.0 - y * (1 / 20) * (1.0 - y * (1 / 42) * sine)))
    cosine = 1.0 - y * (1 / 380) * (1.0 - y * (1 / 462))
    cosine = 1.0 - y * (1 / 182) * (1.0 - y * (1 / 240) * (1.0 - y * (1 / 306) * cosine))
    cosine = 1.0 - y * (1 / 56) * (1.0 - y * (1 / 90) * (1.0 - y * (1 / 132) * cosine))
    cosine = 1.0 - y * (1 / 2) * (1.0 - y * (1 / 12) * (1.0 - y * (1 / 30) * cosine))
    return sine, cosine


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _twist(q, skin, n, local):  # type: ignore[no-untyped-def]
    """Write the centres of segment n, each turned by its share of the twist of quaternion q, into local (3, S)."""
    axis, line = skin.joint_axis[skin.twist_joint[n]], skin.twist_axis[n]
    half = 0.5 * twist_angle(q[0], q[1], q[2], q[3], axis[0], axis[1], axis[2])
    if axis[0] * line[0] + axis[1] * line[1] + axis[2] * line[2] < 0.0:
        half = -half
    for s in range(np.uint64(skin.start[n]), np.uint64(skin.start[n + 1])):
        sine, cosine = _sine_cosine(skin.twist_share[s] * half)
        turn, less = 2.0 * sine * cosine, -2.0 * sine * sine
        local[0, s] = skin.centre[0, s] + less * skin.out[0, s] + turn * skin.across[0, s]
        local[1, s] = skin.centre[1, s] + less * skin.out[1, s] + turn * skin.across[1, s]
        local[2, s] = skin.centre[2, s] + less * skin.out[2, s] + turn * skin.across[2, s]


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _blend(rotations, p, skin, n, local):  # type: ignore[no-untyped-def]
    """Move the blended spheres of segment n in local (3, S) by their shares."""
    last = -1
    m = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    for i in range(skin.blend_start[n], skin.blend_start[n + 1]):
        s = skin.blended[i]
        b = skin.blend_joint[s]
        if b != last:
            m = _across(rotations[p, b], skin.joint_axis[b], skin.twist_shared[b], skin.distal[s])
            last = b
        x, y, z, share = local[0, s], local[1, s], local[2, s], skin.blend_share[s]
        u, v, w = x - skin.blend_point[s, 0], y - skin.blend_point[s, 1], z - skin.blend_point[s, 2]
        local[0, s] = x + share * (m[0] * u + m[1] * v + m[2] * w - u)
        local[1, s] = y + share * (m[3] * u + m[4] * v + m[5] * w - v)
        local[2, s] = z + share * (m[6] * u + m[7] * v + m[8] * w - w)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _carry(world, p, n, local, first, last, centres):  # type: ignore[no-untyped-def]
    """Carry the spheres first..last of local (3, S) into the world by the frame of segment n."""
    a, b, c, d = world[p, n, 0, 0], world[p, n, 0, 1], world[p, n, 0, 2], world[p, n, 0, 3]
    e, f, g, h = world[p, n, 1, 0], world[p, n, 1, 1], world[p, n, 1, 2], world[p, n, 1, 3]
    i, j, k, m = world[p, n, 2, 0], world[p, n, 2, 1], world[p, n, 2, 2], world[p, n, 2, 3]
    for s in range(np.uint64(first), np.uint64(last)):
        x, y, z = local[0, s], local[1, s], local[2, s]
        centres[p, s, 0] = a * x + b * y + c * z + d
        centres[p, s, 1] = e * x + f * y + g * z + h
        centres[p, s, 2] = i * x + j * y + k * z + m


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)
def place_spheres(rotations, world, skin, local, centres):  # type: ignore[no-untyped-def]
    """Fill centres (P, S, 3) for the shown segments: local centres, twisted by their share and blended, into the
    world. local (3, S): working space."""
    for p in range(world.shape[0]):
        for n in range(world.shape[1]):
            if skin.shown[n] == 0:
                continue
            first, last = skin.start[n], skin.start[n + 1]
            j, moves = skin.twist_joint[n], skin.blend_start[n + 1] > skin.blend_start[n]
            if j < 0 and not moves:
                _carry(world, p, n, skin.centre, first, last, centres)
                continue
            if j >= 0:
                _twist(rotations[p, j], skin, n, local)
            else:
                for s in range(first, last):
                    local[0, s], local[1, s], local[2, s] = skin.centre[0, s], skin.centre[1, s], skin.centre[2, s]
            if moves:
                _blend(rotations, p, skin, n, local)
            _carry(world, p, n, local, first, last, centres)
