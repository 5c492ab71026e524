"""Find what blocks straight lines from eyes to points: triangles and spheres, exactly.

A line from the eye e to a point p meets a triangle with corners a, b, c where, seen from e, the
volumes d.(a x b), d.(b x c), d.(c x a) of d = p - e have one sign, at the share c.(a x b) / (their
sum) of the way. It meets a sphere of centre m and radius r where |e + s d - m| = r.

Lines to the points of one group lie in a cone about the line to their middle. What is outside the
cone is passed over: first whole items, then their triangles, each as the sphere about it. A sphere
of radius r at the distance x along the axis and y from it is outside a cone of half angle w where
y cos w - x sin w > r.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from workbench.compiled import batch_loop, inlined
from workbench.geometry.polygon import point_winding
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["Blockers", "blocked_lines", "enclosing_parts"]


class Blockers(NamedTuple):
    """What may stand before eyes."""

    corners: Floats
    """(T, 3, 3) [m] triangles, grouped by item."""
    start: Ints
    """(N + 1,) where those of each item begin."""
    ball: Floats
    """(T, 4) centre and radius [m] of a sphere about each."""
    item_ball: Floats
    """(N, 4) the same about all of an item."""
    blocks: Bools
    """(N,) items that are looked at."""
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


class _Cone(NamedTuple):
    """A cone about the lines to a group of points."""

    eye: tuple[float, float, float]
    axis: tuple[float, float, float]
    sine: float
    """Of the half angle; cosine 0: everything is inside."""
    cosine: float
    length: float
    """Distance [m] of the farthest point."""


@inlined
def _cone(eye, points, b, begin, end):  # type: ignore[no-untyped-def]
    """The cone about the lines from eye b to its points `begin` to `end`."""
    ex, ey, ez = eye[b, 0], eye[b, 1], eye[b, 2]
    x = y = z = 0.0
    for m in range(begin, end):
        x += points[b, m, 0] - ex
        y += points[b, m, 1] - ey
        z += points[b, m, 2] - ez
    size = max(math.sqrt(x * x + y * y + z * z), 1e-300)
    x /= size
    y /= size
    z /= size
    cosine = 1.0
    length = 0.0
    for m in range(begin, end):
        px = points[b, m, 0] - ex
        py = points[b, m, 1] - ey
        pz = points[b, m, 2] - ez
        far = math.sqrt(px * px + py * py + pz * pz)
        cosine = min(cosine, (px * x + py * y + pz * z) / far)
        length = max(length, far)
    cosine = max(cosine - 1e-9, 0.0)  # rounding
    return _Cone((ex, ey, ez), (x, y, z), math.sqrt(1.0 - cosine * cosine), cosine, length)


@inlined
def _outside(cone, balls, k, radius, sx, sy, sz):  # type: ignore[no-untyped-def]
    """Whether the sphere k, displaced by s, is outside a cone or beyond its end."""
    x = balls[k, 0] + sx - cone.eye[0]
    y = balls[k, 1] + sy - cone.eye[1]
    z = balls[k, 2] + sz - cone.eye[2]
    along = x * cone.axis[0] + y * cone.axis[1] + z * cone.axis[2]
    beside = math.sqrt(max(x * x + y * y + z * z - along * along, 0.0))
    wide = cone.cosine > 0.0 and beside * cone.cosine - along * cone.sine > radius * (1.0 + 1e-9)
    return wide or along - radius > cone.length


@batch_loop
def blocked_lines(
    eye: Floats,
    points: Floats,
    group: Ints,
    own: Ints,
    margins: Floats,
    blockers: Blockers,
    begin: int,
    end: int,
    out: Ints,
    share: Floats,
) -> None:
    """Find the item that blocks each line first.

    Parameters
    ----------
    eye
        (B, 3) [m].
    points
        (B, M, 3) [m].
    group
        (G + 1,) where the groups of points that are near each other begin.
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
    share
        (B, M) filled: where on the way that is.
    """
    for b in range(begin, end):
        row = b if len(blockers.radius) > 1 else 0
        for g in range(len(group) - 1):
            for m in range(group[g], group[g + 1]):
                out[b, m] = -1
                share[b, m] = 1.0
            cone = _cone(eye, points, b, group[g], group[g + 1])
            _block_by_parts(
                cone, points, b, row, group[g], group[g + 1], own, margins, blockers, out, share
            )
            _block_by_spheres(
                cone, points, b, row, group[g], group[g + 1], own, margins, blockers, out, share
            )


@inlined
def _block_by_parts(cone, points, b, row, first, last, own, margins, blockers, out, share):  # type: ignore[no-untyped-def]
    """Let the triangles of items block the lines of a group."""
    for item in range(len(blockers.blocks)):
        if not blockers.blocks[item]:
            continue
        sx = sy = sz = 0.0
        if blockers.moving[item]:
            sx = blockers.displacement[row, 0]
            sy = blockers.displacement[row, 1]
            sz = blockers.displacement[row, 2]
        if _outside(cone, blockers.item_ball, item, blockers.item_ball[item, 3], sx, sy, sz):
            continue
        for t in range(blockers.start[item], blockers.start[item + 1]):
            if _outside(cone, blockers.ball, t, blockers.ball[t, 3], sx, sy, sz):
                continue
            for m in range(first, last):
                ex, ey, ez = cone.eye
                dx = points[b, m, 0] - ex
                dy = points[b, m, 1] - ey
                dz = points[b, m, 2] - ez
                found = _triangle_share(blockers.corners, t, ex - sx, ey - sy, ez - sz, dx, dy, dz)
                if found >= 0.0 and found < share[b, m]:
                    margin = margins[1] if item == own[m] else margins[0]
                    if (1.0 - found) * math.sqrt(dx * dx + dy * dy + dz * dz) > margin:
                        share[b, m] = found
                        out[b, m] = item


@inlined
def _block_by_spheres(cone, points, b, row, first, last, own, margins, blockers, out, share):  # type: ignore[no-untyped-def]
    """Let spheres block the lines of a group."""
    for s in range(blockers.radius.shape[1]):
        radius = blockers.radius[row, s]
        if not radius > 0.0 or _outside(cone, blockers.centre[row], s, radius, 0.0, 0.0, 0.0):
            continue
        for m in range(first, last):
            dx = points[b, m, 0] - cone.eye[0]
            dy = points[b, m, 1] - cone.eye[1]
            dz = points[b, m, 2] - cone.eye[2]
            square = dx * dx + dy * dy + dz * dz
            x = blockers.centre[row, s, 0] - cone.eye[0]
            y = blockers.centre[row, s, 1] - cone.eye[1]
            z = blockers.centre[row, s, 2] - cone.eye[2]
            along = (x * dx + y * dy + z * dz) / square
            rest = radius * radius - (x * x + y * y + z * z - along * along * square)
            if not rest >= 0.0:
                continue
            half = math.sqrt(rest / square)
            found = max(along - half, 0.0)
            item = blockers.sphere_item[s]
            if along + half > 0.0 and found < share[b, m]:
                margin = margins[1] if item == own[m] else margins[0]
                if (1.0 - found) * math.sqrt(square) > margin:
                    share[b, m] = found
                    out[b, m] = item


@batch_loop
def enclosing_parts(eye: Floats, blockers: Blockers, begin: int, end: int, out: Ints) -> None:
    """Find the item with a closed surface that each eye is inside of.

    Parameters
    ----------
    eye
        (B, 3) [m].
    blockers
        The scenery; `blocks` are the items with closed surfaces.
    begin, end
        The rows that are looked at.
    out
        (B,) filled where there is one.
    """
    for b in range(begin, end):
        row = b if len(blockers.radius) > 1 else 0
        for item in range(len(blockers.blocks)):
            if not blockers.blocks[item]:
                continue
            x, y, z = eye[b, 0], eye[b, 1], eye[b, 2]
            if blockers.moving[item]:
                x -= blockers.displacement[row, 0]
                y -= blockers.displacement[row, 1]
                z -= blockers.displacement[row, 2]
            dx = x - blockers.item_ball[item, 0]
            dy = y - blockers.item_ball[item, 1]
            dz = z - blockers.item_ball[item, 2]
            radius = blockers.item_ball[item, 3]
            if dx * dx + dy * dy + dz * dz > radius * radius:
                continue
            first, last = blockers.start[item], blockers.start[item + 1]
            if abs(point_winding(x, y, z, blockers.corners, first, last)) > 0.5:
                out[b] = item
