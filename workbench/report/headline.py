"""The whole result in a sentence or two."""

from __future__ import annotations

import math

import numpy as np

from workbench.contact.collide import allowed_depth
from workbench.model.arrays import Bools
from workbench.model.environment import Environment
from workbench.model.result import PersonFound, PosturesFound, Result
from workbench.report.motions.words import motions_headline
from workbench.report.population.words import population_headline
from workbench.report.words import millimetres
from workbench.study.kept_reaches import kept_of_people, kept_words
from workbench.study.unasked import overlap_words, unasked_overlaps

__all__ = ["headline"]

_TOUCHING = 5e-5
"""[m] A smaller distance reads as 0.0 mm: there the body touches, or rests."""
_MOST_SHORT = 3
"""People in a case whose shortfalls are named."""


def headline(result: Result) -> str:
    """The whole result in a sentence for each section."""
    words = [_postures_headline(found) for found in result.postures]
    if result.population is not None:
        words.insert(0, population_headline(result.population))
    if result.motions:
        words.append(motions_headline(result.motions))
    count = len(result.warnings)
    if count and result.verdicts:
        words.append(f"{count} warning{'s' if count > 1 else ''}.")
    return " ".join(words)


def _postures_headline(found: PosturesFound) -> str:
    """Which controls are kept by what may be their own pieces, who was looked at, and how many
    criteria failed."""
    kept = kept_of_people(found.environment, found.study.criteria, found.reaches)
    first = "".join(f"{words}. " for words in kept_words(kept))
    people = len(found.people)
    cases = len(found.cases)
    who = f"{people} {'people' if people > 1 else 'person'}"
    if found.study.crowd is not None:  # those beside a population are not its people
        who = f"{found.who[:1].upper()}{found.who[1:]}"
    scope = f"{who} in {cases} case{'s' if cases > 1 else ''}"
    if found.row:
        scope = f"{found.row[:1].upper()}{found.row[1:]}, {scope}"
    said = f"{first[:1].upper()}{first[1:]}{scope}: {_failed(found)}."
    return said + _short(found) + _tightest(found) + _deepest(found)


def _short(found: PosturesFound) -> str:
    """ " Postures fall short of the study: pilot, flying: the eyes stay 56 mm below left design
    eye.", "" where they do not."""
    if not found.short:
        return ""
    by_person: dict[str, list[str]] = {}
    for line in found.short:
        who, _, what = line.partition(": ")
        by_person.setdefault(who, []).append(what)
    shown = [f"{who}: {', and '.join(what)}" for who, what in by_person.items()]
    more = len(shown) - _MOST_SHORT
    said = "; ".join(shown[:_MOST_SHORT]).replace("_", " ")
    return f" Postures fall short of the study: {said}{f'; {more} more' if more > 0 else ''}."


def _failed(found: PosturesFound) -> str:
    """ "1 of 3 criteria failed: clear of the wall", "both criteria hold"."""
    count = len(found.verdicts)
    criteria = f"{count} criteri{'a' if count > 1 else 'on'}"
    failed = [verdict.criterion.name for verdict in found.verdicts if not verdict.passed]
    if failed:
        return f"{len(failed)} of {criteria} failed: {', '.join(failed)}"
    few = {1: "the criterion holds", 2: "both criteria hold"}
    return few.get(count, f"all {criteria} hold")


def _tightest(found: PosturesFound) -> str:
    """ " The tightest gap is 12.4 mm: head from canopy (cruise, pilot).", "" where there is none.

    A gap is a distance of a segment from a part that it may not touch. Hands and what they use,
    feet and what they use, are not apart by a gap, nor is what touches.
    """
    tightest: tuple[float, str] | None = None
    for person in found.people:
        distance = np.where(_has_gap(person, found.environment), person.clearance.distance, np.inf)
        distance = np.where(distance > _TOUCHING, distance, np.inf)
        case, segment, part = np.unravel_index(np.argmin(distance), distance.shape)
        least = float(distance[case, segment, part])
        if math.isfinite(least) and (tightest is None or least < tightest[0]):
            name = found.environment.parts[part].replace("_", " ")
            what = f"{person.body.segment_names[segment]} from {name}"
            tightest = least, f"{what} ({found.cases[case]}, {person.name})"
    if tightest is None:
        return ""
    return f" The tightest gap is {millimetres(tightest[0])}: {tightest[1]}."


def _has_gap(person: PersonFound, environment: Environment) -> Bools:
    """(N, K) between which segments and parts a distance is a gap."""
    body = person.body
    gap = allowed_depth(body, environment) <= 0
    for control in environment.controls:
        used = np.isin(environment.parts, control.own_parts)
        ends = np.isin(body.segments, ("LF", "RF") if control.for_feet else ("LHN", "RHN"))
        gap &= ~(ends[:, None] & used)
    return np.asarray(gap, dtype=np.bool_)


def _deepest(found: PosturesFound) -> str:
    """ " The deepest overlap that no criterion asks about: right upper leg is 51.2 mm into
    left seat pan (20.0 mm allowed) (cruise, pilot).", "" where there is none."""
    overlaps = unasked_overlaps(found.study.criteria, found.cases, found.people, found.between)
    if not overlaps:
        return ""
    deepest = max(overlaps, key=lambda overlap: overlap.excess)
    words = f"{overlap_words(deepest)} ({deepest.case}, {deepest.person})"
    return f" The deepest overlap that no criterion asks about: {words}."
