"""Vehicle packaging: where SAE's design tools expect drivers' hips, eyes and hands, from a few
dimensions of a car.

Dimensions carry their SAE J1100 codes: H30 the height of the seat over the heel, L6 from the ball
of foot aft to the wheel's centre, A19 the rise of the track, W20 how far the seat is from the
centre line. The standards' text was not at hand. Each formula says where its numbers were read and
how sure they are: `sourced` (read in the code or text named), `remembered` (agrees with what is
known of it, not read). Lengths [m], angles [rad].
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError, UsageError
from workbench.model.arrays import Floats

__all__ = [
    "EYELLIPSE_AXES",
    "SEAT_CURVES",
    "Eyellipse",
    "SeatCurve",
    "eyellipse",
    "seat_curve",
]

CLASS_A = (0.127, 0.405)
"""Heights of the seat over the heel [m] that the curves for cars hold for."""


@dataclass(frozen=True)
class SeatCurve:
    """Distance aft of the ball of foot a + b H30 + c H30^2, all in mm, and how sure the numbers
    are."""

    a: float
    b: float
    c: float
    sure: str

    def __call__(self, height: Floats) -> Floats:
        """(...) [m] at heights (...) [m]."""
        z = 1e3 * height
        return 1e-3 * (self.a + self.b * z + self.c * z * z)


SEAT_CURVES: Mapping[float, SeatCurve] = {
    2.5: SeatCurve(687.1, 0.895336, -0.00210494, "remembered"),
    5.0: SeatCurve(692.6, 0.981427, -0.0022623, "remembered"),
    10.0: SeatCurve(715.9, 0.968793, -0.00228674, "remembered"),
    50.0: SeatCurve(793.7, 0.903387, -0.00225518, "sourced"),
    90.0: SeatCurve(885.0, 0.735374, -0.0020165, "remembered"),
    95.0: SeatCurve(913.7, 0.672316, -0.0019553, "sourced"),
    97.5: SeatCurve(936.6, 0.613879, -0.00186247, "remembered"),
}
"""By percentile: how far aft that share of drivers (half of them women) sit at most. SAE J1517,
class A (cars); 50 and 95 as coded in the public Commuter-Cars package program (CodeMonkeys,
Primary_18.m)."""

EYELLIPSE_AXES: Mapping[float, tuple[float, float, float]] = {
    95.0: (0.2064, 0.0603, 0.0934),
    99.0: (0.2871, 0.0853, 0.1321),
}
"""Full axes [m] along, across and up, for seat travel over 133 mm. Remembered from SAE J941 (2002
and later); they agree with its published differences to the older ones."""


def seat_curve(height: ArrayLike, *, percentile: float = 95.0) -> Floats:
    """(...) [m] how far aft of the ball of foot `percentile` per cent of car drivers sit at most,
    at H30 `height` (...) [m]: the curve for the seating reference point at 95.

    SAE J1517 (class A; see SEAT_CURVES for how sure each curve is). InputError beyond H30 127 to
    405 mm and for a percentile without a curve.

    Examples
    --------
    >>> import workbench as wb
    >>> wb.seat_curve([0.2, 0.3, 0.4]).round(3)  # of 95 % of drivers, behind the ball of the foot
    array([0.97 , 0.939, 0.87 ])
    """
    return _curve(SEAT_CURVES, percentile)(_within(height, CLASS_A, "a car (class A)"))


@dataclass(frozen=True, eq=False)
class Eyellipse:
    """An eyellipse: centroid (3,) [m] midway between the eyes, in the workbench's axes; axes (3,)
    [m]: full lengths; tilt [rad]: the long axis falls forward by this.

    A share of the eyes lies on the near side of any plane that touches the ellipsoid; fewer are
    inside of it.
    """

    centroid: Floats
    axes: Floats
    tilt: float

    def cutoff(self, direction: ArrayLike) -> float:
        """[m] how far along a unit direction (3,) from the centroid the tangent plane lies."""
        n = np.asarray(direction, dtype=np.float64)
        c = np.cos(self.tilt)
        s = np.sin(self.tilt)
        own = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])  # rows: the ellipsoid's axes
        return float(np.linalg.norm(0.5 * self.axes * (own @ n)))


def eyellipse(
    ball: ArrayLike,
    *,
    heel: float,
    side: float,
    wheel: float,
    height: float,
    clutch: bool,
    rise: float = 0.0,
    percentile: float = 95.0,
) -> Eyellipse:
    """Where the eyes of drivers are, SAE J941 (2002 and later, seat travel over 133 mm, half of the
    drivers women).

    ball (3,) [m]: the ball of foot reference point; heel [m]: the height of the heel point (H8);
    side [m]: where the seat's middle is across (W20, + left); wheel: L6, height: H30 [m]; rise: A19
    [rad]. Centroid 664 + 0.587 L6
    - 0.176 H30 - 12.5 with a clutch aft of the ball [mm], 638 + H30 above the heel; tilt 18.6
    degrees less the rise. Remembered; a summary agrees on what it depends on. InputError for a
    percentile other than 95 and 99.

    Examples
    --------
    >>> import workbench as wb
    >>> found = wb.eyellipse([0, 0, 0], heel=-0.1, side=0.3, wheel=-0.5, height=0.3, clutch=False)
    >>> found.centroid.round(3)  # [m]
    array([-0.318,  0.3  ,  0.838])
    """
    if percentile not in EYELLIPSE_AXES:
        raise InputError(
            f"no eyellipse for {percentile:g} %; valid: {', '.join(f'{p:g}' for p in EYELLIPSE_AXES)}"
        )
    point = np.asarray(ball, dtype=np.float64)
    if point.shape != (3,):
        raise UsageError(f"ball: expected a point (3,), got an array {point.shape}")
    aft = 0.664 + 0.587 * wheel - 0.176 * height - 0.0125 * clutch
    centroid = np.array([point[0] - aft, side, heel + 0.638 + height])
    return Eyellipse(centroid, np.array(EYELLIPSE_AXES[percentile]), float(np.radians(18.6) - rise))


def _curve(curves: Mapping[float, SeatCurve], percentile: float) -> SeatCurve:
    if percentile not in curves:
        raise InputError(
            f"no curve for {percentile:g} %; valid: {', '.join(f'{p:g}' for p in curves)}"
        )
    return curves[percentile]


def _within(height: ArrayLike, limits: tuple[float, float], what: str) -> Floats:
    z = np.asarray(height, dtype=np.float64)
    low, high = limits
    if not np.all((z >= low) & (z <= high)):
        worst = float(np.ravel(z)[int(np.argmax(np.abs(np.ravel(z) - 0.5 * (low + high))))])
        raise InputError(
            f"the seat of {what} is {1e3 * low:g} to {1e3 * high:g} mm above the heel (H30), "
            f"got {1e3 * worst:g} mm"
        )
    return z
