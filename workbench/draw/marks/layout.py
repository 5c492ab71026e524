"""Where marks, their labels and the scale bar go. The raster and the vector display draw the same
layout.

A kind of mark has one look: contact, allowed and point are dots; clearance is a dimension line
between two points, with arrows inside where there is room and outside where there is not; reach is
a target (ring and cross), missed the same with a line to where the hand got; stop is a diamond at
the joint; axis_x, axis_y, axis_z are arrows; segment is a word.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, project
from workbench.draw.colours import MARKS, Colour
from workbench.draw.scene import Mark, Scene

__all__ = [
    "DOT",
    "TEXT_SIZE",
    "PlacedMark",
    "ScaleBar",
    "Shape",
    "layout_marks",
    "mark_shapes",
    "scale_bar",
]

DOT = 4.0  # [pixels] radius of a mark's dot
TEXT_SIZE = 13.0  # [pixels]
_WIDE = {
    "mwMW@%…—": 0.92,
    "iljI|.,:;'! ": 0.32,
    "ftr()[]-/°": 0.42,
}  # widths of letters in text sizes, a little
_CAPITAL = 0.74
_LETTER = 0.59  # more than in common sans-serif fonts
_CLEAR = 2.0  # [pixels] between labels
_RINGS = (
    15.0,
    21.0,
    29.0,
    39.0,
    52.0,
    68.0,
    90.0,
    120.0,
    160.0,
    220.0,
)  # [pixels] from dot to label
_TURNS = 24
_LONGEST = 48  # characters of a label
_ARROW = 8.0  # [pixels] length of an arrow head
_ROOM = 3.0 * _ARROW  # [pixels] a shorter dimension has its arrows outside

_Point = tuple[float, float]
_Box = tuple[float, float, float, float]


class PlacedMark(NamedTuple):
    """A mark in the picture [pixels]: dot x, y; label's middle x, y and its half width and height
    (0 where none).

    to: the other end of a mark that is a line, None for a point.
    """

    dot: _Point
    label: _Point
    half: _Point
    text: str
    colour: Colour
    kind: str
    to: _Point | None = None

    @property
    def held(self) -> _Point:
        """Where the leader of the label begins: the middle of a dimension, the tip of an axis, else
        the dot."""
        return _held(self.kind, self.dot, self.to)


class Shape(NamedTuple):
    """A piece of a mark: corners x, y [pixels]; stroke width [pixels], 0 for a filled polygon;
    closed or open."""

    corners: tuple[_Point, ...]
    width: float
    closed: bool = False


class ScaleBar(NamedTuple):
    """A bar of `length` [m]: left end x, y and length in pixels, and its caption."""

    length: float
    x: float
    y: float
    pixels: float
    text: str


def layout_marks(scene: Scene, camera: Camera) -> list[PlacedMark]:
    """Every mark inside the picture, with a label that overlaps no dot and no other label while
    there is room.

    Labels go outward from the middle of the marks, as near to their dot as is free; where nothing
    is free, to the place with the least overlap. Letters that no picture can show are replaced,
    long labels shortened.
    """
    shown, dots, ends = _inside(scene.marks, camera)
    middle = np.mean(dots, axis=0) if dots else np.zeros(2)
    taken = [_box(dot, (DOT + 1.0, DOT + 1.0)) for dot in dots]
    taken += [
        _box(point, (3.0, 3.0))
        for dot, to in zip(dots, ends, strict=True)
        if to
        for point in _along(dot, to)
    ]
    placed = []
    for mark, dot, to in zip(shown, dots, ends, strict=True):
        text = _plain(mark.label)
        half = (_text_width(text) / 2.0 + 4.0, TEXT_SIZE / 2.0 + 2.0) if text else (0.0, 0.0)
        label = held = _held(mark.kind, dot, to)
        if text:
            outward = math.atan2(held[1] - middle[1], held[0] - middle[0])
            if to is not None:  # beside a line, not on it
                away = (
                    (to[1] - dot[1], dot[0] - to[0])
                    if mark.kind == "clearance"
                    else (to[0] - dot[0], to[1] - dot[1])
                )
                outward = math.atan2(away[1], away[0]) if away != (0.0, 0.0) else outward
            label = _free_place(held, half, outward, taken, camera)
            taken.append(_box(label, half))
        placed.append(PlacedMark(dot, label, half, text, MARKS[mark.kind], mark.kind, to))
    return placed


def _inside(
    marks: tuple[Mark, ...], camera: Camera
) -> tuple[list[Mark], list[_Point], list[_Point | None]]:
    """Marks whose point is in the picture; their points and other ends in pixels."""
    points = project(camera, np.array([mark.point for mark in marks]).reshape(-1, 3))
    others = project(camera, np.array([mark.to or mark.point for mark in marks]).reshape(-1, 3))
    size = (camera.width, camera.height)
    here = np.all(
        (points[:, :2] >= 0) & (points[:, :2] <= size) & np.isfinite(others[:, :2]), axis=1
    )
    chosen = np.flatnonzero(here)
    ends = [(float(others[k, 0]), float(others[k, 1])) if marks[k].to else None for k in chosen]
    return (
        [marks[k] for k in chosen],
        [(float(points[k, 0]), float(points[k, 1])) for k in chosen],
        ends,
    )


def _plain(text: str) -> str:
    """A label without letters that SVG forbids or no font has, no longer than _LONGEST."""
    clean = "".join(
        letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in text
    )
    return clean if len(clean) <= _LONGEST else clean[: _LONGEST - 1] + "…"


def _text_width(text: str) -> float:
    """[pixels] no narrower than the text is in any common sans-serif font."""
    sizes = [
        next(
            (size for letters, size in _WIDE.items() if letter in letters),
            _CAPITAL if letter.isupper() or ord(letter) > 0x2E80 else _LETTER,
        )
        for letter in text
    ]
    return TEXT_SIZE * sum(sizes)


def _held(kind: str, dot: _Point, to: _Point | None) -> _Point:
    if to is None or kind == "missed":
        return dot
    return to if kind.startswith("axis") else ((dot[0] + to[0]) / 2.0, (dot[1] + to[1]) / 2.0)


def _along(start: _Point, end: _Point) -> list[_Point]:
    """Points of a line, 6 pixels apart or closer, at most 200."""
    count = min(int(math.hypot(end[0] - start[0], end[1] - start[1]) / 6.0) + 2, 200)
    return [(float(x), float(y)) for x, y in np.linspace(start, end, count)]


def _box(middle: _Point, half: _Point) -> _Box:
    return middle[0] - half[0], middle[1] - half[1], middle[0] + half[0], middle[1] + half[1]


def _free_place(
    dot: _Point, half: _Point, outward: float, taken: list[_Box], camera: Camera
) -> _Point:
    """Try rings of places around the dot, the outward direction first, then turning away from it to
    both sides."""
    boxes = np.array(taken)
    turns = [
        (turn + 1) // 2 * (1 if turn % 2 else -1) * math.tau / _TURNS for turn in range(_TURNS)
    ]
    best = dot
    least = math.inf
    for ring in _RINGS:
        for turn in turns:
            reach_x = ring + half[0] - half[1]
            reach_y = ring
            x = dot[0] + reach_x * math.cos(outward + turn)
            y = dot[1] + reach_y * math.sin(outward + turn)
            x = min(max(x, half[0] + _CLEAR), camera.width - half[0] - _CLEAR)
            y = min(max(y, half[1] + _CLEAR), camera.height - half[1] - _CLEAR)
            left, top, right, bottom = _box((x, y), (half[0] + _CLEAR, half[1] + _CLEAR))
            wide = np.minimum(boxes[:, 2], right) - np.maximum(boxes[:, 0], left)
            high = np.minimum(boxes[:, 3], bottom) - np.maximum(boxes[:, 1], top)
            overlap = float(np.sum(np.maximum(wide, 0.0) * np.maximum(high, 0.0)))
            if overlap < least:
                best = (x, y)
                least = overlap
            if overlap == 0.0:
                return best
    return best


def mark_shapes(mark: PlacedMark) -> list[Shape]:
    """What a mark is drawn with besides its leader and label; nothing for a word. A dot is a
    16-sided polygon."""
    if mark.kind == "segment":
        return []
    if mark.kind in ("reach", "missed"):
        return _target(mark)
    if mark.kind == "stop":
        return [Shape(_regular(mark.dot, DOT + 3.0, 4), 2.0, True)]
    if mark.to is None:
        return [Shape(_regular(mark.dot, DOT, 16), 0.0, True)]
    return (
        _arrow(mark.dot, mark.to) if mark.kind.startswith("axis") else _dimension(mark.dot, mark.to)
    )


def _regular(middle: _Point, radius: float, corners: int) -> tuple[_Point, ...]:
    turns = [math.tau * k / corners for k in range(corners)]
    return tuple(
        (middle[0] + radius * math.cos(turn), middle[1] + radius * math.sin(turn)) for turn in turns
    )


def _target(mark: PlacedMark) -> list[Shape]:
    (x, y), reach = mark.dot, DOT + 3.0
    shapes = [Shape(_regular(mark.dot, DOT + 0.5, 16), 1.6, True)]
    shapes += [
        Shape(((x - reach, y), (x + reach, y)), 1.2),
        Shape(((x, y - reach), (x, y + reach)), 1.2),
    ]
    return shapes if mark.to is None else [Shape((mark.dot, mark.to), 1.6), *shapes]


def _head(tip: _Point, along: _Point) -> Shape:
    """An arrow head at `tip` that points along a unit vector."""
    (x, y), (u, v) = tip, along
    back = (x - _ARROW * u, y - _ARROW * v)
    side = _ARROW * 0.32
    return Shape(
        (tip, (back[0] - side * v, back[1] + side * u), (back[0] + side * v, back[1] - side * u)),
        0.0,
        True,
    )


def _arrow(start: _Point, tip: _Point) -> list[Shape]:
    length = math.hypot(tip[0] - start[0], tip[1] - start[1])
    if length < _ARROW:  # seen end-on
        return [Shape(_regular(start, DOT, 16), 1.4, True)]
    along = ((tip[0] - start[0]) / length, (tip[1] - start[1]) / length)
    stem = (tip[0] - 0.7 * _ARROW * along[0], tip[1] - 0.7 * _ARROW * along[1])
    return [Shape((start, stem), 2.0), _head(tip, along)]


def _dimension(start: _Point, end: _Point) -> list[Shape]:
    """A dimension line: ticks across its ends, arrows from inside, or from outside where it is
    short."""
    length = math.hypot(end[0] - start[0], end[1] - start[1])
    along = (
        ((end[0] - start[0]) / length, (end[1] - start[1]) / length) if length > 0.0 else (1.0, 0.0)
    )
    (u, v), tick = along, 6.0
    ticks = [
        Shape(((x - tick * v, y + tick * u), (x + tick * v, y - tick * u)), 1.4)
        for x, y in (start, end)
    ]
    if length >= _ROOM:
        return [Shape((start, end), 1.4), *ticks, _head(start, (-u, -v)), _head(end, along)]
    tail = 2.2 * _ARROW
    before = (start[0] - tail * u, start[1] - tail * v)
    after = (end[0] + tail * u, end[1] + tail * v)
    return [Shape((before, after), 1.4), *ticks, _head(start, along), _head(end, (-u, -v))]


def scale_bar(camera: Camera) -> ScaleBar:
    """A bar of 1, 2 or 5 times a power of ten millimetres, at most a sixth of the picture's
    width."""
    room = camera.width / 6.0 / camera.scale * 1000.0  # [mm]
    power = 10.0 ** math.floor(math.log10(room))
    length = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= room)
    text = f"{length:g} mm" if length < 1e4 else f"{length / 1000.0:g} m"
    return ScaleBar(
        length / 1000.0, 16.0, camera.height - 16.0, length / 1000.0 * camera.scale, text
    )
