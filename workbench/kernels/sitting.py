"""People in a seat, one after another: hips by the planes of the seat, feet on their pedals, the seat where that is
easiest.

What a person sits on moves a little with the thighs, and the thighs with where that person sits, so both take turns
until neither moves. From one place of the seat to the next the legs follow their own solution, multipliers and all;
and the seat goes from place to place downhill: first by how far the feet miss, then by discomfort.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.kernels.inverse import solve_chains, tips
from workbench.kernels.limb_contacts import Limbs, least_heights
from workbench.kernels.limits import Planes
from workbench.kernels.linkage import Linkage
from workbench.kernels.rotation import swing_twist_quaternion

__all__ = ["Legs", "Sitting", "seat_rows"]

HEEL, AIR = 0, 1
"""Which of a foot's two rows: the heel on the floor, or wherever it comes."""
STEPS = 90
REACHED, SHORT = 1e-4, 1e-3
"""Distances [m] within which a pedal is reached, and beyond which a foot that stays away is held against a place."""
SOME, LAST = np.array([6.0, 1e-5]), np.array([16.0, 1e-8])
"""Turns of sitting and stepping at most, and how little [m] hips at rest move from one to the next: at a place on trial,
at the place that is taken."""


class Sitting(NamedTuple):
    """How B people sit. limbs: what rests and moves with the legs; counts (2, N): which segments rest on cushion and
    back, ways (2, 3): their normals; fixed (B, 2) [m]: the least heights of what rests and does not move with the legs,
    lap (B, 3, 4): the attitude of the lower torso, at the origin; level (B, 3) [m]: the heights that are wanted on
    cushion, back and beside the middle, and solve (3, 3): the shift from how much they are off; ahead (3,): the way the
    seat travels; rise (2,) [m]: its travel up; eye (B,) [m]: the height of the lower torso that brings the eyes to
    theirs, NaN where none is asked for."""

    limbs: Limbs
    counts: NDArray[np.bool_]
    ways: NDArray[np.float64]
    fixed: NDArray[np.float64]
    lap: NDArray[np.float64]
    level: NDArray[np.float64]
    solve: NDArray[np.float64]
    ahead: NDArray[np.float64]
    rise: NDArray[np.float64]
    eye: NDArray[np.float64]


class Legs(NamedTuple):
    """The legs of B people, two (the second not looked at where `feet` is 1): links; goal (B, 2, 2, 12): of each foot
    with the heel on the floor and in the air; start (B, 2, K, 3): angles in comfort; seeds (2, M, K, 3) to begin again
    from; again (3,): from how many, with the heel down, in the air, and at first; joints (2, K) of the body; axes (J, 3, 3); floor:
    1 where heels have one; in_air: the discomfort of a heel that is not on it."""

    links: tuple[Linkage, Linkage]
    goal: NDArray[np.float64]
    start: NDArray[np.float64]
    seeds: NDArray[np.float64]
    again: NDArray[np.int64]
    joints: NDArray[np.int64]
    axes: NDArray[np.float64]
    feet: int
    floor: int
    in_air: float


class _Sitter(NamedTuple):
    """Where one person's search stands, all of it views of `all`: base (4, 3, 4): the lower torso, for each row; rows
    2 foot + HEEL or AIR: angles (4, K, 3), numbers (4, 8), held (4, 6 + R), known (4,); chosen (2,): the row that each
    foot is in; rotations (1, J, 4); up (1,) [m]."""

    all: NDArray[np.float64]
    base: NDArray[np.float64]
    angles: NDArray[np.float64]
    numbers: NDArray[np.float64]
    held: NDArray[np.float64]
    known: NDArray[np.float64]
    chosen: NDArray[np.float64]
    rotations: NDArray[np.float64]
    up: NDArray[np.float64]


class _Desk(NamedTuple):
    """What the search of one person works with: the person's number `own` (1,) and for each row `who` (4,), goal
    (4, 12), follow (4,); lap (1, 3, 4), heights (1, 2); seed_tips (2, M, 6) with told (2,), seed_who (M,), seed_base
    (M, 3, 4); planes (none) and first (5,)."""

    own: NDArray[np.int64]
    who: NDArray[np.int64]
    goal: NDArray[np.float64]
    follow: NDArray[np.int64]
    lap: NDArray[np.float64]
    heights: NDArray[np.float64]
    seed_tips: NDArray[np.float64]
    told: NDArray[np.int64]
    seed_who: NDArray[np.int64]
    seed_base: NDArray[np.float64]
    planes: Planes
    first: NDArray[np.int64]


@njit(cache=True)
def _new_sitter(links, stops, joints):  # type: ignore[no-untyped-def]
    """An empty sitter, with chains of so many links and stops."""
    ends = np.cumsum(np.array([48, 12 * links, 32, 4 * (6 + stops), 4, 2, 4 * joints, 1]))
    all_ = np.zeros(ends[-1])
    return _Sitter(
        all_, all_[: ends[0]].reshape(4, 3, 4), all_[ends[0] : ends[1]].reshape(4, links, 3),
        all_[ends[1] : ends[2]].reshape(4, 8), all_[ends[2] : ends[3]].reshape(4, 6 + stops), all_[ends[3] : ends[4]],
        all_[ends[4] : ends[5]], all_[ends[5] : ends[6]].reshape(1, joints, 4), all_[ends[6] : ends[7]],
    )  # fmt: skip


@njit(cache=True)
def _new_desk(seeds):  # type: ignore[no-untyped-def]
    """An empty desk, for so many seeds."""
    base = np.zeros((seeds, 3, 4))
    for i in range(3 * seeds):
        base[i // 3, i % 3, i % 3] = 1.0
    planes = Planes(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    return _Desk(
        np.zeros(1, np.int64), np.zeros(4, np.int64), np.zeros((4, 12)), np.zeros(4, np.int64), np.zeros((1, 3, 4)),
        np.zeros((1, 2)), np.zeros((2, seeds, 6)), np.zeros(2, np.int64), np.zeros(seeds, np.int64), base, planes,
        np.zeros(5, np.int64),
    )  # fmt: skip


@njit(cache=True, error_model="numpy", _nrt=False)
def _copy(one, other):  # type: ignore[no-untyped-def]
    """Copy numbers, one after another."""
    for i in range(one.shape[0]):
        other[i] = one[i]


@njit(cache=True, inline="always")
def _sit(sit, b, forward, sitter, desk):  # type: ignore[no-untyped-def]
    """Let person b rest on the seat at a place; returns how far that moves the hips [m]."""
    heights, who = desk.heights, desk.own
    least_heights(sit.limbs, who, sitter.rotations, desk.lap, (sit.ways, sit.counts), heights, 0, len(who))
    low = sit.level[b, 0] - min(heights[0, 0], sit.fixed[b, 0])
    rear = sit.level[b, 1] - min(heights[0, 1], sit.fixed[b, 1])
    aside, moved = sit.level[b, 2], 0.0
    z = sit.solve[2, 0] * low + sit.solve[2, 1] * rear + sit.solve[2, 2] * aside
    up = min(max(0.0, sit.rise[0]), sit.rise[1])
    if not math.isnan(sit.eye[b]):
        up = min(max(sit.eye[b] - z, sit.rise[0]), sit.rise[1])
    sitter.up[0] = up
    for i in range(3):
        at = sit.solve[i, 0] * low + sit.solve[i, 1] * rear + sit.solve[i, 2] * aside + forward * sit.ahead[i]
        if i == 2:
            at += up
        moved = max(moved, abs(at - sitter.base[0, i, 3]))
        for r in range(4):
            sitter.base[r, i, 3] = at
    return moved


@njit(cache=True, inline="always")
def _stretch(legs, foot, r, sitter, desk):  # type: ignore[no-untyped-def]
    """Solve a row of a foot, from where it was or from comfort, again from seeds where that fails; returns the miss."""
    out = (sitter.angles, sitter.numbers, sitter.held)
    problem, planes = (sitter.base, desk.goal), (desk.planes, desk.first)
    link, seeds, near = (legs.links[0] if foot == 0 else legs.links[1]), legs.seeds[foot], sitter.known[r] == 0.0 or sitter.numbers[r, 0] < REACHED
    desk.follow[r], steps = r if sitter.known[r] > 0.0 else -1, np.int64(STEPS)
    settings = (steps, seeds, desk.seed_tips[foot], legs.again[2])
    solve_chains(link, desk.who, problem, planes, settings, out, desk.follow, r, r + 1)
    sitter.known[r] = 1.0
    if sitter.numbers[r, 0] < REACHED or not near:
        return sitter.numbers[r, 0]
    if desk.told[foot] == 0:
        tips(link, desk.seed_who, desk.seed_base, seeds, desk.seed_tips[foot])
        desk.told[foot] = 1
    desk.follow[r] = -1
    settings = (steps, seeds, desk.seed_tips[foot], legs.again[r % 2])
    solve_chains(link, desk.who, problem, planes, settings, out, desk.follow, r, r + 1)
    return sitter.numbers[r, 0]


@njit(cache=True, inline="always")
def _step_on(legs, b, foot, sitter, desk):  # type: ignore[no-untyped-def]
    """Put a foot of person b on its pedal, the heel on the floor where that can be; returns miss [m], discomfort, and
    whether the heel is down."""
    r, miss = 2 * foot + HEEL, np.inf
    if legs.floor:
        miss = _stretch(legs, foot, r, sitter, desk)
    down = miss < REACHED
    if not down:
        r = 2 * foot + AIR
        if sitter.known[r] == 0.0:
            _copy(legs.start[b, foot].reshape(-1), sitter.angles[r].reshape(-1))
        miss = _stretch(legs, foot, r, sitter, desk)
    sitter.chosen[foot] = r
    link, angles, ease = (legs.links[0] if foot == 0 else legs.links[1]), sitter.angles, 0.0 if down or not legs.floor else legs.in_air
    for d in range(link.mode.shape[0]):
        off = angles[r, link.free_joint[d], link.free_axis[d]] - link.mode[d]
        ease += link.weight[d] * off * off
    for k in range(angles.shape[1]):
        j = legs.joints[foot, k]
        q = swing_twist_quaternion(legs.axes, j, angles[r, k, 0], angles[r, k, 1], angles[r, k, 2])
        for i in range(4):
            sitter.rotations[0, j, i] = q[i]
    return miss, ease, down


@njit(cache=True)
def _begin(sit, legs, b, rotations, sitter, desk):  # type: ignore[no-untyped-def]
    """Begin with person b, nothing known of any foot."""
    desk.own[0] = b
    for i in range(2):
        desk.told[i] = 0
    for i in range(desk.seed_who.shape[0]):
        desk.seed_who[i] = b
    _copy(sit.lap[b].reshape(-1), desk.lap.reshape(-1))
    _copy(rotations[b].reshape(-1), sitter.rotations.reshape(-1))
    for r in range(4):
        desk.who[r], sitter.known[r] = b, 0.0
        _copy(sit.lap[b].reshape(-1), sitter.base[r].reshape(-1))
        _copy(legs.start[b, r // 2].reshape(-1), sitter.angles[r].reshape(-1))
        _copy(legs.goal[b, r // 2, r % 2], desk.goal[r])


@njit(cache=True)
def _settle(sit, legs, b, forward, patience, sitter, desk, row):  # type: ignore[no-untyped-def]
    """Sit and put the feet on their pedals in turns, with the seat at a place; patience (2,): how many turns at most,
    and how little [m] the hips move when they are at rest. Fills row (4,): what is missed [m], discomfort, 1 where all
    is as wished, 1."""
    _sit(sit, b, forward, sitter, desk)
    for _ in range(int(patience[0])):
        row[0], row[1], row[2], row[3] = 0.0, 0.0, 1.0, 1.0
        for foot in range(legs.feet):
            miss, ease, down = _step_on(legs, b, foot, sitter, desk)
            row[0] += miss if miss > SHORT else 0.0
            row[1] += ease
            if miss > SHORT or (legs.floor and not down):
                row[2] = 0.0
        if _sit(sit, b, forward, sitter, desk) < patience[1]:
            return


@njit(cache=True, error_model="numpy", _nrt=False)
def _better(table, grid, i, j):  # type: ignore[no-untyped-def]
    """Whether place i is before place j: it misses less, or is easier, or nearer to where the seat stands at rest."""
    one, other = np.floor(1e4 * table[i, 0] + 0.5), np.floor(1e4 * table[j, 0] + 0.5)
    if one != other:
        return one < other
    one, other = np.floor(1e3 * table[i, 1] + 0.5), np.floor(1e3 * table[j, 1] + 0.5)
    if one != other:
        return one < other
    if abs(grid[i]) != abs(grid[j]):
        return abs(grid[i]) < abs(grid[j])
    return i < j


@njit(cache=True, inline="always")
def _walk(sit, legs, b, grid, best, sitters, desk, table):  # type: ignore[no-untyped-def]
    """From a place that is settled go downhill until both neighbours are worse; returns the place."""
    now, kept, _ = sitters
    step, moved = -1, True
    while moved:
        moved = False
        for side in range(2):
            i = best + step - 2 * side * step
            if moved or i < 0 or i >= len(grid) or table[i, 3] > 0.0:
                continue
            _copy(kept.all, now.all)
            _settle(sit, legs, b, grid[i], SOME, now, desk, table[i])
            if _better(table, grid, i, best):
                _copy(now.all, kept.all)
                best, step, moved = i, i - best, True
    return best


@njit(cache=True, inline="always")
def _scan(sit, legs, b, grid, best, sitters, desk, table):  # type: ignore[no-untyped-def]
    """Try all places, from one that is settled outward; returns the best."""
    now, kept, begun = sitters
    _copy(kept.all, begun.all)
    first = best
    for side in (-1, 1):
        _copy(begun.all, now.all)
        i = first + side
        while 0 <= i < len(grid):
            if table[i, 3] == 0.0:
                _settle(sit, legs, b, grid[i], SOME, now, desk, table[i])
                if _better(table, grid, i, best):
                    _copy(now.all, kept.all)
                    best = i
            i += side
    return best


@njit(cache=True, nogil=True)
def seat_rows(sit, legs, grid, first, every, out, begin, end):  # type: ignore[no-untyped-def]
    """Seat the people begin..end of B.

    grid (G,) [m]: the places of the seat; first (B,): where each begins; every: 1 tries all places. out: rotations
    (B, J, 4), in and out; lap (B, 3, 4): where the lower torso comes; travel (B, 2) [m]: forward and up; numbers
    (B, 2, 8) of the feet, as chains have them; row (B, 4): what is missed [m], discomfort, 1 where all pedals are had
    as wished, and how many places were tried.
    """
    rotations, lap, travel, numbers, rows = out
    links, stops, joints = legs.start.shape[2], legs.links[0].rows.shape[0], rotations.shape[1]
    now, kept, begun = (
        _new_sitter(links, stops, joints), _new_sitter(links, stops, joints), _new_sitter(links, stops, joints),
    )  # fmt: skip
    sitters, desk, table = (now, kept, begun), _new_desk(legs.seeds.shape[1]), np.zeros((len(grid), 4))
    for b in range(begin, end):
        _begin(sit, legs, b, rotations, now, desk)
        for i in range(len(grid)):
            table[i, 3] = 0.0
        best = first[b]
        _settle(sit, legs, b, grid[best], SOME, now, desk, table[best])
        _copy(now.all, kept.all)
        best = _walk(sit, legs, b, grid, best, sitters, desk, table)
        if every or table[best, 2] == 0.0:
            best = _scan(sit, legs, b, grid, best, sitters, desk, table)
        _settle(sit, legs, b, grid[best], LAST, kept, desk, rows[b])
        rows[b, 3] = 0.0
        for i in range(len(grid)):
            rows[b, 3] += table[i, 3]
        _copy(kept.rotations.reshape(-1), rotations[b].reshape(-1))
        _copy(kept.base[0].reshape(-1), lap[b].reshape(-1))
        travel[b, 0], travel[b, 1] = grid[best], kept.up[0]
        for foot in range(legs.feet):
            _copy(kept.numbers[int(kept.chosen[foot])], numbers[b, foot])
