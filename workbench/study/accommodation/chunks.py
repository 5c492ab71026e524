"""The work of an accommodation study in chunks of people, each written whole: a run that is killed
goes on from there.

A chunk's file is named by its key (see `solve.content`), which is made from the whole study, the
chunk's fitted bodies and the program: a file is used again for nothing else. Chunks may be worked
on by this process, or by the workers of a Dask cluster: the numbers are the same.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import closing, suppress
from functools import lru_cache
from pathlib import Path
from time import monotonic
from typing import Protocol

import numpy as np

from workbench.contact.index_cache import PARTIAL
from workbench.errors import InputError
from workbench.model.accommodation import AccommodationStudy
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.content import content_key
from workbench.model.poses import Poses
from workbench.posture.seating.seat import Seated
from workbench.study.accommodation.crew import Crew
from workbench.study.accommodation.crew_files import Kept, read_kept, write_kept
from workbench.study.accommodation.forks import shared
from workbench.study.accommodation.requirements import Asked
from workbench.study.accommodation.sitters import Sitters, seated, seating_study
from workbench.study.accommodation.tried import Tried, judged, met_by, sitting

__all__ = [
    "Chunk",
    "chunk_result",
    "forget_chunks",
    "gathered",
    "result_chunks",
    "seat_key",
    "seated_chunk",
    "time_left",
]

Say = Callable[[str], None]


class Chunk:
    """What became of the people of a chunk: margin (B, R), reason (B, R) into words, toward (B, R,
    3), seat (B, 2)."""

    def __init__(self, kept: Kept) -> None:
        self.margin: Floats = kept.arrays["margin"]
        self.reason: Ints = kept.arrays["reason"]
        self.toward: Floats = kept.arrays["toward"]
        self.seat: Floats = kept.arrays["seat"]
        self.words = tuple(kept.texts["words"])


class Workers(Protocol):
    """Somebody else who does the work: see study.cluster."""

    def tried(
        self, study: AccommodationStudy, asked: Sequence[Asked], crew: Crew, chunks: Sequence[int]
    ) -> Generator[tuple[int, Kept]]:
        """The chunks of these numbers as they get ready, in any order."""


def result_chunks(
    study: AccommodationStudy,
    asked: Sequence[Asked],
    crew: Crew,
    *,
    keep: Path | None,
    say: Say,
    workers: Workers | None = None,
) -> list[Chunk]:
    """The chunks of a study in order, those of an earlier run read back from the folder `keep`.

    workers: who does the work, this process where None; the numbers are the same. InputError where
    a chunk cannot be written; those written before stay.
    """
    keys = _chunk_keys(study, asked, crew) if keep is not None else []
    paths = (
        [keep / f"{chunk:05d}-{key[:8].hex()}.chunk" for chunk, key in enumerate(keys)]
        if keep is not None
        else []
    )
    found = {
        chunk: kept
        for chunk, path in enumerate(paths)
        if (kept := read_kept(path, keys[chunk])) is not None
    }
    missing = [chunk for chunk in range(len(crew)) if chunk not in found]
    begun = monotonic()
    people = sum(crew.rows(chunk).stop - crew.rows(chunk).start for chunk in missing)
    done = 0
    say(f"person 0 of {people}")
    source = (
        workers.tried(study, asked, crew, missing)
        if workers is not None
        else _here(study, asked, crew, missing)
    )
    try:
        with closing(source) as ready:
            for chunk, kept in ready:
                if paths:
                    write_kept(paths[chunk], keys[chunk], kept)
                found[chunk] = kept
                done += crew.rows(chunk).stop - crew.rows(chunk).start
                say(f"person {done} of {people}{time_left(begun, done, people - done)}")
    except InputError as error:
        if not paths or not done:
            raise
        went = f"{done} of {people} people are done and kept: the same command goes on from there"
        raise InputError([*error.problems, went]) from None
    except KeyboardInterrupt:
        kept_words = (
            "what was done is kept, and the same command goes on from there"
            if paths
            else "nothing is kept"
        )
        raise KeyboardInterrupt(f"stopped after {done} of {people} people: {kept_words}") from None
    return [Chunk(found[chunk]) for chunk in range(len(crew))]


def _chunk_keys(study: AccommodationStudy, asked: Sequence[Asked], crew: Crew) -> list[bytes]:
    """The key of each chunk: of the study, of what is asked, and of the chunk's people, what they
    wear and their fitted bodies."""
    base = content_key(
        "accommodation", study, tuple(asked), crew.task, crew.people, tuple(crew.wears)
    )
    return [
        content_key("chunk", base, crew.index(chunk), tuple(crew.fits_of(chunk)))
        for chunk in range(len(crew))
    ]


def _here(
    study: AccommodationStudy, asked: Sequence[Asked], crew: Crew, chunks: Sequence[int]
) -> Generator[tuple[int, Kept]]:
    """The chunks by processes of this machine, which also hand back where people sit: what is tried
    next needs it."""

    key = seat_key(study)

    def work(chunk: int) -> tuple[Kept, tuple[Seated, Poses] | None]:
        known = (key, chunk) in crew.sitting
        sitters = seated_chunk(study, crew, chunk)
        kept = packed(judged(study, asked, sitting(study, asked, sitters)))
        return kept, None if known else (sitters.seat, sitters.held)

    if (
        len(chunks) > 1
    ):  # one person here first: forks then know the kernels and what obstacles are indexed by
        row = int(crew.index(chunks[0])[0])
        met_by(study, asked, crew.body(row), [row])
    with closing(shared(work, chunks)) as ready:
        for chunk, (kept, seat) in ready:
            if seat is not None:
                crew.sitting[key, chunk] = Sitters(crew.bodies(chunk), *seat)
            yield chunk, kept


def seated_chunk(study: AccommodationStudy, crew: Crew, chunk: int) -> Sitters:
    """The people of a chunk in the seat; who has been seated already, for a study with the same
    seat, pedals and view, stays so."""
    at = seat_key(study), chunk
    if at not in crew.sitting:
        crew.sitting[at] = seated(study, crew.bodies(chunk), crew.index(chunk).tolist())
    found: Sitters = crew.sitting[at]
    return found


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


def chunk_result(
    study: AccommodationStudy, asked: Sequence[Asked], body: Body, rows: Sequence[int]
) -> Kept:
    """The numbers of one chunk, the people of these rows, as they are kept."""
    return packed(met_by(study, asked, body, rows))


def packed(tried: Tried) -> Kept:
    """What became of some people as arrays: words become numbers of a list."""
    said = tried.words.ravel().tolist()
    words = [word for word in dict.fromkeys(said) if word]
    number = {word: k for k, word in enumerate(words)} | {"": -1}
    reason = np.array([number[word] for word in said], dtype=np.int64)
    arrays = {
        "margin": tried.margin,
        "toward": tried.toward,
        "seat": tried.seat,
        "reason": reason.reshape(tried.margin.shape),
    }
    return Kept(arrays, {"words": words})


def gathered(chunks: Sequence[Chunk]) -> tuple[Chunk, tuple[str, ...]]:
    """All chunks as one, and the words that its reasons number, in the order in which they first
    occur."""
    words = list(dict.fromkeys(word for chunk in chunks for word in chunk.words))
    number = {word: k for k, word in enumerate(words)}
    reasons = []
    for chunk in chunks:
        table = np.array([number[word] for word in chunk.words] + [-1], dtype=np.int64)
        reasons.append(table[chunk.reason])
    arrays = {
        name: np.concatenate([getattr(chunk, name) for chunk in chunks])
        for name in ("margin", "toward", "seat")
    }
    return Chunk(Kept(arrays | {"reason": np.concatenate(reasons)}, {"words": words})), tuple(words)
