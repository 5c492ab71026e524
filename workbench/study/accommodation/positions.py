"""Find for each person the seat position in which every requirement is met.

A person fits a workplace if some position within the travel of the seat meets all requirements at
once. The comfortable position comes first. For people who miss something there, the travel is
searched:

1. Positions on a lattice over the whole travel are tried, at most ``SPACING`` apart and with the
   ends of the travel. What seating alone answers is asked first (view, pedals). Clearances and
   reaches follow only where a person may do better than in the positions so far.
2. Where no position fits, the neighbours of the best one are tried at halved distances down to
   ``FINEST``.

The same search says who would fit if a requirement were dropped: each of several sets of
requirements counts as met where some position meets all of it.

A person who fits only within a region smaller than the lattice, away from the best position that
was tried, is not found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.accommodation import MET, AccommodationStudy
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Seat
from workbench.study.accommodation.requirements import Asked
from workbench.study.accommodation.sitters import Sitters, join_sitters, seated_at
from workbench.study.accommodation.tried import Tried, judged, sitting

__all__ = ["FINEST", "SPACING", "Before", "Fitted", "fitted_positions", "lattice"]

SPACING = 0.03
"""Distance [m] between neighbours of the lattice, at most."""
FINEST = 0.0075
"""Distance [m] down to which the neighbours of the best position are tried."""
WAVE = 8
"""Positions of the lattice that are tried at a time."""
MOST_ROWS = 512
"""People in positions that are judged at a time, which bounds the memory."""
_FIRST = ("eye_height", "view_over", "pedals")
"""Checks that seating alone answers: they come first."""
_NOWHERE = ("preferred_seat",)
"""Checks whose margin is the same in every position."""
_AROUND = ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1))


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
        that fit. NaN where none fits, and where the comfortable one does: then no other is tried.
    sets
        (B, K) whether some position meets all requirements of each set.
    """

    tried: Tried
    comfortable: Floats
    window: Floats
    sets: Bools


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
    """Who is searched for, and what was found so far; `best` is in the order of these people.

    score (B,) [m]: the least margin in the best position of the requirements that depend on it.
    """

    study: AccommodationStudy
    asked: Sequence[Asked]
    members: Bools
    body: Body
    rows: Ints
    best: Fitted
    score: Floats


def fitted_positions(
    study: AccommodationStudy,
    asked: Sequence[Asked],
    members: Bools,
    sitters: Sitters,
    rows: Sequence[int],
    before: Before | None = None,
) -> Fitted:
    """Judge people in the fitting position nearest to the comfortable one.

    Parameters
    ----------
    members
        (R, K) the requirements of each set.
    sitters
        B people in their comfortable positions.
    rows
        (B,) their rows in the study's population.
    before
        Of a changed design: how the same people came out without the change. Who met everything
        where he sits, and still meets what the change bears on, is asked nothing else.
    """
    if before is None:
        tried = judged(study, asked, sitting(study, asked, sitters))
    else:
        tried = _judged_again(study, asked, sitters, before)
    comfortable = tried.seat.copy()
    window = np.full((len(comfortable), 4), np.nan)
    found = Fitted(tried, comfortable, window, _met_sets(tried.margin, members))
    positions = lattice(study.environment.seat(study.seat))
    short = np.flatnonzero((tried.margin[:, _movable(asked)] < -MET).any(axis=1))
    if len(positions) < 2 or not len(short):
        return found
    best = Fitted(tried.rows(short), comfortable[short], window[short], found.sets[short])
    score = _score(best.tried.margin, asked)
    numbers = np.asarray(rows)[short]
    search = _Search(study, asked, members, sitters.body[short], numbers, best, score)
    _scan(search, positions)
    _refine(search)
    tried.put(short, best.tried)
    window[short] = best.window
    found.sets[short] = best.sets
    return found


def _judged_again(
    study: AccommodationStudy, asked: Sequence[Asked], sitters: Sitters, before: Before
) -> Tried:
    """People of a changed design in their comfortable positions."""
    people = len(sitters.seat)
    nothing = np.full((people, len(asked)), "", dtype=object)
    toward = np.full((people, len(asked), 3), np.nan)
    seat = np.stack([sitters.seat.forward, sitters.seat.up], axis=1)
    tried = Tried(before.margin.copy(), nothing, toward, seat)
    borne = np.array(before.borne, dtype=np.int64)
    stays = np.flatnonzero(before.stays)
    if len(stays) and len(borne):
        some = [asked[r] for r in before.borne]
        again = judged(study, some, sitting(study, some, sitters.rows(stays)))
        tried.margin[np.ix_(stays, borne)] = again.margin
    short = (tried.margin < -MET).any(axis=1) | ~before.stays
    rest = np.flatnonzero(short)
    if len(rest):
        tried.put(rest, judged(study, asked, sitting(study, asked, sitters.rows(rest))))
    return tried


def lattice(seat: Seat) -> Floats:
    """(M, 2) [m] positions all over the travel of a seat, forward and up, with its ends."""
    axes = [_axis(*seat.travel_forward), _axis(*seat.travel_up)]
    forward, up = np.meshgrid(*axes, indexing="ij")
    return np.stack([forward.ravel(), up.ravel()], axis=1)


def _axis(low: float, high: float) -> Floats:
    return np.linspace(low, high, 1 + int(np.ceil((high - low) / SPACING - 1e-9)))


def _movable(asked: Sequence[Asked]) -> Bools:
    """(R,) the requirements whose margins depend on the position."""
    return np.array([one.requirement.check not in _NOWHERE for one in asked], dtype=np.bool_)


def _score(margin: Floats, asked: Sequence[Asked]) -> Floats:
    """(B,) [m] the least margin of the requirements that depend on the position."""
    known = np.where(np.isnan(margin), np.inf, margin)[:, _movable(asked)]
    score: Floats = known.min(axis=1, initial=np.inf)
    return score


def _met_sets(margin: Floats, members: Bools) -> Bools:
    """(B, K) whether margins (B, R) [m] meet all requirements of each set (R, K)."""
    missed = (margin < -MET).astype(np.int64) @ members.astype(np.int64)
    return np.asarray(missed == 0, dtype=np.bool_)


def _scan(search: _Search, positions: Floats) -> None:
    """Try the lattice, for each person the nearest to the comfortable position first. Where no set
    is asked for, who fits is asked no further."""
    way = np.linalg.norm(positions[None] - search.best.comfortable[:, None], axis=2)
    order = np.argsort(way, axis=1, kind="stable")
    for first in range(0, len(positions), WAVE):
        people = np.arange(len(order))
        if not search.members.shape[1]:
            people = np.flatnonzero(search.score < -MET)
        some = order[people, first : first + WAVE]
        _try_positions(search, np.repeat(people, some.shape[1]), positions[some.ravel()])


def _try_positions(search: _Search, people: Ints, positions: Floats) -> None:
    """Judge people (N,) of the search in positions (N, 2), one each, and keep what is better.

    All are judged in batches: a call costs more than a person.
    """
    seats: list[Sitters] = []
    whose: list[Ints] = []
    for position, some in _groups(positions):
        who = people[some]
        place = tuple(position.tolist())
        seats.append(seated_at(search.study, search.body[who], search.rows[who].tolist(), place))
        whose.append(who)
    for part in _batches([len(rows) for rows in whose]):
        _judge(search, np.concatenate(whose[part]), join_sitters(seats[part]))


def _batches(sizes: Sequence[int]) -> Iterator[slice]:
    """Parts of a list whose sizes come to MOST_ROWS at most, or that have one entry."""
    first = 0
    total = 0
    for last, size in enumerate(sizes):
        if last > first and total + size > MOST_ROWS:
            yield slice(first, last)
            first = last
            total = 0
        total += size
    if sizes:
        yield slice(first, len(sizes))


def _judge(search: _Search, people: Ints, sitters: Sitters) -> None:
    """Judge people (N,) of the search, each where it sits, and keep what is better.

    What costs least is asked first, and what follows only of those who may still do better in
    their position, or meet another set.
    """
    best = search.best
    count = len(search.asked)
    margin = np.full((len(people), count), np.nan)
    words = np.full(margin.shape, "", dtype=object)
    toward = np.full((*margin.shape, 3), np.nan)
    seat = np.stack([sitters.seat.forward, sitters.seat.up], axis=1)
    same = np.flatnonzero(~_movable(search.asked))
    margin[:, same] = best.tried.margin[np.ix_(people, same)]
    left = np.arange(len(people))
    known = ~_movable(search.asked)
    for stage in _stages(search.asked):
        if not stage.any():
            continue
        rows = np.flatnonzero(stage)
        asked = [search.asked[r] for r in rows.tolist()]
        some = sitters.rows(left)
        tried = judged(search.study, asked, sitting(search.study, asked, some))
        margin[np.ix_(left, rows)] = tried.margin
        words[np.ix_(left, rows)] = tried.words
        toward[np.ix_(left, rows)] = tried.toward
        known = known | stage
        left = left[_hopeful(search, people[left], margin[left], known)]
        if not len(left):
            return
    _keep(search, people[left], Tried(margin[left], words[left], toward[left], seat[left]))


def _stages(asked: Sequence[Asked]) -> list[Bools]:
    """The requirements (R,) that are asked one after the other: by seating alone, then where the
    body is, then reaches."""
    checks = np.array([one.requirement.check for one in asked])
    first = np.isin(checks, _FIRST)
    last = checks == "reach"
    return [first, ~first & ~last & _movable(asked), last]


def _hopeful(search: _Search, people: Ints, margin: Floats, known: Bools) -> Ints:
    """The rows of people (N,) who may do better than in their best position, or meet another set,
    as far as the requirements (R,) that are known say."""
    movable = known & _movable(search.asked)
    least = np.where(np.isnan(margin), np.inf, margin)[:, movable].min(axis=1, initial=np.inf)
    better = least > np.minimum(search.score[people], -MET)
    sets = _met_sets(margin[:, known], search.members[known])
    return np.flatnonzero(better | (sets & ~search.best.sets[people]).any(axis=1))


def _keep(search: _Search, people: Ints, tried: Tried) -> None:
    """Take up what became of people (N,) in positions."""
    best = search.best
    np.logical_or.at(best.sets, people, _met_sets(tried.margin, search.members))
    score = _score(tried.margin, search.asked)
    for row in np.flatnonzero(score >= -MET).tolist():
        _widen(best.window[people[row]], tried.seat[row])
    for row, person in enumerate(people.tolist()):
        if _is_better(search, person, float(score[row]), tried.seat[row]):
            best.tried.put(np.array([person]), tried.rows(np.array([row])))
            search.score[person] = score[row]


def _is_better(search: _Search, person: int, score: float, position: Floats) -> bool:
    """Whether a position is better than the best so far: one that fits before one that does not,
    of those that fit the nearer to the comfortable one, else that of the greater least margin."""
    before = float(search.score[person])
    if score >= -MET and before >= -MET:
        comfortable = search.best.comfortable[person]
        known = np.linalg.norm(search.best.tried.seat[person] - comfortable)
        return bool(np.linalg.norm(position - comfortable) < known - 1e-9)
    return score > before


def _widen(window: Floats, position: Floats) -> None:
    """Take a position that fits into the window (4,) of a person."""
    window[::2] = np.fmin(window[::2], position)
    window[1::2] = np.fmax(window[1::2], position)


def _refine(search: _Search) -> None:
    """Try the neighbours of the best position of those for whom none fits, nearer and nearer."""
    seat = search.study.environment.seat(search.study.seat)
    low, high = np.array([seat.travel_forward, seat.travel_up]).T
    step = SPACING / 2
    while step >= FINEST - 1e-9:
        people = np.flatnonzero(search.score < -MET)
        if not len(people):
            return
        centres = np.repeat(search.best.tried.seat[people], len(_AROUND), axis=0)
        ways = np.tile(np.array(_AROUND, dtype=np.float64), (len(people), 1))
        wanted = np.clip(centres + step * ways, low, high)
        _try_positions(search, np.repeat(people, len(_AROUND)), wanted)
        step /= 2


def _groups(positions: Floats) -> Iterator[tuple[Floats, Ints]]:
    """The distinct positions of (B, 2), with the rows that have each."""
    distinct, which = np.unique(np.round(positions, 6), axis=0, return_inverse=True)
    for k, position in enumerate(distinct):
        yield position, np.flatnonzero(which.ravel() == k)
