"""One picture as a file: PNG of disks, SVG of circles or of outlines."""

from __future__ import annotations

import io

from workbench.draw.camera import standard_view
from workbench.draw.circles import circles
from workbench.draw.disks import disks
from workbench.draw.outline import outline
from workbench.draw.scene import Scene
from workbench.draw.views import four_views
from workbench.errors import UsageError, one_of

__all__ = ["ENDINGS", "STYLES", "render"]

ENDINGS = {"disks": ".png", "circles": ".svg", "outline": ".svg"}  # of the files of each style
STYLES = tuple(ENDINGS)


def render(scene: Scene, *, view: str = "three_quarter", style: str = "disks", size: int = 800) -> bytes:
    """The bytes of a picture, size x size pixels: PNG for disks, SVG for circles and outline.

    view: a standard view. UsageError for an unknown view or style or a size beyond 16 to 8192.
    """
    if style not in STYLES:
        raise UsageError(f"no style {style!r}; {one_of(style, STYLES)}")
    if not 16 <= size <= 8192:
        raise UsageError(f"a picture of 16 to 8192 pixels is possible, got {size}")
    framed = dict(four_views(scene, width=size, height=size))
    camera = framed.get(view) or standard_view(view, scene.bounds, width=size, height=size)
    if style == "circles":
        return circles(scene, camera).encode()
    if style == "outline":
        return outline(scene, camera).encode()
    out = io.BytesIO()
    disks(scene, camera).save(out, "PNG", optimize=True)
    return out.getvalue()
