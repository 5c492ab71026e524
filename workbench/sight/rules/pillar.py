"""Angle that an A-pillar hides from both of a driver's eyes, by the UN R125 family.

Two level cuts of the pillar are seen from two eyes that turn with the head:

1. A plane that rises 2 degrees ahead of Pm meets the pillar; the level cut at the foremost point of
   that is S1. A plane that falls 5 degrees gives S2.
2. The eyes, p_to_e from the P point of their side and e_apart from one another, turn about it until
   the line from the outer eye that touches the outer edge of S2 is square to the line of the eyes.
3. The angle is between the line from the inner eye that touches the inner edge of S1, and the
   parallel through it to the first line; 0 where that edge is not inside of the parallel.

A line square to the eyes through the outer one passes the P point at half of e_apart, c. It touches
a point at distance r and bearing b from P where the head is turned by b - asin(c / r). The outer edge
is the point of S2 that asks for the largest turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError
from workbench.geometry.clipping import plane_intersections
from workbench.model.arrays import Floats
from workbench.model.rule_set import RuleSet
from workbench.sight.rules.eye_points import SIGN, EyePoints, Side

__all__ = ["PillarAngle", "pillar_angle"]

_ON_LEVEL = 1e-9
"""[m] from a level cut within which a corner is on it."""


@dataclass(frozen=True, eq=False)
class PillarAngle:
    """What a pillar hides from both eyes.

    Parameters
    ----------
    angle
        [rad] hidden, 0 where the pillar is narrower than the eyes are apart.
    of_upper, of_lower
        [rad] what each cut, S1 and S2, would hide by itself. The rule's angle of a pillar that
        leans back is smaller: higher up its inner edge is farther outward.
    turn
        [rad] of the head to the left.
    eyes
        (2, 3) [m] the outer and the inner eye after the turn: E1 and E2 of the driver's side, E4 and
        E3 of the passenger's.
    outer, inner
        (3,) [m] the edges that are touched, of S2 and of S1.
    status
        How sure the rule's numbers are.
    """

    angle: float
    of_upper: float
    of_lower: float
    turn: float
    eyes: Floats
    outer: Floats
    inner: Floats
    status: str


def pillar_angle(corners: Floats, points: EyePoints, rules: RuleSet, *, side: Side) -> PillarAngle:
    """Find the angle that a pillar hides from both eyes.

    Parameters
    ----------
    corners
        (T, 3, 3) [m] the triangles of the pillar with its trim and seals; what they hold behind Pm
        or on the other side of it does not count.
    points
        Of `car_eye_points`: P1 is of the driver's side, P2 of the passenger's.
    side
        Of the pillar.

    Raises
    ------
    InputError
        If a plane from Pm does not meet the pillar ahead on this side, or it is nearer to P than
        half the distance of the eyes.
    """
    mirror = np.array([1.0, SIGN[side], 1.0])  # a pillar on the right is one on the left, mirrored
    pivot = mirror * points["p1" if side == points.driver else "p2"]
    pm = mirror * points["pm"]
    s1 = _level_cut(mirror * corners, pm, rules.number("s1_rise"), side)
    s2 = _level_cut(mirror * corners, pm, -rules.number("s2_fall"), side)
    half = 0.5 * rules.number("e_apart")
    nearest = float(np.linalg.norm((np.concatenate([s1, s2]) - pivot)[:, :2], axis=1).min())
    if nearest <= half:
        raise InputError(
            f"the pillar on the {side} is {1e3 * nearest:.0f} mm from the P point; "
            f"farther than {1e3 * half:g} mm is needed, where the eyes are"
        )
    ahead = float(np.sqrt(rules.number("p_to_e") ** 2 - half**2))
    angle, turn, eyes, edges = _between(s2, s1, pivot, half=half, ahead=ahead)
    return PillarAngle(
        angle=angle,
        of_upper=_between(s1, s1, pivot, half=half, ahead=ahead)[0],
        of_lower=_between(s2, s2, pivot, half=half, ahead=ahead)[0],
        turn=SIGN[side] * turn,
        eyes=mirror * eyes,
        outer=mirror * edges[0],
        inner=mirror * edges[1],
        status=f"{points.status}; {rules.status('p_to_e', 'e_apart', 's1_rise', 's2_fall')}",
    )


class _Turned(NamedTuple):
    """The angle [rad] hidden, the turn [rad] of the head, eyes (2, 3) and edges (2, 3) [m], the
    outer before the inner."""

    angle: float
    turn: float
    eyes: Floats
    edges: Floats


def _between(outer: Floats, inner: Floats, pivot: Floats, *, half: float, ahead: float) -> _Turned:
    """Turn the eyes to the outer edge of one cut (K, 3) on the left and touch the inner edge of
    another. half, ahead [m]: of the eyes aside from their middle, and of that from the pivot."""
    away = (outer - pivot)[:, :2]
    turns = np.arctan2(away[:, 1], away[:, 0]) - np.arcsin(half / np.linalg.norm(away, axis=1))
    turn = float(turns.max())
    forward = np.array([np.cos(turn), np.sin(turn), 0.0])
    left = np.array([-np.sin(turn), np.cos(turn), 0.0])
    eyes = pivot + ahead * forward + half * np.stack([left, -left])
    bearing = np.arctan2((inner - eyes[1]) @ left, (inner - eyes[1]) @ forward)
    edges = np.stack([outer[np.argmax(turns)], inner[np.argmin(bearing)]])
    return _Turned(max(0.0, -float(bearing.min())), turn, eyes, edges)


def _level_cut(corners: Floats, pm: Floats, rise: float, side: Side) -> Floats:
    """(K, 3) [m] the corners of the level cut where a plane from Pm first meets a pillar on the
    left."""
    met = _crossing(corners, np.array([-np.sin(rise), 0.0, np.cos(rise)]), pm)
    met = met[(met[:, 0] > pm[0]) & (met[:, 1] > pm[1])]
    if not len(met):
        raise InputError(
            f"the plane from Pm, {abs(np.degrees(rise)):g} degrees {'up' if rise > 0 else 'down'}, "
            f"meets nothing of the pillar ahead on the {side}"
        )
    level = met[np.argmax(met[:, 0])]
    cut = _crossing(corners, np.array([0.0, 0.0, 1.0]), level)
    return cut[(cut[:, 0] > pm[0]) & (cut[:, 1] > pm[1])]


def _crossing(corners: Floats, normal: Floats, point: Floats) -> Floats:
    """(K, 3) [m] where a plane through a point crosses the edges of triangles, and the corners that
    lie on it."""
    lines, _ = plane_intersections(corners, normal, float(normal @ point))
    vertices = corners.reshape(-1, 3)
    on_plane = np.abs((vertices - point) @ normal) <= _ON_LEVEL
    return np.concatenate([lines.reshape(-1, 3), vertices[on_plane]])
