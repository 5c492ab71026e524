"""The paper's other raster method: scan line by scan line, only the frontmost parts of the spheres
that it meets.

A scan line and the eye (or the view's direction) span a cutting plane. It meets each sphere in a
circle or not at all; seen along the plane the circles cover runs of the line. Where runs begin, end
and circles cross one another the line is divided, and each piece goes to the sphere that is
foremost there: by its frontmost point (`front`, which is what a painter of disks shows) or by its
surface (`surface`, what a ray meets first). Nothing here is shared with the painter and the depth
buffer of `frames`, so that they check one another.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from PIL import Image

from workbench.draw.camera import Camera, to_view
from workbench.draw.colours import INKS, PAPER
from workbench.draw.scene import Scene, Spheres
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Floats, Ints

__all__ = ["RULES", "Pieces", "scan_numbers", "scan_pieces", "scanline"]

RULES = ("front", "surface")


class Pieces(NamedTuple):
    """Visible pieces of scan lines: row (K,), ends (K, 2) from and to [pixels], sphere (K,)."""

    row: Ints
    ends: Floats
    sphere: Ints


class _Circles(NamedTuple):
    """What a cutting plane meets: sphere (M,); middle (M, 2) across and along the plane; radius
    (M,); run (M, 2)."""

    sphere: Ints
    middle: Floats
    radius: Floats
    run: Floats


def scan_pieces(
    spheres: Spheres, camera: Camera, *, rule: str = "front", rows: Ints | None = None
) -> Pieces:
    """The visible pieces of scan lines `rows`, all where not given. UsageError for a rule that is
    not in RULES.

    A view with a finite cut is refused: the method has no cut faces.
    """
    if rule not in RULES:
        raise UsageError(f"no rule {rule!r} for scan lines; {one_of(rule, RULES)}")
    if math.isfinite(camera.cut):
        raise UsageError(
            "the scan-line display cannot cut; draw disks, or take the cut out of the camera"
        )
    seen = to_view(camera, spheres.centre)
    front = np.minimum(seen[:, 2] + spheres.radius, camera.nearest)
    found = [Pieces(np.empty(0, np.int64), np.empty((0, 2)), np.empty(0, np.int64))]
    for row in np.arange(camera.height) if rows is None else rows:
        height = (camera.height / 2.0 - row - 0.5) / camera.scale  # [m] of the line at depth 0
        circles = _cut(seen, spheres.radius, camera, float(height))
        ends, sphere = _foremost(circles, camera, front if rule == "front" else None)
        stretch = camera.scale * (
            math.hypot(height, camera.distance) if camera.inverse_distance else 1.0
        )
        found.append(Pieces(np.full(len(sphere), row), camera.width / 2.0 + stretch * ends, sphere))
    return Pieces(*(np.concatenate(column) for column in zip(*found, strict=True)))


def _cut(seen: Floats, radius: Floats, camera: Camera, height: float) -> _Circles:
    """The circles of the plane through a line at `height` [m] at depth 0.

    Parallel: across and depth; runs are metres across. Perspective: the eye is the origin and the
    line ahead of it the second axis; runs are slopes across / along, and spheres that hold the eye
    are left out.
    """
    if not camera.inverse_distance:
        off = height - seen[:, 1]
        middle = seen[:, [0, 2]]
    else:
        steep = math.hypot(height, camera.distance)
        ahead = (seen[:, 1] * height - (seen[:, 2] - camera.distance) * camera.distance) / steep
        off = (seen[:, 1] * camera.distance + (seen[:, 2] - camera.distance) * height) / steep
        middle = np.column_stack([seen[:, 0], ahead])
    square = radius * radius - off * off
    met = square > 0.0
    if camera.inverse_distance:
        met &= np.sum((seen - [0.0, 0.0, camera.distance]) ** 2, axis=1) > radius * radius
    sphere = np.flatnonzero(met)
    middle = middle[sphere]
    cut = np.sqrt(square[sphere])
    if not camera.inverse_distance:
        return _Circles(
            sphere, middle, cut, np.column_stack([middle[:, 0] - cut, middle[:, 0] + cut])
        )
    turn = np.arctan2(middle[:, 0], middle[:, 1])
    half = np.arcsin(np.minimum(cut / np.hypot(*middle.T), 1.0))
    low = np.maximum(turn - half, -math.pi / 2)
    high = np.minimum(turn + half, math.pi / 2)
    ahead_ = low < high
    run = np.tan(np.column_stack([low, high])[ahead_])
    return _Circles(sphere[ahead_], middle[ahead_], cut[ahead_], run)


def _foremost(circles: _Circles, camera: Camera, front: Floats | None) -> tuple[Floats, Ints]:
    """Ends (K, 2) and spheres (K,) of the pieces of one line. front (S,): depth that decides; None:
    the surface's."""
    places = np.unique(
        np.concatenate(
            [circles.run.ravel(), *([_crossings(circles, camera)] if front is None else [])]
        )
    )
    if len(places) < 2:
        return np.empty((0, 2)), np.empty(0, dtype=np.int64)
    middle = (places[1:] + places[:-1]) / 2.0
    inside = (circles.run[:, :1] < middle) & (middle < circles.run[:, 1:])
    score = _surface(circles, camera, middle) if front is None else front[circles.sphere][:, None]
    score = np.where(inside, score, -np.inf)
    best = (
        len(score) - 1 - np.argmax(score[::-1], axis=0)
    )  # of equal ones the last, as a painter would
    sphere = np.where(inside.any(axis=0), circles.sphere[best], -1)
    start = np.flatnonzero(np.diff(sphere, prepend=-2))
    end = np.append(start[1:], len(sphere))
    pieces = np.column_stack([places[start], places[end]])
    seen = sphere[start] >= 0
    return pieces[seen], sphere[start][seen]


def _surface(circles: _Circles, camera: Camera, place: Floats) -> Floats:
    """(M, K) how near the surface of each circle is at each place of the line: depth, or minus the
    distance."""
    across = circles.middle[:, :1]
    along = circles.middle[:, 1:]
    square = circles.radius[:, None] ** 2
    if not camera.inverse_distance:
        depth: Floats = along + np.sqrt(np.maximum(square - (place - across) ** 2, 0.0))
        return depth
    length = np.sqrt(1.0 + place * place)
    forward = (across * place + along) / length
    rest = forward**2 - (across**2 + along**2 - square)
    return np.sqrt(np.maximum(rest, 0.0)) - forward


def _crossings(circles: _Circles, camera: Camera) -> Floats:
    """Where on the line circles cross one another, as far as the eye is concerned; hidden crossings
    too."""
    first, second = np.triu_indices(len(circles.radius), 1)
    step = circles.middle[second] - circles.middle[first]
    apart = np.hypot(*step.T)
    r = circles.radius[first]
    s = circles.radius[second]
    meet = (apart < r + s) & (apart > np.abs(r - s))
    first = first[meet]
    step = step[meet]
    apart = apart[meet]
    r = r[meet]
    s = s[meet]
    foot = (apart * apart + r * r - s * s) / (2.0 * apart)
    rise = np.sqrt(np.maximum(r * r - foot * foot, 0.0))
    unit = step / apart[:, None]
    base = circles.middle[first] + foot[:, None] * unit
    side = rise[:, None] * unit[:, ::-1] * [-1.0, 1.0]
    points = np.concatenate([base + side, base - side])
    if not camera.inverse_distance:
        return points[:, 0]
    points = points[points[:, 1] > 0.0]
    slopes: Floats = points[:, 0] / points[:, 1]
    return slopes


def scan_numbers(spheres: Spheres, camera: Camera, *, rule: str = "front") -> Ints:
    """(height, width) the sphere shown in each pixel, -1 for none: pieces taken at the middles of
    pixels."""
    picture = np.full((camera.height, camera.width), -1, dtype=np.int64)
    pieces = scan_pieces(spheres, camera, rule=rule)
    edges = np.clip(pieces.ends, 0.0, camera.width) - 0.5
    first = np.ceil(edges[:, 0]).astype(np.int64)
    end = np.ceil(edges[:, 1]).astype(np.int64)
    for row, low, high, sphere in zip(pieces.row, first, end, pieces.sphere, strict=True):
        picture[row, low:high] = sphere
    return picture


def scanline(
    scene: Scene, camera: Camera, *, rule: str = "surface", spacing: int = 1
) -> Image.Image:
    """RGB picture of a scene's bodies by scan lines, every `spacing`-th one [pixels], in ink,
    stronger the nearer.

    The environment and marks are not drawn.
    """
    if spacing < 1:
        raise UsageError(f"scan lines must be 1 pixel apart or more, got {spacing}")
    spheres = scene.spheres
    shown = scan_numbers(spheres, camera, rule=rule)
    shown[np.arange(camera.height) % spacing != 0] = -1
    front = to_view(camera, spheres.centre)[:, 2] + spheres.radius
    low, high = (front.min(), front.max()) if len(front) else (0.0, 0.0)
    share = (front - low) / max(high - low, 1e-12)
    colour = np.array(
        [PAPER] * (len(front) + 1), dtype=np.float64
    )  # the last one, found by -1, is paper
    for index, body in enumerate(scene.bodies):
        mine = np.flatnonzero(spheres.body == index)
        strength = 0.2 + 0.8 * share[mine, None]
        colour[mine] += (np.array(INKS[body.colour]) - np.array(PAPER)) * strength
    return Image.fromarray(np.round(colour[shown]).astype(np.uint8))
