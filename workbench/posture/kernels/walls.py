"""Walls that the spheres of a limb must stay behind, made of what they enter or are near to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit
from workbench.contact.kernels.inner import inlined, inner
from workbench.posture.kernels.contacts import wall
from workbench.posture.kernels.limits import Planes

__all__ = ["CLEAR", "MOST_WALLS", "Desk", "build", "new_desk"]

MOST_WALLS = 16
CLEAR = 2e-4
"""How far [m] beyond what is allowed a posture is kept off obstacles, so that rounding does not
touch them."""
SAME = 0.9
ALIKE = 0.95
"""Cosine between normals of walls before the same sphere that are taken to be one: over several
turns, at once."""


class Desk(NamedTuple):
    """Working space: walls (MOST_WALLS, 6): sphere, normal (3), height [m], part; the planes made
    of them; many (1,): how many there are. trial (1, K, 3), free (K, 3): angles; tried (M,): 1 for
    a seed that was used; kept (M, K, 3), depth (M,) [m]: postures to begin at and how deep they
    enter."""

    walls: NDArray[np.float64]
    planes: Planes
    many: NDArray[np.int64]
    trial: NDArray[np.float64]
    free: NDArray[np.float64]
    tried: NDArray[np.int64]
    kept: NDArray[np.float64]
    depth: NDArray[np.float64]


@njit(cache=True)
def new_desk(joints, seeds):  # type: ignore[no-untyped-def]
    """An empty working space."""
    planes = Planes(
        np.zeros(MOST_WALLS, np.int64),
        np.zeros((MOST_WALLS, 3)),
        np.zeros((MOST_WALLS, 3)),
        np.zeros(MOST_WALLS),
    )
    return Desk(
        np.zeros((MOST_WALLS, 6)),
        planes,
        np.zeros(1, np.int64),
        np.zeros((1, joints, 3)),
        np.zeros((joints, 3)),
        np.zeros(seeds, np.int64),
        np.zeros((seeds, joints, 3)),
        np.zeros(seeds),
    )


@inner
def _plane(limbs, b, room, space, desk):  # type: ignore[no-untyped-def]
    """Make planes of the walls for body b, whose spheres stand as they do in space."""
    walls = desk.walls
    planes = desk.planes
    centres = space.centres
    world = space.world
    for m in range(desk.many[0]):
        s = int(walls[m, 0])
        part = int(walls[m, 5])
        n0 = walls[m, 1]
        n1 = walls[m, 2]
        n2 = walls[m, 3]
        k = limbs.carrier[s]
        high = walls[m, 4]
        d0 = centres[0, s, 0] - world[0, k, 0, 3]
        d1 = centres[0, s, 1] - world[0, k, 1, 3]
        d2 = centres[0, s, 2] - world[0, k, 2, 3]
        for i in range(3):
            planes.point[m, i] = (
                world[0, k, 0, i] * d0 + world[0, k, 1, i] * d1 + world[0, k, 2, i] * d2
            )
        if room.field.root.shape[0] > 1 and room.moving[part] > 0:
            high += n0 * room.shift[b, 0] + n1 * room.shift[b, 1] + n2 * room.shift[b, 2]
        planes.link[m] = limbs.link[s]
        planes.normal[m, 0] = n0
        planes.normal[m, 1] = n1
        planes.normal[m, 2] = n2
        planes.offset[m] = (
            high + limbs.radius[b, s] - room.allowed[limbs.segment[s], part] + 2.0 * CLEAR
        )


@inlined
def _contrary(room, i, count, space):  # type: ignore[no-untyped-def]
    """Whether contact i is from outside a part that the same sphere's centre is inside of: it would
    push farther in."""
    found = space.found
    if found[0, i, 6] > 0.0:
        return False
    part = room.owner[int(found[0, i, 2])]
    for m in range(count):
        if (
            found[0, m, 6] > 0.0
            and found[0, m, 1] == found[0, i, 1]
            and room.owner[int(found[0, m, 2])] == part
        ):
            return True
    return False


@inner
def build(limbs, b, room, count, stops, anew, space, desk, work):  # type: ignore[no-untyped-def]
    """Walls of the `count` contacts in space, deepest first: new ones only where `anew`; else
    besides those there are, in the place of those they follow upon."""
    walls = desk.walls
    many = desk.many
    if anew:
        many[0] = 0
    for i in range(count):
        if _contrary(room, i, count, space):
            continue
        s, n0, n1, n2, high, part = wall(limbs, b, room, i, space)
        at = -1
        for m in range(many[0]):
            along = n0 * walls[m, 1] + n1 * walls[m, 2] + n2 * walls[m, 3]
            if int(walls[m, 0]) == s and along > (ALIKE if anew else SAME):
                at = m
        if at >= 0 and anew:
            continue
        if at < 0 and many[0] < MOST_WALLS:
            at = many[0]
            many[0] += 1
            work.press[stops + at] = 0.0
        elif at < 0:
            at = 0
            for m in range(1, MOST_WALLS):
                if work.press[stops + m] < work.press[stops + at]:
                    at = m
            work.press[stops + at] = 0.0
        walls[at, 0] = s
        walls[at, 1] = n0
        walls[at, 2] = n1
        walls[at, 3] = n2
        walls[at, 4] = high
        walls[at, 5] = part
    _plane(limbs, b, room, space, desk)
