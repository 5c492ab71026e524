"""Joint stops: the margin of every joint, the motion that limits it, and the nearest legal rotation.

A margin is the distance [rad] to the nearest stop in the plane of the swing vector, or the distance
to the nearest twist limit if that is less. It is negative where a stop is breached. Joints have a
swing cone with four half-angles and two twist limits [1]_, or a hinge with play; the shoulder has a
spherical polygon for the direction of the arm, in the spirit of sinus cones [2]_.

References
----------
.. [1] P. Baerlocher and R. Boulic (2000), Parametrization and range of motion of the ball-and-socket
   joint, Deformable Avatars, 180-190.
.. [2] A. E. Engin and S. T. Tumer (1989), Three-dimensional kinematic modelling of the human
   shoulder complex, Journal of Biomechanical Engineering 111, 107-112.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.arguments import short_repr
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.joint_angles import angles_of, compose
from workbench.model.poses import Poses
from workbench.model.quaternions import conjugate, multiply, rotate, shortest
from workbench.model.stops import StopKind, Stops
from workbench.posture.kernels.limit_violation import StopPack
from workbench.posture.kernels.stop_law import (
    SMALLEST_LIMIT,
    nearest_on_cones,
    nearest_on_polygons,
)

__all__ = [
    "StopMargins",
    "moves_flesh",
    "nearest_legal",
    "nearest_on_cone",
    "nearest_on_polygon",
    "packed_stops",
    "polygon_sides",
    "stop_limits",
    "stops",
]


def packed_stops(body: Body) -> StopPack:
    """Pack the joint stops of a body as the arrays that the kernel `past_stops` reads."""
    stops = body.stops
    couplings = [
        [c.joint, c.axis, c.side, c.driver_joint, c.driver_axis, *c.driver_angle, *c.limit]
        for c in stops.couplings
    ]
    sides, corners = _polygons(stops)
    return StopPack(
        kind=stops.kind,
        axes=stops.axes,
        limits=stops.limits,
        play=stops.play,
        coupling=np.array(couplings, dtype=np.float64).reshape(-1, 9),
        sides=sides,
        corners=corners,
        limb=stops.limb,
        before=_joints_before(body),
    )


def _polygons(stops: Stops) -> tuple[Floats, Ints]:
    """Sides (J, V, 5, 3) and numbers of corners (J,) of the spherical polygons; 0 for others."""
    joints = len(stops.kind)
    polygonal = np.flatnonzero(stops.kind == StopKind.POLYGON)
    most = max((len(stops.polygon[j]) for j in polygonal), default=1)
    sides = np.zeros((joints, most, 5, 3))
    corners = np.zeros(joints, dtype=np.int64)
    for j in polygonal:
        corners[j] = len(stops.polygon[j])
        sides[j, : corners[j]] = polygon_sides(stops.polygon[j], stops.polygon_centre[j])
    return sides, corners


def _joints_before(body: Body) -> Ints:
    """(J, B) joints from a polygon's frame to its joint, padded with -1; none for other kinds."""
    chains = [
        _chain_before(body, j) if body.stops.kind[j] == StopKind.POLYGON else []
        for j in range(len(body.joints))
    ]
    longest = max((len(chain) for chain in chains), default=0)
    padded = [chain + [-1] * (longest - len(chain)) for chain in chains]
    return np.array(padded, dtype=np.int64).reshape(len(chains), longest)


def _chain_before(body: Body, joint: int) -> list[int]:
    """The joints from the frame of a joint's polygon to the joint, without itself."""
    segment = int(body.parent[joint + 1])
    chain = list[int]()
    while segment != body.stops.polygon_frame[joint]:
        chain.insert(0, segment - 1)
        segment = int(body.parent[segment])
    return chain


def polygon_sides(corner: Floats, centre: Floats) -> Floats:
    """(V, 5, 3) sides of a spherical polygon with corners (V, 3) about a centre (3,).

    A side has its first corner, its inward normal, the normals of its two ends, and the normal of
    the plane through centre and corner.
    """
    following = np.roll(corner, -1, axis=0)
    inward = np.cross(corner, following)
    inward /= np.linalg.norm(inward, axis=1, keepdims=True)
    spoke = np.cross(centre, corner)
    return np.stack(
        [corner, inward, np.cross(inward, corner), np.cross(following, inward), spoke], axis=1
    )


IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class StopMargins:
    """Margins of the J joints of P poses."""

    body: Body
    margin: Floats
    """(P, J) [rad] positive inside, infinite for free joints."""
    axis: Ints
    """(P, J) axis of the motion whose stop is nearest: 0 and 1 swing, 2 twist."""
    side: Ints
    """(P, J) 0 for the first motion of that axis, 1 for the second."""
    nearest: Floats
    """(P, J, 4) nearest legal rotations; the joint's own where it is legal."""

    __repr__ = short_repr

    def motion(self, pose: int, joint: int) -> str:
        """Name of the motion whose stop is nearest."""
        return self.body.stops.motions[joint][int(self.axis[pose, joint])][
            int(self.side[pose, joint])
        ]


@dataclass(frozen=True, eq=False)
class _Nearest:
    """Nearest stops of one joint in P poses, filled in place."""

    margin: Floats
    """(P,) [rad]."""
    axis: Ints
    """(P,)."""
    side: Ints
    """(P,)."""
    legal: Floats
    """(P, 3) [rad] nearest legal angles."""


def stops(body: Body, poses: Poses) -> StopMargins:
    """Compute the margins and the nearest legal rotations of all joints.

    Parameters
    ----------
    body
        The body.
    poses
        P poses.

    Returns
    -------
    StopMargins
        Margins (P, J) [rad], the motions that limit, and rotations (P, J, 4). A joint of a missing
        limb, beyond which no sphere is, has no stop.

    Examples
    --------
    >>> import numpy as np
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> kneeling = wb.pose(body, {"RK": {"flexion": 90}, "LK": {"flexion": 170}})
    >>> margin = np.degrees(wb.stops(body, kneeling).margin[0])
    >>> [round(margin[body.joints.index(knee)]) for knee in ("RK", "LK")]  # degrees to the stop
    [45, -35]
    """
    angles = angles_of(body, poses)
    limits = stop_limits(body, angles)
    count = (len(poses), len(body.joints))
    margin = np.full(count, np.inf)
    axis = np.zeros(count, np.int64)
    side = np.zeros(count, np.int64)
    legal = angles.copy()
    of_joint = [
        _Nearest(margin[:, j], axis[:, j], side[:, j], legal[:, j]) for j in range(count[1])
    ]
    cones = _joints_of_kind(body, StopKind.CONE)
    _cones(angles[:, cones, :2], limits[:, cones, :2], [of_joint[j] for j in cones])
    for j in cones:
        _twist(angles[:, j, 2], limits[:, j, 2], of_joint[j])
    for j in _joints_of_kind(body, StopKind.HINGE):
        _hinge(angles[:, j], limits[:, j], float(body.stops.play[j]), of_joint[j])
    composed = compose(body, legal)
    for j in _joints_of_kind(body, StopKind.POLYGON):
        composed[:, j] = _polygon(body, poses, j, limits[:, j, 2], of_joint[j])
    margin[:, ~moves_flesh(body)] = np.inf
    breached = margin < 0
    nearest = poses.rotations.copy()
    nearest[breached] = composed[breached]
    return StopMargins(body, margin, axis, side, nearest)


def moves_flesh(body: Body) -> Bools:
    """Return (J,) whether a joint moves any sphere: not those of a missing limb."""
    filled = np.diff(body.start) > 0
    for segment in range(len(body.segments) - 1, 0, -1):
        filled[body.parent[segment]] |= filled[segment]
    return np.asarray(filled[1:], dtype=np.bool_)


def nearest_legal(body: Body, poses: Poses) -> Floats:
    """Compute the nearest legal rotations without the margins; poses that are legal cost little.

    Parameters
    ----------
    body
        The body.
    poses
        P poses.

    Returns
    -------
    Floats
        (P, J, 4) rotations, as those of `stops`.
    """
    angles = angles_of(body, poses)
    limits = stop_limits(body, angles)
    legal = _clamped(body, angles, limits)
    moved = poses.rotations.copy()
    changed = np.abs(legal - angles).max(axis=-1) > 0.0
    moved[changed] = compose(body, legal)[changed]
    count = len(poses)
    for j in _joints_of_kind(body, StopKind.POLYGON):
        result = _Nearest(
            np.zeros(count),
            np.zeros(count, np.int64),
            np.zeros(count, np.int64),
            np.zeros((count, 3)),
        )
        inside = _polygon(body, poses, j, limits[:, j, 2], result)
        breached = result.margin < 0
        moved[breached, j] = inside[breached]
    return moved


def stop_limits(body: Body, angles: Floats) -> Floats:
    """Compute the limits of every motion in every pose, the couplings applied.

    Parameters
    ----------
    body
        The body.
    angles
        (P, J, 3) [rad] joint angles.

    Returns
    -------
    Floats
        (P, J, 3, 2) [rad] how far each angle goes up and down.
    """
    limits = np.broadcast_to(body.stops.limits, (len(angles), *body.stops.limits.shape)).copy()
    for c in body.stops.couplings:
        driver = angles[:, c.driver_joint, c.driver_axis]
        limits[:, c.joint, c.axis, c.side] = np.interp(driver, c.driver_angle, c.limit)
    return limits


def nearest_on_cone(swing: Floats, limits: Floats) -> tuple[Floats, Floats, Floats]:
    """Nearest boundary points of swing cones.

    swing (M, 2) [rad]; limits (M, 2, 2): half-angles (axis; first, second sense). Legal is (s1 /
    L1)^2 + (s2 / L2)^2 <= 1 with the half-angle of the sign of each component (Baerlocher & Boulic
    2000). Returns the points (M, 2), the signed distances (M,) (positive inside) and the outward
    normals there (M, 2).
    """
    point = np.empty((len(swing), 2))
    distance = np.empty(len(swing))
    normal = np.empty((len(swing), 2))
    half_angles = np.maximum(limits, SMALLEST_LIMIT)
    nearest_on_cones(np.ascontiguousarray(swing), half_angles, point, distance, normal)
    return point, distance, normal


def nearest_on_polygon(direction: Floats, polygon: Floats, centre: Floats) -> tuple[Floats, Floats]:
    """Nearest boundary point of a spherical polygon that is star-shaped about `centre`.

    direction (P, 3), polygon (V, 3) counter-clockwise about centre, centre (3,): unit vectors.
    Edges are great circles. Returns the point (P, 3) and the signed angle (P,) [rad], positive
    inside.
    """
    point = np.empty((len(direction), 3))
    angle = np.empty(len(direction))
    sides = polygon_sides(polygon, centre)
    nearest_on_polygons(np.ascontiguousarray(direction), sides, point, angle)
    return point, angle


def _joints_of_kind(body: Body, kind: StopKind) -> list[int]:
    return np.flatnonzero(body.stops.kind == kind).tolist()


def _outside_cone(swing: Floats, limits: Floats) -> Bools:
    """(P,) whether swings (P, 2) are outside their cones: (s1 / L1)^2 + (s2 / L2)^2 > 1."""
    half = np.maximum(np.where(swing >= 0, limits[..., 0], limits[..., 1]), SMALLEST_LIMIT)
    return np.sum((swing / half) ** 2, axis=-1) > 1.0


def _clamped(body: Body, angles: Floats, limits: Floats) -> Floats:
    """Angles (P, J, 3) [rad] of cones and hinges brought to their limits (P, J, 3, 2)."""
    legal = angles.copy()
    for j in _joints_of_kind(body, StopKind.CONE):
        swing = angles[:, j, :2]
        outside = _outside_cone(swing, limits[:, j, :2])
        if outside.any():  # the projection on an ellipse is an iteration
            legal[outside, j, :2] = nearest_on_cone(swing[outside], limits[outside, j, :2])[0]
        legal[:, j, 2] = np.clip(angles[:, j, 2], -limits[:, j, 2, 1], limits[:, j, 2, 0])
    for j in _joints_of_kind(body, StopKind.HINGE):
        slack = np.array([0.0, body.stops.play[j], body.stops.play[j]])
        down = limits[:, j, :, 1] + slack
        legal[:, j] = np.clip(angles[:, j], -down, limits[:, j, :, 0] + slack)
    return legal


def _cones(swing: Floats, limits: Floats, results: Sequence[_Nearest]) -> None:
    """Measure swings (P, C, 2) of C joints against their four half-angles (P, C, 2, 2)."""
    every = (len(swing), len(results))
    found = nearest_on_cone(swing.reshape(-1, 2), limits.reshape(-1, 2, 2))
    point, distance, normal = (values.reshape(*every, *values.shape[1:]) for values in found)
    axis = np.argmax(np.abs(normal), axis=2)
    side = np.take_along_axis(normal, axis[..., None], axis=2)[..., 0] < 0
    legal = np.where(distance[..., None] < 0, point, swing)
    for c, result in enumerate(results):
        result.margin[:] = distance[:, c]
        result.axis[:] = axis[:, c]
        result.side[:] = side[:, c]
        result.legal[:, :2] = legal[:, c]


def _hinge(angles: Floats, limits: Floats, play: float, result: _Nearest) -> None:
    """Measure the hinge axis against its range, the other two angles against limit plus play.

    Within its play an angle is no nearer to a stop, so it counts only beyond.
    """
    slack = np.array([0.0, play, play])
    up = limits[..., 0] + slack
    down = limits[..., 1] + slack
    room = np.stack([up - angles, down + angles], axis=-1)
    room[:, 1:][np.abs(angles[:, 1:]) <= slack[1:]] = np.inf
    flat = room.reshape(len(room), 6)
    tight = np.argmin(flat, axis=1)
    result.margin[:] = np.take_along_axis(flat, tight[:, None], axis=1)[:, 0]
    result.axis[:] = tight // 2
    result.side[:] = tight % 2
    result.legal[:] = np.clip(angles, -down, up)


def _twist(twist: Floats, limits: Floats, result: _Nearest) -> None:
    """Measure twists (P,) against their two limits (P, 2); they replace margins that are greater."""
    room = np.stack([limits[:, 0] - twist, limits[:, 1] + twist], axis=1)
    least = room.min(axis=1)
    nearer = least < result.margin
    result.margin[nearer] = least[nearer]
    result.axis[nearer] = 2
    result.side[nearer] = np.argmin(room, axis=1)[nearer]
    result.legal[:, 2] = np.clip(twist, -limits[:, 1], limits[:, 0])


def _polygon(
    body: Body, poses: Poses, joint: int, twist_limits: Floats, result: _Nearest
) -> Floats:
    """Measure a limb against its spherical polygon, and its twist against its limits (P, 2).

    Returns the legal rotations (P, 4): the limb turned back along the great circle to the nearest
    point of the polygon, and the twist clamped.
    """
    before = _frame_before(body, poses, joint)
    relative = multiply(before, poses.rotations[:, joint])
    limb = rotate(relative, np.broadcast_to(body.stops.limb[joint], (len(poses), 3)))
    point, distance = nearest_on_polygon(
        limb, body.stops.polygon[joint], body.stops.polygon_centre[joint]
    )
    # the axis of the turn that leads out, from the polygon's frame into the joint's own axes
    outward = np.cross(limb, point) * np.where(distance < 0, -1.0, 1.0)[:, None]
    turn = rotate(conjugate(before), outward) @ body.stops.axes[joint, :2].T
    result.margin[:] = distance
    result.axis[:] = np.argmax(np.abs(turn), axis=1)
    result.side[:] = np.take_along_axis(turn, result.axis[:, None], axis=1)[:, 0] < 0
    _twist(angles_of(body, poses)[:, joint, 2], twist_limits, result)
    back = np.where((distance < 0)[:, None], shortest(limb, point), IDENTITY)
    moved = poses.rotations.copy()
    moved[:, joint] = multiply(conjugate(before), multiply(back, relative))
    legal = angles_of(body, Poses(moved, poses.reference, poses.world_from_reference))
    legal[:, joint, 2] = np.clip(legal[:, joint, 2], -twist_limits[:, 1], twist_limits[:, 0])
    return compose(body, legal)[:, joint]


def _frame_before(body: Body, poses: Poses, joint: int) -> Floats:
    """(P, 4) rotations from the frame of a joint's polygon to the segment that the joint hangs on."""
    before = np.broadcast_to(IDENTITY, (len(poses), 4))
    at = int(body.parent[joint + 1])
    while at != body.stops.polygon_frame[joint]:
        before = multiply(poses.rotations[:, at - 1], before)
        at = int(body.parent[at])
    return before
