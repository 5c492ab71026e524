"""A result as the rows of result.json: millimetres, degrees, milliseconds and words."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from workbench.errors import MissingPartError, UsageError, one_of
from workbench.files.results.motions import AgreementRow
from workbench.files.results.result import FindingRow, ResultFile, VerdictRow
from workbench.model.motion_case import Agreement
from workbench.model.result import Finding, Result, Verdict
from workbench.model.units import UNITS
from workbench.report.headline import headline
from workbench.report.motions.rows import motion_rows
from workbench.report.population.rows import population_rows
from workbench.report.postures.rows import postures_rows, postures_tables
from workbench.report.sentences import finding_sentence, share_sentence, verdict_sentence
from workbench.report.tables import Table, micro, verdict_tables

__all__ = ["result_columns", "result_file", "result_frame", "result_tables", "verdict_row"]

_AT_MOST = ("excursion", "injury", "score", "pedals")
"""Checks of what must not exceed a limit: value and limit stand without their signs."""


def result_file(result: Result) -> ResultFile:
    """Convert a result to the rows of result.json."""
    study = result.study
    people = result.provenance.get("people", {}).get("measures", "")
    return ResultFile(
        study=study.name,
        title=study.title,
        headline=headline(result),
        passed=result.passed,
        environment=study.environment.name,
        cases=[case.name for case in study.cases],
        verdicts=[verdict_row(verdict) for verdict in result.verdicts],
        postures=[postures_rows(found) for found in result.postures],
        motions=[motion_rows(motion) for motion in result.motions],
        agreement=[_agreement_row(agreement) for agreement in result.agreements],
        population=population_rows(result.population, people) if result.population else None,
        warnings=list(result.warnings),
        provenance={kind: dict(rows) for kind, rows in result.provenance.items()},
    )


def _agreement_row(agreement: Agreement) -> AgreementRow:
    return AgreementRow(
        name=agreement.name,
        rms_mm=micro(1000 * agreement.rms),
        peak_mm=micro(1000 * agreement.peak),
        peak_ms=micro(1000 * agreement.at),
    )


def verdict_row(verdict: Verdict) -> VerdictRow:
    """Convert a verdict to a row."""
    share = verdict.share
    return VerdictRow(
        name=verdict.criterion.name,
        check=verdict.criterion.check,
        motion=verdict.motion or None,
        row=verdict.row or None,
        passed=verdict.passed,
        doubtful=verdict.doubtful is not None,
        sentence=verdict_sentence(verdict),
        worst=_finding_row(verdict, verdict.worst) if verdict.worst else None,
        breaches=[_finding_row(verdict, finding) for finding in verdict.breaches],
        interval=(micro(100 * share.low), micro(100 * share.high)) if share else None,
    )


def _finding_row(verdict: Verdict, finding: Finding) -> FindingRow:
    """A measured value in the unit of a file; what must not exceed a limit without its sign."""
    criterion = verdict.criterion
    unit = UNITS[finding.unit]
    sign = -1.0 if criterion.check in _AT_MOST else 1.0
    if verdict.share is not None:
        sentence = share_sentence(criterion, verdict.share)
    else:
        sentence = finding_sentence(criterion.check, finding)
    return FindingRow(
        case=finding.case,
        person=finding.person,
        other_person=finding.other_person or None,
        subject=finding.subject,
        target=finding.target,
        value=micro(sign * unit.scale * finding.value),
        limit=micro(sign * unit.scale * finding.limit),
        margin=micro(unit.scale * finding.margin),
        unit=unit.column,
        time_ms=_thousand(finding.time),
        point_mm=_point(finding),
        surface_known_to=_thousand(finding.surface_known_to),
        sphere=_number(finding.sphere),
        polygon=_number(finding.polygon),
        other_sphere=_number(finding.other_sphere),
        sentence=sentence,
    )


def _thousand(value: float) -> float | None:
    """A length [m] or time [s] in mm or ms; None where it is not finite."""
    return micro(1000 * value) if math.isfinite(value) else None


def _number(index: int) -> int | None:
    """A number that is counted from 0; None where there is none."""
    return index if index >= 0 else None


def _point(finding: Finding) -> tuple[float, float, float] | None:
    """The point of a finding [mm]; None where there is none, or it is not finite."""
    if finding.point is None or not all(map(math.isfinite, finding.point)):
        return None
    x, y, z = (micro(1000 * value) for value in finding.point)
    return x, y, z


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
