"""The chunks of an accommodation study on a Dask cluster: the same tasks and the same numbers as
without one.

A worker gets the study once, then a chunk at a time. What a worker that dies was at is done by
another; what was done before is with the one who asked.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from workbench.errors import InputError, MissingPartError
from workbench.model.accommodation import AccommodationStudy
from workbench.model.population import Population
from workbench.study.accommodation.chunks import chunk_result
from workbench.study.accommodation.crew import Crew
from workbench.study.accommodation.crew_files import Kept
from workbench.study.accommodation.crew_fit import Fit, Task, fit_chunk, fit_chunks, single_threaded
from workbench.study.accommodation.requirements import Asked
from workbench.threads import cores

__all__ = ["Cluster", "cluster_at"]

PATIENCE = 6
"""Seconds within which a scheduler must answer."""


class Cluster:
    """A Dask client that fits bodies and tries people out."""

    def __init__(self, client: Any) -> None:
        self.client = client

    def fit(
        self, task: Task, chunks: Sequence[Population], done: Callable[[int, Fit], None]
    ) -> None:
        """Fit chunks; done(number, fit) is called for each as it is ready."""
        for number, found in self._each(_fitted, task, [(people,) for people in chunks]):
            done(number, found)

    def tried(
        self, study: AccommodationStudy, asked: Sequence[Asked], crew: Crew, chunks: Sequence[int]
    ) -> Generator[tuple[int, Kept]]:
        """The chunks of these numbers as they get ready."""
        common = (study, tuple(asked), crew.task, tuple(crew.wears))
        pieces = [
            (crew.index(chunk).tolist(), [_plain(fit) for fit in crew.fits_of(chunk)])
            for chunk in chunks
        ]
        for number, found in self._each(_tried, common, pieces):
            yield chunks[number], found

    def _each(
        self, work: Callable[..., Any], common: object, pieces: Sequence[tuple[Any, ...]]
    ) -> Iterator[tuple[int, Any]]:
        """What `work` says of each piece, as it gets ready."""
        from distributed import as_completed

        held = self.client.scatter([common], hash=False)[0]
        tasks = [self.client.submit(work, held, *piece, pure=False) for piece in pieces]
        number = {task.key: n for n, task in enumerate(tasks)}
        for task in as_completed(tasks):
            found = task.result()
            if isinstance(found, InputError):
                raise found
            yield number[task.key], found
            task.release()


@contextmanager
def cluster_at(address: str) -> Iterator[Cluster]:
    """The cluster of a scheduler at an address, or one of its own with a process a core for
    "local".

    MissingPartError where Dask is not installed, InputError where nobody answers there.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise MissingPartError(
            "a cluster needs Dask: pip install 'bubbleman-workbench[cluster]'"
        ) from None
    if address == "local":
        with (
            LocalCluster(n_workers=cores(), threads_per_worker=1, dashboard_address=None) as own,
            Client(own) as client,
        ):
            yield Cluster(client)
        return
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, TimeoutError, ValueError) as error:
        why = str(error).split("\n")[0] or type(error).__name__
        said = f"no Dask scheduler answers at {address!r} within {PATIENCE} s ({why})"
        raise InputError(f"{said}; give its address, such as tcp://host:8786, or local") from None
    with client:
        yield Cluster(client)


def _plain(fit: Fit) -> Fit:
    """A fit whose arrays are in memory, not in a file of this machine."""
    return Fit({name: values.copy() for name, values in fit.fields.items()}, fit.told)


def _fitted(task: Task, people: Population) -> Fit | InputError:
    """A worker's fit of a chunk; with one thread for linear algebra, in a process of its own if
    need be."""
    try:
        if single_threaded():
            return fit_chunk(task, people)
        found: list[Fit] = []
        fit_chunks(task, [people], processes=1, done=lambda _, fit: found.append(fit))
        return found[0]
    except InputError as error:
        return InputError(error.problems)


def _tried(
    common: tuple[AccommodationStudy, Sequence[Asked], Task, Sequence[Any]],
    rows: Sequence[int],
    fits: Sequence[Fit],
) -> Kept:
    """A worker's numbers of a chunk, the people of these rows."""
    study, asked, task, wears = common
    crew = Crew(task, study.people.rows(np.array(rows)), wears, fits)
    return chunk_result(study, asked, crew.of(np.arange(len(rows))), rows)
