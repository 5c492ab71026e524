"""Sample which pieces of straight edges are visible against depth buffers, and paint them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.compiled import njit
from workbench.draw.kernels.occlusion import with_room
from workbench.model.arrays import Floats, Ints

__all__ = ["SurfaceLayers", "edge_pieces", "paint_lines"]


@njit(cache=True)
def _hidden(row: int, column: int, depth: float, surface: Floats, bias: float) -> bool:
    """Return whether the surfaces of a pixel and of its eight neighbours are all nearer.

    With the neighbours, no surface hides its own edge.
    """
    height, width = surface.shape
    least = depth + bias
    if least >= surface[row, column]:  # most often
        return False
    for down in range(-1, 2):
        line = min(max(row + down, 0), height - 1)
        for across in range(-1, 2):
            if least >= surface[line, min(max(column + across, 0), width - 1)]:
                return False
    return True


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


HIDDEN = 0
FAINT = 1
PLAIN = 2


@njit(cache=True)
def _visibility(x: float, y: float, depth: float, clear: bool, layers: SurfaceLayers) -> int:
    """Return HIDDEN, FAINT or PLAIN for a point x, y [pixels] of an edge."""
    height, width = layers.depth.shape
    if not (0.0 <= x < width and 0.0 <= y < height and depth <= layers.cut + layers.bias):
        return HIDDEN
    row = math.floor(y)
    column = math.floor(x)
    before_body = layers.sphere[row, column] >= 0
    if before_body and depth < layers.body_depth[row, column]:
        return HIDDEN
    if _hidden(row, column, depth, layers.depth, layers.bias):
        return HIDDEN
    return FAINT if before_body or clear else PLAIN


@njit(cache=True)
def edge_pieces(
    edges: Floats, clear: Ints, layers: SurfaceLayers, step: float, inverse_distance: float
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
    pieces = np.empty((2 * len(edges) + 64, 6))
    found = 0
    for i in range(len(edges)):
        dx = edges[i, 1, 0] - edges[i, 0, 0]
        dy = edges[i, 1, 1] - edges[i, 0, 1]
        count = math.ceil(math.sqrt(dx * dx + dy * dy) / step) + 2
        pieces = with_room(pieces, found + count + 1)
        last_state = -1
        first_depth = 0.0
        length = 0
        for k in range(count):
            share = k / (count - 1)
            x = edges[i, 0, 0] * (1.0 - share) + edges[i, 1, 0] * share
            y = edges[i, 0, 1] * (1.0 - share) + edges[i, 1, 1] * share
            depth = edges[i, 0, 2] * (1.0 - share) + edges[i, 1, 2] * share
            depth = depth / (1.0 + depth * inverse_distance)
            state = _visibility(x, y, depth, clear[i], layers)
            if state != last_state:
                found += last_state > HIDDEN and length > 1
                pieces[found, 0] = x
                pieces[found, 1] = y
                pieces[found, 5] = 1.0 if state == FAINT else 0.0
                first_depth = depth
                length = 0
            last_state = state
            length = length + 1
            pieces[found, 2] = x
            pieces[found, 3] = y
            pieces[found, 4] = (first_depth + depth) / 2.0
        found += last_state > HIDDEN and length > 1
    return pieces[:found]


class _Stroke(NamedTuple):
    """A line to be painted: u runs along the axis that it is nearest to, v across it [pixels]."""

    is_steep: bool
    """Whether u runs down the picture."""
    u0: float
    v0: float
    u1: float
    """Not less than u0."""
    slope: float
    half: float
    """Half the extent of the line along v; 0 for a line one pixel wide."""


@njit(cache=True)
def _stroke(ends: Floats, n: int, width: float) -> _Stroke:
    """Prepare line n of ends (M, 4) [pixels]."""
    is_steep = abs(ends[n, 3] - ends[n, 1]) > abs(ends[n, 2] - ends[n, 0])
    along = 1 if is_steep else 0
    start = 0 if ends[n, along] <= ends[n, 2 + along] else 2
    u0 = ends[n, start + along]
    v0 = ends[n, start + 1 - along]
    u1 = ends[n, 2 - start + along]
    v1 = ends[n, 3 - start - along]
    slope = (v1 - v0) / (u1 - u0) if u1 > u0 else 0.0
    half = 0.5 * width * math.sqrt(1.0 + slope * slope) if width > 1.0 else 0.0
    return _Stroke(is_steep, u0, v0, u1, slope, half)


@njit(cache=True)
def _extent_across(stroke: _Stroke, u: int) -> tuple[int, int]:
    """Return the first and last pixel along v that a line takes at u: one at least."""
    v = stroke.v0 + stroke.slope * (min(max(u + 0.5, stroke.u0), stroke.u1) - stroke.u0)
    first = math.ceil(v - stroke.half - 0.5)
    last = math.floor(v + stroke.half - 0.5)
    if last < first or stroke.half == 0.0:
        return math.floor(v), math.floor(v)
    return first, last


@njit(cache=True)
def paint_lines(ends: Floats, opacity: Ints, width: float, mask: Ints) -> None:
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
    for n in range(len(ends)):
        stroke = _stroke(ends, n, width)
        u_size, v_size = (height, across) if stroke.is_steep else (across, height)
        first_u = max(math.floor(stroke.u0), 0)
        last_u = min(math.floor(stroke.u1), u_size - 1)
        for u in range(first_u, last_u + 1):
            first, last = _extent_across(stroke, u)
            for v in range(max(first, 0), min(last, v_size - 1) + 1):
                if stroke.is_steep:
                    mask[u, v] = opacity[n]
                else:
                    mask[v, u] = opacity[n]
