"""The lines that draw an environment: feature edges, silhouettes, cut edges; and what of them is visible.

A feature edge is an open edge of a part, or one between two polygons that meet at more than FEATURE_ANGLE. A
silhouette is an edge between a polygon that faces the viewer and one that does not. A cut edge is where the cutting
plane of the view goes through a triangle.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, project
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
    """Undirected edges: corners (M, 2) vertices, part (M,), normal of a first and a second side (M, 3), open (M,)."""

    corners: Ints
    part: Ints
    first: Floats
    second: Floats
    open: Bools


def drawn_edges(environment: Environment, camera: Camera, cut: float) -> tuple[Floats, Bools]:
    """Edges (M, 2, 3) x, y [pixels], depth [m] to be drawn in this view, and whether each is of a see-through part."""
    sides = _sides(environment)
    sharp = np.sum(sides.first * sides.second, axis=1) < np.cos(FEATURE_ANGLE)
    turned = (sides.first @ camera.toward) * (sides.second @ camera.toward) < 0
    wanted = (sides.open | sharp | turned) & ~environment.hidden[sides.part]
    points = project(camera, environment.vertices)
    edges, clear = points[sides.corners[wanted]], environment.see_through[sides.part[wanted]]
    cut_edges, cut_clear = _cut_edges(environment, points, cut)
    return np.concatenate([edges, cut_edges]), np.concatenate([clear, cut_clear])


def _sides(environment: Environment) -> _Sides:
    """Pair the polygons' directed edges within each part; a second normal is turned where the windings disagree."""
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
    normal = environment.normal[polygon[second]] * np.where(against, 1.0, -1.0)[:, None]
    lone = members != 2
    normal[lone] = environment.normal[polygon[first[lone]]]
    return _Sides(environment.edges[first], part[first], environment.normal[polygon[first]], normal, lone)


def _cut_edges(environment: Environment, points: Floats, cut: float) -> tuple[Floats, Bools]:
    """Where the plane at depth `cut` [m] crosses triangles: (M, 2, 3) as drawn_edges gives them."""
    part = environment.polygon_part[triangle_polygons(environment)]
    near = points[environment.triangles][:, :, 2] > cut
    crossed = np.flatnonzero((near.sum(axis=1) % 3 > 0) & ~environment.hidden[part])
    corners, near = points[environment.triangles[crossed]], near[crossed]
    odd = np.argmax(near == (near.sum(axis=1) == 1)[:, None], axis=1)  # the corner that is alone on its side
    row = np.arange(len(crossed))
    apex = corners[row, odd]
    ends = []
    for step in (1, 2):
        other = corners[row, (odd + step) % 3]
        share = (cut - apex[:, 2]) / (other[:, 2] - apex[:, 2])
        ends.append(apex + share[:, None] * (other - apex))
    return np.stack(ends, axis=1).reshape(-1, 2, 3), environment.see_through[part[crossed]]


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
    points = edges[edge, 0] * (1.0 - share) + edges[edge, 1] * share
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
