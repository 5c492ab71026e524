"""What a whole population costs in the trainer: bodies, one position of the seat for each, the whole
travel, and a reach map. Seconds by the clock on all cores, as a user waits for them.

The people are those of the study `trainer_accommodation`, but all who were measured, or some of them
spread evenly. What everybody takes is then projected from two numbers of people, so that what a run
takes for itself is not multiplied, and the row says so.
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
from workbench.model.accommodation import MET, MapTask
from workbench.model.arrays import Floats
from workbench.model.study import Study
from workbench.study.accommodation.accommodation import population_question
from workbench.study.accommodation.checkpoints import joined_chunks, result_chunks
from workbench.study.accommodation.population_bodies import PopulationBodies, fit_population
from workbench.study.accommodation.reach_maps import people_maps
from workbench.study.passes import MAP, Passes

__all__ = [
    "EVERYBODY",
    "MAP_POINTS",
    "bodies_of",
    "everybody",
    "margins_in_seat",
    "people_rows",
    "share_of_fits",
    "some_of",
]

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
    """Seconds by the clock and of CPU that something took for so many people, what came of it, and
    that in words."""

    wall: float
    cpu: float
    count: int
    found: Any
    words: str = ""


def _timed(work: Callable[[], Any], count: int) -> _Taken:
    wall = time.perf_counter()
    begun = os.times()
    found = work()
    ended = os.times()
    cpu = sum(ended[:4]) - sum(begun[:4])
    return _Taken(time.perf_counter() - wall, cpu, count, found)


def people_rows(count: int, *, mapped: int, points: int = MAP_POINTS) -> Iterator[Row]:
    """Yield what everybody takes, projected from so many people where these are fewer, and from
    `mapped` of them for the map."""
    with (
        tempfile.TemporaryDirectory() as cache,
        patch.dict(os.environ, {"WORKBENCH_CACHE": cache}),
    ):
        study = everybody()
        _figures(study, 2, 2, min(points, 50))  # compiles everything and makes every index
        whole = _figures(study, count, mapped, points)
        part = _figures(study, count // 4, mapped // 4, points) if count < EVERYBODY else {}
    for figure, taken in whole.items():
        yield _row(figure, taken, part.get(figure))


def _figures(study: Study, count: int, mapped: int, points: int) -> dict[str, _Taken]:
    """What so many people of a study take by figure, and `mapped` of them for the map."""
    study = some_of(study, count)
    held = replace(study, roles=(replace(study.roles[0], free=False),))
    fewer = some_of(study, mapped)
    first = _timed(lambda: bodies_of(study), count)
    again = _timed(lambda: bodies_of(study), count)
    bodies = again.found
    one = _timed(lambda: share_of_fits(margins_in_seat(held, bodies)), count)
    every = _timed(lambda: share_of_fits(margins_in_seat(study, bodies)), count)
    some = bodies_of(fewer)
    panel = _timed(lambda: _map(fewer, some, points), mapped)
    return {
        "bodies, the first time": replace(first, words=f"{len(bodies[0].sphere_names)} spheres"),
        "bodies at hand, read": again,
        "one position of the seat": replace(one, words=f"{one.found:.1%} meet everything"),
        "the whole travel of the seat": replace(every, words=f"{every.found:.1%} meet everything"),
        f"reach map of {points} points": replace(panel, words=panel.found),
    }


def bodies_of(study: Study) -> PopulationBodies:
    """The bodies of a study's people, made or read."""
    (role,) = study.roles
    body = morph_to(role.body, role.detail)
    return fit_population(body, population_question(study).people, role.clothes, sits=True)


def margins_in_seat(study: Study, bodies: PopulationBodies) -> Floats:
    """(B, R) what everybody has to spare in each requirement, in one position of the seat or where
    the seat's travel suits them best."""
    question = population_question(study)
    chunks = result_chunks(question, bodies, keep=None, tell=lambda done, total: None)
    return joined_chunks(chunks).margin


def share_of_fits(margin: Floats) -> float:
    """The share of the people who meet everything."""
    return float(np.mean(np.all(np.isnan(margin) | (margin >= -MET), axis=1)))


def _map(study: Study, bodies: PopulationBodies, points: int) -> str:
    """How many points a map of the panel has, and the share that is reached on the average."""
    task = MapTask("instrument_panel", "push", 2, "either", points)
    question = population_question(study)
    passes = Passes(lambda text: None, [MAP])
    panel = next(people_maps(question, (task,), bodies, passes=passes))
    return f"{len(panel.points)} points of the panel, {panel.share.mean():.1%} of them reached"


def _row(figure: str, taken: _Taken, part: _Taken | None) -> Row:
    """A row about everybody, by what some people took and, where these are not all, a part of
    them."""
    each = f"{1000 * taken.cpu / taken.count:.3g} ms of CPU a person"
    said = [each, taken.words] if taken.words else [each]
    wall = taken.wall
    if part is not None:
        slope = max(taken.wall - part.wall, 0.0) / (taken.count - part.count)
        wall += slope * (EVERYBODY - taken.count)
        said.append(
            f"projected from {part.count} people in {part.wall:.1f} s and {taken.count} in "
            f"{taken.wall:.1f} s"
        )
    return Row(figure, f"{EVERYBODY} people", wall, "s", "; ".join(said))
