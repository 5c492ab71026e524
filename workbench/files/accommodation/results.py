"""The published shape of an accommodation study's result.json, and reading it back."""

from __future__ import annotations

from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from workbench.errors import InputError
from workbench.files.opening import read_whole
from workbench.files.results import MARK

__all__ = [
    "AccommodationResultFile",
    "GainRow",
    "GroupRow",
    "HardRow",
    "MapRow",
    "PeopleRow",
    "RequirementRow",
    "ShareVerdictRow",
    "load_accommodation_result",
]


class _Row(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class GroupRow(_Row):
    """The share, 0 to 1, of a group that is served, and its interval; count: people in it."""

    group: str
    share: float
    low: float
    high: float
    count: int


class ShareVerdictRow(_Row):
    """A share that is asked for: of those who meet the criteria `of` (all where there is none),
    with its interval, all 0 to 1."""

    name: str
    passed: bool
    of: list[str]
    at_least: float
    share: float
    low: float
    high: float
    sentence: str


class RequirementRow(_Row):
    """One requirement: share: of those who meet it; without: who would be served if it were
    dropped; alone: who are left out by nothing else; spread_mm: margins at 1, 5, 50, 95 and 99 % of
    the people, null where it applies to nobody."""

    name: str
    criterion: str
    check: str
    target: str
    zone: int
    share: float
    without: float
    alone: float
    spread_mm: list[float | None]


class PeopleRow(_Row):
    """Everybody, one entry a person in every list, and one a requirement in every list of margins
    and reasons.

    margin_mm: null where it does not apply, negative where it is not met; reason: index into
    `reasons`, -1 where nothing limits; seat_mm: forward and up; stature_mm: null where it is not
    known; limiting: the measure that leaves the person out, "" for whom all is met.
    """

    label: list[str]
    sex: list[str]
    weight: list[float]
    stature_mm: list[float] | None
    served: list[bool]
    limiting: list[str]
    seat_mm: list[tuple[float, float]]
    margin_mm: list[list[float | None]]
    reason: list[list[int]]


class HardRow(_Row):
    """One of the people hardest to serve, at the requirement that is missed by most."""

    person: str
    sex: str
    requirement: str
    margin_mm: float
    reason: str
    limiting: str


class GainRow(_Row):
    """What a change of the design gains, shares 0 to 1; rate_per_mm: the share of this requirement
    by a millimetre; margin_rate: millimetres of margin by a millimetre, mean of those who do not
    meet it, null where not known."""

    words: str
    requirement: str
    move_mm: float
    rate_per_mm: float
    margin_rate: float | None
    before: float
    after: float
    joint_before: float
    joint_after: float


class MapRow(_Row):
    """A population reach map: for each point its place and the share of people who reach it."""

    part: str
    grip: str
    zone: int
    hand: str
    points_mm: list[tuple[float, float, float]]
    flat_mm: list[tuple[float, float]]
    share: list[float]


class AccommodationResultFile(_Row):
    """result.json of an accommodation study."""

    format: str = "bubbleman-workbench accommodation 1"
    study: str
    title: str
    environment: str
    seat: str
    body: str
    population: str
    people_hash: str
    seed: int | None
    confidence: float
    headline: str
    shares: list[GroupRow]
    requirements: list[RequirementRow]
    hardest: list[HardRow]
    gains: list[GainRow]
    maps: list[MapRow]
    reasons: list[str]
    people: PeopleRow
    warnings: list[str]
    provenance: dict[str, dict[str, str]]
    verdicts: list[ShareVerdictRow] = []


def load_accommodation_result(path: Path) -> AccommodationResultFile:
    """Read the result.json of an accommodation study, or the one in its folder. InputError where it
    is none."""
    file = path / MARK if path.is_dir() else path
    try:
        return AccommodationResultFile.model_validate_json(read_whole(file, "a result"))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(str(key) for key in first["loc"])
        said = f"{where}: {first['msg']}" if where else first["msg"]
        raise InputError(
            f"{file}: is no result of an accommodation study of this version ({said})"
        ) from None
