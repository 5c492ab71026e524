"""The planes of a seat, and the attitude of who sits in it.

A body rests on cushion and back with the stated depth, on the seat's centre line. The pelvis leans
with the seat's back. The translation solves three plane equations at once: the lowest sphere toward
the cushion, the rearmost toward the back, the reference segment on the centre line.
"""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.environment import Seat
from workbench.model.posing import attitude_matrix

__all__ = ["seat_attitude", "seat_planes", "seat_shift"]


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


def seat_shift(seat: Seat, forward: float, up: float) -> Floats:
    """(3,) [m] how far a seat stands from its reference position: horizontally ahead, and up."""
    centre = seat_planes(seat)[2]
    shift: Floats = forward * np.array([centre[1], -centre[0], 0.0]) + np.array([0.0, 0.0, up])
    return shift
