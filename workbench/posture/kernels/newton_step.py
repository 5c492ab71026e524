"""Damped Newton step of a chain, held by stops and planes.

The step solves (H + μ W) step = -g, with the Hessian H and the gradient g of the augmented
Lagrangian (the method of multipliers, [1]_ chapter 17), the damping μ (Levenberg and Marquardt,
[1]_ chapter 10) and the comfort weights W. The stops and planes that hold the step are an active
set, found by repetition.

References
----------
.. [1] J. Nocedal and S. J. Wright (2006), Numerical Optimization, 2nd edition, Springer.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import inlined, inner, shared
from workbench.geometry.vectors import cross, dot, scale, subtract, vector
from workbench.posture.kernels.cholesky import factorise, substitute
from workbench.posture.kernels.inequality_constraints import WHOLE_CONE, WHOLE_POLYGON

__all__ = [
    "HOLD",
    "INSIDE",
    "DescentWorkspace",
    "new_work",
    "newton",
    "normal_equations",
    "take_step",
    "undo_step",
    "update_multipliers",
]

Floats = NDArray[np.float64]

HOLD = 1e5
"""Penalty [1/rad2, 1/m2] of a breach of a stop or plane."""
INSIDE = 1e-6
"""How far [rad, m] inside a stop a solution is brought, so that rounding does not put it past."""
UNSURE = 30.0
"""Most [1/rad, 1/m] by which the force of a stop in the Hessian may exceed its multiplier."""
GRID = 2.0**24
"""[1/rad] After each step the angles are rounded to one over this, 6e-8 rad. Steps among stops and
obstacles can multiply a difference tenfold each: so the last digits, which are others once a cockpit is
turned or moved, do not grow until they lead a search elsewhere."""
MOST_STEP = 0.6
"""Largest change [rad] of an angle in one step."""
MOST_TURNS = 6
"""Active sets that are tried for one step at most."""
LEAST_CURVATURE = 1e-9
"""Square of a pivot of the Cholesky factorisation below which a matrix does not count as positive definite."""


class DescentWorkspace(NamedTuple):
    """Working arrays of a descent, for n free angles and R stops and planes."""

    matrix: Floats
    """(n, n) Hessian without stops and damping, lower triangle."""
    whole: Floats
    """(n, n) the matrix that is factorised, in place."""
    right: Floats
    """(n,) negative gradient without stops."""
    side: Floats
    """(n,) negative gradient with the stops that hold."""
    step: Floats
    """(n,) [rad] the step."""
    active: NDArray[np.int64]
    """(R,) 1 for a stop or plane that holds the step."""
    force: Floats
    """(6,) force [1/m] on the tip and its direction, in the gradient."""
    pushed: Floats
    """(6,) multipliers of the target."""
    press: Floats
    """(R,) multipliers of stops and planes."""
    kept: Floats
    """(K, 3) [rad] the angles before the step."""
    bend: Floats
    """(6,) force on the tip and its direction, in the Hessian."""


def new_work(joints: int, free: int, rows: int) -> DescentWorkspace:
    """Make empty working arrays for so many joints, free angles, and rows of room."""
    return DescentWorkspace(
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


@shared
def normal_equations(link, goal, p, state, work, pull, ease, bent):  # type: ignore[no-untyped-def]
    """Fill gradient and Hessian of the sum that is made least, without its stops.

    Parameters
    ----------
    link, state : Linkage, State
        The chain, with the Jacobians at its angles.
    goal : (P, 12)
        Target [m], direction, and the weights of these six numbers.
    p : int
        Row of goal.
    work : Work
        force and bend in; matrix (lower triangle) and right out.
    pull : float
        Penalty [1/m2] of the distance from the goal.
    ease : float
        Weight of comfort.
    bent : bool
        Whether the Hessian has the curvature of the tip's path and of the stops. Without it the
        step is that of Gauss and Newton.
    """
    directed = goal[p, 9] > 0.0
    _fill_gradient(link, state, work, ease, directed)
    _fill_hessian(link, goal, p, state, work, pull, ease, bent)
    if bent:
        joints = link.axes.shape[0]
        tip = vector(state.at)
        _add_swing_curvature(link, state, work.matrix, 0, joints, tip, True, vector(work.bend))
        if directed:
            direction = vector(state.at[3:])
            force = vector(work.bend[3:])
            _add_swing_curvature(link, state, work.matrix, 0, joints, direction, False, force)
        _add_stop_curvature(link, state, work)


@inlined
def _fill_hessian(link, goal, p, state, work, pull, ease, bent):  # type: ignore[no-untyped-def]
    """Fill the Hessian of comfort and of the penalties on tip and direction, lower triangle."""
    # With the Jacobian S and the squared weights w of three coordinates a penalty gives
    #     H = S' w S - Σ f . d2x/dθi dθj.
    # Free angles are numbered outward from the base, so a turn about j carries the slope of i >= j:
    #     d2x/dθi dθj = ωj x Si, so that Hij = (w Sj - f x ωj) . Si.
    n = link.mode.shape[0]
    directed = goal[p, 9] > 0.0
    tilt = pull * goal[p, 9] * goal[p, 9]
    tip = (pull * goal[p, 6] ** 2, pull * goal[p, 7] ** 2, pull * goal[p, 8] ** 2)
    for j in range(n):
        row = _hessian_row(state, work, j, 0, tip, bent)
        for i in range(j, n):
            work.matrix[i, j] = dot(vector(state.slope[i]), row)
        if directed:
            row = _hessian_row(state, work, j, 3, (tilt, tilt, tilt), bent)
            for i in range(j, n):
                work.matrix[i, j] += dot(vector(state.slope[i, 3:]), row)
        work.matrix[j, j] += ease * link.weight[j]


@inlined
def _hessian_row(state, work, j, first, weights, bent):  # type: ignore[no-untyped-def]
    """Vector w Sj - f x ωj of the tip (first 0) or of its direction (first 3)."""
    slope = vector(state.slope[j, first:])
    row = (weights[0] * slope[0], weights[1] * slope[1], weights[2] * slope[2])
    if bent:
        row = _minus_cross(row, vector(work.bend[first:]), vector(state.spin[j]))
    return row


@inlined
def _fill_gradient(link, state, work, ease, directed):  # type: ignore[no-untyped-def]
    """Fill the negative gradient: the pull of comfort, and S' f, the force on the tip."""
    numbers = 6 if directed else 3
    for i in range(link.mode.shape[0]):
        off = link.mode[i] - state.angles[link.free_joint[i], link.free_axis[i]]
        right = ease * link.weight[i] * off
        for c in range(numbers):
            right += state.slope[i, c] * work.force[c]
        work.right[i] = right


@inlined
def _minus_cross(a, f, w):  # type: ignore[no-untyped-def]
    """Vector a - f x w, each sum from left to right."""
    return (
        a[0] - f[1] * w[2] + f[2] * w[1],
        a[1] - f[2] * w[0] + f[0] * w[2],
        a[2] - f[0] * w[1] + f[1] * w[0],
    )


@inlined
def _arm(state, k, point, is_point):  # type: ignore[no-untyped-def]
    """What a turn about joint k carries: the arm from its centre, or a direction as it is."""
    if is_point:
        return subtract(point, vector(state.pivot[k]))
    return point


@inlined
def _add_swing_curvature(link, state, matrix, first, last, point, is_point, force):  # type: ignore[no-untyped-def]
    """Subtract the second derivatives, times a force, that swings of one joint give a point.

    The axes of a swing turn with the swing itself: their derivative b moves an arm r by b x r, and
    f . (b x r) = b . (r x f). Joints first..last - 1 count. A direction is no point.
    """
    for k in range(first, last):
        j = link.free_of[k, 0]
        i = link.free_of[k, 1]
        if j < 0 or i < 0:
            continue
        torque = cross(_arm(state, k, point, is_point), force)
        matrix[j, j] -= dot(vector(state.bend[k, 0]), torque)
        matrix[i, j] -= dot(vector(state.bend[k, 1]), torque)
        matrix[i, i] -= dot(vector(state.bend[k, 2]), torque)


@inlined
def _add_turn_curvature(link, state, matrix, first, last, point, is_point, force):  # type: ignore[no-untyped-def]
    """Subtract the second derivatives, times a force, that joints first..last - 1 give a point."""
    # Of two turns the outer one, j, carries the slope s of the inner one, i:
    #     f . (ωj x s) = ωj . (s x f).
    joint = link.free_joint
    for i in range(joint.shape[0]):
        k = joint[i]
        if k < first or k >= last:
            continue
        slope = cross(vector(state.spin[i]), _arm(state, k, point, is_point))
        torque = cross(slope, force)
        for j in range(i + 1):
            if joint[j] >= first:
                matrix[i, j] -= dot(vector(state.spin[j]), torque)
    _add_swing_curvature(link, state, matrix, first, last, point, is_point, force)


@inlined
def _add_cone_curvature(link, matrix, k, push, curvature):  # type: ignore[no-untyped-def]
    """Add the three second derivatives of the cone of joint k, times the force it holds with."""
    j = link.free_of[k, 0]
    i = link.free_of[k, 1]
    if j >= 0 and i >= 0:
        matrix[j, j] += push * curvature[0]
        matrix[i, j] += push * curvature[1]
        matrix[i, i] += push * curvature[2]


@inner
def _add_stop_curvature(link, state, work):  # type: ignore[no-untyped-def]
    """Add the curvature of the cones, polygons and planes that hold, times the force they hold with.

    The force of a stop that only just holds is not known yet. It counts with its multiplier and
    `UNSURE` more at most, since the whole penalty would bend the step too much.
    """
    matrix = work.matrix
    held = state.held
    for r in range(state.used[0]):
        push = min(work.press[r] + HOLD * (INSIDE - state.room[r]), work.press[r] + UNSURE)
        if not push > 0.0:
            continue
        is_plane = r >= link.rows.shape[0]
        if is_plane or link.rows[r, 1] == WHOLE_POLYGON:
            first = 0 if is_plane else link.polygon_link
            last = int(held[r, 6]) if is_plane else link.rows[r, 0] + 1
            force = scale(push, vector(held[r, 3:]))
            _add_turn_curvature(link, state, matrix, first, last, vector(held[r]), is_plane, force)
        elif link.rows[r, 1] == WHOLE_CONE:
            _add_cone_curvature(link, matrix, link.rows[r, 0], push, held[r])


@inlined
def _fill_system(link, state, work, damping):  # type: ignore[no-untyped-def]
    """Fill the system of a step: Hessian, damping, and the penalties of the active rows."""
    # The augmented Lagrangian has (max(0, press + HOLD (INSIDE - room)))2 / (2 HOLD) for a row.
    # Where the row is active, with gradient g of its room, that adds HOLD g g' to the Hessian.
    n = link.mode.shape[0]
    slope = state.slope_of_room
    for i in range(n):
        work.side[i] = work.right[i]
        for j in range(i + 1):
            work.whole[i, j] = work.matrix[i, j]
        work.whole[i, i] += damping * link.weight[i]
    for r in range(state.used[0]):
        if not work.active[r]:
            continue
        push = work.press[r] + HOLD * (INSIDE - state.room[r])
        for i in range(n):
            g = slope[r, i]
            if g != 0.0:
                work.side[i] += push * g
                for j in range(i + 1):
                    work.whole[i, j] += HOLD * g * slope[r, j]


@inlined
def _update_active_set(link, state, work):  # type: ignore[no-untyped-def]
    """Mark the rows that hold after the step, by their linear change; True if any changed."""
    changed = False
    for r in range(state.used[0]):
        after = state.room[r] - INSIDE
        for i in range(link.mode.shape[0]):
            after += state.slope_of_room[r, i] * work.step[i]
        holds = 1 if work.press[r] - HOLD * after > 0.0 else 0
        if holds != work.active[r]:
            work.active[r] = holds
            changed = True
    return changed


@shared
def newton(link, state, work, damping):  # type: ignore[no-untyped-def]
    """Solve for the damped step; False if its system is not positive definite.

    Parameters
    ----------
    link, state : Linkage, State
        The chain, with its room to the stops and planes.
    work : Work
        matrix, right and press in; step, side and active out.
    damping : float
        μ, as a multiple of the comfort weights.
    """
    for r in range(state.used[0]):
        holds = work.press[r] + HOLD * (INSIDE - state.room[r]) > 0.0
        work.active[r] = 1 if holds else 0
    for _ in range(MOST_TURNS):
        _fill_system(link, state, work, damping)
        if not factorise(work.whole, LEAST_CURVATURE):
            return False
        substitute(work.whole, work.side, work.step)
        if not _update_active_set(link, state, work):
            return True
    return True


@inlined
def take_step(link, state, work):  # type: ignore[no-untyped-def]
    """Add the step to the angles, shortened to `MOST_STEP`, and keep the old angles.

    Returns the largest change of an angle [rad].
    """
    largest = 0.0
    for i in range(link.mode.shape[0]):
        largest = max(largest, abs(work.step[i]))
    share = min(1.0, MOST_STEP / max(largest, 1e-300))
    for i in range(link.mode.shape[0]):
        k = link.free_joint[i]
        axis = link.free_axis[i]
        work.kept[k, axis] = state.angles[k, axis]
        moved = state.angles[k, axis] + share * work.step[i]
        state.angles[k, axis] = np.rint(moved * GRID) / GRID
    return share * largest


@inlined
def undo_step(link, state, work):  # type: ignore[no-untyped-def]
    """Put the angles back to where they were before the last step."""
    for i in range(link.mode.shape[0]):
        k = link.free_joint[i]
        axis = link.free_axis[i]
        state.angles[k, axis] = work.kept[k, axis]


@inlined
def update_multipliers(goal, p, state, work, pull, both):  # type: ignore[no-untyped-def]
    """Update the multipliers after a step: of the stops and planes, and of the goal if `both`."""
    # Hestenes and Powell: λ <- λ + penalty x violation, at least 0 for an inequality.
    for r in range(state.used[0]):
        work.press[r] = max(0.0, work.press[r] + HOLD * (INSIDE - state.room[r]))
    if both:
        for i in range(6):
            work.pushed[i] += pull * goal[p, 6 + i] * (goal[p, i] - state.at[i])
