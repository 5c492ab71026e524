"""A Result as plain rows: what result.json, the CSV tables and the page are made of."""

from __future__ import annotations

import math

import numpy as np

from workbench.files.results import (
    ContactRow,
    FindingRow,
    PersonRow,
    ResultFile,
    StopRow,
    VerdictRow,
)
from workbench.model.contacts import Contacts
from workbench.model.environment import Environment
from workbench.model.result import Finding, PersonResult, Result, Verdict
from workbench.model.vocabulary import DIRECTIONS
from workbench.report.envelopes.rows import envelope_rows
from workbench.report.reach_rows import reach_rows
from workbench.report.words import (
    contact_sentence,
    finding_sentence,
    person_words,
    verdict_sentence,
)

__all__ = ["result_file"]

Point = tuple[float, float, float]


def result_file(result: Result) -> ResultFile:
    """The result in millimetres, degrees and words."""
    study = result.study
    contacts = [row for person in result.people for row in _contact_rows(result, person)]
    for (one, other), rows in result.between.items():
        contacts += _rows(result, rows, (one, other, "between_people"))
    return ResultFile(
        study=study.name,
        title=study.title,
        passed=result.passed,
        environment=study.environment.name,
        cases=list(study.cases),
        parts=list(study.environment.parts),
        verdicts=[_verdict_row(verdict, study.cases) for verdict in result.verdicts],
        people=[_person_row(result, index) for index in range(len(result.people))],
        contacts=contacts,
        warnings=list(result.warnings),
        provenance={kind: dict(rows) for kind, rows in result.provenance.items()},
        reaches=reach_rows(result),
        envelopes=envelope_rows(result),
    )


def _verdict_row(verdict: Verdict, cases: tuple[str, ...]) -> VerdictRow:
    check = verdict.criterion.check
    return VerdictRow(
        name=verdict.criterion.name,
        check=check,
        passed=verdict.passed,
        doubtful=verdict.doubtful is not None,
        sentence=verdict_sentence(verdict, cases),
        worst=_finding_row(check, verdict.worst, cases) if verdict.worst else None,
        breaches=[_finding_row(check, finding, cases) for finding in verdict.breaches],
    )


def _finding_row(check: str, finding: Finding, cases: tuple[str, ...]) -> FindingRow:
    angle = check == "stops"
    return FindingRow(
        case=cases[finding.case],
        person=finding.person,
        other_person=finding.other_person or None,
        subject=finding.subject,
        target=finding.target,
        value=_micro(math.degrees(finding.value) if angle else finding.value * 1000),
        limit=_micro(math.degrees(finding.limit) if angle else finding.limit * 1000),
        unit="deg" if angle else "mm",
        point_mm=_point(finding.point)
        if finding.point and all(map(math.isfinite, finding.point))
        else None,
        surface_known_to=_micro(1000 * finding.surface_known_to)
        if math.isfinite(finding.surface_known_to)
        else None,
        sentence=finding_sentence(check, finding, cases),
    )


def _person_row(result: Result, index: int) -> PersonRow:
    found = result.people[index]
    person = result.study.people[index]
    body = person.body
    return PersonRow(
        name=person.name,
        description=person_words(person, float(found.placed.body.mass[0].sum())),
        body=body.name,
        seat=person.seat,
        size={
            name: _micro(value if name == "mass" else 1000 * value)
            for name, value in person.size.measures.items()
        }
        if person.size
        else None,
        postures=list(person.postures),
        segments=list(body.segments),
        clearance_mm=[
            [[_micro(1000 * d) if math.isfinite(d) else None for d in row] for row in case]
            for case in found.clearance.distance.tolist()
        ],
        stops=[
            StopRow(
                case=result.study.cases[p],
                joint=body.joints[j],
                margin_deg=_micro(math.degrees(found.margin[p, j]))
                if math.isfinite(found.margin[p, j])
                else None,
                motion=found.margin_motion[p][j] if math.isfinite(found.margin[p, j]) else None,
            )
            for p in range(len(found.placed))
            for j in range(len(body.joints))
        ],
    )


def _contact_rows(result: Result, person: PersonResult) -> list[ContactRow]:
    return _rows(result, person.contacts, (person.name, "", "environment")) + _rows(
        result, person.self_contacts, (person.name, "", "self")
    )


def _rows(result: Result, contacts: Contacts, who: tuple[str, str, str]) -> list[ContactRow]:
    """The deepest contact of each case and pair, greatest excess first."""
    deepest = contacts.deepest()
    order = np.lexsort((deepest.sphere, -deepest.excess, deepest.pose))
    return [_contact_row(result, deepest.rows(order), (row, *who)) for row in range(len(order))]


def _contact_row(result: Result, contacts: Contacts, at: tuple[int, str, str, str]) -> ContactRow:
    row, person, other_person, kind = at
    polygons = isinstance(contacts.other, Environment)
    sphere = int(contacts.sphere[row])
    part = int(contacts.part[row])
    return ContactRow(
        case=result.study.cases[contacts.pose[row]],
        person=person,
        other_person=other_person or None,
        kind=kind,
        segment=contacts.body.segments[contacts.segment[row]],
        sphere=sphere - int(contacts.body.start[contacts.segment[row]]),
        subpart=contacts.body.sphere_names[sphere] or None,
        direction=DIRECTIONS[contacts.facing[row]],
        part=contacts.other.parts[part] if isinstance(contacts.other, Environment) else None,
        polygon=int(contacts.polygon[row] - contacts.other.part_start[part])
        if isinstance(contacts.other, Environment)
        else None,
        other_segment=None
        if isinstance(contacts.other, Environment)
        else contacts.other.segments[contacts.other_segment[row]],
        other_sphere=None
        if isinstance(contacts.other, Environment)
        else int(contacts.other_sphere[row] - contacts.other.start[contacts.other_segment[row]]),
        distance_mm=_micro(1000 * contacts.distance[row]),
        allowed_mm=_micro(1000 * contacts.allowed[row]),
        excess_mm=_micro(1000 * contacts.excess[row]),
        point_mm=_point(contacts.point[row]),
        normal=tuple(_micro(float(v)) for v in contacts.normal[row]),  # type: ignore[arg-type]
        sentence=contact_sentence(contacts, row)
        + ("" if polygons else f" of {other_person or 'the same body'}"),
    )


def _point(point: object) -> Point:
    return tuple(_micro(1000 * float(v)) for v in point)  # type: ignore[attr-defined, return-value]


def _micro(value: float) -> float:
    """Six decimals: a nanometre or a microdegree, so that the last bits of a machine do not
    show."""
    return round(float(value), 6) + 0.0
