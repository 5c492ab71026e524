"""Draw random people from a population model. The same seed gives the same people."""

from __future__ import annotations

import numpy as np

from workbench.body.people.scores import scores_of
from workbench.errors import UsageError
from workbench.model.arrays import Floats
from workbench.model.population import Population, PopulationModel, sex_index

__all__ = ["draw_people"]

_MAX_PEOPLE = 250_000


def draw_people(model: PopulationModel, count: int, *, seed: int, men: float = 0.5) -> Population:
    """Draw people at random, men first, then women.

    Each sex has its own stream of normal numbers (PCG64), which get the model's correlation and
    quantiles. So the n-th man of a seed is the same, however many people are drawn.

    Parameters
    ----------
    model
        The population model.
    count
        Number of people, up to 250,000.
    seed
        0 or more.
    men
        Share of men, rounded to whole people.

    Raises
    ------
    UsageError
        If a number is out of its range.
    """
    _check_request(count, seed, men)
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


def _check_request(count: int, seed: int, men: float) -> None:
    """Refuse numbers that are out of their range."""
    if not 0 <= count <= _MAX_PEOPLE:
        raise UsageError(f"0 to {_MAX_PEOPLE} people can be drawn, got {count}")
    if not 0 <= men <= 1:
        raise UsageError(f"the share of men lies between 0 and 1, got {men:g}")
    if seed < 0:
        raise UsageError(f"a seed is a whole number, 0 or more, got {seed}")


def _drawn(model: PopulationModel, sex: str, people: int, chance: np.random.Generator) -> Floats:
    """(people, M) values [m; kg]: z = L n with the Cholesky factor L of the correlation."""
    scores = scores_of(model, sex)
    independent = chance.standard_normal((people, len(model.names)))
    correlated = independent @ np.linalg.cholesky(scores.correlation).T
    return scores.to_values(correlated, range(len(model.names)))
