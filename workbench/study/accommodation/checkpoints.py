"""Evaluate an accommodation study in chunks of people, each kept on disk as soon as it is done.

A run that is cut off goes on from there. A chunk's file is named by its key (see `model.content`),
which is made from the whole study, the chunk's fitted bodies and the program: a file is used again
for nothing else. The numbers are the same for every executor.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Executor
from contextlib import closing, suppress
from dataclasses import astuple, dataclass, fields, replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.contact.index_cache import PARTIAL, read_arrays, write_arrays
from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.content import content_key
from workbench.model.criterion import NO_REASON, Reason
from workbench.model.population import Population
from workbench.model.workplace import Workplace
from workbench.posture.seating.seat import SeatMemory
from workbench.study.accommodation.overlaps import Overlaps, join_overlaps, people_overlaps
from workbench.study.accommodation.population_bodies import MOST_KEPT, PopulationBodies
from workbench.study.certainty import certain_elsewhere, true_bounds
from workbench.study.checks.margins import Asked, Bounds, no_bounds
from workbench.study.executors import Shared, completed, worked
from workbench.study.passes import Count
from workbench.study.positions import (
    WAVE,
    Before,
    FittedBody,
    comfortable_situations,
    fitted_positions,
    found_places,
    lattice,
    spacing_of,
    tried,
)
from workbench.study.situation import Occupants, Remembered, TakenPlaces, seating_of
from workbench.threads import available_cores

__all__ = [
    "Chunk",
    "PopulationQuestion",
    "forget_chunks",
    "joined_chunks",
    "result_chunks",
    "taken_places",
]

Say = Callable[[str], None]
_KEPT = "what was done is kept, and the same command goes on from there"


@dataclass(frozen=True, eq=False)
class Chunk:
    """What became of B people and R requirements, as numbers.

    margin (B, R), between low and high (B, R) where the surface of the body truly is, see
    `margins.Bounds`: all NaN where that was not asked; reason (B, R): index into `words`, -1 where
    there is none; toward (B, R, 3); seat, comfortable (B, 2), window (B, 4), sets (B, K), setting
    (B, A): see `positions.FittedBody`. elsewhere (B,): see `certainty.certain_elsewhere`; nobody where
    the bounds were not asked. overlap (O, 4), depth (O,): see `overlaps.Overlaps`; none where
    the bounds were not asked. judged_person (M,), judged (M, A + 2 + R): people in settings and
    positions that were judged, see `positions.FittedBody`.
    """

    margin: Floats
    low: Floats
    high: Floats
    reason: Ints
    toward: Floats
    seat: Floats
    comfortable: Floats
    window: Floats
    sets: Bools
    setting: Floats
    elsewhere: Bools
    overlap: Ints
    depth: Floats
    judged_person: Ints
    judged: Floats
    words: tuple[Reason, ...]

    @property
    def judged_where(self) -> Floats:
        """(M, A + 2) [m or rad] the setting and position of each row of `judged`."""
        return self.judged[:, : self.setting.shape[1] + 2]

    @property
    def judged_margin(self) -> Floats:
        """(M, R) [m] the margins of each row of `judged`, NaN where they are not known."""
        return self.judged[:, self.setting.shape[1] + 2 :]

    @property
    def overlapping(self) -> Bools:
        """(B,) who overlaps something by more than is allowed, about which no criterion asks."""
        return np.isin(np.arange(len(self.margin)), self.overlap[:, 0])


@dataclass(frozen=True, eq=False)
class PopulationQuestion:
    """What is the same for all people of a population.

    Parameters
    ----------
    place, asked
        The workplace and its requirements.
    members
        (R, K) the requirements of each set of which it is asked whether some position meets it.
        Without sets, people who fit are searched no further.
    people
        The population.
    before
        Of a changed design: how everybody came out without the change.
    bounded
        Whether it is asked between which margins the true ones lie.
    """

    place: Workplace
    asked: tuple[Asked, ...]
    members: Bools
    people: Population
    before: Before | None = None
    bounded: bool = True


def result_chunks(
    question: PopulationQuestion,
    bodies: PopulationBodies,
    *,
    keep: Path | None,
    tell: Count,
    executor: Executor | None = None,
) -> list[Chunk]:
    """Answer a question for everybody, chunk by chunk, or read what an earlier run kept.

    Parameters
    ----------
    bodies
        The bodies of the people.
    keep
        The folder of the chunks; nothing is kept if None.
    tell
        Called with how many people are done, those at hand in part, and of how many.
    executor
        Does the work: processes of this machine if None. The numbers are the same for all.

    Returns
    -------
    list of Chunk
        In the order of the people.

    Raises
    ------
    InputError
        If a chunk cannot be written; those written before stay.
    """
    files = _Files(keep, _chunk_keys(question, bodies) if keep is not None else [])
    found = files.read()
    missing = [number for number in range(len(bodies.chunks)) if number not in found]
    people = sum(_size(bodies.chunks[number]) for number in missing)
    done = 0

    def waiting(jobs: float) -> None:
        tell(people * jobs / len(missing), people)

    tell(0, people)
    try:
        with closing(_evaluated(question, bodies, missing, executor, waiting)) as ready:
            for number, chunk in ready:
                files.write(number, chunk)
                found[number] = chunk
                done += _size(bodies.chunks[number])
    except InputError as error:
        if keep is None or not done:
            raise
        went = f"{done} of {people} people are done and kept: the same command goes on from there"
        raise InputError([*error.problems, went]) from None
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"stopped after {done} of {people} people: "
            + (_KEPT if keep is not None and done else "nothing is kept")
        ) from None
    return [found[number] for number in range(len(bodies.chunks))]


@dataclass(frozen=True)
class _Files:
    """Chunks on disk, one .npz file each, named by its number and key."""

    folder: Path | None
    keys: list[bytes]

    def read(self) -> dict[int, Chunk]:
        """Return the chunks that are kept, by their numbers, without those that are damaged."""
        found = {}
        for number, key in enumerate(self.keys):
            arrays = read_arrays(self._path(number), key)
            if arrays is not None:
                words = tuple(Reason(*json.loads(one)) for one in arrays.pop("words").tolist())
                found[number] = Chunk(words=words, **arrays)
        return found

    def write(self, number: int, chunk: Chunk) -> None:
        """Keep a chunk, written in one step; InputError where the disk does not allow it."""
        if self.folder is None:
            return
        arrays: dict[str, NDArray[Any]] = {
            one.name: getattr(chunk, one.name) for one in fields(chunk)
        }
        arrays["words"] = np.array([json.dumps(astuple(one)) for one in chunk.words], dtype=str)
        try:
            write_arrays(self._path(number), self.keys[number], arrays)
        except OSError as error:
            raise InputError(f"{self.folder}: cannot be written ({error.strerror})") from None

    def _path(self, number: int) -> Path:
        assert self.folder is not None
        return self.folder / f"{number:05d}-{self.keys[number][:8].hex()}.chunk"


def _size(rows: slice) -> int:
    return int(rows.stop - rows.start)


def _numbers(rows: slice) -> Ints:
    return np.arange(rows.start, rows.stop)


def _chunk_keys(question: PopulationQuestion, bodies: PopulationBodies) -> list[bytes]:
    """Return the key of each chunk: of the study, what is asked, and the chunk's bare bodies."""
    base = content_key("accommodation", question, bodies.family)
    return [content_key("chunk", base, _numbers(rows), bodies.rows(rows)) for rows in bodies.chunks]


def _evaluated(
    question: PopulationQuestion,
    bodies: PopulationBodies,
    missing: Sequence[int],
    executor: Executor | None,
    waiting: Callable[[float], None],
) -> Generator[tuple[int, Chunk]]:
    """Yield the chunks of these numbers as they are done, and note where their people sit."""
    places = _places(question.place, question.people, bodies)
    shared = Shared(question)

    def arguments(number: int) -> tuple[object, ...]:
        rows = bodies.chunks[number]
        seats = bodies.held.get(number, SeatMemory())
        return shared, _numbers(rows), bodies.chunk(number), bodies.seats.get(places[number]), seats

    if executor is None and min(available_cores(), len(missing)) > 1:
        # one person here first: forks then have the compiled functions and the distance indexes;
        # from few starts, which is enough for that
        for number in missing[:MOST_KEPT]:
            bodies.chunk(number)
        row = bodies.chunks[missing[0]].start
        body = bodies.chunk(missing[0]).value[0]
        who = Occupants(body, question.people, np.array([row]))
        known = Remembered(1, np.zeros(1, dtype=np.int64), {}, few_starts=True)
        there = comfortable_situations(question.place, who)
        tried([replace(one, remembered=known) for one in there], question.asked)
    jobs = completed(_evaluate_chunk, missing, arguments, executor=executor, waiting=waiting)
    with closing(jobs) as ready:
        for number, (chunk, taken, seats) in ready:
            bodies.seats[places[number]] = taken
            bodies.held[number] = seats
            yield number, chunk


def _places(
    place: Workplace, people: Population, bodies: PopulationBodies
) -> list[tuple[bytes, int, int]]:
    """Return the key in `bodies.seats` of each chunk: of nothing but what decides where they are."""
    cases = tuple(seating_of(place, case) for case in range(len(place.cases)))
    key = content_key("seating", cases, people)
    return [(key, rows.start, rows.stop) for rows in bodies.chunks]


def _telling(place: Workplace) -> Callable[[], None]:
    """What is called before each batch of positions and tells how much of a chunk is done: all, after
    many; half of it after as many as a search of the travel takes."""
    usual = 2.0 + len(lattice(place.travel, spacing_of(place))) / WAVE
    calls = count()

    def proceed() -> None:
        worked(1.0 - 0.5 ** (next(calls) / usual))

    return proceed


def _evaluate_chunk(
    task: Shared[PopulationQuestion],
    numbers: Ints,
    body: Shared[Body],
    taken: tuple[TakenPlaces, ...] | None,
    seats: SeatMemory,
) -> tuple[Chunk, tuple[TakenPlaces, ...], SeatMemory]:
    """Answer a question for some people.

    Parameters
    ----------
    numbers
        (B,) numbers of the people in the population.
    body
        Their dressed bodies, a row each.
    taken
        The places they have taken, case by case; None where these are not known yet.
    seats
        Where they were seated in other positions.

    Returns
    -------
    Chunk, tuple of Taken and SeatMemory
        What became of the people, their places, and all positions that they were seated in.
    """
    question = task.value
    place = question.place
    who = Occupants(body.value, question.people, numbers, seats=seats)
    proceed = _telling(place)
    situations = comfortable_situations(place, who, taken or ())
    before = question.before.rows(numbers) if question.before is not None else None
    fitted = fitted_positions(
        place, question.asked, question.members, who, situations, before, proceed=proceed
    )
    bounds = no_bounds(len(who), question.asked)
    overlaps = join_overlaps([], [])
    elsewhere = np.zeros(len(who), dtype=np.bool_)
    if question.bounded:
        places = found_places(place, who, situations, fitted)
        bounds = true_bounds(question.asked, places, fitted)
        overlaps = join_overlaps(
            [people_overlaps(there) for _, there in places], [rows for rows, _ in places]
        )
        elsewhere = certain_elsewhere(place, question.asked, who, fitted, bounds, proceed=proceed)
    found = tuple(situation.taken for situation in situations)
    return _as_numbers(fitted, bounds, overlaps, elsewhere), taken or found, seats


def taken_places(
    place: Workplace,
    people: Population,
    bodies: PopulationBodies,
    *,
    executor: Executor | None = None,
) -> list[tuple[TakenPlaces, ...]]:
    """Return the comfortable places that the people of each chunk take in each case.

    Who has taken a place already, in a workplace with the same seat, pedals and view, stays there.
    """
    keys = _places(place, people, bodies)
    question = PopulationQuestion(place, (), np.zeros((0, 0), dtype=np.bool_), people)
    task = Shared(question)
    missing = [number for number, key in enumerate(keys) if key not in bodies.seats]

    def arguments(number: int) -> tuple[object, ...]:
        return task, _numbers(bodies.chunks[number]), bodies.chunk(number)

    with closing(completed(_take_chunk, missing, arguments, executor=executor)) as ready:
        for number, taken in ready:
            bodies.seats[keys[number]] = taken
    return [bodies.seats[key] for key in keys]


def _take_chunk(
    task: Shared[PopulationQuestion], numbers: Ints, body: Shared[Body]
) -> tuple[TakenPlaces, ...]:
    question = task.value
    who = Occupants(body.value, question.people, numbers)
    situations = comfortable_situations(question.place, who)
    return tuple(situation.taken for situation in situations)


def forget_chunks(keep: Path) -> None:
    """Remove the chunks that were kept in a folder, and the folder if nothing else is in it: the
    work is done.

    What was half written when a run was killed goes too.
    """
    if keep.is_dir():
        for pattern in ("*.chunk", f"{PARTIAL}*"):
            for path in keep.glob(pattern):
                path.unlink(missing_ok=True)
        with suppress(OSError):
            keep.rmdir()


def _as_numbers(fitted: FittedBody, bounds: Bounds, overlaps: Overlaps, elsewhere: Bools) -> Chunk:
    """What became of some people as numbers: words become indices into a list."""
    found = fitted.tried
    rows = fitted.judged.tolist()
    every = found.words.ravel().tolist()
    words = tuple(word for word in dict.fromkeys(every) if word)
    number = {word: k for k, word in enumerate(words)} | {NO_REASON: -1}
    reason = np.array([number[word] for word in every], dtype=np.int64)
    return Chunk(
        margin=found.margin,
        low=bounds.low,
        high=bounds.high,
        reason=reason.reshape(found.margin.shape),
        toward=found.toward,
        seat=found.seat,
        comfortable=fitted.comfortable,
        window=fitted.window,
        sets=fitted.sets,
        setting=fitted.setting,
        elsewhere=elsewhere,
        overlap=overlaps.pair,
        depth=overlaps.depth,
        judged_person=np.repeat(np.arange(len(rows)), [len(some) for some in rows]),
        judged=np.array([row for some in rows for row in some], dtype=np.float64).reshape(
            -1, fitted.setting.shape[1] + 2 + found.margin.shape[1]
        ),
        words=words,
    )


def joined_chunks(chunks: Sequence[Chunk]) -> Chunk:
    """All chunks as one; its words stand in the order in which they first occur."""
    words = tuple(dict.fromkeys(word for chunk in chunks for word in chunk.words))
    number = {word: k for k, word in enumerate(words)}
    reasons = []
    for chunk in chunks:
        table = np.array([number[word] for word in chunk.words] + [-1], dtype=np.int64)
        reasons.append(table[chunk.reason])
    ends = np.cumsum([0, *(len(chunk.margin) for chunk in chunks)])
    overlaps = join_overlaps(
        [Overlaps(chunk.overlap, chunk.depth) for chunk in chunks],
        [np.arange(*ends[k : k + 2]) for k in range(len(chunks))],
    )
    judged = [chunk.judged_person + first for chunk, first in zip(chunks, ends[:-1], strict=True)]
    joined: dict[str, Any] = {
        "reason": np.concatenate(reasons),
        "overlap": overlaps.pair,
        "depth": overlaps.depth,
        "judged_person": np.concatenate(judged),
        "words": words,
    }
    for one in fields(Chunk):
        if one.name not in joined:
            joined[one.name] = np.concatenate([getattr(chunk, one.name) for chunk in chunks])
    return Chunk(**joined)
