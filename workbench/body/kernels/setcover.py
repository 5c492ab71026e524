"""Set cover: few rows that together hold every item. Greedy, pruned, and improved in small
neighbourhoods.

Rows are lists of items in flat arrays (start, item); the transposed lists say which rows hold an
item. All choices are made in a fixed order or from a seeded generator of our own, so the answer is
the same on every machine.
"""

from __future__ import annotations

import heapq

import numpy as np

from workbench.compiled import njit

__all__ = ["greedy_cover", "improve_cover", "prune_cover", "transposed"]


@njit(cache=True)
def transposed(start, item, items):  # type: ignore[no-untyped-def]
    """The rows of each item: start (items + 1,), row; from rows start (m + 1,), item."""
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
    """How many items of a row nobody holds yet."""
    gain = 0
    for k in range(start[j], start[j + 1]):
        if times[item[k]] == 0:
            gain += 1
    return gain


@njit(cache=True)
def _change(j, start, item, times, by):  # type: ignore[no-untyped-def]
    for k in range(start[j], start[j + 1]):
        times[item[k]] += by


@njit(cache=True)
def greedy_cover(start, item, times, chosen):  # type: ignore[no-untyped-def]
    """Take the row with the most items not yet held until nothing is gained (lazily: gains only
    fall).

    times (items,): how many chosen rows hold each item; chosen (m,): both are updated. Within ln(n)
    + 1 of the fewest.
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
    least = 2
    for k in range(start[j], start[j + 1]):
        least = min(least, times[item[k]])
        if least < 2:
            break
    return least == 2


@njit(cache=True)
def prune_cover(start, item, times, chosen, fixed):  # type: ignore[no-untyped-def]
    """Drop chosen rows that hold nothing alone, those with the fewest items first; fixed (m,)
    stay."""
    rows = np.flatnonzero(chosen)
    order = rows[np.argsort((start[rows + 1] - start[rows]).astype(np.float64), kind="mergesort")]
    for j in order:
        if fixed[j] == 0 and _needless(j, start, item, times):
            chosen[j] = 0
            _change(j, start, item, times, -1)


@njit(cache=True)
def _next(state):  # type: ignore[no-untyped-def]
    """A generator small enough to be the same compiled and not: numbers from 0 to 2^31 - 1 (Park &
    Miller, 1988)."""
    return (state * 48271) % 2147483647


@njit(cache=True)
def _neighbours(seat, size, held, centre, near, far):  # type: ignore[no-untyped-def]
    """Write the `size` entries of held nearest to held[seat] into near (numbers into held)."""
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


@njit(cache=True)
def _refill(open_items, start, item, begin, row, times, most, noise, state, work):  # type: ignore[no-untyped-def]
    """Cover the open items anew, greedily with noise, by at most `most` rows. Returns rows used (or
    most + 1)."""
    gain, touched, taken = work
    count = 0
    for x in open_items:
        for k in range(begin[x], begin[x + 1]):
            if gain[row[k]] == 0:
                touched[count] = row[k]
                count += 1
            gain[row[k]] += 1
    left = len(open_items)
    used = 0
    while left > 0 and used < most:
        best = -1.0
        pick = -1
        for t in range(count):
            g = gain[touched[t]]
            if g > best * (1.0 - noise):
                state = _next(state)
                score = g * (1.0 - noise * (state / 2147483647.0))
                if score > best:
                    best = score
                    pick = touched[t]
        if pick < 0 or gain[pick] == 0:
            break
        taken[used] = pick
        used += 1
        for k in range(start[pick], start[pick + 1]):
            x = item[k]
            times[x] += 1
            if times[x] == 1:
                left -= 1
                for q in range(begin[x], begin[x + 1]):
                    gain[row[q]] -= 1
    for t in range(count):
        gain[touched[t]] = 0
    return used if left == 0 else used + most + 1, state


@njit(cache=True)
def improve_cover(start, item, begin, row, times, chosen, fixed, centre, moves, target, seed):  # type: ignore[no-untyped-def]
    """Large-neighbourhood search: drop 3 to 12 neighbouring rows, cover what opened anew; keep what
    is no worse.

    centre (m, 3): places of the rows, which make neighbourhoods. Ends after `moves` tries or once
    no more than target rows are chosen. Source: Shaw, CP 1998, DOI 10.1007/3-540-49481-2_30.
    """
    held = np.flatnonzero(chosen - fixed)
    count = len(held)
    state = 1 + seed % 2147483646
    free = np.full(len(held), -1, np.int64)
    free[: len(held)] = held
    near = np.empty(12, np.int64)
    far = np.empty(12)
    work = (
        np.zeros(len(chosen), np.int64),
        np.empty(len(chosen), np.int64),
        np.empty(64, np.int64),
    )
    goal = target - int(fixed.sum())
    for _ in range(moves if count > 1 else 0):
        if count <= goal:
            break
        state = _next(state)
        seat = state % count
        state = _next(state)
        size = _neighbours(seat, min(3 + state % 10, count), free[:count], centre, near, far)
        opened = np.empty(0, np.int64)
        gone = np.sort(near[:size])
        old = free[gone].copy()
        for j in old:
            _change(j, start, item, times, -1)
        room = 0
        opens = 0
        for j in old:
            room += start[j + 1] - start[j]
        opened = np.empty(room, np.int64)
        for j in old:
            for k in range(start[j], start[j + 1]):
                if times[item[k]] == 0:
                    times[item[k]] = -1
                    opened[opens] = item[k]
                    opens += 1
        for k in range(opens):
            times[opened[k]] = 0
        used, state = _refill(
            opened[:opens], start, item, begin, row, times, size, 0.25, state, work
        )
        if used > size:
            for k in range(used - size - 1):
                _change(work[2][k], start, item, times, -1)
            for j in old:
                _change(j, start, item, times, 1)
            continue
        for k in range(used):
            free[gone[k]] = work[2][k]
        for k in range(size - 1, used - 1, -1):
            count -= 1
            free[gone[k]] = free[count]
    chosen[:] = fixed
    chosen[free[:count]] = 1
