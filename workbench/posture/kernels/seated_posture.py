"""Seated posture with the seat at one place of its travel: hips on the seat, feet on their pedals.

What a person sits on moves a little with the thighs, and the thighs move with the hips. So hips and
feet are solved in turns until the hips are at rest (a fixed-point iteration). From one place of the
seat to the next the legs follow their own solution, multipliers and all.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.rotation import swing_twist_quaternion
from workbench.compiled import inlined, inner
from workbench.posture.kernels.augmented_lagrangian import REACHED, discomfort
from workbench.posture.kernels.chain_kinematics import Linkage
from workbench.posture.kernels.inequality_constraints import ContactPlanes
from workbench.posture.kernels.inverse_kinematics import (
    DESCENT_STEPS,
    ChainWorkspace,
    Search,
    Seeds,
    Solutions,
    new_chain_workspace,
    solve_chain,
)
from workbench.posture.kernels.limb_contacts import (
    Limbs,
    Space,
    depth_behind,
    new_space,
    row_heights,
)

__all__ = [
    "FINAL",
    "FINAL_HEELS_UP",
    "FOOT_DISCOMFORT",
    "HEELS_DOWN",
    "HEELS_UP",
    "LIFTED",
    "MISSED",
    "PRESSED",
    "ROW",
    "TOTAL_DISCOMFORT",
    "TRIAL",
    "TRIAL_HEELS_UP",
    "VISITED",
    "Effort",
    "Legs",
    "SeatWorkspace",
    "SitterState",
    "Sitting",
    "begin_sitter",
    "copy_matrix",
    "copy_row",
    "new_seat_workspace",
    "new_sitter",
    "solve_seated_posture",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

HEEL = 0
AIR = 1
"""Which of a foot's two rows: the heel on the floor, or wherever it comes. Row = 2 foot + this."""
FIRST_SEARCH = 2
"""Index in `Legs.again` of the first search of a row."""
SHORT = 1e-3
"""Miss [m] beyond which a foot that does not reach its pedal is held against a place."""
MISSED = 0
TOTAL_DISCOMFORT = 1
HEELS_DOWN = 2
VISITED = 3
FOOT_DISCOMFORT = 4
PRESSED = 6
LIFTED = 7
ROW = 8
"""Columns of what is found at a place: the misses of the feet [m], discomfort, how many feet are as
wished, 1 once visited, the discomfort of each foot, how much deeper [m] the thighs press into the
cushion than it gives, and 1 where the heels are in the air for that; and the number of columns."""


class Effort(NamedTuple):
    """How carefully a posture is settled."""

    turns: int
    """Turns of sitting and stepping at most."""
    tolerance: float
    """Change [m] of the hips from turn to turn below which they are at rest."""
    heels_down: bool
    """Whether the heels are to be on the floor."""
    thighs: bool
    """Whether it is found how deep the thighs press into the cushion."""


TRIAL = Effort(6, 1e-5, True, True)
"""For a place on trial."""
FINAL = Effort(16, 1e-7, True, True)
"""For the place that is taken."""
FINAL_HEELS_UP = Effort(16, 1e-7, False, True)
"""For the place that is taken, with both heels in the air."""
TRIAL_HEELS_UP = Effort(6, 1e-5, False, True)
"""For a place on trial, with both heels in the air."""
HEELS_UP = Effort(2, 1e-3, False, False)
"""For an estimate with both heels in the air."""


class Sitting(NamedTuple):
    """How B people sit in a seat."""

    limbs: Limbs
    """Segments that rest on the seat and move with the legs."""
    counts: NDArray[np.bool_]
    """(2, N) the segments that rest on the cushion and on the back."""
    ways: Floats
    """(2, 3) normals of cushion and back."""
    fixed: Floats
    """(B, 2) [m] least heights, along these, of what rests and does not move with the legs; the
    lower torso is at the origin."""
    lap: Floats
    """(B, 3, 4) attitude of the lower torso, at the origin."""
    level: Floats
    """(B, 3) [m] heights that are wanted on the cushion, on the back and beside the middle."""
    solve: Floats
    """(3, 3) position from three such heights: the inverse of the planes' normals."""
    ahead: Floats
    """(3,) unit direction in which the seat travels."""
    rise: Floats
    """(B, 2) [m] the seat's travel up: lowest and highest."""
    eye: Floats
    """(B,) [m] height of the lower torso that brings the eyes to theirs, NaN if none is asked
    for."""
    thighs: Limbs
    """The thighs, which lie on the front of the cushion."""
    front: Floats
    """(F, 3) outward unit normals of the cushion's front, no rows where thighs hang as they
    will."""
    at_front: Floats
    """(F,) [m] heights of these faces with the seat not moved."""
    gives: float
    """How deep [m] thighs may press into the front."""


class Legs(NamedTuple):
    """The legs of B people. There are always two; the second does not count where `feet` is 1."""

    links: tuple[Linkage, Linkage]
    goal: Floats
    """(B, 2, 2, 12) goal of each foot with the heel on the floor, and in the air."""
    start: Floats
    """(B, 2, K, 3) [rad] angles in comfort."""
    seeds: tuple[Seeds, Seeds]
    again: Ints
    """(3,) how many seeds a search begins again from: with the heel down, in the air, at first."""
    joints: Ints
    """(2, K) joints of the body."""
    axes: Floats
    """(J, 3, 3) axes of all joints."""
    feet: int
    """Number of feet that count."""
    along: Floats
    """(2,) 1 for a foot whose pedal moves with the seat, else 0."""
    floor: int
    """1 if heels have a floor."""
    in_air: float
    """Discomfort of a heel that is not on it."""


class SitterState(NamedTuple):
    """State of one person in the seat. All arrays are views of `all`, so one copy keeps them."""

    all: Floats
    base: Floats
    """(4, 3, 4) [m] the lower torso, for each row of `angles`."""
    angles: Floats
    """(4, K, 3) [rad] angles of the legs: rows 2 foot + HEEL and 2 foot + AIR."""
    numbers: Floats
    """(4, 8) as of `Solutions`."""
    held: Floats
    """(4, 6 + R) as of `Solutions`."""
    known: Floats
    """(4,) 1 for a row that was solved."""
    chosen: Floats
    """(2,) the row that each foot is in."""
    rotations: Floats
    """(1, J, 4) of all joints."""
    up: Floats
    """(1,) [m] the seat's travel up."""
    missed: Floats
    """(2, 4) [m] where the hips were, from the pedal, when a heel could last not be on the floor, and
    by how much it missed."""


class SeatWorkspace(NamedTuple):
    """Working arrays of one person at a time."""

    goal: Floats
    """(4, 12) goals of the four rows."""
    lap: Floats
    """(1, 3, 4) attitude of the lower torso."""
    heights: Floats
    """(1, 2) [m] least heights along the normals of cushion and back."""
    tried: Ints
    """(2,) 1 for a foot that was begun again from seeds."""
    angles: Floats
    """(1, 1, 3) no angles: the rotations are given."""
    planes: ContactPlanes
    """No planes."""
    chain: ChainWorkspace
    space: Space
    thighs: Space
    """Of the thighs."""
    offset: Floats
    """(F,) [m] heights of the faces of the cushion's front where the seat stands."""


def _leg_sizes(legs: Legs) -> tuple[int, int, int, int]:
    """Return how many joints a leg has, and the most free angles, stops and seeds of either."""
    left, right = legs.links
    free = max(left.mode.shape[0], right.mode.shape[0])
    stops = max(left.rows.shape[0], right.rows.shape[0])
    seeds = max(legs.seeds[0].angles.shape[0], legs.seeds[1].angles.shape[0])
    return left.axes.shape[0], free, stops, seeds


def new_sitter(legs: Legs, joints: int) -> SitterState:
    """Make an empty sitter for bodies of so many joints."""
    links = legs.start.shape[2]
    _, _, stops, _ = _leg_sizes(legs)
    ends = np.cumsum(np.array([48, 12 * links, 32, 4 * (6 + stops), 4, 2, 4 * joints, 1, 8]))
    every = np.zeros(ends[-1])
    return SitterState(
        every,
        every[: ends[0]].reshape(4, 3, 4),
        every[ends[0] : ends[1]].reshape(4, links, 3),
        every[ends[1] : ends[2]].reshape(4, 8),
        every[ends[2] : ends[3]].reshape(4, 6 + stops),
        every[ends[3] : ends[4]],
        every[ends[4] : ends[5]],
        every[ends[5] : ends[6]].reshape(1, joints, 4),
        every[ends[6] : ends[7]],
        every[ends[7] :].reshape(2, 4),
    )


def new_seat_workspace(sit: Sitting, legs: Legs, joints: int) -> SeatWorkspace:
    """Make working arrays for bodies of so many joints."""
    links, free, stops, seeds = _leg_sizes(legs)
    chain = new_chain_workspace(links, free, stops, seeds)
    return SeatWorkspace(
        np.zeros((4, 12)),
        np.zeros((1, 3, 4)),
        np.zeros((1, 2)),
        np.zeros(2, np.int64),
        np.zeros((1, 1, 3)),
        ContactPlanes(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)),
        chain,
        new_space(sit.limbs, joints),
        new_space(sit.thighs, joints),
        np.zeros(len(sit.front)),
    )


@inlined
def copy_row(values, out):  # type: ignore[no-untyped-def]
    """Copy numbers (N,), one after another."""
    for i in range(values.shape[0]):
        out[i] = values[i]


@inlined
def copy_matrix(values, out):  # type: ignore[no-untyped-def]
    """Copy numbers (N, M), one after another."""
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            out[i, j] = values[i, j]


@inlined
def _level_seat(sit, b, low, rear, sitter):  # type: ignore[no-untyped-def]
    """Raise the seat by as much as brings the eyes to their height, within its travel [m]."""
    z = sit.solve[2, 0] * low + sit.solve[2, 1] * rear + sit.solve[2, 2] * sit.level[b, 2]
    up = min(max(0.0, sit.rise[b, 0]), sit.rise[b, 1])
    if not math.isnan(sit.eye[b]):
        up = min(max(sit.eye[b] - z, sit.rise[b, 0]), sit.rise[b, 1])
    sitter.up[0] = up


@inner
def _sit(sit, legs, b, forward, sitter, workspace):  # type: ignore[no-untyped-def]
    """Rest person b on the seat, moved forward by so much [m], with the pedals that go along; returns
    the move of the hips [m]."""
    # The hips x have the three heights that are wanted, less the least heights of what rests:
    #     n1 . x = level1 - heights1,    n2 . x = level2 - heights2,    n3 . x = level3,
    # so that x = N^-1 times these, and the seat's travel is added.
    heights = workspace.heights
    row_heights(
        sit.limbs,
        b,
        sitter.rotations,
        workspace.lap,
        0,
        sit.ways,
        sit.counts,
        workspace.angles,
        workspace.space,
        heights,
    )
    low = sit.level[b, 0] - min(heights[0, 0], sit.fixed[b, 0])
    rear = sit.level[b, 1] - min(heights[0, 1], sit.fixed[b, 1])
    _level_seat(sit, b, low, rear, sitter)
    moved = 0.0
    for i in range(3):
        at = (
            sit.solve[i, 0] * low
            + sit.solve[i, 1] * rear
            + sit.solve[i, 2] * sit.level[b, 2]
            + forward * sit.ahead[i]
        )
        if i == 2:
            at += sitter.up[0]
        moved = max(moved, abs(at - sitter.base[0, i, 3]))
        shift = forward * sit.ahead[i] + (sitter.up[0] if i == 2 else 0.0)
        for r in range(4):
            sitter.base[r, i, 3] = at
            goal = legs.goal[b, r // 2, r % 2, i]
            workspace.goal[r, i] = goal + legs.along[r // 2] * shift
    return moved


@inner
def _pressed(sit, b, forward, sitter, workspace):  # type: ignore[no-untyped-def]
    """How much deeper [m] the thighs of person b press into the cushion than it gives."""
    if len(sit.front) == 0:
        return 0.0
    for f in range(len(sit.front)):
        n = sit.front[f]
        along = n[0] * sit.ahead[0] + n[1] * sit.ahead[1] + n[2] * sit.ahead[2]
        workspace.offset[f] = sit.at_front[f] + forward * along + sitter.up[0] * n[2]
    depth = depth_behind(
        sit.thighs,
        b,
        sitter.rotations,
        sitter.base,
        0,
        sit.front,
        workspace.offset,
        workspace.angles,
        workspace.thighs,
    )
    return max(0.0, depth - sit.gives)


@inner
def _solve_row(legs, b, foot, r, again, near, sitter, workspace):  # type: ignore[no-untyped-def]
    """Solve one row of a foot, from so many seeds at most."""
    solve_chain(
        legs.links[0] if foot == 0 else legs.links[1],
        b,
        (sitter.base, workspace.goal),
        r,
        workspace.planes,
        (0, 0),
        Search(DESCENT_STEPS, legs.seeds[0] if foot == 0 else legs.seeds[1], again),
        near,
        Solutions(sitter.angles, sitter.numbers, sitter.held),
        workspace.chain,
    )


@inner
def _stretch(legs, b, foot, r, sitter, workspace):  # type: ignore[no-untyped-def]
    """Solve row r of a foot from where it was, or from comfort; returns the miss [m].

    A row that is new, or reached its target before, is tried again from seeds if it fails.
    """
    near = sitter.known[r] != 0.0
    try_again = not near or sitter.numbers[r, 0] < REACHED
    again = legs.again[r % 2]
    _solve_row(legs, b, foot, r, legs.again[FIRST_SEARCH], near, sitter, workspace)
    sitter.known[r] = 1.0
    if sitter.numbers[r, 0] >= REACHED and try_again and again > 0:
        if workspace.tried[foot] == 0:
            workspace.tried[foot] = 1
            near = False
        _solve_row(legs, b, foot, r, again, near, sitter, workspace)
    return sitter.numbers[r, 0]


@inner
def _heel_down(legs, b, foot, sitter, workspace):  # type: ignore[no-untyped-def]
    """Try a foot with its heel on the floor; returns whether that can be."""
    # A heel that missed the floor by d cannot be on it before the hips have moved by d, since the
    # length of the leg bounds how far it comes. Until then there is no need to try again.
    r = 2 * foot + HEEL
    missed = sitter.missed[foot]
    square = 0.0
    for i in range(3):
        square += (sitter.base[0, i, 3] - workspace.goal[r, i] - missed[i]) ** 2
    if math.sqrt(square) < missed[3] - SHORT:
        return False
    miss = _stretch(legs, b, foot, r, sitter, workspace)
    for i in range(3):
        missed[i] = sitter.base[0, i, 3] - workspace.goal[r, i]
    missed[3] = miss if miss >= REACHED else 0.0
    return miss < REACHED


@inlined
def _turn_leg(legs, foot, angles, rotations):  # type: ignore[no-untyped-def]
    """Write the rotations of a leg's joints at angles (K, 3) [rad]."""
    for k in range(angles.shape[0]):
        j = legs.joints[foot, k]
        q = swing_twist_quaternion(legs.axes, j, angles[k, 0], angles[k, 1], angles[k, 2])
        for i in range(4):
            rotations[0, j, i] = q[i]


@inner
def _step_on(legs, b, foot, heels_down, sitter, workspace):  # type: ignore[no-untyped-def]
    """Put a foot of person b on its pedal, with the heel on the floor if wished and possible.

    Returns the miss [m], the discomfort of the leg, and whether the heel is down.
    """
    r = 2 * foot + AIR
    down = False
    if heels_down and legs.floor > 0:
        down = _heel_down(legs, b, foot, sitter, workspace)
    if down:
        r = 2 * foot + HEEL
    else:
        if sitter.known[r] == 0.0:
            copy_matrix(legs.start[b, foot], sitter.angles[r])
        _stretch(legs, b, foot, r, sitter, workspace)
    sitter.chosen[foot] = r
    base = legs.in_air if legs.floor > 0 and not down else 0.0
    link = legs.links[0] if foot == 0 else legs.links[1]
    cost = discomfort(link, sitter.angles[r], base)
    _turn_leg(legs, foot, sitter.angles[r], sitter.rotations)
    return sitter.numbers[r, 0], cost, down


@inner
def begin_sitter(sit, legs, b, rotations, sitter, workspace):  # type: ignore[no-untyped-def]
    """Begin with person b, nothing known of any foot; rotations (B, J, 4)."""
    for foot in range(2):
        workspace.tried[foot] = 0
        sitter.missed[foot, 3] = 0.0
    copy_matrix(sit.lap[b], workspace.lap[0])
    copy_matrix(rotations[b], sitter.rotations[0])
    for r in range(4):
        sitter.known[r] = 0.0
        copy_matrix(sit.lap[b], sitter.base[r])
        copy_matrix(legs.start[b, r // 2], sitter.angles[r])
        copy_row(legs.goal[b, r // 2, r % 2], workspace.goal[r])


@inner
def solve_seated_posture(sit, legs, b, forward, effort, sitter, workspace, row):  # type: ignore[no-untyped-def]
    """Sit and put the feet on their pedals in turns, until the hips are at rest.

    Parameters
    ----------
    sit, legs : Sitting, Legs
        B people.
    b : int
        The person.
    forward : float
        How far forward the seat is [m].
    effort : Effort
        How carefully.
    sitter, workspace : Sitter, SeatWorkspace
        State of the person in and out, and working arrays.
    row : (ROW,)
        Filled with what was found at this place.
    """
    _sit(sit, legs, b, forward, sitter, workspace)
    row[PRESSED] = 0.0
    for _ in range(effort.turns):
        row[MISSED] = 0.0
        row[TOTAL_DISCOMFORT] = 0.0
        row[HEELS_DOWN] = 0.0
        row[VISITED] = 1.0
        for foot in range(legs.feet):
            miss, discomfort, down = _step_on(legs, b, foot, effort.heels_down, sitter, workspace)
            row[MISSED] += miss if miss > SHORT else 0.0
            row[TOTAL_DISCOMFORT] += discomfort
            row[FOOT_DISCOMFORT + foot] = discomfort
            row[HEELS_DOWN] += 1.0 if down or legs.floor == 0 else 0.0
        if _sit(sit, legs, b, forward, sitter, workspace) < effort.tolerance:
            break
    if effort.thighs:
        row[PRESSED] = _pressed(sit, b, forward, sitter, workspace)
