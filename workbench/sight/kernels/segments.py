"""Find what blocks straight lines from eyes to points: triangles and spheres, exactly.

The line d from an eye to a point meets a triangle with corners a, b, c, seen from the eye, where the
volumes d.(a x b), d.(b x c), d.(c x a) have one sign, at the share c.(a x b) / (their sum) of the
way. It meets a sphere of centre m, seen from the eye, and radius r where |s d - m| = r.

Lines to the points of one group lie in a cone. What is outside it is passed over: first whole items,
then their triangles, each as the sphere about it. A sphere of radius r at the distance x along the
axis and y from it is outside a cone of half angle w where y cos w - x sin w > r.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from workbench.compiled import batch_loop, inlined
from workbench.geometry.polygon import winding_number
from workbench.geometry.vectors import cross, dot, norm, subtract, vector
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["Blockers", "Lines", "blocked_lines", "enclosing"]


_ROUNDING = 1e-9
"""[m] More than rounding makes of the size of a box."""


class Blockers(NamedTuple):
    """What may stand before B eyes.

    corners (T, 3, 3) [m]: triangles, grouped by item; those of an item begin at start (N + 1,).
    ball (T, 4), item_ball (N, 7) [m]: centre and radius of a sphere about each triangle and each
    item, and half the size of the item's box. blocks (N,): items that block. moving (N,): those
    displaced by displacement (R, 3) [m]. centre (R, S, 3), radius (R, S) [m]: spheres, NaN for none;
    sphere_item (S,). Eye b has row b modulo R.
    """

    corners: Floats
    start: Ints
    ball: Floats
    item_ball: Floats
    blocks: Bools
    moving: Bools
    displacement: Floats
    centre: Floats
    radius: Floats
    sphere_item: Ints


class Lines(NamedTuple):
    """Lines from B eyes to M points each.

    eye (B, 3) [m]; way (B, M, 3) [m] from the eye to each point. group (G + 1,): where groups of
    points that are near each other begin; cone (B, G, 6): unit axis, sine and cosine of the half
    angle, and distance of the farthest point [m]. A cosine of 0 holds everything.
    own (M,): the item that each point is on, -1 for none; margins (2,) [m]: how near the point other
    items, and this one, block nothing. item, share (B, M): filled with the item that blocks first,
    and where; they begin with -1 for none, and 1.
    """

    eye: Floats
    way: Floats
    group: Ints
    cone: Floats
    margins: Floats
    own: Ints
    item: Ints
    share: Floats


@inlined
def _outside(cone, seen, radius):  # type: ignore[no-untyped-def]
    """Whether a sphere, seen from the eye, is outside a cone (6,) or beyond its end."""
    along = dot(seen, vector(cone))
    beside = math.sqrt(max(dot(seen, seen) - along * along, 0.0))
    wide = cone[4] > 0.0 and beside * cone[4] - along * cone[3] > radius * (1.0 + 1e-9)
    return wide or along - radius > cone[5]


@inlined
def _triangle_share(corners, t, eye, way):  # type: ignore[no-untyped-def]
    """Share of the way from an eye at which it meets triangle t; infinity where it does not."""
    a = subtract(vector(corners[t, 0]), eye)
    b = subtract(vector(corners[t, 1]), eye)
    c = subtract(vector(corners[t, 2]), eye)
    normal = cross(a, b)
    one = dot(way, normal)
    two = dot(way, cross(b, c))
    three = dot(way, cross(c, a))
    whole = one + two + three
    least = min(one, two, three)
    most = max(one, two, three)
    if (least < 0.0 and most > 0.0) or whole == 0.0:
        return math.inf
    return dot(c, normal) / whole


@inlined
def _sphere_share(centre, radius, way):  # type: ignore[no-untyped-def]
    """Share of the way at which it enters a sphere, 0 from inside; infinity where it does not."""
    square = dot(way, way)
    along = dot(centre, way) / square
    rest = radius * radius - (dot(centre, centre) - along * along * square)
    if not rest >= 0.0:
        return math.inf
    half = math.sqrt(rest / square)
    return max(along - half, 0.0) if along + half > 0.0 else math.inf


@inlined
def _block(lines, b, m, item, share):  # type: ignore[no-untyped-def]
    """Let an item block line m of eye b at a share of the way, if nothing does before."""
    if share >= 0.0 and share < lines.share[b, m]:
        way = vector(lines.way[b, m])
        margin = lines.margins[1] if item == lines.own[m] else lines.margins[0]
        if (1.0 - share) * math.sqrt(dot(way, way)) > margin:
            lines.share[b, m] = share
            lines.item[b, m] = item


@batch_loop
def blocked_lines(lines: Lines, blockers: Blockers, begin: int, end: int) -> None:
    """Find what blocks the lines of the eyes from `begin` to `end` first."""
    for b in range(begin, end):
        row = b % len(blockers.radius)
        for g in range(len(lines.group) - 1):
            cone = lines.cone[b, g]
            points = range(lines.group[g], lines.group[g + 1])
            for item in range(len(blockers.blocks)):
                eye = vector(lines.eye[b])
                if blockers.moving[item]:
                    eye = subtract(eye, vector(blockers.displacement[row]))
                ball = blockers.item_ball[item]
                if not blockers.blocks[item] or _outside(
                    cone, subtract(vector(ball), eye), ball[3]
                ):
                    continue
                for t in range(blockers.start[item], blockers.start[item + 1]):
                    ball = blockers.ball[t]
                    if _outside(cone, subtract(vector(ball), eye), ball[3]):
                        continue
                    for m in points:
                        share = _triangle_share(blockers.corners, t, eye, vector(lines.way[b, m]))
                        _block(lines, b, m, item, share)
            for s in range(blockers.radius.shape[1]):
                radius = blockers.radius[row, s]
                centre = subtract(vector(blockers.centre[row, s]), vector(lines.eye[b]))
                if not radius > 0.0 or _outside(cone, centre, radius):
                    continue
                for m in points:
                    share = _sphere_share(centre, radius, vector(lines.way[b, m]))
                    _block(lines, b, m, blockers.sphere_item[s], share)


@batch_loop
def enclosing(eyes: Floats, blockers: Blockers, found: Ints) -> None:
    """Write the item that each of eyes (B, 3) is in: a sphere, or of those that block a closed one."""
    for b in range(len(eyes)):
        row = b % len(blockers.radius)
        for s in range(blockers.radius.shape[1]):
            away = subtract(vector(blockers.centre[row, s]), vector(eyes[b]))
            if norm(away) < blockers.radius[row, s]:
                found[b] = blockers.sphere_item[s]
        for item in range(len(blockers.blocks)):
            eye = vector(eyes[b])
            if blockers.moving[item]:
                eye = subtract(eye, vector(blockers.displacement[row]))
            bound = blockers.item_ball[item]
            out = subtract(vector(bound), eye)
            beside = max(abs(out[0]) - bound[4], abs(out[1]) - bound[5], abs(out[2]) - bound[6])
            if not blockers.blocks[item] or beside > _ROUNDING:
                continue
            x, y, z = eye
            begun = blockers.start[item]
            ended = blockers.start[item + 1]
            if abs(winding_number(x, y, z, blockers.corners, begun, ended)) > 0.5:
                found[b] = item
