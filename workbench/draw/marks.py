"""Where marks, their labels and the scale bar go. The raster and the vector display draw the same layout."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, project
from workbench.draw.colours import MARKS, Colour
from workbench.draw.scene import Scene

__all__ = ["DOT", "TEXT_SIZE", "PlacedMark", "ScaleBar", "placed_marks", "scale_bar"]

DOT = 4.0  # [pixels] radius of a mark's dot
TEXT_SIZE = 13.0  # [pixels]
_GLYPH = 0.62  # width of a character in text sizes: a little more than that of digits in common sans-serif fonts
_CLEAR = 2.0  # [pixels] between labels
_RINGS = (15.0, 21.0, 29.0, 39.0, 52.0, 68.0, 90.0, 120.0, 160.0, 220.0)  # [pixels] from dot to label
_TURNS = 24


class PlacedMark(NamedTuple):
    """A mark in the picture [pixels]: dot x, y; label's middle x, y and its half width and height (0 where none)."""

    dot: tuple[float, float]
    label: tuple[float, float]
    half: tuple[float, float]
    text: str
    colour: Colour
    kind: str


class ScaleBar(NamedTuple):
    """A bar of `length` [m]: left end x, y and length in pixels, and its caption."""

    length: float
    x: float
    y: float
    pixels: float
    text: str


def placed_marks(scene: Scene, camera: Camera) -> list[PlacedMark]:
    """Every mark inside the picture, with a label that overlaps no dot and no other label while there is room.

    Labels go outward from the middle of the marks, as near to their dot as is free; where nothing is free, to the
    place with the least overlap.
    """
    points = project(camera, np.array([mark.point for mark in scene.marks]).reshape(-1, 3))
    inside = np.all((points[:, :2] >= 0) & (points[:, :2] <= (camera.width, camera.height)), axis=1)
    dots = [(float(x), float(y)) for x, y, _ in points[inside]]
    middle = np.mean(dots, axis=0) if dots else np.zeros(2)
    taken = [_box(dot, (DOT + 1.0, DOT + 1.0)) for dot in dots]
    placed = []
    shown = [mark for mark, here in zip(scene.marks, inside, strict=True) if here]
    for mark, dot in zip(shown, dots, strict=True):
        half = (len(mark.label) * TEXT_SIZE * _GLYPH / 2.0 + 3.0, TEXT_SIZE / 2.0 + 2.0) if mark.label else (0.0, 0.0)
        label = dot
        if mark.label:
            outward = math.atan2(dot[1] - middle[1], dot[0] - middle[0])
            label = _free_place(dot, half, outward, taken, camera)
            taken.append(_box(label, half))
        placed.append(PlacedMark(dot, label, half, mark.label, MARKS[mark.kind], mark.kind))
    return placed


_Box = tuple[float, float, float, float]


def _box(middle: tuple[float, float], half: tuple[float, float]) -> _Box:
    return middle[0] - half[0], middle[1] - half[1], middle[0] + half[0], middle[1] + half[1]


def _free_place(
    dot: tuple[float, float], half: tuple[float, float], outward: float, taken: list[_Box], camera: Camera
) -> tuple[float, float]:
    """Try rings of places around the dot, the outward direction first, then turning away from it to both sides."""
    boxes = np.array(taken)
    turns = [(turn + 1) // 2 * (1 if turn % 2 else -1) * math.tau / _TURNS for turn in range(_TURNS)]
    best, least = dot, math.inf
    for ring in _RINGS:
        for turn in turns:
            reach_x, reach_y = ring + half[0] - half[1], ring
            x = dot[0] + reach_x * math.cos(outward + turn)
            y = dot[1] + reach_y * math.sin(outward + turn)
            x = min(max(x, half[0] + _CLEAR), camera.width - half[0] - _CLEAR)
            y = min(max(y, half[1] + _CLEAR), camera.height - half[1] - _CLEAR)
            left, top, right, bottom = _box((x, y), (half[0] + _CLEAR, half[1] + _CLEAR))
            wide = np.minimum(boxes[:, 2], right) - np.maximum(boxes[:, 0], left)
            high = np.minimum(boxes[:, 3], bottom) - np.maximum(boxes[:, 1], top)
            overlap = float(np.sum(np.maximum(wide, 0.0) * np.maximum(high, 0.0)))
            if overlap < least:
                best, least = (x, y), overlap
            if overlap == 0.0:
                return best
    return best


def scale_bar(camera: Camera) -> ScaleBar:
    """A bar of 1, 2 or 5 times a power of ten millimetres, at most a sixth of the picture's width."""
    room = camera.width / 6.0 / camera.scale * 1000.0  # [mm]
    power = 10.0 ** math.floor(math.log10(room))
    length = max(step * power for step in (1.0, 2.0, 5.0) if step * power <= room)
    text = f"{length:g} mm" if length < 1e4 else f"{length / 1000.0:g} m"
    return ScaleBar(length / 1000.0, 16.0, camera.height - 16.0, length / 1000.0 * camera.scale, text)
