"""Trees of boxes over the polygons of each part, and the nearest polygon of a part."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit
from workbench.geometry.order import stable_order
from workbench.geometry.polygon import point_polygon

__all__ = ["box_gap", "build_tree", "nearest_polygon", "wider"]

LEAF = 4


def build_tree(
    low: NDArray[np.float64], high: NDArray[np.float64], groups: NDArray[np.int64]
) -> tuple[
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.int64],
    NDArray[np.int64],
    NDArray[np.int64],
    NDArray[np.int64],
    NDArray[np.int64],
]:
    """Trees over boxes low..high (F, 3), one for each group groups[k]:groups[k + 1] of consecutive
    boxes.

    Returns low, high, child, first, last (nodes), item (boxes in leaf order), root (groups; -1
    where empty).
    """
    return _build(low, high, groups)


@njit(cache=True)
def _build(low, high, groups):  # type: ignore[no-untyped-def]
    count = low.shape[0]
    parts = groups.shape[0] - 1
    room = 2 * count + parts
    node_low = np.empty((room, 3))
    node_high = np.empty((room, 3))
    child = np.empty(room, np.int64)
    todo = np.empty(room, np.int64)
    root = np.empty(parts, np.int64)
    first = np.empty(room, np.int64)
    last = np.empty(room, np.int64)
    used = 0
    item = np.empty(count, np.int64)
    part = np.empty(count, np.int64)
    keys = np.empty(count)
    order = np.empty(count, np.int64)
    spare = np.empty(count, np.int64)
    for s in range(count):
        item[s] = s
    for k in range(parts):
        root[k] = -1
        if groups[k] == groups[k + 1]:
            continue
        root[k] = used
        first[used] = groups[k]
        last[used] = groups[k + 1]
        todo[0] = used
        waiting = 1
        used += 1
        while waiting > 0:
            waiting -= 1
            m = todo[waiting]
            a = first[m]
            b = last[m]
            child[m] = -1
            for i in range(3):
                node_low[m, i] = np.inf
                node_high[m, i] = -np.inf
                for s in range(a, b):
                    node_low[m, i] = min(node_low[m, i], low[item[s], i])
                    node_high[m, i] = max(node_high[m, i], high[item[s], i])
            if b - a <= LEAF:
                continue
            axis = 0
            for i in range(1, 3):
                if node_high[m, i] - node_low[m, i] > node_high[m, axis] - node_low[m, axis]:
                    axis = i
            for s in range(b - a):
                part[s] = item[a + s]
                keys[s] = 0.5 * (low[part[s], axis] + high[part[s], axis])
            stable_order(keys, b - a, order, spare)
            for s in range(b - a):
                item[a + s] = part[order[s]]
            half = (a + b) // 2
            child[m] = used
            first[used] = a
            last[used] = half
            first[used + 1] = half
            last[used + 1] = b
            todo[waiting] = used
            todo[waiting + 1] = used + 1
            waiting += 2
            used += 2
    return node_low[:used], node_high[:used], child[:used], first[:used], last[:used], item, root


@njit(cache=True, inline="always")
def box_gap(x, y, z, low, high):  # type: ignore[no-untyped-def]
    """Squared distance of a point to a box, 0 inside."""
    u = max(low[0] - x, 0.0, x - high[0])
    v = max(low[1] - y, 0.0, y - high[1])
    w = max(low[2] - z, 0.0, z - high[2])
    return u * u + v * v + w * w


@njit(cache=True, inline="always")
def wider(square):  # type: ignore[no-untyped-def]
    """A squared distance widened by rounding: what is pruned against it cannot be the equal of the
    best."""
    return square * (1.0 + 1e-12) + 1e-30


@njit(cache=True)
def nearest_polygon(x, y, z, faces, part, limit):  # type: ignore[no-untyped-def]
    """Nearest polygon of a part: squared distance, polygon, point; polygon -1 where none is within
    sqrt(limit)."""
    best = limit
    found = -1
    bx = x
    by = y
    bz = z
    stack = np.empty(64, np.int64)
    gaps = np.empty(64)
    stack[0] = faces.root[part]
    size = 1
    gaps[0] = box_gap(x, y, z, faces.low[stack[0]], faces.high[stack[0]])
    while size > 0:
        size -= 1
        m = stack[size]
        if gaps[size] > wider(best):
            continue
        c = faces.child[m]
        if c < 0:
            for s in range(faces.first[m], faces.last[m]):
                f = faces.item[s]
                gap, qx, qy, qz = point_polygon(x, y, z, faces, f, wider(best))
                # equal distances go to the lower polygon, so that the answer does not depend on the
                # tree
                if gap < best or (gap == best and (found < 0 or f < found)):
                    best = gap
                    found = f
                    bx = qx
                    by = qy
                    bz = qz
            continue
        near = c
        far = c + 1
        a = box_gap(x, y, z, faces.low[near], faces.high[near])
        b = box_gap(x, y, z, faces.low[far], faces.high[far])
        if b < a:
            near, far, a, b = far, near, b, a
        if b <= wider(best):
            stack[size] = far
            gaps[size] = b
            size += 1
        if a <= wider(best):
            stack[size] = near
            gaps[size] = a
            size += 1
    if found < 0:
        best = np.inf
    return best, found, bx, by, bz
