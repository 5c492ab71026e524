"""Thin points so that no two are nearer than a spacing: the accepted points of dart throwing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit

__all__ = ["sample_poisson_disk"]


def sample_poisson_disk(points: NDArray[np.float64], spacing: float) -> NDArray[np.int64]:
    """Return the indices of the points that are kept.

    Each point, in order, is kept unless a kept one is nearer than the spacing.

    Parameters
    ----------
    points
        (n, 3) [m].
    spacing
        [m].
    """
    cell = np.floor((points - points.min(axis=0)) / spacing).astype(np.int64)
    bits = max(4, int(np.ceil(np.log2(2 * len(points) + 2))))
    kept = np.zeros(len(points), dtype=np.bool_)
    _thin(points, cell, spacing * spacing, (1 << bits) - 1, kept)
    return np.flatnonzero(kept)


@njit(cache=True)
def _slot(i, j, k, mask):  # type: ignore[no-untyped-def]
    """Hash a cell of the grid to a slot of the table."""
    return ((i * 73856093) ^ (j * 19349663) ^ (k * 83492791)) & mask


@njit(cache=True)
def _is_free(p, points, cell, square, mask, head, after):  # type: ignore[no-untyped-def]
    """True where no kept point in the 27 cells around point p is nearer than the spacing."""
    for i in range(cell[p, 0] - 1, cell[p, 0] + 2):
        for j in range(cell[p, 1] - 1, cell[p, 1] + 2):
            for k in range(cell[p, 2] - 1, cell[p, 2] + 2):
                q = head[_slot(i, j, k, mask)]
                while q >= 0:
                    u = points[p, 0] - points[q, 0]
                    v = points[p, 1] - points[q, 1]
                    w = points[p, 2] - points[q, 2]
                    if u * u + v * v + w * w < square:
                        return False
                    q = after[q]
    return True


@njit(cache=True)
def _thin(points, cell, square, mask, kept):  # type: ignore[no-untyped-def]
    """Fill kept (n,). A slot of the table is a list of kept points, linked by `after`."""
    head = np.full(mask + 1, -1, np.int64)
    after = np.full(len(points), -1, np.int64)
    for p in range(len(points)):
        if _is_free(p, points, cell, square, mask, head, after):
            slot = _slot(cell[p, 0], cell[p, 1], cell[p, 2], mask)
            after[p] = head[slot]
            head[slot] = p
            kept[p] = True
