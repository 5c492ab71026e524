"""Joint angles by name to rotations, and back: swing is one rotation vector, twist a turn about the
limb."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, UsageError, one_of
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.poses import Poses, check_joints, rotation_fault
from workbench.model.quaternions import (
    exponential,
    from_matrices,
    matrices,
    multiply,
    slerp,
    swing_twist,
)

__all__ = [
    "ContinuousAngles",
    "angles_of",
    "attitude_matrix",
    "between",
    "check_pairs",
    "compose",
    "join_poses",
    "motion_of",
    "named_angles",
    "pose",
    "poses_at",
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
    return about_z @ about_y @ about_x


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


# Between two poses: rotations on the shortest arc at a constant rate, positions on a straight
# line.


def between(start: Poses, end: Poses, at: ArrayLike) -> Poses:
    """The P poses on the way from `start` to `end` at the fractions `at` (one, or (P,), 0 to 1).

    Joints and the reference segment turn on the shortest arc at a constant rate (spherical linear
    interpolation, Shoemake 1985), its origin moves on a straight line. A joint that turns by
    exactly half a turn goes the way its end quaternion's sign says: the rotation conj(start) end as
    it stands; the reference segment's is the one whose largest component is positive. InputError
    where the poses do not belong together.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> down, up = wb.pose(body, {}), wb.pose(body, {"RS": {"flexion": 90}})
    >>> half = wb.between(down, up, 0.5)
    >>> wb.place(body, half).centres.shape
    (1, 399, 3)
    """
    check_pairs(start, end)
    fraction = _fractions(at, len(start))
    turns = [from_matrices(poses.world_from_reference[:, :, :3]) for poses in (start, end)]
    world = np.empty((len(start), 3, 4))
    world[:, :, :3] = matrices(slerp(turns[0], turns[1], fraction))
    first = start.world_from_reference[:, :, 3]
    last = end.world_from_reference[:, :, 3]
    world[:, :, 3] = first + fraction[:, None] * (last - first)
    time = None
    if start.time is not None and end.time is not None:
        time = start.time + fraction * (end.time - start.time)
    rotations = slerp(start.rotations, end.rotations, fraction[:, None])
    return Poses(rotations, start.reference, world, time)


def _fractions(at: ArrayLike, count: int) -> Floats:
    """(P,) the fractions of a number of poses; UsageError for a wrong number of them, InputError
    for one beyond 0 to 1."""
    given = np.asarray(at, dtype=np.float64)
    if given.shape not in ((), (1,), (count,)):
        raise UsageError(
            f"at: expected one fraction or {count}, one for each pose, got an array {given.shape}"
        )
    fraction: Floats = np.broadcast_to(given, (count,))
    if not np.all((fraction >= 0) & (fraction <= 1)):
        raise InputError(
            f"at: expected fractions from 0 to 1, got {fraction.min():g} to {fraction.max():g}"
        )
    return fraction


def poses_at(poses: Poses, times: ArrayLike) -> Poses:
    """The poses of a motion at times (T,) [s], on the way `between` its frames.

    Before the first and after the last frame the motion stands still. UsageError where the poses
    have no rising time.
    """
    clock = poses.time
    if clock is None or len(clock) < 1 or np.any(np.diff(clock) <= 0.0):
        raise UsageError("a motion is needed: poses with times that rise")
    asked = np.atleast_1d(np.asarray(times, dtype=np.float64))
    wanted = np.clip(asked, clock[0], clock[-1])
    before = np.clip(np.searchsorted(clock, wanted, side="right") - 1, 0, max(len(clock) - 2, 0))
    after = np.minimum(before + 1, len(clock) - 1)
    span = clock[after] - clock[before]
    share = np.divide(wanted - clock[before], span, out=np.zeros_like(wanted), where=span > 0.0)
    rows = [
        Poses(poses.rotations[k], poses.reference, poses.world_from_reference[k])
        for k in (before, after)
    ]
    return replace(between(rows[0], rows[1], np.clip(share, 0.0, 1.0)), time=asked)


def check_pairs(start: Poses, end: Poses) -> None:
    """InputError unless both hold the same number of poses, joints, and the same reference
    segment."""
    if len(start) != len(end):
        raise InputError(
            f"start and end need the same number of poses, got {len(start)} and {len(end)}"
        )
    if start.rotations.shape[1] != end.rotations.shape[1]:
        joints = start.rotations.shape[1], end.rotations.shape[1]
        raise InputError(
            f"start and end are poses of different bodies: {joints[0]} and {joints[1]} joints"
        )
    if start.reference != end.reference:
        raise InputError(
            "start and end place different reference segments: re-reference one of them"
        )
