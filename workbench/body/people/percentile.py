"""Compute percentiles of a population, and percentile people.

Each measure is taken by itself, as in tables of percentiles. Nobody is at the 5th percentile of
every measure.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.people.conditional import scores_of
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.population import Population, PopulationModel, sex_index

__all__ = ["percentile_people", "percentile_rank", "percentile_values", "quantiles"]


def percentile_values(
    source: Population | PopulationModel, sex: str, percentiles: ArrayLike
) -> Floats:
    """Compute the values of all measures at given percentiles.

    Values of real people are exact and linear between neighbours: definition 7 of Hyndman & Fan (1996),
    numpy's "linear", with weights. Values of a model come from its tables. Percentiles 0 and 100 are
    the least and the greatest person measured.

    Parameters
    ----------
    source
        Real people or a model.
    sex
        "male" or "female".
    percentiles
        (P,) [%], 0 to 100.

    Returns
    -------
    Floats
        (P, M) [m; kg].

    Raises
    ------
    InputError
        If a percentile is not between 0 and 100.

    References
    ----------
    Hyndman, R. J. & Fan, Y. (1996), Sample quantiles in statistical packages, American Statistician 50,
    361-365.
    """
    from scipy.special import ndtri  # takes a sixth of a second to load

    levels = np.atleast_1d(np.asarray(percentiles, dtype=np.float64)) / 100
    wrong = levels[~((levels >= 0) & (levels <= 1))]
    if wrong.size:
        raise InputError(f"a percentile lies between 0 and 100, got {100 * wrong[0]:g}")
    if isinstance(source, PopulationModel):
        scores = scores_of(source, sex)
        known = np.clip(ndtri(levels)[:, None], scores.knot_scores[:, 0], scores.knot_scores[:, -1])
        return scores.to_values(known, range(len(source.names)))
    people = source.of_sex(sex)
    return np.stack(
        [quantiles(column, people.weight, levels) for column in people.measures.T], axis=1
    )


def percentile_rank(model: PopulationModel, sex: str, name: str, value: float) -> float:
    """Compute the percentile [%] at which a measure [m; kg] stands: what `percentile_values` takes.

    Raises
    ------
    InputError
        If the model has no such measure or sex.
    """
    from scipy.special import ndtr  # takes a sixth of a second to load

    scores = scores_of(model, sex)
    return float(100 * ndtr(scores.to_scores([value], scores.columns([name]))[0]))


def percentile_people(
    source: Population | PopulationModel, sex: str, percentiles: ArrayLike
) -> Population:
    """Return one person for each percentile [%], with all measures at that percentile of their sex.

    Raises
    ------
    InputError
        If a percentile is not between 0 and 100.
    """
    levels = np.atleast_1d(np.asarray(percentiles, dtype=np.float64))
    values = percentile_values(source, sex, levels)
    name = source.name if isinstance(source, PopulationModel) else source.source
    codes = np.full(len(levels), sex_index(sex))
    labels = tuple(f"{level:g} %" for level in levels)
    return Population(source.names, codes, np.ones(len(levels)), values, name, labels)


def quantiles(values: Floats, weight: Floats, levels: Floats) -> Floats:
    """Compute the quantiles (Q,) of values (P,) with weights (P,) at levels (Q,), 0 to 1."""
    known, level = _steps(values, weight)
    return np.asarray(np.interp(levels, level, known))


def _steps(values: Floats, weight: Floats) -> tuple[Floats, Floats]:
    """Sorted values (P,), and the level (P,) of each: 0 for the first and 1 for the last.

    The level between two values rises by half of both weights.
    """
    order = np.argsort(values, kind="stable")
    steps = weight[order]
    if len(steps) == 1:
        return values, np.array([0.5])
    level = np.concatenate([[0.0], np.cumsum((steps[1:] + steps[:-1]) / 2)])
    return values[order], level / level[-1]
