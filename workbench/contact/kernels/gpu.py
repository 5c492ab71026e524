"""The batch loops of forward kinematics and clearance on a CUDA device: a thread a pose, the same
functions.

numba-cuda compiles a function that was compiled for the processor anew for the device where a
kernel calls it, so there is no second copy of the mathematics. Importing this module needs
numba-cuda (or its simulator).
"""

from __future__ import annotations

import numpy as np
from numba import config, cuda, float32, int64

from workbench.body.kernels.forward import chain_transforms, place_spheres
from workbench.contact.kernels.groups import group_clearance, group_collides
from workbench.contact.kernels.wide import DEEP, EIGHT

__all__ = [
    "THREADS",
    "clearance_kernel",
    "collide_kernel",
    "device_count",
    "place_kernel",
    "to_device",
    "to_host",
]

THREADS = 64
"""Threads of a block; a pose is a long walk with many branches, so larger blocks only wait for
their last one."""

ROOM = DEEP + EIGHT
"""Numbers a search keeps of the boxes it has still to visit."""


def device_count() -> int:
    """How many CUDA devices there are; 0 where there is no driver."""
    return len(cuda.gpus) if cuda.is_available() else 0


def to_device(values):  # type: ignore[no-untyped-def]
    """An array, or a tuple of arrays (named or not), in the device's memory; numbers stay what they
    are."""
    if isinstance(values, tuple):
        moved = [to_device(item) for item in values]
        return type(values)(*moved) if hasattr(values, "_fields") else tuple(moved)
    if not hasattr(values, "shape"):
        return values
    # the simulator's own arrays cannot be handed on to compiled functions
    return np.array(values) if config.ENABLE_CUDASIM else cuda.to_device(values)


def to_host(values):  # type: ignore[no-untyped-def]
    """An array of the device's memory as an array here."""
    return values if isinstance(values, np.ndarray) else values.copy_to_host()


@cuda.jit
def place_kernel(placed, walk):  # type: ignore[no-untyped-def]
    """Forward kinematics of every pose.

    placed: rotations (P, J, 4), centres (P, S, 3), world (P, N, 3, 4), where the reference
    segment's transform stands already; walk: Chain, Skin.
    """
    rotations, centres, world = placed
    chain, skin = walk
    for p in range(cuda.grid(1), world.shape[0], cuda.gridsize(1)):
        chain_transforms(rotations[p : p + 1], chain, 0, world[p : p + 1])
        place_spheres(rotations[p : p + 1], world[p : p + 1], skin, centres[p : p + 1])


@cuda.jit
def collide_kernel(placed, index, answer, space):  # type: ignore[no-untyped-def]
    """`group_collides` for every pose.

    placed: centres (P, S, 3), world (P, N, 3, 4); index: Crowd, Faces, Shells, Field; answer:
    allowed (N, G), hit (P,); space: key (N G, T), pair (N G, T), a column for each of the T
    threads.
    """
    centres, world = placed
    crowd, faces, shells, field = index
    allowed, hit = answer
    thread = cuda.grid(1)
    stack = cuda.local.array(DEEP, int64)
    gaps = cuda.local.array(ROOM, float32)
    mine = (stack, gaps, space[0][:, thread], space[1][:, thread])
    for p in range(thread, hit.shape[0], cuda.gridsize(1)):
        group_collides(centres, world, crowd, faces, shells, field, allowed, hit, mine, p, p + 1)


@cuda.jit
def clearance_kernel(placed, index, answer, space):  # type: ignore[no-untyped-def]
    """`group_clearance` for every pose.

    placed, index as above; answer: distance, sphere, polygon (P, N, G); space: lows (clusters, T),
    low (S, T).
    """
    centres, world = placed
    crowd, faces, shells, field = index
    thread = cuda.grid(1)
    stack = cuda.local.array(DEEP, int64)
    gaps = cuda.local.array(ROOM, float32)
    mine = (stack, gaps, space[0][:, thread], space[1][:, thread])
    for p in range(thread, answer[0].shape[0], cuda.gridsize(1)):
        group_clearance(centres, world, crowd, faces, shells, field, answer, mine, p, p + 1)
