"""Joint stops: how far each joint is from the end of its range.

The margin is the angle that is left, less what is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from workbench.model.accommodation import MET
from workbench.model.arrays import pieces
from workbench.model.criterion import Criterion, Reason
from workbench.model.result import Finding, MotionFound
from workbench.model.units import UNITS, plain
from workbench.posture.stops import stops
from workbench.study.checks.margins import Asked, Margins, no_margins
from workbench.study.situation import Situation

__all__ = ["findings", "margins", "moments", "no_joint"]


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """What everybody has to spare in the joint nearest to its stop."""
    found = no_margins(len(situation), asked)
    body = situation.body
    left = stops(body, situation.poses)
    for r, one in enumerate(asked):
        wanted = np.isin(body.segments[1:], one.criterion.segments)
        angle = np.where(wanted, left.margin, np.inf)
        joint = angle.argmin(axis=1)
        found.margin[:, r] = UNITS["rad"].counted(angle.min(axis=1) - one.criterion.at_least)
        for b in np.flatnonzero(found.margin[:, r] < -MET):
            motion = plain(left.motion(int(b), int(joint[b])))
            found.words[b, r] = Reason("stop", f"{body.joint_names[joint[b]]} ({motion})")
    return found


def findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """Each joint whose distal segment is asked about."""
    body = situation.body
    left = stops(body, situation.poses)
    for joint in np.flatnonzero(np.isfinite(left.margin[0])).tolist():
        if body.segments[joint + 1] in criterion.segments:
            yield Finding(
                case=situation.work.name,
                person=situation.place.role,
                other_person="",
                subject=body.joint_names[joint],
                target=left.motion(0, joint),
                value=float(left.margin[0, joint]),
                limit=criterion.at_least,
                unit="rad",
            )


def moments(found: MotionFound, criterion: Criterion) -> list[Finding]:
    """The joints past their stops in a motion, or the one nearest to its stop where none is."""
    study = found.study
    body = study.body
    asked = {
        joint
        for joint, segment in zip(body.joints, body.segments[1:], strict=True)
        if segment in criterion.segments
    }
    past = [
        _moment(found, criterion, body.joint(breach.joint), breach.motion, -breach.worst, breach.at)
        for breach in found.breaches
        if breach.joint in asked
    ]
    if past:
        return past
    return _nearest(found, criterion, asked)


def _nearest(found: MotionFound, criterion: Criterion, asked: set[str]) -> list[Finding]:
    """The joint that comes nearest to its stop, nothing where none has one."""
    study = found.study
    keep = np.isin(study.body.joints, list(asked))
    best: list[Finding] = []
    for frames in pieces(len(study.motion)):
        left = stops(study.body, study.motion.rows(frames))
        margin = np.where(keep, left.margin, np.inf)
        frame, joint = (int(v) for v in np.unravel_index(int(np.argmin(margin)), margin.shape))
        least = float(margin[frame, joint])
        if np.isfinite(least) and (not best or least < best[0].value):
            time = float(study.motion.clock[frames.start + frame])
            motion = left.motion(frame, joint)
            best = [_moment(found, criterion, joint, motion, least, time)]
    return best


def no_joint(criterion: Criterion) -> str:
    """Why a motion without findings passes."""
    return "no joint that is asked about has a stop"


def _moment(
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
