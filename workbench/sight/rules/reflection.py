"""Instruments mirrored in a windscreen: whether their virtual image lies in a view that must be
clear.

Each planar polygon of the windscreen is a flat mirror with its own outline, on both of its sides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats
from workbench.model.environment import Environment
from workbench.sight.eyes import Eyes
from workbench.sight.obscuration import Target
from workbench.sight.regions import Region, azimuth_elevation
from workbench.sight.rules.mirrors import (
    SEEN,
    Glass,
    looked_through,
    reflections,
    what_hides,
)
from workbench.sight.scenery import Scenery

__all__ = ["Reflection", "windscreen_reflection"]


@dataclass(frozen=True, eq=False)
class Reflection:
    """What two eyes see of a target in a windscreen, inside a region.

    seen (2, M): the points that the left and the right eye see mirrored. share: of the points, seen
    by one eye at least. middle (2,) [rad]: azimuth to the left and elevation of the mean direction,
    NaN where nothing is seen. parts: that mirror it.
    """

    seen: Bools
    share: float
    middle: Floats
    parts: tuple[str, ...]


def windscreen_reflection(
    scenery: Scenery,
    eyes: Eyes,
    target: Target,
    *,
    environment: Environment,
    windscreen: Sequence[str],
    region: Region,
    row: int = 0,
) -> Reflection:
    """Find the virtual image of a target in a windscreen.

    Parameters
    ----------
    scenery
        Of the environment: what may stand between eye, windscreen and target.
    eyes
        Of B people.
    target
        An instrument; where it has normals, it shines to their side.
    windscreen
        The parts that mirror.
    region
        The view that must be free of images, as `cockpit_outline`.
    row
        Who of them, and whose scenery.

    Raises
    ------
    InputError
        If a part has no such name.
    """
    parts = [environment.part_index(name) for name in windscreen]
    clear = looked_through(scenery.of_row(row), parts)
    seen = np.zeros((2, len(target.points)), dtype=np.bool_)
    ways = [np.zeros((0, 3))]
    mirroring = []
    for part in parts:
        for polygon in range(*environment.part_start[[part, part + 1]]):
            for side, eye in enumerate((eyes.left[row], eyes.right[row])):
                glass = _pane(environment, polygon, eye)
                places = reflections(glass, eye, target.points)
                images = region.contains(places - eye) & np.isfinite(places[:, 0])
                if target.normals is not None:
                    images &= np.einsum("ni,ni->n", places - target.points, target.normals) > 0.0
                if not images.any():
                    continue
                images &= what_hides(clear, eye, glass, target.points, own=target.item) == SEEN
                seen[side] |= images
                ways.append(places[images] - eye)
                mirroring += [environment.parts[part]] * bool(images.any())
    way = np.concatenate(ways)
    way = way / np.linalg.norm(way, axis=1)[:, None]
    mean = way.sum(axis=0) if len(way) else np.full(3, np.nan)
    middle = azimuth_elevation(mean, region.axes)
    return Reflection(seen, float(seen.any(axis=0).mean()), middle, tuple(dict.fromkeys(mirroring)))


def _pane(environment: Environment, polygon: int, eye: Floats) -> Glass:
    """A polygon as a flat mirror whose normal is on the side of an eye."""
    first, last = environment.triangle_start[[polygon, polygon + 1]]
    corners = environment.vertices[environment.triangles[first:last]]
    at = environment.circle_centre[polygon]
    normal = environment.normal[polygon] * np.sign((eye - at) @ environment.normal[polygon] or 1.0)
    return Glass("windscreen", at, normal, np.inf, corners)
