"""Between two poses: rotations on the shortest arc at a constant rate, positions on a straight
line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, UsageError
from workbench.model.arrays import Floats
from workbench.model.poses import Poses
from workbench.model.quaternions import from_matrices, matrices, slerp

__all__ = ["between", "check_pairs", "poses_at"]


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
