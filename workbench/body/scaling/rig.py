"""Compute positions of spheres and joints in the postures of anthropometry.

In one posture every position is linear in the body's coordinates, so a posture is a set of
matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.joint_angles import pose
from workbench.model.quaternions import rotate
from workbench.model.skinning import distal

__all__ = ["ON_A_SEAT", "POSTURES", "Rig", "Shape", "rig_of"]

_SIDES = ("L", "R")
_SIT = {f"{s}{joint}": {"flexion": 90.0} for s in _SIDES for joint in ("H", "K", "E")}
POSTURES: dict[str, dict[str, dict[str, float]]] = {
    "standing": {},
    "sitting": _SIT,
    "arm_forward": {"RS": {"flexion": 90.0}},
    # the clavicle takes 38 of the 180 degrees, within its stop; both turn about the same axis
    "overhead": {
        **{f"{s}C": {"elevation": 38.0} for s in _SIDES},
        **{f"{s}S": {"abduction": 142.0} for s in _SIDES},
        **{f"{s}H": {"flexion": 90.0} for s in _SIDES},
    },
}
"""Joint angles [degrees] of the postures of ANSUR II (NATICK/TR-15/007).

Standing upright; sitting upright with level thighs and right angles at knees and elbows; one arm
level to the front; both arms overhead."""
ON_A_SEAT = ("sitting", "overhead")
"""Those in which hips and thighs rest on a seat."""


@dataclass(frozen=True, eq=False)
class Shape:
    """What may change in a body, of one shape or of several (...)."""

    centre: Floats
    """(..., S, 3) sphere centres in their segments' frames [m]."""
    radius: Floats
    """(..., S) [m]."""
    in_parent: Floats
    """(..., J, 3) joints in the parents' frames [m]."""
    in_child: Floats
    """(..., J, 3) joints in the children's frames [m]."""


@dataclass(frozen=True, eq=False)
class Rig:
    """A skeleton of N segments, J joints and S spheres in Q postures, with the stage at the origin.

    B of the spheres are blended: they follow the mean of two segments across a joint.
    """

    frames: Floats
    """(Q, N, 3, 3) rotations, world from segment."""
    parent: Ints
    """(J,) segment above each joint."""
    above: Floats
    """(N, N) 1 where segment j is an ancestor of segment i, or i itself."""
    segment: Ints
    """(S,) segment of each sphere."""
    turn: Floats
    """(Q, S, 3, 3) world from centre: the segment's rotation, or the mean of two."""
    blended: Ints
    """(B,) spheres that are blended."""
    joint: Ints
    """(B,) joint across which they are blended."""
    distal: Bools
    """(B,) True where that is the joint above their segment."""
    lever: Floats
    """(Q, B, 3, 3) what the joint's coordinates add to their positions."""

    def origins(self, shape: Shape) -> tuple[Floats, Floats]:
        """Return segment origins (Q, ..., N, 3) and joints (Q, ..., J, 3) in the world [m]."""
        down = np.einsum("qjab,...jb->q...ja", self.frames[:, self.parent], shape.in_parent)
        up = np.einsum("qjab,...jb->q...ja", self.frames[:, 1:], shape.in_child)
        step = np.concatenate([np.zeros_like(down[..., :1, :]), down - up], axis=-2)
        origin = self.above @ step
        return origin, origin[..., self.parent, :] + down

    def spheres(self, shape: Shape, origin: Floats, queue: int) -> Floats:
        """Return the sphere centres (S, 3) in the world [m] in one posture.

        origin (Q, N, 3): origins of the segments, see `origins`; queue: number of the posture.
        """
        centres: Floats = origin[queue, self.segment] + np.einsum(
            "sab,sb->sa", self.turn[queue], shape.centre
        )
        if len(self.blended):
            point = np.where(
                self.distal[:, None], shape.in_child[self.joint], shape.in_parent[self.joint]
            )
            centres[self.blended] += np.einsum("sab,sb->sa", self.lever[queue], point)
        return centres


def rig_of(body: Body) -> Rig:
    """Compute the rig of a body. Bodies with the same tree and joint stops share most of the work.

    A blended sphere c with the share w of the other segment R2 is at the mean of both positions:

        (1 - w) (R1 c + t1) + w (R2 (c - j1 + j2) + t2) = (R1 - L) c + L j1 + t1,    L = w (R1 - R2),

    since both segments have the joint j1 = j2 in common.
    """
    frames = np.stack([_posture_frames(_Skeleton(body), name) for name in POSTURES])
    segment = body.sphere_segment
    blended = np.flatnonzero((body.blend_joint >= 0) & (body.blend_share[0] > 0))
    joint = body.blend_joint[blended]
    below = distal(body)[blended]
    turn = frames[:, segment]
    other = frames[:, np.where(below, body.parent[joint + 1], joint + 1)]
    lever = body.blend_share[0, blended, None, None] * (turn[:, blended] - other)
    turn[:, blended] -= lever
    above = np.eye(len(body.segments))
    for n in range(1, len(body.segments)):
        above[n] += above[body.parent[n]]
    return Rig(frames, body.parent[1:], above, segment, turn, blended, joint, below, lever)


class _Skeleton:
    """A body as a key of a cache: bodies with the same stops and tree have the same frames."""

    def __init__(self, body: Body) -> None:
        self.body = body
        self._key = (id(body.stops), body.joints, body.parent.tobytes())
        self.stops = body.stops  # kept, so that no other stops can get its id

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Skeleton) and self._key == other._key


@lru_cache(maxsize=64)
def _posture_frames(skeleton: _Skeleton, posture: str) -> Floats:
    """(N, 3, 3) world from segment rotations in a posture, the stage unturned."""
    body = skeleton.body
    rotations = pose(body, POSTURES[posture]).rotations[0]
    frames = np.zeros((len(body.segments), 3, 3))
    frames[0] = np.eye(3)
    for n in range(1, len(body.segments)):
        turn = rotate(np.broadcast_to(rotations[n - 1], (3, 4)), np.eye(3)).T
        frames[n] = frames[int(body.parent[n])] @ turn
    return frames
