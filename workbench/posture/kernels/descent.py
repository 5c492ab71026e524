"""The descents of inverse kinematics: from angles to the most comfortable ones near by that bring
the tip to a target within the stops, and where it is out of reach to those that bring it nearest.

What is made least is the weighted square of the distance to the comfort modes, held to the target
(an equality) and to the stops and planes (inequalities) by the method of multipliers (augmented
Lagrangian; Nocedal & Wright 2006, Numerical Optimization, chapter 17), each step a damped Newton
step (Levenberg and Marquardt; chapter 10) with the curvature of the tip's path in it. Where the
target cannot be had, comfort gives way to distance.
"""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import inlined, inner
from workbench.posture.kernels.limits import rooms
from workbench.posture.kernels.linkage import move
from workbench.posture.kernels.newton import HOLD, INSIDE, back, equations, go, multiply, newton

__all__ = [
    "EASE",
    "FORCE",
    "KEPT",
    "LAST",
    "REACHED",
    "approach",
    "descend",
    "look",
    "put_row",
    "take",
    "take_row",
]

FIRST = 1e2
LAST = 1e4
GROWTH = 10.0
"""Weights [1/m2] of the distance to the target: where they begin, where they end."""
SETTLED = 1e-2
CLOSE = 0.05
NEAR = 2e-5
KEPT = 1e-5
"""Distances [m]: within which multipliers are trusted, of an answer, and the greatest breach of an
answer."""
REACHED = 1e-4
"""Distance [m] within which a target is reached."""
MOST_SLOW = 3
"""Steps in a row that close the gap by less than a fifth, after which the target seems out of
reach."""
SURE = 2.0
RESTED = 2e-6
"""Damping below which a step is nearly Newton's, and how little [m] the distance then changes once
it is the least."""
FORCE = 300.0
"""How hard [1/m] what is out of reach pulls, however far it is: stops would give way to more."""
EASE = 1e-3
"""What comfort counts for where the target cannot be had."""
BEGUN = 0
TRIED = 1
RETURNED = 2
STUCK = 3
"""Where a descent stands: at its start, after a step, after a step that was taken back, before one
that failed."""


@inner
def look(link, b, base, p, planes, span, state):  # type: ignore[no-untyped-def]
    """Where a state's angles bring the chain of body b, and how far it is from its stops and
    planes."""
    move(link, b, base, p, state)
    rooms(link, planes, span, state)


@inlined
def take_row(angles, p, out):  # type: ignore[no-untyped-def]
    """Copy angles[p] (K, 3) into out."""
    for k in range(out.shape[0]):
        for axis in range(3):
            out[k, axis] = angles[p, k, axis]


@inlined
def take(values, out):  # type: ignore[no-untyped-def]
    """Copy values (K, 3) into out."""
    for k in range(out.shape[0]):
        for axis in range(3):
            out[k, axis] = values[k, axis]


@inlined
def put_row(values, angles, p):  # type: ignore[no-untyped-def]
    """Copy values (K, 3) into angles[p]."""
    for k in range(values.shape[0]):
        for axis in range(3):
            angles[p, k, axis] = values[k, axis]


@inner
def _cost(link, goal, p, state, work, pull, ease):  # type: ignore[no-untyped-def]
    """The sum that is made least, the distance from the goal, and the greatest breach; fills
    work.force (6,), the pull of the goal."""
    gap = 0.0
    total = 0.0
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


@inner
def descend(link, b, problem, p, planes, span, most, warm, state, work):  # type: ignore[no-untyped-def]
    """From the angles of a state to the nearest least, the target held; returns the number of steps
    and whether the target seems out of reach. work.pushed and work.press hold the multipliers, in
    where warm, and out."""
    base, goal = problem
    if not warm:
        work.pushed[:] = 0.0
        work.press[:] = 0.0
    pull = LAST if warm else FIRST
    damping = 0.0 if warm else 1e-2
    bent = False
    moved = 0.0
    cost = 0.0
    last = np.inf
    phase = BEGUN
    steps = 0
    still = 0
    slow = 0
    while steps < most and damping < 1e9:
        if phase != STUCK:
            look(link, b, base, p, planes, span, state)
        after, gap, worst = _cost(link, goal, p, state, work, pull, 1.0)
        if phase == TRIED and not after <= cost + 1e-9 * abs(cost):
            back(link, state, work)
            damping = max(damping * 5.0, 0.03)
            phase = RETURNED
            slow = slow + 1
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
                multiply(goal, p, state, work, pull, gap < CLOSE)
            after, gap, worst = _cost(link, goal, p, state, work, pull, 1.0)
        if phase < RETURNED or (
            bent and damping > 1.0
        ):  # far off the curvature is of no use: go on without
            bent = phase < RETURNED and gap < CLOSE
            cost = after
            for i in range(
                6
            ):  # a way that is still to be gone would bend too much: what holds at its end is known
                work.bend[i] = goal[p, 6 + i] * work.pushed[i] if warm else work.force[i]
            equations(link, goal, p, state, work, pull, 1.0, bent)
        steps += 1
        if newton(link, state, work, damping):
            moved = go(link, state, work)
            phase = TRIED
        else:
            damping = max(damping * 5.0, 0.03)
            phase = STUCK
    return steps, True


@inner
def approach(link, b, problem, p, planes, span, most, state, work):  # type: ignore[no-untyped-def]
    """From the angles of a state to the nearest that the tip gets to a target out of reach; returns
    the number of steps and the weight of the distance. work.press holds the pressure on the stops,
    in and out.

    The step is damped by how much of what it promised it has kept (Nocedal & Wright 2006, chapter
    4).
    """
    base, goal = problem
    work.pushed[:] = 0.0
    pull = 0.0
    damping = 1.0
    rise = 4.0
    moved = 0.0
    cost = 0.0
    promise = 1.0
    last = np.inf
    phase = BEGUN
    steps = 0
    still = 0
    while steps < most and damping < 1e9:
        if phase != STUCK:
            look(link, b, base, p, planes, span, state)
        after, gap, worst = _cost(link, goal, p, state, work, pull, EASE)
        if phase == TRIED and not after <= cost + 1e-10 * abs(cost):
            back(link, state, work)
            damping = max(damping * rise, 0.03)
            rise = rise * 2.0
            phase = RETURNED
            continue
        if phase == TRIED:
            kept = (cost - after) / promise
            damping = damping * (0.2 if kept > 0.7 else 1.0 if kept > 0.25 else 3.0)
            rise = 4.0
            still = still + 1 if damping < SURE and abs(gap - last) < RESTED else 0
            last = gap
            if worst < KEPT and (still > 1 or gap < NEAR):
                return steps, pull
            if moved < 0.1:
                multiply(goal, p, state, work, pull, np.bool_(False))
        if phase < RETURNED:
            pull = min(LAST, FORCE / max(gap, 1e-9))
            cost, gap, worst = _cost(link, goal, p, state, work, pull, EASE)
            for i in range(6):
                work.bend[i] = work.force[i]
            equations(link, goal, p, state, work, pull, EASE, np.bool_(True))
        steps += 1
        if newton(link, state, work, damping if damping > 1e-3 else 0.0):
            promise = 1e-300
            push = 0.0
            for i in range(link.mode.shape[0]):
                push += work.side[i] * work.step[i]
                promise += 0.5 * damping * link.weight[i] * work.step[i] * work.step[i]
            promise += 0.5 * push
            moved = go(link, state, work)
            phase = TRIED
        else:
            damping = max(damping * rise, 0.03)
            rise = rise * 2.0
            phase = STUCK
    return steps, pull
