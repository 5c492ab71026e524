"""Polygons hide arcs and lines in vector pictures: exact, by kernels.pictures.hiding, at any size
of picture.

Only opaque parts hide, and only what of them lies behind the cutting plane. Bodies hide the lines
of the environment: a line is cut where it goes behind the outline of a sphere.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, metric_depth, projective_depth, to_view, view_to_pixels
from workbench.draw.clipping import (
    chain_segments,
    clip_segments,
    clip_triangles,
    plane_intersections,
)
from workbench.draw.kernels.occlusion import (
    Occluders,
    hidden_arcs,
    hidden_lines,
    lines_among_balls,
    occluder_planes,
)
from workbench.draw.lines.arcs import Arcs
from workbench.draw.lines.edges import Lines, drawn_edges
from workbench.draw.scene import Scene
from workbench.draw.visibility import cut_depth, projected_disks, triangle_polygons
from workbench.errors import UsageError, one_of
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = [
    "HIDDEN",
    "Surroundings",
    "build_occluders",
    "sections",
    "split_hidden_arcs",
    "surroundings",
    "visible_edge_lines",
]

HIDDEN = ("veiled", "hidden_line")
_BIAS = 1e-3  # [m] a polygon that touches a rim or an edge does not hide it
_AHEAD = np.array([0.0, 0.0, 1.0])
_CELL = 24.0  # [pixels]


class Surroundings(NamedTuple):
    """What vector displays draw of an environment: its triangles as they hide, its visible lines,
    its cut faces."""

    hiders: Occluders
    lines: Lines
    sections: list[list[Floats]]


def surroundings(scene: Scene, camera: Camera, hidden: str) -> Surroundings | None:
    """The environment of a scene as lines, None where there is none. hidden: one of HIDDEN,
    UsageError for others."""
    if hidden not in HIDDEN:
        raise UsageError(f"no style {hidden!r}; {one_of(hidden, HIDDEN)}")
    if scene.environment is None:
        return None
    cut = cut_depth(projected_disks(scene, camera), camera)
    hiders = build_occluders(scene.environment, camera, cut)
    edges, clear = drawn_edges(scene.environment, camera, cut)
    lines = visible_edge_lines(edges, clear, scene, camera, hiders, cut)
    return Surroundings(hiders, lines, sections(scene.environment, camera, cut))


def build_occluders(environment: Environment, camera: Camera, cut: float) -> Occluders:
    """The opaque triangles of an environment as they hide things behind the depth `cut` [m], in a
    grid."""
    part = environment.polygon_part[triangle_polygons(environment)]
    chosen = np.flatnonzero(~environment.hidden[part] & ~environment.see_through[part])
    seen = to_view(camera, environment.vertices)[environment.triangles[chosen]]
    seen, _ = clip_triangles(seen, _AHEAD, min(cut, camera.closest))
    corners = view_to_pixels(camera, seen)
    corners[..., 2] = projective_depth(camera, corners[..., 2])
    low = corners[:, :, :2].min(axis=1)
    high = corners[:, :, :2].max(axis=1)
    here = np.all((high >= 0.0) & (low <= (camera.width, camera.height)), axis=1)
    columns = math.ceil(camera.width / _CELL)
    rows = math.ceil(camera.height / _CELL)
    start, inside = _grid(low[here], high[here], columns, rows)
    planes = occluder_planes(np.ascontiguousarray(corners[here]), _BIAS)
    return Occluders(planes, _CELL, columns, rows, start, inside)


def _grid(low: Floats, high: Floats, columns: int, rows: int) -> tuple[Ints, Ints]:
    """start (columns rows + 1,) and the boxes that meet each cell, row by row."""
    most = np.array([columns - 1, rows - 1])
    first = np.clip(np.floor(low / _CELL).astype(np.int64), 0, most)
    last = np.clip(np.floor(high / _CELL).astype(np.int64), 0, most)
    span = last - first + 1
    count = span[:, 0] * span[:, 1]
    box = np.repeat(np.arange(len(count)), count)
    number = np.arange(len(box)) - np.repeat(np.cumsum(count) - count, count)
    column = first[box, 0] + number % span[box, 0]
    row = first[box, 1] + number // span[box, 0]
    cell = row * columns + column
    order = np.argsort(cell, kind="stable")
    start = np.searchsorted(cell[order], np.arange(columns * rows + 1))
    return start.astype(np.int64), box[order]


def split_hidden_arcs(arcs: Arcs, hiders: Occluders) -> Arcs:
    """The arcs cut where a polygon comes in front of them or goes; those behind one are
    `veiled`."""
    ratio, turn = arcs.squeeze.T
    along = np.column_stack([np.cos(turn), np.sin(turn)]) * arcs.disk[:, 2:]
    across = np.column_stack([-np.sin(turn), np.cos(turn)]) * (arcs.disk[:, 2] * ratio)[:, None]
    rows = [(arcs.disk[:, :2], arcs.depth)] + [
        (way, np.sum(arcs.tilt * way, axis=1)) for way in (along, across)
    ]
    rims = np.stack([np.column_stack(row) for row in rows], axis=1)
    of, angle, hidden = hidden_arcs(rims, arcs.angle, hiders)
    lead = arcs.lead[of].copy()
    lead[angle[:, 0] > arcs.angle[of, 0], 0] = -1
    lead[angle[:, 1] < arcs.angle[of, 1], 1] = -1
    pieces = Arcs._make(column[of] for column in arcs)
    return pieces._replace(angle=angle, lead=lead, veiled=hidden == 1)


def visible_edge_lines(
    edges: Floats, clear: Bools, scene: Scene, camera: Camera, hiders: Occluders, cut: float
) -> Lines:
    """The pieces of edges (M, 2, 3) x, y [pixels], depth [m] behind the depth `cut` that nothing
    hides.

    A piece is faint where it is of a see-through part (clear) or in front of a body. What is beside
    the picture is left out.
    """
    edges = np.concatenate([edges[:, :, :2], projective_depth(camera, edges[:, :, 2:])], axis=2)
    seen, kept = clip_segments(_from_picture(camera, edges), _AHEAD, cut + _BIAS)
    ends = view_to_pixels(camera, seen)
    ends[..., 2] = projective_depth(camera, ends[..., 2])
    low = ends[:, :, :2].min(axis=1)
    high = ends[:, :, :2].max(axis=1)
    here = np.all((high >= 0.0) & (low <= (camera.width, camera.height)), axis=1)
    ends = ends[here]
    kept = kept[here]
    of, share, hidden = hidden_lines(np.ascontiguousarray(ends), hiders)
    of = of[hidden == 0]
    share = share[hidden == 0]
    pieces = ends[of, :1] * (1.0 - share[:, :, None]) + ends[of, 1:] * share[:, :, None]
    seen = _from_picture(camera, pieces)
    spheres = scene.spheres
    balls = np.column_stack([to_view(camera, spheres.centre), spheres.radius])
    rows = lines_among_balls(np.ascontiguousarray(seen), balls, camera.distance)
    which = rows[:, 0].astype(np.int64)
    share = rows[:, 1:3, None]
    drawn = view_to_pixels(camera, seen[which, :1] * (1.0 - share) + seen[which, 1:] * share)
    return Lines(
        drawn[:, :, :2], drawn[:, :, 2].mean(axis=1), clear[kept[of[which]]] | (rows[:, 3] == 1.0)
    )


def _from_picture(camera: Camera, points: Floats) -> Floats:
    """View coordinates (..., 3) [m] of x, y [pixels] and projective depth (..., 3)."""
    depth = metric_depth(camera, points[..., 2])
    size = camera.scale / (1.0 - depth * camera.inverse_distance)
    x = (points[..., 0] - camera.width / 2.0) / size
    y = (camera.height / 2.0 - points[..., 1]) / size
    return np.stack([x, y, depth], axis=-1)


def sections(environment: Environment, camera: Camera, cut: float) -> list[list[Floats]]:
    """Where the plane at depth `cut` [m] goes through solid parts: of each part its loops (K, 2)
    [pixels].

    To be filled by the even-odd rule. Nothing for a plane at infinity.
    """
    if not math.isfinite(cut):
        return []
    part = environment.polygon_part[triangle_polygons(environment)]
    solid = environment.solid & ~environment.hidden & ~environment.see_through
    seen = to_view(camera, environment.vertices)
    found = []
    for number in np.flatnonzero(solid):
        lines, _ = plane_intersections(seen[environment.triangles[part == number]], _AHEAD, cut)
        found.append([view_to_pixels(camera, loop)[:, :2] for loop in chain_segments(lines)])
    return [loops for loops in found if loops]
