"""The nearest that segments come to parts, and joints to their stops, over the frames of a
motion."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from workbench.body.forward import place
from workbench.contact.clearance_pairs import clearance_of_pairs
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.motion_case import MotionCase
from workbench.model.poses import Poses
from workbench.model.spool import pieces
from workbench.posture.stops import stops
from workbench.study.crash.frames import BLOCK
from workbench.study.pairs import pair_of

__all__ = ["Approach", "NearStop", "nearest_approach", "nearest_stop"]


@dataclass(frozen=True)
class Approach:
    """A segment near to a part, by their names: signed distance [m], and in which frame."""

    distance: float
    frame: int
    segment: str
    part: str


@dataclass(frozen=True)
class NearStop:
    """A joint (index) near to its stop: margin [rad], in which motion and which frame."""

    margin: float
    frame: int
    joint: int
    motion: str


def nearest_approach(study: MotionCase, criterion: Criterion) -> Approach | None:
    """The nearest of the segments and parts of a criterion over all frames, pairs that may touch
    left out; None where there is no such pair."""
    body = study.body
    environment = study.environment
    pair = pair_of(body, environment, criterion)
    best = None
    for some in pieces(len(study.motion), size=BLOCK):
        placed = place(body, study.motion.rows(some))
        found = clearance_of_pairs(placed, environment, pairs=[pair])
        frame = int(np.argmin(found.distance[:, 0]))
        least = float(found.distance[frame, 0])
        if np.isfinite(least) and (best is None or least < best.distance):
            segment = body.sphere_segment[found.sphere[frame, 0]]
            part = environment.polygon_part[found.polygon[frame, 0]]
            best = Approach(
                least,
                some.start + frame,
                body.segment_names[int(segment)],
                environment.parts[int(part)],
            )
    return best


def nearest_stop(body: Body, motion: Poses, asked: Collection[str]) -> NearStop | None:
    """The joint of those asked about that comes nearest to its stop; None where none has one."""
    best = None
    keep = np.isin(body.joints, list(asked))
    for some in pieces(len(motion)):
        margins = stops(body, motion.rows(some))
        margin = np.where(keep, margins.margin, np.inf)
        frame, joint = (int(v) for v in np.unravel_index(int(np.argmin(margin)), margin.shape))
        least = float(margin[frame, joint])
        if np.isfinite(least) and (best is None or least < best.margin):
            best = NearStop(least, some.start + frame, joint, margins.motion(frame, joint))
    return best
