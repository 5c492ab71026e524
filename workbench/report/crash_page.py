"""report.html of a crash study: verdicts, a strip of positions, the story in words, timeline, curves and tables."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from markupsafe import Markup

from workbench.draw.camera import Camera, standard_view
from workbench.draw.outline import outline
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.strip import strip_svg
from workbench.files.crash_results import CrashResultFile
from workbench.model.arrays import Floats
from workbench.model.crash import CrashResult
from workbench.model.moving import poses_at
from workbench.report.crash_charts import clearance_curves, curves, timeline
from workbench.report.crash_words import agreement_sentence, breach_sentence, meeting_sentence, milliseconds
from workbench.report.page import part_count, template
from workbench.solve.forward import place
from workbench.solve.signals import GRAVITY

__all__ = ["crash_page"]

_POSITIONS = 5
_MOST_LINES = 14
_SIZE = 420
_FIGURES = ("peak", "3 ms", "HIC15", "HIC36", "delta-v")


def crash_page(result: CrashResult, rows: CrashResultFile, *, progress: Callable[[str], None] | None = None) -> str:
    """The HTML text of a crash study's report; the same bytes for the same result."""
    if progress is not None:
        progress("pictures of the motion")
    story, more = _story(result)
    strip, caption = _strip(result)
    lines = [(s.point.name, np.linalg.norm(s.acceleration, axis=1) / GRAVITY) for s in result.signals]
    known = {f.name for s in rows.signals for f in s.figures}
    return template("crash.html.j2").render(
        rows=rows,
        description=result.study.description,
        parts=part_count(result.study.environment),
        story=story,
        more=more,
        strip=Markup(strip),
        strip_caption=caption,
        timeline=Markup(timeline(result)),
        clearance=Markup(clearance_curves(result)),
        acceleration=Markup(curves(result.signals[0].time, lines, unit="g", title="Resultant acceleration"))
        if lines
        else "",
        figures=[name for name in _FIGURES if name in known],
        agreement=agreement_sentence(result.agreements, result.study.against_name) if result.agreements else "",
    )


def _story(result: CrashResult) -> tuple[list[str], int]:
    """Contacts beyond what is allowed and stops passed, in the order of time; the deepest where there are too many."""
    names = dict(zip(result.study.body.joints, result.study.body.joint_names, strict=True))
    told = [(m.enter, m.depth - m.allowed, meeting_sentence(m)) for m in result.meetings if m.depth > m.allowed]
    told += [(b.begin, b.worst * 0.1, breach_sentence(b, names)) for b in result.breaches]
    kept = sorted(told, key=lambda row: -row[1])[:_MOST_LINES]
    return [text for _, _, text in sorted(kept)], len(told) - len(kept)


def _moments(result: CrashResult) -> Floats:
    """Times worth a picture: the first and last frame, the deepest moments of the deepest contacts, the rest evenly."""
    start, end = result.episodes.span
    wanted = [start, end]
    apart = (end - start) / (2 * _POSITIONS)
    deep = sorted((m for m in result.meetings if not m.own and m.depth > m.allowed), key=lambda m: m.allowed - m.depth)
    for time in [*(m.deepest for m in deep), *np.linspace(start, end, _POSITIONS)]:
        if len(wanted) < _POSITIONS and min(abs(time - t) for t in wanted) >= apart:
            wanted.append(float(time))
    return np.array(sorted(wanted))


def _strip(result: CrashResult) -> tuple[str, str]:
    """The body (and the one it is compared with) at a few moments, seen from the side that shows most of its way."""
    study, times = result.study, _moments(result)
    shown = [place(study.body, poses_at(study.motion, times))]
    if study.against is not None:
        shown.append(place(study.body, poses_at(study.against, times)))
    low = np.min([(p.centres - study.body.radius[:, None]).min(axis=(0, 1)) for p in shown], axis=0)
    high = np.max([(p.centres + study.body.radius[:, None]).max(axis=(0, 1)) for p in shown], axis=0)
    view = "left" if high[0] - low[0] >= high[1] - low[1] else "front"
    camera: Camera = standard_view(view, np.array([low - 0.1, high + 0.1]), width=_SIZE, height=_SIZE)
    colours = ("warm", "blue")
    pictures = [
        outline(Scene(tuple(SceneBody(p, k, colours[n]) for n, p in enumerate(shown)), study.environment,
                      title=f"{study.person} at {milliseconds(time)}"), camera)
        for k, time in enumerate(times.tolist())
    ]  # fmt: skip
    caption = f"{study.person} from the {view} at {', '.join(milliseconds(t) for t in times.tolist())}"
    if study.against is not None:
        caption += f"; in blue {study.against_name}"
    return strip_svg(pictures, [milliseconds(t) for t in times.tolist()], title=caption), caption
