"""Connected components of a graph."""

from __future__ import annotations

import numpy as np

from workbench.compiled import inlined, njit
from workbench.model.arrays import Ints

__all__ = ["component_labels"]


@inlined
def _first_of(parent, node):  # type: ignore[no-untyped-def]
    """The first node of the component of a node, with the ways there halved."""
    while parent[node] != node:
        parent[node] = parent[parent[node]]
        node = parent[node]
    return node


@njit(cache=True)
def _join(one, other, parent):  # type: ignore[no-untyped-def]
    """Join the ends of all edges, the later component to the earlier; parent (count,) in place."""
    for i in range(len(one)):
        a = _first_of(parent, one[i])
        b = _first_of(parent, other[i])
        parent[max(a, b)] = min(a, b)
    for node in range(len(parent)):
        parent[node] = parent[parent[node]]  # the parent is earlier, so it is a first node by now


def component_labels(one: Ints, other: Ints, count: int) -> Ints:
    """Number the connected components of a graph, in the order of their first nodes.

    Parameters
    ----------
    one, other
        (N,) the ends of the edges.
    count
        Number of nodes.

    Returns
    -------
    Ints
        (count,) the component of each node, from 0.
    """
    parent = np.arange(count)
    _join(one.astype(np.int64), other.astype(np.int64), parent)
    return np.unique(parent, return_inverse=True)[1].reshape(-1)
