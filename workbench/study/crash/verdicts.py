"""The criteria of a crash study, judged."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.errors import UsageError
from workbench.model.crash import CrashCriterion, CrashResult, CrashVerdict
from workbench.study.crash.frames import Excursion
from workbench.study.crash.signals import figure_of

__all__ = ["crash_verdict"]


def crash_verdict(
    criterion: CrashCriterion, result: CrashResult, excursions: Mapping[str, Excursion]
) -> CrashVerdict:
    """How a criterion comes out; UsageError for a check that is not known."""
    judge = {"contact": _contact, "excursion": _excursion, "stops": _stops, "rules": _rules}.get(
        criterion.check
    )
    if judge is None:
        raise UsageError(f"no check {criterion.check!r}")
    return judge(criterion, result, excursions)


def _contact(
    criterion: CrashCriterion, result: CrashResult, excursions: Mapping[str, Excursion]
) -> CrashVerdict:
    about = [
        m
        for m in result.meetings
        if not m.own and m.segment in criterion.segments and m.other in criterion.parts
    ]
    limit = 1000 * criterion.at_most
    if not about:
        return CrashVerdict(criterion, True, 0.0, limit, "mm", float("nan"), "no contact")
    worst = max(about, key=lambda m: m.depth - m.allowed)
    depth = 1000 * (worst.depth - worst.allowed)
    told = f"{worst.who}: {depth:.1f} mm into {worst.other}" + (
        " beyond what is allowed" if worst.allowed else ""
    )
    return CrashVerdict(criterion, depth <= limit + 1e-6, depth, limit, "mm", worst.deepest, told)


def _excursion(
    criterion: CrashCriterion, result: CrashResult, excursions: Mapping[str, Excursion]
) -> CrashVerdict:
    body = result.study.body
    found = excursions[criterion.name]
    name = (
        body.sphere_names[found.sphere]
        or body.segment_names[int(body.sphere_segment[found.sphere])]
    )
    value = 1000 * found.value
    limit = 1000 * criterion.at_most
    return CrashVerdict(
        criterion,
        value <= limit,
        value,
        limit,
        "mm",
        float(result.study.motion.clock[found.frame]),
        f"{name} goes {value:.1f} mm",
    )


def _stops(
    criterion: CrashCriterion, result: CrashResult, excursions: Mapping[str, Excursion]
) -> CrashVerdict:
    limit = float(np.degrees(criterion.at_most))
    if not result.breaches:
        return CrashVerdict(
            criterion, True, 0.0, limit, "degrees", float("nan"), "no joint is past its stop"
        )
    worst = max(result.breaches, key=lambda b: b.worst)
    name = result.study.body.joint_names[result.study.body.joint(worst.joint)]
    value = float(np.degrees(worst.worst))
    told = f"{name} is {value:.1f} degrees past its stop in {worst.motion.replace('_', ' ')}"
    return CrashVerdict(criterion, value <= limit, value, limit, "degrees", worst.at, told)


def _rules(
    criterion: CrashCriterion, result: CrashResult, excursions: Mapping[str, Excursion]
) -> CrashVerdict:
    """The limit that is most used up, of all limits of the rule set."""
    found = []
    for limit in result.study.limits:
        segment = result.study.body.segment(limit.segment)
        for signal in result.signals:
            step = float(signal.time[1] - signal.time[0])
            if signal.point.segment == segment and step > 0.5 * limit.span:
                told = (
                    f"{signal.point.name}: samples {1000 * step:.3g} ms apart cannot tell a figure over "
                    f"{1000 * limit.span:g} ms"
                )
                return CrashVerdict(
                    criterion, False, float("nan"), limit.value, "", float("nan"), told
                )
            if signal.point.segment == segment:
                value, begin, end = figure_of(signal, limit)
                found.append((value / limit.value, value, begin, end, limit, signal.point.name))
    _, value, begin, end, limit, name = max(found, key=lambda row: row[0])
    window = "" if np.isinf(limit.span) else f"{1000 * limit.span:g}"
    what = f"HIC{window}" if limit.figure == "hic" else f"level held for {window} ms"
    unit = "" if limit.figure == "hic" else "g"
    when = f" from {1000 * begin:.1f} to {1000 * end:.1f} ms" if limit.figure == "hic" else ""
    told = f"{name}: {what} {value:.0f}{' ' + unit if unit else ''}{when} ({limit.source} allows {limit.value:g})"
    return CrashVerdict(
        criterion, all(row[0] <= 1.0 for row in found), value, limit.value, unit, begin, told
    )
