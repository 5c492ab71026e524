"""Criteria: each check is one function from what was measured to findings, and one row in a
table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.contact.clearance_pairs import clearance_of_pairs
from workbench.contact.collide import allowed_depth
from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats
from workbench.model.contacts import Clearance
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.model.posture_study import Person, SeatFit
from workbench.model.result import ControlReach, Finding, PersonResult, Verdict
from workbench.study.accommodation.views import margin_of_view
from workbench.study.pairs import pair_of

__all__ = ["Measured", "verdict"]

LENGTH_TOLERANCE = 1e-9
ANGLE_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Measured:
    """Everything the checks look at: people as asked for and as found, their own segments'
    clearance, that between people, and their reaches."""

    environment: Environment
    cases: tuple[str, ...]
    asked: Mapping[str, Person]
    people: Mapping[str, PersonResult]
    own: Mapping[str, Clearance]
    between: Mapping[tuple[str, str], Clearance]
    reaches: tuple[ControlReach, ...] = ()


def verdict(criterion: Criterion, measured: Measured) -> Verdict:
    """How one criterion came out."""
    tolerance = ANGLE_TOLERANCE if criterion.check == "stops" else LENGTH_TOLERANCE
    findings = sorted(
        (f for f in CHECKS[criterion.check](criterion, measured) if criterion.asks(f.case)),
        key=lambda f: (f.margin, measured.cases.index(f.case), f.person),
    )
    breaches = tuple(f for f in findings if f.margin < -tolerance)
    # a criterion that looked at nothing has shown nothing
    passed = bool(findings) and not breaches
    return Verdict(
        criterion,
        passed,
        findings[0] if findings else None,
        breaches,
        _doubtful(findings, breaches),
    )


def _doubtful(findings: list[Finding], breaches: tuple[Finding, ...]) -> Finding | None:
    """What could turn a verdict: one finding that may be a breach, or all breaches together that
    may be none."""
    known = [f for f in breaches or findings if f.doubt > 0]
    if not known or len(known) < len(breaches):
        return None
    return min(known, key=lambda f: f.doubt) if breaches else max(known, key=lambda f: f.doubt)


def _contact(criterion: Criterion, measured: Measured) -> Iterator[Finding]:
    """Overlap with parts beyond what the parts allow, and `at_most` more."""
    if criterion.subparts:
        yield from _subparts(criterion, measured)
        return
    for person in _wanted(criterion, measured):
        allowed = allowed_depth(person.placed.body, measured.environment) + criterion.at_most
        keep = _keep(criterion, person, measured.environment)
        asked = _Pairs(person.clearance, -allowed, keep, person.name)
        yield from _pair_findings(asked, measured.cases)


def _clearance(criterion: Criterion, measured: Measured) -> Iterator[Finding]:
    """Distance to parts; pairs whose contact is allowed by rule are left out."""
    if criterion.subparts:
        yield from _subparts(criterion, measured)
        return
    for person in _wanted(criterion, measured):
        allowed = allowed_depth(person.placed.body, measured.environment)
        keep = _keep(criterion, person, measured.environment) & (allowed == 0)
        limit = np.full(allowed.shape, criterion.at_least)
        asked = _Pairs(person.clearance, limit, keep, person.name)
        yield from _pair_findings(asked, measured.cases)


def _self_contact(criterion: Criterion, measured: Measured) -> Iterator[Finding]:
    """Overlap of non-adjacent segments beyond the body's allowance for soft flesh."""
    for person in _wanted(criterion, measured):
        own = measured.own[person.name]
        wanted = np.isin(own.body.segments, criterion.segments)
        keep = wanted[:, None] | wanted[None, :]
        asked = _Pairs(own, -own.body.allowance[0], keep, person.name)
        yield from _pair_findings(asked, measured.cases)


def _between_people(criterion: Criterion, measured: Measured) -> Iterator[Finding]:
    for (one, other), near in measured.between.items():
        if one in criterion.people or other in criterion.people:
            rows, columns = (
                np.isin(measured.people[name].placed.body.segments, criterion.segments)
                for name in (one, other)
            )
            keep = rows[:, None] & columns[None, :]
            limit = np.full(keep.shape, criterion.at_least)
            yield from _pair_findings(_Pairs(near, limit, keep, one, other), measured.cases)


def _stops(criterion: Criterion, measured: Measured) -> Iterator[Finding]:
    """Margin of each joint whose distal segment is wanted."""
    for person in _wanted(criterion, measured):
        body = person.placed.body
        for case, joint in np.argwhere(np.isfinite(person.margin)):
            if body.segments[joint + 1] in criterion.segments:
                yield Finding(
                    case=measured.cases[case],
                    person=person.name,
                    other_person="",
                    subject=body.joint_names[joint],
                    target=person.margin_motion[case][joint],
                    value=float(person.margin[case, joint]),
                    limit=criterion.at_least,
                    unit="rad",
                )


def _reach(criterion: Criterion, measured: Measured) -> Iterator[Finding]:
    """Each control in the zone asked for, or its own: how far the grip stays from it must be
    nothing."""
    for row in measured.reaches:
        wanted = (
            row.person in criterion.people
            and row.control in criterion.controls
            and row.hand == (criterion.hand or "")
        )
        if wanted and row.zone == (criterion.zone or row.own_zone):
            # what is reached only through an obstacle is not reached
            short = 0.0 if row.reached else max(row.miss + row.overlap, 1e-4)
            words = f"the {row.limb}"
            target = f"{row.control} in zone {row.zone}" + (
                f", limited by {row.limit}" if row.limit else ""
            )
            yield Finding(measured.cases[row.case], row.person, "", words, target, -short, 0.0)


def _subparts(criterion: Criterion, measured: Measured) -> Iterator[Finding]:
    """Clearance or contact of named spheres: the nearest of each case."""
    environment = measured.environment
    for person in _wanted(criterion, measured):
        placed = person.placed
        body = placed.body
        pair = pair_of(body, environment, criterion)
        found = clearance_of_pairs(placed, environment, pairs=[pair])
        limit = -criterion.at_most if criterion.check == "contact" else criterion.at_least
        for case in np.flatnonzero(np.isfinite(found.distance[:, 0])).tolist():
            sphere = int(found.sphere[case, 0])
            polygon = int(found.polygon[case, 0])
            segment = body.segment_names[int(body.sphere_segment[sphere])]
            yield Finding(
                case=measured.cases[case],
                person=person.name,
                other_person="",
                subject=f"{segment} ({body.sphere_names[sphere]})",
                target=environment.parts[int(environment.polygon_part[polygon])],
                value=float(found.distance[case, 0]),
                limit=limit,
                point=tuple(found.point[case, 0].tolist()),
            )


def _seats(criterion: Criterion, measured: Measured) -> Iterator[tuple[int, Person, SeatFit]]:
    """How seat and pedals came out, of those who are asked about, case by case."""
    for name in criterion.people:
        person = measured.asked[name]
        for case, fit in enumerate(person.fits):
            if fit is not None:
                yield case, person, fit


def _pedals(criterion: Criterion, measured: Measured) -> Iterator[Finding]:
    """How far the worse foot stays from its pedal."""
    for case, person, fit in _seats(criterion, measured):
        aims = person.aims[case]
        if fit.foot and aims is not None:
            target = aims.controls[fit.foot] + (f", limited by {fit.limit}" if fit.limit else "")
            words = f"the {fit.foot}"
            yield Finding(
                measured.cases[case], person.name, "", words, target, -fit.miss, -criterion.at_most
            )


def _preferred_seat(criterion: Criterion, measured: Measured) -> Iterator[Finding]:
    """Travel left at the position of the seat that is wanted, to its nearer end."""
    for case, person, fit in _seats(criterion, measured):
        seat = f"seat {person.seat}"
        yield Finding(
            measured.cases[case], person.name, "", seat, "the travel", fit.spare, criterion.at_least
        )


def _view(criterion: Criterion, measured: Measured) -> Iterator[Finding]:
    """The height of the eyes, against their point or the line over parts."""
    for person in _wanted(criterion, measured):
        asked = measured.asked[person.name]
        body = person.placed.body
        eyes = [body.sphere_names.index(name) for name in EYES if name in body.sphere_names]
        if len(eyes) < len(EYES) or asked.seat is None:
            raise InputError(f"body {body.name} has no spheres {EYES[0]!r} and {EYES[1]!r}")
        height = person.placed.centres[:, eyes].mean(axis=1)
        for case in range(len(person.placed)):
            aims = asked.aims[case] if asked.aims else None
            point = aims.eyes if aims is not None else None
            if criterion.check == "eye_height" and point is None:
                continue
            where = (asked.seat, point)
            margin = margin_of_view(
                measured.environment, where, criterion, height[case : case + 1]
            )[0]
            target = point if criterion.check == "eye_height" else ", ".join(criterion.parts)
            if np.isfinite(margin):
                yield Finding(
                    measured.cases[case],
                    person.name,
                    "",
                    "the eyes",
                    str(target),
                    float(margin),
                    0.0,
                )


def _excursion(criterion: Criterion, measured: Measured) -> Iterator[Finding]:
    """How far the surface of segments gets along a direction."""
    for person in _wanted(criterion, measured):
        body = person.placed.body
        rows = [n for n, name in enumerate(body.segments) if name in criterion.segments]
        about = np.flatnonzero(np.isin(body.sphere_segment, rows))
        gap = person.placed.centres[:, about] - np.array(criterion.origin)
        ahead = gap @ np.array(criterion.direction) + body.radius[0, about]
        for case, sphere in enumerate(ahead.argmax(axis=1).tolist()):
            segment = body.segment_names[int(body.sphere_segment[about[sphere]])]
            value = -float(ahead[case, sphere])
            yield Finding(
                measured.cases[case],
                person.name,
                "",
                segment,
                "the origin",
                value,
                -criterion.at_most,
            )


EYES = ("left eye", "right eye")
"""The spheres between whose centres a body looks from."""
CHECKS: dict[str, Callable[[Criterion, Measured], Iterator[Finding]]] = {
    "contact": _contact,
    "clearance": _clearance,
    "self_contact": _self_contact,
    "between_people": _between_people,
    "stops": _stops,
    "reach": _reach,
    "pedals": _pedals,
    "preferred_seat": _preferred_seat,
    "eye_height": _view,
    "view_over": _view,
    "excursion": _excursion,
}


def _wanted(criterion: Criterion, measured: Measured) -> list[PersonResult]:
    return [person for name, person in measured.people.items() if name in criterion.people]


def _keep(criterion: Criterion, person: PersonResult, environment: Environment) -> Bools:
    """(N, K) the segments and parts a criterion is about."""
    rows = np.isin(person.placed.body.segments, criterion.segments)
    return rows[:, None] & np.isin(environment.parts, criterion.parts)[None, :]


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Clearances of pairs of segments and parts (or segments), and what is asked of them.

    limit (N, K) [m]: the distance may not be below it; keep (N, K): the pairs that are asked about.
    """

    near: Clearance
    limit: Floats
    keep: Bools
    person: str
    other_person: str = ""


def _pair_findings(asked: _Pairs, cases: tuple[str, ...]) -> Iterator[Finding]:
    """The worst finding of each case, and every breach."""
    near = asked.near
    distance = near.distance
    wanted = asked.keep & np.isfinite(distance)
    margin = np.where(wanted, distance - asked.limit, np.inf)
    known = _surface(near)
    for case in range(len(margin)):
        if not np.isfinite(margin[case]).any():
            continue
        tightest = {np.argmin(margin[case]), np.argmin(margin[case] - np.nan_to_num(known[0]))}
        pairs = {tuple(map(int, np.unravel_index(at, asked.keep.shape))) for at in tightest}
        for row, column in pairs | set(map(tuple, np.argwhere(margin[case] < 0).tolist())):
            where = (case, row, column)
            yield Finding(
                case=cases[case],
                person=asked.person,
                other_person=asked.other_person,
                subject=near.name(where),
                target=near.other_name(where),
                value=float(distance[where]),
                limit=float(asked.limit[row, column]),
                point=tuple(near.point[where].tolist()),
                surface_known_to=float(known[0 if margin[where] >= 0 else 1, row, column]),
            )


def _surface(near: Clearance) -> Floats:
    """(2, N, K) [m] how far the true surface may lie outside and inside the spheres of each pair,
    NaN where not known; parts of an environment are where they are."""
    own = near.body.fit_error[0].T[:, :, None]
    if isinstance(near.other, Environment):
        return np.broadcast_to(own, (2, *near.distance.shape[1:]))
    both: Floats = own + near.other.fit_error[0].T[:, None, :]
    return both
