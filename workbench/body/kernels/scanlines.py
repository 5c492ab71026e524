"""Volumes of a closed mesh, of a union of balls, and of what they share, by parallel lines.

Along each line (upright, through the middle of a square of a grid) the lengths inside both are
exact; only the spacing of the lines is an approximation.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit

__all__ = ["shared_volume"]


def shared_volume(
    corners: NDArray[np.float64],
    centre: NDArray[np.float64],
    radius: NDArray[np.float64],
    pitch: float,
) -> tuple[float, float, float]:
    """Volumes [m3] of the mesh, of the union of the balls, and of their intersection.

    corners (T, 3, 3) of a closed mesh wound outward; centre (m, 3), radius (m,); pitch [m] between
    lines.
    """
    low = (
        np.minimum(corners.min(axis=(0, 1)), (centre - radius[:, None]).min(axis=0))[:2]
        - pitch * 0.381966
    )
    high = np.maximum(corners.max(axis=(0, 1)), (centre + radius[:, None]).max(axis=0))[:2]
    size = np.ceil((high - low) / pitch).astype(np.int64) + 1
    lines = int(size[0] * size[1])
    counts = np.zeros((2, lines + 1), dtype=np.int64)
    empty = np.empty((0, 2))
    for fill in (False, True):
        marks = np.empty((int(counts[0, -1]), 2)) if fill else empty
        spans = np.empty((int(counts[1, -1]), 2)) if fill else empty
        free = counts[:, :-1].copy()
        _cross(corners, low, size, pitch, fill, free[0], marks)
        _pierce(centre, radius, low, size, pitch, fill, free[1], spans)
        if not fill:
            counts[:, 1:] = np.cumsum(free, axis=1)
            counts[:, 0] = 0
    mesh, union, both = _lengths(counts, marks, spans)
    area = pitch * pitch
    return mesh * area, union * area, both * area


@njit(cache=True)
def _cross(corners, low, size, pitch, fill, free, marks):  # type: ignore[no-untyped-def]
    """Where the lines cross the triangles: height and +1 going in, -1 going out (upward)."""
    for t in range(len(corners)):
        c = corners[t]
        ux = c[1, 0] - c[0, 0]
        uy = c[1, 1] - c[0, 1]
        vx = c[2, 0] - c[0, 0]
        vy = c[2, 1] - c[0, 1]
        area = ux * vy - uy * vx
        if area == 0.0:
            continue
        first = max(0, math.ceil((c[:, 0].min() - low[0]) / pitch))
        last = min(size[0] - 1, math.floor((c[:, 0].max() - low[0]) / pitch))
        bottom = max(0, math.ceil((c[:, 1].min() - low[1]) / pitch))
        top = min(size[1] - 1, math.floor((c[:, 1].max() - low[1]) / pitch))
        for i in range(first, last + 1):
            for j in range(bottom, top + 1):
                px = low[0] + i * pitch - c[0, 0]
                py = low[1] + j * pitch - c[0, 1]
                a = (px * vy - py * vx) / area
                b = (ux * py - uy * px) / area
                if a < 0.0 or b < 0.0 or a + b > 1.0:
                    continue
                line = i * size[1] + j
                if fill:
                    k = free[line]
                    marks[k, 0] = c[0, 2] + a * (c[1, 2] - c[0, 2]) + b * (c[2, 2] - c[0, 2])
                    marks[k, 1] = -1.0 if area > 0.0 else 1.0
                free[line] += 1


@njit(cache=True)
def _pierce(centre, radius, low, size, pitch, fill, free, spans):  # type: ignore[no-untyped-def]
    """Where the lines run inside the balls: from, to."""
    for s in range(len(radius)):
        first = max(0, math.ceil((centre[s, 0] - radius[s] - low[0]) / pitch))
        last = min(size[0] - 1, math.floor((centre[s, 0] + radius[s] - low[0]) / pitch))
        for i in range(first, last + 1):
            dx = low[0] + i * pitch - centre[s, 0]
            for j in range(size[1]):
                dy = low[1] + j * pitch - centre[s, 1]
                square = radius[s] * radius[s] - dx * dx - dy * dy
                if square <= 0.0:
                    continue
                line = i * size[1] + j
                if fill:
                    half = math.sqrt(square)
                    spans[free[line], 0] = centre[s, 2] - half
                    spans[free[line], 1] = centre[s, 2] + half
                free[line] += 1


@njit(cache=True)
def _lengths(counts, marks, spans):  # type: ignore[no-untyped-def]
    """Summed lengths inside the mesh, inside the union, inside both."""
    mesh = 0.0
    union = 0.0
    both = 0.0
    for line in range(counts.shape[1] - 1):
        cut = marks[counts[0, line] : counts[0, line + 1]]
        run = spans[counts[1, line] : counts[1, line + 1]]
        n = len(cut) + 2 * len(run)
        if n == 0:
            continue
        place = np.empty(n)
        kind = np.empty(n, np.int64)
        step = np.empty(n)
        for k in range(len(cut)):
            place[k] = cut[k, 0]
            kind[k] = 0
            step[k] = cut[k, 1]
        for k in range(len(run)):
            a = len(cut) + 2 * k
            place[a] = run[k, 0]
            kind[a] = 1
            step[a] = 1.0
            place[a + 1] = run[k, 1]
            kind[a + 1] = 1
            step[a + 1] = -1.0
        order = np.argsort(place, kind="mergesort")
        winding = 0.0
        deep = 0.0
        before = 0.0
        for e in order:
            length = place[e] - before
            if winding > 0.5:
                mesh += length
            if deep > 0.5:
                union += length
                if winding > 0.5:
                    both += length
            before = place[e]
            if kind[e] == 0:
                winding += step[e]
            else:
                deep += step[e]
    return mesh, union, both
