"""A score of direction signs as a motion of a body that keeps within its joint stops.

Each movement runs from rest to rest along a great circle, its share of the way after the share u of
its time being 10 u^3 - 15 u^4 + 6 u^5: least jerk, as people move from point to point (Flash &
Hogan, J. Neurosci. 5(7), 1985). A direction that the stops forbid becomes the nearest one that they
allow.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.body.forward import place
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.laban import SUBPARTS, Movement, Score, nearest_sign, sign_vector
from workbench.model.poses import Poses
from workbench.model.posing import compose
from workbench.motion.laban.limbs import Limb, Spine
from workbench.motion.laban.paths import smooth
from workbench.posture.stops import nearest_legal

__all__ = ["score_poses"]

_LEAST_RATE = 50.0
_MOST_RATE = 1000.0
_FRAMES = 20
_MOST_FRAMES = 2_000_000
_TOLD = np.radians(1.0)
"""What a stop keeps from its direction by less is not told."""
_LEVELS = {"low": (25.0, 50.0, 25.0), "middle": (0.0, 0.0, 0.0), "high": (0.0, 0.0, -35.0)}
"""Flexion of hip and knee and dorsiflexion of the ankle [deg] of a leg that carries the body."""


def score_poses(body: Body, score: Score) -> tuple[Poses, tuple[str, ...]]:
    """The motion of a body with the paper's joints that a score tells, and what the joint stops
    kept from it.

    The body begins upright with its arms at its sides, the pelvis stays upright and faces forward,
    the lowest sphere is on the ground z = 0. A part without a movement keeps its joints' angles;
    feet slide as a support moves. At least 50 frames a second, and 20 in the shortest movement.
    InputError where the body has not the paper's joints.
    """
    lacking = [
        j
        for j in (
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
        )
        if j not in body.joints
    ]
    if lacking:
        raise InputError(
            f"body {body.name}: a score is told by the paper's joints, {', '.join(lacking)} are missing"
        )
    beat = 60.0 / score.tempo
    moves = [
        replace(m, begin=(m.begin - 1.0) * beat, beats=m.beats * beat) for m in score.movements
    ]
    time = _clock(score, moves)
    notes: list[str] = []
    angles = np.zeros((len(time), len(body.joints), 3))
    for name, joints in (("trunk", ("W", "SP")), ("head", ("NP", "HP"))):
        spine = Spine(body, joints)
        for move in _about(moves, name):
            _tell(notes, score, move, spine.move(move))
        spine.write(angles, time)
    for side in ("left", "right"):
        arm = Limb(body, side[0].upper(), ("S", "E", "W"))
        for move in _about(moves, *_whole(f"{side} arm")):
            _tell(notes, score, move, arm.move(move, move.part.split(" ", 1)[1]))
        arm.write(angles, time)
        _leg(body, side, (moves, score, notes), (angles, time))
    poses = _grounded(body, compose(body, angles), (_travelled(moves, score, time), time))
    return poses, tuple(notes)


def _clock(score: Score, moves: list[Movement]) -> Floats:
    """(P,) [s] even frames until the last movement has ended."""
    shortest = min(m.beats for m in moves)
    end = max(m.begin + m.beats for m in moves)
    rate = float(np.clip(np.ceil(_FRAMES / shortest), _LEAST_RATE, _MOST_RATE))
    frames = int(np.ceil(end * rate - 1e-9)) + 1
    if frames > _MOST_FRAMES:
        raise InputError(
            f"{score.file}: {end:g} s at {rate:g} frames a second are more than {_MOST_FRAMES} frames"
        )
    return np.asarray(np.arange(frames) / rate)


def _whole(limb: str) -> tuple[str, ...]:
    return (limb, *SUBPARTS[limb])


def _about(moves: list[Movement], *parts: str) -> list[Movement]:
    return [m for m in moves if m.part in parts and m.sign is not None]


def _tell(notes: list[str], score: Score, move: Movement, found: tuple[float, Floats]) -> None:
    """A note where a movement ends elsewhere than its sign says: by how far [rad], and where
    (3,)."""
    off, vector = found
    if off > _TOLD:
        where = f"line {move.line}: " if move.line else ""
        notes.append(
            f"{where}{move.part} {move.sign} is beyond the joint stops; the nearest legal posture is "
            f"{np.degrees(off):.0f} degrees from it, {nearest_sign(vector)}"
        )


def _leg(
    body: Body, side: str, told: tuple[list[Movement], Score, list[str]], out: tuple[Floats, Floats]
) -> None:
    """A leg that carries the body at the level of the support, unless it gestures."""
    moves, score, notes = told
    leg = Limb(body, side[0].upper(), ("H", "K", "A"))
    level = "middle"
    carries = True
    for move in _about(moves, "support", *_whole(f"{side} leg")):
        if move.part == "support":
            level = move.sign.level if move.sign else level
            if carries:
                leg.carry(move, _LEVELS[level])
        elif move.part == f"{side} leg" and str(move.sign) == "place low":
            leg.carry(move, _LEVELS[level])
            carries = True
        else:
            _tell(notes, score, move, leg.move(move, move.part.split(" ", 1)[1]))
            carries = False
    leg.write(*out)


def _travelled(moves: list[Movement], score: Score, time: Floats) -> Floats:
    """(P, 2) [m] how far the supports have carried the body."""
    way = np.zeros((len(time), 2))
    for move in _about(moves, "support"):
        flat = sign_vector(move.sign)[:2] if move.sign else np.zeros(2)
        length = float(np.linalg.norm(flat))
        step = score.step * flat / length if length else flat
        way += smooth((time - move.begin) / move.beats)[:, None] * step
    return way


def _grounded(body: Body, rotations: Floats, when: tuple[Floats, Floats]) -> Poses:
    """The motion with every frame within the stops and its lowest sphere on the ground."""
    way, time = when
    world = np.tile(np.eye(3, 4), (len(time), 1, 1))
    pelvis = body.segment("LT")
    legal = rotations
    for _ in range(2):  # the range of one joint may depend on another
        legal = nearest_legal(body, Poses(legal, pelvis, world))
    for first in range(0, len(time), 1024):
        some = slice(first, first + 1024)
        centres = place(body, Poses(legal[some], pelvis, world[some])).centres
        world[some, 2, 3] = -(centres[..., 2] - body.radius[0]).min(axis=1)
    world[:, :2, 3] = way
    return Poses(legal, pelvis, world, time)
