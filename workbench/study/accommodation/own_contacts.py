"""Overlaps of people with themselves, in the posture with hands and feet in their places."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.poses import Poses
from workbench.solve.contact.collide import self_clearance
from workbench.solve.forward import place

__all__ = ["own_margins"]


def own_margins(
    bodies: Sequence[Body], poses: Poses, criterion: Criterion
) -> tuple[Floats, NDArray[np.object_]]:
    """How far B bodies, a pose each, are from overlapping themselves more than flesh allows.

    Returns
    -------
    margin, words
        (B,) [m], NaN where no pair of segments is asked about, and (B,) the pair that overlaps,
        "" where none does.
    """
    margin = np.full(len(bodies), np.nan)
    words = np.full(len(bodies), "", dtype=object)
    for b, body in enumerate(bodies):
        row = slice(b, b + 1)
        own = self_clearance(
            place(
                body,
                Poses(poses.rotations[row], poses.reference, poses.world_from_reference[row]),
            )
        )
        wanted = np.isin(body.segments, criterion.segments)
        asked = (wanted[:, None] | wanted[None, :]) & np.isfinite(own.distance[0])
        if not asked.any():
            continue
        room = np.where(asked, own.distance[0] + body.allowance, np.inf)
        one, other = np.unravel_index(int(np.argmin(room)), room.shape)
        margin[b] = room[one, other]
        if margin[b] < 0:
            words[b] = f"{body.segment_names[one]} at {body.segment_names[other]}"
    return margin, words
