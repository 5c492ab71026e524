"""Batch loops of spheres against spheres: the paper's three steps, and the least distance of
segment pairs."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.contact.kernels.fronts import (
    SPARE,
    Blocks,
    first_pairs,
    foremost_pair,
    place_blocks,
)

__all__ = ["Balls", "PairAnswers", "PairBody", "facing_side", "pair_clearance", "sphere_contacts"]


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


class PairBody(NamedTuple):
    """One of two placed bodies, or both."""

    centres: NDArray[np.float64]
    """(P, S, 3) [m]."""
    world: NDArray[np.float64]
    """(P, N, 3, 4) world_from_segment."""
    radius: NDArray[np.float64]
    """(S,) [m]."""
    shown: NDArray[np.int64]
    """(N,) 1 for a segment in the logical window."""
    blocks: Blocks


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
def _write_witness(one, other, p, a, b, directions, out):  # type: ignore[no-untyped-def]
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
    out.facing[p, a, b] = facing_side(one.world, p, a, x, y, z, directions)


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
def _largest(radius, most):  # type: ignore[no-untyped-def]
    """The largest radius, or `most`."""
    for s in range(len(radius)):
        most = max(most, radius[s])
    return most


@inlined
def _place(one, other, p, alike, first, rooms):  # type: ignore[no-untyped-def]
    """Bring the spheres of both into blocks of single precision, seen from sphere `first`; returns
    the greatest coordinate [m]."""
    x = one.centres[p, first, 0]
    y = one.centres[p, first, 1]
    z = one.centres[p, first, 2]
    most = place_blocks(one.centres, p, one.shown, one.blocks, rooms[0].ball, x, y, z)
    if not alike:
        other_most = place_blocks(
            other.centres, p, other.shown, other.blocks, rooms[1].ball, x, y, z
        )
        most = max(most, other_most)
    return most


@batch_loop
def pair_clearance(one, other, alike, pairs, directions, out, rooms, places, begin, end):  # type: ignore[no-untyped-def]
    """Fill out with the least I of the segment pairs (M, 2), all with spheres, and what has it;
    poses begin..end.

    one, other: PairBody, alike where they are the same; directions (N, 6, 3) of the one's segments;
    out: PairAnswers; rooms: Room of both (with the same ball where alike), places (2, M): working
    space. The search begins at what was nearest in the pose before, which no answer shows.
    """
    for m in range(len(pairs)):
        places[0, m] = one.blocks.first[pairs[m, 0]] * 8
    big = _largest(other.radius, _largest(one.radius, 0.0))
    ends = (one.centres, one.radius, one.blocks), (other.centres, other.radius, other.blocks)
    begun1 = places[0]
    begun2 = places[1]
    for p in range(begin, end):
        _nothing(p, one.shown, other.shown, out)
        if len(pairs) == 0:
            continue
        most = _place(one, other, p, alike, one.blocks.start[pairs[0, 0]], rooms)
        first_pairs(
            pairs,
            one.blocks.first,
            other.blocks.first,
            rooms[0].ball,
            rooms[1].ball,
            rooms[0].high,
            begun1,
            begun2,
        )
        spare = np.float32(SPARE * (most + big))
        for m in range(len(pairs)):
            a = pairs[m, 0]
            b = pairs[m, 1]
            gap, s, t = foremost_pair(
                ends[0], ends[1], p, (a, b), rooms, (begun1[m], begun2[m]), spare
            )
            out.distance[p, a, b] = gap
            out.sphere[p, a, b] = s
            out.target[p, a, b] = t
            _write_witness(one, other, p, a, b, directions, out)
