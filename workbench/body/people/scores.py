"""Scores: one sex's measures as standard normal scores and back, and how the scores go together.

Both kinds of population come to the same thing here. Of real people, scores are z-scores: (value -
mean) / sd, with Pearson's correlation. Of a model they are normal scores: a Gaussian copula, exact
at every quantile of its tables.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.measures import check_measures
from workbench.model.population import Population, PopulationModel, sex_index

__all__ = ["Scores", "scores_of"]


@dataclass(frozen=True, eq=False, repr=False)
class Scores:
    """M measures of one sex: knots (M, K) of rising values [m; kg] at rising scores, and the
    correlation (M, M).

    Between knots both ways are straight lines. Beyond the last knot the line from the median
    through it is followed, so that every value has a score, however rare, and every score its
    value.
    """

    names: tuple[str, ...]
    sex: str
    source: str
    knot_scores: Floats
    knot_values: Floats
    correlation: Floats

    def __repr__(self) -> str:
        return f"Scores({self.source}, {self.sex}: {len(self.names)} measures)"

    def columns(self, names: Iterable[str]) -> list[int]:
        """Indices of measures; InputError lists the valid ones."""
        return [self.names.index(name) for name in check_measures(names, self.names)]

    def to_scores(self, values: ArrayLike, columns: Sequence[int]) -> Floats:
        """(..., C) scores of values (..., C) [m; kg] of these columns."""
        x = np.asarray(values, dtype=np.float64)
        out = np.empty_like(x)
        for k, c in enumerate(columns):
            middle = np.interp(0.0, self.knot_scores[c], self.knot_values[c])
            out[..., k] = _line(x[..., k], self.knot_values[c], self.knot_scores[c], (middle, 0.0))
        return out

    def to_values(self, scores: ArrayLike, columns: Sequence[int]) -> Floats:
        """(..., C) values [m; kg] of scores (..., C) of these columns."""
        x = np.asarray(scores, dtype=np.float64)
        out = np.empty_like(x)
        for k, c in enumerate(columns):
            middle = np.interp(0.0, self.knot_scores[c], self.knot_values[c])
            out[..., k] = _line(x[..., k], self.knot_scores[c], self.knot_values[c], (0.0, middle))
        return out


def scores_of(source: Population | PopulationModel, sex: str) -> Scores:
    """The scores of one sex of real people or of a model; InputError where they cannot be told."""
    return (
        _model_scores(source, sex)
        if isinstance(source, PopulationModel)
        else _people_scores(source, sex)
    )


def _model_scores(model: PopulationModel, sex: str) -> Scores:
    row = sex_index(sex, model.sexes)
    edge = 0.5 / float(model.count[row])  # the least of n people stands for the lowest n-th of them
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


def _line(x: Floats, at: Floats, to: Floats, median: tuple[float, float]) -> Floats:
    """Piecewise straight through the points (at, to); beyond the ends, straight from the median
    through the end."""
    inside = np.interp(x, at, to)
    low, high = ((to[end] - median[1]) / (at[end] - median[0]) for end in (0, -1))
    return np.asarray(
        inside + np.minimum(x - at[0], 0.0) * low + np.maximum(x - at[-1], 0.0) * high
    )
