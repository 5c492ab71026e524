"""Clip line segments and triangles by a plane, and find where a plane crosses triangles.

What lies behind the eye or is cut away must never be projected.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["chain_segments", "clip_segments", "clip_triangles", "plane_intersections"]

_WELD_DISTANCE = 1e-5
"""Spacing [m] of the grid to which ends of lines are rounded; ends in one cell are one point."""


def _heights(points: Floats, normal: Floats) -> Floats:
    """Return points (..., 3) . normal (3,).

    Three written products are several times as fast as a matrix product that is this narrow.
    """
    return points[..., 0] * normal[0] + points[..., 1] * normal[1] + points[..., 2] * normal[2]


def clip_segments(ends: Floats, normal: Floats, offset: float) -> tuple[Floats, Ints]:
    """Keep what of segments (M, 2, 3) lies where normal . x <= offset.

    Returns
    -------
    tuple[Floats, Ints]
        Pieces (K, 2, 3), and the segment (K,) of each.
    """
    above = _heights(ends, normal) - offset
    kept = np.flatnonzero(np.any(above <= 0.0, axis=1))
    pieces = ends[kept].copy()
    height = above[kept]
    for end in (0, 1):
        cut = np.flatnonzero(height[:, end] > 0.0)
        inner = height[cut, 1 - end]
        # heights h_in <= 0 < h_out: the plane is at the share h_in / (h_in - h_out) of the way
        share = (inner / (inner - height[cut, end]))[:, None]
        pieces[cut, end] = ends[kept[cut], 1 - end] * (1.0 - share) + ends[kept[cut], end] * share
    return pieces, kept


def clip_triangles(corners: Floats, normal: Floats, offset: float) -> tuple[Floats, Ints]:
    """Keep what of triangles (T, 3, 3) lies where normal . x <= offset.

    A triangle that loses one corner becomes two triangles. Windings stay.

    Returns
    -------
    tuple[Floats, Ints]
        Pieces (K, 3, 3) in the order of their triangles, and the triangle (K,) of each.
    """
    above = _heights(corners, normal) - offset
    lost = np.sum(above > 0.0, axis=1)
    if not lost.any():
        return corners, np.arange(len(corners))
    whole = np.flatnonzero(lost == 0)
    one_lost = np.flatnonzero(lost == 1)
    two_lost = np.flatnonzero(lost == 2)
    quad = _split_at_plane(corners[one_lost], above[one_lost], above[one_lost] > 0.0)
    tip = _split_at_plane(corners[two_lost], above[two_lost], above[two_lost] <= 0.0)
    pieces = np.concatenate(
        [
            corners[whole],
            np.stack([quad.left_cut, quad.left, quad.right], axis=1),
            np.stack([quad.left_cut, quad.right, quad.right_cut], axis=1),
            np.stack([tip.apex, tip.left_cut, tip.right_cut], axis=1),
        ]
    )
    source = np.concatenate([whole, one_lost, one_lost, two_lost])
    order = np.argsort(source, kind="stable")
    return np.ascontiguousarray(pieces[order]), source[order]


class _SplitTriangles(NamedTuple):
    """Triangles that a plane crosses; (K, 3) points each."""

    apex: Floats
    """The corner that is alone on its side of the plane."""
    left: Floats
    """The next corner in the order of the winding."""
    right: Floats
    """The corner after that."""
    left_cut: Floats
    """Where the plane cuts the side from apex to left."""
    right_cut: Floats
    """Where the plane cuts the side from apex to right."""


def _split_at_plane(corners: Floats, above: Floats, alone: Bools) -> _SplitTriangles:
    """Cut triangles (K, 3, 3) at heights `above` (K, 3) = 0; alone (K, 3): marks each apex."""
    row = np.arange(len(corners))
    first = np.argmax(alone, axis=1)
    apex = corners[row, first]
    height = above[row, first]
    others = []
    cuts = []
    for step in (1, 2):
        other = (first + step) % 3
        share = (height / (height - above[row, other]))[:, None]
        others.append(corners[row, other])
        cuts.append(apex * (1.0 - share) + corners[row, other] * share)
    return _SplitTriangles(apex, *others, *cuts)


def plane_intersections(corners: Floats, normal: Floats, offset: float) -> tuple[Floats, Ints]:
    """Intersect triangles (T, 3, 3) with the plane normal . x = offset.

    Returns
    -------
    tuple[Floats, Ints]
        Segments (K, 2, 3), and the triangle (K,) of each.
    """
    above = _heights(corners, normal) - offset
    count = np.sum(above > 0.0, axis=1)  # 1 or 2 corners above: the plane crosses
    crossed = np.flatnonzero(count % 3 > 0)
    alone = (above[crossed] > 0.0) == (count[crossed] == 1)[:, None]
    split = _split_at_plane(corners[crossed], above[crossed], alone)
    return np.stack([split.left_cut, split.right_cut], axis=1).reshape(-1, 2, 3), crossed


def chain_segments(lines: Floats) -> list[Floats]:
    """Join segments (M, 2, 3) end to end, in either direction, into polylines (K, 3)."""
    keys = np.round(lines / _WELD_DISTANCE).astype(np.int64)
    nodes = [(tuple(a), tuple(b)) for a, b in keys.tolist()]
    lines_at: dict[tuple[int, ...], list[int]] = {}
    for line, pair in enumerate(nodes):
        for node in pair:
            lines_at.setdefault(node, []).append(line)
    unused = [a != b for a, b in nodes]
    chains = []
    for line, (node, _) in enumerate(nodes):
        chain = []
        current: int | None = line if unused[line] else None
        while current is not None:
            unused[current] = False
            forward = nodes[current][0] == node
            chain.append(lines[current, 0 if forward else 1])
            node = nodes[current][1] if forward else nodes[current][0]
            current = next((other for other in lines_at[node] if unused[other]), None)
        if len(chain) > 2:
            chains.append(np.array(chain))
    return chains
