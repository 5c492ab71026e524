"""Batch loops of spheres against spheres: the paper's three steps, and the least distance of
segment pairs."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.contact.kernels.fronts import SPARE, first_pairs, foremost_pair, place_blocks

__all__ = ["Balls", "pair_clearance", "sphere_contacts"]


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


@inlined
def _witness(one, other, p, a, b, out):  # type: ignore[no-untyped-def]
    """Write where the nearest spheres of segments a and b face each other: the point on the other's
    sphere, and the side of the one's segment, of its table of directions, that is nearest to the
    way to the other's centre."""
    (c1, world, directions), (c2, radius) = one, other
    _, sphere, target, point, facing = out
    u = sphere[p, a, b]
    v = target[p, a, b]
    x = c2[p, v, 0] - c1[p, u, 0]
    y = c2[p, v, 1] - c1[p, u, 1]
    z = c2[p, v, 2] - c1[p, u, 2]
    far = math.sqrt(x * x + y * y + z * z)
    part = radius[v] / far if far > 1e-12 else 0.0
    point[p, a, b, 0] = c2[p, v, 0] - part * x
    point[p, a, b, 1] = c2[p, v, 1] - part * y
    point[p, a, b, 2] = c2[p, v, 2] - part * z if far > 1e-12 else c2[p, v, 2] + radius[v]
    r = world[p, a, 0, 0] * x + world[p, a, 1, 0] * y + world[p, a, 2, 0] * z
    s = 0
    t = world[p, a, 0, 1] * x + world[p, a, 1, 1] * y + world[p, a, 2, 1] * z
    w = world[p, a, 0, 2] * x + world[p, a, 1, 2] * y + world[p, a, 2, 2] * z
    most = -np.inf
    for d in range(directions.shape[1]):
        along = directions[a, d, 0] * r + directions[a, d, 1] * t + directions[a, d, 2] * w
        s = d if along > most else s
        most = max(along, most)
    facing[p, a, b] = s


@inner
def _nothing(p, shown1, shown2, out):  # type: ignore[no-untyped-def]
    """Write for all segment pairs of pose p that there is nothing: infinite, NaN outside the
    window."""
    distance, sphere, target, point, facing = out
    for a in range(distance.shape[1]):
        for b in range(distance.shape[2]):
            distance[p, a, b] = np.inf if shown1[a] == 1 and shown2[b] == 1 else np.nan
            sphere[p, a, b] = -1
            target[p, a, b] = -1
            facing[p, a, b] = -1
            point[p, a, b, 0] = np.nan
            point[p, a, b, 1] = np.nan
            point[p, a, b, 2] = np.nan


@batch_loop
def pair_clearance(one, other, alike, pairs, directions, out, space, begin, end):  # type: ignore[no-untyped-def]
    """Fill out with the least I of the segment pairs (M, 2), all with spheres, and what has it;
    poses begin..end.

    one, other: (centres (P, S, 3), world (P, N, 3, 4), Crowd, Blocks), alike where they are the
    same; directions (N, 6, 3); out: distance (P, N, N'), the one's and the other's sphere (P, N,
    N'), point (P, N, N', 3), facing (P, N, N'); space: Room of both (with the same ball where
    alike), places (2, M). The search begins at what was nearest in the pose before, which no answer
    shows.
    """
    (c1, world1, crowd1, blocks1), (c2, _, crowd2, blocks2) = one, other
    room1, room2, places = space
    ends = (c1, crowd1.radius, blocks1), (c2, crowd2.radius, blocks2)
    for m in range(len(pairs)):
        places[0][m] = blocks1.first[pairs[m, 0]] * 8
    big = 0.0
    for radius in (crowd1.radius, crowd2.radius):
        for s in range(len(radius)):
            big = max(big, radius[s])
    for p in range(begin, end):
        _nothing(p, crowd1.shown, crowd2.shown, out)
        if len(pairs) == 0:
            continue
        s = blocks1.start[pairs[0, 0]]
        x = c1[p, s, 0]
        y = c1[p, s, 1]
        z = c1[p, s, 2]
        most = place_blocks(c1, p, crowd1.shown, blocks1, room1.ball, x, y, z)
        if not alike:
            most = max(most, place_blocks(c2, p, crowd2.shown, blocks2, room2.ball, x, y, z))
        first_pairs(
            pairs,
            blocks1.first,
            blocks2.first,
            room1.ball,
            room2.ball,
            room1.high,
            places[0],
            places[1],
        )
        spare = np.float32(SPARE * (most + big))
        for m in range(len(pairs)):
            a = pairs[m, 0]
            b = pairs[m, 1]
            begun = (places[0][m], places[1][m])
            best = foremost_pair(ends[0], ends[1], p, (a, b), (room1, room2), begun, spare)
            out[0][p, a, b], out[1][p, a, b], out[2][p, a, b] = best
            _witness((c1, world1, directions), (c2, crowd2.radius), p, a, b, out)
