"""Joint stops and planes as rows of room: how far the chain is from each, and how that changes with
its free angles.

Room is positive inside. A row of a stop is in radians, a row of a plane in metres. All is inlined
into the batch loop by force and compiled without counting references (see kernels.limbs.linkage).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import inlined, njit

__all__ = [
    "SIDE_ROWS",
    "WHOLE_CONE",
    "WHOLE_POLYGON",
    "WHOLE_TURN",
    "Planes",
    "nearest_side",
    "rooms",
    "within",
]

WHOLE_CONE = 3
WHOLE_POLYGON = 4
WHOLE_TURN = 5
"""What stands in the place of an axis in a row that is about more than one angle."""
SIDE_ROWS = 3
LEAST = 1e-9
MOST_SWING = 3.12
FAR = 1e3


class Planes(NamedTuple):
    """Obstacles near to a chain, made planes: point (Q, 3) of link (Q,) must have normal (Q, 3) . x
    >= offset (Q,)."""

    link: NDArray[np.int64]
    point: NDArray[np.float64]
    normal: NDArray[np.float64]
    offset: NDArray[np.float64]


@inlined
def _limit(bounds, angles, k, axis, side):  # type: ignore[no-untyped-def]
    """A limit with its coupling: the limit, the row of the coupling it follows just here (or -1),
    and how fast."""
    limits, coupled, coupling, _ = bounds
    c = coupled[k, axis, side]
    if c < 0:
        return limits[k, axis, side], -1, 0.0
    driver = angles[int(coupling[c, 0]), int(coupling[c, 1])]
    low = coupling[c, 2]
    high = coupling[c, 3]
    if driver <= low:
        return coupling[c, 4], -1, 0.0
    if driver >= high:
        return coupling[c, 5], -1, 0.0
    rate = (coupling[c, 5] - coupling[c, 4]) / (high - low)
    return coupling[c, 4] + rate * (driver - low), c, rate


@inlined
def _cone(bounds, angles, k, held, out):  # type: ignore[no-untyped-def]
    """The swing cone: (s1 / L1)^2 + (s2 / L2)^2 <= 1, its excess divided by its slope to be an
    angle. Fills a row of room, slope, label, and its curvature into held."""
    room, slope, label, r = out
    coupling = bounds[2]
    free_of = bounds[3]
    s0 = angles[k, 0]
    s1 = angles[k, 1]
    b0 = 0 if s0 >= 0 else 1
    b1 = 0 if s1 >= 0 else 1
    l0, c0, r0 = _limit(bounds, angles, k, 0, b0)
    l1, c1, r1 = _limit(bounds, angles, k, 1, b1)
    l0 = max(l0, LEAST)
    l1 = max(l1, LEAST)
    root = math.sqrt((s0 / l0) ** 2 + (s1 / l1) ** 2)
    room[r] = FAR
    label[r, 1] = 0
    label[r, 2] = b0
    held[r, 0] = 0.0
    held[r, 1] = 0.0
    held[r, 2] = 0.0
    if root < 0.05:  # near the middle of the cone nothing limits
        return
    g0 = s0 / (l0 * l0 * root)
    g1 = s1 / (l1 * l1 * root)
    total = math.sqrt(g0 * g0 + g1 * g1)
    if abs(g1) > abs(g0):
        label[r, 1] = 1
        label[r, 2] = b1
    room[r] = (1.0 - root) / total
    bend = 1.0 / (root * total)
    held[r, 0] = bend * (1.0 / (l0 * l0) - g0 * g0)
    held[r, 1] = -bend * g0 * g1
    held[r, 2] = bend * (1.0 / (l1 * l1) - g1 * g1)
    if free_of[k, 0] >= 0:
        slope[r, free_of[k, 0]] -= g0 / total
    if free_of[k, 1] >= 0:
        slope[r, free_of[k, 1]] -= g1 / total
    if c0 >= 0 and free_of[int(coupling[c0, 0]), int(coupling[c0, 1])] >= 0:
        slope[r, free_of[int(coupling[c0, 0]), int(coupling[c0, 1])]] += g0 * s0 / l0 * r0 / total
    if c1 >= 0 and free_of[int(coupling[c1, 0]), int(coupling[c1, 1])] >= 0:
        slope[r, free_of[int(coupling[c1, 0]), int(coupling[c1, 1])]] += g1 * s1 / l1 * r1 / total


@inlined
def _local(world, k, x, y, z):  # type: ignore[no-untyped-def]
    """A world direction in the frame of link k."""
    return (
        world[k, 0, 0] * x + world[k, 1, 0] * y + world[k, 2, 0] * z,
        world[k, 0, 1] * x + world[k, 1, 1] * y + world[k, 2, 1] * z,
        world[k, 0, 2] * x + world[k, 1, 2] * y + world[k, 2, 2] * z,
    )


@inlined
def _out(world, k, x, y, z):  # type: ignore[no-untyped-def]
    """A direction of link k's frame in the world."""
    return (
        world[k, 0, 0] * x + world[k, 0, 1] * y + world[k, 0, 2] * z,
        world[k, 1, 0] * x + world[k, 1, 1] * y + world[k, 1, 2] * z,
        world[k, 2, 0] * x + world[k, 2, 1] * y + world[k, 2, 2] * z,
    )


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def nearest_side(sides, x, y, z):  # type: ignore[no-untyped-def]
    """Nearest boundary point of the spherical polygon to a direction, its side, and whether the
    direction is inside."""
    count = sides.shape[0]
    best = -2.0
    side = 0
    whole = False
    inside = False
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        height = x * sides[i, 1, 0] + y * sides[i, 1, 1] + z * sides[i, 1, 2]
        if (
            x * sides[i, 4, 0] + y * sides[i, 4, 1] + z * sides[i, 4, 2] >= 0.0
            and x * sides[j, 4, 0] + y * sides[j, 4, 1] + z * sides[j, 4, 2] < 0.0
        ):
            inside = height >= 0.0
        along = (
            x * sides[i, 2, 0] + y * sides[i, 2, 1] + z * sides[i, 2, 2] >= 0.0
            and x * sides[i, 3, 0] + y * sides[i, 3, 1] + z * sides[i, 3, 2] >= 0.0
        )
        if along:
            cosine = math.sqrt(max(0.0, 1.0 - height * height))
        else:
            cosine = x * sides[i, 0, 0] + y * sides[i, 0, 1] + z * sides[i, 0, 2]
        if cosine > best:
            best = cosine
            side = i
            whole = along
    if not whole:
        return (sides[side, 0, 0], sides[side, 0, 1], sides[side, 0, 2]), side, inside
    u = sides[side, 1, 0]
    v = sides[side, 1, 1]
    w = sides[side, 1, 2]
    height = x * u + y * v + z * w
    size = max(best, 1e-300)
    return ((x - height * u) / size, (y - height * v) / size, (z - height * w) / size), side, inside


@inlined
def _polygon(shape, world, spin, free_joint, held, out):  # type: ignore[no-untyped-def]
    """The limb's direction in its spherical polygon: room is the angle to the nearest boundary
    point. Fills a row."""
    sides, limb, axes, k, frame = shape
    room, slope, label, r = out
    d = _out(world, k + 1, limb[0], limb[1], limb[2])
    d = _local(world, frame, d[0], d[1], d[2])
    q, side, inside = nearest_side(sides, d[0], d[1], d[2])
    gap = math.sqrt((d[0] - q[0]) ** 2 + (d[1] - q[1]) ** 2 + (d[2] - q[2]) ** 2)
    angle = 2.0 * math.asin(min(1.0, 0.5 * gap))
    # u leads in; on the boundary itself the side's own normal does
    sign = (-1.0 if inside else 1.0) / max(gap, 1e-300)
    u = (sign * (q[0] - d[0]), sign * (q[1] - d[1]), sign * (q[2] - d[2]))
    if gap < 1e-5:
        u = (sides[side, 1, 0], sides[side, 1, 1], sides[side, 1, 2])
    c = (d[1] * u[2] - d[2] * u[1], d[2] * u[0] - d[0] * u[2], d[0] * u[1] - d[1] * u[0])
    turn = _out(world, frame, c[0], c[1], c[2])
    # told as the swing axis of the joint that leads out: the sense is against the turn that leads
    # in
    own = _local(world, k, turn[0], turn[1], turn[2])
    first = own[0] * axes[k, 0, 0] + own[1] * axes[k, 0, 1] + own[2] * axes[k, 0, 2]
    second = own[0] * axes[k, 1, 0] + own[1] * axes[k, 1, 1] + own[2] * axes[k, 1, 2]
    label[r, 1] = 0 if abs(first) >= abs(second) else 1
    label[r, 2] = 0 if (first if abs(first) >= abs(second) else second) < 0.0 else 1
    room[r] = angle if inside else -angle
    e = _out(world, frame, d[0], d[1], d[2])
    v = _out(world, frame, u[0], u[1], u[2])
    for i in range(3):
        held[r, i] = e[i]
        held[r, 3 + i] = v[i]
    for i in range(free_joint.shape[0]):
        if frame <= free_joint[i] <= k:
            slope[r, i] = spin[i, 0] * turn[0] + spin[i, 1] * turn[1] + spin[i, 2] * turn[2]


@inlined
def _half_turn(angles, free_of, k, out):  # type: ignore[no-untyped-def]
    """Keep the polygon joint's swing below a half turn, where its angles would change their
    meaning. Fills a row."""
    room, slope, label, r = out
    s0 = angles[k, 0]
    s1 = angles[k, 1]
    size = math.sqrt(s0 * s0 + s1 * s1)
    axis = 0 if abs(s0) >= abs(s1) else 1
    label[r, 1] = axis
    label[r, 2] = 0 if angles[k, axis] >= 0.0 else 1
    room[r] = MOST_SWING - size
    if size > 1.0:
        for i in range(2):
            if free_of[k, i] >= 0:
                slope[r, free_of[k, i]] = -angles[k, i] / size


@inlined
def _wall(planes, m, chain, out):  # type: ignore[no-untyped-def]
    """A plane: room is the height of the point above it. Fills a row."""
    link, point, normal, offset = planes
    world, spin, free_joint, pivot = chain
    room, slope, held, r = out
    k = link[m]
    n0 = normal[m, 0]
    n1 = normal[m, 1]
    n2 = normal[m, 2]
    x, y, z = _out(world, k, point[m, 0], point[m, 1], point[m, 2])
    x = x + world[k, 0, 3]
    y = y + world[k, 1, 3]
    z = z + world[k, 2, 3]
    room[r] = n0 * x + n1 * y + n2 * z - offset[m]
    held[r, 0] = x
    held[r, 1] = y
    held[r, 2] = z
    held[r, 6] = k
    held[r, 3] = n0
    held[r, 4] = n1
    held[r, 5] = n2
    for i in range(free_joint.shape[0]):
        j = free_joint[i]
        if j >= k:
            continue
        r0 = x - pivot[j, 0]
        r1 = y - pivot[j, 1]
        r2 = z - pivot[j, 2]
        slope[r, i] = (
            spin[i, 0] * (r1 * n2 - r2 * n1)
            + spin[i, 1] * (r2 * n0 - r0 * n2)
            + spin[i, 2] * (r0 * n1 - r1 * n0)
        )


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def rooms(link, planes, span, state):  # type: ignore[no-untyped-def]
    """Fill the rows of room of a state whose world and spin are there: the stops in the order of
    link.rows, then the planes span[0]..span[1]."""
    rows = link.rows
    free_of = link.free_of
    coupling = link.coupling
    bounds = (link.limits, link.coupled, coupling, free_of)
    angles = state.angles
    world = state.world
    spin = state.spin
    room = state.room
    slope = state.slope_of_room
    label = state.label
    stops = rows.shape[0]
    count = span[1] - span[0]
    state.used[0] = stops + count
    for r in range(stops + count):
        for i in range(slope.shape[1]):
            slope[r, i] = 0.0
    for r in range(stops):
        k = rows[r, 0]
        axis = rows[r, 1]
        side = rows[r, 2]
        label[r, 0] = k
        label[r, 1] = axis
        label[r, 2] = side
        if axis < SIDE_ROWS:
            limit, c, rate = _limit(bounds, angles, k, axis, side)
            sign = 1.0 - 2.0 * side
            room[r] = limit - sign * angles[k, axis]
            slope[r, free_of[k, axis]] = -sign
            if c >= 0 and free_of[int(coupling[c, 0]), int(coupling[c, 1])] >= 0:
                slope[r, free_of[int(coupling[c, 0]), int(coupling[c, 1])]] += rate
        elif axis == WHOLE_CONE:
            _cone(bounds, angles, k, state.held, (room, slope, label, r))
        elif axis == WHOLE_POLYGON:
            shape = (link.sides, link.limb, link.axes, k, link.polygon_link)
            _polygon(shape, world, spin, link.free_joint, state.held, (room, slope, label, r))
        else:
            _half_turn(angles, free_of, k, (room, slope, label, r))
    walls = (planes.link, planes.point, planes.normal, planes.offset)
    for m in range(count):
        r = stops + m
        label[r, 0] = -1
        label[r, 1] = m
        label[r, 2] = 0
        _wall(
            walls,
            span[0] + m,
            (world, spin, link.free_joint, state.pivot),
            (room, slope, state.held, r),
        )


@inlined
def within(link, angles):  # type: ignore[no-untyped-def]
    """Bring free angles (K, 3) inside cones, hinges and twist limits, in place: cones along the ray
    from zero."""
    bounds = (link.limits, link.coupled, link.coupling, link.free_of)
    for twist in range(2):  # twists follow swings, so they come second
        for r in range(link.rows.shape[0]):
            k = link.rows[r, 0]
            axis = link.rows[r, 1]
            if axis == WHOLE_CONE and twist == 0:
                s0 = angles[k, 0]
                s1 = angles[k, 1]
                l0 = max(_limit(bounds, angles, k, 0, 0 if s0 >= 0 else 1)[0], LEAST)
                l1 = max(_limit(bounds, angles, k, 1, 0 if s1 >= 0 else 1)[0], LEAST)
                root = math.sqrt((s0 / l0) ** 2 + (s1 / l1) ** 2)
                if root > 1.0:
                    angles[k, 0] = s0 / root
                    angles[k, 1] = s1 / root
            elif axis < SIDE_ROWS and (axis == 2) == (twist == 1):
                limit = _limit(bounds, angles, k, axis, link.rows[r, 2])[0]
                if link.rows[r, 2] == 0:
                    angles[k, axis] = min(angles[k, axis], limit)
                else:
                    angles[k, axis] = max(angles[k, axis], -limit)
