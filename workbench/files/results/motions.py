"""The part of result.json about motions."""

from __future__ import annotations

from workbench.files.results.postures import Row

__all__ = ["AgreementRow", "BreachRow", "FigureRow", "MeetingRow", "MotionRows", "SignalRow"]


class MeetingRow(Row):
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


class BreachRow(Row):
    """A joint past its stop."""

    joint: str
    motion: str
    begin_ms: float
    end_ms: float
    worst_ms: float
    degrees: float
    sentence: str


class FigureRow(Row):
    """A figure of a signal, and from when to when it is."""

    name: str
    value: float
    unit: str
    begin_ms: float
    end_ms: float


class SignalRow(Row):
    """A point: its filter class and figures. note: how the filter differs from that of SAE J211-1,
    "" where it does not."""

    name: str
    segment: str
    filter_class: int | None
    samples_per_second: float
    note: str = ""
    figures: list[FigureRow]


class AgreementRow(Row):
    """How near a joint or segment is to the other motion's."""

    name: str
    rms_mm: float
    peak_mm: float
    peak_ms: float


class MotionRows(Row):
    """One motion: whose, how long, contacts, joints past their stops, signals, movement in words.

    name: the case, with the role and the size of the person where there are several. pulse: the
    vehicle's own motion in words, null where the study states none.
    """

    name: str
    case: str
    person: str
    body: str
    frames: int
    span_ms: tuple[float, float]
    contacts: list[MeetingRow]
    stops: list[BreachRow]
    signals: list[SignalRow]
    pulse: str | None
    movement: list[str]
