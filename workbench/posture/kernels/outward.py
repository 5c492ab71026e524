"""How far out along a ray a chain still reaches: the tip held to the ray and pushed outward until
stops and length hold it, each row from where the one before has come to.

What is made least is the push's potential and a little comfort, held to the ray (equalities) and to
the stops (inequalities) by the method of multipliers, each step damped by how much of what it
promised it kept (Nocedal & Wright 2006, Numerical Optimization, chapters 4 and 17).
"""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit
from workbench.contact.kernels.inner import inner
from workbench.posture.kernels.descent import (
    EASE,
    FORCE,
    KEPT,
    LAST,
    REACHED,
    descend,
    look,
    put_row,
    take,
    take_row,
)
from workbench.posture.kernels.limits import within
from workbench.posture.kernels.linkage import new_state
from workbench.posture.kernels.newton import (
    HOLD,
    INSIDE,
    back,
    equations,
    go,
    multiply,
    new_work,
    newton,
)

__all__ = ["reach_outward"]

BEGUN = 0
TRIED = 1
RETURNED = 2
STUCK = 3
ON_RAY = 5e-5
RESTED = 5e-5
SURE = 2.0
"""How near [m] to the ray, how little [m] gained by a step damped so little [-] that nothing more
is to be had."""
LEGAL = 5e-4
MOST_WARM = 12


@inner
def _cost(link, goal, state, work):  # type: ignore[no-untyped-def]
    """The sum that is made least, the distance from the ray, and the greatest breach; fills
    work.force (6,)."""
    total = -FORCE * state.at[0]
    square = 0.0
    worst = 0.0
    work.force[0] = FORCE
    for i in range(1, 3):
        off = goal[0, i] - state.at[i]
        square += off * off
        total += (0.5 * LAST * off + work.pushed[i]) * off
        work.force[i] = work.pushed[i] + LAST * off
    for i in range(link.mode.shape[0]):
        off = state.angles[link.free_joint[i], link.free_axis[i]] - link.mode[i]
        total += 0.5 * EASE * link.weight[i] * off * off
    for r in range(state.used[0]):
        breach = INSIDE - state.room[r]
        worst = max(worst, breach)
        pressed = max(0.0, work.press[r] + HOLD * breach)
        total += (0.5 / HOLD) * (pressed * pressed - work.press[r] * work.press[r])
    return total, math.sqrt(square), worst


@inner
def _extend(link, b, base, goal, planes, most, warm, state, work):  # type: ignore[no-untyped-def]
    """From the angles of a state outward along x as far as it goes; returns whether it came to rest
    there, and the number of steps. The multipliers of ray and stops are those of `work`, in and
    out."""
    damping = 0.0 if warm else 1.0
    rise = 4.0
    moved = 0.0
    cost = 0.0
    promise = 1.0
    last = -np.inf
    phase = BEGUN
    steps = 0
    none = np.int64(0)
    while steps < most and damping < 1e9:
        if phase != STUCK:
            look(link, b, base, none, planes, (none, none), state)
        after, off, worst = _cost(link, goal, state, work)
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
            if (
                damping < SURE
                and abs(state.at[0] - last) < RESTED
                and off < ON_RAY
                and worst < KEPT
            ):
                return True, steps
            last = state.at[0]
            if moved < 0.1:
                multiply(goal, none, state, work, LAST, np.bool_(True))
        if phase < RETURNED:
            cost = _cost(link, goal, state, work)[0]
            work.bend[0], work.bend[1], work.bend[2] = FORCE, work.pushed[1], work.pushed[2]
            equations(link, goal, none, state, work, LAST, EASE, np.bool_(True))
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
    return False, steps


@inner
def _along(ray, p, base, own, goal):  # type: ignore[no-untyped-def]
    """Turn the world so that ray[p], a point and a direction, runs along x: base[p] into own, the
    ray into goal."""
    x = ray[p, 3]
    y = ray[p, 4]
    z = ray[p, 5]
    # the second axis is square to the direction and to the coordinate that it has least of
    u, v, w = (0.0, z, -y) if abs(x) <= abs(y) and abs(x) <= abs(z) else (-z, 0.0, x)
    if abs(z) < abs(x) and abs(z) < abs(y):
        u = y
        v = -x
        w = 0.0
    size = math.sqrt(u * u + v * v + w * w)
    u = u / size
    v = v / size
    w = w / size
    turn = ((x, y, z), (u, v, w), (y * w - z * v, z * u - x * w, x * v - y * u))
    for i in range(3):
        a, b, c = turn[i]
        for m in range(4):
            own[0, i, m] = a * base[p, 0, m] + b * base[p, 1, m] + c * base[p, 2, m]
        goal[0, i] = a * ray[p, 0] + b * ray[p, 1] + c * ray[p, 2]
        goal[0, 6 + i] = 1.0 if i > 0 else 0.0


@inner
def _begin(link, p, lead, out, state, work):  # type: ignore[no-untyped-def]
    """Angles and multipliers of row p from where a row has come to, or of its own where lead is
    -1."""
    angles, held, _, _ = out
    take_row(angles, p, state.angles)
    for i in range(6 + link.rows.shape[0]):
        value = held[lead, i] if lead >= 0 else 0.0
        if i < 6:
            work.pushed[i] = value
        else:
            work.press[i - 6] = value
    if lead >= 0:
        for d in range(link.mode.shape[0]):
            k = link.free_joint[d]
            axis = link.free_axis[d]
            state.angles[k, axis] = angles[lead, k, axis]


@inner
def _try(link, b, own, goals, planes, most, p, far, capped, lead, out, state, work, best):  # type: ignore[no-untyped-def]
    """Bring row p to the far end of its ray, or as far as it goes; True where it came to rest.
    Keeps what is better."""
    goal, end = goals
    warm = lead >= 0
    none = np.int64(0)  # a plain 0 would have all compiled for itself
    _begin(link, p, lead, out, state, work)
    if capped:
        count, left = descend(
            link, b, (own, end), none, planes, (none, none), most, warm, state, work
        )
        rested = not left
    else:
        rested, count = _extend(link, b, own, goal, planes, most, warm, state, work)
    out[3][p] += count
    within(link, state.angles)
    look(link, b, own, none, planes, (none, none), state)
    off = math.sqrt((state.at[1] - goal[0, 1]) ** 2 + (state.at[2] - goal[0, 2]) ** 2)
    breach = 0.0
    for r in range(state.used[0]):
        breach = max(breach, -state.room[r])
    way = state.at[0] - goal[0, 0]
    if capped:
        rested = abs(way - far) < REACHED
        way = far if rested else way
    if off < 2.0 * ON_RAY and breach < LEGAL and way > out[2][p]:
        out[2][p] = way
        take(state.angles, best)
        for i in range(6 + link.rows.shape[0]):
            out[1][p, i] = work.pushed[i] if i < 6 else work.press[i - 6]
        return rested
    return False


@njit(cache=True, nogil=True)
def reach_outward(link, who, base, rays, planes, far, most, out, follow, begin, end):  # type: ignore[no-untyped-def]
    """How far the chains begin..end of P reach along rays (P, 6), a point and a unit direction
    each, up to `far` [m].

    base (P, 3, 4); planes: none. out: angles (P, K, 3), in a start that reaches the point, out
    where it came to; held (P, 6 + R): multipliers of ray and stops; ways (P,) [m]: how far beyond
    the point, `far` itself where that is reached, -inf where nothing on the ray was; steps (P,).
    follow (P,): the row, in begin..p, from whose solution to begin, -1 for the row's own start;
    that is tried besides where the other leads nowhere.
    """
    joints = link.axes.shape[0]
    stops = link.rows.shape[0]
    ways = out[2]
    state = new_state(joints, link.mode.shape[0], stops)
    work = new_work(joints, link.mode.shape[0], stops)
    own = np.zeros((1, 3, 4))
    best = np.zeros((joints, 3))
    goal = np.zeros((1, 12))
    last = np.zeros((1, 12))
    for p in range(begin, end):
        _along(rays, p, base, own, goal)
        last[:] = goal
        last[0, 0] = goal[0, 0] + far
        last[0, 6] = 1.0
        ways[p] = -np.inf
        lead = follow[p]
        take_row(out[0], p, best)
        if lead >= 0 and ways[lead] == -np.inf:
            lead = -1
        # what the one before could do is tried first, then the other, then both from the row's own
        # start
        for attempt in range(0 if lead >= 0 else 2, 4):
            like = attempt >= 2 or lead < 0
            capped = attempt % 2 == 0 if like else (ways[lead] == far) == (attempt == 0)
            some = min(MOST_WARM, most) if attempt < 2 else most
            if attempt == 1 and not capped and ways[p] > -np.inf:
                continue
            if _try(
                link,
                who[p],
                own,
                (goal, last),
                planes,
                some,
                p,
                far,
                capped,
                lead if attempt < 2 else -1,
                out,
                state,
                work,
                best,
            ):
                break
        put_row(best, out[0], p)
