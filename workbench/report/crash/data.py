"""A crash result as the rows of result.json and of the CSV tables, rounded for reading."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from workbench.files.crash.results import (
    AgreementRow,
    BreachRow,
    CrashResultFile,
    CrashVerdictRow,
    FigureRow,
    MeetingRow,
    SignalRow,
)
from workbench.files.output_file import Content
from workbench.model.crash import CrashResult, CrashVerdict, Meeting, Signal
from workbench.model.spool import pieces
from workbench.report.crash.words import (
    breach_sentence,
    crash_headline,
    meeting_sentence,
    pulse_words,
)
from workbench.report.movement import movement_sentences
from workbench.report.tables import csv_parts, csv_text

__all__ = ["crash_csv_tables", "crash_result_file"]

_UNITS = {"peak": "g", "3 ms": "g", "delta-v": "m/s"}


def crash_result_file(result: CrashResult) -> CrashResultFile:
    """The rows of result.json: times in ms, lengths in mm, angles in degrees, speeds in m/s."""
    study = result.study
    names = dict(zip(study.body.joints, study.body.joint_names, strict=True))
    start, end = result.episodes.span
    return CrashResultFile(
        study=study.name,
        title=study.title,
        passed=result.passed and (result.other is None or result.other.passed),
        headline=crash_headline(result),
        environment=study.environment.name,
        person=study.person,
        body=study.body.name,
        frames=len(study.motion),
        span_ms=(_ms(start), _ms(end)),
        verdicts=[_verdict(v) for v in result.verdicts],
        contacts=[_meeting(m) for m in result.meetings],
        stops=[
            BreachRow(
                joint=b.joint,
                motion=b.motion,
                begin_ms=_ms(b.begin),
                end_ms=_ms(b.end),
                worst_ms=_ms(b.at),
                degrees=round(math.degrees(b.worst), 2),
                sentence=breach_sentence(b, names),
            )
            for b in result.breaches
        ],
        signals=[_signal(s, study.body.segments[s.point.segment]) for s in result.signals],
        motion=study.motion_name,
        against=study.against_name or None,
        agreement=[
            AgreementRow(name=a.name, rms_mm=_mm(a.rms), peak_mm=_mm(a.peak), peak_ms=_ms(a.at))
            for a in result.agreements
        ],
        against_verdicts=[_verdict(v) for v in result.other.verdicts] if result.other else [],
        against_signals=[
            _signal(s, study.body.segments[s.point.segment]) for s in result.other.signals
        ]
        if result.other
        else [],
        pulse=pulse_words(study.pulse) if study.pulse else None,
        movement=movement_sentences(study.body, study.motion),
        warnings=list(result.warnings),
        provenance={key: dict(rows) for key, rows in result.provenance.items()},
    )


def crash_csv_tables(result: CrashResult, rows: CrashResultFile) -> dict[str, Content]:
    """File name to CSV text: verdicts, contacts, stops, figures, clearance and signals over time,
    agreement."""
    body = result.study.body
    tables: dict[str, Content] = {
        "verdicts.csv": csv_text(
            ["criterion", "check", "passed", "value", "limit", "unit", "time_ms", "sentence"],
            (
                [
                    v.name,
                    v.check,
                    "yes" if v.passed else "no",
                    v.value,
                    v.limit,
                    v.unit,
                    v.time_ms,
                    v.sentence,
                ]
                for v in rows.verdicts
            ),
        ),
        "contacts.csv": csv_text(
            [
                "kind",
                "segment",
                "subject",
                "target",
                "met_ms",
                "deepest_ms",
                "parted_ms",
                "depth_mm",
                "allowed_mm",
                "speed_m_s",
                "normal_m_s",
                "tangential_m_s",
                "x_mm",
                "y_mm",
                "z_mm",
                "force_n",
            ],
            (
                [
                    c.kind,
                    c.segment,
                    c.subject,
                    c.target,
                    c.met_ms,
                    c.deepest_ms,
                    c.parted_ms,
                    c.depth_mm,
                    c.allowed_mm,
                    c.speed_m_s,
                    c.normal_m_s,
                    c.tangential_m_s,
                    *c.point_mm,
                    c.force_n,
                ]
                for c in rows.contacts
            ),
        ),
        "stops.csv": csv_text(
            ["joint", "motion", "begin_ms", "end_ms", "worst_ms", "degrees"],
            ([b.joint, b.motion, b.begin_ms, b.end_ms, b.worst_ms, b.degrees] for b in rows.stops),
        ),
        "figures.csv": csv_text(
            ["point", "segment", "filter_class", "figure", "value", "unit", "begin_ms", "end_ms"],
            (
                [s.name, s.segment, s.filter_class, f.name, f.value, f.unit, f.begin_ms, f.end_ms]
                for s in rows.signals
                for f in s.figures
            ),
        ),
        "clearance.csv": csv_parts(["time_ms", *body.segments], _clearance_rows(result)),
        "signals.csv": csv_parts(
            [
                "point",
                "time_ms",
                *(
                    f"{what}_{axis}"
                    for what in ("position_m", "velocity_m_s", "acceleration_m_s2")
                    for axis in "xyz"
                ),
            ],
            _signal_rows(result),
        ),
    }
    if result.forces:
        head = ["time_ms", *(f"{f.segment or 'tension'} {f.part} [N]" for f in result.forces)]
        tables["forces.csv"] = csv_parts(head, _force_rows(result))
    if rows.agreement:
        tables["agreement.csv"] = csv_text(
            ["name", "rms_mm", "peak_mm", "peak_ms"],
            ([a.name, a.rms_mm, a.peak_mm, a.peak_ms] for a in rows.agreement),
        )
    return tables


def _clearance_rows(result: CrashResult) -> Iterator[list[object]]:
    clock = result.study.motion.clock
    for rows in pieces(len(clock)):
        for t, row in zip(clock[rows].tolist(), result.clearance[rows].tolist(), strict=True):
            yield [_ms(t), *(_mm(v) if math.isfinite(v) else None for v in row)]


def _force_rows(result: CrashResult) -> Iterator[list[object]]:
    for p, t in enumerate(result.study.motion.clock):
        yield [_ms(float(t)), *(round(float(f.force[p]), 1) for f in result.forces)]


def _signal_rows(result: CrashResult) -> Iterator[list[object]]:
    for s in result.signals:
        for rows in pieces(len(s.time)):
            columns = np.concatenate(
                [s.position[rows], s.velocity[rows], s.acceleration[rows]], axis=1
            ).tolist()
            for t, row in zip(s.time[rows].tolist(), columns, strict=True):
                yield [s.point.name, _ms(t), *(round(v, 6) for v in row)]


def _ms(seconds: float) -> float:
    return round(1000 * seconds, 4) + 0.0


def _mm(metres: float) -> float:
    return round(1000 * metres, 3) + 0.0


def _verdict(verdict: CrashVerdict) -> CrashVerdictRow:
    when = None if math.isnan(verdict.at) else _ms(verdict.at)
    at = "" if when is None else f" at {when:.1f} ms"
    limit = (
        f" ({verdict.limit:g} {verdict.unit} allowed)"
        if verdict.criterion.check in ("excursion",)
        else ""
    )
    value = None if math.isnan(verdict.value) else round(verdict.value, 3) + 0.0
    return CrashVerdictRow(
        name=verdict.criterion.name,
        check=verdict.criterion.check,
        passed=verdict.passed,
        value=value,
        limit=round(verdict.limit, 3),
        unit=verdict.unit,
        time_ms=when,
        sentence=f"{verdict.told}{at}{limit}.",
    )


def _meeting(m: Meeting) -> MeetingRow:
    x, y, z = (_mm(v) for v in m.point)
    return MeetingRow(
        kind="self" if m.own else "environment",
        segment=m.segment,
        subject=m.who,
        target=m.other,
        met_ms=None if m.began else _ms(m.enter),
        deepest_ms=_ms(m.deepest),
        parted_ms=None if m.lasts else _ms(m.leave),
        depth_mm=_mm(m.depth),
        allowed_mm=_mm(m.allowed),
        speed_m_s=round(m.speed, 3),
        normal_m_s=round(m.normal, 3) + 0.0,
        tangential_m_s=round(m.tangential, 3),
        point_mm=(x, y, z),
        force_n=None if m.force is None else round(m.force, 1),
        sentence=meeting_sentence(m),
    )


def _signal(signal: Signal, segment: str) -> SignalRow:
    rate = (len(signal.time) - 1) / (signal.time[-1] - signal.time[0])
    figures = [
        FigureRow(
            name=name,
            value=round(value, 2),
            unit=_UNITS.get(name, ""),
            begin_ms=_ms(begin),
            end_ms=_ms(end),
        )
        for name, (value, begin, end) in signal.figures.items()
    ]
    return SignalRow(
        name=signal.point.name,
        segment=segment,
        filter_class=signal.cfc,
        samples_per_second=round(float(rate), 3),
        figures=figures,
    )
