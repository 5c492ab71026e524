"""Descents of inverse kinematics: from the angles of a chain to a least near by.

What is made least is discomfort, the weighted square of the distance to the comfort modes, subject
to the target (an equality) and the stops and planes (inequalities). Multipliers hold these (the
augmented Lagrangian, [1]_ chapter 17):

    L = ease/2 Σ w (θ - mode)^2  +  Σ λ e + pull/2 e^2  +  Σ (max(0, μ + HOLD c)^2 - μ^2) / (2 HOLD),

with the weighted distances e of tip and direction from their target, the breaches c of stops and
planes, and the multipliers λ (`Work.pushed`) and μ (`Work.press`).

There are two descents. They differ in how the damping of a step follows its success, so neither can
stand for the other without changing what it comes to:

- `minimize` looks for a posture on the target. A posture may be far off it at first, so the penalty
  grows from step to step and the promise of a step cannot be compared with what it kept. The
  damping grows after a step that fails and shrinks after one that does not (Levenberg and
  Marquardt, [1]_ chapter 10).
- `approach` and `extend` look for the nearest to a target out of reach, and for the farthest along
  a ray. The damping follows the gain ratio, what a step kept of what it promised ([2]_).

References
----------
.. [1] J. Nocedal and S. J. Wright (2006), Numerical Optimization, 2nd edition, Springer.
.. [2] H. B. Nielsen (1999), Damping parameter in Marquardt's method, report IMM-REP-1999-05,
   Technical University of Denmark.
"""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import inlined, inner, shared
from workbench.posture.kernels.chain_kinematics import forward_kinematics
from workbench.posture.kernels.inequality_constraints import constraint_slacks
from workbench.posture.kernels.newton_step import (
    HOLD,
    INSIDE,
    newton,
    normal_equations,
    take_step,
    undo_step,
    update_multipliers,
)

__all__ = [
    "DISTANT_EASE",
    "LAST_PENALTY",
    "LEAST_EASE",
    "ON_RAY",
    "REACHED",
    "discomfort",
    "evaluate",
    "extend",
    "minimize",
    "minimize_distance",
    "put_row",
    "take",
    "take_row",
]

FIRST_PENALTY = 1e2
LAST_PENALTY = 1e4
PENALTY_GROWTH = 10.0
"""Penalty [1/m2] of the distance from the target: at first, at last, and its growth in a step."""
FORCE = 300.0
"""Greatest pull [1/m] of a target out of reach, and the push along a ray: stops would yield to
more."""
DISTANT_EASE = 1e-3
LEAST_EASE = 1e-5
"""Weight of comfort where the target is out of reach, and where it is nearly reached: comfort holds
the tip back by its weight over the pull, which was some 0.2 mm for reaches that two stops hold."""
REACHED = 1e-4
"""Distance [m] within which a target is reached."""
TIP_TOLERANCE = 2e-5
"""Distance [m] from the target at which a descent stops."""
BREACH_TOLERANCE = 1e-5
"""Greatest breach [rad, m] with which a descent stops."""
SETTLED = 1e-2
"""Largest change [rad] of an angle in a step after which a descent counts as settled."""
MULTIPLIER_STEP = 0.1
"""Largest change [rad] of an angle in a step after which the multipliers are updated."""
MULTIPLIER_RADIUS = 0.05
"""Distance [m] from the target within which its multipliers and its curvature are trusted."""
MOST_STILL = 3
"""Settled steps in a row that do not reach the target, after which it seems out of reach."""
MOST_SLOW = 3
"""Steps in a row that close the gap by less than a fifth, after which it seems out of reach."""
SLOW = 0.8
"""Share of the gap that a slow step leaves."""
SURE = 2.0
"""Damping below which a step is nearly Newton's, so that a short one says that a least is near."""
RESTED = 2e-6
"""Change [m] of the distance, in two steps that are nearly Newton's, at which it is the least."""
ON_RAY = 5e-5
"""Distance [m] from a ray within which the tip is on it."""
RESTED_ON_RAY = 5e-5
"""Gain [m] along a ray, of a step that is nearly Newton's, at which nothing more is to be had."""
FIRST_DAMPING = 1e-2
"""Damping of the first step toward a target."""
LEAST_DAMPING = 0.03
"""Damping after a step that failed, at least."""
MOST_DAMPING = 1e9
"""Damping at which a descent gives up."""
BEGUN = 0
TRIED = 1
RETURNED = 2
STUCK = 3
"""Where a descent stands: at its start, after a step, after a step that was taken back, after one
whose system could not be solved."""


@shared
def evaluate(link, b, base, p, planes, span, state):  # type: ignore[no-untyped-def]
    """Place the chain of body b at the angles of a state, and fill its room to stops and planes.

    Arguments as of `posture.kernels.linkage.forward_kinematics` and `posture.kernels.limits.constraint_slacks`.
    """
    forward_kinematics(link, b, base, p, state)
    constraint_slacks(link, planes, span, state)


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


@inlined
def discomfort(link, angles, base):  # type: ignore[no-untyped-def]
    """Add to base the weighted squares of the distances of angles (K, 3) from the comfort modes."""
    total = base
    for i in range(link.mode.shape[0]):
        off = angles[link.free_joint[i], link.free_axis[i]] - link.mode[i]
        total += link.weight[i] * off * off
    return total


@inner
def _cost(link, goal, p, state, work, pull, ease, ahead):  # type: ignore[no-untyped-def]
    """Evaluate the augmented Lagrangian, less a push `ahead` [1/m] times the tip's x.

    Fills work.force (6,), the force of goal and push on the tip. Returns the value, the distance
    from the goal [m], and the greatest breach of a stop or plane [rad, m].
    """
    gap = 0.0
    total = -ahead * state.at[0]
    for i in range(6):
        off = goal[p, 6 + i] * (goal[p, i] - state.at[i])
        gap += off * off
        total += (0.5 * pull * off + work.pushed[i]) * off
        work.force[i] = goal[p, 6 + i] * (work.pushed[i] + pull * off)
    work.force[0] += ahead
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


@inlined
def _aim(link, goal, p, state, work, pull, bent, warm):  # type: ignore[no-untyped-def]
    """Fill the equations of a step toward the target."""
    # The curvature counts with the force that will hold the tip at the end. That is known where the
    # multipliers came with the start; the force on the way there would bend the step too much.
    for i in range(6):
        work.bend[i] = goal[p, 6 + i] * work.pushed[i] if warm else work.force[i]
    normal_equations(link, goal, p, state, work, pull, 1.0, bent)


@shared
def minimize(link, b, problem, p, planes, span, most, warm, state, work):  # type: ignore[no-untyped-def]
    """Descend in comfort to a posture on the target, from the angles of a state.

    Parameters
    ----------
    link, b, planes, span
        As of `look`.
    problem : tuple of two
        World-from-base transforms (P, 3, 4) [m] and goals (P, 12): target [m], direction, and the
        weights of their six numbers.
    p : int
        Row of the problem.
    most : int
        Steps at most.
    warm : bool
        Whether the multipliers in work are those of a solution near by.
    state, work : State, Work
        Angles and multipliers in and out.

    Returns
    -------
    steps : int
        Steps that were tried.
    far : bool
        Whether the target seems out of reach.
    """
    base, goal = problem
    if not warm:
        work.pushed[:] = 0.0
        work.press[:] = 0.0
    pull = LAST_PENALTY if warm else FIRST_PENALTY
    damping = 0.0 if warm else FIRST_DAMPING
    bent = False
    moved = 0.0
    cost = 0.0
    last = np.inf
    phase = BEGUN
    steps = 0
    still = 0
    slow = 0
    while steps < most and damping < MOST_DAMPING:
        if phase != STUCK:
            evaluate(link, b, base, p, planes, span, state)
        after, gap, worst = _cost(link, goal, p, state, work, pull, 1.0, 0.0)
        if phase == TRIED and not after <= cost + 1e-9 * abs(cost):
            undo_step(link, state, work)
            damping = max(damping * 5.0, LEAST_DAMPING)
            phase = RETURNED
            slow = slow + 1
            if last > MULTIPLIER_RADIUS and slow > MOST_SLOW:
                return steps, True
            continue
        if phase == TRIED:
            damping = damping * 0.2 if damping > 1e-4 else 0.0
            still = still + 1 if moved < SETTLED else 0
            slow = slow + 1 if gap > SLOW * last else 0
            if pull >= LAST_PENALTY:
                if still > 0 and worst < BREACH_TOLERANCE and gap < TIP_TOLERANCE:
                    return steps, False
                if gap > REACHED and (still > MOST_STILL or slow > MOST_SLOW):
                    return steps, True
            last = gap
            if pull < LAST_PENALTY:
                pull *= PENALTY_GROWTH
            elif moved < MULTIPLIER_STEP:
                update_multipliers(goal, p, state, work, pull, gap < MULTIPLIER_RADIUS)
            after, gap, worst = _cost(link, goal, p, state, work, pull, 1.0, 0.0)
        # a step that was taken back with the curvature is tried without it: far off it is of no use
        if phase < RETURNED or (bent and damping > 1.0):
            bent = phase < RETURNED and gap < MULTIPLIER_RADIUS
            cost = after
            _aim(link, goal, p, state, work, pull, bent, warm)
        steps += 1
        if newton(link, state, work, damping):
            moved = take_step(link, state, work)
            phase = TRIED
        else:
            damping = max(damping * 5.0, LEAST_DAMPING)
            phase = STUCK
    return steps, True


@inlined
def _damping_factor(gain_ratio):  # type: ignore[no-untyped-def]
    """By how much the damping changes after a step that kept so much of what it promised."""
    if gain_ratio > 0.7:
        return 0.2
    return 1.0 if gain_ratio > 0.25 else 3.0


@inlined
def _promise(link, work, damping):  # type: ignore[no-untyped-def]
    """Decrease that a step promises: (g . step + μ step W step) / 2, from (H + μ W) step = g."""
    promise = 1e-300
    push = 0.0
    for i in range(link.mode.shape[0]):
        push += work.side[i] * work.step[i]
        promise += 0.5 * damping * link.weight[i] * work.step[i] * work.step[i]
    return promise + 0.5 * push


@inlined
def _aim_outward(link, goal, p, state, work, pull, ease, ahead):  # type: ignore[no-untyped-def]
    """Fill the equations of a step toward a target out of reach, or along a ray."""
    # On a ray the curvature counts with the multipliers, the forces that will hold the tip there.
    if ahead > 0.0:
        for i in range(6):
            work.bend[i] = goal[p, 6 + i] * work.pushed[i]
        work.bend[0] = ahead
    else:
        for i in range(6):
            work.bend[i] = work.force[i]
    normal_equations(link, goal, p, state, work, pull, ease, True)


@inlined
def _at_rest(still, gap, worst, ahead):  # type: ignore[no-untyped-def]
    """Whether a descent has come to rest, after so many steps in a row that changed next to nothing."""
    if worst >= BREACH_TOLERANCE:
        return False
    if ahead > 0.0:
        return still > 0 and gap < ON_RAY
    return still > 1 or gap < TIP_TOLERANCE


@shared
def _minimise(link, b, problem, p, planes, span, most, damping, ease, ahead, state, work):  # type: ignore[no-untyped-def]
    """Descend with the gain ratio: to the nearest to a target, or as far as a push `ahead` goes.

    Returns the number of steps, the penalty of the distance [1/m2], and whether it came to rest.
    """
    base, goal = problem
    pull = LAST_PENALTY if ahead > 0.0 else 0.0
    rise = 4.0
    moved = 0.0
    cost = 0.0
    promise = 1.0
    last = np.inf
    phase = BEGUN
    steps = 0
    still = 0
    while steps < most and damping < MOST_DAMPING:
        if phase != STUCK:
            evaluate(link, b, base, p, planes, span, state)
        after, gap, worst = _cost(link, goal, p, state, work, pull, ease, ahead)
        if phase == TRIED and not after <= cost + 1e-10 * abs(cost):
            undo_step(link, state, work)
            damping = max(damping * rise, LEAST_DAMPING)
            rise = rise * 2.0
            phase = RETURNED
            continue
        if phase == TRIED:
            damping = damping * _damping_factor((cost - after) / promise)
            rise = 4.0
            distance = state.at[0] if ahead > 0.0 else gap
            tolerance = RESTED_ON_RAY if ahead > 0.0 else RESTED
            still = still + 1 if damping < SURE and abs(distance - last) < tolerance else 0
            last = distance
            if _at_rest(still, gap, worst, ahead):
                return steps, pull, True
            if moved < MULTIPLIER_STEP:
                update_multipliers(goal, p, state, work, pull, ahead > 0.0)
        if phase < RETURNED:
            if not ahead > 0.0:  # the pull is the same however far the target is
                pull = min(LAST_PENALTY, FORCE / max(gap, 1e-9))
            cost, gap, worst = _cost(link, goal, p, state, work, pull, ease, ahead)
            _aim_outward(link, goal, p, state, work, pull, ease, ahead)
        steps += 1
        if newton(link, state, work, damping if damping > 1e-3 else 0.0):
            promise = _promise(link, work, damping)
            moved = take_step(link, state, work)
            phase = TRIED
        else:
            damping = max(damping * rise, LEAST_DAMPING)
            rise = rise * 2.0
            phase = STUCK
    return steps, pull, False


@inner
def minimize_distance(link, b, problem, p, planes, span, most, ease, state, work):  # type: ignore[no-untyped-def]
    """Descend to the posture whose tip is nearest to a target out of reach.

    Arguments as of `minimize`, and the weight `ease` of comfort. The multipliers of the stops in work
    are taken, and left there.

    Returns
    -------
    steps : int
        Steps that were tried.
    pull : float
        Penalty [1/m2] of the distance from the target; the target pulls with pull times distance.
    """
    work.pushed[:] = 0.0
    steps, pull, _ = _minimise(link, b, problem, p, planes, span, most, 1.0, ease, 0.0, state, work)
    return steps, pull


@inner
def extend(link, b, problem, p, planes, span, most, warm, state, work):  # type: ignore[no-untyped-def]
    """Descend outward along x, as far as stops and the length of the chain let the tip go.

    The goal holds the other two coordinates: its weights are 0, 1, 1, and 0 for the direction. The
    multipliers in work are taken, and left there.

    Returns
    -------
    steps : int
        Steps that were tried.
    rested : bool
        Whether the tip came to rest on the ray.
    """
    damping = 0.0 if warm else 1.0
    steps, _, rested = _minimise(
        link, b, problem, p, planes, span, most, damping, DISTANT_EASE, FORCE, state, work
    )
    return steps, rested
