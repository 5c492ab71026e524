"""How deep the segments of a body stand in one another, and what volume the spheres of each have
together."""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit

__all__ = ["segment_overlaps", "union_volumes"]


@njit(cache=True)
def segment_overlaps(centres, radius, start, asked, deepest):  # type: ignore[no-untyped-def]
    """Raise deepest (N, N) [m] to the greatest depth that spheres of two segments overlap by, both
    ways, for the pairs asked (N, N) is True for; what is shallower than what stands there already
    is not told.

    centres (S, 3), radius (S,); those of segment n are start[n]:start[n + 1].
    """
    count = start.shape[0] - 1
    low = np.full((count, 3), np.inf)
    high = np.full((count, 3), -np.inf)
    for n in range(count):
        for s in range(start[n], start[n + 1]):
            for i in range(3):
                low[n, i] = min(low[n, i], centres[s, i] - radius[s])
                high[n, i] = max(high[n, i], centres[s, i] + radius[s])
    for a in range(count):
        for b in range(a + 1, count):
            apart = not asked[a, b]
            for i in range(3):
                apart = apart or low[a, i] > high[b, i] or low[b, i] > high[a, i]
            if apart or start[a] == start[a + 1] or start[b] == start[b + 1]:
                continue
            best = deepest[a, b]
            for u in range(start[a], start[a + 1]):
                for v in range(start[b], start[b + 1]):
                    # deeper than the best so far: |c_u - c_v| < r_u + r_v - best
                    reach = radius[u] + radius[v] - best
                    x = centres[u, 0] - centres[v, 0]
                    y = centres[u, 1] - centres[v, 1]
                    z = centres[u, 2] - centres[v, 2]
                    square = x * x + y * y + z * z
                    if reach > 0.0 and square < reach * reach:
                        best = radius[u] + radius[v] - math.sqrt(square)
            deepest[a, b] = deepest[b, a] = best


@njit(cache=True)
def _covered(ends, used):  # type: ignore[no-untyped-def]
    """Length of the union of the intervals ends[:used] (low, high), which are sorted in place by
    their lows."""
    for i in range(1, used):
        low = ends[i, 0]
        high = ends[i, 1]
        k = i - 1
        while k >= 0 and ends[k, 0] > low:
            ends[k + 1, 0], ends[k + 1, 1] = ends[k, 0], ends[k, 1]
            k -= 1
        ends[k + 1, 0] = low
        ends[k + 1, 1] = high
    total = 0.0
    reached = -np.inf
    for i in range(used):
        total += max(ends[i, 1] - max(ends[i, 0], reached), 0.0)
        reached = max(reached, ends[i, 1])
    return total


@njit(cache=True)
def union_volumes(centre, radius, start, lines):  # type: ignore[no-untyped-def]
    """Volume (N,) [m3] of the union of the spheres of each segment, by `lines` x `lines` straight
    lines along z through the middles of equal cells across it.

    The cells go with the segment's size, so that a larger body of the same shape has just so much
    more volume.
    """
    volume = np.zeros(start.shape[0] - 1)
    for n in range(start.shape[0] - 1):
        a = start[n]
        b = start[n + 1]
        if a == b:
            continue
        low = np.full(2, np.inf)
        high = np.full(2, -np.inf)
        for s in range(a, b):
            for i in range(2):
                low[i] = min(low[i], centre[s, i] - radius[s])
                high[i] = max(high[i], centre[s, i] + radius[s])
        wide = (high[0] - low[0]) / lines
        long = (high[1] - low[1]) / lines
        ends = np.empty((b - a, 2))
        cut = np.empty((b - a, 3))
        for p in range(lines):
            x = low[0] + (p + 0.5) * wide
            many = 0
            for s in range(a, b):
                # the plane at x cuts a circle of radius^2 = r^2 - (c_x - x)^2 out of the sphere
                square = radius[s] ** 2 - (centre[s, 0] - x) ** 2
                if square > 0.0:
                    cut[many, 0] = square
                    cut[many, 1] = centre[s, 1]
                    cut[many, 2] = centre[s, 2]
                    many += 1
            for q in range(lines):
                y = low[1] + (q + 0.5) * long
                used = 0
                for k in range(many):
                    # and the line at y half a chord of sqrt(radius^2 - (c_y - y)^2) out of that
                    square = cut[k, 0] - (cut[k, 1] - y) ** 2
                    if square > 0.0:
                        half = math.sqrt(square)
                        ends[used, 0] = cut[k, 2] - half
                        ends[used, 1] = cut[k, 2] + half
                        used += 1
                volume[n] += _covered(ends, used) * wide * long
    return volume
