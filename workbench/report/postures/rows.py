"""People in postures as the rows of result.json."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from workbench.files.results.postures import (
    ContactRow,
    PersonRow,
    PosturesRows,
    ReachRow,
    StopRow,
)
from workbench.model.contacts import Contacts
from workbench.model.environment import Environment
from workbench.model.result import PersonFound, PosturesFound
from workbench.model.vocabulary import DIRECTIONS
from workbench.report.postures.envelopes.rows import envelope_rows, envelope_tables
from workbench.report.postures.reach_rows import reach_rows
from workbench.report.tables import csv_text, row_table
from workbench.report.words import contact_sentence, person_words

__all__ = ["postures_rows", "postures_tables"]

Point = tuple[float, float, float]


def postures_rows(found: PosturesFound) -> PosturesRows:
    """Convert what was found of people in postures to millimetres, degrees and words."""
    contacts = [row for person in found.people for row in _contact_rows(found, person)]
    for (one, other), rows in found.between.items():
        contacts += _rows(found, rows, (one, other, "between_people"))
    return PosturesRows(
        row=found.row or None,
        cases=list(found.cases),
        parts=list(found.environment.parts),
        people=[_person_row(found, index) for index in range(len(found.people))],
        contacts=contacts,
        reaches=reach_rows(found),
        envelopes=envelope_rows(found),
    )


def postures_tables(found: Sequence[PosturesRows]) -> dict[str, str]:
    """File name to CSV text: contacts, clearance (long form), stops, reaches and envelopes; with
    the size first where several sizes take a role one at a time."""
    lead = ["size"] if any(rows.row for rows in found) else []
    tables = {
        "contacts.csv": row_table(
            ContactRow, ((_lead(rows), row) for rows in found for row in rows.contacts), lead=lead
        ),
        "clearance.csv": csv_text(
            [*lead, "case", "person", "segment", "part", "clearance_mm"],
            (line for rows in found for line in _clearances(rows)),
        ),
        "stops.csv": row_table(
            StopRow,
            (
                ([*_lead(rows), person.name], row)
                for rows in found
                for person in rows.people
                for row in person.stops
            ),
            lead=[*lead, "person"],
        ),
    }
    if any(rows.reaches for rows in found):
        reaches = ((_lead(rows), row) for rows in found for row in rows.reaches)
        tables["reaches.csv"] = row_table(ReachRow, reaches, lead=lead)
    return tables | envelope_tables(found)


def _lead(rows: PosturesRows) -> list[str]:
    return [rows.row] if rows.row else []


def _clearances(rows: PosturesRows) -> Iterator[list[object]]:
    for person in rows.people:
        for case, table in zip(rows.cases, person.clearance_mm, strict=True):
            for segment, line in zip(person.segments, table, strict=True):
                for part, value in zip(rows.parts, line, strict=True):
                    if value is not None:
                        yield [*_lead(rows), case, person.name, segment, part, value]


def _person_row(result: PosturesFound, index: int) -> PersonRow:
    found = result.people[index]
    role = found.role
    body = found.body
    return PersonRow(
        name=role.name,
        description=person_words(found),
        body=body.name,
        seat=role.seat,
        size={
            name: _micro(value if name == "mass" else 1000 * value)
            for name, value in role.size.measures.items()
        }
        if role.size
        else None,
        postures=list(found.postures),
        segments=list(body.segments),
        clearance_mm=[
            [[_micro(1000 * d) if math.isfinite(d) else None for d in row] for row in case]
            for case in found.clearance.distance.tolist()
        ],
        stops=[
            StopRow(
                case=result.cases[p],
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


def _contact_rows(result: PosturesFound, person: PersonFound) -> list[ContactRow]:
    return _rows(result, person.contacts, (person.name, "", "environment")) + _rows(
        result, person.self_contacts, (person.name, "", "self")
    )


def _rows(result: PosturesFound, contacts: Contacts, who: tuple[str, str, str]) -> list[ContactRow]:
    """The deepest contact of each case and pair, greatest excess first."""
    deepest = contacts.deepest()
    order = np.lexsort((deepest.sphere, -deepest.excess, deepest.pose))
    return [_contact_row(result, deepest.rows(order), (row, *who)) for row in range(len(order))]


def _contact_row(
    result: PosturesFound, contacts: Contacts, at: tuple[int, str, str, str]
) -> ContactRow:
    row, person, other_person, kind = at
    polygons = isinstance(contacts.other, Environment)
    sphere = int(contacts.sphere[row])
    part = int(contacts.part[row])
    return ContactRow(
        case=result.cases[contacts.pose[row]],
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
