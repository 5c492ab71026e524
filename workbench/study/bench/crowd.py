"""The population of an open study: who fits, reaches and clears while the study is changed.

People are settled as a run of the study does it: each in the position of the seat, and in the
setting, that suits best. That takes seconds. While something is dragged they are followed: each
stays where the person was settled, and only what the change touches is asked again. So somebody who
is found to miss something may still fit elsewhere; settling decides it.

While parts are dragged, reaches take no notice of them as obstacles: the index of the others serves
every step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from workbench.body.scaling.scale import morph_to
from workbench.model.accommodation import met_of
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Control, Environment
from workbench.model.moves import control_moves, part_moves
from workbench.model.population import Population
from workbench.model.poses import Poses
from workbench.model.workplace import Workplace
from workbench.posture.reaching.limbs import HANDS
from workbench.study.accommodation.accommodation import population_question
from workbench.study.accommodation.chunks import Question
from workbench.study.accommodation.population_bodies import PopulationBodies, fit_population
from workbench.study.bench.state import (
    Arrangement,
    OpenStudy,
    arranged_environment,
    arranged_study,
)
from workbench.study.checks.margins import Asked
from workbench.study.checks.reach import ReachMemory, margins_again
from workbench.study.checks.table import (
    AFTER_SEATING,
    CHECKS,
    IN_POSTURE,
    margins_of,
    needs_hands,
)
from workbench.study.people import present_people
from workbench.study.positions import (
    Before,
    Fitted,
    comfortable_situations,
    fitted_positions,
    found_places,
    in_positions,
)
from workbench.study.settings import at_setting, nominal_setting, renewed
from workbench.study.situation import (
    Occupants,
    Situation,
    hands_moved,
    with_hands,
    with_hands_again,
    with_some_hands,
    without_parts,
)
from workbench.study.workplaces import population_of

__all__ = [
    "AT_HAND",
    "Crowd",
    "Followed",
    "Settled",
    "crowd_question",
    "followed",
    "in_columns",
    "met_all",
    "open_crowd",
    "poses_there",
    "remember",
    "same_columns",
    "settled",
]

AT_HAND = 256
"""People who are followed while something is dragged."""
Places = tuple[tuple[Ints, list[Situation]], ...]


@dataclass(frozen=True, eq=False)
class Crowd:
    """The people of an open study.

    Parameters
    ----------
    row
        The index of their role.
    people, bodies
        All of them, and their bodies.
    order
        (P,) the rows of all people: those at hand first, spread evenly over them.
    """

    row: int
    people: Population
    bodies: PopulationBodies
    order: Ints

    @property
    def at_hand(self) -> int:
        """How many are followed."""
        return min(len(self.order), AT_HAND)

    def occupants(self, rows: Ints) -> Occupants:
        """Some people with their bodies."""
        return Occupants(self.bodies[rows], self.people, rows)


@dataclass(frozen=True, eq=False)
class Settled:
    """People as a run of a state finds them.

    Parameters
    ----------
    arrangement, question
        The state, and what is asked of everybody in it.
    rows
        (B,) of the people in their population.
    who
        The people; None of those who are not followed.
    comfortable
        (B,) their postures in each case, in the comfortable position and with the hands at rest.
    fitted
        In the positions that suit them best, with their margins there.
    places
        The people in those positions, case by case: by setting, with their indices.
    """

    arrangement: Arrangement
    question: Question
    rows: Ints
    who: Occupants | None
    comfortable: tuple[Poses, ...]
    fitted: Fitted
    places: Places
    hands: dict[object, Situation] = field(default_factory=dict)
    """The people with their hands on their controls, while some parts are no obstacles."""
    memory: ReachMemory = field(default_factory=dict)
    """What all of them reached where they sat last."""
    last: list[_Posed] = field(default_factory=list)
    """Where they sat last while the seat was dragged; empty before."""

    @property
    def margin(self) -> Floats:
        """(B, R) [m]."""
        return self.fitted.tried.margin


@dataclass(frozen=True, eq=False)
class _Posed:
    """People where they sit in a state, and their margins (B, R) [m] there, NaN where a requirement
    does not apply or is not known; waiting (B, R): those that wait for a hand to be searched for."""

    content: tuple[object, ...]
    situations: Sequence[Situation]
    margin: Floats
    waiting: Bools


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


def open_crowd(opened: OpenStudy, say: Callable[[str], None] = lambda text: None) -> Crowd | None:
    """Make the bodies of an open study's population, or read them from the cache.

    Parameters
    ----------
    say
        Called with words on how far that is.

    Returns
    -------
    Crowd or None
        None where no population takes a role.

    Raises
    ------
    InputError
        If there is no body for somebody's measures.
    """
    if opened.crowd is None:
        return None
    row = opened.crowd
    role = opened.study.roles[row]
    people = population_of(replace(role, population=opened.population))
    body = morph_to(role.body, role.detail)
    with ThreadPoolExecutor(1) as pool:  # no forks: other threads of this process are at work
        bodies = fit_population(
            body, people, role.clothes, sits=role.seat is not None, executor=pool, progress=say
        )
    count = len(people)
    first = np.unique(np.linspace(0, count - 1, min(count, AT_HAND)).round().astype(np.int64))
    rest = np.setdiff1d(np.arange(count), first)
    return Crowd(row, people, bodies, np.concatenate([first, rest]))


def crowd_question(opened: OpenStudy, crowd: Crowd, arrangement: Arrangement) -> Question:
    """What a run of a state asks of everybody, without the sets that only a report shows.

    Raises
    ------
    InputError
        Where no criterion asks for anything.
    """
    study = arranged_study(opened, arrangement)
    roles = list(study.roles)
    roles[crowd.row] = replace(roles[crowd.row], population=crowd.people)
    study = replace(study, roles=tuple(roles))
    beside = present_people(study) if len(roles) > 1 else None
    question = population_question(study, beside)
    none = np.zeros((len(question.asked), 0), dtype=np.bool_)
    return replace(question, members=none, bounded=False)


def settled(
    crowd: Crowd,
    question: Question,
    arrangement: Arrangement,
    rows: Ints,
    before: Settled | None = None,
    *,
    proceed: Callable[[], None] = lambda: None,
) -> Settled:
    """Put people where a run puts them, and measure what they have to spare.

    Parameters
    ----------
    rows
        (B,) of the people.
    before
        The same people in another state: of who met everything in the comfortable position, only
        what has changed since is asked. What they reached goes along.
    proceed
        As of `fitted_positions`.
    """
    place = question.place
    who = crowd.occupants(rows)
    situations = comfortable_situations(place, who)
    known = None if before is None else _before(before, question, arrangement)
    fitted = fitted_positions(
        place, question.asked, question.members, who, situations, known, proceed=proceed
    )
    places = found_places(place, who, situations, fitted)
    comfortable = tuple(situation.taken.poses for situation in situations)
    found = Settled(arrangement, question, rows, who, comfortable, fitted, tuple(places))
    return found if before is None else replace(found, memory=before.memory)


def _before(before: Settled, question: Question, arrangement: Arrangement) -> Before | None:
    """How people came out in another state, where only the reaches of some controls can differ."""
    old = before.arrangement
    if old.people != arrangement.people or old.zones != arrangement.zones:
        return None
    if len(arrangement.people) > 1:
        return None
    moved = _moved(before, arrangement)
    if moved.parts or moved.controls & _held(question.place):
        return None
    same = same_columns(before.question.asked, question.asked)
    borne = [
        r
        for r, one in enumerate(question.asked)
        if same[r] < 0 or one.requirement.target in moved.controls
    ]
    fitted = before.fitted
    there = (fitted.tried.seat == fitted.comfortable).all(axis=1)
    there &= (fitted.setting == nominal_setting(before.question.place)).all(axis=1)
    stays = met_of(before.margin).all(axis=1) & there
    return Before(in_columns(before.margin, same), stays, tuple(borne))


def same_columns(old: Sequence[Asked], new: Sequence[Asked]) -> Ints:
    """(R,) the number among some requirements of each of others, -1 of those that are not there."""

    def about(one: Asked) -> tuple[object, ...]:
        control = one.control.name if one.control is not None else ""
        return one.criterion.name, one.requirement.name, control, one.case

    at = {about(one): r for r, one in enumerate(old)}
    found = np.array([at.get(about(one), -1) for one in new], dtype=np.int64)
    for r in np.flatnonzero(found >= 0).tolist():
        limits = [
            (one.criterion.at_least, one.criterion.at_most) for one in (old[found[r]], new[r])
        ]
        if limits[0] != limits[1]:
            found[r] = -1
    return found


def in_columns(values: Floats, columns: Ints) -> Floats:
    """(B, R) the columns of values (B, Q) in another order, NaN for those numbered -1."""
    return np.where(columns >= 0, values[:, columns], np.nan)


@dataclass(frozen=True)
class _Moved:
    """The parts, by index, and the controls that stand elsewhere than in another state."""

    parts: frozenset[int]
    controls: frozenset[str]


def _moved(before: Settled, arrangement: Arrangement) -> _Moved:
    environment = before.question.place.environment
    old = before.arrangement.moves
    parts = part_moves(environment, arrangement.moves) != part_moves(environment, old)
    controls = control_moves(environment, arrangement.moves) != control_moves(environment, old)
    rows = np.flatnonzero(controls.any(axis=1))
    return _Moved(
        frozenset(np.flatnonzero(parts.any(axis=1)).tolist()),
        frozenset(environment.controls[k].name for k in rows),
    )


def _held(place: Workplace) -> frozenset[str]:
    """The controls that hands and feet hold in some case."""
    return frozenset(name for case in place.cases for name in case.held.values())


def followed(
    opened: OpenStudy,
    crowd: Crowd,
    known: Settled,
    question: Question,
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
    moved = _moved(known, arrangement)
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


def _touched(question: Question, known: Settled, moved: _Moved) -> list[int]:
    """The requirements that a move bears on: reaches of the controls, what is about the parts, and
    what depends on a hand that holds a control."""
    names = {question.place.environment.parts[k] for k in moved.parts}
    _, situations = known.places[0]
    found = []
    for r, one in enumerate(question.asked):
        if one.control is not None:
            touched = one.control.name in moved.controls
        else:
            touched = bool(names & set(one.criterion.parts))
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
    moved: _Moved,
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
        there = replace(situation, place=at) if moved.parts else situation
        for some, people in ((reaches, reaching), (rest, there)):
            if some:
                every = [people] * len(situations)
                margin[:, some] = margins_of(every, [asked[q] for q in some]).margin
        if held:
            hands = _known_hands(known, situation, at, moved)
            posed = replace(hands, place=there.place)
            margin[:, held] = _margins_held(posed, [asked[q] for q in held])
    return margin


def _without_moved(situation: Situation, moved: _Moved) -> Situation:
    """A situation without the parts that have moved, as obstacles."""
    if not moved.parts:
        return situation
    old = situation.place
    names = tuple(old.environment.parts[k] for k in sorted(moved.parts))
    return replace(situation, place=replace(old, environment=without_parts(old.environment, names)))


def _margins_held(posed: Situation, asked: Sequence[Asked]) -> Floats:
    """(B, Q) [m] what people have to spare with the hands where they are."""
    margin = np.full((len(posed), len(asked)), np.nan)
    for q, one in enumerate(asked):
        check = CHECKS[one.requirement.check]
        assert check.margins is not None
        margin[:, q] = check.margins(posed, [one]).margin[:, 0]
    return margin


def _known_hands(known: Settled, situation: Situation, at: Workplace, moved: _Moved) -> Situation:
    """The people of a situation with their hands on their controls; of a drag they are found once
    for each place of the controls that are held."""
    key = situation, moved.parts, _held_points(at)
    hands = known.hands.get(key)
    if hands is None:
        hands = _hands_there(situation, at, moved)
        known.hands.clear()
        known.hands[key] = hands
    return hands


def _hands_there(situation: Situation, at: Workplace, moved: _Moved) -> Situation:
    """The people of a situation with their hands on their controls while parts and controls are
    dragged; the parts that are dragged are no obstacles."""
    reaching = _without_moved(situation, moved)
    if not moved.controls & _held(at):
        return with_hands(reaching)
    there = _with_controls(reaching, at)
    if moved.parts:
        return with_hands(there)
    return with_hands_again(there, hands_moved(situation, moved.controls), with_hands(situation))


def _held_points(place: Workplace) -> tuple[object, ...]:
    """Where the controls are that hands and feet hold."""
    held = _held(place)
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
    crowd: Crowd,
    known: Settled,
    question: Question,
    arrangement: Arrangement,
    *,
    search: bool,
) -> Followed:
    """What people have to spare where they sit otherwise: in the seat where it is held, else in the
    positions that they were in."""
    posed = known.last[0] if known.last else None
    if posed is None or posed.content != arrangement.content:
        posed = _posed(opened, crowd, known, question, arrangement, brief=not search)
        known.last[:] = [posed]
        before = None
    else:
        before = posed.margin
    if search and posed.waiting.any():
        _ask_those_waiting(posed, question)
    reaches = np.array([one.control is not None for one in question.asked])
    columns = np.flatnonzero(reaches)
    margin = posed.margin
    some = None if before is None else before[:, columns]
    found = _reaches_again(posed.situations, question, columns, known.memory, some, search=search)
    margin[:, columns] = found
    return Followed(margin.copy(), ~(posed.waiting | (reaches & np.isnan(margin))))


def _ask_those_waiting(posed: _Posed, question: Question) -> None:
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
    crowd: Crowd,
    known: Settled,
    question: Question,
    arrangement: Arrangement,
    *,
    brief: bool,
) -> _Posed:
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
    return _Posed(arrangement.content, around, margin, waiting)


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
    question: Question,
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


def remember(known: Settled) -> None:
    """Find what settled people reach where they sit, so that they can be followed from there once
    their seat is dragged."""
    place = known.question.place
    if known.memory or place.own_seat is None or known.who is None:
        return
    columns = np.array(
        [r for r, one in enumerate(known.question.asked) if one.control is not None], dtype=np.int64
    )
    comfortable = comfortable_situations(place, known.who)
    situations = in_positions(place, known.who, known.fitted.tried.seat, comfortable)
    memory: ReachMemory = {}
    _reaches_again(situations, known.question, columns, memory, search=True)
    known.memory.update(memory)


def poses_there(known: Settled, arrangement: Arrangement, case: int) -> Poses:
    """(B,) the postures of people in a state, with the hands at rest: where they were followed to,
    else in their comfortable positions."""
    if known.last and known.last[0].content == arrangement.content:
        return known.last[0].situations[case].taken.poses
    return known.comfortable[case]


def met_all(margin: Floats, columns: Bools | None = None) -> Bools:
    """(B,) who meets all requirements, or all of some (R,)."""
    some = margin if columns is None else margin[:, columns]
    return np.asarray(met_of(some).all(axis=1), dtype=np.bool_)
