"""Find what intervals leave of many lines or rims at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from workbench.model.arrays import Floats, Ints

__all__ = ["Gaps", "gaps_along", "gaps_round"]

_LEAST_ROUND = 1e-12
"""[rad] A gap of a rim no wider than this is rounding."""
_LEAST_ALONG = 1e-9
"""[rad] or share of a line: the same of a line, whose ends lie hundreds of pixels off."""


class Gaps(NamedTuple):
    """What no interval covers, in the order of the items and along each."""

    item: Ints
    """(G,)."""
    low: Floats
    """(G,) where a gap begins, and (G,) where it ends."""
    high: Floats
    before: Ints
    """(G,) the interval that ends where a gap begins, and (G,) the one that begins at its end."""
    after: Ints


def gaps_round(item: Ints, start: Floats, end: Floats, turn: float) -> Gaps:
    """Find what intervals leave of closed rims, as far as those have any interval.

    Parameters
    ----------
    item, start, end
        (K,) the rim, the beginning and the end of each interval; none is longer than two turns.
    turn
        Length of a rim.

    Returns
    -------
    Gaps
        Their beginnings are within a turn of the rim's first interval.
    """
    low = start % turn
    return _gaps(item, low, low + (end - start), turn, _LEAST_ROUND)


def gaps_along(item: Ints, start: Floats, end: Floats, length: Floats) -> Gaps:
    """Find what intervals leave of lines, from 0 to their lengths.

    Parameters
    ----------
    item, start, end
        (K,) the line, the beginning and the end of each interval.
    length
        (M,) of all lines.

    Returns
    -------
    Gaps
        `before` is -1 where a gap begins at 0; `after` is K or more where it ends with the line.
    """
    lines = np.arange(len(length))
    return _gaps(
        np.concatenate([item, lines]),
        np.concatenate([start, length]),
        np.concatenate([end, length]),
        None,
        _LEAST_ALONG,
    )


def _gaps(item: Ints, start: Floats, end: Floats, turn: float | None, least: float) -> Gaps:
    """Find the gaps before intervals: on a line (`turn` is None) from 0 on, on a rim from the end
    of the interval that reaches farthest into the next turn."""
    if not len(item):
        return Gaps(item, start, end, item, item)
    order = np.lexsort((start, item))
    farness = np.lexsort((end, item))
    rank = np.empty(len(item), dtype=np.int64)
    rank[farness] = np.arange(len(item))
    sorted_item = item[order]
    # of the intervals of its item up to each, the one that reaches farthest
    farthest = farness[np.maximum.accumulate(rank[order])]
    is_first = np.diff(sorted_item, prepend=-1) > 0
    before = np.concatenate([[-1], farthest[:-1]])
    reach = np.where(is_first, -np.inf, end[before])
    if turn is None:
        floor = np.zeros(len(item))
        floor_of = np.full(len(item), -1)
    else:
        blocks = np.flatnonzero(is_first)
        count = np.diff(blocks, append=len(item))
        floor_of = np.repeat(farthest[blocks + count - 1], count)
        floor = end[floor_of] - turn
    before = np.where(reach >= floor, before, floor_of)
    reach = np.maximum(reach, floor)
    high = start[order]
    gap = np.flatnonzero(high > reach + least)
    return Gaps(sorted_item[gap], reach[gap], high[gap], before[gap], order[gap])
