"""Changes of a design that would let more people meet everything, looked for in the margins.

Moving a control toward a person's shoulder lets the margin grow as much as the way gets shorter; so
do a part that is moved away from the sphere it is nearest to, and a seat's end for who sits at it.
So the margins say, to first order, who would meet what with a change made. What it really gains is
what a run with it says (see gains).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from workbench.model.accommodation import Change, met_of
from workbench.model.arrays import Bools, Floats, xyz
from workbench.model.workplace import Workplace
from workbench.posture.seating.sides import leftward
from workbench.study.accommodation.changes import moved_parts
from workbench.study.accommodation.chunks import Chunk, Question
from workbench.study.accommodation.shares import left_out_alone, share_single
from workbench.study.checks.view import TOO_LOW

__all__ = ["MOST_MOVE", "growth", "proposals", "shortest"]

MOST_MOVE = 0.1
"""The longest move [m] that is looked at."""
OF_THE_SEAT = ("eye_height", "view_over", "pedals", "preferred_seat")
"""The checks for which the ends of the seat's travel are moved."""
STEP = 1e-3
"""[m] between the moves that are tried; what is nearer to an end of travel is at it."""
_MOVES = np.arange(1, round(MOST_MOVE / STEP) + 1) * STEP
ENOUGH = 0.95
"""The part of what the best move would gain that the shortest one which is proposed must gain."""


def proposals(question: Question, found: Chunk) -> Iterator[tuple[Change, int]]:
    """Changes that let more people meet everything, as far as the margins say, with the number of
    the requirement each is for: those first that leave out most people by nothing else."""
    asked = question.asked
    weight = question.people.weight
    met = met_of(found.margin)
    single = share_single(met, weight)
    alone = left_out_alone(met, found.sets[:, : len(asked)], weight)
    tried: set[str] = set()
    for r in np.lexsort((single, -alone)).tolist():
        target = asked[r].requirement.target
        if single[r] >= 1.0 or target in tried:
            continue
        seat = asked[r].requirement.check in OF_THE_SEAT
        change = (_travel if seat else _moved)(question, found, r)
        if change is not None:
            tried.add(target)
            yield change, r


def growth(question: Question, found: Chunk, change: Change, r: int) -> Floats:
    """(P,) by how much each person's margin of the requirement r grows with a unit of a change's
    move: for a start, and as long as nothing else gets in the way."""
    place = question.place
    asked = question.asked
    if change.control or change.parts:
        size = float(np.linalg.norm(change.move))
        if r not in _rows(question, change) or size == 0:
            return np.zeros(len(found.margin))
        return np.nan_to_num(found.toward[:, r] @ (np.array(change.move) / size))
    if asked[r].requirement.check not in OF_THE_SEAT:
        return np.zeros(len(found.margin))
    seat = place.own_seat
    if seat is None:
        return np.zeros(len(found.margin))
    column = 0 if any(change.travel_forward) else 1
    low, high = change.travel_forward if column == 0 else change.travel_up
    ends = seat.travel_forward if column == 0 else seat.travel_up
    at = found.seat[:, column]
    helped = ((np.abs(at - ends[0]) < STEP) & (low < 0)) | (
        (np.abs(at - ends[1]) < STEP) & (high > 0)
    )
    return np.asarray((helped & ~met_of(found.margin[:, r])).astype(np.float64))


def _rows(question: Question, change: Change) -> list[int]:
    """The requirements whose margins a moved control or part changes as `toward` says: reaches of
    what is moved, and clearances to nothing but what is moved."""
    parts = set(moved_parts(question.place.environment, change))
    rows = []
    for r, one in enumerate(question.asked):
        if one.control is not None:
            goes = one.control.part in parts if change.parts else one.control.name == change.control
        else:
            goes = one.requirement.check == "clearance" and parts >= set(one.criterion.parts)
        rows += [r] if goes else []
    return rows


def shortest(shares: Floats, now: float) -> int | None:
    """The first of some shares (M,) that gains ENOUGH of what the best does over that of now; None
    where none gains."""
    best = float(shares.max(initial=now))
    if best <= now + 1e-9:
        return None
    return int(np.argmax(shares >= now + ENOUGH * (best - now) - 1e-12))


def _moved(question: Question, found: Chunk, r: int) -> Change | None:
    """A control or parts moved along an axis: the shortest of the moves that gain about as much as
    the best."""
    one = question.asked[r]
    if one.requirement.check not in ("reach", "clearance"):
        return None
    control = one.control.name if one.control is not None else ""
    parts = () if one.control is not None else one.criterion.parts
    ways = _ways(question.place)
    shares = np.stack(
        [
            _shares_moved(question, found, Change("", control, parts, xyz(axis)))
            for axis in ways.values()
        ],
        axis=1,
    )
    m = shortest(shares.max(axis=1), _joint(met_of(found.margin), question.people.weight))
    if m is None:
        return None
    word = list(ways)[int(np.argmax(shares[m]))]
    move = float(_MOVES[m])
    name = control or one.requirement.target
    words = f"moving {name} {1000 * move:.0f} mm {word}"
    return Change(words, control, parts, xyz(move * ways[word]))


def _ways(place: Workplace) -> dict[str, Floats]:
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


def _shares_moved(question: Question, found: Chunk, change: Change) -> Floats:
    """The share that meets everything after each of the moves along a way, as the margins say."""
    weight = question.people.weight
    rows = _rows(question, change)
    others = np.delete(met_of(found.margin), rows, axis=1).all(axis=1)
    steps = np.nan_to_num(found.toward[:, rows] @ np.array(change.move))
    shares = [
        weight @ (others & met_of(found.margin[:, rows] + move * steps).all(axis=1))
        for move in _MOVES
    ]
    share: Floats = np.array(shares) / weight.sum()
    return share


def _joint(met: Bools, weight: Floats) -> float:
    return float(weight @ met.all(axis=1) / weight.sum())


def _travel(question: Question, found: Chunk, r: int) -> Change | None:
    """The end of the seat's travel, at which those sit who miss the view or the pedals, moved
    outward."""
    seat = question.place.own_seat
    if seat is None:
        return None
    along = question.asked[r].requirement.check in ("pedals", "preferred_seat")
    ends = seat.travel_forward if along else seat.travel_up
    beyond = _wants_upper_end(found, r, ends, along)
    at = found.seat[:, 0 if along else 1]
    at_end = np.abs(at - ends[int(beyond)]) < STEP
    met = met_of(found.margin)
    others = np.delete(met, r, axis=1).all(axis=1)
    weight = question.people.weight
    shares = [
        weight @ (others & met_of(found.margin[:, r] + move * at_end)) / weight.sum()
        for move in _MOVES
    ]
    m = shortest(np.array(shares), _joint(met, weight))
    if m is None:
        return None
    move = float(_MOVES[m])
    ends_moved = (0.0, move) if beyond else (-move, 0.0)
    if along:
        way = "farther forward" if beyond else "farther back"
        words = f"letting the seat go {1000 * move:.0f} mm {way}"
        return Change(words, travel_forward=ends_moved)
    way = "higher" if beyond else "lower"
    return Change(f"letting the seat go {1000 * move:.0f} mm {way}", travel_up=ends_moved)


def _wants_upper_end(found: Chunk, r: int, ends: tuple[float, float], along: bool) -> bool:
    """Whether those who miss a requirement want the seat beyond its upper (foremost) end."""
    missed = np.flatnonzero(~met_of(found.margin)[:, r])
    if along:  # short legs stop short of pedals: who sits at neither end is helped by neither
        at = found.seat[missed, 0]
        return bool(np.mean(at - ends[0] >= ends[1] - at) >= 0.5)
    return bool(np.mean([found.words[k] == TOO_LOW for k in found.reason[missed, r]]) >= 0.5)
