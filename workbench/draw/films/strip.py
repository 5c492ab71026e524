"""Several pictures of one size side by side with a line of text under each: Figure 7 of the
paper."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.sax.saxutils import escape

from PIL import Image, ImageDraw, ImageFont

from workbench.draw.colours import INK, PAPER, hexadecimal
from workbench.draw.marks.layout import TEXT_SIZE
from workbench.errors import UsageError

__all__ = ["strip_image", "strip_svg"]

_FOOT = 26  # [pixels] room for the text
_GAP = 8  # [pixels] between pictures


def strip_image(pictures: Sequence[Image.Image], captions: Sequence[str]) -> Image.Image:
    """Pictures in a row, their captions below. UsageError where sizes differ or captions lack."""
    sizes = [picture.size for picture in pictures]
    width, height = _size(sizes, captions)
    page = Image.new("RGB", (len(pictures) * (width + _GAP) - _GAP, height + _FOOT), PAPER)
    draw = ImageDraw.Draw(page)
    font = ImageFont.load_default(TEXT_SIZE)
    for number, (picture, caption) in enumerate(zip(pictures, captions, strict=True)):
        left = number * (width + _GAP)
        page.paste(picture, (left, 0))
        draw.text(
            (left + width / 2.0, height + _FOOT / 2.0), caption, fill=INK, font=font, anchor="mm"
        )
    return page


def strip_svg(pictures: Sequence[str], captions: Sequence[str], *, title: str = "") -> str:
    """SVG pictures, each a whole text as the vector displays give it, as panels of one."""
    found = [re.match(r'<svg [^>]*width="(\d+)" height="(\d+)"', text) for text in pictures]
    width, height = _size([(int(m[1]), int(m[2])) if m else (0, 0) for m in found], captions)
    whole = len(pictures) * (width + _GAP) - _GAP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {whole} {height + _FOOT}" width="{whole}"'
        f' height="{height + _FOOT}" role="img">',
        f"<title>{escape(title)}</title>",
        f'<rect width="{whole}" height="{height + _FOOT}" fill="{hexadecimal(PAPER)}"/>',
    ]
    for number, (text, caption) in enumerate(zip(pictures, captions, strict=True)):
        left = number * (width + _GAP)
        parts.append(text.replace("<svg ", f'<svg x="{left}" ', 1).rstrip())
        parts.append(
            f'<text x="{left + width / 2:.1f}" y="{height + _FOOT / 2:.1f}" dy=".36em" text-anchor="middle"'
            f" font-family='Helvetica,Arial,sans-serif' font-size=\"{TEXT_SIZE:.0f}\""
            f' fill="{hexadecimal(INK)}">{escape(caption)}</text>'
        )
    return "\n".join([*parts, "</svg>", ""])


def _size(sizes: Sequence[tuple[int, int]], captions: Sequence[str]) -> tuple[int, int]:
    if not sizes or len(set(sizes)) > 1 or len(captions) != len(sizes):
        raise UsageError(
            f"a strip needs pictures of one size and a caption each, got {sizes} and {len(captions)}"
        )
    return sizes[0]
