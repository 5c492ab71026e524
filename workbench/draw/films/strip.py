"""Set several pictures of one size side by side, with a caption under each: the paper's Figure 7."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.sax.saxutils import escape

from PIL import Image, ImageDraw, ImageFont

from workbench.draw.marks.layout import FONT, TEXT_SIZE
from workbench.draw.scene import INK, PAPER, hexadecimal
from workbench.errors import UsageError

__all__ = ["strip_image", "strip_svg"]

_CAPTION_HEIGHT = 26
"""[pixels]."""
_GAP = 8
"""Distance [pixels] between pictures."""


def strip_image(pictures: Sequence[Image.Image], captions: Sequence[str]) -> Image.Image:
    """Join pictures in a row, their captions below.

    Raises
    ------
    UsageError
        If the sizes differ, or the number of captions is another.
    """
    width, height = _common_size([picture.size for picture in pictures], captions)
    whole = len(pictures) * (width + _GAP) - _GAP
    page = Image.new("RGB", (whole, height + _CAPTION_HEIGHT), PAPER)
    draw = ImageDraw.Draw(page)
    font = ImageFont.load_default(TEXT_SIZE)
    for number, (picture, caption) in enumerate(zip(pictures, captions, strict=True)):
        left = number * (width + _GAP)
        page.paste(picture, (left, 0))
        middle = (left + width / 2.0, height + _CAPTION_HEIGHT / 2.0)
        draw.text(middle, caption, fill=INK, font=font, anchor="mm")
    return page


def strip_svg(pictures: Sequence[str], captions: Sequence[str], *, title: str = "") -> str:
    """Join SVG texts of whole pictures in a row, their captions below.

    Raises
    ------
    UsageError
        If the sizes differ, or the number of captions is another.
    """
    matches = [re.match(r'<svg [^>]*width="(\d+)" height="(\d+)"', text) for text in pictures]
    width, height = _common_size(
        [(int(m[1]), int(m[2])) if m else (0, 0) for m in matches], captions
    )
    whole = len(pictures) * (width + _GAP) - _GAP
    whole_height = height + _CAPTION_HEIGHT
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {whole} {whole_height}" width="{whole}"'
        f' height="{whole_height}" role="img">',
        f"<title>{escape(title)}</title>",
        f'<rect width="{whole}" height="{whole_height}" fill="{hexadecimal(PAPER)}"/>',
    ]
    for number, (text, caption) in enumerate(zip(pictures, captions, strict=True)):
        left = number * (width + _GAP)
        parts.append(text.replace("<svg ", f'<svg x="{left}" ', 1).rstrip())
        parts.append(_svg_caption(caption, left + width / 2, height + _CAPTION_HEIGHT / 2))
    return "\n".join([*parts, "</svg>", ""])


def _svg_caption(caption: str, x: float, y: float) -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" dy=".36em" text-anchor="middle"'
        f' {FONT} font-size="{TEXT_SIZE:.0f}"'
        f' fill="{hexadecimal(INK)}">{escape(caption)}</text>'
    )


def _common_size(sizes: Sequence[tuple[int, int]], captions: Sequence[str]) -> tuple[int, int]:
    if not sizes or len(set(sizes)) > 1 or len(captions) != len(sizes):
        raise UsageError(
            f"a strip needs pictures of one size and a caption each, got {sizes} and {len(captions)}"
        )
    return sizes[0]
