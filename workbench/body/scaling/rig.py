"""What the postures of anthropometry do to a skeleton: how each turns the segments, and so each
sphere and joint.

Within a posture every place is linear in the body's coordinates, so a posture is a handful of
matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.blend import distal
from workbench.model.body import Body
from workbench.model.posing import pose
from workbench.model.quaternions import rotate

__all__ = ["POSTURES", "Rig", "Shape", "rig_of"]

_SIDES = ("L", "R")
_SIT = {f"{s}{joint}": {"flexion": 90.0} for s in _SIDES for joint in ("H", "K", "E")}
# NATICK/TR-15/007 (ANSUR II): standing upright; sitting upright, thighs level, knees and elbows at
# right angles; the arm level to the front; both arms overhead; the legs stretched to the front.
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
    "legs_forward": {f"{s}H": {"flexion": 90.0} for s in _SIDES},
}


@dataclass(frozen=True, eq=False)
class Shape:
    """What may change in a body: sphere centres (..., S, 3), radii (..., S), joint coordinates in
    parent and child (..., J, 3)."""

    centre: Floats
    radius: Floats
    in_parent: Floats
    in_child: Floats


@dataclass(frozen=True, eq=False)
class Rig:
    """A skeleton of N segments, J joints and S spheres in Q postures, the stage unturned at the
    origin.

    frames (Q, N, 3, 3): world from segment rotations; parent (J,); above (N, N): 1 where a segment
    hangs from another or is it. segment (S,): of each sphere; turn (Q, S, 3, 3): world from centre,
    that of the segment or the mean of two; blended (B,): spheres that are blended, joint (B,) the
    joint they are blended across, distal (B,) whether that is the one above them, lever (Q, B, 3,
    3): what the joint's coordinates add to their places.
    """

    frames: Floats
    parent: Ints
    above: Floats
    segment: Ints
    turn: Floats
    blended: Ints
    joint: Ints
    distal: Bools
    lever: Floats

    def origins(self, shape: Shape) -> tuple[Floats, Floats]:
        """Segment origins (Q, ..., N, 3) and joints (Q, ..., J, 3) in the world [m]."""
        down = np.einsum("qjab,...jb->q...ja", self.frames[:, self.parent], shape.in_parent)
        up = np.einsum("qjab,...jb->q...ja", self.frames[:, 1:], shape.in_child)
        step = np.concatenate([np.zeros_like(down[..., :1, :]), down - up], axis=-2)
        origin = self.above @ step
        return origin, origin[..., self.parent, :] + down

    def spheres(self, shape: Shape, origin: Floats, queue: int) -> Floats:
        """(S, 3) sphere centres in the world [m] in one posture, of a shape whose origins (Q, N, 3)
        are known."""
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
    """The rig of a body; bodies with the same tree and stops share most of the work."""
    frames = _frames(body)
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


def _frames(body: Body) -> Floats:
    return np.stack([_turned(body, name) for name in POSTURES])


def _turned(body: Body, posture: str) -> Floats:
    return _posture_frames(_Skeleton(body), posture)


class _Skeleton:
    """A body as a key: two bodies with the same stops and the same tree are turned alike by a
    posture."""

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
