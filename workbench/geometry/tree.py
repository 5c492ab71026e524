"""Trees of boxes over groups of boxes, halved at the median."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined
from workbench.geometry.order import stable_order

__all__ = [
    "DEPTH",
    "box_gap",
    "build_tree",
    "wider",
]

LEAF = 4
"""Most boxes in a leaf."""
DEPTH = 64
"""Places on the stack of a search: trees are halved, so no tree is deeper."""


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
    count = len(low)
    parts = len(groups) - 1
    node_box = np.empty((2, 2 * count + parts, 3))
    links = np.empty((3, 2 * count + parts), dtype=np.int64)
    item = np.arange(count)
    root = np.full(parts, -1)
    keys = np.empty(count)
    space = np.empty((4, 2 * count + parts), dtype=np.int64)
    used = _build(low, high, groups, node_box, links, item, root, keys, space)
    low, high = node_box[:, :used].copy()
    child, first, last = links[:, :used].copy()
    return low, high, child, first, last, item, root


@inlined
def _cover(low, high, item, a, b, node_box, m):  # type: ignore[no-untyped-def]
    """Make node_box (2, M, 3) of node m the box around the boxes item[a:b]; returns its longest
    axis."""
    axis = 0
    longest = -np.inf
    for i in range(3):
        least = np.inf
        most = -np.inf
        for s in range(a, b):
            least = min(least, low[item[s], i])
            most = max(most, high[item[s], i])
        node_box[0, m, i] = least
        node_box[1, m, i] = most
        if most - least > longest:
            longest = most - least
            axis = i
    return axis


@batch_loop
def _build(low, high, groups, node_box, links, item, root, keys, space):  # type: ignore[no-untyped-def]
    """Fill node_box (2, M, 3), links (3, M): child, first and last of each node, item and root;
    returns how many nodes there are. keys (F,), space (4, M): working space.

    A node of more than LEAF boxes is halved at the median of their middles on its longest axis.
    """
    child = links[0]
    first = links[1]
    last = links[2]
    todo = space[0]
    part = space[1]
    order = space[2]
    spare = space[3]
    used = 0
    for k in range(len(root)):
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
            axis = _cover(low, high, item, a, b, node_box, m)
            if b - a <= LEAF:
                continue
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
    return used


@inlined
def box_gap(x, y, z, low, high, m):  # type: ignore[no-untyped-def]
    """Squared distance [m2] of a point to box m of low..high (M, 3), 0 inside."""
    u = max(low[m, 0] - x, 0.0, x - high[m, 0])
    v = max(low[m, 1] - y, 0.0, y - high[m, 1])
    w = max(low[m, 2] - z, 0.0, z - high[m, 2])
    return u * u + v * v + w * w


@inlined
def wider(square):  # type: ignore[no-untyped-def]
    """A squared distance widened by rounding: what is pruned against it cannot be the equal of the
    best."""
    return square * (1.0 + 1e-12) + 1e-30
