"""Evaluate an accommodation study in chunks of people, each kept on disk as soon as it is done.

A run that is cut off goes on from there. A chunk's file is named by its key (see `model.content`),
which is made from the whole study, the chunk's fitted bodies and the program: a file is used again
for nothing else. The numbers are the same for every executor.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Executor
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.contact.index_cache import PARTIAL, read_arrays, write_arrays
from workbench.errors import InputError
from workbench.model.accommodation import AccommodationStudy
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.content import content_key
from workbench.model.poses import Poses
from workbench.posture.seating.seat import Seated
from workbench.study.accommodation.population_bodies import Family, PopulationBodies
from workbench.study.accommodation.positions import Before, Fitted, fitted_positions
from workbench.study.accommodation.requirements import Asked, sets_of
from workbench.study.accommodation.sitters import Sitters, seated, seating_study
from workbench.study.accommodation.tried import judged, sitting
from workbench.study.executors import Shared, completed

__all__ = [
    "Chunk",
    "evaluate_chunk",
    "forget_chunks",
    "gathered",
    "result_chunks",
    "seat_everybody",
    "time_left",
]

Say = Callable[[str], None]
Seat = tuple[Seated, Poses]
"""Where people sit, and their poses with the hands at rest."""
_KEPT = "what was done is kept, and the same command goes on from there"


@dataclass(frozen=True, eq=False)
class Chunk:
    """What became of B people and R requirements, as numbers.

    margin (B, R); reason (B, R): index into `words`, -1 where there is none; toward (B, R, 3); seat,
    comfortable (B, 2), window (B, 4), sets (B, K): see `positions.Fitted`.
    """

    margin: Floats
    reason: Ints
    toward: Floats
    seat: Floats
    comfortable: Floats
    window: Floats
    sets: Bools
    words: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Question:
    """What is the same for all chunks of a study: its requirements, and the family of its people."""

    study: AccommodationStudy
    asked: tuple[Asked, ...]
    family: Family
    before: Before | None = None
    """Of a changed design: how everybody came out without the change."""
    with_sets: bool = True
    """Whether `sets` are wanted; without them people who fit are searched no further."""


def result_chunks(
    study: AccommodationStudy,
    asked: Sequence[Asked],
    bodies: PopulationBodies,
    *,
    keep: Path | None,
    say: Say,
    executor: Executor | None = None,
    before: Before | None = None,
    with_sets: bool = True,
) -> list[Chunk]:
    """Evaluate the chunks of a study, or read those that an earlier run kept.

    Parameters
    ----------
    study, asked, bodies
        The study, its requirements and the bodies of its people.
    keep
        The folder of the chunks; nothing is kept if None.
    say
        Called with a line on how many people are done.
    executor
        Does the work: processes of this machine if None. The numbers are the same for all.
    before
        Of a changed design: how everybody came out without the change.
    with_sets
        Whether `sets` are wanted, which costs more positions.

    Returns
    -------
    list of Chunk
        In the order of the people.

    Raises
    ------
    InputError
        If a chunk cannot be written; those written before stay.
    """
    question = Question(study, tuple(asked), bodies.family, before, with_sets)
    files = _Files(keep, _chunk_keys(question, bodies) if keep is not None else [])
    found = files.read()
    missing = [number for number in range(len(bodies.chunks)) if number not in found]
    people = sum(_size(bodies.chunks[number]) for number in missing)
    begun = monotonic()
    done = 0
    say(f"person 0 of {people}")
    try:
        with closing(_evaluated(question, bodies, missing, executor)) as ready:
            for number, chunk in ready:
                files.write(number, chunk)
                found[number] = chunk
                done += _size(bodies.chunks[number])
                say(f"person {done} of {people}{time_left(begun, done, people - done)}")
    except InputError as error:
        if keep is None or not done:
            raise
        went = f"{done} of {people} people are done and kept: the same command goes on from there"
        raise InputError([*error.problems, went]) from None
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"stopped after {done} of {people} people: "
            + ("nothing is kept" if keep is None else _KEPT)
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
                words = tuple(arrays.pop("words").tolist())
                found[number] = Chunk(words=words, **arrays)
        return found

    def write(self, number: int, chunk: Chunk) -> None:
        """Keep a chunk, written in one step; InputError where the disk does not allow it."""
        if self.folder is None:
            return
        arrays: dict[str, NDArray[Any]] = {
            "margin": chunk.margin,
            "reason": chunk.reason,
            "toward": chunk.toward,
            "seat": chunk.seat,
            "comfortable": chunk.comfortable,
            "window": chunk.window,
            "sets": chunk.sets,
            "words": np.array(chunk.words, dtype=str),
        }
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


def _chunk_keys(question: Question, bodies: PopulationBodies) -> list[bytes]:
    """Return the key of each chunk: of the study, what is asked, and the chunk's bare bodies."""
    base = content_key("accommodation", question)
    return [content_key("chunk", base, _numbers(rows), bodies.rows(rows)) for rows in bodies.chunks]


def _evaluated(
    question: Question,
    bodies: PopulationBodies,
    missing: Sequence[int],
    executor: Executor | None,
) -> Generator[tuple[int, Chunk]]:
    """Yield the chunks of these numbers as they are done, and note where their people sit."""
    places = _places(question.study, bodies)
    shared = Shared(question)

    def arguments(number: int) -> tuple[object, ...]:
        rows = bodies.chunks[number]
        return shared, _numbers(rows), bodies.rows(rows), bodies.seats.get(places[number])

    if executor is None and len(missing) > 1:
        # one person here first: forks then have the compiled functions and the distance indexes
        row = bodies.chunks[missing[0]].start
        people = seated(question.study, bodies[row], [row])
        judged(question.study, question.asked, sitting(question.study, question.asked, people))
    with closing(completed(evaluate_chunk, missing, arguments, executor=executor)) as ready:
        for number, (chunk, seat) in ready:
            if seat is not None:
                bodies.seats[places[number]] = seat
            yield number, chunk


def _places(study: AccommodationStudy, bodies: PopulationBodies) -> list[tuple[bytes, int, int]]:
    """Return the key in `bodies.seats` of each chunk."""
    key = seat_key(study)
    return [(key, rows.start, rows.stop) for rows in bodies.chunks]


def evaluate_chunk(
    question: Shared[Question],
    numbers: Ints,
    rows: tuple[Ints, dict[str, Floats]],
    seat: Seat | None,
) -> tuple[Chunk, Seat | None]:
    """Evaluate all requirements for some people.

    Parameters
    ----------
    question
        What is the same for all chunks.
    numbers
        (B,) numbers of the people in the study's population.
    rows
        Their sex and fitted fields, as `PopulationBodies.rows` gives them.
    seat
        Where they sit; None where that is not known yet.

    Returns
    -------
    Chunk and Seat
        What became of the people, and where they sit if that was not given.
    """
    study = question.value.study
    asked = question.value.asked
    body = question.value.family.body(*rows)
    sitters = (
        seated(study, body, numbers.tolist()) if seat is None else Sitters(body, seat[0], seat[1])
    )
    before = question.value.before
    sets = (
        sets_of(study, asked)
        if question.value.with_sets
        else np.zeros((len(asked), 0), dtype=np.bool_)
    )
    fitted = fitted_positions(
        study,
        asked,
        sets,
        sitters,
        numbers.tolist(),
        before.rows(numbers) if before is not None else None,
    )
    chunk = packed(fitted)
    return chunk, (sitters.seat, sitters.held) if seat is None else None


def seat_everybody(
    study: AccommodationStudy, bodies: PopulationBodies, *, executor: Executor | None = None
) -> list[Seat]:
    """Return where the people of each chunk sit.

    Who has been seated already, for a study with the same seat, pedals and view, stays so.
    """
    places = _places(study, bodies)
    question = Shared(Question(study, (), bodies.family))
    missing = [number for number, place in enumerate(places) if place not in bodies.seats]

    def arguments(number: int) -> tuple[object, ...]:
        rows = bodies.chunks[number]
        return question, _numbers(rows), bodies.rows(rows)

    with closing(completed(_seat_chunk, missing, arguments, executor=executor)) as ready:
        for number, seat in ready:
            bodies.seats[places[number]] = seat
    return [bodies.seats[place] for place in places]


def _seat_chunk(
    question: Shared[Question], numbers: Ints, rows: tuple[Ints, dict[str, Floats]]
) -> Seat:
    body = question.value.family.body(*rows)
    sitters = seated(question.value.study, body, numbers.tolist())
    return sitters.seat, sitters.held


@lru_cache(maxsize=16)
def seat_key(study: AccommodationStudy) -> bytes:
    """The key of where people sit: of the part of the study that decides it."""
    return content_key("seating", seating_study(study))


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


def time_left(begun: float, done: int, left: int) -> str:
    """ ", 40 s left", from what was done since the beginning."""
    if not done or not left:
        return ""
    seconds = (monotonic() - begun) / done * left
    return f", {seconds:.0f} s left" if seconds < 120 else f", {seconds / 60:.0f} min left"


def packed(fitted: Fitted) -> Chunk:
    """What became of some people as numbers: words become indices into a list."""
    tried = fitted.tried
    said = tried.words.ravel().tolist()
    words = tuple(word for word in dict.fromkeys(said) if word)
    number = {word: k for k, word in enumerate(words)} | {"": -1}
    reason = np.array([number[word] for word in said], dtype=np.int64)
    return Chunk(
        margin=tried.margin,
        reason=reason.reshape(tried.margin.shape),
        toward=tried.toward,
        seat=tried.seat,
        comfortable=fitted.comfortable,
        window=fitted.window,
        sets=fitted.sets,
        words=words,
    )


def gathered(chunks: Sequence[Chunk]) -> Chunk:
    """All chunks as one; its words stand in the order in which they first occur."""
    words = tuple(dict.fromkeys(word for chunk in chunks for word in chunk.words))
    number = {word: k for k, word in enumerate(words)}
    reasons = []
    for chunk in chunks:
        table = np.array([number[word] for word in chunk.words] + [-1], dtype=np.int64)
        reasons.append(table[chunk.reason])
    return Chunk(
        margin=np.concatenate([chunk.margin for chunk in chunks]),
        reason=np.concatenate(reasons),
        toward=np.concatenate([chunk.toward for chunk in chunks]),
        seat=np.concatenate([chunk.seat for chunk in chunks]),
        comfortable=np.concatenate([chunk.comfortable for chunk in chunks]),
        window=np.concatenate([chunk.window for chunk in chunks]),
        sets=np.concatenate([chunk.sets for chunk in chunks]),
        words=words,
    )
