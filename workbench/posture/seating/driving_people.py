"""Many drivers at one wheel: the driving posture of each, as the seated people of an accommodation
study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench.errors import UsageError
from workbench.model.body import Body
from workbench.model.driving import Driver, Package
from workbench.model.environment import Seat
from workbench.model.poses import Poses
from workbench.model.posing import join_poses
from workbench.posture.seating.driving import Drivers, DrivingCase, at_wheel
from workbench.posture.seating.seat_people import SeatedPeople

__all__ = ["seat_drivers"]

MOST_PEOPLE = 256


def seat_drivers(
    body: Body,
    poses: Poses,
    seat: Seat,
    *,
    drivers: Sequence[Driver],
    package: Package,
    feet: Mapping[str, tuple[float, float, float]],
    eye: float | None = None,
    seed: int | None = None,
    numbers: Sequence[int] = (),
) -> SeatedPeople:
    """Seat B drivers, one row of poses a body, each as `driving_posture` has it; B numbers, by
    which the angles of each are drawn where there is a seed. UsageError where their numbers differ.

    A foot's miss is that of its pedal; where the travel ends before the seat is where the driver
    wants it, the feet still go to their pedals, and `spare_travel` is negative by what is lacking.
    """
    count = len(body)
    numbers = numbers or range(count)
    if not len(poses) == len(drivers) == len(numbers) == count:
        got = f"{len(poses)}, {len(drivers)} and {len(numbers)}"
        raise UsageError(f"{count} bodies need as many poses, drivers and numbers, got {got}")
    case = DrivingCase(seat, package, feet, eye, seed)
    found = []
    for first in range(0, count, MOST_PEOPLE):
        some = slice(first, first + MOST_PEOPLE)
        own = Poses(poses.rotations[some], poses.reference, poses.world_from_reference[some])
        found.append(at_wheel(body[some], own, case, drivers=drivers[some], numbers=numbers[some]))
    return _people(found, seat, eye)


def _people(found: list[Drivers], seat: Seat, eye: float | None) -> SeatedPeople:
    """Drivers as seated people."""
    forward, up, wanted = np.concatenate([part.travel for part in found]).T
    eyes = np.concatenate([part.eye for part in found])
    count = len(forward)
    feet = list(found[0].miss)
    (rear, front), (low, high) = seat.travel_forward, seat.travel_up
    return SeatedPeople(
        poses=join_poses([part.poses for part in found]),
        forward=forward,
        up=up,
        shift=np.stack([forward, np.zeros(count), up], axis=1),
        eye=eyes,
        eye_off=eyes[:, 2] - eye if eye is not None else np.zeros(count),
        miss={foot: np.concatenate([part.miss[foot] for part in found]) for foot in feet},
        limit={foot: tuple(words for part in found for words in part.limit[foot]) for foot in feet},
        spare_travel=np.stack([wanted - rear, front - wanted, up - low, high - up], axis=1),
        discomfort=np.zeros(count),
        tried=np.ones(count, dtype=np.int64),
    )
