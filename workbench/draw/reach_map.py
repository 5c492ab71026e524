"""The picture of a population reach map: bands of the share of people over the part, with its
surroundings as lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from xml.sax.saxutils import escape

import numpy as np

from workbench.draw.camera import Camera, facing, project, to_view
from workbench.draw.contours import kernel_regression, level_loops, median_spacing
from workbench.draw.lines.hidden_lines import surroundings
from workbench.draw.lines.svg import environment_paths
from workbench.draw.marks.layout import layout_marks
from workbench.draw.marks.pictures import svg_bar, svg_marks
from workbench.draw.scene import Mark, Scene
from workbench.model.accommodation import ReachMap
from workbench.model.arrays import Bools, Floats
from workbench.model.environment import Control, Environment

__all__ = ["BANDS", "LEVELS", "map_controls", "reach_map_svg"]

LEVELS = (0.5, 0.9, 0.95, 0.99)
BANDS = ("#f7e4dc", "#fbf0cc", "#dcead0", "#b3d6bd", "#7fbb9f")
"""Colours below the first level, between the levels, and from the last one on: darker is more
people."""
_LINE = "#1f5c46"
_MARGIN = 70
_STEP = 6.0  # [pixels] round the part, between points of the grid
_NEAR = 0.12  # [m] from the points of a map: a control nearer than this belongs to the part
_FRONT = 0.15  # [m] what stands farther before the part than this is cut away
_FONT = 'font-family=\'Helvetica,Arial,sans-serif\' font-size="13" font-weight="700" text-anchor="middle"'


def reach_map_svg(
    found: ReachMap,
    environment: Environment,
    *,
    width: int = 1040,
    sitter: tuple[float, float, float] | None = None,
) -> str:
    """SVG text, `width` pixels wide, of a part seen along its main normal from the sitter's side.

    The shares are spread over a grid by `contours.spread`, 1.3 times the points' spacing wide, and
    shown only where the part faces the viewer. sitter (3,) [m]: on which side the viewer stands.
    Lines at LEVELS carry their share; controls near the part are marked by name.
    """
    camera = _camera(found, environment, (width, sitter))
    near = map_controls(found, environment)
    marks = tuple(Mark(c.at, c.name.replace("_", " "), "point") for c in near)
    alone = _seen_alone(found, environment)
    scene = Scene((), alone, marks, f"Who reaches {found.task.part.replace('_', ' ')}")
    drawn = surroundings(scene, camera, "hidden_line")
    lines = environment_paths(drawn.lines) if drawn is not None else []
    shape = _silhouette(found, alone, camera)
    bands, labels = _bands(found, camera, (shape, _boxes(scene, camera)))
    size = f'viewBox="0 0 {camera.width} {camera.height}" width="{camera.width}" height="{camera.height}"'
    clip = "map-" + "".join(
        letter if letter.isalnum() else "-" for letter in f"{found.task.part}-{found.task.hand}"
    )
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img"><title>{escape(scene.title)}</title>',
            f'<defs><mask id="{clip}"><g fill="#fff" stroke="#fff">{_mask(shape, camera)}</g></mask></defs>',
            f'<rect width="{camera.width}" height="{camera.height}" fill="#fff"/>',
            f'<g mask="url(#{clip})"><rect width="{camera.width}" height="{camera.height}" fill="{BANDS[0]}"/>',
            *bands,
            "</g>",
            *lines,
            *labels,
            *svg_marks(scene, camera),
            *svg_bar(camera),
            "</svg>",
            "",
        ]
    )


def map_controls(found: ReachMap, environment: Environment) -> list[Control]:
    """The controls within 120 mm of a map's points."""
    chosen = []
    for control in environment.controls:
        if len(found.points) and np.linalg.norm(found.points - control.at, axis=1).min() <= _NEAR:
            chosen.append(control)
    return chosen


def _axes(found: ReachMap, sitter: tuple[float, float, float] | None) -> tuple[Floats, Floats]:
    """Unit vectors (3,) to the right and up in the picture: those that `flat` was measured along,
    turned to the sitter's side."""
    points = found.points - found.points.mean(axis=0)
    flat = found.flat - found.flat.mean(axis=0)
    along = np.linalg.lstsq(points, flat, rcond=None)[0].T
    length = np.linalg.norm(along, axis=1)
    if np.any(length < 0.5):  # points on one line: look forward
        return np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    right = along[0] / length[0]
    up = along[1] - (along[1] @ right) * right
    if sitter is not None and (sitter - found.points.mean(axis=0)) @ np.cross(right, up) < 0:
        right = -right
    return right, up / np.linalg.norm(up)


def _camera(
    found: ReachMap, environment: Environment, how: tuple[int, tuple[float, float, float] | None]
) -> Camera:
    """Looks along the part's normal; the part and the controls near it fill the picture's width."""
    width, sitter = how
    right, up = _axes(found, sitter)
    toward = np.cross(right, up)
    part = environment.part(found.task.part)
    corners = environment.vertices[np.unique(environment.edges[_edges(environment, part)])]
    corners = np.concatenate(
        [corners, found.points, *[[c.at] for c in map_controls(found, environment)]]
    )
    seen = corners @ np.array([right, up, toward]).T
    low = seen.min(axis=0)
    high = seen.max(axis=0)
    extent = np.maximum(high - low, 1e-3)
    scale = min((width - 2 * _MARGIN) / extent[0], (0.8 * width - 2 * _MARGIN) / extent[1])
    height = int(np.ceil(extent[1] * scale)) + 2 * _MARGIN
    middle = (low + high) / 2 @ np.array([right, up, toward])
    camera = Camera("panel", right, up, toward, middle, float(scale), width, height)
    front = to_view(camera, found.points)[:, 2].max()
    return replace(camera, cut=float(front) + _FRONT)


def _edges(environment: Environment, part: int) -> slice:
    polygons = environment.polygons(part)
    return slice(
        int(environment.edge_start[polygons.start]), int(environment.edge_start[polygons.stop])
    )


def _seen_alone(found: ReachMap, environment: Environment) -> Environment:
    """The environment with everything hidden but the part itself and what is mounted near its
    points."""
    hidden = np.array(environment.hidden)
    mounted = {control.part for control in map_controls(found, environment)}
    for k, name in enumerate(environment.parts):
        corners = environment.vertices[np.unique(environment.edges[_edges(environment, k)])]
        apart = np.linalg.norm(
            corners[:, None] - found.points[None, :: max(1, len(found.points) // 400)], axis=2
        )
        close = len(corners) > 0 and float(apart.min(axis=1).max()) <= 2 * _NEAR
        hidden[k] |= not (name == found.task.part or name in mounted or close)
    return replace(environment, hidden=hidden)


def _silhouette(found: ReachMap, environment: Environment, camera: Camera) -> list[list[Floats]]:
    """The loops (K, 2) [pixels] of each of the part's polygons that face the viewer."""
    polygons = environment.polygons(environment.part(found.task.part))
    front = facing(camera, environment.normal[polygons], environment.offset[polygons]) > 1e-6
    return [
        [
            project(camera, environment.vertices[loop])[:, :2]
            for loop in _loops(environment, int(polygon))
        ]
        for polygon in np.flatnonzero(front) + polygons.start
    ]


def _mask(shape: list[list[Floats]], camera: Camera) -> str:
    """A silhouette as paths for a mask; the whole picture where nothing faces the viewer."""
    paths = []
    for loops in shape:
        text = "".join(
            "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in loop.tolist()) + "Z" for loop in loops
        )
        paths.append(f'<path fill-rule="evenodd" d="{text}"/>')
    return "".join(paths) or f'<rect width="{camera.width}" height="{camera.height}"/>'


def _inside(shape: list[list[Floats]], points: Floats) -> Bools:
    """(Q,) which of the points (Q, 2) [pixels] lie in a silhouette: an odd number of edges to their
    right."""
    inside = np.zeros(len(points), dtype=np.bool_)
    for loops in shape:
        odd = np.zeros(len(points), dtype=np.bool_)
        for loop in loops:
            for (x0, y0), (x1, y1) in zip(
                loop.tolist(), np.roll(loop, -1, axis=0).tolist(), strict=True
            ):
                crosses = (y0 > points[:, 1]) != (y1 > points[:, 1])
                with np.errstate(divide="ignore", invalid="ignore"):
                    at = x0 + (points[:, 1] - y0) * (x1 - x0) / (y1 - y0)
                odd ^= crosses & (at > points[:, 0])
        inside |= odd
    return inside


def _loops(environment: Environment, polygon: int) -> list[list[int]]:
    """The corners of a polygon's loops."""
    edges = environment.edges[
        environment.edge_start[polygon] : environment.edge_start[polygon + 1]
    ].tolist()
    following: dict[int, list[int]] = {}
    for start, end in edges:
        following.setdefault(start, []).append(end)
    loops = []
    while following:
        start = next(iter(following))
        loop = [start]
        corner = start
        while corner in following:
            ends = following[corner]
            corner = ends.pop()
            if not ends:
                del following[loop[-1]]
            if corner == start:
                break
            loop.append(corner)
        loops.append(loop)
    return loops


def _bands(
    found: ReachMap, camera: Camera, room: tuple[list[list[Floats]], list[tuple[float, ...]]]
) -> tuple[list[str], list[str]]:
    """Filled regions of each level with their lines, and the lines' labels inside a silhouette,
    clear of boxes [pixels]."""
    toward = np.cross(camera.right, camera.up)
    kept = found.normals @ toward > 0.05
    kept = kept if kept.any() else np.ones(len(found.points), dtype=np.bool_)
    points = project(camera, found.points[kept])[:, :2]
    share = found.share[kept]
    columns = np.arange(0, camera.width + _STEP, _STEP)
    rows = np.arange(0, camera.height + _STEP, _STEP)
    places = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    width = max(1.3 * median_spacing(points), _STEP) if len(points) > 1 else _STEP
    field = kernel_regression(points, share, places, width=width).reshape(len(rows), len(columns))
    parts = []
    labels = []
    boxes = list(room[1])
    for level, colour in zip(LEVELS, BANDS[1:], strict=True):
        loops = [loop[:, ::-1] * _STEP for loop in level_loops(field, level - 1e-9)]
        text = "".join(
            "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in loop.tolist()) + "Z" for loop in loops
        )
        if text:
            parts.append(
                f'<path fill="{colour}" fill-rule="evenodd" stroke="{_LINE}" stroke-width="1.4" d="{text}"/>'
            )
            labels += _label(loops, f"{100 * level:.0f} %", (room[0], boxes))
    return parts, labels


def _label(
    loops: Sequence[Floats], text: str, room: tuple[list[list[Floats]], list[tuple[float, ...]]]
) -> list[str]:
    """The share written on its line where it runs over the part, as far as can be from what is
    written already."""
    shape, boxes = room
    line = np.concatenate(list(loops))
    inner = line[_inside(shape, line)] if shape else line
    if not len(inner):
        return []
    box = np.array(boxes).reshape(-1, 4)
    gap = np.maximum(
        np.maximum(box[None, :, :2] - inner[:, None], inner[:, None] - box[None, :, 2:]), 0.0
    )
    free = np.linalg.norm(gap, axis=2).min(axis=1) if len(box) else np.ones(len(inner))
    x, y = inner[int(np.argmax(np.minimum(free, 60.0)))].tolist()
    boxes.append((x - 24, y - 11, x + 24, y + 11))
    return [
        f'<text x="{x:.1f}" y="{y:.1f}" dy=".35em" {_FONT} fill="{_LINE}" stroke="#fff" stroke-width="4" '
        f'stroke-linejoin="round" paint-order="stroke">{text}</text>'
    ]


def _boxes(scene: Scene, camera: Camera) -> list[tuple[float, ...]]:
    """What the controls' dots and labels take up [pixels]."""
    boxes: list[tuple[float, ...]] = []
    for mark in layout_marks(scene, camera):
        (x, y), (u, v), (a, b) = mark.dot, mark.label, mark.half
        boxes += [(x - 6, y - 6, x + 6, y + 6), (u - a, v - b, u + a, v + b)]
    return boxes
