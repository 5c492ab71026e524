"""Lines and triangles cut by a plane, so that what is behind the eye or cut away is never
projected."""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["chain_segments", "clip_segments", "clip_triangles", "plane_intersections"]

_WELD = 1e-5  # [m] ends of lines nearer than about this are one


def _heights(points: Floats, normal: Floats) -> Floats:
    """(...,) points (..., 3) along a direction: sums written out are several times as fast as so
    narrow a product."""
    heights: Floats = (
        points[..., 0] * normal[0] + points[..., 1] * normal[1] + points[..., 2] * normal[2]
    )
    return heights


def clip_segments(ends: Floats, normal: Floats, offset: float) -> tuple[Floats, Ints]:
    """The pieces (K, 2, 3) of segments (M, 2, 3) where normal . x <= offset, and the segment (K,)
    of each."""
    above = _heights(ends, normal) - offset
    kept = np.flatnonzero(np.any(above <= 0.0, axis=1))
    pieces = ends[kept].copy()
    height = above[kept]
    for end in (0, 1):
        cut = np.flatnonzero(height[:, end] > 0.0)
        first = height[cut, 1 - end]
        second = height[cut, end]
        share = (first / (first - second))[:, None]
        pieces[cut, end] = ends[kept[cut], 1 - end] * (1.0 - share) + ends[kept[cut], end] * share
    return pieces, kept


def clip_triangles(corners: Floats, normal: Floats, offset: float) -> tuple[Floats, Ints]:
    """The pieces (K, 3, 3) of triangles (T, 3, 3) where normal . x <= offset, and the triangle (K,)
    of each.

    A triangle that loses one corner becomes two; windings stay. What is not cut is returned as it
    is, in order.
    """
    above = _heights(corners, normal) - offset
    count = np.sum(above > 0.0, axis=1)
    if not count.any():
        return corners, np.arange(len(corners))
    made = [corners[count == 0]]
    of = [np.flatnonzero(count == 0)]
    for lost in (1, 2):
        cut = np.flatnonzero(count == lost)
        apex, left, right, to_left, to_right = _crossings(
            corners[cut], above[cut], (above[cut] > 0.0) == (lost == 1)
        )
        if lost == 2:  # the apex is what is left
            made.append(np.stack([apex, to_left, to_right], axis=1))
            of.append(cut)
        else:
            made += [
                np.stack([to_left, left, right], axis=1),
                np.stack([to_left, right, to_right], axis=1),
            ]
            of += [cut, cut]
    pieces = np.concatenate(made)
    source = np.concatenate(of)
    order = np.argsort(source, kind="stable")
    return np.ascontiguousarray(pieces[order]), source[order]


def _crossings(
    corners: Floats, above: Floats, alone: Bools
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """The corner alone on its side, the next two in turn, and where the sides to them cross the
    plane; (K, 3) each."""
    row = np.arange(len(corners))
    at = np.argmax(alone, axis=1)
    apex = corners[row, at]
    height = above[row, at]
    others = []
    crossed = []
    for step in (1, 2):
        near = (at + step) % 3
        share = (height / (height - above[row, near]))[:, None]
        others.append(corners[row, near])
        crossed.append(apex * (1.0 - share) + corners[row, near] * share)
    return apex, others[0], others[1], crossed[0], crossed[1]


def plane_intersections(corners: Floats, normal: Floats, offset: float) -> tuple[Floats, Ints]:
    """Where the plane normal . x = offset crosses triangles (T, 3, 3): segments (K, 2, 3), and the
    triangle of each."""
    above = _heights(corners, normal) - offset
    count = np.sum(above > 0.0, axis=1)
    crossed = np.flatnonzero(count % 3 > 0)
    alone = (above[crossed] > 0.0) == (count[crossed] == 1)[:, None]
    _, _, _, first, second = _crossings(corners[crossed], above[crossed], alone)
    return np.stack([first, second], axis=1).reshape(-1, 2, 3), crossed


def chain_segments(lines: Floats) -> list[Floats]:
    """Lines (M, 2, 3) run together end to end, whichever way they point, into loops (K, 3)."""
    keys = np.round(lines / _WELD).astype(np.int64)
    names = [(tuple(a), tuple(b)) for a, b in keys.tolist()]
    at: dict[tuple[int, ...], list[int]] = {}
    for line, pair in enumerate(names):
        for end in pair:
            at.setdefault(end, []).append(line)
    free: Bools = np.array([a != b for a, b in names], dtype=np.bool_)
    loops = []
    for line in range(len(names)):
        if not free[line]:
            continue
        loop = []
        here = names[line][0]
        now = line
        while now >= 0:
            free[now] = False
            first = names[now][0] == here
            loop.append(lines[now, 0 if first else 1])
            here = names[now][1] if first else names[now][0]
            now = next((other for other in at[here] if free[other]), -1)
        if len(loop) > 2:
            loops.append(np.array(loop))
    return loops
