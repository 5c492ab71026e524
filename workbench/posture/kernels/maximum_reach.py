"""Maximum reach along a ray: how far out the tip of a chain comes, held to the ray.

Each row is solved in the frame of its ray, whose x axis runs along it. The tip is pushed along x
and held to y = z = 0 until stops and the length of the chain hold it (`augmented_lagrangian.extend`). If the
row may be able to reach the far end that was asked for, the tip is brought there instead
(`augmented_lagrangian.minimize`). A row starts at a solution near by, then at its own start.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.geometry.vectors import cross, dot, matvec, store, transpose_matvec, vector
from workbench.posture.kernels.augmented_lagrangian import (
    ON_RAY,
    REACHED,
    evaluate,
    extend,
    minimize,
    put_row,
    take,
    take_row,
)
from workbench.posture.kernels.chain_kinematics import ChainState, Linkage, new_state
from workbench.posture.kernels.inequality_constraints import clamp_angles
from workbench.posture.kernels.inverse_kinematics import LEGAL, greatest_breach
from workbench.posture.kernels.newton_step import DescentWorkspace, new_work

__all__ = ["Extents", "GuideRows", "RayWorkspace", "new_ray_workspace", "reach_outward"]

Floats = NDArray[np.float64]

OFF_RAY = 2.0 * ON_RAY
"""Distance [m] from its ray at which a posture does not count."""
MOST_WARM = 12
"""Steps of a descent from a solution near by at most."""


class GuideRows(NamedTuple):
    """What the guides of P rows have come to: solutions near by."""

    angles: Floats
    """(P, K, 3) [rad] their postures."""
    held: Floats
    """(P, 6 + R) multipliers of the ray, in the axes of base and rays, and of the R stops."""
    ways: Floats
    """(P,) [m] how far they came beyond the point, minus infinity for a row without a guide."""


class Extents(NamedTuple):
    """How far P chains reach along their rays, filled in place."""

    angles: Floats
    """(P, K, 3) [rad] starts that reach the points in, the postures at the far ends out."""
    held: Floats
    """(P, 6 + R) multipliers of the ray, in the axes of base and rays, and of the R stops."""
    ways: Floats
    """(P,) [m] how far beyond the point: the most that was asked for if that is reached, minus
    infinity if nothing on the ray was."""
    steps: NDArray[np.int64]
    """(P,) steps that were tried."""


class _Ray(NamedTuple):
    """One ray as the x axis of a frame of its own."""

    turn: Floats
    """(3, 3) rotation from the axes of base and rays to the frame: its rows are the axes of the frame."""
    base: Floats
    """(1, 3, 4) [m] frame-from-base transform."""
    goal: Floats
    """(1, 12) the point, and weights that hold y and z."""
    end: Floats
    """(1, 12) the far end that was asked for, and weights that hold x, y and z."""


class RayWorkspace(NamedTuple):
    """Working arrays of one row at a time."""

    ray: _Ray
    state: ChainState
    work: DescentWorkspace
    best: Floats
    """(K, 3) [rad] the posture that came farthest."""


def new_ray_workspace(link: Linkage) -> RayWorkspace:
    """Make working arrays for a chain without planes."""
    joints = link.axes.shape[0]
    free = link.mode.shape[0]
    stops = link.rows.shape[0]
    ray = _Ray(np.zeros((3, 3)), np.zeros((1, 3, 4)), np.zeros((1, 12)), np.zeros((1, 12)))
    state = new_state(joints, free, stops)
    return RayWorkspace(ray, state, new_work(joints, free, stops), np.zeros((joints, 3)))


@inlined
def _square_to(x, y, z):  # type: ignore[no-untyped-def]
    """Unit vector square to (x, y, z) and to the axis of the world that it is farthest from."""
    u, v, w = (0.0, z, -y) if abs(x) <= abs(y) and abs(x) <= abs(z) else (-z, 0.0, x)
    if abs(z) < abs(x) and abs(z) < abs(y):
        u = y
        v = -x
        w = 0.0
    size = math.sqrt(u * u + v * v + w * w)
    return u / size, v / size, w / size


@inner
def _begin_ray(rays, p, base, far, ray):  # type: ignore[no-untyped-def]
    """Fill a frame whose x axis is rays[p], with base[p], the point and the far end in it."""
    first = vector(rays[p, 3:])
    second = _square_to(first[0], first[1], first[2])
    store(first, ray.turn[0])
    store(second, ray.turn[1])
    store(cross(first, second), ray.turn[2])
    for i in range(3):
        a, b, c = vector(ray.turn[i])
        for m in range(4):
            ray.base[0, i, m] = a * base[p, 0, m] + b * base[p, 1, m] + c * base[p, 2, m]
        ray.goal[0, i] = dot((a, b, c), vector(rays[p]))
        ray.goal[0, 6 + i] = 1.0 if i > 0 else 0.0
        ray.end[0, i] = ray.goal[0, i]
        ray.end[0, 6 + i] = 1.0
    ray.end[0, 0] += far


@inlined
def _axes(turn):  # type: ignore[no-untyped-def]
    """Read a rotation (3, 3) as nine numbers."""
    a, b, c = vector(turn[0]), vector(turn[1]), vector(turn[2])
    return a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]


@inner
def _begin_guided(link, p, near, workspace):  # type: ignore[no-untyped-def]
    """Start at the guide of row p, with its multipliers, those of the ray turned into its frame."""
    work = workspace.work
    take_row(near.angles, p, workspace.state.angles)
    store(matvec(_axes(workspace.ray.turn), vector(near.held[p])), work.pushed)
    store((0.0, 0.0, 0.0), work.pushed[3:])
    for i in range(link.rows.shape[0]):
        work.press[i] = near.held[p, 6 + i]


@inner
def _begin_alone(link, p, angles, workspace):  # type: ignore[no-untyped-def]
    """Start at angles[p], without multipliers."""
    take_row(angles, p, workspace.state.angles)
    workspace.work.pushed[:] = 0.0
    workspace.work.press[:] = 0.0


@inlined
def _keep(link, p, way, out, workspace):  # type: ignore[no-untyped-def]
    """Keep a posture that came farthest, with its multipliers."""
    work = workspace.work
    out.ways[p] = way
    take(workspace.state.angles, workspace.best)
    store(transpose_matvec(_axes(workspace.ray.turn), vector(work.pushed)), out.held[p])
    for i in range(link.rows.shape[0]):
        out.held[p, 6 + i] = work.press[i]


@inner
def _attempt(link, b, p, planes, most, far, to_end, warm, out, workspace):  # type: ignore[no-untyped-def]
    """Bring row p from a state to the far end of its ray, or as far as it goes; keep what is better.

    Returns whether it came to rest there.
    """
    ray = workspace.ray
    state = workspace.state
    work = workspace.work
    if to_end:
        steps, _ = minimize(
            link, b, (ray.base, ray.end), 0, planes, (0, 0), most, warm, state, work
        )
        rested = False
    else:
        steps, rested = extend(
            link, b, (ray.base, ray.goal), 0, planes, (0, 0), most, warm, state, work
        )
    out.steps[p] += steps
    clamp_angles(link, state.angles)
    evaluate(link, b, ray.base, 0, planes, (0, 0), state)
    way = state.at[0] - ray.goal[0, 0]
    if to_end:
        rested = abs(way - far) < REACHED
        way = far if rested else way
    off = math.sqrt((state.at[1] - ray.goal[0, 1]) ** 2 + (state.at[2] - ray.goal[0, 2]) ** 2)
    if off < OFF_RAY and greatest_breach(state) < LEGAL and way > out.ways[p]:
        _keep(link, p, way, out, workspace)
        return rested
    return False


@inner
def _extend_row(link, b, p, planes, far, most, near, out, workspace):  # type: ignore[no-untyped-def]
    """Extend row p in up to four attempts, until one comes to rest.

    The first does what the guide could do, reach the far end or not, and the second the other. The
    last two do both from the row's own start.
    """
    came = near.ways[p]
    out.ways[p] = -np.inf
    take_row(out.angles, p, workspace.best)
    for attempt in range(0 if came > -np.inf else 2, 4):
        guided = attempt < 2
        to_end = (came == far) == (attempt == 0) if guided else attempt == 2
        if attempt == 1 and not to_end and out.ways[p] > -np.inf:
            continue
        if guided:
            _begin_guided(link, p, near, workspace)
        else:
            _begin_alone(link, p, out.angles, workspace)
        steps = min(MOST_WARM, most) if guided else most
        if _attempt(link, b, p, planes, steps, far, to_end, guided, out, workspace):
            break
    put_row(workspace.best, out.angles, p)


@batch_loop
def reach_outward(link, who, base, rays, planes, far, most, near, out, begin, end, workspace):  # type: ignore[no-untyped-def]
    """Extend the chains of rows begin..end - 1 of P along their rays, each by itself.

    Parameters
    ----------
    link : Linkage
        The chain of B bodies.
    who : (P,)
        Row of the body of each chain.
    base : (P, 3, 4)
        Transforms [m] from the held links to the axes of the rays.
    rays : (P, 6)
        A point [m] and a unit direction each.
    planes : Planes
        No planes.
    far : float
        How far [m] to go beyond the points.
    most : int
        Steps of an attempt at most.
    near : Guides
        Solutions near by.
    out : Extents
        Filled.
    begin, end : int
        Rows to solve.
    workspace : RayWorkspace
        Working arrays.
    """
    for p in range(begin, end):
        _begin_ray(rays, p, base, far, workspace.ray)
        _extend_row(link, who[p], p, planes, far, most, near, out, workspace)
