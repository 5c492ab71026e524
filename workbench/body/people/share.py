"""Accommodation: the share of people who are served, with its confidence interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from workbench.errors import InputError
from workbench.model.arrays import Bools

__all__ = [
    "TENTHS_FROM",
    "Share",
    "bootstrap_share",
    "percent",
    "percent_number",
    "share_of",
]

TENTHS_FROM = 500
"""People from which a share is shown to a tenth of a percent. Of fewer one person is more than 0.2
%."""


@dataclass(frozen=True)
class Share:
    """A share of people, 0 to 1, and the interval low to high that holds the true one with this
    confidence."""

    share: float
    low: float
    high: float
    count: int
    method: str
    confidence: float

    def __str__(self) -> str:
        share, low, high = (
            percent_number(value, self.count) for value in (self.share, self.low, self.high)
        )
        return f"{share} % of {self.count} people ({100 * self.confidence:g} % confidence: {low} to {high} %)"


def percent(share: float, count: int) -> str:
    """Write a share of so many people: "81 %", and "81.3 %" from TENTHS_FROM people on.

    What is not all or nothing is never rounded to it: "under 1 %", "over 99.9 %".
    """
    least = 0.001 if count >= TENTHS_FROM else 0.01
    if 1e-9 < share <= least / 2:
        return f"under {100 * least:g} %"
    if 1 - least / 2 <= share < 1 - 1e-9:
        return f"over {100 * (1 - least):g} %"
    return f"{percent_number(share, count)} %"


def percent_number(share: float, count: int) -> str:
    """Write a share of so many people, or a difference of shares, as a number of percent: "81",
    "81.3", "-0.4".

    A half goes to the even digit, however the share was added up: of 200 people 17 are 8 % and the
    other 183 are 92 %.
    """
    places = 1 if count >= TENTHS_FROM else 0
    digits = round(round(100 * 10**places * share, 6))
    return f"{digits / 10**places:.{places}f}"


def share_of(served: Bools, *, weight: ArrayLike | None = None, confidence: float = 0.95) -> Share:
    """The share of the people served (P,), with the score interval of Wilson (1927).

    With weights (P,) the interval is that of Kish's effective count, (sum w)^2 / sum w^2.
    """
    inside = np.asarray(served, dtype=np.bool_)
    if inside.ndim != 1 or not len(inside):
        raise InputError(
            f"a share needs one person or more, one value each; got an array of shape {inside.shape}"
        )
    if not 0 < confidence < 1:
        raise InputError(f"an interval needs a confidence between 0 and 1, got {confidence:g}")
    w = np.ones(len(inside)) if weight is None else np.asarray(weight, dtype=np.float64)
    if w.shape != inside.shape or not np.all((w > 0) & np.isfinite(w)):
        raise InputError(
            f"weights must be positive and one a person; got shape {w.shape} for {len(inside)} people"
        )
    share = float(w[inside].sum() / w.sum())
    people = float(w.sum() ** 2 / (w**2).sum())
    low, high = _wilson(share, people, confidence)
    return Share(share, min(low, share), max(high, share), len(inside), "wilson", confidence)


def bootstrap_share(
    served: Bools,
    *,
    weight: ArrayLike | None = None,
    strata: ArrayLike | None = None,
    seed: int,
    draws: int = 10_000,
    confidence: float = 0.95,
) -> Share:
    """The share of the people served (P,) with the percentile interval of the bootstrap (Efron
    1979).

    As many people are drawn again, with replacement, `draws` times; from each of the strata (P,) as
    many as it has, whose part of all weight (P,) stays as it is. People of the same stratum, weight
    and verdict are alike, so it is their numbers that are drawn, which is the same and quicker. The
    same seed gives the same interval.
    """
    found = share_of(served, weight=weight, confidence=confidence)
    inside = np.asarray(served, dtype=np.bool_)
    w = np.ones(len(inside)) if weight is None else np.asarray(weight, dtype=np.float64)
    group = np.zeros(len(inside), np.int64) if strata is None else np.asarray(strata)
    stream = np.random.Generator(np.random.PCG64(seed))
    shares = np.zeros(draws)
    for name in np.unique(group):
        own = group == name
        cells, count = np.unique(np.stack([w[own], inside[own]]), axis=1, return_counts=True)
        drawn = stream.multinomial(count.sum(), count / count.sum(), size=draws) * cells[0]
        shares += (drawn @ cells[1]) / drawn.sum(axis=1) * (w[own].sum() / w.sum())
    tail = (1 - confidence) / 2
    low, high = np.quantile(shares, [tail, 1 - tail], method="inverted_cdf")
    return Share(found.share, float(low), float(high), found.count, "bootstrap", confidence)


def _wilson(share: float, people: float, confidence: float) -> tuple[float, float]:
    z = float(ndtri((1 + confidence) / 2))
    middle = (share + z**2 / (2 * people)) / (1 + z**2 / people)
    half = (
        z
        * float(np.sqrt(share * (1 - share) / people + z**2 / (4 * people**2)))
        / (1 + z**2 / people)
    )
    return max(middle - half, 0.0), min(middle + half, 1.0)
