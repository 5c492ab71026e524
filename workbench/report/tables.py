"""Tables of a result: as CSV text for spreadsheets, as columns for programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workbench.files.names import unique_names
from workbench.files.results.postures import Row
from workbench.files.results.result import FindingRow, VerdictRow

__all__ = ["Table", "csv_parts", "csv_text", "micro", "row_table", "verdict_tables"]

_ROWS = 4096
_FOR_READERS = ("sentence", "normal")
"""Keys of rows that tables leave out."""


@dataclass(frozen=True)
class Table:
    """Names of columns, and rows of as many cells: numbers, texts, truth values, None where there is
    none. Rows that are made one at a time can be read once."""

    header: Sequence[str]
    rows: Iterable[Sequence[object]]

    def csv(self) -> str:
        """The table as CSV text."""
        return csv_text(self.header, self.rows)

    def csv_parts(self) -> Iterator[str]:
        """As `csv`, some rows at a time."""
        return csv_parts(self.header, self.rows)

    def columns(self) -> dict[str, NDArray[np.generic]]:
        """Column by column arrays with a value a row: truth values, whole numbers, numbers (NaN where
        there is none; so is a column without any value), else texts (None where there is none)."""
        cells = list(zip(*self.rows, strict=True)) or [()] * len(self.header)
        names = unique_names(self.header, "column")
        return {name: _column(values) for name, values in zip(names, cells, strict=True)}


def _column(values: Sequence[object]) -> NDArray[np.generic]:
    """The cells of a column as an array."""
    kinds = {type(value) for value in values}
    if values and kinds <= {bool}:
        return np.array(values, dtype=np.bool_)
    if values and kinds <= {int}:
        return np.array(values, dtype=np.int64)
    if values and kinds <= {int, float, type(None)}:
        return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column


def micro(value: float) -> float:
    """Return a number with six decimals: a nanometre or a microdegree, so that the last bits of a
    machine do not show."""
    return round(float(value), 6) + 0.0


def verdict_tables(verdicts: Sequence[VerdictRow]) -> dict[str, Table]:
    """By name: the verdicts with their worst findings, and all breaches."""
    worst = ["worst_value", "limit", "margin", "unit", "time_ms", "surface_known_to"]
    return {
        "verdicts": Table(
            ["criterion", "check", "size", "motion", "passed", *worst, "sentence"],
            (
                [
                    v.name,
                    v.check,
                    v.row,
                    v.motion,
                    v.passed,
                    *_numbers(v.worst),
                    v.sentence,
                ]
                for v in verdicts
            ),
        ),
        "breaches": row_table(
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
) -> Table:
    """Rows of one kind: a column for each of their keys, three for a point.

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
    return Table([*lead, *names], ([*before, *_cells(row, keys)] for before, row in rows))


def _cells(row: Row, keys: Sequence[str]) -> Iterator[object]:
    for key in keys:
        value = getattr(row, key)
        if key == "point_mm":
            yield from value or (None, None, None)
        else:
            yield value


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """CSV text with yes and no for truth values; a cell that a spreadsheet would take for a formula
    is quoted with an apostrophe."""
    return "".join(csv_parts(header, rows))


def csv_parts(header: Sequence[str], rows: Iterable[Sequence[object]]) -> Iterator[str]:
    """As `csv_text`, some rows at a time."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    for number, row in enumerate(rows, start=1):
        writer.writerow([_csv_cell(cell) for cell in row])
        if not number % _ROWS:
            yield out.getvalue()
            out.seek(0)
            out.truncate()
    yield out.getvalue()


def _csv_cell(cell: object) -> object:
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    return "'" + cell if isinstance(cell, str) and cell.startswith(("=", "+", "-", "@")) else cell
