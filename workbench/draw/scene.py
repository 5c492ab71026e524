"""Scene: what a picture shows. Bodies in one pose each, an environment, marks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.draw.colours import FAMILIES, MARKS
from workbench.errors import InputError, UsageError, one_of
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = ["Mark", "Scene", "SceneBody", "Spheres", "shown_corners"]


@dataclass(frozen=True, eq=False)
class SceneBody:
    """One pose of a placed body, drawn in one colour family (see colours.FAMILIES)."""

    placed: Placed
    pose: int = 0
    colour: str = "warm"

    def __post_init__(self) -> None:
        if not -len(self.placed.centres) <= self.pose < len(self.placed.centres):
            raise UsageError(f"scene: pose {self.pose} of {len(self.placed.centres)}")
        if self.colour not in FAMILIES:
            raise UsageError(
                f"scene: no colour family {self.colour!r}; {one_of(self.colour, FAMILIES)}"
            )


@dataclass(frozen=True)
class Mark:
    """A point (3,) [m] to be marked, a short label ("" for none) and its kind (see colours.MARKS).

    to (3,) [m]: the other end of a mark that is a line: of a dimension (clearance), of an axis, of
    a miss.
    """

    point: tuple[float, float, float]
    label: str = ""
    kind: str = "contact"
    to: tuple[float, float, float] | None = None

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
    """All spheres of a scene: centre (S, 3), radius (S,) [m], body (S,): index into the scene's
    bodies."""

    centre: Floats
    radius: Floats
    body: Ints


@dataclass(frozen=True, eq=False)
class Scene:
    """Bodies, an environment or None, marks; title and description are read out by screen readers.

    ghosts: bodies shown pale behind all others, the earliest first (see ghosts); they are none of
    the scene's spheres. key: what the bodies of a colour family are, "predicted" and "warm", said
    in the picture's upper right corner.
    """

    bodies: tuple[SceneBody, ...] = ()
    environment: Environment | None = None
    marks: tuple[Mark, ...] = ()
    title: str = "Body"
    description: str = ""
    ghosts: tuple[SceneBody, ...] = ()
    key: tuple[tuple[str, str], ...] = ()

    @property
    def spheres(self) -> Spheres:
        """The spheres of all bodies in turn, without those outside a body's logical window."""
        found = [Spheres(np.empty((0, 3)), np.empty(0), np.empty(0, dtype=np.int64))]
        for index, shown in enumerate(self.bodies):
            body = shown.placed.body
            inside = shown.placed.window[body.sphere_segment]
            centre = shown.placed.centres[shown.pose][inside]
            if not np.all(np.isfinite(centre)):
                raise InputError(
                    f"scene: body {body.name}, pose {shown.pose}: sphere centres must be finite"
                )
            radius = body.radius[shown.placed.person[shown.pose], inside]
            found.append(Spheres(centre, radius, np.full(len(centre), index, dtype=np.int64)))
        return Spheres(*(np.concatenate(column) for column in zip(*found, strict=True)))

    @property
    def bounds(self) -> Floats:
        """(2, 3) the box [m] around all spheres; around what is shown of the environment where
        there is no body."""
        spheres = self.spheres
        if len(spheres.radius):
            reach = spheres.radius[:, None]
            return np.array(
                [(spheres.centre - reach).min(axis=0), (spheres.centre + reach).max(axis=0)]
            )
        corners = shown_corners(self.environment)
        if not len(corners):
            raise UsageError("scene: nothing to show; give a body or an environment")
        return np.array([corners.min(axis=0), corners.max(axis=0)])


def shown_corners(environment: Environment | None) -> Floats:
    """(V, 3) the corners [m] of all polygons that are not of hidden parts; none without an
    environment."""
    if environment is None:
        return np.empty((0, 3))
    shown = ~environment.hidden[environment.polygon_part]
    edges = environment.edges[np.repeat(shown, np.diff(environment.edge_start))]
    return environment.vertices[np.unique(edges)]
