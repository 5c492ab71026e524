"""The swing cone: nearest point on a curve made of four quarter ellipses."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Floats
from workbench.posture.kernels.limits import SMALLEST_LIMIT

__all__ = ["nearest_on_cone"]

SAMPLES = 96
HALVINGS = 52


def nearest_on_cone(swing: Floats, limits: Floats) -> tuple[Floats, Floats, Floats]:
    """Nearest boundary point of the swing cone.

    swing (P, 2) [rad]; limits (P, 2, 2): half-angles (axis; first, second sense). Legal is (s1 /
    L1)^2 + (s2 / L2)^2 <= 1 with the half-angle of the sign of each component (Baerlocher & Boulic
    2000). Returns the point (P, 2), the signed distance (P,) (positive inside) and the outward
    normal there (P, 2).
    """
    limits = np.maximum(limits, SMALLEST_LIMIT)
    turn = np.linspace(0.0, 2 * np.pi, SAMPLES, endpoint=False, dtype=np.float64)
    gap = _curve(turn[None], limits) - swing[:, None]
    best = turn[np.argmin(np.sum(gap**2, axis=-1), axis=1)]
    low = best - 2 * np.pi / SAMPLES
    high = best + 2 * np.pi / SAMPLES
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        # the distance falls where the curve runs toward the point
        toward = (
            np.sum(
                (_curve(middle[:, None], limits)[:, 0] - swing) * _slope(middle, limits), axis=-1
            )
            < 0
        )
        low = np.where(toward, middle, low)
        high = np.where(toward, high, middle)
    point = _curve(0.5 * (low + high)[:, None], limits)[:, 0]
    used = np.where(point >= 0, limits[..., 0], limits[..., 1])
    normal = point / used**2
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    side = np.where(swing >= 0, limits[..., 0], limits[..., 1])
    inside = np.sum((swing / side) ** 2, axis=-1) <= 1.0
    distance = np.linalg.norm(point - swing, axis=-1)
    return point, np.where(inside, distance, -distance), normal


def _curve(turn: Floats, limits: Floats) -> Floats:
    """Boundary points (P, T, 2) at parameters (1 or P, T)."""
    unit = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    half = np.where(unit >= 0, limits[:, None, :, 0], limits[:, None, :, 1])
    return unit * half


def _slope(turn: Floats, limits: Floats) -> Floats:
    """Derivative (P, 2) of the curve at parameters (P,)."""
    c = np.cos(turn)
    s = np.sin(turn)
    half = np.where(np.stack([c, s], axis=-1) >= 0, limits[..., 0], limits[..., 1])
    return np.stack([-s, c], axis=-1) * half
