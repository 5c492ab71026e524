"""The tables of a result: for files, as arrays by column, and as data frames."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.errors import MissingPartError, UsageError, one_of
from workbench.files.results.result import ResultFile
from workbench.model.result import Result
from workbench.report.postures.rows import postures_tables
from workbench.report.result_rows import result_file
from workbench.report.tables import Table, verdict_tables

__all__ = ["result_columns", "result_frame", "result_tables"]


def result_tables(result: Result, rows: ResultFile) -> dict[str, Table]:
    """Return the tables of what a result has, by name.

    Parameters
    ----------
    rows
        The rows of the same result.
    """
    tables = dict(verdict_tables(rows.verdicts)) if rows.verdicts else {}
    if result.postures:
        tables |= postures_tables(rows.postures)
    if result.motions:
        from workbench.report.motions.rows import motion_tables  # not loaded for other studies

        for name, table in motion_tables(result.motions, rows).items():
            tables[f"motion_{name}" if name in tables else name] = table
    if result.population is not None and rows.population is not None:
        from workbench.report.population.rows import population_tables

        tables |= population_tables(result.population, rows.population)
    return tables


def result_columns(result: Result) -> dict[str, dict[str, NDArray[np.generic]]]:
    """Return the tables of a result as arrays by column. See `Result.tables`."""
    tables = result_tables(result, result_file(result))
    return {name: table.columns() for name, table in tables.items()}


def result_frame(result: Result, table: str) -> Any:
    """Return one table of a result as a data frame. See `Result.to_dataframe`.

    Raises
    ------
    MissingPartError
        If pandas is not installed.
    UsageError
        If the result has no such table.
    """
    try:
        import pandas
    except ImportError:
        raise MissingPartError(
            "data frames need pandas: pip install pandas (result.tables() gives the same columns as "
            "arrays)"
        ) from None
    tables = result_tables(result, result_file(result))
    name = table or ("people" if result.population is not None else "verdicts")
    if name not in tables:
        raise UsageError(f"table: this result has no table {name!r}; {one_of(name, tables)}")
    return pandas.DataFrame(tables[name].columns())
