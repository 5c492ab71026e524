"""Thinning of points so that no two are nearer than a spacing: the accepted darts of dart
throwing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit

__all__ = ["thin_points"]


def thin_points(points: NDArray[np.float64], spacing: float) -> NDArray[np.int64]:
    """Numbers of the points (n, 3) that stay when each, in order, is kept unless a kept one is
    nearer than spacing."""
    cell = np.floor((points - points.min(axis=0)) / spacing).astype(np.int64)
    bits = max(4, int(np.ceil(np.log2(2 * len(points) + 2))))
    kept = np.zeros(len(points), dtype=np.bool_)
    _thin(points, cell, spacing * spacing, (1 << bits) - 1, kept)
    return np.flatnonzero(kept)


@njit(cache=True)
def _slot(i, j, k, mask):  # type: ignore[no-untyped-def]
    return ((i * 73856093) ^ (j * 19349663) ^ (k * 83492791)) & mask


@njit(cache=True)
def _thin(points, cell, square, mask, kept):  # type: ignore[no-untyped-def]
    head = np.full(mask + 1, -1, np.int64)
    after = np.full(len(points), -1, np.int64)
    for p in range(len(points)):
        free = True
        for i in range(cell[p, 0] - 1, cell[p, 0] + 2):
            for j in range(cell[p, 1] - 1, cell[p, 1] + 2):
                for k in range(cell[p, 2] - 1, cell[p, 2] + 2):
                    q = head[_slot(i, j, k, mask)]
                    while q >= 0 and free:
                        u = points[p, 0] - points[q, 0]
                        v = points[p, 1] - points[q, 1]
                        w = points[p, 2] - points[q, 2]
                        free = u * u + v * v + w * w >= square
                        q = after[q]
                    if not free:
                        break
                if not free:
                    break
            if not free:
                break
        if free:
            slot = _slot(cell[p, 0], cell[p, 1], cell[p, 2], mask)
            after[p] = head[slot]
            head[slot] = p
            kept[p] = True
