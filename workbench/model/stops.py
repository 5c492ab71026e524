"""Joint stops as arrays: how far each joint may turn, by motion name."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from workbench.model.arguments import short_repr
from workbench.model.arrays import Bools, Floats, Ints, read_only
from workbench.model.units import plain

__all__ = ["Coupling", "StopKind", "Stops", "motion_words"]

LOCKED = 1e-6
"""[rad] An axis whose limits are both less is locked."""
_GERUNDS = {"bend": "bending", "turn": "turning"}


def motion_words(motion: str) -> str:
    """The name of a motion in a sentence: "medial rotation", "bending left" of "bend_left"."""
    first, _, rest = motion.partition("_")
    return plain(f"{_GERUNDS.get(first, first)} {rest}".strip())


class StopKind(IntEnum):
    """How a joint is limited.

    FREE not at all; CONE a swing cone with four half-angles and two twist limits; HINGE one axis,
    with play on the others; POLYGON a spherical polygon for the direction of the limb, with twist
    limits.
    """

    FREE = 0
    CONE = 1
    HINGE = 2
    POLYGON = 3


@dataclass(frozen=True)
class Coupling:
    """A limit that depends on another motion, linear between two driver angles and constant beyond
    them.

    The limit of motion `side` (0 first name, 1 second name) of `axis` (0, 1 swing, 2 twist) of
    `joint` becomes `limit[0]` where the driver motion stands at `driver_angle[0]`, `limit[1]` at
    `driver_angle[1]`; all [rad].
    """

    joint: int
    axis: int
    side: int
    driver_joint: int
    driver_axis: int
    driver_angle: tuple[float, float]
    limit: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Stops:
    """The stops of J joints.

    kind (J,); axes (J, 3, 3): unit axes of swing 1, swing 2 and twist, rows, in the frame both
    segments share in the zero pose; limits (J, 3, 2) [rad]: how far along the first and the second
    motion of each axis, both positive; play (J,) [rad]: how far the other axes of a hinge may
    stray; motions: for each joint three pairs of names; polygon: for each joint the (V, 3) unit
    vertices of its spherical polygon, counter-clockwise seen from outside about `polygon_centre`
    (J, 3), or an empty array; polygon_frame (J,): the segment in whose frame they stand; limb (J,
    3): the direction of the limb in the zero pose that the polygon holds for.
    """

    kind: Ints
    axes: Floats
    limits: Floats
    play: Floats
    motions: tuple[tuple[tuple[str, str], ...], ...]
    couplings: tuple[Coupling, ...]
    polygon: tuple[Floats, ...]
    polygon_centre: Floats
    polygon_frame: Ints
    limb: Floats

    __repr__ = short_repr

    def __post_init__(self) -> None:
        joints = len(self.motions)
        put = object.__setattr__
        put(self, "kind", read_only(self.kind, np.int64, (joints,), "stops.kind"))
        put(self, "axes", read_only(self.axes, np.float64, (joints, 3, 3), "stops.axes"))
        put(self, "limits", read_only(self.limits, np.float64, (joints, 3, 2), "stops.limits"))
        put(self, "play", read_only(self.play, np.float64, (joints,), "stops.play"))
        put(
            self,
            "polygon",
            tuple(read_only(p, np.float64, (None, 3), "stops.polygon") for p in self.polygon),
        )
        put(
            self,
            "polygon_centre",
            read_only(self.polygon_centre, np.float64, (joints, 3), "stops.polygon_centre"),
        )
        put(
            self,
            "polygon_frame",
            read_only(self.polygon_frame, np.int64, (joints,), "stops.polygon_frame"),
        )
        put(self, "limb", read_only(self.limb, np.float64, (joints, 3), "stops.limb"))

    @property
    def locked(self) -> Bools:
        """(J, 3) the axes about which a joint that has stops does not turn."""
        limited = self.kind != StopKind.FREE
        return np.asarray(limited[:, None] & (self.limits.max(axis=2) < LOCKED), dtype=np.bool_)
