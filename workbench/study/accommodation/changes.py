"""Changes of a design: a workplace with the change made, which of its requirements the change bears
on, and what its parts would enter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from workbench.geometry.entering import Entered, entered, travel_ways
from workbench.model.accommodation import Change
from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.surroundings import displaced, moved_controls
from workbench.model.units import plain
from workbench.model.workplace import Workplace
from workbench.study.checks.margins import Asked

__all__ = ["affected_requirements", "changed", "enters", "enters_words", "moved_parts"]


@dataclass(frozen=True, eq=False)
class _Mover:
    """Parts that are moved together by (3,) [m] from (3,) [m] off where they are at rest; travels: again
    and again, as a seat."""

    parts: tuple[str, ...]
    start: Floats
    by: Floats
    travels: bool


def changed(place: Workplace, change: Change) -> Workplace:
    """The workplace with a change made: what is moved as a study's own moves are, and the ends of the
    own seat's travel, or of the area to step in."""
    environment = displaced(place.environment, change.moves)
    if not change.of_travel:
        return replace(place, environment=environment)
    forward, second = (
        (ends[0] + by[0], ends[1] + by[1])
        for ends, by in zip(place.travel, (change.travel_forward, change.travel_up), strict=True)
    )
    seats = tuple(
        replace(seat, travel_forward=forward, travel_up=second) if seat.name == place.seat else seat
        for seat in environment.seats
    )
    stand = place.stand
    if stand is not None:
        stand = replace(stand, forward=forward, left=second)
    return replace(place, environment=replace(environment, seats=seats), stand=stand)


def enters(place: Workplace, change: Change) -> Entered | None:
    """What the parts of a change, and those that go with the own seat beyond its travel, enter deepest
    more than they do in the design as it is; None where they enter nothing. What turns is not looked
    at."""
    environment = place.environment
    movers = [_Mover(move.parts, np.zeros(3), np.array(move.by), False) for move in change.moves]
    seat = place.own_seat
    if seat is not None and change.of_travel:
        known = (seat.travel_forward, seat.travel_up)
        longer = changed(place, change).travel
        movers += [
            _Mover(seat.moves, *way, True) for way in travel_ways(seat, known, longer, middles=True)
        ]
    gone = {name for mover in movers for name in mover.parts}
    still = [name for name in environment.parts if name not in gone]
    tried = [(one, one.by, still) for one in movers]
    for one, other in combinations(movers, 2):
        if one.parts != other.parts:
            tried.append((other, other.by - one.by, list(one.parts)))
    found = [
        entered(environment, one.parts, by, start=one.start, others=others, way_counts=one.travels)
        for one, by, others in tried
    ]
    return max((one for one in found if one), key=lambda one: one.depth, default=None)


def enters_words(what: str, found: Entered) -> str:
    """ "moving shelf 80 mm aft would put shelf 18 mm into post"."""
    more = "farther " if found.touched else ""
    much = f"{1000 * found.depth:.0f} mm {more}into {plain(found.other)}"
    return f"{what} would put {plain(found.part)} {much}"


def moved_parts(change: Change) -> set[str]:
    """The parts that a change moves."""
    return {name for move in change.moves for name in move.parts}


def affected_requirements(place: Workplace, asked: Sequence[Asked], change: Change) -> list[int]:
    """The numbers of the requirements that a change bears on: of controls with nothing but their own
    parts the reaches of these, what is asked about the parts and what is seen; all of them where the sitters hold
    one of the controls, or anything else is moved."""
    every = list(range(len(asked)))
    held = {name for case in place.cases for name in case.held.values()}
    controls = set(moved_controls(place.environment, change.moves))
    parts = moved_parts(change)
    if change.of_travel or controls & held or not _of_controls(place.environment, parts):
        return every
    rows = [
        r
        for r, one in enumerate(asked)
        if (one.control is not None and one.control.name in controls)
        or (one.control is None and parts & set(one.criterion.parts))
        or one.requirement.of_sight
    ]
    return rows if rows else every


def _of_controls(environment: Environment, parts: set[str]) -> bool:
    """Whether each part is that of one control alone."""
    on = [part for control in environment.controls for part in control.own_parts]
    return all(on.count(part) == 1 for part in parts)
