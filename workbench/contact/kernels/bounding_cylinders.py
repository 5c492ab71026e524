"""Heads of a tree's nodes: a flat cylinder around all polygons below each child.

A box around a piece of a slanting surface is as thick as the piece is wide; a cylinder along its
normal is as thin as the piece is flat. A search that has looked at the boxes looks at these, and of
the polygons of a finely cut surface opens a fifth of those that it would open else.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.contact.kernels.wide_bvh import DEEP, widest
from workbench.geometry.polygon import EDGES, RECORD
from workbench.geometry.simd4 import FOUR
from workbench.geometry.simd8 import LANES, larger, load, not_above, root, splat8, store

__all__ = ["SPARE", "cylinders_within", "heads_of"]

ROWS = 8
"""Normal, centre, radius, half the height."""
SPARE = 4e-6
"""Widening as a part of the greatest coordinate: a height and the way from the axis take ten
roundings of 6e-8."""


@inlined
def cylinders_within(x, y, z, head, m, limit, gaps):  # type: ignore[no-untyped-def]
    """Bits of those of the eight heads (M, ROWS, LANES) of node m that lie within sqrt(limit) of a
    point; the squared distances in gaps[DEEP:DEEP + LANES] are raised to theirs, which are lessened
    by rounding at the most."""
    step = np.uint64(LANES)
    at = np.uint64(m) * np.uint64(ROWS * LANES)
    up = at + step + step + step
    far = up + step + step + step
    p = splat8(np.float32(x))
    q = splat8(np.float32(y))
    r = splat8(np.float32(z))
    p = p - load(head, up)
    q = q - load(head, up + step)
    r = r - load(head, up + step + step)
    h = p * load(head, at) + q * load(head, at + step) + r * load(head, at + step + step)
    none = splat8(np.float32(0.0))
    spare = splat8(np.float32(SPARE * max(max(abs(x), abs(y)), abs(z))))
    square = (p * p + q * q + r * r) * splat8(np.float32(1.0 - SPARE))
    out = larger(root(larger(square - h * h, none)) - load(head, far) - spare, none)
    over = larger(larger(h, none - h) - load(head, far + step) - spare, none)
    low = larger(out * out + over * over, load(gaps, np.uint64(DEEP)))
    store(gaps, np.uint64(DEEP), low)
    return not_above(low, splat8(np.float32(widest(limit))))


@inner
def _below(child, many, c, found, stack):  # type: ignore[no-untyped-def]
    """Write the ranks of all polygons under child c, itself one or a node, into found; how many."""
    if c < 0:
        found[0] = -1 - c
        return 1
    stack[0] = c
    size = 1
    used = 0
    while size > 0:
        size -= 1
        m = stack[size]
        for k in range(many[m]):
            if child[m, k] < 0:
                found[used] = -1 - child[m, k]
                used += 1
            else:
                stack[size] = child[m, k]
                size += 1
    return used


@inner
def _axis(found, used, record, begin, row):  # type: ignore[no-untyped-def]
    """Write the mean normal, of length 1 or 0, and the mean of the centres of polygons into
    row[:6]."""
    for k in range(6):
        row[k] = 0.0
    for i in range(used):
        q = begin[found[i]]
        along = row[0] * record[q] + row[1] * record[q + 1] + row[2] * record[q + 2]
        way = -1.0 if along < 0.0 else 1.0
        size = way * record[q + 6] * record[q + 6]
        for k in range(3):
            row[k] += size * record[q + k]
            row[3 + k] += record[q + 3 + k] / used
    long = math.sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2])
    for k in range(3):
        row[k] = row[k] / long if long > 1e-30 else 0.0


@inner
def _extent(found, used, record, begin, row):  # type: ignore[no-untyped-def]
    """Write the radius and half the height of the cylinder about the axis row[:6] that holds all
    polygons into row[6:8]."""
    row[6] = 0.0
    row[7] = 0.0
    for i in range(used):
        off = record[begin[found[i]] + 9]
        for e in range(begin[found[i]] + RECORD, begin[found[i] + 1], EDGES):
            for tail in range(e, e + FOUR):
                u = record[tail] - row[3]
                v = record[tail + FOUR] - row[4]
                w = record[tail + 2 * FOUR] - row[5]
                h = row[0] * u + row[1] * v + row[2] * w
                u = u - h * row[0]
                v = v - h * row[1]
                w = w - h * row[2]
                row[6] = max(row[6], math.sqrt(u * u + v * v + w * w) + off)
                row[7] = max(row[7], abs(h) + off)


@batch_loop
def _heads(child, many, record, begin, rows, found, stack, row):  # type: ignore[no-untyped-def]
    """Fill rows (M, LANES, ROWS) with the cylinders, not yet widened. found (F,), stack (F +
    LANES,), row (ROWS,): working space."""
    for m in range(len(child)):
        for lane in range(many[m]):
            used = _below(child, many, child[m, lane], found, stack)
            _axis(found, used, record, begin, row)
            _extent(found, used, record, begin, row)
            for i in range(ROWS):
                rows[m, lane, i] = row[i]


def heads_of(
    child: NDArray[np.int32],
    many: NDArray[np.int64],
    record: NDArray[np.float64],
    begin: NDArray[np.int64],
    reach: float,
) -> NDArray[np.float32]:
    """Heads (M, ROWS, LANES) of the children (M, LANES) of trees of polygons as in `Field`.

    reach [m]: the greatest coordinate of all.
    """
    rows = np.zeros((len(child), LANES, ROWS))
    found = np.empty(len(begin), dtype=np.int64)
    stack = np.empty(len(begin) + LANES, dtype=np.int64)
    _heads(child, many, record, begin, rows, found, stack, np.empty(ROWS))
    rows[..., 6:] = rows[..., 6:] * (1.0 + 1e-6) + SPARE * reach
    return np.ascontiguousarray(rows.transpose(0, 2, 1).astype(np.float32))
