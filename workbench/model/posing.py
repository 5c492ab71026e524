"""Joint angles by name to rotations, and back: swing is one rotation vector, twist a turn about the
limb."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, one_of
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.poses import Poses, check_joints, rotation_fault
from workbench.model.quaternions import exponential, multiply, swing_twist

__all__ = [
    "ContinuousAngles",
    "angles_of",
    "attitude_matrix",
    "compose",
    "join_poses",
    "motion_of",
    "named_angles",
    "pose",
]

Angles = Mapping[str, Mapping[str, float]]
NOT_TURNED = 1e-9
"""An angle [rad] that is smaller is rounding: it moves no part of a body by a millionth of a
millimetre."""


def pose(
    body: Body,
    angles: Angles,
    *,
    rotations: Mapping[str, Sequence[float]] | None = None,
    reference: str | None = None,
    position: Sequence[float] = (0.0, 0.0, 0.0),
    attitude: ArrayLike | None = None,
) -> Poses:
    """One pose (P = 1) of a body.

    angles: anatomical angles in degrees by joint and motion name ({"LH": {"flexion": 90}}); what is
    not named is 0. rotations: quaternions w, x, y, z by joint, instead of angles. reference: the
    placed segment (default: the stage); position [m] of its origin; attitude (3, 3): world from
    reference rotation, identity where None. rotation = exp(swing vector) exp(twist), the angles of
    an axis being its component of the swing vector. InputError for unknown joints and motions.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> poses = wb.pose(body, {"RS": {"flexion": 90}}, position=(0, 0, 1))
    >>> wb.place(body, poses).centres.shape  # poses, spheres, x y z
    (1, 399, 3)
    """
    quaternion = compose(body, _swings(body, angles))
    for name, given in (rotations or {}).items():
        value = np.asarray(given, dtype=np.float64)
        length = float(np.linalg.norm(value))
        if value.shape != (4,) or not np.isfinite(length) or length < 1e-9:
            raise InputError(
                f"rotations: joint {name}: expected a quaternion w, x, y, z, got {list(given)}"
            )
        quaternion[body.joint(name)] = value / length
    place = np.zeros((1, 3, 4))
    place[0, :, :3] = np.eye(3) if attitude is None else _attitude(attitude)
    place[0, :, 3] = _position(position)
    return Poses(quaternion[None], body.segment(reference) if reference else 0, place)


def _swings(body: Body, angles: Angles) -> Floats:
    """(J, 3) the angles [rad] of each joint about its axes, from degrees by joint and motion."""
    swing = np.zeros((len(body.joints), 3))
    for name, motions in angles.items():
        j = body.joint(name)
        for motion, degrees in motions.items():
            if not np.isfinite(degrees):
                raise InputError(
                    f"angles: joint {name}: {motion}: expected a finite angle, got {degrees}"
                )
            axis, sign = motion_of(body, j, motion)
            swing[j, axis] += sign * np.radians(degrees)
    return swing


def _attitude(given: ArrayLike) -> Floats:
    matrix = np.asarray(given, dtype=np.float64)
    if matrix.shape != (3, 3):
        raise InputError(f"attitude: expected a rotation (3, 3), got an array {matrix.shape}")
    if fault := rotation_fault(matrix[None]):
        raise InputError(f"attitude: {fault.replace(' in row 0', '')}")
    return matrix


def _position(given: Sequence[float]) -> Floats:
    point = np.asarray(given, dtype=np.float64)
    if point.shape != (3,) or not np.all(np.isfinite(point)):
        raise InputError(f"position: expected x, y, z [m], got {list(given)}")
    return point


def join_poses(rows: Sequence[Poses]) -> Poses:
    """One batch from several; they must name the same reference segment.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> rows = [wb.pose(body, {"RS": {"flexion": angle}}) for angle in (0, 45, 90)]
    >>> wb.place(body, wb.join_poses(rows)).centres.shape
    (3, 399, 3)
    """
    if not rows:
        raise InputError("no poses to join")
    if len({row.reference for row in rows}) > 1:
        raise InputError("poses with different reference segments cannot be one batch")
    rotations = np.concatenate([row.rotations for row in rows])
    world = np.concatenate([row.world_from_reference for row in rows])
    person = [row.person for row in rows if row.person is not None]
    together = np.concatenate(person) if person else None
    return Poses(rotations, rows[0].reference, world, person=together)


def motion_of(body: Body, joint: int, motion: str) -> tuple[int, float]:
    """Axis (0, 1 swing, 2 twist) and sense (1 or -1) of a named motion; InputError lists the valid
    names."""
    pairs = body.stops.motions[joint]
    for axis, (first, second) in enumerate(pairs):
        if motion in (first, second):
            return axis, 1.0 if motion == first else -1.0
    valid = [name for pair in pairs for name in pair]
    raise InputError(f"joint {body.joints[joint]}: no motion {motion!r}; {one_of(motion, valid)}")


def named_angles(body: Body, angles: Floats) -> dict[str, dict[str, float]]:
    """Return angles (J, 3) [rad], as `angles_of` gives them, as `pose` takes them: degrees by joint
    and motion; joints that are not turned are left out."""
    found: dict[str, dict[str, float]] = {}
    for j, joint in enumerate(body.joints):
        turned = {
            body.stops.motions[j][axis][int(angle < 0)]: abs(float(np.degrees(angle)))
            for axis, angle in enumerate(angles[j])
            if abs(angle) > NOT_TURNED
        }
        if turned:
            found[joint] = turned
    return found


def attitude_matrix(*, pitch: float = 0.0, roll: float = 0.0, yaw: float = 0.0) -> Floats:
    """(3, 3) rotation from attitude angles [rad]: Rz(yaw) Ry(pitch) Rx(roll); pitch + is nose
    down."""
    (sp, sr, sy), (cp, cr, cy) = np.sin([pitch, roll, yaw]), np.cos([pitch, roll, yaw])
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    matrix: Floats = about_z @ about_y @ about_x
    return matrix


def compose(body: Body, angles: Floats) -> Floats:
    """Quaternions (..., J, 4) from the two swing components and the twist (..., J, 3) [rad]."""
    axes = body.stops.axes
    vector = angles[..., 0, None] * axes[:, 0] + angles[..., 1, None] * axes[:, 1]
    return multiply(exponential(vector), exponential(angles[..., 2, None] * axes[:, 2]))


def angles_of(body: Body, poses: Poses) -> Floats:
    """(P, J, 3) [rad] the angle of each joint about its two swing axes and its twist axis, in the
    first sense."""
    check_joints(body, poses)
    axes = body.stops.axes
    swing, twist = swing_twist(poses.rotations, axes[None, :, 2])
    first = np.sum(swing * axes[None, :, 0], axis=-1)
    second = np.sum(swing * axes[None, :, 1], axis=-1)
    return np.stack([first, second, twist], axis=-1)


_TURN = 2.0 * np.pi
_NO_SWING = 1e-9
"""Length [rad] of a swing vector below which it has no direction."""


class ContinuousAngles:
    """Choose among equal joint angles those nearest to the frame before, batch by batch.

    A twist may change by whole turns. A swing vector may grow or shrink by whole turns along its own
    direction: its two components change together, so that the angles still compose to the rotation.
    """

    def __init__(self) -> None:
        self._last: Floats | None = None

    def take(self, angles: Floats) -> Floats:
        """Continue the angles of the batch before.

        Parameters
        ----------
        angles
            (P, J, 3) [rad] two swing components and the twist of J joints, as `angles_of` returns.

        Returns
        -------
        Floats
            (P, J, 3) [rad] angles of the same rotations.
        """
        result = np.array(angles)
        if not len(result):
            return result
        last = result[0] if self._last is None else self._last
        before = np.concatenate([last[None], result[:-1]])
        # a joint without a step of half a turn, from the first frame on, needs nothing
        steps = np.abs(result - before).max(axis=(0, 2), initial=0.0)
        for j in np.flatnonzero(steps > np.pi):
            _continue(last[j], result[:, j])
        self._last = result[-1].copy()
        return result


def _continue(last: Floats, angles: Floats) -> None:
    """Continue the angles (P, 3) of a joint from those before (3,), in place."""
    for row in angles:
        row[2] += _TURN * np.rint((last[2] - row[2]) / _TURN)
        row[:2] = _nearest_swing(last[:2], row[:2])
        last = row


def _nearest_swing(last: Floats, swing: Floats) -> Floats:
    """(2,) the swing vector of the same rotation that is nearest to the one before."""
    size = np.hypot(swing[0], swing[1])
    direction = swing / size if size > _NO_SWING else last / max(np.hypot(*last), _NO_SWING)
    turns = np.rint((last @ direction - size) / _TURN)
    return np.asarray(swing + _TURN * turns * direction)
