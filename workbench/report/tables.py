"""CSV tables of a result, for spreadsheets."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence

from workbench.files.results.result import FindingRow, VerdictRow
from workbench.files.results.row import Row

__all__ = ["csv_parts", "csv_text", "micro", "row_table", "verdict_tables"]

_ROWS = 4096
_FOR_READERS = ("sentence", "normal")
"""Keys of rows that tables leave out."""


def micro(value: float) -> float:
    """Return a number with six decimals: a nanometre or a microdegree, so that the last bits of a
    machine do not show."""
    return round(float(value), 6) + 0.0


def verdict_tables(verdicts: Sequence[VerdictRow]) -> dict[str, str]:
    """File name to CSV text: the verdicts with their worst findings, and all breaches."""
    worst = ["worst_value", "limit", "margin", "unit", "time_ms", "surface_known_to"]
    return {
        "verdicts.csv": csv_text(
            ["criterion", "check", "size", "motion", "passed", *worst, "sentence"],
            (
                [
                    v.name,
                    v.check,
                    v.row,
                    v.motion,
                    _cell(v.passed),
                    *_numbers(v.worst),
                    v.sentence,
                ]
                for v in verdicts
            ),
        ),
        "breaches.csv": row_table(
            FindingRow,
            (([v.name], row) for v in verdicts for row in v.breaches),
            lead=["criterion"],
        ),
    }


def _numbers(worst: FindingRow | None) -> list[object]:
    if worst is None:
        return [None] * 6
    return [
        worst.value,
        worst.limit,
        worst.margin,
        worst.unit,
        worst.time_ms,
        worst.surface_known_to,
    ]


def row_table(
    kind: type[Row], rows: Iterable[tuple[Sequence[object], Row]], *, lead: Sequence[str] = ()
) -> str:
    """Rows of one kind as CSV text: a column for each of their keys, three for a point.

    Parameters
    ----------
    rows
        What comes before each row, and the row.
    lead
        The names of what comes before.
    """
    keys = [key for key in kind.model_fields if key not in _FOR_READERS]
    names: list[str] = []
    for key in keys:
        names += ["x_mm", "y_mm", "z_mm"] if key == "point_mm" else [key]
    return csv_text([*lead, *names], ([*before, *_cells(row, keys)] for before, row in rows))


def _cells(row: Row, keys: Sequence[str]) -> Iterator[object]:
    for key in keys:
        value = getattr(row, key)
        if key == "point_mm":
            yield from value or (None, None, None)
        else:
            yield _cell(value)


def _cell(value: object) -> object:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return value


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
