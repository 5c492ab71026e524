"""Borders of polygons with as few edges as they have sides.

Triangles that lie in one plane are merged into polygons, whose borders keep every vertex of the
mesh: a flat wall of a finely cut model has hundreds along each side. A search measures each edge.
"""

from __future__ import annotations

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.environment import Environment

__all__ = ["STRAIGHT", "straightened"]

STRAIGHT = 1e-12
"""How far [m] a vertex that is left out may lie off the side that it is on: less than distances
are computed to."""


def straightened(environment: Environment) -> tuple[Floats, Ints]:
    """Join the edges of each polygon that lie in one line.

    Parameters
    ----------
    environment
        Its F polygons.

    Returns
    -------
    tuple
        Ends (E, 2, 3) [m] of the sides, tail and head, polygon by polygon; and where those of each
        polygon begin (F + 1,).
    """
    ends = environment.vertices[environment.edges]
    polygon = np.repeat(np.arange(len(environment.edge_start) - 1), np.diff(environment.edge_start))
    after = _edge_after(environment.edges, polygon)
    goes_on = _in_line(ends, after)
    while True:
        first, last, run = _runs(after, goes_on)
        bent = _off(ends, first, last, run) > STRAIGHT
        if not np.any(bent & goes_on):
            break
        goes_on &= ~np.isin(run, np.unique(run[bent & goes_on]))
    sides = np.stack([ends[first, 0], ends[last, 1]], axis=1)
    count = np.bincount(polygon[first], minlength=len(environment.edge_start) - 1)
    return sides, np.concatenate([[0], np.cumsum(count)])


def _edge_after(edges: Ints, polygon: Ints) -> Ints:
    """(E,) the edge of the same polygon that begins where each edge ends; -1 where not one does."""
    most = int(edges.max(initial=0)) + 1
    tail = polygon * most + edges[:, 0]
    order = np.argsort(tail, kind="stable")
    head = polygon * most + edges[:, 1]
    low, high = (np.searchsorted(tail[order], head, side=side) for side in ("left", "right"))
    after: Ints = np.where(high - low == 1, order[np.minimum(low, len(order) - 1)], -1)
    return after


def _in_line(ends: Floats, after: Ints) -> Bools:
    """(E,) whether each edge and the one after it point the same way."""
    way = ends[:, 1] - ends[:, 0]
    on = way[after]
    both = np.linalg.norm(way + on, axis=1)
    aside = np.linalg.norm(np.cross(way, on), axis=1)
    straight = aside <= STRAIGHT * np.maximum(both, 1e-300)
    return np.asarray((after >= 0) & straight & (np.einsum("ec,ec->e", way, on) > 0.0))


def _runs(after: Ints, goes_on: Bools) -> tuple[Ints, Ints, Ints]:
    """The first and the last edge (R,) of each run of edges in one line, and the run (E,) of each
    edge. No run goes all around: a polygon has corners."""
    begins = np.ones(len(after), dtype=np.bool_)
    begins[after[goes_on]] = False
    first = np.flatnonzero(begins)
    run = np.full(len(after), -1)
    run[first] = np.arange(len(first))
    last = first.copy()
    on = np.flatnonzero(goes_on[last])
    while len(on):
        last[on] = after[last[on]]
        run[last[on]] = on
        on = on[goes_on[last[on]]]
    return first, last, run


def _off(ends: Floats, first: Ints, last: Ints, run: Ints) -> Floats:
    """(E,) [m] how far the head of each edge lies off the line from the tail of its run's first edge
    to the head of its last."""
    start = ends[first, 0][run]
    way = ends[last, 1][run] - start
    arm = ends[:, 1] - start
    long = np.maximum(np.linalg.norm(way, axis=1), 1e-300)
    off: Floats = np.linalg.norm(np.cross(way, arm), axis=1) / long
    return off
