"""Everything a study leaves behind: result.json, CSV tables, report.html."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from workbench.files.results import ResultFile, dump_json, write_folder
from workbench.model.result import Result
from workbench.report.data import result_file
from workbench.report.page import page
from workbench.report.tables import csv_tables

__all__ = ["write_report"]


def write_report(result: Result, folder: Path, *, progress: Callable[[str], None] | None = None) -> ResultFile:
    """Write a result into a folder, all of it or nothing; returns the rows of result.json.

    The same inputs and versions give the same bytes. InputError where the folder cannot be written.
    """
    rows = result_file(result)
    files: dict[str, str | bytes] = {"result.json": dump_json(rows), **csv_tables(rows)}
    files["report.html"] = page(result, rows, progress=progress)
    write_folder(folder, files)
    return rows
