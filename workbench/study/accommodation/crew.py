"""The bodies of a whole population: fitted chunk by chunk, by several processes, and kept on disk.

A chunk is fitted by itself, always with one thread for linear algebra, so that its bytes depend on
nothing but the people in it: not on how many processes there are, nor on who else is in the study.
Kept chunks are files of plain numbers, named by the key of what they were made from (see
`solve.content`), and read back as they were. WORKBENCH_CACHE says where they are kept, or that they
are not, as for other things kept (see solve.contact.index_cache).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from workbench.body.scaling.morph import morph
from workbench.body.wear import wear
from workbench.contact.index_cache import cache_folder, forget_partial
from workbench.errors import InputError
from workbench.model.arrays import Ints
from workbench.model.body import ROW_FIELDS, Body, body_of_rows, stack_bodies
from workbench.model.content import content_key
from workbench.model.encumbrance import Encumbrance
from workbench.model.population import SEXES, Population
from workbench.study.accommodation.crew_files import Kept, read_kept, write_kept
from workbench.study.accommodation.crew_fit import FIELDS, Fit, Task, fit_chunks
from workbench.threads import cores

__all__ = ["CHUNK", "FITTED", "Crew", "Fitters", "crew_of", "templates"]

CHUNK = 64
"""People fitted together, and least people of a chunk of work."""
MOST_TOGETHER = 4
LEAST_CHUNKS = 8
"""Chunks of work are up to so many times CHUNK people, where that leaves so many of them: people
lead one another."""
FITTED = (
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
    "hand_length",
    "foot_length",
    "abdominal_extension_depth_sitting",
)
"""What a person's body shows exactly, as far as it is known of the person; all other measures are
drawn near."""
MOST_CHUNKS = 512
"""Chunks kept on disk, about a megabyte each; those used longest ago give way."""


class Crew:
    """The bodies of a population, chunk by chunk, made when they are asked for; size: people a
    chunk."""

    def __init__(
        self, task: Task, people: Population, wears: Sequence[Encumbrance], fits: Sequence[Fit]
    ) -> None:
        self.task = task
        self.people = people
        self.wears = wears
        self.fits = fits
        self.together = max(1, min(MOST_TOGETHER, len(fits) // LEAST_CHUNKS))
        self.size = self.together * len(fits[0].told)
        self.sitting: dict[
            tuple[bytes, int], Any
        ] = {}  # chunks that sit already, by what decides it and their number

    def __len__(self) -> int:
        return (len(self.people) + self.size - 1) // self.size

    def rows(self, chunk: int) -> slice:
        """The people of a chunk."""
        return slice(chunk * self.size, min((chunk + 1) * self.size, len(self.people)))

    def index(self, chunk: int) -> Ints:
        """The numbers of the people of a chunk."""
        return np.arange(*self.rows(chunk).indices(len(self.people)))

    def fits_of(self, chunk: int) -> Sequence[Fit]:
        """What was fitted of the people of a chunk."""
        return self.fits[chunk * self.together : (chunk + 1) * self.together]

    def bodies(self, chunk: int) -> Body:
        """The bodies of a chunk, dressed, a row each."""
        return self.of(self.index(chunk))

    def body(self, row: int) -> Body:
        """The body of one person, dressed."""
        return self.of(np.array([row]))

    def of(self, people: Ints) -> Body:
        """The bodies of some people, dressed, a row each."""
        templates = self.task.templates
        bare = stack_bodies([templates[sex] for sex in SEXES])[self.people.sex[people]]
        fields = {name: getattr(bare, name) for name in ROW_FIELDS}
        number, at = np.divmod(people, len(self.fits[0].told))
        for name in FIELDS:
            rows = [self.fits[n].fields[name][k] for n, k in zip(number, at, strict=True)]
            fields[name] = np.stack(rows)
        made = body_of_rows(bare, fields)
        return wear(made, self.wears, like=templates[SEXES[0]])

    @property
    def told(self) -> list[str]:
        """For each person, why not all measures could be had exactly, "" where they could."""
        return [words for fit in self.fits for words in fit.told]


class Fitters(Protocol):
    """Somebody else who fits bodies: see study.cluster."""

    def fit(
        self, task: Task, chunks: Sequence[Population], done: Callable[[int, Fit], None]
    ) -> None:
        """Fit chunks; done(number, fit) is called for each as it is ready."""


def crew_of(
    body: Body,
    people: Population,
    wears: Sequence[Encumbrance],
    *,
    say: Callable[[str], None],
    processes: int | None = None,
    workers: Fitters | None = None,
) -> Crew:
    """The bodies of a population, those of earlier runs read back. say: told how far it is.

    processes: how many fit at once, as many as cores where None; workers: somebody else who fits.
    The bytes depend on neither. InputError where somebody has no body.
    """
    task = Task(templates(body), FITTED)
    chunks = [
        people.rows(np.arange(a, min(a + CHUNK, len(people)))) for a in range(0, len(people), CHUNK)
    ]
    base = content_key("fitting", task)
    keys = [content_key("fitted bodies", base, chunk) for chunk in chunks]
    folder = _folder()
    fits = [_read(folder, key) for key in keys]
    missing = [number for number, fit in enumerate(fits) if fit is None]
    count = 0

    def done(number: int, fit: Fit) -> None:
        nonlocal count
        fits[missing[number]] = fit
        count += len(fit.told)
        say(f"fitting bodies: {count} of {sum(len(chunks[m]) for m in missing)}")
        _keep(folder, keys[missing[number]], fit)

    if missing:
        say(f"fitting bodies: 0 of {sum(len(chunks[m]) for m in missing)}")
        some = [chunks[m] for m in missing]
        if workers is not None:
            workers.fit(task, some, done)
        else:
            fit_chunks(task, some, processes=processes or cores(), done=done)
        _forget(folder)
    return Crew(task, people, wears, [fit for fit in fits if fit is not None])


def templates(body: Body) -> dict[str, Body]:
    """The body that men and that women are made from: of a family with a typical adult of each sex
    these, else the body itself."""
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


def _folder() -> Path | None:
    folder = cache_folder()
    return folder / "people" if folder is not None else None


def _read(folder: Path | None, key: bytes) -> Fit | None:
    if folder is None:
        return None
    path = folder / f"{key[:20].hex()}.crew"
    found = read_kept(path, key)
    if found is None or set(found.arrays) != set(FIELDS):
        return None
    return Fit({name: found.arrays[name] for name in FIELDS}, found.texts["told"])


def _keep(folder: Path | None, key: bytes, fit: Fit) -> None:
    """Keep a chunk, where the disk lets us: that saves time later and decides nothing."""
    if folder is None:
        return
    with suppress(InputError):
        write_kept(
            folder / f"{key[:20].hex()}.crew", key, Kept(dict(fit.fields), {"told": fit.told})
        )


def _forget(folder: Path | None) -> None:
    if folder is None or not folder.is_dir():
        return
    files = sorted(folder.glob("*.crew"), key=lambda path: path.stat().st_mtime)
    for path in files[:-MOST_CHUNKS]:
        path.unlink(missing_ok=True)
    forget_partial(folder)
