"""Find for each person the seat position in which every requirement is met.

A person fits a workplace if some position within the travel of the seat meets all requirements at
once. The comfortable position comes first. For people who miss something there, the travel is
searched:

1. Positions on a lattice over the whole travel are tried, at most ``SPACING`` apart and with the
   ends of the travel. What seating alone answers is asked first (view, pedals). Clearances and
   reaches follow only where a person may do better than in the positions so far.
2. Where no position fits, the neighbours of the best one are tried at halved distances down to
   ``FINEST``.
3. Who misses by less than ``NEAR_MISS`` there is tried in all positions about the best one,
   ``CLOSE_SPACING`` apart, and then in its neighbours at the ``LAST_STEPS``.

Who fits in none of them is tried at other settings of what may be adjusted (a wheel, pedals, the
tilt of the seat): a lattice of settings, nearest to the nominal one first, with the lattice of
positions at each. Then follow the neighbours of the best position at its setting. Settings between
those of the lattice are not tried: on the compact car they let nobody else fit.

The same search says who would fit if a requirement were dropped: each of several sets of
requirements counts as met where some position meets all of it.

A person who fits only within a region smaller than the lattice, away from the best position that
was tried, is not found.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from workbench.model.accommodation import MET
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.content import content_key
from workbench.model.environment import Seat
from workbench.model.workplace import Workplace
from workbench.posture.seating.posture import DECIMALS
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.checks.table import (
    AFTER_SEATING,
    CHECKS,
    IN_POSTURE,
    REACHING,
    SAME_EVERYWHERE,
    margins_of,
    most_of,
    needs_hands,
    never_met,
)
from workbench.study.settings import (
    at_setting,
    nominal_setting,
    renewed,
    settings_of,
)
from workbench.study.situation import (
    Occupants,
    Remembered,
    Situation,
    Taken,
    in_place,
    position_of,
    seating_of,
    situated,
)

__all__ = [
    "FINEST",
    "SPACING",
    "Before",
    "Fitted",
    "Tried",
    "comfortable_situations",
    "fitted_positions",
    "found_places",
    "in_positions",
    "lattice",
    "tried",
]

SPACING = 0.03
"""Distance [m] between neighbours of the lattice, at most."""
FINEST = 0.0075
"""Distance [m] down to which the neighbours of the best position are tried."""
NEAR_MISS = 0.02
CLOSE_SPACING = 0.005
CLOSE = 4
"""Who misses by less [m] in the best position is tried in a lattice about it: its spacing [m], and
how many of its points lie to each side."""
LAST_STEPS = (0.0025, 0.001, 0.0005)
"""Distances [m] at which the neighbours of the best position of those are tried at last."""
SETTING_WORTH = 1e-4
"""A setting in which somebody still does not fit must be better than the best so far by this [m]."""
WAVE = 8
"""Positions of the lattice that are tried at a time."""
MOST_ROWS = 512
"""People in positions that are judged at a time, which bounds the memory."""
_AROUND = ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1))


@dataclass(frozen=True, eq=False)
class Tried(Margins):
    """Margins of B people, and (B, 2) [m] the positions of the seat, forward and up."""

    seat: Floats

    def rows(self, keep: Ints) -> Tried:
        """A copy of what became of the people at indices, in their order."""
        return Tried(self.margin[keep], self.words[keep], self.toward[keep], self.seat[keep])

    def take(self, rows: Ints, other: Tried) -> None:
        """Replace what became of the people at indices."""
        self.put(rows, np.arange(self.margin.shape[1]), other)
        self.seat[rows] = other.seat


def tried(situations: Sequence[Situation], asked: Sequence[Asked]) -> Tried:
    """What becomes of people where they are, in the cases of their workplace."""
    found = margins_of(situations, asked)
    return Tried(found.margin, found.words, found.toward, position_of(situations[0]))


def comfortable_situations(
    place: Workplace, who: Occupants, taken: Sequence[Taken] = ()
) -> list[Situation]:
    """Put people into each case of their workplace, the seat in the position that the first
    predicted case makes comfortable.

    Parameters
    ----------
    taken
        The places that they have taken in each case; looked for where it is empty.
    """
    first = place.first_predicted
    if taken:
        wanted = in_place(place, first, who, taken[first])
        every = [in_place(place, case, who, one) for case, one in enumerate(taken)]
        return [replace(situation, spare=wanted.spare) for situation in every]
    wanted = situated(place, first, who)
    at = position_of(wanted)
    return [
        wanted if case == first else replace(situated(place, case, who, at), spare=wanted.spare)
        for case in range(len(place.cases))
    ]


def in_positions(
    place: Workplace, who: Occupants, positions: Floats, wanted: Sequence[Situation]
) -> list[Situation]:
    """People in each case with their seats in positions (B, 2) [m].

    What is left of the travel stays as it is where the seat is `wanted`, case by case.
    """
    return [
        replace(situated(place, case, who, positions), spare=there.spare)
        for case, there in enumerate(wanted)
    ]


@dataclass(frozen=True, eq=False)
class Fitted:
    """People in the positions that suit them best.

    Parameters
    ----------
    tried
        B people, R requirements: margins and reasons in the fitting position nearest to the
        comfortable one; where none fits, in that of the greatest least margin.
    comfortable
        (B, 2) [m] forward and up.
    window
        (B, 4) [m] the least and greatest forward, the least and greatest up of the positions tried
        that fit, in the setting of the margins. NaN where none fits, and where the comfortable one
        does: then no other is tried.
    sets
        (B, K) whether some position, in some setting, meets all requirements of each set.
    setting
        (B, A) [m or rad] the setting of the adjustments that the margins are of.
    """

    tried: Tried
    comfortable: Floats
    window: Floats
    sets: Bools
    setting: Floats

    def rows(self, keep: Ints) -> Fitted:
        """A copy of what became of the people at indices, in their order."""
        return Fitted(
            self.tried.rows(keep),
            self.comfortable[keep],
            self.window[keep],
            self.sets[keep],
            self.setting[keep],
        )

    def take(self, rows: Ints, other: Fitted) -> None:
        """Replace what became of the people at indices; their comfortable positions stay."""
        self.tried.take(rows, other.tried)
        self.window[rows] = other.window
        self.sets[rows] = other.sets
        self.setting[rows] = other.setting


def found_places(
    place: Workplace, who: Occupants, comfortable: Sequence[Situation], fitted: Fitted
) -> list[tuple[Ints, list[Situation]]]:
    """People in the positions and settings that their margins are of.

    Parameters
    ----------
    comfortable
        The same people in each case, in their comfortable positions.

    Returns
    -------
    list of tuple
        By setting the indices of people, and these people case by case.
    """
    stays = (fitted.tried.seat == fitted.comfortable).all(axis=1)
    stays &= (fitted.setting == nominal_setting(place)).all(axis=1)
    rows = np.flatnonzero(stays)
    found = [(rows, [one.rows(rows) for one in comfortable])] if len(rows) else []
    rest = np.flatnonzero(~stays)
    for setting in np.unique(fitted.setting[rest], axis=0):
        rows = rest[(fitted.setting[rest] == setting).all(axis=1)]
        wanted = [one.rows(rows) for one in comfortable]
        at = at_setting(place, setting)
        found.append((rows, in_positions(at, who.rows(rows), fitted.tried.seat[rows], wanted)))
    return found


@dataclass(frozen=True, eq=False)
class Before:
    """How people came out before a change of the design that bears on some requirements only.

    Parameters
    ----------
    margin
        (B, R) [m].
    stays
        (B,) who met everything in the comfortable position, where this person still sits.
    borne
        The requirements that the change bears on, by number.
    """

    margin: Floats
    stays: Bools
    borne: tuple[int, ...]

    def rows(self, keep: Ints) -> Before:
        """The people at indices, in their order."""
        return Before(self.margin[keep], self.stays[keep], self.borne)


@dataclass(frozen=True, eq=False)
class _Search:
    """Who is searched for in one setting, and what was found so far; `best` is in the order of
    these people.

    wanted: the cases in the comfortable position of the setting; fixed: what became of them there; counted (B, R): the requirements by which positions are compared: without those that are the same
    everywhere, or proved to be missed everywhere; score (B,) [m]: the least
    margin of these in the best position; setting (A,) [m or rad]; remembered: what the people
    reached so far in it; worth [m]: what a position that does not fit must be better by; judged: the people (by index) in positions [m] that were judged.
    """

    place: Workplace
    asked: Sequence[Asked]
    members: Bools
    who: Occupants
    wanted: Sequence[Situation]
    best: Fitted
    fixed: Margins
    counted: Bools
    setting: Floats
    remembered: Remembered
    worth: float = 0.0
    proceed: Callable[[], None] = lambda: None
    judged: set[tuple[int, float, float]] = field(default_factory=set)

    again: bool = False

    def of(self, people: Ints, before: Fitted, *, few_starts: bool) -> _Search:
        """The same search of some people (N,), once more from what was found before."""
        return replace(
            self,
            who=self.who.rows(people),
            wanted=[situation.rows(people) for situation in self.wanted],
            best=before.rows(people),
            fixed=_of(self.fixed, people, np.ones(len(self.asked), dtype=np.bool_)),
            counted=self.counted[people],
            remembered=replace(self.remembered.rows(people), few_starts=few_starts),
            judged=set(),
            again=True,
        )

    @cached_property
    def whole(self) -> Bools:
        """(B,) who was judged whole in the comfortable position."""
        return np.zeros(len(self.who), dtype=np.bool_)

    @cached_property
    def score(self) -> Floats:
        """(B,) [m] the least margin of what counts in the best position, as the search goes on."""
        return _score(self.best.tried.margin, self.counted)

    @cached_property
    def moved(self) -> Bools:
        """(B,) whose best position is one of this search."""
        return np.zeros(len(self.who), dtype=np.bool_)

    @cached_property
    def comfortable(self) -> Floats:
        """(B, 2) [m] the comfortable position in the setting, forward and up."""
        return position_of(self.wanted[0])


def fitted_positions(
    place: Workplace,
    asked: Sequence[Asked],
    members: Bools,
    who: Occupants,
    comfortable: Sequence[Situation],
    before: Before | None = None,
    *,
    proceed: Callable[[], None] = lambda: None,
) -> Fitted:
    """Judge people in the fitting position nearest to the comfortable one.

    Parameters
    ----------
    members
        (R, K) the requirements of each set.
    who
        B people.
    comfortable
        The same people in each case, in their comfortable positions.
    before
        Of a changed design: how the same people came out without the change. Who met everything
        where he sits, and still meets what the change bears on, is asked nothing else.
    proceed
        Called before each batch of positions; the search ends by what it raises.
    """
    reached = Remembered(len(who), np.arange(len(who)), {}, few_starts=True)
    comfortable = _remembering(comfortable, reached)
    here = _tried_again(comfortable, asked, before) if before else tried(comfortable, asked)
    positions = lattice(place.own_seat)
    hangs = _hang_on_reaches(comfortable, asked, here.margin, anywhere=len(positions) == 1)
    if len(hangs):
        here.take(hangs, tried(_whole([one.rows(hangs) for one in comfortable]), asked))
    at = here.seat.copy()
    window = np.full((len(at), 4), np.nan)
    nominal = nominal_setting(place)
    setting = np.tile(nominal, (len(at), 1))
    found = Fitted(here, at, window, _met_sets(here.margin, members), setting)
    movable = _movable(asked)
    short = np.flatnonzero((here.margin[:, movable] < -MET).any(axis=1))
    if len(positions) > 1 and len(short):
        wanted = [situation.rows(short) for situation in comfortable]
        search = _Search(
            place,
            asked,
            members,
            who.rows(short),
            wanted,
            found.rows(short),
            here.rows(short),
            movable & ~never_met(wanted, asked),
            nominal,
            replace(reached.rows(short), searching=True),
            proceed=proceed,
        )
        search.whole[np.isin(short, hangs)] = True
        _search_travel(search, positions)
        found.take(short, search.best)
    settings = settings_of(place)
    if len(settings):
        _Settings(place, asked, members, who, comfortable, found, reached, proceed).search(settings)
    return found


def _tried_again(situations: Sequence[Situation], asked: Sequence[Asked], before: Before) -> Tried:
    """People of a changed design in their comfortable positions."""
    people = len(situations[0])
    nothing = no_margins(people, asked)
    margin = before.margin.copy()
    found = Tried(margin, nothing.words, nothing.toward, position_of(situations[0]))
    borne = np.array(before.borne, dtype=np.int64)
    stays = np.flatnonzero(before.stays)
    if len(stays) and len(borne):
        some = [asked[r] for r in before.borne]
        again = tried([situation.rows(stays) for situation in situations], some)
        margin[np.ix_(stays, borne)] = again.margin
    rest = np.flatnonzero((margin < -MET).any(axis=1) | ~before.stays)
    if len(rest):
        found.take(rest, tried([situation.rows(rest) for situation in situations], asked))
    return found


def lattice(seat: Seat | None) -> Floats:
    """(M, 2) [m] positions all over the travel of a seat, forward and up, with its ends; one
    position without a seat."""
    if seat is None:
        return np.zeros((1, 2))
    axes = [_axis(*seat.travel_forward), _axis(*seat.travel_up)]
    forward, up = np.meshgrid(*axes, indexing="ij")
    return np.stack([forward.ravel(), up.ravel()], axis=1)


def _axis(low: float, high: float) -> Floats:
    return np.linspace(low, high, 1 + int(np.ceil((high - low) / SPACING - 1e-9)))


def _movable(asked: Sequence[Asked]) -> Bools:
    """(R,) the requirements whose margins depend on the position."""
    return np.array([one.requirement.check not in SAME_EVERYWHERE for one in asked], dtype=np.bool_)


def _score(margin: Floats, counted: Bools) -> Floats:
    """(B,) [m] the least margin of some requirements (R,), or of some of each person (B, R)."""
    known = np.where(np.isnan(margin) | ~counted, np.inf, margin)
    score: Floats = known.min(axis=1, initial=np.inf)
    return score


def _met_sets(margin: Floats, members: Bools) -> Bools:
    """(B, K) whether margins (B, R) [m] meet all requirements of each set (R, K)."""
    missed = (margin < -MET).astype(np.int64) @ members.astype(np.int64)
    return np.asarray(missed == 0, dtype=np.bool_)


def _scan(search: _Search, positions: Floats) -> None:
    """Try the lattice, for each person the nearest to the comfortable position first. Where no set
    is asked for, who fits is asked no further."""
    way = np.linalg.norm(positions[None] - search.comfortable[:, None], axis=2)
    order = np.argsort(way, axis=1, kind="stable")
    for first in range(0, len(positions), WAVE):
        people = np.arange(len(order))
        if not search.members.shape[1]:
            people = np.flatnonzero(search.score < -MET)
        some = order[people, first : first + WAVE]
        _try_positions(search, np.repeat(people, some.shape[1]), positions[some.ravel()])


def _try_positions(search: _Search, people: Ints, positions: Floats) -> None:
    """Judge people (N,) of the search in positions (N, 2), one each, and keep what is better.

    Nobody is judged twice in a position: neighbours meet at the ends of the travel. The others are
    judged in batches: a call costs more than a person.
    """
    new = _not_judged(search, people, positions)
    people = people[new]
    positions = positions[new]
    order = np.lexsort(positions.T[::-1])
    for first in range(0, len(order), MOST_ROWS):
        some = order[first : first + MOST_ROWS]
        _judge(search, people[some], positions[some])


def _not_judged(search: _Search, people: Ints, positions: Floats) -> Ints:
    """The rows of people (N,) in positions (N, 2) that were not judged yet; now they count as
    judged."""
    new = []
    for row, (person, (forward, up)) in enumerate(
        zip(people.tolist(), positions.tolist(), strict=True)
    ):
        key = (person, round(forward, DECIMALS), round(up, DECIMALS))
        if key not in search.judged:
            search.judged.add(key)
            new.append(row)
    return np.array(new, dtype=np.int64)


def _judge(search: _Search, people: Ints, positions: Floats) -> None:
    """Judge people (N,) of the search, each in a position (N, 2), and keep what is better.

    What costs least is asked first, and what follows only of those who may still do better in
    their position, or meet another set.
    """
    search.proceed()
    found = no_margins(len(people), search.asked)
    known = ~_movable(search.asked)
    found.put(np.arange(len(people)), np.flatnonzero(known), _of(search.fixed, people, known))
    wanted = [situation.rows(people) for situation in search.wanted]
    there = in_positions(search.place, search.who.rows(people), positions, wanted)
    situations = _remembering(there, search.remembered.rows(people))
    left = np.arange(len(people))
    for stage in _stages(search, people):
        columns = np.flatnonzero(stage.columns)
        asked = [search.asked[r] for r in columns.tolist()]
        if stage.at_most:
            margin = found.margin[left]
            margin[:, columns] = most_of(situations, asked)
        else:
            found.put(left, columns, margins_of(situations, asked))
            known = known | stage.columns
            margin = found.margin[left]
        hopeful = _hopeful(search, people[left], margin, known | stage.columns)
        if not len(hopeful):
            return
        if len(hopeful) < len(left):
            situations = [situation.rows(hopeful) for situation in situations]
            left = left[hopeful]
    at = position_of(situations[0])
    best = Tried(found.margin[left], found.words[left], found.toward[left], at)
    _keep(search, people[left], best)


def _remembering(situations: Sequence[Situation], known: Remembered) -> list[Situation]:
    """Situations with what their people reached elsewhere."""
    return [replace(situation, remembered=known) for situation in situations]


@dataclass(frozen=True, eq=False)
class _Stage:
    """Requirements (R,) that are asked together, or of which it is only asked how much there can be
    to spare at most."""

    columns: Bools
    at_most: bool = False


def _stages(search: _Search, people: Ints) -> list[_Stage]:
    """The requirements in the order in which they are asked of people (N,), those together that
    cost alike.

    First comes what seating alone answers, then what is asked of the posture with the hands at
    rest, and what that says of requirements with the hands on their controls. For the others hands
    are brought to their controls, or limbs reach for some: of these, those come first that somebody
    misses in his best position. Nine in ten positions that are no better are given up by these.
    """
    cost = np.array([CHECKS[one.requirement.check].cost for one in search.asked])
    held = np.array([needs_hands(search.wanted[one.case], one) for one in search.asked])
    missed = np.any(search.best.tried.margin[people] < -MET, axis=0)
    dear = held | (cost == REACHING)
    stages = [
        _Stage(cost == AFTER_SEATING),
        _Stage((cost == IN_POSTURE) & ~dear),
        _Stage(held, at_most=True),
        _Stage(dear & missed & ~held),
        _Stage(dear & missed & held),
        _Stage(dear & ~missed & held),
        _Stage(dear & ~missed & ~held),
    ]
    movable = _movable(search.asked)
    some = [replace(stage, columns=stage.columns & movable) for stage in stages]
    return [stage for stage in some if np.any(stage.columns)]


def _hopeful(search: _Search, people: Ints, margin: Floats, known: Bools) -> Ints:
    """The rows of people (N,) who may do better than in their best position, or meet another set,
    as far as the requirements (R,) that are known say."""
    least = _score(margin, known & search.counted[people])
    better = least > np.minimum(search.score[people] + search.worth, -MET)
    sets = _met_sets(margin[:, known], search.members[known])
    return np.flatnonzero(better | (sets & ~search.best.sets[people]).any(axis=1))


def _keep(search: _Search, people: Ints, tried: Tried) -> None:
    """Take up what became of people (N,) in positions."""
    best = search.best
    np.logical_or.at(best.sets, people, _met_sets(tried.margin, search.members))
    score = _score(tried.margin, search.counted[people])
    for row in np.flatnonzero(score >= -MET).tolist():
        _widen(best.window[people[row]], tried.seat[row])
    for row, person in enumerate(people.tolist()):
        if _is_better(search, person, float(score[row]), tried.seat[row]):
            best.tried.take(np.array([person]), tried.rows(np.array([row])))
            best.setting[person] = search.setting
            search.moved[person] = True
            search.score[person] = score[row]


def _is_better(search: _Search, person: int, score: float, position: Floats) -> bool:
    """Whether a position is better than the best so far: one that fits before one that does not,
    of those that fit the nearer to the comfortable one, else that of the greater least margin."""
    before = float(search.score[person])
    if score >= -MET and before >= -MET:
        comfortable = search.comfortable[person]
        known = np.linalg.norm(search.best.tried.seat[person] - comfortable)
        return bool(np.linalg.norm(position - comfortable) < known - 1e-9)
    if score >= -MET:
        return True
    return score > before + search.worth


def _widen(window: Floats, position: Floats) -> None:
    """Take a position that fits into the window (4,) of a person."""
    window[::2] = np.fmin(window[::2], position)
    window[1::2] = np.fmax(window[1::2], position)


def _refine(search: _Search) -> None:
    """Try the neighbours of the best position of those for whom none fits, nearer and nearer."""
    step = SPACING / 2
    while step >= FINEST - 1e-9:
        people = np.flatnonzero(search.score < -MET)
        if not len(people):
            return
        _try_neighbours(search, people, step)
        step /= 2
    _try_close(search)
    for step in LAST_STEPS:
        _try_neighbours(search, _near_misses(search), step)


def _search_travel(search: _Search, positions: Floats) -> None:
    """Search the travel of the seat, whose lattice is `positions` (M, 2) [m].

    While positions are searched for, reaches that obstacles put in doubt are tried from few starts.
    In the position that is found they are asked whole. Who fits there by the one and not by the
    other is searched for again with all starts everywhere. Who reaches there what few starts missed
    is searched for again from the posture that reaches it.
    """
    before = search.best.rows(np.arange(len(search.who)))
    _scan(search, positions)
    _refine(search)
    few = search.best.tried.margin.copy()
    fits = search.score >= -MET
    _judge_whole(search)
    margin = search.best.tried.margin
    misses = _score(margin, search.counted) < -MET
    wrong = fits & search.moved & misses
    missed = misses & ~wrong & ((few < -MET) & (margin >= -MET)).any(axis=1)
    for people, few_starts in ((np.flatnonzero(wrong), False), (np.flatnonzero(missed), True)):
        if len(people) and not search.again:
            again = search.of(people, before, few_starts=few_starts)
            _search_travel(again, positions)
            search.best.take(people, again.best)
    # who is proved to be kept from something everywhere fits nowhere
    search.best.window[~search.counted[:, _movable(search.asked)].all(axis=1)] = np.nan


def _judge_whole(search: _Search) -> None:
    """Judge whole, in the best position of each, those who were not yet: each reach with all starts,
    and with how much is to spare."""
    people = np.flatnonzero(search.moved | ~search.whole)
    if not len(people):
        return
    best = search.best
    wanted = [situation.rows(people) for situation in search.wanted]
    who = search.who.rows(people)
    there = in_positions(search.place, who, best.tried.seat[people], wanted)
    whole = tried(_whole(_remembering(there, search.remembered.rows(people))), search.asked)
    best.tried.take(people, whole)
    best.sets[people] |= _met_sets(whole.margin, search.members)


def _whole(situations: Sequence[Situation]) -> list[Situation]:
    """Situations in which each reach is searched for whole."""
    known = situations[0].remembered
    assert known is not None
    return _remembering(situations, replace(known, few_starts=False, searching=False))


def _hang_on_reaches(
    situations: Sequence[Situation], asked: Sequence[Asked], margin: Floats, *, anywhere: bool
) -> Ints:
    """The people whose verdict hangs on reaches: they miss nothing but what hands or feet reach for,
    or what depends on where these are. anywhere: all who miss any of that."""
    hangs = np.array(
        [
            CHECKS[one.requirement.check].cost == REACHING or needs_hands(situations[one.case], one)
            for one in asked
        ]
    )
    missed = margin < -MET
    elsewhere = missed[:, ~hangs].any(axis=1) & (not anywhere)
    return np.flatnonzero(missed[:, hangs].any(axis=1) & ~elsewhere)


def _near_misses(search: _Search) -> Ints:
    """The people who fit nowhere, but nearly do."""
    return np.flatnonzero((search.score < -MET) & (search.score > -NEAR_MISS))


def _try_neighbours(search: _Search, people: Ints, step: float) -> None:
    """Try the eight neighbours of the best position of people (N,), at a distance [m]."""
    centres = np.repeat(search.best.tried.seat[people], len(_AROUND), axis=0)
    ways = np.tile(np.array(_AROUND, dtype=np.float64), (len(people), 1))
    wanted = _within_travel(search, centres + step * ways)
    _try_positions(search, np.repeat(people, len(_AROUND)), wanted)


def _within_travel(search: _Search, positions: Floats) -> Floats:
    """Positions (N, 2) [m], brought into the travel of the seat."""
    seat = search.place.own_seat
    assert seat is not None
    low, high = np.array([seat.travel_forward, seat.travel_up]).T
    inside: Floats = np.clip(positions, low, high)
    return inside


def _try_close(search: _Search) -> None:
    """Try those who nearly fit in all positions about their best one."""
    people = _near_misses(search)
    steps = CLOSE_SPACING * np.arange(-CLOSE, CLOSE + 1)
    ways = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    ways = ways[np.argsort(np.linalg.norm(ways, axis=1), kind="stable")]
    centres = search.best.tried.seat[people].copy()
    for first in range(0, len(ways), WAVE):
        left = np.flatnonzero(search.score[people] < -MET)
        some = ways[first : first + WAVE]
        wanted = np.repeat(centres[left], len(some), axis=0) + np.tile(some, (len(left), 1))
        rows = np.repeat(people[left], len(some))
        _try_positions(search, rows, _within_travel(search, wanted))


@dataclass(frozen=True, eq=False)
class _Settings:
    """People who are searched for at other settings than the nominal one, and what was found of
    them so far. comfortable: the cases at the nominal setting; remembered: what the people reached
    there."""

    place: Workplace
    asked: Sequence[Asked]
    members: Bools
    who: Occupants
    comfortable: Sequence[Situation]
    found: Fitted
    remembered: Remembered
    proceed: Callable[[], None]

    @cached_property
    def moved(self) -> Bools:
        """(B,) who is best off in a position that was searched for here."""
        return np.zeros(len(self.who), dtype=np.bool_)

    @property
    def score(self) -> Floats:
        """(B,) [m] the least margin of all requirements in the best position and setting."""
        return _score(self.found.tried.margin, np.ones(len(self.asked), dtype=np.bool_))

    @property
    def left(self) -> Ints:
        """The people who fit in no position and setting so far."""
        return np.flatnonzero(self.score < -MET)

    def search(self, settings: Floats) -> None:
        """Try settings (S, A), then the neighbours of the best positions."""
        positions = lattice(self.place.own_seat)
        for setting in settings:
            self._tried_at(setting, self.left, lambda search: _scan(search, positions))
        if len(positions) > 1:
            self._refine_at_best()
        for setting in np.unique(self.found.setting[self.moved], axis=0):
            self._judge_whole(setting)

    def _judge_whole(self, setting: Floats) -> None:
        """Judge whole those who are best off at a setting (A,)."""
        people = np.flatnonzero(self.moved & (self.found.setting == setting).all(axis=1))
        place = at_setting(self.place, setting)
        who = self.who.rows(people)
        wanted = [situation.rows(people) for situation in self.comfortable]
        there = in_positions(place, who, self.found.tried.seat[people], wanted)
        there = _remembering(there, self.remembered.elsewhere().rows(people))
        whole = tried(_whole(there), renewed(place, self.asked))
        self.found.tried.take(people, whole)

    def _tried_at(self, setting: Floats, people: Ints, trying: Callable[[_Search], None]) -> None:
        """Try some people (N,) at a setting (A,): in the comfortable position there, then as
        `trying` does."""
        if not len(people):
            return
        place = at_setting(self.place, setting)
        asked = renewed(place, self.asked)
        who = self.who.rows(people)
        before = [situation.rows(people) for situation in self.comfortable]
        wanted = comfortable_situations(place, who, _taken_again(self.place, place, before))
        best = self.found.rows(people)
        fixed = _margins_anywhere(wanted, asked)
        everything = np.ones((len(people), len(asked)), dtype=np.bool_)
        search = _Search(
            place,
            asked,
            self.members,
            who,
            wanted,
            best,
            fixed,
            everything,
            setting,
            replace(self.remembered.elsewhere().rows(people), searching=True),
            SETTING_WORTH,
            self.proceed,
        )
        _try_positions(search, np.arange(len(people)), search.comfortable)
        trying(search)
        self.found.take(people, best)
        self.moved[people[search.moved]] = True

    def _refine_at_best(self) -> None:
        """Try the neighbours of the best position at its setting, where that is not the nominal
        one."""
        left = self.left
        nominal = nominal_setting(self.place)
        for setting in np.unique(self.found.setting[left], axis=0):
            if not np.array_equal(setting, nominal):
                mine = (self.found.setting[left] == setting).all(axis=1)
                self._tried_at(setting, left[mine], _refine)


def _margins_anywhere(wanted: Sequence[Situation], asked: Sequence[Asked]) -> Margins:
    """The margins of the requirements that are the same in every position, NaN of the others."""
    people = len(wanted[0])
    same = np.flatnonzero(~_movable(asked))
    found = no_margins(people, asked)
    if len(same):
        found.put(np.arange(people), same, margins_of(wanted, [asked[r] for r in same.tolist()]))
    return found


def _of(margins: Margins, people: Ints, columns: Bools) -> Margins:
    """The margins of some people (N,) in some requirements (R,)."""
    at = np.ix_(people, np.flatnonzero(columns))
    return Margins(margins.margin[at], margins.words[at], margins.toward[at])


def _taken_again(
    place: Workplace, other: Workplace, situations: Sequence[Situation]
) -> Sequence[Taken]:
    """The places that people have taken in a workplace, where they take the same ones in another;
    else nothing."""
    for case in range(len(place.cases)):
        one, two = (content_key("seating", seating_of(each, case)) for each in (place, other))
        if one != two:
            return ()
    return [situation.taken for situation in situations]
