"""Bodies of a whole population: fitted in parallel, kept on disk, given out by rows.

A chunk of people is fitted by itself with one thread for linear algebra. Its bytes therefore depend
on nothing but its people: not on the number of processes, nor on who else is in the study. A fitted
chunk is an .npz file named by the key of what it was made from (see `model.content`). The
environment variable WORKBENCH_CACHE names the folder, or switches the files off.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing, suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from workbench.body.scaling.measure import MEASURES
from workbench.body.scaling.morph import morph
from workbench.body.scaling.scale import scale, scale_many
from workbench.body.scaling.seated import seated
from workbench.body.wear import wear
from workbench.contact.index_cache import cache_folder, forget_partial, read_arrays, write_arrays
from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints
from workbench.model.body import ROW_FIELDS, Body, body_of_rows, stack_bodies
from workbench.model.content import content_key
from workbench.model.person import Encumbrance
from workbench.model.population import MASS, SEXES, Population
from workbench.posture.seating.seat import SeatMemory
from workbench.study.executors import Shared, completed, worked
from workbench.study.passes import Count
from workbench.study.persons import APART
from workbench.study.situation import TakenPlaces
from workbench.threads import available_cores

__all__ = [
    "CHUNK_SIZE",
    "EXACT_MEASURES",
    "MOST_KEPT",
    "Family",
    "FittedChunk",
    "PopulationBodies",
    "fit_chunk",
    "fit_population",
    "templates_by_sex",
]

CHUNK_SIZE = 64
"""People that are fitted together: neighbours of one chunk start each other's search."""
MAX_CHUNKS_TOGETHER = 2
"""Fitted chunks that a study works on together at most."""
MOST_KEPT = 4
"""Chunks whose dressed bodies stay in memory."""
LEAST_CHUNK = 16
FEWEST_CHUNKS = 2
"""People that are worked on together at least, and the pieces of work that there are at least where
these are so many: it is said how far it is."""
MAX_FILES = 512
"""Files kept on disk, about a megabyte each; those used longest ago are removed."""
EXACT_MEASURES = (
    "stature",
    "sitting_height",
    "eye_height_sitting",
    "acromial_height_sitting",
    "thumb_tip_reach",
    "buttock_knee_length",
    "knee_height_sitting",
    "popliteal_height",
    "shoulder_elbow_length",
    "bideltoid_breadth",
    "thigh_clearance",
    "hip_breadth",
    "hip_breadth_sitting",
    "elbow_rest_height",
    "hand_length",
    "foot_length",
    "abdominal_extension_depth_sitting",
)
"""Measures that a body shows exactly, as far as they are known of the person; it shows all others
as nearly as it can. On a body, elbow rest height is acromial height sitting less shoulder-elbow
length, in people to 12 mm (they move their shoulders between measures): where both heights are
known, the upper arm's length is shown nearly, as reach is exact by itself."""
FITTED_FIELDS = (
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
    "seated_factors",
)
"""Fields of a body that differ between people of one sex."""


class FittedChunk(NamedTuple):
    """Fitted bodies: the FITTED_FIELDS by name, each (B, ...), and a note for each body.

    A note says why a body does not show all measures exactly; it is "" where the body does.
    """

    fields: dict[str, Floats]
    notes: list[str]


@dataclass(frozen=True, eq=False)
class Family:
    """What the bodies of a population share: a template with a row for each sex, clothes, and
    whether they sit."""

    template: Body
    encumbrances: tuple[Encumbrance, ...] = ()
    sits: bool = False

    @cached_property
    def dressed(self) -> Body:
        """The template, dressed. All bodies have its topology, and what is kept with that."""
        return wear(self.template, self.encumbrances, like=self.template[0])


@dataclass(frozen=True, eq=False)
class PopulationBodies:
    """Bodies of B people: `bodies[17]` and `bodies[rows]` are dressed bodies, a row each."""

    family: Family
    sex: Ints
    """(B,) index into SEXES."""
    fields: Mapping[str, Floats]
    """FITTED_FIELDS (B, ...) of the bare bodies."""
    notes: tuple[str, ...]
    """(B,) why a body does not show all measures exactly, "" where it does."""
    seats: dict[tuple[bytes, int, int], tuple[TakenPlaces, ...]] = field(default_factory=dict)
    """The places that the people of a chunk take in each case, by the key of what decides them and
    the chunk's first and last rows; filled as chunks are worked on."""
    held: dict[int, SeatMemory] = field(default_factory=dict)
    """Where the people of a chunk were seated in other positions, by its number; filled too."""
    kept: dict[tuple[int, int], Shared[Body]] = field(default_factory=dict, init=False)
    """The dressed bodies of a chunk by its first and last row, filled where chunks are few. Others
    than these bodies begin without any."""

    def __len__(self) -> int:
        return len(self.sex)

    def __getitem__(self, people: int | slice | Ints) -> Body:
        if isinstance(people, (int, np.integer)):
            people = np.array([people])
        family = self.family
        sex, fields = self.rows(people)
        template = family.template
        rows = {
            name: fields[name] if name in fields else getattr(template, name)[sex]
            for name in ROW_FIELDS
        }
        bare = body_of_rows(template, rows)
        if family.sits:
            bare = seated(bare)
        dressed = wear(bare, family.encumbrances, like=template[0])
        return body_of_rows(family.dressed, {name: getattr(dressed, name) for name in ROW_FIELDS})

    def chunk(self, number: int) -> Shared[Body]:
        """Return the dressed bodies of a chunk. Those of few chunks are kept, and with them what is
        made of them: a changed design asks the same people again."""
        rows = self.chunks[number]
        key = (rows.start, rows.stop)
        found = self.kept.get(key) or Shared(self[rows])
        if number < MOST_KEPT:
            self.kept[key] = found
        return found

    def rows(self, people: slice | Ints) -> tuple[Ints, dict[str, Floats]]:
        """Return what tells the bare bodies of some people (B,) apart: their sex (B,), and FITTED_FIELDS
        (B, ...) by name."""
        return self.sex[people], {name: rows[people] for name, rows in self.fields.items()}

    @property
    def chunks(self) -> list[slice]:
        """People that are worked on together. The more they are the less each of them costs: each
        core gets one chunk, if that is not too large. No number depends on it."""
        pieces = max(FEWEST_CHUNKS, available_cores())
        size = max(LEAST_CHUNK, -(-len(self) // pieces))
        size = min(size, CHUNK_SIZE * MAX_CHUNKS_TOGETHER)
        return [slice(first, min(first + size, len(self))) for first in range(0, len(self), size)]


def fit_population(
    body: Body,
    people: Population,
    encumbrances: Sequence[Encumbrance] = (),
    *,
    sits: bool = False,
    executor: Executor | None = None,
    progress: Count = lambda done, total: None,
) -> PopulationBodies:
    """Fit a body to each person; chunks that an earlier run fitted are read from disk.

    Parameters
    ----------
    body
        A body of the family that people are made from.
    people
        B people.
    encumbrances
        What everybody wears.
    sits
        Whether everybody has the flesh of hips and thighs spread as on a seat.
    executor
        Fits the chunks: processes of this machine if None. The bytes are the same for all.
    progress
        Called with a line on how many people are fitted.

    Raises
    ------
    InputError
        If there is no body for somebody's measures.
    """
    templates = templates_by_sex(body)
    family = Family(stack_bodies([templates[sex] for sex in SEXES]), tuple(encumbrances), sits)
    fields = {
        name: np.empty((len(people), *getattr(family.template, name).shape[1:]))
        for name in FITTED_FIELDS
    }
    notes = [""] * len(people)
    with closing(_fitted_chunks(templates, people, executor, progress)) as chunks:
        for first, chunk in chunks:
            rows = slice(first, first + len(chunk.notes))
            notes[rows] = chunk.notes
            for name, values in chunk.fields.items():
                fields[name][rows] = values
    return PopulationBodies(family, people.sex, fields, tuple(notes))


def _fitted_chunks(
    templates: Mapping[str, Body],
    people: Population,
    executor: Executor | None,
    progress: Count,
) -> Generator[tuple[int, FittedChunk]]:
    """Yield each chunk and the number of its first person: those on disk, then those to fit."""
    base = content_key("fitting", templates, EXACT_MEASURES)
    missing: dict[int, tuple[bytes, Population]] = {}
    for first in range(0, len(people), CHUNK_SIZE):
        chunk = people.rows(np.arange(first, min(first + CHUNK_SIZE, len(people))))
        key = content_key("fitted bodies", base, chunk)
        kept = _read_chunk(key)
        if kept is None:
            missing[first] = key, chunk
        else:
            yield first, kept
    if missing:
        yield from _fit_missing(templates, missing, executor, progress)
        _remove_old_files()


def _fit_missing(
    templates: Mapping[str, Body],
    missing: Mapping[int, tuple[bytes, Population]],
    executor: Executor | None,
    progress: Count,
) -> Generator[tuple[int, FittedChunk]]:
    """Fit chunks, by key and people, in parallel; keep each and yield it as it is ready."""
    shared = Shared(templates)
    total = sum(len(people) for _, people in missing.values())
    progress(0, total)
    jobs = completed(
        _fit_shared,
        list(missing),
        lambda first: (shared, missing[first][1]),
        executor=executor,
        waiting=lambda done: progress(total * done / len(missing), total),
    )
    with closing(jobs):
        for first, fitted in jobs:
            _write_chunk(missing[first][0], fitted)
            yield first, fitted


def templates_by_sex(body: Body) -> dict[str, Body]:
    """Return the body that men and the body that women are made from.

    A family with a typical adult of each sex gives these two; another body serves both sexes.
    """
    basis = body.basis
    if basis is None:
        return dict.fromkeys(SEXES, body)
    level = next(
        name
        for name, detail in basis.details.items()
        if len(detail.names) == len(body.sphere_names)
    )
    anchors = dict(zip(basis.anchor_names, basis.anchors, strict=True))
    if not {f"adult_{sex}" for sex in SEXES} <= set(anchors):
        return dict.fromkeys(SEXES, body)
    return {sex: morph(body, anchors[f"adult_{sex}"], level) for sex in SEXES}


def _fit_shared(templates: Shared[Mapping[str, Body]], people: Population) -> FittedChunk:
    return fit_chunk(templates.value, people)


def fit_chunk(templates: Mapping[str, Body], people: Population) -> FittedChunk:
    """Fit a body to each of some people, with one thread for linear algebra.

    Several threads would sum in another order and give other last digits. A person whose exact
    measures have no body gets one that shows all measures nearly, and a note. The masses of the
    segments add up to the person's.

    Parameters
    ----------
    templates
        The body to start from by sex.
    people
        One person or more.

    Raises
    ------
    InputError
        If there is no body for somebody's measures.
    """
    persons = _persons(people)
    with threadpool_limits(limits=1, user_api="blas"):
        streams = {
            sex: scale_many(
                templates[sex],
                [person.exact for person in persons if person.sex == sex],
                others=[person.near for person in persons if person.sex == sex],
            )
            for sex in SEXES
        }
        found = []
        for one in persons:
            found.append(_fit(templates[one.sex], one, next(streams[one.sex])))
            worked(len(found) / len(persons))
    bodies = [body for body, _ in found]
    fields = {name: np.concatenate([getattr(b, name) for b in bodies]) for name in FITTED_FIELDS}
    masses = [_mass_of(one, body) for one, body in zip(persons, bodies, strict=True)]
    fields["mass"] = np.concatenate(masses)
    return FittedChunk(fields, [note for _, note in found])


def _mass_of(person: _Person, body: Body) -> Floats:
    """(1, N) [kg] masses of the segments that add up to the person's, the body's where that is not
    known."""
    if person.mass is None:
        return body.mass
    mass: Floats = body.mass * (person.mass / body.mass.sum())
    return mass


@dataclass(frozen=True)
class _Person:
    """What a body is fitted to: lengths [m] to show exactly and nearly, and the mass [kg]."""

    name: str
    sex: str
    exact: dict[str, float]
    near: dict[str, float]
    mass: float | None


def _persons(people: Population) -> list[_Person]:
    exact = [name for name in EXACT_MEASURES if name in people.names]
    if {"elbow_rest_height", "acromial_height_sitting"} <= set(exact):
        exact = [name for name in exact if name != "shoulder_elbow_length"]
    near = [n for n in people.names if n in MEASURES and n not in (*exact, *APART)]
    persons = []
    labels = people.labels or [str(number) for number in range(len(people))]
    for label, code, values in zip(labels, people.sex, people.measures.tolist(), strict=True):
        row = dict(zip(people.names, values, strict=True))
        one = _Person(
            name=f"{SEXES[code]} {label}",
            sex=SEXES[code],
            exact={name: row[name] for name in exact},
            near={name: row[name] for name in near},
            mass=row.get(MASS),
        )
        persons.append(one)
    return persons


def _fit(template: Body, person: _Person, found: Body | InputError) -> tuple[Body, str]:
    """Return the body found, or the next best one with a note."""
    return _fit_nearly(template, person) if isinstance(found, InputError) else (found, "")


def _fit_nearly(template: Body, person: _Person) -> tuple[Body, str]:
    """Fit the exact measures alone; failing that, all measures nearly, with a note."""
    try:
        return scale(template, person.exact), ""
    except InputError as error:
        note = error.problems[0]
    try:
        return scale(template, {}, others=person.exact | person.near), note
    except InputError as error:
        raise InputError([f"{person.name}: {problem}" for problem in error.problems]) from None


def _path(key: bytes) -> Path | None:
    folder = cache_folder()
    return folder / "people" / f"{key[:20].hex()}.npz" if folder is not None else None


def _read_chunk(key: bytes) -> FittedChunk | None:
    """Read a fitted chunk; None where it must be fitted: not kept, or damaged."""
    path = _path(key)
    arrays = read_arrays(path, key) if path is not None else None
    if path is None or arrays is None:
        return None
    with suppress(OSError):
        path.touch()  # files used longest ago are removed first
    return FittedChunk({name: arrays[name] for name in FITTED_FIELDS}, arrays["notes"].tolist())


def _write_chunk(key: bytes, chunk: FittedChunk) -> None:
    """Keep a fitted chunk where the disk allows it: the file saves time and decides nothing."""
    path = _path(key)
    if path is not None:
        with suppress(OSError):
            write_arrays(path, key, chunk.fields | {"notes": np.array(chunk.notes, dtype=str)})


def _remove_old_files() -> None:
    """Remove what was used longest ago, and what a killed process left half written."""
    folder = cache_folder()
    if folder is None or not (folder / "people").is_dir():
        return
    with suppress(OSError):
        files = sorted((folder / "people").iterdir(), key=lambda path: path.stat().st_mtime)
        for path in files[:-MAX_FILES]:
            path.unlink(missing_ok=True)
        forget_partial(folder / "people")
