"""The part of the page about motions: positions, the story in words, timelines, curves, tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.draw.views import four_views
from workbench.draw.web.motion_view import motion_view
from workbench.draw.web.snippet import STILL
from workbench.files.results.motions import MeetingRow, MotionRows
from workbench.files.results.result import FindingRow, ResultFile
from workbench.model.arrays import Floats
from workbench.model.motion_case import ContactEvent
from workbench.model.result import MotionFound, Result
from workbench.model.units import plain, tenths
from workbench.motion.signals import GRAVITY
from workbench.report.circles import circle_figure
from workbench.report.motions.charts import clearance_curves, curves, timeline
from workbench.report.motions.compared import compared_section
from workbench.report.motions.paired_proportions import decisive_time, paired_motions
from workbench.report.motions.people import moving_people
from workbench.report.motions.pictures import FILM_CAPTION, motion_positions, motion_scene
from workbench.report.motions.sentences import (
    agreement_sentence,
    breach_sentence,
    happening,
    meeting_sentence,
)
from workbench.report.section import Making, Section, SectionWriter
from workbench.report.sentences import milliseconds
from workbench.report.templates import template
from workbench.report.turnable import Look, PageViews, close_up, look, still_picture
from workbench.study.unasked import unasked_meetings

__all__ = ["motion_words", "motions_sections", "unasked_lines"]

_POSITIONS = 5
_COLOURS = ("warm", "blue")
_CAPTION = "spheres are red while they are deeper in something than is allowed"
_MOST_LINES = 14
_MOST_FORCES = 6
_FIGURES = {
    "peak": "Peak",
    "3 ms": "Held for 3 ms",
    "HIC15": "HIC15",
    "HIC36": "HIC36",
    "HIC": "HIC, any window",
    "delta-v": "Change of velocity",
}
"""Figures of signals, and the headings of their columns."""


def motions_sections(result: Result, rows: ResultFile, making: Making) -> list[Section]:
    """The sections of a page about the motions of a result.

    Parameters
    ----------
    making
        What the sections of the page share; a turnable picture is added for each motion.
    """
    making.progress("pictures of the motion")
    found = result.motions
    moments = _moments(found)
    positions = motion_positions([m.study for m in found], moments)
    several = len(found) > 1
    colours = [_COLOURS[k % len(_COLOURS)] for k in range(len(found))]
    decisive = [decisive_time([motion]) for motion in found]
    shown = [
        replace(motion_view(motion, colour, moments=decisive), begin=time, look_from="left")
        for motion, colour, time in zip(found, colours, decisive, strict=True)
    ]
    sections = []
    for k, (motion, row) in enumerate(zip(found, rows.motions, strict=True)):
        index = making.views.add(
            shown[k],
            case=motion.study.name or motion.study.case,
            near=partial(_near, motion, colours[k]),
        )
        drawings, side = positions[k]
        moment = motion_scene(motion.study, decisive[k], colours[k])
        html = template("motions/happens.html.j2").render(
            m=_motion(motion, row, index),
            making=making,
            turnable=_place(making.views, index, motion, colours[k]),
            positions=[
                (Markup(drawing), milliseconds(t), happening(motion, t))
                for drawing, t in zip(drawings, moments.tolist(), strict=True)
            ],
            side=side,
            circles=circle_figure(moment, f"{row.name or row.case} at {milliseconds(decisive[k])}"),
            film=making.film if not k else "",
            film_caption=FILM_CAPTION,
        )
        title = f"What happens: {row.name}" if several else "What happens"
        sections.append(Section("questions", f"motion-{k + 1}", title, Markup(html)))
    if several:
        both = paired_motions(result, shown, colours, making.views)
        sections.append(compared_section(rows, both=both))
    return [*sections, moving_people(found, moments), *_tables(result, rows, making)]


def _tables(result: Result, rows: ResultFile, making: Making) -> Iterator[Section]:
    """The sections of signals, of how far two motions are apart, of contacts and joint stops."""

    writer = SectionWriter("motions", {"rows": rows, "making": making})
    known = {figure.name for m in rows.motions for s in m.signals for figure in s.figures}
    signals = [(m.name, signal) for m in rows.motions for signal in m.signals]
    if signals:
        figures = {name: words for name, words in _FIGURES.items() if name in known}
        pulses = dict.fromkeys(m.pulse for m in rows.motions if m.pulse)
        shown = {"signals": signals, "figures": figures, "pulses": pulses}
        yield writer.section("tables", "signals", "Signals", shown)
    if rows.agreement:
        one, two = (result.motions[case].study.name for case in result.study.compare or (0, 1))
        words = agreement_sentence(result.agreements, two)
        title = f"{one[:1].upper()}{one[1:]} against {two}"
        yield writer.section("tables", "agreement", title, {"agreed": words})
    contacts = [
        (m.name, row, _table_look(making.views, m, row)) for m in rows.motions for row in m.contacts
    ]
    if contacts:
        forces = any(row.force_n is not None for _, row, _ in contacts)
        counts = [_count_words(m) for m in rows.motions]
        values = {"contacts": contacts, "forces": forces, "counts": counts}
        yield writer.section("tables", "motion-contacts", "Contacts", values)
    stops = [(m.name, row) for m in rows.motions for row in m.stops]
    if stops:
        title = "Joints past their stops"
        yield writer.section("tables", "motion-stops", title, {"stops": stops})


def _table_look(views: PageViews, motion: MotionRows, row: MeetingRow) -> Look:
    if not _is_deep(row):
        return Look()
    view = views.of_case(motion.name or motion.case)
    return look(view, row.point_mm, row.deepest_ms, said=row.sentence)


def _count_words(motion: MotionRows) -> str:
    """How many contacts a motion has of which kind: the rows of its table."""
    own = [row for row in motion.contacts if row.kind == "self"]
    deep = [row for row in motion.contacts if row.kind != "self" and _is_deep(row)]
    count = len(motion.contacts)
    rest = count - len(own) - len(deep)
    lead = f"{motion.name}: " if motion.name else ""
    return (
        f"{lead}{count} contact{'s' if count != 1 else ''}: {len(deep)} with parts deeper than "
        f"allowed, {rest} with parts within what is allowed, {len(own)} of the body with itself."
    )


def unasked_lines(result: Result, views: PageViews) -> list[Markup]:
    """The contacts of all motions that no criterion asks about as lines that make the picture of
    the motion look there."""
    lines = []
    for motion in result.motions:
        view = views.of_case(motion.study.name or motion.study.case)
        lead = f"{motion.study.name}: " if len(result.motions) > 1 else ""
        for meeting in unasked_meetings(motion.study.criteria, motion.meetings):
            words = plain(meeting_sentence(meeting))
            text = f"{lead}{words[:1].lower()}{words[1:]}" if lead else words
            lines.append(_look(view, meeting).link(text))
    return lines


def _near(motion: MotionFound, colour: str, finding: FindingRow) -> str:
    """A close-up of a finding, when it is."""
    scene = motion_scene(motion.study, (finding.time_ms or 0.0) / 1000.0, colour)
    label = f"{tenths(abs(finding.value), abs(finding.limit))} {finding.unit}".rstrip()
    return close_up(scene, finding.point_mm or (), label, struck=finding.target)


def _place(views: PageViews, index: int, motion: MotionFound, colour: str) -> Markup:
    """The place of a motion's picture, with a still of what decides it."""
    name = motion.study.name or motion.study.case
    time = decisive_time([motion])
    scene = motion_scene(motion.study, time, colour)
    camera = dict(four_views(scene, width=STILL, height=STILL))["left"]
    words = f"{name} at {milliseconds(time)}, seen from the left"
    still = still_picture(scene, camera)
    return views.place(index, still=still, alt=words, caption=f"{name}: {_CAPTION}")


def motion_words(rows: MotionRows) -> str:
    """Who moves, for how long: "pilot: bubbleman, 121 frames from 0.0 to 120.0 ms"."""
    start, end = rows.span_ms
    body = plain(rows.body)
    return f"{rows.person}: {body}, {rows.frames} frames from {start:.1f} to {end:.1f} ms"


def _motion(motion: MotionFound, rows: MotionRows, view: int) -> dict[str, Any]:
    story, more = _story(motion, view)
    return {
        "rows": rows,
        "story": story,
        "more": more,
        "timeline": Markup(timeline(motion)),
        "clearance": Markup(clearance_curves(motion)),
        "forces": bool(motion.forces),
        "force_curves": Markup(_force_curves(motion)),
        "acceleration": Markup(_acceleration(motion)),
    }


def _acceleration(motion: MotionFound) -> str:
    """The resultant acceleration of each point over time [g]; "" where there is none."""
    if not motion.signals:
        return ""
    time = motion.signals[0].time
    lines = [
        (s.point.name, np.interp(time, s.time, np.linalg.norm(s.acceleration, axis=1)) / GRAVITY)
        for s in motion.signals
    ]
    return curves(time, lines, unit="g", title="Resultant acceleration")


def _is_deep(row: MeetingRow) -> bool:
    return row.depth_mm > row.allowed_mm


def _story(result: MotionFound, view: int) -> tuple[list[Markup], int]:
    """Contacts beyond what is allowed and stops passed, in the order of time; the deepest where
    there are too many."""
    names = dict(zip(result.study.body.joints, result.study.body.joint_names, strict=True))
    told = [
        (m.enter, m.depth - m.allowed, meeting_sentence(m), _look(view, m))
        for m in result.meetings
        if m.depth > m.allowed
    ]
    told += [(b.begin, b.worst * 0.1, breach_sentence(b, names), Look()) for b in result.breaches]
    kept = sorted(told, key=lambda row: -row[1])[:_MOST_LINES]
    ordered = sorted(kept, key=lambda row: row[:3])
    return [place.link(text) for _, _, text, place in ordered], len(told) - len(kept)


def _look(view: int, meeting: ContactEvent) -> Look:
    """Where and when a contact is deepest."""
    return look(view, [1000.0 * value for value in meeting.point], 1000.0 * meeting.deepest)


def _moments(motions: Sequence[MotionFound]) -> Floats:
    """Times worth a picture: the first and last frame, when criteria fail, the deepest moments of
    the deepest contacts of the first motion, the rest evenly."""
    result = motions[0]
    start, end = result.episodes.span
    wanted = [start, end]
    apart = (end - start) / (2 * _POSITIONS)
    failing = [
        v.worst.time
        for motion in motions
        for v in motion.verdicts
        if not v.passed and v.worst is not None and np.isfinite(v.worst.time)
    ]
    deep = sorted(
        (m for m in result.meetings if not m.own and m.depth > m.allowed),
        key=lambda m: m.allowed - m.depth,
    )
    even = np.linspace(start, end, _POSITIONS)
    for time in [*failing, *(m.deepest for m in deep), *even]:
        if len(wanted) < _POSITIONS and min(abs(time - t) for t in wanted) >= apart:
            wanted.append(float(time))
    return np.array(sorted(wanted))


def _force_curves(result: MotionFound) -> str:
    """The strongest forces over time [kN]; "" where there is none."""
    names = dict(zip(result.study.body.segments, result.study.body.segment_names, strict=True))
    strong = sorted(result.forces, key=lambda f: -float(f.force.max()))[:_MOST_FORCES]
    called = [
        f"{names[f.segment]}: {f.part}" if f.segment else f"tension of the {f.part}" for f in strong
    ]
    lines = [(plain(name), f.force / 1000) for name, f in zip(called, strong, strict=True)]
    return (
        curves(result.study.motion.clock, lines, unit="kN", title="Forces over time")
        if lines
        else ""
    )
