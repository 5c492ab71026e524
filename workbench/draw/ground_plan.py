"""Plan the ground around a pair of eyes: what of it they see, and what hides the rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.draw.chart import FINER, Chart, Stroke, Words
from workbench.draw.directions import Outlook
from workbench.draw.scene import INK
from workbench.draw.sheet import LETTER, Sheet
from workbench.draw.zones import Items, spread, zones
from workbench.errors import UsageError
from workbench.model.arrays import Bools, Floats
from workbench.model.environment import Environment
from workbench.sight.obscuration import lines_of_sight
from workbench.sight.panorama import Panorama

__all__ = ["blind_distances", "ground_level", "ground_plan"]

_SIZES = (5.0, 10.0, 20.0, 40.0, 80.0)
"""Radii [m] of plans."""
_STEP = math.radians(0.1)
"""Width [rad] of what is looked at in one piece: 0.7 m of ground 20 m away, 1 m below the eyes."""
_ROOM = 1.5
"""Least radius as a multiple of the distance at which the ground comes into sight to most sides."""
_SIDES = 360
"""Number of sides to which the near blind zone is measured."""
_LABELLED = 8
"""Number of sides at which its distance is written."""
_NEAREST = 0.3
"""Distance [m] at which the search for ground in sight begins."""
_STEPS = 400
"""Distances at which the ground is looked for, from the nearest to the radius of the largest plan."""
_LYING = 0.01
"""Height [m] over the ground up to which a part is the ground's own surface."""
_HATCH = 9
"""Distance [fine pixels] between the lines of the hatch."""
_DARKER = 0.72
"""Share of the colour that is left in a line of the hatch."""


def ground_level(environment: Environment) -> float:
    """The height z [m] of the ground: of the point "ground", or the lowest point of all parts."""
    named = environment.points.get("ground")
    return float(environment.bounds[0, 2]) if named is None else named[2]


def ground_plan(outlook: Outlook, ground: float, *, width: int, height: int) -> Chart:
    """Draw the ground about two eyes in plan, straight ahead up.

    Each point of the ground has the colour of what hides it to both eyes, paler where it hides it to
    one. The near blind zone is hatched: from below the eyes to where the ground first comes into
    sight of one eye.

    Parameters
    ----------
    outlook
        Whose view.
    ground
        Height z [m] of the ground.
    width, height
        Size of the picture [pixels].

    Raises
    ------
    UsageError
        If the ground is not below the eyes.
    """
    level = float(outlook.eyes.middle[0, 2]) - ground
    if not level > 0.0:
        raise UsageError(f"the ground at {ground:g} m is not below the eyes; say its height")
    eyes = outlook.look(_STEP)
    near = blind_distances(outlook, eyes, ground)
    radius = _radius(near)
    sheet = Sheet(width, height, (radius, radius))
    places = sheet.places()
    far = np.linalg.norm(places, axis=-1)
    inside = far <= radius
    items = [spread(_hidden(outlook, eye, places[inside], ground), inside) for eye in eyes]
    both = (items[0] >= 0) & (items[1] >= 0)
    sums = []
    for chosen in (both, both ^ ((items[0] >= 0) | (items[1] >= 0))):
        item = np.where(items[0] >= 0, items[0], items[1])[chosen & inside]
        sums.append(np.bincount(item, minlength=len(outlook.zones)) / (FINER * sheet.scale) ** 2)
    clear = float(np.sum(inside & (items[0] < 0) & (items[1] < 0))) / (FINER * sheet.scale) ** 2
    found = zones(outlook.zones, sums[0], sums[1], clear)
    side = np.floor(np.arctan2(-places[..., 0], places[..., 1]) * (_SIDES / math.tau)).astype(int)
    painted = found.paint(items[0], items[1], np.zeros_like(items[0]))
    row, column = np.indices(inside.shape)
    hatched = both & (far < near[side % _SIDES]) & ((row + column) % _HATCH == 0)
    painted[hatched] = np.round(_DARKER * painted[hatched])
    colours, words = sheet.coloured(found, inside, painted, unit="m2", places=1)
    strokes, labels = _grid(sheet, radius, near)
    title = f"Ground seen from {outlook.name}, {level:.2f} m above it"
    caption = (
        "cross: the eyes, ahead is up; pale: hidden to one eye; hatched: to both, around the eyes"
    )
    return Chart(title, caption, colours, strokes, [*sheet.words(title, caption), *labels, *words])


def _hidden(outlook: Outlook, eye: Panorama, places: Floats, ground: float) -> Items:
    """(...) what hides points (..., 2) of the ground, to the right of the eyes and ahead of them, from
    an eye, -1 for nothing."""
    middle = outlook.eyes.middle[0]
    offset = np.array([0.0, 0.0, ground - middle[2]]) + (middle - eye.eye)
    way = places[..., 1:] * outlook.axes[0] - places[..., :1] * outlook.axes[1] + offset
    item = eye.look(way)
    unsure = _borders(eye).look(way) > 0
    found = lines_of_sight(outlook.scenery, eye.eye[None], eye.eye + way[unsure][None])[0]
    item[unsure] = found
    lies = np.append(_is_ground(outlook, ground), True)
    return np.where(lies[item], np.int32(-1), item)


def _borders(eye: Panorama) -> Panorama:
    """The same pixels, 1 where one beside or above holds another item: far ground is so flat before
    the eyes that such a pixel is metres long, so what is in it is looked at exactly."""
    near = np.pad(eye.item, ((0, 0), (1, 1), (1, 1)), constant_values=-2)
    middle = near[:, 1:-1, 1:-1]
    beside = (near[:, 1:-1, :-2], near[:, 1:-1, 2:], near[:, :-2, 1:-1], near[:, 2:, 1:-1])
    differs = np.any([middle != other for other in beside], axis=0)
    return replace(eye, item=differs.astype(np.int32))


def _is_ground(outlook: Outlook, ground: float) -> Bools:
    """(N,) which items lie on the ground, as a road does."""
    scenery = outlook.scenery
    top = np.full(len(scenery.names), -np.inf)
    np.maximum.at(top, scenery.item, scenery.triangles[:, :, 2].max(axis=1))
    return np.isfinite(top) & (top <= ground + _LYING)


def blind_distances(outlook: Outlook, eyes: tuple[Panorama, Panorama], ground: float) -> Floats:
    """Measure how far from below the eyes the ground first comes into sight of one of them, beyond
    the box around all parts: what is seen of it between parts does not count.

    Parameters
    ----------
    outlook, eyes
        Whose view, and what either eye sees.
    ground
        Height z [m] of the ground.

    Returns
    -------
    Floats
        (360,) [m] by azimuth, to the left from straight ahead; infinite where it does not come into
        sight within 80 m.
    """
    azimuth = (np.arange(_SIDES) + 0.5) * (math.tau / _SIDES)
    distance = np.geomspace(_NEAREST, _SIZES[-1], _STEPS)
    way = np.stack([-np.sin(azimuth), np.cos(azimuth)], axis=-1)
    places = distance[None, :, None] * way[:, None]
    seen = np.zeros((_SIDES, _STEPS), dtype=np.bool_)
    for eye in eyes:
        seen |= _hidden(outlook, eye, places, ground) < 0
    seen &= distance >= _leaving(outlook, ground, way)[:, None]
    return np.where(seen.any(axis=1), distance[np.argmax(seen, axis=1)], np.inf)


def _leaving(outlook: Outlook, ground: float, way: Floats) -> Floats:
    """(K,) [m] how far level lines from the eyes, of directions (K, 2) to the right and ahead, run
    over the parts that stand on the ground, by the box around them all."""
    scenery = outlook.scenery
    standing = ~_is_ground(outlook, ground)[scenery.item]
    if not standing.any():
        return np.zeros(len(way))
    middle = outlook.eyes.middle[0, :2]
    corners = scenery.triangles[standing][:, :, :2].reshape(-1, 2) - middle
    world = way[:, 1:] * outlook.axes[0, :2] - way[:, :1] * outlook.axes[1, :2]
    with np.errstate(divide="ignore"):
        ends = np.where(world > 0.0, corners.max(axis=0), corners.min(axis=0)) / world
    return np.maximum(ends.min(axis=1), 0.0)


def _radius(near: Floats) -> float:
    """The radius [m] of a plan that shows the near blind zone to most sides."""
    known = near[np.isfinite(near)]
    wanted = _ROOM * float(np.quantile(known, 0.8)) if len(known) else _SIZES[-1]
    return next((size for size in _SIZES if size >= wanted), _SIZES[-1])


def _grid(sheet: Sheet, radius: float, near: Floats) -> tuple[list[Stroke], list[Words]]:
    """Rings about the eyes with their distances, and the end of the near blind zone in figures."""
    turn = np.linspace(0.0, math.tau, 181)
    circle = np.stack([np.sin(turn), np.cos(turn)], axis=1)
    rings = radius * np.array([0.2, 0.4, 0.6, 0.8, 1.0])
    strokes = [sheet.line(ring * circle) for ring in rings]
    strokes.append(sheet.line(radius * circle, INK, 1.2))
    cross = 0.02 * radius * np.array([[-1.0, 0.0], [1.0, 0.0], [np.nan, np.nan], [0, -1], [0, 1]])
    strokes += sheet.emphasised(cross)
    labels: list[Words] = []
    for side in range(0, _SIDES, _SIDES // _LABELLED):
        distance = float(near[side])
        if distance < radius:
            azimuth = side * (math.tau / _SIDES)
            way = np.array([-math.sin(azimuth), math.cos(azimuth)])
            label = _clear_label(sheet, distance, way, f"{distance:.1f} m", labels)
            strokes.append(Stroke(np.stack([sheet.pixels(distance * way), np.array(label.at)])))
            labels.append(label._replace(colour=INK))
    # ring labels go to the upper right, between the sides that are labelled
    slant = np.array([math.sin(0.4), math.cos(0.4)])
    for ring in rings[:-1]:
        labels.append(_clear_label(sheet, ring, slant, f"{ring:g} m", labels))
    return strokes, labels


def _clear_label(
    sheet: Sheet, distance: float, way: Floats, text: str, others: Sequence[Words]
) -> Words:
    """A label at a distance along a direction (2,), or as much farther out as others need room."""
    label = sheet.label(distance * way, text)
    while any(_overlap(label, other) for other in others):
        distance += 0.5 * label.size / sheet.scale
        label = sheet.label(distance * way, text)
    return label


def _overlap(one: Words, other: Words) -> bool:
    """Whether two labels stand on one another."""
    apart = np.abs(np.subtract(one.at, other.at))
    wide = 0.5 * LETTER * one.size * (len(one.text) + len(other.text) + 1)
    return bool(apart[0] < wide and apart[1] < 1.2 * one.size)
