"""The swing cone: nearest point on a curve made of four quarter ellipses."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats
from workbench.posture.kernels.limits import SMALLEST_LIMIT
from workbench.posture.kernels.swing_cone import nearest_on_cones

__all__ = ["nearest_on_cone"]


def nearest_on_cone(swing: Floats, limits: Floats) -> tuple[Floats, Floats, Floats]:
    """Nearest boundary points of swing cones.

    swing (M, 2) [rad]; limits (M, 2, 2): half-angles (axis; first, second sense). Legal is (s1 /
    L1)^2 + (s2 / L2)^2 <= 1 with the half-angle of the sign of each component (Baerlocher & Boulic
    2000). Returns the points (M, 2), the signed distances (M,) (positive inside) and the outward
    normals there (M, 2).
    """
    point = np.empty((len(swing), 2))
    distance = np.empty(len(swing))
    normal = np.empty((len(swing), 2))
    half_angles = np.maximum(limits, SMALLEST_LIMIT)
    nearest_on_cones(np.ascontiguousarray(swing), half_angles, point, distance, normal)
    return point, distance, normal
