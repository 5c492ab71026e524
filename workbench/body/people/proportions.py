"""Estimate the share of people who are accommodated, and the difference of two shares of the same
people, each with its confidence interval."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats
from workbench.model.comparison import PairedShare

__all__ = [
    "TENTHS_FROM",
    "Share",
    "bootstrap_share",
    "checked_weights",
    "effective_count",
    "paired_share",
    "percent",
    "percent_number",
    "percent_parts",
    "proportion_interval",
    "wilson_interval",
]

TENTHS_FROM = 500
"""Number of people from which on a share is shown to a tenth of a percent. Of fewer people, one
person is more than 0.2 %."""


@dataclass(frozen=True)
class Share:
    """A share of people, and the confidence interval that holds the true share."""

    share: float
    """0 to 1."""
    low: float
    """Lower end of the interval."""
    high: float
    """Upper end of the interval."""
    count: int
    """Number of people."""
    method: str
    """"wilson" or "bootstrap"."""
    confidence: float
    """Confidence level, 0 to 1."""

    def __str__(self) -> str:
        share, low, high = (
            percent_number(value, self.count) for value in (self.share, self.low, self.high)
        )
        return f"{share} % of {self.count} people ({100 * self.confidence:g} % confidence: {low} to {high} %)"


def percent(share: float, count: int) -> str:
    """Write a share of a number of people: "81 %", and "81.3 %" from TENTHS_FROM people on.

    A share that is neither 0 nor 1 is never rounded to them: "under 1 %", "over 99.9 %".
    """
    least = 0.001 if count >= TENTHS_FROM else 0.01
    if 1e-9 < share <= least / 2 + 1e-9:
        return f"under {100 * least:g} %"
    if 1 - least / 2 - 1e-9 <= share < 1 - 1e-9:
        return f"over {100 * (1 - least):g} %"
    return f"{percent_number(share, count)} %"


def percent_parts(shares: Sequence[float], count: int) -> list[str]:
    """Write the shares of a whole so that their percentages add to 100, by largest remainders.

    Each is rounded down; what is missing then goes to those that lost most by it, among equals to
    those that `percent_number` would round up.

    Parameters
    ----------
    shares
        0 to 1, with the sum 1.
    count
        Number of people.
    """
    whole = 1000 if count >= TENTHS_FROM else 100
    exact = [round(whole * share, 6) for share in shares]
    digits = [math.floor(value) for value in exact]
    order = sorted(
        range(len(shares)),
        key=lambda k: (digits[k] - exact[k], digits[k] - round(exact[k])),
    )
    for k in order[: whole - sum(digits)]:
        digits[k] += 1
    parts = zip(shares, digits, strict=True)
    return [percent(number / whole if number else share, count) for share, number in parts]


def percent_number(share: float, count: int) -> str:
    """Write a share, or a difference of shares, as a number of percent: "81", "81.3", "-0.4".

    A half is rounded to the even digit, independent of the order of summation: of 200 people, 17 are
    8 % and the other 183 are 92 %.
    """
    places = 1 if count >= TENTHS_FROM else 0
    digits = round(round(100 * 10**places * share, 6))
    return f"{digits / 10**places:.{places}f}"


def proportion_interval(
    served: Bools, *, weight: ArrayLike | None = None, confidence: float = 0.95
) -> Share:
    """Estimate the share of accommodated people, with Wilson's score interval.

    Weighted people count as Kish's effective number, (sum w)^2 / sum w^2.

    Parameters
    ----------
    served
        (P,) True for people who are accommodated.
    weight
        (P,) positive weights; equal if None.
    confidence
        Confidence level, between 0 and 1.

    Raises
    ------
    InputError
        If there are no people, or weights or confidence are not valid.

    References
    ----------
    Wilson, E. B. (1927), Probable inference, the law of succession, and statistical inference,
    Journal of the American Statistical Association 22, 209-212.
    """
    inside = np.asarray(served, dtype=np.bool_)
    if inside.ndim != 1 or not len(inside):
        raise InputError(
            f"a share needs one person or more, one value each; got an array of shape {inside.shape}"
        )
    if not 0 < confidence < 1:
        raise InputError(f"an interval needs a confidence between 0 and 1, got {confidence:g}")
    w = checked_weights(weight, len(inside))
    share = float(w[inside].sum() / w.sum())
    low, high = wilson_interval(share, effective_count(w), confidence)
    return Share(share, min(low, share), max(high, share), len(inside), "wilson", confidence)


def checked_weights(weight: ArrayLike | None, people: int) -> Floats:
    """Return the weights (P,) of people, ones if None.

    Raises
    ------
    InputError
        If they are not positive, or not one a person.
    """
    w = np.ones(people) if weight is None else np.asarray(weight, dtype=np.float64)
    if w.shape != (people,) or not np.all((w > 0) & np.isfinite(w)):
        raise InputError(
            f"weights must be positive and one a person; got shape {w.shape} for {people} people"
        )
    return w


def effective_count(weight: Floats) -> float:
    """Return Kish's effective number of people with weights (P,), (sum w)^2 / sum w^2."""
    return float(weight.sum() ** 2 / (weight**2).sum())


def bootstrap_share(
    served: Bools,
    *,
    weight: ArrayLike | None = None,
    strata: ArrayLike | None = None,
    seed: int,
    draws: int = 10_000,
    confidence: float = 0.95,
) -> Share:
    """Estimate the share of accommodated people, with the percentile interval of the bootstrap.

    Each of `draws` times, as many people are drawn with replacement from each stratum as it has. A
    stratum keeps its share of all weight. People of the same stratum, weight and verdict are alike, so
    their numbers are drawn, from a multinomial distribution. The same seed gives the same interval.

    Parameters
    ----------
    served
        (P,) True for people who are accommodated.
    weight, strata
        (P,) positive weights, and labels of strata; equal if None.
    seed
        0 or more.
    draws
        Number of resamples.
    confidence
        Confidence level, between 0 and 1.

    Raises
    ------
    InputError
        As for `proportion_interval`.

    References
    ----------
    Efron, B. (1979), Bootstrap methods: another look at the jackknife, Annals of Statistics 7, 1-26.
    """
    found = proportion_interval(served, weight=weight, confidence=confidence)
    inside = np.asarray(served, dtype=np.bool_)
    w = checked_weights(weight, len(inside))
    stratum = np.zeros(len(inside), np.int64) if strata is None else np.asarray(strata)
    stream = np.random.Generator(np.random.PCG64(seed))
    shares = np.zeros(draws)
    for name in np.unique(stratum):
        own = stratum == name
        resampled = _resampled_shares(inside[own], w[own], draws, stream)
        shares += resampled * (w[own].sum() / w.sum())
    tail = (1 - confidence) / 2
    low, high = np.quantile(shares, [tail, 1 - tail], method="inverted_cdf")
    return Share(found.share, float(low), float(high), found.count, "bootstrap", confidence)


def _resampled_shares(
    inside: Bools, weight: Floats, draws: int, stream: np.random.Generator
) -> Floats:
    """(draws,) weighted shares of as many people (P,), drawn with replacement."""
    cells, count = np.unique(np.stack([weight, inside]), axis=1, return_counts=True)
    drawn = stream.multinomial(count.sum(), count / count.sum(), size=draws) * cells[0]
    return np.asarray((drawn @ cells[1]) / drawn.sum(axis=1))


def wilson_interval(share: float, people: float, confidence: float) -> tuple[float, float]:
    """Compute Wilson's score interval of a share of an effective number of people.

    (p + z^2 / 2n +- z sqrt(p (1 - p) / n + z^2 / 4n^2)) / (1 + z^2 / n), within 0 and 1.
    """
    from scipy.special import ndtri  # takes a sixth of a second to load

    z = float(ndtri((1 + confidence) / 2))
    middle = (share + z**2 / (2 * people)) / (1 + z**2 / people)
    half = (
        z
        * float(np.sqrt(share * (1 - share) / people + z**2 / (4 * people**2)))
        / (1 + z**2 / people)
    )
    return max(middle - half, 0.0), min(middle + half, 1.0)


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
