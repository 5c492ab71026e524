"""The lines that draw an environment: feature edges, silhouettes, cut edges; and what of them is
visible.

A feature edge is an open edge of a part, or one between two polygons that meet at more than
FEATURE_ANGLE. A silhouette is an edge between a polygon that faces the viewer and one that does
not. A cut edge is where the cutting plane of the view goes through a triangle.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import Camera, facing, projective_depth, to_view, view_to_pixels
from workbench.draw.clipping import clip_segments, plane_intersections
from workbench.draw.kernels.edge_lines import edge_pieces
from workbench.draw.visibility import DepthBuffers, triangle_polygons
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = ["FEATURE_ANGLE", "Lines", "drawn_edges", "visible_lines"]

FEATURE_ANGLE = np.radians(25.0)
_WELD = (
    1e-5  # [m] corners nearer than about this are one: some mesh files hold a copy for each face
)
_STEP = 2.0  # [pixels] between the points at which an edge is tested
_BIAS = 1e-3  # [m] an edge lies on its own surface: so much in front counts as visible


class Lines(NamedTuple):
    """Visible pieces of edges: ends (M, 2, 2) x, y [pixels]; depth (M,) [m]; faint (M,): seen
    through or as a veil."""

    ends: Floats
    depth: Floats
    faint: Bools


class _Sides(NamedTuple):
    """Undirected edges of parts that are shown: corners (M, 2) vertices; clear (M,): of a
    see-through part.

    first, second (M,): the polygons on both sides; sense (M,): 1 where they are wound alike, -1
    where not, 0 where there are not two; always (M,): drawn from wherever it is seen, as an open or
    sharp edge.
    """

    corners: Ints
    clear: Bools
    first: Ints
    second: Ints
    sense: Floats
    always: Bools


def drawn_edges(
    environment: Environment, camera: Camera, cut: float, *, seen: Floats | None = None
) -> tuple[Floats, Bools]:
    """Edges (M, 2, 3) x, y [pixels], depth [m] to be drawn in this view, and whether each is of a
    see-through part.

    cut [m]: the depth of the cutting plane. Edges are cut where they come too near the eye. seen
    (V, 3): the environment's vertices in view coordinates, where they are known already.
    """
    sides = _sides(environment)
    front = facing(camera, environment.normal, environment.offset)
    turned = front[sides.first] * front[sides.second] * sides.sense < 0.0
    wanted = np.flatnonzero(sides.always | turned)
    ahead = np.array([0.0, 0.0, 1.0])
    points = to_view(camera, environment.vertices) if seen is None else seen
    edges, kept = clip_segments(points[sides.corners[wanted]], ahead, camera.closest)
    clear = sides.clear[wanted[kept]]
    if np.isfinite(cut):
        part = environment.polygon_part[triangle_polygons(environment)]
        shown = np.flatnonzero(~environment.hidden[part])
        cut_edges, of = plane_intersections(points[environment.triangles[shown]], ahead, cut)
        edges = np.concatenate([edges, cut_edges])
        clear = np.append(clear, environment.see_through[part[shown[of]]])
    return view_to_pixels(camera, edges), clear


@lru_cache(maxsize=8)
def _sides(environment: Environment) -> _Sides:
    """Pair the polygons' directed edges within each part; remembered, for it is the same in every
    view."""
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
    against = (
        ends[first, 0] == ends[second, 1]
    )  # two neighbours of one winding run along their edge in two directions
    lone = members != 2
    sense = np.where(lone, 0.0, np.where(against, 1.0, -1.0))
    one = environment.normal[polygon[first]]
    other = environment.normal[polygon[second]] * sense[:, None]
    sharp = lone | (np.sum(one * other, axis=1) < np.cos(FEATURE_ANGLE))
    level = (environment.normal[polygon[first]] == environment.normal[polygon[second]]).all(
        axis=1
    ) & (sense > 0.0)
    level &= (
        environment.offset[polygon[first]] == environment.offset[polygon[second]]
    )  # these face one way together
    shown = np.flatnonzero(~environment.hidden[part[first]] & (sharp | ~level))
    clear = environment.see_through[part[first]]
    columns = (environment.edges[first], clear, polygon[first], polygon[second], sense, sharp)
    return _Sides(*(column[shown] for column in columns))


def visible_lines(edges: Floats, clear: Bools, layers: DepthBuffers) -> Lines:
    """The pieces of edges (M, 2, 3) that no opaque surface hides, tested every two pixels or
    closer.

    A piece is faint where it is of a see-through part or in front of a body, and is left out behind
    a body.
    """
    height, width = layers.depth.shape
    low = edges[:, :, :2].min(axis=1)
    high = edges[:, :, :2].max(axis=1)
    inside = np.all((high >= 0) & (low <= (width, height)), axis=1) & (
        edges[:, :, 2].min(axis=1) <= layers.cut + _BIAS
    )
    edges = edges[inside]
    camera = layers.camera
    edges = np.concatenate([edges[:, :, :2], projective_depth(camera, edges[:, :, 2:])], axis=2)
    seen = (layers.depth, layers.sphere, layers.body_depth)
    limits = np.array([_BIAS, layers.cut])
    pieces = edge_pieces(edges, clear[inside], seen, limits, _STEP, camera.inverse_distance)
    return Lines(pieces[:, :4].reshape(-1, 2, 2), pieces[:, 4], pieces[:, 5] == 1.0)
