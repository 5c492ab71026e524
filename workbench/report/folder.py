"""Everything a study leaves behind: result.json, CSV tables, report.html, and the manifest that
lists them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from workbench.files.accommodation.results import AccommodationResultFile
from workbench.files.crash.results import CrashResultFile
from workbench.files.output_file import Content
from workbench.files.output_folder import write_folder
from workbench.files.parquet import has_parquet, parquet_bytes
from workbench.files.results import ResultFile, dump_json
from workbench.model.accommodation import Accommodation
from workbench.model.crash import CrashResult
from workbench.model.result import Result
from workbench.report.accommodation.data import (
    accommodation_file,
    accommodation_lines,
    accommodation_tables,
)
from workbench.report.accommodation.page import accommodation_page
from workbench.report.accommodation.words import accommodation_headline
from workbench.report.crash.data import crash_csv_tables, crash_result_file
from workbench.report.crash.page import crash_page
from workbench.report.crash.pictures import crash_film
from workbench.report.crash.words import crash_headline
from workbench.report.data import result_file
from workbench.report.envelopes.rows import envelope_solids, envelope_tables
from workbench.report.page import page
from workbench.report.reach_rows import reach_tables
from workbench.report.tables import csv_tables
from workbench.report.words import headline

__all__ = ["report_headline", "report_lines", "write_report"]

Say = Callable[[str], None]
AnyResult = Result | CrashResult | Accommodation
AnyFile = ResultFile | CrashResultFile | AccommodationResultFile


def write_report(
    result: AnyResult, folder: Path, *, progress: Say | None = None, tell: Say = lambda line: None
) -> AnyFile:
    """Write a result into a folder, all of it or nothing; returns the rows of result.json.

    The same inputs and versions give the same bytes. tell: called with a line for each of the
    user's files that is kept under another name, see write_folder. InputError where the folder
    cannot be written.
    """
    rows: AnyFile
    if isinstance(result, Accommodation):
        rows, files = _accommodation(result, progress)
    else:
        rows, files = (
            _crash(result, progress)
            if isinstance(result, CrashResult)
            else _clearance(result, progress)
        )
    write_folder(folder, files, holds="result", tell=tell)
    return rows


def report_headline(result: AnyResult) -> str:
    """The whole result in one sentence."""
    if isinstance(result, Accommodation):
        return accommodation_headline(result)
    return crash_headline(result) if isinstance(result, CrashResult) else headline(result)


def report_lines(result: AnyResult, rows: AnyFile) -> list[str]:
    """What the command line says before that: a line for each verdict, or what leaves people
    out."""
    if isinstance(result, Accommodation) or isinstance(rows, AccommodationResultFile):
        return accommodation_lines(result) if isinstance(result, Accommodation) else []
    lines = [
        f"{'passed' if verdict.passed else 'FAILED'}  {verdict.name}: {verdict.sentence}"
        for verdict in rows.verdicts
    ]
    if isinstance(rows, CrashResultFile):
        lines += [
            f"{'passed' if v.passed else 'FAILED'}  {v.name}, {rows.against}: {v.sentence}"
            for v in rows.against_verdicts
        ]
    return lines


def _accommodation(
    result: Accommodation, progress: Say | None
) -> tuple[AccommodationResultFile, dict[str, Content]]:
    rows = accommodation_file(result)
    tables = accommodation_tables(result, rows)
    files: dict[str, Content] = {"result.json": dump_json(rows), **tables}
    if has_parquet():
        files["people.parquet"] = parquet_bytes(tables["people.csv"])
    return rows, files | {
        "report.html": accommodation_page(result, downloads=[*files], progress=progress)
    }


def _clearance(result: Result, progress: Say | None) -> tuple[ResultFile, dict[str, Content]]:
    rows = result_file(result)
    tables = csv_tables(rows) | reach_tables(rows) | envelope_tables(rows)
    files: dict[str, Content] = {
        "result.json": dump_json(rows),
        **tables,
        **envelope_solids(result),
    }
    return rows, files | {"report.html": page(result, rows, progress=progress)}


def _crash(result: CrashResult, progress: Say | None) -> tuple[CrashResultFile, dict[str, Content]]:
    rows = crash_result_file(result)
    files: dict[str, Content] = {"result.json": dump_json(rows), **crash_csv_tables(result, rows)}
    film = ""
    if result.study.film:
        film, content = crash_film(result.study, progress=progress)
        files[film] = content
    return rows, files | {"report.html": crash_page(result, rows, film=film, progress=progress)}
