"""What a turnable picture shows: bodies, perhaps in motion, an environment, and marks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from workbench.draw.closed_hands import closed_hands
from workbench.draw.scene import Colour, Mark, Scene, SceneBody
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = [
    "PEOPLE",
    "WebBody",
    "WebGaps",
    "WebMark",
    "WebPlace",
    "WebView",
    "body_view",
    "mark_view",
    "scene_view",
]

PEOPLE: dict[str, Colour] = {
    "warm": (214, 172, 138),
    "blue": (126, 164, 208),
    "green": (140, 184, 146),
    "rose": (206, 152, 170),
    "grey": (178, 178, 178),
}
"""Colour of a body in a turnable picture, by its family (see `colours.FAMILIES`)."""
_FAILING_KINDS = ("contact", "missed", "stop")
"""Kinds of marks that say that something fails."""


@dataclass(frozen=True, eq=False)
class WebBody:
    """A body of S spheres in F frames; one frame where it stands still."""

    name: str
    colour: Colour
    radius: Floats
    """(S,) [m]."""
    centres: Floats
    """(F, S, 3) [m]."""
    segment: Ints
    """(S,) index into `segments`."""
    segments: tuple[str, ...]
    spheres: tuple[str, ...]
    """(S,) names, "" where a sphere has none."""
    failing: tuple[int, ...] = ()
    """Spheres that touch what they may not: shown in red."""
    ghost: bool = False
    """Whether it is shown faint: another run, an earlier state."""
    touching: tuple[tuple[int, float, float], ...] = ()
    """Of a motion: spheres that are shown in red for a while, and from when to when [s]."""
    state: int | None = None
    """Of two states: 0 where it is of the first, 1 of the second, None of both."""


@dataclass(frozen=True)
class WebMark:
    """A point, or a dimension line between two points, with its text."""

    point: tuple[float, float, float]
    """Position [m]."""
    text: str
    to: tuple[float, float, float] | None = None
    """Other end [m] of a line."""
    failing: bool = False
    span: tuple[float, float] | None = None
    """From when to when [s] of a motion it is shown; always if None."""
    state: int | None = None
    """As of `WebBody`."""


@dataclass(frozen=True, eq=False)
class WebGaps:
    """How near a motion comes at each of T times, and what is asked of it."""

    times: Floats
    """(T,) [s] that rise."""
    least: Floats
    """(T,) [m] least gap."""
    words: str
    """What is nearest where it is least."""
    name: str = ""
    """The criterion that is nearest to failing, "" where there is none."""
    limit: float = 0.0
    """[m] What it asks for."""
    asked: Floats | None = None
    """(T,) [m] what it measures."""


@dataclass(frozen=True, eq=False)
class WebPlace:
    """A place as it is drawn.

    Parameters
    ----------
    vertices
        (V, 3) [m], each of one part.
    part
        (V,) index into `names`.
    triangles, edges
        (T, 3) and (E, 2) vertices.
    names, colours, glass
        Of the parts.
    state
        Of the parts, as of `WebBody`; all are of both states if empty.
    """

    vertices: Floats
    part: Ints
    triangles: Ints
    edges: Ints
    names: tuple[str, ...]
    colours: tuple[Colour, ...]
    glass: tuple[bool, ...]
    state: tuple[int | None, ...] = ()


@dataclass(frozen=True, eq=False)
class WebView:
    """One turnable picture."""

    title: str
    bodies: tuple[WebBody, ...] = ()
    environment: Environment | WebPlace | None = None
    marks: tuple[WebMark, ...] = ()
    times: tuple[float, ...] | None = field(default=None)
    """[s] of the F frames of a motion."""
    gaps: WebGaps | None = None
    """Shown under the times of a motion."""
    look_from: str = "corner"
    """The view it opens with: left, right, front, back, top or corner."""
    begin: float | None = None
    """[s] of a motion that it opens at; its first frame if None."""
    states: tuple[str, str] | None = None
    """What the two states are called that a slider wipes between, None where there is but one."""


def body_view(
    placed: Placed,
    name: str,
    colour: str,
    *,
    frames: slice | Sequence[int] = slice(0, 1),
    failing: Sequence[int] = (),
    ghost: bool = False,
    touching: Sequence[tuple[int, float, float]] = (),
    environment: Environment | None = None,
) -> WebBody:
    """Return a placed body as it is shown, without the segments outside its logical window.

    Parameters
    ----------
    placed
        The body in P poses of one person.
    name, colour
        What it is called, and a key of `PEOPLE`.
    frames
        The poses to be shown.
    failing
        Indices of spheres of the body that are shown in red.
    ghost
        Whether it is shown faint.
    touching
        Indices of spheres that are shown in red for a while, and from when to when [s].
    environment
        Whose controls hands hold where there is one frame. A hand has another number of spheres then;
        it is red as a whole where one of its own is failing.
    """
    body = placed.body
    rows = np.arange(len(placed))[frames]
    hands = closed_hands(placed, int(rows[0]), environment) if len(rows) == 1 else ()
    window = placed.window.copy()
    window[[hand.segment for hand in hands]] = False
    inside = window[body.sphere_segment]
    number = np.cumsum(inside) - 1
    kept = np.flatnonzero(inside)
    segments = [np.full(len(hand.radius), hand.segment) for hand in hands]
    segment = np.concatenate([body.sphere_segment[inside], *segments])
    red = set(body.sphere_segment[list(failing)].tolist()) & {hand.segment for hand in hands}
    return WebBody(
        name,
        PEOPLE[colour],
        np.concatenate(
            [body.radius[placed.person[rows[0]], inside], *(hand.radius for hand in hands)]
        ),
        np.concatenate(
            [placed.centres[rows][:, inside], *(hand.centre[None] for hand in hands)], axis=1
        ),
        segment,
        body.segment_names,
        (*(body.sphere_names[int(sphere)] for sphere in kept), *[""] * (len(segment) - len(kept))),
        tuple(
            sorted(
                {int(number[sphere]) for sphere in failing if inside[sphere]}
                | set(np.flatnonzero(np.isin(segment, list(red))).tolist())
            )
        ),
        ghost,
        tuple((int(number[s]), start, end) for s, start, end in touching if inside[s]),
    )


def mark_view(mark: Mark) -> WebMark:
    """Return a mark of a picture as it is shown in a turnable one."""
    return WebMark(mark.point, mark.label, mark.to, mark.kind in _FAILING_KINDS)


def scene_view(scene: Scene, names: Sequence[str] = ()) -> WebView:
    """Return a scene as it is shown in a turnable picture.

    Parameters
    ----------
    scene
        Bodies, environment, marks and ghosts.
    names
        Names of the bodies; those of their body files if empty.
    """
    shown = [*scene.bodies, *scene.ghosts]
    called = [*names, *(body.placed.body.name for body in shown[len(names) :])]
    bodies = tuple(
        replace(_one(body, name), ghost=k >= len(scene.bodies))
        for k, (body, name) in enumerate(zip(shown, called, strict=True))
    )
    return WebView(
        scene.title, bodies, scene.environment, tuple(mark_view(mark) for mark in scene.marks)
    )


def _one(shown: SceneBody, name: str) -> WebBody:
    pose = shown.pose % len(shown.placed)
    here = slice(pose, pose + 1)
    return body_view(shown.placed, name, shown.colour, frames=here, environment=shown.holds)
