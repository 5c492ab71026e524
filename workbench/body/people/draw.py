"""Random people: draws from a population model, the same for the same seed."""

from __future__ import annotations

import numpy as np

from workbench.body.people.scores import scores_of
from workbench.errors import UsageError
from workbench.model.arrays import Floats
from workbench.model.population import Population, PopulationModel, sex_index

__all__ = ["draw_people"]

MOST = 250_000


def draw_people(model: PopulationModel, count: int, *, seed: int, men: float = 0.5) -> Population:
    """Draw `count` people, the share `men` of them (rounded to whole people) men; men first, then
    women.

    Scores are drawn by PCG64, one stream a sex, and given the model's correlation and quantiles; so
    the n-th man of a seed is the same man however many are drawn. UsageError where a number makes
    no sense.
    """
    if not 0 <= count <= MOST:
        raise UsageError(f"0 to {MOST} people can be drawn, got {count}")
    if not 0 <= men <= 1:
        raise UsageError(f"the share of men lies between 0 and 1, got {men:g}")
    if seed < 0:
        raise UsageError(f"a seed is a whole number, 0 or more, got {seed}")
    wanted = {"male": round(count * men), "female": count - round(count * men)}
    streams = np.random.SeedSequence(seed).spawn(len(wanted))
    drawn = [np.empty((0, len(model.names)))]
    codes = [np.empty(0, dtype=np.int64)]
    for (sex, people), stream in zip(wanted.items(), streams, strict=True):
        if people:
            drawn.append(_drawn(model, sex, people, np.random.Generator(np.random.PCG64(stream))))
            codes.append(np.full(people, sex_index(sex)))
    labels = tuple(f"{sex} {n + 1}" for sex, people in wanted.items() for n in range(people))
    source = f"{model.name}, drawn with seed {seed}"
    return Population(
        model.names, np.concatenate(codes), np.ones(count), np.concatenate(drawn), source, labels
    )


def _drawn(model: PopulationModel, sex: str, people: int, chance: np.random.Generator) -> Floats:
    scores = scores_of(model, sex)
    mixed = (
        chance.standard_normal((people, len(model.names)))
        @ np.linalg.cholesky(scores.correlation).T
    )
    return scores.to_values(mixed, range(len(model.names)))
