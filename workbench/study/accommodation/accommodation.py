"""The accommodation study: a whole population through one workplace, who is left out, by what and
by how much."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

import numpy as np

from workbench.body.forward import place
from workbench.body.parts import moved
from workbench.body.pieces import piece_warnings
from workbench.errors import InputError
from workbench.model.accommodation import (
    MET,
    AccommodationStudy,
    GroupShare,
    PopulationFound,
)
from workbench.model.arrays import Bools
from workbench.study.accommodation.chunks import Chunk, gathered, result_chunks
from workbench.study.accommodation.gains import gains_of
from workbench.study.accommodation.hardest import hardest_rows, in_position, shown_people
from workbench.study.accommodation.limiting import bearing_on, limiting_measures
from workbench.study.accommodation.people_maps import people_maps
from workbench.study.accommodation.population_bodies import PopulationBodies, fit_population
from workbench.study.accommodation.requirements import Asked, asked_of
from workbench.study.accommodation.shares import (
    group_shares,
    left_out_alone,
    share_single,
    share_without,
    spread_of,
)
from workbench.study.reaches import buried_controls
from workbench.study.warnings import enclosure_warnings

__all__ = ["accommodation_study"]

Say = Callable[[str], None]
EXPECTED = 10.0
"""People who should meet two requirements, if these had nothing to do with each other, from which
on it says something that nobody does."""


def accommodation_study(
    study: AccommodationStudy,
    *,
    keep: Path | None = None,
    say: Say = lambda text: None,
    executor: Executor | None = None,
) -> PopulationFound:
    """Put a population into its seat and ask everything of everybody.

    keep: a folder in which chunks of people are kept until it is done, so that a run that is cut
    off goes on where it was; say: called with how far it is; executor: does the work, processes of
    this machine if None, with the same numbers. InputError where a chunk cannot be written, or
    somebody cannot be given a body.
    """
    asked = asked_of(study)
    if not asked:
        raise InputError(f"{study.name}: no criterion asks for anything")
    bodies = fit_population(study.body, study.people, study.wears, executor=executor, progress=say)
    found = gathered(result_chunks(study, asked, bodies, keep=keep, say=say, executor=executor))
    met: Bools = np.asarray(np.isnan(found.margin) | (found.margin >= -MET))
    weight = study.people.weight
    hardest = hardest_rows(found.margin)
    return PopulationFound(
        study=study,
        requirements=tuple(one.requirement for one in asked),
        margin=found.margin,
        reason=found.reason,
        reasons=found.words,
        seat=found.seat,
        comfortable=found.comfortable,
        window=found.window,
        sets=found.sets,
        limiting=_limiting(study, asked, found),
        shares=_shares(study, np.asarray(met.all(axis=1))),
        single=share_single(met, weight),
        without=share_without(found.sets[:, : len(asked)], weight),
        alone=left_out_alone(met, found.sets[:, : len(asked)], weight),
        spread=spread_of(found.margin, weight),
        hardest=hardest,
        gains=tuple(gains_of(study, asked, bodies, found, keep=keep, say=say, executor=executor)),
        maps=tuple(people_maps(study, bodies, say=say, executor=executor)),
        warnings=(
            *_warnings(study, asked, bodies, met),
            *_around(study, bodies, found, hardest),
            *study.warnings,
        ),
        shown=tuple(shown_people(study, asked, bodies, found, hardest)),
    )


def _shares(study: AccommodationStudy, served: Bools) -> tuple[GroupShare, ...]:
    rule = study.interval
    return tuple(
        group_shares(served, study.people, study.mixes, confidence=study.confidence, interval=rule)
    )


def _limiting(study: AccommodationStudy, asked: tuple[Asked, ...], found: Chunk) -> tuple[str, ...]:
    """For everybody left out the measure that is oddest of those that bear on what is missed by
    most."""
    worst = np.nan_to_num(found.margin, nan=np.inf)
    rows = np.flatnonzero(worst.min(axis=1) < -MET)
    at = worst[rows].argmin(axis=1)
    words = [
        found.words[int(found.reason[row, r])] if found.reason[row, r] >= 0 else ""
        for row, r in zip(rows, at, strict=True)
    ]
    bearing = [
        bearing_on(asked[int(r)], said, study.body) for r, said in zip(at, words, strict=True)
    ]
    names = [""] * len(study.people)
    for row, name in zip(rows, limiting_measures(study.people, rows, bearing), strict=True):
        names[int(row)] = name
    return tuple(names)


def _warnings(
    study: AccommodationStudy, asked: tuple[Asked, ...], bodies: PopulationBodies, met: Bools
) -> tuple[str, ...]:
    """Collect what a reader of the shares must know, what bears on all of them first."""
    return (
        *piece_warnings([(study.body.name, study.body)]),
        *_told(bodies),
        *_hopeless(asked, met),
        *buried_controls(study.environment),
    )


def _told(bodies: PopulationBodies) -> list[str]:
    told = [note for note in bodies.notes if note]
    if not told:
        return []
    return [
        f"{len(told)} of {len(bodies)} people could not be given all their measures exactly; they have them "
        f"nearly (the first because {told[0]})"
    ]


def _around(
    study: AccommodationStudy, bodies: PopulationBodies, found: Chunk, hardest: tuple[int, ...]
) -> list[str]:
    """Report open parts that enclose the hardest person, or the first, in the seat."""
    if not study.environment.undecided:
        return []
    row = hardest[0] if hardest else 0
    body = bodies[row]
    sitters = in_position(study, body, row, found)
    environment = moved(
        study.environment, study.environment.seat(study.seat).moves, sitters.seat.shift[0]
    )
    return list(enclosure_warnings(f"person {row + 1}", place(body, sitters.held), environment))


def _hopeless(asked: tuple[Asked, ...], met: Bools) -> list[str]:
    """Requirements that nobody meets, and pairs that nobody meets together though some meet
    each."""
    single: Bools = np.asarray(met.any(axis=0))
    told = [
        f"nobody meets {asked[r].requirement.name!r}: check where it is and what is asked for"
        for r in np.flatnonzero(~single)
    ]
    count = met.sum(axis=0)
    both = met.T.astype(np.float64) @ met.astype(np.float64)
    expected = np.outer(count, count) / len(met)
    for a, b in np.argwhere(np.triu((both == 0) & (expected >= EXPECTED), 1)):
        told.append(
            f"nobody meets both {asked[a].requirement.name!r} and {asked[b].requirement.name!r} in the "
            "position of the seat that suits best: they may contradict each other"
        )
    return told
