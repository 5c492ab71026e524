"""Draw spheres scan line by scan line, the paper's other raster method.

A scan line and the eye (or the direction of the view) span a cutting plane. The plane meets each
sphere in a circle or not at all. Seen along the plane, each circle covers an interval of the line.
The ends of the intervals and the points where circles cross divide the line into pieces. Each piece
shows the sphere that is foremost there, by one of two rules:

- ``front``: by the frontmost point of the sphere, as the painter's algorithm does.
- ``surface``: by its surface, which a ray meets first.

This module shares no code with `sphere_raster`, so that they can check one another.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from PIL import Image

from workbench.draw.camera import Camera, to_view
from workbench.draw.scene import INKS, PAPER, Scene, Spheres
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["RULES", "Pieces", "scan_numbers", "scan_pieces", "scanline"]

RULES = ("front", "surface")
"""Which sphere is foremost, see above."""


class Pieces(NamedTuple):
    """Visible pieces of scan lines."""

    row: Ints
    """(K,) the scan line."""
    ends: Floats
    """(K, 2) from and to [pixels]."""
    sphere: Ints
    """(K,)."""


class _Circles(NamedTuple):
    """The circles in which a cutting plane meets spheres.

    The axes of the plane are across (along the scan line) and along (into the view). In a parallel
    view they are metres to the right and depth. In perspective the eye is the origin.
    """

    sphere: Ints
    """(M,)."""
    centre: Floats
    """(M, 2) [m] across and along."""
    radius: Floats
    """(M,) [m]."""
    interval: Floats
    """(M, 2) covered part of the scan line: metres across, in perspective slopes across / along."""


def scan_pieces(
    spheres: Spheres, camera: Camera, *, rule: str = "front", rows: Ints | None = None
) -> Pieces:
    """Find the visible pieces of scan lines.

    Parameters
    ----------
    spheres, camera
        What is seen, and from where.
    rule
        One of `RULES`.
    rows
        The scan lines; all if None.

    Raises
    ------
    UsageError
        If there is no such rule, or the camera has a near plane: the method has no cut faces.
    """
    if rule not in RULES:
        raise UsageError(f"no rule {rule!r} for scan lines; {one_of(rule, RULES)}")
    if math.isfinite(camera.cut):
        raise UsageError(
            "the scan-line display cannot cut; draw disks, or take the cut out of the camera"
        )
    seen = to_view(camera, spheres.centre)
    front = np.minimum(seen[:, 2] + spheres.radius, camera.nearest)
    pieces = [Pieces(np.empty(0, np.int64), np.empty((0, 2)), np.empty(0, np.int64))]
    for row in np.arange(camera.height) if rows is None else rows:
        height = float((camera.height / 2.0 - row - 0.5) / camera.scale)  # [m] at depth 0
        circles = _plane_circles(seen, spheres.radius, camera, height)
        ends, sphere = _foremost_pieces(circles, camera, front if rule == "front" else None)
        stretch = camera.scale
        if math.isfinite(camera.distance):
            stretch *= math.hypot(height, camera.distance)
        ends = camera.width / 2.0 + stretch * ends
        pieces.append(Pieces(np.full(len(sphere), row), ends, sphere))
    return Pieces(*(np.concatenate(column) for column in zip(*pieces, strict=True)))


def _plane_circles(seen: Floats, radius: Floats, camera: Camera, height: float) -> _Circles:
    """Intersect spheres, in view coordinates (S, 3), with the plane of the line at `height` [m]."""
    if math.isinf(camera.distance):
        offset = height - seen[:, 1]
        sphere = np.flatnonzero(radius * radius - offset * offset > 0.0)
        centre = seen[sphere][:, [0, 2]]
        cut_radius = np.sqrt((radius * radius - offset * offset)[sphere])
        interval = np.column_stack([centre[:, 0] - cut_radius, centre[:, 0] + cut_radius])
        return _Circles(sphere, centre, cut_radius, interval)
    return _perspective_circles(seen, radius, camera, height)


def _perspective_circles(seen: Floats, radius: Floats, camera: Camera, height: float) -> _Circles:
    """Intersect spheres with the plane through the eye and a scan line.

    Spheres that hold the eye are left out, and intervals end beside the eye.
    """
    slant = math.hypot(height, camera.distance)  # from the eye to the line at depth 0
    depth = seen[:, 2] - camera.distance
    along = (seen[:, 1] * height - depth * camera.distance) / slant
    offset = (seen[:, 1] * camera.distance + depth * height) / slant
    square = radius * radius - offset * offset
    eye_outside = np.sum((seen - [0.0, 0.0, camera.distance]) ** 2, axis=1) > radius * radius
    sphere = np.flatnonzero((square > 0.0) & eye_outside)
    centre = np.column_stack([seen[:, 0], along])[sphere]
    cut_radius = np.sqrt(square[sphere])
    interval, ahead = _tangent_slopes(centre, cut_radius)
    return _Circles(sphere[ahead], centre[ahead], cut_radius[ahead], interval)


def _tangent_slopes(centre: Floats, radius: Floats) -> tuple[Floats, Bools]:
    """Return the slopes (K, 2) of the tangents from the eye to circles, and which (M,) are ahead."""
    direction = np.arctan2(centre[:, 0], centre[:, 1])
    half_angle = np.arcsin(np.minimum(radius / np.hypot(*centre.T), 1.0))
    low = np.maximum(direction - half_angle, -math.pi / 2)
    high = np.minimum(direction + half_angle, math.pi / 2)
    ahead = low < high
    return np.tan(np.column_stack([low, high])[ahead]), np.asarray(ahead)


def _foremost_pieces(
    circles: _Circles, camera: Camera, front: Floats | None
) -> tuple[Floats, Ints]:
    """Divide one line into pieces of one visible sphere each.

    Parameters
    ----------
    circles, camera
        The circles on the line, and the camera.
    front
        (S,) depth that decides which sphere is foremost; None for the surface's own.

    Returns
    -------
    tuple[Floats, Ints]
        Ends (K, 2) and sphere (K,).
    """
    ends = [circles.interval.ravel()]
    if front is None:
        ends.append(_crossings(circles, camera))
    places = np.unique(np.concatenate(ends))
    if len(places) < 2:
        return np.empty((0, 2)), np.empty(0, dtype=np.int64)
    middle = (places[1:] + places[:-1]) / 2.0
    inside = (circles.interval[:, :1] < middle) & (middle < circles.interval[:, 1:])
    nearness = (
        _nearness(circles, camera, middle) if front is None else front[circles.sphere][:, None]
    )
    nearness = np.where(inside, nearness, -np.inf)
    # the last of equal ones, as a painter would
    best = len(nearness) - 1 - np.argmax(nearness[::-1], axis=0)
    sphere = np.where(inside.any(axis=0), circles.sphere[best], -1)
    return _joined_pieces(places, sphere)


def _joined_pieces(places: Floats, sphere: Ints) -> tuple[Floats, Ints]:
    """Join neighbouring intervals between places (K + 1,) that show one sphere (K,), -1 for none."""
    start = np.flatnonzero(np.diff(sphere, prepend=-2))
    end = np.append(start[1:], len(sphere))
    pieces = np.column_stack([places[start], places[end]])
    covered = sphere[start] >= 0
    return pieces[covered], sphere[start][covered]


def _nearness(circles: _Circles, camera: Camera, place: Floats) -> Floats:
    """Return how near (M, K) the surface of each circle is at places (K,) of the line: its depth,
    in perspective minus its distance from the eye."""
    across = circles.centre[:, :1]
    along = circles.centre[:, 1:]
    square = circles.radius[:, None] ** 2
    if math.isinf(camera.distance):
        return along + np.sqrt(np.maximum(square - (place - across) ** 2, 0.0))
    length = np.sqrt(1.0 + place * place)
    forward = (across * place + along) / length  # of the centre, along the ray
    discriminant = forward**2 - (across**2 + along**2 - square)
    return np.sqrt(np.maximum(discriminant, 0.0)) - forward


def _crossings(circles: _Circles, camera: Camera) -> Floats:
    """Return where on the line two circles cross as seen from the eye; hidden crossings too."""
    points = _circle_intersections(circles)
    if math.isinf(camera.distance):
        return points[:, 0]
    points = points[points[:, 1] > 0.0]
    return points[:, 0] / points[:, 1]


def _circle_intersections(circles: _Circles) -> Floats:
    """Return the points (K, 2) in which two circles intersect."""
    first, second = np.triu_indices(len(circles.radius), 1)
    step = circles.centre[second] - circles.centre[first]
    distance = np.hypot(*step.T)
    r = circles.radius[first]
    s = circles.radius[second]
    meet = (distance < r + s) & (distance > np.abs(r - s))
    first, step, distance, r, s = (column[meet] for column in (first, step, distance, r, s))
    # circles of radius r and s at distance d cross at a = (d^2 + r^2 - s^2) / 2 d along the line
    # of their centres, and h = sqrt(r^2 - a^2) to either side of it
    foot = (distance * distance + r * r - s * s) / (2.0 * distance)
    rise = np.sqrt(np.maximum(r * r - foot * foot, 0.0))
    unit = step / distance[:, None]
    base = circles.centre[first] + foot[:, None] * unit
    side = rise[:, None] * unit[:, ::-1] * [-1.0, 1.0]
    return np.concatenate([base + side, base - side])


def scan_numbers(spheres: Spheres, camera: Camera, *, rule: str = "front") -> Ints:
    """Return the sphere (height, width) shown at the middle of each pixel, -1 for none."""
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
    """Draw the bodies of a scene by scan lines, each sphere in a shade that is lighter the nearer it
    is.

    Environment and marks are not drawn.

    Parameters
    ----------
    scene, camera
        What is drawn, and from where.
    rule
        One of `RULES`.
    spacing
        Distance [pixels] from one scan line to the next.

    Raises
    ------
    UsageError
        If the spacing is below 1; see also `scan_pieces`.
    """
    if spacing < 1:
        raise UsageError(f"scan lines must be 1 pixel apart or more, got {spacing}")
    spheres = scene.spheres
    shown = scan_numbers(spheres, camera, rule=rule)
    shown[np.arange(camera.height) % spacing != 0] = -1
    front = to_view(camera, spheres.centre)[:, 2] + spheres.radius
    low, high = (front.min(), front.max()) if len(front) else (0.0, 0.0)
    share = (front - low) / max(high - low, 1e-12)
    # the last row, which the index -1 finds, is paper
    colour = np.array([PAPER] * (len(front) + 1), dtype=np.float64)
    for index, body in enumerate(scene.bodies):
        own = np.flatnonzero(spheres.body == index)
        strength = 1.0 - 0.75 * share[own, None]  # of ink on paper: the nearest keep a quarter
        colour[own] += (np.array(INKS[body.colour]) - np.array(PAPER)) * strength
    return Image.fromarray(np.round(colour[shown]).astype(np.uint8))
