"""Write a chart as SVG or PNG: an area of colours, and lines and words over it.

Both files show the same: the colours are pixels, twice as fine as the picture.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from workbench.draw.marks.layout import FONT
from workbench.draw.scene import INK, PAPER, Colour, hexadecimal
from workbench.model.arrays import Floats

__all__ = ["FINER", "Chart", "Stroke", "Words", "chart_image", "chart_svg"]

FINER = 2
"""Pixels of the area of colours for one of the picture, each way."""
_ANCHORS = {"start": "lm", "middle": "mm", "end": "rm"}
"""Where words are held: as SVG and as Pillow call it."""


class Stroke(NamedTuple):
    """A line through points (K, 2) [pixels]; it breaks where a point is NaN."""

    points: Floats
    colour: Colour = INK
    width: float = 1.0


class Words(NamedTuple):
    """A line of text about a point [pixels]."""

    at: tuple[float, float]
    text: str
    size: float
    anchor: str = "start"
    """start, middle or end: what of the text is at the point."""
    colour: Colour = INK
    halo: bool = False
    """Whether paper surrounds the letters."""


@dataclass(frozen=True, eq=False)
class Chart:
    """What a chart shows; screen readers read out title and description."""

    title: str
    description: str
    colours: NDArray[np.uint8]
    """(FINER height, FINER width, 3)."""
    strokes: Sequence[Stroke] = ()
    words: Sequence[Words] = ()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [pixels]."""
        return self.colours.shape[1] // FINER, self.colours.shape[0] // FINER


def chart_svg(chart: Chart) -> str:
    """Write a chart as SVG text, which holds no script and refers to nothing outside."""
    width, height = chart.size
    image = base64.b64encode(_png(_indexed(chart.colours))).decode()
    strokes = [
        f'<path stroke="{hexadecimal(stroke.colour)}" stroke-width="{stroke.width:g}" d="{path}"/>'
        for stroke in chart.strokes
        if (path := "".join(_svg_path(run) for run in _runs(stroke.points)))
    ]
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'width="{width}" height="{height}" role="img">',
            f"<title>{escape(chart.title)}</title><desc>{escape(chart.description)}</desc>",
            f'<image width="{width}" height="{height}" href="data:image/png;base64,{image}"/>',
            '<g fill="none" stroke-linecap="round" stroke-linejoin="round">',
            *strokes,
            f"</g><g {FONT}>",
            *(_svg_words(words) for words in chart.words),
            "</g></svg>",
            "",
        ]
    )


def _svg_path(run: Floats) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in run.tolist())


def _svg_words(words: Words) -> str:
    halo = ' stroke="#fff" stroke-width="3" stroke-linejoin="round" paint-order="stroke"'
    x, y = words.at
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" dy=".36em" font-size="{words.size:.1f}" '
        f'text-anchor="{words.anchor}" fill="{hexadecimal(words.colour)}"'
        f"{halo if words.halo else ''}>{escape(words.text)}</text>"
    )


def chart_image(chart: Chart) -> Image.Image:
    """Draw a chart as pixels."""
    fine = Image.fromarray(chart.colours)
    draw = ImageDraw.Draw(fine)
    for stroke in chart.strokes:
        width = max(1, round(FINER * stroke.width))
        for run in _runs(stroke.points):
            corners = [(FINER * x, FINER * y) for x, y in run.tolist()]
            draw.line(corners, fill=stroke.colour, width=width, joint="curve")
    image = fine.resize(chart.size, Image.Resampling.BOX)
    draw = ImageDraw.Draw(image)
    for words in chart.words:
        draw.text(
            words.at,
            words.text,
            fill=words.colour,
            font=ImageFont.load_default(words.size),
            anchor=_ANCHORS[words.anchor],
            stroke_width=1.5 if words.halo else 0,
            stroke_fill=PAPER,
        )
    return image


def _runs(points: Floats) -> list[Floats]:
    """The pieces (K, 2) of a line between its points that are NaN, of two points at least."""
    finite = np.all(np.isfinite(points), axis=1)
    borders = np.flatnonzero(np.diff(finite, prepend=False, append=False))
    pieces = [points[low:high] for low, high in borders.reshape(-1, 2).tolist()]
    return [piece for piece in pieces if len(piece) > 1]


def _indexed(colours: NDArray[np.uint8]) -> Image.Image:
    """An image of few colours with a palette, which makes a small file; as it is with many."""
    packed = colours.astype(np.int64) @ np.array([65536, 256, 1])
    palette, index = np.unique(packed, return_inverse=True)
    if len(palette) > 256:
        return Image.fromarray(colours)
    image = Image.fromarray(index.reshape(packed.shape).astype(np.uint8))
    rgb = np.stack([palette // 65536, palette // 256 % 256, palette % 256], axis=1)
    image.putpalette(rgb.astype(np.uint8).tobytes())
    return image


def _png(image: Image.Image) -> bytes:
    out = io.BytesIO()
    image.save(out, "PNG", optimize=True)
    return out.getvalue()
