"""Write the straight lines of a drawing with fewer bytes, for pages that hold many drawings.

A drawing of an environment is thousands of lines, each with both its ends. On a page

1. lines of no length and lines that stand there twice go;
2. lines that meet at an end become one polyline, and two of them that go on in the same direction
   become one line;
3. points are written as differences from the point before.

Coordinates stay whole tenths of a pixel, so that every line is where it was. What is drawn stays
alike but for corners, which are closed where two lines had left a notch.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise

__all__ = ["compacted"]

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
