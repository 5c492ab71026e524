"""The planes of a seat, and the attitude of who sits in it.

A body rests on cushion and back with the stated depth, on the seat's centre line. The pelvis leans
with the seat's back. The translation solves three plane equations at once: the lowest sphere toward
the cushion, the rearmost toward the back, the reference segment on the centre line.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.environment import Environment, Seat
from workbench.model.joint_angles import attitude_matrix
from workbench.model.surroundings import moved_along
from workbench.model.workplace import Workplace
from workbench.posture.reaching.reach_solver import apply, on_grid

__all__ = [
    "SeatAxes",
    "leftward",
    "middle",
    "own_axes",
    "seat_at",
    "seat_attitude",
    "seat_planes",
    "seat_shift",
]


@dataclass(frozen=True, eq=False)
class SeatAxes:
    """Axes at the reference point of a seat, x along its heading, z up. Points in them are rounded to
    a nanometre, so that the last digits choose no place.

    seat: the seat as it is in them; world (3, 4) [m]: the transform from these axes to the world.
    """

    seat: Seat
    world: Floats

    def point(self, at: tuple[float, float, float]) -> tuple[float, float, float]:
        """A point of the world [m] in these axes."""
        own = self.world[:, :3].T @ (np.array(at) - self.world[:, 3])
        x, y, z = on_grid(own).tolist()
        return x, y, z

    def height(self, z: float) -> float:
        """A height in the world [m] in these axes."""
        return float(on_grid(np.array(z - self.world[2, 3])))

    def back(self, points: Floats) -> Floats:
        """Points (B, 3) [m] in these axes as they are in the world."""
        return apply(self.world[None, :, :3], points) + self.world[:, 3]


def own_axes(seat: Seat) -> SeatAxes:
    """The axes of a seat in its reference position."""
    world = np.column_stack([attitude_matrix(yaw=seat.yaw), seat.srp])
    return SeatAxes(replace(seat, srp=(0.0, 0.0, 0.0), yaw=0.0), world)


def seat_planes(seat: Seat) -> tuple[Floats, Floats, Floats]:
    """Unit normals (3,) of cushion (up), back (forward) and centre plane (left) of a seat, all
    through its SRP."""
    heading = attitude_matrix(yaw=seat.yaw)
    cushion = np.array([-np.sin(seat.cushion_angle), 0.0, np.cos(seat.cushion_angle)])
    back = np.array([np.cos(seat.back_angle), 0.0, np.sin(seat.back_angle)])
    return heading @ cushion, heading @ back, heading @ np.array([0.0, 1.0, 0.0])


def seat_attitude(seat: Seat) -> Floats:
    """(3, 3) attitude of the reference segment of a sitter: the seat's heading, leaning with the
    seat back."""
    return attitude_matrix(yaw=seat.yaw, pitch=-seat.back_angle)


def seat_shift(seat: Seat | None, forward: float, up: float) -> Floats:
    """(3,) [m] how far a seat stands from its reference position: horizontally ahead, and up; 0 of none."""
    if seat is None:
        return np.zeros(3)
    centre = seat_planes(seat)[2]
    return forward * np.array([centre[1], -centre[0], 0.0]) + np.array([0.0, 0.0, up])


def seat_at(environment: Environment, name: str, forward: float, up: float) -> Environment:
    """Move what goes with a seat so far [m] ahead and up of where it stands at rest."""
    seat = environment.seat(name)
    return moved_along(environment, seat.moves, seat_shift(seat, forward, up))


def middle(place: Workplace) -> Floats:
    """(3,) [m] a point in the middle between left and right of whoever takes a workplace."""
    if place.own_seat is not None:
        return np.array(place.own_seat.srp)
    if place.stand is not None:
        return np.array(place.stand.on)
    return np.array(place.cases[0].pose.world_from_reference[0, :, 3])


def leftward(place: Workplace) -> Floats:
    """(3,) the horizontal unit vector to the left of whoever takes a workplace."""
    if place.own_seat is not None:
        return seat_planes(place.own_seat)[2]
    side = place.cases[0].pose.world_from_reference[0, :, 1] * np.array([1.0, 1.0, 0.0])
    return side / np.linalg.norm(side)
