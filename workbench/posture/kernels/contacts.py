"""What the spheres of limbs of a family's bodies enter, and planes that they must stay behind.

A search places one limb again and again, a little farther each time, and most of its spheres are far
from everything. So of each sphere it is kept where it was last looked at, and how far it was from
all parts at least: as long as it has not moved as far, it touches nothing. What is found is the
same with and without what is kept, to the last bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.forward import Chain, Skin, chain_transforms, place_spheres
from workbench.compiled import inlined, inner, njit
from workbench.contact.kernels.field import Field, deepest, record_gap, square_bound
from workbench.contact.kernels.heads import near_heads
from workbench.contact.kernels.inside import Shells
from workbench.contact.kernels.wide import DEEP, EIGHT, near_boxes, point_lanes
from workbench.geometry.lanes import first_bit
from workbench.geometry.polygon import Faces, point_polygon
from workbench.geometry.tree import wider

__all__ = [
    "DEEPEST",
    "Limbs",
    "Obstacles",
    "Space",
    "forget",
    "least_heights",
    "limb_contacts",
    "new_space",
    "plane_of_contact",
    "touch",
]


DEEPEST = 16
"""Contacts of a limb that are found, the deepest."""
GROUPS = 2
"""Groups of parts: those that stay, and those that stand aside for each body."""
WIDER = 5e-3
"""How much farther [m] than asked for is looked for polygons, so that it need not be done again
soon."""
ROUNDING = 1e-9
"""Rounding [m] of the distance that a sphere has moved."""


class Obstacles(NamedTuple):
    """Parts in the way: faces, shells, field, whose second group of parts stands aside by shift (B,
    3) [m] for each body; owner (F,) the part of each polygon, allowed (N, parts) [m], moving
    (parts,): 1 in the second group, normal (F, 3), least (N, groups) [m] that is allowed anywhere
    in a group."""

    faces: Faces
    shells: Shells
    field: Field
    owner: NDArray[np.int64]
    allowed: NDArray[np.float64]
    moving: NDArray[np.int64]
    normal: NDArray[np.float64]
    least: NDArray[np.float64]
    shift: NDArray[np.float64]


class Space(NamedTuple):
    """Working space of one limb at a time."""

    rotations: NDArray[np.float64]
    """(1, J, 4) of all joints."""
    world: NDArray[np.float64]
    """(1, N, 3, 4) the segments that go along."""
    centres: NDArray[np.float64]
    """(1, S, 3) [m] their spheres."""
    stack: NDArray[np.int64]
    gaps: NDArray[np.float32]
    """Working space of the trees of polygons."""
    found: NDArray[np.float64]
    """(1, DEEPEST, 7) the contacts: excess [m], sphere, polygon, point (3) [m], 1 where the centre
    is inside."""
    last: NDArray[np.float64]
    """(groups, S, 3) [m] where a sphere was last looked at, in its group's own frame."""
    gap: NDArray[np.float64]
    """(groups, S) [m] how far its centre was from all surfaces of the group at least; -1 where it
    is not known, or the centre is inside."""


@njit(cache=True)
def new_space(limbs, joints):  # type: ignore[no-untyped-def]
    """An empty working space for bodies of so many joints."""
    spheres = limbs.centre.shape[2]
    segments = limbs.skin.shown.shape[0]
    return Space(
        np.zeros((1, joints, 4)),
        np.zeros((1, segments, 3, 4)),
        np.zeros((1, spheres, 3)),
        np.empty(DEEP, np.int64),
        np.empty(DEEP + EIGHT, np.float32),
        np.zeros((1, DEEPEST, 7)),
        np.zeros((GROUPS, spheres, 3)),
        np.full((GROUPS, spheres), -1.0),
    )


@inlined
def forget(space):  # type: ignore[no-untyped-def]
    """Forget how far spheres were from all parts: others are looked at, or parts have moved."""
    for g in range(space.gap.shape[0]):
        for s in range(space.gap.shape[1]):
            space.gap[g, s] = -1.0


class Limbs(NamedTuple):
    """The moving segments of B bodies of a family, S spheres of theirs: skin, chain as for one
    body; of each body its own centre, out, across (B, 3, S), radius, twist_share, blend_share (B,
    S), twist_axis (B, N, 3), blend_point (B, S, 3), at_came, at_to (B, M, 3).

    solid (B, S): those that may meet obstacles; segment (S,); link (S,): the link of the chain that
    carries each, carrier (S,): that link's segment. joint (K,): the body's joints of the chain,
    free (K,): 1 where they turn. base: the held segment.
    """

    skin: Skin
    chain: Chain
    centre: NDArray[np.float64]
    out: NDArray[np.float64]
    across: NDArray[np.float64]
    radius: NDArray[np.float64]
    twist_axis: NDArray[np.float64]
    twist_share: NDArray[np.float64]
    blend_share: NDArray[np.float64]
    blend_point: NDArray[np.float64]
    at_came: NDArray[np.float64]
    at_to: NDArray[np.float64]
    solid: NDArray[np.int64]
    segment: NDArray[np.int64]
    link: NDArray[np.int64]
    carrier: NDArray[np.int64]
    joint: NDArray[np.int64]
    free: NDArray[np.int64]
    axes: NDArray[np.float64]
    base: int


@inner
def _quaternion(axes, angles, p, k, out, j):  # type: ignore[no-untyped-def]
    """Write exp(swing) exp(twist) of angles[p, k] about axes[j] into out[0, j]."""
    s0 = angles[p, k, 0]
    s1 = angles[p, k, 1]
    t = angles[p, k, 2]
    x = s0 * axes[j, 0, 0] + s1 * axes[j, 1, 0]
    y = s0 * axes[j, 0, 1] + s1 * axes[j, 1, 1]
    z = s0 * axes[j, 0, 2] + s1 * axes[j, 1, 2]
    size = math.sqrt(x * x + y * y + z * z)
    w = math.cos(0.5 * size)
    scale = 0.5
    if size > 1e-9:
        scale = math.sin(0.5 * size) / size
    x = x * scale
    y = y * scale
    z = z * scale
    a = math.cos(0.5 * t)
    b = math.sin(0.5 * t)
    u = b * axes[j, 2, 0]
    v = b * axes[j, 2, 1]
    r = b * axes[j, 2, 2]
    out[0, j, 0] = w * a - x * u - y * v - z * r
    out[0, j, 1] = w * u + x * a + y * r - z * v
    out[0, j, 2] = w * v + y * a + z * u - x * r
    out[0, j, 3] = w * r + z * a + x * v - y * u


@inner
def _placed(limbs, b, held, base, p, angles, q, space):  # type: ignore[no-untyped-def]
    """Place the limb of body b, held[p], base[p], at angles[q]: frames and spheres into space."""
    rotations = space.rotations
    world = space.world
    centres = space.centres
    for j in range(rotations.shape[1]):
        for i in range(4):
            rotations[0, j, i] = held[p, j, i]
    for k in range(limbs.joint.shape[0]):
        if limbs.free[k]:
            _quaternion(limbs.axes, angles, q, k, rotations, limbs.joint[k])
    for i in range(3):
        for m in range(4):
            world[0, limbs.base, i, m] = base[p, i, m]
    c = limbs.chain
    s = limbs.skin
    chain = Chain(c.to, c.came, c.joint, c.upward, limbs.at_came[b], limbs.at_to[b])
    chain_transforms(rotations, chain, 0, world)
    skin = Skin(
        limbs.centre[b],
        limbs.out[b],
        limbs.across[b],
        s.start,
        s.twist_joint,
        s.joint_axis,
        limbs.twist_axis[b],
        limbs.twist_share[b],
        s.shown,
        s.blend_joint,
        limbs.blend_share[b],
        limbs.blend_point[b],
        s.blended,
        s.blend_start,
        s.distal,
        s.twist_shared,
    )
    place_spheres(rotations, world, skin, centres)


@inner
def _keep(found, p, count, values):  # type: ignore[no-untyped-def]
    """Insert (excess, sphere, polygon, x, y, z, inside) by its excess among found[p], deepest
    first; the new count."""
    most = found.shape[1]
    if count == most and found[p, most - 1, 0] >= values[0]:
        return count
    at = min(count, most - 1)
    while at > 0 and found[p, at - 1, 0] < values[0]:
        for i in range(7):
            found[p, at, i] = found[p, at - 1, i]
        at -= 1
    for i in range(7):
        found[p, at, i] = values[i]
    return min(count + 1, most)


@inlined
def _spare(x, y, z, s, g, space):  # type: ignore[no-untyped-def]
    """How far [m] sphere s, with its centre at (x, y, z), still is from all surfaces of group g at
    least: its last gap, less what it has moved. Where that is more than 0, the centre is outside."""
    last = space.last
    u = x - last[g, s, 0]
    v = y - last[g, s, 1]
    w = z - last[g, s, 2]
    return space.gap[g, s] - math.sqrt(u * u + v * v + w * w) - ROUNDING


@inlined
def _sphere(x, y, z, r, s, n, g, room, clear, outside, count, space):  # type: ignore[no-untyped-def]
    """Keep what sphere s of segment n, at (x, y, z) with radius r, enters of group g by more than
    -clear beyond what is allowed; outside: whether its centre surely is outside all solids."""
    faces = room.faces
    shells = room.shells
    field = room.field
    owner = room.owner
    allowed = room.allowed
    stack = space.stack
    gaps = space.gaps
    found = space.found
    square, sure = square_bound(x, y, z, field, g)
    near = max(r + clear - room.least[n, g], 0.0)
    limit = wider(near * near)
    far = near + WIDER
    space.last[g, s, 0] = x
    space.last[g, s, 1] = y
    space.last[g, s, 2] = z
    if (sure or outside) and square > limit:
        space.gap[g, s] = math.sqrt(square)
        return count
    deep = -1
    if not sure and not outside:
        depth, rank = deepest(x, y, z, faces, shells, field, g, stack, gaps)
        if rank >= 0:
            deep = int(field.record[field.begin[rank] + 8])
            far = near
            excess = depth + r - allowed[n, owner[deep]]
            if excess > -clear and (count < DEEPEST or excess > found[0, DEEPEST - 1, 0]):
                _, u, v, w = point_polygon(x, y, z, faces, deep, np.inf)
                count = _keep(found, 0, count, (excess, float(s), float(deep), u, v, w, 1.0))
    least = far * far
    limit = wider(least)
    stack[0] = field.root[g]
    size = 1
    point = point_lanes(x, y, z)
    while size > 0:
        size -= 1
        m = stack[size]
        bits = near_boxes(point, field.box, m, field.many[m], limit, gaps)
        if bits != 0:
            bits &= near_heads(x, y, z, field.head, m, limit, gaps)
        while bits != 0:
            c = np.int64(field.child[m, first_bit(bits)])
            bits &= bits - np.uint64(1)
            if c >= 0:
                stack[size] = c
                size += 1
                continue
            gap = record_gap(x, y, z, field, -1 - c, limit)
            if gap > limit:
                continue
            least = min(least, gap)
            f = int(field.record[field.begin[-1 - c] + 8])
            excess = r - math.sqrt(gap) - allowed[n, owner[f]]
            known = count == DEEPEST and excess <= found[0, DEEPEST - 1, 0]
            if f != deep and excess > -clear and not known:
                _, u, v, w = point_polygon(x, y, z, faces, f, np.inf)
                count = _keep(found, 0, count, (excess, float(s), float(f), u, v, w, 0.0))
    space.gap[g, s] = -1.0 if deep >= 0 else math.sqrt(least)
    return count


@inner
def touch(limbs, b, held, base, p, angles, q, room, near, space):  # type: ignore[no-untyped-def]
    """Place the limb of body b, held[p], base[p], at angles[q], and find what it enters by more
    than -near [m] beyond what is allowed: into space.found, deepest first; returns how many."""
    field = room.field
    shift = room.shift
    count = np.int64(0)
    _placed(limbs, b, held, base, p, angles, q, space)
    for g in range(field.root.shape[0]):
        if field.root[g] < 0:
            continue
        x, y, z = (shift[b, 0], shift[b, 1], shift[b, 2]) if g == 1 else (0.0, 0.0, 0.0)
        for s in range(limbs.centre.shape[2]):
            if not limbs.solid[b, s]:
                continue
            u = space.centres[0, s, 0] - x
            v = space.centres[0, s, 1] - y
            w = space.centres[0, s, 2] - z
            r = limbs.radius[b, s]
            n = limbs.segment[s]
            # only what is entered deeper than all that is kept is still of interest
            some = min(near, -space.found[0, DEEPEST - 1, 0]) if count == DEEPEST else near
            spare = _spare(u, v, w, s, g, space)
            if spare <= max(r + some - room.least[n, g], 0.0):
                count = _sphere(u, v, w, r, s, n, g, room, some, spare > 0.0, count, space)
    return count


@inlined
def _away(room, b, i, space):  # type: ignore[no-untyped-def]
    """The unit vector that leads sphere and polygon of contact i apart, from the polygon's nearest
    point to the centre, or back where the centre is inside; and how high [m] that point is along
    it, in the world."""
    found = space.found
    s = int(found[0, i, 1])
    f = int(found[0, i, 2])
    x = 0.0
    y = 0.0
    z = 0.0
    if room.field.root.shape[0] > 1 and room.moving[room.owner[f]] > 0:
        x = room.shift[b, 0]
        y = room.shift[b, 1]
        z = room.shift[b, 2]
    u = found[0, i, 3] + x
    v = found[0, i, 4] + y
    w = found[0, i, 5] + z
    sign = -1.0 if found[0, i, 6] > 0.0 else 1.0
    n0 = sign * (space.centres[0, s, 0] - u)
    n1 = sign * (space.centres[0, s, 1] - v)
    n2 = sign * (space.centres[0, s, 2] - w)
    size = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    if size > 1e-9:
        n0 = n0 / size
        n1 = n1 / size
        n2 = n2 / size
    else:
        n0 = room.normal[f, 0]
        n1 = room.normal[f, 1]
        n2 = room.normal[f, 2]
    return n0, n1, n2, n0 * u + n1 * v + n2 * w


@inner
def plane_of_contact(limbs, b, room, i, clear, space, planes, m):  # type: ignore[no-untyped-def]
    """Make plane m of contact i of body b, whose spheres stand as in space: the centre of the sphere
    must stay above the polygon's nearest point by its radius, less what is allowed, and by twice
    `clear` [m]."""
    s = int(space.found[0, i, 1])
    part = room.owner[int(space.found[0, i, 2])]
    n0, n1, n2, high = _away(room, b, i, space)
    k = limbs.carrier[s]
    world = space.world
    d0 = space.centres[0, s, 0] - world[0, k, 0, 3]
    d1 = space.centres[0, s, 1] - world[0, k, 1, 3]
    d2 = space.centres[0, s, 2] - world[0, k, 2, 3]
    for j in range(3):
        planes.point[m, j] = (
            world[0, k, 0, j] * d0 + world[0, k, 1, j] * d1 + world[0, k, 2, j] * d2
        )
    planes.link[m] = limbs.link[s]
    planes.normal[m, 0] = n0
    planes.normal[m, 1] = n1
    planes.normal[m, 2] = n2
    allowed = room.allowed[limbs.segment[s], part]
    planes.offset[m] = high + limbs.radius[b, s] - allowed + 2.0 * clear


@njit(cache=True, nogil=True)
def limb_contacts(limbs, who, held, base, angles, room, reach, out, begin, end):  # type: ignore[no-untyped-def]
    """Place the limbs of rows begin..end at angles (P, K, 3), row p of body who[p], and find what
    they enter.

    held (P, J, 4): rotations of all joints, those of the chain aside; base (P, 3, 4). reach [m]:
    how near what counts is, how far it is to be kept off. out: planes (P DEEPEST,), DEEPEST for
    each row; many (P,), part (P, DEEPEST), overlap (P,) [m] beyond what is allowed.
    """
    planes, many, part, overlap = out
    near, clear = reach
    space = new_space(limbs, held.shape[1])
    for p in range(begin, end):
        b = who[p]
        forget(space)
        many[p] = touch(limbs, b, held, base, p, angles, p, room, near, space)
        overlap[p] = max(0.0, space.found[0, 0, 0]) if many[p] > 0 else 0.0
        for i in range(many[p]):
            part[p, i] = room.owner[int(space.found[0, i, 2])]
            plane_of_contact(limbs, b, room, i, clear, space, planes, p * DEEPEST + i)


@njit(cache=True, nogil=True)
def least_heights(limbs, who, held, base, ways, out, begin, end):  # type: ignore[no-untyped-def]
    """Place the segments of rows begin..end, row p of body who[p], and fill out (P, W) with the
    least height of their spheres along each way. ways: vectors (W, 3) and which segments count (W,
    N)."""
    way, counts = ways
    spheres = limbs.centre.shape[2]
    space = new_space(limbs, held.shape[1])
    angles = np.zeros((1, 1, 3))
    centres = space.centres
    for p in range(begin, end):
        b = who[p]
        _placed(limbs, b, held, base, p, angles, np.int64(0), space)
        for w in range(len(way)):
            out[p, w] = np.inf
            for s in range(spheres):
                if counts[w, limbs.segment[s]]:
                    high = (
                        way[w, 0] * centres[0, s, 0]
                        + way[w, 1] * centres[0, s, 1]
                        + way[w, 2] * centres[0, s, 2]
                    )
                    out[p, w] = min(out[p, w], high - limbs.radius[b, s])
