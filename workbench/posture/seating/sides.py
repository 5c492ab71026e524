"""Left and right of whoever takes a workplace."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.workplace import Workplace
from workbench.posture.seating.seating import seat_planes

__all__ = ["leftward", "middle"]


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
    left: Floats = side / np.linalg.norm(side)
    return left
