"""Trees of boxes with up to eight children a node, whose gaps to a point are worked out together.

A search visits a seventh of the nodes that a tree of pairs has it visit, and each visit costs no
more than one of those: the eight boxes lie coordinate after coordinate and are looked at by eight
lanes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.geometry.bvh import half_area
from workbench.geometry.simd8 import LANES, larger, load, not_above, splat8, store

__all__ = [
    "DEEP",
    "EIGHT",
    "SearchSpace",
    "boxes_within",
    "collapse_bvh",
    "point_lanes",
    "search_space",
    "widest",
]

EIGHT = LANES
DEEP = 512
"""Places on a search's stack: seven a level, on 70 levels of the tree of pairs that it was made
from."""


class SearchSpace(NamedTuple):
    """Working space of a search, one for each thread."""

    stack: NDArray[np.int64]
    """(DEEP,) nodes to visit."""
    gaps: NDArray[np.float32]
    """(DEEP + EIGHT,) their squared distances [m2], and those of one node's children."""


def search_space() -> SearchSpace:
    """New working space."""
    return SearchSpace(np.empty(DEEP, dtype=np.int64), np.empty(DEEP + EIGHT, dtype=np.float32))


@inlined
def widest(limit):  # type: ignore[no-untyped-def]
    """More than any square in single precision of a gap within a squared distance: such are off by
    less than 1e-6."""
    return limit * (1.0 + 2e-6) + 1e-37


@inlined
def _between(x):  # type: ignore[no-untyped-def]
    """Numbers of single precision below and above one of double, eight times."""
    spare = 1.2e-7 * abs(x) + 1e-30
    return splat8(np.float32(x - spare)), splat8(np.float32(x + spare))


@inlined
def point_lanes(x, y, z):  # type: ignore[no-untyped-def]
    """A point as `boxes_within` wants it."""
    return _between(x), _between(y), _between(z)


@inlined
def boxes_within(point, box, m, many, limit, gaps):  # type: ignore[no-untyped-def]
    """Bits of those of the `many` boxes of node m that lie within sqrt(limit) of a point; the
    squared distances of all, in single precision and lessened by rounding at the most, into
    gaps[DEEP:DEEP + EIGHT]."""
    (x, x_up), (y, y_up), (z, z_up) = point
    none = splat8(np.float32(0.0))
    at = np.uint64(m) * np.uint64(6 * EIGHT)
    step = np.uint64(EIGHT)
    far = at + step + step + step
    u = larger(larger(load(box, at) - x_up, x - load(box, far)), none)
    v = larger(larger(load(box, at + step) - y_up, y - load(box, far + step)), none)
    w = larger(larger(load(box, at + step + step) - z_up, z - load(box, far + step + step)), none)
    square = u * u + v * v + w * w
    store(gaps, np.uint64(DEEP), square)
    bits = not_above(square, splat8(np.float32(widest(limit))))
    return bits & ((np.uint64(1) << np.uint64(many)) - np.uint64(1))


@inner
def _open_largest(box, link, m, some):  # type: ignore[no-untyped-def]
    """Write up to EIGHT nodes that stand for node m into some: the largest is replaced by its two
    children until there is no room or all are leaves; returns how many."""
    count = 1
    some[0] = m
    while count < EIGHT:
        largest = -1
        best = -1.0
        for k in range(count):
            area = half_area(box, some[k])
            if link[some[k], 0] >= 0 and area > best:
                largest = k
                best = area
        if largest < 0:
            break
        some[count] = link[some[largest], 0] + 1
        some[largest] = link[some[largest], 0]
        count += 1
    return count


@batch_loop
def _collapse(box, link, item, root, wide, child, many, start, space):  # type: ignore[no-untyped-def]
    """Fill wide (M, 6, EIGHT), child (M, EIGHT), many (M,) and start (G,) as `collapse_bvh` gives them;
    returns how many nodes there are. space (3, M + EIGHT): nodes to do,
    what they become, and the children of one."""
    todo = space[0]
    place = space[1]
    some = space[2]
    used = 0
    for g in range(len(root)):
        start[g] = -1
        if root[g] < 0:
            continue
        start[g] = used
        todo[0] = root[g]
        place[0] = used
        waiting = 1
        used += 1
        while waiting > 0:
            waiting -= 1
            at = place[waiting]
            count = _open_largest(box, link, todo[waiting], some)
            many[at] = count
            for k in range(count):
                c = some[k]
                for i in range(6):
                    wide[at, i, k] = box[c, i]
                if link[c, 0] < 0:
                    child[at, k] = -1 - item[link[c, 1]]
                else:
                    child[at, k] = used
                    todo[waiting] = c
                    place[waiting] = used
                    waiting += 1
                    used += 1
    return used


def collapse_bvh(
    box: NDArray[np.float64],
    link: NDArray[np.int64],
    item: NDArray[np.int64],
    root: NDArray[np.int64],
) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.int64], NDArray[np.int64]]:
    """The trees of `split_tree`, whose leaves hold one item each, with up to eight children a node.

    Returns box (M, 6, EIGHT) in single precision, rounded outward: low and high coordinates of each
    child's box; child (M, EIGHT): a node, or -1 less the item of a leaf; many (M,) children; root,
    -1 where empty.
    """
    room = len(box)
    boxes = np.zeros((room, 6, EIGHT))
    many = np.zeros(room, dtype=np.int64)
    child = np.zeros((room, EIGHT), dtype=np.int32)
    start = np.empty(len(root), dtype=np.int64)
    space = np.empty((3, room + EIGHT), dtype=np.int64)
    used = _collapse(box, link, item, root, boxes, child, many, start, space)
    exact = boxes[:used]
    wide = exact.astype(np.float32)
    low = wide[:, :3]
    high = wide[:, 3:]
    wide[:, :3] = np.where(low > exact[:, :3], np.nextafter(low, np.float32(-np.inf)), low)
    wide[:, 3:] = np.where(high < exact[:, 3:], np.nextafter(high, np.float32(np.inf)), high)
    return wide, child[:used].copy(), many[:used].copy(), start
