"""Instruments mirrored in a windscreen: whether their virtual image lies in a view that must be
clear.

Each triangle of the windscreen is a flat mirror with its own outline, on both of its sides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from workbench.model.arrays import Bools, Floats
from workbench.model.environment import Environment
from workbench.sight.eyes import Eyes
from workbench.sight.obscuration import Target
from workbench.sight.regions import Region, azimuth_elevation
from workbench.sight.rules.mirrors import SEEN, looked_through, what_hides
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
    panes = [environment.triangle_corners(part) for part in parts]
    part_of = np.repeat(parts, [len(pane) for pane in panes])
    corners = np.concatenate(panes)
    clear = looked_through(scenery.of_row(row), parts)
    seen = np.zeros((2, len(target.points)), dtype=np.bool_)
    ways = [np.zeros((0, 3))]
    mirroring: dict[int, None] = {}
    for side, eye in enumerate((eyes.left[row], eyes.right[row])):
        places = _reflected_by(corners.tobytes(), eye.tobytes(), target.points.tobytes())
        images = np.isfinite(places[..., 0]) & region.contains(places - eye)
        if target.normals is not None:
            images &= np.einsum("tmi,mi->tm", places - target.points, target.normals) > 0.0
        pane, point = np.nonzero(images)
        place = places[pane, point]
        free = what_hides(clear, eye, place, target.points[point], own=target.item) == SEEN
        seen[side, point[free]] = True
        ways.append(place[free] - eye)
        mirroring |= dict.fromkeys(part_of[pane[free]].tolist())
    way = np.concatenate(ways)
    way = way / np.linalg.norm(way, axis=1)[:, None]
    mean = way.sum(axis=0) if len(way) else np.full(3, np.nan)
    return Reflection(
        seen,
        float(seen.any(axis=0).mean()),
        azimuth_elevation(mean, region.axes),
        tuple(environment.parts[part] for part in mirroring),
    )


@lru_cache(maxsize=32)
def _reflected_by(*arrays: bytes) -> Floats:
    """(T, M, 3) [m] where flat triangles (T, 3, 3) mirror points (M, 3) to an eye (3,), NaN where
    they do not, or the point is on their other side.

    arrays: of triangles, eye and points; while something else is dragged, all three stay.
    """
    given, eye, points = (np.frombuffer(one).reshape(-1, 3) for one in arrays)
    corners = given.reshape(-1, 3, 3)
    sides = np.roll(corners, -1, axis=1) - corners
    normal = np.cross(sides[:, 0], sides[:, 1])
    length = np.linalg.norm(normal, axis=1)
    normal /= np.where(length > 0.0, length, 1.0)[:, None]
    offset = np.einsum("ti,ti->t", normal, corners[:, 0])
    of_eye = (normal @ eye[0] - offset)[:, None]
    of_point = normal @ points.T - offset[:, None]
    # the line from the eye to the virtual image crosses the plane at this share of its way
    same_side = of_eye * of_point > 0.0
    share = np.where(same_side, of_eye / np.where(same_side, of_eye + of_point, 1.0), np.nan)
    image = points - 2.0 * of_point[..., None] * normal[:, None]
    place = eye + share[..., None] * (image - eye)
    inward = np.cross(normal[:, None], sides)
    height = np.einsum("tki,tmki->tmk", inward, place[:, :, None] - corners[:, None])
    return np.where((height >= 0.0).all(axis=2)[..., None], place, np.nan)
