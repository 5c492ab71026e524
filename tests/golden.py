"""The pictures of tests/data/golden: each vector display with what it can show. python -m
tests.golden renews them.

Look at every picture that changes before it is committed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from tests.test_draw import BOX, boxes, spheres_body
from workbench.draw.camera import Camera, standard_view
from workbench.draw.films.strip import strip_svg
from workbench.draw.lines.circles import circles
from workbench.draw.lines.outline import outline
from workbench.draw.scene import Mark, Scene

__all__ = ["FOLDER", "PICTURES"]

FOLDER = Path(__file__).resolve().parent / "data" / "golden"
ARM = spheres_body([[0, -0.6, 0], [0.1, -0.25, 0.1], [0.2, 0.1, 0.15], [0.5, 0.4, 0.3], [0.55, 0.6, 0.45]],
                   [0.35, 0.3, 0.25, 0.2, 0.12])  # fmt: skip
ROOM = boxes([[-0.9, -0.9, -0.9], [0.9, 0.9, -0.45]], [[0.3, -0.5, -0.45], [0.45, -0.1, 0.35]])
OTHER = replace(spheres_body([[0, 0, 0], [0, 0.4, 0.5]], [0.4, 0.3]), colour="blue")
SCENES = {
    "alone": Scene((ARM,), title="an arm"),
    "in_a_room": Scene((ARM,), ROOM, title="an arm & a room"),
    "marked": Scene(
        (ARM,),
        marks=(
            Mark((0.5, 0.4, 0.5), "<12.4 mm>", "contact"),
            Mark((0.2, -0.7, -0.8), "80.0 mm", "clearance", (0.2, 0.6, -0.8)),
            Mark((0, -0.6, 0), "", "reach"),
            Mark((0, 0, 0), "x", "axis_x", (0.0, 0.9, 0.0)),
        ),
    ),
    "over_another": Scene((ARM,), ghosts=(OTHER,), key=(("predicted", "warm"), ("actual", "blue"))),
}


def _front(field: float = 0.0) -> Camera:
    return standard_view("front", BOX, width=200, height=200, field=field)


def _strip() -> str:
    ways = [(0.5 * math.cos(turn), 0.5 * math.sin(turn)) for turn in (0.0, 0.8)]
    bodies = [spheres_body([[0.0, 0.0, 0.0], [0.0, y, z]], [0.4, 0.25]) for y, z in ways]
    return strip_svg(
        [outline(Scene((body,)), _front()) for body in bodies], ["0 ms", "<50> ms"], title="a strip"
    )


PICTURES: Mapping[str, Callable[[], str]] = {
    "outline": lambda: outline(SCENES["alone"], _front()),
    "outline_perspective": lambda: outline(SCENES["alone"], _front(0.8)),
    "outline_in_a_room": lambda: outline(SCENES["in_a_room"], _front(), hidden="hidden_line"),
    "outline_marked": lambda: outline(SCENES["marked"], _front()),
    "outline_over_another": lambda: outline(SCENES["over_another"], _front()),
    "circles": lambda: circles(SCENES["alone"], _front()),
    "circles_in_a_room": lambda: circles(SCENES["in_a_room"], _front()),
    "ellipses_in_a_room": lambda: circles(SCENES["in_a_room"], _front(0.8), exact=True),
    "strip": _strip,
}


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, picture in PICTURES.items():
        (FOLDER / f"{name}.svg").write_text(picture())
