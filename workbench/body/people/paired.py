"""Compare two shares of the same people: the difference, its interval, and a test."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.people.share import checked_weights, effective_count, wilson_interval
from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats
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
    """Compare who is accommodated before and after a change.

    The interval of the difference is Newcombe's [1]_. Weighted people count as Kish's effective
    number. The test is McNemar's [2]_, exact, on the unweighted people.

    Parameters
    ----------
    before, after
        (P,) True for people who are accommodated, the same people in the same order.
    weight
        (P,) positive weights; equal if None.
    confidence
        Confidence level, between 0 and 1.
    name
        Of the comparison.

    Raises
    ------
    InputError
        If the people differ or there are none, or weights or confidence are not valid.

    References
    ----------
    .. [1] R. G. Newcombe (1998), Improved confidence intervals for the difference between binomial
       proportions based on paired data, Statistics in Medicine 17, 2635-2650, method 10.
    .. [2] Q. McNemar (1947), Note on the sampling error of the difference between correlated
       proportions or percentages, Psychometrika 12, 153-157.
    """
    one = np.asarray(before, dtype=np.bool_)
    two = np.asarray(after, dtype=np.bool_)
    if one.shape != two.shape or one.ndim != 1 or not len(one):
        raise InputError(
            f"two shares are compared person by person; got {one.shape} and {two.shape} values"
        )
    w = checked_weights(weight, len(one))
    if not 0 < confidence < 1:
        raise InputError(f"a confidence lies between 0 and 1, got {confidence:g}")
    table = _FourfoldTable.of(one, two, w)
    low, high = _newcombe_interval(table, effective_count(w), confidence)
    gainers = int((~one & two).sum())
    losers = int((one & ~two).sum())
    return PairedShare(
        name=name,
        before=table.before,
        after=table.after,
        both=table.both,
        gained=table.gained,
        lost=table.lost,
        neither=table.neither,
        gainers=gainers,
        losers=losers,
        count=len(one),
        difference=table.gained - table.lost,
        low=low,
        high=high,
        chance=_mcnemar_p_value(gainers, losers),
        confidence=confidence,
    )


@dataclass(frozen=True)
class _FourfoldTable:
    """Shares of the people by their two outcomes; they add up to 1."""

    both: float
    gained: float
    """Accommodated after, but not before."""
    lost: float
    """Accommodated before, but not after."""
    neither: float

    @classmethod
    def of(cls, before: Bools, after: Bools, weight: Floats) -> _FourfoldTable:
        """Sum the weights (P,) of each combination."""
        masks = (before & after, ~before & after, before & ~after, ~before & ~after)
        return cls(*(float(weight[mask].sum() / weight.sum()) for mask in masks))

    @property
    def before(self) -> float:
        """Share before."""
        return self.both + self.lost

    @property
    def after(self) -> float:
        """Share after."""
        return self.both + self.gained


def _newcombe_interval(
    table: _FourfoldTable, people: float, confidence: float
) -> tuple[float, float]:
    """Interval of after - before, for an effective number of people.

    With Wilson's intervals l..u of both shares p, and the correlation phi of the outcomes, the
    lower end lies sqrt(a^2 - 2 phi a b + b^2) below the difference, a = p_after - l_after and
    b = u_before - p_before; the upper end likewise.
    """
    after = table.after
    before = table.before
    after_low, after_high = _wilson_around(after, people, confidence)
    before_low, before_high = _wilson_around(before, people, confidence)
    phi = _outcome_correlation(table, people)

    def combine(one: float, two: float) -> float:
        return math.sqrt(max(one**2 - 2 * phi * one * two + two**2, 0.0))

    below = combine(after - after_low, before_high - before)
    above = combine(after_high - after, before - before_low)
    difference = table.gained - table.lost
    return max(difference - below, -1.0), min(difference + above, 1.0)


def _wilson_around(share: float, people: float, confidence: float) -> tuple[float, float]:
    """Wilson's interval, which holds the share itself in spite of rounding."""
    low, high = wilson_interval(share, people, confidence)
    return min(low, share), max(high, share)


def _outcome_correlation(table: _FourfoldTable, people: float) -> float:
    """Correlation of the two outcomes; Newcombe's continuity correction lowers a positive one."""
    both, gained, lost, neither = table.both, table.gained, table.lost, table.neither
    product = (both + gained) * (lost + neither) * (both + lost) * (gained + neither)
    if product <= 0:
        return 0.0
    cross = both * neither - gained * lost
    if cross > 0:
        cross = max(cross - 0.5 / people, 0.0)
    return cross / math.sqrt(product)


def _mcnemar_p_value(gainers: int, losers: int) -> float:
    """Two-sided p-value: twice the lesser tail of a fair coin, thrown once for each who changed."""
    from scipy.special import bdtr  # takes a sixth of a second to load

    changed = gainers + losers
    if not changed:
        return 1.0
    return min(1.0, 2.0 * float(bdtr(min(gainers, losers), changed, 0.5)))
