"""Trees of boxes with up to eight children a node, whose gaps to a point are worked out together.

A search visits a seventh of the nodes that a tree of pairs has it visit, and each visit costs about two of those: the
eight boxes lie coordinate after coordinate, so that the compiler takes several at once.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["DEEP", "EIGHT", "box_gaps", "widened"]

EIGHT = 8
DEEP = 512
"""Places on a search's stack: seven a level, on 70 levels of the tree of pairs that it was made from."""


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def box_gaps(x, y, z, box, m, gaps):  # type: ignore[no-untyped-def]
    """Squared distances of a point to the eight boxes of node m, into gaps[DEEP:DEEP + EIGHT]."""
    for k in range(EIGHT):
        u = max(max(box[m, 0, k] - x, x - box[m, 3, k]), 0.0)
        v = max(max(box[m, 1, k] - y, y - box[m, 4, k]), 0.0)
        w = max(max(box[m, 2, k] - z, z - box[m, 5, k]), 0.0)
        gaps[DEEP + k] = u * u + v * v + w * w


@njit(cache=True, error_model="numpy")
def _collapsed(box, link, item, root):  # type: ignore[no-untyped-def]
    room = box.shape[0]
    wide, many = np.zeros((room, 6, EIGHT)), np.zeros(room, np.int64)
    child, start = np.zeros((room, EIGHT), np.int32), np.full(root.shape[0], -1, np.int64)
    todo, place, some, used = np.empty(room, np.int64), np.empty(room, np.int64), np.empty(EIGHT, np.int64), 0
    for g in range(root.shape[0]):
        if root[g] < 0:
            continue
        start[g], todo[0], place[0], waiting = used, root[g], used, 1
        used += 1
        while waiting > 0:
            waiting -= 1
            m, at, count = todo[waiting], place[waiting], 1
            some[0] = m
            while count < EIGHT:
                largest, best = -1, -1.0
                for k in range(count):
                    c = some[k]
                    u, v, w = box[c, 3] - box[c, 0], box[c, 4] - box[c, 1], box[c, 5] - box[c, 2]
                    if link[c, 0] >= 0 and u * v + v * w + w * u > best:
                        largest, best = k, u * v + v * w + w * u
                if largest < 0:
                    break
                some[count] = link[some[largest], 0] + 1
                some[largest] = link[some[largest], 0]
                count += 1
            many[at] = count
            for k in range(count):
                c = some[k]
                for i in range(6):
                    wide[at, i, k] = box[c, i]
                if link[c, 0] < 0:
                    child[at, k] = -1 - item[link[c, 1]]
                else:
                    child[at, k], todo[waiting], place[waiting] = used, c, used
                    waiting += 1
                    used += 1
    return wide[:used], child[:used], many[:used], start


def widened(
    box: NDArray[np.float64], link: NDArray[np.int64], item: NDArray[np.int64], root: NDArray[np.int64]
) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.int64], NDArray[np.int64]]:
    """The trees of `split_tree`, whose leaves hold one item each, with up to eight children a node.

    Returns box (M, 6, EIGHT) in single precision, rounded outward: low and high coordinates of each child's box; child
    (M, EIGHT): a node, or -1 less the item of a leaf; many (M,) children; root, -1 where empty.
    """
    exact, child, many, start = _collapsed(box, link, item, root)
    wide = exact.astype(np.float32)
    low, high = wide[:, :3], wide[:, 3:]
    wide[:, :3] = np.where(low > exact[:, :3], np.nextafter(low, np.float32(-np.inf)), low)
    wide[:, 3:] = np.where(high < exact[:, 3:], np.nextafter(high, np.float32(np.inf)), high)
    return wide, child, many, start
