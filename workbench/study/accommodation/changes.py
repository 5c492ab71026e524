"""Changes of a design: a workplace with the change made, and which of its requirements the change bears
on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from workbench.body.parts import moved
from workbench.model.accommodation import Change
from workbench.model.environment import Environment
from workbench.model.workplace import Workplace
from workbench.study.checks.margins import Asked

__all__ = ["borne_by", "changed", "moved_parts"]


def changed(place: Workplace, change: Change) -> Workplace:
    """The workplace with a change made. A control takes its own parts along, but for those that are
    another control's too; a part takes all controls along that are on it."""
    environment = place.environment
    if change.control or change.parts:
        environment = moved(environment, moved_parts(environment, change), change.move)
        x, y, z = change.move
        controls = tuple(
            replace(c, at=(c.at[0] + x, c.at[1] + y, c.at[2] + z))
            if c.name == change.control or c.part in change.parts
            else c
            for c in environment.controls
        )
        return replace(place, environment=replace(environment, controls=controls))
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


def moved_parts(environment: Environment, change: Change) -> tuple[str, ...]:
    """The parts that a change moves."""
    if not change.control:
        return change.parts
    every = environment.controls
    own = next(control.own_parts for control in every if control.name == change.control)
    shared = {part for one in every if one.name != change.control for part in one.own_parts}
    return tuple(part for part in own if part not in shared)


def borne_by(place: Workplace, asked: Sequence[Asked], change: Change) -> list[int]:
    """The numbers of the requirements that a change bears on: of a control its own and those about
    its part; all of them where it is one that the sitters hold, or anything else is moved."""
    every = list(range(len(asked)))
    held = {name for case in place.cases for name in case.held.values()}
    if not change.control or change.control in held:
        return every
    parts = set(moved_parts(place.environment, change))
    rows = [
        r
        for r, one in enumerate(asked)
        if (one.requirement.target == change.control and one.control is not None)
        or (one.control is None and parts & set(one.criterion.parts))
    ]
    return rows if rows else every
