"""Eight lower bounds at once: the balls of a body in lanes, carried with their segment and looked
up in a grid.

All in single precision, about a grid's own origin, so that it does anywhere. What that leaves open
is taken off the distance: a bound is never more than the distance, and what a bound cannot decide
is worked out in double precision.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit
from workbench.geometry.lanes import (
    LANES,
    codes,
    corners,
    eight,
    larger,
    load,
    root,
    smaller,
    store,
    total,
    whole,
)

__all__ = ["FAR", "Lanes", "bound_lanes", "carry", "frame_of", "gathered", "in_solid_box"]

FAR = 1e18
"""Minus this is the radius of a ball that is not there [m]."""
SPARE = 4e-6
"""More than the rounding of a place and of a bound, as a part of the grid's and the segment's
size."""


class Lanes(NamedTuple):
    """The balls of a body, eight side by side: x, y, z in the frame of their segment and radius,
    LANES of each.

    hub: those around the clusters of segment n in the blocks group[n]:group[n + 1]; cluster (.,
    LANES): which, or -1. ball: the spheres of cluster c; member (., LANES): which, or -1. moves,
    block_moves: 1 where any of a cluster or a block moves in the frame of its segment, so that the
    placed centres are to be asked. who: the segments that have spheres. extent (1,): the greatest
    coordinate of all [m].
    """

    group: NDArray[np.int64]
    hub: NDArray[np.float32]
    cluster: NDArray[np.int64]
    block_moves: NDArray[np.int64]
    ball: NDArray[np.float32]
    member: NDArray[np.int64]
    moves: NDArray[np.int64]
    who: NDArray[np.int64]
    extent: NDArray[np.float64]


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def frame_of(world, p, n, field, g):  # type: ignore[no-untyped-def]
    """The transform of segment n to the origin of grid g: three rows of four."""
    w = world
    o = field.grid
    one = (
        np.float32(w[p, n, 0, 0]),
        np.float32(w[p, n, 0, 1]),
        np.float32(w[p, n, 0, 2]),
        np.float32(w[p, n, 0, 3] - o[g, 0]),
    )
    two = (
        np.float32(w[p, n, 1, 0]),
        np.float32(w[p, n, 1, 1]),
        np.float32(w[p, n, 1, 2]),
        np.float32(w[p, n, 1, 3] - o[g, 1]),
    )
    three = (
        np.float32(w[p, n, 2, 0]),
        np.float32(w[p, n, 2, 1]),
        np.float32(w[p, n, 2, 2]),
        np.float32(w[p, n, 2, 3] - o[g, 2]),
    )
    return one, two, three


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def carry(frame, balls, at):  # type: ignore[no-untyped-def]
    """Coordinates of the eight balls from place `at`, about the origin of a grid."""
    step = np.uint64(LANES)
    a = load(balls, at)
    b = load(balls, at + step)
    c = load(balls, at + step + step)
    one, two, three = frame
    x = eight(one[0]) * a + eight(one[1]) * b + eight(one[2]) * c + eight(one[3])
    y = eight(two[0]) * a + eight(two[1]) * b + eight(two[2]) * c + eight(two[3])
    z = eight(three[0]) * a + eight(three[1]) * b + eight(three[2]) * c + eight(three[3])
    return x, y, z


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def gathered(centres, p, member, at, field, g, room):  # type: ignore[no-untyped-def]
    """Coordinates of the eight spheres member[at:at + LANES] about the origin of grid g, as they
    are placed."""
    for k in range(LANES):
        s = max(member[at + k], 0)
        room[k] = centres[p, s, 0] - field.grid[g, 0]
        room[k + LANES] = centres[p, s, 1] - field.grid[g, 1]
        room[k + 2 * LANES] = centres[p, s, 2] - field.grid[g, 2]
    step = np.uint64(LANES)
    return load(room, np.uint64(0)), load(room, step), load(room, step + step)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _along(x, per, n):  # type: ignore[no-untyped-def]
    """Along one axis: the cell, the place in it, and how far outside the grid."""
    u = x * per
    a = smaller(larger(u, eight(np.float32(0.0))), eight(np.float32(n - 1)))
    i = smaller(whole(a), eight(np.float32(n - 2)))
    return i, a - i, u - a


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def bound_lanes(spot, extent, field, g, room):  # type: ignore[no-untyped-def]
    """Lower bounds of the distances of eight points to a group by its grid g, and the bits of those
    in whose cells a solid may be. room (5 LANES,): working space."""
    h = np.float32(field.grid[g, 3])
    per = eight(np.float32(field.grid[g, 4]))
    nx = field.shape[g, 0]
    ny = field.shape[g, 1]
    nz = field.shape[g, 2]
    i, r, du = _along(spot[0], per, nx)
    j, s, dv = _along(spot[1], per, ny)
    k, t, dw = _along(spot[2], per, nz)
    step = np.uint64(LANES)
    first = field.shape[g, 3]
    store(room, np.uint64(0), (i * eight(np.float32(ny)) + j) * eight(np.float32(nz)) + k)
    store(room, step, r)
    store(room, step + step, s)
    store(room, step + step + step, t)
    scale = eight(field.scale[g])
    unsure = np.uint64(0)
    for lane in range(LANES):
        at = step * np.uint64(first + np.int64(room[lane]))
        weights = corners(room[LANES + lane], room[2 * LANES + lane], room[3 * LANES + lane])
        room[4 * LANES + lane] = total(weights * codes(field.cell, at) * scale)
        unsure |= np.uint64(field.cell[at] & 1) << np.uint64(lane)
    one = eight(np.float32(1.0))
    none = eight(np.float32(0.0))
    mix = load(room, step + step + step + step) * eight(np.float32(1.0 - SPARE))
    low = (
        mix
        - eight(h * h) * (r * (one - r) + s * (one - s) + t * (one - t))
        - eight(np.float32(field.grid[g, 5]))
    )
    low = larger(low, none) + eight(h * h) * (du * du + dv * dv + dw * dw)
    size = h * np.float32(nx + ny + nz) + np.float32(extent)
    return root(low) * eight(np.float32(1.0 - SPARE)) - eight(np.float32(SPARE) * size), unsure


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def in_solid_box(x, y, z, field, g):  # type: ignore[no-untyped-def]
    """True where a point lies in the box of a solid of group g."""
    b = field.solid_span
    for s in range(field.solid_start[g], field.solid_start[g + 1]):
        if (
            min(x - b[s, 0], y - b[s, 1], z - b[s, 2]) >= 0.0
            and min(b[s, 3] - x, b[s, 4] - y, b[s, 5] - z) >= 0.0
        ):
            return True
    return False
