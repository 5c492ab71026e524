"""The people of an open study followed while something is dragged.

Each stays where the person was settled, and only what the change touches is asked again. So somebody
who is found to miss something may still fit elsewhere; settling decides it.

While parts are dragged, reaches take no notice of them as obstacles: the index of the others serves
every step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Control, Environment
from workbench.model.poses import Poses
from workbench.model.workplace import Workplace
from workbench.posture.reaching.limbs import HANDS
from workbench.study.accommodation.checkpoints import PopulationQuestion
from workbench.study.bench.crowd import (
    BenchPopulation,
    HandsPlaced,
    Moved,
    Posed,
    Settled,
    held_controls,
    in_columns,
    moved_since,
    same_columns,
)
from workbench.study.bench.state import Arrangement, OpenStudy, arranged_environment
from workbench.study.checks.margins import Asked
from workbench.study.checks.reach import ReachMemory, margins_again
from workbench.study.checks.table import (
    AFTER_SEATING,
    CHECKS,
    IN_POSTURE,
    margins_here,
    margins_of,
    needs_hands,
)
from workbench.study.positions import comfortable_situations, in_positions
from workbench.study.settings import at_setting, renewed
from workbench.study.situation import (
    Situation,
    hands_moved,
    with_hands,
    with_hands_again,
    with_some_hands,
    without_parts,
)

__all__ = ["Followed", "followed", "poses_there"]


@dataclass(frozen=True, eq=False)
class Followed:
    """What people have to spare where they are while the study is changed.

    Parameters
    ----------
    margin
        (B, R) [m], NaN where a requirement does not apply, or is not known.
    known
        (B, R) what is known. Of reaches in another position of the seat only that is known at once
        which needs no search.
    """

    margin: Floats
    known: Bools


def followed(
    opened: OpenStudy,
    crowd: BenchPopulation,
    known: Settled,
    question: PopulationQuestion,
    arrangement: Arrangement,
    *,
    search: bool = True,
) -> Followed:
    """Measure what people have to spare in another state, each where the person was settled.

    Parameters
    ----------
    known
        The people in a state before.
    question
        What is asked in the other state.
    search
        Whether what is not known at once is searched for.

    Returns
    -------
    Followed
        Of what the change does not touch the margins of before. Where people sit otherwise, a
        control that is reached has 0 to spare: how much more is not asked for.
    """
    person = arrangement.people[crowd.row]
    moved = moved_since(known, arrangement)
    feet = {
        name
        for case in question.place.cases
        if case.aims is not None
        for limb, name in case.aims.controls.items()
        if limb.endswith("foot")
    }
    adjusted = known.arrangement.settings != arrangement.settings
    parts = _adjusted(opened)
    adjusted |= any(question.place.environment.parts[k] in parts for k in moved.parts)
    zones = known.arrangement.zones != arrangement.zones
    sits = known.arrangement.people[crowd.row] is person
    if not sits or zones or feet & moved.controls or adjusted:
        return _seated_anew(opened, crowd, known, question, arrangement, search=search)
    same = same_columns(known.question.asked, question.asked)
    margin = in_columns(known.margin, same)
    everything = np.ones(margin.shape, dtype=np.bool_)
    new = set(np.flatnonzero(same < 0).tolist())
    columns = sorted(new.union(_touched(question, known, moved)))
    if not columns:
        return Followed(margin, everything)
    for rows, situations in known.places:
        at = at_setting(question.place, known.fitted.setting[rows[0]])
        asked = renewed(at, [question.asked[r] for r in columns])
        found = _margins_there(known, situations, at, asked, moved)
        margin[np.ix_(rows, np.array(columns))] = found
    return Followed(margin, everything)


def _adjusted(opened: OpenStudy) -> set[str]:
    """The parts that adjustments move: with these the settings are others."""
    return {name for one in opened.study.environment.adjustments for name in one.parts}


def _touched(question: PopulationQuestion, known: Settled, moved: Moved) -> list[int]:
    """The requirements that a move bears on: reaches and the sight of the controls, what is about the
    parts, what is seen beyond them, and what depends on a hand that holds a control."""
    names = {question.place.environment.parts[k] for k in moved.parts}
    _, situations = known.places[0]
    found = []
    for r, one in enumerate(question.asked):
        if one.control is not None:
            touched = one.control.name in moved.controls
        else:
            touched = bool(names & set(one.criterion.parts))
            if one.requirement.of_sight:
                touched |= bool(names) or one.requirement.target in moved.controls
            there = situations[one.case]
            touched |= needs_hands(there, one, hands_moved(there, moved.controls))
        if touched:
            found.append(r)
    return found


def _margins_there(
    known: Settled,
    situations: Sequence[Situation],
    at: Workplace,
    asked: Sequence[Asked],
    moved: Moved,
) -> Floats:
    """(B, Q) [m] what people have to spare in some requirements, in a workplace `at` where parts and
    controls have moved."""
    margin = np.full((len(situations[0]), len(asked)), np.nan)
    for number, situation in enumerate(situations):
        mine = [q for q, one in enumerate(asked) if one.case == number]
        reaches = [q for q in mine if asked[q].control is not None]
        held = [q for q in mine if needs_hands(situation, asked[q])]
        rest = [q for q in mine if q not in reaches and q not in held]
        reaching = _without_moved(situation, moved)
        sight = any(asked[q].requirement.of_sight for q in mine)
        there = replace(situation, place=at) if moved.parts or sight else situation
        for some, people in ((reaches, reaching), (rest, there)):
            if some:
                every = [people] * len(situations)
                margin[:, some] = margins_of(every, [asked[q] for q in some]).margin
        if held:
            hands = _known_hands(known, situation, at, moved)
            posed = replace(hands, place=there.place)
            margin[:, held] = margins_here(posed, [asked[q] for q in held]).margin
    return margin


def _without_moved(situation: Situation, moved: Moved) -> Situation:
    """A situation without the parts that have moved, as obstacles."""
    if not moved.parts:
        return situation
    old = situation.place
    names = tuple(old.environment.parts[k] for k in sorted(moved.parts))
    return replace(situation, place=replace(old, environment=without_parts(old.environment, names)))


def _known_hands(known: Settled, situation: Situation, at: Workplace, moved: Moved) -> Situation:
    """The people of a situation with their hands on their controls; of a drag they are found once
    for each place of the controls that are held."""
    key = situation, moved.parts, _held_points(at)
    hands = known.trail.hands
    if hands is None or hands.about != key:
        hands = HandsPlaced(key, _hands_there(situation, at, moved))
        known.trail.hands = hands
    return hands.situation


def _hands_there(situation: Situation, at: Workplace, moved: Moved) -> Situation:
    """The people of a situation with their hands on their controls while parts and controls are
    dragged; the parts that are dragged are no obstacles."""
    reaching = _without_moved(situation, moved)
    if not moved.controls & held_controls(at):
        return with_hands(reaching)
    there = _with_controls(reaching, at)
    if moved.parts:
        return with_hands(there)
    return with_hands_again(there, hands_moved(situation, moved.controls), with_hands(situation))


def _held_points(place: Workplace) -> tuple[object, ...]:
    """Where the controls are that hands and feet hold."""
    held = held_controls(place)
    return tuple(control.at for control in place.environment.controls if control.name in held)


def _with_controls(situation: Situation, at: Workplace) -> Situation:
    """A situation with the controls where another workplace has them."""
    environment = _controlled(situation.environment, at.environment.controls)
    return replace(situation, place=replace(situation.place, environment=environment))


@lru_cache(maxsize=8)
def _controlled(environment: Environment, controls: tuple[Control, ...]) -> Environment:
    """The surroundings with other controls, once for each, so that they are indexed once."""
    return replace(environment, controls=controls)


def _seated_anew(
    opened: OpenStudy,
    crowd: BenchPopulation,
    known: Settled,
    question: PopulationQuestion,
    arrangement: Arrangement,
    *,
    search: bool,
) -> Followed:
    """What people have to spare where they sit otherwise: in the seat where it is held, else in the
    positions that they were in."""
    trail = known.trail
    posed = trail.posed
    if posed is None or posed.content != arrangement.content:
        posed = _posed(opened, crowd, known, question, arrangement, brief=not search)
        trail.posed = posed
        before = None
    else:
        before = posed.margin
    if search and posed.waiting.any():
        _ask_those_waiting(posed, question)
    reaches = np.array([one.control is not None for one in question.asked])
    columns = np.flatnonzero(reaches)
    margin = posed.margin
    some = None if before is None else before[:, columns]
    found = _reaches_again(posed.situations, question, columns, trail.reaches, some, search=search)
    margin[:, columns] = found
    return Followed(margin.copy(), ~(posed.waiting | (reaches & np.isnan(margin))))


def _ask_those_waiting(posed: Posed, question: PopulationQuestion) -> None:
    """Search for the hands of those whose margins wait for that, and ask these."""
    for number, situation in enumerate(posed.situations):
        mine = np.array([one.case == number for one in question.asked])
        rows = np.flatnonzero((posed.waiting & mine).any(axis=1))
        if not len(rows):
            continue
        columns = np.flatnonzero(posed.waiting[rows].any(axis=0) & mine)
        asked = [question.asked[r] for r in columns.tolist()]
        there = _with_needed_hands(situation.rows(rows), asked)
        every = [there] * len(posed.situations)
        posed.margin[np.ix_(rows, columns)] = margins_of(every, asked).margin
    posed.waiting[:] = False


def _posed(
    opened: OpenStudy,
    crowd: BenchPopulation,
    known: Settled,
    question: PopulationQuestion,
    arrangement: Arrangement,
    *,
    brief: bool,
) -> Posed:
    """People where they sit otherwise, with all margins but those of reaches, and where it is to be
    brief of those that wait for a hand."""
    place = question.place
    who = known.who
    assert who is not None
    situations = comfortable_situations(place, who)
    new = arrangement.people[crowd.row]
    if new.free and known.arrangement.people[crowd.row].free:
        situations = in_positions(place, who, known.fitted.tried.seat, situations)
    plain = arranged_environment(opened, arrangement)
    if place.seat is not None and len(arrangement.people) == 1:
        # but for the travel of the seat the same, and indexed already
        around = [replace(one, place=replace(place, environment=plain)) for one in situations]
    else:
        around = situations
    cost = np.array([CHECKS[one.requirement.check].cost for one in question.asked])
    around = [_with_needed_hands(one, question.asked, brief=brief) for one in around]
    margin = np.full((len(who), len(question.asked)), np.nan)
    for some, there in ((AFTER_SEATING, situations), (IN_POSTURE, around)):
        columns = np.flatnonzero(cost == some)
        if len(columns):
            asked = [question.asked[r] for r in columns.tolist()]
            margin[:, columns] = margins_of(there, asked).margin
    waiting = np.zeros(margin.shape, dtype=np.bool_)
    for r, one in enumerate(question.asked):
        unsure = with_hands(around[one.case]).unsure
        if unsure is not None and needs_hands(around[one.case], one):
            waiting[:, r] = unsure
    margin[waiting] = np.nan
    return Posed(arrangement.content, around, margin, waiting)


def _with_needed_hands(
    situation: Situation, asked: Sequence[Asked], *, brief: bool = False
) -> Situation:
    """The same, with no hand brought to its control that nothing depends on; `brief` as of
    `reach`."""
    mine = [one for one in asked if one.case == situation.case]
    needed = [hand for hand in HANDS if any(needs_hands(situation, one, [hand]) for one in mine)]
    return with_some_hands(situation, needed, brief=brief)


def _reaches_again(
    situations: Sequence[Situation],
    question: PopulationQuestion,
    columns: Ints,
    memory: ReachMemory,
    before: Floats | None = None,
    *,
    search: bool,
) -> Floats:
    """(B, Q) [m] what people have to spare in some reaches; arguments as of `margins_again`."""
    found = np.full((len(situations[0]), len(columns)), np.nan)
    for number, situation in enumerate(situations):
        mine = [q for q, r in enumerate(columns) if question.asked[r].case == number]
        if mine:
            asked = [question.asked[columns[q]] for q in mine]
            some = None if before is None else before[:, mine]
            found[:, mine] = margins_again(situation, asked, memory, some, search=search)
    return found


def poses_there(known: Settled, arrangement: Arrangement, case: int) -> Poses:
    """(B,) the postures of people in a state, with the hands at rest: where they were followed to,
    else in their comfortable positions."""
    posed = known.trail.posed
    if posed is not None and posed.content == arrangement.content:
        return posed.situations[case].taken.poses
    return known.comfortable[case]
