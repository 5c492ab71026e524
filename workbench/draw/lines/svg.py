"""Write what all vector displays have in common as SVG: the page and the environment's lines; and make
a picture smaller."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from xml.sax.saxutils import escape

import numpy as np

from workbench.draw.camera import Camera
from workbench.draw.lines.edges import Lines
from workbench.draw.marks.pictures import svg_bar, svg_key, svg_marks
from workbench.draw.scene import PAPER, SECTION, Scene, hexadecimal
from workbench.errors import InputError
from workbench.model.arrays import Floats

__all__ = ["closed_paths", "compacted", "environment_paths", "number_rows", "page", "section_paths"]

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


# Write the straight lines of a drawing with fewer bytes, for pages that hold many drawings.
#
# A drawing of an environment is thousands of lines, each with both its ends. On a page
#
# 1. lines of no length and lines that stand there twice go;
# 2. lines that meet at an end become one polyline, and two of them that go on in the same direction
#    become one line;
# 3. points are written as differences from the point before.
#
# Coordinates stay whole tenths of a pixel, so that every line is where it was. What is drawn stays
# alike but for corners, which are closed where two lines had left a notch.

Point = tuple[int, int]
"""x and y [tenths of a pixel]."""
_NUMBER = r"-?\d+\.\d"
_PATH = re.compile(rf' d="((?:M{_NUMBER} {_NUMBER}L{_NUMBER} {_NUMBER})+)"')
_LINE = re.compile(rf"M({_NUMBER}) ({_NUMBER})L({_NUMBER}) ({_NUMBER})")


def compacted(svg: str) -> str:
    """Return a drawing with the same lines in fewer bytes; curves stay as they are."""
    return _PATH.sub(lambda found: f' d="{_path(found[1])}"', svg)


def _path(text: str) -> str:
    lines = [tuple(map(_tenths, found)) for found in _LINE.findall(text)]
    ends = [((a, b), (c, d)) for a, b, c, d in lines]
    return "".join(_written(_polylines(ends)))


def _tenths(number: str) -> int:
    """ "-12.3" as -123."""
    return int(number.replace(".", ""))


def _polylines(lines: Sequence[tuple[Point, Point]]) -> Iterator[list[Point]]:
    """Join lines that meet at their ends, each once, in the order in which they begin."""
    left = dict.fromkeys((min(line), max(line)) for line in lines if line[0] != line[1])
    at: dict[Point, list[Point]] = {}
    for one, other in left:
        at.setdefault(one, []).append(other)
        at.setdefault(other, []).append(one)
    for line in list(left):
        if line not in left:
            continue
        del left[line]
        polyline = list(line)
        for _ in range(2):  # on at the one end, then at the other
            while (after := _after(polyline[-1], at, left)) is not None:
                del left[min(polyline[-1], after), max(polyline[-1], after)]
                polyline.append(after)
            polyline.reverse()
        yield _straightened(polyline)


def _after(
    end: Point, at: dict[Point, list[Point]], left: dict[tuple[Point, Point], None]
) -> Point | None:
    """Where a line that is left leads from a point; None where none begins."""
    return next((to for to in at[end] if (min(end, to), max(end, to)) in left), None)


def _straightened(polyline: list[Point]) -> list[Point]:
    """Leave out the points at which a polyline goes straight on."""
    kept = polyline[:1]
    for point, after in pairwise(polyline[1:]):
        x, y = point[0] - kept[-1][0], point[1] - kept[-1][1]
        u, v = after[0] - point[0], after[1] - point[1]
        if x * v != y * u or x * u + y * v < 0:
            kept.append(point)
    return [*kept, polyline[-1]]


def _written(polylines: Iterator[list[Point]]) -> Iterator[str]:
    """The commands of a path."""
    pen = (0, 0)
    for polyline in polylines:
        for k, point in enumerate(polyline):
            x = point[0] - pen[0]
            lead = "m" if k == 0 else "" if x < 0 else " "
            yield f"{lead}{_number(x)}{_spaced(point[1] - pen[1])}"
            pen = point


def _spaced(tenths: int) -> str:
    """A number behind another one."""
    return _number(tenths) if tenths < 0 else f" {_number(tenths)}"


def _number(tenths: int) -> str:
    """ ".3" of 3, "-1.2" of -12, "4" of 40."""
    whole, rest = divmod(abs(tenths), 10)
    text = (f"{whole}.{rest}" if whole else f".{rest}") if rest else f"{whole}"
    return f"-{text}" if tenths < 0 else text
