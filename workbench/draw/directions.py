"""Plot all directions from a pair of eyes on a plane, so that equal areas are equal solid angles.

The picture is as who looks out sees it: what is to the left, where azimuth is positive, is drawn to
the left.

References
----------
.. [1] J. P. Snyder (1987), Map projections: a working manual, USGS professional paper 1395, page 185:
   Lambert's azimuthal equal-area projection; Hammer's is that of half the azimuth, twice as wide.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.draw.chart import Chart, Stroke, Words
from workbench.draw.scene import INK
from workbench.draw.sheet import Sheet
from workbench.draw.zones import Zones, spread, zones
from workbench.model.arrays import Floats
from workbench.sight.eyes import Eyes
from workbench.sight.panorama import Panorama, face_directions, panorama
from workbench.sight.regions import Region, azimuth_elevation, direction_of
from workbench.sight.scenery import Scenery

__all__ = ["PROJECTIONS", "Outlook", "Projection", "direction_chart", "hidden_zones"]

_STEP = math.radians(0.2)
"""Width [rad] of what is looked at in one piece."""
_GRID = math.radians(30.0)
"""Distance [rad] between the lines of the grid."""
_FINE = 181
"""Number of points of a line."""
_SEAM = math.radians(179.999)
"""Azimuth [rad] at which the plane is cut behind the viewer."""
_FRONT = math.radians(125.0)
"""How far [rad] from straight ahead the polar plot goes."""


class Projection(NamedTuple):
    """An equal-area map of the directions to a plane, in radians where it is true to scale."""

    half: tuple[float, float]
    """How far the plane goes to the right and up."""
    off: float
    """How far [rad] from straight ahead directions are shown."""
    flat: Callable[[Floats], Floats]
    """Points (..., 2) to the right and up of azimuth and elevation (..., 2) [rad]; NaN where they
    are not shown."""
    angles: Callable[[Floats], Floats]
    """Azimuth and elevation (..., 2) [rad] of points (..., 2), NaN beyond the border."""


def _azimuthal(directions: Floats) -> Floats:
    """Lambert's projection about straight ahead, r = 2 sin(off / 2), of directions (..., 3)."""
    ahead, left, up = np.moveaxis(directions, -1, 0)
    k = np.sqrt(2.0 / np.maximum(1.0 + ahead, 1e-12))
    return np.stack([-k * left, k * up], axis=-1)


def _from_azimuthal(points: Floats) -> Floats:
    x, y = np.moveaxis(points, -1, 0)
    square = x * x + y * y
    k = np.sqrt(np.maximum(1.0 - square / 4.0, 0.0))
    return np.stack([1.0 - square / 2.0, -k * x, k * y], axis=-1)


def _from_hammer(points: Floats) -> Floats:
    halved = points * [0.5, 1.0]
    inside = np.linalg.norm(halved, axis=-1, keepdims=True) <= math.sqrt(2.0)
    angles = azimuth_elevation(_from_azimuthal(halved)) * [2.0, 1.0]
    return np.where(inside, angles, np.nan)


def _polar(angles: Floats) -> Floats:
    points = _azimuthal(direction_of(angles[..., 0], angles[..., 1]))
    inside = np.linalg.norm(points, axis=-1, keepdims=True) <= _POLAR_RADIUS * (1.0 + 1e-9)
    return np.where(inside, points, np.nan)


def _from_polar(points: Floats) -> Floats:
    inside = np.linalg.norm(points, axis=-1, keepdims=True) <= _POLAR_RADIUS
    return np.where(inside, azimuth_elevation(_from_azimuthal(points)), np.nan)


_POLAR_RADIUS = 2.0 * math.sin(_FRONT / 2.0)
_WIDE = math.sqrt(8.0)
PROJECTIONS: Mapping[str, Projection] = {
    "equal_area": Projection(
        (_WIDE, _WIDE / 2.0),
        math.pi,
        lambda angles: _azimuthal(direction_of(angles[..., 0] / 2.0, angles[..., 1])) * [2.0, 1.0],
        _from_hammer,
    ),
    "polar": Projection((_POLAR_RADIUS, _POLAR_RADIUS), _FRONT, _polar, _from_polar),
}
"""All directions on an ellipse (Hammer), and those up to 125 degrees from ahead on a disk (Lambert)."""


@dataclass(frozen=True, eq=False)
class Outlook:
    """What two eyes look out on.

    Parameters
    ----------
    name
        Whose eyes they are: "the eyes of the pilot".
    scenery
        What may hide, of N items.
    zones
        (N,) the zone that each item is drawn in: itself, or the whole body that it is of.
    eyes
        The eyes; the first row is drawn.
    axes
        (3, 3) ahead, left, up as rows: what plots are about.
    rule
        An outline that is drawn over, in which solid angles are measured; None for all that is
        shown.
    status
        Where the outline is from, and how sure that is.
    """

    name: str
    scenery: Scenery
    zones: tuple[str, ...]
    eyes: Eyes
    axes: Floats
    rule: Region | None = None
    status: str = ""

    def look(self, step: float = _STEP) -> tuple[Panorama, Panorama]:
        """Look in every direction with the left and the right eye, in pieces so wide [rad]."""
        left, right = (
            panorama(self.scenery, eye[0], step=step, axes=self.axes)
            for eye in (self.eyes.left, self.eyes.right)
        )
        return left, right


def hidden_zones(outlook: Outlook, left: Panorama, right: Panorama, within: Region) -> Zones:
    """Measure [sr] what is hidden of a region to both eyes, and to one only.

    Where different items hide a direction from the two eyes, each counts half. So all add up to the
    region.
    """
    count = len(outlook.zones)
    both, one = np.zeros(count + 1), np.zeros(count + 1)
    clear = 0.0
    for face, items in enumerate(zip(left.item, right.item, strict=True)):
        weight = left.weight * within.contains(face_directions(left.axes, face, len(items[0])))
        blocked = [item >= 0 for item in items]
        two = blocked[0] & blocked[1]
        clear += float(weight[~(blocked[0] | blocked[1])].sum())
        for item, hides in zip(items, blocked, strict=True):
            both += np.bincount(item[two], weight[two] / 2.0, count + 1)
            single = hides & ~two
            one += np.bincount(item[single], weight[single], count + 1)
    return zones(outlook.zones, both[:count], one[:count], clear)


def direction_chart(outlook: Outlook, style: str, *, width: int, height: int) -> Chart:
    """Plot what every direction shows: what hides it to both eyes or to one, and what is free.

    Parameters
    ----------
    outlook
        Whose view.
    style
        A key of `PROJECTIONS`.
    width, height
        Size of the picture [pixels].
    """
    projection = PROJECTIONS[style]
    sheet = Sheet(width, height, projection.half)
    left, right = outlook.look()
    region = outlook.rule or Region("shown", outlook.axes, projection.off)
    found = hidden_zones(outlook, left, right, region)
    angles = projection.angles(sheet.places())
    inside = np.isfinite(angles[..., 0])
    way = direction_of(*angles[inside].T) @ outlook.axes
    painted = found.paint(
        *(
            spread(items, inside)
            for items in (left.look(way), right.look(way), left.look_through(way))
        )
    )
    colours, words = sheet.coloured(found, inside, painted, unit="sr", places=3)
    strokes, labels = _grid(projection, sheet)
    if outlook.rule is not None:
        strokes += sheet.emphasised(projection.flat(_rule_line(outlook)))
    title = f"Seen in every direction from {outlook.name}"
    where = f"in {outlook.rule.name}" if outlook.rule else "of all that is shown"
    caption = f"pale: hidden to one eye; L, R: degrees to the left and right; solid angles {where}"
    return Chart(
        title,
        caption,
        colours,
        strokes,
        [*sheet.words(title, caption, outlook.status), *labels, *words],
    )


def _grid(projection: Projection, sheet: Sheet) -> tuple[list[Stroke], list[Words]]:
    """Lines of azimuth and elevation, 30 degrees apart, and the border; with labels."""
    side = np.linspace(-_SEAM, _SEAM, _FINE)
    above = np.linspace(-math.pi / 2.0, math.pi / 2.0, _FINE)
    azimuths = _GRID * np.arange(-5, 6)
    elevations = _GRID * np.arange(-2, 3)
    lines = [np.stack([np.full(_FINE, azimuth), above], axis=1) for azimuth in azimuths]
    lines += [np.stack([side, np.full(_FINE, elevation)], axis=1) for elevation in elevations]
    strokes = [sheet.line(projection.flat(line)) for line in lines]
    strokes.append(sheet.line(_border(projection), INK, 1.2))
    named = [(azimuth, 0.0) for azimuth in azimuths if azimuth]
    named += [(0.0, elevation) for elevation in elevations if elevation]
    points = projection.flat(np.array(named))
    if sheet.scale * _GRID < 4.0 * sheet.letters:
        return strokes, []
    labels = [
        sheet.label(point, f"{abs(math.degrees(turn + rise)):.0f}° {_side(turn, rise)}")
        for point, (turn, rise) in zip(points, named, strict=True)
        if np.isfinite(point).all()
    ]
    return strokes, labels


def _side(turn: float, rise: float) -> str:
    if turn:
        return "L" if turn > 0.0 else "R"
    return "up" if rise > 0.0 else "down"


def _border(projection: Projection) -> Floats:
    """(K, 2) the border of a map, an ellipse."""
    turn = np.linspace(0.0, math.tau, 2 * _FINE)
    return np.stack([np.cos(turn), np.sin(turn)], axis=1) * projection.half


def _rule_line(outlook: Outlook) -> Floats:
    """(K, 2) azimuth and elevation along the outline of the rule, about the axes of the plot."""
    rule = outlook.rule
    if rule is None:
        return np.empty((0, 2))
    if len(rule.corners):
        ends = np.concatenate([rule.corners, rule.corners[:1]])
        share = np.linspace(0.0, len(ends) - 1.0, _FINE * len(rule.corners))
        along = np.stack([np.interp(share, np.arange(len(ends)), ends[:, k]) for k in (0, 1)])
        way = direction_of(*along)
    else:
        turn = np.linspace(0.0, math.tau, 2 * _FINE)
        off = math.sin(rule.half_angle) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        way = np.column_stack([np.full(len(turn), math.cos(rule.half_angle)), off])
    return azimuth_elevation(way @ rule.axes, outlook.axes)
