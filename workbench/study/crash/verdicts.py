"""Judge the criteria of a motion: each check finds what comes nearest to failing, and when."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from workbench.errors import UsageError
from workbench.model.criterion import Criterion, Limit
from workbench.model.motion_case import Meeting, Signal
from workbench.model.result import Finding, MotionFound, Verdict
from workbench.study.crash.frames import Excursion
from workbench.study.crash.nearest import nearest_approach, nearest_stop
from workbench.study.crash.signals import figure_of

__all__ = ["motion_verdict"]

LENGTH_TOLERANCE = 1e-9
"""[m]"""


def motion_verdict(
    criterion: Criterion, found: MotionFound, excursions: Mapping[str, Excursion]
) -> Verdict:
    """Judge one criterion of a motion.

    Parameters
    ----------
    found
        What was found of the motion, without its verdicts.
    excursions
        The largest excursion, by the name of the criterion that asks for it.

    Raises
    ------
    UsageError
        For a check that cannot be asked of a motion.
    """
    if criterion.check == "excursion":
        return _judged(criterion, found, [_excursion(criterion, found, excursions[criterion.name])])
    judge = _JUDGES.get(criterion.check)
    if judge is None:
        raise UsageError(f"no check {criterion.check!r} of a motion")
    return judge(criterion, found)


def _judged(
    criterion: Criterion, found: MotionFound, findings: Iterable[Finding], nothing: str = ""
) -> Verdict:
    """The verdict of some findings; where there are none, passed if there are words for that."""
    ordered = sorted(findings, key=lambda finding: finding.margin)
    tolerance = LENGTH_TOLERANCE if ordered and ordered[0].unit in ("m", "rad") else 0.0
    breaches = tuple(finding for finding in ordered if finding.margin < -tolerance)
    return Verdict(
        criterion,
        not breaches and bool(ordered or nothing),
        ordered[0] if ordered else None,
        breaches,
        motion=found.study.name,
        words="" if ordered else nothing,
    )


def _contact(criterion: Criterion, found: MotionFound) -> Verdict:
    """The contacts in continuous time; of named spheres the nearest at the frames."""
    if criterion.subparts:
        return _clearance(criterion, found)
    about = (
        meeting
        for meeting in found.meetings
        if not meeting.own
        and meeting.segment in criterion.segments
        and meeting.other in criterion.parts
    )
    findings = [_meeting(found, meeting, criterion.at_most) for meeting in about]
    return _judged(criterion, found, findings, "no contact")


def _self_contact(criterion: Criterion, found: MotionFound) -> Verdict:
    wanted = criterion.segments
    findings = [
        _meeting(found, meeting, 0.0)
        for meeting in found.meetings
        if meeting.own and (meeting.segment in wanted or meeting.other in wanted)
    ]
    return _judged(criterion, found, findings, "no segment overlaps another")


def _meeting(found: MotionFound, meeting: Meeting, at_most: float) -> Finding:
    """The deepest moment of a contact, against what is allowed and `at_most` [m] more."""
    return Finding(
        case=found.study.case,
        person=found.study.person,
        other_person="",
        subject=meeting.who,
        target=meeting.other,
        value=-meeting.depth,
        limit=-(meeting.allowed + at_most),
        point=meeting.point,
        time=meeting.deepest,
    )


def _excursion(criterion: Criterion, found: MotionFound, farthest: Excursion) -> Finding:
    body = found.study.body
    sphere = farthest.sphere
    segment = body.segment_names[int(body.sphere_segment[sphere])]
    return Finding(
        case=found.study.case,
        person=found.study.person,
        other_person="",
        subject=body.sphere_names[sphere] or segment,
        target="the origin",
        value=-farthest.value,
        limit=-criterion.at_most,
        time=float(found.study.motion.clock[farthest.frame]),
    )


def _clearance(criterion: Criterion, found: MotionFound) -> Verdict:
    """The nearest that segments or named spheres come to parts, allowed contacts left out."""
    nearest = nearest_approach(found.study, criterion)
    if nearest is None:
        return _judged(criterion, found, ())
    finding = Finding(
        case=found.study.case,
        person=found.study.person,
        other_person="",
        subject=nearest.segment,
        target=nearest.part,
        value=nearest.distance,
        limit=-criterion.at_most if criterion.check == "contact" else criterion.at_least,
        time=float(found.study.motion.clock[nearest.frame]),
    )
    return _judged(criterion, found, [finding])


def _stops(criterion: Criterion, found: MotionFound) -> Verdict:
    """The joints past their stops, or the one nearest to its stop where none is."""
    study = found.study
    body = study.body
    asked = {
        joint
        for joint, segment in zip(body.joints, body.segments[1:], strict=True)
        if segment in criterion.segments
    }
    findings = [
        _stop(found, criterion, body.joint(breach.joint), breach.motion, -breach.worst, breach.at)
        for breach in found.breaches
        if breach.joint in asked
    ]
    if not findings:
        near = nearest_stop(body, study.motion, asked)
        if near is not None:
            time = float(study.motion.clock[near.frame])
            findings = [_stop(found, criterion, near.joint, near.motion, near.margin, time)]
    return _judged(criterion, found, findings, "no joint that is asked about has a stop")


def _stop(
    found: MotionFound, criterion: Criterion, joint: int, motion: str, margin: float, time: float
) -> Finding:
    return Finding(
        case=found.study.case,
        person=found.study.person,
        other_person="",
        subject=found.study.body.joint_names[joint],
        target=motion,
        value=margin,
        limit=criterion.at_least,
        unit="rad",
        time=time,
    )


def _injury(criterion: Criterion, found: MotionFound) -> Verdict:
    """The limits of the rule set; the worst is the one that is most used up."""
    findings = []
    for limit in criterion.limits:
        segment = found.study.body.segment(limit.segment)
        for signal in found.signals:
            if signal.point.segment != segment:
                continue
            step = float(signal.time[1] - signal.time[0])
            if step > 0.5 * limit.span:
                words = (
                    f"samples of {signal.point.name} are {1000 * step:.3g} ms apart; a figure over "
                    f"{1000 * limit.span:g} ms needs denser ones"
                )
                return Verdict(criterion, False, None, motion=found.study.name, words=words)
            findings.append(_figure(found, limit, signal))
    findings.sort(key=lambda finding: -finding.value / finding.limit)
    breaches = tuple(finding for finding in findings if finding.margin < 0)
    worst = findings[0] if findings else None
    return Verdict(
        criterion, bool(findings) and not breaches, worst, breaches, motion=found.study.name
    )


def _figure(found: MotionFound, limit: Limit, signal: Signal) -> Finding:
    """A limit of a rule set and its figure of a signal."""
    value, begin, end = figure_of(signal, limit)
    window = "" if np.isinf(limit.span) else f"{1000 * limit.span:g}"
    if limit.figure == "hic":
        figure = f"HIC{window} from {1000 * begin:.1f} to {1000 * end:.1f} ms"
    else:
        figure = f"acceleration held for {window} ms"
    return Finding(
        case=found.study.case,
        person=found.study.person,
        other_person="",
        subject=f"{signal.point.name}, {figure}",
        target=limit.source,
        value=-value,
        limit=-limit.value,
        unit="" if limit.figure == "hic" else "g",
        time=begin,
    )


_JUDGES: dict[str, Callable[[Criterion, MotionFound], Verdict]] = {
    "contact": _contact,
    "clearance": _clearance,
    "self_contact": _self_contact,
    "stops": _stops,
    "injury": _injury,
}
