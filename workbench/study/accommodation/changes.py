"""Changes of a design: a workplace with the change made, and which of its requirements the change bears
on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from workbench.model.accommodation import Change
from workbench.model.environment import Environment
from workbench.model.surroundings import displaced, moved_controls
from workbench.model.workplace import Workplace
from workbench.study.checks.margins import Asked

__all__ = ["borne_by", "changed", "moved_parts"]


def changed(place: Workplace, change: Change) -> Workplace:
    """The workplace with a change made: what is moved as a study's own moves are, and the ends of the
    own seat's travel."""
    environment = displaced(place.environment, change.moves)
    if not change.of_travel:
        return replace(place, environment=environment)
    seats = []
    for seat in environment.seats:
        if seat.name == place.seat:
            forward, up = (
                (ends[0] + by[0], ends[1] + by[1])
                for ends, by in (
                    (seat.travel_forward, change.travel_forward),
                    (seat.travel_up, change.travel_up),
                )
            )
            seat = replace(seat, travel_forward=forward, travel_up=up)
        seats.append(seat)
    return replace(place, environment=replace(environment, seats=tuple(seats)))


def moved_parts(change: Change) -> set[str]:
    """The parts that a change moves."""
    return {name for move in change.moves for name in move.parts}


def borne_by(place: Workplace, asked: Sequence[Asked], change: Change) -> list[int]:
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
