"""Draw random people from a population. The same seed gives the same people.

Measured people are drawn as they are, each at most once. Synthetic people are like them:

1. Each measured person j of a sex has normal scores z_j, with correlation R.
2. A synthetic person has the scores a z_j + sqrt(1 - a^2) e of a measured person j who is picked
   at random, and of e, normal with correlation R: a kernel estimate that keeps the variance [1]_.
3. Each score becomes the measure at the same rank among the measured people. So a measure has the
   values that were recorded, no less and no greater, each as often.

a is RESEMBLANCE. With a = 0 this is the Gaussian copula. People of a population of which only
figures are known are drawn from that, with measures from its quantile tables.

Given measures stay as they are. The other scores are regressed on them,

    z = B z_g + a (z_j - B z_gj) + sqrt(1 - a^2) e,    B = R_ag R_gg^-1,

e being normal with the conditional covariance R - B R_ga, and person j is picked with the weight
exp(-d^2 / 2 (1 - a^2)), d being the Mahalanobis distance of the given scores from a z_gj. This is
the conditional distribution of the same model. Where it rests on fewer than LEAST_LENDERS people,
the weights are widened until it rests on so many.

References
----------
.. [1] B. W. Silverman (1986), Density Estimation for Statistics and Data Analysis, section 6.4.1.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.body.people.conditional import (
    Scores,
    conditional_distribution,
    normal_scores,
    scores_of,
)
from workbench.body.people.proportions import effective_count
from workbench.errors import InputError, UsageError
from workbench.model.arrays import Floats
from workbench.model.population import (
    SEXES,
    Population,
    PopulationModel,
    check_plausible,
    sex_index,
)

__all__ = ["LEVELS", "RESEMBLANCE", "draw_people", "fit_population"]

RESEMBLANCE = 0.97
"""Correlation of the scores of a synthetic person with those of the measured person picked."""
LEAST_LENDERS = 100.0
"""Effective number of measured people that a conditional draw rests on."""
_MAX_PEOPLE = 250_000
_WIDER = 1.25
_FOLLOWS = 1e-12
"""Conditional variance of a score that follows from the given ones."""


def draw_people(
    source: Population | PopulationModel,
    count: int,
    *,
    seed: int,
    men: float = 0.5,
    synthetic: bool = False,
    given: Mapping[str, float] | None = None,
) -> Population:
    """Draw people at random, men first, then women.

    Each sex has its own stream of random numbers (PCG64). So the n-th man of a seed is the same,
    however many people are drawn.

    Parameters
    ----------
    source
        Measured people, or a population model. Of a model without measured people all are
        synthetic.
    count
        Number of people, up to 250,000.
    seed
        0 or more.
    men
        Share of men, rounded to whole people.
    synthetic
        Whether people like those measured are drawn, instead of these themselves.
    given
        Measures [m; kg] that everybody has; these people are synthetic.

    Raises
    ------
    UsageError
        If a number is out of its range, or fewer people of a sex were measured than are wanted.
    InputError
        If a given measure is unknown or no person's, or a model cannot be fitted to the people.

    Examples
    --------
    >>> import workbench as wb
    >>> people = wb.load_population_model("ansur2")
    >>> drawn = wb.draw_people(people, 100, seed=1, men=0.5)
    >>> drawn
    Population(ansur2, drawn with seed 1: 50 men, 50 women, 57 measures)
    """
    _check_request(count, seed, men)
    number_of_men = round(count * men)
    wanted = {"male": number_of_men, "female": count - number_of_men}
    streams = dict(zip(SEXES, np.random.SeedSequence(seed).spawn(len(SEXES)), strict=True))
    people = source if isinstance(source, Population) else source.people
    if people is not None and not synthetic and not given:
        return _measured_people(people, wanted, streams, seed)
    model = (
        source
        if isinstance(source, PopulationModel)
        else fit_population(source, name=source.source)
    )
    check_plausible(given or {})
    drawn = [np.empty((0, len(model.names)))]
    for sex, number in wanted.items():
        if number:
            drawn.append(_synthetic_people(model, sex, given or {}, number, streams[sex]))
    return Population(
        model.names,
        np.repeat([sex_index(sex) for sex in wanted], list(wanted.values())),
        np.ones(count),
        np.concatenate(drawn),
        f"{model.name}, synthetic, drawn with seed {seed}",
        tuple(f"{sex} {n + 1}" for sex, number in wanted.items() for n in range(number)),
    )


def _check_request(count: int, seed: int, men: float) -> None:
    """Refuse numbers that are out of their range."""
    if not 0 <= count <= _MAX_PEOPLE:
        raise UsageError(f"0 to {_MAX_PEOPLE} people can be drawn, got {count}")
    if not 0 <= men <= 1:
        raise UsageError(f"the share of men lies between 0 and 1, got {men:g}")
    if seed < 0:
        raise UsageError(f"a seed is a whole number, 0 or more, got {seed}")


def _measured_people(
    people: Population,
    wanted: Mapping[str, int],
    streams: Mapping[str, np.random.SeedSequence],
    seed: int,
) -> Population:
    """Choose measured people, each at most once: those with the least random numbers."""
    if short := people.lacking(wanted["male"], wanted["female"]):
        raise UsageError(f"{short}; ask for fewer, for another share, or for synthetic people")
    rows = []
    for sex, number in wanted.items():
        own = np.flatnonzero(people.sex == sex_index(sex))
        chance = np.random.Generator(np.random.PCG64(streams[sex])).random(len(own))
        rows.append(own[np.argsort(chance, kind="stable")[:number]])
    chosen = people.rows(np.concatenate(rows))
    return Population(
        chosen.names,
        chosen.sex,
        chosen.weight,
        chosen.measures,
        f"{people.source}, drawn with seed {seed}",
        chosen.labels,
    )


def _synthetic_people(
    model: PopulationModel,
    sex: str,
    given: Mapping[str, float],
    number: int,
    stream: np.random.SeedSequence,
) -> Floats:
    """(number, M) measures [m; kg] of synthetic people of one sex."""
    from scipy.special import ndtr  # takes a sixth of a second to load

    scores = scores_of(model, sex)
    every = range(len(scores.names))
    noise = np.random.Generator(np.random.PCG64(stream)).standard_normal((number, len(every)))
    expected = conditional_distribution(scores, given)
    normal = noise @ _factor(expected.covariance).T
    if model.people is None:
        values = scores.to_values(expected.mean + normal, every)
    else:
        lenders = model.people.of_sex(sex)
        chance = np.random.Generator(np.random.PCG64(stream.spawn(1)[0])).random(number)
        own = normal_scores(lenders)
        weight = np.cumsum(_lending(scores, lenders, own, given))
        rows = np.searchsorted(weight / weight[-1], chance, side="right")
        known = conditional_distribution(scores, {name: lenders.column(name) for name in given})
        lent = RESEMBLANCE * (own - known.mean)[rows]
        drawn = expected.mean + lent + np.sqrt(1 - RESEMBLANCE**2) * normal
        values = _measured_values(lenders, ndtr(drawn))
    values[:, scores.columns(given)] = list(given.values())
    return values


def _measured_values(people: Population, levels: Floats) -> Floats:
    """(P, M) least measures [m; kg] that shares (P, M), 0 to 1, of measured people do not exceed."""
    values = np.empty_like(levels)
    for k, column in enumerate(people.measures.T):
        order = np.argsort(column, kind="stable")
        share = np.cumsum(people.weight[order])
        at = np.searchsorted(share / share[-1], levels[:, k])
        values[:, k] = column[order][np.minimum(at, len(order) - 1)]
    return values


def _factor(covariance: Floats) -> Floats:
    """L of a covariance L L' (M, M) whose rows of given measures are zero."""
    free = np.flatnonzero(np.diag(covariance) > _FOLLOWS)
    factor = np.zeros_like(covariance)
    factor[np.ix_(free, free)] = np.linalg.cholesky(covariance[np.ix_(free, free)])
    return factor


def _lending(
    scores: Scores, lenders: Population, own: Floats, given: Mapping[str, float]
) -> Floats:
    """(N,) weight with which each measured person, of scores `own` (N, M), is picked."""
    from scipy.linalg import cho_factor, cho_solve  # takes a sixth of a second to load

    weight = lenders.weight
    columns = scores.columns(given)
    if not columns:
        return weight
    wanted = scores.to_scores(list(given.values()), columns)
    off = RESEMBLANCE * own[:, columns] - wanted
    factor = cho_factor(scores.correlation[np.ix_(columns, columns)])
    square = (off * cho_solve(factor, off.T).T).sum(axis=1)
    square -= square.min()
    least = min(LEAST_LENDERS, 0.999 * effective_count(weight))
    width = 1 - RESEMBLANCE**2
    near: Floats = weight * np.exp(-square / (2 * width))
    while effective_count(near) < least:
        width *= _WIDER
        near = weight * np.exp(-square / (2 * width))
    return near


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
