"""Thighs on the front of a cushion: how deep they press in, by a section through the seat."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from workbench.body.forward import place
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.environment import Seat
from workbench.model.poses import Poses
from workbench.posture.seating.seating import seat_planes

__all__ = ["FrontFaces", "front_faces", "pressed_thighs", "thighs_of"]

_THIGHS = {"left foot": "LUL", "right foot": "RUL"}


@dataclass(frozen=True, eq=False)
class FrontFaces:
    """The front of a cushion in the world, with the seat at rest."""

    normal: Floats
    """(F, 3) outward unit normals; no rows where thighs hang as they will."""
    offset: Floats
    """(F,) [m] heights of the faces along them."""
    gives: float
    """How deep [m] thighs may press in."""


def front_faces(seat: Seat) -> FrontFaces:
    """Return the faces of the front of a seat's cushion in the world."""
    front = seat.front
    if front is None:
        return FrontFaces(np.zeros((0, 3)), np.zeros(0), 0.0)
    cushion, _, left = seat_planes(seat)
    along, above, offset = np.array(front.faces).T
    normal = np.outer(along, np.cross(left, cushion)) + np.outer(above, cushion)
    return FrontFaces(normal, offset + normal @ np.array(seat.srp), front.gives)


def thighs_of(body: Body, feet: Collection[str]) -> tuple[int, ...]:
    """Segments of a body that are the thighs of some of its feet and have spheres."""
    names = [name for foot, name in _THIGHS.items() if foot in feet and name in body.segments]
    known = [body.segment(name) for name in names]
    return tuple(n for n in known if body.start[n + 1] > body.start[n])


def pressed_thighs(
    body: Body, poses: Poses, seat: Seat, shift: Floats, feet: Collection[str]
) -> Floats:
    """Measure how much deeper thighs press into the front of a cushion than it gives.

    The greatest depth counts: of a sphere in the convex section of the cushion, which goes on to
    both sides. It is 0 where the cushion gives way far enough, or has no front.

    Parameters
    ----------
    body, poses
        B poses of the rows of a body, in their order.
    seat
        The seat.
    shift
        (B, 3) [m] displacement of the seat.
    feet
        "left foot" and "right foot", as far as they are on pedals: a leg that is not hangs as its
        posture has it.

    Returns
    -------
    Floats
        (B,) [m] depth beyond what is given.
    """
    faces = front_faces(seat)
    thighs = thighs_of(body, feet)
    if not (len(faces.normal) and thighs):
        return np.zeros(len(poses))
    placed = place(body, poses, window=[body.segments[n] for n in thighs])
    sphere = np.flatnonzero(np.isin(body.sphere_segment, thighs))
    centre = placed.centres[:, sphere] - shift[:, None]
    outside = (centre @ faces.normal.T - faces.offset).max(axis=2)
    depth = (body.radius[:, sphere] - outside).max(axis=1)
    beyond: Floats = np.maximum(depth - faces.gives, 0.0)
    return beyond
