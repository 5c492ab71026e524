"""Segments told one by one, as poses of a body: joints from the turns of their segments, and how
well it all hangs."""

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
    """Poses of a body whose segments turn as told, and how far (P, K) [m] each told segment is from
    where the body's joints put it.

    The first told segment in the body's order is placed; segments that are not told follow their
    parents, or the nearest told segment below them where nothing above is told. InputError for an
    unknown segment.
    """
    for name in track.segments:
        if name not in body.segments:
            raise InputError(
                f"{track.file}: body {body.name} has no segment {name!r}; {one_of(name, body.segments)}"
            )
    told = {body.segment(name): k for k, name in enumerate(track.segments)}
    root = min(told)
    turns = {n: from_matrices(track.world_from_segment[:, k, :, :3]) for n, k in told.items()}
    turns.setdefault(0, turns[root])
    for n in range(1, len(body.segments)):
        turns.setdefault(n, turns[root] if n < root else turns[int(body.parent[n])])
    rotations = np.stack(
        [
            multiply(conjugate(turns[int(body.parent[j + 1])]), turns[j + 1])
            for j in range(len(body.joints))
        ],
        axis=1,
    )
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    poses = Poses(rotations, root, track.world_from_segment[:, told[root]], track.time)
    at = place(body, poses).world_from_segment[:, [body.segment(name) for name in track.segments]][
        ..., 3
    ]
    return poses, np.asarray(np.linalg.norm(at - track.world_from_segment[..., 3], axis=-1))
