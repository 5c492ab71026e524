"""The part of the page about motions: positions, the story in words, timelines, curves, tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from workbench.draw.web.motion_view import motion_view
from workbench.files.results.motions import MeetingRow, MotionRows
from workbench.files.results.result import ResultFile
from workbench.model.arrays import Floats
from workbench.model.motion_case import Meeting
from workbench.model.result import MotionFound, Result
from workbench.motion.signals import GRAVITY
from workbench.report.motions.charts import clearance_curves, curves, timeline
from workbench.report.motions.pictures import FILM_CAPTION, motion_strips
from workbench.report.motions.words import agreement_sentence, breach_sentence, meeting_sentence
from workbench.report.templates import template
from workbench.report.turnable import Look, PageViews, look

__all__ = ["motion_words", "motions_section"]

_POSITIONS = 5
_COLOURS = ("warm", "blue")
_CAPTION = "scrub or play; red spheres are deeper in something than is allowed"
_MOST_LINES = 14
_MOST_FORCES = 6
_FIGURES = ("peak", "3 ms", "HIC15", "HIC36", "delta-v")


def motions_section(
    result: Result, rows: ResultFile, *, film: str, say: Callable[[str], None], views: PageViews
) -> Markup:
    """The part of the page about the motions of a result.

    Parameters
    ----------
    film
        The name of a film's file, "" where there is none.
    say
        Called with words on how far it is.
    views
        The turnable pictures of the page; one is added for each motion.
    """
    say("pictures of the motion")
    found = result.motions
    known = {figure.name for m in rows.motions for s in m.signals for figure in s.figures}
    compared = [found[case].study.name for case in result.study.compare or ()]
    strips = motion_strips([m.study for m in found], _moments(found))
    indices = [
        views.add(motion_view(m, _COLOURS[k % len(_COLOURS)]), case=m.study.name or m.study.case)
        for k, m in enumerate(found)
    ]
    html = template("motions/section.html.j2").render(
        film=film,
        film_caption=FILM_CAPTION,
        strips=[
            (_place(views, index, m), Markup(strip), caption)
            for m, index, (strip, caption) in zip(found, indices, strips, strict=True)
        ],
        motions=[
            _motion(m, row, index)
            for m, row, index in zip(found, rows.motions, indices, strict=True)
        ],
        signals=[(m.name, signal) for m in rows.motions for signal in m.signals],
        figures=[name for name in _FIGURES if name in known],
        agreement=rows.agreement,
        compared=compared,
        agreed=agreement_sentence(result.agreements, compared[1]) if rows.agreement else "",
    )
    return Markup(html)


def _place(views: PageViews, index: int, motion: MotionFound) -> Markup:
    name = motion.study.name or motion.study.case
    words = f"{name}: the still pictures of this motion are below"
    return views.place(index, still="", alt=words, caption=f"{name}: {_CAPTION}")


def motion_words(rows: MotionRows) -> str:
    """Who moves, for how long: "pilot: bubbleman, 121 frames from 0.0 to 120.0 ms"."""
    start, end = rows.span_ms
    return f"{rows.person}: {rows.body}, {rows.frames} frames from {start:.1f} to {end:.1f} ms"


def _motion(motion: MotionFound, rows: MotionRows, view: int) -> dict[str, Any]:
    story, more = _story(motion, view)
    return {
        "rows": rows,
        "contacts": [
            (
                row,
                look(view, row.point_mm, row.deepest_ms, said=row.sentence)
                if _is_deep(row)
                else Look(),
            )
            for row in rows.contacts
        ],
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
    lines = [
        (s.point.name, np.linalg.norm(s.acceleration, axis=1) / GRAVITY) for s in motion.signals
    ]
    if not lines:
        return ""
    return curves(motion.signals[0].time, lines, unit="g", title="Resultant acceleration")


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


def _look(view: int, meeting: Meeting) -> Look:
    """Where and when a contact is deepest."""
    return look(view, [1000.0 * value for value in meeting.point], 1000.0 * meeting.deepest)


def _moments(motions: Sequence[MotionFound]) -> Floats:
    """Times worth a picture: the first and last frame, the deepest moments of the deepest contacts
    of the first motion, the rest evenly."""
    result = motions[0]
    start, end = result.episodes.span
    wanted = [start, end]
    apart = (end - start) / (2 * _POSITIONS)
    deep = sorted(
        (m for m in result.meetings if not m.own and m.depth > m.allowed),
        key=lambda m: m.allowed - m.depth,
    )
    for time in [*(m.deepest for m in deep), *np.linspace(start, end, _POSITIONS)]:
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
    lines = [
        (name.replace("_", " "), f.force / 1000) for name, f in zip(called, strong, strict=True)
    ]
    return (
        curves(result.study.motion.clock, lines, unit="kN", title="Forces over time")
        if lines
        else ""
    )
