"""Batch inverse kinematics: the most comfortable angles of a chain that bring its tip to a target within its stops.

What is made least is the weighted square of the distance to the comfort modes, held to the target (an equality) and
to the stops and planes (inequalities) by the method of multipliers (augmented Lagrangian; Nocedal & Wright 2006,
Numerical Optimization, chapter 17), each step a damped Newton step (Levenberg and Marquardt; chapter 10) with the
curvature of the tip's path in it. Where the target cannot be had, comfort gives way to distance.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from workbench.kernels.limits import Planes, rooms, within
from workbench.kernels.linkage import move, new_state

__all__ = ["breaches", "solve_chains", "tips"]

FIRST, LAST, GROWTH = 1e2, 1e4, 10.0
"""Weights [1/m2] of the distance to the target: where they begin, where they end."""
HOLD = 1e5
"""Weight [1/rad2, 1/m2] of a breach of a stop or plane."""
INSIDE = 1e-6
"""How far [rad, m] inside a stop a solution is brought, so that rounding does not put it past."""
MOST_STEP, SETTLED = 0.6, 1e-2
CLOSE, NEAR, KEPT = 0.05, 2e-5, 1e-5
"""Distances [m]: within which multipliers are trusted, of an answer, and the greatest breach of an answer."""
REACHED, LEGAL = 1e-4, 5e-4
"""Distance [m] within which a target is reached, breach [rad, m] below which a solution is within the stops."""
MOST_TURNS = 6
EASE = 1e-3
"""What comfort counts for where the target cannot be had."""


@njit(cache=True)
def _force(goal, state, held, force):  # type: ignore[no-untyped-def]
    """Fill force (6,), the pull of the goal; returns the distance from it and the share of the pull in the cost."""
    pull, pushed = held
    gap, cost = 0.0, 0.0
    for i in range(6):
        off = goal[6 + i] * (goal[i] - state.at[i])
        gap += off * off
        cost += (0.5 * pull * off + pushed[i]) * off
        force[i] = goal[6 + i] * (pushed[i] + pull * off)
    return math.sqrt(gap), cost


@njit(cache=True)
def _cost(link, goal, state, held, ease, press, force):  # type: ignore[no-untyped-def]
    """The sum that is made least, the distance from the goal, and the greatest breach."""
    gap, total = _force(goal, state, held, force)
    for i in range(link.mode.shape[0]):
        off = state.angles[link.free_joint[i], link.free_axis[i]] - link.mode[i]
        total += 0.5 * ease * link.weight[i] * off * off
    worst = 0.0
    for r in range(state.used[0]):
        breach = INSIDE - state.room[r]
        worst = max(worst, breach)
        pressed = press[r] + HOLD * breach
        total += (0.5 / HOLD) * (max(0.0, pressed) ** 2 - press[r] ** 2)
    return total, gap, worst


@njit(cache=True)
def _equations(link, goal, state, held, force, bent, matrix, right):  # type: ignore[no-untyped-def]
    """Normal equations of the step without the stops: matrix (n, n), lower triangle, and right side (n,). The second
    derivative of a turn after a turn is the cross product of the outer rate of turn with the inner slope."""
    n, f, directed = link.mode.shape[0], force, goal[9] > 0.0
    pull, ease = held
    for i in range(n):
        s = state.slope[i]
        right[i] = ease * link.weight[i] * (link.mode[i] - state.angles[link.free_joint[i], link.free_axis[i]])
        right[i] += s[0] * f[0] + s[1] * f[1] + s[2] * f[2]
        if directed:
            right[i] += s[3] * f[3] + s[4] * f[4] + s[5] * f[5]
        for j in range(i + 1):
            t, w = state.slope[j], state.spin[j]  # free angles run outward from the held link, so j is the outer one
            value = pull * (s[0] * t[0] + s[1] * t[1] + s[2] * t[2])
            if bent:
                value -= f[0] * (w[1] * s[2] - w[2] * s[1])
                value -= f[1] * (w[2] * s[0] - w[0] * s[2]) + f[2] * (w[0] * s[1] - w[1] * s[0])
            if directed:
                value += pull * goal[9] * goal[9] * (s[3] * t[3] + s[4] * t[4] + s[5] * t[5])
                if bent:
                    value -= f[3] * (w[1] * s[5] - w[2] * s[4])
                    value -= f[4] * (w[2] * s[3] - w[0] * s[5]) + f[5] * (w[0] * s[4] - w[1] * s[3])
            matrix[i, j] = value
        matrix[i, i] += ease * link.weight[i]


@njit(cache=True)
def _cholesky(matrix, right, step):  # type: ignore[no-untyped-def]
    """Solve by Cholesky's factors of the lower triangle, in place; False where it is not positive."""
    n = right.shape[0]
    for j in range(n):
        for i in range(j, n):
            value = matrix[i, j]
            for m in range(j):
                value -= matrix[i, m] * matrix[j, m]
            if i == j:
                if not value > 1e-9:
                    return False
                matrix[j, j] = math.sqrt(value)
            else:
                matrix[i, j] = value / matrix[j, j]
    for i in range(n):
        value = right[i]
        for m in range(i):
            value -= matrix[i, m] * step[m]
        step[i] = value / matrix[i, i]
    for i in range(n - 1, -1, -1):
        value = step[i]
        for m in range(i + 1, n):
            value -= matrix[m, i] * step[m]
        step[i] = value / matrix[i, i]
    return True


@njit(cache=True)
def _step(state, equations, damping, press, work):  # type: ignore[no-untyped-def]
    """The damped step, with the stops that hold it found by turns; False where the equations are not positive."""
    matrix, right, weight = equations
    whole, side, active, step = work
    n = right.shape[0]
    for r in range(state.used[0]):
        active[r] = press[r] + HOLD * (INSIDE - state.room[r]) > 0.0
    for _ in range(MOST_TURNS):
        for i in range(n):
            side[i] = right[i]
            for j in range(i + 1):
                whole[i, j] = matrix[i, j]
            whole[i, i] += damping * weight[i]
        for r in range(state.used[0]):
            if active[r]:
                g, push = state.slope_of_room[r], press[r] + HOLD * (INSIDE - state.room[r])
                for i in range(n):
                    if g[i] != 0.0:
                        side[i] += push * g[i]
                        for j in range(i + 1):
                            whole[i, j] += HOLD * g[i] * g[j]
        if not _cholesky(whole, side, step):
            return False
        changed = False
        for r in range(state.used[0]):
            after = state.room[r] - INSIDE
            for i in range(n):
                after += state.slope_of_room[r, i] * step[i]
            holds = press[r] - HOLD * after > 0.0
            if holds != active[r]:
                active[r], changed = holds, True
        if not changed:
            return True
    return True


@njit(cache=True)
def _try(link, problem, states, step):  # type: ignore[no-untyped-def]
    """Put states[1] a step, bounded, beyond states[0]; returns the greatest change of an angle."""
    base, planes, count = problem
    here, there = states
    largest = np.max(np.abs(step))
    scale = min(1.0, MOST_STEP / max(largest, 1e-300))
    there.angles[:] = here.angles
    for i in range(link.mode.shape[0]):
        there.angles[link.free_joint[i], link.free_axis[i]] += scale * step[i]
    move(link, base, there)
    rooms(link, planes, count, there)
    return scale * largest


@njit(cache=True)
def _descend(link, problem, most, states, press):  # type: ignore[no-untyped-def]
    """From the angles of states[0] to the nearest least; returns whether states[1] has it, and the number of steps.
    press (R,) receives the pressure on each stop and plane."""
    base, goal, planes, count = problem
    here, there = states
    n, rows = link.mode.shape[0], here.room.shape[0]
    pushed, force = np.zeros(6), np.zeros(6)
    press[:] = 0.0
    work = (np.empty((n, n)), np.empty(n), np.zeros(rows, np.bool_), np.zeros(n))
    matrix, right, step = np.empty((n, n)), np.empty(n), work[3]
    move(link, base, here)
    rooms(link, planes, count, here)
    pull, damping, ease, swapped, bent = FIRST, 1e-2, 1.0, False, False
    cost, gap, worst = _cost(link, goal, here, (pull, pushed), ease, press, force)
    _equations(link, goal, here, (pull, ease), force, bent, matrix, right)
    steps, still = 0, 0
    while steps < most and damping < 1e9:
        steps += 1
        moved = 0.0
        accepted = _step(here, (matrix, right, link.weight), damping, press, work)
        if accepted:
            moved = _try(link, (base, planes, count), (here, there), step)
            after, gap_after, worst_after = _cost(link, goal, there, (pull, pushed), ease, press, force)
            accepted = after <= cost + 1e-9 * abs(cost)
        if not accepted:
            damping = max(damping * 5.0, 0.03)
            if bent and damping > 1.0:  # the curvature is of no use this far off: go on without
                _force(goal, here, (pull, pushed), force)
                bent = False
                _equations(link, goal, here, (pull, ease), force, bent, matrix, right)
            continue
        here, there, swapped = there, here, not swapped
        gap, worst, damping = gap_after, worst_after, damping * 0.2 if damping > 1e-4 else 0.0
        still = still + 1 if moved < (SETTLED if ease == 1.0 else 0.02 * SETTLED) else 0
        if pull >= LAST and still > 0 and worst < KEPT and (gap < NEAR or (ease < 1.0 and still > 1)):
            break
        if pull >= LAST and ease == 1.0 and gap > 1e-4 and still > 3:
            ease, still = EASE, 0
            pushed[:] = 0.0
        if pull < LAST:
            pull *= GROWTH
        elif moved < 0.1:
            for r in range(here.used[0]):
                press[r] = max(0.0, press[r] + HOLD * (INSIDE - here.room[r]))
            if gap < CLOSE and ease == 1.0:
                for i in range(6):
                    pushed[i] += pull * goal[6 + i] * (goal[i] - here.at[i])
        cost, gap, worst = _cost(link, goal, here, (pull, pushed), ease, press, force)
        bent = gap < CLOSE or ease < 1.0
        _equations(link, goal, here, (pull, ease), force, bent, matrix, right)
    return swapped, steps


@njit(cache=True)
def _worth(link, goal, planes, count, state):  # type: ignore[no-untyped-def]
    """Distance from the goal and greatest breach of a state, brought inside what can be clipped."""
    rooms(link, planes, count, state)
    breach, gap = 0.0, 0.0
    for r in range(state.used[0]):
        breach = max(breach, -state.room[r])
    for i in range(6):
        gap += (goal[6 + i] * (goal[i] - state.at[i])) ** 2
    return math.sqrt(gap), breach


@njit(cache=True)
def _next_seed(base, goal, seeds, tried):  # type: ignore[no-untyped-def]
    """The seed not yet tried whose tip and direction, in the frame of the held link, are nearest to the goal."""
    local = np.zeros(6)
    for i in range(3):
        for m in range(3):
            local[i] += base[m, i] * (goal[m] - base[m, 3])
            local[3 + i] += base[m, i] * goal[3 + m]
    best, least = -1, np.inf
    for s in range(seeds.shape[0]):
        gap = 0.0
        for i in range(6):
            gap += (goal[6 + i] * (local[i] - seeds[s, i])) ** 2
        if gap < least and not tried[s]:
            best, least = s, gap
    return best


@njit(cache=True)
def _holder(press, state, gap, held):  # type: ignore[no-untyped-def]
    """Fill held (5,): joint, axis, side of the stop under most pressure (or -1 and a plane's number), how much it
    would give [m/rad, m/m] and 1.0; zeros where nothing is held."""
    held[:] = 0.0
    best = -1
    for r in range(state.used[0]):
        if press[r] > (press[best] if best >= 0 else 0.0):
            best = r
    if best >= 0 and gap > 0.0:
        held[0], held[1], held[2] = state.label[best, 0], state.label[best, 1], state.label[best, 2]
        held[3], held[4] = press[best] / (LAST * gap), 1.0


@njit(cache=True)
def solve_chains(link, problem, planes, settings, out):  # type: ignore[no-untyped-def]
    """Solve P chains. problem: base (P, 3, 4), goal (P, 12): target, direction, weights of each. planes: rows of
    Planes and start (P + 1,). settings: most steps, seeds (M, K, 3) to begin again from with their tips and directions
    (M, 6), how many of them. out: angles (P, K, 3), the start in and the solution out; numbers (P, 8): error, breach,
    steps, and what holds (5)."""
    base, goal = problem
    rows, start = planes
    most, seeds, seed_tips, again = settings
    angles, numbers = out
    joints, free, widest = link.at_parent.shape[0], link.mode.shape[0], 0
    for p in range(len(base)):
        widest = max(widest, start[p + 1] - start[p])
    one, two = new_state(joints, free, len(link.rows) + widest), new_state(joints, free, len(link.rows) + widest)
    best, tried, press = np.empty((joints, 3)), np.zeros(len(seeds), np.bool_), np.zeros(len(link.rows) + widest)
    for p in range(len(base)):
        a, b, error, breach = start[p], start[p + 1], np.inf, np.inf
        near = Planes(rows.link[a:b], rows.point[a:b], rows.normal[a:b], rows.offset[a:b])
        one.angles[:] = angles[p]
        best[:] = angles[p]
        tried[:] = False
        numbers[p] = 0.0
        for attempt in range(again + 1):
            swapped, steps = _descend(link, (base[p], goal[p], near, b - a), most, (one, two), press)
            found = two if swapped else one
            within(link, found.angles)
            move(link, base[p], found)
            gap, past = _worth(link, goal[p], near, b - a, found)
            numbers[p, 2] += steps
            if (past < LEGAL and breach >= LEGAL) or (past < max(LEGAL, breach) and gap < error):
                error, breach = gap, past
                best[:] = found.angles
                _holder(press, found, gap, numbers[p, 3:])
            if (error < REACHED and breach < LEGAL) or attempt == again:
                break
            s = _next_seed(base[p], goal[p], seed_tips, tried)
            if s < 0:
                break
            tried[s] = True
            one.angles[:] = angles[p]
            for d in range(free):
                one.angles[link.free_joint[d], link.free_axis[d]] = seeds[s, link.free_joint[d], link.free_axis[d]]
        angles[p] = best
        numbers[p, 0], numbers[p, 1] = error, breach


@njit(cache=True)
def tips(link, base, angles, out):  # type: ignore[no-untyped-def]
    """Fill out (P, 6) with tip and direction at angles (P, K, 3)."""
    state = new_state(link.at_parent.shape[0], link.mode.shape[0], 1)
    for p in range(len(angles)):
        state.angles[:] = angles[p]
        move(link, base[p], state)
        out[p] = state.at


@njit(cache=True)
def breaches(link, planes, angles, out):  # type: ignore[no-untyped-def]
    """Bring angles (P, K, 3) inside what can be clipped, and fill out (P,) with the greatest breach that is left."""
    state = new_state(link.at_parent.shape[0], link.mode.shape[0], len(link.rows))
    base = np.zeros((3, 4))
    for i in range(3):
        base[i, i] = 1.0
    for p in range(len(angles)):
        state.angles[:] = angles[p]
        within(link, state.angles)
        move(link, base, state)
        rooms(link, planes, 0, state)
        angles[p] = state.angles
        out[p] = 0.0
        for r in range(state.used[0]):
            out[p] = max(out[p], -state.room[r])
