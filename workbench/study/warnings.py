"""What a reader of a result must know that no criterion asks: stops breached, bodies swallowed or
enclosed, seats missed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from workbench.contact.enclosure import enclosed
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment, Rest
from workbench.model.poses import Placed
from workbench.model.result import Finding, PersonFound, Verdict

__all__ = ["enclosure_warnings", "result_warnings", "seat_verdicts"]

SEAT_TOLERANCE = 0.01
SEAT_LOST = 0.05
"""How far [m] the real sinking into a seat may be from the stated depth before it is reported, and
before it fails."""
DRIVER_TOLERANCE = 0.1
"""The same before it is reported of a driver, who sits by the hip point and whose back has an angle of
its own."""


def result_warnings(
    environment: Environment, cases: tuple[str, ...], people: tuple[PersonFound, ...]
) -> list[str]:
    """Sentences, person by person."""
    found: list[str] = []
    for person in people:
        found += _breached(cases, person)
        found += _swallowed(environment, cases, person)
        found += enclosure_warnings(person.name, person.placed, environment, cases)
        if person.role.seat is not None:
            seat = environment.seat(person.role.seat)
            for surface, what in ((seat.cushion, "cushion"), (seat.back, "back")):
                tolerance = DRIVER_TOLERANCE if "driver" in person.postures else SEAT_TOLERANCE
                words = f"{what} of seat {seat.name!r}"
                found += _missed(environment, person, surface, words, tolerance)
    return found


def _breached(cases: tuple[str, ...], person: PersonFound) -> Iterator[str]:
    for case, joint in np.argwhere(person.margin < -1e-9):
        yield (
            f"{person.name}, {cases[case]}: {person.placed.body.joint_names[joint]} is "
            f"{-np.degrees(person.margin[case, joint]):.1f} degrees past its stop in "
            f"{person.margin_motion[case][joint].replace('_', ' ')}"
        )


def _swallowed(
    environment: Environment, cases: tuple[str, ...], person: PersonFound
) -> Iterator[str]:
    body = person.placed.body
    with_spheres = np.diff(body.start) > 0
    radius = body.radius[0][person.clearance.sphere[:, with_spheres]]
    inside = person.clearance.distance[:, with_spheres] < -radius
    for case, part in np.argwhere(np.all(inside, axis=1)):
        yield (
            f"{person.name}, {cases[case]}: the whole body is inside the solid part "
            f"{environment.parts[part]!r}; if that part is a shell around people, say 'solid: false' for it"
        )


def enclosure_warnings(
    name: str, placed: Placed, environment: Environment, cases: Sequence[str] = ()
) -> Iterator[str]:
    """A sentence for each visible part that is open, not declared to be no solid, and encloses a
    body in some pose.

    cases: the names of the poses, where they have any.
    """
    for part in environment.undecided:
        if environment.hidden[part]:
            continue
        within = np.flatnonzero(enclosed(placed, environment, part) > 0.5)
        if not len(within):
            continue
        where = f", {cases[int(within[0])]}" if cases else ""
        where += f" and {len(within) - 1} more" if cases and len(within) > 1 else ""
        yield (
            f"{name}{where}: the body is enclosed by the open part {environment.parts[part]!r}, which counts as a "
            "surface without an inside: mend its mesh if it is a solid, or say 'solid: false' for it if it is a shell "
            "around people"
        )


def _missed(
    environment: Environment, person: PersonFound, surface: Rest, what: str, tolerance: float
) -> Iterator[str]:
    """The seat's planes say where a sitter rests; the part itself may be elsewhere."""
    gaps = _gaps(environment, person, surface)
    gap = max(gaps, key=lambda gap: abs(gap + surface.depth), default=-surface.depth)
    if abs(gap + surface.depth) > tolerance:
        where = f"{1000 * gap:.0f} mm clear of" if gap > 0 else f"{-1000 * gap:.0f} mm deep in"
        yield (
            f"{person.name} is {where} {surface.part!r}, the {what}, where {1000 * surface.depth:.0f} mm deep was "
            f"stated: check the seat reference point, the seat's angles, and the mesh's unit and axes"
        )


def seat_verdicts(
    environment: Environment, cases: tuple[str, ...], people: tuple[PersonFound, ...]
) -> list[Verdict]:
    """A failed verdict where somebody is not on his seat at all; nothing where everybody is.

    Whoever floats or is buried has clearances that mean nothing, whatever the study asks.
    """
    lost = []
    for person in people:
        if person.role.seat is None:
            continue
        rest = environment.seat(person.role.seat).cushion
        for case, gap in enumerate(_gaps(environment, person, rest)):
            if abs(gap + rest.depth) > SEAT_LOST:
                lost.append(
                    Finding(
                        case=cases[case],
                        person=person.name,
                        other_person="",
                        subject="the sitter",
                        target=rest.part,
                        value=float(gap),
                        limit=-rest.depth,
                    )
                )
    if not lost:
        return []
    everyone = tuple(person.name for person in people)
    criterion = Criterion("everybody is on his seat", "seated", everyone, (), (), 0.0)
    lost.sort(key=lambda finding: -abs(finding.margin))
    return [Verdict(criterion, False, lost[0], tuple(lost))]


def _gaps(environment: Environment, person: PersonFound, rest: Rest) -> list[float]:
    """Distance [m] of whoever rests there to the real part, case by case; nothing where the part is
    not to be seen."""
    body = person.placed.body
    names = body.segments if "all" in rest.segments else rest.segments
    rows = [body.segments.index(name) for name in names if name in body.segments]
    if rest.part not in environment.parts or environment.hidden[environment.part(rest.part)]:
        return []
    gaps = person.clearance.distance[:, rows, environment.part(rest.part)].min(axis=1)
    return [float(gap) for gap in gaps if np.isfinite(gap)]
