"""Draw a population reach map: contour bands of the share of people over a part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from xml.sax.saxutils import escape

import numpy as np

from workbench.draw.camera import Camera, facing, project, to_view
from workbench.draw.contours import kernel_regression, level_loops, median_spacing
from workbench.draw.lines.hidden_lines import surroundings
from workbench.draw.lines.svg import closed_paths, environment_paths
from workbench.draw.marks.layout import FONT, layout_marks
from workbench.draw.marks.pictures import svg_bar, svg_marks
from workbench.draw.scene import Mark, Scene
from workbench.geometry.polygon import inside_loops
from workbench.model.accommodation import ReachMap
from workbench.model.arrays import Bools, Floats
from workbench.model.environment import Control, Environment
from workbench.model.units import plain

__all__ = ["BANDS", "LEVELS", "map_controls", "reach_map_svg"]

LEVELS = (0.5, 0.9, 0.95, 0.99)
"""Shares of people that have a contour line."""
BANDS = ("#f7e4dc", "#fbf0cc", "#dcead0", "#b3d6bd", "#7fbb9f")
"""Colours below the first level, between the levels, and from the last one on: darker is more
people."""
_LINE = "#1f5c46"
_MARGIN = 70
"""Border [pixels] around the part."""
_GRID_STEP = 6.0
"""Distance [pixels] between the points of the grid that is contoured."""
_PART_DISTANCE = 0.12
"""Distance [m] from the points of a map within which a control belongs to the part."""
_VIEW_DISTANCE = 0.15
"""Distance [m] before the part beyond which everything is cut away."""
_KERNEL_WIDTH = 1.3
"""Width of the smoothing kernel, as a multiple of the spacing of the points."""
_MIN_FACING = 0.05
"""Least component of a point's normal toward the viewer."""
_MAX_SAMPLES = 400
"""Approximate number of points of the map that distances of parts are measured from."""
_LABEL_TEXT = f'{FONT} font-size="13" font-weight="700" text-anchor="middle"'

_Box = tuple[float, float, float, float]
_Silhouette = list[list[Floats]]
"""Loops (K, 2) [pixels] of each polygon of a part that faces the viewer."""


def reach_map_svg(
    reach_map: ReachMap,
    environment: Environment,
    *,
    width: int = 1040,
    sitter: tuple[float, ...] | None = None,
) -> str:
    """Draw a part along its main normal, with contour bands of the share of people who reach it.

    The shares are spread over a grid by kernel regression and shown only where the part faces the
    viewer. Lines at `LEVELS` carry their share. Controls near the part are marked by name.

    Parameters
    ----------
    reach_map, environment
        The map and its environment.
    width
        Width of the picture [pixels].
    sitter
        (3,) point [m] of the person; the viewer stands on this side of the part.

    Returns
    -------
    str
        SVG text.
    """
    task = reach_map.task
    camera = _panel_camera(reach_map, environment, width, sitter)
    controls = map_controls(reach_map, environment)
    marks = tuple(Mark(c.at, plain(c.name), "point") for c in controls)
    alone = _only_near_parts(reach_map, environment)
    scene = Scene((), alone, marks, f"Who {'sees' if task.sees else 'reaches'} {plain(task.part)}")
    drawn = surroundings(scene, camera, "hidden_line")
    silhouette = _silhouette(reach_map, alone, camera)
    bands, labels = _contour_bands(
        reach_map, camera, _Labels(silhouette, _mark_boxes(scene, camera))
    )
    name = f"{task.part}-{task.hand}"
    clip = "map-" + "".join(letter if letter.isalnum() else "-" for letter in name)
    size = f'width="{camera.width}" height="{camera.height}"'
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {camera.width} {camera.height}" '
            f'{size} role="img"><title>{escape(scene.title)}</title>',
            f'<defs><mask id="{clip}"><g fill="#fff" stroke="#fff">{_mask(silhouette, camera)}</g></mask></defs>',
            f'<rect {size} fill="#fff"/>',
            f'<g mask="url(#{clip})"><rect {size} fill="{BANDS[0]}"/>',
            *bands,
            "</g>",
            *(environment_paths(drawn.lines) if drawn is not None else []),
            *labels,
            *svg_marks(scene, camera),
            *svg_bar(camera),
            "</svg>",
            "",
        ]
    )


def map_controls(reach_map: ReachMap, environment: Environment) -> list[Control]:
    """Return the controls within 120 mm of the points of a map."""
    points = reach_map.points
    return [
        control
        for control in environment.controls
        if len(points) and np.linalg.norm(points - control.at, axis=1).min() <= _PART_DISTANCE
    ]


def _picture_axes(reach_map: ReachMap, sitter: tuple[float, ...] | None) -> tuple[Floats, Floats]:
    """Return unit vectors (3,) to the right and up: the axes of the map's flat coordinates, seen
    from the sitter's side."""
    points = reach_map.points - reach_map.points.mean(axis=0)
    flat = reach_map.flat - reach_map.flat.mean(axis=0)
    axes = np.linalg.lstsq(points, flat, rcond=None)[0].T  # flat = points @ axes.T
    length = np.linalg.norm(axes, axis=1)
    if np.any(length < 0.5):  # the points lie on one line: look forward
        return np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    right = axes[0] / length[0]
    up = axes[1] - (axes[1] @ right) * right
    if sitter is not None and (sitter - reach_map.points.mean(axis=0)) @ np.cross(right, up) < 0:
        right = -right
    return right, up / np.linalg.norm(up)


def _panel_camera(
    reach_map: ReachMap, environment: Environment, width: int, sitter: tuple[float, ...] | None
) -> Camera:
    """Return a camera along the part's normal; the part and its controls fill the width."""
    right, up = _picture_axes(reach_map, sitter)
    axes = np.array([right, up, np.cross(right, up)])
    part = environment.part_index(reach_map.task.part)
    controls = [[control.at] for control in map_controls(reach_map, environment)]
    points = np.concatenate([_part_corners(environment, part), reach_map.points, *controls])
    seen = points @ axes.T
    low = seen.min(axis=0)
    high = seen.max(axis=0)
    extent = np.maximum(high - low, 1e-3)
    scale = min((width - 2 * _MARGIN) / extent[0], (0.8 * width - 2 * _MARGIN) / extent[1])
    height = int(np.ceil(extent[1] * scale)) + 2 * _MARGIN
    camera = Camera(
        "panel", right, up, axes[2], (low + high) / 2 @ axes, float(scale), width, height
    )
    front = to_view(camera, reach_map.points)[:, 2].max()
    return replace(camera, cut=float(front) + _VIEW_DISTANCE)


def _part_corners(environment: Environment, part: int) -> Floats:
    """Return the corners (V, 3) [m] of a part."""
    polygons = environment.polygons(part)
    first, last = environment.edge_start[[polygons.start, polygons.stop]]
    return environment.vertices[np.unique(environment.edges[first:last])]


def _only_near_parts(reach_map: ReachMap, environment: Environment) -> Environment:
    """Hide everything but the part of the map and what is mounted near its points."""
    hidden = np.array(environment.hidden)
    near_ones = map_controls(reach_map, environment)
    mounted = {part for control in near_ones for part in control.own_parts}
    samples = reach_map.points[:: max(1, len(reach_map.points) // _MAX_SAMPLES)]
    for part, name in enumerate(environment.parts):
        corners = _part_corners(environment, part)
        distance = np.linalg.norm(corners[:, None] - samples[None], axis=2)
        near = len(corners) > 0 and float(distance.min(axis=1).max()) <= 2 * _PART_DISTANCE
        hidden[part] |= not (name == reach_map.task.part or name in mounted or near)
    return replace(environment, hidden=hidden)


def _silhouette(reach_map: ReachMap, environment: Environment, camera: Camera) -> _Silhouette:
    """Project the polygons of the part that face the viewer."""
    polygons = environment.polygons(environment.part_index(reach_map.task.part))
    front = facing(camera, environment.normal[polygons], environment.offset[polygons]) > 1e-6
    return [
        [
            project(camera, environment.vertices[loop])[:, :2]
            for loop in _polygon_loops(environment, int(polygon))
        ]
        for polygon in np.flatnonzero(front) + polygons.start
    ]


def _mask(silhouette: _Silhouette, camera: Camera) -> str:
    """Write a silhouette as SVG paths; the whole picture if nothing faces the viewer."""
    paths = [f'<path fill-rule="evenodd" d="{closed_paths(loops)}"/>' for loops in silhouette]
    return "".join(paths) or f'<rect width="{camera.width}" height="{camera.height}"/>'


def _in_silhouette(silhouette: _Silhouette, points: Floats) -> Bools:
    """Return which (Q,) of the points (Q, 2) [pixels] lie in a polygon."""
    inside = np.zeros(len(points), dtype=np.bool_)
    for loops in silhouette:
        inside |= inside_loops(points, loops)
    return inside


def _polygon_loops(environment: Environment, polygon: int) -> list[list[int]]:
    """Chain the directed edges of a polygon into loops of vertices."""
    first, last = environment.edge_start[[polygon, polygon + 1]]
    following: dict[int, list[int]] = {}
    for start, end in environment.edges[first:last].tolist():
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


@dataclass(frozen=True, eq=False)
class _Labels:
    """Where contour labels may go: inside the silhouette and clear of the boxes."""

    silhouette: _Silhouette
    boxes: list[_Box] = field(default_factory=list)
    """Boxes [pixels] that are taken: left, top, right, bottom."""


def _contour_bands(
    reach_map: ReachMap, camera: Camera, placing: _Labels
) -> tuple[list[str], list[str]]:
    """Return SVG paths of the filled region of each level, and the labels of their lines."""
    toward = np.cross(camera.right, camera.up)
    front = reach_map.normals @ toward > _MIN_FACING
    front = front if front.any() else np.ones(len(reach_map.points), dtype=np.bool_)
    points = project(camera, reach_map.points[front])[:, :2]
    share = _share_grid(points, reach_map.share[front], camera)
    bands = []
    labels = []
    for level, colour in zip(LEVELS, BANDS[1:], strict=True):
        loops = [loop[:, ::-1] * _GRID_STEP for loop in level_loops(share, level - 1e-9)]
        if loops:
            bands.append(
                f'<path fill="{colour}" fill-rule="evenodd" stroke="{_LINE}" stroke-width="1.4" '
                f'd="{closed_paths(loops)}"/>'
            )
            labels += _contour_label(loops, f"{100 * level:.0f} %", placing)
    return bands, labels


def _share_grid(points: Floats, share: Floats, camera: Camera) -> Floats:
    """Spread shares (M,) at points (M, 2) [pixels] over a grid (rows, columns) of the picture."""
    columns = np.arange(0, camera.width + _GRID_STEP, _GRID_STEP)
    rows = np.arange(0, camera.height + _GRID_STEP, _GRID_STEP)
    places = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    width = _GRID_STEP
    if len(points) > 1:
        width = max(_KERNEL_WIDTH * median_spacing(points), _GRID_STEP)
    return kernel_regression(points, share, places, width=width).reshape(len(rows), len(columns))


def _contour_label(loops: Sequence[Floats], text: str, placing: _Labels) -> list[str]:
    """Write a share on its line: over the part, and as far as possible from other labels."""
    line = np.concatenate(list(loops))
    inner = line[_in_silhouette(placing.silhouette, line)] if placing.silhouette else line
    if not len(inner):
        return []
    box = np.array(placing.boxes).reshape(-1, 4)
    gap = np.maximum(
        np.maximum(box[None, :, :2] - inner[:, None], inner[:, None] - box[None, :, 2:]), 0.0
    )
    free = np.linalg.norm(gap, axis=2).min(axis=1) if len(box) else np.ones(len(inner))
    x, y = inner[int(np.argmax(np.minimum(free, 60.0)))].tolist()
    placing.boxes.append((x - 24, y - 11, x + 24, y + 11))
    return [
        f'<text x="{x:.1f}" y="{y:.1f}" dy=".35em" {_LABEL_TEXT} fill="{_LINE}" stroke="#fff" stroke-width="4" '
        f'stroke-linejoin="round" paint-order="stroke">{text}</text>'
    ]


def _mark_boxes(scene: Scene, camera: Camera) -> list[_Box]:
    """Return the boxes [pixels] of the controls' dots and labels."""
    boxes: list[_Box] = []
    for mark in layout_marks(scene, camera):
        (x, y), (u, v), (a, b) = mark.dot, mark.label, mark.half
        boxes += [(x - 6, y - 6, x + 6, y + 6), (u - a, v - b, u + a, v + b)]
    return boxes
