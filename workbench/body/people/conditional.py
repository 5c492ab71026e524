"""Condition a population on some measures.

The scores of a population are taken as jointly normal. Then the other measures have a conditional
distribution, and a combination of measures has a probability.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.people.scores import Scores
from workbench.errors import InputError
from workbench.model.arrays import Floats

__all__ = ["Conditional", "Improbability", "condition", "improbability"]


@dataclass(frozen=True, eq=False)
class Conditional:
    """All M measures of P people of whom some measures are given."""

    names: tuple[str, ...]
    mean: Floats
    """(P, M) expected scores."""
    covariance: Floats
    """(M, M) of the scores, the same for everybody; zero for given measures."""
    values: Floats
    """(P, M) [m; kg] at the expected scores; given measures as they were given."""
    spread: Floats
    """(P, M) [m; kg] half of the range from one standard deviation below to one above."""


@dataclass(frozen=True, eq=False)
class Improbability:
    """How far P people with K given measures are from the middle of their population."""

    names: tuple[str, ...]
    z: Floats
    """(P, K) score of each measure by itself."""
    surprise: Floats
    """(P, K) score of each measure given the others; large where it contradicts them."""
    distance: Floats
    """(P,) Mahalanobis distance."""
    rarer: Floats
    """(P,) share of the population that is farther out."""

    def worst(self, person: int = 0) -> tuple[str, float]:
        """Return the measure that contradicts the others most, and its score given them."""
        k = int(np.argmax(np.abs(self.surprise[person])))
        return self.names[k], float(self.surprise[person, k])


def condition(scores: Scores, given: Mapping[str, ArrayLike]) -> Conditional:
    """Compute the conditional distribution of all measures.

    For jointly normal scores with correlation R, of given (g) and all (a) measures:

        mean = R_ag R_gg^-1 z_g,    covariance = R - R_ag R_gg^-1 R_ga.

    Parameters
    ----------
    scores
        The scores of one sex.
    given
        Values [m; kg] by measure, (P,) or one value for everybody.

    Raises
    ------
    InputError
        If a measure is unknown, a value not positive, or a given measure follows from the others.
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
    """Compute how improbable given measures are: each by itself, each given the others, and together.

    With K = R_gg^-1 the score of a measure given the others is (K z)_i / sqrt(K_ii). The squared
    Mahalanobis distance z' K z is chi-squared distributed, with one degree of freedom per measure.

    Parameters
    ----------
    scores
        The scores of one sex.
    given
        Values [m; kg] by measure, (P,) or one value for everybody.

    Raises
    ------
    InputError
        If a measure is unknown, a value not positive, or a given measure follows from the others.
    """
    from scipy.special import gammaincc  # takes a sixth of a second to load

    columns, values = _given(scores, given)
    z = scores.to_scores(values, columns)
    precision = _solve(scores, columns, np.eye(len(columns)))
    weighted = z @ precision
    distance = np.sqrt(np.maximum((weighted * z).sum(axis=1), 0.0))
    rarer = gammaincc(len(columns) / 2, distance**2 / 2)
    surprise = weighted / np.sqrt(np.diag(precision))
    return Improbability(tuple(given), z, surprise, distance, rarer)


def _given(scores: Scores, given: Mapping[str, ArrayLike]) -> tuple[list[int], Floats]:
    """Columns of the given measures, and their values (P, K) [m; kg]."""
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
    """R_gg^-1 times `right` (K, n), by Cholesky's factorization."""
    from scipy.linalg import LinAlgError, cho_factor, cho_solve  # takes a sixth of a second to load

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
