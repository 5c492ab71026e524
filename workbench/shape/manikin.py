"""A body held in the postures of anthropometry, so that lengths can be read off it as an anthropometer does.

Every length is a sum of reaches: how far a sphere's surface, or a joint, lies along a direction. With the extreme
spheres held fixed a length is linear in the body's coordinates and radii, which is what scaling needs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.posing import pose
from workbench.model.quaternions import rotate

__all__ = ["BACK", "DOWN", "FRONT", "LEFT", "POSTURES", "RIGHT", "UP", "Length", "Manikin", "Reach", "Shape"]

FRONT, BACK = np.array([1.0, 0, 0]), np.array([-1.0, 0, 0])
LEFT, RIGHT = np.array([0, 1.0, 0]), np.array([0, -1.0, 0])
UP, DOWN = np.array([0, 0, 1.0]), np.array([0, 0, -1.0])

_SIDES = ("L", "R")
_SIT = {f"{s}{joint}": {"flexion": 90.0} for s in _SIDES for joint in ("H", "K", "E")}
# NATICK/TR-15/007 (ANSUR II): standing upright; sitting upright, thighs level, knees and elbows at right angles;
# the arm level to the front; both arms overhead; the legs stretched to the front.
POSTURES: dict[str, dict[str, dict[str, float]]] = {
    "standing": {},
    "sitting": _SIT,
    "arm_forward": {"RS": {"flexion": 90.0}},
    # the clavicle takes 38 of the 180 degrees, within its stop; both turn about the same axis
    "overhead": {
        **{f"{s}C": {"elevation": 38.0} for s in _SIDES},
        **{f"{s}S": {"abduction": 142.0} for s in _SIDES},
        **{f"{s}H": {"flexion": 90.0} for s in _SIDES},
    },
    "legs_forward": {f"{s}H": {"flexion": 90.0} for s in _SIDES},
}


@dataclass(frozen=True)
class Reach:
    """How far one point lies along a direction in a posture: a sphere's surface (`sphere`), or a joint (`joint`)."""

    posture: str
    direction: tuple[float, float, float]
    sphere: int = -1
    joint: int = -1
    surface: bool = True


@dataclass(frozen=True)
class Length:
    """A sum of signed reaches."""

    terms: tuple[tuple[float, Reach], ...]

    def __add__(self, other: Length) -> Length:
        return Length(self.terms + other.terms)

    def __sub__(self, other: Length) -> Length:
        return self + other * -1.0

    def __mul__(self, factor: float) -> Length:
        return Length(tuple((factor * sign, reach) for sign, reach in self.terms))


@dataclass(frozen=True, eq=False)
class Shape:
    """What may change in a body: sphere centres (S, 3), radii (S,), joint coordinates in parent and child (J, 3)."""

    centre: Floats
    radius: Floats
    in_parent: Floats
    in_child: Floats


class Manikin:
    """A body (or a change of one) in the postures of anthropometry."""

    def __init__(self, body: Body, shape: Shape | None = None) -> None:
        """Raises InputError where the body lacks the joints that the postures name: it is not a human body."""
        missing = sorted({joint for angles in POSTURES.values() for joint in angles} - set(body.joints))
        if missing:
            raise InputError(f"body {body.name} cannot be measured as a person: it has no joint {', '.join(missing)}")
        self.body = body
        self.shape = shape or Shape(body.centre, body.radius, body.joint_in_parent, body.joint_in_child)
        self._segment = body.sphere_segment
        self._frames = {name: _frames(body, angles) for name, angles in POSTURES.items()}
        self._found: dict[tuple[str, ...], Ints] = {}
        self.placed = {name: self._place(frames) for name, frames in self._frames.items()}

    def _place(self, frames: Floats) -> tuple[Floats, Floats]:
        """Sphere centres (S, 3) and joints (J, 3) in the world; the stage at the origin. Linear in the shape."""
        body, shape = self.body, self.shape
        origin = np.zeros((len(body.segments), 3))
        joint = np.zeros((len(body.joints), 3))
        for n in range(1, len(body.segments)):
            parent = int(body.parent[n])
            joint[n - 1] = origin[parent] + frames[parent] @ shape.in_parent[n - 1]
            origin[n] = joint[n - 1] - frames[n] @ shape.in_child[n - 1]
        return origin[self._segment] + np.einsum("sij,sj->si", frames[self._segment], shape.centre), joint

    def changed(self, shape: Shape, placed: Mapping[str, tuple[Floats, Floats]] | None = None) -> Manikin:
        """The same body with another shape; placed: its spheres and joints by posture where they are known already."""
        other = object.__new__(Manikin)
        other.body, other.shape, other._segment, other._frames = self.body, shape, self._segment, self._frames
        other._found = self._found
        other.placed = dict(placed) if placed else {n: other._place(f) for n, f in self._frames.items()}
        return other

    def lowest(self) -> float:
        """Height [m] of the lowest surface, standing, over the stage."""
        return float((self.placed["standing"][0][:, 2] - self.shape.radius).min())

    def overlaps(self) -> Floats:
        """(N, N) greatest depth [m] two segments overlap by, standing or sitting; negative where they are apart."""
        count = len(self.body.segments)
        filled = np.flatnonzero(np.diff(self.body.start) > 0)
        first = self.body.start[filled]
        deepest = np.full((count, count), -np.inf)
        radius = self.shape.radius
        for posture in ("standing", "sitting"):
            centres = self.placed[posture][0]
            square = np.sum(centres**2, axis=1)
            apart = np.sqrt(np.maximum(square[:, None] + square[None, :] - 2.0 * centres @ centres.T, 0.0))
            depth = radius[:, None] + radius[None, :] - apart
            rows = np.maximum.reduceat(np.maximum.reduceat(depth, first, axis=0), first, axis=1)
            at = np.ix_(filled, filled)
            deepest[at] = np.maximum(deepest[at], rows)
        return deepest

    def value(self, length: Length) -> float:
        """A length [m]; with extreme spheres chosen on another shape, linear in this one's."""
        total = 0.0
        for sign, reach in length.terms:
            centres, joints = self.placed[reach.posture]
            point = joints[reach.joint] if reach.joint >= 0 else centres[reach.sphere]
            total += sign * float(np.dot(reach.direction, point))
            if reach.sphere >= 0 and reach.surface:
                total += sign * float(self.shape.radius[reach.sphere])
        return total

    def farthest(self, posture: str, direction: Floats, where: Iterable[str]) -> Length:
        """The farthest surface along a direction among segments ("LF") or subparts ("LF/heel")."""
        rows = self._rows(where)
        reach = self.placed[posture][0][rows] @ direction + self.shape.radius[rows]
        best = int(rows[int(np.argmax(reach))])
        return Length(((1.0, Reach(posture, _tuple(direction), sphere=best)),))

    def band(
        self, posture: str, direction: Floats, level: tuple[Length, float, Iterable[str]], *, along: Floats = UP
    ) -> Length:
        """The farthest surface along a direction, of spheres near a level: (level along `along`, half width [m],
        segments or subparts)."""
        height, half, where = level
        rows = self._rows(where)
        near = np.abs(self.placed[posture][0][rows] @ along - self.value(height)) <= half
        if not near.any():
            raise InputError(f"body {self.body.name} has no spheres within {1000 * half:.0f} mm of that level")
        reach = self.placed[posture][0][rows] @ direction + self.shape.radius[rows]
        best = int(rows[int(np.argmax(np.where(near, reach, -np.inf)))])
        return Length(((1.0, Reach(posture, _tuple(direction), sphere=best)),))

    def middle(self, posture: str, direction: Floats, subpart: str) -> Length:
        """The centre of a named sphere along a direction."""
        row = int(self._rows([subpart])[0])
        return Length(((1.0, Reach(posture, _tuple(direction), sphere=row, surface=False)),))

    def joint(self, posture: str, direction: Floats, name: str) -> Length:
        """A joint along a direction."""
        return Length(((1.0, Reach(posture, _tuple(direction), joint=self.body.joint(name))),))

    def _rows(self, where: Iterable[str]) -> Ints:
        """The spheres of segments ("LF") or subparts ("LF/heel"); looked up once for all shapes of the body."""
        key = tuple(where)
        if key not in self._found:
            self._found[key] = np.array([row for name in key for row in self._named(name)])
        return self._found[key]

    def _named(self, name: str) -> list[int]:
        segment, _, subpart = name.partition("/")
        rows = range(*self.body.spheres(self.body.segment(segment)).indices(len(self._segment)))
        named = [row for row in rows if not subpart or self.body.sphere_names[row] == subpart]
        if not named:
            raise InputError(f"body {self.body.name}: segment {segment} has no sphere named {subpart!r}")
        return named


def _frames(body: Body, angles: Mapping[str, Mapping[str, float]]) -> Floats:
    """(N, 3, 3) world from segment rotations in a posture, the stage unturned."""
    rotations = pose(body, angles).rotations[0]
    frames = np.zeros((len(body.segments), 3, 3))
    frames[0] = np.eye(3)
    for n in range(1, len(body.segments)):
        turn = rotate(np.broadcast_to(rotations[n - 1], (3, 4)), np.eye(3)).T
        frames[n] = frames[int(body.parent[n])] @ turn
    return frames


def _tuple(direction: Floats) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in direction)
    return x, y, z
