"""Least clearance of every segment from every part, with the sphere, the polygon and its point.

What is nearest in the pose before, or of the segment before, is tried first: its sphere, then the
sphere nearest to the point found. From this pair on few spheres can be nearer still. A
sphere s outside the part is at least as far from it as each of these says:

1. The box of the part.
2. The plane that touches the part from the side of the pair: n.c - max n.v over the part's
   vertices v, where n is the unit vector from the point found to the centre found.
3. The ball around a centre h that holds no surface: its radius less |c - h|.

A centre inside a solid is no deeper than the way to the point found. The same bounds the spheres of
a cluster from its hub. Equal distances go to the lowest sphere and the lowest polygon, so that no
answer shows what was tried first.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.contact.kernels.clearance_groups import carried, cluster_hub
from workbench.contact.kernels.point_in_solid import inside_part
from workbench.contact.kernels.search import (
    Parts,
    foot,
    nearest_in,
    polygon_number,
    signed_distance,
    span_gap,
)
from workbench.geometry.bvh import wider
from workbench.geometry.simd8 import greatest, larger, load, splat8

__all__ = ["PartSpace", "part_clearance"]

_L = np.uint64(8)
CORNERS = np.uint64(24)
"""Numbers of eight vertices: x of all, y, z."""
FAR = np.float32(1e15)
"""Farther [m] than any vertex."""
HAIR = 1e-9
"""More [m] than the rounding of a distance between two points of the body."""
SPARE = 1e-6
"""More than the rounding of a height of a vertex in single precision, as a part of the sides of the
part's box: four roundings of 6e-8."""


class PartSpace(NamedTuple):
    """Working space of a thread."""

    hub: NDArray[np.float64]
    """(C, 3) the hubs of all clusters in the world [m]."""
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


@inlined
def _top(n0, n1, n2, parts, k):  # type: ignore[no-untyped-def]
    """How far the vertices of part k reach along a direction, seen from the middle of its box."""
    x = splat8(np.float32(n0))
    y = splat8(np.float32(n1))
    z = splat8(np.float32(n2))
    top = splat8(-FAR)
    for b in range(np.uint64(parts.first[k]), np.uint64(parts.first[k + 1])):
        e = b * CORNERS
        reach = x * load(parts.corner, e) + y * load(parts.corner, e + _L)
        top = larger(top, reach + z * load(parts.corner, e + _L + _L))
    return np.float64(greatest(top))


@inlined
def _apart(x, y, z, point):  # type: ignore[no-untyped-def]
    """Distance [m] of two points."""
    u = x - point[0]
    v = y - point[1]
    w = z - point[2]
    return math.sqrt(u * u + v * v + w * w)


@inlined
def _beyond(x, y, z, limit, plane, free, way, parts, k):  # type: ignore[no-untyped-def]
    """True where the signed distance of a point to part k surely is more than a limit [m].

    plane: unit normal and height; free: centre and radius of the ball without surface; way: how far
    that centre is from a point of the part.
    """
    over = plane[0] * x + plane[1] * y + plane[2] * z - plane[3]
    if over > 0.0 and over > limit:
        return True
    square = span_gap(x, y, z, parts.trees.span, k)
    if square > 0.0 and (limit < 0.0 or square > limit * limit):
        return True
    arm = _apart(x, y, z, free)
    low = max(over, free[3] - arm)
    if parts.faces.solid[k] > 0 and low <= 0.0 and square == 0.0:
        return -way - arm > limit
    return max(low, 0.0) > limit


@inlined
def _foot_of(centres, p, s, parts, rank):  # type: ignore[no-untyped-def]
    """The point of the polygon of a rank that is nearest to sphere s of pose p."""
    return foot(centres[p, s, 0], centres[p, s, 1], centres[p, s, 2], parts.trees, rank)


@inlined
def _plane(centres, p, sphere, point, best, radius, parts, k):  # type: ignore[no-untyped-def]
    """The plane that touches part k from the side of the nearest sphere so far: unit normal and
    height."""
    u = centres[p, sphere, 0] - point[0]
    v = centres[p, sphere, 1] - point[1]
    w = centres[p, sphere, 2] - point[2]
    way = -1.0 if best < -radius[sphere] else 1.0
    per = way / max(math.sqrt(u * u + v * v + w * w), 1e-12)
    u = u * per
    v = v * per
    w = w * per
    s = parts.trees.span
    middle = u * (s[k, 0] + s[k, 3]) + v * (s[k, 1] + s[k, 4]) + w * (s[k, 2] + s[k, 5])
    sides = s[k, 3] - s[k, 0] + s[k, 4] - s[k, 1] + s[k, 5] - s[k, 2]
    return u, v, w, _top(u, v, w, parts, k) + 0.5 * middle + SPARE * sides + HAIR


@inner
def _measure(pair, s, plane, near, found, free, space):  # type: ignore[no-untyped-def]
    """Improve what was found by sphere s.

    plane: which touches the part, unit normal and height; zeros where none is known. near: whether
    the polygon found is likely to be nearest to this sphere too. found: the least signed distance
    [m], its sphere and the rank of its polygon. free: centre and radius of the ball without
    surface. Returns both anew.
    """
    centres, radius, p, k, parts = pair
    best, sphere, rank = found
    clear = free[3]
    x = centres[p, s, 0]
    y = centres[p, s, 1]
    z = centres[p, s, 2]
    r = radius[s]
    inside = False
    boxed = parts.faces.solid[k] > 0 and span_gap(x, y, z, parts.trees.span, k) == 0.0
    if boxed and _apart(x, y, z, free) + HAIR >= clear:
        over = plane[0] * x + plane[1] * y + plane[2] * z - plane[3]
        inside = over <= 0.0 and inside_part(x, y, z, parts.faces, parts.shells, k, space.stack)
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
def _sphere_near(point, centres, p, n, crowd, hub):  # type: ignore[no-untyped-def]
    """The sphere of segment n that is nearest to a point."""
    near = np.int64(-1)
    least = np.inf
    for c in range(crowd.start[n], crowd.start[n + 1]):
        if _apart(hub[c, 0], hub[c, 1], hub[c, 2], point) - crowd.reach[c] >= least:
            continue
        for i in range(crowd.first[c], crowd.first[c + 1]):
            s = crowd.member[i]
            apart = _apart(centres[p, s, 0], centres[p, s, 1], centres[p, s, 2], point)
            if apart - crowd.radius[s] < least:
                least = apart - crowd.radius[s]
                near = s
    return near


@inlined
def _segment_part(centres, p, n, k, crowd, parts, most, begun, space):  # type: ignore[no-untyped-def]
    """Least signed distance [m] of segment n to part k in pose p, its sphere, the rank of its
    polygon, and the point; a sphere of -1 where it is not less than `most`.

    begun: a sphere and a rank, -1 for none, that may be nearest.

    First the sphere begun with is measured, then the one nearest to the point found, then all that
    may be nearer. Where `most` is finite there is only the last.
    """
    radius = crowd.radius
    hub = space.hub
    pair = Pair(centres, radius, p, k, parts)
    plane = 0.0, 0.0, 0.0, 0.0
    found = most, np.int64(-1), np.int64(begun[1])
    free = 0.0, 0.0, 0.0, -np.inf
    point = 0.0, 0.0, 0.0
    one = np.int64(-1)
    other = np.int64(-1)
    if most == np.inf:
        one = np.int64(begun[0])
        found, free = _measure(pair, one, plane, True, found, free, space)
        point = _foot_of(centres, p, one, parts, found[2])
        other = _sphere_near(point, centres, p, n, crowd, hub)
    if other != one:
        found, free = _measure(pair, other, plane, True, found, free, space)
        if found[1] == other:
            point = _foot_of(centres, p, other, parts, found[2])
    way = np.inf
    seen = found[1]
    if seen >= 0:
        plane = _plane(centres, p, seen, point, found[0], radius, parts, k)
        way = _apart(free[0], free[1], free[2], point)
    for c in range(crowd.start[n], crowd.start[n + 1]):
        limit = found[0] + crowd.reach[c] + HAIR
        x = hub[c, 0]
        y = hub[c, 1]
        z = hub[c, 2]
        if _beyond(x, y, z, limit, plane, free, way, parts, k):
            continue
        if seen < 0:  # nothing bounds the spheres yet: does anything come near enough to the hub?
            known = max(free[3] - _apart(x, y, z, free) - HAIR, 0.0)
            _, rank, about = signed_distance(
                x, y, z, limit, known, parts, k, space.stack, space.gaps
            )
            if rank < 0:
                continue
            free = x, y, z, about
        for i in range(crowd.first[c], crowd.first[c + 1]):
            s = crowd.member[i]
            x = centres[p, s, 0]
            y = centres[p, s, 1]
            z = centres[p, s, 2]
            limit = found[0] + radius[s] + HAIR
            if s in (one, other) or _beyond(x, y, z, limit, plane, free, way, parts, k):
                continue
            found, free = _measure(pair, s, plane, False, found, free, space)
            if seen >= 0:
                way = _apart(free[0], free[1], free[2], point)
    if found[1] != seen:
        point = _foot_of(centres, p, found[1], parts, found[2])
    return found[0], found[1], found[2], point


@inlined
def _begun(p, n, k, begin, crowd, rank, out, before):  # type: ignore[no-untyped-def]
    """Where the search for segment n and part k begins: a sphere and a rank.

    before: the segment before that was measured against this part, -1 for none.
    """
    if p > begin and out.sphere[p - 1, n, k] >= 0:
        return out.sphere[p - 1, n, k], rank[out.polygon[p - 1, n, k]]
    sphere = crowd.member[crowd.first[crowd.start[n]]]
    return sphere, rank[out.polygon[p, before, k]] if before >= 0 else np.int64(-1)


@inlined
def _far(world, p, n, k, crowd, parts, most):  # type: ignore[no-untyped-def]
    """True where segment n is farther from part k than `most` [m] by the sphere around it and the
    part's box."""
    if most == np.inf:
        return False
    x, y, z = carried(world, p, n, crowd.around[n, 0], crowd.around[n, 1], crowd.around[n, 2])
    reach = max(crowd.big[n] + most, 0.0)
    return span_gap(x, y, z, parts.trees.span, k) > wider(reach * reach)


@inlined
def _place_hubs(centres, world, p, crowd, hub):  # type: ignore[no-untyped-def]
    """Fill hub (C, 3) with where the hubs of the segments shown are in pose p."""
    for n in range(len(crowd.shown)):
        for c in range(crowd.start[n], crowd.start[n + 1] if crowd.shown[n] else crowd.start[n]):
            x, y, z = cluster_hub(centres, world, p, crowd, n, c)
            hub[c, 0] = x
            hub[c, 1] = y
            hub[c, 2] = z


@batch_loop
def part_clearance(centres, world, crowd, parts, most, out, space, begin, end):  # type: ignore[no-untyped-def]
    """Fill out with the least signed distance of each segment to each part, where it is less than
    most (N, K) [m], for the poses begin..end.

    centres (P, S, 3), world (P, N, 3, 4) [m]; parts: Parts; out: Nearest, left as it is for
    hidden parts and for segments without spheres; space: PartSpace.
    """
    for p in range(begin, end):
        _place_hubs(centres, world, p, crowd, space.hub)
        for k in range(len(parts.trees.root)):
            if parts.trees.root[k] < 0:
                continue
            before = -1
            for n in range(len(crowd.shown)):
                if crowd.shown[n] == 0 or crowd.start[n] == crowd.start[n + 1]:
                    continue
                if _far(world, p, n, k, crowd, parts, most[n, k]):
                    continue
                begun = _begun(p, n, k, begin, crowd, parts.faces.rank, out, before)
                d, s, f, point = _segment_part(
                    centres, p, n, k, crowd, parts, most[n, k], begun, space
                )
                if s < 0:
                    continue
                out.distance[p, n, k] = d
                out.sphere[p, n, k] = s
                out.polygon[p, n, k] = polygon_number(parts.trees, f)
                for axis in range(3):
                    out.point[p, n, k, axis] = point[axis]
                before = n
