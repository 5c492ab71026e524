"""Changes of a design that would let more people meet everything, looked for in the margins.

Moving a control toward a person's shoulder lets the margin grow as much as the way gets shorter; so
do a part that is moved away from the sphere it is nearest to, and a seat's end for who sits at it.
So the margins say, to first order, who would meet what with a change made. What it really gains is
what a run with it says (see gains).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from workbench.model.accommodation import MET, Change
from workbench.model.arrays import Bools, Floats
from workbench.posture.seating.sides import leftward
from workbench.study.accommodation.changes import moved_parts
from workbench.study.accommodation.chunks import Chunk, Question
from workbench.study.accommodation.shares import left_out_alone, share_single
from workbench.study.checks.view import TOO_LOW

__all__ = ["MOST_MOVE", "growth", "met_of", "proposals", "shortest"]

MOST_MOVE = 0.1
"""The longest move [m] that is looked at."""
OF_THE_SEAT = ("eye_height", "view_over", "pedals", "preferred_seat")
"""The checks for which the ends of the seat's travel are moved."""
STEP = 1e-3
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


def met_of(margin: Floats) -> Bools:
    """Whether margins [m] are met; what does not apply is."""
    return np.asarray(np.isnan(margin) | (margin >= -MET))


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
    control, parts = (
        (one.control.name, ()) if one.control is not None else ("", one.criterion.parts)
    )
    side = leftward(question.place)
    ahead = np.array([side[1], -side[0], 0.0])
    up = np.array([0.0, 0.0, 1.0])
    ways = {
        "aft": -ahead,
        "forward": ahead,
        "up": up,
        "down": -up,
        "to the left": side,
        "to the right": -side,
    }
    met = met_of(found.margin)
    weight = question.people.weight
    now = _joint(met, weight)
    moves = np.arange(1, round(MOST_MOVE / STEP) + 1) * STEP
    shares = np.empty((len(moves), len(ways)))
    for k, axis in enumerate(ways.values()):
        x, y, z = axis.tolist()
        rows = _rows(question, Change("", control, parts, (x, y, z)))
        others = np.delete(met, rows, axis=1).all(axis=1)
        steps = np.nan_to_num(found.toward[:, rows] @ axis)
        for at, move in enumerate(moves):
            then = others & met_of(found.margin[:, rows] + move * steps).all(axis=1)
            shares[at, k] = weight @ then / weight.sum()
    m = shortest(shares.max(axis=1), now)
    if m is None:
        return None
    word = list(ways)[int(np.argmax(shares[m]))]
    x, y, z = (moves[m] * ways[word]).tolist()
    name = control or one.requirement.target
    return Change(f"moving {name} {1000 * moves[m]:.0f} mm {word}", control, parts, (x, y, z))


def _joint(met: Bools, weight: Floats) -> float:
    return float(weight @ met.all(axis=1) / weight.sum())


def _travel(question: Question, found: Chunk, r: int) -> Change | None:
    """The end of the seat's travel, at which those sit who miss the view or the pedals, moved
    outward."""
    own = question.place.own_seat
    if own is None:
        return None
    seat = question.asked[r].requirement.check in ("pedals", "preferred_seat")
    met = met_of(found.margin)
    weight = question.people.weight
    missed = np.flatnonzero(~met[:, r])
    column, ends = (0, own.travel_forward) if seat else (1, own.travel_up)
    if seat:  # short legs stop short of pedals: who sits at neither end is helped by neither
        beyond = np.mean(found.seat[missed, 0] - ends[0] >= ends[1] - found.seat[missed, 0]) >= 0.5
    else:
        beyond = np.mean([found.words[k] == TOO_LOW for k in found.reason[missed, r]]) >= 0.5
    at_end = np.abs(found.seat[:, column] - ends[int(beyond)]) < STEP
    others = np.delete(met, r, axis=1).all(axis=1)
    moves = np.arange(1, round(MOST_MOVE / STEP) + 1) * STEP
    shares = [
        weight @ (others & met_of(found.margin[:, r] + move * at_end)) / weight.sum()
        for move in moves
    ]
    m = shortest(np.array(shares), _joint(met, weight))
    if m is None:
        return None
    move = float(moves[m])
    words = (
        ("farther forward" if beyond else "farther back")
        if seat
        else ("higher" if beyond else "lower")
    )
    ends_moved = (0.0, move) if beyond else (-move, 0.0)
    told = f"letting the seat go {1000 * move:.0f} mm {words}"
    return Change(told, travel_forward=ends_moved) if seat else Change(told, travel_up=ends_moved)
