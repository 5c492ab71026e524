"""A proof that a hand has no room at a target, however it is turned.

The tip stays on the target and the hand is rigid, so all there is to choose is a rotation. The
rotations are the rotation vectors within a ball of radius pi. A cube of these with half an edge h
holds rotations within the angle a = sqrt(3) h of the one in its middle (Hartley & Kahl 2009, Global
optimization through rotation space search, lemmas 1 and 2). A sphere of the hand with its centre d
from the tip moves by 2 d sin(a / 2) at most within the cube. So where it is deeper in a part than
that, beyond what the part allows, no rotation of the cube keeps it out. A cube of which that is not
known is cut into eight.

The proof asks only the parts that stay where they are, and nothing of the rest of the body. It holds
for every position of the seat, every posture and every harness zone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import inlined, inner
from workbench.geometry.vectors import add, matvec, norm, store, subtract, vector
from workbench.posture.kernels.chain_kinematics import rotation_of
from workbench.posture.kernels.limb_contacts import contact_of_sphere

__all__ = ["ProofWorkspace", "has_no_room", "most_allowed", "new_turns"]

MOST_CUBES = 40_000
"""Cubes after which no proof is sought any more."""
LEAST_EDGE = math.pi / 256
"""Half the edge [rad] of a cube that is not cut again: then there is no proof."""
SURELY = 1e-6
"""[m] How much more than is allowed a proof wants, so that rounding does not make one."""
STACKED = 128
"""Cubes that wait at most: seven of each size, and the eight of the last cut."""
ROOT_3 = math.sqrt(3.0)
STILL = 0
"""The group of the parts that stay where they are."""


class ProofWorkspace(NamedTuple):
    """Working space of a proof."""

    middle: NDArray[np.float64]
    """(STACKED, 3) [rad] the middles of the cubes that wait."""
    half: NDArray[np.float64]
    """(STACKED,) [rad] half their edges."""


def new_turns() -> ProofWorkspace:
    """Make the working space of a proof."""
    return ProofWorkspace(np.zeros((STACKED, 3)), np.zeros(STACKED))


@inlined
def _box_gap(point, span, m):  # type: ignore[no-untyped-def]
    """Square of the distance [m2] of a point from the box span[m] (low, high), 0 within."""
    square = 0.0
    for axis in range(3):
        gap = max(max(span[m, axis] - point[axis], point[axis] - span[m, 3 + axis]), 0.0)
        square += gap * gap
    return square


@inlined
def most_allowed(room, g, n, part, point, arm, depth):  # type: ignore[no-untyped-def]
    """The most [m] that a part allows segment n if it may be what a centre is deepest in: the part
    `part`, or another solid of group g. The centre is within `arm` of a point, and at least `depth`
    deep in that solid.

    No point is deeper in a solid than half the least extent of its box.
    """
    field = room.field
    most = room.allowed[n, part]
    for m in range(field.solid_start[g], field.solid_start[g + 1]):
        span = field.solid_span
        thick = span[m, 3] - span[m, 0]
        for axis in range(1, 3):
            thick = min(thick, span[m, 3 + axis] - span[m, axis])
        if 0.5 * thick >= depth and _box_gap(point, span, m) <= arm * arm:
            most = max(most, room.allowed[n, field.solid_part[m]])
    return most


@inlined
def _stays_in(limbs, b, room, s, point, moved, space):  # type: ignore[no-untyped-def]
    """Whether sphere s of body b, deepest in what `space.found` has first, is kept from nowhere
    within `moved` [m] of its centre: it enters more than is allowed all over there.

    A polygon that its surface enters stays entered by as much less. Inside a solid the lemma of
    `clear_reach` applies: the solid that the centre is deepest in may be another one there.
    """
    excess = space.found[0, 0, 0]
    if space.found[0, 0, 6] == 0.0:
        return excess > moved + SURELY
    n = limbs.segment[s]
    part = room.owner[int(space.found[0, 0, 2])]
    depth = excess - limbs.radius[b, s] + room.allowed[n, part]
    allowed = most_allowed(room, STILL, n, part, point, moved, max(0.0, depth - moved))
    return limbs.radius[b, s] + depth - moved - allowed > SURELY


@inlined
def _cut(turns, size, middle, half):  # type: ignore[no-untyped-def]
    """Put the eight parts of a cube on the stack, without those outside the ball of rotations;
    returns its new size."""
    half = 0.5 * half
    for corner in range(8):
        part = (
            middle[0] + (half if corner & 1 else -half),
            middle[1] + (half if corner & 2 else -half),
            middle[2] + (half if corner & 4 else -half),
        )
        if norm(part) - ROOT_3 * half <= math.pi:
            store(part, turns.middle[size])
            turns.half[size] = half
            size += 1
    return size


@inner
def has_no_room(limbs, b, room, target, slack, turns, space):  # type: ignore[no-untyped-def]
    """Prove that no rotation of a hand about its target keeps it out of the parts that stay.

    Parameters
    ----------
    limbs : Limbs
        Limbs of B bodies.
    b : int
        Row of the body.
    room : Obstacles
        The parts.
    target : tuple of three
        [m] in the world.
    slack : float
        How far [m] the tip may be from it.
    turns, space
        Working space.

    Returns
    -------
    bool
        False where there is such a rotation, and where it is not known.
    """
    if room.field.trees.root[STILL] < 0:
        return False
    tip = vector(limbs.tip[b])
    turns.middle[0, :] = 0.0
    turns.half[0] = math.pi
    size = 1
    first = 0  # the sphere that a cube was given up for last
    spheres = limbs.rigid.shape[0]
    for _ in range(MOST_CUBES):
        if size == 0:
            return spheres > 0
        size -= 1
        middle = vector(turns.middle[size])
        half = turns.half[size]
        turn = rotation_of(middle)
        reach = 2.0 * math.sin(0.5 * min(ROOT_3 * half, math.pi))
        clear = True
        kept = False
        for i in range(spheres):
            k = (first + i) % spheres
            s = limbs.rigid[k]
            arm = subtract(
                (limbs.centre[b, 0, s], limbs.centre[b, 1, s], limbs.centre[b, 2, s]), tip
            )
            point = add(target, matvec(turn, arm))
            if contact_of_sphere(limbs, b, room, STILL, s, point, space) > 0:
                clear = False
                if _stays_in(limbs, b, room, s, point, norm(arm) * reach + slack, space):
                    kept = True
                    first = k
                    break
        if kept:
            continue
        if clear or half <= LEAST_EDGE:
            return False
        size = _cut(turns, size, middle, half)
    return False
