"""Turn recorded motions of single segments into poses of a body."""

from __future__ import annotations

import numpy as np

from workbench.body.forward import place
from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.motion import SegmentTrack
from workbench.model.poses import Poses
from workbench.model.quaternions import conjugate, from_matrices, multiply

__all__ = ["poses_from_track"]


def poses_from_track(body: Body, track: SegmentTrack) -> tuple[Poses, Floats]:
    """Compute poses of a body whose segments have the recorded attitudes.

    The first recorded segment in the body's order is placed. A segment without a record follows its
    parent, or the placed segment if it comes before that one.

    Parameters
    ----------
    track
        World from segment (P, K, 3, 4) of K recorded segments.

    Returns
    -------
    tuple of Poses and Floats
        The poses, and the distance (P, K) [m] of each recorded segment's origin from where the
        body's joints place it.

    Raises
    ------
    InputError
        If the body has no segment of a recorded name.
    """
    for name in track.segments:
        if name not in body.segments:
            raise InputError(
                f"{track.file}: body {body.name} has no segment {name!r}; {one_of(name, body.segments)}"
            )
    recorded = [body.segment(name) for name in track.segments]
    root = min(recorded)
    attitudes = _attitudes(body, track, recorded)
    rotations = np.stack(
        [
            multiply(conjugate(attitudes[int(body.parent[n])]), attitudes[n])
            for n in range(1, len(body.segments))
        ],
        axis=1,
    )
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    world = track.world_from_segment
    poses = Poses(rotations, root, world[:, recorded.index(root)], track.time)
    origins = place(body, poses).world_from_segment[:, recorded][..., 3]
    return poses, np.asarray(np.linalg.norm(origins - world[..., 3], axis=-1))


def _attitudes(body: Body, track: SegmentTrack, recorded: list[int]) -> dict[int, Floats]:
    """(P, 4) world from segment of every segment, by its index; recorded: indices (K,)."""
    attitudes = {
        segment: from_matrices(track.world_from_segment[:, k, :, :3])
        for k, segment in enumerate(recorded)
    }
    root = min(recorded)
    attitudes.setdefault(0, attitudes[root])
    for segment in range(1, len(body.segments)):
        carrier = root if segment < root else int(body.parent[segment])
        attitudes.setdefault(segment, attitudes[carrier])
    return attitudes
