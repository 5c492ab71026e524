"""Contacts of the spheres of moving limbs with the parts of an environment and with people who stand
still there, and planes from them.

A search places one limb again and again, a little farther each time, and most of its spheres are far
from everything. So the distance of each sphere from all parts is cached with the place where it was
measured. As long as the sphere has not moved as far, it touches nothing. Of a sphere that is near
something the polygons near by are listed: as long as it has not moved farther than they were
searched for, it touches no others. The contacts are the same with and without this cache, to the
last bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.forward import Chain, Skin, chain_transforms, place_spheres
from workbench.body.kernels.rotation import swing_twist_quaternion
from workbench.compiled import batch_loop, inlined, inner, shared
from workbench.contact.kernels.bounding_cylinders import cylinders_within
from workbench.contact.kernels.distance_field import (
    DistanceField,
    depth_in,
    near_polygon,
    solids_at,
    square_bound,
)
from workbench.contact.kernels.point_in_solid import SolidMeshes
from workbench.contact.kernels.search import record_gap
from workbench.contact.kernels.wide_bvh import DEEP, EIGHT, boxes_within, point_lanes
from workbench.geometry.bvh import wider
from workbench.geometry.polygon import Faces, point_polygon
from workbench.geometry.simd8 import lowest_set_bit
from workbench.geometry.vectors import (
    add,
    dot,
    norm,
    rotation_part,
    scale,
    store,
    subtract,
    transpose_matvec,
    vector,
)

__all__ = [
    "DEEPEST",
    "GROUPS",
    "Company",
    "Limbs",
    "Obstacles",
    "Space",
    "contact_of_sphere",
    "depth_behind",
    "find_contacts",
    "forget",
    "limb_contacts",
    "new_space",
    "plane_of_contact",
    "row_heights",
    "way_of_people",
]


DEEPEST = 16
"""Number of contacts of a limb that are kept, the deepest."""
SOLIDS = 16
"""How many solids may hold a centre at once; of more, the others count as surfaces."""
PEOPLE = 2
"""The group of the people, after the parts that stay and those that are displaced for each body."""
GROUPS = 3
WIDER = 5e-3
"""How much farther [m] than asked for polygons are searched, so that a sphere that moves a little
need not be searched again."""
LISTED = 16
"""How many polygons near a sphere are listed at most: as long as it has not moved by `WIDER`, no tree is
walked for it again."""
ROUNDING_MARGIN = 1e-9
"""Rounding [m] of the distance that a sphere has moved."""
STEPS = 2.0**30
"""[1/m] The excess of a contact is rounded down to one over this, 1e-9 m. Where polygons meet, those of
an edge or a corner are all as deep, but for the last digits, which are others once a cockpit is turned
or moved."""


class Company(NamedTuple):
    """Bodies that stand still, in one of Q ways in each of P reaches: S spheres in G segments."""

    centres: NDArray[np.float64]
    """(Q, S, 3) [m] in the world."""
    radius: NDArray[np.float64]
    """(Q, S) [m]."""
    start: NDArray[np.int64]
    """(G + 1,) where the spheres of each segment begin."""
    around: NDArray[np.float64]
    """(Q, G, 3) centres of spheres around those of each segment [m]."""
    big: NDArray[np.float64]
    """(Q, G) radii of these [m]."""
    allowed: NDArray[np.float64]
    """(Q, N, G) [m] how deep each segment of a limb may be in each of these; infinite where it does
    not matter."""
    row: NDArray[np.int64]
    """(P,) the way of each reach."""


class Obstacles(NamedTuple):
    """What is in the way: parts, as F polygons in one or two groups, of which the second is
    displaced; and bodies that stand still, as S spheres in segments. A segment counts as a part:
    these are numbered after the K of the environment, and their spheres after the polygons."""

    faces: Faces
    shells: SolidMeshes
    field: DistanceField
    owner: NDArray[np.int64]
    """(F + S,) the part of each polygon and sphere."""
    allowed: NDArray[np.float64]
    """(N, parts) [m] how deep each segment may enter each part."""
    moving: NDArray[np.int64]
    """(parts,) 1 for a part of the second group."""
    normal: NDArray[np.float64]
    """(F, 3) outward unit normals."""
    least: NDArray[np.float64]
    """(N, groups) [m] the least that is allowed to each segment in a group."""
    shift: NDArray[np.float64]
    """(B, 3) [m] displacement of the second group for each body."""
    branch: NDArray[np.int64]
    """(M, 8) the part that all polygons below each child of a tree node are of; -1 for several."""
    people: Company
    """Other people, and the own body but for the limb."""


class Space(NamedTuple):
    """Working arrays of one limb at a time."""

    rotations: NDArray[np.float64]
    """(1, J, 4) of all joints."""
    world: NDArray[np.float64]
    """(1, N, 3, 4) the segments that go along."""
    centres: NDArray[np.float64]
    """(1, S, 3) [m] their spheres."""
    stack: NDArray[np.int64]
    gaps: NDArray[np.float32]
    """Working arrays of the trees of polygons."""
    found: NDArray[np.float64]
    """(1, DEEPEST, 7) the contacts: excess [m], sphere, polygon, point (3) [m], 1 where the centre
    is inside. Of a sphere of a person, its number after the polygons, its centre and its radius less
    what is allowed [m]."""
    last: NDArray[np.float64]
    """(groups, S, 3) [m] where a sphere was last looked at, in its group's own frame."""
    entered: NDArray[np.int64]
    """(SOLIDS,) the solid parts that hold the centre of a sphere."""
    gap: NDArray[np.float64]
    """(groups, S) [m] how far its centre was from all surfaces of the group at least; -1 where it
    is not known, or the centre is inside."""
    listed: NDArray[np.int64]
    """(groups, S, 1 + LISTED) how many polygons are listed near it, -1 where none are; their ranks."""
    around: NDArray[np.float64]
    """(groups, S, 5) where it was then (3) [m]; what is not listed is farther from there [m] than this
    less what its part allows; and how far at least."""


def new_space(limbs: Limbs, joints: int) -> Space:
    """Make working arrays for bodies of so many joints."""
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
        np.zeros(SOLIDS, np.int64),
        np.full((GROUPS, spheres), -1.0),
        np.full((GROUPS, spheres, 1 + LISTED), -1),
        np.zeros((GROUPS, spheres, 5)),
    )


@inlined
def way_of_people(room, p):  # type: ignore[no-untyped-def]
    """The way in which people stand in reach p; 0 where there are none."""
    return room.people.row[p] if room.people.row.shape[0] > 0 else np.int64(0)


@inlined
def forget(space):  # type: ignore[no-untyped-def]
    """Empty the cache of distances: the body is another one, or parts have moved."""
    for g in range(space.gap.shape[0]):
        for s in range(space.gap.shape[1]):
            space.gap[g, s] = -1.0


class Limbs(NamedTuple):
    """Moving segments of B bodies of a family, with S of their spheres."""

    skin: Skin
    """Spheres of one body; centre to blend_point below stand in for its own."""
    chain: Chain
    """Segments of one body; at_came and at_to below stand in for its own."""
    centre: NDArray[np.float64]
    """(B, 3, S) [m] centres, in the frames of their segments."""
    out: NDArray[np.float64]
    """(B, 3, S) [m] the centres' arms from the axis of their segment's twist."""
    across: NDArray[np.float64]
    """(B, 3, S) [m] axis x arm."""
    radius: NDArray[np.float64]
    """(B, S) [m]."""
    twist_axis: NDArray[np.float64]
    """(B, N, 3) unit axes of the segments' twist."""
    twist_share: NDArray[np.float64]
    """(B, S) share of the twist that a sphere follows."""
    blend_share: NDArray[np.float64]
    """(B, S) share of a joint's rotation that a blended sphere follows."""
    blend_point: NDArray[np.float64]
    """(B, S, 3) [m] the point about which it does."""
    at_came: NDArray[np.float64]
    """(B, M, 3) [m] each joint in the frame of the segment before it, from the held one on."""
    at_to: NDArray[np.float64]
    """(B, M, 3) [m] the same in the frame of the segment after it."""
    solid: NDArray[np.int64]
    """(B, S) 1 for a sphere that may not enter parts."""
    segment: NDArray[np.int64]
    """(S,) segment of each sphere."""
    link: NDArray[np.int64]
    """(S,) link of the chain that carries each sphere."""
    carrier: NDArray[np.int64]
    """(S,) segment of that link."""
    joint: NDArray[np.int64]
    """(K,) the body's joints of the chain."""
    free: NDArray[np.int64]
    """(K,) 1 for a joint that turns."""
    axes: NDArray[np.float64]
    """(J, 3, 3) axes of all joints."""
    base: int
    """The held segment."""
    grip: NDArray[np.int64]
    """(B,) the solid sphere, rigid in the segment that arrives, that reaches nearest to its tip or
    farthest beyond: r - d is greatest with its radius r and its centre d from the tip; -1 for
    none."""
    grip_arm: NDArray[np.float64]
    """(B,) [m] that d."""
    tip: NDArray[np.float64]
    """(B, 3) [m] the point that arrives, in the frame of the segment that arrives."""
    rigid: NDArray[np.int64]
    """(H,) the solid spheres that are rigid in that segment."""


@inlined
def _skin_of_row(limbs, b):  # type: ignore[no-untyped-def]
    """Skin of body b."""
    s = limbs.skin
    return Skin(
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


@inner
def _placed(limbs, b, held, base, p, angles, q, space):  # type: ignore[no-untyped-def]
    """Place the limb of body b, held[p], base[p], at angles[q]: frames and spheres into space."""
    rotations = space.rotations
    for j in range(rotations.shape[1]):
        for i in range(4):
            rotations[0, j, i] = held[p, j, i]
    for k in range(limbs.joint.shape[0]):
        if limbs.free[k]:
            j = limbs.joint[k]
            first, second, twist = vector(angles[q, k])
            turn = swing_twist_quaternion(limbs.axes, j, first, second, twist)
            for i in range(4):
                rotations[0, j, i] = turn[i]
    for i in range(3):
        for m in range(4):
            space.world[0, limbs.base, i, m] = base[p, i, m]
    c = limbs.chain
    chain = Chain(c.to, c.came, c.joint, c.upward, limbs.at_came[b], limbs.at_to[b])
    chain_transforms(rotations, chain, 0, space.world)
    place_spheres(rotations, space.world, _skin_of_row(limbs, b), space.centres)


@inlined
def _rounded(excess):  # type: ignore[no-untyped-def]
    """The excess of a contact [m] rounded down, so that of those that are as deep it is the same."""
    return math.floor(excess * STEPS) / STEPS


@inlined
def _precedes(excess, s, polygon, found, i):  # type: ignore[no-untyped-def]
    """Whether a contact comes before found[0, i]: the deeper, of equals that of the sphere and of the
    polygon with the lower number."""
    if excess != found[0, i, 0]:
        return excess > found[0, i, 0]
    if s != found[0, i, 1]:
        return s < found[0, i, 1]
    return polygon < found[0, i, 2]


@inner
def _keep(found, count, values):  # type: ignore[no-untyped-def]
    """Insert a contact among found[0], in the order of `_precedes`; returns the new count.

    values are excess [m], sphere, polygon, point (3) [m], and 1 for a centre inside.
    """
    most = found.shape[1]
    excess, s, polygon = values[0], values[1], values[2]
    if count == most and not _precedes(excess, s, polygon, found, most - 1):
        return count
    at = min(count, most - 1)
    while at > 0 and _precedes(excess, s, polygon, found, at - 1):
        for i in range(7):
            found[0, at, i] = found[0, at - 1, i]
        at -= 1
    for i in range(7):
        found[0, at, i] = values[i]
    return min(count + 1, most)


@inlined
def _spare(x, y, z, s, g, space):  # type: ignore[no-untyped-def]
    """Least distance [m] of sphere s, with its centre at (x, y, z), from all surfaces of group g.

    It is the distance that was measured last, less what the sphere has moved since. Where it is
    more than 0, the centre is outside.
    """
    moved = norm(subtract((x, y, z), vector(space.last[g, s])))
    return space.gap[g, s] - moved - ROUNDING_MARGIN


@inlined
def _may_count(excess, s, polygon, clear, count, found):  # type: ignore[no-untyped-def]
    """Whether a contact is deep enough to be among those that are kept."""
    if count == DEEPEST:
        return _precedes(excess, s, polygon, found, DEEPEST - 1)
    return excess > -clear


@inlined
def _keep_contact(x, y, z, s, polygon, excess, inside, count, room, space):  # type: ignore[no-untyped-def]
    """Keep a contact of sphere s with a polygon, with the polygon's nearest point to its centre."""
    _, u, v, w = point_polygon(x, y, z, room.faces, polygon, np.inf)
    values = (excess, float(s), float(polygon), u, v, w, inside)
    return _keep(space.found, count, values)


@inlined
def _inside_solids(x, y, z, r, s, n, g, room, clear, count, space):  # type: ignore[no-untyped-def]
    """Keep the nearest polygon of each solid of group g that holds a centre. Returns the count, and how
    many solids do: space.entered."""
    field = room.field
    near = near_polygon(x, y, z, field, g)
    first, last = solids_at(x, y, z, field, g)
    entered = np.int64(0)
    for m in range(first, last):
        depth, rank = depth_in(
            x, y, z, room.faces, room.shells, field, m, near, space.stack, space.gaps
        )
        if rank < 0:
            continue
        f = int(field.trees.record[field.trees.begin[rank] + 8])
        part = room.owner[f]
        if entered < SOLIDS:
            space.entered[entered] = part
            entered += 1
        excess = _rounded(depth + r - room.allowed[n, part])
        if _may_count(excess, s, f, clear, count, space.found):
            count = _keep_contact(x, y, z, s, f, excess, 1.0, count, room, space)
    return count, entered


@inlined
def _is_entered(part, entered, space):  # type: ignore[no-untyped-def]
    """Whether a part is among the first `entered` solids that hold a centre."""
    found = False
    for i in range(entered):
        found = found or space.entered[i] == part
    return found


@inlined
def _keep_polygon(x, y, z, r, s, n, rank, gap, room, clear, entered, count, space):  # type: ignore[no-untyped-def]
    """Keep a polygon, by its rank, that a centre is sqrt(gap) [m] away from where the sphere enters it.
    Those of the first `entered` solids that hold the centre are left out: seen from inside they would
    push the sphere farther in. Returns the count."""
    trees = room.field.trees
    f = int(trees.record[trees.begin[rank] + 8])
    excess = _rounded(r - math.sqrt(gap) - room.allowed[n, room.owner[f]])
    if _may_count(excess, s, f, clear, count, space.found) and not _is_entered(
        room.owner[f], entered, space
    ):
        count = _keep_contact(x, y, z, s, f, excess, 0.0, count, room, space)
    return count


@inlined
def _deep(r, clear, count, found):  # type: ignore[no-untyped-def]
    """What this less what its part allows is the distance of [m] counts as a contact, and is among those
    that are kept."""
    return min(r + clear, r - found[0, DEEPEST - 1, 0]) if count == DEEPEST else r + clear


@inlined
def _listed_polygons(x, y, z, r, s, n, g, room, clear, entered, count, space):  # type: ignore[no-untyped-def]
    """The same as `_near_polygons`, of those that are listed; -1 for the square where others may count."""
    around = space.around[g, s]
    moved = norm(subtract((x, y, z), vector(around))) + ROUNDING_MARGIN
    if space.listed[g, s, 0] < 0 or _deep(r, clear, count, space.found) + moved > around[3]:
        return count, -1.0
    least = max(around[4] - moved, 0.0) ** 2
    for i in range(space.listed[g, s, 0]):
        rank = space.listed[g, s, 1 + i]
        gap = record_gap(x, y, z, room.field.trees, rank, np.inf)
        least = min(least, gap)
        count = _keep_polygon(x, y, z, r, s, n, rank, gap, room, clear, entered, count, space)
    return count, least


@inlined
def _near_polygons(x, y, z, r, s, n, g, room, clear, far, entered, count, space):  # type: ignore[no-untyped-def]
    """Keep the polygons of group g within far [m] of a centre that the sphere enters, and list them.

    The tree is walked depth first. A branch is cut if its boxes and its cylinders are farther away
    than what counts and than the nearest polygon so far; or if it is of one part, and farther away
    than what of this part counts. Returns the count, and the square of a distance [m2] that no
    polygon within far is nearer than.
    """
    field = room.field
    stack = space.stack
    gaps = space.gaps
    least = far * far
    limit = wider(least)
    rest = limit
    deep = _deep(r, clear, count, space.found) + WIDER
    many = 0
    stack[0] = field.trees.root[g]
    size = 1
    point = point_lanes(x, y, z)
    while size > 0:
        size -= 1
        m = stack[size]
        bits = boxes_within(point, field.trees.box, m, field.trees.many[m], limit, gaps)
        if bits != 0:
            bits &= cylinders_within(x, y, z, field.trees.head, m, limit, gaps)
        while bits != 0:
            k = lowest_set_bit(bits)
            bits &= bits - np.uint64(1)
            low = np.float64(gaps[DEEP + k]) * (1.0 - 2e-6)
            part = room.branch[m, k]
            if part >= 0 and low > 0.0:
                counts = max(deep - room.allowed[n, part], 0.0)
                if low > wider(counts * counts):
                    rest = min(rest, low)
                    continue
            c = np.int64(field.trees.child[m, k])
            if c >= 0:
                stack[size] = c
                size += 1
                continue
            gap = record_gap(x, y, z, field.trees, -1 - c, limit)
            if gap > limit:
                continue
            least = min(least, gap)
            if many < LISTED:
                space.listed[g, s, 1 + many] = -1 - c
            many += 1
            count = _keep_polygon(x, y, z, r, s, n, -1 - c, gap, room, clear, entered, count, space)
            deep = min(deep, _deep(r, clear, count, space.found) + WIDER)
            near = max(deep - room.least[n, g], 0.0)
            limit = min(limit, wider(max(near * near, least)))
    rest = min(rest, limit)
    space.listed[g, s, 0] = many if many <= LISTED else -1
    store((x, y, z), space.around[g, s])
    space.around[g, s, 3] = min(deep, far + room.least[n, g])
    space.around[g, s, 4] = math.sqrt(rest)
    return count, min(least, rest)


@inlined
def _sphere(x, y, z, r, s, n, g, room, clear, outside, count, space):  # type: ignore[no-untyped-def]
    """Keep what one sphere enters of a group by more than -clear [m] beyond what is allowed.

    Sphere s of segment n has its centre at (x, y, z), in the frame of group g, and radius r [m].
    outside says that the centre is surely outside all solids. Returns the new count of contacts.
    """
    field = room.field
    square, sure = square_bound(x, y, z, field, g)
    near = max(r + clear - room.least[n, g], 0.0)
    store((x, y, z), space.last[g, s])
    if (sure or outside) and square > wider(near * near):
        space.gap[g, s] = math.sqrt(square)
        return count
    entered = np.int64(0)
    if not sure and not outside:
        count, entered = _inside_solids(x, y, z, r, s, n, g, room, clear, count, space)
    far = near + WIDER
    count, least = _listed_polygons(x, y, z, r, s, n, g, room, clear, entered, count, space)
    if least < 0.0:
        count, least = _near_polygons(x, y, z, r, s, n, g, room, clear, far, entered, count, space)
    # in a solid: its surface holds nothing back
    space.gap[g, s] = -1.0 if entered > 0 else math.sqrt(least)
    return count


@shared
def contact_of_sphere(limbs, b, room, g, s, point, space):  # type: ignore[no-untyped-def]
    """Find what sphere s of body b, with its centre at a point (3) [m] in the frame of group g,
    enters of the group beyond what is allowed; space.found is filled, deepest first. Returns the
    number of contacts."""
    x, y, z = point
    n = limbs.segment[s]
    r = limbs.radius[b, s]
    none = np.int64(0)
    return _sphere(x, y, z, r, s, n, g, room, 0.0, False, none, space)


@inlined
def _near_people(x, y, z, r, s, n, q, room, clear, count, space):  # type: ignore[no-untyped-def]
    """Keep what sphere s of segment n, with its centre at (x, y, z) and radius r [m], enters of people
    who stand in way q, by more than -clear [m] beyond what is allowed: of each of their segments the
    sphere that it is deepest in."""
    people = room.people
    polygons = room.normal.shape[0]
    at = (x, y, z)
    store(at, space.last[PEOPLE, s])
    least = np.inf
    for g in range(people.big.shape[1]):
        allowed = people.allowed[q, n, g]
        if allowed == np.inf:
            continue
        gap = norm(subtract(at, vector(people.around[q, g]))) - people.big[q, g] + allowed
        foremost = -1
        if gap <= r + clear + WIDER:
            gap = np.inf
            for v in range(people.start[g], people.start[g + 1]):
                apart = norm(subtract(at, vector(people.centres[q, v]))) - people.radius[q, v]
                if apart + allowed < gap - 1.0 / STEPS:  # of two as near the first
                    gap = apart + allowed
                    foremost = v
        least = min(least, gap - 1.0 / STEPS)
        excess = _rounded(r - gap)
        if foremost >= 0 and _may_count(excess, s, polygons + foremost, clear, count, space.found):
            px, py, pz = vector(people.centres[q, foremost])
            off = people.radius[q, foremost] - allowed
            values = (excess, float(s), float(polygons + foremost), px, py, pz, off)
            count = _keep(space.found, count, values)
    space.gap[PEOPLE, s] = least
    return count


@inner
def _touch_people(limbs, b, q, room, near, count, space):  # type: ignore[no-untyped-def]
    """Keep what a limb that is placed enters of people who stand in way q by more than -near [m];
    returns the new count of contacts."""
    for s in range(limbs.centre.shape[2]):
        if not limbs.solid[b, s]:
            continue
        x, y, z = vector(space.centres[0, s])
        r = limbs.radius[b, s]
        n = limbs.segment[s]
        some = min(near, -space.found[0, DEEPEST - 1, 0]) if count == DEEPEST else near
        if _spare(x, y, z, s, PEOPLE, space) <= r + some:
            count = _near_people(x, y, z, r, s, n, q, room, some, count, space)
    return count


@shared
def find_contacts(limbs, b, held, base, p, angles, q, room, near, space):  # type: ignore[no-untyped-def]
    """Place a limb and find what it enters by more than -near [m] beyond what is allowed.

    Parameters
    ----------
    limbs : Limbs
        Limbs of B bodies.
    b : int
        Row of the body.
    held : (P, J, 4)
        Rotations of all joints, those of the chain aside.
    base : (P, 3, 4)
        World-from-base transforms [m] of the held segment.
    p : int
        Row of held and base.
    angles : (Q, K, 3)
        Joint angles of the chain [rad].
    q : int
        Row of angles.
    room : Obstacles
        The parts.
    near : float
        How near [m] a contact may be that is not yet one.
    space : Space
        Working arrays; found is filled, deepest first.

    Returns
    -------
    int
        Number of contacts.
    """
    field = room.field
    count = np.int64(0)
    _placed(limbs, b, held, base, p, angles, q, space)
    for g in range(field.trees.root.shape[0]):
        if field.trees.root[g] < 0:
            continue
        shift = vector(room.shift[b]) if g == 1 else (0.0, 0.0, 0.0)
        for s in range(limbs.centre.shape[2]):
            if not limbs.solid[b, s]:
                continue
            x, y, z = subtract(vector(space.centres[0, s]), shift)
            r = limbs.radius[b, s]
            n = limbs.segment[s]
            # only what is entered deeper than all that is kept is still of interest
            some = min(near, -space.found[0, DEEPEST - 1, 0]) if count == DEEPEST else near
            spare = _spare(x, y, z, s, g, space)
            if spare <= max(r + some - room.least[n, g], 0.0):
                count = _sphere(x, y, z, r, s, n, g, room, some, spare > 0.0, count, space)
    if room.people.radius.shape[1] > 0:
        count = _touch_people(limbs, b, way_of_people(room, p), room, near, count, space)
    return count


@inlined
def _away(room, b, i, space):  # type: ignore[no-untyped-def]
    """Direction that leads sphere and polygon of contact i apart, and the height of its plane [m].

    The unit vector leads from the polygon's nearest point to the centre, or back if the centre is
    inside. If both coincide, it is the polygon's normal. The height is that of the nearest point
    along it, in the world. From a sphere of a person it leads from centre to centre, up if both
    coincide; the nearest point is that of the sphere's surface, sunk by what is allowed.
    """
    found = space.found[0, i]
    polygon = int(found[2])
    if polygon >= room.normal.shape[0]:
        point = vector(found[3:])
        n = subtract(vector(space.centres[0, int(found[1])]), point)
        size = norm(n)
        n = scale(1.0 / size, n) if size > 1e-9 else (0.0, 0.0, 1.0)
        return n, dot(n, point) + found[6]
    shift = (0.0, 0.0, 0.0)
    if room.field.trees.root.shape[0] > 1 and room.moving[room.owner[polygon]] > 0:
        shift = vector(room.shift[b])
    point = add(vector(found[3:]), shift)
    sign = -1.0 if found[6] > 0.0 else 1.0
    n = scale(sign, subtract(vector(space.centres[0, int(found[1])]), point))
    size = norm(n)
    if size > 1e-9:
        n = (n[0] / size, n[1] / size, n[2] / size)
        return n, dot(n, point)
    n = vector(room.normal[polygon])
    return n, dot(n, point)


@inner
def plane_of_contact(limbs, b, room, i, clear, space, planes, m):  # type: ignore[no-untyped-def]
    """Make plane m of contact i of body b, whose spheres stand as in space.

    The centre of the sphere must stay above the polygon's nearest point by its radius, less what is
    allowed, and by twice `clear` [m].
    """
    s = int(space.found[0, i, 1])
    part = room.owner[int(space.found[0, i, 2])]
    normal, height = _away(room, b, i, space)
    frame = space.world[0, limbs.carrier[s]]
    arm = subtract(vector(space.centres[0, s]), (frame[0, 3], frame[1, 3], frame[2, 3]))
    store(transpose_matvec(rotation_part(frame), arm), planes.point[m])
    store(normal, planes.normal[m])
    planes.link[m] = limbs.link[s]
    allowed = room.allowed[limbs.segment[s], part]
    planes.offset[m] = height + limbs.radius[b, s] - allowed + 2.0 * clear


@batch_loop
def limb_contacts(limbs, who, held, base, angles, room, reach, out, begin, end, space):  # type: ignore[no-untyped-def]
    """Find what the limbs of rows begin..end - 1 of P enter, and planes that keep them out of it.

    Parameters
    ----------
    limbs : Limbs
        Limbs of B bodies.
    who : (P,)
        Row of the body of each limb.
    held : (P, J, 4)
        Rotations of all joints, those of the chain aside.
    base : (P, 3, 4)
        World-from-base transforms [m] of the held segment.
    angles : (P, K, 3)
        Joint angles of the chain [rad].
    room : Obstacles
        The parts.
    reach : tuple of two
        How near [m] what counts is, and how far [m] it is to be kept off.
    out : tuple of four
        Filled: planes (P DEEPEST,), DEEPEST for each row; number of contacts (P,); their parts (P,
        DEEPEST); the greatest depth (P,) [m] beyond what is allowed.
    begin, end : int
        Rows to look at.
    space : Space
        Working arrays.
    """
    planes, many, part, overlap = out
    near, clear = reach
    for p in range(begin, end):
        b = who[p]
        forget(space)
        many[p] = find_contacts(limbs, b, held, base, p, angles, p, room, near, space)
        overlap[p] = max(0.0, space.found[0, 0, 0]) if many[p] > 0 else 0.0
        for i in range(many[p]):
            part[p, i] = room.owner[int(space.found[0, i, 2])]
            plane_of_contact(limbs, b, room, i, clear, space, planes, p * DEEPEST + i)


@inner
def row_heights(limbs, b, held, base, p, ways, counts, angles, space, out):  # type: ignore[no-untyped-def]
    """Fill out[p] (W,) with the least heights [m] of the spheres of body b along W ways.

    Parameters
    ----------
    limbs : Limbs
        The segments of B bodies.
    b : int
        Row of the body.
    held : (P, J, 4)
        Rotations of all joints.
    base : (P, 3, 4)
        World-from-base transforms [m] of the held segment.
    p : int
        Row of held, base and out.
    ways : (W, 3)
        Unit vectors.
    counts : (W, N)
        Which segments count.
    angles : (1, 1, 3)
        No angles: the limbs have no joints that turn.
    space : Space
        Working arrays.
    """
    _placed(limbs, b, held, base, p, angles, 0, space)
    for w in range(len(ways)):
        out[p, w] = np.inf
        for s in range(limbs.centre.shape[2]):
            if counts[w, limbs.segment[s]]:
                high = dot(vector(ways[w]), vector(space.centres[0, s]))
                out[p, w] = min(out[p, w], high - limbs.radius[b, s])


@inner
def depth_behind(limbs, b, held, base, p, faces, offset, angles, space):  # type: ignore[no-untyped-def]
    """Return how deep [m] the spheres of body b go into a convex solid; negative where all are
    outside.

    A sphere that is outside beside an edge counts as nearer than it is.

    Parameters
    ----------
    limbs, b, held, base, p, angles, space
        As of `row_heights`.
    faces : (F, 3)
        Outward unit normals.
    offset : (F,)
        Heights of the faces along them [m].
    """
    _placed(limbs, b, held, base, p, angles, 0, space)
    deepest = -np.inf
    for s in range(limbs.centre.shape[2]):
        outside = -np.inf
        for f in range(len(faces)):
            high = dot(vector(faces[f]), vector(space.centres[0, s]))
            outside = max(outside, high - offset[f])
        deepest = max(deepest, limbs.radius[b, s] - outside)
    return deepest
