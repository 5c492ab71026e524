"""Find the pairs of boxes in a plane that meet, by a sweep along one axis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from workbench.model.arrays import Floats, Ints

__all__ = ["box_pairs", "in_ranges"]


def in_ranges(first: Ints, last: Ints) -> tuple[Ints, Ints]:
    """Return each number of ranges (M,) from `first` to before `last`, and its range, (K,) each."""
    count = last - first
    of = np.repeat(np.arange(len(count)), count)
    return np.arange(len(of)) + np.repeat(first - np.cumsum(count) + count, count), of


def box_pairs(one: Floats, other: Floats) -> tuple[Ints, Ints]:
    """Find which boxes of two sets meet or touch.

    Parameters
    ----------
    one, other
        (M, 4) and (N, 4) least x, y and greatest x, y; infinite ones are allowed.

    Returns
    -------
    tuple[Ints, Ints]
        The boxes (K,) of `one` and (K,) of `other` of each pair, once, in no particular order.
    """
    sweeps = [(axis, _sweep_ranges(one, other, axis)) for axis in range(2)]
    axis, (ahead, back) = min(sweeps, key=lambda sweep: sum(r.size() for r in sweep[1]))
    i_ahead, j_ahead = ahead.pairs()
    j_back, i_back = back.pairs()
    i = np.concatenate([i_ahead, i_back])
    j = np.concatenate([j_ahead, j_back])
    low = 1 - axis
    high = 3 - axis
    meets = one[:, low][i] <= other[:, high][j]
    meets &= other[:, low][j] <= one[:, high][i]
    return i[meets], j[meets]


class _Ranges(NamedTuple):
    """Of each box of a set a range of another set's boxes in their order along an axis."""

    order: Ints
    first: Ints
    last: Ints

    def size(self) -> int:
        """Return the number of pairs."""
        return int(np.sum(self.last - self.first))

    def pairs(self) -> tuple[Ints, Ints]:
        """Return the pairs, (K,) and (K,)."""
        place, box = in_ranges(self.first, self.last)
        return box, self.order[place]


def _sweep_ranges(one: Floats, other: Floats, axis: int) -> tuple[_Ranges, _Ranges]:
    """Return the pairs that meet along an axis: a box of `other` begins within one of `one`, or the
    other way round and later."""
    order = np.argsort(other[:, axis], kind="stable")
    low = other[order, axis]
    first = np.searchsorted(low, one[:, axis], "left")
    last = np.searchsorted(low, one[:, axis + 2], "right")
    ahead = _Ranges(order, first, np.maximum(first, last))
    # one that begins together with the other counted above: here only those that begin later
    order = np.argsort(one[:, axis], kind="stable")
    low = one[order, axis]
    first = np.searchsorted(low, other[:, axis], "right")
    last = np.searchsorted(low, other[:, axis + 2], "right")
    return ahead, _Ranges(order, first, np.maximum(first, last))
