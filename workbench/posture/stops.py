"""Joint stops: the margin of every joint in degrees, which motion limits it, and the nearest legal
rotation.

The swing cone with four half-angles and two twist limits follows Baerlocher & Boulic 2000 (elliptic
swing cones with twist); the shoulder's limit is a spherical polygon for the direction of the arm,
in the spirit of the sinus cones of Engin & Tumer 1989. A margin is the distance to the nearest stop
in the plane of the swing vector, or the distance to the nearest twist limit if that is less;
negative where a stop is breached.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.poses import Poses
from workbench.model.posing import angles_of, compose
from workbench.model.quaternions import conjugate, multiply, rotate, shortest
from workbench.model.stops import StopKind
from workbench.posture.ellipse import nearest_on_cone
from workbench.posture.shoulder import nearest_on_polygon

__all__ = ["StopMargins", "nearest_legal", "stop_limits", "stops"]


@dataclass(frozen=True, eq=False)
class StopMargins:
    """Margins of P poses: margin (P, J) [rad], positive inside, infinite for free joints; axis,
    side (P, J): the motion whose stop is nearest (axis 0, 1, 2; side 0 first name, 1 second);
    nearest (P, J, 4): the nearest legal rotation, the joint's own where it is legal."""

    body: Body
    margin: Floats
    axis: Ints
    side: Ints
    nearest: Floats

    def motion(self, pose: int, joint: int) -> str:
        """Name of the motion whose stop is nearest."""
        return self.body.stops.motions[joint][int(self.axis[pose, joint])][
            int(self.side[pose, joint])
        ]


def stops(body: Body, poses: Poses) -> StopMargins:
    """Joint-stop margins, and the nearest legal rotations, of all joints in all poses."""
    angles = angles_of(body, poses)
    limits = stop_limits(body, angles)
    count = (len(poses), len(body.joints))
    margin = np.full(count, np.inf)
    axis = np.zeros(count, np.int64)
    side = np.zeros(count, np.int64)
    legal = angles.copy()
    nearest = poses.rotations.copy()
    kind = body.stops.kind
    for j in np.flatnonzero(kind == StopKind.CONE):
        _cone(
            angles[:, j, :2], limits[:, j, :2], (margin[:, j], axis[:, j], side[:, j], legal[:, j])
        )
    for j in np.flatnonzero(kind == StopKind.HINGE):
        _hinge(
            angles[:, j],
            (limits[:, j], body.stops.play[j]),
            (margin[:, j], axis[:, j], side[:, j], legal[:, j]),
        )
    for j in np.flatnonzero(kind == StopKind.CONE):
        _twist(
            angles[:, j, 2], limits[:, j, 2], (margin[:, j], axis[:, j], side[:, j], legal[:, j])
        )
    composed = compose(body, legal)
    for j in np.flatnonzero(kind == StopKind.POLYGON):
        composed[:, j] = _polygon(
            body, poses, (int(j), limits[:, j, 2]), (margin[:, j], axis[:, j], side[:, j])
        )
    breached = margin < 0
    nearest[breached] = composed[breached]
    return StopMargins(body, margin, axis, side, nearest)


def nearest_legal(body: Body, poses: Poses) -> Floats:
    """(P, J, 4) the nearest legal rotations, as those of `stops`, without the margins: what is
    legal costs little."""
    angles = angles_of(body, poses)
    limits = stop_limits(body, angles)
    legal = angles.copy()
    moved = poses.rotations.copy()
    kind = body.stops.kind
    for j in np.flatnonzero(kind == StopKind.CONE):
        swing = angles[:, j, :2]
        most = np.maximum(np.where(swing >= 0, limits[:, j, :2, 0], limits[:, j, :2, 1]), 1e-9)
        out = np.sum((swing / most) ** 2, axis=-1) > 1.0
        if out.any():
            legal[out, j, :2] = nearest_on_cone(swing[out], limits[out, j, :2])[0]
        legal[:, j, 2] = np.clip(angles[:, j, 2], -limits[:, j, 2, 1], limits[:, j, 2, 0])
    for j in np.flatnonzero(kind == StopKind.HINGE):
        slack = np.array([0.0, body.stops.play[j], body.stops.play[j]])
        legal[:, j] = np.clip(
            angles[:, j], -(limits[:, j, :, 1] + slack), limits[:, j, :, 0] + slack
        )
    composed = compose(body, legal)
    changed = np.abs(legal - angles).max(axis=-1) > 0.0
    moved[changed] = composed[changed]
    for j in np.flatnonzero(kind == StopKind.POLYGON):
        columns = (
            np.zeros(len(poses)),
            np.zeros(len(poses), np.int64),
            np.zeros(len(poses), np.int64),
        )
        inside = _polygon(body, poses, (int(j), limits[:, j, 2]), columns)
        out = columns[0] < 0
        moved[out, j] = inside[out]
    return moved


def stop_limits(body: Body, angles: Floats) -> Floats:
    """(P, J, 3, 2) [rad] limits of every motion in every pose, the couplings applied."""
    limits = np.broadcast_to(body.stops.limits, (len(angles), *body.stops.limits.shape)).copy()
    for c in body.stops.couplings:
        driver = angles[:, c.driver_joint, c.driver_axis]
        limits[:, c.joint, c.axis, c.side] = np.interp(driver, c.driver_angle, c.limit)
    return limits


Columns = tuple[Floats, Ints, Ints, Floats]


def _cone(swing: Floats, limits: Floats, out: Columns) -> None:
    """Swing (P, 2) against the four half-angles (P, 2, 2)."""
    margin, axis, side, legal = out
    point, distance, normal = nearest_on_cone(swing, limits)
    margin[:] = distance
    axis[:] = np.argmax(np.abs(normal), axis=1)
    side[:] = np.take_along_axis(normal, axis[:, None], axis=1)[:, 0] < 0
    legal[:, :2] = np.where(distance[:, None] < 0, point, swing)


def _hinge(angles: Floats, rule: tuple[Floats, Floats], out: Columns) -> None:
    """The hinge axis against its range; the other axes and the twist against limit plus play.

    Within its play an axis is no nearer to a stop, so it counts only beyond.
    """
    margin, axis, side, legal = out
    limits, play = rule
    slack = np.array([0.0, play, play])
    far = limits[..., 0] + slack
    near = limits[..., 1] + slack
    room = np.stack([far - angles, near + angles], axis=-1)
    room[np.abs(angles) <= slack] = np.inf
    room[:, 0] = np.stack([far[:, 0] - angles[:, 0], near[:, 0] + angles[:, 0]], axis=-1)
    tight = np.argmin(room.reshape(len(room), 6), axis=1)
    margin[:] = np.take_along_axis(room.reshape(len(room), 6), tight[:, None], axis=1)[:, 0]
    axis[:] = tight // 2
    side[:] = tight % 2
    legal[:] = np.clip(angles, -near, far)


def _twist(twist: Floats, limits: Floats, out: Columns) -> None:
    """Twist (P,) against its two limits (P, 2); replaces the margin where this one is less."""
    margin, axis, side, legal = out
    room = np.stack([limits[:, 0] - twist, limits[:, 1] + twist], axis=1)
    least = room.min(axis=1)
    nearer = least < margin
    margin[nearer], axis[nearer], side[nearer] = least[nearer], 2, np.argmin(room, axis=1)[nearer]
    legal[:, 2] = np.clip(twist, -limits[:, 1], limits[:, 0])


def _polygon(
    body: Body, poses: Poses, joint: tuple[int, Floats], out: tuple[Floats, Ints, Ints]
) -> Floats:
    """Limb direction against the spherical polygon, twist against its limits; returns the legal
    rotations (P, 4)."""
    j, twist_limits = joint
    margin, axis, side = out
    before = np.broadcast_to(np.array([1.0, 0.0, 0.0, 0.0]), (len(poses), 4))
    at = int(body.parent[j + 1])
    while at != body.stops.polygon_frame[j]:
        before = multiply(poses.rotations[:, at - 1], before)
        at = int(body.parent[at])
    relative = multiply(before, poses.rotations[:, j])
    limb = rotate(relative, np.broadcast_to(body.stops.limb[j], (len(poses), 3)))
    point, distance = nearest_on_polygon(limb, body.stops.polygon[j], body.stops.polygon_centre[j])
    outward = np.cross(limb, point) * np.where(distance < 0, -1.0, 1.0)[:, None]
    # the sense of a turn in the polygon's frame, told in the joint's own axes
    turn = rotate(conjugate(before), outward) @ body.stops.axes[j, :2].T
    margin[:] = distance
    axis[:] = np.argmax(np.abs(turn), axis=1)
    side[:] = np.take_along_axis(turn, axis[:, None], axis=1)[:, 0] < 0
    back = np.where((distance < 0)[:, None], shortest(limb, point), np.array([1.0, 0.0, 0.0, 0.0]))
    moved = poses.rotations.copy()
    moved[:, j] = multiply(conjugate(before), multiply(back, relative))
    legal = angles_of(body, Poses(moved, poses.reference, poses.world_from_reference))
    _twist(
        angles_of(body, poses)[:, j, 2],
        twist_limits,
        (margin, axis, side, np.zeros((len(poses), 3))),
    )
    legal[:, j, 2] = np.clip(legal[:, j, 2], -twist_limits[:, 1], twist_limits[:, 0])
    return compose(body, legal)[:, j]
