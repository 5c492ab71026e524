"""Batch loops of spheres against spheres: the paper's three steps, and the least distance of
segment pairs."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner

__all__ = ["Balls", "PairAnswers", "facing_side", "pair_clearance", "sphere_contacts"]

HAIR = 1e-12
"""More than the rounding of a height, as a part of a metre and of the greatest height."""


class Balls(NamedTuple):
    """The spheres of a placed body, and one around those of each segment."""

    centres: NDArray[np.float64]
    """(P, S, 3) [m]."""
    radius: NDArray[np.float64]
    """(S,) [m]."""
    start: NDArray[np.int64]
    """(N + 1,) where the spheres of each segment begin."""
    around: NDArray[np.float64]
    """(P, N, 3) centres of the enclosing spheres [m]."""
    big: NDArray[np.float64]
    """(N,) radii of the enclosing spheres [m]."""


@inlined
def _apart(a, i, b, j, p):  # type: ignore[no-untyped-def]
    """Distance [m] of point i of a (P, ., 3) from point j of b in pose p."""
    x = a[p, i, 0] - b[p, j, 0]
    y = a[p, i, 1] - b[p, j, 1]
    z = a[p, i, 2] - b[p, j, 2]
    return math.sqrt(x * x + y * y + z * z)


@inner
def _segment_contacts(few, many, p, a, b, swapped, margin, rows, numbers, used):  # type: ignore[no-untyped-def]
    """Put down the sphere pairs of segment a of `few` and b of `many` that are nearer than margin;
    returns how many there are then. swapped: whether `many` is the one, `few` the other."""
    for u in range(few.start[a], few.start[a + 1]):
        if not _apart(few.centres, u, many.around, b, p) - few.radius[u] - many.big[b] < margin:
            continue
        for v in range(many.start[b], many.start[b + 1]):
            gap = _apart(few.centres, u, many.centres, v, p) - (few.radius[u] + many.radius[v])
            if not gap < margin:
                continue
            if used < len(rows):
                rows[used, 0] = p
                rows[used, 1] = v if swapped else u
                rows[used, 2] = u if swapped else v
                numbers[used] = gap
            used += 1
    return used


@batch_loop
def sphere_contacts(one, other, pairs, margin, rows, numbers):  # type: ignore[no-untyped-def]
    """Fill rows and numbers with all sphere pairs of the segment pairs (M, 2) nearer than margin
    [m]; returns how many.

    I = |ci - cj| - (ri + rj). The paper's three steps: enclosing spheres; each sphere of the
    smaller set against the other's enclosing sphere; pairs. one, other: Balls. rows (C, 3): pose,
    sphere of one, sphere of other; numbers (C,): I [m]. Where there are more than these hold, the
    others are counted only.
    """
    used = 0
    for p in range(len(one.centres)):
        for m in range(len(pairs)):
            a = pairs[m, 0]
            b = pairs[m, 1]
            if not _apart(one.around, a, other.around, b, p) - one.big[a] - other.big[b] < margin:
                continue
            if one.start[a + 1] - one.start[a] <= other.start[b + 1] - other.start[b]:
                used = _segment_contacts(one, other, p, a, b, False, margin, rows, numbers, used)
            else:
                used = _segment_contacts(other, one, p, b, a, True, margin, rows, numbers, used)
    return used


class PairAnswers(NamedTuple):
    """What is filled for each pose and pair of a segment of one body and one of the other."""

    distance: NDArray[np.float64]
    """(P, N, N') least distance of two of their spheres [m]."""
    sphere: NDArray[np.int64]
    """(P, N, N') the one's sphere, -1 where there is none."""
    target: NDArray[np.int64]
    """(P, N, N') the other's sphere, -1 where there is none."""
    point: NDArray[np.float64]
    """(P, N, N', 3) the point of the other's sphere that faces the one's [m]."""
    facing: NDArray[np.int64]
    """(P, N, N') the side of the one's segment that faces the other's sphere, -1 where none."""


@inlined
def facing_side(world, p, a, x, y, z, directions):  # type: ignore[no-untyped-def]
    """Which of the directions (N, 6, 3) of segment a is nearest to a direction of the world."""
    r = world[p, a, 0, 0] * x + world[p, a, 1, 0] * y + world[p, a, 2, 0] * z
    s = world[p, a, 0, 1] * x + world[p, a, 1, 1] * y + world[p, a, 2, 1] * z
    t = world[p, a, 0, 2] * x + world[p, a, 1, 2] * y + world[p, a, 2, 2] * z
    side = 0
    most = -np.inf
    for d in range(directions.shape[1]):
        along = directions[a, d, 0] * r + directions[a, d, 1] * s + directions[a, d, 2] * t
        side = d if along > most else side
        most = max(along, most)
    return side


@inlined
def _write_witness(one, other, world, p, a, b, directions, out):  # type: ignore[no-untyped-def]
    """Write where the nearest spheres of segments a and b face each other: point and facing."""
    u = out.sphere[p, a, b]
    v = out.target[p, a, b]
    x = other.centres[p, v, 0] - one.centres[p, u, 0]
    y = other.centres[p, v, 1] - one.centres[p, u, 1]
    z = other.centres[p, v, 2] - one.centres[p, u, 2]
    far = math.sqrt(x * x + y * y + z * z)
    apart = far > 1e-12
    part = other.radius[v] / far if apart else 0.0
    out.point[p, a, b, 0] = other.centres[p, v, 0] - part * x
    out.point[p, a, b, 1] = other.centres[p, v, 1] - part * y
    height = other.centres[p, v, 2]
    out.point[p, a, b, 2] = height - part * z if apart else height + other.radius[v]
    out.facing[p, a, b] = facing_side(world, p, a, x, y, z, directions)


@inner
def _nothing(p, shown1, shown2, out):  # type: ignore[no-untyped-def]
    """Write for all segment pairs of pose p that there is nothing: infinite, NaN outside the
    window."""
    for a in range(out.distance.shape[1]):
        for b in range(out.distance.shape[2]):
            out.distance[p, a, b] = np.inf if shown1[a] == 1 and shown2[b] == 1 else np.nan
            out.sphere[p, a, b] = -1
            out.target[p, a, b] = -1
            out.facing[p, a, b] = -1
            out.point[p, a, b, 0] = np.nan
            out.point[p, a, b, 1] = np.nan
            out.point[p, a, b, 2] = np.nan


@inlined
def _gap(one, other, p, s, t):  # type: ignore[no-untyped-def]
    """I = |cs - ct| - (rs + rt) [m] of sphere s of the one and t of the other in pose p."""
    return _apart(one.centres, s, other.centres, t, p) - (one.radius[s] + other.radius[t])


@inlined
def _nearest_sphere(one, s, other, b, p):  # type: ignore[no-untyped-def]
    """The sphere of segment b of the other that is nearest to sphere s of the one."""
    near = other.start[b]
    least = np.inf
    for t in range(other.start[b], other.start[b + 1]):
        gap = _gap(one, other, p, s, t)
        if gap < least:
            least = gap
            near = t
    return near


@inlined
def _heights(body, p, n, way, turn, height):  # type: ignore[no-untyped-def]
    """Fill height with how far the spheres of segment n reach along turn times a direction; returns
    the greatest."""
    top = -np.inf
    for s in range(body.start[n], body.start[n + 1]):
        along = way[0] * body.centres[p, s, 0] + way[1] * body.centres[p, s, 1]
        along += way[2] * body.centres[p, s, 2]
        height[s] = turn * along + body.radius[s]
        top = max(top, height[s])
    return top


@inner
def _nearest_pair(one, other, p, a, b, begun, heights, front):  # type: ignore[no-untyped-def]
    """Least I of segments a and b in pose p with its spheres, of equal ones the lowest.

    For a unit direction n I is no less than (n.ct - rt) - (n.cs + rs). So along the direction from
    one to the other of a pair that is nearly the nearest, few spheres of either segment are far
    enough forward to be of a pair that is nearer still. `begun` is the pair to begin with.
    """
    height1, height2 = heights
    s, t = begun
    x = other.centres[p, t, 0] - one.centres[p, s, 0]
    y = other.centres[p, t, 1] - one.centres[p, s, 1]
    z = other.centres[p, t, 2] - one.centres[p, s, 2]
    far = math.sqrt(x * x + y * y + z * z)
    # shorter than a unit where the centres are one: all the safer
    per = 1.0 / max(far, 1e-12)
    way = x * per, y * per, z * per
    top1 = _heights(one, p, a, way, 1.0, height1)
    top2 = _heights(other, p, b, way, -1.0, height2)
    best = _gap(one, other, p, s, t)
    spare = HAIR * (1.0 + abs(top1) + abs(top2))
    count = 0
    for v in range(other.start[b], other.start[b + 1]):
        if -height2[v] - top1 <= best + spare:
            front[count] = v
            count += 1
    for u in range(one.start[a], one.start[a + 1]):
        if -height1[u] - top2 > best + spare:
            continue
        for i in range(count):
            gap = _gap(one, other, p, u, front[i])
            better = gap < best or (gap == best and (u < s or (u == s and front[i] < t)))
            if better:
                best = gap
                s = u
                t = front[i]
    return best, s, t


@batch_loop
def pair_clearance(  # type: ignore[no-untyped-def]
    one, other, world, shown, pairs, directions, out, heights, front, begin, end
):
    """Fill out with the least I of the segment pairs (M, 2), all with spheres, and what has it;
    poses begin..end.

    one, other: Balls; world (P, N, 3, 4) and directions (N, 6, 3) of the one's segments; shown: the
    segments (N,) and (N',) in the logical windows; out: PairAnswers; heights (S,) and (S',), front
    (S',): working space. The search begins at what was nearest in the pose before, which no answer
    shows.
    """
    for p in range(begin, end):
        _nothing(p, shown[0], shown[1], out)
        for m in range(len(pairs)):
            a = pairs[m, 0]
            b = pairs[m, 1]
            if p > begin:
                s = out.sphere[p - 1, a, b]
                t = out.target[p - 1, a, b]
            else:  # to the nearest of the other segment and back
                t = _nearest_sphere(one, one.start[a], other, b, p)
                s = _nearest_sphere(other, t, one, a, p)
            gap, s, t = _nearest_pair(one, other, p, a, b, (s, t), heights, front)
            out.distance[p, a, b] = gap
            out.sphere[p, a, b] = s
            out.target[p, a, b] = t
            _write_witness(one, other, world, p, a, b, directions, out)
