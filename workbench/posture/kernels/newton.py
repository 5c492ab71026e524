"""One damped Newton step of a chain toward the least of a sum, held by stops and planes with
multipliers.

The stops and planes that hold a step are found by turns; they count by the method of multipliers
(augmented Lagrangian; Nocedal & Wright 2006, Numerical Optimization, chapter 17).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import inlined, inner, njit
from workbench.posture.kernels.limits import WHOLE_CONE, WHOLE_POLYGON

__all__ = ["HOLD", "INSIDE", "Work", "back", "equations", "go", "multiply", "new_work", "newton"]

HOLD = 1e5
"""Weight [1/rad2, 1/m2] of a breach of a stop or plane."""
INSIDE = 1e-6
"""How far [rad, m] inside a stop a solution is brought, so that rounding does not put it past."""
UNSURE = 30.0
"""How hard [1/rad, 1/m] at most a stop is taken to hold more than its multiplier says, in its
curvature."""
MOST_STEP = 0.6
MOST_TURNS = 6


class Work(NamedTuple):
    """Working space of a descent: matrix, whole (n, n), right, side, step (n,), active (R,), force,
    pushed (6,), press (R,), kept (K, 3), bend (6,): the pull in the curvature."""

    matrix: NDArray[np.float64]
    whole: NDArray[np.float64]
    right: NDArray[np.float64]
    side: NDArray[np.float64]
    step: NDArray[np.float64]
    active: NDArray[np.int64]
    force: NDArray[np.float64]
    pushed: NDArray[np.float64]
    press: NDArray[np.float64]
    kept: NDArray[np.float64]
    bend: NDArray[np.float64]


@njit(cache=True)
def new_work(joints, free, rows):  # type: ignore[no-untyped-def]
    """An empty working space."""
    return Work(
        np.zeros((free, free)),
        np.zeros((free, free)),
        np.zeros(free),
        np.zeros(free),
        np.zeros(free),
        np.zeros(rows, np.int64),
        np.zeros(6),
        np.zeros(6),
        np.zeros(rows),
        np.zeros((joints, 3)),
        np.zeros(6),
    )


@njit(cache=True, error_model="numpy", _nrt=False)
def equations(link, goal, p, state, work, pull, ease, bent):  # type: ignore[no-untyped-def]
    """Normal equations of the step without the stops: matrix (n, n), lower triangle, and right side
    (n,). The second derivative of a turn after a turn is the cross product of the outer rate of
    turn with the inner slope; it counts times work.bend (6,), the force that will hold the tip and
    its direction."""
    n = link.mode.shape[0]
    f = work.force
    directed = goal[p, 9] > 0.0
    for i in range(n):
        off = link.mode[i] - state.angles[link.free_joint[i], link.free_axis[i]]
        right = ease * link.weight[i] * off
        for c in range(3):
            right += state.slope[i, c] * f[c]
        if directed:
            for c in range(3, 6):
                right += state.slope[i, c] * f[c]
        work.right[i] = right
    f = work.bend
    tilt = pull * goal[p, 9] * goal[p, 9]
    p0 = pull * goal[p, 6] ** 2
    p1 = pull * goal[p, 7] ** 2
    p2 = pull * goal[p, 8] ** 2
    for j in range(n):  # free angles run outward from the held link, so j is the outer one
        t0 = p0 * state.slope[j, 0]
        t1 = p1 * state.slope[j, 1]
        t2 = p2 * state.slope[j, 2]
        w0 = state.spin[j, 0]
        w1 = state.spin[j, 1]
        w2 = state.spin[j, 2]
        if bent:
            t0 = t0 - f[1] * w2 + f[2] * w1
            t1 = t1 - f[2] * w0 + f[0] * w2
            t2 = t2 - f[0] * w1 + f[1] * w0
        for i in range(j, n):
            work.matrix[i, j] = (
                state.slope[i, 0] * t0 + state.slope[i, 1] * t1 + state.slope[i, 2] * t2
            )
        if directed:
            t0 = tilt * state.slope[j, 3]
            t1 = tilt * state.slope[j, 4]
            t2 = tilt * state.slope[j, 5]
            if bent:
                t0 = t0 - f[4] * w2 + f[5] * w1
                t1 = t1 - f[5] * w0 + f[3] * w2
                t2 = t2 - f[3] * w1 + f[4] * w0
            for i in range(j, n):
                work.matrix[i, j] += (
                    state.slope[i, 3] * t0 + state.slope[i, 4] * t1 + state.slope[i, 5] * t2
                )
        work.matrix[j, j] += ease * link.weight[j]
    if bent:
        point = (state.at[0], state.at[1], state.at[2])
        force = (f[0], f[1], f[2])
        _swings(link, state, work.matrix, (0, link.axes.shape[0]), point, True, force)
        if directed:
            point = (state.at[3], state.at[4], state.at[5])
            force = (f[3], f[4], f[5])
            _swings(link, state, work.matrix, (0, link.axes.shape[0]), point, False, force)
        _bend_of_stops(link, state, work)


@inlined
def _swings(link, state, matrix, span, point, fixed, force):  # type: ignore[no-untyped-def]
    """Less the second derivatives, times a force, of a point (of a direction where not fixed) by
    swings of one and the same joint, as far as a turn after a turn does not make them. Of the
    joints span[0]..span[1]."""
    free_of = link.free_of
    pivot = state.pivot
    bend = state.bend
    for k in range(span[0], span[1]):
        j = free_of[k, 0]
        i = free_of[k, 1]
        if j < 0 or i < 0:
            continue
        x, y, z = point
        if fixed:
            x = x - pivot[k, 0]
            y = y - pivot[k, 1]
            z = z - pivot[k, 2]
        u = y * force[2] - z * force[1]
        v = z * force[0] - x * force[2]
        w = x * force[1] - y * force[0]
        matrix[j, j] -= bend[k, 0, 0] * u + bend[k, 0, 1] * v + bend[k, 0, 2] * w
        matrix[i, j] -= bend[k, 1, 0] * u + bend[k, 1, 1] * v + bend[k, 1, 2] * w
        matrix[i, i] -= bend[k, 2, 0] * u + bend[k, 2, 1] * v + bend[k, 2, 2] * w


@inlined
def _turns(link, state, matrix, span, point, fixed, force):  # type: ignore[no-untyped-def]
    """Less the second derivatives, times a force, of a point (of a direction where not fixed) by
    turns of the joints span[0]..span[1]."""
    joint = link.free_joint
    spin = state.spin
    pivot = state.pivot
    f0, f1, f2 = force
    for i in range(joint.shape[0]):
        k = joint[i]
        if k < span[0] or k >= span[1]:
            continue
        x, y, z = point
        if fixed:
            x = x - pivot[k, 0]
            y = y - pivot[k, 1]
            z = z - pivot[k, 2]
        s0 = spin[i, 1] * z - spin[i, 2] * y
        s1 = spin[i, 2] * x - spin[i, 0] * z
        s2 = spin[i, 0] * y - spin[i, 1] * x
        # force . (outer x slope) = outer . (slope x force)
        s0, s1, s2 = s1 * f2 - s2 * f1, s2 * f0 - s0 * f2, s0 * f1 - s1 * f0
        for j in range(i + 1):
            if joint[j] >= span[0]:
                matrix[i, j] -= spin[j, 0] * s0 + spin[j, 1] * s1 + spin[j, 2] * s2
    _swings(link, state, matrix, span, point, fixed, force)


@inner
def _bend_of_stops(link, state, work):  # type: ignore[no-untyped-def]
    """The curvature of cones, polygon and planes that hold, times what they hold with. Of one that
    only just holds, what it will hold with is not known yet: it counts little, since much of it
    would bend too much."""
    matrix = work.matrix
    press = work.press
    held = state.held
    for r in range(state.used[0]):
        push = min(press[r] + HOLD * (INSIDE - state.room[r]), press[r] + UNSURE)
        if not push > 0.0:
            continue
        plane = r >= link.rows.shape[0]
        if plane or link.rows[r, 1] == WHOLE_POLYGON:
            first, last = (
                (0, int(held[r, 6])) if plane else (link.polygon_link, link.rows[r, 0] + 1)
            )
            force = (push * held[r, 3], push * held[r, 4], push * held[r, 5])
            _turns(
                link,
                state,
                matrix,
                (first, last),
                (held[r, 0], held[r, 1], held[r, 2]),
                plane,
                force,
            )
        elif link.rows[r, 1] == WHOLE_CONE:
            k = link.rows[r, 0]
            j = link.free_of[k, 0]
            i = link.free_of[k, 1]
            if j >= 0 and i >= 0:
                matrix[j, j] += push * held[r, 0]
                matrix[i, j] += push * held[r, 1]
                matrix[i, i] += push * held[r, 2]


@inlined
def _cholesky(matrix, right, step):  # type: ignore[no-untyped-def]
    """Solve by Cholesky's factors of the lower triangle, in place; False where it is not
    positive."""
    n = right.shape[0]
    for j in range(n):
        value = matrix[j, j]
        for m in range(j):
            value -= matrix[j, m] * matrix[j, m]
        if not value > 1e-9:
            return False
        matrix[j, j] = 1.0 / math.sqrt(value)
        for i in range(j + 1, n):
            value = matrix[i, j]
            for m in range(j):
                value -= matrix[i, m] * matrix[j, m]
            matrix[i, j] = value * matrix[j, j]
    for i in range(n):
        value = right[i]
        for m in range(i):
            value -= matrix[i, m] * step[m]
        step[i] = value * matrix[i, i]
    for i in range(n - 1, -1, -1):
        value = step[i]
        for m in range(i + 1, n):
            value -= matrix[m, i] * step[m]
        step[i] = value * matrix[i, i]
    return True


@inner
def newton(link, state, work, damping):  # type: ignore[no-untyped-def]
    """The damped step, with the stops that hold it found by turns; False where the equations are
    not positive."""
    n = link.mode.shape[0]
    slope = state.slope_of_room
    press = work.press
    active = work.active
    for r in range(state.used[0]):
        active[r] = 1 if press[r] + HOLD * (INSIDE - state.room[r]) > 0.0 else 0
    for _ in range(MOST_TURNS):
        for i in range(n):
            work.side[i] = work.right[i]
            for j in range(i + 1):
                work.whole[i, j] = work.matrix[i, j]
            work.whole[i, i] += damping * link.weight[i]
        for r in range(state.used[0]):
            if active[r]:
                push = press[r] + HOLD * (INSIDE - state.room[r])
                for i in range(n):
                    g = slope[r, i]
                    if g != 0.0:
                        work.side[i] += push * g
                        for j in range(i + 1):
                            work.whole[i, j] += HOLD * g * slope[r, j]
        if not _cholesky(work.whole, work.side, work.step):
            return False
        changed = False
        for r in range(state.used[0]):
            after = state.room[r] - INSIDE
            for i in range(n):
                after += slope[r, i] * work.step[i]
            holds = 1 if press[r] - HOLD * after > 0.0 else 0
            if holds != active[r]:
                active[r] = holds
                changed = True
        if not changed:
            return True
    return True


@inlined
def go(link, state, work):  # type: ignore[no-untyped-def]
    """Add the step, bounded, to the angles, and keep the old ones; returns the greatest change of
    an angle."""
    largest = 0.0
    for i in range(link.mode.shape[0]):
        largest = max(largest, abs(work.step[i]))
    scale = min(1.0, MOST_STEP / max(largest, 1e-300))
    for i in range(link.mode.shape[0]):
        k = link.free_joint[i]
        axis = link.free_axis[i]
        work.kept[k, axis] = state.angles[k, axis]
        state.angles[k, axis] += scale * work.step[i]
    return scale * largest


@inlined
def back(link, state, work):  # type: ignore[no-untyped-def]
    """Take the last step back."""
    for i in range(link.mode.shape[0]):
        k = link.free_joint[i]
        axis = link.free_axis[i]
        state.angles[k, axis] = work.kept[k, axis]


@inlined
def multiply(goal, p, state, work, pull, both):  # type: ignore[no-untyped-def]
    """Multipliers after a step: of the stops and planes, and of the goal where `both`."""
    for r in range(state.used[0]):
        work.press[r] = max(0.0, work.press[r] + HOLD * (INSIDE - state.room[r]))
    if both:
        for i in range(6):
            work.pushed[i] += pull * goal[p, 6 + i] * (goal[p, i] - state.at[i])
