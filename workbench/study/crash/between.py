"""How near people who move at the same time come to one another."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from workbench.body.forward import place
from workbench.contact.collide import body_clearance
from workbench.model.criterion import Criterion
from workbench.model.motion_case import MotionCase
from workbench.model.moving import poses_at
from workbench.model.result import Finding, Verdict
from workbench.model.spool import pieces
from workbench.model.study import Study
from workbench.study.crash.frames import BLOCK

__all__ = ["between_verdicts"]


def between_verdicts(study: Study, motions: Sequence[MotionCase]) -> list[Verdict]:
    """Judge the criteria between people of each case of motions.

    The frames are those of the first of two people; the other is where he is at that time, held at
    the ends of his motion.
    """
    verdicts = []
    for criterion in study.criteria:
        if criterion.check != "between_people":
            continue
        for case in study.motions:
            if not criterion.asks(case.name):
                continue
            there = [motion for motion in motions if motion.case == case.name]
            findings = [
                _nearest(criterion, one, other)
                for one, other in combinations(there, 2)
                if one.person != other.person and {one.person, other.person} & set(criterion.people)
            ]
            verdicts.append(_verdict(criterion, case.name, findings))
    return verdicts


def _verdict(criterion: Criterion, case: str, findings: list[Finding]) -> Verdict:
    findings.sort(key=lambda finding: finding.margin)
    breaches = tuple(finding for finding in findings if finding.margin < 0)
    passed = bool(findings) and not breaches
    return Verdict(criterion, passed, findings[0] if findings else None, breaches, motion=case)


def _nearest(criterion: Criterion, one: MotionCase, other: MotionCase) -> Finding:
    """The frame in which two people are nearest, with the segments that are."""
    clock = one.motion.clock
    first, last = other.motion.clock[[0, -1]]
    keep = np.outer(
        np.isin(one.body.segments, criterion.segments),
        np.isin(other.body.segments, criterion.segments),
    )
    found = []
    for rows in pieces(len(clock), size=BLOCK):
        times = clock[rows]
        here = place(one.body, one.motion.rows(rows))
        there = place(other.body, poses_at(other.motion, np.clip(times, first, last)))
        near = body_clearance(here, there)
        distance = np.where(keep, near.distance, np.inf)
        frame, row, column = np.unravel_index(int(np.argmin(distance)), distance.shape)
        where = (int(frame), int(row), int(column))
        found.append(
            Finding(
                case=one.case,
                person=one.person,
                other_person=other.person,
                subject=near.name(where),
                target=near.other_name(where),
                value=float(distance[where]),
                limit=criterion.at_least,
                point=tuple(near.point[where].tolist()),
                time=float(times[where[0]]),
            )
        )
    return min(found, key=lambda finding: finding.margin)
