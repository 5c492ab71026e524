"""Lay out marks, their labels and the scale bar. Raster and vector displays draw the same layout.

Shapes of the kinds of marks:

- contact, allowed, point: a dot.
- clearance: a dimension line, with arrows inside it, or outside if it is short.
- reach: a target (ring and cross). missed: the same with a line to where the hand got.
- stop: a diamond at the joint.
- axis_x, axis_y, axis_z: an arrow.
- segment: a word.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, project
from workbench.draw.scene import MARKS, Colour, Mark, Scene
from workbench.model.arrays import Floats

__all__ = [
    "FONT",
    "TEXT_SIZE",
    "PlacedMark",
    "ScaleBar",
    "Shape",
    "layout_marks",
    "mark_shapes",
    "scale_bar",
]

FONT = "font-family='Helvetica,Arial,sans-serif'"
"""The attribute of SVG text; the quotes are single, since a family may have a name in double quotes."""
TEXT_SIZE = 13.0
"""Height of letters [pixels]."""
_DOT_RADIUS = 4.0
"""[pixels]."""
_LETTER_WIDTHS = {"mwMW@%…—": 0.92, "iljI|.,:;'! ": 0.32, "ftr()[]-/°": 0.42}
"""Widths of letters as shares of the text size, a little more than in common sans-serif fonts."""
_CAPITAL_WIDTH = 0.74
_OTHER_WIDTH = 0.59
_FIRST_WIDE_LETTER = 0x2E80
"""Code point from which scripts have letters as wide as capitals."""
_LABEL_GAP = 2.0
"""Free space [pixels] around labels."""
_LABEL_DISTANCES = (15.0, 21.0, 29.0, 39.0, 52.0, 68.0, 90.0, 120.0, 160.0, 220.0)
"""Distances [pixels] of a label from its dot, in the order in which they are tried."""
_LABEL_DIRECTIONS = 24
"""Number of directions that are tried at each distance."""
_MAX_LETTERS = 48
"""Longest label."""
_ARROW = 8.0
"""Length of an arrow head [pixels]."""
_MIN_INSIDE_LENGTH = 3.0 * _ARROW
"""Length [pixels] below which a dimension line has its arrows outside."""
_TICK = 6.0
"""Half length [pixels] of the ticks of a dimension line."""
_SCALE_BAR_MARGIN = 16.0
"""Distance [pixels] of the scale bar from the left and lower border."""

_Point = tuple[float, float]
"""x, y [pixels]."""
_Box = tuple[float, float, float, float]
"""Left, top, right, bottom [pixels]."""


class PlacedMark(NamedTuple):
    """A mark in the picture; all lengths are pixels."""

    dot: _Point
    label: _Point
    """Middle of the label."""
    half: _Point
    """Half width and half height of the label, 0 without one."""
    text: str
    colour: Colour
    kind: str
    to: _Point | None = None
    """Other end of a mark that is a line."""

    @property
    def held(self) -> _Point:
        """Where the leader of the label begins, see `_leader_start`."""
        return _leader_start(self.kind, self.dot, self.to)


class Shape(NamedTuple):
    """A polygon or polyline of a mark."""

    corners: tuple[_Point, ...]
    width: float
    """Width of the stroke [pixels], 0 for a filled polygon."""
    closed: bool = False


class ScaleBar(NamedTuple):
    """A bar of known length."""

    length: float
    """[m]."""
    x: float
    """Left end [pixels]."""
    y: float
    pixels: float
    """Length in the picture."""
    text: str


def layout_marks(scene: Scene, camera: Camera) -> list[PlacedMark]:
    """Place every mark inside the picture, with a label that overlaps no dot and no other label.

    Labels go outward from the middle of the marks, as near to their dot as is free. If nothing is
    free they go to the place with the least overlap. Letters that no picture can show are replaced,
    long labels shortened.
    """
    shown, dots, ends = _marks_inside(scene.marks, camera)
    middle = np.mean(dots, axis=0) if dots else np.zeros(2)
    taken = [_box(dot, (_DOT_RADIUS + 1.0, _DOT_RADIUS + 1.0)) for dot in dots]
    for dot, to in zip(dots, ends, strict=True):
        if to:
            taken.extend(_box(point, (3.0, 3.0)) for point in _points_along(dot, to))
    placed = []
    for mark, dot, to in zip(shown, dots, ends, strict=True):
        text = _printable(mark.label)
        label = _leader_start(mark.kind, dot, to)
        half = (0.0, 0.0)
        if text:
            half = (_text_width(text) / 2.0 + 4.0, TEXT_SIZE / 2.0 + 2.0)
            outward = _label_direction(mark.kind, dot, to, middle)
            label = _free_position(label, half, outward, taken, camera)
            taken.append(_box(label, half))
        placed.append(PlacedMark(dot, label, half, text, MARKS[mark.kind], mark.kind, to))
    return placed


def _marks_inside(
    marks: tuple[Mark, ...], camera: Camera
) -> tuple[list[Mark], list[_Point], list[_Point | None]]:
    """Return the marks whose point is in the picture, their points and their other ends."""
    points = project(camera, np.array([mark.point for mark in marks]).reshape(-1, 3))
    others = project(camera, np.array([mark.to or mark.point for mark in marks]).reshape(-1, 3))
    size = (camera.width, camera.height)
    inside = np.all((points[:, :2] >= 0) & (points[:, :2] <= size), axis=1)
    inside &= np.all(np.isfinite(others[:, :2]), axis=1)
    chosen = np.flatnonzero(inside)
    shown = [marks[k] for k in chosen]
    dots = [(x, y) for x, y, _ in points[chosen].tolist()]
    ends = [(x, y) for x, y, _ in others[chosen].tolist()]
    return shown, dots, [end if mark.to else None for mark, end in zip(shown, ends, strict=True)]


def _printable(text: str) -> str:
    """Replace letters that SVG forbids or no font has, and shorten long labels."""
    clean = "".join(
        letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in text
    )
    return clean if len(clean) <= _MAX_LETTERS else clean[: _MAX_LETTERS - 1] + "…"


def _text_width(text: str) -> float:
    """Return a width [pixels] that the text does not exceed in any common sans-serif font."""
    return TEXT_SIZE * sum(_letter_width(letter) for letter in text)


def _letter_width(letter: str) -> float:
    for letters, width in _LETTER_WIDTHS.items():
        if letter in letters:
            return width
    wide = letter.isupper() or ord(letter) > _FIRST_WIDE_LETTER
    return _CAPITAL_WIDTH if wide else _OTHER_WIDTH


def _leader_start(kind: str, dot: _Point, to: _Point | None) -> _Point:
    """Return the middle of a dimension line, the tip of an axis, otherwise the dot."""
    if to is None or kind == "missed":
        return dot
    return to if kind.startswith("axis") else ((dot[0] + to[0]) / 2.0, (dot[1] + to[1]) / 2.0)


def _label_direction(kind: str, dot: _Point, to: _Point | None, middle: Floats) -> float:
    """Return the angle [rad] at which a label is tried first: beside a dimension line, beyond the
    end of other lines, else away from the middle (2,) of all marks."""
    start = _leader_start(kind, dot, to)
    if to is not None and to != dot:
        along = (to[0] - dot[0], to[1] - dot[1])
        across = (to[1] - dot[1], dot[0] - to[0])
        x, y = across if kind == "clearance" else along
        return math.atan2(y, x)
    return math.atan2(start[1] - middle[1], start[0] - middle[0])


def _points_along(start: _Point, end: _Point) -> list[_Point]:
    """Return at most 200 points of a line, about 6 pixels apart or closer."""
    count = min(int(math.hypot(end[0] - start[0], end[1] - start[1]) / 6.0) + 2, 200)
    return [(x, y) for x, y in np.linspace(start, end, count).tolist()]


def _box(middle: _Point, half: _Point) -> _Box:
    return middle[0] - half[0], middle[1] - half[1], middle[0] + half[0], middle[1] + half[1]


def _overlap_area(box: _Box, taken: Floats) -> float:
    """Return the area [pixels^2] that a box shares with the boxes that are taken (K, 4)."""
    left, top, right, bottom = box
    width = np.minimum(taken[:, 2], right) - np.maximum(taken[:, 0], left)
    height = np.minimum(taken[:, 3], bottom) - np.maximum(taken[:, 1], top)
    return float(np.sum(np.maximum(width, 0.0) * np.maximum(height, 0.0)))


def _free_position(
    dot: _Point, half: _Point, outward: float, taken: list[_Box], camera: Camera
) -> _Point:
    """Find a free position for a label of half size `half`, on growing ellipses about a dot.

    The direction `outward` [rad] is tried first, then directions to both sides of it.
    """
    boxes = np.array(taken)
    best = dot
    least = math.inf
    for distance in _LABEL_DISTANCES:
        for step in range(_LABEL_DIRECTIONS):
            side = 1 if step % 2 else -1
            angle = outward + (step + 1) // 2 * side * math.tau / _LABEL_DIRECTIONS
            x = dot[0] + (distance + half[0] - half[1]) * math.cos(angle)
            y = dot[1] + distance * math.sin(angle)
            x = min(max(x, half[0] + _LABEL_GAP), camera.width - half[0] - _LABEL_GAP)
            y = min(max(y, half[1] + _LABEL_GAP), camera.height - half[1] - _LABEL_GAP)
            box = _box((x, y), (half[0] + _LABEL_GAP, half[1] + _LABEL_GAP))
            overlap = _overlap_area(box, boxes)
            if overlap < least:
                best = (x, y)
                least = overlap
            if overlap == 0.0:
                return best
    return best


def mark_shapes(mark: PlacedMark) -> list[Shape]:
    """Return what a mark is drawn with besides its leader and label."""
    if mark.kind == "segment":
        return []
    if mark.kind in ("reach", "missed"):
        return _target(mark)
    if mark.kind == "stop":
        return [Shape(_regular_polygon(mark.dot, _DOT_RADIUS + 3.0, 4), 2.0, True)]
    if mark.to is None:
        return [Shape(_regular_polygon(mark.dot, _DOT_RADIUS, 16), 0.0, True)]
    if mark.kind.startswith("axis"):
        return _arrow(mark.dot, mark.to)
    return _dimension_line(mark.dot, mark.to)


def _regular_polygon(middle: _Point, radius: float, corners: int) -> tuple[_Point, ...]:
    turns = [math.tau * k / corners for k in range(corners)]
    return tuple(
        (middle[0] + radius * math.cos(turn), middle[1] + radius * math.sin(turn)) for turn in turns
    )


def _target(mark: PlacedMark) -> list[Shape]:
    """Return ring and cross, and the line to where the hand got."""
    x, y = mark.dot
    reach = _DOT_RADIUS + 3.0
    shapes = [
        Shape(_regular_polygon(mark.dot, _DOT_RADIUS + 0.5, 16), 1.6, True),
        Shape(((x - reach, y), (x + reach, y)), 1.2),
        Shape(((x, y - reach), (x, y + reach)), 1.2),
    ]
    return shapes if mark.to is None else [Shape((mark.dot, mark.to), 1.6), *shapes]


def _arrow_head(tip: _Point, direction: _Point) -> Shape:
    """Return an arrow head at `tip` that points along a unit vector."""
    x, y = tip
    u, v = direction
    back = (x - _ARROW * u, y - _ARROW * v)
    half_width = _ARROW * 0.32
    left = (back[0] - half_width * v, back[1] + half_width * u)
    right = (back[0] + half_width * v, back[1] - half_width * u)
    return Shape((tip, left, right), 0.0, True)


def _unit_vector(start: _Point, end: _Point) -> tuple[float, _Point]:
    """Return the length [pixels] of a line and its direction, to the right if it is a point."""
    length = math.hypot(end[0] - start[0], end[1] - start[1])
    if length == 0.0:
        return 0.0, (1.0, 0.0)
    return length, ((end[0] - start[0]) / length, (end[1] - start[1]) / length)


def _arrow(start: _Point, tip: _Point) -> list[Shape]:
    length, (u, v) = _unit_vector(start, tip)
    if length < _ARROW:  # seen end-on
        return [Shape(_regular_polygon(start, _DOT_RADIUS, 16), 1.4, True)]
    stem = (tip[0] - 0.7 * _ARROW * u, tip[1] - 0.7 * _ARROW * v)
    return [Shape((start, stem), 2.0), _arrow_head(tip, (u, v))]


def _dimension_line(start: _Point, end: _Point) -> list[Shape]:
    """Return a line with ticks across its ends and arrows from inside, or from outside if short."""
    length, (u, v) = _unit_vector(start, end)
    ticks = [
        Shape(((x - _TICK * v, y + _TICK * u), (x + _TICK * v, y - _TICK * u)), 1.4)
        for x, y in (start, end)
    ]
    forward = (u, v)
    backward = (-u, -v)
    if length >= _MIN_INSIDE_LENGTH:
        heads = [_arrow_head(start, backward), _arrow_head(end, forward)]
        return [Shape((start, end), 1.4), *ticks, *heads]
    tail = 2.2 * _ARROW
    before = (start[0] - tail * u, start[1] - tail * v)
    after = (end[0] + tail * u, end[1] + tail * v)
    heads = [_arrow_head(start, forward), _arrow_head(end, backward)]
    return [Shape((before, after), 1.4), *ticks, *heads]


def scale_bar(camera: Camera) -> ScaleBar:
    """Return a bar of 1, 2 or 5 times a power of ten millimetres, at most a sixth of the width."""
    longest = camera.width / 6.0 / camera.scale * 1000.0  # [mm]
    power = 10.0 ** math.floor(math.log10(longest))
    millimetres = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= longest)
    text = f"{millimetres:g} mm" if millimetres < 1e4 else f"{millimetres / 1000.0:g} m"
    length = millimetres / 1000.0
    left = _SCALE_BAR_MARGIN
    return ScaleBar(length, left, camera.height - _SCALE_BAR_MARGIN, length * camera.scale, text)
