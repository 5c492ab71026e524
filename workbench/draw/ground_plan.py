"""Plan the ground around a pair of eyes: what of it they see, and what hides the rest; and the ground
that they see in mirrors, with the ground that a rule asks for."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.draw.chart import FINER, Chart, Stroke, Words
from workbench.draw.directions import Outlook
from workbench.draw.scene import INK, Colour
from workbench.draw.sheet import GRID, LETTER, Sheet
from workbench.draw.zones import Items, Zones, spread, zones
from workbench.errors import UsageError
from workbench.geometry.polygon import inside_loops
from workbench.model.arrays import Bools, Floats
from workbench.model.environment import Environment, Mirror
from workbench.model.units import plain
from workbench.sight.obscuration import lines_of_sight
from workbench.sight.panorama import Panorama
from workbench.sight.rules.mirrors import glass_of, ground_points, mirror_field

__all__ = [
    "blind_distances",
    "ground_level",
    "ground_plan",
    "mirror_plan",
]

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


_AHEAD = 6.0
"""How far [m] ahead of the eyes a plan goes."""
_BEHIND = 40.0, 80.0
"""How far [m] behind them: where no ground is asked for, and at most."""
_ASIDE = 12.0
"""How far [m] to each side at least."""
_SQUARES = 300
"""Squares from the front to the rear, of each of which the middle is looked at."""
_ASKED = 900
"""Points of the ground that is asked for: its share is known to about 1 %."""
_GAP = 3.0
"""Room [m] between the plans of mirrors that stand side by side."""
_LINE = 1.5
"""Height of a line of the legend as a multiple of its letters."""
_BOX = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])
_CAPTION = "cross: the eyes, ahead is up; pale: seen by one eye; box: all that stands on the ground"
_MIRROR_HATCH = 14
"""Distance [fine pixels] between the lines of the hatch over the ground that is asked for."""
_MIRROR_DARKER = 0.78
"""Share of the colour that is left in such a line."""


def mirror_plan(
    outlook: Outlook,
    environment: Environment,
    ground: float,
    *,
    required: Mapping[str, Floats],
    source: str = "",
    width: int,
    height: int,
) -> Chart:
    """Draw the ground that eyes see in the mirrors of an environment, straight ahead up: a plan for
    each mirror, side by side.

    A square of the ground has the colour of its mirror where both eyes see its middle, a paler one
    where one does. Ground that is asked for is outlined, hatched and named.

    Parameters
    ----------
    outlook, environment
        Whose view, and the mirrors.
    ground
        Height z [m] of the ground.
    required
        The ground that is asked for in mirrors, by their names: corners (K, 3) [m]; all mirrors of the
        environment are drawn.
    source
        The rule that asks for it, "" for none.
    width, height
        Size of the picture [pixels].

    Raises
    ------
    UsageError
        If there is no mirror.
    """
    mirrors = environment.mirrors
    if not mirrors:
        raise UsageError(f"environment {environment.name} has no mirrors; name them in its file")
    asked = {name: _in_plan(outlook, corners) for name, corners in required.items()}
    plans = _plans(asked, len(mirrors), width, height)
    points = _in_world(outlook, plans.squares, ground)
    seen = [_seen(outlook, environment, mirror, points) for mirror in mirrors]
    both = np.array([one.all(axis=0).sum() for one in seen])
    found = zones([mirror.name for mirror in mirrors], both, np.zeros(len(mirrors)), 0.0)
    panels = [_panel(plans, k, mirror, asked.get(mirror.name)) for k, mirror in enumerate(mirrors)]
    strokes = [stroke for panel in panels for stroke in panel.strokes]
    strokes += [
        stroke for k in range(len(mirrors)) for stroke in _vehicle(plans, k, outlook, ground)
    ]
    colours = _coloured(plans, found, seen, [asked.get(mirror.name) for mirror in mirrors])
    words = [label for panel in panels for label in panel.words]
    size = plans.sheet.letters
    for k, mirror in enumerate(mirrors):
        text = _told(outlook, environment, mirror, required.get(mirror.name))
        line = plans.bottom + (1.5 + k * _LINE) * size
        _patch(colours, (size, line - 0.5 * size), size, found.rows[found.row[k]].colour)
        room = (width - 5.0 * size) / (0.55 * len(text))
        words.append(Words((3.2 * size, line), text, min(0.9 * size, room)))
    rule = f"outlined and hatched, to {_BEHIND[1]:g} m behind at most: asked for by {source}"
    lines = [f"Ground seen in mirrors from {outlook.name}", _CAPTION, *([rule] if required else [])]
    words += plans.sheet.words(*lines)
    return Chart(lines[0], "; ".join(lines[1:]), colours, strokes, words)


@dataclass(frozen=True, eq=False)
class _Plans:
    """Plans of the ground side by side, one a mirror, each of squares of equal size.

    half: (2,) [m] how far each goes to the right and up from its middle; centre: (2,) [m] where that
    is, to the right of the eyes and ahead. count: of plans.
    """

    sheet: Sheet
    half: Floats
    centre: Floats
    count: int

    @property
    def square(self) -> float:
        """[m] the side of a square."""
        return float(2.0 * self.half[1]) / _SQUARES

    @property
    def number(self) -> tuple[int, int]:
        """Squares to the right, and up."""
        across, along = np.ceil(2.0 * self.half / self.square).astype(int).tolist()
        return across, along

    @property
    def squares(self) -> Floats:
        """(N, 2) [m] the middles of the squares, those at the rear first, from the left."""
        right, ahead = (np.arange(count) + 0.5 for count in self.number)
        grid = np.stack(np.meshgrid(right, ahead), axis=-1).reshape(-1, 2)
        return np.asarray(self.centre - self.half + grid * self.square)

    @property
    def bottom(self) -> float:
        """The end of the plans [pixels]."""
        return float(self.sheet.pixels(np.array([0.0, -self.half[1]]))[1])

    def middle(self, k: int) -> Floats:
        """(2,) [m] what of a plan is in the middle of the sheet."""
        pitch = 2.0 * self.half[0] + _GAP
        return np.asarray(self.centre - [(k - 0.5 * (self.count - 1)) * pitch, 0.0])


def _plans(asked: Mapping[str, Floats], count: int, width: int, height: int) -> _Plans:
    """Plans that hold the ground that is asked for."""
    every = np.concatenate([np.zeros((1, 2)), *asked.values()])
    behind = min(1.1 * float(-every[:, 1].min()), _BEHIND[1]) if asked else _BEHIND[0]
    aside = max(_ASIDE, 1.15 * float(np.abs(every[:, 0]).max()))
    half = np.array([aside, 0.5 * (_AHEAD + behind)])
    sheet = Sheet(width, height, (0.5 * count * (2.0 * aside + _GAP), float(half[1])))
    return _Plans(sheet, half, np.array([0.0, 0.5 * (_AHEAD - behind)]), count)


def _coloured(
    plans: _Plans, found: Zones, seen: Sequence[Bools], asked: Sequence[Floats | None]
) -> NDArray[np.uint8]:
    """The colours of the picture: of each mirror where it shows the ground (2, N), hatched where
    that is asked for."""
    places = plans.sheet.places()
    shown = np.zeros(places.shape[:2], dtype=np.bool_)
    items = np.full((2, *shown.shape), -1, dtype=np.int32)
    hatched = np.zeros_like(shown)
    hatch = np.add(*np.indices(shown.shape)) % _MIRROR_HATCH == 0
    for k, (one, corners) in enumerate(zip(seen, asked, strict=True)):
        plan = places + plans.middle(k)
        at = np.floor((plan - plans.centre + plans.half) / plans.square).astype(int)
        inside = np.all((at >= 0) & (at < plans.number), axis=-1)
        column, row = at[inside].T
        items[:, inside] = np.where(one[:, row * plans.number[0] + column], k, -1)
        shown |= inside
        if corners is not None:
            within = inside_loops(plan[inside & hatch], [corners])
            hatched[inside & hatch] = within
    painted = found.paint(items[0], items[1], np.zeros_like(items[0]))
    painted[hatched] = np.round(_MIRROR_DARKER * painted[hatched])
    return np.where(shown[..., None], painted, np.uint8(255))


class _Panel(NamedTuple):
    """Lines and words over a plan."""

    strokes: list[Stroke]
    words: list[Words]


def _panel(plans: _Plans, k: int, mirror: Mirror, asked: Floats | None) -> _Panel:
    """The name of a mirror, level lines every 10 m behind the eyes, the border, the eyes, and the
    ground (K, 2) [m] that is asked for."""
    sheet, half, centre = plans.sheet, plans.half, plans.centre
    middle = plans.middle(k)
    words = [sheet.label(np.array([0.0, 0.8 * _AHEAD]) - middle, plain(mirror.name))]
    strokes = []
    for far in np.arange(10.0, half[1] - centre[1], 10.0).tolist():
        line = np.array([[-half[0], -far], [half[0], -far]])
        strokes.append(sheet.line(line - middle))
        words.append(sheet.label(line[0] * [0.8, 1.0] - middle, f"{far:g} m"))
    strokes.append(sheet.line(_BOX * half + centre - middle, INK, 1.2))
    cross = np.array([[-1.0, 0.0], [1.0, 0.0], [np.nan, np.nan], [0.0, -1.0], [0.0, 1.0]])
    strokes += sheet.emphasised(cross - middle)
    if asked is not None:
        drawn = np.clip(asked, centre - half, centre + half)
        strokes += sheet.emphasised(np.vstack([drawn, drawn[:1]]) - middle)
        words.append(sheet.label(drawn.mean(axis=0) - middle, f"class {mirror.field}"))
    return _Panel(strokes, [one._replace(colour=INK) for one in words])


def _in_plan(outlook: Outlook, points: Floats) -> Floats:
    """(..., 2) [m] to the right of the eyes and ahead of them, of points (..., 3) in the world."""
    away = points - outlook.eyes.middle[0]
    return np.stack([-away @ outlook.axes[1], away @ outlook.axes[0]], axis=-1)


def _in_world(outlook: Outlook, places: Floats, ground: float) -> Floats:
    """(N, 3) [m] the points of the ground at places (N, 2) of a plan."""
    points = outlook.eyes.middle[0] + np.stack([-places[:, 0], places[:, 1]], axis=1) @ np.stack(
        [outlook.axes[1], outlook.axes[0]]
    )
    points[:, 2] = ground
    return np.asarray(points)


def _seen(outlook: Outlook, environment: Environment, mirror: Mirror, points: Floats) -> Bools:
    """(2, N) which points the left and the right eye see in a mirror."""
    glass = glass_of(environment, mirror, eye=outlook.eyes.middle[0])
    part = environment.part_index(mirror.part)
    return mirror_field(outlook.scenery, outlook.eyes, glass, points, item=part).seen


def _told(outlook: Outlook, environment: Environment, mirror: Mirror, asked: Floats | None) -> str:
    """ "left mirror, convex 1260 mm: 93 % of the ground of class III is seen by one eye at least, 88 %
    by both"."""
    shape = "flat" if math.isinf(mirror.radius) else f"convex {1000 * mirror.radius:.0f} mm"
    lead = f"{plain(mirror.name)}, {shape}"
    if asked is None:
        return lead
    seen = _seen(outlook, environment, mirror, ground_points(asked, count=_ASKED))
    either, both = 100 * seen.any(axis=0).mean(), 100 * seen.all(axis=0).mean()
    return (
        f"{lead}: {either:.0f} % of the ground of class {mirror.field} is seen by one eye at least, "
        f"{both:.0f} % by both"
    )


def _vehicle(plans: _Plans, k: int, outlook: Outlook, ground: float) -> list[Stroke]:
    """The box around all parts that stand on the ground."""
    corners = outlook.scenery.triangles
    standing = corners[corners[:, :, 2].max(axis=1) > ground + _LYING].reshape(-1, 3)
    if not len(standing):
        return []
    places = _in_plan(outlook, standing)
    low, high = places.min(axis=0), places.max(axis=0)
    box = (low + high) / 2.0 + _BOX * (high - low) / 2.0
    return [plans.sheet.line(box - plans.middle(k), GRID, 1.5)]


def _patch(
    colours: NDArray[np.uint8], corner: tuple[float, float], size: float, colour: Colour
) -> None:
    """Paint a patch of the legend."""
    x, y = (round(FINER * value) for value in corner)
    colours[y : y + round(FINER * size), x : x + round(FINER * 1.7 * size)] = colour
