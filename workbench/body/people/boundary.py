"""Choose boundary cases: the few people on the edge of a population that a cockpit must fit.

The method is that of Zehner and others [1]_:

1. The chosen measures of one sex become z-scores.
2. The first two principal components of their correlation are kept. For measures of a cockpit they
   are size, and limbs against torso.
3. The cases are eight points of the ellipse that holds the given share of the people: the ends of
   its axes and the octants between.
4. Measures that are not chosen follow by regression.

References
----------
.. [1] G. F. Zehner, R. S. Meindl & J. A. Hudson (1993), A multivariate anthropometric method for
   crew station design, AL-TR-1992-0164.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.body.people.conditional import Scores, conditional_distribution, scores_of
from workbench.body.people.percentile import quantiles
from workbench.errors import InputError
from workbench.model.arguments import short_repr
from workbench.model.arrays import Floats
from workbench.model.population import COCKPIT, Population, PopulationModel, sex_index

__all__ = ["Boundary", "boundary_cases"]

_ANGLES = (0, 45, 90, 135, 180, 225, 270, 315)
"""Directions of the cases [degrees] in the plane of the two components."""
_COCKPIT_WORDS = (
    "overall large",
    "longest limbs",
    "long limbs, short torso",
    "short torso",
    "overall small",
    "short limbs",
    "short limbs, tall torso",
    "tallest torso",
)
"""What the eight directions mean for the measures of a cockpit."""
_DEGENERATE = 1e-9
"""Variance of the second component below which all measures follow from one."""


@dataclass(frozen=True, eq=False)
class Boundary:
    """Eight boundary people of one sex, with all measures."""

    people: Population
    names: tuple[str, ...]
    """The K chosen measures."""
    radius: float
    """Radius of the ellipse, in standard deviations along its axes."""
    explained: Floats
    """(2,) share of the variance of the chosen measures along both axes."""
    axes: Floats
    """(2, K) unit principal components over the chosen measures."""

    __repr__ = short_repr


def boundary_cases(
    source: Population | PopulationModel,
    sex: str,
    *,
    share: float = 0.95,
    measures: Sequence[str] = COCKPIT,
) -> Boundary:
    """Choose the eight cases on the ellipse that holds a share of one sex.

    Parameters
    ----------
    source
        Real people, whose ellipse is scaled to hold the share, or a model, whose ellipse has the
        radius sqrt(-2 ln(1 - share)) of the bivariate normal distribution.
    sex
        "male" or "female".
    share
        Share of the people inside the ellipse, between 0 and 1.
    measures
        Two or more measures to choose by.

    Raises
    ------
    InputError
        If the share or the measures are not valid, or all measures follow from one.

    Examples
    --------
    >>> import workbench as wb
    >>> people = wb.load_population_model("ansur2")
    >>> cases = wb.boundary_cases(people, "female", share=0.9)
    >>> cases.people
    Population(ansur2, boundary of 90 %: 0 men, 8 women, 57 measures)
    """
    if not 0 < share < 1:
        raise InputError(f"the share of people inside lies between 0 and 1, got {share:g}")
    scores = scores_of(source, sex)
    columns = scores.columns(measures)
    if len(columns) < 2:
        raise InputError(
            f"two measures or more are needed for boundary cases, got {', '.join(measures) or 'none'}"
        )
    variance, axes = _components(scores.correlation[np.ix_(columns, columns)])
    if variance[1] < _DEGENERATE:
        raise InputError(f"boundary cases: {', '.join(measures)} follow exactly from one another")
    # a point t of the unit circle has the z-scores r t diag(sqrt(variance)) axes
    scale = np.sqrt(variance[:2, None]) * axes
    radius = _radius(source, scores, columns, scale / variance[:2, None], share)
    angle = np.deg2rad(_ANGLES)
    z = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1) @ scale
    chosen = dict(zip(measures, scores.to_values(z, columns).T, strict=True))
    title = f"{scores.source}, boundary of {100 * share:g} %"
    people = _cases(scores, chosen, title)
    return Boundary(people, tuple(measures), radius, variance[:2] / variance.sum(), axes)


def _cases(scores: Scores, chosen: dict[str, Floats], title: str) -> Population:
    """The eight people with the chosen measures (8,) [m; kg] by name; the others by regression."""
    every = conditional_distribution(scores, chosen)
    cockpit = tuple(chosen) == COCKPIT
    labels = _COCKPIT_WORDS if cockpit else tuple(f"{angle} degrees" for angle in _ANGLES)
    codes = np.full(len(_ANGLES), sex_index(scores.sex))
    return Population(scores.names, codes, np.ones(len(_ANGLES)), every.values, title, labels)


def _components(correlation: Floats) -> tuple[Floats, Floats]:
    """Principal components: variances (K,), greatest first, and the first two axes (2, K).

    The first axis points to large people, the second to large values of the first measure chosen.
    """
    variance, vectors = np.linalg.eigh(correlation)
    variance = variance[::-1].copy()
    axes = vectors[:, ::-1].T[:2].copy()
    axes[0] *= 1.0 if axes[0].sum() >= 0 else -1.0
    axes[1] *= 1.0 if axes[1, 0] >= 0 else -1.0
    return variance, axes


def _radius(
    source: Population | PopulationModel,
    scores: Scores,
    columns: list[int],
    weights: Floats,
    share: float,
) -> float:
    """Radius of the ellipse that holds a share of the people.

    weights (2, K) take z-scores to coordinates in which the ellipse is a circle.
    """
    if isinstance(source, PopulationModel):
        return float(np.sqrt(-2 * np.log1p(-share)))
    people = source.of_sex(scores.sex)
    along = scores.to_scores(people.measures[:, columns], columns) @ weights.T
    return float(quantiles(np.hypot(*along.T), people.weight, np.array([share]))[0])
