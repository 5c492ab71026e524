"""Boundary cases: the few people on the edge of a population whom a cockpit must fit to fit
everybody within.

Zehner, Meindl & Hudson 1993 (AL-TR-1992-0164): z-scores of the chosen measures for each sex,
principal components of their correlation, the first two kept (size; limbs against torso), the
ellipse that holds 90, 95 or 98 % of the people, its axis ends and octants: eight cases a sex.
Measures not chosen follow by regression on those chosen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.body.people.conditional import condition
from workbench.body.people.percentile import quantiles
from workbench.body.people.scores import Scores, scores_of
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.measures import COCKPIT
from workbench.model.population import Population, PopulationModel, sex_index

__all__ = ["Boundary", "boundary_cases"]

ANGLES = (0, 45, 90, 135, 180, 225, 270, 315)
# What the eight directions mean where the measures are those of a cockpit.
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


@dataclass(frozen=True, eq=False)
class Boundary:
    """Eight boundary people of one sex, with all measures.

    radius: of the ellipse, in standard deviations along its axes; explained (2,): share of the
    variance of the chosen measures along both; axes (2, K): unit principal components, over the
    chosen measures `names`.
    """

    people: Population
    names: tuple[str, ...]
    radius: float
    explained: Floats
    axes: Floats


def boundary_cases(
    source: Population | PopulationModel,
    sex: str,
    *,
    share: float = 0.95,
    measures: Sequence[str] = COCKPIT,
) -> Boundary:
    """The cases on the ellipse that holds this share of one sex.

    Of real people the radius is the one that holds the share; of a model it is that of the normal
    distribution, sqrt(-2 ln(1 - share)).
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
    if variance[1] < 1e-9:
        raise InputError(f"boundary cases: {', '.join(measures)} follow exactly from one another")
    scale = np.sqrt(variance[:2, None]) * axes
    radius = _radius(source, scores, columns, scale / variance[:2, None], share)
    turn = np.deg2rad(ANGLES)
    z = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1) @ scale
    chosen = scores.to_values(z, columns)
    every = condition(scores, dict(zip(measures, chosen.T, strict=True)))
    words = (
        _COCKPIT_WORDS
        if tuple(measures) == COCKPIT
        else tuple(f"{angle} degrees" for angle in ANGLES)
    )
    codes = np.full(len(ANGLES), sex_index(sex))
    title = f"{scores.source}, boundary of {100 * share:g} %"
    people = Population(scores.names, codes, np.ones(len(ANGLES)), every.values, title, words)
    return Boundary(people, tuple(measures), radius, variance[:2] / variance.sum(), axes)


def _components(correlation: Floats) -> tuple[Floats, Floats]:
    """Variances (K,), greatest first, and the two first axes (2, K), the first toward large people,
    the second toward a large value of the first measure chosen."""
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
    if isinstance(source, PopulationModel):
        return float(np.sqrt(-2 * np.log1p(-share)))
    people = source.of_sex(scores.sex)
    along = scores.to_scores(people.measures[:, columns], columns) @ weights.T
    return float(quantiles(np.hypot(*along.T), people.weight, np.array([share]))[0])
