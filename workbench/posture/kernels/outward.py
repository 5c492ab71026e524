"""How far out along a ray a chain still reaches: the tip held to the ray and pushed outward until
stops and length hold it, each row from its own start or from a solution near by.

What is made least is the push's potential and a little comfort, held to the ray (equalities) and to
the stops (inequalities) by the method of multipliers, each step damped by how much of what it
promised it kept (Nocedal & Wright 2006, Numerical Optimization, chapters 4 and 17).
"""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import inner, njit
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
def _along(ray, p, base, turn, own, goal):  # type: ignore[no-untyped-def]
    """Turn the world so that ray[p], a point and a direction, runs along x: base[p] into own, the
    ray into goal; fills turn (3, 3), whose rows are the new axes."""
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
    axes = ((x, y, z), (u, v, w), (y * w - z * v, z * u - x * w, x * v - y * u))
    for i in range(3):
        a, b, c = axes[i]
        turn[i, 0] = a
        turn[i, 1] = b
        turn[i, 2] = c
        for m in range(4):
            own[0, i, m] = a * base[p, 0, m] + b * base[p, 1, m] + c * base[p, 2, m]
        goal[0, i] = a * ray[p, 0] + b * ray[p, 1] + c * ray[p, 2]
        goal[0, 6 + i] = 1.0 if i > 0 else 0.0


@inner
def _begin(link, p, turn, angles, held, state, work):  # type: ignore[no-untyped-def]
    """Stand at angles[p] with the multipliers held[p], those of the ray turned into its axes."""
    take_row(angles, p, state.angles)
    for i in range(3):
        work.pushed[i] = turn[i, 0] * held[p, 0] + turn[i, 1] * held[p, 1] + turn[i, 2] * held[p, 2]
        work.pushed[3 + i] = 0.0
    for i in range(link.rows.shape[0]):
        work.press[i] = held[p, 6 + i]


@inner
def _rest(link, work):  # type: ignore[no-untyped-def]
    """Drop all multipliers."""
    for i in range(6):
        work.pushed[i] = 0.0
    for i in range(link.rows.shape[0]):
        work.press[i] = 0.0


@inner
def _try(link, b, own, turn, goals, planes, most, p, far, capped, warm, out, state, work, best):  # type: ignore[no-untyped-def]
    """Bring row p from a state to the far end of its ray, or as far as it goes; True where it came
    to rest. Keeps what is better."""
    goal, end = goals
    _, held, ways, steps = out
    none = np.int64(0)  # a plain 0 would have all compiled for itself
    if capped:
        count, left = descend(
            link, b, (own, end), none, planes, (none, none), most, warm, state, work
        )
        rested = not left
    else:
        rested, count = _extend(link, b, own, goal, planes, most, warm, state, work)
    steps[p] += count
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
    if off < 2.0 * ON_RAY and breach < LEGAL and way > ways[p]:
        ways[p] = way
        take(state.angles, best)
        for i in range(3):
            held[p, i] = (
                turn[0, i] * work.pushed[0]
                + turn[1, i] * work.pushed[1]
                + turn[2, i] * work.pushed[2]
            )
        for i in range(link.rows.shape[0]):
            held[p, 6 + i] = work.press[i]
        return rested
    return False


@njit(cache=True, nogil=True)
def reach_outward(link, who, base, rays, planes, far, most, near, out, begin, end):  # type: ignore[no-untyped-def]
    """How far the chains begin..end of P reach along rays (P, 6), a point and a unit direction
    each, up to `far` [m].

    base (P, 3, 4); planes: none. near: what guides have come to: angles (P, K, 3), multipliers (P,
    6 + R) of the world and the stops, and their ways (P,) [m], -inf where there is no guide. out:
    angles (P, K, 3), in a start that reaches the point, out where it came to; held (P, 6 + R):
    multipliers; ways (P,) [m]: how far beyond the point, `far` itself where that is reached, -inf
    where nothing on the ray was; steps (P,). The row's own start is tried where the guide leads
    nowhere.
    """
    joints = link.axes.shape[0]
    stops = link.rows.shape[0]
    guides, pressed, came = near
    ways = out[2]
    state = new_state(joints, link.mode.shape[0], stops)
    work = new_work(joints, link.mode.shape[0], stops)
    own = np.zeros((1, 3, 4))
    turn = np.zeros((3, 3))
    best = np.zeros((joints, 3))
    goal = np.zeros((1, 12))
    last = np.zeros((1, 12))
    for p in range(begin, end):
        _along(rays, p, base, turn, own, goal)
        last[:] = goal
        last[0, 0] = goal[0, 0] + far
        last[0, 6] = 1.0
        ways[p] = -np.inf
        take_row(out[0], p, best)
        # what the guide could do is tried first, then the other, then both from the row's own start
        for attempt in range(0 if came[p] > -np.inf else 2, 4):
            guided = attempt < 2
            capped = (came[p] == far) == (attempt == 0) if guided else attempt == 2
            some = min(MOST_WARM, most) if guided else most
            if attempt == 1 and not capped and ways[p] > -np.inf:
                continue
            if guided:
                _begin(link, p, turn, guides, pressed, state, work)
            else:
                take_row(out[0], p, state.angles)
                _rest(link, work)
            if _try(
                link,
                who[p],
                own,
                turn,
                (goal, last),
                planes,
                some,
                p,
                far,
                capped,
                guided,
                out,
                state,
                work,
                best,
            ):
                break
        put_row(best, out[0], p)
