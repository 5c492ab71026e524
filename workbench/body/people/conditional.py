"""Conditional people: what the other measures are, given some; and how improbable a mix of measures
is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.special import gammaincc

from workbench.body.people.scores import Scores
from workbench.errors import InputError
from workbench.model.arrays import Floats

__all__ = ["Conditional", "Improbability", "condition", "improbability"]


@dataclass(frozen=True, eq=False)
class Conditional:
    """All M measures of P people of whom some measures are given.

    mean (P, M): expected scores; covariance (M, M): of the scores, zero for what is given, the same
    for everybody; values (P, M) [m; kg]: at the mean scores, the given ones as they were given;
    spread (P, M) [m; kg]: half of what lies between one standard deviation below and above.
    """

    names: tuple[str, ...]
    mean: Floats
    covariance: Floats
    values: Floats
    spread: Floats


@dataclass(frozen=True, eq=False)
class Improbability:
    """How far P people with K given measures are from the middle of their population.

    z (P, K): score of each measure by itself; surprise (P, K): score of each given the others,
    large where it contradicts them; distance (P,): Mahalanobis distance; rarer (P,): share of the
    population farther out.
    """

    names: tuple[str, ...]
    z: Floats
    surprise: Floats
    distance: Floats
    rarer: Floats

    def worst(self, person: int = 0) -> tuple[str, float]:
        """The measure that stands out most from the others given, and its score given them."""
        k = int(np.argmax(np.abs(self.surprise[person])))
        return self.names[k], float(self.surprise[person, k])


def condition(scores: Scores, given: Mapping[str, ArrayLike]) -> Conditional:
    """Expect all measures from some: `given` maps a measure to its values (P,) or one value [m;
    kg].

    Of scores that are jointly normal: mean = R_ag R_gg^-1 z_g, covariance = R - R_ag R_gg^-1 R_ga.
    """
    columns, values = _given(scores, given)
    z = scores.to_scores(values, columns)
    every = range(len(scores.names))
    share = _solve(scores, columns, scores.correlation[columns])  # (K, M)
    mean = z @ share
    covariance = scores.correlation - scores.correlation[:, columns] @ share
    covariance = (covariance + covariance.T) / 2
    mean[:, columns] = z
    covariance[columns] = covariance[:, columns] = 0.0
    sd = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    expected = scores.to_values(mean, every)
    expected[:, columns] = values
    spread = (scores.to_values(mean + sd, every) - scores.to_values(mean - sd, every)) / 2
    return Conditional(scores.names, mean, covariance, expected, spread)


def improbability(scores: Scores, given: Mapping[str, ArrayLike]) -> Improbability:
    """Tell how improbable given measures [m; kg] are, each by itself, each given the others, and
    together.

    With K = R_gg^-1: surprise_i = (K z)_i / sqrt(K_ii), distance^2 = z' K z, chi-squared with as
    many degrees of freedom as measures are given.
    """
    columns, values = _given(scores, given)
    z = scores.to_scores(values, columns)
    precision = _solve(scores, columns, np.eye(len(columns)))
    pulled = z @ precision
    distance = np.sqrt(np.maximum((pulled * z).sum(axis=1), 0.0))
    rarer = gammaincc(len(columns) / 2, distance**2 / 2)
    return Improbability(tuple(given), z, pulled / np.sqrt(np.diag(precision)), distance, rarer)


def _given(scores: Scores, given: Mapping[str, ArrayLike]) -> tuple[list[int], Floats]:
    """Columns and values (P, K) of what is given."""
    columns = scores.columns(given)
    if not columns:
        return columns, np.empty((1, 0))
    try:
        each = [np.atleast_1d(np.asarray(value, dtype=np.float64)) for value in given.values()]
        values = np.stack(np.broadcast_arrays(*each), axis=-1)
    except ValueError:
        sizes = ", ".join(f"{name} {np.shape(v)}" for name, v in given.items())
        raise InputError(f"given measures need as many values each, or one, got {sizes}") from None
    for name, column in zip(given, np.moveaxis(values, -1, 0), strict=True):
        if column.ndim != 1 or not np.all((column > 0) & np.isfinite(column)):
            raise InputError(f"{name}: one positive value a person is needed, got {given[name]!r}")
    return columns, values


def _solve(scores: Scores, columns: list[int], right: Any) -> Floats:
    """R_gg^-1 times `right`; InputError where the measures given follow from one another."""
    if not columns:
        return np.empty((0, np.shape(right)[1]))
    try:
        return np.asarray(
            cho_solve(cho_factor(scores.correlation[np.ix_(columns, columns)]), right)
        )
    except LinAlgError:
        names = ", ".join(scores.names[c] for c in columns)
        raise InputError(
            f"{scores!r}: one of these follows exactly from the others: {names}"
        ) from None
