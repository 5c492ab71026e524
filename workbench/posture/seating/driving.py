"""A driver's posture: the trunk by the statistical angles, the seat where the legs want it, the
feet on their pedals.

In the order of Reed, Manary, Flannagan & Schneider's cascade (2002): the hips along the track, then
the eyes over the hips, then the trunk and the limbs by inverse kinematics guided by data. Angles
that do not go together are settled by least squares in units of their scatter, and what is left is
told as residuals.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise

import numpy as np

from workbench.body.forward import segment_frames
from workbench.errors import InputError, UsageError, one_of
from workbench.model.arguments import short_repr
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.criterion import Reason
from workbench.model.driving import Driver, Package
from workbench.model.environment import Seat
from workbench.model.joint_angles import angles_of, compose, join_poses, motion_of
from workbench.model.poses import Poses, row_for_each
from workbench.posture.kernels.trunk_fit import trunk_turns
from workbench.posture.reaching.limbs import FEET
from workbench.posture.reaching.reach_solver import (
    REACHED,
    TURN_LEVER,
    cold,
    goals_of,
    joint_rotations,
    limb_task,
    rows_of,
    solve_reaches,
)
from workbench.posture.seating.driving_angles import drawn_angles, expected_angles, h_point_offset
from workbench.posture.seating.driving_legs import (
    Sole,
    accelerator_foot,
    ankles_wanted,
    directions_of,
    hips_from_pedal,
    pitches_at,
    soles_on,
)
from workbench.posture.seating.resting import pressed_thighs
from workbench.posture.seating.seat import PEOPLE_PER_SEAT_BATCH, Seated, in_world
from workbench.posture.seating.seating import own_axes
from workbench.posture.seating.stepping import limits_of

__all__ = ["SPINE", "DrivingPosture", "Spine", "driving_posture", "spine_of", "spine_tilts"]

LIFTS = 4
LIFTED = 1e-4
"""Rounds of lifting the seat for the view, as the posture changes with the height, and how little
[m] ends them."""
SOLE_AGAIN = 0
BALL_AGAIN = 2
"""Seeds to begin again from where a leg does not bring the sole, or then the ball, to its pedal from
its comfort modes. In 60 drivers of the car at all places of the seat no seed brought one of 5,000
legs there, or nearer, that had not come from comfort."""


@dataclass(frozen=True, eq=False)
class DrivingPosture(Seated):
    """B drivers at the wheel, a row each, with their hands as they were.

    A foot's `miss` is the distance from its pedal or rest. Where the travel ends before the seat is
    where the driver wants it, `spare_travel` is negative by what is lacking.
    """

    wanted: Floats = field(kw_only=True)
    """(B,) [m] `forward` without an end of travel; `forward` where the seats are held."""
    hips: Floats = field(kw_only=True)
    """(B, 3) [m] the middle of the hip joints."""
    h_point: Floats = field(kw_only=True)
    """(B, 3) [m] the hip point of the seat."""
    expected: Floats = field(kw_only=True)
    """(B, 8) [rad] the angles of ANGLES as predicted, or drawn."""

    __repr__ = short_repr


def driving_posture(
    body: Body,
    poses: Poses,
    seat: Seat,
    *,
    drivers: Sequence[Driver],
    package: Package,
    feet: Mapping[str, tuple[float, float, float]],
    eye: float | None = None,
    seed: int | None = None,
    numbers: Sequence[int] = (),
    positions: Floats | None = None,
) -> DrivingPosture:
    """Find the driving postures of B drivers.

    They are found in the seat's own axes. The foot that is nearest to the
    ball of foot reference point is on the accelerator; of two alike the right one. The seat's hip point comes to where the body wants it by `h_point_offset`, as far as the travel
    goes. A driver gets the same posture alone and in any company.

    Parameters
    ----------
    body, poses
        B poses of the rows of a body, from which the arms are taken: of one person, of each row in
        their order, or of the rows that `poses.person` names.
    seat
        The seat with its travel.
    drivers
        B drivers: sex, size and age.
    package
        The car's dimensions.
    feet
        By "left foot" and "right foot" the point [m] of the pedal or rest that it is on, its heel
        on the floor.
    eye
        Height [m] of the eyes; the seat stands as low as gives it. At its reference height if None.
    seed
        The angles are drawn about their means; the means if None.
    numbers
        B numbers by which the angles of each are drawn; 0 to B - 1 if empty.
    positions
        (B, 2) [m] forward and up, where the seat of each is held. Anywhere in its travel if None.

    Raises
    ------
    InputError
        If a body lacks hips, eyes or ears.
    UsageError
        If the numbers of rows do not match.
    """
    count = len(poses)
    people = row_for_each(body, poses)
    who = list(drivers)
    drawn = list(numbers) or list(range(count))
    if not len(who) == len(drawn) == count:
        got = f"{len(who)} and {len(drawn)}"
        raise UsageError(f"drivers, numbers: expected {count} of each for {count} poses, got {got}")
    axes = own_axes(seat)
    travel = np.array([seat.travel_forward, seat.travel_up])
    ends = np.tile(travel, (count, 1, 1)) if positions is None else np.stack([positions] * 2, -1)
    every = _Case(
        axes.seat,
        Package(*(axes.point(getattr(package, one.name)) for one in fields(package))),
        {foot: axes.point(at) for foot, at in feet.items()},
        None if eye is None else axes.height(eye),
        seed,
        ends,
        positions is not None,
    )
    parts = []
    for first in range(0, count, PEOPLE_PER_SEAT_BATCH):
        some = slice(first, first + PEOPLE_PER_SEAT_BATCH)
        own = Poses(poses.rotations[some], poses.reference, poses.world_from_reference[some])
        case = replace(every, travel=ends[some])
        parts.append(_at_wheel(people[some], own, case, who[some], drawn[some]))
    found = in_world(_driving(parts, every, poses.person), axes)
    return replace(found, hips=axes.back(found.hips), h_point=axes.back(found.h_point))


def _driving(parts: Sequence[_Drivers], case: _Case, person: Ints | None) -> DrivingPosture:
    """Drivers as postures of the rows `person` of a body."""
    forward, up, wanted = np.concatenate([part.travel for part in parts]).T
    eyes = np.concatenate([part.eye for part in parts])
    poses = join_poses([part.poses for part in parts])
    count = len(forward)
    feet = list(parts[0].miss)
    (rear, front), (low, high) = case.forward, case.up
    shift = np.stack([forward, np.zeros(count), up], axis=1)
    return DrivingPosture(
        poses=replace(poses, person=person),
        forward=forward,
        up=up,
        shift=shift,
        eye=eyes,
        eye_off=eyes[:, 2] - case.eye if case.eye is not None else np.zeros(count),
        miss={foot: np.concatenate([part.miss[foot] for part in parts]) for foot in feet},
        limit={foot: tuple(words for part in parts for words in part.limit[foot]) for foot in feet},
        spare_travel=np.stack([wanted - rear, front - wanted, up - low, high - up], axis=1),
        discomfort=np.zeros(count),
        tried=np.ones(count, dtype=np.int64),
        pressed=np.concatenate([part.pressed for part in parts]),
        pitches={foot: np.concatenate([part.pitches[foot] for part in parts]) for foot in feet},
        wanted=wanted,
        hips=np.concatenate([part.hips for part in parts]),
        h_point=np.array(case.package.h_point) + shift,
        expected=np.concatenate([part.expected for part in parts]),
    )


@dataclass(frozen=True, eq=False)
class _Case:
    """What drivers share: the seat, the package, where the feet go [m], the height of the eyes [m],
    the seed; the travel (B, 2, 2) [m] of each: forward and up, the least and the greatest; and
    whether the seats are held where they are, so that no place is looked for."""

    seat: Seat
    package: Package
    feet: Mapping[str, tuple[float, float, float]]
    eye: float | None
    seed: int | None
    travel: Floats
    held: bool

    @property
    def pedal_foot(self) -> str:
        """The foot on the accelerator."""
        return accelerator_foot(self.feet, self.package.ball)

    @property
    def forward(self) -> tuple[Floats, Floats]:
        """The least and the greatest travel forward (B,) [m]."""
        return self.travel[:, 0, 0], self.travel[:, 0, 1]

    @property
    def up(self) -> tuple[Floats, Floats]:
        """The least and the greatest travel up (B,) [m]."""
        return self.travel[:, 1, 0], self.travel[:, 1, 1]


@dataclass(frozen=True, eq=False)
class _Drivers:
    """B drivers at the wheel: poses; travel (B, 3) [m]: forward, up, and forward without an end of
    travel; eye, hips (B, 3) [m]; expected (B, 8) [rad]; by foot the miss (B,) [m] and what limits
    it; pressed (B,) [m] and pitches as of `Seated`."""

    poses: Poses
    travel: Floats
    eye: Floats
    hips: Floats
    expected: Floats
    miss: dict[str, Floats]
    limit: dict[str, tuple[Reason, ...]]
    pressed: Floats
    pitches: dict[str, Floats]


@dataclass(frozen=True, eq=False)
class _Crew:
    """B drivers before they sit: their bodies (rows of one), drivers, numbers, trunks, soles, the
    plantarflexion (B,) [rad] that they want of each foot's ankle, and the poses they come with."""

    body: Body
    drivers: Sequence[Driver]
    numbers: Sequence[int]
    spine: Spine
    soles: dict[str, Sole]
    ankles: dict[str, Floats]
    poses: Poses


def _at_wheel(
    body: Body, poses: Poses, case: _Case, drivers: Sequence[Driver], numbers: Sequence[int]
) -> _Drivers:
    """Drivers at the wheel: trunk, then seat, lifted until the eyes have their height, then feet.

    Poses come back by the segment that they were given by.
    """
    seat = case.seat
    if not case.feet or not set(case.feet) <= set(FEET):
        raise UsageError(
            f"feet: expected 'left foot', 'right foot' or both, got {', '.join(case.feet) or 'none'}"
        )
    if min([case.seed or 0, *numbers]) < 0:
        raise UsageError(f"seed, person: expected 0 or more, got {case.seed} and {min(numbers)}")
    low, high = case.up
    soles = {foot: soles_on(body, foot, at, case.package) for foot, at in case.feet.items()}
    ankles = {
        foot: ankles_wanted(body, foot, case.seed if foot == case.pedal_foot else None, numbers)
        for foot in case.feet
    }
    crew = _Crew(body, drivers, numbers, spine_of(body), soles, ankles, poses)
    up = np.clip(0.0, low, high) if case.eye is None else low
    rows = _seated(crew, case, up)
    for _ in range(LIFTS if case.eye is not None else 0):
        lift = np.clip(up + (case.eye or 0.0) - rows.eye[:, 2], low, high)
        off = np.abs(lift - up) >= LIFTED
        if not off.any():
            break
        up = np.where(off, lift, up)
        rows = _seated(crew, case, up)
    done = _stepped(crew, rows)
    shift = np.insert(done.travel[:, :2], 1, 0.0, axis=1)
    return replace(done, pressed=pressed_thighs(body, done.poses, seat, shift, case.feet))


def _seated(crew: _Crew, case: _Case, up: Floats) -> _Drivers:
    """The drivers with the seat lifted by `up` (B,) [m], feet as they were."""
    body = crew.body
    x, y, z = case.package.h_point
    mean, spread = expected_angles(crew.drivers, case.package, up)
    drawn = mean
    if case.seed is not None:
        drawn = drawn_angles(mean, spread, case.seed, crew.numbers)
    tilts = spine_tilts(crew.spine, drawn, spread)
    aft, above = np.array([h_point_offset(driver) for driver in crew.drivers]).T
    height = z + up - above
    rear, front = case.forward
    wanted = rear.copy()
    if not case.held:
        pedal = case.pedal_foot
        others = [sole for foot, sole in crew.soles.items() if foot != pedal]
        angles = (mean, drawn, spread)
        hip = hips_from_pedal(crew.soles[pedal], height, angles, crew.ankles[pedal], others)
        wanted = hip - aft - x
    forward = np.clip(wanted, rear, front)
    hips = np.stack([x + forward + aft, np.full(len(up), y), height], axis=1)
    seated = _placed(crew, tilts, hips)
    sphere = [body.sphere_names.index(f"{side} eye") for side in ("left", "right")]
    head = segment_frames(body, seated, int(body.sphere_segment[sphere[0]]))
    eye = (
        np.einsum("bij,bj->bi", head[:, :, :3], body.centre[:, sphere].mean(axis=1)) + head[:, :, 3]
    )
    travel = np.stack([forward, up, wanted], axis=1)
    pitches = {
        foot: np.stack([sole.flattest, sole.steepest], axis=1) for foot, sole in crew.soles.items()
    }
    return _Drivers(seated, travel, eye, hips, drawn, {}, {}, np.zeros(len(up)), pitches)


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
    pitch = -tilts[:, 0]  # nose up about y: see attitude_matrix
    world[:, 0, 0] = world[:, 2, 2] = np.cos(pitch)
    world[:, 0, 2] = np.sin(pitch)
    world[:, 2, 0] = -world[:, 0, 2]
    world[:, 1, 1] = 1.0
    world[:, :, 3] = hips - np.einsum("bij,bj->bi", world[:, :, :3], crew.spine.hips)
    return Poses(rotations, body.segment("LT"), world)


def _stepped(crew: _Crew, rows: _Drivers) -> _Drivers:
    """Every foot with its ball on its point and its sole as flat as the ankle wants it where that can
    be, else in the plane of the pedal, else as near as it gets."""
    seated = rows.poses
    miss = {}
    limit = {}
    who = np.arange(len(seated))
    for foot, sole in crew.soles.items():
        pitch = pitches_at(sole, rows.hips, crew.ankles[foot])
        task = limb_task(
            crew.body,
            sole.limb,
            who,
            held=seated.rotations,
            base=np.array(seated.world_from_reference),
            goal=_goals(sole, pitch),
        )
        start = cold(task, angles_of(task.body, seated)[:, task.joints])
        found = solve_reaches(task, start, SOLE_AGAIN)
        rotations = joint_rotations(task, found.angles)
        numbers = found.numbers.copy()
        freer = ((_goals(sole, sole.steepest), SOLE_AGAIN), (goals_of(sole.at), BALL_AGAIN))
        for goal, again in freer:
            off = np.flatnonzero(numbers[:, 0] > REACHED)
            if len(off):
                some = replace(rows_of(task, off), goal=goal[off])
                found = solve_reaches(some, start[off], again)
                rotations[off] = joint_rotations(some, found.angles)
                numbers[off] = found.numbers
        seated = Poses(rotations, seated.reference, seated.world_from_reference)
        miss[foot], limit[foot] = numbers[:, 0].copy(), limits_of(task, numbers)
    world = segment_frames(crew.body, seated, crew.poses.reference)
    return replace(
        rows, poses=Poses(seated.rotations, crew.poses.reference, world), miss=miss, limit=limit
    )


def _goals(sole: Sole, pitch: Floats) -> Floats:
    """(B, 12) goals of feet with their balls on their pedal and soles of a pitch (B,) [rad]."""
    goal = goals_of(sole.at)
    goal[:, 3:6] = directions_of(pitch)
    goal[:, 9:] = TURN_LEVER
    return goal


# The trunk in side view: a body's own landmarks for the published angles, and the tilts that come
# nearest to them.
#
# The waist joint stands for the sacrum's upper end (L5/S1), the solar plexus joint for T12/L1, the
# neck pivot for C7/T1; the ears and the eyes are the body's. Where a body has these joints a little
# elsewhere, its bones are so much longer or shorter than people's, and the angles cannot all be had
# together with the line from hip to eye.

SPINE = ("LT", "W", "SP", "NP", "HP")
"""The lower torso, and the joints that tilt what is above."""
TRUNK = (5, 4, 3, 2, 1)
"""Pelvis, abdomen, thorax, neck, head in ANGLES."""
JUST = 1e-6
LEAN = (-1.0, 2.0)
"""How far [rad] a lower torso may tilt aft."""


@dataclass(frozen=True, eq=False)
class Spine:
    """B trunks in side view, upright as in the zero pose: hips (B, 3) [m] the middle of the hip
    joints in the lower torso; links (B, 6, 2) [m]: forward and up from the hips to the waist, to the
    solar plexus, the neck pivot, the head pivot, the ear, and from the ear to the eye; flexion (4, 2)
    [rad]: least and greatest flexion of the joints."""

    hips: Floats
    links: Floats
    flexion: Floats


def spine_of(body: Body) -> Spine:
    """The trunks of the rows of a body. InputError where it has no human trunk, or no eyes and
    ears."""
    sides = [body.joint(name) for name in ("LH", "RH")]
    joints = [body.joint(name) for name in SPINE[1:]]
    hips = 0.5 * (body.joint_in_parent[:, sides[0]] + body.joint_in_parent[:, sides[1]])
    ear = _middle(body, "ear")
    points = [body.joint_in_parent[:, joints[0]] - hips]
    points += [body.joint_in_parent[:, b] - body.joint_in_child[:, a] for a, b in pairwise(joints)]
    points += [ear - body.joint_in_child[:, joints[3]], _middle(body, "eye") - ear]
    flexion = np.zeros((4, 2))
    for k, joint in enumerate(joints):
        axis, sign = motion_of(body, joint, "flexion")
        first, second = body.stops.limits[joint, axis]
        flexion[k] = (-second, first) if sign > 0 else (-first, second)
    return Spine(hips, np.stack(points, axis=1)[:, :, [0, 2]], flexion)


def _middle(body: Body, name: str) -> Floats:
    """(B, 3) [m] midway between a left and a right sphere of the head."""
    rows = []
    for side in ("left", "right"):
        if f"{side} {name}" not in body.sphere_names:
            known = [n for n in body.sphere_names if n]
            raise InputError(
                f"body {body.name} has no sphere '{side} {name}'; {one_of(f'{side} {name}', known)}"
            )
        rows.append(body.centre[:, body.sphere_names.index(f"{side} {name}")])
    return 0.5 * (rows[0] + rows[1])


def spine_tilts(spine: Spine, mean: Floats, spread: Floats) -> Floats:
    """(B, 5) [rad] how far lower, central and upper torso, neck and head of B trunks tilt aft of
    upright.

    The line from hip to eye is held, as the cascade has it; within the joint stops the five angles
    are as near to the given ones (B, 8) [rad] as they can be, by least squares in units of their
    scatter (B, 8). Where the stops do not let the line be had, it is come near to.
    """
    links = np.ascontiguousarray(spine.links)
    count = len(links)
    bounds = np.empty((count, 5, 2))
    bounds[:, 0] = LEAN
    bounds[:, 1:] = spine.flexion + np.array([JUST, -JUST])
    turns = np.zeros((count, 5))
    turns[:, 0] = mean[:, TRUNK[0]] - np.arctan2(-links[:, 0, 0], links[:, 0, 1])
    turns = np.clip(turns, bounds[..., 0], bounds[..., 1])
    wanted = np.ascontiguousarray(mean[:, [0, *TRUNK]])
    trunk_turns(links, wanted, np.ascontiguousarray(spread[:, list(TRUNK)]), bounds, turns)
    return np.concatenate([turns[:, :1], turns[:, :1] - np.cumsum(turns[:, 1:], axis=1)], axis=1)
