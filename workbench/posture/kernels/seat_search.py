"""The seat put where each person is best off: place by place downhill, first by how far the feet
miss, then by discomfort; beyond where heels can be on the floor only as far as lifting them may
pay.
"""

from __future__ import annotations

import numpy as np

from workbench.compiled import njit
from workbench.posture.kernels.sitting import (
    ALOFT,
    DOWN,
    EASE,
    FEET,
    LAST,
    MISSED,
    ROW,
    SOME,
    TRIED,
    begin_sitter,
    copy_row,
    new_desk,
    new_sitter,
    settle,
)

__all__ = ["ROW", "seat_rows"]

NONE = 0
EVERY = 1
PEDALS = 2
HEELS = 3
"""What places are scanned for after the walk."""


@njit(cache=True, error_model="numpy", _nrt=False)
def _better(table, grid, i, j):  # type: ignore[no-untyped-def]
    """Whether place i is before place j: it misses less, or is easier, or nearer to where the seat
    stands at rest."""
    one = np.floor(1e4 * table[i, MISSED] + 0.5)
    other = np.floor(1e4 * table[j, MISSED] + 0.5)
    if one != other:
        return one < other
    one = np.floor(1e3 * table[i, EASE] + 0.5)
    other = np.floor(1e3 * table[j, EASE] + 0.5)
    if one != other:
        return one < other
    if abs(grid[i]) != abs(grid[j]):
        return abs(grid[i]) < abs(grid[j])
    return i < j


@njit(cache=True, inline="always")
def _walk(sit, legs, b, grid, best, sitters, desk, table):  # type: ignore[no-untyped-def]
    """From a place that is settled go downhill until both neighbours are worse; returns the
    place."""
    now = sitters[0]
    kept = sitters[1]
    step = -1
    moved = True
    while moved:
        moved = False
        for side in range(2):
            i = best + step - 2 * side * step
            if moved or i < 0 or i >= len(grid) or table[i, TRIED] > 0.0:
                continue
            copy_row(kept.all, now.all)
            settle(sit, legs, b, grid[i], SOME, now, desk, table[i])
            if _better(table, grid, i, best):
                copy_row(now.all, kept.all)
                best, step, moved = i, i - best, True
    return best


@njit(cache=True, inline="always")
def _least(legs, walked, aloft):  # type: ignore[no-untyped-def]
    """The least that a place may come to with some heel in the air: its feet aloft, or down as
    where one has walked."""
    total = 0.0
    lift = np.inf
    for foot in range(legs.feet):
        down = walked[FEET + foot]
        up = aloft[FEET + foot]
        if aloft[MISSED] > 0.0:
            up = np.inf
        total += min(down, up)
        lift = min(lift, up - min(down, up))
    return total + lift


@njit(cache=True, inline="always")
def _scan(sit, legs, b, grid, best, mode, sitters, desk, table):  # type: ignore[no-untyped-def]
    """Try places on both sides of one that is settled, outward; returns the best.

    mode: EVERY place; PEDALS: until feet none of which is as wished grow worse; HEELS: heels are
    down, and places where to lift them cannot pay, told from legs with both in the air, are passed
    over, until that grows worse.
    """
    now, kept, begun, high = sitters
    copy_row(kept.all, begun.all)
    first = best
    aloft = np.zeros((2, ROW))
    for side in (-1, 1):
        copy_row(begun.all, now.all)
        copy_row(begun.all, high.all)
        i = first + side
        more = True
        aloft[0, EASE] = np.inf
        aloft[0, MISSED] = 0.0
        before = table[first]
        while 0 <= i < len(grid) and more:
            passed = False
            if mode == HEELS:
                settle(sit, legs, b, grid[i], ALOFT, high, desk, aloft[1])
                passed = _least(legs, table[first], aloft[1]) >= table[best, EASE]
                more = not passed or (
                    aloft[1, EASE] < aloft[0, EASE] and aloft[1, MISSED] <= aloft[0, MISSED]
                )
                copy_row(aloft[1], aloft[0])
            if not passed and table[i, TRIED] == 0.0:
                settle(sit, legs, b, grid[i], SOME, now, desk, table[i])
                if _better(table, grid, i, best):
                    copy_row(now.all, kept.all)
                    best = i
            if mode == PEDALS:
                more = (
                    table[i, DOWN] > 0.0 or before[DOWN] > 0.0 or _better(table, grid, i, i - side)
                )
                before = table[i]
            i += side
    return best


@njit(cache=True, nogil=True)
def seat_rows(sit, legs, grid, first, every, out, begin, end):  # type: ignore[no-untyped-def]
    """Seat the people begin..end of B.

    grid (G,) [m]: the places of the seat; first (B,): where each begins; every: 1 tries all places.
    out: rotations (B, J, 4), in and out; lap (B, 3, 4): where the lower torso comes; travel (B, 2)
    [m]: forward and up; numbers (B, 2, 8) of the feet, as chains have them; row (B, ROW): what is
    missed [m], discomfort, how many feet are as wished, how many places were tried, and the
    discomfort of each foot.
    """
    rotations, lap, travel, numbers, rows = out
    links = legs.start.shape[2]
    stops = legs.links[0].rows.shape[0]
    joints = rotations.shape[1]
    now = new_sitter(links, stops, joints)
    kept = new_sitter(links, stops, joints)
    begun = new_sitter(links, stops, joints)
    high = new_sitter(links, stops, joints)
    sitters = (now, kept, begun, high)
    desk = new_desk()
    table = np.zeros((len(grid), ROW))
    for b in range(begin, end):
        begin_sitter(sit, legs, b, rotations, now, desk)
        for i in range(len(grid)):
            table[i, TRIED] = 0.0
        best = first[b]
        settle(sit, legs, b, grid[best], SOME, now, desk, table[best])
        copy_row(now.all, kept.all)
        best = _walk(sit, legs, b, grid, best, sitters, desk, table)
        mode = EVERY if every else NONE
        if mode == NONE and (table[best, MISSED] > 0.0 or table[best, DOWN] < legs.feet):
            mode = PEDALS
        elif (
            mode == NONE
            and legs.floor
            and max(table[best, FEET], table[best, FEET + legs.feet - 1]) > legs.in_air
        ):
            mode = HEELS
        if mode != NONE:
            best = _scan(sit, legs, b, grid, best, mode, sitters, desk, table)
        settle(sit, legs, b, grid[best], LAST, kept, desk, rows[b])
        rows[b, TRIED] = 0.0
        for i in range(len(grid)):
            rows[b, TRIED] += table[i, TRIED]
        copy_row(kept.rotations.reshape(-1), rotations[b].reshape(-1))
        copy_row(kept.base[0].reshape(-1), lap[b].reshape(-1))
        travel[b, 0] = grid[best]
        travel[b, 1] = kept.up[0]
        for foot in range(legs.feet):
            copy_row(kept.numbers[int(kept.chosen[foot])], numbers[b, foot])
