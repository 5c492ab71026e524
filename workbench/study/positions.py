"""Find for each person the seat position in which every requirement is met.

A person fits a workplace if some position within the travel of the seat meets all requirements at
once. The comfortable position comes first. For people who miss something there, the travel is
searched:

1. Positions on a lattice over the whole travel are tried, at most ``SPACING`` apart and with the
   ends of the travel. What seating alone answers is asked first (view, pedals). Clearances and
   reaches follow only where a person may do better than in the positions so far.
2. Where no position fits, those are tried between the positions of the lattice where the margins,
   taken as straight from one to the next, promise the most.
3. Where still none fits, the neighbours of the best one are tried at halved distances down to
   ``FINEST``.
4. Who misses by less than ``NEAR_MISS`` there is tried in all positions about the best one,
   ``CLOSE_SPACING`` apart, and then in its neighbours at the ``LAST_STEPS``.

Who fits in none of them is tried at other settings of what may be adjusted (a wheel, pedals, the
tilt of the seat): a lattice of settings, nearest to the nominal one first, with the lattice of
positions at each. Then follow the neighbours of the best position at its setting. Settings between
those of the lattice are not tried: on the compact car they let nobody else fit.

The same search says who would fit if a requirement were dropped: each of several sets of
requirements counts as met where some position meets all of it.

A person who fits only within a region smaller than the lattice, away from the positions that
were tried, is not found.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from workbench.model.accommodation import MET
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.content import content_key
from workbench.model.workplace import Workplace
from workbench.posture.seating.posture import DECIMALS
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.checks.table import (
    AFTER_SEATING,
    CHECKS,
    IN_POSTURE,
    REACHING,
    margins_of,
    most_of,
    needs_hands,
    needs_legs,
    never_met,
    same_everywhere,
    takes_looks,
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
    TakenPlaces,
    in_place,
    position_of,
    seating_of,
    situated,
    with_clear_legs,
    with_hands,
)

__all__ = [
    "FINEST",
    "SPACING",
    "WAVE",
    "WITHIN_NEIGHBOURS",
    "Before",
    "FittedBody",
    "Outcomes",
    "comfortable_situations",
    "fitted_positions",
    "found_places",
    "in_positions",
    "lattice",
    "spacing_of",
    "tried",
]

SPACING = 0.03
"""Distance [m] between neighbours of the lattice, at most."""
BENDING_SPACING = 0.1
"""The same for people whose standing posture is predicted: in each position they bend anew, which
takes 100 times as long as to be seated."""
FINEST = 0.0075
"""Distance [m] down to which the neighbours of the best position are tried."""
NEAR_MISS = 0.02
CLOSE_SPACING = 0.005
CLOSE = 4
"""Who misses by less [m] in the best position is tried in a lattice about it: its spacing [m], and
how many of its points lie to each side."""
BETWEEN = 0.002
MOST_BETWEEN = 6
APART_BETWEEN = 0.015
FARTHEST = 1.0
"""Between the positions of the lattice margins are worked out so far [m] apart, and so many of the
best places are tried, so far [m] from each other at least; margins count up to the last."""
LAST_STEPS = (0.0025, 0.001, 0.0005)
"""Distances [m] at which the neighbours of the best position of those are tried at last."""
WITHIN_NEIGHBOURS = 0.01
"""Who misses by more [m] in all positions that a changed design is tried in is not tried in their
neighbours: these were tried before the change, where they were worth it."""
SAME_SETTING = 1e-5
"""[m or rad] Two settings that are less apart are the same one."""
SETTING_WORTH = 1e-4
POSITION_WORTH = 1e-6
"""A setting, or a position, in which somebody still does not fit must be better than the best so far by
this [m]: of those that are alike but for rounding the first one stays."""
WAVE = 8
"""Positions of the lattice that are tried at a time."""
MOST_ROWS = 512
"""People in positions that are judged at a time, which bounds the memory."""
CALL = 12
"""A call costs as much as so many requirements of a person that are asked for in it."""
_AROUND = ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1))


@dataclass(frozen=True, eq=False)
class Outcomes(Margins):
    """Margins of B people, and (B, 2) [m] the positions of the seat, forward and up."""

    seat: Floats

    def rows(self, keep: Ints) -> Outcomes:
        """A copy of what became of the people at indices, in their order."""
        return Outcomes(self.margin[keep], self.words[keep], self.toward[keep], self.seat[keep])

    def take(self, rows: Ints, other: Outcomes) -> None:
        """Replace what became of the people at indices."""
        self.put(rows, np.arange(self.margin.shape[1]), other)
        self.seat[rows] = other.seat


def tried(situations: Sequence[Situation], asked: Sequence[Asked]) -> Outcomes:
    """What becomes of people where they are, in the cases of their workplace."""
    found = margins_of(situations, asked)
    return Outcomes(found.margin, found.words, found.toward, position_of(situations[0]))


def comfortable_situations(
    place: Workplace, who: Occupants, taken: Sequence[TakenPlaces] = ()
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
    place: Workplace,
    who: Occupants,
    positions: Floats,
    wanted: Sequence[Situation],
    *,
    heedless: bool = False,
) -> list[Situation]:
    """People in each case with their seats in positions (B, 2) [m]; heedless as of `in_place`.

    What is left of the travel stays as it is where the seat is `wanted`, case by case.
    """
    return [
        replace(situated(place, case, who, positions, heedless=heedless), spare=there.spare)
        for case, there in enumerate(wanted)
    ]


@dataclass(frozen=True, eq=False)
class FittedBody:
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
    judged
        (B,) of those who do not fit in the comfortable position a list of arrays (A + 2 + R,), one
        for each position that was judged in some setting: the setting, where it is, and what the
        person has to spare there [m], NaN where that is not known.
    first
        (B, R) [m] the margins in the comfortable position and the nominal setting, NaN where they
        are not known.
    """

    tried: Outcomes
    comfortable: Floats
    window: Floats
    sets: Bools
    setting: Floats
    judged: NDArray[np.object_]
    first: Floats

    def rows(self, keep: Ints) -> FittedBody:
        """A copy of what became of the people at indices, in their order."""
        return FittedBody(
            self.tried.rows(keep),
            self.comfortable[keep],
            self.window[keep],
            self.sets[keep],
            self.setting[keep],
            self.judged[keep],
            self.first[keep],
        )

    def take(self, rows: Ints, other: FittedBody) -> None:
        """Replace what became of the people at indices; their comfortable positions stay."""
        self.tried.take(rows, other.tried)
        self.window[rows] = other.window
        self.sets[rows] = other.sets
        self.setting[rows] = other.setting
        self.judged[rows] = other.judged


def found_places(
    place: Workplace, who: Occupants, comfortable: Sequence[Situation], fitted: FittedBody
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
    """How people came out before a change of the design.

    Parameters
    ----------
    margin, seat
        (B, R) [m], and (B, 2) [m] the position that they are of.
    nominal
        (B,) whose margins are of the nominal setting of all adjustments.
    fits
        (B,) who met everything.
    known
        (B,) of whom of the others it is known where the change may let them fit.
    again
        (B, W, A + 2) [m or rad] the settings, and the positions of the travel that there was, in which
        it may; NaN after the last of a person.
    travel
        (2, 2) [m] that travel, forward and up.
    borne
        The requirements that the change bears on, by number: they are asked again where people sit.
    """

    margin: Floats
    seat: Floats
    nominal: Bools
    fits: Bools
    known: Bools
    again: Floats
    travel: Floats
    borne: tuple[int, ...]

    def rows(self, keep: Ints) -> Before:
        """The people at indices, in their order."""
        return replace(
            self,
            margin=self.margin[keep],
            seat=self.seat[keep],
            nominal=self.nominal[keep],
            fits=self.fits[keep],
            known=self.known[keep],
            again=self.again[keep],
        )


@dataclass(frozen=True, eq=False)
class _Search:
    """Who is searched for in one setting, and what was found so far; `best` is in the order of
    these people.

    wanted: the cases in the comfortable position of the setting; fixed: what became of them there; counted (B, R): the requirements by which positions are compared: without those that are the same
    everywhere, or proved to be missed everywhere; score (B,) [m]: the least
    margin of these in the best position; setting (A,) [m or rad]; remembered: what the people
    reached so far in it; worth [m]: what a position that does not fit must be better by; judged: the people (by index) in positions [m] that were judged; seen: these positions (2,) of
    each with what there is to spare (R,) [m], NaN where that is not known; before: of a changed
    design how these people came out without the change, whose best position they begin with; notes: whether it is noted what people have to
    spare in each position; coarse: whether it is only asked who fits, see `here` of `fitted_positions`.
    """

    place: Workplace
    asked: Sequence[Asked]
    members: Bools
    who: Occupants
    wanted: Sequence[Situation]
    best: FittedBody
    fixed: Margins
    counted: Bools
    setting: Floats
    remembered: Remembered
    worth: float = POSITION_WORTH
    proceed: Callable[[], None] = lambda: None
    judged: set[tuple[int, float, float]] = field(default_factory=set)
    seen: dict[int, list[tuple[Floats, Floats]]] = field(default_factory=dict)
    again: bool = False
    before: Before | None = None
    notes: bool = False
    coarse: bool = False

    def of(self, people: Ints, before: FittedBody, *, few_starts: bool) -> _Search:
        """The same search of some people (N,), once more from what was found before."""
        return replace(
            self,
            who=self.who.rows(people),
            wanted=[situation.rows(people) for situation in self.wanted],
            best=before.rows(people),
            fixed=_of(self.fixed, people, np.ones(len(self.asked), dtype=np.bool_)),
            counted=self.counted[people],
            before=self.before.rows(people) if self.before is not None else None,
            remembered=replace(self.remembered.rows(people), few_starts=few_starts),
            judged=set(),
            seen={},
            again=True,
        )

    @property
    def begun(self) -> bool:
        """Whether people begin with the best position of a search before."""
        return self.before is not None

    @cached_property
    def whole(self) -> Bools:
        """(B,) who was judged whole in the comfortable position."""
        return np.zeros(len(self.who), dtype=np.bool_)

    @property
    def unrefined(self) -> Bools:
        """(B,) about whose best position more positions are worth a try: of a changed design only
        where these may let the person fit."""
        everybody = np.ones(len(self.who), dtype=np.bool_)
        return self.moved & (self.score > -WITHIN_NEIGHBOURS) if self.begun else everybody

    @cached_property
    def score(self) -> Floats:
        """(B,) [m] the least margin of what counts in the best position, as the search goes on."""
        return _score(self.best.tried.margin, self.counted)

    @cached_property
    def moved(self) -> Bools:
        """(B,) whose best position is one of this search."""
        return np.zeros(len(self.who), dtype=np.bool_)

    @cached_property
    def held(self) -> Bools:
        """(R,) which requirements of the posture depend on where hands are."""
        return np.array([needs_hands(self.wanted[one.case], one) for one in self.asked])

    @cached_property
    def legs(self) -> Bools:
        """(R,) which requirements of the posture depend on where the legs are."""
        return np.array([needs_legs(self.wanted[one.case], one) for one in self.asked])

    @cached_property
    def movable(self) -> Bools:
        """(R,) as of `_movable`."""
        return _movable(self.place, self.asked)

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
    thorough: bool = False,
    here: Outcomes | None = None,
    proceed: Callable[[], None] = lambda: None,
) -> FittedBody:
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
        Of a changed design: how the same people came out without the change. Who fitted, and still
        meets what the change bears on, is asked nothing else; the others are tried where it may let them fit.
    thorough
        Whether each reach is searched for whole in each position. That takes up to a hundred times
        as long, and is what the sparing search is compared with.
    here
        What becomes of the people in a position of theirs that is known. Then it is only asked whether
        they fit in another: not how much they have to spare there, and neighbours nearer than
        `FINEST` are left out.
    proceed
        Called before each batch of positions; the search ends by what it raises.
    """
    reached = Remembered(len(who), np.arange(len(who)), {}, few_starts=not thorough)
    comfortable = _remembering(comfortable, reached)
    positions = lattice(place.travel, spacing_of(place))
    coarse = here is not None
    settled = np.zeros(len(who), dtype=np.bool_)
    whole = np.zeros(len(who), dtype=np.bool_)
    if before is not None:
        here, settled = _tried_again(place, who, comfortable, asked, before)
    elif here is None:
        here = tried(comfortable, asked)
    if not coarse:
        hangs = _hang_on_reaches(comfortable, asked, here.margin, anywhere=len(positions) == 1)
        whole[hangs] = ~settled[hangs]
        some = np.flatnonzero(whole)
        if len(some):
            here.take(some, tried(_whole([one.rows(some) for one in comfortable]), asked))
    found = _begun_with(here, position_of(comfortable[0]), nominal_setting(place), members)
    movable = _movable(place, asked)
    missing = (here.margin[:, movable] < -MET).any(axis=1)
    if coarse:  # who misses what is the same everywhere fits nowhere
        missing &= ~(here.margin[:, ~movable] < -MET).any(axis=1)
    for begun, mine in ((False, missing & ~settled), (True, missing & settled)):
        short = np.flatnonzero(mine)
        if len(positions) < 2 or not len(short):
            continue
        wanted = [situation.rows(short) for situation in comfortable]
        search = _Search(
            place,
            asked,
            members,
            who.rows(short),
            wanted,
            found.rows(short),
            here.rows(short),
            movable & (thorough | ~never_met(wanted, asked)),
            nominal_setting(place),
            replace(reached.rows(short), searching=not thorough),
            before=before.rows(short) if before is not None and begun else None,
            notes=before is None and bool(members.shape[1]),
            coarse=coarse,
            proceed=proceed,
        )
        search.whole[:] = whole[short] | begun
        _note(search, np.arange(len(short)), search.comfortable, here.margin[short])
        _search_travel(search, positions)
        found.take(short, search.best)
    settings = settings_of(place)
    if len(settings):
        _Settings(place, asked, members, who, comfortable, found, reached, before, proceed).search(
            settings
        )
    return found


def _begun_with(here: Outcomes, comfortable: Floats, nominal: Floats, members: Bools) -> FittedBody:
    """What is known of people who were judged in one position each, at the nominal setting (A,)."""
    count = len(comfortable)
    judged = np.empty(count, dtype=object)
    judged[:] = [[] for _ in range(count)]
    return FittedBody(
        here,
        comfortable,
        np.full((count, 4), np.nan),
        _met_sets(here.margin, members),
        np.tile(nominal, (count, 1)),
        judged,
        here.margin.copy(),
    )


def _tried_again(
    place: Workplace,
    who: Occupants,
    comfortable: Sequence[Situation],
    asked: Sequence[Asked],
    before: Before,
) -> tuple[Outcomes, Bools]:
    """People of a changed design, and who of them (B,) is settled: in the position that was found
    before, or else comfortable and still to be searched for."""
    people = len(who)
    nothing = no_margins(people, asked)
    comes = position_of(comfortable[0])
    found = Outcomes(before.margin.copy(), nothing.words, nothing.toward, comes.copy())
    settled = (before.fits | before.known) & before.nominal
    low, high = np.array(place.travel).T
    settled &= ((before.seat >= low - MET) & (before.seat <= high + MET)).all(axis=1)
    there = np.flatnonzero(settled)
    found.seat[there] = before.seat[there]
    if len(before.borne):
        some = [asked[r] for r in before.borne]
        stays = (before.seat == comes).all(axis=1)
        for rows in (there[stays[there]], there[~stays[there]]):
            wanted = [situation.rows(rows) for situation in comfortable]
            if not stays[rows].all():
                at = in_positions(place, who.rows(rows), before.seat[rows], wanted)
                reached = wanted[0].remembered
                wanted = at if reached is None else _remembering(at, reached)
            if len(rows):
                again = tried(wanted, some)
                found.margin[np.ix_(rows, before.borne)] = again.margin
    settled &= before.known | ~(found.margin < -MET).any(axis=1)
    rest = np.flatnonzero(~settled)
    if len(rest):
        found.take(rest, tried([situation.rows(rest) for situation in comfortable], asked))
    return found, settled


def _scan_changed(search: _Search, positions: Floats, before: Before) -> None:
    """Try people of a changed design where it may let them fit: in some of the positions that were
    judged before in the setting of the search, and in those of the lattice that a longer travel has
    added."""
    new = positions[_outside(positions, before.travel)]
    comes = _outside(search.comfortable, before.travel)
    person, place = np.nonzero(_at_the_setting(before, search.setting))
    everybody = np.repeat(np.arange(len(search.who)), len(new))
    people = np.concatenate([np.flatnonzero(comes), everybody, person])
    places = [search.comfortable[comes], np.tile(new, (len(search.who), 1))]
    _try_positions(search, people, np.concatenate([*places, before.again[person, place, -2:]]))


def _at_the_setting(before: Before, setting: Floats) -> Bools:
    """(B, W) which places to try again are of a setting (A,)."""
    same = (np.abs(before.again[:, :, :-2] - setting) < SAME_SETTING).all(axis=2)
    return same & ~np.isnan(before.again[:, :, -1])


def _outside(positions: Floats, travel: Floats) -> Bools:
    """(M,) which positions (M, 2) lie outside a travel (2, 2) of the seat."""
    inside = (positions >= travel[:, 0] - 1e-6) & (positions <= travel[:, 1] + 1e-6)
    return np.asarray(~inside.all(axis=1))


def spacing_of(place: Workplace) -> float:
    """Distance [m] between neighbours of the lattice, at most."""
    bends = place.seat is None and any(case.aims is not None for case in place.cases)
    return BENDING_SPACING if bends else SPACING


def lattice(
    travel: tuple[tuple[float, float], tuple[float, float]], spacing: float = SPACING
) -> Floats:
    """(M, 2) [m] positions all over the travel of a seat, or the area that somebody steps in, with
    its ends, so far [m] from each other at most; one position where there is none."""
    first, second = np.meshgrid(*(_axis(*ends, spacing) for ends in travel), indexing="ij")
    return np.stack([first.ravel(), second.ravel()], axis=1)


def _axis(low: float, high: float, spacing: float) -> Floats:
    return np.linspace(low, high, 1 + int(np.ceil((high - low) / spacing - 1e-9)))


def _movable(place: Workplace, asked: Sequence[Asked]) -> Bools:
    """(R,) the requirements whose margins depend on the position."""
    return np.array([not same_everywhere(place, one) for one in asked], dtype=np.bool_)


def _score(margin: Floats, counted: Bools) -> Floats:
    """(B,) [m] the least margin of some requirements (R,), or of some of each person (B, R)."""
    known = np.where(np.isnan(margin) | ~counted, np.inf, margin)
    return known.min(axis=1, initial=np.inf)


def _met_sets(margin: Floats, members: Bools) -> Bools:
    """(B, K) whether margins (B, R) [m] meet all requirements of each set (R, K)."""
    missed = (margin < -MET).astype(np.int64) @ members.astype(np.int64)
    return np.asarray(missed == 0, dtype=np.bool_)


def _scan(search: _Search, positions: Floats) -> None:
    """Try the lattice, for each person the nearest to the comfortable position first. Where no set
    is asked for, who fits is asked no further. Of a changed design less, see `_scan_changed`."""
    if search.before is not None:
        _scan_changed(search, positions, search.before)
        return
    way = np.linalg.norm(positions[None] - search.comfortable[:, None], axis=2)
    order = np.argsort(np.round(way, DECIMALS), axis=1, kind="stable")
    for first in range(0, len(positions), WAVE):
        people = np.arange(len(order))
        if not search.members.shape[1]:
            people = np.flatnonzero(search.score < -MET)
        some = order[people, first : first + WAVE]
        _try_positions(search, np.repeat(people, some.shape[1]), positions[some.ravel()])


def _try_positions(search: _Search, people: Ints, positions: Floats) -> None:
    """Judge people (N,) of the search in positions (N, 2), one each, and keep what is better.

    Nobody is judged twice in a position: neighbours meet at the ends of the travel. The others are
    judged in batches: a call costs more than a person. All positions of a person are in one batch,
    so that what is asked in them does not depend on who else is searched for.
    """
    new = _not_judged(search, people, positions)
    people = people[new]
    positions = positions[new]
    order = np.lexsort((*np.round(positions, DECIMALS).T[::-1], people))
    count = np.bincount(people, minlength=len(search.who))
    batch = (np.cumsum(count) - count) // MOST_ROWS
    for number in np.unique(batch[people]).tolist():
        some = order[batch[people[order]] == number]
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
    same = ~search.movable
    found.put(np.arange(len(people)), np.flatnonzero(same), _of(search.fixed, people, same))
    wanted = [situation.rows(people) for situation in search.wanted]
    who = search.who.rows(people)
    there = in_positions(search.place, who, positions, wanted, heedless=True)
    situations = _remembering(there, search.remembered.rows(people))
    left = np.arange(len(people))
    known = np.tile(same, (len(people), 1))
    # what counts of each person so far: what is asked for others' sake does not, until his own turn
    told = known.copy()
    far = _out_of_reach(search, situations)
    for stage in _stages(search, people):
        wants = stage.columns[left] & ~known[left]
        if stage.legs and wants.any():
            situations = [with_clear_legs(one) for one in situations]
        if not stage.at_most:
            wants = _worth_a_call(wants, ~known[left] & wants.any(axis=0))
            _ask_each(situations, search.asked, wants, found, left)
            known[left] |= wants
            told[left] |= stage.columns[left]
        margin = np.where(told[left], found.margin[left], np.nan)
        if stage.at_most and wants.any():
            _put_most(situations, search.asked, wants, margin)
        at_most = np.where(np.isnan(margin), far[left], margin)
        hopeful = _hopeful(search, people[left], at_most)
        given_up = np.setdiff1d(np.arange(len(left)), hopeful)
        at = positions[left[given_up]]
        _note(search, people[left[given_up]], at, margin[given_up])
        if not len(hopeful):
            return
        if len(hopeful) < len(left):
            situations = [situation.rows(hopeful) for situation in situations]
            left = left[hopeful]
    at = position_of(situations[0])
    best = Outcomes(found.margin[left], found.words[left], found.toward[left], at)
    _note(search, people[left], positions[left], best.margin)
    _keep(search, people[left], best)


def _put_most(
    situations: Sequence[Situation], asked: Sequence[Asked], wants: Bools, margin: Floats
) -> None:
    """Put what people (N,) have to spare at most into their margins (N, R), where it is wanted (N,
    R)."""
    rows = np.flatnonzero(wants.any(axis=1))
    columns = np.flatnonzero(wants.any(axis=0))
    some = situations
    if len(rows) < len(wants):
        some = [situation.rows(rows) for situation in situations]
    where = np.ix_(rows, columns)
    most = most_of(some, [asked[r] for r in columns.tolist()])
    margin[where] = np.where(wants[where], most, margin[where])


def _out_of_reach(search: _Search, situations: Sequence[Situation]) -> Floats:
    """(N, R) what people who stand have to spare at most by the length of their limbs, NaN of what
    that does not tell. Positions are compared by it, but it is not noted: it may be off by a hand's
    length. In the travel of a seat, which is shorter than a lap, hardly a control is out of reach."""
    found = np.full((len(situations[0]), len(search.asked)), np.nan)
    reaches = [r for r, one in enumerate(search.asked) if one.control is not None]
    if search.place.seat is None and reaches:
        found[:, reaches] = most_of(situations, [search.asked[r] for r in reaches])
    return found


def _worth_a_call(wants: Bools, more: Bools) -> Bools:
    """What is asked (N, R): no more than is wanted of each person (N, R), or `more` (N, R) of it,
    which takes fewer calls, where these cost as much as what nobody wants."""
    idle = int((more & ~wants).sum())
    if idle <= CALL:
        return more
    calls = len(np.unique(wants, axis=0)) - len(np.unique(more, axis=0))
    return wants if idle > CALL * calls else more


def _ask_each(
    situations: Sequence[Situation],
    asked: Sequence[Asked],
    wants: Bools,
    found: Margins,
    people: Ints,
) -> None:
    """Ask people (N,) of `found` what is wanted of each (N, R), those together of whom the same is.
    Their hands are brought to their controls together."""
    for r in np.flatnonzero(wants.any(axis=0)).tolist():
        if needs_hands(situations[asked[r].case], asked[r]):
            with_hands(situations[asked[r].case])
    sets, which = wants[:1], np.zeros(len(wants), dtype=np.int64)
    if (wants != sets).any():
        sets, which = np.unique(wants, axis=0, return_inverse=True)
    for number, columns in enumerate(sets):
        if columns.any():
            rows = np.flatnonzero(which.ravel() == number)
            some = situations
            if len(sets) > 1:
                some = [situation.rows(rows) for situation in situations]
            those = np.flatnonzero(columns)
            found.put(people[rows], those, margins_of(some, [asked[r] for r in those.tolist()]))


def _note(search: _Search, people: Ints, positions: Floats, margin: Floats) -> None:
    """Note what people (N,) have to spare in positions (N, 2), as far as it is known (N, R)."""
    if not search.begun:  # nothing is sought between positions of a changed design
        for person, position, some in zip(people.tolist(), positions, margin, strict=True):
            search.seen.setdefault(person, []).append((position, some))
    if search.notes:
        setting = np.broadcast_to(search.setting, (len(people), len(search.setting)))
        rows = np.hstack([setting, positions, margin])
        for person, row in zip(people.tolist(), rows, strict=True):
            search.best.judged[person].append(row)


def _remembering(situations: Sequence[Situation], known: Remembered) -> list[Situation]:
    """Situations with what their people reached elsewhere."""
    return [replace(situation, remembered=known) for situation in situations]


@dataclass(frozen=True, eq=False)
class _Stage:
    """Requirements of each person (N, R) that are asked together, or of which it is only asked how
    much there can be to spare at most; legs: whether the legs must be clear before."""

    columns: Bools
    at_most: bool = False
    legs: bool = True


def _stages(search: _Search, people: Ints) -> list[_Stage]:
    """The requirements in the order in which they are asked of people (N,), those together that
    cost alike.

    First comes what seating alone answers, then what is asked of the posture with the hands at
    rest: what the legs do not move before what they do. Then comes what the
    posture says of requirements with the hands on their controls. For the others hands
    are brought to their controls, or limbs reach for some: of these, those come first that the
    person misses in his best position. Nine in ten positions that are no better are given up by
    these. The order does not depend on who else is asked.
    """
    cost = np.array([CHECKS[one.requirement.check].cost for one in search.asked])
    held = search.held
    looks = np.array([takes_looks(search.place, one) for one in search.asked])
    seen = np.array([one.requirement.of_sight for one in search.asked])
    missed = search.best.tried.margin[people] < -MET
    legs = search.legs
    dear = (held | (cost == REACHING)) & ~looks
    cheap = (cost == IN_POSTURE) & ~dear & ~looks
    pedals = np.array([one.requirement.check == "pedals" for one in search.asked])
    movable = search.movable

    def stage(columns: Bools, *, at_most: bool = False, legs: bool = True) -> _Stage:
        return _Stage(np.broadcast_to(columns & movable, missed.shape), at_most, legs)

    return [
        stage(cost == AFTER_SEATING, legs=False),
        stage(pedals, at_most=True, legs=False),
        stage(cheap & ~legs, legs=False),
        stage(dear & seen, at_most=True, legs=False),
        stage(looks & missed, at_most=True, legs=False),
        stage(cheap & legs),
        stage(held & ~seen, at_most=True),
        stage(dear & missed & ~held),
        stage(dear & missed & held),
        stage(dear & held),
        stage(dear & ~held),
        stage(looks & ~missed, at_most=True),
        stage(looks),
    ]


def _hopeful(search: _Search, people: Ints, margin: Floats) -> Ints:
    """The rows of people (N,) who may do better than in their best position, or meet another set,
    as far as margins (N, R) say; NaN of what is not known."""
    least = _score(margin, search.counted[people])
    enough = np.minimum(search.score[people] + search.worth, -MET)
    if search.begun:
        enough = np.maximum(enough, -WITHIN_NEIGHBOURS)
    better = least > enough
    sets = _met_sets(margin, search.members)
    return np.flatnonzero(better | (sets & ~search.best.sets[people]).any(axis=1))


def _keep(search: _Search, people: Ints, tried: Outcomes) -> None:
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
    step = spacing_of(search.place) / 2
    while step >= FINEST - 1e-9:
        people = np.flatnonzero((search.score < -MET) & search.unrefined)
        if not len(people):
            return
        _try_neighbours(search, people, step)
        step /= 2
    _try_close(search)
    for step in LAST_STEPS:
        _try_neighbours(search, _near_misses(search), step)


def _try_between(search: _Search, positions: Floats) -> None:
    """Try those who fit in no position of the lattice where the margins between its positions
    promise more than the best of them has.

    The best of two limits that work against each other (room above the head, height of the eyes)
    lies along a narrow crest. Positions of the lattice lie beside it, now nearer, now farther, so
    that the nearest of them says little of where the crest is highest. Each margin by itself changes
    smoothly: it is taken as linear along both ways between four positions, and goes on as from the
    two nearest where it is not known (who misses much there is asked no further). What is not known
    then is taken as met.
    """
    if search.begun:
        return
    people = np.flatnonzero((search.score < -MET) & search.unrefined)
    ends = [np.unique(axis) for axis in positions.T]
    fine, weights = zip(*(_between(axis) for axis in ends), strict=True)
    places = np.stack(np.meshgrid(*fine, indexing="ij"), axis=-1).reshape(-1, 2)
    wanted = []
    for person in people.tolist():
        margin = _on_lattice(search.seen.get(person, []), ends, len(search.asked))
        margin = _continued(_continued(margin, 1), 0)
        unknown = np.isnan(margin) | ~search.counted[person]
        known = np.einsum("ai,bj,ijr->abr", *weights, np.where(unknown, 0.0, margin))
        some = np.einsum("ai,bj,ijr->abr", *weights, unknown.astype(np.float64))
        promise = np.where(some > 0, np.inf, known).min(axis=2).ravel()
        least = max(float(search.score[person]) + search.worth, -NEAR_MISS)
        wanted += [(person, places[one]) for one in _peaks(promise, places, least)]
    if wanted:
        at = np.array([place for _, place in wanted])
        _try_positions(search, np.array([person for person, _ in wanted]), at)


def _between(axis: Floats) -> tuple[Floats, Floats]:
    """(F,) places along an axis (N,), BETWEEN apart at most, and (F, N) the weight that each place of
    the axis has there for what is linear in between."""
    fine = [
        np.linspace(low, high, 1 + int(np.ceil((high - low) / BETWEEN - 1e-9)))[:-1]
        for low, high in pairwise(axis)
    ]
    places = np.concatenate([*fine, axis[-1:]])
    return places, np.stack([np.interp(places, axis, one) for one in np.eye(len(axis))], axis=1)


def _on_lattice(
    seen: Sequence[tuple[Floats, Floats]], axes: Sequence[Floats], count: int
) -> Floats:
    """(N, M, R) [m] what somebody has to spare in the positions of a lattice with axes (N,) and
    (M,), NaN where it is not known, from what was `seen`."""
    margin = np.full((len(axes[0]), len(axes[1]), count), np.nan)
    for position, some in seen:
        where = [
            int(np.argmin(np.abs(axis - one))) for axis, one in zip(axes, position, strict=True)
        ]
        if abs(axes[0][where[0]] - position[0]) + abs(axes[1][where[1]] - position[1]) < 1e-9:
            margin[tuple(where)] = some
    return np.clip(margin, -FARTHEST, FARTHEST)  # what is met without end has no weight


def _continued(margin: Floats, axis: int) -> Floats:
    """Margins (N, M, R) in which those that are not known go on straight along an axis, as from the
    two nearest that are known on the one side or the other."""
    found = np.moveaxis(margin.copy(), axis, 0)
    count = len(found)
    for step, places in ((1, range(2, count)), (-1, range(count - 3, -1, -1))):
        for place in places:
            straight = 2 * found[place - step] - found[place - 2 * step]
            found[place] = np.where(np.isnan(found[place]), straight, found[place])
    return np.moveaxis(found, 0, axis)


def _peaks(promise: Floats, places: Floats, least: float) -> list[int]:
    """The places (P, 2) of the greatest promise (P,) above `least`, the greatest first."""
    left = np.where(promise > least, np.round(promise, DECIMALS), -np.inf)
    found: list[int] = []
    while len(found) < MOST_BETWEEN and (left > -np.inf).any():
        found.append(int(np.argmax(left)))
        left[np.linalg.norm(places - places[found[-1]], axis=1) < APART_BETWEEN] = -np.inf
    return found


def _search_travel(search: _Search, positions: Floats) -> None:
    """Search the travel of the seat: the lattice of positions, then about the best position of each.

    While positions are searched for, reaches that obstacles put in doubt are tried from few starts.
    In the position that is found they are asked whole. Who fits there by the one and not by the
    other is searched for again with all starts everywhere. Who reaches there what few starts missed
    is searched for again from the posture that reaches it.
    """
    first = search.best.rows(np.arange(len(search.who)))
    _scan(search, positions)
    _try_between(search, positions)
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
            again = search.of(people, first, few_starts=few_starts)
            _search_travel(again, positions)
            search.best.take(people, again.best)
    # who is proved to be kept from something everywhere, or misses what is the same everywhere, fits
    # nowhere
    movable = _movable(search.place, search.asked)
    nowhere = ~search.counted[:, movable].all(axis=1)
    nowhere |= (search.fixed.margin[:, ~movable] < -MET).any(axis=1)
    search.best.window[nowhere] = np.nan


def _judge_whole(search: _Search) -> None:
    """Judge whole, in the best position of each, those who were not yet: each reach with all starts,
    and with how much is to spare."""
    best = search.best
    asks = search.moved | ~search.whole
    if search.coarse:
        asks = search.moved & (search.score < -MET)
    if search.begun:
        hangs = np.zeros(len(asks), dtype=np.bool_)
        hangs[_hang_on_reaches(search.wanted, search.asked, best.tried.margin, anywhere=False)] = (
            True
        )
        asks &= hangs | (search.score >= -MET)
    for moved in (False, True):  # who stays sits as comfortable people do, to the last digit
        people = np.flatnonzero(asks & (search.moved == moved))
        if not len(people):
            continue
        there = [situation.rows(people) for situation in search.wanted]
        if moved:
            positions = best.tried.seat[people]
            there = in_positions(search.place, search.who.rows(people), positions, there)
        known = search.remembered.rows(people)
        whole = tried(_whole(_remembering(there, known)), search.asked)
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
    or what depends on where these are, or their hands do not get to what they hold. anywhere: all
    who miss any of that."""
    hangs = np.array(
        [
            CHECKS[one.requirement.check].cost == REACHING or needs_hands(situations[one.case], one)
            for one in asked
        ]
    )
    missed = margin < -MET
    elsewhere = missed[:, ~hangs].any(axis=1) & (not anywhere)
    return np.flatnonzero((missed[:, hangs].any(axis=1) | _kept_hands(situations)) & ~elsewhere)


def _kept_hands(situations: Sequence[Situation]) -> Bools:
    """(B,) whose hands were brought to what they hold in some case and do not get there."""
    kept = np.zeros(len(situations[0]), dtype=np.bool_)
    for situation in situations:
        if situation.hands_placed:
            for hand, miss in with_hands(situation).hand_miss.items():
                kept |= (miss > 0) | (with_hands(situation).hand_overlap[hand] > 0)
    return kept


def _near_misses(search: _Search) -> Ints:
    """The people who fit nowhere, but nearly do."""
    near = (search.score < -MET) & (search.score > -NEAR_MISS) & (not search.coarse)
    return np.flatnonzero(near & search.unrefined)


def _try_neighbours(search: _Search, people: Ints, step: float) -> None:
    """Try the eight neighbours of the best position of people (N,), at a distance [m]."""
    centres = np.repeat(search.best.tried.seat[people], len(_AROUND), axis=0)
    ways = np.tile(np.array(_AROUND, dtype=np.float64), (len(people), 1))
    wanted = _within_travel(search, centres + step * ways)
    _try_positions(search, np.repeat(people, len(_AROUND)), wanted)


def _within_travel(search: _Search, positions: Floats) -> Floats:
    """Positions (N, 2) [m], brought into the travel of the seat."""
    low, high = np.array(search.place.travel).T
    return np.clip(positions, low, high)


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
    there; before: see `fitted_positions`."""

    place: Workplace
    asked: Sequence[Asked]
    members: Bools
    who: Occupants
    comfortable: Sequence[Situation]
    found: FittedBody
    remembered: Remembered
    before: Before | None
    proceed: Callable[[], None]

    @cached_property
    def known(self) -> Bools:
        """(B,) of whom it is known at which settings and where a change may let them fit."""
        return np.zeros(len(self.who), dtype=np.bool_) if self.before is None else self.before.known

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
        positions = lattice(self.place.travel, spacing_of(self.place))

        def scan(search: _Search) -> None:
            _try_positions(search, np.arange(len(search.who)), search.comfortable)
            _scan(search, positions)

        for setting in settings:
            left = self.left
            self._tried_at(setting, left[~self.known[left]], scan)
            if self.before is not None:
                left = left[self.known[left]]
                left = left[_may_fit_at(setting, positions, self.before.rows(left))]
                changed = partial(_scan, positions=positions)
                self._tried_at(setting, left, changed, before=self.before.rows(left))
        if len(positions) > 1:
            self._refine_at_best()
        for setting in np.unique(self.found.setting[self.moved], axis=0):
            self._judge_whole(setting)

    def _comfortable_at(self, place: Workplace, people: Ints) -> list[Situation]:
        """Some people (N,) in the comfortable position of the workplace in a setting."""
        before = [situation.rows(people) for situation in self.comfortable]
        taken = _taken_again(self.place, place, before)
        return comfortable_situations(place, self.who.rows(people), taken)

    def _judge_whole(self, setting: Floats) -> None:
        """Judge whole those who are best off at a setting (A,)."""
        people = np.flatnonzero(self.moved & (self.found.setting == setting).all(axis=1))
        place = at_setting(self.place, setting)
        who = self.who.rows(people)
        wanted = self._comfortable_at(place, people)
        there = in_positions(place, who, self.found.tried.seat[people], wanted)
        there = _remembering(there, self.remembered.elsewhere().rows(people))
        whole = tried(_whole(there), renewed(place, self.asked))
        self.found.tried.take(people, whole)

    def _tried_at(
        self,
        setting: Floats,
        people: Ints,
        trying: Callable[[_Search], None],
        *,
        before: Before | None = None,
    ) -> None:
        """Try some people (N,) at a setting (A,)."""
        if not len(people):
            return
        place = at_setting(self.place, setting)
        asked = renewed(place, self.asked)
        who = self.who.rows(people)
        wanted = self._comfortable_at(place, people)
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
            before=before,
            notes=self.before is None and bool(self.members.shape[1]),
        )
        trying(search)
        self.found.take(people, best)
        self.moved[people[search.moved]] = True

    def _refine_at_best(self) -> None:
        """Try the neighbours of the best position at its setting, where that is not the nominal
        one."""
        left = self.left
        left = left[~self.known[left] | (self.score[left] > -WITHIN_NEIGHBOURS)]
        nominal = nominal_setting(self.place)
        for setting in np.unique(self.found.setting[left], axis=0):
            if not np.array_equal(setting, nominal):
                mine = (self.found.setting[left] == setting).all(axis=1)
                self._tried_at(setting, left[mine], _refine)


def _may_fit_at(setting: Floats, positions: Floats, before: Before) -> Bools:
    """(B,) whom a change may let fit at a setting (A,): where they were judged there before, or in a
    travel (of the lattice `positions`) that has become longer."""
    if _outside(positions, before.travel).any():
        return np.ones(len(before.known), dtype=np.bool_)
    return np.asarray(_at_the_setting(before, setting).any(axis=1))


def _margins_anywhere(wanted: Sequence[Situation], asked: Sequence[Asked]) -> Margins:
    """The margins of the requirements that are the same in every position, NaN of the others."""
    people = len(wanted[0])
    same = np.flatnonzero(~_movable(wanted[0].place, asked))
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
) -> Sequence[TakenPlaces]:
    """The places that people have taken in a workplace, where they take the same ones in another;
    else nothing."""
    for case in range(len(place.cases)):
        one, two = (content_key("seating", seating_of(each, case)) for each in (place, other))
        if one != two:
            return ()
    return [situation.taken for situation in situations]
