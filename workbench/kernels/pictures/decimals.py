"""Numbers as text with a fixed number of decimals, row by row: drawings hold thousands, one call
for all of them."""

from __future__ import annotations

import math

from workbench.kernels.compiled import njit
from workbench.kernels.order import NONE
from workbench.model.arrays import Floats, Ints

__all__ = ["write_rows"]

_ZERO = 48
_POINT = 46
_MINUS = 45


@njit(cache=True)
def _put(value: float, places: int, out: Ints, at: int) -> int:
    """Write a number from `at` on, rounded half away from zero; where it ends. No minus sign before
    0."""
    unit = 1
    for _ in range(places):
        unit *= 10
    whole = math.floor(abs(value) * unit + 0.5)
    if value < 0.0 and whole > 0:
        out[at] = _MINUS
        at += 1
    digits = places + 1
    rest = whole // (10 * unit)
    while rest > 0:
        digits = digits + 1
        rest = rest // 10
    last = at + digits + (1 if places > 0 else 0)
    k = last - 1
    for n in range(digits):
        if n == places and places > 0:
            out[k] = _POINT
            k -= 1
        out[k] = _ZERO + whole % 10
        whole //= 10
        k -= 1
    return last


@njit(cache=True)
def write_rows(
    values: Floats, places: Ints, words: Ints, word_start: Ints, out: Ints, start: Ints
) -> None:
    """Rows of text into the bytes `out`: word 0, the first of values (M, K) with places[0]
    decimals, word 1, and so on.

    words: the bytes of K + 1 words, each from word_start (K + 2,); start (M + 1,) receives where
    rows begin. Values are finite, with at most 12 digits before the point; out holds 20 bytes a
    value more than the words.
    """
    at = NONE
    for row in range(len(values)):
        start[row] = at
        for k in range(values.shape[1] + 1):
            for n in range(word_start[k], word_start[k + 1]):
                out[at] = words[n]
                at += 1
            if k < values.shape[1]:
                at = _put(values[row, k], places[k], out, at)
    start[len(values)] = at
