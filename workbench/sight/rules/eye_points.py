"""Eye points that rules give without a person: from the R point of a seat and the angle of its
back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.rule_set import REMEMBERED, RuleSet
from workbench.posture.seating.packaging import Eyellipse

__all__ = [
    "EyePoints",
    "car_eye_points",
    "eyellipse_centroid",
    "ocular_points",
    "seat_back_shift",
]

Side = Literal["left", "right"]
SIGN = {"left": 1.0, "right": -1.0}
"""The sign of y on each side."""
_ROUNDING = 1e-9
"""[rad] by which an angle may be beyond the ends of a table."""


@dataclass(frozen=True, eq=False)
class EyePoints:
    """Points (3,) [m] of a rule by their names, the side of the car that the driver is on, and how
    sure the numbers are."""

    points: Mapping[str, Floats]
    driver: Side
    status: str

    def __getitem__(self, name: str) -> Floats:
        return self.points[name]


def car_eye_points(
    r_point: ArrayLike,
    seat_back: float,
    rules: RuleSet,
    *,
    seat_travel: float | None = None,
    driver: Side = "left",
) -> EyePoints:
    """Find V1 and V2, P1, P2 and Pm of the UN R125 family.

    Parameters
    ----------
    r_point
        (3,) [m] the R point of the driver's seat.
    seat_back
        [rad] from the vertical.
    seat_travel
        [m] along which the seat is adjusted, which moves P1, P2 and Pm; None leaves them.

    Raises
    ------
    InputError
        If the seat back is not 5 to 40 degrees from the vertical.
    """
    shift = seat_back_shift(seat_back, rules)
    by_travel = np.zeros(3)
    names = ["v1", "v2", "p1", "p2", "pm", "seat_back_shift"]
    if seat_travel is not None:
        # band k is over seat_travel_over[k - 1], up to and with seat_travel_over[k]; band 0 is none
        over = rules.shaped("seat_travel_over", None)
        shifts = rules.shaped("seat_travel_shift", len(over), 3)
        by_travel = np.vstack([by_travel, shifts])[np.searchsorted(over, seat_travel)]
        names.append("seat_travel_shift")
    mirrored = np.array([1.0, SIGN[driver], 1.0])
    origin = np.asarray(r_point, dtype=np.float64)
    points = {
        name: origin + mirrored * (rules.shaped(name, 3) + shift + by_travel * name.startswith("p"))
        for name in names[:5]
    }
    return EyePoints(points, driver, rules.status(*names))


def seat_back_shift(seat_back: float, rules: RuleSet) -> Floats:
    """(3,) [m] by which a seat back [rad] other than 25 degrees moves the V, P and E points, by
    linear interpolation in the rule's table.

    InputError beyond the table, 5 to 40 degrees: it is no rotation about R, so it does not go on.
    """
    angles = rules.shaped("seat_back", None)
    if not angles[0] - _ROUNDING <= seat_back <= angles[-1] + _ROUNDING:
        low, high = np.degrees(angles[[0, -1]])
        raise InputError(
            f"seat back {np.degrees(seat_back):g} degrees from the vertical: the table of "
            f"{rules.name} holds for {low:g} to {high:g} degrees and does not go on"
        )
    rows = rules.shaped("seat_back_shift", len(angles), 3)
    return np.array([np.interp(seat_back, angles, column) for column in rows.T])


def ocular_points(
    r_point: ArrayLike, rules: RuleSet, *, working_paper: float | None = None
) -> EyePoints:
    """Find the driver's ocular points of UN R46: "left", "right" and their "middle".

    Parameters
    ----------
    r_point
        (3,) [m] the R point of the driver's seat.
    working_paper
        The seat back [rad] where the height is to follow the EC working paper of 2008,
        452.1 cos(back) + 225.26 mm; None for the rule's own 635 mm, which any seat back has.

    Raises
    ------
    InputError
        If that seat back is not 5 to 40 degrees from the vertical, as in the paper.
    """
    names = ["ocular_height", "ocular_apart"]
    height = rules.number("ocular_height")
    if working_paper is not None:
        if not np.radians(5.0) - _ROUNDING <= working_paper <= np.radians(40.0) + _ROUNDING:
            raise InputError(
                f"seat back {np.degrees(working_paper):g} degrees from the vertical: the working "
                f"paper's heights hold for 5 to 40 degrees; leave it out for the rule's 635 mm"
            )
        names = ["working_paper_cosine", "working_paper_constant", "ocular_apart"]
        height = rules.number(names[0]) * np.cos(working_paper) + rules.number(names[1])
    middle = np.asarray(r_point, dtype=np.float64) + np.array([0.0, 0.0, height])
    aside = np.array([0.0, 0.5 * rules.number("ocular_apart"), 0.0])
    points = {"left": middle + aside, "right": middle - aside, "middle": middle}
    return EyePoints(points, "left", rules.status(*names))


def eyellipse_centroid(ellipse: Eyellipse) -> EyePoints:
    """Take the centroid of an eyellipse, midway between the eyes, as the point "middle"."""
    status = f"SAE J941 (2002 and later): {REMEMBERED}"
    return EyePoints({"middle": ellipse.centroid}, "left", status)
