"""Driving: who drives, what a driver's posture is predicted for, and the side-view angles it is
told in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arguments import check_fields, short_repr
from workbench.model.arrays import Floats, read_only

__all__ = ["ANGLES", "Driver", "DrivingAims", "DrivingAngles", "Package"]

ANGLES = ("hip to eye", "head", "neck", "thorax", "abdomen", "pelvis", "thigh", "knee")
"""The side-view angles of a driving posture, in the order of every array of them. From vertical,
aft positive: from the middle of the hips to the middle of the eyes, from the seventh neck vertebra
to the ear (neck), from the twelfth chest vertebra to the seventh neck vertebra (thorax), from the
sacrum to the twelfth chest vertebra (abdomen), from the hips to the sacrum (pelvis). Above the
horizontal: from ear to eye (head), from hip to knee (thigh). Knee: included."""

ADULT = (16.0, 100.0)


@dataclass(frozen=True)
class Driver:
    """Who drives: sex, stature and sitting height [m], body mass index [kg/m^2], age [years].

    InputError for a sex that is neither male nor female and for anybody but an adult.
    """

    sex: str
    stature: float
    sitting_height: float
    mass_index: float
    age: float = 40.0

    def __post_init__(self) -> None:
        check_fields(self)
        if self.sex not in ("male", "female"):
            raise InputError(f"the sex of a driver is male or female, got {self.sex!r}")
        if not ADULT[0] <= self.age <= ADULT[1]:
            raise InputError(
                f"drivers are {ADULT[0]:g} to {ADULT[1]:g} years old, got {self.age:g}"
            )
        if not 1.2 <= self.stature <= 2.3 or not 0.4 <= self.sitting_height / self.stature <= 0.65:
            tall = 1e3 * self.stature
            sitting = 1e3 * self.sitting_height
            raise InputError(
                f"nobody who drives is {tall:.0f} mm tall and {sitting:.0f} mm sitting (1200 to 2300 mm, "
                f"of which 40 to 65 %)"
            )
        if not 12 <= self.mass_index <= 70:
            raise InputError(f"a body mass index is 12 to 70 kg/m^2, got {self.mass_index:.1f}")


@dataclass(frozen=True)
class Package:
    """What a driver sits before, all (3,) [m]: heel, where the accelerator's heel stands (AHP);
    ball, the ball of foot reference point on the accelerator; wheel, the steering wheel's centre;
    h_point, the seat's hip point where the seat stands in its reference position (SgRP)."""

    heel: tuple[float, float, float]
    ball: tuple[float, float, float]
    wheel: tuple[float, float, float]
    h_point: tuple[float, float, float]

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True)
class DrivingAims:
    """What a study says of a driver: sex ("" as the person's size says), age [years], the seed that
    the posture is drawn with (None: the mean posture), and the environment's points of the wheel's
    centre and the seat's hip point."""

    sex: str
    age: float
    seed: int | None
    wheel: str
    h_point: str


@dataclass(frozen=True, eq=False)
class DrivingAngles:
    """The angles of ANGLES (8,) [rad] of a posture, and the standard deviation of people about them
    (8,) [rad]."""

    mean: Floats
    spread: Floats

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in ("mean", "spread"):
            object.__setattr__(
                self,
                name,
                read_only(getattr(self, name), np.float64, (len(ANGLES),), f"angles.{name}"),
            )
