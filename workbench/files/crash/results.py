"""The published shape of a crash study's result.json."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

__all__ = [
    "AgreementRow",
    "BreachRow",
    "CrashResultFile",
    "CrashVerdictRow",
    "FigureRow",
    "MeetingRow",
    "SignalRow",
]


class _Row(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class CrashVerdictRow(_Row):
    """One criterion: value and limit in `unit`, at a time; null where nothing happened."""

    name: str
    check: str
    passed: bool
    value: float | None
    limit: float
    unit: str
    time_ms: float | None
    sentence: str


class MeetingRow(_Row):
    """One contact in continuous time. parted_ms is null where it lasts to the end, met_ms where it
    was there before; force_n: at the deepest, null where the study states no law for the pair."""

    kind: str
    segment: str
    subject: str
    target: str
    met_ms: float | None
    deepest_ms: float
    parted_ms: float | None
    depth_mm: float
    allowed_mm: float
    speed_m_s: float
    normal_m_s: float
    tangential_m_s: float
    point_mm: tuple[float, float, float]
    force_n: float | None = None
    sentence: str


class BreachRow(_Row):
    """A joint past its stop."""

    joint: str
    motion: str
    begin_ms: float
    end_ms: float
    worst_ms: float
    degrees: float
    sentence: str


class FigureRow(_Row):
    """A figure of a signal, and from when to when it is."""

    name: str
    value: float
    unit: str
    begin_ms: float
    end_ms: float


class SignalRow(_Row):
    """A point: its filter class and figures."""

    name: str
    segment: str
    filter_class: int | None
    samples_per_second: float
    figures: list[FigureRow]


class AgreementRow(_Row):
    """How near a joint or segment is to the other motion's."""

    name: str
    rms_mm: float
    peak_mm: float
    peak_ms: float


class CrashResultFile(_Row):
    """result.json of a crash study."""

    format: str = "bubbleman-workbench crash 1"
    study: str
    title: str
    passed: bool
    headline: str
    environment: str
    person: str
    body: str
    frames: int
    span_ms: tuple[float, float]
    verdicts: list[CrashVerdictRow]
    contacts: list[MeetingRow]
    stops: list[BreachRow]
    signals: list[SignalRow]
    motion: str = ""
    against: str | None
    agreement: list[AgreementRow]
    against_verdicts: list[CrashVerdictRow] = []
    against_signals: list[SignalRow] = []
    pulse: str | None = None
    movement: list[str]
    warnings: list[str]
    provenance: dict[str, dict[str, str]]
