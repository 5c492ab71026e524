"""A whole population in the trainer: bodies the first time and at hand, seats, hands, reaches and
clearances.

Prints CPU seconds of each stage done in one process, wall seconds of the whole shared among all
cores, those of a population reach map of 2,000 points of the panel, and the share that fits. Where
the public files of ANSUR II lie under a folder that is given, its 6,068 people are used, else as
many drawn from the population that comes along.

    python benchmarks/accommodation.py [people] [folder with the ANSUR II CSV files] [coarse, medium
    or fine]
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import workbench as wb
from workbench.body.scaling.scale import morph_to
from workbench.model.accommodation import MapTask
from workbench.study.accommodation.accommodation import population_question
from workbench.study.accommodation.chunks import Question, joined_chunks, result_chunks
from workbench.study.accommodation.people_maps import people_maps
from workbench.study.accommodation.population_bodies import PopulationBodies, fit_population
from workbench.study.checks.table import margins_of
from workbench.study.positions import comfortable_situations
from workbench.study.situation import Occupants

PEOPLE = 6068


class Clock:
    """CPU and wall seconds by stage."""

    def __init__(self) -> None:
        self.cpu: dict[str, float] = {}

    def time(self, stage: str, work: Callable[[], Any]) -> Any:
        """Do some work and count what it takes."""
        begun = os.times()
        found = work()
        ended = os.times()
        used = sum(ended[k] - begun[k] for k in range(4))
        self.cpu[stage] = self.cpu.get(stage, 0.0) + used
        return found


def people_of(count: int, folder: Path | None) -> Any:
    """The people: rows of the public files, spread evenly, or drawn."""
    files = sorted(folder.rglob("ANSUR*.csv")) if folder else []
    if not files:
        return wb.draw_people(wb.load_population_model("ansur2"), count, seed=1, men=4082 / PEOPLE)
    people = wb.read_ansur(*files)
    return people.rows(np.arange(min(count, len(people))) * len(people) // min(count, len(people)))


def main() -> None:
    """Time everything once; kernels are compiled before."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else PEOPLE
    folder = Path(sys.argv[2]) if len(sys.argv) > 2 else None
    study = wb.load_study("trainer_accommodation")
    (role,) = study.roles
    role = replace(role, population=people_of(count, folder))
    question = population_question(replace(study, roles=(role,)))
    body = morph_to(role.body, sys.argv[3] if len(sys.argv) > 3 else "coarse")
    people = question.people
    clock = Clock()
    with tempfile.TemporaryDirectory() as cache:
        os.environ["WORKBENCH_CACHE"] = cache
        warm = fit_population(body, people.rows(np.arange(2)))[:]
        who = Occupants(warm, people, np.arange(2))
        margins_of(comfortable_situations(question.place, who), question.asked)
        begun = time.perf_counter()
        clock.time("bodies, first time", lambda: fit_population(body, people))
        first = time.perf_counter() - begun
        begun = time.perf_counter()
        bodies = clock.time("bodies at hand", lambda: fit_population(body, people))
        met = [staged(clock, question, bodies, rows) for rows in bodies.chunks]
        alone = time.perf_counter() - begun
        begun = time.perf_counter()
        chunks = result_chunks(question, bodies, keep=None, say=lambda text: None)
        shared = joined_chunks(chunks)
        wall = time.perf_counter() - begun
        begun = time.perf_counter()
        task = MapTask("instrument_panel", "push", 2, "either", 2000)
        panel = clock.time(
            "reach map",
            lambda: next(people_maps(question, (task,), bodies, say=lambda t: None)),
        )
        mapped = time.perf_counter() - begun
    served = np.concatenate(met)
    fits = np.all(np.isnan(shared.margin) | (shared.margin >= -1e-6), axis=1)
    assert np.all(fits | ~served)  # other positions of the seat serve more, and nobody less
    print(
        f"{len(people)} people, {len(question.asked)} requirements, {len(bodies.chunks)} chunks, {os.cpu_count()} cores"
    )
    for stage, used in clock.cpu.items():
        print(f"  {stage:20} {used:8.2f} s of CPU, {1000 * used / len(people):8.3f} ms a person")
    print(
        f"  first time {first:.1f} s more, then {alone:.1f} s of wall clock in one process, {wall:.1f} s in all; "
        f"{100 * served.mean():.1f} % fit"
    )
    print(
        f"  reach map of {len(panel.points)} points: {mapped:.1f} s; {100 * panel.share.mean():.1f} % of them reached"
    )


def staged(clock: Clock, question: Question, bodies: PopulationBodies, people: slice) -> Any:
    """One chunk in stages; who meets everything."""
    rows = np.arange(people.start, people.stop)
    body = clock.time("bodies at hand", lambda: bodies[people])
    who = Occupants(body, question.people, rows)
    there = clock.time("seats", lambda: comfortable_situations(question.place, who))
    margin = clock.time("margins", lambda: margins_of(there, question.asked)).margin
    return np.all(np.isnan(margin) | (margin >= -1e-6), axis=1)


if __name__ == "__main__":
    main()
