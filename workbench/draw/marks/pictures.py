"""Draw the layout of marks as SVG and as pixels: shapes with a white rim, leaders, labels, bar."""

from __future__ import annotations

import math
from xml.sax.saxutils import escape

from PIL import Image, ImageDraw, ImageFont

from workbench.draw.camera import Camera
from workbench.draw.marks.layout import (
    FONT,
    TEXT_SIZE,
    PlacedMark,
    Shape,
    layout_marks,
    mark_shapes,
    scale_bar,
)
from workbench.draw.scene import INK, INKS, PAPER, Colour, Scene, hexadecimal

__all__ = ["paint_mark_shapes", "paint_mark_texts", "svg_bar", "svg_key", "svg_marks"]

_RIM_WIDTH = 2.6
"""Width [pixels] of the paper around what is drawn."""
_KEY_STEP = 18.0
"""Distance [pixels] from the top to the first line of the legend, and from line to line."""
_TEXT = f'{FONT} font-size="{TEXT_SIZE:.0f}" text-anchor="middle"'


def svg_marks(scene: Scene, camera: Camera) -> list[str]:
    """Return SVG elements of a scene's marks: leaders, shapes, labels on plates.

    Shapes are paths, so that every circle element of a drawing is a sphere.
    """
    marks = layout_marks(scene, camera)
    leaders = [_svg_leader(mark) for mark in marks if mark.text]
    shapes = [text for mark in marks for text in _svg_shapes(mark)]
    labels = [_svg_label(mark) for mark in marks if mark.text]
    return [
        '<g class="marks" stroke-linecap="round" stroke-linejoin="round">',
        *leaders,
        *shapes,
        f"<g {_TEXT}>",
        *labels,
        "</g></g>",
    ]


def _svg_leader(mark: PlacedMark) -> str:
    (x, y), (u, v) = mark.held, mark.label
    return f'<path stroke="{hexadecimal(mark.colour)}" d="M{x:.1f} {y:.1f}L{u:.1f} {v:.1f}"/>'


def _svg_shapes(mark: PlacedMark) -> list[str]:
    """Return all shapes of a mark in paper and wider, then all in colour."""
    colour = hexadecimal(mark.colour)
    rims = []
    shapes = []
    for shape in mark_shapes(mark):
        text = "L".join(f"{x:.1f} {y:.1f}" for x, y in shape.corners)
        path = f'd="M{text}{"Z" if shape.closed else ""}"'
        rim_width = shape.width + _RIM_WIDTH
        rims.append(f'<path fill="none" stroke="#fff" stroke-width="{rim_width:.1f}" {path}/>')
        style = f'fill="{colour}"'
        if shape.width:
            style = f'fill="none" stroke="{colour}" stroke-width="{shape.width:.1f}"'
        shapes.append(f'<path class="{mark.kind}" {style} {path}/>')
    return rims + shapes


def _svg_label(mark: PlacedMark) -> str:
    (u, v), (a, b) = mark.label, mark.half
    colour = hexadecimal(mark.colour)
    return (
        f'<rect x="{u - a:.1f}" y="{v - b:.1f}" width="{2 * a:.1f}" height="{2 * b:.1f}" rx="4" fill="#fff"'
        f' stroke="{colour}"/><text x="{u:.1f}" y="{v:.1f}" dy=".36em" fill="{colour}">{escape(mark.text)}</text>'
    )


def svg_bar(camera: Camera) -> list[str]:
    """Return SVG elements of the scale bar.

    A perspective view has none, since no bar is true for all depths.
    """
    if math.isfinite(camera.distance):
        return []
    bar = scale_bar(camera)
    ink = hexadecimal(INK)
    shape = f"M{bar.x:.1f} {bar.y - 5:.1f}v10m0-5h{bar.pixels:.2f}m0-5v10"
    return [
        f'<g class="scale"><path fill="none" stroke="{ink}" stroke-width="2" d="{shape}"/>'
        f'<text x="{bar.x + bar.pixels / 2.0:.1f}" y="{bar.y - 8:.1f}" {_TEXT} fill="{ink}">{bar.text}</text></g>'
    ]


def svg_key(scene: Scene, camera: Camera) -> list[str]:
    """Return SVG elements of a scene's legend: a line for each entry, in its colour."""
    if not scene.key:
        return []
    right = camera.width - _KEY_STEP / 2.0
    lines = [
        f'<text x="{right:.1f}" y="{_KEY_STEP * (k + 1):.1f}" dy=".36em"'
        f' fill="{hexadecimal(INKS[colour])}">{escape(what)}</text>'
        for k, (what, colour) in enumerate(scene.key)
    ]
    return [
        f'<g class="key" {FONT} font-size="{TEXT_SIZE:.0f}" text-anchor="end">',
        *lines,
        "</g>",
    ]


def paint_mark_shapes(image: Image.Image, scene: Scene, camera: Camera, factor: int) -> None:
    """Paint leaders, shapes and the scale bar.

    Parameters
    ----------
    image
        Picture that is `factor` times as large as the camera's, and made smaller later.
    scene, camera
        The scene with its marks, and its camera.
    factor
        Pixels of the image for one of the camera.
    """
    draw = ImageDraw.Draw(image)
    marks = layout_marks(scene, camera)
    for mark in marks:
        if mark.text:
            for width, colour in ((3.0, PAPER), (1.0, mark.colour)):
                _stroke(draw, Shape((mark.held, mark.label), width), colour, factor)
    for mark in marks:
        _paint_shapes(draw, mark, factor)
    if math.isinf(camera.distance):  # no bar is true for all depths of a perspective view
        _paint_scale_bar(draw, camera, factor)


def _paint_shapes(draw: ImageDraw.ImageDraw, mark: PlacedMark, factor: int) -> None:
    """Paint all shapes of a mark in paper and wider, then all in colour."""
    shapes = mark_shapes(mark)
    for shape in shapes:
        _stroke(draw, shape._replace(width=shape.width + _RIM_WIDTH), PAPER, factor)
    for shape in shapes:
        if shape.width:
            _stroke(draw, shape, mark.colour, factor)
        else:
            draw.polygon([(x * factor, y * factor) for x, y in shape.corners], fill=mark.colour)


def _paint_scale_bar(draw: ImageDraw.ImageDraw, camera: Camera, factor: int) -> None:
    bar = scale_bar(camera)
    right = bar.x + bar.pixels
    line = Shape(((bar.x, bar.y), (right, bar.y)), 2.0)
    ends = [Shape(((x, bar.y - 5.0), (x, bar.y + 5.0)), 2.0) for x in (bar.x, right)]
    for width, colour in ((4.0, PAPER), (2.0, INK)):
        for shape in (line, *ends):
            _stroke(draw, shape._replace(width=width), colour, factor)


def _stroke(draw: ImageDraw.ImageDraw, shape: Shape, colour: Colour, factor: int) -> None:
    """Draw a line along the corners, with round joints."""
    corners = [(x * factor, y * factor) for x, y in shape.corners]
    if shape.closed:
        corners += corners[:2]
    draw.line(corners, fill=colour, width=max(1, round(shape.width * factor)), joint="curve")


def paint_mark_texts(image: Image.Image, scene: Scene, camera: Camera) -> None:
    """Write labels on white plates, the legend and the caption of the scale bar.

    Parameters
    ----------
    image
        Picture in the size of the camera, where letters are crisp.
    scene, camera
        The scene with its marks, and its camera.
    """
    draw = ImageDraw.Draw(image)
    font = ImageFont.load_default(TEXT_SIZE)  # the font inside Pillow: the same on every machine
    for mark in layout_marks(scene, camera):
        if mark.text:
            (x, y), (a, b) = mark.label, mark.half
            draw.rounded_rectangle(
                (x - a, y - b, x + a, y + b), radius=4, fill=PAPER, outline=mark.colour, width=1
            )
            draw.text((x, y), mark.text, fill=mark.colour, font=font, anchor="mm")
    outlined = {"font": font, "stroke_width": 2, "stroke_fill": PAPER}
    for k, (what, colour) in enumerate(scene.key):
        position = (camera.width - _KEY_STEP / 2.0, _KEY_STEP * (k + 1))
        draw.text(position, what, fill=INKS[colour], anchor="rm", **outlined)
    if math.isinf(camera.distance):
        bar = scale_bar(camera)
        middle = bar.x + bar.pixels / 2.0
        draw.text((middle, bar.y - 7), bar.text, fill=INK, anchor="ms", **outlined)
