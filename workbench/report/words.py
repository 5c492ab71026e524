"""Deterministic English from data: what passed, what touches what, by how many millimetres."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from workbench.model.contacts import Contacts
from workbench.model.environment import Environment
from workbench.model.posture_study import Person, Size
from workbench.model.result import Finding, Result, Verdict

__all__ = [
    "contact_sentence",
    "finding_sentence",
    "headline",
    "millimetres",
    "person_words",
    "verdict_sentence",
    "without_polygons",
]


def millimetres(metres: float) -> str:
    """ "12.4 mm" of a length in metres; never "-0.0 mm"."""
    return f"{_tenths(metres * 1000)} mm"


def degrees(radians: float) -> str:
    """ "12.4 degrees" of an angle in radians."""
    return f"{_tenths(math.degrees(radians))} degrees"


def _tenths(value: float) -> str:
    text = f"{value:.1f}"
    return text[1:] if text in ("-0.0",) else text


def finding_sentence(check: str, finding: Finding, cases: tuple[str, ...]) -> str:
    """One finding in words, its case and person first: "cruise, pilot: right lower leg, knee cap
    (front) is ..."."""
    lead = f"{cases[finding.case]}, {finding.person}: "
    if check == "stops":
        motion = finding.target.replace("_", " ")
        if finding.value < 0:
            return (
                f"{lead}{finding.subject} is {degrees(-finding.value)} past its stop in {motion}."
            )
        return f"{lead}{finding.subject} is {degrees(finding.value)} from its stop in {motion}."
    if check == "seated":
        where = _apart(finding.value)
        return f"{lead}{finding.subject} is {where} {finding.target}, {millimetres(-finding.limit)} into it was stated."
    if check == "reach":
        if finding.value >= 0:
            return f"{lead}{finding.subject} reaches {finding.target}."
        return f"{lead}{finding.subject} stays {millimetres(-finding.value)} from {finding.target}."
    if check in _PLAIN:
        return lead + _PLAIN[check](finding)
    target = (
        f"{finding.other_person}'s {finding.target}" if finding.other_person else finding.target
    )
    need = ""
    if check in ("contact", "self_contact"):
        if finding.limit < 0:
            need = f" ({millimetres(-finding.limit)} allowed)"
    elif finding.value < finding.limit:
        need = f", {millimetres(finding.limit - finding.value)} less than the {millimetres(finding.limit)} asked for"
    return f"{lead}{finding.subject} is {_apart(finding.value)} {target}{need}."


def _pedal_words(finding: Finding) -> str:
    if finding.value >= finding.limit:
        return f"{finding.subject} is on {finding.target}."
    return f"{finding.subject} stays {millimetres(-finding.value)} from {finding.target}."


def _seat_words(finding: Finding) -> str:
    if finding.value < 0:
        return f"{finding.subject} is wanted {millimetres(-finding.value)} beyond its travel."
    return (
        f"{finding.subject} has {millimetres(finding.value)} of its travel left where it is wanted."
    )


def _view_words(finding: Finding) -> str:
    """Of the height of the eyes, against what is asked for."""
    if finding.value < 0:
        return (
            f"{finding.subject} lack {millimetres(-finding.value)} of height for {finding.target}."
        )
    return f"{finding.subject} have {millimetres(finding.value)} of height to spare for {finding.target}."


def _excursion_words(finding: Finding) -> str:
    allowed = millimetres(-finding.limit)
    return f"{finding.subject} is {millimetres(-finding.value)} from {finding.target} ({allowed} allowed)."


_PLAIN: dict[str, Callable[[Finding], str]] = {
    "pedals": _pedal_words,
    "preferred_seat": _seat_words,
    "eye_height": _view_words,
    "view_over": _view_words,
    "excursion": _excursion_words,
}


def _apart(distance: float) -> str:
    """ "12.4 mm into" or "12.4 mm from"."""
    return f"{millimetres(-distance)} into" if distance < 0 else f"{millimetres(distance)} from"


def without_polygons(sentence: str) -> str:
    """A sentence that names parts only: the numbers of polygons are for the tables."""
    return re.sub(r", polygon \d+\b", "", sentence)


def contact_sentence(contacts: Contacts, row: int) -> str:
    """A contact in words: "right hand, thumb tip (front): 12.4 mm into instrument_panel, polygon
    117"."""
    text = (
        f"{contacts.name(row)}: {_apart(float(contacts.distance[row]))} {contacts.other_name(row)}"
    )
    allowed = float(contacts.allowed[row])
    return f"{text} ({millimetres(allowed)} allowed)" if allowed > 0 else text


def verdict_sentence(verdict: Verdict, cases: tuple[str, ...]) -> str:
    """A criterion's outcome in one or two sentences."""
    if verdict.worst is None:
        return "Nothing was there to be measured: what it asks about is hidden, allowed to touch, or not in this study."
    told = finding_sentence(verdict.criterion.check, verdict.worst, cases)
    doubt = _doubt(verdict, cases)
    if verdict.passed:
        return f"Nearest to failing: {told}{doubt}"
    more = len(verdict.breaches) - 1
    return told + (f" {more} more breach{'es' if more > 1 else ''}." if more else "") + doubt


def _doubt(verdict: Verdict, cases: tuple[str, ...]) -> str:
    """ " It clears by 2.1 mm; the body's surface is known to 3.2 mm, so it may not." where the
    verdict could turn."""
    found = verdict.doubtful
    if found is None:
        return ""
    who = (
        "It"
        if found == verdict.worst
        else f"{found.subject[:1].upper()}{found.subject[1:]} ({cases[found.case]})"
    )
    whose = "the bodies' surfaces are" if found.other_person else "the body's surface is"
    by = millimetres(abs(found.value - found.limit))
    outcome = f"clears by {by}" if verdict.passed else f"fails by {by}"
    known = f"{whose} known to {millimetres(found.surface_known_to)}"
    return (
        f" {who} {outcome}; {known}, so it {'may not hold' if verdict.passed else 'may yet hold'}."
    )


def person_words(person: Person, mass: float) -> str:
    """Who somebody is and where: "bubbleman as a woman of stature 1525 mm, 51.3 kg, in seat left,
    20 mm forward"."""
    words = person.body.name
    if person.size is not None:
        given = ", ".join(
            f"{name.replace('_', ' ')} {1000 * value:.0f} mm"
            for name, value in person.size.measures.items()
            if name != "mass"
        )
        words += f" as a {_kind(person.size)}" + (f" of {given}" if given else "")
    if person.wears:
        words += f", with {', '.join(item.name for item in person.wears)}"
    words += f", {mass:.1f} kg"
    if person.seat is not None:
        words += f", in seat {person.seat.replace('_', ' ')}"
        for value, ahead, behind in (
            (person.forward, "forward", "back"),
            (person.up, "up", "down"),
        ):
            if value:
                words += f", {abs(1000 * value):.0f} mm {ahead if value > 0 else behind}"
    return words


def _kind(size: Size) -> str:
    """ "woman", or "girl of 6 years" with an age below 18."""
    if size.age is None or size.age >= 18:
        return "woman" if size.sex == "female" else "man"
    return f"{'girl' if size.sex == 'female' else 'boy'} of {size.age:g} years"


def headline(result: Result) -> str:
    """The whole result in one sentence."""
    failed = [verdict for verdict in result.verdicts if not verdict.passed]
    people = len(result.people)
    cases = len(result.study.cases)
    scope = (
        f"{people} {'people' if people > 1 else 'person'} in {cases} case{'s' if cases > 1 else ''}"
    )
    count = len(result.verdicts)
    criteria = f"{count} criteri{'a' if count > 1 else 'on'}"
    if not failed:
        hold = {1: "the criterion holds", 2: "both criteria hold"}.get(
            count, f"all {criteria} hold"
        )
        return f"{scope}: {hold}{_warned(result)}."
    names = ", ".join(verdict.criterion.name for verdict in failed)
    return f"{scope}: {len(failed)} of {criteria} failed: {names}{_warned(result)}."


def part_count(environment: Environment) -> str:
    """ "31 parts, 402 polygons"."""
    return f"{len(environment.parts)} parts, {len(environment.normal)} polygons"


def _warned(result: Result) -> str:
    count = len(result.warnings)
    return f", with {count} warning{'s' if count > 1 else ''}" if count else ""
