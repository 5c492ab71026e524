"""Fitting the bodies of a chunk of people, here or in processes of their own.

Linear algebra on several threads adds up in another order and gives other last digits; so fitting
is done where it has one thread: in this process if that was started so, else in children that are.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from queue import Empty, SimpleQueue
from typing import NamedTuple

import numpy as np

from workbench.body.scaling.measure import MEASURES
from workbench.body.scaling.scale import scale, scale_many
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.measures import MASS
from workbench.model.population import SEXES, Population
from workbench.study.persons import APART

__all__ = ["FIELDS", "Fit", "Task", "fit_chunk", "fit_chunks", "main", "single_threaded"]

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


FIELDS = (
    "centre",
    "radius",
    "joint_in_parent",
    "joint_in_child",
    "mass",
    "allowance",
    "enclosing_centre",
    "enclosing_radius",
    "twist_point",
    "twist_axis",
    "twist_share",
    "basis_at",
)
"""What bodies of a family differ in."""


class Fit(NamedTuple):
    """B fitted bodies: the fields that they differ in, each (B, ...), and for each why it does not
    show all measures exactly, "" where it does."""

    fields: dict[str, Floats]
    told: list[str]


class Task(NamedTuple):
    """What is needed to fit anybody: a body to begin from by sex, and the measures that are to be
    shown exactly."""

    templates: Mapping[str, Body]
    exact: tuple[str, ...]


def fit_chunk(task: Task, people: Population) -> Fit:
    """The bodies of some people (one or more): the exact measures shown, their others near, masses
    adding up to theirs.

    Who cannot have all of them exactly has them near instead and is told of. InputError where there
    is no such body.
    """
    exact = [name for name in task.exact if name in people.names]
    near = [name for name in people.names if name in MEASURES and name not in (*exact, *APART)]
    rows = [dict(zip(people.names, row, strict=True)) for row in people.measures.tolist()]
    bodies: list[Body] = []
    told: list[str] = []
    streams = {}
    for code in np.unique(people.sex):
        own = [row for row, sex in zip(rows, people.sex, strict=True) if sex == code]
        given = [{name: row[name] for name in exact} for row in own]
        rest = [{name: row[name] for name in near} for row in own]
        streams[int(code)] = scale_many(task.templates[SEXES[int(code)]], given, others=rest)
    for row, code, label in zip(
        rows, people.sex, people.labels or map(str, range(len(people))), strict=True
    ):
        found = next(streams[int(code)])
        body, words = (
            (found, "")
            if isinstance(found, Body)
            else _near(
                task.templates[SEXES[int(code)]], row, (exact, near), f"{SEXES[int(code)]} {label}"
            )
        )
        bodies.append(_heavy(body, row))
        told.append(words)
    return Fit(
        {field: np.concatenate([getattr(body, field) for body in bodies]) for field in FIELDS}, told
    )


def _near(
    template: Body, row: Mapping[str, float], names: tuple[Sequence[str], Sequence[str]], who: str
) -> tuple[Body, str]:
    """A body with as much of what is asked for as there is: the exact measures alone, else all of
    them near."""
    exact, near = names
    hard = {name: row[name] for name in exact}
    every = {name: row[name] for name in (*exact, *near)}
    try:
        return scale(template, hard), ""
    except InputError as error:
        why = error.problems[0]
    try:
        return scale(template, {}, others=every), why
    except InputError as error:
        raise InputError([f"{who}: {problem}" for problem in error.problems]) from None


def _heavy(body: Body, row: Mapping[str, float]) -> Body:
    return replace(body, mass=body.mass * (row[MASS] / body.mass.sum())) if MASS in row else body


def fit_chunks(
    task: Task, chunks: Sequence[Population], *, processes: int, done: Callable[[int, Fit], None]
) -> None:
    """Fit chunks with so many processes at once; done(number, fit) is called for each as it is
    ready, in this thread.

    InputError as of `fit_chunk`, or where a process ends before its work.
    """
    if single_threaded():
        for number, people in enumerate(chunks):
            done(number, fit_chunk(task, people))
        return
    waiting: SimpleQueue[int] = SimpleQueue()
    for number in range(len(chunks)):
        waiting.put(number)
    ready: SimpleQueue[tuple[int, Fit | InputError]] = SimpleQueue()
    crowd = [_Child(task) for _ in range(min(processes, len(chunks)))]
    try:
        threads = [
            threading.Thread(target=child.serve, args=(chunks, waiting, ready), daemon=True)
            for child in crowd
        ]
        for thread in threads:
            thread.start()
        for _ in range(len(chunks)):
            number, found = ready.get()
            if isinstance(found, InputError):
                raise found
            done(number, found)
    finally:
        for child in crowd:
            child.stop()


def single_threaded() -> bool:
    """Whether this process was started with one thread for linear algebra."""
    return (
        os.environ.get("OMP_NUM_THREADS") == "1"
        and os.environ.get("OPENBLAS_NUM_THREADS", "1") == "1"
    )


class _Child:
    """A process that fits chunks: a task goes in, then chunks, and for each a fit comes out."""

    def __init__(self, task: Task) -> None:
        settings = (
            os.environ
            | dict.fromkeys(THREADS, "1")
            | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
        )
        command = [
            sys.executable,
            "-c",
            "from workbench.study.accommodation.crew_fit import main; main()",
        ]
        # in a session of its own: Ctrl-C in a terminal reaches the parent only, which then ends
        # this process
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=settings,
            start_new_session=True,
        )
        self.task = task

    def serve(
        self, chunks: Sequence[Population], waiting: SimpleQueue[int], ready: SimpleQueue[object]
    ) -> None:
        """Take chunks until none is left."""
        to = self.process.stdin
        back = self.process.stdout
        assert to is not None and back is not None
        try:
            pickle.dump(self.task, to)
            while True:
                number = waiting.get_nowait()
                pickle.dump(chunks[number], to)
                to.flush()
                ready.put((number, pickle.load(back)))
        except Empty:
            return
        except (OSError, ValueError, EOFError, pickle.UnpicklingError):
            ready.put(
                (
                    -1,
                    InputError(
                        "a process that fits bodies ended before its work: is there memory left?"
                    ),
                )
            )

    def stop(self) -> None:
        """End the process."""
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                pipe.close()
        self.process.terminate()
        self.process.wait()


def main() -> None:
    """The work of a child: read a task, then chunks; write what became of each."""
    source = sys.stdin.buffer
    sink = sys.stdout.buffer
    task = pickle.load(source)
    while True:
        try:
            people = pickle.load(source)
        except EOFError:
            return
        try:
            found: Fit | InputError = fit_chunk(task, people)
        except InputError as error:
            found = error
        pickle.dump(found, sink)
        sink.flush()
