"""People in postures as the rows of result.json."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.files.results.postures import (
    ContactRow,
    PersonRow,
    PostureRow,
    PosturesRows,
    ReachRow,
    StopRow,
)
from workbench.model.body import DIRECTIONS, Body
from workbench.model.contacts import Contacts
from workbench.model.criterion import short_words
from workbench.model.environment import Environment
from workbench.model.joint_angles import angles_of, named_angles
from workbench.model.poses import Poses
from workbench.model.quaternions import from_matrices
from workbench.model.reach import DOUBTS
from workbench.model.result import ControlReach, PersonFound, PosturesFound
from workbench.report.postures.envelopes import envelope_rows, envelope_tables
from workbench.report.sentences import contact_sentence, person_words
from workbench.report.tables import Table, micro, row_table

__all__ = [
    "Held",
    "doubt_sentence",
    "held_tables",
    "posture_row",
    "posture_rows",
    "posture_tables",
    "postures_rows",
    "postures_tables",
    "reach_rows",
    "seat_position",
]

Point = tuple[float, float, float]


@dataclass(frozen=True)
class _Who:
    """Whose contacts rows are about: one person, "" or the other one, and the kind of contact."""

    person: str
    other: str
    kind: str


def postures_rows(found: PosturesFound) -> PosturesRows:
    """Convert what was found of people in postures to millimetres, degrees and words."""
    contacts = []
    for person in found.people:
        contacts += _rows(found, person.contacts, _Who(person.name, "", "environment"))
        contacts += _rows(found, person.self_contacts, _Who(person.name, "", "self"))
    for (one, other), rows in found.between.items():
        contacts += _rows(found, rows, _Who(one, other, "between_people"))
    return PosturesRows(
        row=found.row or None,
        cases=list(found.cases),
        parts=list(found.environment.parts),
        people=[_person_row(found, person) for person in found.people],
        contacts=contacts,
        reaches=reach_rows(found),
        envelopes=envelope_rows(found),
        settings={
            one.column: micro(one.at / one.shown_unit) for one in found.environment.adjustments
        },
    )


def postures_tables(found: Sequence[PosturesRows]) -> dict[str, Table]:
    """By name: contacts, clearance (long form), stops, reaches and envelopes; with
    the size first where several sizes take a role one at a time."""
    lead = ["size"] if any(rows.row for rows in found) else []
    contacts = ((_lead(rows), row) for rows in found for row in rows.contacts)
    clearances = (line for rows in found for line in _clearances(rows))
    stops = (
        ([*_lead(rows), person.name], row)
        for rows in found
        for person in rows.people
        for row in person.stops
    )
    head = [*lead, "case", "person", "segment", "part", "clearance_mm"]
    tables = {
        "contacts": row_table(ContactRow, contacts, lead=lead),
        "clearance": Table(head, clearances),
        "stops": row_table(StopRow, stops, lead=[*lead, "person"]),
        **posture_tables(found),
    }
    if any(rows.reaches for rows in found):
        reaches = ((_lead(rows), row) for rows in found for row in rows.reaches)
        tables["reaches"] = row_table(ReachRow, reaches, lead=lead)
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


def _person_row(result: PosturesFound, found: PersonFound) -> PersonRow:
    """A person: size, postures, clearances and joint stops."""
    role = found.role
    size = None
    if role.size:
        measures = role.size.measures.items()
        size = {name: micro(v if name == "mass" else 1000 * v) for name, v in measures}
    return PersonRow(
        name=role.name,
        description=person_words(found),
        body=found.body.name,
        seat=role.seat,
        seat_mm=seat_position(found),
        size=size,
        postures=posture_rows(result, found),
        segments=list(found.body.segments),
        clearance_mm=[
            [[micro(1000 * d) if math.isfinite(d) else None for d in row] for row in case]
            for case in found.clearance.distance.tolist()
        ],
        stops=[
            _stop_row(result, found, p, j)
            for p in range(len(found.placed))
            for j in range(len(found.body.joints))
        ],
    )


def _stop_row(result: PosturesFound, found: PersonFound, p: int, j: int) -> StopRow:
    """The margin of joint j to its stop in case p; none where the joint has no stop."""
    margin = found.margin[p, j]
    stops = math.isfinite(margin)
    return StopRow(
        case=result.cases[p],
        joint=found.body.joints[j],
        margin_deg=micro(math.degrees(margin)) if stops else None,
        motion=found.margin_motion[p][j] if stops else None,
    )


def _rows(result: PosturesFound, contacts: Contacts, who: _Who) -> list[ContactRow]:
    """The deepest contact of each case and pair, greatest excess first."""
    deepest = contacts.deepest()
    deepest = deepest.rows(np.lexsort((deepest.sphere, -deepest.excess, deepest.pose)))
    return [_contact_row(result, deepest, row, who) for row in range(len(deepest.sphere))]


def _contact_row(result: PosturesFound, contacts: Contacts, row: int, who: _Who) -> ContactRow:
    """One contact: the sphere, what it touches, and how deep it is."""
    body = contacts.body
    segment = contacts.segment[row]
    sphere = int(contacts.sphere[row])
    touched = _touched(contacts, row)
    sentence = contact_sentence(contacts, row, whose=who.other)
    x, y, z = (micro(float(v)) for v in contacts.normal[row])
    return ContactRow(
        case=result.cases[contacts.pose[row]],
        person=who.person,
        other_person=who.other or None,
        kind=who.kind,
        segment=body.segments[segment],
        sphere=sphere - int(body.start[segment]),
        subpart=body.sphere_names[sphere] or None,
        direction=DIRECTIONS[contacts.facing[row]],
        part=touched.part,
        polygon=touched.polygon,
        other_segment=touched.segment,
        other_sphere=touched.sphere,
        distance_mm=micro(1000 * contacts.distance[row]),
        allowed_mm=micro(1000 * contacts.allowed[row]),
        excess_mm=micro(1000 * contacts.excess[row]),
        point_mm=_point(contacts.point[row]),
        normal=(x, y, z),
        sentence=sentence,
    )


@dataclass(frozen=True)
class _Touched:
    """What a sphere touches: a polygon of a part, or a sphere of a segment, by its place there."""

    part: str | None = None
    polygon: int | None = None
    segment: str | None = None
    sphere: int | None = None


def _touched(contacts: Contacts, row: int) -> _Touched:
    other = contacts.other
    if isinstance(other, Environment):
        k = int(contacts.part[row])
        return _Touched(
            part=other.parts[k], polygon=int(contacts.polygon[row] - other.part_start[k])
        )
    n = contacts.other_segment[row]
    return _Touched(
        segment=other.segments[n], sphere=int(contacts.other_sphere[row] - other.start[n])
    )


def _point(point: object) -> Point:
    return tuple(micro(1000 * float(v)) for v in point)  # type: ignore[attr-defined, return-value]


_TURN_PLACES = 9
"""Decimals of a quaternion: a millionth of a millimetre at the end of an arm."""


def posture_rows(result: PosturesFound, found: PersonFound) -> list[PostureRow]:
    """Return the posture of a person in each case: joint angles, and where the body is placed."""
    return [
        posture_row(found.body, found.poses.rows(slice(p, p + 1)), case, found.postures[p])
        for p, case in enumerate(result.cases)
    ]


def posture_row(body: Body, poses: Poses, case: str, name: str) -> PostureRow:
    """Return one pose of a body in a case, as it is called there."""
    (angles,) = angles_of(body, poses)
    (world,) = poses.world_from_reference
    (turn,) = from_matrices(world[None, :, :3])
    return PostureRow(
        case=case,
        name=name,
        angles_deg={
            joint: {motion: micro(degrees) for motion, degrees in motions.items()}
            for joint, motions in named_angles(body, angles).items()
        },
        reference=body.segments[poses.reference],
        position_mm=(micro(1e3 * world[0, 3]), micro(1e3 * world[1, 3]), micro(1e3 * world[2, 3])),
        rotation=_rounded(turn.tolist()),
    )


def _rounded(turn: Sequence[float]) -> tuple[float, float, float, float]:
    w, x, y, z = (round(value, _TURN_PLACES) + 0.0 for value in turn)
    return w, x, y, z


def seat_position(found: PersonFound) -> tuple[float, float] | None:
    """Return the position of the seat of a person, forward and up [mm]; None without a seat."""
    if found.role.seat is None:
        return None
    return micro(1e3 * found.forward), micro(1e3 * found.up)


def posture_tables(found: Sequence[PosturesRows]) -> dict[str, Table]:
    """Return by name: the joint angles, and the placements with the seats; with the
    size first where several sizes take a role one at a time."""
    lead = ["size"] if any(rows.row for rows in found) else []
    held = [
        Held(
            [*([rows.row] if rows.row else []), posture.case, person.name], person.seat_mm, posture
        )
        for rows in found
        for person in rows.people
        for posture in person.postures
    ]
    return held_tables([*lead, "case", "person"], held)


@dataclass(frozen=True)
class Held:
    """A posture that somebody holds: what leads its lines in a table, the position of the seat
    [mm], None without one, and the posture."""

    lead: Sequence[object]
    seat_mm: tuple[float, float] | None
    posture: PostureRow


def held_tables(head: Sequence[str], held: Sequence[Held]) -> dict[str, Table]:
    """Return by name: joint angles, and placements with the seats.

    Parameters
    ----------
    head
        The names of what leads the lines.
    held
        The postures.
    """
    place = ["reference", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"]
    return {
        "postures": Table([*head, "joint", "motion", "angle_deg"], _angles(held)),
        "placements": Table(
            [*head, "posture", *place, "seat_forward_mm", "seat_up_mm"], _placements(held)
        ),
    }


def _angles(held: Sequence[Held]) -> Iterator[list[object]]:
    for one in held:
        for joint, motions in one.posture.angles_deg.items():
            for motion, degrees in motions.items():
                yield [*one.lead, joint, motion, degrees]


def _placements(held: Sequence[Held]) -> Iterator[list[object]]:
    for one in held:
        posture = one.posture
        yield [
            *one.lead,
            posture.name,
            posture.reference,
            *posture.position_mm,
            *posture.rotation,
            *(one.seat_mm or (None, None)),
        ]


def reach_rows(result: PosturesFound) -> list[ReachRow]:
    """The reaches of a result in millimetres and words."""
    return [
        ReachRow(
            person=row.person,
            control=row.control,
            zone=row.zone,
            own_zone=row.own_zone,
            limb=row.limb,
            reached=row.reached,
            miss_mm=0.0 if row.reached else round(1000 * row.miss, 3),
            overlap_mm=round(1000 * row.overlap, 3),
            limit=row.limit.text,
            spare_mm=None if row.spare is None else round(1000 * row.spare, 3),
            discomfort=round(row.discomfort, 4),
            doubt=row.doubt,
            sentence=_sentence(row),
        )
        for row in result.reaches
    ]


def _sentence(row: ControlReach) -> str:
    lead = f"{row.person}, zone {row.zone}: "
    if row.reached:
        return f"{lead}the {row.limb} reaches {row.control}."
    return f"{lead}{short_words(row.limb, row.control, row.miss, row.overlap, row.limit)}."


def doubt_sentence(ends: Sequence[str]) -> str:
    """Return how many reaches obstacles put in doubt, and how these ended; "" where none was."""
    certain, soon, other, kept, proved = (ends.count(end) for end in DOUBTS)
    doubted = len(ends) - certain
    if not doubted:
        return ""
    ways = [
        f"{count} {'was' if count == 1 else 'were'} solved by {how}"
        for count, how in ((soon, "a small change of posture"), (other, "another posture"))
        if count
    ]
    if kept:
        ways.append(f"for {kept} no clear posture was found, which does not prove that none exists")
    if proved:
        ways.append(f"for {proved} none exists, because the control is too deep inside a part")
    lead = f"In {doubted} of {len(ends)} reaches an obstacle was in the way at first"
    return f"{lead}: {', '.join(ways)}."
