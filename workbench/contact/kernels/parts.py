"""Least clearance of every segment from every part, with the sphere, the polygon and its point.

What is nearest in the pose before, or of the segment before, is tried first: its sphere, then the
sphere nearest to the point found. From this pair on few spheres can be nearer still. A
sphere s outside the part is at least as far from it as each of these says:

1. The box of the part.
2. The plane that touches the part from the side of the pair: n.c - max n.v over the part's
   vertices v, where n is the unit vector from the point found to the centre found.
3. The ball around a centre h that holds no surface: its radius less |c - h|.

A centre inside a solid is no deeper than the way to the point found. The spheres of a segment are
bounded by eight lanes in single precision, with a margin for rounding; what is left is measured in
double precision. Equal distances go to the lowest sphere and the lowest polygon, so that no answer
shows what was tried first.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.contact.kernels.fronts import FAR, NODE, SPARE, near_place, place_blocks
from workbench.contact.kernels.groups import carried
from workbench.contact.kernels.inside import inside_part
from workbench.contact.kernels.search import (
    Parts,
    foot,
    nearest_in,
    polygon_number,
    span_gap,
)
from workbench.geometry.lanes import (
    eight,
    greatest,
    larger,
    load,
    not_above,
    pack,
    root,
    where_below,
)
from workbench.geometry.tree import wider

__all__ = ["PartSpace", "part_clearance"]

_L = np.uint64(8)
CORNERS = np.uint64(24)
"""Numbers of eight vertices: x of all, y, z."""
HAIR = 1e-9
"""More [m] than the rounding of a distance between two points of the body."""


class PartSpace(NamedTuple):
    """Working space of a thread."""

    ball: NDArray[np.float32]
    """The spheres in blocks, as in `Blocks`."""
    front: NDArray[np.float32]
    """(8 B + 8,) places picked out."""
    spare: NDArray[np.float32]
    """(8,)."""
    stack: NDArray[np.int64]
    """(DEEP,)."""
    gaps: NDArray[np.float32]
    """(DEEP + EIGHT,)."""


class Pair(NamedTuple):
    """One segment in one pose, and one part: what stays the same while they are searched."""

    centres: NDArray[np.float64]
    """(P, S, 3) [m]."""
    radius: NDArray[np.float64]
    """(S,) [m]."""
    p: int
    k: int
    """Numbers of the pose and the part."""
    parts: Parts
    origin: tuple[float, float, float]
    """Where the blocks of spheres are seen from [m]."""
    spare: float
    """More [m] than the rounding of single precision."""


@inlined
def _top(n0, n1, n2, parts, k):  # type: ignore[no-untyped-def]
    """How far the vertices of part k reach along a direction, seen from the middle of its box."""
    x = eight(np.float32(n0))
    y = eight(np.float32(n1))
    z = eight(np.float32(n2))
    top = eight(-FAR)
    for b in range(np.uint64(parts.first[k]), np.uint64(parts.first[k + 1])):
        e = b * CORNERS
        reach = x * load(parts.corner, e) + y * load(parts.corner, e + _L)
        top = larger(top, reach + z * load(parts.corner, e + _L + _L))
    return np.float64(greatest(top))


@inlined
def _beyond(value, low, high):  # type: ignore[no-untyped-def]
    """How far eight coordinates lie outside an interval, negative inside."""
    return larger(eight(np.float32(low)) - value, value - eight(np.float32(high)))


@inlined
def _candidates(ball, a, b, origin, plane, free, parts, k, solid, most, spare, front):  # type: ignore[no-untyped-def]
    """Write the places in the blocks a..b whose spheres may come as near as `most` into front; how
    many.

    plane: unit normal and height, free: centre of the ball without surface, its radius and its
    distance from a point of the part; both as seen from the origin.
    """
    n0 = eight(np.float32(plane[0]))
    n1 = eight(np.float32(plane[1]))
    n2 = eight(np.float32(plane[2]))
    height = eight(np.float32(plane[3]))
    h0 = eight(np.float32(free[0]))
    h1 = eight(np.float32(free[1]))
    h2 = eight(np.float32(free[2]))
    clear = eight(np.float32(free[3]))
    way = eight(np.float32(free[4]))
    none = eight(np.float32(0.0))
    margin = eight(np.float32(spare))
    limit = eight(np.float32(most + spare))
    s = parts.trees.span
    used = np.uint64(0)
    for g in range(np.uint64(a), np.uint64(b)):
        e = g * NODE
        x = load(ball, e)
        y = load(ball, e + _L)
        z = load(ball, e + _L + _L)
        u = larger(_beyond(x, s[k, 0] - origin[0], s[k, 3] - origin[0]), none)
        v = larger(_beyond(y, s[k, 1] - origin[1], s[k, 4] - origin[1]), none)
        w = larger(_beyond(z, s[k, 2] - origin[2], s[k, 5] - origin[2]), none)
        out = larger(root(u * u + v * v + w * w), n0 * x + n1 * y + n2 * z - height)
        u = x - h0
        v = y - h1
        w = z - h2
        arm = root(u * u + v * v + w * w)
        low = larger(out, clear - arm)
        if solid:
            low = where_below(margin, low, low, none - way - arm)
        bits = not_above(low - load(ball, e + _L + _L + _L), limit)
        used = pack(front, used, bits, np.float32(np.int64(g * _L)))
    return used


@inlined
def _foot_of(centres, p, s, parts, rank):  # type: ignore[no-untyped-def]
    """The point of the polygon of a rank that is nearest to sphere s of pose p."""
    return foot(centres[p, s, 0], centres[p, s, 1], centres[p, s, 2], parts.trees, rank)


@inlined
def _plane(centres, p, sphere, rank, point, best, radius, parts, k, middle):  # type: ignore[no-untyped-def]
    """The plane that touches part k from the side of the nearest sphere so far: unit normal and
    height, as seen from where `middle` of the part's box is."""
    u = centres[p, sphere, 0] - point[0]
    v = centres[p, sphere, 1] - point[1]
    w = centres[p, sphere, 2] - point[2]
    way = -1.0 if best < -radius[sphere] else 1.0
    per = way / max(math.sqrt(u * u + v * v + w * w), 1e-12)
    u = u * per
    v = v * per
    w = w * per
    return u, v, w, _top(u, v, w, parts, k) + u * middle[0] + v * middle[1] + w * middle[2]


@inlined
def _apart(x, y, z, point):  # type: ignore[no-untyped-def]
    """Distance [m] of two points."""
    u = x - point[0]
    v = y - point[1]
    w = z - point[2]
    return math.sqrt(u * u + v * v + w * w)


@inner
def _measure(pair, s, plane, near, found, free, space):  # type: ignore[no-untyped-def]
    """Improve what was found by sphere s.

    plane: which touches the part, unit normal and height as seen from the origin; zeros where none
    is known. near: whether the polygon found is likely to be nearest to this sphere too. found: the
    least signed distance [m], its sphere and the rank of its polygon. free: centre and radius of
    the ball without surface. Returns both anew.
    """
    centres, radius, p, k, parts, origin, spare = pair
    best, sphere, rank = found
    hub = free[0], free[1], free[2]
    clear = free[3]
    x = centres[p, s, 0]
    y = centres[p, s, 1]
    z = centres[p, s, 2]
    r = radius[s]
    inside = False
    boxed = parts.faces.solid[k] > 0 and span_gap(x, y, z, parts.trees.span, k) == 0.0
    if boxed and _apart(x, y, z, hub) + HAIR >= clear:
        over = plane[0] * (x - origin[0]) + plane[1] * (y - origin[1])
        over += plane[2] * (z - origin[2]) - plane[3]
        inside = over <= spare and inside_part(x, y, z, parts.faces, parts.shells, k, space.stack)
    # the sum's rounding counts where a centre lies on a surface
    reach = best + r + (1e-15 * (abs(best) + r) if best < np.inf else 0.0)
    if not inside and reach < 0.0:
        return found, free
    limit = np.inf if inside or best == np.inf else reach * reach * (1.0 + 1e-12)
    hint = rank if near or inside else np.int64(-1)
    square, f = nearest_in(
        x, y, z, parts.trees, parts.trees.root[k], hint, limit, space.stack, space.gaps
    )
    away = math.sqrt(square)
    if not inside and away > clear:
        free = x, y, z, away
    signed = (-away if inside else away) - r
    if f >= 0 and (signed < best or (signed == best and s < sphere)):
        found = signed, s, f
    return found, free


@inlined
def _sphere_near(point, origin, blocks, n, space):  # type: ignore[no-untyped-def]
    """The sphere of segment n that is nearest to a point."""
    first = blocks.first[n]
    place = near_place(
        np.float32(point[0] - origin[0]),
        np.float32(point[1] - origin[1]),
        np.float32(point[2] - origin[2]),
        space.ball,
        first,
        blocks.first[n + 1],
        space.spare,
    )
    return np.int64(place) + blocks.start[n] - 8 * first


@inlined
def _segment_part(  # type: ignore[no-untyped-def]
    centres, p, n, k, crowd, blocks, parts, origin, most_at, most, begun, space
):
    """Least signed distance [m] of segment n to part k in pose p, its sphere, the rank of its
    polygon, and the point; a sphere of -1 where it is not less than `most`.

    begun: a place of the blocks and a rank, -1 for none, that may be nearest; most_at: the greatest
    coordinate and radius as seen from the origin.

    First the sphere at the place begun with is measured, then the one nearest to the point found,
    then all that may be nearer. Where `most` is finite there is only the last.
    """
    radius = crowd.radius
    first = blocks.first[n]
    last = blocks.first[n + 1]
    base = blocks.start[n] - 8 * first
    span = parts.trees.span
    middle = (
        0.5 * (span[k, 0] + span[k, 3]) - origin[0],
        0.5 * (span[k, 1] + span[k, 4]) - origin[1],
        0.5 * (span[k, 2] + span[k, 5]) - origin[2],
    )
    reach = abs(middle[0]) + abs(middle[1]) + abs(middle[2])
    reach += span[k, 3] - span[k, 0] + span[k, 4] - span[k, 1] + span[k, 5] - span[k, 2]
    spare = SPARE * (most_at + reach)
    pair = Pair(centres, radius, p, k, parts, origin, spare)
    plane = 0.0, 0.0, 0.0, 0.0
    found = most, np.int64(-1), np.int64(begun[1])
    free = origin[0], origin[1], origin[2], -np.inf
    point = origin
    one = np.int64(-1)
    other = np.int64(-1)
    if most == np.inf:
        one = np.int64(begun[0]) + base
        found, free = _measure(pair, one, plane, True, found, free, space)
        point = _foot_of(centres, p, one, parts, found[2])
        other = _sphere_near(point, origin, blocks, n, space)
    if other != one:
        found, free = _measure(pair, other, plane, True, found, free, space)
        if found[1] == other:
            point = _foot_of(centres, p, other, parts, found[2])
    way = np.inf
    seen = found[1]
    if seen >= 0:
        plane = _plane(centres, p, seen, found[2], point, found[0], radius, parts, k, middle)
        way = _apart(free[0], free[1], free[2], point)
    hub = free[0] - origin[0], free[1] - origin[1], free[2] - origin[2], free[3], way
    front = space.front
    count = _candidates(
        space.ball,
        first,
        last,
        origin,
        plane,
        hub,
        parts,
        k,
        parts.faces.solid[k] > 0,
        found[0],
        spare,
        front,
    )
    for i in range(np.int64(count)):
        s = np.int64(front[i]) + base
        if s not in (one, other):
            found, free = _measure(pair, s, plane, False, found, free, space)
    if found[1] != seen:
        point = _foot_of(centres, p, found[1], parts, found[2])
    return found[0], found[1], found[2], point


@inlined
def _begun(p, n, k, begin, blocks, rank, out, before):  # type: ignore[no-untyped-def]
    """Where the search for segment n and part k begins: a place of the blocks and a rank.

    before: the segment before that was measured against this part, -1 for none.
    """
    place = 8 * blocks.first[n]
    if p > begin and out.sphere[p - 1, n, k] >= 0:
        place += out.sphere[p - 1, n, k] - blocks.start[n]
        return place, rank[out.polygon[p - 1, n, k]]
    return place, rank[out.polygon[p, before, k]] if before >= 0 else np.int64(-1)


@inlined
def _far(world, p, n, k, crowd, parts, most):  # type: ignore[no-untyped-def]
    """True where segment n is farther from part k than `most` [m] by the sphere around it and the
    part's box."""
    if most == np.inf:
        return False
    x, y, z = carried(world, p, n, crowd.around[n, 0], crowd.around[n, 1], crowd.around[n, 2])
    reach = max(crowd.big[n] + most, 0.0)
    return span_gap(x, y, z, parts.trees.span, k) > wider(reach * reach)


@batch_loop
def part_clearance(  # type: ignore[no-untyped-def]
    centres, world, crowd, blocks, parts, most, out, space, begin, end
):
    """Fill out with the least signed distance of each segment to each part, where it is less than
    most (N, K) [m], for the poses begin..end.

    centres (P, S, 3), world (P, N, 3, 4) [m]; parts: Parts; out: Nearest, left as it is for
    hidden parts and for segments without spheres; space: PartSpace.
    """
    shown = crowd.shown
    lead = -1
    big = 0.0
    for n in range(len(shown)):
        if shown[n] == 1 and blocks.start[n] < blocks.start[n + 1]:
            lead = n if lead < 0 else lead
            for s in range(blocks.start[n], blocks.start[n + 1]):
                big = max(big, crowd.radius[s])
    if lead < 0:
        return
    for p in range(begin, end):
        s = blocks.start[lead]
        origin = centres[p, s, 0], centres[p, s, 1], centres[p, s, 2]
        size = big + place_blocks(
            centres, p, shown, blocks, space.ball, origin[0], origin[1], origin[2]
        )
        for k in range(len(parts.trees.root)):
            if parts.trees.root[k] < 0:
                continue
            before = -1
            for n in range(lead, len(shown)):
                if shown[n] == 0 or blocks.start[n] == blocks.start[n + 1]:
                    continue
                if _far(world, p, n, k, crowd, parts, most[n, k]):
                    continue
                d, s, f, point = _segment_part(
                    centres,
                    p,
                    n,
                    k,
                    crowd,
                    blocks,
                    parts,
                    origin,
                    size,
                    most[n, k],
                    _begun(p, n, k, begin, blocks, parts.faces.rank, out, before),
                    space,
                )
                if s < 0:
                    continue
                out.distance[p, n, k] = d
                out.sphere[p, n, k] = s
                out.polygon[p, n, k] = polygon_number(parts.trees, f)
                for axis in range(3):
                    out.point[p, n, k, axis] = point[axis]
                before = n
