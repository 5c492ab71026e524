"""Distances of a point to eight triangles or convex quadrangles at once, in single precision:
nearly exact.

Each lies in a frame of its own, its longest side from the origin along the first axis. For a
polygon with more corners a triangle around it stands, and the distance is then only a lower bound.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit
from workbench.geometry.lanes import LANES, eight, larger, load, root, smaller, where_below

__all__ = ["ROWS", "SPARE", "rows_of", "triangle_ways"]

ROWS = 23
"""Origin, the three axes of the frame; length of the first side; direction and length of the side
from the origin, of that from the end of the first and of the one between their ends; 0, or FAR
where the distance is only a lower bound."""
SPARE = 4e-6
"""More than the rounding of a distance, as a part of the grid's size, where no angle is too
small."""
THIN = 0.995
"""Cosine of an angle of six degrees: with a smaller one what is computed is taken for a lower bound
only."""
FAR = 1e18
EDGES = 10
"""Where the edges begin in a polygon's record."""


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def triangle_ways(x, y, z, tri, m):  # type: ignore[no-untyped-def]
    """Distances of a point, about the grid's origin, to the eight polygons of patch m: from below,
    and from above."""
    step = np.uint64(LANES)
    at = np.uint64(m) * np.uint64(ROWS * LANES)
    p = eight(x) - load(tri, at)
    q = eight(y) - load(tri, at + step)
    r = eight(z) - load(tri, at + step * np.uint64(2))
    u = p * load(tri, at + step * np.uint64(3)) + q * load(tri, at + step * np.uint64(4))
    u = u + r * load(tri, at + step * np.uint64(5))
    v = p * load(tri, at + step * np.uint64(6)) + q * load(tri, at + step * np.uint64(7))
    v = v + r * load(tri, at + step * np.uint64(8))
    h = p * load(tri, at + step * np.uint64(9)) + q * load(tri, at + step * np.uint64(10))
    h = h + r * load(tri, at + step * np.uint64(11))
    none = eight(np.float32(0.0))
    long = load(tri, at + step * np.uint64(12))
    out = u - smaller(larger(u, none), long)
    best = out * out + v * v
    inner = v
    a = load(tri, at + step * np.uint64(13))
    b = load(tri, at + step * np.uint64(14))
    along = u * a + v * b
    across = u * b - v * a
    out = along - smaller(larger(along, none), load(tri, at + step * np.uint64(15)))
    best = smaller(best, out * out + across * across)
    inner = smaller(inner, across)
    a = load(tri, at + step * np.uint64(16))
    b = load(tri, at + step * np.uint64(17))
    s = u - long
    along = s * a + v * b
    across = v * a - s * b
    out = along - smaller(larger(along, none), load(tri, at + step * np.uint64(18)))
    best = smaller(best, out * out + across * across)
    inner = smaller(inner, across)
    far = load(tri, at + step * np.uint64(15))
    s = u - far * load(tri, at + step * np.uint64(13))
    t = v - far * load(tri, at + step * np.uint64(14))
    a = load(tri, at + step * np.uint64(19))
    b = load(tri, at + step * np.uint64(20))
    along = s * a + t * b
    across = s * b - t * a
    out = along - smaller(larger(along, none), load(tri, at + step * np.uint64(21)))
    best = smaller(best, out * out + across * across)
    inner = smaller(inner, across)
    way = root(h * h + where_below(inner, none, best, none))
    return way, way + load(tri, at + step * np.uint64(22))


@njit(cache=True, error_model="numpy")
def _unit(a, other):  # type: ignore[no-untyped-def]
    long = math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    return a / long if long > 1e-150 else other


@njit(cache=True, error_model="numpy")
def _frame(first, normal):  # type: ignore[no-untyped-def]
    """Axes (3, 3): along `first`, across, and the part of `normal` square to it; any where there is
    none."""
    axes = np.zeros((3, 3))
    axes[0] = _unit(first, np.array([1.0, 0.0, 0.0]))
    spare = np.zeros(3)
    spare[np.argmin(np.abs(axes[0]))] = 1.0
    spare = _unit(spare - axes[0] * np.sum(axes[0] * spare), axes[0])
    lean = normal - axes[0] * np.sum(axes[0] * normal)
    axes[2] = _unit(lean, spare) if np.sum(lean * lean) > 1e-6 else spare
    axes[1, 0] = axes[2, 1] * axes[0, 2] - axes[2, 2] * axes[0, 1]
    axes[1, 1] = axes[2, 2] * axes[0, 0] - axes[2, 0] * axes[0, 2]
    axes[1, 2] = axes[2, 0] * axes[0, 1] - axes[2, 1] * axes[0, 0]
    return axes


@njit(cache=True, error_model="numpy")
def _flat(record, begin, end, axes, o):  # type: ignore[no-untyped-def]
    """Low and high of a polygon's corners about o along the axes (3, 3), as rows (2, 3)."""
    span = np.empty((2, 3))
    span[0] = np.inf
    span[1] = -np.inf
    for e in range(begin, end, 6):
        for k in range(3):
            value = 0.0
            for axis in range(3):
                value += axes[k, axis] * (record[e + axis] - o[axis])
            span[0, k], span[1, k] = min(span[0, k], value), max(span[1, k], value)
    return span


@njit(cache=True, error_model="numpy")
def _ring(record, begin, end, lead, axes, ring):  # type: ignore[no-untyped-def]
    """Write the corners of a triangle or quadrangle into ring (4, 2), from edge `lead` on, about
    its head along two axes, a triangle's last twice. True where it is convex and no angle of it too
    small."""
    many = (end - begin) // 6
    o = record[lead : lead + 3]
    for c in range(4):
        e = begin + (lead - begin + 6 * min(c, many - 1)) % (end - begin)
        for k in range(2):
            ring[c, k] = np.sum(axes[k] * (record[e : e + 3] - o))
    turn = -1.0 if ring[2, 1] < 0.0 else 1.0
    for c in range(many):
        u = ring[(c + 1) % many] - ring[c]
        v = ring[(c - 1) % many] - ring[c]
        far = math.sqrt(np.sum(u * u) * np.sum(v * v))
        if (
            turn * (u[0] * v[1] - u[1] * v[0]) < 0.0
            or not np.sum(u * v) <= THIN * far
            or far < 1e-150
        ):
            return False
    return True


@njit(cache=True, error_model="numpy")
def _side(row, at, u, v):  # type: ignore[no-untyped-def]
    """Write the direction and the length of (u, v)."""
    far = math.sqrt(u * u + v * v)
    row[at], row[at + 1], row[at + 2] = (u / far, v / far, far) if far > 1e-150 else (1.0, 0.0, 0.0)


@njit(cache=True, error_model="numpy")
def _row(record, begin, end, row):  # type: ignore[no-untyped-def]
    """Write one polygon's rows, its origin still in the world; how far its corners lie off what
    stands for it."""
    lead = begin
    long = -1.0
    chained = end - begin in (18, 24)
    for e in range(begin, end, 6):
        square = np.sum((record[e + 3 : e + 6] - record[e : e + 3]) ** 2)
        if square > long:
            lead = e
            long = square
        after = e + 6 if e + 6 < end else begin
        chained = chained and bool(np.all(record[e + 3 : e + 6] == record[after : after + 3]))
    o = record[lead : lead + 3].copy()
    side = math.sqrt(long)
    ring = np.zeros((4, 2))
    axes = _frame(record[lead + 3 : lead + 6] - o, record[begin - EDGES : begin - EDGES + 3])
    exact = chained and _ring(record, begin, end, lead, axes, ring)
    span = _flat(record, begin, end, axes, o)
    if exact and ring[2, 1] < 0.0:  # the other way round
        axes[1], axes[2], ring[:, 1] = -axes[1], -axes[2], -ring[:, 1]
    elif not exact:
        # the right triangle around the rectangle around all
        o = o + axes[0] * span[0, 0] + axes[1] * span[0, 1]
        side = 2.0 * (span[1, 0] - span[0, 0])
        ring[2:] = 0.0
        ring[2, 1] = ring[3, 1] = 2.0 * (span[1, 1] - span[0, 1])
    row[:3] = o
    row[3:12] = axes.reshape(-1)
    row[12] = side
    _side(row, 13, ring[3, 0], ring[3, 1])
    _side(row, 16, ring[2, 0] - side, ring[2, 1])
    if exact and end - begin == 24:
        _side(row, 19, ring[2, 0] - ring[3, 0], ring[2, 1] - ring[3, 1])
    else:  # as far as can be, and on neither side of it
        row[19] = 0.0
        row[20] = 0.0
        row[21] = -FAR
    row[22] = 0.0 if exact else FAR
    return max(-span[0, 2], span[1, 2])


@njit(cache=True, error_model="numpy", nogil=True)
def _fill(record, begin, patch, rows):  # type: ignore[no-untyped-def]
    off = 0.0
    for m in range(patch.shape[0]):
        for lane in range(LANES):
            f = patch[m, lane]
            off = max(off, _row(record, begin[f] + EDGES, begin[f + 1], rows[m, lane]))
    return off


def rows_of(
    patch: NDArray[np.int32],
    record: NDArray[np.float64],
    begin: NDArray[np.int64],
    origin: NDArray[np.float64],
) -> tuple[NDArray[np.float32], float]:
    """Rows (B, ROWS, LANES) of the polygons patch (B, LANES), about an origin (3,), and how far
    corners lie off them [m]."""
    rows = np.zeros((len(patch), LANES, ROWS))
    off = _fill(record, begin, patch, rows)
    rows[..., :3] -= origin
    return np.ascontiguousarray(rows.transpose(0, 2, 1).astype(np.float32)), off
