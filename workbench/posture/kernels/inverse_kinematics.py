"""Batch inverse kinematics: each row is one chain with a target of its own.

A row is solved by descents (`posture.kernels.descent`) from its own start, from a solution near by,
or from seeds, in this order:

1. A solution near by, with its multipliers: the row is there in a few steps.
2. The row's own start.
3. Seeds that have not been tried, those first whose tips are nearest to the target.

Rows know nothing of one another.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner, shared
from workbench.geometry.vectors import (
    rotation_part,
    subtract,
    transpose_matvec,
    vector,
)
from workbench.posture.kernels.augmented_lagrangian import (
    DISTANT_EASE,
    LAST_PENALTY,
    LEAST_EASE,
    REACHED,
    evaluate,
    minimize,
    minimize_distance,
    put_row,
    take,
    take_row,
)
from workbench.posture.kernels.chain_kinematics import ChainState, forward_kinematics, new_state
from workbench.posture.kernels.inequality_constraints import clamp_angles
from workbench.posture.kernels.newton_step import DescentWorkspace, new_work

__all__ = [
    "DESCENT_STEPS",
    "LEGAL",
    "NEARLY",
    "ChainWorkspace",
    "Search",
    "Seeds",
    "Solutions",
    "greatest_breach",
    "holder",
    "new_chain_workspace",
    "next_seed",
    "place_chains",
    "place_seeds",
    "residual",
    "solve_chain",
    "solve_chains",
]

COLD = 0
WARM = 1
MISSED_BEFORE = 2
"""How a descent begins: without multipliers, with those of a solution near by, or with those of a
target near by that was missed."""
DESCENT_STEPS = 90
"""Steps of a descent at most."""
HASTE = 10
"""Steps after which a descent with multipliers is given up for one without."""
WIDE = 0.03
"""Miss [m] of the solution near by beyond which nothing else is tried."""
FEW_AGAIN = 2
"""Seeds that are tried at most after a solution near by that reached its own target."""
NEARLY = 2e-3
"""Distance [m] within which a target that is missed may still be reached: it is approached again
with the least comfort, and about obstacles."""
LEGAL = 5e-4
"""Breach [rad, m] below which a solution is within the stops."""


class Seeds(NamedTuple):
    """Postures to begin again from, the same ones for all rows of a body."""

    angles: NDArray[np.float64]
    """(M, K, 3) joint angles [rad] within the stops."""
    tips: NDArray[np.float64]
    """(B, M, 6) tip [m] and direction in the frame of the held link, by row of the body; filled
    when first needed."""
    placed: NDArray[np.int64]
    """(B,) 1 where the tips of a row are filled."""
    origin: NDArray[np.float64]
    """(1, 3, 4) the frame of the held link in itself."""


class Search(NamedTuple):
    """How long a row is searched."""

    steps: int
    """Steps of one descent at most."""
    seeds: Seeds
    """Postures to begin again from."""
    again: int
    """How many of them at most."""


class Solutions(NamedTuple):
    """Solutions of P rows, with R stops, filled in place."""

    angles: NDArray[np.float64]
    """(P, K, 3) [rad] the starts in, the solutions out."""
    numbers: NDArray[np.float64]
    """(P, 8) distance from the target [m], greatest breach of a stop or plane [rad, m], steps, and
    what holds the chain: joint, axis and side of a stop (-1, number and 0 of a plane), how much it
    would give [m/rad, m/m], and 1; zeros where nothing holds."""
    held: NDArray[np.float64]
    """(P, 6 + R) multipliers of the target and of the stops."""


class ChainWorkspace(NamedTuple):
    """Working arrays of one row at a time."""

    state: ChainState
    work: DescentWorkspace
    tried: NDArray[np.int64]
    """(M,) 1 for a seed that was used for the row."""
    best: NDArray[np.float64]
    """(K, 3) [rad] the best angles of the row."""


def new_chain_workspace(joints: int, free: int, rows: int, seeds: int) -> ChainWorkspace:
    """Make working arrays for so many joints, free angles, rows of room, and seeds."""
    return ChainWorkspace(
        new_state(joints, free, rows),
        new_work(joints, free, rows),
        np.zeros(seeds, np.int64),
        np.zeros((joints, 3)),
    )


@inlined
def greatest_breach(state):  # type: ignore[no-untyped-def]
    """Greatest breach [rad, m] of the stops and planes of a state, 0 if all have room."""
    breach = 0.0
    for r in range(state.used[0]):
        breach = max(breach, -state.room[r])
    return breach


@inlined
def residual(goal, p, state):  # type: ignore[no-untyped-def]
    """Measure the weighted distance from the goal [m] and the greatest breach of a state."""
    gap = 0.0
    for i in range(6):
        gap += (goal[p, 6 + i] * (goal[p, i] - state.at[i])) ** 2
    return math.sqrt(gap), greatest_breach(state)


@inner
def place_seeds(link, b, seeds, state):  # type: ignore[no-untyped-def]
    """Fill the tips of the seeds for row b of a body, unless they are filled."""
    if seeds.placed[b] == 1:
        return
    for s in range(seeds.angles.shape[0]):
        take_row(seeds.angles, s, state.angles)
        forward_kinematics(link, b, seeds.origin, 0, state)
        for i in range(6):
            seeds.tips[b, s, i] = state.at[i]
    seeds.placed[b] = 1


@inner
def next_seed(base, goal, p, seeds, b, tried):  # type: ignore[no-untyped-def]
    """Choose the seed whose tip and direction are nearest to the goal of row p.

    Seeds that were tried are left out. Returns -1 if none is left.
    """
    rotation = rotation_part(base[p])
    origin = (base[p, 0, 3], base[p, 1, 3], base[p, 2, 3])
    target = transpose_matvec(rotation, subtract(vector(goal[p]), origin))
    direction = transpose_matvec(rotation, vector(goal[p, 3:]))
    best = -1
    least = np.inf
    for s in range(seeds.angles.shape[0]):
        gap = 0.0
        for i in range(3):
            gap += (goal[p, 6 + i] * (target[i] - seeds.tips[b, s, i])) ** 2
        for i in range(3):
            gap += (goal[p, 9 + i] * (direction[i] - seeds.tips[b, s, 3 + i])) ** 2
        if gap < least and tried[s] == 0:
            best = s
            least = gap
    return best


@inlined
def holder(state, press, force, p, numbers):  # type: ignore[no-untyped-def]
    """Fill numbers[p, 3:] of `Solutions` with the stop or plane under most pressure.

    How much it would give is its multiplier divided by the force [1/m] at the tip: how far the tip
    would come if the stop gave way by one unit.
    """
    best = -1
    for i in range(3, 8):
        numbers[p, i] = 0.0
    for r in range(state.used[0]):
        if press[r] > (press[best] if best >= 0 else 0.0):
            best = r
    if best >= 0 and force > 0.0:
        for i in range(3):
            numbers[p, 3 + i] = state.label[best, i]
        numbers[p, 6] = press[best] / force
        numbers[p, 7] = 1.0


@inner
def _keep_better(link, b, problem, p, planes, span, pull, out, workspace):  # type: ignore[no-untyped-def]
    """Keep the angles of a descent if they are better than the best so far; returns their distance.

    A posture within the stops is better than one that is not. Of two such the nearer is better, and
    one that reaches the target replaces any before it.
    """
    base, goal = problem
    state = workspace.state
    work = workspace.work
    clamp_angles(link, state.angles)
    evaluate(link, b, base, p, planes, span, state)
    gap, past = residual(goal, p, state)
    error = out.numbers[p, 0]
    breach = out.numbers[p, 1]
    if (past < LEGAL and breach >= LEGAL) or (
        past < max(LEGAL, breach) and (gap < error or gap < REACHED)
    ):
        out.numbers[p, 0] = gap
        out.numbers[p, 1] = past
        take(state.angles, workspace.best)
        for i in range(6):
            out.held[p, i] = work.pushed[i]
        for i in range(link.rows.shape[0]):
            out.held[p, 6 + i] = work.press[i]
        holder(state, work.press, pull * gap, p, out.numbers)
    return gap


@inner
def _descend_and_keep(link, b, problem, p, planes, span, most, warm, out, workspace):  # type: ignore[no-untyped-def]
    """Descend straight to the target; returns whether it seems out of reach."""
    state = workspace.state
    work = workspace.work
    steps, far = minimize(link, b, problem, p, planes, span, most, warm, state, work)
    out.numbers[p, 2] += steps
    _keep_better(link, b, problem, p, planes, span, LAST_PENALTY, out, workspace)
    return far


@inner
def _approach_and_keep(link, b, problem, p, planes, span, most, ease, out, workspace):  # type: ignore[no-untyped-def]
    """Come as near to the target as can be, with so much weight of comfort; returns the distance."""
    state = workspace.state
    work = workspace.work
    steps, pull = minimize_distance(link, b, problem, p, planes, span, most, ease, state, work)
    out.numbers[p, 2] += steps
    return _keep_better(link, b, problem, p, planes, span, pull, out, workspace)


@inner
def _attempt(link, b, problem, p, planes, span, most, mode, out, workspace):  # type: ignore[no-untyped-def]
    """Solve row p from the angles of its state.

    It goes straight for the target; if that fails, as near as can be, and nearer still where that
    is nearly there; and in comfort from there if that reaches the target after all.
    """
    if mode != MISSED_BEFORE:
        warm = mode == WARM
        steps = HASTE if warm else most
        far = _descend_and_keep(link, b, problem, p, planes, span, steps, warm, out, workspace)
        if warm or not far:
            return
    gap = _approach_and_keep(link, b, problem, p, planes, span, most, DISTANT_EASE, out, workspace)
    if REACHED <= gap < NEARLY:
        gap = _approach_and_keep(
            link, b, problem, p, planes, span, most, LEAST_EASE, out, workspace
        )
    if gap < REACHED:
        _descend_and_keep(link, b, problem, p, planes, span, most, False, out, workspace)


@inlined
def _begin_row(link, again, out, p, near, workspace):  # type: ignore[no-untyped-def]
    """Clear row p; returns how its first descent begins, and how many seeds may follow."""
    mode = COLD
    seeds = again
    take_row(out.angles, p, workspace.best)
    workspace.tried[:] = 0
    if near and out.numbers[p, 1] < LEGAL:
        mode = WARM
        seeds = min(again, FEW_AGAIN)
        if out.numbers[p, 0] >= REACHED:
            mode = MISSED_BEFORE
            seeds = min(again, 1 if out.numbers[p, 0] < WIDE else -1)
        workspace.work.press[:] = 0.0
        for i in range(6):
            workspace.work.pushed[i] = out.held[p, i]
        for i in range(link.rows.shape[0]):
            workspace.work.press[i] = out.held[p, 6 + i]
    for i in range(8):
        out.numbers[p, i] = 0.0
    out.numbers[p, 0] = np.inf
    out.numbers[p, 1] = np.inf
    return mode, seeds


@inlined
def _take_seed(link, b, problem, p, seeds, out, workspace):  # type: ignore[no-untyped-def]
    """Set the free angles of the state to the next seed; False if none is left."""
    base, goal = problem
    state = workspace.state
    place_seeds(link, b, seeds, state)
    seed = next_seed(base, goal, p, seeds, b, workspace.tried)
    if seed < 0:
        return False
    workspace.tried[seed] = 1
    take_row(out.angles, p, state.angles)
    for d in range(link.mode.shape[0]):
        k = link.free_joint[d]
        axis = link.free_axis[d]
        state.angles[k, axis] = seeds.angles[seed, k, axis]
    return True


@shared
def solve_chain(link, b, problem, p, planes, span, search, near, out, workspace):  # type: ignore[no-untyped-def]
    """Solve row p: from the solution near by that out holds, from its own start, from seeds.

    Parameters
    ----------
    link : Linkage
        The chain of B bodies.
    b : int
        Row of the body.
    problem : tuple of two
        World-from-base transforms (P, 3, 4) [m], and goals (P, 12): target [m], direction, and the
        weights of their six numbers.
    p : int
        Row of problem and out.
    planes, span : Planes, tuple of two
        Planes that the chain must stay above: the first that counts, and the one after the last.
    search : Search
        Steps and seeds.
    near : bool
        Whether out holds a solution near by.
    out : Solutions
        The start or the solution near by in, the solution out.
    workspace : ChainWorkspace
        Working arrays.
    """
    mode, seeds = _begin_row(link, search.again, out, p, near, workspace)
    for attempt in range(-1 if mode != COLD else 0, search.again + 1):
        if attempt > 0:
            if not _take_seed(link, b, problem, p, search.seeds, out, workspace):
                break
        else:
            take_row(out.angles, p, workspace.state.angles)
        _attempt(link, b, problem, p, planes, span, search.steps, mode, out, workspace)
        reached = out.numbers[p, 0] < REACHED and out.numbers[p, 1] < LEGAL
        if reached or attempt >= seeds:
            break
        mode = COLD
    put_row(workspace.best, out.angles, p)


@batch_loop
def solve_chains(link, who, problem, planes, start, search, near, out, begin, end, workspace):  # type: ignore[no-untyped-def]
    """Solve the rows begin..end - 1 of P, each by itself.

    Parameters
    ----------
    link, problem, planes, search, out
        As of `solve_chain`.
    who : (P,)
        Row of the body of each chain.
    start : (P + 1,)
        The planes of row p are start[p]..start[p + 1] - 1.
    near : (P,)
        1 where out holds a solution near by: of the row with another target or other planes, or of
        its guide. Few seeds are tried then, and none if that solution is far from its own target.
    begin, end : int
        Rows to solve.
    workspace : ChainWorkspace
        Working arrays, with rows of room for all stops and the planes of any row.
    """
    for p in range(begin, end):
        span = (start[p], start[p + 1])
        solve_chain(link, who[p], problem, p, planes, span, search, near[p] == 1, out, workspace)


@batch_loop
def place_chains(link, who, base, angles, inside, planes, tip, breach, state):  # type: ignore[no-untyped-def]
    """Place P chains, and measure their breach of the stops.

    Parameters
    ----------
    link : Linkage
        The chain of B bodies.
    who : (P,)
        Row of the body of each chain.
    base : (P, 3, 4)
        World-from-base transforms [m].
    angles : (P, K, 3)
        Joint angles [rad].
    inside : bool
        Whether the angles are brought inside what can be clamped first, in place.
    planes : Planes
        No planes.
    tip : (P, 6)
        Filled with tips [m] and directions.
    breach : (P,)
        Filled with the greatest breach [rad] of a stop, 0 where all have room.
    state : State
        Working arrays.
    """
    for p in range(len(angles)):
        take_row(angles, p, state.angles)
        if inside:
            clamp_angles(link, state.angles)
            put_row(state.angles, angles, p)
        evaluate(link, who[p], base, p, planes, (0, 0), state)
        for i in range(6):
            tip[p, i] = state.at[i]
        breach[p] = greatest_breach(state)
