"""A whole population through one workplace, who is left out, by what and
by how much."""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.body.pieces import piece_warnings
from workbench.body.scaling.scale import morph_to
from workbench.errors import InputError
from workbench.model.accommodation import MET, GroupShare, certainty_of, met_of
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.criterion import NO_REASON, Reason
from workbench.model.population import Population
from workbench.model.result import GripFinding, Illustration, PopulationFound
from workbench.model.study import Role, Study
from workbench.model.units import plain
from workbench.model.workplace import Workplace
from workbench.study.accommodation.checkpoints import (
    Chunk,
    PopulationQuestion,
    joined_chunks,
    result_chunks,
)
from workbench.study.accommodation.gains import gains_of
from workbench.study.accommodation.grips import grip_findings, grip_words
from workbench.study.accommodation.limiting_dimensions import (
    limiting_measures,
    odd_people,
    relevant_measures,
)
from workbench.study.accommodation.overlaps import Overlaps, overlap_warnings, summed_overlaps
from workbench.study.accommodation.population_bodies import (
    PopulationBodies,
    fit_population,
)
from workbench.study.accommodation.proposals import kept_by_ends
from workbench.study.accommodation.reach_maps import people_maps
from workbench.study.accommodation.shares import (
    group_shares,
    missed_only,
    share_single,
    share_without,
    spread_of,
)
from workbench.study.accommodation.worst_cases import (
    Places,
    beheld_people,
    found_situations,
    hardest_rows,
    shown_people,
)
from workbench.study.checks.margins import Asked
from workbench.study.checks.score import assumed_words
from workbench.study.checks.sight import shortfall_words
from workbench.study.checks.sight_rules import source_of
from workbench.study.kept_reaches import kept_by_parts, kept_words
from workbench.study.passes import ASKING, BODIES, CHANGE, LAST, MAP, USUAL_CHANGES, Passes
from workbench.study.people import Present, person_found, present_people
from workbench.study.positions import SAME_SETTING
from workbench.study.requirements import asked_of, sets_of
from workbench.study.settings import nominal_setting
from workbench.study.warnings import (
    controls_inside_solids,
    enclosure_warnings,
    lost_seats,
    seat_warnings,
)
from workbench.study.workplaces import population_of, workplace_of

__all__ = [
    "accommodation",
    "body_of_person",
    "person_again",
    "person_shown",
    "population_question",
]

Say = Callable[[str], None]
EXPECTED = 10.0
"""People who should meet two requirements, if these had nothing to do with each other, from which
on it says something that nobody does."""


def accommodation(
    study: Study,
    beside: Present | None = None,
    *,
    keep: Path | None = None,
    say: Say = lambda text: None,
    executor: Executor | None = None,
) -> PopulationFound:
    """Let everybody of a population take the role, and ask everything of everybody.

    Parameters
    ----------
    study
        With a population in one of its roles.
    beside
        Those who are there too.
    keep
        A folder in which chunks of people are kept until all is done, so that a run that is cut off
        goes on where it was.
    say
        Called with words on how far it is.
    executor
        Does the work: processes of this machine if None. The numbers are the same for all.

    Raises
    ------
    InputError
        Where a chunk cannot be written, or somebody cannot be given a body.
    """
    question = population_question(study, beside)
    place = question.place
    asked = question.asked
    people = question.people
    role = _crowd(study)[1]
    body = morph_to(role.body, role.detail)
    sits = role.seat is not None
    changes = [CHANGE] * (len(study.changes) or USUAL_CHANGES)
    passes = Passes(say, [BODIES, ASKING, *changes, *[MAP] * len(study.reach_maps), LAST])
    fitting = passes.begin(BODIES, "fitting bodies")
    bodies = fit_population(
        body, people, role.clothes, sits=sits, executor=executor, progress=fitting
    )
    asking = passes.begin(ASKING, "asking everybody")
    chunks = result_chunks(question, bodies, keep=keep, tell=asking, executor=executor)
    found = joined_chunks(chunks)
    met = met_of(found.margin)
    checks = [one.requirement.check for one in asked]
    hardest = hardest_rows(found.margin, people.weight, checks=checks)
    gains = gains_of(
        question, study.changes, bodies, found, keep=keep, passes=passes, executor=executor
    )
    maps = tuple(people_maps(question, study.reach_maps, bodies, passes=passes, executor=executor))
    grips = tuple(grip_findings(question, bodies, found))
    overlaps = summed_overlaps(
        Overlaps(found.overlap, found.depth), body, place.environment, people.weight
    )
    return PopulationFound(
        study=study,
        place=place,
        people=people,
        body=body,
        requirements=tuple(one.requirement for one in asked),
        margin=found.margin,
        low=found.low,
        high=found.high,
        reason=found.reason,
        reasons=found.words,
        seat=found.seat,
        comfortable=found.comfortable,
        window=found.window,
        sets=found.sets,
        setting=found.setting,
        limiting=_limiting(question, body, found),
        shares=_shares(study, people, found),
        single=share_single(met, people.weight),
        without=share_without(found.sets[:, : len(asked)], people.weight),
        only=missed_only(met, people.weight),
        spread=spread_of(found.margin, people.weight),
        hardest=tuple(hardest),
        tried=gains.tried,
        refused=gains.refused,
        ends=kept_by_ends(question, found),
        maps=maps,
        grips=grips,
        warnings=(
            *_warnings(question, body, bodies, found, grips),
            *_around(role, question, bodies, found, tuple(hardest)),
            *overlap_warnings(overlaps, len(people), people.labels),
            *study.warnings,
        ),
        shown=tuple(
            shown_people(question, bodies, found, list(hardest), at=list(hardest.values()))
        ),
        beheld=tuple(beheld_people(question, bodies, found)),
        overlaps=overlaps,
        overlapping=found.overlapping,
        elsewhere=found.elsewhere,
    )


def population_question(study: Study, beside: Present | None = None) -> PopulationQuestion:
    """What is asked of everybody who takes the role of a population.

    Raises
    ------
    InputError
        Where no criterion asks for anything.
    """
    row, role = _crowd(study)
    environment = study.environment if beside is None else beside.environment
    place = workplace_of(study, row, environment, () if beside is None else beside.beside())
    asked = asked_of(place)
    if not asked:
        raise InputError(f"{study.name}: no criterion asks for anything")
    return PopulationQuestion(
        place, asked, sets_of(asked, study.share_criteria), population_of(role)
    )


def body_of_person(study: Study, row: int) -> Body:
    """Return the body of one person of a study's population, dressed, and seated where all are.

    Raises
    ------
    InputError
        Where there is no such person, or no body for the person's measures.
    """
    return _bodies_of_person(study, row)[0]


def _bodies_of_person(study: Study, row: int) -> PopulationBodies:
    """That body alone; arguments and errors as of `body_of_person`."""
    role = _crowd(study)[1]
    people = population_of(role)
    if not 0 <= row < len(people):
        raise InputError(f"{study.name}: no person {row + 1} of {len(people)}")
    body = morph_to(role.body, role.detail)
    sits = role.seat is not None
    return fit_population(body, people.rows(np.array([row])), role.clothes, sits=sits)


def person_shown(found: PopulationFound, row: int, requirement: str) -> Illustration | None:
    """Return one person as found at a requirement, to be drawn.

    Parameters
    ----------
    found
        What was found of the population.
    row
        Of the person.
    requirement
        The name of one that applies to the person.

    Returns
    -------
    Shown or None
        None where it does not apply.
    """
    names = [each.name for each in found.requirements]
    column = names.index(requirement) if requirement in names else -1
    if column < 0 or np.isnan(found.margin[row, column]):
        return None
    places = Places(found.seat[[row]], found.comfortable[[row]], found.setting[[row]])
    return person_again(found.study, row, places, column)


def person_again(study: Study, row: int, places: Places, requirement: int) -> Illustration:
    """Return one person of a study's population as found at a requirement, from where that was.

    Parameters
    ----------
    study
        With a population in one of its roles; others take their places anew.
    row
        Of the person.
    places
        Where the person (B = 1) was found; a setting that is nominal but for rounding is.
    requirement
        Its number.

    Raises
    ------
    InputError
        Where there is no such person, or no body for the person's measures.
    """
    question = population_question(study, present_people(study) if len(study.roles) > 1 else None)
    bodies = _bodies_of_person(study, row)
    nominal = nominal_setting(question.place)
    rounded = np.isclose(places.setting, nominal, rtol=0.0, atol=SAME_SETTING)
    there = replace(places, setting=np.where(rounded, nominal, places.setting))
    question = replace(question, people=question.people.rows(np.array([row])))
    return next(shown_people(question, bodies, there, [0], at=[requirement], first=row))


def _crowd(study: Study) -> tuple[int, Role]:
    """The role that a population takes, and its index."""
    return next((k, role) for k, role in enumerate(study.roles) if role.population is not None)


def _shares(study: Study, people: Population, found: Chunk) -> tuple[GroupShare, ...]:
    asked = study.shares
    return tuple(
        group_shares(
            np.asarray(met_of(found.margin).all(axis=1)),
            people,
            asked.mixes,
            certainty=certainty_of(found.margin, found.low, found.high, found.elsewhere),
            overlapping=found.overlapping,
            confidence=asked.confidence,
            interval=asked.interval,
        )
    )


def _limiting(question: PopulationQuestion, body: Body, found: Chunk) -> tuple[str, ...]:
    """For everybody left out the measure that is oddest of those that bear on what is missed by
    most."""
    worst = np.nan_to_num(found.margin, nan=np.inf)
    rows = np.flatnonzero(worst.min(axis=1) < -MET)
    at = worst[rows].argmin(axis=1)
    words = [
        found.words[int(found.reason[row, r])] if found.reason[row, r] >= 0 else NO_REASON
        for row, r in zip(rows, at, strict=True)
    ]
    sits = question.place.seat is not None
    bearing = [
        relevant_measures(question.asked[int(r)], why, body, sits=sits)
        for r, why in zip(at, words, strict=True)
    ]
    people = question.people
    names = [""] * len(people)
    for row, name in zip(rows, limiting_measures(people, rows, bearing), strict=True):
        names[int(row)] = name
    return tuple(names)


def _warnings(
    question: PopulationQuestion,
    body: Body,
    bodies: PopulationBodies,
    found: Chunk,
    grips: Sequence[GripFinding],
) -> tuple[str, ...]:
    """Collect what a reader of the shares must know, what bears on all of them first."""
    kept = kept_by_parts(
        question.place.environment,
        [one.requirement for one in question.asked],
        margin=found.margin,
        reason=found.reason,
        reasons=found.words,
        weight=question.people.weight,
    )
    flat = {one.requirement for one in grips}
    kept = [one for one in kept if one.requirement not in flat]
    told = {one.requirement for one in kept} | flat
    where = "place" if question.place.seat is None else "position of the seat"

    def limits(person: int, r: int) -> Reason:
        one = question.asked[r]
        if found.reason[person, r] < 0 or not (one.control or one.requirement.of_sight):
            return NO_REASON
        return found.words[int(found.reason[person, r])]

    return (
        *grip_words(grips),
        *kept_words(kept),
        *rules_words(question.place, question.asked),
        *piece_warnings([(body.name, body)]),
        *odd_people(question.people),
        *_inexact(bodies),
        *_unmet_requirements(question.asked, found.margin, told, reasons=limits, where=where),
        *controls_inside_solids(question.place.environment),
    )


def rules_words(place: Workplace, asked: Sequence[Asked]) -> list[str]:
    """Say which criteria are judged by values of rule sets that are not sure, and by which, and what
    scores of postures assume."""
    judged: dict[str, list[str]] = {}
    for criterion in dict.fromkeys(one.criterion for one in asked):
        rules = criterion.rule_set
        if rules is None:
            continue
        if criterion.check == "force":
            told = rules.all_told
        elif criterion.check == "score":
            told = rules.all_told + assumed_words(criterion, place)
        else:
            mirrors = [place.environment.mirror(name).field for name in criterion.mirrors]
            told = source_of(criterion, *(f"field_{field}" for field in dict.fromkeys(mirrors)))
        if told != rules.description:
            judged.setdefault(told, []).append(repr(criterion.name))
    return [
        f"criterion {names[0]} is judged by {words}"
        if len(names) == 1
        else f"criteria {', '.join(names)} are judged by {words}"
        for words, names in judged.items()
    ]


def _inexact(bodies: PopulationBodies) -> list[str]:
    notes = [note for note in bodies.notes if note]
    if not notes:
        return []
    return [
        f"{len(notes)} of {len(bodies)} people could not be given all their measures exactly; "
        f"they have them nearly (the first because {notes[0]})"
    ]


def _around(
    role: Role,
    question: PopulationQuestion,
    bodies: PopulationBodies,
    found: Chunk,
    hardest: tuple[int, ...],
) -> list[str]:
    """Report open parts that enclose the hardest person, or the first, where this one is, and that
    the planes of the seat are not where its parts are."""
    if not question.place.environment.undecided and role.seat is None:
        return []
    row = hardest[0] if hardest else 0
    _, situations = next(found_situations(question, bodies, np.array([row]), found))
    environment = situations[0].environment_moved
    cases = tuple(situation.work.name for situation in situations)
    place = replace(situations[0].place, environment=environment)
    there = [replace(situation, place=place) for situation in situations]
    one = person_found(replace(role, name=question.people.called(row)), there)
    lost = lost_seats(question.place.environment, [role])
    return [
        *enclosure_warnings(one.name, situations[0].placed, environment),
        *(() if lost else seat_warnings(environment, cases, one)),
    ]


def _unmet_requirements(
    asked: tuple[Asked, ...],
    margin: Floats,
    told: Container[str] = (),
    *,
    reasons: Callable[[int, int], Reason] = lambda person, r: NO_REASON,
    where: str = "position of the seat",
) -> list[str]:
    """Requirements that nobody meets, with what is missing to whom it is least, and pairs that nobody
    meets together though some meet each.

    margin (P, R); told: those that nobody meets and that are told already; reasons: what limits a
    person in a requirement; where: what people are in that suits best.
    """
    met = met_of(margin)
    words = []
    for r in np.flatnonzero(~met.any(axis=0)).tolist():
        person = int(np.argmax(np.nan_to_num(margin[:, r], nan=-np.inf)))
        size = -float(margin[person, r])
        limit = reasons(person, r)
        much = shortfall_words(asked[r].requirement, asked[r].criterion, size, limit)
        if asked[r].requirement.name not in told:
            lack = f"it is missed by at least {much}{limit.clause}"
            name = plain(asked[r].requirement.name)
            words.append(f"nobody meets {name!r}: {lack}: check where it is and what is asked for")
    count = met.sum(axis=0)
    both = met.T.astype(np.float64) @ met.astype(np.float64)
    expected = np.outer(count, count) / len(met)
    for pair in np.argwhere(np.triu((both == 0) & (expected >= EXPECTED), 1)):
        one, other = (plain(asked[r].requirement.name) for r in pair)
        words.append(
            f"nobody meets both {one!r} and {other!r} in the "
            f"{where} found for them: the two may contradict each other"
        )
    return words
