"""Two shares of the same people: the difference with its interval, and whether chance would explain
it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import bdtr, ndtri

from workbench.errors import InputError
from workbench.model.arrays import Bools
from workbench.model.comparison import PairedShare

__all__ = ["paired_share"]


def paired_share(
    before: Bools,
    after: Bools,
    *,
    weight: ArrayLike | None = None,
    confidence: float = 0.95,
    name: str = "",
) -> PairedShare:
    """Compare who is served (P,) before and after, the same people in the same order.

    The interval is that of Newcombe 1998, Statistics in Medicine 17:2635-2650, method 10: Wilson's
    intervals of both shares, squared and added with their correlation. With weights (P,) it is that
    of Kish's effective count. The test is McNemar's (1947), exact, on the people as they are
    counted, weighted or not. InputError where the two do not belong together or nobody is there.
    """
    one = np.asarray(before, dtype=np.bool_)
    two = np.asarray(after, dtype=np.bool_)
    if one.shape != two.shape or one.ndim != 1 or not len(one):
        raise InputError(
            f"two shares are compared person by person; got {one.shape} and {two.shape} values"
        )
    w = np.ones(len(one)) if weight is None else np.asarray(weight, dtype=np.float64)
    if w.shape != one.shape or not np.all((w > 0) & np.isfinite(w)):
        raise InputError(
            f"weights must be positive and one a person; got shape {w.shape} for {len(one)} people"
        )
    if not 0 < confidence < 1:
        raise InputError(f"a confidence lies between 0 and 1, got {confidence:g}")
    table = [
        float(w[mask].sum() / w.sum()) for mask in (one & two, ~one & two, one & ~two, ~one & ~two)
    ]
    low, high = _interval(table, float(w.sum() ** 2 / (w**2).sum()), confidence)
    gainers = int((~one & two).sum())
    losers = int((one & ~two).sum())
    both, gained, lost, neither = table
    return PairedShare(
        name=name,
        before=both + lost,
        after=both + gained,
        both=both,
        gained=gained,
        lost=lost,
        neither=neither,
        gainers=gainers,
        losers=losers,
        count=len(one),
        difference=gained - lost,
        low=low,
        high=high,
        chance=_chance(gainers, losers),
        confidence=confidence,
    )


def _interval(table: list[float], people: float, confidence: float) -> tuple[float, float]:
    """The interval of after - before; table: shares served in both, after only, before only, in
    none."""
    both, gained, lost, _ = table
    after = both + gained
    before = both + lost
    z = float(ndtri((1 + confidence) / 2))
    (l1, u1), (l2, u2) = _wilson(after, people, z), _wilson(before, people, z)
    phi = _correlation(table, people)

    def span(one: float, two: float) -> float:
        return math.sqrt(max(one**2 - 2 * phi * one * two + two**2, 0.0))

    down = span(after - l1, u2 - before)
    up = span(u1 - after, before - l2)
    return max(gained - lost - down, -1.0), min(gained - lost + up, 1.0)


def _correlation(table: list[float], people: float) -> float:
    """Of the two outcomes, brought nearer to zero by a correction for continuity where it is
    positive."""
    both, gained, lost, neither = table
    product = (both + gained) * (lost + neither) * (both + lost) * (gained + neither)
    if product <= 0:
        return 0.0
    cross = both * neither - gained * lost
    if cross > 0:
        cross = max(cross - 0.5 / people, 0.0)
    return cross / math.sqrt(product)


def _wilson(share: float, people: float, z: float) -> tuple[float, float]:
    middle = (share + z**2 / (2 * people)) / (1 + z**2 / people)
    half = (
        z * math.sqrt(share * (1 - share) / people + z**2 / (4 * people**2)) / (1 + z**2 / people)
    )
    return min(max(middle - half, 0.0), share), max(min(middle + half, 1.0), share)


def _chance(gainers: int, losers: int) -> float:
    """Twice the lesser tail of a fair coin thrown once for each who changed."""
    return (
        min(1.0, 2.0 * float(bdtr(min(gainers, losers), gainers + losers, 0.5)))
        if gainers + losers
        else 1.0
    )
