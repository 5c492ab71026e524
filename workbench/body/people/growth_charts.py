"""Compute stature and mass of children by age, sex and percentile, from growth charts.

The charts are those of the CDC [1]_. They hold three parameters by the LMS method [2]_: power L,
median M and coefficient of variation S. A child at the normal score z has

    value = M (1 + L S z)^(1/L),    or M exp(S z) for L = 0.

Parameters are interpolated linearly in age, as the CDC's own programs do.

References
----------
.. [1] R. J. Kuczmarski and others (2002), 2000 CDC growth charts for the United States: methods and
   development, Vital and Health Statistics 11(246).
.. [2] T. J. Cole & P. J. Green (1992), Smoothing reference centile curves: the LMS method and
   penalized likelihood, Statistics in Medicine 11, 1305-1319.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.person import Growth
from workbench.model.population import Population, check_measures, sex_index

__all__ = ["growth_people", "growth_percentile", "growth_values"]

_MIN_PERCENTILE = 0.1
_MAX_PERCENTILE = 99.9
"""The curves are fitted from the 3rd to the 97th percentile; farther out than this they are
guesses."""
_LOGNORMAL = 1e-6
"""Power L below which a measure counts as lognormal."""


def growth_values(growth: Growth, sex: str, percentiles: ArrayLike, *, age: float) -> Floats:
    """Compute the measures of children of one age at given percentiles.

    Parameters
    ----------
    growth
        The growth charts.
    sex
        "male" or "female".
    percentiles
        (P,) [%], 0.1 to 99.9.
    age
        Age [years].

    Returns
    -------
    Floats
        (P, M) [m; kg].

    Raises
    ------
    InputError
        If a percentile or the age is out of the range of the charts.
    """
    from scipy.special import ndtri  # takes a sixth of a second to load

    levels = np.atleast_1d(np.asarray(percentiles, dtype=np.float64))
    wrong = levels[~((levels >= _MIN_PERCENTILE) & (levels <= _MAX_PERCENTILE))]
    if wrong.size:
        raise InputError(
            f"{growth.name}: percentiles from {_MIN_PERCENTILE:g} to {_MAX_PERCENTILE:g} are known, got {wrong[0]:g}"
        )
    power, median, spread = _curve(growth, sex, age).T
    z = ndtri(levels / 100)[:, None]
    lognormal = np.abs(power) < _LOGNORMAL
    safe_power = np.where(lognormal, 1.0, power)
    powered = (1 + safe_power * spread * z) ** (1 / safe_power)
    return np.asarray(median * np.where(lognormal, np.exp(spread * z), powered))


def growth_percentile(
    growth: Growth, sex: str, measure: str, values: ArrayLike, *, age: float
) -> Floats:
    """Compute the percentiles of values of one measure, among children of one age.

    Parameters
    ----------
    growth, sex
        The growth charts, and "male" or "female".
    measure
        Name of the measure.
    values
        (...) [m; kg].
    age
        Age [years].

    Returns
    -------
    Floats
        (...) [%].

    Raises
    ------
    InputError
        If a value is not positive, or measure or age are not in the charts.
    """
    from scipy.special import ndtr  # takes a sixth of a second to load

    x = np.asarray(values, dtype=np.float64)
    if not np.all((x > 0) & np.isfinite(x)):
        raise InputError(f"{measure}: positive values are needed, got {values!r}")
    check_measures([measure], growth.names)
    power, median, spread = _curve(growth, sex, age)[growth.names.index(measure)]
    if abs(power) < _LOGNORMAL:
        return np.asarray(100 * ndtr(np.log(x / median) / spread))
    return np.asarray(100 * ndtr(((x / median) ** power - 1) / (power * spread)))


def growth_people(growth: Growth, sex: str, percentiles: ArrayLike, *, age: float) -> Population:
    """Return one child of an age [years] for each percentile [%], with all measures at that percentile.

    Raises
    ------
    InputError
        If a percentile or the age is out of the range of the charts.
    """
    values = growth_values(growth, sex, percentiles, age=age)
    levels = np.atleast_1d(np.asarray(percentiles, dtype=np.float64))
    codes = np.full(len(levels), sex_index(sex))
    labels = tuple(f"{level:g} %" for level in levels)
    return Population(
        growth.names, codes, np.ones(len(levels)), values, f"{growth.name}, {age:g} years", labels
    )


def _curve(growth: Growth, sex: str, age: float) -> Floats:
    """(M, 3) parameters L, M and S at an age [years].

    The charts begin at 24 months, half a month before their first row; the line through the first two
    rows is extended to there.
    """
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
