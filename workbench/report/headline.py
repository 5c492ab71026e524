"""The whole result in a sentence or two."""

from __future__ import annotations

from workbench.model.result import PosturesFound, Result
from workbench.report.motions.words import motions_headline
from workbench.report.population.words import population_headline
from workbench.study.kept_reaches import kept_of_people, kept_words

__all__ = ["headline"]

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
    return said + _short(found)


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
