"""Many different bodies, one pose each, against an environment: the least clearance of each thing that is asked for."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from workbench.kernels.inside import inside_part
from workbench.kernels.tree import box_gap, nearest_polygon

__all__ = ["least_gaps"]


@njit(cache=True, nogil=True)
def least_gaps(centres, radius, shift, asked, faces, shells, out, begin, end):  # type: ignore[no-untyped-def]
    """Least signed distance plus allowance, for bodies begin..end.

    centres (B, S, 3), radius (B, S); shift (B, 3): how far the parts that go along have gone. asked: rows: spheres,
    group by group; first (G + 1,): where each group begins; pairs (M, 4): question, group, part, 1 where the part goes
    along; allowed (M,): added to the pair's distance. out: room (B, Q), infinite before; sphere, polygon (B, Q).
    """
    rows, first, pairs, allowed = asked
    room, sphere, polygon = out
    stack = np.empty(64, np.int64)
    for b in range(begin, end):
        for m in range(len(pairs)):
            q, g, k, moves = pairs[m, 0], pairs[m, 1], pairs[m, 2], pairs[m, 3]
            root = faces.root[k]
            if root < 0:
                continue
            for i in range(first[g], first[g + 1]):
                s = rows[i]
                x = centres[b, s, 0] - moves * shift[b, 0]
                y = centres[b, s, 1] - moves * shift[b, 1]
                z = centres[b, s, 2] - moves * shift[b, 2]
                r = radius[b, s]
                # the sphere must come nearer than `most` to be the one that counts
                most = room[b, q] - allowed[m]
                gap = math.sqrt(box_gap(x, y, z, faces.low[root], faces.high[root]))
                if gap > 0.0 and gap - r >= most:
                    continue
                inside = inside_part(x, y, z, faces, shells, k, stack)
                if not inside and most + r <= 0.0:
                    continue
                limit = np.inf if inside or most == np.inf else (most + r) * (most + r) * (1.0 + 1e-12)
                square, f, _, _, _ = nearest_polygon(x, y, z, faces, k, limit)
                if f < 0:
                    continue
                signed = (-math.sqrt(square) if inside else math.sqrt(square)) - r
                if signed + allowed[m] < room[b, q]:
                    room[b, q], sphere[b, q], polygon[b, q] = signed + allowed[m], s, f
