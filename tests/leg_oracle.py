"""Legs with the ball of the foot in its place, slowly and obviously: every posture of a grid. The knee
swings about the line from hip to ankle and its shank twists, the foot turns on its ball, rolls about
its length, and has its heel higher or lower. What the search of clear legs must not miss."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
from scipy.spatial.transform import Rotation

import workbench as wb

SWINGS = np.radians(np.arange(-40.0, 41.0, 5.0))
TWISTS = np.radians([-12.0, 0.0, 12.0])
TURNS = np.radians([-14.0, -7.0, 0.0, 7.0, 14.0])
ROLLS = np.radians([-16.0, -8.0, 0.0, 8.0, 16.0])
SPARE = 5e-4
"""[m] What a posture of the grid must have to spare: others are as good as touching."""


class Leg:
    """The leg of one person in one posture: joints and frames in the world."""

    def __init__(self, body, poses, foot):
        side = foot[0].upper()
        self.joints = [body.joint(side + letter) for letter in "HKA"]
        world = wb.place(body, poses).world_from_segment[0]
        self.pelvis = world[body.segment("LT")][:, :3]
        frames = [world[body.segment(side + name)] for name in ("UL", "LL", "F")]
        self.turned = [frame[:, :3] for frame in frames]
        self.hip, self.knee, self.ankle = (
            frame[:, :3] @ body.joint_in_child[0, joint] + frame[:, 3]
            for frame, joint in zip(frames, self.joints, strict=True)
        )
        ball, heel = (wb.limb(body, foot, grip=grip).tip[0] for grip in ("ball", "heel"))
        self.ball = self.turned[2] @ ball + frames[2][:, 3]
        self.sole = self.turned[2] @ (ball - heel)

    def foot(self, turn, roll, pitch):
        """The rotation (3, 3) of a foot that is turned, rolled and pitched [rad] from where it is."""
        across = np.cross(self.sole, [0.0, 0.0, 1.0])
        along = self.sole / np.linalg.norm(self.sole)
        way = Rotation.from_rotvec([0.0, 0.0, turn])
        way *= Rotation.from_rotvec(pitch * across / np.linalg.norm(across))
        way *= Rotation.from_rotvec(roll * along)
        return way.as_matrix()

    def rotations(self, swing, twist, moved):
        """Quaternions (3, 4) of hip, knee and ankle with the foot moved (3, 3); None where the leg is
        too short."""
        thigh = np.linalg.norm(self.knee - self.hip)
        shank = np.linalg.norm(self.knee - self.ankle)
        ankle = self.ball + moved @ (self.ankle - self.ball)
        way = ankle - self.hip
        far = np.linalg.norm(way)
        if not abs(thigh - shank) < far < thigh + shank:
            return None
        way = way / far
        along = (thigh**2 - shank**2 + far**2) / (2.0 * far)
        out = self.knee - self.hip
        out = out - (out @ way) * way
        out = Rotation.from_rotvec(swing * way).apply(out / np.linalg.norm(out))
        knee = self.hip + along * way + np.sqrt(thigh**2 - along**2) * out
        old, new = (self.knee - self.hip, self.ankle - self.knee), (knee - self.hip, ankle - knee)
        upper = _brought(old, new) @ self.turned[0]
        lower = _brought(old[::-1], new[::-1]) @ self.turned[1]
        lower = Rotation.from_rotvec(twist * new[1] / shank).as_matrix() @ lower
        frames = (self.pelvis, upper, lower, moved @ self.turned[2])
        between = [one.T @ other for one, other in pairwise(frames)]
        return Rotation.from_matrix(between).as_quat(scalar_first=True)


def _brought(old, new):
    """The rotation that brings the first of two vectors to the new first one, and the plane of both to
    that of the new ones."""

    def frame(first, second):
        first = first / np.linalg.norm(first)
        third = np.cross(first, second)
        third /= np.linalg.norm(third)
        return np.column_stack([first, np.cross(third, first), third])

    return frame(*new) @ frame(*old).T


def legs_of_grid(body, poses, foot, pitches):
    """Poses (P,) of one person in which a leg is within its stops, the ball of its foot in its place,
    its sole pitched by one of some angles [rad]."""
    leg = Leg(body, poses, foot)
    found = []
    for turn, roll, pitch in product(TURNS, ROLLS, pitches):
        moved = leg.foot(turn, roll, pitch)
        for swing, twist in product(SWINGS, TWISTS):
            turned = leg.rotations(swing, twist, moved)
            if turned is not None:
                found.append(poses.rotations[0].copy())
                found[-1][leg.joints] = turned
    world = np.repeat(poses.world_from_reference, len(found), axis=0)
    every = wb.Poses(np.array(found), poses.reference, world)
    margin = wb.stops(body, every).margin[:, leg.joints].min(axis=1)
    return every.rows(np.flatnonzero(margin >= 0.0))


def leg_overlap(body, poses, foot, environment):
    """(P,) [m] how much deeper the leg is in parts than they allow; negative where it is clear."""
    names = [foot[0].upper() + name for name in ("UL", "LL", "F")]
    room = wb.room(wb.place(body, poses), environment)
    return -room[:, [body.segment(name) for name in names]].min(axis=1)
