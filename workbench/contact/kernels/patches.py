"""Patches of up to eight neighbouring polygons, and for each cell of a grid those that hold all
that may be nearest.

For a set Q and a point w the difference d(x, Q)^2 - |x - w|^2 is concave, so over a cell it is
least at a corner: where it is positive at all eight, Q is nowhere in the cell as near as w. With w
on the surface, the nearest points of the corners, what is left to a cell are those patches that
stand over or beside it, however far the surface is; a search looks at three to eight of them, none
waiting for another, in place of a walk down a tree.
"""

from __future__ import annotations

import numpy as np

from workbench.compiled import njit
from workbench.contact.kernels.heads import SPARE
from workbench.geometry.lanes import LANES, eight, larger, load, not_above, root, store
from workbench.geometry.polygon import point_polygon

__all__ = ["LEVELS", "fill_lists", "nearest_points"]

LEVELS = 5
"""Cells are worked out in blocks of 16, 8, 4, 2 along each axis and one by one, each from the list
of the last."""
MOST = 32
"""Patches of a cell, four times as many of a block of two along each axis and so on: with more the
tree is as good."""
HAIR = 1e-3
"""Widening of a cell as a part of its edge, more than any rounding of a point's cell."""


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)
def nearest_points(faces, field, g, points, begin, end):  # type: ignore[no-untyped-def]
    """Fill points (n, 3) with the nearest point of the surface, for the nodes begin..end of grid
    g."""
    ny = field.shape[g, 1]
    nz = field.shape[g, 2]
    h = field.grid[g, 3]
    for at in range(begin, end):
        i = at // (ny * nz)
        j = at // nz % ny
        k = at % nz
        x = field.grid[g, 0] + i * h
        y = field.grid[g, 1] + j * h
        z = field.grid[g, 2] + k * h
        f = int(field.record[field.begin[field.near[field.shape[g, 3] + at]] + 8])
        _, points[at, 0], points[at, 1], points[at, 2] = point_polygon(x, y, z, faces, f, np.inf)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _corner_lanes(field, g, points, low, high, spots, ways):  # type: ignore[no-untyped-def]
    """Write the corners of the block of nodes low..high (3,) of grid g into spots (3 LANES,), and
    their squared distances to the nearest points of each corner into ways (LANES LANES,)."""
    ny = field.shape[g, 1]
    nz = field.shape[g, 2]
    h = field.grid[g, 3]
    for c in range(LANES):
        i = high[0] if c & 4 else low[0]
        j = high[1] if c & 2 else low[1]
        k = high[2] if c & 1 else low[2]
        x = field.grid[g, 0] + (i + (HAIR if c & 4 else -HAIR)) * h
        y = field.grid[g, 1] + (j + (HAIR if c & 2 else -HAIR)) * h
        z = field.grid[g, 2] + (k + (HAIR if c & 1 else -HAIR)) * h
        spots[c] = x
        spots[c + LANES] = y
        spots[c + 2 * LANES] = z
    # relative to the first corner, so that single precision does anywhere
    x0 = field.grid[g, 0] + low[0] * h
    y0 = field.grid[g, 1] + low[1] * h
    z0 = field.grid[g, 2] + low[2] * h
    for c in range(LANES):
        ways[c] = (high[0] - low[0] + HAIR) * h if c & 4 else -HAIR * h
        ways[c + LANES] = (high[1] - low[1] + HAIR) * h if c & 2 else -HAIR * h
        ways[c + 2 * LANES] = (high[2] - low[2] + HAIR) * h if c & 1 else -HAIR * h
    step = np.uint64(LANES)
    p = load(ways, np.uint64(0))
    q = load(ways, step)
    r = load(ways, step + step)
    for c in range(LANES):
        i = high[0] if c & 4 else low[0]
        j = high[1] if c & 2 else low[1]
        k = high[2] if c & 1 else low[2]
        at = (i * ny + j) * nz + k
        u = p - eight(np.float32(points[at, 0] - x0))
        v = q - eight(np.float32(points[at, 1] - y0))
        w = r - eight(np.float32(points[at, 2] - z0))
        store(ways, step * np.uint64(c), u * u + v * v + w * w)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _beaten(spots, ways, box, head, q, spare):  # type: ignore[no-untyped-def]
    """True where all of patch q is farther, at all corners, than the nearest point of one of them.

    box (B, 6), head (B, 8): a box and a cylinder around the patch; spare [m]: more than their
    rounding.
    """
    step = np.uint64(LANES)
    none = eight(np.float32(0.0))
    x = load(spots, np.uint64(0))
    y = load(spots, step)
    z = load(spots, step + step)
    u = larger(larger(eight(box[q, 0]) - x, x - eight(box[q, 3])), none)
    v = larger(larger(eight(box[q, 1]) - y, y - eight(box[q, 4])), none)
    w = larger(larger(eight(box[q, 2]) - z, z - eight(box[q, 5])), none)
    square = u * u + v * v + w * w
    u = x - eight(head[q, 3])
    v = y - eight(head[q, 4])
    w = z - eight(head[q, 5])
    h = u * eight(head[q, 0]) + v * eight(head[q, 1]) + w * eight(head[q, 2])
    out = larger(root(larger(u * u + v * v + w * w - h * h, none)) - eight(head[q, 6]), none)
    over = larger(larger(h, none - h) - eight(head[q, 7]), none)
    far = larger(root(larger(square, out * out + over * over)) - eight(spare), none)
    far = far * far * eight(np.float32(1.0 - 1e-5)) - eight(spare * spare)
    for c in range(LANES):
        if not_above(far, load(ways, step * np.uint64(c))) == np.uint64(0):
            return True
    return False


@njit(cache=True, error_model="numpy", nogil=True)
def fill_lists(field, g, points, patches, start, begin, end):  # type: ignore[no-untyped-def]
    """The lists of the cells in the blocks of 16 along each axis begin..end of grid g, one after
    the other.

    points (n, 3): `nearest_points` of all nodes; patches: box (B, 6) and head (B, 8) of each. start
    (n,) is filled: where the list of each cell begins in what is returned, its length before its
    patches.
    """
    box, head = patches
    shape = field.shape[g]
    items = np.empty(1024, np.int32)
    used = 0
    reach = max(np.abs(field.span[g]).max(), 1.0)
    spare = np.float32(2.0 * SPARE * reach + 4.0 * field.grid[g, 6])
    some = np.empty((LEVELS + 1, len(box)), np.int32)
    count = np.zeros(LEVELS + 1, np.int64)
    spots = np.empty(3 * LANES, np.float32)
    ways = np.empty(LANES * LANES, np.float32)
    todo = np.empty((LEVELS * LANES, 4), np.int64)
    across = (shape[:3] + 14) // 16
    some[0], count[0] = np.arange(len(box)), len(box)
    for block in range(begin, end):
        todo[0, 0] = 1
        todo[0, 1] = 16 * (block // (across[1] * across[2]))
        todo[0, 2] = 16 * (block // across[2] % across[1])
        todo[0, 3] = 16 * (block % across[2])
        waiting = 1
        while waiting > 0:
            waiting -= 1
            level, i, j, k = todo[waiting]
            size = 1 << (LEVELS - level)
            high = (
                min(i + size, shape[0] - 1),
                min(j + size, shape[1] - 1),
                min(k + size, shape[2] - 1),
            )
            _corner_lanes(field, g, points, (i, j, k), high, spots, ways)
            found = 0
            for s in range(count[level - 1]):
                q = some[level - 1, s]
                if not _beaten(spots, ways, box, head, q, spare):
                    some[level, found] = q
                    found += 1
            count[level] = found
            if found > MOST << (2 * (LEVELS - level)) and level > 2:
                continue
            if level == LEVELS:
                if used + found + 1 > len(items):
                    more = np.empty(2 * len(items), np.int32)
                    more[:used] = items[:used]
                    items = more
                start[(i * shape[1] + j) * shape[2] + k] = used
                items[used] = found
                items[used + 1 : used + 1 + found] = some[level, :found]
                used += found + 1
                continue
            size //= 2
            for c in range(LANES):
                a = i + (size if c & 4 else 0)
                b = j + (size if c & 2 else 0)
                d = k + (size if c & 1 else 0)
                if a < shape[0] - 1 and b < shape[1] - 1 and d < shape[2] - 1:
                    todo[waiting, 0] = level + 1
                    todo[waiting, 1] = a
                    todo[waiting, 2] = b
                    todo[waiting, 3] = d
                    waiting += 1
    return items[:used]
