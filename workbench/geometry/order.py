"""Sorting for compiled loops: numba compiles NumPy's sorts anew for each kernel that calls one,
seconds each."""

from __future__ import annotations

from workbench.compiled import inner
from workbench.model.arrays import Floats, Ints

__all__ = ["stable_order"]

_RUN = 16


@inner
def stable_order(keys: Floats, count: int, order: Ints, spare: Ints) -> None:
    """Fill order[:count] with the places of keys[:count] (no NaN) from the least on, equal ones as
    they stand: runs sorted by insertion, then merged. spare: room for as many."""
    for begin in range(0, count, _RUN):
        for k in range(begin, min(begin + _RUN, count)):
            place = k
            key = keys[k]
            while place > begin and keys[order[place - 1]] > key:
                order[place] = order[place - 1]
                place -= 1
            order[place] = k
    width = _RUN
    while width < count:
        for begin in range(0, count, 2 * width):
            half = min(begin + width, count)
            end = min(begin + 2 * width, count)
            for k in range(begin, half):
                spare[k] = order[k]
            a = begin
            b = half
            at = begin
            while a < half:
                if b < end and keys[order[b]] < keys[spare[a]]:
                    order[at] = order[b]
                    b += 1
                else:
                    order[at] = spare[a]
                    a += 1
                at += 1
        width *= 2
