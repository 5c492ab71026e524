"""Solve set covers: choose few rows that together hold every item.

A cover is greedy, then pruned, then improved in small neighbourhoods. Rows are lists of items in
flat arrays (start, item), and the transposed lists are the rows of each item. Choices are made in a
fixed order or from a seeded generator of the module's own, so that every machine gives the same
answer.
"""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit

__all__ = ["greedy_cover", "improve_cover", "prune_cover", "transposed"]

_MIN_DROPPED = 3
_MAX_DROPPED = 12
"""Rows that one move drops."""
_NOISE = 0.25
"""Share of its gain by which a row can be rated lower at random."""


@njit(cache=True)
def transposed(start, item, items):  # type: ignore[no-untyped-def]
    """Return the rows of each item: begin (items + 1,) and row, of rows start (m + 1,) and item."""
    begin = np.zeros(items + 1, np.int64)
    for x in item:
        begin[x + 1] += 1
    begin = np.cumsum(begin)
    free = begin[:-1].copy()
    row = np.empty(len(item), np.int32)
    for j in range(len(start) - 1):
        for k in range(start[j], start[j + 1]):
            x = item[k]
            row[free[x]] = j
            free[x] += 1
    return begin, row


@njit(cache=True)
def _fresh(j, start, item, times):  # type: ignore[no-untyped-def]
    """Return how many items of row j no chosen row holds."""
    gain = 0
    for k in range(start[j], start[j + 1]):
        if times[item[k]] == 0:
            gain += 1
    return gain


@njit(cache=True)
def _change(j, start, item, times, by):  # type: ignore[no-untyped-def]
    """Add `by` to the counts of the items of row j."""
    for k in range(start[j], start[j + 1]):
        times[item[k]] += by


@njit(cache=True)
def greedy_cover(start, item, times, chosen):  # type: ignore[no-untyped-def]
    """Choose the row with the most open items until none gains any.

    Gains only fall, so a row is rated again only when it is the first of the queue. The number of rows
    is within ln(n) + 1 of the least.

    Parameters
    ----------
    start, item
        m rows of items.
    times
        (n,) how many chosen rows hold each item, updated.
    chosen
        (m,) 1 for chosen rows, updated.
    """
    heap = [
        (start[j] - start[j + 1], j)
        for j in range(len(chosen))
        if chosen[j] == 0 and start[j + 1] > start[j]
    ]
    heapq.heapify(heap)
    while len(heap) > 0:
        known, j = heap[0]
        gain = _fresh(j, start, item, times)
        if gain == 0:
            heapq.heappop(heap)
        elif -gain > known:
            heapq.heapreplace(heap, (-gain, j))
        else:
            heapq.heappop(heap)
            chosen[j] = 1
            _change(j, start, item, times, 1)


@njit(cache=True)
def _needless(j, start, item, times):  # type: ignore[no-untyped-def]
    """True where every item of row j is held by another chosen row too."""
    least = 2
    for k in range(start[j], start[j + 1]):
        least = min(least, times[item[k]])
        if least < 2:
            break
    return least == 2


@njit(cache=True)
def prune_cover(start, item, times, chosen, fixed):  # type: ignore[no-untyped-def]
    """Remove chosen rows that hold no item alone, those with the fewest items first.

    Parameters
    ----------
    start, item
        m rows of items.
    times, chosen
        (n,) and (m,), updated, see `greedy_cover`.
    fixed
        (m,) 1 for rows that stay.
    """
    rows = np.flatnonzero(chosen)
    order = rows[np.argsort((start[rows + 1] - start[rows]).astype(np.float64), kind="mergesort")]
    for j in order:
        if fixed[j] == 0 and _needless(j, start, item, times):
            chosen[j] = 0
            _change(j, start, item, times, -1)


@njit(cache=True)
def _next(state):  # type: ignore[no-untyped-def]
    """Return the next state of a random generator, 0 to 2^31 - 1.

    It is the one of Park & Miller (1988), which gives the same numbers compiled or not.
    """
    return (state * 48271) % 2147483647


@njit(cache=True)
def _neighbours(seat, size, held, centre, near, far):  # type: ignore[no-untyped-def]
    """Write the entries of `held` nearest to held[seat] into `near`, up to `size`, nearest first.

    Returns their number.
    """
    c = centre[held[seat]]
    count = 0
    for k in range(len(held)):
        o = centre[held[k]]
        d = (o[0] - c[0]) ** 2 + (o[1] - c[1]) ** 2 + (o[2] - c[2]) ** 2
        if count == size and d >= far[count - 1]:
            continue
        place = count if count < size else size - 1
        while place > 0 and far[place - 1] > d:
            far[place] = far[place - 1]
            near[place] = near[place - 1]
            place -= 1
        far[place] = d
        near[place] = k
        count = min(count + 1, size)
    return count


class _Rows(NamedTuple):
    """m rows of items, and for each of n items the rows that hold it."""

    start: NDArray[np.int64]
    """(m + 1,) items of row j: item[start[j]:start[j + 1]]."""
    item: NDArray[np.int32]
    begin: NDArray[np.int64]
    """(n + 1,) rows of item x: row[begin[x]:begin[x + 1]]."""
    row: NDArray[np.int32]


class _Refill(NamedTuple):
    """Working arrays of `_refill`, for m rows."""

    gain: NDArray[np.int64]
    """(m,) open items that each row would hold; 0 between calls."""
    touched: NDArray[np.int64]
    """(m,) the rows that hold any."""
    taken: NDArray[np.int64]
    """(64,) the rows that were taken."""


@njit(cache=True)
def _count_gains(open_items, rows, work):  # type: ignore[no-untyped-def]
    """Count the open items of each row into work.gain; returns how many rows hold any."""
    gain = work.gain
    count = 0
    for x in open_items:
        for k in range(rows.begin[x], rows.begin[x + 1]):
            j = rows.row[k]
            if gain[j] == 0:
                work.touched[count] = j
                count += 1
            gain[j] += 1
    return count


@njit(cache=True)
def _best_row(count, state, work):  # type: ignore[no-untyped-def]
    """Pick the touched row with the largest gain, each reduced at random by up to `_NOISE` of it.

    Returns the row, -1 for none, and the state of the generator.
    """
    best = -1.0
    pick = -1
    for t in range(count):
        gain = work.gain[work.touched[t]]
        if gain > best * (1.0 - _NOISE):
            state = _next(state)
            score = gain * (1.0 - _NOISE * (state / 2147483647.0))
            if score > best:
                best = score
                pick = work.touched[t]
    return pick, state


@njit(cache=True)
def _take_row(j, rows, times, work):  # type: ignore[no-untyped-def]
    """Take row j: count its items up, and the gains of other rows down; returns the items gained."""
    gained = 0
    for k in range(rows.start[j], rows.start[j + 1]):
        x = rows.item[k]
        times[x] += 1
        if times[x] == 1:
            gained += 1
            for q in range(rows.begin[x], rows.begin[x + 1]):
                work.gain[rows.row[q]] -= 1
    return gained


@njit(cache=True)
def _refill(open_items, rows, times, most, state, work):  # type: ignore[no-untyped-def]
    """Cover open items anew, greedily with noise, by at most `most` rows.

    Returns whether all are covered, the number of rows taken, and the state of the generator.
    """
    count = _count_gains(open_items, rows, work)
    left = len(open_items)
    used = 0
    while left > 0 and used < most:
        pick, state = _best_row(count, state, work)
        if pick < 0 or work.gain[pick] == 0:
            break
        work.taken[used] = pick
        used += 1
        left -= _take_row(pick, rows, times, work)
    for t in range(count):
        work.gain[work.touched[t]] = 0
    return left == 0, used, state


@njit(cache=True)
def _opened_items(dropped, start, item, times):  # type: ignore[no-untyped-def]
    """Return the items of dropped rows that no row holds any more, each once."""
    room = 0
    for j in dropped:
        room += start[j + 1] - start[j]
    opened = np.empty(room, np.int64)
    count = 0
    for j in dropped:
        for k in range(start[j], start[j + 1]):
            if times[item[k]] == 0:
                times[item[k]] = -1  # seen
                opened[count] = item[k]
                count += 1
    for k in range(count):
        times[opened[k]] = 0
    return opened[:count]


@njit(cache=True)
def _try_neighbourhood(seats, free, rows, times, state, work):  # type: ignore[no-untyped-def]
    """Drop the rows on some seats and cover anew; undone where that takes more rows.

    seats, free: ascending indices into `free` (h,), which holds the chosen rows and is filled in
    place. Returns how many of the seats hold a row now, the first ones, and the generator's state.
    """
    dropped = free[seats].copy()
    for j in dropped:
        _change(j, rows.start, rows.item, times, -1)
    opened = _opened_items(dropped, rows.start, rows.item, times)
    is_covered, used, state = _refill(opened, rows, times, len(seats), state, work)
    if not is_covered:
        for k in range(used):
            _change(work.taken[k], rows.start, rows.item, times, -1)
        for j in dropped:
            _change(j, rows.start, rows.item, times, 1)
        return len(seats), state
    for k in range(used):
        free[seats[k]] = work.taken[k]
    return used, state


@njit(cache=True)
def improve_cover(start, item, begin, row, times, chosen, fixed, centre, moves, target, seed):  # type: ignore[no-untyped-def]
    """Improve a cover by large-neighbourhood search [1]_.

    Each move drops 3 to 12 neighbouring rows and covers anew what opened. It stays where it takes
    no more rows.

    Parameters
    ----------
    start, item, begin, row
        The rows, and the rows of each item, see `transposed`.
    times
        (n,) how many chosen rows hold each item.
    chosen, fixed
        (m,) 1 for a chosen row, updated, and for one that stays.
    centre
        (m, 3) positions of the rows, which make neighbourhoods.
    moves, target, seed
        The search ends after `moves` tries, or once no more than `target` rows are chosen.

    References
    ----------
    .. [1] P. Shaw (1998), Using constraint programming and local search methods to solve vehicle
       routing problems, CP 1998, DOI 10.1007/3-540-49481-2_30.
    """
    rows = _Rows(start, item, begin, row)
    free = np.flatnonzero(chosen - fixed)
    work = _Refill(
        np.zeros(len(chosen), np.int64),
        np.empty(len(chosen), np.int64),
        np.empty(64, np.int64),
    )
    state = 1 + seed % 2147483646
    goal = target - int(fixed.sum())
    count = _search_neighbourhoods(free, rows, times, centre, moves, goal, state, work)
    chosen[:] = fixed
    chosen[free[:count]] = 1


@njit(cache=True)
def _search_neighbourhoods(free, rows, times, centre, moves, goal, state, work):  # type: ignore[no-untyped-def]
    """Try moves until `goal` rows are left in `free` (h,); returns how many are, the first ones."""
    count = len(free)
    near = np.empty(_MAX_DROPPED, np.int64)
    distance = np.empty(_MAX_DROPPED)
    for _ in range(moves if count > 1 else 0):
        if count <= goal:
            break
        state = _next(state)
        seat = state % count
        state = _next(state)
        size = min(_MIN_DROPPED + state % (_MAX_DROPPED - _MIN_DROPPED + 1), count)
        size = _neighbours(seat, size, free[:count], centre, near, distance)
        seats = np.sort(near[:size])
        used, state = _try_neighbourhood(seats, free, rows, times, state, work)
        for k in range(size - 1, used - 1, -1):  # the last rows move to the seats that are free
            count -= 1
            free[seats[k]] = free[count]
    return count
