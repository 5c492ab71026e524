"""Everything a study leaves behind: result.json, CSV tables, report.html, and the manifest that
lists them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from workbench.files.output_file import Content
from workbench.files.output_folder import write_folder
from workbench.files.parquet import has_parquet, parquet_bytes
from workbench.files.results.result import ResultFile, dump_json
from workbench.model.result import Result
from workbench.report.inspection_text import verdict_lines
from workbench.report.page import page
from workbench.report.postures.envelopes import envelope_solids
from workbench.report.result_rows import result_file, result_tables

__all__ = ["report_lines", "write_report"]

Say = Callable[[str], None]


def write_report(
    result: Result,
    folder: str | Path,
    *,
    film: bool = False,
    progress: Say | None = None,
    tell: Say = lambda line: None,
) -> ResultFile:
    """Write a result into a folder (report.html, tables, result.json), all of it or nothing.

    The same inputs and versions give the same bytes.

    Parameters
    ----------
    film
        Whether a film of the motions is made.
    progress
        Called with words on how far it is.
    tell
        Called with a line for each of the user's files that is kept under another name, see
        write_folder.

    Returns
    -------
    ResultFile
        The rows of result.json.

    Raises
    ------
    InputError
        Where the folder cannot be written.
    """
    rows = result_file(result)
    files: dict[str, Content] = {"result.json": dump_json(rows), **_tables(result, rows)}
    name = ""
    if film:
        from workbench.report.motions.pictures import motion_film  # not loaded for other studies

        name, content = motion_film([m.study for m in result.motions], progress=progress)
        files[name] = content
    files["report.html"] = page(result, rows, files=list(files), film=name, progress=progress)
    write_folder(Path(folder), files, holds="result", tell=tell)
    return rows


def _tables(result: Result, rows: ResultFile) -> dict[str, Content]:
    """Tables and other files beside result.json, of what the result has."""
    tables = result_tables(result, rows)
    files: dict[str, Content] = {
        f"{name}.csv": table.csv_parts() for name, table in tables.items() if name != "people"
    }
    files |= envelope_solids(result.postures)
    if "people" in tables:
        text = tables["people"].csv()
        files["people.csv"] = text
        if has_parquet():
            files["people.parquet"] = parquet_bytes(text)
    return files


def report_lines(result: Result, rows: ResultFile) -> list[str]:
    """What the command line says before the headline: what leaves people out, and a line for each
    verdict."""
    lines = []
    if result.population is not None:
        from workbench.report.population.rows import population_lines

        lines = population_lines(result.population)
    return [*lines, *verdict_lines(rows)]
