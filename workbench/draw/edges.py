"""The lines that draw an environment: feature edges, silhouettes, cut edges; and what of them is visible.

A feature edge is an open edge of a part, or one between two polygons that meet at more than FEATURE_ANGLE. A
silhouette is an edge between a polygon that faces the viewer and one that does not. A cut edge is where the cutting
plane of the view goes through a triangle.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, facing, in_view, metric, projective, to_picture
from workbench.draw.clipping import clip_segments, cut_lines
from workbench.draw.visibility import Layers, triangle_polygons
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = ["FEATURE_ANGLE", "Lines", "drawn_edges", "visible_lines"]

FEATURE_ANGLE = np.radians(25.0)
_WELD = 1e-5  # [m] corners nearer than about this are one: some mesh files hold a copy for each face
_STEP = 2.0  # [pixels] between the points at which an edge is tested
_BIAS = 1e-3  # [m] an edge lies on its own surface: so much in front counts as visible


class Lines(NamedTuple):
    """Visible pieces of edges: ends (M, 2, 2) x, y [pixels]; depth (M,) [m]; faint (M,): seen through or as a veil."""

    ends: Floats
    depth: Floats
    faint: Bools


class _Sides(NamedTuple):
    """Undirected edges of parts that are shown: corners (M, 2) vertices; clear (M,): of a see-through part.

    first, second (M,): the polygons on both sides; sense (M,): 1 where they are wound alike, -1 where not, 0
    where there are not two; always (M,): drawn from wherever it is seen, as an open or sharp edge.
    """

    corners: Ints
    clear: Bools
    first: Ints
    second: Ints
    sense: Floats
    always: Bools


def drawn_edges(environment: Environment, camera: Camera, cut: float) -> tuple[Floats, Bools]:
    """Edges (M, 2, 3) x, y [pixels], depth [m] to be drawn in this view, and whether each is of a see-through part.

    cut [m]: the depth of the cutting plane. Edges are cut where they come too near the eye.
    """
    sides = _sides(environment)
    front = facing(camera, environment.normal, environment.offset)
    turned = front[sides.first] * front[sides.second] * sides.sense < 0.0
    wanted = np.flatnonzero(sides.always | turned)
    seen = in_view(camera, environment.vertices)
    ahead = np.array([0.0, 0.0, 1.0])
    edges, kept = clip_segments(seen[sides.corners[wanted]], ahead, camera.closest)
    clear = sides.clear[wanted[kept]]
    if np.isfinite(cut):
        part = environment.polygon_part[triangle_polygons(environment)]
        shown = np.flatnonzero(~environment.hidden[part])
        cut_edges, of = cut_lines(seen[environment.triangles[shown]], ahead, cut)
        edges, clear = np.concatenate([edges, cut_edges]), np.append(clear, environment.see_through[part[shown[of]]])
    return to_picture(camera, edges), clear


@lru_cache(maxsize=8)
def _sides(environment: Environment) -> _Sides:
    """Pair the polygons' directed edges within each part; remembered, for it is the same in every view."""
    grid = np.round(environment.vertices / _WELD).astype(np.int64)
    _, welded = np.unique(grid, axis=0, return_inverse=True)
    polygon = np.repeat(np.arange(len(environment.normal)), np.diff(environment.edge_start))
    part = environment.polygon_part[polygon]
    ends = welded.reshape(-1)[environment.edges]
    count = np.int64(len(environment.vertices))
    key = (part * count + ends.min(axis=1)) * count + ends.max(axis=1)
    order = np.argsort(key, kind="stable")
    order = order[ends[order, 0] != ends[order, 1]]
    start = np.flatnonzero(np.diff(key[order], prepend=-1))
    members = np.diff(start, append=len(order))
    first = order[start]
    second = order[np.minimum(start + 1, max(len(order) - 1, 0))]
    against = ends[first, 0] == ends[second, 1]  # two neighbours of one winding run along their edge in two directions
    lone = members != 2
    sense = np.where(lone, 0.0, np.where(against, 1.0, -1.0))
    one, other = environment.normal[polygon[first]], environment.normal[polygon[second]] * sense[:, None]
    sharp = lone | (np.sum(one * other, axis=1) < np.cos(FEATURE_ANGLE))
    shown = np.flatnonzero(~environment.hidden[part[first]])
    clear = environment.see_through[part[first]]
    columns = (environment.edges[first], clear, polygon[first], polygon[second], sense, sharp)
    return _Sides(*(column[shown] for column in columns))


def visible_lines(edges: Floats, clear: Bools, layers: Layers) -> Lines:
    """The pieces of edges (M, 2, 3) that no opaque surface hides, tested every two pixels or closer.

    A piece is faint where it is of a see-through part or in front of a body, and is left out behind a body.
    """
    height, width = layers.depth.shape
    low, high = edges[:, :, :2].min(axis=1), edges[:, :, :2].max(axis=1)
    inside = np.all((high >= 0) & (low <= (width, height)), axis=1) & (edges[:, :, 2].min(axis=1) <= layers.cut + _BIAS)
    edges, clear = edges[inside], clear[inside]
    length = np.linalg.norm(edges[:, 1, :2] - edges[:, 0, :2], axis=1)
    count = np.ceil(length / _STEP).astype(np.int64) + 2
    edge = np.repeat(np.arange(len(edges)), count)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    share = (step / (count[edge] - 1))[:, None]
    edges = np.concatenate([edges[:, :, :2], projective(layers.camera, edges[:, :, 2:])], axis=2)
    points = edges[edge, 0] * (1.0 - share) + edges[edge, 1] * share
    points[:, 2] = metric(layers.camera, points[:, 2])
    state = _states(points, clear[edge], layers)
    fresh = (np.diff(state, prepend=-1) != 0) | (step == 0)
    start = np.flatnonzero(fresh)
    last = np.append(start[1:], len(state))[: len(start)] - 1
    shown = (state[start] > 0) & (last > start)
    start, last = start[shown], last[shown]
    ends = np.stack([points[start, :2], points[last, :2]], axis=1)
    return Lines(ends, (points[start, 2] + points[last, 2]) / 2.0, state[start] == 1)


def _states(points: Floats, clear: Bools, layers: Layers) -> Ints:
    """0 hidden, 1 faint, 2 plain for points (M, 3) x, y [pixels], depth [m]."""
    height, width = layers.depth.shape
    column, row = np.floor(points[:, 0]).astype(np.int64), np.floor(points[:, 1]).astype(np.int64)
    state = np.zeros(len(points), dtype=np.int64)
    here = (column >= 0) & (column < width) & (row >= 0) & (row < height) & (points[:, 2] <= layers.cut + _BIAS)
    at, depth = (row[here], column[here]), points[here, 2]
    free = depth >= _farthest_around(layers.depth, at) - _BIAS
    body = layers.sphere[at] >= 0
    behind = body & (depth < layers.body_depth[at])
    state[here] = np.where(free & ~behind, np.where(body | clear[here], 1, 2), 0)
    return state


def _farthest_around(depth: Floats, at: tuple[Ints, Ints]) -> Floats:
    """The least depth among pixels (row, column) and their eight neighbours: no surface hides its own edge."""
    row, column = at
    least = np.full(len(row), np.inf)
    for down in (-1, 0, 1):
        near = np.clip(row + down, 0, depth.shape[0] - 1) * depth.shape[1]
        for across in (-1, 0, 1):
            here = near + np.clip(column + across, 0, depth.shape[1] - 1)
            np.minimum(least, depth.ravel()[here], out=least)
    return least
