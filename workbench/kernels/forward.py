"""Batch loops of forward kinematics: the chain of transforms, and the spheres in the world."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.kernels.rotation import quaternion_matrix, rotate_about, twist_angle

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
    """The spheres of a body and how they share the twist of a joint; `shown` (N,) is 1 in the window."""

    centre: NDArray[np.float64]
    start: NDArray[np.int64]
    twist_joint: NDArray[np.int64]
    joint_axis: NDArray[np.float64]
    twist_point: NDArray[np.float64]
    twist_axis: NDArray[np.float64]
    twist_share: NDArray[np.float64]
    shown: NDArray[np.int64]


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


@njit(cache=True)
def place_spheres(rotations, world, skin, centres):  # type: ignore[no-untyped-def]
    """Fill centres (P, S, 3) for the shown segments: local centres, twisted by their share, into the world."""
    for p in range(world.shape[0]):
        for n in range(world.shape[1]):
            if skin.shown[n] == 0:
                continue
            angle = 0.0
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
                for i in range(3):
                    t = world[p, n, i]
                    centres[p, s, i] = t[0] * x + t[1] * y + t[2] * z + t[3]
