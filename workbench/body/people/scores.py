"""Turn the measures of one sex into standard normal scores and back.

Scores of real people are z-scores, (value - mean) / sd, with Pearson's correlation. Scores of a
model are normal scores of a Gaussian copula, exact at every quantile of its tables.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.population import Population, PopulationModel, check_measures, sex_index

__all__ = ["Scores", "normal_scores", "scores_of"]


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
