"""Overlaps of people with themselves, in the posture with hands and feet in their places."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from workbench.body.forward import place
from workbench.contact.collide import self_clearance
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.poses import Poses

__all__ = ["own_margins"]


def own_margins(
    body: Body, poses: Poses, criterion: Criterion
) -> tuple[Floats, NDArray[np.object_]]:
    """Compute how far B people are from overlapping themselves more than flesh allows.

    Parameters
    ----------
    body, poses
        B rows, and a pose of each.
    criterion
        Names the segments that are asked about.

    Returns
    -------
    margin, words
        (B,) [m], NaN where no pair of segments is asked about, and (B,) the pair that overlaps,
        "" where none does.
    """
    margin = np.full(len(body), np.nan)
    words = np.full(len(body), "", dtype=object)
    own = self_clearance(place(body, poses))
    wanted = np.isin(body.segments, criterion.segments)
    asked = (wanted[:, None] | wanted[None, :]) & np.isfinite(own.distance)
    room = np.where(asked, own.distance + body.allowance, np.inf)
    for b in np.flatnonzero(asked.any(axis=(1, 2))):
        one, other = np.unravel_index(int(np.argmin(room[b])), room[b].shape)
        margin[b] = room[b, one, other]
        if margin[b] < 0:
            words[b] = f"{body.segment_names[one]} at {body.segment_names[other]}"
    return margin, words
