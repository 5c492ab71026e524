"""Many drivers at one wheel: the driving posture of each, as the seated people of an accommodation study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from workbench.errors import UsageError
from workbench.model.body import Body
from workbench.model.driving import Driver, Package
from workbench.model.environment import Seat
from workbench.model.poses import Poses
from workbench.model.posing import join_poses
from workbench.solve.driving import DrivingPosture, driving_posture
from workbench.solve.seat_people import SeatedPeople

__all__ = ["seat_drivers"]


def seat_drivers(
    bodies: Sequence[Body],
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
    """Seat B drivers, one row of poses a body, each as `driving_posture` has it; B numbers, by which the angles of each
    are drawn where there is a seed. UsageError where their numbers differ.

    A foot's miss is that of its pedal; where the travel ends before the seat is where the driver wants it, the feet
    still go to their pedals, and `spare_travel` is negative by what is lacking.
    """
    count = len(bodies)
    numbers = numbers or range(count)
    if not len(poses) == len(drivers) == len(numbers) == count:
        got = f"{len(poses)}, {len(drivers)} and {len(numbers)}"
        raise UsageError(f"{count} bodies need as many poses, drivers and numbers, got {got}")
    place = poses.world_from_reference
    alone = [Poses(poses.rotations[b : b + 1], poses.reference, place[b : b + 1]) for b in range(count)]
    rows = [
        driving_posture(
            body, alone[b], seat, driver=drivers[b], package=package, feet=feet, eye=eye, seed=seed, person=numbers[b]
        )
        for b, body in enumerate(bodies)
    ]
    return _people(rows, seat, eye)


def _people(rows: list[DrivingPosture], seat: Seat, eye: float | None) -> SeatedPeople:
    """Drivers, a row each, as seated people."""
    count, feet = len(rows), list(rows[0].miss)
    forward, wanted, up = (np.array([getattr(row, name) for row in rows]) for name in ("forward", "wanted", "up"))
    eyes = np.array([row.eye for row in rows])
    (rear, front), (low, high) = seat.travel_forward, seat.travel_up
    return SeatedPeople(
        poses=join_poses([row.poses for row in rows]),
        forward=forward,
        up=up,
        shift=np.stack([forward, np.zeros(count), up], axis=1),
        eye=eyes,
        eye_off=eyes[:, 2] - eye if eye is not None else np.zeros(count),
        miss={foot: np.array([row.miss[foot] for row in rows]) for foot in feet},
        limit={foot: tuple(row.limit[foot] for row in rows) for foot in feet},
        spare_travel=np.stack([wanted - rear, front - wanted, up - low, high - up], axis=1),
        discomfort=np.zeros(count),
        tried=np.ones(count, dtype=np.int64),
    )
