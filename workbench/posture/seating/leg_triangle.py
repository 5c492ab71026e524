"""Angles of the triangle of hip, knee and ankle, from the lengths of thigh and shank."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Floats
from workbench.posture.kernels.driving_legs import FLAT

__all__ = ["LegTriangle", "leg_triangle"]


@dataclass(frozen=True, eq=False)
class LegTriangle:
    """Legs whose hip and ankle are given. The arrays have the shape of their distances."""

    hip: Floats
    """[rad] between the thigh and the line from hip to ankle."""
    knee: Floats
    """[rad] between thigh and shank: pi for a straight leg."""
    lack: Floats
    """[m] by how much the ankle is out of reach: negative if it is too near."""


def leg_triangle(thigh: Floats, shank: Floats, distance: Floats) -> LegTriangle:
    """Solve the triangle of a leg by the law of cosines.

    Parameters
    ----------
    thigh, shank
        Lengths [m], which broadcast with the distances.
    distance
        From hip to ankle [m]. A leg that cannot span it is stretched, or folded.

    Returns
    -------
    LegTriangle
        Angles at hip and knee, and what the leg lacks.
    """
    span = np.clip(distance, np.abs(thigh - shank) + FLAT, thigh + shank - FLAT)
    hip = np.arccos((thigh**2 + span**2 - shank**2) / (2 * thigh * span))
    knee = np.arccos((thigh**2 + shank**2 - span**2) / (2 * thigh * shank))
    return LegTriangle(hip, knee, distance - span)
