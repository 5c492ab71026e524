"""Find the lines that draw an environment, and the visible pieces of them.

Three kinds of edges are drawn:

- feature edges: open edges of a part, and edges between polygons that meet at more than
  `FEATURE_ANGLE`;
- silhouettes: edges between a polygon that faces the viewer and one that does not;
- section edges: where the near plane of the view cuts a triangle.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.draw.camera import (
    TO_VIEWER,
    Camera,
    facing,
    projective_depth,
    to_view,
    view_to_pixels,
)
from workbench.draw.visibility import DepthBuffers, triangle_polygons, triangles_shown
from workbench.geometry.box_pairs import in_ranges
from workbench.geometry.clipping import clip_segments, plane_intersections
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = [
    "FEATURE_ANGLE",
    "Lines",
    "SurfaceLayers",
    "drawn_edges",
    "edge_pieces",
    "feature_edges",
    "paint_lines",
    "visible_lines",
]

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


# Sample which pieces of straight edges are visible against depth buffers, and paint them.
#
# Pictures of pixels ask their own depth buffers, so that an edge ends at the very pixels at which the
# picture shows something nearer: in perspective those of the paper's circles too, which are not the
# true outlines. Vector pictures cut lines exactly, see `lines.occlusion`.

_HIDDEN = 0
_FAINT = 1
_PLAIN = 2


class SurfaceLayers(NamedTuple):
    """What can hide an edge, (height, width) each, and its limits."""

    depth: Floats
    """Depth [m] of the foremost opaque surface."""
    sphere: NDArray[np.int32]
    """Index of the foremost sphere, -1 for none."""
    body_depth: Floats
    """Depth [m] of the spheres."""
    bias: float
    """Depth [m] by which a surface must be nearer to hide an edge."""
    cut: float
    """Depth [m] of the near plane."""


def _visibility(points: Floats, clear: Bools, layers: SurfaceLayers) -> Ints:
    """Return _HIDDEN, _FAINT or _PLAIN (K,) for points (K, 3) of edges: x, y [pixels], depth [m]."""
    height, width = layers.depth.shape
    x, y, depth = points.T
    state = np.full(len(points), _HIDDEN)
    shown = (x >= 0.0) & (x < width) & (y >= 0.0) & (y < height)
    at = np.flatnonzero(shown & (depth <= layers.cut + layers.bias))
    row = np.floor(y[at]).astype(np.int64)
    column = np.floor(x[at]).astype(np.int64)
    before_body = layers.sphere[row, column] >= 0
    state[at] = np.where(before_body | clear[at], _FAINT, _PLAIN)
    state[at[before_body & (depth[at] < layers.body_depth[row, column])]] = _HIDDEN
    # behind the surfaces of the pixel and of its eight neighbours: none hides its own edge
    surface = layers.depth.ravel()
    lines = [width * np.clip(row + down, 0, height - 1) for down in (0, -1, 1)]
    places = [np.clip(column + across, 0, width - 1) for across in (0, -1, 1)]
    least = depth[at] + layers.bias
    behind = np.arange(len(at))
    for line, place in product(lines, places):
        behind = behind[least[behind] < surface[line[behind] + place[behind]]]
    state[at[behind]] = _HIDDEN
    return state


def _shares_inside(edges: Floats, width: int, height: int) -> tuple[Floats, Floats]:
    """Return between which shares (M,) of their lengths edges lie in the picture, or farther."""
    start = edges[:, 0, :2]
    along = edges[:, 1, :2] - start
    is_level = along == 0.0
    divisor = np.where(is_level, 1.0, along)
    one = np.where(is_level, 0.0, -start / divisor)
    other = np.where(is_level, 1.0, ([width, height] - start) / divisor)
    low = np.minimum(one, other).max(axis=1)
    high = np.maximum(one, other).min(axis=1)
    return np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0)


def edge_pieces(
    edges: Floats, clear: Bools, layers: SurfaceLayers, step: float, inverse_distance: float
) -> Floats:
    """Find the visible pieces of edges, tested at both ends and every `step` [pixels] or closer.

    Parameters
    ----------
    edges
        (M, 2, 3) ends as x, y [pixels] and projective depth.
    clear
        (M,) whether the part is see-through.
    layers
        What can hide them.
    step
        Largest distance [pixels] of the points that are tested. A piece of one point is dropped.
    inverse_distance
        Of the camera [1/m].

    Returns
    -------
    Floats
        (K, 6) from x, y to x, y [pixels], mean depth [m], and 1 for a faint piece.
    """
    height, width = layers.depth.shape
    length = np.hypot(*(edges[:, 1, :2] - edges[:, 0, :2]).T)
    steps = np.ceil(length / step) + 1.0
    low, high = _shares_inside(edges, width, height)
    first = np.maximum(np.floor(low * steps) - 1.0, 0.0).astype(np.int64)
    last = np.minimum(np.ceil(high * steps) + 1.0, steps).astype(np.int64)
    number, edge = in_ranges(first, np.maximum(last + 1, first))
    share = (number / steps[edge])[:, None]
    points = edges[edge, 0] * (1.0 - share) + edges[edge, 1] * share
    points[:, 2] /= 1.0 + points[:, 2] * inverse_distance
    state = _visibility(points, clear[edge], layers)
    is_new = (np.diff(edge, prepend=-1) != 0) | (np.diff(state, prepend=-1) != 0)
    begin = np.flatnonzero(is_new)
    end = np.append(begin[1:], len(state))[: len(begin)] - 1
    kept = (state[begin] != _HIDDEN) & (end > begin)
    begin = begin[kept]
    end = end[kept]
    depth = (points[begin, 2] + points[end, 2]) / 2.0
    return np.column_stack(
        [points[begin, :2], points[end, :2], depth, (state[begin] == _FAINT).astype(np.float64)]
    )


def paint_lines(
    ends: Floats, opacity: NDArray[np.uint8], width: float, mask: NDArray[np.uint8]
) -> None:
    """Paint lines into a mask in turn, later ones over earlier ones.

    A line takes the pixels whose middles lie less than half its width from it. In every column, or
    row if it is steep, it takes at least the pixel that it goes through. Ends are cut across the
    axes of the picture.

    Parameters
    ----------
    ends
        (M, 4) from x, y to x, y [pixels].
    opacity
        (M,) value of the pixels.
    width
        Width of the lines [pixels].
    mask
        (height, width) filled in place.
    """
    height, across = mask.shape
    is_steep = np.abs(ends[:, 3] - ends[:, 1]) > np.abs(ends[:, 2] - ends[:, 0])
    # u runs along the axis that a line is nearest to, v across it
    lines = np.where(is_steep[:, None], ends[:, [1, 0, 3, 2]], ends)
    is_turned = lines[:, 0] > lines[:, 2]
    u0, v0, u1, v1 = np.where(is_turned[:, None], lines[:, [2, 3, 0, 1]], lines).T
    slope = np.where(u1 > u0, (v1 - v0) / np.where(u1 > u0, u1 - u0, 1.0), 0.0)
    half = 0.5 * width * np.sqrt(1.0 + slope * slope) if width > 1.0 else np.zeros(len(ends))
    u_size = np.array([across, height])[is_steep.astype(np.int64)]
    v_size = across + height - u_size
    first = np.maximum(np.floor(u0), 0).astype(np.int64)
    last = np.minimum(np.floor(u1), u_size - 1).astype(np.int64)
    u, line = in_ranges(first, np.maximum(last + 1, first))
    v = v0[line] + slope[line] * (np.clip(u + 0.5, u0[line], u1[line]) - u0[line])
    low = np.ceil(v - half[line] - 0.5)
    high = np.floor(v + half[line] - 0.5)
    is_thin = (high < low) | (half[line] == 0.0)
    low = np.maximum(np.where(is_thin, np.floor(v), low), 0).astype(np.int64)
    high = np.where(is_thin, np.floor(v), high)
    high = np.minimum(high, v_size[line] - 1).astype(np.int64)
    pixel, owner = in_ranges(low, np.maximum(high + 1, low))
    stride = np.where(is_steep, across, 1).astype(np.int64)
    begin = stride[line] * u
    side = across + 1 - stride[line]
    place = begin[owner] + side[owner] * pixel
    newest = np.full(mask.size, -1, dtype=np.int32)
    np.maximum.at(newest, place, line.astype(np.int32)[owner])
    painted = np.flatnonzero(newest >= 0)
    mask.flat[painted] = opacity[newest[painted]]
