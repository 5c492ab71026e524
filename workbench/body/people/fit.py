"""Fit a population model to real people: quantile tables and a Gaussian copula. It keeps the people."""

from __future__ import annotations

import numpy as np

from workbench.body.people.scores import normal_scores
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.population import SEXES, Population, PopulationModel

__all__ = ["LEVELS", "fit_population"]

_LOW = (0.001, 0.005, 0.01, 0.025)
LEVELS: tuple[float, ...] = (
    *_LOW,
    *(round(0.05 * k, 2) for k in range(1, 20)),
    *(1 - p for p in reversed(_LOW)),
)
"""Levels of the quantiles that are kept, besides the least and the greatest person."""


def fit_population(people: Population, *, name: str, description: str = "") -> PopulationModel:
    """Fit a model to people.

    Measures are recorded in whole millimetres. Each value is spread evenly over the interval to
    half way to its neighbours, so that quantiles increase strictly. Levels nearer to 0 or 1 than
    one person are left out.

    Parameters
    ----------
    people
        Real people, with weights.
    name, description
        Of the model.

    Raises
    ------
    InputError
        If a sex has no more people than measures, or a measure has fewer than three values.
    """
    sexes = tuple(sex for code, sex in enumerate(SEXES) if np.any(people.sex == code))
    groups = [people.of_sex(sex) for sex in sexes]
    count = [len(group) for group in groups]
    if min(count, default=0) <= len(people.names):
        raise InputError(
            f"population {people.source}: {count} people are too few for {len(people.names)} measures"
        )
    inner = [level for level in LEVELS if 1 / min(count) < min(level, 1 - level)]
    levels = np.array([0.0, *inner, 1.0])
    for group in groups:
        _require_variation(group)
    return PopulationModel(
        name,
        description,
        people.source,
        people.names,
        sexes,
        np.array(count),
        levels,
        np.stack([_quantile_table(group, levels) for group in groups]),
        np.stack([_normal_correlation(group) for group in groups]),
        people,
    )


def _require_variation(people: Population) -> None:
    """Refuse measures with fewer than three different values."""
    flat = [measure for measure in people.names if len(np.unique(people.column(measure))) < 3]
    if flat:
        raise InputError(
            f"population {people.source}: {', '.join(flat)}: fewer than three different values"
        )


def _quantile_table(people: Population, levels: Floats) -> Floats:
    """(M, L) quantiles [m; kg] of every measure at levels (L,)."""
    return np.stack([_quantiles(column, people.weight, levels) for column in people.measures.T])


def _quantiles(values: Floats, weight: Floats, levels: Floats) -> Floats:
    """(L,) quantiles of values (P,) that are each spread to half way to their neighbours."""
    known, each = np.unique(values, return_inverse=True)
    below = np.cumsum(np.bincount(each, weights=weight))[:-1] / weight.sum()
    edges = np.concatenate([known[:1], (known[1:] + known[:-1]) / 2, known[-1:]])
    return np.asarray(np.interp(levels, np.concatenate([[0.0], below, [1.0]]), edges))


def _normal_correlation(people: Population) -> Floats:
    """(M, M) Pearson's correlation of the normal scores."""
    matrix = np.cov(normal_scores(people), rowvar=False, aweights=people.weight)
    spread = np.sqrt(np.diag(matrix))
    matrix = matrix / np.outer(spread, spread)
    matrix = (matrix + matrix.T) / 2
    np.fill_diagonal(matrix, 1.0)
    return np.asarray(matrix)
