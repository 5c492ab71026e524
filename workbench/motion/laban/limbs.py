"""Move limbs and the spine to directions, within their joint stops.

Each class keeps the movements of one part as paths of directions and angles. Movements are added in
the order of time, then `write` samples the joint angles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.joint_angles import angles_of, compose
from workbench.model.laban import Movement, Sign, sign_vector
from workbench.model.poses import Poses
from workbench.model.quaternions import conjugate, multiply, rotate, shortest, swing_twist
from workbench.posture.stops import nearest_legal, nearest_on_cone, stop_limits

__all__ = ["DirectionPath", "Ending", "Limb", "Path", "Spine", "minimum_jerk"]

_FORWARD = np.array([1.0, 0.0, 0.0])
_LEFT = np.array([0.0, 1.0, 0.0])
_DOWN = np.array([0.0, 0.0, -1.0])
_UP = np.array([0.0, 0.0, 1.0])
_SPINE_CORRECTIONS = 3
"""Fixed-point steps for the lean of two joints, whose axes are not quite parallel."""


class Ending(NamedTuple):
    """Where a movement ends, in the frame of the segment that carries the part."""

    error: float
    """Angle [rad] from the direction of the sign."""
    direction: Floats
    """(3,) unit vector."""


class Limb:
    """An arm or a leg: a ball joint, a hinge, and a ball joint at its end.

    Directions are those of the segment that carries the limb. The zero pose hangs down.
    """

    def __init__(self, body: Body, side: str, joints: tuple[str, str, str]) -> None:
        self.body = body
        self.ball, self.hinge, self.end = (body.joint(side + name) for name in joints)
        outward = _LEFT if side == "L" else -_LEFT
        via = np.array([_FORWARD, outward, _DOWN])
        self._upper = DirectionPath(_DOWN, via)
        """Direction of the upper part."""
        self._bend = Path(np.zeros(2))
        """Twist of the ball joint and flexion of the hinge [rad]."""
        self._tip = DirectionPath(_DOWN, via)
        """Direction of hand or foot in the frame of the lower part."""
        self._ankle = Path(np.zeros(1))
        """Dorsiflexion [rad] of the end joint, in addition to its direction."""

    def move(self, movement: Movement, part: str) -> Ending:
        """Add a movement after all so far.

        Parameters
        ----------
        part
            What moves: "arm", "upper arm", "lower arm", "hand", "leg", "upper leg" or "lower leg".

        Returns
        -------
        Ending
            The nearest direction within the joint stops.
        """
        sign = movement.sign or Sign("place", "low")
        if part.startswith("lower"):
            return self._move_lower(movement, sign_vector(sign))
        if part == "hand":
            return self._move_hand(movement, sign_vector(sign))
        if sign.level == "middle" and sign.direction == "place":
            self._draw_in(movement, part)
            return Ending(0.0, sign_vector(sign))
        return self._move_upper(movement, part, sign_vector(sign))

    def _move_upper(self, movement: Movement, part: str, aim: Floats) -> Ending:
        """Point the whole limb, stretched, or its upper part alone."""
        begin, span = movement.begin, movement.beats
        stretched = part in ("arm", "leg")
        angles = np.zeros((len(self.body.joints), 3))
        angles[self.hinge, 0] = 0.0 if stretched else self._bend.last[1]
        rotations = compose(self.body, angles)
        rotations[self.ball] = shortest(_DOWN, aim)
        reached = rotate(self._legal(rotations)[self.ball], _DOWN)
        self._upper.move(begin, span, reached)
        if stretched:
            self._bend.move(begin, span, np.zeros(2))
            self._tip.move(begin, span, _DOWN)
        if "leg" in part:
            self._ankle.move(begin, span, np.zeros(1))
        return Ending(_angle(aim, reached), reached)

    def _draw_in(self, movement: Movement, part: str) -> None:
        """Bring the end to the ball joint: bend the hinge fully; a foot stays below its hip."""
        begin, span = movement.begin, movement.beats
        flexion = float(self.body.stops.limits[self.hinge, 0, 0])
        twist = self._bend.last[0]
        if part == "leg":
            # thigh and shank about equally long: half the knee's flexion is the hip's
            thigh = np.array([np.sin(0.5 * flexion), 0.0, -np.cos(0.5 * flexion)])
            self._upper.move(begin, span, thigh)
            self._ankle.move(begin, span, np.zeros(1))
            twist = 0.0
        self._bend.move(begin, span, np.array([twist, flexion]))

    def stand(self, movement: Movement, flexion: tuple[float, float, float]) -> None:
        """Add a movement to a standing posture with flexions [deg] of hip, knee and ankle."""
        begin, span = movement.begin, movement.beats
        hip, knee, ankle = np.radians(flexion)
        self._upper.move(begin, span, np.array([np.sin(hip), 0.0, -np.cos(hip)]))
        self._bend.move(begin, span, np.array([0.0, knee]))
        self._ankle.move(begin, span, np.array([ankle]))

    def write(self, angles: Floats, time: Floats) -> None:
        """Write the limb's joint angles at times (P,) [s] into a table (P, J, 3) [rad]."""
        axes = self.body.stops.axes
        twist, flexion = self._bend.at(time).T
        for joint, path in ((self.ball, self._upper), (self.end, self._tip)):
            direction = path.at(time)
            rotation = shortest(np.broadcast_to(_DOWN, direction.shape), direction)
            swing, _ = swing_twist(rotation, axes[joint, 2])
            angles[:, joint, :2] = swing @ axes[joint, :2].T
        angles[:, self.ball, 2] = twist
        angles[:, self.hinge, 0] = flexion
        angles[:, self.end, 0] += self._ankle.at(time)[:, 0]

    def _legal(self, rotations: Floats) -> Floats:
        """(J, 4) the nearest joint rotations within the stops."""
        return np.asarray(nearest_legal(self.body, _pose(self.body, rotations))[0])

    def _move_lower(self, movement: Movement, aim: Floats) -> Ending:
        """Point the lower part: the ball joint twists and the hinge bends, within their ranges.

        The reachable directions are a family of arcs, one for each twist. If the range of the twist
        leaves out the aim, the nearest arc is one of the two at its ends.
        """
        end = movement.begin + movement.beats
        swing = shortest(_DOWN, self._upper.at(np.array([end]))[0])
        axes = self.body.stops.axes
        ahead = np.cross(axes[self.hinge, 0], _DOWN)  # where flexion takes the lower part
        across = np.cross(axes[self.ball, 2], ahead)
        own_aim = rotate(conjugate(swing), aim)
        low, high = self._twist_limits(swing)
        twist = float(self._bend.last[0])
        if np.hypot(own_aim @ across, own_aim @ ahead) > 1e-6:  # else any twist will do
            twist = float(np.arctan2(own_aim @ across, own_aim @ ahead))
        twists = (float(np.clip(twist, low, high)), low, high)
        bend, direction = self._nearest_bend(own_aim, twists, np.array([ahead, across]))
        self._bend.move(movement.begin, movement.beats, bend)
        reached = rotate(swing, direction)
        return Ending(_angle(aim, reached), reached)

    def _nearest_bend(
        self, aim: Floats, twists: tuple[float, ...], plane_axes: Floats
    ) -> tuple[Floats, Floats]:
        """Twist and flexion (2,) [rad] nearest to an aim (3,), and the direction (3,) they give.

        A twist t bends in the plane of down and cos t a + sin t b, with plane_axes a and b (2, 3).
        """
        best_cosine = -2.0
        best_bend = np.zeros(2)
        best_direction = _DOWN
        for twist in twists:
            plane = np.cos(twist) * plane_axes[0] + np.sin(twist) * plane_axes[1]
            flexion = self._nearest_flexion(aim, plane)
            direction = np.cos(flexion) * _DOWN + np.sin(flexion) * plane
            if aim @ direction > best_cosine + 1e-9:  # the first of equals
                best_cosine = float(aim @ direction)
                best_bend = np.array([twist, flexion])
                best_direction = direction
        return best_bend, best_direction

    def _nearest_flexion(self, aim: Floats, plane: Floats) -> float:
        """The hinge's flexion [rad] nearest to an aim (3,), bending from down toward `plane`."""
        flexion, extension = self.body.stops.limits[self.hinge, 0]
        return float(np.clip(np.arctan2(aim @ plane, aim @ _DOWN), -extension, flexion))

    def _twist_limits(self, swing: Floats) -> tuple[float, float]:
        """Least and greatest twist [rad] of the ball joint at a swing, a quaternion (4,)."""
        rotations = compose(self.body, np.zeros((len(self.body.joints), 3)))
        rotations[self.ball] = swing
        angles = angles_of(self.body, _pose(self.body, rotations))
        greatest, least = stop_limits(self.body, angles)[0, self.ball, 2]
        return -float(least), float(greatest)

    def _move_hand(self, movement: Movement, aim: Floats) -> Ending:
        """Point the hand by the wrist's swing, with the arm where it will be at the end."""
        end = np.array([movement.begin + movement.beats])
        angles = np.zeros((len(self.body.joints), 3))
        angles[self.ball, 2], angles[self.hinge, 0] = self._bend.at(end)[0]
        rotations = compose(self.body, angles)
        swing = shortest(_DOWN, self._upper.at(end)[0])
        arm = multiply(swing, multiply(rotations[self.ball], rotations[self.hinge]))
        rotations[self.end] = shortest(_DOWN, rotate(conjugate(arm), aim))
        tip = rotate(self._legal(rotations)[self.end], _DOWN)
        self._tip.move(movement.begin, movement.beats, tip)
        reached = rotate(arm, tip)
        return Ending(_angle(aim, reached), reached)


class Spine:
    """Two joints in series that share a lean in proportion to their ranges.

    They are waist and solar plexus, or the two joints of the neck.
    """

    def __init__(self, body: Body, joints: tuple[str, str]) -> None:
        self.body = body
        self.joints = [body.joint(name) for name in joints]
        self._direction = DirectionPath(_UP, np.array([_FORWARD, _LEFT]))

    def move(self, movement: Movement) -> Ending:
        """Add a movement after all so far; return the nearest direction within the stops."""
        aim = sign_vector(movement.sign or Sign("place", "high"))
        lean = self._lean(aim[None])
        limits = self.body.stops.limits[self.joints, :2].sum(axis=0)[None]
        nearest, distance, _ = nearest_on_cone(lean, limits)
        beyond = distance[:, None] < 0
        reached = self._direction_of(np.where(beyond, nearest, lean))[0]
        self._direction.move(movement.begin, movement.beats, reached)
        return Ending(_angle(aim, reached), reached)

    def write(self, angles: Floats, time: Floats) -> None:
        """Write the joint angles at times (P,) [s] into a table (P, J, 3) [rad]."""
        wanted = self._lean(self._direction.at(time))
        lean = wanted
        # the two joints do not quite turn about one axis: correct the lean by what it misses
        for _ in range(_SPINE_CORRECTIONS):
            lean = lean + wanted - self._lean(self._direction_of(lean))
        angles[:, self.joints, :2] = self._shares(lean)

    def _lean(self, direction: Floats) -> Floats:
        """(P, 2) [rad] swing from upright to directions (P, 3), about the first joint's axes."""
        axes = self.body.stops.axes[self.joints[0]]
        rotation = shortest(np.broadcast_to(_UP, direction.shape), direction)
        swing, _ = swing_twist(rotation, axes[2])
        return np.asarray(swing @ axes[:2].T)

    def _shares(self, lean: Floats) -> Floats:
        """(P, 2, 2) swing of each joint for a lean (P, 2), in proportion to the joints' limits."""
        limits = self.body.stops.limits[self.joints, :2]
        own = np.where(lean[:, None] >= 0, limits[None, ..., 0], limits[None, ..., 1])
        return np.asarray(lean[:, None] * own / np.maximum(own.sum(axis=1, keepdims=True), 1e-12))

    def _direction_of(self, lean: Floats) -> Floats:
        """(P, 3) directions that leans (P, 2) give."""
        angles = np.zeros((len(lean), len(self.body.joints), 3))
        angles[:, self.joints, :2] = self._shares(lean)
        rotations = compose(self.body, angles)
        both = multiply(rotations[:, self.joints[0]], rotations[:, self.joints[1]])
        return rotate(both, np.broadcast_to(_UP, (len(lean), 3)))


def _pose(body: Body, rotations: Floats) -> Poses:
    """One pose of joint rotations (J, 4), with the pelvis at the origin."""
    return Poses(rotations[None], body.segment("LT"), np.eye(3, 4)[None])


def _angle(a: Floats, b: Floats) -> float:
    """Angle [rad] between two vectors (3,)."""
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


_OPPOSITE = np.cos(np.radians(170.0))
"""Cosine of the angle from which on two directions count as opposite."""
_NEARLY_PARALLEL = 0.9
"""Cosine of the angle to the start from which on a direction cannot be turned through."""


def minimum_jerk(share: Floats) -> Floats:
    """Compute the share of the way that a minimum-jerk movement has done.

    s(u) = 10 u^3 - 15 u^4 + 6 u^5 moves from rest to rest with the least integral of the squared
    jerk, as people move from point to point.

    Parameters
    ----------
    share
        (P,) shares u of the time; the way is 0 before 0 and 1 after 1.

    Returns
    -------
    Floats
        (P,) shares of the way.

    References
    ----------
    Flash, T. & Hogan, N. (1985), The coordination of arm movements: an experimentally confirmed
    mathematical model, Journal of Neuroscience 5, 1688-1703.
    """
    u = np.clip(share, 0.0, 1.0)
    return np.asarray(u**3 * (10.0 - 15.0 * u + 6.0 * u**2))


class Path:
    """Numbers (k,) that move from rest to rest, target after target.

    A movement begins where the one before has come to by then, even if that one is not at its end.
    """

    def __init__(self, start: Floats) -> None:
        self._start = np.array(start, dtype=np.float64)
        self._moves: list[tuple[float, float, Floats, Floats]] = []
        """Begin [s], span [s], start (k,) and target (k,) of each movement."""

    @property
    def last(self) -> Floats:
        """The last target (k,), or the start before any movement."""
        return self._moves[-1][3] if self._moves else self._start

    def move(self, begin: float, span: float, target: Floats) -> None:
        """Append a movement to a target (k,) that begins at `begin` [s] and takes `span` [s]."""
        start = self.at(np.array([begin]))[0]
        self._moves.append((begin, span, start, np.array(target, dtype=np.float64)))

    def at(self, time: Floats) -> Floats:
        """Return the values (P, k) at times (P,) [s]."""
        values = np.repeat(self._start[None], len(time), axis=0)
        latest = np.searchsorted([move[0] for move in self._moves], time) - 1
        for k in np.unique(latest[latest >= 0]).tolist():
            begin, span, start, target = self._moves[k]
            rows = latest == k
            share = minimum_jerk((time[rows] - begin) / span)
            values[rows] = self._interpolate(start, target, share)
        return values

    def _interpolate(self, start: Floats, target: Floats, share: Floats) -> Floats:
        """(P, k) values after shares (P,) of the way."""
        return np.asarray(start + share[:, None] * (target - start))


class DirectionPath(Path):
    """A unit vector (3,) that moves along great circles.

    A turn to the opposite direction has no unique great circle. It passes through the first of the
    directions `via` (n, 3) that is not nearly parallel to the start.
    """

    def __init__(self, start: Floats, via: Floats) -> None:
        super().__init__(start)
        self._via = via

    def _interpolate(self, start: Floats, target: Floats, share: Floats) -> Floats:
        if start @ target >= _OPPOSITE:
            return _great_circle(start, target, share)
        middle = next(way for way in self._via if abs(way @ start) < _NEARLY_PARALLEL)
        first = _great_circle(start, middle, 2.0 * share)
        second = _great_circle(middle, target, 2.0 * share - 1.0)
        return np.where(share[:, None] < 0.5, first, second)


def _great_circle(start: Floats, target: Floats, share: Floats) -> Floats:
    """(P, 3) points on the shorter great circle between two unit vectors (slerp)."""
    across = target - start * (start @ target)
    sine = float(np.linalg.norm(across))
    if sine < 1e-12:
        return np.repeat(target[None], len(share), axis=0)
    angle = np.arctan2(sine, float(start @ target)) * share[:, None]
    return np.asarray(np.cos(angle) * start + np.sin(angle) * across / sine)
