"""Batch inverse kinematics: a chain a row, each from its own start, from a solution near by, or
from seeds.

A solution near by comes with its multipliers, so that the row is there in a few steps. Rows know
nothing of one another.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import inlined, inner, njit
from workbench.posture.kernels.descent import (
    LAST,
    REACHED,
    approach,
    descend,
    look,
    put_row,
    take,
    take_row,
)
from workbench.posture.kernels.limits import within
from workbench.posture.kernels.linkage import move, new_state
from workbench.posture.kernels.newton import new_work

__all__ = [
    "LEGAL",
    "Seeds",
    "breaches",
    "holder",
    "next_seed",
    "place_seeds",
    "solve_chains",
    "tips",
    "worth",
]

COLD = 0
WARM = 1
FAR = 2
"""How a descent begins: from nothing, with multipliers, with those of a target that was missed."""
HASTE = 10
"""Steps after which a descent with multipliers is given up for one without."""
WIDE = 0.03
"""Miss [m] of the solution near by beyond which nothing else is tried."""
FEW_AGAIN = 2
"""Seeds that are tried at most after a solution near by that reached its own target."""
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


@inlined
def worth(goal, p, state):  # type: ignore[no-untyped-def]
    """Distance from the goal and greatest breach of a state whose rooms are there."""
    breach = 0.0
    gap = 0.0
    for r in range(state.used[0]):
        breach = max(breach, -state.room[r])
    for i in range(6):
        gap += (goal[p, 6 + i] * (goal[p, i] - state.at[i])) ** 2
    return math.sqrt(gap), breach


@inner
def place_seeds(link, b, seeds, state):  # type: ignore[no-untyped-def]
    """Fill the tips of the seeds for row b of a body, where they are not."""
    if seeds.placed[b] == 1:
        return
    none = np.int64(0)  # a plain 0 would have all compiled for itself
    for s in range(seeds.angles.shape[0]):
        take_row(seeds.angles, s, state.angles)
        move(link, b, seeds.origin, none, state)
        for i in range(6):
            seeds.tips[b, s, i] = state.at[i]
    seeds.placed[b] = 1


@inner
def next_seed(base, goal, p, seeds, b, tried):  # type: ignore[no-untyped-def]
    """The seed not yet tried whose tip and direction, for row b of the body, are nearest to the
    goal of row p; -1 where none is left."""
    best = -1
    least = np.inf
    for s in range(seeds.angles.shape[0]):
        gap = 0.0
        for i in range(6):
            local = 0.0
            for m in range(3):
                local += base[p, m, i % 3] * (
                    goal[p, m + i - i % 3] - (base[p, m, 3] if i < 3 else 0.0)
                )
            gap += (goal[p, 6 + i] * (local - seeds.tips[b, s, i])) ** 2
        if gap < least and tried[s] == 0:
            best = s
            least = gap
    return best


@inlined
def holder(state, press, force, p, numbers):  # type: ignore[no-untyped-def]
    """Fill numbers[p, 3:]: joint, axis, side of the stop under most pressure (or -1 and a plane's
    number), how much it would give [m/rad, m/m] and 1.0; zeros where nothing is held."""
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
def _attempt(link, b, problem, planes, most, out, p, mode, before, state, work, best):  # type: ignore[no-untyped-def]
    """Solve row p from the angles of a state: straight for it; if that fails as near as can be; in
    comfort if that gets there. Keeps in best what is better than before (distance, breach), and
    returns the better."""
    base, goal = problem
    rows, start = planes
    _, numbers, held = out
    error, breach = before
    span = (start[p], start[p + 1])
    far = mode == FAR
    pull = LAST
    for turn in range(3):
        if turn == 1:
            steps, pull = approach(link, b, problem, p, rows, span, most, state, work)
        elif turn == 2 or not far:
            some = HASTE if mode == WARM else most
            steps, far = descend(link, b, problem, p, rows, span, some, mode == WARM, state, work)
            pull = LAST
        else:
            continue
        numbers[p, 2] += steps
        within(link, state.angles)
        look(link, b, base, p, rows, span, state)
        gap, past = worth(goal, p, state)
        if (past < LEGAL and breach >= LEGAL) or (
            past < max(LEGAL, breach) and (gap < error or gap < REACHED)
        ):
            error = gap
            breach = past
            take(state.angles, best)
            for i in range(6 + link.rows.shape[0]):
                held[p, i] = work.pushed[i] if i < 6 else work.press[i - 6]
            holder(state, work.press, pull * gap, p, numbers)
        if mode == WARM or not far or (turn == 1 and gap >= REACHED):
            break
    return error, breach


@inner
def _row(link, b, problem, planes, settings, out, p, near, state, work, tried, best):  # type: ignore[no-untyped-def]
    """Solve row p: from the solution near by that out holds, from its own start, from seeds."""
    base, goal = problem
    most, seeds, again = settings
    angles, numbers, held = out
    stops = link.rows.shape[0]
    free = link.mode.shape[0]
    error = np.inf
    breach = np.inf
    mode = COLD
    few = again
    take_row(angles, p, best)
    tried[:] = 0
    if near and numbers[p, 1] < LEGAL:
        mode, few = (
            (WARM, min(again, FEW_AGAIN))
            if numbers[p, 0] < REACHED
            else (FAR, min(again, 1 if numbers[p, 0] < WIDE else -1))
        )
        work.press[:] = 0.0
        for i in range(6 + stops):
            if i < 6:
                work.pushed[i] = held[p, i]
            else:
                work.press[i - 6] = held[p, i]
    for i in range(8):
        numbers[p, i] = 0.0
    for attempt in range(-1 if mode != COLD else 0, again + 1):
        at = attempt
        if attempt > 0:
            place_seeds(link, b, seeds, state)
            at = next_seed(base, goal, p, seeds, b, tried)
            if at < 0:
                break
            tried[at] = 1
        take_row(angles, p, state.angles)
        if attempt > 0:
            for d in range(free):
                k = link.free_joint[d]
                axis = link.free_axis[d]
                state.angles[k, axis] = seeds.angles[at, k, axis]
        error, breach = _attempt(
            link, b, problem, planes, most, out, p, mode, (error, breach), state, work, best
        )
        if (error < REACHED and breach < LEGAL) or attempt >= few:
            break
        mode = COLD
    put_row(best, angles, p)
    numbers[p, 0] = error
    numbers[p, 1] = breach


@njit(cache=True, nogil=True)
def solve_chains(link, who, problem, planes, settings, out, near, begin, end):  # type: ignore[no-untyped-def]
    """Solve the chains begin..end of P, each by itself, chain p of body who[p].

    problem: base (P, 3, 4), goal (P, 12): target, direction, weights of each. planes: rows of
    Planes and start (P + 1,). settings: most steps, Seeds to begin again from, and from how many.
    out: angles (P, K, 3), the start in and the solution out; numbers (P, 8): error, breach, steps,
    and what holds (5); held (P, 6 + R): multipliers of target and stops. near (P,): 1 where out
    holds a solution near by: of the row with another target or other planes, or of its guide. Then
    few seeds are tried, and none where that solution is far from its own target.
    """
    start = planes[1]
    joints = link.axes.shape[0]
    free = link.mode.shape[0]
    widest = 0
    for p in range(begin, end):
        widest = max(widest, start[p + 1] - start[p])
    state = new_state(joints, free, len(link.rows) + widest)
    work = new_work(joints, free, len(link.rows) + widest)
    tried = np.zeros(len(settings[1].angles), np.int64)
    best = np.zeros((joints, 3))
    for p in range(begin, end):
        _row(
            link, who[p], problem, planes, settings, out, p, near[p] == 1, state, work, tried, best
        )


@njit(cache=True, nogil=True)
def tips(link, who, base, angles, out):  # type: ignore[no-untyped-def]
    """Fill out (P, 6) with tip and direction at angles (P, K, 3), chain p of body who[p]."""
    state = new_state(link.axes.shape[0], link.mode.shape[0], 1)
    for p in range(len(angles)):
        take_row(angles, p, state.angles)
        move(link, who[p], base, p, state)
        for i in range(6):
            out[p, i] = state.at[i]


@njit(cache=True)
def breaches(link, planes, angles, out):  # type: ignore[no-untyped-def]
    """Bring angles (P, K, 3) inside what can be clipped, and fill out (P,) with the greatest breach
    that is left."""
    state = new_state(link.axes.shape[0], link.mode.shape[0], len(link.rows))
    base = np.zeros((1, 3, 4))
    none = np.int64(0)  # a plain 0 would have all compiled for itself
    for i in range(3):
        base[0, i, i] = 1.0
    for p in range(len(angles)):
        take_row(angles, p, state.angles)
        within(link, state.angles)
        look(link, none, base, none, planes, (none, none), state)
        put_row(state.angles, angles, p)
        out[p] = 0.0
        for r in range(state.used[0]):
            out[p] = max(out[p], -state.room[r])
