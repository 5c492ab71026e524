"""A driver's posture: the trunk by the statistical angles, the seat where the legs want it, the feet on their pedals.

In the order of Reed, Manary, Flannagan & Schneider's cascade (2002): the hips along the track, then the eyes over
the hips, then the trunk and the limbs by inverse kinematics guided by data. Angles that do not go together are settled
by least squares in units of their scatter, and what is left is told as residuals.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.driving import ANGLES, Driver, DrivingAngles, Package
from workbench.model.environment import Seat
from workbench.model.poses import Poses
from workbench.model.posing import angles_of, attitude_matrix, compose, motion_of
from workbench.solve.driving_angles import drawn_angles, driving_angles, h_point_offset
from workbench.solve.forward import place
from workbench.solve.limbs import limb
from workbench.solve.posture import eye_points
from workbench.solve.reach import reach
from workbench.solve.spine import SPINE, Spine, side_view, spine_of, spine_tilts

__all__ = ["DrivingPosture", "driving_posture"]

GRID = 0.001
"""Spacing [m] of the hip places that are tried."""
NEAR, FAR = 0.15, 1.3
"""How far aft of the ankle [m] hips are looked for."""
LIFTS = 4
"""Rounds of lifting the seat for the view: the posture changes with the height."""


@dataclass(frozen=True, eq=False)
class DrivingPosture:
    """One driver at the wheel (hands as they were): poses (P = 1) in the world; the seat's `forward` and `up` [m], and
    `wanted` [m], the forward position without an end of travel; eye, hips, h_point (3,) [m]: the middle of the eyes, of
    the hip joints, and the seat's hip point; expected, found (8,) [rad]: the angles of ANGLES as predicted (or drawn)
    and as the body has them; by foot, how far it stays from its place [m] and what limits it."""

    poses: Poses
    forward: float
    up: float
    wanted: float
    eye: Floats
    hips: Floats
    h_point: Floats
    expected: Floats
    found: Floats
    miss: Mapping[str, float]
    limit: Mapping[str, str]

    @property
    def residual(self) -> dict[str, float]:
        """By angle, found less expected [rad]."""
        return dict(zip(ANGLES, (self.found - self.expected).tolist(), strict=True))


def driving_posture(
    body: Body,
    poses: Poses,
    seat: Seat,
    *,
    driver: Driver,
    package: Package,
    feet: Mapping[str, tuple[float, float, float]],
    eye: float | None = None,
    seed: int | None = None,
    person: int = 0,
) -> DrivingPosture:
    """The driving posture of a body whose arms are as in `poses` (P = 1), in a seat that faces along +x.

    feet: by "left foot" and "right foot" a point [m] of the pedal or rest that it is on, its heel on the floor. eye
    [m]: the seat stands as low as brings the eyes to this height; at its reference height where None. seed: the angles
    are drawn for the so-numbered `person`; the mean posture where None. The seat's hip point comes to where the body
    wants it by `h_point_offset`, as far as the travel goes. InputError for a seat that faces elsewhere, and for a body
    without hips, eyes and ears.
    """
    if abs(np.sin(seat.yaw)) > 1e-9 or np.cos(seat.yaw) < 0:
        raise InputError(f"seat {seat.name!r} faces {np.degrees(seat.yaw):g} degrees off +x; driving postures are for "
                         f"drivers who face along +x")  # fmt: skip
    low, high = seat.travel_up
    up = min(max(0.0, low), high) if eye is None else low
    posture = _at_height(body, poses, seat, (driver, package, feet, seed, person), up)
    for _ in range(LIFTS if eye is not None else 0):
        lift = float(np.clip(up + (eye or 0.0) - posture.eye[2], low, high))
        if abs(lift - up) < 1e-4:
            break
        up = lift
        posture = _at_height(body, poses, seat, (driver, package, feet, seed, person), up)
    return posture


_Case = tuple[Driver, Package, Mapping[str, tuple[float, float, float]], int | None, int]


def _at_height(body: Body, poses: Poses, seat: Seat, case: _Case, up: float) -> DrivingPosture:
    """The posture with the seat lifted by `up` [m]."""
    driver, package, feet, seed, person = case
    x, y, z = package.h_point
    lifted = replace(package, h_point=(x, y, z + up))
    angles = driving_angles(driver, lifted)
    angles = angles if seed is None else drawn_angles(angles, seed, person=person)
    spine = spine_of(body)
    tilts = spine_tilts(spine, angles)
    aft, above = h_point_offset(driver)
    soles = {foot: _sole(body, foot, at, package) for foot, at in feet.items()}
    wanted = _hip_x(body, (soles["right foot"], z + up - above), angles) - aft - x
    forward = float(np.clip(wanted, *seat.travel_forward))
    hips = np.array([x + forward + aft, y, z + up - above])
    seated = _placed(body, poses, spine, (tilts, hips))
    miss: dict[str, float] = {}
    limit: dict[str, str] = {}
    for foot, (at, along) in soles.items():
        seated, miss[foot], limit[foot] = _foot(body, seated, foot, (at, along))
    placed = place(body, seated)
    return DrivingPosture(
        poses=Poses(seated.rotations, poses.reference, placed.world_from_segment[:, poses.reference]),
        forward=forward,
        up=up,
        wanted=wanted,
        eye=eye_points(placed)[0],
        hips=hips,
        h_point=np.array([x + forward, y, z + up]),
        expected=angles.mean,
        found=side_view(placed)[0],
        miss=miss,
        limit=limit,
    )


def _placed(body: Body, poses: Poses, spine: Spine, how: tuple[Floats, Floats]) -> Poses:
    """The poses with the trunk tilted segment by segment (5,) [rad] aft, the middle of the hips at a point (3,) [m]."""
    tilts, hips = how
    angles = angles_of(body, poses)
    for k, name in enumerate(SPINE[1:]):
        joint = body.joint(name)
        axis, sign = motion_of(body, joint, "flexion")
        angles[:, joint] = 0.0
        angles[:, joint, axis] = sign * (tilts[k] - tilts[k + 1])
    rotations = poses.rotations.copy()
    joints = [body.joint(name) for name in SPINE[1:]]
    rotations[:, joints] = compose(body, angles)[:, joints]
    world = np.zeros((len(poses), 3, 4))
    world[:, :, :3] = attitude_matrix(pitch=-float(tilts[0]))
    world[:, :, 3] = hips - world[:, :, :3] @ spine.hips
    return Poses(rotations, body.segment("LT"), world)


def _sole(body: Body, foot: str, at: tuple[float, float, float], package: Package) -> tuple[Floats, Floats]:
    """Where the ball of a foot goes (3,) [m] and the way (3,) from heel to ball, the heel on the floor.

    The sole, which of a shod foot lies under the foot's own, is in the plane that rises from the heel point (for the
    other foot: from beside it) to the pedal; the round of the heel rests in the corner of floor and plane, and the ball
    lies as far up as the foot is long.
    """
    ball, heel = limb(body, foot, grip="ball"), limb(body, foot, grip="heel")
    length = float(np.linalg.norm(ball.tip - heel.tip))
    start = np.array([package.heel[0], at[1], package.heel[2]])
    plane = (at - start) / np.linalg.norm(at - start)
    slope = float(np.arctan2(plane[2], plane[0]))
    spheres = body.spheres(heel.end)
    names = body.sphere_names[spheres]
    lowest = float((body.centre[spheres, 2] - body.radius[spheres]).min())
    sole = max(float(min(ball.tip[2], heel.tip[2])) - lowest, 0.0)
    around = float(body.radius[int(spheres.start) + names.index("heel")]) + sole
    lift = sole * np.array([-plane[2], 0.0, plane[0]])
    return start + (around * np.tan(0.5 * slope) + length) * plane + lift, plane


def _hip_x(body: Body, where: tuple[tuple[Floats, Floats], float], angles: DrivingAngles) -> float:
    """x [m] of the hips at a height [m] from which thigh and knee come nearest to their angles, in units of their
    scatter, the right foot being on the accelerator."""
    (at, along), height = where
    ball, heel = limb(body, "right foot", grip="ball"), limb(body, "right foot", grip="heel")
    hip, knee, ankle = (body.joint(name) for name in ("RH", "RK", "RA"))
    thigh = float(np.linalg.norm(body.joint_in_child[hip] - body.joint_in_parent[knee]))
    shank = float(np.linalg.norm(body.joint_in_child[knee] - body.joint_in_parent[ankle]))
    sole = ball.tip - heel.tip
    turn = np.arctan2(along[2], along[0]) - np.arctan2(sole[2], sole[0])
    offset = attitude_matrix(pitch=-float(turn)) @ (body.joint_in_child[ankle] - ball.tip)
    end = at + offset
    x = end[0] - np.arange(NEAR, FAR, GRID)
    reach_x, rise = end[0] - x, end[2] - height
    span = np.clip(np.hypot(reach_x, rise), abs(thigh - shank) + 1e-6, thigh + shank - 1e-6)
    bent = np.arccos((thigh**2 + shank**2 - span**2) / (2 * thigh * shank))
    lifted = np.arctan2(rise, reach_x) + np.arccos((thigh**2 + span**2 - shank**2) / (2 * thigh * span))
    off = np.stack([lifted, bent], axis=1) - angles.mean[6:]
    too_far = np.hypot(reach_x, rise) - span
    cost = np.sum((off / angles.spread[6:]) ** 2, axis=1) + 1e3 * np.abs(too_far)
    best = int(np.clip(np.argmin(cost), 1, len(x) - 2))
    a, b, c = cost[best - 1 : best + 2]
    return float(x[best] - GRID * 0.5 * (a - c) / max(a - 2 * b + c, 1e-12))


def _foot(body: Body, poses: Poses, foot: str, sole: tuple[Floats, Floats]) -> tuple[Poses, float, str]:
    """The foot with its ball on a point and its sole along a direction where that can be, else as near as it gets."""
    at, along = sole
    ball, heel = limb(body, foot, grip="ball"), limb(body, foot, grip="heel")
    way = ball.tip - heel.tip
    pointed = replace(ball, pointing=way / np.linalg.norm(way))
    found = reach(body, poses, at, limb=pointed, direction=along)
    if not found.reached[0]:
        found = reach(body, poses, at, limb=ball)
    kept = Poses(found.poses.rotations, poses.reference, poses.world_from_reference)
    return kept, float(found.miss[0]), "" if found.reached[0] else found.limit(0)
