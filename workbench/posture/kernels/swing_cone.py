"""The swing cone: nearest point on a curve made of four quarter ellipses."""

from __future__ import annotations

import math

from workbench.compiled import batch_loop, inlined

__all__ = ["nearest_on_cones"]

SAMPLES = 96
"""Points of the curve of which the nearest is taken first."""
HALVINGS = 52
"""Halvings of the parameter between the points beside that: to the last digit."""


@inlined
def _half_angle(unit, limits, m, k):  # type: ignore[no-untyped-def]
    """The half-angle [rad] of axis k on the side that a component of the direction points to."""
    return limits[m, k, 0] if unit >= 0.0 else limits[m, k, 1]


@inlined
def _curve(turn, limits, m):  # type: ignore[no-untyped-def]
    """The point of the curve at a parameter, and its derivative there."""
    c = math.cos(turn)
    s = math.sin(turn)
    a = _half_angle(c, limits, m, 0)
    b = _half_angle(s, limits, m, 1)
    return c * a, s * b, -s * a, c * b


@inlined
def _nearest_turn(x, y, limits, m):  # type: ignore[no-untyped-def]
    """The parameter of the point of the curve that is nearest to (x, y)."""
    step = 2.0 * math.pi / SAMPLES
    best = 0.0
    least = math.inf
    for k in range(SAMPLES):
        u, v, _, _ = _curve(k * step, limits, m)
        square = (u - x) * (u - x) + (v - y) * (v - y)
        if square < least:
            least = square
            best = k * step
    low = best - step
    high = best + step
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        u, v, p, q = _curve(middle, limits, m)
        if (u - x) * p + (v - y) * q < 0.0:  # the distance falls where the curve runs on
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@batch_loop
def nearest_on_cones(swing, limits, point, distance, normal):  # type: ignore[no-untyped-def]
    """Find the nearest boundary points of M swing cones.

    Parameters
    ----------
    swing : (M, 2)
        Swings [rad].
    limits : (M, 2, 2)
        Half-angles [rad], none of them 0: axis; first and second sense.
    point : (M, 2)
        Filled with the points [rad].
    distance : (M,)
        Filled with the distances [rad], positive inside.
    normal : (M, 2)
        Filled with the outward normals there.
    """
    for m in range(len(swing)):
        x = swing[m, 0]
        y = swing[m, 1]
        u, v, _, _ = _curve(_nearest_turn(x, y, limits, m), limits, m)
        a = _half_angle(u, limits, m, 0)
        b = _half_angle(v, limits, m, 1)
        p = u / (a * a)
        q = v / (b * b)
        size = math.sqrt(p * p + q * q)
        point[m, 0] = u
        point[m, 1] = v
        normal[m, 0] = p / size
        normal[m, 1] = q / size
        away = math.sqrt((u - x) * (u - x) + (v - y) * (v - y))
        first = x / _half_angle(x, limits, m, 0)
        second = y / _half_angle(y, limits, m, 1)
        distance[m] = away if first * first + second * second <= 1.0 else -away
