"""Fitting: real people become a model: quantile tables and normal-scores correlation (a Gaussian
copula)."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.population import SEXES, Population, PopulationModel

__all__ = ["LEVELS", "fit_population"]

# Shares of the people whose quantiles are kept, beside the least and the greatest person.
_LOW = (0.001, 0.005, 0.01, 0.025)
LEVELS: tuple[float, ...] = (
    *_LOW,
    *(round(0.05 * k, 2) for k in range(1, 20)),
    *(1 - p for p in reversed(_LOW)),
)


def fit_population(people: Population, *, name: str, description: str = "") -> PopulationModel:
    """The model of these people; InputError where there are too few of one sex, or a measure never
    changes.

    Measures come in whole millimetres: each recorded value is taken as spread evenly to halfway to
    its neighbours, so that quantiles rise strictly. Levels nearer to 0 or 1 than the people can
    tell are left out.
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
    quantiles = []
    correlation = []
    for group in groups:
        flat = [measure for measure in group.names if len(np.unique(group.column(measure))) < 3]
        if flat:
            raise InputError(
                f"population {people.source}: {', '.join(flat)}: fewer than three different values"
            )
        quantiles.append(
            np.stack([_table(column, group.weight, levels) for column in group.measures.T])
        )
        correlation.append(_normal_correlation(group))
    return PopulationModel(
        name,
        description,
        people.source,
        people.names,
        sexes,
        np.array(count),
        levels,
        np.stack(quantiles),
        np.stack(correlation),
    )


def _table(values: Floats, weight: Floats, levels: Floats) -> Floats:
    known, each = np.unique(values, return_inverse=True)
    below = np.cumsum(np.bincount(each, weights=weight))[:-1] / weight.sum()
    at = np.concatenate([known[:1], (known[1:] + known[:-1]) / 2, known[-1:]])
    return np.asarray(np.interp(levels, np.concatenate([[0.0], below, [1.0]]), at))


def _normal_correlation(people: Population) -> Floats:
    """(M, M) Pearson's correlation of the van der Waerden scores; equal values share their middle
    rank."""
    scores = np.empty_like(people.measures)
    for k, column in enumerate(people.measures.T):
        _, each = np.unique(column, return_inverse=True)
        share = np.bincount(each, weights=people.weight) / people.weight.sum()
        scores[:, k] = ndtri(np.cumsum(share) - share / 2)[each]
    matrix = np.cov(scores, rowvar=False, aweights=people.weight)
    spread = np.sqrt(np.diag(matrix))
    matrix = matrix / np.outer(spread, spread)
    matrix = (matrix + matrix.T) / 2
    np.fill_diagonal(matrix, 1.0)
    return np.asarray(matrix)
