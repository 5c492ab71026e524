"""What a whole population costs in the trainer: bodies, one position of the seat for each, the whole
travel, and a reach map. Seconds by the clock on all cores, as a user waits for them.

The people are those of the study `trainer_accommodation`, but all who were measured, or some of them
spread evenly; what fewer take is projected in proportion, and the row says so.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.cases import changed_study
from benchmarks.table import Row
from workbench.body.scaling.scale import morph_to
from workbench.model.accommodation import MapTask
from workbench.model.study import Study
from workbench.study.accommodation.accommodation import population_question
from workbench.study.accommodation.chunks import joined_chunks, result_chunks
from workbench.study.accommodation.people_maps import people_maps
from workbench.study.accommodation.population_bodies import PopulationBodies, fit_population

__all__ = ["EVERYBODY", "MAP_POINTS", "everybody", "people_rows", "some_of"]

EVERYBODY = 6068
MAP_POINTS = 2000


def everybody() -> Study:
    """The study of the trainer's left seat with everybody who was measured, and no changes or
    maps."""

    def change(document: dict[str, Any]) -> None:
        document["people"]["pilot"]["population"] = {"source": "ansur2", "people": "all"}
        document.pop("reach_maps", None)
        document.pop("changes", None)

    return changed_study("trainer_accommodation", change)


def some_of(study: Study, count: int) -> Study:
    """The study with so many of its people, spread evenly."""
    (role,) = study.roles
    people = role.population
    rows = np.arange(count) * len(people) // count  # type: ignore[arg-type]
    return replace(study, roles=(replace(role, population=people.rows(rows)),))  # type: ignore[union-attr]


@dataclass(frozen=True)
class _Taken:
    """Seconds by the clock and of CPU that something took, and what came of it."""

    wall: float
    cpu: float
    found: Any


def _timed(work: Callable[[], Any]) -> _Taken:
    wall = time.perf_counter()
    begun = os.times()
    found = work()
    ended = os.times()
    return _Taken(time.perf_counter() - wall, sum(ended[:4]) - sum(begun[:4]), found)


def people_rows(count: int, *, mapped: int, points: int = MAP_POINTS) -> Iterator[Row]:
    """Yield what so many people take, and so many for the map, all projected to everybody."""
    study = some_of(everybody(), count)
    (role,) = study.roles
    body = morph_to(role.body, role.detail)
    held = replace(study, roles=(replace(role, free=False),))
    with (
        tempfile.TemporaryDirectory() as cache,
        patch.dict(os.environ, {"WORKBENCH_CACHE": cache}),
    ):
        _warm(study, held, points)
        people = population_question(study).people
        first = _timed(lambda: fit_population(body, people, sits=True))
        yield _row("bodies, the first time", first, count, f"{len(body.sphere_names)} spheres")
        bodies = _timed(lambda: fit_population(body, people, sits=True))
        yield _row("bodies at hand, read", bodies, count, "")
        one = _timed(lambda: _fitting(held, bodies.found))
        yield _row("one position of the seat", one, count, f"{one.found:.1%} meet everything")
        every = _timed(lambda: _fitting(study, bodies.found))
        yield _row(
            "the whole travel of the seat", every, count, f"{every.found:.1%} meet everything"
        )
        fewer = some_of(study, mapped)
        people = population_question(fewer).people
        some = fit_population(body, people, sits=True)
        panel = _timed(lambda: _map(fewer, some, points))
        shown, reached = panel.found
        words = f"{shown} points of the panel, {reached:.1%} of them reached"
        yield _row(f"reach map of {points} points", panel, mapped, words)


def _warm(study: Study, held: Study, points: int) -> None:
    """Compile everything and make every index before it is timed."""
    few = some_of(study, 2)
    (role,) = few.roles
    body = morph_to(role.body, role.detail)
    bodies = fit_population(body, population_question(few).people, sits=True)
    _fitting(few, bodies)
    _fitting(some_of(held, 2), bodies)
    _map(few, bodies, min(points, 50))


def _fitting(study: Study, bodies: PopulationBodies) -> float:
    """The share of the people who meet everything, in one position of the seat or in any."""
    question = population_question(study)
    chunks = result_chunks(question, bodies, keep=None, say=lambda text: None)
    margin = joined_chunks(chunks).margin
    return float(np.mean(np.all(np.isnan(margin) | (margin >= -1e-6), axis=1)))


def _map(study: Study, bodies: PopulationBodies, points: int) -> tuple[int, float]:
    """How many points a map of the panel has, and the share that is reached on the average."""
    task = MapTask("instrument_panel", "push", 2, "either", points)
    question = population_question(study)
    panel = next(people_maps(question, (task,), bodies, say=lambda text: None))
    return len(panel.points), float(panel.share.mean())


def _row(figure: str, taken: _Taken, count: int, words: str) -> Row:
    """A row about everybody, by what `count` people took."""
    each = f"{1000 * taken.cpu / count:.3g} ms of CPU a person"
    said = [each, words] if words else [each]
    if count < EVERYBODY:
        said.append(f"projected from {count} people in {taken.wall:.1f} s")
    wall = taken.wall * EVERYBODY / count
    return Row(figure, f"{EVERYBODY} people", wall, "s", "; ".join(said))
