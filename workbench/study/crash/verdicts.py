"""The criteria of a crash study, judged."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.errors import UsageError
from workbench.model.crash import CrashResult, CrashVerdict
from workbench.model.criterion import Criterion
from workbench.study.crash.frames import Excursion
from workbench.study.crash.nearest import nearest_approach, nearest_stop
from workbench.study.crash.signals import figure_of

__all__ = ["crash_verdict"]


def crash_verdict(
    criterion: Criterion, result: CrashResult, excursions: Mapping[str, Excursion]
) -> CrashVerdict:
    """How a criterion comes out; UsageError for a check that is not known."""
    judge = _JUDGES.get(criterion.check)
    if judge is None:
        raise UsageError(f"no check {criterion.check!r}")
    return judge(criterion, result, excursions)


def _contact(
    criterion: Criterion, result: CrashResult, excursions: Mapping[str, Excursion]
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
    criterion: Criterion, result: CrashResult, excursions: Mapping[str, Excursion]
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


def _clearance(
    criterion: Criterion, result: CrashResult, excursions: Mapping[str, Excursion]
) -> CrashVerdict:
    """The nearest that segments come to parts, allowed contacts left out."""
    study = result.study
    limit = 1000 * criterion.at_least
    found = nearest_approach(study, criterion)
    if found is None:
        told = "nothing is there to be measured"
        return CrashVerdict(criterion, False, float("nan"), limit, "mm", float("nan"), told)
    value = 1000 * found.distance
    told = f"{found.segment} comes to {value:.1f} mm from {found.part}"
    at = float(study.motion.clock[found.frame])
    return CrashVerdict(criterion, value >= limit - 1e-6, value, limit, "mm", at, told)


def _self_contact(
    criterion: Criterion, result: CrashResult, excursions: Mapping[str, Excursion]
) -> CrashVerdict:
    wanted = criterion.segments
    about = [m for m in result.meetings if m.own and (m.segment in wanted or m.other in wanted)]
    if not about:
        told = "no segment overlaps another"
        return CrashVerdict(criterion, True, 0.0, 0.0, "mm", float("nan"), told)
    worst = max(about, key=lambda m: m.depth - m.allowed)
    depth = 1000 * (worst.depth - worst.allowed)
    told = f"{worst.who}: {depth:.1f} mm into {worst.other} beyond what flesh allows"
    return CrashVerdict(criterion, depth <= 1e-6, depth, 0.0, "mm", worst.deepest, told)


def _stops(
    criterion: Criterion, result: CrashResult, excursions: Mapping[str, Excursion]
) -> CrashVerdict:
    """How far joints are past their stops; -`at_least` is what they may be."""
    body = result.study.body
    limit = 0.0 - float(np.degrees(criterion.at_least))
    asked = {
        joint
        for joint, segment in zip(body.joints, body.segments[1:], strict=True)
        if segment in criterion.segments
    }
    breaches = [breach for breach in result.breaches if breach.joint in asked]
    if not breaches and limit >= 0:
        told = "no joint is past its stop"
        return CrashVerdict(criterion, True, 0.0, limit, "degrees", float("nan"), told)
    if not breaches:
        return _inside_stops(criterion, result, asked)
    worst = max(breaches, key=lambda b: b.worst)
    name = body.joint_names[body.joint(worst.joint)]
    value = float(np.degrees(worst.worst))
    told = f"{name} is {value:.1f} degrees past its stop in {worst.motion.replace('_', ' ')}"
    return CrashVerdict(criterion, value <= limit, value, limit, "degrees", worst.at, told)


def _inside_stops(criterion: Criterion, result: CrashResult, asked: set[str]) -> CrashVerdict:
    """The joint that comes nearest to its stop, of those that stay inside."""
    study = result.study
    limit = 0.0 - float(np.degrees(criterion.at_least))
    found = nearest_stop(study.body, study.motion, asked)
    if found is None:
        told = "no joint that is asked about has a stop"
        return CrashVerdict(criterion, True, float("nan"), limit, "degrees", float("nan"), told)
    value = -float(np.degrees(found.margin))
    name = study.body.joint_names[found.joint]
    told = f"{name} stays {-value:.1f} degrees inside its stop in {found.motion.replace('_', ' ')}"
    at = float(study.motion.clock[found.frame])
    return CrashVerdict(criterion, value <= limit + 1e-9, value, limit, "degrees", at, told)


def _rules(
    criterion: Criterion, result: CrashResult, excursions: Mapping[str, Excursion]
) -> CrashVerdict:
    """The limit that is most used up, of all limits of the rule set."""
    found = []
    for limit in criterion.limits:
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


_JUDGES = {
    "contact": _contact,
    "clearance": _clearance,
    "self_contact": _self_contact,
    "excursion": _excursion,
    "stops": _stops,
    "injury": _rules,
}
