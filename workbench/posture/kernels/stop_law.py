"""The geometry of joint stops, which all that places, solves, checks and simulates asks.

Four kinds of stops hold a joint:

- a limit of one angle, which may follow another angle (a coupling);
- a swing cone, (s1 / L1)^2 + (s2 / L2)^2 <= 1, with four half-angles [1]_: a curve made of four
  quarter ellipses;
- a spherical polygon for the direction of a limb, as the sinus cones of [2]_;
- a half turn of the swing of that limb.

What is made of it: rows of room with their gradients, for solvers (`limits`); exact margins and
nearest legal rotations of batches (`posture.stops`); the excess of one pose, for the steps of a
simulation (`past_stops`).

References
----------
.. [1] P. Baerlocher and R. Boulic (2000), Parametrization and range of motion of the ball-and-socket
   joint, Deformable Avatars, 180-190.
.. [2] A. E. Engin and S. T. Tumer (1989), Three-dimensional kinematic modelling of the human
   shoulder complex, Journal of Biomechanical Engineering 111, 107-112.
"""

from __future__ import annotations

import math

from workbench.compiled import batch_loop, inlined
from workbench.geometry.vectors import dot, norm, scale, store, subtract, vector

__all__ = [
    "SMALLEST_LIMIT",
    "cone_share",
    "followed_limit",
    "nearest_on_cones",
    "nearest_on_polygons",
    "nearest_side",
]

SMALLEST_LIMIT = 1e-9
"""Half-angle [rad] that stands for 0, so that nothing is divided by zero."""
SAMPLES = 96
"""Points of the curve of a cone of which the nearest is taken first."""
HALVINGS = 52
"""Halvings of the parameter between the points beside that: to the last digit."""


@inlined
def followed_limit(driver, low, high, at_low, at_high):  # type: ignore[no-untyped-def]
    """Limit [rad] that follows an angle, and its rate: interpolated between two angles of the driver,
    constant beyond them."""
    if driver <= low:
        return at_low, 0.0
    if driver >= high:
        return at_high, 0.0
    rate = (at_high - at_low) / (high - low)
    return at_low + rate * (driver - low), rate


@inlined
def cone_share(first, second, l0, l1):  # type: ignore[no-untyped-def]
    """How far out a swing is, as a share of its cone along the ray from zero: 1 on the cone."""
    return math.sqrt((first / l0) ** 2 + (second / l1) ** 2)


@inlined
def _side_cosine(side, direction):  # type: ignore[no-untyped-def]
    """Cosine of the distance to one side (5, 3) of a spherical polygon, and whether it is to its arc.

    Beyond the ends of the arc it is the distance to the first corner; the other corner is the first
    one of the next side.
    """
    on_arc = dot(direction, vector(side[2])) >= 0.0 and dot(direction, vector(side[3])) >= 0.0
    if on_arc:
        height = dot(direction, vector(side[1]))
        return math.sqrt(max(0.0, 1.0 - height * height)), True
    return dot(direction, vector(side[0])), False


@inlined
def _in_polygon(sides, direction):  # type: ignore[no-untyped-def]
    """Whether a direction is inside a spherical polygon that its centre sees whole.

    The planes through centre and corners cut the sphere into sectors. In its own sector a direction
    is inside if it is on the inner side of the arc.
    """
    count = sides.shape[0]
    inside = False
    for i in range(count):
        following = i + 1 if i + 1 < count else 0
        if (
            dot(direction, vector(sides[i, 4])) >= 0.0
            and dot(direction, vector(sides[following, 4])) < 0.0
        ):
            inside = dot(direction, vector(sides[i, 1])) >= 0.0
    return inside


@inlined
def nearest_side(sides, direction):  # type: ignore[no-untyped-def]
    """Find the boundary point of a spherical polygon that is nearest to a direction.

    Parameters
    ----------
    sides : (V, 5, 3)
        As `Linkage.sides`.
    direction : tuple of three
        A unit vector.

    Returns
    -------
    point : tuple of three
        The nearest boundary point, a unit vector.
    side : int
        The side it is on.
    inside : bool
        Whether the direction is inside.
    """
    largest = -2.0
    nearest = 0
    arc = False
    for i in range(sides.shape[0]):
        cosine, on_arc = _side_cosine(sides[i], direction)
        if cosine > largest:
            largest = cosine
            nearest = i
            arc = on_arc
    inside = _in_polygon(sides, direction)
    if not arc:
        return vector(sides[nearest, 0]), nearest, inside
    normal = vector(sides[nearest, 1])
    x, y, z = subtract(direction, scale(dot(direction, normal), normal))
    size = max(largest, 1e-300)
    return (x / size, y / size, z / size), nearest, inside


@inlined
def _half_angle_of(unit, limits, m, k):  # type: ignore[no-untyped-def]
    """The half-angle [rad] of axis k on the side that a component of the direction points to."""
    return limits[m, k, 0] if unit >= 0.0 else limits[m, k, 1]


@inlined
def _curve(turn, limits, m):  # type: ignore[no-untyped-def]
    """The point of the curve at a parameter, and its derivative there."""
    c = math.cos(turn)
    s = math.sin(turn)
    a = _half_angle_of(c, limits, m, 0)
    b = _half_angle_of(s, limits, m, 1)
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
        a = _half_angle_of(u, limits, m, 0)
        b = _half_angle_of(v, limits, m, 1)
        p = u / (a * a)
        q = v / (b * b)
        size = math.sqrt(p * p + q * q)
        point[m, 0] = u
        point[m, 1] = v
        normal[m, 0] = p / size
        normal[m, 1] = q / size
        away = math.sqrt((u - x) * (u - x) + (v - y) * (v - y))
        share = cone_share(x, y, _half_angle_of(x, limits, m, 0), _half_angle_of(y, limits, m, 1))
        distance[m] = away if share <= 1.0 else -away


@batch_loop
def nearest_on_polygons(direction, sides, point, distance):  # type: ignore[no-untyped-def]
    """Find the boundary points of a spherical polygon that are nearest to M directions.

    Parameters
    ----------
    direction : (M, 3)
        Unit vectors.
    sides : (V, 5, 3)
        As `Linkage.sides`.
    point : (M, 3)
        Filled with the points, unit vectors.
    distance : (M,)
        Filled with the angles [rad] to them, positive inside.
    """
    for m in range(len(direction)):
        toward = vector(direction[m])
        nearest, _, inside = nearest_side(sides, toward)
        angle = 2.0 * math.asin(min(1.0, 0.5 * norm(subtract(toward, nearest))))
        store(nearest, point[m])
        distance[m] = angle if inside else -angle
