"""Place of the seat, among those of its travel, where each person is best off.

The search goes downhill from place to place: first by how far the feet miss their pedals, then by
how much deeper the thighs press into the cushion than it gives, then by discomfort. Where that ends
short of what is wished, more places are scanned. Thighs are not downhill from everywhere, since
they rise as a heel comes off the floor: where they press on any place of the way, places are tried
outward as long as one farther on may rest them, or be easier. Where they press with the heels on
the floor, the heels come off it if that helps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import batch_loop, inlined, inner
from workbench.posture.kernels.seated_posture import (
    FINAL,
    FINAL_HEELS_UP,
    FOOT_DISCOMFORT,
    HEELS_DOWN,
    HEELS_UP,
    LIFTED,
    MISSED,
    PRESSED,
    ROW,
    TOTAL_DISCOMFORT,
    TRIAL,
    TRIAL_HEELS_UP,
    VISITED,
    Legs,
    SeatWorkspace,
    SitterState,
    Sitting,
    begin_sitter,
    copy_matrix,
    copy_row,
    new_seat_workspace,
    new_sitter,
    solve_seated_posture,
)

__all__ = ["SeatPlaces", "SeatSearch", "new_seat_search", "optimize_seat"]

Floats = NDArray[np.float64]

SCAN_NONE = 0
SCAN_EVERY = 1
SCAN_PEDALS = 2
SCAN_HEELS = 3
SCAN_THIGHS = 4
"""What is scanned after the walk downhill: nothing; every place; outward while feet none of which is
as wished do not grow worse; outward while lifting the heels may pay; outward while thighs press at
the best place, or a place farther on may be easier."""
MISS_UNIT = 1e4
PRESS_UNIT = 1e3
DISCOMFORT_UNIT = 1e3
"""Misses are compared to 1 / MISS_UNIT [m], the press of thighs to 1 / PRESS_UNIT [m], discomfort to
1 / DISCOMFORT_UNIT, so that rounding does not choose a place."""


class SeatPlaces(NamedTuple):
    """Where the seat search puts B people, filled in place."""

    rotations: Floats
    """(B, J, 4) joint rotations, in and out."""
    lap: Floats
    """(B, 3, 4) [m] the lower torso."""
    travel: Floats
    """(B, 2) [m] travel of the seat, forward and up."""
    numbers: Floats
    """(B, 2, 8) of the feet, as of `posture.kernels.inverse.Solutions`."""
    row: Floats
    """(B, ROW) as of `posture.kernels.sitting`, with the number of places that were tried in
    VISITED."""


class SeatSearch(NamedTuple):
    """Working arrays of the search of one person."""

    now: SitterState
    """The person at the place on trial."""
    high: SitterState
    """The person with both heels in the air."""
    best: Floats
    """`Sitter.all` at the best place so far."""
    begun: Floats
    """`Sitter.all` at the place where a scan began."""
    table: Floats
    """(G, ROW) what was found at each place."""
    lifted: Floats
    """(2, ROW) what was found with both heels in the air: at the place before, and now."""
    workspace: SeatWorkspace


def new_seat_search(sit: Sitting, legs: Legs, places: int, joints: int) -> SeatSearch:
    """Make working arrays for a number of places and joints."""
    now = new_sitter(legs, joints)
    return SeatSearch(
        now,
        new_sitter(legs, joints),
        np.zeros(now.all.shape[0]),
        np.zeros(now.all.shape[0]),
        np.zeros((places, ROW)),
        np.zeros((2, ROW)),
        new_seat_workspace(sit, legs, joints),
    )


@inner
def _order(one, other):  # type: ignore[no-untyped-def]
    """Less than 0 where a row of the table is better than another, more where it is worse.

    It misses less; or presses the thighs less; or is easier.
    """
    order = np.floor(MISS_UNIT * one[MISSED] + 0.5) - np.floor(MISS_UNIT * other[MISSED] + 0.5)
    if order == 0.0:
        order = np.floor(PRESS_UNIT * one[PRESSED] + 0.5)
        order -= np.floor(PRESS_UNIT * other[PRESSED] + 0.5)
    if order == 0.0:
        order = np.floor(DISCOMFORT_UNIT * one[TOTAL_DISCOMFORT] + 0.5)
        order -= np.floor(DISCOMFORT_UNIT * other[TOTAL_DISCOMFORT] + 0.5)
    return order


@inner
def _better(table, grid, i, j):  # type: ignore[no-untyped-def]
    """Whether place i is better than place j: by its row; or nearer to where the seat stands at
    rest; or first."""
    order = _order(table[i], table[j])
    if order != 0.0:
        return order < 0.0
    if abs(grid[i]) != abs(grid[j]):
        return abs(grid[i]) < abs(grid[j])
    return i < j


@inner
def _try_place(sit, legs, b, grid, i, best, search):  # type: ignore[no-untyped-def]
    """Settle person b at place i, and keep that if it is better; returns the best place."""
    solve_seated_posture(
        sit, legs, b, grid[i], TRIAL, search.now, search.workspace, search.table[i]
    )
    if _better(search.table, grid, i, best):
        copy_row(search.now.all, search.best)
        return i
    return best


@inner
def _walk(sit, legs, b, grid, start, search):  # type: ignore[no-untyped-def]
    """Go downhill from a settled place until both neighbours are worse; returns the place.

    The neighbour in the direction of the last step is tried first.
    """
    best = start
    step = -1
    moved = True
    while moved:
        moved = False
        for side in range(2):
            i = best + step - 2 * side * step
            if moved or i < 0 or i >= len(grid) or search.table[i, VISITED] > 0.0:
                continue
            copy_row(search.best, search.now.all)
            found = _try_place(sit, legs, b, grid, i, best, search)
            if found != best:
                step = found - best
                best = found
                moved = True
    return best


@inner
def _least_discomfort(legs, settled, lifted):  # type: ignore[no-untyped-def]
    """Least discomfort that a place may have with at least one heel in the air.

    Each foot counts as lifted there (row lifted), or as down at the place of the walk (row
    settled), whichever is less; and the foot that costs least to lift is lifted.
    """
    total = 0.0
    lift = np.inf
    for foot in range(legs.feet):
        down = settled[FOOT_DISCOMFORT + foot]
        up = lifted[FOOT_DISCOMFORT + foot]
        if lifted[MISSED] > 0.0:
            up = np.inf
        total += min(down, up)
        lift = min(lift, up - min(down, up))
    return total + lift


@inner
def _lifting_may_pay(sit, legs, b, grid, i, first, best, search):  # type: ignore[no-untyped-def]
    """Estimate place i with both heels in the air.

    Returns whether it may be better than the best place, and whether a place farther on may be: the
    estimate says so here, or it is still falling.
    """
    lifted = search.lifted
    solve_seated_posture(sit, legs, b, grid[i], HEELS_UP, search.high, search.workspace, lifted[1])
    least = _least_discomfort(legs, search.table[first], lifted[1])
    may_pay = not least >= search.table[best, TOTAL_DISCOMFORT]
    falling = (
        lifted[1, TOTAL_DISCOMFORT] < lifted[0, TOTAL_DISCOMFORT]
        and lifted[1, MISSED] <= lifted[0, MISSED]
    )
    copy_row(lifted[1], lifted[0])
    return may_pay, may_pay or falling


@inner
def _farther_may_rest(sit, legs, b, grid, i, first, best, side, search):  # type: ignore[no-untyped-def]
    """Whether a place beyond place i may be better than the best one: thighs press there, or it is
    easier here, or grows so, or lifting heels may pay."""
    table = search.table
    _, lifting = _lifting_may_pay(sit, legs, b, grid, i, first, best, search)
    return (
        lifting
        or PRESS_UNIT * table[best, PRESSED] >= 0.5
        or table[i, TOTAL_DISCOMFORT] < table[best, TOTAL_DISCOMFORT]
        or table[i, TOTAL_DISCOMFORT] < table[i - side, TOTAL_DISCOMFORT]
    )


@inner
def _scan_side(sit, legs, b, grid, first, best, side, mode, search):  # type: ignore[no-untyped-def]
    """Try places outward from place `first` on one side (-1 or 1); returns the best place."""
    table = search.table
    copy_row(search.begun, search.now.all)
    copy_row(search.begun, search.high.all)
    search.lifted[0, TOTAL_DISCOMFORT] = np.inf
    search.lifted[0, MISSED] = 0.0
    i = first + side
    more = True
    while 0 <= i < len(grid) and more:
        wanted = True
        if mode == SCAN_HEELS:
            wanted, more = _lifting_may_pay(sit, legs, b, grid, i, first, best, search)
        if wanted and table[i, VISITED] == 0.0:
            best = _try_place(sit, legs, b, grid, i, best, search)
        if mode == SCAN_THIGHS:
            more = _farther_may_rest(sit, legs, b, grid, i, first, best, side, search)
        if mode == SCAN_PEDALS:
            more = (
                table[i, HEELS_DOWN] > 0.0
                or table[i - side, HEELS_DOWN] > 0.0
                or _better(table, grid, i, i - side)
            )
        i += side
    return best


@inlined
def _pressed_somewhere(table):  # type: ignore[no-untyped-def]
    """Whether thighs press on any place that was tried."""
    for i in range(table.shape[0]):
        if table[i, VISITED] > 0.0 and PRESS_UNIT * table[i, PRESSED] >= 0.5:
            return True
    return False


@inner
def _scan_mode(legs, place, every, pressed):  # type: ignore[no-untyped-def]
    """What is to be scanned after a walk that ended at a place (ROW,)."""
    if every:
        return SCAN_EVERY
    if pressed:
        return SCAN_THIGHS
    if place[MISSED] > 0.0 or place[HEELS_DOWN] < legs.feet:
        return SCAN_PEDALS
    # to lift a heel can only pay where a foot on the floor costs more than a heel in the air
    hardest = max(place[FOOT_DISCOMFORT], place[FOOT_DISCOMFORT + legs.feet - 1])
    if legs.floor and hardest > legs.in_air:
        return SCAN_HEELS
    return SCAN_NONE


@inner
def _lift_heels(sit, legs, b, grid, best, search):  # type: ignore[no-untyped-def]
    """Try person b with both heels in the air at the places where the thighs press with a heel on
    the floor: the knees rise with the heels. Returns the best place."""
    table = search.table
    raised = search.lifted[1]
    copy_row(search.best, search.begun)
    for i in range(len(grid)):
        presses = table[i, VISITED] > 0.0 and PRESS_UNIT * table[i, PRESSED] >= 0.5
        # a place with all heels in the air is never easier than what these cost
        easier = table[best, TOTAL_DISCOMFORT] > legs.feet * legs.in_air
        pressed = PRESS_UNIT * table[best, PRESSED] >= 0.5
        if presses and table[i, HEELS_DOWN] > 0.0 and (pressed or easier):
            copy_row(search.begun, search.high.all)
            solve_seated_posture(
                sit, legs, b, grid[i], TRIAL_HEELS_UP, search.high, search.workspace, raised
            )
            if _order(raised, table[best]) < 0.0:
                copy_row(raised, table[i])
                table[i, LIFTED] = 1.0
                copy_row(search.high.all, search.best)
                best = i
    return best


@inner
def _seat_person(sit, legs, grid, first, every, out, b, search):  # type: ignore[no-untyped-def]
    """Seat person b: walk downhill, scan where need be, settle at the best place."""
    now = search.now
    begin_sitter(sit, legs, b, out.rotations, now, search.workspace)
    search.table[:, VISITED] = 0.0
    search.table[:, LIFTED] = 0.0
    solve_seated_posture(
        sit, legs, b, grid[first], TRIAL, now, search.workspace, search.table[first]
    )
    copy_row(now.all, search.best)
    best = _walk(sit, legs, b, grid, first, search)
    mode = _scan_mode(legs, search.table[best], every, _pressed_somewhere(search.table))
    if mode != SCAN_NONE:
        copy_row(search.best, search.begun)
        walked = best
        for side in (-1, 1):
            best = _scan_side(sit, legs, b, grid, walked, best, side, mode, search)
    if legs.floor > 0:
        best = _lift_heels(sit, legs, b, grid, best, search)
    copy_row(search.best, now.all)
    effort = FINAL_HEELS_UP if search.table[best, LIFTED] > 0.0 else FINAL
    solve_seated_posture(sit, legs, b, grid[best], effort, now, search.workspace, out.row[b])
    _write_place(legs, b, grid[best], out, search)


@inner
def _write_place(legs, b, forward, out, search):  # type: ignore[no-untyped-def]
    """Write where person b is seated, with the seat so far forward [m]."""
    now = search.now
    out.row[b, VISITED] = 0.0
    for i in range(search.table.shape[0]):
        out.row[b, VISITED] += search.table[i, VISITED]
    copy_matrix(now.rotations[0], out.rotations[b])
    copy_matrix(now.base[0], out.lap[b])
    out.travel[b, 0] = forward
    out.travel[b, 1] = now.up[0]
    for foot in range(legs.feet):
        copy_row(now.numbers[int(now.chosen[foot])], out.numbers[b, foot])


@batch_loop
def optimize_seat(sit, legs, grid, first, every, out, begin, end, search):  # type: ignore[no-untyped-def]
    """Seat the people begin..end - 1 of B.

    Parameters
    ----------
    sit, legs : Sitting, Legs
        B people.
    grid : (B, G)
        Places of each person's seat [m], forward.
    first : (B,)
        Index of the place where each person's search begins.
    every : bool
        Whether all places are tried.
    out : SeatPlaces
        Joint rotations in; filled.
    begin, end : int
        People to seat.
    search : SeatSearch
        Working arrays.
    """
    for b in range(begin, end):
        _seat_person(sit, legs, grid[b], first[b], every, out, b, search)
