"""Straight edges in a picture of pixels: what of each shows, sampled against its layers; and their
painting."""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import njit
from workbench.model.arrays import Floats, Ints

__all__ = ["edge_pieces", "paint_lines"]


@njit(cache=True)
def _hidden(row: int, column: int, depth: float, surface: Floats, bias: float) -> bool:
    """Whether the surfaces of a pixel and its eight neighbours are all nearer: no surface hides its
    own edge."""
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


@njit(cache=True)
def _state(
    x: float,
    y: float,
    depth: float,
    clear: bool,
    layers: tuple[Floats, Ints, Floats],
    limits: Floats,
) -> int:
    """0 hidden, 1 faint, 2 plain, at a point x, y [pixels]. limits (2,): bias [m] and the depth of
    the cut."""
    surface, sphere, body_depth = layers
    height, width = surface.shape
    if not (0.0 <= x < width and 0.0 <= y < height and depth <= limits[1] + limits[0]):
        return 0
    row = math.floor(y)
    column = math.floor(x)
    body = sphere[row, column] >= 0
    if (body and depth < body_depth[row, column]) or _hidden(
        row, column, depth, surface, limits[0]
    ):
        return 0
    return 1 if body or clear else 2


@njit(cache=True)
def edge_pieces(
    edges: Floats,
    clear: Ints,
    layers: tuple[Floats, Ints, Floats],
    limits: Floats,
    step: float,
    bend: float,
) -> Floats:
    """Pieces (K, 6): from x, y to x, y [pixels], depth [m], 1 where faint, of edges (M, 2, 3) x, y,
    projective depth.

    clear (M,): of see-through parts. layers: depth of the foremost surface, sphere or -1, its
    depth, (height, width) each. limits (2,): see _state. Tested at both ends and every `step`
    [pixels] or closer; a piece of one point is none.
    """
    pieces = np.empty((2 * len(edges) + 64, 6))
    found = 0
    for i in range(len(edges)):
        dx = edges[i, 1, 0] - edges[i, 0, 0]
        dy = edges[i, 1, 1] - edges[i, 0, 1]
        count = math.ceil(math.sqrt(dx * dx + dy * dy) / step) + 2
        if found + count + 1 > len(pieces):
            larger = np.empty((2 * len(pieces) + count, 6))
            for piece in range(found):
                for part in range(6):
                    larger[piece, part] = pieces[piece, part]
            pieces = larger
        before = -1
        first = 0.0
        length = 0
        for k in range(count):
            share = k / (count - 1)
            x = edges[i, 0, 0] * (1.0 - share) + edges[i, 1, 0] * share
            y = edges[i, 0, 1] * (1.0 - share) + edges[i, 1, 1] * share
            depth = edges[i, 0, 2] * (1.0 - share) + edges[i, 1, 2] * share
            depth = depth / (1.0 + depth * bend)
            state = _state(x, y, depth, clear[i], layers, limits)
            if state != before:
                found += before > 0 and length > 1
                pieces[found, 0] = x
                pieces[found, 1] = y
                pieces[found, 5] = 1.0 if state == 1 else 0.0
                first = depth
                length = 0
            before = state
            length = length + 1
            pieces[found, 2] = x
            pieces[found, 3] = y
            pieces[found, 4] = (first + depth) / 2.0
        found += before > 0 and length > 1
    return pieces[:found]


@njit(cache=True)
def paint_lines(ends: Floats, opacity: Ints, width: float, mask: Ints) -> None:
    """Lines (M, 4) from x, y to x, y [pixels], `width` wide, into `mask` (height, width) in turn,
    later ones over.

    A line takes the pixels whose middles lie less than half its width off, and in every column, or
    row where it is steep, the one that it goes through. Ends are cut across the picture's axes.
    """
    height, across = mask.shape
    for n in range(len(ends)):
        x0 = ends[n, 0]
        y0 = ends[n, 1]
        x1 = ends[n, 2]
        y1 = ends[n, 3]
        steep = abs(y1 - y0) > abs(x1 - x0)
        if steep:
            x0, y0, x1, y1 = y0, x0, y1, x1
        if x0 > x1:
            x0, y0, x1, y1 = x1, y1, x0, y0
        slope = (y1 - y0) / (x1 - x0) if x1 > x0 else 0.0
        half = 0.5 * width * math.sqrt(1.0 + slope * slope) if width > 1.0 else 0.0
        most, least = (height, across) if steep else (across, height)
        for u in range(max(math.floor(x0), 0), min(math.floor(x1), most - 1) + 1):
            v = y0 + slope * (min(max(u + 0.5, x0), x1) - x0)
            first = math.ceil(v - half - 0.5)
            last = math.floor(v + half - 0.5)
            if last < first or half == 0.0:
                first = last = math.floor(v)
            for w in range(max(first, 0), min(last, least - 1) + 1):
                if steep:
                    mask[u, w] = opacity[n]
                else:
                    mask[w, u] = opacity[n]
