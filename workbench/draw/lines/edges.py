"""Find the lines that draw an environment, and the visible pieces of them.

Three kinds of edges are drawn:

- feature edges: open edges of a part, and edges between polygons that meet at more than
  `FEATURE_ANGLE`;
- silhouettes: edges between a polygon that faces the viewer and one that does not;
- section edges: where the near plane of the view cuts a triangle.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from workbench.draw.camera import (
    TO_VIEWER,
    Camera,
    facing,
    projective_depth,
    to_view,
    view_to_pixels,
)
from workbench.draw.lines.edge_lines import SurfaceLayers, edge_pieces
from workbench.draw.visibility import DepthBuffers, triangle_polygons, triangles_shown
from workbench.geometry.clipping import clip_segments, plane_intersections
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = ["FEATURE_ANGLE", "Lines", "drawn_edges", "feature_edges", "visible_lines"]

FEATURE_ANGLE = np.radians(25.0)
"""Angle [rad] between two polygons from which their common edge is sharp."""
_WELD_DISTANCE = 1e-5
"""Spacing [m] of the grid to which corners are rounded; corners in one cell are one. Some mesh
files hold a copy of a corner for each face."""
_SAMPLE_STEP = 2.0
"""Distance [pixels] between the points at which an edge is tested."""
_DEPTH_BIAS = 1e-3
"""Depth [m] by which an edge may lie behind a surface and still count as visible, since it lies on
the surface of its own polygons."""


class Lines(NamedTuple):
    """Visible pieces of edges."""

    ends: Floats
    """(M, 2, 2) x, y [pixels]."""
    depth: Floats
    """(M,) [m]."""
    faint: Bools
    """(M,) whether it belongs to a see-through part or lies in front of a body."""


class _EdgeTopology(NamedTuple):
    """Undirected edges of shown parts, with the polygons on both sides."""

    corners: Ints
    """(M, 2) vertices."""
    see_through: Bools
    """(M,) whether the part is see-through."""
    first: Ints
    """(M,) polygon on one side."""
    second: Ints
    """(M,) polygon on the other side."""
    sense: Floats
    """(M,) 1 for polygons of the same winding, -1 for opposite ones, 0 unless there are two."""
    sharp: Bools
    """(M,) whether it is an open or a sharp edge, drawn wherever it is visible."""


def drawn_edges(
    environment: Environment, camera: Camera, cut: float, *, seen: Floats | None = None
) -> tuple[Floats, Bools]:
    """Return the edges to be drawn in a view. They are clipped where they come too near the eye.

    Parameters
    ----------
    environment, camera
        What is seen, and from where.
    cut
        Depth [m] of the near plane.
    seen
        (V, 3) view coordinates of the vertices, if they are known already.

    Returns
    -------
    tuple[Floats, Bools]
        Ends (M, 2, 3) as x, y [pixels] and depth [m], and whether (M,) the part is see-through.
    """
    edges = _edge_topology(environment)
    front = facing(camera, environment.normal, environment.offset)
    silhouette = front[edges.first] * front[edges.second] * edges.sense < 0.0
    chosen = np.flatnonzero(edges.sharp | silhouette)
    points = to_view(camera, environment.vertices) if seen is None else seen
    ends, kept = clip_segments(points[edges.corners[chosen]], TO_VIEWER, camera.closest)
    see_through = edges.see_through[chosen[kept]]
    if np.isfinite(cut):
        shown = triangles_shown(environment)
        section, source = plane_intersections(points[environment.triangles[shown]], TO_VIEWER, cut)
        part = environment.polygon_part[triangle_polygons(environment)[shown[source]]]
        ends = np.concatenate([ends, section])
        see_through = np.append(see_through, environment.see_through[part])
    return view_to_pixels(camera, ends), see_through


def feature_edges(environment: Environment) -> tuple[Ints, Ints]:
    """Return the open and sharp edges of the parts that are not hidden.

    Returns
    -------
    tuple[Ints, Ints]
        Vertices (M, 2) of each edge, and its part (M,).
    """
    edges = _edge_topology(environment)
    part = environment.polygon_part[edges.first[edges.sharp]]
    return edges.corners[edges.sharp], part


@lru_cache(maxsize=8)
def _edge_topology(environment: Environment) -> _EdgeTopology:
    """Pair the directed edges of polygons within each part; cached, as it is the same in every
    view."""
    polygon = np.repeat(np.arange(len(environment.normal)), np.diff(environment.edge_start))
    first, second, sense = _paired_edges(environment, polygon)
    one = polygon[first]
    other = polygon[second]
    cosine = np.sum(environment.normal[one] * (environment.normal[other] * sense[:, None]), axis=1)
    sharp = (sense == 0.0) | (cosine < np.cos(FEATURE_ANGLE))
    # two polygons of one plane and winding face the viewer together, so are never a silhouette
    coplanar = (environment.normal[one] == environment.normal[other]).all(axis=1)
    coplanar &= (environment.offset[one] == environment.offset[other]) & (sense > 0.0)
    part = environment.polygon_part[one]
    shown = np.flatnonzero(~environment.hidden[part] & (sharp | ~coplanar))
    return _EdgeTopology(
        environment.edges[first][shown],
        environment.see_through[part][shown],
        one[shown],
        other[shown],
        sense[shown],
        sharp[shown],
    )


def _paired_edges(environment: Environment, polygon: Ints) -> tuple[Ints, Ints, Floats]:
    """Group the directed edges that join the same two corners of a part.

    Parameters
    ----------
    environment
        The environment.
    polygon
        (E,) polygon of each directed edge.

    Returns
    -------
    tuple[Ints, Ints, Floats]
        Of each group its first two directed edges (M,), and its sense, see `_EdgeTopology`.
    """
    grid = np.round(environment.vertices / _WELD_DISTANCE).astype(np.int64)
    count = np.int64(len(environment.vertices))
    welded = np.zeros(count, np.int64)
    for coordinate in grid.T:  # in the order of x, then y, then z; rows as a whole sort slowly
        rank = np.unique(coordinate, return_inverse=True)[1]
        welded = np.unique(welded * count + rank, return_inverse=True)[1]
    ends = welded[environment.edges]
    part = environment.polygon_part[polygon]
    key = (part * count + ends.min(axis=1)) * count + ends.max(axis=1)
    order = np.argsort(key, kind="stable")
    order = order[ends[order, 0] != ends[order, 1]]
    start = np.flatnonzero(np.diff(key[order], prepend=-1))
    members = np.diff(start, append=len(order))
    first = order[start]
    second = order[np.minimum(start + 1, max(len(order) - 1, 0))]
    # neighbours of one winding run along their common edge in opposite directions
    opposed = ends[first, 0] == ends[second, 1]
    sense = np.where(members != 2, 0.0, np.where(opposed, 1.0, -1.0))
    return first, second, sense


def visible_lines(edges: Floats, see_through: Bools, buffers: DepthBuffers) -> Lines:
    """Return the pieces of edges that no opaque surface hides, tested every two pixels or closer.

    Edges of see-through parts and in front of a body are faint. Edges behind a body are left out.

    Parameters
    ----------
    edges
        (M, 2, 3) ends as x, y [pixels] and depth [m].
    see_through
        (M,) whether the part is see-through.
    buffers
        Depth buffers of the scene.
    """
    height, width = buffers.depth.shape
    low = edges.min(axis=1)
    high = edges.max(axis=1)
    inside = np.all((high[:, :2] >= 0) & (low[:, :2] <= (width, height)), axis=1)
    inside &= low[:, 2] <= buffers.cut + _DEPTH_BIAS
    edges = edges[inside]
    camera = buffers.camera
    edges[:, :, 2] = projective_depth(camera, edges[:, :, 2])
    layers = SurfaceLayers(
        buffers.depth, buffers.sphere, buffers.body_depth, _DEPTH_BIAS, buffers.cut
    )
    pieces = edge_pieces(edges, see_through[inside], layers, _SAMPLE_STEP, camera.inverse_distance)
    return Lines(pieces[:, :4].reshape(-1, 2, 2), pieces[:, 4], pieces[:, 5] == 1.0)
