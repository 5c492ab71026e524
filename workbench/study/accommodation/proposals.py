"""Changes of a design that would let more people meet everything, looked for in the margins.

Moving a control toward a person's shoulder lets the margin grow as much as the way gets shorter; so
does a part that is moved away from the sphere it is nearest to. A seat that goes beyond the end of
its travel carries along who sits at that end: what they reach for comes nearer as if it were moved
the other way. So does a step beyond the area in which people may step. So the margins say, to first order, who would meet what with a change made. What it
really gains is what a run with it says (see gains).

1. For each requirement that somebody misses, the straight moves of its control or parts are looked
   at; for the sitters' own seat, each end of its travel; of an area to step in, each of its ends. Who may sit or stand elsewhere is looked at in
   each place that was judged: a move there lets somebody fit who has given way in all the others.
2. Of each, the shortest move is taken that gains nearly as much as the best one does.
3. Two of them together are looked at where people are left out whom neither helps alone.
4. A move that would put a part into another one is cut down to the longest that does not.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from workbench.model.accommodation import Change, met_of
from workbench.model.arrays import Bools, Floats, Ints, xyz
from workbench.model.surroundings import Move, moved_controls, parts_along
from workbench.model.workplace import Workplace
from workbench.posture.seating.seating import leftward
from workbench.study.accommodation.changes import enters, enters_words
from workbench.study.accommodation.checkpoints import Chunk, PopulationQuestion
from workbench.study.accommodation.population_bodies import PopulationBodies
from workbench.study.accommodation.shares import share_single, share_without
from workbench.study.accommodation.sight_moves import SightMoves
from workbench.study.checks.view import TOO_LOW

__all__ = ["MOST_MOVE", "Proposal", "growth", "kept_by_ends", "proposals", "shortest"]

MOST_MOVE = 0.1
"""The longest move [m] that is looked at."""
STEP = 1e-3
"""[m] between the moves that are tried; what is nearer to an end of travel is at it."""
PAIR_STEP = 1e-2
"""[m] between the moves of two things together."""
MOST_PAIRED = 6
"""Controls and parts that are looked at two together: those whose requirements are missed most."""
MOST_PAIRS = 2
"""Proposals of two moves together, at most."""
SLACK = 1e-6
"""[m] More than rounding makes of a margin that has grown by the longest moves."""
NEEDED = 0.1
"""The part of what two moves gain together that is gained by people whom neither helps alone; with
less, two single proposals say as much."""
ENOUGH = 0.95
"""The part of what the best move would gain that the shortest one which is proposed must gain."""
_ENDS = (
    ("travel_forward", -1, "farther back"),
    ("travel_forward", 1, "farther forward"),
    ("travel_up", -1, "lower"),
    ("travel_up", 1, "higher"),
)
"""The ends of the seat's travel: which travel, outward, and what going beyond it is called."""
_OF_AREA = {
    "farther back": ("farther back", "rear"),
    "farther forward": ("farther forward", "front"),
    "lower": ("farther to the right", "right"),
    "higher": ("farther to the left", "left"),
}
"""The same of an area to step in: what going beyond an end is called, and the end."""
KEEPS = 0.2
"""An end keeps somebody from what is missed where its margin grows by so much with a metre beyond."""
_DEGREES = 100.0
"""What is turned turns by so many degrees where something else would move by a metre."""
_ASIDE = 0.7
"""Sine of the angle between where a mirror looks and a side to which it may look farther, at least."""
_SEAT_WORDS = "letting the seat go "
_STEP_WORDS = "letting people step "
MOST_NAMED = 3
"""Parts that are moved together, at most: more have no name in a sentence."""
_OF_PARTS = ("clearance", "contact", "view_over", "over_nose")
"""Checks that may be about parts, which give way to them."""


@dataclass(frozen=True, eq=False)
class _Way:
    """A straight way for something, and what it does to the margins to first order.

    thing, words: what is moved, and where to; rows: the requirements that it changes; slope
    (P, len(rows)): by how much their margins grow with a metre of it; change: as a metre of it is
    made. optional: of a seat, which nobody must take farther than suits.
    """

    thing: str
    words: str
    rows: tuple[int, ...]
    slope: Floats
    change: Change
    optional: bool = False

    def by(self, amount: float) -> Change:
        """The change with so much [m] of the way gone."""
        unit = self.change
        much = f"{1000 * amount:.0f} mm" if unit.size else f"{_DEGREES * amount:.1f} degrees"
        return Change(
            self.words.format(much),
            tuple(move.times(amount) for move in unit.moves),
            _scaled(unit.travel_forward, amount),
            _scaled(unit.travel_up, amount),
        )


@dataclass(frozen=True, eq=False)
class Proposal:
    """A change that lets more people meet everything, as far as the margins say.

    Parameters
    ----------
    change
        None where every move that would gain anything puts a part into another one.
    requirement
        The number of the one that it is for.
    share, served
        The share that would meet everything, and who would (P,).
    limit
        That a longer move would put a part into another one; "" where it is not cut down.
    """

    change: Change | None
    requirement: int
    share: float
    served: Bools
    limit: str


def proposals(
    question: PopulationQuestion, bodies: PopulationBodies, found: Chunk
) -> Iterator[Proposal]:
    """Changes that let more people meet everything, as far as the margins say: first those that let
    most people meet everything."""
    met = met_of(found.margin)
    weight = question.people.weight
    without = share_without(found.sets[:, : len(question.asked)], weight)
    single = share_single(met, weight)
    missed = [r for r in np.lexsort((single, -without)).tolist() if single[r] < 1.0]
    things = [_moved_ways(question, found, r) for r in missed]
    seat = _seat_ways(question, found)
    seen = _sight_ways(question, SightMoves(question, bodies, found), found)
    best = [
        one
        for ways in (*things, *seen, *([way] for way in seat))
        if (one := _single(question.place, found, ways, weight)) is not None
    ]
    helpful = [
        _most_helpful(found, ways, r, weight) for ways, r in zip(things, missed, strict=True)
    ]
    paired = [way for way in helpful if way is not None]
    pairs = [
        one
        for two in combinations([*_each_once(paired)[:MOST_PAIRED], *seat], 2)
        if (one := _pair(question.place, found, two, weight)) is not None
    ]
    pairs.sort(key=lambda one: -one.share)
    once = {one.change or one.limit: one for one in (*best, *pairs[:MOST_PAIRS])}
    yield from sorted(once.values(), key=lambda one: -one.share)


def growth(question: PopulationQuestion, found: Chunk, change: Change, r: int) -> Floats:
    """(P,) by how much each person's margin of the requirement r grows with a metre of a change: for
    a start, and as long as nothing else gets in the way."""
    total = np.zeros(len(found.margin))
    if change.size == 0:
        return total
    for move in change.moves:
        if r in _rows(question, move):
            total += np.nan_to_num(found.toward[:, r] @ np.array(move.by))
    for travel, outward, _ in _ENDS:
        amount = outward * getattr(change, travel)[int(outward > 0)]
        if amount > 0:
            total += amount * _seat_slope(question, found, travel, outward)[:, r]
    return total / change.size


def _rows(question: PopulationQuestion, move: Move) -> tuple[int, ...]:
    """The requirements whose margins a move changes as `toward` says: reaches of what is moved, and
    what is asked about nothing but parts that are moved."""
    controls = set(moved_controls(question.place.environment, [move]))
    parts = set(move.parts)
    return tuple(
        r
        for r, one in enumerate(question.asked)
        if (one.control is not None and one.control.name in controls)
        or (
            one.control is None
            and one.requirement.check in _OF_PARTS
            and one.criterion.parts
            and parts >= set(one.criterion.parts)
        )
    )


def shortest(shares: Floats, now: float) -> int | None:
    """The first of some shares (M,) that gains ENOUGH of what the best does over that of now; None
    where none gains."""
    best = float(shares.max(initial=now))
    if best <= now + 1e-9:
        return None
    return int(np.argmax(shares >= now + ENOUGH * (best - now) - 1e-12))


def _scaled(ends: tuple[float, float], amount: float) -> tuple[float, float]:
    return ends[0] * amount, ends[1] * amount


def _moved_ways(question: PopulationQuestion, found: Chunk, r: int) -> list[_Way]:
    """The straight ways of the control or the parts that a requirement is about; none where it is
    about neither."""
    one = question.asked[r]
    if one.control is None and (one.requirement.check not in _OF_PARTS or not one.criterion.parts):
        return []
    environment = question.place.environment
    name = one.requirement.target
    parts, controls = tuple(one.criterion.parts), tuple[str, ...]()
    seats = {part for seat in environment.seats for part in (*seat.moves, *seat.parts)}
    if one.control is None and (len(parts) > MOST_NAMED or seats & set(parts)):
        return []  # whoever sits goes along with a seat, and what moves must have a name
    if one.control is not None:
        name = one.control.name
        parts = parts_along(environment, (name,))
        controls = () if one.control.part in parts else (name,)
    rows = _rows(question, Move(parts, controls, (0.0, 0.0, 0.0)))
    toward = np.nan_to_num(found.toward[:, rows])
    return [
        _Way(
            thing=name,
            words=f"moving {name} {{}} {word}",
            rows=rows,
            slope=toward @ axis,
            change=Change("", (Move(parts, controls, xyz(axis)),)),
        )
        for word, axis in _axes(question.place).items()
    ]


def _sight_ways(
    question: PopulationQuestion, moves: SightMoves, found: Chunk
) -> Iterator[list[_Way]]:
    """The straight ways of what hides things from people, of what they look at, and of the seat beyond
    each end of its travel, as far as somebody sees by them what he missed."""
    rows = tuple(range(found.margin.shape[1]))
    axes = _axes(question.place)
    mirrors = question.place.environment.mirrors
    for name, thing in moves.things() if len(moves.people) else ():
        moved = {
            f"moving {name} {{}} {word}": replace(thing, by=xyz(axis))
            for word, axis in axes.items()
        }
        turned = [
            _turns(name, thing, np.array(mirror.normal), axes)
            for mirror in mirrors
            if (mirror.part,) == thing.parts and mirror.aims is None
        ]
        for tried in (moved, *turned):
            ways = [
                _Way(name, words, rows, slope, Change("", (move,)))
                for words, move in tried.items()
                if (slope := moves.slope(move)).any()
            ]
            yield ways
    seat = question.place.own_seat
    for travel, outward, words in _ENDS if seat is not None and len(moves.people) else ():
        along = travel == "travel_forward"
        at_end = np.flatnonzero(_at_end(question.place, found.seat, travel, outward))
        slope = moves.of_seat(outward * np.array([along, not along], dtype=np.float64), at_end)
        yield [_seat_way(question.place, travel, outward, words, slope)] if slope.any() else []


def _turns(name: str, mirror: Move, normal: Floats, axes: Mapping[str, Floats]) -> dict[str, Move]:
    """A mirror with a unit normal (3,) turned so that it looks farther to each side, by words."""
    found = {}
    for word, axis in axes.items():
        across = np.cross(normal, axis)
        if (length := float(np.linalg.norm(across))) > _ASIDE:
            turn = xyz(np.radians(_DEGREES) * across / length)
            found[f"turning {name} {{}} to look farther {word}"] = replace(mirror, turn=turn)
    return found


def _axes(place: Workplace) -> dict[str, Floats]:
    """(3,) the unit vectors along which something may be moved, by what they are called."""
    side = leftward(place)
    ahead = np.array([side[1], -side[0], 0.0])
    up = np.array([0.0, 0.0, 1.0])
    return {
        "aft": -ahead,
        "forward": ahead,
        "up": up,
        "down": -up,
        "to the left": side,
        "to the right": -side,
    }


def _seat_ways(question: PopulationQuestion, found: Chunk) -> list[_Way]:
    """Going on beyond each end of the travel of the sitters' own seat, or of the area to step in; none
    where nobody is there who would gain by it."""
    if not question.place.goes:
        return []
    missed = ~met_of(found.margin)
    ways = []
    for travel, outward, words in _ENDS:
        slope = _seat_slope(question, found, travel, outward)
        if not (missed & (slope > 0)).any():
            continue
        ways.append(_seat_way(question.place, travel, outward, words, slope))
    return ways


def _seat_way(place: Workplace, travel: str, outward: int, words: str, slope: Floats) -> _Way:
    """Going on beyond an end of the seat's travel, or of the area to step in."""
    ends = (0.0, 1.0) if outward > 0 else (-1.0, 0.0)
    along = travel == "travel_forward"
    change = Change("", travel_forward=ends) if along else Change("", travel_up=ends)
    rows = tuple(range(slope.shape[1]))
    if place.own_seat is None:
        said = f"{_STEP_WORDS}{{}} {_OF_AREA[words][0]}"
        return _Way("area", said, rows, slope, change, True)
    return _Way("seat", f"{_SEAT_WORDS}{{}} {words}", rows, slope, change, True)


def _at_end(place: Workplace, positions: Floats, travel: str, outward: int) -> Bools:
    """(P,) who is at an end of the travel of a seat or an area, by positions (P, 2) [m]. Where an area
    does not go at all it has no end."""
    axis = int(travel != "travel_forward")
    ends = place.travel[axis]
    there = place.own_seat is not None or ends[0] < ends[1]
    return np.asarray(there & (np.abs(positions[:, axis] - ends[int(outward > 0)]) < STEP))


def kept_by_ends(question: PopulationQuestion, found: Chunk) -> dict[str, Bools]:
    """Who (P,) of those left out stands at an end of the area to step in, beyond which the worst missed
    requirement would be missed by less, by what the end is called; nobody where nobody steps."""
    at = np.nan_to_num(found.margin, nan=np.inf).argmin(axis=1)[:, None]
    left_out = ~met_of(found.margin).all(axis=1)
    kept = {}
    for travel, outward, words in _ENDS if question.place.own_seat is None else ():
        slope = np.take_along_axis(_seat_slope(question, found, travel, outward), at, axis=1)
        who = left_out & (slope[:, 0] > KEEPS)
        if who.any():
            kept[_OF_AREA[words][1]] = who
    return kept


def _seat_slope(question: PopulationQuestion, found: Chunk, travel: str, outward: int) -> Floats:
    """(P, R) by how much the margins of those who sit at an end of the seat's travel grow with a
    metre beyond it: 0 of everybody else, and of what is not known."""
    place = question.place
    if not place.goes:
        return np.zeros(found.margin.shape)
    along = travel == "travel_forward"
    at_end = _at_end(place, found.seat, travel, outward)
    wanted = _at_end(place, found.comfortable, travel, outward)
    second = "up" if place.own_seat is not None else "to the left"
    way = outward * _axes(place)["forward" if along else second]
    missed = ~met_of(found.margin)
    slope = np.zeros(found.margin.shape)
    for r, one in enumerate(question.asked):
        check = one.requirement.check
        if check in ("reach", "clearance", "contact", "over_nose"):
            slope[:, r] = -np.nan_to_num(found.toward[:, r] @ way)
        elif check in ("pedals", "preferred_seat") and along:
            slope[:, r] = missed[:, r]
        elif check in ("eye_height", "view_over") and second == "up" and not along:
            low = np.array([k >= 0 and found.words[k] == TOO_LOW for k in found.reason[:, r]])
            # who meets it and sits at the end would sit farther for the eyes' sake
            slope[:, r] = np.where(missed[:, r], np.where(low, outward, -outward), wanted * 2.0 - 1)
    found_slope: Floats = slope * at_end[:, None]
    return found_slope


def _served(found: Chunk, ways: Sequence[_Way], steps: Sequence[Floats]) -> Bools:
    """(M, ..., P) who would meet everything with each of the amounts [m] (M,) of one way, or of two
    with each of the amounts of either."""
    rows = sorted({r for way in ways for r in way.rows})
    people = len(found.margin)
    margin, person = _in_places(found)
    kept = np.flatnonzero(np.delete(met_of(margin), rows, axis=1).all(axis=1))
    margin, person = margin[kept][:, rows], person[kept]
    slopes = []
    for way in ways:
        slope = np.zeros(margin.shape)
        slope[:, [rows.index(r) for r in way.rows]] = way.slope[person]
        if way.optional:
            slope[kept >= people] = 0.0  # an end of the travel is known where people sit at it
        slopes.append(slope)
    # who misses something by more than the longest moves bring, or that none brings, is not served
    most = sum(
        amounts.max() * np.maximum(slope, 0.0) for amounts, slope in zip(steps, slopes, strict=True)
    )
    may = met_of(margin + most + SLACK).all(axis=1)
    margin, person, slopes = margin[may], person[may], [slope[may] for slope in slopes]
    shape = tuple(len(amounts) for amounts in steps)
    served = np.zeros((*shape, people), dtype=np.bool_)
    for at in np.ndindex(shape):
        more = sum(amounts[k] * slope for amounts, k, slope in zip(steps, at, slopes, strict=True))
        served[at][person[met_of(margin + more).all(axis=1)]] = True
    for axis, way in enumerate(ways):
        if way.optional:
            served = np.logical_or.accumulate(served, axis=axis)
    return served


def _in_places(found: Chunk) -> tuple[Floats, Ints]:
    """(P + N, R) [m] the margins of everybody where they are found, then of some in each of the N
    other places that were judged, in any setting, and (P + N,) whose they are. What is not known there counts as
    missed."""
    there = found.judged_margin
    asked = ~np.isnan(found.margin[found.judged_person])
    there = np.where(np.isnan(there) & asked, -np.inf, there)
    person = np.concatenate([np.arange(len(found.margin)), found.judged_person])
    return np.concatenate([found.margin, there]), person


def _single(
    place: Workplace, found: Chunk, ways: Sequence[_Way], weight: Floats
) -> Proposal | None:
    """The shortest move along one of some ways that gains about as much as the best, of those that put
    no part into another one."""
    if not ways:
        return None
    steps = STEP * np.arange(round(MOST_MOVE / STEP) + 1, dtype=np.float64)
    served = [_served(found, [way], [steps]) for way in ways]
    shares = np.stack([one @ weight / weight.sum() for one in served], axis=1)
    now = float(shares[0, 0])
    refused: Proposal | None = None
    while (m := shortest(shares.max(axis=1), now)) is not None:
        k = int(np.argmax(shares[m]))
        change = ways[k].by(float(steps[m]))
        r = _most_met(found, [ways[k]], [float(steps[m])], weight)
        into = enters(place, change)
        one = Proposal(change, r, float(shares[m, k]), served[k][m], "")
        if into is None:
            return replace(one, limit=refused.limit) if refused else one
        refused = refused or replace(one, change=None, limit=enters_words(change.words, into))
        shares[_free(place, ways[k], steps[: m + 1]) :, k] = now
    return refused


def _free(place: Workplace, way: _Way, steps: Floats) -> int:
    """The first of some rising amounts [m] of a way by which a part is put into another one."""
    return bisect_left(steps, True, key=lambda amount: enters(place, way.by(amount)) is not None)


def _most_met(found: Chunk, ways: Sequence[_Way], amounts: Sequence[float], weight: Floats) -> int:
    """The requirement that most people would meet with a change who miss it now."""
    margin = found.margin.copy()
    for way, amount in zip(ways, amounts, strict=True):
        margin[:, way.rows] += amount * way.slope
    newly = weight @ (met_of(margin) & ~met_of(found.margin))
    return int(np.argmax(newly)) if newly.any() else ways[0].rows[0]


def _most_helpful(found: Chunk, ways: Sequence[_Way], r: int, weight: Floats) -> _Way | None:
    """The way along which most people would meet one requirement, whatever else they miss; None
    where it lets nobody."""
    missed = ~met_of(found.margin[:, r])
    gained = []
    for way in ways:
        after = found.margin[:, r] + MOST_MOVE * way.slope[:, way.rows.index(r)]
        gained.append(float(weight @ (missed & met_of(after))))
    if not any(gained):
        return None
    return ways[int(np.argmax(gained))]


def _each_once(ways: Sequence[_Way]) -> list[_Way]:
    """The first way of each thing."""
    return list({way.thing: way for way in reversed(ways)}.values())[::-1]


def _pair(place: Workplace, found: Chunk, two: Sequence[_Way], weight: Floats) -> Proposal | None:
    """The shortest two moves together that gain about as much as the best two, of those that put no
    part into another one; None where few of those who gain need both."""
    steps = PAIR_STEP * np.arange(round(MOST_MOVE / PAIR_STEP) + 1, dtype=np.float64)
    served = _served(found, two, [steps, steps])
    alone = served[:, 0].any(axis=0) | served[0].any(axis=0)
    shares = served @ weight / weight.sum()
    now = float(shares[0, 0])
    long = (steps[:, None] + steps[None, :]).ravel()
    limit = ""
    order = np.argsort(long, kind="stable")
    while (first := shortest(shares.ravel()[order], now)) is not None:
        m, k = (int(at) for at in np.unravel_index(order[first], shares.shape))
        both = float(weight @ (served[m, k] & ~alone) / weight.sum())
        if both < NEEDED * (float(shares[m, k]) - now) or both <= 0.0:
            return None
        amounts = [float(steps[m]), float(steps[k])]
        one, other = (way.by(amount) for way, amount in zip(two, amounts, strict=True))
        together = Change(
            _together(one.words, other.words),
            (*one.moves, *other.moves),
            _sum(one.travel_forward, other.travel_forward),
            _sum(one.travel_up, other.travel_up),
        )
        into = enters(place, together)
        if into is None:
            r = _most_met(found, two, amounts, weight)
            return Proposal(together, r, float(shares[m, k]), served[m, k], limit)
        limit = limit or enters_words(together.words, into)
        shares[_free(place, two[0], steps[: m + 1]) :] = now
        shares[:, _free(place, two[1], steps[: k + 1]) :] = now
        shares[m:, k:] = now
    return None


def _together(one: str, other: str) -> str:
    """ "moving knob 20 mm aft and letting the seat go 10 mm higher"; the seat, or who steps, is named
    once."""
    for words in (_SEAT_WORDS, _STEP_WORDS):
        if one.startswith(words):
            other = other.removeprefix(words)
    return f"{one} and {other}"


def _sum(one: tuple[float, float], other: tuple[float, float]) -> tuple[float, float]:
    return one[0] + other[0], one[1] + other[1]
