"""Growing children: stature and mass by age, sex and percentile, and the percentile of a child.

Growth charts of the CDC (Kuczmarski et al. 2002, Vital Health Stat 11(246)), method of Cole & Green
1992: value = M (1 + L S z)^(1/L), or M exp(S z) where L = 0; L, M and S are interpolated in age as
the CDC's own programs do.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr, ndtri

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.growth import Growth
from workbench.model.measures import check_measures
from workbench.model.population import Population, sex_index

__all__ = ["growth_people", "growth_percentile", "growth_values"]

# The curves rest on the 3rd to 97th percentile; farther out than this they are guesses.
LEAST = 0.1
MOST = 99.9


def growth_values(growth: Growth, sex: str, percentiles: ArrayLike, *, age: float) -> Floats:
    """(P, M) values [m; kg] of children of one age [years] at percentiles (P,) [%], 0.1 to 99.9."""
    levels = np.atleast_1d(np.asarray(percentiles, dtype=np.float64))
    wrong = levels[~((levels >= LEAST) & (levels <= MOST))]
    if wrong.size:
        raise InputError(
            f"{growth.name}: percentiles from {LEAST:g} to {MOST:g} are known, got {wrong[0]:g}"
        )
    power, median, spread = _curve(growth, sex, age).T
    z = ndtri(levels / 100)[:, None]
    flat = np.abs(power) < 1e-6
    safe = np.where(flat, 1.0, power)
    return np.asarray(
        median * np.where(flat, np.exp(spread * z), (1 + safe * spread * z) ** (1 / safe))
    )


def growth_percentile(
    growth: Growth, sex: str, measure: str, values: ArrayLike, *, age: float
) -> Floats:
    """(...) percentiles [%] of values [m; kg] of one measure among children of one age [years]."""
    x = np.asarray(values, dtype=np.float64)
    if not np.all((x > 0) & np.isfinite(x)):
        raise InputError(f"{measure}: positive values are needed, got {values!r}")
    check_measures([measure], growth.names)
    power, median, spread = _curve(growth, sex, age)[growth.names.index(measure)]
    if abs(power) < 1e-6:
        return np.asarray(100 * ndtr(np.log(x / median) / spread))
    return np.asarray(100 * ndtr(((x / median) ** power - 1) / (power * spread)))


def growth_people(growth: Growth, sex: str, percentiles: ArrayLike, *, age: float) -> Population:
    """One child for each percentile [%]: every measure of the charts at that percentile, age in
    years."""
    values = growth_values(growth, sex, percentiles, age=age)
    levels = np.atleast_1d(np.asarray(percentiles, dtype=np.float64))
    codes = np.full(len(levels), sex_index(sex))
    labels = tuple(f"{level:g} %" for level in levels)
    return Population(
        growth.names, codes, np.ones(len(levels)), values, f"{growth.name}, {age:g} years", labels
    )


def _curve(growth: Growth, sex: str, age: float) -> Floats:
    """(M, 3) L, M, S at an age [years]; the charts begin at 24 months, half a month before their
    first row, to which the first two rows are carried on."""
    months = 12 * age
    low = np.floor(growth.age[0])
    high = growth.age[-1]
    if not low <= months <= high:
        raise InputError(
            f"{growth.name}: ages from {low / 12:g} to {high / 12:g} years are known, got {age:g}"
        )
    row = int(np.clip(np.searchsorted(growth.age, months) - 1, 0, len(growth.age) - 2))
    step = (months - growth.age[row]) / (growth.age[row + 1] - growth.age[row])
    table = growth.lms[sex_index(sex)]
    return np.asarray(table[:, row] + step * (table[:, row + 1] - table[:, row]))
