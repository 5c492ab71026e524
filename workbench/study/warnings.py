"""What a reader of a result must know that no criterion asks: stops breached, bodies swallowed, seats missed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from workbench.model.environment import Environment, Rest
from workbench.model.result import PersonResult
from workbench.model.study import Study

__all__ = ["result_warnings"]

SEAT_TOLERANCE = 0.01
"""How far [m] the real sinking into a seat may be from the stated depth before it is told."""


def result_warnings(study: Study, environment: Environment, people: tuple[PersonResult, ...]) -> list[str]:
    """Sentences, person by person."""
    found: list[str] = []
    for person, asked in zip(people, study.people, strict=True):
        found += _breached(study, person)
        found += _swallowed(study, person)
        if asked.seat is not None:
            seat = environment.seat(asked.seat)
            for rest, what in ((seat.cushion, "cushion"), (seat.back, "back")):
                found += _missed(environment, person, (rest, f"{what} of seat {seat.name!r}"))
    return found


def _breached(study: Study, person: PersonResult) -> Iterator[str]:
    for case, joint in np.argwhere(person.margin < -1e-9):
        yield (
            f"{person.name}, {study.cases[case]}: {person.placed.body.joint_names[joint]} is "
            f"{-np.degrees(person.margin[case, joint]):.1f} degrees past its stop in "
            f"{person.margin_motion[case][joint].replace('_', ' ')}"
        )


def _swallowed(study: Study, person: PersonResult) -> Iterator[str]:
    body = person.placed.body
    with_spheres = np.diff(body.start) > 0
    radius = body.radius[person.clearance.sphere[:, with_spheres]]
    inside = person.clearance.distance[:, with_spheres] < -radius
    for case, part in np.argwhere(np.all(inside, axis=1)):
        yield (
            f"{person.name}, {study.cases[case]}: the whole body is inside the solid part "
            f"{study.environment.parts[part]!r}; if that part is a shell around people, say 'solid: false' for it"
        )


def _missed(environment: Environment, person: PersonResult, rest: tuple[Rest, str]) -> Iterator[str]:
    """The seat's planes say where a sitter rests; the part itself may be elsewhere."""
    surface, what = rest
    body = person.placed.body
    names = body.segments if "all" in surface.segments else surface.segments
    rows = [body.segments.index(name) for name in names if name in body.segments]
    if surface.part not in environment.parts or environment.hidden[environment.part(surface.part)]:
        return
    gaps = person.clearance.distance[:, rows, environment.part(surface.part)].min(axis=1)
    worst = int(np.argmax(np.abs(gaps + surface.depth)))
    gap = float(gaps[worst])
    if np.isfinite(gap) and abs(gap + surface.depth) > SEAT_TOLERANCE:
        where = f"{1000 * gap:.0f} mm clear of" if gap > 0 else f"{-1000 * gap:.0f} mm deep in"
        yield (
            f"{person.name} is {where} {surface.part!r}, the {what}, where {1000 * surface.depth:.0f} mm deep was "
            f"stated: check the seat reference point and the seat's angles against the mesh"
        )
