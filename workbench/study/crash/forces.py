"""Forces of contact in a crash study: only of pairs for which the study states a law."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from workbench.contact.collide import allowed_depth
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.force import force_at, force_history
from workbench.model.motion_case import ForceCurve, Meeting, MotionCase
from workbench.model.simulation import depth_offset, ruled

__all__ = ["force_curves", "ruled_pairs", "with_forces"]


def ruled_pairs(study: MotionCase) -> Ints:
    """(Q, 2) the segments and parts that have a law."""
    some: Bools = np.zeros((len(study.body.segments), len(study.environment.parts)), dtype=np.bool_)
    for rule in study.forces:
        some |= np.outer(rule.segments, rule.parts)
    return np.argwhere(some)


def force_curves(study: MotionCase, pairs: Ints, gap: Floats) -> tuple[ForceCurve, ...]:
    """The forces of pairs (Q, 2) over signed distances (P, Q) [m] at the frames, of those that are
    ever pushed.

    A distance may be infinite where a pair is not pushed.
    """
    offset = depth_offset(study.bears, allowed_depth(study.body, study.environment))
    curves = []
    for q, (n, k) in enumerate(pairs.tolist()):
        law = ruled(study.forces, n, k)
        depth = -gap[:, q] - offset[n, k]
        if law is not None and depth.max() > 0:
            curves.append(
                ForceCurve(
                    study.body.segments[n], study.environment.parts[k], force_history(law, depth)
                )
            )
    return tuple(curves)


def with_forces(study: MotionCase, meetings: Iterable[Meeting]) -> list[Meeting]:
    """Meetings with the force at their deepest, where a law gives it."""
    if not study.forces:
        return list(meetings)
    offset = depth_offset(study.bears, allowed_depth(study.body, study.environment))
    return [_with_force(study, meeting, offset) for meeting in meetings]


def _with_force(study: MotionCase, meeting: Meeting, offset: Floats) -> Meeting:
    if meeting.own:
        return meeting
    n = study.body.segment(meeting.segment)
    k = study.environment.part_index(meeting.other)
    law = ruled(study.forces, n, k)
    depth = meeting.depth - float(offset[n, k])
    return meeting if law is None else replace(meeting, force=force_at(law, depth, depth))
