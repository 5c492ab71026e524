"""A driver's posture: the trunk by the statistical angles, the seat where the legs want it, the
feet on their pedals.

In the order of Reed, Manary, Flannagan & Schneider's cascade (2002): the hips along the track, then
the eyes over the hips, then the trunk and the limbs by inverse kinematics guided by data. Angles
that do not go together are settled by least squares in units of their scatter, and what is left is
told as residuals.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.body.forward import place, segment_frames
from workbench.errors import InputError, UsageError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.driving import Driver, Package
from workbench.model.environment import Seat
from workbench.model.poses import Poses, check_rows
from workbench.model.posing import angles_of, attitude_matrix, compose, motion_of
from workbench.posture.reaching.chains import (
    AGAIN,
    REACHED,
    TURN_LEVER,
    cold,
    goals_of,
    limb_task,
    posed,
    rows_of,
    solved,
)
from workbench.posture.reaching.limbs import FEET
from workbench.posture.seating.driving_angles import drawn_angles, driving_angles, h_point_offset
from workbench.posture.seating.driving_legs import Sole, hips_from_pedal, soles_on
from workbench.posture.seating.spine import SPINE, Spine, side_view, spine_of, spine_tilts
from workbench.posture.seating.stepping import limits_of

__all__ = ["Drivers", "DrivingCase", "DrivingPosture", "at_wheel", "driving_posture"]

LIFTS = 4
LIFTED = 1e-4
"""Rounds of lifting the seat for the view, as the posture changes with the height, and how little
[m] ends them."""


@dataclass(frozen=True, eq=False)
class DrivingPosture:
    """One driver at the wheel (hands as they were): poses (P = 1) in the world; the seat's
    `forward` and `up` [m], and `wanted` [m], the forward position without an end of travel; eye,
    hips, h_point (3,) [m]: the middle of the eyes, of the hip joints, and the seat's hip point;
    expected, found (8,) [rad]: the angles of ANGLES as predicted (or drawn) and as the body has
    them; by foot, how far it stays from its place [m] and what limits it."""

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
    """The driving posture of a body whose arms are as in `poses` (P = 1), in a seat that faces
    along +x.

    feet: by "left foot" and "right foot" a point [m] of the pedal or rest that it is on, its heel
    on the floor. eye [m]: the seat stands as low as brings the eyes to this height; at its
    reference height where None. seed: the angles are drawn for the so-numbered `person`; the mean
    posture where None. The seat's hip point comes to where the body wants it by `h_point_offset`,
    as far as the travel goes. InputError for a seat that faces elsewhere, and for a body without
    hips, eyes and ears.
    """
    case = DrivingCase(seat, package, feet, eye, seed)
    found = at_wheel(body, poses, case, drivers=[driver], numbers=[person])
    placed = place(body, found.poses)
    forward, up, wanted = (float(value) for value in found.travel[0])
    return DrivingPosture(
        poses=found.poses,
        forward=forward,
        up=up,
        wanted=wanted,
        eye=found.eye[0],
        hips=found.hips[0],
        h_point=np.array(package.h_point) + np.array([forward, 0.0, up]),
        expected=found.expected[0],
        found=side_view(placed)[0],
        miss={foot: float(miss[0]) for foot, miss in found.miss.items()},
        limit={foot: words[0] for foot, words in found.limit.items()},
    )


@dataclass(frozen=True, eq=False)
class DrivingCase:
    """What drivers share: the seat, the package, where the feet go [m], the height of the eyes [m],
    the seed."""

    seat: Seat
    package: Package
    feet: Mapping[str, tuple[float, float, float]]
    eye: float | None
    seed: int | None


@dataclass(frozen=True, eq=False)
class Drivers:
    """B drivers at the wheel: poses; travel (B, 3) [m]: forward, up, and forward without an end of
    travel; eye, hips (B, 3) [m]; expected (B, 8) [rad]; by foot the miss (B,) [m] and what limits
    it."""

    poses: Poses
    travel: Floats
    eye: Floats
    hips: Floats
    expected: Floats
    miss: dict[str, Floats]
    limit: dict[str, tuple[str, ...]]


@dataclass(frozen=True, eq=False)
class _Crew:
    """B drivers before they sit: their bodies (rows of one), drivers, numbers, trunks, soles, and the poses they
    come with."""

    body: Body
    drivers: Sequence[Driver]
    numbers: Sequence[int]
    spines: list[Spine]
    soles: dict[str, Sole]
    poses: Poses


def at_wheel(
    body: Body,
    poses: Poses,
    case: DrivingCase,
    *,
    drivers: Sequence[Driver],
    numbers: Sequence[int],
) -> Drivers:
    """Drivers at the wheel, a row of poses each: trunk, then seat, lifted until the eyes have their
    height, then feet.

    Poses come back by the segment that they were given by. InputError as of `driving_posture`.
    """
    seat = case.seat
    if abs(np.sin(seat.yaw)) > 1e-9 or np.cos(seat.yaw) < 0:
        raise InputError(
            f"seat {seat.name!r} faces {np.degrees(seat.yaw):g} degrees off +x; driving postures are for "
            f"drivers who face along +x"
        )
    check_rows(poses, len(body), "bodies")
    if not {"right foot"} <= set(case.feet) <= set(FEET):
        raise UsageError(
            f"feet: expected 'right foot', and 'left foot' or not, got {', '.join(case.feet) or 'none'}"
        )
    if min([case.seed or 0, *numbers]) < 0:
        raise UsageError(f"seed, person: expected 0 or more, got {case.seed} and {min(numbers)}")
    low, high = seat.travel_up
    soles = {foot: soles_on(body, foot, at, case.package) for foot, at in case.feet.items()}
    crew = _Crew(body, drivers, numbers, [spine_of(one) for one in body], soles, poses)
    up = np.full(len(body), min(max(0.0, low), high) if case.eye is None else low)
    rows = _seated(crew, case, up)
    for _ in range(LIFTS if case.eye is not None else 0):
        lift = np.clip(up + (case.eye or 0.0) - rows.eye[:, 2], low, high)
        off = np.abs(lift - up) >= LIFTED
        if not off.any():
            break
        up = np.where(off, lift, up)
        rows = _seated(crew, case, up)
    return _stepped(crew, rows)


def _seated(crew: _Crew, case: DrivingCase, up: Floats) -> Drivers:
    """The drivers with the seat lifted by `up` (B,) [m], feet as they were."""
    body = crew.body
    x, y, z = case.package.h_point
    angles = []
    for driver, number, lift in zip(crew.drivers, crew.numbers, up.tolist(), strict=True):
        mean = driving_angles(driver, replace(case.package, h_point=(x, y, z + lift)))
        angles.append(
            mean if case.seed is None else drawn_angles(mean, case.seed, person=int(number))
        )
    tilts = spine_tilts(crew.spines, angles)
    aft, above = np.array([h_point_offset(driver) for driver in crew.drivers]).T
    height = z + up - above
    wanted = hips_from_pedal(crew.soles["right foot"], height, angles) - aft - x
    forward = np.clip(wanted, *case.seat.travel_forward)
    hips = np.stack([x + forward + aft, np.full(len(up), y), height], axis=1)
    seated = _placed(crew, tilts, hips)
    sphere = [body.sphere_names.index(f"{side} eye") for side in ("left", "right")]
    head = segment_frames(body, seated, int(body.sphere_segment[sphere[0]]))
    eye = (
        np.einsum("bij,bj->bi", head[:, :, :3], body.centre[:, sphere].mean(axis=1)) + head[:, :, 3]
    )
    expected = np.array([one.mean for one in angles])
    return Drivers(seated, np.stack([forward, up, wanted], axis=1), eye, hips, expected, {}, {})


def _placed(crew: _Crew, tilts: Floats, hips: Floats) -> Poses:
    """The poses with the trunks tilted segment by segment (B, 5) [rad] aft, the middle of the hips
    at points (B, 3)."""
    body = crew.body
    rotations = np.array(crew.poses.rotations)
    angles = np.zeros((len(tilts), len(body.joints), 3))
    joints = [body.joint(name) for name in SPINE[1:]]
    for k, joint in enumerate(joints):
        axis, sign = motion_of(body, joint, "flexion")
        angles[:, joint, axis] = sign * (tilts[:, k] - tilts[:, k + 1])
    rotations[:, joints] = compose(body, angles)[:, joints]
    world = np.zeros((len(tilts), 3, 4))
    world[:, :, :3] = [attitude_matrix(pitch=-tilt) for tilt in tilts[:, 0].tolist()]
    own = np.array([spine.hips for spine in crew.spines])
    world[:, :, 3] = hips - np.einsum("bij,bj->bi", world[:, :, :3], own)
    return Poses(rotations, body.segment("LT"), world)


def _stepped(crew: _Crew, rows: Drivers) -> Drivers:
    """Every foot with its ball on its point and its sole along its way where that can be, else as
    near as it gets."""
    seated = rows.poses
    miss = {}
    limit = {}
    who = np.arange(len(seated))
    for foot, sole in crew.soles.items():
        goal = goals_of(sole.at)
        goal[:, 3:6] = sole.along
        goal[:, 9:] = TURN_LEVER
        task = limb_task(
            crew.body,
            sole.limb,
            who,
            held=seated.rotations,
            base=np.array(seated.world_from_reference),
            goal=goal,
        )
        start = cold(task, angles_of(task.body, seated)[:, task.joints])
        found = solved(task, start, AGAIN)
        off = np.flatnonzero(found.numbers[:, 0] > REACHED)
        rotations = posed(task, found.angles)
        numbers = found.numbers.copy()
        if len(off):
            free = replace(rows_of(task, off), goal=goals_of(sole.at[off]))
            found = solved(free, start[off], AGAIN)
            rotations[off] = posed(free, found.angles)
            numbers[off] = found.numbers
        seated = Poses(rotations, seated.reference, seated.world_from_reference)
        miss[foot], limit[foot] = numbers[:, 0].copy(), limits_of(task, numbers)
    world = segment_frames(crew.body, seated, crew.poses.reference)
    return replace(
        rows, poses=Poses(seated.rotations, crew.poses.reference, world), miss=miss, limit=limit
    )
