"""The descents of inverse kinematics: from angles to the most comfortable ones near by that bring the tip to a target
within the stops, and where it is out of reach to those that bring it nearest.

What is made least is the weighted square of the distance to the comfort modes, held to the target (an equality) and
to the stops and planes (inequalities) by the method of multipliers (augmented Lagrangian; Nocedal & Wright 2006,
Numerical Optimization, chapter 17), each step a damped Newton step (Levenberg and Marquardt; chapter 10) with the
curvature of the tip's path in it. Where the target cannot be had, comfort gives way to distance.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.kernels.limits import rooms
from workbench.kernels.linkage import move

__all__ = ["LAST", "REACHED", "Work", "approach", "descend", "look", "new_work", "put_row", "take", "take_row"]

FIRST, LAST, GROWTH = 1e2, 1e4, 10.0
"""Weights [1/m2] of the distance to the target: where they begin, where they end."""
HOLD = 1e5
"""Weight [1/rad2, 1/m2] of a breach of a stop or plane."""
INSIDE = 1e-6
"""How far [rad, m] inside a stop a solution is brought, so that rounding does not put it past."""
MOST_STEP, SETTLED = 0.6, 1e-2
CLOSE, NEAR, KEPT = 0.05, 2e-5, 1e-5
"""Distances [m]: within which multipliers are trusted, of an answer, and the greatest breach of an answer."""
REACHED = 1e-4
"""Distance [m] within which a target is reached."""
MOST_TURNS = 6
MOST_SLOW = 3
"""Steps in a row that close the gap by less than a fifth, after which the target seems out of reach."""
SURE, RESTED = 2.0, 2e-6
"""Damping below which a step is nearly Newton's, and how little [m] the distance then changes once it is the least."""
FORCE = 300.0
"""How hard [1/m] what is out of reach pulls, however far it is: stops would give way to more."""
EASE = 1e-3
"""What comfort counts for where the target cannot be had."""
BEGUN, TRIED, RETURNED, STUCK = 0, 1, 2, 3
"""Where a descent stands: at its start, after a step, after a step that was taken back, before one that failed."""


class Work(NamedTuple):
    """Working space of a descent: matrix, whole (n, n), right, side, step (n,), active (R,), force, pushed (6,), press
    (R,), kept (K, 3), bend (6,): the pull in the curvature."""

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
def look(link, b, base, p, planes, span, state):  # type: ignore[no-untyped-def]
    """Where a state's angles bring the chain of body b, and how far it is from its stops and planes."""
    move(link, b, base, p, state)
    rooms(link, b, planes, span, state)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def take_row(angles, p, out):  # type: ignore[no-untyped-def]
    """Copy angles[p] (K, 3) into out."""
    for k in range(out.shape[0]):
        for axis in range(3):
            out[k, axis] = angles[p, k, axis]


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def take(values, out):  # type: ignore[no-untyped-def]
    """Copy values (K, 3) into out."""
    for k in range(out.shape[0]):
        for axis in range(3):
            out[k, axis] = values[k, axis]


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def put_row(values, angles, p):  # type: ignore[no-untyped-def]
    """Copy values (K, 3) into angles[p]."""
    for k in range(values.shape[0]):
        for axis in range(3):
            angles[p, k, axis] = values[k, axis]


@njit(cache=True, error_model="numpy", _nrt=False)
def _cost(link, goal, p, state, work, pull, ease):  # type: ignore[no-untyped-def]
    """The sum that is made least, the distance from the goal, and the greatest breach; fills work.force (6,), the pull
    of the goal."""
    gap, total = 0.0, 0.0
    for i in range(6):
        off = goal[p, 6 + i] * (goal[p, i] - state.at[i])
        gap += off * off
        total += (0.5 * pull * off + work.pushed[i]) * off
        work.force[i] = goal[p, 6 + i] * (work.pushed[i] + pull * off)
    for i in range(link.mode.shape[0]):
        off = state.angles[link.free_joint[i], link.free_axis[i]] - link.mode[i]
        total += 0.5 * ease * link.weight[i] * off * off
    worst = 0.0
    for r in range(state.used[0]):
        breach = INSIDE - state.room[r]
        worst = max(worst, breach)
        pressed = max(0.0, work.press[r] + HOLD * breach)
        total += (0.5 / HOLD) * (pressed * pressed - work.press[r] * work.press[r])
    return total, math.sqrt(gap), worst


@njit(cache=True, error_model="numpy", _nrt=False)
def _equations(link, goal, p, state, work, pull, ease, bent, warm):  # type: ignore[no-untyped-def]
    """Normal equations of the step without the stops: matrix (n, n), lower triangle, and right side (n,). The second
    derivative of a turn after a turn is the cross product of the outer rate of turn with the inner slope."""
    n, f, directed = link.mode.shape[0], work.force, goal[p, 9] > 0.0
    for i in range(6):  # a way that is still to be gone would bend too much: what will hold at its end is known
        work.bend[i] = goal[p, 6 + i] * work.pushed[i] if warm else f[i]
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
    for j in range(n):  # free angles run outward from the held link, so j is the outer one
        t0, t1, t2 = pull * state.slope[j, 0], pull * state.slope[j, 1], pull * state.slope[j, 2]
        w0, w1, w2 = state.spin[j, 0], state.spin[j, 1], state.spin[j, 2]
        if bent:
            t0, t1, t2 = t0 - f[1] * w2 + f[2] * w1, t1 - f[2] * w0 + f[0] * w2, t2 - f[0] * w1 + f[1] * w0
        for i in range(j, n):
            work.matrix[i, j] = state.slope[i, 0] * t0 + state.slope[i, 1] * t1 + state.slope[i, 2] * t2
        if directed:
            t0, t1, t2 = tilt * state.slope[j, 3], tilt * state.slope[j, 4], tilt * state.slope[j, 5]
            if bent:
                t0, t1, t2 = t0 - f[4] * w2 + f[5] * w1, t1 - f[5] * w0 + f[3] * w2, t2 - f[3] * w1 + f[4] * w0
            for i in range(j, n):
                work.matrix[i, j] += state.slope[i, 3] * t0 + state.slope[i, 4] * t1 + state.slope[i, 5] * t2
        work.matrix[j, j] += ease * link.weight[j]


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _cholesky(matrix, right, step):  # type: ignore[no-untyped-def]
    """Solve by Cholesky's factors of the lower triangle, in place; False where it is not positive."""
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


@njit(cache=True, error_model="numpy", _nrt=False)
def _step(link, state, work, damping):  # type: ignore[no-untyped-def]
    """The damped step, with the stops that hold it found by turns; False where the equations are not positive."""
    n, slope, press, active = link.mode.shape[0], state.slope_of_room, work.press, work.active
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
                active[r], changed = holds, True
        if not changed:
            return True
    return True


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _go(link, state, work):  # type: ignore[no-untyped-def]
    """Add the step, bounded, to the angles, and keep the old ones; returns the greatest change of an angle."""
    largest = 0.0
    for i in range(link.mode.shape[0]):
        largest = max(largest, abs(work.step[i]))
    scale = min(1.0, MOST_STEP / max(largest, 1e-300))
    for i in range(link.mode.shape[0]):
        k, axis = link.free_joint[i], link.free_axis[i]
        work.kept[k, axis] = state.angles[k, axis]
        state.angles[k, axis] += scale * work.step[i]
    return scale * largest


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _back(link, state, work):  # type: ignore[no-untyped-def]
    """Take the last step back."""
    for i in range(link.mode.shape[0]):
        k, axis = link.free_joint[i], link.free_axis[i]
        state.angles[k, axis] = work.kept[k, axis]


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _multiply(goal, p, state, work, pull, both):  # type: ignore[no-untyped-def]
    """Multipliers after a step: of the stops and planes, and of the goal where `both`."""
    for r in range(state.used[0]):
        work.press[r] = max(0.0, work.press[r] + HOLD * (INSIDE - state.room[r]))
    if both:
        for i in range(6):
            work.pushed[i] += pull * goal[p, 6 + i] * (goal[p, i] - state.at[i])


@njit(cache=True, error_model="numpy", _nrt=False)
def descend(link, b, problem, p, planes, span, most, warm, state, work):  # type: ignore[no-untyped-def]
    """From the angles of a state to the nearest least, the target held; returns the number of steps and whether the
    target seems out of reach. work.pushed and work.press hold the multipliers, in where warm, and out."""
    base, goal = problem
    if not warm:
        work.pushed[:] = 0.0
        work.press[:] = 0.0
    pull, damping, bent, moved, cost, last = LAST if warm else FIRST, 0.0 if warm else 1e-2, False, 0.0, 0.0, np.inf
    phase, steps, still, slow = BEGUN, 0, 0, 0
    while steps < most and damping < 1e9:
        if phase != STUCK:
            look(link, b, base, p, planes, span, state)
        after, gap, worst = _cost(link, goal, p, state, work, pull, 1.0)
        if phase == TRIED and not after <= cost + 1e-9 * abs(cost):
            _back(link, state, work)
            damping, phase, slow = max(damping * 5.0, 0.03), RETURNED, slow + 1
            if last > CLOSE and slow > MOST_SLOW:
                return steps, True
            continue
        if phase == TRIED:
            damping = damping * 0.2 if damping > 1e-4 else 0.0
            still = still + 1 if moved < SETTLED else 0
            if pull >= LAST and still > 0 and worst < KEPT and gap < NEAR:
                return steps, False
            slow = slow + 1 if gap > 0.8 * last else 0
            if pull >= LAST and gap > REACHED and (still > 3 or slow > MOST_SLOW):
                return steps, True
            last = gap
            if pull < LAST:
                pull *= GROWTH
            elif moved < 0.1:
                _multiply(goal, p, state, work, pull, gap < CLOSE)
            after, gap, worst = _cost(link, goal, p, state, work, pull, 1.0)
        if phase < RETURNED or (bent and damping > 1.0):  # far off the curvature is of no use: go on without
            bent = phase < RETURNED and gap < CLOSE
            cost = after
            _equations(link, goal, p, state, work, pull, 1.0, bent, warm)
        steps += 1
        if _step(link, state, work, damping):
            moved, phase = _go(link, state, work), TRIED
        else:
            damping, phase = max(damping * 5.0, 0.03), STUCK
    return steps, True


@njit(cache=True, error_model="numpy", _nrt=False)
def approach(link, b, problem, p, planes, span, most, state, work):  # type: ignore[no-untyped-def]
    """From the angles of a state to the nearest that the tip gets to a target out of reach; returns the number of steps
    and the weight of the distance. work.press holds the pressure on the stops, in and out.

    The step is damped by how much of what it promised it has kept (Nocedal & Wright 2006, chapter 4).
    """
    base, goal = problem
    work.pushed[:] = 0.0
    pull, damping, rise, moved, cost, promise, last = 0.0, 1.0, 4.0, 0.0, 0.0, 1.0, np.inf
    phase, steps, still = BEGUN, 0, 0
    while steps < most and damping < 1e9:
        if phase != STUCK:
            look(link, b, base, p, planes, span, state)
        after, gap, worst = _cost(link, goal, p, state, work, pull, EASE)
        if phase == TRIED and not after <= cost + 1e-10 * abs(cost):
            _back(link, state, work)
            damping, rise, phase = max(damping * rise, 0.03), rise * 2.0, RETURNED
            continue
        if phase == TRIED:
            kept = (cost - after) / promise
            damping, rise = damping * (0.2 if kept > 0.7 else 1.0 if kept > 0.25 else 3.0), 4.0
            still = still + 1 if damping < SURE and abs(gap - last) < RESTED else 0
            last = gap
            if worst < KEPT and (still > 1 or gap < NEAR):
                return steps, pull
            if moved < 0.1:
                _multiply(goal, p, state, work, pull, False)
        if phase < RETURNED:
            pull = min(LAST, FORCE / max(gap, 1e-9))
            cost, gap, worst = _cost(link, goal, p, state, work, pull, EASE)
            _equations(link, goal, p, state, work, pull, EASE, True, False)
        steps += 1
        if _step(link, state, work, damping if damping > 1e-3 else 0.0):
            promise, push = 1e-300, 0.0
            for i in range(link.mode.shape[0]):
                push += work.side[i] * work.step[i]
                promise += 0.5 * damping * link.weight[i] * work.step[i] * work.step[i]
            promise += 0.5 * push
            moved, phase = _go(link, state, work), TRIED
        else:
            damping, rise, phase = max(damping * rise, 0.03), rise * 2.0, STUCK
    return steps, pull
