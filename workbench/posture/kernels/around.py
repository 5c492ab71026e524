"""Reaches kept off obstacles: from a posture that enters something to one that reaches the target
and enters nothing.

A row is led away in comfort first: what its posture enters becomes walls that its spheres must stay
behind, and the posture is solved again from where it stands. Where that fails, the tip is brought
to the target, the spheres out of the obstacles and the joints within their stops at once, comfort
aside: damped Gauss-Newton steps, with walls made anew of the contacts at each. They begin at the
row's own posture, then at postures of all kinds that reach the target, those first that enter
least. What comes clear is made comfortable afterwards. A row knows of no other row.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit
from workbench.contact.kernels.inner import inlined, inner
from workbench.posture.kernels.contacts import new_space, touch
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
from workbench.posture.kernels.inverse import LEGAL, holder, next_seed, place_seeds, worth
from workbench.posture.kernels.limits import within
from workbench.posture.kernels.linkage import new_state
from workbench.posture.kernels.newton import equations, go, new_work, newton
from workbench.posture.kernels.walls import CLEAR, MOST_WALLS, build, new_desk

__all__ = ["Trail", "settle"]

NEAR = 0.03
HINT = 2e-3
"""How near [m] an obstacle is minded where a clear posture is made comfortable, and where one is
sought."""
STEPS = 24
FEW = 16
"""Steps of a descent against walls, and of one to where walls end."""
TURNS = 6
LAST_TURNS = 2
MOST_TURNS = 12
EASY_TURNS = 3
"""How often walls are added: to a target that is reached but for obstacles; to another; on the way
to where a limb gets with obstacles; how often a clear posture is made more comfortable."""
MOST_NEW = 8
"""Walls that a turn adds."""
MOST_LOST = 1
"""Times that walls may keep the target out of reach before comfort is given up."""
LOTS = (8, 24)
"""How many starts a search takes, one lot after the other."""
CLOSE = 0.01
OFF = 0.05
"""Distance [m] and breach [rad] within which a posture that the search begins at reaches the
target."""
WALKS = 32
WAY = 24
"""How many ways back from obstacles are gone, and their steps."""
MOST_JOINT = 60
MOST_SLOW = 10
BETTER = 0.97
"""Steps toward target, clearance and stops at once; those in a row that leave more than so much of
what is missing."""
PULL = 1e4
EASE = 1e-4
DAMPING = 1.0
ARRIVED = 5e-5
INSIDE = 2e-4
RADIAN = 0.3
"""Distance [m] and breach [rad] with which such steps have arrived; what a radian past a stop
counts [m]."""
GAIN = 0.98
"""Share of the discomfort above which no further turn is worth it."""


class Trail(NamedTuple):
    """What P rows have come to: angles (P, K, 3), numbers (P, 8) and held (P, 6 + R) as in
    limbs.inverse; overlap (P,) [m]; part (P,) that is entered deepest or holds the limb, -1 where
    none."""

    angles: NDArray[np.float64]
    numbers: NDArray[np.float64]
    held: NDArray[np.float64]
    overlap: NDArray[np.float64]
    part: NDArray[np.int64]


@inner
def _look_at(job, desk, state, space):  # type: ignore[no-untyped-def]
    """Bring the angles of a state inside what can be clipped, and look at them: distance from the
    target, breach of the stops, overlap, the part that is entered deepest or -1, and how many
    contacts are in space."""
    link, limbs, b, problem, held, room, p = job
    base, goal = problem
    none = np.int64(0)
    breach = 0.0  # a plain 0 would have all that it is passed to compiled for itself
    within(link, state.angles)
    look(link, b, base, p, desk.planes, (none, desk.many[0]), state)
    error, _ = worth(goal, p, state)
    for r in range(link.rows.shape[0]):
        breach = max(breach, -state.room[r])
    put_row(state.angles, desk.trial, 0)
    count = touch(limbs, b, held, base, p, desk.trial, none, room, CLEAR, space)
    overlap = max(0.0, space.found[0, 0, 0]) if count > 0 else 0.0
    part = room.owner[int(space.found[0, 0, 2])] if overlap > 0.0 else -1
    return error, breach, overlap, part, count


@inner
def _keep(link, p, worthy, force, trail, desk, state, work):  # type: ignore[no-untyped-def]
    """Keep the state for row p."""
    error, breach, overlap, part, _ = worthy
    numbers = trail.numbers
    put_row(state.angles, trail.angles, p)
    numbers[p, 0] = error
    numbers[p, 1] = breach
    trail.overlap[p] = overlap
    trail.part[p] = part
    holder(state, work.press, force, p, numbers)
    if overlap <= 0.0 and numbers[p, 7] > 0.0 and numbers[p, 3] < 0.0:
        trail.part[p] = int(desk.walls[int(numbers[p, 4]), 5])
    for i in range(6 + link.rows.shape[0]):
        trail.held[p, i] = work.pushed[i] if i < 6 else work.press[i - 6]


@inlined
def _arrived(worthy):  # type: ignore[no-untyped-def]
    """Whether a state that was looked at reaches the target within the stops and enters nothing."""
    error, breach, overlap, _, _ = worthy
    return overlap <= 0.0 and error < REACHED and breach < LEGAL


@inlined
def _less(worthy, p, trail):  # type: ignore[no-untyped-def]
    """Whether a state that was looked at is better than what is kept for row p: clear, then nearer
    to the target."""
    error, breach, overlap, _, _ = worthy
    if breach >= LEGAL:
        return False
    if (overlap <= 0.0) != (trail.overlap[p] <= 0.0):
        return overlap <= 0.0
    return error + 2.0 * overlap < trail.numbers[p, 0] + 2.0 * trail.overlap[p] - 1e-9


@inner
def _rounds(job, turns, easy, trail, desk, state, work, space):  # type: ignore[no-untyped-def]
    """Solve a row from a state against walls, and with what it enters as more of them, until it
    enters nothing: in comfort where easy, else as near to the target as can be. True where it
    reaches the target then. What is better than what is kept is kept."""
    link, limbs, b, problem, _, room, p = job
    stops = link.rows.shape[0]
    none = np.int64(0)
    lost = 0
    anew = np.bool_(False)
    most = np.int64(FEW if easy else STEPS)
    warm = np.bool_(True)
    for _ in range(turns):
        span = (none, desk.many[0])
        pull = LAST
        far = True
        if easy:
            steps, far = descend(
                link, b, problem, p, desk.planes, span, np.int64(STEPS), warm, state, work
            )
            trail.numbers[p, 2] += steps
        if far:
            steps, pull = approach(link, b, problem, p, desk.planes, span, most, state, work)
            trail.numbers[p, 2] += steps
        worthy = _look_at(job, desk, state, space)
        if _less(worthy, p, trail):
            _keep(link, p, worthy, pull * worthy[0], trail, desk, state, work)
        lost += 1 if easy and worthy[0] >= REACHED else 0
        if worthy[2] <= 0.0 or lost > MOST_LOST:
            return _arrived(worthy)
        build(limbs, b, room, min(worthy[4], MOST_NEW), stops, anew, space, desk, work)
    return False


@inner
def _join(job, trail, desk, state, work, space):  # type: ignore[no-untyped-def]
    """Bring the tip to the target, the spheres out of obstacles and the angles within the stops at
    once, comfort aside, against walls of the contacts at each step; True where all three are
    had."""
    link, limbs, b, problem, held, room, p = job
    base, goal = problem
    stops = link.rows.shape[0]
    none = np.int64(0)
    bent = np.bool_(False)
    anew = np.bool_(True)
    least = np.inf
    slow = 0
    work.pushed[:] = 0.0
    work.press[:] = 0.0
    for _ in range(MOST_JOINT):
        put_row(state.angles, desk.trial, 0)
        count = touch(limbs, b, held, base, p, desk.trial, none, room, HINT, space)
        depth = max(0.0, space.found[0, 0, 0] + CLEAR) if count > 0 else 0.0
        build(limbs, b, room, count, stops, anew, space, desk, work)
        look(link, b, base, p, desk.planes, (none, desk.many[0]), state)
        error, _ = worth(goal, p, state)
        for i in range(6):
            work.force[i] = PULL * goal[p, 6 + i] ** 2 * (goal[p, i] - state.at[i])
        breach = 0.0
        for r in range(stops):
            breach = max(breach, -state.room[r])
        if error < ARRIVED and depth <= 0.0 and breach < INSIDE:
            return _arrived(_look_at(job, desk, state, space))
        left = error + depth + RADIAN * breach
        slow = 0 if left < BETTER * least else slow + 1
        least = min(least, left)
        if slow > MOST_SLOW:
            return False
        equations(link, goal, p, state, work, PULL, EASE, bent)
        trail.numbers[p, 2] += 1
        if not newton(link, state, work, DAMPING):
            return False
        go(link, state, work)
    return False


@inlined
def _discomfort(link, angles):  # type: ignore[no-untyped-def]
    """The weighted square of the distance of angles (K, 3) from the comfort modes."""
    total = 0.0
    for i in range(link.mode.shape[0]):
        off = angles[link.free_joint[i], link.free_axis[i]] - link.mode[i]
        total += link.weight[i] * off * off
    return total


@inner
def _ease(job, trail, desk, state, work, space):  # type: ignore[no-untyped-def]
    """Make a state that has arrived comfortable, against walls of all that is near; what arrives
    and is better is kept in the place of it."""
    link, limbs, b, problem, held, room, p = job
    stops = link.rows.shape[0]
    none = np.int64(0)
    anew = np.bool_(True)
    warm = np.bool_(False)
    _keep(link, p, _look_at(job, desk, state, space), 0.0, trail, desk, state, work)
    best = _discomfort(link, state.angles)
    for _ in range(EASY_TURNS):
        put_row(state.angles, desk.trial, 0)
        count = touch(limbs, b, held, problem[0], p, desk.trial, none, room, NEAR, space)
        build(limbs, b, room, count, stops, anew, space, desk, work)
        steps, _ = descend(
            link,
            b,
            problem,
            p,
            desk.planes,
            (none, desk.many[0]),
            np.int64(STEPS),
            warm,
            state,
            work,
        )
        trail.numbers[p, 2] += steps
        worthy = _look_at(job, desk, state, space)
        if _arrived(worthy):
            value = _discomfort(link, state.angles)
            if value < best:
                _keep(link, p, worthy, 0.0, trail, desk, state, work)
            if value > GAIN * best:
                return
            best = value
        elif worthy[0] >= CLOSE:
            return


@inner
def _starts(job, seeds, lot, desk, state, work, space):  # type: ignore[no-untyped-def]
    """Up to `lot` postures of all kinds that reach the target but for obstacles, from seeds not yet
    tried, into desk.kept, and how deep they enter into desk.depth; returns how many."""
    link, _, b, problem, _, _, p = job
    base, goal = problem
    place_seeds(link, b, seeds, state)
    count = 0
    none = np.int64(0)
    desk.depth[:] = np.inf
    for _ in range(lot):
        at = next_seed(base, goal, p, seeds, b, desk.tried)
        if at < 0:
            break
        desk.tried[at] = 1
        take(desk.free, state.angles)
        for d in range(link.mode.shape[0]):
            k = link.free_joint[d]
            axis = link.free_axis[d]
            state.angles[k, axis] = seeds.angles[at, k, axis]
        desk.many[0] = 0
        work.press[:] = 0.0
        approach(link, b, problem, p, desk.planes, (none, none), np.int64(STEPS), state, work)
        error, breach, overlap, _, _ = _look_at(job, desk, state, space)
        if error < CLOSE and breach < OFF:
            take(state.angles, desk.kept[count])
            desk.depth[count] = overlap + error
            count += 1
    return count


@inner
def _search(job, seeds, trail, desk, state, work, space):  # type: ignore[no-untyped-def]
    """Seek a posture that arrives, from the free one and then from those of all kinds; True where
    state is one."""
    take(desk.free, state.angles)
    if _join(job, trail, desk, state, work, space):
        return True
    desk.tried[:] = 0
    for lot in LOTS:
        for _ in range(_starts(job, seeds, lot, desk, state, work, space)):
            least = 0
            for i in range(desk.depth.shape[0]):
                if desk.depth[i] < desk.depth[least]:
                    least = i
            desk.depth[least] = np.inf
            take(desk.kept[least], state.angles)
            if _join(job, trail, desk, state, work, space):
                return True
    return False


@inner
def _stand(job, angles, near, desk, state, work, space):  # type: ignore[no-untyped-def]
    """Stand at angles (K, 3), with walls of what is as near as `near` [m], and without
    multipliers."""
    link, limbs, b, problem, held, room, p = job
    none = np.int64(0)
    anew = np.bool_(True)
    take(angles, state.angles)
    work.pushed[:] = 0.0
    work.press[:] = 0.0
    put_row(state.angles, desk.trial, 0)
    count = touch(limbs, b, held, problem[0], p, desk.trial, none, room, near, space)
    build(limbs, b, room, count, link.rows.shape[0], anew, space, desk, work)


@inner
def _walk(job, seeds, desk, state, space):  # type: ignore[no-untyped-def]
    """From postures of all kinds that enter nothing straight toward the free one, as far as nothing
    is entered: into desk.kept[0] where the tip is nearest to the target then; False where there is
    none."""
    link, _, b, problem, _, _, p = job
    base, goal = problem
    place_seeds(link, b, seeds, state)
    least = np.inf
    desk.tried[:] = 0
    desk.many[0] = 0
    for _ in range(WALKS):
        at = next_seed(base, goal, p, seeds, b, desk.tried)
        if at < 0:
            break
        desk.tried[at] = 1
        for step in range(WAY + 1):
            share = step / WAY
            take(desk.free, state.angles)
            for d in range(link.mode.shape[0]):
                k = link.free_joint[d]
                axis = link.free_axis[d]
                state.angles[k, axis] = (
                    share * desk.free[k, axis] + (1.0 - share) * seeds.angles[at, k, axis]
                )
            error, breach, overlap, _, _ = _look_at(job, desk, state, space)
            if overlap > 0.0 or breach >= LEGAL:
                break
            if error < least:
                least = error
                take(state.angles, desk.kept[0])
    return least < np.inf


@inner
def _begin(job, trail, desk, state, work):  # type: ignore[no-untyped-def]
    """Stand at the free posture without walls, with the multipliers with which it was found."""
    link = job[0]
    p = job[6]
    take(desk.free, state.angles)
    desk.many[0] = 0
    work.press[:] = 0.0
    for i in range(6 + link.rows.shape[0]):
        if i < 6:
            work.pushed[i] = trail.held[p, i]
        else:
            work.press[i - 6] = trail.held[p, i]


@njit(cache=True, nogil=True)
def settle(link, limbs, who, held, problem, room, seeds, asked, trail, begin, end):  # type: ignore[no-untyped-def]
    """Keep reaches off obstacles, rows begin..end of P, each by itself.

    link, limbs: of B bodies; who (P,), held (P, J, 4), problem: base (P, 3, 4) and goal (P, 12).
    seeds: postures to begin at. asked (P,): 1 where the target may be reached
    but for obstacles, so that a search is worth it. trail: free postures in, what they have come to
    out.
    """
    joints = link.axes.shape[0]
    stops = link.rows.shape[0]
    state = new_state(joints, link.mode.shape[0], stops + MOST_WALLS)
    work = new_work(joints, link.mode.shape[0], stops + MOST_WALLS)
    space = new_space(limbs, held.shape[1])
    desk = new_desk(joints, len(seeds.angles))
    anew = np.bool_(False)
    easy = np.bool_(True)
    hard = np.bool_(False)
    for p in range(begin, end):
        job = (link, limbs, who[p], problem, held, room, p)
        take_row(trail.angles, p, desk.free)
        _begin(job, trail, desk, state, work)
        worthy = _look_at(job, desk, state, space)
        trail.overlap[p] = worthy[2]
        trail.part[p] = worthy[3]
        if worthy[2] > 0.0:
            build(limbs, who[p], room, min(worthy[4], MOST_NEW), stops, anew, space, desk, work)
            if _rounds(
                job, TURNS if asked[p] else LAST_TURNS, easy, trail, desk, state, work, space
            ):
                continue
        elif worthy[0] < REACHED:
            continue
        if asked[p] and _search(job, seeds, trail, desk, state, work, space):
            _ease(job, trail, desk, state, work, space)
            continue
        if asked[p] or trail.overlap[p] > 0.0:
            _stand(job, desk.free, CLEAR, desk, state, work, space)
            _rounds(job, np.int64(MOST_TURNS), hard, trail, desk, state, work, space)
        if trail.overlap[p] > 0.0 and _walk(job, seeds, desk, state, space):
            _stand(job, desk.kept[0], NEAR, desk, state, work, space)
            _rounds(job, np.int64(MOST_TURNS), hard, trail, desk, state, work, space)
