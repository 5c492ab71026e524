"""The statistical driving posture: side-view angles of a driver from sex, size, age and package,
with their scatter.

Park, Ebert, Reed & Hallman, Statistical models for predicting automobile driving postures for men
and women including effects of age, Human Factors 58(2), 2016: 90 drivers in 9 packages. The
coefficients are those of the public code of a driver's manikin (drBrolin/Virtual-Driver-Lua), which
agrees with itself on three test drivers; the paper itself was not at hand. Angles are in degrees
there, lengths in mm.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats, read_only
from workbench.model.driving import ANGLES, Driver, DrivingAngles, Package

__all__ = ["drawn_angles", "driving_angles", "expected_angles", "h_point_offset", "residuals"]

FEMALE_SPREAD = (4.1, 5.3, 5.7, 7.0, 9.4, 13.9, 4.5, 8.7)
MALE_SPREAD = (3.3, 5.0, 6.5, 4.3, 11.4, 13.2, 4.4, 8.9)
"""Residual standard deviations [degrees], in the order of ANGLES."""
SEATS = (0.10, 0.50)
"""Heights of the hip point above the heel [m] that the angles are used for; the 9 packages lie
within."""


def driving_angles(driver: Driver, package: Package) -> DrivingAngles:
    """The mean angles of such a driver in such a package, and the residual standard deviations of
    people about them.

    The package counts by H30, the height of its hip point above the heel, and L6, from the ball of
    foot aft to the wheel. InputError where the seat is no car's.
    """
    mean, spread = expected_angles([driver], package, np.zeros(1))
    return DrivingAngles(mean[0], spread[0])


def expected_angles(
    drivers: Sequence[Driver], package: Package, lift: Floats
) -> tuple[Floats, Floats]:
    """The mean angles (B, 8) [rad] of drivers whose seats are lifted (B,) [m], and the standard
    deviations (B, 8) [rad] of people about them; see `driving_angles`."""
    height = package.h_point[2] + lift - package.heel[2]
    outside = np.flatnonzero((height < SEATS[0]) | (height > SEATS[1]))
    if len(outside):
        raise InputError(
            f"driving postures are known for hip points {1e3 * SEATS[0]:g} to {1e3 * SEATS[1]:g} mm above "
            f"the heel (H30), got {1e3 * height[outside[0]]:.0f} mm"
        )
    female = np.array([driver.sex == "female" for driver in drivers])
    mean = np.empty((len(drivers), len(ANGLES)))
    for mine, angles in ((female, _female), (~female, _male)):
        rows = np.flatnonzero(mine)
        h = 1e3 * height[rows]
        relative = 1e3 * (package.ball[0] - package.wheel[0]) - (700.0 - 0.55556 * h)
        mean[rows] = angles(_measures([drivers[row] for row in rows.tolist()]), h, relative)
    return np.radians(mean), np.radians(np.where(female[:, None], FEMALE_SPREAD, MALE_SPREAD))


def drawn_angles(mean: Floats, spread: Floats, seed: int, numbers: Iterable[int]) -> Floats:
    """Angles (B, 8) [rad] of drivers with such numbers: the means (8,) or (B, 8) and a residual for
    each, normal and independent, the same for the same seed and number. The source tells no
    correlations."""
    return mean + spread * [residuals(seed, (number,), len(ANGLES)) for number in numbers]


@lru_cache(maxsize=1 << 15)
def residuals(seed: int, stream: tuple[int, ...], count: int) -> Floats:
    """(count,) the residuals of a driver in units of their standard deviations, of one of the streams
    of a seed."""
    chance = np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=stream)))
    return read_only(chance.standard_normal(count), np.float64, (count,), "residuals")


def h_point_offset(driver: Driver) -> tuple[float, float]:
    """How far the hip point of the seat lies aft of and above the middle of the driver's hip joints
    [m]; the same source as the angles, by body mass index."""
    b = driver.mass_index
    up = 0.2872 * b - 11.583 if driver.sex == "female" else 0.2921 * b - 7.5027
    return 1e-3 * (0.4691 * b + 6.7786), 1e-3 * up


def _measures(drivers: Sequence[Driver]) -> tuple[Floats, Floats, Floats, Floats]:
    """(B,) stature [mm], sitting height by stature, body mass index [kg/m^2] and age [years]."""
    rows = [(one.stature, one.sitting_height, one.mass_index, one.age) for one in drivers]
    stature, sitting, mass_index, age = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    return 1e3 * stature, sitting / stature, mass_index, age


def _female(measures: tuple[Floats, Floats, Floats, Floats], h: Floats, wheel: Floats) -> Floats:
    """(B, 8) [degrees], from `_measures`, H30 (B,) and L6 less its usual value (B,) [mm]."""
    s, r, b, age = measures
    return np.stack(
        [
            0.32 + 0.214 * b,
            72.3 - 0.0183 * s - 81.8 * r + 0.267 * b,
            111.0 - 0.0736 * s - 2.15 * age - 0.0124 * h + 0.00137 * s * age,
            -39.73 + 81.29 * r,
            5.093 + 0.8034 * b,
            129.0 - 0.0454 * s - 0.204 * age,
            -93.2 + 228.0 * r + 7.06 * b - 0.0262 * h - 0.0358 * wheel - 13.9 * r * b,
            372.0 - 449.0 * r - 12.9 * b + 0.0741 * age - 0.102 * h + 0.0819 * wheel + 25.5 * r * b,
        ],
        axis=1,
    )


def _male(measures: tuple[Floats, Floats, Floats, Floats], h: Floats, wheel: Floats) -> Floats:
    """(B, 8) [degrees], from `_measures`, H30 (B,) and L6 less its usual value (B,) [mm]."""
    s, r, b, age = measures
    return np.stack(
        [
            -36.8 + 86.0 * r - 0.00843 * h,
            -90.8 + 162.0 * r + 0.327 * b + 1.65 * age - 3.11 * r * age,
            -7.83 - 0.0524 * age,
            -49.0 + 109.0 * r - 0.0671 * age - 0.00946 * h,
            -71.6 + 140.0 * r + 1.11 * b,
            -124.0 + 0.12 * s - 1.5 * b + 3.31 * age - 0.00189 * s * age,
            35.2 + 0.019 * s - 72.5 * r - 0.162 * b - 0.0304 * h - 0.0436 * wheel,
            204.0 - 0.0348 * s - 0.0857 * h + 0.0933 * wheel,
        ],
        axis=1,
    )
