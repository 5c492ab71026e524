"""Working angles: the angles of neck, trunk, arms, wrists and legs that posture scores ask for.

They are what an observer measures on a photograph, not the coordinates of the joints. Segment
frames are parallel to the world's in the zero pose, so a standing body with hanging arms has zeros.

- Trunk: the line from the middle of the hips to the pivot of the neck, against the plumb line, in
  the plane that the pelvis faces and across it. Twist: the upper torso against the pelvis.
- Neck: the head against the upper torso.
- Upper arm: how far it is raised from hanging along the upper torso, to whatever side. It counts as
  extension, negative, where it points more behind the trunk than to the side, below the shoulder.
  A flexion measured in the plane of the trunk alone would be noise for an arm raised to the side.
- Wrist: the forearm against the hand's own axes, so a palm that faces down bends downward.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats
from workbench.model.poses import Placed

__all__ = ["WorkingAngles", "check_segments", "joint_points", "working_angles"]

_MEASURED = (
    "LT",
    "UT",
    "H",
    *(side + name for side in "LR" for name in ("SM", "UA", "LA", "HN", "UL", "LL")),
)


@dataclass(frozen=True, eq=False)
class WorkingAngles:
    """Angles [rad] of P postures; (P, 2) are of the left and the right side.

    Parameters
    ----------
    trunk_flexion, trunk_side, trunk_twist
        (P,) forward, to the left and turned to the left.
    neck_flexion, neck_side, neck_twist
        (P,) as of the trunk, against the upper torso.
    arm_raise, arm_out, shoulder_raise
        (P, 2) the upper arm from hanging, negative behind the trunk; its way out of the sagittal
        plane; elevation of the collar bone.
    arm_level
        (P, 2) the upper arm from straight down in the world.
    elbow, forearm_out, forearm_twist
        (P, 2) flexion; the forearm's way out of the sagittal plane; pronation, supination negative.
    across
        (P, 2) True where the wrist is beyond the middle of the trunk.
    wrist_bend, wrist_deviation
        (P, 2) to the palm; to the thumb.
    knee, hip_trunk
        (P, 2) flexion; the included angle of trunk and thigh.
    """

    trunk_flexion: Floats
    trunk_side: Floats
    trunk_twist: Floats
    neck_flexion: Floats
    neck_side: Floats
    neck_twist: Floats
    arm_raise: Floats
    arm_out: Floats
    arm_level: Floats
    shoulder_raise: Floats
    elbow: Floats
    forearm_out: Floats
    forearm_twist: Floats
    across: Bools
    wrist_bend: Floats
    wrist_deviation: Floats
    knee: Floats
    hip_trunk: Floats

    def __len__(self) -> int:
        return len(self.trunk_flexion)


def working_angles(placed: Placed) -> WorkingAngles:
    """Measure the angles that posture scores ask for.

    Parameters
    ----------
    placed
        P postures in the world, z upward.

    Raises
    ------
    InputError
        If the body lacks trunk, head, arms or legs, or they are outside the logical window.

    Examples
    --------
    >>> import numpy as np
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> posed = wb.pose(body, {"RS": {"flexion": 50}, "RE": {"flexion": 80}})
    >>> angles = wb.working_angles(wb.place(body, posed))
    >>> np.degrees(angles.arm_raise[0]).round(1), np.degrees(angles.elbow[0]).round(1)
    (array([ 0., 50.]), array([ 0., 80.]))
    """
    check_segments(placed, _MEASURED, "posture scores")
    frames = {name: _axes(placed, name) for name in _MEASURED}
    trunk = _trunk_line(placed)
    left, up = frames["LT"][..., 1], np.array([0.0, 0.0, 1.0])
    level = np.maximum(np.hypot(left[:, 0], left[:, 1]), 1e-300)
    ahead = (trunk[:, 0] * left[:, 1] - trunk[:, 1] * left[:, 0]) / level
    aside = (trunk[:, 0] * left[:, 0] + trunk[:, 1] * left[:, 1]) / level
    neck = _between(frames["UT"], frames["H"])
    sides = [
        _upper_arm(frames, side) | _forearm(placed, frames, side) | _leg(frames, trunk, side)
        for side in "LR"
    ]
    both: dict[str, Any] = {
        name: np.stack([one[name] for one in sides], axis=1) for name in sides[0]
    }
    return WorkingAngles(
        trunk_flexion=np.arctan2(ahead, trunk @ up) - _upright(placed),
        trunk_side=np.arcsin(np.clip(aside, -1.0, 1.0)),
        trunk_twist=_twist(_between(frames["LT"], frames["UT"])),
        neck_flexion=np.arctan2(neck[:, 0, 2], neck[:, 2, 2]),
        neck_side=np.arctan2(neck[:, 1, 2], np.hypot(neck[:, 0, 2], neck[:, 2, 2])),
        neck_twist=_twist(neck),
        **both,
    )


def check_segments(placed: Placed, names: tuple[str, ...], what: str) -> None:
    """InputError where a body lacks some segments, or they were not placed."""
    body = placed.body
    missing = [
        name for name in names if name not in body.segments or not placed.window[body.segment(name)]
    ]
    if missing:
        raise InputError(
            f"body {body.name}: {what} need the segments {', '.join(names)}; "
            f"not there or outside the logical window: {', '.join(missing)}"
        )


def joint_points(placed: Placed, joints: list[int]) -> Floats:
    """(P, K, 3) [m] the places of some joints in the world."""
    parent = placed.body.parent[np.array(joints) + 1]
    world = placed.world_from_segment[:, parent]
    local = placed.body.joint_in_parent[:, joints][placed.person]
    return np.einsum("pkij,pkj->pki", world[..., :3], local) + world[..., 3]


def _axes(placed: Placed, name: str) -> Floats:
    """(P, 3, 3) world from segment."""
    return placed.world_from_segment[:, placed.body.segment(name), :, :3]


def _between(parent: Floats, child: Floats) -> Floats:
    """(P, 3, 3) parent from child."""
    return parent.transpose(0, 2, 1) @ child


def _twist(between: Floats) -> Floats:
    """(P,) the turn about z in swing times twist.

    Of the quaternion it is 2 atan2(z, w), and R10 - R01 = 4 w z, R00 + R11 = 2 (w^2 - z^2).
    """
    return np.arctan2(between[:, 1, 0] - between[:, 0, 1], between[:, 0, 0] + between[:, 1, 1])


def _trunk_line(placed: Placed) -> Floats:
    """(P, 3) unit vectors from the middle of the hips to the pivot of the neck."""
    body = placed.body
    points = joint_points(placed, [body.joint(name) for name in ("LH", "RH", "NP")])
    line = points[:, 2] - 0.5 * (points[:, 0] + points[:, 1])
    return line / np.linalg.norm(line, axis=1, keepdims=True)


def _upright(placed: Placed) -> Floats:
    """(P,) the lean of the trunk's line in the zero pose."""
    body = placed.body
    hips, neck = [body.joint("LH"), body.joint("RH")], body.joint("NP")
    origins = body.zero_origins
    low = origins[:, body.parent[hips[0] + 1]] + body.joint_in_parent[:, hips].mean(axis=1)
    line = origins[:, body.parent[neck + 1]] + body.joint_in_parent[:, neck] - low
    return np.arctan2(line[:, 0], line[:, 2])[placed.person]


def _upper_arm(frames: dict[str, Floats], side: str) -> dict[str, Floats]:
    """The angles of one upper arm and its shoulder."""
    out = 1.0 if side == "L" else -1.0
    hanging = -_between(frames["UT"], frames[side + "UA"])[..., 2]
    raised = np.arctan2(np.hypot(hanging[:, 0], hanging[:, 1]), -hanging[:, 2])
    behind = (-hanging[:, 0] > np.abs(hanging[:, 1])) & (hanging[:, 2] < 0.0)
    collar = _between(frames["UT"], frames[side + "SM"])
    return {
        "arm_raise": np.where(behind, -raised, raised),
        "arm_out": np.arcsin(np.clip(out * hanging[:, 1], -1.0, 1.0)),
        "arm_level": np.arccos(np.clip(frames[side + "UA"][:, 2, 2], -1.0, 1.0)),
        "shoulder_raise": np.arcsin(np.clip(out * collar[:, 2, 1], -1.0, 1.0)),
    }


def _forearm(placed: Placed, frames: dict[str, Floats], side: str) -> dict[str, Floats]:
    """The angles of one elbow, forearm and wrist."""
    out = 1.0 if side == "L" else -1.0
    lower = frames[side + "LA"]
    left = frames["UT"][..., 1]
    elbow = _between(frames[side + "UA"], lower)
    wrist = _between(lower, frames[side + "HN"])
    # the forearm's direction to the fingers in the hand's axes: palm inward, thumb forward
    forearm = -wrist[:, 2]
    point = joint_points(placed, [placed.body.joint(side + "W")])[:, 0]
    origin = placed.world_from_segment[:, placed.body.segment("UT"), :, 3]
    outward = -out * np.einsum("pi,pi->p", left, lower[..., 2])
    return {
        "elbow": np.arctan2(np.hypot(elbow[:, 0, 2], elbow[:, 1, 2]), elbow[:, 2, 2]),
        "forearm_out": np.arcsin(np.clip(outward, -1.0, 1.0)),
        "forearm_twist": -out * (_twist(elbow) + _twist(wrist)),
        "across": out * np.einsum("pi,pi->p", point - origin, left) < 0.0,
        "wrist_bend": np.arctan2(out * forearm[:, 1], -forearm[:, 2]),
        "wrist_deviation": np.arctan2(-forearm[:, 0], -forearm[:, 2]),
    }


def _leg(frames: dict[str, Floats], trunk: Floats, side: str) -> dict[str, Floats]:
    """The angles of one leg; trunk (P, 3): the direction of its line."""
    thigh = frames[side + "UL"]
    knee = _between(thigh, frames[side + "LL"])
    return {
        "knee": np.arctan2(np.hypot(knee[:, 0, 2], knee[:, 1, 2]), knee[:, 2, 2]),
        "hip_trunk": np.arccos(np.clip(-np.einsum("pi,pi->p", trunk, thigh[..., 2]), -1.0, 1.0)),
    }
