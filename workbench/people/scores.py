"""Scores: one sex's measures as standard normal scores and back, and how the scores go together.

Both kinds of population come to the same thing here. Of real people, scores are z-scores: (value - mean) / sd, with
Pearson's correlation. Of a model they are normal scores: a Gaussian copula, exact at every quantile of its tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.population import Population, PopulationModel, sex_index

__all__ = ["Scores", "scores_of"]


@dataclass(frozen=True, eq=False)
class Scores:
    """M measures of one sex: knots (M, K) of rising values [m; kg] at rising scores, and the correlation (M, M).

    Between knots both ways are straight lines. Beyond the last knot the line from the median through it is followed,
    so that every value has a score, however rare, and every score its value.
    """

    names: tuple[str, ...]
    sex: str
    source: str
    knot_scores: Floats
    knot_values: Floats
    correlation: Floats

    def to_scores(self, values: ArrayLike, columns: Sequence[int]) -> Floats:
        """(..., C) scores of values (..., C) [m; kg] of these columns."""
        return self._mapped(values, columns, self.knot_values, self.knot_scores)

    def to_values(self, scores: ArrayLike, columns: Sequence[int]) -> Floats:
        """(..., C) values [m; kg] of scores (..., C) of these columns."""
        return self._mapped(scores, columns, self.knot_scores, self.knot_values)

    def column(self, name: str) -> int:
        """Index of a measure; InputError lists the valid ones."""
        if name not in self.names:
            raise InputError(f"{self.source}: no measure {name!r}; valid: {', '.join(self.names)}")
        return self.names.index(name)

    def _mapped(self, given: ArrayLike, columns: Sequence[int], knots: Floats, onto: Floats) -> Floats:
        x = np.asarray(given, dtype=np.float64)
        out = np.empty_like(x)
        for k, column in enumerate(columns):
            middle = _median(self.knot_scores[column], self.knot_values[column], knots[column] is not None)
            out[..., k] = x[..., k] + middle
        return out
