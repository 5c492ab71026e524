"""Result files: their published shape, and output folders that appear complete or not at all."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from workbench.errors import InputError
from workbench.files.crash.results import CrashResultFile
from workbench.files.opening import read_whole

__all__ = ["Content", "FindingRow", "PersonRow", "ResultFile", "VerdictRow", "check_folder", "dump_json", "load_result",
           "write_file", "write_folder"]  # fmt: skip

MARK = "result.json"
Content = str | bytes | Iterable[str]
"""What a file holds: a text, bytes, or a text in parts that are made as they are written."""


class _Row(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class FindingRow(_Row):
    """One measured value: lengths in mm, angles in degrees; `sentence` says it in words.

    surface_known_to: how far the true surface may lie from the spheres toward turning the outcome, in mm; null where
    the body does not say.
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
    """One ray of an envelope: its azimuth, and its elevation about the seat reference point or its height above it.

    outer, inner: its outermost and innermost reached point, null where none is; clear_*: the same clear of obstacles;
    easy_*, moderate_*: within these grades of discomfort. lost: stretches that obstacles take, from and to, and the
    obstacle.
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
    """One reach envelope: rays about the seat reference point, and level rays about the upright axis through it.

    lost_litres_to: what each obstacle takes, by the part that the limb would enter deepest, the most first.
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
    kind: str
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
    return json.dumps(result.model_dump(mode="json"), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def load_result(path: Path) -> ResultFile | CrashResultFile:
    """Read a result.json, or the one in a result's folder. InputError where it is none of this version."""
    file = path / MARK if path.is_dir() else path
    try:
        text = read_whole(file, "a result")
        crash = b'"kind": "crash"' in text[:1000]
        return (CrashResultFile if crash else ResultFile).model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(key) for key in first["loc"])
        said = f"{where}: {first['msg']}" if where else first["msg"]
        raise InputError(f"{file}: is no result of this version of the workbench ({said})") from None


def write_file(path: Path, content: Content) -> None:
    """Write one file that appears at once or not at all. InputError where it cannot be written."""
    partial = path.with_name(f".{path.name}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _put(partial, content)
        partial.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None
    finally:
        partial.unlink(missing_ok=True)


def write_folder(folder: Path, files: Mapping[str, Content], *, mark: str = MARK) -> None:
    """Write all files into a folder that appears at once, replacing an earlier result.

    InputError where the folder holds something that is not a result, or cannot be written.
    """
    folder = check_folder(folder, mark=mark)
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        partial = Path(tempfile.mkdtemp(prefix=".partial-", dir=folder.parent))
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror})") from None
    try:
        for name, content in files.items():
            path = partial / name
            path.parent.mkdir(parents=True, exist_ok=True)
            _put(path, content)
        partial.chmod(0o755)
        _swap(partial, folder)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror})") from None
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _put(path: Path, content: Content) -> None:
    if isinstance(content, (str, bytes)):
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return
    with path.open("wb") as file:
        for part in content:
            file.write(part.encode())


def check_folder(folder: Path, *, mark: str = MARK) -> Path:
    """The place of an output folder; InputError where something is there that is not an earlier result, nor empty."""
    try:
        place = folder.resolve()
        foreign = place.exists() and (not place.is_dir() or (any(place.iterdir()) and not (place / mark).is_file()))
    except RuntimeError:
        raise InputError(f"{folder}: cannot be written (symbolic links in a circle)") from None
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror})") from None
    if foreign:
        raise InputError(f"{folder}: is there already and is not a result of the workbench; choose another --out")
    return place


def _swap(partial: Path, folder: Path) -> None:
    """Put the complete folder in place of an old one, which comes back if that fails."""
    if not folder.exists():
        partial.rename(folder)
        return
    old = Path(tempfile.mkdtemp(prefix=".replaced-", dir=folder.parent))
    try:
        folder.replace(old)
        partial.rename(folder)
    finally:
        if not folder.exists():
            old.rename(folder)
        shutil.rmtree(old, ignore_errors=True)
