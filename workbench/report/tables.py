"""CSV tables of a result, for spreadsheets."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence

from workbench.files.results import ResultFile

__all__ = ["csv_parts", "csv_tables", "csv_text"]

_ROWS = 4096


def csv_tables(result: ResultFile) -> dict[str, str]:
    """File name to CSV text: verdicts, breaches, contacts, clearance (long form), stops."""
    return {
        "verdicts.csv": csv_text(
            [
                "criterion",
                "check",
                "passed",
                "worst_value",
                "limit",
                "unit",
                "surface_known_to",
                "sentence",
            ],
            (
                [v.name, v.check, "yes" if v.passed else "no", *_numbers(v.worst), v.sentence]
                for v in result.verdicts
            ),
        ),
        "breaches.csv": csv_text(
            [
                "criterion",
                "case",
                "person",
                "other_person",
                "subject",
                "target",
                "value",
                "limit",
                "unit",
                "surface_known_to",
            ],
            (
                [
                    v.name,
                    b.case,
                    b.person,
                    b.other_person,
                    b.subject,
                    b.target,
                    b.value,
                    b.limit,
                    b.unit,
                    b.surface_known_to,
                ]
                for v in result.verdicts
                for b in v.breaches
            ),
        ),
        "contacts.csv": csv_text(
            [
                "case",
                "person",
                "other_person",
                "kind",
                "segment",
                "sphere",
                "subpart",
                "direction",
                "part",
                "polygon",
                "other_segment",
                "other_sphere",
                "distance_mm",
                "allowed_mm",
                "excess_mm",
                "x_mm",
                "y_mm",
                "z_mm",
            ],
            (
                [
                    c.case,
                    c.person,
                    c.other_person,
                    c.kind,
                    c.segment,
                    c.sphere,
                    c.subpart,
                    c.direction,
                    c.part,
                    c.polygon,
                    c.other_segment,
                    c.other_sphere,
                    c.distance_mm,
                    c.allowed_mm,
                    c.excess_mm,
                    *c.point_mm,
                ]
                for c in result.contacts
            ),
        ),
        "clearance.csv": csv_text(
            ["case", "person", "segment", "part", "clearance_mm"],
            (
                [case, person.name, segment, part, value]
                for person in result.people
                for case, rows in zip(result.cases, person.clearance_mm, strict=True)
                for segment, row in zip(person.segments, rows, strict=True)
                for part, value in zip(result.parts, row, strict=True)
                if value is not None
            ),
        ),
        "stops.csv": csv_text(
            ["case", "person", "joint", "margin_deg", "motion"],
            (
                [s.case, p.name, s.joint, s.margin_deg, s.motion]
                for p in result.people
                for s in p.stops
            ),
        ),
    }


def _numbers(worst: object) -> list[object]:
    return [
        getattr(worst, "value", ""),
        getattr(worst, "limit", ""),
        getattr(worst, "unit", ""),
        getattr(worst, "surface_known_to", ""),
    ]


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """CSV text; a cell that a spreadsheet would take for a formula is quoted with an apostrophe."""
    return "".join(csv_parts(header, rows))


def csv_parts(header: Sequence[str], rows: Iterable[Sequence[object]]) -> Iterator[str]:
    """As `csv_text`, some rows at a time."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    for number, row in enumerate(rows, start=1):
        writer.writerow(
            [
                "'" + c if isinstance(c, str) and c.startswith(("=", "+", "-", "@")) else c
                for c in row
            ]
        )
        if not number % _ROWS:
            yield out.getvalue()
            out.seek(0)
            out.truncate()
    yield out.getvalue()
