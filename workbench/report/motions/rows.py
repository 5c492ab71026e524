"""Motions as the rows of result.json and of the CSV tables, rounded for reading."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from workbench.files.results.motions import (
    AgreementRow,
    BreachRow,
    FigureRow,
    MeetingRow,
    MotionRows,
    SignalRow,
)
from workbench.files.results.result import ResultFile
from workbench.model.arrays import pieces
from workbench.model.body import Body
from workbench.model.motion_case import ContactEvent, ForceCurve, Signal, StopBreach
from workbench.model.result import MotionFound
from workbench.report.motions.movement_summary import movement_sentences
from workbench.report.motions.sentences import breach_sentence, meeting_sentence, pulse_words
from workbench.report.tables import Table, row_table

__all__ = ["motion_rows", "motion_tables"]

_UNITS = {"peak": "g", "3 ms": "g", "delta-v": "m/s"}
_AXES = tuple(
    f"{what}_{axis}"
    for what in ("position_m", "velocity_m_s", "acceleration_m_s2")
    for axis in "xyz"
)


def motion_rows(found: MotionFound) -> MotionRows:
    """Convert what was found of a motion: times in ms, lengths in mm, angles in degrees, speeds in
    m/s."""
    study = found.study
    body = study.body
    start, end = found.episodes.span
    return MotionRows(
        name=study.name,
        case=study.case,
        person=study.person,
        body=body.name,
        frames=len(study.motion),
        span_ms=(_ms(start), _ms(end)),
        contacts=[_meeting(m) for m in found.meetings],
        stops=[_breach(b, body) for b in found.breaches],
        signals=[_signal(s, body.segments[s.point.segment]) for s in found.signals],
        pulse=pulse_words(study.pulse) if study.pulse else None,
        movement=movement_sentences(body, study.motion),
    )


def _breach(breach: StopBreach, body: Body) -> BreachRow:
    """A joint that went beyond its stop."""
    names = dict(zip(body.joints, body.joint_names, strict=True))
    return BreachRow(
        joint=breach.joint,
        motion=breach.motion,
        begin_ms=_ms(breach.begin),
        end_ms=_ms(breach.end),
        worst_ms=_ms(breach.at),
        degrees=round(math.degrees(breach.worst), 2),
        sentence=breach_sentence(breach, names),
    )


def motion_tables(motions: Sequence[MotionFound], rows: ResultFile) -> dict[str, Table]:
    """By name: contacts, stops, figures, clearance and signals over time, forces,
    agreement; the motion of each row comes first."""
    segments = motions[0].study.body.segments
    contacts = (([m.name], row) for m in rows.motions for row in m.contacts)
    stops = (([m.name], row) for m in rows.motions for row in m.stops)
    tables = {
        "contacts": row_table(MeetingRow, contacts, lead=["motion"]),
        "stops": row_table(BreachRow, stops, lead=["motion"]),
        "figures": _figures_table(rows.motions),
        "clearance": Table(["motion", "time_ms", *segments], _clearances(motions)),
        "signals": Table(["motion", "point", "time_ms", *_AXES], _signals(motions)),
    }
    if any(motion.forces for motion in motions):
        tables["forces"] = _forces_table(motions)
    if rows.agreement:
        tables["agreement"] = row_table(AgreementRow, (([], row) for row in rows.agreement))
    return tables


def _forces_table(motions: Sequence[MotionFound]) -> Table:
    """A row for each frame, with a column for each pair of a segment and a part."""
    pairs = list(dict.fromkeys(_pair(force) for motion in motions for force in motion.forces))
    names = [f"{segment or 'tension'} {part} [N]" for segment, part in pairs]
    return Table(["motion", "time_ms", *names], _forces(motions, pairs))


def _figures_table(motions: Sequence[MotionRows]) -> Table:
    """A row for each figure of each signal."""
    head = ["motion", "point", "segment", "filter_class"]
    head += ["figure", "value", "unit", "begin_ms", "end_ms"]
    figures = [
        [m.name, s.name, s.segment, s.filter_class, f.name, f.value, f.unit, f.begin_ms, f.end_ms]
        for m in motions
        for s in m.signals
        for f in s.figures
    ]
    return Table(head, figures)


def _clearances(motions: Sequence[MotionFound]) -> Iterator[list[object]]:
    for motion in motions:
        clock = motion.study.motion.clock
        for rows in pieces(len(clock)):
            metres = motion.clearance[rows].tolist()
            for time, row in zip(clock[rows].tolist(), metres, strict=True):
                cells = (_mm(v) if math.isfinite(v) else None for v in row)
                yield [motion.study.name, _ms(time), *cells]


def _signals(motions: Sequence[MotionFound]) -> Iterator[list[object]]:
    for motion in motions:
        for signal in motion.signals:
            for rows in pieces(len(signal.time)):
                columns = (signal.position, signal.velocity, signal.acceleration)
                table = np.concatenate([column[rows] for column in columns], axis=1)
                for time, row in zip(signal.time[rows].tolist(), table.tolist(), strict=True):
                    values = (round(v, 6) for v in row)
                    yield [motion.study.name, signal.point.name, _ms(time), *values]


def _forces(
    motions: Sequence[MotionFound], pairs: Sequence[tuple[str, str]]
) -> Iterator[list[object]]:
    """Frame by frame the forces of pairs of a segment and a part, None where there is none."""
    for motion in motions:
        known = {_pair(force): force.force for force in motion.forces}
        for frame, time in enumerate(motion.study.motion.clock.tolist()):
            cells = (
                round(float(known[pair][frame]), 1) if pair in known else None for pair in pairs
            )
            yield [motion.study.name, _ms(time), *cells]


def _pair(force: ForceCurve) -> tuple[str, str]:
    return force.segment, force.part


def _ms(seconds: float) -> float:
    return round(1000 * seconds, 4) + 0.0


def _mm(metres: float) -> float:
    return round(1000 * metres, 3) + 0.0


def _meeting(m: ContactEvent) -> MeetingRow:
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
        note=signal.note,
        figures=figures,
    )
