"""Where the pedal of a car lies by SAE J1517's formulae: what built the cars that tests and
environments hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from workbench.model.arrays import Floats

BALL_TO_HEEL = 0.203


def pedal_plane_angle(height: ArrayLike) -> Floats:
    """(...) [rad] angle A47 of the undepressed accelerator's plane to the floor: 78.96 - 0.15 z -
    0.0173 z^2 degrees, z being H30 in cm. Sourced (Primary_18.m)."""
    z = 1e2 * np.asarray(height, dtype=np.float64)
    found: Floats = np.radians(78.96 - 0.15 * z - 0.0173 * z * z)
    return found


def heel_from_ball(height: ArrayLike) -> Floats:
    """(...) [m] how far the heel point lies aft of the ball of foot: the manikin's 203 mm along the
    pedal plane. So L53 is `seat_curve` less this."""
    found: Floats = BALL_TO_HEEL * np.cos(pedal_plane_angle(height))
    return found
