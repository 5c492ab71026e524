"""Perform a score of direction signs with a body, within its joint stops.

Each movement runs from rest to rest along a great circle, in minimum-jerk time (`paths`). A
direction beyond the stops is replaced by the nearest one within them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from workbench.body.forward import place
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.joint_angles import compose
from workbench.model.laban import SUBPARTS, Movement, Score, nearest_sign, sign_vector
from workbench.model.poses import Poses
from workbench.motion.laban.limbs import Ending, Limb, Spine, minimum_jerk
from workbench.posture.stops import nearest_legal

__all__ = ["BATCH_SIZE", "score_poses"]

_JOINTS = [
    "W",
    "SP",
    "NP",
    "HP",
    "LS",
    "RS",
    "LE",
    "RE",
    "LW",
    "RW",
    "LH",
    "RH",
    "LK",
    "RK",
    "LA",
    "RA",
]
"""The paper's joints that signs move."""
_MIN_RATE = 50.0
"""Least frames per second."""
_MAX_RATE = 1000.0
_FRAMES = 20
"""Least frames in the shortest movement, unless they exceed the greatest rate."""
_MAX_FRAMES = 2_000_000
BATCH_SIZE = 1024
"""Frames that are placed at once, to bound the memory."""
_NOTED_ERROR = np.radians(1.0)
"""Angle [rad] between a sign and the direction reached from which on a note reports it."""
_LEVELS = {"low": (25.0, 50.0, 25.0), "middle": (0.0, 0.0, 0.0), "high": (0.0, 0.0, -35.0)}
"""Flexion of hip and knee and dorsiflexion of the ankle [deg] of a leg that carries the body."""


def score_poses(body: Body, score: Score) -> tuple[Poses, tuple[str, ...]]:
    """Compute the motion that a score describes.

    The body begins upright with its arms at its sides. The pelvis stays upright and faces forward,
    and the lowest sphere is on the ground z = 0. A part without a movement keeps its joint angles.
    Feet slide as a support moves. There are at least 50 frames a second, and 20 in the shortest
    movement.

    Parameters
    ----------
    body
        A body with the paper's joints.
    score
        The score, its times in beats.

    Returns
    -------
    tuple of Poses and str
        The motion, and a note for each movement that the joint stops keep from its sign.

    Raises
    ------
    InputError
        If the body has other joints, or the motion too many frames.
    """
    missing = [joint for joint in _JOINTS if joint not in body.joints]
    if missing:
        raise InputError(
            f"body {body.name}: a score needs the paper's joints; {', '.join(missing)} are missing"
        )
    performance = _Performance(body, score, _in_seconds(score))
    time = _frame_times(score, performance.movements)
    angles = np.zeros((len(time), len(body.joints), 3))
    _perform_spine(performance, angles, time)
    for side in ("left", "right"):
        _perform_arm(performance, side).write(angles, time)
        _perform_leg(performance, side).write(angles, time)
    travel = _support_travel(performance, time)
    return _grounded(body, compose(body, angles), travel, time), tuple(performance.notes)


@dataclass
class _Performance:
    """A score that is being performed by a body."""

    body: Body
    score: Score
    movements: list[Movement]
    """The movements of the score in seconds."""
    notes: list[str] = field(default_factory=list)

    def movements_of(self, *parts: str) -> list[Movement]:
        """The movements of some parts that have a sign; those without one hold."""
        return [m for m in self.movements if m.part in parts and m.sign is not None]

    def note(self, movement: Movement, ending: Ending) -> None:
        """Note a movement that ends elsewhere than its sign says."""
        if ending.error <= _NOTED_ERROR:
            return
        line = f"line {movement.line}: " if movement.line else ""
        self.notes.append(
            f"{line}{movement.part} {movement.sign} is beyond the joint stops; the nearest legal posture is "
            f"{np.degrees(ending.error):.0f} degrees from it, {nearest_sign(ending.direction)}"
        )


def _in_seconds(score: Score) -> list[Movement]:
    """The movements with begin [s] from the first beat on and duration [s] instead of beats."""
    beat = 60.0 / score.tempo
    return [replace(m, begin=(m.begin - 1.0) * beat, beats=m.beats * beat) for m in score.movements]


def _frame_times(score: Score, movements: list[Movement]) -> Floats:
    """(P,) [s] at an even rate until the last movement has ended."""
    shortest = min(m.beats for m in movements)
    end = max(m.begin + m.beats for m in movements)
    rate = float(np.clip(np.ceil(_FRAMES / shortest), _MIN_RATE, _MAX_RATE))
    frames = int(np.ceil(end * rate - 1e-9)) + 1
    if frames > _MAX_FRAMES:
        raise InputError(
            f"{score.file}: {end:g} s at {rate:g} frames a second are more than {_MAX_FRAMES} frames"
        )
    return np.asarray(np.arange(frames) / rate)


def _perform_spine(performance: _Performance, angles: Floats, time: Floats) -> None:
    """Write trunk and head into joint angles (P, J, 3) [rad]."""
    for part, joints in (("trunk", ("W", "SP")), ("head", ("NP", "HP"))):
        spine = Spine(performance.body, joints)
        for movement in performance.movements_of(part):
            performance.note(movement, spine.move(movement))
        spine.write(angles, time)


def _with_subparts(limb: str) -> tuple[str, ...]:
    """A whole limb and its parts."""
    return (limb, *SUBPARTS[limb])


def _part_of_limb(movement: Movement) -> str:
    """The part without its side: "lower arm" of "left lower arm"."""
    return movement.part.split(" ", 1)[1]


def _perform_arm(performance: _Performance, side: str) -> Limb:
    arm = Limb(performance.body, side[0].upper(), ("S", "E", "W"))
    for movement in performance.movements_of(*_with_subparts(f"{side} arm")):
        performance.note(movement, arm.move(movement, _part_of_limb(movement)))
    return arm


def _perform_leg(performance: _Performance, side: str) -> Limb:
    """A leg carries the body at the level of the support, until it gestures.

    It carries again from the sign "place low" on.
    """
    leg = Limb(performance.body, side[0].upper(), ("H", "K", "A"))
    level = "middle"
    carries = True
    for movement in performance.movements_of("support", *_with_subparts(f"{side} leg")):
        if movement.part == "support":
            level = movement.sign.level if movement.sign else level
            if carries:
                leg.stand(movement, _LEVELS[level])
        elif movement.part == f"{side} leg" and str(movement.sign) == "place low":
            leg.stand(movement, _LEVELS[level])
            carries = True
        else:
            performance.note(movement, leg.move(movement, _part_of_limb(movement)))
            carries = False
    return leg


def _support_travel(performance: _Performance, time: Floats) -> Floats:
    """(P, 2) [m] by which the supports have carried the body; they add up where they overlap."""
    travel = np.zeros((len(time), 2))
    for movement in performance.movements_of("support"):
        direction = sign_vector(movement.sign)[:2] if movement.sign else np.zeros(2)
        length = float(np.linalg.norm(direction))
        step = performance.score.step * direction / length if length else direction
        travel += minimum_jerk((time - movement.begin) / movement.beats)[:, None] * step
    return travel


def _grounded(body: Body, rotations: Floats, travel: Floats, time: Floats) -> Poses:
    """The motion with every frame within the stops and its lowest sphere on the ground z = 0.

    rotations (P, J, 4), travel (P, 2) [m] of the pelvis, time (P,) [s].
    """
    world = np.tile(np.eye(3, 4), (len(time), 1, 1))
    pelvis = body.segment("LT")
    legal = rotations
    for _ in range(2):  # the range of one joint may depend on the angle of another
        legal = nearest_legal(body, Poses(legal, pelvis, world))
    for first in range(0, len(time), BATCH_SIZE):
        rows = slice(first, first + BATCH_SIZE)
        centres = place(body, Poses(legal[rows], pelvis, world[rows])).centres
        world[rows, 2, 3] = -(centres[..., 2] - body.radius[0]).min(axis=1)
    world[:, :2, 3] = travel
    return Poses(legal, pelvis, world, time)
