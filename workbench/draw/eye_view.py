"""See a scene as somebody's eyes do: whose eyes, where they look, and a camera there."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from workbench.draw.camera import Camera, look_at
from workbench.draw.directions import Outlook
from workbench.draw.scene import Scene, SceneBody
from workbench.draw.zones import OWN
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Floats
from workbench.model.environment import Environment
from workbench.model.poses import Placed
from workbench.model.rule_set import RuleSet
from workbench.model.units import plain
from workbench.sight.eyes import USUAL_DOWN, Eyes, eyes_of, given_eyes, has_eyes, head_of
from workbench.sight.rules.cockpit_view import cockpit_outline
from workbench.sight.rules.eye_points import Side
from workbench.sight.scenery import scenery_of

__all__ = [
    "FIELD",
    "Onlooker",
    "eye_point",
    "eye_view",
    "eyes_camera",
    "looked_at",
    "onlooker",
    "outlook",
    "ruled",
    "without_head",
]

FIELD = math.radians(75.0)
"""Angle of view [rad] from bottom to top."""

_NEAR_PLANE = 0.08
"""Distance [m] before the eyes where drawing begins. Brows, nose and cheeks would hide the rest."""
_HEADINGS = math.radians(45.0)
"""A plot is about that multiple of this azimuth [rad] to which the head is turned most nearly."""


@dataclass(frozen=True, eq=False)
class Onlooker:
    """Whose eyes see a scene.

    Parameters
    ----------
    name
        Of the person or the point.
    eyes
        One row.
    body
        The index of the body in the scene, -1 where only a point is given.
    """

    name: str
    eyes: Eyes
    body: int = -1


def eye_point(shown: SceneBody) -> tuple[Floats, Floats]:
    """Find the eyes of a body.

    Returns
    -------
    tuple[Floats, Floats]
        The midpoint (3,) [m] between the pupils, and the axes (3, 3) of the head: forward, left, up
        as rows.

    Raises
    ------
    UsageError
        If the body has no eyes, or they are not placed.
    """
    eyes = _eyes(shown)
    return eyes.middle[0], eyes.axes[0]


def _eyes(shown: SceneBody) -> Eyes:
    """The eyes of a body, one row. Errors as of `eye_point`."""
    body = shown.placed.body
    if not has_eyes(body):
        raise UsageError(
            f"body {body.name}: no sphere is named an eye; give a camera by eye and target"
        )
    eyes = eyes_of(_alone(shown))
    if not np.all(np.isfinite(eyes.middle)):
        raise UsageError(
            f"body {body.name}: its eyes are outside the logical window, so it has no view"
        )
    return eyes


def _alone(shown: SceneBody) -> Placed:
    """The pose that is shown of a body."""
    placed = shown.placed
    pose = shown.pose % len(placed)
    return placed.of_person(int(placed.person[pose]), np.array([pose]))


def onlooker(scene: Scene, people: tuple[str, ...], name: str) -> Onlooker:
    """Find somebody's eyes in a scene, or eyes at a point of its environment.

    Parameters
    ----------
    scene, people
        The scene, and the names of its bodies.
    name
        Of a person or a point; "" for the first body.

    Raises
    ------
    UsageError
        If there is nobody and no point of that name, or the body has no eyes.
    """
    points = {} if scene.environment is None else scene.environment.points
    if not name and not scene.bodies:
        hint = f"; place eyes at a point by a view such as eye:POINT; {one_of('', points)}"
        raise UsageError(f"there is no body here whose eyes could see{hint if points else ''}")
    if name in people or not name:
        index = people.index(name) if name else 0
        called = people[index] if people else "the body"
        return Onlooker(called, _eyes(scene.bodies[index]), index)
    if name not in points:
        raise UsageError(
            f"nobody is called {name!r}; {one_of(name, [*people, *points])} (a person or a point)"
        )
    return Onlooker(name, given_eyes(points[name]))


def outlook(scene: Scene, people: tuple[str, ...], name: str) -> Outlook:
    """Return what somebody's eyes look out on, for plots of directions and plans of the ground.

    Arguments and errors as of `onlooker`. InputError where an eye is inside something.
    """
    looks = onlooker(scene, people, name)
    others = {
        people[k] if people else f"body {k + 1}": _alone(shown)
        for k, shown in enumerate(scene.bodies)
        if k != looks.body
    }
    own = _alone(scene.bodies[looks.body]) if looks.body >= 0 else None
    scenery = scenery_of(scene.environment, own, others)
    parts = () if scene.environment is None else tuple(scene.environment.parts)
    zones = [_whose(name, others) for name in scenery.names[len(parts) :]]
    forward = looks.eyes.axes[0, 0]
    azimuth = _HEADINGS * round(math.atan2(forward[1], forward[0]) / _HEADINGS)
    ahead = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
    axes = np.array([ahead, [-ahead[1], ahead[0], 0.0], [0.0, 0.0, 1.0]])
    name = plain(looks.name)
    called = f"the eyes of {name}" if looks.body >= 0 else f"eyes at {name}"
    return Outlook(called, scenery, (*parts, *zones), looks.eyes, axes)


def ruled(seen: Outlook, rules: RuleSet, side: str) -> Outlook:
    """The outlook with the outline of AC 25.773-1 drawn over, of the left or the right seat."""
    seat: Side = "right" if side == "right" else "left"
    region = cockpit_outline(rules, seat=seat, axes=seen.axes)
    return replace(seen, rule=region, status=rules.told("outline_left_seat"))


def _whose(segment: str, others: Iterable[str]) -> str:
    """The person whose segment of a scenery it is."""
    return next((name for name in others if segment.startswith(f"{name}'s ")), OWN)


def looked_at(environment: Environment | None, name: str) -> Floats:
    """(3,) [m] where a control, a part (the middle of its surface) or a point is; UsageError lists
    the names."""
    if environment is None:
        raise UsageError(f"look-at {name}: there is no environment here")
    places = {control.name: control.at for control in environment.controls} | environment.points
    if name in places:
        return np.array(places[name])
    if name not in environment.parts:
        valid = [*places, *environment.parts]
        raise UsageError(f"look-at: nothing is called {name!r}; {one_of(name, valid)}")
    corners = environment.triangle_corners(environment.part_index(name))
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(sides, axis=1)
    weighed: Floats = area @ corners.mean(axis=1)
    return weighed / float(area.sum())


def without_head(scene: Scene, body: int) -> Scene:
    """Return a scene without the head of one of its bodies."""
    if body < 0:
        return scene
    shown = scene.bodies[body]
    window = np.array(shown.placed.window)
    window[head_of(shown.placed.body)] = False
    headless = replace(shown, placed=replace(shown.placed, window=window))
    return replace(scene, bodies=(*scene.bodies[:body], headless, *scene.bodies[body + 1 :]))


def eye_view(
    shown: SceneBody,
    *,
    down: float = USUAL_DOWN,
    left: float = 0.0,
    field: float = FIELD,
    width: int = 640,
    height: int = 640,
) -> Camera:
    """Return a perspective camera between the eyes of a body, upright with its head.

    What is within 80 mm of the eyes is not drawn.

    Parameters
    ----------
    shown
        The body and its pose.
    down, left
        Angles [rad] of the line of sight from straight ahead of the head. The default is a usual
        line of sight.
    field
        Angle of view [rad] from bottom to top.
    width, height
        Size of the picture [pixels].
    """
    eyes = _eyes(shown)
    target = eyes.middle[0] + eyes.line(down=down, left=left)[0]
    return eyes_camera(eyes, "eye", target, field=field, width=width, height=height)


def eyes_camera(
    eyes: Eyes, kind: str, target: Floats | None, *, field: float, width: int, height: int
) -> Camera:
    """Return a perspective camera at eyes (one row), upright with the head.

    Parameters
    ----------
    eyes
        The eyes, with the head as it is turned.
    kind
        eye (midway between them), left_eye, right_eye, or both_eyes.
    target
        (3,) [m] what is in the middle of the picture; on a usual line of sight if None.
    field, width, height
        Angle of view [rad] from bottom to top, and size [pixels].
    """
    places = {"left_eye": eyes.left, "right_eye": eyes.right}
    place = places.get(kind, eyes.middle)[0]
    way = eyes.line()[0] if target is None else target - place
    distance = float(np.linalg.norm(way))
    camera = look_at(
        place,
        place + way / distance,
        up=eyes.axes[0, 2],
        field=field,
        width=width,
        height=height,
        cut=1.0 - _NEAR_PLANE,  # as a depth; what is in the middle of the picture is 1 m away
    )
    # opened: nothing before the bodies is cut away, as in views from outside
    return replace(
        camera,
        name="eye",
        opened=math.inf,
        aside=eyes.left[0] - eyes.middle[0] if kind == "both_eyes" else np.zeros(3),
        focus=math.inf if target is None else distance,
    )
