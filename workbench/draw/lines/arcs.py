"""The visible rims of a scene's spheres as arcs of circles and ellipses, in pixels, exact.

In a parallel view a rim is a circle at one depth. In perspective it is an ellipse (the tangent cone
of a sphere cut by the picture's plane), and it lies in a plane: projective depth changes linearly
across the picture along it. Either way an arc is an ellipse, two ends as angles of its parameter,
and a plane of depth. A sphere that holds the eye is not drawn; rims end at the plane nearest the
eye; the rim of a sphere that reaches beside the eye is no ellipse and is left out, though the
sphere hides what is behind it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, to_view
from workbench.draw.kernels.arcs import silhouette_arcs
from workbench.draw.kernels.silhouettes import Rims, parallel_rims, perspective_rims
from workbench.draw.scene import Scene, Spheres
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

_MOST_SPHERES = 50_000
JOINT_STEP = 0.013  # [m] with 12 to 15 mm ripples are gone and limbs still stand out
# of the radius: rings of a thigh seen along its length are steps of up to about a third of it
JOINT_SHARE = 0.4


class Arcs(NamedTuple):
    """Visible arcs of rims: ellipses, circles in a parallel view; angles from +x (right) to +y
    (down) of the picture.

    sphere (A,): of the scene's spheres. disk (A, 3): x, y of the middle, the longer half axis
    [pixels]; squeeze (A, 2): the shorter half axis as a share of the longer, and the direction
    [rad] of the longer; 1 and 0 for a circle. angle (A, 2) [rad]: from and to, of the ellipse's
    parameter from its longer axis, the second larger. depth (A,): projective depth at the middle
    (see camera.projective), in a parallel view [m]; tilt (A, 2): its change a pixel to the right
    and down. lead (A, 2): the spheres whose arcs lead into this one and go on after it, -1 for
    none, its own for a closed rim; outer (A,): against the background; veiled (A,): behind an
    opaque polygon; body (A,).
    """

    sphere: Ints
    disk: Floats
    squeeze: Floats
    angle: Floats
    depth: Floats
    tilt: Floats
    lead: Ints
    outer: Bools
    veiled: Bools
    body: Ints


def arc_points(arcs: Arcs, which: Ints, angle: Floats) -> Floats:
    """(M, 2) [pixels] points of arcs `which` (M,) at angles (M,) of their parameters."""
    ratio, turn = arcs.squeeze[which].T
    x = arcs.disk[which, 2] * np.cos(angle)
    y = arcs.disk[which, 2] * ratio * np.sin(angle)
    if arcs.tilt.any():
        x, y = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
    points: Floats = arcs.disk[which, :2] + np.column_stack([x, y])
    return points


def arc_lengths(arcs: Arcs) -> Floats:
    """(A,) [pixels] length of each arc; of flat ellipses a few per cent too much or too little."""
    lengths: Floats = (
        (arcs.angle[:, 1] - arcs.angle[:, 0])
        * arcs.disk[:, 2]
        * np.sqrt((1.0 + arcs.squeeze[:, 0] ** 2) / 2.0)
    )
    return lengths


def outline_arcs(
    scene: Scene, camera: Camera, *, step: float = JOINT_STEP, share: float = JOINT_SHARE
) -> Arcs:
    """The visible arcs of a scene's bodies, whatever the environment.

    step [m], share: of depth between spheres of one segment and of joined ones: a smaller step is
    not drawn, nor one below this share of the rim's radius. 0 and 0: everything that shows.
    UsageError beyond 50,000 spheres, whose rims are a matter of minutes and no drawing.
    """
    count = len(scene.spheres.radius)
    if count > _MOST_SPHERES:
        raise UsageError(
            f"outline: {count} spheres; {_MOST_SPHERES} at most, or draw them as disks"
        )
    return (_parallel if math.isinf(camera.distance) else _perspective)(scene, camera, step, share)


def _parallel(scene: Scene, camera: Camera, step: float, share: float) -> Arcs:
    """Circles, in pixels."""
    spheres = scene.spheres
    flat = project_disks(spheres, camera)
    shown = np.sort(flat.order)
    disk = flat.disk[shown]
    depth = flat.centre[shown]
    balls = np.column_stack([disk[:, :2], depth * camera.scale, disk[:, 2]])
    segment, joined = _segments(scene)
    steps = camera.scale * np.maximum(step, share * flat.radius[shown])
    angle, keys = silhouette_arcs(
        parallel_rims(balls, segment[shown], spheres.body[shown], joined, steps)
    )
    which = keys[:, 0]
    count = len(keys)
    return _named(
        spheres,
        shown,
        keys,
        disk[which],
        np.tile([1.0, 0.0], (count, 1)),
        angle,
        depth[which],
        np.zeros((count, 2)),
    )


def _perspective(scene: Scene, camera: Camera, step: float, share: float) -> Arcs:
    """Ellipses: the angle on the cone becomes that of the ellipse's parameter."""
    spheres = scene.spheres
    near = camera.distance - camera.nearest
    seen = to_view(camera, spheres.centre) * [1.0, -1.0, -1.0] + [0.0, 0.0, camera.distance]
    outside = np.sum(seen * seen, axis=1) > spheres.radius**2 * (1.0 + 1e-12)
    shown = np.flatnonzero(outside & (seen[:, 2] + spheres.radius > near))
    balls = np.column_stack([seen, spheres.radius])[shown]
    radius = spheres.radius[shown]
    segment, joined = _segments(scene)
    rims = perspective_rims(
        balls, segment[shown], spheres.body[shown], joined, np.maximum(step, share * radius)
    )
    angle, keys = _ahead(rims, *silhouette_arcs(rims), near)
    which = keys[:, 0]
    disk, squeeze = rim_ellipses(camera, balls)
    depth, tilt = rim_planes(camera, rims.balls[:, :3], rims.balls[:, 5], disk)
    arcs = _named(
        spheres, shown, keys, disk[which], squeeze[which], angle, depth[which], tilt[which]
    )
    return arcs._replace(angle=_parameters(camera, rims.balls[which], arcs))


def _ahead(rims: Rims, angle: Floats, keys: Ints, near: float) -> tuple[Floats, Ints]:
    """Arcs without those that are no ellipses, and cut where they come nearer than `near` [m] along
    the view."""
    along = rims.balls[:, 2]
    radius = rims.balls[:, 3]
    cut = (along - radius < near)[keys[:, 0]]
    if not cut.any():
        return angle, keys
    angles = [angle[~cut]]
    names = [keys[~cut]]
    for arc in np.flatnonzero(cut & (along > radius)[keys[:, 0]]):
        ball = rims.balls[keys[arc, 0]]
        level = ball[5] / ball[4] * ball[8]
        swing = ball[3] / ball[4] * ball[11]
        cosine = (
            (near / ball[5] - level) / swing
            if swing < 0.0
            else (math.inf if level * ball[5] > near else -math.inf)
        )
        if cosine <= -1.0:
            continue
        open_ = math.acos(
            min(cosine, 1.0)
        )  # from here to the same before the whole turn it is far enough
        first, last = angle[arc]
        for turn in range(math.floor(first / math.tau) - 1, math.floor(last / math.tau) + 1):
            low = max(first, turn * math.tau + open_)
            high = min(last, (turn + 1) * math.tau - open_)
            if high > low:
                key = keys[arc].copy()
                key[1], key[2] = key[1] if low == first else -1, key[2] if high == last else -1
                angles.append(np.array([[low, high]]))
                names.append(key[None])
    return np.concatenate(angles), np.concatenate(names)


def rim_ellipses(camera: Camera, balls: Floats) -> tuple[Floats, Floats]:
    """disk (S, 3) and squeeze (S, 2), as in Arcs, of spheres (S, 4) x, y (down), distance along the
    view, radius [m].

    With w along the view, rho across it and F the focal length in pixels: middle F rho w / (w^2 -
    r^2) outward from the picture's middle, half axes F r sqrt(rho^2 + w^2 - r^2) / (w^2 - r^2)
    outward and F r / sqrt(w^2 - r^2) across.
    """
    focal = camera.scale * camera.distance
    off = np.hypot(balls[:, 0], balls[:, 1])
    square = np.where(balls[:, 2] > balls[:, 3], balls[:, 2] ** 2 - balls[:, 3] ** 2, 1.0)
    longer = focal * balls[:, 3] * np.sqrt(np.maximum(off * off + square, 0.0)) / square
    middle = focal * balls[:, :2] * (balls[:, 2] / square)[:, None] + [
        camera.width / 2.0,
        camera.height / 2.0,
    ]
    ratio = focal * balls[:, 3] / np.sqrt(square) / longer
    return np.column_stack([middle, longer]), np.column_stack(
        [ratio, np.arctan2(balls[:, 1], balls[:, 0])]
    )


def rim_planes(
    camera: Camera, centre: Floats, tangent: Floats, disk: Floats
) -> tuple[Floats, Floats]:
    """(S,) projective depth at the middle of each rim `disk` (S, 3) and (S, 2) its change a pixel
    right and down.

    centre (S, 3): x, y (down), distance along the view; tangent (S,): from the eye to the rim, t
    [m]. The rim's points p have p . c = t^2.
    """
    focal = camera.scale * camera.distance
    slope = (camera.distance / tangent) ** 2
    tilt = slope[:, None] * centre[:, :2] / focal
    offset = disk[:, :2] - [camera.width / 2.0, camera.height / 2.0]
    return slope * centre[:, 2] - camera.distance + np.sum(tilt * offset, axis=1), tilt


def _parameters(camera: Camera, balls: Floats, arcs: Arcs) -> Floats:
    """(A, 2) angles of the ellipses' parameters from angles on the cones of rims `balls` (A,
    15)."""
    focal = camera.scale * camera.distance
    ends = []
    sine = (balls[:, 3] / balls[:, 4])[:, None]
    cosine = (balls[:, 5] / balls[:, 4])[:, None]
    turn = arcs.squeeze[:, 1]
    for angle in arcs.angle.T[:, :, None]:
        ray = cosine * balls[:, 6:9] + sine * (
            np.cos(angle) * balls[:, 9:12] + np.sin(angle) * balls[:, 12:]
        )
        x, y = (
            focal * ray[:, :2] / ray[:, 2:]
            + [camera.width / 2.0, camera.height / 2.0]
            - arcs.disk[:, :2]
        ).T
        along = x * np.cos(turn) + y * np.sin(turn)
        across = y * np.cos(turn) - x * np.sin(turn)
        ends.append(np.arctan2(across / arcs.squeeze[:, 0], along))
    whole = arcs.angle[:, 1] - arcs.angle[:, 0] > math.tau - 1e-9
    width = np.where(whole, math.tau, (ends[1] - ends[0]) % math.tau)
    return np.column_stack([ends[0], ends[0] + width])


def _named(
    spheres: Spheres,
    shown: Ints,
    keys: Ints,
    disk: Floats,
    squeeze: Floats,
    angle: Floats,
    depth: Floats,
    tilt: Floats,
) -> Arcs:
    """Arcs of the shown spheres, named by the scene's numbers."""
    number = np.append(shown, -1)
    sphere = number[keys[:, 0]]
    veiled = np.zeros(len(keys), dtype=np.bool_)
    return Arcs(
        sphere,
        disk,
        squeeze,
        angle,
        depth,
        tilt,
        number[keys[:, 1:3]],
        keys[:, 3] == 1,
        veiled,
        spheres.body[sphere],
    )


def _segments(scene: Scene) -> tuple[Ints, Bools]:
    """(S,) the segment of each sphere, counted through all bodies, and (N, N) which of them are one
    or joined."""
    first = np.cumsum([0, *(len(shown.placed.body.segments) for shown in scene.bodies)])
    joined = np.zeros((first[-1], first[-1]), dtype=np.bool_)
    numbers = [np.empty(0, dtype=np.int64)]
    for shown, low, high in zip(scene.bodies, first[:-1], first[1:], strict=True):
        segment = shown.placed.body.sphere_segment
        numbers.append(low + segment[shown.placed.window[segment]])
        joined[low:high, low:high] = shown.placed.body.adjacent
    return np.concatenate(numbers), joined
