"""A person in a seat at some place of its travel: the hips by the planes of the seat, the feet on
their pedals.

What a person sits on moves a little with the thighs, and the thighs with where that person sits, so
both take turns until neither moves. From one place of the seat to the next the legs follow their
own solution, multipliers and all.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.rotation import swing_twist_quaternion
from workbench.compiled import njit
from workbench.posture.kernels.contacts import Limbs, least_heights
from workbench.posture.kernels.inverse import Seeds, solve_chains
from workbench.posture.kernels.limits import Planes
from workbench.posture.kernels.linkage import Linkage

__all__ = [
    "ALOFT",
    "DOWN",
    "EASE",
    "FEET",
    "LAST",
    "MISSED",
    "ROW",
    "SOME",
    "TRIED",
    "Legs",
    "Sitting",
    "begin_sitter",
    "copy_row",
    "new_desk",
    "new_sitter",
    "settle",
]

HEEL = 0
AIR = 1
"""Which of a foot's two rows: the heel on the floor, or wherever it comes."""
STEPS = 90
REACHED = 1e-4
SHORT = 1e-3
"""Distances [m] within which a pedal is reached, and beyond which a foot that stays away is held
against a place."""
SOME = np.array([6.0, 1e-5, 1.0])
LAST = np.array([16.0, 1e-7, 1.0])
ALOFT = np.array([2.0, 1e-3, 0.0])
"""At a place on trial, at the place that is taken, with both heels in the air: turns of sitting and
stepping at most, how little [m] hips at rest move from one to the next, and whether heels are to be
on the floor."""
MISSED = 0
EASE = 1
DOWN = 2
TRIED = 3
FEET = 4
ROW = 6
"""What is told of a place: what is missed [m], discomfort, how many feet are as wished, 1 once
tried, and of each foot its discomfort."""


class Sitting(NamedTuple):
    """How B people sit. limbs: what rests and moves with the legs; counts (2, N): which segments
    rest on cushion and back, ways (2, 3): their normals; fixed (B, 2) [m]: the least heights of
    what rests and does not move with the legs, lap (B, 3, 4): the attitude of the lower torso, at
    the origin; level (B, 3) [m]: the heights that are wanted on cushion, back and beside the
    middle, and solve (3, 3): the shift from how much they are off; ahead (3,): the way the seat
    travels; rise (2,) [m]: its travel up; eye (B,) [m]: the height of the lower torso that brings
    the eyes to theirs, NaN where none is asked for."""

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
    """The legs of B people, two (the second not looked at where `feet` is 1): links; goal (B, 2, 2,
    12): of each foot with the heel on the floor and in the air; start (B, 2, K, 3): angles in
    comfort; seeds of each to begin again from; again (3,): from how many, with the heel down,
    in the air, and at first; joints (2, K) of the body; axes (J, 3, 3); floor: 1 where heels have
    one; in_air: the discomfort of a heel that is not on it."""

    links: tuple[Linkage, Linkage]
    goal: NDArray[np.float64]
    start: NDArray[np.float64]
    seeds: tuple[Seeds, Seeds]
    again: NDArray[np.int64]
    joints: NDArray[np.int64]
    axes: NDArray[np.float64]
    feet: int
    floor: int
    in_air: float


class _Sitter(NamedTuple):
    """Where one person's search stands, all of it views of `all`: base (4, 3, 4): the lower torso,
    for each row; rows 2 foot + HEEL or AIR: angles (4, K, 3), numbers (4, 8), held (4, 6 + R),
    known (4,); chosen (2,): the row that each foot is in; rotations (1, J, 4); up (1,) [m]; missed
    (2, 4) [m]: where the hips were when a heel could last not be on the floor, and by how much."""

    all: NDArray[np.float64]
    base: NDArray[np.float64]
    angles: NDArray[np.float64]
    numbers: NDArray[np.float64]
    held: NDArray[np.float64]
    known: NDArray[np.float64]
    chosen: NDArray[np.float64]
    rotations: NDArray[np.float64]
    up: NDArray[np.float64]
    missed: NDArray[np.float64]


class _Desk(NamedTuple):
    """What the search of one person works with: the person's number `own` (1,) and for each row
    `who` (4,), goal (4, 12), near (4,); lap (1, 3, 4), heights (1, 2); tried (2,): 1 for a foot
    that was begun again from seeds; planes (none) and first (5,)."""

    own: NDArray[np.int64]
    who: NDArray[np.int64]
    goal: NDArray[np.float64]
    near: NDArray[np.int64]
    lap: NDArray[np.float64]
    heights: NDArray[np.float64]
    tried: NDArray[np.int64]
    planes: Planes
    first: NDArray[np.int64]


@njit(cache=True)
def new_sitter(links, stops, joints):  # type: ignore[no-untyped-def]
    """An empty sitter, with chains of so many links and stops."""
    ends = np.cumsum(np.array([48, 12 * links, 32, 4 * (6 + stops), 4, 2, 4 * joints, 1, 8]))
    all_ = np.zeros(ends[-1])
    return _Sitter(
        all_,
        all_[: ends[0]].reshape(4, 3, 4),
        all_[ends[0] : ends[1]].reshape(4, links, 3),
        all_[ends[1] : ends[2]].reshape(4, 8),
        all_[ends[2] : ends[3]].reshape(4, 6 + stops),
        all_[ends[3] : ends[4]],
        all_[ends[4] : ends[5]],
        all_[ends[5] : ends[6]].reshape(1, joints, 4),
        all_[ends[6] : ends[7]],
        all_[ends[7] :].reshape(2, 4),
    )


@njit(cache=True)
def new_desk():  # type: ignore[no-untyped-def]
    """An empty desk."""
    planes = Planes(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    return _Desk(
        np.zeros(1, np.int64),
        np.zeros(4, np.int64),
        np.zeros((4, 12)),
        np.zeros(4, np.int64),
        np.zeros((1, 3, 4)),
        np.zeros((1, 2)),
        np.zeros(2, np.int64),
        planes,
        np.zeros(5, np.int64),
    )


@njit(cache=True, error_model="numpy", _nrt=False)
def copy_row(one, other):  # type: ignore[no-untyped-def]
    """Copy numbers, one after another."""
    for i in range(one.shape[0]):
        other[i] = one[i]


@njit(cache=True, inline="always")
def _sit(sit, b, forward, sitter, desk):  # type: ignore[no-untyped-def]
    """Let person b rest on the seat at a place; returns how far that moves the hips [m]."""
    heights = desk.heights
    who = desk.own
    least_heights(
        sit.limbs, who, sitter.rotations, desk.lap, (sit.ways, sit.counts), heights, 0, len(who)
    )
    low = sit.level[b, 0] - min(heights[0, 0], sit.fixed[b, 0])
    rear = sit.level[b, 1] - min(heights[0, 1], sit.fixed[b, 1])
    aside = sit.level[b, 2]
    moved = 0.0
    z = sit.solve[2, 0] * low + sit.solve[2, 1] * rear + sit.solve[2, 2] * aside
    up = min(max(0.0, sit.rise[0]), sit.rise[1])
    if not math.isnan(sit.eye[b]):
        up = min(max(sit.eye[b] - z, sit.rise[0]), sit.rise[1])
    sitter.up[0] = up
    for i in range(3):
        at = (
            sit.solve[i, 0] * low
            + sit.solve[i, 1] * rear
            + sit.solve[i, 2] * aside
            + forward * sit.ahead[i]
        )
        if i == 2:
            at += up
        moved = max(moved, abs(at - sitter.base[0, i, 3]))
        for r in range(4):
            sitter.base[r, i, 3] = at
    return moved


@njit(cache=True, inline="always")
def _stretch(legs, foot, r, sitter, desk):  # type: ignore[no-untyped-def]
    """Solve a row of a foot, from where it was or from comfort, again from seeds where that fails;
    returns the miss."""
    link = legs.links[0] if foot == 0 else legs.links[1]
    seeds = legs.seeds[0] if foot == 0 else legs.seeds[1]
    out = (sitter.angles, sitter.numbers, sitter.held)
    problem = (sitter.base, desk.goal)
    planes = (desk.planes, desk.first)
    new = sitter.known[r] == 0.0
    steps = np.int64(STEPS)
    again = legs.again[r % 2]
    desk.near[r] = 0 if new else 1
    try_again = new or sitter.numbers[r, 0] < REACHED
    settings = (steps, seeds, legs.again[2])
    solve_chains(link, desk.who, problem, planes, settings, out, desk.near, r, r + 1)
    sitter.known[r] = 1.0
    if sitter.numbers[r, 0] >= REACHED and try_again and again > 0:
        if desk.tried[foot] == 0:
            desk.tried[foot] = 1
            desk.near[r] = 0
        settings = (steps, seeds, again)
        solve_chains(link, desk.who, problem, planes, settings, out, desk.near, r, r + 1)
    return sitter.numbers[r, 0]


@njit(cache=True, inline="always")
def _heel_down(legs, foot, sitter, desk):  # type: ignore[no-untyped-def]
    """Try a foot with its heel on the floor; False where that cannot be. A miss is a distance
    within which nothing is reached: as long as the hips have moved by less since, there is no need
    to try again."""
    r = 2 * foot + HEEL
    gone = 0.0
    for i in range(3):
        gone += (sitter.base[0, i, 3] - sitter.missed[foot, i]) ** 2
    if math.sqrt(gone) < sitter.missed[foot, 3] - SHORT:
        return False
    miss = _stretch(legs, foot, r, sitter, desk)
    for i in range(3):
        sitter.missed[foot, i] = sitter.base[0, i, 3]
    sitter.missed[foot, 3] = miss if miss >= REACHED else 0.0
    return miss < REACHED


@njit(cache=True, inline="always")
def _step_on(legs, b, foot, heels, sitter, desk):  # type: ignore[no-untyped-def]
    """Put a foot of person b on its pedal, the heel on the floor where `heels` is 1 and that can
    be; returns miss [m], discomfort, and whether the heel is down."""
    r = 2 * foot + AIR
    down = False
    if heels > 0 and legs.floor > 0:
        down = _heel_down(legs, foot, sitter, desk)
    if down:
        r = 2 * foot + HEEL
    else:
        if sitter.known[r] == 0.0:
            copy_row(legs.start[b, foot].reshape(-1), sitter.angles[r].reshape(-1))
        _stretch(legs, foot, r, sitter, desk)
    sitter.chosen[foot] = r
    link = legs.links[0] if foot == 0 else legs.links[1]
    angles = sitter.angles
    ease = 0.0
    if legs.floor > 0 and not down:
        ease = legs.in_air
    for d in range(link.mode.shape[0]):
        off = angles[r, link.free_joint[d], link.free_axis[d]] - link.mode[d]
        ease += link.weight[d] * off * off
    for k in range(angles.shape[1]):
        j = legs.joints[foot, k]
        q = swing_twist_quaternion(legs.axes, j, angles[r, k, 0], angles[r, k, 1], angles[r, k, 2])
        for i in range(4):
            sitter.rotations[0, j, i] = q[i]
    return sitter.numbers[r, 0], ease, down


@njit(cache=True)
def begin_sitter(sit, legs, b, rotations, sitter, desk):  # type: ignore[no-untyped-def]
    """Begin with person b, nothing known of any foot."""
    desk.own[0] = b
    for i in range(2):
        desk.tried[i] = 0
        sitter.missed[i, 3] = 0.0
    copy_row(sit.lap[b].reshape(-1), desk.lap.reshape(-1))
    copy_row(rotations[b].reshape(-1), sitter.rotations.reshape(-1))
    for r in range(4):
        desk.who[r] = b
        sitter.known[r] = 0.0
        copy_row(sit.lap[b].reshape(-1), sitter.base[r].reshape(-1))
        copy_row(legs.start[b, r // 2].reshape(-1), sitter.angles[r].reshape(-1))
        copy_row(legs.goal[b, r // 2, r % 2], desk.goal[r])


@njit(cache=True)
def settle(sit, legs, b, forward, how, sitter, desk, row):  # type: ignore[no-untyped-def]
    """Sit and put the feet on their pedals in turns, with the seat at a place; how (3,): how many
    turns at most, how little [m] the hips move when they are at rest, 1 where heels are to be on
    the floor. Fills row (ROW,)."""
    _sit(sit, b, forward, sitter, desk)
    for _ in range(int(how[0])):
        row[MISSED] = 0.0
        row[EASE] = 0.0
        row[DOWN] = 0.0
        row[TRIED] = 1.0
        for foot in range(legs.feet):
            miss, ease, down = _step_on(legs, b, foot, how[2], sitter, desk)
            row[MISSED] += miss if miss > SHORT else 0.0
            row[EASE] += ease
            row[FEET + foot] = ease
            row[DOWN] += 1.0 if down or legs.floor == 0 else 0.0
        if _sit(sit, b, forward, sitter, desk) < how[1]:
            return
