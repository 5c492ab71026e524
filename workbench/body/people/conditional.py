"""Condition a population on some measures.

The measures of one sex become standard normal scores. Scores of real people are z-scores, (value -
mean) / sd, with Pearson's correlation; those of a model are normal scores of a Gaussian copula, exact
at every quantile of its tables. Scores are taken as jointly normal. Then the other measures have a
conditional distribution, and a combination of measures has a probability.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.population import Population, PopulationModel, check_measures, sex_index

__all__ = [
    "Conditional",
    "Improbability",
    "Scores",
    "conditional_distribution",
    "mahalanobis_distance",
    "normal_scores",
    "scores_of",
]


@dataclass(frozen=True, eq=False, repr=False)
class Scores:
    """The scores of M measures of one sex.

    Values and scores are piecewise linear in each other. Beyond the last knot the line from the median
    through it goes on, so that every value has a score and every score a value.
    """

    names: tuple[str, ...]
    sex: str
    source: str
    """Name of the population."""
    knot_scores: Floats
    """(M, K) increasing scores."""
    knot_values: Floats
    """(M, K) increasing values [m; kg] at these scores."""
    correlation: Floats
    """(M, M) of the scores."""

    def __repr__(self) -> str:
        return f"Scores({self.source}, {self.sex}: {len(self.names)} measures)"

    def columns(self, names: Iterable[str]) -> list[int]:
        """Return the indices of measures.

        Raises
        ------
        InputError
            If a measure is unknown; the message lists the valid ones.
        """
        return [self.names.index(name) for name in check_measures(names, self.names)]

    def to_scores(self, values: ArrayLike, columns: Sequence[int]) -> Floats:
        """Return the scores (..., C) of values (..., C) [m; kg] of some columns."""
        return _by_column(
            values, columns, self.knot_values, self.knot_scores, self._middle(columns)
        )

    def to_values(self, scores: ArrayLike, columns: Sequence[int]) -> Floats:
        """Return the values (..., C) [m; kg] of scores (..., C) of some columns."""
        middle = self._middle(columns)[:, ::-1]
        return _by_column(scores, columns, self.knot_scores, self.knot_values, middle)

    def _middle(self, columns: Sequence[int]) -> Floats:
        """(C, 2) median value [m; kg] and its score, zero."""
        medians = [np.interp(0.0, self.knot_scores[c], self.knot_values[c]) for c in columns]
        return np.array([(median, 0.0) for median in medians]).reshape(-1, 2)


def _by_column(
    given: ArrayLike, columns: Sequence[int], knots: Floats, results: Floats, middle: Floats
) -> Floats:
    """(..., C) piecewise linear functions through knots (M, K) and results (M, K) at `given`.

    middle (C, 2): where the lines beyond the ends come from.
    """
    x = np.asarray(given, dtype=np.float64)
    out = np.empty_like(x)
    for k, c in enumerate(columns):
        out[..., k] = _interpolate(x[..., k], knots[c], results[c], middle[k])
    return out


def scores_of(source: Population | PopulationModel, sex: str) -> Scores:
    """Compute the scores of one sex of real people or of a model.

    Raises
    ------
    InputError
        If there are fewer than three people, or a measure is the same for everybody.
    """
    if isinstance(source, PopulationModel):
        return _model_scores(source, sex)
    return _people_scores(source, sex)


def normal_scores(people: Population) -> Floats:
    """Compute the normal scores (P, M) of people of one sex, after van der Waerden.

    A value's score is the normal quantile of its middle rank. Equal values share theirs.
    """
    from scipy.special import ndtri  # takes a sixth of a second to load

    scores = np.empty_like(people.measures)
    for k, column in enumerate(people.measures.T):
        _, each = np.unique(column, return_inverse=True)
        share = np.bincount(each, weights=people.weight) / people.weight.sum()
        scores[:, k] = ndtri(np.cumsum(share) - share / 2)[each]
    return scores


def _model_scores(model: PopulationModel, sex: str) -> Scores:
    from scipy.special import ndtri  # takes a sixth of a second to load

    row = sex_index(sex, model.sexes)
    edge = 0.5 / float(model.count[row])  # the least of n people is the middle of the lowest n-th
    scores = ndtri(np.clip(model.levels, edge, 1 - edge))
    knots = np.broadcast_to(scores, (len(model.names), len(scores)))
    return Scores(model.names, sex, model.name, knots, model.quantiles[row], model.correlation[row])


def _people_scores(people: Population, sex: str) -> Scores:
    rows = people.of_sex(sex)
    if len(rows) < 3:
        raise InputError(
            f"population {people.source}: three or more people are needed, {len(rows)} are {sex}"
        )
    share = rows.weight / rows.weight.sum()
    mean = share @ rows.measures
    off = rows.measures - mean
    spread = np.sqrt(share @ off**2)
    for name, sd, middle in zip(rows.names, spread, mean, strict=True):
        if sd <= 1e-12 * middle:
            raise InputError(
                f"population {people.source}: {name} is the same for every {sex} person"
            )
    z = off / spread
    correlation = (z * share[:, None]).T @ z
    correlation = (correlation + correlation.T) / 2
    np.fill_diagonal(correlation, 1.0)
    values = np.stack([mean - spread, mean + spread], axis=1)
    return Scores(
        rows.names,
        sex,
        people.source,
        np.broadcast_to([-1.0, 1.0], values.shape),
        values,
        correlation,
    )


def _interpolate(x: Floats, knots: Floats, results: Floats, middle: Floats) -> Floats:
    """Interpolate between knots (K,); extend the lines from the middle (2,) through both ends."""
    inside = np.interp(x, knots, results)
    low, high = ((results[end] - middle[1]) / (knots[end] - middle[0]) for end in (0, -1))
    below = np.minimum(x - knots[0], 0.0)
    above = np.maximum(x - knots[-1], 0.0)
    return np.asarray(inside + below * low + above * high)


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


def conditional_distribution(scores: Scores, given: Mapping[str, ArrayLike]) -> Conditional:
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


def mahalanobis_distance(scores: Scores, given: Mapping[str, ArrayLike]) -> Improbability:
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
