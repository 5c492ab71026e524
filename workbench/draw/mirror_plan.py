"""Plan the ground that two eyes see in mirrors, with the ground that a rule asks for."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from workbench.draw.chart import FINER, Chart, Stroke, Words
from workbench.draw.colours import INK, Colour
from workbench.draw.directions import Outlook
from workbench.draw.sheet import GRID, Sheet
from workbench.draw.zones import Items, zones
from workbench.errors import UsageError
from workbench.model.arrays import Bools, Floats
from workbench.model.environment import Environment, Mirror
from workbench.model.figures import plain
from workbench.sight.rules.mirrors import Glass, glass_of, ground_points, mirror_field

__all__ = ["mirror_plan"]

_AHEAD = 6.0
"""How far [m] ahead of the eyes a plan goes."""
_BEHIND = 40.0, 80.0
"""How far [m] behind them: where no ground is asked for, and at most."""
_ASIDE = 12.0
"""How far [m] to each side at least."""
_CELLS = 300
"""Squares from the front to the rear, of each of which the middle is looked at."""
_ASKED = 900
"""Points of the ground that is asked for: its share is known to about 1 %."""
_GAP = 3.0
"""Room [m] between the plans of mirrors that stand side by side."""
_LINE = 1.5
"""Height of a line of the legend as a multiple of its letters."""
_HATCH = 14
"""Distance [fine pixels] between the lines of the hatch over the ground that is asked for."""
_DARKER = 0.78
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
    eye = outlook.eyes.middle[0]
    asked = {name: _in_plan(outlook, corners) for name, corners in required.items()}
    half, centre = _part_of_plan(asked)
    pitch = 2.0 * half[0] + _GAP
    sheet = Sheet(width, height, (0.5 * len(mirrors) * pitch, half[1]))
    cell = 2.0 * half[1] / _CELLS
    number = np.ceil(2.0 * half / cell).astype(int)
    right, ahead = (centre[k] - half[k] + (np.arange(number[k]) + 0.5) * cell for k in (0, 1))
    places = np.stack(np.meshgrid(right, ahead), axis=-1).reshape(-1, 2)
    points = _in_world(outlook, places, ground)
    every = [
        _seen(outlook, environment, mirror, glass_of(environment, mirror, eye=eye), points)
        for mirror in mirrors
    ]
    both = np.array([seen.all(axis=0).sum() for seen in every])
    found = zones([mirror.name for mirror in mirrors], both, np.zeros(len(mirrors)), 0.0)
    shown = np.zeros((FINER * height, FINER * width), dtype=np.bool_)
    items = np.full((2, *shown.shape), -1, dtype=np.int32)
    hatched = np.zeros_like(shown)
    strokes: list[Stroke] = []
    words: list[Words] = []
    y, x = np.indices(shown.shape)
    for k, (mirror, seen) in enumerate(zip(mirrors, every, strict=True)):
        middle = centre - [(k - 0.5 * (len(mirrors) - 1)) * pitch, 0.0]
        plan = sheet.places() + middle
        # each pixel has the colour of the square that it is in
        at = np.floor((plan - [right[0], ahead[0]]) / cell + 0.5).astype(int)
        inside = np.all((at >= 0) & (at < number), axis=-1)
        shown |= inside
        column, row = at[inside].T
        items[:, inside] = np.where(seen[:, row * number[0] + column], np.int32(k), np.int32(-1))
        corners = asked.get(mirror.name)
        strokes += _grid(sheet, half, centre, middle)
        strokes += _vehicle(sheet, middle, outlook, ground)
        if corners is not None:
            hatched |= inside & _inside(plan, corners) & ((x + y) % _HATCH == 0)
            ends = np.array([[-half[0], -half[1]], half]) + centre
            drawn = np.clip(corners, *ends)
            strokes += sheet.emphasised(np.vstack([drawn, drawn[:1]]) - middle)
            label = sheet.label(drawn.mean(axis=0) - middle, f"class {mirror.field}")
            words.append(label._replace(colour=INK))
        words += [
            sheet.label(np.array([centre[0] - 0.8 * half[0], -behind]) - middle, f"{behind:g} m")
            for behind in _distances(half, centre)
        ]
        top = sheet.label(np.array([0.0, 0.8 * _AHEAD]) - middle, plain(mirror.name))
        words.append(top._replace(colour=INK))
    painted = found.paint(items[0], items[1], np.zeros_like(items[0]))
    painted[hatched] = np.round(_DARKER * painted[hatched])
    colours = np.where(shown[..., None], painted, np.uint8(255))
    title = f"Ground seen in mirrors from {outlook.name}"
    caption = (
        "cross: the eyes, ahead is up; pale: seen by one eye; box: all that stands on the ground"
    )
    rule = f"outlined and hatched: asked for by {source}, to {_BEHIND[1]:g} m behind at most"
    size = sheet.letters
    top_line = float(sheet.pixels(np.array([0.0, -half[1]]))[1]) + 1.5 * size
    for k, mirror in enumerate(mirrors):
        text = _told(outlook, environment, mirror, required.get(mirror.name))
        line = top_line + k * _LINE * size
        _patch(colours, (size, line - 0.5 * size), size, found.rows[found.row[k]].colour)
        room = (width - 5.0 * size) / (0.55 * len(text))
        words.append(Words((3.2 * size, line), text, min(0.9 * size, room)))
    lines = (title, caption, rule) if required else (title, caption)
    return Chart(title, "; ".join(lines[1:]), colours, strokes, [*sheet.words(*lines), *words])


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


def _part_of_plan(asked: Mapping[str, Floats]) -> tuple[Floats, Floats]:
    """(2,) [m] how far to the right and up a plan goes from its middle, and (2,) where that is."""
    every = np.concatenate([np.zeros((1, 2)), *asked.values()])
    behind = min(1.1 * float(-every[:, 1].min()), _BEHIND[1]) if asked else _BEHIND[0]
    aside = max(_ASIDE, 1.15 * float(np.abs(every[:, 0]).max()))
    return np.array([aside, 0.5 * (_AHEAD + behind)]), np.array([0.0, 0.5 * (_AHEAD - behind)])


def _seen(
    outlook: Outlook, environment: Environment, mirror: Mirror, glass: Glass, points: Floats
) -> Bools:
    """(2, N) which points the left and the right eye see in a mirror."""
    part = environment.part_index(mirror.part)
    return mirror_field(outlook.scenery, outlook.eyes, glass, points, item=part).seen


def _told(outlook: Outlook, environment: Environment, mirror: Mirror, asked: Floats | None) -> str:
    """ "left mirror, convex 1260 mm: 93 % of the ground of class III is seen by one eye at least, 88 %
    by both"."""
    shape = "flat" if math.isinf(mirror.radius) else f"convex {1000 * mirror.radius:.0f} mm"
    lead = f"{plain(mirror.name)}, {shape}"
    if asked is None:
        return lead
    glass = glass_of(environment, mirror, eye=outlook.eyes.middle[0])
    seen = _seen(outlook, environment, mirror, glass, ground_points(asked, count=_ASKED))
    either, both = 100 * seen.any(axis=0).mean(), 100 * seen.all(axis=0).mean()
    return (
        f"{lead}: {either:.0f} % of the ground of class {mirror.field} is seen by one eye at least, "
        f"{both:.0f} % by both"
    )


def _inside(places: Floats, corners: Floats) -> Bools:
    """(H, W) which places (H, W, 2) are in a polygon (K, 2), by the crossings of a ray to the right."""
    found = np.zeros(places.shape[:2], dtype=np.bool_)
    x, y = places[..., 0], places[..., 1]
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if y0 != y1:
            crosses = (y0 > y) != (y1 > y)
            found ^= crosses & (x < x0 + (y - y0) * ((x1 - x0) / (y1 - y0)))
    return found


def _distances(half: Floats, centre: Floats) -> Floats:
    """Every 10 m [m] behind the eyes."""
    return np.arange(10.0, half[1] - centre[1], 10.0)


def _grid(sheet: Sheet, half: Floats, centre: Floats, middle: Floats) -> list[Stroke]:
    """Level lines every 10 m behind the eyes, the border of a plan, and the eyes."""
    ends = np.array([[-1.0, 0.0], [1.0, 0.0]]) * half + [centre[0], 0.0]
    strokes = [sheet.line(ends - [0.0, far] - middle) for far in _distances(half, centre)]
    border = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])
    strokes.append(sheet.line(border * half + centre - middle, INK, 1.2))
    cross = np.array([[-1.0, 0.0], [1.0, 0.0], [np.nan, np.nan], [0.0, -1.0], [0.0, 1.0]])
    return [*strokes, *sheet.emphasised(cross - middle)]


def _vehicle(sheet: Sheet, middle: Floats, outlook: Outlook, ground: float) -> list[Stroke]:
    """The box around all parts that stand on the ground."""
    corners = outlook.scenery.triangles
    standing = corners[corners[:, :, 2].max(axis=1) > ground + 0.01].reshape(-1, 3)
    if not len(standing):
        return []
    places = _in_plan(outlook, standing)
    (left, rear), (right, front) = places.min(axis=0), places.max(axis=0)
    box = np.array([[left, rear], [right, rear], [right, front], [left, front], [left, rear]])
    return [sheet.line(box - middle, GRID, 1.5)]


def _patch(colours: Items, corner: tuple[float, float], size: float, colour: Colour) -> None:
    """Paint a patch of the legend."""
    x, y = (round(FINER * value) for value in corner)
    colours[y : y + round(FINER * size), x : x + round(FINER * 1.7 * size)] = colour
