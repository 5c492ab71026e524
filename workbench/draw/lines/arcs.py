"""Find the visible rims of a scene's spheres as arcs of circles and ellipses, in pixels, exactly.

In a parallel view a rim is a circle at one depth. In perspective it is an ellipse: the tangent cone
of a sphere cut by the plane of the picture. It lies in a plane, so projective depth changes
linearly across the picture along it. Either way an arc is an ellipse, two angles of its parameter,
and a plane of depth.

A sphere that holds the eye is not drawn. Rims end at the near plane. The rim of a sphere that
reaches beside the eye is no ellipse and is left out, though the sphere hides what is behind it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, to_view
from workbench.draw.lines.silhouettes import (
    Rims,
    parallel_rims,
    perspective_rims,
    silhouette_arcs,
)
from workbench.draw.scene import Scene, Spheres, window_spheres
from workbench.draw.sphere_raster import project_disks
from workbench.errors import UsageError
from workbench.model.arrays import Bools, Floats, Ints

__all__ = [
    "JOINT_SHARE",
    "JOINT_STEP",
    "Arcs",
    "arc_lengths",
    "arc_points",
    "outline_arcs",
    "rim_ellipses",
    "rim_planes",
]

_MAX_SPHERES = 50_000
JOINT_STEP = 0.013
"""Least step of depth [m] that is drawn between spheres of one segment and of joined ones. With 12
to 15 mm ripples are gone and limbs still stand out."""
JOINT_SHARE = 0.4
"""The same as a share of the rim's radius. The rings of a thigh seen along its length are steps of
up to about a third of it."""


class Arcs(NamedTuple):
    """Visible arcs of rims. Angles go from +x (right) to +y (down) of the picture."""

    sphere: Ints
    """(A,) index in the scene's spheres."""
    disk: Floats
    """(A, 3) x, y of the middle, and the longer half axis [pixels]."""
    squeeze: Floats
    """(A, 2) shorter half axis as a share of the longer, and direction [rad] of the longer; 1 and 0
    for a circle."""
    angle: Floats
    """(A, 2) from and to [rad], of the ellipse's parameter from its longer axis; to is larger."""
    depth: Floats
    """(A,) projective depth [m] at the middle."""
    tilt: Floats
    """(A, 2) change of the projective depth per pixel to the right and down."""
    lead: Ints
    """(A, 2) spheres whose arcs lead into this one and go on after it; -1 for none, its own for a
    closed rim."""
    outer: Bools
    """(A,) whether it is seen against the background."""
    veiled: Bools
    """(A,) whether it is behind an opaque polygon."""
    body: Ints
    """(A,) index of the body in the scene."""


def arc_points(arcs: Arcs, which: Ints, angle: Floats) -> Floats:
    """Return points (M, 2) [pixels] of arcs `which` (M,) at angles (M,) of their parameters."""
    ratio, turn = arcs.squeeze[which].T
    x = arcs.disk[which, 2] * np.cos(angle)
    y = arcs.disk[which, 2] * ratio * np.sin(angle)
    if arcs.tilt.any():
        x, y = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
    return arcs.disk[which, :2] + np.column_stack([x, y])


def arc_lengths(arcs: Arcs) -> Floats:
    """Return the length (A,) [pixels] of each arc; within a few per cent for flat ellipses."""
    width = arcs.angle[:, 1] - arcs.angle[:, 0]
    return width * arcs.disk[:, 2] * np.sqrt((1.0 + arcs.squeeze[:, 0] ** 2) / 2.0)


def outline_arcs(
    scene: Scene, camera: Camera, *, step: float = JOINT_STEP, share: float = JOINT_SHARE
) -> Arcs:
    """Find the visible arcs of a scene's bodies, whatever the environment.

    Parameters
    ----------
    scene, camera
        What is seen, and from where.
    step, share
        Least step of depth, in metres and as a share of the rim's radius, that is drawn between
        spheres of one segment and of joined segments. With 0 and 0 everything visible is drawn.

    Raises
    ------
    UsageError
        If there are more than 50,000 spheres, whose rims would take minutes and be no drawing.
    """
    count = len(scene.spheres.radius)
    if count > _MAX_SPHERES:
        raise UsageError(f"outline: {count} spheres; {_MAX_SPHERES} at most, or draw them as disks")
    find = _parallel_arcs if math.isinf(camera.distance) else _perspective_arcs
    return find(scene, camera, step, share)


def _parallel_arcs(scene: Scene, camera: Camera, step: float, share: float) -> Arcs:
    """Find arcs of circles; the rims are cut in pixels."""
    spheres = scene.spheres
    flat = project_disks(spheres, camera)
    shown = np.sort(flat.order)
    disk = flat.disk[shown]
    depth = flat.centre[shown]
    balls = np.column_stack([disk[:, :2], depth * camera.scale, disk[:, 2]])
    steps = camera.scale * np.maximum(step, share * flat.radius[shown])
    segment, joined = _scene_segments(scene)
    rims = parallel_rims(balls, segment[shown], spheres.body[shown], joined, steps)
    angle, keys = silhouette_arcs(rims)
    circle = np.tile([1.0, 0.0], (len(disk), 1))
    shapes = _RimShapes(disk, circle, depth, np.zeros((len(disk), 2)))
    return _scene_arcs(spheres, shown, keys, angle, shapes)


def _perspective_arcs(scene: Scene, camera: Camera, step: float, share: float) -> Arcs:
    """Find arcs of ellipses; the rims are cut in metres, with angles on the tangent cone."""
    spheres = scene.spheres
    near = camera.distance - camera.nearest
    seen = to_view(camera, spheres.centre) * [1.0, -1.0, -1.0] + [0.0, 0.0, camera.distance]
    eye_outside = np.sum(seen * seen, axis=1) > spheres.radius**2 * (1.0 + 1e-12)
    shown = np.flatnonzero(eye_outside & (seen[:, 2] + spheres.radius > near))
    balls = np.column_stack([seen, spheres.radius])[shown]
    steps = np.maximum(step, share * spheres.radius[shown])
    segment, joined = _scene_segments(scene)
    rims = perspective_rims(balls, segment[shown], spheres.body[shown], joined, steps)
    angle, keys = _clip_arcs(rims, *silhouette_arcs(rims), near)
    disk, squeeze = rim_ellipses(camera, balls)
    depth, tilt = rim_planes(camera, rims.balls[:, :3], rims.balls[:, 5], disk)
    shapes = _RimShapes(disk, squeeze, depth, tilt)
    arcs = _scene_arcs(spheres, shown, keys, angle, shapes)
    return arcs._replace(angle=_ellipse_parameters(camera, rims.balls[keys[:, 0]], arcs))


def _clip_arcs(rims: Rims, angle: Floats, keys: Ints, near: float) -> tuple[Floats, Ints]:
    """Remove arcs that are no ellipses, and clip arcs where they come nearer than `near` [m]."""
    along = rims.balls[:, 2]
    radius = rims.balls[:, 3]
    crosses = (along - radius < near)[keys[:, 0]]
    if not crosses.any():
        return angle, keys
    angles = [angle[~crosses]]
    kept = [keys[~crosses]]
    for arc in np.flatnonzero(crosses & (along > radius)[keys[:, 0]]):
        first, last = angle[arc]
        for low, high in _far_intervals(rims.balls[keys[arc, 0]], first, last, near):
            key = keys[arc].copy()
            if low != first:
                key[1] = -1
            if high != last:
                key[2] = -1
            angles.append(np.array([[low, high]]))
            kept.append(key[None])
    return np.concatenate(angles), np.concatenate(kept)


def _far_intervals(
    ball: Floats, first: float, last: float, near: float
) -> Iterator[tuple[float, float]]:
    """Yield the parts of an arc, from angle `first` to `last`, that are farther than `near` [m].

    With t the length of the tangent, the rim's point at angle a has the distance
    t (level + swing cos(a)) along the view (columns of `ball` as in `Rims.balls`).
    """
    tangent = ball[5]
    level = tangent / ball[4] * ball[8]
    swing = ball[3] / ball[4] * ball[11]
    if swing < 0.0:
        cosine = (near / tangent - level) / swing
    else:
        cosine = math.inf if level * tangent > near else -math.inf
    if cosine <= -1.0:
        return
    # far enough from this angle to the same before the whole turn
    begin = math.acos(min(cosine, 1.0))
    for turn in range(math.floor(first / math.tau) - 1, math.floor(last / math.tau) + 1):
        low = max(first, turn * math.tau + begin)
        high = min(last, (turn + 1) * math.tau - begin)
        if high > low:
            yield low, high


def rim_ellipses(camera: Camera, balls: Floats) -> tuple[Floats, Floats]:
    """Project the rims of spheres in perspective.

    Parameters
    ----------
    camera
        A perspective camera.
    balls
        (S, 4) x, y (down), distance along the view, radius [m].

    Returns
    -------
    tuple[Floats, Floats]
        disk (S, 3) and squeeze (S, 2), as in `Arcs`.
    """
    # With w the distance along the view, rho = |(x, y)| and F the focal length in pixels:
    #     middle      F rho w / (w^2 - r^2) outward from the middle of the picture,
    #     half axes   F r sqrt(rho^2 + w^2 - r^2) / (w^2 - r^2) outward,
    #                 F r / sqrt(w^2 - r^2) across.
    focal = camera.scale * camera.distance
    x, y, along, radius = balls.T
    rho = np.hypot(x, y)
    square = np.where(along > radius, along**2 - radius**2, 1.0)
    longer = focal * radius * np.sqrt(np.maximum(rho * rho + square, 0.0)) / square
    centre = [camera.width / 2.0, camera.height / 2.0]
    middle = focal * balls[:, :2] * (along / square)[:, None] + centre
    ratio = focal * radius / np.sqrt(square) / longer
    return np.column_stack([middle, longer]), np.column_stack([ratio, np.arctan2(y, x)])


def rim_planes(
    camera: Camera, centre: Floats, tangent: Floats, disk: Floats
) -> tuple[Floats, Floats]:
    """Return the plane of each rim in pixels and projective depth.

    Parameters
    ----------
    camera
        A perspective camera.
    centre
        (S, 3) x, y (down), distance along the view [m] of the spheres.
    tangent
        (S,) distance [m] from the eye to the rim.
    disk
        (S, 3) as in `Arcs`.

    Returns
    -------
    tuple[Floats, Floats]
        Projective depth (S,) at the middle of the rim, and its change (S, 2) per pixel right and
        down.
    """
    # The rim's points p satisfy p . c = t^2, with c the centre and t the tangent.
    focal = camera.scale * camera.distance
    slope = (camera.distance / tangent) ** 2
    tilt = slope[:, None] * centre[:, :2] / focal
    offset = disk[:, :2] - [camera.width / 2.0, camera.height / 2.0]
    return slope * centre[:, 2] - camera.distance + np.sum(tilt * offset, axis=1), tilt


def _ellipse_parameters(camera: Camera, balls: Floats, arcs: Arcs) -> Floats:
    """Turn angles on tangent cones into angles (A, 2) of the ellipses' parameters.

    Parameters
    ----------
    camera
        A perspective camera.
    balls
        (A, 15) the spheres of the arcs, see `Rims`.
    arcs
        Arcs with angles on the cones.
    """
    turn = arcs.squeeze[:, 1]
    ends = []
    for angle in arcs.angle.T:
        x, y = (_cone_pixels(camera, balls, angle) - arcs.disk[:, :2]).T
        along_axis = x * np.cos(turn) + y * np.sin(turn)
        across_axis = y * np.cos(turn) - x * np.sin(turn)
        ends.append(np.arctan2(across_axis / arcs.squeeze[:, 0], along_axis))
    whole = arcs.angle[:, 1] - arcs.angle[:, 0] > math.tau - 1e-9
    width = np.where(whole, math.tau, (ends[1] - ends[0]) % math.tau)
    return np.column_stack([ends[0], ends[0] + width])


def _cone_pixels(camera: Camera, balls: Floats, angle: Floats) -> Floats:
    """Project the rays (A, 2) [pixels] of tangent cones at angles (A,); balls (A, 15), see `Rims`.

    A ray is cos b axis + sin b (cos a first + sin a second), with sin b = r / d and d the distance
    of the sphere from the eye.
    """
    sine = (balls[:, 3] / balls[:, 4])[:, None]
    cosine = (balls[:, 5] / balls[:, 4])[:, None]
    a = angle[:, None]
    across = np.cos(a) * balls[:, 9:12] + np.sin(a) * balls[:, 12:]
    ray = cosine * balls[:, 6:9] + sine * across
    focal = camera.scale * camera.distance
    centre = [camera.width / 2.0, camera.height / 2.0]
    return np.asarray(focal * ray[:, :2] / ray[:, 2:] + centre)


class _RimShapes(NamedTuple):
    """Ellipses and planes of S rims, as the fields of the same names in `Arcs`."""

    disk: Floats
    squeeze: Floats
    depth: Floats
    tilt: Floats


def _scene_arcs(
    spheres: Spheres, shown: Ints, keys: Ints, angle: Floats, shapes: _RimShapes
) -> Arcs:
    """Build arcs with the scene's numbers of spheres.

    Parameters
    ----------
    spheres, shown
        The scene's spheres, and those (S,) whose rims were cut.
    keys, angle
        Arcs as `silhouette_arcs` returns them.
    shapes
        Of the shown spheres.
    """
    number = np.append(shown, -1)  # -1 stays -1
    rim = keys[:, 0]
    sphere = number[rim]
    return Arcs(
        sphere,
        shapes.disk[rim],
        shapes.squeeze[rim],
        angle,
        shapes.depth[rim],
        shapes.tilt[rim],
        lead=number[keys[:, 1:3]],
        outer=keys[:, 3] == 1,
        veiled=np.zeros(len(keys), dtype=np.bool_),
        body=spheres.body[sphere],
    )


def _scene_segments(scene: Scene) -> tuple[Ints, Bools]:
    """Number the segments of all bodies through.

    Returns
    -------
    tuple[Ints, Bools]
        Segment (S,) of each sphere, and which segments (N, N) are one or joined.
    """
    first = np.cumsum([0, *(len(shown.placed.body.segments) for shown in scene.bodies)])
    joined = np.zeros((first[-1], first[-1]), dtype=np.bool_)
    numbers = [np.empty(0, dtype=np.int64)]
    for shown, low, high in zip(scene.bodies, first[:-1], first[1:], strict=True):
        numbers.append(low + window_spheres(shown)[2])
        joined[low:high, low:high] = shown.placed.body.adjacent
    return np.concatenate(numbers), joined
