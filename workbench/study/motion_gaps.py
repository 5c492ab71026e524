"""How near a motion comes to its surroundings at each of its frames, against what is asked of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.contact.clearance_pairs import clearance_of_pairs
from workbench.contact.kernels.search import Nearest
from workbench.contact.movers import room_of_segments, rooms_by_mover
from workbench.model.arrays import Floats
from workbench.model.criterion import Criterion
from workbench.model.motion_case import MotionCase
from workbench.model.poses import Placed
from workbench.model.surroundings import Surroundings
from workbench.study.checks.parts import asked_pair, limit_of

__all__ = ["AskedGap", "asked_gaps", "distance_criteria", "frame_rooms", "nearest_criterion"]


@dataclass(frozen=True, eq=False)
class AskedGap:
    """What a criterion about distances finds at each frame.

    Parameters
    ----------
    criterion
        A clearance or a contact.
    distance
        (P,) [m] with the overlap that a part allows given back to a contact; infinite where nothing
        is near.
    limit
        [m] The distance that may not be fallen short of.
    """

    criterion: Criterion
    distance: Floats
    limit: float

    @property
    def least(self) -> float:
        """The least that is left [m] of what is asked for, infinite where nothing is near."""
        return float((self.distance - self.limit).min(initial=np.inf))


def distance_criteria(motion: MotionCase) -> tuple[Criterion, ...]:
    """The criteria of a motion that are about distances from parts."""
    return tuple(one for one in motion.criteria if one.check in ("clearance", "contact"))


def frame_rooms(motion: MotionCase, placed: Placed) -> Nearest:
    """Find what comes nearest to each segment at P frames, with the overlap that parts allow added.

    Parameters
    ----------
    placed
        The body of the motion in P of its frames.
    """
    still = Surroundings(motion.environment, (), np.zeros((0, 3)))
    return room_of_segments(rooms_by_mover(placed, still))


def asked_gaps(
    motion: MotionCase, placed: Placed, criteria: Sequence[Criterion]
) -> tuple[AskedGap, ...]:
    """Find what criteria about distances find at P frames.

    Parameters
    ----------
    placed
        The body of the motion in P of its frames.
    criteria
        Some of `distance_criteria`.
    """
    if not criteria:
        return ()
    pairs = [asked_pair(motion.body, motion.environment, one) for one in criteria]
    found = clearance_of_pairs(placed, motion.environment, pairs=pairs).distance
    return tuple(AskedGap(one, found[:, q], limit_of(one) + 0.0) for q, one in enumerate(criteria))


def nearest_criterion(gaps: Sequence[AskedGap]) -> AskedGap | None:
    """The gap of the criterion that is nearest to failing, None where there is none."""
    return min(gaps, key=lambda one: one.least, default=None)
