"""Draw hands on controls as hands hold them: with the fingers closed on the parts of the control.

Nobody's posture or result depends on it. A hand is closed where the point of it that arrives, by the
control's grip, is at the control. It gets the spheres of the hand of the survey at the person's own
size, hung on the person's wrist so that its grip point is in the same direction from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from workbench.body.hands import Gap, Hand, close_hand, grasp
from workbench.body.scaling.measure import measure
from workbench.errors import InputError
from workbench.geometry.nearest import Solid, build_solid, mesh_distance
from workbench.model.arrays import Floats
from workbench.model.body import DIRECTIONS, Body
from workbench.model.environment import Control, Environment
from workbench.model.poses import Placed
from workbench.model.quaternions import cross, matrices, shortest
from workbench.posture.reaching.limbs import HANDS, Limb, limb

__all__ = ["DrawnHand", "closed_hands"]

AT = 0.015
"""A hand is at a control if it is nearer than this [m]: postures that are written by eye are as near."""
NEAR = 0.4
"""What of a control is farther from its point than this [m] along an axis is out of a hand's reach."""
_GRASPS = {"push": "fingertip_push", "pinch": "tip_pinch", "grasp": "power"}
"""The grasp of each grip of a control."""
_TILTS = np.radians(np.arange(0.0, 41.0, 2.0))
"""[rad] How far a palm is tilted back about the wrist until it is out of what it holds."""


@dataclass(frozen=True, eq=False)
class DrawnHand:
    """Spheres (S, 3), (S,) [m] in the world in the place of those of a segment."""

    segment: int
    centre: Floats
    radius: Floats


@lru_cache(maxsize=64)
def closed_hands(
    placed: Placed, pose: int, environment: Environment | None
) -> tuple[DrawnHand, ...]:
    """Close the hands of a body that are at controls.

    Parameters
    ----------
    placed, pose
        The body, and which of its poses.
    environment
        Its surroundings with their controls; None where there are none.

    Returns
    -------
    tuple
        A hand for each that holds something; none of a body without the landmarks of a hand.
    """
    if environment is None or not environment.controls:
        return ()
    body = placed.body[int(placed.person[pose])]
    found = []
    for name in HANDS:
        for control in environment.controls:
            if control.own_parts and not control.for_feet and body.has(f"{name[0].upper()}HN"):
                drawn = _closed(body, placed.world_from_segment[pose], environment, name, control)
                if drawn is not None:
                    found.append(drawn)
                    break
    return tuple(found)


def _closed(
    body: Body, world: Floats, environment: Environment, name: str, control: Control
) -> DrawnHand | None:
    """A hand closed on a control, None where it is not at it."""
    try:
        arm = limb(body, name, grip=control.grip)
        if np.linalg.norm(world[arm.end] @ np.append(arm.tip[0], 1.0) - control.at) > AT:
            return None
        size = measure(body, ["hand_length", "hand_breadth"])
    except InputError:  # a body without a landmark is drawn as it is
        return None
    hand = Hand(size["hand_length"], size["hand_breadth"], side=name.split()[0])
    chosen = grasp(_GRASPS[control.grip])
    place = _place(body, arm, hand.grip_point(chosen))
    place = world[arm.end, :, :3] @ place + np.c_[np.zeros((3, 3)), world[arm.end, :, 3]]
    surfaces = _surfaces(environment, control)
    place = _tilted(hand, chosen.begin, place, surfaces)
    closed = close_hand(hand, chosen, _gap(surfaces, place))
    return DrawnHand(arm.end, _in_world(place, closed.centres), hand.radius)


def _place(body: Body, arm: Limb, grip_point: Floats) -> Floats:
    """(3, 4) the hand's axes in those of its segment: its grip point and the body's own in the same
    direction from the wrist, at the same distance."""
    ahead, back = (body.directions[arm.end, DIRECTIONS.index(way)] for way in ("top", "back"))
    axes = np.column_stack([ahead, cross(back, ahead), back])
    wrist = body.joint_in_child[0, arm.end - 1]
    own = arm.tip[0] - wrist
    given = axes @ grip_point
    ways = given / np.linalg.norm(given), own / np.linalg.norm(own)
    turn = matrices(shortest(*ways)) @ axes
    return np.column_stack([turn, wrist + own - turn @ grip_point])


def _tilted(
    hand: Hand, angles: Floats, place: Floats, surfaces: Sequence[tuple[Solid, bool]]
) -> Floats:
    """(3, 4) the hand tilted back about its wrist until the palm is out of the parts, or as little
    in them as may be: reaches let it be in them as deep as flesh gives way."""
    cosine, sine = np.cos(_TILTS), np.sin(_TILTS)
    turns = np.tile(np.eye(3), (len(_TILTS), 1, 1))
    turns[:, 0, 0] = turns[:, 2, 2] = cosine
    turns[:, 2, 0], turns[:, 0, 2] = sine, -sine
    palm = np.einsum("tij,sj->tsi", turns, hand.centres(angles)[40:])
    away = _gap(surfaces, place)(palm.reshape(-1, 3)).reshape(palm.shape[:2])
    room = (away - hand.radius[40:]).min(axis=1)
    best = int(np.argmax(np.minimum(room, 0.0)))
    return np.column_stack([place[:, :3] @ turns[best], place[:, 3]])


def _surfaces(environment: Environment, control: Control) -> list[tuple[Solid, bool]]:
    """The own parts of a control, as far as they are near it, and which of them are solid: an index
    of all parts would be made anew for each person whose seat stands elsewhere."""
    found = []
    for part in map(environment.part_index, control.own_parts):
        corners = environment.triangle_corners(part)
        away = np.maximum(corners.min(axis=1) - control.at, control.at - corners.max(axis=1))
        near = corners[away.max(axis=1) < NEAR].reshape(-1, 3)
        if len(near):
            vertices, faces = np.unique(near, axis=0, return_inverse=True)
            solid = build_solid(vertices, faces.reshape(-1, 3))
            found.append((solid, bool(environment.solid[part])))
    return found


def _gap(surfaces: Sequence[tuple[Solid, bool]], place: Floats) -> Gap:
    """Signed distances of points in a hand's axes to some surfaces."""

    def gap(points: Floats) -> Floats:
        at = np.ascontiguousarray(_in_world(place, points))
        least = np.full(len(at), np.inf)
        for surface, solid in surfaces:
            away = np.empty(len(at))
            mesh_distance(at, surface, away, np.empty(len(at), dtype=np.int64), np.empty_like(at))
            least = np.minimum(least, away if solid else np.abs(away))
        return least

    return gap


def _in_world(place: Floats, points: Floats) -> Floats:
    found: Floats = points @ place[:, :3].T + place[:, 3]
    return found
