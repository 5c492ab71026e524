"""report.html of a crash study: verdicts, a strip of positions, the story in words, timeline,
curves and tables."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from markupsafe import Markup

from workbench.files.crash.results import CrashResultFile, CrashVerdictRow
from workbench.model.arrays import Floats
from workbench.model.crash import CrashResult
from workbench.motion.signals import GRAVITY
from workbench.report.crash.charts import clearance_curves, curves, timeline
from workbench.report.crash.pictures import FILM_CAPTION, crash_strips
from workbench.report.crash.words import agreement_sentence, breach_sentence, meeting_sentence
from workbench.report.page import part_count, template

__all__ = ["crash_page"]

_POSITIONS = 5
_MOST_LINES = 14
_MOST_FORCES = 6
_FIGURES = ("peak", "3 ms", "HIC15", "HIC36", "delta-v")


def crash_page(
    result: CrashResult,
    rows: CrashResultFile,
    *,
    film: str = "",
    progress: Callable[[str], None] | None = None,
) -> str:
    """The HTML text of a crash study's report; the same bytes for the same result. film: the name
    of its file."""
    if progress is not None:
        progress("pictures of the motion")
    story, more = _story(result)
    lines = [
        (s.point.name, np.linalg.norm(s.acceleration, axis=1) / GRAVITY) for s in result.signals
    ]
    known = {f.name for s in rows.signals for f in s.figures}
    return template("crash/page.html.j2").render(
        rows=rows,
        description=result.study.description,
        parts=part_count(result.study.environment),
        story=story,
        more=more,
        strips=[
            (Markup(strip), caption)
            for strip, caption in crash_strips(result.study, _moments(result))
        ],
        forces=bool(result.forces),
        force_curves=Markup(_force_curves(result)),
        film=film,
        film_caption=FILM_CAPTION,
        timeline=Markup(timeline(result)),
        clearance=Markup(clearance_curves(result)),
        acceleration=Markup(
            curves(result.signals[0].time, lines, unit="g", title="Resultant acceleration")
        )
        if lines
        else "",
        figures=[name for name in _FIGURES if name in known],
        verdicts=_verdicts(rows),
        agreement=agreement_sentence(result.agreements, result.study.against_name)
        if result.agreements
        else "",
    )


def _verdicts(
    rows: CrashResultFile,
) -> list[tuple[str, CrashVerdictRow | None, CrashVerdictRow | None]]:
    """The criteria by name, each with its verdict on the motion and on the second one."""
    one = {verdict.name: verdict for verdict in rows.verdicts}
    two = {verdict.name: verdict for verdict in rows.against_verdicts}
    return [(name, one.get(name), two.get(name)) for name in dict.fromkeys([*one, *two])]


def _story(result: CrashResult) -> tuple[list[str], int]:
    """Contacts beyond what is allowed and stops passed, in the order of time; the deepest where
    there are too many."""
    names = dict(zip(result.study.body.joints, result.study.body.joint_names, strict=True))
    told = [
        (m.enter, m.depth - m.allowed, meeting_sentence(m))
        for m in result.meetings
        if m.depth > m.allowed
    ]
    told += [(b.begin, b.worst * 0.1, breach_sentence(b, names)) for b in result.breaches]
    kept = sorted(told, key=lambda row: -row[1])[:_MOST_LINES]
    return [text for _, _, text in sorted(kept)], len(told) - len(kept)


def _moments(result: CrashResult) -> Floats:
    """Times worth a picture: the first and last frame, the deepest moments of the deepest contacts,
    the rest evenly."""
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


def _force_curves(result: CrashResult) -> str:
    """The strongest forces over time [kN]; "" where there is none."""
    names = dict(zip(result.study.body.segments, result.study.body.segment_names, strict=True))
    strong = sorted(result.forces, key=lambda f: -float(f.force.max()))[:_MOST_FORCES]
    told = [
        f"{names[f.segment]}: {f.part}" if f.segment else f"tension of the {f.part}" for f in strong
    ]
    lines = [(name.replace("_", " "), f.force / 1000) for name, f in zip(told, strong, strict=True)]
    return (
        curves(result.study.motion.clock, lines, unit="kN", title="Forces over time")
        if lines
        else ""
    )
