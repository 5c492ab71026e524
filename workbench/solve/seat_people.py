"""Many people into one seat: for each body the seat position and posture that `seat_posture` finds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.errors import UsageError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.environment import Seat
from workbench.model.poses import Poses
from workbench.model.posing import join_poses
from workbench.solve.posture import Pedals, seat_posture
from workbench.solve.seating import seat_planes

__all__ = ["SeatedPeople", "seat_people"]


@dataclass(frozen=True, eq=False)
class SeatedPeople:
    """B seated people, a row each: poses in the world (B rows, for each its own body), the seat's `forward` and `up`
    (B,) [m] from where it stands at rest, and shift (B, 3) [m], the same as a vector for the parts that go along.

    eye (B, 3) [m]: midway between the eyes; eye_off (B,) [m]: how much it stays above (+) or below (-) the height
    asked for, 0 where none is. miss (B,) [m] and limit of each foot: how far it stays from its pedal, and what limits
    it in words ("" where nothing does). spare_travel (B, 4) [m]: what is left of the seat's travel to the rear, to the
    front, down and up. discomfort (B,): of both legs.
    """

    poses: Poses
    forward: Floats
    up: Floats
    shift: Floats
    eye: Floats
    eye_off: Floats
    miss: Mapping[str, Floats]
    limit: Mapping[str, tuple[str, ...]]
    spare_travel: Floats
    discomfort: Floats

    def __len__(self) -> int:
        return len(self.forward)


def seat_people(
    bodies: Sequence[Body], poses: Poses, seat: Seat, *, eye: float | None, pedals: Pedals, threads: int | None = None
) -> SeatedPeople:
    """Seat B bodies of a family, one row of poses a body, each where view and pedals are had (see `seat_posture`).

    eye: the height [m] that the eyes are to reach, any where None. pedals: where the balls of the feet go, and the
    floor the heels stand on. threads: all cores where None; the answer does not depend on it. UsageError where there
    are not as many poses as bodies.
    """
    if len(poses) != len(bodies):
        raise UsageError(f"{len(bodies)} bodies need as many poses, got {len(poses)}")
    place = poses.world_from_reference
    own = [Poses(poses.rotations[b : b + 1], poses.reference, place[b : b + 1]) for b in range(len(bodies))]
    rows = [seat_posture(body, pose, seat, eye=eye, pedals=pedals) for body, pose in zip(bodies, own, strict=True)]
    forward, up, eyes, discomfort = (
        np.concatenate([getattr(row, name) for row in rows]) for name in ("forward", "up", "eye", "discomfort")
    )
    (rear, front), (low, high) = seat.travel_forward, seat.travel_up
    centre = seat_planes(seat)[2]
    return SeatedPeople(
        poses=join_poses([row.poses for row in rows]),
        forward=forward,
        up=up,
        shift=np.outer(forward, [centre[1], -centre[0], 0.0]) + np.outer(up, [0.0, 0.0, 1.0]),
        eye=eyes,
        eye_off=eyes[:, 2] - eye if eye is not None else np.zeros(len(rows)),
        miss={foot: np.concatenate([row.miss[foot] for row in rows]) for foot in pedals.at},
        limit={foot: tuple(row.limit[foot][0] for row in rows) for foot in pedals.at},
        spare_travel=np.stack([forward - rear, front - forward, up - low, high - up], axis=1),
        discomfort=discomfort,
    )
