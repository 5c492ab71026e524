"""The table of checks, and the verdicts that they come to.

A new check is a file with `margins`, `findings` or `moments`, a row here, its keys in
`files.study.schema` and its sentence in `report.words`. If its margin is a distance of the body's
surface, the file has `bounds` too, and the check is one of `model.accommodation.OF_SURFACE`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from workbench.errors import UsageError
from workbench.model.accommodation import OF_RULES
from workbench.model.arrays import Bools, Floats
from workbench.model.criterion import Criterion
from workbench.model.motion_case import MotionCase
from workbench.model.result import Finding, MotionFound, Verdict
from workbench.model.units import UNITS
from workbench.model.workplace import Workplace
from workbench.posture.reaching.limbs import HANDS
from workbench.study.checks import (
    between_people,
    excursion,
    force,
    injury,
    joint_stops,
    parts,
    reach,
    score,
    seat_travel,
    self_contact,
    sight,
    sight_rules,
    view,
)
from workbench.study.checks.margins import Asked, Bounds, Margins, no_bounds, no_margins
from workbench.study.situation import Situation, moved_by_hands, moved_by_legs, with_hands

__all__ = [
    "AFTER_SEATING",
    "CHECKS",
    "IN_POSTURE",
    "LENGTH_TOLERANCE",
    "REACHING",
    "between_verdict",
    "bounds_of",
    "findings_of",
    "margins_here",
    "margins_of",
    "most_of",
    "motion_verdict",
    "needs_hands",
    "needs_legs",
    "never_met",
    "same_everywhere",
    "takes_looks",
    "verdict",
]

LENGTH_TOLERANCE = 1e-9
"""[m], [rad], and of a share: a breach by no more than this is none."""
AFTER_SEATING = 0
"""The cost of what seating alone answers."""
IN_POSTURE = 1
"""The cost of what is asked of the whole posture, with the hands on their controls."""
REACHING = 2
"""The cost of what searches for postures."""
_SAME_EVERYWHERE = ("preferred_seat", "pillar", "forward_field", "force")
"""Checks by which nobody chooses a position. Strength changes little with it: people sit where they
see and reach, and push there."""
_OF_POSTURE = ("self_contact", "stops", "score")
"""Checks that ask for nothing but the posture."""
Answer = TypeVar("Answer")


@dataclass(frozen=True)
class Check:
    """How a check is asked.

    Parameters
    ----------
    cost
        When it is asked: AFTER_SEATING, IN_POSTURE or REACHING.
    margins
        Of many people in one case: a number for each requirement. None of what is not asked so.
    findings
        Of one person in one case: everything that is near or missed. None of checks that look at
        more than one person or case.
    moments
        Of a motion: what comes nearest to failing. None of what is not asked of motions.
    bounds
        Of many people in one case, with the hands where they belong: between which margins the
        true ones lie. None of what does not depend on the body's surface.
    nothing
        Why a motion without moments passes; "" where it does not.
    spheres
        Of one case: the spheres (S,) that the margins of a criterion depend on. None where they may
        depend on the whole posture.
    most
        Of many people in one case, with the hands at rest: (B, R) [m] what they have to spare at
        most, wherever their hands are. None where nothing is known of that.
    never
        Of many people in one case, whose margins were asked: (B, R) what is proved to be missed in
        every position of the seat. None where nothing is.
    """

    cost: int
    margins: Callable[[Situation, Sequence[Asked]], Margins] | None = None
    findings: Callable[[Situation, Criterion], Iterable[Finding]] | None = None
    moments: Callable[[MotionFound, Criterion], Iterable[Finding]] | None = None
    bounds: Callable[[Situation, Sequence[Asked]], Bounds] | None = None
    nothing: Callable[[Criterion], str] = lambda criterion: ""
    spheres: Callable[[Situation, Criterion], Bools] | None = None
    most: Callable[[Situation, Sequence[Asked]], Floats] | None = None
    never: Callable[[Situation, Sequence[Asked]], Bools] | None = None


CHECKS = {
    "eye_height": Check(AFTER_SEATING, view.margins, view.findings),
    "view_over": Check(AFTER_SEATING, view.margins, view.findings),
    "over_nose": Check(AFTER_SEATING, view.nose_margins, view.nose_findings),
    **{
        check: Check(
            IN_POSTURE,
            sight.margins,
            sight.findings,
            spheres=sight.spheres_asked,
            most=sight.most,
        )
        for check in ("sees", "reads")
    },
    **{
        check: Check(IN_POSTURE, sight_rules.margins, sight_rules.findings, most=sight_rules.most)
        for check in OF_RULES
    },
    "pedals": Check(
        IN_POSTURE,
        seat_travel.pedal_margins,
        seat_travel.pedal_findings,
        spheres=seat_travel.spheres_asked,
        most=seat_travel.most,
    ),
    "preferred_seat": Check(AFTER_SEATING, seat_travel.seat_margins, seat_travel.seat_findings),
    "clearance": Check(
        IN_POSTURE,
        parts.margins,
        parts.findings,
        parts.clearance_moments,
        parts.bounds,
        spheres=parts.spheres_asked,
        most=parts.most,
    ),
    "contact": Check(
        IN_POSTURE,
        parts.margins,
        parts.findings,
        parts.contact_moments,
        parts.bounds,
        parts.no_contact,
        parts.spheres_asked,
        parts.most,
    ),
    "self_contact": Check(
        IN_POSTURE,
        self_contact.margins,
        self_contact.findings,
        self_contact.moments,
        self_contact.bounds,
        self_contact.no_overlap,
    ),
    "between_people": Check(IN_POSTURE, between_people.margins, bounds=between_people.bounds),
    "stops": Check(
        IN_POSTURE,
        joint_stops.margins,
        joint_stops.findings,
        joint_stops.moments,
        nothing=joint_stops.no_joint,
    ),
    "excursion": Check(
        IN_POSTURE,
        excursion.margins,
        excursion.findings,
        excursion.moments,
        excursion.bounds,
    ),
    "score": Check(IN_POSTURE, score.margins, score.findings, score.moments),
    "force": Check(IN_POSTURE, force.margins, force.findings),
    "reach": Check(REACHING, reach.margins, most=reach.most, never=reach.never_reached),
    "injury": Check(IN_POSTURE, moments=injury.moments),
}


def margins_of(situations: Sequence[Situation], asked: Sequence[Asked]) -> Margins:
    """What people have to spare in all requirements.

    Parameters
    ----------
    situations
        The same B people in each case of their workplace, with the hands at rest.
    """
    found = no_margins(len(situations[0]), asked)
    everybody = np.arange(len(situations[0]))
    bounded = [r for r, one in enumerate(asked) if one.for_certain and one.requirement.of_surface]
    for number, situation in enumerate(situations):
        rows = [r for r, one in enumerate(asked) if one.case == number and r not in bounded]
        for there, some in _posed(situation, asked, rows):
            those = margins_here(there, [asked[r] for r in some])
            found.put(everybody, np.array(some), those)
    if bounded:
        found.margin[:, bounded] = bounds_of(situations, [asked[r] for r in bounded]).low
    return found


def margins_here(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """What people have to spare in some requirements with the hands where they are: all requirements
    of a check are asked together."""
    found = no_margins(len(situation), asked)
    everybody = np.arange(len(situation))
    for margins, columns in _by_function(asked, range(len(asked)), lambda check: check.margins):
        those = [asked[r] for r in columns]
        found.put(everybody, np.array(columns), margins(situation, those))
    return found


def _posed(
    situation: Situation, asked: Sequence[Asked], rows: Sequence[int]
) -> Iterator[tuple[Situation, list[int]]]:
    """Some requirements with the situation in which they are asked: the hands at rest, or where
    they belong."""
    held = [r for r in rows if needs_hands(situation, asked[r])]
    rest = [r for r in rows if r not in held]
    if rest:
        yield situation, rest
    if held:
        yield with_hands(situation), held


def same_everywhere(place: Workplace, one: Asked) -> bool:
    """Whether the margin of a requirement counts as the same in every position: that of a seat, or
    of a point of the environment from which is looked; of somebody who stands, that of a posture
    which is carried along, and of what is stepped to; and a force."""
    check = one.requirement.check
    if check in _OF_POSTURE:
        return place.carried(one.case)
    fixed = check in _SAME_EVERYWHERE or bool(one.criterion.eye_point)
    return fixed or reach.same_in_the_area(place, one)


def takes_looks(place: Workplace, one: Asked) -> bool:
    """Whether a requirement is of what each person sees in thousands of directions: it takes longer
    than a reach."""
    return one.requirement.check in OF_RULES and not same_everywhere(place, one)


def needs_hands(situation: Situation, one: Asked, hands: Collection[str] = HANDS) -> bool:
    """Whether the margin of a requirement depends on where some hands are: else it is the same while
    they rest, and no hand has to be brought to its control for it."""
    check = CHECKS[one.requirement.check]
    if check.cost != IN_POSTURE:
        return False
    if check.spheres is None:
        return bool(hands)
    moved = moved_by_hands(situation, hands)
    return bool(np.any(check.spheres(situation, one.criterion) & moved))


def needs_legs(situation: Situation, one: Asked) -> bool:
    """Whether the margin of a requirement of the posture depends on where the legs are that have
    their feet on pedals."""
    check = CHECKS[one.requirement.check]
    if check.cost != IN_POSTURE or check.spheres is None:
        return check.cost != AFTER_SEATING
    moved = moved_by_legs(situation)
    return bool(np.any(check.spheres(situation, one.criterion) & moved))


def most_of(situations: Sequence[Situation], asked: Sequence[Asked]) -> Floats:
    """(B, R) [m] what people have to spare at most, as far as the posture with the hands at rest
    says; infinite where it says nothing.

    Parameters
    ----------
    situations
        As of `margins_of`.
    """
    found = np.full((len(situations[0]), len(asked)), np.inf)
    for number, situation in enumerate(situations):
        rows = [r for r, one in enumerate(asked) if one.case == number]
        for most, columns in _by_function(asked, rows, lambda check: check.most):
            found[:, columns] = most(situation, [asked[r] for r in columns])
    return found


def never_met(situations: Sequence[Situation], asked: Sequence[Asked]) -> Bools:
    """(B, R) what people are proved to miss in every position of the seat.

    Parameters
    ----------
    situations
        As of `margins_of`, which was asked of them.
    """
    found = np.zeros((len(situations[0]), len(asked)), dtype=np.bool_)
    for number, situation in enumerate(situations):
        rows = [r for r, one in enumerate(asked) if one.case == number]
        for never, columns in _by_function(asked, rows, lambda check: check.never):
            found[:, columns] = never(situation, [asked[r] for r in columns])
    return found


def bounds_of(situations: Sequence[Situation], asked: Sequence[Asked]) -> Bounds:
    """Between which margins the true ones lie, of the requirements that depend on the surface of
    the body; NaN of the others.

    Parameters
    ----------
    situations
        As of `margins_of`.
    """
    found = no_bounds(len(situations[0]), asked)
    everybody = np.arange(len(situations[0]))
    for number, situation in enumerate(situations):
        rows = [r for r, one in enumerate(asked) if one.case == number]
        for there, some in _posed(situation, asked, rows):
            for bounds, columns in _by_function(asked, some, lambda check: check.bounds):
                those = [asked[r] for r in columns]
                found.put(everybody, np.array(columns), bounds(there, those))
    return found


def _by_function(
    asked: Sequence[Asked], rows: Sequence[int], function: Callable[[Check], Answer | None]
) -> Iterator[tuple[Answer, list[int]]]:
    """The functions of the checks of some requirements, each with those that it answers
    together."""
    groups: dict[Answer, list[int]] = {}
    for r in rows:
        answer = function(CHECKS[asked[r].requirement.check])
        if answer is not None:
            groups.setdefault(answer, []).append(r)
    yield from groups.items()


def findings_of(situations: Iterable[Situation], criterion: Criterion) -> list[Finding]:
    """What a criterion finds about people by themselves, in the cases that it is asked of."""
    findings = CHECKS[criterion.check].findings
    if findings is None:
        return []
    return [
        finding
        for situation in situations
        if situation.place.role in criterion.people and criterion.asks(situation.work.name)
        for finding in findings(situation, criterion)
    ]


def verdict(criterion: Criterion, findings: Iterable[Finding], cases: Sequence[str]) -> Verdict:
    """Judge one criterion of people in postures.

    A criterion that looked at nothing has shown nothing: it fails.

    Parameters
    ----------
    cases
        The names of the cases in their order, by which equal findings stand.
    """
    ordered = sorted(findings, key=lambda f: (_counted(f), cases.index(f.case), f.person))
    breaches = tuple(f for f in ordered if f.margin < -LENGTH_TOLERANCE)
    return Verdict(
        criterion,
        bool(ordered) and not breaches,
        ordered[0] if ordered else None,
        breaches,
        _doubtful(ordered, breaches),
    )


def _counted(finding: Finding) -> float:
    """What the margin of a finding counts beside lengths [m]."""
    return UNITS[finding.unit].counts * finding.margin


def _doubtful(findings: list[Finding], breaches: tuple[Finding, ...]) -> Finding | None:
    """What could turn a verdict: the finding nearest to its limit that may be a breach, or all
    breaches together that may be none."""
    known = [f for f in breaches or findings if f.doubt > 0]
    if not known or len(known) < len(breaches):
        return None
    return min(known, key=lambda f: f.doubt) if breaches else known[0]


def motion_verdict(criterion: Criterion, found: MotionFound) -> Verdict:
    """Judge one criterion of a motion.

    Parameters
    ----------
    found
        What was found of the motion, without its verdicts.

    Raises
    ------
    UsageError
        For a check that cannot be asked of a motion.
    """
    check = CHECKS.get(criterion.check)
    if check is None or check.moments is None:
        raise UsageError(f"no check {criterion.check!r} of a motion")
    if criterion.check == "injury":
        coarse = injury.too_coarse(found, criterion)
        if coarse:
            return Verdict(criterion, False, None, motion=found.study.name, words=coarse)
        return _motion_verdict(criterion, found.study.name, list(check.moments(found, criterion)))
    ordered = sorted(check.moments(found, criterion), key=lambda finding: finding.margin)
    nothing = check.nothing(criterion)
    if not ordered and nothing:
        return Verdict(criterion, True, None, motion=found.study.name, words=nothing)
    return _motion_verdict(criterion, found.study.name, ordered)


def between_verdict(criterion: Criterion, case: str, motions: Sequence[MotionCase]) -> Verdict:
    """Judge a criterion between the people who move in one case."""
    findings = between_people.motion_findings(criterion, motions)
    ordered = sorted(findings, key=lambda finding: finding.margin)
    return _motion_verdict(criterion, case, ordered)


def _motion_verdict(criterion: Criterion, motion: str, ordered: Sequence[Finding]) -> Verdict:
    """The verdict of findings in their order, the worst first."""
    breaches = tuple(
        finding
        for finding in ordered
        if finding.margin < (0.0 if finding.unit in ("", "g") else -LENGTH_TOLERANCE)
    )
    return Verdict(
        criterion,
        bool(ordered) and not breaches,
        ordered[0] if ordered else None,
        breaches,
        motion=motion,
    )
