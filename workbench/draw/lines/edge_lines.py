"""Sample which pieces of straight edges are visible against depth buffers, and paint them.

Pictures of pixels ask their own depth buffers, so that an edge ends at the very pixels at which the
picture shows something nearer: in perspective those of the paper's circles too, which are not the
true outlines. Vector pictures cut lines exactly, see `lines.occlusion`.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.geometry.box_pairs import in_ranges
from workbench.model.arrays import Bools, Floats, Ints

__all__ = ["SurfaceLayers", "edge_pieces", "paint_lines"]

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
