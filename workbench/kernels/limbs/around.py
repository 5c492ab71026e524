"""Reaches kept off obstacles: what a posture enters becomes walls that its spheres must stay behind, and the posture is
solved again from where it stands with the multipliers that it has, until nothing is entered.

A row begins from the walls and multipliers of a row alike that has come clear, from its own free posture, from those of
a row that has not come clear, and last from postures of all kinds that reach the target, those first that enter least.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.kernels.compiled import njit
from workbench.kernels.inner import inlined, inner
from workbench.kernels.limbs.contacts import new_space, touch, wall
from workbench.kernels.limbs.descent import LAST, REACHED, approach, descend, look, put_row, take, take_row
from workbench.kernels.limbs.inverse import LEGAL, holder, next_seed, worth
from workbench.kernels.limbs.limits import Planes, within
from workbench.kernels.limbs.linkage import new_state
from workbench.kernels.limbs.newton import new_work

__all__ = ["BLOCKED", "FREE", "LED", "MISSED", "MOST_WALLS", "OWN", "SEARCH", "Trail", "settle"]

FREE, LED, BLOCKED, MISSED = 0, 1, 2, 3
"""What becomes of a row: clear at once, led around obstacles, kept from its target by them, out of reach anyway."""
FROM_FREE, FROM_FOUND = -1, -2
OWN, SEARCH = 1, 2
"""What a row tries besides following: its own free posture, a search among others."""
MOST_WALLS = 16
CLEAR = 2e-4
"""How far [m] beyond what is allowed a posture is kept off obstacles, so that rounding does not touch them."""
NEAR = 0.03
"""How near [m] an obstacle is minded at once where a reach begins again from a posture that is clear."""
STEPS, FEW = 24, 16
"""Steps of a descent against walls, and of one to where walls end."""
TURNS, LAST_TURNS = 6, 2
MOST_LOST = 1
"""Times that walls may keep the target out of reach before they are taken to close the way."""
SAME = 0.9
"""Cosine between normals of walls before the same sphere that are taken to be one."""
MOST_NEW, BEST = 8, 4


class Trail(NamedTuple):
    """What P rows have come to: angles (P, K, 3), numbers (P, 8) and held (P, 6 + R) as in limbs.inverse; overlap
    (P,) [m]; part (P,) that is entered deepest or holds the limb, -1 where none; walls (P, MOST_WALLS, 6): sphere,
    normal (3), height [m], part; press (P, MOST_WALLS); many (P,); status (P,)."""

    angles: NDArray[np.float64]
    numbers: NDArray[np.float64]
    held: NDArray[np.float64]
    overlap: NDArray[np.float64]
    part: NDArray[np.int64]
    walls: NDArray[np.float64]
    press: NDArray[np.float64]
    many: NDArray[np.int64]
    status: NDArray[np.int64]


class _Desk(NamedTuple):
    """Working space: walls (MOST_WALLS, 6) and the planes made of them, many (1,); trial (1, K, 3), free (K, 3), held
    (6 + R,), tried (M,), kept (M, K, 3), depth (M,)."""

    walls: NDArray[np.float64]
    planes: Planes
    many: NDArray[np.int64]
    trial: NDArray[np.float64]
    free: NDArray[np.float64]
    held: NDArray[np.float64]
    tried: NDArray[np.int64]
    kept: NDArray[np.float64]
    depth: NDArray[np.float64]


@njit(cache=True)
def _new_desk(joints, stops, seeds):  # type: ignore[no-untyped-def]
    planes = Planes(
        np.zeros(MOST_WALLS, np.int64), np.zeros((MOST_WALLS, 3)), np.zeros((MOST_WALLS, 3)), np.zeros(MOST_WALLS)
    )
    return _Desk(
        np.zeros((MOST_WALLS, 6)),
        planes,
        np.zeros(1, np.int64),
        np.zeros((1, joints, 3)),
        np.zeros((joints, 3)),
        np.zeros(6 + stops),
        np.zeros(seeds, np.int64),
        np.zeros((seeds, joints, 3)),
        np.zeros(seeds),
    )


@inner
def _plane(limbs, b, room, space, desk):  # type: ignore[no-untyped-def]
    """Make planes of the walls for body b, whose spheres stand as they do in space."""
    walls, planes, centres, world = desk.walls, desk.planes, space.centres, space.world
    for m in range(desk.many[0]):
        s, part = int(walls[m, 0]), int(walls[m, 5])
        n0, n1, n2 = walls[m, 1], walls[m, 2], walls[m, 3]
        k, high = limbs.carrier[s], walls[m, 4]
        d0, d1, d2 = (
            centres[0, s, 0] - world[0, k, 0, 3],
            centres[0, s, 1] - world[0, k, 1, 3],
            centres[0, s, 2] - world[0, k, 2, 3],
        )
        for i in range(3):
            planes.point[m, i] = world[0, k, 0, i] * d0 + world[0, k, 1, i] * d1 + world[0, k, 2, i] * d2
        if room.field.root.shape[0] > 1 and room.moving[part] > 0:
            high += n0 * room.shift[b, 0] + n1 * room.shift[b, 1] + n2 * room.shift[b, 2]
        planes.link[m] = limbs.link[s]
        planes.normal[m, 0], planes.normal[m, 1], planes.normal[m, 2] = n0, n1, n2
        planes.offset[m] = high + limbs.radius[b, s] - room.allowed[limbs.segment[s], part] + 2.0 * CLEAR


@inner
def _build(limbs, b, room, count, stops, space, desk, work):  # type: ignore[no-untyped-def]
    """Walls of the deepest of the `count` contacts in space: new ones, or in the place of those they follow upon."""
    walls, many = desk.walls, desk.many
    for i in range(min(count, MOST_NEW)):
        s, n0, n1, n2, high, part = wall(limbs, b, room, i, space)
        at = -1
        for m in range(many[0]):
            along = n0 * walls[m, 1] + n1 * walls[m, 2] + n2 * walls[m, 3]
            if int(walls[m, 0]) == s and along > SAME:
                at = m
        if at < 0 and many[0] < MOST_WALLS:
            at = many[0]
            many[0] += 1
            work.press[stops + at] = 0.0
        elif at < 0:
            at = 0
            for m in range(1, MOST_WALLS):
                if work.press[stops + m] < work.press[stops + at]:
                    at = m
            work.press[stops + at] = 0.0
        walls[at, 0], walls[at, 1], walls[at, 2], walls[at, 3] = s, n0, n1, n2
        walls[at, 4], walls[at, 5] = high, part
    _plane(limbs, b, room, space, desk)


@inner
def _keep(link, p, worthy, force, trail, desk, state, work):  # type: ignore[no-untyped-def]
    """Keep the state for row p with its walls, those that press or are near."""
    error, breach, overlap, part = worthy
    stops, numbers = link.rows.shape[0], trail.numbers
    put_row(state.angles, trail.angles, p)
    numbers[p, 0], numbers[p, 1], trail.overlap[p], trail.part[p] = error, breach, overlap, part
    holder(state, work.press, force, p, numbers)
    if overlap <= 0.0 and numbers[p, 7] > 0.0 and numbers[p, 3] < 0.0:
        trail.part[p] = int(desk.walls[int(numbers[p, 4]), 5])
    for i in range(6 + stops):
        trail.held[p, i] = work.pushed[i] if i < 6 else work.press[i - 6]
    trail.many[p] = 0
    for m in range(desk.many[0]):
        if work.press[stops + m] > 0.0 or state.room[stops + m] < NEAR:
            at = trail.many[p]
            trail.press[p, at] = work.press[stops + m]
            for i in range(6):
                trail.walls[p, at, i] = desk.walls[m, i]
            trail.many[p] += 1


@inner
def _rounds(link, limbs, b, problem, held, room, turns, warm, p, trail, desk, state, work, space):  # type: ignore[no-untyped-def]
    """Solve row p from a state against walls, and with what it enters as more of them, until it enters nothing; True
    where it then reaches the target. What is better than what is there is kept."""
    base, goal = problem
    stops, numbers = link.rows.shape[0], trail.numbers
    none, lost = np.int64(0), 0  # a plain 0 would have all that it is passed to compiled for itself
    for _ in range(turns):
        span, pull = (none, desk.many[0]), LAST
        steps, far = descend(link, b, problem, p, desk.planes, span, np.int64(STEPS), warm, state, work)
        if far:
            more, pull = approach(link, b, problem, p, desk.planes, span, np.int64(FEW), state, work)
            steps += more
        numbers[p, 2] += steps
        within(link, state.angles)
        look(link, b, base, p, desk.planes, span, state)
        error, _ = worth(goal, p, state)
        breach = 0.0
        for r in range(stops):
            breach = max(breach, -state.room[r])
        put_row(state.angles, desk.trial, 0)
        count = touch(limbs, b, held, base, p, desk.trial, none, room, CLEAR, space)
        overlap = max(0.0, space.found[0, 0, 0]) if count > 0 else 0.0
        part = room.owner[int(space.found[0, 0, 2])] if overlap > 0.0 else -1
        less = error + 2.0 * overlap < numbers[p, 0] + 2.0 * trail.overlap[p] - 1e-9
        if (overlap <= 0.0) != (trail.overlap[p] <= 0.0):
            less = overlap <= 0.0
        if less and breach < LEGAL:
            _keep(link, p, (error, breach, overlap, part), pull * error, trail, desk, state, work)
        lost += 1 if error >= REACHED else 0
        if overlap <= 0.0 or lost > MOST_LOST:
            return overlap <= 0.0 and error < REACHED and breach < LEGAL
        _build(limbs, b, room, count, stops, space, desk, work)
        warm = True
    return False


@inner
def _begin(link, limbs, b, p, what, base, held, room, trail, desk, state, work, space):  # type: ignore[no-untyped-def]
    """Stand where row p begins again: with a row's walls and multipliers if `what` is that row; in its own free posture
    if FROM_FREE; else in the posture that the search has found to enter least, minding all that is near. Returns how
    many contacts there are."""
    stops, near, none = link.rows.shape[0], CLEAR, np.int64(0)
    take(desk.free, state.angles)
    desk.many[0] = 0
    if what >= 0:
        for d in range(link.mode.shape[0]):
            k, axis = link.free_joint[d], link.free_axis[d]
            state.angles[k, axis] = trail.angles[what, k, axis]
        desk.many[0], near = trail.many[what], -1.0  # nothing is so deep: the spheres are to be placed only
        for m in range(desk.many[0]):
            work.press[stops + m] = trail.press[what, m]
            for i in range(6):
                desk.walls[m, i] = trail.walls[what, m, i]
    elif what == FROM_FOUND:
        least = 0
        for i in range(desk.depth.shape[0]):
            if desk.depth[i] < desk.depth[least]:
                least = i
        desk.depth[least], near = np.inf, NEAR
        take(desk.kept[least], state.angles)
    for i in range(6 + stops):
        value = trail.held[what, i] if what >= 0 else desk.held[i]
        if i < 6:
            work.pushed[i] = value
        else:
            work.press[i - 6] = value
    put_row(state.angles, desk.trial, 0)
    count = touch(limbs, b, held, base, p, desk.trial, none, room, near, space)
    _build(limbs, b, room, count, stops, space, desk, work)
    return count


@inner
def _search(link, limbs, b, problem, held, room, settings, p, trail, desk, state, work, space):  # type: ignore[no-untyped-def]
    """Postures of all kinds that reach the target of row p, and how deep they enter obstacles; returns how many."""
    base, goal = problem
    seeds, seed_tips, tries = settings
    count, none = 0, np.int64(0)
    desk.tried[:] = 0
    desk.depth[:] = np.inf
    for _ in range(tries):
        at = next_seed(base, goal, p, seed_tips, desk.tried)
        if at < 0:
            break
        desk.tried[at] = 1
        take(desk.free, state.angles)
        for d in range(link.mode.shape[0]):
            k, axis = link.free_joint[d], link.free_axis[d]
            state.angles[k, axis] = seeds[at, k, axis]
        work.press[:] = 0.0
        steps, _ = approach(link, b, problem, p, desk.planes, (none, none), np.int64(STEPS), state, work)
        trail.numbers[p, 2] += steps
        within(link, state.angles)
        look(link, b, base, p, desk.planes, (none, none), state)
        error, breach = worth(goal, p, state)
        if error > 10.0 * REACHED or breach >= LEGAL:
            continue
        put_row(state.angles, desk.trial, 0)
        touched = touch(limbs, b, held, base, p, desk.trial, none, room, CLEAR, space)
        take(state.angles, desk.kept[count])
        desk.depth[count] = space.found[0, 0, 0] if touched > 0 else 0.0
        count += 1
    return count


@inlined
def _own(p, count, asked, room, trail, desk, space):  # type: ignore[no-untyped-def]
    """Take down what the free posture of row p enters; True where that is nothing."""
    trail.overlap[p] = max(0.0, space.found[0, 0, 0]) if count > 0 else 0.0
    if trail.overlap[p] <= 0.0:
        trail.status[p] = FREE if asked else MISSED
        return True
    trail.part[p] = room.owner[int(space.found[0, 0, 2])]
    return False


@njit(cache=True, nogil=True)
def settle(link, limbs, who, held, problem, room, settings, ways, rows, trail, begin, end):  # type: ignore[no-untyped-def]
    """Keep reaches off obstacles, those that rows = (todo (Q,), guide (P,), alike (P,), asked (P,)) names, of
    todo[begin..end] one after another.

    link, limbs: of B bodies; who (P,), held (P, J, 4), problem: base (P, 3, 4) and goal (P, 12). settings: seeds
    (M, K, 3), their tips (M, 6), how many to try. ways: OWN, SEARCH. guide: a row to follow, or -1: then the last one
    alike that was led around; asked: 1 where the target would be reached but for obstacles. trail: free postures in,
    what they have come to out.
    """
    todo, guide, alike, asked = rows
    joints, stops = link.axes.shape[0], link.rows.shape[0]
    state = new_state(joints, link.mode.shape[0], stops + MOST_WALLS)
    work = new_work(joints, link.mode.shape[0], stops + MOST_WALLS)
    space, desk = new_space(limbs, held.shape[1]), _new_desk(joints, stops, len(settings[0]))
    led, stuck, group = -1, -1, -1
    for at in range(begin, end):
        p, found = todo[at], 0
        if alike[p] != group:
            led, stuck, group = -1, -1, alike[p]
        take_row(trail.angles, p, desk.free)
        for i in range(6 + stops):
            desk.held[i] = trail.held[p, i]
        lead, trail.status[p] = guide[p] if guide[p] >= 0 else led, BLOCKED if asked[p] else MISSED
        for attempt in range(4 + BEST):
            what = lead if attempt == 1 else stuck if attempt == 3 else FROM_FREE if attempt < 3 else FROM_FOUND
            if attempt == 4 and ways & SEARCH:
                found = _search(link, limbs, who[p], problem, held, room, settings, p, trail, desk, state, work, space)
            if attempt >= 4 + found or (attempt % 2 == 0 and attempt < 4 and not ways & OWN):
                continue
            if attempt in (1, 3) and not (asked[p] and what >= 0):
                continue
            count = _begin(link, limbs, who[p], p, what, problem[0], held, room, trail, desk, state, work, space)
            if attempt == 0:
                if _own(p, count, asked[p], room, trail, desk, space):
                    break
                continue
            turns = TURNS if asked[p] and attempt != 3 else LAST_TURNS
            if _rounds(
                link, limbs, who[p], problem, held, room, turns, attempt < 4, p, trail, desk, state, work, space
            ):
                trail.status[p] = LED
                break
        if trail.status[p] == LED:
            led = p
        elif trail.status[p] == BLOCKED:
            stuck = p
