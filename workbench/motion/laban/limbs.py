"""Limbs and the spine that move to directions within their joint stops."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.laban import Movement, Sign, sign_vector
from workbench.model.poses import Poses
from workbench.model.posing import angles_of, compose
from workbench.model.quaternions import multiply, rotate, shortest, swing_twist
from workbench.motion.laban.paths import Path, Ways
from workbench.posture.ellipse import nearest_on_cone
from workbench.posture.stops import nearest_legal, stop_limits

__all__ = ["Limb", "Spine"]

_DOWN = np.array([0.0, 0.0, -1.0])
_UP = np.array([0.0, 0.0, 1.0])
Reached = tuple[float, Floats]
"""How far [rad] from its sign a movement ends, and in which direction (3,)."""


class Limb:
    """An arm or a leg: a ball joint, a hinge, and a ball joint at its end. Directions are those of
    the segment that carries it."""

    def __init__(self, body: Body, side: str, joints: tuple[str, str, str]) -> None:
        self.body = body
        self.ball, self.hinge, self.end = (body.joint(side + name) for name in joints)
        outward = np.array([0.0, 1.0 if side == "L" else -1.0, 0.0])
        by = np.array([[1.0, 0.0, 0.0], outward, _DOWN])
        self._upper = Ways(_DOWN, by)
        self._bend = Path(np.zeros(2))  # twist of the ball joint, flexion of the hinge [rad]
        self._tip = Ways(_DOWN, by)
        self._ankle = Path(np.zeros(1))

    def move(self, move: Movement, part: str) -> Reached:
        """Take up a movement of "arm", "upper arm", "lower arm" or "hand" (or of a leg), after all
        so far."""
        sign = move.sign or Sign("place", "low")
        aim = sign_vector(sign)
        when = (move.begin, move.beats)
        if part.startswith("lower"):
            return self._bent(aim, when)
        if part == "hand":
            return self._pointed(aim, when)
        if sign.level == "middle" and sign.direction == "place":
            self._draw_in(part, when)
            return 0.0, aim
        straight = part in ("arm", "leg")
        angles = np.zeros((len(self.body.joints), 3))
        angles[self.hinge, 0] = 0.0 if straight else self._bend.last[1]
        turn = compose(self.body, angles)
        turn[self.ball] = shortest(_DOWN, aim)
        there = rotate(self._legal(turn)[self.ball], _DOWN)
        self._upper.move(*when, there)
        if straight:
            self._bend.move(*when, np.zeros(2))
            self._tip.move(*when, _DOWN)
        if "leg" in part:
            self._ankle.move(*when, np.zeros(1))
        return _angle(aim, there), there

    def _draw_in(self, part: str, when: tuple[float, float]) -> None:
        """The end to the ball joint: the hinge bends as far as it goes; a foot stays below its
        hip."""
        most = float(self.body.stops.limits[self.hinge, 0, 0])
        if part == "leg":
            self._upper.move(*when, np.array([np.sin(0.5 * most), 0.0, -np.cos(0.5 * most)]))
            self._ankle.move(*when, np.zeros(1))
        self._bend.move(*when, np.array([0.0 if part == "leg" else self._bend.last[0], most]))

    def carry(self, move: Movement, flexion: tuple[float, float, float]) -> None:
        """Stand: hip, knee and ankle bent by so many degrees."""
        hip, knee, ankle = np.radians(flexion)
        when = move.begin, move.beats
        self._upper.move(*when, np.array([np.sin(hip), 0.0, -np.cos(hip)]))
        self._bend.move(*when, np.array([0.0, knee]))
        self._ankle.move(*when, np.array([ankle]))

    def write(self, angles: Floats, time: Floats) -> None:
        """Put the joints' angles (P, J, 3) [rad] at times (P,) [s] into a table of all."""
        axes = self.body.stops.axes
        bend = self._bend.at(time)
        for joint, path in ((self.ball, self._upper), (self.end, self._tip)):
            way = path.at(time)
            swing, _ = swing_twist(shortest(np.broadcast_to(_DOWN, way.shape), way), axes[joint, 2])
            angles[:, joint, :2] = swing @ axes[joint, :2].T
        angles[:, self.ball, 2], angles[:, self.hinge, 0] = bend.T
        angles[:, self.end, 0] += self._ankle.at(time)[:, 0]

    def _legal(self, turn: Floats) -> Floats:
        """(J, 4) the nearest rotations within the stops."""
        world = np.eye(3, 4)[None]
        return np.asarray(
            nearest_legal(self.body, Poses(turn[None], self.body.segment("LT"), world))[0]
        )

    def _bent(self, aim: Floats, when: tuple[float, float]) -> Reached:
        """The lower part to a direction: the upper one turns about itself and the hinge bends, both
        within range."""
        upper = self._upper.at(np.array([sum(when)]))[0]
        swing = shortest(_DOWN, upper)
        axes = self.body.stops.axes
        ahead = np.cross(axes[self.hinge, 0], _DOWN)
        across = np.cross(axes[self.ball, 2], ahead)
        own = rotate(swing * [1, -1, -1, -1], aim)
        low, high = self._twist_limits(swing)
        turn = (
            np.arctan2(own @ across, own @ ahead)
            if np.hypot(own @ across, own @ ahead) > 1e-6
            else float(self._bend.last[0])
        )
        most = self.body.stops.limits[self.hinge, 0]
        best = (-2.0, np.zeros(2), _DOWN)
        for twist in (float(np.clip(turn, low, high)), low, high):
            plane = np.cos(twist) * ahead + np.sin(twist) * across
            flex = float(np.clip(np.arctan2(own @ plane, own @ _DOWN), -most[1], most[0]))
            found = np.cos(flex) * _DOWN + np.sin(flex) * plane
            if own @ found > best[0] + 1e-9:
                best = (float(own @ found), np.array([twist, flex]), found)
        self._bend.move(*when, best[1])
        there = rotate(swing, best[2])
        return _angle(aim, there), there

    def _twist_limits(self, swing: Floats) -> tuple[float, float]:
        turn = compose(self.body, np.zeros((len(self.body.joints), 3)))
        turn[self.ball] = swing
        pose = Poses(turn[None], self.body.segment("LT"), np.eye(3, 4)[None])
        first, second = stop_limits(self.body, angles_of(self.body, pose))[0, self.ball, 2]
        return -float(second), float(first)

    def _pointed(self, aim: Floats, when: tuple[float, float]) -> Reached:
        """The hand to a direction, by the wrist's swing."""
        end = np.array([sum(when)])
        twist, flex = self._bend.at(end)[0]
        angles = np.zeros((len(self.body.joints), 3))
        angles[self.ball, 2] = twist
        angles[self.hinge, 0] = flex
        turn = compose(self.body, angles)
        arm = multiply(
            shortest(_DOWN, self._upper.at(end)[0]), multiply(turn[self.ball], turn[self.hinge])
        )
        turn[self.end] = shortest(_DOWN, rotate(arm * [1, -1, -1, -1], aim))
        legal = self._legal(turn)[self.end]
        there = rotate(legal, _DOWN)
        self._tip.move(*when, there)
        return _angle(aim, rotate(arm, there)), rotate(arm, there)


class Spine:
    """Two joints that share a lean, each by its part of both ranges: waist and solar plexus, or
    those of the neck."""

    def __init__(self, body: Body, joints: tuple[str, str]) -> None:
        self.body, self.joints = body, [body.joint(name) for name in joints]
        self._way = Ways(_UP, np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))

    def move(self, move: Movement) -> Reached:
        """Take up a movement, after all so far."""
        aim = sign_vector(move.sign or Sign("place", "high"))
        lean = self._lean(aim[None])
        limits = self.body.stops.limits[self.joints, :2].sum(axis=0)[None]
        point, distance, _ = nearest_on_cone(lean, limits)
        there = self._reached(np.where(distance[:, None] < 0, point, lean))[0]
        self._way.move(move.begin, move.beats, there)
        return _angle(aim, there), there

    def write(self, angles: Floats, time: Floats) -> None:
        """Put the joints' angles (P, J, 3) [rad] at times (P,) [s] into a table of all."""
        aim = self._way.at(time)
        wanted = lean = self._lean(aim)
        for _ in range(
            3
            # both joints do not quite turn about one axis: the direction is met by a few
            # corrections
        ):
            lean = lean + wanted - self._lean(self._reached(lean))
        angles[:, self.joints, :2] = self._shares(lean)

    def _lean(self, aim: Floats) -> Floats:
        """(P, 2) [rad] the turn from upright to directions (P, 3) about the joints' two swing
        axes."""
        axes = self.body.stops.axes[self.joints[0]]
        swing, _ = swing_twist(shortest(np.broadcast_to(_UP, aim.shape), aim), axes[2])
        return np.asarray(swing @ axes[:2].T)

    def _shares(self, lean: Floats) -> Floats:
        """(P, 2, 2) each joint's part of a lean (P, 2), as its limits are to both limits."""
        limits = self.body.stops.limits[self.joints, :2]
        own = np.where(lean[:, None] >= 0, limits[None, ..., 0], limits[None, ..., 1])
        return np.asarray(lean[:, None] * own / np.maximum(own.sum(axis=1, keepdims=True), 1e-12))

    def _reached(self, lean: Floats) -> Floats:
        """(P, 3) the direction that a lean gives."""
        angles = np.zeros((len(lean), len(self.body.joints), 3))
        angles[:, self.joints, :2] = self._shares(lean)
        turn = compose(self.body, angles)
        both = multiply(turn[:, self.joints[0]], turn[:, self.joints[1]])
        return rotate(both, np.broadcast_to(_UP, (len(lean), 3)))


def _angle(a: Floats, b: Floats) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
