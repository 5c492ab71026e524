"""Figures and names as they are read: a tenth of a millimetre or a degree, and finer where a tenth hides a
difference."""

from __future__ import annotations

__all__ = ["plain", "tenths"]

FINEST = 6
"""Decimals at most: a nanometre in millimetres, below which nothing counts as a breach."""


def tenths(value: float, limit: float = 0.0) -> str:
    """Write a number with one decimal, or with as many as tell it from its limit.

    "12.4"; "30.04" beside a limit of 30, "65.84" beside one of 65.86; "0.0001" beside a limit of 0 of 0.00006; "0.0" of what is no
    farther than 1e-6 from it; never "-0.0".
    """
    for places in range(1, FINEST + 1):
        text = f"{value:.{places}f}"
        if float(text) != round(limit, places) and round(abs(value - limit), places) > 0:
            return text
    text = f"{value:.1f}"
    return text[1:] if text == "-0.0" else text


def plain(name: str) -> str:
    """A name from a file, or a sentence with such names, as words: nothing else writes names for reading."""
    return name.replace("_", " ")
