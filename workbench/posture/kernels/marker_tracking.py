"""Joint angles from markers: weighted least squares on the whole chain, frame after frame [1]_.

A step is that of Gauss and Newton on the rotation vectors of all joints, and on the rotation and the
position of the placed segment. Each joint is drawn to its neutral angles a little, so that what no
marker sees stays defined. A joint past a stop is drawn back by a stiff quadratic penalty. A step that
raises the weighted sum of squares is halved.

References
----------
.. [1] T. W. Lu and J. J. O'Connor (1999), Bone position estimation from skin marker co-ordinates
   using global optimisation with joint constraints, Journal of Biomechanics 32, 129-134.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.rotation import product, quaternion_matrix, swing_twist_angles
from workbench.compiled import inlined, inner, njit
from workbench.geometry.vectors import (
    add,
    matvec,
    norm,
    quaternion,
    quaternion_product,
    rotation_part,
    scale,
    store,
    subtract,
    transpose_matvec,
    vector,
)
from workbench.posture.kernels.cholesky import LEAST_PIVOT, factorise, substitute
from workbench.posture.kernels.limit_violation import StopPack, past_stops

__all__ = ["MarkerChain", "solve_markers"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_FRAME_STEPS = 20
"""Steps of a frame at most; of the first five times as many."""
_LEAST_GAIN = 1e-6
"""Share of the cost that a step saves at least; with less a frame is solved."""
_HALVINGS = 6
"""Shares of a step that are tried."""
_MOST_TURN = 0.6
"""Largest turn [rad] of a joint in one step."""
_CLOSE = 1e-5
"""Largest turn [rad] or move [m] of a step at which a frame is solved."""
_DEEPEST = 16
"""Blocks of a marker at most: the joints that carry it, and the placed segment's two."""
_REGULAR = 1e-6
"""What the diagonal of the normal equations has at least."""
_NUDGE = 1e-6
"""Turn [rad] by which the derivatives of joint angles are taken."""

_STOP_WEIGHT = 100.0
"""Weight [1/rad] of the excess past a stop: 0.6 degrees cost as much as a marker one unit off."""
_LEAST_EXCESS = 1e-9
"""Excess [rad] past a stop below which it is rounding."""


class MarkerChain(NamedTuple):
    """A body as a tree of K segments below its placed segment, with M markers on it."""

    parent: Ints
    """(K,) segment that each segment hangs on; 0 is the placed one."""
    at_parent: Floats
    """(K, 3) [m] the joint above each segment, in the frame of its parent."""
    at_child: Floats
    """(K, 3) [m] the same in the segment's own frame."""
    axes: Floats
    """(K, 3, 3) two swing axes and the twist axis of each joint."""
    half: Floats
    """(K, 3) [rad] the angle that costs as much as a marker one unit off."""
    marker_segment: Ints
    """(M,) segment of each marker."""
    local: Floats
    """(M, 3) [m] the marker in that segment's frame."""
    weight: Floats
    """(M,) [1/m]."""
    joint: Ints
    """(K,) index in `stops` of the joint above each segment."""
    stops: StopPack
    """Stops of all J joints of the body."""


class _Workspace(NamedTuple):
    """Working arrays of a frame. Unknown block 0 turns the placed segment, k joint k, K moves it."""

    world: Floats
    """(K, 3, 4) [m] segments."""
    joint: Floats
    """(K, 3) [m] centres of the joints; row 0 is the origin of the placed segment."""
    matrix: Floats
    """(3 K + 3, 3 K + 3) normal equations."""
    right: Floats
    """(3 K + 3,) their right side, then the step."""
    path: Ints
    """(16,) blocks that move a marker."""
    blocks: Floats
    """(16, 3, 3) derivatives of its residual by these."""
    gap: Floats
    """(3,) a residual."""
    turns: Floats
    """(J, 4) rotations of all joints of the body."""
    angles: Floats
    """(J, 3) [rad] their angles."""
    limits: Floats
    """(J, 3, 2) [rad] their limits."""
    past: Floats
    """(J, 3) [rad] their excess past the stops."""
    saved: Floats
    """(K + 4, 4) rotations of the joints, the placed segment's rotation and its frame."""


@inlined
def _turned(q, x):  # type: ignore[no-untyped-def]
    """Turn a quaternion further by a rotation vector in the outer frame; of unit length."""
    angle = norm(x)
    s = 0.5 - angle * angle / 48.0 if angle < 1e-4 else math.sin(0.5 * angle) / angle
    turn = (math.cos(0.5 * angle), s * x[0], s * x[1], s * x[2])
    w, a, b, c = quaternion_product(turn, q)
    size = math.sqrt(w**2 + a**2 + b**2 + c**2)
    return w / size, a / size, b / size, c / size


@inlined
def _store_quaternion(q, out):  # type: ignore[no-untyped-def]
    """Write a quaternion into an array (4,)."""
    for i in range(4):
        out[i] = q[i]


@inner
def _place_chain(rotations, place, chain, workspace):  # type: ignore[no-untyped-def]
    """Place the segments at joint rotations (K, 4), the placed one at place (3, 4).

    With the joint at u in the parent's and v in the segment's frame: R' = R Q, p' = p + R u - R' v.
    """
    world = workspace.world
    for i in range(3):
        workspace.joint[0, i] = place[i, 3]
        for j in range(4):
            world[0, i, j] = place[i, j]
    for k in range(1, chain.parent.shape[0]):
        above = world[chain.parent[k]]
        parent = rotation_part(above)
        q = rotations[k]
        child = product(parent, quaternion_matrix(q[0], q[1], q[2], q[3]))
        u = vector(chain.at_parent[k])
        v = matvec(child, vector(chain.at_child[k]))
        for i in range(3):
            workspace.joint[k, i] = (
                above[i, 3] + above[i, 0] * u[0] + above[i, 1] * u[1] + above[i, 2] * u[2]
            )
            for j in range(3):
                world[k, i, j] = child[3 * i + j]
            world[k, i, 3] = workspace.joint[k, i] - v[i]


@inlined
def _marker_position(frame, local):  # type: ignore[no-untyped-def]
    """Position of a point (3,) [m] of a segment whose frame is (3, 4)."""
    out = (frame[0, 3], frame[1, 3], frame[2, 3])
    for j in range(3):
        out = add(out, scale(local[j], (frame[0, j], frame[1, j], frame[2, j])))
    return out


@inner
def _add_blocks(matrix, right, at, other, one, two, gap):  # type: ignore[no-untyped-def]
    """Add one' two to block (at, other) of the normal matrix, and one' gap where both are the same."""
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += one[k, i] * two[k, j]
            matrix[3 * at + i, 3 * other + j] += total
        if at == other:
            for k in range(3):
                right[3 * at + i] += one[k, i] * gap[k]


@inlined
def _fill_cross_matrix(arm, block):  # type: ignore[no-untyped-def]
    """Fill a block (3, 3) with what a turn does to the end of an arm: -[arm], so that ω x arm."""
    x, y, z = arm
    store((0.0, z, -y), block[0])
    store((-z, 0.0, x), block[1])
    store((y, -x, 0.0), block[2])


@inner
def _fill_path(position, segment, weight, chain, workspace):  # type: ignore[no-untyped-def]
    """Fill path and blocks of a marker: all that turns it, and what moves it; returns how many."""
    length = 0
    k = segment
    while True:
        arm = scale(weight, subtract(position, vector(workspace.joint[k])))
        workspace.path[length] = k
        _fill_cross_matrix(arm, workspace.blocks[length])
        length += 1
        if k == 0:
            break
        k = chain.parent[k]
    workspace.path[length] = chain.parent.shape[0]
    for i in range(3):
        for j in range(3):
            workspace.blocks[length, i, j] = weight if i == j else 0.0
    return length + 1


@inner
def _add_markers(seen, chain, workspace):  # type: ignore[no-untyped-def]
    """Add the normal equations of the markers that were seen (M, 3)."""
    path = workspace.path
    blocks = workspace.blocks
    for m in range(seen.shape[0]):
        if not np.isfinite(seen[m, 0]):
            continue
        segment = chain.marker_segment[m]
        weight = chain.weight[m]
        position = _marker_position(workspace.world[segment], chain.local[m])
        store(scale(weight, subtract(vector(seen[m]), position)), workspace.gap)
        count = _fill_path(position, segment, weight, chain, workspace)
        for a in range(count):
            for b in range(count):
                _add_blocks(
                    workspace.matrix,
                    workspace.right,
                    path[a],
                    path[b],
                    blocks[a],
                    blocks[b],
                    workspace.gap,
                )


@inner
def _add_joints(rotations, chain, workspace):  # type: ignore[no-untyped-def]
    """Add the normal equations of the pull of each joint to its neutral angles, by differences."""
    block = workspace.blocks[0]
    gap = workspace.gap
    for k in range(1, chain.parent.shape[0]):
        q = quaternion(rotations[k])
        parent = workspace.world[chain.parent[k]]
        half = vector(chain.half[k])
        now = swing_twist_angles(q, chain.axes[k])
        for j in range(3):
            # a turn about an axis of the world, in the parent's frame
            nudge = scale(_NUDGE, vector(parent[j]))
            slope = scale(
                1.0 / _NUDGE, subtract(swing_twist_angles(_turned(q, nudge), chain.axes[k]), now)
            )
            for i in range(3):
                block[i, j] = slope[i] / half[i]
        for i in range(3):
            gap[i] = -now[i] / half[i]
        _add_blocks(workspace.matrix, workspace.right, k, k, block, block, gap)


@inner
def _measure_stops(rotations, chain, workspace):  # type: ignore[no-untyped-def]
    """Fill the angles of all joints and their excess past the stops."""
    for k in range(1, chain.parent.shape[0]):
        for i in range(4):
            workspace.turns[chain.joint[k], i] = rotations[k, i]
    past_stops(workspace.turns, chain.stops, workspace.angles, workspace.limits, workspace.past)


@inner
def _cost(seen, rotations, chain, workspace):  # type: ignore[no-untyped-def]
    """Sum of the weighted squares of all residuals of placed segments; measures the stops."""
    total = 0.0
    for m in range(seen.shape[0]):
        if np.isfinite(seen[m, 0]):
            frame = workspace.world[chain.marker_segment[m]]
            gap = subtract(vector(seen[m]), _marker_position(frame, chain.local[m]))
            total += (chain.weight[m] * norm(gap)) ** 2
    _measure_stops(rotations, chain, workspace)
    for k in range(1, chain.parent.shape[0]):
        j = chain.joint[k]
        for i in range(3):
            total += (workspace.angles[j, i] / chain.half[k, i]) ** 2
            total += (_STOP_WEIGHT * workspace.past[j, i]) ** 2
    return total


@inner
def _add_stops(rotations, chain, workspace):  # type: ignore[no-untyped-def]
    """Add the normal equations that draw each joint back from beyond its stops.

    With the excess e n in the frame of the segment R, a turn w of the joint in the world changes e
    by (R n) . w.
    """
    _measure_stops(rotations, chain, workspace)
    for k in range(1, chain.parent.shape[0]):
        excess = vector(workspace.past[chain.joint[k]])
        size = norm(excess)
        if size < _LEAST_EXCESS:
            continue
        direction = scale(1.0 / size, matvec(rotation_part(workspace.world[k]), excess))
        for i in range(3):
            workspace.right[3 * k + i] -= _STOP_WEIGHT**2 * size * direction[i]
            for j in range(3):
                workspace.matrix[3 * k + i, 3 * k + j] += (
                    _STOP_WEIGHT**2 * direction[i] * direction[j]
                )


@inner
def _advance(rotations, turn, place, share, chain, workspace):  # type: ignore[no-untyped-def]
    """Turn and move everything by a share of the step.

    Returns the largest turn [rad] or move [m].
    """
    count = chain.parent.shape[0]
    most = 0.0
    for k in range(count + 1):
        step = scale(share, vector(workspace.right[3 * k :]))
        size = norm(step)
        most = max(most, size)
        if k == count:
            for i in range(3):
                place[i, 3] += step[i]
            break
        if size > _MOST_TURN:
            x, y, z = scale(_MOST_TURN, step)
            step = (x / size, y / size, z / size)
        if k == 0:
            _store_quaternion(_turned(quaternion(turn), step), turn)
        else:
            parent = rotation_part(workspace.world[chain.parent[k]])
            own = transpose_matvec(parent, step)
            _store_quaternion(_turned(quaternion(rotations[k]), own), rotations[k])
    r = quaternion_matrix(turn[0], turn[1], turn[2], turn[3])
    for i in range(3):
        for j in range(3):
            place[i, j] = r[3 * i + j]
    return most


@inner
def _save(rotations, turn, place, saved):  # type: ignore[no-untyped-def]
    """Keep a pose."""
    count = rotations.shape[0]
    for i in range(4):
        for k in range(count):
            saved[k, i] = rotations[k, i]
        saved[count, i] = turn[i]
        for j in range(3):
            saved[count + 1 + j, i] = place[j, i]


@inner
def _restore(saved, rotations, turn, place):  # type: ignore[no-untyped-def]
    """Return to the pose that was kept."""
    count = rotations.shape[0]
    for i in range(4):
        for k in range(count):
            rotations[k, i] = saved[k, i]
        turn[i] = saved[count, i]
        for j in range(3):
            place[j, i] = saved[count + 1 + j, i]


@inner
def _descend(cost, seen, chain, rotations, turn, place, workspace):  # type: ignore[no-untyped-def]
    """Take the step, or the half, a quarter and so forth of it that does not raise the cost.

    Returns the cost, and the largest turn [rad] or move [m], 0 where no share of the step is taken.
    """
    _save(rotations, turn, place, workspace.saved)
    share = 1.0
    for _ in range(_HALVINGS):
        moved = _advance(rotations, turn, place, share, chain, workspace)
        _place_chain(rotations, place, chain, workspace)
        now = _cost(seen, rotations, chain, workspace)
        if now <= cost:
            return now, moved
        _restore(workspace.saved, rotations, turn, place)
        _place_chain(rotations, place, chain, workspace)
        share *= 0.5
    return cost, 0.0


@inner
def _solve_frame(seen, chain, rotations, turn, place, steps, workspace):  # type: ignore[no-untyped-def]
    """Fit one frame from where it stands, in so many steps at most."""
    _place_chain(rotations, place, chain, workspace)
    cost = _cost(seen, rotations, chain, workspace)
    for _ in range(steps):
        workspace.matrix[:] = 0.0
        workspace.right[:] = 0.0
        for i in range(workspace.right.shape[0]):
            workspace.matrix[i, i] = _REGULAR
        _add_markers(seen, chain, workspace)
        _add_joints(rotations, chain, workspace)
        _add_stops(rotations, chain, workspace)
        factorise(workspace.matrix, LEAST_PIVOT)
        substitute(workspace.matrix, workspace.right, workspace.right)
        before = cost
        cost, moved = _descend(cost, seen, chain, rotations, turn, place, workspace)
        if moved < _CLOSE or before - cost <= _LEAST_GAIN * cost:
            break


@njit(cache=True, nogil=True)
def solve_markers(seen, chain, rotations, turns, places, modelled):  # type: ignore[no-untyped-def]
    """Fit a body to the markers of P frames.

    Parameters
    ----------
    seen : (P, M, 3)
        Markers [m], NaN where one was not seen.
    chain : MarkerChain
        The body.
    rotations : (P, K, 4)
        Filled with joint rotations. The first frame starts from what the arrays hold, every other
        from the one before it.
    turns, places : (P, 4), (P, 3, 4)
        Filled with the rotation of the placed segment, and its frame [m].
    modelled : (P, M, 3)
        Filled with the markers where the body has them [m].
    """
    count = chain.parent.shape[0]
    size = 3 * (count + 1)
    joints = chain.stops.kind.shape[0]
    workspace = _Workspace(
        np.empty((count, 3, 4)),
        np.zeros((count, 3)),
        np.zeros((size, size)),
        np.zeros(size),
        np.empty(_DEEPEST, np.int64),
        np.empty((_DEEPEST, 3, 3)),
        np.empty(3),
        np.zeros((joints, 4)),
        np.empty((joints, 3)),
        np.empty((joints, 3, 2)),
        np.empty((joints, 3)),
        np.empty((count + 4, 4)),
    )
    workspace.turns[:, 0] = 1.0
    for p in range(seen.shape[0]):
        if p:
            rotations[p] = rotations[p - 1]
            turns[p] = turns[p - 1]
            places[p] = places[p - 1]
        steps = _FRAME_STEPS if p else 5 * _FRAME_STEPS
        _solve_frame(seen[p], chain, rotations[p], turns[p], places[p], steps, workspace)
        for m in range(seen.shape[1]):
            frame = workspace.world[chain.marker_segment[m]]
            store(_marker_position(frame, chain.local[m]), modelled[p, m])
