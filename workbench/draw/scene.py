"""Describe what a picture shows: bodies in one pose each, an environment, marks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.draw.closed_hands import closed_hands
from workbench.draw.colours import FAMILIES, MARKS
from workbench.errors import InputError, UsageError, one_of
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = ["Mark", "Scene", "SceneBody", "Spheres", "shown_corners", "window_spheres"]


@dataclass(frozen=True, eq=False)
class SceneBody:
    """One pose of a placed body, drawn in one colour family."""

    placed: Placed
    pose: int = 0
    colour: str = "warm"
    """A key of `colours.FAMILIES`."""
    holds: Environment | None = None
    """The surroundings, whole, whose controls the hands hold; None: hands are as the body has them."""

    def __post_init__(self) -> None:
        if not -len(self.placed.centres) <= self.pose < len(self.placed.centres):
            raise UsageError(f"scene: pose {self.pose} of {len(self.placed.centres)}")
        if self.colour not in FAMILIES:
            raise UsageError(
                f"scene: no colour family {self.colour!r}; {one_of(self.colour, FAMILIES)}"
            )


@dataclass(frozen=True)
class Mark:
    """A point or a line to be marked in a picture."""

    point: tuple[float, float, float]
    """Position [m]."""
    label: str = ""
    kind: str = "contact"
    """A key of `colours.MARKS`."""
    to: tuple[float, float, float] | None = None
    """Other end [m] of a mark that is a line: a dimension (clearance), an axis, a missed target."""

    def __post_init__(self) -> None:
        for end in (self.point,) if self.to is None else (self.point, self.to):
            if len(end) != 3 or not np.all(np.isfinite(end)):
                raise InputError(
                    f"mark {self.label!r}: a finite point of 3 coordinates is needed, got {end}"
                )
        if self.kind not in MARKS:
            raise UsageError(
                f"mark {self.label!r}: no kind {self.kind!r}; {one_of(self.kind, MARKS)}"
            )


class Spheres(NamedTuple):
    """All spheres of a scene."""

    centre: Floats
    """(S, 3) [m]."""
    radius: Floats
    """(S,) [m]."""
    body: Ints
    """(S,) index of the body in the scene."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies, an environment and marks; screen readers read out title and description."""

    bodies: tuple[SceneBody, ...] = ()
    environment: Environment | None = None
    marks: tuple[Mark, ...] = ()
    title: str = "Body"
    description: str = ""
    ghosts: tuple[SceneBody, ...] = ()
    """Bodies shown pale behind all others, the earliest first (see `ghosts`). They are not part of
    `spheres` and `bounds`."""
    key: tuple[tuple[str, str], ...] = ()
    """Legend in the upper right corner: text and colour family of each line."""

    @property
    def spheres(self) -> Spheres:
        """The spheres of all bodies in turn, without those outside a body's logical window."""
        columns = [Spheres(np.empty((0, 3)), np.empty(0), np.empty(0, dtype=np.int64))]
        for index, shown in enumerate(self.bodies):
            centre, radius, _ = window_spheres(shown)
            columns.append(Spheres(centre, radius, np.full(len(centre), index, dtype=np.int64)))
        return Spheres(*(np.concatenate(column) for column in zip(*columns, strict=True)))

    @property
    def bounds(self) -> Floats:
        """(2, 3) bounding box [m] of all spheres, or of the shown environment without bodies."""
        spheres = self.spheres
        if len(spheres.radius):
            radius = spheres.radius[:, None]
            low, high = spheres.centre - radius, spheres.centre + radius
        else:
            low = high = shown_corners(self.environment)
        if not len(low):
            raise UsageError("scene: nothing to show; give a body or an environment")
        return np.array([low.min(axis=0), high.max(axis=0)])


def window_spheres(shown: SceneBody) -> tuple[Floats, Floats, Ints]:
    """Return centres (S, 3) and radii (S,) [m] of the spheres in a body's logical window, of hands
    at controls as they hold them, which come last; and their segments (S,)."""
    placed = shown.placed
    body = placed.body
    hands = closed_hands(placed, shown.pose, shown.holds)
    window = placed.window.copy()
    window[[hand.segment for hand in hands]] = False
    inside = window[body.sphere_segment]
    centre = placed.centres[shown.pose][inside]
    if not np.all(np.isfinite(centre)):
        raise InputError(
            f"scene: body {body.name}, pose {shown.pose}: sphere centres must be finite"
        )
    radius = body.radius[placed.person[shown.pose], inside]
    return (
        np.concatenate([centre, *(hand.centre for hand in hands)]),
        np.concatenate([radius, *(hand.radius for hand in hands)]),
        np.concatenate(
            [
                body.sphere_segment[inside],
                *(np.full(len(hand.radius), hand.segment) for hand in hands),
            ]
        ),
    )


def shown_corners(environment: Environment | None) -> Floats:
    """Return the corners (V, 3) [m] of all polygons of parts that are not hidden."""
    if environment is None:
        return np.empty((0, 3))
    shown = ~environment.hidden[environment.polygon_part]
    edges = environment.edges[np.repeat(shown, np.diff(environment.edge_start))]
    return environment.vertices[np.unique(edges)]
