"""result.json: one shape for every study, read back as it was written."""

from __future__ import annotations

import json
from pathlib import Path

from pydantic import BaseModel, ValidationError

from workbench.errors import InputError
from workbench.files.file_errors import read_whole
from workbench.files.results.motions import AgreementRow, MotionRows
from workbench.files.results.population import PopulationRows
from workbench.files.results.postures import PosturesRows, Row

__all__ = ["MARK", "FindingRow", "ResultFile", "VerdictRow", "dump_json", "load_result"]

MARK = "result.json"
FORMAT = "bubbleman-workbench result 2"


class FindingRow(Row):
    """One measured value in `unit`: mm, deg, g, percent, points, N, or "" of a number; in words:
    `sentence`.

    margin: what is to spare, negative where the criterion is not met. time_ms: null of a posture.
    surface_known_to: how far the true surface may lie from the spheres toward turning the outcome,
    in mm; null where the body does not say. sphere, polygon, other_sphere: the numbers of the
    sphere that is nearest or farthest, and of what it meets: a polygon of the part, or a sphere of
    the other limb.
    """

    case: str
    person: str
    other_person: str | None
    subject: str
    target: str
    value: float
    limit: float
    margin: float
    unit: str
    time_ms: float | None
    point_mm: tuple[float, float, float] | None
    surface_known_to: float | None
    sentence: str
    sphere: int | None = None
    polygon: int | None = None
    other_sphere: int | None = None


class VerdictRow(Row):
    """One criterion: passed or not, the finding nearest to failing, all breaches.

    motion: the case that it is about where cases are motions, row: the size of the person where
    several sizes take a role, else null. doubtful: true where the
    verdict could turn, the body's surface being known no better. interval: of a share, in percent.
    """

    name: str
    check: str
    motion: str | None
    row: str | None
    passed: bool
    doubtful: bool
    sentence: str
    worst: FindingRow | None
    breaches: list[FindingRow]
    interval: tuple[float, float] | None = None


class ResultFile(Row):
    """result.json: verdicts, and what was found of people in postures, of motions, of a population.

    passed: whether every criterion that passes or fails has passed.
    """

    format: str = FORMAT
    study: str
    title: str
    headline: str
    passed: bool
    environment: str
    cases: list[str]
    verdicts: list[VerdictRow]
    postures: list[PosturesRows]
    motions: list[MotionRows]
    agreement: list[AgreementRow]
    population: PopulationRows | None
    warnings: list[str]
    provenance: dict[str, dict[str, str]]


def dump_json(rows: BaseModel) -> str:
    """The text of a result file: the same bytes for the same result."""
    return (
        json.dumps(rows.model_dump(mode="json"), indent=1, ensure_ascii=False, allow_nan=False)
        + "\n"
    )


def load_result(path: Path) -> ResultFile:
    """Read a result.json, or the one in a result's folder.

    Raises
    ------
    InputError
        Where it is no result of this version.
    """
    file = path / MARK if path.is_dir() else path
    try:
        rows = ResultFile.model_validate_json(read_whole(file, "a result"))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(key) for key in first["loc"])
        said = f"{where}: {first['msg']}" if where else first["msg"]
        raise InputError(
            f"{file}: is no result of this version of the workbench ({said})"
        ) from None
    if rows.format != FORMAT:
        raise InputError(f"{file}: has the format {rows.format!r}; this version reads {FORMAT!r}")
    return rows
