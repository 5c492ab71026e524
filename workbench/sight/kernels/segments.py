"""Find what blocks straight lines from eyes to points: triangles and spheres, exactly.

A line from the eye e to a point p meets a triangle with corners a, b, c where, seen from e, the
volumes d.(a x b), d.(b x c), d.(c x a) of d = p - e have one sign, at the share c.(a x b) / (their
sum) of the way. It meets a sphere where |e + s d - m| = r.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from workbench.compiled import batch_loop, inlined
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["Blockers", "blocked_lines"]


class Blockers(NamedTuple):
    """What may stand before eyes."""

    corners: Floats
    """(T, 3, 3) [m] opaque triangles."""
    item: Ints
    """(T,) of each."""
    moving: Bools
    """(N,) items that are displaced."""
    displacement: Floats
    """(B, 3) [m] of these."""
    centre: Floats
    """(B, S, 3) [m] of spheres."""
    radius: Floats
    """(B, S) [m]; NaN for none."""
    sphere_item: Ints
    """(S,) of each."""


@inlined
def _triangle_share(corners, t, ex, ey, ez, dx, dy, dz):  # type: ignore[no-untyped-def]
    """Share of the way d from e at which it meets triangle t; infinity where it does not."""
    ax = corners[t, 0, 0] - ex
    ay = corners[t, 0, 1] - ey
    az = corners[t, 0, 2] - ez
    bx = corners[t, 1, 0] - ex
    by = corners[t, 1, 1] - ey
    bz = corners[t, 1, 2] - ez
    cx = corners[t, 2, 0] - ex
    cy = corners[t, 2, 1] - ey
    cz = corners[t, 2, 2] - ez
    nx = ay * bz - az * by
    ny = az * bx - ax * bz
    nz = ax * by - ay * bx
    one = dx * nx + dy * ny + dz * nz
    two = dx * (by * cz - bz * cy) + dy * (bz * cx - bx * cz) + dz * (bx * cy - by * cx)
    three = dx * (cy * az - cz * ay) + dy * (cz * ax - cx * az) + dz * (cx * ay - cy * ax)
    whole = one + two + three
    same = (one >= 0.0 and two >= 0.0 and three >= 0.0) or (
        one <= 0.0 and two <= 0.0 and three <= 0.0
    )
    if not same or whole == 0.0:
        return math.inf
    return (cx * nx + cy * ny + cz * nz) / whole


@batch_loop
def blocked_lines(
    eye: Floats,
    points: Floats,
    own: Ints,
    margins: Floats,
    blockers: Blockers,
    begin: int,
    end: int,
    out: Ints,
) -> None:
    """Find the item that blocks each line first.

    Parameters
    ----------
    eye
        (B, 3) [m].
    points
        (B, M, 3) [m].
    own
        (M,) the item that each point is on, -1 for none.
    margins
        (2,) [m] before the point from which on other items, and its own, block nothing.
    blockers
        The scenery.
    begin, end
        The rows that are looked at.
    out
        (B, M) filled: the item, -1 where nothing blocks.
    """
    corners = blockers.corners
    for b in range(begin, end):
        row = b if len(blockers.radius) > 1 else 0
        for m in range(points.shape[1]):
            ex = eye[b, 0]
            ey = eye[b, 1]
            ez = eye[b, 2]
            dx = points[b, m, 0] - ex
            dy = points[b, m, 1] - ey
            dz = points[b, m, 2] - ez
            square = dx * dx + dy * dy + dz * dz
            length = math.sqrt(square)
            best = 1.0
            found = -1
            for t in range(len(corners)):
                item = blockers.item[t]
                sx = 0.0
                sy = 0.0
                sz = 0.0
                if blockers.moving[item]:
                    sx = blockers.displacement[row, 0]
                    sy = blockers.displacement[row, 1]
                    sz = blockers.displacement[row, 2]
                share = _triangle_share(corners, t, ex - sx, ey - sy, ez - sz, dx, dy, dz)
                margin = margins[1] if item == own[m] else margins[0]
                if share >= 0.0 and share < best and (1.0 - share) * length > margin:
                    best = share
                    found = item
            for s in range(blockers.radius.shape[1]):
                radius = blockers.radius[row, s]
                if not radius > 0.0:
                    continue
                mx = blockers.centre[row, s, 0] - ex
                my = blockers.centre[row, s, 1] - ey
                mz = blockers.centre[row, s, 2] - ez
                along = (mx * dx + my * dy + mz * dz) / square
                away = mx * mx + my * my + mz * mz - along * along * square
                rest = radius * radius - away
                if not rest >= 0.0:
                    continue
                half = math.sqrt(rest / square)
                share = max(along - half, 0.0)
                item = blockers.sphere_item[s]
                margin = margins[1] if item == own[m] else margins[0]
                if along + half > 0.0 and share < best and (1.0 - share) * length > margin:
                    best = share
                    found = item
            out[b, m] = found
