"""Write what all vector displays have in common as SVG: the page and the environment's lines."""

from __future__ import annotations

import re
from collections.abc import Iterable
from xml.sax.saxutils import escape

import numpy as np

from workbench.draw.camera import Camera
from workbench.draw.colours import PAPER, SECTION, hexadecimal
from workbench.draw.lines.edges import Lines
from workbench.draw.marks.pictures import svg_bar, svg_key, svg_marks
from workbench.draw.scene import Scene
from workbench.errors import InputError
from workbench.model.arrays import Floats

__all__ = ["closed_paths", "environment_paths", "number_rows", "page", "section_paths"]

_FIELD = re.compile(r"\{:\.(\d)f\}")
_MAX_COORDINATE = 1e9
"""[pixels]."""
_MAX_LINES = 9000
"""Number of pieces of lines that keeps a picture under 400 kB."""


def number_rows(pattern: str, values: Floats) -> list[str]:
    """Write each row of numbers as text.

    Parameters
    ----------
    pattern
        K fields such as {:.2f}, with other text around them.
    values
        (M, K) numbers.

    Returns
    -------
    list[str]
        M texts. Halves are rounded away from zero; zero has no sign.

    Raises
    ------
    InputError
        If a number is not finite, or is a billion or more.
    """
    if not np.all(np.abs(values) < _MAX_COORDINATE):
        raise InputError("a drawing needs finite coordinates below a billion pixels")
    unit = 10.0 ** np.array([int(places) for places in _FIELD.findall(pattern)])
    size = np.floor(np.abs(values) * unit + 0.5) / unit
    rounded = np.where(values < 0, -size, size) + 0.0  # -0 becomes 0
    return [pattern.format(*row) for row in rounded.tolist()]


def closed_paths(loops: Iterable[Floats]) -> str:
    """Write path commands of closed loops (K, 2) [pixels]."""
    texts = ("L".join(f"{x:.1f} {y:.1f}" for x, y in loop.tolist()) for loop in loops)
    return "".join(f"M{text}Z" for text in texts)


def page(scene: Scene, camera: Camera, what: str, parts: Iterable[str]) -> str:
    """Write a whole SVG text: parts on white paper, then marks, legend and scale bar.

    It holds no script and no reference to anything outside.

    Parameters
    ----------
    scene, camera
        What is drawn, and the size of the picture.
    what
        Description of the display for those who cannot see it.
    parts
        SVG elements.
    """
    width = camera.width
    height = camera.height
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}"'
            f' height="{height}" role="img">',
            f"<title>{escape(scene.title)}</title>",
            f"<desc>{escape(scene.description or _description(scene, camera, what))}</desc>",
            f'<rect width="{width}" height="{height}" fill="{hexadecimal(PAPER)}"/>',
            *parts,
            *svg_marks(scene, camera),
            *svg_key(scene, camera),
            *svg_bar(camera),
            "</svg>",
            "",
        ]
    )


def _description(scene: Scene, camera: Camera, what: str) -> str:
    """Describe a picture for readers who cannot see it."""
    where = f" in {scene.environment.name}" if scene.environment is not None else ""
    names = ", ".join(shown.placed.body.name for shown in scene.bodies) or "no body"
    view = camera.name.replace("_", "-")
    return f"{names}{where}, {view} view: {what}; {len(scene.marks)} points marked."


def environment_paths(lines: Lines) -> list[str]:
    """Return a group of two paths, faint and plain lines. Of more than 9,000 the longest stay."""
    length = np.linalg.norm(lines.ends[:, 1] - lines.ends[:, 0], axis=1)
    kept = np.sort(np.argsort(-length, kind="stable")[:_MAX_LINES])
    parts = ['<g class="environment" fill="none" stroke-linecap="round" stroke="#8d99a8">']
    for faint, style in (
        (True, 'stroke-width="0.6" stroke-opacity="0.45"'),
        (False, 'stroke-width="0.8"'),
    ):
        chosen = lines.ends[kept[lines.faint[kept] == faint]].reshape(-1, 4)
        if len(chosen):
            path = "".join(number_rows("M{:.1f} {:.1f}L{:.1f} {:.1f}", chosen))
            parts.append(f'<path {style} d="{path}"/>')
    return [*parts, "</g>"]


def section_paths(sections: list[list[Floats]], hidden: str) -> list[str]:
    """Return a group of the cut faces of solids.

    Parameters
    ----------
    sections
        Loops (K, 2) [pixels] of each part.
    hidden
        The style of hidden lines; cut faces are opaque in hidden_line.
    """
    if not sections:
        return []
    opacity = 1.0 if hidden == "hidden_line" else 0.7
    style = f'fill="{hexadecimal(SECTION)}" fill-opacity="{opacity:g}"'
    group = f'<g class="section" {style} fill-rule="evenodd" stroke="#8d99a8" stroke-width="0.8">'
    return [group, *(f'<path d="{closed_paths(loops)}"/>' for loops in sections), "</g>"]
