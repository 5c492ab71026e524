"""Describe what a picture shows: bodies in one pose each, an environment, marks, and their colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.draw.closed_hands import closed_hands
from workbench.errors import InputError, UsageError, one_of
from workbench.model.arrays import Floats, Ints
from workbench.model.environment import Environment
from workbench.model.poses import Placed

__all__ = [
    "FAMILIES",
    "GLASS",
    "INK",
    "INKS",
    "MARKS",
    "PAPER",
    "SECTION",
    "Colour",
    "Mark",
    "Scene",
    "SceneBody",
    "Spheres",
    "hexadecimal",
    "ramp",
    "shown_corners",
    "window_spheres",
]

Colour = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""

PAPER: Colour = (255, 255, 255)
INK: Colour = (52, 60, 72)
GLASS: Colour = (150, 190, 205)
SECTION: Colour = (176, 184, 194)

FAMILIES: dict[str, tuple[Colour, Colour]] = {
    "warm": ((140, 118, 103), (252, 238, 220)),
    "blue": ((98, 122, 158), (214, 231, 248)),
    "green": ((98, 130, 110), (216, 240, 218)),
    "rose": ((150, 104, 118), (250, 222, 228)),
    "grey": ((116, 116, 116), (238, 238, 238)),
}
"""Colour families: a ramp of one hue from far to near. Near is light: on a white page the dark
outline holds the form together, and what is far recedes."""

INKS: dict[str, Colour] = {
    "warm": (66, 48, 36),
    "blue": (20, 58, 122),
    "green": (24, 86, 50),
    "rose": (130, 34, 66),
    "grey": (40, 40, 40),
}
"""The same hues for thin lines."""

MARKS: dict[str, Colour] = {
    "contact": (212, 32, 38),
    "allowed": (206, 128, 0),
    "clearance": (20, 96, 190),
    "point": (30, 130, 70),
    "reach": (0, 122, 128),
    "missed": (176, 24, 92),
    "stop": (122, 44, 168),
    "segment": (70, 78, 90),
    "axis_x": (200, 40, 40),
    "axis_y": (30, 130, 50),
    "axis_z": (30, 80, 200),
}
"""Colour of each kind of mark; `marks.layout` describes their shapes."""


def ramp(family: str, share: Floats) -> Floats:
    """Interpolate a colour family at shares (...,), 0 far to 1 near; colours (..., 3) of 0 to 255."""
    far, near = (np.array(colour, dtype=np.float64) for colour in FAMILIES[family])
    return far + (near - far) * np.asarray(share)[..., None]


def hexadecimal(colour: Floats | Colour) -> str:
    """Write a colour of 0 to 255 as '#rrggbb'."""
    red, green, blue = (round(float(value)) for value in colour)
    return f"#{red:02x}{green:02x}{blue:02x}"


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
