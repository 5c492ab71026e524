"""Clearance between people who are there at the same time.

The margin is the distance of the nearest segments, less what is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from workbench.body.forward import place
from workbench.contact.collide import body_clearance
from workbench.model.accommodation import MET
from workbench.model.arrays import Bools, pieces
from workbench.model.body import Body
from workbench.model.criterion import NO_REASON, Criterion, Reason
from workbench.model.joint_angles import poses_at
from workbench.model.motion_case import MotionCase
from workbench.model.poses import Placed
from workbench.model.result import Finding
from workbench.model.workplace import Beside
from workbench.study.checks.margins import Asked, Bounds, Margins, no_bounds, no_margins
from workbench.study.checks.pairs import NearPairs, pair_findings
from workbench.study.crash.frames import BLOCK
from workbench.study.situation import Situation

__all__ = ["bounds", "findings", "margins", "motion_findings"]


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """What everybody has to spare to whoever is nearest of those beside."""
    found = no_margins(len(situation), asked)
    for beside in situation.place.beside:
        near = body_clearance(situation.placed, _repeated(situation, beside))
        for r, one in enumerate(asked):
            keep = _pairs(situation.body, beside.placed.body, one.criterion)
            distance = np.where(keep & np.isfinite(near.distance), near.distance, np.inf)
            flat = distance.reshape(len(distance), -1)
            margin = flat.min(axis=1) - one.criterion.at_least
            before = np.nan_to_num(found.margin[:, r], nan=np.inf)
            for b in np.flatnonzero(margin < before).tolist():
                found.margin[b, r] = margin[b]
                row, other = np.unravel_index(int(flat[b].argmin()), keep.shape)
                found.words[b, r] = NO_REASON
                if margin[b] < -MET:
                    name = situation.body.segment_names[int(row)]
                    theirs = near.other_name((b, int(row), int(other)))
                    found.words[b, r] = Reason("near", name, at=f"{beside.role}'s {theirs}")
    return found


def bounds(situation: Situation, asked: Sequence[Asked]) -> Bounds:
    """Between what everybody may truly have to spare; both bodies have a surface."""
    found = no_bounds(len(situation), asked)
    for margin in (found.low, found.high):
        margin[:] = np.inf
    own = situation.body.fit_error[situation.placed.person]
    for beside in situation.place.beside:
        other = beside.placed.body
        near = body_clearance(situation.placed, _repeated(situation, beside))
        for margin, side, sign in ((found.low, 0, 1.0), (found.high, 1, -1.0)):
            grown = sign * (own[:, :, None, side] + other.fit_error[:1, None, :, side])
            for r, one in enumerate(asked):
                keep = _pairs(situation.body, other, one.criterion) & np.isfinite(near.distance)
                room = np.where(keep, near.distance - grown, np.inf).min(axis=(1, 2))
                margin[:, r] = np.minimum(margin[:, r], room - one.criterion.at_least)
    for margin in (found.low, found.high):
        margin[np.isinf(margin)] = np.nan
    return found


def _repeated(situation: Situation, beside: Beside) -> Placed:
    """Whoever is beside in this case, once for each row of a situation."""
    rows = np.full(len(situation), situation.case)
    return beside.placed.of_person(0, rows)


def _pairs(one: Body, other: Body, criterion: Criterion) -> Bools:
    """(N, M) the pairs of segments that a criterion is about."""
    rows, columns = (np.isin(body.segments, criterion.segments) for body in (one, other))
    return np.asarray(rows[:, None] & columns[None, :])


def findings(one: Situation, other: Situation, criterion: Criterion) -> Iterator[Finding]:
    """The pairs of segments of two people that are too near, and the nearest pair."""
    keep = _pairs(one.body, other.body, criterion)
    asked = NearPairs(
        near=body_clearance(one.placed, other.placed),
        limit=np.full(keep.shape, criterion.at_least),
        keep=keep,
        person=one.place.role,
        other_person=other.place.role,
    )
    yield from pair_findings(asked, one.work.name)


def motion_findings(criterion: Criterion, motions: Sequence[MotionCase]) -> list[Finding]:
    """How near each two of the motions of one case come to each other.

    The frames are those of the first of two people; the other is where he is at that time, held at
    the ends of his motion.
    """
    return [
        _nearest(criterion, one, other)
        for one, other in combinations(motions, 2)
        if one.person != other.person and {one.person, other.person} & set(criterion.people)
    ]


def _nearest(criterion: Criterion, one: MotionCase, other: MotionCase) -> Finding:
    """The frame in which two people are nearest, with the segments that are."""
    clock = one.motion.clock
    first, last = other.motion.clock[[0, -1]]
    keep = _pairs(one.body, other.body, criterion)
    found = []
    for rows in pieces(len(clock), size=BLOCK):
        times = clock[rows]
        here = place(one.body, one.motion.rows(rows))
        there = place(other.body, poses_at(other.motion, np.clip(times, first, last)))
        near = body_clearance(here, there)
        distance = np.where(keep, near.distance, np.inf)
        frame, row, column = np.unravel_index(int(np.argmin(distance)), distance.shape)
        where = (int(frame), int(row), int(column))
        polygon, other_sphere = near.met(where)
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
                sphere=int(near.sphere[where]),
                polygon=polygon,
                other_sphere=other_sphere,
            )
        )
    return min(found, key=lambda finding: finding.margin)
