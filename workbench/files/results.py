"""Result files: their published shape."""

from __future__ import annotations

import json
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from workbench.errors import InputError
from workbench.files.crash.results import CrashResultFile
from workbench.files.opening import read_whole

__all__ = ["FindingRow", "PersonRow", "ResultFile", "VerdictRow", "dump_json", "load_result"]

MARK = "result.json"


class _Row(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class FindingRow(_Row):
    """One measured value: lengths in mm, angles in degrees; `sentence` says it in words.

    surface_known_to: how far the true surface may lie from the spheres toward turning the outcome,
    in mm; null where the body does not say.
    """

    case: str
    person: str
    other_person: str | None
    subject: str
    target: str
    value: float
    limit: float
    unit: str
    point_mm: tuple[float, float, float] | None
    surface_known_to: float | None
    sentence: str


class VerdictRow(_Row):
    """One criterion: passed or not, the finding nearest to failing, all breaches.

    doubtful: true where the verdict could turn, the body's surface being known no better.
    """

    name: str
    check: str
    passed: bool
    doubtful: bool
    sentence: str
    worst: FindingRow | None
    breaches: list[FindingRow]


class ContactRow(_Row):
    """One contact: the deepest of a case, a segment and a part (or other segment)."""

    case: str
    person: str
    other_person: str | None
    kind: str
    segment: str
    sphere: int
    subpart: str | None
    direction: str
    part: str | None
    polygon: int | None
    other_segment: str | None
    other_sphere: int | None
    distance_mm: float
    allowed_mm: float
    excess_mm: float
    point_mm: tuple[float, float, float]
    normal: tuple[float, float, float]
    sentence: str


class StopRow(_Row):
    """Margin of one joint in one case; null where the joint is free."""

    case: str
    joint: str
    margin_deg: float | None
    motion: str | None


class PersonRow(_Row):
    """One person: body, size (measures in mm, mass in kg), place, postures by case.

    clearance_mm[case][segment][part]: null where nothing is there.
    """

    name: str
    description: str
    body: str
    seat: str | None
    size: dict[str, float] | None
    postures: list[str]
    segments: list[str]
    clearance_mm: list[list[list[float | None]]]
    stops: list[StopRow]


class ReachRow(_Row):
    """How one person reaches one control in one harness zone; miss_mm is 0 where it is reached."""

    person: str
    control: str
    zone: int
    own_zone: int
    limb: str
    reached: bool
    miss_mm: float
    overlap_mm: float
    limit: str
    discomfort: float
    sentence: str


class EnvelopeRayRow(_Row):
    """One ray of an envelope: its azimuth, and its elevation about the seat reference point or its
    height above it.

    outer, inner: its outermost and innermost reached point, null where none is; clear_*: the same
    clear of obstacles; easy_*, moderate_*: within these grades of discomfort. lost: stretches that
    obstacles take, from and to, and the obstacle.
    """

    azimuth_deg: float
    elevation_deg: float
    height_mm: float
    outer_mm: float | None
    inner_mm: float | None
    clear_outer_mm: float | None
    clear_inner_mm: float | None
    easy_outer_mm: float | None
    easy_inner_mm: float | None
    moderate_outer_mm: float | None
    moderate_inner_mm: float | None
    lost: list[tuple[float, float, str]]


class EnvelopeRow(_Row):
    """One reach envelope: rays about the seat reference point, and level rays about the upright
    axis through it.

    lost_litres_to: what each obstacle takes, by the part that the limb would enter deepest, the
    most first.
    """

    person: str
    limb: str
    zone: int
    people: int
    origin_mm: tuple[float, float, float]
    volume_litres: float
    obstacles: bool
    lost_litres: float
    lost_litres_to: dict[str, float]
    rays: list[EnvelopeRayRow]
    levels: list[EnvelopeRayRow]


class ResultFile(_Row):
    """result.json."""

    format: str = "bubbleman-workbench result 1"
    study: str
    title: str
    passed: bool
    environment: str
    cases: list[str]
    parts: list[str]
    verdicts: list[VerdictRow]
    people: list[PersonRow]
    contacts: list[ContactRow]
    warnings: list[str]
    provenance: dict[str, dict[str, str]]
    reaches: list[ReachRow] = []
    envelopes: list[EnvelopeRow] = []


def dump_json(result: BaseModel) -> str:
    """The text of result.json: the same bytes for the same result."""
    return (
        json.dumps(result.model_dump(mode="json"), indent=1, ensure_ascii=False, allow_nan=False)
        + "\n"
    )


def load_result(path: Path) -> ResultFile | CrashResultFile:
    """Read a result.json, or the one in a result's folder. InputError where it is none of this
    version."""
    file = path / MARK if path.is_dir() else path
    try:
        text = read_whole(file, "a result")
        crash = b'"format": "bubbleman-workbench crash' in text[:1000]
        return (CrashResultFile if crash else ResultFile).model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(key) for key in first["loc"])
        said = f"{where}: {first['msg']}" if where else first["msg"]
        raise InputError(
            f"{file}: is no result of this version of the workbench ({said})"
        ) from None
