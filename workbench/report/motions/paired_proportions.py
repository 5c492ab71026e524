"""Two motions of one study in one turnable picture, with a slider that wipes from one to the
other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from markupsafe import Markup

from workbench.draw.web.motion_view import motion_view
from workbench.draw.web.views import WebView
from workbench.model.arrays import Floats
from workbench.model.result import MotionFound, Result
from workbench.report.motions.pictures import motion_scene
from workbench.report.sentences import milliseconds
from workbench.report.states import TwoStates, two_states
from workbench.report.turnable import PageViews

__all__ = ["decisive_time", "paired_motions"]


def paired_motions(
    result: Result, shown: Sequence[WebView], colours: Sequence[str], views: PageViews
) -> Markup:
    """Return the place of the picture of the two motions that the study compares, of its only two
    where it names none; "" where there are more, or where they have no time in common.

    Parameters
    ----------
    shown
        The turnable picture of each motion of the result.
    colours
        The colour family of each motion.
    views
        The pictures of the page; this one is added.
    """
    if result.study.compare is None and len(result.motions) != 2:
        return Markup("")
    one, two = result.study.compare or (0, 1)
    motions = (result.motions[one], result.motions[two])
    pair = (shown[one], shown[two])
    if pair[0].times != pair[1].times:
        times = _common(pair, decisive_time(motions))
        if times is None:
            return Markup("")
        pair = (
            motion_view(motions[0], colours[one], times=times),
            motion_view(motions[1], colours[two], times=times),
        )
    names = (motions[0].study.name, motions[1].study.name)
    time = decisive_time(motions)
    first, second = (
        motion_scene(motion.study, time, colours[k])
        for motion, k in zip(motions, (one, two), strict=True)
    )
    who = motions[0].study.person
    return two_states(
        TwoStates(
            views=(replace(pair[0], begin=time), pair[1]),
            scenes=(first, second),
            names=names,
            title=f"{who}: {names[0]} and {names[1]}",
            said=f"{who} at {milliseconds(time)}, seen from the left",
            caption=_caption(motions, time),
        ),
        views.packing,
    )


def _caption(motions: Sequence[MotionFound], time: float) -> str:
    """What the pictures show when they are opened, and on paper."""
    when = f"The picture begins at {milliseconds(time)}"
    failing = any(not verdict.passed for motion in motions for verdict in motion.verdicts)
    return f"{when}, when the first criterion that fails is at its worst" if failing else when


def _common(pair: tuple[WebView, WebView], time: float) -> Floats | None:
    """Times [s] that both motions have, as many as the first is shown at, and one more of them;
    None without any."""
    first = pair[0].times or ()
    second = pair[1].times or ()
    start = max(first[0], second[0])
    end = min(first[-1], second[-1])
    if end <= start:
        return None
    return np.union1d(np.linspace(start, end, max(len(first), 2)), np.clip(time, start, end))


def decisive_time(motions: Sequence[MotionFound]) -> float:
    """Return the time [s] at which the first criterion that fails is at its worst, the middle of the
    first motion where none has a time."""
    times = [
        verdict.worst.time
        for motion in motions
        for verdict in motion.verdicts
        if not verdict.passed and verdict.worst is not None
    ]
    start, end = motions[0].episodes.span
    return next((float(time) for time in times if np.isfinite(time)), (start + end) / 2)
