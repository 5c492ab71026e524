"""Overlap of a body with itself.

The margin is the distance of two segments that do not share a joint, the overlap that soft flesh is
allowed, and as much more as the criterion allows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from workbench.model.arrays import Bools
from workbench.model.body import Body
from workbench.model.criterion import Criterion, Reason
from workbench.model.result import Finding, MotionFound
from workbench.study.checks.margins import Asked, Bounds, Margins, no_bounds, no_margins
from workbench.study.checks.pairs import NearPairs, pair_findings
from workbench.study.checks.parts import meeting_finding
from workbench.study.situation import Situation

__all__ = ["bounds", "findings", "margins", "moments", "no_overlap"]


def margins(situation: Situation, asked: Sequence[Asked]) -> Margins:
    """What everybody has to spare before segments overlap more than flesh allows."""
    found = no_margins(len(situation), asked)
    body = situation.body
    distance = situation.own.distance
    for r, one in enumerate(asked):
        pairs = _pairs(body, one.criterion) & np.isfinite(distance)
        room = np.where(pairs, distance + body.allowance + one.criterion.at_most, np.inf)
        for b in np.flatnonzero(pairs.any(axis=(1, 2))):
            row, other = np.unravel_index(int(np.argmin(room[b])), room[b].shape)
            found.margin[b, r] = room[b, row, other]
            if room[b, row, other] < 0:
                names = body.segment_names
                found.words[b, r] = Reason("near", names[row], at=names[other])
    return found


def bounds(situation: Situation, asked: Sequence[Asked]) -> Bounds:
    """Between what everybody may truly have to spare; both segments of a pair have a surface."""
    found = no_bounds(len(situation), asked)
    body = situation.body
    distance = situation.own.distance
    outside, inside = np.moveaxis(body.fit_error[situation.placed.person], 2, 0)
    for r, one in enumerate(asked):
        pairs = _pairs(body, one.criterion) & np.isfinite(distance)
        some = pairs.any(axis=(1, 2))
        allowed = body.allowance + one.criterion.at_most
        for margin, growth in ((found.low, outside), (found.high, -inside)):
            grown = growth[:, :, None] + growth[:, None, :]
            room = np.where(pairs, distance + allowed - grown, np.inf)
            margin[some, r] = room[some].min(axis=(1, 2))
    return found


def _pairs(body: Body, criterion: Criterion) -> Bools:
    """(N, N) the pairs of segments that a criterion is about."""
    wanted = np.isin(body.segments, criterion.segments)
    return np.asarray(wanted[:, None] | wanted[None, :])


def findings(situation: Situation, criterion: Criterion) -> Iterator[Finding]:
    """The pairs of segments that overlap, and the nearest pair."""
    body = situation.body
    asked = NearPairs(
        near=situation.own,
        limit=-body.allowance[0] - criterion.at_most,
        keep=_pairs(body, criterion),
        person=situation.place.role,
    )
    yield from pair_findings(asked, situation.work.name)


def moments(found: MotionFound, criterion: Criterion) -> Iterator[Finding]:
    """The overlaps of a motion in continuous time, each at its deepest."""
    wanted = criterion.segments
    for meeting in found.meetings:
        if meeting.own and (meeting.segment in wanted or meeting.other in wanted):
            yield meeting_finding(found, meeting, criterion.at_most)


def no_overlap(criterion: Criterion) -> str:
    """Why a motion without findings passes."""
    return "no segment overlaps another"
