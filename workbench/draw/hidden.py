"""What a picture does not show: parts that stand before a point, and parts that a view cuts off."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from PIL import Image

from workbench.draw.camera import Camera, project, to_view
from workbench.draw.disks import disks
from workbench.draw.marks.pictures import paint_mark_shapes, paint_mark_texts
from workbench.draw.scene import Scene
from workbench.draw.visibility import (
    cut_depth,
    projected_disks,
    render_buffers,
    triangle_polygons,
)
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Bools, Floats
from workbench.model.environment import Environment

__all__ = ["cut_off_words", "seen_through", "shining_part"]

_AROUND = 0.06
"""How far [m] around a point nothing is to be before it."""
_BEFORE = 0.03
"""What is less [m] nearer than the point is what it is on."""
_SHARE = 0.25
"""A part that covers less of the surroundings of a point hides nothing."""
_ROUNDS = 4
"""Walls one behind the other that are looked through."""
_NAMED = 3
"""Parts that a sentence names."""


def seen_through(
    scene: Scene, camera: Camera, points: Sequence[Floats], *, kept: Iterable[str] = ()
) -> tuple[Scene, tuple[str, ...]]:
    """Make the parts see-through that hide points from a camera.

    Parameters
    ----------
    scene, camera
        What is seen, and from where.
    points
        (3,) [m] each.
    kept
        Parts that stay as they are: those that the points are about.

    Returns
    -------
    tuple[Scene, tuple[str, ...]]
        The scene, and the parts; nothing changes in a perspective view.
    """
    environment = scene.environment
    if environment is None or not points or np.isfinite(camera.distance):
        return scene, ()
    stay = np.isin(environment.parts, list(kept))
    found: list[str] = []
    for _ in range(_ROUNDS):
        shown = replace(scene, environment=environment)
        before = _before(shown, camera, points) & ~stay & ~environment.see_through
        if not before.any():
            return shown, tuple(found)
        found += [environment.parts[k] for k in np.flatnonzero(before).tolist()]
        environment = replace(environment, see_through=environment.see_through | before)
    return replace(scene, environment=environment), tuple(found)


def _before(scene: Scene, camera: Camera, points: Sequence[Floats]) -> Bools:
    """(K,) whether each part of the environment hides the surroundings of a point."""
    environment = scene.environment
    assert environment is not None
    buffers = render_buffers(scene, camera)
    polygon = triangle_polygons(environment)
    hides = np.zeros(len(environment.parts), dtype=np.bool_)
    for point in points:
        x, y, depth = project(camera, point[None])[0]
        reach = max(round(_AROUND * camera.scale), 1)
        rows = slice(max(round(y) - reach, 0), max(round(y) + reach + 1, 0))
        columns = slice(max(round(x) - reach, 0), max(round(x) + reach + 1, 0))
        window = buffers.triangle[rows, columns]
        nearer = (window >= 0) & (buffers.depth[rows, columns] > depth + _BEFORE)
        number = window[nearer]
        if window.size:
            covered = np.bincount(
                environment.polygon_part[polygon[number]], minlength=len(environment.parts)
            )
            hides |= covered > _SHARE * window.size
    return hides


def cut_off_words(scene: Scene, camera: Camera) -> list[str]:
    """Return which parts of the environment lie outside a picture of people, or are cut away before
    them, in words; nothing where it shows all."""
    environment = scene.environment
    if environment is None or not scene.bodies:
        return []
    cut = cut_depth(projected_disks(scene, camera), camera)
    outside: list[str] = []
    beyond = 0
    away: list[str] = []
    for k, name in enumerate(environment.parts):
        if environment.hidden[k]:
            continue
        corners = environment.triangle_corners(k).reshape(-1, 3)
        if not len(corners):  # a section has left nothing of it
            continue
        seen = project(camera, corners)[:, :2]
        low, high = seen.min(axis=0), seen.max(axis=0)
        size = (camera.width, camera.height)
        if (high < 0.0).any() or (low > size).any():
            outside.append(name)
        elif (low < 0.0).any() or (high > size).any():
            beyond += 1
        if to_view(camera, corners)[:, 2].min() > cut:
            away.append(name)
    words = []
    if outside:
        words.append(f"outside the picture, which is as large as the people: {_some(outside)}")
    if beyond:
        many = f"{beyond} parts reach" if beyond > 1 else "1 part reaches"
        words.append(f"{many} beyond the picture: the environment by itself shows all of it")
    if away:
        words.append(f"cut away before the people: {_some(away)}")
    return words


def _some(names: Sequence[str]) -> str:
    more = len(names) - _NAMED
    return ", ".join(names[:_NAMED]) + (f" and {more} more" if more > 0 else "")


_OPACITY = 0.5
"""Opacity of the part over what hides it."""
_COLOUR = np.array([240.0, 120.0, 90.0])


def shining_part(scene: Scene, camera: Camera, part: str) -> Image.Image:
    """Draw a scene in light and shade, with one part shining through all that is before it.

    Raises
    ------
    UsageError
        If the scene has no such part.
    """
    environment = scene.environment
    names = () if environment is None else environment.parts
    if environment is None or part not in names:
        raise UsageError(f"no part {part!r} in the scene; {one_of(part, names)}")
    whole = disks(replace(scene, marks=()), camera, mode="shaded")
    others = np.array([name != part for name in names])
    lit = _drawn(replace(environment, hidden=others), camera)
    bare = _drawn(replace(environment, hidden=np.ones_like(others)), camera)
    here = np.abs(lit - bare).max(axis=2) > 0.0
    shade = 0.4 + 0.6 * lit[here].mean(axis=1, keepdims=True) / 255.0
    picture = np.asarray(whole, dtype=np.float64).copy()
    picture[here] += _OPACITY * (shade * _COLOUR - picture[here])
    image = Image.fromarray(np.round(picture).astype(np.uint8))
    paint_mark_shapes(image, scene, camera, 1)
    paint_mark_texts(image, scene, camera)
    return image


def _drawn(environment: Environment, camera: Camera) -> Floats:
    """(height, width, 3) of the environment alone."""
    return np.asarray(disks(Scene((), environment), camera, mode="shaded"), dtype=np.float64)
